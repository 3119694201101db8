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

/// The attitude of the beam during a transfer: it keeps the one that it has at one of the ends, or it swings from one
/// to the other, or it keeps that of one end but for a roll about the line of flight.
typedef enum { SSV_HELD, SSV_SWUNG, SSV_ROLLED } ssv_attitude_mode_t;

/// Seeds of a transit, into an empty list: each cheap direction of the body along the line of flight, and those that
/// the attitudes at the ends fly along without a turn, rolled about that line so that the first turn or the last is the
/// smallest.
void ssv_seed_transit(const ssv_phase_context_t* context, const ssv_capability_t* capability, ssv_seeds_t* seeds);

/// Seeds of a transfer in one attitude mode, into an empty list. Two small turns cost more than one large: so each
/// cheap direction of the body along the line of flight, the beam pointing as it lies, or as it docks, and the turn at
/// the other end with all its spins. Or all of the turn is made in flight. The spins also decide on which sides of the
/// beam the flight begins and ends, so how long it is.
void ssv_seed_transfer(const ssv_phase_context_t* context, ssv_capability_t* capability, ssv_attitude_mode_t mode,
                       ssv_seeds_t* seeds);

#endif
