// What a reason is in words.
#include "ssv/link.h"

const char* ssv_link_reason_str(ssv_link_reason_t reason) {
    static const char* const words[SSV_LINK_NUM_REASONS] = {
        [SSV_LINK_NO_REASON] = "no reason",
        [SSV_LINK_LENGTH] = "length is not that of the header",
        [SSV_LINK_FORMAT] = "no timeline file of this version",
        [SSV_LINK_CRC] = "CRC-32 is not that of the content",
        [SSV_LINK_PLAN_HASH] = "plan hash is missing or another one",
        [SSV_LINK_EPOCH] = "older than the last timeline",
        [SSV_LINK_EXPIRY] = "timeline has expired",
        [SSV_LINK_MASS_CONFIGURATION] = "reckoned for other bodies",
        [SSV_LINK_FORCE] = "asks for more thrust than there is",
        [SSV_LINK_START_POSE] = "vehicle is not at the start pose",
        [SSV_LINK_SEGMENTS] = "number of segments out of range",
        [SSV_LINK_DURATION] = "duration out of range",
        [SSV_LINK_THRUST] = "thrust out of range",
        [SSV_LINK_EVENT] = "event out of range or order",
        [SSV_LINK_NOTHING] = "no such timeline",
        [SSV_LINK_BUSY] = "busy executing",
        [SSV_LINK_NOT_ARMED] = "not armed",
        [SSV_LINK_BEAT_LOST] = "planner makes no progress",
        [SSV_LINK_COMMANDED] = "by command",
        [SSV_LINK_TRACKING] = "too far from the plan",
        [SSV_LINK_INTERNAL] = "internal state is impossible",
    };
    return (unsigned)reason < SSV_LINK_NUM_REASONS ? words[reason] : "unknown reason";
}
