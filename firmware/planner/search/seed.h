/// Where the search for a phase starts: trials that are good by a rough guess of their price (DESIGN.md 6).
#ifndef SSV_SEED_H
#define SSV_SEED_H

#include "planner/search/decision.h"

/// Prices closer than this fraction are even. It is the same in all scalars: those that refine by other margins go
/// other ways.
#define SSV_EVEN REAL(1e-9)

/// Whether one price is less than another by more than rounding in this scalar. Prices of mirror images are not: which
/// is taken is then a matter of order.
static inline bool ssv_clearly_less(real_t a, real_t b) {
    return a < b - real_mul(real_max(REAL(5e-9), 3 * REAL_EPSILON), b);
}

/// Whether two prices are so close, the first being the lesser, that what is found later decides: scalars of few digits
/// may not tell them apart.
static inline bool ssv_alike(real_t a, real_t b) { return b - a <= real_mul(REAL(1e-4), a); }

/// Axes, edges and diagonals of the body.
#define SSV_NUM_DIRECTIONS 26

/// The thrusts that turns about S ask for at unit rate: for momentum, linear drag and quadratic drag.
enum { SSV_TURN_ACCEL, SSV_TURN_LINEAR, SSV_TURN_QUADRATIC, SSV_NUM_TURN_PARTS };
typedef struct {
    vec3_t axis_S;                                           ///< the beam's z axis as it is held, across x
    bool any[SSV_NUM_TURN_PARTS];                            ///< whether there is such a part at all
    real_t thrust[SSV_NUM_TURN_PARTS][3][SSV_NUM_THRUSTERS]; ///< about x, axis_S, and the third axis
} ssv_turns_t;

/// The same with the beam held along +y and all of it rolled about x: what stays, what goes with the cosine of the
/// roll, and what with its sine.
typedef struct {
    bool any[SSV_NUM_TURN_PARTS];
    real_t thrust[SSV_NUM_TURN_PARTS][3][3][SSV_NUM_THRUSTERS];
} ssv_rolled_turns_t;

/// How the vehicle handles: the directions of its body that are cheap to fly along, the price of a metre along each,
/// and its turns. If thrusters serve the vehicle rolled half a turn about x as well, the first num_upright stand for
/// all.
typedef struct {
    bool either_way_up;
    int num, num_upright;
    real_t least; ///< of the prices [1/m], also those not kept
    vec3_t n[SSV_NUM_DIRECTIONS];
    real_t price[SSV_NUM_DIRECTIONS]; ///< [1/m] see ssv_metre_price
    ssv_turns_t turns;                ///< without a beam
    ssv_rolled_turns_t rolled;        ///< with the beam of the transfer that is being drawn,
    ssv_turns_t carried;              ///< and as it is held
} ssv_capability_t;

void ssv_capability_init(const ssv_question_t* question, ssv_capability_t* capability);

/// A place where the search may start.
typedef struct {
    ssv_decision_t decision;
    real_t price, transit_price; ///< estimates; the latter of what is flown before
} ssv_seed_t;

/// What the beam does on the way of a transfer: it keeps the attitude that it has at one of the ends, or it swings from
/// one to the other, or it keeps that of one end but for a roll about the way.
typedef enum { SSV_HELD, SSV_SWUNG, SSV_ROLLED } ssv_attitude_mode_t;

/// Starts of the transit: each cheap direction of the body along the way, and those that the attitudes at the ends fly
/// along without a turn, rolled about the way so that the first turn or the last is the smallest. @return how many of
/// `most`.
int ssv_seed_transit(const ssv_phase_context_t* context, const ssv_capability_t* capability, int most,
                     ssv_seed_t* list);

/// Starts of the transfer. Two small turns cost more than one large: so each cheap direction of the body along the way,
/// the beam pointing as it lies, or as it docks, and the turn at the other end with all its spins. Or all of the turn
/// is made on the way. The spins also decide on which sides of the beam the flight begins and ends, so how long it is.
/// @return how many of `most`.
int ssv_seed_transfer(const ssv_phase_context_t* context, ssv_capability_t* capability, ssv_attitude_mode_t carry,
                      int most, ssv_seed_t* list);

#endif
