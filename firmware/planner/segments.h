/// The thruster timeline: exact thrusts over time, as straight lines.
#ifndef SSV_SEGMENTS_H
#define SSV_SEGMENTS_H

#include "planner/profile/limits.h"
#include "ssv/plan.h"
#include "ssv/real.h"

/// Appends the segments of one arc, which starts t_s after the plan's start, to plan->segment. Each segment carries
/// the exact impulse of each thruster, keeps within +-force_max_N, and stays within SSV_TIMELINE_TOLERANCE of the exact
/// thrust.
/// @param drift_max_s2 bound on the error over force_max times the square of the segment's length: how far the error
/// could carry the body. A weak thrust over a long coast passes the tolerance as almost any line; this keeps it from
/// being lost. For the SSV 1e-4 s2 is 8 um.
/// @return SSV_FEASIBLE, or SSV_TOO_MANY_SEGMENTS with the timeline incomplete.
ssv_outcome_t ssv_timeline_append(const ssv_thrusts_t* thrusts, const ssv_arc_t* arc, real_t t_s, int leg,
                                  real_t drift_max_s2, ssv_plan_t* plan);

/// About how many segments ssv_timeline_append makes of an arc, at a fraction of the time.
int ssv_timeline_count(const ssv_thrusts_t* thrusts, const ssv_arc_t* arc, real_t drift_max_s2);

#endif
