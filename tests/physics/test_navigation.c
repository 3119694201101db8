// Navigation of the simulator: counts and moments of its errors, its delay and its drop-outs.
#include <math.h>
#include <string.h>

#include "physics/navigation.h"
#include "unity.h"

#define SIGMAS 4 // 1 in 15,000 by chance, and the seeds are fixed

void setUp(void) {}
void tearDown(void) {}

/// Moving, so that a stale truth would show: x is the time.
static rb_state_t truth_at(double t_s) {
    const rb_state_t state = {{{t_s, -2, 3}, {0.5, -0.5, 0.5, 0.5}}, {0.01, 0.02, -0.03, 0.1, -0.2, 0.3}};
    return state;
}

static void observe(sim_navigation_t* navigation, double t_s) {
    const rb_state_t truth = truth_at(t_s);
    sim_navigation_observe(navigation, t_s, &truth);
}

/// The small turn from the true attitude to the measured one, about axes of {b}.
static void turn_of(const sim_measurement_t* measurement, double turn[3]) {
    const rb_state_t truth = truth_at(measurement->t_s);
    const rb_pose_t between = rb_relative(&truth.eta, &measurement->state.eta);
    for (int i = 0; i < 3; i++) {
        turn[i] = 2 * between.q[1 + i] / between.q[0]; // to third order
    }
}

static void test_ideal_navigation_tells_the_truth_with_every_step_to_the_bit(void) {
    const sim_navigation_config_t ideal = {.rate_Hz = 0};
    sim_navigation_t navigation;
    sim_navigation_init(&navigation, &ideal, 1, 3);
    for (int i = 0; i < 100; i++) {
        const double t_s = 0.005 * i;
        const rb_state_t truth = truth_at(t_s);
        sim_measurement_t measurement;
        sim_navigation_observe(&navigation, t_s, &truth);
        TEST_ASSERT_TRUE(sim_navigation_take(&navigation, t_s, &measurement));
        TEST_ASSERT_EQUAL_MEMORY(&truth, &measurement.state, sizeof truth);
        TEST_ASSERT_EQUAL(i, measurement.number);
        TEST_ASSERT_EQUAL_DOUBLE(t_s, measurement.t_s);
        TEST_ASSERT_FALSE(sim_navigation_take(&navigation, t_s, &measurement));
    }
}

static void test_measurements_come_at_their_rate_after_their_delay_with_the_state_of_their_time(void) {
    const sim_navigation_config_t config = {.rate_Hz = 10, .delay_s = 0.235};
    sim_navigation_t navigation;
    sim_navigation_init(&navigation, &config, 1, 3);
    long long taken = 0;
    double t_s = 0;
    for (int step = 0; step <= 2000; step++) { // ten seconds
        observe(&navigation, t_s);
        sim_measurement_t measurement;
        while (sim_navigation_take(&navigation, t_s, &measurement)) {
            TEST_ASSERT_EQUAL(taken, measurement.number);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.1 * (double)taken, measurement.t_s);
            TEST_ASSERT_EQUAL_DOUBLE(measurement.t_s, measurement.state.eta.p_m[0]);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, measurement.t_s + 0.235, t_s);
            taken++;
        }
        t_s += 0.005;
    }
    TEST_ASSERT_EQUAL(98, taken); // of 101 measured, those of 9.8, 9.9 and 10 s are under way
}

static void test_a_rate_that_the_steps_do_not_divide_keeps_its_mean(void) {
    const sim_navigation_config_t config = {.rate_Hz = 7};
    sim_navigation_t navigation;
    sim_navigation_init(&navigation, &config, 1, 3);
    int taken = 0;
    for (int step = 0; step < 20000; step++) { // one hundred seconds
        observe(&navigation, 0.005 * step);
        sim_measurement_t measurement;
        if (sim_navigation_take(&navigation, 0.005 * step, &measurement)) {
            TEST_ASSERT_EQUAL(taken, measurement.number);
            TEST_ASSERT_TRUE(measurement.t_s > taken / 7.0 - 1e-6 && measurement.t_s < taken / 7.0 + 0.005);
            taken++;
        }
    }
    TEST_ASSERT_EQUAL(700, taken);
}

static void test_drop_outs_are_as_many_as_their_probability_says_and_leave_gaps_in_the_numbers(void) {
    enum { N = 20000 };
    const sim_navigation_config_t config = {.rate_Hz = 10, .dropout = 0.2};
    sim_navigation_t navigation;
    sim_navigation_init(&navigation, &config, 4, 3);
    int taken = 0, twice = 0;
    long long last = -1;
    for (int i = 0; i < N; i++) {
        observe(&navigation, 0.1 * i);
        sim_measurement_t measurement;
        if (sim_navigation_take(&navigation, 0.1 * i, &measurement)) {
            TEST_ASSERT_EQUAL(i, measurement.number);
            twice += measurement.number - last > 2;
            last = measurement.number;
            taken++;
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * sqrt(N * 0.2 * 0.8), N * 0.8, taken);
    // Independent of one another: a gap of two or more begins with 0.8 * 0.2^2 of the measurements.
    TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * sqrt(N * 0.032), N * 0.032, twice);

    const sim_navigation_config_t all = {.rate_Hz = 10, .dropout = 1};
    sim_navigation_init(&navigation, &all, 4, 3);
    for (int i = 0; i < 1000; i++) {
        sim_measurement_t measurement;
        observe(&navigation, 0.1 * i);
        TEST_ASSERT_FALSE(sim_navigation_take(&navigation, 0.1 * i, &measurement));
    }
}

