// Thrusters of the simulator: each step from command to force by its table, and the lag against its closed form.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "physics/thruster.h"
#include "unity.h"

#define COUNT_OF(a) (sizeof(a) / sizeof(a)[0])

void setUp(void) {}
void tearDown(void) {}

/// Where the first thruster's force settles.
static double settled_N(const sim_thruster_config_t* config, double command) {
    sim_thruster_bank_t bank;
    const double commands[SIM_THRUSTERS] = {command};
    double force_N[SIM_THRUSTERS];
    sim_thruster_init(&bank, config, 1, 2);
    sim_thruster_command(&bank, commands);
    sim_thruster_force(&bank, 1e6, force_N);
    return force_N[0];
}

typedef struct {
    double command, force_N;
} row_t;

static void check_table(const sim_thruster_config_t* config, const row_t* row, size_t count) {
    for (size_t i = 0; i < count; i++) {
        char label[40];
        snprintf(label, sizeof label, "command %g", row[i].command);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-14, row[i].force_N, settled_N(config, row[i].command), label);
    }
}

static void test_an_ideal_thruster_pushes_with_its_command_at_once_to_the_bit(void) {
    const sim_thruster_config_t ideal = {.lag_s = 0};
    sim_thruster_bank_t bank;
    const double commands[SIM_THRUSTERS] = {1.0 / 3, -5.7, 1e-12, 0, 1e3, -0.1};
    double force_N[SIM_THRUSTERS];
    sim_thruster_init(&bank, &ideal, 1, 2);
    sim_thruster_command(&bank, commands);
    sim_thruster_force(&bank, 0, force_N);
    TEST_ASSERT_EQUAL_MEMORY(commands, force_N, sizeof force_N);
    sim_thruster_step(&bank, 0.005);
    TEST_ASSERT_EQUAL_MEMORY(commands, bank.force_N, sizeof force_N);
}

static void test_commands_are_rounded_to_the_quantum(void) {
    const sim_thruster_config_t config = {.quantum = 0.25};
    static const row_t row[] = {{0, 0},       {0.12, 0},   {0.125, 0.25}, {-0.125, -0.25}, {0.3, 0.25},
                                {0.37, 0.25}, {0.38, 0.5}, {-0.38, -0.5}, {6, 6},          {-5.9, -6}};
    check_table(&config, row, COUNT_OF(row));
}

static void test_commands_inside_the_dead_band_give_nothing_and_those_outside_all(void) {
    const sim_thruster_config_t config = {.dead_band = 0.1};
    static const row_t row[] = {{0, 0},           {0.05, 0},          {0.1, 0}, {-0.1, 0},
                                {0.1001, 0.1001}, {-0.1001, -0.1001}, {1, 1},   {-1, -1}};
    check_table(&config, row, COUNT_OF(row));
}

static void test_forces_stop_at_the_limit_of_either_way(void) {
    const sim_thruster_config_t config = {.force_forward_max_N = 6, .force_reverse_max_N = 4.5};
    static const row_t row[] = {{5.9, 5.9}, {6, 6}, {6.1, 6}, {100, 6}, {-4.4, -4.4}, {-4.6, -4.5}, {-100, -4.5}};
    check_table(&config, row, COUNT_OF(row));
}

static void test_a_curve_runs_on_straight_lines_and_grows_with_the_voltage(void) {
    // Asymmetric, dead up to an effort of 0.07.
    sim_thruster_config_t config = {.curve = {.num_points = 6,
                                              .effort = {-1, -0.5, -0.07, 0.07, 0.6, 1},
                                              .force_N = {-40, -12, 0, 0, 20, 52},
                                              .voltage_exponent = 1.5}};
    static const row_t row[] = {{-1.2, -40}, {-1, -40},  {-0.75, -26}, {-0.5, -12}, {-0.285, -6},
                                {-0.07, 0},  {-0.05, 0}, {0, 0},       {0.07, 0},   {0.335, 10},
                                {0.6, 20},   {0.8, 36},  {0.9, 44},    {1, 52},     {1.5, 52}};
    check_table(&config, row, COUNT_OF(row));
    config.curve.voltage_ratio = 4;
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 8 * 36, settled_N(&config, 0.8));
    config.curve.voltage_ratio = 0.25;
    TEST_ASSERT_DOUBLE_WITHIN(1e-13, -26 / 8.0, settled_N(&config, -0.75));
}

