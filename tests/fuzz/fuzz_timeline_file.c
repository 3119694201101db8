// Fuzzes the reader of timeline files. The input is a file whose magic, lengths, sum of durations and CRC-32 are mended
// as its first byte says, so that what is behind them is reached. What is found sound is the only file of its timeline,
// and no number of it is out of range.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "link/bytes.h"
#include "link/timeline_file.h"
#include "ssv/link.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

static void check(bool holds) {
    if (!holds) abort();
}

static void mend(uint8_t how, uint8_t* file, size_t length) {
    static const uint8_t front[] = {'S', 'S', 'V', 'T', 1, 0, 6};
    if (length < SSV_TIMELINE_HEADER_BYTES) return;
    if ((how & 1) != 0) {
        memcpy(file, front, sizeof front);
        ssv_put_u32(file + AT_LENGTH, (uint32_t)length);
    }
    const size_t num_segments = (length - SSV_TIMELINE_HEADER_BYTES) / SSV_TIMELINE_SEGMENT_BYTES;
    if ((how & 2) != 0) ssv_put_u16(file + AT_NUM_SEGMENTS, (uint16_t)num_segments);
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
