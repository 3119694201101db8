// Plans as a receiver has them, encoded and decoded: where the vehicle is at any time, and what a thrust reserve does.
// SSV_LONG=1 runs as many as the requirements name.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "question.h"
#include "sample.h"
#include "ssv/answer.h"
#include "unity.h"

#define SEED 20261129
#define TIMES_PER_PLAN 40
#define RELATIVE 1e-12 // numbers cross the wire as they are; only the order of sums may differ

static const lcm_ssv_planner_t planner = {.planner_id = 7, .version = (char[]){"0"}};
static ssv_answer_t answer, other;
static char label[96];

void setUp(void) {}
void tearDown(void) {}

static int times(int quick, int full) { return getenv("SSV_LONG") == NULL ? quick : full; }

static void check_near(double expected, double actual, double size) {
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(RELATIVE * size, expected, actual, label);
}

static void check_vector(vec3_t expected, vec3_t actual, double size) {
    check_near(expected.x, actual.x, size);
    check_near(expected.y, actual.y, size);
    check_near(expected.z, actual.z, size);
}

/// Through the message's bytes and back.
static void receive(const lcm_ssv_plan_t* sent, ssv_plan_t* received) {
    static uint8_t bytes[SSV_PLAN_BYTES_MAX];
    lcm_ssv_plan_t message;
    const int size = lcm_ssv_plan_t_encode(bytes, 0, sizeof bytes, sent);
    TEST_ASSERT_GREATER_THAN(0, size);
    TEST_ASSERT_EQUAL_INT(size, lcm_ssv_plan_t_decode(bytes, 0, size, &message));
    ssv_plan_from_wire(received, &message);
    lcm_ssv_plan_t_decode_cleanup(&message);
}

static void check_samples(double time_s, const ssv_plan_t* here, const ssv_plan_t* there) {
    ssv_sample_t a, b;
    ssv_plan_sample(here, time_s, &a);
    ssv_plan_sample(there, time_s, &b);
    TEST_ASSERT_EQUAL_INT_MESSAGE(a.leg, b.leg, label);
    TEST_ASSERT_EQUAL_INT_MESSAGE(a.mated, b.mated, label);
    check_vector(a.X_IS.p, b.X_IS.p, 1 + vec3_norm(a.X_IS.p));
    check_near(a.X_IS.q.w, b.X_IS.q.w, 1);
    check_near(a.X_IS.q.x, b.X_IS.q.x, 1);
    check_near(a.X_IS.q.y, b.X_IS.q.y, 1);
    check_near(a.X_IS.q.z, b.X_IS.q.z, 1);
    check_vector(a.v_IS_S_m_s, b.v_IS_S_m_s, 1 + vec3_norm(a.v_IS_S_m_s));
    check_vector(a.w_IS_S_rad_s, b.w_IS_S_rad_s, 1 + vec3_norm(a.w_IS_S_rad_s));
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) check_near(a.u_N[i], b.u_N[i], 1 + fabs(a.u_N[i]));
}

static void check_motion(int way) {
    static ssv_plan_t received;
    sample_seed(SEED + (uint64_t)way);
    for (int k = 0; k < times(100, 1000); k++) {
        ssv_scenario_t scenario = sample_scenario();
        scenario.method = way == 0 ? SSV_METHOD_PAPER : SSV_METHOD_OPTIMAL;
        scenario.effort = way == 2 ? SSV_EFFORT_BEST : SSV_EFFORT_QUICK;
        const lcm_ssv_task_t question = question_of(&scenario);
        snprintf(label, sizeof label, "seed %d, way %d, task %d", SEED, way, k);
        if (ssv_answer(&question, &planner, &answer) != SSV_OK) continue;
        receive(&answer.wire, &received);
        for (int i = 0; i <= TIMES_PER_PLAN; i++) {
            const double share = i == TIMES_PER_PLAN ? 1.01 : sample_between(0, 1);
            check_samples(share * answer.wire.quote.time_s, &answer.plan, &received);
        }
        for (int i = 0; i < answer.plan.num_legs; i++) {
            check_samples(answer.plan.leg[i].t_start_s, &answer.plan, &received);
        }
    }
}

static void test_a_received_plan_of_method_paper_moves_as_the_planner_s_own(void) { check_motion(0); }
static void test_a_received_plan_of_method_optimal_moves_as_the_planner_s_own(void) { check_motion(1); }
static void test_a_received_plan_of_effort_best_moves_as_the_planner_s_own(void) { check_motion(2); }

static void test_a_thrust_reserve_is_kept_and_costs_what_weaker_thrusters_would(void) {
    sample_seed(SEED + 10);
    double strongest = 0;
    int plans = 0;
    const int count = times(200, 1000);
    for (int k = 0; k < count; k++) {
        ssv_scenario_t scenario = sample_scenario();
        scenario.method = k % 2 == 0 ? SSV_METHOD_OPTIMAL : SSV_METHOD_PAPER;
        lcm_ssv_task_t question = question_of(&scenario);
        question.scenario.thrust_reserve = 0.2;
        const double force_max_N = question.scenario.vehicle.force_max_N;
        snprintf(label, sizeof label, "seed %d, task %d", SEED + 10, k);
        const ssv_status_t status = ssv_answer(&question, &planner, &answer);
        question.scenario.thrust_reserve = 0;
        question.scenario.vehicle.force_max_N = force_max_N * (1 - 0.2);
        TEST_ASSERT_EQUAL_INT_MESSAGE(status, ssv_answer(&question, &planner, &other), label);
        if (status != SSV_OK) continue;
        plans++;
        const lcm_ssv_quote_t *kept = &answer.wire.quote, *weak = &other.wire.quote;
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&weak->cost, &kept->cost, sizeof kept->cost, label);
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&weak->cost_lower_bound, &kept->cost_lower_bound, sizeof kept->cost, label);
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&weak->time_s, &kept->time_s, sizeof kept->time_s, label);
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&weak->impulse_Ns, &kept->impulse_Ns, sizeof kept->impulse_Ns, label);
        TEST_ASSERT_TRUE_MESSAGE(kept->cost_lower_bound <= kept->cost, label);
        for (int i = 0; i < answer.wire.num_segments; i++) {
            for (int n = 0; n < SSV_NUM_THRUSTERS; n++) {
                const lcm_ssv_segment_t* segment = &answer.wire.segments[i];
                const double most_N = fmax(fabs(segment->u_start_N[n]), fabs(segment->u_end_N[n]));
                TEST_ASSERT_TRUE_MESSAGE(most_N <= force_max_N * (1 - 0.2), label);
                strongest = fmax(strongest, most_N / force_max_N);
            }
        }
    }
    printf("%d plans with a reserve of 0.2: no thrust above %.17g of its limit\n", plans, strongest);
    TEST_ASSERT_GREATER_THAN(count * 9 / 10, plans);
    TEST_ASSERT_TRUE(strongest > 0.79); // the reserve is not kept by flying weakly
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_a_received_plan_of_method_paper_moves_as_the_planner_s_own);
    RUN_TEST(test_a_received_plan_of_method_optimal_moves_as_the_planner_s_own);
    RUN_TEST(test_a_received_plan_of_effort_best_moves_as_the_planner_s_own);
    RUN_TEST(test_a_thrust_reserve_is_kept_and_costs_what_weaker_thrusters_would);
    return UNITY_END();
}
