// The simulated world as a whole: closed forms, conservation step by step, mate and dock, same seed same bits, and what
// a step costs. The last test prints its cost.
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "physics/world.h"
#include "unity.h"

#define COUNT_OF(a) (sizeof(a) / sizeof(a)[0])
#define PI 3.14159265358979323846
#define HULL_M 0.3025
#define STANDOFF_M 0.3631
#define GRAVITY_M_S2 9.80665
#define STEP_S 0.005

static const double NO_THRUST[SIM_THRUSTERS];

static sim_world_t world;

void setUp(void) {}
void tearDown(void) {}

/// Vehicle and beam of the case study, thrusters on the hull, all disturbances off; the vehicle looks at the beam's
/// middle from where it mates, the beam stands upright at x = STANDOFF_M.
static sim_world_config_t calm(void) {
    sim_world_config_t config = {
        .vehicle = {.mass_kg = 76.2,
                    .inertia_kg_m2 = {2.7, 2.7, 2.7},
                    .drag_lin_kg_s = 413.685,
                    .drag_quad_ang_Nm_s2 = 2.2},
        .beam = {.mass_kg = 11.3636, .inertia_kg_m2 = {8.81, 8.81, 0.0376}, .strip_kg_m2 = 66.66, .length_m = 3.048},
        .X_nb = {{0, 0, 0}, {1, 0, 0, 0}},
        .X_nB = {{STANDOFF_M, 0, 0}, {1, 0, 0, 0}},
    };
    static const int axis[3] = {2, 0, 1}, push[3] = {0, 1, 2};
    for (int t = 0; t < SIM_THRUSTERS; t++) {
        const double sign = t % 2 == 0 ? 1 : -1;
        config.thruster[t].r_m[axis[t / 2]] = sign * HULL_M;
        config.thruster[t].n[push[t / 2]] = sign;
    }
    return config;
}

/// Where a vehicle at the origin that looks along x finds the beam of `calm`.
static sim_mate_place_t place_of_calm(void) {
    const sim_mate_place_t place = {STANDOFF_M, 0, PI};
    return place;
}

static void disturb(sim_world_config_t* config) {
    const sim_water_config_t water = {
        .mean_n_m_s = {0.002, 0, -0.001}, .wander_m_s = {0.005, 0.005, 0.005}, .wander_time_s = 60};
    config->water = water;
    config->thrusters.gain_spread = 0.05;
    config->thrusters.lag_s = 0.2;
    config->thrusters.dead_band = 0.05;
    config->thrusters.quantum = 0.01;
    config->thrusters.force_forward_max_N = config->thrusters.force_reverse_max_N = 6;
    config->navigation.rate_Hz = 10;
    config->navigation.delay_s = 0.15;
    config->navigation.dropout = 0.1;
    config->navigation.position_m.white = 0.005;
    config->navigation.attitude_rad.white = 0.0087;
    config->navigation.position_m.walk_sqrt_s = 1e-4;
}

static void begin(const sim_world_config_t* config, uint64_t seed) {
    const char* fault = sim_world_init(&world, config, seed);
    TEST_ASSERT_TRUE_MESSAGE(fault == NULL, fault);
}

static void wiggle(int step, double command[SIM_THRUSTERS]) {
    for (int t = 0; t < SIM_THRUSTERS; t++) {
        command[t] = 5 * sin(0.003 * step * (t + 1));
    }
}

static void test_speed_behind_a_lagging_thruster_follows_the_closed_form(void) {
    sim_world_config_t config = calm();
    config.thrusters.lag_s = 0.2;
    begin(&config, 1);
    const double both_x[SIM_THRUSTERS] = {6, -6}, rate = 413.685 / 76.2, lag = 1 / 0.2, terminal = 12 / 413.685;
    for (int i = 0; i < 200; i++) {
        sim_world_step(&world, both_x, STEP_S);
    }
    // m v' + c v = F (1 - exp(-t / tau))
    const double t = 1, fast = exp(-rate * t), slow = exp(-lag * t);
    const double v = terminal * (1 - fast - rate / (rate - lag) * (slow - fast));
    const double x = terminal * (t - (1 - fast) / rate - rate / (rate - lag) * ((1 - slow) / lag - (1 - fast) / rate));
    // RK4 at 5 ms and rates near 5 /s: some 1e-9 relative.
    TEST_ASSERT_DOUBLE_WITHIN(1e-10, v, world.state.nu[0]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-10, x, world.state.eta.p_m[0]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 12 * (1 - 0.2 * (1 - slow)), world.impulse_Ns); // Simpson's rule
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1, world.t_s);
}

