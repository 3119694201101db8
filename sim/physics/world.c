#include "world.h"

#include <math.h>
#include <string.h>

/// Numbers of the random streams. Fixed, so that a seed means the same from version to version.
enum { STREAM_WATER = 1, STREAM_THRUSTERS = 2, STREAM_NAVIGATION = 3 };

static bool not_negative(const double* value, int count) {
    for (int i = 0; i < count; i++) {
        if (!(value[i] >= 0) || isinf(value[i])) {
            return false;
        }
    }
    return true;
}

static bool all_finite(const double* value, int count) {
    for (int i = 0; i < count; i++) {
        if (!isfinite(value[i])) {
            return false;
        }
    }
    return true;
}

static bool unit(const double* value, int count) {
    double square = 0;
    for (int i = 0; i < count; i++) {
        square += value[i] * value[i];
    }
    return fabs(square - 1) < 1e-6;
}

static const char* fault_of_body(const rb_body_t* body) {
    if (!(body->mass_kg > 0) || isinf(body->mass_kg)) {
        return "body: mass_kg must be above 0";
    }
    for (int i = 0; i < 3; i++) {
        if (!(body->inertia_kg_m2[i] > 0) || isinf(body->inertia_kg_m2[i])) {
            return "body: inertia_kg_m2 must be above 0";
        }
    }
    const double drag[6] = {body->drag_lin_kg_s,       body->drag_quad_kg_m, body->drag_lin_ang_Nm_s,
                            body->drag_quad_ang_Nm_s2, body->strip_kg_m2,    body->length_m};
    if (!not_negative(body->added_mass_kg, 3) || !not_negative(body->added_inertia_kg_m2, 3)) {
        return "body: added mass and added inertia must be 0 or more";
    }
    if (!not_negative(drag, 6)) {
        return "body: drag and length_m must be 0 or more";
    }
    if (!isfinite(body->net_weight_N) || !all_finite(body->centre_of_buoyancy_m, 3)) {
        return "body: net_weight_N and centre_of_buoyancy_m must be finite";
    }
    return NULL;
}

static const char* fault_of_water(const sim_water_config_t* config) {
    if (!all_finite(config->mean_n_m_s, 3) || !not_negative(config->wander_m_s, 3)) {
        return "water: the mean must be finite, wander_m_s 0 or more";
    }
    if (sim_water_wanders(config) && !(config->wander_time_s > 0)) {
        return "water: a current that wanders needs a wander_time_s above 0";
    }
    return NULL;
}

static const char* fault_of_thrusters(const sim_thruster_config_t* config) {
    const sim_curve_t* curve = &config->curve;
    const double sizes[6] = {config->quantum,
                             config->dead_band,
                             config->gain_spread,
                             config->force_forward_max_N,
                             config->force_reverse_max_N,
                             config->lag_s};
    if (!not_negative(sizes, 6) || !all_finite(config->gain_error, SIM_THRUSTERS)) {
        return "thrusters: quantum, dead_band, gain_spread, force limits and lag_s must be 0 or more, gain_error "
               "finite";
    }
    if (curve->num_points == 0) {
        return NULL;
    }
    if (curve->num_points < 2 || curve->num_points > SIM_CURVE_POINTS) {
        return "thrusters: a curve has 2 to 32 points";
    }
    for (int i = 0; i < curve->num_points; i++) {
        if (!isfinite(curve->force_N[i]) || !isfinite(curve->effort[i]) ||
            (i > 0 && curve->effort[i] <= curve->effort[i - 1])) {
            return "thrusters: the curve's efforts must rise, its forces be finite";
        }
    }
    if (!not_negative(&curve->voltage_ratio, 1) || !isfinite(curve->voltage_exponent)) {
        return "thrusters: voltage_ratio must be 0 or more, voltage_exponent finite";
    }
    return NULL;
}

static const char* fault_of_navigation(const sim_navigation_config_t* config) {
    const sim_error_t* error[4] = {&config->position_m, &config->attitude_rad, &config->velocity_m_s,
                                   &config->rate_rad_s};
    for (int i = 0; i < 4; i++) {
        if (!not_negative(&error[i]->white, 1) || !not_negative(&error[i]->walk_sqrt_s, 1) ||
            !all_finite(error[i]->bias, 3)) {
            return "navigation: white and walk_sqrt_s must be 0 or more, bias finite";
        }
    }
    if (!not_negative(&config->rate_Hz, 1) || !not_negative(&config->delay_s, 1)) {
        return "navigation: rate_Hz and delay_s must be 0 or more";
    }
    if (!(config->dropout >= 0 && config->dropout <= 1)) {
        return "navigation: dropout is a probability";
    }
    if (config->delay_s > 0 && !(config->rate_Hz > 0 && config->rate_Hz * config->delay_s < SIM_UNDER_WAY - 1)) {
        return "navigation: a delay needs a rate, and less than 127 measurements under way";
    }
    return NULL;
}

