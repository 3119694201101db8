#include "ssv/check.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ssv/answer.h"

#define PI 3.14159265358979323846
#define NUM_THRUSTERS 6
/// Type hash and asker_t, which are no part of what is asked.
#define ASKER_END (8 + 4 * 8)
/// Longest encoded task.
#define TASK_BYTES_MAX 8192

// ---- The hash of a question -----------------------------------------------------------------------------------------

uint64_t ssv_question_hash(const void* message, size_t size) {
    const uint8_t* bytes = message;
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    if (size <= ASKER_END) return 0;
    for (size_t i = ASKER_END; i < size; i++) hash = (hash ^ bytes[i]) * UINT64_C(0x100000001b3);
    return hash;
}

uint64_t ssv_task_question_hash(const lcm_ssv_task_t* question) {
    uint8_t message[TASK_BYTES_MAX];
    const int size = lcm_ssv_task_t_encode(message, 0, sizeof message, question);
    return size > 0 ? ssv_question_hash(message, (size_t)size) : 0;
}

// ---- What is wrong --------------------------------------------------------------------------------------------------

// A check stops at the first fault, which it names. Numbers of a planner are as good as its arithmetic: `relative` of
// their size, and `absolute` for those that come of differences of positions and angles of some metres and radians.
typedef struct {
    char* reason;
    double relative, absolute;
} check_t;

__attribute__((format(printf, 2, 3))) static bool fail(const check_t* check, const char* format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(check->reason, SSV_CHECK_REASON_SIZE, format, args);
    va_end(args);
    return false;
}

static bool is_near(const check_t* check, double a, double b, double size) {
    return fabs(a - b) <= check->relative * size + check->absolute; // false for what is not a number
}

static bool check_sum(const check_t* check, const char* what, double is, double should_be) {
    if (is_near(check, is, should_be, fabs(is) + fabs(should_be))) return true;
    return fail(check, "%s: %.9g, but what it is made of gives %.9g", what, is, should_be);
}

static bool check_amount(const check_t* check, const char* what, double value) {
    if (isfinite(value) && value >= 0) return true;
    return fail(check, "%s: %.9g is no amount", what, value);
}

// ---- Poses ----------------------------------------------------------------------------------------------------------

