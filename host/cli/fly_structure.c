#include "fly_structure.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "announce.h"
#include "ask.h"
#include "commands.h"
#include "flight.h"
#include "output.h"
#include "report.h"
#include "search_watch.h"
#include "ssv/answer.h"
#include "wire/message.h"
#include "wire/names.h"

/// [s] Longest search for a schedule.
#define SEARCH_LIMIT_S 120.0
/// Prices that are asked for between two looks at whether it is to end.
#define ASKED_MOST 64
/// Flights in a row without a beam docked, after which no more are made.
#define TRIES_MAX 3
#define ROWS_MAX (TRIES_MAX * STRUCTURE_MAX_SLOTS)
#define DEG_PER_RAD 57.295779513082321

/// One flight, beside what the schedule had for it.
typedef struct {
    int beam, slot;
    assembly_price_t scheduled;
    const char* outcome;
    char reason[128];
    bool is_docked;
    double time_s, impulse_Ns;    ///< flown
    double clearance_m;           ///< least, of the simulator; NAN where nothing stands around
    double position_m, angle_rad; ///< at the dock
    uint64_t plan_hash;           ///< of the plan that was flown
} row_t;

/// The assembly, and what has come of it so far.
typedef struct {
    const task_options_t* options;
    structure_t* structure;
    const char* shown;
    flight_signals_t signals;
    assembly_result_t result; ///< the schedule that is flown
    announce_t announce;      ///< likewise
    int next;                 ///< part of it
    int num_schedules, num_rows, num_vain;
    row_t row[ROWS_MAX];
    double cost, time_s, impulse_Ns; ///< of the first schedule
    double flown_s, flown_Ns;
    bool touched;
    json_t* tasks; ///< flights as JSON; NULL for people
} assembly_flight_t;

// ---- Schedules ------------------------------------------------------------------------------------------------------

static bool is_stopped(void* context) { return flight_count_signals(context) > 0; }

/// Prices for the search, a few at a time.
typedef struct {
    pricing_t* pricing;
    flight_signals_t* signals;
} asked_t;

static bool ask(void* context, const assembly_question_t* questions, int count, assembly_price_t* prices) {
    const asked_t* const asked = context;
    for (int i = 0; i < count; i += ASKED_MOST) {
        const int more = count - i < ASKED_MOST ? count - i : ASKED_MOST;
        if (is_stopped(asked->signals) || !pricing_ask(asked->pricing, &questions[i], more, &prices[i])) return false;
    }
    return true;
}

static void tell(const assembly_flight_t* flight) {
    char error[256];
    if (!announce_tell(&flight->announce, flight->options->lcm_url, error, sizeof error)) {
        fprintf(stderr, "ssv: %s\n", error);
    }
}

/// Finds in which order what is left is assembled. @return EXIT_OK, or another exit code after a line on standard
/// error.
static int schedule(assembly_flight_t* flight) {
    char error[1024];
    pricing_t* const pricing = pricing_open(flight->structure, 0);
    if (pricing == NULL || !pricing_check(pricing, error, sizeof error)) {
        fprintf(stderr, "ssv: %s: %s\n", flight->shown, pricing == NULL ? "out of memory" : error);
        if (pricing != NULL) pricing_close(pricing);
        return pricing == NULL ? EXIT_FAILED : EXIT_INVALID;
    }
    search_watch_t watch = search_watch_begin(pricing, SEARCH_LIMIT_S, is_stopped, &flight->signals);
    asked_t asked = {pricing, &flight->signals};
    const assembly_prices_t prices = {ask, &asked};
    const assembly_limits_t limits = {search_watch_must_stop, search_watch_found, &watch};
    const bool sound = assembly_schedule(flight->structure, &prices, &limits, &flight->result);
    search_watch_end(&watch);
    pricing_close(pricing);
    if (is_stopped(&flight->signals)) return EXIT_ABORTED;
    if (!sound || flight->result.best.num_parts == 0) {
        fprintf(stderr, "ssv: %s: %s\n", flight->shown,
                !sound ? "out of memory" : "by every order and choice of beams some part that is left has no plan");
        return sound ? EXIT_INFEASIBLE : EXIT_FAILED;
    }
    flight->next = 0;
    flight->num_schedules++;
    if (!announce_begin(&flight->announce, flight->structure, flight->shown, &flight->result, error, sizeof error)) {
        fprintf(stderr, "ssv: %s\n", error);
        return EXIT_FAILED;
    }
    fprintf(stderr, "ssv: schedule %d: %d parts, J = %.1f, %.1f s%s\n", flight->num_schedules,
            flight->result.best.num_parts, flight->announce.wire.cost, flight->announce.wire.time_s,
            flight->result.status == HTN_OPTIMAL ? "" : ", the best that was found in time");
    tell(flight);
    return EXIT_OK;
}

