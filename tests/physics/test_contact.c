// Arrivals at mate and dock and distances against places worked out by hand, and distances against points sampled one
// by one.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "physics/contact.h"
#include "physics/random.h"
#include "unity.h"

#define PI 3.14159265358979323846

static sim_random_t draws;

void setUp(void) { sim_random_init(&draws, 20261128, 0); }
void tearDown(void) {}

static double between(double low, double high) { return low + (high - low) * sim_random_uniform(&draws); }

static rb_pose_t random_pose(void) {
    rb_pose_t pose = {{between(-5, 5), between(-5, 5), between(-5, 5)}, {1, 0, 0, 0}};
    double square = 0;
    for (int i = 0; i < 4; i++) {
        pose.q[i] = sim_random_gauss(&draws);
        square += pose.q[i] * pose.q[i];
    }
    for (int i = 0; i < 4; i++) {
        pose.q[i] /= sqrt(square);
    }
    return pose;
}

static rb_pose_t turned_about_z(double angle_rad) {
    const rb_pose_t pose = {{0, 0, 0}, {cos(angle_rad / 2), 0, 0, sin(angle_rad / 2)}};
    return pose;
}

static rb_pose_t turned_about_x(double angle_rad) {
    const rb_pose_t pose = {{0, 0, 0}, {cos(angle_rad / 2), sin(angle_rad / 2), 0, 0}};
    return pose;
}

static void test_a_vehicle_at_its_place_with_any_roll_is_off_by_nothing(void) {
    for (int trial = 0; trial < 100; trial++) {
        const rb_pose_t X_nB = random_pose();
        const sim_mate_place_t place = {0.3631, between(-1.5, 1.5), between(-PI, PI)};
        // In the beam's frame: out along the ring angle, +x back to the axis, then any roll about +x.
        const rb_pose_t ring = turned_about_z(place.ring_angle_rad), out = {{0.3631, 0, 0}, {0, 0, 0, 1}};
        const rb_pose_t roll = turned_about_x(between(-PI, PI));
        rb_pose_t X_BS = rb_compose(&ring, &out);
        X_BS.p_m[2] += place.attach_height_m;
        X_BS = rb_compose(&X_BS, &roll);
        const rb_state_t vehicle = {rb_compose(&X_nB, &X_BS), {0}};
        const sim_arrival_t arrival = sim_arrival_at_mate(&vehicle, &X_nB, &place);
        TEST_ASSERT_DOUBLE_WITHIN(1e-14, 0, arrival.position_m);
        TEST_ASSERT_DOUBLE_WITHIN(1e-14, 0, arrival.angle_rad);
        const sim_mate_place_t nearest = sim_mate_place_nearest(&vehicle.eta, &X_nB, 3.048, 0.3631);
        TEST_ASSERT_DOUBLE_WITHIN(1e-13, place.attach_height_m, nearest.attach_height_m);
        TEST_ASSERT_DOUBLE_WITHIN(1e-13, 0, sin(place.ring_angle_rad - nearest.ring_angle_rad));
    }
}

static void test_errors_at_the_mate_are_those_that_were_put_in(void) {
    const rb_pose_t X_nB = {{1, 2, 3}, {1, 0, 0, 0}};
    const sim_mate_place_t place = {0.5, 1, 0}; // at (1.5, 2, 4), looking along -x
    rb_state_t vehicle = {{{1.5 + 0.03, 2 - 0.04, 4 + 0.12}, {0, 0, 0, 1}}, {0.02, -0.03, 0.06, 0.1, 0.2, -0.2}};
    const rb_pose_t yaw = turned_about_z(0.01);
    memcpy(vehicle.eta.q, rb_compose(&vehicle.eta, &yaw).q, sizeof vehicle.eta.q);
    const sim_arrival_t arrival = sim_arrival_at_mate(&vehicle, &X_nB, &place);
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 0.13, arrival.position_m);
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 0.01, arrival.angle_rad);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 0.07, arrival.speed_m_s);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 0.3, arrival.rate_rad_s);
    // Above the beam's end the nearest place is the end.
    const rb_pose_t beyond = {{1, 2 + 0.7, 3 + 9}, {1, 0, 0, 0}};
    const sim_mate_place_t nearest = sim_mate_place_nearest(&beyond, &X_nB, 3, 0.5);
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 1.5, nearest.attach_height_m);
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, PI / 2, nearest.ring_angle_rad);
    TEST_ASSERT_EQUAL_DOUBLE(0.5, nearest.standoff_m);
}

