// Distances as the judge of the clearance tests measures them, along plans of the four scenes: clearance_pairs FIRST
// COUNT. A line for each pair at each of some poses: the body's axis from and to, its radius; kind of the obstacle, its
// point and axis, length and radius; the distance.
#include <stdio.h>
#include <stdlib.h>

#include "sample.h"
#include "scenes.h"

#define POSES 10

static void print_point(vec3_t p) { printf(" %.17g %.17g %.17g", p.x, p.y, p.z); }

static void print_pair(const ssv_obstacle_t* body, const ssv_obstacle_t* obstacle) {
    printf("%d", (int)obstacle->kind);
    print_point(body->p_I_m);
    print_point(body->axis_I);
    printf(" %.17g %.17g", body->length_m, body->radius_m);
    print_point(obstacle->p_I_m);
    print_point(obstacle->axis_I);
    printf(" %.17g %.17g %.17g\n", obstacle->length_m, obstacle->radius_m, scene_apart(body, obstacle));
}

// The hull, and once mated the beam, where they are in the middle of so many parts of each leg.
static void print_pairs(const ssv_scenario_t* s, const ssv_plan_t* plan) {
    for (int k = 0; k < plan->num_legs; k++) {
        for (int n = 0; n < POSES; n++) {
            ssv_sample_t sample;
            ssv_plan_sample(plan, plan->leg[k].t_start_s + (n + 0.5) / POSES * plan->leg[k].duration_s, &sample);
            const ssv_obstacle_t hull = {SSV_CAPSULE, sample.X_IS.p, vec3(0, 0, 1), 0, s->vehicle.radius_m};
            const pose_t X_IB = pose_mul(sample.X_IS, plan->X_SB);
            const vec3_t along = quat_apply(X_IB.q, vec3(0, 0, 1));
            const ssv_obstacle_t beam = {SSV_CAPSULE, vec3_sub(X_IB.p, vec3_scale(s->beam.length_m / 2, along)), along,
                                         s->beam.length_m, s->beam.radius_m};
            for (int o = 0; o < s->scene->num_obstacles; o++) {
                print_pair(&hull, &s->scene->obstacle[o]);
                if (sample.mated) print_pair(&beam, &s->scene->obstacle[o]);
            }
        }
    }
}

int main(int argc, char** argv) {
    static ssv_scene_t scene;
    static ssv_problem_t problem;
    static ssv_work_t work;
    static ssv_plan_t plan;
    ssv_fault_t fault;
    if (argc != 3) return 64;
    for (int k = atoi(argv[1]); k < atoi(argv[1]) + atoi(argv[2]); k++) {
        sample_seed(20261128u + (uint64_t)k);
        const ssv_scenario_t s = scene_task((scene_kind_t)(k % SCENE_KINDS), &scene);
        if (ssv_problem_init(&problem, &s, &fault) == SSV_OK && ssv_plan(&problem, &work, &plan) == SSV_OK)
            print_pairs(&s, &plan);
    }
    return 0;
}
