/// Schedules by beam search: part after part, the most promising ways so far are carried on together.
#ifndef SSV_SCHEDULER_STAGES_H
#define SSV_SCHEDULER_STAGES_H

#include "estimate.h"
#include "schedule.h"

typedef struct {
    assembly_schedule_t best; ///< no parts: none was found
    double lowest_share;      ///< the lowest price that was asked for, as a share of its estimate
    bool stopped, in_vain, out_of_memory;
} stages_result_t;

/// Carries on so many ways, those that have cost least above what their parts were due by the estimate; of each, so
/// many parts are priced that are due most.
stages_result_t stages_search(const structure_t* structure, const assembly_prices_t* prices, const estimate_t* estimate,
                              int num_ways, int num_parts, bool (*stop)(void* context), void* context);

#endif
