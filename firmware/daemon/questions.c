#include "questions.h"

#include <string.h>

static bool same_id(const question_key_t* a, const question_key_t* b) {
    return a->kind == b->kind && a->asker_id == b->asker_id && a->request_id == b->request_id;
}

void questions_init(questions_t* questions, uint8_t* question_arena, size_t question_size_max, uint8_t* answer_arena,
                    size_t answer_size_max) {
    memset(questions, 0, sizeof *questions);
    for (size_t i = 0; i < QUESTIONS_MAX; i++) questions->waiting[i].bytes = question_arena + i * question_size_max;
    for (size_t i = 0; i < ANSWERS_MAX; i++) questions->kept[i].bytes = answer_arena + i * answer_size_max;
}

static asker_t* find_asker(questions_t* questions, int64_t asker_id) {
    for (int i = 0; i < ASKERS_MAX; i++) {
        asker_t* asker = &questions->asker[i];
        if (asker->known && asker->asker_id == asker_id) return asker;
    }
    return NULL;
}

// The place of an asker: its own, or the one of which nothing was heard for the longest time and nothing is here. There
// is such a place, for there is one more than questions and answers together.
static asker_t* place_of_asker(questions_t* questions, int64_t asker_id) {
    asker_t* place = find_asker(questions, asker_id);
    if (place != NULL) return place;
    for (int i = 0; i < ASKERS_MAX; i++) {
        asker_t* asker = &questions->asker[i];
        if (asker->num_waiting > 0 || asker->num_kept > 0) continue;
        if (place == NULL || asker->heard < place->heard) place = asker;
    }
    *place = (asker_t){.asker_id = asker_id, .known = true, .newest_epoch_us = INT64_MIN};
    return place;
}

// The newest question not yet begun of the asker that has the most waiting; NULL if that is the one who asks for room.
static waiting_t* crowd(questions_t* questions, const asker_t* asker) {
    const asker_t* most = asker;
    for (int i = 0; i < ASKERS_MAX; i++) {
        const int least = most->num_waiting + (most == asker ? 1 : 0);
        if (questions->asker[i].num_waiting > least) most = &questions->asker[i];
    }
    waiting_t* newest = NULL;
    for (int i = 0; i < QUESTIONS_MAX && most != asker; i++) {
        waiting_t* waiting = &questions->waiting[i];
        if (waiting->asker != most || waiting->begun) continue;
        if (newest == NULL || waiting->arrived > newest->arrived) newest = waiting;
    }
    return newest;
}

static void free_place(questions_t* questions, waiting_t* waiting) {
    waiting->asker->num_waiting--;
    waiting->asker = NULL;
    waiting->begun = false;
    questions->num_waiting--;
}

static waiting_t* make_room(questions_t* questions, const asker_t* asker) {
    for (int i = 0; i < QUESTIONS_MAX; i++) {
        if (questions->waiting[i].asker == NULL) return &questions->waiting[i];
    }
    questions->num_crowded++;
    waiting_t* given_up = crowd(questions, asker);
    if (given_up != NULL) free_place(questions, given_up);
    return given_up;
}

admission_t questions_admit(questions_t* questions, const question_key_t* key, const void* bytes, int size,
                            const kept_answer_t** answer) {
    for (int i = 0; i < ANSWERS_MAX; i++) {
        const kept_answer_t* kept = &questions->kept[i];
        if (kept->asker == NULL || !same_id(&kept->key, key)) continue;
        if (kept->key.hash != key->hash) return ADMIT_REUSED;
        *answer = kept;
        return ADMIT_ANSWERED;
    }
    for (int i = 0; i < QUESTIONS_MAX; i++) {
        const waiting_t* waiting = &questions->waiting[i];
        if (waiting->asker == NULL || !same_id(&waiting->key, key)) continue;
        return waiting->key.hash == key->hash ? ADMIT_WAITING : ADMIT_REUSED;
    }
    asker_t* asker = place_of_asker(questions, key->asker_id);
    asker->heard = ++questions->now;
    waiting_t* place = make_room(questions, asker);
    if (place == NULL) return ADMIT_CROWDED;
    place->key = *key;
    place->asker = asker;
    place->arrived = questions->now;
    place->size = size;
    memcpy(place->bytes, bytes, (size_t)size);
    asker->num_waiting++;
    questions->num_waiting++;
    return ADMIT_NEW;
}

void questions_note_epoch(waiting_t* question) {
    asker_t* asker = question->asker;
    if (question->key.epoch_us > asker->newest_epoch_us) asker->newest_epoch_us = question->key.epoch_us;
}

bool questions_is_stale(const waiting_t* question) { return question->key.epoch_us < question->asker->newest_epoch_us; }

waiting_t* questions_next(questions_t* questions, bool begun_only) {
    waiting_t* next = NULL;
    for (int i = 0; i < QUESTIONS_MAX; i++) {
        waiting_t* waiting = &questions->waiting[i];
        if (waiting->asker == NULL || (begun_only && !waiting->begun)) continue;
        const bool same_turn = next != NULL && waiting->asker->served == next->asker->served;
        // What one asker has begun comes before the rest of its questions.
        const bool sooner = same_turn && waiting->asker == next->asker && waiting->begun != next->begun
                                ? waiting->begun
                                : same_turn && waiting->arrived < next->arrived;
        if (next == NULL || waiting->asker->served < next->asker->served || sooner) next = waiting;
    }
    return next;
}

void questions_yield(questions_t* questions, waiting_t* question) { question->asker->served = ++questions->now; }

static kept_answer_t* place_of_answer(questions_t* questions) {
    const asker_t* most = &questions->asker[0];
    for (int i = 1; i < ASKERS_MAX; i++) {
        if (questions->asker[i].num_kept > most->num_kept) most = &questions->asker[i];
    }
    kept_answer_t* oldest = NULL;
    for (int i = 0; i < ANSWERS_MAX; i++) {
        kept_answer_t* kept = &questions->kept[i];
        if (kept->asker == NULL) return kept;
        if (kept->asker == most && (oldest == NULL || kept->stored < oldest->stored)) oldest = kept;
    }
    return oldest;
}

void questions_done(questions_t* questions, waiting_t* question, const void* answer, int size) {
    questions_yield(questions, question);
    if (size > 0) {
        kept_answer_t* place = place_of_answer(questions);
        if (place->asker != NULL) place->asker->num_kept--;
        place->key = question->key;
        place->asker = question->asker;
        place->asker->num_kept++;
        place->stored = questions->now;
        place->size = size;
        memcpy(place->bytes, answer, (size_t)size);
    }
    free_place(questions, question);
}
