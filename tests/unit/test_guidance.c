// Guidance piece by piece: the observer against a body of closed form, the law's signs and priorities, the clock, and
// the rules for mating and docking.
#include "guidance/law.h"
#include "guidance/limits.h"
#include "guidance/observer.h"
#include "planner/model/allocation.h"
#include "sample.h"
#include "unity.h"

#define STEP_S 0.05
#define FORCE_N 6
#define COUNT_OF(a) (sizeof(a) / sizeof(a)[0])

static ssv_scenario_t scenario;
static ssv_problem_t problem;
static ssv_work_t work;
static ssv_plan_t plan;
static ssv_guidance_t guidance;
static ssv_guidance_command_t command;
static const ssv_guidance_config_t config = {FORCE_N, 0};

void setUp(void) {
    ssv_fault_t fault;
    scenario = scenario_case_study(true);
    scenario.method = SSV_METHOD_OPTIMAL;
    TEST_ASSERT_EQUAL(SSV_OK, ssv_problem_init(&problem, &scenario, &fault));
    TEST_ASSERT_EQUAL(SSV_OK, ssv_plan(&problem, &work, &plan));
    ssv_guidance_init(&guidance, &problem, &plan, &config);
}

void tearDown(void) {}

static double component(vec3_t v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static vec3_t along(int axis, double size) {
    return vec3(axis == 0 ? size : 0, axis == 1 ? size : 0, axis == 2 ? size : 0);
}

static void take_hold(void) {
    guidance.mated = true;
    guidance.X_SB = plan.X_SB;
    ssv_observer_set_body(&guidance);
}

// A vehicle with linear drag alone that a steady force pushes, in closed form: v' = (F - c v) / m.
static double drifted_m(double force_N, double t_s) {
    const double rate = 413.685 / 76.2, v = force_N / 413.685;
    return v * (t_s + (exp(-rate * t_s) - 1) / rate);
}

static void test_observer_finds_a_steady_force_without_bias_on_every_axis(void) {
    for (int axis = 0; axis < 3; axis++) {
        ssv_guidance_init(&guidance, &problem, &plan, &config);
        const pose_t start = scenario.X_IS;
        for (int k = 1; k <= 1200; k++) {
            ssv_observer_predict(&guidance, STEP_S);
            if (k % 2 == 1) continue; // 10 Hz
            const vec3_t p = vec3_add(start.p, along(axis, drifted_m(2, k * STEP_S)));
            ssv_guidance_measure(&guidance, 0, (pose_t){p, start.q});
        }
        for (int other = 0; other < 3; other++) {
            const double force = other == axis ? 2 : 0;
            // The poles of 0.7 rad/s have had a minute: exp(-30); rounding remains.
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, force, component(guidance.estimate.force_I_N, other));
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, drifted_m(2, 60), component(guidance.estimate.X_IS.p, axis));
    }
}

static void test_observer_finds_a_steady_moment_about_every_axis(void) {
    for (int axis = 0; axis < 3; axis++) {
        ssv_guidance_init(&guidance, &problem, &plan, &config);
        take_hold();
        const pose_t start = scenario.X_IS;
        // Held still by thrust against the moment, as by a thruster that gives too much.
        ssv_alloc(&problem.allocation, along(0, 0), along(axis, -0.1), guidance.command_N);
        for (int k = 1; k <= 2400; k++) {
            ssv_observer_predict(&guidance, STEP_S);
            if (k % 2 == 0) ssv_guidance_measure(&guidance, 0, start);
        }
        for (int other = 0; other < 3; other++) {
            const double moment = other == axis ? 0.1 : 0;
            TEST_ASSERT_DOUBLE_WITHIN(1e-5, moment, component(guidance.estimate.moment_S_Nm, other));
        }
    }
}

