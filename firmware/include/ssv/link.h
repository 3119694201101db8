/// The MAVLink 2 link between the planner's computer and the vehicle's controller: both ends, and the file that a
/// timeline travels in. Bytes in, bytes out, time passed in: no input or output, no clock, no heap, no globals.
///
/// How an end is driven. Feed what arrives to `..._receive`, which stops after each event: call it again with the rest
/// until all is consumed. Ask `..._poll` for the next frame whenever the transport has room for one, and at least every
/// 10 ms; it gives nothing when nothing is due. A frame is numbered and signed when polled, so a frame that is polled
/// must be sent. `now_us` never decreases and starts near 0 at boot. All structs are the caller's and may be moved.
///
/// Frames, as in ssv/scenario.h: I inertial, S vehicle. Those of MAVLink, NED and FRD, appear on the wire alone: both
/// are half a turn about x from ours (link/ssv.xml).
///
/// Losses are counted (ssv_link_statistics_t) and repaired where it matters: commands and files are asked for again
/// until answered, and every request may arrive any number of times. Nothing that arrives is trusted: counts, lengths,
/// offsets and numbers are checked before use, and frames for other systems are passed over.
#ifndef SSV_LINK_H
#define SSV_LINK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ssv/timeline.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Longest frame [bytes]: header, 255 bytes of payload, checksum, signature.
#define SSV_LINK_FRAME_BYTES_MAX 280
/// Peers that are told apart in the statistics; later ones are counted in none.
#define SSV_LINK_MAX_PEERS 4
/// Longest text [bytes] of a status text, without the zero at its end.
#define SSV_LINK_TEXT_MAX 50
/// Longest name [bytes] of a parameter.
#define SSV_LINK_PARAMETER_NAME_MAX 16

/// Layout of a timeline file (link/timeline_file.c): a header, then one record per segment.
#define SSV_TIMELINE_HEADER_BYTES 96
#define SSV_TIMELINE_SEGMENT_BYTES 56
#define SSV_TIMELINE_FILE_BYTES_MAX (SSV_TIMELINE_HEADER_BYTES + SSV_TIMELINE_SEGMENT_BYTES * SSV_MAX_SEGMENTS)
/// Longest timeline and longest segment [ns]: 20,000 s, the planner's own limit, and as much again.
#define SSV_TIMELINE_DURATION_MAX_NS INT64_C(40000000000000)

/// MAVLink numbers of these roles.
#define SSV_LINK_VEHICLE_SYSID 1
#define SSV_LINK_VEHICLE_COMPID 1
#define SSV_LINK_PLANNER_COMPID 195

/// What the vehicle does; numbers of SSV_PHASE in ssv.xml.
typedef enum {
    SSV_LINK_DISARMED = 0,
    SSV_LINK_READY = 1,
    SSV_LINK_EXECUTING = 2,
    SSV_LINK_HOLDING = 3,
    SSV_LINK_BRAKING = 4,
    SSV_LINK_STOPPED = 5,
    SSV_LINK_DONE = 6
} ssv_link_phase_t;

/// Why a command or a timeline is refused, or why the vehicle is in its phase; numbers of SSV_REASON in ssv.xml.
typedef enum {
    SSV_LINK_NO_REASON = 0,
    SSV_LINK_LENGTH = 1,
    SSV_LINK_FORMAT = 2,
    SSV_LINK_CRC = 3,
    SSV_LINK_PLAN_HASH = 4,
    SSV_LINK_EPOCH = 5,
    SSV_LINK_EXPIRY = 6,
    SSV_LINK_MASS_CONFIGURATION = 7,
    SSV_LINK_FORCE = 8,
    SSV_LINK_START_POSE = 9,
    SSV_LINK_SEGMENTS = 10,
    SSV_LINK_DURATION = 11,
    SSV_LINK_THRUST = 12,
    SSV_LINK_EVENT = 13,
    SSV_LINK_NOTHING = 14,
    SSV_LINK_BUSY = 15,
    SSV_LINK_NOT_ARMED = 16,
    SSV_LINK_BEAT_LOST = 17,
    SSV_LINK_COMMANDED = 18,
    SSV_LINK_TRACKING = 19,
    SSV_LINK_INTERNAL = 20,
    SSV_LINK_NUM_REASONS
} ssv_link_reason_t;

