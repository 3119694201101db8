#include "contact.h"

#include <math.h>
#include <string.h>

#define RIGHT_ANGLE 1.57079632679489661923

// Each takes 0.618 of what is left: 1e-12 of a line.
#define GOLDEN_CUTS 58
// Of a right angle: to the rounding of its double.
#define HALVINGS 53

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

/// From a point to the axis of an upright cylinder.
static double off_axis_m(const double p_m[3], const sim_tank_t* tank) {
    return hypot(p_m[0] - tank->from_m[0], p_m[1] - tank->from_m[1]);
}

/// A tank is convex, so an end of a line is nearest to its wall.
double sim_room_m(const sim_capsule_t* body, const sim_tank_t* tank) {
    double least_m = INFINITY;
    for (int i = tank->kind == SIM_BOX ? 0 : 2; i < 3; i++) {
        least_m = fmin(least_m, fmin(body->a_m[i], body->b_m[i]) - tank->from_m[i]);
        least_m = fmin(least_m, tank->to_m[i] - fmax(body->a_m[i], body->b_m[i]));
    }
    if (tank->kind == SIM_CYLINDER) {
        least_m = fmin(least_m, tank->radius_m - fmax(off_axis_m(body->a_m, tank), off_axis_m(body->b_m, tank)));
    }
    return least_m - body->radius_m;
}

/// A tube by its middle, its axis and half its length.
typedef struct {
    double middle_m[3], axis[3];
    double half_m, radius_m;
} tube_frame_t;

static tube_frame_t frame_of(const sim_tube_t* tube) {
    tube_frame_t frame = {.half_m = distance(tube->a_m, tube->b_m) / 2, .radius_m = tube->radius_m};
    for (int i = 0; i < 3; i++) {
        frame.middle_m[i] = (tube->a_m[i] + tube->b_m[i]) / 2;
        frame.axis[i] = (tube->b_m[i] - tube->a_m[i]) / (2 * frame.half_m);
    }
    return frame;
}

/// From the surface of a tube to the point at a share of a line; negative inside.
static double point_off_tube(const tube_frame_t* tube, const sim_capsule_t* line, double share) {
    double out[3], across[3];
    for (int i = 0; i < 3; i++) {
        out[i] = line->a_m[i] + share * (line->b_m[i] - line->a_m[i]) - tube->middle_m[i];
    }
    const double along_m = dot(out, tube->axis);
    for (int i = 0; i < 3; i++) {
        across[i] = out[i] - along_m * tube->axis[i];
    }
    const double beyond_m = fabs(along_m) - tube->half_m, beside_m = norm(across) - tube->radius_m;
    return beyond_m > 0 && beside_m > 0 ? hypot(beyond_m, beside_m) : fmax(beyond_m, beside_m);
}

/// The signed distance from a convex body is a convex function, so along a line it has one valley: golden section.
double sim_tube_distance_m(const sim_tube_t* tube, const sim_capsule_t* other) {
    const tube_frame_t frame = frame_of(tube);
    const double ratio = (sqrt(5) - 1) / 2;
    double low = 0, high = 1, share[2] = {1 - ratio, ratio}, value[2];
    double least_m = fmin(point_off_tube(&frame, other, 0), point_off_tube(&frame, other, 1));
    for (int k = 0; k < 2; k++) {
        value[k] = point_off_tube(&frame, other, share[k]);
    }
    for (int cut = 0; cut < GOLDEN_CUTS && distance(other->a_m, other->b_m) > 0; cut++) {
        if (value[0] < value[1]) {
            high = share[1];
            share[1] = share[0];
            value[1] = value[0];
            share[0] = high - ratio * (high - low);
            value[0] = point_off_tube(&frame, other, share[0]);
        } else {
            low = share[0];
            share[0] = share[1];
            value[0] = value[1];
            share[1] = low + ratio * (high - low);
            value[1] = point_off_tube(&frame, other, share[1]);
        }
        least_m = fmin(least_m, fmin(value[0], value[1]));
    }
    return least_m - other->radius_m;
}

/// How far the rim of a tube's end reaches from its middle along a unit vector: less, the more that is along the axis.
static double rim_m(const tube_frame_t* tube, const double direction[3]) {
    double across[3];
    rb_cross(direction, tube->axis, across);
    return tube->radius_m * norm(across);
}

double sim_tube_height_m(const sim_tube_t* tube, const sim_half_space_t* ground) {
    const tube_frame_t frame = frame_of(tube);
    return fmin(dot(ground->n, tube->a_m), dot(ground->n, tube->b_m)) - ground->offset_m - rim_m(&frame, ground->n);
}

/// How far the rim around a point reaches from the axis of an upright cylinder. From above it is an ellipse; in its own
/// axes, mirrored into the quadrant of the middle (x, y), its farthest point (x + p cos t, y + q sin t) is where the
/// derivative of the square, over cos t, falls through zero, and it falls all the way.
static double farthest_of_rim_m(const tube_frame_t* tube, const double p_m[3], const sim_tank_t* tank) {
    const double level = hypot(tube->axis[0], tube->axis[1]), p = tube->radius_m, q = p * fabs(tube->axis[2]);
    const double east = p_m[0] - tank->from_m[0], north = p_m[1] - tank->from_m[1];
    // The longer axis is level and across the tube.
    const double c = level > 0 ? tube->axis[1] / level : 1, s = level > 0 ? -tube->axis[0] / level : 0;
    const double x = fabs(c * east + s * north), y = fabs(c * north - s * east);
    double low = 0, high = 1; // shares of a right angle
    for (int halving = 0; halving < HALVINGS; halving++) {
        const double middle = (low + high) / 2, t = middle * RIGHT_ANGLE;
        if (y * q - tan(t) * x * p - (p * p - q * q) * sin(t) > 0) {
            low = middle;
        } else {
            high = middle;
        }
    }
    const double t = low * RIGHT_ANGLE;
    return hypot(x + p * cos(t), y + q * sin(t));
}

double sim_tube_room_m(const sim_tube_t* tube, const sim_tank_t* tank) {
    const tube_frame_t frame = frame_of(tube);
    double least_m = INFINITY;
    for (int i = tank->kind == SIM_BOX ? 0 : 2; i < 3; i++) {
        const double direction[3] = {i == 0, i == 1, i == 2}, reach_m = rim_m(&frame, direction);
        least_m = fmin(least_m, fmin(tube->a_m[i], tube->b_m[i]) - reach_m - tank->from_m[i]);
        least_m = fmin(least_m, tank->to_m[i] - fmax(tube->a_m[i], tube->b_m[i]) - reach_m);
    }
    if (tank->kind == SIM_CYLINDER) {
        const double off_m =
            fmax(farthest_of_rim_m(&frame, tube->a_m, tank), farthest_of_rim_m(&frame, tube->b_m, tank));
        least_m = fmin(least_m, tank->radius_m - off_m);
    }
    return least_m;
}
