// libFuzzer target: the bytes of a task_t or a scenario_batch_t as they may come from anyone, decoded and answered
// as the daemon does it. Whatever they are, the answer must be sound.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ssv/answer.h"

#define CHECK(condition)                                                                                               \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);                                    \
            abort();                                                                                                   \
        }                                                                                                              \
    } while (0)

static const lcm_ssv_planner_t planner = {.planner_id = 1, .version = (char[]){"0"}};

static bool is_same_asker(const lcm_ssv_asker_t* a, const lcm_ssv_asker_t* b) {
    return a->asker_id == b->asker_id && a->request_id == b->request_id && a->epoch_us == b->epoch_us &&
           a->planner_id == b->planner_id;
}

static bool is_price(double x) { return isfinite(x) && x >= 0; }

// How far two ways to the same sum may lie apart, relative and absolute, and how far a price below its bound or a
// thrust beyond its limit. A plan sums at most 128 segments and 8 legs, each rounded a few times; the double figures
// are those of this project's other tests.
#if defined(SSV_REAL_FLOAT)
#define RELATIVE 3e-5 // 256 roundings of 2^-23
#define ABSOLUTE 1e-6 // where the terms cancel, as a time since the start does, in seconds of a plan of one segment
#define BOUND 3e-5
#define LIMIT_ABSOLUTE ABSOLUTE
#elif defined(SSV_REAL_FIXED)
#define RELATIVE 1e-9
#define ABSOLUTE 0x1p-24 // 256 roundings of 2^-32, whatever the size
#define BOUND 1e-9
#define LIMIT_ABSOLUTE ABSOLUTE
#else
#define RELATIVE 1e-9
#define ABSOLUTE 1e-9
#define BOUND 1e-12
#define LIMIT_ABSOLUTE 0 // a thrust keeps to its limit, and a price to its bound, however small they are
#endif

static bool is_near(double a, double b) { return fabs(a - b) <= RELATIVE * (fabs(a) + fabs(b)) + ABSOLUTE; }

/// Every price, with the sums that it is made of: of the weights as the planner's scalar holds them.
static void check_price(const lcm_ssv_scenario_t* question, double time_s, double impulse_Ns, double cost) {
    CHECK(is_price(time_s) && is_price(impulse_Ns) && is_price(cost));
    const double per_s = real_to_double(real_from_double(question->weight_time_per_s));
    const double per_Ns = real_to_double(real_from_double(question->weight_impulse_per_Ns));
    const double sum = per_s * time_s + per_Ns * impulse_Ns;
    // A weight enlarges the rounding of what it weighs.
    CHECK(fabs(cost - sum) <= RELATIVE * (cost + sum) + ABSOLUTE * (1 + per_s + per_Ns));
}

static void check_candidates(const lcm_ssv_scenario_t* question, const lcm_ssv_quote_t* quote) {
    const bool is_ok = quote->status == LCM_SSV_QUOTE_T_STATUS_OK;
    if (quote->status == LCM_SSV_QUOTE_T_STATUS_NUMERIC_OVERFLOW) {
        CHECK(quote->num_candidates == 0 && quote->num_front == 0);
        return;
    }
    CHECK(quote->num_candidates >= 0 && quote->num_candidates <= SSV_MAX_CANDIDATES);
    CHECK((quote->num_candidates > 0) == (!is_ok || question->options.want_candidates != 0));
    for (int i = 0; i < quote->num_candidates; i++) {
        const lcm_ssv_candidate_t* candidate = &quote->candidates[i];
        CHECK(candidate->contact == 1 || candidate->contact == 2);
        check_price(question, candidate->time_s, candidate->impulse_Ns, candidate->cost);
        const bool feasible = candidate->reason[0] == '\0';
        CHECK(strlen(candidate->reason) < SSV_CANDIDATE_REASON_SIZE);
        CHECK(!feasible || is_ok);
        CHECK(!feasible || quote->cost <= candidate->cost ||
              is_near(quote->cost, candidate->cost)); // sums in another order
    }
}

