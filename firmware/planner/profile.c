#include "planner/profile.h"

#include "planner/law.h"

#define N SSV_NUM_THRUSTERS
#define MAX_KNOTS SSV_MAX_PROFILE_PIECES
#define MAX_NEWTON 60
#define MAX_FALSI 60

// Terminal speed is only approached; cruise at this much less. The time lost is the same fraction of the cruise.
#define TERMINAL_MARGIN REAL(5.9604644775390625e-8)
// Two laws closer than this fraction of their size are one law: the rest is rounding.
#define SAME_LAW REAL(1e-11)
// Thrusters whose laws agree this closely are one to the rules.
#define SAME_THRUSTER REAL(1e-13)
// The next knot lies at least this fraction of the top speed beyond the last; a law found out of place in between is so by
// rounding only.
#define PROBE REAL(9.3132257461547852e-10)

// How closely two ramps without a cruise cover their leg, as a fraction of it.
#define PEAK_TOLERANCE REAL(1e-11)
// A short optimal leg's ramps cover the distance to within twice this fraction, cruising the rest: in J that is its square.
#define SHORT_BY REAL(1e-7)
// An estimated peak this close to the cruise is taken for the cruise; a peak found too low is left by a little more than asked.
#define NEARLY REAL(0.97)
#define BEYOND REAL(1.003)
// Faster than any vehicle [m/s or rad/s].
#define FASTEST REAL(1e4)
// Longer than any leg [m or rad].
#define HOLD_FOR_EVER REAL(1e6)
// A thruster whose drag costs less than this fraction of the cruise idles there for all that matters: a coast on it is no
// different from the cruise.
#define NEXT_TO_NOTHING REAL(1e-6)

real_t ssv_piece_speed(const ssv_piece_t* piece, real_t t_s) {
    if (piece->v_start == piece->v_end) return piece->v_start;
    const real_t v = ssv_law_speed(piece->law, piece->v_start, t_s);
    return real_max(real_min(piece->v_start, piece->v_end), real_min(real_max(piece->v_start, piece->v_end), v));
}

ssv_moments_t ssv_piece_moments(const ssv_piece_t* piece, real_t v_from, real_t v_to, real_t time_s) {
    return ssv_law_moments(piece->law, v_from, v_to, time_s);
}

void ssv_piece_thrust(const ssv_thrusts_t* thrusts, const ssv_piece_t* piece, int i, real_t c[3]) {
    const real_t A = thrusts->accel[i];
    c[0] = real_mul(A, piece->law[0]);
    c[1] = real_mul(A, piece->law[1]) + thrusts->linear[i];
    c[2] = real_mul(A, piece->law[2]) + thrusts->quadratic[i];
}

// ---- Which law holds at which speed -------------------------------------------------------------------------------------

typedef enum { SPEED_UP, BRAKE, COAST, THRIFTY_UP, THRIFTY_SLOW } policy_t;

typedef struct {
    real_t c[3];
    real_t noise; // differences from another law below the sum of both noises are rounding
} law_t;

// Laws that a leg's thrusters can be bound to: up[i] and brake[i] put thruster i at its limit, idle[i] gives it no thrust.
typedef struct {
    const ssv_thrusts_t* thrusts;
    real_t top;   // speeds go up to here
    real_t total; // sum of |accel|
    real_t weight_time, weight_impulse, lambda; // of the thrifty policies; lambda is the marginal cost of distance
    bool acts[N];     // false also for a thruster whose laws are those of an earlier one
    bool coasts[N];   // whether a coast on thruster i differs from a cruise, up to the top
    real_t weight[N]; // |accel| of all thrusters with these laws
    law_t up[N], brake[N], idle[N];
} laws_t;

static bool same(real_t a, real_t b) { return real_abs(a - b) <= real_mul(SAME_THRUSTER, real_abs(a) + real_abs(b)); }

