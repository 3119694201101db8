/// The planner behind its wire types, with no transport between: one task_t in, one plan_t out; up to 16 scenarios
/// in a scenario_batch_t in, as many prices in a quote_batch_t out. The daemon calls it for what arrives over LCM, `ssv
/// plan` and `ssv quote` call it in process, so both give the same answer to the same question.
///
/// This is where doubles of the wire become scalars of the core and back, and where a fault becomes a sentence. In,
/// each double becomes the nearest scalar (of two as near, float takes the even one, fixed the larger in size); one
/// beyond fixed's largest becomes that, which no field's range allows. Out, each scalar becomes the nearest double:
/// itself in float, and in fixed up to 2^21 in size. All memory is the caller's; nothing here allocates.
#ifndef SSV_ANSWER_H
#define SSV_ANSWER_H

#include <stddef.h>

#include "lcm_ssv_plan_t.h"
#include "lcm_ssv_quote_batch_t.h"
#include "lcm_ssv_scenario_batch_t.h"
#include "lcm_ssv_scenario_t.h"
#include "lcm_ssv_task_t.h"
#include "ssv/planner.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Most scenarios of a batch.
#define SSV_MAX_BATCH 16
/// Room for the longest reason, that of an infeasible scenario with its candidates' own, as many as fit; and for such a
/// one.
#define SSV_REASON_SIZE 1536
#define SSV_CANDIDATE_REASON_SIZE 80

/// The longest messages [bytes], by the sizes of the wire types. A quote has a reason or a front, never both.
#define SSV_QUOTE_BYTES_MAX (186 + SSV_REASON_SIZE + (55 + SSV_CANDIDATE_REASON_SIZE) * SSV_MAX_CANDIDATES)
#define SSV_PLAN_BYTES_MAX                                                                                             \
    (184 + SSV_QUOTE_BYTES_MAX + 205 * SSV_MAX_LEGS + 64 * SSV_MAX_ARCS + 113 * SSV_MAX_SEGMENTS + 9 * SSV_MAX_EVENTS)
#define SSV_QUOTE_BATCH_BYTES_MAX (81 + SSV_QUOTE_BYTES_MAX * SSV_MAX_BATCH)

/// What a quote_t points to.
typedef struct {
    char reason[SSV_REASON_SIZE];
    char candidate_reason[SSV_MAX_CANDIDATES][SSV_CANDIDATE_REASON_SIZE];
    lcm_ssv_candidate_t candidates[SSV_MAX_CANDIDATES];
    lcm_ssv_candidate_t front[SSV_MAX_FRONT];
} ssv_quote_parts_t;

/// A scenario on its way to its answer; its fields are not API.
typedef struct {
    int stage;
    bool begun;
    ssv_status_t status;
    ssv_scene_t scene; ///< that the problem refers to
    ssv_problem_t problem;
    ssv_work_t work;
    ssv_front_t front;
} ssv_working_t;

/// Memory for one answer: caller-owned, some 80 kB, best static. `wire` points into the rest, so the struct must not be
/// copied or freed while wire is in use.
typedef struct {
    lcm_ssv_plan_t wire; ///< the answer, ready to encode
    ssv_plan_t plan;     ///< the core's plan behind it; meaningful when wire.quote.status is STATUS_OK
    ssv_quote_parts_t parts;
    lcm_ssv_leg_t legs[SSV_MAX_LEGS];
    lcm_ssv_arc_t arcs[SSV_MAX_ARCS];
    lcm_ssv_segment_t segments[SSV_MAX_SEGMENTS];
    lcm_ssv_event_t events[SSV_MAX_EVENTS];
    ssv_working_t working; ///< working.status is the core's: that of ssv_plan, or what ssv_problem_init found
} ssv_answer_t;

