/// One flight: has a task flown, in simulation or by a real vehicle, shows how it gets on, and keeps what was flown.
#ifndef SSV_FLIGHT_H
#define SSV_FLIGHT_H

#include <stdbool.h>

#include "report.h"
#include "task_options.h"

/// SIGINT, SIGTERM and SIGHUP as events.
typedef struct {
    int fd;    ///< can be read when there are new ones
    int count; ///< that have come
} flight_signals_t;

/// From here on a signal is an event like others. @return false with a line on standard error.
bool flight_take_signals(flight_signals_t* signals);

/// Counts those that are new. @return how many have come in all.
int flight_count_signals(flight_signals_t* signals);

/// What has come of a flight.
typedef struct {
    bool has_answer; ///< the planner's: the plan, or its refusal
    lcm_ssv_plan_t plan;
    bool is_flown; ///< to whichever end; the rest holds if so
    lcm_ssv_execution_t end;
    report_leg_t leg[SSV_MAX_LEGS];
    flown_t flown;
    json_t* truth; ///< what the simulator says; NULL for a real vehicle
    int news_lost;
    double wall_s;
} flight_result_t;

/// Has a task flown that is planned already: asks for it, follows it to its end, and shows how it gets on. With
/// `options->in_simulation` a simulated vehicle and its planner are started for it and ended with it.
/// @return the exit code, after a line on standard error unless the flight or the answer tells why: `result` is written
/// in full, and closed by the caller.
int flight_fly(const task_options_t* options, const report_plan_t* predicted, lcm_ssv_task_t* question,
               flight_signals_t* signals, flight_result_t* result);

/// The same flight as a report.
report_flight_t flight_report(const task_options_t* options, const report_plan_t* predicted,
                              const flight_result_t* result);

void flight_close(flight_result_t* result);

#endif
