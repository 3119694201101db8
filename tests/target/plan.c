/// Plans the shipped scenarios, each with both methods, the case study among obstacles, then NUM_RANDOM seeded random
/// tasks. Prints a line for each:
/// what it is, method, status, J, plan hash, instructions, bytes of stack. Exit code 0, or 1 if a task is refused or a
/// shipped scenario has no plan.
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "board.h"
#include "sample.h"
#include "shipped.h"

#define SEED 20261122u
#define NUM_RANDOM 60

static const char* word(ssv_status_t status) {
    return status == SSV_OK ? "ok" : status == SSV_INFEASIBLE ? "infeasible" : "overflow";
}

// What a planner takes between its calls.
static ssv_problem_t problem;
static ssv_work_t work;
static ssv_plan_t plan;

/// @return what came of it.
static ssv_status_t try(const char* name, const ssv_scenario_t* scenario) {
    ssv_fault_t fault;
    const ssv_status_t checked = ssv_problem_init(&problem, scenario, &fault);
    if (checked != SSV_OK) {
        printf("%s: %s: %s\n", name, fault.field, ssv_status_str(checked));
        return checked;
    }
    board_stack_paint();
    const uint64_t before = board_instructions();
    const ssv_status_t status = ssv_plan(&problem, &work, &plan);
    const uint64_t instructions = board_instructions() - before;
    printf("%s %s %s %.9g %08" PRIx32 "%08" PRIx32 " %.0f %u\n", name,
           scenario->method == SSV_METHOD_PAPER ? "paper" : "optimal", word(status), real_to_double(plan.quote.cost),
           (uint32_t)(plan.plan_hash >> 32), (uint32_t)plan.plan_hash, (double)instructions,
           (unsigned)board_stack_used());
    return status;
}

#define NUM_OBSTACLES 16

/// The case study among beams that stand in a ring around where its beam lies, and some that lie beside the way to the
/// port.
static ssv_scenario_t among_obstacles(ssv_scene_t* scene) {
    ssv_scenario_t scenario = shipped[0].scenario;
    for (size_t k = 0; k < sizeof shipped / sizeof *shipped; k++) {
        if (strcmp(shipped[k].name, "paper_case") == 0) scenario = shipped[k].scenario;
    }
    for (int k = 0; k < NUM_OBSTACLES; k++) {
        const bool stands = k < NUM_OBSTACLES / 2;
        const int column = k % 4, side = k % 8 < 4 ? -1 : 1;
        const vec3_t foot = vec3(real_from_int(2 * column + 1), real_from_int(stands ? 2 * side : 7 * side),
                                 real_from_int(stands ? -5 : side));
        scene->obstacle[k] = (ssv_obstacle_t){
            SSV_CAPSULE, foot, stands ? vec3(REAL(0), REAL(0), REAL(1)) : vec3(REAL(1), REAL(0), REAL(0)),
            scenario.beam.length_m, scenario.beam.radius_m};
    }
    scene->num_obstacles = NUM_OBSTACLES;
    scenario.scene = scene;
    scenario.obstacles = (UINT64_C(1) << NUM_OBSTACLES) - 1;
    scenario.standoff_m = scenario.vehicle.radius_m + scenario.beam.radius_m;
    scenario.margin_m = REAL(0.03);
    scenario.approach_mate_m = scenario.approach_dock_m = REAL(0.15);
    return scenario;
}

int main(void) {
    static ssv_scene_t scene;
    int missing = 0;
    for (size_t k = 0; k < sizeof shipped / sizeof *shipped; k++) {
        for (int method = SSV_METHOD_OPTIMAL; method <= SSV_METHOD_PAPER; method++) {
            ssv_scenario_t scenario = shipped[k].scenario;
            scenario.method = (ssv_method_t)method;
            if (try(shipped[k].name, &scenario) != SSV_OK) missing++;
        }
    }
    const ssv_scenario_t among = among_obstacles(&scene);
    if (try("16_obstacles", &among) != SSV_OK) missing++;
    sample_seed(SEED);
    for (int i = 0; i < NUM_RANDOM; i++) {
        ssv_scenario_t scenario = sample_scenario();
        scenario.method = i % 2 == 0 ? SSV_METHOD_OPTIMAL : SSV_METHOD_PAPER;
        scenario.want_candidates = false;
        char name[] = "random_00";
        name[7] = (char)('0' + i / 10);
        name[8] = (char)('0' + i % 10);
        if (try(name, &scenario) < SSV_OK) missing++;
    }
    return missing == 0 ? 0 : 1;
}