static void test_errors_at_the_dock_are_those_that_were_put_in_at_either_end(void) {
    for (int contact = 1; contact <= 2; contact++) {
        // Vehicle and beam unturned, the beam 1 m ahead: its ends at (1, 0, -1.5) and (1, 0, 1.5).
        const double side = contact == 1 ? -1 : 1;
        const rb_pose_t X_bB = {{1, 0, 0}, {1, 0, 0, 0}};
        const double tilt = 0.02;
        const sim_port_t port = {contact, {1 + 0.03, 0.04, side * 1.5}, {0, side * sin(tilt), -side * cos(tilt)}};
        const rb_state_t vehicle = {{{0, 0, 0}, {1, 0, 0, 0}}, {0, 0, 0.01, 0, 0.1, 0}};
        const sim_arrival_t arrival = sim_arrival_at_dock(&vehicle, &X_bB, 3, &port);
        TEST_ASSERT_DOUBLE_WITHIN(1e-14, 0.05, arrival.position_m);
        TEST_ASSERT_DOUBLE_WITHIN(1e-14, tilt, arrival.angle_rad);
        // v + w x r = (0, 0, 0.01) + (0, 0.1, 0) x (1, 0, +-1.5)
        TEST_ASSERT_DOUBLE_WITHIN(1e-14, hypot(0.15, 0.01 - 0.1), arrival.speed_m_s);
        TEST_ASSERT_DOUBLE_WITHIN(1e-14, 0.1, arrival.rate_rad_s);
    }
}

static void test_an_arrival_is_within_up_to_the_very_edge_of_every_limit(void) {
    const sim_arrival_t limit = {0.03, 0.035, 0.02, 0.05};
    const sim_arrival_t none = {0, 0, 0, 0}, at_the_edge = limit, huge = {1e9, 3, 1e9, 1e9};
    TEST_ASSERT_TRUE(sim_arrival_within(&at_the_edge, &limit));
    TEST_ASSERT_TRUE(sim_arrival_within(&none, &limit));
    TEST_ASSERT_TRUE(sim_arrival_within(&huge, &none)); // a limit of 0 limits nothing
    for (int field = 0; field < 4; field++) {
        sim_arrival_t over = limit;
        double* value[4] = {&over.position_m, &over.angle_rad, &over.speed_m_s, &over.rate_rad_s};
        *value[field] = nextafter(*value[field], 1);
        TEST_ASSERT_FALSE(sim_arrival_within(&over, &limit));
        *value[field] = NAN;
        TEST_ASSERT_FALSE(sim_arrival_within(&over, &limit));
    }
}

static sim_capsule_t random_capsule(double reach_m, double length_m) {
    sim_capsule_t capsule = {.radius_m = between(0, 0.5)};
    for (int i = 0; i < 3; i++) {
        capsule.a_m[i] = between(-reach_m, reach_m);
        capsule.b_m[i] = capsule.a_m[i] + between(-length_m, length_m);
    }
    return capsule;
}

static double point_to_piece(const double p[3], const sim_capsule_t* capsule) {
    double along = 0, length2 = 0;
    for (int i = 0; i < 3; i++) {
        const double d = capsule->b_m[i] - capsule->a_m[i];
        along += (p[i] - capsule->a_m[i]) * d;
        length2 += d * d;
    }
    const double share = length2 > 0 ? fmax(0, fmin(1, along / length2)) : 0;
    double square = 0;
    for (int i = 0; i < 3; i++) {
        square += pow(p[i] - capsule->a_m[i] - share * (capsule->b_m[i] - capsule->a_m[i]), 2);
    }
    return sqrt(square);
}

/// By golden section along the first piece: the distance of a point on it to the second is convex.
static double distance_searched(const sim_capsule_t* one, const sim_capsule_t* other) {
    double low = 0, high = 1;
    const double ratio = (sqrt(5) - 1) / 2;
    double least = INFINITY;
    for (int i = 0; i < 90; i++) {
        double value[2];
        const double share[2] = {high - ratio * (high - low), low + ratio * (high - low)};
        for (int k = 0; k < 2; k++) {
            double p[3];
            for (int j = 0; j < 3; j++) {
                p[j] = one->a_m[j] + share[k] * (one->b_m[j] - one->a_m[j]);
            }
            value[k] = point_to_piece(p, other);
            least = fmin(least, value[k]);
        }
        if (value[0] < value[1]) {
            high = share[1];
        } else {
            low = share[0];
        }
    }
    return least - one->radius_m - other->radius_m;
}

