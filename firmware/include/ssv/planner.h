/// The onboard trajectory planner: what does it cost to fly to a beam and carry it to a hub port, and which thrusts do
/// it?
///
/// `ssv_problem_init` checks a scenario and caches what follows from it, `ssv_plan` searches and prices the candidates
/// and writes the plan, `ssv_plan_sample` reads the plan at a time. Where the price will do, there are `ssv_quote`,
/// `ssv_front` and `ssv_lower_bound`. The planner is a function of its input: no clock, no randomness, no heap, no
/// globals, no I/O; the same scenario gives the same plan, bit for bit. All memory is the caller's and every loop is
/// bounded by a constant of this header or of the sources. Two planners may run side by side.
///
///     ssv_scenario_t scenario = ssv_scenario_default();   // then fill in bodies, poses and port
///     ssv_problem_t problem;
///     ssv_fault_t fault;
///     if (ssv_problem_init(&problem, &scenario, &fault) != SSV_OK) { ... fault.field names what is wrong ... }
///     if (ssv_plan(&problem, &plan) == SSV_OK) { ... plan.quote.cost, plan.segment[0..plan.num_segments) ... }
///
/// Frames (right-handed, SI units, names end in their unit): I inertial; S vehicle, origin at its centre of mass,
/// contact point on +x; B beam, origin at its centre of mass, z along the tube, contact 1 at z = -length/2, contact 2
/// at z = +length/2; C the centre of mass of vehicle and beam, axes of S. A 6-vector wrench is [force; moment] in axes
/// of S, the moment about S. "paper" is C. L. R. McGhan, "A Trajectory Planner for Autonomous Structural Assembly".
#ifndef SSV_PLANNER_H
#define SSV_PLANNER_H

#include "ssv/real.h"
#include "ssv/vec3.h"

#define SSV_VERSION "0.1.0"

#define SSV_NUM_THRUSTERS 6
#define SSV_NUM_CONTACTS 2
#define SSV_MAX_ATTACH_HEIGHTS 8
#define SSV_MAX_CANDIDATES (SSV_NUM_CONTACTS * SSV_MAX_ATTACH_HEIGHTS)
#define SSV_MAX_LEGS 8
#define SSV_MAX_SEGMENTS 128
#define SSV_MAX_EVENTS 2
/// Pieces of all legs together; one piece is one law dv/dt = a0 + a1 v + a2 v^2 of the speed along a leg.
#define SSV_MAX_PIECES 64

/// How far from unit length a quaternion or direction may be; closer is normalised, farther is refused.
#define SSV_UNIT_TOLERANCE REAL(1e-3)
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
    SSV_E_WEIGHTS = -5     ///< both weights zero: every plan would cost nothing
} ssv_status_t;

/// A sentence for any status, e.g. "outside its range"; never NULL.
const char* ssv_status_str(ssv_status_t status);

/// Why a candidate is not feasible.
typedef enum {
    SSV_FEASIBLE = 0,
    SSV_TOO_LONG,         ///< would take longer than SSV_DURATION_MAX_S
    SSV_NO_AUTHORITY,     ///< the thrusters cannot move the body along a leg
    SSV_TOO_MANY_PIECES,  ///< the motion has more pieces than SSV_MAX_PIECES
    SSV_TOO_MANY_SEGMENTS ///< the timeline has more segments than SSV_MAX_SEGMENTS
} ssv_outcome_t;

/// A sentence for any outcome; never NULL.
const char* ssv_outcome_str(ssv_outcome_t outcome);

