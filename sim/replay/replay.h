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
    double thrust_ratio;   ///< largest |thrust| over force_max_N
    double impulse_Ns;     ///< integral of the sum of |thrust|
    double time_s;         ///< end of the timeline
    sim_nearest_t nearest; ///< how near vehicle and beam came to what stands around
    rb_pose_t vehicle_end, beam_end;
} replay_flight_t;

/// Flies with Runge-Kutta steps of at most step_s, which end on the borders of the segments. At the mate the beam joins
/// as it lies, errors and all, and takes its share of the momentum.
void replay_fly(const plan_file_t* plan, double step_s, replay_flight_t* flight);

/// Flies with half the step and half again, until that moves the end of the flight by less than 1e-6 m and 1e-6 rad.
/// @param[out] step_s the step of *flight; halving_m, halving_rad how far the last halving moved its end.
/// @return false if no step down to 0.0003 s is fine enough: time constants are too short, or the motion too unstable.
bool replay_fly_converged(const plan_file_t* plan, replay_flight_t* flight, double* step_s, double* halving_m,
                          double* halving_rad);

#endif
