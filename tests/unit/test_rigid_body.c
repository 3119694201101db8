// The physics that judges plans, against closed forms, conservation laws and brute-force quadrature.
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "physics/rigid_body.h"
#include "unity.h"

#define COUNT_OF(a) (sizeof(a) / sizeof(a)[0])
#define PI 3.14159265358979323846

static const double ZERO[6];

void setUp(void) {}
void tearDown(void) {}

static rb_body_t plain_body(void) {
    const rb_body_t body = {.mass_kg = 76.2, .inertia_kg_m2 = {2.7, 2.7, 2.7}};
    return body;
}

/// Three unequal axes in everything, no drag.
static rb_body_t lopsided_body(void) {
    const rb_body_t body = {.mass_kg = 10, .inertia_kg_m2 = {1, 2.5, 3}, .added_mass_kg = {2, 9, 14}};
    return body;
}

static rb_body_t tube(double strip_kg_m2) {
    const rb_body_t body = {
        .mass_kg = 11.3636, .inertia_kg_m2 = {8.81, 8.81, 0.0376}, .strip_kg_m2 = strip_kg_m2, .length_m = 3.048};
    return body;
}

static rb_state_t at_rest(void) {
    const rb_state_t state = {{{0, 0, 0}, {1, 0, 0, 0}}, {0}};
    return state;
}

static void run(const rb_craft_t* craft, rb_state_t* state, const double tau[6], double duration_s, int steps) {
    for (int i = 0; i < steps; i++) {
        rb_step(craft, state, tau, tau, duration_s / steps);
    }
}

