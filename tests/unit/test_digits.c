// Vectors, poses, arcs, profiles and timelines in every scalar: what is short, slow or nearly equal keeps its digits,
// too.
#include <math.h>
#include <string.h>

#include "planner/motion/maneuver.h"
#include "planner/profile/arc.h"
#include "planner/profile/profile.h"
#include "planner/profile/ramp.h"
#include "planner/segments.h"
#include "sample.h"
#include "unity.h"

#define NUM_SIZES 9 // 1 down to 1e-8
#define NUM_OF_EACH 2000
#define FLIGHT_M 11.0L

void setUp(void) { sample_seed(20261122); }
void tearDown(void) {}

static long double size_of(vec3_t a) {
    return sqrtl(powl(real_to_double(a.x), 2) + powl(real_to_double(a.y), 2) + powl(real_to_double(a.z), 2));
}

static vec3_t shorter(vec3_t a, int size) { return vec3_scale(real_from_double(pow(10, -size)), a); }

static void test_the_length_of_a_vector_is_as_good_as_its_components(void) {
    for (int n = 0; n < NUM_SIZES * NUM_OF_EACH; n++) {
        const vec3_t a = shorter(sample_vector(1), n % NUM_SIZES);
        const long double expected = size_of(a);
        // Rounded are three squares, half a digit each, and the root, which makes 1 / (2 * 0.29) of their error: 0.29
        // is the shortest that is not scaled. In fixed point that counts in last digits, else in parts of the length.
        const long double rounding = 3.1L * (long double)real_to_double(REAL_EPSILON);
        const long double allowed = strcmp(REAL_NAME, "fixed") == 0 ? rounding : rounding * expected;
        TEST_ASSERT_TRUE(fabsl((long double)real_to_double(vec3_norm(a)) - expected) <= allowed);
    }
}

static void test_a_flight_turns_as_far_as_its_twist_says_however_little_that_is(void) {
    const vec3_t zero = vec3(REAL(0), REAL(0), REAL(0));
    for (int n = 0; n < NUM_SIZES * NUM_OF_EACH; n++) {
        const ssv_twist_t twist = {vec3(REAL(1), REAL(0), REAL(0)), shorter(sample_vector(0.1), n % NUM_SIZES)};
        const pose_t X = ssv_maneuver_pose((pose_t){zero, quat_identity()}, twist, REAL(FLIGHT_M));
        const long double turned = 2 * asinl(fminl(1, size_of(vec3(X.q.x, X.q.y, X.q.z))));
        // A part in a million of the turn, or what the last digits of twist and attitude amount to.
        const long double expected = FLIGHT_M * size_of(twist.w), allowed = 1e-6L * expected + 5e-9L;
        TEST_ASSERT_DOUBLE_WITHIN((double)allowed, (double)expected, (double)turned);
    }
}

// Without a constant thrust, the distance between two speeds is log((b + c v_to) / (b + c v_from)) / c.
static void test_a_slow_coast_is_as_long_as_its_drag_says(void) {
    const double b = -16.3, c = 300;
    const real_t dv_dt[3] = {REAL(0), real_from_double(b), real_from_double(c)};
    for (int n = 0; n < NUM_OF_EACH; n++) {
        const double fast = pow(10, sample_between(-5, -2)), slow = fast * sample_between(0.2, 0.6);
        const ssv_moments_t m = ssv_moments_between(dv_dt, real_from_double(fast), real_from_double(slow));
        const long double expected =
            log1pl((long double)(c * (slow - fast)) / (long double)(b + c * fast)) / (long double)c;
        // A part in ten thousand for the speeds' digits in fixed point, and its last digit.
        TEST_ASSERT_DOUBLE_WITHIN((double)(1e-4L * expected + 1e-9L), (double)expected, real_to_double(m.distance));
    }
}

