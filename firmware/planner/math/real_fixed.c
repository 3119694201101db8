// Q31.32 (ssv/real_fixed.h); nothing where another scalar is built. Inside the transcendental functions numbers have 62
// or 61 bits after the point ("q62", "q61").
#include "ssv/real.h"

#if defined SSV_REAL_FIXED
#include <stdatomic.h>

#define ONE_Q32 ((int64_t)1 << 32)
#define ONE_Q62 ((int64_t)1 << 62)
#define HALF_PI_Q62 UINT64_C(7244019458077122842)
#define PI_Q61 ((int64_t)HALF_PI_Q62)
#define TWO_OVER_PI_Q63 UINT64_C(5871781006564002453)
#define ATAN_HALF_Q61 INT64_C(1069098597953152948)
#define SQRT2_Q62 UINT64_C(6521908912666391106)
#define LN2_Q57 INT64_C(99893036290645747)
#define LN2_Q62 UINT64_C(3196577161300663915)
#define INV_LN2_Q24 INT64_C(24204406)

#define COUNT_OF(array) ((int)(sizeof(array) / sizeof(array)[0]))

_Static_assert(-1 >> 1 == -1, "right shifts keep the sign");

static atomic_uint_least32_t overflows;

uint32_t real_overflows(void) { return atomic_load_explicit(&overflows, memory_order_relaxed); }

static real_t overflow(bool negative) {
    atomic_fetch_add_explicit(&overflows, 1, memory_order_relaxed);
    return negative ? -REAL_MAX : REAL_MAX;
}

// ---- 64 x 64 -> 128 bits --------------------------------------------------------------------------------------------

typedef struct {
    uint64_t high, low;
} wide_t;

#if defined __SIZEOF_INT128__ && !defined SSV_REAL_PORTABLE
__extension__ typedef unsigned __int128 uint128_t;

static inline wide_t product(uint64_t a, uint64_t b) {
    const uint128_t p = (uint128_t)a * b;
    return (wide_t){(uint64_t)(p >> 64), (uint64_t)p};
}
#else
static inline wide_t product(uint64_t a, uint64_t b) {
    const uint32_t a0 = (uint32_t)a, a1 = (uint32_t)(a >> 32), b0 = (uint32_t)b, b1 = (uint32_t)(b >> 32);
    const uint64_t low = (uint64_t)a0 * b0;
    const uint64_t middle = (uint64_t)a1 * b0 + (low >> 32); // cannot carry
    const uint64_t other = (uint64_t)a0 * b1 + (uint32_t)middle;
    return (wide_t){(uint64_t)a1 * b1 + (middle >> 32) + (other >> 32), other << 32 | (uint32_t)low};
}
#endif

// Two's complement: a negative factor counts as itself plus 2^64.
static inline wide_t signed_product(int64_t a, int64_t b) {
    wide_t p = product((uint64_t)a, (uint64_t)b);
    p.high -= ((uint64_t)(a >> 63) & (uint64_t)b) + ((uint64_t)(b >> 63) & (uint64_t)a);
    return p;
}

static int64_t mul_q62(int64_t a, int64_t b) {
    const wide_t p = signed_product(a, b);
    return (int64_t)(p.high << 2 | p.low >> 62);
}

static uint64_t size_of(int64_t a) { return a < 0 ? 0 - (uint64_t)a : (uint64_t)a; }

static int64_t with_sign(bool negative, uint64_t size) { return negative ? -(int64_t)size : (int64_t)size; }

int64_t real_to_nano(real_t a) {
    const uint64_t size = size_of(a), whole = (size >> 32) * 1000000000;
    return with_sign(a < 0, whole + (((size & UINT32_MAX) * 1000000000 + (UINT64_C(1) << 31)) >> 32));
}

// ---- The four operations and the root -------------------------------------------------------------------------------

real_t real_mul(real_t a, real_t b) {
    const wide_t p = signed_product(a, b);
    // To the nearest, ties to even: just below one half, and a hair more if the last bit is odd.
    const uint64_t low = p.low + 0x7fffffff + (p.low >> 32 & 1);
    const uint64_t high = p.high + (low < p.low);
    if ((high + (UINT64_C(1) << 26)) >> 27 != 0) return overflow((a < 0) != (b < 0));
    return (int64_t)(high << 32 | low >> 32);
}

// 2^127 / d for d >= 2^63, too small by less than 2^-59 of it: a quotient of 16 bits, then Newton's steps.
static uint64_t reciprocal(uint64_t d) {
    const uint32_t d32 = (uint32_t)(d >> 32);
    uint32_t x32 = (UINT32_MAX / (d32 >> 16)) << 15; // 2^63 / d32
    const int64_t miss32 = (int64_t)((UINT64_C(1) << 63) - (uint64_t)x32 * d32);
    x32 += (uint32_t)((int64_t)x32 * (miss32 >> 31) >> 32);
    uint64_t x = (uint64_t)x32 << 32;
    int64_t miss = (int64_t)((UINT64_C(1) << 63) - product(d, x).high);
    x += (uint64_t)((int64_t)x32 * (miss >> 8) >> 23);
    miss = (int64_t)((UINT64_C(1) << 63) - product(d, x).high);
    x += (uint64_t)((int64_t)x32 * miss >> 31);
    return x - 8;
}

