// The plan followed: reference and clock, dwell before mate and dock, back-off and giving up.
#include "ssv/guidance.h"
#include "guidance/law.h"
#include "guidance/limits.h"
#include "guidance/observer.h"
#include "planner/model/grasp.h"

static vec3_t zero(void) { return vec3(REAL(0), REAL(0), REAL(0)); }

void ssv_guidance_init(ssv_guidance_t* guidance, const ssv_problem_t* problem, const ssv_plan_t* plan,
                       const ssv_guidance_config_t* config) {
    memset(guidance, 0, sizeof *guidance);
    guidance->problem = problem;
    guidance->plan = plan;
    guidance->config = *config;
    guidance->estimate.X_IS = problem->scenario.X_IS;
    guidance->X_SB = plan->X_SB;
    ssv_observer_set_body(guidance);
    ssv_observer_restart(guidance);
}

static void enter(ssv_guidance_t* guidance, ssv_guidance_state_t state) {
    guidance->state = state;
    guidance->attempt = SSV_ATTEMPT_NONE;
    guidance->in_state_s = guidance->inside_s = REAL(0);
    if (state != SSV_GUIDANCE_DWELLING) guidance->held_s = REAL(0);
}

static real_t end_of_phase_s(const ssv_guidance_t* guidance) {
    return guidance->mated ? guidance->plan->quote.time_s : guidance->plan->event[0].t_s;
}

// Where this phase ends: the vehicle at the beam where it lies, or the beam in the port, held as it was taken.
static pose_t place(const ssv_guidance_t* guidance) {
    const pose_t X_IB = guidance->mated ? guidance->plan->quote.X_IB_final : guidance->problem->scenario.X_IB;
    return pose_mul(X_IB, pose_inv(guidance->X_SB));
}

// Out of the port, or away from the beam's side: the vehicle's contact is on +x.
static vec3_t way_out_I(const ssv_guidance_t* guidance, pose_t X_IS) {
    if (guidance->mated) return guidance->problem->scenario.axis_I;
    return quat_apply(X_IS.q, vec3(REAL(-1), REAL(0), REAL(0)));
}

static real_t back_off_most_m(const ssv_guidance_t* guidance) {
    return guidance->problem->around.counts ? BACK_OFF_NEAR_M : BACK_OFF_M;
}

static real_t backing_speed_m_s(const ssv_guidance_t* guidance) {
    return guidance->back_off_m < back_off_most_m(guidance) ? BACK_OFF_M_S : REAL(0);
}

// Impulse of the timeline from t_s on for span_s, spread over dt_s: a thrust that jumps within a step would be off by
// as much as it jumps, and a pair with a long lever remembers that.
static void spread_thrust(const ssv_plan_t* plan, real_t t_s, real_t span_s, real_t dt_s,
                          real_t u_N[SSV_NUM_THRUSTERS]) {
    for (int k = 0; k < plan->num_segments; k++) {
        const ssv_segment_t* segment = &plan->segment[k];
        const real_t from = real_max(t_s, segment->t_s) - segment->t_s;
        const real_t to = real_min(t_s + span_s, segment->t_s + segment->duration_s) - segment->t_s;
        if (to <= from) continue;
        const real_t share = real_div(to - from, dt_s);
        const real_t along = real_div(real_mul(REAL(0.5), from + to), segment->duration_s);
        for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
            const real_t middle = segment->u_start_N[i] + real_mul(along, segment->u_end_N[i] - segment->u_start_N[i]);
            u_N[i] += real_mul(share, middle);
        }
    }
}

// The plan's motion, for the vehicle that carries the beam as it was taken hold of and not as planned.
static ssv_reference_t reference_of_plan(const ssv_guidance_t* guidance) {
    const ssv_plan_t* plan = guidance->plan;
    ssv_sample_t now;
    ssv_plan_sample(plan, guidance->plan_time_s, &now);
    ssv_reference_t reference = {now.X_IS, now.v_IS_S_m_s, now.w_IS_S_rad_s, {REAL(0)}};
    if (guidance->mated) {
        const pose_t X = pose_mul(plan->X_SB, pose_inv(guidance->X_SB)); // the real S in the planned one
        reference.X_IS = pose_mul(now.X_IS, X);
        const quat_t back = quat_conj(X.q);
        reference.v_S_m_s = quat_apply(back, vec3_add(now.v_IS_S_m_s, vec3_cross(now.w_IS_S_rad_s, X.p)));
        reference.w_S_rad_s = quat_apply(back, now.w_IS_S_rad_s);
    }
    return reference;
}

static ssv_reference_t reference_at_place(const ssv_guidance_t* guidance) {
    ssv_reference_t reference = {place(guidance), zero(), zero(), {REAL(0)}};
    const vec3_t out_I = way_out_I(guidance, reference.X_IS);
    reference.X_IS.p = vec3_add(reference.X_IS.p, vec3_scale(guidance->back_off_m, out_I));
    const real_t speed = guidance->state == SSV_GUIDANCE_BACKING_OFF ? backing_speed_m_s(guidance)
                         : guidance->state == SSV_GUIDANCE_RETURNING ? -BACK_OFF_M_S
                                                                     : REAL(0);
    reference.v_S_m_s = vec3_scale(speed, quat_apply(quat_conj(reference.X_IS.q), out_I));
    return reference;
}

