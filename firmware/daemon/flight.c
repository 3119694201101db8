#define _GNU_SOURCE
#include "flight.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "channels.h"
#include "lcm_ssv_execution_t.h"
#include "lcm_ssv_vehicle_state_t.h"
#include "log.h"

/// [us] How often the bus is told.
#define TELL_US INT64_C(100000)
/// [us] In lockstep, how long the simulator runs at a time while frames go to and fro, and how long it may take.
#define EXCHANGE_US INT64_C(10000)
#define SIMULATOR_PATIENCE_MS 5000
/// [us] How old the vehicle's last message may be.
#define HEARD_US INT64_C(2000000)
/// [ms] From the upload to the start.
#define VALID_FOR_MS 60000
/// Plans of one task: the first, and anew where the vehicle strayed before the mate.
#define PLANS_MAX 4
/// How a task ended is told so often, in such intervals of the real clock: a datagram may be lost.
#define ENDINGS 5
#define ENDING_US INT64_C(100000)
/// Frames that are read before others get their turn.
#define READS_MAX 64

static int64_t clock_us(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (int64_t)t.tv_sec * 1000000 + t.tv_nsec / 1000;
}

/// The time that the executive lives in: the simulator's in lockstep, else the real one.
static int64_t now_us(const flight_t* flight) {
    return flight->options.lockstep != NULL ? flight->lock_us : clock_us(CLOCK_MONOTONIC) - flight->zero_us;
}

bool flight_open(flight_t* flight, lcm_t* lcm, const flight_options_t* options, uint32_t boot_id, char* error,
                 size_t error_size) {
    ssv_executive_config_t config = {.link = {.sysid = SSV_LINK_VEHICLE_SYSID,
                                              .compid = SSV_LINK_PLANNER_COMPID,
                                              .vehicle_sysid = SSV_LINK_VEHICLE_SYSID,
                                              .vehicle_compid = SSV_LINK_VEHICLE_COMPID,
                                              .boot_id = boot_id},
                                     .thruster_lag_s = real_from_double(options->thruster_lag_s)};
    char where[64];
    memset(flight, 0, sizeof *flight);
    flight->lcm = lcm;
    flight->options = *options;
    flight->zero_us = clock_us(CLOCK_MONOTONIC);
    flight->port.fd = flight->leave.fd = -1;
    config.link.sign = options->key != NULL;
    if (config.link.sign && !key_read(options->key, now_us(flight), &config.link.signing, error, error_size))
        return false;
    ssv_executive_init(&flight->executive, &config);
    if (!port_open(&flight->port, options->link, error, error_size)) return false;
    if (options->lockstep != NULL) {
        (void)snprintf(where, sizeof where, "udp:127.0.0.1:%s", options->lockstep);
        if (!port_open(&flight->leave, where, error, error_size)) {
            port_close(&flight->port);
            return false;
        }
    }
    flight->is_open = true;
    return true;
}

void flight_close(flight_t* flight) {
    if (!flight->is_open) return;
    port_close(&flight->port);
    port_close(&flight->leave);
    flight->is_open = false;
}

bool flight_is_under_way(const flight_t* flight) {
    return flight->is_open && (flight->executive.outcome == SSV_EXECUTIVE_UNDER_WAY || flight->has_news);
}

bool flight_hears(const flight_t* flight) {
    return flight->is_open && flight->executive.heard && now_us(flight) - flight->executive.heard_us < HEARD_US;
}

// ---- Beginning and ending -------------------------------------------------------------------------------------------

static bool begin(flight_t* flight) {
    // Of two plans the one with the larger epoch is newer, also to a vehicle that another planner spoke with before.
    const int64_t wall_us = clock_us(CLOCK_REALTIME);
    flight->epoch_us = wall_us > flight->epoch_us ? wall_us : flight->epoch_us + 1;
    const ssv_scenario_t* scenario = &flight->problem.scenario;
    const ssv_executive_order_t order = {
        .epoch_us = flight->epoch_us,
        .valid_for_ms = VALID_FOR_MS,
        // The problem's limit is what the reserve leaves of it.
        .force_max_N = real_div(scenario->vehicle.force_max_N, REAL(1) - scenario->thrust_reserve)};
    flight->num_plans++;
    return ssv_executive_begin(&flight->executive, now_us(flight), &flight->problem, &flight->plan, &order);
}