static void test_observer_is_unbiased_by_late_measurements_and_drop_outs(void) {
    const pose_t start = scenario.X_IS;
    sample_seed(1);
    for (int k = 1; k <= 2400; k++) {
        ssv_observer_predict(&guidance, STEP_S);
        if (k % 2 == 1 || sample_below(5) == 0) continue;
        const double late_s = 0.3;
        const vec3_t p = vec3_add(start.p, vec3(drifted_m(2, fmax(k * STEP_S - late_s, 0)), 0, 0));
        ssv_guidance_measure(&guidance, late_s, (pose_t){p, start.q});
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 2, guidance.estimate.force_I_N.x);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, drifted_m(2, 120), guidance.estimate.X_IS.p.x);
}

// The farthest that an estimate goes beyond a vehicle that stands 0.1 m from where it was thought to be.
static double overshoot_m(double late_s) {
    ssv_guidance_init(&guidance, &problem, &plan, &config);
    const pose_t stands = {vec3_add(scenario.X_IS.p, vec3(0.1, 0, 0)), scenario.X_IS.q};
    double most_m = 0;
    for (int k = 1; k <= 600; k++) {
        ssv_observer_predict(&guidance, STEP_S);
        if (k % 2 == 0) ssv_guidance_measure(&guidance, late_s, stands);
        most_m = fmax(most_m, guidance.estimate.X_IS.p.x - stands.p.x);
    }
    return most_m;
}

static void test_observer_does_not_correct_the_same_error_twice_when_measurements_are_late(void) {
    // Undelayed 0.020 m. The drift that a correction adds goes on unseen for 0.6 s: 0.044 m; each correction over again
    // would make it 0.068 m.
    TEST_ASSERT_TRUE(overshoot_m(0.6) < 0.055);
    TEST_ASSERT_TRUE(overshoot_m(0) < 0.025);
}

static void test_observer_passes_noise_on_as_its_bandwidth_says(void) {
    const pose_t start = scenario.X_IS;
    double squares = 0;
    const int steps = 20000, skip = 400;
    sample_seed(2);
    for (int k = 1; k <= steps; k++) {
        ssv_observer_predict(&guidance, STEP_S);
        if (k % 2 == 0) {
            const vec3_t noise = sample_vector(0.005 * sqrt(3)); // 5 mm deviation, uniform
            ssv_guidance_measure(&guidance, 0, (pose_t){vec3_add(start.p, noise), start.q});
        }
        if (k > skip)
            squares +=
                vec3_dot(vec3_sub(guidance.estimate.X_IS.p, start.p), vec3_sub(guidance.estimate.X_IS.p, start.p));
    }
    const double rms_m = sqrt(squares / (3 * (steps - skip)));
    // A drift with poles sqrt(1/2) (1 +- i) w passes on 3/4 sqrt(2) w r of noise of density r = 25 mm2 * 0.1 s.
    const double expected_m = sqrt(0.75 * sqrt(2) * OBSERVER_POSITION_RAD_S * 25e-6 * 0.1);
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * expected_m, expected_m, rms_m);
}

// The wrench of what the law adds.
static ssv_wrench_t answer(ssv_reference_t* reference) {
    const ssv_law_error_t error = ssv_law_error(&guidance, reference);
    real_t u_N[SSV_NUM_THRUSTERS];
    ssv_law_thrusts(&guidance, reference, &error, u_N);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) TEST_ASSERT_TRUE(fabs(u_N[i]) <= FORCE_N);
    return ssv_observer_wrench(&problem.scenario.vehicle, u_N);
}

static ssv_reference_t at_the_estimate(void) {
    const ssv_reference_t reference = {guidance.estimate.X_IS, {0, 0, 0}, {0, 0, 0}, {0}};
    return reference;
}

