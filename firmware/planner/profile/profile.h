/// The speed along one leg over time, rest to rest, in closed form (DESIGN.md 5). Knows thrusts and limits, nothing of
/// bodies.
///
/// Along a leg with speed v and acceleration a, thruster i gives u_i = accel[i] a + linear[i] v + quadratic[i] v^2
/// (paper Eqs. 6, 7, 11, 15 in one), |u_i| <= force_max. A thruster that is bound to a constant thrust makes dv/dt a
/// quadratic in v. A profile is a chain of arcs, each with one such quadratic, and time, distance and impulse of an arc
/// have closed forms.
#ifndef SSV_PROFILE_H
#define SSV_PROFILE_H

#include "planner/profile/arc.h"
#include "planner/profile/limits.h"
#include "ssv/plan.h"
#include "ssv/real.h"

/// Most arcs in one profile.
#define SSV_MAX_PROFILE_ARCS 24

typedef struct {
    ssv_outcome_t outcome; ///< SSV_FEASIBLE; SSV_NO_AUTHORITY if no thruster acts along the leg or the least thrust
                           ///< does not slow the body; SSV_TOO_LONG; SSV_TOO_MANY_ARCS
    real_t duration_s, impulse_Ns, peak_speed; ///< meaningful when feasible
} ssv_profile_price_t;

typedef struct {
    real_t duration_s, impulse_Ns, peak_speed;
    int num_arcs;
    ssv_arc_t arc[SSV_MAX_PROFILE_ARCS];
} ssv_profile_t;

/// How a leg is flown.
typedef struct {
    ssv_ramp_t ramp;
    real_t cutoff; ///< [m/s or rad/s] SSV_DRAG_ONLY: speed at which it ends and full reverse begins
    real_t weight_time_per_s, weight_impulse_per_Ns; ///< SSV_OPTIMAL: W1, W2; scaled together they change nothing
    real_t speed_max;                                ///< [m/s or rad/s] cap; 0 = none
} ssv_rule_t;

/// The profile over a distance [m or rad] > 0 under a rule.
/// The paper's ramps: full thrust ahead, terminal speed as long as needed, then SSV_FULL_REVERSE brakes with full
/// thrust; SSV_DRAG_ONLY gives the least total thrust that keeps the body on the leg down to the cutoff, then brakes. A
/// leg too short for terminal speed turns from speeding up to slowing where the distance asks. SSV_OPTIMAL: the profile
/// with the least W1 T + W2 F of all (DESIGN.md 5). Without a price on time no leg would end: W1 counts as at least
/// 1e-3 N times W2 (SSV_TIME_PRICE_MIN_N in tolerance.h). *profile is meaningful only when feasible. Some 10 to 100
/// logarithms.
ssv_outcome_t ssv_profile_solve(const ssv_thrusts_t* thrusts, const ssv_rule_t* rule, real_t distance,
                                ssv_profile_t* profile);

/// Duration and impulse of that profile, to the same bits, without its arcs.
ssv_profile_price_t ssv_profile_price(const ssv_thrusts_t* thrusts, const ssv_rule_t* rule, real_t distance);

/// The same for both the paper's ramps at once, at little more than the cost of one; rule->ramp is not looked at.
void ssv_profile_price_ramps(const ssv_thrusts_t* thrusts, const ssv_rule_t* rule, real_t distance,
                             ssv_profile_price_t* full_reverse, ssv_profile_price_t* drag_only);

/// Speed of an arc at a time since its start, 0 <= t_s <= arc->duration_s.
real_t ssv_arc_speed(const ssv_arc_t* arc, real_t t_s);

/// The same by the arc's accelerations alone, from the end that says it best; at the other end, and outside the arc, it
/// is not quite what the arc says.
real_t ssv_arc_speed_free(const ssv_arc_t* arc, real_t t_s);

/// Integrals of an arc between two of its speeds that are time_s apart.
ssv_moments_t ssv_arc_moments(const ssv_arc_t* arc, real_t v_from, real_t v_to, real_t time_s);

/// Thrust of thruster i on an arc at speed v as a quadratic c[0] + c[1] v + c[2] v^2.
void ssv_arc_thrust(const ssv_thrusts_t* thrusts, const ssv_arc_t* arc, int i, real_t c[3]);

#endif
