/// Little-endian numbers in byte strings, and the CRC-32 of files.
#ifndef SSV_LINK_BYTES_H
#define SSV_LINK_BYTES_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

static inline uint16_t ssv_get_u16(const uint8_t* bytes) { return (uint16_t)(bytes[0] | bytes[1] << 8); }

static inline uint32_t ssv_get_u32(const uint8_t* bytes) {
    return ssv_get_u16(bytes) | (uint32_t)ssv_get_u16(bytes + 2) << 16;
}

static inline uint64_t ssv_get_u64(const uint8_t* bytes) {
    return ssv_get_u32(bytes) | (uint64_t)ssv_get_u32(bytes + 4) << 32;
}

static inline int64_t ssv_get_i64(const uint8_t* bytes) { return (int64_t)ssv_get_u64(bytes); }

static inline float ssv_get_f32(const uint8_t* bytes) {
    const uint32_t bits = ssv_get_u32(bytes);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static inline void ssv_put_u16(uint8_t* bytes, uint16_t value) {
    bytes[0] = (uint8_t)value;
    bytes[1] = (uint8_t)(value >> 8);
}

static inline void ssv_put_u32(uint8_t* bytes, uint32_t value) {
    ssv_put_u16(bytes, (uint16_t)value);
    ssv_put_u16(bytes + 2, (uint16_t)(value >> 16));
}

static inline void ssv_put_u64(uint8_t* bytes, uint64_t value) {
    ssv_put_u32(bytes, (uint32_t)value);
    ssv_put_u32(bytes + 4, (uint32_t)(value >> 32));
}

static inline void ssv_put_f32(uint8_t* bytes, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    ssv_put_u32(bytes, bits);
}

/// Whether |value| <= limit; false for a NaN.
static inline int ssv_within(float value, float limit) { return value >= -limit && value <= limit; }

/// CRC-32 of zlib, gzip and IEEE 802.3. `before` is that of the bytes in front of these, 0 for none.
uint32_t ssv_crc32(uint32_t before, const uint8_t* bytes, size_t num_bytes);

/// The CRC-32 that MAVLink FTP asks for: the same polynomial, but neither begun nor ended with a complement.
uint32_t ssv_crc32_of_ftp(const uint8_t* bytes, size_t num_bytes);

#endif
