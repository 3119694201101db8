// A scene: what it must be, what of it the hash covers, distances, and who is told when an end is blocked.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "planner/model/shape.h"
#include "sample.h"
#include "scenes.h"
#include "unity.h"

#define SEED 20261128

static ssv_scene_t scene;
static ssv_problem_t problem;
static ssv_work_t work;
static ssv_plan_t plan, other;
static ssv_fault_t fault;

void setUp(void) { memset(&scene, 0, sizeof scene); }
void tearDown(void) {}

static ssv_obstacle_t sphere(double x, double y, double z, double radius) {
    return (ssv_obstacle_t){.p_I_m = {x, y, z}, .radius_m = radius};
}

static ssv_scenario_t question(void) {
    ssv_scenario_t s = scenario_case_study(true);
    s.method = SSV_METHOD_OPTIMAL;
    s.standoff_m = 0.3631;
    s.scene = &scene;
    s.margin_m = 0.03;
    return s;
}

static void test_distances_are_those_of_other_formulas(void) {
    sample_seed(SEED);
    for (int k = 0; k < 100000; k++) {
        ssv_obstacle_t o[2];
        for (int i = 0; i < 2; i++) {
            o[i] = (ssv_obstacle_t){SSV_CAPSULE, sample_vector(2), sample_direction(), sample_between(0, 4),
                                    sample_between(0, 0.4)};
            if (sample_below(4) == 0) o[i].length_m = 0;
        }
        if (sample_below(5) == 0) o[1].axis_I = o[0].axis_I; // parallel
        if (sample_below(5) == 0) o[1].kind = SSV_WALL;
        const ssv_capsule_t body = {o[0].p_I_m, o[0].axis_I, o[0].length_m, o[0].radius_m};
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, scene_apart(&o[0], &o[1]), ssv_capsule_to_obstacle(&body, &o[1]));
    }
}

static void test_a_tank_is_left_by_the_end_that_sticks_out(void) {
    const ssv_tank_t box = {SSV_BOX, {-1, -2, -3}, {1, 2, 3}, 0}, round = {SSV_CYLINDER, {5, 0, -3}, {0, 0, 3}, 2};
    const ssv_capsule_t upright = {{0.5, 0, -2}, {0, 0, 1}, 4, 0.1}, tilted = {{5, 1, 0}, {0, 1, 0}, 1.5, 0.1};
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.4, ssv_capsule_to_tank(&upright, &box));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -2.6, ssv_capsule_to_tank(&upright, &round));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.6, ssv_capsule_to_tank(&tilted, &round));
}

static void refused(const ssv_scenario_t* s, ssv_status_t status, const char* field, int index) {
    TEST_ASSERT_EQUAL_INT(status, ssv_problem_init(&problem, s, &fault));
    TEST_ASSERT_EQUAL_STRING(field, fault.field);
    TEST_ASSERT_EQUAL_INT(index, fault.index);
}

static void test_what_is_wrong_with_a_scene_is_named(void) {
    ssv_scenario_t s = question();
    scene.num_obstacles = 65;
    refused(&s, SSV_E_RANGE, "scene.num_obstacles", -1);
    scene.num_obstacles = 3;
    scene.obstacle[1] = sphere(0, 0, 0, -0.1);
    refused(&s, SSV_E_RANGE, "scene.obstacles[i].radius_m", 1);
    scene.obstacle[1] = sphere(0, NAN, 0, 0.1);
    refused(&s, SSV_E_NOT_FINITE, "scene.obstacles[i].p_I_m", 1);
    scene.obstacle[1] = (ssv_obstacle_t){.kind = SSV_WALL, .axis_I = {0, 0, 1.001}};
    refused(&s, SSV_E_NOT_UNIT, "scene.obstacles[i].axis_I", 1);
    scene.obstacle[1] = (ssv_obstacle_t){.length_m = 1};
    refused(&s, SSV_E_NOT_UNIT, "scene.obstacles[i].axis_I", 1);
    scene.obstacle[1] = (ssv_obstacle_t){.kind = (ssv_obstacle_kind_t)2};
    refused(&s, SSV_E_RANGE, "scene.obstacles[i].kind", 1);
    scene.obstacle[1] = sphere(0, 0, 0, 0.1);
    s.obstacles = 9; // the first, and one that is not there
    refused(&s, SSV_E_RANGE, "obstacles", -1);
    TEST_ASSERT_EQUAL_DOUBLE(3, fault.value);
    s.obstacles = 1;
    s.scene = NULL;
    refused(&s, SSV_E_RANGE, "obstacles", -1);
    s.scene = &scene;
    s.margin_m = 11;
    refused(&s, SSV_E_RANGE, "margin_m", -1);
    s.margin_m = 0;
    scene.tank = (ssv_tank_t){SSV_BOX, {0, 0, 0}, {1, -1, 1}, 0};
    refused(&s, SSV_E_RANGE, "scene.tank.to_I_m", -1);
    scene.tank = (ssv_tank_t){SSV_CYLINDER, {0, 0, 0}, {0, 0, 1}, 0};
    refused(&s, SSV_E_RANGE, "scene.tank.radius_m", -1);
}

