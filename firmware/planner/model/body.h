/// Rigid bodies and their drag: the wrench that thrusters must give to move along a constant body twist (model of
/// DESIGN.md 3).
#ifndef SSV_BODY_H
#define SSV_BODY_H

#include "ssv/plan.h"

/// Force [N] and moment about S [N m], in axes of S.
typedef struct {
    vec3_t force, moment;
} ssv_wrench_t;

/// Velocity of S and rate, in axes of S.
typedef struct {
    vec3_t v, w;
} ssv_twist_t;

/// What moves as one rigid body: the vehicle, and the beam too once mated.
typedef struct {
    const ssv_vehicle_t* vehicle;
    const ssv_beam_t* beam; ///< NULL while the vehicle is alone
    pose_t X_SB;            ///< beam in S; meaningful with a beam
} ssv_assembly_t;

/// Wrench = accel s'' + linear s' + quadratic s'^2 while the assembly moves with twist * s'.
typedef struct {
    ssv_wrench_t accel, linear, quadratic;
} ssv_demand_t;

/// Demand along a twist: inertia with added mass (Kirchhoff's equations), linear and quadratic drag, strip drag of the
/// beam, centripetal and gyroscopic terms. s' >= 0. Costs some 20 square roots with a beam that turns.
void ssv_body_demand(const ssv_assembly_t* assembly, ssv_twist_t twist, ssv_demand_t* demand);

/// Centre of mass C in S (paper Table 6), added mass left out.
vec3_t ssv_body_centre(const ssv_assembly_t* assembly);

#endif
