#include "planner/search/seed.h"

#include "planner/model/allocation.h"

// Body directions this much dearer per metre than the cheapest are not drawn; the search still finds its way in
// between.
#define DIRECTION_SLACK REAL(1.05)
// Swings are tried with spins up to this one, either way.
#define LAST_SWING 1
// Part of the price of a turn that it keeps when it is made on the way.
#define SWING_SHARE REAL(0.25)

// Whether the thrusters serve the vehicle rolled half a turn about x as well as before: three wrenches with nothing
// special about them tell.
static bool serves_both_ways_up(const ssv_problem_t* problem) {
    static const real_t probe[3][6] = {{REAL(0.8), REAL(0.5), REAL(-0.3), REAL(0.1), REAL(0.05), REAL(0.12)},
                                       {REAL(-0.2), REAL(0.7), REAL(0.6), REAL(-0.07), REAL(0.15), REAL(-0.04)},
                                       {REAL(0.3), REAL(-0.4), REAL(0.9), REAL(0.11), REAL(-0.09), REAL(0.02)}};
    for (int k = 0; k < 3; k++) {
        const real_t* w = probe[k];
        real_t u[2][SSV_NUM_THRUSTERS], sum[2] = {REAL(0), REAL(0)}, squares[2] = {REAL(0), REAL(0)};
        for (int way = 0; way < 2; way++) {
            const real_t sign = way == 0 ? REAL(1) : REAL(-1);
            ssv_alloc(&problem->allocation, vec3(w[0], real_mul(sign, w[1]), real_mul(sign, w[2])),
                      vec3(w[3], real_mul(sign, w[4]), real_mul(sign, w[5])), u[way]);
            for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
                sum[way] += real_abs(u[way][i]);
                squares[way] += real_sq(u[way][i]);
            }
        }
        if (real_abs(sum[0] - sum[1]) > real_mul(SSV_EVEN, sum[0])) return false;
        if (real_abs(squares[0] - squares[1]) > real_mul(SSV_EVEN, squares[0])) return false;
    }
    return true;
}

// Keeps the cheapest few, cheapest first.
static void keep(ssv_seed_t* list, int* num, int most, const ssv_decision_t* decision, real_t price) {
    if (*num == most && !ssv_clearly_less(price, list[most - 1].price)) return;
    int k = *num < most ? (*num)++ : most - 1;
    for (; k > 0 && ssv_clearly_less(price, list[k - 1].price); k--) list[k] = list[k - 1];
    list[k] = (ssv_seed_t){*decision, price, REAL(0)};
}

// Fills the turns with this assembly, as if the vehicle were a sphere.
static void roll_turns(const ssv_problem_t* problem, const ssv_assembly_t* assembly, ssv_rolled_turns_t* turns) {
    const vec3_t zero = vec3(REAL(0), REAL(0), REAL(0));
    for (int part = 0; part < SSV_NUM_TURN_PARTS; part++) turns->any[part] = false;
    for (int k = 0; k < 3; k++) {
        const vec3_t w = vec3(real_from_int(k == 0), real_from_int(k == 1), real_from_int(k == 2));
        ssv_demand_t there, back;
        ssv_body_demand(assembly, (ssv_twist_t){zero, w}, &there);
        ssv_body_demand(assembly, (ssv_twist_t){zero, vec3_neg(w)}, &back);
        // What does not change its sign with the rate is no drag.
        const ssv_wrench_t drag = {vec3_scale(REAL(0.5), vec3_sub(there.quadratic.force, back.quadratic.force)),
                                   vec3_scale(REAL(0.5), vec3_sub(there.quadratic.moment, back.quadratic.moment))};
        const ssv_wrench_t* const wrench[SSV_NUM_TURN_PARTS] = {&there.accel, &there.linear, &drag};
        for (int part = 0; part < SSV_NUM_TURN_PARTS; part++) {
            const vec3_t f = wrench[part]->force, m = wrench[part]->moment;
            real_t(*thrust)[SSV_NUM_THRUSTERS] = turns->thrust[part][k];
            ssv_alloc(&problem->allocation, vec3(f.x, REAL(0), REAL(0)), vec3(m.x, REAL(0), REAL(0)), thrust[0]);
            ssv_alloc(&problem->allocation, vec3(REAL(0), f.y, f.z), vec3(REAL(0), m.y, m.z), thrust[1]);
            ssv_alloc(&problem->allocation, vec3(REAL(0), -f.z, f.y), vec3(REAL(0), -m.z, m.y), thrust[2]);
            const real_t size =
                real_abs(f.x) + real_abs(f.y) + real_abs(f.z) + real_abs(m.x) + real_abs(m.y) + real_abs(m.z);
            if (size > REAL(0)) turns->any[part] = true;
        }
    }
}

