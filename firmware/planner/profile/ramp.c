// Switching rules: which arc holds at which speed, and the table of arcs that makes a ramp.
#include "planner/profile/ramp.h"

#include "planner/math/assert.h"
#include "planner/profile/tolerance.h"

// ---- Arcs by their ids ----

// An arc's id says which group of thrusters is bound, and to what: its limit backwards, no thrust, or its limit
// forwards. SIDES is a power of two, which is quick to divide by.
enum { BACKWARDS = 0, IDLE = 1, FORWARDS = 2, SIDES = 4 };

static int id_of(int group, int side) { return SIDES * group + side; }
static int group_of(int arc_id) { return (int)((unsigned)arc_id / SIDES); }
static int side_of(int arc_id) { return (int)((unsigned)arc_id % SIDES); }
static bool is_coast(int arc_id) { return side_of(arc_id) == IDLE; }

static real_t pull_of(const ssv_thruster_groups_t* groups, int arc_id) {
    const real_t limit = groups->limit[group_of(arc_id)];
    return is_coast(arc_id) ? REAL(0) : side_of(arc_id) == FORWARDS ? limit : -limit;
}

void ssv_ramp_dv_dt(const ssv_thruster_groups_t* groups, int arc_id, real_t dv_dt[3]) {
    SSV_ASSERT(arc_id >= 0 && group_of(arc_id) < groups->num && side_of(arc_id) <= FORWARDS);
    dv_dt[0] = pull_of(groups, arc_id);
    dv_dt[1] = groups->linear[group_of(arc_id)];
    dv_dt[2] = groups->quadratic[group_of(arc_id)];
}

void ssv_switching_up_to(ssv_switching_t* s, real_t top_speed) {
    SSV_ASSERT(!(top_speed < REAL(0)));
    s->top_speed = top_speed;
    for (int k = 0; k < s->groups.num; k++) {
        const real_t steepest = real_abs(s->groups.linear[k]) + real_mul(top_speed, real_abs(s->groups.quadratic[k]));
        s->size[k] = real_mul(top_speed, steepest);
    }
}

// dv/dt on arc a less that on arc b, as a quadratic. @return how much of it may be rounding.
static real_t difference(const ssv_switching_t* s, int a, int b, real_t d[3]) {
    const int i = group_of(a), j = group_of(b);
    const real_t a0 = pull_of(&s->groups, a), b0 = pull_of(&s->groups, b);
    d[0] = a0 - b0;
    d[1] = s->groups.linear[i] - s->groups.linear[j];
    d[2] = s->groups.quadratic[i] - s->groups.quadratic[j];
    return real_mul(SAME_ACCELERATION, real_abs(a0) + s->size[i] + real_abs(b0) + s->size[j]);
}

// Sign of dv/dt on arc a less that on arc b just beyond speed v: by value, then slope, then curvature, each only if it
// is more than rounding. The arcs of thrusters that mirror each other often agree at v and part later.
static int compare(const ssv_switching_t* s, int a, int b, real_t v) {
    real_t d[3];
    const real_t noise = difference(s, a, b, d);
    real_t first = ssv_quadratic_at(d, v);
    if (real_abs(first) <= noise) {
        first = real_mul(s->top_speed, d[1] + real_mul(REAL(2), real_mul(d[2], v)));
        if (real_abs(first) <= noise) first = real_mul(d[2], real_sq(s->top_speed));
        if (real_abs(first) <= noise) return 0;
    }
    return first > REAL(0) ? 1 : -1;
}

// The bang arc of the tightest limit just beyond speed v.
static int tightest_limit(const ssv_switching_t* s, int side, real_t v) {
    const int tighter = side == FORWARDS ? -1 : 1;
    int best = id_of(0, side);
    for (int k = 1; k < s->groups.num; k++) {
        if (compare(s, id_of(k, side), best, v) == tighter) best = id_of(k, side);
    }
    return best;
}

// ---- The paper's switching rules ----

