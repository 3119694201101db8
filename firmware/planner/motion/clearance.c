#include "planner/motion/clearance.h"

#include "planner/math/assert.h"
#include "planner/model/grasp.h"
#include "planner/motion/path.h"

#define NUM_BODIES 2
// Halves of halves under way. More, and the stack is too deep; fewer, and maneuvers of some hundred metres do not come
// down to the resolution: they count as if they were nearer.
#define MAX_STRETCHES 22
// A stretch on which nothing moves farther than this [m] is halved no more. Larger, and motions that keep the margin by
// less count as if they did not; smaller, and motions along an obstacle take longer.
#define RESOLUTION_M REAL(2.5e-4)
// Of a trial. More, and trials along an obstacle take longer; fewer, and some of these count as if they touched it.
#define TRIAL_POSES 1024
// Of the plan that is written: enough for the longest leg along a wall, all of which is equally near.
#define PLAN_BRACKET_M REAL(0.0045)
#define PLAN_POSES 32768

// How much deeper a contact may become that is allowed [m]. Larger, and that can be seen; smaller, and the last pose of
// each approach takes many steps.
#define DEEPER_M REAL(1e-3)

// A stretch of a maneuver, and what still matters to each body there.
typedef struct {
    real_t from, to;
    bool leaves, arrives; // whether it is part of the first stretch of all, or of the last
    ssv_obstacles_t near[NUM_BODIES];
} stretch_t;

// A maneuver and its bodies.
typedef struct {
    const ssv_flight_t* flight;
    const ssv_clearance_rule_t* rule;
    pose_t X_IS;
    ssv_twist_t twist;
    vec3_t p_SA_m, axis_S; // of the beam: contact 1 and z axis
    real_t speed[NUM_BODIES];
    int leg;
    ssv_clearance_t* clearance;
} track_t;

void ssv_clearance_begin(real_t seen_m, ssv_clearance_t* clearance) {
    *clearance = (ssv_clearance_t){seen_m, seen_m, 0, REAL(0), SSV_BODY_VEHICLE, SSV_OBSTACLE_NONE};
}

// Takes note of a distance at the middle of a stretch from which nothing moves farther than reach_m. @return whether
// that settles the stretch.
static bool settles(const track_t* track, ssv_moving_t body, int obstacle, real_t distance_m, real_t s, real_t reach_m,
                    bool is_last) {
    ssv_clearance_t* c = track->clearance;
    if (distance_m < c->seen_m) {
        c->seen_m = distance_m;
        c->leg = track->leg;
        c->s = s;
        c->body = body;
        c->obstacle = obstacle;
    }
    const real_t enough = track->rule->enough_m, tight = c->seen_m - track->rule->bracket_m;
    const real_t target = c->seen_m < enough ? tight : real_max(enough, tight), bound = distance_m - reach_m;
    if (bound < target && !is_last) return false;
    c->certified_m = real_min(c->certified_m, bound);
    return true;
}

static real_t distance_to(const ssv_surroundings_t* around, const ssv_capsule_t* body, int obstacle) {
    return obstacle == SSV_OBSTACLE_TANK   ? ssv_capsule_to_tank(body, &around->scene->tank)
           : obstacle == SSV_OBSTACLE_BEAM ? ssv_capsule_to_obstacle(body, &around->beam)
                                           : ssv_capsule_to_obstacle(body, &around->scene->obstacle[obstacle]);
}

static bool holds(const ssv_obstacles_t* set, int obstacle) {
    return obstacle == SSV_OBSTACLE_TANK   ? set->tank
           : obstacle == SSV_OBSTACLE_BEAM ? set->beam
                                           : (set->obstacles >> obstacle & 1) != 0;
}

// What is lent to a contact that is allowed here, so that it has enough where it is as deep as at its own end.
static real_t lent(const track_t* track, ssv_moving_t body, int obstacle, const stretch_t* stretch) {
    const ssv_surroundings_t* around = track->flight->around;
    const ssv_scenario_t* s = track->flight->scenario;
    real_t at_end = track->rule->enough_m;
    if (stretch->leaves && body == SSV_BODY_VEHICLE && holds(&around->left, obstacle)) {
        const ssv_capsule_t hull = ssv_hull_at(s, s->X_IS.p);
        at_end = distance_to(around, &hull, obstacle) - DEEPER_M;
    } else if (stretch->arrives && body == SSV_BODY_VEHICLE && obstacle == SSV_OBSTACLE_BEAM) {
        at_end = s->standoff_m - s->vehicle.radius_m - s->beam.radius_m - DEEPER_M;
    } else if (stretch->arrives && body == SSV_BODY_BEAM && holds(&around->at_port, obstacle)) {
        const ssv_capsule_t docked = ssv_beam_from(s, s->p_IP_m, s->axis_I);
        at_end = distance_to(around, &docked, obstacle) - DEEPER_M;
    }
    return real_max(REAL(0), track->rule->enough_m - at_end);
}

