/// Flies the core's plans closed loop: guidance on sim/physics, whose truth judges.
#ifndef TESTS_GUIDED_H
#define TESTS_GUIDED_H

#include "physics/world.h"
#include "ssv/guidance.h"

/// What disturbs a flight; all zero is nominal.
typedef struct {
    double wander_m_s;  ///< Gauss-Markov current per axis, 60 s
    double gain_spread; ///< of each thruster
    double lag_s, known_lag_s;
    double rate_Hz, position_m, attitude_rad, delay_s, dropout; ///< navigation
    double dead_band_N;
    bool open_loop;
} conditions_t;

typedef struct {
    ssv_guidance_state_t state; ///< at the end
    int num_attempts;
    bool mated, docked;
    sim_arrival_t mate, dock; ///< of the last attempts, by truth
    double time_s, impulse_Ns;
    double time_mate_s;
    double across_most_m, lag_most_m;
    double grasp_rad;                        ///< error of the estimated beam attitude in the vehicle's frame
    double estimate_tip_m;                   ///< where guidance took the tip to be at the dock
    double position_rms_m, attitude_rms_rad; ///< of the estimate while it dwells at the dock, per axis
} flown_t;

/// Flies for at most twice the plan's time and 600 s. The limit is what each thruster really gives.
void guided_flight(const ssv_problem_t* problem, const ssv_plan_t* plan, double force_max_N,
                   const conditions_t* conditions, uint64_t seed, flown_t* flown);

#endif
