// The walk over the message types: messages through JSON and back, and what is refused on the way, with its path.
#define _POSIX_C_SOURCE 200809L
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lcm_ssv_plan_t.h"
#include "lcm_ssv_planner_status_t.h"
#include "lcm_ssv_quote_batch_t.h"
#include "lcm_ssv_scenario_batch_t.h"
#include "lcm_ssv_task_t.h"
#include "unity.h"
#include "wire/message.h"
#include "wire/names.h"

#define SEED UINT64_C(20261128)
#define NUM_CASES 300

void setUp(void) {}
void tearDown(void) {}

static uint64_t state;

/// xorshift64*, seeded per case.
static uint64_t random_bits(void) {
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return state * UINT64_C(2685821657736338717);
}

/// Every kind of finite double: any bits, and the odd ones more often than bits would give them.
static double random_double(void) {
    static const double odd[] = {0.0, -0.0, 5e-324, -2.2250738585072009e-308, 1e308, -1.7976931348623157e308,
                                 0.1, 1.0,  1e22};
    const uint64_t bits = random_bits();
    double value;
    memcpy(&value, &bits, sizeof value);
    if (bits % 4 == 0 || !(value - value == 0)) {
        return odd[bits / 4 % (sizeof odd / sizeof odd[0])];
    }
    return value;
}

static char* random_text(void) {
    static const char* const texts[] = {
        "", "plain", "with \"quotes\" and \\", "tab\there", "\x1b[31m", "m\xc3\xa4\xc3\x9fig", "true", "1e5"};
    return strdup(texts[random_bits() % (sizeof texts / sizeof texts[0])]);
}

static void random_doubles(double* values, int count) {
    for (int i = 0; i < count; i++) {
        values[i] = random_double();
    }
}

static void random_candidate(lcm_ssv_candidate_t* candidate) {
    *candidate =
        (lcm_ssv_candidate_t){(int8_t)random_bits(), random_double(), random_double(), random_text(),
                              random_double(),       random_double(), random_double(), (int8_t)(random_bits() % 2),
                              (int8_t)random_bits(), random_double()};
}

static lcm_ssv_candidate_t* random_candidates(int32_t* count, uint64_t most) {
    *count = (int32_t)(random_bits() % (most + 1));
    lcm_ssv_candidate_t* const candidates = calloc((size_t)*count + 1, sizeof *candidates);
    for (int32_t i = 0; i < *count; i++) {
        random_candidate(&candidates[i]);
    }
    return candidates;
}

static void random_pose(lcm_ssv_pose_t* pose) {
    random_doubles(pose->p_m, 3);
    random_doubles(pose->q, 4);
}

static void random_asker(lcm_ssv_asker_t* asker) {
    *asker = (lcm_ssv_asker_t){(int64_t)random_bits(), (int64_t)random_bits(), INT64_MIN, (int64_t)random_bits()};
}

static void random_answer(lcm_ssv_answer_t* answer) {
    random_asker(&answer->asker);
    answer->question_hash = (int64_t)random_bits();
    answer->planner = (lcm_ssv_planner_t){(int64_t)random_bits(), random_text(), (int8_t)(random_bits() % 3)};
}

static void random_quote(lcm_ssv_quote_t* quote) {
    quote->candidates = random_candidates(&quote->num_candidates, 16);
    quote->front = random_candidates(&quote->num_front, 24);
    quote->scenario_hash = (int64_t)random_bits();
    quote->status = (int8_t)(random_bits() % 4);
    quote->reason = random_text();
    random_doubles(&quote->cost, 1);
    random_doubles(&quote->time_s, 1);
    quote->choice = (lcm_ssv_choice_t){(int8_t)random_bits(), random_double(), random_double(), (int32_t)random_bits()};
    random_pose(&quote->X_IS_final);
    random_pose(&quote->X_IB_final);
}

