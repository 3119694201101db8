#include "ssv/answer.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "planner/model/fields.def"
#include "ssv/check.h"

#define DEG_PER_RAD 57.29577951308232

static vec3_t vec3_from_wire(const double v[3]) {
    return vec3(real_from_double(v[0]), real_from_double(v[1]), real_from_double(v[2]));
}

static quat_t quat_from_wire(const double q[4]) {
    const quat_t quat = {real_from_double(q[0]), real_from_double(q[1]), real_from_double(q[2]),
                         real_from_double(q[3])};
    return quat;
}

// How a field comes in, by its kind.
#define FROM_REAL(value) real_from_double(value)
#define FROM_VEC3(value) vec3_from_wire(value)
#define FROM_UNIT(value) vec3_from_wire(value)
#define FROM_QUAT(value) quat_from_wire(value)
#define FROM_INT(value) (value)
#define FROM_BOOL(value) ((value) != 0)
#define FROM_ENUM(type) (type)
#define FROM_HEIGHT(k) real_from_double
#define FROM_RING(value) real_from_double(value)
#define FROM_ADDED(value) real_from_double(value)
#define FROM_FIELD(kind, core, wire, min, max, unit, text) scenario->core = FROM_##kind(message->wire);

void ssv_scenario_from_wire(ssv_scenario_t* scenario, const lcm_ssv_scenario_t* message, const ssv_scene_t* scene) {
    memset(scenario, 0, sizeof *scenario);
    SSV_FIELDS(FROM_FIELD)
    scenario->scene = scene;
    scenario->obstacles = (uint64_t)message->obstacles;
    scenario->left = (uint64_t)message->left;
}

// Of what stands by itself.
#define FROM_KEPT_FIELD(kind, core, wire, min, max, unit, text) core = FROM_##kind(wire);

void ssv_scene_from_wire(ssv_scene_t* to, const lcm_ssv_scene_t* message) {
    const lcm_ssv_scene_t scene = *message; // by the name that it has in the table
    memset(to, 0, sizeof *to);
    to->num_obstacles = scene.num_obstacles;
    for (int i = 0; i < SSV_MAX_OBSTACLES; i++) {
        ssv_obstacle_t obstacle;
        SSV_OBSTACLE_FIELDS(FROM_KEPT_FIELD)
        SSV_CAPSULE_FIELDS(FROM_KEPT_FIELD)
        SSV_AXIS_FIELDS(FROM_KEPT_FIELD)
        to->obstacle[i] = obstacle;
    }
    ssv_tank_t tank = {.kind = (ssv_tank_kind_t)scene.tank.kind};
    SSV_TANK_FIELDS(FROM_KEPT_FIELD)
    SSV_CYLINDER_FIELDS(FROM_KEPT_FIELD)
    to->tank = tank;
}

static void vec3_to_wire(double wire[3], vec3_t v) {
    wire[0] = real_to_double(v.x);
    wire[1] = real_to_double(v.y);
    wire[2] = real_to_double(v.z);
}

static lcm_ssv_pose_t pose_to_wire(pose_t pose) {
    lcm_ssv_pose_t wire;
    vec3_to_wire(wire.p_m, pose.p);
    wire.q[0] = real_to_double(pose.q.w);
    wire.q[1] = real_to_double(pose.q.x);
    wire.q[2] = real_to_double(pose.q.y);
    wire.q[3] = real_to_double(pose.q.z);
    return wire;
}

/// A candidate, with its reason in words of SSV_CANDIDATE_REASON_SIZE.
static lcm_ssv_candidate_t candidate_to_wire(const ssv_candidate_t* candidate, const char* reason) {
    const bool names_obstacle = candidate->outcome >= SSV_NO_WAY;
    const lcm_ssv_candidate_t wire = {
        .contact = (int8_t)candidate->contact,
        .attach_height_m = real_to_double(candidate->attach_height_m),
        .ring_angle_rad = real_to_double(candidate->ring_angle_rad),
        .reason = (char*)reason, // encoders only read it
        .time_s = real_to_double(candidate->time_s),
        .impulse_Ns = real_to_double(candidate->impulse_Ns),
        .cost = real_to_double(candidate->cost),
        .body = names_obstacle ? (int8_t)candidate->body : 0,
        .obstacle = names_obstacle ? (int8_t)candidate->obstacle : LCM_SSV_CLEARANCE_T_OBSTACLE_NONE,
        .clearance_m = names_obstacle ? real_to_double(candidate->clearance_m) : 0};
    return wire;
}

