/// The thruster controller: flies the live timeline of the link tick by tick, turns newtons into efforts, and stops the
/// vehicle where the planner, the link or an operator demand it. It knows no planner, no clock, no heap and no
/// operating system: bytes, navigation and time are handed in, efforts and bytes are handed out. The same code runs on
/// the vehicle, on a bench and in the simulator.
///
/// How it is driven. Every SSV_VEHICLE_TICK_US call `ssv_vehicle_tick` with the time at which the tick is due, give its
/// efforts to the thrusters until the next one, and then try to mate or to dock if it says so. In between hand over
/// what arrives (`..._receive`, `..._navigate`, `..._supply`) and send what `..._poll` gives while the transport has
/// room. `now_us` never decreases and starts near 0 at boot. Frames as in ssv/scenario.h: I inertial, S vehicle.
///
/// Phases are those of the link (ssv_link_phase_t); firmware/vehicle/README.md has the table of commands.
#ifndef SSV_VEHICLE_H
#define SSV_VEHICLE_H

#include "ssv/link.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SSV_VEHICLE_TICK_US INT64_C(5000)
#define SSV_THRUST_MAX_POINTS 12

/// One direction of a thruster at the nominal supply: straight lines between the points. The first point is the edge of
/// the dead band: a smaller effort than its own gives nothing. Without points the force is thrust_max_N times the
/// effort.
typedef struct {
    int32_t num_points;                   ///< 0, or 2 to SSV_THRUST_MAX_POINTS
    float effort[SSV_THRUST_MAX_POINTS];  ///< [-] in (0, 1], rising
    float force_N[SSV_THRUST_MAX_POINTS]; ///< [N] size of the force, 0 or more, rising
} ssv_thrust_branch_t;

typedef struct {
    ssv_thrust_branch_t forward, reverse;
} ssv_thrust_curve_t;

/// Constant, and outlives the vehicle: it may stand in flash.
typedef struct {
    ssv_link_vehicle_config_t link;
    float thrust_max_N; ///< [N] the most that any thruster is asked for; a quarter above link.force_max_N, the most
                        ///< that a timeline may have, there is room for all that a tick has to correct
    ssv_thrust_curve_t curve[SSV_NUM_THRUSTERS];

    int64_t beat_warn_us, beat_stop_us; ///< [us] without progress of the planner until it warns, until it stops
    int64_t trim_hold_us, trim_ramp_us; ///< [us] how long a trim counts in full, and then takes to fade
    int64_t trim_stop_us;               ///< [us] without a trim, once there was one, until it stops
    float trim_max_N;                   ///< [N] larger ones are cut

    /// The brake is the wrench [-v; -w] times these gains, as much of it as the thrusters have, until the vehicle is as
    /// slow as this or the time is over. Gains must be below mass over the delay of the navigation.
    float brake_kg_s, brake_Nm_s;             ///< [N/(m/s)], [N m/(rad/s)]
    float u_per_wrench[SSV_NUM_THRUSTERS][6]; ///< thrusts per [force [N]; moment [N m]] in axes of S
    float brake_speed_m_s, brake_rate_rad_s;  ///< [m/s], [rad/s]
    int64_t brake_max_us;                     ///< [us]
    int64_t navigation_stale_us;              ///< [us] after which the vehicle does not know how it moves
} ssv_vehicle_config_t;

/// What a tick does.
typedef struct {
    bool is_armed;                   ///< if not, the thrusters are without power and the efforts are no numbers
    float effort[SSV_NUM_THRUSTERS]; ///< [-] in [-1, 1], from this tick to the next
    float u_N[SSV_NUM_THRUSTERS];    ///< [N] what they should give
    bool attempts;                   ///< whether the gripper is to try this once the tick is over; then the answer is
                                     ///< due by ssv_vehicle_attempted, and the timeline waits for it
    ssv_timeline_event_t event;
} ssv_vehicle_output_t;

