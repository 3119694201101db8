#define _POSIX_C_SOURCE 200809L
#include "report.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "wire/message.h"
#include "wire/names.h"

#define DEG_PER_RAD 57.295779513082321
// What ssv-replay judges by, and the least that is worth a number.
#define JUDGED_MM 5.0
#define JUDGED_DEG 0.5
#define TOLD_MM 0.1
#define TOLD_DEG 0.01

static void phase_sums(const lcm_ssv_plan_t* plan, int8_t phase, double* time_s, double* impulse_Ns) {
    *time_s = 0;
    *impulse_Ns = 0;
    for (int i = 0; i < plan->num_legs; i++) {
        if (plan->legs[i].phase == phase) {
            *time_s += plan->legs[i].duration_s;
            *impulse_Ns += plan->legs[i].impulse_Ns;
        }
    }
}

static bool set_task(json_t* json, const lcm_ssv_task_t* task) {
    return json_object_set_new(json, "scenario", wire_to_json("scenario_t", &task->scenario)) == 0 &&
           json_object_set_new(json, "scene", wire_to_json("scene_t", &task->scene)) == 0;
}

json_t* report_plan_object(const report_plan_t* report) {
    const lcm_ssv_plan_t* plan = report->plan;
    json_t* const json = json_object();
    bool complete = json != NULL;
    if (plan->quote.status != LCM_SSV_QUOTE_T_STATUS_INVALID) complete = set_task(json, report->question);
    complete = complete && json_object_set_new(json, "plan", wire_to_json("plan_t", plan)) == 0;
    if (complete) return json;
    json_decref(json);
    return NULL;
}

bool report_plan_json(FILE* out, const void* plan) {
    json_t* const json = report_plan_object(plan);
    return json != NULL && wire_json_write(out, json);
}

static json_t* row_json(const report_quote_t* row) {
    json_t* const json = json_pack("{s:s}", "file", row->path);
    if (row->quote->status != LCM_SSV_QUOTE_T_STATUS_INVALID) {
        (void)set_task(json, row->question);
    }
    if (json_object_set_new(json, "quote", wire_to_json("quote_t", row->quote)) != 0) {
        json_decref(json);
        return NULL;
    }
    return json;
}

bool report_quotes_json(FILE* out, const void* report) {
    const report_quotes_t* quotes = report;
    json_t* const rows = json_array();
    bool complete = rows != NULL;
    for (int i = 0; i < quotes->count && complete; i++) {
        complete = json_array_append_new(rows, row_json(&quotes->row[i])) == 0;
    }
    if (!complete) {
        json_decref(rows);
        return false;
    }
    return wire_json_write(out, json_pack("{s:o}", "quotes", rows));
}

static void candidate_row(FILE* out, const lcm_ssv_candidate_t* candidate, bool chosen) {
    fprintf(out, "  %7d %+9.4f %+8.1f %11.3f %12.3f %12.3f%s\n", candidate->contact, candidate->attach_height_m,
            candidate->ring_angle_rad * DEG_PER_RAD, candidate->time_s, candidate->impulse_Ns, candidate->cost,
            chosen ? "  chosen" : "");
}

static void candidates_table(FILE* out, const lcm_ssv_quote_t* quote) {
    bool missing =
        quote->status == LCM_SSV_QUOTE_T_STATUS_OK; // the choice may stand between the heights that were given
    fprintf(out, "  %7s %9s %8s %11s %12s %12s\n", "contact", "height m", "ring deg", "time s", "impulse N s", "J");
    for (int i = 0; i < quote->num_candidates; i++) {
        const lcm_ssv_candidate_t* candidate = &quote->candidates[i];
        if (candidate->reason[0] != '\0') {
            fprintf(out, "  %7d %+9.4f %8s not feasible: %s\n", candidate->contact, candidate->attach_height_m, "",
                    candidate->reason);
            continue;
        }
        const bool chosen = quote->status == LCM_SSV_QUOTE_T_STATUS_OK && candidate->contact == quote->choice.contact &&
                            candidate->attach_height_m == quote->choice.attach_height_m;
        candidate_row(out, candidate, chosen);
        missing = missing && !chosen;
    }
    if (missing) {
        const lcm_ssv_candidate_t choice = {.contact = quote->choice.contact,
                                            .attach_height_m = quote->choice.attach_height_m,
                                            .ring_angle_rad = quote->choice.ring_angle_rad,
                                            .time_s = quote->time_s,
                                            .impulse_Ns = quote->impulse_Ns,
                                            .cost = quote->cost};
        candidate_row(out, &choice, true);
    }
}