static void turns_at(const ssv_rolled_turns_t* rolled, vec3_t axis_S, ssv_turns_t* turns) {
    turns->axis_S = axis_S;
    for (int part = 0; part < SSV_NUM_TURN_PARTS; part++) {
        turns->any[part] = rolled->any[part];
        for (int k = 0; rolled->any[part] && k < 3; k++) {
            const real_t(*thrust)[SSV_NUM_THRUSTERS] = rolled->thrust[part][k];
            for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
                turns->thrust[part][k][i] =
                    thrust[0][i] + real_mul(axis_S.y, thrust[1][i]) + real_mul(axis_S.z, thrust[2][i]);
            }
        }
    }
}

// What the turn q (in axes of the body) costs, roughly: W1 angle / v for the way, and for reaching v both what inertia
// and what drag ask.
static real_t turn_guess(const ssv_question_t* question, const ssv_turns_t* turns, quat_t q) {
    const vec3_t e = vec3(q.x, q.y, q.z);
    const real_t sine = vec3_norm(e), versine = REAL(1) - real_abs(q.w);
    if (sine < REAL(1e-4)) return REAL(0);
    // To 1 %.
    const real_t angle = real_mul(sine, REAL(2) + real_mul(versine, REAL(0.596) + real_mul(REAL(0.545), versine)));
    const vec3_t axis = vec3_scale(real_div(REAL(1), sine), e);
    const real_t c = turns->axis_S.y, s = turns->axis_S.z;
    const vec3_t w = vec3(axis.x, real_mul(c, axis.y) + real_mul(s, axis.z), real_mul(c, axis.z) - real_mul(s, axis.y));
    real_t most[SSV_NUM_TURN_PARTS] = {REAL(0)}, sum[SSV_NUM_TURN_PARTS] = {REAL(0)}; // of the thrusts
    for (int part = 0; part < SSV_NUM_TURN_PARTS; part++) {
        const real_t(*thrust)[SSV_NUM_THRUSTERS] = turns->thrust[part];
        for (int i = 0; turns->any[part] && i < SSV_NUM_THRUSTERS; i++) {
            const real_t u = real_mul(w.x, thrust[0][i]) + real_mul(w.y, thrust[1][i]) + real_mul(w.z, thrust[2][i]);
            most[part] = real_max(most[part], real_abs(u));
            sum[part] += real_abs(u);
        }
    }
    const real_t W1 = ssv_leg_weight_time(question), W2 = question->weight_impulse_per_Ns;
    const real_t F = question->problem->scenario.vehicle.force_max_N, way = real_mul(W1, angle);
    const real_t rise =
        real_div(real_mul(W1, most[SSV_TURN_ACCEL]), F) +
        real_mul(W2, real_mul(REAL(1.5), sum[SSV_TURN_ACCEL]) + real_mul(angle, sum[SSV_TURN_QUADRATIC]));
    const real_t hurry = real_div(real_mul(real_sq(way), most[SSV_TURN_QUADRATIC]), F);
    return real_sqrt(real_mul(REAL(4), real_mul(way, rise)) + hurry) +
           real_mul(W2, real_mul(angle, sum[SSV_TURN_LINEAR]));
}

