#include "pilot.h"

#include <string.h>

static const ssv_link_command_t steps[] = {SSV_LINK_COMMIT, SSV_LINK_ARM, SSV_LINK_START};

const char* pilot_init(pilot_t* pilot, const sil_config_t* config, const ssv_timeline_t* timeline, uint64_t seed) {
    memset(pilot, 0, sizeof *pilot);
    const char* fault = sil_init(&pilot->sil, config, seed);
    if (fault != NULL) return fault;
    const ssv_timeline_stamp_t stamp = {INT64_C(1767225600000000), 600000};
    const ssv_link_planner_config_t planner = {.sysid = SSV_LINK_VEHICLE_SYSID,
                                               .compid = SSV_LINK_PLANNER_COMPID,
                                               .vehicle_sysid = SSV_LINK_VEHICLE_SYSID,
                                               .vehicle_compid = SSV_LINK_VEHICLE_COMPID,
                                               .boot_id = 41};
    ssv_link_planner_init(&pilot->planner, &planner);
    pilot->length = ssv_timeline_encode(timeline, &stamp, pilot->file, sizeof pilot->file);
    pilot->plan_hash = timeline->plan_hash;
    pilot->session = 1;
    return ssv_link_planner_upload(&pilot->planner, pilot->file, pilot->length) ? NULL : "no timeline file";
}

static void take(pilot_t* pilot, const ssv_link_planner_event_t* event) {
    bool done = event->kind == SSV_LINK_PLANNER_UPLOADED;
    if (event->kind == SSV_LINK_PLANNER_EXECUTION) pilot->execution = event->of.execution;
    if (event->kind == SSV_LINK_PLANNER_UPLOAD_FAILED) pilot->has_failed = true;
    if (event->kind == SSV_LINK_PLANNER_TEXT && event->of.text.severity <= SSV_LINK_WARNING)
        memcpy(pilot->warning, event->of.text.text, sizeof pilot->warning);
    if (event->kind == SSV_LINK_PLANNER_ANSWERED) {
        done = event->of.answer.result == SSV_LINK_ACCEPTED;
        if (!done) {
            pilot->has_failed = true;
            pilot->refusal = event->of.answer.reason;
        }
    }
    if (!done) return;
    if (pilot->num_done < 3)
        ssv_link_planner_command(&pilot->planner, pilot->sil.now_us, steps[pilot->num_done], 1, pilot->plan_hash);
    pilot->num_done++;
}

static void exchange(pilot_t* pilot) {
    uint8_t frame[SSV_LINK_FRAME_BYTES_MAX];
    size_t length;
    const int64_t now_us = pilot->sil.now_us;
    ssv_link_planner_event_t event;
    while ((length = ssv_link_planner_poll(&pilot->planner, now_us, frame)) > 0) {
        if (!pilot->is_cut) ssv_vehicle_receive(&pilot->sil.vehicle, now_us, frame, length);
    }
    while ((length = ssv_vehicle_poll(&pilot->sil.vehicle, now_us, frame)) > 0) {
        if (pilot->is_cut) continue;
        ssv_link_planner_receive(&pilot->planner, now_us, frame, length, &event);
        take(pilot, &event);
    }
    ssv_link_planner_receive(&pilot->planner, now_us, NULL, 0, &event);
    take(pilot, &event);
}

void pilot_step(pilot_t* pilot) {
    if (!pilot->is_frozen) pilot->progress++;
    ssv_link_planner_beat(&pilot->planner, pilot->session, pilot->progress);
    exchange(pilot);
    sil_step(&pilot->sil);
}

bool pilot_await(pilot_t* pilot, ssv_link_phase_t phase, double longest_s) {
    const int64_t until_us = pilot->sil.now_us + (int64_t)(1e6 * longest_s);
    while (pilot->sil.vehicle.state.phase != phase && pilot->sil.now_us < until_us) pilot_step(pilot);
    return pilot->sil.vehicle.state.phase == phase;
}
