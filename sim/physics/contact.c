#include "contact.h"

#include <math.h>
#include <string.h>

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static double norm(const double a[3]) { return sqrt(dot(a, a)); }

static double distance(const double a[3], const double b[3]) {
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return norm(d);
}

double sim_angle_rad(const double a[3], const double b[3]) {
    double c[3];
    rb_cross(a, b, c);
    return atan2(norm(c), dot(a, b));
}

sim_arrival_t sim_arrival_at_mate(const rb_state_t* vehicle, const rb_pose_t* X_nB, const sim_mate_place_t* place) {
    const double phi = place->ring_angle_rad, radius_m = place->standoff_m, ahead_b[3] = {1, 0, 0};
    const rb_pose_t in_beam = {{radius_m * cos(phi), radius_m * sin(phi), place->attach_height_m}, {1, 0, 0, 0}};
    const double inward_B[3] = {-cos(phi), -sin(phi), 0};
    const rb_pose_t ideal = rb_compose(X_nB, &in_beam);
    double ahead_n[3], inward_n[3];
    rb_rotate(vehicle->eta.q, ahead_b, ahead_n);
    rb_rotate(X_nB->q, inward_B, inward_n);
    const sim_arrival_t r = {distance(vehicle->eta.p_m, ideal.p_m), sim_angle_rad(ahead_n, inward_n), norm(vehicle->nu),
                             norm(vehicle->nu + 3)};
    return r;
}

sim_arrival_t sim_arrival_at_dock(const rb_state_t* vehicle, const rb_pose_t* X_bB, double beam_length_m,
                                  const sim_port_t* port) {
    const double side = port->contact == 1 ? -1 : 1, outward_B[3] = {0, 0, side};
    const rb_pose_t in_beam = {{0, 0, side * beam_length_m / 2}, {1, 0, 0, 0}};
    const rb_pose_t contact_b = rb_compose(X_bB, &in_beam), contact = rb_compose(&vehicle->eta, &contact_b);
    const double into_port_n[3] = {-port->axis_n[0], -port->axis_n[1], -port->axis_n[2]};
    double outward_n[3], velocity_b[3];
    rb_rotate(contact.q, outward_B, outward_n);
    rb_cross(vehicle->nu + 3, contact_b.p_m, velocity_b);
    for (int i = 0; i < 3; i++) {
        velocity_b[i] += vehicle->nu[i];
    }
    const sim_arrival_t r = {distance(contact.p_m, port->p_nP_m), sim_angle_rad(outward_n, into_port_n),
                             fmax(norm(vehicle->nu), norm(velocity_b)), norm(vehicle->nu + 3)};
    return r;
}

static bool within(double value, double limit) { return limit <= 0 || value <= limit; }

bool sim_arrival_within(const sim_arrival_t* arrival, const sim_arrival_t* limit) {
    return within(arrival->position_m, limit->position_m) && within(arrival->angle_rad, limit->angle_rad) &&
           within(arrival->speed_m_s, limit->speed_m_s) && within(arrival->rate_rad_s, limit->rate_rad_s);
}

sim_mate_place_t sim_mate_place_nearest(const rb_pose_t* vehicle, const rb_pose_t* X_nB, double beam_length_m,
                                        double standoff_m) {
    const rb_pose_t X_BS = rb_relative(X_nB, vehicle);
    const double half_m = beam_length_m / 2, height_m = fmax(-half_m, fmin(half_m, X_BS.p_m[2]));
    const sim_mate_place_t place = {standoff_m, height_m, atan2(X_BS.p_m[1], X_BS.p_m[0])};
    return place;
}

static double clamped(double share) { return fmax(0, fmin(1, share)); }

/// Least distance of two straight pieces, from a along d each: where the derivative along both vanishes, or at an end.
static double distance_of_pieces(const double a1[3], const double d1[3], const double a2[3], const double d2[3]) {
    const double between[3] = {a1[0] - a2[0], a1[1] - a2[1], a1[2] - a2[2]};
    const double l1 = dot(d1, d1), l2 = dot(d2, d2), d12 = dot(d1, d2), b1 = dot(d1, between), b2 = dot(d2, between);
    const double parallel = l1 * l2 - d12 * d12; // (|d1 x d2|)^2
    double s1 = 0;
    if (l1 > 0 && parallel > 1e-12 * l1 * l2) {
        s1 = clamped((d12 * b2 - b1 * l2) / parallel);
    }
    double s2 = l2 > 0 ? (d12 * s1 + b2) / l2 : 0;
    if (s2 < 0 || s2 > 1 || l2 <= 0) {
        s2 = clamped(s2);
        s1 = l1 > 0 ? clamped((d12 * s2 - b1) / l1) : 0;
    }
    double gap[3];
    for (int i = 0; i < 3; i++) {
        gap[i] = between[i] + s1 * d1[i] - s2 * d2[i];
    }
    return norm(gap);
}

double sim_distance_m(const sim_capsule_t* one, const sim_capsule_t* other) {
    double d1[3], d2[3];
    for (int i = 0; i < 3; i++) {
        d1[i] = one->b_m[i] - one->a_m[i];
        d2[i] = other->b_m[i] - other->a_m[i];
    }
    return distance_of_pieces(one->a_m, d1, other->a_m, d2) - one->radius_m - other->radius_m;
}

double sim_height_m(const sim_capsule_t* body, const sim_half_space_t* ground) {
    return fmin(dot(ground->n, body->a_m), dot(ground->n, body->b_m)) - ground->offset_m - body->radius_m;
}