static void test_a_vehicle_left_alone_drifts_with_the_current(void) {
    sim_world_config_t config = calm();
    config.water.mean_n_m_s[0] = 0.01;
    config.water.mean_n_m_s[2] = -0.02;
    config.X_nb.q[0] = 0.5;
    config.X_nb.q[1] = config.X_nb.q[2] = config.X_nb.q[3] = 0.5;
    begin(&config, 1);
    for (int i = 0; i < 400; i++) {
        sim_world_step(&world, NO_THRUST, STEP_S);
    }
    const double rate = 413.685 / 76.2, t = 2, drifted = t + expm1(-rate * t) / rate;
    static const double current[3] = {0.01, 0, -0.02};
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-10, current[i] * drifted, world.state.eta.p_m[i]);
    }
    double v_n[3];
    rb_rotate(world.state.eta.q, world.state.nu, v_n);
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-10, current[i] * -expm1(-rate * t), v_n[i]);
    }
}

static void test_a_vehicle_left_alone_follows_a_wandering_current_as_closely_as_its_drag_binds_it(void) {
    enum { STEPS = 40000 };
    sim_world_config_t config = calm();
    const sim_water_config_t water = {.wander_m_s = {0.005, 0.005, 0.005}, .wander_time_s = 60};
    config.water = water;
    begin(&config, 3);
    double variance = 0;
    for (int step = 0; step < STEPS; step++) {
        double current_n[3], v_n[3];
        sim_water_current(&world.water, current_n);
        sim_world_step(&world, NO_THRUST, STEP_S);
        rb_rotate(world.state.eta.q, world.state.nu, v_n);
        for (int i = 0; i < 3; i++) {
            variance += pow(v_n[i] - current_n[i], 2) / (3 * STEPS);
        }
    }
    // The speed through the water takes each jump of the current, of variance q, and decays by e^(-a dt) in each step.
    const double a = 413.685 / 76.2, kept2 = exp(-2 * a * STEP_S), q = 0.005 * 0.005 * 2 * STEP_S / 60;
    const double expected = q * kept2 / (1 - kept2);
    TEST_ASSERT_DOUBLE_WITHIN(4 * sqrt(1 / (3 * STEPS * STEP_S * a)) * expected, expected, variance);
}

static void test_a_flight_in_a_current_is_the_flight_in_still_water_carried_along(void) {
    // Galilei: start with the water's own velocity, and in the water's frame nothing differs. With added mass, thrust
    // and drag of all kinds.
    sim_world_config_t config = calm();
    config.vehicle.added_mass_kg[1] = 40;
    config.vehicle.added_inertia_kg_m2[2] = 1;
    config.vehicle.centre_of_buoyancy_m[2] = 0.01;
    sim_world_t still;
    TEST_ASSERT_NULL(sim_world_init(&still, &config, 1));
    config.water.mean_n_m_s[0] = 0.03;
    config.water.mean_n_m_s[1] = -0.02;
    begin(&config, 1);
    world.state.nu[0] = 0.03;
    world.state.nu[1] = -0.02;
    for (int i = 0; i < 4000; i++) {
        double command[SIM_THRUSTERS];
        wiggle(i, command);
        sim_world_step(&still, command, STEP_S);
        sim_world_step(&world, command, STEP_S);
    }
    const double carried[3] = {0.03 * 20, -0.02 * 20, 0};
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-11, still.state.eta.p_m[i] + carried[i], world.state.eta.p_m[i]);
        TEST_ASSERT_DOUBLE_WITHIN(1e-11, still.state.nu[3 + i], world.state.nu[3 + i]);
    }
}

static void test_a_heavy_body_sinks_at_the_speed_of_its_drag_and_a_light_one_rises(void) {
    for (int sign = -1; sign <= 1; sign += 2) {
        sim_world_config_t config = calm();
        config.vehicle.net_weight_N = sign * 2.0;
        begin(&config, 1);
        for (int i = 0; i < 2000; i++) {
            sim_world_step(&world, NO_THRUST, STEP_S);
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, -sign * 2.0 / 413.685, world.state.nu[2]);
    }
}