static void random_plan(lcm_ssv_plan_t* plan) {
    memset(plan, 0, sizeof *plan);
    random_answer(&plan->answer);
    random_quote(&plan->quote);
    plan->plan_hash = (int64_t)random_bits();
    plan->num_legs = (int32_t)(random_bits() % 9);
    plan->num_arcs = (int32_t)(random_bits() % 81);
    plan->num_segments = (int32_t)(random_bits() % 129);
    plan->num_events = (int32_t)(random_bits() % 3);
    plan->legs = calloc((size_t)plan->num_legs + 1, sizeof *plan->legs);
    plan->arcs = calloc((size_t)plan->num_arcs + 1, sizeof *plan->arcs);
    plan->segments = calloc((size_t)plan->num_segments + 1, sizeof *plan->segments);
    plan->events = calloc((size_t)plan->num_events + 1, sizeof *plan->events);
    for (int i = 0; i < plan->num_legs; i++) {
        lcm_ssv_leg_t* const leg = &plan->legs[i];
        *leg = (lcm_ssv_leg_t){.phase = (int8_t)(random_bits() % 2),
                               .kind = (int8_t)(random_bits() % 3),
                               .ramp = (int8_t)(random_bits() % 3)};
        random_doubles(&leg->t_start_s, 1);
        random_doubles(&leg->peak_speed, 1);
        random_doubles(leg->v_S, 3);
        random_doubles(leg->w_S, 3);
        leg->first_arc = (int8_t)random_bits();
        leg->num_arcs = (int8_t)random_bits();
        random_pose(&leg->X_IS_start);
        random_pose(&leg->X_IS_end);
    }
    for (int i = 0; i < plan->num_arcs; i++) {
        random_doubles(&plan->arcs[i].t_s, 1);
        random_doubles(&plan->arcs[i].v_end, 1);
        random_doubles(plan->arcs[i].dv_dt, 3);
    }
    for (int i = 0; i < plan->num_segments; i++) {
        random_doubles(plan->segments[i].u_start_N, 6);
        random_doubles(plan->segments[i].u_end_N, 6);
        plan->segments[i].leg = (int8_t)random_bits();
    }
    for (int i = 0; i < plan->num_events; i++) {
        plan->events[i] = (lcm_ssv_event_t){random_double(), (int8_t)(random_bits() % 2)};
    }
    random_pose(&plan->X_SB);
    plan->clearance = (lcm_ssv_clearance_t){
        random_double(),      random_double(), (int8_t)random_bits(), random_double(), (int8_t)(random_bits() % 2),
        (int8_t)random_bits()};
    plan->arrival = (lcm_ssv_arrival_t){random_double(), random_double(), random_double(), random_double()};
}

static void random_body(lcm_ssv_body_t* body) {
    random_doubles(&body->mass_kg, 1);
    random_doubles(body->inertia_kg_m2, 3);
    random_doubles(body->added_mass_kg, 3);
    random_doubles(&body->drag_lin_ang_Nm_s, 1);
}

static void random_scenario(lcm_ssv_scenario_t* scenario) {
    memset(scenario, 0, sizeof *scenario);
    random_asker(&scenario->asker);
    random_doubles(&scenario->thrust_reserve, 1);
    random_body(&scenario->vehicle.body);
    random_body(&scenario->beam.body);
    for (int i = 0; i < 6; i++) {
        random_doubles(scenario->vehicle.thruster[i].p_ST_m, 3);
        random_doubles(scenario->vehicle.thruster[i].n_T_S, 3);
    }
    random_pose(&scenario->X_IS);
    random_doubles(scenario->port.axis_I, 3);
    scenario->contact = (int8_t)random_bits();
    scenario->options.method = (int8_t)(random_bits() % 2);
    scenario->options.effort = (int8_t)(random_bits() % 2);
    scenario->options.num_attach_heights = (int8_t)random_bits();
    random_doubles(scenario->options.attach_heights_m, 8);
    scenario->options.attach_anywhere = (int8_t)(random_bits() % 2);
    scenario->options.want_front = (int8_t)(random_bits() % 2);
    scenario->obstacles = (int64_t)random_bits();
    scenario->left = (int64_t)random_bits();
    random_doubles(&scenario->margin_m, 1);
    random_doubles(&scenario->transfer_rate_max_rad_s, 1);
}

/// The text of {"it": message}, which the caller frees.
static char* text_of(const char* type, const void* message) {
    char* text = NULL;
    size_t size = 0;
    FILE* const memory = open_memstream(&text, &size);
    TEST_ASSERT_TRUE(wire_json_write(memory, json_pack("{s:o}", "it", wire_to_json(type, message))));
    fclose(memory);
    return text;
}

