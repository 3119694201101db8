// How long the planner takes for plans, prices, bounds and profiles, by each method; what its answers cost against the
// paper's method; and the same by the paper's own iteration. What it prints is in its --help, below.
#define _GNU_SOURCE
#include <argp.h>
#include <glob.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <lcm/lcm.h>

#include "euler.h"
#include "figures.h"
#include "planner/motion/maneuver.h"
#include "sample.h"
#include "scenario_file.h"
#include "ssv/answer.h"
#include "stack.h"

#define SEED 20261124
#define MAX_REPEATS 300
#define MAX_ROWS 96
#define BOUNDS_PER_SAMPLE 1000
#define ANSWER_TIMEOUT_US 500000
#define ANSWER_TRIES 20
// Random tasks whose times are taken: each the least of a few, so that it tells of the task and not of the machine.
#define TIMED_TASKS 400
#define TIMED_REPEATS 3
#define EULER_REPEATS 30

typedef struct {
    const char* name;
    ssv_method_t method;
    ssv_effort_t effort;
    int repeats; // fewer where planning is slow
    int timed_tasks;
    int priced_tasks;                   // per model and weights
    double plan_goal_ms, quote_goal_ms; // p99; 0: none
} way_t;

// The first is what the others are compared with.
enum { PAPER, QUICK, BEST, NUM_WAYS };
static const way_t ways[NUM_WAYS] = {
    [PAPER] = {"paper", SSV_METHOD_PAPER, SSV_EFFORT_QUICK, MAX_REPEATS, TIMED_TASKS, 1000, 0, 0},
    [QUICK] = {"quick", SSV_METHOD_OPTIMAL, SSV_EFFORT_QUICK, MAX_REPEATS, TIMED_TASKS, 1000, 1, 0.5},
    [BEST] = {"best", SSV_METHOD_OPTIMAL, SSV_EFFORT_BEST, 30, 30, 20, 20, 0},
};

// Of time and of impulse; the least price that coupled motion is known to reach on the case study of model paper, and
// how far above it either effort may stay.
static const struct {
    const char* name;
    double time, impulse, coupled_optimum, quick_goal, best_goal;
} weights[] = {
    {"1, 0", 1, 0, 166.2, 0.06, 0.035},
    {"1, 0.1", 1, 0.1, 628.8, 0.04, 0.02},
    {"1, 1", 1, 1, 3699.7, 0.03, 0.015},
    {"0.01, 1", 0.01, 1, 3399.2, 0.01, 0.005},
};
#define NUM_WEIGHTS ((int)(sizeof weights / sizeof weights[0]))

static const char* const model_name[2] = {"paper", "ease"};

static ssv_work_t work;
static ssv_plan_t plan;
static ssv_quote_t quote;
static report_t goals;

__attribute__((noreturn)) static void give_up(const char* what) {
    fprintf(stderr, "bench_planner: %s\n", what);
    exit(EXIT_FAILURE);
}

static void add_goal(const char* what, double figure, double goal, bool at_least) {
    report_row(&goals);
    report_text(&goals, "goal", what);
    report_figure(&goals, "figure", figure);
    report_text(&goals, "relation", at_least ? ">=" : "<=");
    report_figure(&goals, "wanted", goal);
    report_text(&goals, "result", (at_least ? figure >= goal : figure <= goal) ? "met" : "missed");
}

// ---- Questions ------------------------------------------------------------------------------------------------------

static void check(const ssv_scenario_t* scenario, ssv_problem_t* problem) {
    ssv_fault_t fault;
    if (ssv_problem_init(problem, scenario, &fault) != SSV_OK) give_up(fault.field);
}

/// The problem in this way, the candidates not listed.
static ssv_problem_t problem_of(ssv_scenario_t scenario, const way_t* way) {
    ssv_problem_t problem;
    scenario.method = way->method;
    scenario.effort = way->effort;
    scenario.want_candidates = false;
    check(&scenario, &problem);
    return problem;
}

static void weigh(ssv_scenario_t* scenario, int w) {
    scenario->weight_time_per_s = real_from_double(weights[w].time);
    scenario->weight_impulse_per_Ns = real_from_double(weights[w].impulse);
}

/// Random task number k, the bodies of a model in it.
static ssv_scenario_t model_scenario(int k, bool ease) {
    sample_seed(SEED + (uint64_t)k);
    ssv_scenario_t scenario = sample_scenario();
    scenario.vehicle = model_vehicle();
    scenario.beam = model_beam(ease);
    return scenario;
}