static bool laws_init(const ssv_thrusts_t* thrusts, laws_t* laws) {
    real_t largest = REAL(0);
    for (int i = 0; i < N; i++) largest = real_max(largest, real_abs(thrusts->accel[i]));
    laws->thrusts = thrusts;
    laws->top = laws->total = REAL(0); // only values are compared until laws_up_to
    for (int i = 0; i < N; i++) {
        const real_t A = thrusts->accel[i];
        laws->acts[i] = real_abs(A) > real_mul(SAME_LAW, largest);
        if (!laws->acts[i]) continue;
        const real_t limit = real_div(thrusts->force_max_N, real_abs(A));
        laws->total += real_abs(A);
        const real_t c1 = -real_div(thrusts->linear[i], A), c2 = -real_div(thrusts->quadratic[i], A);
        laws->idle[i] = (law_t){{REAL(0), c1, c2}, REAL(0)};
        laws->up[i] = (law_t){{limit, c1, c2}, REAL(0)};
        laws->brake[i] = (law_t){{-limit, c1, c2}, REAL(0)};
        laws->weight[i] = real_abs(A);
        for (int j = 0; j < i && laws->acts[i]; j++) {
            const real_t* c = laws->up[j].c;
            if (!laws->acts[j] || !same(c[0], limit) || !same(c[1], c1) || !same(c[2], c2)) continue;
            laws->acts[i] = false;
            laws->weight[j] += real_abs(A);
        }
    }
    return largest > REAL(0);
}

// Sets the speed that the laws are looked at up to.
static void laws_up_to(laws_t* laws, real_t top) {
    laws->top = top;
    for (int i = 0; i < N; i++) {
        if (!laws->acts[i]) continue;
        law_t* const law[3] = {&laws->up[i], &laws->brake[i], &laws->idle[i]};
        for (int k = 0; k < 3; k++) law[k]->noise = real_mul(SAME_LAW, ssv_quadratic_size(law[k]->c, top));
    }
}

// Sign of a - b just beyond speed v: by value, then slope, then curvature, each only if it is more than rounding. Laws of
// thrusters that mirror each other often agree at v and part later.
static int compare(const laws_t* laws, const law_t* a, const law_t* b, real_t v) {
    const real_t noise = a->noise + b->noise;
    const real_t d[3] = {a->c[0] - b->c[0], a->c[1] - b->c[1], a->c[2] - b->c[2]};
    real_t first = ssv_quadratic_at(d, v);
    if (real_abs(first) <= noise) {
        first = real_mul(laws->top, d[1] + real_mul(REAL(2), real_mul(d[2], v)));
        if (real_abs(first) <= noise) first = real_mul(d[2], real_sq(laws->top));
        if (real_abs(first) <= noise) return 0;
    }
    return first > REAL(0) ? 1 : -1;
}

// The tightest limit just beyond speed v.
static const law_t* limit_at(const laws_t* laws, bool up, real_t v) {
    const law_t* best = NULL;
    for (int i = 0; i < N; i++) {
        if (!laws->acts[i]) continue;
        const law_t* law = up ? &laws->up[i] : &laws->brake[i];
        if (best == NULL || (up ? compare(laws, law, best, v) < 0 : compare(laws, law, best, v) > 0)) best = law;
    }
    return best;
}

// Total height of the kinks at or below a law just beyond speed v.
static real_t kinks_below(const laws_t* laws, const law_t* law, real_t v) {
    real_t sum = REAL(0);
    for (int i = 0; i < N; i++) {
        if (laws->acts[i] && compare(laws, &laws->idle[i], law, v) <= 0) sum += laws->weight[i];
    }
    return sum;
}

// Least sum of |u_i|: that sum is convex and piecewise linear in a with a kink of height |accel_i| where u_i = 0, so the
// minimum is the weighted median of the kinks. Of equal ones the stronger braking is taken.
static const law_t* coast_at(const laws_t* laws, real_t v) {
    const real_t half = real_mul(REAL(0.5) - SAME_LAW, laws->total);
    const law_t* best = limit_at(laws, false, v);
    if (kinks_below(laws, best, v) >= half) return best;
    best = NULL;
    for (int i = 0; i < N; i++) {
        if (!laws->acts[i] || kinks_below(laws, &laws->idle[i], v) < half) continue;
        if (best == NULL || compare(laws, &laws->idle[i], best, v) < 0) best = &laws->idle[i];
    }
    return best;
}