// The generated encoder is the oracle: two messages are the same if their bytes on the wire are.

static void check_plan_survives(const lcm_ssv_plan_t* plan, const char* label) {
    static uint8_t before[1 << 16], after[1 << 16];
    char error[512];
    lcm_ssv_plan_t again;
    char* const text = text_of("plan_t", plan);
    const wire_part_t part = {"it", "plan_t", &again};
    TEST_ASSERT_TRUE_MESSAGE(wire_json_read("text", text, strlen(text), &part, 1, error, sizeof error), error);
    const int size = lcm_ssv_plan_t_encode(before, 0, sizeof before, plan);
    TEST_ASSERT_EQUAL_INT_MESSAGE(size, lcm_ssv_plan_t_encode(after, 0, sizeof after, &again), label);
    TEST_ASSERT_EQUAL_MEMORY_MESSAGE(before, after, (size_t)size, label);
    TEST_ASSERT_TRUE(wire_is_message("plan_t", before, (size_t)size));
    wire_clear("plan_t", &again);
    free(text);
}

static void test_random_plans_come_back_from_json_bit_for_bit(void) {
    for (int k = 0; k < NUM_CASES; k++) {
        char label[64];
        lcm_ssv_plan_t plan;
        state = SEED + (uint64_t)k;
        snprintf(label, sizeof label, "seed %" PRIu64, state);
        random_plan(&plan);
        check_plan_survives(&plan, label);
        wire_clear("plan_t", &plan);
    }
}

/// Of what is beyond the count nothing comes back, so nothing is there.
static void random_scene(lcm_ssv_scene_t* scene) {
    memset(scene, 0, sizeof *scene);
    scene->num_obstacles = (int8_t)(random_bits() % 65);
    for (int i = 0; i < scene->num_obstacles; i++) {
        lcm_ssv_obstacle_t* const obstacle = &scene->obstacles[i];
        obstacle->kind = (int8_t)(random_bits() % 2);
        random_doubles(obstacle->p_I_m, 3);
        random_doubles(obstacle->axis_I, 3);
        random_doubles(&obstacle->length_m, 1);
        random_doubles(&obstacle->radius_m, 1);
    }
    scene->tank.kind = (int8_t)(random_bits() % 3);
    random_doubles(scene->tank.from_I_m, 3);
    random_doubles(scene->tank.to_I_m, 3);
    random_doubles(&scene->tank.radius_m, 1);
}

static void test_random_tasks_come_back_from_json_bit_for_bit(void) {
    for (int k = 0; k < NUM_CASES; k++) {
        uint8_t before[8192], after[8192];
        char error[512];
        lcm_ssv_task_t task, again;
        state = SEED + (uint64_t)k;
        random_scenario(&task.scenario);
        random_scene(&task.scene);
        char* const text = text_of("task_t", &task);
        const wire_part_t part = {"it", "task_t", &again};
        TEST_ASSERT_TRUE_MESSAGE(wire_json_read("text", text, strlen(text), &part, 1, error, sizeof error), error);
        const int size = lcm_ssv_task_t_encode(before, 0, sizeof before, &task);
        TEST_ASSERT_GREATER_THAN_INT(0, size);
        TEST_ASSERT_EQUAL_INT(size, lcm_ssv_task_t_encode(after, 0, sizeof after, &again));
        TEST_ASSERT_EQUAL_MEMORY(before, after, (size_t)size);
        TEST_ASSERT_TRUE(wire_is_message("task_t", before, (size_t)size));
        free(text);
    }
}

