/// What is asked about a problem: the wishes of its scenario, or others in their place.
#ifndef SSV_QUESTION_H
#define SSV_QUESTION_H

#include "ssv/planner.h"

/// One question. The problem stays as it is: a front asks about the same problem with other weights, and a plan that
/// does not fit its memory is asked for once more by the paper's method.
typedef struct {
    const ssv_problem_t* problem;
    ssv_method_t method; ///< of the path and of the profiles along it
    real_t weight_time_per_s, weight_impulse_per_Ns;
    real_t approach_mate_m, approach_dock_m; ///< of method optimal
    bool list_candidates;                    ///< whether the answer lists every candidate, which then are all searched
} ssv_question_t;

/// The question as the scenario asks it.
static inline ssv_question_t ssv_question_of(const ssv_problem_t* problem) {
    const ssv_scenario_t* s = &problem->scenario;
    return (ssv_question_t){problem,
                            s->method,
                            s->weight_time_per_s,
                            s->weight_impulse_per_Ns,
                            s->approach_mate_m,
                            s->approach_dock_m,
                            s->want_candidates};
}

#endif
