/// Asks a running planner over LCM.
#ifndef SSV_ASK_H
#define SSV_ASK_H

#include <stdbool.h>
#include <stddef.h>

#include "lcm_ssv_plan_t.h"
#include "lcm_ssv_quote_batch_t.h"
#include "lcm_ssv_scenario_batch_t.h"
#include "lcm_ssv_scenario_t.h"

/// Publishes the question on SSV_SCENARIO and waits for the plan on SSV_PLAN that carries its request id. The question
/// is sent again every half second, since a datagram may be lost and the planner answers a repeated id from its store.
/// @param url     LCM provider; NULL for LCM's default (the environment's LCM_DEFAULT_URL, else UDP multicast).
/// @param scalar  the arithmetic that the planner must compute in, by its own word on SSV_PLANNER_STATUS, which comes
/// once a
///                second; NULL for any.
/// @param answer  written only on success; the caller frees it with lcm_ssv_plan_t_decode_cleanup.
/// @return true; or false with a sentence in `error`: no transport, another scalar, or no answer within timeout_s.
bool ask_plan(const char* url, const char* scalar, double timeout_s, const lcm_ssv_scenario_t* question,
              lcm_ssv_plan_t* answer, char* error, size_t error_size);

/// Likewise on SSV_SCENARIO_BATCH and SSV_QUOTE_BATCH, for 1..SSV_MAX_BATCH scenarios; the answer has a quote for each
/// of them and is freed with lcm_ssv_quote_batch_t_decode_cleanup.
bool ask_quotes(const char* url, const char* scalar, double timeout_s, const lcm_ssv_scenario_batch_t* question,
                lcm_ssv_quote_batch_t* answer, char* error, size_t error_size);

#endif