static double plan_ms(const ssv_problem_t* problem) {
    const double start = spent_ms();
    (void)ssv_plan(problem, &work, &plan);
    return spent_ms() - start;
}

static double quote_ms(const ssv_problem_t* problem) {
    const double start = spent_ms();
    (void)ssv_quote(problem, &work, &quote);
    return spent_ms() - start;
}

/// Infinite where no candidate is feasible.
static double price(const ssv_scenario_t* scenario, const way_t* way) {
    ssv_problem_t problem = problem_of(*scenario, way);
    return ssv_quote(&problem, &work, &quote) == SSV_OK ? real_to_double(quote.cost) : (double)INFINITY;
}

static double bound_ns(const ssv_problem_t* problem) {
    volatile double outside;
    const double start = spent_ms();
    for (int i = 0; i < BOUNDS_PER_SAMPLE; i++) {
        outside = real_to_double(ssv_lower_bound(problem));
    }
    (void)outside;
    return (spent_ms() - start) * 1e6 / BOUNDS_PER_SAMPLE;
}

// ---- Over LCM -------------------------------------------------------------------------------------------------------

typedef struct {
    lcm_t* lcm;
    pid_t daemon;
    int64_t last_answered; // request id
} link_t;

static void on_plan(const lcm_recv_buf_t* datagram, const char* channel, void* user) {
    (void)channel;
    link_t* link = user;
    lcm_ssv_plan_t answer;
    if (lcm_ssv_plan_t_decode(datagram->data, 0, (int)datagram->data_size, &answer) < 0) return;
    link->last_answered = answer.answer.asker.request_id;
    lcm_ssv_plan_t_decode_cleanup(&answer);
}

/// Sends the question until its answer comes. @return the time on the wall from the last sending to the answer,
/// decoded.
static double round_trip_ms(link_t* link, const lcm_ssv_task_t* question) {
    uint8_t bytes[8192];
    const int size = lcm_ssv_task_t_encode(bytes, 0, sizeof bytes, question);
    for (int i = 0; i < ANSWER_TRIES; i++) {
        const double start = wall_ms();
        if (size < 0 || lcm_publish(link->lcm, "SSV_SCENARIO", bytes, (unsigned)size) != 0) {
            give_up("cannot send over LCM");
        }
        while (lcm_handle_timeout(link->lcm, ANSWER_TIMEOUT_US / 1000) > 0) {
            if (link->last_answered == question->scenario.asker.request_id) {
                return wall_ms() - start;
            }
        }
    }
    give_up("ssv-plannerd does not answer");
}

/// A daemon of our own on a multicast port of our own.
static void link_open(link_t* link) {
    char url[64];
    snprintf(url, sizeof url, "udpm://239.255.76.67:%d?ttl=0", 20000 + (int)(getpid() % 20000));
    *link = (link_t){lcm_create(url), 0, -1};
    if (link->lcm == NULL) {
        give_up("no LCM over UDP multicast: `bash tests/run.sh -R bench -V` runs this where there is");
    }
    lcm_subscribe(link->lcm, "SSV_PLAN", on_plan, link);
    link->daemon = fork();
    if (link->daemon == 0) {
        prctl(PR_SET_PDEATHSIG, SIGTERM);
        if (freopen("/dev/null", "w", stderr) != NULL) {
            execl(SSV_DAEMON, SSV_DAEMON, "--lcm-url", url, (char*)NULL);
        }
        _exit(127);
    }
}

static void link_close(link_t* link) {
    kill(link->daemon, SIGTERM);
    waitpid(link->daemon, NULL, 0);
    lcm_destroy(link->lcm);
}

// ---- The scenarios of host/scenarios --------------------------------------------------------------------------------

/// One scenario, planned in one way.
typedef struct {
    const char* name;
    const way_t* way;
    lcm_ssv_task_t question;
    ssv_problem_t problem;
    double cost, bound;
    int segments, bytes;
    samples_t calibration_ms, plan_ms, quote_ms, over_lcm_ms, bound_ns;
} row_t;

