/// The scalar of the planner, and every operation on it beyond + and -.
///
/// Sums, differences and comparisons are plain C; products, quotients, roots and transcendental functions are calls, so
/// that one physics runs in several arithmetics. CMake's SSV_REAL chooses one for everything that is built together:
///   double   real_double.h   IEEE 754 binary64, the default
///   float    real_float.h    IEEE 754 binary32
///   fixed    real_fixed.h    Q31.32 in 64-bit integers: no floating point, the same bits on every machine
/// Each gives the same names, and nothing else in the sources knows which one it is:
///   real_t, REAL_NAME         the type, and "double", "float" or "fixed"
///   SSV_NAME(name)            the name with the scalar behind it, for linkers (ssv/planner.h)
///   REAL(literal)             a constant, converted when compiled
///   real_mul real_div real_abs real_sqrt   correctly rounded
///   real_log1p real_expm1 real_sin real_cos real_tan real_atan2(y, x)
///   real_scale(a, n)          a 2^n
///   real_exponent(a)          the n for which 2^(n-1) <= |a| < 2^n, to scale numbers by before they lose digits or
///                             overflow. The IEEE scalars' own exponents do that: there it is always 0
///   REAL_MAX                  largest result
///   REAL_EPSILON, REAL_NOISE  rounding to reckon with in numbers of about 1: of one operation, and after some tens
///                             that numbers far from 1 took part in
///   REAL_STEP                 the least distance of two numbers, where that does not shrink with them: those smaller
///                             than some thousands of it have few digits. 0 in the IEEE scalars
///   real_from_int             exact for |a| < 2^24
///   real_from_double real_to_double real_is_finite
///                             the boundary: what comes from or goes to the outside. Rounds to the nearest; NaN and
///                             infinities pass, and are not finite
///   real_to_float             the nearest binary32, for the timeline (ssv/timeline.h); the number must be finite
///   real_to_nano              10^9 a, the nearest integer, likewise; |a| must not exceed 2^26
///   real_bits                 the value's bits, for hashes; both zeros give the same
///   real_overflows()          how many results did not fit so far: compare before and after
/// The IEEE scalars overflow to infinities, which real_is_finite finds; their real_overflows() is always 0.
/// Of libm the archive takes only what the scalar's header names. Build with -ffp-contract=off: a fused product would
/// make the same source give different bits.
#ifndef SSV_REAL_H
#define SSV_REAL_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

// Such a compiler may take it that no number is a NaN, and the checks of a scenario and of real_from_double are gone.
#if defined __FAST_MATH__ || (defined __FINITE_MATH_ONLY__ && __FINITE_MATH_ONLY__ > 0)
#error "The planner cannot be built with -ffast-math or -ffinite-math-only: NaNs would pass. Give -fno-fast-math here."
#endif

#if defined SSV_REAL_FIXED
#include "ssv/real_fixed.h"
#elif defined SSV_REAL_FLOAT
#include "ssv/real_float.h"
#else
#include "ssv/real_double.h"
#endif

#define REAL_PI REAL(3.14159265358979323846)

inline real_t real_sq(real_t a) { return real_mul(a, a); }
inline real_t real_min(real_t a, real_t b) { return a < b ? a : b; }
inline real_t real_max(real_t a, real_t b) { return a > b ? a : b; }

#endif
