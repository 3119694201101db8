// The generator of the simulator's random numbers, and the current that it drives, against published numbers, closed
// forms and statistics with their bounds.
#include <math.h>
#include <string.h>

#include "physics/random.h"
#include "physics/water.h"
#include "unity.h"

#define COUNT_OF(a) (sizeof(a) / sizeof(a)[0])

/// Statistics of seeded draws may be this many of their own standard deviations off: 1 in 15,000 by chance.
#define SIGMAS 4

void setUp(void) {}
void tearDown(void) {}

static void test_the_generator_gives_the_numbers_that_its_authors_publish(void) {
    // xoshiro256++ from the state 1, 2, 3, 4, as in the reference vectors of its public implementations.
    static const uint64_t expected[] = {41943041u,
                                        58720359u,
                                        3588806011781223u,
                                        3591011842654386u,
                                        9228616714210784205u,
                                        9973669472204895162u,
                                        14011001112246962877u,
                                        12406186145184390807u,
                                        15849039046786891736u,
                                        10450023813501588000u};
    sim_random_t random = {{1, 2, 3, 4}};
    for (size_t i = 0; i < COUNT_OF(expected); i++) {
        TEST_ASSERT_EQUAL_HEX64(expected[i], sim_random_bits(&random));
    }
}

static void test_uniform_numbers_fill_the_unit_interval_evenly(void) {
    enum { N = 1000000, BINS = 100 };
    sim_random_t random;
    sim_random_init(&random, 7, 0);
    int count[BINS] = {0};
    for (int i = 0; i < N; i++) {
        const double u = sim_random_uniform(&random);
        TEST_ASSERT_TRUE(u >= 0 && u < 1);
        count[(int)(u * BINS)]++;
    }
    double chi2 = 0;
    for (int i = 0; i < BINS; i++) {
        chi2 += pow(count[i] - (double)N / BINS, 2) / ((double)N / BINS);
    }
    // Chi-squared with 99 degrees of freedom: mean 99, standard deviation sqrt(198).
    TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * sqrt(198), BINS - 1, chi2);
}

static void test_gaussian_numbers_have_the_moments_and_the_tails_of_a_gaussian(void) {
    enum { N = 1000000 };
    sim_random_t random;
    sim_random_init(&random, 8, 0);
    double sum[5] = {0}, beyond_2 = 0, beyond_3 = 0;
    for (int i = 0; i < N; i++) {
        const double g = sim_random_gauss(&random);
        for (int k = 1; k <= 4; k++) {
            sum[k] += pow(g, k) / N;
        }
        beyond_2 += fabs(g) > 2;
        beyond_3 += fabs(g) > 3;
    }
    // The variance of the mean of g^k is (E g^2k - (E g^k)^2) / N.
    TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * sqrt(1.0 / N), 0, sum[1]);
    TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * sqrt(2.0 / N), 1, sum[2]);
    TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * sqrt(15.0 / N), 0, sum[3]);
    TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * sqrt(96.0 / N), 3, sum[4]);
    const double p2 = erfc(sqrt(2)), p3 = erfc(3 / sqrt(2));
    TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * sqrt(N * p2 * (1 - p2)), N * p2, beyond_2);
    TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * sqrt(N * p3 * (1 - p3)), N * p3, beyond_3);
}

static void test_neighbouring_seeds_and_streams_are_uncorrelated(void) {
    enum { N = 200000 };
    static const uint64_t seed[4] = {1, 1, 2, 2}, stream[4] = {0, 1, 0, 1};
    sim_random_t random[4];
    double product[4][4] = {{0}};
    for (int a = 0; a < 4; a++) {
        sim_random_init(&random[a], seed[a], stream[a]);
    }
    for (int i = 0; i < N; i++) {
        double g[4];
        for (int a = 0; a < 4; a++) {
            g[a] = sim_random_gauss(&random[a]);
        }
        for (int a = 0; a < 4; a++) {
            for (int b = 0; b < a; b++) {
                product[a][b] += g[a] * g[b] / N;
            }
        }
    }
    for (int a = 0; a < 4; a++) {
        for (int b = 0; b < a; b++) {
            TEST_ASSERT_DOUBLE_WITHIN(SIGMAS / sqrt(N), 0, product[a][b]);
        }
    }
}

