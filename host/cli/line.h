/// A connection to the bus, and the planners that are heard on it.
///
/// The bus is open to strangers. What comes is looked at as bytes first (line_is_message), then by whoever asked. What
/// fails is refused with a line on standard error, a few at most and then a count.
#ifndef SSV_LINE_H
#define SSV_LINE_H

#include <lcm/lcm.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "lcm_ssv_answer_t.h"
#include "ssv/check.h"

#define LINE_PLANNERS_MAX 64
/// No datagram is larger. liblcm gives the start of one, cut within its channel's name, a negative size.
#define LINE_DATAGRAM_MAX 65535
/// [s] Status comes once a second: how long to listen for the first one, and after which silence a planner is gone.
#define LINE_LISTEN_S 1.2
#define LINE_SILENCE_S 3.0

/// A planner that was heard.
typedef struct {
    int64_t planner_id; ///< 0 = whoever hears it, where none was heard
    int8_t scalar;
    int8_t link; ///< planner_status_t.LINK_*
    double heard_s;
    int failures; ///< batches that it lost
    int batch;    ///< number of the one that it has, -1 = none
} line_planner_t;

/// The caller sets the first four.
typedef struct {
    const char* url;            ///< LCM provider; NULL for LCM's default
    const char* scalar;         ///< arithmetic that the planner must compute in; NULL for any
    double timeout_s;           ///< how long to wait for an answer, for the sentence that says that none came
    const char* answer_channel; ///< where the answers are awaited
    lcm_t* lcm;
    line_planner_t heard[LINE_PLANNERS_MAX];
    int num_heard;
    int foreign; ///< messages on the channel that are none of our version
    int refused; ///< answers to us that were not right
} line_t;

/// [s] By a clock that never goes back.
double line_now_s(void);

/// @param context  what `received` gets for each message on the line's answer channel; begins with the line.
/// @return false with a sentence in `error`, and nothing to close.
bool line_open(line_t* line, lcm_msg_handler_t received, void* context, char* error, size_t error_size);

/// Has one more channel received likewise.
bool line_hear(line_t* line, const char* channel, lcm_msg_handler_t received, void* context, char* error,
               size_t error_size);

void line_close(line_t* line);

/// Waits until a message is received, `until_s` has come, or `wake_fd` can be read (-1 for none); takes what is there.
/// @return false with the error set if LCM fails.
bool line_wait(line_t* line, double until_s, int wake_fd, char* error, size_t error_size);

bool line_send(line_t* line, const char* channel, const uint8_t* message, int size, char* error, size_t error_size);

/// Whether a datagram is one message of this type, through and through. The generated decoders may read nothing else.
bool line_is_message(const char* type, const lcm_recv_buf_t* datagram);

/// An answer that is not used. The first few are told; what it holds may steer a terminal, and is made harmless.
void line_refuse(line_t* line, char* reason);

/// What ssv/check.h leaves open: the scalar that was asked for.
bool line_check_scalar(const line_t* line, const lcm_ssv_answer_t* answer, char reason[SSV_CHECK_REASON_SIZE]);

bool line_wants(const line_t* line, int8_t scalar);

/// The first planner of the scalar that is wanted; NULL if none was heard.
const line_planner_t* line_first_wanted(const line_t* line);

/// Why nobody answered, in a sentence.
void line_tell_silence(const line_t* line, char* error, size_t error_size);

#endif
