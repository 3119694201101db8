#include "scenes.h"

#include <math.h>
#include <stddef.h>

#include "sample.h"

typedef struct {
    double x[3];
} point_t;

typedef struct {
    point_t a, b; // ends of its line
    double radius;
} tube_t;

static point_t point_of(vec3_t v) { return (point_t){{real_to_double(v.x), real_to_double(v.y), real_to_double(v.z)}}; }

static vec3_t vec3_of(point_t p) {
    return vec3(real_from_double(p.x[0]), real_from_double(p.x[1]), real_from_double(p.x[2]));
}

static point_t along(point_t p, double s, point_t d) {
    return (point_t){{p.x[0] + s * d.x[0], p.x[1] + s * d.x[1], p.x[2] + s * d.x[2]}};
}

static double dot(point_t a, point_t b) { return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2]; }

static point_t cross(point_t a, point_t b) {
    return (point_t){
        {a.x[1] * b.x[2] - a.x[2] * b.x[1], a.x[2] * b.x[0] - a.x[0] * b.x[2], a.x[0] * b.x[1] - a.x[1] * b.x[0]}};
}

static double norm(point_t a) { return sqrt(dot(a, a)); }

static point_t unit(point_t a) { return along((point_t){{0, 0, 0}}, 1 / norm(a), a); }

static point_t turned(const double q[4], point_t v) {
    const point_t e = {{q[1], q[2], q[3]}}, t = cross(e, v);
    return along(along(v, 2 * q[0], t), 2, cross(e, t));
}

// ---- Distances: of two lines either at two of their ends, or between the two where both are endless ----

static double point_to_line(point_t p, const tube_t* t) {
    const point_t d = along(t->b, -1, t->a), r = along(p, -1, t->a);
    const double dd = dot(d, d), s = dd > 0 ? fmin(1, fmax(0, dot(r, d) / dd)) : 0;
    return norm(along(r, -s, d));
}

static double tube_to_tube(const tube_t* a, const tube_t* b) {
    double least = fmin(fmin(point_to_line(a->a, b), point_to_line(a->b, b)),
                        fmin(point_to_line(b->a, a), point_to_line(b->b, a)));
    const point_t u = along(a->b, -1, a->a), v = along(b->b, -1, b->a), r = along(b->a, -1, a->a), n = cross(u, v);
    const double nn = dot(n, n);
    if (nn > 1e-12) {
        // Whether the common perpendicular meets both.
        const double s = dot(cross(r, v), n) / nn, t = dot(cross(r, u), n) / nn;
        if (s >= 0 && s <= 1 && t >= 0 && t <= 1) least = fmin(least, fabs(dot(r, n)) / sqrt(nn));
    }
    return least - a->radius - b->radius;
}

static double tube_to_wall(const tube_t* a, const ssv_obstacle_t* wall) {
    const point_t n = point_of(wall->axis_I), p = point_of(wall->p_I_m);
    return fmin(dot(n, along(a->a, -1, p)), dot(n, along(a->b, -1, p))) - a->radius;
}

static double tube_to_tank(const tube_t* a, const ssv_tank_t* tank) {
    const point_t from = point_of(tank->from_I_m), to = point_of(tank->to_I_m), end[2] = {a->a, a->b};
    double least = INFINITY;
    for (int e = 0; e < 2; e++) {
        for (int i = tank->kind == SSV_BOX ? 0 : 2; i < 3; i++) {
            least = fmin(least, fmin(end[e].x[i] - from.x[i], to.x[i] - end[e].x[i]));
        }
        if (tank->kind == SSV_CYLINDER) {
            const double off = hypot(end[e].x[0] - from.x[0], end[e].x[1] - from.x[1]);
            least = fmin(least, real_to_double(tank->radius_m) - off);
        }
    }
    return least - a->radius;
}

static tube_t tube_of(const ssv_obstacle_t* o) {
    const point_t a = point_of(o->p_I_m);
    return (tube_t){a, along(a, real_to_double(o->length_m), point_of(o->axis_I)), real_to_double(o->radius_m)};
}

static double to_obstacle(const tube_t* body, const ssv_obstacle_t* obstacle) {
    if (obstacle->kind == SSV_WALL) return tube_to_wall(body, obstacle);
    const tube_t tube = tube_of(obstacle);
    return tube_to_tube(body, &tube);
}

// ---- What a plan comes near ----

static tube_t ball(point_t p, double radius) { return (tube_t){p, p, radius}; }