// ---- What stands ----------------------------------------------------------------------------------------------------

static bool read_pose(const json_t* json, const char* key, double p_m[3], double q[4]) {
    const json_t* const pose = json_object_get(json, key);
    for (size_t i = 0; i < 7; i++) {
        const json_t* const number = json_array_get(pose, i);
        if (!json_is_number(number)) return false;
        *(i < 3 ? &p_m[i] : &q[i - 3]) = json_number_value(number);
    }
    return true;
}

/// A beam is docked as it lies: its end at the port is the nearer one.
static void take_up_docked(structure_t* structure, int s, const double p_IB_m[3], const double q[4]) {
    const structure_slot_t* const slot = &structure->slot[s];
    const structure_port_t* const port = &structure->hub[slot->hub[0]].port[slot->port[0]];
    structure_port_t* const at = &structure->stands_at[s];
    const double half_m = structure->task.beam.length_m / 2;
    const double z_I[3] = {2 * (q[1] * q[3] + q[0] * q[2]), 2 * (q[2] * q[3] - q[0] * q[1]),
                           1 - 2 * (q[1] * q[1] + q[2] * q[2])};
    double along = 0;
    for (int i = 0; i < 3; i++) along += z_I[i] * port->axis_I[i];
    const double sign = along < 0 ? -1 : 1;
    for (int i = 0; i < 3; i++) {
        at->axis_I[i] = sign * z_I[i];
        at->p_IP_m[i] = p_IB_m[i] - half_m * at->axis_I[i];
    }
}

/// Takes up where the flight has left vehicle and beam. @return false if the simulator does not say.
static bool take_up(structure_t* structure, const row_t* row, const json_t* truth) {
    const json_t* const end = json_object_get(truth, "end");
    const char* const beam = json_string_value(json_object_get(end, "beam"));
    double p_IB_m[3], q_IB[4];
    if (beam == NULL || !read_pose(end, "X_IS", structure->p_IS_m, structure->q_IS) ||
        !read_pose(end, "X_IB", p_IB_m, q_IB)) {
        return false;
    }
    if (row->is_docked) {
        structure->stands |= set_of(row->slot);
        structure->gone |= set_of(row->beam);
        structure->left = row->slot;
        take_up_docked(structure, row->slot, p_IB_m, q_IB);
    } else if (strcmp(beam, "waiting") != 0) { // let go where it is, it weighs nothing in the water
        memcpy(structure->beam[row->beam].p_IB_m, p_IB_m, sizeof p_IB_m);
        memcpy(structure->beam[row->beam].q_IB, q_IB, sizeof q_IB);
        structure->left = -1;
    }
    return true;
}

// ---- A part ---------------------------------------------------------------------------------------------------------

/// The part's task from where the vehicle is, past what stands. @return false if out of memory.
static bool make_task(const structure_t* structure, const assembly_part_t* part, lcm_ssv_task_t* task) {
    pricing_t* const now = pricing_open(structure, 1);
    if (now == NULL) return false;
    const assembly_question_t question = {0, part->beam, part->slot, structure->obstacles ? structure->left : -1,
                                          structure->obstacles ? structure->stands : 0};
    task->scenario = pricing_scenario(now, &question);
    task->scene = *pricing_scene(now);
    pricing_close(now);
    return true;
}

static double number_of(const json_t* json, const char* key) { return json_number_value(json_object_get(json, key)); }

static void note_flown(assembly_flight_t* flight, row_t* row, const flight_result_t* result) {
    const json_t* const clearance = json_object_get(result->truth, "clearance");
    const json_t* const dock = json_object_get(result->truth, "dock");
    row->outcome = name_of(&names_outcome, result->end.outcome);
    snprintf(row->reason, sizeof row->reason, "%s", result->end.reason);
    row->is_docked = result->end.outcome == LCM_SSV_EXECUTION_T_OUTCOME_DOCKED;
    row->time_s = result->end.flown_s;
    row->impulse_Ns = result->end.impulse_Ns;
    row->clearance_m = json_is_object(clearance) ? number_of(clearance, "least_m") : (double)NAN;
    row->position_m = number_of(dock, "position_m");
    row->angle_rad = number_of(dock, "angle_rad");
    row->plan_hash = (uint64_t)result->plan.plan_hash;
    flight->flown_s += row->time_s;
    flight->flown_Ns += row->impulse_Ns;
    flight->touched = flight->touched || report_touches(result->truth);
}

/// Adds the flight as `ssv fly` of one task would write it, with its name. @return false if out of memory.
static bool add_flight(assembly_flight_t* flight, const row_t* row, const report_flight_t* report) {
    json_t* const json = report_flight_object(report);
    return json != NULL &&
           json_object_set_new(json, "name",
                               json_sprintf("%s to %s", flight->structure->beam[row->beam].name,
                                            flight->structure->slot[row->slot].name)) == 0 &&
           json_array_append_new(flight->tasks, json) == 0;
}

