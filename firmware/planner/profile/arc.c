// Integrals of an arc. Each closed form cancels somewhere, so they are chosen by conditioning (DESIGN.md 5).
#include "planner/profile/arc.h"

#include "planner/math/assert.h"
#include "planner/math/gauss.h"
#include "planner/profile/tolerance.h"

// A quadratic as the closed forms need it: times 2^n, so that neither its discriminant overflows nor small coefficients
// lose their digits.
typedef struct {
    real_t c[3], disc;
    real_t root; // of the discriminant's size
    int n;
} scaled_t;

static scaled_t scale(const real_t c[3]) {
    scaled_t s;
    s.n = real_exponent(COEFFICIENT_MAX) -
          real_exponent(real_max(real_abs(c[0]), real_max(real_abs(c[1]), real_abs(c[2]))));
    for (int k = 0; k < 3; k++) s.c[k] = real_scale(c[k], s.n);
    s.disc = real_sq(s.c[1]) - real_mul(REAL(4), real_mul(s.c[0], s.c[2]));
    s.root = real_sqrt(real_abs(s.disc));
    return s;
}

// a / b, or far if that is larger in size.
static real_t div_up_to(real_t a, real_t b, real_t far) {
    if (b == REAL(0)) return far;
    if (a != REAL(0) && real_exponent(a) - real_exponent(b) > real_exponent(far)) return far;
    const real_t ratio = real_div(a, b);
    return real_abs(ratio) < far ? ratio : far;
}

static bool roots_of(const scaled_t* s, real_t far, real_t root[2]) {
    const real_t* c = s->c;
    if (s->disc < REAL(0)) return false;
    const real_t q = real_mul(REAL(-0.5), c[1] + (c[1] < REAL(0) ? -s->root : s->root));
    if (q == REAL(0)) {
        if (c[2] == REAL(0)) return false;
        root[0] = root[1] = REAL(0);
        return true;
    }
    const real_t a = div_up_to(c[0], q, far), b = div_up_to(q, c[2], far);
    root[0] = real_min(a, b);
    root[1] = real_max(a, b);
    return true;
}

bool ssv_quadratic_roots(const real_t c[3], real_t far, real_t root[2]) {
    const scaled_t s = scale(c);
    return roots_of(&s, far, root);
}

real_t ssv_quadratic_root_after(const real_t c[3], real_t from, real_t to) {
    SSV_ASSERT(!(from < REAL(0)));
    if (ssv_quadratic_keeps_sign(c, from, to)) return to;
    real_t root[2];
    if (!ssv_quadratic_roots(c, real_mul(REAL(2), to), root)) return to;
    if (root[0] > from && root[0] < to) return root[0];
    if (root[1] > from && root[1] < to) return root[1];
    return to;
}

static bool hardly_changes(const real_t dv_dt[3], real_t v_from, real_t v_to) {
    const real_t a = real_abs(ssv_quadratic_at(dv_dt, v_from)), b = real_abs(ssv_quadratic_at(dv_dt, v_to));
    const real_t m = real_abs(ssv_quadratic_at(dv_dt, real_mul(REAL(0.5), v_from + v_to)));
    return real_max(a, real_max(b, m)) < real_mul(QUADRATURE_RATIO, real_min(a, real_min(b, m)));
}

static ssv_moments_t moments_by_quadrature(const real_t dv_dt[3], real_t v_from, real_t v_to) {
    ssv_moments_t m = {REAL(0), REAL(0), REAL(0)};
    const real_t mid = real_mul(REAL(0.5), v_from + v_to), half = real_mul(REAL(0.5), v_to - v_from);
    for (int k = 0; k < GAUSS_8_POINTS; k++) {
        const real_t v = mid + real_mul(half, gauss_8[k].node);
        const real_t dt = real_div(real_mul(gauss_8[k].weight, half), ssv_quadratic_at(dv_dt, v));
        m.time += dt;
        m.distance += real_mul(v, dt);
        m.speed2 += real_mul(real_sq(v), dt);
    }
    return m;
}

