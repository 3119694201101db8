// What holds for the price of every task. SSV_LONG=1 runs the full sweeps.
#include <stdio.h>
#include <string.h>

#include "sample.h"
#include "sweep.h"
#include "unity.h"

// Case k of a sweep starts with sample_seed(SEED + k).
#define SEED 20261123
// One task in so many is searched with effort best, too.
#define BEST_EVERY 50
#define SAME_PRICE 1e-6
// Cases of the full sweeps.
#define MAX_TASKS 100000
#define MAX_BOUNDS 1000000
#define MAX_PLANS 10000
#define MAX_FRONTS 2000
#define MAX_ANYWHERE 5000

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
    (void)snprintf(text, sizeof text, "%s, first by sample_seed(%d)", what, SEED + breaches.first);
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, breaches.count, text);
}

// False: the scenario was refused, or no candidate is feasible. No task of these sweeps is so.
static bool quote_of(const ssv_scenario_t* s, ssv_quote_t* quote) {
    ssv_problem_t problem;
    ssv_work_t work;
    ssv_fault_t fault;
    memset(quote, 0, sizeof *quote); // all that is read of one that was refused
    return ssv_problem_init(&problem, s, &fault) == SSV_OK && ssv_quote(&problem, &work, quote) == SSV_OK;
}

static double price(const ssv_scenario_t* s) {
    ssv_quote_t quote;
    return quote_of(s, &quote) ? quote.cost : (double)NAN;
}

static ssv_scenario_t task(int k, ssv_method_t method, ssv_effort_t effort) {
    sample_seed(SEED + (uint64_t)k);
    ssv_scenario_t s = sample_scenario();
    s.method = method;
    s.effort = effort;
    return s;
}

// ---- Against the paper and the lower bound --------------------------------------------------------------------------

typedef struct {
    double bound, paper, quick, best; // best 0: not asked
} prices_t;

static void price_all_ways(int k, void* result) {
    prices_t* p = result;
    ssv_scenario_t s = task(k, SSV_METHOD_OPTIMAL, SSV_EFFORT_QUICK);
    ssv_quote_t quote;
    p->quick = quote_of(&s, &quote) ? quote.cost : (double)NAN;
    p->bound = quote.lower_bound;
    s.effort = SSV_EFFORT_BEST;
    if (k % BEST_EVERY == 0) p->best = price(&s);
    s.method = SSV_METHOD_PAPER;
    p->paper = price(&s);
}

static void test_optimal_never_costs_more_than_paper_nor_best_more_than_quick_nor_any_less_than_the_lower_bound(void) {
    const int count = sweep_count(300, MAX_TASKS);
    const prices_t* p = sweep("optimal, paper and bound", count, sizeof *p, price_all_ways);
    static double saved[MAX_TASKS], gap[MAX_TASKS], gained[MAX_TASKS];
    int num_best = 0;
    breaches_t no_price = {0, 0}, above_paper = {0, 0}, above_quick = {0, 0}, below_bound = {0, 0};
    TEST_ASSERT_NOT_NULL(p);
    for (int k = 0; k < count; k++) {
        expect(isfinite(p[k].quick) && isfinite(p[k].best) && isfinite(p[k].paper) && p[k].bound > 0, k, &no_price);
        expect(!(p[k].quick > p[k].paper), k, &above_paper);
        expect(!(p[k].quick < p[k].bound), k, &below_bound);
        saved[k] = 1 - p[k].quick / p[k].paper;
        gap[k] = p[k].quick / p[k].bound - 1;
        if (k % BEST_EVERY != 0) continue;
        expect(!(p[k].best > p[k].quick), k, &above_quick);
        expect(!(p[k].best < p[k].bound), k, &below_bound);
        gained[num_best++] = 1 - p[k].best / p[k].quick;
    }
    printf(
        "seed %d, %d tasks: quick saves %.1f %% on paper (median; 1 in 100 below %.1f %%), is %.1f %% above the "
        "bound\n",
        SEED, count, 100 * sweep_quantile(saved, count, 0.5), 100 * sweep_quantile(saved, count, 0.01),
        100 * sweep_quantile(gap, count, 0.5));
    printf("of them %d: best saves another %.1f %% (median; 1 in 100 above %.1f %%)\n", num_best,
           100 * sweep_quantile(gained, num_best, 0.5), 100 * sweep_quantile(gained, num_best, 0.99));
    printf("%d without a price, %d above paper, %d best above quick, %d below the bound\n", no_price.count,
           above_paper.count, above_quick.count, below_bound.count);
    assert_none("no price", no_price);
    assert_none("quick above paper", above_paper);
    assert_none("best above quick", above_quick);
    assert_none("below the bound", below_bound);
}

