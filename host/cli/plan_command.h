/// Shows the answer to one task: what `ssv plan` does at its end, and `ssv fly` where there is no plan to fly.
#ifndef SSV_PLAN_COMMAND_H
#define SSV_PLAN_COMMAND_H

#include "lcm_ssv_plan_t.h"
#include "task_options.h"

/// Shows a planner's answer: a plan where the options say, anything else on standard output, and on standard error why
/// it is no plan, in words of the file. @return the exit code.
int plan_show(const task_options_t* options, const scenario_file_t* file, const lcm_ssv_task_t* question,
              const lcm_ssv_plan_t* answer);

/// Likewise a task that could not be read.
int plan_refused(const task_options_t* options, char* reason);

#endif