static bool look_at(const track_t* track, ssv_moving_t body, const ssv_capsule_t* shape, int obstacle, real_t s,
                    real_t reach_m, bool is_last, const stretch_t* stretch) {
    real_t distance_m = distance_to(track->flight->around, shape, obstacle);
    if (stretch->leaves || stretch->arrives) distance_m += lent(track, body, obstacle, stretch);
    return settles(track, body, obstacle, distance_m, s, reach_m, is_last);
}

// Looks at one body in the middle of a stretch and leaves what still matters.
static void look(const track_t* track, ssv_moving_t body, const ssv_capsule_t* shape, real_t s, real_t reach_m,
                 bool is_last, stretch_t* stretch) {
    ssv_obstacles_t* near = &stretch->near[body];
    is_last = is_last || reach_m <= RESOLUTION_M;
    for (uint64_t left = near->obstacles; left != 0; left &= left - 1) {
        const int k = __builtin_ctzll(left);
        if (look_at(track, body, shape, k, s, reach_m, is_last, stretch)) near->obstacles &= ~(left & (0 - left));
    }
    near->beam = near->beam && !look_at(track, body, shape, SSV_OBSTACLE_BEAM, s, reach_m, is_last, stretch);
    near->tank = near->tank && !look_at(track, body, shape, SSV_OBSTACLE_TANK, s, reach_m, is_last, stretch);
}

static bool matters(const ssv_obstacles_t* near) { return near->obstacles != 0 || near->beam || near->tank; }

static ssv_obstacles_t without(ssv_obstacles_t from, ssv_obstacles_t these) {
    return (ssv_obstacles_t){from.obstacles & ~these.obstacles, from.beam && !these.beam, from.tank && !these.tank};
}

// Looks at the stretches given, and at halves of what is not settled.
static void follow(const track_t* track, stretch_t stretch[MAX_STRETCHES], int num) {
    const ssv_scenario_t* s = track->flight->scenario;
    for (int poses = 1; num > 0; poses++) {
        stretch_t* last = &stretch[num - 1];
        const real_t half = real_mul(REAL(0.5), last->to - last->from), middle = last->from + half;
        const pose_t X_IS = ssv_maneuver_pose(track->X_IS, track->twist, middle);
        const bool is_last = poses >= track->rule->most_poses || num == MAX_STRETCHES;
        if (matters(&last->near[SSV_BODY_VEHICLE])) {
            const ssv_capsule_t hull = ssv_hull_at(s, X_IS.p);
            look(track, SSV_BODY_VEHICLE, &hull, middle, real_mul(track->speed[SSV_BODY_VEHICLE], half), is_last, last);
        }
        if (matters(&last->near[SSV_BODY_BEAM])) {
            const ssv_capsule_t beam = ssv_beam_from(s, vec3_add(X_IS.p, quat_apply(X_IS.q, track->p_SA_m)),
                                                     quat_apply(X_IS.q, track->axis_S));
            look(track, SSV_BODY_BEAM, &beam, middle, real_mul(track->speed[SSV_BODY_BEAM], half), is_last, last);
        }
        if (!matters(&last->near[SSV_BODY_VEHICLE]) && !matters(&last->near[SSV_BODY_BEAM])) {
            num--;
            continue;
        }
        stretch[num] = *last;
        stretch[num++].to = middle; // the first half is next
        last->from = middle;
    }
}

static real_t speed_of(ssv_twist_t twist, vec3_t p_S) { return vec3_norm(vec3_add(twist.v, vec3_cross(twist.w, p_S))); }

