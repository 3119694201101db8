/// Frames to packets and back: the one module that knows MAVLink's generated code. A packet is what a message means to
/// this project, in its own units and frames; messages that no end of the link cares about are counted and passed over.
#ifndef SSV_LINK_WIRE_H
#define SSV_LINK_WIRE_H

#include "ssv/link.h"

/// Bytes of a file-transfer request or answer: header and data.
#define SSV_FTP_HEADER_BYTES 12
#define SSV_FTP_DATA_BYTES_MAX 239

typedef enum {
    SSV_PACKET_HEARTBEAT,
    SSV_PACKET_HEALTH,
    SSV_PACKET_COMMAND,
    SSV_PACKET_ACK,
    SSV_PACKET_ATTITUDE,
    SSV_PACKET_POSITION,
    SSV_PACKET_THRUSTS,
    SSV_PACKET_TEXT,
    SSV_PACKET_TIMESYNC,
    SSV_PACKET_PARAMETER_LIST,
    SSV_PACKET_PARAMETER_READ,
    SSV_PACKET_PARAMETER_SET,
    SSV_PACKET_PARAMETER,
    SSV_PACKET_VERSION,
    SSV_PACKET_FTP,
    SSV_PACKET_EXECUTION,
    SSV_PACKET_BEAT,
    SSV_PACKET_TRIM
} ssv_packet_kind_t;

typedef struct {
    uint16_t sequence;
    uint8_t session, opcode, size, request, last_of_burst;
    uint32_t offset;
    uint8_t data[SSV_FTP_DATA_BYTES_MAX];
} ssv_ftp_t;

typedef struct {
    ssv_packet_kind_t kind;
    uint8_t sysid, compid;               ///< the sender, of a packet that arrived
    uint8_t target_sysid, target_compid; ///< 0 for all, and where the message has no target
    uint32_t time_ms; ///< [ms] since the sender's boot; of a pose when it held, of others when it is sent
    union {
        struct {
            uint8_t type, autopilot, base_mode, status;
            uint32_t custom_mode;
        } heartbeat;
        struct {
            uint16_t lost_permyriad, lost, bad_crc, bad_signature, refused;
        } health;
        struct {
            uint16_t command;
            bool is_long; ///< COMMAND_LONG: x and y are 0
            float parameter[4];
            uint32_t x, y;
        } command;
        struct {
            uint16_t command;
            uint8_t result;
            int32_t detail;
        } ack;
        ssv_link_pose_t pose;
        float u_N[SSV_NUM_THRUSTERS];
        struct {
            uint8_t severity;
            char text[SSV_LINK_TEXT_MAX + 1];
        } text;
        struct {
            int64_t theirs_ns, ours_ns; ///< [ns] time of the asker; of the answerer, 0 in a question
        } timesync;
        struct {
            int32_t index, count; ///< index < 0: by name
            char name[SSV_LINK_PARAMETER_NAME_MAX + 1];
            float value;
        } parameter;
        uint32_t version;
        ssv_ftp_t ftp;
        ssv_link_execution_t execution;
        ssv_link_beat_t beat;
        ssv_link_trim_t trim;
    } of;
} ssv_packet_t;

/// `signing` null: neither signs nor asks for signatures.
void ssv_wire_init(ssv_wire_t* wire, uint8_t sysid, uint8_t compid, const ssv_link_signing_t* signing);

/// Takes one byte that arrived, once ssv_wire_next has no more.
void ssv_wire_take(ssv_wire_t* wire, uint8_t byte);

/// The next packet that is for us or for all, out of the bytes taken; false when there is none. What followed a start
/// of frame that was none is looked through again, so that no frame is lost to it: otherwise bytes of a payload that
/// look like a start can hide the same frame each time that it comes.
bool ssv_wire_next(ssv_wire_t* wire, int64_t now_us, ssv_packet_t* packet);

/// Writes the packet's frame, at most SSV_LINK_FRAME_BYTES_MAX, and returns its length. The sender and the time of
/// the packet are filled in here.
size_t ssv_wire_send(ssv_wire_t* wire, int64_t now_us, ssv_packet_t* packet, uint8_t* frame);

#endif
