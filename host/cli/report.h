/// Shows an answer of the planner: JSON for programs, a table for people. Both are the same for an answer planned in process
/// and one that came over LCM.
#ifndef SSV_REPORT_H
#define SSV_REPORT_H

#include <stdbool.h>
#include <stdio.h>

#include "lcm_ssv_plan_t.h"
#include "lcm_ssv_scenario_t.h"

/// Writes the answer and the question as one JSON object; numbers have 17 digits, so reading them gives the same doubles.
/// An answer with STATUS_INVALID is shown by its status and reason alone.
/// @return false if the answer holds a number that is not finite, which JSON has no word for, or out of memory.
bool report_json(FILE* out, const lcm_ssv_scenario_t* question, const lcm_ssv_plan_t* answer);

/// Writes the answer as tables at most 120 columns wide; `title` heads them. Nothing for STATUS_INVALID.
void report_table(FILE* out, const char* title, const lcm_ssv_scenario_t* question, const lcm_ssv_plan_t* answer);

#endif
