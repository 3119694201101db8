#define _POSIX_C_SOURCE 200809L
#include <argp.h>
#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "announce.h"
#include "ask.h"
#include "commands.h"
#include "line.h"
#include "output.h"
#include "price_file.h"
#include "report.h"
#include "scheduler/assembly.h"
#include "scheduler/bound.h"
#include "scheduler/pricing.h"
#include "search_watch.h"
#include "ssv/answer.h"
#include "task_options.h"
#include "wire/message.h"
#include "wire/names.h"

static const char doc[] =
    "Schedules the assembly of a structure: which beam goes to which slot, in which order, at the least sum of J = W1 "
    "time + W2 impulse."
    "\vExamples:\n"
    "  ssv schedule host/structures/ease.yaml\n"
    "  ssv schedule ease.yaml --weights 1,0     time alone counts\n"
    "  ssv schedule ease.yaml --time-limit 10   the best that is found in 10 s, as after Ctrl-C\n"
    "  ssv schedule ease.yaml --lcm             running planners find the prices\n"
    "  ssv schedule ease.yaml --front           what time and impulse can be traded for\n"
    "  ssv schedule ease.yaml --cache prices    asks only for what is not in the file yet\n"
    "  ssv schedule ease.yaml --format json --output schedule.json\n"
    "\n"
    "Every part is priced by the planner, in process and on all cores or over LCM, with what stands then as obstacles. "
    "The table says whether the schedule is proved optimal, that is to say that no other order or choice of beams "
    "costs less by "
    "the planner's prices; and what taking the cheapest part each time would cost. host/FORMATS.md tells of structure "
    "files.\n"
    "\n"
    "Exit codes:\n"
    "   0  schedule found\n"
    "   2  the structure is refused: a file cannot be read, a key or a value is\n"
    "      wrong, or it does not close; the message names the place. Or the\n"
    "      file of --cache is none, or holds what this planner does not say\n"
    "   3  the structure is sound, but there is no schedule, or none was found in\n"
    "      time, or before Ctrl-C\n"
    "   4  nobody answered over LCM, or not in this program's scalar, or LCM does\n"
    "      not work here\n"
    "  64  wrong arguments\n"
    "   1  anything else, e.g. FILE cannot be written\n";

enum { KEY_WEIGHTS = 256, KEY_TIME_LIMIT, KEY_LCM, KEY_TIMEOUT, KEY_CACHE, KEY_FRONT, KEY_FORMAT, KEY_OUTPUT };

static const struct argp_option options_table[] = {
    {"weights", KEY_WEIGHTS, "W1,W2", 0, "Weights of time [1/s] and impulse [1/(N s)] instead of the file's", 0},
    {"time-limit", KEY_TIME_LIMIT, "S", 0, "Stop after so long with the best schedule found (default: none)", 0},
    {"lcm", KEY_LCM, "URL", OPTION_ARG_OPTIONAL,
     "Have all ssv-plannerd that are heard over LCM price the parts, instead of this program", 0},
    {"timeout", KEY_TIMEOUT, "S", 0, "How long to wait for an answer over LCM (default: 10)", 0},
    {"cache", KEY_CACHE, "FILE", 0, "Take prices from there, and add those that are new", 0},
    {"front", KEY_FRONT, NULL, 0,
     "The schedules of five pairs of weights, from time alone to impulse alone, side by side; --time-limit is for each",
     0},
    {"format", KEY_FORMAT, "table|json", 0, "For people (default) or for programs", 0},
    {"output", KEY_OUTPUT, "FILE", 0, "Write there instead of to standard output, which is -", 0},
    {0},
};

typedef struct {
    const char *path, *output_path, *cache_path;
    const char* lcm_url;
    double weights[2], time_limit_s, timeout_s;
    bool weights_given, as_json, over_lcm, want_front;
} arguments_t;