/// Where the timeline is. Private to the vehicle.
typedef struct {
    const uint8_t* file; ///< of the link's live timeline; null for none
    int32_t num_segments, segment;
    int32_t num_events, next_event;
    ssv_timeline_event_t event[SSV_MAX_EVENTS];
    int64_t in_segment_ns, plan_time_ns; ///< [ns] since the start of the segment, of the timeline
    float put_off_N[SSV_NUM_THRUSTERS];  ///< [N] what the next tick gives for the last one
    float moment_N[SSV_NUM_THRUSTERS];   ///< [N] over a tick squared: how late the thrusts so far should have acted
} ssv_execution_t;

/// Whose beats count, and when they last did. Private to the vehicle.
typedef struct {
    bool is_known, is_bound, has_warned;
    uint8_t sysid, compid;
    ssv_link_beat_t beat;
    int64_t grew_us;
    uint32_t flown_boot_id, flown_session; ///< of the execution that was last; its beats are old
} ssv_deadman_t;

/// Some 18 kB, most of it the link's two timelines. Private to the vehicle but for `link.wire.statistics` and `state`.
typedef struct {
    const ssv_vehicle_config_t* config;
    ssv_link_vehicle_t link;
    ssv_link_vehicle_state_t state;
    ssv_execution_t execution;
    bool has_started;      ///< whether the live timeline was started, which happens once
    bool attempts, awaits; ///< whether the next tick attempts the event; whether the answer is due
    ssv_deadman_t deadman;
    bool has_trim;
    uint32_t trim_sequence;
    int64_t trim_us;
    float clock_rate;       ///< [-] of the timeline's clock, that of the newest trim
    int64_t clock_ahead_ns; ///< [ns] how far the planner's clock of the timeline is ahead of the vehicle's own
    float trim_N[SSV_NUM_THRUSTERS];
    bool is_slowing; ///< whether it brakes
    int64_t slowing_us;
    float force_scale;
    float carried_N[SSV_NUM_THRUSTERS]; ///< [N] for one tick: what the dead bands have kept back so far
} ssv_controller_t;

/// Starts disarmed, without timeline, at the nominal supply. False, and the vehicle is unusable, when a curve breaks a
/// rule above or a limit is not positive.
bool ssv_vehicle_init(ssv_controller_t* vehicle, const ssv_vehicle_config_t* config);

/// Takes what arrived on the link, all of it.
void ssv_vehicle_receive(ssv_controller_t* vehicle, int64_t now_us, const uint8_t* bytes, size_t num_bytes);

/// The next frame to send, as ssv_link_vehicle_poll.
size_t ssv_vehicle_poll(ssv_controller_t* vehicle, int64_t now_us, uint8_t* frame);

/// Tells where the vehicle was at `held_us`, [0, now], and how it moved; `pose->known` is taken as true. Numbers that
/// no vehicle can have, an attitude that is not of unit length among them, are passed over.
void ssv_vehicle_navigate(ssv_controller_t* vehicle, int64_t held_us, const ssv_link_pose_t* pose);

/// Tells the force that the supply gives over the force of the curves, such as its voltage over the nominal one to the
/// power of 1.5; kept within 1/4 and 4.
void ssv_vehicle_supply(ssv_controller_t* vehicle, float force_scale);

/// One tick. Every field of `output` is written.
void ssv_vehicle_tick(ssv_controller_t* vehicle, int64_t now_us, ssv_vehicle_output_t* output);

/// Tells how an attempt ended. After a miss the vehicle holds, and SSV_LINK_PAUSE_CONTINUE 1 is another attempt. Passed
/// over when no answer is due.
void ssv_vehicle_attempted(ssv_controller_t* vehicle, int64_t now_us, bool hit);

/// A configuration for the SSV of the paper: three pairs of thrusters on the hull, 6 N each, no dead band.
void ssv_vehicle_config_default(ssv_vehicle_config_t* config, uint32_t boot_id);

#ifdef __cplusplus
}
#endif

#endif
