// What more effort and more questions may do to a price: make it lower, never higher, and for vehicles of every kind.
// SSV_LONG=1 runs the full sweeps.
#include <stdio.h>

#include "sample.h"
#include "sweep.h"
#include "unity.h"
#include "vehicles.h"

// Case k of a sweep is of vehicle k % NUM_VEHICLES and starts with sample_seed(SEED + k).
#define SEED 20261129
#define MAX_TASKS 2000

void setUp(void) {}
void tearDown(void) {}

// How often something does not hold, and where first.
typedef struct {
    int count, first;
} breaches_t;

static void expect(bool holds, int k, breaches_t* breaches) {
    if (!holds && breaches->count++ == 0) breaches->first = k;
}

static void assert_none(const char* what, breaches_t breaches) {
    char text[200];
    (void)snprintf(text, sizeof text, "%s, first by sample_seed(%d) and %s", what, SEED + breaches.first,
                   vehicle_name[breaches.first % NUM_VEHICLES]);
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, breaches.count, text);
}

static ssv_scenario_t task(int k) {
    sample_seed(SEED + (uint64_t)k);
    ssv_scenario_t s = sample_scenario();
    set_vehicle(&s, (vehicle_kind_t)(k % NUM_VEHICLES));
    s.method = SSV_METHOD_OPTIMAL;
    s.want_candidates = false;
    return s;
}

static bool quote_of(const ssv_scenario_t* s, ssv_quote_t* quote) {
    ssv_problem_t problem;
    ssv_work_t work;
    ssv_fault_t fault;
    return ssv_problem_init(&problem, s, &fault) == SSV_OK && ssv_quote(&problem, &work, quote) == SSV_OK;
}

static double price(ssv_scenario_t s, ssv_effort_t effort, bool want_candidates) {
    ssv_quote_t quote;
    s.effort = effort;
    s.want_candidates = want_candidates;
    return quote_of(&s, &quote) ? quote.cost : (double)NAN;
}

// The cheapest point of a front by the scenario's weights.
static double least_of_front(ssv_scenario_t s, ssv_effort_t effort) {
    ssv_problem_t problem;
    ssv_work_t work;
    ssv_fault_t fault;
    ssv_front_t front;
    s.effort = effort;
    if (ssv_problem_init(&problem, &s, &fault) != SSV_OK || ssv_front(&problem, &work, &front) != SSV_OK)
        return (double)NAN;
    double least = front.point[0].cost;
    for (int k = 1; k < front.num_points; k++) least = fmin(least, front.point[k].cost);
    return least;
}

typedef struct {
    double quick, best, quick_list, best_list, quick_front, best_front; // best_front 0: not asked
} prices_t;

#define FRONT_EVERY 10
// The plan's own point, or one that is better in both by rounding, whose price is summed up another way.
#define SAME_PRICE (1 + 1e-12)

static void price_all_ways(int k, void* result) {
    const ssv_scenario_t s = task(k);
    prices_t* p = result;
    p->quick = price(s, SSV_EFFORT_QUICK, false);
    p->best = price(s, SSV_EFFORT_BEST, false);
    p->quick_list = price(s, SSV_EFFORT_QUICK, true);
    p->best_list = price(s, SSV_EFFORT_BEST, true);
    p->quick_front = least_of_front(s, SSV_EFFORT_QUICK);
    if (k / NUM_VEHICLES % FRONT_EVERY == 0) p->best_front = least_of_front(s, SSV_EFFORT_BEST);
}

static void test_front_list_and_plan_agree(void) {
    const int count = sweep_count(5 * NUM_VEHICLES, MAX_TASKS);
    const prices_t* p = sweep("plans, lists and fronts", count, sizeof *p, price_all_ways);
    breaches_t no_price = {0, 0}, above_quick = {0, 0}, list_above = {0, 0}, list_below = {0, 0}, best_above = {0, 0},
               front = {0, 0};
    TEST_ASSERT_NOT_NULL(p);
    for (int k = 0; k < count; k++) {
        expect(p[k].quick > 0 && p[k].best > 0, k, &no_price);
        expect(p[k].best <= p[k].quick, k, &above_quick);
        expect(p[k].quick_list <= p[k].quick, k, &list_above);
        expect(p[k].best <= p[k].quick_list, k, &list_below);
        expect(p[k].best_list <= p[k].best, k, &best_above);
        expect(p[k].quick_front >= p[k].quick && p[k].quick_front <= SAME_PRICE * p[k].quick, k, &front);
        if (!(p[k].best_front > 0)) continue;
        expect(p[k].best_front >= p[k].best && p[k].best_front <= SAME_PRICE * p[k].best, k, &front);
    }
    assert_none("no price", no_price);
    assert_none("best above quick", above_quick);
    assert_none("a list above its plan", list_above);
    assert_none("a list of effort quick below effort best", list_below);
    assert_none("a list of effort best above its plan", best_above);
    assert_none("a front that is not as cheap as its plan, or cheaper", front);
}