static int read_scenarios(row_t* rows) {
    static char error[1024];
    ssv_scenario_t scenario;
    glob_t found;
    if (glob(SSV_HOST_DIR "/scenarios/*.yaml", 0, NULL, &found) != 0) {
        give_up("no scenarios in " SSV_HOST_DIR "/scenarios");
    }
    int count = 0;
    for (; count < MAX_ROWS && (size_t)(count / NUM_WAYS) < found.gl_pathc; count++) {
        row_t* row = &rows[count];
        const char* path = found.gl_pathv[count / NUM_WAYS];
        const char* name = strrchr(path, '/') + 1;
        if (!scenario_file_read(path, SSV_HOST_DIR "/models", &row->question, error, sizeof error)) {
            give_up(error);
        }
        row->name = strndup(name, strcspn(name, "."));
        row->way = &ways[count % NUM_WAYS];
        row->question.scenario.options.method = (int8_t)row->way->method;
        row->question.scenario.options.effort = (int8_t)row->way->effort;
        row->question.scenario.options.want_candidates = 0;
        row->question.scenario.asker.request_id = (int64_t)(count + 1) * MAX_REPEATS;
        ssv_scenario_from_wire(&scenario, &row->question.scenario, NULL);
        row->problem = problem_of(scenario, row->way);
    }
    globfree(&found);
    return count;
}

/// One repeat of everything, so that all figures of a row saw the same disturbances.
static void measure(row_t* row, link_t* link) {
    samples_add(&row->calibration_ms, calibrate_ms());
    samples_add(&row->plan_ms, plan_ms(&row->problem));
    samples_add(&row->quote_ms, quote_ms(&row->problem));
    samples_add(&row->over_lcm_ms, round_trip_ms(link, &row->question));
    samples_add(&row->bound_ns, bound_ns(&row->problem));
    row->question.scenario.asker.request_id++;
}

static void measure_scenarios(row_t* rows, int count) {
    static ssv_answer_t answer;
    const lcm_ssv_planner_t planner = ssv_planner_identity(1);
    link_t link;
    link_open(&link);
    lcm_ssv_task_t first = rows[0].question;
    first.scenario.asker.request_id = 0;
    round_trip_ms(&link, &first);     // until the daemon is up
    for (int i = 0; i < count; i++) { // a first, untimed look at each
        if (ssv_answer(&rows[i].question, &planner, &answer) != SSV_OK) give_up(answer.wire.quote.reason);
        rows[i].cost = answer.wire.quote.cost;
        rows[i].bound = answer.wire.quote.cost_lower_bound;
        rows[i].segments = answer.wire.num_segments;
        rows[i].bytes = lcm_ssv_plan_t_encoded_size(&answer.wire);
    }
    for (int repeat = 0; repeat < MAX_REPEATS; repeat++) {
        for (int i = 0; i < count; i++) {
            if (repeat < rows[i].way->repeats) measure(&rows[i], &link);
        }
    }
    link_close(&link);
}

static void report_scenarios(report_t* report, row_t* rows, int count) {
    double worst_plan_ms[NUM_WAYS] = {0}, worst_bound_ns = 0;
    report_section(
        report, "scenarios",
        "Scenarios of host/scenarios: times of a plan and of its price in process, of the round trip over LCM, "
        "and of the lower bound. All but the round trip is processor time, which other programs do not add to.\nplan x "
        "loop: in units of the calibration loop of 100000 dependent roots and "
        "quotients, to compare machines, or versions on a machine whose speed varies");
    for (int i = 0; i < count; i++) {
        row_t* row = &rows[i];
        report_row(report);
        report_text(report, "scenario", row->name);
        report_text(report, "method", row->way->name);
        report_count(report, "repeats", row->plan_ms.count);
        report_samples(report, "plan", "ms", &row->plan_ms);
        report_samples(report, "price", "ms", &row->quote_ms);
        report_figure(report, "price_worst_over_mean",
                      samples_quantile(&row->quote_ms, 1) / samples_mean(&row->quote_ms));
        report_figure(report, "LCM_median_ms", samples_quantile(&row->over_lcm_ms, 0.5));
        report_figure(report, "LCM_p99_ms", samples_quantile(&row->over_lcm_ms, 0.99));
        report_figure(report, "bound_median_ns", samples_quantile(&row->bound_ns, 0.5));
        report_figure(report, "bound_p99_ns", samples_quantile(&row->bound_ns, 0.99));
        const double loop_ms = samples_quantile(&row->calibration_ms, 0.5);
        report_figure(report, "loop_ms", loop_ms);
        report_figure(report, "plan_x_loop", samples_quantile(&row->plan_ms, 0.5) / loop_ms);
        const int way = i % NUM_WAYS;
        worst_plan_ms[way] = fmax(worst_plan_ms[way], samples_quantile(&row->plan_ms, 0.99));
        worst_bound_ns = fmax(worst_bound_ns, samples_quantile(&row->bound_ns, 0.99));
    }
    report_section(
        report, "answers",
        "The same per second, and the answers: J over that of method paper, lower bound over J, segments, bytes");
    for (int i = 0; i < count; i++) {
        row_t* row = &rows[i];
        report_row(report);
        report_text(report, "scenario", row->name);
        report_text(report, "method", row->way->name);
        report_figure(report, "plans_per_s", 1e3 / samples_quantile(&row->plan_ms, 0.5));
        report_figure(report, "prices_per_s", 1e3 / samples_quantile(&row->quote_ms, 0.5));
        report_figure(report, "bounds_per_s", 1e9 / samples_quantile(&row->bound_ns, 0.5));
        report_figure(report, "J", row->cost);
        report_figure(report, "J_over_paper", row->cost / rows[i - i % NUM_WAYS].cost);
        report_figure(report, "bound_over_J", row->bound / row->cost);
        report_count(report, "segments", row->segments);
        report_count(report, "bytes", row->bytes);
    }
    for (int way = QUICK; way < NUM_WAYS; way++) {
        char what[120];
        snprintf(what, sizeof what, "plan of a scenario, %s: p99 [ms]", ways[way].name);
        add_goal(what, worst_plan_ms[way], ways[way].plan_goal_ms, false);
    }
    add_goal("lower bound: p99 [us]", worst_bound_ns / 1e3, 2, false);
}

