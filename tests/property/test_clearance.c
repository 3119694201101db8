// Random tasks with things around them: every plan keeps clear of them, and says by how much. The judge samples poses
// and has its own formulas (support/scenes). SSV_LONG=1 plans 10,000 tasks in each scene.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "sample.h"
#include "scenes.h"
#include "sweep.h"
#include "unity.h"

// Case k of scene number n starts with sample_seed(SEED + 1000000 n + k).
#define SEED 20261128
#define MAX_CASES 10000
#define POSES 200
// What rounding may do to a pose some ten metres from the origin.
#define ROUNDING_M (strcmp(REAL_NAME, "float") == 0 ? 2e-5 : 1e-6)
#define MARGIN_M 0.03

static const char* const names[SCENE_KINDS] = {"bare", "built", "strewn", "walls"};
static char label[160];

void setUp(void) {}
void tearDown(void) {}

typedef struct {
    bool found, named, overflowed;
    double nearest_m, certified_m, seen_m, named_m, ratio;
} kept_t;

static scene_kind_t kind;
static ssv_effort_t effort;
static bool compares;

static void plan_one(int k, void* result) {
    static ssv_plan_t plan;
    static ssv_scene_t scene;
    static ssv_work_t work;
    ssv_problem_t problem;
    ssv_fault_t fault;
    kept_t* kept = result;
    memset(kept, 0, sizeof *kept);
    sample_seed(SEED + 1000000u * (uint64_t)kind + (uint64_t)k);
    ssv_scenario_t s = scene_task(kind, &scene);
    s.effort = effort;
    if (ssv_problem_init(&problem, &s, &fault) != SSV_OK) return;
    kept->found = ssv_plan(&problem, &work, &plan) == SSV_OK;
    if (!kept->found) {
        // An honest answer of a planner in fixed point, which for another scalar to solve.
        kept->overflowed = plan.quote.status == SSV_NUMERIC_OVERFLOW && strcmp(REAL_NAME, "double") != 0;
        kept->named = plan.quote.status == SSV_INFEASIBLE || kept->overflowed;
        for (int c = 0; c < plan.quote.num_candidates; c++) {
            const ssv_candidate_t* candidate = &plan.quote.candidate[c];
            kept->named = kept->named && candidate->outcome >= SSV_NO_WAY && candidate->clearance_m < s.margin_m;
        }
        return;
    }
    const ssv_clearance_t* c = &plan.clearance;
    const double cost = real_to_double(plan.quote.cost);
    kept->nearest_m = scene_nearest(&s, &plan, POSES).clearance_m;
    kept->certified_m = real_to_double(c->certified_m);
    kept->seen_m = real_to_double(c->seen_m);
    kept->named_m = scene_distance(&s, &plan, c->leg, real_to_double(c->s), c->body == SSV_BODY_BEAM, c->obstacle);
    if (!compares) return;
    s.scene = NULL;
    s.obstacles = 0;
    s.margin_m = real_from_double(0);
    if (ssv_problem_init(&problem, &s, &fault) != SSV_OK || ssv_plan(&problem, &work, &plan) != SSV_OK) return;
    kept->ratio = cost / real_to_double(plan.quote.cost);
}

// All of the first two scenes, and of the others all but 5 in 1,000, one at least.
static int fewest(int count) { return kind < SCENE_STREWN ? count : count - (count + 199) / 200; }

// Every plan is judged. @return how many were found.
static int judge(int count) {
    static double ratio[MAX_CASES];
    int found = 0, overflowed = 0;
    double least = INFINITY, sum = 0;
    const kept_t* all = sweep(names[kind], count, sizeof *all, plan_one);
    TEST_ASSERT_NOT_NULL(all);
    for (int k = 0; k < count; k++) {
        const kept_t* kept = &all[k];
        (void)snprintf(label, sizeof label, "%s, case %d: nearest %.6f, certified %.6f, seen %.6f, there %.6f",
                       names[kind], k, kept->nearest_m, kept->certified_m, kept->seen_m, kept->named_m);
        if (!kept->found) {
            TEST_ASSERT_TRUE_MESSAGE(kept->named, label);
            overflowed += kept->overflowed;
            continue;
        }
        TEST_ASSERT_TRUE_MESSAGE(kept->certified_m >= MARGIN_M - ROUNDING_M, label);
        TEST_ASSERT_TRUE_MESSAGE(kept->nearest_m >= kept->certified_m - ROUNDING_M, label);
        TEST_ASSERT_TRUE_MESSAGE(kept->seen_m - kept->certified_m <= 0.005, label);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(ROUNDING_M, kept->seen_m, kept->named_m, label);
        least = fmin(least, kept->nearest_m);
        ratio[found++] = kept->ratio;
        sum += kept->ratio;
    }
    printf("%s, effort %s: %d of %d found, nearest %.1f mm", names[kind], effort == SSV_EFFORT_BEST ? "best" : "quick",
           found, count, 1e3 * least);
    if (compares) {
        printf("; J over that in free space: mean %.4f, 90 %% below %.3f", sum / found,
               sweep_quantile(ratio, found, 0.9));
    }
    if (overflowed > 0) printf("; %d overflowed", overflowed);
    printf("\n");
    return found;
}

