// The price of a leg as a function of the marginal cost of distance: J = min over lambda of lambda D + G(lambda), where
// G(lambda) is the least integral of L - lambda v over a ramp up and a ramp down. Around the right lambda J is flat, so a guess
// of the peak speed will do, and so will few points of quadrature.
#include "planner/estimate.h"

#define N SSV_NUM_THRUSTERS
#define NUM_NODES 3
#define NUM_GUESSES 5
// A thruster with less than this share of the largest coefficient does not act.
#define SAME_LAW REAL(1e-9)
// Guesses of the peak this close together price the leg to the square of that.
#define CLOSE REAL(0.1)
// Terminal speed is only approached.
#define BELOW_TERMINAL REAL(0.99999)

// Gauss-Legendre on [0, 1].
static const real_t node[NUM_NODES] = {REAL(0.11270166537925831), REAL(0.5), REAL(0.88729833462074169)};
static const real_t weight[NUM_NODES] = {REAL(0.27777777777777778), REAL(0.44444444444444444), REAL(0.27777777777777778)};

typedef struct {
    const ssv_thrusts_t* thrusts;
    real_t weight_time, weight_impulse;
    int num; // thrusters that act; the others hold drag alone
    real_t accel[N], linear[N], quadratic[N], limit[N]; // per thruster: |accel|, idle law's coefficients, force_max / |accel|
    int num_passive;
    real_t passive_linear[N], passive_quadratic[N];
} leg_t;

static bool leg_init(const ssv_thrusts_t* t, leg_t* leg) {
    real_t largest = REAL(0);
    for (int i = 0; i < N; i++) largest = real_max(largest, real_abs(t->accel[i]));
    leg->thrusts = t;
    leg->num = leg->num_passive = 0;
    for (int i = 0; i < N; i++) {
        const real_t A = t->accel[i];
        if (real_abs(A) <= real_mul(SAME_LAW, largest)) {
            leg->passive_linear[leg->num_passive] = t->linear[i];
            leg->passive_quadratic[leg->num_passive++] = t->quadratic[i];
            continue;
        }
        const real_t per_A = real_div(REAL(1), A);
        const int k = leg->num++;
        leg->accel[k] = real_abs(A);
        leg->linear[k] = -real_mul(t->linear[i], per_A);
        leg->quadratic[k] = -real_mul(t->quadratic[i], per_A);
        leg->limit[k] = real_abs(real_mul(t->force_max_N, per_A));
    }
    return leg->num > 0;
}

static real_t holding_cost(const leg_t* leg, real_t v) {
    const ssv_thrusts_t* t = leg->thrusts;
    real_t sum = REAL(0);
    for (int i = 0; i < N; i++) sum += real_abs(t->linear[i] + real_mul(t->quadratic[i], v));
    return leg->weight_time + real_mul(leg->weight_impulse, real_mul(sum, v));
}

// Largest speed in (0, most] that every thruster can hold.
static real_t top_speed(const leg_t* leg, real_t most) {
    const ssv_thrusts_t* t = leg->thrusts;
    real_t top = most;
    for (int i = 0; i < N; i++) {
        const real_t b = real_abs(t->linear[i]);
        const bool against = (t->linear[i] < REAL(0)) != (t->quadratic[i] < REAL(0));
        const real_t c = against ? -real_abs(t->quadratic[i]) : real_abs(t->quadratic[i]);
        // Along b v + c v^2 the limit is first met at +force_max, or for c < 0 past the hump at -force_max.
        const real_t disc = real_sq(b) + real_mul(REAL(4), real_mul(c, t->force_max_N));
        real_t v;
        if (disc >= REAL(0)) {
            const real_t den = b + real_sqrt(disc);
            if (!(real_mul(den, top) > real_mul(REAL(2), t->force_max_N))) continue;
            v = real_div(real_mul(REAL(2), t->force_max_N), den);
        } else {
            const real_t num = b + real_sqrt(real_sq(b) - real_mul(REAL(4), real_mul(c, t->force_max_N)));
            if (!(real_mul(real_mul(REAL(-2), c), top) > num)) continue;
            v = real_div(num, real_mul(REAL(-2), c));
        }
        top = real_mul(BELOW_TERMINAL, v);
    }
    return top;
}

// Cheapest speed to hold: the least of the convex holding_cost(v) / v, sought from the top down over the speeds at which some
// thruster changes sign.
static real_t cruise_speed(const leg_t* leg, real_t top) {
    const ssv_thrusts_t* t = leg->thrusts;
    real_t v = top;
    for (int n = 0; n <= N; n++) {
        // Slope just below v, and the next change of sign below it.
        real_t slope = REAL(0), below = REAL(0);
        for (int i = 0; i < N; i++) {
            // c v + b, per speed, where c != 0; below its zero the sign is that of b.
            const real_t c = t->quadratic[i];
            if (c == REAL(0)) continue;
            const real_t zero = -real_div(t->linear[i], c);
            slope += zero < v ? real_abs(c) : -real_abs(c);
            if (zero < v) below = real_max(below, zero);
        }
        slope = real_mul(leg->weight_impulse, slope);
        if (real_mul(slope, real_sq(v)) <= leg->weight_time) return v;
        const real_t stationary = real_sqrt(real_div(leg->weight_time, slope));
        if (stationary >= below) return stationary;
        v = below;
    }
    return v;
}

