#include "planner/profile/profile.h"

#include "planner/profile/estimate.h"
#include "planner/profile/ramp.h"

#define N SSV_NUM_THRUSTERS
// One arc is the cruise.
#define MAX_STRETCHES (SSV_MAX_PROFILE_ARCS - 1)
#define NUM_GUESSES 3
#define MAX_NEWTON 60
#define SURELY 8
#define MAX_FALSI 60

// Faster than any vehicle [m/s or rad/s].
#define FASTEST REAL(1e4)
// Terminal speed is only approached; cruise at this much less. The time lost is the same fraction of the cruise.
#define TERMINAL_MARGIN real_max(REAL(5.9604644775390625e-8), 64 * REAL_NOISE)
// How closely two ramps without a cruise cover their leg, as a fraction of it.
#define PEAK_TOLERANCE real_max(REAL(1e-11), 4 * REAL_NOISE)
// Where two such ramps meet: at this part of a ramp's peak its acceleration is typical of all of it; the first peak
// that is tried is no more than this part of the top; a step of the log-odds is no more than this; and the hair.
#define TYPICAL REAL(0.7)
#define FIRST REAL(0.9)
#define FARTHEST REAL(4)
#define HAIR REAL(1e-5)
// A short optimal leg's ramps cover the distance to within twice this fraction, cruising the rest: in J that is its
// square.
#define SHORT_BY REAL(1e-5)
// An estimated peak this close to the cruise is taken for the cruise; a peak found too low is left by a little more
// than asked.
#define NEARLY REAL(0.97)
#define BEYOND REAL(1.003)
// Longer than any leg, as a multiple of it.
#define HOLD_FOR_EVER REAL(100)
// A coast counts as the cruise if the drag of the thruster that idles costs less than the first of these fractions of
// it, or if that drag takes less than the second off the speed along the whole leg: between such speeds a ramp cannot
// be walked.
#define NEXT_TO_NOTHING REAL(1e-7)
#define KEEPS_SPEED REAL(1e-4)
// A speed that a scalar with a fixed smallest number rounds to nothing makes a leg longer than this power of two of its
// own units of time; and the longest plan, in seconds.
#define EMPTY_EXPONENT 30
#define LONGEST_PLAN_EXPONENT 15
// A thrust below this fraction of the limit is none.
#define NO_THRUST real_max(REAL(1e-11), 16 * REAL_NOISE)

real_t ssv_arc_speed(const ssv_arc_t* arc, real_t t_s) {
    if (arc->v_start == arc->v_end) return arc->v_start;
    // From the end that is farther from a terminal speed: time there says little of the speed, the other way round it
    // is exact.
    const real_t Q_start = real_abs(ssv_quadratic_at(arc->dv_dt, arc->v_start));
    const real_t Q_end = real_abs(ssv_quadratic_at(arc->dv_dt, arc->v_end));
    const real_t v = Q_start >= Q_end ? ssv_law_speed(arc->dv_dt, arc->v_start, t_s)
                                      : ssv_law_speed(arc->dv_dt, arc->v_end, t_s - arc->duration_s);
    return real_max(real_min(arc->v_start, arc->v_end), real_min(real_max(arc->v_start, arc->v_end), v));
}

ssv_moments_t ssv_arc_moments(const ssv_arc_t* arc, real_t v_from, real_t v_to, real_t time_s) {
    return ssv_law_moments(arc->dv_dt, v_from, v_to, time_s);
}

void ssv_arc_thrust(const ssv_thrusts_t* thrusts, const ssv_arc_t* arc, int i, real_t c[3]) {
    const real_t A = thrusts->accel[i];
    c[0] = real_mul(A, arc->dv_dt[0]);
    c[1] = real_mul(A, arc->dv_dt[1]) + thrusts->linear[i];
    c[2] = real_mul(A, arc->dv_dt[2]) + thrusts->quadratic[i];
}

// ---- Where the ramps meet
// -----------------------------------------------------------------------------------------------

