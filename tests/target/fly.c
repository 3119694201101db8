/// Flies a shipped scenario from its start to the mate, with all that flies: the planner plans, guidance tracks, both
/// ends of the link pass timeline, beats, commands and trims as bytes, and the controller ticks. What would be measured
/// is the plan's own pose, a few millimetres and milliradians off. Prints hashes of every effort, thrust and trim on
/// the way, the last thrusts in hex, and how it ended. Exit code 0 when it came to the attempt to mate.
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "shipped.h"
#include "ssv/guidance.h"
#include "ssv/vehicle.h"

#define SCENARIO "on_axis"
#define SEED 20261122u
#define TICKS_PER_STEP 10 // guidance steps every 50 ms
#define STEP_S REAL(0.05)
#define STEPS_PER_LINE 100
#define MAX_STEPS 4000
#define SESSION 1

static ssv_problem_t problem;
static ssv_work_t work;
static ssv_plan_t plan;
static ssv_timeline_t timeline;
static uint8_t file[SSV_TIMELINE_FILE_BYTES_MAX];
static ssv_guidance_t guidance;
static ssv_guidance_command_t command;
static ssv_link_planner_t planner;
static ssv_vehicle_config_t config;
static ssv_controller_t vehicle;
static ssv_vehicle_output_t output;
static int64_t now_us;
static uint64_t hash = 0xcbf29ce484222325u;
static uint64_t random_state = SEED;

static void mix(const float* values) {
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
        uint32_t bits;
        memcpy(&bits, &values[k], sizeof bits);
        hash = (hash ^ bits) * 0x100000001b3u;
    }
}

static float to_float(real_t value) { return (float)real_to_double(value); }

static void put_vec3(vec3_t v, float out[3]) {
    out[0] = to_float(v.x);
    out[1] = to_float(v.y);
    out[2] = to_float(v.z);
}

// A whole number of steps of 2^-10, up to four either way: some millimetres or milliradians.
static real_t offset(void) {
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return real_from_double(((double)(random_state >> 60) - 7.5) * 0x1p-11);
}

// ---- Bytes ----------------------------------------------------------------------------------------------------------

// Lets both ends talk until neither has more to say. Returns the last event of this kind, if any.
static ssv_link_planner_event_t talk(ssv_link_planner_event_kind_t kind) {
    uint8_t frame[SSV_LINK_FRAME_BYTES_MAX];
    ssv_link_planner_event_t event, found = {.kind = SSV_LINK_PLANNER_NOTHING};
    size_t up, down;
    do {
        up = ssv_link_planner_poll(&planner, now_us, frame);
        ssv_vehicle_receive(&vehicle, now_us, frame, up);
        down = ssv_vehicle_poll(&vehicle, now_us, frame);
        ssv_link_planner_receive(&planner, now_us, frame, down, &event);
        if (event.kind == kind) found = event;
    } while (up > 0 || down > 0);
    return found;
}

static bool command_vehicle(ssv_link_command_t what, int32_t value) {
    if (!ssv_link_planner_command(&planner, now_us, what, value, timeline.plan_hash)) return false;
    const ssv_link_planner_event_t answer = talk(SSV_LINK_PLANNER_ANSWERED);
    return answer.kind == SSV_LINK_PLANNER_ANSWERED && answer.of.answer.result == SSV_LINK_ACCEPTED;
}

static bool upload(void) {
    const ssv_timeline_stamp_t stamp = {1, 600000};
    const size_t length = ssv_timeline_encode(&timeline, &stamp, file, sizeof file);
    return ssv_link_planner_upload(&planner, file, length) &&
           talk(SSV_LINK_PLANNER_UPLOADED).kind == SSV_LINK_PLANNER_UPLOADED;
}

// ---- The flight -----------------------------------------------------------------------------------------------------

static bool make_plan(void) {
    ssv_fault_t fault;
    for (size_t k = 0; k < sizeof shipped / sizeof *shipped; k++) {
        if (strcmp(shipped[k].name, SCENARIO) != 0) continue;
        return ssv_problem_init(&problem, &shipped[k].scenario, &fault) == SSV_OK &&
               ssv_plan(&problem, &work, &plan) == SSV_OK;
    }
    return false;
}