static void test_distances_of_capsules_are_those_that_a_search_finds(void) {
    for (int trial = 0; trial < 20000; trial++) {
        sim_capsule_t one = random_capsule(2, trial % 5 == 1 ? 0 : 2),
                      other = random_capsule(2, trial % 5 == 2 ? 0 : 2);
        if (trial % 5 == 3) { // parallel, and nearly so
            const double scale = between(-2, 2), askew = trial % 2 == 0 ? 0 : 1e-7;
            for (int i = 0; i < 3; i++) {
                other.b_m[i] = other.a_m[i] + scale * (one.b_m[i] - one.a_m[i]) + askew * between(-1, 1);
            }
        }
        char label[40];
        snprintf(label, sizeof label, "trial %d", trial);
        const double searched = distance_searched(&one, &other); // to the root of the rounding error where pieces cross
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-7, searched, sim_distance_m(&one, &other), label);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-7, searched, sim_distance_m(&other, &one), label);
    }
}

static void test_distances_that_one_can_see(void) {
    const sim_capsule_t sphere = {{0, 0, 5}, {0, 0, 5}, 0.3}, ball = {{0, 4, 2}, {0, 4, 2}, 0.7};
    const sim_capsule_t tube = {{-1, 0, 0}, {1, 0, 0}, 0.1}, across = {{0, -2, 1}, {0, 2, 1}, 0.2};
    const sim_capsule_t beyond = {{4, 0, 0}, {9, 0, 0}, 0.5}, on_it = {{0, 0, 0}, {3, 0, 0}, 0.1};
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 5 - 1, sim_distance_m(&sphere, &ball));
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 5 - 0.4, sim_distance_m(&sphere, &tube));
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 1 - 0.3, sim_distance_m(&tube, &across));
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 3 - 0.6, sim_distance_m(&tube, &beyond));
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, -0.2, sim_distance_m(&tube, &on_it));
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, -0.6, sim_distance_m(&sphere, &sphere));
    const sim_half_space_t floor_at_minus_1 = {{0, 0, 1}, -1}, wall = {{-0.6, 0.8, 0}, 0};
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 5 + 1 - 0.3, sim_height_m(&sphere, &floor_at_minus_1));
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 1 - 0.1, sim_height_m(&tube, &floor_at_minus_1));
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, -0.6 - 0.1, sim_height_m(&tube, &wall));
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 3.2 - 0.7, sim_height_m(&ball, &wall));
}

static sim_tube_t random_tube(void) {
    const sim_capsule_t capsule = random_capsule(2, 2);
    sim_tube_t tube = {.radius_m = between(0.02, 0.5)};
    memcpy(tube.a_m, capsule.a_m, sizeof tube.a_m);
    memcpy(tube.b_m, capsule.b_m, sizeof tube.b_m);
    return tube;
}

