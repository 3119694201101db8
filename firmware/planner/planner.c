// The answer to a question: the path that is chosen, written as legs, events and the thruster timeline.
#include "ssv/planner.h"

#include "planner/math/assert.h"
#include "planner/model/body.h"
#include "planner/motion/maneuver.h"
#include "planner/motion/path.h"
#include "planner/motion/question.h"
#include "planner/profile/limits.h"
#include "planner/profile/profile.h"
#include "planner/search/select.h"
#include "planner/segments.h"
#include "ssv/vec3.h"

// Solves the maneuver once more and writes its leg and arcs.
static ssv_outcome_t add_leg(const ssv_question_t* question, const ssv_assembly_t* assembly,
                             const ssv_maneuver_t* maneuver, pose_t X_IS, ssv_plan_t* plan) {
    ssv_thrusts_t thrusts;
    ssv_profile_t profile;
    ssv_ramp_t ramp;
    ssv_maneuver_thrusts(question->problem, assembly, maneuver->twist, &thrusts);
    const ssv_price_t price = ssv_maneuver_solve(question, maneuver, &thrusts, &profile, &ramp);
    if (price.outcome != SSV_FEASIBLE) return price.outcome;
    if (plan->num_arcs + profile.num_arcs > SSV_MAX_ARCS) return SSV_TOO_MANY_ARCS;
    SSV_ASSERT(plan->num_legs < SSV_MAX_LEGS);
    plan->leg[plan->num_legs++] = (ssv_leg_t){.phase = maneuver->phase,
                                              .kind = maneuver->kind,
                                              .ramp = ramp,
                                              .t_start_s = plan->quote.time_s,
                                              .duration_s = price.time_s,
                                              .impulse_Ns = price.impulse_Ns,
                                              .length = maneuver->length,
                                              .peak_speed = profile.peak_speed,
                                              .v_S = maneuver->twist.v,
                                              .w_S = maneuver->twist.w,
                                              .X_IS_start = X_IS,
                                              .X_IS_end = ssv_maneuver_pose(X_IS, maneuver->twist, maneuver->length),
                                              .first_arc = plan->num_arcs,
                                              .num_arcs = profile.num_arcs};
    for (int k = 0; k < profile.num_arcs; k++) plan->arc[plan->num_arcs++] = profile.arc[k];
    plan->quote.time_s += price.time_s;
    plan->quote.impulse_Ns += price.impulse_Ns;
    plan->quote.cost += price.cost;
    return SSV_FEASIBLE;
}

static void add_event(ssv_plan_t* plan, ssv_event_kind_t kind) {
    SSV_ASSERT(plan->num_events < SSV_MAX_EVENTS);
    plan->event[plan->num_events++] = (ssv_event_t){plan->quote.time_s, kind};
}

static ssv_assembly_t assembly_in(const ssv_problem_t* problem, ssv_phase_t phase, pose_t X_SB) {
    const ssv_scenario_t* scenario = &problem->scenario;
    return (ssv_assembly_t){&scenario->vehicle, phase == SSV_TRANSFER ? &scenario->beam : NULL, X_SB};
}

// Writes the motion of a path: legs, arcs, events, final poses.
static ssv_outcome_t write_motion(const ssv_question_t* question, const ssv_path_t* path, ssv_plan_t* plan) {
    pose_t X_IS = question->problem->scenario.X_IS;
    plan->quote.time_s = plan->quote.impulse_Ns = plan->quote.cost = REAL(0);
    plan->num_legs = plan->num_arcs = plan->num_events = 0;
    for (int k = 0; k < path->num_maneuvers; k++) {
        const ssv_maneuver_t* maneuver = &path->maneuver[k];
        if (maneuver->phase == SSV_TRANSFER && plan->num_events == 0) add_event(plan, SSV_MATE);
        if (!(maneuver->length > REAL(0))) continue;
        const ssv_assembly_t assembly = assembly_in(question->problem, maneuver->phase, path->X_SB);
        const ssv_outcome_t outcome = add_leg(question, &assembly, maneuver, X_IS, plan);
        if (outcome != SSV_FEASIBLE) return outcome;
        X_IS = plan->leg[plan->num_legs - 1].X_IS_end;
    }
    add_event(plan, SSV_DOCK);
    plan->X_SB = path->X_SB;
    return SSV_FEASIBLE;
}

