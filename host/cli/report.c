#define _POSIX_C_SOURCE 200809L
#include "report.h"

#include <inttypes.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "scenario_file.h"

#define DEG_PER_RAD 57.295779513082321

// An answer may come from the wire: a value that names nothing is shown as such.
#define NAME(names, value) name_of(names, sizeof(names) / sizeof(names)[0], value)

static const char* name_of(const char* const* names, size_t count, int8_t value) {
    return value >= 0 && (size_t)value < count ? names[value] : "unknown";
}

static const char* const status_names[] = {"ok", "infeasible", "invalid", "numeric_overflow"};
static const char* const phase_names[] = {"transit", "transfer"};
static const char* const kind_names[] = {"translate", "turn", "screw"};
static const char* const ramp_names[] = {"full_reverse", "drag_only", "optimal"};
static const char* const event_names[] = {"mate", "dock"};

/// Appends to an array, which becomes NULL if the value is; NULL in a larger whole makes that NULL too.
static void append(json_t** array, json_t* value) {
    if (json_array_append_new(*array, value) != 0) {
        json_decref(*array);
        *array = NULL;
    }
}

static json_t* vector_json(const double* values, int count) {
    json_t* array = json_array();
    for (int i = 0; i < count; i++) {
        append(&array, json_real(values[i]));
    }
    return array;
}

/// Text that JSON can hold: what is not UTF-8 loses its non-ASCII bytes.
static json_t* text_json(const char* text) {
    json_t* string = json_string(text);
    if (string != NULL) {
        return string;
    }
    char* ascii = strdup(text);
    if (ascii == NULL) {
        return NULL;
    }
    for (char* c = ascii; *c != '\0'; c++) {
        if ((unsigned char)*c >= 0x80) {
            *c = '?';
        }
    }
    string = json_string(ascii);
    free(ascii);
    return string;
}

static json_t* hash_json(int64_t hash) {
    char digits[17];
    snprintf(digits, sizeof digits, "%016" PRIx64, (uint64_t)hash);
    return json_string(digits);
}

static json_t* pose_json(const char* p_key, const char* q_key, const lcm_ssv_pose_t* pose) {
    return json_pack("{s:o, s:o}", p_key, vector_json(pose->p_m, 3), q_key, vector_json(pose->q, 4));
}

static json_t* body_json(const lcm_ssv_body_t* body) {
    return json_pack("{s:f, s:o, s:o, s:f, s:f, s:f, s:f}", "mass_kg", body->mass_kg, "inertia_kg_m2",
                     vector_json(body->inertia_kg_m2, 3), "added_mass_kg", vector_json(body->added_mass_kg, 3),
                     "drag_lin_kg_s", body->drag_lin_kg_s, "drag_quad_kg_m", body->drag_quad_kg_m, "drag_lin_ang_Nm_s",
                     body->drag_lin_ang_Nm_s, "drag_quad_ang_Nm_s2", body->drag_quad_ang_Nm_s2);
}

static json_t* vehicle_json(const lcm_ssv_vehicle_t* vehicle) {
    json_t* thrusters = json_array();
    for (size_t i = 0; i < sizeof vehicle->thruster / sizeof vehicle->thruster[0]; i++) {
        json_t* thruster = json_pack("{s:o, s:o}", "p_ST_m", vector_json(vehicle->thruster[i].p_ST_m, 3), "n_T_S",
                                     vector_json(vehicle->thruster[i].n_T_S, 3));
        append(&thrusters, thruster);
    }
    json_t* json = body_json(&vehicle->body);
    json_t* rest = json_pack("{s:f, s:f, s:o}", "radius_m", vehicle->radius_m, "force_max_N", vehicle->force_max_N,
                             "thrusters", thrusters);
    json_object_update(json, rest);
    json_decref(rest);
    return json;
}

static json_t* beam_json(const lcm_ssv_beam_t* beam) {
    json_t* json = body_json(&beam->body);
    json_t* rest = json_pack("{s:f, s:f, s:f}", "radius_m", beam->radius_m, "length_m", beam->length_m,
                             "drag_strip_kg_m2", beam->drag_strip_kg_m2);
    json_object_update(json, rest);
    json_decref(rest);
    return json;
}

