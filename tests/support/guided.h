/// Flies the core's plans closed loop as the vehicle would: the executive on this side of the link, the controller on
/// the other, sim/physics below, whose truth judges. All in one process and in virtual time.
#ifndef TESTS_GUIDED_H
#define TESTS_GUIDED_H

#include "sil/sil.h"
#include "ssv/executive.h"

/// Sees every frame between the two ends. @return whether it gets through.
typedef bool (*guided_line_t)(void* context, bool up, int64_t now_us, const uint8_t* frame, size_t length);

/// What disturbs a flight; all zero is nominal.
typedef struct {
    double wander_m_s;  ///< Gauss-Markov current per axis, 60 s
    double gain_spread; ///< of each thruster
    double lag_s, known_lag_s;
    double rate_Hz, position_m, attitude_rad, delay_s, dropout; ///< navigation
    double dead_band_N;
    bool open_loop;
    guided_line_t line; ///< NULL passes all
    void* context;
} conditions_t;

typedef struct {
    ssv_executive_outcome_t outcome;
    ssv_link_reason_t reason;
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

/// The simulated vehicle that such a flight takes.
void guided_configure(const ssv_problem_t* problem, const ssv_plan_t* plan, double force_max_N,
                      const conditions_t* conditions, sil_config_t* config);

/// Flies until the executive says how it ended. The limit is what each thruster really gives. False when the simulator
/// or the executive does not take the task.
bool guided_flight(const ssv_problem_t* problem, const ssv_plan_t* plan, double force_max_N,
                   const conditions_t* conditions, uint64_t seed, flown_t* flown);

#endif
