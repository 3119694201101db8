/// Arcs: stretches of a leg on which dv/dt = Q(v) = dv_dt[0] + dv_dt[1] v + dv_dt[2] v^2, and their time and distance
/// in closed form (DESIGN.md 5). Pure mathematics.
#ifndef SSV_ARC_H
#define SSV_ARC_H

#include <stdbool.h>

#include "ssv/real.h"

static inline real_t ssv_quadratic_at(const real_t c[3], real_t v) {
    return c[0] + real_mul(v, c[1] + real_mul(v, c[2]));
}

/// |c[0]| + |c[1]| v + |c[2]| v^2, against which a difference is judged to be rounding; v >= 0.
static inline real_t ssv_quadratic_size(const real_t c[3], real_t v) {
    return real_abs(c[0]) + real_mul(v, real_abs(c[1]) + real_mul(v, real_abs(c[2])));
}

/// Whether the quadratic has one sign at both speeds and no extremum in between. Then it has no root there, which
/// settles most cases without a square root.
static inline bool ssv_quadratic_keeps_sign(const real_t c[3], real_t from, real_t to) {
    const real_t a = ssv_quadratic_at(c, from), b = ssv_quadratic_at(c, to), twice = real_mul(REAL(2), c[2]);
    const bool one_sign = (a > REAL(0) && b > REAL(0)) || (a < REAL(0) && b < REAL(0));
    return one_sign && (c[1] + real_mul(twice, from) >= REAL(0)) == (c[1] + real_mul(twice, to) >= REAL(0));
}

/// Smaller and larger root of the quadratic, without cancellation. A root beyond `far` is given as `far`.
/// @return false if there is none; then root is untouched.
bool ssv_quadratic_roots(const real_t c[3], real_t far, real_t root[2]);

/// Smallest root in (from, to), else to.
real_t ssv_quadratic_root_after(const real_t c[3], real_t from, real_t to);

/// Integrals over time of 1, v and v^2 on an arc.
typedef struct {
    real_t time, distance, speed2; ///< [s], [m or rad], [m2/s or rad2/s]
} ssv_moments_t;

/// Integrals from one speed >= 0 to another, with Q not zero in between. Where Q leads from v_to to v_from they are
/// negative.
ssv_moments_t ssv_moments_between(const real_t dv_dt[3], real_t v_from, real_t v_to);

/// The same where the time between the two speeds is known, which close to a terminal speed is more exact.
ssv_moments_t ssv_moments_over(const real_t dv_dt[3], real_t v_from, real_t v_to, real_t time);

/// Speed a time t after (before, if t < 0) the speed was v_from.
real_t ssv_speed_after(const real_t dv_dt[3], real_t v_from, real_t t);

#endif