real_t real_div(real_t a, real_t b) {
    const bool negative = (a < 0) != (b < 0);
    const uint64_t n = size_of(a), d = size_of(b);
    if (n >> 26 >= d) return overflow(negative);
    const int shift = __builtin_clzll(d);
    const uint64_t n_shifted = shift >= 26 ? n << (shift - 26) : n >> (26 - shift);
    // Rounded down it is this or one more; the remainder tells.
    uint64_t q = product(n_shifted, reciprocal(d << shift)).high >> 5;
    uint64_t rest = (n << 32) - q * d;
    if (rest >= d) {
        q++;
        rest -= d;
    }
    const uint64_t to_next = d - rest;
    if (rest > to_next || (rest == to_next && (q & 1) != 0)) q++;
    return with_sign(negative, q);
}

// n / d for n <= d, d >= 2^61; q62, too small by less than 2^-58.
static int64_t ratio_q62(int64_t n, uint64_t d) {
    const int shift = __builtin_clzll(d);
    return with_sign(n < 0, product(size_of(n) << shift, reciprocal(d << shift)).high >> 1);
}

real_t real_sqrt(real_t a) {
    if (a <= 0) {
        if (a < 0) (void)overflow(true);
        return 0;
    }
    const int half_shift = __builtin_clzll((uint64_t)a) / 2;
    const uint64_t x = (uint64_t)a << (2 * half_shift); // in [2^62, 2^64)
    const uint32_t x32 = (uint32_t)(x >> 32);
    // 1 / sqrt(x 2^-64) with 31 bits after the point, never too large: a straight line to within 9 %, then Newton's
    // steps.
    uint32_t y = (uint32_t)(0x111000000u - ((uint64_t)x32 * 0x9c000000u >> 32));
    for (int n = 0; n < 4; n++) {
        const uint32_t one = (uint32_t)(((uint64_t)y * y >> 32) * x32 >> 32); // 30 bits after the point
        y = (uint32_t)((uint64_t)y * (0xbffffffeu - one) >> 31);
    }
    // sqrt(x) from its upper half and one more step: the root rounded down, or one less; what is left of 2^32 a tells.
    const uint32_t root32 = (uint32_t)((uint64_t)x32 * y >> 31);
    const int64_t left = (int64_t)(x - (uint64_t)root32 * root32);
    const int64_t root_q16 = ((int64_t)root32 << 16) + ((left >> 8) * (int64_t)y >> 40);
    const int64_t root = root_q16 >> half_shift;
    const int64_t rest = (int64_t)(((uint64_t)a << 32) - (uint64_t)root * (uint64_t)root);
    return rest > root ? root + 1 : root;
}

real_t real_scale(real_t a, int n) {
    if (n <= 0) return n < -62 ? 0 : (a + (((int64_t)1 << -n) >> 1)) >> -n;
    if (n >= 58 ? a != 0 : size_of(a) >> (58 - n) != 0) return overflow(a < 0);
    return a * ((int64_t)1 << n);
}

int real_exponent(real_t a) { return a == 0 ? 0 : 32 - __builtin_clzll(size_of(a)); }

// ---- Transcendental functions ---------------------------------------------------------------------------------------

// c[0] + c[1] w + c[2] w^2 + ...
static int64_t polynomial_q62(const int64_t* c, int num, int64_t w) {
    int64_t sum = c[num - 1];
    for (int k = num - 2; k >= 0; k--) sum = c[k] + mul_q62(sum, w);
    return sum;
}

// log m for m = 2^e f, f in [sqrt(1/2), sqrt(2)]: e log 2 + 2 atanh((f - 1) / (f + 1)).
real_t real_log1p(real_t a) {
    static const int64_t atanh_over[] = {ONE_Q62,     ONE_Q62 / 3,  ONE_Q62 / 5, ONE_Q62 / 7,
                                         ONE_Q62 / 9, ONE_Q62 / 11, ONE_Q62 / 13};
    if (a <= -ONE_Q32) return overflow(true);
    const uint64_t m = (uint64_t)a + (uint64_t)ONE_Q32;
    const int shift = __builtin_clzll(m);
    int e = 31 - shift;
    uint64_t f = m << shift >> 1;
    if (f > SQRT2_Q62) {
        f >>= 1;
        e++;
    }
    const int64_t z = ratio_q62((int64_t)f - ONE_Q62, f + (uint64_t)ONE_Q62);
    const int64_t half = mul_q62(z, polynomial_q62(atanh_over, COUNT_OF(atanh_over), mul_q62(z, z)));
    return (e * LN2_Q57 + (half >> 4) + ((int64_t)1 << 24)) >> 25;
}