static lcm_ssv_leg_t leg_to_wire(const ssv_leg_t* leg) {
    lcm_ssv_leg_t wire = {.phase = (int8_t)leg->phase,
                          .kind = (int8_t)leg->kind,
                          .ramp = (int8_t)leg->ramp,
                          .t_start_s = real_to_double(leg->t_start_s),
                          .duration_s = real_to_double(leg->duration_s),
                          .impulse_Ns = real_to_double(leg->impulse_Ns),
                          .length = real_to_double(leg->length),
                          .peak_speed = real_to_double(leg->peak_speed),
                          .X_IS_start = pose_to_wire(leg->X_IS_start),
                          .X_IS_end = pose_to_wire(leg->X_IS_end),
                          .first_arc = (int8_t)leg->first_arc,
                          .num_arcs = (int8_t)leg->num_arcs};
    vec3_to_wire(wire.v_S, leg->v_S);
    vec3_to_wire(wire.w_S, leg->w_S);
    return wire;
}

static lcm_ssv_arc_t arc_to_wire(const ssv_arc_t* arc) {
    lcm_ssv_arc_t wire = {.t_s = real_to_double(arc->t_s),
                          .duration_s = real_to_double(arc->duration_s),
                          .s = real_to_double(arc->s),
                          .v_start = real_to_double(arc->v_start),
                          .v_end = real_to_double(arc->v_end)};
    for (int i = 0; i < 3; i++) wire.dv_dt[i] = real_to_double(arc->dv_dt[i]);
    return wire;
}

static lcm_ssv_segment_t segment_to_wire(const ssv_segment_t* segment) {
    lcm_ssv_segment_t wire = {.t_s = real_to_double(segment->t_s),
                              .duration_s = real_to_double(segment->duration_s),
                              .leg = (int8_t)segment->leg};
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        wire.u_start_N[i] = real_to_double(segment->u_start_N[i]);
        wire.u_end_N[i] = real_to_double(segment->u_end_N[i]);
    }
    return wire;
}

static lcm_ssv_clearance_t clearance_to_wire(const ssv_clearance_t* clearance) {
    const lcm_ssv_clearance_t wire = {.certified_m = real_to_double(clearance->certified_m),
                                      .seen_m = real_to_double(clearance->seen_m),
                                      .leg = (int8_t)clearance->leg,
                                      .s = real_to_double(clearance->s),
                                      .body = (int8_t)clearance->body,
                                      .obstacle = (int8_t)clearance->obstacle};
    return wire;
}

static lcm_ssv_arrival_t arrival_to_wire(const ssv_arrival_t* arrival) {
    const lcm_ssv_arrival_t wire = {.rounding_m = real_to_double(arrival->rounding.position_m),
                                    .rounding_rad = real_to_double(arrival->rounding.angle_rad),
                                    .lines_m = real_to_double(arrival->lines.position_m),
                                    .lines_rad = real_to_double(arrival->lines.angle_rad)};
    return wire;
}

/// Appends to a reason of SSV_REASON_SIZE; what does not fit is cut.
__attribute__((format(printf, 2, 3))) static void reason_add(char* reason, const char* format, ...) {
    const size_t used = strlen(reason);
    va_list args;
    va_start(args, format);
    vsnprintf(reason + used, SSV_REASON_SIZE - used, format, args);
    va_end(args);
}

/// "vehicle.thruster[i].n_T_S" and 2 give "vehicle.thruster[2].n_T_S".
static void reason_add_field(char* reason, const char* field, int index) {
    const char* const open = strchr(field, '[');
    if (open == NULL || index < 0) {
        reason_add(reason, "%s", field);
        return;
    }
    reason_add(reason, "%.*s[%d%s", (int)(open - field), field, index, strchr(open, ']'));
}

static void reason_add_overflow(char* reason) {
    reason_add(reason,
               "a number does not fit the planner's arithmetic, " REAL_NAME "; ask a planner that computes in double");
}

static void reason_add_miss(char* reason, const ssv_miss_t* miss) {
    reason_add(reason,
               "flown open loop its plan would end %.2g m and %.2g deg off by what " REAL_NAME
               " rounds alone; ask a planner that computes in double",
               real_to_double(miss->position_m), real_to_double(miss->angle_rad) * DEG_PER_RAD);
}

