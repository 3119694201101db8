// The track of a flight, fed with messages of a motion in closed form: rows, means, beams, strangers.
#include <math.h>
#include <string.h>

#include "report/flown.h"
#include "unity.h"

#define RATE_HZ 10
static flown_t flown, again;

/// A vehicle on a circle of 1 m, one turn each 100 s, that mates at a third and docks at the end of `duration_s`; its
/// thrusts grow with time.
static lcm_ssv_vehicle_state_t state_at(double t_s, double duration_s) {
    const double angle = 2 * 3.14159265358979323846 * t_s / 100;
    lcm_ssv_vehicle_state_t state = {.time_s = 50 + t_s,
                                     .plan_hash = 1,
                                     .X_IS = {{cos(angle), sin(angle), 0}, {cos(angle / 2), 0, 0, sin(angle / 2)}},
                                     .v_IS_S_m_s = {0, 2 * 3.14159265358979323846 / 100, 0},
                                     .mated = t_s >= duration_s / 3,
                                     .docked = t_s >= duration_s};
    state.X_IB = state.X_IS;
    state.X_IB.p_m[2] += 0.5; // half a metre above the vehicle, as long as it is held
    for (int k = 0; k < 6; k++) state.u_N[k] = t_s * (k + 1) / duration_s;
    return state;
}

static void fly(double duration_s, bool with_truth) {
    flown_begin(&flown);
    for (int i = 0; i <= RATE_HZ * duration_s; i++) {
        const double t_s = (double)i / RATE_HZ + 0.05;
        const lcm_ssv_execution_t news = {.flown_s = t_s, .plan_time_s = 0.9 * t_s};
        const lcm_ssv_vehicle_state_t state = state_at(t_s, duration_s), truth = state_at(t_s - 0.03, duration_s);
        if (with_truth) TEST_ASSERT_TRUE(flown_note_truth(&flown, &truth));
        TEST_ASSERT_TRUE(flown_note_execution(&flown, &news));
        TEST_ASSERT_TRUE(flown_note_estimate(&flown, &state));
    }
}

void setUp(void) {}
void tearDown(void) {}

static void test_rows_of_a_slow_motion_are_half_a_second_apart(void) {
    fly(60, true); // 3 cm in half a second: 0.4 s is the first step of more than 2 cm
    for (int i = 1; i < flown.estimate.count; i++) {
        const double step_s = flown.estimate.row[i].t_s - flown.estimate.row[i - 1].t_s;
        TEST_ASSERT_TRUE_MESSAGE(step_s < 0.51, "no more than half a second apart");
    }
    TEST_ASSERT_INT_WITHIN(3, flown.estimate.count, flown.truth.count);
    TEST_ASSERT_EQUAL_DOUBLE(50, flown.start_s);
}

/// 5000 s are 12,500 rows as close as this; the impulse of the means is that of the messages all the same.
static void test_a_long_flight_has_no_more_rows_and_the_same_impulse(void) {
    const double duration_s = 5000;
    double impulse_Ns = 0;
    fly(duration_s, false);
    TEST_ASSERT_LESS_OR_EQUAL_INT(FLOWN_ROWS_MAX, flown.estimate.count);
    TEST_ASSERT_GREATER_THAN_INT(FLOWN_ROWS_MAX / 3, flown.estimate.count);
    for (int i = 1; i < flown.estimate.count; i++) {
        const flown_row_t* const row = &flown.estimate.row[i];
        TEST_ASSERT_TRUE(row->t_s > row[-1].t_s);
        impulse_Ns += row->u_N[5] * (row->t_s - row[-1].t_s);
    }
    // Thrust 6 t / 5000 s over 5000 s; a message stands for the tenth of a second before it.
    TEST_ASSERT_DOUBLE_WITHIN(2e-3 * 15000, 15000, impulse_Ns);
}

static void test_the_rows_in_which_the_beam_changes_hands_are_there_to_the_tenth_of_a_second(void) {
    const double duration_s = 5000;
    fly(duration_s, false);
    double mated_s = -1;
    for (int i = 0; i < flown.estimate.count && mated_s < 0; i++)
        mated_s = flown.estimate.row[i].beam != FLOWN_LIES ? flown.estimate.row[i].t_s : -1;
    TEST_ASSERT_DOUBLE_WITHIN(0.101, duration_s / 3, mated_s);
    TEST_ASSERT_EQUAL_INT(FLOWN_DOCKED, flown.estimate.row[flown.estimate.count - 1].beam);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.5, flown.estimate.X_SB.p_m[2]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.5, flown.estimate.X_IB_docked.p_m[2]);
}

