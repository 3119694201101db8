/// Plans COUNT scenarios drawn from SEED around the numbers of both models and prints a line for each: its number, the
/// status and the hashes. Usage: plan_hashes SEED COUNT. Built with different compilers and options, the output must not differ.
///
/// The draw itself uses IEEE operations and the square root alone, so it is the same everywhere.
#include "ssv/planner.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static uint64_t random_state;

// splitmix64
static uint64_t next(void) {
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static double between(double low, double high) {
    return low + (high - low) * ((double)(next() >> 11) * 0x1p-53);
}

static int below(int n) { return (int)(next() % (uint64_t)n); }

static vec3_t random_vector(double size) {
    const double x = between(-size, size), y = between(-size, size), z = between(-size, size);
    const vec3_t v = {real_from_double(x), real_from_double(y), real_from_double(z)};
    return v;
}

static vec3_t random_direction(void) {
    for (;;) {
        const double x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
        const double n = sqrt(x * x + y * y + z * z);
        if (n > 0.1 && n <= 1) {
            const vec3_t v = {real_from_double(x / n), real_from_double(y / n), real_from_double(z / n)};
            return v;
        }
    }
}

static quat_t random_attitude(void) {
    for (;;) {
        const double w = between(-1, 1), x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
        const double n = sqrt(w * w + x * x + y * y + z * z);
        if (n > 0.1 && n <= 1) {
            const quat_t q = {real_from_double(w / n), real_from_double(x / n), real_from_double(y / n), real_from_double(z / n)};
            return q;
        }
    }
}

static void fill_thrusters(ssv_vehicle_t* vehicle, double jitter_m) {
    static const double position[SSV_NUM_THRUSTERS][3] = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
    static const double direction[SSV_NUM_THRUSTERS][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        const vec3_t p = {real_from_double(0.3025 * position[i][0]), real_from_double(0.3025 * position[i][1]),
                          real_from_double(0.3025 * position[i][2])};
        const vec3_t n = {real_from_double(direction[i][0]), real_from_double(direction[i][1]),
                          real_from_double(direction[i][2])};
        vehicle->thruster[i].p_ST_m = vec3_add(p, random_vector(jitter_m));
        vehicle->thruster[i].n_T_S = n;
    }
}

static vec3_t diagonal(double x, double y, double z) {
    const vec3_t v = {real_from_double(x), real_from_double(y), real_from_double(z)};
    return v;
}

static ssv_scenario_t random_scenario(void) {
    static const double weights[][2] = {{1, 0}, {0, 1}, {1, 1}, {1, 0.1}, {0.01, 1}};
    const int is_ease = below(2), is_varied = below(2);
    const double vary = is_varied ? between(0.8, 1.25) : 1;
    ssv_scenario_t s = ssv_scenario_default();

    s.vehicle.body.mass_kg = real_from_double(76.2 * vary);
    s.vehicle.body.inertia_kg_m2 = diagonal(2.7, 2.7 * vary, 2.7);
    if (is_varied) {
        s.vehicle.body.added_mass_kg = vec3_add(random_vector(30), diagonal(30, 30, 30));
    }
    s.vehicle.body.drag_lin_kg_s = real_from_double(413.685 * vary);
    s.vehicle.body.drag_quad_kg_m = real_from_double(is_varied ? between(0, 300) : 0);
    s.vehicle.body.drag_lin_ang_Nm_s = real_from_double(is_varied ? between(0, 1) : 0);
    s.vehicle.body.drag_quad_ang_Nm_s2 = real_from_double(2.2);
    s.vehicle.radius_m = real_from_double(0.3025);
    s.vehicle.force_max_N = real_from_double(6);
    fill_thrusters(&s.vehicle, is_varied ? 0.03 : 0);

    s.beam.body.mass_kg = real_from_double(11.3636 * vary);
    s.beam.body.inertia_kg_m2 = is_ease ? diagonal(8.81, 8.81, 0.0376) : diagonal(0.0124, 0.0124, 0.0083);
    s.beam.radius_m = real_from_double(0.0606);
    s.beam.length_m = real_from_double(3.048);
    s.beam.drag_strip_kg_m2 = real_from_double(is_ease ? 66.66 : 0);

    s.X_IS.p = random_vector(8);
    s.X_IS.q = random_attitude();
    s.X_IB.p = random_vector(8);
    s.X_IB.q = random_attitude();
    s.p_IP_m = random_vector(8);
    s.axis_I = random_direction();
    s.contact = below(3);
    s.standoff_m = real_from_double(below(2) ? 0.3025 : 0.3631);
    const double* const weight = weights[below(5)];
    s.weight_time_per_s = real_from_double(weight[0]);
    s.weight_impulse_per_Ns = real_from_double(weight[1]);
    s.num_attach_heights = below(4);
    for (int i = 0; i < s.num_attach_heights; i++) {
        s.attach_heights_m[i] = real_from_double(between(-1.5, 1.5));
    }
    s.ring_angle_given = below(2) == 1;
    s.ring_angle_rad = real_from_double(s.ring_angle_given ? between(-6, 6) : 0);
    return s;
}

int main(int argc, char** argv) {
    static ssv_problem_t problem;
    static ssv_plan_t plan;
    if (argc != 3) {
        fputs("usage: plan_hashes SEED COUNT\n", stderr);
        return 64;
    }
    random_state = strtoull(argv[1], NULL, 10);
    const int count = atoi(argv[2]);
    for (int i = 0; i < count; i++) {
        const ssv_scenario_t scenario = random_scenario();
        ssv_fault_t fault;
        const ssv_status_t checked = ssv_problem_init(&problem, &scenario, &fault);
        if (checked != SSV_OK) {
            printf("%d refused %s %s\n", i, fault.field, ssv_status_str(checked));
            continue;
        }
        const ssv_status_t status = ssv_plan(&problem, &plan);
        printf("%d %s %016" PRIx64 " %016" PRIx64 "\n", i, status == SSV_OK ? "ok" : "infeasible", plan.scenario_hash,
               ssv_plan_hash(&plan));
    }
    return 0;
}
