/// Scenarios of the core as the messages that ask for them.
#ifndef TESTS_QUESTION_H
#define TESTS_QUESTION_H

#include "lcm_ssv_task_t.h"
#include "ssv/planner.h"

/// The message that ssv_scenario_from_wire makes this scenario of, with its scene; asked by an asker with a name.
lcm_ssv_task_t question_of(const ssv_scenario_t* scenario);

#endif
