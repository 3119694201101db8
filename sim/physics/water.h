/// The water's own motion: a uniform current, constant or wandering.
#ifndef SIM_WATER_H
#define SIM_WATER_H

#include <stdbool.h>

#include "random.h"

/// All zero: still water.
typedef struct {
    double mean_n_m_s[3]; ///< in {n}
    /// Along each axis of {n} a Gauss-Markov process of first order comes on top, with this standard deviation.
    double wander_m_s[3];
    double wander_time_s; ///< after which its correlation has fallen to 1/e; above 0 unless wander_m_s is all 0
} sim_water_config_t;

typedef struct {
    sim_water_config_t config;
    sim_random_t random;
    double wander_n_m_s[3];
} sim_water_t;

/// Whether the current changes in time.
bool sim_water_wanders(const sim_water_config_t* config);

/// Draws the start of the wandering from its stationary distribution.
void sim_water_init(sim_water_t* water, const sim_water_config_t* config, uint64_t seed, uint64_t stream);

/// Goes on by dt_s, exactly: the values at the steps are distributed alike whatever the steps are.
void sim_water_step(sim_water_t* water, double dt_s);

void sim_water_current(const sim_water_t* water, double current_n_m_s[3]);

#endif