static error_t parse_option(int key, char* argument, struct argp_state* state) {
    arguments_t* const arguments = state->input;
    switch (key) {
        case KEY_WEIGHTS:
            if (!task_parse_weights(argument, arguments->weights)) {
                argp_error(state, "--weights %s: not two numbers with a comma between, e.g. 1,0.5", argument);
            }
            arguments->weights_given = true;
            return 0;
        case KEY_TIME_LIMIT:
            if (!tree_number(argument, &arguments->time_limit_s) ||
                !(arguments->time_limit_s > 0 && arguments->time_limit_s <= 1e6)) {
                argp_error(state, "--time-limit %s: not a number of seconds in (0, 1e6]", argument);
            }
            return 0;
        case KEY_LCM:
            arguments->over_lcm = true;
            arguments->lcm_url = argument;
            if (argument == NULL && state->next < state->argc && strstr(state->argv[state->next], "://") != NULL) {
                arguments->lcm_url = state->argv[state->next++]; // argp leaves "--lcm URL" without a "=" to us
            }
            return 0;
        case KEY_TIMEOUT:
            if (!tree_number(argument, &arguments->timeout_s) ||
                !(arguments->timeout_s > 0 && arguments->timeout_s <= 1e6)) {
                argp_error(state, "--timeout %s: not a number of seconds in (0, 1e6]", argument);
            }
            return 0;
        case KEY_CACHE:
            if (strcmp(argument, "-") == 0) argp_error(state, "--cache -: prices are kept in a file");
            arguments->cache_path = argument;
            return 0;
        case KEY_FRONT: arguments->want_front = true; return 0;
        case ARGP_KEY_END:
            if (arguments->want_front && arguments->weights_given) {
                argp_error(state, "--front has weights of its own: leave out --weights");
            }
            return 0;
        case KEY_FORMAT:
            arguments->as_json = strcmp(argument, "json") == 0;
            if (!arguments->as_json && strcmp(argument, "table") != 0) {
                argp_error(state, "--format %s: there are table and json", argument);
            }
            return 0;
        case KEY_OUTPUT: arguments->output_path = argument; return 0;
        case ARGP_KEY_ARG:
            if (arguments->path != NULL) {
                argp_error(state, "no more than 1 structure at a time, but there is also '%s'", argument);
            }
            arguments->path = argument;
            return 0;
        case ARGP_KEY_NO_ARGS: argp_error(state, "which structure file?"); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

static volatile sig_atomic_t interrupted;

static void interrupt(int number) {
    (void)number;
    interrupted = 1;
}

/// A signal ends the search with what it has; a second one ends the program.
static void take_signals(void) {
    struct sigaction action = {.sa_handler = interrupt, .sa_flags = (int)SA_RESETHAND};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

static bool is_interrupted(void* context) {
    (void)context;
    return interrupted != 0;
}

// ---- The report -----------------------------------------------------------------------------------------------------

/// One part as it will be flown.
typedef struct {
    double time_s[2], impulse_Ns[2]; ///< of transit and transfer
    double attach_height_m, clearance_m;
    int contact;
    bool has_clearance;
} flight_t;

typedef struct {
    const char* shown;
    const char* error; ///< why prices could not be had over LCM, if so
    const structure_t* structure;
    const assembly_result_t* result;
    pricing_counts_t counts;
    double wall_s, first_s;
    bool stopped; ///< before the search was done
    flight_t flight[STRUCTURE_MAX_SLOTS];
    announce_t announce; ///< the schedule as the bus has it
    json_t* tasks;       ///< each with its plan; NULL for people
} report_t;

/// Adds the task as `ssv plan` would write it, with its name. @return false if out of memory.
static bool add_task(json_t* tasks, const report_t* report, int i, const lcm_ssv_task_t* task,
                     const lcm_ssv_plan_t* plan) {
    const assembly_part_t* const part = &report->result->best.part[i];
    const report_plan_t planned = {report->shown, task, plan, false};
    json_t* const json = report_plan_object(&planned);
    return json != NULL &&
           json_object_set_new(json, "name",
                               json_sprintf("%s to %s", report->structure->beam[part->beam].name,
                                            report->structure->slot[part->slot].name)) == 0 &&
           json_array_append_new(tasks, json) == 0;
}

/// Plans the parts, which must cost what they were priced at.
static bool plan_parts(const pricing_t* pricing, report_t* report) {
    static ssv_answer_t answer;
    static lcm_ssv_task_t task;
    const lcm_ssv_planner_t planner = ssv_planner_identity(0);
    const lcm_ssv_plan_t* const plan = &answer.wire;
    const assembly_schedule_t* const schedule = &report->result->best;
    task.scene = *pricing_scene(pricing);
    for (int i = 0; i < schedule->num_parts; i++) {
        flight_t* const flight = &report->flight[i];
        lcm_ssv_schedule_part_t* const part = &report->announce.part[i];
        task.scenario = pricing_scenario(pricing, &schedule->part[i].question);
        ssv_answer(&task, &planner, &answer);
        if (plan->quote.status != LCM_SSV_QUOTE_T_STATUS_OK || plan->quote.cost != schedule->part[i].price.cost) {
            fprintf(stderr, "ssv: part %d is priced at %.9g, but its plan says otherwise\n", i + 1,
                    schedule->part[i].price.cost);
            return false;
        }
        *flight = (flight_t){.attach_height_m = plan->quote.choice.attach_height_m,
                             .contact = plan->quote.choice.contact,
                             .clearance_m = plan->clearance.seen_m,
                             .has_clearance = plan->clearance.obstacle != LCM_SSV_CLEARANCE_T_OBSTACLE_NONE};
        part->scenario_hash = plan->quote.scenario_hash;
        part->plan_hash = plan->plan_hash;
        for (int k = 0; k < plan->num_legs; k++) {
            flight->time_s[plan->legs[k].phase] += plan->legs[k].duration_s;
            flight->impulse_Ns[plan->legs[k].phase] += plan->legs[k].impulse_Ns;
        }
        if (report->tasks != NULL && !add_task(report->tasks, report, i, &task, plan)) return false;
    }
    return true;
}

static void tree_lines(FILE* out, const report_t* report) {
    const assembly_schedule_t* const schedule = &report->result->best;
    for (int i = 0; i < schedule->num_parts; i++) {
        const char* const beam = report->structure->beam[schedule->part[i].beam].name;
        const char* const slot = report->structure->slot[schedule->part[i].slot].name;
        fprintf(out, "  assemble-part %s %s\n", beam, slot);
        for (int phase = SSV_TRANSIT; phase <= SSV_TRANSFER; phase++) {
            fprintf(out, "    %-15s %10.3f s %12.3f N s\n", phase == SSV_TRANSIT ? "fly-to-beam" : "fly-beam-to-hub",
                    report->flight[i].time_s[phase], report->flight[i].impulse_Ns[phase]);
        }
    }
}

static void quality_lines(FILE* out, const report_t* report) {
    const assembly_result_t* const result = report->result;
    if (result->status == HTN_OPTIMAL && result->relied_share == 0) {
        fprintf(out, "Proved optimal");
    } else if (result->status == HTN_OPTIMAL) {
        fprintf(out,
                "Proved optimal as far as no flight costs less than %.2f of the cheapest one past the hubs alone (the "
                "lowest of all prices: %.3f)",
                result->relied_share, result->lowest_share);
    } else if (result->lower_bound > 0) {
        fprintf(out, "Not proved optimal: no schedule costs less than %.3f, so this one is at most %.1f %% above",
                result->lower_bound, 100 * (result->best.cost / result->lower_bound - 1));
    } else {
        fprintf(out, "Not proved optimal, and without a bound: %s",
                bound_fits(report->structure) ? "there was no time" : "there are too many parts for one");
        if (isfinite(result->estimated_least)) {
            fprintf(out, "; by estimates of prices the least is about %.0f, which this is %+.1f %% off",
                    result->estimated_least, 100 * (result->best.cost / result->estimated_least - 1));
        }
    }
    if (result->greedy.num_parts > 0) {
        fprintf(out, "; the cheapest part each time makes J = %.3f, %+.1f %%\n", result->greedy.cost,
                100 * (result->greedy.cost / result->best.cost - 1));
    } else {
        fprintf(out, "; the cheapest part each time %s\n", result->greedy_tried ? "leads nowhere" : "was not tried");
    }
}

static bool report_table(FILE* out, const void* content) {
    const report_t* const report = content;
    const structure_t* const structure = report->structure;
    const assembly_schedule_t* const schedule = &report->result->best;
    double sum = 0;
    fprintf(out, "%s: J = %.9g /s x %.3f s + %.9g /(N s) x %.3f N s = %.3f\n", report->shown,
            structure->task.weight_time_per_s, report->announce.wire.time_s, structure->task.weight_impulse_per_Ns,
            report->announce.wire.impulse_Ns, schedule->cost);
    quality_lines(out, report);
    fprintf(out, "\n  %2s  %-16s %-20s %10s %12s %12s %12s %9s %9s\n", "", "beam", "slot", "time s", "impulse N s", "J",
            "sum of J", "height m", "clear m");
    for (int i = 0; i < schedule->num_parts; i++) {
        const assembly_part_t* const part = &schedule->part[i];
        sum += part->price.cost;
        fprintf(out, "  %2d  %-16s %-20s %10.3f %12.3f %12.3f %12.3f %+9.4f ", i + 1, structure->beam[part->beam].name,
                structure->slot[part->slot].name, part->price.time_s, part->price.impulse_Ns, part->price.cost, sum,
                report->flight[i].attach_height_m);
        if (report->flight[i].has_clearance) {
            fprintf(out, "%9.3f\n", report->flight[i].clearance_m);
        } else {
            fprintf(out, "%9s\n", "-");
        }
    }
    char from[32] = "over LCM";
    if (report->counts.threads > 0) snprintf(from, sizeof from, "on %d threads", report->counts.threads);
    fprintf(out, "\nassemble-structure\n");
    tree_lines(out, report);
    fprintf(out,
            "\n  %" PRIu64 " prices %s, %" PRIu64 " kept from before, %" PRIu64 " known already; %d poses, %" PRIu64
            " states, %" PRIu64 " nodes\n  first schedule after %.1f s, all after %.1f s\n",
            report->counts.asked, from, report->counts.kept, report->counts.known, report->counts.poses,
            report->result->states, report->result->nodes, report->first_s, report->wall_s);
    return true;
}

static json_t* hash_json(uint64_t hash) {
    char text[17];
    snprintf(text, sizeof text, "%016" PRIx64, hash);
    return json_string(text);
}

static json_t* phase_json(const flight_t* flight, ssv_phase_t phase) {
    return json_pack("{s:s,s:f,s:f}", "task", phase == SSV_TRANSIT ? "fly-to-beam" : "fly-beam-to-hub", "time_s",
                     flight->time_s[phase], "impulse_Ns", flight->impulse_Ns[phase]);
}

static json_t* part_json(const report_t* report, int i) {
    const assembly_part_t* const part = &report->result->best.part[i];
    const flight_t* const flight = &report->flight[i];
    const lcm_ssv_schedule_part_t* const told = &report->announce.part[i];
    return json_pack("{s:s,s:s,s:s,s:f,s:f,s:f,s:i,s:f,s:o,s:o,s:o,s:[o,o]}", "task", "assemble-part", "beam",
                     report->structure->beam[part->beam].name, "slot", report->structure->slot[part->slot].name, "cost",
                     part->price.cost, "time_s", part->price.time_s, "impulse_Ns", part->price.impulse_Ns, "contact",
                     flight->contact, "attach_height_m", flight->attach_height_m, "clearance_m",
                     flight->has_clearance ? json_real(flight->clearance_m) : json_null(), "scenario_hash",
                     hash_json((uint64_t)told->scenario_hash), "plan_hash", hash_json((uint64_t)told->plan_hash),
                     "subtasks", phase_json(flight, SSV_TRANSIT), phase_json(flight, SSV_TRANSFER));
}

static bool report_json(FILE* out, const void* content) {
    const report_t* const report = content;
    const assembly_result_t* const result = report->result;
    json_t* const parts = json_array();
    for (int i = 0; i < result->best.num_parts; i++) json_array_append_new(parts, part_json(report, i));
    return wire_json_write(
        out,
        json_pack(
            "{s:{s:s,s:f,s:f,s:f,s:b,s:f,s:f,s:f,s:o,s:o,s:s,s:o},s:{s:I,s:I,s:I,s:i,s:I,s:I,s:i,s:f,s:f},s:O}",
            "schedule", "structure", report->shown, "cost", result->best.cost, "time_s", report->announce.wire.time_s,
            "impulse_Ns", report->announce.wire.impulse_Ns, "optimal", result->status == HTN_OPTIMAL, "lower_bound",
            result->lower_bound, "relied_share", result->relied_share, "lowest_share", result->lowest_share,
            "estimated_least", isfinite(result->estimated_least) ? json_real(result->estimated_least) : json_null(),
            "greedy_cost", result->greedy.num_parts > 0 ? json_real(result->greedy.cost) : json_null(), "task",
            "assemble-structure", "subtasks", parts, "search", "prices", (json_int_t)report->counts.asked, "kept",
            (json_int_t)report->counts.kept, "known", (json_int_t)report->counts.known, "poses", report->counts.poses,
            "states", (json_int_t)result->states, "nodes", (json_int_t)result->nodes, "threads", report->counts.threads,
            "first_s", report->first_s, "wall_s", report->wall_s, "tasks", report->tasks));
}

// ---- The command ----------------------------------------------------------------------------------------------------

/// Names the slots that no beam can be docked at, even where nothing stands but hubs; these prices are known by now.
static void name_blocked_slots(pricing_t* pricing, const report_t* report) {
    static assembly_question_t questions[STRUCTURE_MAX_BEAMS];
    static assembly_price_t answers[STRUCTURE_MAX_BEAMS];
    const structure_t* const structure = report->structure;
    for (int s = 0; s < structure->num_slots; s++) {
        int count = 0;
        bool is_open = false;
        for (int b = 0; b < structure->num_beams; b++) {
            if (!structure_may_take(structure, 0, b, s)) continue;
            questions[count++] = (assembly_question_t){.beam = b, .slot = s, .left = -1};
        }
        if (!pricing_ask(pricing, questions, count, answers)) return;
        for (int i = 0; i < count; i++) is_open = is_open || answers[i].feasible;
        if (is_open) continue;
        fprintf(stderr,
                "ssv: %s:%d: slots[%d]: no beam can be brought to '%s', even with nothing in the way but the hubs\n",
                report->shown, structure->slot[s].line, s, structure->slot[s].name);
    }
}

/// Whether there is a schedule. @return EXIT_OK, or why not after a line on standard error.
static int judge(const arguments_t* arguments, pricing_t* pricing, const report_t* report) {
    const assembly_result_t* const result = report->result;
    if (pricing_is_cache_wrong(pricing)) {
        fprintf(stderr, "ssv: %s holds prices that this planner does not give; remove it\n", arguments->cache_path);
        return EXIT_INVALID;
    }
    if (result->asked_in_vain && !report->stopped) {
        fprintf(stderr, "ssv: %s\n", report->error[0] != '\0' ? report->error : "out of memory");
        return report->error[0] != '\0' ? EXIT_NO_ANSWER : EXIT_FAILED;
    }
    if (result->best.num_parts == 0) {
        fprintf(stderr, "ssv: %s: %s\n", report->shown,
                result->status == HTN_NO_PLAN ? "no schedule: by every order and choice of beams some part has no plan"
                                              : "no schedule was found before the search was stopped");
        if (result->status == HTN_NO_PLAN) name_blocked_slots(pricing, report);
        return EXIT_INFEASIBLE;
    }
    return EXIT_OK;
}

static int show(const arguments_t* arguments, const pricing_t* pricing, report_t* report) {
    const assembly_result_t* const result = report->result;
    char error[512];
    if (!announce_begin(&report->announce, report->structure, report->shown, result, error, sizeof error)) {
        fprintf(stderr, "ssv: %s\n", error);
        return EXIT_FAILED;
    }
    if (!plan_parts(pricing, report)) return EXIT_FAILED;
    if (arguments->over_lcm && !announce_tell(&report->announce, arguments->lcm_url, error, sizeof error)) {
        fprintf(stderr, "ssv: %s\n", error);
        return EXIT_NO_ANSWER;
    }
    return output_report(arguments->output_path, arguments->as_json ? report_json : report_table, report) ? EXIT_OK
                                                                                                          : EXIT_FAILED;
}

// ---- The front ------------------------------------------------------------------------------------------------------

enum { FRONT_POINTS = 5 };

typedef struct {
    double weights[2]; ///< of time and impulse
    double cost, time_s, impulse_Ns;
    bool optimal;
} point_t;

typedef struct {
    const char* shown;
    int count;
    point_t point[FRONT_POINTS];
} front_t;

static void note_point(front_t* front, const report_t* report) {
    point_t* const point = &front->point[front->count++];
    const assembly_schedule_t* const schedule = &report->result->best;
    *point =
        (point_t){.weights = {report->structure->task.weight_time_per_s, report->structure->task.weight_impulse_per_Ns},
                  .cost = schedule->cost,
                  .optimal = report->result->status == HTN_OPTIMAL};
    for (int i = 0; i < schedule->num_parts; i++) {
        point->time_s += schedule->part[i].price.time_s;
        point->impulse_Ns += schedule->part[i].price.impulse_Ns;
    }
}

static bool front_table(FILE* out, const void* content) {
    const front_t* const front = content;
    fprintf(out, "%s: schedules by weights\n\n  %8s %12s %12s %14s %12s\n", front->shown, "W1 1/s", "W2 1/(N s)",
            "time s", "impulse N s", "J");
    for (int i = 0; i < front->count; i++) {
        const point_t* const point = &front->point[i];
        fprintf(out, "  %8g %12g %12.3f %14.3f %12.3f%s\n", point->weights[0], point->weights[1], point->time_s,
                point->impulse_Ns, point->cost, point->optimal ? "" : "  not proved optimal");
    }
    return true;
}

static bool front_json(FILE* out, const void* content) {
    const front_t* const front = content;
    json_t* const points = json_array();
    for (int i = 0; i < front->count; i++) {
        const point_t* const point = &front->point[i];
        json_array_append_new(points, json_pack("{s:[f,f],s:f,s:f,s:f,s:b}", "weights", point->weights[0],
                                                point->weights[1], "cost", point->cost, "time_s", point->time_s,
                                                "impulse_Ns", point->impulse_Ns, "optimal", point->optimal));
    }
    return wire_json_write(out, json_pack("{s:s,s:o}", "structure", front->shown, "front", points));
}

// ---- Prices, and the search -----------------------------------------------------------------------------------------

/// Prices over LCM.
typedef struct {
    ask_prices_t* line;
    char error[1024];
} remote_t;

static bool ask_remote(void* context, const lcm_ssv_task_t* tasks, int count, lcm_ssv_quote_t* quotes) {
    remote_t* const remote = context;
    return ask_prices(remote->line, tasks, count, quotes, NULL, NULL, remote->error, sizeof remote->error);
}

/// Schedules the structure and shows that, or makes it a point of the front where there is one.
static int schedule(const arguments_t* arguments, const structure_t* structure, cache_t* cache, const char* shown,
                    front_t* front) {
    assembly_result_t result;
    remote_t remote = {.line = NULL};
    if (arguments->over_lcm) {
        // The parts are planned here in the end, which must cost the same.
        const ask_target_t target = {arguments->lcm_url, ssv_scalar, arguments->timeout_s};
        remote.line = ask_prices_open(&target, remote.error, sizeof remote.error);
        if (remote.line == NULL) {
            fprintf(stderr, "ssv: %s\n", remote.error);
            return EXIT_NO_ANSWER;
        }
    }
    pricing_t* const pricing =
        arguments->over_lcm ? pricing_open_elsewhere(structure, ask_remote, &remote) : pricing_open(structure, 0);
    if (pricing != NULL) pricing_use(pricing, cache);
    search_watch_t watch = search_watch_begin(pricing, arguments->time_limit_s, is_interrupted, NULL);
    const assembly_prices_t prices = {pricing_ask, pricing};
    const assembly_limits_t limits = {search_watch_must_stop, search_watch_found, &watch};
    if (pricing == NULL) {
        fprintf(stderr, "ssv: out of memory\n");
        ask_prices_close(remote.line);
        return EXIT_FAILED;
    }
    char refused[256];
    if (!pricing_check(pricing, refused, sizeof refused)) {
        fprintf(stderr, "ssv: %s: %s\n", shown, refused);
        pricing_close(pricing);
        ask_prices_close(remote.line);
        return EXIT_INVALID;
    }
    if (remote.line != NULL) ask_prices_stop(remote.line, search_watch_must_stop, &watch);
    take_signals();
    const bool sound = assembly_schedule(structure, &prices, &limits, &result);
    search_watch_end(&watch);
    static report_t report;
    report = (report_t){.shown = shown,
                        .error = remote.error,
                        .structure = structure,
                        .result = &result,
                        .counts = pricing_counts(pricing),
                        .wall_s = line_now_s() - watch.begun_s,
                        .first_s = watch.first_s,
                        .stopped = watch.stopped,
                        .tasks = arguments->as_json ? json_array() : NULL};
    if (!sound) fprintf(stderr, "ssv: out of memory\n");
    int code = sound ? judge(arguments, pricing, &report) : EXIT_FAILED;
    if (code == EXIT_OK && front == NULL) code = show(arguments, pricing, &report);
    if (code == EXIT_OK && front != NULL) note_point(front, &report);
    json_decref(report.tasks);
    pricing_close(pricing);
    ask_prices_close(remote.line);
    return code;
}

/// One schedule, or one for each pair of weights.
static int schedule_all(const arguments_t* arguments, structure_t* structure, cache_t* cache, const char* shown) {
    static const double weights[FRONT_POINTS][2] = {{1, 0}, {1, 0.1}, {1, 1}, {0.1, 1}, {0, 1}};
    if (!arguments->want_front) return schedule(arguments, structure, cache, shown, NULL);
    front_t front = {.shown = shown};
    int code = EXIT_OK;
    for (int i = 0; i < FRONT_POINTS && code == EXIT_OK && interrupted == 0; i++) {
        structure->task.weight_time_per_s = weights[i][0];
        structure->task.weight_impulse_per_Ns = weights[i][1];
        code = schedule(arguments, structure, cache, shown, &front);
    }
    if (code != EXIT_OK) return code;
    return output_report(arguments->output_path, arguments->as_json ? front_json : front_table, &front) ? EXIT_OK
                                                                                                        : EXIT_FAILED;
}

/// Likewise with prices from a file, and to it.
static int schedule_with_cache(const arguments_t* arguments, structure_t* structure, const char* shown) {
    char head[160], error[512] = "out of memory";
    snprintf(head, sizeof head, "planner %s, %s, effort %s, steps %d", SSV_VERSION, ssv_scalar,
             name_of(&names_effort, structure->task.options.effort), PRICING_STEPS);
    cache_t* const cache = cache_open(head);
    if (cache == NULL || !price_file_read(cache, arguments->cache_path, error, sizeof error)) {
        fprintf(stderr, "ssv: %s\n", error);
        cache_close(cache);
        return cache == NULL ? EXIT_FAILED : EXIT_INVALID;
    }
    const int before = cache_count(cache);
    int code = schedule_all(arguments, structure, cache, shown);
    const bool has_more = cache_count(cache) > before && code != EXIT_INVALID;
    if (has_more && !price_file_write(cache, arguments->cache_path) && code == EXIT_OK) code = EXIT_FAILED;
    cache_close(cache);
    return code;
}

int schedule_command(int argc, char** argv) {
    static const struct argp parser = {
        .options = options_table, .parser = parse_option, .args_doc = "STRUCTURE", .doc = doc};
    static structure_t structure;
    arguments_t arguments = {.timeout_s = 10};
    char name[] = "ssv schedule", error[1024], shown[256];
    argv[0] = name;
    argp_parse(&parser, argc, argv, 0, NULL, &arguments);
    snprintf(shown, sizeof shown, "%s", strcmp(arguments.path, "-") == 0 ? "standard input" : arguments.path);
    tree_make_harmless(shown);
    char* const models = task_data_folder(SSV_MODELS_FROM_BIN);
    if (models == NULL) {
        fprintf(stderr, "ssv: out of memory\n");
        return EXIT_FAILED;
    }
    const bool sound = structure_read(&structure, arguments.path, models, error, sizeof error);
    free(models);
    if (!sound) {
        fprintf(stderr, "ssv: %s\n", error);
        return EXIT_INVALID;
    }
    if (arguments.weights_given) {
        structure.task.weight_time_per_s = arguments.weights[0];
        structure.task.weight_impulse_per_Ns = arguments.weights[1];
    }
    return arguments.cache_path != NULL ? schedule_with_cache(&arguments, &structure, shown)
                                        : schedule_all(&arguments, &structure, NULL, shown);
}
