// The vehicle's end of the link.
#include "link/bytes.h"
#include "link/server.h"
#include "link/timeline_file.h"

/// Numbers of MAVLink: type of vehicle, autopilot, modes, states, two requests.
enum {
    TYPE_SUBMARINE = 12,
    AUTOPILOT_GENERIC = 0,
    MODE_CUSTOM = 1,
    MODE_AUTO = 4,
    MODE_ARMED = 128,
    // Ground tools read the custom mode of a submarine as ArduSub's: these two are called so there and are no lies.
    CUSTOM_MODE_AUTO = 3,
    CUSTOM_MODE_MANUAL = 19,
    STATE_STANDBY = 3,
    STATE_ACTIVE = 4,
    STATE_CRITICAL = 5,
    COMMAND_SET_INTERVAL = 511,
    COMMAND_REQUEST_MESSAGE = 512,
    MESSAGE_VERSION = 148
};

/// [us] No message more often than so.
#define INTERVAL_MIN_US INT64_C(20000)

/// What is sent again and again; kind, message id, and the interval unless asked for another one. At 57,600 baud these
/// take a quarter of the line.
static const struct {
    ssv_packet_kind_t kind;
    uint16_t message_id;
    int64_t interval_us;
} streams[SSV_LINK_NUM_STREAMS] = {
    {SSV_PACKET_HEARTBEAT, 0, 1000000}, {SSV_PACKET_EXECUTION, 53000, 200000}, {SSV_PACKET_ATTITUDE, 31, 100000},
    {SSV_PACKET_POSITION, 32, 100000},  {SSV_PACKET_THRUSTS, 375, 500000},     {SSV_PACKET_HEALTH, 1, 1000000},
};

void ssv_link_vehicle_init(ssv_link_vehicle_t* link, const ssv_link_vehicle_config_t* config) {
    memset(link, 0, sizeof *link);
    link->config = *config;
    ssv_wire_init(&link->wire, config->sysid, config->compid, config->sign ? &config->signing : NULL);
    for (int i = 0; i < SSV_LINK_NUM_STREAMS; i++) {
        link->interval_us[i] = streams[i].interval_us;
        link->told_us[i] = -1;
    }
}

// ---- Texts and log --------------------------------------------------------------------------------------------------

static size_t append(char* text, size_t capacity, size_t length, const char* more) {
    while (*more != '\0' && length + 1 < capacity) text[length++] = *more++;
    text[length] = '\0';
    return length;
}

static size_t append_number(char* text, size_t capacity, size_t length, uint32_t number) {
    char digits[11];
    size_t at = sizeof digits - 1;
    digits[at] = '\0';
    do {
        digits[--at] = (char)('0' + number % 10);
        number /= 10;
    } while (number > 0);
    return append(text, capacity, length, digits + at);
}

// A line of milliseconds, severity and text; the oldest lines make room for it.
static void write_log(ssv_link_vehicle_t* link, int64_t now_us, ssv_link_severity_t severity, const char* text) {
    char line[SSV_LINK_TEXT_MAX + 32];
    size_t length = append_number(line, sizeof line, 0, (uint32_t)(now_us / 1000));
    length = append(line, sizeof line, length, " ");
    length = append_number(line, sizeof line, length, (uint32_t)severity);
    length = append(line, sizeof line, length, " ");
    length = append(line, sizeof line, length, text);
    length = append(line, sizeof line, length, "\n");
    if (link->log_length + length > sizeof link->log) {
        size_t cut = link->log_length + length - sizeof link->log;
        while (cut < link->log_length && link->log[cut - 1] != '\n') cut++;
        memmove(link->log, link->log + cut, link->log_length - cut);
        link->log_length = (uint16_t)(link->log_length - cut);
    }
    memcpy(link->log + link->log_length, line, length);
    link->log_length = (uint16_t)(link->log_length + length);
}

void ssv_link_vehicle_say(ssv_link_vehicle_t* link, int64_t now_us, ssv_link_severity_t severity, const char* text) {
    if (link->num_texts == SSV_LINK_MAX_TEXTS) {
        link->first_text = (link->first_text + 1) % SSV_LINK_MAX_TEXTS;
        link->num_texts--;
    }
    const int32_t at = (link->first_text + link->num_texts) % SSV_LINK_MAX_TEXTS;
    memset(link->text[at].text, 0, sizeof link->text[at].text);
    append(link->text[at].text, sizeof link->text[at].text, 0, text);
    link->text[at].severity = (uint8_t)severity;
    link->num_texts++;
    write_log(link, now_us, severity, link->text[at].text);
}