static double dot(const double* a, const double* b, int n) {
    double sum = 0;
    for (int i = 0; i < n; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

static double kinetic_energy(const rb_craft_t* craft, const double nu[6]) {
    double momentum[6];
    rb_momentum(craft, nu, momentum);
    return dot(nu, momentum, 6) / 2;
}

/// Momentum in {n}: [P; H about the origin of {n}].
static void world_momentum(const rb_craft_t* craft, const rb_state_t* state, double world[6]) {
    double momentum[6], lever[3];
    rb_momentum(craft, state->nu, momentum);
    rb_rotate(state->eta.q, momentum, world);
    rb_rotate(state->eta.q, momentum + 3, world + 3);
    rb_cross(state->eta.p_m, world, lever);
    for (int i = 0; i < 3; i++) {
        world[3 + i] += lever[i];
    }
}

static double state_distance(const rb_state_t* a, const rb_state_t* b) {
    double square = 0;
    for (int i = 0; i < 3; i++) {
        square += pow(a->eta.p_m[i] - b->eta.p_m[i], 2);
    }
    for (int i = 0; i < 4; i++) {
        square += pow(a->eta.q[i] - b->eta.q[i], 2);
    }
    for (int i = 0; i < 6; i++) {
        square += pow(a->nu[i] - b->nu[i], 2);
    }
    return sqrt(square);
}

/// Seeded, so that a failure repeats: splitmix64, uniform in [-1, 1).
static uint64_t seed = 20240611;
static double random_number(void) {
    uint64_t z = (seed += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return (double)((z ^ (z >> 31)) >> 11) / (double)(1LL << 52) - 1;
}

static void random_pose(rb_pose_t* pose) {
    double square = 0;
    for (int i = 0; i < 4; i++) {
        pose->q[i] = random_number();
        square += pose->q[i] * pose->q[i];
    }
    for (int i = 0; i < 4; i++) {
        pose->q[i] /= sqrt(square);
    }
    for (int i = 0; i < 3; i++) {
        pose->p_m[i] = 2 * random_number();
    }
}

/// Strips added up one by one (midpoint rule): [force; moment] of the water on a tube.
static void strips_one_by_one(const rb_body_t* body, const double nu[6], double tau[6]) {
    const int n = 200000;
    const double dz = body->length_m / n;
    memset(tau, 0, 6 * sizeof *tau);
    for (int i = 0; i < n; i++) {
        const double place[3] = {0, 0, (i + 0.5) * dz - body->length_m / 2};
        double v[3], moment[3];
        rb_cross(nu + 3, place, v);
        const double vx = v[0] + nu[0], vy = v[1] + nu[1], speed = hypot(vx, vy);
        const double force[3] = {-body->strip_kg_m2 * speed * vx * dz, -body->strip_kg_m2 * speed * vy * dz, 0};
        rb_cross(place, force, moment);
        for (int k = 0; k < 3; k++) {
            tau[k] += force[k];
            tau[3 + k] += moment[k];
        }
    }
}

static void test_speed_under_constant_thrust_and_linear_drag_follows_the_exponential(void) {
    rb_body_t body = plain_body();
    body.drag_lin_kg_s = 413.685;
    rb_craft_t craft;
    rb_craft_alone(&craft, &body);
    rb_state_t state = at_rest();
    const double tau[6] = {12, 0, 0, 0, 0, 0}, t = 0.5, rate = 413.685 / 76.2;
    run(&craft, &state, tau, t, 500);
    // RK4 at h lambda = 0.005: relative error some 1e-12.
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 12 / 413.685 * -expm1(-rate * t), state.nu[0]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 12 / 413.685 * (t + expm1(-rate * t) / rate), state.eta.p_m[0]);
    run(&craft, &state, tau, 10, 1000);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 12 / 413.685, state.nu[0]);
}

static void test_speed_under_constant_thrust_and_quadratic_drag_follows_the_hyperbolic_tangent(void) {
    rb_body_t body = plain_body();
    body.drag_quad_kg_m = 50;
    body.drag_quad_ang_Nm_s2 = 2.2;
    rb_craft_t craft;
    rb_craft_alone(&craft, &body);
    rb_state_t straight = at_rest(), turning = at_rest();
    const double push[6] = {0, 12, 0, 0, 0, 0}, twist[6] = {0, 0, 0, 0, 0, 3.63};
    run(&craft, &straight, push, 5, 5000);
    run(&craft, &turning, twist, 1.5, 3000);
    const double v = sqrt(12.0 / 50), w = sqrt(3.63 / 2.2);
    TEST_ASSERT_DOUBLE_WITHIN(1e-11, v * tanh(12 * 5 / (76.2 * v)), straight.nu[1]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-10, 76.2 / 50 * log(cosh(12 * 5 / (76.2 * v))), straight.eta.p_m[1]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-11, w * tanh(3.63 * 1.5 / (2.7 * w)), turning.nu[5]);
    const double angle = 2.7 / 2.2 * log(cosh(3.63 * 1.5 / (2.7 * w)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-10, angle, 2 * atan2(turning.eta.q[3], turning.eta.q[0]));
}

static void test_drag_opposes_motion_in_any_direction_with_both_terms(void) {
    rb_body_t body = plain_body();
    body.drag_lin_kg_s = 3;
    body.drag_quad_kg_m = 5;
    body.drag_lin_ang_Nm_s = 7;
    body.drag_quad_ang_Nm_s2 = 11;
    rb_craft_t craft;
    rb_craft_alone(&craft, &body);
    const double nu[6] = {2, -3, 6, 1, 4, -8}; // |v| = 7, |w| = 9
    double tau[6];
    rb_drag(&craft, nu, tau);
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, -(3 + 5 * 7) * nu[i], tau[i]);
        TEST_ASSERT_DOUBLE_WITHIN(1e-11, -(7 + 11 * 9) * nu[3 + i], tau[3 + i]);
    }
}

static void test_thrust_that_grows_in_time_moves_the_body_by_the_cubic(void) {
    const rb_body_t body = plain_body();
    rb_craft_t craft;
    rb_craft_alone(&craft, &body);
    rb_state_t state = at_rest();
    const double from[6] = {1, 0, 0, 0, 0, 0}, to[6] = {4, 0, 0, 0, 0, 0};
    rb_step(&craft, &state, from, to, 2); // one step: RK4 integrates a cubic exactly
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, (1 * 2 + 1.5 * 2 * 2 / 2) / 76.2, state.nu[0]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, (1 * 2 * 2 / 2.0 + 1.5 * 2 * 2 * 2 / 6) / 76.2, state.eta.p_m[0]);
}

static void test_thrusters_make_force_and_moment_about_the_vehicle(void) {
    const rb_thruster_t thruster[2] = {{{0.3, 0, 0}, {0, 1, 0}}, {{0, 0.2, 0.1}, {0, 0, -1}}};
    const double u_N[2] = {5, -2}, expected[6] = {0, 5, 2, 0.4, 0, 1.5};
    double tau[6];
    rb_thrust(2, thruster, u_N, tau);
    for (int i = 0; i < 6; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-15, expected[i], tau[i]);
    }
}

