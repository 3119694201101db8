// MAVLink frames: checksums, sequence numbers, signatures, and the messages that mean something to us.
#include "link/wire.h"

#include <float.h>

#include "link/bytes.h"

// Nothing of the generated code keeps state of its own: only calls whose state is the caller's are made.
#define MAVLINK_NO_CONVERSION_HELPERS
#define MAVLINK_MAX_SIGNING_STREAMS 4
#include "ssv/mavlink.h"

/// [10 us] from the Unix epoch to that of signatures, 2015-01-01.
#define SIGNING_EPOCH_US INT64_C(1420070400000000)

typedef struct {
    mavlink_status_t status;
    mavlink_message_t message; ///< being received
    bool sign;
    int64_t unix_zero_us;
    mavlink_signing_t signing;
    mavlink_signing_streams_t streams;
} framing_t;

_Static_assert(sizeof(framing_t) <= sizeof((ssv_wire_t*)0)->memory, "ssv_wire_t.memory is too small");

// The pointers into the state itself are set at each use, so that the state may be moved.
static framing_t* framing_of(ssv_wire_t* wire, int64_t now_us) {
    framing_t* framing = (framing_t*)(void*)wire->memory;
    if (framing->sign) {
        // The library counts the time up by one per frame and by what others send; the clock must lead.
        const uint64_t clock = (uint64_t)(framing->unix_zero_us + now_us - SIGNING_EPOCH_US) / 10;
        if (clock > framing->signing.timestamp) framing->signing.timestamp = clock;
        framing->status.signing = &framing->signing;
        framing->status.signing_streams = &framing->streams;
    }
    return framing;
}

void ssv_wire_init(ssv_wire_t* wire, uint8_t sysid, uint8_t compid, const ssv_link_signing_t* signing) {
    memset(wire, 0, sizeof *wire);
    wire->sysid = sysid;
    wire->compid = compid;
    framing_t* framing = (framing_t*)(void*)wire->memory;
    framing->status.parse_state = MAVLINK_PARSE_STATE_IDLE;
    if (signing == NULL) return;
    framing->sign = true;
    framing->unix_zero_us = signing->unix_zero_us;
    framing->signing.flags = MAVLINK_SIGNING_FLAG_SIGN_OUTGOING;
    framing->signing.link_id = signing->link_id;
    memcpy(framing->signing.secret_key, signing->key, sizeof signing->key);
}

// ---- Frames: I to NED and S to FRD, half a turn about x; its own inverse. -------------------------------------------

static void turn_vector(const float in[3], float out[3]) {
    out[0] = in[0];
    out[1] = -in[1];
    out[2] = -in[2];
}

static void turn_quaternion(const float in[4], float out[4]) {
    out[0] = in[0];
    out[1] = in[1];
    out[2] = -in[2];
    out[3] = -in[3];
}

// ---- Receiving ------------------------------------------------------------------------------------------------------

static void count_received(ssv_wire_t* wire, const mavlink_message_t* message) {
    ssv_link_statistics_t* statistics = &wire->statistics;
    int32_t i = 0;
    statistics->received++;
    while (i < statistics->num_peers &&
           (statistics->peer[i].sysid != message->sysid || statistics->peer[i].compid != message->compid))
        i++;
    if (i == SSV_LINK_MAX_PEERS) return;
    ssv_link_peer_t* peer = &statistics->peer[i];
    if (i == statistics->num_peers) {
        *peer = (ssv_link_peer_t){message->sysid, message->compid, message->seq, 0, 0};
        statistics->num_peers++;
    }
    // What seems to be more than half of the numbers lost is rather a frame that came late or a peer that began anew.
    const uint8_t gap = (uint8_t)(message->seq - peer->next_sequence);
    if (gap < 128) {
        peer->lost += gap;
        statistics->lost += gap;
    }
    peer->next_sequence = (uint8_t)(message->seq + 1);
    peer->received++;
}

// The text of a message's field, which need not end in a zero.
static void copy_text(char* to, size_t size, const char* from, size_t length) {
    size_t i = 0;
    for (; i + 1 < size && i < length && from[i] != '\0'; i++) to[i] = from[i];
    to[i] = '\0';
}