// ---- Timelines ------------------------------------------------------------------------------------------------------

static int64_t expiry_us(const ssv_link_vehicle_t* link, uint8_t which) {
    return link->begun_us[which] + INT64_C(1000) * ssv_get_u32(link->image[which] + AT_VALID_FOR);
}

static uint64_t hash_of(const ssv_link_vehicle_t* link, uint8_t which) {
    return link->length[which] >= SSV_TIMELINE_HEADER_BYTES ? ssv_get_u64(link->image[which] + AT_PLAN_HASH) : 0;
}

static uint64_t incoming_hash(const ssv_link_vehicle_t* link) {
    return link->incoming ? hash_of(link, link->live ^ 1) : 0;
}

const uint8_t* ssv_link_vehicle_live(const ssv_link_vehicle_t* link, int64_t* expires_us) {
    if (link->length[link->live] == 0) return NULL;
    if (expires_us != NULL) *expires_us = expiry_us(link, link->live);
    return link->image[link->live];
}

// Whether the vehicle is where the timeline starts. Half the angle between two attitudes has the length of the vector
// part of one's quaternion times the other's conjugate as its sine.
static bool is_at_start(const ssv_link_vehicle_t* link, const ssv_link_pose_t* pose, const uint8_t* file) {
    float square_m2 = 0, a[4], sine_square = 0;
    if (!pose->known) return false;
    for (int i = 0; i < 3; i++) {
        const float apart_m = pose->p_IS_m[i] - ssv_get_f32(file + AT_P_IS + 4 * i);
        square_m2 += apart_m * apart_m;
    }
    for (int i = 0; i < 4; i++) a[i] = ssv_get_f32(file + AT_Q_IS + 4 * i);
    const float* b = pose->q_IS;
    const float vector[3] = {a[0] * b[1] - a[1] * b[0] - a[2] * b[3] + a[3] * b[2],
                             a[0] * b[2] + a[1] * b[3] - a[2] * b[0] - a[3] * b[1],
                             a[0] * b[3] - a[1] * b[2] + a[2] * b[1] - a[3] * b[0]};
    for (int i = 0; i < 3; i++) sine_square += vector[i] * vector[i];
    const float half_rad = link->config.start_tolerance_rad / 2;
    return square_m2 <= link->config.start_tolerance_m * link->config.start_tolerance_m &&
           sine_square <= half_rad * half_rad;
}

static ssv_timeline_fault_t check_incoming(const ssv_link_vehicle_t* link, int64_t now_us,
                                           const ssv_link_vehicle_state_t* state, uint64_t plan_hash) {
    const uint8_t incoming = link->live ^ 1;
    const uint8_t* file = link->image[incoming];
    ssv_timeline_fault_t found = ssv_timeline_check(file, link->length[incoming]);
    if (found.reason != SSV_LINK_NO_REASON) return found;
    if (ssv_get_u64(file + AT_PLAN_HASH) != plan_hash)
        found.reason = SSV_LINK_PLAN_HASH;
    else if (ssv_get_i64(file + AT_EPOCH) < link->epoch_us)
        found.reason = SSV_LINK_EPOCH;
    else if (now_us > expiry_us(link, incoming))
        found.reason = SSV_LINK_EXPIRY;
    else if (ssv_get_u32(file + AT_MASS_CONFIGURATION) != link->config.mass_configuration)
        found.reason = SSV_LINK_MASS_CONFIGURATION;
    else if (ssv_get_f32(file + AT_U_MAX) > link->config.force_max_N)
        found.reason = SSV_LINK_FORCE;
    else if (!is_at_start(link, &state->pose, file))
        found.reason = SSV_LINK_START_POSE;
    return found;
}

// ---- Commands -------------------------------------------------------------------------------------------------------

static void acknowledge(ssv_link_vehicle_t* link, uint8_t sysid, uint8_t compid, uint16_t command,
                        ssv_link_result_t result, int32_t detail) {
    const int32_t room = (int32_t)(sizeof link->ack / sizeof *link->ack);
    if (link->num_acks == room) return; // as if the answer were lost: the command comes again
    link->ack[(link->first_ack + link->num_acks) % room] =
        (ssv_link_ack_t){sysid, compid, (uint8_t)result, command, detail};
    link->num_acks++;
}