static void test_law_pushes_against_each_error_of_position_and_attitude(void) {
    guidance.estimate.X_IS.q = (quat_t){1, 0, 0, 0};
    for (int axis = 0; axis < 3; axis++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            ssv_reference_t reference = at_the_estimate();
            reference.X_IS.p = vec3_add(reference.X_IS.p, along(axis, sign * 0.01));
            ssv_wrench_t w = answer(&reference);
            TEST_ASSERT_TRUE(sign * component(w.force, axis) > 0.1);
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0, vec3_norm(w.moment));

            reference = at_the_estimate();
            reference.X_IS.q = quat_from_axis_angle(along(axis, 1), sign * 0.01);
            w = answer(&reference);
            TEST_ASSERT_TRUE(sign * component(w.moment, axis) > 0.01);
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0, vec3_norm(w.force));

            reference = at_the_estimate();
            reference.w_S_rad_s = along(axis, sign * 0.01);
            w = answer(&reference);
            TEST_ASSERT_TRUE(sign * component(w.moment, axis) > 0.01);
        }
    }
}

static void test_law_cancels_the_estimated_force_and_moment(void) {
    take_hold();
    const ssv_reference_t still = at_the_estimate();
    guidance.estimate.force_I_N = vec3(1, -2, 0.5);
    guidance.estimate.moment_S_Nm = vec3(0.1, 0.2, -0.3);
    ssv_reference_t reference = still;
    const ssv_wrench_t w = answer(&reference);
    const vec3_t force_I = quat_apply(guidance.estimate.X_IS.q, w.force);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0, vec3_norm(vec3_add(force_I, guidance.estimate.force_I_N)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0, vec3_norm(vec3_add(w.moment, guidance.estimate.moment_S_Nm)));
}

static void test_law_turns_the_pair_about_its_centre_of_mass(void) {
    take_hold();
    ssv_reference_t reference = at_the_estimate();
    const vec3_t r = guidance.body.p_SC_m;
    // Turned about C: C stands where it should, S does not.
    const quat_t turn = quat_from_axis_angle(vec3(0, 0, 1), 0.01);
    reference.X_IS.q = quat_mul(guidance.estimate.X_IS.q, turn);
    reference.X_IS.p =
        vec3_add(guidance.estimate.X_IS.p, quat_apply(guidance.estimate.X_IS.q, vec3_sub(r, quat_apply(turn, r))));
    const ssv_wrench_t w = answer(&reference);
    const vec3_t about_C = vec3_sub(w.moment, vec3_cross(r, w.force));
    TEST_ASSERT_TRUE(about_C.z > 0.1);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0, vec3_norm(w.force)); // no added mass: C is where no force is needed
}

static void test_law_moves_the_pair_without_turning_it(void) {
    take_hold();
    ssv_reference_t reference = at_the_estimate();
    reference.X_IS.p = vec3_add(reference.X_IS.p, vec3(0.01, -0.02, 0.005));
    const ssv_wrench_t w = answer(&reference);
    const vec3_t about_C = vec3_sub(w.moment, vec3_cross(guidance.body.p_SC_m, w.force));
    TEST_ASSERT_TRUE(vec3_norm(w.force) > 0.5);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0, vec3_norm(about_C));
}

static void test_law_gives_attitude_what_it_needs_before_position(void) {
    guidance.estimate.X_IS.q = (quat_t){1, 0, 0, 0};
    ssv_reference_t reference = at_the_estimate();
    reference.X_IS.q = quat_from_axis_angle(vec3(0, 0, 1), 0.5);
    const double wanted = answer(&reference).moment.z;
    reference.X_IS.p = vec3_add(reference.X_IS.p, vec3(3, 4, 0));
    const ssv_wrench_t w = answer(&reference);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, wanted, w.moment.z);
    TEST_ASSERT_TRUE(w.force.x > 1);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0, w.force.x * 4 - w.force.y * 3); // scaled, not bent
    // More than there is: all to the moment.
    reference.w_S_rad_s = vec3(0, 0, 10);
    const ssv_wrench_t most = answer(&reference);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 2 * FORCE_N * 0.3025, most.moment.z);
}