static bool read_command(const mavlink_message_t* message, ssv_packet_t* packet) {
    packet->kind = SSV_PACKET_COMMAND;
    packet->of.command.is_long = message->msgid == MAVLINK_MSG_ID_COMMAND_LONG;
    if (packet->of.command.is_long) {
        mavlink_command_long_t in;
        mavlink_msg_command_long_decode(message, &in);
        packet->of.command.command = in.command;
        const float parameter[4] = {in.param1, in.param2, in.param3, in.param4};
        memcpy(packet->of.command.parameter, parameter, sizeof parameter);
        packet->of.command.x = packet->of.command.y = 0;
        return true;
    }
    mavlink_command_int_t in;
    mavlink_msg_command_int_decode(message, &in);
    packet->of.command.command = in.command;
    const float parameter[4] = {in.param1, in.param2, in.param3, in.param4};
    memcpy(packet->of.command.parameter, parameter, sizeof parameter);
    packet->of.command.x = (uint32_t)in.x;
    packet->of.command.y = (uint32_t)in.y;
    return true;
}

static bool read_parameter(const mavlink_message_t* message, ssv_packet_t* packet) {
    if (message->msgid == MAVLINK_MSG_ID_PARAM_REQUEST_READ) {
        mavlink_param_request_read_t in;
        mavlink_msg_param_request_read_decode(message, &in);
        packet->kind = SSV_PACKET_PARAMETER_READ;
        packet->of.parameter.index = in.param_index;
        copy_text(packet->of.parameter.name, sizeof packet->of.parameter.name, in.param_id, sizeof in.param_id);
    } else {
        mavlink_param_set_t in;
        mavlink_msg_param_set_decode(message, &in);
        packet->kind = SSV_PACKET_PARAMETER_SET;
        packet->of.parameter.index = -1;
        copy_text(packet->of.parameter.name, sizeof packet->of.parameter.name, in.param_id, sizeof in.param_id);
    }
    return true;
}

static bool read_ftp(const mavlink_message_t* message, ssv_packet_t* packet) {
    mavlink_file_transfer_protocol_t in;
    mavlink_msg_file_transfer_protocol_decode(message, &in);
    packet->kind = SSV_PACKET_FTP;
    packet->of.ftp.sequence = ssv_get_u16(in.payload);
    packet->of.ftp.session = in.payload[2];
    packet->of.ftp.opcode = in.payload[3];
    packet->of.ftp.size = in.payload[4];
    packet->of.ftp.request = in.payload[5];
    packet->of.ftp.last_of_burst = in.payload[6];
    packet->of.ftp.offset = ssv_get_u32(in.payload + 8);
    memcpy(packet->of.ftp.data, in.payload + SSV_FTP_HEADER_BYTES, SSV_FTP_DATA_BYTES_MAX);
    return packet->of.ftp.size <= SSV_FTP_DATA_BYTES_MAX;
}

static bool read_attitude(const mavlink_message_t* message, ssv_packet_t* packet) {
    mavlink_attitude_quaternion_t in;
    mavlink_msg_attitude_quaternion_decode(message, &in);
    packet->kind = SSV_PACKET_ATTITUDE;
    packet->time_ms = in.time_boot_ms;
    turn_quaternion((const float[]){in.q1, in.q2, in.q3, in.q4}, packet->of.pose.q_IS);
    turn_vector((const float[]){in.rollspeed, in.pitchspeed, in.yawspeed}, packet->of.pose.w_IS_S_rad_s);
    return true;
}

static bool read_position(const mavlink_message_t* message, ssv_packet_t* packet) {
    mavlink_local_position_ned_t in;
    mavlink_msg_local_position_ned_decode(message, &in);
    packet->kind = SSV_PACKET_POSITION;
    packet->time_ms = in.time_boot_ms;
    turn_vector((const float[]){in.x, in.y, in.z}, packet->of.pose.p_IS_m);
    turn_vector((const float[]){in.vx, in.vy, in.vz}, packet->of.pose.v_IS_m_s);
    return true;
}