bool flight_begin(flight_t* flight, const ssv_answer_t* answer) {
    if (!flight->is_open || flight_is_under_way(flight)) return false;
    // The problem refers to the scene of the answer, whose memory is the next question's soon.
    flight->scene = answer->working.scene;
    flight->problem = answer->working.problem;
    flight->problem.scenario.scene = flight->problem.around.scene = &flight->scene;
    flight->plan = answer->plan;
    flight->answer = answer->wire.answer;
    flight->num_plans = flight->sequence = flight->num_endings = 0;
    flight->told_us = now_us(flight) - TELL_US;
    flight->begun_us = now_us(flight);
    flight->begun_clock_us = clock_us(CLOCK_MONOTONIC);
    flight->simulator_gone = false;
    if (!begin(flight)) return false;
    flight->has_news = true;
    log_line(LOG_INFO, "task %016" PRIx64 ": flies plan %016" PRIx64, (uint64_t)flight->answer.asker.request_id,
             flight->plan.plan_hash);
    return true;
}

void flight_stop(flight_t* flight) {
    if (flight->is_open) ssv_executive_stop(&flight->executive, now_us(flight));
}

void flight_control(flight_t* flight, const lcm_ssv_control_t* control) {
    if (!flight_is_under_way(flight) ||
        (control->planner_id != 0 && control->planner_id != flight->answer.planner.planner_id) ||
        (control->request_id != 0 && control->request_id != flight->answer.asker.request_id))
        return;
    switch (control->command) {
        case LCM_SSV_CONTROL_T_COMMAND_STOP: flight_stop(flight); break;
        case LCM_SSV_CONTROL_T_COMMAND_PAUSE: ssv_executive_pause(&flight->executive, true); break;
        case LCM_SSV_CONTROL_T_COMMAND_CONTINUE: ssv_executive_pause(&flight->executive, false); break;
        default: break;
    }
}

// Where the vehicle strayed on its way to the beam, it is planned anew from where it is by now, to take hold of the
// beam where it was to.
static bool plan_anew(flight_t* flight) {
    ssv_executive_t* executive = &flight->executive;
    // A vehicle that nobody holds yet may have drifted off while the timeline was on its way.
    const bool has_drifted = executive->outcome == SSV_EXECUTIVE_REFUSED && executive->reason == SSV_LINK_START_POSE;
    if ((executive->outcome != SSV_EXECUTIVE_STRAYED && !has_drifted) || executive->guidance.mated ||
        flight->num_plans >= PLANS_MAX || flight->simulator_gone)
        return false;
    ssv_scenario_t scenario = flight->problem.scenario;
    ssv_fault_t fault;
    scenario.vehicle.force_max_N = real_div(scenario.vehicle.force_max_N, REAL(1) - scenario.thrust_reserve);
    scenario.contact = flight->plan.quote.choice.contact;
    scenario.num_attach_heights = 1;
    scenario.attach_heights_m[0] = flight->plan.quote.choice.attach_height_m;
    scenario.attach_anywhere = false;
    scenario.ring_angle_given = true;
    scenario.ring_angle_rad = flight->plan.quote.choice.ring_angle_rad;
    // It has braked since, which guidance's estimate knows nothing of.
    if (!ssv_executive_measured(executive, &scenario.X_IS) ||
        ssv_problem_init(&flight->problem, &scenario, &fault) != SSV_OK ||
        ssv_plan(&flight->problem, &flight->work, &flight->plan) != SSV_OK)
        return false;
    log_line(LOG_WARN, "task %016" PRIx64 ": off its plan, flies plan %016" PRIx64 " from where it is",
             (uint64_t)flight->answer.asker.request_id, flight->plan.plan_hash);
    return begin(flight);
}

// ---- What the bus is told -------------------------------------------------------------------------------------------

static const char* reason_str(const flight_t* flight) {
    const ssv_executive_t* executive = &flight->executive;
    if (flight->simulator_gone) return "the simulator is gone";
    switch (executive->outcome) {
        case SSV_EXECUTIVE_UNDER_WAY: return "";
        case SSV_EXECUTIVE_DOCKED: return "docked";
        case SSV_EXECUTIVE_MISSED:
            return executive->guidance.mated ? "could not dock within the tolerance"
                                             : "could not mate within the tolerance";
        case SSV_EXECUTIVE_STRAYED: return "too far from the plan";
        case SSV_EXECUTIVE_STOPPED: return "stopped as commanded";
        case SSV_EXECUTIVE_SILENT: return "the vehicle is not heard";
        default: return ssv_link_reason_str(executive->reason);
    }
}

static int32_t leg_at(const ssv_plan_t* plan, real_t t_s) {
    int32_t leg = 0;
    while (leg + 1 < plan->num_legs && plan->leg[leg + 1].t_start_s <= t_s) leg++;
    return leg;
}

static void publish(flight_t* flight, const char* channel, int size) {
    if (size > 0 && lcm_publish(flight->lcm, channel, flight->message, (unsigned)size) != 0)
        log_line(LOG_WARN, "cannot send %d bytes on %s: %s", size, channel, strerror(errno));
}

static double seconds(int64_t from_us, int64_t to_us) { return 1e-6 * (double)(to_us - from_us); }

