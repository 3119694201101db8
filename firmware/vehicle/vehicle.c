// The controller: phases, commands, brake, and what a tick does.
#include "vehicle/deadman.h"
#include "vehicle/execution.h"
#include "vehicle/thrust.h"

#include <string.h>

/// [ns] A trim reckoned for a moment farther than this from the vehicle's own plan time is not for now.
#define TRIM_APART_NS INT64_C(1000000000)
/// The clocks of planner and vehicle meet within some so many ticks, and the timeline never goes on by more than this.
#define CLOCK_TICKS 16
#define CLOCK_TICK_MAX_NS (1250 * SSV_VEHICLE_TICK_US)

/// [m, m/s, rad/s] Navigation beyond this is taken for none.
#define NAVIGATION_MAX 1e5F
/// [-] An attitude whose square is farther from 1 than this is none: a brake by it could push where it ought to stop.
#define UNIT_TOLERANCE 0.01F

static bool is_flying(const ssv_controller_t* vehicle) {
    return vehicle->state.phase == SSV_LINK_EXECUTING || vehicle->state.phase == SSV_LINK_HOLDING;
}

static float clip(float value, float most) { return value > most ? most : value < -most ? -most : value; }

static void enter(ssv_controller_t* vehicle, ssv_link_phase_t phase, ssv_link_reason_t reason) {
    vehicle->state.phase = phase;
    vehicle->state.reason = reason;
    vehicle->state.may_swap = !is_flying(vehicle) && phase != SSV_LINK_BRAKING;
    vehicle->is_slowing = false;
    if (!is_flying(vehicle)) {
        ssv_deadman_release(&vehicle->deadman);
        vehicle->has_trim = vehicle->attempts = vehicle->awaits = false;
    }
}

static void slow_down(ssv_controller_t* vehicle, int64_t now_us) {
    vehicle->is_slowing = true;
    vehicle->slowing_us = now_us;
}

static void stop(ssv_controller_t* vehicle, int64_t now_us, ssv_link_reason_t reason) {
    enter(vehicle, SSV_LINK_BRAKING, reason);
    slow_down(vehicle, now_us);
    ssv_link_vehicle_say(&vehicle->link, now_us, SSV_LINK_CRITICAL, "safe-stop: brakes");
}

static void hold(ssv_controller_t* vehicle, int64_t now_us, ssv_link_reason_t reason) {
    enter(vehicle, SSV_LINK_HOLDING, reason);
    slow_down(vehicle, now_us);
    ssv_link_vehicle_say(&vehicle->link, now_us, SSV_LINK_NOTICE, "holds");
}

// ---- Set-up ---------------------------------------------------------------------------------------------------------

static bool is_sound(const ssv_vehicle_config_t* config) {
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
        if (!ssv_thrust_is_sound(&config->curve[k])) return false;
    }
    return config->link.force_max_N > 0 && config->thrust_max_N >= config->link.force_max_N &&
           config->beat_warn_us > 0 && config->beat_stop_us > 0 && config->trim_hold_us > 0 &&
           config->trim_ramp_us > 0 && config->trim_stop_us > 0 && config->trim_max_N >= 0 && config->brake_kg_s >= 0 &&
           config->brake_Nm_s >= 0 && config->brake_max_us > 0 && config->navigation_stale_us > 0;
}

bool ssv_vehicle_init(ssv_controller_t* vehicle, const ssv_vehicle_config_t* config) {
    memset(vehicle, 0, sizeof *vehicle);
    vehicle->config = config;
    vehicle->force_scale = 1;
    ssv_link_vehicle_init(&vehicle->link, &config->link);
    enter(vehicle, SSV_LINK_DISARMED, SSV_LINK_NO_REASON);
    return is_sound(config);
}

// No number compares as smaller than anything.
static bool are_sound(const float* value, int count) {
    for (int i = 0; i < count; i++) {
        if (!(value[i] > -NAVIGATION_MAX && value[i] < NAVIGATION_MAX)) return false;
    }
    return true;
}

static bool is_unit(const float q[4]) {
    const float excess = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1;
    return excess > -UNIT_TOLERANCE && excess < UNIT_TOLERANCE;
}

void ssv_vehicle_navigate(ssv_controller_t* vehicle, int64_t held_us, const ssv_link_pose_t* pose) {
    if (!are_sound(pose->p_IS_m, 3) || !are_sound(pose->q_IS, 4) || !are_sound(pose->v_IS_m_s, 3) ||
        !are_sound(pose->w_IS_S_rad_s, 3) || !is_unit(pose->q_IS))
        return;
    vehicle->state.pose = *pose;
    vehicle->state.pose.known = true;
    vehicle->state.pose_us = held_us;
}

