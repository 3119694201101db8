/// Where the vehicle may take hold of the beam, and the turns that bring one direction onto another (paper Eqs. 3-5).
#ifndef SSV_GRASP_H
#define SSV_GRASP_H

#include "ssv/plan.h"

/// One way to take hold.
typedef struct {
    int contact;           ///< 1 or 2, the contact that will dock
    real_t height_m;       ///< [m] along z_B
    real_t ring_angle_rad; ///< [rad] about z_B from x_B
} ssv_grasp_t;

/// Ring angles to price: the given one, or the one nearest to the vehicle, or SSV_NUM_RING_ANGLES evenly spaced ones
/// when the vehicle stands on the beam's axis and no side is nearer. @return how many were written.
int ssv_grasp_ring_angles(const ssv_scenario_t* scenario, real_t ring_angle_rad[SSV_NUM_RING_ANGLES]);

/// From the beam's axis out to the vehicle's side of it, unit, in I.
vec3_t ssv_grasp_radial(const ssv_scenario_t* scenario, const ssv_grasp_t* grasp);

/// Where the vehicle's centre stands when mated, p_IS [m] (paper Eq. 4).
vec3_t ssv_grasp_position(const ssv_scenario_t* scenario, const ssv_grasp_t* grasp);

/// From the beam's centre to the contact that docks, p_B [m], in B; its direction is the beam's outward axis there.
vec3_t ssv_grasp_contact(const ssv_scenario_t* scenario, int contact);

/// Axes about which the smallest rotation takes unit vector from to unit vector to (paper Eq. 5), and its angle in [0,
/// pi]: one axis, or SSV_NUM_TURN_AXES evenly spaced ones when to = -from. @return how many were written, at least 1.
int ssv_grasp_turn_axes(vec3_t from, vec3_t to, vec3_t axis[SSV_NUM_TURN_AXES], real_t* angle_rad);

#endif