static bool read_execution(const mavlink_message_t* message, ssv_packet_t* packet) {
    mavlink_ssv_execution_t in;
    mavlink_msg_ssv_execution_decode(message, &in);
    if (in.phase > SSV_LINK_DONE || in.reason >= SSV_LINK_NUM_REASONS) return false;
    packet->kind = SSV_PACKET_EXECUTION;
    packet->time_ms = in.time_boot_ms;
    packet->of.execution = (ssv_link_execution_t){in.time_boot_ms,
                                                  in.boot_id,
                                                  in.beat,
                                                  in.live_hash,
                                                  in.incoming_hash,
                                                  in.plan_time,
                                                  in.segment,
                                                  (ssv_link_phase_t)in.phase,
                                                  (ssv_link_reason_t)in.reason,
                                                  in.events,
                                                  in.attempts};
    return true;
}

static bool read_trim(const mavlink_message_t* message, ssv_packet_t* packet) {
    mavlink_ssv_trim_t in;
    mavlink_msg_ssv_trim_decode(message, &in);
    packet->kind = SSV_PACKET_TRIM;
    packet->of.trim.boot_id = in.boot_id;
    packet->of.trim.session = in.session;
    packet->of.trim.sequence = in.sequence;
    packet->of.trim.plan_time_ns = in.plan_time;
    packet->of.trim.clock_rate = in.clock_rate;
    if (!(in.clock_rate >= 0 && in.clock_rate <= 1)) return false;
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        if (!ssv_within(in.trim[i], FLT_MAX)) return false;
        packet->of.trim.trim_N[i] = in.trim[i];
    }
    return true;
}

// Messages of one or two fields, and those that carry no more than a request.
static bool read_small(const mavlink_message_t* message, ssv_packet_t* packet) {
    switch (message->msgid) {
        case MAVLINK_MSG_ID_HEARTBEAT:
            packet->kind = SSV_PACKET_HEARTBEAT;
            packet->of.heartbeat.type = mavlink_msg_heartbeat_get_type(message);
            packet->of.heartbeat.autopilot = mavlink_msg_heartbeat_get_autopilot(message);
            packet->of.heartbeat.base_mode = mavlink_msg_heartbeat_get_base_mode(message);
            packet->of.heartbeat.status = mavlink_msg_heartbeat_get_system_status(message);
            packet->of.heartbeat.custom_mode = mavlink_msg_heartbeat_get_custom_mode(message);
            return true;
        case MAVLINK_MSG_ID_SYS_STATUS:
            packet->kind = SSV_PACKET_HEALTH;
            packet->of.health.lost = mavlink_msg_sys_status_get_errors_count1(message);
            packet->of.health.bad_crc = mavlink_msg_sys_status_get_errors_count2(message);
            packet->of.health.bad_signature = mavlink_msg_sys_status_get_errors_count3(message);
            return true;
        case MAVLINK_MSG_ID_COMMAND_ACK:
            packet->kind = SSV_PACKET_ACK;
            packet->of.ack.command = mavlink_msg_command_ack_get_command(message);
            packet->of.ack.result = mavlink_msg_command_ack_get_result(message);
            packet->of.ack.detail = mavlink_msg_command_ack_get_result_param2(message);
            return true;
        case MAVLINK_MSG_ID_TIMESYNC:
            packet->kind = SSV_PACKET_TIMESYNC;
            packet->of.timesync.ours_ns = mavlink_msg_timesync_get_tc1(message);
            packet->of.timesync.theirs_ns = mavlink_msg_timesync_get_ts1(message);
            return true;
        case MAVLINK_MSG_ID_PARAM_REQUEST_LIST: packet->kind = SSV_PACKET_PARAMETER_LIST; return true;
        case MAVLINK_MSG_ID_SSV_BEAT:
            packet->kind = SSV_PACKET_BEAT;
            packet->of.beat.boot_id = mavlink_msg_ssv_beat_get_boot_id(message);
            packet->of.beat.session = mavlink_msg_ssv_beat_get_session(message);
            packet->of.beat.progress = mavlink_msg_ssv_beat_get_progress(message);
            return true;
        case MAVLINK_MSG_ID_ACTUATOR_OUTPUT_STATUS: {
            float actuator[32];
            mavlink_msg_actuator_output_status_get_actuator(message, actuator);
            packet->kind = SSV_PACKET_THRUSTS;
            memcpy(packet->of.u_N, actuator, sizeof packet->of.u_N);
            return true;
        }
        case MAVLINK_MSG_ID_STATUSTEXT: {
            char text[SSV_LINK_TEXT_MAX];
            mavlink_msg_statustext_get_text(message, text);
            packet->kind = SSV_PACKET_TEXT;
            packet->of.text.severity = mavlink_msg_statustext_get_severity(message);
            copy_text(packet->of.text.text, sizeof packet->of.text.text, text, sizeof text);
            return true;
        }
        default: return false;
    }
}