// Total weight of the groups whose idle acceleration is at or below that of an arc, just beyond speed v.
static real_t weight_below(const ssv_switching_t* s, int arc_id, real_t v) {
    real_t sum = REAL(0);
    for (int k = 0; k < s->groups.num; k++) {
        const int idle = id_of(k, IDLE);
        if (idle == arc_id || compare(s, idle, arc_id, v) <= 0) sum += s->groups.weight[k];
    }
    return sum;
}

// The arc of the least total thrust. The sum of |u_i| is convex and piecewise linear in the acceleration, with a kink
// of height |accel_i| where u_i = 0, so the minimum lies at the weighted median of the kinks. Of equal ones the
// stronger braking is taken.
static int coast_arc(const ssv_switching_t* s, real_t v) {
    const real_t half = real_mul(REAL(0.5) - SAME_ACCELERATION, s->groups.total);
    const int limit = tightest_limit(s, BACKWARDS, v);
    if (weight_below(s, limit, v) >= half) return limit;
    int best = SSV_NO_ARC;
    for (int k = 0; k < s->groups.num; k++) {
        if (best != SSV_NO_ARC && compare(s, id_of(k, IDLE), best, v) >= 0) continue;
        if (weight_below(s, id_of(k, IDLE), v) >= half) best = id_of(k, IDLE);
    }
    SSV_ASSERT(best != SSV_NO_ARC);
    return best;
}

static int paper_arc(const ssv_switching_t* s, ssv_switching_rule_t rule, real_t v) {
    return rule == SSV_COAST ? coast_arc(s, v) : tightest_limit(s, rule == SSV_SPEED_UP ? FORWARDS : BACKWARDS, v);
}

// First speed in (from, to) at which the order of the arcs may change: a limit crosses this arc, or with `idles` an
// idle curve does, or a passive thruster changes its sign; else to.
static real_t next_breakpoint(const ssv_switching_t* s, int side, bool idles, int arc_id, real_t from, real_t to) {
    real_t next = to, d[3];
    for (int k = 0; k < s->groups.num; k++) {
        const int rival[2] = {id_of(k, side), id_of(k, IDLE)};
        for (int n = 0; n < (idles ? 2 : 1); n++) {
            if (rival[n] == arc_id) continue;
            const real_t noise = difference(s, rival[n], arc_id, d);
            // What was equal to compare() is made equal here, else rounding could hide that the two cross.
            const real_t here = ssv_quadratic_at(d, from - real_mul(SWITCH_SPACING, s->top_speed));
            if (!idles && real_abs(here) <= noise) d[0] -= here;
            if (ssv_quadratic_keeps_sign(d, from, next)) continue;
            if (ssv_quadratic_size(d, to) > noise) next = ssv_quadratic_root_after(d, from, next);
        }
    }
    for (int k = 0; idles && k < s->groups.num_passive; k++) {
        const real_t drag[3] = {REAL(0), s->groups.passive_linear[k], s->groups.passive_quadratic[k]};
        next = ssv_quadratic_root_after(drag, from, next);
    }
    return next;
}

// ---- The minimum-cost switching rules ----

// C(a) = L(v, a) - lambda v is what a second at acceleration a costs, less what the distance flown in it is worth. The
// optimality conditions ask at each speed for the acceleration with the least C(a) / |a|: for the place where a line
// from the origin touches C, which DESIGN.md 5 draws. C is convex and made of straight segments, which join in kinks
// where some thruster idles and end at the limit. So the line touches at a kink (a coast arc) or at the limit (a bang
// arc). Two tests tell whether it touches at a given kink: the segment on the inner side of the kink, drawn on to a =
// 0, must arrive at or above zero, and the segment on the outer side at or below. A test that fails says on which side
// to look. This is an active-set method: it steps from kink to kink until both tests hold. To compare the ratios of the
// kinks instead would let rounding pick one among those that are nearly equal.
enum { INWARDS = 0, OUTWARDS = 1 }; // towards a = 0, towards the limit

