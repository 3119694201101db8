// Schedules of small random structures against a judge that tries every order and every choice of beams, and asks the
// planner itself, with rounding, scene and rules of its own. SSV_LONG=1 judges 2,000.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "estimate.h"
#include "pricing.h"
#include "sample.h"
#include "ssv/answer.h"
#include "structures.h"
#include "sweep.h"
#include "unity.h"

// Structure k starts with sample_seed(SEED + k).
#define SEED 20261129
#define SLOTS 3

void setUp(void) {}
void tearDown(void) {}

static structure_t sample_structure(int number) {
    sample_seed(SEED + (uint64_t)number);
    return structures_sample(SLOTS);
}

static assembly_result_t scheduled(const structure_t* structure, int threads) {
    static const assembly_limits_t limits = {0};
    assembly_result_t result;
    pricing_t* const pricing = pricing_open(structure, threads);
    TEST_ASSERT_NOT_NULL(pricing);
    const assembly_prices_t prices = {pricing_ask, pricing};
    TEST_ASSERT_TRUE(assembly_schedule(structure, &prices, &limits, &result));
    pricing_close(pricing);
    return result;
}

// ---- The judge ------------------------------------------------------------------------------------------------------

static vec3_t vector_of(const double n[3]) {
    return vec3(real_from_double(n[0]), real_from_double(n[1]), real_from_double(n[2]));
}

static real_t rounded(real_t x) { return real_from_double(floor(real_to_double(x) * 1048576 + 0.5) / 1048576); }

static pose_t rounded_pose(pose_t X) {
    const quat_t q = X.q;
    const bool negative =
        real_to_double(q.w) < -0x1p-21 || (fabs(real_to_double(q.w)) <= 0x1p-21 && real_to_double(q.x) < 0);
    const real_t sign = real_from_int(negative ? -1 : 1);
    const pose_t r = {vec3(rounded(X.p.x), rounded(X.p.y), rounded(X.p.z)),
                      {rounded(real_mul(sign, q.w)), rounded(real_mul(sign, q.x)), rounded(real_mul(sign, q.y)),
                       rounded(real_mul(sign, q.z))}};
    return r;
}

typedef struct {
    const structure_t* structure;
    ssv_scenario_t task;
    ssv_scene_t scene;
    int num_plans; ///< orders that end well
} judge_t;

static void stand(ssv_scene_t* scene, const double from[3], const double to[3], double radius_m) {
    ssv_obstacle_t* const o = &scene->obstacle[scene->num_obstacles++];
    const vec3_t line = vec3_sub(vector_of(to), vector_of(from));
    const double length = real_to_double(vec3_norm(line));
    *o = (ssv_obstacle_t){.kind = SSV_CAPSULE,
                          .p_I_m = vector_of(from),
                          .length_m = real_from_double(length),
                          .radius_m = real_from_double(radius_m)};
    if (length > 0) o->axis_I = vec3_unit(line);
}

/// A beam to a slot from there, with what is built in the way.
static ssv_scenario_t task_of(const judge_t* judge, pose_t X_IS, uint64_t built, int last, int b, int s) {
    const structure_t* const structure = judge->structure;
    const structure_slot_t* const slot = &structure->slot[s];
    const structure_beam_t* const beam = &structure->beam[b];
    const structure_port_t* const port = &structure->hub[slot->hub[0]].port[slot->port[0]];
    ssv_scenario_t task = judge->task;
    task.X_IS = X_IS;
    task.X_IB = (pose_t){vector_of(beam->p_IB_m),
                         {real_from_double(beam->q_IB[0]), real_from_double(beam->q_IB[1]),
                          real_from_double(beam->q_IB[2]), real_from_double(beam->q_IB[3])}};
    task.p_IP_m = vector_of(port->p_IP_m);
    task.axis_I = vector_of(port->axis_I);
    if (structure->obstacles) {
        task.scene = &judge->scene;
        for (int h = 0; h < structure->num_hubs; h++) task.obstacles |= UINT64_C(1) << h;
        task.obstacles |= built << structure->num_hubs;
        task.left = last < 0 ? 0 : UINT64_C(1) << (structure->num_hubs + last);
    }
    return task;
}

