// What ssv/real.h promises of every scalar: the same names, and results that agree with double as closely as the scalar
// can.
#include "ssv/real.h"

#include <math.h>
#include <stdlib.h>

#include "unity.h"

void setUp(void) {}
void tearDown(void) {}

// The step from 1 to the next number that the scalar has.
static double resolution(void) {
    real_t step = REAL(1);
    while (REAL(1) + real_mul(step, REAL(0.5)) > REAL(1)) step = real_mul(step, REAL(0.5));
    return real_to_double(step);
}

// A few steps, for libm's functions round as they like.
static void check(const char* what, double expected, real_t got) {
    const double tolerance = 4 * resolution() * (1 + fabs(expected));
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(tolerance, expected, real_to_double(got), what);
}

static void test_the_resolution_is_that_of_the_named_scalar(void) {
    const double expected = strcmp(REAL_NAME, "double") == 0  ? 0x1p-52
                            : strcmp(REAL_NAME, "float") == 0 ? 0x1p-23
                                                              : 0x1p-32;
    TEST_ASSERT_DOUBLE_WITHIN(0, expected, resolution());
}

static void test_every_operation_agrees_with_double(void) {
    // Exact in every scalar, so that the argument is the same.
    static const double points[] = {-12.5, -3.0, -0.75, -0.0625, 0.0, 0.03125, 0.5, 1.0, 1.4375, 7.25, 13.0};
    const int num = (int)(sizeof points / sizeof *points);
    for (int i = 0; i < num; i++) {
        const double x = points[i];
        const real_t a = real_from_double(x);
        check("there and back", x, a);
        check("absolute", fabs(x), real_abs(a));
        check("square", x * x, real_sq(a));
        check("sine", sin(x), real_sin(a));
        check("cosine", cos(x), real_cos(a));
        if (fabs(x) < 1.5) check("tangent", tan(x), real_tan(a));
        if (fabs(x) < 8) check("expm1", expm1(x), real_expm1(a));
        if (x >= 0) check("root", sqrt(x), real_sqrt(a));
        if (x > -1) check("log1p", log1p(x), real_log1p(a));
        for (int j = 0; j < num; j++) {
            const double y = points[j];
            const real_t b = real_from_double(y);
            check("product", x * y, real_mul(a, b));
            if (y < 0 || y > 0) check("quotient", x / y, real_div(a, b));
            check("arc tangent", atan2(x, y), real_atan2(a, b));
            check("least", x < y ? x : y, real_min(a, b));
            check("largest", x > y ? x : y, real_max(a, b));
        }
    }
    TEST_ASSERT_EQUAL_UINT32(0, real_overflows());
}

static void test_constants_are_converted_when_compiled(void) {
    static const real_t constant[] = {REAL(-0.625), REAL(3), REAL_PI};
    check("fraction", -0.625, constant[0]);
    check("whole number", 3, constant[1]);
    check("pi", 3.14159265358979323846, constant[2]);
    check("from an int", -7, real_from_int(-7));
}

static void test_what_is_no_number_is_not_finite(void) {
    TEST_ASSERT_FALSE(real_is_finite(real_from_double((double)NAN)));
    TEST_ASSERT_FALSE(real_is_finite(real_from_double((double)INFINITY)));
    TEST_ASSERT_FALSE(real_is_finite(real_from_double(-(double)INFINITY)));
    TEST_ASSERT_TRUE(real_is_finite(real_from_double(-1e5)));
    TEST_ASSERT_TRUE(isnan(real_to_double(real_from_double((double)NAN))));
    TEST_ASSERT_TRUE(isinf(real_to_double(real_from_double((double)INFINITY))));
}

static void test_bits_tell_values_apart_but_not_the_two_zeros(void) {
    TEST_ASSERT_EQUAL_UINT64(real_bits(REAL(0)), real_bits(-REAL(0)));
    TEST_ASSERT_TRUE(real_bits(REAL(1)) != real_bits(REAL(-1)));
    TEST_ASSERT_TRUE(real_bits(REAL(1)) != real_bits(REAL(1.0000002)));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_the_resolution_is_that_of_the_named_scalar);
    RUN_TEST(test_every_operation_agrees_with_double);
    RUN_TEST(test_constants_are_converted_when_compiled);
    RUN_TEST(test_what_is_no_number_is_not_finite);
    RUN_TEST(test_bits_tell_values_apart_but_not_the_two_zeros);
    return UNITY_END();
}
