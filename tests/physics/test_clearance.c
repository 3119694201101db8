// The watch over a flight, at poses that are put there one by one: what it counts, what it allows, and what it names.
#include <math.h>
#include <string.h>

#include "physics/clearance.h"
#include "unity.h"

#define HULL_M 0.3
#define TUBE_M 0.06
#define LENGTH_M 3.0
#define STANDOFF_M (HULL_M + TUBE_M)
#define PORT_Z_M 9.0

static sim_surroundings_t around;
static sim_watch_t watch;
static double clock_s;

/// The beam upright at the origin, the vehicle 4 m east of it, the port 9 m up, looking down: contact 2 docks, the
/// upper end. Nothing else stands there.
void setUp(void) {
    memset(&around, 0, sizeof around);
    around = (sim_surroundings_t){
        .counts = true,
        .margin_m = 0.03,
        .hull_radius_m = HULL_M,
        .beam_radius_m = TUBE_M,
        .beam_length_m = LENGTH_M,
        .approach_mate_m = 0.2,
        .approach_dock_m = 0.2,
        .X_nb = {{4, 0, 0}, {1, 0, 0, 0}},
        .X_nB = {{0, 0, 0}, {1, 0, 0, 0}},
        .place = {STANDOFF_M, 0, 0},
        .port = {2, {0, 0, PORT_Z_M}, {0, 0, -1}},
    };
}
void tearDown(void) {}

static void add_ball(double x, double y, double z, double radius_m) {
    const sim_obstacle_t ball = {false, {{x, y, z}, {x, y, z}, radius_m}, {{0}, 0}};
    around.obstacle[around.num_obstacles] = ball;
    around.chosen |= UINT64_C(1) << around.num_obstacles++;
}

static void begin(void) {
    sim_watch_init(&watch, &around);
    clock_s = 0;
}

static void look_alone(double x, double y, double z) {
    const rb_pose_t X_nb = {{x, y, z}, {1, 0, 0, 0}};
    sim_watch_look(&watch, clock_s++, &X_nb, &around.X_nB, false);
}

/// The vehicle east of the beam that it carries, whose middle is there.
static void look_carrying(double x, double y, double z) {
    const rb_pose_t X_nb = {{x + STANDOFF_M, y, z}, {1, 0, 0, 0}}, X_nB = {{x, y, z}, {1, 0, 0, 0}};
    sim_watch_look(&watch, clock_s++, &X_nb, &X_nB, true);
}

static void check(double least_m, double t_s, bool is_beam, int obstacle) {
    TEST_ASSERT_EQUAL_INT(obstacle, watch.nearest.obstacle);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, least_m, watch.nearest.least_m);
    TEST_ASSERT_EQUAL_DOUBLE(t_s, watch.nearest.t_s);
    TEST_ASSERT_EQUAL_INT(is_beam, watch.nearest.is_beam);
}

static void check_nothing(void) {
    TEST_ASSERT_EQUAL_INT(SIM_NO_OBSTACLE, watch.nearest.obstacle);
    TEST_ASSERT_TRUE(isinf(watch.nearest.least_m));
}

static void test_where_nothing_counts_nothing_is_near(void) {
    add_ball(4, 0, 0, 1);
    around.counts = false;
    begin();
    look_alone(4, 0, 0);
    check_nothing();
}

static void test_the_least_distance_comes_with_its_time_and_its_obstacle(void) {
    add_ball(3, 2, 0, 0.5);
    add_ball(2, -1, 0, 0.5);
    begin();
    for (double x = 4; x > 0.9; x -= 0.5) {
        look_alone(x, 0, 0);
    }
    check(1 - 0.5 - HULL_M, 4, false, 1);
    around.chosen = 1; // the second does not count
    begin();
    for (double x = 4; x > 1.9; x -= 0.5) {
        look_alone(x, 0, 0);
    }
    check(2 - 0.5 - HULL_M, 2, false, 0);
}

static void test_the_beam_at_rest_is_in_the_way_but_for_the_last_stretch_before_the_vehicle_mates(void) {
    begin();
    look_alone(2, 0, 0);
    check(2 - HULL_M - TUBE_M, 0, false, SIM_ITS_BEAM);
    look_alone(STANDOFF_M + 0.21, 0, 0);
    look_alone(STANDOFF_M + 0.19, 0, 0);
    look_alone(STANDOFF_M - 0.01, 0, 0);
    check(0.21, 1, false, SIM_ITS_BEAM);
    look_carrying(0, 0, 0);
    look_carrying(0, 0, 3);
    check(0.21, 1, false, SIM_ITS_BEAM);
}

static void test_a_vehicle_that_turns_away_again_has_touched_its_beam(void) {
    begin();
    look_alone(STANDOFF_M + 0.1, 0, 0);
    look_alone(STANDOFF_M - 0.01, 0, 0);
    check_nothing();
    look_alone(STANDOFF_M + 0.5, 0, 0);
    check(-0.01, 1, false, SIM_ITS_BEAM);
}

static void test_the_contact_with_the_beam_may_be_no_deeper_than_it_is_when_mated(void) {
    begin();
    look_alone(STANDOFF_M - SIM_DEEPER_M + 0.001, 0, 0);
    check_nothing();
    look_alone(STANDOFF_M - SIM_DEEPER_M - 0.001, 0, 0);
    check(-SIM_DEEPER_M - 0.001, 1, false, SIM_ITS_BEAM);
    around.place.standoff_m -= 0.05; // where it stands in the tube when mated, that is no deeper
    begin();
    look_alone(STANDOFF_M - SIM_DEEPER_M - 0.001, 0, 0);
    check_nothing();
}

