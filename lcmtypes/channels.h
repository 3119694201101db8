/// The LCM channels that the messages of package ssv go over.
#ifndef SSV_CHANNELS_H
#define SSV_CHANNELS_H

#define CHANNEL_SCENARIO "SSV_SCENARIO"     ///< scenario_t, to the planner
#define CHANNEL_PLAN "SSV_PLAN"             ///< plan_t, its answer
#define CHANNEL_BATCH "SSV_SCENARIO_BATCH"  ///< scenario_batch_t, to the planner
#define CHANNEL_QUOTES "SSV_QUOTE_BATCH"    ///< quote_batch_t, its answer
#define CHANNEL_STATUS "SSV_PLANNER_STATUS" ///< planner_status_t, once a second

#endif
