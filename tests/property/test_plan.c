// Random tasks: what holds for every plan as it is written. SSV_LONG=1 runs ten times as many.
#include <stdio.h>
#include <stdlib.h>

#include "sample.h"
#include "unity.h"

#define SEED 20261123

static ssv_problem_t problem;
static ssv_work_t work;
static ssv_plan_t plan, other;
static char label[64];

void setUp(void) {}
void tearDown(void) {}

static int times(int count) { return getenv("SSV_LONG") == NULL ? count : 10 * count; }

static void name(int task) { (void)snprintf(label, sizeof label, "seed %d, task %d", SEED, task); }

static void solve(const ssv_scenario_t* s, ssv_plan_t* p) {
    ssv_fault_t fault;
    TEST_ASSERT_EQUAL_INT_MESSAGE(SSV_OK, ssv_problem_init(&problem, s, &fault), label);
    TEST_ASSERT_EQUAL_INT_MESSAGE(SSV_OK, ssv_plan(&problem, &work, p), label);
}

static void test_claimed_poses_meet_the_task(void) {
    sample_seed(SEED + 1);
    for (int k = 0; k < times(500); k++) {
        ssv_scenario_t s = sample_scenario();
        name(k);
        s.method = k % 10 == 0 ? SSV_METHOD_OPTIMAL : SSV_METHOD_PAPER;
        solve(&s, &plan);
        // At the mate: the vehicle at its standoff, at the chosen height, looking at the axis.
        const pose_t mate = pose_mul(plan.quote.X_IB_final, pose_inv(plan.X_SB)); // = X_IS_final
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9, 0, vec3_norm(vec3_sub(mate.p, plan.quote.X_IS_final.p)), label);
        const vec3_t p_BS = pose_inv(plan.X_SB).p;
        const vec3_t ahead_B = quat_apply(quat_conj(plan.X_SB.q), vec3(1, 0, 0));
        const double phi = plan.quote.choice.ring_angle_rad;
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9, s.standoff_m * cos(phi), p_BS.x, label);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9, s.standoff_m * sin(phi), p_BS.y, label);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9, plan.quote.choice.attach_height_m, p_BS.z, label);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9, 1, -ahead_B.x * cos(phi) - ahead_B.y * sin(phi), label);
        // Docked: the contact on the port, the beam's outward axis against the port's.
        const double side = plan.quote.choice.contact == 1 ? -1 : 1;
        const pose_t contact_B = {{0, 0, side * 1.524}, quat_identity()};
        const vec3_t contact_I = pose_mul(plan.quote.X_IB_final, contact_B).p;
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9, 0, vec3_norm(vec3_sub(contact_I, s.p_IP_m)), label);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(
            1e-9, -side, vec3_dot(quat_apply(plan.quote.X_IB_final.q, vec3(0, 0, 1)), s.axis_I), label);
    }
}

static void test_timeline_is_contiguous_and_every_thrust_within_its_limit(void) {
    int most = 0;
    sample_seed(SEED + 2);
    for (int k = 0; k < times(500); k++) {
        const ssv_scenario_t s = sample_scenario();
        double t = 0;
        name(k);
        solve(&s, &plan);
        for (int g = 0; g < plan.num_segments; g++) {
            const ssv_segment_t* segment = &plan.segment[g];
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9, t, segment->t_s, label);
            TEST_ASSERT_TRUE_MESSAGE(segment->duration_s > 0, label);
            for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
                TEST_ASSERT_TRUE_MESSAGE(fmax(fabs(segment->u_start_N[i]), fabs(segment->u_end_N[i])) <= 6, label);
            }
            t += segment->duration_s;
        }
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-7, plan.quote.time_s, t, label);
        most = plan.num_segments > most ? plan.num_segments : most;
    }
    printf("seed %d: at most %d of %d segments\n", SEED + 2, most, SSV_MAX_SEGMENTS);
}

static void test_either_contact_never_costs_more_than_a_given_one(void) {
    sample_seed(SEED + 5);
    for (int k = 0; k < times(300); k++) {
        ssv_scenario_t s = sample_scenario();
        name(k);
        s.contact = 0;
        solve(&s, &plan);
        for (s.contact = 1; s.contact <= 2; s.contact++) {
            solve(&s, &other);
            TEST_ASSERT_TRUE_MESSAGE(plan.quote.cost <= other.quote.cost, label);
        }
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_claimed_poses_meet_the_task);
    RUN_TEST(test_timeline_is_contiguous_and_every_thrust_within_its_limit);
    RUN_TEST(test_either_contact_never_costs_more_than_a_given_one);
    return UNITY_END();
}
