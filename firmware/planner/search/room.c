#include "planner/search/room.h"

#include "planner/model/grasp.h"
#include "planner/model/shape.h"
#include "planner/motion/clearance.h"

// Sides of a beam that are looked at, evenly all round, and how far from one of them, at most, any other is, as a
// share of the standoff: the chord of half a step.
#define NUM_SIDES SSV_NUM_RING_ANGLES
#define FARTHEST_SIDE REAL(0.197)

static bool blocks(const ssv_clearance_t* clearance, real_t enough_m, ssv_outcome_t outcome,
                   ssv_candidate_t* candidate) {
    if (clearance->seen_m >= enough_m) return false;
    candidate->outcome = outcome;
    candidate->body = clearance->body;
    candidate->obstacle = clearance->obstacle;
    candidate->clearance_m = clearance->seen_m;
    return true;
}

static real_t square(real_t a, real_t b) { return real_sq(a) + real_sq(b); }

// Whether the vehicle may touch its beam where it starts: it is as close as it would be on the last stretch.
static bool starts_mating(const ssv_scenario_t* s, const ssv_surroundings_t* around, real_t height_m) {
    const vec3_t p_BS = pose_between(s->X_IB, s->X_IS).p;
    const real_t off_ring_m = vec3_norm(vec3(p_BS.x, p_BS.y, REAL(0))) - s->standoff_m;
    return s->attach_anywhere || square(off_ring_m, p_BS.z - height_m) <= real_sq(around->mating_m);
}

// The vehicle beside a beam that lies along axis_I, its centre a standoff away from hold_I: on the side that has most
// room, or on the one that is given.
static void beside(const ssv_problem_t* problem, const ssv_obstacles_t* obstacles, vec3_t hold_I, vec3_t axis_I,
                   const vec3_t* given_I, real_t enough_m, ssv_clearance_t* most) {
    const ssv_scenario_t* s = &problem->scenario;
    const vec3_t side_I = vec3_perpendicular(axis_I), other_I = vec3_cross(axis_I, side_I);
    const real_t step = real_div(real_mul(REAL(2), REAL_PI), real_from_int(NUM_SIDES));
    for (int k = 0; k < (given_I != NULL ? 1 : NUM_SIDES); k++) {
        const real_t angle = real_mul(step, real_from_int(k));
        const vec3_t radial_I =
            given_I != NULL ? *given_I
                            : vec3_add(vec3_scale(real_cos(angle), side_I), vec3_scale(real_sin(angle), other_I));
        const ssv_capsule_t hull = ssv_hull_at(s, vec3_add(hold_I, vec3_scale(s->standoff_m, radial_I)));
        ssv_clearance_t here;
        ssv_clearance_begin(enough_m, &here);
        ssv_clearance_at(&problem->around, obstacles, SSV_BODY_VEHICLE, &hull, &here);
        if (k == 0 || here.seen_m > most->seen_m) *most = here;
        if (most->seen_m >= enough_m) break;
    }
}

void ssv_room_check(const ssv_question_t* question, ssv_candidate_t* candidate) {
    const ssv_problem_t* problem = question->problem;
    const ssv_scenario_t* s = &problem->scenario;
    const ssv_surroundings_t* around = &problem->around;
    const real_t enough_m = s->margin_m + SSV_MARGIN_ROOM_M, height_m = candidate->attach_height_m;
    const vec3_t axis_I = around->beam.axis_I;
    const ssv_obstacles_t scene = {around->all.obstacles, false, around->all.tank};
    const ssv_obstacles_t start = {scene.obstacles & ~around->left.obstacles, !starts_mating(s, around, height_m),
                                   scene.tank};
    const ssv_obstacles_t goal = {scene.obstacles & ~around->at_port.obstacles, false,
                                  scene.tank && !around->at_port.tank};
    const ssv_capsule_t hull = ssv_hull_at(s, s->X_IS.p), lying = ssv_beam_from(s, around->beam.p_I_m, axis_I),
                        docked = ssv_beam_from(s, s->p_IP_m, s->axis_I);
    ssv_clearance_t clearance;
    ssv_clearance_begin(enough_m, &clearance);
    ssv_clearance_at(around, &start, SSV_BODY_VEHICLE, &hull, &clearance);
    ssv_clearance_at(around, &scene, SSV_BODY_BEAM, &lying, &clearance);
    if (blocks(&clearance, enough_m, SSV_START_BLOCKED, candidate)) return;
    ssv_clearance_at(around, &goal, SSV_BODY_BEAM, &docked, &clearance);
    if (blocks(&clearance, enough_m, SSV_GOAL_BLOCKED, candidate)) return;

    const ssv_grasp_t grasp = {candidate->contact, height_m, s->ring_angle_rad};
    const vec3_t given_I = ssv_grasp_radial(s, &grasp);
    const real_t from_contact = real_abs(ssv_grasp_contact(s, candidate->contact).z - height_m);
    const real_t any_side_m = enough_m - real_mul(FARTHEST_SIDE, s->standoff_m);
    const real_t some_side_m = s->ring_angle_given ? enough_m : any_side_m;
    beside(problem, &scene, vec3_add(s->X_IB.p, vec3_scale(height_m, axis_I)), axis_I,
           s->ring_angle_given ? &given_I : NULL, some_side_m, &clearance);
    if (blocks(&clearance, some_side_m, SSV_MATE_BLOCKED, candidate)) return;
    beside(problem, &scene, vec3_add(s->p_IP_m, vec3_scale(from_contact, s->axis_I)), s->axis_I, NULL, any_side_m,
           &clearance);
    (void)blocks(&clearance, any_side_m, SSV_GOAL_BLOCKED, candidate);
}
