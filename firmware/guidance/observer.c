#include "guidance/observer.h"

#include "guidance/limits.h"

#define N 6

static vec3_t zero(void) { return vec3(REAL(0), REAL(0), REAL(0)); }

ssv_assembly_t ssv_observer_assembly(const ssv_guidance_t* guidance) {
    const ssv_scenario_t* s = &guidance->problem->scenario;
    return (ssv_assembly_t){&s->vehicle, guidance->mated ? &s->beam : NULL, guidance->X_SB};
}

static void put(real_t column[N], ssv_wrench_t wrench) {
    column[0] = wrench.force.x;
    column[1] = wrench.force.y;
    column[2] = wrench.force.z;
    column[3] = wrench.moment.x;
    column[4] = wrench.moment.y;
    column[5] = wrench.moment.z;
}

static void put_twist(real_t column[N], ssv_twist_t twist) { put(column, (ssv_wrench_t){twist.v, twist.w}); }

static real_t mean(vec3_t a) { return real_div(a.x + a.y + a.z, REAL(3)); }

void ssv_observer_set_body(ssv_guidance_t* guidance) {
    ssv_guidance_body_t* body = &guidance->body;
    const ssv_assembly_t assembly = ssv_observer_assembly(guidance);
    for (int c = 0; c < N; c++) {
        real_t e[N] = {REAL(0)};
        e[c] = REAL(1);
        ssv_demand_t demand;
        ssv_body_demand(&assembly, (ssv_twist_t){vec3(e[0], e[1], e[2]), vec3(e[3], e[4], e[5])}, &demand);
        real_t accel[N], linear[N];
        put(accel, demand.accel);
        put(linear, demand.linear);
        for (int r = 0; r < N; r++) {
            body->mass[r][c] = accel[r];
            body->drag[r][c] = linear[r];
        }
    }
    body->p_SC_m = ssv_body_centre(&assembly);
    body->mass_kg = mean(vec3(body->mass[0][0], body->mass[1][1], body->mass[2][2]));
    body->drag_kg_s = mean(vec3(body->drag[0][0], body->drag[1][1], body->drag[2][2]));
    // About C the inertia is smaller than about S.
    const vec3_t r = body->p_SC_m;
    body->inertia_kg_m2 = real_max(mean(vec3(body->mass[3][3], body->mass[4][4], body->mass[5][5])) -
                                       real_mul(real_mul(REAL(2), real_div(body->mass_kg, REAL(3))), vec3_dot(r, r)),
                                   REAL(1e-4));
    body->drag_Nm_s = mean(vec3(body->drag[3][3], body->drag[4][4], body->drag[5][5]));
}

void ssv_observer_restart(ssv_guidance_t* guidance) {
    for (int k = 0; k < SSV_GUIDANCE_HISTORY; k++) {
        guidance->history[k] = guidance->estimate.X_IS;
        guidance->history_age_s[k] = REAL(0);
    }
}

ssv_wrench_t ssv_observer_inertia(const ssv_guidance_body_t* body, ssv_twist_t acceleration) {
    real_t a[N], w[N];
    put_twist(a, acceleration);
    for (int r = 0; r < N; r++) {
        w[r] = REAL(0);
        for (int c = 0; c < N; c++) w[r] += real_mul(body->mass[r][c], a[c]);
    }
    return (ssv_wrench_t){vec3(w[0], w[1], w[2]), vec3(w[3], w[4], w[5])};
}

ssv_wrench_t ssv_observer_wrench(const ssv_vehicle_t* vehicle, const real_t u_N[SSV_NUM_THRUSTERS]) {
    ssv_wrench_t sum = {zero(), zero()};
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        const vec3_t force = vec3_scale(u_N[i], vehicle->thruster[i].n_T_S);
        sum.force = vec3_add(sum.force, force);
        sum.moment = vec3_add(sum.moment, vec3_cross(vehicle->thruster[i].p_ST_m, force));
    }
    return sum;
}

