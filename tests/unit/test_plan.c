// Whole plans through the public interface.
#include <string.h>

#include "sample.h"
#include "unity.h"

static ssv_problem_t problem;
static ssv_work_t work;
static ssv_plan_t plan, other;

void setUp(void) {}
void tearDown(void) {}

static ssv_status_t plan_of(const ssv_scenario_t* s, ssv_plan_t* p) {
    ssv_fault_t fault;
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, s, &fault));
    return ssv_plan(&problem, &work, p);
}

static ssv_status_t quote_of(const ssv_scenario_t* s, ssv_quote_t* quote) {
    ssv_fault_t fault;
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, s, &fault));
    return ssv_quote(&problem, &work, quote);
}

static ssv_status_t front_of(const ssv_scenario_t* s, ssv_front_t* front) {
    ssv_fault_t fault;
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, s, &fault));
    return ssv_front(&problem, &work, front);
}

static void test_plan_of_the_case_study_has_the_papers_four_legs_and_two_events(void) {
    const ssv_scenario_t s = scenario_case_study(false);
    TEST_ASSERT_EQUAL_INT(SSV_OK, plan_of(&s, &plan));
    static const ssv_leg_kind_t kind[] = {SSV_TRANSLATE, SSV_TURN, SSV_TURN, SSV_TRANSLATE};
    static const ssv_phase_t phase[] = {SSV_TRANSIT, SSV_TRANSIT, SSV_TRANSFER, SSV_TRANSFER};
    TEST_ASSERT_EQUAL_INT(4, plan.num_legs);
    double time = 0, impulse = 0;
    for (int k = 0; k < 4; k++) {
        TEST_ASSERT_EQUAL_INT(kind[k], plan.leg[k].kind);
        TEST_ASSERT_EQUAL_INT(phase[k], plan.leg[k].phase);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, time, plan.leg[k].t_start_s);
        time += plan.leg[k].duration_s;
        impulse += plan.leg[k].impulse_Ns;
    }
    TEST_ASSERT_EQUAL_INT(2, plan.num_events);
    TEST_ASSERT_EQUAL_INT(SSV_MATE, plan.event[0].kind);
    TEST_ASSERT_EQUAL_DOUBLE(plan.leg[2].t_start_s, plan.event[0].t_s);
    TEST_ASSERT_EQUAL_INT(SSV_DOCK, plan.event[1].kind);
    TEST_ASSERT_EQUAL_DOUBLE(plan.quote.time_s, plan.event[1].t_s);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, time, plan.quote.time_s);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, impulse, plan.quote.impulse_Ns);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, time + impulse, plan.quote.cost);
}

static void test_choice_is_the_cheapest_candidate_and_its_price_is_that_of_the_plan(void) {
    sample_seed(41);
    for (int trial = 0; trial < 50; trial++) {
        const ssv_scenario_t s = sample_scenario();
        TEST_ASSERT_EQUAL_INT(SSV_OK, plan_of(&s, &plan));
        const int contacts = s.contact == 0 ? 2 : 1, heights = s.num_attach_heights == 0 ? 3 : s.num_attach_heights;
        TEST_ASSERT_EQUAL_INT(contacts * heights, plan.quote.num_candidates);
        for (int k = 0; k < plan.quote.num_candidates; k++)
            TEST_ASSERT_TRUE(plan.quote.choice.cost <= plan.quote.candidate[k].cost);
        // To the last bit: what was quoted is what is flown.
        TEST_ASSERT_TRUE(plan.quote.choice.cost == plan.quote.cost && plan.quote.choice.time_s == plan.quote.time_s);
        TEST_ASSERT_TRUE(plan.quote.choice.impulse_Ns == plan.quote.impulse_Ns);
    }
}

static void test_vehicle_on_the_beams_axis_takes_the_cheapest_of_sixteen_sides(void) {
    ssv_scenario_t s = scenario_case_study(true);
    TEST_ASSERT_EQUAL_INT(SSV_OK, plan_of(&s, &plan));
    TEST_ASSERT_TRUE(plan.quote.num_priced >= 3 * SSV_NUM_RING_ANGLES);
    s.ring_angle_given = true;
    double least = (double)INFINITY;
    for (int k = 0; k < SSV_NUM_RING_ANGLES; k++) {
        s.ring_angle_rad = 2 * REAL_PI * k / SSV_NUM_RING_ANGLES;
        TEST_ASSERT_EQUAL_INT(SSV_OK, plan_of(&s, &other));
        least = fmin(least, other.quote.cost);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-9 * least, least, plan.quote.cost);
}

