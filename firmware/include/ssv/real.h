/// The scalar of the planner, and every operation on it beyond + and -.
///
/// Sums and comparisons are plain C; products, quotients, roots and transcendental functions are calls, so that another
/// arithmetic can take the place of `double` here without a change to the physics. Write constants as REAL(0.5).
/// The planner's archive takes from libm only what this header names. Build with -ffp-contract=off: a fused product would
/// make the same source give different bits.
#ifndef SSV_REAL_H
#define SSV_REAL_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/// IEEE 754 binary64.
typedef double real_t;

/// A constant of the scalar's type.
#define REAL(x) ((real_t)(x))
#define REAL_PI REAL(3.14159265358979323846)

static inline real_t real_mul(real_t a, real_t b) { return a * b; }
static inline real_t real_div(real_t a, real_t b) { return a / b; }
static inline real_t real_sq(real_t a) { return a * a; }
static inline real_t real_abs(real_t a) { return fabs(a); }
static inline real_t real_min(real_t a, real_t b) { return a < b ? a : b; }
static inline real_t real_max(real_t a, real_t b) { return a > b ? a : b; }
static inline real_t real_sqrt(real_t a) { return sqrt(a); }
static inline real_t real_log1p(real_t a) { return log1p(a); }
static inline real_t real_expm1(real_t a) { return expm1(a); }
static inline real_t real_sin(real_t a) { return sin(a); }
static inline real_t real_cos(real_t a) { return cos(a); }
static inline real_t real_tan(real_t a) { return tan(a); }
static inline real_t real_atan2(real_t y, real_t x) { return atan2(y, x); }
static inline real_t real_from_int(int a) { return (real_t)a; }

/// The boundary: what comes from or goes to the outside as a double. Exact for this scalar.
static inline real_t real_from_double(double a) { return a; }
static inline double real_to_double(real_t a) { return a; }
static inline bool real_is_finite(real_t a) { return isfinite(a); }

/// The value's bits, for hashes; the two zeros give the same bits.
static inline uint64_t real_bits(real_t a) {
    const double d = a + 0.0;
    uint64_t bits = 0;
    memcpy(&bits, &d, sizeof bits);
    return bits;
}

#endif
