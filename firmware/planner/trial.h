/// A trial: one choice of everything that is free in a phase, and the motion that it amounts to (DESIGN.md 6).
#ifndef SSV_TRIAL_H
#define SSV_TRIAL_H

#include "planner/chain.h"

/// Where a flight starts and where it ends.
#define SSV_NUM_ENDS 2
/// Flights shorter than this have no direction.
#define SSV_NO_WAY_M REAL(1e-6)

/// A phase's free numbers x. The vehicle travels with attitude q_IT exp(TURN -+ TWIST) as the flight starts and ends. A transfer
/// has more: the vehicle's roll about its contact axis, the spins about the beam's axis as it lies and as it docks that the
/// turns at both ends make besides what they must, and the pivots of these turns in S [m]. Rotations are in rad.
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
    quat_t q_IT;                 ///< vehicle in the middle of the flight, before TURN
    vec3_t n_S;                  ///< the direction of the body in which it flies, before TURN
    real_t x[SSV_NUM_TRANSFER];
} ssv_trial_t;

/// One phase, for one contact and height.
typedef struct {
    const ssv_problem_t* problem;
    ssv_phase_t phase;
    int contact;
    real_t height_m;             ///< [m] attach height along z_B
    pose_t X_from, X_to;         ///< ends of the transit; those of a transfer are its trials' to choose
    const ssv_trial_t* transit;  ///< what a transfer's price shall include, or NULL
    int num_priced;              ///< trials so far
} ssv_task_t;

/// What a trial amounts to.
typedef struct {
    ssv_assembly_t assembly;     ///< what moves
    pose_t X_from;               ///< vehicle where the flight begins
    ssv_grasp_t grasp;           ///< of a transfer
    ssv_flight_t flight;
} ssv_motion_t;

/// The attitude in which two unit vectors of the body, a_S and b_S, point along a_I and, as well as may be, towards b_I.
quat_t ssv_attitude(vec3_t a_S, vec3_t b_S, vec3_t a_I, vec3_t b_I);

/// An attitude turned on by a rotation vector [rad] in axes of the body.
quat_t ssv_turned_by(quat_t q, vec3_t rotation);

/// The beam's z axis: as the vehicle holds it, as it lies, and when it has docked.
vec3_t ssv_beam_axis_S(real_t mate_roll);
vec3_t ssv_beam_axis_start(const ssv_task_t* task);
vec3_t ssv_beam_axis_end(const ssv_task_t* task);

/// Attitudes as the flight starts and ends, for a flight along way [m]: the vehicle flies in the direction n_S whatever else changes.
void ssv_travel_attitudes(const ssv_trial_t* trial, vec3_t way, quat_t q_IT[SSV_NUM_ENDS]);

/// Attitudes where the first turn begins and the last one ends. Those of a transfer follow from how it travels: the smallest
/// turns that bring the beam's axis from where it lies and on to where it docks, and the spins. If the ring angle is given, the
/// first turn begins there instead.
void ssv_trial_ends(const ssv_task_t* task, const ssv_trial_t* trial, const quat_t q_IT[SSV_NUM_ENDS], quat_t q_IS[SSV_NUM_ENDS]);

/// Where the beam's axis is taken hold of as it lies, and where that place is when it has docked.
void ssv_hold_points(const ssv_task_t* task, vec3_t p_I[SSV_NUM_ENDS]);

/// Where the vehicle stands at both ends of a transfer, p_IS [m].
void ssv_stands(const ssv_task_t* task, const vec3_t hold_I[SSV_NUM_ENDS], const quat_t q_IS[SSV_NUM_ENDS], vec3_t p_IS[SSV_NUM_ENDS]);

/// The motion of a trial: turn about a pivot, fly on while turning from one travel attitude to the other, turn about a pivot. Its
/// flight is laid out, not priced.
void ssv_trial_lay(const ssv_task_t* task, const ssv_trial_t* trial, ssv_motion_t* motion);

#endif
