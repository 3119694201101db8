// One flight: has a task flown, in simulation or by a real vehicle, shows how it gets on, and keeps what was flown.
#define _GNU_SOURCE
#include "flight.h"

#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include "ask.h"
#include "commands.h"
#include "line.h"
#include "processes.h"
#include "wire/message.h"
#include "wire/names.h"

/// [s] How often a terminal's line is rewritten.
#define LINE_PERIOD_S 0.1
#define LINE_COLUMNS_MAX 200
/// [s] From when on a vehicle that says nothing is worth a word.
#define SILENCE_S 0.5
/// [s] Longest time constant of thrusters that ssv-plannerd takes.
#define LAG_MAX_S 10.0

/// Exit codes of ssv-sim: conditions that are none; no port, or no bus.
enum { SIM_EXIT_INPUT = 65, SIM_EXIT_PORT = 69 };

/// The simulated vehicle and its planner, with what they are started with.
typedef struct {
    process_t simulator, planner;
    char conditions[PATH_MAX]; ///< path; empty = none
    double lag_s;
    int plan_file;
    bool failed; ///< one of them ended during the flight
} simulation_t;

/// A flight, and what has come of it so far.
typedef struct {
    const task_options_t* options;
    const lcm_ssv_plan_t* plan; ///< predicted, until the planner's own is there
    simulation_t* simulation;   ///< NULL = a real vehicle
    flight_signals_t* signals;
    int num_signals; ///< that had come before
    flight_result_t* result;
    int leg_at;
    int32_t sequence;
    double plan_time_s, flown_s, impulse_Ns; ///< when there was news last
    double leg_flown_s, leg_impulse_Ns;      ///< when the leg began
    int8_t state, goal;                      ///< that a line was written about last
    int32_t attempts, num_plans, num_texts;  ///< likewise
    bool on_terminal, line_is_open;
    double line_at_s;
} flight_t;

// ---- What was flown -------------------------------------------------------------------------------------------------

static void enter_leg(flight_t* flight, double flown_s, double impulse_Ns) {
    report_leg_t* leg = &flight->result->leg[flight->leg_at];
    leg->time_s = flown_s - flight->leg_flown_s;
    leg->impulse_Ns = impulse_Ns - flight->leg_impulse_Ns;
}

/// Adds what is new to the legs. A leg ends when the plan's clock passes its end: the wait before mate or dock, while
/// that clock stands, is part of the leg before it. Between two messages all three grow evenly.
static void note_legs(flight_t* flight, const lcm_ssv_execution_t* news) {
    const lcm_ssv_plan_t* plan = flight->plan;
    if (news->num_plans > 1 || news->state < LCM_SSV_EXECUTION_T_STATE_TRACKING) return;
    while (flight->leg_at + 1 < plan->num_legs) {
        const double end_s = plan->legs[flight->leg_at + 1].t_start_s, span_s = news->plan_time_s - flight->plan_time_s;
        if (news->plan_time_s <= end_s + 1e-6) break;
        const double part = span_s > 0 ? fmin(fmax((end_s - flight->plan_time_s) / span_s, 0), 1) : 0;
        const double flown_s = flight->flown_s + part * (news->flown_s - flight->flown_s);
        const double impulse_Ns = flight->impulse_Ns + part * (news->impulse_Ns - flight->impulse_Ns);
        enter_leg(flight, flown_s, impulse_Ns);
        flight->result->leg[flight->leg_at].begun = flight->result->leg[flight->leg_at].ended = true;
        flight->leg_flown_s = flown_s;
        flight->leg_impulse_Ns = impulse_Ns;
        flight->leg_at++;
    }
    if (news->plan_time_s == flight->plan_time_s)
        flight->result->leg[flight->leg_at].wait_s += news->flown_s - flight->flown_s;
    enter_leg(flight, news->flown_s, news->impulse_Ns);
    flight->result->leg[flight->leg_at].begun = news->flown_s > 0;
    flight->result->leg[flight->leg_at].ended = news->outcome == LCM_SSV_EXECUTION_T_OUTCOME_DOCKED;
    flight->plan_time_s = news->plan_time_s;
    flight->flown_s = news->flown_s;
    flight->impulse_Ns = news->impulse_Ns;
}