static void front_table(FILE* out, const lcm_ssv_quote_t* quote) {
    fprintf(out, "  %11s %12s %12s %7s %9s %8s\n", "time s", "impulse N s", "J", "contact", "height m", "ring deg");
    for (int i = 0; i < quote->num_front; i++) {
        const lcm_ssv_candidate_t* point = &quote->front[i];
        fprintf(out, "  %11.3f %12.3f %12.3f %7d %+9.4f %+8.1f\n", point->time_s, point->impulse_Ns, point->cost,
                point->contact, point->attach_height_m, point->ring_angle_rad * DEG_PER_RAD);
    }
}

/// The tables that a quote comes with on request, each with an empty line before it.
static void detail_tables(FILE* out, const lcm_ssv_quote_t* quote) {
    if (quote->num_candidates > 0) {
        fprintf(out, "\n  Candidates:\n");
        candidates_table(out, quote);
    }
    if (quote->num_front > 0) {
        fprintf(out, "\n  What time and impulse can be traded for:\n");
        front_table(out, quote);
    }
}

static void legs_table(FILE* out, const lcm_ssv_plan_t* plan) {
    fprintf(out, "  %-10s %-10s %-13s %11s %11s %12s %13s\n", "phase", "leg", "ramp", "start s", "time s",
            "impulse N s", "peak speed");
    for (int i = 0; i < plan->num_legs; i++) {
        const lcm_ssv_leg_t* leg = &plan->legs[i];
        fprintf(out, "  %-10s %-10s %-13s %11.3f %11.3f %12.3f %7.4f %s\n", name_of(&names_phase, leg->phase),
                name_of(&names_kind, leg->kind), name_of(&names_ramp, leg->ramp), leg->t_start_s, leg->duration_s,
                leg->impulse_Ns, leg->peak_speed, leg->kind == LCM_SSV_LEG_T_KIND_TURN ? "rad/s" : "m/s");
    }
    for (int8_t phase = LCM_SSV_LEG_T_PHASE_TRANSIT; phase <= LCM_SSV_LEG_T_PHASE_TRANSFER; phase++) {
        double time_s = 0, impulse_Ns = 0;
        phase_sums(plan, phase, &time_s, &impulse_Ns);
        fprintf(out, "  %-10s %-10s %-13s %11s %11.3f %12.3f\n", name_of(&names_phase, phase), "in all", "", "", time_s,
                impulse_Ns);
    }
}

/// The best possible plan costs no less than the bound, so the plan's distance from the bound is the most it can be
/// off. Beyond WEAK_PERCENT that says little of the plan and much of the bound.
#define WEAK_PERCENT 100
static double gap_percent(const lcm_ssv_quote_t* quote) { return 100 * (quote->cost / quote->cost_lower_bound - 1); }

static void bound_line(FILE* out, const lcm_ssv_scenario_t* question, const lcm_ssv_quote_t* quote) {
    if (!(quote->cost_lower_bound > 0)) {
        fprintf(out, "No lower bound is known: %s\n",
                question->vehicle.body.drag_lin_kg_s > 0
                    ? "there is hardly anything to fly"
                    : "it would follow from the vehicle's linear drag, of which there is none");
    } else if (gap_percent(quote) > WEAK_PERCENT) {
        fprintf(out,
                "No plan of any kind costs less than %.3f, a weak bound: it knows of the vehicle's linear drag alone\n",
                quote->cost_lower_bound);
    } else {
        fprintf(out, "No plan of any kind costs less than %.3f: this one is at most %.1f %% above the best possible\n",
                quote->cost_lower_bound, gap_percent(quote));
    }
}