static void test_free_tumbling_in_water_conserves_energy_and_both_impulses(void) {
    const rb_body_t body = lopsided_body();
    rb_craft_t craft;
    rb_craft_alone(&craft, &body);
    rb_state_t state = {{{1, 2, 3}, {1, 0, 0, 0}}, {0.5, -0.4, 0.3, 0.7, -1.1, 0.2}};
    double before[6], after[6];
    world_momentum(&craft, &state, before);
    const double energy = kinetic_energy(&craft, state.nu);
    run(&craft, &state, ZERO, 60, 60000);
    world_momentum(&craft, &state, after);
    // 60 s at 1 ms: fourth-order drift stays below 1e-9 of values near 10.
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, energy, kinetic_energy(&craft, state.nu));
    for (int i = 0; i < 6; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, before[i], after[i]);
    }
}

static void test_joined_bodies_conserve_energy_and_both_impulses_at_any_relative_pose(void) {
    rb_body_t first = lopsided_body(), second = tube(0);
    second.added_mass_kg[0] = second.added_mass_kg[1] = 35;
    for (int trial = 0; trial < 5; trial++) {
        rb_pose_t X_b;
        random_pose(&X_b);
        rb_craft_t craft;
        rb_craft_joined(&craft, &first, &second, &X_b);
        rb_state_t state = at_rest();
        random_pose(&state.eta);
        for (int i = 0; i < 6; i++) {
            state.nu[i] = 0.5 * random_number();
        }
        double before[6], after[6];
        world_momentum(&craft, &state, before);
        const double energy = kinetic_energy(&craft, state.nu);
        run(&craft, &state, ZERO, 20, 20000);
        world_momentum(&craft, &state, after);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, energy, kinetic_energy(&craft, state.nu));
        for (int i = 0; i < 6; i++) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-8, before[i], after[i]);
        }
    }
}

static void test_a_body_drifting_askew_feels_the_munk_moment(void) {
    const rb_body_t body = lopsided_body();
    rb_craft_t craft;
    rb_craft_alone(&craft, &body);
    const double nu[6] = {0.5, 0.2, 0, 0, 0, 0};
    double rate[6];
    rb_acceleration(&craft, nu, ZERO, rate);
    // N = -(m_y - m_x) u v, in the classical form; added masses 2 and 9.
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, -(9 - 2) * 0.5 * 0.2 / 3, rate[5]);
}

static void test_a_spinning_top_precesses_at_the_closed_form_rate(void) {
    const rb_body_t body = {.mass_kg = 5, .inertia_kg_m2 = {2, 2, 3}};
    rb_craft_t craft;
    rb_craft_alone(&craft, &body);
    rb_state_t state = at_rest();
    state.nu[3] = 0.3;
    state.nu[5] = 2;
    const double rate = (3 - 2) / 2.0 * 2, t = 7;
    run(&craft, &state, ZERO, t, 7000);
    TEST_ASSERT_DOUBLE_WITHIN(1e-11, 0.3 * cos(rate * t), state.nu[3]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-11, 0.3 * sin(rate * t), state.nu[4]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-13, 2, state.nu[5]);
}

static void test_a_pair_spins_about_its_own_centre_of_mass(void) {
    const rb_body_t vehicle = plain_body(), beam = tube(0);
    const rb_pose_t X_SB = {{0.3025, -1.524, 0}, {sqrt(0.5), -sqrt(0.5), 0, 0}};
    rb_craft_t pair;
    rb_craft_joined(&pair, &vehicle, &beam, &X_SB);
    const double share = 11.3636 / (76.2 + 11.3636), c[3] = {share * 0.3025, share * -1.524, 0}, w = 0.4;
    rb_state_t state = at_rest();
    // The centre stands still: v = -w x c. A tube about a transverse axis, here z of the vehicle, is a principal axis.
    state.nu[5] = w;
    state.nu[0] = w * c[1];
    state.nu[1] = -w * c[0];
    double momentum[6];
    rb_momentum(&pair, state.nu, momentum);
    const double reduced_kg = 76.2 * share, span2 = 0.3025 * 0.3025 + 1.524 * 1.524;
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0, momentum[0]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0, momentum[1]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, w * (2.7 + 8.81 + reduced_kg * span2), momentum[5]); // parallel axes
    run(&pair, &state, ZERO, 2 * PI / w, 5000);
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0, state.eta.p_m[i]); // once round, home again
    }
    run(&pair, &state, ZERO, PI / w, 2500);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 2 * c[0], state.eta.p_m[0]); // half round: across the centre
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 2 * c[1], state.eta.p_m[1]);
}