void ssv_link_vehicle_answer(ssv_link_vehicle_t* link, const ssv_link_vehicle_event_t* event, ssv_link_result_t result,
                             ssv_link_reason_t reason) {
    acknowledge(link, event->sysid, event->compid, (uint16_t)event->of.command.command, result, (int32_t)reason);
}

// The answer to a commit. A commit of what is live already is one whose answer was lost.
static ssv_link_result_t commit(ssv_link_vehicle_t* link, int64_t now_us, const ssv_link_vehicle_state_t* state,
                                uint64_t plan_hash, ssv_timeline_fault_t* found, bool* swapped) {
    const uint8_t incoming = link->live ^ 1;
    *found = (ssv_timeline_fault_t){SSV_LINK_NO_REASON, 0};
    if (!link->incoming) {
        if (plan_hash != 0 && hash_of(link, link->live) == plan_hash) return SSV_LINK_ACCEPTED;
        found->reason = SSV_LINK_NOTHING;
        return SSV_LINK_DENIED;
    }
    if (!state->may_swap) {
        found->reason = SSV_LINK_BUSY;
        return SSV_LINK_TEMPORARILY_REJECTED;
    }
    *found = check_incoming(link, now_us, state, plan_hash);
    if (found->reason != SSV_LINK_NO_REASON) {
        ssv_link_vehicle_say(link, now_us, SSV_LINK_WARNING, ssv_link_reason_str(found->reason));
        return SSV_LINK_DENIED;
    }
    ssv_server_close(&link->server);
    link->epoch_us = ssv_get_i64(link->image[incoming] + AT_EPOCH);
    link->live = incoming;
    link->incoming = false;
    *swapped = true;
    ssv_link_vehicle_say(link, now_us, SSV_LINK_INFO, "timeline committed");
    return SSV_LINK_ACCEPTED;
}

static ssv_link_reason_t check_start(const ssv_link_vehicle_t* link, int64_t now_us,
                                     const ssv_link_vehicle_state_t* state, uint64_t plan_hash) {
    if (link->length[link->live] == 0) return SSV_LINK_NOTHING;
    if (hash_of(link, link->live) != plan_hash) return SSV_LINK_PLAN_HASH;
    // A start that comes again finds the execution under way, which does not expire.
    const bool is_under_way = state->phase == SSV_LINK_EXECUTING || state->phase == SSV_LINK_HOLDING;
    return !is_under_way && now_us > expiry_us(link, link->live) ? SSV_LINK_EXPIRY : SSV_LINK_NO_REASON;
}

static int stream_of(float message_id) {
    for (int i = 0; i < SSV_LINK_NUM_STREAMS; i++) {
        if (message_id == (float)streams[i].message_id) return i;
    }
    return -1;
}

static ssv_link_result_t set_interval(ssv_link_vehicle_t* link, int64_t now_us, const float parameter[4]) {
    const int i = stream_of(parameter[0]);
    if (i < 0) return SSV_LINK_UNSUPPORTED;
    if (streams[i].kind == SSV_PACKET_HEARTBEAT || !(parameter[1] >= -1 && parameter[1] <= 1e9F))
        return SSV_LINK_DENIED;
    int64_t interval_us = (int32_t)parameter[1];
    if (interval_us == 0)
        interval_us = streams[i].interval_us;
    else if (interval_us > 0 && interval_us < INTERVAL_MIN_US)
        interval_us = INTERVAL_MIN_US;
    link->interval_us[i] = interval_us;
    link->due_us[i] = now_us;
    return SSV_LINK_ACCEPTED;
}

static ssv_link_result_t request_message(ssv_link_vehicle_t* link, int64_t now_us, const float parameter[4]) {
    const int i = stream_of(parameter[0]);
    if (parameter[0] == (float)MESSAGE_VERSION)
        link->want_version = true;
    else if (i >= 0 && link->interval_us[i] >= 0)
        link->due_us[i] = now_us;
    else
        return SSV_LINK_UNSUPPORTED;
    return SSV_LINK_ACCEPTED;
}