// Tells guidance and controller where the vehicle is: about where the plan has it.
static void measure(real_t plan_time_s) {
    ssv_sample_t sample;
    ssv_plan_sample(&plan, plan_time_s, &sample);
    real_t off[6]; // one by one: the order of arguments is the compiler's
    for (int i = 0; i < 6; i++) off[i] = offset();
    sample.X_IS.p = vec3_add(sample.X_IS.p, vec3(off[0], off[1], off[2]));
    const quat_t turn = {REAL(1), off[3], off[4], off[5]};
    sample.X_IS.q = quat_unit(quat_mul(sample.X_IS.q, turn));
    ssv_guidance_measure(&guidance, REAL(0), sample.X_IS);
    ssv_link_pose_t pose = {.known = true,
                            .q_IS = {to_float(sample.X_IS.q.w), to_float(sample.X_IS.q.x), to_float(sample.X_IS.q.y),
                                     to_float(sample.X_IS.q.z)}};
    put_vec3(sample.X_IS.p, pose.p_IS_m);
    put_vec3(quat_apply(sample.X_IS.q, sample.v_IS_S_m_s), pose.v_IS_m_s);
    put_vec3(sample.w_IS_S_rad_s, pose.w_IS_S_rad_s);
    ssv_vehicle_navigate(&vehicle, now_us, &pose);
}

static void send_trim(uint32_t sequence) {
    float trim_N[SSV_NUM_THRUSTERS];
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) trim_N[k] = to_float(command.trim_N[k]);
    mix(trim_N);
    const int64_t plan_time_ns = (int64_t)(1e9 * real_to_double(command.plan_time_s));
    ssv_link_planner_trim(&planner, SESSION, sequence, plan_time_ns, to_float(command.clock_rate), trim_N);
    ssv_link_planner_beat(&planner, SESSION, sequence + 1);
}

static bool prepare(void) {
    const ssv_link_planner_config_t own = {.sysid = SSV_LINK_VEHICLE_SYSID,
                                           .compid = SSV_LINK_PLANNER_COMPID,
                                           .vehicle_sysid = SSV_LINK_VEHICLE_SYSID,
                                           .vehicle_compid = SSV_LINK_VEHICLE_COMPID,
                                           .boot_id = 1};
    ssv_vehicle_config_default(&config, 1);
    ssv_link_planner_init(&planner, &own);
    if (!ssv_vehicle_init(&vehicle, &config)) return false;
    const ssv_guidance_config_t tracking = {real_from_double((double)config.link.force_max_N), REAL(0)};
    ssv_guidance_init(&guidance, &problem, &plan, &tracking);
    ssv_timeline_of_plan(&plan, &timeline);
    measure(REAL(0));
    ssv_link_planner_beat(&planner, SESSION, 1);
    return upload() && command_vehicle(SSV_LINK_COMMIT, 0) && command_vehicle(SSV_LINK_ARM, 1) &&
           command_vehicle(SSV_LINK_START, 0);
}

static void tick(void) {
    (void)talk(SSV_LINK_PLANNER_NOTHING);
    ssv_vehicle_tick(&vehicle, now_us, &output);
    mix(output.effort);
    mix(output.u_N);
    now_us += SSV_VEHICLE_TICK_US;
}

int main(void) {
    if (!make_plan() || !prepare()) {
        puts("not started");
        return 1;
    }
    for (uint32_t step = 1; step <= MAX_STEPS && !output.attempts; step++) {
        ssv_guidance_step(&guidance, STEP_S, &command);
        send_trim(step);
        if (command.attempt == SSV_ATTEMPT_MATE) (void)command_vehicle(SSV_LINK_PAUSE_CONTINUE, 1);
        for (int k = 0; k < TICKS_PER_STEP && !output.attempts; k++) tick();
        measure(command.plan_time_s + real_mul(command.clock_rate, STEP_S));
        if (step % STEPS_PER_LINE == 0)
            printf("%u %d %08" PRIx32 "%08" PRIx32 "\n", (unsigned)step, (int)vehicle.state.phase,
                   (uint32_t)(hash >> 32), (uint32_t)hash);
    }
    printf("%s after %u ms, phase %d, plan %08" PRIx32 "%08" PRIx32 ", hash %08" PRIx32 "%08" PRIx32 ", u_N",
           output.attempts ? "mates" : "lost", (unsigned)(now_us / 1000), (int)vehicle.state.phase,
           (uint32_t)(plan.plan_hash >> 32), (uint32_t)plan.plan_hash, (uint32_t)(hash >> 32), (uint32_t)hash);
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
        uint32_t bits;
        memcpy(&bits, &output.u_N[k], sizeof bits);
        printf(" %08" PRIx32, bits);
    }
    printf("\n");
    return output.attempts ? 0 : 1;
}
