// Solves a leg: the ramps of a rule, where they meet, what is cruised between them, and what all of it costs.
#include "planner/profile/profile.h"

#include <stddef.h>

#include "planner/math/assert.h"
#include "planner/math/root.h"
#include "planner/profile/estimate.h"
#include "planner/profile/ramp.h"
#include "planner/profile/tolerance.h"
#include "ssv/scenario.h"

#define N SSV_NUM_THRUSTERS
// One arc of a profile is the cruise, the others are arcs of its two ramps.
#define MAX_RAMP_ARCS (SSV_MAX_PROFILE_ARCS - 1)

real_t ssv_arc_speed_free(const ssv_arc_t* arc, real_t t_s) {
    if (arc->v_start == arc->v_end) return arc->v_start;
    // From the end that is farther from a terminal speed. There the time says exactly what the speed is; at the other
    // end the speed hardly depends on it.
    const real_t a_start = real_abs(ssv_quadratic_at(arc->dv_dt, arc->v_start));
    const real_t a_end = real_abs(ssv_quadratic_at(arc->dv_dt, arc->v_end));
    return a_start >= a_end ? ssv_speed_after(arc->dv_dt, arc->v_start, t_s)
                            : ssv_speed_after(arc->dv_dt, arc->v_end, t_s - arc->duration_s);
}

real_t ssv_arc_speed(const ssv_arc_t* arc, real_t t_s) {
    SSV_ASSERT(!(t_s < REAL(0)) && !(arc->v_start < REAL(0)) && !(arc->v_end < REAL(0)));
    const real_t v = ssv_arc_speed_free(arc, t_s);
    return real_max(real_min(arc->v_start, arc->v_end), real_min(real_max(arc->v_start, arc->v_end), v));
}

ssv_moments_t ssv_arc_moments(const ssv_arc_t* arc, real_t v_from, real_t v_to, real_t time_s) {
    return ssv_moments_over(arc->dv_dt, v_from, v_to, time_s);
}

void ssv_arc_thrust(const ssv_thrusts_t* thrusts, const ssv_arc_t* arc, int i, real_t c[3]) {
    SSV_ASSERT(i >= 0 && i < N);
    const real_t A = thrusts->accel[i];
    c[0] = real_mul(A, arc->dv_dt[0]);
    c[1] = real_mul(A, arc->dv_dt[1]) + thrusts->linear[i];
    c[2] = real_mul(A, arc->dv_dt[2]) + thrusts->quadratic[i];
}

// ---- The leg and its ramps ----

// A leg in its own units, and what is decided of it so far.
typedef struct {
    ssv_units_t unit;
    ssv_thrusts_t thrusts;
    ssv_switching_t switching;
    real_t distance, cutoff, top_speed;
    ssv_speed_arc_t arc[MAX_RAMP_ARCS]; // of the ramp up from the front, of the ramp that slows from the back
    ssv_ramp_table_t up, slow;
    real_t peak, cruise_distance;
    ssv_speed_arc_t cruise_arc;
    // What the ramp up to up_peak costs, and its length.
    real_t up_peak, up_length;
    ssv_profile_price_t up_price;
} solved_leg_t;

static void restart(ssv_ramp_table_t* ramp) { ramp->num = 0; }

// Largest speed that every thruster can hold; without drag, the one at the end of the leg under full thrust.
static real_t top_speed_of(const solved_leg_t* leg) {
    const ssv_thruster_groups_t* groups = &leg->switching.groups;
    const real_t terminal = ssv_terminal_speed(&leg->thrusts, ENDLESS_SPEED);
    if (terminal < ENDLESS_SPEED) return terminal - real_mul(TERMINAL_MARGIN, terminal);
    real_t limit = groups->limit[0];
    for (int k = 1; k < groups->num; k++) limit = real_min(limit, groups->limit[k]);
    return real_sqrt(real_mul(REAL(2), real_mul(limit, leg->distance)));
}

