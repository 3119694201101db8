// Arrivals at mate and dock against places worked out by hand, and distances against points sampled one by one.
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

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_a_vehicle_at_its_place_with_any_roll_is_off_by_nothing);
    RUN_TEST(test_errors_at_the_mate_are_those_that_were_put_in);
    RUN_TEST(test_errors_at_the_dock_are_those_that_were_put_in_at_either_end);
    RUN_TEST(test_an_arrival_is_within_up_to_the_very_edge_of_every_limit);
    RUN_TEST(test_distances_of_capsules_are_those_that_a_search_finds);
    RUN_TEST(test_distances_that_one_can_see);
    return UNITY_END();
}
