/// The question that the planner answers: vehicle, beam, port, and what the asker fixes beforehand. Types alone; the
/// functions are in ssv/planner.h.
///
/// Frames (right-handed, SI units, names end in their unit): I inertial; S vehicle, origin at its centre of mass,
/// contact point on +x; B beam, origin at its centre of mass, z along the tube, contact 1 at z = -length/2, contact 2
/// at z = +length/2; C the centre of mass of vehicle and beam, axes of S. A 6-vector wrench is [force; moment] in axes
/// of S, the moment about S. "paper" is C. L. R. McGhan, "A Trajectory Planner for Autonomous Structural Assembly".
#ifndef SSV_SCENARIO_H
#define SSV_SCENARIO_H

#include "ssv/real.h"
#include "ssv/timeline.h"
#include "ssv/vec3.h"

#define SSV_NUM_CONTACTS 2
#define SSV_MAX_ATTACH_HEIGHTS 8

/// How far from unit length a quaternion or direction may be; closer is normalised, farther is refused.
#define SSV_UNIT_TOLERANCE REAL(1e-3)

typedef enum {
    SSV_OK = 0,
    SSV_INFEASIBLE = 1, ///< a sound question to which no candidate is an answer
    SSV_NUMERIC_OVERFLOW =
        2, ///< a sound question, but a number on the way to its answer did not fit the scalar: ask a planner
           ///< of another one (ssv/real.h). A candidate that would have been rejected counts too
    SSV_E_NOT_FINITE = -1, ///< a NaN or an infinity
    SSV_E_RANGE = -2,      ///< outside the range that its field states
    SSV_E_NOT_UNIT = -3,   ///< a quaternion or direction farther than SSV_UNIT_TOLERANCE from unit length
    SSV_E_SINGULAR = -4,   ///< thrusters that cannot hold every force and moment
    SSV_E_WEIGHTS = -5,    ///< both weights zero: every plan would cost nothing
    SSV_E_IMPOSSIBLE = -6, ///< within its range, but nothing can be so: moments of inertia, or a standoff inside
    SSV_E_TOO_FINE = -7    ///< so small that the scalar has too few digits of it: ask a planner of another one
} ssv_status_t;

/// One rigid body, neutrally buoyant. Drag on it is -(drag_lin + drag_quad |v|) v at its centre of mass and
/// -(drag_lin_ang + drag_quad_ang |w|) w; zero is a valid value. Added mass adds to mass_kg for motion along each body
/// axis.
typedef struct {
    real_t mass_kg;           ///< [kg] [0.01, 10000]
    vec3_t inertia_kg_m2;     ///< [kg m2] principal, about the body's x, y, z, each [1e-9, 10000000], none larger than
                              ///< the others together; of the vehicle in fixed point 1.53e-5 or more
    vec3_t added_mass_kg;     ///< [kg] along x, y, z, each [0, 10000]
    real_t drag_lin_kg_s;     ///< [N/(m/s)] [0, 100000]
    real_t drag_quad_kg_m;    ///< [N/(m/s)2] [0, 100000]
    real_t drag_lin_ang_Nm_s; ///< [N m/(rad/s)] [0, 100000]
    real_t drag_quad_ang_Nm_s2; ///< [N m/(rad/s)2] [0, 100000]
} ssv_body_t;

typedef struct {
    vec3_t p_ST_m; ///< [m] position of thruster T in S, each |x| <= 10
    vec3_t n_T_S;  ///< [-] unit, direction of positive force in S
} ssv_thruster_t;

/// The vehicle S: contact point on +x at radius_m.
typedef struct {
    ssv_body_t body;
    real_t radius_m;    ///< [m] [0.001, 10] hull
    real_t force_max_N; ///< [N] [0.001, 10000] each thruster gives -force_max_N..+force_max_N (paper F_MAX)
    ssv_thruster_t thruster[SSV_NUM_THRUSTERS];
} ssv_vehicle_t;

