/// Navigation: what the vehicle is told of its pose and twist, with noise, bias, delay and drop-outs.
#ifndef SIM_NAVIGATION_H
#define SIM_NAVIGATION_H

#include <stdbool.h>

#include "random.h"
#include "rigid_body.h"

/// Measurements under way at once: rate_Hz * delay_s must stay below.
#define SIM_UNDER_WAY 128

/// Error of one quantity, per axis, in its unit.
typedef struct {
    double white;       ///< standard deviation, fresh with each measurement
    double bias[3];     ///< constant
    double walk_sqrt_s; ///< standard deviation that a random walk from 0 has after one second
} sim_error_t;

/// All zero: the truth with every step, at once.
typedef struct {
    double rate_Hz;           ///< 0: a measurement with every step
    double delay_s;           ///< from the moment it holds for to its arrival; needs a rate
    double dropout;           ///< probability that a measurement never arrives
    sim_error_t position_m;   ///< in {n}
    sim_error_t attitude_rad; ///< a small turn about the axes of {b}
    sim_error_t velocity_m_s; ///< in {b}
    sim_error_t rate_rad_s;   ///< in {b}
} sim_navigation_config_t;

typedef struct {
    double t_s;       ///< the moment it holds for
    long long number; ///< from 0; numbers that never arrive were dropped
    rb_state_t state; ///< nu is over ground
} sim_measurement_t;

typedef struct {
    sim_navigation_config_t config;
    sim_random_t random;
    double walk[4][3]; ///< position, attitude, velocity, rate
    double walked_s;   ///< time of the walk's last step
    double next_s;     ///< when the next measurement is due
    long long number;  ///< and which one that is
    int first, num_under_way;
    sim_measurement_t under_way[SIM_UNDER_WAY];
} sim_navigation_t;

void sim_navigation_init(sim_navigation_t* navigation, const sim_navigation_config_t* config, uint64_t seed,
                         uint64_t stream);

/// Measures the truth at the time t_s, if a measurement is due. Times must not fall; the first is 0.
void sim_navigation_observe(sim_navigation_t* navigation, double t_s, const rb_state_t* truth);

/// Hands over the oldest measurement that has arrived at the time t_s, each one once.
/// @return false if there is none.
bool sim_navigation_take(sim_navigation_t* navigation, double t_s, sim_measurement_t* measurement);

#endif