// Fills in the event of a command that the vehicle itself must judge.
static ssv_link_result_t ask_vehicle(const ssv_packet_t* packet, uint64_t plan_hash, ssv_link_vehicle_event_t* event) {
    const float value = packet->of.command.parameter[0];
    if (packet->of.command.command != SSV_LINK_START && value != 0 && value != 1) return SSV_LINK_DENIED;
    if (packet->of.command.command == SSV_LINK_TERMINATE && value != 1) return SSV_LINK_DENIED;
    event->kind = SSV_LINK_VEHICLE_COMMANDED;
    event->of.command.command = (ssv_link_command_t)packet->of.command.command;
    event->of.command.value = value == 1;
    event->of.command.plan_hash = plan_hash;
    return SSV_LINK_IN_PROGRESS;
}

static void take_command(ssv_link_vehicle_t* link, int64_t now_us, const ssv_link_vehicle_state_t* state,
                         const ssv_packet_t* packet, ssv_link_vehicle_event_t* event) {
    const uint16_t command = packet->of.command.command;
    const uint64_t plan_hash = packet->of.command.x | (uint64_t)packet->of.command.y << 32;
    const float* parameter = packet->of.command.parameter;
    ssv_timeline_fault_t found = {SSV_LINK_NO_REASON, 0};
    ssv_link_result_t result = SSV_LINK_UNSUPPORTED;
    bool swapped = false;
    switch (command) {
        case SSV_LINK_COMMIT:
            result = packet->of.command.is_long ? SSV_LINK_COMMAND_INT_ONLY
                                                : commit(link, now_us, state, plan_hash, &found, &swapped);
            break;
        case SSV_LINK_START:
            found.reason = check_start(link, now_us, state, plan_hash);
            if (packet->of.command.is_long)
                result = SSV_LINK_COMMAND_INT_ONLY;
            else
                result = found.reason != SSV_LINK_NO_REASON ? SSV_LINK_DENIED : ask_vehicle(packet, plan_hash, event);
            break;
        case SSV_LINK_DROP:
            if (link->server.open && link->incoming) ssv_server_close(&link->server);
            link->incoming = false;
            result = SSV_LINK_ACCEPTED;
            break;
        case SSV_LINK_ARM:
        case SSV_LINK_PAUSE_CONTINUE:
        case SSV_LINK_TERMINATE: result = ask_vehicle(packet, 0, event); break;
        case COMMAND_SET_INTERVAL: result = set_interval(link, now_us, parameter); break;
        case COMMAND_REQUEST_MESSAGE: result = request_message(link, now_us, parameter); break;
        default: break;
    }
    if (swapped) event->kind = SSV_LINK_VEHICLE_COMMITTED;
    if (event->kind != SSV_LINK_VEHICLE_COMMANDED)
        acknowledge(link, packet->sysid, packet->compid, command, result,
                    (int32_t)found.reason | (int32_t)((uint32_t)found.index << 8));
}

// ---- The rest of what arrives ---------------------------------------------------------------------------------------

static int32_t parameter_of(const ssv_link_vehicle_t* link, const ssv_packet_t* packet) {
    if (packet->of.parameter.index >= 0)
        return packet->of.parameter.index < link->config.num_parameters ? packet->of.parameter.index : -1;
    for (int32_t i = 0; i < link->config.num_parameters; i++) {
        if (strcmp(link->config.parameters[i].name, packet->of.parameter.name) == 0) return i;
    }
    return -1;
}

// Any request is answered by values; one to set a value, too, for that is how tools learn that it stayed.
static void take_parameter(ssv_link_vehicle_t* link, const ssv_packet_t* packet) {
    if (packet->kind == SSV_PACKET_PARAMETER_LIST) {
        link->next_parameter = 0;
        link->end_parameter = link->config.num_parameters;
        return;
    }
    const int32_t i = parameter_of(link, packet);
    if (i < 0 || link->next_parameter < link->end_parameter)
        return; // unknown, or a list is on its way that has it, too
    link->next_parameter = i;
    link->end_parameter = i + 1;
}

static void take(ssv_link_vehicle_t* link, int64_t now_us, const ssv_link_vehicle_state_t* state,
                 const ssv_packet_t* packet, ssv_link_vehicle_event_t* event) {
    switch (packet->kind) {
        case SSV_PACKET_COMMAND: take_command(link, now_us, state, packet, event); break;
        case SSV_PACKET_FTP: ssv_server_request(link, now_us, packet); break;
        case SSV_PACKET_PARAMETER_LIST:
        case SSV_PACKET_PARAMETER_READ:
        case SSV_PACKET_PARAMETER_SET: take_parameter(link, packet); break;
        case SSV_PACKET_TIMESYNC:
            if (packet->of.timesync.ours_ns == 0) {
                link->want_timesync = true;
                link->timesync_ns = packet->of.timesync.theirs_ns;
            }
            break;
        case SSV_PACKET_BEAT:
            event->kind = SSV_LINK_VEHICLE_BEAT;
            event->of.beat = packet->of.beat;
            break;
        case SSV_PACKET_TRIM:
            event->kind = SSV_LINK_VEHICLE_TRIM;
            event->of.trim = packet->of.trim;
            break;
        default: break;
    }
}

