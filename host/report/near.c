#include "near.h"

#include <math.h>
#include <string.h>

/// All that is within radius_m of the line from p by `along`.
typedef struct {
    double p[3], along[3], radius_m;
} capsule_t;

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static double clamp(double x) { return fmin(fmax(x, 0), 1); }

/// out = p + s along
static void point_at(const double p[3], double s, const double along[3], double out[3]) {
    for (int i = 0; i < 3; i++) out[i] = p[i] + s * along[i];
}

// ---- Poses ----------------------------------------------------------------------------------------------------------

static void rotate(const double q[4], const double v[3], double out[3]) {
    const double* const e = &q[1];
    const double t[3] = {2 * (e[1] * v[2] - e[2] * v[1]), 2 * (e[2] * v[0] - e[0] * v[2]),
                         2 * (e[0] * v[1] - e[1] * v[0])};
    const double u[3] = {e[1] * t[2] - e[2] * t[1], e[2] * t[0] - e[0] * t[2], e[0] * t[1] - e[1] * t[0]};
    for (int i = 0; i < 3; i++) out[i] = v[i] + q[0] * t[i] + u[i];
}

void near_point(const lcm_ssv_pose_t* X, const double p[3], double out[3]) {
    double turned[3];
    rotate(X->q, p, turned);
    point_at(X->p_m, 1, turned, out);
}

lcm_ssv_pose_t near_compose(const lcm_ssv_pose_t* X_AB, const lcm_ssv_pose_t* X_BC) {
    const double* const a = X_AB->q;
    const double* const b = X_BC->q;
    lcm_ssv_pose_t X = {.q = {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
                              a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
                              a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
                              a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1]}};
    near_point(X_AB, X_BC->p_m, X.p_m);
    return X;
}

lcm_ssv_pose_t near_inverse(const lcm_ssv_pose_t* X) {
    const double back[3] = {-X->p_m[0], -X->p_m[1], -X->p_m[2]};
    lcm_ssv_pose_t inverse = {.q = {X->q[0], -X->q[1], -X->q[2], -X->q[3]}};
    rotate(inverse.q, back, inverse.p_m);
    return inverse;
}

// ---- Distances ------------------------------------------------------------------------------------------------------

/// Puts the two points on the surfaces, given two on the lines inside of them.
static void finish(near_t* near, const double on_body[3], double body_radius_m, const double on_obstacle[3],
                   double obstacle_radius_m) {
    double way[3] = {on_obstacle[0] - on_body[0], on_obstacle[1] - on_body[1], on_obstacle[2] - on_body[2]};
    const double length_m = sqrt(dot(way, way));
    for (int i = 0; i < 3; i++) way[i] = length_m > 0 ? way[i] / length_m : 0;
    near->distance_m = length_m - body_radius_m - obstacle_radius_m;
    point_at(on_body, body_radius_m, way, near->p_body_I_m);
    point_at(on_obstacle, -obstacle_radius_m, way, near->p_obstacle_I_m);
}

/// Where two lines come closest if both were endless, then each in turn as near as its ends let it.
static void between_lines(const capsule_t* a, const capsule_t* b, near_t* near) {
    const double r[3] = {a->p[0] - b->p[0], a->p[1] - b->p[1], a->p[2] - b->p[2]};
    const double uu = dot(a->along, a->along), vv = dot(b->along, b->along), uv = dot(a->along, b->along);
    const double ur = dot(a->along, r), vr = dot(b->along, r), sine = uu * vv - uv * uv;
    double s = sine > 1e-14 * uu * vv && sine > 0 ? clamp((uv * vr - vv * ur) / sine) : 0;
    const double t = vv > 0 ? clamp((uv * s + vr) / vv) : 0;
    double on_a[3], on_b[3];
    s = uu > 0 ? clamp((uv * t - ur) / uu) : 0;
    point_at(a->p, s, a->along, on_a);
    point_at(b->p, t, b->along, on_b);
    finish(near, on_a, a->radius_m, on_b, b->radius_m);
}

/// The lower end of a body's line, seen from a plane whose normal points to where the body may be.
static void above_plane(const capsule_t* body, const double p[3], const double normal[3], near_t* near) {
    double at[3];
    point_at(body->p, dot(normal, body->along) < 0 ? 1 : 0, body->along, at);
    const double r[3] = {at[0] - p[0], at[1] - p[1], at[2] - p[2]}, height_m = dot(normal, r);
    near->distance_m = height_m - body->radius_m;
    point_at(at, -body->radius_m, normal, near->p_body_I_m);
    point_at(at, -height_m, normal, near->p_obstacle_I_m);
}

static void keep_nearer(near_t* nearest, const near_t* other) {
    if (other->distance_m < nearest->distance_m) *nearest = *other;
}

/// The inside of an upright cylinder's mantle: an end of the line is nearest.
static void within_mantle(const capsule_t* body, const lcm_ssv_tank_t* tank, near_t* nearest) {
    for (int end = 0; end < 2; end++) {
        near_t near = *nearest;
        double at[3];
        point_at(body->p, end, body->along, at);
        const double x = at[0] - tank->from_I_m[0], y = at[1] - tank->from_I_m[1], r_m = hypot(x, y);
        const double out[3] = {r_m > 0 ? x / r_m : 1, r_m > 0 ? y / r_m : 0, 0};
        near.distance_m = tank->radius_m - r_m - body->radius_m;
        point_at(at, body->radius_m, out, near.p_body_I_m);
        point_at(at, tank->radius_m - r_m, out, near.p_obstacle_I_m);
        keep_nearer(nearest, &near);
    }
}

