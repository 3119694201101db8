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

ssv_status_t ssv_front(const ssv_problem_t* problem, ssv_work_t* work, ssv_front_t* front) {
    const ssv_question_t own = ssv_question_of(problem);
    const uint32_t overflows = real_overflows();
    ssv_quote_t quote;
    memset(front, 0, sizeof *front);
    front->status = SSV_INFEASIBLE;
    front->scenario_hash = problem->scenario_hash;
    for (int n = 0; n < SSV_NUM_RUNGS; n++) {
        // The scenario's own price is to be among the points, so that rung is asked as it was asked.
        ssv_question_t question = own;
        if (n < SSV_NUM_RUNGS - 1) {
            question.list_candidates = true;
            question.weight_time_per_s = rungs[n][0];
            question.weight_impulse_per_Ns = real_div(rungs[n][1], problem->scenario.vehicle.force_max_N);
        }
        if (ssv_quote_of(&question, work, &quote) != SSV_OK) continue;
        front->status = SSV_OK;
        front_add(front, &quote.choice, SSV_NUM_RUNGS - 1 - n);
        for (int k = 0; k < quote.num_candidates; k++) {
            if (quote.candidate[k].outcome == SSV_FEASIBLE)
                front_add(front, &quote.candidate[k], SSV_NUM_RUNGS - 1 - n);
        }
    }
    for (int k = 0; k < front->num_points; k++) {
        ssv_candidate_t* point = &front->point[k];
        point->cost =
            real_mul(own.weight_time_per_s, point->time_s) + real_mul(own.weight_impulse_per_Ns, point->impulse_Ns);
    }
    if (real_overflows() != overflows) {
        memset(front, 0, sizeof *front);
        front->status = SSV_NUMERIC_OVERFLOW;
        front->scenario_hash = problem->scenario_hash;
    }
    return front->status;
}
