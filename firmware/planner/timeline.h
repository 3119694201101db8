/// The thruster timeline: exact thrusts over time, cut into straight lines.
#ifndef SSV_TIMELINE_H
#define SSV_TIMELINE_H

#include "planner/profile.h"

/// Appends the segments of one piece, which starts t_s after the plan's start, to plan->segment. Each segment carries the
/// exact impulse of each thruster, keeps within +-force_max_N, and stays within SSV_TIMELINE_TOLERANCE of the exact thrust.
/// @return SSV_FEASIBLE, or SSV_TOO_MANY_SEGMENTS with the timeline incomplete.
ssv_outcome_t ssv_timeline_append(const ssv_thrusts_t* thrusts, const ssv_piece_t* piece, real_t t_s, int leg, ssv_plan_t* plan);

#endif