static double length_of(const sim_tube_t* tube) {
    const double d[3] = {tube->b_m[0] - tube->a_m[0], tube->b_m[1] - tube->a_m[1], tube->b_m[2] - tube->a_m[2]};
    return sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

/// A point of the tube: a share of its length along it, and shares of its radius across it, drawn in to its surface.
static void point_of_tube(const sim_tube_t* tube, const double share[3], double p[3]) {
    const double out_m = tube->radius_m / fmax(1, hypot(share[1], share[2]));
    const double length_m = length_of(tube), aside[3] = {1, 0, 0}, ahead[3] = {0, 1, 0};
    double z[3], x[3], y[3];
    for (int i = 0; i < 3; i++) {
        z[i] = (tube->b_m[i] - tube->a_m[i]) / length_m;
    }
    rb_cross(fabs(z[0]) < 0.9 ? aside : ahead, z, x);
    const double norm = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    rb_cross(z, x, y);
    for (int i = 0; i < 3; i++) {
        p[i] = tube->a_m[i] + share[0] * length_m * z[i] + out_m / norm * (share[1] * x[i] + share[2] * y[i]);
    }
}

/// From tube to line by projections in turn: the nearest point of the one, then of the other, and so on. Where they are
/// apart that comes down to the two nearest points, where they meet to a point of both.
static double tube_to_line_projected(const sim_tube_t* tube, const sim_capsule_t* line) {
    const double length_m = length_of(tube);
    double p[3], q[3] = {0};
    memcpy(p, line->a_m, sizeof p);
    for (int turn = 0; turn < 20000; turn++) {
        double along_m = 0, out_m = 0, along_line = 0, square = 0;
        for (int i = 0; i < 3; i++) {
            along_m += (p[i] - tube->a_m[i]) * (tube->b_m[i] - tube->a_m[i]) / length_m;
        }
        for (int i = 0; i < 3; i++) {
            q[i] = tube->a_m[i] + along_m * (tube->b_m[i] - tube->a_m[i]) / length_m;
            out_m = hypot(out_m, p[i] - q[i]);
        }
        const double share = fmax(0, fmin(1, along_m / length_m)), within = fmin(1, tube->radius_m / fmax(out_m, 1e-9));
        for (int i = 0; i < 3; i++) {
            const double ahead_m = tube->b_m[i] - tube->a_m[i], d_m = line->b_m[i] - line->a_m[i];
            q[i] = tube->a_m[i] + share * ahead_m + within * (p[i] - q[i]);
            along_line += (q[i] - line->a_m[i]) * d_m;
            square += d_m * d_m;
        }
        const double on_line = square > 0 ? fmax(0, fmin(1, along_line / square)) : 0;
        for (int i = 0; i < 3; i++) {
            p[i] = line->a_m[i] + on_line * (line->b_m[i] - line->a_m[i]);
        }
    }
    return sqrt(pow(p[0] - q[0], 2) + pow(p[1] - q[1], 2) + pow(p[2] - q[2], 2));
}

static double room_of_point(const double p[3], const sim_tank_t* tank) {
    const sim_capsule_t point = {{p[0], p[1], p[2]}, {p[0], p[1], p[2]}, 0};
    double least_m = fmin(p[2] - tank->from_m[2], tank->to_m[2] - p[2]);
    if (tank->kind == SIM_BOX) {
        for (int i = 0; i < 2; i++) {
            least_m = fmin(least_m, fmin(p[i] - tank->from_m[i], tank->to_m[i] - p[i]));
        }
    } else {
        least_m = fmin(least_m, tank->radius_m - hypot(p[0] - tank->from_m[0], p[1] - tank->from_m[1]));
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, least_m, sim_room_m(&point, tank));
    return least_m;
}

/// Least room of the points of a tube: over a net, then over finer ones around the best so far.
static double least_room(const sim_tube_t* tube, const sim_tank_t* tank) {
    double least_m = INFINITY, best[3] = {0.5, 0, 0}, reach[3] = {0.5, 1, 1};
    for (int round = 0; round < 70; round++) {
        const double middle[3] = {best[0], best[1], best[2]};
        const int cells = round == 0 ? 24 : 6, knots = cells + 1;
        for (int n = 0; n < knots * knots * knots; n++) {
            const int k[3] = {n % knots, n / knots % knots, n / knots / knots};
            double at[3], p[3];
            for (int i = 0; i < 3; i++) {
                at[i] = middle[i] + reach[i] * (2.0 * k[i] / cells - 1);
            }
            at[0] = fmax(0, fmin(1, at[0]));
            point_of_tube(tube, at, p);
            const double value_m = room_of_point(p, tank);
            if (value_m < least_m) {
                least_m = value_m;
                memcpy(best, at, sizeof best);
            }
        }
        for (int i = 0; i < 3; i++) {
            reach[i] *= 0.8;
        }
    }
    return least_m;
}

static void test_distances_of_tubes_are_those_that_projections_find(void) {
    int inside = 0;
    for (int trial = 0; trial < 200; trial++) {
        const sim_tube_t tube = random_tube();
        sim_capsule_t other = random_capsule(1, trial % 5 == 1 ? 0 : 2);
        const sim_capsule_t around = {
            {tube.a_m[0], tube.a_m[1], tube.a_m[2]}, {tube.b_m[0], tube.b_m[1], tube.b_m[2]}, tube.radius_m};
        if (trial % 10 == 0) { // through a point of the tube
            const double share[3] = {between(0, 1), between(-0.7, 0.7), between(-0.7, 0.7)};
            double p[3];
            point_of_tube(&tube, share, p);
            for (int i = 0; i < 3; i++) {
                other.b_m[i] = 2 * p[i] - other.a_m[i];
            }
        }
        char label[40];
        snprintf(label, sizeof label, "trial %d", trial);
        const double found = sim_tube_distance_m(&tube, &other), apart = tube_to_line_projected(&tube, &other);
        // Where the line goes through the tube they are 0 apart, and depths count from there. Where it all but touches,
        // projections come nearer with the square root of their number.
        if (apart > 1e-5) {
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5, apart - other.radius_m, found, label);
        } else {
            TEST_ASSERT_TRUE_MESSAGE(found <= 1e-5 - other.radius_m, label);
            inside++;
        }
        TEST_ASSERT_TRUE_MESSAGE(found >= sim_distance_m(&around, &other) - 1e-12, label);
    }
    TEST_ASSERT_GREATER_THAN_INT(20, inside);
}

