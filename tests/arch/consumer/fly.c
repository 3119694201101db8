/// Somebody else's program, in C and at the same time in C++: fills in the paper's case study, plans it, and prints the
/// price, the plan's hash, the flown timeline and the plan at some times, to the last bit.
#include <inttypes.h>
#include <stdio.h>

#include "ssv/planner.h"

#define NUM_SAMPLES 9

static ssv_problem_t problem;
static ssv_work_t work;
static ssv_plan_t plan;
static ssv_timeline_t timeline;

static vec3_t axis_times(int axis, real_t length) {
    return vec3(axis == 0 ? length : REAL(0), axis == 1 ? length : REAL(0), axis == 2 ? length : REAL(0));
}

static ssv_scenario_t case_study(void) {
    ssv_scenario_t scenario = ssv_scenario_default();
    ssv_vehicle_t* vehicle = &scenario.vehicle;
    vehicle->body.mass_kg = REAL(76.2);
    vehicle->body.inertia_kg_m2 = vec3(REAL(2.7), REAL(2.7), REAL(2.7));
    vehicle->body.drag_lin_kg_s = REAL(413.685);
    vehicle->body.drag_quad_ang_Nm_s2 = REAL(2.2);
    vehicle->radius_m = REAL(0.3025);
    vehicle->force_max_N = REAL(6);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        const real_t side = i % 2 == 0 ? REAL(1) : REAL(-1);
        vehicle->thruster[i].p_ST_m = axis_times((i / 2 + 2) % 3, real_mul(side, REAL(0.3025)));
        vehicle->thruster[i].n_T_S = axis_times(i / 2, side);
    }
    scenario.beam.body.mass_kg = REAL(11.3636);
    scenario.beam.body.inertia_kg_m2 = vec3(REAL(8.81), REAL(8.81), REAL(0.0376));
    scenario.beam.radius_m = REAL(0.0606);
    scenario.beam.length_m = REAL(3.048);
    scenario.beam.drag_strip_kg_m2 = REAL(66.66);
    scenario.X_IS.q = quat_between(vec3(REAL(1), REAL(0), REAL(0)), vec3(REAL(-1), REAL(0), REAL(0)));
    scenario.X_IB.p = vec3(REAL(5), REAL(0), REAL(0));
    scenario.X_IB.q = quat_from_axis_angle(vec3(REAL(0), REAL(1), REAL(0)), real_mul(REAL(0.5), REAL_PI));
    scenario.p_IP_m = vec3(REAL(6.524), REAL(5), REAL(0));
    scenario.axis_I = vec3(REAL(0), REAL(-1), REAL(0));
    scenario.standoff_m = REAL(0.3025);
    return scenario;
}

static void print_sample(real_t t_s) {
    ssv_sample_t sample;
    ssv_plan_sample(&plan, t_s, &sample);
    const pose_t X_IB = pose_mul(sample.X_IS, plan.X_SB);
    printf("%a %a %a %a %d\n", real_to_double(t_s), real_to_double(vec3_norm(X_IB.p)), real_to_double(X_IB.q.w),
           real_to_double(sample.u_N[0]), sample.mated ? 1 : 0);
}

int main(void) {
    const ssv_scenario_t scenario = case_study();
    ssv_fault_t fault;
    const ssv_status_t checked = ssv_problem_init(&problem, &scenario, &fault);
    if (checked != SSV_OK) {
        fprintf(stderr, "%s: %s\n", fault.field, ssv_status_str(checked));
        return 1;
    }
    if (ssv_plan(&problem, &work, &plan) != SSV_OK) {
        fprintf(stderr, "%s\n", ssv_status_str(plan.quote.status));
        return 1;
    }
    ssv_timeline_of_plan(&plan, &timeline);
    printf("%s %s %a %016" PRIx64 "\n", ssv_scalar, REAL_NAME, real_to_double(plan.quote.cost), plan.plan_hash);
    for (int k = 0; k < timeline.num_segments; k++) {
        printf("%" PRId64 " %a\n", timeline.segment[k].duration_ns, (double)timeline.segment[k].u_end_N[3]);
    }
    for (int n = 0; n < NUM_SAMPLES; n++) {
        print_sample(real_div(real_mul(plan.quote.time_s, real_from_int(n)), real_from_int(NUM_SAMPLES - 1)));
    }
    return 0;
}