static void check_front(const lcm_ssv_scenario_t* question, const lcm_ssv_quote_t* quote) {
    const bool wanted = quote->status == LCM_SSV_QUOTE_T_STATUS_OK && question->options.want_front != 0;
    CHECK(quote->num_front >= 0 && quote->num_front <= SSV_MAX_FRONT);
    CHECK((quote->num_front > 0) == wanted);
    for (int i = 0; i < quote->num_front; i++) {
        const lcm_ssv_candidate_t* point = &quote->front[i];
        CHECK(point->reason[0] == '\0');
        check_price(question, point->time_s, point->impulse_Ns, point->cost);
        CHECK(i == 0 ||
              (quote->front[i - 1].time_s < point->time_s && quote->front[i - 1].impulse_Ns > point->impulse_Ns));
    }
}

static void check_quote(const lcm_ssv_scenario_t* question, const lcm_ssv_quote_t* quote) {
    CHECK((quote->status == LCM_SSV_QUOTE_T_STATUS_OK) == (quote->reason[0] == '\0'));
    CHECK(strlen(quote->reason) < SSV_REASON_SIZE - 1); // none is cut
    const lcm_ssv_options_t* options = &question->options;
    const bool is_method =
        options->method == LCM_SSV_OPTIONS_T_METHOD_OPTIMAL || options->method == LCM_SSV_OPTIONS_T_METHOD_PAPER;
    const bool is_effort =
        options->effort == LCM_SSV_OPTIONS_T_EFFORT_QUICK || options->effort == LCM_SSV_OPTIONS_T_EFFORT_BEST;
    CHECK((is_method && is_effort) || quote->status == LCM_SSV_QUOTE_T_STATUS_INVALID);
#if !defined(SSV_REAL_FLOAT) && !defined(SSV_REAL_FIXED)
    CHECK(quote->status !=
          LCM_SSV_QUOTE_T_STATUS_NUMERIC_OVERFLOW); // what is within its range does not overflow a double
#endif
    if (quote->status != LCM_SSV_QUOTE_T_STATUS_OK) { // nothing is claimed
        CHECK(quote->time_s == 0 && quote->impulse_Ns == 0 && quote->cost == 0 && quote->cost_lower_bound == 0);
    }
    if (quote->status == LCM_SSV_QUOTE_T_STATUS_INVALID) {
        CHECK(quote->num_candidates == 0 && quote->num_front == 0);
        return;
    }
    check_candidates(question, quote);
    check_front(question, quote);
    if (quote->status == LCM_SSV_QUOTE_T_STATUS_OK) {
        check_price(question, quote->time_s, quote->impulse_Ns, quote->cost);
        CHECK(is_price(quote->cost_lower_bound) &&
              quote->cost_lower_bound <= quote->cost * (1 + BOUND) + LIMIT_ABSOLUTE * BOUND);
        CHECK(question->contact == 0 || quote->choice.contact == question->contact);
    }
}

static void check_motion(const lcm_ssv_scenario_t* question, const lcm_ssv_plan_t* plan) {
    const lcm_ssv_quote_t* quote = &plan->quote;
    CHECK(plan->num_legs >= 0 && plan->num_legs <= SSV_MAX_LEGS);
    CHECK(plan->num_segments >= 0 && plan->num_segments <= SSV_MAX_SEGMENTS);
    CHECK(plan->num_events == SSV_MAX_EVENTS);
    double time_s = 0, impulse_Ns = 0;
    for (int i = 0; i < plan->num_legs; i++) {
        CHECK(is_near(plan->legs[i].t_start_s, time_s));
        time_s += plan->legs[i].duration_s;
        impulse_Ns += plan->legs[i].impulse_Ns;
    }
    CHECK(is_near(time_s, quote->time_s) && is_near(impulse_Ns, quote->impulse_Ns));

    double end_s = 0;
    for (int i = 0; i < plan->num_segments; i++) {
        const lcm_ssv_segment_t* segment = &plan->segments[i];
        CHECK(is_near(segment->t_s, end_s) && segment->duration_s > 0);
        end_s = segment->t_s + segment->duration_s;
        CHECK(segment->leg >= 0 && segment->leg < plan->num_legs);
        for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
            const double limit_N =
                question->vehicle.force_max_N * (1 - question->thrust_reserve) * (1 + RELATIVE) + LIMIT_ABSOLUTE;
            CHECK(fabs(segment->u_start_N[k]) <= limit_N && fabs(segment->u_end_N[k]) <= limit_N);
        }
    }
    CHECK(is_near(end_s, quote->time_s));
    CHECK(plan->events[0].kind == LCM_SSV_EVENT_T_KIND_MATE && plan->events[1].kind == LCM_SSV_EVENT_T_KIND_DOCK);
    CHECK(plan->events[0].t_s >= 0 && plan->events[0].t_s <= plan->events[1].t_s);
    CHECK(is_near(plan->events[1].t_s, quote->time_s));
}

