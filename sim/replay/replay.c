#include "replay.h"

#include <math.h>
#include <string.h>

#include "physics/contact.h"

#define DEG_PER_RAD 57.295779513082320877

// Error of a step [-]: metres, radians, and the same per second; of a position far from the origin relative to that.
// The first run has this one and each further run a 32nd, which halves the steps where they are bound by it. After the
// last run, doubles are too coarse to tell.
#define FIRST_TOLERANCE 1e-10
#define FINER 32
#define RUNS_MAX 4
// What the last refinement may still move a figure by, as a share of its limit.
#define SETTLED 0.05
// And where doubles allow no more of them, as a share of what the figure keeps from its limit.
#define CERTAIN 0.25
// Steps of all runs together: half a minute.
#define STEPS_MAX INT64_C(20000000)
// After so many, a run that will not come to its end with what is left is given up.
#define STEPS_TRIED INT64_C(1000000)
#define STEPS_BETWEEN_WORDS 5000
#define LONGEST_STEP_S 5.0
#define FIRST_STEP_S 0.01
// No body moves much farther than this between two looks at what it comes near.
#define LOOK_M 0.002

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

/// What moves, who watches it, and what it may cost.
typedef struct {
    rb_craft_t craft;
    rb_state_t state;
    bool is_carried;
    rb_pose_t X_SB; ///< once the beam is carried
    double t_s, step_s, duration_s;
    double tolerance;
    int run;
    int64_t num_steps, most_steps;
    sim_watch_t watch;
    const replay_listener_t* listener;
} flyer_t;

static void look(flyer_t* flyer, const plan_file_t* plan) {
    const rb_pose_t X_IB = flyer->is_carried ? rb_compose(&flyer->state.eta, &flyer->X_SB) : plan->X_IB;
    sim_watch_look(&flyer->watch, flyer->t_s, &flyer->state.eta, &X_IB, flyer->is_carried);
}

/// How far two states are apart, in units of a step's error; infinite where one of them is no number any more.
static double apart(const rb_state_t* a, const rb_state_t* b) {
    const double gaps[4] = {distance(a->eta.p_m, b->eta.p_m) / (1 + norm(a->eta.p_m)), turn_rad(&a->eta, &b->eta),
                            distance(a->nu, b->nu), distance(a->nu + 3, b->nu + 3)};
    double largest = 0;
    for (int i = 0; i < 4; i++) {
        if (!isfinite(gaps[i])) {
            return INFINITY;
        }
        largest = fmax(largest, gaps[i]);
    }
    return largest;
}

/// What a state that was reached in two halves lacks, if its error is a 15th of its difference from one reached in one
/// step: of fifth order then.
static void extrapolate(const rb_state_t* once, rb_state_t* twice) {
    double length = 0;
    for (int i = 0; i < 3; i++) {
        twice->eta.p_m[i] += (twice->eta.p_m[i] - once->eta.p_m[i]) / 15;
    }
    for (int i = 0; i < 4; i++) {
        twice->eta.q[i] += (twice->eta.q[i] - once->eta.q[i]) / 15;
        length = hypot(length, twice->eta.q[i]);
    }
    for (int i = 0; i < 4; i++) {
        twice->eta.q[i] /= length;
    }
    for (int i = 0; i < 6; i++) {
        twice->nu[i] += (twice->nu[i] - once->nu[i]) / 15;
    }
}

/// The longest step after which vehicle and beam are looked at often enough.
static double longest_step_s(const flyer_t* flyer, const plan_file_t* plan) {
    if (!plan->around.counts) {
        return LONGEST_STEP_S;
    }
    const double reach_m = flyer->is_carried ? norm(flyer->X_SB.p_m) + plan->beam.length_m / 2 : 0;
    const double speed_m_s = norm(flyer->state.nu) + reach_m * norm(flyer->state.nu + 3);
    return fmin(LONGEST_STEP_S, 2 * LOOK_M / fmax(speed_m_s, 1e-6));
}

/// Tells how far the run is, now and then. @return whether it may come to its end with the steps that it has.
static bool goes_on(const flyer_t* flyer) {
    const double share = flyer->t_s / flyer->duration_s;
    if (flyer->listener != NULL && flyer->num_steps / 3 % STEPS_BETWEEN_WORDS == 0) {
        flyer->listener->told(flyer->listener->context, flyer->run, share);
    }
    return flyer->num_steps < STEPS_TRIED || (double)flyer->num_steps < share * (double)flyer->most_steps;
}

static void thrust_at(const double tau[2][6], double share, double out[6]) {
    for (int i = 0; i < 6; i++) {
        out[i] = tau[0][i] + share * (tau[1][i] - tau[0][i]);
    }
}