static void test_a_scene_holds_as_many_obstacles_as_it_counts(void) {
    static const struct {
        const char *key, *value, *refusal;
    } wrong[] = {
        {"num_obstacles", "3", "text: it.obstacles: 2 entries, there must be exactly 3"},
        {"num_obstacles", "65", "text: it.obstacles: 65 entries are counted, there may be 0 to 64"},
        {"num_obstacles", "-1", "text: it.obstacles: -1 entries are counted, there may be 0 to 64"},
        {"num_obstacles", "200", "text: it.num_obstacles: 200 is outside [-128, 127]"},
        {"obstacles", "{}", "text: it.obstacles: not a list of 2"},
    };
    const lcm_ssv_scene_t scene = {.num_obstacles = 2, .obstacles = {{.kind = 1}, {.radius_m = 0.5}, {.length_m = 9}}};
    json_t* const whole = wire_to_json("scene_t", &scene);
    TEST_ASSERT_EQUAL_INT(2, json_array_size(json_object_get(whole, "obstacles")));
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        char error[512];
        lcm_ssv_scene_t again;
        json_t* const json = json_pack("{s:o}", "it", json_deep_copy(whole));
        json_object_set_new(json_object_get(json, "it"), wrong[k].key,
                            json_loads(wrong[k].value, JSON_DECODE_ANY, NULL));
        char* const text = json_dumps(json, 0);
        const wire_part_t part = {"it", "scene_t", &again};
        TEST_ASSERT_FALSE(wire_json_read("text", text, strlen(text), &part, 1, error, sizeof error));
        TEST_ASSERT_EQUAL_STRING(wrong[k].refusal, error);
        free(text);
        json_decref(json);
    }
    json_decref(whole);
    // Whatever a message counts, nothing beyond its room is looked at.
    const lcm_ssv_scene_t beyond = {.num_obstacles = 127}, below = {.num_obstacles = -128};
    json_t* const most = wire_to_json("scene_t", &beyond);
    json_t* const none = wire_to_json("scene_t", &below);
    TEST_ASSERT_EQUAL_INT(64, json_array_size(json_object_get(most, "obstacles")));
    TEST_ASSERT_EQUAL_INT(0, json_array_size(json_object_get(none, "obstacles")));
    json_decref(most);
    json_decref(none);
}

static void test_a_number_that_is_not_finite_is_no_json(void) {
    lcm_ssv_scenario_t scenario = {.standoff_m = 1};
    scenario.beam.body.inertia_kg_m2[1] = (double)INFINITY;
    TEST_ASSERT_NULL(wire_to_json("scenario_t", &scenario));
    scenario.beam.body.inertia_kg_m2[1] = 0;
    json_t* const json = wire_to_json("scenario_t", &scenario);
    TEST_ASSERT_NOT_NULL(json);
    json_decref(json);
}

/// A plan with one candidate, a leg and two segments, as JSON.
static json_t* small_plan(void) {
    lcm_ssv_candidate_t candidate = {.reason = (char[]){"too far"}};
    lcm_ssv_leg_t leg = {.phase = 1};
    lcm_ssv_segment_t segments[2] = {{.t_s = 0}, {.t_s = 1}};
    const lcm_ssv_plan_t plan = {.num_legs = 1,
                                 .num_segments = 2,
                                 .quote = {.num_candidates = 1, .reason = (char[]){""}, .candidates = &candidate},
                                 .legs = &leg,
                                 .segments = segments};
    return wire_to_json("plan_t", &plan);
}

/// What stands at a path of keys and numbers, "quote.candidates.0".
static json_t* at(json_t* json, const char* path) {
    char copy[128];
    snprintf(copy, sizeof copy, "%s", path);
    for (char* step = strtok(copy, "."); step != NULL; step = strtok(NULL, ".")) {
        json = json_is_array(json) ? json_array_get(json, strtoul(step, NULL, 10)) : json_object_get(json, step);
    }
    return json;
}

// In the object or list at `where`, the entry `key` becomes `value`; it goes if that is empty.
typedef struct {
    const char *where, *key, *value, *refusal;
} bad_t;