/// What an obstacle of a clearance_t is called.
static const char* obstacle_name(int obstacle, char* text, size_t size) {
    if (obstacle == LCM_SSV_CLEARANCE_T_OBSTACLE_BEAM) return "its beam";
    if (obstacle == LCM_SSV_CLEARANCE_T_OBSTACLE_TANK) return "the tank's wall";
    snprintf(text, size, "obstacle %d", obstacle);
    return text;
}

/// How clear the plan keeps, where there is something to keep clear of.
static void clearance_line(FILE* out, const lcm_ssv_plan_t* plan) {
    const lcm_ssv_clearance_t* clearance = &plan->clearance;
    char text[24];
    if (clearance->obstacle == LCM_SSV_CLEARANCE_T_OBSTACLE_NONE) {
        return;
    }
    fprintf(out, "Keeps clear by %.0f mm (%s, the %s on leg %d of %d)\n", 1e3 * clearance->certified_m,
            obstacle_name(clearance->obstacle, text, sizeof text), name_of(&names_body, clearance->body),
            clearance->leg + 1, plan->num_legs);
}

static bool is_missed(double off_m, double off_rad) {
    return 1e3 * off_m > JUDGED_MM || off_rad * DEG_PER_RAD > JUDGED_DEG;
}

/// Where the timeline leads by itself, and if beside the goal, why.
static void arrival_line(FILE* out, const lcm_ssv_arrival_t* arrival) {
    const double off_m = arrival->lines_m + arrival->rounding_m, off_rad = arrival->lines_rad + arrival->rounding_rad;
    if (is_missed(off_m, off_rad)) {
        fprintf(
            out,
            "Open loop, even by exact thrusters, it misses by some %.1g m and %.1g deg, since %s: it needs guidance\n",
            off_m, off_rad * DEG_PER_RAD,
            is_missed(arrival->lines_m, arrival->lines_rad) ? "its motion is unstable" : "its arithmetic is coarse");
    } else if (1e3 * off_m < TOLD_MM && off_rad * DEG_PER_RAD < TOLD_DEG) {
        fprintf(out, "Open loop, by exact thrusters in still water, it arrives within some %g mm and %g deg\n", TOLD_MM,
                TOLD_DEG);
    } else {
        fprintf(out, "Open loop, by exact thrusters in still water, it ends some %.1g mm and %.1g deg off\n",
                1e3 * off_m, off_rad * DEG_PER_RAD);
    }
}

static const char* base_name(const char* path) {
    const char* const slash = strrchr(path, '/');
    return slash == NULL ? path : slash + 1;
}

