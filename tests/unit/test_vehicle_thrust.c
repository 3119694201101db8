// Newtons to efforts against the simulator's curve, and the impulse that a dead band keeps back.
#include <math.h>
#include <string.h>

#include "physics/thruster.h"
#include "sil/sil.h"
#include "two_ends.h"
#include "unity.h"
#include "vehicle/thrust.h"

#define MOST_N 30.0F
#define RATIO 0.8 // of the supply's force to the nominal one

// A curve like that of a common thruster: stronger forward than in reverse, quadratic, nothing up to 0.07.
static sim_curve_t curve;
static sil_t sil;

static double force_of(double effort) {
    const double strongest_N = effort > 0 ? 51.5 : 39.9;
    return strongest_N * effort * fabs(effort);
}

void setUp(void) {
    static const double effort[] = {-1, -0.8, -0.6, -0.4, -0.2, -0.07, 0, 0.07, 0.2, 0.4, 0.6, 0.8, 1};
    draw_seed(3);
    memset(&curve, 0, sizeof curve);
    curve.num_points = sizeof effort / sizeof *effort;
    for (int i = 0; i < curve.num_points; i++) {
        curve.effort[i] = effort[i];
        curve.force_N[i] = force_of(effort[i]);
    }
    curve.voltage_ratio = RATIO;
    curve.voltage_exponent = 1;
    sil_config_t config;
    memset(&config, 0, sizeof config);
    config.world.vehicle = (rb_body_t){.mass_kg = 76, .inertia_kg_m2 = {3, 3, 3}};
    config.world.beam = config.world.vehicle;
    config.world.X_nb.q[0] = config.world.X_nB.q[0] = 1;
    config.world.thrusters.curve = curve;
    config.world.thrusters.dead_band = 0.07;
    for (int t = 0; t < SIM_THRUSTERS; t++) { // pairs on the hull
        config.world.thruster[t].n[t / 2] = t % 2 == 0 ? 1 : -1;
        config.world.thruster[t].r_m[(t / 2 + 2) % 3] = t % 2 == 0 ? 0.3 : -0.3;
    }
    config.force_max_N = 24;
    config.boot_id = 1;
    TEST_ASSERT_NULL(sil_init(&sil, &config, 1));
}

void tearDown(void) {}

// What the simulated thruster does with an effort.
static double physics_N(float effort) { return fabsf(effort) <= 0.07F ? 0 : sim_curve_force(&curve, (double)effort); }

static void test_the_effort_gives_the_force_by_the_curve_of_the_physics(void) {
    const float edge_N = (float)RATIO * sil.config.curve[0].forward.force_N[0];
    for (int trial = 0; trial < 10000; trial++) {
        const float demand_N = (float)draw_between(-30, 30);
        float carried_N = 0, given_N;
        if (fabsf(demand_N) < edge_N) continue;
        const float effort =
            ssv_thrust_effort(&sil.config.curve[0], (float)RATIO, MOST_N, demand_N, &carried_N, &given_N);
        TEST_ASSERT_TRUE(fabsf(effort) <= 1);
        TEST_ASSERT_DOUBLE_WITHIN(2e-5, (double)demand_N, physics_N(effort));
        TEST_ASSERT_EQUAL_FLOAT(demand_N, given_N);
        TEST_ASSERT_EQUAL_FLOAT(0, carried_N);
    }
}

static void test_a_greater_demand_never_has_a_smaller_effort(void) {
    float before = -1;
    for (int i = -3000; i <= 3000; i++) {
        float carried_N = 0, given_N;
        const float effort =
            ssv_thrust_effort(&sil.config.curve[0], (float)RATIO, MOST_N, 0.01F * (float)i, &carried_N, &given_N);
        TEST_ASSERT_TRUE(effort >= before);
        before = effort;
    }
}

static void test_the_dead_band_loses_no_impulse(void) {
    const double edge_N = RATIO * (double)sil.config.curve[0].forward.force_N[0];
    float carried_N = 0, given_N;
    double owed_N = 0;
    for (int tick = 0; tick < 100000; tick++) {
        const float demand_N = (float)(0.3 * sin(1e-3 * tick) + draw_between(-0.05, 0.05));
        const float effort =
            ssv_thrust_effort(&sil.config.curve[0], (float)RATIO, MOST_N, demand_N, &carried_N, &given_N);
        owed_N += (double)demand_N - physics_N(effort);
        // Half the band's edge, and the rounding of all ticks so far.
        TEST_ASSERT_TRUE(fabs(owed_N) <= edge_N / 2 + 1e-3);
    }
}

static void test_without_demand_nothing_is_given(void) {
    float carried_N = 0, given_N;
    for (int tick = 0; tick < 1000; tick++)
        TEST_ASSERT_EQUAL_FLOAT(0, ssv_thrust_effort(&sil.config.curve[0], 1, MOST_N, 0, &carried_N, &given_N));
}

static void test_what_is_too_much_is_cut_and_not_carried(void) {
    float carried_N = 0, given_N;
    TEST_ASSERT_EQUAL_FLOAT(1, ssv_thrust_effort(&sil.config.curve[0], 0.5F, MOST_N, 1000, &carried_N, &given_N));
    TEST_ASSERT_FLOAT_WITHIN(1e-4F, 25.75F, given_N);
    TEST_ASSERT_EQUAL_FLOAT(0, carried_N);
    TEST_ASSERT_EQUAL_FLOAT(-1, ssv_thrust_effort(&sil.config.curve[0], 0.5F, MOST_N, -1000, &carried_N, &given_N));
    TEST_ASSERT_FLOAT_WITHIN(1e-4F, -19.95F, given_N);
    ssv_thrust_effort(&sil.config.curve[0], 1, MOST_N, 1000, &carried_N, &given_N);
    TEST_ASSERT_EQUAL_FLOAT(MOST_N, given_N);
}

static void test_curves_that_do_not_rise_are_refused(void) {
    ssv_thrust_curve_t bad = sil.config.curve[0];
    TEST_ASSERT_TRUE(ssv_thrust_is_sound(&bad));
    bad.reverse.force_N[2] = bad.reverse.force_N[1];
    TEST_ASSERT_FALSE(ssv_thrust_is_sound(&bad));
    bad = sil.config.curve[0];
    bad.forward.effort[bad.forward.num_points - 1] = 1.01F;
    TEST_ASSERT_FALSE(ssv_thrust_is_sound(&bad));
    bad = sil.config.curve[0];
    bad.forward.effort[0] = NAN;
    TEST_ASSERT_FALSE(ssv_thrust_is_sound(&bad));
    bad.forward.num_points = 1;
    TEST_ASSERT_FALSE(ssv_thrust_is_sound(&bad));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_the_effort_gives_the_force_by_the_curve_of_the_physics);
    RUN_TEST(test_a_greater_demand_never_has_a_smaller_effort);
    RUN_TEST(test_the_dead_band_loses_no_impulse);
    RUN_TEST(test_without_demand_nothing_is_given);
    RUN_TEST(test_what_is_too_much_is_cut_and_not_carried);
    RUN_TEST(test_curves_that_do_not_rise_are_refused);
    return UNITY_END();
}
