// Profiles against textbook solutions of one-dimensional motion. Random legs against brute force: property.profile.
#include <math.h>

#include "planner/profile/profile.h"
#include "unity.h"

#define MASS 76.2
#define DRAG 413.685
#define FORCE 6.0
#define RADIUS 0.3025
#define INERTIA 2.7
#define DRAG_ANG 2.2

static ssv_profile_t profile;

void setUp(void) {}
void tearDown(void) {}

// The SSV along one of its axes: two thrusters share inertia and drag.
static ssv_thrusts_t straight(void) {
    const ssv_thrusts_t t = {{MASS / 2, -MASS / 2}, {DRAG / 2, -DRAG / 2}, {0}, FORCE};
    return t;
}

// The SSV about one of its axes: both thrusters of a pair push the same way.
static ssv_thrusts_t turning(void) {
    const double k = 1 / (2 * RADIUS);
    const ssv_thrusts_t t = {{0, 0, INERTIA * k, INERTIA * k}, {0}, {0, 0, DRAG_ANG * k, DRAG_ANG * k}, FORCE};
    return t;
}

static void solve(const ssv_thrusts_t* thrusts, ssv_ramp_t ramp, double cutoff, double distance) {
    TEST_ASSERT_EQUAL_INT(
        SSV_FEASIBLE, ssv_profile_solve(thrusts, &(ssv_rule_t){.ramp = ramp, .cutoff = cutoff}, distance, &profile));
}

static void test_straight_leg_takes_the_time_of_the_exact_solution_with_linear_drag(void) {
    // Long against tau = m/C: T = D/v_t + 2 tau ln 2, v_t = 2 F / C. The exponential that is left out is below 1e-20.
    const ssv_thrusts_t t = straight();
    static const double stroke[] = {6.524, 5.0, 3.476, 0.3025};
    static const double expected[] = {225.162, 172.624, 120.086, 10.6837};
    for (int k = 0; k < 4; k++) {
        solve(&t, SSV_FULL_REVERSE, 0.001, stroke[k]);
        const double exact = stroke[k] * DRAG / (2 * FORCE) + 2 * MASS / DRAG * log(2);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * exact, exact, profile.duration_s); // terminal margin 6e-8
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * expected[k], expected[k], profile.duration_s);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * profile.impulse_Ns, 2 * FORCE * exact, profile.impulse_Ns);
    }
}

static void test_quarter_turn_takes_the_time_of_the_exact_solution_with_quadratic_drag(void) {
    // Up: w = w_t tanh(t / tau), angle = w_t tau ln cosh. Down: w = w_t tan, angle = w_t tau ln(1 + (w/w_t)^2) / 2,
    // equal to -ln(1 - (w/w_t)^2) / 2 for the first; the peak from their sum.
    const double w_t = sqrt(2 * FORCE * RADIUS / DRAG_ANG), reach = INERTIA / DRAG_ANG, angle = 1.5707963267948966;
    const double e = exp(2 * angle / reach), x2 = (e - 1) / (e + 1);
    const double exact = reach / w_t * (atanh(sqrt(x2)) + atan(sqrt(x2)));
    const ssv_thrusts_t t = turning();
    solve(&t, SSV_FULL_REVERSE, 0.01, angle);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, exact, profile.duration_s);
    TEST_ASSERT_DOUBLE_WITHIN(5e-6, 2.26669, profile.duration_s); // model check value, to its digits
    TEST_ASSERT_DOUBLE_WITHIN(5e-5, 27.2003, profile.impulse_Ns);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, w_t * sqrt(x2), profile.peak_speed);
}

static void test_leg_without_drag_speeds_up_and_brakes_at_constant_rate(void) {
    const ssv_thrusts_t t = {{10, 5, 0, -10, 2, 1}, {0}, {0}, FORCE};
    solve(&t, SSV_FULL_REVERSE, 0.001, 2.5);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 2 * sqrt(2.5 / 0.6), profile.duration_s); // a = 6 N / 10 kg
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, sqrt(2.5 * 0.6), profile.peak_speed);
    TEST_ASSERT_EQUAL_INT(2, profile.num_arcs);
}

static void test_drag_only_ramp_gives_no_thrust_above_its_cutoff_and_full_reverse_below(void) {
    const ssv_thrusts_t t = straight();
    solve(&t, SSV_DRAG_ONLY, 0.001, 3.476);
    const ssv_arc_t* coast = &profile.arc[profile.num_arcs - 2];
    const ssv_arc_t* brake = &profile.arc[profile.num_arcs - 1];
    double c[3];
    ssv_arc_thrust(&t, coast, 0, c);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0, fabs(c[0]) + fabs(c[1]) + fabs(c[2]));
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 0.001, coast->v_end);
    // The coast is an exponential decay from terminal speed.
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, MASS / DRAG * log(2 * FORCE / DRAG / 0.001), coast->duration_s);
    ssv_arc_thrust(&t, brake, 0, c);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -FORCE, c[0]);
    TEST_ASSERT_EQUAL_DOUBLE(0, brake->v_end);
}

