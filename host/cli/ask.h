/// Asks running planners over LCM: a plan of one of them, or prices of all that are there.
///
/// The bus is open to strangers. What comes is looked at as bytes first (wire_is_message), then whether it is for us,
/// then whether it can be the answer to what was asked (ssv/check.h). What fails is refused with a line on standard
/// error, a few at most and then a count, and the right answer is still awaited.
#ifndef SSV_ASK_H
#define SSV_ASK_H

#include <stdbool.h>
#include <stddef.h>

#include "lcm_ssv_plan_t.h"
#include "lcm_ssv_quote_t.h"
#include "lcm_ssv_scenario_t.h"

/// Whom to ask, and for how long.
typedef struct {
    const char* url;    ///< LCM provider; NULL for LCM's default (LCM_DEFAULT_URL, else UDP multicast)
    const char* scalar; ///< arithmetic that the planner must compute in, "double", "float" or "fixed"; NULL for any
    double timeout_s;   ///< how long to wait for an answer; with many batches, from one answer to the next
} ask_target_t;

/// A new question of this process: its own random asker_id, an unpredictable request_id, and the time on the clock.
/// @return false with a sentence in `error` if the system gives no random numbers.
bool ask_stamp(lcm_ssv_asker_t* asker, char* error, size_t error_size);

/// Sends the question, stamped, on SSV_SCENARIO and waits for its plan on SSV_PLAN; again every half second, since a
/// datagram may be lost and a planner answers a repeated question from its store. With a scalar, the first planner
/// heard of that one is asked by its id, which is written to the question: no other can answer then.
/// @param answer  written only on success; the caller frees it with lcm_ssv_plan_t_decode_cleanup.
/// @return true; or false with a sentence in `error`: no transport, no planner of the scalar, or no answer in time.
bool ask_plan(const ask_target_t* target, lcm_ssv_scenario_t* question, lcm_ssv_plan_t* answer, char* error,
              size_t error_size);

/// Likewise the prices of any number of scenarios (their own asker means nothing), in batches of at most SSV_MAX_BATCH.
/// What fits one batch goes to whoever is there. More is dealt to the planners that are heard, one batch at a time
/// each; a planner that falls silent, or does not answer for long, loses its batch to another. Where none is heard,
/// whoever hears the batch answers it.
/// @param quotes    one for each scenario, in their order, written only on success; freed with wire_clear each.
/// @param progress  called after each answer with how many scenarios have their price; may be NULL.
bool ask_quotes(const ask_target_t* target, const lcm_ssv_scenario_t* scenarios, int count, lcm_ssv_quote_t* quotes,
                void (*progress)(int priced, int count, void* context), void* context, char* error, size_t error_size);

#endif