static void test_a_constant_current_stays_what_it_is_to_the_bit(void) {
    const sim_water_config_t config = {.mean_n_m_s = {0.01, -0.02, 0.003}};
    sim_water_t water;
    sim_water_init(&water, &config, 5, 1);
    for (int i = 0; i < 1000; i++) {
        double current[3];
        sim_water_current(&water, current);
        TEST_ASSERT_EQUAL_MEMORY(config.mean_n_m_s, current, sizeof current);
        sim_water_step(&water, 0.005);
    }
}

static void test_a_wandering_current_has_its_deviation_and_its_correlation_time(void) {
    enum { N = 400000, LAG = 20 };
    const double time_s = 60, dt_s = time_s / LAG; // LAG steps are one correlation time
    const sim_water_config_t config = {
        .mean_n_m_s = {0.1, 0, -0.1}, .wander_m_s = {0.005, 0.01, 0.02}, .wander_time_s = time_s};
    static double value[3][N];
    sim_water_t water;
    sim_water_init(&water, &config, 11, 1);
    for (int i = 0; i < N; i++) {
        double current[3];
        sim_water_current(&water, current);
        for (int axis = 0; axis < 3; axis++) {
            value[axis][i] = (current[axis] - config.mean_n_m_s[axis]) / config.wander_m_s[axis];
        }
        sim_water_step(&water, dt_s);
    }
    for (int axis = 0; axis < 3; axis++) {
        double mean = 0, variance = 0, half = 0, one = 0, two = 0, other = 0;
        for (int i = 0; i < N; i++) {
            mean += value[axis][i] / N;
            variance += value[axis][i] * value[axis][i] / N;
            other += value[axis][i] * value[(axis + 1) % 3][i] / N;
        }
        for (int i = 0; i + 2 * LAG < N; i++) {
            half += value[axis][i] * value[axis][i + LAG / 2] / (N - 2 * LAG);
            one += value[axis][i] * value[axis][i + LAG] / (N - 2 * LAG);
            two += value[axis][i] * value[axis][i + 2 * LAG] / (N - 2 * LAG);
        }
        // Averages over m = N/LAG correlation times: variance 2/m of the mean, 1/m of a product of two axes, and of
        // products at a lag of x correlation times (Bartlett) (1 + (1 + 2 x) exp(-2 x)) / m, at most 2/m.
        const double deviation = sqrt(2.0 * LAG / N);
        TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * deviation, 0, mean);
        TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * deviation, 0, other);
        TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * deviation, 1, variance);
        TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * deviation, exp(-0.5), half);
        TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * deviation, exp(-1), one);
        TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * deviation, exp(-2), two);
    }
}

static void test_a_wandering_current_starts_stationary_and_does_not_care_how_long_its_steps_are(void) {
    enum { N = 40000 };
    const sim_water_config_t config = {.wander_m_s = {1, 1, 1}, .wander_time_s = 10};
    // Ten seconds in one step, in four unequal ones: variance 1 at both ends and correlation 1/e between them.
    static const double steps[2][4] = {{10}, {0.1, 7, 0.4, 2.5}};
    for (int way = 0; way < 2; way++) {
        double before = 0, after = 0, product = 0;
        for (uint64_t seed = 0; seed < N; seed++) {
            sim_water_t water;
            double first[3], last[3];
            sim_water_init(&water, &config, seed, 1);
            sim_water_current(&water, first);
            for (int i = 0; i < 4 && steps[way][i] > 0; i++) {
                sim_water_step(&water, steps[way][i]);
            }
            sim_water_current(&water, last);
            before += first[0] * first[0] / N;
            after += last[0] * last[0] / N;
            product += first[0] * last[0] / N;
        }
        TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * sqrt(2.0 / N), 1, before);
        TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * sqrt(2.0 / N), 1, after);
        TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * sqrt((1 + exp(-2)) / N), exp(-1), product);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_the_generator_gives_the_numbers_that_its_authors_publish);
    RUN_TEST(test_uniform_numbers_fill_the_unit_interval_evenly);
    RUN_TEST(test_gaussian_numbers_have_the_moments_and_the_tails_of_a_gaussian);
    RUN_TEST(test_neighbouring_seeds_and_streams_are_uncorrelated);
    RUN_TEST(test_a_constant_current_stays_what_it_is_to_the_bit);
    RUN_TEST(test_a_wandering_current_has_its_deviation_and_its_correlation_time);
    RUN_TEST(test_a_wandering_current_starts_stationary_and_does_not_care_how_long_its_steps_are);
    return UNITY_END();
}