static bool read_message(const mavlink_message_t* message, ssv_packet_t* packet) {
    switch (message->msgid) {
        case MAVLINK_MSG_ID_COMMAND_INT:
        case MAVLINK_MSG_ID_COMMAND_LONG: return read_command(message, packet);
        case MAVLINK_MSG_ID_PARAM_REQUEST_READ:
        case MAVLINK_MSG_ID_PARAM_SET: return read_parameter(message, packet);
        case MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL: return read_ftp(message, packet);
        case MAVLINK_MSG_ID_ATTITUDE_QUATERNION: return read_attitude(message, packet);
        case MAVLINK_MSG_ID_LOCAL_POSITION_NED: return read_position(message, packet);
        case MAVLINK_MSG_ID_SSV_EXECUTION: return read_execution(message, packet);
        case MAVLINK_MSG_ID_SSV_TRIM: return read_trim(message, packet);
        default: return read_small(message, packet);
    }
}

// Whether a good frame is a packet for us.
static bool accept(ssv_wire_t* wire, const mavlink_message_t* message, ssv_packet_t* packet) {
    count_received(wire, message);
    if (message->msgid == MAVLINK_MSG_ID_SETUP_SIGNING) wire->statistics.refused_signing_setup++;
    const mavlink_msg_entry_t* entry = mavlink_get_msg_entry(message->msgid);
    const uint8_t* payload = (const uint8_t*)_MAV_PAYLOAD(message);
    packet->sysid = message->sysid;
    packet->compid = message->compid;
    packet->target_sysid =
        (entry->flags & MAV_MSG_ENTRY_FLAG_HAVE_TARGET_SYSTEM) != 0 ? payload[entry->target_system_ofs] : 0;
    packet->target_compid =
        (entry->flags & MAV_MSG_ENTRY_FLAG_HAVE_TARGET_COMPONENT) != 0 ? payload[entry->target_component_ofs] : 0;
    packet->time_ms = 0;
    const bool is_ours = (packet->target_sysid == 0 || packet->target_sysid == wire->sysid) &&
                         (packet->target_compid == 0 || packet->target_compid == wire->compid) &&
                         !(message->sysid == wire->sysid && message->compid == wire->compid);
    return is_ours && read_message(message, packet);
}

void ssv_wire_take(ssv_wire_t* wire, uint8_t byte) { wire->byte[wire->held++] = byte; }

static void drop(ssv_wire_t* wire, uint16_t count) {
    wire->held = (uint16_t)(wire->held - count);
    wire->parsed = 0;
    memmove(wire->byte, wire->byte + count, wire->held);
}

