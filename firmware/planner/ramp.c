#include "planner/ramp.h"

#include "planner/profile.h"

#define N SSV_NUM_THRUSTERS

// Two laws closer than this fraction of their size are one law: the rest is rounding.
#define SAME_LAW real_max(REAL(1e-11), 16 * REAL_NOISE)
// The next knot lies at least this fraction of the top speed beyond the last; a law found out of place in between is so by
// rounding only.
#define PROBE real_max(REAL(9.3132257461547852e-10), 16 * REAL_NOISE)
// Where two laws are equally good to the thrifty rules, which is better beyond is looked at so far beyond, as a fraction of that
// speed. Thrusters that would idle this close together idle together.
#define LOOK_AHEAD real_max(REAL(1e-6), 4096 * REAL_NOISE)
#define TOGETHER real_max(REAL(1e-6), 1024 * REAL_NOISE)

// ---- Which law holds at which speed -------------------------------------------------------------------------------------

// A law's number: thruster k at its limit forwards, idle, or at its limit backwards.
enum { BACKWARDS = 0, IDLE = 1, FORWARDS = 2, NUM_SIDES = 3 };

static int number(int k, int side) { return NUM_SIDES * k + side; }

static real_t law_c0(const ssv_laws_t* laws, int law) {
    const real_t limit = laws->limit[law / NUM_SIDES];
    return law % NUM_SIDES == IDLE ? REAL(0) : law % NUM_SIDES == FORWARDS ? limit : -limit;
}

void ssv_ramp_law(const ssv_laws_t* laws, int law, real_t c[3]) {
    c[0] = law_c0(laws, law);
    c[1] = laws->linear[law / NUM_SIDES];
    c[2] = laws->quadratic[law / NUM_SIDES];
}

void ssv_steering_up_to(ssv_steering_t* s, real_t top) {
    s->top = top;
    for (int k = 0; k < s->laws.num; k++) {
        s->size[k] = real_mul(top, real_abs(s->laws.linear[k]) + real_mul(top, real_abs(s->laws.quadratic[k])));
    }
}

// Law a less law b, as a quadratic. @return how much of it may be rounding.
static real_t difference(const ssv_steering_t* s, int a, int b, real_t d[3]) {
    const int i = a / NUM_SIDES, j = b / NUM_SIDES;
    const real_t a0 = law_c0(&s->laws, a), b0 = law_c0(&s->laws, b);
    d[0] = a0 - b0;
    d[1] = s->laws.linear[i] - s->laws.linear[j];
    d[2] = s->laws.quadratic[i] - s->laws.quadratic[j];
    return real_mul(SAME_LAW, real_abs(a0) + s->size[i] + real_abs(b0) + s->size[j]);
}

// Sign of a - b just beyond speed v: by value, then slope, then curvature, each only if it is more than rounding. Laws of
// thrusters that mirror each other often agree at v and part later.
static int compare(const ssv_steering_t* s, int a, int b, real_t v) {
    real_t d[3];
    const real_t noise = difference(s, a, b, d);
    real_t first = ssv_quadratic_at(d, v);
    if (real_abs(first) <= noise) {
        first = real_mul(s->top, d[1] + real_mul(REAL(2), real_mul(d[2], v)));
        if (real_abs(first) <= noise) first = real_mul(d[2], real_sq(s->top));
        if (real_abs(first) <= noise) return 0;
    }
    return first > REAL(0) ? 1 : -1;
}

// The tightest limit just beyond speed v.
static int limit_at(const ssv_steering_t* s, int side, real_t v) {
    int best = number(0, side);
    for (int k = 1; k < s->laws.num; k++) {
        const int order = compare(s, number(k, side), best, v);
        if (side == FORWARDS ? order < 0 : order > 0) best = number(k, side);
    }
    return best;
}

// Total height of the kinks at or below a law just beyond speed v.
static real_t kinks_below(const ssv_steering_t* s, int law, real_t v) {
    real_t sum = REAL(0);
    for (int k = 0; k < s->laws.num; k++) {
        if (number(k, IDLE) == law || compare(s, number(k, IDLE), law, v) <= 0) sum += s->laws.weight[k];
    }
    return sum;
}