/// Answers to a command; numbers of MAV_RESULT.
typedef enum {
    SSV_LINK_ACCEPTED = 0,
    SSV_LINK_TEMPORARILY_REJECTED = 1,
    SSV_LINK_DENIED = 2,
    SSV_LINK_UNSUPPORTED = 3,
    SSV_LINK_FAILED = 4,
    SSV_LINK_IN_PROGRESS = 5,
    SSV_LINK_COMMAND_INT_ONLY = 8,
    SSV_LINK_NO_ANSWER = 255 ///< not on the wire: the peer did not answer in time
} ssv_link_result_t;

/// Severity of a status text; numbers of MAV_SEVERITY.
typedef enum {
    SSV_LINK_CRITICAL = 2,
    SSV_LINK_ERROR = 3,
    SSV_LINK_WARNING = 4,
    SSV_LINK_NOTICE = 5,
    SSV_LINK_INFO = 6
} ssv_link_severity_t;

// ---- The timeline file ----------------------------------------------------------------------------------------------

/// What goes into the file beside the timeline.
typedef struct {
    int64_t epoch_us;      ///< [us] > 0; of two timelines the one with the larger epoch is newer
    uint32_t valid_for_ms; ///< [ms] > 0; from the upload's begin, by the vehicle's clock, to the latest start
} ssv_timeline_stamp_t;

/// Why a file is refused: the first thing that is wrong, in the order in which the file is read.
typedef struct {
    ssv_link_reason_t reason; ///< SSV_LINK_NO_REASON for a sound file
    int32_t index;            ///< of the segment or event that it is about; else 0
} ssv_timeline_fault_t;

/// A sentence's worth of English for a reason, e.g. "CRC-32 is not that of the content".
const char* ssv_link_reason_str(ssv_link_reason_t reason);

/// Writes the file of a timeline. Returns its length, or 0 when the timeline breaks a rule that the reader checks, or
/// `capacity` is too small; SSV_TIMELINE_FILE_BYTES_MAX always suffices. Cost: one pass, and one of the CRC.
size_t ssv_timeline_encode(const ssv_timeline_t* timeline, const ssv_timeline_stamp_t* stamp, uint8_t* file,
                           size_t capacity);

/// Checks everything about a file that can be checked without the vehicle: length, CRC-32, plan hash present, ranges,
/// contiguity, events. Cost: one pass, and one of the CRC.
ssv_timeline_fault_t ssv_timeline_check(const uint8_t* file, size_t length);

/// Reads the file into a timeline of the caller's. Both outputs stay untouched unless the answer is
/// SSV_LINK_NO_REASON. `stamp` may be null.
ssv_timeline_fault_t ssv_timeline_decode(const uint8_t* file, size_t length, ssv_timeline_t* timeline,
                                         ssv_timeline_stamp_t* stamp);

/// One segment of a file that ssv_timeline_check has found sound, 0 <= index < its num_segments: what a controller
/// reads that keeps the file and no second copy.
void ssv_timeline_read_segment(const uint8_t* file, int32_t index, ssv_timeline_segment_t* segment);

/// The events of such a file, in order, for a controller that has no room for a whole timeline. Returns how many.
int32_t ssv_timeline_read_events(const uint8_t* file, int32_t* num_segments,
                                 ssv_timeline_event_t event[SSV_MAX_EVENTS]);

/// All of such a file but its segments, which stay untouched. `stamp` may be null.
void ssv_timeline_read_header(const uint8_t* file, ssv_timeline_t* timeline, ssv_timeline_stamp_t* stamp);

// ---- What both ends have --------------------------------------------------------------------------------------------

/// Signs what is sent and accepts only what is signed with the same key.
typedef struct {
    uint8_t key[32];
    uint8_t link_id;      ///< number of this link among those of the system
    int64_t unix_zero_us; ///< [us] Unix time at now_us = 0; a clock that goes back makes peers refuse frames
} ssv_link_signing_t;

typedef struct {
    uint8_t sysid, compid;
    uint8_t next_sequence; ///< the sequence number that the next frame should have
    uint32_t received;     ///< good frames
    uint32_t lost;         ///< frames missing in the sequence numbers
} ssv_link_peer_t;