vec3_t ssv_observer_rotation(quat_t q) {
    const real_t sign = q.w < REAL(0) ? REAL(-1) : REAL(1);
    const vec3_t e = vec3(real_mul(sign, q.x), real_mul(sign, q.y), real_mul(sign, q.z));
    const real_t sine = vec3_norm(e);
    // Twice the sine is the angle to a third of its cube.
    if (sine < REAL(1e-3)) return vec3_scale(REAL(2), e);
    return vec3_scale(real_div(real_mul(REAL(2), real_atan2(sine, real_mul(sign, q.w))), sine), e);
}

static quat_t turned(quat_t q, vec3_t rotation) {
    const real_t angle = vec3_norm(rotation);
    if (angle < REAL(1e-3)) {
        const quat_t small = {REAL(1), real_mul(REAL(0.5), rotation.x), real_mul(REAL(0.5), rotation.y),
                              real_mul(REAL(0.5), rotation.z)};
        return quat_unit(quat_mul(q, small));
    }
    return quat_unit(quat_mul(q, quat_from_axis_angle(vec3_unit(rotation), angle)));
}

// m x = b by Gauss elimination: a mass matrix with drag is positive definite, so it needs no pivots.
static void solve(real_t m[N][N], real_t b[N], real_t x[N]) {
    for (int k = 0; k < N; k++) {
        for (int r = k + 1; r < N; r++) {
            const real_t factor = real_div(m[r][k], m[k][k]);
            for (int c = k; c < N; c++) m[r][c] -= real_mul(factor, m[k][c]);
            b[r] -= real_mul(factor, b[k]);
        }
    }
    for (int r = N - 1; r >= 0; r--) {
        x[r] = b[r];
        for (int c = r + 1; c < N; c++) x[r] -= real_mul(m[r][c], x[c]);
        x[r] = real_div(x[r], m[r][r]);
    }
}

// The lag's mean over the step, and where it leads to; implicit, so that a lag shorter than the step is none.
static ssv_wrench_t thrust_over(ssv_guidance_t* guidance, real_t dt_s) {
    const real_t share = real_div(dt_s, dt_s + guidance->config.thruster_lag_s);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        guidance->thrust_N[i] += real_mul(share, guidance->command_N[i] - guidance->thrust_N[i]);
    }
    return ssv_observer_wrench(&guidance->problem->scenario.vehicle, guidance->thrust_N);
}

// The share of a step's drag that counts at its end: half of it, which is of second order, or where drag stops the
// vehicle within the step as much more as keeps it from turning round. The way that it slides on is exact for each.
static real_t share_at_end(const ssv_guidance_body_t* body, real_t dt_s) {
    const real_t moving = real_div(real_mul(dt_s, body->drag_kg_s), body->mass_kg);
    const real_t turning = real_div(real_mul(dt_s, body->drag_Nm_s), body->inertia_kg_m2);
    const real_t most = real_max(moving, turning);
    return most > REAL(2) ? REAL(1) - real_div(REAL(1), most) : REAL(0.5);
}

// The twist after dt_s under a wrench, where drag and gyration grow with the square of the twist as `square` says.
static ssv_twist_t twist_after(const ssv_guidance_body_t* body, ssv_twist_t twist, ssv_wrench_t wrench,
                               const ssv_demand_t* at_start, ssv_wrench_t square, real_t dt_s) {
    const real_t implicit_s = real_mul(share_at_end(body, dt_s), dt_s);
    real_t m[N][N], b[N], rate[N];
    put(b, (ssv_wrench_t){vec3_sub(wrench.force, vec3_add(at_start->linear.force, square.force)),
                          vec3_sub(wrench.moment, vec3_add(at_start->linear.moment, square.moment))});
    for (int r = 0; r < N; r++) {
        for (int c = 0; c < N; c++) m[r][c] = body->mass[r][c] + real_mul(implicit_s, body->drag[r][c]);
    }
    solve(m, b, rate);
    return (ssv_twist_t){vec3_add(twist.v, vec3_scale(dt_s, vec3(rate[0], rate[1], rate[2]))),
                         vec3_add(twist.w, vec3_scale(dt_s, vec3(rate[3], rate[4], rate[5])))};
}