static void test_drag_only_needs_less_impulse_and_more_time_than_full_reverse(void) {
    const ssv_thrusts_t t = turning();
    solve(&t, SSV_FULL_REVERSE, 0.01, 1.5);
    const double time = profile.duration_s, impulse = profile.impulse_Ns;
    solve(&t, SSV_DRAG_ONLY, 0.01, 1.5);
    TEST_ASSERT_TRUE(profile.duration_s > time && profile.impulse_Ns < impulse);
}

static void test_arcs_join_in_time_speed_and_distance_and_cover_the_leg(void) {
    const ssv_thrusts_t t = {{30, -25, 4, 9, 0, -2}, {210, -190, 15, 0, 3, 1}, {40, 0, -60, 25, 9, 0}, FORCE};
    static const double stroke[] = {1e-6, 1e-3, 0.02, 0.5, 20};
    for (int k = 0; k < 5; k++) {
        for (int ramp = SSV_FULL_REVERSE; ramp <= SSV_DRAG_ONLY; ramp++) {
            solve(&t, (ssv_ramp_t)ramp, 0.001, stroke[k]);
            double time = 0, distance = 0, speed = 0;
            for (int i = 0; i < profile.num_arcs; i++) {
                const ssv_arc_t* p = &profile.arc[i];
                TEST_ASSERT_DOUBLE_WITHIN(1e-9 * profile.duration_s, time, p->t_s);
                TEST_ASSERT_DOUBLE_WITHIN(1e-9 * stroke[k], distance, p->s);
                TEST_ASSERT_EQUAL_DOUBLE(speed, p->v_start);
                TEST_ASSERT_DOUBLE_WITHIN(1e-9 * profile.peak_speed, p->v_end, ssv_arc_speed(p, p->duration_s));
                time += p->duration_s;
                distance += ssv_arc_moments(p, p->v_start, p->v_end, p->duration_s).distance;
                speed = p->v_end;
            }
            TEST_ASSERT_EQUAL_DOUBLE(0, speed);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9 * stroke[k], stroke[k], distance);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9 * time, time, profile.duration_s);
        }
    }
}

// The largest acceleration on one side that every thruster can give at a
// speed, |accel a + linear v + quadratic v^2| <= force_max.
static double acceleration(const ssv_thrusts_t* t, double v, bool up) {
    double most = INFINITY;
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        const double hold = v * (t->linear[i] + t->quadratic[i] * v), along = t->accel[i] < 0 ? -hold : hold;
        if (t->accel[i] != 0) most = fmin(most, (t->force_max_N + (up ? -along : along)) / fabs(t->accel[i]));
    }
    return most;
}

// Time of full thrust to the cap, the cap, and full reverse, by the midpoint rule over the speed.
static double capped_time(const ssv_thrusts_t* t, double cap, double distance) {
    enum { STEPS = 20000 };
    double time = 0, covered = 0;
    for (int n = 0; n < STEPS; n++) {
        const double v = cap * (n + 0.5) / STEPS;
        const double dt = cap / STEPS * (1 / acceleration(t, v, true) + 1 / acceleration(t, v, false));
        time += dt;
        covered += v * dt;
    }
    TEST_ASSERT_TRUE(covered < distance); // or the cap would not bind
    return time + (distance - covered) / cap;
}

static void test_a_capped_leg_never_passes_its_cap_and_takes_the_time_of_a_quadrature(void) {
    const ssv_thrusts_t legs[] = {
        straight(), turning(), {{30, -25, 4, 9, 0, -2}, {210, -190, 15, 0, 3, 1}, {40, 0, -60, 25, 9, 0}, FORCE}};
    static const double share[] = {0.9, 0.5, 0.1, 0.01};
    for (int k = 0; k < 3; k++) {
        solve(&legs[k], SSV_FULL_REVERSE, 0.001, 3);
        const double free_time = profile.duration_s, free_peak = profile.peak_speed;
        for (int n = 0; n < 4; n++) {
            const double cap = share[n] * free_peak, exact = capped_time(&legs[k], cap, 3);
            // Once without a price on thrust, which is the same motion: full thrust is optimal then.
            for (int ramp = SSV_FULL_REVERSE; ramp <= SSV_OPTIMAL; ramp += SSV_OPTIMAL - SSV_FULL_REVERSE) {
                const ssv_rule_t rule = {.ramp = (ssv_ramp_t)ramp, .weight_time_per_s = 1, .speed_max = cap};
                TEST_ASSERT_EQUAL_INT(SSV_FEASIBLE, ssv_profile_solve(&legs[k], &rule, 3, &profile));
                TEST_ASSERT_EQUAL_DOUBLE(cap, profile.peak_speed);
                // The rule's error is the second derivative over 24 times the square of a step: below 1e-8 of the time.
                TEST_ASSERT_DOUBLE_WITHIN(1e-7 * exact, exact, profile.duration_s);
                TEST_ASSERT_TRUE(profile.duration_s > free_time);
            }
        }
    }
}

