/// The LCM channels that the messages of package ssv go over.
#ifndef SSV_CHANNELS_H
#define SSV_CHANNELS_H

#define CHANNEL_SCENARIO "SSV_SCENARIO"     ///< task_t, to the planner
#define CHANNEL_PLAN "SSV_PLAN"             ///< plan_t, its answer
#define CHANNEL_BATCH "SSV_SCENARIO_BATCH"  ///< scenario_batch_t, to the planner
#define CHANNEL_QUOTES "SSV_QUOTE_BATCH"    ///< quote_batch_t, its answer
#define CHANNEL_STATUS "SSV_PLANNER_STATUS" ///< planner_status_t, once a second
#define CHANNEL_EXECUTE "SSV_EXECUTE"       ///< task_t, to the planner: plan it, answer on SSV_PLAN, and fly it
#define CHANNEL_CONTROL "SSV_CONTROL"       ///< control_t, to the planner: stop, pause or go on with a flight
#define CHANNEL_EXECUTION "SSV_EXECUTION"   ///< execution_t, how a flight gets on
#define CHANNEL_SCHEDULE "SSV_SCHEDULE"     ///< schedule_t, in which order a structure is assembled
#define CHANNEL_STATE "SSV_VEHICLE_STATE"   ///< vehicle_state_t, as estimated
#define CHANNEL_TRUTH "SSV_VEHICLE_TRUTH"   ///< vehicle_state_t, as simulated

#endif
