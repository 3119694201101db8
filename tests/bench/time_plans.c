/// Plans and prices each shipped scenario REPEATS times by method optimal, effort quick, and by method paper, in the
/// scalar that it is built with: `time_plans REPEATS` prints a line for each time, the scenario, the method, and
/// milliseconds of processor time of plan and price. The scenarios take turns, so that all see the same disturbances.
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "shipped.h"

#define NUM_SHIPPED ((int)(sizeof shipped / sizeof *shipped))

static double spent_ms(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec / 1e6;
}

static void time_one(const char* name, ssv_scenario_t scenario, ssv_method_t method) {
    static ssv_problem_t problem;
    static ssv_work_t work;
    static ssv_plan_t plan;
    static ssv_quote_t quote;
    ssv_fault_t fault;
    scenario.method = method;
    scenario.effort = SSV_EFFORT_QUICK;
    scenario.want_candidates = false;
    if (ssv_problem_init(&problem, &scenario, &fault) != SSV_OK) exit(EXIT_FAILURE);
    const double start_ms = spent_ms();
    const ssv_status_t planned = ssv_plan(&problem, &work, &plan);
    const double between_ms = spent_ms();
    const ssv_status_t priced = ssv_quote(&problem, &work, &quote);
    const double end_ms = spent_ms();
    if (planned != SSV_OK || priced != SSV_OK) exit(EXIT_FAILURE);
    printf("%s %s %.6f %.6f\n", name, method == SSV_METHOD_PAPER ? "paper" : "quick", between_ms - start_ms,
           end_ms - between_ms);
}

int main(int argc, char** argv) {
    if (argc != 2) {
        fputs("usage: time_plans REPEATS\n", stderr);
        return 64;
    }
    const int repeats = atoi(argv[1]);
    for (int n = 0; n < repeats; n++) {
        for (int k = 0; k < NUM_SHIPPED; k++) {
            time_one(shipped[k].name, shipped[k].scenario, SSV_METHOD_PAPER);
            time_one(shipped[k].name, shipped[k].scenario, SSV_METHOD_OPTIMAL);
        }
    }
    return EXIT_SUCCESS;
}