static void test_halving_the_step_divides_the_error_by_sixteen(void) {
    rb_body_t first = lopsided_body(), second = tube(5);
    first.drag_lin_kg_s = 20;
    first.drag_quad_ang_Nm_s2 = 1;
    rb_pose_t X_b = {{0.3, -1.5, 0.1}, {0.5, -0.5, 0.5, 0.5}};
    rb_craft_t craft;
    rb_craft_joined(&craft, &first, &second, &X_b);
    const double tau[6] = {5, -3, 4, 1, -2, 0.5};
    rb_state_t state[4];
    static const int steps[4] = {100, 200, 400, 6400};
    for (size_t i = 0; i < COUNT_OF(state); i++) {
        // Well away from rest, so that no strip passes through zero speed, where drag has a kink in its second
        // derivative.
        state[i] = at_rest();
        state[i].nu[0] = 0.8;
        state[i].nu[2] = -0.9;
        run(&craft, &state[i], tau, 2, steps[i]);
    }
    const double coarse = state_distance(&state[0], &state[3]), middle = state_distance(&state[1], &state[3]),
                 fine = state_distance(&state[2], &state[3]);
    TEST_ASSERT_DOUBLE_WITHIN(0.3, 4, log2(coarse / middle));
    TEST_ASSERT_DOUBLE_WITHIN(0.3, 4, log2(middle / fine));
}

static void test_attitude_stays_a_unit_quaternion_over_many_turns(void) {
    const rb_body_t body = plain_body();
    rb_craft_t craft;
    rb_craft_alone(&craft, &body);
    rb_state_t state = at_rest();
    state.nu[3] = 3;
    run(&craft, &state, ZERO, 100, 10000);
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 1, dot(state.eta.q, state.eta.q, 4));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, fabs(cos(150)), fabs(state.eta.q[0]));
}

static void test_broadside_drag_of_a_tube_has_its_closed_form(void) {
    const double k = 66.66, length = 3.048;
    const rb_body_t body = tube(k);
    rb_craft_t craft;
    rb_craft_alone(&craft, &body);
    const double nu[6] = {0.3, -0.4, 5, 0, 0, 7}; // neither motion along the axis nor spin about it matters
    double tau[6];
    rb_drag(&craft, nu, tau);
    const double expected[6] = {-k * length * 0.5 * 0.3, k * length * 0.5 * 0.4, 0, 0, 0, 0};
    for (int i = 0; i < 6; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, expected[i], tau[i]);
    }
}

static void test_drag_of_a_tube_turning_about_its_middle_has_its_closed_form(void) {
    const double k = 66.66, length = 3.048, w = 0.35;
    const rb_body_t body = tube(k);
    rb_craft_t craft;
    rb_craft_alone(&craft, &body);
    const double nu[6] = {0, 0, 0, 0.6 * w, 0.8 * w, 0}, moment = k * w * w * pow(length, 4) / 32;
    double tau[6];
    rb_drag(&craft, nu, tau);
    const double expected[6] = {0, 0, 0, -0.6 * moment, -0.8 * moment, 0};
    for (int i = 0; i < 6; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, expected[i], tau[i]);
    }
}