// A leg in its own units, and what is decided of it: the two ramps, and how far the body cruises between them.
typedef struct {
    ssv_units_t unit;
    ssv_thrusts_t thrusts;
    ssv_steering_t steering;
    real_t distance, cutoff, top;
    ssv_stretch_t stretch[MAX_STRETCHES];
    ssv_ramp_table_t up, slow;
    real_t peak, cruise;
    ssv_stretch_t hold;
    // What the ramp up to a peak costs, and its length.
    real_t up_peak, up_length;
    ssv_profile_price_t up_price;
} leg_t;

static void restart(ssv_ramp_table_t* ramp) { ramp->num = 0; }

// Largest speed that every thruster can hold; without drag, the one at the end of the leg under full thrust.
static real_t top_speed(const leg_t* leg) {
    const ssv_laws_t* laws = &leg->steering.laws;
    const real_t terminal = ssv_terminal_speed(&leg->thrusts, FASTEST);
    if (terminal < FASTEST) return terminal - real_mul(TERMINAL_MARGIN, terminal);
    real_t limit = laws->limit[0];
    for (int k = 1; k < laws->num; k++) limit = real_min(limit, laws->limit[k]);
    return real_sqrt(real_mul(REAL(2), real_mul(limit, leg->distance)));
}

static ssv_outcome_t begin(const ssv_thrusts_t* thrusts, const ssv_rule_t* rule, real_t distance, leg_t* leg) {
    const bool optimal = rule->ramp == SSV_OPTIMAL;
    const real_t weight_impulse = optimal ? rule->weight_impulse_per_Ns : REAL(0);
    const real_t weight_time = real_max(rule->weight_time_per_s, real_mul(SSV_TIME_PRICE_MIN_N, weight_impulse));
    if (!ssv_thrusts_scale(thrusts, weight_time, weight_impulse, distance, &leg->unit, &leg->thrusts))
        return SSV_NO_AUTHORITY;
    if (!ssv_laws_of(&leg->thrusts, &leg->steering.laws)) return SSV_NO_AUTHORITY;
    leg->distance = real_scale(distance, -leg->unit.length);
    leg->cutoff = real_scale(rule->cutoff, -leg->unit.speed);
    leg->steering.weight_time = weight_time;
    leg->steering.weight_impulse = real_scale(weight_impulse, leg->unit.force);
    leg->top = top_speed(leg);
    if (rule->speed_max > REAL(0)) leg->top = real_min(leg->top, real_scale(rule->speed_max, -leg->unit.speed));
    leg->up = (ssv_ramp_table_t){.first = &leg->stretch[0], .step = 1};
    leg->slow = (ssv_ramp_table_t){.first = &leg->stretch[MAX_STRETCHES - 1], .step = -1};
    leg->up_peak = REAL(0);
    return SSV_FEASIBLE;
}

static bool extend(leg_t* leg, ssv_policy_t policy, real_t top, ssv_ramp_table_t* ramp) {
    const int taken = ramp == &leg->up ? leg->slow.num : leg->up.num;
    return ssv_ramp_extend(&leg->steering, policy, top, MAX_STRETCHES - taken, ramp);
}

// What is left to cruise when both ramps go up to a peak.
static real_t cruise_at(leg_t* leg, real_t peak, real_t a[2]) {
    const ssv_laws_t* laws = &leg->steering.laws;
    return leg->distance - ssv_ramp_reach(laws, &leg->up, peak, &a[0]) - ssv_ramp_reach(laws, &leg->slow, peak, &a[1]);
}

// 1 / (1 / a[0] + 1 / a[1]): the acceleration of both ramps together.
static real_t together(const real_t a[2]) { return real_mul(a[0], real_div(a[1], a[0] + a[1])); }

// The nearer to `from` of `to` and the knots of a ramp on the way there.
static real_t next_knot(const ssv_ramp_table_t* ramp, real_t from, real_t to) {
    for (int k = 0; k < ramp->num; k++) {
        const real_t knot = ssv_ramp_stretch(ramp, k)->v_high;
        if ((from < knot && knot < to) || (to < knot && knot < from)) to = knot;
    }
    return to;
}