static void price_by_paper(int k, void* result) {
    prices_t* p = result;
    const ssv_scenario_t s = task(k, SSV_METHOD_PAPER, SSV_EFFORT_QUICK);
    ssv_quote_t quote;
    p->paper = quote_of(&s, &quote) ? quote.cost : (double)NAN;
    p->bound = quote.lower_bound;
}

static void test_paper_never_costs_less_than_the_lower_bound(void) {
    const int count = sweep_count(5000, MAX_BOUNDS);
    const prices_t* p = sweep("paper and bound", count, sizeof *p, price_by_paper);
    static double gap[MAX_BOUNDS];
    breaches_t below_bound = {0, 0};
    TEST_ASSERT_NOT_NULL(p);
    for (int k = 0; k < count; k++) {
        expect(p[k].bound > 0 && p[k].bound <= p[k].paper, k, &below_bound);
        gap[k] = p[k].paper / p[k].bound - 1;
    }
    printf("seed %d, %d tasks: paper is %.1f %% above the bound (median)\n", SEED, count,
           100 * sweep_quantile(gap, count, 0.5));
    assert_none("below the bound", below_bound);
}

// ---- Invariance -----------------------------------------------------------------------------------------------------

enum { MOVED, MIRRORED, TIMES_3, TIMES_4, NUM_CHANGES };
static const char* const change_name[NUM_CHANGES] = {"moved", "mirrored", "weights times 3", "weights times 4"};

typedef struct {
    double off[NUM_CHANGES]; // relative change of the price
} changes_t;

static void change(ssv_method_t method, bool anywhere, int k, changes_t* result) {
    ssv_scenario_t s = task(k, method, SSV_EFFORT_QUICK);
    s.attach_anywhere = anywhere;
    ssv_scenario_t changed[NUM_CHANGES] = {s, s, s, s};
    const vec3_t p = sample_vector(100);
    changed[MOVED] = scenario_moved(&s, (pose_t){p, sample_attitude()});
    const mirror_axis_t vehicle_axis = sample_below(2) == 0 ? MIRROR_Y : MIRROR_Z;
    changed[MIRRORED] = scenario_mirrored(&s, vehicle_axis, (mirror_axis_t)sample_below(3));
    static const double factor[NUM_CHANGES] = {1, 1, 3, 4};
    const double J = price(&s);
    for (int n = 0; n < NUM_CHANGES; n++) {
        changed[n].weight_time_per_s *= factor[n];
        changed[n].weight_impulse_per_Ns *= factor[n];
        result->off[n] = price(&changed[n]) / (factor[n] * J) - 1;
    }
}

static void change_paper(int k, void* result) { change(SSV_METHOD_PAPER, false, k, result); }
static void change_optimal(int k, void* result) { change(SSV_METHOD_OPTIMAL, false, k, result); }
static void change_anywhere(int k, void* result) { change(SSV_METHOD_OPTIMAL, true, k, result); }

static void check_invariance(const char* name, int count, void (*run)(int k, void* result)) {
    const changes_t* c = sweep(name, count, sizeof *c, run);
    breaches_t changed[NUM_CHANGES] = {{0, 0}};
    TEST_ASSERT_NOT_NULL(c);
    for (int n = 0; n < NUM_CHANGES; n++) {
        double worst = 0;
        for (int k = 0; k < count; k++) {
            const double off = fabs(c[k].off[n]);
            // Times a power of two not even rounding may differ.
            expect(off <= (n == TIMES_4 ? 0 : SAME_PRICE), k, &changed[n]);
            worst = fmax(worst, off);
        }
        printf("%s, %d tasks %s: price differs by %.1e at most, too much in %d", name, count, change_name[n], worst,
               changed[n].count);
        if (changed[n].count > 0) printf(", first sample_seed(%d)", SEED + changed[n].first);
        printf("\n");
    }
    for (int n = 0; n < NUM_CHANGES; n++) assert_none(change_name[n], changed[n]);
}

static void test_price_by_paper_has_no_place_or_handedness_and_scales_with_the_weights(void) {
    check_invariance("paper", sweep_count(1000, MAX_TASKS), change_paper);
}

static void test_price_by_optimal_has_no_place_or_handedness_and_scales_with_the_weights(void) {
    check_invariance("optimal", sweep_count(200, MAX_TASKS), change_optimal);
    check_invariance("optimal, anywhere along the beam", sweep_count(20, MAX_ANYWHERE), change_anywhere);
}