// Looks at the next byte; what became of the frame that it is of.
static uint8_t parse(ssv_wire_t* wire, framing_t* framing) {
    const uint8_t outcome =
        mavlink_frame_char_buffer(&framing->message, &framing->status, wire->byte[wire->parsed++], NULL, NULL);
    const bool is_new = wire->parsed == wire->held; // what is looked at again was counted before
    switch (outcome) {
        case MAVLINK_FRAMING_BAD_CRC:
            if (is_new && mavlink_get_msg_entry(framing->message.msgid) == NULL)
                wire->statistics.unknown++;
            else if (is_new)
                wire->statistics.bad_crc++;
            framing->status.parse_state = MAVLINK_PARSE_STATE_IDLE; // it would wait for the signature of a bad frame
            drop(wire, 1);
            break;
        case MAVLINK_FRAMING_BAD_SIGNATURE:
            wire->statistics.bad_signature++;
            if ((framing->message.incompat_flags & MAVLINK_IFLAG_SIGNED) != 0 &&
                framing->signing.last_status == MAVLINK_SIGNING_STATUS_TOO_MANY_STREAMS)
                wire->statistics.refused_streams++;
            drop(wire, wire->parsed);
            break;
        case MAVLINK_FRAMING_OK: drop(wire, wire->parsed); break;
        default:
            if (framing->status.parse_state <= MAVLINK_PARSE_STATE_IDLE)
                drop(wire, 1); // no start of a frame, or of one with flags that nobody knows
            break;
    }
    return outcome;
}

bool ssv_wire_next(ssv_wire_t* wire, int64_t now_us, ssv_packet_t* packet) {
    framing_t* framing = framing_of(wire, now_us);
    while (wire->parsed < wire->held) {
        if (parse(wire, framing) == MAVLINK_FRAMING_OK && accept(wire, &framing->message, packet)) return true;
    }
    return false;
}

// ---- Sending --------------------------------------------------------------------------------------------------------

// Generated structs are in wire order, largest fields first, so they begin with the payload as it stands.
typedef union {
    mavlink_heartbeat_t heartbeat;
    mavlink_sys_status_t health;
    mavlink_command_int_t command;
    mavlink_command_ack_t ack;
    mavlink_attitude_quaternion_t attitude;
    mavlink_local_position_ned_t position;
    mavlink_actuator_output_status_t thrusts;
    mavlink_statustext_t text;
    mavlink_timesync_t timesync;
    mavlink_param_value_t parameter;
    mavlink_autopilot_version_t version;
    mavlink_file_transfer_protocol_t ftp;
    mavlink_ssv_execution_t execution;
    mavlink_ssv_beat_t beat;
    mavlink_ssv_trim_t trim;
} payload_t;

_Static_assert(offsetof(mavlink_ssv_execution_t, attempts) + 1 == MAVLINK_MSG_ID_SSV_EXECUTION_LEN,
               "the struct is the payload, and what may follow it is padding");
_Static_assert(!MAVLINK_NEED_BYTE_SWAP && MAVLINK_ALIGNED_FIELDS,
               "payloads are copied from structs as they stand, which takes a little-endian machine");

static void write_command(const ssv_packet_t* packet, mavlink_command_int_t* out) {
    out->target_system = packet->target_sysid;
    out->target_component = packet->target_compid;
    out->command = packet->of.command.command;
    out->param1 = packet->of.command.parameter[0];
    out->param2 = packet->of.command.parameter[1];
    out->param3 = packet->of.command.parameter[2];
    out->param4 = packet->of.command.parameter[3];
    out->x = (int32_t)packet->of.command.x;
    out->y = (int32_t)packet->of.command.y;
}

static void write_ack(const ssv_packet_t* packet, mavlink_command_ack_t* out) {
    out->command = packet->of.ack.command;
    out->result = packet->of.ack.result;
    out->progress = packet->of.ack.result == MAV_RESULT_IN_PROGRESS ? UINT8_MAX : 0;
    out->result_param2 = packet->of.ack.detail;
    out->target_system = packet->target_sysid;
    out->target_component = packet->target_compid;
}

static void write_ftp(const ssv_packet_t* packet, mavlink_file_transfer_protocol_t* out) {
    const ssv_ftp_t* ftp = &packet->of.ftp;
    out->target_system = packet->target_sysid;
    out->target_component = packet->target_compid;
    ssv_put_u16(out->payload, ftp->sequence);
    out->payload[2] = ftp->session;
    out->payload[3] = ftp->opcode;
    out->payload[4] = ftp->size;
    out->payload[5] = ftp->request;
    out->payload[6] = ftp->last_of_burst;
    ssv_put_u32(out->payload + 8, ftp->offset);
    memcpy(out->payload + SSV_FTP_HEADER_BYTES, ftp->data, ftp->size);
}