static void turn(const double q[4], const double v[3], double turned[3]) {
    const double t[3] = {2 * (q[2] * v[2] - q[3] * v[1]), 2 * (q[3] * v[0] - q[1] * v[2]),
                         2 * (q[1] * v[1] - q[2] * v[0])};
    turned[0] = v[0] + q[0] * t[0] + q[2] * t[2] - q[3] * t[1];
    turned[1] = v[1] + q[0] * t[1] + q[3] * t[0] - q[1] * t[2];
    turned[2] = v[2] + q[0] * t[2] + q[1] * t[1] - q[2] * t[0];
}

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void quat_product(const double a[4], const double b[4], double product[4]) {
    product[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    product[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    product[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    product[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

static void compose(const lcm_ssv_pose_t* X_AB, const lcm_ssv_pose_t* X_BC, lcm_ssv_pose_t* X_AC) {
    double p[3];
    turn(X_AB->q, X_BC->p_m, p);
    for (int i = 0; i < 3; i++) X_AC->p_m[i] = X_AB->p_m[i] + p[i];
    quat_product(X_AB->q, X_BC->q, X_AC->q);
}

static bool check_pose(const check_t* check, const char* what, const lcm_ssv_pose_t* X) {
    for (int i = 0; i < 3; i++) {
        if (!(fabs(X->p_m[i]) <= 1e5)) return fail(check, "%s.p_m[%d]: %.9g m is nowhere near", what, i, X->p_m[i]);
    }
    const double norm = sqrt(X->q[0] * X->q[0] + X->q[1] * X->q[1] + X->q[2] * X->q[2] + X->q[3] * X->q[3]);
    if (fabs(norm - 1) <= 1e-3) return true;
    return fail(check, "%s.q: length %.9g is not 1", what, norm);
}

// Within the rounding of positions some tens of metres from the origin, which attitudes and lengths act on.
static bool same_pose(const check_t* check, const lcm_ssv_pose_t* a, const lcm_ssv_pose_t* b) {
    const double size = 10 + fabs(a->p_m[0]) + fabs(a->p_m[1]) + fabs(a->p_m[2]);
    double cosine = 0, norms = 1;
    for (int i = 0; i < 3; i++) {
        if (!is_near(check, a->p_m[i], b->p_m[i], 10 * size)) return false;
    }
    double aa = 0, bb = 0;
    for (int i = 0; i < 4; i++) {
        cosine += a->q[i] * b->q[i];
        aa += a->q[i] * a->q[i];
        bb += b->q[i] * b->q[i];
    }
    norms = sqrt(aa * bb);
    const double angle = 2 * sqrt(fmax(0, 2 * (1 - fabs(cosine) / norms)));
    return angle <= 100 * (check->relative + check->absolute) + 1e-7;
}

static bool check_same_pose(const check_t* check, const char* what, const lcm_ssv_pose_t* a, const lcm_ssv_pose_t* b) {
    return same_pose(check, a, b) || fail(check, "%s: not the pose that the motion leads to", what);
}

// X exp(twist s) by Rodrigues' formula.
static void move_along(const lcm_ssv_leg_t* leg, double s, lcm_ssv_pose_t* X) {
    const double rate = sqrt(dot(leg->w_S, leg->w_S)), angle = rate * s;
    lcm_ssv_pose_t moved = {.q = {1, 0, 0, 0}};
    double w[3] = {0, 0, 0}, across[3] = {0, 0, 0}, back[3] = {0, 0, 0};
    if (angle > 0) {
        const double c = 2 * pow(sin(angle / 2), 2) / angle, d = 1 - sin(angle) / angle;
        for (int i = 0; i < 3; i++) w[i] = leg->w_S[i] / rate;
        for (int i = 0; i < 3; i++) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            across[i] = s * (w[j] * leg->v_S[k] - w[k] * leg->v_S[j]);
        }
        for (int i = 0; i < 3; i++) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            back[i] = w[j] * across[k] - w[k] * across[j];
        }
        moved.q[0] = cos(angle / 2);
        for (int i = 0; i < 3; i++) {
            moved.q[1 + i] = w[i] * sin(angle / 2);
            moved.p_m[i] = c * across[i] + d * back[i];
        }
    }
    for (int i = 0; i < 3; i++) moved.p_m[i] += s * leg->v_S[i];
    lcm_ssv_pose_t end;
    compose(X, &moved, &end);
    *X = end;
}

// ---- A price --------------------------------------------------------------------------------------------------------

static double price_of(const lcm_ssv_scenario_t* question, double time_s, double impulse_Ns) {
    return question->weight_time_per_s * time_s + question->weight_impulse_per_Ns * impulse_Ns;
}

static bool check_place(const check_t* check, const lcm_ssv_scenario_t* question, const char* what, int contact,
                        double height_m, double ring_angle_rad) {
    const lcm_ssv_options_t* options = &question->options;
    const double half = 0.5 * question->beam.length_m;
    const double rings[3] = {half, 0, -half};
    const bool given = options->num_attach_heights > 0;
    const double* heights = given ? options->attach_heights_m : rings;
    const int num = given ? options->num_attach_heights : 3;
    bool known = false;
    if (contact != 1 && contact != 2) return fail(check, "%s: contact %d is neither 1 nor 2", what, contact);
    if (question->contact != 0 && contact != question->contact) {
        return fail(check, "%s: contact %d, but %d was asked for", what, contact, question->contact);
    }
    if (!(fabs(height_m) <= half * (1 + check->relative) + check->absolute)) {
        return fail(check, "%s: height %.9g m is not on the beam", what, height_m);
    }
    for (int i = 0; i < num && i < 8; i++)
        known = known || is_near(check, height_m, heights[i], question->beam.length_m);
    const bool anywhere = options->attach_anywhere && options->method == LCM_SSV_OPTIONS_T_METHOD_OPTIMAL;
    if (!known && !anywhere) return fail(check, "%s: height %.9g m was not asked for", what, height_m);
    if (!(fabs(ring_angle_rad) <= 2 * PI + 1e-6)) return fail(check, "%s: ring angle %.9g rad", what, ring_angle_rad);
    if (options->ring_angle_given && !is_near(check, ring_angle_rad, options->ring_angle_rad, 2 * PI)) {
        return fail(check, "%s: ring angle %.9g rad, but %.9g was asked for", what, ring_angle_rad,
                    options->ring_angle_rad);
    }
    return true;
}

static bool check_candidates(const check_t* check, const lcm_ssv_scenario_t* question, const char* list,
                             const lcm_ssv_candidate_t* candidates, int count) {
    for (int i = 0; i < count; i++) {
        const lcm_ssv_candidate_t* candidate = &candidates[i];
        char what[32];
        snprintf(what, sizeof what, "%s[%d]", list, i);
        const bool feasible = candidate->reason == NULL || candidate->reason[0] == '\0';
        const bool has_place = candidate->obstacle >= LCM_SSV_CLEARANCE_T_OBSTACLE_NONE &&
                               candidate->obstacle <= LCM_SSV_CLEARANCE_T_OBSTACLE_TANK &&
                               isfinite(candidate->clearance_m);
        if (!has_place) return fail(check, "%s: obstacle %d is none", what, candidate->obstacle);
        if (!feasible && (candidate->contact == 1 || candidate->contact == 2)) continue;
        if (!check_place(check, question, what, candidate->contact, candidate->attach_height_m,
                         candidate->ring_angle_rad) ||
            !check_amount(check, what, candidate->time_s) || !check_amount(check, what, candidate->impulse_Ns) ||
            !check_sum(check, what, candidate->cost, price_of(question, candidate->time_s, candidate->impulse_Ns))) {
            return false;
        }
    }
    return true;
}

// The beam as the vehicle holds it: its axis `standoff_m` ahead along x, at the height chosen, square to x.
static bool check_grasp(const check_t* check, const lcm_ssv_scenario_t* question, const lcm_ssv_choice_t* choice,
                        const lcm_ssv_pose_t* X_SB) {
    const double z_B[3] = {0, 0, 1};
    double axis_S[3];
    turn(X_SB->q, z_B, axis_S);
    const double should_be[3] = {question->standoff_m, 0, 0};
    const double slack = 1e-4 + 1e3 * (check->relative + check->absolute);
    for (int i = 0; i < 3; i++) {
        const double held_m = X_SB->p_m[i] + choice->attach_height_m * axis_S[i];
        if (!(fabs(held_m - should_be[i]) <= slack)) {
            return fail(check, "X_SB: the beam is not held at its height %.9g m, %.9g m ahead of the vehicle",
                        choice->attach_height_m, question->standoff_m);
        }
    }
    return true;
}

// Positions of the scene enter here, which the planner rounds to its arithmetic; a dock that is off by a tenth of a
// millimetre or a tenth of a milliradian is none of that.
static bool check_docked(const check_t* check, const lcm_ssv_scenario_t* question, const lcm_ssv_quote_t* quote) {
    const double half = 0.5 * question->beam.length_m, sign = quote->choice.contact == 1 ? -1 : 1;
    const double outward_B[3] = {0, 0, sign};
    const double slack = 1e-4 + 1e3 * (check->relative + check->absolute);
    double outward[3];
    turn(quote->X_IB_final.q, outward_B, outward);
    const double norm = sqrt(dot(question->port.axis_I, question->port.axis_I));
    for (int i = 0; i < 3; i++) {
        const double contact_m = quote->X_IB_final.p_m[i] + half * outward[i];
        if (!(fabs(contact_m - question->port.p_IP_m[i]) <= slack)) {
            return fail(check, "X_IB_final: the beam's contact ends %.9g m beside the port",
                        contact_m - question->port.p_IP_m[i]);
        }
        if (!(fabs(outward[i] + question->port.axis_I[i] / norm) <= slack)) {
            return fail(check, "X_IB_final: the beam does not point into the port");
        }
    }
    return true;
}

static bool check_quote(const check_t* check, const lcm_ssv_scenario_t* question, const lcm_ssv_quote_t* quote) {
    if (quote->status < LCM_SSV_QUOTE_T_STATUS_OK || quote->status > LCM_SSV_QUOTE_T_STATUS_NUMERIC_OVERFLOW) {
        return fail(check, "status: %d is none", quote->status);
    }
    if (quote->status != LCM_SSV_QUOTE_T_STATUS_OK) {
        return quote->reason != NULL && quote->reason[0] != '\0' ? true : fail(check, "reason: a refusal without one");
    }
    if (quote->num_candidates > 0 && !question->options.want_candidates) {
        return fail(check, "candidates: not asked for");
    }
    if (quote->num_front > 0 && !question->options.want_front) return fail(check, "front: not asked for");
    const lcm_ssv_choice_t* choice = &quote->choice;
    if (!check_amount(check, "time_s", quote->time_s) || !check_amount(check, "impulse_Ns", quote->impulse_Ns) ||
        !check_amount(check, "cost_lower_bound", quote->cost_lower_bound) ||
        !check_sum(check, "cost", quote->cost, price_of(question, quote->time_s, quote->impulse_Ns)) ||
        !check_place(check, question, "choice", choice->contact, choice->attach_height_m, choice->ring_angle_rad) ||
        !check_candidates(check, question, "candidates", quote->candidates, quote->num_candidates) ||
        !check_candidates(check, question, "front", quote->front, quote->num_front) ||
        !check_pose(check, "X_IS_final", &quote->X_IS_final) || !check_pose(check, "X_IB_final", &quote->X_IB_final) ||
        !check_docked(check, question, quote)) {
        return false;
    }
    if (quote->cost_lower_bound > quote->cost * (1 + check->relative) + check->absolute) {
        return fail(check, "cost: %.9g is below the bound of %.9g", quote->cost, quote->cost_lower_bound);
    }
    return true;
}

static bool check_head(check_t* check, const lcm_ssv_asker_t* asker, uint64_t question_hash,
                       const lcm_ssv_answer_t* answer) {
    switch (answer->planner.scalar) {
        case LCM_SSV_PLANNER_T_SCALAR_DOUBLE: *check = (check_t){check->reason, 1e-9, 1e-9}; break;
        case LCM_SSV_PLANNER_T_SCALAR_FLOAT: *check = (check_t){check->reason, 2e-5, 1e-6}; break;
        case LCM_SSV_PLANNER_T_SCALAR_FIXED: *check = (check_t){check->reason, 1e-6, 1e-6}; break;
        default: return fail(check, "planner.scalar: %d is none", answer->planner.scalar);
    }
    if (answer->asker.asker_id != asker->asker_id || answer->asker.request_id != asker->request_id) {
        return fail(check, "answer.asker: of another question");
    }
    if ((uint64_t)answer->question_hash != question_hash) {
        return fail(check, "question_hash: %016llx, but %016llx was asked", (unsigned long long)answer->question_hash,
                    (unsigned long long)question_hash);
    }
    if (answer->planner.planner_id == 0) return fail(check, "planner.planner_id: a planner without a name");
    if (asker->planner_id != 0 && answer->planner.planner_id != asker->planner_id) {
        return fail(check, "planner.planner_id: another planner than the one that was asked");
    }
    return true;
}

bool ssv_check_quotes(const lcm_ssv_scenario_batch_t* question, uint64_t question_hash,
                      const lcm_ssv_quote_batch_t* answer, char reason[SSV_CHECK_REASON_SIZE]) {
    check_t check = {.reason = reason};
    reason[0] = '\0';
    if (!check_head(&check, &question->asker, question_hash, &answer->answer)) return false;
    if (answer->num_quotes != question->num_scenarios) {
        return fail(&check, "num_quotes: %d to %d scenarios", answer->num_quotes, question->num_scenarios);
    }
    for (int i = 0; i < answer->num_quotes; i++) {
        if (check_quote(&check, &question->scenarios[i], &answer->quotes[i])) continue;
        char fault[SSV_CHECK_REASON_SIZE];
        memcpy(fault, reason, sizeof fault);
        return fail(&check, "quotes[%d].%.*s", i, SSV_CHECK_REASON_SIZE - 24, fault);
    }
    return true;
}

// ---- A motion -------------------------------------------------------------------------------------------------------

static bool check_arcs(const check_t* check, const lcm_ssv_plan_t* plan, int index, int* next_arc) {
    const lcm_ssv_leg_t* leg = &plan->legs[index];
    double t_s = 0, s = 0, v = 0;
    if (leg->num_arcs < 1 || leg->first_arc != *next_arc || leg->first_arc + leg->num_arcs > plan->num_arcs) {
        return fail(check, "legs[%d]: its arcs are not among those of the plan", index);
    }
    for (int k = leg->first_arc; k < leg->first_arc + leg->num_arcs; k++) {
        const lcm_ssv_arc_t* arc = &plan->arcs[k];
        const double top = fmax(arc->v_start, arc->v_end);
        const bool sound = arc->duration_s > 0 && arc->v_start >= 0 && arc->v_end >= 0 && isfinite(arc->dv_dt[0]) &&
                           isfinite(arc->dv_dt[1]) && isfinite(arc->dv_dt[2]);
        if (!sound || !is_near(check, arc->t_s, t_s, leg->duration_s) || !is_near(check, arc->s, s, leg->length) ||
            !is_near(check, arc->v_start, v, leg->peak_speed) ||
            !(top <= leg->peak_speed * (1 + check->relative) + check->absolute)) {
            return fail(check, "arcs[%d]: does not go on where the last one ends", k);
        }
        t_s += arc->duration_s;
        v = arc->v_end;
        // How far it goes follows from the next one's start, or from the leg's length; between its two speeds at any
        // rate.
        s = k + 1 < leg->first_arc + leg->num_arcs ? plan->arcs[k + 1].s : leg->length;
        const double least = fmin(arc->v_start, arc->v_end) * arc->duration_s, most = top * arc->duration_s;
        const double slack = 10 * (check->relative * (most + leg->length) + check->absolute);
        if (!(s - arc->s >= least - slack && s - arc->s <= most + slack)) {
            return fail(check, "arcs[%d]: %.9g m or rad do not go with its speeds", k, s - arc->s);
        }
    }
    if (!is_near(check, t_s, leg->duration_s, leg->duration_s) || !is_near(check, v, 0, leg->peak_speed)) {
        return fail(check, "legs[%d]: its arcs do not end with it, at rest", index);
    }
    *next_arc += leg->num_arcs;
    return true;
}

static bool check_legs(const check_t* check, const lcm_ssv_scenario_t* question, const lcm_ssv_plan_t* plan,
                       double* mate_s) {
    lcm_ssv_pose_t X = question->X_IS;
    double t_s = 0, impulse_Ns = 0;
    int next_arc = 0;
    *mate_s = 0;
    for (int i = 0; i < plan->num_legs; i++) {
        const lcm_ssv_leg_t* leg = &plan->legs[i];
        char what[32];
        snprintf(what, sizeof what, "legs[%d]", i);
        if ((leg->phase != LCM_SSV_LEG_T_PHASE_TRANSIT && leg->phase != LCM_SSV_LEG_T_PHASE_TRANSFER) ||
            (i > 0 && leg->phase < plan->legs[i - 1].phase)) {
            return fail(check, "%s.phase: %d does not follow", what, leg->phase);
        }
        if (leg->kind < LCM_SSV_LEG_T_KIND_TRANSLATE || leg->kind > LCM_SSV_LEG_T_KIND_SCREW) {
            return fail(check, "%s.kind: %d is none", what, leg->kind);
        }
        const double* unit = leg->kind == LCM_SSV_LEG_T_KIND_TURN ? leg->w_S : leg->v_S;
        const bool sound = leg->duration_s > 0 && leg->length > 0 && isfinite(leg->length) && leg->peak_speed > 0 &&
                           fabs(sqrt(dot(unit, unit)) - 1) <= 1e-3 && dot(leg->v_S, leg->v_S) < 1e12 &&
                           dot(leg->w_S, leg->w_S) < 1e12;
        if (!sound) return fail(check, "%s: no motion along a twist", what);
        if (!is_near(check, leg->t_start_s, t_s, plan->quote.time_s)) {
            return fail(check, "%s.t_start_s: %.9g s, but the last one ends at %.9g s", what, leg->t_start_s, t_s);
        }
        if (!check_amount(check, what, leg->impulse_Ns) || !check_pose(check, what, &leg->X_IS_start) ||
            !check_pose(check, what, &leg->X_IS_end) || !check_same_pose(check, what, &leg->X_IS_start, &X)) {
            return false;
        }
        move_along(leg, leg->length, &X);
        if (!check_same_pose(check, what, &leg->X_IS_end, &X) || !check_arcs(check, plan, i, &next_arc)) return false;
        X = leg->X_IS_end;
        t_s += leg->duration_s;
        impulse_Ns += leg->impulse_Ns;
        if (leg->phase == LCM_SSV_LEG_T_PHASE_TRANSIT) *mate_s = t_s;
    }
    if (next_arc != plan->num_arcs) return fail(check, "num_arcs: %d, but the legs have %d", plan->num_arcs, next_arc);
    return check_sum(check, "time_s", plan->quote.time_s, t_s) &&
           check_sum(check, "impulse_Ns", plan->quote.impulse_Ns, impulse_Ns) &&
           check_same_pose(check, "X_IS_final", &plan->quote.X_IS_final, &X);
}

// Of a thrust that runs on a straight line.
static double impulse_of(double from_N, double to_N, double duration_s) {
    if ((from_N < 0) == (to_N < 0)) return 0.5 * fabs(from_N + to_N) * duration_s;
    return 0.5 * (from_N * from_N + to_N * to_N) / (fabs(from_N) + fabs(to_N)) * duration_s;
}

// The timeline stays within half a per cent of the limit of the exact thrust, so much may its impulse be off.
#define TIMELINE_TOLERANCE 0.005

static bool check_segments(const check_t* check, const lcm_ssv_scenario_t* question, const lcm_ssv_plan_t* plan) {
    const double limit_N = question->vehicle.force_max_N * (1 - question->thrust_reserve);
    double t_s = 0, impulse_Ns = 0;
    for (int i = 0; i < plan->num_segments; i++) {
        const lcm_ssv_segment_t* segment = &plan->segments[i];
        if (!(segment->duration_s > 0) || !is_near(check, segment->t_s, t_s, plan->quote.time_s)) {
            return fail(check, "segments[%d]: starts at %.9g s, but the last one ends at %.9g s", i, segment->t_s, t_s);
        }
        if (segment->leg < 0 || segment->leg >= plan->num_legs || (i > 0 && segment->leg < plan->segments[i - 1].leg)) {
            return fail(check, "segments[%d].leg: %d does not follow", i, segment->leg);
        }
        const lcm_ssv_leg_t* leg = &plan->legs[segment->leg];
        const double slack_s = 10 * (check->relative * plan->quote.time_s + check->absolute);
        if (!(segment->t_s >= leg->t_start_s - slack_s &&
              segment->t_s + segment->duration_s <= leg->t_start_s + leg->duration_s + slack_s)) {
            return fail(check, "segments[%d]: outside its leg", i);
        }
        for (int k = 0; k < NUM_THRUSTERS; k++) {
            const double most_N = fmax(fabs(segment->u_start_N[k]), fabs(segment->u_end_N[k]));
            const bool within = most_N <= limit_N * (1 + check->relative) + check->absolute &&
                                isfinite(segment->u_start_N[k]) && isfinite(segment->u_end_N[k]);
            if (!within) return fail(check, "segments[%d], thruster %d: beyond the limit of %.9g N", i, k, limit_N);
            impulse_Ns += impulse_of(segment->u_start_N[k], segment->u_end_N[k], segment->duration_s);
        }
        t_s = segment->t_s + segment->duration_s;
    }
    const double off_Ns = TIMELINE_TOLERANCE * NUM_THRUSTERS * limit_N * plan->quote.time_s + check->absolute;
    if (!(fabs(impulse_Ns - plan->quote.impulse_Ns) <= off_Ns)) {
        return fail(check, "segments: %.9g N s, but the price is of %.9g N s", impulse_Ns, plan->quote.impulse_Ns);
    }
    return check_sum(check, "segments", t_s, plan->quote.time_s);
}

static bool check_events(const check_t* check, const lcm_ssv_plan_t* plan, double mate_s) {
    if (plan->num_events != 2 || plan->events[0].kind != LCM_SSV_EVENT_T_KIND_MATE ||
        plan->events[1].kind != LCM_SSV_EVENT_T_KIND_DOCK) {
        return fail(check, "events: not one mate, then one dock");
    }
    return check_sum(check, "events[0].t_s", plan->events[0].t_s, mate_s) &&
           check_sum(check, "events[1].t_s", plan->events[1].t_s, plan->quote.time_s);
}

// ---- What it keeps clear of -----------------------------------------------------------------------------------------

// How far the two ends of a clearance may be apart.
#define BRACKET_M 0.005

static bool is_some_obstacle(const lcm_ssv_task_t* task, int obstacle) {
    if (obstacle == LCM_SSV_CLEARANCE_T_OBSTACLE_TANK) return task->scene.tank.kind != LCM_SSV_TANK_T_KIND_NONE;
    return obstacle == LCM_SSV_CLEARANCE_T_OBSTACLE_BEAM ||
           (obstacle >= 0 && obstacle < SSV_MAX_OBSTACLES && ((uint64_t)task->scenario.obstacles >> obstacle & 1) != 0);
}

// The clearance of the motion as it was received.
static bool measure_clearance(const check_t* check, const lcm_ssv_task_t* task, const lcm_ssv_plan_t* plan,
                              ssv_clearance_t* clearance) {
    ssv_scene_t scene;
    ssv_scenario_t scenario;
    ssv_problem_t problem;
    ssv_plan_t motion;
    ssv_fault_t fault;
    ssv_scene_from_wire(&scene, &task->scene);
    ssv_scenario_from_wire(&scenario, &task->scenario, &scene);
    if (ssv_problem_init(&problem, &scenario, &fault) != SSV_OK) return fail(check, "status: a plan for no question");
    ssv_plan_from_wire(&motion, plan);
    ssv_plan_clearance(&problem, &motion, &scene, scenario.obstacles, clearance);
    return true;
}

// How far positions of this plan may be off, by the rounding of its arithmetic and of ours.
static double slack_of(const check_t* check, const lcm_ssv_plan_t* plan) {
    double size_m = 10;
    for (int i = 0; i < plan->num_legs; i++) {
        for (int k = 0; k < 3; k++) size_m = fmax(size_m, 10 + fabs(plan->legs[i].X_IS_end.p_m[k]));
    }
    return 1e-4 + 10 * check->relative * size_m;
}

static bool check_clearance(const check_t* check, const lcm_ssv_task_t* task, const lcm_ssv_plan_t* plan) {
    const lcm_ssv_clearance_t* is = &plan->clearance;
    const double slack_m = slack_of(check, plan);
    ssv_clearance_t own = {.obstacle = SSV_OBSTACLE_NONE};
    if (!measure_clearance(check, task, plan, &own)) return false;
    if ((is->obstacle == LCM_SSV_CLEARANCE_T_OBSTACLE_NONE) != (own.obstacle == SSV_OBSTACLE_NONE)) {
        return fail(check, "clearance.obstacle: %d, but there is %s to keep clear of", is->obstacle,
                    own.obstacle == SSV_OBSTACLE_NONE ? "nothing" : "something");
    }
    if (is->obstacle == LCM_SSV_CLEARANCE_T_OBSTACLE_NONE) return true;
    if (!is_some_obstacle(task, is->obstacle)) {
        return fail(check, "clearance.obstacle: %d was not to be kept clear of", is->obstacle);
    }
    if (is->body != LCM_SSV_CLEARANCE_T_BODY_VEHICLE && is->body != LCM_SSV_CLEARANCE_T_BODY_BEAM) {
        return fail(check, "clearance.body: %d is none", is->body);
    }
    if (is->leg < 0 || is->leg >= plan->num_legs) return fail(check, "clearance.leg: %d is none", is->leg);
    if (!(is->s >= 0 && is->s <= plan->legs[is->leg].length * (1 + check->relative) + check->absolute)) {
        return fail(check, "clearance.s: %.9g is not on leg %d", is->s, is->leg);
    }
    if (!(is->certified_m <= is->seen_m && is->seen_m - is->certified_m <= BRACKET_M + slack_m)) {
        return fail(check, "clearance: %.9g m certified, %.9g m seen", is->certified_m, is->seen_m);
    }
    const double least_m = real_to_double(own.certified_m), most_m = real_to_double(own.seen_m);
    if (!(is->certified_m <= most_m + slack_m && is->seen_m >= least_m - slack_m)) {
        return fail(check, "clearance: %.9g to %.9g m, but the motion keeps %.9g to %.9g m", is->certified_m,
                    is->seen_m, least_m, most_m);
    }
    if (most_m < task->scenario.margin_m - slack_m) {
        return fail(check, "clearance: %.9g m, but %.9g m were asked for", most_m, task->scenario.margin_m);
    }
    return true;
}

// Nobody who has the plan alone can tell what its planner's arithmetic rounded.
static bool check_arrival(const check_t* check, const lcm_ssv_plan_t* plan) {
    const lcm_ssv_arrival_t* const is = &plan->arrival;
    const double miss[] = {is->rounding_m, is->rounding_rad, is->lines_m, is->lines_rad};
    for (size_t i = 0; i < sizeof miss / sizeof *miss; i++) {
        if (!(miss[i] >= 0) || !isfinite(miss[i])) return fail(check, "arrival: %.9g is no distance", miss[i]);
    }
    return true;
}

// Speed of the vehicle, of its turning, and of both ends of the beam, per unit of speed along a leg.
static double speed_of(const lcm_ssv_leg_t* leg, const double p_S[3]) {
    double v[3];
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        v[i] = leg->v_S[i] + leg->w_S[j] * p_S[k] - leg->w_S[k] * p_S[j];
    }
    return sqrt(dot(v, v));
}

static bool check_cap(const check_t* check, int leg, const char* cap, double most, double speed) {
    if (most == 0 || speed <= most * (1 + check->relative) + check->absolute) return true;
    return fail(check, "legs[%d].peak_speed: %.9g, but %s is %.9g", leg, speed, cap, most);
}

static bool check_caps(const check_t* check, const lcm_ssv_scenario_t* question, const lcm_ssv_plan_t* plan) {
    const double at_centre[3] = {0, 0, 0};
    for (int i = 0; i < plan->num_legs; i++) {
        const lcm_ssv_leg_t* leg = &plan->legs[i];
        const double speed_m_s = leg->peak_speed * speed_of(leg, at_centre);
        const double rate_rad_s = leg->peak_speed * sqrt(dot(leg->w_S, leg->w_S));
        if (leg->phase == LCM_SSV_LEG_T_PHASE_TRANSIT) {
            if (!check_cap(check, i, "transit_speed_max_m_s", question->transit_speed_max_m_s, speed_m_s) ||
                !check_cap(check, i, "transit_rate_max_rad_s", question->transit_rate_max_rad_s, rate_rad_s)) {
                return false;
            }
            continue;
        }
        double ends_m_s = 0;
        for (int end = -1; end <= 1; end += 2) {
            const double p_B[3] = {0, 0, 0.5 * end * question->beam.length_m};
            double p_S[3];
            turn(plan->X_SB.q, p_B, p_S);
            for (int k = 0; k < 3; k++) p_S[k] += plan->X_SB.p_m[k];
            ends_m_s = fmax(ends_m_s, leg->peak_speed * speed_of(leg, p_S));
        }
        if (!check_cap(check, i, "transfer_speed_max_m_s", question->transfer_speed_max_m_s, speed_m_s) ||
            !check_cap(check, i, "transfer_rate_max_rad_s", question->transfer_rate_max_rad_s, rate_rad_s) ||
            !check_cap(check, i, "transfer_beam_speed_max_m_s", question->transfer_beam_speed_max_m_s, ends_m_s)) {
            return false;
        }
    }
    return true;
}

bool ssv_check_plan(const lcm_ssv_task_t* task, const lcm_ssv_plan_t* plan, char reason[SSV_CHECK_REASON_SIZE]) {
    const lcm_ssv_scenario_t* question = &task->scenario;
    check_t check = {.reason = reason};
    lcm_ssv_pose_t X_IB;
    double mate_s;
    reason[0] = '\0';
    if (!check_head(&check, &question->asker, ssv_task_question_hash(task), &plan->answer) ||
        !check_quote(&check, question, &plan->quote)) {
        return false;
    }
    if (plan->quote.status != LCM_SSV_QUOTE_T_STATUS_OK) {
        if (plan->num_legs == 0 && plan->num_arcs == 0 && plan->num_segments == 0 && plan->num_events == 0) return true;
        return fail(&check, "status: a motion, but no plan");
    }
    if (!check_legs(&check, question, plan, &mate_s) || !check_segments(&check, question, plan) ||
        !check_events(&check, plan, mate_s) || !check_pose(&check, "X_SB", &plan->X_SB) ||
        !check_grasp(&check, question, &plan->quote.choice, &plan->X_SB)) {
        return false;
    }
    compose(&plan->quote.X_IS_final, &plan->X_SB, &X_IB);
    return check_same_pose(&check, "X_IB_final", &plan->quote.X_IB_final, &X_IB) &&
           check_caps(&check, question, plan) && check_clearance(&check, task, plan) && check_arrival(&check, plan);
}