// Thrust of thruster i at speed v and acceleration a.
static real_t thrust(const ssv_thrusts_t* t, int i, real_t v, real_t a) {
    return real_mul(t->accel[i], a) + real_mul(v, t->linear[i] + real_mul(v, t->quadratic[i]));
}

// L(v, a) = W1 + W2 sum |u_i|, cost per second.
static real_t cost_rate(const laws_t* laws, real_t v, real_t a) {
    real_t sum = REAL(0);
    for (int i = 0; i < N; i++) sum += real_abs(thrust(laws->thrusts, i, v, a));
    return laws->weight_time + real_mul(laws->weight_impulse, sum);
}

// The law with the least (L(v, a) - lambda v) / |a|, which the optimality conditions ask for: that is convex over linear in a,
// so a limit or a kink where some thruster idles.
static const law_t* thrifty_at(const laws_t* laws, bool up, real_t v) {
    const law_t* limit = limit_at(laws, up, v);
    const law_t* best = limit;
    const real_t at = real_min(v + real_mul(PROBE, laws->top), laws->top), distance_value = real_mul(laws->lambda, at);
    const real_t limit_a = ssv_quadratic_at(limit->c, at);
    real_t best_cost = cost_rate(laws, at, limit_a) - distance_value, best_a = real_abs(limit_a);
    for (int i = 0; i < N; i++) {
        if (!laws->coasts[i]) continue;
        const real_t a = ssv_quadratic_at(laws->idle[i].c, at);
        if (up ? a <= REAL(0) || a >= limit_a : a >= REAL(0) || a <= limit_a) continue;
        const real_t cost = cost_rate(laws, at, a) - distance_value;
        if (real_mul(cost, best_a) >= real_mul(best_cost, real_abs(a))) continue;
        best = &laws->idle[i];
        best_cost = cost;
        best_a = real_abs(a);
    }
    return best;
}

static const law_t* law_at(const laws_t* laws, policy_t policy, real_t v) {
    switch (policy) {
        case COAST: return coast_at(laws, v);
        case THRIFTY_UP: return thrifty_at(laws, true, v);
        case THRIFTY_SLOW: return thrifty_at(laws, false, v);
        case SPEED_UP: return limit_at(laws, true, v);
        case BRAKE: break;
    }
    return limit_at(laws, false, v);
}

// Along its law a thrifty policy changes where a line of L - lambda v, drawn on from the kink towards a = 0, meets zero
// there: then the next kink on that side is as good. With the signs of all thrusts held that line is quadratic in v.
static real_t next_balance(const laws_t* laws, bool up, const law_t* law, real_t from, real_t to) {
    const ssv_thrusts_t* t = laws->thrusts;
    // No thruster's sign changes in between; at the ends, where laws cross, several may idle at once.
    const real_t mid = real_mul(REAL(0.5), from + to), a = ssv_quadratic_at(law->c, mid);
    real_t next = to;
    for (int side = -1; side <= 1; side += 2) {
        real_t line[3] = {laws->weight_time, -laws->lambda, REAL(0)};
        for (int i = 0; i < N; i++) {
            const real_t u = thrust(t, i, mid, a);
            // A thruster that idles along the law has one sign for less acceleration, the other for more.
            const real_t push = real_abs(real_mul(t->accel[i], a)); // what drag must cancel
            const bool idles = real_abs(u) <= real_mul(REAL(1e-9), push) &&
                               real_abs(t->accel[i]) > real_mul(SAME_LAW, laws->total);
            const bool positive = idles ? (t->accel[i] > REAL(0)) == ((side > 0) == up) : u > REAL(0);
            const real_t weight = positive ? laws->weight_impulse : -laws->weight_impulse;
            line[1] += real_mul(weight, t->linear[i]);
            line[2] += real_mul(weight, t->quadratic[i]);
        }
        next = ssv_quadratic_root_after(line, from, next);
    }
    return next;
}