/// A frame with a bad checksum or signature cannot be attributed to a peer, so these are of the link.
typedef struct {
    uint32_t received;              ///< good frames
    uint32_t lost;                  ///< of all peers
    uint32_t bad_crc;               ///< checksum wrong
    uint32_t unknown;               ///< of messages that the dialect does not have
    uint32_t bad_signature;         ///< unsigned, or signature or time wrong
    uint32_t refused_streams;       ///< signed by more senders than the table holds
    uint32_t refused_signing_setup; ///< SETUP_SIGNING over the link, which is never obeyed
    uint32_t sent;
    int32_t num_peers;
    ssv_link_peer_t peer[SSV_LINK_MAX_PEERS];
} ssv_link_statistics_t;

/// Framing state; its content is the business of link/wire.c.
typedef struct {
    uint64_t memory[56];
    uint16_t held, parsed; ///< bytes of the frame under way, and those looked at
    uint8_t byte[SSV_LINK_FRAME_BYTES_MAX];
    uint8_t sysid, compid;
    ssv_link_statistics_t statistics;
} ssv_wire_t;

typedef struct {
    bool known;            ///< whether the rest is
    float p_IS_m[3];       ///< [m]
    float q_IS[4];         ///< [-] unit, scalar first
    float v_IS_m_s[3];     ///< [m/s] in axes of I
    float w_IS_S_rad_s[3]; ///< [rad/s] in axes of S
} ssv_link_pose_t;

typedef struct {
    uint32_t boot_id, session, progress; ///< see SSV_BEAT in ssv.xml
} ssv_link_beat_t;

typedef struct {
    uint32_t boot_id, session, sequence; ///< see SSV_TRIM in ssv.xml
    int64_t plan_time_ns;                ///< [ns]
    float clock_rate;                    ///< [-] [0, 1] of the timeline's clock
    float trim_N[SSV_NUM_THRUSTERS];     ///< [N] finite
} ssv_link_trim_t;

/// Numbers are those of MAV_CMD, so that any tool can give them.
typedef enum {
    SSV_LINK_TERMINATE = 185,      ///< MAV_CMD_DO_FLIGHTTERMINATION: stop safely, whatever is under way
    SSV_LINK_PAUSE_CONTINUE = 193, ///< MAV_CMD_DO_PAUSE_CONTINUE: value 0 pauses, 1 goes on
    SSV_LINK_ARM = 400,            ///< MAV_CMD_COMPONENT_ARM_DISARM: value 1 arms, 0 disarms
    SSV_LINK_COMMIT = 31010,       ///< MAV_CMD_USER_1, with the plan hash
    SSV_LINK_START = 31011,        ///< MAV_CMD_USER_2, with the plan hash
    SSV_LINK_DROP = 31012          ///< MAV_CMD_USER_3: forget the incoming timeline
} ssv_link_command_t;

// ---- The vehicle's end ----------------------------------------------------------------------------------------------

/// A number that tools may read and none may set.
typedef struct {
    char name[SSV_LINK_PARAMETER_NAME_MAX + 1]; ///< upper case, e.g. "SSV_BEAT_STOP_S"
    float value;
} ssv_link_parameter_t;

typedef struct {
    uint8_t sysid, compid; ///< SSV_LINK_VEHICLE_*
    uint32_t boot_id;      ///< another at each boot, never 0
    uint32_t version;      ///< major, minor, patch, type from the highest byte down
    bool sign;
    ssv_link_signing_t signing;             ///< read if `sign`
    const ssv_link_parameter_t* parameters; ///< outlives the link
    int32_t num_parameters;
    uint32_t mass_configuration; ///< see ssv/timeline.h; a timeline for another one is refused
    float force_max_N;           ///< [N] the most that every thruster can give
    float start_tolerance_m;     ///< [m] how far from a timeline's start the vehicle may be when it is committed
    float start_tolerance_rad;   ///< [rad] likewise
} ssv_link_vehicle_config_t;

/// What the link tells others about the vehicle, and checks commands against: kept up to date by the vehicle.
typedef struct {
    ssv_link_phase_t phase;
    ssv_link_reason_t reason;
    bool may_swap;        ///< whether a commit may replace the live timeline now
    int64_t plan_time_ns; ///< [ns]
    int32_t segment;
    uint8_t events, attempts; ///< see SSV_EXECUTION in ssv.xml
    uint32_t beat;            ///< progress counter of the newest beat that counted
    ssv_link_pose_t pose;
    int64_t pose_us;              ///< [us] when the pose held
    float u_N[SSV_NUM_THRUSTERS]; ///< [N] thrusts commanded now
} ssv_link_vehicle_state_t;