// Of these obstacles, those that anything comes near enough to count for a trial: a way of some length between two
// points stays within half of it around the middle between them.
static uint64_t within_reach(const ssv_flight_t* flight, const ssv_clearance_rule_t* rule, vec3_t p_end, real_t way_m,
                             real_t extent_m) {
    const vec3_t middle = vec3_scale(REAL(0.5), vec3_add(flight->X_IS.p, p_end));
    const real_t reach_m = real_mul(REAL(0.5), way_m) + extent_m + rule->enough_m + rule->bracket_m;
    const ssv_capsule_t ball = {middle, vec3(REAL(0), REAL(0), REAL(0)), REAL(0), reach_m};
    uint64_t near = flight->around->all.obstacles;
    for (uint64_t left = near; left != 0; left &= left - 1) {
        const ssv_obstacle_t* obstacle = &flight->around->scene->obstacle[__builtin_ctzll(left)];
        if (ssv_capsule_to_obstacle(&ball, obstacle) >= REAL(0)) near &= ~(left & (0 - left));
    }
    return near;
}

// How much of a maneuver takes the point that moves at this speed so far.
static real_t part_of(real_t way_m, real_t speed, real_t length) {
    if (!(way_m > REAL(0))) return REAL(0);
    return way_m >= real_mul(speed, length) ? length : real_min(length, real_div(way_m, speed));
}

void ssv_clearance_add(const ssv_flight_t* flight, const ssv_clearance_rule_t* rule, int first_leg,
                       ssv_clearance_t* clearance) {
    const ssv_scenario_t* s = flight->scenario;
    const ssv_surroundings_t* around = flight->around;
    const bool alone = flight->assembly->beam == NULL;
    const pose_t X_SB = flight->assembly->X_SB;
    const vec3_t p_SA = vec3_add(X_SB.p, quat_apply(X_SB.q, ssv_grasp_contact(s, 1)));
    const vec3_t p_SZ = vec3_add(X_SB.p, quat_apply(X_SB.q, ssv_grasp_contact(s, 2)));
    // The last stretch is measured along the way of the vehicle before it mates, and of the contact before it docks.
    const vec3_t p_SE = alone ? vec3(REAL(0), REAL(0), REAL(0)) : flight->contact == 1 ? p_SA : p_SZ;
    const ssv_obstacles_t none = {0, false, false}, beam = {0, true, false};
    pose_t at[SSV_MAX_PHASE_MANEUVERS + 1] = {flight->X_IS};
    real_t way_m = REAL(0);
    SSV_ASSERT(flight->num_maneuvers <= SSV_MAX_PHASE_MANEUVERS);
    for (int k = 0; k < flight->num_maneuvers; k++) {
        const ssv_maneuver_t* maneuver = &flight->maneuver[k];
        const bool moves = maneuver->length > REAL(0);
        at[k + 1] = moves ? ssv_maneuver_pose(at[k], maneuver->twist, maneuver->length) : at[k];
        way_m += real_mul(vec3_norm(maneuver->twist.v), maneuver->length);
    }
    ssv_obstacles_t vehicle_near = alone ? around->all : without(around->all, beam);
    if (rule->judges_contacts && vehicle_near.obstacles != 0) {
        const real_t held_m = alone ? REAL(0) : real_max(vec3_norm(p_SA), vec3_norm(p_SZ)) + s->beam.radius_m;
        const real_t extent_m = real_max(s->vehicle.radius_m, held_m);
        vehicle_near.obstacles = within_reach(flight, rule, at[flight->num_maneuvers].p, way_m, extent_m);
    }
    const ssv_obstacles_t beam_near = alone ? none : vehicle_near;
    track_t track = {.flight = flight,
                     .rule = rule,
                     .p_SA_m = p_SA,
                     .axis_S = quat_apply(X_SB.q, vec3(REAL(0), REAL(0), REAL(1))),
                     .leg = first_leg,
                     .clearance = clearance};
    real_t ahead_m = alone ? -around->mating_m : -around->docking_m;
    real_t behind_m = alone ? around->leaving_m : REAL(0);
    for (int k = 0; k < flight->num_maneuvers; k++) {
        ahead_m += real_mul(speed_of(flight->maneuver[k].twist, p_SE), flight->maneuver[k].length);
    }
    for (int k = 0; k < flight->num_maneuvers; k++) {
        const ssv_maneuver_t* maneuver = &flight->maneuver[k];
        const real_t length = maneuver->length, speed = speed_of(maneuver->twist, p_SE);
        if (!(length > REAL(0))) continue;
        track.X_IS = at[k];
        track.twist = maneuver->twist;
        track.speed[SSV_BODY_VEHICLE] = vec3_norm(maneuver->twist.v);
        track.speed[SSV_BODY_BEAM] = real_max(speed_of(maneuver->twist, p_SA), speed_of(maneuver->twist, p_SZ));
        const real_t left = part_of(behind_m, speed, length), arriving = part_of(ahead_m, speed, length);
        const real_t cut[4] = {REAL(0), real_min(left, arriving), real_max(left, arriving), length};
        stretch_t stretch[MAX_STRETCHES];
        int num = 0;
        for (int n = 2; n >= 0; n--) {
            if (!(cut[n] < cut[n + 1])) continue;
            stretch_t* next = &stretch[num++];
            *next = (stretch_t){cut[n], cut[n + 1], cut[n] < left, cut[n] >= arriving, {vehicle_near, beam_near}};
            if (rule->judges_contacts) continue;
            if (next->leaves) next->near[SSV_BODY_VEHICLE] = without(vehicle_near, around->left);
            if (next->arrives) {
                next->near[SSV_BODY_VEHICLE] = without(next->near[SSV_BODY_VEHICLE], beam);
                next->near[SSV_BODY_BEAM] = without(beam_near, around->at_port);
            }
        }
        follow(&track, stretch, num);
        track.leg++;
        ahead_m -= real_mul(speed, length);
        behind_m -= real_mul(speed, length);
    }
}