size_t ssv_link_vehicle_receive(ssv_link_vehicle_t* link, int64_t now_us, const ssv_link_vehicle_state_t* state,
                                const uint8_t* bytes, size_t num_bytes, ssv_link_vehicle_event_t* event) {
    ssv_packet_t packet;
    size_t taken = 0;
    event->kind = SSV_LINK_VEHICLE_NOTHING;
    for (;;) {
        while (ssv_wire_next(&link->wire, now_us, &packet)) {
            take(link, now_us, state, &packet, event);
            if (event->kind != SSV_LINK_VEHICLE_NOTHING) {
                event->sysid = packet.sysid;
                event->compid = packet.compid;
                return taken;
            }
        }
        if (taken == num_bytes) return taken;
        ssv_wire_take(&link->wire, bytes[taken++]);
    }
}

// ---- Sending --------------------------------------------------------------------------------------------------------

static void tell_heartbeat(const ssv_link_vehicle_state_t* state, ssv_packet_t* packet) {
    const bool is_armed = state->phase != SSV_LINK_DISARMED;
    const bool is_auto = state->phase == SSV_LINK_EXECUTING || state->phase == SSV_LINK_HOLDING;
    const bool is_critical = state->phase == SSV_LINK_BRAKING || state->phase == SSV_LINK_STOPPED;
    packet->of.heartbeat.type = TYPE_SUBMARINE;
    packet->of.heartbeat.autopilot = AUTOPILOT_GENERIC;
    packet->of.heartbeat.base_mode = (uint8_t)(MODE_CUSTOM | (is_armed ? MODE_ARMED : 0) | (is_auto ? MODE_AUTO : 0));
    packet->of.heartbeat.custom_mode = is_auto ? CUSTOM_MODE_AUTO : CUSTOM_MODE_MANUAL;
    packet->of.heartbeat.status = is_critical ? STATE_CRITICAL : is_armed ? STATE_ACTIVE : STATE_STANDBY;
}

static uint16_t clip(uint32_t count) { return count < UINT16_MAX ? (uint16_t)count : UINT16_MAX; }

static void tell_health(const ssv_link_statistics_t* statistics, ssv_packet_t* packet) {
    const uint64_t all = (uint64_t)statistics->received + statistics->lost;
    packet->of.health.lost_permyriad = (uint16_t)(all == 0 ? 0 : UINT64_C(10000) * statistics->lost / all);
    packet->of.health.lost = clip(statistics->lost);
    packet->of.health.bad_crc = clip(statistics->bad_crc);
    packet->of.health.bad_signature = clip(statistics->bad_signature);
    packet->of.health.refused = clip(statistics->refused_streams + statistics->refused_signing_setup);
}

static void tell_execution(const ssv_link_vehicle_t* link, const ssv_link_vehicle_state_t* state,
                           ssv_packet_t* packet) {
    ssv_link_execution_t* execution = &packet->of.execution;
    execution->boot_id = link->config.boot_id;
    execution->beat = state->beat;
    execution->live_hash = hash_of(link, link->live);
    execution->incoming_hash = incoming_hash(link);
    execution->plan_time_ns = state->plan_time_ns;
    execution->segment = state->segment;
    execution->phase = state->phase;
    execution->reason = state->reason;
    execution->events = state->events;
    execution->attempts = state->attempts;
}

static void tell(const ssv_link_vehicle_t* link, const ssv_link_vehicle_state_t* state, ssv_packet_t* packet) {
    switch (packet->kind) {
        case SSV_PACKET_HEARTBEAT: tell_heartbeat(state, packet); break;
        case SSV_PACKET_EXECUTION: tell_execution(link, state, packet); break;
        case SSV_PACKET_HEALTH: tell_health(&link->wire.statistics, packet); break;
        case SSV_PACKET_THRUSTS: memcpy(packet->of.u_N, state->u_N, sizeof packet->of.u_N); break;
        default:
            packet->of.pose = state->pose;
            packet->time_ms = (uint32_t)(state->pose_us / 1000);
            break;
    }
}