/// One rigid body, neutrally buoyant. Drag on it is -(drag_lin + drag_quad |v|) v at its centre of mass and
/// -(drag_lin_ang + drag_quad_ang |w|) w; zero is a valid value. Added mass adds to mass_kg for motion along each body
/// axis.
typedef struct {
    real_t mass_kg;             ///< [kg] [0.01, 10000]
    vec3_t inertia_kg_m2;       ///< [kg m2] principal, about the body's x, y, z, each [1e-4, 100000]
    vec3_t added_mass_kg;       ///< [kg] along x, y, z, each [0, 10000]
    real_t drag_lin_kg_s;       ///< [N/(m/s)] [0, 100000]
    real_t drag_quad_kg_m;      ///< [N/(m/s)2] [0, 100000]
    real_t drag_lin_ang_Nm_s;   ///< [N m/(rad/s)] [0, 100000]
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

/// One question, unchecked: any value may stand here. Nothing is looked up elsewhere.
typedef struct {
    ssv_vehicle_t vehicle;
    ssv_beam_t beam;
    pose_t X_IS;              ///< vehicle at the start, at rest; each |p| <= 1000 m, q unit
    pose_t X_IB;              ///< beam at the start, at rest; likewise
    vec3_t p_IP_m;            ///< [m] hub port, where the beam's contact point must end, each |x| <= 1000
    vec3_t axis_I;            ///< [-] unit, out of the hub; the docked beam's outward axis points against it
    int contact;              ///< beam contact that docks: 1, 2, or 0 for either
    real_t standoff_m;        ///< [m] [0.001, 20] vehicle centre to beam axis when mated (paper Eq. 4: R_S + R_B)
    real_t weight_time_per_s; ///< [1/s] [0, 1000] W1 of J = W1 T + W2 F (paper Eq. 16); legs are shaped as if >= 0.01 N
                              ///< x W2
    real_t weight_impulse_per_Ns; ///< [1/(N s)] [0, 1000] W2; not both zero
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
} ssv_scenario_t;

/// A scenario with identity poses, unit weights, every choice left to the method, and all physical numbers zero: those
/// must be filled in before `ssv_problem_init` accepts it.
ssv_scenario_t ssv_scenario_default(void);

/// What is wrong with a scenario, where.
typedef struct {
    ssv_status_t status;
    const char* field; ///< path of the field, e.g. "vehicle.thrusters[].n_T"; static storage
    int index;         ///< which element where the path has [], else -1
    real_t value;      ///< the offending number (for SSV_E_NOT_UNIT the length)
    real_t min, max;   ///< what would be accepted (SSV_E_RANGE, SSV_E_NOT_UNIT)
} ssv_fault_t;

/// Thrusts per wrench on S: row i gives thruster i [N] from [force [N]; moment about S [N m]] (paper Eqs. 12-14, in
/// full).
typedef struct {
    real_t u_per_wrench[SSV_NUM_THRUSTERS][6];
} ssv_allocation_t;

/// Memory that planning works in, in numbers.
#define SSV_WORK_REALS 850

/// A checked scenario with what the search needs from it, and the memory that it works in: one question at a time for
/// each. Made by `ssv_problem_init` only; its fields are not API.
typedef struct {
    ssv_scenario_t scenario; ///< as given, with quaternions and directions normalised and the heights filled in
    uint64_t scenario_hash;
    ssv_allocation_t allocation;
    real_t work[SSV_WORK_REALS]; ///< of a question while it is answered; means nothing afterwards
} ssv_problem_t;

/// Checks every field of the scenario against its range and caches the inverse of the thruster matrix.
/// @return SSV_OK, or a negative status; then *problem is untouched and *fault says which field. Costs about a
/// microsecond.
ssv_status_t ssv_problem_init(ssv_problem_t* problem, const ssv_scenario_t* scenario, ssv_fault_t* fault);

/// 64-bit hash (FNV-1a over the fields in the order declared) of a scenario, as given.
uint64_t ssv_scenario_hash(const ssv_scenario_t* scenario);

/// A price that no plan for this problem can undercut, whatever the method, from the balance of momentum (DESIGN.md
/// 11). Costs less than a microsecond. Where a number does not fit the scalar it is 0, which no plan undercuts either.
real_t ssv_lower_bound(const ssv_problem_t* problem);

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
typedef enum { SSV_MATE = 0, SSV_DOCK = 1 } ssv_event_kind_t;

/// A stretch of a leg in which the speed v along it follows dv/dt = law[0] + law[1] v + law[2] v^2.
typedef struct {
    real_t t_s;            ///< [s] start, since the leg's start
    real_t duration_s;     ///< [s] > 0
    real_t s;              ///< [m or rad] distance along the leg at the start
    real_t v_start, v_end; ///< [m/s or rad/s]
    real_t law[3];
} ssv_piece_t;

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
    int first_piece, num_pieces; ///< into plan.piece
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
} ssv_candidate_t;