void ssv_vehicle_supply(ssv_controller_t* vehicle, float force_scale) {
    vehicle->force_scale = force_scale > 4 ? 4 : force_scale >= 0.25F ? force_scale : 0.25F;
}

// ---- Commands -------------------------------------------------------------------------------------------------------

// Why the vehicle in its phase obeys nothing but to disarm and to stop; SSV_LINK_NO_REASON when it does.
static ssv_link_reason_t deafness(const ssv_controller_t* vehicle) {
    const ssv_link_phase_t phase = vehicle->state.phase;
    if (phase == SSV_LINK_DISARMED) return SSV_LINK_NOT_ARMED;
    return phase == SSV_LINK_BRAKING || phase == SSV_LINK_STOPPED ? vehicle->state.reason : SSV_LINK_NO_REASON;
}

static ssv_link_reason_t arm(ssv_controller_t* vehicle, bool on) {
    if (!on) {
        if (vehicle->state.phase != SSV_LINK_DISARMED) enter(vehicle, SSV_LINK_DISARMED, SSV_LINK_COMMANDED);
        return SSV_LINK_NO_REASON;
    }
    if (vehicle->state.phase == SSV_LINK_DISARMED) {
        enter(vehicle, SSV_LINK_READY, SSV_LINK_NO_REASON);
        return SSV_LINK_NO_REASON;
    }
    return deafness(vehicle);
}

static ssv_link_reason_t pause(ssv_controller_t* vehicle, int64_t now_us) {
    if (deafness(vehicle) != SSV_LINK_NO_REASON) return deafness(vehicle);
    if (!is_flying(vehicle)) return SSV_LINK_NOTHING;
    if (vehicle->state.phase == SSV_LINK_EXECUTING) hold(vehicle, now_us, SSV_LINK_COMMANDED);
    return SSV_LINK_NO_REASON;
}

static ssv_link_reason_t go_on(ssv_controller_t* vehicle) {
    if (deafness(vehicle) != SSV_LINK_NO_REASON) return deafness(vehicle);
    if (!is_flying(vehicle)) return SSV_LINK_NOTHING;
    if (vehicle->state.phase == SSV_LINK_HOLDING) {
        enter(vehicle, SSV_LINK_EXECUTING, SSV_LINK_NO_REASON);
        vehicle->attempts = ssv_execution_is_at_event(&vehicle->execution) && !vehicle->awaits;
    }
    return SSV_LINK_NO_REASON;
}

static ssv_link_reason_t terminate(ssv_controller_t* vehicle, int64_t now_us) {
    const ssv_link_phase_t phase = vehicle->state.phase;
    if (phase != SSV_LINK_DISARMED && phase != SSV_LINK_BRAKING && phase != SSV_LINK_STOPPED)
        stop(vehicle, now_us, SSV_LINK_COMMANDED);
    return SSV_LINK_NO_REASON;
}

// A start that comes again finds its timeline started.
static ssv_link_reason_t start(ssv_controller_t* vehicle, int64_t now_us, const ssv_link_vehicle_event_t* event) {
    if (deafness(vehicle) != SSV_LINK_NO_REASON) return deafness(vehicle);
    if (vehicle->has_started) return vehicle->state.phase == SSV_LINK_READY ? SSV_LINK_NOTHING : SSV_LINK_NO_REASON;
    if (!vehicle->state.pose.known) return SSV_LINK_START_POSE;
    if (!ssv_deadman_bind(&vehicle->deadman, now_us, vehicle->config->beat_warn_us, event->sysid, event->compid))
        return SSV_LINK_BEAT_LOST;
    ssv_execution_begin(&vehicle->execution, ssv_link_vehicle_live(&vehicle->link, NULL));
    memset(vehicle->carried_N, 0, sizeof vehicle->carried_N);
    vehicle->has_started = true;
    vehicle->has_trim = vehicle->attempts = vehicle->awaits = false;
    vehicle->trim_sequence = 0;
    vehicle->clock_rate = 1;
    vehicle->clock_ahead_ns = 0;
    vehicle->state.events = vehicle->state.attempts = 0;
    enter(vehicle, SSV_LINK_EXECUTING, SSV_LINK_NO_REASON);
    ssv_link_vehicle_say(&vehicle->link, now_us, SSV_LINK_INFO, "timeline started");
    return SSV_LINK_NO_REASON;
}

