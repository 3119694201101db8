// What time and impulse can be traded for: the quotes of a ladder of weights (DESIGN.md 6).
#include "planner/motion/question.h"
#include "planner/search/budget.h"
#include "planner/search/select.h"
#include "ssv/planner.h"

// Rungs of the ladder of weights: the price of a second, and that of a second of one thruster at its limit. The last
// rung, which is not listed, is the scenario itself.
static const real_t rungs[SSV_NUM_RUNGS - 1][2] = {{REAL(1), REAL(0)},   {REAL(1), REAL(0.02)}, {REAL(1), REAL(0.1)},
                                                   {REAL(1), REAL(0.5)}, {REAL(1), REAL(2)},    {REAL(1), REAL(10)},
                                                   {REAL(1), REAL(100)}, {REAL(0), REAL(1)}};

// Adds the point if none is at least as good in both, and drops those that it makes needless. Room is kept for spare
// more.
static void front_add(ssv_front_t* front, const ssv_candidate_t* point, int spare) {
    int kept = 0;
    for (int k = 0; k < front->num_points; k++) {
        const ssv_candidate_t* old = &front->point[k];
        if (old->time_s <= point->time_s && old->impulse_Ns <= point->impulse_Ns) return;
    }
    for (int k = 0; k < front->num_points; k++) {
        const ssv_candidate_t old = front->point[k];
        if (old.time_s < point->time_s || old.impulse_Ns < point->impulse_Ns) front->point[kept++] = old;
    }
    front->num_points = kept;
    if (kept + spare >= SSV_MAX_FRONT) return;
    int k = front->num_points++;
    for (; k > 0 && front->point[k - 1].time_s > point->time_s; k--) front->point[k] = front->point[k - 1];
    front->point[k] = *point;
}

// A front under way.
typedef struct {
    ssv_question_t own; // the scenario's
    int rung;
    bool overflowed;
    ssv_quote_t quote; // of the rung
    ssv_choice_t choice;
} climb_t;

_Static_assert(sizeof(climb_t) <= sizeof(ssv_work_t), "a front under way fits the memory to work in");
_Static_assert(_Alignof(climb_t) <= _Alignof(ssv_work_t), "and may stand there");

static void begin_rung(climb_t* climb) {
    // The scenario's own price is to be among the points, so that rung is asked as it was asked.
    ssv_question_t question = climb->own;
    if (climb->rung < SSV_NUM_RUNGS - 1) {
        const uint32_t overflows = real_overflows();
        question.list_candidates = true;
        question.weight_time_per_s = rungs[climb->rung][0];
        question.weight_impulse_per_Ns =
            real_div(rungs[climb->rung][1], question.problem->scenario.vehicle.force_max_N);
        if (real_overflows() != overflows) climb->overflowed = true;
    }
    ssv_choice_begin(&question, &climb->choice, &climb->quote);
}

// Takes over what the rung found.
static void end_rung(climb_t* climb, ssv_front_t* front) {
    const ssv_quote_t* quote = &climb->quote;
    const int spare = SSV_NUM_RUNGS - 1 - climb->rung;
    if (quote->status == SSV_NUMERIC_OVERFLOW) climb->overflowed = true;
    if (quote->status != SSV_OK) return;
    front->status = SSV_OK;
    front_add(front, &quote->choice, spare);
    for (int k = 0; k < quote->num_candidates; k++) {
        if (quote->candidate[k].outcome == SSV_FEASIBLE) front_add(front, &quote->candidate[k], spare);
    }
}

static void finish(climb_t* climb, ssv_front_t* front) {
    const uint32_t overflows = real_overflows();
    for (int k = 0; k < front->num_points; k++) {
        ssv_candidate_t* point = &front->point[k];
        point->cost = real_mul(climb->own.weight_time_per_s, point->time_s) +
                      real_mul(climb->own.weight_impulse_per_Ns, point->impulse_Ns);
    }
    if (!climb->overflowed && real_overflows() == overflows) return;
    const uint64_t scenario_hash = front->scenario_hash;
    memset(front, 0, sizeof *front);
    front->status = SSV_NUMERIC_OVERFLOW;
    front->scenario_hash = scenario_hash;
}

void ssv_front_begin(const ssv_problem_t* problem, ssv_work_t* work, ssv_front_t* front) {
    climb_t* climb = (climb_t*)work;
    memset(front, 0, sizeof *front);
    front->status = SSV_INFEASIBLE;
    front->scenario_hash = problem->scenario_hash;
    climb->own = ssv_question_of(problem);
    climb->rung = 0;
    climb->overflowed = false;
    begin_rung(climb);
}

bool ssv_front_step(ssv_work_t* work, ssv_front_t* front) {
    climb_t* climb = (climb_t*)work;
    if (climb->rung == SSV_NUM_RUNGS) return true;
    if (!ssv_choice_quote_step(&climb->choice, &climb->quote)) return false;
    end_rung(climb, front);
    climb->rung++;
    if (climb->rung < SSV_NUM_RUNGS) {
        begin_rung(climb);
        return false;
    }
    finish(climb, front);
    return true;
}

ssv_status_t ssv_front(const ssv_problem_t* problem, ssv_work_t* work, ssv_front_t* front) {
    ssv_front_begin(problem, work, front);
    while (!ssv_front_step(work, front)) {}
    return front->status;
}