// Adds one thruster to a segment's value at a = 0: what the thruster costs there less what it costs in a cruise at the
// top speed, which is its part of lambda. The difference is taken thruster by thruster, because of the two totals all
// but the price of time cancels. A thruster is positive on the segment if its thrust has the sign of its accel.
static void add_cost(const ssv_switching_t* s, real_t weight, real_t linear, real_t quadratic, bool positive,
                     real_t line[3]) {
    const real_t cost = real_mul(s->weight_impulse, weight), bend = real_mul(s->top_speed, quadratic);
    const bool positive_in_cruise = linear + bend < REAL(0);
    const real_t slope = positive == positive_in_cruise ? bend : bend + real_mul(REAL(2), linear);
    line[1] += real_mul(positive_in_cruise ? cost : -cost, slope);
    line[2] -= real_mul(positive ? cost : -cost, quadratic);
}

// The values at a = 0 of the two segments that join at an arc's acceleration. While no thruster changes its sign they
// are quadratics in the speed; `mid` is a speed at which the signs are those asked for. The outer one is negated, so
// that the arc holds where neither is below zero.
static void tangents(const ssv_switching_t* s, bool up, int arc_id, real_t mid, real_t line[2][3]) {
    const ssv_thruster_groups_t* groups = &s->groups;
    real_t c[3];
    ssv_ramp_dv_dt(groups, arc_id, c);
    const real_t a = ssv_quadratic_at(c, mid);
    for (int direction = INWARDS; direction <= OUTWARDS; direction++) {
        line[direction][0] = s->weight_time;
        line[direction][1] = -real_div(s->weight_time, s->top_speed);
        line[direction][2] = REAL(0);
    }
    for (int k = 0; k < groups->num; k++) {
        const real_t thrust = a - real_mul(mid, groups->linear[k] + real_mul(mid, groups->quadratic[k]));
        const bool idles = real_abs(thrust) <= real_mul(IDLE_TOGETHER, real_abs(a));
        // A thruster that idles on the arc has one sign on the inner segment and the other on the outer.
        for (int direction = INWARDS; direction <= OUTWARDS; direction++) {
            const bool positive = idles ? (direction == OUTWARDS) == up : thrust > REAL(0);
            add_cost(s, groups->weight[k], groups->linear[k], groups->quadratic[k], positive, line[direction]);
        }
    }
    for (int k = 0; k < groups->num_passive; k++) {
        const real_t linear = -groups->passive_linear[k], quadratic = -groups->passive_quadratic[k];
        const bool positive = linear + real_mul(quadratic, mid) < REAL(0);
        for (int direction = INWARDS; direction <= OUTWARDS; direction++) {
            add_cost(s, REAL(1), linear, quadratic, positive, line[direction]);
        }
    }
    for (int n = 0; n < 3; n++) line[OUTWARDS][n] = -line[OUTWARDS][n];
}

// The active set: the arc that is bound, and the one left last, to which it does not return at the same speed.
typedef struct {
    int arc_id, left;
} active_set_t;

// Steps to the next arc in a direction at speed v: to a kink short of the limit, or outwards to the limit that is the
// tightest just beyond speed `at`.
// @return false if there is none; then *active is untouched.
static bool step(const ssv_switching_t* s, int side, int direction, real_t at, real_t v, active_set_t* active) {
    const ssv_thruster_groups_t* groups = &s->groups;
    const real_t sign = side == FORWARDS ? REAL(1) : REAL(-1);
    const int limit = tightest_limit(s, side, at);
    real_t c[3];
    ssv_ramp_dv_dt(groups, active->arc_id, c);
    const real_t here = real_mul(sign, ssv_quadratic_at(c, v)), apart = real_mul(IDLE_TOGETHER, here);
    ssv_ramp_dv_dt(groups, limit, c);
    const real_t most = real_mul(sign, ssv_quadratic_at(c, v));
    int next = direction == OUTWARDS ? limit : active->arc_id;
    real_t next_a = direction == OUTWARDS ? most : REAL(0);
    for (int k = 0; k < groups->num; k++) {
        const real_t a = real_mul(sign, real_mul(v, groups->linear[k] + real_mul(v, groups->quadratic[k])));
        if (!s->coasts[k] || a <= REAL(0) || id_of(k, IDLE) == active->left) continue;
        if (direction == OUTWARDS ? a <= here + apart || a >= next_a : a >= here - apart || a <= next_a) continue;
        next = id_of(k, IDLE);
        next_a = a;
    }
    if (next == active->arc_id || next == active->left) return false;
    *active = (active_set_t){next, active->arc_id};
    return true;
}