static void test_a_body_with_its_buoyancy_above_its_mass_swings_with_the_period_of_a_pendulum(void) {
    sim_world_config_t config = calm();
    config.vehicle.drag_lin_kg_s = config.vehicle.drag_quad_ang_Nm_s2 = 0;
    config.vehicle.added_inertia_kg_m2[0] = 0.6;
    config.vehicle.net_weight_N = 0;
    config.vehicle.centre_of_buoyancy_m[2] = 0.02;
    const double tilt = 1e-4;
    config.X_nb.q[0] = cos(tilt / 2);
    config.X_nb.q[1] = sin(tilt / 2);
    begin(&config, 1);
    const double period_s = 2 * PI * sqrt((2.7 + 0.6) / (76.2 * GRAVITY_M_S2 * 0.02));
    const int steps = 1000; // for 1.25 periods: it hangs straight and turns fastest
    for (int i = 0; i < steps; i++) {
        sim_world_step(&world, NO_THRUST, 1.25 * period_s / steps);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-9 * tilt + 1e-12, 0, world.state.eta.q[1]); // third order in the tilt
    TEST_ASSERT_DOUBLE_WITHIN(1e-8 * tilt, -tilt * 2 * PI / period_s, world.state.nu[3]);
}

static double dot(const double* a, const double* b, int n) {
    double sum = 0;
    for (int i = 0; i < n; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

/// Kinetic energy 0.5 nu' (M + A) nu and momentum in {n}, about the origin of {n}, of what moves through the water.
static double energy_and_momentum(double momentum_n[6]) {
    double current_n[3], current_b[3], nu[6], momentum[6], lever[3], drifted[3];
    sim_water_current(&world.water, current_n);
    rb_rotate_back(world.state.eta.q, current_n, current_b);
    for (int i = 0; i < 3; i++) {
        nu[i] = world.state.nu[i] - current_b[i];
        nu[3 + i] = world.state.nu[3 + i];
        drifted[i] = world.state.eta.p_m[i] - world.t_s * current_n[i];
    }
    rb_momentum(&world.craft, nu, momentum);
    rb_rotate(world.state.eta.q, momentum, momentum_n);
    rb_rotate(world.state.eta.q, momentum + 3, momentum_n + 3);
    rb_cross(drifted, momentum_n, lever);
    for (int i = 0; i < 3; i++) {
        momentum_n[3 + i] += lever[i];
    }
    return dot(nu, momentum, 6) / 2;
}

static void test_every_step_without_forces_keeps_energy_and_momentum_to_a_billionth(void) {
    double worst_energy = 0, worst_momentum = 0;
    for (int trial = 0; trial < 20; trial++) {
        sim_world_config_t config = calm();
        config.vehicle.drag_lin_kg_s = config.vehicle.drag_quad_ang_Nm_s2 = config.beam.strip_kg_m2 = 0;
        const bool pair = trial % 2 == 1, current = trial % 4 >= 2;
        sim_random_t draws;
        sim_random_init(&draws, (uint64_t)trial, 9);
        for (int i = 0; i < 3; i++) {
            config.vehicle.added_mass_kg[i] = 60 * sim_random_uniform(&draws);
            config.vehicle.added_inertia_kg_m2[i] = 2 * sim_random_uniform(&draws);
            config.beam.added_mass_kg[i] = 35 * sim_random_uniform(&draws);
            config.beam.added_inertia_kg_m2[i] = 5 * sim_random_uniform(&draws);
            config.water.mean_n_m_s[i] = current ? 0.05 * sim_random_gauss(&draws) : 0;
        }
        begin(&config, 1);
        if (pair) {
            const sim_mate_place_t place = place_of_calm();
            TEST_ASSERT_EQUAL(SIM_HIT, sim_world_mate(&world, &place).outcome);
        }
        for (int i = 0; i < 6; i++) {
            world.state.nu[i] = (i < 3 ? 0.1 : 0.5) * sim_random_gauss(&draws);
        }
        double before[6], after[6];
        double energy = energy_and_momentum(before);
        const double first = energy;
        for (int step = 0; step < 4000; step++) {
            sim_world_step(&world, NO_THRUST, STEP_S);
            const double now = energy_and_momentum(after);
            worst_energy = fmax(worst_energy, fabs(now / energy - 1));
            for (int i = 0; i < 6; i++) {
                worst_momentum = fmax(worst_momentum, fabs(after[i] - before[i]) / sqrt(dot(before, before, 6)));
            }
            energy = now;
            memcpy(before, after, sizeof before);
        }
        TEST_ASSERT_DOUBLE_WITHIN(4000 * 1e-9, 1, energy / first);
    }
    printf(
        "Without forces, 20 flights of 4,000 steps of 5 ms: the worst step changes energy by %.1e and momentum by %.1e "
        "of "
        "themselves\n",
        worst_energy, worst_momentum);
    TEST_ASSERT_TRUE(worst_energy < 1e-9);
    TEST_ASSERT_TRUE(worst_momentum < 1e-9);
}

static void test_momentum_without_thrust_changes_by_drag_and_by_nothing_else(void) {
    // Linear drag on the vehicle alone, no current: P + c p is conserved at every step.
    sim_world_config_t config = calm();
    config.vehicle.drag_quad_ang_Nm_s2 = 0.5;
    begin(&config, 1);
    const double nu[6] = {0.1, -0.2, 0.15, 0.3, -0.4, 0.5};
    memcpy(world.state.nu, nu, sizeof nu);
    double before[6], after[6];
    energy_and_momentum(before);
    for (int step = 0; step < 2000; step++) {
        const rb_pose_t from = world.state.eta;
        sim_world_step(&world, NO_THRUST, STEP_S);
        energy_and_momentum(after);
        for (int i = 0; i < 3; i++) {
            const double kept = after[i] + 413.685 * (world.state.eta.p_m[i] - from.p_m[i]);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9 * 20, before[i], kept); // of some 20 N s
        }
        memcpy(before, after, sizeof before);
    }
}

static void test_mating_hits_up_to_the_edge_of_every_tolerance_and_a_miss_changes_nothing(void) {
    typedef struct {
        const char* what;
        double y_m, yaw_rad, speed_m_s, rate_rad_s;
        sim_outcome_t outcome;
    } row_t;
    static const row_t row[] = {
        {"perfect", 0, 0, 0, 0, SIM_HIT},
        {"just near enough", 0.0299, 0, 0, 0, SIM_HIT},
        {"just too far", 0.0301, 0, 0, 0, SIM_MISS},
        {"just straight enough", 0, 0.0349, 0, 0, SIM_HIT},
        {"just too askew", 0, 0.0351, 0, 0, SIM_MISS},
        {"just slow enough", 0, 0, 0.0199, 0, SIM_HIT},
        {"just too fast", 0, 0, 0.0201, 0, SIM_MISS},
        {"turns just slowly enough", 0, 0, 0, 0.0499, SIM_HIT},
        {"turns just too fast", 0, 0, 0, 0.0501, SIM_MISS},
        {"all at the edge", 0.0299, -0.0349, -0.0199, -0.0499, SIM_HIT},
        {"far off", 5, 2, 0, 0, SIM_MISS},
    };
    for (size_t i = 0; i < COUNT_OF(row); i++) {
        sim_world_config_t config = calm();
        const sim_arrival_t limit = {0.03, 0.035, 0.02, 0.05};
        config.mate_limit = limit;
        config.X_nb.p_m[1] = row[i].y_m;
        config.X_nb.q[0] = cos(row[i].yaw_rad / 2);
        config.X_nb.q[3] = sin(row[i].yaw_rad / 2);
        begin(&config, 1);
        world.state.nu[2] = row[i].speed_m_s;
        world.state.nu[3] = row[i].rate_rad_s;
        const sim_world_t before = world;
        const sim_mate_place_t place = place_of_calm();
        const sim_attempt_t attempt = sim_world_mate(&world, &place);
        TEST_ASSERT_EQUAL_MESSAGE(row[i].outcome, attempt.outcome, row[i].what);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-14, row[i].y_m, attempt.arrival.position_m, row[i].what);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-14, fabs(row[i].yaw_rad), attempt.arrival.angle_rad, row[i].what);
        TEST_ASSERT_EQUAL_DOUBLE(fabs(row[i].speed_m_s), attempt.arrival.speed_m_s);
        TEST_ASSERT_EQUAL_DOUBLE(fabs(row[i].rate_rad_s), attempt.arrival.rate_rad_s);
        if (row[i].outcome == SIM_HIT) {
            TEST_ASSERT_EQUAL(SIM_BEAM_CARRIED, world.beam);
            TEST_ASSERT_EQUAL(SIM_OUT_OF_TURN, sim_world_mate(&world, &place).outcome);
            // As it lies: the error stays between vehicle and beam.
            const rb_pose_t held = rb_relative(&world.state.eta, &config.X_nB);
            TEST_ASSERT_EQUAL_MEMORY(&held, &world.X_bB, sizeof held);
            TEST_ASSERT_EQUAL_MEMORY(&config.X_nB, &world.X_nB, sizeof config.X_nB);
        } else {
            TEST_ASSERT_EQUAL_MEMORY(&before, &world, sizeof before);
        }
    }
}

