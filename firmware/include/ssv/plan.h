/// The answer to a question: candidates, price, plan with its thruster timeline, front, and the plan at one instant.
/// Types alone; the functions are in ssv/planner.h. Frames and units as in ssv/scenario.h.
#ifndef SSV_PLAN_H
#define SSV_PLAN_H

#include "ssv/scenario.h"
#include "ssv/timeline.h"

#define SSV_MAX_CANDIDATES (SSV_NUM_CONTACTS * SSV_MAX_ATTACH_HEIGHTS)
#define SSV_MAX_LEGS 8
/// Arcs of all legs together; one arc has one quadratic dv/dt = a0 + a1 v + a2 v^2 of the speed along a leg.
#define SSV_MAX_ARCS 80
/// Most points of a front.
#define SSV_MAX_FRONT 24

/// Longest plan; a candidate that takes longer is infeasible.
#define SSV_DURATION_MAX_S REAL(20000)
/// The timeline's thrust stays within this fraction of force_max_N of the exact thrust.
#define SSV_TIMELINE_TOLERANCE REAL(0.005)
/// Speeds at which a drag-only ramp ends and the short full reverse begins (paper Table 3's cut-offs).
#define SSV_CUTOFF_TRANSLATE_M_S REAL(0.001)
#define SSV_CUTOFF_TURN_RAD_S REAL(0.01)
/// Ring angles tried when every side of the beam is equally near (paper Eq. 4 has no answer there).
#define SSV_NUM_RING_ANGLES 16
/// Turning axes tried when the goal is half a turn away (paper Eq. 5 has no answer there).
#define SSV_NUM_TURN_AXES 16

/// Why a candidate is not feasible.
typedef enum {
    SSV_FEASIBLE = 0,
    SSV_TOO_LONG,          ///< would take longer than SSV_DURATION_MAX_S
    SSV_NO_AUTHORITY,      ///< the thrusters cannot move the body along a leg
    SSV_TOO_MANY_ARCS,     ///< the motion has more arcs than SSV_MAX_ARCS
    SSV_TOO_MANY_SEGMENTS, ///< the timeline has more segments than SSV_MAX_SEGMENTS
    // From here on the candidate names the obstacle.
    SSV_NO_WAY,        ///< no way was found that keeps clear of it
    SSV_START_BLOCKED, ///< it is too near the vehicle, or the beam, where that starts
    SSV_MATE_BLOCKED,  ///< it is too near the vehicle wherever that mates at this height
    SSV_GOAL_BLOCKED   ///< it is too near the docked beam, or the vehicle on any side of it
} ssv_outcome_t;

/// What moves: the vehicle's hull, a sphere; once mated the beam, a tube with flat ends.
typedef enum { SSV_BODY_VEHICLE = 0, SSV_BODY_BEAM = 1 } ssv_moving_t;

/// Numbers of what is no obstacle of the scene.
#define SSV_OBSTACLE_NONE (-1) ///< there is nothing to keep clear of
#define SSV_OBSTACLE_BEAM 64   ///< the beam as it lies, during the transit
#define SSV_OBSTACLE_TANK 65

typedef enum { SSV_TRANSIT = 0, SSV_TRANSFER = 1 } ssv_phase_t; ///< vehicle alone; vehicle with beam
typedef enum {
    SSV_TRANSLATE = 0,
    SSV_TURN = 1,
    SSV_SCREW = 2
} ssv_leg_kind_t; ///< straight; about an axis; both at once
typedef enum {
    SSV_FULL_REVERSE = 0,
    SSV_DRAG_ONLY = 1,
    SSV_OPTIMAL = 2
} ssv_ramp_t; ///< how a leg slows (paper Figs. 6, 7)

/// A stretch of a leg in which the speed v along it follows dv/dt = dv_dt[0] + dv_dt[1] v + dv_dt[2] v^2.
typedef struct {
    real_t t_s;            ///< [s] start, since the leg's start
    real_t duration_s;     ///< [s] > 0
    real_t s;              ///< [m or rad] distance along the leg at the start
    real_t v_start, v_end; ///< [m/s or rad/s]
    real_t dv_dt[3];
} ssv_arc_t;

/// One rest-to-rest motion along a constant body twist. Speeds and distances along it are in rad for SSV_TURN, else in
/// m along the path of S.
typedef struct {
    ssv_phase_t phase;
    ssv_leg_kind_t kind;
    ssv_ramp_t ramp;
    real_t t_start_s;  ///< [s] since plan start
    real_t duration_s; ///< [s]
    real_t impulse_Ns; ///< [N s] integral of the sum of absolute thrusts
    real_t length;     ///< [m or rad]
    real_t peak_speed; ///< [m/s or rad/s]
    vec3_t v_S, w_S;   ///< twist of S in axes of S per unit of speed: |w_S| = 1 for SSV_TURN, else |v_S| = 1
    pose_t X_IS_start, X_IS_end;
    int first_arc, num_arcs; ///< into plan.arc
} ssv_leg_t;

