/// What the optimal profile of a leg costs, without solving it: for searches that compare hundreds of legs (DESIGN.md 5).
#ifndef SSV_ESTIMATE_H
#define SSV_ESTIMATE_H

#include "ssv/planner.h"

/// Optimal profiles count time as at least this many newtons of thrust: without a price on it no leg would end.
#define SSV_TIME_PRICE_MIN_N REAL(1e-3)

/// Thruster i along a leg with speed v and acceleration a: accel[i] a + linear[i] v + quadratic[i] v^2, |.| <= force_max_N.
typedef struct {
    real_t accel[SSV_NUM_THRUSTERS], linear[SSV_NUM_THRUSTERS], quadratic[SSV_NUM_THRUSTERS];
    real_t force_max_N;
} ssv_thrusts_t;

/// Price W1 T + W2 F of the optimal profile over a distance [m or rad] > 0, to a few per cent for turns and a few per mille for
/// long flights, at some tenth of the time of ssv_profile_solve; and about the speed [m/s or rad/s] at which it peaks.
/// @return false if no thruster acts along the leg; then the outputs are untouched.
bool ssv_profile_estimate(const ssv_thrusts_t* thrusts, real_t weight_time_per_s, real_t weight_impulse_per_Ns,
                          real_t distance, real_t* price, real_t* peak_speed);

#endif
