/// What parts of an assembly cost, estimated from few prices, and what the whole costs at least by the estimate.
///
/// The flight to a beam hardly depends on the slot that the beam goes to, and the flight with it hardly on where the
/// vehicle came from. So a price is nearly that of the same beam and slot from the start, and the difference that it
/// makes for the beam to come from elsewhere: as many prices as twice the beams times the slots tell them all, past the
/// hubs alone.
///
/// Where each part costs its estimate, the way of the vehicle is a flow from places through beams to slots, each place
/// left once, each beam taken once at most and each slot filled once. The cheapest such flow costs no more than any
/// schedule, since it need not be one way; and its dual prices say how much a part takes away from that.
#ifndef SSV_SCHEDULER_ESTIMATE_H
#define SSV_SCHEDULER_ESTIMATE_H

#include "prices.h"
#include "structure.h"

typedef struct estimate estimate_t;

/// Asks for the prices, until `stop` says so. @return NULL if out of memory, stopped or without prices.
estimate_t* estimate_open(const structure_t* structure, const assembly_prices_t* prices, bool (*stop)(void* context),
                          void* context);

/// What a part is thought to cost from the place where the slot `last` is, -1 being the start. INFINITY if it was seen
/// to have no plan.
double estimate_part(const estimate_t* estimate, int last, int beam, int slot);

/// Of what all parts cost, how much is put down to this one: a schedule of parts that cost their estimates costs
/// estimate_least() and what each part costs above its due.
double estimate_due(const estimate_t* estimate, int last, int beam, int slot);

/// What all parts cost at least if each costs its estimate; INFINITY if some slot can have no beam.
double estimate_least(const estimate_t* estimate);

void estimate_close(estimate_t* estimate);

#endif
