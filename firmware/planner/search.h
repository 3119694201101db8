/// The choice by J: the cheapest chain of moves that does the task with one contact and attach height.
#ifndef SSV_SEARCH_H
#define SSV_SEARCH_H

#include "planner/chain.h"

/// The paper's chain: nearest ring angle (or the cheapest of several where none is nearest); translate, then turn the shortest
/// way; turn about C, then translate. Ring angles and turning axes whose straight flights alone cost give_up or more are left
/// out. *num_priced grows by the chains that were priced. @return false if all were left out; then *best is not meaningful.
bool ssv_search_paper(const ssv_problem_t* problem, int contact, real_t height_m, real_t give_up, ssv_chain_t* best,
                      int* num_priced);

/// Turn, fly, turn in both phases, with travel attitudes, pivots, ring angle and both free rolls by J (DESIGN.md 6). Not
/// thorough: only the starts of that search.
void ssv_search_optimal(const ssv_problem_t* problem, int contact, real_t height_m, ssv_effort_t effort, bool thorough,
                        ssv_chain_t* best, int* num_priced);

#endif
