/// The live timeline, tick by tick.
#ifndef VEHICLE_EXECUTION_H
#define VEHICLE_EXECUTION_H

#include "ssv/vehicle.h"

/// Stands at the start of a sound timeline file, which stays as it is.
void ssv_execution_begin(ssv_execution_t* execution, const uint8_t* file);

/// Goes on for a tick, by `passing_ns` [0, 1.25 ticks] on the timeline's clock, but not past an event or the end, and
/// gives the thrust of the tick.
///
/// That is the impulse of the timeline over what passed, spread over the tick: its mean where the clock runs at the
/// rate 1, less where it is slower, nothing where it stands. To it comes a correction, so that the moment in time at
/// which it acts is right, too: where a thrust jumps within a tick the mean alone acts too early or too late by up to
/// an eighth of jump times tick squared, and an unstable pair makes centimetres of that. What is wrong in one tick is
/// made good by a little more in it and as much less in the next one, or the other way round: at most `room_N`, which
/// the thrusters have above every thrust of the timeline, a quarter of the largest for the largest jump.
void ssv_execution_advance(ssv_execution_t* execution, int64_t passing_ns, float most_N, float room_N,
                           float u_N[SSV_NUM_THRUSTERS]);

/// Whether it stands before an event, which must be passed first.
bool ssv_execution_is_at_event(const ssv_execution_t* execution);
void ssv_execution_pass_event(ssv_execution_t* execution);

/// Whether all segments and events are behind it.
bool ssv_execution_is_over(const ssv_execution_t* execution);

#endif