static void step_to(double t_s) {
    guidance.plan_time_s = t_s;
    ssv_sample_t sample;
    ssv_plan_sample(&plan, t_s, &sample);
    guidance.estimate.X_IS = sample.X_IS;
    guidance.estimate.v_S_m_s = sample.v_IS_S_m_s;
    guidance.estimate.w_S_rad_s = sample.w_IS_S_rad_s;
}

// A moment at which the vehicle flies straight.
static double straight_s(void) {
    for (double t = 0; t < plan.event[0].t_s; t += 1) {
        ssv_sample_t sample;
        ssv_plan_sample(&plan, t, &sample);
        if (vec3_norm(sample.v_IS_S_m_s) > 0.02 && vec3_norm(sample.w_IS_S_rad_s) < 1e-3) return t;
    }
    TEST_FAIL_MESSAGE("the plan flies nowhere straight");
    return 0;
}

static void test_clock_waits_for_what_lags_along_the_path_and_not_for_what_is_ahead_or_beside_it(void) {
    static const struct {
        double along_m, across_m, rate;
    } rows[] = {{0, 0, 1},           {0.5 * 0.2 * CLOCK_LAG_M, 0, 1}, {0.6 * CLOCK_LAG_M, 0, 0.5},
                {CLOCK_LAG_M, 0, 0}, {3 * CLOCK_LAG_M, 0, 0},         {-0.1, 0, 1},
                {0, 0.1, 1}};
    const double t = straight_s();
    for (size_t k = 0; k < COUNT_OF(rows); k++) {
        step_to(t);
        const vec3_t v_I = vec3_unit(quat_apply(guidance.estimate.X_IS.q, guidance.estimate.v_S_m_s));
        const vec3_t off =
            vec3_add(vec3_scale(-rows[k].along_m, v_I), vec3_scale(rows[k].across_m, vec3_perpendicular(v_I)));
        guidance.estimate.X_IS.p = vec3_add(guidance.estimate.X_IS.p, off);
        ssv_guidance_step(&guidance, STEP_S, &command);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, rows[k].rate, command.clock_rate); // the path turns a little
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, t + command.clock_rate * STEP_S, guidance.plan_time_s);
    }
}

static void test_lost_across_the_path_asks_for_a_new_plan_and_lag_along_it_does_not(void) {
    const double t = straight_s();
    for (int across = 0; across < 2; across++) {
        step_to(t);
        const vec3_t v_I = vec3_unit(quat_apply(guidance.estimate.X_IS.q, guidance.estimate.v_S_m_s));
        const vec3_t way = across ? vec3_perpendicular(v_I) : vec3_neg(v_I);
        guidance.estimate.X_IS.p = vec3_add(guidance.estimate.X_IS.p, vec3_scale(1.1 * LOST_ACROSS_M, way));
        ssv_guidance_step(&guidance, STEP_S, &command);
        TEST_ASSERT_EQUAL(across, command.replan);
    }
}

static pose_t place_to_mate(void) { return pose_mul(scenario.X_IB, pose_inv(plan.X_SB)); }

// Puts the vehicle to rest there and lets guidance dwell; measurements say that it stays.
static int steps_until_attempt(pose_t X_IS, int most) {
    for (int k = 1; k <= most; k++) {
        ssv_guidance_step(&guidance, STEP_S, &command);
        if (command.attempt != SSV_ATTEMPT_NONE) return k;
        guidance.estimate.X_IS = X_IS;
        guidance.estimate.v_S_m_s = guidance.estimate.w_S_rad_s = vec3(0, 0, 0);
    }
    return 0;
}

static void arrive(pose_t X_IS, double end_s) {
    guidance.plan_time_s = end_s;
    guidance.estimate.X_IS = X_IS;
    guidance.estimate.v_S_m_s = guidance.estimate.w_S_rad_s = vec3(0, 0, 0);
}