// Where thrusters are not square to each other, the cheapest directions are somewhat off the axes, edges and diagonals:
// steps along each axis, to whichever side is cheaper.
static void better(const ssv_question_t* question, vec3_t* n, real_t* price) {
    static const real_t steps[] = {REAL(0.04), REAL(0.02), REAL(0.01)};
    for (int k = 0; k < 3 * (int)(sizeof steps / sizeof steps[0]); k++) {
        const real_t step = steps[k / 3];
        const vec3_t aside =
            vec3(k % 3 == 0 ? step : REAL(0), k % 3 == 1 ? step : REAL(0), k % 3 == 2 ? step : REAL(0));
        const vec3_t next[2] = {vec3_unit(vec3_add(*n, aside)), vec3_unit(vec3_sub(*n, aside))};
        const real_t there[2] = {ssv_metre_price(question, next[0]), ssv_metre_price(question, next[1])};
        const int side = there[0] < there[1] ? 0 : 1;
        const real_t other = real_min(*price, there[1 - side]);
        if (!(there[side] < other - real_mul(SSV_EVEN, other))) continue;
        *price = there[side];
        *n = next[side];
    }
}

void ssv_capability_init(const ssv_question_t* question, ssv_capability_t* d) {
    real_t price[SSV_NUM_DIRECTIONS], least = REAL(0);
    vec3_t n[SSV_NUM_DIRECTIONS];
    bool upright[SSV_NUM_DIRECTIONS];
    int num = 0;
    for (int x = -1; x <= 1; x++) {
        for (int y = -1; y <= 1; y++) {
            for (int z = -1; z <= 1; z++) {
                if (x == 0 && y == 0 && z == 0) continue;
                n[num] = vec3_unit(vec3(real_from_int(x), real_from_int(y), real_from_int(z)));
                upright[num] = z > 0 || (z == 0 && y >= 0);
                price[num] = ssv_metre_price(question, n[num]);
                if (num == 0 || price[num] < least) least = price[num];
                num++;
            }
        }
    }
    d->num = d->num_upright = 0;
    d->least = least;
    for (int up = 1; up >= 0; up--) {
        for (int k = 0; k < num; k++) {
            if (price[k] > real_mul(DIRECTION_SLACK, least) || upright[k] != (up == 1)) continue;
            better(question, &n[k], &price[k]);
            d->n[d->num] = n[k];
            d->price[d->num++] = price[k];
        }
        if (up == 1) d->num_upright = d->num;
    }
    const ssv_assembly_t alone = ssv_vehicle_alone(question->problem);
    roll_turns(question->problem, &alone, &d->rolled);
    turns_at(&d->rolled, vec3(REAL(0), REAL(1), REAL(0)), &d->turns);
    d->either_way_up = serves_both_ways_up(question->problem);
    if (!d->either_way_up) d->num_upright = d->num;
}

int ssv_seed_transit(const ssv_phase_context_t* context, const ssv_capability_t* capability, int most,
                     ssv_seed_t* list) {
    const vec3_t way = vec3_sub(context->hold_I[1], context->hold_I[0]);
    const real_t distance = vec3_norm(way);
    const bool flies = distance > SSV_NO_WAY_M;
    const vec3_t direction_I = flies ? vec3_unit(way) : vec3(REAL(1), REAL(0), REAL(0));
    const quat_t* q_end = context->transit.q_IS;
    int num = 0;
    for (int k = -SSV_NUM_ENDS; k < (flies ? capability->num : 0); k++) {
        const vec3_t n_S = k < 0 ? quat_apply(quat_conj(q_end[k + SSV_NUM_ENDS]), direction_I) : capability->n[k];
        const real_t fly = real_mul(distance, k < 0 ? ssv_metre_price(context->question, n_S) : capability->price[k]);
        if (num == most && fly >= list[most - 1].price) continue;
        quat_t q[SSV_NUM_ENDS];
        for (int end = 0; end < SSV_NUM_ENDS; end++) {
            q[end] = quat_mul(quat_between(quat_apply(q_end[end], n_S), direction_I), q_end[end]);
        }
        // Rolled about the way so that one of the turns is the smallest.
        for (int end = 0; end < (flies ? SSV_NUM_ENDS : 1); end++) {
            const real_t to =
                fly + turn_guess(context->question, &capability->turns, quat_mul(quat_conj(q_end[0]), q[end]));
            if (num == most && to >= list[most - 1].price) continue;
            const real_t from =
                turn_guess(context->question, &capability->turns, quat_mul(quat_conj(q[end]), q_end[1]));
            const ssv_decision_t decision = {.q_IT = q[end], .n_S = n_S};
            keep(list, &num, most, &decision, to + from);
        }
    }
    return num;
}

