// Fuzzes both ends of the link. The input is a list of frames, which get the right checksum, so that what is behind the
// checksum is reached: any message with any payload, requests of the file transfer with the paths and the session that
// there are, commands with the plan hashes that there are, and bytes as they stand. Time goes on between them. Whatever
// comes, what is live is sound.
#include <string.h>

#define MAVLINK_NO_CONVERSION_HELPERS
#include "check.h"
#include "link/bytes.h"
#include "link/timeline_file.h"
#include "ssv/link.h"
#include "ssv/mavlink.h"

#define MAX_STEPS 200

static ssv_link_vehicle_t vehicle;
static ssv_link_vehicle_state_t state;
static ssv_link_planner_t planner;
static uint8_t file[SSV_TIMELINE_FILE_BYTES_MAX];
static int64_t now_us;

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

static const uint32_t ids[] = {MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL,
                               MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL,
                               MAVLINK_MSG_ID_COMMAND_INT,
                               MAVLINK_MSG_ID_COMMAND_LONG,
                               MAVLINK_MSG_ID_COMMAND_ACK,
                               MAVLINK_MSG_ID_PARAM_REQUEST_READ,
                               MAVLINK_MSG_ID_PARAM_REQUEST_LIST,
                               MAVLINK_MSG_ID_PARAM_SET,
                               MAVLINK_MSG_ID_TIMESYNC,
                               MAVLINK_MSG_ID_SSV_BEAT,
                               MAVLINK_MSG_ID_SSV_TRIM,
                               MAVLINK_MSG_ID_SSV_EXECUTION,
                               MAVLINK_MSG_ID_HEARTBEAT,
                               MAVLINK_MSG_ID_SYS_STATUS,
                               MAVLINK_MSG_ID_STATUSTEXT,
                               MAVLINK_MSG_ID_ACTUATOR_OUTPUT_STATUS,
                               MAVLINK_MSG_ID_ATTITUDE_QUATERNION,
                               MAVLINK_MSG_ID_LOCAL_POSITION_NED,
                               MAVLINK_MSG_ID_SETUP_SIGNING,
                               MAVLINK_MSG_ID_ODOMETRY};

/// Kinds of steps, of STEP_KINDS: below the first a message of any kind, then requests, commands, bytes.
enum { FIRST_REQUEST = 5, FIRST_COMMAND = 11, BYTES = 15, STEP_KINDS = 16 };

static void begin(void) {
    static const ssv_link_parameter_t parameters[] = {{"A", 1}, {"B", 2}};
    const ssv_link_vehicle_config_t config = {.sysid = 1,
                                              .compid = 1,
                                              .boot_id = 1,
                                              .parameters = parameters,
                                              .num_parameters = 2,
                                              .mass_configuration = 7,
                                              .force_max_N = 6,
                                              .start_tolerance_m = 1,
                                              .start_tolerance_rad = 1};
    const ssv_link_planner_config_t own = {
        .sysid = 1, .compid = 195, .vehicle_sysid = 1, .vehicle_compid = 1, .boot_id = 1, .chunk_bytes = 64};
    ssv_link_vehicle_init(&vehicle, &config);
    ssv_link_planner_init(&planner, &own);
    state = (ssv_link_vehicle_state_t){.may_swap = true, .pose = {.known = true, .q_IS = {1, 0, 0, 0}}};
    now_us = 0;
    const ssv_timeline_stamp_t stamp = {1, 1000000};
    static ssv_timeline_t timeline;
    timeline = (ssv_timeline_t){
        .plan_hash = 1, .mass_configuration = 7, .u_max_N = 6, .q_IS = {1, 0, 0, 0}, .num_segments = 3};
    for (int i = 0; i < 3; i++) timeline.segment[i].duration_ns = 1;
    ssv_link_planner_upload(&planner, file, ssv_timeline_encode(&timeline, &stamp, file, sizeof file));
    ssv_link_planner_command(&planner, 0, SSV_LINK_COMMIT, 0, 1);
}

static void check_vehicle(void) {
    const uint8_t* live = ssv_link_vehicle_live(&vehicle, NULL);
    if (live != NULL) check(ssv_timeline_check(live, vehicle.length[vehicle.live]).reason == SSV_LINK_NO_REASON);
    check(vehicle.server.num_answers <= SSV_LINK_MAX_ANSWERS && vehicle.log_length <= SSV_LINK_LOG_BYTES);
}

static void to_vehicle(const uint8_t* bytes, size_t length) {
    for (size_t at = 0; at < length;) {
        ssv_link_vehicle_event_t event;
        const size_t took = ssv_link_vehicle_receive(&vehicle, now_us, &state, bytes + at, length - at, &event);
        check((took > 0 || event.kind != 0) && took <= length - at);
        at += took;
        if (event.kind == SSV_LINK_VEHICLE_COMMANDED)
            ssv_link_vehicle_answer(&vehicle, &event, SSV_LINK_ACCEPTED, SSV_LINK_NO_REASON);
    }
}

// Names are looked up by these numbers, and texts are read up to their zero.
static void check_event(const ssv_link_planner_event_t* event) {
    switch (event->kind) {
        case SSV_LINK_PLANNER_EXECUTION:
            check(event->of.execution.phase <= SSV_LINK_DONE && event->of.execution.reason < SSV_LINK_NUM_REASONS);
            break;
        case SSV_LINK_PLANNER_TEXT: check(memchr(event->of.text.text, 0, sizeof event->of.text.text) != NULL); break;
        case SSV_LINK_PLANNER_ANSWERED: check(event->of.answer.reason < SSV_LINK_NUM_REASONS); break;
        case SSV_LINK_PLANNER_UPLOAD_FAILED: check(event->of.upload < SSV_LINK_NUM_REASONS); break;
        default: break;
    }
}