// Peak at which both ramps take the distance, to within PEAK_TOLERANCE of it; at the top they take more, leg->cruise
// being how much. Safeguarded Newton on the root of the distance covered, over the log-odds of the peak, as a share of
// a hair more than the top: the root is linear in the peak where there is no drag, a coast covers the log of its peak,
// and a ramp to a terminal speed the log of what it lacks. Where Newton leaves the bracket, the distance covered is
// taken to be linear in the log-odds. No step goes past a knot, and every other late one halves the bracket.
static void meet(leg_t* leg, real_t top) {
    const ssv_laws_t* laws = &leg->steering.laws;
    const real_t D = leg->distance, whole = top + real_mul(HAIR, top);
    real_t low = REAL(0), high = top, covered[2] = {REAL(0), D - leg->cruise}, next = REAL(0), v, a[2];
    // With drag, a ramp is about as long as one of the acceleration at some part of its peak.
    for (int n = 0; n < NUM_GUESSES; n++) {
        const real_t typical = real_mul(TYPICAL, next);
        a[0] = ssv_ramp_acceleration(laws, &leg->up, typical);
        a[1] = ssv_ramp_acceleration(laws, &leg->slow, typical);
        next = real_min(real_sqrt(real_mul(REAL(2), real_mul(D, together(a)))), real_mul(FIRST, top));
    }
    for (int n = 0; n < MAX_NEWTON; n++) {
        v = next;
        leg->cruise = cruise_at(leg, v, a);
        if (real_abs(leg->cruise) <= real_mul(PEAK_TOLERANCE, D)) break;
        const bool above = leg->cruise < REAL(0);
        *(above ? &high : &low) = v;
        covered[above] = D - leg->cruise;
        real_t odds = real_div(v, whole - v), dy = FARTHEST;
        if (covered[above] > real_mul(REAL(1e-6), D)) { // or the quotient may be too large
            const real_t root = real_sqrt(real_div(D, covered[above])), lack = real_mul(covered[above], root - REAL(1));
            const real_t per_odds = real_div(real_mul(whole, together(a)), real_mul(v, whole - v));
            dy = real_mul(REAL(2), real_div(real_mul(lack, per_odds), v));
            dy = real_max(-FARTHEST, real_min(FARTHEST, dy));
        }
        for (int way = 0; way < 2; way++) {
            odds += real_mul(odds, real_expm1(dy));
            next = real_div(real_mul(whole, odds), REAL(1) + odds);
            if ((next > low && next < high) || !(low > REAL(0))) break;
            odds = real_div(low, whole - low);
            const real_t ratio = real_div(real_div(high, whole - high), odds);
            dy = real_mul(real_log1p(ratio - REAL(1)), real_div(D - covered[0], covered[1] - covered[0]));
        }
        const bool creeps = n >= SURELY && n % 2 == 0;
        if (creeps || !(next > low && next < high)) next = real_mul(REAL(0.5), low + high);
        next = next_knot(&leg->slow, v, next_knot(&leg->up, v, next));
    }
    leg->peak = v;
    // The tolerance was not met only where the reach leaps: then the lower side, and the rest is cruised.
    if (leg->cruise < -real_mul(PEAK_TOLERANCE, D)) leg->cruise = cruise_at(leg, leg->peak = low, a);
}

// Of a leg so slow that this scalar rounds its speed to nothing. It takes longer than 2^EMPTY_EXPONENT of its own units
// of time. Where that is not longer than the longest plan, only a finer scalar can tell.
static ssv_outcome_t too_slow(const leg_t* leg) {
    if (leg->unit.time + EMPTY_EXPONENT < LONGEST_PLAN_EXPONENT)
        (void)real_div(REAL(1), REAL(0)); // counts as an overflow
    return SSV_TOO_LONG;
}

