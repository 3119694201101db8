#include "planner/profile/ramp.h"

#define N SSV_NUM_THRUSTERS

// More than any ramp has stretches.
#define MAX_STEPS 48

// Two laws closer than this fraction of their size are one law: the rest is rounding.
#define SAME_LAW real_max(REAL(1e-11), 16 * REAL_NOISE)
// The next knot lies at least this fraction of the top speed beyond the last; a law found out of place in between is so
// by rounding only.
#define PROBE real_max(REAL(9.3132257461547852e-10), 16 * REAL_NOISE)
// The thrifty rules judge a law so far beyond the speed at which it takes over, as a fraction of that speed. Thrusters
// that would idle this close together idle together.
#define LOOK_AHEAD real_max(REAL(1e-6), 256 * REAL_NOISE)
#define TOGETHER real_max(REAL(1e-9), 64 * REAL_NOISE)

// ---- Which law holds at which speed
// -------------------------------------------------------------------------------------

// A law's number: thruster k at its limit forwards, idle, or at its limit backwards. A power of two is quick to divide
// by.
enum { BACKWARDS = 0, IDLE = 1, FORWARDS = 2, SIDES = 4 };

static int number(int k, int side) { return SIDES * k + side; }
static int thruster_of(int law) { return (int)((unsigned)law / SIDES); }
static int side_of(int law) { return (int)((unsigned)law % SIDES); }

static real_t law_c0(const ssv_laws_t* laws, int law) {
    const real_t limit = laws->limit[thruster_of(law)];
    return side_of(law) == IDLE ? REAL(0) : side_of(law) == FORWARDS ? limit : -limit;
}

void ssv_ramp_law(const ssv_laws_t* laws, int law, real_t c[3]) {
    c[0] = law_c0(laws, law);
    c[1] = laws->linear[thruster_of(law)];
    c[2] = laws->quadratic[thruster_of(law)];
}

void ssv_steering_up_to(ssv_steering_t* s, real_t top) {
    s->top = top;
    for (int k = 0; k < s->laws.num; k++) {
        s->size[k] = real_mul(top, real_abs(s->laws.linear[k]) + real_mul(top, real_abs(s->laws.quadratic[k])));
    }
}

// Law a less law b, as a quadratic. @return how much of it may be rounding.
static real_t difference(const ssv_steering_t* s, int a, int b, real_t d[3]) {
    const int i = thruster_of(a), j = thruster_of(b);
    const real_t a0 = law_c0(&s->laws, a), b0 = law_c0(&s->laws, b);
    d[0] = a0 - b0;
    d[1] = s->laws.linear[i] - s->laws.linear[j];
    d[2] = s->laws.quadratic[i] - s->laws.quadratic[j];
    return real_mul(SAME_LAW, real_abs(a0) + s->size[i] + real_abs(b0) + s->size[j]);
}