/// Plans the next part anew, and has it flown. @return EXIT_OK if its beam is docked, another exit code otherwise.
static int fly_part(assembly_flight_t* flight) {
    static ssv_answer_t answer;
    static lcm_ssv_task_t task;
    static flight_result_t result;
    const assembly_part_t* const part = &flight->result.best.part[flight->next];
    row_t* const row = &flight->row[flight->num_rows++];
    char seed[32], error[1024];
    task_options_t options = *flight->options;
    *row = (row_t){.beam = part->beam,
                   .slot = part->slot,
                   .scheduled = part->price,
                   .outcome = "not flown",
                   .clearance_m = (double)NAN};
    snprintf(seed, sizeof seed, "%llu",
             strtoull(options.seed == NULL ? "1" : options.seed, NULL, 10) + (unsigned long long)flight->num_rows - 1);
    options.seed = seed;
    if (!make_task(flight->structure, part, &task)) {
        fprintf(stderr, "ssv: out of memory\n");
        return EXIT_FAILED;
    }
    if (!ask_stamp(&task.scenario.asker, error, sizeof error)) {
        fprintf(stderr, "ssv: %s\n", error);
        return EXIT_FAILED;
    }
    const lcm_ssv_planner_t planner = ssv_planner_identity(task.scenario.asker.asker_id);
    ssv_answer(&task, &planner, &answer);
    fprintf(stderr, "ssv: part %d of %d: %s to %s\n", flight->next + 1, flight->result.best.num_parts,
            flight->structure->beam[row->beam].name, flight->structure->slot[row->slot].name);
    if (answer.wire.quote.status != LCM_SSV_QUOTE_T_STATUS_OK) {
        snprintf(row->reason, sizeof row->reason, "%s", answer.wire.quote.reason);
        fprintf(stderr, "ssv: no plan from where the vehicle is: %s\n", row->reason);
        return EXIT_INFEASIBLE;
    }
    const report_plan_t predicted = {flight->shown, &task, &answer.wire, false};
    int code = flight_fly(&options, &predicted, &task, &flight->signals, &result);
    if (result.is_flown) {
        note_flown(flight, row, &result);
        const report_flight_t report = flight_report(&options, &predicted, &result);
        const bool sound = (flight->tasks == NULL || add_flight(flight, row, &report)) &&
                           take_up(flight->structure, row, result.truth);
        if (!sound) {
            fprintf(stderr, "ssv: the simulator does not say where it has ended\n");
            code = EXIT_FAILED;
        }
    } else if (result.has_answer) {
        snprintf(row->reason, sizeof row->reason, "%s", result.plan.quote.reason);
    }
    flight_close(&result);
    return code;
}

/// Whether another schedule may do better after such an end of a flight.
static bool may_go_on(const assembly_flight_t* flight, int code) {
    const bool failed = code == EXIT_MISSED || code == EXIT_ABORTED || code == EXIT_INFEASIBLE || code == EXIT_TOUCHED;
    return failed && flight->signals.count == 0 && flight->num_vain < TRIES_MAX && flight->num_rows < ROWS_MAX;
}

/// @return EXIT_OK once all stands, or why not.
static int assemble(assembly_flight_t* flight) {
    const set_t all = set_of(flight->structure->num_slots) - 1;
    int code = schedule(flight);
    flight->cost = flight->announce.wire.cost;
    flight->time_s = flight->announce.wire.time_s;
    flight->impulse_Ns = flight->announce.wire.impulse_Ns;
    while (code == EXIT_OK && flight->structure->stands != all) {
        lcm_ssv_schedule_part_t* const part = &flight->announce.part[flight->next];
        part->state = LCM_SSV_SCHEDULE_PART_T_STATE_FLIES;
        tell(flight);
        code = fly_part(flight);
        const row_t* const row = &flight->row[flight->num_rows - 1];
        part->state = row->is_docked ? LCM_SSV_SCHEDULE_PART_T_STATE_STANDS : LCM_SSV_SCHEDULE_PART_T_STATE_FAILED;
        part->plan_hash = (int64_t)row->plan_hash;
        tell(flight);
        flight->next++;
        flight->num_vain = row->is_docked ? 0 : flight->num_vain + 1;
        if (row->is_docked && code == EXIT_TOUCHED) code = EXIT_OK; // it is told in the end
        if (code != EXIT_OK && may_go_on(flight, code)) code = schedule(flight);
    }
    return code;
}

// ---- The report -----------------------------------------------------------------------------------------------------

static int count_bits(set_t bits) {
    int count = 0;
    for (; bits != 0; bits &= bits - 1) count++;
    return count;
}

