// Which speeds and accelerations the thrusters of a leg allow, and the units to reckon them in.
#include "planner/profile/limits.h"

#include "planner/math/assert.h"
#include "planner/profile/tolerance.h"

#define N SSV_NUM_THRUSTERS

bool ssv_thrusts_scale(const ssv_thrusts_t* thrusts, real_t weight_time_per_s, real_t weight_impulse_per_Ns,
                       real_t distance, ssv_units_t* units, ssv_thrusts_t* scaled) {
    SSV_ASSERT(distance > REAL(0) && !(thrusts->force_max_N < REAL(0)));
    real_t total = REAL(0);
    for (int i = 0; i < N; i++) total += real_abs(thrusts->accel[i]);
    if (!(total > REAL(0))) return false;
    const int length = real_exponent(distance), force = real_exponent(thrusts->force_max_N);
    // The thrust that is worth as much as the time it takes. Where it is less than the limit, it holds the peak down.
    const int worth = real_exponent(weight_time_per_s) - real_exponent(weight_impulse_per_Ns);
    const bool price_binds = weight_impulse_per_Ns > REAL(0) && worth < force;
    const int least = force - PRICE_HOLDS_DOWN_EXPONENT;
    const int acting = !price_binds ? force : worth > least ? worth : least;
    // The peak of a short leg is the root of acceleration times length.
    const int speed_squared = length - real_exponent(total) + acting;
    const int speed = speed_squared < 0 ? -((1 - speed_squared) / 2) : speed_squared / 2, time = length - speed;
    *units = (ssv_units_t){length, time, speed, force};
    for (int i = 0; i < N; i++) {
        scaled->accel[i] = real_scale(thrusts->accel[i], speed - time - force);
        scaled->linear[i] = real_scale(thrusts->linear[i], speed - force);
        scaled->quadratic[i] = real_scale(thrusts->quadratic[i], 2 * speed - force);
    }
    scaled->force_max_N = real_scale(thrusts->force_max_N, -force);
    return true;
}

static bool same(real_t a, real_t b) { return real_abs(a - b) <= real_mul(SAME_IDLE_CURVE, real_abs(a) + real_abs(b)); }

bool ssv_thruster_groups_of(const ssv_thrusts_t* t, ssv_thruster_groups_t* groups) {
    real_t largest = REAL(0);
    for (int i = 0; i < N; i++) largest = real_max(largest, real_abs(t->accel[i]));
    groups->num = groups->num_passive = 0;
    groups->total = REAL(0);
    for (int i = 0; i < N; i++) {
        const real_t A = t->accel[i];
        if (real_abs(A) <= real_mul(PASSIVE_SHARE, largest)) {
            if (t->linear[i] == REAL(0) && t->quadratic[i] == REAL(0)) continue;
            groups->passive_linear[groups->num_passive] = t->linear[i];
            groups->passive_quadratic[groups->num_passive++] = t->quadratic[i];
            continue;
        }
        const real_t limit = real_div(t->force_max_N, real_abs(A));
        const real_t linear = -real_div(t->linear[i], A), quadratic = -real_div(t->quadratic[i], A);
        int k = 0;
        while (k < groups->num && !(same(groups->linear[k], linear) && same(groups->quadratic[k], quadratic))) k++;
        if (k == groups->num) {
            groups->weight[k] = REAL(0);
            groups->limit[k] = limit;
            groups->linear[k] = linear;
            groups->quadratic[k] = quadratic;
            groups->num++;
        }
        groups->weight[k] += real_abs(A);
        groups->limit[k] = real_min(groups->limit[k], limit);
        groups->total += real_abs(A);
    }
    SSV_ASSERT(groups->num + groups->num_passive <= N);
    return groups->num > 0;
}

real_t ssv_cruise_thrust(const ssv_thrusts_t* thrusts, real_t v) {
    SSV_ASSERT(!(v < REAL(0)));
    real_t sum = REAL(0);
    for (int i = 0; i < N; i++) sum += real_abs(thrusts->linear[i] + real_mul(thrusts->quadratic[i], v));
    return real_mul(sum, v);
}

real_t ssv_terminal_speed(const ssv_thrusts_t* thrusts, real_t most) {
    SSV_ASSERT(!(most < REAL(0)) && !(thrusts->force_max_N < REAL(0)));
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

// From the top speed down, from one speed at which some thruster changes sign to the next: between them the price per
// distance has one formula.
real_t ssv_cruise_speed(const ssv_thrusts_t* thrusts, real_t weight_time, real_t weight_impulse, real_t top_speed) {
    SSV_ASSERT(!(top_speed < REAL(0)) && !(weight_time < REAL(0)) && !(weight_impulse < REAL(0)));
    real_t v = top_speed;
    for (int n = 0; n <= N; n++) {
        // Slope of the cruise thrust over the speed just below v, and the next change of sign below it.
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
