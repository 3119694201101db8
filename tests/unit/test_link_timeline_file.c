// The timeline file: what is written is read back, and each thing that can be wrong is found and named.
#include <float.h>
#include <math.h>
#include <string.h>

#include "two_ends.h"
#include "unity.h"

static uint8_t file[SSV_TIMELINE_FILE_BYTES_MAX];
static ssv_timeline_t timeline, back;
static const ssv_timeline_stamp_t stamp = {EPOCH_US, 600000};

void setUp(void) {
    draw_seed(1);
    timeline = draw_timeline(10);
}
void tearDown(void) {}

// CRC-32 bit by bit, as its definition says.
static uint32_t slow_crc(const uint8_t* bytes, size_t length, uint32_t state) {
    for (size_t i = 0; i < length; i++) {
        state ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) state = (state & 1) != 0 ? state >> 1 ^ 0xedb88320 : state >> 1;
    }
    return state;
}

static size_t encode(void) { return ssv_timeline_encode(&timeline, &stamp, file, sizeof file); }

// Puts the right CRC into a file that was changed on purpose.
static void mend_crc(size_t length) {
    const uint32_t crc = ~slow_crc(file + 16, length - 16, UINT32_MAX);
    for (int i = 0; i < 4; i++) file[12 + i] = (uint8_t)(crc >> 8 * i);
}

static void test_what_is_encoded_is_decoded_bit_for_bit_for_every_number_of_segments(void) {
    for (int n = 0; n <= SSV_MAX_SEGMENTS; n++) {
        ssv_timeline_stamp_t stamp_back = {0, 0};
        timeline = draw_timeline(n);
        memset(&back, 0, sizeof back);
        const size_t length = encode();
        TEST_ASSERT_EQUAL_size_t(96 + 56 * (size_t)n, length);
        const ssv_timeline_fault_t fault = ssv_timeline_decode(file, length, &back, &stamp_back);
        TEST_ASSERT_EQUAL_INT(SSV_LINK_NO_REASON, fault.reason);
        TEST_ASSERT_EQUAL_MEMORY(&timeline, &back, sizeof back);
        TEST_ASSERT_EQUAL_INT64(stamp.epoch_us, stamp_back.epoch_us);
        TEST_ASSERT_EQUAL_UINT32(stamp.valid_for_ms, stamp_back.valid_for_ms);
    }
}

static void test_every_flipped_bit_is_found(void) {
    const size_t length = encode();
    for (size_t bit = 0; bit < 8 * length; bit++) {
        file[bit / 8] ^= (uint8_t)(1 << bit % 8);
        TEST_ASSERT_NOT_EQUAL_INT(SSV_LINK_NO_REASON, ssv_timeline_check(file, length).reason);
        file[bit / 8] ^= (uint8_t)(1 << bit % 8);
    }
}

static void test_every_other_length_is_found(void) {
    const size_t length = encode();
    for (size_t other = 0; other <= sizeof file; other++) {
        if (other != length) TEST_ASSERT_EQUAL_INT(SSV_LINK_LENGTH, ssv_timeline_check(file, other).reason);
    }
}

static void set_f32(size_t at, float value) { memcpy(file + at, &value, sizeof value); }

static void set_int(size_t at, int bytes, int64_t value) {
    for (int i = 0; i < bytes; i++) file[at + (size_t)i] = (uint8_t)((uint64_t)value >> 8 * i);
}

// A change that the CRC knows of, and the reason and index that it must be refused with.
static const struct {
    const char* label;
    size_t at;
    int bytes; // 0: a float
    double value;
    ssv_link_reason_t reason;
    int32_t index;
} faults[] = {
    {"another magic", 0, 1, 'X', SSV_LINK_FORMAT, 0},
    {"another version", 4, 2, 2, SSV_LINK_FORMAT, 0},
    {"seven thrusters", 6, 1, 7, SSV_LINK_FORMAT, 0},
    {"three events", 7, 1, 3, SSV_LINK_EVENT, 3},
    {"no plan hash", 16, 8, 0, SSV_LINK_PLAN_HASH, 0},
    {"no epoch", 24, 8, 0, SSV_LINK_EPOCH, 0},
    {"negative epoch", 24, 8, -5, SSV_LINK_EPOCH, 0},
    {"never valid", 32, 4, 0, SSV_LINK_EXPIRY, 0},
    {"negative largest thrust", 40, 0, -1, SSV_LINK_FORCE, 0},
    {"largest thrust not a number", 40, 0, NAN, SSV_LINK_FORCE, 0},
    {"infinite largest thrust", 40, 0, INFINITY, SSV_LINK_FORCE, 0},
    {"start not a number", 48, 0, NAN, SSV_LINK_START_POSE, 0},
    {"start beyond any tank", 44, 0, 1e5, SSV_LINK_START_POSE, 0},
    {"attitude not unit", 56, 0, 1.001, SSV_LINK_START_POSE, 0},
    {"attitude not a number", 60, 0, NAN, SSV_LINK_START_POSE, 0},
    {"one segment more", 72, 2, 11, SSV_LINK_SEGMENTS, 11},
    {"65535 segments", 72, 2, 65535, SSV_LINK_SEGMENTS, 65535},
    {"reserved bytes in use", 74, 2, 1, SSV_LINK_FORMAT, 0},
    {"reserved bytes in use", 84, 4, 1, SSV_LINK_FORMAT, 0},
    {"event after the end", 76, 2, 11, SSV_LINK_EVENT, 0},
    {"event of no kind", 82, 1, 2, SSV_LINK_EVENT, 1},
    {"two mates", 82, 1, 0, SSV_LINK_EVENT, 1},
    {"dock before mate", 80, 2, 4, SSV_LINK_EVENT, 1},
    {"reserved byte of an event", 79, 1, 1, SSV_LINK_EVENT, 0},
    {"an event that is not counted", 7, 1, 1, SSV_LINK_EVENT, 1},
    {"another sum", 88, 8, 1, SSV_LINK_DURATION, 10},
    {"no duration", 96, 8, 0, SSV_LINK_DURATION, 0},
    {"negative duration", 96 + 56 * 3, 8, -1, SSV_LINK_DURATION, 3},
    {"duration that overflows", 96 + 56 * 9, 8, 9e18, SSV_LINK_DURATION, 9},
    {"thrust beyond the largest", 96 + 56 * 2 + 8, 0, 6.001, SSV_LINK_THRUST, 2},
    {"thrust not a number", 96 + 56 * 9 + 52, 0, NAN, SSV_LINK_THRUST, 9},
    {"infinite thrust", 96 + 56 * 5 + 32, 0, -INFINITY, SSV_LINK_THRUST, 5},
};

