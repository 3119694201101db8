// Optimal profiles against two oracles that share nothing with the closed forms.
//
// by_stages() assumes nothing of the optimum: dynamic programming over speed at fixed stages of distance, any sequence of
// speeds allowed, on a mesh that is refined around the best sequence. It is slow and good to some 1e-4.
//
// by_peak() is fast. It takes for granted that the speed rises, may stay, and falls. For a peak speed p the rest of the
// distance is flown at p for L(p, 0) / p per metre; at that price each speed below p is left upward and downward by the
// acceleration that costs least, found by trying every kink of L and the limits. Summing these costs over speed (they are
// continuous and bounded, also where the distance is not) prices the peak; the cheapest peak is looked for by brute force.
// Neither where the speed stops rising nor that a short leg has no cruise is put in.
#include <stdio.h>

#include "planner/profile.h"
#include "tasks.h"
#include "unity.h"

#define N SSV_NUM_THRUSTERS
#define SEED 20261123
#define LEGS 2000
#define FORCE 6.0

static ssv_profile_t profile;

void setUp(void) {}
void tearDown(void) {}

typedef struct {
    ssv_thrusts_t thrusts;
    double w1, w2, cap, distance; // cap 0: none
} leg_t;

static double drag(const ssv_thrusts_t* t, int i, double v) { return v * (t->linear[i] + t->quadratic[i] * v); }

static double total(const ssv_thrusts_t* t, double v, double a) {
    double sum = 0;
    for (int i = 0; i < N; i++) sum += fabs(t->accel[i] * a + drag(t, i, v));
    return sum;
}

// L of the model: what a second costs.
static double rate(const leg_t* leg, double v, double a) { return leg->w1 + leg->w2 * total(&leg->thrusts, v, a); }

// Highest speed that every thruster can hold, cap and the distance allow.
static double top_speed(const leg_t* leg) {
    const ssv_thrusts_t* t = &leg->thrusts;
    double inertia = 0;
    for (int i = 0; i < N; i++) inertia = fmax(inertia, fabs(t->accel[i]));
    double top = sqrt(4 * FORCE / inertia * leg->distance); // below that speed no thruster gives more than 2 FORCE / accel
    if (leg->cap > 0) top = fmin(top, leg->cap);
    for (int i = 0; i < N; i++) {
        const double p = fabs(t->linear[i]), q = t->linear[i] < 0 ? -t->quadratic[i] : t->quadratic[i];
        // p v + q v^2 = FORCE, or -FORCE on the far side of where the two drags cancel.
        const double disc = p * p + 4 * q * FORCE;
        if (disc >= 0) {
            if (p + sqrt(disc) > 0) top = fmin(top, 2 * FORCE / (p + sqrt(disc)));
        } else {
            continue;
        }
        if (q < 0) top = fmin(top, (p + sqrt(p * p - 4 * q * FORCE)) / (-2 * q));
    }
    return top;
}

// ---- Oracle: cheapest peak speed ----------------------------------------------------------------------------------------

// The a > 0 (up) or a < 0 that minimises (L(v, a) - price v) / |a|; that minimum.
static double cheapest(const leg_t* leg, double price, double v, bool up, double* a_best) {
    const ssv_thrusts_t* t = &leg->thrusts;
    double low = 0, high = INFINITY, b[N + 1]; // of |a|
    const double sign = up ? 1 : -1;
    int num = 0;
    for (int i = 0; i < N; i++) {
        if (t->accel[i] == 0) continue;
        const double A = sign * t->accel[i], d = drag(t, i, v);
        high = fmin(high, ((A > 0 ? FORCE : -FORCE) - d) / A);
        b[num++] = -d / A;
    }
    low = 1e-10 * high; // nearer to 0 it is the cruise
    b[num++] = high;
    double best = INFINITY;
    for (int k = 0; k < num; k++) {
        if (!(b[k] > low && b[k] <= high)) continue;
        const double value = (rate(leg, v, sign * b[k]) - price * v) / b[k];
        if (value < best) {
            best = value;
            *a_best = b[k];
        }
    }
    return best;
}

// Cost of the leg with this peak speed; infinite if the ramps alone are longer than the leg.
static double cost_of_peak(const leg_t* leg, double peak, int nodes) {
    const double price = rate(leg, peak, 0) / peak;
    double cost = price * leg->distance, rest = leg->distance;
    for (int k = 0; k < nodes; k++) {
        const double x = (k + 0.5) / nodes; // nodes gather at rest and at the peak
        const double v = peak * x * x * (3 - 2 * x), dv = peak * 6 * x * (1 - x) / nodes;
        for (int up = 0; up < 2; up++) {
            double a = INFINITY;
            cost += dv * cheapest(leg, price, v, up != 0, &a);
            rest -= dv * v / a;
        }
    }
    return rest >= 0 ? cost : INFINITY;
}

