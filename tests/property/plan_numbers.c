/// Plans the shipped scenarios, then tasks drawn from SEED, and prints a line of numbers for each, for test_scalars.py to
/// compare between scalars. Usage: plan_numbers SEED METHOD FIRST STEP COUNT; METHOD is that of ssv_method_t, and every STEP-th
/// task from FIRST up to COUNT is planned. A line has the task's number, the status, whether a result did not fit the scalar,
/// and of a plan J, time, impulse, contact, attach height, ring angle, the beam's half length, the standoff, port position and
/// axis, the final poses of vehicle and beam, how far the plan sampled a moment before the end of a leg is from that end, at
/// most, and the vehicle's pose at the end of each leg.
#include <stdio.h>
#include <stdlib.h>

#include "shipped.h"
#include "tasks.h"

#define NUM_SHIPPED ((int)(sizeof shipped / sizeof *shipped))

static void print_real(real_t value) { printf(" %.17g", real_to_double(value)); }

static void print_vec3(vec3_t v) {
    print_real(v.x);
    print_real(v.y);
    print_real(v.z);
}

static void print_pose(pose_t X) {
    print_vec3(X.p);
    print_real(X.q.w);
    print_vec3(vec3(X.q.x, X.q.y, X.q.z));
}

#define MOMENT_S REAL(0.001)

static double off_the_legs_m(const ssv_plan_t* plan) {
    real_t most = REAL(0);
    for (int k = 0; k < plan->num_legs; k++) {
        const ssv_leg_t* leg = &plan->leg[k];
        ssv_sample_t sample;
        ssv_plan_sample(plan, leg->t_start_s + leg->duration_s - MOMENT_S, &sample);
        const vec3_t off = vec3_sub(sample.X_IS.p, leg->X_IS_end.p);
        if (sample.leg == k) most = real_max(most, real_abs(off.x) + real_abs(off.y) + real_abs(off.z));
    }
    return real_to_double(most);
}

static void print_plan(const ssv_scenario_t* scenario, const ssv_plan_t* plan) {
    const ssv_quote_t* quote = &plan->quote;
    print_real(quote->cost);
    print_real(quote->time_s);
    print_real(quote->impulse_Ns);
    printf(" %d", quote->choice.contact);
    print_real(quote->choice.attach_height_m);
    print_real(quote->choice.ring_angle_rad);
    print_real(real_mul(REAL(0.5), scenario->beam.length_m));
    print_real(scenario->standoff_m);
    print_vec3(scenario->p_IP_m);
    print_vec3(scenario->axis_I);
    print_pose(plan->X_IS_final);
    print_pose(plan->X_IB_final);
    printf(" %.17g", off_the_legs_m(plan));
    for (int k = 0; k < plan->num_legs; k++) print_pose(plan->leg[k].X_IS_end);
}

int main(int argc, char** argv) {
    static ssv_problem_t problem;
    static ssv_plan_t plan;
    if (argc != 6) {
        fputs("usage: plan_numbers SEED METHOD FIRST STEP COUNT\n", stderr);
        return 64;
    }
    const uint64_t seed = strtoull(argv[1], NULL, 10);
    const int method = atoi(argv[2]), first = atoi(argv[3]), step = atoi(argv[4]), count = atoi(argv[5]);
    for (int i = first; i < count; i += step) {
        task_seed(seed + (uint64_t)i);
        ssv_scenario_t scenario = i < NUM_SHIPPED ? shipped[i].scenario : task_random();
        scenario.method = (ssv_method_t)method;
        scenario.want_candidates = false;
        ssv_fault_t fault;
        const uint32_t overflows = real_overflows();
        ssv_status_t status = ssv_problem_init(&problem, &scenario, &fault);
        if (status == SSV_OK) status = ssv_plan(&problem, &plan);
        printf("%d %d %d", i, (int)status, real_overflows() != overflows ? 1 : 0);
        if (status == SSV_OK) print_plan(&problem.scenario, &plan);
        putchar('\n');
    }
    return 0;
}