static double price_of(const ssv_thrusts_t* thrusts, const ssv_rule_t* rule, double distance) {
    const ssv_profile_price_t price = ssv_profile_price(thrusts, rule, distance);
    TEST_ASSERT_EQUAL_INT(SSV_FEASIBLE, price.outcome);
    TEST_ASSERT_TRUE(rule->speed_max == 0 || price.peak_speed <= rule->speed_max);
    return rule->weight_time_per_s * price.duration_s + rule->weight_impulse_per_Ns * price.impulse_Ns;
}

static void test_a_capped_optimal_leg_costs_more_the_lower_its_cap_and_never_more_than_full_thrust(void) {
    const ssv_thrusts_t legs[] = {
        straight(), turning(), {{30, -25, 4, 9, 0, -2}, {210, -190, 15, 0, 3, 1}, {40, 0, -60, 25, 9, 0}, FORCE}};
    static const double weight[] = {0, 0.03, 1}, distance[] = {0.02, 0.5, 10};
    for (int n = 0; n < 27; n++) {
        const ssv_thrusts_t* t = &legs[n % 3];
        const double D = distance[n / 9];
        ssv_rule_t rule = {.ramp = SSV_OPTIMAL, .weight_time_per_s = 1, .weight_impulse_per_Ns = weight[n / 3 % 3]};
        TEST_ASSERT_EQUAL_INT(SSV_FEASIBLE, ssv_profile_solve(t, &rule, D, &profile));
        const double free_peak = profile.peak_speed;
        double cheaper = price_of(t, &rule, D);
        for (int k = 0; k < 20; k++) {
            rule.speed_max = free_peak * (1.2 - 0.06 * k);
            const double price = price_of(t, &rule, D);
            // A short leg ends its search a hundred-thousandth short of the best peak; in the price that is its square.
            TEST_ASSERT_TRUE(price >= cheaper * (1 - 1e-9));
            if (rule.speed_max >= free_peak) TEST_ASSERT_DOUBLE_WITHIN(1e-9 * cheaper, cheaper, price);
            ssv_rule_t full = rule;
            full.ramp = SSV_FULL_REVERSE;
            TEST_ASSERT_TRUE(price <= price_of(t, &full, D) * (1 + 1e-9));
            cheaper = price;
        }
        TEST_ASSERT_TRUE(cheaper > price_of(t,
                                            &(ssv_rule_t){.ramp = SSV_OPTIMAL,
                                                          .weight_time_per_s = 1,
                                                          .weight_impulse_per_Ns = rule.weight_impulse_per_Ns},
                                            D));
    }
}

static void test_leg_that_no_thruster_acts_on_has_no_authority(void) {
    const ssv_thrusts_t t = {{0}, {0}, {0}, FORCE};
    TEST_ASSERT_EQUAL_INT(SSV_NO_AUTHORITY,
                          ssv_profile_solve(&t, &(ssv_rule_t){.ramp = SSV_FULL_REVERSE, .cutoff = 0.001}, 1, &profile));
}

static void test_drag_only_is_refused_where_least_thrust_does_not_slow_the_body(void) {
    // One thruster idles at a = 0 and weighs more than the rest together: least thrust holds the speed.
    const ssv_thrusts_t t = {{100, 1, 1}, {0, 1, 1}, {0}, FORCE};
    TEST_ASSERT_EQUAL_INT(SSV_NO_AUTHORITY,
                          ssv_profile_solve(&t, &(ssv_rule_t){.ramp = SSV_DRAG_ONLY, .cutoff = 0.001}, 1, &profile));
    TEST_ASSERT_EQUAL_INT(SSV_FEASIBLE,
                          ssv_profile_solve(&t, &(ssv_rule_t){.ramp = SSV_FULL_REVERSE, .cutoff = 0.001}, 1, &profile));
}

static void test_leg_longer_than_the_longest_plan_is_too_long(void) {
    const ssv_thrusts_t t = straight();
    TEST_ASSERT_EQUAL_INT(
        SSV_TOO_LONG, ssv_profile_solve(&t, &(ssv_rule_t){.ramp = SSV_FULL_REVERSE, .cutoff = 0.001}, 600, &profile));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_straight_leg_takes_the_time_of_the_exact_solution_with_linear_drag);
    RUN_TEST(test_quarter_turn_takes_the_time_of_the_exact_solution_with_quadratic_drag);
    RUN_TEST(test_leg_without_drag_speeds_up_and_brakes_at_constant_rate);
    RUN_TEST(test_drag_only_ramp_gives_no_thrust_above_its_cutoff_and_full_reverse_below);
    RUN_TEST(test_drag_only_needs_less_impulse_and_more_time_than_full_reverse);
    RUN_TEST(test_arcs_join_in_time_speed_and_distance_and_cover_the_leg);
    RUN_TEST(test_a_capped_leg_never_passes_its_cap_and_takes_the_time_of_a_quadrature);
    RUN_TEST(test_a_capped_optimal_leg_costs_more_the_lower_its_cap_and_never_more_than_full_thrust);
    RUN_TEST(test_leg_that_no_thruster_acts_on_has_no_authority);
    RUN_TEST(test_drag_only_is_refused_where_least_thrust_does_not_slow_the_body);
    RUN_TEST(test_leg_longer_than_the_longest_plan_is_too_long);
    return UNITY_END();
}