static void test_half_turn_of_the_beam_is_planned_about_the_cheapest_axis(void) {
    ssv_scenario_t s = scenario_case_study(true);
    s.axis_I = vec3(-1, 0, 0); // outward axis of contact 1 is -x: it must come round to +x
    s.ring_angle_given = true;
    s.ring_angle_rad = -REAL_PI / 2;
    TEST_ASSERT_EQUAL_INT(SSV_OK, plan_of(&s, &plan));
    TEST_ASSERT_TRUE(plan.quote.num_priced >= 3 * SSV_NUM_TURN_AXES);
    const vec3_t outward_I = quat_apply(plan.quote.X_IB_final.q, vec3(0, 0, -1));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1, outward_I.x);
}

static void test_sample_moves_with_its_own_velocity_and_joins_the_legs(void) {
    sample_seed(42);
    for (int trial = 0; trial < 20; trial++) {
        const ssv_scenario_t s = sample_scenario();
        TEST_ASSERT_EQUAL_INT(SSV_OK, plan_of(&s, &plan));
        for (int k = 0; k < 200; k++) {
            const double h = 1e-5, t = sample_between(h, plan.quote.time_s - h);
            ssv_sample_t before, here, after;
            ssv_plan_sample(&plan, t - h, &before);
            ssv_plan_sample(&plan, t, &here);
            ssv_plan_sample(&plan, t + h, &after);
            const vec3_t v_I = vec3_scale(1 / (2 * h), vec3_sub(after.X_IS.p, before.X_IS.p));
            // Central difference: rounding 1e-15 / h plus a jump of the acceleration (< 30 m/s2) times h.
            TEST_ASSERT_DOUBLE_WITHIN(5e-4, 0, vec3_norm(vec3_sub(v_I, quat_apply(here.X_IS.q, here.v_IS_S_m_s))));
            const quat_t d = quat_mul(quat_conj(before.X_IS.q), after.X_IS.q);
            const vec3_t w = vec3_scale(1 / h, vec3(d.x, d.y, d.z));
            const double sign = d.w < 0 ? -1 : 1;
            TEST_ASSERT_DOUBLE_WITHIN(5e-4, 0, vec3_norm(vec3_sub(vec3_scale(sign, w), here.w_IS_S_rad_s)));
        }
    }
}

static void test_sample_rests_before_the_start_and_after_the_end(void) {
    const ssv_scenario_t s = scenario_case_study(true);
    ssv_sample_t sample;
    TEST_ASSERT_EQUAL_INT(SSV_OK, plan_of(&s, &plan));
    ssv_plan_sample(&plan, -1, &sample);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0, vec3_norm(vec3_sub(sample.X_IS.p, s.X_IS.p)));
    TEST_ASSERT_FALSE(sample.mated);
    ssv_plan_sample(&plan, plan.quote.time_s + 1, &sample);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0, vec3_norm(vec3_sub(sample.X_IS.p, plan.quote.X_IS_final.p)));
    TEST_ASSERT_TRUE(sample.mated);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) TEST_ASSERT_EQUAL_DOUBLE(0, sample.u_N[i]);
}

static void test_task_that_is_done_already_costs_nothing(void) {
    ssv_scenario_t s = scenario_case_study(true);
    TEST_ASSERT_EQUAL_INT(SSV_OK, plan_of(&s, &plan));
    s.X_IS = plan.quote.X_IS_final;
    s.X_IB = plan.quote.X_IB_final;
    s.num_attach_heights = 1;
    s.attach_heights_m[0] = plan.quote.choice.attach_height_m;
    TEST_ASSERT_EQUAL_INT(SSV_OK, plan_of(&s, &other));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0,
                              other.quote.cost); // a turn by the rounding of the pose, 1e-8 rad, takes some 2e-4 s
    TEST_ASSERT_EQUAL_INT(2, other.num_events);
}

