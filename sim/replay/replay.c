#include "replay.h"

#include <math.h>
#include <string.h>

#include "physics/contact.h"

#define DEG_PER_RAD 57.295779513082320877
#define COARSEST_STEP_S 0.02
#define HALVINGS 6

static double norm(const double a[3]) { return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }

static double distance(const double a[3], const double b[3]) {
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return norm(d);
}

static double turn_rad(const rb_pose_t* X_a, const rb_pose_t* X_b) {
    const rb_pose_t between = rb_relative(X_a, X_b);
    return 2 * atan2(norm(between.q + 1), fabs(between.q[0]));
}

static replay_arrival_t in_report_units(sim_arrival_t arrival) {
    const replay_arrival_t r = {1000 * arrival.position_m, DEG_PER_RAD * arrival.angle_rad, arrival.speed_m_s,
                                arrival.rate_rad_s};
    return r;
}

static replay_arrival_t arrival_at_mate(const plan_file_t* plan, const rb_state_t* vehicle) {
    const sim_mate_place_t place = {plan->standoff_m, plan->attach_height_m, plan->ring_angle_rad};
    return in_report_units(sim_arrival_at_mate(vehicle, &plan->X_IB, &place));
}

static replay_arrival_t arrival_at_dock(const plan_file_t* plan, const rb_state_t* vehicle, const rb_pose_t* X_SB) {
    sim_port_t port = {.contact = plan->contact};
    memcpy(port.p_nP_m, plan->p_IP_m, sizeof port.p_nP_m);
    memcpy(port.axis_n, plan->axis_I, sizeof port.axis_n);
    return in_report_units(sim_arrival_at_dock(vehicle, X_SB, plan->beam.length_m, &port));
}

/// Integral of |u| along a straight line from a to b: a trapezium, or two triangles when it crosses zero.
static double absolute_impulse(double a, double b, double duration_s) {
    const double sum = fabs(a) + fabs(b);
    return a * b >= 0 ? duration_s * sum / 2 : duration_s * (a * a + b * b) / (2 * sum);
}

static void fly_segment(const plan_file_t* plan, const plan_segment_t* segment, const rb_craft_t* craft, double step_s,
                        rb_state_t* state) {
    double tau_start[6], tau_end[6], from[6], to[6];
    rb_thrust(PLAN_THRUSTERS, plan->thruster, segment->u_start_N, tau_start);
    rb_thrust(PLAN_THRUSTERS, plan->thruster, segment->u_end_N, tau_end);
    const double steps = fmax(ceil(segment->duration_s / step_s), 1);
    for (double k = 0; k < steps; k++) {
        for (int i = 0; i < 6; i++) {
            from[i] = tau_start[i] + k / steps * (tau_end[i] - tau_start[i]);
            to[i] = tau_start[i] + (k + 1) / steps * (tau_end[i] - tau_start[i]);
        }
        rb_step(craft, state, from, to, segment->duration_s / steps);
    }
}

void replay_fly(const plan_file_t* plan, double step_s, replay_flight_t* flight) {
    memset(flight, 0, sizeof *flight);
    rb_craft_t craft;
    rb_craft_alone(&craft, &plan->vehicle);
    rb_state_t state = {plan->X_IS, {0}};
    rb_pose_t X_SB = {{0, 0, 0}, {1, 0, 0, 0}};
    for (size_t s = 0; s <= plan->num_segments; s++) {
        if (s == plan->num_transit_segments) {
            flight->mate = arrival_at_mate(plan, &state);
            X_SB = rb_take_hold(&craft, &state, &plan->beam, &plan->X_IB);
        }
        if (s < plan->num_segments) {
            fly_segment(plan, &plan->segment[s], &craft, step_s, &state);
        }
    }
    flight->dock = arrival_at_dock(plan, &state, &X_SB);
    flight->vehicle_end = state.eta;
    flight->beam_end = rb_compose(&state.eta, &X_SB);

    for (size_t s = 0; s < plan->num_segments; s++) {
        const plan_segment_t* segment = &plan->segment[s];
        flight->time_s += segment->duration_s;
        for (int i = 0; i < PLAN_THRUSTERS; i++) {
            const double a = segment->u_start_N[i], b = segment->u_end_N[i];
            flight->thrust_ratio = fmax(flight->thrust_ratio, fmax(fabs(a), fabs(b)) / plan->force_max_N);
            flight->impulse_Ns += absolute_impulse(a, b, segment->duration_s);
        }
    }
}

bool replay_fly_converged(const plan_file_t* plan, replay_flight_t* flight, double* step_s, double* halving_m,
                          double* halving_rad) {
    replay_flight_t coarse;
    *step_s = COARSEST_STEP_S;
    replay_fly(plan, *step_s, &coarse);
    for (int halving = 0; halving < HALVINGS; halving++) {
        *step_s /= 2;
        replay_fly(plan, *step_s, flight);
        *halving_m = fmax(distance(coarse.vehicle_end.p_m, flight->vehicle_end.p_m),
                          distance(coarse.beam_end.p_m, flight->beam_end.p_m));
        *halving_rad = turn_rad(&coarse.vehicle_end, &flight->vehicle_end);
        if (*halving_m < 1e-6 && *halving_rad < 1e-6) {
            return true;
        }
        coarse = *flight;
    }
    return false;
}
