/// Where the search for a phase starts: trials that are good by a rough guess of their price (DESIGN.md 6).
#ifndef SSV_DRAW_H
#define SSV_DRAW_H

#include "planner/trial.h"

/// Prices closer than this fraction are equal: which is taken must not hang on rounding.
#define SSV_EVEN REAL(1e-9)

/// Axes, edges and diagonals of the body.
#define SSV_NUM_DIRECTIONS 26

/// The directions of the body that are cheap to fly along, and the price of a metre along each. If thrusters serve the vehicle
/// rolled half a turn about x as well, the first num_upright stand for all.
typedef struct {
    int num, num_upright;
    real_t least;                ///< of the prices [1/m], also those not kept
    vec3_t n[SSV_NUM_DIRECTIONS];
    real_t price[SSV_NUM_DIRECTIONS]; ///< [1/m] see ssv_metre_price
} ssv_directions_t;

void ssv_cheap_directions(const ssv_problem_t* problem, ssv_directions_t* directions);

/// A place where the search may start.
typedef struct {
    ssv_trial_t trial;
    real_t price, transit_price; ///< estimates; the latter of what is flown before
} ssv_start_t;

/// What the beam does on the way of a transfer: it keeps the attitude that it has at one of the ends, or it swings from one to
/// the other, or it keeps that of one end but for a roll about the way.
typedef enum { SSV_HELD, SSV_SWUNG, SSV_ROLLED } ssv_carry_t;

/// Starts of the transit: each cheap direction of the body along the way, and those that the attitudes at the ends fly along
/// without a turn, rolled about the way between the attitudes that are the nearest to both ends. @return how many of `most`.
int ssv_draw_transit(const ssv_task_t* task, const ssv_directions_t* directions, int most, ssv_start_t* list);

/// Starts of the transfer. Two small turns cost more than one large: so each cheap direction of the body along the way, the beam
/// pointing as it lies, or as it docks, and the turn at the other end with all its spins. Or all of the turn is made on the way.
/// The spins also decide on which sides of the beam the flight begins and ends, so how long it is. @return how many of `most`.
int ssv_draw_transfer(const ssv_task_t* task, const ssv_directions_t* directions, ssv_carry_t carry, int most, ssv_start_t* list);

#endif