// ---- Random tasks: times --------------------------------------------------------------------------------------------

static double least_ms(double (*measured_ms)(const ssv_problem_t*), const ssv_problem_t* problem) {
    double least = INFINITY;
    for (int n = 0; n < TIMED_REPEATS; n++) least = fmin(least, measured_ms(problem));
    return least;
}

static void report_random_times(report_t* report) {
    report_section(
        report, "random_times",
        "Random tasks: times of a plan and of its price, each the least of three, so that they tell of the task");
    for (int w = 0; w < NUM_WAYS; w++) {
        samples_t plan_times = {0}, quote_times = {0};
        for (int k = 0; k < ways[w].timed_tasks; k++) {
            sample_seed(SEED + (uint64_t)k);
            ssv_problem_t problem = problem_of(sample_scenario(), &ways[w]);
            samples_add(&plan_times, least_ms(plan_ms, &problem));
            samples_add(&quote_times, least_ms(quote_ms, &problem));
        }
        const double spread = samples_quantile(&quote_times, 1) / samples_mean(&quote_times);
        report_row(report);
        report_text(report, "method", ways[w].name);
        report_count(report, "tasks", ways[w].timed_tasks);
        report_samples(report, "plan", "ms", &plan_times);
        report_figure(report, "plan_worst_over_mean", samples_quantile(&plan_times, 1) / samples_mean(&plan_times));
        report_samples(report, "price", "ms", &quote_times);
        report_figure(report, "price_worst_over_mean", spread);
        if (w == PAPER) continue;
        char what[120];
        snprintf(what, sizeof what, "plan of a random task, %s: p99 [ms]", ways[w].name);
        add_goal(what, samples_quantile(&plan_times, 0.99), ways[w].plan_goal_ms, false);
        if (w != QUICK) continue;
        add_goal("price of a random task, quick: p99 [ms]", samples_quantile(&quote_times, 0.99), ways[w].quote_goal_ms,
                 false);
        add_goal("price of a random task, quick: worst/mean", spread, 3, false);
    }
}

// ---- Profiles -------------------------------------------------------------------------------------------------------

#define MAX_LEGS (MAX_ROWS * SSV_MAX_LEGS)

typedef struct {
    ssv_thrusts_t thrusts;
    ssv_rule_t rule;
    real_t length;
} leg_case_t;

static ssv_thrusts_t thrusts_of(const ssv_problem_t* problem, const ssv_leg_t* leg) {
    ssv_thrusts_t thrusts;
    const ssv_assembly_t assembly = {&problem->scenario.vehicle,
                                     leg->phase == SSV_TRANSFER ? &problem->scenario.beam : NULL, plan.X_SB};
    ssv_maneuver_thrusts(problem, &assembly, (ssv_twist_t){leg->v_S, leg->w_S}, &thrusts);
    return thrusts;
}