static void test_plan_that_would_take_too_long_is_infeasible_with_a_reason_for_each_candidate(void) {
    ssv_scenario_t s = scenario_case_study(true);
    s.contact = 0;
    s.vehicle.force_max_N = 0.01;
    TEST_ASSERT_EQUAL_INT(SSV_INFEASIBLE, plan_of(&s, &plan));
    TEST_ASSERT_EQUAL_INT(SSV_INFEASIBLE, plan.quote.status);
    TEST_ASSERT_EQUAL_INT(6, plan.quote.num_candidates);
    for (int k = 0; k < 6; k++) TEST_ASSERT_EQUAL_INT(SSV_TOO_LONG, plan.quote.candidate[k].outcome);
    TEST_ASSERT_EQUAL_INT(0, plan.num_legs + plan.num_segments + plan.num_events);
    TEST_ASSERT_TRUE(plan.plan_hash == 0 && plan.quote.scenario_hash == ssv_scenario_hash(&s));
}

static void test_quote_lists_candidates_only_when_asked_and_is_the_plan_s_price_either_way(void) {
    for (int method = SSV_METHOD_OPTIMAL; method <= SSV_METHOD_PAPER; method++) {
        ssv_scenario_t s = scenario_case_study(true);
        ssv_quote_t with, without;
        s.method = (ssv_method_t)method;
        TEST_ASSERT_EQUAL_INT(SSV_OK, quote_of(&s, &with));
        s.want_candidates = false;
        TEST_ASSERT_EQUAL_INT(SSV_OK, quote_of(&s, &without));
        TEST_ASSERT_EQUAL_INT(3, with.num_candidates);
        TEST_ASSERT_EQUAL_INT(0, without.num_candidates);
        // Listed are the prices of a search of each, which may find a cheaper one.
        TEST_ASSERT_TRUE(method == SSV_METHOD_PAPER ? with.cost == without.cost : with.cost <= without.cost);
        for (int k = 0; k < 3; k++) TEST_ASSERT_TRUE(with.candidate[k].cost >= with.cost);
        TEST_ASSERT_EQUAL_INT(SSV_OK, plan_of(&s, &plan));
        TEST_ASSERT_TRUE(plan.quote.cost == without.cost && plan.quote.lower_bound == without.lower_bound);
        s.want_candidates = true;
        TEST_ASSERT_EQUAL_INT(SSV_OK, plan_of(&s, &plan));
        TEST_ASSERT_TRUE(plan.quote.cost == with.cost);
    }
}

static void test_heavy_weights_and_strong_thrusters_price_a_task_beyond_any_round_number(void) {
    for (int method = SSV_METHOD_OPTIMAL; method <= SSV_METHOD_PAPER; method++) {
        ssv_scenario_t s = scenario_case_study(true);
        s.method = (ssv_method_t)method;
        s.want_candidates = false;
        s.vehicle.force_max_N = REAL(10000);
        s.vehicle.body.drag_lin_kg_s = REAL(100000);
        s.X_IS.p.x = REAL(-900);
        TEST_ASSERT_EQUAL_INT(SSV_OK, plan_of(&s, &plan));
        const real_t cost = plan.quote.cost;
        s.weight_time_per_s = s.weight_impulse_per_Ns = REAL(512);
        TEST_ASSERT_EQUAL_INT(SSV_OK, plan_of(&s, &plan));
        TEST_ASSERT_TRUE(plan.quote.cost == 512 * cost && plan.quote.cost > 1e9);
    }
}

static void test_optimal_comes_close_to_coupled_motion_on_the_case_study(void) {
    // The least J known for the case study of model paper, from direct collocation of motion that turns and flies at
    // once, and how far above it either effort may stay.
    static const struct {
        double time, impulse, coupled_optimum, slack[2];
    } row[] = {
        {1, 0, 166.2, {0.06, 0.035}},
        {1, 0.1, 628.8, {0.04, 0.02}},
        {1, 1, 3699.7, {0.03, 0.015}},
        {0.01, 1, 3399.2, {0.01, 0.005}},
    };
    for (size_t k = 0; k < sizeof row / sizeof row[0]; k++) {
        for (int effort = SSV_EFFORT_QUICK; effort <= SSV_EFFORT_BEST; effort++) {
            ssv_scenario_t s = scenario_case_study(false);
            ssv_quote_t quote;
            s.method = SSV_METHOD_OPTIMAL;
            s.effort = (ssv_effort_t)effort;
            s.want_candidates = false;
            s.weight_time_per_s = real_from_double(row[k].time);
            s.weight_impulse_per_Ns = real_from_double(row[k].impulse);
            TEST_ASSERT_EQUAL_INT(SSV_OK, quote_of(&s, &quote));
            TEST_ASSERT_TRUE(real_to_double(quote.cost) <= row[k].coupled_optimum * (1 + row[k].slack[effort]));
        }
    }
}