static void to_planner(const uint8_t* bytes, size_t length) {
    for (size_t at = 0; at < length;) {
        ssv_link_planner_event_t event;
        const size_t took = ssv_link_planner_receive(&planner, now_us, bytes + at, length - at, &event);
        check((took > 0 || event.kind != 0) && took <= length - at);
        at += took;
        check_event(&event);
    }
}

// What the two ends say to one another, too; each frame must be one that the other takes without complaint.
static void talk(void) {
    uint8_t frame[SSV_LINK_FRAME_BYTES_MAX];
    for (int k = 0; k < 8; k++) {
        size_t length = ssv_link_vehicle_poll(&vehicle, now_us, &state, frame);
        check(length <= sizeof frame);
        to_planner(frame, length);
        length = ssv_link_planner_poll(&planner, now_us, frame);
        check(length <= sizeof frame);
        to_vehicle(frame, length);
    }
}

// The frame of a message with this payload, from somebody or from one of the ends.
static size_t make_frame(uint8_t from, uint32_t id, const uint8_t* payload, uint8_t length, uint8_t* frame) {
    static mavlink_status_t status;
    const mavlink_msg_entry_t* entry = mavlink_get_msg_entry(id);
    mavlink_message_t message;
    memset(&message, 0, sizeof message);
    message.msgid = id & 0xffffff;
    memcpy(_MAV_PAYLOAD_NON_CONST(&message), payload, length);
    mavlink_finalize_message_buffer(&message, from % 3 == 0 ? 255 : 1,
                                    from % 3 == 1   ? 1
                                    : from % 3 == 2 ? 195
                                                    : 190,
                                    &status, entry->min_msg_len, entry->max_msg_len, entry->crc_extra);
    return mavlink_msg_to_send_buffer(frame, &message);
}

// Makes a request of the file transfer out of the payload's first bytes; the rest is the data. Most requests are of the
// kinds that move a file, and from whoever has the session, for only those get past its checks.
static size_t make_request(uint8_t from, const uint8_t* payload, uint8_t* frame) {
    static const char* const paths[] = {"/plan/incoming", "/plan/live", "/plan/header", "/log/events"};
    static const uint8_t common[] = {4, 5, 6, 7, 15, 4, 5, 7, 15, 11, 14, 1};
    mavlink_file_transfer_protocol_t out = {.target_system = 1, .target_component = 1};
    const uint8_t kind = payload[1] % 16, opcode = kind < sizeof common ? common[kind] : payload[2] % 16;
    if (vehicle.server.open && payload[3] % 8 < 5) from = vehicle.server.compid == 195 ? 2 : 0;
    memcpy(out.payload + 8, payload + 4, sizeof out.payload - 8 < 243 ? sizeof out.payload - 8 : 243);
    out.payload[0] = payload[0];
    out.payload[2] = (uint8_t)(vehicle.server.session + (payload[3] % 8 == 7));
    out.payload[3] = opcode;
    out.payload[4] = payload[2];
    const bool has_path = opcode == 4 || opcode == 6 || opcode == 11 || opcode == 14;
    if (has_path && payload[3] % 8 != 6) {
        const char* path = paths[payload[2] % 4];
        out.payload[4] = (uint8_t)strlen(path);
        memcpy(out.payload + 12, path, strlen(path));
    }
    return make_frame(from, MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL, (const uint8_t*)&out, 254, frame);
}

static size_t make_command(uint8_t from, const uint8_t* payload, uint8_t* frame) {
    static const uint16_t commands[] = {185, 193, 400, 511, 512, 31010, 31011, 31012};
    mavlink_command_int_t out = {.target_system = 1, .target_component = 1, .command = commands[payload[0] % 8]};
    const uint64_t plan_hash = payload[1] % 2 == 0 ? 1 : ssv_get_u64(vehicle.image[vehicle.live ^ 1] + AT_PLAN_HASH);
    memcpy(&out.param1, payload + 2, 4);
    if (payload[1] % 4 < 2) out.param1 = (float)(payload[2] % 3);
    out.x = (int32_t)(uint32_t)plan_hash;
    out.y = (int32_t)(plan_hash >> 32);
    return make_frame(from, MAVLINK_MSG_ID_COMMAND_INT, (const uint8_t*)&out, sizeof out, frame);
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    begin();
    for (int step = 0; step < MAX_STEPS && size >= 5; step++) {
        const uint8_t kind = data[0], from = data[1], wait = data[2], id = data[3];
        uint8_t length = data[4], payload[255] = {0}, frame[SSV_LINK_FRAME_BYTES_MAX];
        data += 5;
        size -= 5;
        if (length > size) length = (uint8_t)size;
        memcpy(payload, data, length);
        data += length;
        size -= length;
        // Mostly a while in which nothing is over yet.
        now_us += wait % 8 == 7 ? INT64_C(20000) * wait * wait : INT64_C(1000) * wait;
        size_t num_bytes = length;
        if (kind % STEP_KINDS == BYTES)
            memcpy(frame, payload, length);
        else if (kind % STEP_KINDS >= FIRST_COMMAND)
            num_bytes = make_command(from, payload, frame);
        else if (kind % STEP_KINDS >= FIRST_REQUEST)
            num_bytes = make_request(from, payload, frame);
        else
            num_bytes = make_frame(from, ids[id % (sizeof ids / sizeof *ids)], payload, length, frame);
        to_vehicle(frame, num_bytes);
        to_planner(frame, num_bytes);
        if ((kind & 0x10) != 0) talk();
        check_vehicle();
    }
    return 0;
}
