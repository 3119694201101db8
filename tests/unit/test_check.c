// Whether an answer can be the answer to a question: the planner's own pass, each kind of forgery is refused.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "question.h"
#include "sample.h"
#include "ssv/answer.h"
#include "ssv/check.h"
#include "unity.h"

#define SEED 20261128
#define NUM_TASKS 300

static const lcm_ssv_planner_t planner = {.planner_id = 7, .version = (char[]){"0"}};
static ssv_answer_t answer;
static lcm_ssv_task_t question;
static char reason[SSV_CHECK_REASON_SIZE], label[96];

void setUp(void) {}
void tearDown(void) {}

static void check_passes(int way) {
    sample_seed(SEED);
    int plans = 0;
    for (int k = 0; k < NUM_TASKS; k++) {
        ssv_scenario_t scenario = sample_scenario();
        scenario.method = way == 0 ? SSV_METHOD_PAPER : SSV_METHOD_OPTIMAL;
        scenario.effort = way == 2 ? SSV_EFFORT_BEST : SSV_EFFORT_QUICK;
        scenario.attach_anywhere = way == 1 && k % 4 == 0;
        scenario.thrust_reserve = k % 3 == 0 ? REAL(0.2) : REAL(0);
        question = question_of(&scenario);
        question.scenario.options.want_candidates = (int8_t)(k % 2);
        question.scenario.options.want_front = way == 1 && k % 10 == 0;
        ssv_answer(&question, &planner, &answer);
        snprintf(label, sizeof label, "seed %d, task %d, way %d", SEED, k, way);
        const bool passes = ssv_check_plan(&question, &answer.wire, reason);
        if (!passes) printf("%s: %s\n", label, reason);
        TEST_ASSERT_TRUE_MESSAGE(passes, label);
        TEST_ASSERT_EQUAL_STRING("", reason);
        plans += answer.wire.quote.status == LCM_SSV_QUOTE_T_STATUS_OK;
    }
    TEST_ASSERT_GREATER_THAN(NUM_TASKS * 9 / 10, plans); // else this says little
}

static void test_300_plans_of_method_paper_pass(void) { check_passes(0); }
static void test_300_plans_of_method_optimal_pass(void) { check_passes(1); }
static void test_300_plans_of_effort_best_pass(void) { check_passes(2); }

/// A sound answer to the case study, with contact, heights and ring angle asked for.
static void answer_case_study(void) {
    ssv_scenario_t scenario = scenario_case_study(true);
    scenario.contact = 1;
    scenario.num_attach_heights = 2;
    scenario.attach_heights_m[0] = REAL(0.5);
    scenario.attach_heights_m[1] = REAL(-0.5);
    scenario.ring_angle_given = true;
    scenario.ring_angle_rad = REAL(1);
    scenario.method = SSV_METHOD_OPTIMAL;
    scenario.want_candidates = false;
    scenario.thrust_reserve = REAL(0.25);
    question = question_of(&scenario);
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_answer(&question, &planner, &answer));
    TEST_ASSERT_TRUE_MESSAGE(ssv_check_plan(&question, &answer.wire, reason), reason);
}

static lcm_ssv_quote_t* quote(void) { return &answer.wire.quote; }

