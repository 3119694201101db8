// The executive: one state after another up to the start of the timeline, and then the control loop.
#include "ssv/executive.h"

#include <string.h>

/// [us] How long to wait for a vehicle before the upload, and after which silence it is lost.
#define SEEK_US INT64_C(5000000)
#define SILENCE_US INT64_C(2000000)
/// [us] An upload of which nothing more is acknowledged for so long has failed: a vehicle may be heard and not hear us.
/// With every fifth frame lost whole uploads take 25 s at most.
#define UPLOAD_US INT64_C(40000000)
/// [us] A stop is over by then: the vehicle's brake takes 30 s at most.
#define STOP_US INT64_C(40000000)
/// [us] A flight takes twice the plan's time at most, and so much more.
#define GRACE_US INT64_C(600000000)
/// [us] The longest step: what the loop is later than that is made up for by the next ones.
#define STEP_MAX_US INT64_C(200000)
/// Starts that are refused because no beat has come through yet.
#define START_TRIES_MAX 20
/// Steps in a row that guidance must be lost: 2 s.
#define STRAYS_MAX 40
/// A measured position beyond this, or a measurement older than that, is none.
#define POSITION_MAX_M 1e5F
#define AGE_MAX_US INT64_C(10000000)
/// What the clock's offset creeps up by, for clocks drift: a share of how late a message is.
#define CREEP 4096

void ssv_executive_init(ssv_executive_t* executive, const ssv_executive_config_t* config) {
    memset(executive, 0, sizeof *executive);
    executive->config = *config;
    executive->outcome = SSV_EXECUTIVE_STOPPED;
    ssv_link_planner_init(&executive->link, &config->link);
}

static bool is_under_way(const ssv_executive_t* executive) { return executive->state != SSV_EXECUTIVE_IDLE; }

static void enter(ssv_executive_t* executive, ssv_executive_state_t state) {
    executive->state = state;
    executive->commanded = false;
}

// Without beats the vehicle's dead-man stops whatever is left to stop.
static void finish(ssv_executive_t* executive, ssv_executive_outcome_t outcome, ssv_link_reason_t reason) {
    enter(executive, SSV_EXECUTIVE_IDLE);
    executive->outcome = outcome;
    executive->reason = reason;
    ssv_link_planner_beat(&executive->link, 0, 0);
}

static void command(ssv_executive_t* executive, int64_t now_us, ssv_link_command_t what, int32_t value) {
    if (!executive->commanded || what == SSV_LINK_TERMINATE)
        executive->commanded = ssv_link_planner_command(&executive->link, now_us, what, value, executive->plan_hash);
}

static void stop(ssv_executive_t* executive, int64_t now_us, ssv_executive_outcome_t outcome) {
    if (executive->state < SSV_EXECUTIVE_COMMITTING) {
        finish(executive, outcome, SSV_LINK_NO_REASON);
        return;
    }
    enter(executive, SSV_EXECUTIVE_STOPPING);
    executive->outcome_to_be = outcome;
    executive->stopping_us = now_us;
    command(executive, now_us, SSV_LINK_TERMINATE, 1);
}

bool ssv_executive_begin(ssv_executive_t* executive, int64_t now_us, const ssv_problem_t* problem,
                         const ssv_plan_t* plan, const ssv_executive_order_t* order) {
    if (is_under_way(executive) || plan->quote.status != SSV_OK) return false;
    const ssv_timeline_stamp_t stamp = {order->epoch_us, order->valid_for_ms};
    ssv_timeline_t* timeline = &executive->timeline;
    ssv_timeline_of_plan(plan, timeline);
    timeline->mass_configuration = order->mass_configuration;
    executive->length = ssv_timeline_encode(timeline, &stamp, executive->file, sizeof executive->file);
    if (executive->length == 0) return false;
    int64_t time_ns = 0;
    for (int segment = 0, event = 0; event < timeline->num_events; segment++) {
        while (event < timeline->num_events && timeline->event[event].segment == segment)
            executive->event_ns[event++] = time_ns;
        if (segment < timeline->num_segments) time_ns += timeline->segment[segment].duration_ns;
    }
    executive->problem = problem;
    executive->plan = plan;
    executive->plan_hash = plan->plan_hash;
    executive->outcome = SSV_EXECUTIVE_UNDER_WAY;
    executive->reason = SSV_LINK_NO_REASON;
    executive->session++;
    executive->progress = executive->sequence = 0;
    executive->num_strays = 0;
    executive->num_starts = 0;
    executive->has_clock = executive->wants_pause = executive->has_paused = false;
    executive->impulse_Ns = REAL(0);
    executive->turn.at_us = executive->started_us = 0;
    executive->begun_us = executive->due_us = now_us;
    ssv_guidance_init(&executive->guidance, problem, plan,
                      &(ssv_guidance_config_t){order->force_max_N, executive->config.thruster_lag_s});
    enter(executive, SSV_EXECUTIVE_SEEKING);
    return true;
}