// How far beyond its limit the leg's profile drives any thruster, at most, where an arc starts, ends, and in between.
static double beyond_the_limit_N(const ssv_thrusts_t* thrusts, const ssv_profile_t* profile) {
    double most = 0;
    for (int k = 0; k < profile->num_arcs; k++) {
        const ssv_arc_t* arc = &profile->arc[k];
        for (int n = 0; n <= 4; n++) {
            const double v = real_to_double(arc->v_start) + n / 4.0 * real_to_double(arc->v_end - arc->v_start);
            double dv_dt[3];
            for (int m = 0; m < 3; m++) dv_dt[m] = real_to_double(arc->dv_dt[m]);
            const double a = dv_dt[0] + v * (dv_dt[1] + v * dv_dt[2]);
            for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
                const double u = real_to_double(thrusts->accel[i]) * a + real_to_double(thrusts->linear[i]) * v +
                                 real_to_double(thrusts->quadratic[i]) * v * v;
                most = fmax(most, fabs(u) - real_to_double(thrusts->force_max_N));
            }
        }
    }
    return most;
}

// Two thrusters that mirror each other but for some parts in 100,000, and a third that is at its limit up to where they
// are.
static void test_no_thruster_is_driven_beyond_its_limit_where_two_nearly_mirror_each_other(void) {
    static const ssv_ramp_t ramp[] = {SSV_OPTIMAL, SSV_FULL_REVERSE, SSV_DRAG_ONLY};
    for (int n = 0; n < 3 * NUM_OF_EACH; n++) {
        const ssv_rule_t rule = {ramp[n % 3], REAL(0.01), REAL(1), REAL(0.1), REAL(0)};
        const double twin = 1 + sample_between(-5e-5, 5e-5), third = sample_between(15, 30);
        const ssv_thrusts_t thrusts = {
            .accel = {REAL(2.76), real_from_double(-2.76 * twin), real_from_double(-third)},
            .linear = {REAL(38.1), real_from_double(-38.1 * (1 + sample_between(-1e-6, 1e-6)))},
            .quadratic = {REAL(-1.72), REAL(1.72), real_from_double(sample_between(-10, -1))},
            .force_max_N = REAL(6)};
        ssv_profile_t profile;
        const ssv_outcome_t outcome =
            ssv_profile_solve(&thrusts, &rule, real_from_double(sample_between(0.5, 5)), &profile);
        // Where the least thrust does not slow it, the vehicle does not drift.
        TEST_ASSERT_TRUE(outcome == SSV_FEASIBLE || (rule.ramp == SSV_DRAG_ONLY && outcome == SSV_NO_AUTHORITY));
        if (outcome != SSV_FEASIBLE) continue;
        // A fiftieth of what the timeline may be off.
        TEST_ASSERT_DOUBLE_WITHIN(6e-4, 0, beyond_the_limit_N(&thrusts, &profile));
    }
}

// What a second and the thrusts that hold a speed cost, per unit of distance.
static double cost_of_cruise(const ssv_thrusts_t* thrusts, const ssv_rule_t* rule, double v) {
    double hold = 0;
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        hold += fabs(real_to_double(thrusts->linear[i]) * v + real_to_double(thrusts->quadratic[i]) * v * v);
    }
    return (real_to_double(rule->weight_time_per_s) + real_to_double(rule->weight_impulse_per_Ns) * hold) / v;
}