static bool same_price(const ssv_quote_t* a, const ssv_quote_t* b) {
    const ssv_candidate_t *x = &a->choice, *y = &b->choice;
    return a->scenario_hash == b->scenario_hash && a->cost == b->cost && a->time_s == b->time_s &&
           a->impulse_Ns == b->impulse_Ns && a->lower_bound == b->lower_bound && x->contact == y->contact &&
           x->attach_height_m == y->attach_height_m && x->ring_angle_rad == y->ring_angle_rad;
}

// ---- Anywhere along the beam ----------------------------------------------------------------------------------------

static ssv_scenario_t anywhere(int k, ssv_effort_t effort) {
    ssv_scenario_t s = task(k, SSV_METHOD_OPTIMAL, effort);
    s.want_candidates = false;
    s.attach_anywhere = true;
    return s;
}

typedef struct {
    double given, anywhere, bound, paper;
    bool on_beam, as_quoted, bounded; // bounded: no bound is above that for the heights given
} freed_t;

static void free_height(int k, void* result) {
    static ssv_plan_t plan;
    freed_t* f = result;
    ssv_scenario_t s = anywhere(k, k % BEST_EVERY == 0 ? SSV_EFFORT_BEST : SSV_EFFORT_QUICK);
    const double end = 0.5 * s.beam.length_m;
    ssv_problem_t problem;
    ssv_work_t work;
    ssv_quote_t quote;
    ssv_fault_t fault;
    f->anywhere = quote_of(&s, &quote) ? quote.cost : (double)NAN;
    f->bound = quote.lower_bound;
    f->on_beam = fabs(quote.choice.attach_height_m) <= end;
    f->as_quoted = ssv_problem_init(&problem, &s, &fault) == SSV_OK && ssv_plan(&problem, &work, &plan) == SSV_OK &&
                   same_price(&plan.quote, &quote);
    s.attach_anywhere = false;
    f->given = quote_of(&s, &quote) ? quote.cost : (double)NAN;
    f->bounded = f->bound <= quote.lower_bound;
    // The bound must hold for whichever height the asker might have given instead.
    s.num_attach_heights = 1;
    s.attach_heights_m[0] = sample_between(-end, end);
    s.method = SSV_METHOD_PAPER;
    f->paper = price(&s);
}

static void test_price_anywhere_along_the_beam_is_never_above_that_at_the_heights_given_nor_below_its_bound(void) {
    const int count = sweep_count(60, MAX_ANYWHERE);
    const freed_t* f = sweep("anywhere along the beam", count, sizeof *f, free_height);
    static double saved[MAX_ANYWHERE];
    breaches_t above = {0, 0}, below_bound = {0, 0}, off_beam = {0, 0}, other_plan = {0, 0};
    TEST_ASSERT_NOT_NULL(f);
    for (int k = 0; k < count; k++) {
        expect(f[k].anywhere <= f[k].given, k, &above);
        expect(f[k].bounded && f[k].bound <= f[k].anywhere && f[k].bound <= f[k].paper, k, &below_bound);
        expect(f[k].on_beam, k, &off_beam);
        expect(f[k].as_quoted, k, &other_plan);
        saved[k] = 1 - f[k].anywhere / f[k].given;
    }
    printf("seed %d, %d tasks: anywhere saves %.2f %% (median; 1 in 100 above %.1f %%)\n", SEED, count,
           100 * sweep_quantile(saved, count, 0.5), 100 * sweep_quantile(saved, count, 0.99));
    assert_none("above the heights given", above);
    assert_none("below the bound", below_bound);
    assert_none("off the beam", off_beam);
    assert_none("quoted is not what is planned", other_plan);
    // A step that never gained would pass all that.
    TEST_ASSERT_TRUE(sweep_quantile(saved, count, 0.9) > 0.005);
}

// ---- Quotes, plans and fronts ---------------------------------------------------------------------------------------

typedef enum { AS_QUOTED, BY_PAPER, DIFFERENT } plan_outcome_t;

static void compare_quote_with_plan(int k, void* result) {
    const ssv_scenario_t s = task(k, SSV_METHOD_OPTIMAL, k % BEST_EVERY == 0 ? SSV_EFFORT_BEST : SSV_EFFORT_QUICK);
    static ssv_plan_t plan;
    ssv_problem_t problem;
    ssv_work_t work;
    ssv_quote_t quote;
    ssv_fault_t fault;
    plan_outcome_t* outcome = result;
    *outcome = DIFFERENT;
    if (ssv_problem_init(&problem, &s, &fault) != SSV_OK ||
        ssv_plan(&problem, &work, &plan) != ssv_quote(&problem, &work, &quote))
        return;
    bool by_paper = true;
    double time_s = 0, impulse_Ns = 0; // of what is flown, leg by leg
    for (int n = 0; n < plan.num_legs; n++) {
        by_paper = by_paper && plan.leg[n].ramp != SSV_OPTIMAL;
        time_s += plan.leg[n].duration_s;
        impulse_Ns += plan.leg[n].impulse_Ns;
    }
    if (time_s != plan.quote.time_s || impulse_Ns != plan.quote.impulse_Ns) return;
    *outcome = same_price(&plan.quote, &quote) ? AS_QUOTED : by_paper ? BY_PAPER : DIFFERENT;
}