// First speed in (from, to) at which another law may take over from this one.
static real_t next_crossing(const laws_t* laws, policy_t policy, const law_t* law, real_t from, real_t to) {
    const bool up = policy == SPEED_UP || policy == THRIFTY_UP, has_kinks = policy != SPEED_UP && policy != BRAKE;
    real_t next = to;
    for (int i = 0; i < N; i++) {
        if (!laws->acts[i]) { // its thrust holds drag alone, and changes sign with it
            const real_t drag[3] = {REAL(0), laws->thrusts->linear[i], laws->thrusts->quadratic[i]};
            if (has_kinks) next = ssv_quadratic_root_after(drag, from, next);
            continue;
        }
        const law_t* const rival[2] = {up ? &laws->up[i] : &laws->brake[i], &laws->idle[i]};
        for (int k = 0; k < (has_kinks && (policy == COAST || laws->coasts[i]) ? 2 : 1); k++) {
            const real_t diff[3] = {rival[k]->c[0] - law->c[0], rival[k]->c[1] - law->c[1], rival[k]->c[2] - law->c[2]};
            if (ssv_quadratic_size(diff, to) <= law->noise) continue;
            next = ssv_quadratic_root_after(diff, from, next);
        }
    }
    return has_kinks && policy != COAST ? next_balance(laws, up, law, from, next) : next;
}

// ---- Ramps: speed as a chain of laws, and the distance it takes ---------------------------------------------------------

// From rest to knot speeds: law[k] holds between v[k] and v[k + 1]; reach[k] is the distance from rest to v[k] (or back).
typedef struct {
    int num;
    real_t v[MAX_KNOTS + 1], reach[MAX_KNOTS + 1];
    const law_t* law[MAX_KNOTS];
} ramp_table_t;

// Extends the ramp to speed top under one policy.
static bool ramp_extend(const laws_t* laws, policy_t policy, real_t top, ramp_table_t* ramp) {
    const real_t probe = real_mul(PROBE, laws->top);
    real_t v = ramp->v[ramp->num];
    for (int n = 0; n < MAX_KNOTS && v < top; n++) {
        const law_t* law = law_at(laws, policy, v);
        const real_t next = next_crossing(laws, policy, law, v + probe, top);
        if (ramp->num > 0 && ramp->law[ramp->num - 1] == law) {
            ramp->num--;
        } else if (ramp->num == MAX_KNOTS) {
            return false;
        }
        const int k = ramp->num++;
        ramp->law[k] = law;
        ramp->v[k + 1] = next;
        v = next;
    }
    return v >= top;
}

static void ramp_measure(ramp_table_t* ramp) {
    ramp->reach[0] = REAL(0);
    for (int k = 0; k < ramp->num; k++) {
        ramp->reach[k + 1] = ramp->reach[k] + real_abs(ssv_law_integrals(ramp->law[k]->c, ramp->v[k], ramp->v[k + 1]).distance);
    }
}

// Distance from rest to v, and the acceleration there.
static real_t ramp_reach(const ramp_table_t* ramp, real_t v, real_t* acceleration) {
    int k = 0;
    while (k + 1 < ramp->num && ramp->v[k + 1] < v) k++;
    *acceleration = ssv_quadratic_at(ramp->law[k]->c, v);
    return ramp->reach[k] + real_abs(ssv_law_integrals(ramp->law[k]->c, ramp->v[k], v).distance);
}

// Largest speed that every thruster can hold: |linear v + quadratic v^2| <= force_max. Infinite without drag; then what the
// distance allows.
static real_t top_speed(const laws_t* laws, real_t distance) {
    const ssv_thrusts_t* t = laws->thrusts;
    const law_t* start = limit_at(laws, true, REAL(0));
    bool bounded = false;
    real_t top = REAL(0);
    for (int i = 0; i < N; i++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            const real_t c[3] = {real_mul(real_from_int(sign), t->force_max_N), t->linear[i], t->quadratic[i]};
            real_t root[2];
            if ((c[1] == REAL(0) && c[2] == REAL(0)) || !ssv_quadratic_roots(c, FASTEST, root)) continue;
            for (int k = 0; k < 2; k++) {
                if (root[k] > REAL(0) && (!bounded || root[k] < top)) {
                    top = root[k];
                    bounded = true;
                }
            }
        }
    }
    const real_t free_top = real_sqrt(real_mul(REAL(2), real_mul(start->c[0], distance)));
    if (!bounded) return free_top;
    return top - real_mul(TERMINAL_MARGIN, top);
}

