/// Plans COUNT scenarios drawn from SEED around the numbers of both models and prints a line for each: its number, the
/// status and the hashes. Usage: plan_hashes SEED COUNT. Built with different compilers and options, the output must
/// not differ; in fixed point not on other processors either.
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "sample.h"

int main(int argc, char** argv) {
    static ssv_problem_t problem;
    static ssv_work_t work;
    static ssv_plan_t plan;
    if (argc != 3) {
        fputs("usage: plan_hashes SEED COUNT\n", stderr);
        return 64;
    }
    sample_seed(strtoull(argv[1], NULL, 10));
    const int count = atoi(argv[2]);
    for (int i = 0; i < count; i++) {
        ssv_scenario_t scenario = sample_scenario();
        if (i % 2 == 0) scenario.method = SSV_METHOD_OPTIMAL;
        ssv_fault_t fault;
        const ssv_status_t checked = ssv_problem_init(&problem, &scenario, &fault);
        if (checked != SSV_OK) {
            printf("%d refused %s %s\n", i, fault.field, ssv_status_str(checked));
            continue;
        }
        const ssv_status_t status = ssv_plan(&problem, &work, &plan);
        printf("%d %s %016" PRIx64 " %016" PRIx64 "\n", i,
               status == SSV_OK           ? "ok"
               : status == SSV_INFEASIBLE ? "infeasible"
                                          : "overflow",
               plan.quote.scenario_hash, ssv_plan_hash(&plan));
    }
    return 0;
}