static real_t cutoff_of(const ssv_leg_t* leg) {
    return leg->kind == SSV_TRANSLATE ? SSV_CUTOFF_TRANSLATE_M_S : SSV_CUTOFF_TURN_RAD_S;
}

/// The legs of the plans in one way, each by all its ramps from first to last.
static int collect_legs(row_t* rows, int count, int way, ssv_ramp_t ramp, leg_case_t* legs) {
    int num = 0;
    for (int i = way; i < count; i += NUM_WAYS) {
        const ssv_scenario_t* s = &rows[i].problem.scenario;
        plan_ms(&rows[i].problem);
        for (int k = 0; k < plan.num_legs; k++) {
            const ssv_rule_t rule = {ramp, cutoff_of(&plan.leg[k]), s->weight_time_per_s, s->weight_impulse_per_Ns,
                                     REAL(0)};
            legs[num++] = (leg_case_t){thrusts_of(&rows[i].problem, &plan.leg[k]), rule, plan.leg[k].length};
        }
    }
    return num;
}

static void report_profiles(report_t* report, row_t* rows, int count) {
    static leg_case_t legs[MAX_LEGS];
    static const struct {
        const char* name;
        int way;
        ssv_ramp_t ramp;
    } kinds[] = {{"optimal", QUICK, SSV_OPTIMAL},
                 {"paper, full reverse", PAPER, SSV_FULL_REVERSE},
                 {"paper, drag only", PAPER, SSV_DRAG_ONLY}};
    report_section(report, "profiles",
                   "Profiles over the legs of the scenarios' plans (optimal: those of effort quick)");
    for (int n = 0; n < 3; n++) {
        const int num = collect_legs(rows, count, kinds[n].way, kinds[n].ramp, legs);
        samples_t ns = {0};
        for (int repeat = 0; repeat < MAX_REPEATS; repeat++) {
            ssv_profile_t profile;
            const double start = spent_ms();
            for (int k = 0; k < num; k++)
                (void)ssv_profile_solve(&legs[k].thrusts, &legs[k].rule, legs[k].length, &profile);
            samples_add(&ns, (spent_ms() - start) * 1e6 / num);
        }
        report_row(report);
        report_text(report, "profile", kinds[n].name);
        report_count(report, "legs", num);
        report_samples(report, "profile", "ns", &ns);
        report_figure(report, "profiles_per_s", 1e9 / samples_quantile(&ns, 0.5));
    }
}

// ---- The paper's iteration ------------------------------------------------------------------------------------------

/// The case study with the mating side that its tables took: three candidates, one chain each.
static ssv_scenario_t case_study(bool ease) {
    ssv_scenario_t scenario = scenario_case_study(ease);
    scenario.ring_angle_given = true;
    scenario.ring_angle_rad = real_mul(REAL(-0.5), REAL_PI);
    return scenario;
}

