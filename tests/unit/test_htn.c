// The task network search on a domain that has nothing to do with ours, and the example of how to write one: blocks on
// a table, lifted one at a time by an arm, where each block has a weight and carrying costs the weight. The judge is a
// search of its own over the states, Bellman and Ford's, which knows no tasks.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "htn.h"
#include "unity.h"

#define BLOCKS_MAX 5
#define TABLE (-1)

void setUp(void) {}
void tearDown(void) {}

// ---- The domain -----------------------------------------------------------------------------------------------------

enum { REBUILD, MOVE, LIFT, PUT };

static const htn_kind_t kinds[] = {{"rebuild", 2}, {"move", 1}, {"lift", 0}, {"put", 0}};

/// on[b] is what block b stands on; the arm holds nothing between two moves.
typedef struct {
    int count;
    int on[BLOCKS_MAX], goal[BLOCKS_MAX];
    double weight[BLOCKS_MAX];
    int held; ///< TABLE: nothing
    int moves_left;
    int begun; ///< operators that are in effect
} blocks_t;

static bool is_clear(const blocks_t* blocks, int b) {
    for (int i = 0; i < blocks->count; i++) {
        if (blocks->on[i] == b && i != blocks->held) return false;
    }
    return b != blocks->held;
}

static bool apply(void* state, const htn_task_t* task, void* undo, double* cost) {
    blocks_t* blocks = state;
    const int b = task->argument[0];
    if (task->kind == LIFT) {
        if (blocks->held != TABLE || !is_clear(blocks, b)) return false;
        blocks->held = b;
        *cost = 0.25;
    } else {
        const int target = task->argument[1];
        if (blocks->held != b || (target != TABLE && !is_clear(blocks, target))) return false;
        memcpy(undo, &blocks->on[b], sizeof blocks->on[b]);
        *cost = blocks->weight[b] * (target == TABLE ? 1 : 1.5);
        blocks->on[b] = target;
        blocks->held = TABLE;
        blocks->moves_left--;
    }
    blocks->begun++;
    return true;
}

static void undo(void* state, const htn_task_t* task, const void* undo) {
    blocks_t* blocks = state;
    const int b = task->argument[0];
    if (task->kind == LIFT) {
        blocks->held = TABLE;
    } else {
        memcpy(&blocks->on[b], undo, sizeof blocks->on[b]);
        blocks->held = b;
        blocks->moves_left++;
    }
    blocks->begun--;
}

/// rebuild: nothing, if all stands as it should; else one move, and rebuild. move: lift and put.
static htn_binding_t method(void* state, const htn_task_t* task, int number, int binding, htn_subtasks_t* subtasks) {
    const blocks_t* blocks = state;
    const bool done = memcmp(blocks->on, blocks->goal, (size_t)blocks->count * sizeof blocks->on[0]) == 0;
    if (task->kind == MOVE) {
        if (binding > 0) return HTN_NO_MORE;
        subtasks->task[subtasks->count++] = (htn_task_t){LIFT, {task->argument[0]}};
        subtasks->task[subtasks->count++] = (htn_task_t){PUT, {task->argument[0], task->argument[1]}};
        return HTN_BOUND;
    }
    if (number == 0) return binding == 0 && done ? HTN_BOUND : HTN_NO_MORE;
    const int b = binding / (blocks->count + 1), target = binding % (blocks->count + 1) - 1;
    if (b >= blocks->count || done || blocks->moves_left == 0) return HTN_NO_MORE;
    if (b == target || blocks->on[b] == target || !is_clear(blocks, b) ||
        (target != TABLE && !is_clear(blocks, target))) {
        return HTN_SKIP;
    }
    subtasks->task[subtasks->count++] = (htn_task_t){MOVE, {b, target}};
    subtasks->task[subtasks->count++] = (htn_task_t){REBUILD, {0}};
    return HTN_BOUND;
}

/// Each block that is not where it should be is moved once at least.
static double bound(void* state, const htn_agenda_t* agenda) {
    const blocks_t* blocks = state;
    double least = 0;
    if (agenda->task.kind != REBUILD) return 0;
    for (int b = 0; b < blocks->count; b++) {
        if (blocks->on[b] != blocks->goal[b]) least += 0.25 + blocks->weight[b] * (blocks->goal[b] == TABLE ? 1 : 1.5);
    }
    return least;
}