// A pose is told once: what is told again would be taken for another measurement.
static bool is_due(const ssv_link_vehicle_t* link, int64_t now_us, const ssv_link_vehicle_state_t* state, int stream) {
    const bool is_pose = streams[stream].kind == SSV_PACKET_ATTITUDE || streams[stream].kind == SSV_PACKET_POSITION;
    if (is_pose && (!state->pose.known || state->pose_us == link->told_us[stream])) return false;
    return link->interval_us[stream] >= 0 && now_us >= link->due_us[stream];
}

static bool poll_stream(ssv_link_vehicle_t* link, int64_t now_us, const ssv_link_vehicle_state_t* state,
                        ssv_packet_t* packet) {
    for (int i = 0; i < SSV_LINK_NUM_STREAMS; i++) {
        if (!is_due(link, now_us, state, i)) continue;
        link->told_us[i] = state->pose_us;
        link->due_us[i] += link->interval_us[i];
        if (link->due_us[i] <= now_us) // it fell behind: no burst to catch up
            link->due_us[i] = now_us + link->interval_us[i];
        packet->kind = streams[i].kind;
        tell(link, state, packet);
        return true;
    }
    return false;
}

static bool poll_ack(ssv_link_vehicle_t* link, ssv_packet_t* packet) {
    if (link->num_acks == 0) return false;
    const ssv_link_ack_t* ack = &link->ack[link->first_ack];
    packet->kind = SSV_PACKET_ACK;
    packet->target_sysid = ack->sysid;
    packet->target_compid = ack->compid;
    packet->of.ack.command = ack->command;
    packet->of.ack.result = ack->result;
    packet->of.ack.detail = ack->detail;
    link->first_ack = (link->first_ack + 1) % (int32_t)(sizeof link->ack / sizeof *link->ack);
    link->num_acks--;
    return true;
}

static bool poll_request(ssv_link_vehicle_t* link, int64_t now_us, ssv_packet_t* packet) {
    if (link->want_timesync) {
        link->want_timesync = false;
        packet->kind = SSV_PACKET_TIMESYNC;
        packet->of.timesync.theirs_ns = link->timesync_ns;
        packet->of.timesync.ours_ns = 1000 * now_us + 1; // 0 would be a question
    } else if (link->want_version) {
        link->want_version = false;
        packet->kind = SSV_PACKET_VERSION;
        packet->of.version = link->config.version;
    } else if (link->num_texts > 0) {
        packet->kind = SSV_PACKET_TEXT;
        packet->of.text.severity = link->text[link->first_text].severity;
        memcpy(packet->of.text.text, link->text[link->first_text].text, sizeof packet->of.text.text);
        link->first_text = (link->first_text + 1) % SSV_LINK_MAX_TEXTS;
        link->num_texts--;
    } else if (link->next_parameter < link->end_parameter) {
        const ssv_link_parameter_t* parameter = &link->config.parameters[link->next_parameter];
        packet->kind = SSV_PACKET_PARAMETER;
        packet->of.parameter.index = link->next_parameter++;
        packet->of.parameter.count = link->config.num_parameters;
        packet->of.parameter.value = parameter->value;
        memcpy(packet->of.parameter.name, parameter->name, sizeof packet->of.parameter.name);
    } else {
        return false;
    }
    return true;
}

static bool poll_file(ssv_link_vehicle_t* link, int64_t now_us, ssv_packet_t* packet) {
    link->served = ssv_server_poll(link, now_us, packet);
    return link->served;
}

size_t ssv_link_vehicle_poll(ssv_link_vehicle_t* link, int64_t now_us, const ssv_link_vehicle_state_t* state,
                             uint8_t* frame) {
    ssv_packet_t packet;
    packet.target_sysid = packet.target_compid = 0;
    // Files and the rest take turns, so that neither keeps the other from being heard.
    const bool files_first = !link->served;
    link->served = false;
    if (poll_ack(link, &packet) || (files_first && poll_file(link, now_us, &packet)) ||
        poll_stream(link, now_us, state, &packet) || poll_request(link, now_us, &packet) ||
        poll_file(link, now_us, &packet))
        return ssv_wire_send(&link->wire, now_us, &packet, frame);
    return 0;
}