static ssv_thrusts_t thrusts_along(const ssv_problem_t* problem, const ssv_plan_t* plan, const ssv_leg_t* leg) {
    const ssv_assembly_t assembly = assembly_in(problem, leg->phase, plan->X_SB);
    ssv_thrusts_t thrusts;
    ssv_maneuver_thrusts(problem, &assembly, (ssv_twist_t){leg->v_S, leg->w_S}, &thrusts);
    return thrusts;
}

// About how many segments there will be.
static int count_segments(const ssv_problem_t* problem, const ssv_plan_t* plan, real_t drift_max_s2) {
    int num = 0;
    for (const ssv_leg_t* leg = plan->leg; leg < plan->leg + plan->num_legs; leg++) {
        const ssv_thrusts_t thrusts = thrusts_along(problem, plan, leg);
        for (int k = 0; k < leg->num_arcs; k++) {
            num += ssv_timeline_count(&thrusts, &plan->arc[leg->first_arc + k], drift_max_s2);
        }
    }
    return num;
}

static ssv_outcome_t write_timeline(const ssv_problem_t* problem, real_t drift_max_s2, ssv_plan_t* plan) {
    plan->num_segments = 0;
    for (int index = 0; index < plan->num_legs; index++) {
        const ssv_leg_t* leg = &plan->leg[index];
        const ssv_thrusts_t thrusts = thrusts_along(problem, plan, leg);
        for (int k = 0; k < leg->num_arcs; k++) {
            const ssv_arc_t* arc = &plan->arc[leg->first_arc + k];
            const real_t t_s = leg->t_start_s + arc->t_s;
            const ssv_outcome_t outcome = ssv_timeline_append(&thrusts, arc, t_s, index, drift_max_s2, plan);
            if (outcome != SSV_FEASIBLE) return outcome;
        }
    }
    return SSV_FEASIBLE;
}

// How closely the timeline is cut [s2]: as finely as the plan's memory allows. How many segments it takes grows with
// the fourth root of the inverse, where the bound on drift is what counts: a count or two show where that ends, from
// these on.
#define DRIFT_S2 REAL(1.6e-5)
#define DRIFT_LEAST_S2 REAL(1e-6)
#define MAX_COUNTS 3
#define MOST_COARSER REAL(256)
#define MAX_COARSER 8
#define SEGMENTS_WANTED (SSV_MAX_SEGMENTS - SSV_MAX_SEGMENTS / 10)

SSV_OWN_FRAME static ssv_outcome_t write_plan(const ssv_question_t* question, const ssv_path_t* path,
                                              ssv_plan_t* plan) {
    ssv_outcome_t outcome = write_motion(question, path, plan);
    if (outcome != SSV_FEASIBLE) return outcome;
    real_t drift_s2 = DRIFT_S2;
    for (int n = 0, num = SSV_MAX_SEGMENTS; n < MAX_COUNTS && num > SEGMENTS_WANTED; n++) {
        num = count_segments(question->problem, plan, drift_s2);
        const real_t fraction = real_sq(real_sq(real_div(real_from_int(num), real_from_int(SEGMENTS_WANTED))));
        drift_s2 = real_max(DRIFT_LEAST_S2, real_mul(drift_s2, real_min(MOST_COARSER, fraction)));
    }
    outcome = write_timeline(question->problem, drift_s2, plan);
    for (int n = 0; n < MAX_COARSER && outcome == SSV_TOO_MANY_SEGMENTS; n++) {
        drift_s2 = real_mul(REAL(2), drift_s2);
        outcome = write_timeline(question->problem, drift_s2, plan);
    }
    return outcome;
}

