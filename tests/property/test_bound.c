// No price is below its bound, however little there is to do: tasks that are all but done. SSV_LONG=1 runs a million.
#include <stdio.h>
#include <string.h>

#include "sample.h"
#include "sweep.h"
#include "unity.h"

// Case k of a sweep starts with sample_seed(SEED + k).
#define SEED 20261128
#define MAX_TASKS 1000000

void setUp(void) {}
void tearDown(void) {}

static real_t between(double low, double high) { return real_from_double(sample_between(low, high)); }

// How far off: any power of ten from 1e-16 [m] or 1e-12 [rad], or nothing at all.
static real_t offset(double least_exponent) {
    return sample_below(4) == 0 ? REAL(0) : real_from_double(pow(10, sample_between(least_exponent, 0)));
}

static vec3_t moved(vec3_t p) { return vec3_add(p, vec3_scale(offset(-16), sample_direction())); }

static quat_t turned(quat_t q) { return quat_mul(q, quat_from_axis_angle(sample_direction(), offset(-12))); }

static real_t any_power(double least_exponent, double most_exponent) {
    return real_from_double(pow(10, sample_between(least_exponent, most_exponent)));
}

// Light and heavy, with little drag and with so much that a flight is hardly more than the work against it.
static void vary_bodies(ssv_scenario_t* s) {
    s->vehicle.body.mass_kg = any_power(-1, 3);
    s->vehicle.body.drag_lin_kg_s = any_power(-1, 4);
    s->vehicle.force_max_N = any_power(-1, 3);
    s->beam.body.mass_kg = any_power(-1, 2);
}

// The beam lies where it is to dock and the vehicle holds it; then each of these is a little off.
static ssv_scenario_t task(int k) {
    static const double weights[][2] = {{1, 0}, {0, 1}, {1, 1}, {1, 0.1}, {0.01, 1}};
    sample_seed(SEED + (uint64_t)k);
    ssv_scenario_t s = scenario_case_study(sample_below(2) == 1);
    if (sample_below(2) == 1) vary_bodies(&s);
    s.method = sample_below(2) == 1 ? SSV_METHOD_PAPER : SSV_METHOD_OPTIMAL;
    const double* const weight = weights[sample_below(5)];
    s.weight_time_per_s = real_from_double(weight[0]);
    s.weight_impulse_per_Ns = real_from_double(weight[1]);
    s.standoff_m = real_from_double(sample_below(2) == 1 ? 0.3025 : 0.3631);
    s.num_attach_heights = 1;
    s.attach_heights_m[0] = between(-1.5, 1.5);
    s.ring_angle_rad = between(-3, 3);
    s.ring_angle_given = sample_below(2) == 1;
    s.contact = 1 + sample_below(2);
    const pose_t X_IB = {sample_vector(sample_below(2) == 1 ? 0 : 8), sample_attitude()};
    const vec3_t outward_B = vec3(real_cos(s.ring_angle_rad), real_sin(s.ring_angle_rad), REAL(0));
    const vec3_t end_B =
        vec3(REAL(0), REAL(0), real_mul(real_from_double(s.contact == 1 ? -0.5 : 0.5), s.beam.length_m));
    const vec3_t p_BS = vec3_add(vec3_scale(s.standoff_m, outward_B), vec3(REAL(0), REAL(0), s.attach_heights_m[0]));
    const quat_t q_BS = quat_between(vec3(REAL(1), REAL(0), REAL(0)), vec3_neg(outward_B));
    s.X_IS = pose_mul(X_IB, (pose_t){p_BS, q_BS});
    s.X_IS = (pose_t){moved(s.X_IS.p), turned(s.X_IS.q)};
    s.p_IP_m = moved(vec3_add(X_IB.p, quat_apply(X_IB.q, end_B)));
    s.axis_I = quat_apply(turned(X_IB.q), vec3(REAL(0), REAL(0), s.contact == 1 ? REAL(1) : REAL(-1)));
    s.X_IB = X_IB;
    return s;
}

typedef struct {
    int status;
    real_t bound, price;
} prices_t;

static void price(int k, void* result) {
    prices_t* p = result;
    const ssv_scenario_t s = task(k);
    ssv_problem_t problem;
    ssv_work_t work;
    ssv_fault_t fault;
    ssv_quote_t quote;
    p->status = ssv_problem_init(&problem, &s, &fault);
    if (p->status != SSV_OK) return;
    p->status = ssv_quote(&problem, &work, &quote);
    p->bound = quote.lower_bound;
    p->price = quote.cost;
}

static void test_no_price_is_below_its_bound_however_little_there_is_to_do(void) {
    const int count = sweep_count(5000, MAX_TASKS);
    const prices_t* p = sweep("tasks that are all but done", count, sizeof *p, price);
    TEST_ASSERT_NOT_NULL(p);
    int num_priced = 0, num_bound = 0, num_below = 0, first = 0;
    double nearest = 1;
    for (int k = 0; k < count; k++) {
        TEST_ASSERT_TRUE(p[k].status >= 0);
        if (p[k].status != SSV_OK) continue; // takes too long, or does not fit the scalar
        num_priced++;
        if (p[k].bound > REAL(0)) num_bound++;
        if (p[k].price < p[k].bound && num_below++ == 0) first = k;
        const double gap = real_to_double(p[k].price) / real_to_double(p[k].bound) - 1;
        if (p[k].bound > REAL(0) && gap < nearest) nearest = gap;
    }
    char text[100];
    (void)snprintf(text, sizeof text, "below the bound, first by sample_seed(%d)", SEED + first);
    printf("seed %d, %d tasks: %d priced, %d with a bound, %d below it; at the least %.2g above\n", SEED, count,
           num_priced, num_bound, num_below, nearest);
    TEST_ASSERT_GREATER_THAN(count / 2, num_priced);
    TEST_ASSERT_GREATER_THAN(count / 10, num_bound); // the others have less to do than counts
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, num_below, text);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_no_price_is_below_its_bound_however_little_there_is_to_do);
    return UNITY_END();
}
