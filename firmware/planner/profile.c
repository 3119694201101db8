#include "planner/profile.h"

#include "planner/law.h"

#define N SSV_NUM_THRUSTERS
#define MAX_KNOTS SSV_MAX_PROFILE_PIECES
#define MAX_NEWTON 60

// Terminal speed is only approached; cruise at this much less. The time lost is the same fraction of the cruise.
#define TERMINAL_MARGIN REAL(5.9604644775390625e-8)
// Two laws closer than this fraction of their size are one law: the rest is rounding.
#define SAME_LAW REAL(1e-11)
// The next knot lies at least this fraction of the top speed beyond the last; a law found out of place in between is so by
// rounding only.
#define PROBE REAL(9.3132257461547852e-10)

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

typedef enum { SPEED_UP, BRAKE, COAST } policy_t;

// Laws that a leg's thrusters can be bound to: up[i] and brake[i] put thruster i at its limit, idle[i] gives it no thrust.
typedef struct {
    const ssv_thrusts_t* thrusts;
    real_t top;   // speeds go up to here
    real_t total; // sum of |accel|
    bool acts[N];
    real_t up[N][3], brake[N][3], idle[N][3];
} laws_t;

static bool laws_init(const ssv_thrusts_t* thrusts, laws_t* laws) {
    real_t largest = REAL(0);
    for (int i = 0; i < N; i++) largest = real_max(largest, real_abs(thrusts->accel[i]));
    laws->thrusts = thrusts;
    laws->top = laws->total = REAL(0);
    for (int i = 0; i < N; i++) {
        const real_t A = thrusts->accel[i];
        laws->acts[i] = real_abs(A) > real_mul(SAME_LAW, largest);
        if (!laws->acts[i]) continue;
        const real_t limit = real_div(thrusts->force_max_N, real_abs(A));
        laws->total += real_abs(A);
        laws->idle[i][0] = REAL(0);
        laws->idle[i][1] = -real_div(thrusts->linear[i], A);
        laws->idle[i][2] = -real_div(thrusts->quadratic[i], A);
        for (int k = 0; k < 3; k++) {
            laws->up[i][k] = laws->idle[i][k] + (k == 0 ? limit : REAL(0));
            laws->brake[i][k] = laws->idle[i][k] - (k == 0 ? limit : REAL(0));
        }
    }
    return largest > REAL(0);
}

// Sign of a - b just beyond speed v: by value, then slope, then curvature, each only if it is more than rounding. Laws of
// thrusters that mirror each other often agree at v and part later.
static int compare(const laws_t* laws, const real_t a[3], const real_t b[3], real_t v) {
    const real_t top = laws->top, noise = real_mul(SAME_LAW, ssv_quadratic_size(a, top) + ssv_quadratic_size(b, top));
    const real_t d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    const real_t curve = real_mul(d[2], real_sq(top));
    const real_t slope = real_mul(top, d[1] + real_mul(REAL(2), real_mul(d[2], v)));
    const real_t value = ssv_quadratic_at(d, v);
    const real_t first = real_abs(value) > noise ? value : real_abs(slope) > noise ? slope : curve;
    return real_abs(first) <= noise ? 0 : first > REAL(0) ? 1 : -1;
}

// The tightest limit just beyond speed v.
static const real_t* limit_at(const laws_t* laws, bool up, real_t v) {
    const real_t* best = NULL;
    for (int i = 0; i < N; i++) {
        if (!laws->acts[i]) continue;
        const real_t* law = up ? laws->up[i] : laws->brake[i];
        if (best == NULL || (up ? compare(laws, law, best, v) < 0 : compare(laws, law, best, v) > 0)) best = law;
    }
    return best;
}

// Total height of the kinks at or below a law just beyond speed v.
static real_t kinks_below(const laws_t* laws, const real_t law[3], real_t v) {
    real_t sum = REAL(0);
    for (int i = 0; i < N; i++) {
        if (laws->acts[i] && compare(laws, laws->idle[i], law, v) <= 0) sum += real_abs(laws->thrusts->accel[i]);
    }
    return sum;
}