// A plan under way.
typedef struct {
    enum { CHOOSES, WRITES, CHOOSES_BY_PAPER, WRITES_BY_PAPER, IS_WRITTEN } stage;
    ssv_question_t own; // the scenario's
    ssv_choice_t choice;
} planning_t;

_Static_assert(sizeof(planning_t) <= sizeof(ssv_work_t), "a plan under way fits the memory to work in");
_Static_assert(_Alignof(planning_t) <= _Alignof(ssv_work_t), "and may stand there");

// Ends the answer, with the path of the choice or without any.
static void finish(planning_t* planning, bool found, ssv_plan_t* plan) {
    const uint32_t overflows = real_overflows();
    const ssv_choice_t* choice = &planning->choice;
    planning->stage = IS_WRITTEN;
    if (found) {
        const ssv_problem_t* problem = planning->own.problem;
        ssv_quote_finish_price(&planning->own, &choice->best, &plan->quote);
        ssv_plan_clearance(problem, plan, problem->scenario.scene, problem->scenario.obstacles, &plan->clearance);
    }
    const bool overflowed = choice->overflowed || real_overflows() != overflows;
    if (ssv_quote_finish_status(&planning->own, overflowed, &plan->quote) == SSV_OK) {
        plan->plan_hash = ssv_plan_hash(plan);
    } else {
        memset((char*)plan + sizeof plan->quote, 0, sizeof *plan - sizeof plan->quote);
    }
}

// What is chosen may fail to fit the plan's memory. Then the paper's method is next, candidate by candidate, until one
// fits.
static void write(planning_t* planning, ssv_plan_t* plan) {
    ssv_choice_t* choice = &planning->choice;
    const uint32_t overflows = real_overflows();
    const ssv_outcome_t outcome = write_plan(&choice->question, &choice->best, plan);
    if (real_overflows() != overflows) choice->overflowed = true;
    if (outcome == SSV_FEASIBLE) {
        finish(planning, true, plan);
    } else if (planning->stage == WRITES) {
        const bool overflowed = choice->overflowed;
        ssv_question_t by_paper = planning->own;
        by_paper.method = SSV_METHOD_PAPER;
        ssv_choice_begin(&by_paper, choice, &plan->quote);
        choice->overflowed = choice->overflowed || overflowed;
        planning->stage = CHOOSES_BY_PAPER;
    } else if (!ssv_choice_next(choice, outcome, &plan->quote)) {
        finish(planning, false, plan);
    }
}

void ssv_plan_begin(const ssv_problem_t* problem, ssv_work_t* work, ssv_plan_t* plan) {
    planning_t* planning = (planning_t*)work;
    memset(plan, 0, sizeof *plan);
    planning->own = ssv_question_of(problem);
    planning->stage = CHOOSES;
    ssv_choice_begin(&planning->own, &planning->choice, &plan->quote);
}

bool ssv_plan_step(ssv_work_t* work, ssv_plan_t* plan) {
    planning_t* planning = (planning_t*)work;
    switch (planning->stage) {
        case CHOOSES:
        case CHOOSES_BY_PAPER:
            if (!ssv_choice_step(&planning->choice, &plan->quote)) break;
            if (planning->choice.best.price.outcome != SSV_FEASIBLE) {
                finish(planning, false, plan);
            } else {
                planning->stage = planning->stage == CHOOSES ? WRITES : WRITES_BY_PAPER;
            }
            break;
        case WRITES:
        case WRITES_BY_PAPER: write(planning, plan); break;
        case IS_WRITTEN: break;
    }
    return planning->stage == IS_WRITTEN;
}

ssv_status_t ssv_plan(const ssv_problem_t* problem, ssv_work_t* work, ssv_plan_t* plan) {
    ssv_plan_begin(problem, work, plan);
    while (!ssv_plan_step(work, plan)) {}
    return plan->quote.status;
}
