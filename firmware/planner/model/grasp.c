#include "planner/model/grasp.h"

// Closer than this to the beam's axis [m], the vehicle has no nearest side; a survey is not that good.
#define ON_AXIS REAL(1e-6)
// Directions whose cross product is smaller than this [rad] are parallel or opposite.
#define PARALLEL REAL(1e-8)

int ssv_grasp_ring_angles(const ssv_scenario_t* scenario, real_t ring_angle_rad[SSV_NUM_RING_ANGLES]) {
    if (scenario->ring_angle_given) {
        ring_angle_rad[0] = scenario->ring_angle_rad;
        return 1;
    }
    const vec3_t p_BS = pose_between(scenario->X_IB, scenario->X_IS).p;
    if (vec3_norm(vec3(p_BS.x, p_BS.y, REAL(0))) > ON_AXIS) {
        ring_angle_rad[0] = real_atan2(p_BS.y, p_BS.x);
        return 1;
    }
    const real_t step = real_div(real_mul(REAL(2), REAL_PI), real_from_int(SSV_NUM_RING_ANGLES));
    for (int k = 0; k < SSV_NUM_RING_ANGLES; k++) {
        ring_angle_rad[k] = real_mul(step, real_from_int(k + 1 - SSV_NUM_RING_ANGLES / 2));
    }
    return SSV_NUM_RING_ANGLES;
}

static vec3_t radial_B(const ssv_grasp_t* grasp) {
    return vec3(real_cos(grasp->ring_angle_rad), real_sin(grasp->ring_angle_rad), REAL(0));
}

vec3_t ssv_grasp_radial(const ssv_scenario_t* scenario, const ssv_grasp_t* grasp) {
    return quat_apply(scenario->X_IB.q, radial_B(grasp));
}

vec3_t ssv_grasp_position(const ssv_scenario_t* scenario, const ssv_grasp_t* grasp) {
    const vec3_t p_BS =
        vec3_add(vec3_scale(scenario->standoff_m, radial_B(grasp)), vec3(REAL(0), REAL(0), grasp->height_m));
    return vec3_add(scenario->X_IB.p, quat_apply(scenario->X_IB.q, p_BS));
}

vec3_t ssv_grasp_contact(const ssv_scenario_t* scenario, int contact) {
    const real_t half = real_mul(REAL(0.5), scenario->beam.length_m);
    return vec3(REAL(0), REAL(0), contact == 1 ? -half : half);
}

int ssv_grasp_turn_axes(vec3_t from, vec3_t to, vec3_t axis[SSV_NUM_TURN_AXES], real_t* angle_rad) {
    const vec3_t cross = vec3_cross(from, to);
    const real_t sine = vec3_norm(cross), cosine = vec3_dot(from, to);
    const vec3_t side = vec3_perpendicular(from);
    *angle_rad = real_atan2(sine, cosine);
    if (sine > PARALLEL) {
        axis[0] = vec3_unit(cross);
        return 1;
    }
    if (cosine > REAL(0)) {
        axis[0] = side;
        return 1;
    }
    const real_t step = real_div(real_mul(REAL(2), REAL_PI), real_from_int(SSV_NUM_TURN_AXES));
    for (int k = 0; k < SSV_NUM_TURN_AXES; k++) {
        axis[k] = quat_apply(quat_from_axis_angle(from, real_mul(step, real_from_int(k))), side);
    }
    *angle_rad = REAL_PI;
    return SSV_NUM_TURN_AXES;
}