static bool memory_key(void* state, const htn_agenda_t* agenda, unsigned char key[HTN_MAX_KEY]) {
    const blocks_t* blocks = state;
    if (agenda->task.kind != REBUILD) return false;
    for (int b = 0; b < blocks->count; b++) key[b] = (unsigned char)(blocks->on[b] + 2);
    key[BLOCKS_MAX] = (unsigned char)blocks->moves_left;
    return true;
}

/// The search gives the state back to the last bit.
static void assert_same(const blocks_t* expected, const blocks_t* blocks) {
    TEST_ASSERT_EQUAL_INT(expected->count, blocks->count);
    TEST_ASSERT_EQUAL_INT_ARRAY(expected->on, blocks->on, BLOCKS_MAX);
    TEST_ASSERT_EQUAL_INT_ARRAY(expected->goal, blocks->goal, BLOCKS_MAX);
    TEST_ASSERT_EQUAL_MEMORY(expected->weight, blocks->weight, sizeof expected->weight);
    TEST_ASSERT_EQUAL_INT(expected->held, blocks->held);
    TEST_ASSERT_EQUAL_INT(expected->moves_left, blocks->moves_left);
    TEST_ASSERT_EQUAL_INT(expected->begun, blocks->begun);
}

// ---- Seeded problems, and the judge ---------------------------------------------------------------------------------

static uint64_t seed;

static int below(int n) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (int)((seed >> 33) % (uint64_t)n);
}

static void stack_up(int count, int* on) {
    int order[BLOCKS_MAX] = {0};
    for (int i = 0; i < count; i++) {
        const int j = below(i + 1);
        order[i] = order[j];
        order[j] = i;
    }
    for (int i = 0; i < count; i++) on[order[i]] = i == 0 || below(2) == 0 ? TABLE : order[i - 1];
}

static blocks_t problem(int number, int count) {
    blocks_t blocks = {.count = count, .held = TABLE, .moves_left = 2 * count};
    seed = (uint64_t)number * 7919 + 1;
    stack_up(count, blocks.on);
    stack_up(count, blocks.goal);
    for (int b = 0; b < count; b++) blocks.weight[b] = 0.5 + 0.125 * below(32);
    return blocks;
}

#define STATES_MAX 2000

typedef struct {
    int on[BLOCKS_MAX];
    double cost;
} known_t;

/// The least cost by going over all states until nothing changes.
static double judged(const blocks_t* blocks) {
    static known_t known[STATES_MAX];
    int num_known = 1;
    bool changes = true;
    memcpy(known[0].on, blocks->on, sizeof blocks->on);
    known[0].cost = 0;
    while (changes) {
        changes = false;
        for (int k = 0; k < num_known; k++) {
            for (int b = 0; b < blocks->count; b++) {
                for (int to = TABLE; to < blocks->count; to++) {
                    bool free_to_go = b != to && known[k].on[b] != to;
                    for (int i = 0; i < blocks->count; i++) {
                        free_to_go = free_to_go && known[k].on[i] != b && (to == TABLE || known[k].on[i] != to);
                    }
                    if (!free_to_go) continue;
                    known_t next = known[k];
                    int at = 0;
                    next.on[b] = to;
                    next.cost += 0.25 + blocks->weight[b] * (to == TABLE ? 1 : 1.5);
                    while (at < num_known && memcmp(known[at].on, next.on, sizeof next.on) != 0) at++;
                    TEST_ASSERT_LESS_THAN_INT(STATES_MAX, at);
                    if (at < num_known && known[at].cost <= next.cost) continue;
                    known[at] = next;
                    num_known += at == num_known;
                    changes = true;
                }
            }
        }
    }
    for (int k = 0; k < num_known; k++) {
        if (memcmp(known[k].on, blocks->goal, sizeof blocks->goal) == 0) return known[k].cost;
    }
    return INFINITY;
}

static htn_domain_t domain_with(bool has_bound, bool has_key) {
    const htn_domain_t domain = {kinds, 4, apply, undo, method, has_bound ? bound : NULL, has_key ? memory_key : NULL};
    return domain;
}

static const htn_task_t rebuild = {REBUILD, {0}};