static ssv_outcome_t begin(const ssv_thrusts_t* thrusts, const ssv_rule_t* rule, real_t distance, solved_leg_t* leg) {
    SSV_ASSERT(distance > REAL(0) && !(rule->cutoff < REAL(0)) && !(rule->speed_max < REAL(0)));
    SSV_ASSERT(!(rule->weight_time_per_s < REAL(0)) && !(rule->weight_impulse_per_Ns < REAL(0)));
    const bool optimal = rule->ramp == SSV_OPTIMAL;
    const real_t weight_impulse = optimal ? rule->weight_impulse_per_Ns : REAL(0);
    const real_t weight_time = real_max(rule->weight_time_per_s, real_mul(SSV_TIME_PRICE_MIN_N, weight_impulse));
    if (!ssv_thrusts_scale(thrusts, weight_time, weight_impulse, distance, &leg->unit, &leg->thrusts))
        return SSV_NO_AUTHORITY;
    if (!ssv_thruster_groups_of(&leg->thrusts, &leg->switching.groups)) return SSV_NO_AUTHORITY;
    leg->distance = real_scale(distance, -leg->unit.length);
    leg->cutoff = real_scale(rule->cutoff, -leg->unit.speed);
    leg->switching.weight_time = weight_time;
    leg->switching.weight_impulse = real_scale(weight_impulse, leg->unit.force);
    leg->top_speed = top_speed_of(leg);
    if (rule->speed_max > REAL(0)) {
        leg->top_speed = real_min(leg->top_speed, real_scale(rule->speed_max, -leg->unit.speed));
    }
    leg->up = (ssv_ramp_table_t){.first = &leg->arc[0], .step = 1};
    leg->slow = (ssv_ramp_table_t){.first = &leg->arc[MAX_RAMP_ARCS - 1], .step = -1};
    leg->up_peak = REAL(0);
    return SSV_FEASIBLE;
}

static bool extend(solved_leg_t* leg, ssv_switching_rule_t rule, real_t top_speed, ssv_ramp_table_t* ramp) {
    const int taken = ramp == &leg->up ? leg->slow.num : leg->up.num;
    return ssv_ramp_extend(&leg->switching, rule, top_speed, MAX_RAMP_ARCS - taken, ramp);
}

// The distance that is left to cruise when both ramps are flown up to a peak, and the sizes of the accelerations there:
// a[0] of the ramp up, a[1] of the ramp that slows.
static real_t distance_between_ramps(solved_leg_t* leg, real_t peak, real_t a[2]) {
    const ssv_thruster_groups_t* groups = &leg->switching.groups;
    const real_t ramp_up = ssv_ramp_distance_to(groups, &leg->up, peak, &a[0]);
    return leg->distance - ramp_up - ssv_ramp_distance_to(groups, &leg->slow, peak, &a[1]);
}

// A leg that is so slow that this scalar rounds its speed to nothing takes longer than 2^NO_SPEED_EXPONENT of its own
// units of time. Where that is not longer than the longest plan, only a finer scalar can tell, and the answer is an
// overflow.
static ssv_outcome_t too_slow(const solved_leg_t* leg) {
    if (leg->unit.time + NO_SPEED_EXPONENT < LONGEST_PLAN_EXPONENT) (void)real_div(REAL(1), REAL(0));
    return SSV_TOO_LONG;
}

// ---- The paper's ramps ----

// 1 / (1 / a[0] + 1 / a[1]): a peak that rises by dv makes both ramps together longer by v dv over that.
static real_t both(const real_t a[2]) { return real_mul(a[0], real_div(a[1], a[0] + a[1])); }

// The first switch speed of a ramp on the way from one speed to another, else the other speed.
static real_t next_switch_speed(const ssv_ramp_table_t* ramp, real_t from, real_t to) {
    for (int k = 0; k < ramp->num; k++) {
        const real_t v = ssv_ramp_arc(ramp, k)->v_high;
        if ((from < v && v < to) || (to < v && v < from)) to = v;
    }
    return to;
}

