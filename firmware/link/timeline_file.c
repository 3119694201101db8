// Timelines as files: written, checked, read.
#include "link/timeline_file.h"

#include "link/bytes.h"
#include "ssv/link.h"

#define VERSION 1
#define EVENT_BYTES 4
/// [m] Farther from the origin no tank reaches.
#define POSITION_MAX_M 10000.0F
#define FORCE_MAX_N 10000.0F
/// How far the square of a quaternion's length may be from 1: five times what rounding to binary32 does.
#define UNIT_TOLERANCE 1e-6F

static const uint8_t magic[4] = {'S', 'S', 'V', 'T'};

// The CRC of each value of half a byte: 64 bytes of table, twice as fast as bit by bit.
static uint32_t crc_of(uint32_t state, const uint8_t* bytes, size_t num_bytes) {
    static const uint32_t table[16] = {0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4,
                                       0x4db26158, 0x5005713c, 0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c,
                                       0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
    for (size_t i = 0; i < num_bytes; i++) {
        state = table[(state ^ bytes[i]) & 15] ^ state >> 4;
        state = table[(state ^ (uint32_t)bytes[i] >> 4) & 15] ^ state >> 4;
    }
    return state;
}

uint32_t ssv_crc32(uint32_t before, const uint8_t* bytes, size_t num_bytes) {
    return ~crc_of(~before, bytes, num_bytes);
}

uint32_t ssv_crc32_of_ftp(const uint8_t* bytes, size_t num_bytes) { return crc_of(0, bytes, num_bytes); }

static uint32_t content_crc(const uint8_t* file, size_t length) {
    return ssv_crc32(0, file + AT_PLAN_HASH, length - AT_PLAN_HASH);
}

static const uint8_t* segment_at(const uint8_t* file, int32_t index) {
    return file + SSV_TIMELINE_HEADER_BYTES + SSV_TIMELINE_SEGMENT_BYTES * (size_t)index;
}

static size_t length_of(int32_t num_segments) {
    return SSV_TIMELINE_HEADER_BYTES + SSV_TIMELINE_SEGMENT_BYTES * (size_t)num_segments;
}

void ssv_timeline_read_segment(const uint8_t* file, int32_t index, ssv_timeline_segment_t* segment) {
    const uint8_t* at = segment_at(file, index);
    segment->duration_ns = ssv_get_i64(at);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        segment->u_start_N[i] = ssv_get_f32(at + AT_U_START + 4 * i);
        segment->u_end_N[i] = ssv_get_f32(at + AT_U_END + 4 * i);
    }
}

int32_t ssv_timeline_read_events(const uint8_t* file, int32_t* num_segments,
                                 ssv_timeline_event_t event[SSV_MAX_EVENTS]) {
    for (int i = 0; i < SSV_MAX_EVENTS; i++) {
        const uint8_t* at = file + AT_EVENTS + EVENT_BYTES * i;
        event[i].segment = ssv_get_u16(at);
        event[i].kind = at[2] == SSV_DOCK ? SSV_DOCK : SSV_MATE;
    }
    *num_segments = ssv_get_u16(file + AT_NUM_SEGMENTS);
    return file[AT_NUM_EVENTS];
}

void ssv_timeline_read_header(const uint8_t* file, ssv_timeline_t* timeline, ssv_timeline_stamp_t* stamp) {
    timeline->plan_hash = ssv_get_u64(file + AT_PLAN_HASH);
    timeline->mass_configuration = ssv_get_u32(file + AT_MASS_CONFIGURATION);
    timeline->u_max_N = ssv_get_f32(file + AT_U_MAX);
    for (int i = 0; i < 3; i++) timeline->p_IS_m[i] = ssv_get_f32(file + AT_P_IS + 4 * i);
    for (int i = 0; i < 4; i++) timeline->q_IS[i] = ssv_get_f32(file + AT_Q_IS + 4 * i);
    timeline->num_events = ssv_timeline_read_events(file, &timeline->num_segments, timeline->event);
    if (stamp != NULL) {
        stamp->epoch_us = ssv_get_i64(file + AT_EPOCH);
        stamp->valid_for_ms = ssv_get_u32(file + AT_VALID_FOR);
    }
}

static ssv_timeline_fault_t fault(ssv_link_reason_t reason, int32_t index) {
    return (ssv_timeline_fault_t){reason, index};
}

