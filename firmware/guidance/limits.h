/// Every limit and bandwidth of guidance, each with its meaning and where it is from.
#ifndef SSV_GUIDANCE_LIMITS_H
#define SSV_GUIDANCE_LIMITS_H

#include "ssv/real.h"

// Observer: bandwidth (q / r)^(1/6) [rad/s] of the steady Kalman-Bucy filter whose disturbance is driven by white noise
// of density q while measurements have noise of density r. Larger follows faster, smaller is quieter: the deviation of
// the estimate from noise alone is that of a measurement times sqrt(2 bandwidth interval). In the hold thrusts hardly
// change, so their errors do not either.
#define OBSERVER_POSITION_RAD_S REAL(0.7)
#define OBSERVER_ATTITUDE_RAD_S REAL(0.7)
#define OBSERVER_HOLD_POSITION_RAD_S REAL(0.7)
#define OBSERVER_HOLD_ATTITUDE_RAD_S REAL(0.6)
// Time [s] over which the observer goes from the one to the other.
#define OBSERVER_SETTLE_S REAL(15)
// Longest interval [s] that one measurement stands for: after a drop-out it does not count for more.
#define OBSERVER_INTERVAL_MAX_S REAL(0.2)

// Law: poles [rad/s] of the position and the attitude error.
#define LAW_POSITION_RAD_S REAL(0.3)
#define LAW_ATTITUDE_RAD_S REAL(1)

// Clock: stands still at such a lag along the path or about the turning axis, runs freely below a fifth of it.
#define CLOCK_LAG_M REAL(0.05)
#define CLOCK_LAG_RAD REAL(0.1)

// Beyond such an error beside the path the plan is lost.
#define LOST_ACROSS_M REAL(0.5)
#define LOST_ANGLE_RAD REAL(0.5)

// Dwell: what the estimate must stay inside of for so long, and how long that may take.
#define DWELL_TIP_M REAL(0.012)
#define DWELL_ANGLE_RAD REAL(0.0105)
#define DWELL_SPEED_M_S REAL(0.006)
#define DWELL_INSIDE_S REAL(2)
#define DWELL_MAX_S REAL(120)
// At first it must be inside a share of these, which grows to all of them in so long: who can do better, does.
#define DWELL_TIGHT REAL(0.4)
#define DWELL_LOOSEN_S REAL(20)
// Who has not come inside after so long takes more, up to this share at the longest: half of what a gripper forgives
// (4 cm, 2 deg, 2 cm/s) is better than coming again, which takes minutes and is no better.
#define DWELL_PATIENCE_S REAL(60)
#define DWELL_LOOSE REAL(1.6)
// Least time in the hold: the observer's transients must be over.
#define DWELL_LEAST_S REAL(4)

// Backing off: how far, how fast, how often. A plan keeps clear of what stands around on its own way alone, and behind
// a beam that goes between two hubs there is little room: less far where anything stands.
#define BACK_OFF_M REAL(0.3)
#define BACK_OFF_NEAR_M REAL(0.1)
#define BACK_OFF_M_S REAL(0.01)
// After the last time it comes to rest for so long before it gives up: who is stopped in motion drifts on.
#define BACK_OFF_REST_S REAL(15)
#define SSV_GUIDANCE_TRIES 3

#endif
