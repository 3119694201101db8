/// Observer: the planner's rigid-body model driven by the commanded thrusts, corrected by pose measurements, with a
/// steady force and moment that it estimates.
#ifndef SSV_GUIDANCE_OBSERVER_H
#define SSV_GUIDANCE_OBSERVER_H

#include "planner/model/body.h"
#include "ssv/guidance.h"

/// The assembly under way: the vehicle, with the beam once mated.
ssv_assembly_t ssv_observer_assembly(const ssv_guidance_t* guidance);

/// Fills in guidance->body for what moves now.
void ssv_observer_set_body(ssv_guidance_t* guidance);

/// Forgets the history: the estimate now is all that is known.
void ssv_observer_restart(ssv_guidance_t* guidance);

/// Goes on by dt_s under guidance->command_N.
void ssv_observer_predict(ssv_guidance_t* guidance, real_t dt_s);

/// mass * twist: the wrench of an acceleration, without drag and gyration.
ssv_wrench_t ssv_observer_inertia(const ssv_guidance_body_t* body, ssv_twist_t acceleration);

/// The wrench on S of thrusts.
ssv_wrench_t ssv_observer_wrench(const ssv_vehicle_t* vehicle, const real_t u_N[SSV_NUM_THRUSTERS]);

/// The rotation vector of a turn, by the smaller way round.
vec3_t ssv_observer_rotation(quat_t q);

#endif
