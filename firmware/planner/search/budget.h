/// How much is tried: every effort and every count of tries of the search. More of any of them costs time in
/// proportion and finds a little more; each was set by measurement over random scenarios.
#ifndef SSV_BUDGET_H
#define SSV_BUDGET_H

#include <stdbool.h>

#include "ssv/scenario.h"

/// Spins about the beam's axis that are seeded, evenly all round. Their number is odd: half a turn could as well go the
/// other way.
#define SSV_NUM_SPINS 5
/// Swings are seeded with spins up to this one, either way round.
#define SSV_LAST_SWING 1
/// Axes, edges and diagonals of the body: directions of flight that are looked at.
#define SSV_NUM_DIRECTIONS 26
/// Lines across the contact's axis along which a beam that is flown lengthwise may be held.
#define SSV_NUM_ACROSS 2
/// Seeds of the transit at most, and where a transit is only screened.
#define SSV_MAX_TRANSIT_SEEDS 2
#define SSV_SCREENED_TRANSIT_SEEDS 1
/// The attitude of the beam during a transfer: it keeps the one that it has at one of the ends, or it swings from one
/// to the other, or it keeps that of one end but for a roll about the line of flight, or it flies lengthwise. Or the
/// vehicle turns as little as may be, on its way to the beam and then to the port.
typedef enum {
    SSV_HELD,
    SSV_SWUNG,
    SSV_ROLLED,
    SSV_LENGTHWISE,
    SSV_STEADY,
    SSV_NUM_ATTITUDE_MODES
} ssv_attitude_mode_t;

/// Seeds of a transfer that are drawn in each mode.
typedef struct {
    int num[SSV_NUM_ATTITUDE_MODES];
} ssv_draw_t;

/// Seeds of a transfer that screening draws, and those that a search draws, at most.
#define SSV_SCREENED_SEEDS 4
#define SSV_MAX_SEEDS 9
/// Those that are drawn where what a quick search found is in the way.
extern const ssv_draw_t ssv_evasion_draw;
/// Rounds of refinement at most.
#define SSV_NUM_ROUNDS 3
/// Steps to and fro between how the vehicle travels and where a transfer's flight starts and ends.
#define SSV_NUM_AIMS 2
/// Steps along the beam where it may be held anywhere.
#define SSV_NUM_HEIGHT_STEPS 6
/// Where the beam may be held anywhere, the lower bound tries heights this many to its length.
#define SSV_NUM_BOUND_STEPS 8
/// Steps that improve a direction of flight, along each axis of the body.
#define SSV_NUM_DIRECTION_STEPS 3
/// Pairs of weights of a front: a ladder from time alone to impulse alone, and the scenario's own.
#define SSV_NUM_RUNGS 9

/// When a step of refinement is accepted, as fractions of the price; by measurement: of J, and of how often float and
/// double part.
typedef struct {
    real_t promise;    ///< what the parabola must promise before its lowest point is priced
    real_t least_bend; ///< what the parabola is bent at least, whatever the prices say
    real_t clearly;    ///< how much lower an end must be than where the parabola leads
    real_t goes_on;    ///< what a sweep must have gained for another to follow
} ssv_acceptance_t;

/// Refinement of the cheapest of some seeds.
typedef struct {
    int num_refined, num_sweeps; ///< how many of them, and with how many sweeps
    bool pairs;                  ///< whether numbers also move in pairs
} ssv_stage_t;

/// What decides what a flight costs: the vehicle's linear drag, next to which all else counts little, as with the
/// models of the SSV; or that and all else, inertia, quadratic drag and the beam's. With linear drag alone a metre
/// costs the same in flights of any length, and the beam may point anywhere; a search that looks for less finds the
/// same in less time.
typedef enum { SSV_LINEAR_DRAG, SSV_ANY_DRAG, SSV_NUM_REGIMES } ssv_regime_t;

/// What an effort amounts to.
typedef struct {
    int num_screened; ///< candidates: those with the shortest flights
    int num_searched; ///< the most promising of them, beside those that promise the same
    real_t closeness; ///< of estimates, see ssv_profile_estimate
    ssv_acceptance_t acceptance;
    bool draws;                         ///< whether it starts from seeds of its own, not from those of screening
    ssv_stage_t rounds[SSV_NUM_ROUNDS]; ///< refinement of the transfer, round after round
    ssv_stage_t transit;                ///< refinement of the transit
    ssv_stage_t evasion[2]; ///< refinement of fresh seeds, of the transit and of the transfer, where what was
                            ///< found comes too near something
    ssv_stage_t joint;      ///< refinement of the transfer once more, with the price of both phases
} ssv_budget_t;

/// What an effort amounts to in a regime.
const ssv_budget_t* ssv_budget(ssv_regime_t regime, ssv_effort_t effort);

/// What is drawn in a regime.
typedef struct {
    ssv_draw_t screening; ///< seeds that screening draws,
    int num_transits;     ///< and of how many of them the transits decide, too, beside those that are alike
    ssv_draw_t best;      ///< seeds that effort best draws
} ssv_draws_t;

extern const ssv_draws_t ssv_draws[SSV_NUM_REGIMES];

/// What follows where nothing was found that keeps clear: other efforts, and longer approaches, which lead the last
/// turn of a phase out of what stands close around beam or port.
typedef struct {
    ssv_effort_t effort;
    real_t approach_mate_m, approach_dock_m; ///< [m] at least
} ssv_detour_t;

#define SSV_NUM_DETOURS 5
/// The one that is what effort best has done by then.
#define SSV_SAME_DETOUR 2
extern const ssv_detour_t ssv_detours[SSV_NUM_DETOURS];

#endif
