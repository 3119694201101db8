/// The paper's own way to price a leg, to compare the planner's closed forms with: forward iteration of the dynamics
/// with steps of 0.01 s (Eqs. 6, 7, 11, 15 and the text around them). Written from the paper; takes from the planner
/// only the thrust that a leg asks for, u_i = accel_i s'' + linear_i s' + quadratic_i s'^2, so that both price the same
/// motion. Where the paper leaves open how much is iterated anew (fitting ramps, the hold) it takes the least.
#ifndef BENCH_EULER_H
#define BENCH_EULER_H

#include "planner/profile/profile.h"

typedef struct {
    double time_s, impulse_Ns;
    int steps;
} euler_price_t;

/// What the constant hold between the ramps is: one product, or stepped like the ramps (the paper does not say).
typedef enum { EULER_HOLD_IN_ONE = 0, EULER_HOLD_STEPPED = 1 } euler_hold_t;

/// Speeds up with full thrust until the acceleration is below 0.001, holds, and slows down from there: with full
/// reverse, or with the least thrust down to the speed `cutoff`, where it holds for good. The way to slow down with
/// less weight_time time + weight_impulse impulse counts. Where the ramps are longer than the leg, the pair of points
/// of equal speed on them is looked for with which they fit.
euler_price_t euler_price(const ssv_thrusts_t* thrusts, double distance, double cutoff, double weight_time,
                          double weight_impulse, euler_hold_t hold);

#endif