static tube_t beam_tube(const ssv_scenario_t* s, const double q[4], point_t p) {
    const double half = real_to_double(s->beam.length_m) / 2;
    const point_t z = turned(q, (point_t){{0, 0, 1}});
    return (tube_t){along(p, -half, z), along(p, half, z), real_to_double(s->beam.radius_m)};
}

static void quat_numbers(quat_t q, double n[4]) {
    n[0] = real_to_double(q.w);
    n[1] = real_to_double(q.x);
    n[2] = real_to_double(q.y);
    n[3] = real_to_double(q.z);
}

static void product(const double a[4], const double b[4], double c[4]) {
    c[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    c[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    c[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    c[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

// Where the vehicle is after s of the leg: it turns about a line at a distance from it, and moves on along that line.
static void pose_on(const ssv_leg_t* leg, double s, point_t* p, double q[4]) {
    double q0[4], turn[4] = {1, 0, 0, 0};
    const point_t v = point_of(leg->v_S), w = point_of(leg->w_S);
    const double rate = norm(w), angle = rate * s;
    point_t moved = along((point_t){{0, 0, 0}}, s, v);
    quat_numbers(leg->X_IS_start.q, q0);
    if (rate > 0) {
        const point_t n = unit(w), pivot = along((point_t){{0, 0, 0}}, 1 / rate, cross(n, v));
        turn[0] = cos(angle / 2);
        for (int i = 0; i < 3; i++) turn[1 + i] = sin(angle / 2) * n.x[i];
        moved = along(along(along((point_t){{0, 0, 0}}, dot(n, v) * s, n), 1, pivot), -1, turned(turn, pivot));
    }
    *p = along(point_of(leg->X_IS_start.p), 1, turned(q0, moved));
    product(q0, turn, q);
}

static void take(scene_nearest_t* nearest, double clearance_m, int leg, double s, int obstacle, bool is_beam) {
    if (clearance_m < nearest->clearance_m) *nearest = (scene_nearest_t){clearance_m, leg, obstacle, s, is_beam};
}

static double last_stretch(double approach_m) { return approach_m > 0 ? approach_m : 0.3; }

scene_nearest_t scene_nearest(const ssv_scenario_t* s, const ssv_plan_t* plan, int poses) {
    scene_nearest_t nearest = {INFINITY, -1, SSV_OBSTACLE_NONE, 0, false};
    const ssv_scene_t* scene = s->scene;
    const double margin = real_to_double(s->margin_m), radius = real_to_double(s->vehicle.radius_m);
    const double beam_radius = real_to_double(s->beam.radius_m);
    double q_IB[4], q_SB[4];
    quat_numbers(s->X_IB.q, q_IB);
    quat_numbers(plan->X_SB.q, q_SB);
    const tube_t lying = beam_tube(s, q_IB, point_of(s->X_IB.p));
    const tube_t port = ball(point_of(s->p_IP_m), beam_radius + margin);
    // What may be touched: how far each pose is from the end of its phase, along the way of the point that touches.
    const double lacks = margin + radius + beam_radius - real_to_double(s->standoff_m) + 0.01;
    const double mating_m = fmax(last_stretch(real_to_double(s->approach_mate_m)), lacks);
    const double docking_m = last_stretch(real_to_double(s->approach_dock_m)), leaving_m = fmax(last_stretch(0), lacks);
    double ahead[2] = {0, 0}, behind = 0, point_speed[SSV_MAX_LEGS];
    const tube_t start = ball(point_of(s->X_IS.p), radius);
    for (int k = 0; k < plan->num_legs; k++) {
        const ssv_leg_t* leg = &plan->leg[k];
        point_t contact = {{0, 0, 0}};
        if (leg->phase == SSV_TRANSFER) {
            const double z = real_to_double(s->beam.length_m) / 2 * (plan->quote.choice.contact == 1 ? -1 : 1);
            contact = along(point_of(plan->X_SB.p), 1, turned(q_SB, (point_t){{0, 0, z}}));
        }
        point_speed[k] = norm(along(point_of(leg->v_S), 1, cross(point_of(leg->w_S), contact)));
        ahead[leg->phase] += point_speed[k] * real_to_double(leg->length);
    }
    for (int k = 0; k < plan->num_legs; k++) {
        const ssv_leg_t* leg = &plan->leg[k];
        const double length = real_to_double(leg->length);
        for (int n = 0; n <= poses; n++) {
            const double at = length * n / poses, left = ahead[leg->phase] - point_speed[k] * at;
            const bool mates = leg->phase == SSV_TRANSIT && left <= mating_m + 1e-5;
            const bool docks = leg->phase == SSV_TRANSFER && left <= docking_m + 1e-5;
            point_t p;
            double q[4], q_now[4];
            pose_on(leg, at, &p, q);
            const tube_t hull = ball(p, radius);
            product(q, q_SB, q_now);
            const tube_t beam = beam_tube(s, q_now, along(p, 1, turned(q, point_of(plan->X_SB.p))));
            // On the last stretch it may be as deep as when it has mated, and a little more for rounding.
            const double mated = real_to_double(s->standoff_m) - radius - beam_radius,
                         to_beam = tube_to_tube(&hull, &lying);
            if (leg->phase == SSV_TRANSIT && !(mates && to_beam >= mated - 0.0011))
                take(&nearest, to_beam, k, at, SSV_OBSTACLE_BEAM, false);
            for (int o = 0; scene != NULL && o < scene->num_obstacles; o++) {
                if ((s->obstacles >> o & 1) == 0) continue;
                const bool ports_own = docks && to_obstacle(&port, &scene->obstacle[o]) < 1e-6;
                // What it lets go of it may touch at first, and again a little more for rounding.
                const double apart = to_obstacle(&hull, &scene->obstacle[o]);
                const bool leaves = leg->phase == SSV_TRANSIT && behind + point_speed[k] * at <= leaving_m + 1e-5 &&
                                    (s->left >> o & 1) != 0 &&
                                    apart >= to_obstacle(&start, &scene->obstacle[o]) - 0.0011;
                if (!leaves) take(&nearest, apart, k, at, o, false);
                if (leg->phase == SSV_TRANSFER && !ports_own)
                    take(&nearest, to_obstacle(&beam, &scene->obstacle[o]), k, at, o, true);
            }
            if (scene != NULL && scene->tank.kind != SSV_NO_TANK) {
                const bool ports_own = docks && tube_to_tank(&port, &scene->tank) < 1e-6;
                take(&nearest, tube_to_tank(&hull, &scene->tank), k, at, SSV_OBSTACLE_TANK, false);
                if (leg->phase == SSV_TRANSFER && !ports_own)
                    take(&nearest, tube_to_tank(&beam, &scene->tank), k, at, SSV_OBSTACLE_TANK, true);
            }
        }
        ahead[leg->phase] -= point_speed[k] * length;
        behind += point_speed[k] * length;
    }
    return nearest;
}

double scene_distance(const ssv_scenario_t* scenario, const ssv_plan_t* plan, int leg, double s, bool is_beam,
                      int obstacle) {
    double q_IB[4], q_SB[4], q[4], q_now[4];
    point_t p;
    quat_numbers(scenario->X_IB.q, q_IB);
    quat_numbers(plan->X_SB.q, q_SB);
    pose_on(&plan->leg[leg], s, &p, q);
    product(q, q_SB, q_now);
    const tube_t lying = beam_tube(scenario, q_IB, point_of(scenario->X_IB.p));
    const tube_t body = is_beam ? beam_tube(scenario, q_now, along(p, 1, turned(q, point_of(plan->X_SB.p))))
                                : ball(p, real_to_double(scenario->vehicle.radius_m));
    return obstacle == SSV_OBSTACLE_BEAM   ? tube_to_tube(&body, &lying)
           : obstacle == SSV_OBSTACLE_TANK ? tube_to_tank(&body, &scenario->scene->tank)
                                           : to_obstacle(&body, &scenario->scene->obstacle[obstacle]);
}

double scene_apart(const ssv_obstacle_t* capsule, const ssv_obstacle_t* obstacle) {
    const tube_t body = tube_of(capsule);
    return to_obstacle(&body, obstacle);
}

// ---- Tasks ----

// The hub of the paper: a ball, and three ports around its axis.
#define HUB_RADIUS 0.1905
#define PORT_FROM_HUB 0.381
#define ROOM_AT_START 0.1
#define MARGIN 0.03
#define TANK_ROOM 0.25

static point_t any_point(double size) { return point_of(sample_vector(size)); }

static void add(ssv_scene_t* scene, point_t p, point_t axis, double length, double radius) {
    ssv_obstacle_t* o = &scene->obstacle[scene->num_obstacles++];
    *o = (ssv_obstacle_t){SSV_CAPSULE, vec3_of(p), vec3_of(axis), real_from_double(length), real_from_double(radius)};
}

static bool is_free(const tube_t* body, const ssv_scene_t* scene) {
    for (int k = 0; k < scene->num_obstacles; k++) {
        if (to_obstacle(body, &scene->obstacle[k]) < ROOM_AT_START) return false;
    }
    return true;
}

static tube_t task_beam(const ssv_scenario_t* s) {
    double q[4];
    quat_numbers(s->X_IB.q, q);
    return beam_tube(s, q, point_of(s->X_IB.p));
}

static void hold(const tube_t* body, double room, point_t* least, point_t* most) {
    const point_t end[2] = {body->a, body->b};
    for (int e = 0; e < 2; e++) {
        for (int i = 0; i < 3; i++) {
            least->x[i] = fmin(least->x[i], end[e].x[i] - body->radius - room);
            most->x[i] = fmax(most->x[i], end[e].x[i] + body->radius + room);
        }
    }
}

ssv_scenario_t scene_task(scene_kind_t kind, ssv_scene_t* scene) {
    static const double weights[4][2] = {{1, 0}, {1, 0.1}, {1, 1}, {0.01, 1}};
    ssv_scenario_t s = scenario_case_study(sample_below(2) == 1);
    const double* const weight = weights[sample_below(4)];
    memset(scene, 0, sizeof *scene);
    s.method = SSV_METHOD_OPTIMAL;
    s.want_candidates = false;
    s.contact = 1 + sample_below(2);
    // Hull and tube touch. With less, the vehicle cannot hold a docked beam by the ring next to the hub.
    s.standoff_m = real_from_double(0.3631);
    s.weight_time_per_s = real_from_double(weight[0]);
    s.weight_impulse_per_Ns = real_from_double(weight[1]);
    const double length = real_to_double(s.beam.length_m), tube = real_to_double(s.beam.radius_m);
    double q[4];
    const point_t hub = any_point(4);
    quat_numbers(sample_attitude(), q);
    point_t axis[3];
    for (int k = 0; k < 3; k++) {
        const double azimuth = 2 * acos(-1) / 3 * k;
        axis[k] = turned(q, (point_t){{cos(azimuth) / 2, sin(azimuth) / 2, sqrt(0.75)}});
    }
    const int port = sample_below(3);
    add(scene, hub, (point_t){{0, 0, 0}}, 0, HUB_RADIUS);
    for (int k = 0; k < 3 && kind != SCENE_BARE; k++) {
        if (k != port) add(scene, along(hub, PORT_FROM_HUB, axis[k]), axis[k], length, tube);
    }
    const point_t p_IP = along(hub, PORT_FROM_HUB, axis[port]);
    s.p_IP_m = vec3_of(p_IP);
    s.axis_I = vec3_of(axis[port]);
    const tube_t docked = {p_IP, along(p_IP, length, axis[port]), tube};
    for (int lying = 0; lying < 5 && kind == SCENE_STREWN;) {
        const point_t p = any_point(6), d = point_of(sample_direction());
        const tube_t it = {p, along(p, length, d), tube};
        if (tube_to_tube(&it, &docked) < ROOM_AT_START || !is_free(&it, scene)) continue;
        add(scene, p, d, length, tube);
        lying++;
    }
    tube_t beam, hull;
    do {
        s.X_IB.p = sample_vector(6);
        s.X_IB.q = sample_attitude();
        beam = task_beam(&s);
    } while (!is_free(&beam, scene));
    do {
        s.X_IS.p = sample_vector(6);
        s.X_IS.q = sample_attitude();
        hull = ball(point_of(s.X_IS.p), real_to_double(s.vehicle.radius_m));
    } while (!is_free(&hull, scene) || tube_to_tube(&hull, &beam) < ROOM_AT_START);
    if (kind == SCENE_WALLS) {
        point_t least = {{INFINITY, INFINITY, INFINITY}}, most = {{-INFINITY, -INFINITY, -INFINITY}};
        const tube_t beside = {docked.a, docked.b, 2 * hull.radius + tube};
        hold(&hull, TANK_ROOM, &least, &most);
        hold(&beam, TANK_ROOM, &least, &most);
        hold(&beside, TANK_ROOM, &least, &most);
        scene->tank = (ssv_tank_t){SSV_BOX, vec3_of(least), vec3_of(most), real_from_double(0)};
    }
    s.scene = scene;
    s.obstacles = (UINT64_C(1) << scene->num_obstacles) - 1;
    s.margin_m = real_from_double(MARGIN);
    return s;
}
