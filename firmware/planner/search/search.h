/// The choice by J: the cheapest chain of moves that does the task with one contact and attach height.
#ifndef SSV_SEARCH_H
#define SSV_SEARCH_H

#include "planner/search/seed.h"

/// The paper's chain: nearest ring angle (or the cheapest of several where none is nearest); translate, then turn the
/// shortest way; turn about C, then translate. Ring angles that a bound, or an estimate with a margin, rules out
/// against a feasible price *to_beat are left out; NULL leaves out none. *to_beam is the transit that was priced last,
/// at first one without moves: from one candidate to the next the turn is often the same. *num_priced grows by the
/// chains that were priced. @return false if all were left out; then *best is not meaningful.
bool ssv_search_paper(const ssv_question_t* question, int contact, real_t height_m, const ssv_price_t* to_beat,
                      ssv_phase_path_t* to_beam, ssv_path_t* best, int* num_priced);

/// What a look at a candidate finds: the cheapest start, and those that are alike.
#define SSV_LOOK_STARTS 4
typedef struct {
    int num; ///< at least 1
    ssv_seed_t start[SSV_LOOK_STARTS];
} ssv_look_t;

/// What the search for a candidate remembers, in the problem's memory for it.
#define SSV_MAX_STARTS 9
typedef struct {
    ssv_capability_t capability;
    ssv_look_t look; ///< of the last look that kept what it found
    ssv_seed_t start[SSV_MAX_STARTS];
} ssv_search_t;

/// What the flights of a candidate cost at the cheapest, without any turn: an estimate from below, not a bound.
real_t ssv_optimal_flights(const ssv_question_t* question, const ssv_capability_t* capability, int contact,
                           real_t height_m);

/// Draws and prices starts, and keeps the cheapest as the look if they promise less than *to_beat, or if that is NULL.
/// @return about what ssv_search_optimal would find.
real_t ssv_optimal_look(const ssv_question_t* question, ssv_search_t* search, int contact, real_t height_m,
                        const real_t* to_beat, int* num_priced);

/// Turn, fly, turn in both phases, with travel attitudes, pivots, ring angle and both free rolls by J (DESIGN.md 6).
/// The search goes by estimates, the price is exact; effort quick goes on from the look, which must be at this
/// candidate. *best is replaced if what is found costs less. @return what was found.
ssv_candidate_t ssv_search_optimal(const ssv_question_t* question, ssv_search_t* search, int contact, real_t height_m,
                                   ssv_effort_t effort, ssv_path_t* best, int* num_priced);

#endif