/// The beam B: a tube along z.
typedef struct {
    ssv_body_t body;
    real_t radius_m;         ///< [m] [0.001, 10] outer
    real_t length_m;         ///< [m] [0.01, 100]
    real_t drag_strip_kg_m2; ///< [N/(m/s)2 per m] [0, 100000] cross-flow drag of each strip, 0.5 rho Cd 2R; none along
                             ///< the axis
} ssv_beam_t;

/// What decides the free choices.
typedef enum {
    SSV_METHOD_OPTIMAL = 0, ///< all by J: travel attitude, pivots, ring angle, both free rolls; optimal profiles
    SSV_METHOD_PAPER = 1    ///< the paper's rule: nearest ring angle, translate then turn; turn about C then translate
} ssv_method_t;

/// How many motions SSV_METHOD_OPTIMAL tries.
typedef enum { SSV_EFFORT_QUICK = 0, SSV_EFFORT_BEST = 1 } ssv_effort_t;

#define SSV_MAX_OBSTACLES 64

typedef enum {
    SSV_CAPSULE = 0, ///< all that is within a radius of a line: a tube with round ends, a sphere if it has no length
    SSV_WALL = 1     ///< all that is behind a plane
} ssv_obstacle_kind_t;

/// What stands in the way, fixed in I.
typedef struct {
    ssv_obstacle_kind_t kind;
    vec3_t p_I_m;    ///< [m] where a capsule's line begins; a point of a wall; each |x| <= 1000
    vec3_t axis_I;   ///< [-] unit, along a capsule's line; out of a wall, to where one may be. Used as it stands, so it
                     ///< must be of unit length within SSV_AXIS_TOLERANCE; a sphere needs none
    real_t length_m; ///< [m] [0, 1000] of a capsule's line
    real_t radius_m; ///< [m] [0, 100] of a capsule
} ssv_obstacle_t;

#define SSV_AXIS_TOLERANCE REAL(1e-5)

typedef enum {
    SSV_NO_TANK = 0,
    SSV_BOX = 1,     ///< along the axes of I
    SSV_CYLINDER = 2 ///< upright, its axis along z of I
} ssv_tank_kind_t;

/// What must not be left.
typedef struct {
    ssv_tank_kind_t kind;
    vec3_t from_I_m; ///< [m] least x, y, z of a box; centre of a cylinder's floor; each |x| <= 1000
    vec3_t to_I_m;   ///< [m] greatest x, y, z of a box; of a cylinder z alone, its lid; each |x| <= 1000
    real_t radius_m; ///< [m] [0.001, 1000] of a cylinder
} ssv_tank_t;

/// What stands around. Several scenarios may share one, each with a choice of its own among the obstacles.
typedef struct {
    int num_obstacles; ///< [0, SSV_MAX_OBSTACLES]
    ssv_obstacle_t obstacle[SSV_MAX_OBSTACLES];
    ssv_tank_t tank;
} ssv_scene_t;

