#include "planner/search/capability.h"

#include "planner/math/assert.h"
#include "planner/model/allocation.h"
#include "planner/motion/maneuver.h"
#include "planner/motion/path.h"
#include "planner/motion/price_order.h"
#include "planner/search/tolerance.h"

// Whether the thrusters serve the vehicle as well when it is rolled half a turn about x. Three wrenches without any
// symmetry tell.
static bool serves_both_ways_up(const ssv_problem_t* problem) {
    static const real_t probe[3][6] = {{REAL(0.8), REAL(0.5), REAL(-0.3), REAL(0.1), REAL(0.05), REAL(0.12)},
                                       {REAL(-0.2), REAL(0.7), REAL(0.6), REAL(-0.07), REAL(0.15), REAL(-0.04)},
                                       {REAL(0.3), REAL(-0.4), REAL(0.9), REAL(0.11), REAL(-0.09), REAL(0.02)}};
    for (int k = 0; k < 3; k++) {
        const real_t* w = probe[k];
        real_t u[2][SSV_NUM_THRUSTERS], sum[2] = {REAL(0), REAL(0)}, squares[2] = {REAL(0), REAL(0)};
        for (int rolled = 0; rolled < 2; rolled++) {
            const real_t sign = rolled == 0 ? REAL(1) : REAL(-1);
            ssv_alloc(&problem->allocation, vec3(w[0], real_mul(sign, w[1]), real_mul(sign, w[2])),
                      vec3(w[3], real_mul(sign, w[4]), real_mul(sign, w[5])), u[rolled]);
            for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
                sum[rolled] += real_abs(u[rolled][i]);
                squares[rolled] += real_sq(u[rolled][i]);
            }
        }
        if (!ssv_even(sum[0], sum[1]) || !ssv_even(squares[0], squares[1])) return false;
    }
    return true;
}

