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

/// What moves, and who watches it.
typedef struct {
    rb_craft_t craft;
    rb_state_t state;
    bool is_carried;
    rb_pose_t X_SB; ///< once the beam is carried
    double t_s;
    sim_watch_t watch;
} flyer_t;

static void look(flyer_t* flyer, const plan_file_t* plan) {
    const rb_pose_t X_IB = flyer->is_carried ? rb_compose(&flyer->state.eta, &flyer->X_SB) : plan->X_IB;
    sim_watch_look(&flyer->watch, flyer->t_s, &flyer->state.eta, &X_IB, flyer->is_carried);
}

static void fly_segment(const plan_file_t* plan, const plan_segment_t* segment, double step_s, flyer_t* flyer) {
    double tau_start[6], tau_end[6], from[6], to[6];
    rb_thrust(PLAN_THRUSTERS, plan->thruster, segment->u_start_N, tau_start);
    rb_thrust(PLAN_THRUSTERS, plan->thruster, segment->u_end_N, tau_end);
    const double steps = fmax(ceil(segment->duration_s / step_s), 1);
    for (double k = 0; k < steps; k++) {
        for (int i = 0; i < 6; i++) {
            from[i] = tau_start[i] + k / steps * (tau_end[i] - tau_start[i]);
            to[i] = tau_start[i] + (k + 1) / steps * (tau_end[i] - tau_start[i]);
        }
        rb_step(&flyer->craft, &flyer->state, from, to, segment->duration_s / steps);
        flyer->t_s += segment->duration_s / steps;
        look(flyer, plan);
    }
}

void replay_fly(const plan_file_t* plan, double step_s, replay_flight_t* flight) {
    memset(flight, 0, sizeof *flight);
    flyer_t flyer;
    memset(&flyer, 0, sizeof flyer);
    rb_craft_alone(&flyer.craft, &plan->vehicle);
    flyer.state.eta = plan->X_IS;
    sim_watch_init(&flyer.watch, &plan->around);
    look(&flyer, plan);
    for (size_t s = 0; s <= plan->num_segments; s++) {
        if (s == plan->num_transit_segments) {
            flight->mate = arrival_at_mate(plan, &flyer.state);
            flyer.X_SB = rb_take_hold(&flyer.craft, &flyer.state, &plan->beam, &plan->X_IB);
            flyer.is_carried = true;
            look(&flyer, plan);
        }
        if (s < plan->num_segments) {
            fly_segment(plan, &plan->segment[s], step_s, &flyer);
        }
    }
    flight->dock = arrival_at_dock(plan, &flyer.state, &flyer.X_SB);
    flight->vehicle_end = flyer.state.eta;
    flight->beam_end = rb_compose(&flyer.state.eta, &flyer.X_SB);
    flight->nearest = flyer.watch.nearest;

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