/// "[0, 0, 1]" for a direction of the vehicle.
static void reason_add_direction(char* reason, vec3_t n_S) {
    const double n[3] = {real_to_double(n_S.x), real_to_double(n_S.y), real_to_double(n_S.z)};
    reason_add(reason, " [%.2g, %.2g, %.2g]", n[0], n[1], n[2]);
}

static void reason_add_lack(char* reason, const ssv_lack_t* lack) {
    const bool no_push = vec3_norm(lack->push_S) > REAL(0), no_turn = vec3_norm(lack->turn_S) > REAL(0);
    reason_add(reason, ": placed so that they cannot");
    if (no_push) {
        reason_add(reason, " push along");
        reason_add_direction(reason, lack->push_S);
        reason_add(reason, "%s", lack->coupled ? " without a turn" : "");
    }
    reason_add(reason, "%s", no_push && no_turn ? ", nor" : "");
    if (no_turn) {
        reason_add(reason, " turn about");
        reason_add_direction(reason, lack->turn_S);
        reason_add(reason, "%s", lack->coupled ? " without a push" : "");
    }
    reason_add(reason, " (x, y, z of the vehicle)");
}

static void reason_add_impossible(char* reason, const ssv_fault_t* fault) {
    const double value = real_to_double(fault->value), min = real_to_double(fault->min);
    if (strcmp(fault->field, "standoff_m") == 0) {
        reason_add(
            reason,
            ": %.9g is inside hull and beam, whose radii make %.9g; give that or more, or the hull's radius where "
            "the beam counts as a line",
            value, min);
    } else {
        reason_add(reason, ": %.9g is more than the other two together, %.9g, which no body has", value,
                   real_to_double(fault->max));
    }
}

/// The fault in words: where, what, and what would be right.
static void reason_add_fault(char* reason, const ssv_fault_t* fault) {
    const double value = real_to_double(fault->value);
    const double min = real_to_double(fault->min);
    const double max = real_to_double(fault->max);
    reason_add_field(reason, fault->field, fault->index);
    switch (fault->status) {
        case SSV_E_NOT_FINITE:
            // printf would show the sign of a NaN, which means nothing.
            reason_add(reason, ": %s is not a finite number", isnan(value) ? "nan" : value < 0 ? "-inf" : "inf");
            break;
        case SSV_E_RANGE:
            if (strcmp(fault->field, "obstacles") == 0) {
                reason_add(reason, ": bit %.0f is set, but the scene has %.0f obstacles", value, max + 1);
                break;
            }
            reason_add(reason, ": %.9g is outside its range [%.9g, %.9g]", value, min, max);
            break;
        case SSV_E_NOT_UNIT: reason_add(reason, ": length %.9g is not 1 within %.1g", value, max - 1); break;
        case SSV_E_SINGULAR: reason_add_lack(reason, &fault->lack); break;
        case SSV_E_WEIGHTS:
            reason_add(reason, " and weight_impulse_per_Ns: both are zero, one must be positive");
            break;
        case SSV_E_IMPOSSIBLE: reason_add_impossible(reason, fault); break;
        case SSV_E_TOO_FINE:
            reason_add(reason,
                       ": %.9g has too few digits in " REAL_NAME
                       ", which takes %.3g and more; ask a planner that computes in double",
                       value, min);
            break;
        case SSV_OK:
        case SSV_INFEASIBLE:
        case SSV_NUMERIC_OVERFLOW: break;
    }
}

/// "18 mm" for a distance that is not negative.
static void length_to_words(double length_m, char words[16]) {
    const double mm = 1e3 * length_m;
    if (mm < 9.95) {
        snprintf(words, 16, "%.1f mm", mm);
    } else if (mm < 999.5) {
        snprintf(words, 16, "%.0f mm", mm);
    } else {
        snprintf(words, 16, "%.3g m", length_m);
    }
}

/// A sentence of SSV_CANDIDATE_REASON_SIZE; what does not fit is cut.
__attribute__((format(printf, 2, 3))) static void words_set(char* words, const char* format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(words, SSV_CANDIDATE_REASON_SIZE, format, args);
    va_end(args);
}