/// One question, unchecked: any value may stand here. Nothing is looked up elsewhere.
typedef struct {
    ssv_vehicle_t vehicle;
    ssv_beam_t beam;
    pose_t X_IS;              ///< vehicle at the start, at rest; each |p| <= 1000 m, q unit
    pose_t X_IB;              ///< beam at the start, at rest; likewise
    vec3_t p_IP_m;            ///< [m] hub port, where the beam's contact point must end, each |x| <= 1000
    vec3_t axis_I;            ///< [-] unit, out of the hub; the docked beam's outward axis points against it
    int contact;              ///< beam contact that docks: 1, 2, or 0 for either
    real_t standoff_m;        ///< [m] [0.001, 20] vehicle centre to beam axis when mated: the sum of the radii (paper
                              ///< Eq. 4) or more, or that of the hull alone (the paper's tables: the beam is a line)
    real_t weight_time_per_s; ///< [1/s] [0, 1000] W1 of J = W1 T + W2 F (paper Eq. 16); legs are shaped as if >= 0.01 N
                              ///< x W2
    real_t weight_impulse_per_Ns; ///< [1/(N s)] [0, 1000] W2; not both zero
    real_t thrust_reserve; ///< [-] [0, 0.9) share of every thruster that the plan leaves for tracking; 0.9 is refused
    ssv_method_t method;
    ssv_effort_t effort;    ///< of SSV_METHOD_OPTIMAL
    int num_attach_heights; ///< [0, SSV_MAX_ATTACH_HEIGHTS]; 0 = the three rings +length/2, 0, -length/2 (paper Eq. 3)
    real_t attach_heights_m[SSV_MAX_ATTACH_HEIGHTS]; ///< [m] along z_B, each |h| <= length/2
    bool attach_anywhere;  ///< whether SSV_METHOD_OPTIMAL goes on between them, from the best one; takes several times
                           ///< as long
    bool want_candidates;  ///< whether the answer lists every candidate; all are searched then, which takes longer and
                           ///< may find a lower price
    bool ring_angle_given; ///< whether ring_angle_rad holds
    real_t ring_angle_rad; ///< [rad] |angle| <= 2 pi, about z_B from x_B, the side of the beam to mate on
    /// What stands around, or NULL. By reference: the questions of a batch share one, and it would be five times as
    /// large as all the rest. It must stay as it is as long as the problem is in use. Obstacle k counts if bit k of
    /// `obstacles` is set, the tank always. The planner keeps clear of things as soon as there is one, or a margin;
    /// then the vehicle keeps clear of its own beam too, up to the last stretch before it mates (DESIGN.md 13).
    const ssv_scene_t* scene;
    uint64_t obstacles;
    uint64_t left;   ///< of these, what the vehicle stands at and lets go of: it may touch them over the first stretch,
                     ///< no deeper than where it starts. A beam that was docked last is one
    real_t margin_m; ///< [m] [0, 10] how far vehicle and beam stay away from all of that
    real_t approach_mate_m; ///< [m] [0, 10] before mating the vehicle comes straight along the contact's normal so
                            ///< far; 0 = as it comes
    real_t approach_dock_m; ///< [m] [0, 10] before docking the beam comes straight along the port's axis so far;
                            ///< 0 = as it comes
    real_t contact_speed_max_m_s;       ///< [m/s] [0, 100] on these two stretches; 0 = none
    real_t transit_speed_max_m_s;       ///< [m/s] [0, 100] of the vehicle alone; 0 = none, and so below
    real_t transit_rate_max_rad_s;      ///< [rad/s] [0, 100] of its turning
    real_t transfer_speed_max_m_s;      ///< [m/s] [0, 100] of the vehicle with the beam
    real_t transfer_beam_speed_max_m_s; ///< [m/s] [0, 100] of both ends of the beam then
    real_t transfer_rate_max_rad_s;     ///< [rad/s] [0, 100] of the turning then
} ssv_scenario_t;

/// What thrusters cannot do, or hardly: a unit vector or zero each.
typedef struct {
    vec3_t push_S; ///< [-] a force along it
    vec3_t turn_S; ///< [-] a moment about it
    bool coupled;  ///< whether each of the two can be had with the other, and only so
} ssv_lack_t;

/// What is wrong with a scenario, where.
typedef struct {
    ssv_status_t status;
    const char* field; ///< path of the field in scenario_t, e.g. "vehicle.thruster[i].n_T_S"; static storage
    int index;         ///< which element where the path has brackets, else -1
    real_t value;      ///< the offending number (for SSV_E_NOT_UNIT the length)
    real_t min, max;   ///< what would be accepted (SSV_E_RANGE, SSV_E_NOT_UNIT, SSV_E_IMPOSSIBLE, SSV_E_TOO_FINE)
    ssv_lack_t lack;   ///< SSV_E_SINGULAR: what the thrusters cannot do; else zero
} ssv_fault_t;

#endif