void ssv_executive_stop(ssv_executive_t* executive, int64_t now_us) {
    if (is_under_way(executive) && executive->state != SSV_EXECUTIVE_STOPPING)
        stop(executive, now_us, SSV_EXECUTIVE_STOPPED);
}

void ssv_executive_give_up(ssv_executive_t* executive) {
    if (is_under_way(executive)) finish(executive, SSV_EXECUTIVE_SILENT, SSV_LINK_NO_REASON);
}

void ssv_executive_pause(ssv_executive_t* executive, bool paused) { executive->wants_pause = paused; }

// ---- What the vehicle tells -----------------------------------------------------------------------------------------

// The least delay that was seen counts as none; later messages let it creep up, for clocks drift.
static void learn_clock(ssv_executive_t* executive, int64_t now_us, uint32_t time_boot_ms) {
    const int64_t offset_us = now_us - INT64_C(1000) * time_boot_ms;
    if (!executive->has_clock || offset_us < executive->clock_offset_us)
        executive->clock_offset_us = offset_us;
    else
        executive->clock_offset_us += (offset_us - executive->clock_offset_us) / CREEP;
    executive->has_clock = true;
}

static void take_execution(ssv_executive_t* executive, int64_t now_us, const ssv_link_execution_t* told) {
    const bool is_another = executive->heard && told->boot_id != executive->vehicle.boot_id;
    executive->vehicle = *told;
    executive->heard = true;
    executive->heard_us = now_us;
    if (is_another) executive->has_clock = false;
    learn_clock(executive, now_us, told->time_boot_ms);
    if (is_another && executive->state > SSV_EXECUTIVE_SEEKING)
        finish(executive, SSV_EXECUTIVE_SILENT, SSV_LINK_NO_REASON);
}

static bool are_within(const float* value, int count, float most) {
    for (int i = 0; i < count; i++) {
        if (!(value[i] >= -most && value[i] <= most)) return false; // a NaN is within nothing
    }
    return true;
}

static bool is_pose(const ssv_link_pose_t* pose) {
    const float* q = pose->q_IS;
    if (!are_within(pose->p_IS_m, 3, POSITION_MAX_M) || !are_within(q, 4, 2)) return false;
    const float square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    return square > 0.81F && square < 1.21F;
}

static real_t from_float(float value) { return real_from_double((double)value); }

bool ssv_executive_measured(const ssv_executive_t* executive, pose_t* X_IS) {
    const float *p = executive->pose.p_IS_m, *q = executive->pose.q_IS;
    if (!executive->pose.known) return false;
    X_IS->p = vec3(from_float(p[0]), from_float(p[1]), from_float(p[2]));
    X_IS->q = quat_unit((quat_t){from_float(q[0]), from_float(q[1]), from_float(q[2]), from_float(q[3])});
    return true;
}

static void measure(ssv_executive_t* executive, uint32_t time_boot_ms) {
    pose_t X_IS;
    // Guidance has gone on to the moment of the next step.
    const int64_t age_us = executive->due_us - (INT64_C(1000) * time_boot_ms + executive->clock_offset_us);
    if (age_us >= 0 && age_us < AGE_MAX_US && ssv_executive_measured(executive, &X_IS))
        ssv_guidance_measure(&executive->guidance, real_from_double(1e-6 * (double)age_us), X_IS);
}

static void take_attitude(ssv_executive_t* executive, uint32_t time_boot_ms, const ssv_link_pose_t* told) {
    memcpy(executive->pose.q_IS, told->q_IS, sizeof told->q_IS);
    memcpy(executive->pose.w_IS_S_rad_s, told->w_IS_S_rad_s, sizeof told->w_IS_S_rad_s);
    executive->has_attitude = true;
    executive->attitude_ms = time_boot_ms;
}

