/// The scalar as a fixed-point number: Q31.32, a 64-bit integer that counts 2^-32 (one ulp here, 2.3e-10); the manual
/// is ssv/real.h, which includes this. No floating point in the planner's archive, the same bits from every compiler
/// and core.
///
/// Overflow is never silent. Every call gives at most REAL_MAX = 2^26 in size; a result that would be larger, or that
/// does not exist (a quotient by zero, a root or logarithm of a negative number), becomes +-REAL_MAX, or 0 for a root,
/// and counts in real_overflows(). The 5 bits above REAL_MAX guard plain + and -: no sum of up to 31 results of calls
/// can leave the 64 bits. The count is the archive's only state. It only grows and is never cleared, so that of two
/// planners side by side neither can hide the other's overflow: the worst that can happen is that both report one.
///
/// Largest error against the exact result, in ulp; the first three are correctly rounded, ties to even.
///   real_mul, real_div, real_sqrt   0.5
///   real_log1p, real_sin, real_cos, real_atan2   0.52
///   real_expm1   0.52 up to a result of 2^16, 1 above
///   real_tan     for |a| <= 8: 0.52 up to a result of 2^10 in size, 1 up to 2^13; more near the poles
/// The others hold for arguments up to REAL_MAX in size. Odd functions are exactly odd, cosine is exactly even.
#ifndef SSV_REAL_FIXED_H
#define SSV_REAL_FIXED_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

typedef int64_t real_t;

#define REAL_NAME "fixed"
#define SSV_NAME(name) name##_fixed
/// Rounded to the nearest; a constant that does not fit divides by zero, which compilers refuse.
#define REAL(x)                                                                                                        \
    ((real_t)((x) * 4294967296.0 + ((x) * 1.0 < 0 ? -0.5 : 0.5)) / ((x) * 1.0 < 67108864.0 && (x) * 1.0 > -67108864.0))
/// Largest result of a call.
#define REAL_MAX ((real_t)1 << 58)
#define REAL_EPSILON ((real_t)1)
#define REAL_NOISE ((real_t)1 << 8)
#define REAL_STEP ((real_t)1)

#ifdef __cplusplus
extern "C" {
#endif

real_t real_mul(real_t a, real_t b);
real_t real_div(real_t a, real_t b);
real_t real_sqrt(real_t a);
real_t real_scale(real_t a, int n);
int real_exponent(real_t a);
real_t real_log1p(real_t a);
real_t real_expm1(real_t a);
real_t real_sin(real_t a);
real_t real_cos(real_t a);
real_t real_tan(real_t a);
real_t real_atan2(real_t y, real_t x);
uint32_t real_overflows(void);
int64_t real_to_nano(real_t a);

#ifdef __cplusplus
}
#endif

inline real_t real_abs(real_t a) { return a < 0 ? -a : a; }
inline real_t real_from_int(int a) { return (real_t)a * ((real_t)1 << 32); }
inline uint64_t real_bits(real_t a) { return (uint64_t)a; }

/// Three values stand for what is no number: INT64_MIN for NaN, +-INT64_MAX for the infinities. They are for checks at
/// the boundary only; nothing else may calculate with them.
inline bool real_is_finite(real_t a) { return a > -INT64_MAX && a < INT64_MAX; }

/// To the nearest, ties away from zero; what is beyond REAL_MAX becomes +-REAL_MAX, without counting as an overflow.
static inline real_t real_from_double(double a) {
    if (!(a >= 0) && !(a < 0)) return INT64_MIN;
    if (!(a - a >= 0)) return a < 0 ? -INT64_MAX : INT64_MAX;
    const double ulps = (a < 0 ? -a : a) * 4294967296.0;
    real_t size = REAL_MAX;
    if (ulps < (double)REAL_MAX) {
        size = (real_t)ulps;
        if (ulps - (double)size >= 0.5) size++;
    }
    return a < 0 ? -size : size;
}

static inline double real_to_double(real_t a) {
    if (a == INT64_MIN) return __builtin_nan("");
    if (!real_is_finite(a)) return a < 0 ? -__builtin_inf() : __builtin_inf();
    return (double)a / 4294967296.0;
}

/// Puts the bits together without floating-point arithmetic; to the nearest, ties to even.
static inline float real_to_float(real_t a) {
    uint64_t size = a < 0 ? 0 - (uint64_t)a : (uint64_t)a;
    uint32_t bits = a < 0 ? UINT32_C(1) << 31 : 0;
    if (size != 0) {
        const int zeros = __builtin_clzll(size);
        size <<= zeros;
        const uint64_t odd = size >> 40 & 1, rest = size & ((UINT64_C(1) << 40) - 1);
        const uint32_t digits = (uint32_t)(size >> 40) + (rest + odd > UINT64_C(1) << 39);
        // The leading one of the 24 digits counts in the exponent, and so does a carry out of them.
        bits |= ((uint32_t)(157 - zeros) << 23) + digits;
    }
    float result;
    memcpy(&result, &bits, sizeof result);
    return result;
}

#endif