static void test_front_of_the_case_study_serves_a_scheduler_that_changes_its_weights(void) {
    static const double weights[][2] = {{1, 0}, {0, 1}, {1, 1}};
    ssv_scenario_t s = scenario_case_study(false);
    ssv_front_t front;
    s.method = SSV_METHOD_OPTIMAL;
    TEST_ASSERT_EQUAL_INT(SSV_OK, front_of(&s, &front));
    for (int k = 0; k < 3; k++) {
        ssv_quote_t quote;
        double least = (double)INFINITY;
        s.weight_time_per_s = real_from_double(weights[k][0]);
        s.weight_impulse_per_Ns = real_from_double(weights[k][1]);
        TEST_ASSERT_EQUAL_INT(SSV_OK, quote_of(&s, &quote));
        for (int n = 0; n < front.num_points; n++) {
            const ssv_candidate_t* point = &front.point[n];
            const double time_s = real_to_double(point->time_s), impulse_Ns = real_to_double(point->impulse_Ns);
            least = fmin(least, weights[k][0] * time_s + weights[k][1] * impulse_Ns);
        }
        TEST_ASSERT_TRUE(least <= real_to_double(quote.cost) * (1 + 1e-12)); // all three are rungs of its ladder
    }
}

static void test_quote_and_front_of_an_infeasible_task_say_so(void) {
    ssv_scenario_t s = scenario_case_study(true);
    ssv_quote_t quote;
    ssv_front_t front;
    s.vehicle.force_max_N = real_from_double(0.01);
    s.want_candidates = false;
    TEST_ASSERT_EQUAL_INT(SSV_INFEASIBLE, quote_of(&s, &quote));
    TEST_ASSERT_EQUAL_INT(3, quote.num_candidates); // the reasons, asked for or not
    for (int k = 0; k < 3; k++) TEST_ASSERT_EQUAL_INT(SSV_TOO_LONG, quote.candidate[k].outcome);
    TEST_ASSERT_TRUE(quote.cost == 0 && quote.time_s == 0 && quote.scenario_hash == ssv_scenario_hash(&s));
    TEST_ASSERT_EQUAL_INT(SSV_INFEASIBLE, front_of(&s, &front));
    TEST_ASSERT_EQUAL_INT(0, front.num_points);
}

static void test_same_question_gets_the_same_plan_and_another_question_another_hash(void) {
    ssv_scenario_t s = scenario_case_study(true);
    plan_of(&s, &plan);
    memset(&other, 0x77, sizeof other);
    plan_of(&s, &other);
    TEST_ASSERT_TRUE(plan.plan_hash != 0 && plan.plan_hash == other.plan_hash);
    TEST_ASSERT_TRUE(plan.plan_hash == ssv_plan_hash(&plan));
    plan.segment[3].u_end_N[2] += 1e-12;
    TEST_ASSERT_TRUE(plan.plan_hash != ssv_plan_hash(&plan));
    s.p_IP_m.x += 1e-9;
    plan_of(&s, &other);
    TEST_ASSERT_TRUE(plan.plan_hash != other.plan_hash && plan.quote.scenario_hash != other.quote.scenario_hash);
}

static void assert_same_candidate(const ssv_candidate_t* a, const ssv_candidate_t* b) {
    TEST_ASSERT_TRUE(a->contact == b->contact && a->outcome == b->outcome);
    TEST_ASSERT_TRUE(a->attach_height_m == b->attach_height_m && a->ring_angle_rad == b->ring_angle_rad);
    TEST_ASSERT_TRUE(a->time_s == b->time_s && a->impulse_Ns == b->impulse_Ns && a->cost == b->cost);
}

