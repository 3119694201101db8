// The daemon's questions and answers: no asker takes another's turn, place, epoch or id.
#include "questions.h"

#include <string.h>

#include "unity.h"

#define SIZE_MAX_OF_TEST 16

static questions_t questions;
static uint8_t question_bytes[QUESTIONS_MAX * SIZE_MAX_OF_TEST], answer_bytes[ANSWERS_MAX * SIZE_MAX_OF_TEST];

void setUp(void) { questions_init(&questions, question_bytes, SIZE_MAX_OF_TEST, answer_bytes, SIZE_MAX_OF_TEST); }
void tearDown(void) {}

static question_key_t key(int64_t asker_id, int64_t request_id) {
    return (question_key_t){.kind = 0, .asker_id = asker_id, .request_id = request_id, .hash = (uint64_t)request_id};
}

static admission_t admit(question_key_t k, const kept_answer_t** answer) {
    return questions_admit(&questions, &k, "question", 9, answer);
}

static admission_t ask(int64_t asker_id, int64_t request_id) {
    const kept_answer_t* answer = NULL;
    return admit(key(asker_id, request_id), &answer);
}

static void answer_all(void) {
    for (waiting_t* next = questions_next(&questions, false); next != NULL; next = questions_next(&questions, false)) {
        questions_done(&questions, next, "answer", 7);
    }
}

static void test_a_question_asked_again_waits_once_and_then_gets_its_stored_answer(void) {
    const kept_answer_t* answer = NULL;
    TEST_ASSERT_EQUAL(ADMIT_NEW, ask(1, 10));
    TEST_ASSERT_EQUAL(ADMIT_WAITING, ask(1, 10));
    TEST_ASSERT_EQUAL_INT(1, questions.num_waiting);
    answer_all();
    TEST_ASSERT_EQUAL(ADMIT_ANSWERED, admit(key(1, 10), &answer));
    TEST_ASSERT_EQUAL_INT(7, answer->size);
    TEST_ASSERT_EQUAL_STRING("answer", (const char*)answer->bytes);
}

static void test_another_question_under_an_old_id_is_refused_before_and_after_the_answer(void) {
    question_key_t other = key(1, 10);
    const kept_answer_t* answer = NULL;
    other.hash++;
    TEST_ASSERT_EQUAL(ADMIT_NEW, ask(1, 10));
    TEST_ASSERT_EQUAL(ADMIT_REUSED, admit(other, &answer));
    answer_all();
    TEST_ASSERT_EQUAL(ADMIT_REUSED, admit(other, &answer));
    TEST_ASSERT_NULL(answer);
}

static void test_the_same_id_of_another_asker_or_kind_is_another_question(void) {
    question_key_t batch = key(1, 10);
    const kept_answer_t* answer = NULL;
    batch.kind = 1;
    batch.hash++;
    TEST_ASSERT_EQUAL(ADMIT_NEW, ask(1, 10));
    TEST_ASSERT_EQUAL(ADMIT_NEW, ask(2, 10));
    TEST_ASSERT_EQUAL(ADMIT_NEW, admit(batch, &answer));
}

static void test_no_clock_of_one_asker_makes_another_ones_question_stale(void) {
    question_key_t future = key(1, 10), past = key(2, 10);
    const kept_answer_t* answer = NULL;
    future.epoch_us = INT64_MAX;
    past.epoch_us = 1;
    TEST_ASSERT_EQUAL(ADMIT_NEW, admit(future, &answer));
    TEST_ASSERT_EQUAL(ADMIT_NEW, admit(past, &answer));
    questions_note_epoch(&questions.waiting[0]);
    questions_note_epoch(&questions.waiting[1]);
    past.request_id++;
    past.epoch_us = 0;
    TEST_ASSERT_EQUAL(ADMIT_NEW, admit(past, &answer));
    TEST_ASSERT_FALSE(questions_is_stale(&questions.waiting[0]));
    TEST_ASSERT_FALSE(questions_is_stale(&questions.waiting[1]));
    TEST_ASSERT_TRUE(questions_is_stale(&questions.waiting[2]));
}

