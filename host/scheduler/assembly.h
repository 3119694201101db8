/// The assembly of a structure as a task network, and its schedule at least cost: which beam goes to which slot, in
/// which order, over which poses of the vehicle.
///
///     assemble-structure           all stands: nothing
///                                  else: assemble-part with any beam and slot that the rules allow; assemble-structure
///     assemble-part BEAM SLOT      fly-to-beam BEAM; fly-beam-to-hub BEAM SLOT
///
/// A part's price depends on where the vehicle starts, on the beam and the slot, and on what stands, and on nothing
/// else. Where the vehicle ends is rounded (`pricing_ask`), so that few poses occur and the states close to a graph.
/// Prices come through a callback, all of one state together that may belong to a better schedule. Which may, a bound
/// tells (bound.h).
#ifndef SSV_SCHEDULER_ASSEMBLY_H
#define SSV_SCHEDULER_ASSEMBLY_H

#include "htn.h"
#include "schedule.h"

typedef struct {
    assembly_schedule_t best, greedy; ///< greedy takes the cheapest part each time
    bool greedy_tried;                ///< it is not where there are very many parts
    htn_status_t status;
    bool asked_in_vain; ///< prices were not to be had
    double lower_bound; ///< relies on relied_share, as a proof does
    /// A price that was not asked for is taken to be no less than this share of the least one of the same beam, slot
    /// and place to come from, with nothing but the hubs in the way. 0: the proof relies on nothing.
    double relied_share;
    double lowest_share; ///< the lowest of those that were asked for
    double
        estimated_least; ///< cost of the cheapest schedule by estimates of prices (estimate.h), about; INFINITY: none
    uint64_t nodes, states;
} assembly_result_t;

typedef struct {
    /// Asked all the time whether to end with what has been found; NULL = never.
    bool (*stop)(void* context);
    /// Called with each better schedule, and what is proved by then: that none costs less than the bound.
    void (*found)(void* context, double cost, double lower_bound);
    void* context; ///< of both
} assembly_limits_t;

extern const htn_kind_t assembly_kinds[];

/// Schedules the structure; *result is written in full. @return false if out of memory.
bool assembly_schedule(const structure_t* structure, const assembly_prices_t* prices, const assembly_limits_t* limits,
                       assembly_result_t* result);

/// Tells every decomposition of the structure, the bad ones too; for small structures. The schedule is lent. @return
/// false if out of memory, if there were no prices to be had, or if `told` said so.
bool assembly_each(const structure_t* structure, const assembly_prices_t* prices,
                   bool (*told)(void* context, const assembly_schedule_t* schedule), void* context);

#endif
