/// Contact: how well vehicle and beam arrive where they mate and dock, and how far bodies are from what stands around.
#ifndef SIM_CONTACT_H
#define SIM_CONTACT_H

#include <stdbool.h>

#include "rigid_body.h"

/// Where on the beam the vehicle takes hold: its centre at the standoff from the beam's axis, its +x towards the axis,
/// its roll about +x free.
typedef struct {
    double standoff_m;
    double attach_height_m; ///< along the beam's z
    double ring_angle_rad;  ///< about the beam's z, from its x
} sim_mate_place_t;

/// Where the beam is to go: the end of the beam at the port, the outward axis there against the port's.
typedef struct {
    int contact;      ///< end of the beam: 1 at z = -length/2, 2 at +length/2
    double p_nP_m[3]; ///< port
    double axis_n[3]; ///< out of the port, a unit vector
} sim_port_t;

/// How far from its goal a craft is, and how fast.
typedef struct {
    double position_m;
    double angle_rad;
    double speed_m_s;
    double rate_rad_s;
} sim_arrival_t;

/// The vehicle against its place on a beam at rest.
sim_arrival_t sim_arrival_at_mate(const rb_state_t* vehicle, const rb_pose_t* X_nB, const sim_mate_place_t* place);

/// The carried beam against the port; the speed is the larger of that of the contact point and that of the vehicle.
/// @param X_bB pose of the beam in the vehicle's frame.
sim_arrival_t sim_arrival_at_dock(const rb_state_t* vehicle, const rb_pose_t* X_bB, double beam_length_m,
                                  const sim_port_t* port);

/// Whether no figure exceeds its limit; a limit of 0 limits nothing.
bool sim_arrival_within(const sim_arrival_t* arrival, const sim_arrival_t* limit);

/// The place on a beam that the vehicle is nearest to, for who does not know the plan.
sim_mate_place_t sim_mate_place_nearest(const rb_pose_t* vehicle, const rb_pose_t* X_nB, double beam_length_m,
                                        double standoff_m);

/// Between two unit vectors; exact near 0 and pi, where acos is not.
double sim_angle_rad(const double a[3], const double b[3]);

/// All points within the radius of the line from a to b; a sphere where they are equal.
typedef struct {
    double a_m[3], b_m[3];
    double radius_m;
} sim_capsule_t;

/// All points x with n . x <= offset_m; n is a unit vector.
typedef struct {
    double n[3];
    double offset_m;
} sim_half_space_t;

/// A tube with flat ends: all points that are within the radius of the line from a to b, and beside it. The capsule of
/// the same line and radius sticks out of both ends.
typedef struct {
    double a_m[3], b_m[3];
    double radius_m;
} sim_tube_t;

typedef enum { SIM_NO_TANK, SIM_BOX, SIM_CYLINDER } sim_tank_kind_t;

/// Water that must not be left: a box along the axes of {n}, or an upright cylinder.
typedef struct {
    sim_tank_kind_t kind;
    double from_m[3], to_m[3]; ///< corners of a box; of a cylinder the middle of its floor, and z of its lid alone
    double radius_m;           ///< of a cylinder
} sim_tank_t;

/// Signed distances between surfaces: negative by the depth to which they overlap; of a tube, by the depth of the
/// deepest point of the other's line, less its radius.
double sim_distance_m(const sim_capsule_t* one, const sim_capsule_t* other);
double sim_height_m(const sim_capsule_t* body, const sim_half_space_t* ground);
double sim_room_m(const sim_capsule_t* body, const sim_tank_t* tank);
double sim_tube_distance_m(const sim_tube_t* tube, const sim_capsule_t* other);
double sim_tube_height_m(const sim_tube_t* tube, const sim_half_space_t* ground);
double sim_tube_room_m(const sim_tube_t* tube, const sim_tank_t* tank);

#endif