// The speed in (at, to) at which a test begins to fail, else to. A test that fails from the start, because there is no
// arc to step to, must pass first.
static real_t fails_at(const real_t line[3], real_t at, real_t to) {
    const real_t here = ssv_quadratic_at(line, at), root = ssv_quadratic_root_after(line, at, to);
    if (here < REAL(0)) return ssv_quadratic_root_after(line, root, to);
    // Rounding may put a root that lies at the start a little before it, where it is not found.
    return root == to && here + ssv_quadratic_at(line, to) < REAL(0) ? at : root;
}

#define NO_DIRECTION (-1)

// Brings the active set from the arc that held below speed v (SSV_NO_ARC at rest) to the one that holds above it, and
// tells how far. *next is the speed up to which the arc holds. *direction is where the arc beyond lies, or NO_DIRECTION
// where a breakpoint ended the search and the question is asked again.
static void min_cost_arc(const ssv_switching_t* s, int side, active_set_t* active, real_t v, real_t top_speed,
                         real_t* next, int* direction) {
    const bool up = side == FORWARDS;
    const real_t at =
        real_min(v + real_max(real_mul(SWITCH_SPACING, s->top_speed), real_mul(LOOK_AHEAD, v)), top_speed);
    const int limit = tightest_limit(s, side, at);
    const bool beyond = active->arc_id >= 0 && compare(s, active->arc_id, limit, at) == (up ? 1 : -1);
    if (active->arc_id < 0 || !is_coast(active->arc_id) || beyond) *active = (active_set_t){limit, SSV_NO_ARC};
    real_t line[2][3], to = top_speed;
    for (int n = 0; n < 2 * SSV_NUM_THRUSTERS; n++) {
        to = next_breakpoint(s, side, true, active->arc_id, at, top_speed);
        const real_t mid = real_mul(REAL(0.5), at + to);
        tangents(s, up, active->arc_id, mid, line);
        if (ssv_quadratic_at(line[INWARDS], at) < REAL(0) && step(s, side, INWARDS, at, mid, active)) continue;
        if (!is_coast(active->arc_id)) break; // nothing lies beyond the limit
        if (ssv_quadratic_at(line[OUTWARDS], at) < REAL(0) && step(s, side, OUTWARDS, at, mid, active)) continue;
        break;
    }
    const real_t inwards = fails_at(line[INWARDS], at, to);
    const real_t outwards = is_coast(active->arc_id) ? fails_at(line[OUTWARDS], at, to) : to;
    *next = real_min(inwards, outwards);
    *direction = *next == to ? NO_DIRECTION : inwards < outwards ? INWARDS : OUTWARDS;
}

// ---- Ramps ----

bool ssv_ramp_extend(const ssv_switching_t* s, ssv_switching_rule_t rule, real_t top_speed, int room,
                     ssv_ramp_table_t* ramp) {
    SSV_ASSERT(room >= ramp->num && !(top_speed > s->top_speed));
    const int side = rule == SSV_SPEED_UP || rule == SSV_MIN_COST_UP ? FORWARDS : BACKWARDS;
    real_t v = ssv_ramp_top_speed(ramp), next = v;
    active_set_t active = {SSV_NO_ARC, SSV_NO_ARC};
    for (int n = 0; n < MAX_SWITCHES && v < top_speed; n++) {
        int direction = NO_DIRECTION;
        if (rule == SSV_MIN_COST_UP || rule == SSV_MIN_COST_SLOW) {
            min_cost_arc(s, side, &active, v, top_speed, &next, &direction);
        } else {
            const real_t beyond = v + real_mul(SWITCH_SPACING, s->top_speed);
            active.arc_id = paper_arc(s, rule, v);
            next = next_breakpoint(s, side, rule == SSV_COAST, active.arc_id, beyond, top_speed);
        }
        if (ramp->num > 0 && ssv_ramp_arc(ramp, ramp->num - 1)->arc_id == active.arc_id) {
            ssv_ramp_arc(ramp, ramp->num - 1)->v_high = next;
        } else if (ramp->num == room) {
            return false;
        } else {
            ramp->num++;
            ssv_speed_arc_t* arc = ssv_ramp_arc(ramp, ramp->num - 1);
            arc->arc_id = active.arc_id;
            arc->v_low = v;
            arc->v_high = next;
        }
        v = next;
        active.left = SSV_NO_ARC;
        if (direction != NO_DIRECTION) (void)step(s, side, direction, v, v, &active);
    }
    return v >= top_speed;
}

