// Moves: the pose along a twist, and the choice between the two ramps.
#include "planner/motion/maneuver.h"
#include "sample.h"
#include "unity.h"

void setUp(void) {}
void tearDown(void) {}

static double pose_distance(pose_t a, pose_t b) {
    const quat_t d = quat_mul(quat_conj(a.q), b.q);
    return vec3_norm(vec3_sub(a.p, b.p)) + 2 * vec3_norm(vec3(d.x, d.y, d.z));
}

static void test_pose_along_any_twist_solves_the_kinematic_equations(void) {
    sample_seed(21);
    for (int trial = 0; trial < 50; trial++) {
        const ssv_twist_t twist = {sample_vector(2), sample_direction()};
        const pose_t start = {sample_vector(5), sample_attitude()};
        const double s = sample_between(0, 6);
        // Many small steps, each a straight shift by the middle attitude and a small turn.
        pose_t X = start;
        const int steps = 20000;
        for (int k = 0; k < steps; k++) {
            const quat_t half = quat_from_axis_angle(twist.w, s / steps / 2);
            const quat_t middle = quat_mul(X.q, half);
            X.p = vec3_add(X.p, quat_apply(middle, vec3_scale(s / steps, twist.v)));
            X.q = quat_unit(quat_mul(middle, half));
        }
        TEST_ASSERT_DOUBLE_WITHIN(
            1e-6, 0, pose_distance(X, ssv_maneuver_pose(start, twist, s))); // steps^-2 of the midpoint rule
    }
}

static void test_turn_leaves_its_pivot_where_it_is(void) {
    sample_seed(22);
    for (int trial = 0; trial < 50; trial++) {
        const vec3_t pivot = sample_vector(3);
        const ssv_maneuver_t turn = ssv_maneuver_turn(SSV_TRANSFER, sample_direction(), sample_between(0, 3), pivot);
        const pose_t start = {sample_vector(5), sample_attitude()};
        const pose_t pivot_S = {pivot, quat_identity()};
        const pose_t end = ssv_maneuver_pose(start, turn.twist, turn.length);
        const vec3_t moved = vec3_sub(pose_mul(end, pivot_S).p, pose_mul(start, pivot_S).p);
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0, vec3_norm(moved));
    }
}

static void test_translation_keeps_the_attitude_and_covers_its_displacement(void) {
    const pose_t start = {{1, 2, 3}, {0.5, 0.5, 0.5, 0.5}};
    const ssv_maneuver_t maneuver = ssv_maneuver_translate(SSV_TRANSIT, vec3(3, 0, 4));
    const pose_t end = ssv_maneuver_pose(start, maneuver.twist, maneuver.length);
    const pose_t expected = {vec3_add(start.p, quat_apply(start.q, vec3(3, 0, 4))), start.q};
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 5, maneuver.length);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0, pose_distance(expected, end));
}

static ssv_ramp_t ramp_for(double weight_time, double weight_impulse, ssv_price_t* price) {
    static ssv_problem_t problem;
    static ssv_profile_t profile;
    ssv_scenario_t s = scenario_case_study(false);
    ssv_fault_t fault;
    ssv_ramp_t ramp;
    ssv_thrusts_t thrusts;
    s.weight_time_per_s = weight_time;
    s.weight_impulse_per_Ns = weight_impulse;
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &s, &fault));
    const ssv_question_t question = ssv_question_of(&problem);
    const ssv_assembly_t alone = {&problem.scenario.vehicle, NULL, {{0, 0, 0}, {1, 0, 0, 0}}};
    const ssv_maneuver_t turn = ssv_maneuver_turn(SSV_TRANSIT, vec3(0, 0, 1), 1.5, vec3(0, 0, 0));
    ssv_maneuver_thrusts(&problem, &alone, turn.twist, &thrusts);
    *price = ssv_maneuver_solve(&question, &turn, &thrusts, &profile, &ramp);
    TEST_ASSERT_EQUAL_INT(SSV_FEASIBLE, price->outcome);
    return ramp;
}

static void test_weights_decide_the_ramp(void) {
    ssv_price_t fast, thrifty;
    TEST_ASSERT_EQUAL_INT(SSV_FULL_REVERSE, ramp_for(1, 0, &fast));
    TEST_ASSERT_EQUAL_INT(SSV_DRAG_ONLY, ramp_for(0, 1, &thrifty));
    TEST_ASSERT_TRUE(fast.time_s < thrifty.time_s && fast.impulse_Ns > thrifty.impulse_Ns);
    TEST_ASSERT_EQUAL_DOUBLE(fast.time_s, fast.cost);
    TEST_ASSERT_EQUAL_DOUBLE(thrifty.impulse_Ns, thrifty.cost);
}

static void test_move_of_no_length_costs_nothing(void) {
    static ssv_profile_t profile;
    static ssv_problem_t problem;
    const ssv_scenario_t s = scenario_case_study(false);
    ssv_fault_t fault;
    ssv_ramp_t ramp;
    const ssv_thrusts_t thrusts = {{1}, {0}, {0}, 6};
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &s, &fault));
    const ssv_question_t question = ssv_question_of(&problem);
    const ssv_maneuver_t nowhere = ssv_maneuver_translate(SSV_TRANSIT, vec3(1e-10, 0, 0));
    const ssv_price_t price = ssv_maneuver_solve(&question, &nowhere, &thrusts, &profile, &ramp);
    TEST_ASSERT_EQUAL_INT(SSV_FEASIBLE, price.outcome);
    TEST_ASSERT_EQUAL_DOUBLE(0, nowhere.length);
    TEST_ASSERT_EQUAL_DOUBLE(0, price.time_s + price.impulse_Ns + price.cost);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_pose_along_any_twist_solves_the_kinematic_equations);
    RUN_TEST(test_turn_leaves_its_pivot_where_it_is);
    RUN_TEST(test_translation_keeps_the_attitude_and_covers_its_displacement);
    RUN_TEST(test_weights_decide_the_ramp);
    RUN_TEST(test_move_of_no_length_costs_nothing);
    return UNITY_END();
}