typedef struct {
    double best, least; // of the plan, and of those that are forced to each contact and height
} forced_t;

static void force_each(int k, void* result) {
    ssv_scenario_t s = task(k);
    forced_t* f = result;
    s.num_attach_heights = 0; // the three rings
    f->best = price(s, SSV_EFFORT_BEST, false);
    f->least = (double)INFINITY;
    const int contact = s.contact;
    s.num_attach_heights = 1;
    for (s.contact = 1; s.contact <= SSV_NUM_CONTACTS; s.contact++) {
        if (contact != 0 && contact != s.contact) continue;
        for (int ring = -1; ring <= 1; ring++) {
            s.attach_heights_m[0] = 0.5 * ring * s.beam.length_m;
            f->least = fmin(f->least, price(s, SSV_EFFORT_BEST, false));
        }
    }
}

// Half a per cent is what a scheduler would not mind.
#define TOO_MUCH 1.005

static void test_best_costs_as_little_as_at_the_best_of_its_heights(void) {
    const int count = sweep_count(3 * NUM_VEHICLES, 500);
    const forced_t* f = sweep("forced heights", count, sizeof *f, force_each);
    breaches_t above = {0, 0};
    double worst = 1;
    TEST_ASSERT_NOT_NULL(f);
    for (int k = 0; k < count; k++) {
        expect(f[k].best <= TOO_MUCH * f[k].least, k, &above);
        worst = fmax(worst, f[k].best / f[k].least);
    }
    printf("seed %d, %d tasks: best costs at most %.2f %% more than at the cheapest height\n", SEED, count,
           100 * (worst - 1));
    assert_none("best above a forced height", above);
}

static void price_by_effort(int k, void* result) {
    const ssv_scenario_t s = task(k);
    *(double*)result = price(s, SSV_EFFORT_QUICK, false) / price(s, SSV_EFFORT_BEST, false);
}

// By measurement: medians up to 1.06, and up to 8 of 100 tasks above 1.2. A search for the vehicle of the models alone
// has medians up to 1.27, and up to 71 of 100.
#define TYPICALLY 1.08
#define RARELY 1.2

static void test_quick_costs_little_more_than_best_whatever_the_vehicle(void) {
    const int num_each = sweep_count(25, 100), count = num_each * NUM_VEHICLES;
    const double* ratio = sweep("quick and best", count, sizeof *ratio, price_by_effort);
    double of_vehicle[100];
    TEST_ASSERT_NOT_NULL(ratio);
    for (int vehicle = 0; vehicle < NUM_VEHICLES; vehicle++) {
        for (int i = 0; i < num_each; i++) {
            of_vehicle[i] = ratio[i * NUM_VEHICLES + vehicle];
            TEST_ASSERT_TRUE_MESSAGE(of_vehicle[i] >= 1, vehicle_name[vehicle]);
        }
        const double typical = sweep_quantile(of_vehicle, num_each, 0.5),
                     rare = sweep_quantile(of_vehicle, num_each, 0.85);
        printf("seed %d, %d tasks: %s: median of quick over best %.3f, worst %.3f\n", SEED, num_each,
               vehicle_name[vehicle], typical, of_vehicle[num_each - 1]);
        TEST_ASSERT_TRUE_MESSAGE(typical <= TYPICALLY, vehicle_name[vehicle]);
        TEST_ASSERT_TRUE_MESSAGE(rare <= RARELY, vehicle_name[vehicle]);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_quick_costs_little_more_than_best_whatever_the_vehicle);
    RUN_TEST(test_front_list_and_plan_agree);
    RUN_TEST(test_best_costs_as_little_as_at_the_best_of_its_heights);
    return UNITY_END();
}
