/// The scalar as IEEE 754 binary64; the manual is ssv/real.h, which includes this.
#ifndef SSV_REAL_DOUBLE_H
#define SSV_REAL_DOUBLE_H

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#if FLT_EVAL_METHOD < 0 || FLT_EVAL_METHOD == 2
#error "Plans would depend on when this compiler rounds from more digits than a double has; on x86: -msse2 -mfpmath=sse"
#endif

typedef double real_t;

#define REAL_NAME "double"
#define SSV_NAME(name) name##_double
#define REAL(x) ((real_t)(x))
#define REAL_MAX DBL_MAX
#define REAL_EPSILON DBL_EPSILON
#define REAL_NOISE DBL_EPSILON
#define REAL_STEP REAL(0)

inline real_t real_mul(real_t a, real_t b) { return a * b; }
inline real_t real_div(real_t a, real_t b) { return a / b; }
inline real_t real_abs(real_t a) { return fabs(a); }
inline real_t real_sqrt(real_t a) { return sqrt(a); }
inline real_t real_log1p(real_t a) { return log1p(a); }
inline real_t real_expm1(real_t a) { return expm1(a); }
inline real_t real_sin(real_t a) { return sin(a); }
inline real_t real_cos(real_t a) { return cos(a); }
inline real_t real_tan(real_t a) { return tan(a); }
inline real_t real_atan2(real_t y, real_t x) { return atan2(y, x); }
inline real_t real_from_int(int a) { return (real_t)a; }
static inline real_t real_from_double(double a) { return a; }
static inline double real_to_double(real_t a) { return a; }
static inline float real_to_float(real_t a) { return (float)a; }
inline int64_t real_to_nano(real_t a) { return (int64_t)(a * 1e9 + (a < 0 ? -0.5 : 0.5)); }
inline bool real_is_finite(real_t a) { return isfinite(a); }
inline real_t real_scale(real_t a, int n) { return n == 0 ? a : ldexp(a, n); }
inline uint32_t real_overflows(void) { return 0; }

inline int real_exponent(real_t a) {
    (void)a;
    return 0;
}

inline uint64_t real_bits(real_t a) {
    const double d = a + 0.0;
    uint64_t bits = 0;
    memcpy(&bits, &d, sizeof bits);
    return bits;
}

#endif