typedef enum {
    SSV_LINK_VEHICLE_NOTHING = 0,
    SSV_LINK_VEHICLE_COMMANDED, ///< arm, pause, terminate or start: answer it by ssv_link_vehicle_answer
    SSV_LINK_VEHICLE_COMMITTED, ///< the live timeline is another one now; already answered
    SSV_LINK_VEHICLE_BEAT,
    SSV_LINK_VEHICLE_TRIM
} ssv_link_vehicle_event_kind_t;

typedef struct {
    ssv_link_vehicle_event_kind_t kind;
    uint8_t sysid, compid; ///< who sent it
    union {
        struct {
            ssv_link_command_t command;
            int32_t value;      ///< see ssv_link_command_t
            uint64_t plan_hash; ///< of a start; it is that of the live timeline, which has not expired
        } command;
        ssv_link_beat_t beat;
        ssv_link_trim_t trim;
    } of;
} ssv_link_vehicle_event_t;

#define SSV_LINK_MAX_ANSWERS 12
#define SSV_LINK_MAX_TEXTS 4
#define SSV_LINK_LOG_BYTES 1024
#define SSV_LINK_NUM_STREAMS 6

/// An answer of the file server that waits to be sent; the data of a read are taken when it is.
typedef struct {
    uint8_t sysid, compid;
    uint16_t sequence;
    uint8_t session, opcode, request, size, file, last_of_burst;
    uint32_t offset;
    uint8_t data[4];
} ssv_link_answer_t;

typedef struct {
    uint8_t sysid, compid, result;
    uint16_t command;
    int32_t detail;
} ssv_link_ack_t;

/// The file server. Private to the link.
typedef struct {
    bool open;             ///< whether there is a session
    uint8_t session;       ///< its number
    uint8_t file;          ///< what it has open
    uint8_t sysid, compid; ///< whose it is
    int64_t active_us;     ///< when it was last used, by either end
    bool has_last;         ///< the newest answer to a request that does something the second time, to give again
    ssv_link_answer_t last;
    uint32_t last_crc; ///< of that request, without its session
    bool burst;        ///< whether a burst is being sent
    ssv_link_answer_t next_of_burst;
    int32_t num_answers, first_answer;
    ssv_link_answer_t answer[SSV_LINK_MAX_ANSWERS];
} ssv_link_server_t;

/// The vehicle's end: some 17 kB, most of it the two timelines. Private to the link but for `wire.statistics`.
typedef struct {
    ssv_link_vehicle_config_t config;
    ssv_wire_t wire;
    ssv_link_server_t server;
    uint8_t image[2][SSV_TIMELINE_FILE_BYTES_MAX]; ///< timeline files: one live, one incoming
    uint8_t live;                                  ///< which is which
    uint32_t length[2];                            ///< [bytes] 0 for none
    bool incoming;                                 ///< whether an upload has begun since the last commit or drop
    int64_t begun_us[2];                           ///< [us] when the upload began
    int64_t epoch_us;                              ///< of the timeline committed last
    int32_t num_acks, first_ack;
    ssv_link_ack_t ack[4];
    int32_t num_texts, first_text;
    struct {
        uint8_t severity;
        char text[SSV_LINK_TEXT_MAX + 1];
    } text[SSV_LINK_MAX_TEXTS];
    uint16_t log_length;
    uint8_t log[SSV_LINK_LOG_BYTES];
    int64_t interval_us[SSV_LINK_NUM_STREAMS], due_us[SSV_LINK_NUM_STREAMS]; ///< [us]; interval < 0: never
    int64_t told_us[SSV_LINK_NUM_STREAMS]; ///< [us] when the pose held that was told last
    bool served;                           ///< whether the last frame was the file server's
    bool want_version, want_timesync;
    int64_t timesync_ns;
    int32_t next_parameter, end_parameter; ///< parameters yet to be sent
} ssv_link_vehicle_t;