// ---- What is shown meanwhile ----------------------------------------------------------------------------------------

/// Whole millimetres, none of them -0.
static long mm(double m) { return lround(1e3 * m); }

static void describe(const flight_t* flight, const lcm_ssv_execution_t* news, char* text, size_t size) {
    const char* const state = name_of(&names_state, news->state);
    char link[64] = "";
    const int length =
        news->link_lost > 0 ? snprintf(link, sizeof link, ", %" PRId64 " frames lost", news->link_lost) : 0;
    if (news->link_silence_s > SILENCE_S)
        snprintf(link + length, sizeof link - (size_t)length, ", silent for %.1f s", news->link_silence_s);
    if (news->state == LCM_SSV_EXECUTION_T_STATE_UPLOADING) {
        snprintf(text, size, "%s %d of %d bytes%s", state, news->uploaded_bytes, news->upload_bytes, link);
    } else if (news->state == LCM_SSV_EXECUTION_T_STATE_TRACKING) {
        const lcm_ssv_leg_t* leg = &flight->plan->legs[flight->leg_at];
        snprintf(text, size, "%s to %s: %.1f of %.1f s, leg %d/%d %s%s, %ld mm behind, %ld beside%s", state,
                 name_of(&names_goal, news->goal), news->plan_time_s, news->plan_duration_s, flight->leg_at + 1,
                 flight->plan->num_legs, name_of(&names_kind, leg->kind), news->clock_rate > 0 ? "" : " waits",
                 mm(news->behind_m), mm(news->beside_m), link);
    } else if (news->state == LCM_SSV_EXECUTION_T_STATE_ENDED) {
        snprintf(text, size, "%s", name_of(&names_outcome, news->outcome));
    } else {
        snprintf(text, size, "%s%s", state, link);
    }
}

static void end_line(flight_t* flight) {
    if (flight->line_is_open) fputs("\r\033[K", stderr);
    flight->line_is_open = false;
}

/// A line of its own, that stays.
static void say(flight_t* flight, double time_s, const char* text) {
    end_line(flight);
    fprintf(stderr, "%8.1f s  %s\n", time_s, text);
}

