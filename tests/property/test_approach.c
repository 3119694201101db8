// Random tasks with a straight approach and speed caps: the plan comes straight, and no sample of it is too fast.
// SSV_LONG=1 plans ten times as many.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sample.h"
#include "scenes.h"
#include "unity.h"

#define SEED 20261129
#define SAMPLES 400
// Of a speed, by the scalar's rounding.
#define ROUNDING (strcmp(REAL_NAME, "float") == 0 ? 1e-4 : 1e-6)
#define DEGREE (acos(-1) / 180)

static ssv_problem_t problem;
static ssv_work_t work;
static ssv_plan_t plan, other;
static ssv_scene_t scene;
static char label[64];

void setUp(void) {}
void tearDown(void) {}

static int times(int count) {
    if (getenv("SSV_LONG") != NULL) count *= 10;
    return strcmp(REAL_NAME, "double") == 0 ? count : count / 4;
}

static bool solve(const ssv_scenario_t* s, ssv_plan_t* p) {
    ssv_fault_t fault;
    TEST_ASSERT_EQUAL_INT_MESSAGE(SSV_OK, ssv_problem_init(&problem, s, &fault), label);
    return ssv_plan(&problem, &work, p) == SSV_OK;
}

static double angle_between(vec3_t a, vec3_t b) {
    return atan2(real_to_double(vec3_norm(vec3_cross(a, b))), real_to_double(vec3_dot(a, b)));
}

static double speed(vec3_t v) { return real_to_double(vec3_norm(v)); }

static vec3_t contact_S(const ssv_scenario_t* s, int contact) {
    const real_t half = real_mul(REAL(0.5), s->beam.length_m);
    return vec3_add(plan.X_SB.p, quat_apply(plan.X_SB.q, vec3(0, 0, contact == 1 ? -half : half)));
}

static void test_it_comes_straight_over_the_last_stretch(void) {
    int found = 0;
    sample_seed(SEED);
    const int count = times(100);
    for (int k = 0; k < count; k++) {
        ssv_scenario_t s = scene_task(k % 2 == 0 ? SCENE_BARE : SCENE_BUILT, &scene);
        (void)snprintf(label, sizeof label, "task %d", k);
        s.method = k % 4 == 3 ? SSV_METHOD_PAPER : SSV_METHOD_OPTIMAL;
        s.approach_mate_m = s.approach_dock_m = REAL(0.15);
        s.contact_speed_max_m_s = k % 3 == 0 ? REAL(0.004) : REAL(0);
        if (!solve(&s, &plan)) continue;
        found++;
        int mates = 0;
        while (plan.leg[mates + 1].phase == SSV_TRANSIT) mates++;
        const ssv_leg_t* leg[2] = {&plan.leg[mates], &plan.leg[plan.num_legs - 1]};
        for (int phase = 0; phase < 2; phase++) {
            TEST_ASSERT_EQUAL_INT_MESSAGE(SSV_TRANSLATE, leg[phase]->kind, label);
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-6, 0.15, real_to_double(leg[phase]->length), label);
            for (int n = 0; n <= 20; n++) {
                ssv_sample_t sample;
                const real_t t_s = leg[phase]->t_start_s +
                                   real_mul(real_div(real_from_int(2 * n + 1), REAL(42)), leg[phase]->duration_s);
                ssv_plan_sample(&plan, t_s, &sample);
                const vec3_t v_I = quat_apply(sample.X_IS.q, sample.v_IS_S_m_s);
                // Towards the beam's axis and square to it; against the port's axis with the beam's own along it.
                const vec3_t z_I = quat_apply(s.X_IB.q, vec3(0, 0, REAL(1)));
                const vec3_t to_beam = vec3_sub(s.X_IB.p, sample.X_IS.p);
                const vec3_t normal = vec3_sub(to_beam, vec3_scale(vec3_dot(to_beam, z_I), z_I));
                const vec3_t ahead = phase == 0 ? normal : vec3_neg(s.axis_I);
                TEST_ASSERT_TRUE_MESSAGE(angle_between(v_I, ahead) < DEGREE, label);
                const vec3_t outward_S = vec3_sub(contact_S(&s, s.contact), plan.X_SB.p);
                const vec3_t looks =
                    phase == 0 ? quat_apply(sample.X_IS.q, vec3(REAL(1), 0, 0)) : quat_apply(sample.X_IS.q, outward_S);
                TEST_ASSERT_TRUE_MESSAGE(angle_between(looks, ahead) < DEGREE, label);
                if (k % 3 == 0) TEST_ASSERT_TRUE_MESSAGE(speed(v_I) <= 0.004 * (1 + ROUNDING), label);
            }
        }
    }
    printf("%d of %d found\n", found, count);
    TEST_ASSERT_GREATER_THAN_INT(count * 4 / 5, found);
}

