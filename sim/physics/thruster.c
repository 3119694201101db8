#include "thruster.h"

#include <math.h>
#include <string.h>

void sim_thruster_init(sim_thruster_bank_t* bank, const sim_thruster_config_t* config, uint64_t seed, uint64_t stream) {
    sim_random_t random;
    sim_random_init(&random, seed, stream);
    memset(bank, 0, sizeof *bank);
    bank->config = *config;
    for (int t = 0; t < SIM_THRUSTERS; t++) {
        const double drawn = 2 * sim_random_uniform(&random) - 1;
        bank->gain[t] = 1 + config->gain_error[t] + config->gain_spread * drawn;
    }
}

double sim_curve_force(const sim_curve_t* curve, double effort) {
    const int last = curve->num_points - 1;
    double force_N = curve->force_N[last];
    if (effort <= curve->effort[0]) {
        force_N = curve->force_N[0];
    } else if (effort < curve->effort[last]) {
        int i = 0;
        while (effort >= curve->effort[i + 1]) {
            i++;
        }
        const double share = (effort - curve->effort[i]) / (curve->effort[i + 1] - curve->effort[i]);
        force_N = curve->force_N[i] + share * (curve->force_N[i + 1] - curve->force_N[i]);
    }
    return curve->voltage_ratio > 0 ? force_N * pow(curve->voltage_ratio, curve->voltage_exponent) : force_N;
}

static double target_of(const sim_thruster_config_t* config, double gain, double command) {
    if (config->quantum > 0) {
        command = config->quantum * round(command / config->quantum);
    }
    if (fabs(command) <= config->dead_band) {
        return 0;
    }
    double force_N = gain * (config->curve.num_points > 0 ? sim_curve_force(&config->curve, command) : command);
    if (config->force_forward_max_N > 0) {
        force_N = fmin(force_N, config->force_forward_max_N);
    }
    if (config->force_reverse_max_N > 0) {
        force_N = fmax(force_N, -config->force_reverse_max_N);
    }
    return force_N;
}

void sim_thruster_command(sim_thruster_bank_t* bank, const double command[SIM_THRUSTERS]) {
    for (int t = 0; t < SIM_THRUSTERS; t++) {
        bank->target_N[t] = target_of(&bank->config, bank->gain[t], command[t]);
    }
}

void sim_thruster_force(const sim_thruster_bank_t* bank, double after_s, double force_N[SIM_THRUSTERS]) {
    const double left = bank->config.lag_s > 0 ? exp(-after_s / bank->config.lag_s) : 0;
    for (int t = 0; t < SIM_THRUSTERS; t++) {
        force_N[t] = bank->target_N[t] + left * (bank->force_N[t] - bank->target_N[t]);
    }
}

void sim_thruster_step(sim_thruster_bank_t* bank, double dt_s) { sim_thruster_force(bank, dt_s, bank->force_N); }
