// Bracketed roots of functions whose roots are known.
#include <math.h>

#include "planner/math/root.h"
#include "sample.h"
#include "unity.h"

#define NUM_OF_EACH 1000

void setUp(void) { sample_seed(20261128); }
void tearDown(void) {}

// Increasing functions: one that bends up, one that bends down, one that is nearly a step, one that leaps past 0 at 1,
// and one that bends up so much that halving its value at the upper end alone takes hundreds of steps.
typedef enum { CUBE, ROOT, STEEP, LEAP, POWER, NUM_SHAPES } shape_t;

static double value(shape_t shape, double x) {
    switch (shape) {
        case CUBE: return x * x * x;
        case ROOT: return sqrt(x);
        case STEEP: return atan(1000 * (x - 1));
        case POWER: return pow(x, 256);
        default: return x < 1 ? x - 2 : x;
    }
}

static double argument(shape_t shape, double y) {
    switch (shape) {
        case CUBE: return cbrt(y);
        case ROOT: return y * y;
        case STEEP: return 1 + tan(y) / 1000;
        case POWER: return pow(y, 1.0 / 256);
        default: return 1;
    }
}

static double target(shape_t shape) {
    switch (shape) {
        case STEEP: return sample_between(-1.5, 1.5);
        case LEAP: return 0;
        default: return sample_between(0.01, 1.4);
    }
}

static void test_illinois_finds_the_root_of_every_shape_and_keeps_it_bracketed(void) {
    // Every third step halves: 3 log2(4 / 1e-10) steps would do without any falsi.
    const int most = 106;
    for (int n = 0; n < NUM_SHAPES * NUM_OF_EACH; n++) {
        const shape_t shape = (shape_t)(n % NUM_SHAPES);
        const double y = target(shape), high = sample_between(3, 4);
        ssv_root_t root = ssv_root_between(y, 0, value(shape, 0), high, value(shape, high));
        bool met = false;
        for (int k = 0; k < most && !met && root.high - root.low > 1e-10; k++) {
            const double x = ssv_root_propose(&root);
            TEST_ASSERT_TRUE(root.low <= x && x <= root.high);
            ssv_root_tell_illinois(&root, x, value(shape, x));
            TEST_ASSERT_TRUE(value(shape, root.low) <= y && value(shape, root.high) > y);
            met = value(shape, x) == y;
        }
        TEST_ASSERT_TRUE(met || root.high - root.low <= 1e-10);
        // The functions' own rounding moves a root by no more than a part in 1e13 or so.
        TEST_ASSERT_TRUE(root.low - 1e-12 <= argument(shape, y) && argument(shape, y) <= root.high + 1e-12);
    }
}

static void test_an_end_that_stays_a_second_time_counts_half(void) {
    ssv_root_t root = ssv_root_between(1, 0, 0, 8, 9);
    ssv_root_tell_illinois(&root, 1, 0.5); // the first below: nothing has stayed yet
    TEST_ASSERT_TRUE(root.low == 1 && root.y_low == 0.5);
    ssv_root_tell_illinois(&root, 2, 0.75);
    TEST_ASSERT_TRUE(root.low == 2 && root.y_low == 0.75 && root.high == 8 && root.y_high == 5); // halfway from 9 to 1
    ssv_root_tell_illinois(&root, 4, 2);
    TEST_ASSERT_TRUE(root.high == 4 && root.y_high == 2 && root.y_low == 0.75); // the side changed
    ssv_root_tell(&root, 3, 1.5);
    TEST_ASSERT_TRUE(root.high == 3 && root.y_high == 1.5 && root.y_low == 0.75); // plain bookkeeping halves nothing
}

static void test_a_search_from_below_is_bracketed_by_the_first_value_above(void) {
    ssv_root_t root = ssv_root_from(0, 0, -1, 10);
    ssv_root_tell_illinois(&root, 2, -0.5);
    ssv_root_tell_illinois(&root, 3, -0.25);
    TEST_ASSERT_TRUE(!root.bracketed && root.low == 3 && root.high == 10);
    ssv_root_tell_illinois(&root, 4, 0.25);
    TEST_ASSERT_TRUE(root.bracketed && root.high == 4 && root.y_low == -0.25);
    TEST_ASSERT_TRUE(ssv_root_share(&root) == 0.5 && ssv_root_middle(&root) == 3.5);
}

static void test_a_bracket_without_a_number_inside_is_exhausted(void) {
    ssv_root_t root = ssv_root_between(0, 1, -1, nextafter(1, 2), 1);
    TEST_ASSERT_TRUE(ssv_root_is_exhausted(&root));
    TEST_ASSERT_FALSE(ssv_root_is_inside(&root, 1) || ssv_root_is_inside(&root, nextafter(1, 2)));
    root.high = nextafter(root.high, 2);
    TEST_ASSERT_FALSE(ssv_root_is_exhausted(&root));
    TEST_ASSERT_TRUE(ssv_root_is_inside(&root, nextafter(1, 2)));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_illinois_finds_the_root_of_every_shape_and_keeps_it_bracketed);
    RUN_TEST(test_an_end_that_stays_a_second_time_counts_half);
    RUN_TEST(test_a_search_from_below_is_bracketed_by_the_first_value_above);
    RUN_TEST(test_a_bracket_without_a_number_inside_is_exhausted);
    return UNITY_END();
}
