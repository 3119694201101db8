/// Shapes: how far the vehicle's hull and the beam are from what stands around, at one pose (DESIGN.md 13).
#ifndef SSV_SHAPE_H
#define SSV_SHAPE_H

#include "ssv/planner.h"

/// A moving body as a capsule: all that is within radius_m of the line from p_I_m along axis_I. The hull is one of no
/// length. The beam's line runs from contact to contact: its flat ends are inside, and the capsule sticks out of them
/// by the radius of the tube.
typedef struct {
    vec3_t p_I_m, axis_I;
    real_t length_m, radius_m;
} ssv_capsule_t;

/// From the surface of a moving body to that of an obstacle [m], negative inside.
real_t ssv_capsule_to_obstacle(const ssv_capsule_t* body, const ssv_obstacle_t* obstacle);

/// To the nearest side of the tank [m], negative outside of it.
real_t ssv_capsule_to_tank(const ssv_capsule_t* body, const ssv_tank_t* tank);

ssv_capsule_t ssv_hull_at(const ssv_scenario_t* scenario, vec3_t p_IS_m);

/// The beam with its contact 1 there, its z axis along axis_I.
ssv_capsule_t ssv_beam_from(const ssv_scenario_t* scenario, vec3_t contact_1_I_m, vec3_t axis_I);

/// What a scenario has around it, given a scene and a choice of its obstacles.
void ssv_surroundings_of(const ssv_scenario_t* scenario, const ssv_scene_t* scene, uint64_t obstacles,
                         ssv_surroundings_t* around);

#endif