static void write_attitude(const ssv_packet_t* packet, mavlink_attitude_quaternion_t* out) {
    float q[4], w[3];
    turn_quaternion(packet->of.pose.q_IS, q);
    turn_vector(packet->of.pose.w_IS_S_rad_s, w);
    out->time_boot_ms = packet->time_ms;
    out->q1 = q[0];
    out->q2 = q[1];
    out->q3 = q[2];
    out->q4 = q[3];
    out->rollspeed = w[0];
    out->pitchspeed = w[1];
    out->yawspeed = w[2];
}

static void write_position(const ssv_packet_t* packet, mavlink_local_position_ned_t* out) {
    float p[3], v[3];
    turn_vector(packet->of.pose.p_IS_m, p);
    turn_vector(packet->of.pose.v_IS_m_s, v);
    out->time_boot_ms = packet->time_ms;
    out->x = p[0];
    out->y = p[1];
    out->z = p[2];
    out->vx = v[0];
    out->vy = v[1];
    out->vz = v[2];
}

static void write_execution(const ssv_packet_t* packet, mavlink_ssv_execution_t* out) {
    const ssv_link_execution_t* execution = &packet->of.execution;
    out->time_boot_ms = packet->time_ms;
    out->boot_id = execution->boot_id;
    out->beat = execution->beat;
    out->live_hash = execution->live_hash;
    out->incoming_hash = execution->incoming_hash;
    out->plan_time = execution->plan_time_ns;
    out->segment = (uint16_t)execution->segment;
    out->phase = (uint8_t)execution->phase;
    out->reason = (uint8_t)execution->reason;
    out->events = execution->events;
    out->attempts = execution->attempts;
}

static void write_trim(const ssv_packet_t* packet, mavlink_ssv_trim_t* out) {
    out->target_system = packet->target_sysid;
    out->target_component = packet->target_compid;
    out->boot_id = packet->of.trim.boot_id;
    out->session = packet->of.trim.session;
    out->sequence = packet->of.trim.sequence;
    out->plan_time = packet->of.trim.plan_time_ns;
    out->clock_rate = packet->of.trim.clock_rate;
    memcpy(out->trim, packet->of.trim.trim_N, sizeof out->trim);
}

static void write_version(const ssv_packet_t* packet, mavlink_autopilot_version_t* out) {
    out->capabilities = MAV_PROTOCOL_CAPABILITY_MAVLINK2 | MAV_PROTOCOL_CAPABILITY_FTP |
                        MAV_PROTOCOL_CAPABILITY_COMMAND_INT | MAV_PROTOCOL_CAPABILITY_FLIGHT_TERMINATION;
    out->flight_sw_version = packet->of.version;
}

static void write_health(const ssv_packet_t* packet, mavlink_sys_status_t* out) {
    out->voltage_battery = UINT16_MAX; // not measured
    out->current_battery = -1;
    out->battery_remaining = -1;
    out->drop_rate_comm = packet->of.health.lost_permyriad;
    out->errors_comm = packet->of.health.bad_crc;
    out->errors_count1 = packet->of.health.lost;
    out->errors_count2 = packet->of.health.bad_crc;
    out->errors_count3 = packet->of.health.bad_signature;
    out->errors_count4 = packet->of.health.refused;
}

