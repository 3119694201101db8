// What time and impulse can be traded for: the quotes of a ladder of weights (DESIGN.md 6).
#include "planner/motion/question.h"
#include "planner/search/budget.h"
#include "planner/search/select.h"
#include "ssv/planner.h"

// Rungs of the ladder of weights: the price of a second, and that of a second of one thruster at its limit. Before them
// comes one that is not listed, the scenario itself.
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
    int rung;           // 0 is its own
    bool priced;        // whether that has a price,
    real_t cost;        // and which
    bool overflowed;
    ssv_quote_t quote; // of the rung
    ssv_choice_t choice;
} climb_t;

_Static_assert(sizeof(climb_t) <= sizeof(ssv_work_t), "a front under way fits the memory to work in");
_Static_assert(_Alignof(climb_t) <= _Alignof(ssv_work_t), "and may stand there");

static void begin_rung(climb_t* climb) {
    // The scenario's own price is to be among the points, so that rung is asked as it was asked.
    ssv_question_t question = climb->own;
    if (climb->rung > 0) {
        const uint32_t overflows = real_overflows();
        const real_t* rung = rungs[climb->rung - 1];
        question.list_candidates = true;
        question.weight_time_per_s = rung[0];
        question.weight_impulse_per_Ns = real_div(rung[1], question.problem->scenario.vehicle.force_max_N);
        if (real_overflows() != overflows) climb->overflowed = true;
    }
    ssv_choice_begin(&question, &climb->choice, &climb->quote);
}

// Enters a point with its price by the scenario's weights. What another rung came upon by chance, and the plan for
// these weights does not find, is no point: whoever took it for them would be promised less than the plan costs.
static void consider(const climb_t* climb, const ssv_candidate_t* found, int spare, ssv_front_t* front) {
    ssv_candidate_t point = *found;
    if (climb->rung > 0) {
        point.cost = real_mul(climb->own.weight_time_per_s, point.time_s) +
                     real_mul(climb->own.weight_impulse_per_Ns, point.impulse_Ns);
        if (climb->priced && point.cost < climb->cost) return;
    }
    front_add(front, &point, spare);
}

// Takes over what the rung found.
static void end_rung(climb_t* climb, ssv_front_t* front) {
    const ssv_quote_t* quote = &climb->quote;
    const int spare = SSV_NUM_RUNGS - 1 - climb->rung;
    const uint32_t overflows = real_overflows();
    if (quote->status == SSV_NUMERIC_OVERFLOW) climb->overflowed = true;
    if (quote->status != SSV_OK) return;
    front->status = SSV_OK;
    if (climb->rung == 0) {
        climb->priced = true;
        climb->cost = quote->cost;
    }
    consider(climb, &quote->choice, spare, front);
    for (int k = 0; k < quote->num_candidates; k++) {
        if (quote->candidate[k].outcome == SSV_FEASIBLE) consider(climb, &quote->candidate[k], spare, front);
    }
    if (real_overflows() != overflows) climb->overflowed = true;
}

static void finish(const climb_t* climb, ssv_front_t* front) {
    if (!climb->overflowed) return;
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
    climb->priced = climb->overflowed = false;
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
