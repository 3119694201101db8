#include "water.h"

#include <math.h>

bool sim_water_wanders(const sim_water_config_t* config) {
    return config->wander_m_s[0] > 0 || config->wander_m_s[1] > 0 || config->wander_m_s[2] > 0;
}

void sim_water_init(sim_water_t* water, const sim_water_config_t* config, uint64_t seed, uint64_t stream) {
    water->config = *config;
    sim_random_init(&water->random, seed, stream);
    for (int i = 0; i < 3; i++) {
        water->wander_n_m_s[i] = config->wander_m_s[i] * sim_random_gauss(&water->random);
    }
}

void sim_water_step(sim_water_t* water, double dt_s) {
    if (!sim_water_wanders(&water->config)) {
        return;
    }
    const double steps = dt_s / water->config.wander_time_s, kept = exp(-steps), fresh = sqrt(-expm1(-2 * steps));
    for (int i = 0; i < 3; i++) {
        const double kick = fresh * water->config.wander_m_s[i] * sim_random_gauss(&water->random);
        water->wander_n_m_s[i] = kept * water->wander_n_m_s[i] + kick;
    }
}

void sim_water_current(const sim_water_t* water, double current_n_m_s[3]) {
    for (int i = 0; i < 3; i++) {
        current_n_m_s[i] = water->config.mean_n_m_s[i] + water->wander_n_m_s[i];
    }
}