/// What comes how near to what.
static void nearness_to_words(const ssv_candidate_t* candidate, double margin_m, const char* before, const char* verb,
                              char* words) {
    const double clearance_m = real_to_double(candidate->clearance_m);
    const char* const body = candidate->body == SSV_BODY_BEAM ? "beam" : "vehicle";
    const bool is_tank = candidate->obstacle == SSV_OBSTACLE_TANK, is_on_its_way = candidate->outcome == SSV_NO_WAY;
    char what[24], apart[16], lack[16];
    snprintf(what, sizeof what, "obstacle %d", candidate->obstacle);
    if (is_tank) snprintf(what, sizeof what, "the tank's wall");
    if (candidate->obstacle == SSV_OBSTACLE_BEAM) snprintf(what, sizeof what, "its beam");
    length_to_words(fabs(clearance_m), apart);
    length_to_words(fmax(margin_m - clearance_m, 1e-4), lack); // what the search keeps beyond the margin counts, too
    if (clearance_m < 0) {
        words_set(words, "%sthe %s %s %s %s %s", before, body, verb, apart, is_tank ? "beyond" : "inside", what);
    } else {
        words_set(words, "%sthe %s %s%s %s %s %s, %s too near", before, body, verb, is_on_its_way ? " within" : "",
                  apart, is_on_its_way ? "of" : "from", what, lack);
    }
}

/// Why a candidate is none, in words; empty for a feasible one.
static void outcome_to_words(const ssv_candidate_t* candidate, double margin_m, char* words) {
    switch (candidate->outcome) {
        case SSV_FEASIBLE: words[0] = '\0'; break;
        case SSV_NO_WAY: nearness_to_words(candidate, margin_m, "no way: ", "comes", words); break;
        case SSV_START_BLOCKED: nearness_to_words(candidate, margin_m, "", "starts", words); break;
        case SSV_MATE_BLOCKED: nearness_to_words(candidate, margin_m, "no room to mate: ", "is", words); break;
        case SSV_GOAL_BLOCKED: nearness_to_words(candidate, margin_m, "no room to dock: ", "is", words); break;
        default: words_set(words, "%s", ssv_outcome_str(candidate->outcome)); break;
    }
}

/// Every candidate's own reason, as many as fit; once if it is the same for all.
static void reason_add_candidates(char* reason, const lcm_ssv_quote_t* quote) {
    bool is_same = quote->num_candidates > 1 && quote->candidates[0].obstacle != LCM_SSV_CLEARANCE_T_OBSTACLE_NONE;
    for (int i = 1; i < quote->num_candidates && is_same; i++) {
        is_same = strcmp(quote->candidates[i].reason, quote->candidates[0].reason) == 0;
    }
    reason_add(reason, "no feasible candidate");
    if (is_same) {
        reason_add(reason, "; each: %s", quote->candidates[0].reason);
        return;
    }
    for (int i = 0; i < quote->num_candidates; i++) {
        const lcm_ssv_candidate_t* candidate = &quote->candidates[i];
        char one[64 + SSV_CANDIDATE_REASON_SIZE];
        const int length = snprintf(one, sizeof one, "; contact %d, height %.9g m: %s", candidate->contact,
                                    candidate->attach_height_m, candidate->reason);
        if (strlen(reason) + (size_t)length + sizeof "; and 16 more" > SSV_REASON_SIZE) {
            reason_add(reason, "; and %d more", quote->num_candidates - i);
            return;
        }
        reason_add(reason, "%s", one);
    }
}

static int8_t status_to_wire(ssv_status_t status) {
    switch (status) {
        case SSV_OK: return LCM_SSV_QUOTE_T_STATUS_OK;
        case SSV_INFEASIBLE: return LCM_SSV_QUOTE_T_STATUS_INFEASIBLE;
        case SSV_NUMERIC_OVERFLOW: return LCM_SSV_QUOTE_T_STATUS_NUMERIC_OVERFLOW;
        default: return LCM_SSV_QUOTE_T_STATUS_INVALID;
    }
}

/// A refusal that does not say why yet.
static void quote_begin(ssv_quote_parts_t* parts, lcm_ssv_quote_t* wire) {
    memset(wire, 0, sizeof *wire);
    parts->reason[0] = '\0';
    wire->status = LCM_SSV_QUOTE_T_STATUS_INVALID;
    wire->reason = parts->reason;
    wire->candidates = parts->candidates;
    wire->front = parts->front;
}