/// One line at each change; on a terminal one more below them, that is rewritten.
static void show(flight_t* flight, const lcm_ssv_execution_t* news) {
    char text[LINE_COLUMNS_MAX + 1];
    const double t_s = line_now_s();
    describe(flight, news, text, sizeof text);
    if (news->num_texts != flight->num_texts && news->text[0] != '\0') {
        char told[LINE_COLUMNS_MAX + 1];
        snprintf(told, sizeof told, "the vehicle says: %s", news->text);
        say(flight, news->time_s, told);
    }
    if (news->num_plans > 1 && news->num_plans != flight->num_plans)
        say(flight, news->time_s, "strayed from the plan; flies a new one from where it is");
    if (news->state != flight->state || news->goal != flight->goal || news->attempts != flight->attempts)
        say(flight, news->time_s, text);
    flight->state = news->state;
    flight->goal = news->goal;
    flight->attempts = news->attempts;
    flight->num_plans = news->num_plans;
    flight->num_texts = news->num_texts;
    if (!flight->on_terminal || t_s < flight->line_at_s || news->state == LCM_SSV_EXECUTION_T_STATE_ENDED) return;
    struct winsize window;
    const bool is_known = ioctl(STDERR_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 0;
    fprintf(stderr, "\r\033[K%.*s", is_known ? window.ws_col - 1 : 79, text);
    flight->line_is_open = true;
    flight->line_at_s = t_s + LINE_PERIOD_S;
}

/// What ask_flight calls.
static ask_wish_t turn(const lcm_ssv_plan_t* plan, const lcm_ssv_execution_t* news, void* context) {
    flight_t* flight = context;
    const int num_signals = flight_count_signals(flight->signals) - flight->num_signals;
    if (plan != NULL) flight->plan = plan;
    if (news != NULL) {
        flight->result->news_lost += news->sequence > flight->sequence + 1 ? news->sequence - flight->sequence - 1 : 0;
        flight->sequence = news->sequence;
        note_legs(flight, news);
        (void)flown_note_execution(&flight->result->flown, news);
        show(flight, news);
    }
    simulation_t* simulation = flight->simulation;
    const bool has_ended = news != NULL && news->state == LCM_SSV_EXECUTION_T_STATE_ENDED;
    if (simulation != NULL && !has_ended)
        simulation->failed = !process_runs(&simulation->simulator) || !process_runs(&simulation->planner);
    if (num_signals > 1 || (simulation != NULL && simulation->failed)) return ASK_LEAVE;
    return num_signals > 0 ? ASK_STOP : ASK_GO_ON;
}

/// What ask_flight calls, too.
static void note_state(const lcm_ssv_vehicle_state_t* state, bool is_truth, void* context) {
    const flight_t* const flight = context;
    (void)(is_truth ? flown_note_truth : flown_note_estimate)(&flight->result->flown, state);
}

// ---- The simulation -------------------------------------------------------------------------------------------------

/// A name stands for one of the conditions that ssv knows, anything with a slash or .yaml is a path.
static bool find_conditions(const char* name, char* path, size_t size, char* error, size_t error_size) {
    const size_t length = strlen(name);
    const bool is_path = strchr(name, '/') != NULL || (length > 5 && strcmp(name + length - 5, ".yaml") == 0);
    char* const folder = task_data_folder(SSV_CONDITIONS_FROM_BIN);
    const int written = is_path ? snprintf(path, size, "%s", name)
                                : snprintf(path, size, "%s/%s.yaml", folder == NULL ? "" : folder, name);
    const bool is_there = written > 0 && (size_t)written < size && (is_path || access(path, F_OK) == 0);
    if (!is_there) {
        snprintf(error, error_size,
                 "--conditions %.64s: there is no %.64s.yaml in %.512s; give one of your own by its path", name, name,
                 folder == NULL ? "the conditions folder" : folder);
        tree_make_harmless(error);
    }
    free(folder);
    return is_there;
}

/// The one condition that guidance is told, since a good bench finds it. The simulator judges the rest of the file.
static bool read_lag(const char* path, double* lag_s, char* error, size_t error_size) {
    tree_error_t fault = {error, error_size};
    tree_memory_t memory = {NULL};
    size_t size = 0;
    error[0] = '\0';
    char* const text = tree_file_read(path, &size, &fault);
    const tree_t* const root = text == NULL ? NULL : tree_from_yaml(&memory, &fault, path, text, size);
    const tree_t* const thrusters = root == NULL || root->kind != TREE_MAP ? NULL : tree_get(root, "thrusters");
    const tree_t* const lag = thrusters == NULL || thrusters->kind != TREE_MAP ? NULL : tree_get(thrusters, "lag_s");
    const bool is_number = lag != NULL && (lag->kind == TREE_REAL || lag->kind == TREE_INTEGER);
    *lag_s = is_number ? fmin(fmax(lag->real, 0), LAG_MAX_S) : 0;
    tree_memory_free(&memory);
    free(text);
    return root != NULL;
}

/// The last line of a log, which says why a program ended.
static void last_line(const process_t* process, char* text, size_t size) {
    char* const log = process_log(process);
    size_t length = log == NULL ? 0 : strlen(log);
    while (length > 0 && log[length - 1] == '\n') log[--length] = '\0';
    const char* const newline = length == 0 ? NULL : strrchr(log, '\n');
    snprintf(text, size, "%s", newline != NULL ? newline + 1 : length > 0 ? log : "it left no word");
    tree_make_harmless(text);
    free(log);
}

static bool start_simulator(simulation_t* simulation, const flight_t* flight, char* link, char* lockstep, size_t size,
                            char* error, size_t error_size) {
    const task_options_t* options = flight->options;
    char url[512];
    snprintf(url, sizeof url, "--lcm-url=%s", options->lcm_url == NULL ? "" : options->lcm_url);
    char* argv[] = {"ssv-sim",
                    "-",
                    "--link",
                    "udp-listen:0",
                    "--lockstep",
                    "0",
                    url,
                    "--seed",
                    options->seed == NULL ? "1" : (char*)(uintptr_t)options->seed,
                    simulation->conditions[0] == '\0' ? NULL : "--conditions",
                    simulation->conditions,
                    NULL};
    return process_start(&simulation->simulator, argv[0], argv, simulation->plan_file, error, error_size) &&
           process_await(&simulation->simulator, "link on UDP port ", flight->signals->fd, link, size, error,
                         error_size) &&
           process_await(&simulation->simulator, "lockstep on UDP port ", flight->signals->fd, lockstep, size, error,
                         error_size);
}

/// @return false with a sentence in `error`, or none where the planner's id is not what it should be.
static bool start_planner(simulation_t* simulation, const flight_t* flight, const char* link, char* lockstep,
                          int64_t* planner_id, char* error, size_t error_size) {
    const task_options_t* options = flight->options;
    const bool is_default = strcmp(REAL_NAME, SSV_DEFAULT_SCALAR) == 0;
    char name[32], where[64], lag[40], rate[40], url[512], id[200];
    char* argv[16] = {name, "--link", where, "--lockstep", lockstep, lag};
    int argc = 6;
    snprintf(name, sizeof name, "ssv-plannerd%s%s", is_default ? "" : "-", is_default ? "" : REAL_NAME);
    snprintf(where, sizeof where, "udp:127.0.0.1:%s", link);
    snprintf(lag, sizeof lag, "--thruster-lag=%.17g", simulation->lag_s);
    snprintf(rate, sizeof rate, "--rate=%.17g", options->rate);
    snprintf(url, sizeof url, "--lcm-url=%s", options->lcm_url);
    if (options->rate > 0) argv[argc++] = rate;
    if (options->lcm_url != NULL) argv[argc++] = url;
    if (!process_start(&simulation->planner, name, argv, -1, error, error_size) ||
        !process_await(&simulation->planner, ", planner ", flight->signals->fd, id, sizeof id, error, error_size))
        return false;
    *planner_id = (int64_t)strtoull(id, NULL, 16);
    return *planner_id != 0;
}

/// Starts the simulated vehicle and its planner. @return EXIT_OK, or another exit code after a line on standard error.
static int start(simulation_t* simulation, const flight_t* flight, int64_t* planner_id) {
    char error[1024] = "the planner told no id", reason[1024], link[16], lockstep[16];
    if (!start_simulator(simulation, flight, link, lockstep, sizeof link, error, sizeof error)) {
        const bool has_ended = simulation->simulator.output >= 0 && !process_runs(&simulation->simulator);
        const int code = has_ended ? process_end(&simulation->simulator, false) : 0;
        if (has_ended) last_line(&simulation->simulator, error, sizeof error);
        fprintf(stderr, "ssv: %s\n", error);
        return code == SIM_EXIT_INPUT ? EXIT_INVALID : code == SIM_EXIT_PORT ? EXIT_NO_ANSWER : EXIT_FAILED;
    }
    if (!start_planner(simulation, flight, link, lockstep, planner_id, error, sizeof error)) {
        const bool has_ended = simulation->planner.output >= 0 && !process_runs(&simulation->planner);
        if (has_ended) {
            last_line(&simulation->planner, reason, sizeof reason);
            snprintf(error, sizeof error, "ssv-plannerd: %.900s", reason);
        }
        fprintf(stderr, "ssv: %s\n", error);
        return has_ended ? EXIT_NO_ANSWER : EXIT_FAILED;
    }
    return EXIT_OK;
}

/// Ends both; the simulator first, whose time stands still by now. @return what it says about the flight, which the
/// caller frees with json_decref; NULL if nothing.
static json_t* end(simulation_t* simulation, bool kills) {
    process_end(&simulation->simulator, kills);
    process_end(&simulation->planner, kills);
    char* const verdict = process_output(&simulation->simulator);
    json_t* const truth = verdict == NULL ? NULL : json_loads(verdict, 0, NULL);
    free(verdict);
    process_close(&simulation->simulator);
    process_close(&simulation->planner);
    if (simulation->plan_file >= 0) close(simulation->plan_file);
    return truth;
}

/// What ssv-sim reads: the plan as `ssv plan --format json` writes it.
static int write_plan(const report_plan_t* plan) {
    const int file = process_scratch();
    FILE* const out = file < 0 ? NULL : fdopen(dup(file), "w");
    const bool written = out != NULL && report_plan_json(out, plan);
    if ((out != NULL && fclose(out) != 0) || !written) {
        if (file >= 0) close(file);
        return -1;
    }
    return file;
}

// ---- The flight -----------------------------------------------------------------------------------------------------

static int exit_code(const lcm_ssv_execution_t* end, const json_t* truth) {
    if (report_touches(truth)) return EXIT_TOUCHED;
    switch (end->outcome) {
        case LCM_SSV_EXECUTION_T_OUTCOME_DOCKED: return EXIT_OK;
        case LCM_SSV_EXECUTION_T_OUTCOME_MISSED: return EXIT_MISSED;
        default: return EXIT_ABORTED;
    }
}

bool flight_take_signals(flight_signals_t* signals) {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGHUP);
    const bool blocked = sigprocmask(SIG_BLOCK, &set, NULL) == 0;
    *signals = (flight_signals_t){.fd = blocked ? signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK) : -1};
    if (signals->fd < 0) fprintf(stderr, "ssv: the system gives no files for a flight: %s\n", strerror(errno));
    return signals->fd >= 0;
}

