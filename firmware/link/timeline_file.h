/// Where the numbers of a timeline file stand; little-endian, no padding.
///
/// header                                               | segment, one per segment, in order
///  0  u8[4]   "SSVT"                                    |  0  i64     duration_ns
///  4  u16     version, 1                                |  8  f32[6]  u_start_N
///  6  u8      thrusters, 6                              | 32  f32[6]  u_end_N
///  7  u8      events
///  8  u32     length of the file
/// 12  u32     CRC-32 (zlib) of all that follows
/// 16  u64     plan_hash, not 0
/// 24  i64     epoch_us
/// 32  u32     valid_for_ms
/// 36  u32     mass_configuration
/// 40  f32     u_max_N
/// 44  f32[3]  p_IS_m
/// 56  f32[4]  q_IS
/// 72  u16     segments
/// 74  u16     0
/// 76  2 events of u16 segment, u8 kind, u8 0; all 0 where there is none
/// 84  u32     0
/// 88  i64     sum of all durations
///
/// The CRC does not cover itself: a file that ends in its own CRC-32 has the same CRC-32 whatever its content, so the
/// check that file transfer makes over the whole would say nothing.
#ifndef SSV_LINK_TIMELINE_FILE_H
#define SSV_LINK_TIMELINE_FILE_H

enum {
    AT_VERSION = 4,
    AT_THRUSTERS = 6,
    AT_NUM_EVENTS = 7,
    AT_LENGTH = 8,
    AT_CRC = 12,
    AT_PLAN_HASH = 16,
    AT_EPOCH = 24,
    AT_VALID_FOR = 32,
    AT_MASS_CONFIGURATION = 36,
    AT_U_MAX = 40,
    AT_P_IS = 44,
    AT_Q_IS = 56,
    AT_NUM_SEGMENTS = 72,
    AT_EVENTS = 76,
    AT_DURATION = 88,
    AT_U_START = 8,
    AT_U_END = 32
};

#endif
