/// The six thrusters along one leg, as far as speed and acceleration along it are concerned (DESIGN.md 5). Pure
/// mathematics.
#ifndef SSV_LIMITS_H
#define SSV_LIMITS_H

#include "ssv/plan.h"

/// Optimal profiles count time as at least this many newtons of thrust: without a price on it no leg would end.
#define SSV_TIME_PRICE_MIN_N REAL(1e-3)

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
/// inertia or price that holds it down; and the thrusts in these units, so that fixed point keeps its digits. @return
/// false if no thruster acts along the leg.
bool ssv_thrusts_scale(const ssv_thrusts_t* thrusts, real_t weight_time_per_s, real_t weight_impulse_per_Ns,
                       real_t distance, ssv_units_t* units, ssv_thrusts_t* scaled);

/// What a thruster makes of dv/dt: idle (without its thrust) linear v + quadratic v^2, at its limit that +- limit.
/// Thrusters that idle alike count as one, with the tightest of their limits; those that hardly act along the leg hold
/// drag alone.
typedef struct {
    int num;
    real_t weight[SSV_NUM_THRUSTERS]; ///< sum of |accel|: total thrust changes by that much per unit of dv/dt
    real_t limit[SSV_NUM_THRUSTERS], linear[SSV_NUM_THRUSTERS], quadratic[SSV_NUM_THRUSTERS];
    int num_passive;
    real_t passive_linear[SSV_NUM_THRUSTERS],
        passive_quadratic[SSV_NUM_THRUSTERS]; ///< thrusts per speed and its square
    real_t total;                             ///< sum of the weights
} ssv_laws_t;

/// @return false if no thruster acts along the leg.
bool ssv_laws_of(const ssv_thrusts_t* thrusts, ssv_laws_t* laws);

/// Total thrust that holds a speed.
real_t ssv_holding_thrust(const ssv_thrusts_t* thrusts, real_t v);

/// The speed in (0, most) at which some thruster reaches its limit; `most` if none does.
real_t ssv_terminal_speed(const ssv_thrusts_t* thrusts, real_t most);

/// Cheapest speed in (0, top] to hold: the least of (weight_time + weight_impulse * holding thrust) / v, which is
/// convex in 1 / v.
real_t ssv_cruise_speed(const ssv_thrusts_t* thrusts, real_t weight_time, real_t weight_impulse, real_t top);

#endif
