/// Vehicles that are unlike the one of the models, so that what is measured by that one alone does not pass for true of
/// any: other drag, other thrusters, other sizes.
#ifndef TESTS_VEHICLES_H
#define TESTS_VEHICLES_H

#include "ssv/planner.h"

typedef enum {
    VEHICLE_OF_EASE,      ///< that of the models, with the beam as a tube,
    VEHICLE_OF_PAPER,     ///< and as the paper prints it
    VEHICLE_HEAVY,        ///< a sphere of 120 kg whose drag is quadratic alone
    VEHICLE_CANTED,       ///< six thrusters around the hull, each tilted against the next
    VEHICLE_LIKE_BLUEROV, ///< 13 kg, three thrusters in a plane and three upright, and strong for its size
    VEHICLE_LIKE_REXROV,  ///< 1.9 t with its thrusters in no symmetry but left and right
    VEHICLE_FREE_FLYER,   ///< 12 kg with no drag at all, and a beam without
    VEHICLE_SLOW_TO_TURN, ///< turning is what costs
    NUM_VEHICLES
} vehicle_kind_t;

extern const char* const vehicle_name[NUM_VEHICLES];

/// Puts the vehicle and its beam into a scenario, at a standoff at which they touch.
void set_vehicle(ssv_scenario_t* scenario, vehicle_kind_t kind);

#endif