static void tell_execution(flight_t* flight) {
    const ssv_executive_t* executive = &flight->executive;
    const ssv_guidance_command_t* turn = &executive->turn.command;
    const ssv_link_statistics_t* link = &executive->link.wire.statistics;
    const bool has_ended = executive->outcome != SSV_EXECUTIVE_UNDER_WAY;
    const int64_t now = now_us(flight);
    char text[SSV_LINK_TEXT_MAX + 1];
    memcpy(text, executive->text, sizeof text);
    const lcm_ssv_execution_t wire = {
        .answer = flight->answer,
        .plan_hash = (int64_t)executive->plan_hash,
        .sequence = ++flight->sequence,
        .num_plans = flight->num_plans,
        .state = (int8_t)(has_ended ? LCM_SSV_EXECUTION_T_STATE_ENDED : (int)executive->state - SSV_EXECUTIVE_SEEKING),
        .outcome = (int8_t)executive->outcome,
        .goal = executive->guidance.mated ? LCM_SSV_EXECUTION_T_GOAL_DOCK : LCM_SSV_EXECUTION_T_GOAL_MATE,
        .reason = (char*)(uintptr_t)reason_str(flight),
        .time_s = seconds(flight->begun_us, now),
        .flown_s = executive->started_us > 0 ? seconds(executive->started_us, now) : 0,
        .plan_time_s = real_to_double(executive->guidance.plan_time_s),
        .plan_duration_s = real_to_double(flight->plan.quote.time_s),
        .clock_rate = real_to_double(turn->clock_rate),
        .leg = leg_at(&flight->plan, executive->guidance.plan_time_s),
        .attempts = executive->attempts,
        .impulse_Ns = real_to_double(executive->impulse_Ns),
        .behind_m = real_to_double(turn->error.along_m),
        .beside_m = real_to_double(turn->error.across_m),
        .angle_rad = real_to_double(turn->error.angle_rad),
        .goal_distance_m = real_to_double(turn->error.tip_m),
        .goal_angle_rad = real_to_double(turn->error.tip_angle_rad),
        .upload_bytes = (int32_t)executive->length,
        .uploaded_bytes = (int32_t)ssv_link_planner_uploaded(&executive->link),
        .link_received = link->received,
        .link_lost = link->lost,
        .link_damaged = link->bad_crc,
        .link_lost_up = executive->health.lost,
        .link_silence_s = executive->heard ? seconds(executive->heard_us, now) : seconds(flight->begun_us, now),
        .vehicle_boot_id = executive->heard ? executive->vehicle.boot_id : 0,
        .num_texts = (int32_t)executive->num_texts,
        .text = text};
    publish(flight, CHANNEL_EXECUTION, lcm_ssv_execution_t_encode(flight->message, 0, sizeof flight->message, &wire));
}

static lcm_ssv_pose_t wire_pose(pose_t X) {
    const lcm_ssv_pose_t wire = {
        {real_to_double(X.p.x), real_to_double(X.p.y), real_to_double(X.p.z)},
        {real_to_double(X.q.w), real_to_double(X.q.x), real_to_double(X.q.y), real_to_double(X.q.z)}};
    return wire;
}

static void put(vec3_t v, double out[3]) {
    out[0] = real_to_double(v.x);
    out[1] = real_to_double(v.y);
    out[2] = real_to_double(v.z);
}

static void tell_state(flight_t* flight) {
    const ssv_guidance_t* guidance = &flight->executive.guidance;
    const ssv_estimate_t* estimate = &guidance->estimate;
    const pose_t X_IB = guidance->mated ? pose_mul(estimate->X_IS, guidance->X_SB) : flight->problem.scenario.X_IB;
    lcm_ssv_vehicle_state_t wire = {.time_s = 1e-6 * (double)now_us(flight),
                                    .plan_hash = (int64_t)flight->executive.plan_hash,
                                    .X_IS = wire_pose(estimate->X_IS),
                                    .X_IB = wire_pose(X_IB),
                                    .mated = guidance->mated,
                                    .docked = guidance->state == SSV_GUIDANCE_DONE};
    put(estimate->v_S_m_s, wire.v_IS_S_m_s);
    put(estimate->w_S_rad_s, wire.w_IS_S_rad_s);
    put(estimate->force_I_N, wire.force_I_N);
    put(estimate->moment_S_Nm, wire.moment_S_Nm);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) wire.u_N[i] = real_to_double(flight->executive.turn.command.u_N[i]);
    publish(flight, CHANNEL_STATE, lcm_ssv_vehicle_state_t_encode(flight->message, 0, sizeof flight->message, &wire));
}

static bool has_endings(const flight_t* flight) { return flight->num_endings > 0 && flight->num_endings < ENDINGS; }