// Where the least thrust stops slowing the body, no drag-only ramp starts: end the ramp below.
static void keep_slowing(ramp_table_t* ramp) {
    for (int k = 0; k < ramp->num; k++) {
        const bool slows = ssv_quadratic_at(ramp->law[k]->c, ramp->v[k]) < REAL(0) &&
                           ssv_quadratic_at(ramp->law[k]->c, ramp->v[k + 1]) < REAL(0) &&
                           ssv_quadratic_root_after(ramp->law[k]->c, ramp->v[k], ramp->v[k + 1]) >= ramp->v[k + 1];
        if (!slows) ramp->num = k;
    }
}

// ---- The profile --------------------------------------------------------------------------------------------------------

static real_t impulse(const ssv_thrusts_t* thrusts, const ssv_piece_t* piece) {
    real_t c[N][3], cut[2 * N + 2];
    const real_t low = real_min(piece->v_start, piece->v_end), high = real_max(piece->v_start, piece->v_end);
    int num = 0;
    cut[num++] = low;
    for (int i = 0; i < N; i++) {
        ssv_piece_thrust(thrusts, piece, i, c[i]);
        real_t root[2];
        if (low == high || ssv_quadratic_size(c[i], high) <= real_mul(SAME_LAW, thrusts->force_max_N)) continue;
        if (!ssv_quadratic_roots(c[i], real_mul(REAL(2), high), root)) continue;
        for (int k = 0; k < 2; k++) {
            if (root[k] > low && root[k] < high) cut[num++] = root[k];
        }
    }
    for (int i = 1; i < num; i++) {
        for (int k = i; k > 1 && cut[k] < cut[k - 1]; k--) {
            const real_t swap = cut[k];
            cut[k] = cut[k - 1];
            cut[k - 1] = swap;
        }
    }
    cut[num] = high;
    real_t sum = REAL(0);
    for (int k = 0; k < num; k++) {
        const ssv_moments_t m = low == high ? ssv_law_moments(piece->law, low, high, piece->duration_s)
                                            : ssv_law_integrals(piece->law, cut[k], cut[k + 1]);
        for (int i = 0; i < N; i++) {
            sum += real_abs(real_mul(c[i][0], m.time) + real_mul(c[i][1], m.distance) + real_mul(c[i][2], m.speed2));
        }
    }
    return sum;
}

static bool append(ssv_profile_t* profile, const ssv_thrusts_t* thrusts, const real_t law[3], real_t v_start, real_t v_end,
                   real_t hold_s) {
    if (profile->num_pieces == SSV_MAX_PROFILE_PIECES) return false;
    const ssv_moments_t m = v_start == v_end ? ssv_law_moments(law, v_start, v_end, hold_s) : ssv_law_integrals(law, v_start, v_end);
    const ssv_piece_t* before = &profile->piece[profile->num_pieces];
    real_t s = REAL(0);
    if (profile->num_pieces > 0) {
        before--;
        s = before->s + ssv_law_moments(before->law, before->v_start, before->v_end, before->duration_s).distance;
    }
    ssv_piece_t* piece = &profile->piece[profile->num_pieces++];
    *piece = (ssv_piece_t){profile->duration_s, m.time, s, v_start, v_end, {law[0], law[1], law[2]}};
    profile->duration_s += m.time;
    profile->impulse_Ns += impulse(thrusts, piece);
    return true;
}

