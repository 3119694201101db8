// Fuzzes the whole controller: bytes in, ticks, navigation with any floats, outcomes of attempts at any time. The input
// is a list of steps. Frames are made by the link's own sender, so their checksums are right, and timelines travel by
// the planner's end, so that flights, misses, brakes and dead links are common. After every step the controller must be
// in a phase that may follow, and whatever thrusts must be armed, within its limits, and heard from by its planner: a
// second bookkeeping of the beats, made where they are sent, says until when.
#include <math.h>
#include <string.h>

#include "check.h"
#include "link/wire.h"
#include "ssv/vehicle.h"

#define MAX_STEPS 150
#define MAX_TICKS 800 // of a step
#define MAX_SEGMENTS 6
#define BEAT_EVERY_TICKS 40
#define NAVIGATE_EVERY_TICKS 20
#define DRAIN_EVERY_TICKS 10
#define HULL_M 0.3025 // lever of the thrusters of ssv_vehicle_config_default

enum { PLANNER, STRANGER, NUM_SENDERS };
enum { NO_BEATS, BEATS, FROZEN_BEATS, NUM_BEATS };
enum { TICKS, UPLOAD, COMMAND, BEAT, TRIM, NAVIGATE, SUPPLY, ATTEMPTED, FILE_REQUEST, BYTES, PREPARED, NUM_STEPS };

static ssv_vehicle_config_t config;
static ssv_controller_t vehicle;
static ssv_vehicle_output_t output;
static ssv_link_planner_t planner;
static ssv_wire_t sender[NUM_SENDERS];
static int64_t now_us;
static uint64_t plan_hash; ///< of the timeline that was uploaded last
static ssv_link_beat_t beat[NUM_SENDERS];
static int64_t beat_us[NUM_SENDERS]; ///< when the sender's last beat was sent
static uint32_t trim_sequence;
static int beating;        ///< what the planner sends while ticks pass
static bool navigates;     ///< whether navigation comes while ticks pass
static int64_t braking_us; ///< the last moment before it braked
static ssv_link_pose_t pose;
/// Whose beats keep the flight alive, and when the last one did that may.
static struct {
    int from;
    ssv_link_beat_t beat;
    int64_t grew_us;
} bound;

static const uint8_t* input;
static size_t input_left;

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

static uint8_t byte(void) {
    if (input_left == 0) return 0;
    input_left--;
    return *input++;
}

static uint32_t word(void) {
    uint32_t bits = 0;
    for (int i = 0; i < 4; i++) bits = bits << 8 | byte();
    return bits;
}

