#include "vehicle/deadman.h"

bool ssv_deadman_is_ahead(uint32_t counter, uint32_t of) { return counter != of && counter - of < UINT32_C(1) << 31; }

static bool is_source(const ssv_deadman_t* deadman, uint8_t sysid, uint8_t compid, uint32_t boot_id, uint32_t session) {
    return deadman->is_known && deadman->sysid == sysid && deadman->compid == compid &&
           deadman->beat.boot_id == boot_id && deadman->beat.session == session;
}

static bool is_old(const ssv_deadman_t* deadman, const ssv_link_beat_t* beat) {
    return beat->boot_id == deadman->flown_boot_id && !ssv_deadman_is_ahead(beat->session, deadman->flown_session);
}

bool ssv_deadman_beat(ssv_deadman_t* deadman, int64_t now_us, int64_t warn_us, uint8_t sysid, uint8_t compid,
                      const ssv_link_beat_t* beat) {
    if (is_source(deadman, sysid, compid, beat->boot_id, beat->session)) {
        if (!ssv_deadman_is_ahead(beat->progress, deadman->beat.progress)) return false;
    } else {
        const bool is_silent = !deadman->is_known || now_us - deadman->grew_us > warn_us;
        if (deadman->is_bound || !is_silent || beat->boot_id == 0 || beat->session == 0 || is_old(deadman, beat))
            return false;
    }
    deadman->is_known = true;
    deadman->sysid = sysid;
    deadman->compid = compid;
    deadman->beat = *beat;
    deadman->grew_us = now_us;
    deadman->has_warned = false;
    return true;
}

bool ssv_deadman_bind(ssv_deadman_t* deadman, int64_t now_us, int64_t warn_us, uint8_t sysid, uint8_t compid) {
    if (!deadman->is_known || deadman->sysid != sysid || deadman->compid != compid ||
        now_us - deadman->grew_us > warn_us)
        return false;
    deadman->is_bound = true;
    deadman->flown_boot_id = deadman->beat.boot_id;
    deadman->flown_session = deadman->beat.session;
    return true;
}

void ssv_deadman_release(ssv_deadman_t* deadman) {
    if (!deadman->is_bound) return;
    deadman->is_bound = deadman->is_known = false;
}

bool ssv_deadman_is_bound_to(const ssv_deadman_t* deadman, uint8_t sysid, uint8_t compid, uint32_t boot_id,
                             uint32_t session) {
    return deadman->is_bound && is_source(deadman, sysid, compid, boot_id, session);
}
