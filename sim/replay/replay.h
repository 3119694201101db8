/// Flies a plan open loop and measures, against the task, where vehicle and beam arrive.
#ifndef SIM_REPLAY_H
#define SIM_REPLAY_H

#include <stdbool.h>

#include "plan_file.h"

/// How far from the task the craft is when it should have arrived at rest.
typedef struct {
    double position_mm;
    double pointing_deg;
    double speed_m_s;
    double rate_rad_s;
} replay_arrival_t;

typedef struct {
    /// Vehicle against the mating place (at the standoff from the beam's axis, at the chosen height and ring angle, +x
    /// towards the axis, roll free), just before it takes hold.
    replay_arrival_t mate;
    /// Beam against the port (chosen contact point on it, outward axis there against the port's, roll free); the speed
    /// is the larger of that of the contact point and that of the vehicle.
    replay_arrival_t dock;
    double thrust_ratio;                         ///< largest |thrust| over force_max_N
    double impulse_Ns;                           ///< integral of the sum of |thrust|
    double time_s;                               ///< end of the timeline
    sim_nearest_t nearest;                       ///< how near vehicle and beam came to what stands around
    rb_state_t vehicle_at_mate, vehicle_at_dock; ///< just before it takes hold; at the end
    rb_pose_t beam_end;
    int64_t num_steps;          ///< that the run took
    double tolerance;           ///< [-] error of each of these
    double moved_m, turned_rad; ///< of the end, against a run with 32 times that
} replay_flight_t;

/// What the figures are judged by.
#define REPLAY_POSITION_MAX_MM 5.0
#define REPLAY_POINTING_MAX_DEG 0.5
#define REPLAY_SPEED_MAX_M_S 1e-4
#define REPLAY_RATE_MAX_RAD_S 1e-4

typedef enum {
    REPLAY_JUDGED,
    REPLAY_TOO_LONG, ///< it would take more than some 20 million steps: time constants too short for so long a flight
    REPLAY_TOO_UNSTABLE ///< the rounding of a double moves its end by too much: the motion is too unstable
} replay_end_t;

/// Who hears how far a flight is, now and then.
typedef struct {
    void (*told)(void* context, int run, double share);
    void* context;
} replay_listener_t;

/// What is otherwise than the plan takes it for, as factors: mass, inertia and added mass of both bodies; all their
/// drag; the force of each thruster.
typedef struct {
    double mass, drag, thruster[PLAN_THRUSTERS];
} replay_off_t;

/// Puts it into the plan, whose thrusts and claims stay.
void replay_put_off(const replay_off_t* off, plan_file_t* plan);

/// Flies with Runge-Kutta steps of controlled error, which end on the borders of the segments; then with a 32nd of that
/// error, and on until that moves no figure by more than a twentieth of its limit, but those far beyond it. At the mate
/// the beam joins as it lies, errors and all, and takes its share of the momentum. Takes half a minute at most. @param
/// listener may be NULL.
replay_end_t replay_fly(const plan_file_t* plan, const replay_listener_t* listener, replay_flight_t* flight);

#endif