static float any_float(void) {
    const uint32_t bits = word();
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

// In [-size, size].
static float number(float size) { return size * ((float)byte() - 128) / 128; }

// ---- What must hold -------------------------------------------------------------------------------------------------

#define TO(phase) (1U << SSV_LINK_##phase)
/// What one command may make of a phase, and what a tick may.
static const unsigned by_command[] = {
    [SSV_LINK_DISARMED] = TO(READY),
    [SSV_LINK_READY] = TO(DISARMED) | TO(EXECUTING) | TO(BRAKING),
    [SSV_LINK_EXECUTING] = TO(DISARMED) | TO(HOLDING) | TO(BRAKING),
    [SSV_LINK_HOLDING] = TO(DISARMED) | TO(EXECUTING) | TO(BRAKING),
    [SSV_LINK_BRAKING] = TO(DISARMED),
    [SSV_LINK_STOPPED] = TO(DISARMED),
    [SSV_LINK_DONE] = TO(DISARMED) | TO(READY) | TO(EXECUTING) | TO(BRAKING),
};
static const unsigned by_tick[] = {
    [SSV_LINK_EXECUTING] = TO(HOLDING) | TO(BRAKING) | TO(STOPPED) | TO(DONE),
    [SSV_LINK_HOLDING] = TO(BRAKING) | TO(STOPPED),
    [SSV_LINK_BRAKING] = TO(STOPPED),
    [SSV_LINK_DONE] = 0,
};

static void check_change(const unsigned* by, ssv_link_phase_t from) {
    const ssv_link_phase_t to = vehicle.state.phase;
    check(to == from || (by[from] >> to & 1) != 0);
}

static bool is_flying(ssv_link_phase_t phase) { return phase == SSV_LINK_EXECUTING || phase == SSV_LINK_HOLDING; }

// The power of the thrusts is not positive: a brake takes energy from any motion. Force along axis i is the difference
// of pair i, moment about the next axis its sum times the hull's radius.
static void check_brake(void) {
    const float* q = vehicle.state.pose.q_IS;
    const float* v = vehicle.state.pose.v_IS_m_s;
    const double w = q[0], x = q[1], y = q[2], z = q[3], n = w * w + x * x + y * y + z * z;
    const double R_IS[3][3] = {{n - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                               {2 * (x * y + w * z), n - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                               {2 * (x * z - w * y), 2 * (y * z + w * x), n - 2 * (x * x + y * y)}};
    double power_W = 0, size_W = 0;
    for (int i = 0; i < 3; i++) {
        const double v_S_m_s = (R_IS[0][i] * v[0] + R_IS[1][i] * v[1] + R_IS[2][i] * v[2]) / n;
        const double u_N = output.u_N[2 * i], other_N = output.u_N[2 * i + 1];
        const double linear_W = (u_N - other_N) * v_S_m_s;
        const double angular_W = HULL_M * (u_N + other_N) * vehicle.state.pose.w_IS_S_rad_s[(i + 1) % 3];
        power_W += linear_W + angular_W;
        size_W += fabs(linear_W) + fabs(angular_W);
    }
    check(power_W <= 1e-3 * size_W + 1e-6);
}

static void check_output(void) {
    const ssv_link_phase_t phase = vehicle.state.phase;
    const bool may_thrust = is_flying(phase) || phase == SSV_LINK_BRAKING || phase == SSV_LINK_DONE;
    bool thrusts = false;
    check(output.is_armed == (phase != SSV_LINK_DISARMED));
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
        check(output.is_armed ? fabsf(output.effort[k]) <= 1 : isnan(output.effort[k]));
        check(fabsf(output.u_N[k]) <= config.thrust_max_N);
        check(vehicle.state.u_N[k] == output.u_N[k]);
        if (output.is_armed) check((output.effort[k] == 0) == (output.u_N[k] == 0));
        thrusts = thrusts || output.u_N[k] != 0;
    }
    check(may_thrust || !thrusts);
    check(!output.attempts || phase == SSV_LINK_EXECUTING);
    if (is_flying(phase)) check(now_us - bound.grew_us <= config.beat_stop_us);
    if (thrusts && phase == SSV_LINK_BRAKING && config.curve[0].forward.num_points == 0) check_brake();
}

// ---- Time and bytes -------------------------------------------------------------------------------------------------

static void drain(void) {
    uint8_t frame[SSV_LINK_FRAME_BYTES_MAX];
    for (int n = 0; n < 16 && ssv_vehicle_poll(&vehicle, now_us, frame) > 0; n++) continue;
}

static void send(int from, ssv_packet_t* packet) {
    uint8_t frame[SSV_LINK_FRAME_BYTES_MAX];
    packet->target_sysid = SSV_LINK_VEHICLE_SYSID;
    packet->target_compid = SSV_LINK_VEHICLE_COMPID;
    const ssv_link_phase_t before = vehicle.state.phase;
    const size_t length = ssv_wire_send(&sender[from], now_us, packet, frame);
    ssv_vehicle_receive(&vehicle, now_us, frame, length);
    check_change(by_command, before);
    if (before != SSV_LINK_BRAKING) braking_us = now_us; // it may have braked before, and be started anew since
    if (is_flying(vehicle.state.phase) && !is_flying(before)) {
        check(now_us - beat_us[from] <= config.beat_warn_us && vehicle.state.pose.known);
        bound.from = from;
        bound.beat = vehicle.deadman.beat;
        bound.grew_us = beat_us[from];
    }
    drain();
}

static void send_beat(int from) {
    ssv_packet_t packet = {.kind = SSV_PACKET_BEAT};
    packet.of.beat = beat[from];
    const uint32_t ahead = beat[from].progress - bound.beat.progress;
    if (from == bound.from && beat[from].boot_id == bound.beat.boot_id && beat[from].session == bound.beat.session &&
        ahead != 0 && ahead < UINT32_C(1) << 31) {
        bound.beat.progress = beat[from].progress;
        bound.grew_us = now_us;
    }
    beat_us[from] = now_us;
    send(from, &packet);
}

static void tick(void) {
    const ssv_link_phase_t before = vehicle.state.phase;
    now_us += SSV_VEHICLE_TICK_US;
    ssv_vehicle_tick(&vehicle, now_us, &output);
    check_change(by_tick, before);
    check_output();
    if (before != SSV_LINK_BRAKING) braking_us = now_us;
    if (vehicle.state.phase == SSV_LINK_BRAKING)
        check(now_us - braking_us <= config.brake_max_us + SSV_VEHICLE_TICK_US);
    drain();
}

static void run_ticks(int count) {
    for (int n = 0; n < count; n++) {
        if (navigates && n % NAVIGATE_EVERY_TICKS == 0) ssv_vehicle_navigate(&vehicle, now_us, &pose);
        if (beating != NO_BEATS && n % BEAT_EVERY_TICKS == 0) {
            beat[PLANNER].progress += beating == BEATS;
            send_beat(PLANNER);
        }
        tick();
        if (n % DRAIN_EVERY_TICKS == 0) drain();
    }
}

// ---- Steps ----------------------------------------------------------------------------------------------------------

static void make_timeline(ssv_timeline_t* timeline) {
    memset(timeline, 0, sizeof *timeline);
    timeline->plan_hash = plan_hash;
    timeline->u_max_N = config.link.force_max_N;
    timeline->q_IS[0] = 1;
    timeline->num_segments = byte() % (MAX_SEGMENTS + 1);
    for (int i = 0; i < timeline->num_segments; i++) {
        ssv_timeline_segment_t* segment = &timeline->segment[i];
        const uint8_t kind = byte();
        segment->duration_ns = 1 + (int64_t)(kind % 4 == 0 ? word() % 100 : word() % 2000000000U);
        for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
            segment->u_start_N[k] = number(6);
            segment->u_end_N[k] = number(6);
        }
    }
    timeline->num_events = byte() % (SSV_MAX_EVENTS + 1);
    for (int i = 0; i < timeline->num_events; i++) {
        timeline->event[i].kind = i == timeline->num_events - 1 ? SSV_DOCK : SSV_MATE;
        const int32_t first = i == 0 ? 0 : timeline->event[i - 1].segment;
        timeline->event[i].segment = first + byte() % (timeline->num_segments + 1 - first);
    }
}

// The whole way of a file, by the planner's end and in no time.
static void upload(void) {
    static ssv_timeline_t timeline;
    static uint8_t file[SSV_TIMELINE_FILE_BYTES_MAX];
    const ssv_timeline_stamp_t stamp = {1 + now_us, 100000};
    uint8_t frame[SSV_LINK_FRAME_BYTES_MAX];
    ssv_link_planner_event_t event = {.kind = SSV_LINK_PLANNER_NOTHING};
    plan_hash++;
    make_timeline(&timeline);
    if (!ssv_link_planner_upload(&planner, file, ssv_timeline_encode(&timeline, &stamp, file, sizeof file))) return;
    const ssv_link_phase_t before = vehicle.state.phase;
    for (int n = 0; n < 100 && event.kind != SSV_LINK_PLANNER_UPLOADED; n++) {
        size_t length = ssv_link_planner_poll(&planner, now_us, frame);
        ssv_vehicle_receive(&vehicle, now_us, frame, length);
        length = ssv_vehicle_poll(&vehicle, now_us, frame);
        ssv_link_planner_receive(&planner, now_us, frame, length, &event);
    }
    check(vehicle.state.phase == before);
}

static void command(int from, uint16_t number_of, float value, uint64_t hash) {
    ssv_packet_t packet = {.kind = SSV_PACKET_COMMAND};
    memset(&packet.of, 0, sizeof packet.of);
    packet.of.command.command = number_of;
    packet.of.command.parameter[0] = value;
    packet.of.command.x = (uint32_t)hash;
    packet.of.command.y = (uint32_t)(hash >> 32);
    send(from, &packet);
}

static void any_command(int from) {
    static const uint16_t commands[] = {
        SSV_LINK_TERMINATE, SSV_LINK_PAUSE_CONTINUE, SSV_LINK_PAUSE_CONTINUE, SSV_LINK_ARM,
        SSV_LINK_COMMIT,    SSV_LINK_START,          SSV_LINK_START,          SSV_LINK_DROP};
    const uint8_t which = byte(), value = byte();
    const uint64_t hash = value % 16 == 15 ? word() : plan_hash;
    command(from, commands[which % 8], value % 16 == 14 ? any_float() : (float)(value % 2), hash);
}

static void any_beat(int from) {
    const uint8_t how = byte();
    if (how % 8 == 7) beat[from].boot_id = byte() % 4;
    if (how % 8 == 6) beat[from].session = byte() % 4;
    beat[from].progress += how % 8 == 5 ? word() : how % 8 < 4;
    if (how % 8 == 4) beat[from] = beat[from ^ 1];
    send_beat(from);
}

static void any_trim(int from) {
    const uint8_t how = byte();
    ssv_packet_t packet = {.kind = SSV_PACKET_TRIM};
    trim_sequence += how % 4 != 0;
    packet.of.trim = (ssv_link_trim_t){.boot_id = beat[from].boot_id,
                                       .session = beat[from].session,
                                       .sequence = trim_sequence,
                                       .plan_time_ns = vehicle.state.plan_time_ns};
    packet.of.trim.clock_rate = (how & 16) != 0 ? 1 : (how & 32) != 0 ? any_float() : (float)byte() / 255;
    if (how % 8 == 5) packet.of.trim.plan_time_ns = (int64_t)((uint64_t)word() << 32 | word());
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) packet.of.trim.trim_N[k] = how % 8 == 6 ? any_float() : number(20);
    send(from, &packet);
}

