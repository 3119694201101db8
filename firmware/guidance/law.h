/// Tracking law: thrusts that bring what moves back to a reference, attitude first where they do not reach for both.
#ifndef SSV_GUIDANCE_LAW_H
#define SSV_GUIDANCE_LAW_H

#include "ssv/guidance.h"

/// Where the vehicle should be, how it should move, and what that takes.
typedef struct {
    pose_t X_IS;
    vec3_t v_S_m_s, w_S_rad_s; ///< in axes of the reference
    real_t u_N[SSV_NUM_THRUSTERS];
} ssv_reference_t;

/// Errors of what moves at its centre of mass C.
typedef struct {
    vec3_t position_I_m, velocity_I_m_s; ///< estimate less reference
    vec3_t rotation_S_rad, rate_S_rad_s; ///< in axes of the estimate
} ssv_law_error_t;

ssv_law_error_t ssv_law_error(const ssv_guidance_t* guidance, const ssv_reference_t* reference);

/// The thrusts [N] for these errors, with the estimated disturbance cancelled; each within config.force_max_N.
void ssv_law_thrusts(const ssv_guidance_t* guidance, const ssv_reference_t* reference, const ssv_law_error_t* error,
                     real_t u_N[SSV_NUM_THRUSTERS]);

#endif
