/// Prices in process, on all cores, each asked for once. A price is that of the plan that is flown: the scenario of a
/// question starts at the very pose that the price before ended with, rounded.
#ifndef SSV_SCHEDULER_PRICING_H
#define SSV_SCHEDULER_PRICING_H

#include "assembly.h"
#include "ssv/planner.h"

/// Steps that a pose is rounded to, per metre and per unit of its quaternion, of which the first number that is not
/// zero is made positive. So plans that end the same but for rounding start the next ones the same.
#define PRICING_STEPS 1048576

typedef struct pricing pricing_t;

/// How often the planner was asked, and how often it was known already.
typedef struct {
    uint64_t asked, known;
    int poses, threads;
} pricing_counts_t;

/// @param threads  0 = one for each core. @return NULL if there is no memory or no thread to be had.
pricing_t* pricing_open(const structure_t* structure, int threads);

/// Answers questions, those that are new side by side. Poses that are new get the next numbers in the order of the
/// questions, however many threads there are. The context of assembly_prices_t is the pricing.
bool pricing_ask(void* pricing, const assembly_question_t* questions, int count, assembly_price_t* prices);

/// The planner's scenario of a question. It refers to the pricing's scene.
ssv_scenario_t pricing_scenario(const pricing_t* pricing, const assembly_question_t* question);

pricing_counts_t pricing_counts(const pricing_t* pricing);

void pricing_close(pricing_t* pricing);

#endif