void ssv_turns_of(const ssv_problem_t* problem, const ssv_assembly_t* assembly, ssv_rolled_turns_t* turns) {
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

void ssv_turns_at(const ssv_rolled_turns_t* rolled, vec3_t axis_S, ssv_turns_t* turns) {
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

// A turn at rate v costs W1 angle / v for its time, and for reaching v what inertia and drag ask; v is the best one.
real_t ssv_turn_guess(const ssv_question_t* question, const ssv_turns_t* turns, quat_t q) {
    const vec3_t e = vec3(q.x, q.y, q.z);
    const real_t sine = vec3_norm(e), versine = REAL(1) - real_abs(q.w);
    if (sine < SSV_NO_TURN) return REAL(0);
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
    const real_t F = question->problem->scenario.vehicle.force_max_N, hasten = real_mul(W1, angle);
    const real_t rise =
        real_div(real_mul(W1, most[SSV_TURN_ACCEL]), F) +
        real_mul(W2, real_mul(REAL(1.5), sum[SSV_TURN_ACCEL]) + real_mul(angle, sum[SSV_TURN_QUADRATIC]));
    const real_t hurry = real_div(real_mul(real_sq(hasten), most[SSV_TURN_QUADRATIC]), F);
    return real_sqrt(real_mul(REAL(4), real_mul(hasten, rise)) + hurry) +
           real_mul(W2, real_mul(angle, sum[SSV_TURN_LINEAR]));
}

// The largest of some thrusts, and all of them together.
typedef struct {
    real_t most, sum;
} load_t;

static load_t load_of(const real_t u[SSV_NUM_THRUSTERS]) {
    load_t load = {REAL(0), REAL(0)};
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        load.most = real_max(load.most, real_abs(u[i]));
        load.sum += real_abs(u[i]);
    }
    return load;
}

static load_t scaled(real_t factor, load_t load) {
    return (load_t){real_mul(factor, load.most), real_mul(factor, load.sum)};
}

// At speed v a flight costs W1 length / v for its time, what drag asks over the length, and for reaching v what inertia
// does; v is the best one that the thrusters can hold.
static real_t flight_price(const ssv_question_t* question, load_t accel, load_t linear, load_t quadratic,
                           real_t length) {
    const real_t W1 = ssv_leg_weight_time(question), W2 = question->weight_impulse_per_Ns;
    const real_t F = question->problem->scenario.vehicle.force_max_N, hasten = real_mul(W1, length);
    const real_t rise = real_div(real_mul(W1, accel.most), F) +
                        real_mul(W2, real_mul(REAL(1.5), accel.sum) + real_mul(length, quadratic.sum));
    const real_t under_root = real_sq(linear.most) + real_mul(REAL(4), real_mul(quadratic.most, F));
    const real_t hold = linear.most + real_sqrt(under_root); // 2 F over the top speed
    real_t v = real_sqrt(real_div(hasten, rise));
    if (real_mul(hold, v) > real_mul(REAL(2), F)) v = real_div(real_mul(REAL(2), F), hold);
    return real_div(hasten, v) + real_mul(v, rise) + real_mul(W2, real_mul(length, linear.sum));
}

real_t ssv_flight_guess(const ssv_question_t* question, const ssv_assembly_t* assembly, vec3_t n_S, real_t length_m) {
    const ssv_twist_t twist = {n_S, vec3(REAL(0), REAL(0), REAL(0))};
    ssv_thrusts_t thrusts;
    ssv_maneuver_thrusts(question->problem, assembly, twist, &thrusts);
    return flight_price(question, load_of(thrusts.accel), load_of(thrusts.linear), load_of(thrusts.quadratic),
                        length_m);
}

// The vehicle's drag is against the flight, and its added mass nearly so.
real_t ssv_direction_price(const ssv_question_t* question, const ssv_capability_t* capability, vec3_t n_S) {
    if (capability->regime == SSV_LINEAR_DRAG) return ssv_metre_price(question, n_S);
    const ssv_body_t* body = &question->problem->scenario.vehicle.body;
    real_t u[SSV_NUM_THRUSTERS];
    ssv_alloc(&question->problem->allocation, n_S, vec3(REAL(0), REAL(0), REAL(0)), u);
    const load_t load = load_of(u);
    const real_t mass = body->mass_kg + vec3_dot(n_S, vec3_mul(body->added_mass_kg, n_S));
    return real_div(flight_price(question, scaled(mass, load), scaled(body->drag_lin_kg_s, load),
                                 scaled(body->drag_quad_kg_m, load), capability->flight_m),
                    capability->flight_m);
}

// Steps along each axis, to whichever side is cheaper: where thrusters are not square to each other, the cheapest
// directions are somewhat off the axes, edges and diagonals of the body.
static void improve_direction(const ssv_question_t* question, const ssv_capability_t* capability, vec3_t* n,
                              real_t* price) {
    static const real_t steps[SSV_NUM_DIRECTION_STEPS] = {REAL(0.04), REAL(0.02), REAL(0.01)};
    for (int k = 0; k < 3 * SSV_NUM_DIRECTION_STEPS; k++) {
        const real_t step = steps[k / 3];
        const vec3_t aside =
            vec3(k % 3 == 0 ? step : REAL(0), k % 3 == 1 ? step : REAL(0), k % 3 == 2 ? step : REAL(0));
        const vec3_t next[2] = {vec3_unit(vec3_add(*n, aside)), vec3_unit(vec3_sub(*n, aside))};
        const real_t there[2] = {ssv_direction_price(question, capability, next[0]),
                                 ssv_direction_price(question, capability, next[1])};
        const int side = there[0] < there[1] ? 0 : 1;
        const real_t other = real_min(*price, there[1 - side]);
        if (!ssv_less(there[side], other)) continue;
        *price = there[side];
        *n = next[side];
    }
}

// The cheapest lines across x, of those along which a beam can be held, the cheapest first.
static void rank_across(const ssv_question_t* question, ssv_capability_t* capability) {
    static const vec3_t across[] = {{REAL(0), REAL(1), REAL(0)},
                                    {REAL(0), REAL(0), REAL(1)},
                                    {REAL(0), REAL(0.70710678118654757), REAL(0.70710678118654757)},
                                    {REAL(0), REAL(0.70710678118654757), REAL(-0.70710678118654757)}};
    real_t price[SSV_NUM_ACROSS] = {REAL(0)};
    int num = 0;
    for (int k = 0; k < (int)(sizeof across / sizeof *across); k++) {
        const real_t its = ssv_direction_price(question, capability, across[k]);
        if (num == SSV_NUM_ACROSS && !ssv_clearly_less(its, price[num - 1])) continue;
        int place = num < SSV_NUM_ACROSS ? num++ : num - 1;
        for (; place > 0 && ssv_clearly_less(its, price[place - 1]); place--) {
            price[place] = price[place - 1];
            capability->across[place] = capability->across[place - 1];
        }
        price[place] = its;
        capability->across[place] = across[k];
    }
}

// What prices per metre are told for: the mean of the flights to the beam and to the port.
static real_t typical_flight_m(const ssv_scenario_t* s) {
    const real_t to_beam_m = vec3_norm(vec3_sub(s->X_IB.p, s->X_IS.p));
    const real_t to_port_m = vec3_norm(vec3_sub(s->p_IP_m, s->X_IB.p));
    return real_max(SSV_SHORT_FLIGHT_M, real_mul(REAL(0.5), to_beam_m + to_port_m));
}

// Whether what grows with the square of the speed counts at a speed that a thruster holds against the linear drag.
static ssv_regime_t regime_of(const ssv_scenario_t* s) {
    const ssv_body_t *vehicle = &s->vehicle.body, *beam = &s->beam.body;
    const real_t linear = vehicle->drag_lin_kg_s, force = s->vehicle.force_max_N;
    const real_t square =
        vehicle->drag_quad_kg_m + beam->drag_quad_kg_m + real_mul(s->beam.drag_strip_kg_m2, s->beam.length_m);
    if (beam->drag_lin_kg_s > real_mul(SSV_DRAG_COUNTS, linear)) return SSV_ANY_DRAG;
    // Far beyond any doubt; and else these quotients might not fit.
    if (!(linear > real_mul(REAL(1e-3), force)) || !(linear > real_mul(REAL(1e-3), square))) return SSV_ANY_DRAG;
    const real_t share = real_mul(real_div(square, linear), real_div(force, linear));
    return share > SSV_DRAG_COUNTS ? SSV_ANY_DRAG : SSV_LINEAR_DRAG;
}

void ssv_capability_init(const ssv_question_t* question, ssv_capability_t* capability) {
    real_t price[SSV_NUM_DIRECTIONS], least = REAL(0);
    vec3_t n[SSV_NUM_DIRECTIONS];
    bool upright[SSV_NUM_DIRECTIONS];
    int num = 0;
    capability->regime = regime_of(&question->problem->scenario);
    capability->flight_m = typical_flight_m(&question->problem->scenario);
    for (int x = -1; x <= 1; x++) {
        for (int y = -1; y <= 1; y++) {
            for (int z = -1; z <= 1; z++) {
                if (x == 0 && y == 0 && z == 0) continue;
                n[num] = vec3_unit(vec3(real_from_int(x), real_from_int(y), real_from_int(z)));
                upright[num] = z > 0 || (z == 0 && y >= 0);
                price[num] = ssv_direction_price(question, capability, n[num]);
                if (num == 0 || price[num] < least) least = price[num];
                num++;
            }
        }
    }
    // Prices too high for the scalar make the answer an overflow. Until that is said, the cheapest direction stands all
    // the same.
    const real_t most = real_max(least, real_mul(SSV_DIRECTION_SLACK, least));
    capability->num = capability->num_upright = 0;
    capability->least = least;
    for (int up = 1; up >= 0; up--) {
        for (int k = 0; k < num; k++) {
            if (price[k] > most || upright[k] != (up == 1)) continue;
            improve_direction(question, capability, &n[k], &price[k]);
            capability->n[capability->num] = n[k];
            capability->price[capability->num++] = price[k];
        }
        if (up == 1) capability->num_upright = capability->num;
    }
    rank_across(question, capability);
    const ssv_assembly_t alone = ssv_vehicle_alone(question->problem);
    ssv_turns_of(question->problem, &alone, &capability->rolled);
    ssv_turns_at(&capability->rolled, vec3(REAL(0), REAL(1), REAL(0)), &capability->turns);
    capability->either_way_up = serves_both_ways_up(question->problem);
    if (!capability->either_way_up || capability->num_upright == 0) capability->num_upright = capability->num;
    SSV_ASSERT(capability->num_upright > 0);
}