static void test_quick_plans_keep_the_margin_and_say_where_they_come_nearest(void) {
    const int count = sweep_count(strcmp(REAL_NAME, "double") == 0 ? 400 : 60, MAX_CASES);
    effort = SSV_EFFORT_QUICK;
    compares = false;
    for (kind = SCENE_BARE; kind < SCENE_KINDS; kind++) {
        TEST_ASSERT_GREATER_OR_EQUAL_INT(fewest(count), judge(count));
    }
}

static void test_best_plans_find_a_way_that_costs_little_more_than_in_free_space(void) {
    if (strcmp(REAL_NAME, "double") != 0) TEST_IGNORE_MESSAGE("judged in double");
    const int count = sweep_count(60, 1000);
    effort = SSV_EFFORT_BEST;
    compares = true;
    for (kind = SCENE_BARE; kind < SCENE_KINDS; kind++) {
        TEST_ASSERT_GREATER_OR_EQUAL_INT(fewest(count), judge(count));
    }
}

static void test_more_effort_never_costs_more(void) {
    static ssv_plan_t plan;
    static ssv_scene_t scene;
    static ssv_work_t work;
    ssv_problem_t problem;
    ssv_fault_t fault;
    const int count = sweep_count(strcmp(REAL_NAME, "double") == 0 ? 100 : 10, 1000);
    for (int k = 0; k < count; k++) {
        sample_seed(SEED + 8000000u + (uint64_t)k);
        ssv_scenario_t s = scene_task(SCENE_WALLS, &scene);
        double cost[2];
        bool found[2], overflowed = false;
        for (int more = 0; more < 2; more++) {
            s.effort = (ssv_effort_t)more;
            TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &s, &fault));
            found[more] = ssv_plan(&problem, &work, &plan) == SSV_OK;
            cost[more] = real_to_double(plan.quote.cost);
            overflowed = overflowed || plan.quote.status == SSV_NUMERIC_OVERFLOW;
        }
        if (overflowed && strcmp(REAL_NAME, "double") != 0) continue;
        (void)snprintf(label, sizeof label, "case %d", k);
        TEST_ASSERT_TRUE_MESSAGE(found[1] || !found[0], label);
        if (found[0]) TEST_ASSERT_TRUE_MESSAGE(cost[1] <= cost[0], label);
    }
}

static void test_optimal_never_costs_more_than_paper_where_both_find_a_way(void) {
    static ssv_plan_t plan;
    static ssv_scene_t scene;
    static ssv_work_t work;
    ssv_problem_t problem;
    ssv_fault_t fault;
    int both = 0;
    const int count = sweep_count(strcmp(REAL_NAME, "double") == 0 ? 200 : 30, 2000);
    for (int k = 0; k < count; k++) {
        sample_seed(SEED + 9000000u + (uint64_t)k);
        ssv_scenario_t s = scene_task((scene_kind_t)(k % SCENE_KINDS), &scene);
        double cost[2];
        bool found[2];
        for (int method = 0; method < 2; method++) {
            s.method = (ssv_method_t)method;
            TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &s, &fault));
            found[method] = ssv_plan(&problem, &work, &plan) == SSV_OK;
            cost[method] = real_to_double(plan.quote.cost);
            (void)snprintf(label, sizeof label, "case %d, method %d", k, method);
            if (found[method])
                TEST_ASSERT_TRUE_MESSAGE(scene_nearest(&s, &plan, POSES).clearance_m >= MARGIN_M - ROUNDING_M, label);
        }
        TEST_ASSERT_TRUE_MESSAGE(found[0] || !found[1], label);
        if (!found[1]) continue;
        both++;
        TEST_ASSERT_TRUE_MESSAGE(cost[0] <= cost[1] * (1 + 1e-6), label);
    }
    printf("the paper's way is free in %d of %d\n", both, count);
    TEST_ASSERT_GREATER_THAN_INT(count / 8, both);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_quick_plans_keep_the_margin_and_say_where_they_come_nearest);
    RUN_TEST(test_best_plans_find_a_way_that_costs_little_more_than_in_free_space);
    RUN_TEST(test_more_effort_never_costs_more);
    RUN_TEST(test_optimal_never_costs_more_than_paper_where_both_find_a_way);
    return UNITY_END();
}