static ssv_link_reason_t obey(ssv_controller_t* vehicle, int64_t now_us, const ssv_link_vehicle_event_t* event) {
    const bool on = event->of.command.value == 1;
    switch (event->of.command.command) {
        case SSV_LINK_ARM: return arm(vehicle, on);
        case SSV_LINK_PAUSE_CONTINUE: return on ? go_on(vehicle) : pause(vehicle, now_us);
        case SSV_LINK_TERMINATE: return terminate(vehicle, now_us);
        case SSV_LINK_START: return start(vehicle, now_us, event);
        default: return SSV_LINK_INTERNAL;
    }
}

static void take_trim(ssv_controller_t* vehicle, int64_t now_us, const ssv_link_vehicle_event_t* event) {
    const ssv_link_trim_t* trim = &event->of.trim;
    const int64_t apart_ns = trim->plan_time_ns / 2 - vehicle->state.plan_time_ns / 2; // halves cannot overflow
    if (!is_flying(vehicle) || !ssv_deadman_is_ahead(trim->sequence, vehicle->trim_sequence) ||
        !ssv_deadman_is_bound_to(&vehicle->deadman, event->sysid, event->compid, trim->boot_id, trim->session) ||
        apart_ns > TRIM_APART_NS / 2 || apart_ns < -TRIM_APART_NS / 2)
        return;
    vehicle->trim_sequence = trim->sequence;
    vehicle->has_trim = true;
    vehicle->trim_us = now_us;
    vehicle->clock_rate = trim->clock_rate;
    vehicle->clock_ahead_ns = trim->plan_time_ns - vehicle->execution.plan_time_ns;
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) vehicle->trim_N[k] = clip(trim->trim_N[k], vehicle->config->trim_max_N);
}

static void take(ssv_controller_t* vehicle, int64_t now_us, const ssv_link_vehicle_event_t* event) {
    ssv_link_reason_t reason;
    switch (event->kind) {
        case SSV_LINK_VEHICLE_COMMANDED:
            reason = obey(vehicle, now_us, event);
            ssv_link_vehicle_answer(&vehicle->link, event,
                                    reason == SSV_LINK_NO_REASON ? SSV_LINK_ACCEPTED : SSV_LINK_DENIED, reason);
            break;
        case SSV_LINK_VEHICLE_COMMITTED:
            vehicle->has_started = false;
            vehicle->state.plan_time_ns = 0;
            vehicle->state.segment = 0;
            vehicle->state.events = vehicle->state.attempts = 0;
            if (vehicle->state.phase == SSV_LINK_DONE) enter(vehicle, SSV_LINK_READY, SSV_LINK_NO_REASON);
            break;
        case SSV_LINK_VEHICLE_BEAT:
            if (ssv_deadman_beat(&vehicle->deadman, now_us, vehicle->config->beat_warn_us, event->sysid, event->compid,
                                 &event->of.beat))
                vehicle->state.beat = event->of.beat.progress;
            break;
        case SSV_LINK_VEHICLE_TRIM: take_trim(vehicle, now_us, event); break;
        default: break;
    }
}

void ssv_vehicle_receive(ssv_controller_t* vehicle, int64_t now_us, const uint8_t* bytes, size_t num_bytes) {
    ssv_link_vehicle_event_t event;
    do {
        const size_t taken =
            ssv_link_vehicle_receive(&vehicle->link, now_us, &vehicle->state, bytes, num_bytes, &event);
        bytes += taken;
        num_bytes -= taken;
        take(vehicle, now_us, &event);
    } while (num_bytes > 0 || event.kind != SSV_LINK_VEHICLE_NOTHING);
}

size_t ssv_vehicle_poll(ssv_controller_t* vehicle, int64_t now_us, uint8_t* frame) {
    return ssv_link_vehicle_poll(&vehicle->link, now_us, &vehicle->state, frame);
}

// ---- A tick ---------------------------------------------------------------------------------------------------------

