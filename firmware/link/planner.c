// The planner's end of the link.
#include <string.h>

#include "link/client.h"

/// Numbers of MAVLink: a computer aboard that is no flight controller.
enum { TYPE_ONBOARD_CONTROLLER = 18, AUTOPILOT_INVALID = 8, STATE_ACTIVE = 4, MODE_ARMED = 128 };

#define HEARTBEAT_INTERVAL_US INT64_C(1000000)
/// [us] Of ten beats in a row, as many as the dead-man waits for, a line that loses every fifth frame loses all once in
/// ten days.
#define BEAT_INTERVAL_US INT64_C(100000)
/// [us] How long to wait for the answer to a command before it is given again, and how often: 10 s in all.
#define COMMAND_PATIENCE_US INT64_C(400000)
#define COMMAND_TRIES_MAX 25
#define CHUNK_BYTES_MIN 64

static uint8_t chunk_bytes(const ssv_link_planner_t* link) {
    const uint8_t asked = link->config.chunk_bytes;
    return asked >= CHUNK_BYTES_MIN && asked <= SSV_FTP_DATA_BYTES_MAX ? asked : SSV_FTP_DATA_BYTES_MAX;
}

void ssv_link_planner_init(ssv_link_planner_t* link, const ssv_link_planner_config_t* config) {
    memset(link, 0, sizeof *link);
    link->config = *config;
    link->beat.boot_id = config->boot_id;
    // A client that follows another one begins with other numbers, so the vehicle does not take its requests for old
    // ones.
    link->client.next_sequence = (uint16_t)(config->boot_id * UINT32_C(40503) >> 8);
    link->client.session = (uint8_t)(config->boot_id * UINT32_C(157));
    ssv_wire_init(&link->wire, config->sysid, config->compid, config->sign ? &config->signing : NULL);
}

bool ssv_link_planner_upload(ssv_link_planner_t* link, const uint8_t* file, size_t length) {
    if (length < SSV_TIMELINE_HEADER_BYTES || length > SSV_TIMELINE_FILE_BYTES_MAX) return false;
    ssv_client_begin(&link->client, file, length, chunk_bytes(link));
    return true;
}

size_t ssv_link_planner_uploaded(const ssv_link_planner_t* link) {
    const size_t bytes = (size_t)link->client.num_acked * chunk_bytes(link);
    return bytes < link->client.length ? bytes : link->client.length;
}

bool ssv_link_planner_command(ssv_link_planner_t* link, int64_t now_us, ssv_link_command_t command, int32_t value,
                              uint64_t plan_hash) {
    if (link->command.pending && command != SSV_LINK_TERMINATE) return false;
    link->command.pending = true;
    link->command.command = command;
    link->command.value = value;
    link->command.plan_hash = plan_hash;
    link->command.tries = 0;
    link->command.due_us = now_us;
    return true;
}

void ssv_link_planner_beat(ssv_link_planner_t* link, uint32_t session, uint32_t progress) {
    link->beat.session = session;
    link->beat.progress = progress;
}

void ssv_link_planner_trim(ssv_link_planner_t* link, uint32_t session, uint32_t sequence, int64_t plan_time_ns,
                           float clock_rate, const float trim_N[SSV_NUM_THRUSTERS]) {
    link->has_trim = true;
    link->trim.boot_id = link->config.boot_id;
    link->trim.session = session;
    link->trim.sequence = sequence;
    link->trim.plan_time_ns = plan_time_ns;
    link->trim.clock_rate = clock_rate;
    memcpy(link->trim.trim_N, trim_N, sizeof link->trim.trim_N);
}

// ---- Receiving ------------------------------------------------------------------------------------------------------