static void test_the_last_stretch_is_never_shorter_than_it_takes_to_be_clear_by_the_margin(void) {
    around.margin_m = 0.4;
    begin();
    look_alone(STANDOFF_M + 0.40, 0, 0);
    check_nothing();
    look_alone(STANDOFF_M + 0.42, 0, 0);
    check(0.40, 0, false, SIM_ITS_BEAM); // it was held back until then
}

static void test_the_beam_that_is_carried_ends_flat(void) {
    add_ball(0, 0, LENGTH_M / 2 + 0.25, 0.1);
    add_ball(0, 5, -1, 0.1);
    begin();
    look_carrying(0, 0, 0);
    check(0.15, 0, true, 0);
    look_carrying(0, 5 - TUBE_M - 0.1 - 0.12, 0);
    check(0.12, 1, true, 1);
}

static void test_the_end_that_docks_may_touch_what_is_at_its_port_over_the_last_stretch(void) {
    const double at_port_m = PORT_Z_M - LENGTH_M / 2; // the beam's middle when it is docked
    add_ball(0, 0, PORT_Z_M + 0.3, 0.31);             // the port's own: 1 cm in the docked beam's end
    begin();
    look_carrying(0, 0, at_port_m - 0.25);
    check(0.24, 0, true, 0);
    look_carrying(0, 0, at_port_m - 0.15);
    look_carrying(0, 0, at_port_m);
    check(0.24, 0, true, 0);
    look_carrying(0, 0, at_port_m + SIM_DEEPER_M + 0.001);
    check(-0.01 - SIM_DEEPER_M - 0.001, 3, true, 0);
    // What is not the port's own is never to be touched.
    around.obstacle[0].capsule = (sim_capsule_t){{0.5, 0, PORT_Z_M - 0.5}, {0.5, 0, PORT_Z_M - 0.5}, 0.43};
    begin();
    look_carrying(0, 0, at_port_m);
    check(0.5 - 0.43 - TUBE_M, 0, true, 0);
}

static void test_a_beam_that_turns_away_from_its_port_has_touched_it(void) {
    add_ball(0, 0, PORT_Z_M + 0.3, 0.31);
    begin();
    look_carrying(0, 0, PORT_Z_M - LENGTH_M / 2);
    check(hypot(STANDOFF_M, LENGTH_M / 2 + 0.3) - HULL_M - 0.31, 0, false, 0);
    look_carrying(0, 0, PORT_Z_M - LENGTH_M / 2 - 1);
    check(-0.01, 0, true, 0);
}

static void test_what_the_vehicle_leaves_may_be_touched_while_it_leaves_and_never_deeper(void) {
    add_ball(4.5, 0, 0, 0.21); // 1 cm in the hull
    around.left = 1;
    begin();
    look_alone(4, 0, 0);
    look_alone(3.75, 0, 0);
    look_alone(3.5, 0, 0);
    check(0.49, 2, false, 0);
    look_alone(4, 0, 0); // back again
    check(-0.01, 3, false, 0);
    begin();
    look_alone(4 + SIM_DEEPER_M + 0.001, 0, 0);
    check(-0.01 - SIM_DEEPER_M - 0.001, 0, false, 0);
    begin();
    look_carrying(4 - STANDOFF_M, 0, 0); // it came for another beam by then
    check(-0.01, 0, false, 0);
    around.left = 0;
    begin();
    look_alone(4, 0, 0);
    check(-0.01, 0, false, 0);
}

static void test_walls_and_the_tank_are_in_the_way_too(void) {
    const sim_obstacle_t wall = {true, {{0}, {0}, 0}, {{-1, 0, 0}, -4.5}};
    around.obstacle[0] = wall;
    around.num_obstacles = 1;
    around.chosen = 1;
    begin();
    look_alone(4, 0, 0);
    check(0.5 - HULL_M, 0, false, 0);
    around.chosen = 0;
    around.tank = (sim_tank_t){SIM_BOX, {-1, -1, -2}, {5, 1, 9}, 0};
    begin();
    look_alone(4, 0.5, 0);
    check(0.5 - HULL_M, 0, false, SIM_TANK_WALL);
    look_carrying(3, 0, -0.4);
    check(0.1, 1, true, SIM_TANK_WALL);
    // The port is at the lid, which the docked beam touches.
    begin();
    look_carrying(0, 0, PORT_Z_M - LENGTH_M / 2);
    check(1 - HULL_M, 0, false, SIM_TANK_WALL);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_where_nothing_counts_nothing_is_near);
    RUN_TEST(test_the_least_distance_comes_with_its_time_and_its_obstacle);
    RUN_TEST(test_the_beam_at_rest_is_in_the_way_but_for_the_last_stretch_before_the_vehicle_mates);
    RUN_TEST(test_a_vehicle_that_turns_away_again_has_touched_its_beam);
    RUN_TEST(test_the_contact_with_the_beam_may_be_no_deeper_than_it_is_when_mated);
    RUN_TEST(test_the_last_stretch_is_never_shorter_than_it_takes_to_be_clear_by_the_margin);
    RUN_TEST(test_the_beam_that_is_carried_ends_flat);
    RUN_TEST(test_the_end_that_docks_may_touch_what_is_at_its_port_over_the_last_stretch);
    RUN_TEST(test_a_beam_that_turns_away_from_its_port_has_touched_it);
    RUN_TEST(test_what_the_vehicle_leaves_may_be_touched_while_it_leaves_and_never_deeper);
    RUN_TEST(test_walls_and_the_tank_are_in_the_way_too);
    return UNITY_END();
}