// Thirty-odd of these plans reach each of the caps.
static void test_no_sample_of_a_plan_is_faster_than_its_caps(void) {
    static const double caps[5] = {0.01, 0.05, 0.008, 0.02, 0.01};
    int reached[5] = {0};
    sample_seed(SEED + 1);
    const int count = times(100);
    for (int k = 0; k < count; k++) {
        ssv_scenario_t s = sample_scenario();
        (void)snprintf(label, sizeof label, "task %d", k);
        s.method = k % 3 == 2 ? SSV_METHOD_PAPER : SSV_METHOD_OPTIMAL;
        s.want_candidates = false;
        if (k % 2 == 0) s.transit_speed_max_m_s = real_from_double(caps[0]);
        if (k % 2 == 1) s.transit_rate_max_rad_s = real_from_double(caps[1]);
        if (k % 4 == 0) s.transfer_speed_max_m_s = real_from_double(caps[2]);
        if (k % 4 == 1) s.transfer_beam_speed_max_m_s = real_from_double(caps[3]);
        if (k % 4 == 2) s.transfer_rate_max_rad_s = real_from_double(caps[4]);
        TEST_ASSERT_TRUE_MESSAGE(solve(&s, &plan), label);
        double most[5] = {0};
        for (int n = 0; n < SAMPLES; n++) {
            ssv_sample_t sample;
            ssv_plan_sample(&plan, real_mul(plan.quote.time_s, real_div(real_from_int(n), real_from_int(SAMPLES))),
                            &sample);
            const int first = sample.mated ? 2 : 0;
            most[first] = fmax(most[first], speed(sample.v_IS_S_m_s));
            const int rate = sample.mated ? 4 : 1;
            most[rate] = fmax(most[rate], speed(sample.w_IS_S_rad_s));
            for (int contact = 1; sample.mated && contact <= 2; contact++) {
                const vec3_t v = vec3_add(sample.v_IS_S_m_s, vec3_cross(sample.w_IS_S_rad_s, contact_S(&s, contact)));
                most[3] = fmax(most[3], speed(v));
            }
        }
        const bool asked[5] = {k % 2 == 0, k % 2 == 1, k % 4 == 0, k % 4 == 1, k % 4 == 2};
        for (int i = 0; i < 5; i++) {
            if (!asked[i]) continue;
            TEST_ASSERT_TRUE_MESSAGE(most[i] <= caps[i] * (1 + ROUNDING), label);
            if (most[i] >= 0.99 * caps[i]) reached[i]++;
        }
    }
    for (int i = 0; i < 5; i++) {
        printf("cap %d reached by %d plans\n", i, reached[i]);
        TEST_ASSERT_GREATER_THAN_INT(0, reached[i]);
    }
}

static void test_caps_that_no_plan_reaches_change_nothing_of_it(void) {
    sample_seed(SEED + 2);
    for (int k = 0; k < times(40); k++) {
        ssv_scenario_t s = sample_scenario();
        (void)snprintf(label, sizeof label, "task %d", k);
        TEST_ASSERT_TRUE_MESSAGE(solve(&s, &plan), label);
        s.transit_speed_max_m_s = s.transfer_speed_max_m_s = s.transfer_beam_speed_max_m_s = REAL(100);
        s.transit_rate_max_rad_s = s.transfer_rate_max_rad_s = REAL(100);
        TEST_ASSERT_TRUE_MESSAGE(solve(&s, &other), label);
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&plan.leg, &other.leg, sizeof plan.leg, label);
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&plan.arc, &other.arc, sizeof plan.arc, label);
        TEST_ASSERT_TRUE_MESSAGE(plan.quote.scenario_hash != other.quote.scenario_hash, label);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_it_comes_straight_over_the_last_stretch);
    RUN_TEST(test_no_sample_of_a_plan_is_faster_than_its_caps);
    RUN_TEST(test_caps_that_no_plan_reaches_change_nothing_of_it);
    return UNITY_END();
}