static void another_asker(void) { answer.wire.answer.asker.asker_id++; }
static void another_request(void) { answer.wire.answer.asker.request_id++; }
static void another_hash(void) { answer.wire.answer.question_hash++; }
static void no_planner(void) { answer.wire.answer.planner.planner_id = 0; }
static void another_planner(void) { question.scenario.asker.planner_id = 8; }
static void no_scalar(void) { answer.wire.answer.planner.scalar = 3; }
static void no_status(void) { quote()->status = 9; }
static void refusal_with_a_motion(void) {
    quote()->status = LCM_SSV_QUOTE_T_STATUS_INFEASIBLE;
    static char why[] = "no";
    quote()->reason = why;
}
static void refusal_without_a_reason(void) { quote()->status = LCM_SSV_QUOTE_T_STATUS_INVALID; }
static void another_contact(void) { quote()->choice.contact = 2; }
static void no_contact(void) { quote()->choice.contact = 3; }
static void another_height(void) { quote()->choice.attach_height_m = 0.25; }
static void height_off_the_beam(void) { quote()->choice.attach_height_m = 9; }
static void another_ring_angle(void) { quote()->choice.ring_angle_rad = 1.1; }
static void cheaper(void) { quote()->cost *= 0.99; }
static void bound_above_price(void) { quote()->cost_lower_bound = quote()->cost * 1.001; }
static void price_that_is_no_number(void) { quote()->cost = (double)NAN; }
static void time_that_is_no_number(void) { quote()->time_s = (double)NAN; }
static void endless_impulse(void) { quote()->impulse_Ns = (double)INFINITY; }
static void candidates_not_asked_for(void) { quote()->num_candidates = 1; }
static void front_not_asked_for(void) { quote()->num_front = 1; }
static void too_strong(void) { answer.wire.segments[0].u_start_N[0] = 0.76 * question.scenario.vehicle.force_max_N; }
static void thrust_that_is_no_number(void) { answer.wire.segments[3].u_end_N[2] = (double)NAN; }
static void gap_in_time(void) { answer.wire.segments[4].t_s += 0.01; }
static void gap_between_legs(void) { answer.wire.legs[1].t_start_s += 0.01; }
static void segment_of_another_leg(void) { answer.wire.segments[0].leg = 1; }
static void one_segment_less(void) { answer.wire.num_segments--; }
static void thrusts_of_nothing(void) {
    for (int i = 0; i < answer.wire.num_segments; i++) {
        memset(answer.wire.segments[i].u_start_N, 0, sizeof answer.wire.segments[i].u_start_N);
        memset(answer.wire.segments[i].u_end_N, 0, sizeof answer.wire.segments[i].u_end_N);
    }
}
static void impulse_of_a_leg(void) { answer.wire.legs[0].impulse_Ns *= 1.01; }
static void another_start(void) { answer.wire.legs[0].X_IS_start.p_m[1] += 0.01; }
static void another_end_of_a_leg(void) { answer.wire.legs[0].X_IS_end.p_m[0] += 0.01; }
static void another_end(void) { quote()->X_IS_final.p_m[2] += 0.01; }
static void another_dock(void) { quote()->X_IB_final.p_m[0] += 0.01; }
static void another_grasp(void) { answer.wire.X_SB.p_m[0] += 0.01; }
static void turned_twist(void) { answer.wire.legs[0].v_S[0] += 0.1; }
static void arcs_of_another_leg(void) { answer.wire.legs[1].first_arc--; }
static void one_arc_less(void) { answer.wire.num_arcs--; }
static void jump_of_speed(void) { answer.wire.arcs[1].v_start *= 1.1; }
static void gap_between_arcs(void) { answer.wire.arcs[1].t_s += 0.01; }
static void arc_that_is_no_number(void) { answer.wire.arcs[0].dv_dt[1] = (double)NAN; }
static void arrival_that_is_no_number(void) { answer.wire.arrival.lines_rad = (double)NAN; }
static void arrival_beyond_the_goal(void) { answer.wire.arrival.rounding_m = -1e-9; }
static void no_dock(void) { answer.wire.num_events = 1; }
static void early_mate(void) { answer.wire.events[0].t_s *= 0.9; }

// `says` is how the reason begins: with the place of what was forged.
static const struct {
    void (*forge)(void);
    const char *name, *says;
} forgeries[] = {
    {another_asker, "another asker", "answer.asker"},
    {another_request, "another request", "answer.asker"},
    {another_hash, "another hash", "question_hash"},
    {no_planner, "no planner", "planner.planner_id: a planner without"},
    {another_planner, "another planner", "planner.planner_id: another planner"},
    {no_scalar, "no scalar", "planner.scalar: 3"},
    {no_status, "no status", "status: 9"},
    {refusal_with_a_motion, "refusal with a motion", "status: a motion"},
    {refusal_without_a_reason, "refusal without a reason", "reason: "},
    {another_contact, "another contact", "choice: contact 2"},
    {no_contact, "no contact", "choice: contact 3"},
    {another_height, "another height", "choice: height 0.25 m was not asked for"},
    {height_off_the_beam, "height off the beam", "choice: height 9 m is not on the beam"},
    {another_ring_angle, "another ring angle", "choice: ring angle 1.1"},
    {cheaper, "cheaper", "cost: "},
    {bound_above_price, "bound above the price", "cost: 4009.70251 is below the bound"},
    {price_that_is_no_number, "price that is no number", "cost: "},
    {time_that_is_no_number, "time that is no number", "time_s: "},
    {endless_impulse, "endless impulse", "impulse_Ns: "},
    {candidates_not_asked_for, "candidates not asked for", "candidates: not asked for"},
    {front_not_asked_for, "front not asked for", "front: not asked for"},
    {too_strong, "thrust beyond the limit less the reserve", "segments[0], thruster 0: beyond the limit"},
    {thrust_that_is_no_number, "thrust that is no number", "segments[3], thruster 2"},
    {gap_in_time, "gap in time", "segments[4]: starts at"},
    {gap_between_legs, "gap between legs", "legs[1].t_start_s"},
    {segment_of_another_leg, "segment of another leg", "segments["},
    {one_segment_less, "one segment less", "segments: "},
    {thrusts_of_nothing, "thrusts of nothing", "segments: "},
    {impulse_of_a_leg, "impulse of a leg", "impulse_Ns: "},
    {another_start, "another start", "legs[0]"},
    {another_end_of_a_leg, "another end of a leg", "legs[0]"},
    {another_end, "another end", "X_IS_final"},
    {another_dock, "another dock", "X_IB_final"},
    {another_grasp, "another grasp", "X_SB"},
    {turned_twist, "turned twist", "legs[0]"},
    {arcs_of_another_leg, "arcs of another leg", "legs[1]: its arcs"},
    {one_arc_less, "one arc less", "legs["},
    {jump_of_speed, "jump of speed", "arcs[1]"},
    {gap_between_arcs, "gap between arcs", "arcs[1]"},
    {arc_that_is_no_number, "arc that is no number", "arcs[0]"},
    {no_dock, "no dock", "events: "},
    {early_mate, "early mate", "events[0]"},
    {arrival_that_is_no_number, "arrival that is no number", "arrival"},
    {arrival_beyond_the_goal, "arrival beyond the goal", "arrival"},
};

