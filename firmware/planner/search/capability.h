/// What the vehicle does cheaply: the price of flying along directions of its body, and of turning with and without a
/// beam. Rough, for ranking seeds (DESIGN.md 6).
#ifndef SSV_CAPABILITY_H
#define SSV_CAPABILITY_H

#include "planner/model/body.h"
#include "planner/motion/question.h"
#include "planner/search/budget.h"
#include "ssv/planner.h"
#include "ssv/vec3.h"

/// The thrusts that turns about S, and flights, ask for at unit rate: for momentum, linear drag and quadratic drag.
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

/// The directions of the body that are cheap to fly along, the price of a metre along each, and the turns. If thrusters
/// serve the vehicle rolled half a turn about x as well, the first num_upright stand for all.
typedef struct {
    ssv_regime_t regime;
    bool either_way_up;
    int num, num_upright;
    real_t flight_m; ///< length of the flights that prices per metre are of
    real_t least;    ///< of the prices [1/m], also those not kept
    vec3_t n[SSV_NUM_DIRECTIONS];
    real_t price[SSV_NUM_DIRECTIONS]; ///< [1/m]
    vec3_t across[SSV_NUM_ACROSS];    ///< the cheapest lines across x, either way along them
    ssv_turns_t turns;                ///< without a beam
    ssv_rolled_turns_t rolled;        ///< with the beam of the transfer that is being seeded,
    ssv_turns_t carried;              ///< and as it is held
} ssv_capability_t;

void ssv_capability_init(const ssv_question_t* question, ssv_capability_t* capability);

/// What a straight flight of an assembly along the unit body direction n_S costs, roughly: with all its drag, and with
/// what it takes to get under way.
real_t ssv_flight_guess(const ssv_question_t* question, const ssv_assembly_t* assembly, vec3_t n_S, real_t length_m);

/// The same of the vehicle alone, per metre of a typical flight [1/m].
real_t ssv_direction_price(const ssv_question_t* question, const ssv_capability_t* capability, vec3_t n_S);

/// The turns of an assembly whose beam, if it has one, is held along +y, as if the vehicle were a sphere.
void ssv_turns_of(const ssv_problem_t* problem, const ssv_assembly_t* assembly, ssv_rolled_turns_t* turns);

/// The same with the beam held along axis_S.
void ssv_turns_at(const ssv_rolled_turns_t* rolled, vec3_t axis_S, ssv_turns_t* turns);

/// What the turn q, in axes of the body, costs, roughly.
real_t ssv_turn_guess(const ssv_question_t* question, const ssv_turns_t* turns, quat_t q);

#endif