static void test_gain_errors_are_as_given_and_as_drawn(void) {
    const sim_thruster_config_t given = {.gain_error = {0.03, -0.02, 0, 0, 0, -1}};
    sim_thruster_bank_t bank;
    const double commands[SIM_THRUSTERS] = {2, 2, 2, -2, 2, 2};
    sim_thruster_init(&bank, &given, 1, 2);
    sim_thruster_command(&bank, commands);
    static const double expected[SIM_THRUSTERS] = {2.06, 1.96, 2, -2, 2, 0};
    for (int t = 0; t < SIM_THRUSTERS; t++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-15, expected[t], bank.target_N[t]);
    }

    // Uniform in -5 % to 5 %: mean 0, variance 0.05^2 / 3, none outside; six of each seed, all different.
    enum { SEEDS = 5000 };
    const sim_thruster_config_t drawn = {.gain_spread = 0.05};
    double mean = 0, square = 0;
    for (uint64_t seed = 0; seed < SEEDS; seed++) {
        sim_thruster_init(&bank, &drawn, seed, 2);
        for (int t = 0; t < SIM_THRUSTERS; t++) {
            TEST_ASSERT_TRUE(fabs(bank.gain[t] - 1) <= 0.05 && (t == 0 || bank.gain[t] != bank.gain[t - 1]));
            mean += (bank.gain[t] - 1) / (SEEDS * SIM_THRUSTERS);
            square += pow(bank.gain[t] - 1, 2) / (SEEDS * SIM_THRUSTERS);
        }
    }
    const double variance = 0.05 * 0.05 / 3;
    TEST_ASSERT_DOUBLE_WITHIN(4 * sqrt(variance / (SEEDS * SIM_THRUSTERS)), 0, mean);
    TEST_ASSERT_DOUBLE_WITHIN(4 * variance * sqrt(0.8 / (SEEDS * SIM_THRUSTERS)), variance, square);
}

static void test_quantum_dead_band_gain_and_limit_come_in_this_order(void) {
    const sim_thruster_config_t config = {
        .quantum = 0.5, .dead_band = 0.4, .gain_error = {0.1}, .force_forward_max_N = 3, .force_reverse_max_N = 3};
    static const row_t row[] = {{0.24, 0}, {0.25, 0.55}, {0.6, 0.55}, {2.6, 2.75}, {2.8, 3}, {-9, -3}};
    check_table(&config, row, COUNT_OF(row));
}

static void test_a_lagging_thruster_follows_the_exponential_however_the_time_is_cut(void) {
    const sim_thruster_config_t config = {.lag_s = 0.2};
    sim_thruster_bank_t fine, coarse;
    sim_thruster_init(&fine, &config, 1, 2);
    sim_thruster_init(&coarse, &config, 1, 2);
    const double up[SIM_THRUSTERS] = {6, -3}, down[SIM_THRUSTERS] = {-2, 1};
    sim_thruster_command(&fine, up);
    sim_thruster_command(&coarse, up);
    for (int i = 0; i < 60; i++) {
        sim_thruster_step(&fine, 0.005);
    }
    sim_thruster_step(&coarse, 0.3);
    const double reached = -expm1(-0.3 / 0.2);
    for (int t = 0; t < SIM_THRUSTERS; t++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-13, up[t] * reached, fine.force_N[t]);
        TEST_ASSERT_DOUBLE_WITHIN(1e-14, up[t] * reached, coarse.force_N[t]);
    }
    sim_thruster_command(&coarse, down);
    double force_N[SIM_THRUSTERS];
    static const double times[] = {0, 0.01, 0.1, 0.2, 1};
    for (size_t i = 0; i < COUNT_OF(times); i++) {
        sim_thruster_force(&coarse, times[i], force_N);
        const double left = exp(-times[i] / 0.2);
        TEST_ASSERT_DOUBLE_WITHIN(1e-14, -2 + (6 * reached + 2) * left, force_N[0]);
        TEST_ASSERT_DOUBLE_WITHIN(1e-14, 1 + (-3 * reached - 1) * left, force_N[1]);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_an_ideal_thruster_pushes_with_its_command_at_once_to_the_bit);
    RUN_TEST(test_commands_are_rounded_to_the_quantum);
    RUN_TEST(test_commands_inside_the_dead_band_give_nothing_and_those_outside_all);
    RUN_TEST(test_forces_stop_at_the_limit_of_either_way);
    RUN_TEST(test_a_curve_runs_on_straight_lines_and_grows_with_the_voltage);
    RUN_TEST(test_gain_errors_are_as_given_and_as_drawn);
    RUN_TEST(test_quantum_dead_band_gain_and_limit_come_in_this_order);
    RUN_TEST(test_a_lagging_thruster_follows_the_exponential_however_the_time_is_cut);
    return UNITY_END();
}