/// Flies a segment: each step once, and in two halves, whose difference tells the error. @return whether the steps
/// last.
static bool fly_segment(const plan_file_t* plan, const plan_segment_t* segment, flyer_t* flyer) {
    double tau[2][6];
    rb_thrust(PLAN_THRUSTERS, plan->thruster, segment->u_start_N, tau[0]);
    rb_thrust(PLAN_THRUSTERS, plan->thruster, segment->u_end_N, tau[1]);
    const double start_s = flyer->t_s, duration_s = segment->duration_s;
    double done_s = 0;
    while (done_s < duration_s) {
        const double left_s = duration_s - done_s, most_s = fmin(flyer->step_s, longest_step_s(flyer, plan));
        const bool is_last = most_s >= left_s;
        const double h = is_last ? left_s : fmin(most_s, left_s / 2);
        double from[6], middle[6], to[6];
        thrust_at((const double(*)[6])tau, done_s / duration_s, from);
        thrust_at((const double(*)[6])tau, (done_s + h / 2) / duration_s, middle);
        thrust_at((const double(*)[6])tau, is_last ? 1 : (done_s + h) / duration_s, to);
        rb_state_t once = flyer->state, half, twice;
        rb_step(&flyer->craft, &once, from, to, h);
        half = flyer->state;
        rb_step(&flyer->craft, &half, from, middle, h / 2);
        twice = half;
        rb_step(&flyer->craft, &twice, middle, to, h / 2);
        flyer->num_steps += 3;
        if (!goes_on(flyer)) {
            return false;
        }
        const double error = apart(&once, &twice) / 15 / flyer->tolerance; // of fourth order
        const double factor = error > 0 ? 0.9 * pow(error, -0.2) : 4;
        if (!(error <= 1)) {
            flyer->step_s = h * fmax(0.2, factor);
            continue;
        }
        flyer->t_s = start_s + done_s + h / 2;
        flyer->state = half;
        look(flyer, plan);
        done_s = is_last ? duration_s : done_s + h;
        flyer->t_s = start_s + done_s;
        extrapolate(&once, &twice);
        flyer->state = twice;
        look(flyer, plan);
        if (!is_last || factor < 1) {
            flyer->step_s = h * fmin(4, factor);
        }
    }
    return true;
}

/// One run, the first is 0. @return false if it was given up.
static bool fly(const plan_file_t* plan, int run, int64_t most_steps, const replay_listener_t* listener,
                replay_flight_t* flight) {
    const double tolerance = FIRST_TOLERANCE / pow(FINER, run);
    flyer_t flyer = {.step_s = FIRST_STEP_S,
                     .tolerance = tolerance,
                     .run = run,
                     .most_steps = most_steps,
                     .listener = listener,
                     .X_SB = {{0, 0, 0}, {1, 0, 0, 0}}};
    memset(flight, 0, sizeof *flight);
    rb_craft_alone(&flyer.craft, &plan->vehicle);
    flyer.state.eta = plan->X_IS;
    for (size_t s = 0; s < plan->num_segments; s++) {
        flyer.duration_s += plan->segment[s].duration_s;
    }
    sim_watch_init(&flyer.watch, &plan->around);
    look(&flyer, plan);
    bool flown = true;
    for (size_t s = 0; s <= plan->num_segments && flown; s++) {
        if (s == plan->num_transit_segments) {
            flight->mate = arrival_at_mate(plan, &flyer.state);
            flight->vehicle_at_mate = flyer.state;
            flyer.X_SB = rb_take_hold(&flyer.craft, &flyer.state, &plan->beam, &plan->X_IB);
            flyer.is_carried = true;
            look(&flyer, plan);
        }
        if (s < plan->num_segments) {
            flown = fly_segment(plan, &plan->segment[s], &flyer);
        }
    }
    flight->dock = arrival_at_dock(plan, &flyer.state, &flyer.X_SB);
    flight->vehicle_at_dock = flyer.state;
    flight->beam_end = rb_compose(&flyer.state.eta, &flyer.X_SB);
    flight->nearest = flyer.watch.nearest;
    flight->num_steps = flyer.num_steps;
    flight->tolerance = tolerance;
    flight->time_s = flyer.duration_s;
    return flown;
}

/// What the thrusts alone say.
static void add_thrusts(const plan_file_t* plan, replay_flight_t* flight) {
    for (size_t s = 0; s < plan->num_segments; s++) {
        const plan_segment_t* segment = &plan->segment[s];
        for (int i = 0; i < PLAN_THRUSTERS; i++) {
            const double a = segment->u_start_N[i], b = segment->u_end_N[i];
            flight->thrust_ratio = fmax(flight->thrust_ratio, fmax(fabs(a), fabs(b)) / plan->force_max_N);
            flight->impulse_Ns += absolute_impulse(a, b, segment->duration_s);
        }
    }
}

