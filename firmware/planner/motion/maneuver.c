#include "planner/motion/maneuver.h"

#include "planner/model/allocation.h"
#include "planner/model/grasp.h"
#include "planner/motion/price_order.h"
#include "planner/motion/tolerance.h"

real_t ssv_leg_weight_time(const ssv_question_t* question) {
    return real_max(question->weight_time_per_s, real_mul(SSV_SECOND_COSTS_N, question->weight_impulse_per_Ns));
}

ssv_maneuver_t ssv_maneuver_translate(ssv_phase_t phase, vec3_t displacement_S) {
    const vec3_t zero = vec3(REAL(0), REAL(0), REAL(0));
    ssv_maneuver_t maneuver = {phase, SSV_TRANSLATE, {zero, zero}, vec3_norm(displacement_S), REAL(0)};
    if (maneuver.length < SSV_LENGTH_MIN) {
        maneuver.length = REAL(0);
    } else {
        maneuver.twist.v = vec3_unit(displacement_S);
    }
    return maneuver;
}

ssv_maneuver_t ssv_maneuver_turn(ssv_phase_t phase, vec3_t axis_S, real_t angle_rad, vec3_t pivot_S) {
    const ssv_maneuver_t maneuver = {phase,
                                     SSV_TURN,
                                     {vec3_cross(pivot_S, axis_S), axis_S},
                                     angle_rad < SSV_LENGTH_MIN ? REAL(0) : angle_rad,
                                     REAL(0)};
    return maneuver;
}

ssv_maneuver_t ssv_maneuver_between(ssv_phase_t phase, pose_t X_IS_from, pose_t X_IS_to) {
    const pose_t X = pose_between(X_IS_from, X_IS_to);
    const real_t sign = X.q.w < REAL(0) ? REAL(-1) : REAL(1);
    const vec3_t e = vec3_scale(sign, vec3(X.q.x, X.q.y, X.q.z));
    const real_t sine = vec3_norm(e), half = real_atan2(sine, real_abs(X.q.w)), angle = real_mul(REAL(2), half);
    if (angle < SSV_LENGTH_MIN) return ssv_maneuver_translate(phase, X.p);
    // Angle times the inverse of p = (s + (1 - cos s) [w] + (s - sin s) [w]^2) v: how far S moves, in its own axes.
    const vec3_t w = vec3_unit(e), wp = vec3_cross(w, X.p);
    const real_t bend = REAL(1) - real_div(real_mul(half, real_abs(X.q.w)), sine);
    const vec3_t path = vec3_add(X.p, vec3_add(vec3_scale(-half, wp), vec3_scale(bend, vec3_cross(w, wp))));
    const real_t arc = vec3_norm(path), shift = real_abs(vec3_dot(path, w));
    const bool pitched = shift > real_mul(SSV_LENGTH_MIN, angle) && arc > real_mul(SSV_PIVOT_NEAR_M, angle);
    if (pitched || arc > real_mul(SSV_PIVOT_FAR_M, angle)) {
        return (ssv_maneuver_t){phase, SSV_SCREW, {vec3_unit(path), vec3_scale(real_div(angle, arc), w)}, arc, REAL(0)};
    }
    return (ssv_maneuver_t){phase, SSV_TURN, {vec3_scale(real_div(REAL(1), angle), path), w}, angle, REAL(0)};
}

// What moves at this speed per unit of the maneuver's may move at most at `cap`; 0 = none.
static void limit(real_t cap, real_t speed, ssv_maneuver_t* maneuver) {
    if (!(cap > REAL(0)) || !(real_mul(SSV_SPEED_NEVER, speed) > cap)) return;
    const real_t most = real_div(cap, speed);
    if (!(maneuver->speed_max > REAL(0)) || most < maneuver->speed_max) maneuver->speed_max = most;
}