int flight_count_signals(flight_signals_t* signals) {
    struct signalfd_siginfo signal;
    while (read(signals->fd, &signal, sizeof signal) == (ssize_t)sizeof signal) signals->count++;
    return signals->count;
}

/// Has the plan flown. @return the exit code.
static int fly(flight_t* flight, const report_plan_t* predicted, lcm_ssv_task_t* question, int64_t planner_id) {
    const task_options_t* options = flight->options;
    simulation_t* simulation = flight->simulation;
    flight_result_t* const result = flight->result;
    const ask_target_t target = {options->lcm_url, simulation != NULL ? NULL : options->scalar,
                                 options->timeout_s + (options->rate > 0 ? 1 / options->rate : 0)};
    // A planner of another arithmetic rounds otherwise.
    const bool is_same = simulation != NULL || options->scalar == NULL || strcmp(options->scalar, REAL_NAME) == 0;
    const ask_flight_t how = {
        planner_id, is_same ? predicted->plan->plan_hash : 0, flight->signals->fd, turn, note_state, flight};
    char error[1024], reason[400] = "";
    int code = EXIT_NO_ANSWER;
    const double start_s = line_now_s();
    result->has_answer = ask_flight(&target, &how, question, &result->plan, &result->end, error, sizeof error);
    result->wall_s = line_now_s() - start_s;
    end_line(flight);
    if (simulation != NULL && simulation->failed) {
        const bool is_simulator = !process_runs(&simulation->simulator);
        last_line(is_simulator ? &simulation->simulator : &simulation->planner, reason, sizeof reason);
        snprintf(error, sizeof error, "%s has ended during the flight: %s", is_simulator ? "ssv-sim" : "ssv-plannerd",
                 reason);
        if (is_simulator) code = EXIT_ABORTED; // as where its silence is noticed first
    }
    result->truth = simulation == NULL ? NULL : end(simulation, !result->has_answer);
    if (!result->has_answer) {
        fprintf(stderr, "ssv: %s\n", error);
        if (simulation == NULL && flight->sequence > 0)
            fprintf(stderr, "ssv: the vehicle may still be moving; its planner and its dead-man have it now\n");
        return flight_count_signals(flight->signals) > flight->num_signals ? EXIT_ABORTED : code;
    }
    if (result->plan.quote.status == LCM_SSV_QUOTE_T_STATUS_INVALID) { // the task is sound, a plan of it was made here
        tree_make_harmless(result->plan.quote.reason);
        fprintf(stderr, "ssv: the planner does not fly this: %s\n", result->plan.quote.reason);
        return EXIT_ABORTED;
    }
    result->is_flown = result->plan.quote.status == LCM_SSV_QUOTE_T_STATUS_OK;
    return result->is_flown ? exit_code(&result->end, result->truth) : EXIT_INFEASIBLE;
}

