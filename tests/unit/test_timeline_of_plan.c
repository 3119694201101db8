// The timeline that the vehicle flies against the plan that it was made of, in every scalar.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sample.h"
#include "unity.h"

#define SEED 20261128u
#define NUM_PLANS 200
#define NS 1e-9L

static ssv_problem_t problem;
static ssv_work_t work;
static ssv_plan_t plan;
static ssv_timeline_t timeline;

void setUp(void) {
    memset(&plan, 0, sizeof plan);
    memset(&timeline, 0xff, sizeof timeline);
}
void tearDown(void) {}

static long double exact(real_t a) { return (long double)real_to_double(a); }

// Rounded by the compiler, which does it correctly; no thrust of a plan has more digits than a double.
static void check_thrust(real_t planned_N, float flown_N) {
    const float nearest_N = (float)real_to_double(planned_N);
    TEST_ASSERT_TRUE(nearest_N == flown_N);
    TEST_ASSERT_TRUE(fabsf(flown_N) <= timeline.u_max_N);
}

// Walks both side by side. Of the plan's segments the flown one is that which begins at the same nanosecond; float has
// times so close that some plan's segment is left out.
static void check_segments(void) {
    const int64_t end_ns = (int64_t)llrintl(exact(plan.quote.time_s) / NS);
    int64_t t_ns = 0;
    int k = 0;
    bool is_flown[SSV_MAX_SEGMENTS] = {false};
    for (int n = 0; n < timeline.num_segments; n++) {
        const ssv_timeline_segment_t* flown = &timeline.segment[n];
        TEST_ASSERT_TRUE(flown->duration_ns > 0);
        // The last of those that begin here: what lasts nothing stands before it.
        while (k + 1 < plan.num_segments && exact(plan.segment[k + 1].t_s) / NS <= (long double)t_ns + 0.5L) k++;
        // Half a nanosecond, and the error of the product in double: 2e13 ns have 45 bits.
        TEST_ASSERT_TRUE(fabsl(exact(plan.segment[k].t_s) / NS - (long double)t_ns) <= 0.51L);
        is_flown[k] = true;
        for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
            check_thrust(plan.segment[k].u_start_N[i], flown->u_start_N[i]);
            check_thrust(plan.segment[k].u_end_N[i], flown->u_end_N[i]);
        }
        for (int e = 0; e < timeline.num_events; e++) {
            if (timeline.event[e].kind != SSV_MATE) continue;
            const bool mated = timeline.event[e].segment <= n;
            TEST_ASSERT_EQUAL_INT(mated ? SSV_TRANSFER : SSV_TRANSIT, plan.leg[plan.segment[k].leg].phase);
            if (timeline.event[e].segment == n) {
                TEST_ASSERT_TRUE(fabsl(exact(plan.event[e].t_s) / NS - (long double)t_ns) <= 1);
            }
        }
        t_ns += flown->duration_ns;
    }
    TEST_ASSERT_TRUE(llabs(t_ns - end_ns) <= 1);
    // What is left out lasts less than a nanosecond or the last digit of the plan's times.
    const long double shortest_s = NS + exact(REAL_EPSILON) * exact(plan.quote.time_s);
    for (k = 0; k < plan.num_segments; k++) {
        TEST_ASSERT_TRUE(is_flown[k] || exact(plan.segment[k].duration_s) <= shortest_s);
    }
}

static void test_flown_timelines_of_random_plans_keep_their_times_thrusts_events_and_start(void) {
    sample_seed(SEED);
    int num_flown = 0, num_left_out = 0;
    while (num_flown < NUM_PLANS) {
        ssv_scenario_t scenario = sample_scenario();
        if (num_flown % 2 == 0) scenario.method = SSV_METHOD_OPTIMAL;
        ssv_fault_t fault;
        TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &scenario, &fault));
        if (ssv_plan(&problem, &work, &plan) != SSV_OK) continue;
        ssv_timeline_of_plan(&plan, &timeline);
        TEST_ASSERT_EQUAL_UINT64(plan.plan_hash, timeline.plan_hash);
        TEST_ASSERT_EQUAL_UINT32(0, timeline.mass_configuration);
        TEST_ASSERT_TRUE(timeline.u_max_N > 0 &&
                         timeline.u_max_N <= (float)real_to_double(scenario.vehicle.force_max_N));
        TEST_ASSERT_TRUE(timeline.p_IS_m[1] == (float)real_to_double(scenario.X_IS.p.y));
        // ssv_problem_init has made it a unit quaternion once more.
        TEST_ASSERT_FLOAT_WITHIN(1e-6f, (float)real_to_double(scenario.X_IS.q.w), timeline.q_IS[0]);
        TEST_ASSERT_FLOAT_WITHIN(1e-6f, (float)real_to_double(scenario.X_IS.q.z), timeline.q_IS[3]);
        TEST_ASSERT_EQUAL_INT(plan.num_events, timeline.num_events);
        TEST_ASSERT_EQUAL_INT(SSV_MATE, timeline.event[0].kind);
        TEST_ASSERT_EQUAL_INT(SSV_DOCK, timeline.event[1].kind);
        TEST_ASSERT_EQUAL_INT(timeline.num_segments, timeline.event[1].segment);
        check_segments();
        num_left_out += plan.num_segments - timeline.num_segments;
        num_flown++;
    }
    printf("%s, seed %u: %d segments of %d plans left out\n", REAL_NAME, SEED, num_left_out, num_flown);
    if (strcmp(REAL_NAME, "float") != 0) TEST_ASSERT_EQUAL_INT(0, num_left_out);
}