static void check_planner(ssv_controller_t* vehicle, int64_t now_us) {
    ssv_deadman_t* deadman = &vehicle->deadman;
    const int64_t silent_us = now_us - deadman->grew_us;
    const bool is_untrimmed = vehicle->has_trim && now_us - vehicle->trim_us > vehicle->config->trim_stop_us;
    if (silent_us > vehicle->config->beat_stop_us || is_untrimmed) {
        stop(vehicle, now_us, SSV_LINK_BEAT_LOST);
    } else if (silent_us > vehicle->config->beat_warn_us && !deadman->has_warned) {
        deadman->has_warned = true;
        ssv_link_vehicle_say(&vehicle->link, now_us, SSV_LINK_WARNING, "planner makes no progress");
    }
}

static float square(const float a[3]) { return a[0] * a[0] + a[1] * a[1] + a[2] * a[2]; }

// v in axes of S: R^T v = v + 2 (w (v x r) + (v x r) x r), r the vector part of q_IS and w its scalar.
static void in_axes_of_S(const float q[4], const float v[3], float out[3]) {
    const float t[3] = {v[1] * q[3] - v[2] * q[2], v[2] * q[1] - v[0] * q[3], v[0] * q[2] - v[1] * q[1]};
    out[0] = v[0] + 2 * (q[0] * t[0] + t[1] * q[3] - t[2] * q[2]);
    out[1] = v[1] + 2 * (q[0] * t[1] + t[2] * q[1] - t[0] * q[3]);
    out[2] = v[2] + 2 * (q[0] * t[2] + t[0] * q[2] - t[1] * q[1]);
}

// The braking thrusts, all scaled alike where one is too large, so that the wrench keeps its direction and takes energy
// from any motion. False, and no thrust, once the vehicle is slow, the time is over or nobody knows how it moves.
static bool brake(const ssv_controller_t* vehicle, int64_t now_us, float u_N[SSV_NUM_THRUSTERS]) {
    const ssv_vehicle_config_t* config = vehicle->config;
    const ssv_link_pose_t* pose = &vehicle->state.pose;
    float v_S[3], wrench[6], largest_N = 0;
    if (!pose->known || now_us - vehicle->slowing_us > config->brake_max_us) return false;
    if (square(pose->v_IS_m_s) < config->brake_speed_m_s * config->brake_speed_m_s &&
        square(pose->w_IS_S_rad_s) < config->brake_rate_rad_s * config->brake_rate_rad_s)
        return false;
    in_axes_of_S(pose->q_IS, pose->v_IS_m_s, v_S);
    for (int i = 0; i < 3; i++) {
        wrench[i] = -config->brake_kg_s * v_S[i];
        wrench[3 + i] = -config->brake_Nm_s * pose->w_IS_S_rad_s[i];
    }
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
        u_N[k] = 0;
        for (int i = 0; i < 6; i++) u_N[k] += config->u_per_wrench[k][i] * wrench[i];
        const float size_N = u_N[k] < 0 ? -u_N[k] : u_N[k];
        if (size_N > largest_N) largest_N = size_N;
    }
    if (largest_N > config->thrust_max_N) {
        for (int k = 0; k < SSV_NUM_THRUSTERS; k++) u_N[k] *= config->thrust_max_N / largest_N;
    }
    return true;
}

// How much of the newest trim counts.
static float share_of_trim(const ssv_controller_t* vehicle, int64_t now_us) {
    const int64_t fading_us = now_us - vehicle->trim_us - vehicle->config->trim_hold_us;
    if (!vehicle->has_trim || fading_us >= vehicle->config->trim_ramp_us) return 0;
    return fading_us <= 0 ? 1 : 1 - (float)fading_us / (float)vehicle->config->trim_ramp_us;
}

static void add_trim(const ssv_controller_t* vehicle, int64_t now_us, float u_N[SSV_NUM_THRUSTERS]) {
    const float share = share_of_trim(vehicle, now_us);
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) u_N[k] += share * vehicle->trim_N[k];
}

// How far the timeline goes on in this tick: as far as the planner's clock of it, and a little more or less to meet it.
static int64_t passing_ns(ssv_controller_t* vehicle) {
    const int32_t planned_ns = (int32_t)(vehicle->clock_rate * (float)(1000 * SSV_VEHICLE_TICK_US));
    const int64_t meeting_ns = vehicle->clock_ahead_ns / CLOCK_TICKS + (vehicle->clock_ahead_ns > 0 ? 1 : 0);
    int64_t passing = planned_ns + meeting_ns;
    if (passing < 0) passing = 0;
    if (passing > CLOCK_TICK_MAX_NS) passing = CLOCK_TICK_MAX_NS;
    vehicle->clock_ahead_ns -= passing - planned_ns;
    return passing;
}

