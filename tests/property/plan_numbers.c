/// Plans the shipped scenarios, then tasks drawn from SEED, and prints a line of numbers for each, for test_scalars.py
/// to compare between scalars. Usage: plan_numbers SEED METHOD FIRST STEP COUNT; METHOD is that of ssv_method_t, and
/// every STEP-th task from FIRST up to COUNT is planned. A line has the task's number, the status, whether a result did
/// not fit the scalar, and of a plan J, time, impulse, contact, attach height, ring angle, the beam's half length, the
/// standoff, port position and axis, the final poses of vehicle and beam, how far the plan sampled a moment before the
/// end of a leg is from that end, at most, the pose of the beam on the vehicle, and of each leg the vehicle's pose at
/// its end, its phase, kind, twist and length.
///
/// With `plan_numbers SEED METHOD -` it reads such lines of another scalar instead and prices their motions: a line has
/// the task's number, J and time.
#include <stdio.h>
#include <stdlib.h>

#include "planner/motion/maneuver.h"
#include "sample.h"
#include "shipped.h"

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
    print_pose(plan->quote.X_IS_final);
    print_pose(plan->quote.X_IB_final);
    printf(" %.17g", off_the_legs_m(plan));
    print_pose(plan->X_SB);
    for (int k = 0; k < plan->num_legs; k++) {
        const ssv_leg_t* leg = &plan->leg[k];
        print_pose(leg->X_IS_end);
        printf(" %d %d", (int)leg->phase, (int)leg->kind);
        print_vec3(leg->v_S);
        print_vec3(leg->w_S);
        print_real(leg->length);
    }
}

static ssv_scenario_t task(uint64_t seed, int i, int method) {
    sample_seed(seed + (uint64_t)i);
    ssv_scenario_t scenario = i < NUM_SHIPPED ? shipped[i].scenario : sample_scenario();
    scenario.method = (ssv_method_t)method;
    scenario.want_candidates = false;
    return scenario;
}

static void plan_tasks(uint64_t seed, int method, int first, int step, int count) {
    static ssv_problem_t problem;
    static ssv_work_t work;
    static ssv_plan_t plan;
    for (int i = first; i < count; i += step) {
        const ssv_scenario_t scenario = task(seed, i, method);
        ssv_fault_t fault;
        const uint32_t overflows = real_overflows();
        ssv_status_t status = ssv_problem_init(&problem, &scenario, &fault);
        if (status == SSV_OK) status = ssv_plan(&problem, &work, &plan);
        printf("%d %d %d", i, (int)status, real_overflows() != overflows ? 1 : 0);
        if (status == SSV_OK) print_plan(&problem.scenario, &plan);
        putchar('\n');
    }
}

// ---- Motions of another scalar --------------------------------------------------------------------------------------

static bool read_reals(char** at, real_t* values, int num) {
    for (int k = 0; k < num; k++) {
        char* end;
        values[k] = real_from_double(strtod(*at, &end));
        if (end == *at) return false;
        *at = end;
    }
    return true;
}

static bool read_vec3(char** at, vec3_t* v) {
    real_t x[3];
    if (!read_reals(at, x, 3)) return false;
    *v = vec3(x[0], x[1], x[2]);
    return true;
}

static bool read_pose(char** at, pose_t* X) {
    real_t q[4];
    if (!read_vec3(at, &X->p) || !read_reals(at, q, 4)) return false;
    X->q = (quat_t){q[0], q[1], q[2], q[3]};
    return true;
}

static bool read_maneuver(char** at, ssv_maneuver_t* maneuver) {
    pose_t X_IS_end;
    real_t kinds[2];
    if (!read_pose(at, &X_IS_end) || !read_reals(at, kinds, 2)) return false;
    maneuver->phase = (ssv_phase_t)real_to_double(kinds[0]);
    maneuver->kind = (ssv_leg_kind_t)real_to_double(kinds[1]);
    return read_vec3(at, &maneuver->twist.v) && read_vec3(at, &maneuver->twist.w) &&
           read_reals(at, &maneuver->length, 1);
}

// What a line says before the pose of the beam on the vehicle.
#define NUM_BEFORE 32

static bool price_motion(char* line, uint64_t seed, int method) {
    static ssv_problem_t problem;
    real_t before[NUM_BEFORE], cost = REAL(0), time_s = REAL(0);
    pose_t X_SB;
    ssv_fault_t fault;
    if (!read_reals(&line, before, NUM_BEFORE) || !read_pose(&line, &X_SB)) return false;
    const int i = (int)real_to_double(before[0]);
    const ssv_scenario_t scenario = task(seed, i, method);
    if (ssv_problem_init(&problem, &scenario, &fault) != SSV_OK) return false;
    const ssv_question_t question = ssv_question_of(&problem);
    ssv_maneuver_t maneuver = {.speed_max = REAL(0)};
    while (read_maneuver(&line, &maneuver)) {
        const ssv_beam_t* beam = maneuver.phase == SSV_TRANSFER ? &problem.scenario.beam : NULL;
        const ssv_assembly_t assembly = {&problem.scenario.vehicle, beam, X_SB};
        ssv_thrusts_t thrusts;
        ssv_ramp_t ramp;
        ssv_maneuver_thrusts(&problem, &assembly, maneuver.twist, &thrusts);
        const ssv_price_t price = ssv_maneuver_price(&question, &maneuver, &thrusts, &ramp);
        if (price.outcome != SSV_FEASIBLE) return false;
        cost += price.cost;
        time_s += price.time_s;
    }
    printf("%d", i);
    print_real(cost);
    print_real(time_s);
    putchar('\n');
    return true;
}

int main(int argc, char** argv) {
    static char line[16384];
    if (argc != 4 && argc != 6) {
        fputs("usage: plan_numbers SEED METHOD FIRST STEP COUNT, or SEED METHOD -\n", stderr);
        return 64;
    }
    const uint64_t seed = strtoull(argv[1], NULL, 10);
    const int method = atoi(argv[2]);
    if (argc == 6) {
        plan_tasks(seed, method, atoi(argv[3]), atoi(argv[4]), atoi(argv[5]));
        return 0;
    }
    while (fgets(line, sizeof line, stdin) != NULL) {
        if (price_motion(line, seed, method)) continue;
        fprintf(stderr, "no motion that can be priced: %s", line);
        return 65;
    }
    return 0;
}
