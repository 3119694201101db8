/// Clearance: how far the maneuvers of a phase keep away from what stands around (DESIGN.md 13).
///
/// Along a maneuver a point that is fixed in the body moves at one speed, since the twist is constant; on a line the
/// fastest is one of its ends. So the distance to an obstacle changes by no more than that speed times the way, and
/// what is known at the middle of a stretch bounds all of it. Stretches that this does not settle are halved, each with
/// the obstacles that still matter there.
#ifndef SSV_CLEARANCE_H
#define SSV_CLEARANCE_H

#include "planner/model/body.h"
#include "planner/model/shape.h"
#include "planner/motion/maneuver.h"
#include "ssv/planner.h"

/// The search keeps this much more than the margin [m], or the rounding of a plan's poses would break it: in float,
/// some hundred metres from the origin.
#define SSV_MARGIN_ROOM_M REAL(1e-4)

/// What a clearance is asked for.
typedef struct {
    real_t enough_m;      ///< so much must be certified: where it is, no more is asked
    real_t bracket_m;     ///< how far certified_m and seen_m may be apart where it is not
    bool judges_contacts; ///< whether a contact that is allowed must be no deeper than it is where it ends, or begins;
                          ///< else it is not looked at
    int most_poses; ///< of a maneuver that are looked at; then what is left counts as it is known, never as too far
} ssv_clearance_rule_t;

/// Motion of a phase whose clearance is asked for.
typedef struct {
    const ssv_scenario_t* scenario;
    const ssv_surroundings_t* around;
    const ssv_assembly_t* assembly;
    pose_t X_IS; ///< where it begins
    int contact; ///< that docks
    const ssv_maneuver_t* maneuver;
    int num_maneuvers;
} ssv_flight_t;

/// Starts a clearance that says that nothing was looked at.
void ssv_clearance_begin(real_t seen_m, ssv_clearance_t* clearance);

/// Takes the maneuvers of a phase into a clearance; legs are numbered from first_leg on, those of length 0 left out.
void ssv_clearance_add(const ssv_flight_t* flight, const ssv_clearance_rule_t* rule, int first_leg,
                       ssv_clearance_t* clearance);

/// Whether the motion keeps the margin; if not, *clearance says where it does so least, to bracket_m. Of a contact that
/// is allowed it counts by how much it is too deep, from the margin on.
bool ssv_keeps_clear(const ssv_flight_t* flight, real_t bracket_m, ssv_clearance_t* clearance);

/// The clearance of one body at rest, over the obstacles given, into *clearance.
void ssv_clearance_at(const ssv_surroundings_t* around, const ssv_obstacles_t* obstacles, ssv_moving_t body,
                      const ssv_capsule_t* shape, ssv_clearance_t* clearance);

#endif
