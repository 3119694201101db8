/// The live timeline, tick by tick.
#ifndef VEHICLE_EXECUTION_H
#define VEHICLE_EXECUTION_H

#include "ssv/vehicle.h"

/// Stands at the start of a sound timeline file, which stays as it is.
void ssv_execution_begin(ssv_execution_t* execution, const uint8_t* file);

/// Goes on by a tick, but not past an event or the end. `mean_N` is the impulse of what it passed over the tick.
void ssv_execution_advance(ssv_execution_t* execution, float mean_N[SSV_NUM_THRUSTERS]);

/// Whether it stands before an event, which must be passed first.
bool ssv_execution_is_at_event(const ssv_execution_t* execution);
void ssv_execution_pass_event(ssv_execution_t* execution);

/// Whether all segments and events are behind it.
bool ssv_execution_is_over(const ssv_execution_t* execution);

#endif