bool report_plan_table(FILE* out, const void* report) {
    const report_plan_t* const answer = report;
    const char* const title = base_name(answer->path);
    const lcm_ssv_plan_t* plan = answer->plan;
    const lcm_ssv_quote_t* quote = &plan->quote;
    if (quote->status == LCM_SSV_QUOTE_T_STATUS_INVALID) {
        return true;
    }
    if (quote->status == LCM_SSV_QUOTE_T_STATUS_INFEASIBLE) {
        fprintf(out, "%s: no plan\n", title);
        detail_tables(out, quote);
        return true;
    }
    if (quote->status != LCM_SSV_QUOTE_T_STATUS_OK) {
        return true;
    }
    const lcm_ssv_scenario_t* const question = &answer->question->scenario;
    const bool is_optimal = question->options.method == LCM_SSV_OPTIONS_T_METHOD_OPTIMAL;
    fprintf(out, "%s: J = %.9g /s x %.3f s + %.9g /(N s) x %.3f N s = %.3f\n", title, question->weight_time_per_s,
            quote->time_s, question->weight_impulse_per_Ns, quote->impulse_Ns, quote->cost);
    bound_line(out, question, quote);
    fprintf(out, "Mates at height %+.4f m, ring angle %+.1f deg; contact %d docks\n", quote->choice.attach_height_m,
            quote->choice.ring_angle_rad * DEG_PER_RAD, quote->choice.contact);
    clearance_line(out, plan);
    arrival_line(out, &plan->arrival);
    detail_tables(out, quote);
    fputc('\n', out);
    legs_table(out, plan);
    fputc('\n', out);
    for (int i = 0; i < plan->num_events; i++) {
        fprintf(out, "  %s at %.3f s\n", name_of(&names_event, plan->events[i].kind), plan->events[i].t_s);
    }
    fprintf(out, "  method %s%s%s\n", name_of(&names_method, question->options.method), is_optimal ? ", effort " : "",
            is_optimal ? name_of(&names_effort, question->options.effort) : "");
    fprintf(out, "  %d combinations priced, %d timeline segments, %d bytes on the wire\n",
            (int)quote->choice.candidates, plan->num_segments, lcm_ssv_plan_t_encoded_size(plan));
    if (answer->names_planner) {
        fprintf(out, "  planned in %s by planner %016" PRIx64 ", version %s\n",
                name_of(&names_scalar, plan->answer.planner.scalar), (uint64_t)plan->answer.planner.planner_id,
                plan->answer.planner.version);
    }
    fprintf(out, "  scenario %016" PRIx64 ", plan %016" PRIx64 "\n", (uint64_t)quote->scenario_hash,
            (uint64_t)plan->plan_hash);
    return true;
}

static void quote_row(FILE* out, int path_width, const char* path, const lcm_ssv_quote_t* quote) {
    fprintf(out, "%-*s", path_width, path);
    if (quote->status != LCM_SSV_QUOTE_T_STATUS_OK) {
        fprintf(out, "  %s\n",
                quote->status == LCM_SSV_QUOTE_T_STATUS_INFEASIBLE         ? "no feasible candidate"
                : quote->status == LCM_SSV_QUOTE_T_STATUS_NUMERIC_OVERFLOW ? "numeric overflow"
                                                                           : "refused");
        return;
    }
    fprintf(out, "  %11.3f  %9.3f  %11.3f  %11.3f", quote->cost, quote->time_s, quote->impulse_Ns,
            quote->cost_lower_bound);
    if (!(quote->cost_lower_bound > 0) || gap_percent(quote) > WEAK_PERCENT) {
        fprintf(out, "  %6s", quote->cost_lower_bound > 0 ? "weak" : "none");
    } else {
        fprintf(out, "  %6.1f", gap_percent(quote));
    }
    fprintf(out, "  %7d  %+8.4f\n", quote->choice.contact, quote->choice.attach_height_m);
}

bool report_quotes_table(FILE* out, const void* report) {
    const report_quotes_t* quotes = report;
    int width = (int)strlen("scenario");
    for (int i = 0; i < quotes->count; i++) {
        const int length = (int)strlen(quotes->row[i].path);
        width = length > width ? length : width;
    }
    fprintf(out, "%-*s  %11s  %9s  %11s  %11s  %6s  %7s  %8s\n", width, "scenario", "J", "time s", "impulse N s",
            "lower bound", "gap %", "contact", "height m");
    for (int i = 0; i < quotes->count; i++) {
        quote_row(out, width, quotes->row[i].path, quotes->row[i].quote);
    }
    for (int i = 0; i < quotes->count; i++) {
        const lcm_ssv_quote_t* quote = quotes->row[i].quote;
        if (quote->num_candidates > 0 || quote->num_front > 0) {
            fprintf(out, "\n%s\n", quotes->row[i].path);
            detail_tables(out, quote);
        }
    }
    return true;
}

// ---- A flight -------------------------------------------------------------------------------------------------------