static void execute(ssv_controller_t* vehicle, int64_t now_us, float u_N[SSV_NUM_THRUSTERS],
                    ssv_vehicle_output_t* output) {
    const ssv_vehicle_config_t* config = vehicle->config;
    ssv_execution_t* execution = &vehicle->execution;
    ssv_execution_advance(execution, passing_ns(vehicle), config->thrust_max_N,
                          config->thrust_max_N - config->link.force_max_N, u_N);
    vehicle->state.plan_time_ns = execution->plan_time_ns;
    vehicle->state.segment = execution->segment;
    if (ssv_execution_is_at_event(execution)) {
        if (!vehicle->awaits && !vehicle->attempts && vehicle->has_trim) {
            hold(vehicle, now_us, SSV_LINK_NO_REASON);
        } else if (!vehicle->awaits) {
            vehicle->attempts = false;
            vehicle->awaits = output->attempts = true;
            output->event = execution->event[execution->next_event];
        }
    } else if (ssv_execution_is_over(execution)) {
        enter(vehicle, SSV_LINK_DONE, SSV_LINK_NO_REASON);
        ssv_link_vehicle_say(&vehicle->link, now_us, SSV_LINK_INFO, "timeline flown");
    }
}

// What the thrusters should give in this tick.
static void demand(ssv_controller_t* vehicle, int64_t now_us, float u_N[SSV_NUM_THRUSTERS],
                   ssv_vehicle_output_t* output) {
    memset(u_N, 0, SSV_NUM_THRUSTERS * sizeof *u_N);
    if (is_flying(vehicle)) check_planner(vehicle, now_us);
    // Who is trimmed in the hold is held by the planner, who knows better.
    if (is_flying(vehicle) && share_of_trim(vehicle, now_us) > 0) vehicle->is_slowing = false;
    if (vehicle->is_slowing) vehicle->is_slowing = brake(vehicle, now_us, u_N);
    switch (vehicle->state.phase) {
        case SSV_LINK_EXECUTING: execute(vehicle, now_us, u_N, output); break;
        case SSV_LINK_BRAKING:
            if (!vehicle->is_slowing) {
                enter(vehicle, SSV_LINK_STOPPED, vehicle->state.reason);
                ssv_link_vehicle_say(&vehicle->link, now_us, SSV_LINK_CRITICAL, "safe-stop: stopped");
            }
            break;
        default: break;
    }
    if (is_flying(vehicle)) add_trim(vehicle, now_us, u_N);
}

static float no_number(void) {
    const uint32_t bits = UINT32_C(0x7fc00000);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

void ssv_vehicle_tick(ssv_controller_t* vehicle, int64_t now_us, ssv_vehicle_output_t* output) {
    float u_N[SSV_NUM_THRUSTERS];
    memset(output, 0, sizeof *output);
    if (now_us - vehicle->state.pose_us > vehicle->config->navigation_stale_us) vehicle->state.pose.known = false;
    demand(vehicle, now_us, u_N, output);
    output->is_armed = vehicle->state.phase != SSV_LINK_DISARMED;
    const bool thrusts =
        is_flying(vehicle) || vehicle->state.phase == SSV_LINK_BRAKING || vehicle->state.phase == SSV_LINK_DONE;
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
        if (!thrusts) vehicle->carried_N[k] = 0;
        if (!output->is_armed)
            output->effort[k] = no_number();
        else if (thrusts)
            output->effort[k] =
                ssv_thrust_effort(&vehicle->config->curve[k], vehicle->force_scale, vehicle->config->thrust_max_N,
                                  u_N[k], &vehicle->carried_N[k], &output->u_N[k]);
        vehicle->state.u_N[k] = output->u_N[k];
    }
}

void ssv_vehicle_attempted(ssv_controller_t* vehicle, int64_t now_us, bool hit) {
    if (!vehicle->awaits) return;
    const bool docks = vehicle->execution.event[vehicle->execution.next_event].kind == SSV_DOCK;
    vehicle->awaits = false;
    vehicle->state.attempts++;
    if (!hit) {
        hold(vehicle, now_us, SSV_LINK_TRACKING);
        ssv_link_vehicle_say(&vehicle->link, now_us, SSV_LINK_WARNING, docks ? "missed the port" : "missed the beam");
        return;
    }
    ssv_execution_pass_event(&vehicle->execution);
    vehicle->state.events++;
    ssv_link_vehicle_say(&vehicle->link, now_us, SSV_LINK_NOTICE, docks ? "docked" : "mated");
}