static void test_the_mate_shares_the_momentum_and_the_pair_moves_on_as_one(void) {
    sim_world_config_t config = calm();
    config.water.mean_n_m_s[1] = 0.02; // drops out of the balance
    begin(&config, 1);
    world.state.nu[0] = 0.1;
    const sim_mate_place_t place = place_of_calm();
    sim_world_mate(&world, &place);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 0.1 * 76.2 / (76.2 + 11.3636), world.state.nu[0]);
    for (int i = 1; i < 6; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-15, 0, world.state.nu[i]);
    }
    for (int i = 0; i < 1000; i++) {
        double command[SIM_THRUSTERS];
        wiggle(i, command);
        sim_world_step(&world, command, STEP_S);
    }
    const rb_pose_t held = rb_relative(&world.state.eta, &world.X_nB);
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-14, world.X_bB.p_m[i], held.p_m[i]);
    }
    TEST_ASSERT_TRUE(fabs(world.X_nB.p_m[0] - STANDOFF_M) > 0.01);
}

static void test_a_docked_beam_stays_and_the_vehicle_flies_on_alone(void) {
    sim_world_config_t config = calm();
    const sim_arrival_t limit = {0.03, 0.035, 0.02, 0.05};
    config.dock_limit = limit;
    // Contact 2, at the upper end; the port looks down at it.
    sim_port_t port = {2, {STANDOFF_M, 0, 1.524 + 0.0301}, {0, 0, -1}};
    begin(&config, 1);
    TEST_ASSERT_EQUAL(SIM_OUT_OF_TURN, sim_world_dock(&world, &port).outcome);
    const sim_mate_place_t place = place_of_calm();
    sim_world_mate(&world, &place);
    world.state.nu[2] = 0.015;
    const sim_world_t before = world;
    TEST_ASSERT_EQUAL(SIM_MISS, sim_world_dock(&world, &port).outcome);
    TEST_ASSERT_EQUAL_MEMORY(&before, &world, sizeof before);
    port.p_nP_m[2] = 1.524 + 0.0299;
    port.axis_n[1] = sin(0.0351), port.axis_n[2] = -cos(0.0351);
    TEST_ASSERT_EQUAL(SIM_MISS, sim_world_dock(&world, &port).outcome);
    port.axis_n[1] = sin(0.0349), port.axis_n[2] = -cos(0.0349);
    world.state.nu[2] = 0.0201;
    TEST_ASSERT_EQUAL(SIM_MISS, sim_world_dock(&world, &port).outcome);
    world.state.nu[2] = 0.0199;
    const sim_attempt_t attempt = sim_world_dock(&world, &port);
    TEST_ASSERT_EQUAL(SIM_HIT, attempt.outcome);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0299, attempt.arrival.position_m);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0349, attempt.arrival.angle_rad);
    TEST_ASSERT_EQUAL(SIM_BEAM_DOCKED, world.beam);
    TEST_ASSERT_EQUAL(SIM_OUT_OF_TURN, sim_world_dock(&world, &port).outcome);
    TEST_ASSERT_EQUAL(SIM_OUT_OF_TURN, sim_world_mate(&world, &place).outcome);
    const rb_pose_t docked = world.X_nB;
    TEST_ASSERT_EQUAL_DOUBLE(0, world.state.nu[2]); // the latch stopped it
    // Alone again: it backs off at the speed of its own drag, and the beam stays.
    const double back[SIM_THRUSTERS] = {-6, 6};
    for (int i = 0; i < 2000; i++) {
        sim_world_step(&world, back, STEP_S);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -12 / 413.685, world.state.nu[0]);
    TEST_ASSERT_EQUAL_MEMORY(&docked, &world.X_nB, sizeof docked);
}