static void test_drag_of_a_tube_that_sweeps_in_a_plane_has_its_closed_form(void) {
    // Strips move along x at v + w z. Where that changes sign, at z = -v/w, within the tube or not, |.| splits the
    // integral.
    const double k = 10, h = 1.5, w = 0.4;
    rb_body_t body = tube(k);
    body.length_m = 2 * h;
    rb_craft_t craft;
    rb_craft_alone(&craft, &body);
    static const double speeds[] = {0.1, 0.59, 0.6, 0.61, 2, 2.39, 2.41, 10};
    for (size_t i = 0; i < COUNT_OF(speeds); i++) {
        const double v = speeds[i], nu[6] = {v, 0, 0, 0, w, 0}, far = v + w * h, near = v - w * h;
        double tau[6];
        rb_drag(&craft, nu, tau);
        // With s = v + w z the strip's speed: the integrals of s |s| ds / w and (s - v) s |s| ds / w^2.
        const double force = -k / w * (pow(far, 3) - pow(fabs(near), 3)) / 3;
        const double moment =
            -k / (w * w) * (pow(far, 3) * (far / 4 - v / 3) - pow(fabs(near), 3) * (near / 4 - v / 3));
        char label[40];
        snprintf(label, sizeof label, "v = %g", v);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-11 * fabs(force), force, tau[0], label);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-11 * fabs(force), moment, tau[4], label);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-12, 0, fabs(tau[1]) + fabs(tau[2]) + fabs(tau[3]) + fabs(tau[5]), label);
    }
}

static void test_drag_of_a_tube_in_any_motion_is_the_sum_of_its_strips(void) {
    const rb_body_t body = tube(66.66);
    rb_craft_t craft;
    rb_craft_alone(&craft, &body);
    for (int trial = 0; trial < 40; trial++) {
        // From nearly pure turning to nearly pure drifting, over either form of the integral and the seam between them.
        const double ratio = pow(10, 3 * random_number());
        double nu[6], exact[6], tau[6];
        for (int i = 0; i < 6; i++) {
            nu[i] = random_number() * (i < 3 ? ratio : 1) / fmax(ratio, 1);
        }
        strips_one_by_one(&body, nu, exact);
        rb_drag(&craft, nu, tau);
        const double scale = sqrt(dot(exact, exact, 6));
        char label[40];
        snprintf(label, sizeof label, "trial %d", trial);
        for (int i = 0; i < 6; i++) {
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9 * scale, exact[i], tau[i], label); // the midpoint rule's own error
        }
    }
}

static void test_drag_of_a_carried_tube_is_that_of_its_own_motion_moved_to_the_vehicle(void) {
    const rb_body_t vehicle = plain_body(), beam = tube(66.66);
    rb_pose_t X_SB;
    random_pose(&X_SB);
    rb_craft_t pair, alone;
    rb_craft_joined(&pair, &vehicle, &beam, &X_SB);
    rb_craft_alone(&alone, &beam);
    const double nu[6] = {0.1, -0.2, 0.05, 0.2, 0.1, -0.3};
    double tau[6], nu_B[6], tau_B[6], sweep[3], force[3], moment[3], lever[3];
    rb_drag(&pair, nu, tau);
    rb_cross(nu + 3, X_SB.p_m, sweep);
    for (int i = 0; i < 3; i++) {
        sweep[i] += nu[i];
    }
    rb_rotate_back(X_SB.q, sweep, nu_B);
    rb_rotate_back(X_SB.q, nu + 3, nu_B + 3);
    rb_drag(&alone, nu_B, tau_B);
    rb_rotate(X_SB.q, tau_B, force);
    rb_rotate(X_SB.q, tau_B + 3, moment);
    rb_cross(X_SB.p_m, force, lever);
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-13, force[i], tau[i]);
        TEST_ASSERT_DOUBLE_WITHIN(1e-13, moment[i] + lever[i], tau[3 + i]);
    }
    // The same power by either account.
    TEST_ASSERT_DOUBLE_WITHIN(1e-13, dot(nu_B, tau_B, 6), dot(nu, tau, 6));
}

static void test_a_plastic_mate_conserves_momentum_and_loses_energy(void) {
    const rb_body_t vehicle = plain_body(), beam = tube(66.66);
    rb_pose_t X_SB;
    random_pose(&X_SB);
    rb_craft_t alone, pair;
    rb_craft_alone(&alone, &vehicle);
    rb_craft_joined(&pair, &vehicle, &beam, &X_SB);
    rb_state_t state = {{{1, 2, 3}, {0.5, 0.5, -0.5, 0.5}}, {0.02, -0.03, 0.01, 0.1, 0.05, -0.2}};
    double before[6], after[6], momentum[6];
    world_momentum(&alone, &state, before); // the beam rests: it has none
    const double energy = kinetic_energy(&alone, state.nu);
    rb_momentum(&alone, state.nu, momentum);
    rb_velocity(&pair, momentum, state.nu);
    world_momentum(&pair, &state, after);
    for (int i = 0; i < 6; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-13, before[i], after[i]);
    }
    TEST_ASSERT_TRUE(kinetic_energy(&pair, state.nu) < energy);
}

