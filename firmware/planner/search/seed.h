/// Seeds: decisions that a search starts from, good by a rough guess of their price (DESIGN.md 6).
#ifndef SSV_SEED_H
#define SSV_SEED_H

#include "planner/search/capability.h"
#include "planner/search/decision.h"

typedef struct {
    ssv_decision_t decision;
    real_t price, transit_price; ///< estimates; the latter that of the transit before a transfer, 0 until it is known
} ssv_seed_t;

/// A list of seeds, the cheapest first by both prices together. What is not clearly less comes later.
typedef struct {
    ssv_seed_t* seed;
    int num, most;
} ssv_seeds_t;

/// Enters a seed; where the list is full, in place of the last, if it is clearly less than that.
void ssv_seeds_insert(ssv_seeds_t* seeds, const ssv_seed_t* seed);

/// Orders the first num of a list anew, after their prices have changed.
void ssv_seeds_sort(ssv_seeds_t* seeds, int num);

/// Drops duplicates, those that cost the same as the one before: in a scene with symmetries they are its mirror images.
void ssv_seeds_drop_duplicates(ssv_seeds_t* seeds);

/// Replaces guesses by estimates and orders the seeds by them.
void ssv_seeds_price(ssv_phase_context_t* context, ssv_seeds_t* seeds);

static inline real_t ssv_seed_total(const ssv_seed_t* seed) { return seed->price + seed->transit_price; }

/// Seeds of a transit, into an empty list: one screw that makes all of the turn in flight; each cheap direction of the
/// body along the line of flight, and those that the attitudes at the ends fly along without a turn, rolled about that
/// line so that the first turn or the last is the smallest.
void ssv_seed_transit(const ssv_phase_context_t* context, const ssv_capability_t* capability, ssv_seeds_t* seeds);

/// Finds out what turns with the beam of this transfer cost: before seeding it in any mode.
void ssv_seed_begin(const ssv_phase_context_t* context, ssv_capability_t* capability);

/// Seeds of a transfer in one attitude mode, into an empty list. Two small turns cost more than one large: so each
/// cheap direction of the body along the line of flight, the beam pointing as it lies, or as it docks, and the turn at
/// the other end with all its spins. Or all of the turn is made in flight. The spins also decide on which sides of the
/// beam the flight begins and ends, so how long it is. Where the water drags at the beam more than at the vehicle, it
/// pays to fly it lengthwise, whatever the turns at both ends cost.
void ssv_seed_transfer(const ssv_phase_context_t* context, ssv_capability_t* capability, ssv_attitude_mode_t mode,
                       ssv_seeds_t* seeds);

#endif