// A pose is an attitude and a position of the same moment; where one of them was lost there is none.
static void take_position(ssv_executive_t* executive, uint32_t time_boot_ms, const ssv_link_pose_t* told) {
    memcpy(executive->pose.p_IS_m, told->p_IS_m, sizeof told->p_IS_m);
    memcpy(executive->pose.v_IS_m_s, told->v_IS_m_s, sizeof told->v_IS_m_s);
    executive->pose.known =
        executive->has_attitude && executive->attitude_ms == time_boot_ms && is_pose(&executive->pose);
    executive->has_attitude = false;
    if (executive->pose.known && executive->state == SSV_EXECUTIVE_TRACKING && executive->has_clock)
        measure(executive, time_boot_ms);
}

static void begin_tracking(ssv_executive_t* executive, int64_t now_us) {
    enter(executive, SSV_EXECUTIVE_TRACKING);
    executive->started_us = executive->due_us = now_us;
    executive->attempts = 0;
    executive->vehicle.phase = SSV_LINK_EXECUTING;
    executive->vehicle.attempts = executive->vehicle.events = 0;
    executive->asked_attempt = false;
}

// A start may come before the first beat does, which another start mends.
static void take_refusal(ssv_executive_t* executive, int64_t now_us, ssv_link_command_t what, ssv_link_result_t result,
                         ssv_link_reason_t reason) {
    if (what == SSV_LINK_START && reason == SSV_LINK_BEAT_LOST && ++executive->num_starts < START_TRIES_MAX) return;
    if (executive->state == SSV_EXECUTIVE_TRACKING && result != SSV_LINK_NO_ANSWER) return; // its phase tells more
    if (executive->state == SSV_EXECUTIVE_STOPPING) return;
    if (result == SSV_LINK_NO_ANSWER)
        finish(executive, SSV_EXECUTIVE_SILENT, SSV_LINK_NO_REASON);
    else if (executive->state == SSV_EXECUTIVE_COMMITTING)
        finish(executive, SSV_EXECUTIVE_REFUSED, reason); // nothing has begun that would have to be stopped
    else {
        stop(executive, now_us, SSV_EXECUTIVE_REFUSED);
        executive->reason = reason;
    }
}

static void take_answer(ssv_executive_t* executive, int64_t now_us, const ssv_link_planner_event_t* event) {
    const ssv_link_command_t what = event->of.answer.command;
    executive->commanded = false;
    if (!is_under_way(executive)) return; // a command that was repeated since its answer was lost
    if (event->of.answer.result != SSV_LINK_ACCEPTED) {
        take_refusal(executive, now_us, what, event->of.answer.result, event->of.answer.reason);
    } else if (what == SSV_LINK_COMMIT && executive->state == SSV_EXECUTIVE_COMMITTING) {
        enter(executive, SSV_EXECUTIVE_ARMING);
    } else if (what == SSV_LINK_ARM && executive->state == SSV_EXECUTIVE_ARMING) {
        if (executive->vehicle.phase == SSV_LINK_STOPPED)
            executive->vehicle.phase = SSV_LINK_DISARMED; // what it was asked for; now it may be armed
        else
            enter(executive, SSV_EXECUTIVE_STARTING);
    } else if (what == SSV_LINK_START && executive->state == SSV_EXECUTIVE_STARTING) {
        begin_tracking(executive, now_us);
    }
}

static void take_text(ssv_executive_t* executive, const ssv_link_planner_event_t* event) {
    executive->num_texts++;
    executive->severity = event->of.text.severity;
    memcpy(executive->text, event->of.text.text, sizeof executive->text);
}

static void take(ssv_executive_t* executive, int64_t now_us, const ssv_link_planner_event_t* event) {
    switch (event->kind) {
        case SSV_LINK_PLANNER_EXECUTION: take_execution(executive, now_us, &event->of.execution); break;
        case SSV_LINK_PLANNER_ATTITUDE:
            take_attitude(executive, event->of.pose.time_boot_ms, &event->of.pose.pose);
            break;
        case SSV_LINK_PLANNER_POSITION:
            take_position(executive, event->of.pose.time_boot_ms, &event->of.pose.pose);
            break;
        case SSV_LINK_PLANNER_THRUSTS: memcpy(executive->u_N, event->of.u_N, sizeof executive->u_N); break;
        case SSV_LINK_PLANNER_TEXT: take_text(executive, event); break;
        case SSV_LINK_PLANNER_HEALTH:
            executive->health.lost = event->of.health.lost;
            executive->health.bad_crc = event->of.health.bad_crc;
            executive->health.bad_signature = event->of.health.bad_signature;
            break;
        case SSV_LINK_PLANNER_ANSWERED: take_answer(executive, now_us, event); break;
        case SSV_LINK_PLANNER_UPLOADED:
            if (executive->state == SSV_EXECUTIVE_UPLOADING) enter(executive, SSV_EXECUTIVE_COMMITTING);
            break;
        case SSV_LINK_PLANNER_UPLOAD_FAILED:
            if (executive->state == SSV_EXECUTIVE_UPLOADING)
                finish(executive, event->of.upload == SSV_LINK_NOTHING ? SSV_EXECUTIVE_SILENT : SSV_EXECUTIVE_REFUSED,
                       event->of.upload);
            break;
        default: break;
    }
}