// Sets how the vehicle holds the beam, and its attitude, so that n_S flies ahead along direction_I and the beam points
// along axis_I; two rolls do. Where none does both, one does nearly. @return false for the second if there is but one.
static bool point_beam(int side, vec3_t direction_I, vec3_t axis_I, ssv_decision_t* decision) {
    const vec3_t n = decision->n_S;
    const real_t along = vec3_dot(direction_I, axis_I), reach = real_sqrt(real_sq(n.y) + real_sq(n.z));
    // The roll from where the beam leans on n most, by its cosine.
    real_t c = along < REAL(0) ? REAL(-1) : REAL(1), s = REAL(0);
    if (!(reach > REAL(0))) {
        c = real_from_int(side); // every roll does
    } else if (reach > real_abs(along)) {
        c = real_div(along, reach);
        s = real_mul(real_from_int(side), real_sqrt(real_max(REAL(0), REAL(1) - real_sq(c))));
    }
    const real_t y = reach > REAL(0) ? real_div(n.y, reach) : REAL(1),
                 z = reach > REAL(0) ? real_div(n.z, reach) : REAL(0);
    decision->axis_S = vec3(REAL(0), real_mul(y, c) - real_mul(z, s), real_mul(z, c) + real_mul(y, s));
    decision->q_IT = ssv_attitude(n, decision->axis_S, direction_I, axis_I);
    return side < 0 || reach > real_abs(along) || !(reach > REAL(0));
}

static void set_twist(vec3_t twist, ssv_decision_t* decision) {
    decision->x[SSV_X_TWIST] = twist.x;
    decision->x[SSV_X_TWIST + 1] = twist.y;
    decision->x[SSV_X_TWIST + 2] = twist.z;
}

static real_t distance_between(const vec3_t p[SSV_NUM_ENDS]) { return vec3_norm(vec3_sub(p[1], p[0])); }

// Keeps a trial, and the same with the turn at one end spun about the beam's axis there, by their guessed prices.
static void keep_spins(const ssv_phase_context_t* context, const ssv_turns_t* turns, int spun_end, int num_spins,
                       real_t metre_price, real_t swing, ssv_decision_t* decision, int most, ssv_seed_t* list,
                       int* num) {
    const ssv_scenario_t* s = &context->question->problem->scenario;
    const vec3_t ahead = vec3(s->standoff_m, REAL(0), REAL(0));
    const int other_end = 1 - spun_end;
    ssv_attitudes_t a;
    ssv_decision_attitudes(context, decision, vec3_sub(context->hold_I[1], context->hold_I[0]), &a);
    const quat_t unspun = a.q_IS[spun_end];
    vec3_t p_IS[SSV_NUM_ENDS];
    p_IS[other_end] = vec3_sub(context->hold_I[other_end], quat_apply(a.q_IS[other_end], ahead));
    real_t price = turn_guess(context->question, turns, quat_mul(quat_conj(a.q_IS[other_end]), a.q_IT[other_end]));
    if (swing > REAL(0))
        price += real_mul(swing, turn_guess(context->question, turns, quat_mul(quat_conj(a.q_IT[0]), a.q_IT[1])));
    for (int spin = 0; spin < num_spins; spin++) {
        const quat_t q_IS =
            spin > 0 ? quat_mul(ssv_spin(context->transfer.axis_I[spun_end], spin, REAL(0)), unspun) : unspun;
        decision->spin[spun_end] = spin;
        p_IS[spun_end] = vec3_sub(context->hold_I[spun_end], quat_apply(q_IS, ahead));
        const real_t fly = real_mul(distance_between(p_IS), metre_price);
        keep(list, num, most, decision,
             price + fly + turn_guess(context->question, turns, quat_mul(quat_conj(q_IS), a.q_IT[spun_end])));
    }
}