// With one of the paper's ramps. The ramp up serves both.
static ssv_outcome_t solve_paper(leg_t* leg, ssv_ramp_t ramp) {
    const ssv_laws_t* laws = &leg->steering.laws;
    const real_t top = leg->top, reverse_from = ramp == SSV_DRAG_ONLY ? real_min(leg->cutoff, top) : top;
    restart(&leg->slow);
    if (leg->up.num == 0) {
        ssv_steering_up_to(&leg->steering, top);
        if (!extend(leg, SSV_SPEED_UP, top, &leg->up)) return SSV_TOO_MANY_ARCS;
        ssv_ramp_measure(laws, &leg->up);
    }
    if (!extend(leg, SSV_BRAKE, reverse_from, &leg->slow) || !extend(leg, SSV_COAST, top, &leg->slow))
        return SSV_TOO_MANY_ARCS;
    ssv_ramp_keep_slowing(laws, &leg->slow);
    const real_t highest = ssv_ramp_top(&leg->slow);
    if (highest < top && highest <= reverse_from) return SSV_NO_AUTHORITY;
    ssv_ramp_measure(laws, &leg->slow);
    real_t a[2];
    if (!(highest > REAL(0))) return too_slow(leg);
    leg->peak = highest;
    leg->cruise = cruise_at(leg, highest, a);
    if (leg->cruise < REAL(0)) meet(leg, highest);
    return SSV_FEASIBLE;
}

// Whether drag only ever resists: then nothing but full thrust speeds up best.
static bool always_resists(const ssv_laws_t* laws) {
    for (int k = 0; k < laws->num; k++) {
        if (laws->linear[k] > REAL(0) || laws->quadratic[k] > REAL(0)) return false;
    }
    return true;
}

// Which coasts differ from the cruise. That is decided once for a leg, at about its peak: the conditions with and
// without a coast differ a little, and a peak between them would meet neither.
static void decide_coasts(leg_t* leg, real_t peak) {
    ssv_steering_t* s = &leg->steering;
    const real_t rate = s->weight_time + real_mul(s->weight_impulse, ssv_holding_thrust(&leg->thrusts, peak));
    ssv_steering_up_to(s, peak);
    for (int k = 0; k < s->laws.num; k++) {
        const real_t cost = real_mul(s->weight_impulse, real_mul(s->laws.weight[k], s->size[k]));
        const bool slows = real_mul(s->size[k], leg->distance) > real_mul(KEEPS_SPEED, real_sq(peak));
        s->coasts[k] = slows && cost > real_mul(NEXT_TO_NOTHING, rate);
    }
}

// Both ramps from rest to the peak, with the marginal cost of distance that makes this peak the right one; the distance
// left between them is cruised. A ramp of full thrust ahead, which no marginal cost changes, is kept once it is there.
static bool thrifty_ramps(leg_t* leg, real_t peak, real_t a[2]) {
    ssv_steering_t* s = &leg->steering;
    const bool resists = always_resists(&s->laws);
    ssv_steering_up_to(s, peak);
    leg->peak = peak;
    restart(&leg->slow);
    if (ssv_ramp_top(&leg->up) < peak || !resists) {
        restart(&leg->up);
        if (!extend(leg, resists ? SSV_SPEED_UP : SSV_THRIFTY_UP, peak, &leg->up)) return false;
        ssv_ramp_measure(&s->laws, &leg->up);
    }
    if (!extend(leg, SSV_THRIFTY_SLOW, peak, &leg->slow)) return false;
    ssv_ramp_measure(&s->laws, &leg->slow);
    leg->cruise = cruise_at(leg, peak, a);
    return true;
}

// How far to cruise at this peak before a higher one is worth its ramps, which end there at accelerations a[up] and
// -a[slow]. With C = L - L(v, 0), dJ / d peak = C / a of both ramps + cruise time * d L(v, 0) / dv - cruise time *
// lambda. In the first a thruster cancels unless it idles between the two accelerations, closer to the cruise than the
// ramp that ends on its side; a ramp that ends at a limit passes only coasts that count as the cruise. In the last two
// all but the price of time and the bend of the drag cancels.
static real_t worth_holding(const leg_t* leg, real_t peak, const real_t a[2]) {
    const ssv_steering_t* s = &leg->steering;
    const ssv_thrusts_t* t = &leg->thrusts;
    const real_t most = real_mul(HOLD_FOR_EVER, leg->distance);
    real_t kink = REAL(0), bend = REAL(0);
    for (int k = 0; k < s->laws.num; k++) {
        const real_t idle = real_mul(peak, s->laws.linear[k] + real_mul(peak, s->laws.quadratic[k])),
                     size = real_abs(idle);
        const real_t to = idle > REAL(0) ? a[0] : a[1];
        if (!ssv_ramp_idles(idle > REAL(0) ? &leg->up : &leg->slow)) {
            kink += s->coasts[k] ? REAL(0) : s->laws.weight[k];
        } else if (size < to) {
            kink += real_mul(s->laws.weight[k], REAL(1) - real_div(size, to));
        }
    }
    if (!(kink > REAL(0))) return REAL(0);
    for (int i = 0; i < N; i++) {
        bend += t->linear[i] + real_mul(peak, t->quadratic[i]) > REAL(0) ? t->quadratic[i] : -t->quadratic[i];
    }
    const real_t gain = real_div(s->weight_time, peak) - real_mul(s->weight_impulse, real_mul(peak, bend));
    const real_t cost = real_mul(peak, real_mul(REAL(2), real_mul(s->weight_impulse, kink)));
    return cost >= real_mul(gain, most) ? most : real_div(cost, gain);
}