static void test_substeps_bring_a_long_step_to_the_same_end(void) {
    sim_world_config_t config = calm();
    config.thrusters.lag_s = 0.2;
    double end[2][3], impulse[2];
    for (int way = 0; way < 2; way++) {
        config.substep_max_s = way == 0 ? 0 : 0.001;
        begin(&config, 1);
        const double command[SIM_THRUSTERS] = {6, -5, 3, 2, -4, 1};
        for (int i = 0; i < (way == 0 ? 1000 : 20); i++) {
            sim_world_step(&world, command, way == 0 ? 0.001 : 0.05);
        }
        memcpy(end[way], world.state.eta.p_m, sizeof end[way]);
        impulse[way] = world.impulse_Ns;
    }
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, end[0][i], end[1][i]);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, impulse[0], impulse[1]);
}

static void fly_disturbed(uint64_t seed) {
    sim_world_config_t config = calm();
    disturb(&config);
    begin(&config, seed);
    const sim_mate_place_t place = place_of_calm();
    for (int i = 0; i < 6000; i++) {
        double command[SIM_THRUSTERS];
        wiggle(i, command);
        if (i == 1) {
            TEST_ASSERT_EQUAL(SIM_HIT, sim_world_mate(&world, &place).outcome);
        }
        sim_world_step(&world, command, STEP_S);
        sim_measurement_t measurement;
        sim_world_measurement(&world, &measurement);
    }
}