static json_t* question_json(const lcm_ssv_scenario_t* question) {
    const lcm_ssv_options_t* options = &question->options;
    return json_pack(
        "{s:I, s:I, s:o, s:o, s:o, s:o, s:{s:o, s:o}, s:i, s:f, s:{s:f, s:f}, s:o, s:b, s:o, s:s, s:s, s:b, s:b}",
        "request_id", (json_int_t)question->request_id, "epoch_us", (json_int_t)question->epoch_us, "vehicle",
        vehicle_json(&question->vehicle), "beam", beam_json(&question->beam), "X_IS",
        pose_json("p_IS_m", "q_IS", &question->X_IS), "X_IB", pose_json("p_IB_m", "q_IB", &question->X_IB), "port",
        "p_IP_m", vector_json(question->port.p_IP_m, 3), "axis_I", vector_json(question->port.axis_I, 3), "contact",
        question->contact, "standoff_m", question->standoff_m, "weights", "time", question->weight_time_per_s,
        "impulse", question->weight_impulse_per_Ns, "attach_heights_m",
        vector_json(options->attach_heights_m, options->num_attach_heights), "attach_anywhere",
        options->attach_anywhere != 0, "ring_angle_rad",
        options->ring_angle_given ? json_real(options->ring_angle_rad) : json_null(), "method",
        NAME(scenario_methods, options->method), "effort", NAME(scenario_efforts, options->effort), "want_candidates",
        options->want_candidates != 0, "want_front", options->want_front != 0);
}

static json_t* candidates_json(const lcm_ssv_candidate_t* candidates, int count) {
    json_t* array = json_array();
    for (int i = 0; i < count; i++) {
        const lcm_ssv_candidate_t* candidate = &candidates[i];
        json_t* json = json_pack("{s:i, s:f, s:f, s:o, s:f, s:f, s:f}", "beam_contact", candidate->contact,
                                 "attach_height_m", candidate->attach_height_m, "ring_angle_rad",
                                 candidate->ring_angle_rad, "reason", text_json(candidate->reason), "time_s",
                                 candidate->time_s, "impulse_Ns", candidate->impulse_Ns, "J", candidate->cost);
        append(&array, json);
    }
    return array;
}

static json_t* front_json(const lcm_ssv_quote_t* quote) {
    json_t* array = json_array();
    for (int i = 0; i < quote->num_front; i++) {
        const lcm_ssv_candidate_t* point = &quote->front[i];
        json_t* json = json_pack("{s:f, s:f, s:f, s:i, s:f, s:f}", "time_s", point->time_s, "impulse_Ns",
                                 point->impulse_Ns, "J", point->cost, "beam_contact", point->contact, "attach_height_m",
                                 point->attach_height_m, "ring_angle_rad", point->ring_angle_rad);
        append(&array, json);
    }
    return array;
}

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

static json_t* phase_json(const lcm_ssv_plan_t* plan, int8_t phase) {
    double time_s = 0, impulse_Ns = 0;
    phase_sums(plan, phase, &time_s, &impulse_Ns);
    return json_pack("{s:s, s:f, s:f}", "name", phase_names[phase], "time_s", time_s, "impulse_Ns", impulse_Ns);
}

static json_t* legs_json(const lcm_ssv_plan_t* plan) {
    json_t* array = json_array();
    for (int i = 0; i < plan->num_legs; i++) {
        const lcm_ssv_leg_t* leg = &plan->legs[i];
        json_t* json = json_pack(
            "{s:s, s:s, s:s, s:f, s:f, s:f, s:f, s:o, s:o}", "phase", NAME(phase_names, leg->phase), "kind",
            NAME(kind_names, leg->kind), "ramp", NAME(ramp_names, leg->ramp), "t_start_s", leg->t_start_s, "duration_s",
            leg->duration_s, "impulse_Ns", leg->impulse_Ns, "peak_speed", leg->peak_speed, "pose_start",
            pose_json("p_IS_m", "q_IS", &leg->X_IS_start), "pose_end", pose_json("p_IS_m", "q_IS", &leg->X_IS_end));
        append(&array, json);
    }
    return array;
}