static void take_ack(ssv_link_planner_t* link, int64_t now_us, const ssv_packet_t* packet,
                     ssv_link_planner_event_t* event) {
    if (!link->command.pending || link->command.tries == 0 || packet->of.ack.command != link->command.command) return;
    if (packet->of.ack.result == SSV_LINK_IN_PROGRESS) {
        link->command.due_us = now_us + COMMAND_PATIENCE_US;
        return;
    }
    const uint32_t detail = (uint32_t)packet->of.ack.detail;
    link->command.pending = false;
    event->kind = SSV_LINK_PLANNER_ANSWERED;
    event->of.answer.command = link->command.command;
    event->of.answer.result = (ssv_link_result_t)packet->of.ack.result;
    event->of.answer.reason =
        (detail & 0xff) < SSV_LINK_NUM_REASONS ? (ssv_link_reason_t)(detail & 0xff) : SSV_LINK_INTERNAL;
    event->of.answer.index = (int32_t)(detail >> 8);
}

static void take_ftp(ssv_link_planner_t* link, int64_t now_us, const ssv_ftp_t* ftp, ssv_link_planner_event_t* event) {
    ssv_link_reason_t reason = SSV_LINK_NO_REASON;
    switch (ssv_client_answer(&link->client, now_us, ftp, chunk_bytes(link), &reason)) {
        case SSV_CLIENT_DONE: event->kind = SSV_LINK_PLANNER_UPLOADED; break;
        case SSV_CLIENT_FAILED:
            event->kind = SSV_LINK_PLANNER_UPLOAD_FAILED;
            event->of.upload = reason;
            break;
        default: break;
    }
}

static void take(ssv_link_planner_t* link, int64_t now_us, const ssv_packet_t* packet,
                 ssv_link_planner_event_t* event) {
    switch (packet->kind) {
        case SSV_PACKET_HEARTBEAT:
            event->kind = SSV_LINK_PLANNER_SEEN;
            event->of.seen.armed = (packet->of.heartbeat.base_mode & MODE_ARMED) != 0;
            event->of.seen.custom_mode = packet->of.heartbeat.custom_mode;
            break;
        case SSV_PACKET_EXECUTION:
            event->kind = SSV_LINK_PLANNER_EXECUTION;
            event->of.execution = packet->of.execution;
            break;
        case SSV_PACKET_ATTITUDE:
        case SSV_PACKET_POSITION:
            event->kind = packet->kind == SSV_PACKET_ATTITUDE ? SSV_LINK_PLANNER_ATTITUDE : SSV_LINK_PLANNER_POSITION;
            event->of.pose.time_boot_ms = packet->time_ms;
            event->of.pose.pose = packet->of.pose;
            break;
        case SSV_PACKET_THRUSTS:
            event->kind = SSV_LINK_PLANNER_THRUSTS;
            memcpy(event->of.u_N, packet->of.u_N, sizeof event->of.u_N);
            break;
        case SSV_PACKET_TEXT:
            event->kind = SSV_LINK_PLANNER_TEXT;
            event->of.text.severity = packet->of.text.severity;
            memcpy(event->of.text.text, packet->of.text.text, sizeof event->of.text.text);
            break;
        case SSV_PACKET_HEALTH:
            event->kind = SSV_LINK_PLANNER_HEALTH;
            event->of.health.lost = packet->of.health.lost;
            event->of.health.bad_crc = packet->of.health.bad_crc;
            event->of.health.bad_signature = packet->of.health.bad_signature;
            break;
        case SSV_PACKET_ACK: take_ack(link, now_us, packet, event); break;
        case SSV_PACKET_FTP: take_ftp(link, now_us, &packet->of.ftp, event); break;
        default: break;
    }
}

// What did not come in time.
static void watch(ssv_link_planner_t* link, int64_t now_us, ssv_link_planner_event_t* event) {
    if (ssv_client_watch(&link->client, now_us) == SSV_CLIENT_FAILED) {
        event->kind = SSV_LINK_PLANNER_UPLOAD_FAILED;
        event->of.upload = SSV_LINK_NOTHING;
    } else if (link->command.pending && link->command.tries >= COMMAND_TRIES_MAX && now_us >= link->command.due_us) {
        link->command.pending = false;
        event->kind = SSV_LINK_PLANNER_ANSWERED;
        event->of.answer.command = link->command.command;
        event->of.answer.result = SSV_LINK_NO_ANSWER;
        event->of.answer.reason = SSV_LINK_NO_REASON;
        event->of.answer.index = 0;
    }
}