// How far behind along a direction of motion; the direction means nothing at rest.
static real_t lag(vec3_t error, vec3_t rate, real_t speed_min) {
    const real_t speed = vec3_norm(rate);
    return speed > speed_min ? -real_div(vec3_dot(error, rate), speed) : REAL(0);
}

static real_t rate_for(real_t lag, real_t limit) {
    return real_max(REAL(0), real_min(REAL(1), real_mul(REAL(1.25), REAL(1) - real_div(lag, limit))));
}

// Slower than these the reference counts as standing.
#define STANDS_M_S REAL(1e-3)
#define STANDS_RAD_S REAL(1e-3)

static real_t rate_of_clock(const ssv_guidance_t* guidance, const ssv_reference_t* reference,
                            const ssv_law_error_t* error) {
    const vec3_t v_I = quat_apply(
        reference->X_IS.q, vec3_add(reference->v_S_m_s, vec3_cross(reference->w_S_rad_s, guidance->body.p_SC_m)));
    const real_t moving = lag(error->position_I_m, v_I, STANDS_M_S);
    const real_t turning = lag(error->rotation_S_rad, reference->w_S_rad_s, STANDS_RAD_S);
    return real_min(rate_for(moving, CLOCK_LAG_M), rate_for(turning, CLOCK_LAG_RAD));
}

// The plan's motion and thrust at such a rate of its clock: the timeline's impulse over what passes, spread over dt_s.
// It ends with the phase, for what comes then is another body's.
static void run_at(const ssv_guidance_t* guidance, real_t rate, real_t dt_s, ssv_reference_t* reference) {
    const real_t span_s = real_min(real_mul(rate, dt_s), end_of_phase_s(guidance) - guidance->plan_time_s);
    reference->v_S_m_s = vec3_scale(rate, reference->v_S_m_s);
    reference->w_S_rad_s = vec3_scale(rate, reference->w_S_rad_s);
    if (span_s > REAL(0)) spread_thrust(guidance->plan, guidance->plan_time_s, span_s, dt_s, reference->u_N);
}

static void fill_in_error(const ssv_reference_t* reference, const ssv_law_error_t* error, ssv_guidance_error_t* out) {
    const vec3_t v_I = quat_apply(reference->X_IS.q, reference->v_S_m_s);
    const real_t size = vec3_norm(error->position_I_m);
    out->along_m = lag(error->position_I_m, v_I, STANDS_M_S);
    out->across_m = real_sqrt(real_max(real_sq(size) - real_sq(out->along_m), REAL(0)));
    out->angle_rad = vec3_norm(error->rotation_S_rad);
}

static void fill_in_tip(const ssv_guidance_t* guidance, ssv_guidance_error_t* out) {
    const ssv_estimate_t* x = &guidance->estimate;
    const ssv_scenario_t* s = &guidance->problem->scenario;
    if (!guidance->mated) {
        const pose_t off = pose_between(place(guidance), x->X_IS);
        out->tip_m = vec3_norm(off.p);
        out->tip_angle_rad = vec3_norm(ssv_observer_rotation(off.q));
        out->tip_speed_m_s = vec3_norm(x->v_S_m_s);
        return;
    }
    const vec3_t p_B = ssv_grasp_contact(s, guidance->plan->quote.choice.contact);
    const pose_t X_IB = pose_mul(x->X_IS, guidance->X_SB);
    const vec3_t p_S = vec3_add(guidance->X_SB.p, quat_apply(guidance->X_SB.q, p_B));
    const vec3_t tip_I = vec3_add(X_IB.p, quat_apply(X_IB.q, p_B));
    const vec3_t axis_I = vec3_unit(quat_apply(X_IB.q, p_B));
    out->tip_m = vec3_norm(vec3_sub(tip_I, s->p_IP_m));
    const real_t sine = vec3_norm(vec3_cross(axis_I, s->axis_I));
    out->tip_angle_rad = real_atan2(sine, -vec3_dot(axis_I, s->axis_I));
    out->tip_speed_m_s =
        real_max(vec3_norm(x->v_S_m_s), vec3_norm(vec3_add(x->v_S_m_s, vec3_cross(x->w_S_rad_s, p_S))));
}

/// How much of the tolerance counts after so long in the dwell.
static real_t share_after(real_t time_s) {
    const real_t waited = real_min(real_div(time_s, DWELL_LOOSEN_S), REAL(1));
    const real_t late = real_div(real_max(time_s - DWELL_PATIENCE_S, REAL(0)), DWELL_MAX_S - DWELL_PATIENCE_S);
    return DWELL_TIGHT + real_mul(waited, REAL(1) - DWELL_TIGHT) + real_mul(late, DWELL_LOOSE - REAL(1));
}

