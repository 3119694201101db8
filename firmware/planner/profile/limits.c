#include "planner/profile/limits.h"

#define N SSV_NUM_THRUSTERS
// A thruster with a smaller share of the largest acceleration than this holds drag alone.
#define WEAK real_max(REAL(1e-11), 1024 * REAL_NOISE)
// Thrusters whose laws agree this closely are one.
#define SAME real_max(REAL(1e-10), 4 * REAL_NOISE)
// A price counts as holding the peak down to no less than 2 to minus half this power of what inertia allows.
#define SLOWEST 6

bool ssv_thrusts_scale(const ssv_thrusts_t* thrusts, real_t weight_time_per_s, real_t weight_impulse_per_Ns,
                       real_t distance, ssv_units_t* units, ssv_thrusts_t* scaled) {
    real_t total = REAL(0);
    for (int i = 0; i < N; i++) total += real_abs(thrusts->accel[i]);
    if (!(total > REAL(0))) return false;
    const int length = real_exponent(distance), force = real_exponent(thrusts->force_max_N);
    const int worth = real_exponent(weight_time_per_s) - real_exponent(weight_impulse_per_Ns);
    const bool thrifty = weight_impulse_per_Ns > REAL(0) && worth < force;
    const int acting = !thrifty ? force : worth > force - SLOWEST ? worth : force - SLOWEST;
    const int twice = length - real_exponent(total) + acting;
    const int speed = twice < 0 ? -((1 - twice) / 2) : twice / 2, time = length - speed;
    *units = (ssv_units_t){length, time, speed, force};
    for (int i = 0; i < N; i++) {
        scaled->accel[i] = real_scale(thrusts->accel[i], speed - time - force);
        scaled->linear[i] = real_scale(thrusts->linear[i], speed - force);
        scaled->quadratic[i] = real_scale(thrusts->quadratic[i], 2 * speed - force);
    }
    scaled->force_max_N = real_scale(thrusts->force_max_N, -force);
    return true;
}

static bool same(real_t a, real_t b) { return real_abs(a - b) <= real_mul(SAME, real_abs(a) + real_abs(b)); }

bool ssv_laws_of(const ssv_thrusts_t* t, ssv_laws_t* laws) {
    real_t largest = REAL(0);
    for (int i = 0; i < N; i++) largest = real_max(largest, real_abs(t->accel[i]));
    laws->num = laws->num_passive = 0;
    laws->total = REAL(0);
    for (int i = 0; i < N; i++) {
        const real_t A = t->accel[i];
        if (real_abs(A) <= real_mul(WEAK, largest)) {
            if (t->linear[i] == REAL(0) && t->quadratic[i] == REAL(0)) continue;
            laws->passive_linear[laws->num_passive] = t->linear[i];
            laws->passive_quadratic[laws->num_passive++] = t->quadratic[i];
            continue;
        }
        const real_t limit = real_div(t->force_max_N, real_abs(A));
        const real_t linear = -real_div(t->linear[i], A), quadratic = -real_div(t->quadratic[i], A);
        int k = 0;
        while (k < laws->num && !(same(laws->linear[k], linear) && same(laws->quadratic[k], quadratic))) k++;
        if (k == laws->num) {
            laws->weight[k] = REAL(0);
            laws->limit[k] = limit;
            laws->linear[k] = linear;
            laws->quadratic[k] = quadratic;
            laws->num++;
        }
        laws->weight[k] += real_abs(A);
        laws->limit[k] = real_min(laws->limit[k], limit);
        laws->total += real_abs(A);
    }
    return laws->num > 0;
}

real_t ssv_holding_thrust(const ssv_thrusts_t* thrusts, real_t v) {
    real_t sum = REAL(0);
    for (int i = 0; i < N; i++) sum += real_abs(thrusts->linear[i] + real_mul(thrusts->quadratic[i], v));
    return real_mul(sum, v);
}

real_t ssv_terminal_speed(const ssv_thrusts_t* thrusts, real_t most) {
    const real_t four_F = real_mul(REAL(4), thrusts->force_max_N);
    real_t top = most;
    for (int i = 0; i < N; i++) {
        const real_t b = real_abs(thrusts->linear[i]), size = real_abs(thrusts->quadratic[i]);
        const real_t c =
            (thrusts->linear[i] < REAL(0)) != (thrusts->quadratic[i] < REAL(0)) && b > REAL(0) ? -size : size;
        // Along b v + c v^2 the limit is first met at +force_max, or for c < 0 past the hump at -force_max.
        const real_t disc = real_sq(b) + real_mul(four_F, c), forwards = b + real_sqrt(real_max(REAL(0), disc));
        if (disc >= REAL(0)) {
            if (real_mul(forwards, top) > real_mul(REAL(0.5), four_F))
                top = real_div(real_mul(REAL(0.5), four_F), forwards);
        } else {
            const real_t past = b + real_sqrt(real_sq(b) - real_mul(four_F, c));
            if (real_mul(real_mul(REAL(2), size), top) > past) top = real_div(past, real_mul(REAL(2), size));
        }
    }
    return top;
}

// Sought from the top down, over the speeds at which some thruster changes sign.
real_t ssv_cruise_speed(const ssv_thrusts_t* thrusts, real_t weight_time, real_t weight_impulse, real_t top) {
    real_t v = top;
    for (int n = 0; n <= N; n++) {
        // Slope of the holding thrust per speed just below v, and the next change of sign below it.
        real_t slope = REAL(0), below = REAL(0);
        for (int i = 0; i < N; i++) {
            const real_t b = thrusts->linear[i], c = thrusts->quadratic[i], size = real_abs(c);
            if (c == REAL(0)) continue;
            const bool opposed = (b < REAL(0)) != (c < REAL(0)) && b != REAL(0);
            const real_t zero = !opposed ? REAL(0) : real_abs(b) < real_mul(size, v) ? real_div(real_abs(b), size) : v;
            slope += zero < v ? size : -size;
            if (zero < v) below = real_max(below, zero);
        }
        slope = real_mul(weight_impulse, slope);
        if (real_mul(real_mul(slope, v), v) <= weight_time) return v;
        const real_t stationary = real_sqrt(real_div(weight_time, slope));
        if (stationary >= below) return stationary;
        v = below;
    }
    return v;
}