static void report_euler(report_t* report) {
    static leg_case_t legs[3 * SSV_MAX_LEGS];
    ssv_scenario_t scenario = case_study(false);
    ssv_problem_t all, problem;
    int num = 0;
    check(&scenario, &all);
    const double half_length = 0.5 * real_to_double(scenario.beam.length_m),
                 heights[3] = {half_length, 0, -half_length};
    double planner_cost = 0;
    for (int c = 0; c < 3; c++) {
        scenario.num_attach_heights = 1;
        scenario.attach_heights_m[0] = real_from_double(heights[c]);
        check(&scenario, &problem);
        plan_ms(&problem);
        planner_cost += real_to_double(plan.quote.cost);
        for (int k = 0; k < plan.num_legs; k++) {
            legs[num++] = (leg_case_t){thrusts_of(&problem, &plan.leg[k]),
                                       {SSV_DRAG_ONLY, cutoff_of(&plan.leg[k]), REAL(0), REAL(0), REAL(0)},
                                       plan.leg[k].length};
        }
    }
    ssv_problem_t quick = problem_of(case_study(false), &ways[QUICK]);
    samples_t euler_ms[2] = {{0}, {0}}, legs_ms = {0}, paper_ms = {0}, quick_ms = {0};
    double euler_cost[2];
    int steps[2];
    for (int repeat = 0; repeat < EULER_REPEATS; repeat++) {
        for (int hold = EULER_HOLD_IN_ONE; hold <= EULER_HOLD_STEPPED; hold++) {
            const double start = spent_ms();
            euler_cost[hold] = 0;
            steps[hold] = 0;
            for (int k = 0; k < num; k++) {
                const euler_price_t leg = euler_price(&legs[k].thrusts, real_to_double(legs[k].length),
                                                      real_to_double(legs[k].rule.cutoff), 1, 1, (euler_hold_t)hold);
                euler_cost[hold] += leg.time_s + leg.impulse_Ns;
                steps[hold] += leg.steps;
            }
            samples_add(&euler_ms[hold], spent_ms() - start);
        }
        for (int k = 0; k < 10; k++) {
            const double start = spent_ms();
            for (int leg = 0; leg < num; leg++) {
                ssv_profile_price_t full_reverse, drag_only;
                ssv_profile_price_ramps(&legs[leg].thrusts, &legs[leg].rule, legs[leg].length, &full_reverse,
                                        &drag_only);
            }
            samples_add(&legs_ms, spent_ms() - start);
            samples_add(&paper_ms, quote_ms(&all));
            samples_add(&quick_ms, quote_ms(&quick));
        }
    }
    static const char* const name[2] = {"ramps stepped, hold at once", "every second stepped"};
    const double paper = samples_quantile(&paper_ms, 0.5), alone = samples_quantile(&legs_ms, 0.5);
    report_section(
        report, "euler",
        "The paper's Euler iteration with steps of 0.01 s over the legs of the case study's three candidates, "
        "against their price by ssv_quote,\nmethod paper (and quick, which prices many more motions), and against "
        "the planner's price of the same legs alone");
    for (int hold = EULER_HOLD_IN_ONE; hold <= EULER_HOLD_STEPPED; hold++) {
        const double euler = samples_quantile(&euler_ms[hold], 0.5);
        report_row(report);
        report_text(report, "iteration", name[hold]);
        report_count(report, "steps", steps[hold]);
        report_figure(report, "Euler_ms", euler);
        report_figure(report, "paper_ms", paper);
        report_figure(report, "legs_ms", alone);
        report_figure(report, "Euler_over_paper", euler / paper);
        report_figure(report, "Euler_over_legs", euler / alone);
        report_figure(report, "Euler_over_quick", euler / samples_quantile(&quick_ms, 0.5));
        report_figure(report, "Euler_J_over_J", euler_cost[hold] / planner_cost);
        char what[120];
        snprintf(what, sizeof what, "Euler, %s: time over the planner's", name[hold]);
        add_goal(what, euler / paper, 100, true);
    }
}

// ---- Prices ---------------------------------------------------------------------------------------------------------

static void report_case_study(report_t* report) {
    report_section(
        report, "case_study",
        "J on the case study, standoff 0.3025 m; what coupled motion is known to reach with model paper, and J "
        "over it");
    for (int ease = 0; ease < 2; ease++) {
        for (int w = 0; w < NUM_WEIGHTS; w++) {
            ssv_scenario_t scenario = scenario_case_study(ease == 1);
            double J[NUM_WAYS];
            weigh(&scenario, w);
            for (int way = 0; way < NUM_WAYS; way++) J[way] = price(&scenario, &ways[way]);
            report_row(report);
            report_text(report, "model", model_name[ease]);
            report_text(report, "weights", weights[w].name);
            for (int way = 0; way < NUM_WAYS; way++) {
                char key[40];
                snprintf(key, sizeof key, "J_%s", ways[way].name);
                report_figure(report, key, J[way]);
            }
            report_figure(report, "quick_over_paper", J[QUICK] / J[PAPER]);
            report_figure(report, "best_over_paper", J[BEST] / J[PAPER]);
            if (ease == 1) continue;
            const double optimum = weights[w].coupled_optimum;
            report_figure(report, "coupled_optimum", optimum);
            report_figure(report, "quick_over_optimum", J[QUICK] / optimum);
            report_figure(report, "best_over_optimum", J[BEST] / optimum);
            char what[120];
            snprintf(what, sizeof what, "case study, weights %s, quick: J above the coupled optimum [%%]",
                     weights[w].name);
            add_goal(what, 100 * (J[QUICK] / optimum - 1), 100 * weights[w].quick_goal, false);
            snprintf(what, sizeof what, "case study, weights %s, best: J above the coupled optimum [%%]",
                     weights[w].name);
            add_goal(what, 100 * (J[BEST] / optimum - 1), 100 * weights[w].best_goal, false);
        }
    }
}