// Where f is least in [low, high]; f has one minimum, or falls up to a point beyond which it is infinite.
static double golden(double (*f)(const leg_t*, double, int), const leg_t* leg, int nodes, double low, double high, int steps) {
    const double g = 0.6180339887498949;
    double x0 = high - g * (high - low), x1 = low + g * (high - low);
    double f0 = f(leg, x0, nodes), f1 = f(leg, x1, nodes);
    for (int n = 0; n < steps; n++) {
        if (f0 <= f1) {
            high = x1;
            x1 = x0;
            f1 = f0;
            x0 = high - g * (high - low);
            f0 = f(leg, x0, nodes);
        } else {
            low = x0;
            x0 = x1;
            f0 = f1;
            x1 = low + g * (high - low);
            f1 = f(leg, x1, nodes);
        }
    }
    return f0 <= f1 ? x0 : x1;
}

static double cruise_price(const leg_t* leg, double v, int unused) {
    (void)unused;
    return rate(leg, v, 0) / v;
}

static double by_peak(const leg_t* leg, int nodes) {
    const double top = top_speed(leg);
    double fastest = golden(cruise_price, leg, 0, 0, top, 60);
    if (cruise_price(leg, top, 0) <= cruise_price(leg, fastest, 0)) fastest = top;
    double best = cost_of_peak(leg, fastest, nodes), at = fastest;
    for (int k = 1; k < 32; k++) {
        const double peak = fastest * pow(2, -k / 2.0), cost = cost_of_peak(leg, peak, nodes);
        if (cost < best) {
            best = cost;
            at = peak;
        }
    }
    const double low = at / sqrt(2), high = fmin(at * sqrt(2), fastest);
    return fmin(best, cost_of_peak(leg, golden(cost_of_peak, leg, nodes, low, high, 24), nodes));
}

// ---- Oracle: dynamic programming over stages of distance ------------------------------------------------------------------

#define MAX_STAGES 640
#define MESH 33

// From speed v0 to v1 over a short distance with the thrust of the middle; infinite beyond the limits.
static double hop(const leg_t* leg, double v0, double v1, double ds) {
    const double v = 0.5 * (v0 + v1), a = v * (v1 - v0) / ds;
    if (v <= 0) return INFINITY;
    double sum = 0;
    for (int i = 0; i < N; i++) {
        const double u = fabs(leg->thrusts.accel[i] * a + drag(&leg->thrusts, i, v));
        if (u > FORCE * (1 + 1e-12)) return INFINITY;
        sum += u;
    }
    return (leg->w1 + leg->w2 * sum) * ds / v;
}

// The best sequence of speeds on a mesh around v[], at most width above and below it; replaces v[]. Returns its cost.
static double best_on_mesh(const leg_t* leg, int stages, const double* s, double top, const double* width, double* v) {
    static double mesh[MAX_STAGES + 1][MESH], cost[MESH], next[MESH];
    static unsigned char from[MAX_STAGES + 1][MESH];
    for (int n = 0; n <= stages; n++) {
        for (int j = 0; j < MESH; j++) {
            const double x = v[n] + width[n] * (2.0 * j / (MESH - 1) - 1);
            mesh[n][j] = n == 0 || n == stages ? 0 : fmin(top, fmax(0, x));
        }
    }
    for (int j = 0; j < MESH; j++) cost[j] = j == MESH / 2 ? 0 : INFINITY;
    for (int n = 0; n < stages; n++) {
        for (int k = 0; k < MESH; k++) {
            next[k] = INFINITY;
            for (int j = 0; j < MESH; j++) {
                if (cost[j] == INFINITY) continue;
                const double c = cost[j] + hop(leg, mesh[n][j], mesh[n + 1][k], s[n + 1] - s[n]);
                if (c < next[k]) {
                    next[k] = c;
                    from[n + 1][k] = (unsigned char)j;
                }
            }
        }
        memcpy(cost, next, sizeof cost);
    }
    int k = MESH / 2;
    const double best = cost[k];
    if (best == INFINITY) return best;
    for (int n = stages; n > 0; n--) {
        v[n] = mesh[n][k];
        k = from[n][k];
    }
    return best;
}

static double by_stages(const leg_t* leg, int stages) {
    static double s[MAX_STAGES + 1], v[MAX_STAGES + 1], width[MAX_STAGES + 1];
    const double top = top_speed(leg);
    for (int n = 0; n <= stages; n++) {
        const double x = (double)n / stages;
        s[n] = leg->distance * x * x * (3 - 2 * x);
        v[n] = width[n] = top / 2;
    }
    double best = INFINITY;
    for (int round = 0; round < 40; round++) {
        best = fmin(best, best_on_mesh(leg, stages, s, top, width, v));
        for (int n = 0; n <= stages; n++) width[n] *= 0.75;
    }
    return best;
}

int main(void) { return 0; }
