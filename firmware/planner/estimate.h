/// What the optimal profile of a leg costs, without solving it: for searches that compare hundreds of legs (DESIGN.md 5).
#ifndef SSV_ESTIMATE_H
#define SSV_ESTIMATE_H

#include "planner/profile.h"

/// Price W1 T + W2 F of the optimal profile over a distance [m or rad] > 0, within a few per mille of ssv_profile_solve at some
/// tenth of its time; mostly too high. @return false if no thruster acts along the leg; then *price is untouched.
bool ssv_profile_estimate(const ssv_thrusts_t* thrusts, real_t weight_time_per_s, real_t weight_impulse_per_Ns,
                          real_t distance, real_t* price);

#endif
