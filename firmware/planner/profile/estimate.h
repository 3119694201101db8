/// What the optimal profile of a leg costs, without solving it: for searches that compare hundreds of legs (DESIGN.md
/// 5).
#ifndef SSV_ESTIMATE_H
#define SSV_ESTIMATE_H

#include <stdbool.h>

#include "planner/profile/limits.h"
#include "ssv/real.h"

/// How close, as a share, two guesses of the peak must be for the price at the last to do. Around the right peak the
/// price is flat: "roughly" takes a fifth less time, and is off by up to 7 % for a turn instead of 5 %.
#define SSV_ESTIMATE_CLOSELY REAL(0.1)
#define SSV_ESTIMATE_ROUGHLY REAL(0.3)

/// Price W1 T + W2 F of the optimal profile over a distance [m or rad] > 0, to a few per cent for turns and a few per
/// mille for long flights, at some tenth of the time of ssv_profile_solve. *peak_speed is about the speed [m/s or
/// rad/s] at which that profile peaks.
/// speed_max [m/s or rad/s] is a cap; 0 = none.
/// @return false if no thruster acts along the leg; then the outputs are untouched.
bool ssv_profile_estimate(const ssv_thrusts_t* thrusts, real_t weight_time_per_s, real_t weight_impulse_per_Ns,
                          real_t distance, real_t speed_max, real_t closeness, real_t* price, real_t* peak_speed);

#endif
