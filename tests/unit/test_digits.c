// Vectors, poses and laws in every scalar, against long double: what is short or slow keeps its digits, too.
#include <math.h>
#include <string.h>

#include "planner/law.h"
#include "planner/leg.h"
#include "tasks.h"
#include "unity.h"

#define NUM_SIZES 9 // 1 down to 1e-8
#define NUM_OF_EACH 2000
#define FLIGHT_M 11.0L

void setUp(void) { task_seed(20261122); }
void tearDown(void) {}

static long double size_of(vec3_t a) {
    return sqrtl(powl(real_to_double(a.x), 2) + powl(real_to_double(a.y), 2) + powl(real_to_double(a.z), 2));
}

static vec3_t shorter(vec3_t a, int size) { return vec3_scale(real_from_double(pow(10, -size)), a); }

static void test_the_length_of_a_vector_is_as_good_as_its_components(void) {
    for (int n = 0; n < NUM_SIZES * NUM_OF_EACH; n++) {
        const vec3_t a = shorter(task_vector(1), n % NUM_SIZES);
        const long double expected = size_of(a);
        // Squares, sums and the root are rounded: by a part of the length, in fixed point by a part of the last digit.
        const long double rounding = 2 * (long double)real_to_double(REAL_EPSILON);
        const long double allowed = strcmp(REAL_NAME, "fixed") == 0 ? rounding : rounding * expected;
        TEST_ASSERT_TRUE(fabsl((long double)real_to_double(vec3_norm(a)) - expected) <= allowed);
    }
}

static void test_a_flight_turns_as_far_as_its_twist_says_however_little_that_is(void) {
    const vec3_t zero = vec3(REAL(0), REAL(0), REAL(0));
    for (int n = 0; n < NUM_SIZES * NUM_OF_EACH; n++) {
        const ssv_twist_t twist = {vec3(REAL(1), REAL(0), REAL(0)), shorter(task_vector(0.1), n % NUM_SIZES)};
        const pose_t X = ssv_move_pose((pose_t){zero, quat_identity()}, twist, REAL(FLIGHT_M));
        const long double turned = 2 * asinl(fminl(1, size_of(vec3(X.q.x, X.q.y, X.q.z))));
        // A part in a million of the turn, or what the last digits of twist and attitude amount to.
        const long double expected = FLIGHT_M * size_of(twist.w), allowed = 1e-6L * expected + 5e-9L;
        TEST_ASSERT_DOUBLE_WITHIN((double)allowed, (double)expected, (double)turned);
    }
}

// Without a constant thrust, the distance between two speeds is log((b + c v_to) / (b + c v_from)) / c.
static void test_a_slow_coast_is_as_long_as_its_drag_says(void) {
    const double b = -16.3, c = 300;
    const real_t law[3] = {REAL(0), real_from_double(b), real_from_double(c)};
    for (int n = 0; n < NUM_OF_EACH; n++) {
        const double fast = pow(10, task_between(-5, -2)), slow = fast * task_between(0.2, 0.6);
        const ssv_moments_t m = ssv_law_integrals(law, real_from_double(fast), real_from_double(slow));
        const long double expected = log1pl((long double)(c * (slow - fast)) / (long double)(b + c * fast)) / (long double)c;
        // A part in ten thousand for the speeds' digits in fixed point, and its last digit.
        TEST_ASSERT_DOUBLE_WITHIN((double)(1e-4L * expected + 1e-9L), (double)expected, real_to_double(m.distance));
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_the_length_of_a_vector_is_as_good_as_its_components);
    RUN_TEST(test_a_flight_turns_as_far_as_its_twist_says_however_little_that_is);
    RUN_TEST(test_a_slow_coast_is_as_long_as_its_drag_says);
    return UNITY_END();
}