void ssv_maneuver_limit(const ssv_scenario_t* s, const ssv_assembly_t* assembly, bool approaches,
                        ssv_maneuver_t* maneuver) {
    const bool alone = assembly->beam == NULL;
    const real_t cap = alone ? s->transit_speed_max_m_s : s->transfer_speed_max_m_s;
    const real_t rate_cap = alone ? s->transit_rate_max_rad_s : s->transfer_rate_max_rad_s;
    const real_t beam_cap = alone ? REAL(0) : s->transfer_beam_speed_max_m_s;
    if (cap > REAL(0)) limit(cap, vec3_norm(maneuver->twist.v), maneuver);
    if (rate_cap > REAL(0)) limit(rate_cap, vec3_norm(maneuver->twist.w), maneuver);
    for (int contact = 1; beam_cap > REAL(0) && contact <= SSV_NUM_CONTACTS; contact++) {
        const pose_t X_SB = assembly->X_SB;
        const vec3_t p_SE = vec3_add(X_SB.p, quat_apply(X_SB.q, ssv_grasp_contact(s, contact)));
        limit(beam_cap, vec3_norm(vec3_add(maneuver->twist.v, vec3_cross(maneuver->twist.w, p_SE))), maneuver);
    }
    if (approaches) limit(s->contact_speed_max_m_s, vec3_norm(maneuver->twist.v), maneuver);
}

pose_t ssv_maneuver_pose(pose_t X_IS, ssv_twist_t twist, real_t s) {
    const real_t rate = vec3_norm(twist.w), angle = real_mul(s, rate);
    const vec3_t moved = vec3_scale(s, twist.v);
    pose_t X = {moved, quat_identity()};
    if (rate > REAL(0)) {
        // Rodrigues: p = (a + (1 - cos a) [w] + (a - sin a) [w]^2) v s / a for |w| = 1; as a series while a is small.
        const vec3_t w = vec3_unit(twist.w);
        const vec3_t across = vec3_cross(w, moved), back = vec3_cross(w, across);
        const bool small = angle < SSV_SMALL_RAD;
        const real_t sine = real_sin(real_mul(REAL(0.5), angle)); // 1 - cos a = 2 sine^2, without the difference
        const real_t c = small ? real_mul(REAL(0.5), angle) : real_mul(REAL(2), real_div(real_sq(sine), angle));
        const real_t d = small ? real_mul(REAL(1.0 / 6), real_sq(angle)) : REAL(1) - real_div(real_sin(angle), angle);
        X.p = vec3_add(moved, vec3_add(vec3_scale(c, across), vec3_scale(d, back)));
        X.q = quat_from_axis_angle(w, angle);
    }
    return pose_mul(X_IS, X);
}

static void trim(real_t c[SSV_NUM_THRUSTERS]) {
    real_t largest = REAL(0);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) largest = real_max(largest, real_abs(c[i]));
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        if (real_abs(c[i]) < real_mul(SSV_COEFFICIENT_MIN, largest)) c[i] = REAL(0);
    }
}

void ssv_maneuver_thrusts(const ssv_problem_t* problem, const ssv_assembly_t* assembly, ssv_twist_t twist,
                          ssv_thrusts_t* thrusts) {
    ssv_demand_t demand;
    ssv_body_demand(assembly, twist, &demand);
    ssv_alloc(&problem->allocation, demand.accel.force, demand.accel.moment, thrusts->accel);
    ssv_alloc(&problem->allocation, demand.linear.force, demand.linear.moment, thrusts->linear);
    ssv_alloc(&problem->allocation, demand.quadratic.force, demand.quadratic.moment, thrusts->quadratic);
    trim(thrusts->accel);
    trim(thrusts->linear);
    trim(thrusts->quadratic);
    thrusts->force_max_N = problem->scenario.vehicle.force_max_N;
}

real_t ssv_metre_price(const ssv_question_t* question, vec3_t n_S) {
    const ssv_vehicle_t* vehicle = &question->problem->scenario.vehicle;
    const vec3_t zero = vec3(REAL(0), REAL(0), REAL(0));
    real_t u[SSV_NUM_THRUSTERS], largest = REAL(0), sum = REAL(0);
    // Thrusts are proportional to the speed, so the cheapest speed is the highest.
    ssv_alloc(&question->problem->allocation, vec3_scale(vehicle->body.drag_lin_kg_s, n_S), zero, u);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        largest = real_max(largest, real_abs(u[i]));
        sum += real_abs(u[i]);
    }
    return real_mul(question->weight_time_per_s, real_div(largest, vehicle->force_max_N)) +
           real_mul(question->weight_impulse_per_Ns, sum);
}