static vec3_t between(real_t share, vec3_t from, vec3_t to) {
    return vec3_add(from, vec3_scale(share, vec3_sub(to, from)));
}

// Heun's method for what grows with the square: a fast turn would leave a false moment behind otherwise.
void ssv_observer_predict(ssv_guidance_t* guidance, real_t dt_s) {
    ssv_estimate_t* x = &guidance->estimate;
    const ssv_guidance_body_t* body = &guidance->body;
    const ssv_assembly_t assembly = ssv_observer_assembly(guidance);
    const ssv_twist_t start = {x->v_S_m_s, x->w_S_rad_s};
    const ssv_wrench_t thrust = thrust_over(guidance, dt_s);
    const ssv_wrench_t wrench = {vec3_add(thrust.force, quat_apply(quat_conj(x->X_IS.q), x->force_I_N)),
                                 vec3_add(thrust.moment, x->moment_S_Nm)};
    ssv_demand_t at_start, at_end;
    ssv_body_demand(&assembly, start, &at_start);
    ssv_twist_t end = twist_after(body, start, wrench, &at_start, at_start.quadratic, dt_s);
    ssv_body_demand(&assembly, end, &at_end);
    const ssv_wrench_t square = {between(REAL(0.5), at_start.quadratic.force, at_end.quadratic.force),
                                 between(REAL(0.5), at_start.quadratic.moment, at_end.quadratic.moment)};
    end = twist_after(body, start, wrench, &at_start, square, dt_s);
    x->v_S_m_s = end.v;
    x->w_S_rad_s = end.w;
    // The velocity is in axes of S, which have turned by half the step on its way.
    const real_t share = share_at_end(body, dt_s);
    const vec3_t turn = vec3_scale(dt_s, between(share, start.w, end.w));
    const quat_t half = turned(x->X_IS.q, vec3_scale(REAL(0.5), turn));
    x->X_IS.p = vec3_add(x->X_IS.p, vec3_scale(dt_s, quat_apply(half, between(share, start.v, end.v))));
    x->X_IS.q = turned(x->X_IS.q, turn);
    for (int k = 0; k < SSV_GUIDANCE_HISTORY; k++) guidance->history_age_s[k] += dt_s;
    guidance->newest = (guidance->newest + 1) % SSV_GUIDANCE_HISTORY;
    guidance->history[guidance->newest] = x->X_IS;
    guidance->history_age_s[guidance->newest] = REAL(0);
    guidance->measured_age_s += dt_s;
}

typedef struct {
    real_t pose, twist, disturbance; ///< per second: of error, to error, rate of it, acceleration
} gains_t;

// Gains that give the error a pole at -max(bandwidth, drag) and a Butterworth pair at the bandwidth, where a twist
// decays at `drag` by itself. They are those of the steady Kalman-Bucy filter without drag up to the damping of the
// third pole, and with much drag, where the disturbance is a drift.
static gains_t gains(real_t bandwidth, real_t drag) {
    const real_t square = real_sq(bandwidth);
    if (drag >= bandwidth) {
        return (gains_t){real_mul(REAL(1.41421356), bandwidth), square, real_mul(drag, square)};
    }
    const real_t pose = real_mul(REAL(2), bandwidth) - drag;
    return (gains_t){pose, real_mul(REAL(2), square) - real_mul(drag, pose), real_mul(bandwidth, square)};
}

static real_t blend(real_t share, real_t from, real_t to) { return from + real_mul(share, to - from); }