// A plan of segments with these starts, in turn of the vehicle alone and, from `mate` on, with the beam.
static void plan_of(const double* start_s, int num, double end_s, int mate) {
    memset(&plan, 0, sizeof plan);
    plan.num_legs = 2;
    plan.leg[0].phase = SSV_TRANSIT;
    plan.leg[1].phase = SSV_TRANSFER;
    plan.num_segments = num;
    for (int k = 0; k < num; k++) {
        plan.segment[k].t_s = real_from_double(start_s[k]);
        plan.segment[k].u_start_N[0] = real_from_int(k);
        plan.segment[k].u_end_N[5] = real_from_int(-k);
        plan.segment[k].leg = k < mate ? 0 : 1;
    }
    plan.quote.time_s = real_from_double(end_s);
    plan.num_events = 2;
    plan.event[0].kind = SSV_MATE;
    plan.event[1].kind = SSV_DOCK;
}

static void test_what_lasts_nothing_is_left_out_and_events_stay_where_they_are(void) {
    plan_of((double[]){0, 2, 2, 3}, 4, 5, 2);
    ssv_timeline_of_plan(&plan, &timeline);
    TEST_ASSERT_EQUAL_INT(3, timeline.num_segments);
    TEST_ASSERT_EQUAL_INT64(2000000000, timeline.segment[0].duration_ns);
    TEST_ASSERT_EQUAL_INT64(1000000000, timeline.segment[1].duration_ns);
    TEST_ASSERT_EQUAL_INT64(2000000000, timeline.segment[2].duration_ns);
    TEST_ASSERT_EQUAL_FLOAT(2, timeline.segment[1].u_start_N[0]); // the second of the two that begin at 2 s
    TEST_ASSERT_EQUAL_FLOAT(-3, timeline.segment[2].u_end_N[5]);
    TEST_ASSERT_EQUAL_FLOAT(3, timeline.u_max_N);
    TEST_ASSERT_EQUAL_INT(1, timeline.event[0].segment);
    TEST_ASSERT_EQUAL_INT(3, timeline.event[1].segment);
}

static void test_a_start_behind_the_end_or_before_the_last_one_makes_no_time_run_back(void) {
    plan_of((double[]){0, 2, 1.5, 6}, 4, 5, 3);
    ssv_timeline_of_plan(&plan, &timeline);
    int64_t t_ns = 0;
    for (int n = 0; n < timeline.num_segments; n++) {
        TEST_ASSERT_TRUE(timeline.segment[n].duration_ns > 0);
        t_ns += timeline.segment[n].duration_ns;
    }
    TEST_ASSERT_EQUAL_INT64(5000000000, t_ns);
    TEST_ASSERT_EQUAL_INT(timeline.num_segments, timeline.event[0].segment);
}

static void test_the_vehicle_mates_at_once_or_at_the_end_where_one_phase_has_no_motion(void) {
    plan_of((double[]){0, 1}, 2, 2, 0);
    ssv_timeline_of_plan(&plan, &timeline);
    TEST_ASSERT_EQUAL_INT(0, timeline.event[0].segment);
    TEST_ASSERT_EQUAL_INT(2, timeline.event[1].segment);
    plan_of((double[]){0, 1}, 2, 2, 2);
    ssv_timeline_of_plan(&plan, &timeline);
    TEST_ASSERT_EQUAL_INT(2, timeline.event[0].segment);
    TEST_ASSERT_EQUAL_INT(SSV_MATE, timeline.event[0].kind);
    TEST_ASSERT_EQUAL_INT(2, timeline.event[1].segment);
}

static void test_a_plan_without_motion_is_a_timeline_of_events_alone(void) {
    plan_of(NULL, 0, 0, 0);
    plan.num_legs = 0;
    plan.quote.X_IS_final.p.z = REAL(7);
    ssv_timeline_of_plan(&plan, &timeline);
    TEST_ASSERT_EQUAL_INT(0, timeline.num_segments);
    TEST_ASSERT_EQUAL_INT(2, timeline.num_events);
    TEST_ASSERT_EQUAL_INT(0, timeline.event[1].segment);
    TEST_ASSERT_EQUAL_FLOAT(0, timeline.u_max_N);
    TEST_ASSERT_EQUAL_FLOAT(7, timeline.p_IS_m[2]);
}

static void test_two_timelines_take_no_more_than_the_vehicle_has_for_them(void) {
    TEST_ASSERT_EQUAL_INT(56, sizeof(ssv_timeline_segment_t));
    TEST_ASSERT_TRUE(2 * sizeof(ssv_timeline_t) <= 14600);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_flown_timelines_of_random_plans_keep_their_times_thrusts_events_and_start);
    RUN_TEST(test_what_lasts_nothing_is_left_out_and_events_stay_where_they_are);
    RUN_TEST(test_a_start_behind_the_end_or_before_the_last_one_makes_no_time_run_back);
    RUN_TEST(test_the_vehicle_mates_at_once_or_at_the_end_where_one_phase_has_no_motion);
    RUN_TEST(test_a_plan_without_motion_is_a_timeline_of_events_alone);
    RUN_TEST(test_two_timelines_take_no_more_than_the_vehicle_has_for_them);
    return UNITY_END();
}