static void test_the_same_seed_gives_the_same_bits_and_another_seed_another_flight(void) {
    static sim_world_t first;
    fly_disturbed(42);
    first = world;
    memset(&world, 0xA5, sizeof world);
    fly_disturbed(42);
    TEST_ASSERT_EQUAL_MEMORY(&first, &world, sizeof first);
    fly_disturbed(43);
    TEST_ASSERT_TRUE(fabs(first.state.eta.p_m[0] - world.state.eta.p_m[0]) > 1e-6);
}

static void test_one_more_disturbance_leaves_the_others_their_draws(void) {
    sim_world_config_t config = calm();
    disturb(&config);
    begin(&config, 5);
    double gain[SIM_THRUSTERS], current[3], later[3];
    memcpy(gain, world.thrusters.gain, sizeof gain);
    for (int i = 0; i < 500; i++) {
        sim_world_step(&world, NO_THRUST, STEP_S);
    }
    sim_water_current(&world.water, current);
    config.navigation.position_m.white = config.navigation.dropout = 0;
    config.navigation.rate_Hz = 3;
    begin(&config, 5);
    TEST_ASSERT_EQUAL_MEMORY(gain, world.thrusters.gain, sizeof gain);
    for (int i = 0; i < 500; i++) {
        sim_world_step(&world, NO_THRUST, STEP_S);
    }
    sim_water_current(&world.water, later);
    TEST_ASSERT_EQUAL_MEMORY(current, later, sizeof current);
}

static void check_refused(const sim_world_config_t* config, const char* word) {
    const char* fault = sim_world_init(&world, config, 1);
    TEST_ASSERT_NOT_NULL_MESSAGE(fault, word);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(fault, word), fault);
}

#define CHECK_REFUSED(word, change)                                                                                    \
    do {                                                                                                               \
        sim_world_config_t config = calm();                                                                            \
        change;                                                                                                        \
        check_refused(&config, word);                                                                                  \
    } while (0)