// Tells the end of a task once more, when that is due.
static void tell_ending(flight_t* flight) {
    if (!has_endings(flight) || clock_us(CLOCK_MONOTONIC) - flight->ending_clock_us < ENDING_US) return;
    flight->num_endings++;
    flight->ending_clock_us = clock_us(CLOCK_MONOTONIC);
    flight->sequence--; // the same message
    tell_execution(flight);
}

static void tell(flight_t* flight) {
    const bool has_ended = flight->executive.outcome != SSV_EXECUTIVE_UNDER_WAY;
    if (!has_ended && now_us(flight) - flight->told_us < TELL_US) return;
    flight->told_us = has_ended ? now_us(flight) : flight->told_us + TELL_US;
    tell_execution(flight);
    if (flight->executive.started_us > 0) tell_state(flight);
    flight->has_news = !has_ended;
    if (!has_ended) return;
    flight->num_endings = 1;
    flight->ending_clock_us = clock_us(CLOCK_MONOTONIC);
    log_line(flight->executive.outcome == SSV_EXECUTIVE_DOCKED ? LOG_INFO : LOG_WARN,
             "task %016" PRIx64 ": %s, %.1f s after the start, %" PRIu32 " frames heard, %" PRIu32 " lost",
             (uint64_t)flight->answer.asker.request_id, reason_str(flight),
             flight->executive.started_us > 0 ? seconds(flight->executive.started_us, now_us(flight)) : 0,
             flight->executive.link.wire.statistics.received, flight->executive.link.wire.statistics.lost);
}

// ---- Turns ----------------------------------------------------------------------------------------------------------

static void exchange(flight_t* flight) {
    uint8_t bytes[2048];
    size_t count;
    for (int i = 0; i < READS_MAX && (count = port_read(&flight->port, 0, bytes, sizeof bytes)) > 0; i++)
        ssv_executive_receive(&flight->executive, now_us(flight), bytes, count);
    ssv_executive_receive(&flight->executive, now_us(flight), NULL, 0);
    if (now_us(flight) >= flight->executive.due_us) ssv_executive_step(&flight->executive, now_us(flight));
    while ((count = ssv_executive_poll(&flight->executive, now_us(flight), bytes)) > 0)
        port_write(&flight->port, bytes, count);
}

// Has the simulator run to the given time and waits for it. What it sends is there before its answer.
static bool give_leave(flight_t* flight, int64_t until_us) {
    uint8_t bytes[8];
    for (int i = 0; i < 8; i++) bytes[i] = (uint8_t)((uint64_t)until_us >> 8 * i);
    port_write(&flight->leave, bytes, sizeof bytes);
    if (port_read(&flight->leave, SIMULATOR_PATIENCE_MS, bytes, sizeof bytes) != sizeof bytes) return false;
    flight->lock_us = until_us;
    return true;
}

static void run_simulator(flight_t* flight) {
    const ssv_executive_t* executive = &flight->executive;
    int64_t until_us = executive->due_us;
    if (executive->state != SSV_EXECUTIVE_TRACKING && flight->lock_us + EXCHANGE_US < until_us)
        until_us = flight->lock_us + EXCHANGE_US;
    if (until_us <= flight->lock_us) until_us = flight->lock_us + EXCHANGE_US;
    if (give_leave(flight, until_us)) return;
    flight->simulator_gone = true;
    ssv_executive_give_up(&flight->executive);
}

void flight_turn(flight_t* flight) {
    if (!flight->is_open) return;
    const bool was_under_way = flight_is_under_way(flight);
    if (!was_under_way) tell_ending(flight);
    if (flight->options.lockstep != NULL && (!was_under_way || flight_wait_us(flight) > 0)) return;
    exchange(flight);
    if (!was_under_way) return;
    if (flight->executive.outcome != SSV_EXECUTIVE_UNDER_WAY) (void)plan_anew(flight);
    tell(flight);
    if (flight->options.lockstep != NULL && flight->executive.outcome == SSV_EXECUTIVE_UNDER_WAY) run_simulator(flight);
}

int64_t flight_wait_us(const flight_t* flight) {
    int64_t wait_us = 0;
    if (!flight->is_open) return INT64_MAX;
    if (!flight_is_under_way(flight)) {
        if (!has_endings(flight)) return INT64_MAX;
        wait_us = flight->ending_clock_us + ENDING_US - clock_us(CLOCK_MONOTONIC);
    } else if (flight->options.lockstep == NULL)
        wait_us = flight->executive.due_us - now_us(flight);
    else if (flight->options.rate > 0)
        wait_us = flight->begun_clock_us +
                  (int64_t)((double)(flight->lock_us - flight->begun_us) / flight->options.rate) -
                  clock_us(CLOCK_MONOTONIC);
    return wait_us > 0 ? wait_us : 0;
}