// Speed at which speeding up must turn into slowing so that both take the distance, to within PEAK_TOLERANCE of it: safeguarded
// Newton, from where it would be without drag; the sum of the reaches is increasing in v.
static real_t peak_speed(const ramp_table_t* up, const ramp_table_t* slow, real_t distance, real_t top) {
    real_t low = REAL(0), high = top, a_up, a_slow;
    (void)ramp_reach(up, REAL(0), &a_up);
    (void)ramp_reach(slow, REAL(0), &a_slow);
    real_t v = REAL(0);
    for (int n = 0; n < MAX_NEWTON; n++) {
        const real_t excess = n == 0 ? -distance : ramp_reach(up, v, &a_up) + ramp_reach(slow, v, &a_slow) - distance;
        const real_t pace = real_div(REAL(1), real_abs(a_up)) + real_div(REAL(1), real_abs(a_slow));
        if (real_abs(excess) <= real_mul(PEAK_TOLERANCE, distance)) return v;
        *(excess > REAL(0) ? &high : &low) = v;
        const real_t newton = n == 0 ? real_sqrt(real_div(real_mul(REAL(2), distance), pace)) : v - real_div(excess, real_mul(v, pace));
        v = newton > low && newton < high ? newton : real_mul(REAL(0.5), low + high);
    }
    return low;
}

// What a rule decides: the two ramps, where they meet, and how far the body cruises there.
typedef struct {
    ramp_table_t up, slow;
    real_t peak, cruise;
} motion_t;

static void ramp_start(ramp_table_t* ramp) {
    ramp->num = 0;
    ramp->v[0] = REAL(0);
}

static ssv_outcome_t solve_paper(laws_t* laws, const ssv_rule_t* rule, real_t distance, real_t top, motion_t* m) {
    const real_t reverse_from = rule->ramp == SSV_DRAG_ONLY ? real_min(rule->cutoff, top) : top;
    laws_up_to(laws, top);
    ramp_start(&m->up);
    ramp_start(&m->slow);
    if (!ramp_extend(laws, BRAKE, reverse_from, &m->slow) || !ramp_extend(laws, COAST, top, &m->slow) ||
        !ramp_extend(laws, SPEED_UP, top, &m->up)) {
        return SSV_TOO_MANY_PIECES;
    }
    keep_slowing(&m->slow);
    if (m->slow.v[m->slow.num] < top && m->slow.v[m->slow.num] <= reverse_from) return SSV_NO_AUTHORITY;
    m->peak = real_min(top, m->slow.v[m->slow.num]);
    ramp_measure(&m->up);
    ramp_measure(&m->slow);
    real_t a;
    m->cruise = distance - ramp_reach(&m->up, m->peak, &a) - ramp_reach(&m->slow, m->peak, &a);
    if (m->cruise < REAL(0)) {
        m->peak = peak_speed(&m->up, &m->slow, distance, m->peak);
        m->cruise = distance - ramp_reach(&m->up, m->peak, &a) - ramp_reach(&m->slow, m->peak, &a);
        if (m->cruise < real_mul(PEAK_TOLERANCE, real_mul(REAL(2), distance))) m->cruise = REAL(0); // unless the reach leaps there
    }
    return SSV_FEASIBLE;
}

// Cheapest speed to hold: the least of the convex L(v, 0) / v. Between the speeds where some thruster changes sign that is
// W1 / v + const + W2 g v, so a stationary point, one of those speeds, or top.
static real_t cruise_speed(const laws_t* laws, real_t top) {
    const ssv_thrusts_t* t = laws->thrusts;
    real_t best = top, best_cost = real_div(cost_rate(laws, top, REAL(0)), top);
    for (int i = -1; i < N; i++) {
        // The interval above sign change i (-1: from rest).
        real_t low = REAL(0), high = top, slope = REAL(0);
        if (i >= 0) {
            if (t->quadratic[i] == REAL(0)) continue;
            low = -real_div(t->linear[i], t->quadratic[i]);
            if (!(low > REAL(0) && low < top)) continue;
        }
        for (int j = 0; j < N; j++) {
            const real_t change = t->quadratic[j] == REAL(0) ? REAL(0) : -real_div(t->linear[j], t->quadratic[j]);
            if (change > low && change < high) high = change;
        }
        const real_t mid = real_mul(REAL(0.5), low + high);
        for (int j = 0; j < N; j++) {
            const bool positive = t->linear[j] + real_mul(mid, t->quadratic[j]) > REAL(0);
            slope += positive ? t->quadratic[j] : -t->quadratic[j];
        }
        slope = real_mul(laws->weight_impulse, slope);
        real_t v = high;
        if (slope > REAL(0)) v = real_max(low, real_min(high, real_sqrt(real_div(laws->weight_time, slope))));
        if (!(v > REAL(0))) continue;
        const real_t cost = real_div(cost_rate(laws, v, REAL(0)), v);
        if (cost >= best_cost) continue;
        best = v - real_mul(TERMINAL_MARGIN, v); // a coast towards the speed at which a drag turns never gets there
        best_cost = cost;
    }
    return best;
}

