// libFuzzer target: the bytes of a scenario_t as they may come from anyone, decoded and answered as the daemon does it.
// Whatever they are, the answer must be sound.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ssv/answer.h"

#define CHECK(condition)                                                                                                 \
    do {                                                                                                                 \
        if (!(condition)) {                                                                                              \
            fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);                                      \
            abort();                                                                                                     \
        }                                                                                                                \
    } while (0)

#define ANSWER_BYTES_MAX 24576 // as much as the daemon stores

static bool is_price(double x) { return isfinite(x) && x >= 0; }

static bool is_near(double a, double b) { return fabs(a - b) <= 1e-9 * (fabs(a) + fabs(b)) + 1e-9; }

static void check_candidates(const lcm_ssv_plan_t* plan) {
    CHECK(plan->num_candidates >= 1 && plan->num_candidates <= SSV_MAX_CANDIDATES);
    for (int i = 0; i < plan->num_candidates; i++) {
        const lcm_ssv_candidate_t* candidate = &plan->candidates[i];
        CHECK(candidate->contact == 1 || candidate->contact == 2);
        CHECK(is_price(candidate->time_s) && is_price(candidate->impulse_Ns) && is_price(candidate->cost));
        const bool feasible = candidate->reason[0] == '\0';
        CHECK(!feasible || plan->status == LCM_SSV_PLAN_T_STATUS_OK);
        CHECK(!feasible || plan->cost <= candidate->cost || is_near(plan->cost, candidate->cost)); // sums in another order
    }
}

static void check_motion(const lcm_ssv_scenario_t* question, const lcm_ssv_plan_t* plan) {
    CHECK(plan->num_legs >= 0 && plan->num_legs <= SSV_MAX_LEGS);
    CHECK(plan->num_segments >= 0 && plan->num_segments <= SSV_MAX_SEGMENTS);
    CHECK(plan->num_events == SSV_MAX_EVENTS);
    CHECK(is_price(plan->time_s) && is_price(plan->impulse_Ns) && is_price(plan->cost));
    const double cost = question->weight_time_per_s * plan->time_s + question->weight_impulse_per_Ns * plan->impulse_Ns;
    CHECK(is_near(plan->cost, cost));
    CHECK(is_price(plan->cost_lower_bound) && plan->cost_lower_bound <= plan->cost * (1 + 1e-12));
    CHECK(question->contact == 0 || plan->choice.contact == question->contact);
    double time_s = 0, impulse_Ns = 0;
    for (int i = 0; i < plan->num_legs; i++) {
        CHECK(is_near(plan->legs[i].t_start_s, time_s));
        time_s += plan->legs[i].duration_s;
        impulse_Ns += plan->legs[i].impulse_Ns;
    }
    CHECK(is_near(time_s, plan->time_s) && is_near(impulse_Ns, plan->impulse_Ns));

    double end_s = 0;
    for (int i = 0; i < plan->num_segments; i++) {
        const lcm_ssv_segment_t* segment = &plan->segments[i];
        CHECK(is_near(segment->t_s, end_s) && segment->duration_s > 0);
        end_s = segment->t_s + segment->duration_s;
        CHECK(segment->leg >= 0 && segment->leg < plan->num_legs);
        for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
            const double limit_N = question->vehicle.force_max_N * (1 + 1e-9);
            CHECK(fabs(segment->u_start_N[k]) <= limit_N && fabs(segment->u_end_N[k]) <= limit_N);
        }
    }
    CHECK(is_near(end_s, plan->time_s));
    CHECK(plan->events[0].kind == LCM_SSV_EVENT_T_KIND_MATE && plan->events[1].kind == LCM_SSV_EVENT_T_KIND_DOCK);
    CHECK(plan->events[0].t_s >= 0 && plan->events[0].t_s <= plan->events[1].t_s);
    CHECK(is_near(plan->events[1].t_s, plan->time_s));
}

/// Answers into memory full of `filler` and encodes. @return the number of bytes.
static int answer_bytes(const lcm_ssv_scenario_t* question, ssv_answer_t* answer, int filler, uint8_t* bytes) {
    memset(answer, filler, sizeof *answer);
    const ssv_status_t outcome = ssv_answer(question, answer);
    const int8_t status = answer->wire.status;
    CHECK(status == (outcome == SSV_OK           ? LCM_SSV_PLAN_T_STATUS_OK
                     : outcome == SSV_INFEASIBLE ? LCM_SSV_PLAN_T_STATUS_INFEASIBLE
                                                 : LCM_SSV_PLAN_T_STATUS_INVALID));
    const int size = lcm_ssv_plan_t_encode(bytes, 0, ANSWER_BYTES_MAX, &answer->wire);
    CHECK(size > 0 && size == lcm_ssv_plan_t_encoded_size(&answer->wire));
    return size;
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static ssv_answer_t answer;
    static uint8_t first[ANSWER_BYTES_MAX], second[ANSWER_BYTES_MAX];
    lcm_ssv_scenario_t question;
    if (size > INT32_MAX || lcm_ssv_scenario_t_decode(data, 0, (int)size, &question) != (int)size) {
        return 0;
    }
    // The same question gets the same bytes, whatever the memory held before.
    const int first_size = answer_bytes(&question, &answer, 0xA5, first);
    const int second_size = answer_bytes(&question, &answer, 0x5A, second);
    CHECK(first_size == second_size && memcmp(first, second, (size_t)first_size) == 0);

    const lcm_ssv_plan_t* plan = &answer.wire;
    CHECK(plan->request_id == question.request_id && plan->epoch_us == question.epoch_us);
    CHECK((plan->status == LCM_SSV_PLAN_T_STATUS_OK) == (plan->reason[0] == '\0'));
    CHECK(strlen(plan->reason) < SSV_REASON_SIZE);
    const lcm_ssv_options_t* options = &question.options;
    const bool is_method =
        options->method == LCM_SSV_OPTIONS_T_METHOD_OPTIMAL || options->method == LCM_SSV_OPTIONS_T_METHOD_PAPER;
    const bool is_effort =
        options->effort == LCM_SSV_OPTIONS_T_EFFORT_QUICK || options->effort == LCM_SSV_OPTIONS_T_EFFORT_BEST;
    CHECK((is_method && is_effort) || plan->status == LCM_SSV_PLAN_T_STATUS_INVALID);
    if (plan->status == LCM_SSV_PLAN_T_STATUS_INVALID) {
        CHECK(plan->num_candidates == 0 && plan->num_legs == 0 && plan->num_segments == 0 && plan->num_events == 0);
        return 0;
    }
    check_candidates(plan);
    if (plan->status == LCM_SSV_PLAN_T_STATUS_INFEASIBLE) {
        CHECK(plan->num_legs == 0 && plan->num_segments == 0 && plan->num_events == 0);
        return 0;
    }
    check_motion(&question, plan);
    return 0;
}