static const bad_t bad[] = {
    {"", "plan_hash", "", "text: it.plan_hash: this key is missing"},
    {"", "plan_hsh", "1", "text: it.plan_hsh: unknown key; did you mean plan_hash?"},
    {"", "nothing_like_it", "1", "text: it.nothing_like_it: unknown key"},
    {"", "plan_hash", "\"0123456789ABCDEF\"", "text: it.plan_hash: not a text of 16 hex digits"},
    {"", "plan_hash", "\"012345678\"", "text: it.plan_hash: not a text of 16 hex digits"},
    {"", "plan_hash", "5", "text: it.plan_hash: not a text of 16 hex digits"},
    {"", "legs", "{}", "text: it.legs: not a list of 1"},
    {"", "legs", "[]", "text: it.legs: 0 entries, there must be exactly 1"},
    {"", "segments", "[1]", "text: it.segments: 1 entries, there must be exactly 2"},
    {"", "num_segments", "129", "text: it.segments: 129 entries are counted, there may be 0 to 128"},
    {"", "num_segments", "-1", "text: it.segments: -1 entries are counted, there may be 0 to 128"},
    {"", "num_segments", "3000000000", "text: it.num_segments: 3000000000 is outside [-2147483648, 2147483647]"},
    {"", "num_segments", "2.0", "text: it.num_segments: a number is not a whole number"},
    {"", "quote", "null", "text: it.quote: not a map of keys and values"},
    {"quote", "status", "\"fine\"",
     "text: it.quote.status: 'fine' is none of ok, infeasible, invalid, numeric_overflow"},
    {"quote", "status", "0", "text: it.quote.status: a number is none of ok, infeasible, invalid, numeric_overflow"},
    {"quote", "reason", "1", "text: it.quote.reason: not a text"},
    {"quote", "cost", "\"5\"", "text: it.quote.cost: '5' is not a number"},
    {"quote", "cost", "true", "text: it.quote.cost: true or false is not a number"},
    {"quote.candidates.0", "cost", "[1]", "text: it.quote.candidates[0].cost: a list is not a number"},
    {"quote.candidates.0", "contact", "128", "text: it.quote.candidates[0].contact: 128 is outside [-128, 127]"},
    {"quote.candidates.0", "cost", "", "text: it.quote.candidates[0].cost: this key is missing"},
    {"segments.1", "u_end_N", "[1,2,3,4,5]", "text: it.segments[1].u_end_N: 5 entries, there must be exactly 6"},
    {"segments.1", "u_end_N", "[1,2,3,4,5,{}]", "text: it.segments[1].u_end_N[5]: a map is not a number"},
    {"legs.0.X_IS_end", "q", "\"unit\"", "text: it.legs[0].X_IS_end.q: not a list of 4"},
};

static void test_each_kind_of_fault_is_refused_with_its_path_and_leaves_nothing_behind(void) {
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        const lcm_ssv_plan_t empty = {0};
        lcm_ssv_plan_t plan;
        char error[512];
        json_t* const json = json_pack("{s:o}", "it", small_plan());
        json_t* const place = at(json_object_get(json, "it"), bad[k].where);
        if (bad[k].value[0] == '\0') {
            json_object_del(place, bad[k].key);
        } else {
            json_object_set_new(place, bad[k].key, json_loads(bad[k].value, JSON_DECODE_ANY, NULL));
        }
        char* const text = json_dumps(json, 0);
        const wire_part_t part = {"it", "plan_t", &plan};
        TEST_ASSERT_FALSE_MESSAGE(wire_json_read("text", text, strlen(text), &part, 1, error, sizeof error),
                                  bad[k].refusal);
        TEST_ASSERT_EQUAL_STRING(bad[k].refusal, error);
        TEST_ASSERT_EQUAL_MEMORY(&empty, &plan, sizeof plan);
        free(text);
        json_decref(json);
    }
}

static void test_texts_that_are_no_such_json_are_refused(void) {
    static const char* const texts[] = {
        "", "{", "[]", "{\"it\": 1, \"it\": 2}", "{\"it\": NaN}", "{\"it\": 1e999}", "{} {}", "{\"that\": 1}", "\xff"};
    char deep[200001];
    memset(deep, '[', sizeof deep - 1);
    deep[sizeof deep - 1] = '\0';
    for (size_t k = 0; k <= sizeof texts / sizeof texts[0]; k++) {
        const char* const text = k < sizeof texts / sizeof texts[0] ? texts[k] : deep;
        char error[512];
        lcm_ssv_plan_t plan;
        const wire_part_t part = {"it", "plan_t", &plan};
        TEST_ASSERT_FALSE(wire_json_read("text", text, strlen(text), &part, 1, error, sizeof error));
        TEST_ASSERT_EQUAL_STRING_LEN("text:", error, 5);
    }
}