// Whether drag only ever resists: then nothing but full thrust speeds up best.
static bool always_resists(const laws_t* laws) {
    for (int i = 0; i < N; i++) {
        if (laws->acts[i] && (laws->idle[i].c[1] > REAL(0) || laws->idle[i].c[2] > REAL(0))) return false;
    }
    return true;
}

// Both ramps from rest to the peak, with the marginal cost of distance that makes this peak the right one; the distance left
// between them is cruised. A ramp of full thrust ahead, which no marginal cost changes, is kept once it is there.
static bool thrifty_ramps(laws_t* laws, real_t peak, real_t distance, motion_t* m) {
    const bool resists = always_resists(laws);
    real_t a;
    laws_up_to(laws, peak);
    m->peak = peak;
    const real_t rate = cost_rate(laws, peak, REAL(0));
    laws->lambda = real_div(rate, peak);
    for (int i = 0; i < N; i++) {
        const real_t drag[3] = {REAL(0), laws->thrusts->linear[i], laws->thrusts->quadratic[i]};
        const real_t cost = real_mul(laws->weight_impulse, ssv_quadratic_size(drag, peak));
        laws->coasts[i] = laws->acts[i] && cost > real_mul(NEXT_TO_NOTHING, rate);
    }
    if (m->up.num == 0 || m->up.v[m->up.num] < peak || !resists) {
        ramp_start(&m->up);
        if (!ramp_extend(laws, resists ? SPEED_UP : THRIFTY_UP, peak, &m->up)) return false;
        ramp_measure(&m->up);
    }
    ramp_start(&m->slow);
    if (!ramp_extend(laws, THRIFTY_SLOW, peak, &m->slow)) return false;
    ramp_measure(&m->slow);
    m->cruise = distance - ramp_reach(&m->up, peak, &a) - m->slow.reach[m->slow.num];
    return true;
}

// How far to cruise at this peak before a higher one is worth its ramps. Where some thruster feels no drag it idles in the
// cruise, and dJ / d peak = 2 W2 sum |accel| of those + cruise time * d L(v, 0) / dv - cruise time * lambda.
static real_t worth_holding(const laws_t* laws, real_t peak) {
    const ssv_thrusts_t* t = laws->thrusts;
    real_t kink = REAL(0), slope = REAL(0);
    for (int i = 0; i < N; i++) {
        const real_t grows = t->linear[i] + real_mul(REAL(2), real_mul(peak, t->quadratic[i]));
        slope += thrust(t, i, peak, REAL(0)) > REAL(0) ? grows : -grows;
        if (laws->acts[i] && !laws->coasts[i]) kink += laws->weight[i];
    }
    const real_t gain = laws->lambda - real_mul(laws->weight_impulse, slope);
    if (kink == REAL(0)) return REAL(0);
    if (gain <= REAL(0)) return HOLD_FOR_EVER;
    return real_mul(peak, real_div(real_mul(REAL(2), real_mul(laws->weight_impulse, kink)), gain));
}