int flight_fly(const task_options_t* options, const report_plan_t* predicted, lcm_ssv_task_t* question,
               flight_signals_t* signals, flight_result_t* result) {
    char error[1024];
    static simulation_t simulation;
    flight_t flight = {.options = options,
                       .plan = predicted->plan,
                       .simulation = options->in_simulation ? &simulation : NULL,
                       .signals = signals,
                       .num_signals = flight_count_signals(signals),
                       .result = result,
                       .state = -1,
                       .on_terminal = isatty(STDERR_FILENO) == 1};
    int64_t planner_id = 0;
    simulation = (simulation_t){.simulator = {.output = -1, .log = -1}, .planner = {.output = -1, .log = -1}};
    memset(result, 0, sizeof *result);
    flown_begin(&result->flown);
    if (options->conditions != NULL && (!find_conditions(options->conditions, simulation.conditions,
                                                         sizeof simulation.conditions, error, sizeof error) ||
                                        !read_lag(simulation.conditions, &simulation.lag_s, error, sizeof error))) {
        fprintf(stderr, "ssv: %s\n", error);
        return EXIT_INVALID;
    }
    simulation.plan_file = options->in_simulation ? write_plan(predicted) : -1;
    if (options->in_simulation && simulation.plan_file < 0) {
        fprintf(stderr, "ssv: the system gives no files for a flight: %s\n", strerror(errno));
        return EXIT_FAILED;
    }
    int code = options->in_simulation ? start(&simulation, &flight, &planner_id) : EXIT_OK;
    if (code == EXIT_OK) return fly(&flight, predicted, question, planner_id);
    json_decref(end(&simulation, true));
    return flight_count_signals(signals) > flight.num_signals ? EXIT_ABORTED : code;
}

report_flight_t flight_report(const task_options_t* options, const report_plan_t* predicted,
                              const flight_result_t* result) {
    return (report_flight_t){
        .plan = {predicted->path, predicted->question, &result->plan, true},
        .end = &result->end,
        .legs = result->leg,
        .flown = &result->flown,
        .news_lost = result->news_lost,
        .wall_s = result->wall_s,
        .truth = result->truth,
        .conditions = options->conditions,
        .seed = options->seed == NULL ? "1" : options->seed,
    };
}

void flight_close(flight_result_t* result) {
    json_decref(result->truth);
    if (result->has_answer) {
        lcm_ssv_plan_t_decode_cleanup(&result->plan);
        wire_clear("execution_t", &result->end);
    }
    result->has_answer = result->is_flown = false;
    result->truth = NULL;
}