static void test_each_word_is_that_of_its_constant(void) {
    const struct {
        const names_t* names;
        int8_t value;
        const char* word;
    } words[] = {
        {&names_status, LCM_SSV_QUOTE_T_STATUS_OK, "ok"},
        {&names_status, LCM_SSV_QUOTE_T_STATUS_INFEASIBLE, "infeasible"},
        {&names_status, LCM_SSV_QUOTE_T_STATUS_INVALID, "invalid"},
        {&names_status, LCM_SSV_QUOTE_T_STATUS_NUMERIC_OVERFLOW, "numeric_overflow"},
        {&names_phase, LCM_SSV_LEG_T_PHASE_TRANSIT, "transit"},
        {&names_phase, LCM_SSV_LEG_T_PHASE_TRANSFER, "transfer"},
        {&names_kind, LCM_SSV_LEG_T_KIND_TRANSLATE, "translate"},
        {&names_kind, LCM_SSV_LEG_T_KIND_TURN, "turn"},
        {&names_kind, LCM_SSV_LEG_T_KIND_SCREW, "screw"},
        {&names_ramp, LCM_SSV_LEG_T_RAMP_FULL_REVERSE, "full_reverse"},
        {&names_ramp, LCM_SSV_LEG_T_RAMP_DRAG_ONLY, "drag_only"},
        {&names_ramp, LCM_SSV_LEG_T_RAMP_OPTIMAL, "optimal"},
        {&names_event, LCM_SSV_EVENT_T_KIND_MATE, "mate"},
        {&names_event, LCM_SSV_EVENT_T_KIND_DOCK, "dock"},
        {&names_method, LCM_SSV_OPTIONS_T_METHOD_OPTIMAL, "optimal"},
        {&names_method, LCM_SSV_OPTIONS_T_METHOD_PAPER, "paper"},
        {&names_effort, LCM_SSV_OPTIONS_T_EFFORT_QUICK, "quick"},
        {&names_effort, LCM_SSV_OPTIONS_T_EFFORT_BEST, "best"},
        {&names_obstacle, LCM_SSV_OBSTACLE_T_KIND_CAPSULE, "capsule"},
        {&names_obstacle, LCM_SSV_OBSTACLE_T_KIND_WALL, "wall"},
        {&names_tank, LCM_SSV_TANK_T_KIND_NONE, "none"},
        {&names_tank, LCM_SSV_TANK_T_KIND_BOX, "box"},
        {&names_tank, LCM_SSV_TANK_T_KIND_CYLINDER, "cylinder"},
        {&names_body, LCM_SSV_CLEARANCE_T_BODY_VEHICLE, "vehicle"},
        {&names_body, LCM_SSV_CLEARANCE_T_BODY_BEAM, "beam"},
    };
    for (size_t k = 0; k < sizeof words / sizeof words[0]; k++) {
        TEST_ASSERT_EQUAL_STRING(words[k].word, name_of(words[k].names, words[k].value));
        TEST_ASSERT_EQUAL_INT(words[k].value, name_find(words[k].names, words[k].word));
    }
    TEST_ASSERT_EQUAL_STRING("unknown", name_of(&names_status, 4));
    TEST_ASSERT_EQUAL_INT(-1, name_find(&names_phase, "rest"));
}

static void test_a_plan_at_its_limits_passes_and_one_beyond_any_of_them_does_not(void) {
    static uint8_t bytes[1 << 16];
    static const struct {
        size_t at;
        const char* what;
    } counts[] = {{0, "legs"}, {4, "arcs"}, {8, "segments"}, {12, "events"}, {16, "candidates"}, {20, "front"}};
    lcm_ssv_plan_t plan;
    state = SEED;
    random_plan(&plan);
    const size_t size = (size_t)lcm_ssv_plan_t_encode(bytes, 0, sizeof bytes, &plan);
    const size_t first = (size_t)lcm_ssv_answer_t_encoded_size(&plan.answer); // the type hash in it is that of plan_t
    TEST_ASSERT_TRUE(wire_is_message("plan_t", bytes, size));
    TEST_ASSERT_FALSE(wire_is_message("quote_batch_t", bytes, size));
    TEST_ASSERT_FALSE(wire_is_message("plan_t", bytes, size + 1));
    for (size_t cut = 0; cut < size; cut++) {
        uint8_t* const exact = malloc(cut + 1); // so that a sanitizer sees a read beyond
        memcpy(exact, bytes, cut);
        TEST_ASSERT_FALSE(wire_is_message("plan_t", exact, cut));
        free(exact);
    }
    for (size_t k = 0; k < sizeof counts / sizeof counts[0]; k++) {
        uint8_t kept[4];
        memcpy(kept, &bytes[first + counts[k].at], 4);
        memcpy(&bytes[first + counts[k].at], (const uint8_t[]){0x7f, 0xff, 0xff, 0xff}, 4);
        TEST_ASSERT_FALSE_MESSAGE(wire_is_message("plan_t", bytes, size), counts[k].what);
        memset(&bytes[first + counts[k].at], 0xff, 4);
        TEST_ASSERT_FALSE_MESSAGE(wire_is_message("plan_t", bytes, size), counts[k].what);
        memcpy(&bytes[first + counts[k].at], kept, 4);
    }
    wire_clear("plan_t", &plan);
}