static void report_ratio(report_t* report, const char* on, const char* method, int w, samples_t* ratio) {
    report_row(report);
    report_text(report, "tasks", on);
    report_text(report, "method", method);
    report_text(report, "weights", weights[w].name);
    report_count(report, "number", ratio->count);
    report_figure(report, "J_over_paper_mean", samples_mean(ratio));
    report_figure(report, "J_over_paper_min", samples_quantile(ratio, 0));
    report_figure(report, "J_over_paper_max", samples_quantile(ratio, 1));
}

static void report_ratios(report_t* report, const row_t* rows, int count) {
    report_section(report, "ratios",
                   "J of method optimal over J of method paper: the scenarios, and random tasks of both models");
    for (int way = QUICK; way < NUM_WAYS; way++) {
        for (int w = 0; w < NUM_WEIGHTS; w++) {
            samples_t ratio = {0};
            for (int i = 0; i < count; i += NUM_WAYS) {
                ssv_scenario_t scenario = rows[i].problem.scenario;
                weigh(&scenario, w);
                samples_add(&ratio, price(&scenario, &ways[way]) / price(&scenario, &ways[PAPER]));
            }
            report_ratio(report, "scenarios", ways[way].name, w, &ratio);
        }
        for (int ease = 0; ease < 2; ease++) {
            for (int w = 0; w < NUM_WEIGHTS; w++) {
                samples_t ratio = {0};
                for (int k = 0; k < ways[way].priced_tasks; k++) {
                    ssv_scenario_t scenario = model_scenario(k, ease == 1);
                    weigh(&scenario, w);
                    samples_add(&ratio, price(&scenario, &ways[way]) / price(&scenario, &ways[PAPER]));
                }
                char on[40];
                snprintf(on, sizeof on, "random, model %s", model_name[ease]);
                report_ratio(report, on, ways[way].name, w, &ratio);
            }
        }
    }
}

// ---- Scalars --------------------------------------------------------------------------------------------------------

#define SCALAR_REPEATS 100

/// The core's symbols are the same in every scalar, so each has a program of its own.
static const struct {
    const char *name, *program;
} scalars[] = {{"double", SSV_TIME_double}, {"float", SSV_TIME_float}, {"fixed", SSV_TIME_fixed}};
#define NUM_SCALARS ((int)(sizeof scalars / sizeof scalars[0]))

typedef struct {
    char scenario[64], method[16];
    samples_t plan_ms, price_ms;
} timed_t;

/// @return the number of rows: scenarios and methods in the order they are printed.
static int read_times(const char* program, timed_t rows[MAX_ROWS]) {
    char command[4096], scenario[64], method[16];
    double plan_time_ms = 0, price_time_ms = 0;
    int count = 0;
    snprintf(command, sizeof command, "'%s' %d", program, SCALAR_REPEATS);
    FILE* times = popen(command, "r");
    if (times == NULL) give_up(program);
    while (fscanf(times, "%63s %15s %lf %lf", scenario, method, &plan_time_ms, &price_time_ms) == 4) {
        int k = 0;
        while (k < count && (strcmp(rows[k].scenario, scenario) != 0 || strcmp(rows[k].method, method) != 0)) k++;
        if (k == MAX_ROWS) give_up("too many scenarios");
        if (k == count) {
            rows[count] = (timed_t){0};
            snprintf(rows[count].scenario, sizeof rows[count].scenario, "%s", scenario);
            snprintf(rows[count++].method, sizeof rows[0].method, "%s", method);
        }
        samples_add(&rows[k].plan_ms, plan_time_ms);
        samples_add(&rows[k].price_ms, price_time_ms);
    }
    if (pclose(times) != 0) give_up(program);
    return count;
}

static void report_scalars(report_t* report) {
    static timed_t rows[NUM_SCALARS][MAX_ROWS];
    int count = 0;
    for (int s = 0; s < NUM_SCALARS; s++) count = read_times(scalars[s].program, rows[s]);
    report_section(
        report, "scalars",
        "Scenarios of host/scenarios in each scalar: times of a plan and of its price; on this machine, which has "
        "floating point");
    for (int k = 0; k < count; k++) {
        for (int s = 0; s < NUM_SCALARS; s++) {
            timed_t* row = &rows[s][k];
            report_row(report);
            report_text(report, "scenario", row->scenario);
            report_text(report, "method", row->method);
            report_text(report, "scalar", scalars[s].name);
            report_samples(report, "plan", "ms", &row->plan_ms);
            report_samples(report, "price", "ms", &row->price_ms);
            report_figure(report, "plan_over_double",
                          samples_quantile(&row->plan_ms, 0.5) / samples_quantile(&rows[0][k].plan_ms, 0.5));
        }
    }
}