// Two thrusters that hardly act along the leg idle, one after the other, within moments of its end.
static void test_a_long_leg_cruises_at_the_cheapest_speed_past_thrusters_that_hardly_act(void) {
    const ssv_rule_t rule = {SSV_OPTIMAL, REAL(0), REAL(0.01), REAL(1), REAL(0)};
    ssv_thrusts_t thrusts = {.accel = {REAL(-43.7846298), REAL(43.7789567), REAL(-23.1589955), REAL(-23.1377917),
                                       REAL(0.0103), REAL(-0.0334128)},
                             .linear = {REAL(-206.842468), REAL(206.842468), REAL(-0.0500875), REAL(0.0500875),
                                        REAL(0.103262), REAL(-0.103262)},
                             .quadratic = {REAL(-101.640538), REAL(101.539105), REAL(-413.865633), REAL(-413.865633),
                                           REAL(-0.155897), REAL(-0.25733)},
                             .force_max_N = REAL(6)};
    for (int n = 0; n < NUM_OF_EACH; n++) {
        thrusts.accel[4] = real_from_double(sample_between(0.008, 0.012));
        ssv_profile_t profile;
        TEST_ASSERT_EQUAL(SSV_FEASIBLE,
                          ssv_profile_solve(&thrusts, &rule, real_from_double(sample_between(10, 16)), &profile));
        const double v = real_to_double(profile.peak_speed), cost = cost_of_cruise(&thrusts, &rule, v);
        // Cheaper than at a thousandth more or less, which costs half a millionth: fixed point tells a part in 100
        // million.
        TEST_ASSERT_TRUE(cost < cost_of_cruise(&thrusts, &rule, 1.001 * v));
        TEST_ASSERT_TRUE(cost < cost_of_cruise(&thrusts, &rule, 0.999 * v));
    }
}

// Two thrusters would idle at the same speed to within some parts in 100,000, one of them for a moment only.
static void test_the_price_of_a_leg_does_not_hang_on_the_last_digits_of_its_thrusts(void) {
    static const double accel[] = {-15.509768, 8.443433, 13.243758, -13.279738, -10.61421, 20.134464};
    static const double linear[] = {-1.2808765, 1.2808758, 0.6173246, -0.6173246, -0.4380399, 0.438039};
    static const double quadratic[] = {-0.7764264, 9.2256544, -6.3141825, 11.5830305, -3.5490549, 9.8403398};
    const ssv_rule_t rule = {SSV_OPTIMAL, REAL(0), REAL(0.01), REAL(1), REAL(0)};
    double least = INFINITY, most = 0;
    for (int n = 0; n < NUM_OF_EACH; n++) {
        ssv_thrusts_t thrusts = {.force_max_N = REAL(6)};
        for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
            thrusts.accel[i] = real_from_double(accel[i] * (1 + sample_between(-1e-6, 1e-6)));
            thrusts.linear[i] = real_from_double(linear[i] * (1 + sample_between(-1e-6, 1e-6)));
            thrusts.quadratic[i] = real_from_double(quadratic[i] * (1 + sample_between(-1e-6, 1e-6)));
        }
        const ssv_profile_price_t price = ssv_profile_price(&thrusts, &rule, REAL(2.7274));
        TEST_ASSERT_EQUAL(SSV_FEASIBLE, price.outcome);
        const double cost = 0.01 * real_to_double(price.duration_s) + real_to_double(price.impulse_Ns);
        least = fmin(least, cost);
        most = fmax(most, cost);
    }
    // A hundred times as much as the digits.
    TEST_ASSERT_DOUBLE_WITHIN(1e-4 * least, least, most);
}

// The paper's ramps bind thrusters that hardly act, too: another then gives way within a fraction of a millisecond.
static void test_an_arc_whose_thrusts_bend_within_a_fraction_of_a_millisecond_has_a_timeline(void) {
    const ssv_thrusts_t thrusts = {
        .accel = {REAL(-8.67), REAL(6.6), REAL(0.0011426)}, .linear = {REAL(10), REAL(-2)}, .force_max_N = REAL(6)};
    const real_t drift_max_s2 = REAL(1e-5);
    static ssv_plan_t plan;
    for (int n = 0; n < NUM_OF_EACH; n++) {
        const double slope = -sample_between(8000, 12000), v = sample_between(0.2, 0.5),
                     pull = sample_between(0.05, 0.3);
        ssv_arc_t arc = {.dv_dt = {real_from_double(pull - slope * v), real_from_double(slope)},
                         .v_start = real_from_double(v),
                         .duration_s = real_from_double(sample_between(1, 2) / -slope)};
        arc.v_end = ssv_speed_after(arc.dv_dt, arc.v_start, arc.duration_s);
        const uint32_t overflows = real_overflows();
        plan.num_segments = 0;
        TEST_ASSERT_EQUAL(SSV_FEASIBLE, ssv_timeline_append(&thrusts, &arc, REAL(0), 0, drift_max_s2, &plan));
        TEST_ASSERT_EQUAL(overflows, real_overflows());
    }
}