static json_t* leg_json(const lcm_ssv_leg_t* leg, const report_leg_t* flown) {
    json_t* const json =
        json_pack("{s:{s:f,s:f}}", "predicted", "time_s", leg->duration_s, "impulse_Ns", leg->impulse_Ns);
    json_t* const part = flown->begun ? json_pack("{s:f,s:f,s:f,s:b}", "time_s", flown->time_s, "wait_s", flown->wait_s,
                                                  "impulse_Ns", flown->impulse_Ns, "ended", flown->ended)
                                      : json_null();
    if (json_object_set_new(json, "flown", part) != 0) {
        json_decref(json);
        return NULL;
    }
    return json;
}

json_t* report_flight_object(const report_flight_t* flight) {
    const lcm_ssv_plan_t* plan = flight->plan.plan;
    json_t* const legs = json_array();
    bool complete = legs != NULL;
    for (int i = 0; i < plan->num_legs && complete; i++) {
        complete = json_array_append_new(legs, leg_json(&plan->legs[i], &flight->legs[i])) == 0;
    }
    json_t* const json = json_object();
    complete = complete && set_task(json, flight->plan.question);
    complete = complete && json_object_set_new(json, "plan", wire_to_json("plan_t", plan)) == 0;
    complete = complete && json_object_set_new(json, "execution", wire_to_json("execution_t", flight->end)) == 0;
    complete = complete && json_object_set(json, "legs", legs) == 0;
    complete = complete && json_object_set_new(json, "flown", flown_to_json(flight->flown)) == 0;
    if (complete && flight->truth != NULL) {
        complete = json_object_set_new(json, "simulation",
                                       json_pack("{s:s?,s:s,s:O}", "conditions", flight->conditions, "seed",
                                                 flight->seed, "truth", flight->truth)) == 0;
    }
    complete = complete && json_object_set_new(json, "news_lost", json_integer(flight->news_lost)) == 0;
    complete = complete && json_object_set_new(json, "wall_s", json_real(flight->wall_s)) == 0;
    json_decref(legs);
    if (complete) return json;
    json_decref(json);
    return NULL;
}

bool report_flight_json(FILE* out, const void* flight) {
    json_t* const json = report_flight_object(flight);
    return json != NULL && wire_json_write(out, json);
}

static void flown_row(FILE* out, const char* phase, const char* kind, double time_s, double impulse_Ns,
                      const report_leg_t* flown) {
    fprintf(out, "  %-10s %-10s %12.3f", phase, kind, time_s);
    if (flown->begun) {
        fprintf(out, " %11.3f %11.3f %14.3f %11.3f%s\n", flown->time_s, flown->wait_s, impulse_Ns, flown->impulse_Ns,
                flown->ended ? "" : "  not to its end");
    } else {
        fprintf(out, " %11s %11s %14.3f %11s\n", "-", "-", impulse_Ns, "-");
    }
}

static double number_of(const json_t* json, const char* key) { return json_number_value(json_object_get(json, key)); }

/// How the last attempt to mate or dock went, by the simulator's truth.
static void attempt_line(FILE* out, const json_t* truth, const char* name) {
    const json_t* attempt = json_object_get(truth, name);
    const int attempts = (int)number_of(attempt, "attempts");
    if (attempts == 0) {
        fprintf(out, "  %s: not tried\n", name);
        return;
    }
    const char* const outcome = json_string_value(json_object_get(attempt, "outcome"));
    fprintf(out, "  %s: %.1f mm and %.2f deg off at %.1f mm/s: %s, attempt %d at %.1f s\n", name,
            1e3 * number_of(attempt, "position_m"), DEG_PER_RAD * number_of(attempt, "angle_rad"),
            1e3 * number_of(attempt, "speed_m_s"), outcome == NULL ? "" : outcome, attempts, number_of(attempt, "t_s"));
}

bool report_touches(const json_t* truth) { return number_of(json_object_get(truth, "clearance"), "least_m") < 0; }