// The first peak to try: with drag, a ramp is about as long as one of constant acceleration, namely that at some part
// of its peak.
static real_t first_peak(const solved_leg_t* leg, real_t top_speed) {
    const ssv_thruster_groups_t* groups = &leg->switching.groups;
    real_t peak = REAL(0);
    for (int n = 0; n < NUM_PEAK_GUESSES; n++) {
        const real_t typical = real_mul(TYPICAL_PART, peak);
        const real_t a[2] = {ssv_ramp_acceleration(groups, &leg->up, typical),
                             ssv_ramp_acceleration(groups, &leg->slow, typical)};
        const real_t constant = real_sqrt(real_mul(REAL(2), real_mul(leg->distance, both(a))));
        peak = real_min(constant, real_mul(FIRST_PEAK_MAX, top_speed));
    }
    return peak;
}

// The peak whose log-odds are larger by dy. The odds of a peak v are v / (whole - v).
static real_t move_log_odds(real_t whole, real_t v, real_t dy) {
    real_t odds = real_div(v, whole - v);
    odds += real_mul(odds, real_expm1(dy));
    return real_div(real_mul(whole, odds), REAL(1) + odds);
}

// Newton's step in the log-odds of the peak, for the root of the distance that the ramps cover.
static real_t newton_step(const solved_leg_t* leg, real_t whole, real_t v, real_t covered, const real_t a[2]) {
    if (!(covered > real_mul(COVERED_MIN, leg->distance))) return LOG_ODDS_STEP_MAX;
    const real_t ratio = real_sqrt(real_div(leg->distance, covered)), lack = real_mul(covered, ratio - REAL(1));
    const real_t per_odds = real_div(real_mul(whole, both(a)), real_mul(v, whole - v));
    const real_t dy = real_mul(REAL(2), real_div(real_mul(lack, per_odds), v));
    return real_max(-LOG_ODDS_STEP_MAX, real_min(LOG_ODDS_STEP_MAX, dy));
}

// Finds the peak at which both ramps together cover the leg to within PEAK_TOLERANCE. At the top speed they cover more,
// by -leg->cruise_distance.
//
// It is Newton's method in coordinates that make the ramps' length nearly straight. Without drag the root of the
// distance is linear in the peak; on a coast the distance goes with the logarithm of the peak; close to a terminal
// speed it goes with the logarithm of what the peak lacks of that speed. The root of the distance over the log-odds of
// the peak follows all three. Where Newton leaves the bracket, a straight line through its ends takes over. No step
// goes past a switch speed, where the slope leaps, and if that takes long every other step halves the bracket.
static void meet(solved_leg_t* leg, real_t top_speed) {
    const real_t D = leg->distance, whole = top_speed + real_mul(ODDS_HEADROOM, top_speed);
    ssv_root_t root = ssv_root_between(D, REAL(0), REAL(0), top_speed, D - leg->cruise_distance);
    real_t next = first_peak(leg, top_speed), v, a[2];
    for (int n = 0; n < MAX_PEAK_STEPS; n++) {
        v = next;
        leg->cruise_distance = distance_between_ramps(leg, v, a);
        if (real_abs(leg->cruise_distance) <= real_mul(PEAK_TOLERANCE, D)) break;
        const real_t covered = D - leg->cruise_distance;
        ssv_root_tell(&root, v, covered);
        next = move_log_odds(whole, v, newton_step(leg, whole, v, covered, a));
        if (!ssv_root_is_inside(&root, next) && root.low > REAL(0)) {
            const real_t low_odds = real_div(root.low, whole - root.low);
            const real_t ratio = real_div(real_div(root.high, whole - root.high), low_odds);
            const real_t dy = real_mul(real_log1p(ratio - REAL(1)), ssv_root_share(&root));
            next = move_log_odds(whole, root.low, dy);
        }
        const bool creeps = n >= NUM_FREE_STEPS && n % 2 == 0;
        if (creeps || !ssv_root_is_inside(&root, next)) next = ssv_root_middle(&root);
        next = next_switch_speed(&leg->slow, v, next_switch_speed(&leg->up, v, next));
    }
    leg->peak = v;
    // Only where the distance leaps is the tolerance not met. Then the peak is that below the leap, and the rest is
    // cruised.
    if (leg->cruise_distance < -real_mul(PEAK_TOLERANCE, D)) {
        leg->peak = root.low;
        leg->cruise_distance = distance_between_ramps(leg, leg->peak, a);
    }
}