static void test_each_field_out_of_range_is_named_with_its_index_and_outputs_stay(void) {
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) {
        const size_t length = encode();
        if (faults[i].bytes == 0)
            set_f32(faults[i].at, (float)faults[i].value);
        else
            set_int(faults[i].at, faults[i].bytes, (int64_t)faults[i].value);
        mend_crc(length);
        memset(&back, 0x55, sizeof back);
        const ssv_timeline_t untouched = back;
        const ssv_timeline_fault_t fault = ssv_timeline_decode(file, length, &back, NULL);
        TEST_ASSERT_EQUAL_INT_MESSAGE(faults[i].reason, fault.reason, faults[i].label);
        TEST_ASSERT_EQUAL_INT32_MESSAGE(faults[i].index, fault.index, faults[i].label);
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&untouched, &back, sizeof back, faults[i].label);
    }
}

static void test_a_timeline_that_the_reader_would_refuse_is_not_written(void) {
    timeline.segment[3].u_end_N[5] = NAN;
    TEST_ASSERT_EQUAL_size_t(0, encode());
    setUp();
    timeline.segment[0].duration_ns = INT64_MIN;
    TEST_ASSERT_EQUAL_size_t(0, encode());
    setUp();
    timeline.num_segments = SSV_MAX_SEGMENTS + 1;
    TEST_ASSERT_EQUAL_size_t(0, encode());
    setUp();
    timeline.num_segments = -1;
    TEST_ASSERT_EQUAL_size_t(0, encode());
    setUp();
    timeline.num_events = 3;
    TEST_ASSERT_EQUAL_size_t(0, encode());
    setUp();
    timeline.event[1].segment = 70000;
    TEST_ASSERT_EQUAL_size_t(0, encode());
    setUp();
    TEST_ASSERT_EQUAL_size_t(0, ssv_timeline_encode(&timeline, &stamp, file, 96 + 56 * 10 - 1));
}

static void test_the_crc_is_that_of_zlib(void) {
    // 0xcbf43926 is the check value of CRC-32/ISO-HDLC: that of the nine characters 123456789.
    static const uint8_t digits[] = "123456789";
    TEST_ASSERT_EQUAL_HEX32(0xcbf43926, ~slow_crc(digits, 9, UINT32_MAX));
    const size_t length = encode();
    const uint32_t before =
        (uint32_t)file[12] | (uint32_t)file[13] << 8 | (uint32_t)file[14] << 16 | (uint32_t)file[15] << 24;
    TEST_ASSERT_EQUAL_HEX32(~slow_crc(file + 16, length - 16, UINT32_MAX), before);
}

static void test_every_reason_has_words_of_its_own(void) {
    for (int i = 0; i < SSV_LINK_NUM_REASONS; i++) {
        for (int k = 0; k < i; k++)
            TEST_ASSERT_NOT_EQUAL_INT(
                0, strcmp(ssv_link_reason_str((ssv_link_reason_t)i), ssv_link_reason_str((ssv_link_reason_t)k)));
        TEST_ASSERT_TRUE(strlen(ssv_link_reason_str((ssv_link_reason_t)i)) <= SSV_LINK_TEXT_MAX);
    }
    TEST_ASSERT_EQUAL_STRING("unknown reason", ssv_link_reason_str(SSV_LINK_NUM_REASONS));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_what_is_encoded_is_decoded_bit_for_bit_for_every_number_of_segments);
    RUN_TEST(test_every_flipped_bit_is_found);
    RUN_TEST(test_every_other_length_is_found);
    RUN_TEST(test_each_field_out_of_range_is_named_with_its_index_and_outputs_stay);
    RUN_TEST(test_a_timeline_that_the_reader_would_refuse_is_not_written);
    RUN_TEST(test_the_crc_is_that_of_zlib);
    RUN_TEST(test_every_reason_has_words_of_its_own);
    return UNITY_END();
}