// A long leg cruises at the cheapest speed. A short one has the peak whose ramps just cover the distance: from an
// estimate, regula falsi on the root of the covered fraction, which is nearly linear in the peak, aimed a hair short;
// the hair is cruised.
static ssv_outcome_t solve_optimal(leg_t* leg) {
    const ssv_steering_t* s = &leg->steering;
    real_t cruise = ssv_cruise_speed(&leg->thrusts, s->weight_time, s->weight_impulse, leg->top), price, peak = cruise;
    if (cruise < leg->top)
        cruise -= real_mul(TERMINAL_MARGIN, cruise); // a coast to where a drag turns never gets there
    real_t low = REAL(0), low_miss = -REAL(1), high = cruise, high_miss = REAL(0);
    bool was_above = true, bracketed = false;
    real_t a[2];
    (void)ssv_profile_estimate(&leg->thrusts, s->weight_time, s->weight_impulse, leg->distance, SSV_ESTIMATE_CLOSELY,
                               &price, &peak);
    if (peak > real_mul(NEARLY, cruise)) peak = cruise;
    decide_coasts(leg, peak);
    for (int n = 0; n < MAX_FALSI; n++) {
        if (!(peak > REAL(0))) return too_slow(leg);
        if (!thrifty_ramps(leg, peak, a)) return SSV_TOO_MANY_ARCS;
        const real_t hold = worth_holding(leg, peak, a);
        const real_t covered = real_sqrt(real_div(leg->distance - leg->cruise + hold, leg->distance));
        const real_t miss = covered - REAL(1) + SHORT_BY;
        const bool meets = peak == cruise ? leg->cruise >= hold : real_abs(miss) <= SHORT_BY;
        if (leg->cruise >= REAL(0) && meets) return SSV_FEASIBLE;
        // Illinois: an end that stays twice counts half.
        const bool above = miss > REAL(0);
        if (bracketed && above == was_above)
            *(above ? &low_miss : &high_miss) = real_mul(REAL(0.5), above ? low_miss : high_miss);
        *(above ? &high : &low) = peak;
        *(above ? &high_miss : &low_miss) = miss;
        was_above = above;
        bracketed = bracketed || above;
        if (!bracketed) {
            peak = real_min(cruise, real_mul(BEYOND, real_div(peak, covered)));
        } else {
            const real_t half = real_mul(REAL(0.5), low + high);
            if (half == low || half == high) break; // nothing lies between them, but the reach leaps
            peak = n % 3 == 2 ? half : low + real_mul(high - low, real_div(-low_miss, high_miss - low_miss));
        }
    }
    if (!(low > REAL(0))) return too_slow(leg);
    return thrifty_ramps(leg, low, a) ? SSV_FEASIBLE : SSV_TOO_MANY_ARCS;
}

static ssv_outcome_t solve(leg_t* leg, ssv_ramp_t ramp) {
    // Where only time counts, full thrust and full reverse are optimal.
    const bool thrifty = ramp == SSV_OPTIMAL && leg->steering.weight_impulse > REAL(0);
    const ssv_outcome_t outcome = thrifty ? solve_optimal(leg) : solve_paper(leg, ramp);
    if (outcome != SSV_FEASIBLE) return outcome;
    if (leg->cruise < real_mul(2 * PEAK_TOLERANCE, leg->distance)) leg->cruise = REAL(0);
    return SSV_FEASIBLE;
}