static bool is_priced(const ssv_scenario_t* task, ssv_quote_t* quote) {
    static ssv_work_t work;
    ssv_problem_t problem;
    ssv_fault_t fault;
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, task, &fault));
    return ssv_quote(&problem, &work, quote) == SSV_OK;
}

/// The least that the rest costs from here on.
static double least(judge_t* judge, pose_t X_IS, uint64_t built, uint64_t used, int last) {
    const structure_t* const structure = judge->structure;
    double best = INFINITY;
    if (built == (UINT64_C(1) << structure->num_slots) - 1) {
        judge->num_plans++;
        return 0;
    }
    for (int s = 0; s < structure->num_slots; s++) {
        const structure_slot_t* const slot = &structure->slot[s];
        bool allowed = (built >> s & 1) == 0 && (built & slot->after) == slot->after, touches = built == 0;
        for (int k = 0; k < structure->num_slots; k++) {
            touches = touches || ((built >> k & 1) != 0 && structures_share_a_hub(slot, &structure->slot[k]));
        }
        allowed = allowed && (touches || !structure->touching);
        for (int b = 0; b < structure->num_beams && allowed; b++) {
            bool fits = (used >> b & 1) == 0 && (slot->beam < 0 || slot->beam == b);
            for (int k = 0; k < structure->num_slots; k++) fits = fits && (k == s || structure->slot[k].beam != b);
            if (!fits) continue;
            const ssv_scenario_t task = task_of(judge, X_IS, built, last, b, s);
            ssv_quote_t quote;
            if (!is_priced(&task, &quote)) continue;
            best = fmin(best, real_to_double(quote.cost) + least(judge, rounded_pose(quote.X_IS_final),
                                                                 built | UINT64_C(1) << s, used | UINT64_C(1) << b, s));
        }
    }
    return best;
}

static void judge_init(judge_t* judge, const structure_t* structure) {
    *judge = (judge_t){.structure = structure};
    ssv_scenario_from_wire(&judge->task, &structure->task, NULL);
    for (int h = 0; h < structure->num_hubs; h++) {
        stand(&judge->scene, structure->hub[h].p_IH_m, structure->hub[h].p_IH_m, structure->hub[h].radius_m);
    }
    for (int s = 0; s < structure->num_slots; s++) {
        const structure_slot_t* const slot = &structure->slot[s];
        stand(&judge->scene, structure->hub[slot->hub[0]].port[slot->port[0]].p_IP_m,
              structure->hub[slot->hub[1]].port[slot->port[1]].p_IP_m, structure->task.beam.radius_m);
    }
}

static pose_t start_of(const structure_t* structure) {
    return (pose_t){vector_of(structure->p_IS_m),
                    {real_from_double(structure->q_IS[0]), real_from_double(structure->q_IS[1]),
                     real_from_double(structure->q_IS[2]), real_from_double(structure->q_IS[3])}};
}

static double judged(const structure_t* structure, int* num_plans) {
    static judge_t judge;
    judge_init(&judge, structure);
    const double cost = least(&judge, rounded_pose(start_of(structure)), 0, 0, -1);
    *num_plans = judge.num_plans;
    return cost;
}

// ---- Tests ----------------------------------------------------------------------------------------------------------

static char label[160];