/// The way from outside to a checked problem. @return SSV_OK, or what is wrong, which the reason then tells.
static ssv_status_t check(const lcm_ssv_scenario_t* question, int64_t epoch_us, char* reason, ssv_working_t* working) {
    if (epoch_us < 0) {
        reason_add(reason, "asker.epoch_us: %lld is negative, it must be 0 or later", (long long)epoch_us);
        return SSV_E_RANGE;
    }
    ssv_scenario_t scenario;
    ssv_fault_t fault;
    ssv_scenario_from_wire(&scenario, question, &working->scene);
    const ssv_status_t checked = ssv_problem_init(&working->problem, &scenario, &fault);
    if (checked != SSV_OK) {
        reason_add_fault(reason, &fault);
    }
    return checked;
}

static void front_to_wire(const ssv_front_t* front, lcm_ssv_quote_t* wire) {
    wire->num_front = front->num_points;
    for (int i = 0; i < front->num_points; i++) {
        wire->front[i] = candidate_to_wire(&front->point[i], "");
    }
}

/// The core's quote in words of the wire.
static void quote_to_wire(const ssv_quote_t* quote, double margin_m, ssv_quote_parts_t* parts, lcm_ssv_quote_t* wire) {
    wire->scenario_hash = (int64_t)quote->scenario_hash;
    wire->num_candidates = quote->num_candidates;
    for (int i = 0; i < quote->num_candidates; i++) {
        outcome_to_words(&quote->candidate[i], margin_m, parts->candidate_reason[i]);
        wire->candidates[i] = candidate_to_wire(&quote->candidate[i], parts->candidate_reason[i]);
    }
    wire->status = status_to_wire(quote->status);
    if (quote->status == SSV_INFEASIBLE) {
        reason_add_candidates(wire->reason, wire);
    } else if (quote->status == SSV_NUMERIC_OVERFLOW && wire->reason[0] == '\0') {
        reason_add_overflow(wire->reason);
    }
    if (quote->status != SSV_OK) {
        return;
    }
    wire->cost = real_to_double(quote->cost);
    wire->cost_lower_bound = real_to_double(quote->lower_bound);
    wire->time_s = real_to_double(quote->time_s);
    wire->impulse_Ns = real_to_double(quote->impulse_Ns);
    wire->choice.contact = (int8_t)quote->choice.contact;
    wire->choice.attach_height_m = real_to_double(quote->choice.attach_height_m);
    wire->choice.ring_angle_rad = real_to_double(quote->choice.ring_angle_rad);
    wire->choice.candidates = quote->num_priced;
    wire->X_IS_final = pose_to_wire(quote->X_IS_final);
    wire->X_IB_final = pose_to_wire(quote->X_IB_final);
}

static void motion_to_wire(const ssv_plan_t* plan, const ssv_arrival_t* arrival, lcm_ssv_plan_t* wire) {
    wire->plan_hash = (int64_t)plan->plan_hash;
    wire->num_legs = plan->num_legs;
    for (int i = 0; i < plan->num_legs; i++) {
        wire->legs[i] = leg_to_wire(&plan->leg[i]);
    }
    wire->num_arcs = plan->num_arcs;
    for (int i = 0; i < plan->num_arcs; i++) {
        wire->arcs[i] = arc_to_wire(&plan->arc[i]);
    }
    wire->num_segments = plan->num_segments;
    for (int i = 0; i < plan->num_segments; i++) {
        wire->segments[i] = segment_to_wire(&plan->segment[i]);
    }
    wire->num_events = plan->num_events;
    for (int i = 0; i < plan->num_events; i++) {
        wire->events[i].t_s = real_to_double(plan->event[i].t_s);
        wire->events[i].kind = (int8_t)plan->event[i].kind;
    }
    wire->X_SB = pose_to_wire(plan->X_SB);
    wire->clearance = clearance_to_wire(&plan->clearance);
    wire->arrival = arrival_to_wire(arrival);
}

// ---- One scenario, in slices ----------------------------------------------------------------------------------------

enum { CHECKS, ANSWERS, CLIMBS_FRONT, IS_ANSWERED };

static void work_begin(ssv_working_t* working) {
    working->stage = CHECKS;
    working->status = SSV_INFEASIBLE;
}