// Length, format and CRC: after these the file is what somebody wrote.
static ssv_link_reason_t check_frame(const uint8_t* file, size_t length) {
    if (length < SSV_TIMELINE_HEADER_BYTES || length > SSV_TIMELINE_FILE_BYTES_MAX) return SSV_LINK_LENGTH;
    if (memcmp(file, magic, sizeof magic) != 0 || ssv_get_u16(file + AT_VERSION) != VERSION ||
        file[AT_THRUSTERS] != SSV_NUM_THRUSTERS)
        return SSV_LINK_FORMAT;
    if (ssv_get_u32(file + AT_LENGTH) != length) return SSV_LINK_LENGTH;
    if (ssv_get_u32(file + AT_CRC) != content_crc(file, length)) return SSV_LINK_CRC;
    if (ssv_get_u16(file + AT_NUM_SEGMENTS + 2) != 0 || ssv_get_u32(file + AT_DURATION - 4) != 0)
        return SSV_LINK_FORMAT;
    return SSV_LINK_NO_REASON;
}

// Field by field, since a ssv_timeline_t to read it into is 7 kB.
static ssv_link_reason_t check_header(const uint8_t* file) {
    const float u_max_N = ssv_get_f32(file + AT_U_MAX);
    if (ssv_get_u64(file + AT_PLAN_HASH) == 0) return SSV_LINK_PLAN_HASH;
    if (ssv_get_i64(file + AT_EPOCH) <= 0) return SSV_LINK_EPOCH;
    if (ssv_get_u32(file + AT_VALID_FOR) == 0) return SSV_LINK_EXPIRY;
    if (!(u_max_N >= 0 && u_max_N <= FORCE_MAX_N)) return SSV_LINK_FORCE;
    for (int i = 0; i < 3; i++) {
        if (!ssv_within(ssv_get_f32(file + AT_P_IS + 4 * i), POSITION_MAX_M)) return SSV_LINK_START_POSE;
    }
    float square = 0;
    for (int i = 0; i < 4; i++) {
        const float q = ssv_get_f32(file + AT_Q_IS + 4 * i);
        square += q * q;
    }
    return ssv_within(square - 1, UNIT_TOLERANCE) ? SSV_LINK_NO_REASON : SSV_LINK_START_POSE;
}

static bool is_sound_event(const uint8_t* file, int32_t index, int32_t num_segments) {
    const uint8_t* at = file + AT_EVENTS + EVENT_BYTES * (size_t)index;
    if (index >= file[AT_NUM_EVENTS]) return ssv_get_u32(at) == 0;
    // The vehicle mates before it docks, and each once.
    const bool in_order = index == 0 || (ssv_get_u16(at - EVENT_BYTES) <= ssv_get_u16(at) && at[-2] < at[2]);
    return ssv_get_u16(at) <= num_segments && at[2] <= SSV_DOCK && at[3] == 0 && in_order;
}

static bool is_sound_thrust(const uint8_t* segment, float u_max_N) {
    for (int i = 0; i < 2 * SSV_NUM_THRUSTERS; i++) {
        if (!ssv_within(ssv_get_f32(segment + AT_U_START + 4 * i), u_max_N)) return false;
    }
    return true;
}

ssv_timeline_fault_t ssv_timeline_check(const uint8_t* file, size_t length) {
    ssv_link_reason_t reason = check_frame(file, length);
    if (reason != SSV_LINK_NO_REASON) return fault(reason, 0);
    const int32_t num_segments = ssv_get_u16(file + AT_NUM_SEGMENTS);
    if (num_segments > SSV_MAX_SEGMENTS || length_of(num_segments) != length)
        return fault(SSV_LINK_SEGMENTS, num_segments);
    if (file[AT_NUM_EVENTS] > SSV_MAX_EVENTS) return fault(SSV_LINK_EVENT, file[AT_NUM_EVENTS]);

    reason = check_header(file);
    if (reason != SSV_LINK_NO_REASON) return fault(reason, 0);
    const float u_max_N = ssv_get_f32(file + AT_U_MAX);
    int64_t sum_ns = 0;
    for (int32_t i = 0; i < num_segments; i++) {
        const int64_t duration_ns = ssv_get_i64(segment_at(file, i));
        if (duration_ns <= 0 || duration_ns > SSV_TIMELINE_DURATION_MAX_NS) return fault(SSV_LINK_DURATION, i);
        sum_ns += duration_ns; // 128 times the limit is far from 2^63
        if (!is_sound_thrust(segment_at(file, i), u_max_N)) return fault(SSV_LINK_THRUST, i);
    }
    if (sum_ns > SSV_TIMELINE_DURATION_MAX_NS || sum_ns != ssv_get_i64(file + AT_DURATION))
        return fault(SSV_LINK_DURATION, num_segments);
    for (int32_t i = 0; i < SSV_MAX_EVENTS; i++) {
        if (!is_sound_event(file, i, num_segments)) return fault(SSV_LINK_EVENT, i);
    }
    return fault(SSV_LINK_NO_REASON, 0);
}