/// What a plan says of its clearance is sound, and what was asked for.
static void check_clearance(const lcm_ssv_task_t* task, const lcm_ssv_plan_t* plan) {
    const lcm_ssv_clearance_t* clearance = &plan->clearance;
    const bool has_tank = task->scene.tank.kind != LCM_SSV_TANK_T_KIND_NONE;
    const bool counts = task->scenario.obstacles != 0 || has_tank || real_from_double(task->scenario.margin_m) > 0;
    CHECK(isfinite(clearance->certified_m) && isfinite(clearance->seen_m) && isfinite(clearance->s));
    CHECK(clearance->certified_m <= clearance->seen_m);
    if (!counts) {
        CHECK(clearance->obstacle == LCM_SSV_CLEARANCE_T_OBSTACLE_NONE);
        return;
    }
    const int k = clearance->obstacle;
    CHECK(k == LCM_SSV_CLEARANCE_T_OBSTACLE_NONE || k == LCM_SSV_CLEARANCE_T_OBSTACLE_BEAM ||
          (k == LCM_SSV_CLEARANCE_T_OBSTACLE_TANK && has_tank) ||
          (k >= 0 && k < task->scene.num_obstacles &&
           ((uint64_t)task->scenario.obstacles & UINT64_C(1) << (k & 63)) != 0));
    CHECK(clearance->leg >= 0 && (clearance->leg < plan->num_legs || plan->num_legs == 0));
    CHECK(clearance->body == LCM_SSV_CLEARANCE_T_BODY_VEHICLE || clearance->body == LCM_SSV_CLEARANCE_T_BODY_BEAM);
}

static void check_status(ssv_status_t outcome, int8_t status) {
    CHECK(status == (outcome == SSV_OK                 ? LCM_SSV_QUOTE_T_STATUS_OK
                     : outcome == SSV_INFEASIBLE       ? LCM_SSV_QUOTE_T_STATUS_INFEASIBLE
                     : outcome == SSV_NUMERIC_OVERFLOW ? LCM_SSV_QUOTE_T_STATUS_NUMERIC_OVERFLOW
                                                       : LCM_SSV_QUOTE_T_STATUS_INVALID));
}

/// Fills the stack that the planner is about to use: what it reads there without writing it first is no zero by luck.
__attribute__((noinline)) static void fill_stack(int filler) {
    volatile uint8_t bytes[128 * 1024];
    for (size_t i = 0; i < sizeof bytes; i++) {
        bytes[i] = (uint8_t)filler;
    }
}

/// A search that finds no way takes a hundred times as long as one that does; this one is given up, as a planner gives
/// up what it has no place for.
#define STEPS_MAX 24

/// @return whether the answer is there.
static bool answers(const lcm_ssv_task_t* question, ssv_answer_t* answer) {
    ssv_answer_begin(question, &planner, answer);
    for (int n = 0; n < STEPS_MAX; n++) {
        if (ssv_answer_step(question, answer)) return true;
    }
    return false;
}

/// Answers into memory full of `filler` and encodes. @return the number of bytes; 0 where the answer is given up.
static int plan_bytes(const lcm_ssv_task_t* question, ssv_answer_t* answer, int filler, uint8_t* bytes) {
    memset(answer, filler, sizeof *answer);
    fill_stack(filler);
    if (!answers(question, answer)) return 0;
    check_status(answer->working.status, answer->wire.quote.status);
    const int size = lcm_ssv_plan_t_encode(bytes, 0, SSV_PLAN_BYTES_MAX, &answer->wire);
    CHECK(size > 0 && size == lcm_ssv_plan_t_encoded_size(&answer->wire));
    return size;
}

