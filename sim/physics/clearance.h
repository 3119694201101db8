/// Clearance: how near a flight comes to what stands around it, told apart from the contacts that its task wants.
///
/// What moves is the vehicle's hull, a sphere, and the beam once it is carried, a tube with flat ends; before, the beam
/// is one more thing in the way. Three contacts are allowed, each while the flight is as near as a last or first
/// stretch to where the contact belongs, and there no deeper than in that place by more than SIM_DEEPER_M: the vehicle
/// with its beam before it mates, the docking end with what reaches into the margin around its port before it docks,
/// and the vehicle with what it leaves. A flight that comes near and turns away again has not used its contact: then it
/// counts.
#ifndef SIM_CLEARANCE_H
#define SIM_CLEARANCE_H

#include <stdint.h>

#include "contact.h"

#define SIM_OBSTACLES 64

/// What is no obstacle of the surroundings, by numbers above theirs.
enum { SIM_NO_OBSTACLE = -1, SIM_ITS_BEAM = SIM_OBSTACLES, SIM_TANK_WALL, SIM_NUM_THINGS };

/// How much deeper than in its place an allowed contact may be [m]: as far as arrivals in rough water may be off.
#define SIM_DEEPER_M 0.04

typedef struct {
    bool is_wall;
    sim_capsule_t capsule; ///< unless it is a wall
    sim_half_space_t wall;
} sim_obstacle_t;

/// What stands around, fixed in {n}, and what a task says of it.
typedef struct {
    bool counts; ///< whether there is anything to keep clear of; else the rest is not read
    int num_obstacles;
    sim_obstacle_t obstacle[SIM_OBSTACLES];
    uint64_t chosen; ///< bit k: obstacle k counts
    uint64_t left;   ///< bit k: the vehicle stands at obstacle k and lets go of it
    sim_tank_t tank;
    double margin_m;                         ///< wanted from all of that
    double approach_mate_m, approach_dock_m; ///< the last stretches; 0: SIM_STRETCH_M
    double hull_radius_m, beam_radius_m, beam_length_m;
    rb_pose_t X_nb, X_nB; ///< vehicle and beam at the start
    sim_mate_place_t place;
    sim_port_t port;
} sim_surroundings_t;

/// A last stretch where no approach is asked for, and the first one [m].
#define SIM_STRETCH_M 0.3

/// One distance.
typedef struct {
    double least_m; ///< negative by how deep they are in one another; infinite if nothing was looked at
    double t_s;
    bool is_beam; ///< the beam that is carried, else the vehicle
    int obstacle; ///< or SIM_ITS_BEAM, SIM_TANK_WALL, SIM_NO_OBSTACLE
} sim_nearest_t;

/// Keeps watch on one flight.
typedef struct {
    sim_surroundings_t around;
    sim_nearest_t nearest; ///< so far, of all that is not allowed

    sim_nearest_t held_back; ///< of contacts that are allowed if they come to what they are for
    bool was_carried, is_leaving;
    double mating_m, leaving_m, docking_m; ///< the stretches
    double mate_n_m[3];                    ///< the vehicle's centre when it mates
    double depth_m[2]
                  [SIM_NUM_THINGS]; ///< of an allowed contact of vehicle and beam in its place; infinite: not allowed
} sim_watch_t;

void sim_watch_init(sim_watch_t* watch, const sim_surroundings_t* around);

/// Looks at the poses at one instant. @param is_carried whether the beam is; then X_nB is where it is carried.
void sim_watch_look(sim_watch_t* watch, double t_s, const rb_pose_t* X_nb, const rb_pose_t* X_nB, bool is_carried);

#endif