static void test_turns_go_round_among_askers_and_each_ones_questions_in_order(void) {
    for (int n = 0; n < 3; n++) (void)ask(1, n);
    for (int n = 0; n < 3; n++) (void)ask(2, n);
    const int64_t expected[][2] = {{1, 0}, {2, 0}, {1, 1}, {2, 1}, {1, 2}, {2, 2}};
    for (size_t n = 0; n < sizeof expected / sizeof expected[0]; n++) {
        waiting_t* next = questions_next(&questions, false);
        TEST_ASSERT_EQUAL_INT64(expected[n][0], next->key.asker_id);
        TEST_ASSERT_EQUAL_INT64(expected[n][1], next->key.request_id);
        questions_done(&questions, next, NULL, 0);
    }
    TEST_ASSERT_NULL(questions_next(&questions, false));
}

static void test_a_question_begun_goes_on_before_its_askers_others_but_not_before_other_askers(void) {
    (void)ask(1, 0);
    (void)ask(1, 1);
    (void)ask(2, 0);
    waiting_t* slow = questions_next(&questions, false);
    slow->begun = true;
    questions_yield(&questions, slow);
    waiting_t* other = questions_next(&questions, false);
    TEST_ASSERT_EQUAL_INT64(2, other->key.asker_id);
    TEST_ASSERT_EQUAL_PTR(slow, questions_next(&questions, true));
    questions_done(&questions, other, NULL, 0);
    TEST_ASSERT_EQUAL_PTR(slow, questions_next(&questions, false));
}

static void test_a_flood_of_one_asker_leaves_room_and_a_turn_for_another(void) {
    for (int n = 0; n < 10 * QUESTIONS_MAX; n++) (void)ask(1, n);
    TEST_ASSERT_EQUAL(ADMIT_CROWDED, ask(1, -1));
    TEST_ASSERT_EQUAL(ADMIT_NEW, ask(2, 0));
    TEST_ASSERT_EQUAL_INT(QUESTIONS_MAX, questions.num_waiting);
    TEST_ASSERT_TRUE(questions.num_crowded > 0);
    questions_done(&questions, questions_next(&questions, false), NULL, 0);
    TEST_ASSERT_EQUAL_INT64(2, questions_next(&questions, false)->key.asker_id);
}

static void test_no_room_is_made_by_giving_up_what_has_begun(void) {
    for (int n = 0; n < QUESTIONS_MAX; n++) (void)ask(1, n);
    for (int n = 0; n < QUESTIONS_MAX; n++) questions.waiting[n].begun = true;
    TEST_ASSERT_EQUAL(ADMIT_CROWDED, ask(2, 0));
}

static void test_the_answers_of_a_busy_asker_do_not_push_out_those_of_another(void) {
    const kept_answer_t* answer = NULL;
    (void)ask(2, 0);
    answer_all();
    for (int n = 0; n < 3 * ANSWERS_MAX; n++) {
        (void)ask(1, n);
        answer_all();
    }
    TEST_ASSERT_EQUAL(ADMIT_ANSWERED, admit(key(2, 0), &answer));
    TEST_ASSERT_EQUAL(ADMIT_NEW, ask(1, 0));
    TEST_ASSERT_EQUAL(ADMIT_ANSWERED, admit(key(1, 3 * ANSWERS_MAX - 1), &answer));
}

static void test_more_askers_than_there_are_places_for_are_served_too(void) {
    for (int n = 0; n < 4 * ASKERS_MAX; n++) {
        TEST_ASSERT_EQUAL(ADMIT_NEW, ask(n, 0));
        answer_all();
    }
    for (int n = 0; n < 4 * ASKERS_MAX; n++) {
        const admission_t admission = ask(n + 100000, 0);
        TEST_ASSERT_TRUE(admission == (n < QUESTIONS_MAX ? ADMIT_NEW : ADMIT_CROWDED));
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_a_question_asked_again_waits_once_and_then_gets_its_stored_answer);
    RUN_TEST(test_another_question_under_an_old_id_is_refused_before_and_after_the_answer);
    RUN_TEST(test_the_same_id_of_another_asker_or_kind_is_another_question);
    RUN_TEST(test_no_clock_of_one_asker_makes_another_ones_question_stale);
    RUN_TEST(test_turns_go_round_among_askers_and_each_ones_questions_in_order);
    RUN_TEST(test_a_question_begun_goes_on_before_its_askers_others_but_not_before_other_askers);
    RUN_TEST(test_a_flood_of_one_asker_leaves_room_and_a_turn_for_another);
    RUN_TEST(test_no_room_is_made_by_giving_up_what_has_begun);
    RUN_TEST(test_the_answers_of_a_busy_asker_do_not_push_out_those_of_another);
    RUN_TEST(test_more_askers_than_there_are_places_for_are_served_too);
    return UNITY_END();
}