/// Does the plan's operators by the domain's own rules. @return their cost; the state must then be the goal.
static double replay(blocks_t blocks, const htn_plan_t* plan) {
    double sum = 0;
    for (int i = 0; i < plan->num_steps; i++) {
        const htn_step_t* step = &plan->steps[i];
        unsigned char memory[HTN_MAX_UNDO];
        double cost = 0;
        TEST_ASSERT_TRUE(i == 0 ? step->level == 0 : step->level <= plan->steps[i - 1].level + 1);
        TEST_ASSERT_EQUAL_INT(kinds[step->task.kind].num_methods == 0, step->method < 0);
        if (step->method >= 0) continue;
        TEST_ASSERT_TRUE(apply(&blocks, &step->task, memory, &cost));
        TEST_ASSERT_EQUAL_DOUBLE(cost, step->cost);
        sum += cost;
    }
    TEST_ASSERT_EQUAL_INT(0, memcmp(blocks.on, blocks.goal, (size_t)blocks.count * sizeof blocks.on[0]));
    return sum;
}

// ---- Tests ----------------------------------------------------------------------------------------------------------

static void test_plans_cost_as_little_as_the_shortest_way_through_all_states(void) {
    for (int number = 0; number < 200; number++) {
        const int count = 2 + number % 4;
        const blocks_t start = problem(number, count);
        const double expected = judged(&start);
        for (int variant = 0; variant < 2; variant++) {
            const htn_domain_t domain = domain_with(variant == 1, true);
            blocks_t blocks = start;
            const htn_limits_t limits = {0};
            htn_result_t result = htn_search(&domain, &blocks, &rebuild, 1, &limits);
            TEST_ASSERT_EQUAL_INT(HTN_OPTIMAL, result.status);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, expected, result.plan.cost); // sums of some ten numbers near 1
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, expected, result.lower_bound);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, expected, replay(start, &result.plan));
            assert_same(&start, &blocks);
            free(result.plan.steps);
        }
    }
}

static void test_without_memory_the_plan_is_the_same(void) {
    for (int number = 0; number < 30; number++) {
        const blocks_t start = problem(number, 2 + number % 2);
        const htn_domain_t domain = domain_with(true, false);
        const htn_limits_t limits = {0};
        blocks_t blocks = start;
        htn_result_t result = htn_search(&domain, &blocks, &rebuild, 1, &limits);
        TEST_ASSERT_EQUAL_INT(HTN_OPTIMAL, result.status);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, judged(&start), result.plan.cost);
        TEST_ASSERT_EQUAL_UINT64(0, result.memories);
        free(result.plan.steps);
    }
}

typedef struct {
    double now_s, last;
    int plans;
} watch_t;

static bool tick(void* context) { return (((watch_t*)context)->now_s += 1) >= 150; }

static bool watch(void* context, const htn_plan_t* plan) {
    watch_t* seen = context;
    TEST_ASSERT_TRUE(plan->cost < seen->last);
    seen->last = plan->cost;
    seen->plans++;
    return true;
}

static void test_a_stopped_search_has_a_plan_and_a_bound_with_the_optimum_between(void) {
    int stopped_with_plan = 0;
    for (int number = 0; number < 100; number++) {
        const blocks_t start = problem(number, 5);
        const double expected = judged(&start);
        for (int by_clock = 0; by_clock < 2; by_clock++) {
            const htn_domain_t domain = domain_with(true, true);
            watch_t seen = {0, INFINITY, 0};
            const htn_limits_t limits = {
                .max_nodes = by_clock ? 0 : 200, .stop = by_clock ? tick : NULL, .found = watch, .context = &seen};
            blocks_t blocks = start;
            htn_result_t result = htn_search(&domain, &blocks, &rebuild, 1, &limits);
            TEST_ASSERT_TRUE(result.lower_bound <= expected + 1e-9);
            TEST_ASSERT_TRUE(result.nodes <= 200);
            assert_same(&start, &blocks);
            if (result.plan.steps != NULL) {
                TEST_ASSERT_TRUE(result.plan.cost >= expected - 1e-9);
                TEST_ASSERT_EQUAL_DOUBLE(seen.last, result.plan.cost);
                TEST_ASSERT_GREATER_THAN_INT(0, seen.plans);
                stopped_with_plan += result.status == HTN_STOPPED;
            } else {
                TEST_ASSERT_EQUAL_INT(HTN_STOPPED, result.status);
            }
            free(result.plan.steps);
        }
    }
    TEST_ASSERT_GREATER_THAN_INT(5, stopped_with_plan);
}