// Least of (L(v, a) - lambda v) / |a| on one side: at the limit, or where a thruster idles before it.
static real_t cheapest_change(const leg_t* leg, const real_t idle[N], real_t passive, real_t limit, bool up, real_t* best_a) {
    real_t best = REAL(0);
    for (int j = -1; j < leg->num; j++) {
        const real_t a = j < 0 ? limit : idle[j];
        if (j >= 0 && (up ? a <= REAL(0) || a >= limit : a >= REAL(0) || a <= limit)) continue;
        real_t sum = REAL(0);
        for (int i = 0; i < leg->num; i++) sum += real_mul(leg->accel[i], real_abs(a - idle[i]));
        const real_t ratio = real_div(passive + real_mul(leg->weight_impulse, sum), real_abs(a));
        if (j < 0 || ratio < best) {
            best = ratio;
            *best_a = real_abs(a);
        }
        if (!(leg->weight_impulse > REAL(0))) break; // only time counts: the limit
    }
    return best;
}

// G for ramps up to this peak, lambda being right for it, and the distance that they take.
static real_t ramps(const leg_t* leg, real_t peak, real_t lambda, real_t* distance) {
    real_t sum = REAL(0), way = REAL(0);
    for (int k = 0; k < NUM_NODES; k++) {
        const real_t v = real_mul(peak, node[k]);
        real_t idle[N], up = REAL(0), down = REAL(0), drag = REAL(0), a_up, a_down;
        for (int i = 0; i < leg->num; i++) {
            idle[i] = real_mul(v, leg->linear[i] + real_mul(leg->quadratic[i], v));
            const real_t high = idle[i] + leg->limit[i], low = idle[i] - leg->limit[i];
            if (i == 0 || high < up) up = high;
            if (i == 0 || low > down) down = low;
        }
        for (int i = 0; i < leg->num_passive; i++) {
            drag += real_abs(leg->passive_linear[i] + real_mul(leg->passive_quadratic[i], v));
        }
        if (!(up > REAL(0)) || !(down < REAL(0))) continue; // rounding next to the terminal speed
        const real_t passive = leg->weight_time - real_mul(lambda, v) + real_mul(leg->weight_impulse, real_mul(drag, v));
        const real_t change = cheapest_change(leg, idle, passive, up, true, &a_up) +
                              cheapest_change(leg, idle, passive, down, false, &a_down);
        sum += real_mul(weight[k], change);
        way += real_mul(real_mul(weight[k], v), real_div(REAL(1), a_up) + real_div(REAL(1), a_down));
    }
    *distance = real_mul(peak, way);
    return real_mul(peak, sum);
}

bool ssv_profile_estimate(const ssv_thrusts_t* thrusts, real_t weight_time_per_s, real_t weight_impulse_per_Ns,
                          real_t distance, real_t* price, real_t* peak_speed) {
    leg_t leg;
    leg.weight_impulse = weight_impulse_per_Ns;
    leg.weight_time = real_max(weight_time_per_s, real_mul(SSV_TIME_PRICE_MIN_N, weight_impulse_per_Ns));
    if (!leg_init(thrusts, &leg)) return false;
    real_t limit = leg.limit[0], sum = REAL(0);
    for (int i = 0; i < leg.num; i++) {
        limit = real_min(limit, leg.limit[i]);
        sum += leg.accel[i];
    }
    // Without drag no speed is above that of full thrust half the way.
    const real_t top = top_speed(&leg, real_sqrt(real_mul(limit, distance)));
    const real_t cruise = cruise_speed(&leg, top), time_price = real_mul(leg.weight_time, distance);
    // J = fixed + time_price / peak + rest(peak), where the rest is nearly linear: its slope is at first that without drag, then
    // that between the last two guesses.
    real_t fixed = REAL(0);
    for (int i = 0; i < N; i++) fixed += real_abs(thrusts->linear[i]);
    fixed = real_mul(leg.weight_impulse, real_mul(distance, fixed));
    real_t slope = real_div(leg.weight_time, limit) + real_mul(REAL(2), real_mul(leg.weight_impulse, sum));
    real_t peak = REAL(0), rest = REAL(0);
    for (int n = 0; n < NUM_GUESSES; n++) {
        const real_t last = peak, last_rest = rest;
        peak = real_mul(slope, real_sq(cruise)) > time_price ? real_sqrt(real_div(time_price, slope)) : cruise;
        if (real_abs(peak - last) <= real_mul(CLOSE, peak)) break;
        real_t covered;
        const real_t lambda = real_div(holding_cost(&leg, peak), peak), G = ramps(&leg, peak, lambda, &covered);
        const real_t J = real_mul(lambda, distance) + G;
        if (n == 0 || J < *price) {
            *price = J;
            *peak_speed = peak;
        }
        if (peak == cruise && covered <= distance) break; // a cruise between the ramps
        rest = J - fixed - real_div(time_price, peak);
        slope = n == 0 ? real_div(real_mul(REAL(1.5), rest), peak) : real_div(rest - last_rest, peak - last);
        slope = real_max(REAL(0), slope);
    }
    return true;
}