static const char* fault_of(const sim_world_config_t* config) {
    const char* fault = fault_of_body(&config->vehicle);
    fault = fault ? fault : fault_of_body(&config->beam);
    fault = fault ? fault : fault_of_water(&config->water);
    fault = fault ? fault : fault_of_thrusters(&config->thrusters);
    fault = fault ? fault : fault_of_navigation(&config->navigation);
    if (fault) {
        return fault;
    }
    if (!unit(config->X_nb.q, 4) || !unit(config->X_nB.q, 4) || !all_finite(config->X_nb.p_m, 3) ||
        !all_finite(config->X_nB.p_m, 3)) {
        return "poses: quaternions must be unit, positions finite";
    }
    if (!not_negative(&config->substep_max_s, 1)) {
        return "substep_max_s must be 0 or more";
    }
    for (int i = 0; i < SIM_THRUSTERS; i++) {
        if (!unit(config->thruster[i].n, 3) || !all_finite(config->thruster[i].r_m, 3)) {
            return "thruster: directions must be unit, positions finite";
        }
    }
    return NULL;
}

const char* sim_world_init(sim_world_t* world, const sim_world_config_t* config, uint64_t seed) {
    const char* fault = fault_of(config);
    if (fault) {
        return fault;
    }
    memset(world, 0, sizeof *world);
    world->config = *config;
    world->state.eta = config->X_nb;
    world->X_nB = config->X_nB;
    rb_craft_alone(&world->craft, &config->vehicle);
    sim_water_init(&world->water, &config->water, seed, STREAM_WATER);
    sim_thruster_init(&world->thrusters, &config->thrusters, seed, STREAM_THRUSTERS);
    sim_navigation_init(&world->navigation, &config->navigation, seed, STREAM_NAVIGATION);
    sim_navigation_observe(&world->navigation, 0, &world->state);
    return NULL;
}

static double sum_of_sizes(const double force_N[SIM_THRUSTERS]) {
    double sum = 0;
    for (int t = 0; t < SIM_THRUSTERS; t++) {
        sum += fabs(force_N[t]);
    }
    return sum;
}

void sim_world_step(sim_world_t* world, const double command[SIM_THRUSTERS], double dt_s) {
    const double longest_s = world->config.substep_max_s;
    const int substeps = longest_s > 0 ? (int)fmax(1, ceil(dt_s / longest_s - 1e-9)) : 1;
    const double substep_s = dt_s / substeps;
    double current_n_m_s[3], force_N[3][SIM_THRUSTERS], tau[3][6];
    sim_water_current(&world->water, current_n_m_s);
    sim_thruster_command(&world->thrusters, command);
    for (int k = 0; k < substeps; k++) {
        for (int i = 0; i < 3; i++) {
            sim_thruster_force(&world->thrusters, (k + i / 2.0) * substep_s, force_N[i]);
            rb_thrust(SIM_THRUSTERS, world->config.thruster, force_N[i], tau[i]);
        }
        rb_step_in_current(&world->craft, &world->state, (const double(*)[6])tau, current_n_m_s, substep_s);
        world->impulse_Ns +=
            substep_s / 6 * (sum_of_sizes(force_N[0]) + 4 * sum_of_sizes(force_N[1]) + sum_of_sizes(force_N[2]));
    }
    sim_thruster_step(&world->thrusters, dt_s);
    sim_water_step(&world->water, dt_s);
    world->t_s += dt_s;
    if (world->beam == SIM_BEAM_CARRIED) {
        world->X_nB = rb_compose(&world->state.eta, &world->X_bB);
    }
    sim_navigation_observe(&world->navigation, world->t_s, &world->state);
}

bool sim_world_measurement(sim_world_t* world, sim_measurement_t* measurement) {
    return sim_navigation_take(&world->navigation, world->t_s, measurement);
}

sim_attempt_t sim_world_mate(sim_world_t* world, const sim_mate_place_t* place) {
    sim_attempt_t attempt = {.outcome = SIM_OUT_OF_TURN, .t_s = world->t_s};
    if (world->beam != SIM_BEAM_WAITING) {
        return attempt;
    }
    attempt.arrival = sim_arrival_at_mate(&world->state, &world->X_nB, place);
    attempt.outcome = sim_arrival_within(&attempt.arrival, &world->config.mate_limit) ? SIM_HIT : SIM_MISS;
    if (attempt.outcome == SIM_HIT) {
        world->X_bB = rb_take_hold(&world->craft, &world->state, &world->config.beam, &world->X_nB);
        world->beam = SIM_BEAM_CARRIED;
    }
    return attempt;
}

sim_attempt_t sim_world_dock(sim_world_t* world, const sim_port_t* port) {
    sim_attempt_t attempt = {.outcome = SIM_OUT_OF_TURN, .t_s = world->t_s};
    if (world->beam != SIM_BEAM_CARRIED) {
        return attempt;
    }
    attempt.arrival = sim_arrival_at_dock(&world->state, &world->X_bB, world->config.beam.length_m, port);
    attempt.outcome = sim_arrival_within(&attempt.arrival, &world->config.dock_limit) ? SIM_HIT : SIM_MISS;
    if (attempt.outcome == SIM_HIT) {
        rb_craft_alone(&world->craft, &world->config.vehicle);
        memset(world->state.nu, 0, sizeof world->state.nu);
        world->beam = SIM_BEAM_DOCKED;
    }
    return attempt;
}