static void test_tasks_are_done_in_the_order_given(void) {
    blocks_t blocks = {.count = 2, .on = {TABLE, TABLE}, .weight = {1, 2}, .held = TABLE, .moves_left = 4};
    const htn_domain_t domain = domain_with(false, false);
    const htn_limits_t limits = {0};
    const htn_task_t tasks[] = {{MOVE, {0, 1}}, {MOVE, {0, TABLE}}, {MOVE, {1, 0}}};
    htn_result_t result = htn_search(&domain, &blocks, tasks, 3, &limits);
    TEST_ASSERT_EQUAL_INT(HTN_OPTIMAL, result.status);
    TEST_ASSERT_EQUAL_INT(9, result.plan.num_steps);
    TEST_ASSERT_EQUAL_DOUBLE(3 * 0.25 + 1.5 + 1 + 3, result.plan.cost);
    for (int i = 0; i < 9; i++) {
        TEST_ASSERT_EQUAL_INT(i % 3 == 0 ? MOVE : i % 3 == 1 ? LIFT : PUT, result.plan.steps[i].task.kind);
        TEST_ASSERT_EQUAL_INT(i % 3 == 0 ? 0 : 1, result.plan.steps[i].level);
    }
    free(result.plan.steps);
}

static void test_what_cannot_be_done_has_no_plan(void) {
    blocks_t blocks = {.count = 2, .on = {TABLE, 0}, .weight = {1, 1}, .held = TABLE, .moves_left = 4};
    const htn_domain_t domain = domain_with(false, false);
    const htn_limits_t limits = {0};
    const htn_task_t buried = {MOVE, {0, TABLE}};
    htn_result_t result = htn_search(&domain, &blocks, &buried, 1, &limits);
    TEST_ASSERT_EQUAL_INT(HTN_NO_PLAN, result.status);
    TEST_ASSERT_NULL(result.plan.steps);
    result = htn_search(&domain, &blocks, NULL, 0, &limits);
    TEST_ASSERT_EQUAL_INT(HTN_OPTIMAL, result.status);
    TEST_ASSERT_EQUAL_INT(0, result.plan.num_steps);
    TEST_ASSERT_EQUAL_DOUBLE(0, result.plan.cost);
    free(result.plan.steps);
}

/// How many ways there are to come from here to the goal for the first time, in so many moves at most.
static int count_ways(const blocks_t* blocks, int moves_left) {
    int count = 0;
    if (memcmp(blocks->on, blocks->goal, sizeof blocks->goal) == 0) return 1;
    if (moves_left == 0) return 0;
    for (int b = 0; b < blocks->count; b++) {
        for (int to = TABLE; to < blocks->count; to++) {
            bool free_to_go = b != to && blocks->on[b] != to;
            for (int i = 0; i < blocks->count; i++) {
                free_to_go = free_to_go && blocks->on[i] != b && (to == TABLE || blocks->on[i] != to);
            }
            if (!free_to_go) continue;
            blocks_t next = *blocks;
            next.on[b] = to;
            count += count_ways(&next, moves_left - 1);
        }
    }
    return count;
}

typedef struct {
    int count;
    double least;
} told_t;

static bool count_plan(void* context, const htn_plan_t* plan) {
    told_t* told = context;
    told->count++;
    told->least = fmin(told->least, plan->cost);
    return true;
}

static void test_all_plans_are_told_if_all_are_wanted(void) {
    const htn_domain_t domain = domain_with(true, true);
    for (int number = 0; number < 20; number++) {
        blocks_t blocks = problem(number, 3);
        told_t told = {0, INFINITY};
        const htn_limits_t limits = {.all = true, .found = count_plan, .context = &told};
        const htn_task_t task = {REBUILD, {0}};
        blocks.moves_left = 4;
        const int count = count_ways(&blocks, blocks.moves_left);
        htn_result_t result = htn_search(&domain, &blocks, &task, 1, &limits);
        TEST_ASSERT_EQUAL_INT(count, told.count);
        TEST_ASSERT_EQUAL_INT(count > 0 ? HTN_OPTIMAL : HTN_NO_PLAN, result.status);
        if (count > 0) TEST_ASSERT_TRUE(result.plan.cost == told.least);
        free(result.plan.steps);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_plans_cost_as_little_as_the_shortest_way_through_all_states);
    RUN_TEST(test_without_memory_the_plan_is_the_same);
    RUN_TEST(test_a_stopped_search_has_a_plan_and_a_bound_with_the_optimum_between);
    RUN_TEST(test_tasks_are_done_in_the_order_given);
    RUN_TEST(test_all_plans_are_told_if_all_are_wanted);
    RUN_TEST(test_what_cannot_be_done_has_no_plan);
    return UNITY_END();
}
