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

// Steps along each axis, to whichever side is cheaper: where thrusters are not square to each other, the cheapest
// directions are somewhat off the axes, edges and diagonals of the body.
static void improve_direction(const ssv_question_t* question, vec3_t* n, real_t* price) {
    static const real_t steps[SSV_NUM_DIRECTION_STEPS] = {REAL(0.04), REAL(0.02), REAL(0.01)};
    for (int k = 0; k < 3 * SSV_NUM_DIRECTION_STEPS; k++) {
        const real_t step = steps[k / 3];
        const vec3_t aside =
            vec3(k % 3 == 0 ? step : REAL(0), k % 3 == 1 ? step : REAL(0), k % 3 == 2 ? step : REAL(0));
        const vec3_t next[2] = {vec3_unit(vec3_add(*n, aside)), vec3_unit(vec3_sub(*n, aside))};
        const real_t there[2] = {ssv_metre_price(question, next[0]), ssv_metre_price(question, next[1])};
        const int side = there[0] < there[1] ? 0 : 1;
        const real_t other = real_min(*price, there[1 - side]);
        if (!ssv_less(there[side], other)) continue;
        *price = there[side];
        *n = next[side];
    }
}

void ssv_capability_init(const ssv_question_t* question, ssv_capability_t* capability) {
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
    // Prices too high for the scalar make the answer an overflow. Until that is said, the cheapest direction stands all
    // the same.
    const real_t most = real_max(least, real_mul(SSV_DIRECTION_SLACK, least));
    capability->num = capability->num_upright = 0;
    capability->least = least;
    for (int up = 1; up >= 0; up--) {
        for (int k = 0; k < num; k++) {
            if (price[k] > most || upright[k] != (up == 1)) continue;
            improve_direction(question, &n[k], &price[k]);
            capability->n[capability->num] = n[k];
            capability->price[capability->num++] = price[k];
        }
        if (up == 1) capability->num_upright = capability->num;
    }
    const ssv_assembly_t alone = ssv_vehicle_alone(question->problem);
    ssv_turns_of(question->problem, &alone, &capability->rolled);
    ssv_turns_at(&capability->rolled, vec3(REAL(0), REAL(1), REAL(0)), &capability->turns);
    capability->either_way_up = serves_both_ways_up(question->problem);
    if (!capability->either_way_up || capability->num_upright == 0) capability->num_upright = capability->num;
    SSV_ASSERT(capability->num_upright > 0);
}