static json_t* segments_json(const lcm_ssv_plan_t* plan) {
    json_t* array = json_array();
    for (int i = 0; i < plan->num_segments; i++) {
        const lcm_ssv_segment_t* segment = &plan->segments[i];
        json_t* json = json_pack("{s:f, s:f, s:o, s:o, s:i}", "t_s", segment->t_s, "duration_s", segment->duration_s,
                                 "u_start_N", vector_json(segment->u_start_N, 6), "u_end_N",
                                 vector_json(segment->u_end_N, 6), "leg", segment->leg);
        append(&array, json);
    }
    return array;
}

static json_t* events_json(const lcm_ssv_plan_t* plan) {
    json_t* array = json_array();
    for (int i = 0; i < plan->num_events; i++) {
        json_t* json =
            json_pack("{s:f, s:s}", "t_s", plan->events[i].t_s, "kind", NAME(event_names, plan->events[i].kind));
        append(&array, json);
    }
    return array;
}

/// Moves the keys of one object to the end of another, which becomes NULL if either is.
static void extend(json_t** object, json_t* more) {
    if (json_object_update(*object, more) != 0) {
        json_decref(*object);
        *object = NULL;
    }
    json_decref(more);
}

/// What a quote says by itself; nothing but status and reason where the question is refused.
static json_t* quote_json(const lcm_ssv_quote_t* quote) {
    json_t* json =
        json_pack("{s:s, s:o}", "status", NAME(status_names, quote->status), "reason", text_json(quote->reason));
    if (quote->status == LCM_SSV_QUOTE_T_STATUS_INVALID) {
        return json;
    }
    extend(&json, json_pack("{s:I}", "request_id", (json_int_t)quote->request_id));
    if (quote->status == LCM_SSV_QUOTE_T_STATUS_OK) {
        extend(&json,
               json_pack("{s:{s:f, s:f, s:f, s:f}, s:{s:i, s:f, s:f, s:i}}", "cost", "J", quote->cost, "J_lower_bound",
                         quote->cost_lower_bound, "time_s", quote->time_s, "impulse_Ns", quote->impulse_Ns, "choice",
                         "beam_contact", quote->choice.contact, "attach_height_m", quote->choice.attach_height_m,
                         "ring_angle_rad", quote->choice.ring_angle_rad, "candidates", (int)quote->choice.candidates));
    }
    if (quote->num_candidates > 0) {
        extend(&json, json_pack("{s:o}", "candidates", candidates_json(quote->candidates, quote->num_candidates)));
    }
    if (quote->num_front > 0) {
        extend(&json, json_pack("{s:o}", "front", front_json(quote)));
    }
    return json;
}

static json_t* motion_json(const lcm_ssv_plan_t* plan) {
    return json_pack("{s:[o, o], s:o, s:{s:o}, s:o, s:{s:o, s:o}}", "phases",
                     phase_json(plan, LCM_SSV_LEG_T_PHASE_TRANSIT), phase_json(plan, LCM_SSV_LEG_T_PHASE_TRANSFER),
                     "legs", legs_json(plan), "timeline", "segments", segments_json(plan), "events", events_json(plan),
                     "final", "vehicle", pose_json("p_IS_m", "q_IS", &plan->X_IS_final), "beam",
                     pose_json("p_IB_m", "q_IB", &plan->X_IB_final));
}

/// Writes the object and frees it.
static bool write_json(FILE* out, json_t* json) {
    const bool complete =
        json != NULL && json_dumpf(json, out, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) == 0 && fputc('\n', out) != EOF;
    json_decref(json);
    return complete;
}

bool report_plan_json(FILE* out, const void* report) {
    const lcm_ssv_plan_t* plan = ((const report_plan_t*)report)->plan;
    const lcm_ssv_quote_t* quote = &plan->quote;
    json_t* json = quote_json(quote);
    if (quote->status == LCM_SSV_QUOTE_T_STATUS_OK) {
        extend(&json, motion_json(plan));
    }
    if (quote->status != LCM_SSV_QUOTE_T_STATUS_INVALID) {
        extend(&json, json_pack("{s:o}", "scenario_hash", hash_json(quote->scenario_hash)));
    }
    if (quote->status == LCM_SSV_QUOTE_T_STATUS_OK) {
        extend(&json, json_pack("{s:o}", "plan_hash", hash_json(plan->plan_hash)));
    }
    if (quote->status != LCM_SSV_QUOTE_T_STATUS_INVALID) {
        extend(&json, json_pack("{s:o}", "scenario", question_json(((const report_plan_t*)report)->question)));
    }
    return write_json(out, json);
}