static void test_what_is_of_another_flight_or_no_number_has_no_place(void) {
    fly(60, true);
    const int count = flown.estimate.count, truths = flown.truth.count;
    lcm_ssv_execution_t news = {.flown_s = 61, .plan_time_s = 55};
    lcm_ssv_vehicle_state_t state = state_at(61, 60);
    TEST_ASSERT_FALSE(flown_note_estimate(&flown, &state)); // no execution_t before it
    TEST_ASSERT_TRUE(flown_note_execution(&flown, &news));
    state.time_s = 161;
    TEST_ASSERT_FALSE(flown_note_estimate(&flown, &state));
    TEST_ASSERT_FALSE(flown_note_truth(&flown, &state));
    state = state_at(61, 60);
    state.X_IS.q[2] = NAN;
    TEST_ASSERT_FALSE(flown_note_estimate(&flown, &state));
    TEST_ASSERT_FALSE(flown_note_truth(&flown, &state));
    news.flown_s = INFINITY;
    TEST_ASSERT_FALSE(flown_note_execution(&flown, &news));
    TEST_ASSERT_EQUAL_INT(count, flown.estimate.count);
    TEST_ASSERT_EQUAL_INT(truths, flown.truth.count);
    state = state_at(61, 60);
    TEST_ASSERT_TRUE(flown_note_estimate(&flown, &state));
    TEST_ASSERT_FALSE(flown_note_estimate(&flown, &state)); // twice
}

static void test_a_track_is_read_as_it_was_written(void) {
    char sentence[256] = "";
    tree_error_t error = {sentence, sizeof sentence};
    tree_memory_t memory = {NULL};
    fly(90, true);
    json_t* const json = flown_to_json(&flown);
    char* const text = json_dumps(json, JSON_REAL_PRECISION(17));
    const tree_t* const tree = tree_from_json(&memory, &error, "f.json", text, strlen(text));
    TEST_ASSERT_TRUE_MESSAGE(tree != NULL && flown_from_tree(tree, &again, &error), sentence);
    TEST_ASSERT_EQUAL_INT(flown.estimate.count, again.estimate.count);
    TEST_ASSERT_EQUAL_MEMORY(flown.estimate.row, again.estimate.row,
                             sizeof flown.estimate.row[0] * (size_t)again.estimate.count);
    TEST_ASSERT_INT_WITHIN(1, flown.truth.count,
                           again.truth.count); // the last tenth of a second may not have been heard
    TEST_ASSERT_EQUAL_MEMORY(&flown.estimate.X_SB, &again.estimate.X_SB, sizeof again.estimate.X_SB);
    tree_memory_free(&memory);
    free(text);
    json_decref(json);
}

static void test_a_track_that_is_none_is_refused_by_its_place(void) {
    static const struct {
        const char *text, *place;
    } bad[] = {
        {"{}", "estimate: this key is missing"},
        {"{\"estimate\": {\"rows\": 3}}", "estimate.rows: must be a list"},
        {"{\"estimate\": {\"rows\": [[1]]}}", "estimate.rows[0]: must be a list of 18 numbers"},
        {"{\"estimate\": {\"rows\": [[0,0, 0,0,0, 0,0,0,0, 0,0,0, 0,0,0,0,0,0]]}}", "not of unit length"},
        {"{\"estimate\": {\"rows\": [[0,0, 0,0,0, 1,0,0,0, 0,0,0, 0,0,0,0,0,0], [0,0, 0,0,0, 1,0,0,0, 0,0,0, "
         "0,0,0,0,0,0]]}}",
         "is not later"},
        {"{\"estimate\": {\"rows\": []}}", "X_SB: this key is missing"},
        {"{\"estimate\": {\"rows\": [], \"X_SB\": [1,2,3,4,5,6,\"7\"]}}", "estimate.X_SB[6]: must be a number"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        char sentence[256] = "";
        tree_error_t error = {sentence, sizeof sentence};
        tree_memory_t memory = {NULL};
        const tree_t* const tree = tree_from_json(&memory, &error, "f.json", bad[i].text, strlen(bad[i].text));
        TEST_ASSERT_FALSE(flown_from_tree(tree, &again, &error));
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(sentence, bad[i].place), sentence);
        tree_memory_free(&memory);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_rows_of_a_slow_motion_are_half_a_second_apart);
    RUN_TEST(test_a_long_flight_has_no_more_rows_and_the_same_impulse);
    RUN_TEST(test_the_rows_in_which_the_beam_changes_hands_are_there_to_the_tenth_of_a_second);
    RUN_TEST(test_what_is_of_another_flight_or_no_number_has_no_place);
    RUN_TEST(test_a_track_is_read_as_it_was_written);
    RUN_TEST(test_a_track_that_is_none_is_refused_by_its_place);
    return UNITY_END();
}
