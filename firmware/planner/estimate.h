/// What the optimal profile of a leg costs, without solving it: for searches that compare hundreds of legs (DESIGN.md 5).
#ifndef SSV_ESTIMATE_H
#define SSV_ESTIMATE_H

#include "planner/thrusts.h"

/// Price W1 T + W2 F of the optimal profile over a distance [m or rad] > 0, to a few per cent for turns and a few per mille for
/// long flights, at some tenth of the time of ssv_profile_solve; and about the speed [m/s or rad/s] at which it peaks.
/// @return false if no thruster acts along the leg; then the outputs are untouched.
bool ssv_profile_estimate(const ssv_thrusts_t* thrusts, real_t weight_time_per_s, real_t weight_impulse_per_Ns,
                          real_t distance, real_t* price, real_t* peak_speed);

#endif
