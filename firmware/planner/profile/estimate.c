// The price of a leg as a function of the marginal cost of distance: J = min over lambda of lambda D + G(lambda), where
// G(lambda) is the least integral of L - lambda v over a ramp up and a ramp down. Around the right lambda J is flat, so
// a guess of the peak speed will do, and so will few points of quadrature.
#include "planner/profile/estimate.h"

#define N SSV_NUM_THRUSTERS
#define NUM_NODES 3
#define NUM_GUESSES 5
// Terminal speed is only approached.
#define BELOW_TERMINAL REAL(0.99999)

// Gauss-Legendre on [0, 1].
static const real_t node[NUM_NODES] = {REAL(0.11270166537925831), REAL(0.5), REAL(0.88729833462074169)};
static const real_t weight[NUM_NODES] = {REAL(0.27777777777777778), REAL(0.44444444444444444),
                                         REAL(0.27777777777777778)};

typedef struct {
    ssv_laws_t laws;
    real_t weight_time, weight_impulse;
} leg_t;

// A change of speed: its cost rate C = L(v, a) - lambda v, and |a|.
typedef struct {
    real_t cost, a;
} change_t;

// The least of C / |a| on one side, which is at the limit or where some thruster idles before it. C_rest is what does
// not depend on the thrusters that act.
static change_t cheapest_change(const leg_t* leg, const real_t idle[N], real_t C_rest, real_t limit) {
    change_t best = {REAL(0), REAL(0)};
    const bool up = limit > REAL(0);
    for (int j = -1; j < leg->laws.num; j++) {
        const real_t a = j < 0 ? limit : idle[j], size = real_abs(a);
        if (j >= 0 && (up ? a <= REAL(0) || a >= limit : a >= REAL(0) || a <= limit)) continue;
        real_t sum = REAL(0);
        for (int k = 0; k < leg->laws.num; k++) sum += real_mul(leg->laws.weight[k], real_abs(a - idle[k]));
        const real_t cost = C_rest + real_mul(leg->weight_impulse, sum);
        if (j < 0 || real_mul(cost, best.a) < real_mul(best.cost, size)) best = (change_t){cost, size};
        if (!(leg->weight_impulse > REAL(0))) break; // only time counts
    }
    return best;
}

// G for ramps up to this peak, lambda being right for it, and the distance that they take.
static real_t ramps(const leg_t* leg, real_t peak, real_t lambda, real_t* distance) {
    const ssv_laws_t* laws = &leg->laws;
    real_t sum = REAL(0), way = REAL(0);
    for (int n = 0; n < NUM_NODES; n++) {
        const real_t v = real_mul(peak, node[n]);
        real_t idle[N], up = REAL(0), down = REAL(0), passive = REAL(0);
        for (int k = 0; k < laws->num; k++) {
            idle[k] = real_mul(v, laws->linear[k] + real_mul(laws->quadratic[k], v));
            up = k == 0 ? idle[k] + laws->limit[k] : real_min(up, idle[k] + laws->limit[k]);
            down = k == 0 ? idle[k] - laws->limit[k] : real_max(down, idle[k] - laws->limit[k]);
        }
        if (!(up > REAL(0)) || !(down < REAL(0))) continue; // rounding next to the terminal speed
        for (int k = 0; k < laws->num_passive; k++) {
            passive += real_abs(laws->passive_linear[k] + real_mul(laws->passive_quadratic[k], v));
        }
        const real_t C_rest =
            leg->weight_time - real_mul(lambda, v) + real_mul(leg->weight_impulse, real_mul(passive, v));
        const change_t faster = cheapest_change(leg, idle, C_rest, up),
                       slower = cheapest_change(leg, idle, C_rest, down);
        const real_t per_faster = real_div(weight[n], faster.a), per_slower = real_div(weight[n], slower.a);
        sum += real_mul(faster.cost, per_faster) + real_mul(slower.cost, per_slower);
        way += real_mul(v, per_faster + per_slower);
    }
    *distance = real_mul(peak, way);
    return real_mul(peak, sum);
}

bool ssv_profile_estimate(const ssv_thrusts_t* thrusts_SI, real_t weight_time_per_s, real_t weight_impulse_per_Ns,
                          real_t distance_SI, real_t closeness, real_t* price, real_t* peak_speed) {
    leg_t leg;
    ssv_units_t unit;
    ssv_thrusts_t thrusts;
    leg.weight_time = real_max(weight_time_per_s, real_mul(SSV_TIME_PRICE_MIN_N, weight_impulse_per_Ns));
    if (!ssv_thrusts_scale(thrusts_SI, leg.weight_time, weight_impulse_per_Ns, distance_SI, &unit, &thrusts))
        return false;
    leg.weight_impulse = real_scale(weight_impulse_per_Ns, unit.force);
    const real_t distance = real_scale(distance_SI, -unit.length);
    if (!ssv_laws_of(&thrusts, &leg.laws)) return false;
    real_t limit = leg.laws.limit[0];
    for (int k = 1; k < leg.laws.num; k++) limit = real_min(limit, leg.laws.limit[k]);
    // Without drag no speed is above that of full thrust half the way.
    const real_t free_top = real_sqrt(real_mul(limit, distance)), terminal = ssv_terminal_speed(&thrusts, free_top);
    const real_t top = terminal < free_top ? real_mul(BELOW_TERMINAL, terminal) : free_top;
    const real_t cruise = ssv_cruise_speed(&thrusts, leg.weight_time, leg.weight_impulse, top);
    const real_t time_price = real_mul(leg.weight_time, distance);
    // J = fixed + time_price / peak + rest(peak), where the rest is nearly linear: its slope is at first that without
    // drag, then that between the last two guesses.
    real_t fixed = REAL(0);
    for (int i = 0; i < N; i++) fixed += real_abs(thrusts.linear[i]);
    fixed = real_mul(leg.weight_impulse, real_mul(distance, fixed));
    real_t slope = real_div(leg.weight_time, limit) + real_mul(REAL(2), real_mul(leg.weight_impulse, leg.laws.total));
    real_t peak = REAL(0), rest = REAL(0), least = REAL(0);
    for (int n = 0; n < NUM_GUESSES; n++) {
        const real_t last = peak, last_rest = rest;
        peak = real_mul(slope, real_sq(cruise)) > time_price ? real_sqrt(real_div(time_price, slope)) : cruise;
        if (real_abs(peak - last) <= real_mul(closeness, peak)) break;
        real_t covered;
        const real_t holding = real_mul(leg.weight_impulse, ssv_holding_thrust(&thrusts, peak));
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
