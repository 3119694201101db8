/// The six thrusters along one leg, as far as speed and acceleration along it are concerned (DESIGN.md 5). Pure
/// mathematics.
#ifndef SSV_LIMITS_H
#define SSV_LIMITS_H

#include <stdbool.h>

#include "ssv/real.h"
#include "ssv/scenario.h"

/// Thruster i along a leg with speed v and acceleration a: accel[i] a + linear[i] v + quadratic[i] v^2, |.| <=
/// force_max_N.
typedef struct {
    real_t accel[SSV_NUM_THRUSTERS], linear[SSV_NUM_THRUSTERS], quadratic[SSV_NUM_THRUSTERS];
    real_t force_max_N;
} ssv_thrusts_t;

/// Units of a leg as exponents of two: 2^length m (or rad), 2^time s, 2^speed m/s (or rad/s), 2^force N. All 0 in
/// scalars with an exponent of their own.
typedef struct {
    int length, time, speed, force;
} ssv_units_t;

/// Units in which the leg is about 1 long, the largest thrust about 1 and the peak of a short leg about 1, be it
/// inertia or price that holds it down; and the thrusts in these units, so that fixed point keeps its digits.
/// @param distance > 0.
/// @return false if no thruster acts along the leg; then *scaled is untouched.
bool ssv_thrusts_scale(const ssv_thrusts_t* thrusts, real_t weight_time_per_s, real_t weight_impulse_per_Ns,
                       real_t distance, ssv_units_t* units, ssv_thrusts_t* scaled);

/// The thrusters of a leg in groups. While a thruster idles, that is, gives no thrust, the speed follows the thruster's
/// idle curve dv/dt = linear v + quadratic v^2; while it gives all it can, dv/dt is that plus or minus its limit.
/// Thrusters with the same idle curve form one group, which has the tightest of their limits. Thrusters that hardly act
/// along the leg are passive: they limit nothing, and add to the total thrust what they need to hold drag.
typedef struct {
    int num;
    real_t weight[SSV_NUM_THRUSTERS]; ///< sum of |accel|: total thrust changes by that much per unit of dv/dt
    real_t limit[SSV_NUM_THRUSTERS], linear[SSV_NUM_THRUSTERS], quadratic[SSV_NUM_THRUSTERS];
    int num_passive;
    real_t passive_linear[SSV_NUM_THRUSTERS];    ///< thrust per speed
    real_t passive_quadratic[SSV_NUM_THRUSTERS]; ///< thrust per speed squared
    real_t total;                                ///< sum of the weights
} ssv_thruster_groups_t;

/// @return false if no thruster acts along the leg.
bool ssv_thruster_groups_of(const ssv_thrusts_t* thrusts, ssv_thruster_groups_t* groups);

/// Total thrust that holds a speed >= 0 against drag.
real_t ssv_cruise_thrust(const ssv_thrusts_t* thrusts, real_t v);

/// The speed in (0, most) at which some thruster needs all it has to hold it; `most` if there is none.
real_t ssv_terminal_speed(const ssv_thrusts_t* thrusts, real_t most);

/// Cheapest speed in (0, top_speed] to cruise at: that of the least price per distance, (weight_time + weight_impulse *
/// cruise thrust) / v, which is convex in 1 / v.
real_t ssv_cruise_speed(const ssv_thrusts_t* thrusts, real_t weight_time, real_t weight_impulse, real_t top_speed);

#endif
