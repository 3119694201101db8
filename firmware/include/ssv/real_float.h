/// The scalar as IEEE 754 binary32; the manual is ssv/real.h, which includes this.
#ifndef SSV_REAL_FLOAT_H
#define SSV_REAL_FLOAT_H

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#if FLT_EVAL_METHOD < 0 || FLT_EVAL_METHOD == 1 || FLT_EVAL_METHOD == 2
#error "Plans would depend on when this compiler rounds from more digits than a float has; on x86: -msse2 -mfpmath=sse"
#endif

typedef float real_t;

#define REAL_NAME "float"
#define SSV_NAME(name) name##_float
#define REAL(x) ((real_t)(x))
#define REAL_MAX FLT_MAX
#define REAL_EPSILON FLT_EPSILON
#define REAL_NOISE FLT_EPSILON
#define REAL_STEP REAL(0)

inline real_t real_mul(real_t a, real_t b) { return a * b; }
inline real_t real_div(real_t a, real_t b) { return a / b; }
inline real_t real_abs(real_t a) { return fabsf(a); }
inline real_t real_sqrt(real_t a) { return sqrtf(a); }
inline real_t real_log1p(real_t a) { return log1pf(a); }
inline real_t real_expm1(real_t a) { return expm1f(a); }
inline real_t real_sin(real_t a) { return sinf(a); }
inline real_t real_cos(real_t a) { return cosf(a); }
inline real_t real_tan(real_t a) { return tanf(a); }
inline real_t real_atan2(real_t y, real_t x) { return atan2f(y, x); }
inline real_t real_from_int(int a) { return (real_t)a; }
static inline real_t real_from_double(double a) { return (real_t)a; }
static inline double real_to_double(real_t a) { return (double)a; }
static inline float real_to_float(real_t a) { return a; }
inline int64_t real_to_nano(real_t a) { return (int64_t)((double)a * 1e9 + (a < 0 ? -0.5 : 0.5)); }
inline bool real_is_finite(real_t a) { return isfinite(a); }
inline real_t real_scale(real_t a, int n) { return n == 0 ? a : ldexpf(a, n); }
inline uint32_t real_overflows(void) { return 0; }

inline int real_exponent(real_t a) {
    (void)a;
    return 0;
}

inline uint64_t real_bits(real_t a) {
    const float f = a + 0.0f;
    uint32_t bits = 0;
    memcpy(&bits, &f, sizeof bits);
    return bits;
}

#endif
