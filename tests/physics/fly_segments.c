// Flies a flight that judges outside describe, for them to compare: numbers on standard input, states on standard
// output.
//
// In, separated by white space: two bodies (20 numbers each, see read_body), whether they are joined (0 or 1), pose of
// the second in the first (7), 6 thrusters (position, direction: 36), pose and twist at the start (13), current (3),
// step of the integration [s], number of segments, and for each its duration [s] and 6 thrusts at its start and its
// end. Out: one line for each segment, pose and twist at its end (13 numbers).
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#include "physics/rigid_body.h"

static double next_number(void) {
    double value;
    if (scanf("%lf", &value) != 1) {
        fprintf(stderr, "fly_segments: a number is missing\n");
        exit(1);
    }
    return value;
}

static void read_numbers(double* out, int count) {
    for (int i = 0; i < count; i++) {
        out[i] = next_number();
    }
}

static rb_body_t read_body(void) {
    rb_body_t body;
    body.mass_kg = next_number();
    read_numbers(body.inertia_kg_m2, 3);
    read_numbers(body.added_mass_kg, 3);
    read_numbers(body.added_inertia_kg_m2, 3);
    body.drag_lin_kg_s = next_number();
    body.drag_quad_kg_m = next_number();
    body.drag_lin_ang_Nm_s = next_number();
    body.drag_quad_ang_Nm_s2 = next_number();
    body.strip_kg_m2 = next_number();
    body.length_m = next_number();
    body.net_weight_N = next_number();
    read_numbers(body.centre_of_buoyancy_m, 3);
    return body;
}

static rb_pose_t read_pose(void) {
    rb_pose_t pose;
    read_numbers(pose.p_m, 3);
    read_numbers(pose.q, 4);
    return pose;
}

static void fly_segment(const rb_craft_t* craft, const rb_thruster_t thruster[6], const double current_n_m_s[3],
                        double step_s, rb_state_t* state) {
    double u_start_N[6], u_end_N[6];
    const double duration_s = next_number();
    read_numbers(u_start_N, 6);
    read_numbers(u_end_N, 6);
    const int steps = (int)ceil(duration_s / step_s);
    for (int k = 0; k < steps; k++) {
        double tau[3][6];
        for (int i = 0; i < 3; i++) {
            const double share = (k + i / 2.0) / steps;
            double u_N[6];
            for (int t = 0; t < 6; t++) {
                u_N[t] = u_start_N[t] + share * (u_end_N[t] - u_start_N[t]);
            }
            rb_thrust(6, thruster, u_N, tau[i]);
        }
        rb_step_in_current(craft, state, (const double(*)[6])tau, current_n_m_s, duration_s / steps);
    }
}

int main(void) {
    const rb_body_t vehicle = read_body(), beam = read_body();
    const bool joined = next_number() != 0;
    const rb_pose_t X_bB = read_pose();
    rb_thruster_t thruster[6];
    for (int t = 0; t < 6; t++) {
        read_numbers(thruster[t].r_m, 3);
        read_numbers(thruster[t].n, 3);
    }
    rb_state_t state;
    state.eta = read_pose();
    read_numbers(state.nu, 6);
    double current_n_m_s[3];
    read_numbers(current_n_m_s, 3);
    const double step_s = next_number(), segments = next_number();

    rb_craft_t craft;
    if (joined) {
        rb_craft_joined(&craft, &vehicle, &beam, &X_bB);
    } else {
        rb_craft_alone(&craft, &vehicle);
    }
    for (int segment = 0; segment < segments; segment++) {
        fly_segment(&craft, thruster, current_n_m_s, step_s, &state);
        for (int i = 0; i < 13; i++) {
            const double value = i < 3 ? state.eta.p_m[i] : i < 7 ? state.eta.q[i - 3] : state.nu[i - 7];
            printf("%.17g%c", value, i < 12 ? ' ' : '\n');
        }
    }
    return fflush(stdout) == 0 ? 0 : 1;
}