// The estimate of the moment age_s ago: that of the nearest step, gone on with the twist of now.
static pose_t estimate_then(const ssv_guidance_t* guidance, real_t age_s) {
    const ssv_estimate_t* x = &guidance->estimate;
    int k = guidance->newest;
    for (int n = 1; n < SSV_GUIDANCE_HISTORY; n++) {
        const int older = (guidance->newest + SSV_GUIDANCE_HISTORY - n) % SSV_GUIDANCE_HISTORY;
        if (real_abs(guidance->history_age_s[older] - age_s) < real_abs(guidance->history_age_s[k] - age_s)) k = older;
    }
    const real_t on_s = guidance->history_age_s[k] - age_s;
    const pose_t nearest = guidance->history[k];
    return (pose_t){vec3_add(nearest.p, vec3_scale(on_s, quat_apply(nearest.q, x->v_S_m_s))),
                    turned(nearest.q, vec3_scale(on_s, x->w_S_rad_s))};
}

void ssv_guidance_measure(ssv_guidance_t* guidance, real_t age_s, pose_t X_IS) {
    ssv_estimate_t* x = &guidance->estimate;
    const ssv_guidance_body_t* body = &guidance->body;
    if (age_s < REAL(0) ||
        age_s > guidance->history_age_s[(guidance->newest + 1) % SSV_GUIDANCE_HISTORY] + OBSERVER_INTERVAL_MAX_S)
        return;
    const pose_t then = estimate_then(guidance, age_s);
    const real_t T = real_max(REAL(0), real_min(guidance->measured_age_s - age_s, OBSERVER_INTERVAL_MAX_S));
    guidance->measured_age_s = age_s;
    const real_t held = real_min(real_div(guidance->held_s, OBSERVER_SETTLE_S), REAL(1));
    const gains_t move = gains(blend(held, OBSERVER_POSITION_RAD_S, OBSERVER_HOLD_POSITION_RAD_S),
                               real_div(body->drag_kg_s, body->mass_kg));
    const gains_t turn = gains(blend(held, OBSERVER_ATTITUDE_RAD_S, OBSERVER_HOLD_ATTITUDE_RAD_S),
                               real_div(body->drag_Nm_s, body->inertia_kg_m2));
    // What was wrong then is wrong now.
    const vec3_t off_I = vec3_scale(T, vec3_sub(X_IS.p, then.p));
    const vec3_t off_S = quat_apply(quat_conj(x->X_IS.q), off_I);
    const vec3_t turn_S = vec3_scale(T, ssv_observer_rotation(quat_mul(quat_conj(then.q), X_IS.q)));
    const vec3_t r = body->p_SC_m;
    // A correction of the rate turns about C, which keeps its velocity.
    const vec3_t w = vec3_scale(turn.twist, turn_S);
    x->v_S_m_s = vec3_add(x->v_S_m_s, vec3_sub(vec3_scale(move.twist, off_S), vec3_cross(w, r)));
    x->w_S_rad_s = vec3_add(x->w_S_rad_s, w);
    const vec3_t a = vec3_scale(turn.disturbance, turn_S);
    const ssv_wrench_t by = ssv_observer_inertia(body, (ssv_twist_t){vec3_neg(vec3_cross(a, r)), a});
    x->moment_S_Nm = vec3_add(x->moment_S_Nm, by.moment);
    x->force_I_N = vec3_add(x->force_I_N, vec3_scale(real_mul(body->mass_kg, move.disturbance), off_I));
    const vec3_t shift = vec3_scale(move.pose, off_I), rotation = vec3_scale(turn.pose, turn_S);
    x->X_IS = (pose_t){vec3_add(x->X_IS.p, shift), turned(x->X_IS.q, rotation)};
    // So that the next late measurement does not find the same error again.
    for (int n = 0; n < SSV_GUIDANCE_HISTORY; n++) {
        guidance->history[n].p = vec3_add(guidance->history[n].p, shift);
        guidance->history[n].q = turned(guidance->history[n].q, rotation);
    }
}
