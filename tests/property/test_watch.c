// The simulator's watch over a flight against the judge of the planner's tests, along plans at a hub with things
// around: plans that keep clear of these, and plans that were made without them and touch. Of the watch no formula is
// shared with either, but its beam is a tube with flat ends where theirs is the capsule around it.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "physics/clearance.h"
#include "sample.h"
#include "scenes.h"
#include "sweep.h"
#include "unity.h"

#define SEED 20261204
#define CASES 240
#define MAX_CASES 4000
// Of a leg, by both; legs are some metres long, and where they come nearest the distance changes with the square.
#define POSES 400
#define SAMPLING_M 1e-3
// What the capsule sticks out of the beam's ends: its radius.
#define CAP_M 0.0606

static char label[200];

void setUp(void) {}
void tearDown(void) {}

static void numbers_of(vec3_t v, double out[3]) {
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

static rb_pose_t pose_of(pose_t X) { return (rb_pose_t){{X.p.x, X.p.y, X.p.z}, {X.q.w, X.q.x, X.q.y, X.q.z}}; }

static sim_surroundings_t surroundings_of(const ssv_scenario_t* s, const ssv_candidate_t* choice) {
    sim_surroundings_t around = {
        .counts = true,
        .num_obstacles = s->scene->num_obstacles,
        .chosen = s->obstacles,
        .tank = {(sim_tank_kind_t)s->scene->tank.kind, {0}, {0}, s->scene->tank.radius_m},
        .margin_m = s->margin_m,
        .approach_mate_m = s->approach_mate_m,
        .approach_dock_m = s->approach_dock_m,
        .hull_radius_m = s->vehicle.radius_m,
        .beam_radius_m = s->beam.radius_m,
        .beam_length_m = s->beam.length_m,
        .X_nb = pose_of(s->X_IS),
        .X_nB = pose_of(s->X_IB),
        .place = {s->standoff_m, choice->attach_height_m, choice->ring_angle_rad},
        .port = {choice->contact, {0}, {0}},
    };
    numbers_of(s->p_IP_m, around.port.p_nP_m);
    numbers_of(s->axis_I, around.port.axis_n);
    numbers_of(s->scene->tank.from_I_m, around.tank.from_m);
    numbers_of(s->scene->tank.to_I_m, around.tank.to_m);
    for (int k = 0; k < around.num_obstacles; k++) { // none of these scenes has a wall
        const ssv_obstacle_t* from = &s->scene->obstacle[k];
        sim_capsule_t* to = &around.obstacle[k].capsule;
        numbers_of(from->p_I_m, to->a_m);
        numbers_of(vec3_add(from->p_I_m, vec3_scale(from->length_m, from->axis_I)), to->b_m);
        to->radius_m = from->radius_m;
    }
    return around;
}

/// Moves on by a constant twist for a short way: the mean attitude carries the step.
static rb_pose_t moved(const rb_pose_t* X, const ssv_leg_t* leg, double ds) {
    double half[3], v[3];
    numbers_of(vec3_scale(ds / 4, leg->w_S), half);
    numbers_of(vec3_scale(ds, leg->v_S), v);
    const double angle = sqrt(half[0] * half[0] + half[1] * half[1] + half[2] * half[2]);
    const double share = angle > 0 ? sin(angle) / angle : 1;
    const rb_pose_t turn = {{0}, {cos(angle), share * half[0], share * half[1], share * half[2]}};
    const rb_pose_t shift = {{v[0], v[1], v[2]}, {1, 0, 0, 0}};
    rb_pose_t next = rb_compose(X, &turn);
    next = rb_compose(&next, &shift);
    return rb_compose(&next, &turn);
}

static sim_nearest_t watched(const ssv_scenario_t* s, const ssv_plan_t* plan) {
    const sim_surroundings_t around = surroundings_of(s, &plan->quote.choice);
    const rb_pose_t X_SB = pose_of(plan->X_SB);
    static sim_watch_t watch;
    sim_watch_init(&watch, &around);
    for (int k = 0; k < plan->num_legs; k++) {
        const ssv_leg_t* leg = &plan->leg[k];
        const bool carries = leg->phase == SSV_TRANSFER;
        rb_pose_t X_IS = pose_of(leg->X_IS_start);
        for (int n = 0; n <= POSES; n++) {
            const rb_pose_t X_IB = carries ? rb_compose(&X_IS, &X_SB) : around.X_nB;
            sim_watch_look(&watch, k, &X_IS, &X_IB, carries);
            X_IS = moved(&X_IS, leg, leg->length / POSES);
        }
    }
    return watch.nearest;
}

typedef struct {
    bool found;
    sim_nearest_t watched;
    scene_nearest_t judged;
} pair_t;

static bool keeps_clear;

static void compare_one(int k, void* result) {
    static ssv_plan_t plan;
    static ssv_scene_t scene;
    static ssv_work_t work;
    ssv_problem_t problem;
    ssv_fault_t fault;
    pair_t* pair = result;
    sample_seed(SEED + (uint64_t)k);
    ssv_scenario_t s = scene_task((scene_kind_t)(k % SCENE_KINDS), &scene);
    s.approach_mate_m = s.approach_dock_m = k / SCENE_KINDS % 2 == 0 ? 0.15 : 0;
    ssv_scenario_t asked = s;
    if (!keeps_clear) {
        asked.scene = NULL;
        asked.obstacles = 0;
        asked.margin_m = 0;
    }
    pair->found = ssv_problem_init(&problem, &asked, &fault) == SSV_OK && ssv_plan(&problem, &work, &plan) == SSV_OK;
    if (!pair->found) return;
    pair->watched = watched(&s, &plan);
    pair->judged = scene_nearest(&s, &plan, POSES);
}

/// The capsule holds the tube, and a last stretch as the watch has it, by distance, holds the one along the way. So the
/// watch never sees less; and it sees the same where neither is at work.
static void compare(const pair_t* pair, int* same, int* touch) {
    const double watched_m = pair->watched.least_m, judged_m = pair->judged.clearance_m;
    TEST_ASSERT_TRUE_MESSAGE(watched_m >= judged_m - SAMPLING_M, label);
    *same += fabs(watched_m - judged_m) < SAMPLING_M;
    *touch += watched_m < 0;
    if (watched_m < 0) TEST_ASSERT_TRUE_MESSAGE(judged_m < SAMPLING_M, label);
    if (pair->judged.obstacle == SSV_OBSTACLE_BEAM) return;
    TEST_ASSERT_TRUE_MESSAGE(watched_m <= judged_m + (pair->judged.is_beam ? CAP_M : 0) + SAMPLING_M, label);
}

static int same, touch;

/// @return how many plans there were.
static int compare_all(bool clear) {
    const int count = sweep_count(CASES, MAX_CASES);
    int found = 0;
    keeps_clear = clear;
    same = touch = 0;
    const pair_t* all = sweep(clear ? "clear" : "blind", count, sizeof *all, compare_one);
    TEST_ASSERT_NOT_NULL(all);
    for (int k = 0; k < count; k++) {
        const pair_t* pair = &all[k];
        (void)snprintf(label, sizeof label, "case %d: watched %.6f (%s %d, leg %.0f), judged %.6f (%s %d, leg %d)", k,
                       pair->watched.least_m, pair->watched.is_beam ? "beam" : "vehicle", pair->watched.obstacle,
                       pair->watched.t_s, pair->judged.clearance_m, pair->judged.is_beam ? "beam" : "vehicle",
                       pair->judged.obstacle, pair->judged.leg);
        if (!pair->found) continue;
        found++;
        compare(pair, &same, &touch);
    }
    printf("%s: %d plans, the same distance in %d, a touch in %d\n", clear ? "clear" : "blind", found, same, touch);
    return found;
}

static void test_plans_that_keep_clear_touch_nothing(void) {
    const int found = compare_all(true);
    TEST_ASSERT_EQUAL_INT(0, touch);
    TEST_ASSERT_GREATER_THAN_INT(found / 3, same);
}

static void test_plans_made_without_the_scene_are_seen_to_touch_it(void) {
    const int found = compare_all(false);
    TEST_ASSERT_GREATER_THAN_INT(found / 3, touch);
    TEST_ASSERT_GREATER_THAN_INT(found / 3, same);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_plans_that_keep_clear_touch_nothing);
    RUN_TEST(test_plans_made_without_the_scene_are_seen_to_touch_it);
    return UNITY_END();
}
