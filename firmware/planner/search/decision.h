/// A decision: one choice of every number that is free in a phase, and the motion that follows from it (DESIGN.md 6).
#ifndef SSV_DECISION_H
#define SSV_DECISION_H

#include <stddef.h>

#include "planner/model/body.h"
#include "planner/model/grasp.h"
#include "planner/motion/clearance.h"
#include "planner/motion/maneuver.h"
#include "planner/motion/path.h"
#include "planner/motion/question.h"
#include "ssv/plan.h"
#include "ssv/vec3.h"

/// A phase turns, flies and turns. Its flight has two ends: where it starts, and where it ends.
#define SSV_NUM_ENDS 2

/// The free numbers of a phase, by name and as the list that a search runs through. A rotation is given by twice the
/// tangent of half its angle along its axis, which is about the angle [rad] and takes no sines.
typedef union {
    struct {
        vec3_t turn;                ///< rotation of the vehicle, in axes of its own, on top of the attitude of travel
        vec3_t twist;               ///< rotation that the flight makes in each of its halves
        real_t mate_roll;           ///< of a transfer: how far the vehicle rolls about its contact axis
        real_t spin[SSV_NUM_ENDS];  ///< of a transfer: spins about the beam's axis as it lies and as it docks
        vec3_t pivot[SSV_NUM_ENDS]; ///< [m] of a transfer: pivots of the turns at both ends, in S
    };
    real_t number[15];
} ssv_free_numbers_t;

#define SSV_NUM_FREE ((int)(sizeof(ssv_free_numbers_t) / sizeof(real_t)))

/// What the search must know of a free number.
typedef struct {
    real_t first_step;
    bool transfer_only; ///< whether a transit does without it
    bool flips;         ///< whether it changes its sign when the vehicle is rolled half a turn about its contact axis
} ssv_free_number_t;

/// Place of a named number in the list.
#define SSV_NUMBER_OF(field) (offsetof(ssv_free_numbers_t, field) / sizeof(real_t))

extern const ssv_free_number_t ssv_free_number[sizeof(ssv_free_numbers_t) / sizeof(real_t)];

/// Seeded choices, and the free numbers that go on from there.
typedef struct {
    quat_t q_IT;            ///< attitude of travel: the vehicle in the middle of the flight, before `turn`
    vec3_t n_S;             ///< the direction of the body in which it flies, before `turn`
    vec3_t axis_S;          ///< of a transfer: the beam's z axis as the vehicle holds it, across x, before `mate_roll`
    int spin[SSV_NUM_ENDS]; ///< of a transfer: in [0, SSV_NUM_SPINS), how far it spins before `spin`
    ssv_free_numbers_t free;
} ssv_decision_t;

/// One phase for one contact and height: what a decision is made about.
typedef struct {
    const ssv_question_t* question;
    ssv_phase_t phase;
    int contact;
    real_t height_m;             ///< [m] attach height along z_B
    vec3_t hold_I[SSV_NUM_ENDS]; ///< [m] of a transfer: where the beam's axis is held at the ends; of a transit: where
                                 ///< the vehicle is. The second is where the approach begins, if there is one
    union {
        struct {
            quat_t q_IS[SSV_NUM_ENDS]; ///< the vehicle at the ends
        } transit;
        struct {
            vec3_t axis_I[SSV_NUM_ENDS]; ///< the beam's z axis as it lies, and when it has docked
            quat_t q_given; ///< if the ring angle is given: the vehicle that mates there with the beam's axis along +y
        } transfer;
    };
    const ssv_decision_t* transit_before; ///< the transit that a transfer's price shall include, or NULL
    real_t closeness;                     ///< of estimates, see ssv_profile_estimate; roughly until set
    int num_priced;                       ///< decisions so far
} ssv_phase_context_t;

/// The motion of a decision.
typedef struct {
    ssv_assembly_t assembly; ///< what moves
    pose_t X_from;           ///< vehicle where it begins
    int num_maneuvers;
    ssv_maneuver_t maneuver[SSV_MAX_PHASE_MANEUVERS];
} ssv_motion_t;

ssv_phase_context_t ssv_transfer_context(const ssv_question_t* question, int contact, real_t height_m);

/// The transit to where a transfer begins, as far as the same grasp goes.
ssv_phase_context_t ssv_transit_context(const ssv_phase_context_t* transfer, const pose_t* X_to);

/// Attitudes of a decision: as the flight starts and ends, and where the first turn begins and the last one ends.
typedef struct {
    quat_t q_IT[SSV_NUM_ENDS], q_IS[SSV_NUM_ENDS];
} ssv_attitudes_t;

/// Attitudes for a flight by displacement_I [m]: the vehicle flies in the direction n_S whatever else changes. The ends
/// of a transfer follow from how it travels: the smallest turns that bring the beam's axis from where it lies and on to
/// where it docks, and the spins. If the ring angle is given, the first turn begins there instead.
void ssv_decision_attitudes(const ssv_phase_context_t* context, const ssv_decision_t* decision, vec3_t displacement_I,
                            ssv_attitudes_t* attitudes);

/// The motion of a decision: turn about a pivot, fly on while turning from one attitude of travel to the other, turn
/// about a pivot, and approach straight, if asked for.
void ssv_decision_motion(const ssv_phase_context_t* context, const ssv_decision_t* decision, ssv_motion_t* motion);

/// Whether the motion keeps the margin; if not, *clearance says where it does so least, roughly.
bool ssv_motion_keeps_clear(const ssv_phase_context_t* context, const ssv_motion_t* motion, ssv_clearance_t* clearance);

/// Whether its motion does.
bool ssv_decision_keeps_clear(const ssv_phase_context_t* context, const ssv_decision_t* decision);

/// Where the motion of a decision begins.
pose_t ssv_decision_start(const ssv_phase_context_t* context, const ssv_decision_t* decision);

/// A price of decisions that the thrusters cannot make: no vehicle that ssv_problem_init accepts has one.
#define SSV_NO_PRICE (REAL_MAX / 64)

/// Estimated price of a decision, with that of the transit before it if there is one. Counts it.
real_t ssv_decision_price(ssv_phase_context_t* context, const ssv_decision_t* decision);

/// The same transfer with the vehicle the other way up: rolled half a turn about its contact axis.
ssv_decision_t ssv_other_way_up(const ssv_decision_t* transfer);

/// The attitude in which two unit vectors of the body, a_S and b_S, point along a_I and, as well as may be, towards
/// b_I.
quat_t ssv_attitude(vec3_t a_S, vec3_t b_S, vec3_t a_I, vec3_t b_I);

/// An attitude turned on by a rotation, given like the free ones, in axes of the body.
quat_t ssv_turned_by(quat_t q, vec3_t rotation);

/// Half the rotation that q is the shorter way round, given like the free ones.
vec3_t ssv_half_of(quat_t q);

/// A spin about the unit vector axis: number `spin` of SSV_NUM_SPINS, and x more.
quat_t ssv_spin(vec3_t axis, int spin, real_t x);

/// How the beam is held if a transfer begins with the vehicle at X_IS.
ssv_grasp_t ssv_phase_grasp(const ssv_phase_context_t* context, const pose_t* X_IS);

#endif