// A long leg cruises at the cheapest speed. A short one has the peak whose ramps just cover the distance: from an estimate,
// regula falsi on the root of the covered fraction, which is nearly linear in the peak, aimed a hair short; the hair is cruised.
static ssv_outcome_t solve_optimal(laws_t* laws, const ssv_rule_t* rule, real_t distance, real_t top, motion_t* m) {
    laws->weight_impulse = rule->weight_impulse_per_Ns;
    laws->weight_time = real_max(rule->weight_time_per_s, real_mul(SSV_TIME_PRICE_MIN_N, rule->weight_impulse_per_Ns));
    const real_t cruise = cruise_speed(laws, top);
    real_t low = REAL(0), low_miss = -REAL(1), high = cruise, high_miss = REAL(0), peak = cruise, price;
    bool was_above = true, bracketed = false;
    if (ssv_profile_estimate(laws->thrusts, rule->weight_time_per_s, rule->weight_impulse_per_Ns, distance, &price, &peak)) {
        if (peak > real_mul(NEARLY, cruise)) peak = cruise;
    }
    ramp_start(&m->up);
    for (int n = 0; n < MAX_FALSI; n++) {
        if (!thrifty_ramps(laws, peak, distance, m)) return SSV_TOO_MANY_PIECES;
        const real_t hold = real_min(worth_holding(laws, peak), real_mul(REAL(100), distance));
        const real_t covered = real_sqrt(real_div(distance - m->cruise + hold, distance));
        const real_t miss = covered - REAL(1) + SHORT_BY;
        const bool meets = peak == cruise ? m->cruise >= hold : real_abs(miss) <= SHORT_BY;
        if (m->cruise >= REAL(0) && meets) return SSV_FEASIBLE;
        // Illinois: an end that stays twice counts half.
        const bool above = miss > REAL(0);
        if (bracketed && above == was_above) *(above ? &low_miss : &high_miss) = real_mul(REAL(0.5), above ? low_miss : high_miss);
        *(above ? &high : &low) = peak;
        *(above ? &high_miss : &low_miss) = miss;
        was_above = above;
        bracketed = bracketed || above;
        if (!bracketed) {
            peak = real_min(cruise, real_mul(BEYOND, real_div(peak, covered)));
        } else {
            const real_t share = n % 3 == 2 ? REAL(0.5) : real_div(-low_miss, high_miss - low_miss);
            peak = low + real_mul(high - low, share);
        }
    }
    return thrifty_ramps(laws, low, distance, m) ? SSV_FEASIBLE : SSV_TOO_MANY_PIECES;
}

ssv_outcome_t ssv_profile_solve(const ssv_thrusts_t* thrusts, const ssv_rule_t* rule, real_t distance, ssv_profile_t* profile) {
    static const real_t steady[3] = {REAL(0), REAL(0), REAL(0)};
    laws_t laws;
    motion_t m;
    if (!laws_init(thrusts, &laws)) return SSV_NO_AUTHORITY;
    real_t top = top_speed(&laws, distance);
    if (rule->speed_max > REAL(0)) top = real_min(top, rule->speed_max);
    // Where only time counts, full thrust and full reverse are optimal.
    const bool thrifty = rule->ramp == SSV_OPTIMAL && rule->weight_impulse_per_Ns > REAL(0);
    const ssv_outcome_t outcome =
        thrifty ? solve_optimal(&laws, rule, distance, top, &m) : solve_paper(&laws, rule, distance, top, &m);
    if (outcome != SSV_FEASIBLE) return outcome;

    profile->num_pieces = 0;
    profile->duration_s = profile->impulse_Ns = REAL(0);
    profile->peak_speed = m.peak;
    bool fits = true;
    for (int k = 0; k < m.up.num && m.up.v[k] < m.peak; k++) {
        fits = fits && append(profile, thrusts, m.up.law[k]->c, m.up.v[k], real_min(m.up.v[k + 1], m.peak), REAL(0));
    }
    if (m.cruise > REAL(0)) fits = fits && append(profile, thrusts, steady, m.peak, m.peak, real_div(m.cruise, m.peak));
    for (int k = m.slow.num - 1; k >= 0; k--) {
        if (m.slow.v[k] >= m.peak) continue;
        fits = fits && append(profile, thrusts, m.slow.law[k]->c, real_min(m.slow.v[k + 1], m.peak), m.slow.v[k], REAL(0));
    }
    if (!fits) return SSV_TOO_MANY_PIECES;
    return profile->duration_s <= SSV_DURATION_MAX_S ? SSV_FEASIBLE : SSV_TOO_LONG;
}