int ssv_seed_transfer(const ssv_phase_context_t* context, ssv_capability_t* capability, ssv_attitude_mode_t carry,
                      int most, ssv_seed_t* list) {
    const ssv_scenario_t* s = &context->question->problem->scenario;
    const vec3_t* axis_I = context->transfer.axis_I;
    const vec3_t way = vec3_sub(context->hold_I[1], context->hold_I[0]);
    const vec3_t direction_I = vec3_norm(way) > SSV_NO_WAY_M ? vec3_unit(way) : axis_I[0];
    const quat_t smallest = quat_between(axis_I[0], axis_I[1]);
    const ssv_assembly_t assembly = {&s->vehicle,
                                     &s->beam,
                                     {vec3(s->standoff_m, -context->height_m, REAL(0)),
                                      quat_between(vec3(REAL(0), REAL(0), REAL(1)), vec3(REAL(0), REAL(1), REAL(0)))}};
    int num = 0;
    roll_turns(context->question->problem, &assembly, &capability->rolled);
    for (int variant = 0; variant < (carry == SSV_SWUNG ? SSV_NUM_SPINS : SSV_NUM_ENDS); variant++) {
        if (carry == SSV_SWUNG && variant > LAST_SWING && variant < SSV_NUM_SPINS - LAST_SWING) continue;
        // A swing goes from where the beam lies to where it docks, half of it before the middle of the way.
        const vec3_t half_swing = ssv_half_of(quat_mul(ssv_spin(axis_I[1], variant, REAL(0)), smallest));
        const vec3_t middle_axis_I = quat_apply(ssv_turned_by(quat_identity(), half_swing), axis_I[0]);
        for (int k = 0; k < capability->num_upright; k++) {
            for (int side = -1; side <= 1; side += 2) {
                ssv_decision_t decision = {.n_S = capability->n[k]};
                const int end = carry == SSV_SWUNG ? 0 : variant, other_end = 1 - end;
                if (!point_beam(side, direction_I, carry == SSV_SWUNG ? middle_axis_I : axis_I[end], &decision))
                    continue;
                turns_at(&capability->rolled, decision.axis_S, &capability->carried);
                if (carry == SSV_SWUNG) {
                    set_twist(quat_apply(quat_conj(decision.q_IT), half_swing), &decision);
                } else if (carry == SSV_ROLLED) {
                    const quat_t q_other = ssv_attitude(decision.n_S, decision.axis_S, direction_I, axis_I[other_end]);
                    const vec3_t half = ssv_half_of(quat_mul(quat_conj(decision.q_IT), q_other));
                    decision.q_IT = ssv_turned_by(decision.q_IT, half);
                    set_twist(end == 0 ? half : vec3_neg(half), &decision);
                }
                const bool spins = carry != SSV_SWUNG && !(other_end == 0 && s->ring_angle_given);
                keep_spins(context, &capability->carried, other_end, spins ? SSV_NUM_SPINS : 1, capability->price[k],
                           carry == SSV_SWUNG ? SWING_SHARE : REAL(0), &decision, most, list, &num);
            }
        }
    }
    return num;
}