static bool report_table(FILE* out, const void* content) {
    const assembly_flight_t* const flight = content;
    const structure_t* const structure = flight->structure;
    const int stands = count_bits(structure->stands);
    fprintf(out, "%s: %s, %d of %d beams docked%s\n\n", flight->shown,
            stands == structure->num_slots ? "assembled" : "not assembled", stands, structure->num_slots,
            flight->touched ? ", and something was touched" : "");
    fprintf(out, "  %2s  %-12s %-18s %-9s %10s %9s %12s %9s %8s %8s %8s\n", "", "beam", "slot", "", "scheduled s",
            "flown s", "scheduled N s", "flown N s", "clear mm", "dock mm", "dock deg");
    for (int i = 0; i < flight->num_rows; i++) {
        const row_t* const row = &flight->row[i];
        fprintf(out, "  %2d  %-12s %-18s %-9s %11.1f %9.1f %13.1f %9.1f ", i + 1, structure->beam[row->beam].name,
                structure->slot[row->slot].name, row->outcome, row->scheduled.time_s, row->time_s,
                row->scheduled.impulse_Ns, row->impulse_Ns);
        isnan(row->clearance_m) ? fprintf(out, "%8s", "-") : fprintf(out, "%8.1f", 1e3 * row->clearance_m);
        if (row->is_docked) {
            fprintf(out, " %8.1f %8.2f\n", 1e3 * row->position_m, DEG_PER_RAD * row->angle_rad);
        } else {
            fprintf(out, " %8s %8s  %s\n", "-", "-", row->reason);
        }
    }
    const double W1 = structure->task.weight_time_per_s, W2 = structure->task.weight_impulse_per_Ns;
    const double flown = W1 * flight->flown_s + W2 * flight->flown_Ns;
    fprintf(out,
            "\n  scheduled %.1f s, %.1f N s, J = %.1f\n  flown     %.1f s, %.1f N s, J = %.1f (%+.1f %%)\n"
            "  %d schedules, %d flights; conditions %s, seeds from %s on\n",
            flight->time_s, flight->impulse_Ns, flight->cost, flight->flown_s, flight->flown_Ns, flown,
            100 * (flown / flight->cost - 1), flight->num_schedules, flight->num_rows,
            flight->options->conditions == NULL ? "none" : flight->options->conditions,
            flight->options->seed == NULL ? "1" : flight->options->seed);
    return true;
}

static json_t* row_json(const assembly_flight_t* flight, const row_t* row) {
    return json_pack("{s:s,s:s,s:s,s:s,s:{s:f,s:f,s:f},s:{s:f,s:f},s:o}", "beam",
                     flight->structure->beam[row->beam].name, "slot", flight->structure->slot[row->slot].name,
                     "outcome", row->outcome, "reason", row->reason, "scheduled", "cost", row->scheduled.cost, "time_s",
                     row->scheduled.time_s, "impulse_Ns", row->scheduled.impulse_Ns, "flown", "time_s", row->time_s,
                     "impulse_Ns", row->impulse_Ns, "clearance_m",
                     isnan(row->clearance_m) ? json_null() : json_real(row->clearance_m));
}

static bool report_json(FILE* out, const void* content) {
    const assembly_flight_t* const flight = content;
    json_t* const rows = json_array();
    const int stands = count_bits(flight->structure->stands);
    for (int i = 0; i < flight->num_rows; i++) json_array_append_new(rows, row_json(flight, &flight->row[i]));
    return wire_json_write(
        out, json_pack("{s:{s:s,s:b,s:i,s:i,s:b,s:i,s:{s:f,s:f,s:f},s:{s:f,s:f},s:o},s:O}", "assembly", "structure",
                       flight->shown, "assembled", stands == flight->structure->num_slots, "docked", stands, "slots",
                       flight->structure->num_slots, "touched", flight->touched, "schedules", flight->num_schedules,
                       "scheduled", "cost", flight->cost, "time_s", flight->time_s, "impulse_Ns", flight->impulse_Ns,
                       "flown", "time_s", flight->flown_s, "impulse_Ns", flight->flown_Ns, "flights", rows, "tasks",
                       flight->tasks));
}

int fly_structure(const task_options_t* options, structure_t* structure) {
    static assembly_flight_t flight;
    flight = (assembly_flight_t){.options = options,
                                 .structure = structure,
                                 .shown = options->shown[0],
                                 .tasks = options->as_json ? json_array() : NULL};
    if (!flight_take_signals(&flight.signals)) return EXIT_FAILED;
    int code = assemble(&flight);
    if (flight.touched) code = EXIT_TOUCHED;
    if (flight.num_rows > 0 &&
        !output_report(options->output_path, options->as_json ? report_json : report_table, &flight)) {
        code = EXIT_FAILED;
    }
    json_decref(flight.tasks);
    return code;
}