// ---- Memory ---------------------------------------------------------------------------------------------------------

static void plan_once(void* problem) { plan_ms(problem); }
static void quote_once(void* problem) { quote_ms(problem); }

static void report_memory(report_t* report, row_t* rows, int count) {
    report_section(report, "memory",
                   "Bytes: the plan, the memory that the search works in, and how deep the calls go into the "
                   "stack, at most\nover the scenarios");
    const double kept_KiB = (double)(sizeof(ssv_plan_t) + sizeof(ssv_work_t)) / 1024;
    for (int way = 0; way < NUM_WAYS; way++) {
        size_t plan_stack = 0, quote_stack = 0;
        for (int i = way; i < count; i += NUM_WAYS) {
            const size_t p = stack_high_water(plan_once, &rows[i].problem);
            const size_t q = stack_high_water(quote_once, &rows[i].problem);
            plan_stack = p > plan_stack ? p : plan_stack;
            quote_stack = q > quote_stack ? q : quote_stack;
        }
        report_row(report);
        report_text(report, "method", ways[way].name);
        report_count(report, "plan_bytes", (int)sizeof(ssv_plan_t));
        report_count(report, "work_bytes", (int)sizeof(ssv_work_t));
        report_count(report, "plan_stack_bytes", (int)plan_stack);
        report_count(report, "price_stack_bytes", (int)quote_stack);
        report_figure(report, "plan_and_work_KiB", kept_KiB);
        if (way == PAPER) continue;
        char what[120];
        snprintf(what, sizeof what, "stack of ssv_plan, %s [KiB]", ways[way].name);
        add_goal(what, (double)plan_stack / 1024, 8, false);
    }
    add_goal("ssv_plan_t and the memory to work in [KiB]", kept_KiB, 32, false);
}

// ---- Command line ---------------------------------------------------------------------------------------------------

static const char manual[] =
    "Measures method paper, and method optimal with effort quick and best. For the scenarios in host/scenarios: times "
    "of "
    "plans, prices and lower bounds in process, and of plans as a round trip over LCM to an ssv-plannerd of its own, "
    "beside "
    "a fixed calibration loop. For random tasks: times, and prices against method paper for four pairs of weights. For "
    "single legs: times of profiles, and of the paper's own Euler iteration. Plans in float and in fixed point beside "
    "double. Times are the processor's, but for the round trip, so that what else the machine does hardly counts. The "
    "memory that plans take. In the end the "
    "project's goals, and whether they are met here."
    "\v"
    "It needs LCM over UDP multicast; `bash tests/run.sh -R bench -V` runs it in a private network. Takes about a "
    "minute.\n\n"
    "Exit codes: 0 measured (goals met or not), 1 not possible, 64 wrong usage.\n";

static const struct argp_option option_table[] = {{"json", 'j', NULL, 0, "print JSON instead of tables", 0},
                                                  {NULL, 0, NULL, 0, NULL, 0}};

static error_t parse_option(int key, char* argument, struct argp_state* state) {
    switch (key) {
        case 'j': *(bool*)state->input = true; return 0;
        case ARGP_KEY_ARG: argp_error(state, "unexpected argument '%s'", argument); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

int main(int argc, char** argv) {
    static row_t rows[MAX_ROWS];
    static const struct argp parser = {option_table, parse_option, NULL, manual, NULL, NULL, NULL};
    bool json = false;
    argp_parse(&parser, argc, argv, 0, NULL, &json);

    report_t report = report_new();
    goals = report_new();
    report_section(&goals, "goals", "Goals");
    const int count = read_scenarios(rows);
    measure_scenarios(rows, count);
    report_scenarios(&report, rows, count);
    report_random_times(&report);
    report_profiles(&report, rows, count);
    report_euler(&report);
    report_case_study(&report);
    report_ratios(&report, rows, count);
    report_scalars(&report);
    report_memory(&report, rows, count);
    report_append(&report, &goals);
    if (json) {
        report_print_json(&report);
    } else {
        report_print_tables(&report);
    }
    return EXIT_SUCCESS;
}