// Least sum of |u_i|: that sum is convex and piecewise linear in a with a kink of height |accel_i| where u_i = 0, so the
// minimum is the weighted median of the kinks. Of equal ones the stronger braking is taken.
static const real_t* coast_at(const laws_t* laws, real_t v) {
    const real_t half = real_mul(REAL(0.5) - SAME_LAW, laws->total);
    const real_t* best = limit_at(laws, false, v);
    if (kinks_below(laws, best, v) >= half) return best;
    best = NULL;
    for (int i = 0; i < N; i++) {
        if (!laws->acts[i] || kinks_below(laws, laws->idle[i], v) < half) continue;
        if (best == NULL || compare(laws, laws->idle[i], best, v) < 0) best = laws->idle[i];
    }
    return best;
}

static const real_t* law_at(const laws_t* laws, policy_t policy, real_t v) {
    return policy == COAST ? coast_at(laws, v) : limit_at(laws, policy == SPEED_UP, v);
}

// First speed in (from, to) at which another law may take over from this one.
static real_t next_crossing(const laws_t* laws, policy_t policy, const real_t law[3], real_t from, real_t to) {
    real_t next = to;
    for (int i = 0; i < N; i++) {
        if (!laws->acts[i]) continue;
        const real_t* rival[2] = {policy == SPEED_UP ? laws->up[i] : laws->brake[i], policy == COAST ? laws->idle[i] : NULL};
        for (int k = 0; k < 2; k++) {
            if (rival[k] == NULL || rival[k] == law) continue;
            const real_t diff[3] = {rival[k][0] - law[0], rival[k][1] - law[1], rival[k][2] - law[2]};
            if (ssv_quadratic_size(diff, to) <= real_mul(SAME_LAW, ssv_quadratic_size(law, to))) continue;
            next = ssv_quadratic_root_after(diff, from, next);
        }
    }
    return next;
}

// ---- Ramps: speed as a chain of laws, and the distance it takes ---------------------------------------------------------

// From rest to knot speeds: law[k] holds between v[k] and v[k + 1]; reach[k] is the distance from rest to v[k] (or back).
typedef struct {
    int num;
    real_t v[MAX_KNOTS + 1], reach[MAX_KNOTS + 1];
    const real_t* law[MAX_KNOTS];
} ramp_table_t;

// Extends the ramp to speed top under one policy.
static bool ramp_extend(const laws_t* laws, policy_t policy, real_t top, ramp_table_t* ramp) {
    const real_t probe = real_mul(PROBE, laws->top);
    real_t v = ramp->v[ramp->num];
    for (int n = 0; n < MAX_KNOTS && v < top; n++) {
        const real_t* law = law_at(laws, policy, v);
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
        ramp->reach[k + 1] = ramp->reach[k] + real_abs(ssv_law_integrals(ramp->law[k], ramp->v[k], ramp->v[k + 1]).distance);
    }
}

// Distance from rest to v, and the acceleration there.
static real_t ramp_reach(const ramp_table_t* ramp, real_t v, real_t* acceleration) {
    int k = 0;
    while (k + 1 < ramp->num && ramp->v[k + 1] < v) k++;
    *acceleration = ssv_quadratic_at(ramp->law[k], v);
    return ramp->reach[k] + real_abs(ssv_law_integrals(ramp->law[k], ramp->v[k], v).distance);
}

// Largest speed that every thruster can hold: |linear v + quadratic v^2| <= force_max. Infinite without drag; then what the
// distance allows.
static real_t top_speed(const laws_t* laws, real_t distance) {
    const ssv_thrusts_t* t = laws->thrusts;
    const real_t* start = limit_at(laws, true, REAL(0));
    bool bounded = false;
    real_t top = REAL(0);
    for (int i = 0; i < N; i++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            const real_t c[3] = {real_mul(real_from_int(sign), t->force_max_N), t->linear[i], t->quadratic[i]};
            real_t root[2];
            if ((c[1] == REAL(0) && c[2] == REAL(0)) || !ssv_quadratic_roots(c, REAL(1e9), root)) continue;
            for (int k = 0; k < 2; k++) {
                if (root[k] > REAL(0) && (!bounded || root[k] < top)) {
                    top = root[k];
                    bounded = true;
                }
            }
        }
    }
    const real_t free_top = real_sqrt(real_mul(REAL(2), real_mul(start[0], distance)));
    if (!bounded) return free_top;
    return top - real_mul(TERMINAL_MARGIN, top);
}

