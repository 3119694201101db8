// Where the vehicle may take hold, and the turns that bring one direction onto another.
#include "planner/model/grasp.h"
#include "sample.h"
#include "unity.h"

static double ring[SSV_NUM_RING_ANGLES];
static vec3_t axis[SSV_NUM_TURN_AXES];

void setUp(void) {}
void tearDown(void) {}

static void assert_vec3(double tolerance, vec3_t expected, vec3_t actual) {
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, 0, vec3_norm(vec3_sub(expected, actual)));
}

static void test_nearest_ring_angle_is_the_side_of_the_vehicle(void) {
    sample_seed(5);
    for (int trial = 0; trial < 100; trial++) {
        ssv_scenario_t s = sample_scenario();
        s.ring_angle_given = false;
        TEST_ASSERT_EQUAL_INT(1, ssv_grasp_ring_angles(&s, ring));
        // No other angle at the same height brings the vehicle closer.
        ssv_grasp_t grasp = {1, 0.5, ring[0]};
        const double nearest = vec3_norm(vec3_sub(ssv_grasp_position(&s, &grasp), s.X_IS.p));
        for (int k = 0; k < 36; k++) {
            grasp.ring_angle_rad = ring[0] + 2 * REAL_PI * k / 36;
            TEST_ASSERT_TRUE(vec3_norm(vec3_sub(ssv_grasp_position(&s, &grasp), s.X_IS.p)) >= nearest - 1e-12);
        }
    }
}

static void test_given_ring_angle_is_the_only_one(void) {
    ssv_scenario_t s = scenario_case_study(false);
    s.ring_angle_given = true;
    s.ring_angle_rad = -1.25;
    TEST_ASSERT_EQUAL_INT(1, ssv_grasp_ring_angles(&s, ring));
    TEST_ASSERT_EQUAL_DOUBLE(-1.25, ring[0]);
}

static void test_vehicle_on_the_beams_axis_has_sixteen_ring_angles_all_round(void) {
    const ssv_scenario_t s = scenario_case_study(false);
    TEST_ASSERT_EQUAL_INT(SSV_NUM_RING_ANGLES, ssv_grasp_ring_angles(&s, ring));
    for (int k = 0; k < SSV_NUM_RING_ANGLES; k++) {
        TEST_ASSERT_TRUE(ring[k] > -REAL_PI && ring[k] <= REAL_PI + 1e-12);
        if (k > 0) TEST_ASSERT_DOUBLE_WITHIN(1e-12, 2 * REAL_PI / 16, ring[k] - ring[k - 1]);
    }
}

static void test_case_study_mates_where_table_5_says(void) {
    const ssv_scenario_t s = scenario_case_study(false);
    static const double height[] = {1.524, 0, -1.524}, x[] = {6.524, 5, 3.476};
    for (int k = 0; k < 3; k++) {
        const ssv_grasp_t grasp = {1, height[k], -REAL_PI / 2};
        assert_vec3(1e-12, vec3(x[k], -0.3025, 0), ssv_grasp_position(&s, &grasp));
        assert_vec3(1e-12, vec3(0, -1, 0), ssv_grasp_radial(&s, &grasp));
    }
    assert_vec3(1e-12, vec3(0, 0, -1.524), ssv_grasp_contact(&s, 1));
    assert_vec3(1e-12, vec3(0, 0, 1.524), ssv_grasp_contact(&s, 2));
}

static void test_turn_takes_one_direction_onto_the_other_by_the_angle_between_them(void) {
    sample_seed(6);
    for (int trial = 0; trial < 1000; trial++) {
        const vec3_t from = sample_direction(), to = sample_direction();
        double angle;
        TEST_ASSERT_EQUAL_INT(1, ssv_grasp_turn_axes(from, to, axis, &angle));
        assert_vec3(1e-12, to, quat_apply(quat_from_axis_angle(axis[0], angle), from));
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, acos(fmax(-1, fmin(1, vec3_dot(from, to)))),
                                  angle); // acos is soft near 0 and pi
    }
}

static void test_turn_between_equal_directions_is_no_turn(void) {
    const vec3_t d = vec3(0.6, 0, 0.8);
    double angle;
    TEST_ASSERT_EQUAL_INT(1, ssv_grasp_turn_axes(d, d, axis, &angle));
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 0, angle);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1, vec3_norm(axis[0]));
}

static void test_half_turn_has_sixteen_axes_and_each_of_them_reaches_the_goal(void) {
    const vec3_t from = vec3(0.6, 0, 0.8);
    double angle;
    TEST_ASSERT_EQUAL_INT(SSV_NUM_TURN_AXES, ssv_grasp_turn_axes(from, vec3_neg(from), axis, &angle));
    for (int k = 0; k < SSV_NUM_TURN_AXES; k++) {
        assert_vec3(1e-12, vec3_neg(from), quat_apply(quat_from_axis_angle(axis[k], angle), from));
        if (k > 0) TEST_ASSERT_DOUBLE_WITHIN(1e-12, cos(2 * REAL_PI / 16), vec3_dot(axis[k], axis[k - 1]));
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_nearest_ring_angle_is_the_side_of_the_vehicle);
    RUN_TEST(test_given_ring_angle_is_the_only_one);
    RUN_TEST(test_vehicle_on_the_beams_axis_has_sixteen_ring_angles_all_round);
    RUN_TEST(test_case_study_mates_where_table_5_says);
    RUN_TEST(test_turn_takes_one_direction_onto_the_other_by_the_angle_between_them);
    RUN_TEST(test_turn_between_equal_directions_is_no_turn);
    RUN_TEST(test_half_turn_has_sixteen_axes_and_each_of_them_reaches_the_goal);
    return UNITY_END();
}