static void test_schedules_cost_what_the_best_of_all_orders_costs(void) {
    int several = 0, none = 0, greedy_worse = 0;
    const int count = sweep_count(200, 2000);
    for (int k = 0; k < count; k++) {
        int num_plans = 0;
        const structure_t structure = sample_structure(k);
        const assembly_result_t result = scheduled(&structure, 0);
        const double cost = judged(&structure, &num_plans);
        (void)snprintf(label, sizeof label, "structure %d: %.9g, judged %.9g of %d", k, result.best.cost, cost,
                       num_plans);
        several += num_plans > 1;
        if (num_plans == 0) {
            TEST_ASSERT_EQUAL_INT_MESSAGE(HTN_NO_PLAN, result.status, label);
            TEST_ASSERT_EQUAL_INT_MESSAGE(0, result.best.num_parts, label);
            none++;
            continue;
        }
        TEST_ASSERT_EQUAL_INT_MESSAGE(HTN_OPTIMAL, result.status, label);
        TEST_ASSERT_EQUAL_INT_MESSAGE(SLOTS, result.best.num_parts, label);
        // The judge's capsules differ from the pricing's by rounding.
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-6 * cost, cost, result.best.cost, label);
        if (result.greedy.num_parts == 0) continue;
        TEST_ASSERT_TRUE_MESSAGE(result.greedy.cost >= result.best.cost * (1 - 1e-12), label);
        greedy_worse += result.greedy.cost > result.best.cost * (1 + 1e-9);
    }
    printf("%d structures: %d with several ways, %d with none; greedy is worse in %d\n", count, several, none,
           greedy_worse);
    TEST_ASSERT_GREATER_THAN_INT(count / 2, several);
    TEST_ASSERT_GREATER_THAN_INT(count / 8, greedy_worse);
}

/// One part after another: the second from where the first one's plan ends exactly, and from there as the scheduler
/// rounds it.
static void test_rounding_of_poses_changes_no_price(void) {
    static judge_t judge;
    int count = 0, otherwise = 0;
    double worst = 0;
    for (int k = 0; k < sweep_count(60, 600); k++) {
        const structure_t structure = sample_structure(k);
        judge_init(&judge, &structure);
        ssv_quote_t first, exact, rough;
        const ssv_scenario_t before = task_of(&judge, start_of(&structure), 0, -1, 0, 0);
        if (!is_priced(&before, &first)) continue;
        for (int s = 1; s < structure.num_slots; s++) {
            const ssv_scenario_t task = task_of(&judge, first.X_IS_final, 1, 0, 1, s),
                                 from_rounded = task_of(&judge, rounded_pose(first.X_IS_final), 1, 0, 1, s);
            const bool has_price = is_priced(&task, &exact);
            otherwise += has_price != is_priced(&from_rounded, &rough);
            if (!has_price || rough.status != SSV_OK) continue;
            count++;
            worst = fmax(worst, fabs(real_to_double(rough.cost) / real_to_double(exact.cost) - 1));
        }
    }
    printf("%d prices: rounding changes them by %.1e at most; %d have a plan in one case alone\n", count, worst,
           otherwise);
    TEST_ASSERT_GREATER_THAN_INT(40, count);
    TEST_ASSERT_EQUAL_INT(0, otherwise);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0, worst);
}

/// A random order of 0..count-1.
static void shuffle(int* order, int count) {
    for (int i = 0; i < count; i++) {
        const int j = sample_below(i + 1);
        order[i] = order[j];
        order[j] = i;
    }
}

/// The same structure with hubs, beams and slots in another order, by other names.
static structure_t reordered(const structure_t* from, int number) {
    int hubs[STRUCTURE_MAX_HUBS], beams[STRUCTURE_MAX_BEAMS], slots[STRUCTURE_MAX_SLOTS];
    structure_t s = *from;
    sample_seed(SEED + 1000000u + (uint64_t)number);
    shuffle(hubs, s.num_hubs);
    shuffle(beams, s.num_beams);
    shuffle(slots, s.num_slots);
    for (int h = 0; h < s.num_hubs; h++) s.hub[hubs[h]] = from->hub[h];
    for (int b = 0; b < s.num_beams; b++) s.beam[beams[b]] = from->beam[b];
    for (int i = 0; i < s.num_slots; i++) {
        structure_slot_t* const slot = &s.slot[slots[i]];
        *slot = from->slot[i];
        (void)snprintf(slot->name, sizeof slot->name, "s%d", number + i);
        for (int end = 0; end < 2; end++) slot->hub[end] = hubs[slot->hub[end]];
        if (slot->beam >= 0) slot->beam = beams[slot->beam];
        slot->after = 0;
        for (int k = 0; k < s.num_slots; k++) slot->after |= (from->slot[i].after >> k & 1) << slots[k];
    }
    structures_find_touching(&s);
    return s;
}

