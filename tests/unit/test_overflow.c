// The planner in fixed point, whose numbers end at 6.7e7: what does not fit is told, and never makes a wrong answer.
#include "sample.h"
#include "unity.h"

static ssv_problem_t problem;
static ssv_work_t work;
static ssv_plan_t plan, zeros;
static ssv_quote_t quote;
static ssv_front_t front;
static ssv_fault_t fault;

void setUp(void) {}
void tearDown(void) {}

// Costs some 1e8.
static ssv_scenario_t too_heavy(void) {
    ssv_scenario_t s = scenario_case_study(false);
    s.X_IS.p.x = REAL(-300);
    s.weight_time_per_s = s.weight_impulse_per_Ns = REAL(1000);
    return s;
}

static void begin(const ssv_scenario_t* s) { TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, s, &fault)); }

static void test_price_beyond_the_largest_number_is_an_overflow_by_either_method(void) {
    for (int method = SSV_METHOD_OPTIMAL; method <= SSV_METHOD_PAPER; method++) {
        ssv_scenario_t s = too_heavy();
        s.method = (ssv_method_t)method;
        begin(&s);
        TEST_ASSERT_EQUAL_INT(SSV_NUMERIC_OVERFLOW, ssv_plan(&problem, &work, &plan));
        TEST_ASSERT_EQUAL_INT(SSV_NUMERIC_OVERFLOW, ssv_quote(&problem, &work, &quote));
        TEST_ASSERT_EQUAL_INT(SSV_NUMERIC_OVERFLOW, ssv_front(&problem, &work, &front));
    }
}

// Every metre costs so much that all directions of the body are beyond the largest number: none is left to seed a
// search, unless the cheapest stands.
static void test_a_vehicle_that_no_direction_is_affordable_for_is_an_overflow_too(void) {
    for (int effort = SSV_EFFORT_QUICK; effort <= SSV_EFFORT_BEST; effort++) {
        ssv_scenario_t s = scenario_case_study(false);
        s.method = SSV_METHOD_OPTIMAL;
        s.effort = (ssv_effort_t)effort;
        s.vehicle.body.drag_lin_kg_s = REAL(100000);
        s.vehicle.force_max_N = REAL(0.001);
        s.weight_time_per_s = s.weight_impulse_per_Ns = REAL(1000);
        begin(&s);
        TEST_ASSERT_EQUAL_INT(SSV_NUMERIC_OVERFLOW, ssv_plan(&problem, &work, &plan));
        TEST_ASSERT_EQUAL_INT(SSV_NUMERIC_OVERFLOW, ssv_quote(&problem, &work, &quote));
    }
}

static void test_overflow_leaves_nothing_but_the_status_and_the_question_s_hash(void) {
    const ssv_scenario_t s = too_heavy();
    begin(&s);
    memset(&plan, 0x5a, sizeof plan);
    memset(&quote, 0x5a, sizeof quote);
    memset(&front, 0x5a, sizeof front);
    (void)ssv_plan(&problem, &work, &plan);
    (void)ssv_quote(&problem, &work, &quote);
    (void)ssv_front(&problem, &work, &front);
    memset(&zeros, 0, sizeof zeros);
    zeros.quote.status = SSV_NUMERIC_OVERFLOW;
    zeros.quote.scenario_hash = ssv_scenario_hash(&s);
    TEST_ASSERT_EQUAL_MEMORY(&zeros, &plan, sizeof plan);
    TEST_ASSERT_EQUAL_MEMORY(&zeros.quote, &quote, sizeof quote);
    TEST_ASSERT_EQUAL_INT(SSV_NUMERIC_OVERFLOW, front.status);
    TEST_ASSERT_EQUAL_INT(0, front.num_points);
    TEST_ASSERT_TRUE(front.scenario_hash == zeros.quote.scenario_hash);
}

static void test_overflow_of_one_question_does_not_taint_the_next(void) {
    const ssv_scenario_t heavy = too_heavy();
    ssv_scenario_t light = scenario_case_study(false);
    light.method = SSV_METHOD_OPTIMAL;
    begin(&light);
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_plan(&problem, &work, &plan));
    const uint64_t hash = plan.plan_hash;
    begin(&heavy);
    TEST_ASSERT_EQUAL_INT(SSV_NUMERIC_OVERFLOW, ssv_plan(&problem, &work, &plan));
    begin(&light);
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_plan(&problem, &work, &plan));
    TEST_ASSERT_TRUE(hash == plan.plan_hash);
}

static void test_bound_that_does_not_fit_is_the_bound_that_always_holds(void) {
    ssv_scenario_t s = scenario_case_study(false);
    begin(&s);
    TEST_ASSERT_TRUE(ssv_lower_bound(&problem) > REAL(3000));
    s.weight_impulse_per_Ns = REAL(1000);
    s.vehicle.body.drag_lin_kg_s = REAL(100000);
    begin(&s);
    TEST_ASSERT_TRUE(ssv_lower_bound(&problem) == REAL(0));
}

static void test_thrusters_whose_matrix_has_no_inverse_in_fixed_point_are_refused_as_singular(void) {
    ssv_scenario_t s = scenario_case_study(false);
    s.vehicle.radius_m = REAL(0.001);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++)
        s.vehicle.thruster[i].p_ST_m = vec3_scale(REAL(1e-7), s.vehicle.thruster[i].p_ST_m);
    s.vehicle.thruster[0].p_ST_m = vec3(REAL(0), REAL(0), REAL(10));
    const uint32_t overflows = real_overflows();
    TEST_ASSERT_EQUAL_INT(SSV_E_SINGULAR, ssv_problem_init(&problem, &s, &fault));
    TEST_ASSERT_TRUE(real_overflows() != overflows);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_price_beyond_the_largest_number_is_an_overflow_by_either_method);
    RUN_TEST(test_a_vehicle_that_no_direction_is_affordable_for_is_an_overflow_too);
    RUN_TEST(test_overflow_leaves_nothing_but_the_status_and_the_question_s_hash);
    RUN_TEST(test_overflow_of_one_question_does_not_taint_the_next);
    RUN_TEST(test_bound_that_does_not_fit_is_the_bound_that_always_holds);
    RUN_TEST(test_thrusters_whose_matrix_has_no_inverse_in_fixed_point_are_refused_as_singular);
    return UNITY_END();
}