// Where the least thrust stops slowing the body, no drag-only ramp starts: end the ramp below.
static void keep_slowing(ramp_table_t* ramp) {
    for (int k = 0; k < ramp->num; k++) {
        const bool slows = ssv_quadratic_at(ramp->law[k], ramp->v[k]) < REAL(0) &&
                           ssv_quadratic_at(ramp->law[k], ramp->v[k + 1]) < REAL(0) &&
                           ssv_quadratic_root_after(ramp->law[k], ramp->v[k], ramp->v[k + 1]) >= ramp->v[k + 1];
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

// Speed at which speeding up must turn into slowing so that both take the distance; from below, by safeguarded Newton: the
// sum of the reaches is increasing and convex in v.
static real_t peak_speed(const ramp_table_t* up, const ramp_table_t* slow, real_t distance, real_t top) {
    real_t low = REAL(0), high = top, a_up, a_slow;
    real_t v = top;
    for (int n = 0; n < MAX_NEWTON; n++) {
        const real_t excess = ramp_reach(up, v, &a_up) + ramp_reach(slow, v, &a_slow) - distance;
        if (excess > REAL(0)) {
            high = v;
        } else {
            low = v;
            if (-excess <= real_mul(REAL(1e-14), distance)) break;
        }
        if (high - low <= real_mul(REAL(1e-15), high)) break;
        const real_t slope = real_mul(v, real_div(REAL(1), real_abs(a_up)) + real_div(REAL(1), real_abs(a_slow)));
        const real_t newton = v - real_div(excess, slope);
        v = newton > low && newton < high ? newton : real_mul(REAL(0.5), low + high);
    }
    return low;
}

ssv_outcome_t ssv_profile_solve(const ssv_thrusts_t* thrusts, ssv_ramp_t ramp, real_t cutoff, real_t distance,
                                ssv_profile_t* profile) {
    static const real_t steady[3] = {REAL(0), REAL(0), REAL(0)};
    laws_t laws;
    ramp_table_t up, slow;
    if (!laws_init(thrusts, &laws)) return SSV_NO_AUTHORITY;
    real_t top = top_speed(&laws, distance);
    laws.top = top;
    up.num = slow.num = 0;
    up.v[0] = slow.v[0] = REAL(0);
    const real_t reverse_from = ramp == SSV_DRAG_ONLY ? real_min(cutoff, top) : top;
    if (!ramp_extend(&laws, BRAKE, reverse_from, &slow) || !ramp_extend(&laws, COAST, top, &slow)) return SSV_TOO_MANY_PIECES;
    if (!ramp_extend(&laws, SPEED_UP, top, &up)) return SSV_TOO_MANY_PIECES;
    keep_slowing(&slow);
    if (slow.v[slow.num] < top && slow.v[slow.num] <= reverse_from) return SSV_NO_AUTHORITY;
    top = real_min(top, slow.v[slow.num]);
    ramp_measure(&up);
    ramp_measure(&slow);

    real_t a;
    real_t peak = top, rest = distance - ramp_reach(&up, top, &a) - ramp_reach(&slow, top, &a);
    if (rest < REAL(0)) {
        peak = peak_speed(&up, &slow, distance, top);
        rest = REAL(0);
    }
    profile->num_pieces = 0;
    profile->duration_s = profile->impulse_Ns = REAL(0);
    profile->peak_speed = peak;
    bool fits = true;
    for (int k = 0; k < up.num && up.v[k] < peak; k++) {
        fits = fits && append(profile, thrusts, up.law[k], up.v[k], real_min(up.v[k + 1], peak), REAL(0));
    }
    if (rest > REAL(0)) fits = fits && append(profile, thrusts, steady, peak, peak, real_div(rest, peak));
    for (int k = slow.num - 1; k >= 0; k--) {
        if (slow.v[k] >= peak) continue;
        fits = fits && append(profile, thrusts, slow.law[k], real_min(slow.v[k + 1], peak), slow.v[k], REAL(0));
    }
    if (!fits) return SSV_TOO_MANY_PIECES;
    return profile->duration_s <= SSV_DURATION_MAX_S ? SSV_FEASIBLE : SSV_TOO_LONG;
}
