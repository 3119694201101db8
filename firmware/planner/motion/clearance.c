#include "planner/motion/clearance.h"

#include "planner/math/assert.h"
#include "planner/model/grasp.h"

#define NUM_BODIES 2
// Halves of halves under way. The longest maneuver of the largest tank comes down to the resolution in fewer.
#define MAX_STRETCHES 28
// A stretch on which nothing moves farther than this [m] is halved no more. Larger, and motions that keep the margin by
// less count as if they did not; smaller, and motions along an obstacle take longer.
#define RESOLUTION_M REAL(2.5e-4)
// Of a trial. More, and trials along an obstacle take longer; fewer, and some of these count as if they touched it.
#define TRIAL_POSES 1024
// Of the plan that is written: enough for the longest leg along a wall, all of which is equally near.
#define PLAN_BRACKET_M REAL(0.0045)
#define PLAN_POSES 32768

// A stretch of a maneuver, and what still matters to each body there.
typedef struct {
    real_t from, to;
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

// Looks at one body in the middle of a stretch and leaves what still matters.
static void look(const track_t* track, ssv_moving_t body, const ssv_capsule_t* shape, real_t s, real_t reach_m,
                 bool is_last, ssv_obstacles_t* near) {
    const ssv_surroundings_t* around = track->flight->around;
    is_last = is_last || reach_m <= RESOLUTION_M;
    for (uint64_t left = near->obstacles; left != 0; left &= left - 1) {
        const int k = __builtin_ctzll(left);
        const real_t distance_m = ssv_capsule_to_obstacle(shape, &around->scene->obstacle[k]);
        if (settles(track, body, k, distance_m, s, reach_m, is_last)) near->obstacles &= ~(left & (0 - left));
    }
    if (near->beam) {
        const real_t distance_m = ssv_capsule_to_obstacle(shape, &around->beam);
        near->beam = !settles(track, body, SSV_OBSTACLE_BEAM, distance_m, s, reach_m, is_last);
    }
    if (near->tank) {
        const real_t distance_m = ssv_capsule_to_tank(shape, &around->scene->tank);
        near->tank = !settles(track, body, SSV_OBSTACLE_TANK, distance_m, s, reach_m, is_last);
    }
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
            look(track, SSV_BODY_VEHICLE, &hull, middle, real_mul(track->speed[SSV_BODY_VEHICLE], half), is_last,
                 &last->near[SSV_BODY_VEHICLE]);
        }
        if (matters(&last->near[SSV_BODY_BEAM])) {
            const ssv_capsule_t beam = ssv_beam_from(s, vec3_add(X_IS.p, quat_apply(X_IS.q, track->p_SA_m)),
                                                     quat_apply(X_IS.q, track->axis_S));
            look(track, SSV_BODY_BEAM, &beam, middle, real_mul(track->speed[SSV_BODY_BEAM], half), is_last,
                 &last->near[SSV_BODY_BEAM]);
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
    const ssv_obstacles_t vehicle_near = alone ? around->all : without(around->all, beam);
    const ssv_obstacles_t beam_near = alone ? none : vehicle_near;
    track_t track = {.flight = flight,
                     .rule = rule,
                     .X_IS = flight->X_IS,
                     .p_SA_m = p_SA,
                     .axis_S = quat_apply(X_SB.q, vec3(REAL(0), REAL(0), REAL(1))),
                     .leg = first_leg,
                     .clearance = clearance};
    real_t ahead_m = alone ? -around->mating_m : -around->docking_m;
    for (int k = 0; k < flight->num_maneuvers; k++) {
        ahead_m += real_mul(speed_of(flight->maneuver[k].twist, p_SE), flight->maneuver[k].length);
    }
    for (int k = 0; k < flight->num_maneuvers; k++) {
        const ssv_maneuver_t* maneuver = &flight->maneuver[k];
        const real_t length = maneuver->length, speed = speed_of(maneuver->twist, p_SE),
                     way_m = real_mul(speed, length);
        if (!(length > REAL(0))) continue;
        track.twist = maneuver->twist;
        track.speed[SSV_BODY_VEHICLE] = vec3_norm(maneuver->twist.v);
        track.speed[SSV_BODY_BEAM] = real_max(speed_of(maneuver->twist, p_SA), speed_of(maneuver->twist, p_SZ));
        // Up to here nothing may be touched.
        const real_t free = ahead_m >= way_m       ? length
                            : !(ahead_m > REAL(0)) ? REAL(0)
                                                   : real_min(length, real_div(ahead_m, speed));
        stretch_t stretch[MAX_STRETCHES];
        int num = 0;
        if (free < length) {
            stretch[num++] =
                (stretch_t){free, length, {without(vehicle_near, beam), without(beam_near, around->at_port)}};
        }
        if (free > REAL(0)) stretch[num++] = (stretch_t){REAL(0), free, {vehicle_near, beam_near}};
        follow(&track, stretch, num);
        track.X_IS = ssv_maneuver_pose(track.X_IS, maneuver->twist, length);
        track.leg++;
        ahead_m -= way_m;
    }
}

bool ssv_keeps_clear(const ssv_flight_t* flight, real_t bracket_m, ssv_clearance_t* clearance) {
    const real_t enough_m = flight->scenario->margin_m + SSV_MARGIN_ROOM_M;
    const ssv_clearance_rule_t rule = {enough_m, bracket_m, TRIAL_POSES};
    ssv_clearance_begin(enough_m + bracket_m, clearance);
    ssv_clearance_add(flight, &rule, 0, clearance);
    return clearance->certified_m >= enough_m;
}

void ssv_clearance_at(const ssv_surroundings_t* around, const ssv_obstacles_t* obstacles, ssv_moving_t body,
                      const ssv_capsule_t* shape, ssv_clearance_t* clearance) {
    const ssv_flight_t flight = {.around = around};
    const ssv_clearance_rule_t rule = {REAL(0), REAL(0), 1};
    const track_t track = {.flight = &flight, .rule = &rule, .clearance = clearance};
    ssv_obstacles_t near = *obstacles;
    look(&track, body, shape, REAL(0), REAL(0), true, &near);
}

void ssv_plan_clearance(const ssv_problem_t* problem, const ssv_plan_t* plan, const ssv_scene_t* scene,
                        uint64_t obstacles, ssv_clearance_t* clearance) {
    const ssv_scenario_t* scenario = &problem->scenario;
    const ssv_clearance_rule_t rule = {scenario->margin_m, PLAN_BRACKET_M, PLAN_POSES};
    ssv_surroundings_t around;
    ssv_surroundings_of(scenario, scene, obstacles, &around);
    ssv_clearance_begin(REAL_MAX / 64, clearance);
    int num = 0;
    for (int phase = 0; around.counts && phase < 2; phase++) {
        if (num == plan->num_legs) break;
        const bool alone = phase == (int)SSV_TRANSIT;
        const ssv_assembly_t assembly = {&scenario->vehicle, alone ? NULL : &scenario->beam, plan->X_SB};
        ssv_maneuver_t maneuver[SSV_MAX_LEGS];
        ssv_flight_t flight = {scenario, &around, &assembly, plan->leg[num].X_IS_start, plan->quote.choice.contact,
                               maneuver, 0};
        const int first = num;
        for (; num < plan->num_legs && plan->leg[num].phase == (ssv_phase_t)phase; num++) {
            const ssv_leg_t* leg = &plan->leg[num];
            maneuver[flight.num_maneuvers++] =
                (ssv_maneuver_t){leg->phase, leg->kind, {leg->v_S, leg->w_S}, leg->length, REAL(0)};
        }
        if (flight.num_maneuvers > 0) ssv_clearance_add(&flight, &rule, first, clearance);
    }
    if (clearance->obstacle == SSV_OBSTACLE_NONE) ssv_clearance_begin(REAL(0), clearance);
}
