/// Plans the case study in both models and with both methods on the bare core. Prints a line for each: what it is, status,
/// J, plan hash, instructions, bytes of stack. Exit code 0 if every plan is there, else 1.
#include <inttypes.h>
#include <stdio.h>

#include "board.h"
#include "tasks.h"

int main(void) {
    static ssv_problem_t problem;
    static ssv_plan_t plan;
    int missing = 0;
    for (int ease = 0; ease < 2; ease++) {
        for (int method = SSV_METHOD_OPTIMAL; method <= SSV_METHOD_PAPER; method++) {
            ssv_scenario_t scenario = task_case_study(ease == 1);
            ssv_fault_t fault;
            scenario.method = (ssv_method_t)method;
            scenario.want_candidates = false;
            if (ssv_problem_init(&problem, &scenario, &fault) != SSV_OK) return 1;
            board_stack_paint();
            const uint64_t before = board_instructions();
            const ssv_status_t status = ssv_plan(&problem, &plan);
            const uint64_t instructions = board_instructions() - before;
            printf("%s %s %s %.6f %08" PRIx32 "%08" PRIx32 " %.0f %u\n", ease == 1 ? "ease" : "paper",
                   method == SSV_METHOD_PAPER ? "paper" : "optimal", status == SSV_OK ? "ok" : "infeasible",
                   real_to_double(plan.quote.cost), (uint32_t)(plan.plan_hash >> 32), (uint32_t)plan.plan_hash,
                   (double)instructions, (unsigned)board_stack_used());
            if (status != SSV_OK) missing++;
        }
    }
    return missing == 0 ? 0 : 1;
}
