// The timeline against the exact thrusts of random profiles.
#include <stdlib.h>

#include "planner/profile/profile.h"
#include "planner/segments.h"
#include "sample.h"
#include "unity.h"

#define N SSV_NUM_THRUSTERS

static ssv_plan_t plan;
static ssv_profile_t profile;

void setUp(void) {}
void tearDown(void) {}

static ssv_thrusts_t random_thrusts(void) {
    ssv_thrusts_t t;
    for (int i = 0; i < N; i++) {
        t.accel[i] = sample_between(-60, 60);
        t.linear[i] = sample_between(-0.5, 3) * t.accel[i] + sample_between(-20, 20);
        t.quadratic[i] = sample_between(0, 20) * t.accel[i] + sample_between(-100, 100);
    }
    t.force_max_N = 6;
    return t;
}

static double exact_thrust(const ssv_thrusts_t* thrusts, const ssv_arc_t* arc, int i, double t) {
    const double v = ssv_arc_speed(arc, fmin(fmax(t, 0), arc->duration_s));
    const double a = arc->dv_dt[0] + v * (arc->dv_dt[1] + v * arc->dv_dt[2]);
    return thrusts->accel[i] * a + thrusts->linear[i] * v + thrusts->quadratic[i] * v * v;
}

static void test_timeline_of_random_legs_is_close_exact_in_impulse_contiguous_and_within_limits(void) {
    sample_seed(31);
    for (int trial = 0; trial < 300; trial++) {
        const ssv_thrusts_t thrusts = random_thrusts();
        const ssv_ramp_t ramp = trial % 2 == 0 ? SSV_FULL_REVERSE : SSV_DRAG_ONLY;
        const double distance = pow(10, sample_between(-2, 1.5));
        if (ssv_profile_solve(&thrusts, &(ssv_rule_t){ramp, 0.01, 0, 0, 0}, distance, &profile) != SSV_FEASIBLE)
            continue;
        for (int k = 0; k < profile.num_arcs; k++) {
            const ssv_arc_t* arc = &profile.arc[k];
            plan.num_segments = 0;
            TEST_ASSERT_EQUAL_INT(SSV_FEASIBLE, ssv_timeline_append(&thrusts, arc, 100, 3, 1e-4, &plan));
            double t = 100;
            for (int g = 0; g < plan.num_segments; g++) {
                const ssv_segment_t* segment = &plan.segment[g];
                TEST_ASSERT_DOUBLE_WITHIN(1e-9, t, segment->t_s);
                TEST_ASSERT_EQUAL_INT(3, segment->leg);
                for (int i = 0; i < N; i++) {
                    const double rise = segment->u_end_N[i] - segment->u_start_N[i];
                    double impulse = 0;
                    const int steps = 400; // Simpson
                    for (int n = 0; n <= steps; n++) {
                        const double along = (double)n / steps, at = segment->t_s - 100 + along * segment->duration_s;
                        const double exact = exact_thrust(&thrusts, arc, i, at);
                        TEST_ASSERT_DOUBLE_WITHIN(0.005 * 6, exact, segment->u_start_N[i] + along * rise);
                        impulse += (n == 0 || n == steps ? 1
                                    : n % 2 == 1         ? 4
                                                         : 2) *
                                   exact * segment->duration_s / (3 * steps);
                    }
                    TEST_ASSERT_TRUE(fabs(segment->u_start_N[i]) <= 6 && fabs(segment->u_end_N[i]) <= 6);
                    // Simpson's error on a stretch of the last seconds of a ramp, relative to the leg's whole impulse.
                    TEST_ASSERT_DOUBLE_WITHIN(1e-7 * (1 + profile.impulse_Ns), impulse,
                                              (segment->u_start_N[i] + segment->u_end_N[i]) / 2 * segment->duration_s);
                }
                t += segment->duration_s;
            }
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, 100 + arc->duration_s, t);
        }
    }
}

static void test_count_of_segments_is_close_to_what_is_cut(void) {
    sample_seed(32);
    for (int trial = 0; trial < 300; trial++) {
        const ssv_thrusts_t thrusts = random_thrusts();
        const ssv_rule_t rule = {SSV_OPTIMAL, 0, 1, trial % 2 == 0 ? 0 : 1, 0};
        const double distance = pow(10, sample_between(-2, 1.5)), drift_s2 = pow(10, sample_between(-6, -3));
        if (ssv_profile_solve(&thrusts, &rule, distance, &profile) != SSV_FEASIBLE) continue;
        int counted = 0;
        plan.num_segments = 0;
        for (int k = 0; k < profile.num_arcs; k++) {
            counted += ssv_timeline_count(&thrusts, &profile.arc[k], drift_s2);
            TEST_ASSERT_EQUAL_INT(SSV_FEASIBLE, ssv_timeline_append(&thrusts, &profile.arc[k], 0, 0, drift_s2, &plan));
        }
        TEST_ASSERT_TRUE(abs(counted - plan.num_segments) <= 1 + counted / 20);
    }
}

static void test_constant_thrust_is_one_segment(void) {
    const ssv_thrusts_t thrusts = {{38.1, -38.1}, {206.8425, -206.8425}, {0}, 6};
    TEST_ASSERT_EQUAL_INT(SSV_FEASIBLE,
                          ssv_profile_solve(&thrusts, &(ssv_rule_t){SSV_FULL_REVERSE, 0.001, 0, 0, 0}, 2, &profile));
    plan.num_segments = 0;
    TEST_ASSERT_EQUAL_INT(SSV_FEASIBLE, ssv_timeline_append(&thrusts, &profile.arc[0], 0, 0, 1e-4, &plan));
    TEST_ASSERT_EQUAL_INT(1, plan.num_segments);
    TEST_ASSERT_EQUAL_INT(1, ssv_timeline_count(&thrusts, &profile.arc[0], 1e-4));
}

static void test_full_timeline_refuses_more(void) {
    const ssv_thrusts_t thrusts = {{38.1, -38.1}, {206.8425, -206.8425}, {0}, 6};
    TEST_ASSERT_EQUAL_INT(SSV_FEASIBLE,
                          ssv_profile_solve(&thrusts, &(ssv_rule_t){SSV_FULL_REVERSE, 0.001, 0, 0, 0}, 2, &profile));
    plan.num_segments = SSV_MAX_SEGMENTS;
    TEST_ASSERT_EQUAL_INT(SSV_TOO_MANY_SEGMENTS, ssv_timeline_append(&thrusts, &profile.arc[0], 0, 0, 1e-4, &plan));
    TEST_ASSERT_EQUAL_INT(SSV_MAX_SEGMENTS, plan.num_segments);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_timeline_of_random_legs_is_close_exact_in_impulse_contiguous_and_within_limits);
    RUN_TEST(test_count_of_segments_is_close_to_what_is_cut);
    RUN_TEST(test_constant_thrust_is_one_segment);
    RUN_TEST(test_full_timeline_refuses_more);
    return UNITY_END();
}