// Time from dv/dt = Q(v): with tau = dv / (2 Q_a + Q_a' dv) and d the discriminant, t = 2 atanh(sqrt(d) tau) / sqrt(d),
// or the arc tangent where d < 0. No case of it cancels: 1 - d tau^2 = 4 Q_a Q_b / (2 Q_a + Q_a' dv)^2 exactly.
static real_t time_between(const scaled_t* s, real_t v_from, real_t v_to) {
    const real_t* dv_dt = s->c;
    const real_t dv = v_to - v_from;
    const real_t Q_a = ssv_quadratic_at(dv_dt, v_from), Q_b = ssv_quadratic_at(dv_dt, v_to);
    const real_t den = real_mul(REAL(2), Q_a) + real_mul(dv_dt[1] + real_mul(REAL(2), real_mul(dv_dt[2], v_from)), dv);
    if (s->disc < REAL(0)) {
        const real_t sign = Q_a < REAL(0) ? REAL(-1) : REAL(1);
        const real_t angle = real_atan2(real_mul(sign, real_mul(s->root, dv)), real_mul(sign, den));
        return real_scale(real_div(real_mul(REAL(2), angle), s->root), s->n);
    }
    const real_t x = real_abs(real_div(real_mul(s->root, dv), den));
    if (x < LINEAR_ARGUMENT) return real_scale(real_div(real_mul(REAL(2), dv), den), s->n);
    const real_t one_minus_x2 = real_mul(real_mul(REAL(4), real_div(Q_a, den)), real_div(Q_b, den));
    if (one_minus_x2 <= REAL(0)) return ENDLESS_S; // dv/dt is zero at one end, which is only approached
    // 2 atanh x = log1p(2 x (1 + x) / (1 - x^2))
    const real_t t = real_div(real_log1p(real_div(real_mul(real_mul(REAL(2), x), REAL(1) + x), one_minus_x2)), s->root);
    // Negative where dv/dt leads the other way: a ramp that slows is measured from rest, against time.
    return real_scale((dv < REAL(0)) == (Q_a < REAL(0)) ? t : -t, s->n);
}

// log(1 + y) / y = 1 - y/2 + y^2/3 - ..., and its first moment 1/2 - y/3 + y^2/4 - ..., both smooth at y = 0.
static real_t log1p_over(real_t y, real_t* moment) {
    static const real_t over[] = {REAL(0.5),     REAL(1.0 / 3), REAL(0.25),    REAL(0.2), REAL(1.0 / 6),
                                  REAL(1.0 / 7), REAL(0.125),   REAL(1.0 / 9), REAL(0.1)};
    if (real_abs(y) > LOG_SERIES_ARGUMENT) {
        const real_t one = real_div(real_log1p(y), y);
        *moment = real_div(REAL(1) - one, y);
        return one;
    }
    real_t sum = REAL(0);
    for (int k = (int)(sizeof over / sizeof *over) - 1; k >= 0; k--) sum = over[k] - real_mul(y, sum);
    *moment = sum;
    return REAL(1) - real_mul(y, sum);
}

