/// The executive: has the vehicle at the other end of the link fly a plan. It uploads, commits, arms and starts the
/// timeline, gives beats while it gets on, keeps the vehicle on the plan by guidance, lets it mate and dock when
/// guidance says so, and tells how it ended. Where something is wrong the vehicle is stopped.
///
/// Like the link and guidance it does no input or output and knows no clock and no heap: bytes and time are handed in,
/// frames are handed out. One struct of the caller's holds all.
///
///     ssv_executive_begin(&executive, now_us, &problem, &plan, &order);
///     while (executive.outcome == SSV_EXECUTIVE_UNDER_WAY) {
///         ssv_executive_receive(&executive, now_us, bytes, num_bytes);       whenever bytes come
///         ssv_executive_step(&executive, now_us);                            when executive.due_us has come
///         while ((length = ssv_executive_poll(&executive, now_us, frame))) send(frame, length);
///     }
///
/// `now_us` never decreases and starts near 0. Frames and units as in ssv/scenario.h.
#ifndef SSV_EXECUTIVE_H
#define SSV_EXECUTIVE_H

#include "ssv/guidance.h"
#include "ssv/link.h"

#define ssv_executive_init SSV_NAME(ssv_executive_init)
#define ssv_executive_begin SSV_NAME(ssv_executive_begin)
#define ssv_executive_stop SSV_NAME(ssv_executive_stop)
#define ssv_executive_give_up SSV_NAME(ssv_executive_give_up)
#define ssv_executive_pause SSV_NAME(ssv_executive_pause)
#define ssv_executive_receive SSV_NAME(ssv_executive_receive)
#define ssv_executive_measured SSV_NAME(ssv_executive_measured)
#define ssv_executive_step SSV_NAME(ssv_executive_step)
#define ssv_executive_poll SSV_NAME(ssv_executive_poll)