/// Whether a figure that the last refinement moved by so much is known well enough: against its limit, or if it is far
/// beyond that; or, if no run is finer, at least on which side of it.
static bool is_settled(double value, double moved, double limit, bool is_last) {
    const double beyond = value - limit;
    return moved <= SETTLED * limit || moved < CERTAIN * (is_last ? fabs(beyond) : beyond);
}

/// One arrival in two runs. The figures are lengths of errors; what counts is how far the errors moved.
static bool arrival_is_settled(const replay_arrival_t* arrival, const rb_state_t* coarse, const rb_state_t* fine,
                               double beam_moved_m, bool is_last) {
    const double moved_mm = 1000 * fmax(beam_moved_m, distance(coarse->eta.p_m, fine->eta.p_m));
    return is_settled(arrival->position_mm, moved_mm, REPLAY_POSITION_MAX_MM, is_last) &&
           is_settled(arrival->pointing_deg, DEG_PER_RAD * turn_rad(&coarse->eta, &fine->eta), REPLAY_POINTING_MAX_DEG,
                      is_last) &&
           is_settled(arrival->speed_m_s, distance(coarse->nu, fine->nu), REPLAY_SPEED_MAX_M_S, is_last) &&
           is_settled(arrival->rate_rad_s, distance(coarse->nu + 3, fine->nu + 3), REPLAY_RATE_MAX_RAD_S, is_last);
}

static bool flight_is_settled(const replay_flight_t* coarse, const replay_flight_t* fine, bool is_last) {
    const double nearer_m = fabs(coarse->nearest.least_m - fine->nearest.least_m);
    const bool clearance_is = fine->nearest.obstacle == SIM_NO_OBSTACLE || nearer_m <= LOOK_M ||
                              nearer_m < CERTAIN * fabs(fine->nearest.least_m);
    return clearance_is && isfinite(fine->dock.position_mm) &&
           arrival_is_settled(&fine->mate, &coarse->vehicle_at_mate, &fine->vehicle_at_mate, 0, is_last) &&
           arrival_is_settled(&fine->dock, &coarse->vehicle_at_dock, &fine->vehicle_at_dock, fine->moved_m, is_last);
}

/// How far the end moved from one run to the next.
static void compare(const replay_flight_t* coarse, replay_flight_t* fine) {
    fine->moved_m = fmax(distance(coarse->vehicle_at_dock.eta.p_m, fine->vehicle_at_dock.eta.p_m),
                         distance(coarse->beam_end.p_m, fine->beam_end.p_m));
    fine->turned_rad = turn_rad(&coarse->vehicle_at_dock.eta, &fine->vehicle_at_dock.eta);
}

replay_end_t replay_fly(const plan_file_t* plan, const replay_listener_t* listener, replay_flight_t* flight) {
    replay_flight_t coarse;
    int64_t steps_left = STEPS_MAX;
    bool is_certain = false;
    for (int run = 0; run < RUNS_MAX; run++) {
        if (!fly(plan, run, steps_left, listener, flight)) {
            if (is_certain) {
                *flight = coarse;
            }
            return is_certain ? REPLAY_JUDGED : REPLAY_TOO_LONG;
        }
        steps_left -= flight->num_steps;
        add_thrusts(plan, flight);
        if (run > 0) {
            compare(&coarse, flight);
            is_certain = flight_is_settled(&coarse, flight, true);
            if (flight_is_settled(&coarse, flight, false)) {
                return REPLAY_JUDGED;
            }
        }
        coarse = *flight;
    }
    return is_certain ? REPLAY_JUDGED : REPLAY_TOO_UNSTABLE;
}

static void put_off(const replay_off_t* off, rb_body_t* body) {
    body->mass_kg *= off->mass;
    for (int i = 0; i < 3; i++) {
        body->inertia_kg_m2[i] *= off->mass;
        body->added_mass_kg[i] *= off->mass;
    }
    body->drag_lin_kg_s *= off->drag;
    body->drag_quad_kg_m *= off->drag;
    body->drag_lin_ang_Nm_s *= off->drag;
    body->drag_quad_ang_Nm_s2 *= off->drag;
    body->strip_kg_m2 *= off->drag;
}

void replay_put_off(const replay_off_t* off, plan_file_t* plan) {
    put_off(off, &plan->vehicle);
    put_off(off, &plan->beam);
    for (int t = 0; t < PLAN_THRUSTERS; t++) {
        for (int i = 0; i < 3; i++) {
            plan->thruster[t].n[i] *= off->thruster[t];
        }
    }
}
