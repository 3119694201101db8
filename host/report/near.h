/// What is nearest to the vehicle and its beam at one instant: the same bodies, distances and allowed contacts as the
/// planner's (DESIGN.md 13), with the two points between which the distance is.
#ifndef SSV_NEAR_H
#define SSV_NEAR_H

#include <stdbool.h>

#include "lcm_ssv_plan_t.h"
#include "lcm_ssv_task_t.h"
#include "ssv/planner.h"

/// The nearest pair; `obstacle` is as in clearance_t, OBSTACLE_NONE where there is nothing.
typedef struct {
    int8_t body, obstacle;
    double distance_m; ///< [m] between their surfaces, negative: inside
    double p_body_I_m[3], p_obstacle_I_m[3];
} near_t;

/// What a task has around it, with the ways on which a contact is allowed.
typedef struct {
    const lcm_ssv_task_t* task;
    const ssv_surroundings_t* around;
    lcm_ssv_pose_t X_SB;
} near_scene_t;

/// Where on its way the vehicle is: such a pose, what it holds, and how far it has come in this phase and has to go,
/// the vehicle before it mates, the beam's contact before it docks. A contact is judged where both are infinite.
typedef struct {
    lcm_ssv_pose_t X_IS;
    bool mated;
    double behind_m, ahead_m;
} near_place_t;

/// The nearest pair at a place.
near_t near_at(const near_scene_t* scene, const near_place_t* place);

/// The pair of this body and this obstacle there.
near_t near_pair(const near_scene_t* scene, const near_place_t* place, int8_t body, int8_t obstacle);

// Vectors and poses of the wire.

/// out = X p, a point of a body in I.
void near_point(const lcm_ssv_pose_t* X, const double p[3], double out[3]);

/// X_AC = X_AB X_BC.
lcm_ssv_pose_t near_compose(const lcm_ssv_pose_t* X_AB, const lcm_ssv_pose_t* X_BC);
lcm_ssv_pose_t near_inverse(const lcm_ssv_pose_t* X);

#endif