// Least sum of |u_i|: that sum is convex and piecewise linear in a with a kink of height |accel_i| where u_i = 0, so the
// minimum is the weighted median of the kinks. Of equal ones the stronger braking is taken.
static int coast_at(const ssv_steering_t* s, real_t v) {
    const real_t half = real_mul(REAL(0.5) - SAME_LAW, s->laws.total);
    const int limit = limit_at(s, BACKWARDS, v);
    if (kinks_below(s, limit, v) >= half) return limit;
    int best = -1;
    for (int k = 0; k < s->laws.num; k++) {
        if (best >= 0 && compare(s, number(k, IDLE), best, v) >= 0) continue;
        if (kinks_below(s, number(k, IDLE), v) >= half) best = number(k, IDLE);
    }
    return best;
}

// Where the next law is judged, and where the search for the one after it begins.
static real_t just_beyond(const ssv_steering_t* s, ssv_policy_t policy, real_t v) {
    const real_t probe = real_mul(PROBE, s->top);
    return policy > SSV_COAST ? v + real_max(probe, real_mul(LOOK_AHEAD, v)) : v + probe;
}

// The law with the least (L(v, a) - lambda v) / |a|, which the optimality conditions ask for.
static int thrifty_at(const ssv_steering_t* s, int side, real_t v) {
    const ssv_laws_t* laws = &s->laws;
    const int limit = limit_at(s, side, v);
    const real_t at = real_min(just_beyond(s, SSV_THRIFTY_UP, v), s->top);
    real_t idle[N], c[3];
    ssv_laws_idle(laws, at, idle);
    ssv_ramp_law(laws, limit, c);
    const real_t rest = s->weight_time - real_mul(s->lambda, at) + real_mul(s->weight_impulse, ssv_passive_thrust(laws, at));
    const ssv_change_t change =
        ssv_cheapest_change(laws, idle, s->weight_impulse, rest, ssv_quadratic_at(c, at), s->coasts);
    return change.idle < 0 ? limit : number(change.idle, IDLE);
}

static int law_at(const ssv_steering_t* s, ssv_policy_t policy, real_t v) {
    switch (policy) {
        case SSV_COAST: return coast_at(s, v);
        case SSV_THRIFTY_UP: return thrifty_at(s, FORWARDS, v);
        case SSV_THRIFTY_SLOW: return thrifty_at(s, BACKWARDS, v);
        case SSV_SPEED_UP: return limit_at(s, FORWARDS, v);
        case SSV_BRAKE: break;
    }
    return limit_at(s, BACKWARDS, v);
}

// Along its law a thrifty rule changes where a line of L - lambda v, drawn on from the kink towards a = 0, meets zero there:
// then the next kink on that side is as good. With the signs of all thrusts held that line is quadratic in v.
static real_t next_balance(const ssv_steering_t* s, bool up, int law, real_t from, real_t to) {
    const ssv_laws_t* laws = &s->laws;
    // No thruster's sign changes in between; at the ends, where laws cross, several may idle at once.
    const real_t mid = real_mul(REAL(0.5), from + to);
    real_t idle[N], c[3], line[2][3];
    ssv_laws_idle(laws, mid, idle);
    ssv_ramp_law(laws, law, c);
    const real_t a = ssv_quadratic_at(c, mid);
    for (int side = 0; side < 2; side++) {
        line[side][0] = s->weight_time;
        line[side][1] = -s->lambda;
        line[side][2] = REAL(0);
    }
    for (int k = 0; k < laws->num; k++) {
        const real_t push = a - idle[k];
        const bool idles = real_abs(push) <= real_mul(TOGETHER, real_abs(a));
        // A thruster that idles along the law has one sign for less acceleration, the other for more.
        for (int side = 0; side < 2; side++) {
            const bool positive = idles ? (side == 1) == up : push > REAL(0);
            const real_t weight = real_mul(s->weight_impulse, positive ? laws->weight[k] : -laws->weight[k]);
            line[side][1] -= real_mul(weight, laws->linear[k]);
            line[side][2] -= real_mul(weight, laws->quadratic[k]);
        }
    }
    for (int k = 0; k < laws->num_passive; k++) {
        const bool positive = laws->passive_linear[k] + real_mul(laws->passive_quadratic[k], mid) > REAL(0);
        const real_t weight = positive ? s->weight_impulse : -s->weight_impulse;
        for (int side = 0; side < 2; side++) {
            line[side][1] += real_mul(weight, laws->passive_linear[k]);
            line[side][2] += real_mul(weight, laws->passive_quadratic[k]);
        }
    }
    return ssv_quadratic_root_after(line[1], from, ssv_quadratic_root_after(line[0], from, to));
}

