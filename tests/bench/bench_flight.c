// How many times faster than real time a flight runs: physics with the controller, these with link and executive in one
// process, and all of it as processes with the daemon and LCM between (`ssv fly --sim`). By processor time; the
// processes' is that of all of them.
#define _DEFAULT_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "guided.h"
#include "pilot.h"
#include "shipped.h"

static ssv_problem_t problem;
static ssv_work_t work;
static ssv_plan_t plan;

static double processor_s(void) { return (double)clock() / CLOCKS_PER_SEC; }

static double of_children_s(void) {
    struct rusage used;
    getrusage(RUSAGE_CHILDREN, &used);
    return (double)(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
           1e-6 * (double)(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

// Controller and physics alone: the timeline is uploaded and started, and then only ticks are counted.
static double controller_ratio(double force_max_N) {
    static pilot_t pilot;
    static ssv_timeline_t timeline;
    static sil_config_t config;
    const conditions_t open_loop = {.rate_Hz = 10, .open_loop = true};
    guided_configure(&problem, &plan, force_max_N, &open_loop, &config);
    ssv_timeline_of_plan(&plan, &timeline);
    if (pilot_init(&pilot, &config, &timeline, 1) != NULL || !pilot_await(&pilot, SSV_LINK_EXECUTING, 10)) exit(1);
    // The dead-man waits for no beat here.
    pilot.sil.config.beat_warn_us = pilot.sil.config.beat_stop_us = INT64_MAX / 2;
    const double start_s = processor_s(), from_s = pilot.sil.world.t_s;
    while (pilot.sil.vehicle.state.phase != SSV_LINK_DONE) sil_step(&pilot.sil);
    return (pilot.sil.world.t_s - from_s) / (processor_s() - start_s);
}

static double link_ratio(double force_max_N) {
    static flown_t flown;
    const conditions_t conditions = {.rate_Hz = 10};
    const double start_s = processor_s();
    if (!guided_flight(&problem, &plan, force_max_N, &conditions, 1, &flown) || !flown.docked) exit(1);
    return flown.time_s / (processor_s() - start_s);
}

// Many flights, since one takes hardly longer than its processes to start.
static double processes_ratio(double flown_s) {
    static const char command[] = SSV_PROGRAM " fly " SSV_SCENARIO " --sim --format json > /dev/null";
    const int count = 3;
    const double start_s = of_children_s();
    for (int k = 0; k < count; k++) {
        if (system(command) != 0) {
            fprintf(stderr, "bench_flight: cannot fly: %s\n", command);
            exit(1);
        }
    }
    return count * flown_s / (of_children_s() - start_s);
}

int main(void) {
    ssv_fault_t fault;
    const ssv_scenario_t* scenario = NULL;
    for (size_t k = 0; k < sizeof shipped / sizeof *shipped; k++) {
        if (strcmp(shipped[k].name, "on_axis") == 0) scenario = &shipped[k].scenario;
    }
    if (scenario == NULL || ssv_problem_init(&problem, scenario, &fault) != SSV_OK ||
        ssv_plan(&problem, &work, &plan) != SSV_OK)
        return 1;
    const double force_max_N = real_to_double(scenario->vehicle.force_max_N);
    printf("A flight of on_axis, %.0f s: times faster than real time, by processor time\n",
           real_to_double(plan.quote.time_s));
    printf("  physics and controller              %6.0f  (goal 1000)\n", controller_ratio(force_max_N));
    printf("  with link and executive             %6.0f\n", link_ratio(force_max_N));
    printf("  with daemon and LCM, as processes   %6.0f  (goal 50)\n",
           processes_ratio(real_to_double(plan.quote.time_s)));
    return 0;
}
