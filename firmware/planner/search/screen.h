/// Screening: which transfers, with the transits to them, are worth a search, and what a candidate promises.
#ifndef SSV_SCREEN_H
#define SSV_SCREEN_H

#include "planner/motion/path.h"
#include "planner/motion/question.h"
#include "planner/search/budget.h"
#include "planner/search/capability.h"
#include "planner/search/decision.h"
#include "planner/search/seed.h"

/// What the search for a path remembers from one candidate to the next, in the caller's ssv_work_t.
typedef struct {
    ssv_capability_t capability;
    int num_screened; ///< what the last screening kept: the cheapest seed, and those that are alike
    ssv_seed_t screened[SSV_SCREENED_SEEDS];
    ssv_seed_t seed[SSV_MAX_SEEDS]; ///< of the candidate that is being looked at
} ssv_memory_t;

/// A search for the path of a question.
typedef struct {
    const ssv_question_t* question;
    ssv_memory_t* memory;
    ssv_path_t* best; ///< the cheapest path so far
    int* num_priced;  ///< grows by what is tried
} ssv_search_t;

/// What the flights of a candidate cost at the cheapest, without any turn: an estimate from below, not a bound.
real_t ssv_screen_flights(const ssv_search_t* search, int contact, real_t height_m);

/// Seeds and prices transfers, with transits for those that are alike, and keeps the cheapest if they promise less than
/// *to_beat, or if that is NULL. @return about what ssv_optimal_search would find.
real_t ssv_screen(const ssv_search_t* search, int contact, real_t height_m, const real_t* to_beat);

/// Seeds of a transfer, as many of each attitude mode as are to be drawn, priced by estimates.
ssv_seeds_t ssv_screen_transfers(ssv_phase_context_t* context, ssv_memory_t* memory, const ssv_draw_t* draw);

/// The cheapest transit to where the motion of a transfer begins: of so many seeds, refined as the budget says; with
/// NULL they are priced and no more. *transit is written unless it is NULL. @return its estimated price.
real_t ssv_screen_transit(ssv_phase_context_t* context, const ssv_capability_t* capability, int num_seeds,
                          const ssv_budget_t* budget, const ssv_decision_t* transfer, ssv_decision_t* transit);

/// Adds the price of the transit to a transfer, with the vehicle whichever way up that is cheaper.
void ssv_screen_both_ways_up(ssv_phase_context_t* context, const ssv_capability_t* capability, ssv_seed_t* transfer);

#endif