// First speed in (from, to) at which another law may take over from this one.
static real_t next_crossing(const ssv_steering_t* s, ssv_policy_t policy, int law, real_t from, real_t to) {
    const bool up = policy == SSV_SPEED_UP || policy == SSV_THRIFTY_UP, thrifty = policy > SSV_COAST, kinks = policy >= SSV_COAST;
    real_t next = to, d[3];
    for (int k = 0; k < s->laws.num; k++) {
        const int rival[2] = {number(k, up ? FORWARDS : BACKWARDS), number(k, IDLE)};
        for (int n = 0; n < (kinks && (!thrifty || s->coasts[k]) ? 2 : 1); n++) {
            if (rival[n] == law) continue;
            const real_t noise = difference(s, rival[n], law, d);
            if (ssv_quadratic_size(d, to) > noise) next = ssv_quadratic_root_after(d, from, next);
        }
    }
    for (int k = 0; thrifty && k < s->laws.num_passive; k++) { // its thrust holds drag alone, and changes sign with it
        const real_t drag[3] = {REAL(0), s->laws.passive_linear[k], s->laws.passive_quadratic[k]};
        next = ssv_quadratic_root_after(drag, from, next);
    }
    return thrifty ? next_balance(s, up, law, from, next) : next;
}

// ---- Ramps: speed as a chain of laws, and the distance it takes ---------------------------------------------------------

bool ssv_ramp_extend(const ssv_steering_t* s, ssv_policy_t policy, real_t top, int room, ssv_ramp_table_t* ramp) {
    real_t v = ssv_ramp_top(ramp);
    for (int n = 0; n < SSV_MAX_PROFILE_PIECES && v < top; n++) {
        const int law = law_at(s, policy, v);
        const real_t next = next_crossing(s, policy, law, just_beyond(s, policy, v), top);
        if (ramp->num > 0 && ssv_ramp_stretch(ramp, ramp->num - 1)->law == law) {
            ssv_ramp_stretch(ramp, ramp->num - 1)->v_high = next;
        } else if (ramp->num == room) {
            return false;
        } else {
            ssv_stretch_t* stretch = ssv_ramp_stretch(ramp, ramp->num++);
            stretch->law = law;
            stretch->v_low = v;
            stretch->v_high = next;
        }
        v = next;
    }
    return v >= top;
}

void ssv_ramp_keep_slowing(const ssv_laws_t* laws, ssv_ramp_table_t* ramp) {
    for (int k = 0; k < ramp->num; k++) {
        const ssv_stretch_t* stretch = ssv_ramp_stretch(ramp, k);
        real_t c[3];
        ssv_ramp_law(laws, stretch->law, c);
        const bool slows = ssv_quadratic_at(c, stretch->v_low) < REAL(0) && ssv_quadratic_at(c, stretch->v_high) < REAL(0) &&
                           ssv_quadratic_root_after(c, stretch->v_low, stretch->v_high) >= stretch->v_high;
        if (!slows) ramp->num = k;
    }
}

ssv_moments_t ssv_ramp_integrals(const real_t law[3], real_t v_low, real_t v_high) {
    const ssv_moments_t m = ssv_law_integrals(law, v_low, v_high);
    return (ssv_moments_t){real_abs(m.time), real_abs(m.distance), real_abs(m.speed2)};
}

void ssv_ramp_measure(const ssv_laws_t* laws, ssv_ramp_table_t* ramp) {
    real_t c[3];
    for (int k = 0; k < ramp->num; k++) {
        ssv_stretch_t* stretch = ssv_ramp_stretch(ramp, k);
        ssv_ramp_law(laws, stretch->law, c);
        stretch->m = ssv_ramp_integrals(c, stretch->v_low, stretch->v_high);
    }
}

real_t ssv_ramp_reach(const ssv_laws_t* laws, ssv_ramp_table_t* ramp, real_t v, real_t* acceleration) {
    real_t reach = REAL(0), c[3];
    int k = 0;
    for (; k + 1 < ramp->num && ssv_ramp_stretch(ramp, k)->v_high < v; k++) reach += ssv_ramp_stretch(ramp, k)->m.distance;
    const ssv_stretch_t* stretch = ssv_ramp_stretch(ramp, k);
    ssv_ramp_law(laws, stretch->law, c);
    *acceleration = real_abs(ssv_quadratic_at(c, v));
    ramp->last = k;
    ramp->cut = *stretch;
    if (v != stretch->v_high) {
        ramp->cut.v_high = v;
        ramp->cut.m = ssv_ramp_integrals(c, stretch->v_low, v);
    }
    return reach + ramp->cut.m.distance;
}
