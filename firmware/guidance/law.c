#include "guidance/law.h"

#include "guidance/limits.h"
#include "guidance/observer.h"
#include "planner/model/allocation.h"

static vec3_t velocity_of_C_I(pose_t X_IS, vec3_t v_S_m_s, vec3_t w_S_rad_s, vec3_t p_SC_m) {
    return quat_apply(X_IS.q, vec3_add(v_S_m_s, vec3_cross(w_S_rad_s, p_SC_m)));
}

ssv_law_error_t ssv_law_error(const ssv_guidance_t* guidance, const ssv_reference_t* reference) {
    const ssv_estimate_t* x = &guidance->estimate;
    const vec3_t r = guidance->body.p_SC_m;
    const pose_t off = pose_between(reference->X_IS, x->X_IS);
    const vec3_t r_ref = quat_apply(reference->X_IS.q, r), r_is = quat_apply(x->X_IS.q, r);
    return (ssv_law_error_t){vec3_add(vec3_sub(x->X_IS.p, reference->X_IS.p), vec3_sub(r_is, r_ref)),
                             vec3_sub(velocity_of_C_I(x->X_IS, x->v_S_m_s, x->w_S_rad_s, r),
                                      velocity_of_C_I(reference->X_IS, reference->v_S_m_s, reference->w_S_rad_s, r)),
                             ssv_observer_rotation(off.q),
                             vec3_sub(x->w_S_rad_s, quat_apply(quat_conj(off.q), reference->w_S_rad_s))};
}

// -(stiffness e + damping e'), per unit of mass, with a pole at -w: both there where drag damps less than that, else
// the other one where drag has put it.
static vec3_t feedback(real_t w, real_t drag, vec3_t error, vec3_t rate) {
    const real_t damping = real_max(real_mul(REAL(2), w) - drag, REAL(0));
    const real_t stiffness = real_mul(w, drag + damping - w);
    return vec3_neg(vec3_add(vec3_scale(stiffness, error), vec3_scale(damping, rate)));
}

// The largest share of `more`, at most 1, that keeps each thrust within the limit on top of `base`, which is within it.
static real_t share_that_fits(const real_t base_N[SSV_NUM_THRUSTERS], const real_t more_N[SSV_NUM_THRUSTERS],
                              real_t limit_N) {
    real_t share = REAL(1);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        const real_t room = more_N[i] > REAL(0) ? limit_N - base_N[i] : limit_N + base_N[i];
        const real_t size = real_abs(more_N[i]);
        if (size > room) share = real_min(share, real_div(real_max(room, REAL(0)), size));
    }
    return share;
}

void ssv_law_thrusts(const ssv_guidance_t* guidance, const ssv_reference_t* reference, const ssv_law_error_t* error,
                     real_t u_N[SSV_NUM_THRUSTERS]) {
    const ssv_guidance_body_t* body = &guidance->body;
    const ssv_estimate_t* x = &guidance->estimate;
    const ssv_allocation_t* allocation = &guidance->problem->allocation;
    const quat_t q_SI = quat_conj(x->X_IS.q);
    const ssv_wrench_t plan = ssv_observer_wrench(&guidance->problem->scenario.vehicle, reference->u_N);

    // A turn about C asks for the moment of inertia there, and about S for the force that moves S with it.
    const vec3_t turn = feedback(LAW_ATTITUDE_RAD_S, real_div(body->drag_Nm_s, body->inertia_kg_m2),
                                 error->rotation_S_rad, error->rate_S_rad_s);
    const ssv_wrench_t attitude =
        ssv_observer_inertia(body, (ssv_twist_t){vec3_neg(vec3_cross(turn, body->p_SC_m)), turn});
    real_t turning_N[SSV_NUM_THRUSTERS], moving_N[SSV_NUM_THRUSTERS];
    ssv_alloc(allocation, attitude.force, vec3_sub(vec3_add(plan.moment, attitude.moment), x->moment_S_Nm), turning_N);

    const vec3_t push = vec3_scale(
        body->mass_kg, feedback(LAW_POSITION_RAD_S, real_div(body->drag_kg_s, body->mass_kg),
                                quat_apply(q_SI, error->position_I_m), quat_apply(q_SI, error->velocity_I_m_s)));
    const vec3_t force = vec3_sub(vec3_add(plan.force, push), quat_apply(q_SI, x->force_I_N));
    ssv_alloc(allocation, force, vec3_cross(body->p_SC_m, push), moving_N);

    const real_t none_N[SSV_NUM_THRUSTERS] = {REAL(0)}, limit_N = guidance->config.force_max_N;
    const real_t turning = share_that_fits(none_N, turning_N, limit_N);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) turning_N[i] = real_mul(turning, turning_N[i]);
    const real_t moving = share_that_fits(turning_N, moving_N, limit_N);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        const real_t u = turning_N[i] + real_mul(moving, moving_N[i]);
        u_N[i] = real_max(-limit_N, real_min(limit_N, u));
    }
}