/// What comes after a step of the plan or of the quote.
static void work_priced(const lcm_ssv_scenario_t* scenario, const ssv_quote_t* quote, ssv_working_t* working,
                        ssv_quote_parts_t* parts, lcm_ssv_quote_t* wire) {
    working->status = quote->status;
    working->stage = IS_ANSWERED;
    quote_to_wire(quote, real_to_double(working->problem.scenario.margin_m), parts, wire);
    if (quote->status == SSV_OK && scenario->options.want_front != 0) {
        ssv_front_begin(&working->problem, &working->work, &working->front);
        working->stage = CLIMBS_FRONT;
    }
}

/// The first and the last stages, which plans and quotes have in common. @return whether the stage was one of these.
static bool work_around(const lcm_ssv_scenario_t* scenario, int64_t epoch_us, ssv_working_t* working,
                        lcm_ssv_quote_t* wire) {
    if (working->stage == CHECKS) {
        working->status = check(scenario, epoch_us, wire->reason, working);
        working->stage = working->status == SSV_OK ? ANSWERS : IS_ANSWERED;
        working->begun = false;
    } else if (working->stage == CLIMBS_FRONT) {
        if (ssv_front_step(&working->work, &working->front)) {
            front_to_wire(&working->front, wire);
            working->stage = IS_ANSWERED;
        }
    } else {
        return working->stage == IS_ANSWERED;
    }
    return true;
}

// ---- A plan ---------------------------------------------------------------------------------------------------------

lcm_ssv_planner_t ssv_planner_identity(int64_t planner_id) {
    const int8_t scalar = strcmp(REAL_NAME, "double") == 0  ? LCM_SSV_PLANNER_T_SCALAR_DOUBLE
                          : strcmp(REAL_NAME, "float") == 0 ? LCM_SSV_PLANNER_T_SCALAR_FLOAT
                                                            : LCM_SSV_PLANNER_T_SCALAR_FIXED;
    return (lcm_ssv_planner_t){.planner_id = planner_id, .version = (char*)SSV_VERSION, .scalar = scalar};
}

void ssv_answer_begin(const lcm_ssv_task_t* question, const lcm_ssv_planner_t* planner, ssv_answer_t* answer) {
    memset(&answer->wire, 0, sizeof answer->wire);
    answer->wire.answer = (lcm_ssv_answer_t){.asker = question->scenario.asker,
                                             .question_hash = (int64_t)ssv_task_question_hash(question),
                                             .planner = *planner};
    answer->wire.clearance.obstacle = LCM_SSV_CLEARANCE_T_OBSTACLE_NONE;
    quote_begin(&answer->parts, &answer->wire.quote);
    answer->wire.legs = answer->legs;
    answer->wire.arcs = answer->arcs;
    answer->wire.segments = answer->segments;
    answer->wire.events = answer->events;
    ssv_scene_from_wire(&answer->working.scene, &question->scene);
    work_begin(&answer->working);
}

/// A plan that would arrive but for the arithmetic becomes a numeric overflow.
static void refuse_what_misses(const ssv_working_t* working, ssv_plan_t* plan, ssv_arrival_t* arrival, char* reason) {
    if (ssv_plan_arrival(&working->problem, plan, arrival)) return;
    const uint64_t hash = plan->quote.scenario_hash;
    memset(plan, 0, sizeof *plan);
    plan->quote.status = SSV_NUMERIC_OVERFLOW;
    plan->quote.scenario_hash = hash;
    reason_add_miss(reason, &arrival->rounding);
}

bool ssv_answer_step(const lcm_ssv_task_t* question, ssv_answer_t* answer) {
    const lcm_ssv_scenario_t* scenario = &question->scenario;
    ssv_working_t* working = &answer->working;
    lcm_ssv_quote_t* quote = &answer->wire.quote;
    if (!work_around(scenario, scenario->asker.epoch_us, working, quote)) {
        if (!working->begun) {
            ssv_plan_begin(&working->problem, &working->work, &answer->plan);
            working->begun = true;
        } else if (ssv_plan_step(&working->work, &answer->plan)) {
            ssv_arrival_t arrival = {{REAL(0), REAL(0)}, {REAL(0), REAL(0)}};
            if (answer->plan.quote.status == SSV_OK)
                refuse_what_misses(working, &answer->plan, &arrival, quote->reason);
            work_priced(scenario, &answer->plan.quote, working, &answer->parts, quote);
            if (working->status == SSV_OK) motion_to_wire(&answer->plan, &arrival, &answer->wire);
        }
    }
    return working->stage == IS_ANSWERED;
}