static void test_a_scene_that_holds_nothing_changes_nothing(void) {
    ssv_scenario_t s = question(), bare = s;
    bare.scene = NULL;
    bare.margin_m = s.margin_m = 0;
    scene.num_obstacles = 1;
    scene.obstacle[0] = sphere(2.5, 0, 0, 0.3); // in the way, but not chosen
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &s, &fault));
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_plan(&problem, &work, &plan));
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &bare, &fault));
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_plan(&problem, &work, &other));
    TEST_ASSERT_EQUAL_MEMORY(&other, &plan, sizeof plan);
    TEST_ASSERT_EQUAL_INT(SSV_OBSTACLE_NONE, plan.clearance.obstacle);
}

static void test_the_hash_covers_what_the_mask_selects(void) {
    ssv_scenario_t s = question();
    scene.num_obstacles = 2;
    scene.obstacle[0] = sphere(20, 0, 0, 0.3);
    scene.obstacle[1] = sphere(30, 0, 0, 0.3);
    s.obstacles = 1;
    const uint64_t hash = ssv_scenario_hash(&s);
    scene.obstacle[1].p_I_m.x = 40;
    TEST_ASSERT_EQUAL_HEX64(hash, ssv_scenario_hash(&s));
    scene.obstacle[0].p_I_m.x = 40;
    TEST_ASSERT_TRUE(hash != ssv_scenario_hash(&s));
    s.obstacles = 2; // the same sphere, by another number
    const uint64_t second = ssv_scenario_hash(&s);
    s.obstacles = 1;
    TEST_ASSERT_TRUE(second != ssv_scenario_hash(&s));
    const uint64_t before = ssv_scenario_hash(&s);
    s.approach_mate_m = 0.15;
    const uint64_t mate = ssv_scenario_hash(&s);
    s.approach_mate_m = 0;
    s.approach_dock_m = 0.15;
    TEST_ASSERT_TRUE(before != mate && mate != ssv_scenario_hash(&s) && before != ssv_scenario_hash(&s));
}

static void blocked(const ssv_scenario_t* s, ssv_outcome_t outcome, ssv_moving_t body, int obstacle,
                    double clearance_m) {
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, s, &fault));
    TEST_ASSERT_EQUAL_INT(SSV_INFEASIBLE, ssv_plan(&problem, &work, &plan));
    TEST_ASSERT_EQUAL_INT(0, plan.quote.num_priced); // nothing was searched
    TEST_ASSERT_GREATER_THAN_INT(0, plan.quote.num_candidates);
    for (int k = 0; k < plan.quote.num_candidates; k++) {
        TEST_ASSERT_EQUAL_INT(outcome, plan.quote.candidate[k].outcome);
        TEST_ASSERT_EQUAL_INT(body, plan.quote.candidate[k].body);
        TEST_ASSERT_EQUAL_INT(obstacle, plan.quote.candidate[k].obstacle);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, clearance_m, plan.quote.candidate[k].clearance_m);
    }
}