static void dwell(ssv_guidance_t* guidance, real_t dt_s, const ssv_guidance_error_t* error) {
    const real_t share = share_after(guidance->in_state_s);
    const bool inside =
        error->tip_m < real_mul(share, DWELL_TIP_M) && error->tip_angle_rad < real_mul(share, DWELL_ANGLE_RAD) &&
        error->tip_speed_m_s < real_mul(share, DWELL_SPEED_M_S) && guidance->in_state_s >= DWELL_LEAST_S;
    guidance->inside_s = inside ? guidance->inside_s + dt_s : REAL(0);
    if (guidance->inside_s >= DWELL_INSIDE_S) {
        guidance->attempt = guidance->mated ? SSV_ATTEMPT_DOCK : SSV_ATTEMPT_MATE;
    } else if (guidance->in_state_s > DWELL_MAX_S) {
        guidance->tries++;
        enter(guidance, SSV_GUIDANCE_BACKING_OFF);
    }
}

// Goes on to the end of the interval, in which the reference moves as it was said to.
static void go_on(ssv_guidance_t* guidance, real_t dt_s, real_t rate) {
    const real_t way = real_mul(BACK_OFF_M_S, dt_s);
    guidance->in_state_s += dt_s;
    if (guidance->state == SSV_GUIDANCE_DWELLING) guidance->held_s += dt_s;
    if (guidance->state == SSV_GUIDANCE_FLYING) {
        guidance->plan_time_s = real_min(guidance->plan_time_s + real_mul(rate, dt_s), end_of_phase_s(guidance));
        if (guidance->plan_time_s >= end_of_phase_s(guidance)) enter(guidance, SSV_GUIDANCE_DWELLING);
    } else if (guidance->state == SSV_GUIDANCE_BACKING_OFF) {
        guidance->back_off_m = real_min(guidance->back_off_m + way, back_off_most_m(guidance));
        const bool there = guidance->back_off_m >= back_off_most_m(guidance);
        const bool last = guidance->tries >= SSV_GUIDANCE_TRIES;
        if (there) guidance->held_s += dt_s;
        if (there && !last) enter(guidance, SSV_GUIDANCE_RETURNING);
        if (there && last && guidance->held_s >= BACK_OFF_REST_S) enter(guidance, SSV_GUIDANCE_ABORTED);
    } else if (guidance->state == SSV_GUIDANCE_RETURNING) {
        guidance->back_off_m = real_max(guidance->back_off_m - way, REAL(0));
        if (guidance->back_off_m <= REAL(0)) enter(guidance, SSV_GUIDANCE_DWELLING);
    }
}

void ssv_guidance_step(ssv_guidance_t* guidance, real_t dt_s, ssv_guidance_command_t* command) {
    memset(command, 0, sizeof *command);
    const bool flying = guidance->state == SSV_GUIDANCE_FLYING;
    ssv_reference_t reference = flying ? reference_of_plan(guidance) : reference_at_place(guidance);
    const ssv_reference_t at_full_rate = reference;
    ssv_law_error_t error = ssv_law_error(guidance, &reference);
    const real_t rate = flying && !guidance->paused ? rate_of_clock(guidance, &reference, &error) : REAL(0);
    if (flying) {
        run_at(guidance, rate, dt_s, &reference);
        error = ssv_law_error(guidance, &reference);
    }
    fill_in_error(&at_full_rate, &error, &command->error);
    fill_in_tip(guidance, &command->error);
    command->clock_rate = rate;
    command->plan_time_s = guidance->plan_time_s;
    command->replan = command->error.across_m > LOST_ACROSS_M || command->error.angle_rad > LOST_ANGLE_RAD;
    if (guidance->state != SSV_GUIDANCE_DONE) ssv_law_thrusts(guidance, &reference, &error, command->u_N);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        command->trim_N[i] = command->u_N[i] - reference.u_N[i];
        guidance->command_N[i] = command->u_N[i];
    }
    if (guidance->state == SSV_GUIDANCE_DWELLING && !guidance->paused) dwell(guidance, dt_s, &command->error);
    command->state = guidance->state;
    command->attempt = guidance->attempt;
    ssv_observer_predict(guidance, dt_s);
    go_on(guidance, dt_s, rate);
}

void ssv_guidance_pause(ssv_guidance_t* guidance, bool paused) { guidance->paused = paused; }

void ssv_guidance_attempted(ssv_guidance_t* guidance, bool hit) {
    if (guidance->state != SSV_GUIDANCE_DWELLING) return;
    if (!hit) {
        guidance->tries++;
        enter(guidance, SSV_GUIDANCE_BACKING_OFF);
    } else if (guidance->mated) {
        enter(guidance, SSV_GUIDANCE_DONE);
    } else {
        guidance->mated = true;
        guidance->tries = 0;
        guidance->X_SB = pose_between(guidance->estimate.X_IS, guidance->problem->scenario.X_IB);
        ssv_observer_set_body(guidance);
        enter(guidance, SSV_GUIDANCE_FLYING);
    }
}