bool report_quotes_json(FILE* out, const void* report) {
    const report_quotes_t* quotes = report;
    json_t* array = json_array();
    for (int i = 0; i < quotes->count; i++) {
        const report_quote_t* row = &quotes->row[i];
        json_t* json = json_pack("{s:o}", "file", text_json(row->path));
        extend(&json, quote_json(row->quote));
        if (row->quote->status != LCM_SSV_QUOTE_T_STATUS_INVALID) {
            extend(&json, json_pack("{s:o, s:o}", "scenario_hash", hash_json(row->quote->scenario_hash), "scenario",
                                    question_json(row->question)));
        }
        append(&array, json);
    }
    return write_json(out, json_pack("{s:o}", "quotes", array));
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
        fprintf(out, "  %-10s %-10s %-13s %11.3f %11.3f %12.3f %7.4f %s\n", NAME(phase_names, leg->phase),
                NAME(kind_names, leg->kind), NAME(ramp_names, leg->ramp), leg->t_start_s, leg->duration_s,
                leg->impulse_Ns, leg->peak_speed, leg->kind == LCM_SSV_LEG_T_KIND_TURN ? "rad/s" : "m/s");
    }
    for (int8_t phase = LCM_SSV_LEG_T_PHASE_TRANSIT; phase <= LCM_SSV_LEG_T_PHASE_TRANSFER; phase++) {
        double time_s = 0, impulse_Ns = 0;
        phase_sums(plan, phase, &time_s, &impulse_Ns);
        fprintf(out, "  %-10s %-10s %-13s %11s %11.3f %12.3f\n", phase_names[phase], "in all", "", "", time_s,
                impulse_Ns);
    }
}

/// The best possible plan costs no less than the bound, so the plan's distance from the bound is the most it can be
/// off.
static double gap_percent(const lcm_ssv_quote_t* quote) { return 100 * (quote->cost / quote->cost_lower_bound - 1); }

static void bound_line(FILE* out, const lcm_ssv_quote_t* quote) {
    fprintf(out, "No plan of any kind costs less than %.3f", quote->cost_lower_bound);
    if (quote->cost_lower_bound > 0) {
        fprintf(out, ": this one is at most %.1f %% above the best possible", gap_percent(quote));
    }
    fputc('\n', out);
}

static const char* base_name(const char* path) {
    const char* const slash = strrchr(path, '/');
    return slash == NULL ? path : slash + 1;
}

bool report_plan_table(FILE* out, const void* report) {
    const char* const title = base_name(((const report_plan_t*)report)->path);
    const lcm_ssv_scenario_t* question = ((const report_plan_t*)report)->question;
    const lcm_ssv_plan_t* plan = ((const report_plan_t*)report)->plan;
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
    const bool is_optimal = question->options.method == LCM_SSV_OPTIONS_T_METHOD_OPTIMAL;
    fprintf(out, "%s: J = %.9g /s x %.3f s + %.9g /(N s) x %.3f N s = %.3f\n", title, question->weight_time_per_s,
            quote->time_s, question->weight_impulse_per_Ns, quote->impulse_Ns, quote->cost);
    bound_line(out, quote);
    fprintf(out, "Mates at height %+.4f m, ring angle %+.1f deg; contact %d docks\n", quote->choice.attach_height_m,
            quote->choice.ring_angle_rad * DEG_PER_RAD, quote->choice.contact);
    detail_tables(out, quote);
    fputc('\n', out);
    legs_table(out, plan);
    fputc('\n', out);
    for (int i = 0; i < plan->num_events; i++) {
        fprintf(out, "  %s at %.3f s\n", NAME(event_names, plan->events[i].kind), plan->events[i].t_s);
    }
    fprintf(out, "  method %s%s%s\n", NAME(scenario_methods, question->options.method), is_optimal ? ", effort " : "",
            is_optimal ? NAME(scenario_efforts, question->options.effort) : "");
    fprintf(out, "  %d combinations priced, %d timeline segments, %d bytes on the wire\n",
            (int)quote->choice.candidates, plan->num_segments, lcm_ssv_plan_t_encoded_size(plan));
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
    if (quote->cost_lower_bound > 0) {
        fprintf(out, "  %6.1f", gap_percent(quote));
    } else {
        fprintf(out, "  %6s", "-");
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