static void test_a_blocked_end_is_told_by_body_obstacle_and_depth(void) {
    // The case study: the vehicle starts at the origin, the beam lies along x around (5, 0, 0), it docks at (6.524, 5,
    // 0) with its length along -y.
    ssv_scenario_t s = question();
    scene.num_obstacles = 3;
    s.obstacles = 7;
    scene.obstacle[0] = sphere(50, 0, 0, 1);
    scene.obstacle[2] = sphere(60, 0, 0, 1);
    scene.obstacle[1] = sphere(0.4, 0, 0, 0.2);
    blocked(&s, SSV_START_BLOCKED, SSV_BODY_VEHICLE, 1, 0.4 - 0.2 - 0.3025);
    scene.obstacle[1] = sphere(5, 0.15, 0, 0.1);
    blocked(&s, SSV_START_BLOCKED, SSV_BODY_BEAM, 1, 0.15 - 0.1 - 0.0606);
    scene.obstacle[1] = sphere(6.524, 3, 0.2, 0.2);
    blocked(&s, SSV_GOAL_BLOCKED, SSV_BODY_BEAM, 1, -0.0606);
    scene.obstacle[1] = sphere(50, 0, 0, 1);
    scene.tank = (ssv_tank_t){SSV_BOX, {-0.32, -10, -10}, {20, 20, 20}, 0};
    blocked(&s, SSV_START_BLOCKED, SSV_BODY_VEHICLE, SSV_OBSTACLE_TANK, 0.32 - 0.3025);
}

static void test_the_next_task_may_leave_what_it_has_just_built(void) {
    // The beam that was docked stands there now, and the vehicle touches it.
    ssv_scenario_t s = question();
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &s, &fault));
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_plan(&problem, &work, &plan));
    scene.num_obstacles = 1;
    scene.obstacle[0] = (ssv_obstacle_t){SSV_CAPSULE, s.p_IP_m, s.axis_I, s.beam.length_m, s.beam.radius_m};
    s.obstacles = 1;
    s.X_IS = plan.quote.X_IS_final;
    s.X_IB.p.z = 3; // the next beam
    s.p_IP_m.x += 3;
    blocked(&s, SSV_START_BLOCKED, SSV_BODY_VEHICLE, 0, s.standoff_m - s.vehicle.radius_m - s.beam.radius_m);
    s.left = 1;
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &s, &fault));
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_plan(&problem, &work, &plan));
    TEST_ASSERT_TRUE(plan.clearance.certified_m >= s.margin_m);
    double way_m = 0;
    for (int leg = 0; leg < plan.num_legs; leg++) {
        for (int n = 0; n <= 200; n++) {
            const double at = plan.leg[leg].length * n / 200, apart = scene_distance(&s, &plan, leg, at, false, 0);
            const double far = way_m + vec3_norm(plan.leg[leg].v_S) * at;
            TEST_ASSERT_TRUE(apart >= (far < 0.3 ? -0.0011 : s.margin_m));
        }
        way_m += vec3_norm(plan.leg[leg].v_S) * plan.leg[leg].length;
    }
}

static void test_what_is_seen_later_is_found_on_the_plan(void) {
    ssv_scenario_t s = question();
    ssv_clearance_t clearance;
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &s, &fault));
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_plan(&problem, &work, &plan));
    for (int leg = 0; leg < plan.num_legs; leg++) {
        if (plan.leg[leg].kind == SSV_TURN) continue;
        const vec3_t a = plan.leg[leg].X_IS_start.p, b = plan.leg[leg].X_IS_end.p;
        scene.num_obstacles = 1;
        scene.obstacle[0] = sphere((a.x + b.x) / 2, (a.y + b.y) / 2, (a.z + b.z) / 2, 0.01);
        TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_scene_check(&scene, 1, &fault));
        ssv_plan_clearance(&problem, &plan, &scene, 1, &clearance);
        TEST_ASSERT_EQUAL_INT(0, clearance.obstacle);
        TEST_ASSERT_TRUE(clearance.seen_m < 0 && clearance.seen_m - clearance.certified_m <= 0.005);
        s.scene = &scene;
        s.obstacles = 1;
        TEST_ASSERT_DOUBLE_WITHIN(
            1e-9, clearance.seen_m,
            scene_distance(&s, &plan, clearance.leg, clearance.s, clearance.body == SSV_BODY_BEAM, 0));
        TEST_ASSERT_DOUBLE_WITHIN(0.005, clearance.seen_m, scene_nearest(&s, &plan, 2000).clearance_m);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_distances_are_those_of_other_formulas);
    RUN_TEST(test_a_tank_is_left_by_the_end_that_sticks_out);
    RUN_TEST(test_what_is_wrong_with_a_scene_is_named);
    RUN_TEST(test_a_scene_that_holds_nothing_changes_nothing);
    RUN_TEST(test_the_hash_covers_what_the_mask_selects);
    RUN_TEST(test_a_blocked_end_is_told_by_body_obstacle_and_depth);
    RUN_TEST(test_the_next_task_may_leave_what_it_has_just_built);
    RUN_TEST(test_what_is_seen_later_is_found_on_the_plan);
    return UNITY_END();
}
