#include "navigation.h"

#include <math.h>
#include <string.h>

/// Times are sums of steps and round; what is due within this is due now.
#define TIME_TOLERANCE_S 1e-6

void sim_navigation_init(sim_navigation_t* navigation, const sim_navigation_config_t* config, uint64_t seed,
                         uint64_t stream) {
    memset(navigation, 0, sizeof *navigation);
    navigation->config = *config;
    sim_random_init(&navigation->random, seed, stream);
}

/// Lets the walk go on for elapsed_s and gives the error of one quantity now.
static void error_of(sim_random_t* random, const sim_error_t* config, double walk[3], double elapsed_s,
                     double error[3]) {
    for (int i = 0; i < 3; i++) {
        walk[i] += config->walk_sqrt_s * sqrt(elapsed_s) * sim_random_gauss(random);
        error[i] = config->bias[i] + walk[i] + config->white * sim_random_gauss(random);
    }
}

/// The attitude q, turned by the rotation vector about axes of {b}.
static void turn(const rb_pose_t* eta, const double vector_b[3], double q[4]) {
    const double angle = sqrt(vector_b[0] * vector_b[0] + vector_b[1] * vector_b[1] + vector_b[2] * vector_b[2]);
    const double per_rad = angle > 0 ? sin(angle / 2) / angle : 0.5;
    const rb_pose_t error = {{0, 0, 0},
                             {cos(angle / 2), per_rad * vector_b[0], per_rad * vector_b[1], per_rad * vector_b[2]}};
    const rb_pose_t turned = rb_compose(eta, &error);
    memcpy(q, turned.q, sizeof turned.q);
}

static void spoil(sim_navigation_t* navigation, double elapsed_s, rb_state_t* state) {
    const sim_navigation_config_t* config = &navigation->config;
    double position[3], attitude[3], velocity[3], rate[3];
    error_of(&navigation->random, &config->position_m, navigation->walk[0], elapsed_s, position);
    error_of(&navigation->random, &config->attitude_rad, navigation->walk[1], elapsed_s, attitude);
    error_of(&navigation->random, &config->velocity_m_s, navigation->walk[2], elapsed_s, velocity);
    error_of(&navigation->random, &config->rate_rad_s, navigation->walk[3], elapsed_s, rate);
    for (int i = 0; i < 3; i++) {
        state->eta.p_m[i] += position[i];
        state->nu[i] += velocity[i];
        state->nu[3 + i] += rate[i];
    }
    if (attitude[0] != 0 || attitude[1] != 0 || attitude[2] != 0) {
        turn(&state->eta, attitude, state->eta.q);
    }
}

void sim_navigation_observe(sim_navigation_t* navigation, double t_s, const rb_state_t* truth) {
    if (t_s < navigation->next_s - TIME_TOLERANCE_S) {
        return;
    }
    const double rate_Hz = navigation->config.rate_Hz;
    if (rate_Hz > 0) {
        navigation->next_s = (floor((t_s + TIME_TOLERANCE_S) * rate_Hz) + 1) / rate_Hz;
    }
    sim_measurement_t measurement = {t_s, navigation->number++, *truth};
    spoil(navigation, t_s - navigation->walked_s, &measurement.state);
    navigation->walked_s = t_s;
    if (sim_random_uniform(&navigation->random) < navigation->config.dropout) {
        return;
    }
    if (navigation->num_under_way == SIM_UNDER_WAY) { // nobody takes them: the oldest is of least use
        navigation->first = (navigation->first + 1) % SIM_UNDER_WAY;
        navigation->num_under_way--;
    }
    navigation->under_way[(navigation->first + navigation->num_under_way++) % SIM_UNDER_WAY] = measurement;
}

bool sim_navigation_take(sim_navigation_t* navigation, double t_s, sim_measurement_t* measurement) {
    const sim_measurement_t* oldest = &navigation->under_way[navigation->first];
    if (navigation->num_under_way == 0 || oldest->t_s + navigation->config.delay_s > t_s + TIME_TOLERANCE_S) {
        return false;
    }
    *measurement = *oldest;
    navigation->first = (navigation->first + 1) % SIM_UNDER_WAY;
    navigation->num_under_way--;
    return true;
}