static void test_the_room_of_tubes_in_tanks_is_that_of_their_points(void) {
    for (int trial = 0; trial < 200; trial++) {
        sim_tube_t tube = random_tube();
        const sim_tank_t tank = {trial % 2 == 0 ? SIM_BOX : SIM_CYLINDER,
                                 {between(-3, -2), between(-3, -2), between(-3, -2)},
                                 {between(2, 3), between(2, 3), between(2, 3)},
                                 between(2, 9)};
        if (trial % 10 < 4) { // upright, and level
            const bool upright = trial % 10 < 2;
            for (int i = 0; i < 3; i++) {
                if ((i == 2) != upright) {
                    tube.b_m[i] = tube.a_m[i];
                }
            }
        }
        char label[40];
        snprintf(label, sizeof label, "trial %d", trial);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-6, least_room(&tube, &tank), sim_tube_room_m(&tube, &tank), label);
    }
}

static void test_tubes_have_flat_ends(void) {
    const sim_tube_t tube = {{0, 0, -1}, {0, 0, 1}, 0.1};
    const sim_capsule_t above = {{0, 0, 2}, {0, 0, 2}, 0.3}, beside = {{1, 0, 0.5}, {1, 0, 0.5}, 0.3};
    const sim_capsule_t off_the_rim = {{0.4, 0, 1.4}, {0.4, 0, 1.4}, 0.3},
                        across = {{0.05, -2, 1.5}, {0.05, 2, 1.5}, 0.2};
    const sim_capsule_t within = {{0.02, 0, 0}, {0.02, 0, 0}, 0.3}, through = {{-3, 0, 0.5}, {3, 0, 0.5}, 0.2};
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 1 - 0.3, sim_tube_distance_m(&tube, &above));
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 1 - 0.1 - 0.3, sim_tube_distance_m(&tube, &beside));
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 0.5 - 0.3, sim_tube_distance_m(&tube, &off_the_rim)); // 3, 4, 5
    TEST_ASSERT_DOUBLE_WITHIN(1e-11, 0.5 - 0.2, sim_tube_distance_m(&tube, &across));
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, -0.08 - 0.3, sim_tube_distance_m(&tube, &within));
    TEST_ASSERT_DOUBLE_WITHIN(1e-11, -0.1 - 0.2, sim_tube_distance_m(&tube, &through));
    const sim_half_space_t floor_at_minus_2 = {{0, 0, 1}, -2}, slope = {{0.6, 0, 0.8}, -2}, wall = {{1, 0, 0}, -2};
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 1, sim_tube_height_m(&tube, &floor_at_minus_2));
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 2 - 0.1, sim_tube_height_m(&tube, &wall));
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 2 - 0.8 - 0.1 * 0.6, sim_tube_height_m(&tube, &slope));
    const sim_tank_t box = {SIM_BOX, {-2, -3, -1.5}, {4, 0.5, 9}, 0},
                     pool = {SIM_CYLINDER, {0.3, 0.4, -4}, {0, 0, 5}, 3};
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 0.5 - 0.1, sim_tube_room_m(&tube, &box));
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 3 - 0.5 - 0.1, sim_tube_room_m(&tube, &pool));
    const sim_tube_t lies = {{-1, 0, 0}, {1, 0, 0}, 0.1};
    const sim_tank_t round = {SIM_CYLINDER, {0, 0, -0.15}, {0, 0, 5}, 1.2};
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 0.05, sim_tube_room_m(&lies, &round)); // the floor
    const sim_tank_t deep = {SIM_CYLINDER, {0, 0, -5}, {0, 0, 5}, 1.2};
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 1.2 - sqrt(1.01), sim_tube_room_m(&lies, &deep)); // its rim at (1, 0.1)
    const sim_capsule_t ball = {{0.7, 0, 0}, {0.7, 0, 0}, 0.2};
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 1.2 - 0.9, sim_room_m(&ball, &deep));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_a_vehicle_at_its_place_with_any_roll_is_off_by_nothing);
    RUN_TEST(test_errors_at_the_mate_are_those_that_were_put_in);
    RUN_TEST(test_errors_at_the_dock_are_those_that_were_put_in_at_either_end);
    RUN_TEST(test_an_arrival_is_within_up_to_the_very_edge_of_every_limit);
    RUN_TEST(test_distances_of_capsules_are_those_that_a_search_finds);
    RUN_TEST(test_distances_that_one_can_see);
    RUN_TEST(test_distances_of_tubes_are_those_that_projections_find);
    RUN_TEST(test_the_room_of_tubes_in_tanks_is_that_of_their_points);
    RUN_TEST(test_tubes_have_flat_ends);
    return UNITY_END();
}