static void test_configurations_that_make_no_sense_are_refused_by_name(void) {
    CHECK_REFUSED("mass_kg", config.vehicle.mass_kg = 0);
    CHECK_REFUSED("inertia", config.beam.inertia_kg_m2[1] = -1);
    CHECK_REFUSED("inertia", config.beam.inertia_kg_m2[1] = NAN);
    CHECK_REFUSED("drag", config.beam.strip_kg_m2 = -1);
    CHECK_REFUSED("added", config.beam.added_mass_kg[2] = -1);
    CHECK_REFUSED("net_weight", config.vehicle.net_weight_N = NAN);
    CHECK_REFUSED("wander_time_s", config.water.wander_m_s[1] = 0.005);
    CHECK_REFUSED("water", config.water.mean_n_m_s[1] = INFINITY);
    CHECK_REFUSED("lag_s", config.thrusters.lag_s = -0.1);
    CHECK_REFUSED("curve", config.thrusters.curve.num_points = 1);
    CHECK_REFUSED("curve", config.thrusters.curve.num_points = 2);
    CHECK_REFUSED("curve", config.thrusters.curve.num_points = 33);
    CHECK_REFUSED("delay", config.navigation.delay_s = 0.1);
    CHECK_REFUSED("dropout", config.navigation.dropout = 1.1);
    CHECK_REFUSED("bias", config.navigation.attitude_rad.bias[0] = NAN);
    CHECK_REFUSED("quaternions", config.X_nb.q[0] = 2);
    CHECK_REFUSED("thruster", config.thruster[3].n[0] = 2);
    CHECK_REFUSED("substep", config.substep_max_s = -1);
}

/// Seconds of processor time.
static double now_s(void) { return (double)clock() / CLOCKS_PER_SEC; }

static void test_a_disturbed_step_of_the_pair_costs_less_than_a_thousandth_of_its_time(void) {
    sim_world_config_t config = calm();
    disturb(&config);
    begin(&config, 1);
    const sim_mate_place_t place = place_of_calm();
    sim_world_mate(&world, &place);
    enum { STEPS = 1000 };
    double least_s = INFINITY; // of many short runs: others use this machine, too
    for (int run = 0; run < 50; run++) {
        const double start_s = now_s();
        for (int i = 0; i < STEPS; i++) {
            double command[SIM_THRUSTERS];
            wiggle(i, command);
            sim_world_step(&world, command, STEP_S);
            sim_measurement_t measurement;
            sim_world_measurement(&world, &measurement);
        }
        least_s = fmin(least_s, (now_s() - start_s) / STEPS);
    }
    printf("A step of 5 ms of the pair with every disturbance costs %.2f us: %.0f times real time\n", 1e6 * least_s,
           STEP_S / least_s);
#ifdef NDEBUG // the bound is for the program as it ships, not for builds with sanitizers or without optimisation
    TEST_ASSERT_TRUE(least_s < STEP_S / 1000);
#endif
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_speed_behind_a_lagging_thruster_follows_the_closed_form);
    RUN_TEST(test_a_vehicle_left_alone_drifts_with_the_current);
    RUN_TEST(test_a_vehicle_left_alone_follows_a_wandering_current_as_closely_as_its_drag_binds_it);
    RUN_TEST(test_a_flight_in_a_current_is_the_flight_in_still_water_carried_along);
    RUN_TEST(test_a_heavy_body_sinks_at_the_speed_of_its_drag_and_a_light_one_rises);
    RUN_TEST(test_a_body_with_its_buoyancy_above_its_mass_swings_with_the_period_of_a_pendulum);
    RUN_TEST(test_every_step_without_forces_keeps_energy_and_momentum_to_a_billionth);
    RUN_TEST(test_momentum_without_thrust_changes_by_drag_and_by_nothing_else);
    RUN_TEST(test_mating_hits_up_to_the_edge_of_every_tolerance_and_a_miss_changes_nothing);
    RUN_TEST(test_the_mate_shares_the_momentum_and_the_pair_moves_on_as_one);
    RUN_TEST(test_a_docked_beam_stays_and_the_vehicle_flies_on_alone);
    RUN_TEST(test_substeps_bring_a_long_step_to_the_same_end);
    RUN_TEST(test_the_same_seed_gives_the_same_bits_and_another_seed_another_flight);
    RUN_TEST(test_one_more_disturbance_leaves_the_others_their_draws);
    RUN_TEST(test_configurations_that_make_no_sense_are_refused_by_name);
    RUN_TEST(test_a_disturbed_step_of_the_pair_costs_less_than_a_thousandth_of_its_time);
    return UNITY_END();
}