// ---- What it costs
// ------------------------------------------------------------------------------------------------------

// Integral of |c[0] + c[1] v + c[2] v^2| over a stretch of a law.
static real_t integral_of_size(const real_t law[3], const ssv_stretch_t* stretch, const real_t c[3], real_t nothing) {
    const ssv_moments_t* m = &stretch->m;
    const real_t whole = real_mul(c[0], m->time) + real_mul(c[1], m->distance) + real_mul(c[2], m->speed2);
    if (ssv_quadratic_keeps_sign(c, stretch->v_low, stretch->v_high)) return real_abs(whole);
    real_t from = stretch->v_low, before = REAL(0), sum = REAL(0);
    for (int k = 0; k < 2 && ssv_quadratic_size(c, stretch->v_high) > nothing; k++) { // at most two changes of sign
        const real_t root = ssv_quadratic_root_after(c, from, stretch->v_high);
        if (root >= stretch->v_high) break;
        const ssv_moments_t below = ssv_ramp_integrals(law, stretch->v_low, root);
        const real_t part = real_mul(c[0], below.time) + real_mul(c[1], below.distance) + real_mul(c[2], below.speed2);
        sum += real_abs(part - before);
        before = part;
        from = root;
    }
    return sum + real_abs(whole - before);
}

static real_t impulse(const leg_t* leg, const real_t law[3], const ssv_stretch_t* stretch) {
    const ssv_laws_t* laws = &leg->steering.laws;
    const real_t nothing = real_mul(NO_THRUST, leg->thrusts.force_max_N);
    real_t sum = REAL(0);
    for (int k = 0; k < laws->num; k++) {
        const real_t c[3] = {real_mul(laws->weight[k], law[0]), real_mul(laws->weight[k], law[1] - laws->linear[k]),
                             real_mul(laws->weight[k], law[2] - laws->quadratic[k])};
        sum += integral_of_size(law, stretch, c, nothing);
    }
    for (int k = 0; k < laws->num_passive; k++) {
        const real_t c[3] = {REAL(0), laws->passive_linear[k], laws->passive_quadratic[k]};
        sum += integral_of_size(law, stretch, c, nothing);
    }
    return sum;
}

// An arc in time: its law, stretch and impulse in the leg's units.
typedef struct {
    real_t law[3], impulse;
    const ssv_stretch_t* stretch;
    bool falls;
} part_t;

static int num_parts(const leg_t* leg) {
    return leg->up.last + 1 + (leg->cruise > REAL(0) ? 1 : 0) + leg->slow.last + 1;
}

static void take_part(leg_t* leg, int n, part_t* part) {
    const int back = num_parts(leg) - 1 - n; // the slow ramp backwards
    part->falls = back <= leg->slow.last;
    if (n > leg->up.last && !part->falls) {
        const real_t time = real_div(leg->cruise, leg->peak);
        leg->hold.v_low = leg->hold.v_high = leg->peak;
        leg->hold.m = (ssv_moments_t){time, leg->cruise, real_mul(leg->cruise, leg->peak)};
        part->law[0] = part->law[1] = part->law[2] = REAL(0);
        part->stretch = &leg->hold;
        part->impulse = real_mul(time, ssv_holding_thrust(&leg->thrusts, leg->peak));
        return;
    }
    part->stretch = part->falls ? ssv_ramp_up_to_cut(&leg->slow, back) : ssv_ramp_up_to_cut(&leg->up, n);
    ssv_ramp_law(&leg->steering.laws, part->stretch->law, part->law);
    part->impulse = impulse(leg, part->law, part->stretch);
}

// Longest time in a leg's units, as a power of two, that SI units can hold.
#define LONGEST_EXPONENT 24