bool ssv_keeps_clear(const ssv_flight_t* flight, real_t bracket_m, ssv_clearance_t* clearance) {
    const real_t enough_m = flight->scenario->margin_m + SSV_MARGIN_ROOM_M;
    const ssv_clearance_rule_t rule = {enough_m, bracket_m, true, TRIAL_POSES};
    ssv_clearance_begin(enough_m + bracket_m, clearance);
    ssv_clearance_add(flight, &rule, 0, clearance);
    return clearance->certified_m >= enough_m;
}

void ssv_clearance_at(const ssv_surroundings_t* around, const ssv_obstacles_t* obstacles, ssv_moving_t body,
                      const ssv_capsule_t* shape, ssv_clearance_t* clearance) {
    const ssv_flight_t flight = {.around = around};
    const ssv_clearance_rule_t rule = {REAL(0), REAL(0), false, 1};
    const track_t track = {.flight = &flight, .rule = &rule, .clearance = clearance};
    stretch_t here = {REAL(0), REAL(0), false, false, {{0, false, false}, {0, false, false}}};
    here.near[body] = *obstacles;
    look(&track, body, shape, REAL(0), REAL(0), true, &here);
}

void ssv_plan_clearance(const ssv_problem_t* problem, const ssv_plan_t* plan, const ssv_scene_t* scene,
                        uint64_t obstacles, ssv_clearance_t* clearance) {
    const ssv_scenario_t* scenario = &problem->scenario;
    const ssv_clearance_rule_t rule = {scenario->margin_m, PLAN_BRACKET_M, false, PLAN_POSES};
    ssv_surroundings_t around;
    ssv_surroundings_of(scenario, scene, obstacles, &around);
    ssv_clearance_begin(REAL_MAX / 64, clearance);
    int num = 0;
    for (int phase = 0; around.counts && phase < 2; phase++) {
        if (num == plan->num_legs) break;
        const bool alone = phase == (int)SSV_TRANSIT;
        const ssv_assembly_t assembly = {&scenario->vehicle, alone ? NULL : &scenario->beam, plan->X_SB};
        ssv_maneuver_t maneuver[SSV_MAX_PHASE_MANEUVERS];
        ssv_flight_t flight = {scenario, &around, &assembly, plan->leg[num].X_IS_start, plan->quote.choice.contact,
                               maneuver, 0};
        const int first = num;
        for (; num < plan->num_legs && flight.num_maneuvers < SSV_MAX_PHASE_MANEUVERS &&
               plan->leg[num].phase == (ssv_phase_t)phase;
             num++) {
            const ssv_leg_t* leg = &plan->leg[num];
            maneuver[flight.num_maneuvers++] =
                (ssv_maneuver_t){leg->phase, leg->kind, {leg->v_S, leg->w_S}, leg->length, REAL(0)};
        }
        if (flight.num_maneuvers > 0) ssv_clearance_add(&flight, &rule, first, clearance);
    }
    if (clearance->obstacle == SSV_OBSTACLE_NONE) ssv_clearance_begin(REAL(0), clearance);
}