static void test_a_plastic_mate_head_on_shares_the_speed_by_mass(void) {
    const rb_body_t vehicle = plain_body(), beam = tube(0);
    const rb_pose_t X_SB = {{0.3631, 0, 0}, {1, 0, 0, 0}};
    rb_craft_t alone, pair;
    rb_craft_alone(&alone, &vehicle);
    rb_craft_joined(&pair, &vehicle, &beam, &X_SB);
    const double nu[6] = {0.1, 0, 0, 0, 0, 0};
    double momentum[6], together[6];
    rb_momentum(&alone, nu, momentum);
    rb_velocity(&pair, momentum, together);
    const double expected[6] = {0.1 * 76.2 / (76.2 + 11.3636), 0, 0, 0, 0, 0};
    for (int i = 0; i < 6; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-15, expected[i], together[i]);
    }
}

static void test_velocity_is_the_inverse_of_momentum(void) {
    const rb_body_t first = lopsided_body(), second = tube(0);
    for (int trial = 0; trial < 20; trial++) {
        rb_pose_t X_b;
        random_pose(&X_b);
        rb_craft_t craft;
        rb_craft_joined(&craft, &first, &second, &X_b);
        double nu[6], momentum[6], again[6];
        for (int i = 0; i < 6; i++) {
            nu[i] = random_number();
        }
        rb_momentum(&craft, nu, momentum);
        rb_velocity(&craft, momentum, again);
        for (int i = 0; i < 6; i++) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, nu[i], again[i]);
        }
    }
}

static void test_relative_pose_undoes_composition(void) {
    rb_pose_t X_ab, X_bc;
    random_pose(&X_ab);
    random_pose(&X_bc);
    const rb_pose_t X_ac = rb_compose(&X_ab, &X_bc), again = rb_relative(&X_ab, &X_ac);
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-14, X_bc.p_m[i], again.p_m[i]);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 1, fabs(dot(X_bc.q, again.q, 4)));
    // A quarter turn about z takes x to y.
    const double q[4] = {sqrt(0.5), 0, 0, sqrt(0.5)}, x[3] = {1, 0, 0};
    double y[3];
    rb_rotate(q, x, y);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 1, y[1]);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_speed_under_constant_thrust_and_linear_drag_follows_the_exponential);
    RUN_TEST(test_speed_under_constant_thrust_and_quadratic_drag_follows_the_hyperbolic_tangent);
    RUN_TEST(test_drag_opposes_motion_in_any_direction_with_both_terms);
    RUN_TEST(test_thrust_that_grows_in_time_moves_the_body_by_the_cubic);
    RUN_TEST(test_thrusters_make_force_and_moment_about_the_vehicle);
    RUN_TEST(test_free_tumbling_in_water_conserves_energy_and_both_impulses);
    RUN_TEST(test_joined_bodies_conserve_energy_and_both_impulses_at_any_relative_pose);
    RUN_TEST(test_a_body_drifting_askew_feels_the_munk_moment);
    RUN_TEST(test_a_spinning_top_precesses_at_the_closed_form_rate);
    RUN_TEST(test_a_pair_spins_about_its_own_centre_of_mass);
    RUN_TEST(test_halving_the_step_divides_the_error_by_sixteen);
    RUN_TEST(test_attitude_stays_a_unit_quaternion_over_many_turns);
    RUN_TEST(test_broadside_drag_of_a_tube_has_its_closed_form);
    RUN_TEST(test_drag_of_a_tube_turning_about_its_middle_has_its_closed_form);
    RUN_TEST(test_drag_of_a_tube_that_sweeps_in_a_plane_has_its_closed_form);
    RUN_TEST(test_drag_of_a_tube_in_any_motion_is_the_sum_of_its_strips);
    RUN_TEST(test_drag_of_a_carried_tube_is_that_of_its_own_motion_moved_to_the_vehicle);
    RUN_TEST(test_a_plastic_mate_conserves_momentum_and_loses_energy);
    RUN_TEST(test_a_plastic_mate_head_on_shares_the_speed_by_mass);
    RUN_TEST(test_velocity_is_the_inverse_of_momentum);
    RUN_TEST(test_relative_pose_undoes_composition);
    return UNITY_END();
}
