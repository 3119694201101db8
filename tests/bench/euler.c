#include "euler.h"

#include <math.h>

#define N SSV_NUM_THRUSTERS
#define STEP_S 0.01
// Speeding up ends here, in m/s2 or rad/s2 (Table 3's figures).
#define ACCELERATION_MIN 0.001
#define MAX_STEPS 100000

typedef struct {
    double A[N], per_A[N], linear[N], quadratic[N], force_max_N; // per_A = 1 / A, 0 where A = 0
} leg_t;

typedef struct {
    int steps;
    double v[MAX_STEPS + 1], s[MAX_STEPS + 1], impulse_Ns[MAX_STEPS + 1];
} ramp_t;

typedef enum { FULL_AHEAD, FULL_REVERSE, LEAST_THRUST } drive_t;

static double total_thrust(const leg_t* leg, double v, double a) {
    double sum = 0;
    for (int i = 0; i < N; i++) sum += fabs(leg->A[i] * a + (leg->linear[i] + leg->quadratic[i] * v) * v);
    return sum;
}

// The tightest thruster decides.
static double full_thrust(const leg_t* leg, double v, double sign) {
    double least = INFINITY;
    for (int i = 0; i < N; i++) {
        const double per_A = sign * leg->per_A[i];
        if (per_A == 0) continue;
        const double a = (copysign(leg->force_max_N, per_A) - (leg->linear[i] + leg->quadratic[i] * v) * v) * per_A;
        least = a < least ? a : least;
    }
    return sign * least;
}

// Least is where some thruster idles, within what all can give.
static double least_thrust(const leg_t* leg, double v) {
    const double most = full_thrust(leg, v, -1);
    double best = most, best_sum = total_thrust(leg, v, most);
    for (int i = 0; i < N; i++) {
        const double a = -(leg->linear[i] + leg->quadratic[i] * v) * v * leg->per_A[i];
        if (!(a < 0) || a < most) continue;
        const double sum = total_thrust(leg, v, a);
        if (sum >= best_sum) continue;
        best = a;
        best_sum = sum;
    }
    return best;
}

static double acceleration(const leg_t* leg, drive_t drive, double v) {
    switch (drive) {
        case FULL_AHEAD: return full_thrust(leg, v, 1);
        case FULL_REVERSE: return full_thrust(leg, v, -1);
        case LEAST_THRUST: break;
    }
    return least_thrust(leg, v);
}

static void fly(const leg_t* leg, drive_t drive, double v, double until, ramp_t* ramp) {
    double s = 0, impulse = 0;
    int k = 0;
    ramp->v[0] = v;
    ramp->s[0] = ramp->impulse_Ns[0] = 0;
    while (k < MAX_STEPS) {
        const double a = acceleration(leg, drive, v);
        if (drive == FULL_AHEAD ? a < ACCELERATION_MIN : v <= until) break;
        impulse += total_thrust(leg, v, a) * STEP_S;
        s += v * STEP_S + 0.5 * a * STEP_S * STEP_S;
        v += a * STEP_S;
        k++;
        ramp->v[k] = v;
        ramp->s[k] = s;
        ramp->impulse_Ns[k] = impulse;
    }
    ramp->steps = k;
}

static euler_price_t join(const leg_t* leg, const ramp_t* up, const ramp_t* down, double distance, euler_hold_t hold) {
    int i = up->steps, j = 0;
    while (i > 0 && up->s[i] + down->s[down->steps] - down->s[j] > distance) {
        i--;
        while (j < down->steps && down->v[j] > up->v[i]) j++;
    }
    const double v = up->v[i], rest = distance - up->s[i] - (down->s[down->steps] - down->s[j]);
    euler_price_t price = {0, 0, up->steps + down->steps};
    price.time_s = (i + down->steps - j) * STEP_S;
    price.impulse_Ns = up->impulse_Ns[i] + down->impulse_Ns[down->steps] - down->impulse_Ns[j];
    if (i == 0 || rest <= 0) return price;
    if (hold == EULER_HOLD_IN_ONE) {
        price.time_s += rest / v;
        price.impulse_Ns += rest / v * total_thrust(leg, v, 0);
        return price;
    }
    for (double s = 0; s < rest; s += v * STEP_S) {
        price.time_s += STEP_S;
        price.impulse_Ns += total_thrust(leg, v, 0) * STEP_S;
        price.steps++;
    }
    return price;
}

euler_price_t euler_price(const ssv_thrusts_t* thrusts, double distance, double cutoff, double weight_time,
                          double weight_impulse, euler_hold_t hold) {
    static ramp_t up, down;
    leg_t leg;
    leg.force_max_N = real_to_double(thrusts->force_max_N);
    for (int i = 0; i < N; i++) {
        leg.A[i] = real_to_double(thrusts->accel[i]);
        leg.per_A[i] = leg.A[i] != 0 ? 1 / leg.A[i] : 0;
        leg.linear[i] = real_to_double(thrusts->linear[i]);
        leg.quadratic[i] = real_to_double(thrusts->quadratic[i]);
    }
    fly(&leg, FULL_AHEAD, 0, 0, &up);
    fly(&leg, FULL_REVERSE, up.v[up.steps], 0, &down);
    const euler_price_t reverse = join(&leg, &up, &down, distance, hold);
    fly(&leg, LEAST_THRUST, up.v[up.steps], cutoff, &down);
    const euler_price_t drift = join(&leg, &up, &down, distance, hold);
    const int steps = reverse.steps + drift.steps - up.steps;
    euler_price_t best = weight_time * drift.time_s + weight_impulse * drift.impulse_Ns <
                                 weight_time * reverse.time_s + weight_impulse * reverse.impulse_Ns
                             ? drift
                             : reverse;
    best.steps = steps;
    return best;
}