ssv_timeline_fault_t ssv_timeline_decode(const uint8_t* file, size_t length, ssv_timeline_t* timeline,
                                         ssv_timeline_stamp_t* stamp) {
    const ssv_timeline_fault_t found = ssv_timeline_check(file, length);
    if (found.reason != SSV_LINK_NO_REASON) return found;
    ssv_timeline_read_header(file, timeline, stamp);
    for (int32_t i = 0; i < timeline->num_segments; i++) ssv_timeline_read_segment(file, i, &timeline->segment[i]);
    return found;
}

size_t ssv_timeline_encode(const ssv_timeline_t* timeline, const ssv_timeline_stamp_t* stamp, uint8_t* file,
                           size_t capacity) {
    if (timeline->num_segments < 0 || timeline->num_segments > SSV_MAX_SEGMENTS || timeline->num_events < 0 ||
        timeline->num_events > SSV_MAX_EVENTS)
        return 0;
    const size_t length = length_of(timeline->num_segments);
    if (length > capacity) return 0;
    memset(file, 0, SSV_TIMELINE_HEADER_BYTES);
    memcpy(file, magic, sizeof magic);
    ssv_put_u16(file + AT_VERSION, VERSION);
    file[AT_THRUSTERS] = SSV_NUM_THRUSTERS;
    file[AT_NUM_EVENTS] = (uint8_t)timeline->num_events;
    ssv_put_u32(file + AT_LENGTH, (uint32_t)length);
    ssv_put_u64(file + AT_PLAN_HASH, timeline->plan_hash);
    ssv_put_u64(file + AT_EPOCH, (uint64_t)stamp->epoch_us);
    ssv_put_u32(file + AT_VALID_FOR, stamp->valid_for_ms);
    ssv_put_u32(file + AT_MASS_CONFIGURATION, timeline->mass_configuration);
    ssv_put_f32(file + AT_U_MAX, timeline->u_max_N);
    for (int i = 0; i < 3; i++) ssv_put_f32(file + AT_P_IS + 4 * i, timeline->p_IS_m[i]);
    for (int i = 0; i < 4; i++) ssv_put_f32(file + AT_Q_IS + 4 * i, timeline->q_IS[i]);
    ssv_put_u16(file + AT_NUM_SEGMENTS, (uint16_t)timeline->num_segments);
    for (int32_t i = 0; i < timeline->num_events; i++) {
        uint8_t* at = file + AT_EVENTS + EVENT_BYTES * i;
        if (timeline->event[i].segment < 0 || timeline->event[i].segment > timeline->num_segments) return 0;
        ssv_put_u16(at, (uint16_t)timeline->event[i].segment);
        at[2] = (uint8_t)timeline->event[i].kind;
    }
    uint64_t sum_ns = 0; // wraps where a duration is out of range, which the check finds
    for (int32_t i = 0; i < timeline->num_segments; i++) {
        uint8_t* at = file + length_of(i);
        const ssv_timeline_segment_t* segment = &timeline->segment[i];
        ssv_put_u64(at, (uint64_t)segment->duration_ns);
        for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
            ssv_put_f32(at + AT_U_START + 4 * k, segment->u_start_N[k]);
            ssv_put_f32(at + AT_U_END + 4 * k, segment->u_end_N[k]);
        }
        sum_ns += (uint64_t)segment->duration_ns;
    }
    ssv_put_u64(file + AT_DURATION, sum_ns);
    ssv_put_u32(file + AT_CRC, content_crc(file, length));
    return ssv_timeline_check(file, length).reason == SSV_LINK_NO_REASON ? length : 0;
}
