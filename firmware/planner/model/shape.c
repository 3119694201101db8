#include "planner/model/shape.h"

#include <stddef.h>

// The sine of the angle between two lines, squared, below which they count as parallel: then one end of the shorter
// stands for all of it. Smaller, and where they come closest is that of rounding; larger, and lines that cross at a
// small angle come out farther apart than they are, by the square of the angle. 7e-15 in double, 7e-9 in fixed, 4e-6 in
// float.
#define PARALLEL (32 * REAL_EPSILON)

// The last stretch before mating and docking where no approach is asked for [m]: about the vehicle's own size, so that
// it need not come straight.
#define LAST_STRETCH_M REAL(0.3)
// What a stretch reaches beyond the margin at least [m]: the search must be able to tell that the margin is kept there.
#define STRETCH_ROOM_M REAL(0.01)

static real_t clamp(real_t x, real_t high) { return real_max(REAL(0), real_min(high, x)); }

// Between two lines: where they come closest if both were endless, then each in turn as near as its ends let it.
static real_t lines_apart(const ssv_capsule_t* a, const ssv_obstacle_t* b) {
    const vec3_t zero = vec3(REAL(0), REAL(0), REAL(0));
    const vec3_t u = a->length_m > REAL(0) ? a->axis_I : zero, v = b->length_m > REAL(0) ? b->axis_I : zero;
    const vec3_t r = vec3_sub(a->p_I_m, b->p_I_m), cross = vec3_cross(u, v);
    const real_t along_u = vec3_dot(u, r), along_v = vec3_dot(v, r), cosine = vec3_dot(u, v);
    const real_t sine_sq = vec3_dot(cross, cross);
    real_t s = REAL(0), t = REAL(0);
    if (sine_sq > PARALLEL) {
        s = clamp(real_div(real_mul(cosine, along_v) - along_u, sine_sq), a->length_m);
    }
    t = clamp(real_mul(cosine, s) + along_v, b->length_m);
    s = clamp(real_mul(cosine, t) - along_u, a->length_m);
    return vec3_norm(vec3_add(r, vec3_sub(vec3_scale(s, u), vec3_scale(t, v))));
}

static vec3_t end_of(const ssv_capsule_t* body) {
    return vec3_add(body->p_I_m, vec3_scale(body->length_m, body->axis_I));
}

real_t ssv_capsule_to_obstacle(const ssv_capsule_t* body, const ssv_obstacle_t* obstacle) {
    if (obstacle->kind == SSV_CAPSULE) return lines_apart(body, obstacle) - body->radius_m - obstacle->radius_m;
    const real_t begin = vec3_dot(obstacle->axis_I, vec3_sub(body->p_I_m, obstacle->p_I_m));
    const real_t along = real_mul(body->length_m, vec3_dot(obstacle->axis_I, body->axis_I));
    return begin + real_min(REAL(0), along) - body->radius_m;
}

static real_t within(real_t x, real_t from, real_t to) { return real_min(x - from, to - x); }

static real_t point_to_tank(vec3_t p, const ssv_tank_t* tank) {
    const vec3_t from = tank->from_I_m, to = tank->to_I_m;
    const real_t upright = within(p.z, from.z, to.z);
    if (tank->kind == SSV_BOX) {
        return real_min(upright, real_min(within(p.x, from.x, to.x), within(p.y, from.y, to.y)));
    }
    return real_min(upright, tank->radius_m - vec3_norm(vec3(p.x - from.x, p.y - from.y, REAL(0))));
}

// A tank has no corner that sticks in, so an end of the line is nearest.
real_t ssv_capsule_to_tank(const ssv_capsule_t* body, const ssv_tank_t* tank) {
    return real_min(point_to_tank(body->p_I_m, tank), point_to_tank(end_of(body), tank)) - body->radius_m;
}

ssv_capsule_t ssv_hull_at(const ssv_scenario_t* scenario, vec3_t p_IS_m) {
    return (ssv_capsule_t){p_IS_m, vec3(REAL(0), REAL(0), REAL(0)), REAL(0), scenario->vehicle.radius_m};
}

ssv_capsule_t ssv_beam_from(const ssv_scenario_t* scenario, vec3_t contact_1_I_m, vec3_t axis_I) {
    return (ssv_capsule_t){contact_1_I_m, axis_I, scenario->beam.length_m, scenario->beam.radius_m};
}

void ssv_surroundings_of(const ssv_scenario_t* scenario, const ssv_scene_t* scene, uint64_t obstacles,
                         ssv_surroundings_t* around) {
    const vec3_t axis_I = quat_apply(scenario->X_IB.q, vec3(REAL(0), REAL(0), REAL(1)));
    const real_t half = real_mul(REAL(0.5), scenario->beam.length_m), margin = scenario->margin_m;
    const bool tank = scene != NULL && scene->tank.kind != SSV_NO_TANK;
    around->scene = scene;
    around->counts = (scene != NULL && obstacles != 0) || tank || margin > REAL(0);
    around->all = (ssv_obstacles_t){scene != NULL ? obstacles : 0, around->counts, tank};
    around->beam = (ssv_obstacle_t){SSV_CAPSULE, vec3_sub(scenario->X_IB.p, vec3_scale(half, axis_I)), axis_I,
                                    scenario->beam.length_m, scenario->beam.radius_m};
    // What reaches to within the margin of the docked contact is the port's own.
    const ssv_capsule_t contact = {scenario->p_IP_m, vec3(REAL(0), REAL(0), REAL(0)), REAL(0),
                                   scenario->beam.radius_m + margin};
    around->at_port = (ssv_obstacles_t){0, false, tank && ssv_capsule_to_tank(&contact, &scene->tank) < REAL(0)};
    for (int k = 0; k < SSV_MAX_OBSTACLES; k++) {
        if ((around->all.obstacles >> k & 1) == 0) continue;
        if (ssv_capsule_to_obstacle(&contact, &scene->obstacle[k]) < REAL(0))
            around->at_port.obstacles |= UINT64_C(1) << k;
    }
    around->left = (ssv_obstacles_t){around->all.obstacles & scenario->left, false, false};
    const real_t approach_mate = scenario->approach_mate_m, approach_dock = scenario->approach_dock_m;
    const real_t lacks = margin + scenario->vehicle.radius_m + scenario->beam.radius_m - scenario->standoff_m;
    const real_t at_least = lacks + STRETCH_ROOM_M;
    around->leaving_m = around->left.obstacles != 0 ? real_max(LAST_STRETCH_M, at_least) : REAL(0);
    around->mating_m = real_max(approach_mate > REAL(0) ? approach_mate : LAST_STRETCH_M, at_least);
    around->docking_m = approach_dock > REAL(0) ? approach_dock : LAST_STRETCH_M;
}