/// Starts the link with no timeline, live or incoming.
void ssv_link_vehicle_init(ssv_link_vehicle_t* link, const ssv_link_vehicle_config_t* config);

/// Takes bytes that arrived, up to and including those that make an event. Returns how many it took, which may be none
/// when bytes that came before make another event; `event->kind` is SSV_LINK_VEHICLE_NOTHING when it took all without
/// one.
size_t ssv_link_vehicle_receive(ssv_link_vehicle_t* link, int64_t now_us, const ssv_link_vehicle_state_t* state,
                                const uint8_t* bytes, size_t num_bytes, ssv_link_vehicle_event_t* event);

/// Answers a command. A command that comes again because the answer was lost is an event again: the vehicle accepts
/// what it already does.
void ssv_link_vehicle_answer(ssv_link_vehicle_t* link, const ssv_link_vehicle_event_t* event, ssv_link_result_t result,
                             ssv_link_reason_t reason);

/// The next frame to send, in `frame` with room for SSV_LINK_FRAME_BYTES_MAX; its length, or 0 when none is due.
size_t ssv_link_vehicle_poll(ssv_link_vehicle_t* link, int64_t now_us, const ssv_link_vehicle_state_t* state,
                             uint8_t* frame);

/// Tells tools and the log (/log/events). The oldest text that waits to be sent gives way when too many do; the log
/// keeps all that fit into it, the newest ones.
void ssv_link_vehicle_say(ssv_link_vehicle_t* link, int64_t now_us, ssv_link_severity_t severity, const char* text);

/// The file of the live timeline, sound, for ssv_timeline_read_*; null for none. It stays as it is until the next
/// SSV_LINK_VEHICLE_COMMITTED. `expires_us` [us] is the latest start; may be null.
const uint8_t* ssv_link_vehicle_live(const ssv_link_vehicle_t* link, int64_t* expires_us);

// ---- The planner's end ----------------------------------------------------------------------------------------------

typedef struct {
    uint8_t sysid, compid; ///< sysid of the vehicle, SSV_LINK_PLANNER_COMPID
    uint8_t vehicle_sysid, vehicle_compid;
    uint32_t boot_id; ///< another at each boot, never 0
    bool sign;
    ssv_link_signing_t signing; ///< read if `sign`
    uint8_t chunk_bytes;        ///< [bytes] of file per frame, 64 to 239; 0 for 239. Radios that split long
                                ///< frames lose less with 80
} ssv_link_planner_config_t;

typedef enum {
    SSV_LINK_PLANNER_NOTHING = 0,
    SSV_LINK_PLANNER_SEEN,      ///< a heartbeat of the vehicle
    SSV_LINK_PLANNER_EXECUTION, ///< where it is in its timeline
    SSV_LINK_PLANNER_ATTITUDE,  ///< q_IS and w_IS_S of the pose
    SSV_LINK_PLANNER_POSITION,  ///< p_IS and v_IS of the pose
    SSV_LINK_PLANNER_THRUSTS,
    SSV_LINK_PLANNER_TEXT,
    SSV_LINK_PLANNER_HEALTH,   ///< how the vehicle receives us
    SSV_LINK_PLANNER_ANSWERED, ///< a command was answered, or will not be
    SSV_LINK_PLANNER_UPLOADED, ///< the vehicle has the file, its CRC-32 says
    SSV_LINK_PLANNER_UPLOAD_FAILED
} ssv_link_planner_event_kind_t;

typedef struct {
    uint32_t time_boot_ms, boot_id, beat;
    uint64_t live_hash, incoming_hash;
    int64_t plan_time_ns;
    int32_t segment;
    ssv_link_phase_t phase;
    ssv_link_reason_t reason;
    uint8_t events, attempts;
} ssv_link_execution_t;

typedef struct {
    ssv_link_planner_event_kind_t kind;
    union {
        struct {
            bool armed;
            uint32_t custom_mode;
        } seen;
        ssv_link_execution_t execution;
        struct {
            uint32_t time_boot_ms; ///< [ms] when it held, by the vehicle's clock
            ssv_link_pose_t pose;
        } pose;
        float u_N[SSV_NUM_THRUSTERS]; ///< [N]
        struct {
            uint8_t severity;
            char text[SSV_LINK_TEXT_MAX + 1];
        } text;
        struct {
            uint16_t lost, bad_crc, bad_signature;
        } health;
        struct {
            ssv_link_command_t command;
            ssv_link_result_t result;
            ssv_link_reason_t reason;
            int32_t index; ///< that the reason is about
        } answer;
        ssv_link_reason_t upload; ///< why it failed; SSV_LINK_NOTHING for no answer
    } of;
} ssv_link_planner_event_t;

