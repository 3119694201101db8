/// What the rest of an assembly costs at least, from prices with fewer obstacles.
///
/// Every flight is priced from every pose that flights past the hubs alone lead to; they are few, since poses are
/// rounded, and so they close to a graph. The least price of a beam to a slot, by the beam and slot that the vehicle
/// comes from, then makes a smaller problem, which is solved in full: the cheapest way to build the rest if each part
/// cost that least price.
///
/// Where no beam that stands is an obstacle these are all the prices that there are, and the bound holds for certain.
/// Else it holds as far as what stands makes no flight cheaper; whoever uses it must allow for some.
#ifndef SSV_SCHEDULER_BOUND_H
#define SSV_SCHEDULER_BOUND_H

#include "prices.h"
#include "structure.h"

typedef struct bound bound_t;

/// What the vehicle did last; all -1 where it starts.
typedef struct {
    int beam, slot;
} bound_last_t;

/// Whether the structure is not too large for this.
bool bound_fits(const structure_t* structure);

/// Asks for the prices, until `stop` says so, which is asked later, too.
/// @return NULL if out of memory or stopped, if there are no prices to be had, or if the structure is too large for
/// this.
bound_t* bound_open(const structure_t* structure, const assembly_prices_t* prices, bool (*stop)(void* context),
                    void* context);

/// The least price of one part; 0 if none is known.
double bound_part(const bound_t* bound, bound_last_t last, int beam, int slot);

/// The least price of all that is not built. INFINITY if the rules leave no way; less, and down to 0, where there were
/// too many ways or no time to tell.
double bound_rest(bound_t* bound, set_t built, set_t used, bound_last_t last);

void bound_close(bound_t* bound);

#endif
