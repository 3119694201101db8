// The price of a leg is a function of the marginal cost of distance lambda: J = lambda D + G(lambda), where G(lambda)
// is the least integral of L - lambda v over a ramp up and a ramp down. Around the right lambda J is flat. So a guess
// of the peak speed will do, and so will few points of quadrature.
#include "planner/profile/estimate.h"

#include "planner/math/assert.h"
#include "planner/math/gauss.h"
#include "planner/profile/tolerance.h"
#include "ssv/scenario.h"

#define N SSV_NUM_THRUSTERS

typedef struct {
    ssv_thruster_groups_t groups;
    real_t weight_time, weight_impulse;
} estimated_leg_t;

// A change of speed: its cost rate C = L(v, a) - lambda v, and the size of its acceleration.
typedef struct {
    real_t cost, a;
} change_t;

// The change with the least C / |a| on one side, up to the limit or down to it. It is at that limit or at a kink, where
// some thruster idles. C_rest is the part of C that does not depend on the acceleration.
static change_t cheapest_change(const estimated_leg_t* leg, const real_t idle[N], real_t C_rest, real_t limit) {
    SSV_ASSERT(limit != REAL(0));
    change_t best = {REAL(0), REAL(0)};
    const bool up = limit > REAL(0);
    for (int j = -1; j < leg->groups.num; j++) {
        const real_t a = j < 0 ? limit : idle[j], size = real_abs(a);
        if (j >= 0 && (up ? a <= REAL(0) || a >= limit : a >= REAL(0) || a <= limit)) continue;
        real_t sum = REAL(0);
        for (int k = 0; k < leg->groups.num; k++) sum += real_mul(leg->groups.weight[k], real_abs(a - idle[k]));
        const real_t cost = C_rest + real_mul(leg->weight_impulse, sum);
        if (j < 0 || real_mul(cost, best.a) < real_mul(best.cost, size)) best = (change_t){cost, size};
        if (!(leg->weight_impulse > REAL(0))) break; // only time counts
    }
    return best;
}

// G for ramps up to this peak, lambda being right for it, and the distance that they take.
static real_t ramps(const estimated_leg_t* leg, real_t peak, real_t lambda, real_t* distance) {
    const ssv_thruster_groups_t* groups = &leg->groups;
    real_t sum = REAL(0), covered = REAL(0);
    for (int n = 0; n < GAUSS_3_POINTS; n++) {
        const real_t v = real_mul(peak, gauss_3[n].node);
        real_t idle[N], up = REAL(0), down = REAL(0), passive = REAL(0);
        for (int k = 0; k < groups->num; k++) {
            idle[k] = real_mul(v, groups->linear[k] + real_mul(groups->quadratic[k], v));
            up = k == 0 ? idle[k] + groups->limit[k] : real_min(up, idle[k] + groups->limit[k]);
            down = k == 0 ? idle[k] - groups->limit[k] : real_max(down, idle[k] - groups->limit[k]);
        }
        if (!(up > REAL(0)) || !(down < REAL(0))) continue; // rounding next to the terminal speed
        for (int k = 0; k < groups->num_passive; k++) {
            passive += real_abs(groups->passive_linear[k] + real_mul(groups->passive_quadratic[k], v));
        }
        const real_t C_rest =
            leg->weight_time - real_mul(lambda, v) + real_mul(leg->weight_impulse, real_mul(passive, v));
        const change_t faster = cheapest_change(leg, idle, C_rest, up),
                       slower = cheapest_change(leg, idle, C_rest, down);
        const real_t per_faster = real_div(gauss_3[n].weight, faster.a);
        const real_t per_slower = real_div(gauss_3[n].weight, slower.a);
        sum += real_mul(faster.cost, per_faster) + real_mul(slower.cost, per_slower);
        covered += real_mul(v, per_faster + per_slower);
    }
    *distance = real_mul(peak, covered);
    return real_mul(peak, sum);
}

bool ssv_profile_estimate(const ssv_thrusts_t* thrusts_SI, real_t weight_time_per_s, real_t weight_impulse_per_Ns,
                          real_t distance_SI, real_t speed_max, real_t closeness, real_t* price, real_t* peak_speed) {
    SSV_ASSERT(distance_SI > REAL(0) && !(weight_time_per_s < REAL(0)) && !(weight_impulse_per_Ns < REAL(0)));
    estimated_leg_t leg;
    ssv_units_t unit;
    ssv_thrusts_t thrusts;
    leg.weight_time = real_max(weight_time_per_s, real_mul(SSV_TIME_PRICE_MIN_N, weight_impulse_per_Ns));
    if (!ssv_thrusts_scale(thrusts_SI, leg.weight_time, weight_impulse_per_Ns, distance_SI, &unit, &thrusts))
        return false;
    leg.weight_impulse = real_scale(weight_impulse_per_Ns, unit.force);
    const real_t distance = real_scale(distance_SI, -unit.length);
    if (!ssv_thruster_groups_of(&thrusts, &leg.groups)) return false;
    real_t limit = leg.groups.limit[0];
    for (int k = 1; k < leg.groups.num; k++) limit = real_min(limit, leg.groups.limit[k]);
    // Without drag no speed is above that which full thrust reaches in the middle of the leg.
    const real_t free_top = real_sqrt(real_mul(limit, distance));
    const real_t terminal = ssv_terminal_speed(&thrusts, free_top);
    real_t top = terminal < free_top ? real_mul(BELOW_TERMINAL, terminal) : free_top;
    if (speed_max > REAL(0)) top = real_min(top, real_scale(speed_max, -unit.speed));
    const real_t cruise = ssv_cruise_speed(&thrusts, leg.weight_time, leg.weight_impulse, top);
    const real_t time_price = real_mul(leg.weight_time, distance);
    // J = fixed + time_price / peak + rest(peak), where the rest is nearly linear, so the best peak follows from its
    // slope: at first that of a leg without drag, then half as much again as that of the first chord, then that of the
    // secant through the last two. A secant of a slope brackets nothing, so math/root.h has no part in this.
    real_t fixed = REAL(0);
    for (int i = 0; i < N; i++) fixed += real_abs(thrusts.linear[i]);
    fixed = real_mul(leg.weight_impulse, real_mul(distance, fixed));
    real_t slope = real_div(leg.weight_time, limit) + real_mul(REAL(2), real_mul(leg.weight_impulse, leg.groups.total));
    real_t peak = REAL(0), rest = REAL(0), least = REAL(0);
    for (int n = 0; n < NUM_ESTIMATE_STEPS; n++) {
        const real_t last = peak, last_rest = rest;
        peak = real_mul(slope, real_sq(cruise)) > time_price ? real_sqrt(real_div(time_price, slope)) : cruise;
        if (real_abs(peak - last) <= real_mul(closeness, peak)) break;
        real_t covered;
        const real_t holding = real_mul(leg.weight_impulse, ssv_cruise_thrust(&thrusts, peak));
        const real_t lambda = real_div(leg.weight_time + holding, peak), G = ramps(&leg, peak, lambda, &covered);
        const real_t J = real_mul(lambda, distance) + G;
        if (n == 0 || J < least) {
            least = J;
            *peak_speed = real_scale(peak, unit.speed);
        }
        if (peak == cruise && covered <= distance) break; // a cruise between the ramps
        rest = J - fixed - real_div(time_price, peak);
        slope = n == 0 ? real_div(real_mul(REAL(1.5), rest), peak) : real_div(rest - last_rest, peak - last);
        slope = real_max(REAL(0), slope);
    }
    *price = real_scale(least, unit.time);
    return true;
}