static void plan_one(const lcm_ssv_task_t* task, ssv_answer_t* answer) {
    static uint8_t first[SSV_PLAN_BYTES_MAX], second[SSV_PLAN_BYTES_MAX];
    // The same question gets the same bytes, whatever the memory held before.
    const int first_size = plan_bytes(task, answer, 0xA5, first);
    const int second_size = plan_bytes(task, answer, 0x5A, second);
    CHECK(first_size == second_size && memcmp(first, second, (size_t)first_size) == 0);
    if (first_size == 0) return;

    const lcm_ssv_scenario_t* question = &task->scenario;
    const lcm_ssv_plan_t* plan = &answer->wire;
    CHECK(is_same_asker(&plan->answer.asker, &question->asker));
    check_quote(question, &plan->quote);
    if (plan->quote.status == LCM_SSV_QUOTE_T_STATUS_OK) {
        check_motion(question, plan);
        check_clearance(task, plan);
    } else {
        CHECK(plan->clearance.obstacle == LCM_SSV_CLEARANCE_T_OBSTACLE_NONE);
        CHECK(plan->num_legs == 0 && plan->num_arcs == 0 && plan->num_segments == 0 && plan->num_events == 0);
    }
}

static bool is_legal(const lcm_ssv_quote_t* quote) { return quote->status != LCM_SSV_QUOTE_T_STATUS_INVALID; }

/// The quotes are sound and go with the plans; a plan whose first choice does not fit its memory may cost more.
/// @return whether every scenario is legal.
static bool quote_all(const lcm_ssv_scenario_batch_t* batch, ssv_answer_t* answer) {
    static ssv_batch_answer_t quotes;
    static uint8_t bytes[SSV_QUOTE_BATCH_BYTES_MAX];
    memset(&quotes, 0xA5, sizeof quotes);
    ssv_answer_batch_begin(batch, 1, &planner, &quotes);
    int steps = 0;
    while (!ssv_answer_batch_step(batch, &quotes)) {
        if (steps++ == STEPS_MAX) return true;
    }
    CHECK(quotes.wire.num_quotes == batch->num_scenarios);
    CHECK(is_same_asker(&quotes.wire.answer.asker, &batch->asker) && quotes.wire.answer.question_hash == 1);
    const int size = lcm_ssv_quote_batch_t_encode(bytes, 0, sizeof bytes, &quotes.wire);
    CHECK(size > 0 && size == lcm_ssv_quote_batch_t_encoded_size(&quotes.wire));
    bool all_legal = true;
    for (int i = 0; i < batch->num_scenarios; i++) {
        lcm_ssv_task_t alone = {batch->scenarios[i], batch->scene};
        const lcm_ssv_quote_t* quote = &quotes.quotes[i];
        check_quote(&alone.scenario, quote);
        alone.scenario.asker.epoch_us = batch->asker.epoch_us; // which holds for all of them
        if (!answers(&alone, answer)) continue;
        const lcm_ssv_quote_t* of_plan = &answer->wire.quote;
        if (of_plan->status == LCM_SSV_QUOTE_T_STATUS_OK) {
            CHECK(quote->status == LCM_SSV_QUOTE_T_STATUS_OK && quote->cost <= of_plan->cost);
            CHECK(quote->scenario_hash == of_plan->scenario_hash &&
                  quote->cost_lower_bound == of_plan->cost_lower_bound);
        } else if (of_plan->status == LCM_SSV_QUOTE_T_STATUS_INVALID) {
            CHECK(quote->status == LCM_SSV_QUOTE_T_STATUS_INVALID && strcmp(quote->reason, of_plan->reason) == 0);
        } else {
            CHECK(quote->status != LCM_SSV_QUOTE_T_STATUS_INVALID);
        }
        all_legal = all_legal && is_legal(quote);
    }
    return all_legal;
}

static unsigned long long num_inputs, num_legal;

static void print_shares(void) { fprintf(stderr, "stat::legal_inputs: %llu of %llu\n", num_legal, num_inputs); }

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static ssv_answer_t answer;
    static lcm_ssv_scenario_t scenarios[SSV_MAX_BATCH];
    static lcm_ssv_task_t task;
    lcm_ssv_scenario_batch_t batch;
    if (num_inputs++ == 0) {
        atexit(print_shares);
    }
    if (ssv_scenario_batch_decode(data, size, scenarios, &batch)) {
        num_legal += quote_all(&batch, &answer);
    } else if (size <= INT32_MAX && lcm_ssv_task_t_decode(data, 0, (int)size, &task) == (int)size) {
        plan_one(&task, &answer);
        num_legal += is_legal(&answer.wire.quote);
    }
    return 0;
}