void ssv_answer_refuse(const char* reason, ssv_answer_t* answer) {
    reason_add(answer->parts.reason, "%s", reason);
    answer->working.stage = IS_ANSWERED;
}

ssv_status_t ssv_answer(const lcm_ssv_task_t* question, const lcm_ssv_planner_t* planner, ssv_answer_t* answer) {
    ssv_answer_begin(question, planner, answer);
    while (!ssv_answer_step(question, answer)) {}
    return answer->working.status;
}

// ---- A batch --------------------------------------------------------------------------------------------------------

void ssv_answer_batch_begin(const lcm_ssv_scenario_batch_t* question, uint64_t question_hash,
                            const lcm_ssv_planner_t* planner, ssv_batch_answer_t* answer) {
    memset(&answer->wire, 0, sizeof answer->wire);
    answer->wire.answer =
        (lcm_ssv_answer_t){.asker = question->asker, .question_hash = (int64_t)question_hash, .planner = *planner};
    answer->wire.quotes = answer->quotes;
    ssv_scene_from_wire(&answer->working.scene, &question->scene);
    work_begin(&answer->working);
}

/// A refusal of the next scenario that does not say why yet. @return its number.
static int batch_quote_begin(ssv_batch_answer_t* answer) {
    const int i = answer->wire.num_quotes++;
    quote_begin(&answer->parts[i], &answer->quotes[i]);
    return i;
}

bool ssv_answer_batch_step(const lcm_ssv_scenario_batch_t* question, ssv_batch_answer_t* answer) {
    ssv_working_t* working = &answer->working;
    if (working->stage == IS_ANSWERED) work_begin(working);
    const int i = working->stage == CHECKS ? batch_quote_begin(answer) : answer->wire.num_quotes - 1;
    const lcm_ssv_scenario_t* scenario = &question->scenarios[i];
    if (!work_around(scenario, question->asker.epoch_us, working, &answer->quotes[i])) {
        if (!working->begun) {
            ssv_quote_begin(&working->problem, &working->work, &answer->quote);
            working->begun = true;
        } else if (ssv_quote_step(&working->work, &answer->quote)) {
            work_priced(scenario, &answer->quote, working, &answer->parts[i], &answer->quotes[i]);
        }
    }
    answer->scenario_done = working->stage == IS_ANSWERED;
    return answer->scenario_done && answer->wire.num_quotes == question->num_scenarios;
}

void ssv_answer_batch(const lcm_ssv_scenario_batch_t* question, uint64_t question_hash,
                      const lcm_ssv_planner_t* planner, ssv_batch_answer_t* answer) {
    ssv_answer_batch_begin(question, question_hash, planner, answer);
    while (!ssv_answer_batch_step(question, answer)) {}
}

void ssv_answer_batch_refuse(const lcm_ssv_scenario_batch_t* question, const char* reason, ssv_batch_answer_t* answer) {
    while (answer->wire.num_quotes < question->num_scenarios) {
        const int i = batch_quote_begin(answer);
        reason_add(answer->parts[i].reason, "%s", reason);
    }
    answer->working.stage = IS_ANSWERED;
}

bool ssv_scenario_batch_decode(const void* data, size_t size, lcm_ssv_scenario_t scenarios[SSV_MAX_BATCH],
                               lcm_ssv_scenario_batch_t* batch) {
    // encoded_size counts a type hash, which a part of a message does not have.
    const size_t hash_size = 8;
    const size_t asker_size = (size_t)lcm_ssv_asker_t_encoded_size(&(lcm_ssv_asker_t){0}) - hash_size;
    const size_t scene_size = (size_t)lcm_ssv_scene_t_encoded_size(&(lcm_ssv_scene_t){0}) - hash_size;
    const size_t scenario_size = (size_t)lcm_ssv_scenario_t_encoded_size(&(lcm_ssv_scenario_t){0}) - hash_size;
    const size_t count_at = hash_size + asker_size, scene_at = count_at + 4, head_size = scene_at + scene_size;
    int64_t type_hash = 0;
    int32_t count = 0;
    if (size < head_size || __int64_t_decode_array(data, 0, (int)hash_size, &type_hash, 1) < 0 ||
        type_hash != __lcm_ssv_scenario_batch_t_get_hash() ||
        __int32_t_decode_array(data, (int)count_at, 4, &count, 1) < 0 || count < 1 || count > SSV_MAX_BATCH ||
        size != head_size + (size_t)count * scenario_size) {
        return false;
    }
    *batch = (lcm_ssv_scenario_batch_t){.num_scenarios = count, .scenarios = scenarios};
    __lcm_ssv_asker_t_decode_array(data, (int)hash_size, (int)asker_size, &batch->asker, 1);
    __lcm_ssv_scene_t_decode_array(data, (int)scene_at, (int)scene_size, &batch->scene, 1);
    __lcm_ssv_scenario_t_decode_array(data, (int)head_size, (int)(size - head_size), scenarios, count);
    return true;
}