static ssv_moments_t moments(const scaled_t* s, const real_t dv_dt[3], real_t v_from, real_t v_to, real_t time) {
    const real_t dv = v_to - v_from;
    ssv_moments_t m = {time, REAL(0), REAL(0)};
    real_t root[2];
    if (roots_of(s, real_mul(FAR_ROOT, real_max(v_from, v_to)), root)) {
        // Q = (v - v_t) q(v) with v_t the nearer root: v / Q = v_t / Q + 1 / q and v^2 / Q = v_t^2 / Q + (v + v_t) / q.
        const real_t mid = real_mul(REAL(0.5), v_from + v_to);
        const real_t v_t = real_abs(root[0] - mid) < real_abs(root[1] - mid) ? root[0] : root[1];
        const real_t q = dv_dt[1] + real_mul(dv_dt[2], v_from + v_t), x = real_div(dv, q);
        real_t moment;
        const real_t one = real_mul(x, log1p_over(real_mul(dv_dt[2], x), &moment));
        m.distance = real_mul(v_t, time) + one;
        m.speed2 = real_mul(real_sq(v_t), time) + real_mul(v_from + v_t, one) + real_mul(real_mul(dv, x), moment);
        return m;
    }
    const real_t Q_a = ssv_quadratic_at(dv_dt, v_from);
    const real_t dQ = real_mul(dv, dv_dt[1] + real_mul(dv_dt[2], v_from + v_to));
    const real_t log_ratio = real_log1p(real_div(dQ, Q_a));
    m.distance = real_div(real_mul(REAL(0.5), log_ratio - real_mul(dv_dt[1], time)), dv_dt[2]);
    m.speed2 = real_div(dv - real_mul(dv_dt[0], time) - real_mul(dv_dt[1], m.distance), dv_dt[2]);
    return m;
}

ssv_moments_t ssv_moments_over(const real_t dv_dt[3], real_t v_from, real_t v_to, real_t time) {
    SSV_ASSERT(!(v_from < REAL(0)) && !(v_to < REAL(0)));
    real_t v = v_from, v2 = real_sq(v_from); // means over time
    if (v_from != v_to) {
        if (!hardly_changes(dv_dt, v_from, v_to)) {
            const scaled_t s = scale(dv_dt);
            return moments(&s, dv_dt, v_from, v_to, time);
        }
        // Close to a terminal speed the sums are inexact, but by the same factor: their ratios are good.
        const ssv_moments_t sum = moments_by_quadrature(dv_dt, v_from, v_to);
        if (sum.time != REAL(0)) {
            v = real_div(sum.distance, sum.time);
            v2 = real_div(sum.speed2, sum.time);
        }
    }
    return (ssv_moments_t){time, real_mul(time, v), real_mul(time, v2)};
}

ssv_moments_t ssv_moments_between(const real_t dv_dt[3], real_t v_from, real_t v_to) {
    SSV_ASSERT(!(v_from < REAL(0)) && !(v_to < REAL(0)));
    if (v_from == v_to) return (ssv_moments_t){REAL(0), REAL(0), REAL(0)};
    if (hardly_changes(dv_dt, v_from, v_to)) return moments_by_quadrature(dv_dt, v_from, v_to);
    const scaled_t s = scale(dv_dt);
    return moments(&s, dv_dt, v_from, v_to, time_between(&s, v_from, v_to));
}

// With tau = tanh(root t / 2) / root, or tan for d < 0, the speed is v + 2 Q tau / (1 - Q' tau).
real_t ssv_speed_after(const real_t dv_dt[3], real_t v_from, real_t time) {
    const scaled_t s = scale(dv_dt);
    const real_t t = real_scale(time, -s.n);
    const real_t Q = ssv_quadratic_at(s.c, v_from);
    const real_t slope = s.c[1] + real_mul(REAL(2), real_mul(s.c[2], v_from));
    const real_t x = real_mul(REAL(0.5), real_mul(s.root, real_abs(t)));
    real_t tau = real_mul(REAL(0.5), real_abs(t));
    if (x > LINEAR_ARGUMENT) {
        if (s.disc < REAL(0)) {
            tau = real_div(real_tan(x), s.root);
        } else {
            const real_t e = real_expm1(real_mul(REAL(-2), x));
            tau = real_div(-e, real_mul(REAL(2) + e, s.root));
        }
    }
    if (t < REAL(0)) tau = -tau;
    return v_from + real_div(real_mul(real_mul(REAL(2), Q), tau), REAL(1) - real_mul(slope, tau));
}