static void test_each_kind_of_forgery_is_refused_with_its_own_reason(void) {
    for (size_t i = 0; i < sizeof forgeries / sizeof forgeries[0]; i++) {
        answer_case_study();
        forgeries[i].forge();
        const bool passes = ssv_check_plan(&question, &answer.wire, reason);
        snprintf(label, sizeof label, "%s: %.60s", forgeries[i].name, reason);
        TEST_ASSERT_FALSE_MESSAGE(passes, label);
        TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE(forgeries[i].says, reason, strlen(forgeries[i].says), label);
    }
}

static void test_another_question_than_the_one_answered_is_told_by_its_hash(void) {
    answer_case_study();
    question.scenario.weight_impulse_per_Ns *= 2;
    TEST_ASSERT_FALSE(ssv_check_plan(&question, &answer.wire, reason));
    TEST_ASSERT_EQUAL_STRING_LEN("question_hash", reason, strlen("question_hash"));
}

static void test_a_refusal_of_the_question_is_an_answer(void) {
    answer_case_study();
    question.scenario.contact = 3;
    ssv_answer(&question, &planner, &answer);
    TEST_ASSERT_EQUAL_INT(LCM_SSV_QUOTE_T_STATUS_INVALID, answer.wire.quote.status);
    TEST_ASSERT_TRUE_MESSAGE(ssv_check_plan(&question, &answer.wire, reason), reason);
}

static void test_quotes_pass_and_those_of_another_count_hash_or_price_do_not(void) {
    static ssv_batch_answer_t quotes;
    lcm_ssv_scenario_t scenarios[3];
    sample_seed(SEED + 1);
    for (int i = 0; i < 3; i++) {
        const ssv_scenario_t scenario = sample_scenario();
        scenarios[i] = question_of(&scenario).scenario;
    }
    const lcm_ssv_scenario_batch_t batch = {
        .asker = {.asker_id = 1, .request_id = 2}, .num_scenarios = 3, .scenarios = scenarios};
    ssv_answer_batch(&batch, 99, &planner, &quotes);
    TEST_ASSERT_TRUE_MESSAGE(ssv_check_quotes(&batch, 99, &quotes.wire, reason), reason);
    TEST_ASSERT_FALSE(ssv_check_quotes(&batch, 98, &quotes.wire, reason));
    TEST_ASSERT_EQUAL_STRING_LEN("question_hash", reason, strlen("question_hash"));
    quotes.wire.num_quotes = 2;
    TEST_ASSERT_FALSE(ssv_check_quotes(&batch, 99, &quotes.wire, reason));
    TEST_ASSERT_EQUAL_STRING("num_quotes: 2 to 3 scenarios", reason);
    quotes.wire.num_quotes = 3;
    quotes.quotes[1].cost *= 1.01;
    TEST_ASSERT_FALSE(ssv_check_quotes(&batch, 99, &quotes.wire, reason));
    TEST_ASSERT_EQUAL_STRING_LEN("quotes[1].cost", reason, strlen("quotes[1].cost"));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_300_plans_of_method_paper_pass);
    RUN_TEST(test_300_plans_of_method_optimal_pass);
    RUN_TEST(test_300_plans_of_effort_best_pass);
    RUN_TEST(test_each_kind_of_forgery_is_refused_with_its_own_reason);
    RUN_TEST(test_another_question_than_the_one_answered_is_told_by_its_hash);
    RUN_TEST(test_a_refusal_of_the_question_is_an_answer);
    RUN_TEST(test_quotes_pass_and_those_of_another_count_hash_or_price_do_not);
    return UNITY_END();
}