static void test_quote_is_the_price_of_the_plan_to_the_last_bit(void) {
    const int count = sweep_count(200, MAX_PLANS);
    const plan_outcome_t* outcome = sweep("quote and plan", count, sizeof *outcome, compare_quote_with_plan);
    int by_paper = 0;
    breaches_t different = {0, 0};
    TEST_ASSERT_NOT_NULL(outcome);
    for (int k = 0; k < count; k++) {
        expect(outcome[k] != DIFFERENT, k, &different);
        by_paper += outcome[k] == BY_PAPER;
    }
    printf("seed %d, %d plans: %d did not fit the plan's memory and are the paper's chain\n", SEED, count, by_paper);
    assert_none("quoted is not what is planned", different);
    TEST_ASSERT_TRUE(by_paper <= count / 1000);
}

typedef struct {
    int num_points;
    bool undominated, has_quote, priced;
} front_check_t;

static void check_front(int k, void* result) {
    const ssv_scenario_t s = task(k, k % 2 == 0 ? SSV_METHOD_OPTIMAL : SSV_METHOD_PAPER, SSV_EFFORT_QUICK);
    front_check_t* check = result;
    ssv_problem_t problem;
    ssv_work_t work;
    ssv_quote_t quote;
    ssv_front_t front;
    ssv_fault_t fault;
    if (ssv_problem_init(&problem, &s, &fault) != SSV_OK || ssv_quote(&problem, &work, &quote) != SSV_OK) return;
    if (ssv_front(&problem, &work, &front) != SSV_OK) return;
    check->num_points = front.num_points;
    check->undominated = check->priced = true;
    for (int a = 0; a < front.num_points; a++) {
        const ssv_candidate_t* point = &front.point[a];
        // In order of growing time, impulse falls: then no point is as good as another in both.
        if (a > 0 && (point->time_s <= point[-1].time_s || point->impulse_Ns >= point[-1].impulse_Ns)) {
            check->undominated = false;
        }
        const double J = s.weight_time_per_s * point->time_s + s.weight_impulse_per_Ns * point->impulse_Ns;
        if (fabs(point->cost - J) > 1e-12 * J) check->priced = false;
        // The quote's own point, or one that is better in both.
        if (point->time_s <= quote.time_s && point->impulse_Ns <= quote.impulse_Ns) check->has_quote = true;
    }
}

static void test_front_has_no_dominated_point_and_none_that_the_quote_betters(void) {
    const int count = sweep_count(40, MAX_FRONTS);
    const front_check_t* check = sweep("front", count, sizeof *check, check_front);
    static double points[MAX_FRONTS];
    breaches_t empty = {0, 0}, dominated = {0, 0}, without_quote = {0, 0}, wrong_price = {0, 0};
    TEST_ASSERT_NOT_NULL(check);
    for (int k = 0; k < count; k++) {
        expect(check[k].num_points > 0, k, &empty);
        expect(check[k].undominated, k, &dominated);
        expect(check[k].has_quote, k, &without_quote);
        expect(check[k].priced, k, &wrong_price);
        points[k] = check[k].num_points;
    }
    printf("seed %d, %d fronts of %.0f points (median; at most %.0f)\n", SEED, count,
           sweep_quantile(points, count, 0.5), sweep_quantile(points, count, 1));
    assert_none("empty front", empty);
    assert_none("dominated point", dominated);
    assert_none("without the quote", without_quote);
    assert_none("wrong price", wrong_price);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_optimal_never_costs_more_than_paper_nor_best_more_than_quick_nor_any_less_than_the_lower_bound);
    RUN_TEST(test_paper_never_costs_less_than_the_lower_bound);
    RUN_TEST(test_price_by_paper_has_no_place_or_handedness_and_scales_with_the_weights);
    RUN_TEST(test_price_by_optimal_has_no_place_or_handedness_and_scales_with_the_weights);
    RUN_TEST(test_price_anywhere_along_the_beam_is_never_above_that_at_the_heights_given_nor_below_its_bound);
    RUN_TEST(test_quote_is_the_price_of_the_plan_to_the_last_bit);
    RUN_TEST(test_front_has_no_dominated_point_and_none_that_the_quote_betters);
    return UNITY_END();
}