bool ssv_price_beats(const ssv_price_t* a, const ssv_price_t* b) {
    return a->outcome == SSV_FEASIBLE && (b->outcome != SSV_FEASIBLE || a->cost < b->cost);
}

static ssv_rule_t rule_of(const ssv_question_t* question, const ssv_maneuver_t* maneuver, ssv_ramp_t ramp) {
    const real_t cutoff = maneuver->kind == SSV_TRANSLATE ? SSV_CUTOFF_TRANSLATE_M_S : SSV_CUTOFF_TURN_RAD_S;
    return (ssv_rule_t){ramp, cutoff, ssv_leg_weight_time(question), question->weight_impulse_per_Ns,
                        maneuver->speed_max};
}

static ssv_price_t price_of(const ssv_question_t* question, const ssv_profile_price_t* profile) {
    ssv_price_t price = {profile->outcome, REAL(0), REAL(0), REAL(0)};
    if (price.outcome != SSV_FEASIBLE) return price;
    price.time_s = profile->duration_s;
    price.impulse_Ns = profile->impulse_Ns;
    price.cost = real_mul(question->weight_time_per_s, price.time_s) +
                 real_mul(question->weight_impulse_per_Ns, price.impulse_Ns);
    return price;
}

ssv_price_t ssv_maneuver_price(const ssv_question_t* question, const ssv_maneuver_t* maneuver,
                               const ssv_thrusts_t* thrusts, ssv_ramp_t* ramp) {
    *ramp = SSV_FULL_REVERSE;
    if (!(maneuver->length > REAL(0))) return (ssv_price_t){SSV_FEASIBLE, REAL(0), REAL(0), REAL(0)};
    if (question->method == SSV_METHOD_OPTIMAL) {
        *ramp = SSV_OPTIMAL;
        const ssv_rule_t rule = rule_of(question, maneuver, *ramp);
        const ssv_profile_price_t optimal = ssv_profile_price(thrusts, &rule, maneuver->length);
        return price_of(question, &optimal);
    }
    const ssv_rule_t rule = rule_of(question, maneuver, *ramp);
    ssv_profile_price_t full_reverse, drag_only;
    ssv_profile_price_ramps(thrusts, &rule, maneuver->length, &full_reverse, &drag_only);
    const ssv_price_t reverse = price_of(question, &full_reverse), drift = price_of(question, &drag_only);
    if (drift.outcome != SSV_FEASIBLE) return reverse;
    const bool tie = reverse.outcome == SSV_FEASIBLE && !ssv_less_by(drift.cost, reverse.cost, SSV_RAMPS_TIE);
    if (tie) return reverse;
    *ramp = SSV_DRAG_ONLY;
    return drift;
}

ssv_price_t ssv_maneuver_solve(const ssv_question_t* question, const ssv_maneuver_t* maneuver,
                               const ssv_thrusts_t* thrusts, ssv_profile_t* profile, ssv_ramp_t* ramp) {
    profile->num_arcs = 0;
    *ramp = SSV_OPTIMAL;
    if (question->method == SSV_METHOD_PAPER || !(maneuver->length > REAL(0))) {
        const ssv_price_t price = ssv_maneuver_price(question, maneuver, thrusts, ramp);
        if (price.outcome != SSV_FEASIBLE || !(maneuver->length > REAL(0))) return price;
    }
    const ssv_rule_t rule = rule_of(question, maneuver, *ramp);
    const ssv_outcome_t outcome = ssv_profile_solve(thrusts, &rule, maneuver->length, profile);
    const ssv_profile_price_t price = {outcome, profile->duration_s, profile->impulse_Ns, profile->peak_speed};
    return price_of(question, &price);
}
