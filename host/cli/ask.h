/// Asks running planners over LCM: a plan of one of them, prices of all that are there, or that one flies a task.
///
/// The bus is open to strangers. What comes is looked at as bytes first, then whether it is for us,
/// then whether it can be the answer to what was asked (ssv/check.h). What fails is refused with a line on standard
/// error, a few at most and then a count, and the right answer is still awaited.
#ifndef SSV_ASK_H
#define SSV_ASK_H

#include <stdbool.h>
#include <stddef.h>

#include "lcm_ssv_execution_t.h"
#include "lcm_ssv_plan_t.h"
#include "lcm_ssv_quote_t.h"
#include "lcm_ssv_task_t.h"
#include "lcm_ssv_vehicle_state_t.h"

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
bool ask_plan(const ask_target_t* target, lcm_ssv_task_t* question, lcm_ssv_plan_t* answer, char* error,
              size_t error_size);

/// What whoever had a task flown wants next.
typedef enum {
    ASK_GO_ON,
    ASK_STOP, ///< the vehicle brakes, and the flight ends
    ASK_LEAVE ///< without waiting for its end
} ask_wish_t;

typedef struct {
    int64_t planner_id; ///< that flies; 0 for the one planner on the bus that hears its vehicle
    int64_t plan_hash;  ///< of the plan that is to be flown: another one is stopped; 0 for any
    int wake_fd;        ///< `turn` is called when it can be read, too; -1 for none
    /// Called with what each message tells, and without news at least five times a second. `plan` is NULL until it has
    /// been answered.
    ask_wish_t (*turn)(const lcm_ssv_plan_t* plan, const lcm_ssv_execution_t* news, void* context);
    /// Called with where the vehicle is said to be while the plan is flown: by its planner, or by a simulator.
    void (*state)(const lcm_ssv_vehicle_state_t* state, bool is_truth, void* context);
    void* context;
} ask_flight_t;

/// Has a planner fly the task: asks on SSV_EXECUTE as ask_plan does, and follows the flight to its end.
/// @param answer  the plan, or the planner's refusal, after which nothing is flown; as of ask_plan.
/// @param end     the last that was told, `state` being STATE_ENDED after a flight; freed with wire_clear.
/// @return true; or false with a sentence in `error` and neither of the two written.
bool ask_flight(const ask_target_t* target, const ask_flight_t* flight, lcm_ssv_task_t* question,
                lcm_ssv_plan_t* answer, lcm_ssv_execution_t* end, char* error, size_t error_size);

/// A connection for prices, which knows the planners that it has heard.
typedef struct ask_prices ask_prices_t;

/// @return NULL with a sentence in `error`.
ask_prices_t* ask_prices_open(const ask_target_t* target, char* error, size_t error_size);

/// Has ask_prices ask all the time whether to give up waiting.
void ask_prices_stop(ask_prices_t* deal, bool (*stop)(void* context), void* context);

/// Asks for the prices of any number of tasks (their own asker means nothing), in batches of at most SSV_MAX_BATCH that
/// have the same scene.
/// What fits one batch goes to whoever is there. More is dealt to the planners that are heard, one batch at a time
/// each; a planner that falls silent, or does not answer for long, loses its batch to another. Where none is heard,
/// whoever hears the batch answers it.
/// @param quotes    one for each scenario, in their order, written only on success; freed with wire_clear each.
/// @param progress  called after each answer with how many scenarios have their price; may be NULL.
bool ask_prices(ask_prices_t* deal, const lcm_ssv_task_t* tasks, int count, lcm_ssv_quote_t* quotes,
                void (*progress)(int priced, int count, void* context), void* context, char* error, size_t error_size);

void ask_prices_close(ask_prices_t* deal);

/// The same for who asks once.
bool ask_quotes(const ask_target_t* target, const lcm_ssv_task_t* tasks, int count, lcm_ssv_quote_t* quotes,
                void (*progress)(int priced, int count, void* context), void* context, char* error, size_t error_size);

#endif