void ssv_ramp_keep_slowing(const ssv_thruster_groups_t* groups, ssv_ramp_table_t* ramp) {
    for (int k = 0; k < ramp->num; k++) {
        const ssv_speed_arc_t* arc = ssv_ramp_arc(ramp, k);
        real_t c[3];
        ssv_ramp_dv_dt(groups, arc->arc_id, c);
        const bool slows = ssv_quadratic_at(c, arc->v_low) < REAL(0) && ssv_quadratic_at(c, arc->v_high) < REAL(0) &&
                           ssv_quadratic_root_after(c, arc->v_low, arc->v_high) >= arc->v_high;
        if (!slows) ramp->num = k;
    }
}

ssv_moments_t ssv_ramp_integrals(const real_t dv_dt[3], real_t v_low, real_t v_high) {
    const ssv_moments_t m = ssv_moments_between(dv_dt, v_low, v_high);
    return (ssv_moments_t){real_abs(m.time), real_abs(m.distance), real_abs(m.speed2)};
}

void ssv_ramp_measure(const ssv_thruster_groups_t* groups, ssv_ramp_table_t* ramp) {
    real_t c[3];
    for (int k = 0; k < ramp->num; k++) {
        ssv_speed_arc_t* arc = ssv_ramp_arc(ramp, k);
        SSV_ASSERT(arc->v_low == (k == 0 ? REAL(0) : ssv_ramp_arc(ramp, k - 1)->v_high)); // the arcs join
        ssv_ramp_dv_dt(groups, arc->arc_id, c);
        arc->m = ssv_ramp_integrals(c, arc->v_low, arc->v_high);
    }
}

real_t ssv_ramp_acceleration(const ssv_thruster_groups_t* groups, const ssv_ramp_table_t* ramp, real_t v) {
    if (ramp->num == 0) return REAL(0);
    real_t c[3];
    int k = 0;
    while (k + 1 < ramp->num && ssv_ramp_arc(ramp, k)->v_high < v) k++;
    ssv_ramp_dv_dt(groups, ssv_ramp_arc(ramp, k)->arc_id, c);
    return real_abs(ssv_quadratic_at(c, v));
}

real_t ssv_ramp_distance_to(const ssv_thruster_groups_t* groups, ssv_ramp_table_t* ramp, real_t v,
                            real_t* acceleration) {
    if (ramp->num == 0) {
        ramp->last = -1;
        ramp->partial = (ssv_speed_arc_t){.arc_id = SSV_NO_ARC};
        *acceleration = REAL(0);
        return REAL(0);
    }
    SSV_ASSERT(!(v < REAL(0)) && !(v > ssv_ramp_top_speed(ramp)));
    real_t distance = REAL(0), c[3];
    int k = 0;
    for (; k + 1 < ramp->num && ssv_ramp_arc(ramp, k)->v_high < v; k++) distance += ssv_ramp_arc(ramp, k)->m.distance;
    ramp->last = k;
    ramp->partial = *ssv_ramp_arc(ramp, k);
    ssv_ramp_dv_dt(groups, ramp->partial.arc_id, c);
    *acceleration = real_abs(ssv_quadratic_at(c, v));
    if (v != ramp->partial.v_high) {
        ramp->partial.v_high = v;
        ramp->partial.m = ssv_ramp_integrals(c, ramp->partial.v_low, v);
    }
    return distance + ramp->partial.m.distance;
}

bool ssv_ramp_ends_coasting(const ssv_ramp_table_t* ramp) { return ramp->last >= 0 && is_coast(ramp->partial.arc_id); }