static void test_vehicle_mates_after_two_seconds_inside_the_tolerance_and_not_before(void) {
    arrive(place_to_mate(), plan.event[0].t_s);
    const int steps = steps_until_attempt(place_to_mate(), 2000);
    TEST_ASSERT_EQUAL(SSV_ATTEMPT_MATE, command.attempt);
    TEST_ASSERT_TRUE(command.clock_rate == REAL(0));
    TEST_ASSERT_TRUE(steps * STEP_S >= DWELL_INSIDE_S);
    TEST_ASSERT_TRUE(steps * STEP_S <= DWELL_INSIDE_S + DWELL_LEAST_S + 0.2);
    ssv_guidance_attempted(&guidance, true);
    ssv_guidance_step(&guidance, STEP_S, &command);
    TEST_ASSERT_EQUAL(SSV_GUIDANCE_FLYING, command.state);
    TEST_ASSERT_TRUE(guidance.mated);
}

static void test_vehicle_that_cannot_come_inside_takes_more_of_the_tolerance_after_a_minute(void) {
    pose_t beside = place_to_mate();
    beside.p = vec3_add(beside.p, vec3(0, 0, 1.3 * DWELL_TIP_M)); // half of what is added by the end
    arrive(beside, plan.event[0].t_s);
    const double waited_s = steps_until_attempt(beside, 20 * 600) * STEP_S;
    TEST_ASSERT_EQUAL(SSV_ATTEMPT_MATE, command.attempt);
    TEST_ASSERT_DOUBLE_WITHIN(4 * STEP_S, (DWELL_PATIENCE_S + DWELL_MAX_S) / 2 + DWELL_INSIDE_S, waited_s);
}

/// @param counts  whether anything stands around. @return how far it has backed off in the end.
static double give_up(bool counts) {
    pose_t beside = place_to_mate();
    ssv_problem_t beset = problem;
    beset.around.counts = counts;
    ssv_guidance_init(&guidance, &beset, &plan, &config);
    beside.p = vec3_add(beside.p, vec3(0, 0, 2 * DWELL_TIP_M));
    arrive(beside, plan.event[0].t_s);
    command.state = SSV_GUIDANCE_FLYING;
    int seen[6] = {0}, steps = 0, steps_back = 0;
    ssv_guidance_state_t last = SSV_GUIDANCE_FLYING;
    for (int k = 0; k < 20 * 600 && command.state != SSV_GUIDANCE_ABORTED; k++) {
        TEST_ASSERT_EQUAL(0, steps_until_attempt(beside, 1));
        if (command.state != last) seen[command.state]++;
        steps = command.state != last ? 0 : steps + 1;
        if (command.state == SSV_GUIDANCE_BACKING_OFF) steps_back = steps;
        last = command.state;
    }
    TEST_ASSERT_EQUAL(SSV_GUIDANCE_TRIES, seen[SSV_GUIDANCE_DWELLING]);
    TEST_ASSERT_EQUAL(SSV_GUIDANCE_TRIES, seen[SSV_GUIDANCE_BACKING_OFF]);
    TEST_ASSERT_EQUAL(SSV_GUIDANCE_TRIES - 1, seen[SSV_GUIDANCE_RETURNING]);
    TEST_ASSERT_EQUAL(1, seen[SSV_GUIDANCE_ABORTED]);
    TEST_ASSERT_EQUAL(SSV_ATTEMPT_NONE, command.attempt);
    // The last time it stays where it has backed off to, until it has come to rest; two steps for the ends.
    TEST_ASSERT_DOUBLE_WITHIN(2 * STEP_S, guidance.back_off_m / BACK_OFF_M_S + BACK_OFF_REST_S, steps_back * STEP_S);
    return guidance.back_off_m;
}