#ifdef __cplusplus
extern "C" {
#endif

/// [us] From one turn of the control loop to the next.
#define SSV_EXECUTIVE_STEP_US INT64_C(50000)

/// What is done now. In the order in which they follow each other, but for stopping, which may come after each.
typedef enum {
    SSV_EXECUTIVE_IDLE = 0,
    SSV_EXECUTIVE_SEEKING, ///< waits for the vehicle to be heard
    SSV_EXECUTIVE_UPLOADING,
    SSV_EXECUTIVE_COMMITTING,
    SSV_EXECUTIVE_ARMING, ///< disarms first where the vehicle has stopped
    SSV_EXECUTIVE_STARTING,
    SSV_EXECUTIVE_TRACKING,
    SSV_EXECUTIVE_STOPPING ///< the vehicle brakes
} ssv_executive_state_t;

typedef enum {
    SSV_EXECUTIVE_UNDER_WAY = 0,
    SSV_EXECUTIVE_DOCKED,
    SSV_EXECUTIVE_MISSED,  ///< mate or dock did not succeed in as many attempts as guidance makes
    SSV_EXECUTIVE_STRAYED, ///< lost the plan; before the mate a new one from where it is may help
    SSV_EXECUTIVE_STOPPED, ///< by ssv_executive_stop
    SSV_EXECUTIVE_HALTED,  ///< the vehicle stopped by itself or by another's command: `reason`
    SSV_EXECUTIVE_REFUSED, ///< the vehicle does not take the timeline or a command: `reason`
    SSV_EXECUTIVE_SILENT   ///< the vehicle was not heard, or is another one since it booted anew
} ssv_executive_outcome_t;

typedef struct {
    ssv_link_planner_config_t link;
    real_t thruster_lag_s; ///< [s] [0, 10] time constant of the thrusters, as well as it is known
} ssv_executive_config_t;

/// What goes with a plan that is to be flown.
typedef struct {
    int64_t epoch_us;            ///< [us] > 0, larger than that of the plan flown last
    uint32_t valid_for_ms;       ///< [ms] > 0; from the upload to the latest start
    uint32_t mass_configuration; ///< as ssv/timeline.h
    real_t force_max_N; ///< [N] what each thruster really gives: the plan's limit, and the reserve that it left
} ssv_executive_order_t;

/// How guidance's step went last.
typedef struct {
    ssv_guidance_command_t command;
    int64_t at_us; ///< [us] 0 before the first
} ssv_executive_turn_t;

/// Some 20 kB. Not API, but for reading what has a comment.
typedef struct {
    ssv_executive_config_t config;
    ssv_link_planner_t link; ///< its statistics
    ssv_executive_state_t state;
    ssv_executive_outcome_t outcome;
    ssv_link_reason_t reason; ///< of the outcome, or SSV_LINK_NO_REASON
    int64_t due_us;           ///< [us] when the next step is due
    uint64_t plan_hash;       ///< of the plan flown
    const ssv_problem_t* problem;
    const ssv_plan_t* plan;
    ssv_guidance_t guidance; ///< meaningful from SSV_EXECUTIVE_TRACKING on, as is `turn`
    ssv_executive_turn_t turn;
    real_t impulse_Ns;            ///< [N s] of the thrusts commanded so far
    int64_t begun_us, started_us; ///< [us] when it began, when the timeline started; 0 before
    ssv_link_execution_t vehicle; ///< what the vehicle told last
    ssv_link_pose_t pose;         ///< what it measured last
    float u_N[SSV_NUM_THRUSTERS]; ///< [N] what it gave last
    struct {
        uint16_t lost, bad_crc, bad_signature;
    } health;           ///< frames that the vehicle missed
    uint32_t num_texts; ///< of the vehicle so far; the newest in `text`
    uint8_t severity;
    char text[SSV_LINK_TEXT_MAX + 1];
    bool heard;       ///< whether the vehicle was, in this execution or an earlier one
    int64_t heard_us; ///< [us] when it told of itself last
    bool commanded;   ///< whether a command of this state is under way
    uint32_t session, progress, sequence;
    uint8_t attempts; ///< of the vehicle's, those that guidance knows of
    bool asked_attempt, wants_pause, has_paused;
    int32_t num_strays, num_starts;
    bool has_clock;
    int64_t clock_offset_us; ///< [us] ours less the vehicle's
    bool has_attitude;
    uint32_t attitude_ms;
    ssv_executive_outcome_t outcome_to_be; ///< once it has stopped
    int64_t stopping_us;
    int64_t event_ns[SSV_MAX_EVENTS]; ///< [ns] of the timeline
    ssv_timeline_t timeline;
    uint8_t file[SSV_TIMELINE_FILE_BYTES_MAX];
    size_t length, uploaded;
    int64_t uploaded_us;
} ssv_executive_t;

/// Knows no vehicle and no plan yet.
void ssv_executive_init(ssv_executive_t* executive, const ssv_executive_config_t* config);

/// Begins to fly a plan, SSV_OK and of this problem; both outlive the execution. False, and nothing begins, while
/// another one is under way or when the plan makes no timeline that a vehicle takes.
bool ssv_executive_begin(ssv_executive_t* executive, int64_t now_us, const ssv_problem_t* problem,
                         const ssv_plan_t* plan, const ssv_executive_order_t* order);

/// Stops the vehicle. The outcome follows when it has stopped, or does not answer.
void ssv_executive_stop(ssv_executive_t* executive, int64_t now_us);

/// Ends what is under way without another word to the vehicle, whose dead-man stops it: it is known to be gone.
void ssv_executive_give_up(ssv_executive_t* executive);

/// Has the vehicle wait where it is, or go on. Nothing happens when it does not fly.
void ssv_executive_pause(ssv_executive_t* executive, bool paused);

/// Takes bytes that came from the vehicle, all of them. Also while nothing is under way.
void ssv_executive_receive(ssv_executive_t* executive, int64_t now_us, const uint8_t* bytes, size_t num_bytes);

/// Where the vehicle measured itself to be last. False, and *X_IS untouched, where it has not told.
bool ssv_executive_measured(const ssv_executive_t* executive, pose_t* X_IS);

/// One turn of the control loop: call it when due_us has come, and no later than the vehicle's dead-man allows.
void ssv_executive_step(ssv_executive_t* executive, int64_t now_us);

/// The next frame to send, as ssv_link_planner_poll.
size_t ssv_executive_poll(ssv_executive_t* executive, int64_t now_us, uint8_t* frame);

#ifdef __cplusplus
}
#endif

#endif
