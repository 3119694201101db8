#include "planner/search/minimize.h"

#include "planner/math/assert.h"
#include "planner/motion/price_order.h"
#include "planner/search/tolerance.h"
#include "ssv/plan.h"

// What is minimised, and where it stands.
typedef struct {
    ssv_phase_context_t* context;
    const ssv_acceptance_t* acceptance;
    ssv_decision_t* decision;
    real_t price;
} search_t;

typedef struct {
    real_t number[SSV_NUM_FREE];
} direction_t;

static void step_along(const direction_t* direction, real_t step, ssv_decision_t* decision) {
    for (int k = 0; k < SSV_NUM_FREE; k++) decision->free.number[k] += real_mul(step, direction->number[k]);
}

static real_t price_at(const search_t* search, const direction_t* direction, real_t step) {
    ssv_decision_t there = *search->decision;
    step_along(direction, step, &there);
    return ssv_decision_price(search->context, &there);
}

// Prices a step down and a step up along a direction, and goes to where the parabola through the three prices is
// lowest. How far must not depend on the last digits of prices, in which scalars differ: a parabola that is nearly flat
// counts as bent, which keeps the step short. One of the ends is taken instead only where it is clearly lower. @return
// how far along the direction it went.
static real_t search_along(search_t* search, const direction_t* direction) {
    const ssv_acceptance_t* acceptance = search->acceptance;
    const real_t middle = search->price, down = price_at(search, direction, REAL(-1));
    const real_t up = price_at(search, direction, REAL(1));
    const real_t fall = real_mul(REAL(0.5), down - up);
    const real_t bend = real_max(down + up - real_mul(REAL(2), middle), real_mul(acceptance->least_bend, middle));
    const bool far = real_abs(fall) >= real_mul(SSV_FARTHEST_STEP, bend);
    const real_t step = !far ? real_div(fall, bend) : fall < REAL(0) ? -SSV_FARTHEST_STEP : SSV_FARTHEST_STEP;
    const real_t promised = real_mul(step, fall - real_mul(REAL(0.5), real_mul(bend, step)));
    real_t went = REAL(0);
    if (promised > real_mul(acceptance->promise, middle)) {
        const real_t there = price_at(search, direction, step);
        if (ssv_less(there, middle)) {
            search->price = there;
            went = step;
        }
    }
    const real_t end = real_min(down, up);
    if (end < search->price - real_mul(acceptance->clearly, middle)) {
        search->price = end;
        went = ssv_less(up, down) ? REAL(1) : REAL(-1);
    }
    step_along(direction, went, search->decision);
    return real_abs(went);
}

// Each number in turn. Its step becomes about as long as the way that it went.
static void search_numbers(search_t* search, real_t step[SSV_NUM_FREE]) {
    for (int k = 0; k < SSV_NUM_FREE; k++) {
        if (!(step[k] > REAL(0))) continue;
        direction_t direction = {{REAL(0)}};
        direction.number[k] = step[k];
        const real_t went = search_along(search, &direction);
        step[k] = real_mul(step[k], real_max(SSV_STEP_SHRINK, real_min(SSV_STEP_GROW, went)));
    }
}

// Each number together with the one that stands so far further along the list: both the same way, or one against the
// other, whichever is lower. Where the price has a kink, neither number gains alone.
static void search_pairs(search_t* search, const real_t step[SSV_NUM_FREE], int apart) {
    for (int k = 0; k < SSV_NUM_FREE; k++) {
        const int other = (k + apart) % SSV_NUM_FREE;
        ssv_decision_t decision = *search->decision;
        search_t against = {search->context, search->acceptance, &decision, search->price};
        direction_t direction = {{REAL(0)}};
        direction.number[k] = step[k];
        direction.number[other] = step[other];
        search_along(search, &direction);
        direction.number[other] = -step[other];
        search_along(&against, &direction);
        if (!(against.price < search->price)) continue;
        *search->decision = decision;
        search->price = against.price;
    }
}

// First steps of the numbers that are free in this phase, 0 of the others.
static void first_steps(const ssv_phase_context_t* context, real_t step[SSV_NUM_FREE]) {
    const bool transfer = context->phase == SSV_TRANSFER;
    for (int k = 0; k < SSV_NUM_FREE; k++) {
        step[k] = transfer || !ssv_free_number[k].transfer_only ? ssv_free_number[k].first_step : REAL(0);
    }
    if (transfer && context->question->problem->scenario.ring_angle_given) step[SSV_NUMBER_OF(spin[0])] = REAL(0);
}

void ssv_minimize(ssv_phase_context_t* context, const ssv_acceptance_t* acceptance, const ssv_stage_t* stage,
                  ssv_decision_t* decision, real_t* price) {
    SSV_ASSERT(stage->num_sweeps == 0 || acceptance->least_bend > REAL(0));
    search_t search = {context, acceptance, decision, *price};
    real_t step[SSV_NUM_FREE];
    first_steps(context, step);
    for (int n = 0; n < stage->num_sweeps; n++) {
        const ssv_free_numbers_t before = decision->free;
        const real_t price_before = search.price;
        search_numbers(&search, step);
        if (stage->pairs) search_pairs(&search, step, 1 + n);
        direction_t pattern;
        for (int k = 0; k < SSV_NUM_FREE; k++) pattern.number[k] = decision->free.number[k] - before.number[k];
        search_along(&search, &pattern);
        if (price_before - search.price < real_mul(acceptance->goes_on, price_before)) break;
    }
    *price = search.price;
}

void ssv_minimize_seeds(ssv_phase_context_t* context, const ssv_acceptance_t* acceptance, const ssv_stage_t* stage,
                        ssv_seeds_t* seeds) {
    const int num = stage->num_refined < seeds->num ? stage->num_refined : seeds->num;
    for (int k = 0; k < num; k++) {
        ssv_minimize(context, acceptance, stage, &seeds->seed[k].decision, &seeds->seed[k].price);
    }
    ssv_seeds_sort(seeds, num);
}
