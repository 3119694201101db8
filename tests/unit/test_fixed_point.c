// The fixed-point scalar by itself, in every build: products, quotients and roots against the definition of correct
// rounding in 128 bits, functions against long double, and what happens at the limits. With SSV_LONG set, 10^8 points
// of each.
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ssv/real.h"
#include "unity.h"

_Static_assert(LDBL_MANT_DIG >= 64, "the reference needs 64 bits");

#define SEED 20261122u
#define SHORT_COUNT 300000
#define LONG_COUNT 100000000
#define ULP 0x1p-32L
#define PI_L 3.14159265358979323846264338327950288L

__extension__ typedef __int128 exact_t;
#define ONE ((exact_t)1 << 32)

void setUp(void) {}
void tearDown(void) {}

static int count(void) { return getenv("SSV_LONG") != NULL ? LONG_COUNT : SHORT_COUNT; }

// splitmix64
static uint64_t random_state = SEED;
static uint64_t random_bits(void) {
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

// Every size of number equally often, of either sign, |a| < 2^bits ulp; one in eight within 4 ulp of a power of two.
static real_t random_size(int bits) {
    const uint64_t r = random_bits();
    const int length = (int)((r >> 8) % (uint64_t)(bits + 1));
    real_t a = length == 0 ? 0 : (real_t)(random_bits() >> (64 - length));
    if (r % 8 == 0) a = ((real_t)1 << (length < bits ? length : bits - 1)) + (real_t)((r >> 16) % 9) - 4;
    return (r & 16) != 0 ? -a : a;
}

static exact_t size_of(exact_t a) { return a < 0 ? -a : a; }

// What fits is a call's to give.
static bool fits(exact_t a) { return size_of(a) < REAL_MAX; }

static void fail_with(const char* what, int n, real_t a, real_t b, real_t got) {
    char text[200];
    snprintf(text, sizeof text, "%s, seed %u, point %d: a = %lld, b = %lld gave %lld", what, SEED, n, (long long)a,
             (long long)b, (long long)got);
    TEST_FAIL_MESSAGE(text);
}

// ---- Correct rounding -----------------------------------------------------------------------------------------------

// Whether got is n / d to the nearest, ties to even; d > 0.
static bool is_nearest(exact_t n, exact_t d, exact_t got) {
    const exact_t twice = 2 * size_of(n - got * d);
    return twice < d || (twice == d && got % 2 == 0);
}

static void test_products_are_rounded_to_the_nearest_with_ties_to_even(void) {
    random_state = SEED;
    for (int n = 0; n < count(); n++) {
        const real_t a = random_size(62), b = random_size(62);
        const exact_t p = (exact_t)a * b;
        const uint32_t before = real_overflows();
        const real_t got = real_mul(a, b);
        if (real_overflows() != before) {
            if (fits((size_of(p) >> 32) + 1) || got != ((a < 0) != (b < 0) ? -REAL_MAX : REAL_MAX)) {
                fail_with("product overflowed", n, a, b, got);
            }
        } else if (!is_nearest(p, ONE, got) || size_of(got) > REAL_MAX) {
            fail_with("product", n, a, b, got);
        }
    }
}

static void test_quotients_are_rounded_to_the_nearest_with_ties_to_even(void) {
    random_state = SEED;
    for (int n = 0; n < count(); n++) {
        const real_t a = random_size(63);
        real_t b = random_size(63);
        if (n % 5 == 0) b = random_size(20) * ((real_t)1 << 20); // ties happen
        const uint32_t before = real_overflows();
        const real_t got = real_div(a, b);
        if (real_overflows() != before) {
            if ((b != 0 && fits(size_of(a) * ONE / size_of(b) + 1)) ||
                got != ((a < 0) != (b < 0) ? -REAL_MAX : REAL_MAX)) {
                fail_with("quotient overflowed", n, a, b, got);
            }
        } else if (b == 0 || !is_nearest((exact_t)a * (b < 0 ? -ONE : ONE), size_of(b), got) ||
                   size_of(got) > REAL_MAX) {
            fail_with("quotient", n, a, b, got);
        }
    }
}

static void test_square_roots_are_rounded_to_the_nearest(void) {
    random_state = SEED;
    for (int n = 0; n < count(); n++) {
        real_t a = (real_t)size_of(n < 70000 ? n : random_size(63));
        if (n >= 70000 && n % 4 == 0) { // the root is close to a half or to a whole
            const exact_t root = random_size(46);
            a = (real_t)((root * root + (n % 8 == 0 ? size_of(root) : 0)) >> 32) + n % 3 - 1;
            if (a < 0) a = 0;
        }
        const real_t got = real_sqrt(a);
        // (2 got - 1)^2 <= 4 * 2^32 a < (2 got + 1)^2
        const exact_t four_x = 4 * ONE * a, below = 2 * (exact_t)got - 1, above = below + 2;
        if (got < 0 || (got > 0 && below * below > four_x) || above * above <= four_x) fail_with("root", n, a, 0, got);
    }
}

// ---- Functions ------------------------------------------------------------------------------------------------------

typedef struct {
    const char* name;
    real_t (*function)(real_t);
    long double (*reference)(long double);
    real_t low, high;   // where it is sampled
    long double result; // results beyond this size are not looked at
    long double bound;  // largest error [ulp]
} function_t;

// One third uniform, one third of every size, one third around multiples of a quarter turn.
static real_t random_argument(const function_t* f) {
    for (;;) {
        const uint64_t r = random_bits();
        real_t a = random_size(63);
        if (r % 3 == 0) a = f->low + (real_t)(random_bits() % ((uint64_t)f->high - (uint64_t)f->low));
        if (r % 3 == 1) a = (real_t)roundl(PI_L / 2 * 0x1p32L * (long double)((r >> 8) % 40)) + random_size(30);
        if (a >= f->low && a <= f->high) return a;
    }
}

static void check_function(const function_t* f) {
    long double worst = 0;
    real_t worst_at = 0;
    random_state = SEED;
    for (int n = 0; n < count(); n++) {
        const real_t a = n < 20000 ? n - 10000 : random_argument(f);
        const long double expected = f->reference((long double)a * ULP);
        if (!(fabsl(expected) <= f->result)) continue;
        const long double error = fabsl((long double)f->function(a) - expected / ULP);
        if (!(error > worst)) continue;
        worst = error;
        worst_at = a;
    }
    printf("%-6s up to %6.4Lg: worst error %.4Lf ulp, at %lld\n", f->name, f->result, worst, (long long)worst_at);
    if (worst > f->bound) fail_with(f->name, count(), worst_at, 0, f->function(worst_at));
}

static void test_functions_err_no_more_than_their_header_says(void) {
    static const function_t functions[] = {
        {"log1p", real_log1p, log1pl, 1 - REAL(1), REAL_MAX, INFINITY, 0.52L},
        {"expm1", real_expm1, expm1l, REAL(-40), REAL(18), 0x1p16L, 0.52L},
        {"expm1", real_expm1, expm1l, REAL(11), REAL(18.02), 0x1p26L - 1, 1},
        {"sin", real_sin, sinl, REAL(-100), REAL(100), 1, 0.52L},
        {"sin", real_sin, sinl, -REAL_MAX, REAL_MAX, 1, 0.52L},
        {"cos", real_cos, cosl, REAL(-100), REAL(100), 1, 0.52L},
        {"cos", real_cos, cosl, -REAL_MAX, REAL_MAX, 1, 0.52L},
        {"tan", real_tan, tanl, REAL(-8), REAL(8), 0x1p10L, 0.52L},
        {"tan", real_tan, tanl, REAL(-8), REAL(8), 0x1p13L, 1},
    };
    for (size_t k = 0; k < sizeof functions / sizeof *functions; k++) check_function(&functions[k]);
}

static void test_arc_tangent_errs_no_more_than_its_header_says(void) {
    long double worst = 0;
    random_state = SEED;
    for (int n = 0; n < count(); n++) {
        real_t y = random_size(63), x = random_size(63);
        if (n % 3 == 0) x = y / 128 * (real_t)(random_bits() % 128) + random_size(20); // also where the cases meet
        if (n < 40000) {
            y = n / 200 - 100;
            x = n % 200 - 100;
        }
        const long double error = fabsl((long double)real_atan2(y, x) - atan2l((long double)y, (long double)x) / ULP);
        if (error > 0.52L) fail_with("atan2", n, y, x, real_atan2(y, x));
        if (error > worst) worst = error;
    }
    printf("atan2: worst error %.4Lf ulp\n", worst);
}

static void test_odd_functions_are_exactly_odd_and_the_cosine_is_exactly_even(void) {
    random_state = SEED;
    for (int n = 0; n < count() / 10; n++) {
        const real_t a = random_size(58), b = random_size(58);
        if (real_mul(-a, b) != -real_mul(a, b)) fail_with("product", n, a, b, real_mul(-a, b));
        if (real_div(-a, b) != -real_div(a, b) && b != 0 && a != 0) fail_with("quotient", n, a, b, real_div(-a, b));
        if (real_sin(-a) != -real_sin(a)) fail_with("sine", n, a, 0, real_sin(-a));
        if (real_tan(-a) != -real_tan(a)) fail_with("tangent", n, a, 0, real_tan(-a));
        if (real_cos(-a) != real_cos(a)) fail_with("cosine", n, a, 0, real_cos(-a));
        if (a != 0 && real_atan2(-a, b) != -real_atan2(a, b)) fail_with("arc tangent", n, a, b, real_atan2(-a, b));
    }
}

// ---- Limits ---------------------------------------------------------------------------------------------------------

static void test_what_does_not_fit_or_exist_becomes_the_limit_and_counts(void) {
    const real_t big = REAL(10000);
    const struct {
        const char* what;
        real_t got, expected;
    } cases[] = {
        {"product", real_mul(big, big), REAL_MAX},
        {"product", real_mul(-big, big), -REAL_MAX},
        {"largest product", real_mul(INT64_MAX, INT64_MAX), REAL_MAX},
        {"quotient", real_div(big, REAL(1e-6)), REAL_MAX},
        {"quotient", real_div(big, -REAL(1e-6)), -REAL_MAX},
        {"by zero", real_div(-big, REAL(0)), -REAL_MAX},
        {"zero by zero", real_div(REAL(0), REAL(0)), REAL_MAX},
        {"root", real_sqrt(REAL(-1)), REAL(0)},
        {"logarithm of zero", real_log1p(REAL(-1)), -REAL_MAX},
        {"logarithm", real_log1p(REAL(-2)), -REAL_MAX},
        {"exponential", real_expm1(REAL(18.03)), REAL_MAX},
        {"exponential", real_expm1(REAL(19)), REAL_MAX},
        {"exponential", real_expm1(REAL(60)), REAL_MAX},
        {"exponential", real_expm1(REAL_MAX), REAL_MAX},
    };
    const int num = (int)(sizeof cases / sizeof *cases);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(num, real_overflows());
    for (int k = 0; k < num; k++) TEST_ASSERT_EQUAL_INT64_MESSAGE(cases[k].expected, cases[k].got, cases[k].what);

    const uint32_t before = real_overflows();
    for (uint32_t n = 1; n <= 5; n++) {
        (void)real_div(REAL(1), REAL(0));
        TEST_ASSERT_EQUAL_UINT32(before + n, real_overflows());
    }
}

static void test_what_fits_does_not_count(void) {
    const uint32_t before = real_overflows();
    const real_t largest = REAL_MAX - 1;
    TEST_ASSERT_EQUAL_INT64(largest, real_mul(largest, REAL(1)));
    TEST_ASSERT_EQUAL_INT64(-largest, real_mul(largest, REAL(-1)));
    TEST_ASSERT_EQUAL_INT64(largest, real_div(largest, REAL(1)));
    TEST_ASSERT_EQUAL_INT64(-largest, real_div(-largest, REAL(1)));
    TEST_ASSERT_EQUAL_INT64(REAL(8192), real_sqrt(REAL_MAX));
    TEST_ASSERT_EQUAL_INT64(REAL(-1), real_expm1(-REAL_MAX));
    TEST_ASSERT_EQUAL_INT64(0, real_sqrt(0));
    TEST_ASSERT_EQUAL_INT64(0, real_atan2(0, 0));
    TEST_ASSERT_EQUAL_UINT32(before, real_overflows());
}

static void test_a_sum_of_31_results_stays_inside_the_64_bits(void) {
    real_t sum = real_mul(REAL_MAX, REAL_MAX);
    for (int n = 1; n < 31; n++) {
        TEST_ASSERT_TRUE(sum <= INT64_MAX - REAL_MAX);
        sum += real_mul(REAL_MAX, REAL_MAX - n * REAL(1));
    }
}

// ---- Boundary -------------------------------------------------------------------------------------------------------

static void test_constants_and_doubles_are_rounded_to_the_nearest(void) {
    TEST_ASSERT_EQUAL_INT64(INT64_C(1) << 32, REAL(1));
    TEST_ASSERT_EQUAL_INT64(-(INT64_C(3) << 31), REAL(-1.5));
    TEST_ASSERT_EQUAL_INT64(INT64_C(13493037705), REAL_PI);
    TEST_ASSERT_EQUAL_INT64(0, REAL(1e-10));
    TEST_ASSERT_EQUAL_INT64(1, REAL(2e-10));
    TEST_ASSERT_EQUAL_INT64(INT64_C(13493037705), real_from_double(3.14159265358979323846));
    TEST_ASSERT_EQUAL_INT64(1, real_from_double(0x1p-33));
    TEST_ASSERT_EQUAL_INT64(-1, real_from_double(-0x1p-33));
    TEST_ASSERT_EQUAL_INT64(0, real_from_double(0x1.fffffffffffffp-34));
    random_state = SEED;
    for (int n = 0; n < count(); n++) {
        const real_t a = random_size(53);
        const real_t back = real_from_double(real_to_double(a));
        if (back != a) fail_with("to double and back", n, a, 0, back);
    }
}

static void test_what_is_no_number_passes_the_boundary_and_is_not_finite(void) {
    static const double none[] = {(double)NAN, (double)INFINITY, -(double)INFINITY};
    for (int k = 0; k < 3; k++) TEST_ASSERT_FALSE(real_is_finite(real_from_double(none[k])));
    TEST_ASSERT_TRUE(isnan(real_to_double(real_from_double((double)NAN))));
    TEST_ASSERT_TRUE(real_to_double(real_from_double((double)INFINITY)) > DBL_MAX);
    TEST_ASSERT_TRUE(real_to_double(real_from_double(-(double)INFINITY)) < -DBL_MAX);
    TEST_ASSERT_EQUAL_INT64(REAL_MAX, real_from_double(1e300));
    TEST_ASSERT_EQUAL_INT64(-REAL_MAX, real_from_double(-1e9));
    TEST_ASSERT_TRUE(real_is_finite(real_from_double(1e300)));
}

// 64 bits of mantissa hold every number of the scalar, so the compiler rounds once.
static void test_floats_and_nanoseconds_are_rounded_to_the_nearest(void) {
    for (int n = 0; n < count(); n++) {
        const real_t a = random_size(58);
        const float nearest = (float)((long double)a * ULP), got = real_to_float(a);
        if (nearest < got || nearest > got || signbit(nearest) != signbit(got))
            fail_with("real_to_float", n, a, 0, (real_t)got);
        const exact_t miss = (exact_t)real_to_nano(a) * ONE - (exact_t)a * 1000000000;
        if (size_of(miss) > ONE / 2) fail_with("real_to_nano", n, a, 0, real_to_nano(a));
    }
    // Halfway between two floats the even one, also where that carries into the exponent.
    TEST_ASSERT_EQUAL_FLOAT(16777216.0f, real_to_float(REAL(16777217)));
    TEST_ASSERT_EQUAL_FLOAT(16777220.0f, real_to_float(REAL(16777219)));
    TEST_ASSERT_EQUAL_FLOAT(33554432.0f, real_to_float(REAL(33554431)));
    TEST_ASSERT_EQUAL_FLOAT(-ULP, real_to_float(-1));
    TEST_ASSERT_EQUAL_INT64(-1, real_to_nano(REAL(-1e-9)));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_products_are_rounded_to_the_nearest_with_ties_to_even);
    RUN_TEST(test_quotients_are_rounded_to_the_nearest_with_ties_to_even);
    RUN_TEST(test_square_roots_are_rounded_to_the_nearest);
    RUN_TEST(test_functions_err_no_more_than_their_header_says);
    RUN_TEST(test_arc_tangent_errs_no_more_than_its_header_says);
    RUN_TEST(test_odd_functions_are_exactly_odd_and_the_cosine_is_exactly_even);
    RUN_TEST(test_what_does_not_fit_or_exist_becomes_the_limit_and_counts);
    RUN_TEST(test_what_fits_does_not_count);
    RUN_TEST(test_a_sum_of_31_results_stays_inside_the_64_bits);
    RUN_TEST(test_constants_and_doubles_are_rounded_to_the_nearest);
    RUN_TEST(test_floats_and_nanoseconds_are_rounded_to_the_nearest);
    RUN_TEST(test_what_is_no_number_passes_the_boundary_and_is_not_finite);
    return UNITY_END();
}
