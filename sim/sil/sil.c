#include "sil.h"

#include <math.h>
#include <string.h>

// Efforts this much above the dead band's edge give thrust: a float's worth.
#define EDGE_RATIO (1 + 1e-6)
// What the thrusters have above what plans ask for.
#define THRUST_RATIO 1.25

// One direction of the simulator's curve, from the dead band's edge on.
static void invert(const sim_thruster_config_t* thrusters, double sign, ssv_thrust_branch_t* branch) {
    const sim_curve_t* curve = &thrusters->curve;
    sim_curve_t nominal = *curve;
    nominal.voltage_ratio = 0;
    double edge = thrusters->dead_band * EDGE_RATIO;
    branch->num_points = 0;
    for (int k = 0; k < curve->num_points; k++) { // from the middle outwards
        const double effort = sign * curve->effort[sign > 0 ? k : curve->num_points - 1 - k];
        if (effort <= 0 || effort <= edge || branch->num_points + 1 >= SSV_THRUST_MAX_POINTS) continue;
        if (branch->num_points == 0) {
            edge = fmax(edge, 1e-6);
            branch->effort[0] = (float)edge;
            branch->force_N[0] = (float)fmax(0, sign * sim_curve_force(&nominal, sign * edge));
            branch->num_points = 1;
        }
        branch->effort[branch->num_points] = (float)effort;
        branch->force_N[branch->num_points++] = (float)(sign * sim_curve_force(&nominal, sign * effort));
    }
}

// Without a curve commands are newtons: the dead band is then one of newtons, too.
static void set_curves(ssv_vehicle_config_t* config, const sim_thruster_config_t* thrusters, double thrust_max_N) {
    for (int t = 0; t < SIM_THRUSTERS; t++) {
        ssv_thrust_branch_t* branch[2] = {&config->curve[t].forward, &config->curve[t].reverse};
        for (int b = 0; b < 2; b++) {
            if (thrusters->curve.num_points > 0) {
                invert(thrusters, b == 0 ? 1 : -1, branch[b]);
            } else if (thrusters->dead_band > 0) {
                const double edge_N = thrusters->dead_band * EDGE_RATIO;
                branch[b]->num_points = 2;
                branch[b]->effort[0] = (float)(edge_N / thrust_max_N);
                branch[b]->effort[1] = 1;
                branch[b]->force_N[0] = (float)edge_N;
                branch[b]->force_N[1] = (float)thrust_max_N;
            }
        }
    }
}

// The inverse of the matrix of wrenches, by Gauss and Jordan with pivots. @return whether there is one.
static bool set_allocation(ssv_vehicle_config_t* config, const rb_thruster_t thruster[SIM_THRUSTERS]) {
    double a[6][12] = {{0}};
    for (int t = 0; t < 6; t++) {
        double moment[3];
        rb_cross(thruster[t].r_m, thruster[t].n, moment);
        for (int i = 0; i < 3; i++) {
            a[i][t] = thruster[t].n[i];
            a[3 + i][t] = moment[i];
        }
        a[t][6 + t] = 1;
    }
    for (int c = 0; c < 6; c++) {
        int pivot = c;
        for (int r = c + 1; r < 6; r++) {
            if (fabs(a[r][c]) > fabs(a[pivot][c])) pivot = r;
        }
        if (fabs(a[pivot][c]) < 1e-9) return false;
        for (int k = 0; k < 12; k++) {
            const double swapped = a[c][k];
            a[c][k] = a[pivot][k];
            a[pivot][k] = swapped;
        }
        for (int k = 11; k >= c; k--) a[c][k] /= a[c][c];
        for (int r = 0; r < 6; r++) {
            for (int k = 11; r != c && k >= c; k--) a[r][k] -= a[r][c] * a[c][k];
        }
    }
    for (int t = 0; t < 6; t++) {
        for (int i = 0; i < 6; i++) config->u_per_wrench[t][i] = (float)a[t][6 + i];
    }
    return true;
}

static void look(sil_t* sil) {
    const sim_world_t* world = &sil->world;
    if (world->beam == SIM_BEAM_DOCKED) return;
    sim_watch_look(&sil->watch, world->t_s, &world->state.eta, &world->X_nB, world->beam == SIM_BEAM_CARRIED);
}

const char* sil_init(sil_t* sil, const sil_config_t* config, uint64_t seed) {
    memset(sil, 0, sizeof *sil);
    const char* fault = sim_world_init(&sil->world, &config->world, seed);
    if (fault != NULL) return fault;
    sil->place = config->place;
    sil->port = config->port;
    sim_watch_init(&sil->watch, &config->around);
    look(sil);
    ssv_vehicle_config_default(&sil->config, config->boot_id);
    sil->config.link.sign = config->sign;
    sil->config.link.signing = config->signing;
    sil->config.link.force_max_N = (float)config->force_max_N;
    sil->config.thrust_max_N = (float)(THRUST_RATIO * config->force_max_N);
    set_curves(&sil->config, &config->world.thrusters, (double)sil->config.thrust_max_N);
    if (!set_allocation(&sil->config, config->world.thruster)) return "thruster: together they must give every wrench";
    if (!ssv_vehicle_init(&sil->vehicle, &sil->config)) return "thrusters: the curve has no inverse";
    const sim_curve_t* curve = &config->world.thrusters.curve;
    if (curve->voltage_ratio > 0)
        ssv_vehicle_supply(&sil->vehicle, (float)pow(curve->voltage_ratio, curve->voltage_exponent));
    return NULL;
}

static void navigate(sil_t* sil) {
    sim_measurement_t measurement;
    while (sim_world_measurement(&sil->world, &measurement)) {
        const rb_state_t* state = &measurement.state;
        double v_n[3];
        ssv_link_pose_t pose = {.known = true};
        rb_rotate(state->eta.q, state->nu, v_n);
        for (int i = 0; i < 3; i++) {
            pose.p_IS_m[i] = (float)state->eta.p_m[i];
            pose.v_IS_m_s[i] = (float)v_n[i];
            pose.w_IS_S_rad_s[i] = (float)state->nu[3 + i];
        }
        for (int i = 0; i < 4; i++) pose.q_IS[i] = (float)state->eta.q[i];
        ssv_vehicle_navigate(&sil->vehicle, (int64_t)(1e6 * measurement.t_s + 0.5), &pose);
    }
}

void sil_step(sil_t* sil) {
    double command[SIM_THRUSTERS];
    navigate(sil);
    ssv_vehicle_tick(&sil->vehicle, sil->now_us, &sil->output);
    // Ideal thrusters take newtons, as they are: the rounding of an effort alone would turn an unstable pair.
    const float* command_of = sil->world.config.thrusters.curve.num_points > 0 ? sil->output.effort : sil->output.u_N;
    for (int t = 0; t < SIM_THRUSTERS; t++) command[t] = sil->output.is_armed ? (double)command_of[t] : 0;
    sim_world_step(&sil->world, command, SIL_TICK_S);
    sil->now_us += SSV_VEHICLE_TICK_US;
    look(sil);
    if (!sil->output.attempts) return;
    const ssv_event_kind_t kind = sil->output.event.kind;
    sil->attempt[kind] =
        kind == SSV_MATE ? sim_world_mate(&sil->world, &sil->place) : sim_world_dock(&sil->world, &sil->port);
    sil->num_attempts[kind]++;
    ssv_vehicle_attempted(&sil->vehicle, sil->now_us, sil->attempt[kind].outcome == SIM_HIT);
}