/// How near the flight came to what stands around, by the simulator's truth, beside what the plan promised.
static void flown_clearance_line(FILE* out, const report_flight_t* flight) {
    const json_t* const nearest = json_object_get(flight->truth, "clearance");
    const double least_m = number_of(nearest, "least_m"), margin_m = number_of(nearest, "margin_m");
    const char* const body = json_string_value(json_object_get(nearest, "body"));
    char text[24];
    if (body == NULL) return; // nothing stands around
    const char* const obstacle = obstacle_name((int)number_of(nearest, "obstacle"), text, sizeof text);
    fprintf(out, "  %s %.1f mm %s %s (the %s at %.1f s); planned %.1f mm, margin %.1f mm%s\n",
            least_m < 0 ? "TOUCHED:" : "kept clear by", 1e3 * fabs(least_m), least_m < 0 ? "deep in" : "of", obstacle,
            body, number_of(nearest, "t_s"), 1e3 * flight->plan.plan->clearance.certified_m, 1e3 * margin_m,
            least_m >= 0 && least_m < margin_m ? ": below the margin" : "");
}

bool report_flight_table(FILE* out, const void* report) {
    const report_flight_t* flight = report;
    const lcm_ssv_plan_t* plan = flight->plan.plan;
    const lcm_ssv_execution_t* end = flight->end;
    report_leg_t all = {true, end->outcome == LCM_SSV_EXECUTION_T_OUTCOME_DOCKED, end->flown_s, end->impulse_Ns, 0};
    fprintf(out, "%s: %s", base_name(flight->plan.path), name_of(&names_outcome, end->outcome));
    if (end->outcome != LCM_SSV_EXECUTION_T_OUTCOME_DOCKED && end->reason[0] != '\0') fprintf(out, ": %s", end->reason);
    fprintf(out, "\n\n  %-10s %-10s %12s %11s %11s %14s %11s\n", "phase", "leg", "predicted s", "flown s", "of it wait",
            "predicted N s", "flown N s");
    for (int i = 0; i < plan->num_legs; i++) {
        const lcm_ssv_leg_t* leg = &plan->legs[i];
        flown_row(out, name_of(&names_phase, leg->phase), name_of(&names_kind, leg->kind), leg->duration_s,
                  leg->impulse_Ns, &flight->legs[i]);
        all.wait_s += flight->legs[i].wait_s;
    }
    flown_row(out, "in all", "", plan->quote.time_s, plan->quote.impulse_Ns, &all);
    if (all.ended) {
        fprintf(out, "  %+.1f %% time, %+.1f %% impulse\n", 100 * (end->flown_s / plan->quote.time_s - 1),
                100 * (end->impulse_Ns / plan->quote.impulse_Ns - 1));
    }
    if (end->num_plans > 1) {
        fprintf(out, "  strayed and was planned anew %d times; the legs are those of the first plan\n",
                end->num_plans - 1);
    }
    fputc('\n', out);
    if (flight->truth != NULL) {
        attempt_line(out, flight->truth, "mate");
        attempt_line(out, flight->truth, "dock");
        flown_clearance_line(out, flight);
    } else {
        fprintf(out, "  %d attempts to mate and dock\n", end->attempts);
    }
    fprintf(out,
            "  link: %" PRId64 " frames heard, %" PRId64 " lost, %" PRId64
            " damaged; of ours the vehicle missed %" PRId64 "\n",
            end->link_received, end->link_lost, end->link_damaged, end->link_lost_up);
    if (flight->news_lost > 0) {
        fprintf(out, "  %d messages about the flight did not arrive: the legs' figures may be a little off\n",
                flight->news_lost);
    }
    if (flight->truth != NULL) {
        fprintf(out, "  simulated: conditions %s, seed %s; %.1f s in %.2f s, %.0f times real time\n",
                flight->conditions == NULL ? "none" : flight->conditions, flight->seed, end->time_s, flight->wall_s,
                end->time_s / flight->wall_s);
    }
    fprintf(out, "  plan %016" PRIx64 ", planner %016" PRIx64 "\n", (uint64_t)plan->plan_hash,
            (uint64_t)plan->answer.planner.planner_id);
    return true;
}
