/// Prices in process, on all cores, or of whoever else answers for the planner; each asked for once. A price is that of
/// the plan that is flown: the scenario of a question starts at the very pose that the price before ended with,
/// rounded.
#ifndef SSV_SCHEDULER_PRICING_H
#define SSV_SCHEDULER_PRICING_H

#include "assembly.h"
#include "cache.h"
#include "lcm_ssv_quote_t.h"
#include "lcm_ssv_task_t.h"

/// Steps that a pose is rounded to, per metre and per unit of its quaternion, of which the first number that is not
/// zero is made positive. So plans that end the same but for rounding start the next ones the same.
#define PRICING_STEPS 1048576

typedef struct pricing pricing_t;

/// How often the planner was asked, and how often it was known already.
typedef struct {
    uint64_t asked, known;
    uint64_t kept;      ///< prices that the cache had
    int poses, threads; ///< no thread: prices come from elsewhere
} pricing_counts_t;

/// @param threads  0 = one for each core. @return NULL if there is no memory or no thread to be had.
pricing_t* pricing_open(const structure_t* structure, int threads);

/// Prices from elsewhere: `ask` has so many tasks priced together and writes a quote_t for each, which is freed with
/// wire_clear. @return as of pricing_open.
pricing_t* pricing_open_elsewhere(const structure_t* structure,
                                  bool (*ask)(void* context, const lcm_ssv_task_t* tasks, int count,
                                              lcm_ssv_quote_t* quotes),
                                  void* context);

/// Has prices taken from the cache, and those that are new added to it. Some of what it has is priced anew: where that
/// is something else, there are no more prices to be had, and `pricing_is_cache_wrong` says so.
void pricing_use(pricing_t* pricing, cache_t* cache);
bool pricing_is_cache_wrong(const pricing_t* pricing);

/// Answers questions, those that are new side by side. Poses that are new get the next numbers in the order of the
/// questions, however many threads there are. The context of assembly_prices_t is the pricing.
bool pricing_ask(void* pricing, const assembly_question_t* questions, int count, assembly_price_t* prices);

/// Whether the planner takes the structure's numbers, as far as they are the same for every part. @return false with
/// what is wrong in `error`.
bool pricing_check(const pricing_t* pricing, char* error, size_t error_size);

/// A question as the planner is asked it, and what may stand around in all of them.
lcm_ssv_scenario_t pricing_scenario(const pricing_t* pricing, const assembly_question_t* question);
const lcm_ssv_scene_t* pricing_scene(const pricing_t* pricing);

pricing_counts_t pricing_counts(const pricing_t* pricing);

void pricing_close(pricing_t* pricing);

#endif
