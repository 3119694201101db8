/// Questions that wait and answers that are kept: who may ask how much, whose turn it is, and which answer a question
/// gets that was asked before. Knows neither LCM nor a clock, nor what the bytes of a question mean.
///
/// A question is told by its kind, its asker, the asker's id for it and the hash of what it asks. The same four are the
/// same question: while it waits it is not queued twice, and once answered it gets the stored bytes again. The first
/// three with another hash are a mistake, or somebody else's doing, and are refused.
///
/// No asker can take another's turn: the asker whose last turn is longest ago comes next, its own questions in order of
/// arrival. A turn may end before the answer is there; a question once begun keeps its place. When all places are
/// taken, the asker with the most of them gives up its newest. Epochs are ordered for each asker alone. All memory is
/// the caller's; every call is linear in the sizes below.
#ifndef SSV_QUESTIONS_H
#define SSV_QUESTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Questions that may wait, answers that are kept, and askers that are remembered: each that has one of either, and one
/// more.
#define QUESTIONS_MAX 256
#define ANSWERS_MAX 256
#define ASKERS_MAX (QUESTIONS_MAX + ANSWERS_MAX + 1)

/// What a question is known by.
typedef struct {
    int kind; ///< row of the daemon's table of kinds
    int64_t asker_id;
    int64_t request_id; ///< the asker's own
    int64_t epoch_us;   ///< when the world looked like this, by the asker's clock
    uint64_t hash;      ///< of all that is asked
} question_key_t;

typedef enum {
    ADMIT_NEW,      ///< it waits now
    ADMIT_WAITING,  ///< it waits already
    ADMIT_ANSWERED, ///< *answer is what it got before
    ADMIT_REUSED,   ///< its id stands for another question of this asker
    ADMIT_CROWDED   ///< no room, and this asker has the most places
} admission_t;

typedef struct {
    int64_t asker_id;
    bool known;
    int64_t newest_epoch_us;
    uint64_t served, heard; ///< order of its last turn, and of the last time it was heard
    int num_waiting, num_kept;
} asker_t;

/// A question that waits, its bytes in the caller's arena.
typedef struct {
    question_key_t key;
    asker_t* asker;   ///< NULL = free place
    uint64_t arrived; ///< order of arrival
    bool begun;       ///< set by the caller while a part of the answer is there
    int size;
    uint8_t* bytes;
} waiting_t;

/// An answer that is kept, likewise.
typedef struct {
    question_key_t key;
    asker_t* asker;
    uint64_t stored; ///< order of storing
    int size;
    uint8_t* bytes;
} kept_answer_t;

typedef struct {
    waiting_t waiting[QUESTIONS_MAX];
    kept_answer_t kept[ANSWERS_MAX];
    asker_t asker[ASKERS_MAX];
    int num_waiting;
    uint64_t now;        ///< counts arrivals and turns
    int64_t num_crowded; ///< questions given up for want of room
} questions_t;

/// Empty. The two arenas have room for QUESTIONS_MAX questions and ANSWERS_MAX answers of the sizes given, and must
/// outlive *questions.
void questions_init(questions_t* questions, uint8_t* question_arena, size_t question_size_max, uint8_t* answer_arena,
                    size_t answer_size_max);

/// Takes a question that has arrived, `size` bytes of at most question_size_max, which are copied.
/// @param[out] answer where ADMIT_ANSWERED.
admission_t questions_admit(questions_t* questions, const question_key_t* key, const void* bytes, int size,
                            const kept_answer_t** answer);

/// Notes the epoch of a question that turned out to be a sound one.
void questions_note_epoch(waiting_t* question);

/// Whether its asker has had a sound question about a newer world (question->asker->newest_epoch_us).
bool questions_is_stale(const waiting_t* question);

/// The question whose turn it is, NULL if none waits; of those begun alone, if `begun_only`. It stays where it is until
/// questions_done.
waiting_t* questions_next(questions_t* questions, bool begun_only);

/// Ends a turn: other askers come before this one's next.
void questions_yield(questions_t* questions, waiting_t* question);

/// Frees the question's place and keeps its answer, in the place of the oldest answer of the asker that has the most;
/// with size 0 none is kept.
void questions_done(questions_t* questions, waiting_t* question, const void* answer, int size);

#endif