// A leg with one of the paper's ramps. Where both are asked for, the ramp up of the first serves the second.
static ssv_outcome_t solve_paper(solved_leg_t* leg, ssv_ramp_t ramp) {
    const ssv_thruster_groups_t* groups = &leg->switching.groups;
    const real_t top_speed = leg->top_speed;
    const real_t reverse_from = ramp == SSV_DRAG_ONLY ? real_min(leg->cutoff, top_speed) : top_speed;
    restart(&leg->slow);
    if (leg->up.num == 0) {
        ssv_switching_up_to(&leg->switching, top_speed);
        if (!extend(leg, SSV_SPEED_UP, top_speed, &leg->up)) return SSV_TOO_MANY_ARCS;
        ssv_ramp_measure(groups, &leg->up);
    }
    if (!extend(leg, SSV_BRAKE, reverse_from, &leg->slow) || !extend(leg, SSV_COAST, top_speed, &leg->slow))
        return SSV_TOO_MANY_ARCS;
    ssv_ramp_keep_slowing(groups, &leg->slow);
    const real_t highest = ssv_ramp_top_speed(&leg->slow);
    if (highest < top_speed && highest <= reverse_from) return SSV_NO_AUTHORITY;
    ssv_ramp_measure(groups, &leg->slow);
    real_t a[2];
    if (!(highest > REAL(0))) return too_slow(leg);
    leg->peak = highest;
    leg->cruise_distance = distance_between_ramps(leg, highest, a);
    if (leg->cruise_distance < REAL(0)) meet(leg, highest);
    return SSV_FEASIBLE;
}

// ---- The optimal leg ----

// Whether drag only ever resists: then nothing but full thrust speeds up best.
static bool always_resists(const ssv_thruster_groups_t* groups) {
    for (int k = 0; k < groups->num; k++) {
        if (groups->linear[k] > REAL(0) || groups->quadratic[k] > REAL(0)) return false;
    }
    return true;
}

// Decides which coast arcs differ from the cruise. That is done once for a leg, at about its peak: the conditions with
// and without a coast arc differ a little, and a peak between the two would meet neither.
static void decide_coasts(solved_leg_t* leg, real_t peak) {
    ssv_switching_t* s = &leg->switching;
    const real_t rate = s->weight_time + real_mul(s->weight_impulse, ssv_cruise_thrust(&leg->thrusts, peak));
    ssv_switching_up_to(s, peak);
    for (int k = 0; k < s->groups.num; k++) {
        const real_t cost = real_mul(s->weight_impulse, real_mul(s->groups.weight[k], s->size[k]));
        const bool slows = real_mul(s->size[k], leg->distance) > real_mul(COAST_SLOWS_MIN, real_sq(peak));
        s->coasts[k] = slows && cost > real_mul(COAST_COST_MIN, rate);
    }
}

// Both ramps from rest to the peak, with the marginal cost of distance that makes this peak the right one; the distance
// left between them is cruised. A ramp up of full thrust, which no marginal cost changes, is kept once it is there.
static bool min_cost_ramps(solved_leg_t* leg, real_t peak, real_t a[2]) {
    ssv_switching_t* s = &leg->switching;
    const bool resists = always_resists(&s->groups);
    ssv_switching_up_to(s, peak);
    leg->peak = peak;
    restart(&leg->slow);
    if (ssv_ramp_top_speed(&leg->up) < peak || !resists) {
        restart(&leg->up);
        if (!extend(leg, resists ? SSV_SPEED_UP : SSV_MIN_COST_UP, peak, &leg->up)) return false;
        ssv_ramp_measure(&s->groups, &leg->up);
    }
    if (!extend(leg, SSV_MIN_COST_SLOW, peak, &leg->slow)) return false;
    ssv_ramp_measure(&s->groups, &leg->slow);
    leg->cruise_distance = distance_between_ramps(leg, peak, a);
    return true;
}

