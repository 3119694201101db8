/// Flies the core's plans in the independent physics of sim/.
#ifndef TESTS_FLIGHT_H
#define TESTS_FLIGHT_H

#include "replay/replay.h"
#include "ssv/planner.h"

/// The plan of the problem as the simulators read it; its segments live until the next call. The plan must be SSV_OK.
plan_file_t file_of_plan(const ssv_problem_t* problem, const ssv_plan_t* plan);

/// Flies the plan of the problem open loop. The plan must be SSV_OK. @return whether the flight can be judged.
bool flight_of_plan(const ssv_problem_t* problem, const ssv_plan_t* plan, replay_flight_t* flight);

#endif