/// Memory for the answer to one batch: some 110 kB, likewise.
typedef struct {
    lcm_ssv_quote_batch_t wire; ///< the answer, ready to encode
    lcm_ssv_quote_t quotes[SSV_MAX_BATCH];
    ssv_quote_parts_t parts[SSV_MAX_BATCH];
    ssv_quote_t quote;     ///< the core's, of the scenario that is worked on
    ssv_working_t working; ///< likewise
    bool scenario_done;    ///< whether the last step ended a scenario, of which working.status then is the core's
} ssv_batch_answer_t;

/// Converts scene and scenario of the wire to the core's types, value for value: any content is accepted, nothing is
/// checked here. The scenario refers to the scene; NULL for none. want_front has no part in it: a front is asked for by
/// a call of its own.
void ssv_scene_from_wire(ssv_scene_t* to, const lcm_ssv_scene_t* message);
void ssv_scenario_from_wire(ssv_scenario_t* scenario, const lcm_ssv_scenario_t* message, const ssv_scene_t* scene);

/// Converts a plan from the wire to what ssv_plan_sample and ssv_plan_clearance read: legs, arcs, segments, events,
/// times, poses and the contact that docks. It must have passed ssv_check_plan (ssv/check.h), with status OK.
void ssv_plan_from_wire(ssv_plan_t* plan, const lcm_ssv_plan_t* wire);

/// This planner under an id, which an answer's reader knows it by. The text is static.
lcm_ssv_planner_t ssv_planner_identity(int64_t planner_id);

/// Answers the question: plans it, or says why not. Never fails; the answer's status and reason tell.
/// @return answer->working.status.
ssv_status_t ssv_answer(const lcm_ssv_task_t* question, const lcm_ssv_planner_t* planner, ssv_answer_t* answer);

/// The same in slices, for who has other things to do between (ssv_plan_begin says how long they are): begin, then step
/// until it returns true. *question must stay as it is until then; *planner's text as long as the answer is in use.
void ssv_answer_begin(const lcm_ssv_task_t* question, const lcm_ssv_planner_t* planner, ssv_answer_t* answer);
bool ssv_answer_step(const lcm_ssv_task_t* question, ssv_answer_t* answer);

/// Refuses the question that was begun: status INVALID with this reason (copied, cut at SSV_REASON_SIZE - 1).
void ssv_answer_refuse(const char* reason, ssv_answer_t* answer);

/// Answers a batch of 1..SSV_MAX_BATCH scenarios: a price for each, or why there is none; one that is refused leaves
/// the others alone. A price is that of `ssv_answer`, to the last bit (ssv_quote names the one exception).
/// @param question_hash of the batch's message, see ssv_question_hash.
void ssv_answer_batch(const lcm_ssv_scenario_batch_t* question, uint64_t question_hash,
                      const lcm_ssv_planner_t* planner, ssv_batch_answer_t* answer);

/// The same in slices.
void ssv_answer_batch_begin(const lcm_ssv_scenario_batch_t* question, uint64_t question_hash,
                            const lcm_ssv_planner_t* planner, ssv_batch_answer_t* answer);
bool ssv_answer_batch_step(const lcm_ssv_scenario_batch_t* question, ssv_batch_answer_t* answer);

/// Refuses what is left of the batch that was begun, like `ssv_answer_refuse`.
void ssv_answer_batch_refuse(const lcm_ssv_scenario_batch_t* question, const char* reason, ssv_batch_answer_t* answer);

/// Decodes a scenario_batch_t that came from outside; its scenarios go to the caller's memory, to which
/// batch->scenarios points then (the generated decoder would allocate as many as the message claims to have).
/// @return false if it is none through and through, its count outside 1..SSV_MAX_BATCH included; then *batch is
/// untouched.
bool ssv_scenario_batch_decode(const void* data, size_t size, lcm_ssv_scenario_t scenarios[SSV_MAX_BATCH],
                               lcm_ssv_scenario_batch_t* batch);

#ifdef __cplusplus
}
#endif

#endif