static void test_a_list_may_be_as_long_as_its_limit_and_no_longer(void) {
    static uint8_t bytes[1 << 16];
    static lcm_ssv_segment_t segments[129];
    lcm_ssv_plan_t plan = {
        .answer = {.planner = {.version = (char[]){""}}}, .segments = segments, .quote = {.reason = (char[]){""}}};
    for (int count = 127; count <= 129; count++) {
        plan.num_segments = count;
        const size_t size = (size_t)lcm_ssv_plan_t_encode(bytes, 0, sizeof bytes, &plan);
        TEST_ASSERT_EQUAL(count <= 128, wire_is_message("plan_t", bytes, size));
    }
}

static void test_a_string_must_end_where_it_says(void) {
    uint8_t bytes[1024];
    lcm_ssv_planner_status_t status = {.planner = {.version = (char[]){"1.0"}}};
    const size_t size = (size_t)lcm_ssv_planner_status_t_encode(bytes, 0, sizeof bytes, &status);
    TEST_ASSERT_TRUE(wire_is_message("planner_status_t", bytes, size));
    bytes[24 + 4 + 3] = 'x'; // the terminator of the version
    TEST_ASSERT_FALSE(wire_is_message("planner_status_t", bytes, size));
    bytes[24 + 4 + 3] = '\0';
    bytes[24 + 3] = 0; // its length
    TEST_ASSERT_FALSE(wire_is_message("planner_status_t", bytes, size));
}

/// A generated decoder of a message that passes reads all of it, whatever else was changed in it.
static void test_damaged_messages_that_pass_can_be_decoded(void) {
    static uint8_t bytes[1 << 16];
    int passed = 0;
    for (int k = 0; k < 3000; k++) {
        lcm_ssv_plan_t plan, again;
        state = SEED + (uint64_t)k;
        random_plan(&plan);
        const size_t size = (size_t)lcm_ssv_plan_t_encode(bytes, 0, sizeof bytes, &plan);
        for (int i = 0; i < 3; i++) {
            bytes[8 + random_bits() % (k % 2 == 0 ? size - 8 : 24)] = (uint8_t)random_bits();
        }
        if (wire_is_message("plan_t", bytes, size)) {
            passed++;
            TEST_ASSERT_EQUAL_INT((int)size, lcm_ssv_plan_t_decode(bytes, 0, (int)size, &again));
            lcm_ssv_plan_t_decode_cleanup(&again);
        }
        wire_clear("plan_t", &plan);
    }
    TEST_ASSERT_GREATER_THAN_INT(100, passed);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_random_plans_come_back_from_json_bit_for_bit);
    RUN_TEST(test_random_tasks_come_back_from_json_bit_for_bit);
    RUN_TEST(test_a_scene_holds_as_many_obstacles_as_it_counts);
    RUN_TEST(test_a_number_that_is_not_finite_is_no_json);
    RUN_TEST(test_each_kind_of_fault_is_refused_with_its_path_and_leaves_nothing_behind);
    RUN_TEST(test_texts_that_are_no_such_json_are_refused);
    RUN_TEST(test_each_word_is_that_of_its_constant);
    RUN_TEST(test_a_plan_at_its_limits_passes_and_one_beyond_any_of_them_does_not);
    RUN_TEST(test_a_list_may_be_as_long_as_its_limit_and_no_longer);
    RUN_TEST(test_a_string_must_end_where_it_says);
    RUN_TEST(test_damaged_messages_that_pass_can_be_decoded);
    return UNITY_END();
}