// Sign of a - b just beyond speed v: by value, then slope, then curvature, each only if it is more than rounding. Laws
// of thrusters that mirror each other often agree at v and part later.
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
    const int tighter = side == FORWARDS ? -1 : 1;
    int best = number(0, side);
    for (int k = 1; k < s->laws.num; k++) {
        if (compare(s, number(k, side), best, v) == tighter) best = number(k, side);
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

// Least sum of |u_i|: that sum is convex and piecewise linear in a with a kink of height |accel_i| where u_i = 0, so
// the minimum is the weighted median of the kinks. Of equal ones the stronger braking is taken.
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

// Which law the paper's rules ask for.
static int law_at(const ssv_steering_t* s, ssv_policy_t policy, real_t v) {
    return policy == SSV_COAST ? coast_at(s, v) : limit_at(s, policy == SSV_SPEED_UP ? FORWARDS : BACKWARDS, v);
}

// First speed in (from, to) at which a limit, or with `kinks` another thruster's idling, crosses this law, or a passive
// thruster changes its sign.
static real_t next_crossing(const ssv_steering_t* s, int side, bool kinks, int law, real_t from, real_t to) {
    real_t next = to, d[3];
    for (int k = 0; k < s->laws.num; k++) {
        const int rival[2] = {number(k, side), number(k, IDLE)};
        for (int n = 0; n < (kinks ? 2 : 1); n++) {
            if (rival[n] == law) continue;
            const real_t noise = difference(s, rival[n], law, d);
            // What was equal to compare() is equal here, or their rounding could hide that they cross.
            const real_t here = ssv_quadratic_at(d, from - real_mul(PROBE, s->top));
            if (!kinks && real_abs(here) <= noise) d[0] -= here;
            if (ssv_quadratic_keeps_sign(d, from, next)) continue;
            if (ssv_quadratic_size(d, to) > noise) next = ssv_quadratic_root_after(d, from, next);
        }
    }
    for (int k = 0; kinks && k < s->laws.num_passive; k++) {
        const real_t drag[3] = {REAL(0), s->laws.passive_linear[k], s->laws.passive_quadratic[k]};
        next = ssv_quadratic_root_after(drag, from, next);
    }
    return next;
}

// ---- The thrifty rules
// --------------------------------------------------------------------------------------------------

// The optimality conditions ask for the least C(a) / |a|, where C(a) = L(v, a) - lambda v is convex and piecewise
// linear in a: for the kink, or the limit, at which a line from the origin touches C. There the line through the next
// stretch inwards, towards a = 0, meets a = 0 at or above zero, and the one outwards at or below. Walking along the
// kinks finds it, and rounding cannot pick among kinks that are nearly equal.
enum { INWARDS = 0, OUTWARDS = 1 };

// Adds a thruster's part of a line: what it costs there less what it costs to hold the top speed, which lambda takes
// off. The difference is taken thruster by thruster, because of the whole all but the price of time cancels.
static void add_cost(const ssv_steering_t* s, real_t weight, real_t linear, real_t quadratic, bool positive,
                     real_t line[3]) {
    const real_t cost = real_mul(s->weight_impulse, weight), bend = real_mul(s->top, quadratic);
    const bool held = linear + bend < REAL(0);
    const real_t slope = positive == held ? bend : bend + real_mul(REAL(2), linear);
    line[1] += real_mul(held ? cost : -cost, slope);
    line[2] -= real_mul(positive ? cost : -cost, quadratic);
}

// Where these lines meet a = 0, over the speed; while no thruster's sign changes, at `mid` and around, a quadratic in
// it. The one outwards with its sign turned: a law holds where neither is below zero.
static void tangents(const ssv_steering_t* s, bool up, int law, real_t mid, real_t line[2][3]) {
    const ssv_laws_t* laws = &s->laws;
    real_t c[3];
    ssv_ramp_law(laws, law, c);
    const real_t a = ssv_quadratic_at(c, mid);
    for (int way = INWARDS; way <= OUTWARDS; way++) {
        line[way][0] = s->weight_time;
        line[way][1] = -real_div(s->weight_time, s->top);
        line[way][2] = REAL(0);
    }
    for (int k = 0; k < laws->num; k++) {
        const real_t push = a - real_mul(mid, laws->linear[k] + real_mul(mid, laws->quadratic[k]));
        const bool idles = real_abs(push) <= real_mul(TOGETHER, real_abs(a));
        // A thruster that idles along the law has one sign for less acceleration, the other for more.
        for (int way = INWARDS; way <= OUTWARDS; way++) {
            const bool positive = idles ? (way == OUTWARDS) == up : push > REAL(0);
            add_cost(s, laws->weight[k], laws->linear[k], laws->quadratic[k], positive, line[way]);
        }
    }
    for (int k = 0; k < laws->num_passive; k++) {
        const real_t linear = -laws->passive_linear[k], quadratic = -laws->passive_quadratic[k];
        const bool positive = linear + real_mul(quadratic, mid) < REAL(0);
        for (int way = INWARDS; way <= OUTWARDS; way++) add_cost(s, REAL(1), linear, quadratic, positive, line[way]);
    }
    for (int n = 0; n < 3; n++) line[OUTWARDS][n] = -line[OUTWARDS][n];
}

// A walk along the kinks: the law, and the one it came from, past which it goes at the same speed.
typedef struct {
    int law, left;
} walk_t;

// To the next law that way at a speed: a kink short of the limit, or the limit that holds from `at` on. @return false
// if there is none.
static bool step(const ssv_steering_t* s, int side, int way, real_t at, real_t v, walk_t* walk) {
    const ssv_laws_t* laws = &s->laws;
    const real_t sign = side == FORWARDS ? REAL(1) : REAL(-1);
    const int limit = limit_at(s, side, at);
    real_t c[3];
    ssv_ramp_law(laws, walk->law, c);
    const real_t here = real_mul(sign, ssv_quadratic_at(c, v)), apart = real_mul(TOGETHER, here);
    ssv_ramp_law(laws, limit, c);
    const real_t most = real_mul(sign, ssv_quadratic_at(c, v));
    int next = way == OUTWARDS ? limit : walk->law;
    real_t next_a = way == OUTWARDS ? most : REAL(0);
    for (int k = 0; k < laws->num; k++) {
        const real_t a = real_mul(sign, real_mul(v, laws->linear[k] + real_mul(v, laws->quadratic[k])));
        if (!s->coasts[k] || a <= REAL(0) || number(k, IDLE) == walk->left) continue;
        if (way == OUTWARDS ? a <= here + apart || a >= next_a : a >= here - apart || a <= next_a) continue;
        next = number(k, IDLE);
        next_a = a;
    }
    if (next == walk->law || next == walk->left) return false;
    *walk = (walk_t){next, walk->law};
    return true;
}

// Where in (at, to) a law's line falls below zero, where that law holds no longer, else to. A line that is there from
// the start, because there is no law to step to, comes back first.
static real_t leaves(const real_t line[3], real_t at, real_t to) {
    const real_t here = ssv_quadratic_at(line, at), root = ssv_quadratic_root_after(line, at, to);
    if (here < REAL(0)) return ssv_quadratic_root_after(line, root, to);
    // Rounding may put a root at the start a little before it.
    return root == to && here + ssv_quadratic_at(line, to) < REAL(0) ? at : root;
}

// From the law that held below v, or the limit (-1), to that which holds above; *next is the speed up to which it does,
// and *way where the walk goes on from there (-1: a crossing).
static int thrifty_law(const ssv_steering_t* s, int side, walk_t* walk, real_t v, real_t top, real_t* next, int* way) {
    const bool up = side == FORWARDS;
    const real_t at = real_min(v + real_max(real_mul(PROBE, s->top), real_mul(LOOK_AHEAD, v)), top);
    const int limit = limit_at(s, side, at);
    const bool beyond = walk->law >= 0 && compare(s, walk->law, limit, at) == (up ? 1 : -1);
    if (walk->law < 0 || side_of(walk->law) != IDLE || beyond) *walk = (walk_t){limit, -1};
    real_t line[2][3], to = top;
    for (int n = 0; n < 2 * SSV_NUM_THRUSTERS; n++) {
        to = next_crossing(s, side, true, walk->law, at, top);
        const real_t mid = real_mul(REAL(0.5), at + to);
        tangents(s, up, walk->law, mid, line);
        if (ssv_quadratic_at(line[INWARDS], at) < REAL(0) && step(s, side, INWARDS, at, mid, walk)) continue;
        if (side_of(walk->law) != IDLE) break;
        if (ssv_quadratic_at(line[OUTWARDS], at) < REAL(0) && step(s, side, OUTWARDS, at, mid, walk)) continue;
        break;
    }
    const real_t inwards = leaves(line[INWARDS], at, to);
    const real_t outwards = side_of(walk->law) == IDLE ? leaves(line[OUTWARDS], at, to) : to;
    *next = real_min(inwards, outwards);
    *way = *next == to ? -1 : inwards < outwards ? INWARDS : OUTWARDS;
    return walk->law;
}

// ---- Ramps: speed as a chain of laws, and the distance it takes
// ---------------------------------------------------------

bool ssv_ramp_extend(const ssv_steering_t* s, ssv_policy_t policy, real_t top, int room, ssv_ramp_table_t* ramp) {
    const int side = policy == SSV_SPEED_UP || policy == SSV_THRIFTY_UP ? FORWARDS : BACKWARDS;
    real_t v = ssv_ramp_top(ramp), next = v;
    walk_t walk = {-1, -1};
    for (int n = 0; n < MAX_STEPS && v < top; n++) {
        int law, way = -1;
        if (policy == SSV_THRIFTY_UP || policy == SSV_THRIFTY_SLOW) {
            law = thrifty_law(s, side, &walk, v, top, &next, &way);
        } else {
            law = law_at(s, policy, v);
            next = next_crossing(s, side, policy == SSV_COAST, law, v + real_mul(PROBE, s->top), top);
        }
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
        walk.left = -1;
        if (way >= 0) (void)step(s, side, way, v, v, &walk);
    }
    return v >= top;
}

void ssv_ramp_keep_slowing(const ssv_laws_t* laws, ssv_ramp_table_t* ramp) {
    for (int k = 0; k < ramp->num; k++) {
        const ssv_stretch_t* stretch = ssv_ramp_stretch(ramp, k);
        real_t c[3];
        ssv_ramp_law(laws, stretch->law, c);
        const bool slows = ssv_quadratic_at(c, stretch->v_low) < REAL(0) &&
                           ssv_quadratic_at(c, stretch->v_high) < REAL(0) &&
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

real_t ssv_ramp_acceleration(const ssv_laws_t* laws, const ssv_ramp_table_t* ramp, real_t v) {
    real_t c[3];
    int k = 0;
    if (ramp->num == 0) return REAL(0);
    while (k + 1 < ramp->num && ssv_ramp_stretch(ramp, k)->v_high < v) k++;
    ssv_ramp_law(laws, ssv_ramp_stretch(ramp, k)->law, c);
    return real_abs(ssv_quadratic_at(c, v));
}

real_t ssv_ramp_reach(const ssv_laws_t* laws, ssv_ramp_table_t* ramp, real_t v, real_t* acceleration) {
    real_t reach = REAL(0), c[3];
    int k = 0;
    if (ramp->num == 0) {
        ramp->last = -1;
        ramp->cut = (ssv_stretch_t){.law = SSV_NO_LAW};
        *acceleration = REAL(0);
        return REAL(0);
    }
    for (; k + 1 < ramp->num && ssv_ramp_stretch(ramp, k)->v_high < v; k++)
        reach += ssv_ramp_stretch(ramp, k)->m.distance;
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

bool ssv_ramp_idles(const ssv_ramp_table_t* ramp) { return ramp->last >= 0 && side_of(ramp->cut.law) == IDLE; }