// A leg of one thruster that is asked to cruise so slowly that fixed point rounds its speed to nothing, and the same at
// the paper's rules with a limit that is rounded to nothing. The IEEE scalars have such speeds and find that the leg
// takes too long.
static void test_a_leg_too_slow_for_the_scalar_is_an_honest_outcome(void) {
    ssv_thrusts_t thrusts = {.force_max_N = REAL(1000)};
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        thrusts.accel[i] = REAL(0.01);
        thrusts.quadratic[i] = REAL(100000);
    }
    const ssv_ramp_t ramps[] = {SSV_OPTIMAL, SSV_FULL_REVERSE, SSV_DRAG_ONLY};
    for (int k = 0; k < 3; k++) {
        for (int n = 0; n < 60; n++) {
            const double size = pow(10, -0.25 * n);
            const ssv_rule_t rule = {ramps[k], REAL(0.001), real_from_double(1e-2 * size), REAL(1), REAL(0)};
            thrusts.force_max_N = ramps[k] == SSV_OPTIMAL ? REAL(1000) : real_from_double(1000 * size);
            ssv_profile_t profile;
            const uint32_t overflows = real_overflows();
            const ssv_outcome_t outcome = ssv_profile_solve(&thrusts, &rule, REAL(900), &profile);
            if (real_overflows() != overflows) continue; // said, not silent
            TEST_ASSERT_TRUE(outcome == SSV_FEASIBLE || outcome == SSV_TOO_LONG || outcome == SSV_NO_AUTHORITY);
            if (outcome != SSV_FEASIBLE) continue;
            TEST_ASSERT_TRUE(profile.num_arcs > 0 && profile.duration_s > REAL(0));
        }
    }
}

// Whoever reads a ramp may be given an empty one, whose arcs hold nothing.
static void test_an_empty_ramp_covers_no_distance_and_has_no_arc_to_read(void) {
    ssv_thruster_groups_t groups = {.num = 1, .weight = {REAL(1)}, .limit = {REAL(1)}, .total = REAL(1)};
    ssv_ramp_table_t ramp = {.first = NULL, .step = 1};
    real_t a = REAL(7);
    TEST_ASSERT_TRUE(ssv_ramp_top_speed(&ramp) == REAL(0));
    TEST_ASSERT_TRUE(ssv_ramp_distance_to(&groups, &ramp, REAL(1), &a) == REAL(0));
    TEST_ASSERT_TRUE(a == REAL(0) && ramp.last == -1 && !ssv_ramp_ends_coasting(&ramp));
    TEST_ASSERT_TRUE(ssv_ramp_acceleration(&groups, &ramp, REAL(1)) == REAL(0));
    ssv_ramp_measure(&groups, &ramp);
    ssv_ramp_keep_slowing(&groups, &ramp);
    TEST_ASSERT_EQUAL_INT(0, ramp.num);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_the_length_of_a_vector_is_as_good_as_its_components);
    RUN_TEST(test_a_flight_turns_as_far_as_its_twist_says_however_little_that_is);
    RUN_TEST(test_a_slow_coast_is_as_long_as_its_drag_says);
    RUN_TEST(test_no_thruster_is_driven_beyond_its_limit_where_two_nearly_mirror_each_other);
    RUN_TEST(test_a_long_leg_cruises_at_the_cheapest_speed_past_thrusters_that_hardly_act);
    RUN_TEST(test_the_price_of_a_leg_does_not_hang_on_the_last_digits_of_its_thrusts);
    RUN_TEST(test_an_arc_whose_thrusts_bend_within_a_fraction_of_a_millisecond_has_a_timeline);
    RUN_TEST(test_a_leg_too_slow_for_the_scalar_is_an_honest_outcome);
    RUN_TEST(test_an_empty_ramp_covers_no_distance_and_has_no_arc_to_read);
    return UNITY_END();
}