// Fills in the payload and returns the message's id.
static uint32_t write_payload(const ssv_packet_t* packet, payload_t* out) {
    memset(out, 0, sizeof *out);
    switch (packet->kind) {
        case SSV_PACKET_HEARTBEAT:
            out->heartbeat = (mavlink_heartbeat_t){packet->of.heartbeat.custom_mode, packet->of.heartbeat.type,
                                                   packet->of.heartbeat.autopilot,   packet->of.heartbeat.base_mode,
                                                   packet->of.heartbeat.status,      3};
            return MAVLINK_MSG_ID_HEARTBEAT;
        case SSV_PACKET_HEALTH: write_health(packet, &out->health); return MAVLINK_MSG_ID_SYS_STATUS;
        case SSV_PACKET_COMMAND: write_command(packet, &out->command); return MAVLINK_MSG_ID_COMMAND_INT;
        case SSV_PACKET_ACK: write_ack(packet, &out->ack); return MAVLINK_MSG_ID_COMMAND_ACK;
        case SSV_PACKET_ATTITUDE: write_attitude(packet, &out->attitude); return MAVLINK_MSG_ID_ATTITUDE_QUATERNION;
        case SSV_PACKET_POSITION: write_position(packet, &out->position); return MAVLINK_MSG_ID_LOCAL_POSITION_NED;
        case SSV_PACKET_THRUSTS:
            out->thrusts.time_usec = UINT64_C(1000) * packet->time_ms;
            out->thrusts.active = (1U << SSV_NUM_THRUSTERS) - 1;
            memcpy(out->thrusts.actuator, packet->of.u_N, sizeof packet->of.u_N);
            return MAVLINK_MSG_ID_ACTUATOR_OUTPUT_STATUS;
        case SSV_PACKET_TEXT:
            out->text.severity = packet->of.text.severity;
            memcpy(out->text.text, packet->of.text.text, sizeof out->text.text);
            return MAVLINK_MSG_ID_STATUSTEXT;
        case SSV_PACKET_TIMESYNC:
            out->timesync.tc1 = packet->of.timesync.ours_ns;
            out->timesync.ts1 = packet->of.timesync.theirs_ns;
            return MAVLINK_MSG_ID_TIMESYNC;
        case SSV_PACKET_PARAMETER:
            out->parameter.param_value = packet->of.parameter.value;
            out->parameter.param_count = (uint16_t)packet->of.parameter.count;
            out->parameter.param_index = (uint16_t)packet->of.parameter.index;
            out->parameter.param_type = MAV_PARAM_TYPE_REAL32;
            memcpy(out->parameter.param_id, packet->of.parameter.name, sizeof out->parameter.param_id);
            return MAVLINK_MSG_ID_PARAM_VALUE;
        case SSV_PACKET_VERSION: write_version(packet, &out->version); return MAVLINK_MSG_ID_AUTOPILOT_VERSION;
        case SSV_PACKET_EXECUTION: write_execution(packet, &out->execution); return MAVLINK_MSG_ID_SSV_EXECUTION;
        case SSV_PACKET_BEAT:
            out->beat = (mavlink_ssv_beat_t){packet->of.beat.boot_id, packet->of.beat.session, packet->of.beat.progress,
                                             packet->target_sysid, packet->target_compid};
            return MAVLINK_MSG_ID_SSV_BEAT;
        case SSV_PACKET_TRIM: write_trim(packet, &out->trim); return MAVLINK_MSG_ID_SSV_TRIM;
        default: // the requests that only tools make are never sent by either end
            write_ftp(packet, &out->ftp);
            return MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL;
    }
}

size_t ssv_wire_send(ssv_wire_t* wire, int64_t now_us, ssv_packet_t* packet, uint8_t* frame) {
    framing_t* framing = framing_of(wire, now_us);
    payload_t payload;
    if (packet->kind != SSV_PACKET_ATTITUDE && packet->kind != SSV_PACKET_POSITION)
        packet->time_ms = (uint32_t)(now_us / 1000);
    const uint32_t id = write_payload(packet, &payload);
    const mavlink_msg_entry_t* entry = mavlink_get_msg_entry(id);
    mavlink_message_t message;
    message.msgid = id & 0xffffff;
    memcpy(_MAV_PAYLOAD_NON_CONST(&message), &payload, entry->max_msg_len);
    mavlink_finalize_message_buffer(&message, wire->sysid, wire->compid, &framing->status, entry->min_msg_len,
                                    entry->max_msg_len, entry->crc_extra);
    wire->statistics.sent++;
    return mavlink_msg_to_send_buffer(frame, &message);
}