/// What a task costs.
typedef struct {
    ssv_status_t status; ///< SSV_OK, SSV_INFEASIBLE or SSV_NUMERIC_OVERFLOW
    uint64_t scenario_hash;
    real_t cost;            ///< [-] J = W1 time_s + W2 impulse_Ns
    real_t lower_bound;     ///< [-] no plan costs less; see ssv_lower_bound
    real_t time_s;          ///< [s] start to docked
    real_t impulse_Ns;      ///< [N s]
    ssv_candidate_t choice; ///< the candidate that costs least
    int num_priced;         ///< ways to fly that were priced: grasps, turning axes, travel attitudes
    int num_candidates;     ///< 0 unless asked for (scenario.want_candidates), or SSV_INFEASIBLE
    ssv_candidate_t candidate[SSV_MAX_CANDIDATES];
} ssv_quote_t;

/// The price without the plan: that of `ssv_plan`, to the last bit, unless that plan turns out not to fit its memory
/// (see SSV_TOO_MANY_SEGMENTS). @return quote->status. Every field of *quote is written; with SSV_INFEASIBLE only
/// status, scenario_hash and the candidates are meaningful, with SSV_NUMERIC_OVERFLOW the first two, the rest is zero.
ssv_status_t ssv_quote(ssv_problem_t* problem, ssv_quote_t* quote);

/// The answer. Unless the quote's status is SSV_OK only the quote is meaningful, the rest is zero.
typedef struct {
    ssv_quote_t quote;
    uint64_t plan_hash;
    int num_legs;
    ssv_leg_t leg[SSV_MAX_LEGS];
    int num_pieces;
    ssv_piece_t piece[SSV_MAX_PIECES];
    int num_segments;
    ssv_segment_t segment[SSV_MAX_SEGMENTS];
    int num_events;
    ssv_event_t event[SSV_MAX_EVENTS];
    pose_t X_SB; ///< beam in the vehicle's frame, once mated
    pose_t X_IS_final, X_IB_final;
} ssv_plan_t;

/// Most points of a front.
#define SSV_MAX_FRONT 24

/// What time and impulse can be traded for: no point is better than another in both. In order of growing time.
typedef struct {
    ssv_status_t status; ///< SSV_OK, SSV_INFEASIBLE or SSV_NUMERIC_OVERFLOW
    uint64_t scenario_hash;
    int num_points;                       ///< 0 unless SSV_OK
    ssv_candidate_t point[SSV_MAX_FRONT]; ///< cost is that with the scenario's weights
} ssv_front_t;

/// The front over the scenario's candidates and over a ladder of weights from time alone to impulse alone, each rung
/// planned with the scenario's method and effort. A scheduler that changes its weights takes the point that costs least
/// with them. A point is what `ssv_quote` finds for that rung when it lists all candidates. Costs nine such quotes.
/// @return front->status; every field of *front is written.
ssv_status_t ssv_front(ssv_problem_t* problem, ssv_front_t* front);

/// Plans. @return plan->quote.status. Every field of *plan is written.
ssv_status_t ssv_plan(ssv_problem_t* problem, ssv_plan_t* plan);

/// 64-bit hash (FNV-1a over the fields in the order declared, plan_hash left out, arrays up to their counts) of a plan.
uint64_t ssv_plan_hash(const ssv_plan_t* plan);

/// The plan at one instant.
typedef struct {
    real_t u_N[SSV_NUM_THRUSTERS];   ///< [N] thrusts of the timeline
    pose_t X_IS;                     ///< vehicle pose
    vec3_t v_IS_S_m_s, w_IS_S_rad_s; ///< velocity and rate of the vehicle, in axes of S
    int leg;                         ///< leg under way
    bool mated;                      ///< whether the vehicle holds the beam, which is then at X_IS X_SB
} ssv_sample_t;

/// The plan at time t_s; before the start and after the end the vehicle rests there with zero thrust. The plan must be
/// SSV_OK. At a joint the later leg counts. Pure; cost grows with the number of legs and segments.
void ssv_plan_sample(const ssv_plan_t* plan, real_t t_s, ssv_sample_t* sample);

#endif