#define SSV_LINK_WINDOW 8

/// A request of the file client that waits for its answer. Private to the link.
typedef struct {
    bool used;
    uint16_t sequence;
    uint8_t chunk;
    uint8_t tries;
    bool due;            ///< to be sent (again) at the next poll
    uint32_t order;      ///< count of requests when it was sent last
    int64_t sent_us;     ///< [us] when it was sent last
    int64_t patience_us; ///< [us] how long to wait for the answer
} ssv_link_request_t;

/// The file client. Private to the link.
typedef struct {
    uint8_t stage;
    uint8_t session;
    uint8_t restarts;
    const uint8_t* file;
    uint32_t length, crc;
    uint16_t next_sequence;
    uint8_t num_chunks, next_chunk, num_acked;
    uint32_t acked[4]; ///< one bit per chunk
    uint32_t order;
    int64_t round_trip_us, deviation_us; ///< [us] smoothed; 0 before the first sample
    ssv_link_request_t request[SSV_LINK_WINDOW];
} ssv_link_client_t;

/// The planner's end: some 1.5 kB. Private to the link but for `wire.statistics`.
typedef struct {
    ssv_link_planner_config_t config;
    ssv_wire_t wire;
    ssv_link_client_t client;
    struct {
        bool pending;
        ssv_link_command_t command;
        int32_t value;
        uint64_t plan_hash;
        uint8_t tries;
        int64_t due_us;
    } command;
    ssv_link_beat_t beat;
    int64_t beat_due_us, heartbeat_due_us;
    bool has_trim;
    ssv_link_trim_t trim;
} ssv_link_planner_t;

void ssv_link_planner_init(ssv_link_planner_t* link, const ssv_link_planner_config_t* config);

/// As ssv_link_vehicle_receive; also gives the events of time-outs, so call it with no bytes as well, after polling.
size_t ssv_link_planner_receive(ssv_link_planner_t* link, int64_t now_us, const uint8_t* bytes, size_t num_bytes,
                                ssv_link_planner_event_t* event);

/// As ssv_link_vehicle_poll.
size_t ssv_link_planner_poll(ssv_link_planner_t* link, int64_t now_us, uint8_t* frame);

/// Begins to upload a file of ssv_timeline_encode, which the caller keeps until SSV_LINK_PLANNER_UPLOADED or
/// SSV_LINK_PLANNER_UPLOAD_FAILED. An upload under way is given up, without an event. False, and nothing begins, when
/// the length is not that of a timeline file.
bool ssv_link_planner_upload(ssv_link_planner_t* link, const uint8_t* file, size_t length);

/// How many bytes of the file the vehicle has acknowledged.
size_t ssv_link_planner_uploaded(const ssv_link_planner_t* link);

/// Gives a command; false while another one waits for its answer, unless this one is SSV_LINK_TERMINATE, which takes
/// its place. The plan hash matters to SSV_LINK_COMMIT and SSV_LINK_START, the value to the others. Commit after
/// SSV_LINK_PLANNER_UPLOADED and not before: of an unfinished upload a repeated commit may be accepted when the first
/// one was refused. What is live is in SSV_LINK_PLANNER_EXECUTION.
bool ssv_link_planner_command(ssv_link_planner_t* link, int64_t now_us, ssv_link_command_t command, int32_t value,
                              uint64_t plan_hash);

/// What the next beats say; they go out ten times a second once the session is not 0.
void ssv_link_planner_beat(ssv_link_planner_t* link, uint32_t session, uint32_t progress);

/// Sends trims at the next poll; newer ones take the place of those not yet sent.
void ssv_link_planner_trim(ssv_link_planner_t* link, uint32_t session, uint32_t sequence, int64_t plan_time_ns,
                           float clock_rate, const float trim_N[SSV_NUM_THRUSTERS]);

#ifdef __cplusplus
}
#endif

#endif