// All that may be asked about a problem, and the answers.
typedef struct {
    ssv_work_t work;
    ssv_plan_t plan;
    ssv_quote_t quote;
    ssv_front_t front;
} asker_t;

static void ask(asker_t* asker, int what) {
    if (what == 0) TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_plan(&problem, &asker->work, &asker->plan));
    if (what == 1) TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_quote(&problem, &asker->work, &asker->quote));
    if (what == 2) TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_front(&problem, &asker->work, &asker->front));
}

static void assert_same_answers(const asker_t* a, const asker_t* b) {
    TEST_ASSERT_TRUE(ssv_plan_hash(&a->plan) == ssv_plan_hash(&b->plan) && a->plan.quote.cost == b->plan.quote.cost);
    TEST_ASSERT_TRUE(a->quote.cost == b->quote.cost && a->quote.lower_bound == b->quote.lower_bound);
    TEST_ASSERT_EQUAL_INT(a->quote.num_priced, b->quote.num_priced);
    TEST_ASSERT_EQUAL_INT(a->quote.num_candidates, b->quote.num_candidates);
    assert_same_candidate(&a->quote.choice, &b->quote.choice);
    for (int k = 0; k < a->quote.num_candidates; k++)
        assert_same_candidate(&a->quote.candidate[k], &b->quote.candidate[k]);
    TEST_ASSERT_EQUAL_INT(a->front.num_points, b->front.num_points);
    for (int k = 0; k < a->front.num_points; k++) assert_same_candidate(&a->front.point[k], &b->front.point[k]);
}

// One asker asks its three questions of a fresh problem each, two others take turns on one problem.
static void test_questions_about_one_problem_change_neither_it_nor_one_another(void) {
    static asker_t alone, askers[2];
    static ssv_problem_t untouched;
    for (int method = SSV_METHOD_OPTIMAL; method <= SSV_METHOD_PAPER; method++) {
        ssv_scenario_t s = scenario_case_study(true);
        ssv_fault_t fault;
        s.method = (ssv_method_t)method;
        s.contact = 0;
        memset(&alone, 0, sizeof alone);
        for (int what = 0; what < 3; what++) {
            TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &s, &fault));
            ask(&alone, what);
        }
        TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &s, &fault));
        memcpy(&untouched, &problem, sizeof problem);
        for (int k = 0; k < 2; k++) memset(&askers[k], 0x33 * (k + 1), sizeof askers[k]);
        for (int turn = 0; turn < 3; turn++) {
            for (int k = 0; k < 2; k++) ask(&askers[k], (turn + k) % 3);
        }
        for (int k = 0; k < 2; k++) assert_same_answers(&alone, &askers[k]);
        TEST_ASSERT_EQUAL_MEMORY(&untouched, &problem, sizeof problem);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_questions_about_one_problem_change_neither_it_nor_one_another);
    RUN_TEST(test_plan_of_the_case_study_has_the_papers_four_legs_and_two_events);
    RUN_TEST(test_choice_is_the_cheapest_candidate_and_its_price_is_that_of_the_plan);
    RUN_TEST(test_vehicle_on_the_beams_axis_takes_the_cheapest_of_sixteen_sides);
    RUN_TEST(test_half_turn_of_the_beam_is_planned_about_the_cheapest_axis);
    RUN_TEST(test_sample_moves_with_its_own_velocity_and_joins_the_legs);
    RUN_TEST(test_sample_rests_before_the_start_and_after_the_end);
    RUN_TEST(test_task_that_is_done_already_costs_nothing);
    RUN_TEST(test_plan_that_would_take_too_long_is_infeasible_with_a_reason_for_each_candidate);
    RUN_TEST(test_quote_lists_candidates_only_when_asked_and_is_the_plan_s_price_either_way);
    RUN_TEST(test_heavy_weights_and_strong_thrusters_price_a_task_beyond_any_round_number);
    RUN_TEST(test_optimal_comes_close_to_coupled_motion_on_the_case_study);
    RUN_TEST(test_front_of_the_case_study_serves_a_scheduler_that_changes_its_weights);
    RUN_TEST(test_quote_and_front_of_an_infeasible_task_say_so);
    RUN_TEST(test_same_question_gets_the_same_plan_and_another_question_another_hash);
    return UNITY_END();
}