static void navigate(void) {
    const uint8_t how = byte();
    navigates = (how & 1) == 0;
    pose = (ssv_link_pose_t){.q_IS = {1, 0, 0, 0}};
    for (int i = 0; i < 3 && (how & 2) != 0; i++) {
        pose.v_IS_m_s[i] = number(1);
        pose.w_IS_S_rad_s[i] = number(1);
    }
    for (int i = 0; i < 4 && (how & 4) != 0; i++) pose.q_IS[i] = number((how & 16) != 0 ? 0.2F : 1);
    if ((how & 8) != 0) {
        float* const numbers[] = {pose.p_IS_m, pose.q_IS, pose.v_IS_m_s, pose.w_IS_S_rad_s};
        numbers[byte() % 4][byte() % 3] = any_float();
    }
    ssv_vehicle_navigate(&vehicle, now_us, &pose);
}

static void request_file(int from) {
    ssv_packet_t packet = {.kind = SSV_PACKET_FTP};
    packet.of.ftp = (ssv_ftp_t){.sequence = byte(), .session = byte(), .opcode = byte() % 16, .offset = word() % 9000};
    packet.of.ftp.size = byte() % (SSV_FTP_DATA_BYTES_MAX + 1);
    for (int i = 0; i < packet.of.ftp.size && i < 32; i++) packet.of.ftp.data[i] = byte();
    send(from, &packet);
}

