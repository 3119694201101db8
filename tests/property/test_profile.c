// Random legs against brute force: at every instant the thrust must be what the ramp's rule says, found by looking at
// every breakpoint, and the totals must be the sums over small steps of time.
#include <stdio.h>

#include "planner/profile/profile.h"
#include "sample.h"
#include "unity.h"

#define N SSV_NUM_THRUSTERS
#define SEED 20261122
#define LEGS 400
#define CUTOFF 0.01

static ssv_profile_t profile;

void setUp(void) {}
void tearDown(void) {}

// Six unequal thrusters; inertia and drag over four decades, mostly against the motion but not for every thruster.
static ssv_thrusts_t random_thrusts(void) {
    const double size = pow(10, sample_between(-2, 2));
    const double linear = sample_below(5) == 0 ? 0 : pow(10, sample_between(-2, 2));
    const double quadratic = sample_below(3) == 0 ? 0 : pow(10, sample_between(-2, 2));
    ssv_thrusts_t t;
    for (int i = 0; i < N; i++) {
        t.accel[i] = sample_below(10) == 0 ? 0 : size * sample_between(-1, 1);
        t.linear[i] = sample_below(10) < 7 ? t.accel[i] * linear * sample_between(0, 1)
                                           : 0.3 * size * linear * sample_between(-1, 1);
        t.quadratic[i] = sample_below(10) < 7 ? t.accel[i] * quadratic * sample_between(0, 1)
                                              : 0.3 * size * quadratic * sample_between(-1, 1);
    }
    // Thrusters that mirror each other agree but for rounding, and part only with the square of the speed.
    if (sample_below(3) == 0) {
        t.accel[1] = t.accel[0];
        t.linear[1] = t.linear[0] * (1 + sample_between(-4e-16, 4e-16));
    }
    t.force_max_N = 6;
    return t;
}

static double drag(const ssv_thrusts_t* t, int i, double v) { return t->linear[i] * v + t->quadratic[i] * v * v; }

static double total(const ssv_thrusts_t* t, double v, double a) {
    double sum = 0;
    for (int i = 0; i < N; i++) sum += fabs(t->accel[i] * a + drag(t, i, v));
    return sum;
}

// Least and largest acceleration that every thruster allows at speed v.
static void limits(const ssv_thrusts_t* t, double v, double* low, double* high) {
    *low = -INFINITY;
    *high = INFINITY;
    for (int i = 0; i < N; i++) {
        if (t->accel[i] == 0) continue;
        const double a = (t->force_max_N - drag(t, i, v)) / t->accel[i],
                     b = (-t->force_max_N - drag(t, i, v)) / t->accel[i];
        *high = fmin(*high, fmax(a, b));
        *low = fmax(*low, fmin(a, b));
    }
}

// The least total thrust at speed v is at a limit or where some thruster idles.
static double least_total(const ssv_thrusts_t* t, double v, double low, double high) {
    double least = fmin(total(t, v, low), total(t, v, high));
    for (int i = 0; i < N; i++) {
        const double a = t->accel[i] == 0 ? low : -drag(t, i, v) / t->accel[i];
        if (a > low && a < high) least = fmin(least, total(t, v, a));
    }
    return least;
}

static void assert_obeys_the_ramp(const ssv_thrusts_t* t, ssv_ramp_t ramp, const ssv_arc_t* arc, double v) {
    const double a = arc->dv_dt[0] + v * (arc->dv_dt[1] + v * arc->dv_dt[2]);
    double low, high;
    limits(t, v, &low, &high);
    const double slack = 1e-6 * (high - low); // arcs are compared 1e-9 of the top speed beyond a switch
    if (arc->v_end > arc->v_start) {
        TEST_ASSERT_DOUBLE_WITHIN(slack, high, a);
    } else if (arc->v_end == arc->v_start) {
        TEST_ASSERT_EQUAL_DOUBLE(0, a);
    } else if (ramp == SSV_FULL_REVERSE || v < CUTOFF) {
        TEST_ASSERT_DOUBLE_WITHIN(slack, low, a);
    } else {
        TEST_ASSERT_TRUE(a < 0 && a >= low - slack);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * N * t->force_max_N, least_total(t, v, low, high), total(t, v, a));
    }
    for (int i = 0; i < N; i++) {
        TEST_ASSERT_TRUE(fabs(t->accel[i] * a + drag(t, i, v)) <= t->force_max_N * (1 + 1e-9));
    }
}

static void test_random_legs_obey_their_ramp_and_add_up(void) {
    int feasible = 0;
    sample_seed(SEED);
    for (int leg = 0; leg < LEGS; leg++) {
        const ssv_thrusts_t t = random_thrusts();
        const ssv_ramp_t ramp = sample_below(2) == 0 ? SSV_FULL_REVERSE : SSV_DRAG_ONLY;
        const double stroke = pow(10, sample_between(-2, 2));
        char label[64];
        (void)snprintf(label, sizeof label, "seed %d, leg %d", SEED, leg);
        if (ssv_profile_solve(&t, &(ssv_rule_t){ramp, CUTOFF, 0, 0, 0}, stroke, &profile) != SSV_FEASIBLE) continue;
        feasible++;
        double distance = 0, impulse = 0, time = 0;
        for (int k = 0; k < profile.num_arcs; k++) {
            const ssv_arc_t* arc = &profile.arc[k];
            // Long coasts change fast at first: steps that grow with the square of the time since the arc's start.
            const int steps = 20000;
            double t_from = 0, v_from = arc->v_start;
            for (int n = 1; n <= steps; n++) {
                const double x = (double)n / steps, t_to = arc->duration_s * x * x;
                const double middle = (t_from + t_to) / 2, h = t_to - t_from;
                const double v = ssv_arc_speed(arc, middle), v_to = ssv_arc_speed(arc, t_to);
                const double a = arc->dv_dt[0] + v * (arc->dv_dt[1] + v * arc->dv_dt[2]);
                distance += h / 6 * (v_from + 4 * v + v_to);
                impulse += h * total(&t, v, a);
                if (n % 100 == 0) assert_obeys_the_ramp(&t, ramp, arc, v);
                t_from = t_to;
                v_from = v_to;
            }
            time += arc->duration_s;
        }
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-6 * stroke, stroke, distance, label);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9 * time, time, profile.duration_s, label);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-4 * impulse, impulse, profile.impulse_Ns,
                                          label); // the sum's midpoint rule
    }
    printf("seed %d: %d of %d random legs feasible\n", SEED, feasible, LEGS);
    TEST_ASSERT_TRUE(feasible > LEGS / 2);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_random_legs_obey_their_ramp_and_add_up);
    return UNITY_END();
}
