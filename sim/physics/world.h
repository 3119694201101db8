/// The simulated world: one vehicle, the beam that it fetches, the water, thrusters and navigation.
///
/// A step takes six commands and a length of time; the truth is in the world for all to read, measurements come out one
/// by one, and to mate and to dock are attempts that the truth decides. No heap, no globals, no input or output; the
/// same configuration, seed and calls give the same bits. All that the configuration leaves zero is ideal or absent.
#ifndef SIM_WORLD_H
#define SIM_WORLD_H

#include "contact.h"
#include "navigation.h"
#include "rigid_body.h"
#include "thruster.h"
#include "water.h"

typedef struct {
    rb_body_t vehicle, beam;
    rb_thruster_t thruster[SIM_THRUSTERS];
    rb_pose_t X_nb, X_nB; ///< vehicle and beam at the start, at rest over ground
    double substep_max_s; ///< longest step of the integration; 0: each step of the world is one

    sim_water_config_t water;
    sim_thruster_config_t thrusters;
    sim_navigation_config_t navigation;
    sim_arrival_t mate_limit, dock_limit; ///< beyond which an attempt misses
} sim_world_config_t;

typedef enum { SIM_BEAM_WAITING, SIM_BEAM_CARRIED, SIM_BEAM_DOCKED } sim_beam_t;

typedef enum { SIM_HIT, SIM_MISS, SIM_OUT_OF_TURN } sim_outcome_t;

typedef struct {
    sim_outcome_t outcome;
    double t_s;
    sim_arrival_t arrival; ///< all zero when out of turn
} sim_attempt_t;

typedef struct {
    sim_world_config_t config;

    // the truth
    double t_s;
    rb_state_t state; ///< of the vehicle, nu over ground
    sim_beam_t beam;
    rb_pose_t X_nB;
    double impulse_Ns; ///< integral of the sum of the thrusters' |force|

    rb_craft_t craft; ///< what moves
    rb_pose_t X_bB;   ///< beam in the vehicle's frame, while it is carried
    sim_water_t water;
    sim_thruster_bank_t thrusters;
    sim_navigation_t navigation;
} sim_world_t;

/// @return NULL, or what is wrong with the configuration: a path and what would be right. Then the world is unusable.
const char* sim_world_init(sim_world_t* world, const sim_world_config_t* config, uint64_t seed);

/// @param command efforts if the thrusters have a curve, else newtons; held for dt_s. A disarmed thruster is given 0.
/// @param dt_s above 0
void sim_world_step(sim_world_t* world, const double command[SIM_THRUSTERS], double dt_s);

/// Hands over the oldest measurement that has arrived, each one once. @return false if there is none.
bool sim_world_measurement(sim_world_t* world, sim_measurement_t* measurement);

/// Closes the gripper. A hit joins the beam to the vehicle as it lies, errors and all, and shares the momentum: from
/// then on the pair moves. A miss changes nothing. Out of turn unless the beam waits.
sim_attempt_t sim_world_mate(sim_world_t* world, const sim_mate_place_t* place);

/// Latches the beam into the port. A hit makes the beam part of the structure as it lies; the vehicle, stopped by the
/// latch, is let go at rest. A miss changes nothing. Out of turn unless the beam is carried.
sim_attempt_t sim_world_dock(sim_world_t* world, const sim_port_t* port);

#endif