void ssv_executive_receive(ssv_executive_t* executive, int64_t now_us, const uint8_t* bytes, size_t num_bytes) {
    ssv_link_planner_event_t event;
    do {
        const size_t taken = ssv_link_planner_receive(&executive->link, now_us, bytes, num_bytes, &event);
        bytes += taken;
        num_bytes -= taken;
        take(executive, now_us, &event);
    } while (num_bytes > 0 || event.kind != SSV_LINK_PLANNER_NOTHING);
}

// ---- The control loop -----------------------------------------------------------------------------------------------

static void seek(ssv_executive_t* executive, int64_t now_us) {
    const ssv_link_phase_t phase = executive->vehicle.phase;
    const bool is_heard = executive->heard && now_us - executive->heard_us < SILENCE_US;
    if (is_heard && (phase == SSV_LINK_EXECUTING || phase == SSV_LINK_HOLDING)) {
        finish(executive, SSV_EXECUTIVE_REFUSED, SSV_LINK_BUSY);
    } else if (is_heard && phase != SSV_LINK_BRAKING) {
        ssv_link_planner_upload(&executive->link, executive->file, executive->length);
        enter(executive, SSV_EXECUTIVE_UPLOADING);
        executive->uploaded = 0;
        executive->uploaded_us = now_us;
    } else if (!is_heard && now_us - executive->begun_us > SEEK_US) {
        finish(executive, SSV_EXECUTIVE_SILENT, SSV_LINK_NO_REASON);
    }
}

static void watch_upload(ssv_executive_t* executive, int64_t now_us) {
    const size_t uploaded = ssv_link_planner_uploaded(&executive->link);
    if (uploaded != executive->uploaded) {
        executive->uploaded = uploaded;
        executive->uploaded_us = now_us;
    } else if (now_us - executive->uploaded_us > UPLOAD_US) {
        finish(executive, SSV_EXECUTIVE_SILENT, SSV_LINK_NO_REASON);
    }
}

// Lets the beam be taken hold of or docked where guidance wants it and the vehicle waits for it.
static void attempt(ssv_executive_t* executive, int64_t now_us) {
    const ssv_link_execution_t* vehicle = &executive->vehicle;
    ssv_guidance_t* guidance = &executive->guidance;
    if (vehicle->attempts != executive->attempts) {
        executive->attempts = vehicle->attempts;
        executive->asked_attempt = false;
        ssv_guidance_attempted(guidance, vehicle->events > (guidance->mated ? 1 : 0));
    }
    if (executive->turn.command.attempt != SSV_ATTEMPT_NONE && !executive->asked_attempt && !executive->commanded &&
        vehicle->phase == SSV_LINK_HOLDING) {
        command(executive, now_us, SSV_LINK_PAUSE_CONTINUE, 1);
        executive->asked_attempt = true;
    }
}

// The vehicle that somebody has paused waits; the one that was paused at a mate or dock waits there anyway.
static void pause(ssv_executive_t* executive, int64_t now_us) {
    const ssv_link_execution_t* vehicle = &executive->vehicle;
    const bool is_paused = vehicle->phase == SSV_LINK_HOLDING && vehicle->reason == SSV_LINK_COMMANDED;
    ssv_guidance_pause(&executive->guidance, is_paused || executive->wants_pause);
    if (executive->commanded) return;
    if (executive->wants_pause && vehicle->phase == SSV_LINK_EXECUTING) {
        command(executive, now_us, SSV_LINK_PAUSE_CONTINUE, 0);
        executive->has_paused = true;
    } else if (!executive->wants_pause && executive->has_paused) {
        executive->has_paused = false;
        if (is_paused) command(executive, now_us, SSV_LINK_PAUSE_CONTINUE, 1);
    }
}

