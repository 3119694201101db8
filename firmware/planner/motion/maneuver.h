/// Maneuvers: motion along a constant twist of the vehicle, and its price by the question's method.
#ifndef SSV_MANEUVER_H
#define SSV_MANEUVER_H

#include "planner/model/body.h"
#include "planner/motion/question.h"
#include "planner/profile/limits.h"
#include "planner/profile/profile.h"
#include "ssv/planner.h"
#include "ssv/vec3.h"

/// Which way a leg of the plan goes. Distances are in rad for SSV_TURN, else in m.
typedef struct {
    ssv_phase_t phase;
    ssv_leg_kind_t kind;
    ssv_twist_t twist; ///< per unit of distance
    real_t length;
    real_t speed_max; ///< per unit of distance, too; 0 = as fast as it pays
} ssv_maneuver_t;

typedef struct {
    ssv_outcome_t outcome; ///< the rest is meaningful when SSV_FEASIBLE
    real_t time_s, impulse_Ns, cost;
} ssv_price_t;

/// Whether a is feasible and costs less than b, or b is not feasible.
bool ssv_price_beats(const ssv_price_t* a, const ssv_price_t* b);

/// Legs are planned as if a second cost at least as much as this many newtons: below, they take hours to save next to
/// nothing.
#define SSV_SECOND_COSTS_N REAL(1e-2)

/// The weight of time that legs are planned with; their price is that with the question's own.
real_t ssv_leg_weight_time(const ssv_question_t* question);

/// Straight flight by displacement_S [m] in axes of S, attitude held. A displacement of zero makes a maneuver of length
/// 0.
ssv_maneuver_t ssv_maneuver_translate(ssv_phase_t phase, vec3_t displacement_S);

/// Turn by angle_rad >= 0 about the unit vector axis_S through pivot_S [m].
ssv_maneuver_t ssv_maneuver_turn(ssv_phase_t phase, vec3_t axis_S, real_t angle_rad, vec3_t pivot_S);

/// The one screw, the shorter way round, that takes the vehicle from one pose to another: a translation where the
/// attitudes agree, a turn where it has no pitch.
ssv_maneuver_t ssv_maneuver_between(ssv_phase_t phase, pose_t X_IS_from, pose_t X_IS_to);

/// Sets speed_max so that the scenario's caps hold: those of the phase, and on a contact's approach that of the
/// contact. The twist is constant, so each of them is one on the speed along the maneuver.
void ssv_maneuver_limit(const ssv_scenario_t* scenario, const ssv_assembly_t* assembly, bool approaches,
                        ssv_maneuver_t* maneuver);

/// Pose of S after distance s along the twist: X_IS exp(twist s).
pose_t ssv_maneuver_pose(pose_t X_IS, ssv_twist_t twist, real_t s);

/// Cost per metre of a straight flight along the unit body direction n_S at its cheapest speed, by the vehicle's linear
/// drag alone. No straight flight along it costs less, for the vehicle alone or with a beam that feels no drag of its
/// own.
real_t ssv_metre_price(const ssv_question_t* question, vec3_t n_S);

/// Thrusts along a maneuver of this assembly (DESIGN.md 4).
void ssv_maneuver_thrusts(const ssv_problem_t* problem, const ssv_assembly_t* assembly, ssv_twist_t twist,
                          ssv_thrusts_t* thrusts);

/// Price of a maneuver: with the optimal profile, or for method paper with the cheaper of its ramps. One of length 0
/// costs nothing.
/// @return the price; where no ramp is feasible, why; then *ramp is not meaningful.
ssv_price_t ssv_maneuver_price(const ssv_question_t* question, const ssv_maneuver_t* maneuver,
                               const ssv_thrusts_t* thrusts, ssv_ramp_t* ramp);

/// The same with the profile; a maneuver of length 0 has no arcs.
ssv_price_t ssv_maneuver_solve(const ssv_question_t* question, const ssv_maneuver_t* maneuver,
                               const ssv_thrusts_t* thrusts, ssv_profile_t* profile, ssv_ramp_t* ramp);

#endif