static void test_order_and_names_in_the_file_have_no_part_in_the_cost(void) {
    const int count = sweep_count(40, 400);
    for (int k = 0; k < count; k++) {
        const structure_t structure = sample_structure(k), other = reordered(&structure, k);
        const assembly_result_t one = scheduled(&structure, 0), two = scheduled(&other, 0);
        (void)snprintf(label, sizeof label, "structure %d: %.17g, reordered %.17g", k, one.best.cost, two.best.cost);
        TEST_ASSERT_EQUAL_INT_MESSAGE(one.status, two.status, label);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9 * one.best.cost, one.best.cost, two.best.cost, label);
    }
}

static void move_point(pose_t X, double p[3]) {
    structures_numbers_of_vector(vec3_add(X.p, quat_apply(X.q, vector_of(p))), p);
}

static void turn_axis(pose_t X, double axis[3]) {
    structures_numbers_of_vector(quat_apply(X.q, vector_of(axis)), axis);
}

static void move_pose(pose_t X, double p[3], double q[4]) {
    const quat_t attitude = {real_from_double(q[0]), real_from_double(q[1]), real_from_double(q[2]),
                             real_from_double(q[3])};
    move_point(X, p);
    structures_numbers_of_attitude(quat_mul(X.q, attitude), q);
}

/// The same structure with all that belongs to it, elsewhere.
static structure_t moved(const structure_t* from, int number) {
    structure_t s = *from;
    sample_seed(SEED + 2000000u + (uint64_t)number);
    const pose_t X = {sample_vector(5), sample_attitude()};
    move_pose(X, s.p_IS_m, s.q_IS);
    for (int b = 0; b < s.num_beams; b++) move_pose(X, s.beam[b].p_IB_m, s.beam[b].q_IB);
    for (int h = 0; h < s.num_hubs; h++) {
        move_point(X, s.hub[h].p_IH_m);
        for (int i = 0; i < s.hub[h].num_ports; i++) {
            move_point(X, s.hub[h].port[i].p_IP_m);
            turn_axis(X, s.hub[h].port[i].axis_I);
        }
    }
    return s;
}

static void test_where_it_all_is_has_no_part_in_the_cost(void) {
    double worst = 0;
    const int count = sweep_count(40, 400);
    for (int k = 0; k < count; k++) {
        const structure_t structure = sample_structure(k), other = moved(&structure, k);
        const assembly_result_t one = scheduled(&structure, 0), two = scheduled(&other, 0);
        const double off = fabs(two.best.cost / one.best.cost - 1);
        (void)snprintf(label, sizeof label, "structure %d: %.17g, moved %.17g", k, one.best.cost, two.best.cost);
        TEST_ASSERT_EQUAL_INT_MESSAGE(one.status, two.status, label);
        // What a pose is rounded by changes a price by a millionth at most, and prices of three parts are compared.
        if (two.best.num_parts > 0) TEST_ASSERT_TRUE_MESSAGE(off <= 1e-6, label);
        worst = fmax(worst, off);
    }
    printf("moved: at most %.3g of the cost\n", worst);
}