// 2^k e^r - 1 with |r| <= log(2) / 2.
real_t real_expm1(real_t a) {
    static const int64_t exp_r[] = {ONE_Q62,
                                    ONE_Q62,
                                    ONE_Q62 / 2,
                                    ONE_Q62 / 6,
                                    ONE_Q62 / 24,
                                    ONE_Q62 / 120,
                                    ONE_Q62 / 720,
                                    ONE_Q62 / 5040,
                                    ONE_Q62 / 40320,
                                    ONE_Q62 / 362880,
                                    ONE_Q62 / 3628800,
                                    ONE_Q62 / 39916800,
                                    ONE_Q62 / 479001600,
                                    ONE_Q62 / 6227020800,
                                    ONE_Q62 / 87178291200};
    if (a >= 19 * ONE_Q32) return overflow(false);
    if (a < -23 * ONE_Q32) return -ONE_Q32;
    const int64_t k = (a * INV_LN2_Q24 + ((int64_t)1 << 55)) >> 56;
    const int64_t r = (int64_t)(((uint64_t)a << 30) - (uint64_t)k * LN2_Q62);
    const int shift = 30 - (int)k;
    const uint64_t e = (uint64_t)polynomial_q62(exp_r, COUNT_OF(exp_r), r);
    const int64_t rounded = shift > 63 ? 0 : (int64_t)((e + (UINT64_C(1) << (shift - 1))) >> shift);
    return rounded > REAL_MAX ? overflow(false) : rounded - ONE_Q32;
}

// Sine and cosine of the size of an angle less the nearest multiple of pi / 2.
typedef struct {
    unsigned quarter;
    int64_t sine, cosine; // q62
} turn_t;

static turn_t turn(real_t a) {
    static const int64_t sine_over[] = {ONE_Q62,          -ONE_Q62 / 6,        ONE_Q62 / 120,       -ONE_Q62 / 5040,
                                        ONE_Q62 / 362880, -ONE_Q62 / 39916800, ONE_Q62 / 6227020800};
    static const int64_t cosine[] = {ONE_Q62,         -ONE_Q62 / 2,       ONE_Q62 / 24,       -ONE_Q62 / 720,
                                     ONE_Q62 / 40320, -ONE_Q62 / 3628800, ONE_Q62 / 479001600};
    const uint64_t size = size_of(a), k = (product(size, TWO_OVER_PI_Q63).high + (UINT64_C(1) << 30)) >> 31;
    const int64_t r = (int64_t)((size << 30) - k * HALF_PI_Q62);
    const int64_t w = mul_q62(r, r);
    return (turn_t){(unsigned)k & 3, mul_q62(r, polynomial_q62(sine_over, COUNT_OF(sine_over), w)),
                    polynomial_q62(cosine, COUNT_OF(cosine), w)};
}

static real_t real_of_q62(int64_t a) { return (a + ((int64_t)1 << 29)) >> 30; }

real_t real_sin(real_t a) {
    const turn_t t = turn(a);
    const real_t size = real_of_q62((t.quarter & 1) != 0 ? t.cosine : t.sine);
    return (a < 0) != ((t.quarter & 2) != 0) ? -size : size;
}

real_t real_cos(real_t a) {
    const turn_t t = turn(a);
    const real_t size = real_of_q62((t.quarter & 1) != 0 ? t.sine : t.cosine);
    return t.quarter == 1 || t.quarter == 2 ? -size : size;
}

real_t real_tan(real_t a) {
    const turn_t t = turn(a);
    const real_t size = (t.quarter & 1) != 0 ? real_div(-t.cosine, t.sine) : real_div(t.sine, t.cosine);
    return a < 0 ? -size : size;
}

// atan(n / d) for 0 <= n <= d: from the nearest of 0, 1/2 and 1 by the tangent of a difference, (t - c) / (1 + c t).
real_t real_atan2(real_t y, real_t x) {
    static const int64_t atan_over[] = {ONE_Q62,     -ONE_Q62 / 3,  ONE_Q62 / 5,  -ONE_Q62 / 7,
                                        ONE_Q62 / 9, -ONE_Q62 / 11, ONE_Q62 / 13, -ONE_Q62 / 15};
    uint64_t n = size_of(y), d = size_of(x);
    const bool steep = n > d;
    if (steep) {
        n = d;
        d = size_of(y);
    }
    if (d == 0) return 0;
    const int shift = __builtin_clzll(d);
    n = n << shift >> 2;
    d = d << shift >> 2;                  // in [2^61, 2^62)
    int64_t part = (int64_t)n, angle = 0; // q61
    uint64_t whole = d;
    if (4 * n >= 3 * d) {
        part = (int64_t)(n - d);
        whole = d + n;
        angle = PI_Q61 / 4;
    } else if (4 * n >= d) {
        part = (int64_t)(2 * n - d);
        whole = 2 * d + n;
        angle = ATAN_HALF_Q61;
    }
    const int64_t z = ratio_q62(part, whole);
    angle += mul_q62(z, polynomial_q62(atan_over, COUNT_OF(atan_over), mul_q62(z, z))) >> 1;
    if (steep) angle = PI_Q61 / 2 - angle;
    if (x < 0) angle = PI_Q61 - angle;
    const real_t rounded = (angle + ((int64_t)1 << 28)) >> 29;
    return y < 0 ? -rounded : rounded;
}
#endif
