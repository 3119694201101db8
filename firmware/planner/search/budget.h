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
/// Seeds of the transit at most, and where a transit is only screened.
#define SSV_MAX_TRANSIT_SEEDS 2
#define SSV_SCREENED_TRANSIT_SEEDS 1
/// Attitude modes of a transfer that screening tries, the first ones, and seeds that it draws of all of these.
#define SSV_SCREENED_MODES 2
#define SSV_SCREENED_SEEDS 4
/// Seeds of a transfer at most.
#define SSV_MAX_SEEDS 9
/// Attitude modes and seeds of each where what a quick search found is in the way.
#define SSV_EVASION_MODES 3
#define SSV_EVASION_SEEDS 3
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
} ssv_acceptance_t;

/// Refinement of the cheapest of some seeds.
typedef struct {
    int num_refined, num_sweeps; ///< how many of them, and with how many sweeps
    bool pairs;                  ///< whether numbers also move in pairs
} ssv_stage_t;

/// What an effort amounts to.
typedef struct {
    int num_screened; ///< candidates: those with the shortest flights
    int num_searched; ///< the most promising of them, beside those that promise the same
    real_t closeness; ///< of estimates, see ssv_profile_estimate
    ssv_acceptance_t acceptance;
    int num_modes, num_seeds;           ///< attitude modes of a transfer, and seeds of each; none: go on from screening
    ssv_stage_t rounds[SSV_NUM_ROUNDS]; ///< refinement of the transfer, round after round
    ssv_stage_t transit;                ///< refinement of the transit
    ssv_stage_t evasion[2]; ///< refinement of fresh seeds, of the transit and of the transfer, where what was
                            ///< found comes too near something
    ssv_stage_t joint;      ///< refinement of the transfer once more, with the price of both phases
} ssv_budget_t;

extern const ssv_budget_t ssv_budgets[2]; ///< by ssv_effort_t

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
