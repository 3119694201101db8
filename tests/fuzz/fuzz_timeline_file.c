// Fuzzes the reader of timeline files. The input is a file whose magic, lengths, header, segments, sum of durations and
// CRC-32 are mended as its first byte says, so that what is behind them is reached. What is found sound is the only
// file of its timeline, and no number of it is out of range.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "link/bytes.h"
#include "link/timeline_file.h"
#include "ssv/link.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

// A header that nothing is wrong with but its counts and events.
static void mend_header(uint8_t* file) {
    ssv_put_u64(file + AT_PLAN_HASH, ssv_get_u64(file + AT_PLAN_HASH) | 1);
    ssv_put_u64(file + AT_EPOCH, ssv_get_u32(file + AT_EPOCH) | 1);
    ssv_put_u32(file + AT_VALID_FOR, ssv_get_u32(file + AT_VALID_FOR) | 1);
    ssv_put_f32(file + AT_U_MAX, 6);
    memset(file + AT_P_IS, 0, AT_NUM_SEGMENTS - AT_P_IS);
    ssv_put_f32(file + AT_Q_IS, 1);
    ssv_put_u16(file + AT_NUM_SEGMENTS + 2, 0);
    ssv_put_u32(file + AT_DURATION - 4, 0);
}

// Durations of up to 4 s and thrusts below 2 N.
static void mend_segment(uint8_t* at) {
    ssv_put_u64(at, UINT64_C(1) + ssv_get_u32(at));
    for (int i = 0; i < 2 * SSV_NUM_THRUSTERS; i++) at[AT_U_START + 4 * i + 3] &= 0xbf;
}

static void mend(uint8_t how, uint8_t* file, size_t length) {
    static const uint8_t front[] = {'S', 'S', 'V', 'T', 1, 0, 6};
    if (length < SSV_TIMELINE_HEADER_BYTES) return;
    if ((how & 1) != 0) {
        memcpy(file, front, sizeof front);
        ssv_put_u32(file + AT_LENGTH, (uint32_t)length);
    }
    if ((how & 8) != 0) mend_header(file);
    const size_t num_segments = (length - SSV_TIMELINE_HEADER_BYTES) / SSV_TIMELINE_SEGMENT_BYTES;
    if ((how & 2) != 0) ssv_put_u16(file + AT_NUM_SEGMENTS, (uint16_t)num_segments);
    for (size_t i = 0; i < num_segments && (how & 16) != 0; i++)
        mend_segment(file + SSV_TIMELINE_HEADER_BYTES + SSV_TIMELINE_SEGMENT_BYTES * i);
    if ((how & 4) != 0) {
        uint64_t sum = 0;
        for (size_t i = 0; i < num_segments; i++)
            sum += ssv_get_u64(file + SSV_TIMELINE_HEADER_BYTES + SSV_TIMELINE_SEGMENT_BYTES * i);
        ssv_put_u64(file + AT_DURATION, sum);
    }
    ssv_put_u32(file + AT_CRC, ssv_crc32(0, file + AT_PLAN_HASH, length - AT_PLAN_HASH));
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static uint8_t file[SSV_TIMELINE_FILE_BYTES_MAX + 64], again[SSV_TIMELINE_FILE_BYTES_MAX];
    static ssv_timeline_t timeline;
    ssv_timeline_stamp_t stamp = {0, 0};
    if (size < 1 || size - 1 > sizeof file) return 0;
    const uint8_t how = data[0];
    const size_t length = size - 1;
    uint8_t* exact = malloc(length + 1); // so that a read past the end is seen
    if (exact == NULL) return 0;
    memcpy(exact, data + 1, length);
    mend(how, exact, length);
    memset(&timeline, 0xaa, sizeof timeline);
    if (ssv_timeline_decode(exact, length, &timeline, &stamp).reason == SSV_LINK_NO_REASON) {
        int64_t sum_ns = 0;
        for (int32_t i = 0; i < timeline.num_segments; i++) {
            check(timeline.segment[i].duration_ns > 0);
            sum_ns += timeline.segment[i].duration_ns;
            for (int k = 0; k < SSV_NUM_THRUSTERS; k++)
                check(fabsf(timeline.segment[i].u_start_N[k]) <= timeline.u_max_N &&
                      fabsf(timeline.segment[i].u_end_N[k]) <= timeline.u_max_N);
        }
        check(sum_ns <= SSV_TIMELINE_DURATION_MAX_NS && timeline.plan_hash != 0 && stamp.epoch_us > 0);
        check(ssv_timeline_encode(&timeline, &stamp, again, sizeof again) == length);
        check(memcmp(again, exact, length) == 0);
    }
    free(exact);
    return 0;
}