// Bytes as they stand, and zeros until no false start is left that would swallow what comes next.
static bool send_bytes(void) {
    uint8_t bytes[64 + SSV_LINK_FRAME_BYTES_MAX] = {0};
    const uint32_t received = vehicle.link.wire.statistics.received;
    for (int n = byte() % 64, i = 0; i < n; i++) bytes[i] = byte();
    ssv_vehicle_receive(&vehicle, now_us, bytes, sizeof bytes);
    return vehicle.link.wire.statistics.received == received;
}

// All that it takes to fly, and then some motion.
static void prepare(void) {
    navigates = true;
    pose = (ssv_link_pose_t){.q_IS = {1, 0, 0, 0}};
    ssv_vehicle_navigate(&vehicle, now_us, &pose);
    command(PLANNER, SSV_LINK_ARM, 0, 0);
    upload();
    command(PLANNER, SSV_LINK_COMMIT, 0, plan_hash);
    command(PLANNER, SSV_LINK_ARM, 1, 0);
    beat[PLANNER].session++;
    beat[PLANNER].progress++;
    send_beat(PLANNER);
    command(PLANNER, SSV_LINK_START, 0, plan_hash);
    navigate();
}

static void begin(uint8_t how) {
    static const ssv_thrust_branch_t branch = {3, {0.1F, 0.5F, 0.9F}, {0.4F, 3, 7}};
    ssv_vehicle_config_default(&config, 1);
    config.brake_max_us = 2000000;
    if ((how & 1) != 0) {
        for (int k = 0; k < SSV_NUM_THRUSTERS; k++) config.curve[k] = (ssv_thrust_curve_t){branch, branch};
    }
    check(ssv_vehicle_init(&vehicle, &config));
    const ssv_link_planner_config_t own = {.sysid = SSV_LINK_VEHICLE_SYSID,
                                           .compid = SSV_LINK_PLANNER_COMPID,
                                           .vehicle_sysid = SSV_LINK_VEHICLE_SYSID,
                                           .vehicle_compid = SSV_LINK_VEHICLE_COMPID,
                                           .boot_id = 1};
    ssv_link_planner_init(&planner, &own);
    ssv_wire_init(&sender[PLANNER], SSV_LINK_VEHICLE_SYSID, SSV_LINK_PLANNER_COMPID, NULL);
    ssv_wire_init(&sender[STRANGER], 255, 190, NULL);
    for (int i = 0; i < NUM_SENDERS; i++) {
        beat[i] = (ssv_link_beat_t){1, 1, 0};
        beat_us[i] = INT64_MIN / 2;
    }
    memset(&bound, 0, sizeof bound);
    now_us = 0;
    plan_hash = 0;
    trim_sequence = 0;
    beating = NO_BEATS;
    navigates = false;
    braking_us = 0;
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    input = data;
    input_left = size;
    begin(byte());
    for (int step = 0; step < MAX_STEPS && input_left > 0; step++) {
        const uint8_t kind = byte(), detail = byte();
        const int from = detail % 4 == 3 ? STRANGER : PLANNER;
        const ssv_link_phase_t before = vehicle.state.phase;
        switch (kind % NUM_STEPS) {
            case TICKS:
                beating = detail % NUM_BEATS;
                run_ticks(1 + byte() * byte() % MAX_TICKS);
                break;
            case UPLOAD: upload(); break;
            case COMMAND: any_command(from); break;
            case BEAT: any_beat(from); break;
            case TRIM: any_trim(from); break;
            case NAVIGATE: navigate(); break;
            case SUPPLY: ssv_vehicle_supply(&vehicle, any_float()); break;
            case ATTEMPTED:
                ssv_vehicle_attempted(&vehicle, now_us, detail % 2 == 0);
                check(vehicle.state.phase == before ||
                      (is_flying(before) && detail % 2 == 1 && vehicle.state.phase == SSV_LINK_HOLDING));
                break;
            case FILE_REQUEST: request_file(from); break;
            case PREPARED: prepare(); break;
            default:
                if (!send_bytes()) return 0;
                break;
        }
        const uint8_t* live = ssv_link_vehicle_live(&vehicle.link, NULL);
        if (live != NULL)
            check(ssv_timeline_check(live, vehicle.link.length[vehicle.link.live]).reason == SSV_LINK_NO_REASON);
        check(vehicle.link.server.num_answers <= SSV_LINK_MAX_ANSWERS);
    }
    return 0;
}