static void test_white_noise_and_bias_have_their_deviation_and_their_mean_on_every_axis(void) {
    enum { N = 40000 };
    const sim_navigation_config_t config = {
        .position_m = {.white = 0.005, .bias = {0.01, -0.02, 0}},
        .attitude_rad = {.white = 0.0087, .bias = {0, 0.01, -0.005}},
        .velocity_m_s = {.white = 0.002, .bias = {0.001, 0, 0}},
        .rate_rad_s = {.white = 0.001, .bias = {0, 0, 0.002}},
    };
    const sim_error_t* error[4] = {&config.position_m, &config.attitude_rad, &config.velocity_m_s, &config.rate_rad_s};
    sim_navigation_t navigation;
    sim_navigation_init(&navigation, &config, 9, 3);
    double sum[4][3] = {{0}}, square[4][3] = {{0}};
    for (int k = 0; k < N; k++) {
        const double t_s = 0.1 * k;
        const rb_state_t truth = truth_at(t_s);
        sim_measurement_t measurement;
        observe(&navigation, t_s);
        TEST_ASSERT_TRUE(sim_navigation_take(&navigation, t_s, &measurement));
        double turn[3];
        turn_of(&measurement, turn);
        for (int i = 0; i < 3; i++) {
            const double off[4] = {measurement.state.eta.p_m[i] - truth.eta.p_m[i], turn[i],
                                   measurement.state.nu[i] - truth.nu[i],
                                   measurement.state.nu[3 + i] - truth.nu[3 + i]};
            for (int which = 0; which < 4; which++) {
                const double noise = (off[which] - error[which]->bias[i]) / error[which]->white;
                sum[which][i] += noise / N;
                square[which][i] += noise * noise / N;
            }
        }
    }
    for (int which = 0; which < 4; which++) {
        for (int i = 0; i < 3; i++) {
            TEST_ASSERT_DOUBLE_WITHIN(SIGMAS / sqrt(N), 0, sum[which][i]);
            TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * sqrt(2.0 / N), 1, square[which][i]);
        }
    }
}

static void test_a_walking_bias_spreads_with_the_root_of_time_whatever_the_rate(void) {
    enum { SEEDS = 4000 };
    static const double rates_Hz[] = {1, 10};
    for (int r = 0; r < 2; r++) {
        const sim_navigation_config_t config = {.rate_Hz = rates_Hz[r], .position_m = {.walk_sqrt_s = 0.001}};
        double early = 0, late = 0, both = 0;
        for (uint64_t seed = 0; seed < SEEDS; seed++) {
            sim_navigation_t navigation;
            sim_navigation_init(&navigation, &config, seed, 3);
            double at_5_s = 0, at_20_s = 0;
            for (int k = 0; k <= 20 * (int)rates_Hz[r]; k++) {
                const double t_s = k / rates_Hz[r];
                sim_measurement_t measurement;
                observe(&navigation, t_s);
                TEST_ASSERT_TRUE(sim_navigation_take(&navigation, t_s, &measurement));
                at_20_s = (measurement.state.eta.p_m[1] + 2) / 0.001;
                if (k == 0) {
                    TEST_ASSERT_EQUAL_DOUBLE(0, at_20_s); // it starts from nothing
                }
                if (k == 5 * (int)rates_Hz[r]) {
                    at_5_s = at_20_s;
                }
            }
            early += at_5_s * at_5_s / SEEDS;
            late += at_20_s * at_20_s / SEEDS;
            both += at_5_s * at_20_s / SEEDS;
        }
        TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * 5 * sqrt(2.0 / SEEDS), 5, early);
        TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * 20 * sqrt(2.0 / SEEDS), 20, late);
        TEST_ASSERT_DOUBLE_WITHIN(SIGMAS * sqrt((5.0 * 20 + 25) / SEEDS), 5, both); // independent increments
    }
}

static void test_measurements_that_nobody_takes_make_room_for_newer_ones(void) {
    const sim_navigation_config_t ideal = {.rate_Hz = 0};
    sim_navigation_t navigation;
    sim_navigation_init(&navigation, &ideal, 1, 3);
    for (int i = 0; i < 1000; i++) {
        observe(&navigation, i);
    }
    sim_measurement_t measurement;
    for (int i = 1000 - SIM_UNDER_WAY; i < 1000; i++) {
        TEST_ASSERT_TRUE(sim_navigation_take(&navigation, 1000, &measurement));
        TEST_ASSERT_EQUAL(i, measurement.number);
    }
    TEST_ASSERT_FALSE(sim_navigation_take(&navigation, 1000, &measurement));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_ideal_navigation_tells_the_truth_with_every_step_to_the_bit);
    RUN_TEST(test_measurements_come_at_their_rate_after_their_delay_with_the_state_of_their_time);
    RUN_TEST(test_a_rate_that_the_steps_do_not_divide_keeps_its_mean);
    RUN_TEST(test_drop_outs_are_as_many_as_their_probability_says_and_leave_gaps_in_the_numbers);
    RUN_TEST(test_white_noise_and_bias_have_their_deviation_and_their_mean_on_every_axis);
    RUN_TEST(test_a_walking_bias_spreads_with_the_root_of_time_whatever_the_rate);
    RUN_TEST(test_measurements_that_nobody_takes_make_room_for_newer_ones);
    return UNITY_END();
}
