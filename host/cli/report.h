/// Shows answers of the planner: JSON for programs, tables for people. Both are the same for an answer computed in
/// process and one that came over LCM.
#ifndef SSV_REPORT_H
#define SSV_REPORT_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

#include "lcm_ssv_execution_t.h"
#include "lcm_ssv_plan_t.h"
#include "lcm_ssv_task_t.h"
#include "report/flown.h"
#include "ssv/answer.h"

/// A plan, the question that it answers, and the file that this came from.
typedef struct {
    const char* path;
    const lcm_ssv_task_t* question;
    const lcm_ssv_plan_t* plan;
    bool names_planner; ///< whether the table says which planner it was
} report_plan_t;

typedef struct {
    const char* path;
    const lcm_ssv_task_t* question;
    const lcm_ssv_quote_t* quote;
} report_quote_t;

/// One row for each file.
typedef struct {
    int count;
    report_quote_t* row;
} report_quotes_t;

/// How a leg of a plan was flown.
typedef struct {
    bool begun, ended;
    double time_s, impulse_Ns; ///< so far
    double wait_s;             ///< of that time, while the plan's clock stood: before mate and dock, or in a pause
} report_leg_t;

typedef struct {
    report_plan_t plan; ///< that was flown
    const lcm_ssv_execution_t* end;
    const report_leg_t* legs; ///< one for each of the plan
    const flown_t* flown;
    int news_lost;       ///< messages of the flight that did not arrive
    double wall_s;       ///< how long it took, by the clock on the wall
    const json_t* truth; ///< what the simulator says; NULL where there is none, as are the next two
    const char* conditions;
    const char* seed;
} report_flight_t;

/// Whether the simulator's truth says that something was touched; false where there is none.
bool report_touches(const json_t* truth);

// Each takes a report_plan_t, a report_quotes_t or a report_flight_t.

/// The same as an object, for a file with several; NULL if the answer holds a number that is not finite, or out of
/// memory.
json_t* report_plan_object(const report_plan_t* report);
json_t* report_flight_object(const report_flight_t* flight);

/// Writes one JSON object; numbers have 17 digits, so reading them gives the same doubles. An answer with
/// STATUS_INVALID is shown by its status and reason alone, with the question otherwise.
/// @return false if the answer holds a number that is not finite, which JSON has no word for, or out of memory.
bool report_plan_json(FILE* out, const void* plan);
bool report_quotes_json(FILE* out, const void* quotes);
bool report_flight_json(FILE* out, const void* flight);

/// Writes tables at most 120 columns wide, those of quotes if no path is longer than 43. A plan with STATUS_INVALID has
/// none. @return true.
bool report_plan_table(FILE* out, const void* plan);
bool report_quotes_table(FILE* out, const void* quotes);
bool report_flight_table(FILE* out, const void* flight);

#endif
