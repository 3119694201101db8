/// The choice by J: the cheapest chain of moves that does the task with one contact and attach height.
#ifndef SSV_SEARCH_H
#define SSV_SEARCH_H

#include "planner/chain.h"

/// The paper's chain: nearest ring angle (or the cheapest of several where none is nearest); translate, then turn the shortest
/// way; turn about C, then translate. *num_priced grows by the chains that were priced.
void ssv_search_paper(const ssv_problem_t* problem, int contact, real_t height_m, ssv_chain_t* best, int* num_priced);

/// Turn, translate, turn in both phases, with travel attitudes, pivots, ring angle and both free rolls by J (DESIGN.md 12);
/// never dearer than the paper's chain.
void ssv_search_optimal(const ssv_problem_t* problem, int contact, real_t height_m, ssv_chain_t* best, int* num_priced);

#endif