size_t ssv_link_planner_receive(ssv_link_planner_t* link, int64_t now_us, const uint8_t* bytes, size_t num_bytes,
                                ssv_link_planner_event_t* event) {
    ssv_packet_t packet;
    size_t taken = 0;
    event->kind = SSV_LINK_PLANNER_NOTHING;
    for (;;) {
        while (ssv_wire_next(&link->wire, now_us, &packet)) {
            if (packet.sysid != link->config.vehicle_sysid || packet.compid != link->config.vehicle_compid) continue;
            take(link, now_us, &packet, event);
            if (event->kind != SSV_LINK_PLANNER_NOTHING) return taken;
        }
        if (taken == num_bytes) break;
        ssv_wire_take(&link->wire, bytes[taken++]);
    }
    watch(link, now_us, event);
    return taken;
}

// ---- Sending --------------------------------------------------------------------------------------------------------

static bool poll_command(ssv_link_planner_t* link, int64_t now_us, ssv_packet_t* packet) {
    const bool takes_hash = link->command.command == SSV_LINK_COMMIT || link->command.command == SSV_LINK_START;
    if (!link->command.pending || now_us < link->command.due_us || link->command.tries >= COMMAND_TRIES_MAX)
        return false;
    link->command.tries++;
    link->command.due_us = now_us + COMMAND_PATIENCE_US;
    packet->kind = SSV_PACKET_COMMAND;
    packet->of.command.command = (uint16_t)link->command.command;
    memset(packet->of.command.parameter, 0, sizeof packet->of.command.parameter);
    packet->of.command.parameter[0] = takes_hash ? 0 : (float)link->command.value;
    packet->of.command.x = takes_hash ? (uint32_t)link->command.plan_hash : 0;
    packet->of.command.y = takes_hash ? (uint32_t)(link->command.plan_hash >> 32) : 0;
    return true;
}

static bool poll_beat(ssv_link_planner_t* link, int64_t now_us, ssv_packet_t* packet) {
    if (link->beat.session != 0 && now_us >= link->beat_due_us) {
        link->beat_due_us = now_us + BEAT_INTERVAL_US;
        packet->kind = SSV_PACKET_BEAT;
        packet->of.beat = link->beat;
        return true;
    }
    if (link->has_trim) {
        link->has_trim = false;
        packet->kind = SSV_PACKET_TRIM;
        packet->of.trim = link->trim;
        return true;
    }
    if (now_us < link->heartbeat_due_us) return false;
    link->heartbeat_due_us = now_us + HEARTBEAT_INTERVAL_US;
    packet->kind = SSV_PACKET_HEARTBEAT;
    packet->of.heartbeat.type = TYPE_ONBOARD_CONTROLLER;
    packet->of.heartbeat.autopilot = AUTOPILOT_INVALID;
    packet->of.heartbeat.base_mode = 0;
    packet->of.heartbeat.status = STATE_ACTIVE;
    packet->of.heartbeat.custom_mode = 0;
    return true;
}

size_t ssv_link_planner_poll(ssv_link_planner_t* link, int64_t now_us, uint8_t* frame) {
    ssv_packet_t packet;
    packet.target_sysid = link->config.vehicle_sysid;
    packet.target_compid = link->config.vehicle_compid;
    if (poll_command(link, now_us, &packet) || poll_beat(link, now_us, &packet))
        return ssv_wire_send(&link->wire, now_us, &packet, frame);
    packet.kind = SSV_PACKET_FTP;
    if (ssv_client_poll(&link->client, now_us, chunk_bytes(link), &packet.of.ftp))
        return ssv_wire_send(&link->wire, now_us, &packet, frame);
    return 0;
}