/// A stretch of the thruster timeline; each thrust runs on a straight line from its start to its end value, with the
/// impulse and the first moment of what the motion asks for.
typedef struct {
    real_t t_s;                                                      ///< [s] start, since plan start
    real_t duration_s;                                               ///< [s] > 0
    real_t u_start_N[SSV_NUM_THRUSTERS], u_end_N[SSV_NUM_THRUSTERS]; ///< [N] |u| <= force_max_N
    int leg;                                                         ///< index into plan.leg
} ssv_segment_t;

typedef struct {
    real_t t_s; ///< [s] since plan start
    ssv_event_kind_t kind;
} ssv_event_t;

/// One (contact, height) at its best ring angle.
typedef struct {
    int contact;            ///< 1 or 2
    real_t attach_height_m; ///< [m]
    real_t ring_angle_rad;  ///< [rad]
    ssv_outcome_t outcome;  ///< the three prices are 0 unless SSV_FEASIBLE
    real_t time_s, impulse_Ns, cost;
    ssv_moving_t body;  ///< from SSV_NO_WAY on: what comes too near,
    int obstacle;       ///< to which obstacle of the scene, or SSV_OBSTACLE_BEAM, SSV_OBSTACLE_TANK;
    real_t clearance_m; ///< [m] how far they are apart where they are nearest, negative: how deep it is inside
} ssv_candidate_t;

/// How far a plan stays away from what stands there. A contact that is allowed does not count (DESIGN.md 13).
typedef struct {
    real_t certified_m, seen_m; ///< [m] the least distance is between these two, which are at most 5 mm apart;
                                ///< negative: inside
    int leg;                    ///< where seen_m was seen: on this leg,
    real_t s;                   ///< [m or rad] so far along it,
    ssv_moving_t body;          ///< between this body
    int obstacle;               ///< and this obstacle of the scene, SSV_OBSTACLE_BEAM or SSV_OBSTACLE_TANK; if it is
                                ///< SSV_OBSTACLE_NONE the rest is 0
} ssv_clearance_t;

/// What a task costs.
typedef struct {
    ssv_status_t status; ///< SSV_OK, SSV_INFEASIBLE or SSV_NUMERIC_OVERFLOW
    uint64_t scenario_hash;
    real_t cost;                   ///< [-] J = W1 time_s + W2 impulse_Ns
    real_t lower_bound;            ///< [-] no plan costs less; see ssv_lower_bound
    real_t time_s;                 ///< [s] start to docked
    real_t impulse_Ns;             ///< [N s]
    ssv_candidate_t choice;        ///< the candidate that costs least
    pose_t X_IS_final, X_IB_final; ///< vehicle and beam when docked: where the next task starts
    int num_priced;                ///< ways to fly that were priced: grasps, turning axes, travel attitudes
    int num_candidates;            ///< 0 unless asked for (scenario.want_candidates), or SSV_INFEASIBLE
    ssv_candidate_t candidate[SSV_MAX_CANDIDATES];
} ssv_quote_t;

/// How far from a goal.
typedef struct {
    real_t position_m, angle_rad;
} ssv_miss_t;

/// How far from its goals a timeline ends open loop, the farther of mate and dock: by what the scalar rounds, and by
/// what straight lines leave of the thrusts. Up to 1000 m and rad.
typedef struct {
    ssv_miss_t rounding, lines;
} ssv_arrival_t;

/// The answer. Unless the quote's status is SSV_OK only the quote is meaningful, the rest is zero.
typedef struct {
    ssv_quote_t quote;
    uint64_t plan_hash;
    int num_legs;
    ssv_leg_t leg[SSV_MAX_LEGS];
    int num_arcs;
    ssv_arc_t arc[SSV_MAX_ARCS];
    int num_segments;
    ssv_segment_t segment[SSV_MAX_SEGMENTS];
    int num_events;
    ssv_event_t event[SSV_MAX_EVENTS];
    pose_t X_SB;               ///< beam in the vehicle's frame, once mated
    ssv_clearance_t clearance; ///< of the scenario's scene
} ssv_plan_t;

/// What time and impulse can be traded for: no point is better than another in both. In order of growing time.
typedef struct {
    ssv_status_t status; ///< SSV_OK, SSV_INFEASIBLE or SSV_NUMERIC_OVERFLOW
    uint64_t scenario_hash;
    int num_points;                       ///< 0 unless SSV_OK
    ssv_candidate_t point[SSV_MAX_FRONT]; ///< cost is that with the scenario's weights
} ssv_front_t;

/// The plan at one instant.
typedef struct {
    real_t u_N[SSV_NUM_THRUSTERS];   ///< [N] thrusts of the timeline
    pose_t X_IS;                     ///< vehicle pose
    vec3_t v_IS_S_m_s, w_IS_S_rad_s; ///< velocity and rate of the vehicle, in axes of S
    int leg;                         ///< leg under way
    bool mated;                      ///< whether the vehicle holds the beam, which is then at X_IS X_SB
} ssv_sample_t;

#endif
