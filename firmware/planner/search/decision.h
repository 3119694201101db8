/// A trial: one choice of everything that is free in a phase, and the motion that it amounts to (DESIGN.md 6).
#ifndef SSV_DECISION_H
#define SSV_DECISION_H

#include "planner/motion/path.h"

/// Where a flight starts and where it ends.
#define SSV_NUM_ENDS 2
/// Flights shorter than this have no direction.
#define SSV_NO_WAY_M REAL(1e-6)
/// Spins that a search starts from, evenly all round. Their number is odd: half a turn could as well go the other way.
#define SSV_NUM_SPINS 5

/// A phase's free numbers x. The vehicle travels with attitude q_IT TURN TWIST^-+1 as the flight starts and ends. A
/// transfer has more: by how much the vehicle rolls about its contact axis, the spins about the beam's axis as it lies
/// and as it docks that the turns at both ends make besides what they must, and the pivots of these turns in S [m]. A
/// rotation is given by twice the tangent of half its angle, which is about the angle [rad] and takes no sines.
enum {
    SSV_X_TURN = 0,
    SSV_X_TWIST = 3,
    SSV_NUM_TRANSIT = 6,
    SSV_X_MATE_ROLL = 6,
    SSV_X_SPIN = 7,
    SSV_X_PIVOT = 9,
    SSV_NUM_TRANSFER = 15
};

typedef struct {
    quat_t q_IT;            ///< vehicle in the middle of the flight, before TURN
    vec3_t n_S;             ///< the direction of the body in which it flies, before TURN
    vec3_t axis_S;          ///< of a transfer: the beam's z axis as the vehicle holds it, across x, before MATE_ROLL
    int spin[SSV_NUM_ENDS]; ///< of a transfer: in [0, SSV_NUM_SPINS), how far it spins before SPIN
    real_t x[SSV_NUM_TRANSFER];
} ssv_decision_t;

/// One phase, for one contact and height.
typedef struct {
    const ssv_question_t* question;
    ssv_phase_t phase;
    int contact;
    real_t height_m;             ///< [m] attach height along z_B
    vec3_t hold_I[SSV_NUM_ENDS]; ///< [m] of a transfer: where the beam's axis is held at the ends; else where the
                                 ///< vehicle is
    union {
        struct {
            quat_t q_IS[SSV_NUM_ENDS]; ///< the vehicle at the ends
        } transit;
        struct {
            vec3_t axis_I[SSV_NUM_ENDS]; ///< the beam's z axis as it lies, and when it has docked
            quat_t
                q_given; ///< vehicle that mates at the ring angle, if that is given, and holds the beam's axis along +y
        } transfer;
    };
    const ssv_decision_t* before; ///< the transit that a transfer's price shall include, or NULL
    real_t closeness;             ///< of estimates, see ssv_profile_estimate; roughly until set
    int num_priced;               ///< trials so far
} ssv_phase_context_t;

/// What a trial amounts to.
typedef struct {
    ssv_assembly_t assembly; ///< what moves
    pose_t X_from;           ///< vehicle where it begins
    ssv_maneuver_t maneuver[SSV_MAX_PHASE_MANEUVERS];
} ssv_motion_t;

ssv_phase_context_t ssv_transfer_context(const ssv_question_t* question, int contact, real_t height_m);

/// The flight to where a transfer begins, as far as the same grasp goes.
ssv_phase_context_t ssv_transit_context(const ssv_phase_context_t* transfer, const pose_t* X_to);

/// Attitudes of a trial: as the flight starts and ends, and where the first turn begins and the last one ends.
typedef struct {
    quat_t q_IT[SSV_NUM_ENDS], q_IS[SSV_NUM_ENDS];
} ssv_attitudes_t;

/// Attitudes for a flight along way [m]: the vehicle flies in the direction n_S whatever else changes. The ends of a
/// transfer follow from how it travels: the smallest turns that bring the beam's axis from where it lies and on to
/// where it docks, and the spins. If the ring angle is given, the first turn begins there instead.
void ssv_decision_attitudes(const ssv_phase_context_t* context, const ssv_decision_t* decision, vec3_t way,
                            ssv_attitudes_t* attitudes);

/// The attitude in which two unit vectors of the body, a_S and b_S, point along a_I and, as well as may be, towards
/// b_I.
quat_t ssv_attitude(vec3_t a_S, vec3_t b_S, vec3_t a_I, vec3_t b_I);

/// An attitude turned on by a rotation, given like those of x, in axes of the body.
quat_t ssv_turned_by(quat_t q, vec3_t rotation);

/// Half the rotation that q is the shorter way round, given like those of x.
vec3_t ssv_half_of(quat_t q);

/// A spin about the unit vector axis, and x more.
quat_t ssv_spin(vec3_t axis, int spin, real_t x);

/// The motion of a trial: turn about a pivot, fly on while turning from one travel attitude to the other, turn about a
/// pivot.
void ssv_decision_motion(const ssv_phase_context_t* context, const ssv_decision_t* decision, ssv_motion_t* motion);

/// How the beam is held if a transfer begins with the vehicle at X_IS.
ssv_grasp_t ssv_phase_grasp(const ssv_phase_context_t* context, const pose_t* X_IS);

#endif