// How far to cruise at this peak before a higher one is worth its longer ramps. They end at accelerations a[0] and
// -a[1]. With C(a) = L(v, a) - lambda v, a higher peak changes the price by
//   dJ / d peak = C / a of both ramps + time of the cruise * (d L(v, 0) / dv - lambda).
// In the first term only groups count that idle between the two accelerations, closer to the cruise than the ramp that
// ends on their side; a ramp that ends on a bang arc passes only the coasts that count as the cruise. Of the second
// term the price of time and the bend of the drag remain, all else cancels.
static real_t least_cruise(const solved_leg_t* leg, real_t peak, const real_t a[2]) {
    const ssv_switching_t* s = &leg->switching;
    const ssv_thrusts_t* t = &leg->thrusts;
    const real_t most = real_mul(ENDLESS_CRUISE, leg->distance);
    real_t kink = REAL(0), bend = REAL(0);
    for (int k = 0; k < s->groups.num; k++) {
        const real_t idle = real_mul(peak, s->groups.linear[k] + real_mul(peak, s->groups.quadratic[k]));
        const real_t size = real_abs(idle), ramp_end = idle > REAL(0) ? a[0] : a[1];
        if (!ssv_ramp_ends_coasting(idle > REAL(0) ? &leg->up : &leg->slow)) {
            kink += s->coasts[k] ? REAL(0) : s->groups.weight[k];
        } else if (size < ramp_end) {
            kink += real_mul(s->groups.weight[k], REAL(1) - real_div(size, ramp_end));
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

// A long leg cruises at the cheapest speed. A short one has the peak whose ramps just cover it. From an estimate, that
// peak is the root of the covered share, whose square root is nearly linear in the peak. The search aims a little short
// of the leg, and the rest is cruised.
static ssv_outcome_t solve_optimal(solved_leg_t* leg) {
    const ssv_switching_t* s = &leg->switching;
    real_t cruise_speed = ssv_cruise_speed(&leg->thrusts, s->weight_time, s->weight_impulse, leg->top_speed);
    real_t price, peak = cruise_speed, a[2];
    // A coast from a speed at which some drag turns would never leave it.
    if (cruise_speed < leg->top_speed) cruise_speed -= real_mul(TERMINAL_MARGIN, cruise_speed);
    (void)ssv_profile_estimate(&leg->thrusts, s->weight_time, s->weight_impulse, leg->distance, REAL(0),
                               SSV_ESTIMATE_CLOSELY, &price, &peak);
    if (peak > real_mul(NEAR_CRUISE, cruise_speed)) peak = cruise_speed;
    decide_coasts(leg, peak);
    ssv_root_t root = ssv_root_from(REAL(0), REAL(0), -REAL(1), cruise_speed);
    for (int n = 0; n < MAX_PEAK_STEPS; n++) {
        if (!(peak > REAL(0))) return too_slow(leg);
        if (!min_cost_ramps(leg, peak, a)) return SSV_TOO_MANY_ARCS;
        const real_t least = least_cruise(leg, peak, a);
        const real_t share = real_div(leg->distance - leg->cruise_distance + least, leg->distance);
        const real_t covered = real_sqrt(share), miss = covered - REAL(1) + SHORTFALL;
        const bool meets = peak == cruise_speed ? leg->cruise_distance >= least : real_abs(miss) <= SHORTFALL;
        if (leg->cruise_distance >= REAL(0) && meets) return SSV_FEASIBLE;
        ssv_root_tell_illinois(&root, peak, miss);
        if (!root.bracketed) {
            peak = real_min(cruise_speed, real_mul(OVERSHOOT, real_div(peak, covered)));
        } else {
            if (ssv_root_is_exhausted(&root)) break;
            peak = ssv_root_propose(&root);
        }
    }
    if (!(root.low > REAL(0))) return too_slow(leg);
    return min_cost_ramps(leg, root.low, a) ? SSV_FEASIBLE : SSV_TOO_MANY_ARCS;
}

static ssv_outcome_t solve(solved_leg_t* leg, ssv_ramp_t ramp) {
    // Where only time counts, full thrust and full reverse are optimal.
    const bool min_cost = ramp == SSV_OPTIMAL && leg->switching.weight_impulse > REAL(0);
    const ssv_outcome_t outcome = min_cost ? solve_optimal(leg) : solve_paper(leg, ramp);
    if (outcome != SSV_FEASIBLE) return outcome;
    if (leg->cruise_distance < real_mul(CRUISE_MIN, leg->distance)) leg->cruise_distance = REAL(0);
    return SSV_FEASIBLE;
}

// ---- What it costs ----

// Integral over time of |c[0] + c[1] v + c[2] v^2| on an arc.
static real_t integral_of_size(const real_t dv_dt[3], const ssv_speed_arc_t* arc, const real_t c[3], real_t nothing) {
    const ssv_moments_t* m = &arc->m;
    const real_t whole = real_mul(c[0], m->time) + real_mul(c[1], m->distance) + real_mul(c[2], m->speed2);
    if (ssv_quadratic_keeps_sign(c, arc->v_low, arc->v_high)) return real_abs(whole);
    real_t from = arc->v_low, before = REAL(0), sum = REAL(0);
    for (int k = 0; k < 2 && ssv_quadratic_size(c, arc->v_high) > nothing; k++) { // at most two changes of sign
        const real_t root = ssv_quadratic_root_after(c, from, arc->v_high);
        if (root >= arc->v_high) break;
        const ssv_moments_t below = ssv_ramp_integrals(dv_dt, arc->v_low, root);
        const real_t part = real_mul(c[0], below.time) + real_mul(c[1], below.distance) + real_mul(c[2], below.speed2);
        sum += real_abs(part - before);
        before = part;
        from = root;
    }
    return sum + real_abs(whole - before);
}

static real_t impulse_of(const solved_leg_t* leg, const real_t dv_dt[3], const ssv_speed_arc_t* arc) {
    const ssv_thruster_groups_t* groups = &leg->switching.groups;
    const real_t nothing = real_mul(NO_THRUST, leg->thrusts.force_max_N);
    real_t sum = REAL(0);
    for (int k = 0; k < groups->num; k++) {
        const real_t c[3] = {real_mul(groups->weight[k], dv_dt[0]),
                             real_mul(groups->weight[k], dv_dt[1] - groups->linear[k]),
                             real_mul(groups->weight[k], dv_dt[2] - groups->quadratic[k])};
        sum += integral_of_size(dv_dt, arc, c, nothing);
    }
    for (int k = 0; k < groups->num_passive; k++) {
        const real_t c[3] = {REAL(0), groups->passive_linear[k], groups->passive_quadratic[k]};
        sum += integral_of_size(dv_dt, arc, c, nothing);
    }
    return sum;
}

// An arc as it is flown, in the leg's units.
typedef struct {
    const ssv_speed_arc_t* arc;
    real_t dv_dt[3], impulse;
    bool falls; // from v_high to v_low
} flown_arc_t;

static int num_flown_arcs(const solved_leg_t* leg) {
    return leg->up.last + 1 + (leg->cruise_distance > REAL(0) ? 1 : 0) + leg->slow.last + 1;
}

// The cruise is the singular arc of the leg: dv/dt is zero, and no thruster need be bound.
static void take_cruise(solved_leg_t* leg, flown_arc_t* flown) {
    const real_t time = real_div(leg->cruise_distance, leg->peak);
    leg->cruise_arc.v_low = leg->cruise_arc.v_high = leg->peak;
    leg->cruise_arc.m = (ssv_moments_t){time, leg->cruise_distance, real_mul(leg->cruise_distance, leg->peak)};
    flown->arc = &leg->cruise_arc;
    flown->dv_dt[0] = flown->dv_dt[1] = flown->dv_dt[2] = REAL(0);
    flown->impulse = real_mul(time, ssv_cruise_thrust(&leg->thrusts, leg->peak));
}

// Arc n of the leg: those of the ramp up, the cruise if there is one, those of the slowing ramp from its peak down.
static void take_arc(solved_leg_t* leg, int n, flown_arc_t* flown) {
    SSV_ASSERT(n >= 0 && n < num_flown_arcs(leg));
    const int from_end = num_flown_arcs(leg) - 1 - n;
    flown->falls = from_end <= leg->slow.last;
    if (n > leg->up.last && !flown->falls) {
        take_cruise(leg, flown);
        return;
    }
    flown->arc = flown->falls ? ssv_ramp_flown_arc(&leg->slow, from_end) : ssv_ramp_flown_arc(&leg->up, n);
    ssv_ramp_dv_dt(&leg->switching.groups, flown->arc->arc_id, flown->dv_dt);
    flown->impulse = impulse_of(leg, flown->dv_dt, flown->arc);
}

// Adds an arc to the price, and to the profile unless that is NULL, in SI units. It begins at the distance `from` along
// the leg, in the leg's units.
static void append(const solved_leg_t* leg, const flown_arc_t* flown, real_t from, ssv_profile_price_t* price,
                   ssv_profile_t* profile) {
    const ssv_units_t* unit = &leg->unit;
    const real_t low = real_scale(flown->arc->v_low, unit->speed), high = real_scale(flown->arc->v_high, unit->speed);
    const real_t duration_s = real_scale(flown->arc->m.time, unit->time);
    if (profile != NULL) {
        SSV_ASSERT(profile->num_arcs < SSV_MAX_PROFILE_ARCS);
        ssv_arc_t* arc = &profile->arc[profile->num_arcs++];
        *arc = (ssv_arc_t){.t_s = price->duration_s,
                           .duration_s = duration_s,
                           .s = real_scale(from, unit->length),
                           .v_start = flown->falls ? high : low,
                           .v_end = flown->falls ? low : high};
        for (int n = 0; n < 3; n++) {
            arc->dv_dt[n] = real_scale(flown->dv_dt[n], unit->speed - unit->time - n * unit->speed);
        }
    }
    price->duration_s += duration_s;
    price->impulse_Ns += real_scale(flown->impulse, unit->time + unit->force);
}

static ssv_profile_price_t finish(solved_leg_t* leg, ssv_outcome_t outcome, ssv_profile_t* profile) {
    ssv_profile_price_t price = {outcome, REAL(0), REAL(0), REAL(0)};
    if (outcome != SSV_FEASIBLE) return price;
    price.peak_speed = real_scale(leg->peak, leg->unit.speed);
    real_t from = REAL(0);
    int n = 0;
    if (profile == NULL && leg->up_peak == leg->peak) { // priced with the other of the paper's ramps
        price = leg->up_price;
        from = leg->up_length;
        n = leg->up.last + 1;
    }
    for (; n < num_flown_arcs(leg); n++) {
        flown_arc_t flown;
        take_arc(leg, n, &flown);
        const bool endless = real_exponent(flown.arc->m.time) + leg->unit.time > LONGEST_ARC_EXPONENT;
        price.outcome = endless ? SSV_TOO_LONG : SSV_FEASIBLE;
        if (price.outcome == SSV_FEASIBLE) append(leg, &flown, from, &price, profile);
        from += flown.arc->m.distance;
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
    solved_leg_t leg;
    const ssv_outcome_t outcome = begin(thrusts, rule, distance, &leg);
    return finish(&leg, outcome == SSV_FEASIBLE ? solve(&leg, rule->ramp) : outcome, NULL);
}

ssv_outcome_t ssv_profile_solve(const ssv_thrusts_t* thrusts, const ssv_rule_t* rule, real_t distance,
                                ssv_profile_t* profile) {
    solved_leg_t leg;
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
    solved_leg_t leg;
    ssv_rule_t paper = *rule;
    paper.ramp = SSV_FULL_REVERSE;
    const ssv_outcome_t outcome = begin(thrusts, &paper, distance, &leg);
    *full_reverse = finish(&leg, outcome == SSV_FEASIBLE ? solve(&leg, SSV_FULL_REVERSE) : outcome, NULL);
    *drag_only = finish(&leg, outcome == SSV_FEASIBLE ? solve(&leg, SSV_DRAG_ONLY) : outcome, NULL);
}