static void send_trims(ssv_executive_t* executive) {
    const ssv_guidance_command_t* turn = &executive->turn.command;
    const int64_t event_ns = executive->event_ns[executive->guidance.mated ? 1 : 0];
    const bool is_there = turn->state != SSV_GUIDANCE_FLYING;
    const int64_t time_ns = real_to_nano(turn->plan_time_s);
    float trim_N[SSV_NUM_THRUSTERS];
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) trim_N[i] = real_to_float(turn->trim_N[i]);
    // The plan's times are rounded, and the vehicle waits for an event right at its own.
    ssv_link_planner_trim(&executive->link, executive->session, ++executive->sequence,
                          is_there || time_ns > event_ns ? event_ns : time_ns, real_to_float(turn->clock_rate), trim_N);
}

static void track(ssv_executive_t* executive, int64_t now_us, int64_t span_us) {
    const ssv_link_execution_t* vehicle = &executive->vehicle;
    ssv_guidance_command_t* turn = &executive->turn.command;
    const int64_t longest_us = 2 * (real_to_nano(executive->plan->quote.time_s) / 1000) + GRACE_US;
    attempt(executive, now_us);
    if (vehicle->phase != SSV_LINK_EXECUTING && vehicle->phase != SSV_LINK_HOLDING) {
        finish(executive, vehicle->events == 2 ? SSV_EXECUTIVE_DOCKED : SSV_EXECUTIVE_HALTED,
               vehicle->events == 2 ? SSV_LINK_NO_REASON : vehicle->reason);
        return;
    }
    pause(executive, now_us);
    const real_t span_s = real_from_double(1e-6 * (double)span_us);
    ssv_guidance_step(&executive->guidance, span_s, turn);
    executive->turn.at_us = now_us;
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) executive->impulse_Ns += real_mul(span_s, real_abs(turn->u_N[i]));
    send_trims(executive);
    executive->num_strays = turn->replan ? executive->num_strays + 1 : 0;
    if (turn->state == SSV_GUIDANCE_ABORTED)
        stop(executive, now_us, SSV_EXECUTIVE_MISSED);
    else if (executive->num_strays > STRAYS_MAX || now_us - executive->started_us > longest_us)
        stop(executive, now_us, SSV_EXECUTIVE_STRAYED);
}

static void await_stop(ssv_executive_t* executive, int64_t now_us) {
    const ssv_link_phase_t phase = executive->vehicle.phase;
    if (phase == SSV_LINK_STOPPED || phase == SSV_LINK_DISARMED)
        finish(executive, executive->outcome_to_be, executive->reason);
    else if (now_us - executive->stopping_us > STOP_US)
        finish(executive, SSV_EXECUTIVE_SILENT, SSV_LINK_NO_REASON);
    else if (phase != SSV_LINK_BRAKING)
        command(executive, now_us, SSV_LINK_TERMINATE, 1);
}

void ssv_executive_step(ssv_executive_t* executive, int64_t now_us) {
    int64_t span_us = SSV_EXECUTIVE_STEP_US;
    if (now_us - executive->due_us > span_us) span_us = now_us - executive->due_us;
    if (span_us > STEP_MAX_US) span_us = STEP_MAX_US;
    if (executive->state > SSV_EXECUTIVE_UPLOADING) // which has the line for itself
        ssv_link_planner_beat(&executive->link, executive->session, ++executive->progress);
    if (executive->state > SSV_EXECUTIVE_SEEKING && now_us - executive->heard_us > SILENCE_US)
        finish(executive, SSV_EXECUTIVE_SILENT, SSV_LINK_NO_REASON);
    switch (executive->state) {
        case SSV_EXECUTIVE_SEEKING: seek(executive, now_us); break;
        case SSV_EXECUTIVE_UPLOADING: watch_upload(executive, now_us); break;
        case SSV_EXECUTIVE_COMMITTING: command(executive, now_us, SSV_LINK_COMMIT, 0); break;
        case SSV_EXECUTIVE_ARMING:
            command(executive, now_us, SSV_LINK_ARM, executive->vehicle.phase != SSV_LINK_STOPPED);
            break;
        case SSV_EXECUTIVE_STARTING: command(executive, now_us, SSV_LINK_START, 0); break;
        case SSV_EXECUTIVE_TRACKING: track(executive, now_us, span_us); break;
        case SSV_EXECUTIVE_STOPPING: await_stop(executive, now_us); break;
        default: break;
    }
    executive->due_us += span_us;
}

size_t ssv_executive_poll(ssv_executive_t* executive, int64_t now_us, uint8_t* frame) {
    return ssv_link_planner_poll(&executive->link, now_us, frame);
}
