/// The choice by J: the cheapest chain of moves that does the task with one contact and attach height.
#ifndef SSV_SEARCH_H
#define SSV_SEARCH_H

#include "planner/chain.h"

/// The paper's chain: nearest ring angle (or the cheapest of several where none is nearest); translate, then turn the shortest
/// way; turn about C, then translate. Ring angles and turning axes whose straight flights alone cost give_up or more are left
/// out. *num_priced grows by the chains that were priced. @return false if all were left out; then *best is not meaningful.
bool ssv_search_paper(const ssv_problem_t* problem, int contact, real_t height_m, real_t give_up, ssv_chain_t* best,
                      int* num_priced);

/// Axes, edges and diagonals of the body.
#define SSV_NUM_DIRECTIONS 26

/// The directions of the body that are cheap to fly along, and the price of a metre along each. If thrusters serve the vehicle
/// rolled half a turn about x as well, the first num_upright stand for all.
typedef struct {
    int num, num_upright;
    real_t least;
    vec3_t n[SSV_NUM_DIRECTIONS];
    real_t price[SSV_NUM_DIRECTIONS];
} ssv_directions_t;

void ssv_cheap_directions(const ssv_problem_t* problem, ssv_directions_t* directions);

/// What the flights of a candidate cost at the cheapest, without any turn: an estimate from below, not a bound.
real_t ssv_optimal_flights(const ssv_problem_t* problem, const ssv_directions_t* directions, int contact, real_t height_m);

/// About what ssv_search_optimal would find, from its starts alone.
real_t ssv_optimal_look(const ssv_problem_t* problem, const ssv_directions_t* directions, int contact, real_t height_m,
                        int* num_priced);

/// Turn, fly, turn in both phases, with travel attitudes, pivots, ring angle and both free rolls by J (DESIGN.md 6). The price
/// is exact, the search goes by estimates.
void ssv_search_optimal(const ssv_problem_t* problem, const ssv_directions_t* directions, int contact, real_t height_m,
                        ssv_effort_t effort, ssv_chain_t* best, int* num_priced);

#endif
