/// Whether an answer from the bus can be the answer to a question: what everybody does before using one, on the vehicle
/// and on the host.
///
/// The bus is open: whoever hears a question can answer it. An answer that passes here names the question by its hash,
/// keeps to what was asked, adds up, stays within the thrusters' limits, starts where the vehicle is and docks the beam
/// at the port, and keeps clear of what stands there by the margin and as far as it says, to within the rounding of the
/// arithmetic that it says it was computed in. That its price is the least is nothing that can be seen from it.
#ifndef SSV_CHECK_H
#define SSV_CHECK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "lcm_ssv_plan_t.h"
#include "lcm_ssv_quote_batch_t.h"
#include "lcm_ssv_scenario_batch_t.h"
#include "lcm_ssv_task_t.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Room for the longest sentence that a check writes.
#define SSV_CHECK_REASON_SIZE 160

/// 64-bit FNV-1a of an encoded task_t or scenario_batch_t behind its asker_t: of what is asked, not by whom.
/// @return 0 if the message is too short to ask anything.
uint64_t ssv_question_hash(const void* message, size_t size);

/// The same of a question that is not encoded yet. Costs its encoding, some ten microseconds.
uint64_t ssv_task_question_hash(const lcm_ssv_task_t* question);

/// Whether this may be the answer to this question; any decoded message may stand in *plan, its counts within the
/// limits of plan_t. A refusal of the question (status INVALID, INFEASIBLE, NUMERIC_OVERFLOW) is an answer, too.
/// @param[out] reason what is wrong, where: "segments[3].u_end_N[0]: 1e+06 N is beyond the limit of 6 N"; empty when
/// true.
bool ssv_check_plan(const lcm_ssv_task_t* question, const lcm_ssv_plan_t* plan, char reason[SSV_CHECK_REASON_SIZE]);

/// Likewise; `question_hash` is that of the batch (ssv_question_hash of its message).
bool ssv_check_quotes(const lcm_ssv_scenario_batch_t* question, uint64_t question_hash,
                      const lcm_ssv_quote_batch_t* answer, char reason[SSV_CHECK_REASON_SIZE]);

#ifdef __cplusplus
}
#endif

#endif
