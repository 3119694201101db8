/// The dead-man: whose beats count, and how long the planner has made no progress.
///
/// A beat counts when the planner's progress counter has grown. During an execution only beats of its own sender, boot
/// and session count. Before one, a source that has not fallen silent keeps its place, and one that was flown is old:
/// foreign, frozen and replayed beats do not keep a vehicle going.
#ifndef VEHICLE_DEADMAN_H
#define VEHICLE_DEADMAN_H

#include "ssv/vehicle.h"

/// @return whether the beat counted.
bool ssv_deadman_beat(ssv_deadman_t* deadman, int64_t now_us, int64_t warn_us, uint8_t sysid, uint8_t compid,
                      const ssv_link_beat_t* beat);

/// Binds the execution to the beats of a sender. False when it has none that are fresh.
bool ssv_deadman_bind(ssv_deadman_t* deadman, int64_t now_us, int64_t warn_us, uint8_t sysid, uint8_t compid);

/// The execution is over; its session cannot be used again.
void ssv_deadman_release(ssv_deadman_t* deadman);

/// Whether a sender, boot and session are those that the execution is bound to.
bool ssv_deadman_is_bound_to(const ssv_deadman_t* deadman, uint8_t sysid, uint8_t compid, uint32_t boot_id,
                             uint32_t session);

/// Whether a counter is ahead of another one; they may wrap.
bool ssv_deadman_is_ahead(uint32_t counter, uint32_t of);

#endif