// ---- Back into the core's types -------------------------------------------------------------------------------------

static pose_t pose_from_wire(const lcm_ssv_pose_t* wire) {
    return (pose_t){vec3_from_wire(wire->p_m), quat_from_wire(wire->q)};
}

static ssv_leg_t leg_from_wire(const lcm_ssv_leg_t* wire) {
    return (ssv_leg_t){.phase = (ssv_phase_t)wire->phase,
                       .kind = (ssv_leg_kind_t)wire->kind,
                       .ramp = (ssv_ramp_t)wire->ramp,
                       .t_start_s = real_from_double(wire->t_start_s),
                       .duration_s = real_from_double(wire->duration_s),
                       .impulse_Ns = real_from_double(wire->impulse_Ns),
                       .length = real_from_double(wire->length),
                       .peak_speed = real_from_double(wire->peak_speed),
                       .v_S = vec3_from_wire(wire->v_S),
                       .w_S = vec3_from_wire(wire->w_S),
                       .X_IS_start = pose_from_wire(&wire->X_IS_start),
                       .X_IS_end = pose_from_wire(&wire->X_IS_end),
                       .first_arc = wire->first_arc,
                       .num_arcs = wire->num_arcs};
}

void ssv_plan_from_wire(ssv_plan_t* plan, const lcm_ssv_plan_t* wire) {
    memset(plan, 0, sizeof *plan);
    plan->quote.choice.contact = wire->quote.choice.contact;
    plan->quote.time_s = real_from_double(wire->quote.time_s);
    plan->quote.X_IS_final = pose_from_wire(&wire->quote.X_IS_final);
    plan->quote.X_IB_final = pose_from_wire(&wire->quote.X_IB_final);
    plan->plan_hash = (uint64_t)wire->plan_hash;
    plan->X_SB = pose_from_wire(&wire->X_SB);
    plan->num_legs = wire->num_legs;
    for (int k = 0; k < wire->num_legs; k++) plan->leg[k] = leg_from_wire(&wire->legs[k]);
    plan->num_arcs = wire->num_arcs;
    for (int k = 0; k < wire->num_arcs; k++) {
        const lcm_ssv_arc_t* from = &wire->arcs[k];
        ssv_arc_t* arc = &plan->arc[k];
        *arc = (ssv_arc_t){.t_s = real_from_double(from->t_s),
                           .duration_s = real_from_double(from->duration_s),
                           .s = real_from_double(from->s),
                           .v_start = real_from_double(from->v_start),
                           .v_end = real_from_double(from->v_end)};
        for (int i = 0; i < 3; i++) arc->dv_dt[i] = real_from_double(from->dv_dt[i]);
    }
    plan->num_segments = wire->num_segments;
    for (int k = 0; k < wire->num_segments; k++) {
        const lcm_ssv_segment_t* from = &wire->segments[k];
        ssv_segment_t* segment = &plan->segment[k];
        segment->t_s = real_from_double(from->t_s);
        segment->duration_s = real_from_double(from->duration_s);
        segment->leg = from->leg;
        for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
            segment->u_start_N[i] = real_from_double(from->u_start_N[i]);
            segment->u_end_N[i] = real_from_double(from->u_end_N[i]);
        }
    }
    plan->num_events = wire->num_events;
    for (int k = 0; k < wire->num_events; k++) {
        plan->event[k] = (ssv_event_t){real_from_double(wire->events[k].t_s), (ssv_event_kind_t)wire->events[k].kind};
    }
}