static void test_the_number_of_threads_changes_nothing(void) {
    for (int k = 0; k < 5; k++) {
        const structure_t structure = sample_structure(k);
        const assembly_result_t one = scheduled(&structure, 1), four = scheduled(&structure, 4);
        TEST_ASSERT_EQUAL_INT(one.best.num_parts, four.best.num_parts);
        TEST_ASSERT_EQUAL_UINT64(one.nodes, four.nodes);
        for (int i = 0; i < one.best.num_parts; i++) {
            TEST_ASSERT_EQUAL_INT(one.best.part[i].beam, four.best.part[i].beam);
            TEST_ASSERT_EQUAL_INT(one.best.part[i].slot, four.best.part[i].slot);
            TEST_ASSERT_EQUAL_INT(one.best.part[i].price.pose, four.best.part[i].price.pose);
            TEST_ASSERT_TRUE(one.best.part[i].price.cost == four.best.part[i].price.cost);
        }
    }
}

// ---- Estimates ------------------------------------------------------------------------------------------------------

static bool never(void* context) {
    (void)context;
    return false;
}

/// The cheapest flow by trying all: each slot gets a beam of its own, each beam comes from a place of its own, one of
/// them from the start.
static double least_flow(const structure_t* structure, const estimate_t* estimate, int slot, unsigned used,
                         unsigned left) {
    if (slot == structure->num_slots) return (left & 1u) != 0 ? 0 : (double)INFINITY;
    double least = INFINITY;
    for (int b = 0; b < structure->num_beams; b++) {
        for (int place = 0; place <= structure->num_slots; place++) {
            if ((used >> b & 1u) != 0 || (left >> place & 1u) != 0) continue;
            const double part = estimate_part(estimate, place - 1, b, slot);
            if (!isfinite(part)) continue;
            least = fmin(least, part + least_flow(structure, estimate, slot + 1, used | 1u << b, left | 1u << place));
        }
    }
    return least;
}

static void test_the_estimates_flow_is_the_cheapest_and_no_part_is_due_more_than_it_costs(void) {
    int several = 0;
    for (int k = 0; k < 60; k++) {
        const structure_t structure = sample_structure(k);
        pricing_t* const pricing = pricing_open(&structure, 0);
        const assembly_prices_t prices = {pricing_ask, pricing};
        estimate_t* const estimate = estimate_open(&structure, &prices, never, NULL);
        TEST_ASSERT_NOT_NULL(estimate);
        const double least = least_flow(&structure, estimate, 0, 0, 0);
        (void)snprintf(label, sizeof label, "structure %d: %.9g, judged %.9g", k, estimate_least(estimate), least);
        TEST_ASSERT_EQUAL_INT_MESSAGE(isfinite(least), isfinite(estimate_least(estimate)), label);
        if (isfinite(least)) {
            // Ways count as shorter from a billionth on.
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-6, least, estimate_least(estimate), label);
            for (int b = 0; b < structure.num_beams; b++) {
                for (int s = 0; s < structure.num_slots; s++) {
                    for (int last = -1; last < structure.num_slots; last++) {
                        const double part = estimate_part(estimate, last, b, s);
                        TEST_ASSERT_TRUE_MESSAGE(part >= estimate_due(estimate, last, b, s) - 1e-6, label);
                    }
                }
            }
            several++;
        }
        estimate_close(estimate);
        pricing_close(pricing);
    }
    TEST_ASSERT_GREATER_THAN_INT(40, several);
}

int main(void) {
    char error[512];
    if (!structures_open(error, sizeof error)) {
        fprintf(stderr, "%s\n", error);
        return 1;
    }
    UNITY_BEGIN();
    RUN_TEST(test_schedules_cost_what_the_best_of_all_orders_costs);
    RUN_TEST(test_rounding_of_poses_changes_no_price);
    RUN_TEST(test_order_and_names_in_the_file_have_no_part_in_the_cost);
    RUN_TEST(test_where_it_all_is_has_no_part_in_the_cost);
    RUN_TEST(test_the_number_of_threads_changes_nothing);
    RUN_TEST(test_the_estimates_flow_is_the_cheapest_and_no_part_is_due_more_than_it_costs);
    return UNITY_END();
}
