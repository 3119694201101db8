/// The minimiser of estimated prices: coordinate search with pattern moves (Hooke and Jeeves, Powell), here with a
/// parabola along each direction and, where asked for, steps of two numbers at once.
#ifndef SSV_MINIMIZE_H
#define SSV_MINIMIZE_H

#include "planner/search/budget.h"
#include "planner/search/decision.h"
#include "planner/search/seed.h"

/// Improves a decision whose price is *price: each free number in turn, then pairs of them if the stage says so, then
/// the way that the sweep went as a whole; so many sweeps, fewer where one has gained little. Steps shrink where
/// nothing moves.
void ssv_minimize(ssv_phase_context_t* context, const ssv_acceptance_t* acceptance, const ssv_stage_t* stage,
                  ssv_decision_t* decision, real_t* price);

/// The same for the first few seeds of a list, as many as the stage says, and puts these in order.
void ssv_minimize_seeds(ssv_phase_context_t* context, const ssv_acceptance_t* acceptance, const ssv_stage_t* stage,
                        ssv_seeds_t* seeds);

#endif