// Adds the part to the price, and as an arc to the profile unless that is NULL; it begins at `from` in the leg's
// units.
static void append(const leg_t* leg, const part_t* part, real_t from, ssv_profile_price_t* price,
                   ssv_profile_t* profile) {
    const ssv_units_t* unit = &leg->unit;
    const real_t low = real_scale(part->stretch->v_low, unit->speed),
                 high = real_scale(part->stretch->v_high, unit->speed);
    const real_t duration_s = real_scale(part->stretch->m.time, unit->time);
    if (profile != NULL) {
        ssv_arc_t* arc = &profile->arc[profile->num_arcs++];
        *arc = (ssv_arc_t){.t_s = price->duration_s,
                           .duration_s = duration_s,
                           .s = real_scale(from, unit->length),
                           .v_start = part->falls ? high : low,
                           .v_end = part->falls ? low : high};
        for (int n = 0; n < 3; n++)
            arc->dv_dt[n] = real_scale(part->law[n], unit->speed - unit->time - n * unit->speed);
    }
    price->duration_s += duration_s;
    price->impulse_Ns += real_scale(part->impulse, unit->time + unit->force);
}

static ssv_profile_price_t finish(leg_t* leg, ssv_outcome_t outcome, ssv_profile_t* profile) {
    ssv_profile_price_t price = {outcome, REAL(0), REAL(0), REAL(0)};
    if (outcome != SSV_FEASIBLE) return price;
    price.peak_speed = real_scale(leg->peak, leg->unit.speed);
    real_t from = REAL(0);
    int n = 0;
    if (profile == NULL && leg->up_peak == leg->peak) { // as of the other of the paper's ramps
        price = leg->up_price;
        from = leg->up_length;
        n = leg->up.last + 1;
    }
    for (; n < num_parts(leg); n++) {
        part_t part;
        take_part(leg, n, &part);
        price.outcome =
            real_exponent(part.stretch->m.time) + leg->unit.time > LONGEST_EXPONENT ? SSV_TOO_LONG : SSV_FEASIBLE;
        if (price.outcome == SSV_FEASIBLE) append(leg, &part, from, &price, profile);
        from += part.stretch->m.distance;
        if (price.duration_s > SSV_DURATION_MAX_S) price.outcome = SSV_TOO_LONG;
        if (price.outcome != SSV_FEASIBLE) break;
        if (n != leg->up.last) continue;
        leg->up_peak = leg->peak;
        leg->up_length = from;
        leg->up_price = price;
    }
    return price;
}

ssv_profile_price_t ssv_profile_price(const ssv_thrusts_t* thrusts, const ssv_rule_t* rule, real_t distance) {
    leg_t leg;
    const ssv_outcome_t outcome = begin(thrusts, rule, distance, &leg);
    return finish(&leg, outcome == SSV_FEASIBLE ? solve(&leg, rule->ramp) : outcome, NULL);
}

ssv_outcome_t ssv_profile_solve(const ssv_thrusts_t* thrusts, const ssv_rule_t* rule, real_t distance,
                                ssv_profile_t* profile) {
    leg_t leg;
    const ssv_outcome_t outcome = begin(thrusts, rule, distance, &leg);
    profile->num_arcs = 0;
    const ssv_profile_price_t price =
        finish(&leg, outcome == SSV_FEASIBLE ? solve(&leg, rule->ramp) : outcome, profile);
    profile->duration_s = price.duration_s;
    profile->impulse_Ns = price.impulse_Ns;
    profile->peak_speed = price.peak_speed;
    return price.outcome;
}

void ssv_profile_price_ramps(const ssv_thrusts_t* thrusts, const ssv_rule_t* rule, real_t distance,
                             ssv_profile_price_t* full_reverse, ssv_profile_price_t* drag_only) {
    leg_t leg;
    ssv_rule_t paper = *rule;
    paper.ramp = SSV_FULL_REVERSE;
    const ssv_outcome_t outcome = begin(thrusts, &paper, distance, &leg);
    *full_reverse = finish(&leg, outcome == SSV_FEASIBLE ? solve(&leg, SSV_FULL_REVERSE) : outcome, NULL);
    *drag_only = finish(&leg, outcome == SSV_FEASIBLE ? solve(&leg, SSV_DRAG_ONLY) : outcome, NULL);
}