static void test_vehicle_that_stays_outside_the_tolerance_backs_off_comes_again_and_gives_up_at_rest(void) {
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, BACK_OFF_M, give_up(false));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, BACK_OFF_NEAR_M, give_up(true)); // there may be no more room than that
}

static void test_missed_attempt_backs_off_away_from_the_beam_and_out_of_the_port(void) {
    for (int mated = 0; mated < 2; mated++) {
        ssv_guidance_init(&guidance, &problem, &plan, &config);
        if (mated) take_hold();
        const pose_t place = mated ? plan.quote.X_IS_final : place_to_mate();
        arrive(place, mated ? plan.quote.time_s : plan.event[0].t_s);
        TEST_ASSERT_TRUE(steps_until_attempt(place, 2000) > 0);
        ssv_guidance_attempted(&guidance, false);
        double out_N = 0;
        for (int k = 0; k < 40; k++) {
            ssv_guidance_step(&guidance, STEP_S, &command);
            const ssv_wrench_t w = ssv_observer_wrench(&problem.scenario.vehicle, command.u_N);
            const vec3_t force_I = quat_apply(guidance.estimate.X_IS.q, w.force);
            const vec3_t out_I = mated ? scenario.axis_I : quat_apply(place.q, vec3(-1, 0, 0));
            out_N += vec3_dot(force_I, out_I);
        }
        TEST_ASSERT_EQUAL(SSV_GUIDANCE_BACKING_OFF, command.state);
        TEST_ASSERT_TRUE(out_N / 40 > 0.5);
    }
}

static void test_docked_vehicle_gives_no_thrust(void) {
    take_hold();
    arrive(plan.quote.X_IS_final, plan.quote.time_s);
    TEST_ASSERT_TRUE(steps_until_attempt(plan.quote.X_IS_final, 2000) > 0);
    TEST_ASSERT_EQUAL(SSV_ATTEMPT_DOCK, command.attempt);
    ssv_guidance_attempted(&guidance, true);
    guidance.estimate.force_I_N = vec3(1, 1, 1);
    ssv_guidance_step(&guidance, STEP_S, &command);
    TEST_ASSERT_EQUAL(SSV_GUIDANCE_DONE, command.state);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) TEST_ASSERT_EQUAL_DOUBLE(0, command.u_N[i]);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_observer_finds_a_steady_force_without_bias_on_every_axis);
    RUN_TEST(test_observer_finds_a_steady_moment_about_every_axis);
    RUN_TEST(test_observer_is_unbiased_by_late_measurements_and_drop_outs);
    RUN_TEST(test_observer_does_not_correct_the_same_error_twice_when_measurements_are_late);
    RUN_TEST(test_observer_passes_noise_on_as_its_bandwidth_says);
    RUN_TEST(test_law_pushes_against_each_error_of_position_and_attitude);
    RUN_TEST(test_law_cancels_the_estimated_force_and_moment);
    RUN_TEST(test_law_turns_the_pair_about_its_centre_of_mass);
    RUN_TEST(test_law_moves_the_pair_without_turning_it);
    RUN_TEST(test_law_gives_attitude_what_it_needs_before_position);
    RUN_TEST(test_clock_waits_for_what_lags_along_the_path_and_not_for_what_is_ahead_or_beside_it);
    RUN_TEST(test_lost_across_the_path_asks_for_a_new_plan_and_lag_along_it_does_not);
    RUN_TEST(test_vehicle_mates_after_two_seconds_inside_the_tolerance_and_not_before);
    RUN_TEST(test_vehicle_that_cannot_come_inside_takes_more_of_the_tolerance_after_a_minute);
    RUN_TEST(test_vehicle_that_stays_outside_the_tolerance_backs_off_comes_again_and_gives_up_at_rest);
    RUN_TEST(test_missed_attempt_backs_off_away_from_the_beam_and_out_of_the_port);
    RUN_TEST(test_docked_vehicle_gives_no_thrust);
    return UNITY_END();
}