static void within_tank(const capsule_t* body, const lcm_ssv_tank_t* tank, near_t* nearest) {
    const int first = tank->kind == LCM_SSV_TANK_T_KIND_BOX ? 0 : 2;
    nearest->distance_m = INFINITY;
    for (int axis = first; axis < 3; axis++) {
        for (int side = -1; side <= 1; side += 2) {
            near_t near = *nearest;
            double inward[3] = {0};
            inward[axis] = side;
            above_plane(body, side > 0 ? tank->from_I_m : tank->to_I_m, inward, &near);
            keep_nearer(nearest, &near);
        }
    }
    if (tank->kind == LCM_SSV_TANK_T_KIND_CYLINDER) within_mantle(body, tank, nearest);
}

// ---- Bodies ---------------------------------------------------------------------------------------------------------

/// A beam's line runs from contact to contact, as the planner's does.
static capsule_t beam_at(const lcm_ssv_scenario_t* scenario, const lcm_ssv_pose_t* X_IB) {
    const double half_m = scenario->beam.length_m / 2, first[3] = {0, 0, -half_m}, second[3] = {0, 0, half_m};
    capsule_t beam = {.radius_m = scenario->beam.radius_m};
    near_point(X_IB, first, beam.p);
    near_point(X_IB, second, beam.along);
    for (int i = 0; i < 3; i++) beam.along[i] -= beam.p[i];
    return beam;
}

static capsule_t obstacle_at(const lcm_ssv_obstacle_t* obstacle) {
    capsule_t capsule = {.radius_m = obstacle->radius_m};
    memcpy(capsule.p, obstacle->p_I_m, sizeof capsule.p);
    for (int i = 0; i < 3; i++) capsule.along[i] = obstacle->axis_I[i] * obstacle->length_m;
    return capsule;
}

near_t near_pair(const near_scene_t* scene, const near_place_t* place, int8_t body, int8_t obstacle) {
    const lcm_ssv_task_t* const task = scene->task;
    near_t near = {.body = body, .obstacle = obstacle};
    capsule_t moving = {.radius_m = task->scenario.vehicle.radius_m};
    memcpy(moving.p, place->X_IS.p_m, sizeof moving.p);
    if (body == LCM_SSV_CLEARANCE_T_BODY_BEAM) {
        const lcm_ssv_pose_t X_IB = near_compose(&place->X_IS, &scene->X_SB);
        moving = beam_at(&task->scenario, &X_IB);
    }
    if (obstacle == LCM_SSV_CLEARANCE_T_OBSTACLE_TANK) {
        within_tank(&moving, &task->scene.tank, &near);
    } else if (obstacle == LCM_SSV_CLEARANCE_T_OBSTACLE_BEAM) {
        const capsule_t beam = beam_at(&task->scenario, &task->scenario.X_IB);
        between_lines(&moving, &beam, &near);
    } else if (task->scene.obstacles[obstacle].kind == LCM_SSV_OBSTACLE_T_KIND_WALL) {
        const lcm_ssv_obstacle_t* const wall = &task->scene.obstacles[obstacle];
        above_plane(&moving, wall->p_I_m, wall->axis_I, &near);
    } else {
        const capsule_t capsule = obstacle_at(&task->scene.obstacles[obstacle]);
        between_lines(&moving, &capsule, &near);
    }
    return near;
}

static bool holds(const ssv_obstacles_t* set, int obstacle) {
    return obstacle == LCM_SSV_CLEARANCE_T_OBSTACLE_TANK   ? set->tank
           : obstacle == LCM_SSV_CLEARANCE_T_OBSTACLE_BEAM ? set->beam
                                                           : (set->obstacles >> obstacle & 1) != 0;
}

/// Whether this contact is one that the planner does not judge here.
static bool is_allowed(const near_scene_t* scene, const near_place_t* place, int8_t body, int8_t obstacle) {
    const ssv_surroundings_t* const around = scene->around;
    if (place->mated && obstacle == LCM_SSV_CLEARANCE_T_OBSTACLE_BEAM) return true; // it is what is carried
    if (body == LCM_SSV_CLEARANCE_T_BODY_BEAM)
        return place->ahead_m < real_to_double(around->docking_m) && holds(&around->at_port, obstacle);
    if (place->mated) return false;
    return (place->behind_m < real_to_double(around->leaving_m) && holds(&around->left, obstacle)) ||
           (place->ahead_m < real_to_double(around->mating_m) && obstacle == LCM_SSV_CLEARANCE_T_OBSTACLE_BEAM);
}

near_t near_at(const near_scene_t* scene, const near_place_t* place) {
    near_t nearest = {.obstacle = LCM_SSV_CLEARANCE_T_OBSTACLE_NONE, .distance_m = INFINITY};
    const int8_t last_body = place->mated ? LCM_SSV_CLEARANCE_T_BODY_BEAM : LCM_SSV_CLEARANCE_T_BODY_VEHICLE;
    for (int8_t body = LCM_SSV_CLEARANCE_T_BODY_VEHICLE; body <= last_body; body++) {
        for (int8_t obstacle = 0; obstacle <= LCM_SSV_CLEARANCE_T_OBSTACLE_TANK; obstacle++) {
            if (!holds(&scene->around->all, obstacle) || is_allowed(scene, place, body, obstacle)) continue;
            const near_t near = near_pair(scene, place, body, obstacle);
            keep_nearer(&nearest, &near);
        }
    }
    return nearest;
}
