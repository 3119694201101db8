/// The planner behind its wire types: one scenario_t in, one plan_t out, with no transport between. The daemon calls it for
/// what arrives over LCM, `ssv plan` calls it in process, so both give the same answer to the same question.
///
/// This is where doubles of the wire become scalars of the core and back, and where a fault becomes a sentence.
#ifndef SSV_ANSWER_H
#define SSV_ANSWER_H

#include "lcm_ssv_plan_t.h"
#include "lcm_ssv_scenario_t.h"
#include "ssv/planner.h"

#define SSV_REASON_SIZE 2048

/// Memory for one answer: caller-owned, some 52 kB, best static. `wire` points into the rest, so the struct must not be copied
/// or freed while wire is in use.
typedef struct {
    lcm_ssv_plan_t wire;          ///< the answer, ready to encode
    ssv_plan_t plan;              ///< the core's plan behind it; meaningful when wire.status is STATUS_OK
    char reason[SSV_REASON_SIZE];
    lcm_ssv_candidate_t candidates[SSV_MAX_CANDIDATES];
    lcm_ssv_leg_t legs[SSV_MAX_LEGS];
    lcm_ssv_segment_t segments[SSV_MAX_SEGMENTS];
    lcm_ssv_event_t events[SSV_MAX_EVENTS];
} ssv_answer_t;

/// Converts the wire scenario to the core's type, value for value: any content is accepted, nothing is checked here.
void ssv_scenario_from_wire(ssv_scenario_t* scenario, const lcm_ssv_scenario_t* wire);

/// Answers the question: plans it, or says why not. Never fails; the answer's status is OK, INFEASIBLE or INVALID.
/// @return the core's status: SSV_OK, SSV_INFEASIBLE or what ssv_problem_init found.
ssv_status_t ssv_answer(const lcm_ssv_scenario_t* question, ssv_answer_t* answer);

/// Refuses the question without planning it: status INVALID with this reason (copied, cut at SSV_REASON_SIZE - 1).
void ssv_answer_refuse(const lcm_ssv_scenario_t* question, const char* reason, ssv_answer_t* answer);

#endif
