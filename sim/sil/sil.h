/// Software in the loop: the vehicle's own controller, unchanged, on the simulated world, in virtual time. What comes
/// and goes on the link is the business of whoever drives it.
#ifndef SIM_SIL_H
#define SIM_SIL_H

#include "physics/clearance.h"
#include "physics/world.h"
#include "ssv/vehicle.h"

#define SIL_TICK_S 0.005

typedef struct {
    sim_world_config_t world;
    sim_mate_place_t place; ///< where the plan mates and docks
    sim_port_t port;
    sim_surroundings_t around; ///< nothing if it does not count
    double force_max_N;
    uint32_t boot_id;
    bool sign;
    ssv_link_signing_t signing; ///< read if `sign`
} sil_config_t;

typedef struct {
    ssv_vehicle_config_t config;
    ssv_controller_t vehicle;
    sim_world_t world;
    sim_mate_place_t place;
    sim_port_t port;
    sim_watch_t watch;           ///< over the flight, until the beam is docked
    int64_t now_us;              ///< the vehicle's clock: when the next tick is due
    ssv_vehicle_output_t output; ///< of the last tick
    int num_attempts[2];         ///< by ssv_event_kind_t
    sim_attempt_t attempt[2];    ///< the last of each
} sil_t;

/// The controller is told the thrusters' nominal curve, the dead band and the allocation, as a good bench would find
/// them, and no disturbance.
/// @return NULL, or what is wrong with the configuration.
const char* sil_init(sil_t* sil, const sil_config_t* config, uint64_t seed);

/// One tick of the controller, 5 ms of the world, a look at what it comes near, and the attempt to mate or dock if the
/// controller makes one.
void sil_step(sil_t* sil);

#endif
