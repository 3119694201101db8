// EASE, the tetrahedron of six beams and four hubs, is built in random orders: each task is planned with all that
// stands by then in the way, from where the last one left the vehicle. SSV_LONG=1 builds 200 orders.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "sample.h"
#include "scenes.h"
#include "sweep.h"
#include "unity.h"

#define SEED 20261130
#define MAX_ORDERS 200
#define HUBS 4
#define SLOTS 6
#define HUB_RADIUS_M 0.1905
#define PORT_FROM_HUB_M 0.381
#define BEAM_LENGTH_M 3.048
#define EDGE_M (BEAM_LENGTH_M + 2 * PORT_FROM_HUB_M)
#define MARGIN_M 0.03
// The beam comes along the line between two hubs, and its far end must keep clear of the hub behind it.
#define APPROACH_DOCK_M 0.08
#define POSES 100
#define ROUNDING_M 1e-6
#define LYING_APART_M 1.5

static const int slot_hubs[SLOTS][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

static char label[160];

void setUp(void) {}
void tearDown(void) {}

typedef struct {
    double nearest_m; // over the plans of this order
    int found[3];     // by attempt
    int refused, unconfirmed, first_unconfirmed;
    bool is_sound; // every question
    double cost;
} built_t;

static vec3_t at(const double p[3]) {
    return vec3(real_from_double(p[0]), real_from_double(p[1]), real_from_double(p[2]));
}

static void add(ssv_scene_t* scene, const double p[3], const double axis[3], double length_m, double radius_m) {
    scene->obstacle[scene->num_obstacles++] =
        (ssv_obstacle_t){SSV_CAPSULE, at(p), at(axis), real_from_double(length_m), real_from_double(radius_m)};
}

// Hubs at the corners of a regular tetrahedron, the middle of its base at the origin.
static void place_hubs(double hub[HUBS][3], ssv_scene_t* scene) {
    static const double no_axis[3] = {0, 0, 0};
    const double out = EDGE_M / sqrt(3), pi = acos(-1);
    for (int k = 0; k < HUBS; k++) {
        hub[k][0] = k < 3 ? out * cos(2 * pi * k / 3) : 0;
        hub[k][1] = k < 3 ? out * sin(2 * pi * k / 3) : 0;
        hub[k][2] = k < 3 ? 0 : EDGE_M * sqrt(2.0 / 3);
        add(scene, hub[k], no_axis, 0, HUB_RADIUS_M);
    }
}

// Where a slot's beam begins and ends, by the hub that it docks at.
static void place_slot(double hub[HUBS][3], int slot, int end, double p_IP_m[3], double axis_I[3]) {
    const double* const from = hub[slot_hubs[slot][end]];
    const double* const to = hub[slot_hubs[slot][1 - end]];
    for (int i = 0; i < 3; i++) {
        axis_I[i] = (to[i] - from[i]) / EDGE_M;
        p_IP_m[i] = from[i] + PORT_FROM_HUB_M * axis_I[i];
    }
}

// The beams lie side by side in a rack, each turned about a little, the rack anywhere around the structure.
static void place_rack(pose_t X_IB[SLOTS]) {
    const double azimuth = sample_between(0, 2 * acos(-1)), height = sample_between(-1, 4);
    for (int k = 0; k < SLOTS; k++) {
        const double along = (k - 2.5) * LYING_APART_M, out = sample_between(6.5, 7);
        const double p[3] = {out * cos(azimuth) - along * sin(azimuth), out * sin(azimuth) + along * cos(azimuth),
                             height};
        const vec3_t off = sample_vector(0.1);
        quat_t q = {REAL(1), real_mul(REAL(0.5), off.x), real_mul(REAL(0.5), off.y), real_mul(REAL(0.5), off.z)};
        const real_t norm = real_sqrt(real_from_double(1 + 0.25 * real_to_double(vec3_dot(off, off))));
        q = (quat_t){real_div(q.w, norm), real_div(q.x, norm), real_div(q.y, norm), real_div(q.z, norm)};
        X_IB[k] = (pose_t){at(p), q};
    }
}

// Whether no way that a candidate is refused for can exist: at every side of the beam, by this test's own distances,
// the vehicle's hull is too near to something where it mates, or where it docks.
static bool is_confirmed(const ssv_scenario_t* s, const ssv_candidate_t* candidate) {
    const double radius_m = real_to_double(s->vehicle.radius_m), standoff_m = real_to_double(s->standoff_m);
    const double half_m = BEAM_LENGTH_M / 2, height_m = real_to_double(candidate->attach_height_m);
    const double off_m = candidate->contact == 1 ? half_m + height_m : half_m - height_m;
    if (candidate->outcome != SSV_GOAL_BLOCKED) return false;
    const double z[3] = {real_to_double(s->axis_I.x), real_to_double(s->axis_I.y), real_to_double(s->axis_I.z)};
    const double least = fabs(z[0]) < 0.6 ? 1 : 0;
    double x[3] = {least, 1 - least, 0}, y[3];
    const double in = x[0] * z[0] + x[1] * z[1] + x[2] * z[2];
    for (int i = 0; i < 3; i++) x[i] -= in * z[i];
    const double length = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    for (int i = 0; i < 3; i++) x[i] /= length;
    for (int i = 0; i < 3; i++) y[i] = z[(i + 1) % 3] * x[(i + 2) % 3] - z[(i + 2) % 3] * x[(i + 1) % 3];
    for (int n = 0; n < 360; n++) {
        const double angle = n * acos(-1) / 180;
        const double p[3] = {
            real_to_double(s->p_IP_m.x) + off_m * z[0] + standoff_m * (cos(angle) * x[0] + sin(angle) * y[0]),
            real_to_double(s->p_IP_m.y) + off_m * z[1] + standoff_m * (cos(angle) * x[1] + sin(angle) * y[1]),
            real_to_double(s->p_IP_m.z) + off_m * z[2] + standoff_m * (cos(angle) * x[2] + sin(angle) * y[2])};
        const ssv_obstacle_t hull = {SSV_CAPSULE, at(p), vec3(REAL(0), REAL(0), REAL(0)), REAL(0),
                                     real_from_double(radius_m)};
        double nearest_m = INFINITY;
        for (int k = 0; k < s->scene->num_obstacles; k++) {
            if ((s->obstacles >> k & 1) != 0) nearest_m = fmin(nearest_m, scene_apart(&hull, &s->scene->obstacle[k]));
        }
        if (nearest_m >= MARGIN_M) return false;
    }
    return true;
}

// One order. A beam for which there is no way is left where it lies, and its slot empty.
static void build_one(int k, void* result) {
    static ssv_plan_t plan;
    static ssv_scene_t scene;
    static ssv_work_t work;
    static ssv_problem_t problem;
    ssv_fault_t fault;
    built_t* built = result;
    double hub[HUBS][3];
    pose_t X_IB[SLOTS];
    int slot[SLOTS], beam_obstacle[SLOTS];
    memset(built, 0, sizeof *built);
    built->nearest_m = INFINITY;
    memset(&scene, 0, sizeof scene);
    sample_seed(SEED + (uint64_t)k);
    place_hubs(hub, &scene);
    place_rack(X_IB);
    for (int i = 0; i < SLOTS; i++) slot[i] = i;
    for (int i = SLOTS - 1; i > 0; i--) {
        const int other = sample_below(i + 1), kept = slot[i];
        slot[i] = slot[other];
        slot[other] = kept;
    }
    ssv_scenario_t s = scenario_case_study(true);
    // The beams that wait in the rack are in the way, too.
    for (int i = 0; i < SLOTS; i++) {
        const vec3_t z = quat_apply(X_IB[i].q, vec3(REAL(0), REAL(0), REAL(1)));
        const double axis[3] = {real_to_double(z.x), real_to_double(z.y), real_to_double(z.z)};
        const double p[3] = {real_to_double(X_IB[i].p.x) - BEAM_LENGTH_M / 2 * axis[0],
                             real_to_double(X_IB[i].p.y) - BEAM_LENGTH_M / 2 * axis[1],
                             real_to_double(X_IB[i].p.z) - BEAM_LENGTH_M / 2 * axis[2]};
        beam_obstacle[i] = scene.num_obstacles;
        add(&scene, p, axis, BEAM_LENGTH_M, real_to_double(s.beam.radius_m));
    }
    s.method = SSV_METHOD_OPTIMAL;
    s.contact = 0;
    s.standoff_m = real_from_double(0.3631); // hull and tube touch
    s.num_attach_heights = 3;                // the ends themselves are too near the beams that stand
    for (int i = 0; i < 3; i++) s.attach_heights_m[i] = real_from_double(1.2 * (1 - i));
    s.weight_time_per_s = REAL(1);
    s.weight_impulse_per_Ns = REAL(1);
    s.margin_m = real_from_double(MARGIN_M);
    s.approach_mate_m = real_from_double(0.15);
    s.approach_dock_m = real_from_double(APPROACH_DOCK_M);
    s.scene = &scene;
    s.obstacles = (UINT64_C(1) << scene.num_obstacles) - 1;
    s.X_IS = (pose_t){vec3(REAL(0), REAL(0), REAL(-3)), sample_attitude()};
    for (int i = 0; i < SLOTS; i++) {
        double p_IP_m[3], axis_I[3];
        const int end = sample_below(2);
        bool found = false;
        s.X_IB = X_IB[i];
        s.obstacles &= ~(UINT64_C(1) << beam_obstacle[i]); // it is fetched
        // What quick does not find is asked for with effort best, then for the slot's other end.
        for (int attempt = 0; attempt < 3 && !found; attempt++) {
            place_slot(hub, slot[i], attempt < 2 ? end : 1 - end, p_IP_m, axis_I);
            s.p_IP_m = at(p_IP_m);
            s.axis_I = at(axis_I);
            s.effort = attempt == 0 ? SSV_EFFORT_QUICK : SSV_EFFORT_BEST;
            built->is_sound = ssv_problem_init(&problem, &s, &fault) == SSV_OK;
            if (!built->is_sound) return;
            found = ssv_plan(&problem, &work, &plan) == SSV_OK;
            if (found) built->found[attempt]++;
        }
        if (found) {
            built->cost += real_to_double(plan.quote.cost);
            built->nearest_m = fmin(built->nearest_m, scene_nearest(&s, &plan, POSES).clearance_m);
            s.left = UINT64_C(1) << beam_obstacle[i];
            scene.obstacle[beam_obstacle[i]].p_I_m = at(p_IP_m);
            scene.obstacle[beam_obstacle[i]].axis_I = at(axis_I);
            s.X_IS = plan.quote.X_IS_final;
        } else {
            bool confirmed = plan.quote.num_candidates > 0;
            for (int c = 0; c < plan.quote.num_candidates; c++)
                confirmed = confirmed && is_confirmed(&s, &plan.quote.candidate[c]);
            built->refused++;
            if (!confirmed) built->first_unconfirmed = i;
            built->unconfirmed += !confirmed;
        }
        s.obstacles |= UINT64_C(1) << beam_obstacle[i];
    }
}

static void test_every_order_of_building_keeps_clear_of_what_stands(void) {
    int found[3] = {0}, refused = 0, unconfirmed = 0, whole = 0;
    double least_m = INFINITY, cost = 0;
    const int count = sweep_count(40, MAX_ORDERS);
    const built_t* all = sweep("orders", count, sizeof *all, build_one);
    TEST_ASSERT_NOT_NULL(all);
    for (int k = 0; k < count; k++) {
        (void)snprintf(label, sizeof label, "order %d: %d refused, nearest %.6f m", k, all[k].refused,
                       all[k].nearest_m);
        TEST_ASSERT_TRUE_MESSAGE(all[k].is_sound, label);
        TEST_ASSERT_TRUE_MESSAGE(all[k].nearest_m >= MARGIN_M - ROUNDING_M, label);
        if (all[k].unconfirmed > 0)
            printf("order %d, task %d: no way, and no proof of it\n", k, all[k].first_unconfirmed);
        least_m = fmin(least_m, all[k].nearest_m);
        for (int attempt = 0; attempt < 3; attempt++) found[attempt] += all[k].found[attempt];
        refused += all[k].refused;
        unconfirmed += all[k].unconfirmed;
        if (all[k].refused > 0) continue;
        whole++;
        cost += all[k].cost;
    }
    printf("%d orders: of %d tasks quick finds %d, best %d more, the slot's other end %d more; ", count, count * SLOTS,
           found[0], found[1], found[2]);
    printf("%d have no way for sure, %d none found; %d orders end whole, J %.0f at the mean; nearest %.1f mm\n",
           refused - unconfirmed, unconfirmed, whole, cost / whole, 1e3 * least_m);
    // No search proves that there is none. One task of 1,200 stays open (order 23).
    TEST_ASSERT_LESS_OR_EQUAL_INT(count * SLOTS / 200, unconfirmed);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_every_order_of_building_keeps_clear_of_what_stands);
    return UNITY_END();
}
