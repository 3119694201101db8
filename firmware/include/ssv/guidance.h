/// Guidance: what keeps a vehicle on its plan in water that pushes back. It estimates pose, twist and disturbance from
/// pose measurements, trims the thrusts of the plan's timeline, slows the plan's clock where the vehicle cannot follow,
/// and says when to mate, to dock, to plan anew or to give up.
///
/// It is a function of what it is told: no clock, no randomness, no heap, no globals, no I/O, every loop bounded. One
/// struct of the caller's holds all; problem and plan are read on every step and must outlive it.
///
///     static ssv_guidance_t guidance;
///     ssv_guidance_init(&guidance, &problem, &plan, &config);
///     every 1/20 to 1/10 s, for the interval that begins now:
///         for each measurement that has come: ssv_guidance_measure(&guidance, age_s, X_IS);
///         ssv_guidance_step(&guidance, dt_s, &command);
///         apply command.u_N until the next step, or command.trim_N on top of the timeline
///         if (command.attempt != SSV_ATTEMPT_NONE) { try it; ssv_guidance_attempted(&guidance, hit); }
///
/// Frames and units as in ssv/scenario.h. A wrench is in axes of S, its moment about S.
#ifndef SSV_GUIDANCE_H
#define SSV_GUIDANCE_H

#include "ssv/plan.h"
#include "ssv/planner.h"

#define ssv_guidance_init SSV_NAME(ssv_guidance_init)
#define ssv_guidance_measure SSV_NAME(ssv_guidance_measure)
#define ssv_guidance_step SSV_NAME(ssv_guidance_step)
#define ssv_guidance_pause SSV_NAME(ssv_guidance_pause)
#define ssv_guidance_attempted SSV_NAME(ssv_guidance_attempted)

#ifdef __cplusplus
extern "C" {
#endif

/// Poses that are remembered for measurements that come late: at 20 steps a second those of the last 1.6 s.
#define SSV_GUIDANCE_HISTORY 32

typedef struct {
    real_t force_max_N;    ///< [N] what each thruster really gives, at least what the plan was made with
    real_t thruster_lag_s; ///< [s] [0, 10] time constant of the thrusters, as well as it is known
} ssv_guidance_config_t;

typedef enum {
    SSV_GUIDANCE_FLYING = 0, ///< along the plan
    SSV_GUIDANCE_DWELLING,   ///< at the place to mate or dock, until the estimate stays inside the tolerance
    SSV_GUIDANCE_BACKING_OFF,
    SSV_GUIDANCE_RETURNING, ///< from where it backed off to
    SSV_GUIDANCE_DONE,      ///< docked: thrust is zero
    SSV_GUIDANCE_ABORTED    ///< gave up: holds where it backed off to
} ssv_guidance_state_t;

typedef enum { SSV_ATTEMPT_NONE = 0, SSV_ATTEMPT_MATE, SSV_ATTEMPT_DOCK } ssv_attempt_t;

/// What moves: state and disturbance, as estimated.
typedef struct {
    pose_t X_IS;
    vec3_t v_S_m_s, w_S_rad_s; ///< velocity of S over ground and rate, in axes of S
    vec3_t force_I_N;          ///< [N] disturbance at S, in axes of I
    vec3_t moment_S_Nm;        ///< [N m] and its moment about S, in axes of S
} ssv_estimate_t;

/// How far from the plan, by the estimate. At the end of a phase of what counts there: vehicle or tip of the beam.
typedef struct {
    real_t along_m, across_m; ///< behind the reference along its path, and beside it
    real_t angle_rad;
    real_t tip_m, tip_angle_rad, tip_speed_m_s; ///< meaningful where it dwells
} ssv_guidance_error_t;

typedef struct {
    ssv_guidance_state_t state;
    ssv_attempt_t attempt;            ///< to be tried now, and answered by ssv_guidance_attempted
    bool replan;                      ///< lost: a new plan from the estimate is needed. This one is followed meanwhile
    real_t plan_time_s;               ///< [s] on the plan's clock, at the start of the interval
    real_t clock_rate;                ///< [-] [0, 1] of the plan's clock over the interval; 0 gives the trims alone
    real_t u_N[SSV_NUM_THRUSTERS];    ///< [N] thrusts to give, |u| <= force_max_N
    real_t trim_N[SSV_NUM_THRUSTERS]; ///< [N] the same as a sum on top of clock_rate times the timeline's
    ssv_guidance_error_t error;
} ssv_guidance_command_t;

/// Mass and drag of what moves, as matrices about S.
typedef struct {
    real_t mass[6][6]; ///< wrench per acceleration of S's twist, added mass included
    real_t drag[6][6]; ///< wrench per twist, the linear part
    vec3_t p_SC_m;
    real_t mass_kg, drag_kg_s; ///< for translation alone, mean over the axes
    real_t inertia_kg_m2, drag_Nm_s;
} ssv_guidance_body_t;

/// All that guidance keeps. The fields are not API, but for reading `estimate`, `X_SB` and `body`.
typedef struct {
    const ssv_problem_t* problem;
    const ssv_plan_t* plan;
    ssv_guidance_config_t config;
    ssv_guidance_body_t body;
    ssv_estimate_t estimate;
    pose_t X_SB; ///< beam in the vehicle's frame, as taken hold of, once mated
    bool mated;
    real_t thrust_N[SSV_NUM_THRUSTERS]; ///< that the observer takes the thrusters to give now
    real_t command_N[SSV_NUM_THRUSTERS];
    pose_t history[SSV_GUIDANCE_HISTORY]; ///< estimates at the ends of the last steps, as a ring
    real_t history_age_s[SSV_GUIDANCE_HISTORY];
    int newest;
    real_t measured_age_s; ///< of the moment that the last measurement was of
    ssv_guidance_state_t state;
    ssv_attempt_t attempt;
    real_t plan_time_s, in_state_s, inside_s, held_s;
    bool paused;       ///< whether the plan's clock stands by order, see ssv_guidance_pause
    real_t back_off_m; ///< how far the reference has backed off
    int tries;
} ssv_guidance_t;

/// Starts at the plan's start pose, at rest. The plan must be SSV_OK and of this problem.
void ssv_guidance_init(ssv_guidance_t* guidance, const ssv_problem_t* problem, const ssv_plan_t* plan,
                       const ssv_guidance_config_t* config);

/// Takes a measured pose of the vehicle that holds for the moment age_s before now. Older than the history: passed
/// over.
void ssv_guidance_measure(ssv_guidance_t* guidance, real_t age_s, pose_t X_IS);

/// What to do over the next dt_s, (0, 0.2]. Goes on to the interval's end: the next measurement's age counts from
/// there. Every field of *command is written. Costs some 60 square roots with a beam.
void ssv_guidance_step(ssv_guidance_t* guidance, real_t dt_s, ssv_guidance_command_t* command);

/// Has the plan's clock stand, or go on: while it stands, the vehicle is held where the plan has it then.
void ssv_guidance_pause(ssv_guidance_t* guidance, bool paused);

/// The outcome of an attempt, which was asked for or made by somebody else while it dwells. A hit goes on; a miss backs
/// off and comes again, SSV_GUIDANCE_TRIES (guidance/limits.h) times in all.
void ssv_guidance_attempted(ssv_guidance_t* guidance, bool hit);

#ifdef __cplusplus
}
#endif

#endif
