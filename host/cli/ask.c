#define _POSIX_C_SOURCE 200809L
#include "ask.h"

#include <assert.h>
#include <lcm/lcm.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "lcm_ssv_planner_status_t.h"
#include "ssv/answer.h"

#define RESEND_PERIOD_S 0.5
/// No datagram is larger. liblcm gives the start of one, cut within its channel's name, a negative size.
#define DATAGRAM_SIZE_MAX 65535

/// One question and the wait for its answer, which is a plan or quotes.
typedef struct {
    const char *ask_channel, *answer_channel;
    int64_t request_id;
    lcm_ssv_plan_t* plan;
    lcm_ssv_quote_batch_t* quotes;
    uint32_t num_quotes;   ///< as many as there must be
    const char* scalar;    ///< the one that the planner must have; NULL = any
    char scalar_heard[16]; ///< from its status; empty until then
    bool answered;
    int foreign; ///< messages on the channel that are no such answer of our version
} wait_t;

static double now_s(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static uint32_t read_u32(const uint8_t* data) {
    return (uint32_t)data[0] << 24 | (uint32_t)data[1] << 16 | (uint32_t)data[2] << 8 | data[3];
}

static uint64_t read_u64(const uint8_t* data) { return (uint64_t)read_u32(data) << 32 | read_u32(data + 4); }

/// Steps over a string of the wire. @return whether it lies within the datagram and ends with its only terminator.
static bool skip_string(const uint8_t* data, size_t size, size_t* at) {
    if (*at > size || size - *at < 4) {
        return false;
    }
    const size_t length = read_u32(data + *at);
    *at += 4;
    if (length == 0 || length > size - *at || data[*at + length - 1] != '\0') {
        return false;
    }
    *at += length;
    return true;
}

/// Steps over a number of candidates. @return whether they lie within the datagram as far as their last string.
static bool skip_candidates(const uint8_t* data, size_t size, uint32_t count, size_t* at) {
    for (uint32_t i = 0; i < count; i++) {
        *at += 1 + 2 * 8;
        if (!skip_string(data, size, at)) {
            return false;
        }
        *at += 3 * 8;
    }
    return true;
}

/// Steps over a quote_t. @return whether its counts are within their limits, and it within the datagram as far as its
/// last string.
static bool skip_quote(const uint8_t* data, size_t size, size_t* at) {
    if (*at > size || size - *at < 2 * 4) {
        return false;
    }
    const uint32_t num_candidates = read_u32(data + *at), num_front = read_u32(data + *at + 4);
    if (num_candidates > SSV_MAX_CANDIDATES || num_front > SSV_MAX_FRONT) {
        return false;
    }
    *at += 2 * 4 + 3 * 8 + 1;
    if (!skip_string(data, size, at)) {
        return false;
    }
    *at += 4 * 8 + (1 + 2 * 8 + 4);
    return skip_candidates(data, size, num_candidates, at) && skip_candidates(data, size, num_front, at);
}

// Whether a datagram is what its type hash says, through and through: the generated decoders allocate what the counts
// and the string lengths say, do not look for the strings' terminators, and forget what they allocated when the
// datagram ends early. Offsets follow the .lcm files; the type hash vouches for them.

static bool plan_is_decodable(const uint8_t* data, size_t size) {
    const size_t counts_end = 8 + 3 * 4;
    if (size < counts_end || size > DATAGRAM_SIZE_MAX || read_u64(data) != (uint64_t)__lcm_ssv_plan_t_get_hash()) {
        return false;
    }
    const uint32_t num_legs = read_u32(data + 8), num_segments = read_u32(data + 12), num_events = read_u32(data + 16);
    size_t at = counts_end;
    if (num_legs > SSV_MAX_LEGS || num_segments > SSV_MAX_SEGMENTS || num_events > SSV_MAX_EVENTS ||
        !skip_quote(data, size, &at)) {
        return false;
    }
    // What follows has no strings. encoded_size counts the type hash, which parts of a message do not have.
    at += 8;
    at += num_legs * ((size_t)lcm_ssv_leg_t_encoded_size(&(lcm_ssv_leg_t){0}) - 8);
    at += num_segments * ((size_t)lcm_ssv_segment_t_encoded_size(&(lcm_ssv_segment_t){0}) - 8);
    at += num_events * ((size_t)lcm_ssv_event_t_encoded_size(&(lcm_ssv_event_t){0}) - 8);
    at += 2 * ((size_t)lcm_ssv_pose_t_encoded_size(&(lcm_ssv_pose_t){0}) - 8);
    return at == size;
}

static bool quotes_are_decodable(const uint8_t* data, size_t size, uint32_t num_quotes) {
    size_t at = 8 + 4 + 2 * 8;
    if (size < at || size > DATAGRAM_SIZE_MAX || read_u64(data) != (uint64_t)__lcm_ssv_quote_batch_t_get_hash() ||
        read_u32(data + 8) != num_quotes) {
        return false;
    }
    for (uint32_t i = 0; i < num_quotes; i++) {
        if (!skip_quote(data, size, &at)) {
            return false;
        }
    }
    return at == size;
}

static void plan_received(const lcm_recv_buf_t* datagram, const char* channel, void* context) {
    (void)channel;
    wait_t* wait = context;
    const uint8_t* data = datagram->data;
    const size_t request_id_at = 8 + 5 * 4;
    if (!plan_is_decodable(data, datagram->data_size)) {
        wait->foreign++;
    } else if (!wait->answered && (int64_t)read_u64(data + request_id_at) == wait->request_id) {
        wait->answered = lcm_ssv_plan_t_decode(data, 0, (int)datagram->data_size, wait->plan) >= 0;
    }
}

static void quotes_received(const lcm_recv_buf_t* datagram, const char* channel, void* context) {
    (void)channel;
    wait_t* wait = context;
    const uint8_t* data = datagram->data;
    const size_t request_id_at = 8 + 4;
    const bool is_ours =
        datagram->data_size >= request_id_at + 8 && (int64_t)read_u64(data + request_id_at) == wait->request_id;
    if (is_ours && !wait->answered && quotes_are_decodable(data, datagram->data_size, wait->num_quotes)) {
        wait->answered = lcm_ssv_quote_batch_t_decode(data, 0, (int)datagram->data_size, wait->quotes) >= 0;
    } else if (is_ours || datagram->data_size < 8 || read_u64(data) != (uint64_t)__lcm_ssv_quote_batch_t_get_hash()) {
        wait->foreign++;
    }
}

static void status_received(const lcm_recv_buf_t* datagram, const char* channel, void* context) {
    (void)channel;
    wait_t* wait = context;
    const uint8_t* data = datagram->data;
    const size_t size = datagram->data_size;
    size_t at = 8 + 8;
    if (size < at || size > DATAGRAM_SIZE_MAX || read_u64(data) != (uint64_t)__lcm_ssv_planner_status_t_get_hash() ||
        !skip_string(data, size, &at)) {
        return;
    }
    const char* scalar = (const char*)data + at + 4;
    if (skip_string(data, size, &at)) {
        snprintf(wait->scalar_heard, sizeof wait->scalar_heard, "%s", scalar);
    }
}

static const char* url_in_use(const char* url) {
    const char* const from_environment = getenv("LCM_DEFAULT_URL");
    return url != NULL ? url : from_environment != NULL ? from_environment : "udpm://239.255.76.67:7667?ttl=0";
}

/// Sends and waits until the answer is there or the time is over. @return false with the error set if LCM fails.
static bool exchange(lcm_t* lcm, const uint8_t* message, unsigned size, double timeout_s, wait_t* wait, char* error,
                     size_t error_size) {
    const double deadline_s = now_s() + timeout_s;
    double send_at_s = 0;
    for (double t_s = now_s(); !wait->answered && t_s < deadline_s; t_s = now_s()) {
        if (t_s >= send_at_s) {
            if (lcm_publish(lcm, wait->ask_channel, message, size) != 0) {
                snprintf(error, error_size, "LCM cannot send the question");
                return false;
            }
            send_at_s = t_s + RESEND_PERIOD_S;
        }
        const double wait_s = fmin(send_at_s, deadline_s) - t_s;
        if (lcm_handle_timeout(lcm, (int)ceil(1000 * wait_s)) < 0) {
            snprintf(error, error_size, "LCM cannot receive");
            return false;
        }
    }
    return true;
}

/// Waits until the planner says which scalar it computes in. @return whether that is the one wanted, else with the
/// error set.
static bool check_scalar(lcm_t* lcm, const char* url, double timeout_s, wait_t* wait, char* error, size_t error_size) {
    const double deadline_s = now_s() + timeout_s;
    if (lcm_subscribe(lcm, "SSV_PLANNER_STATUS", status_received, wait) == NULL) {
        snprintf(error, error_size, "cannot set up LCM on %s", url_in_use(url));
        return false;
    }
    for (double t_s = now_s(); wait->scalar_heard[0] == '\0' && t_s < deadline_s; t_s = now_s()) {
        if (lcm_handle_timeout(lcm, (int)ceil(1000 * (deadline_s - t_s))) < 0) {
            snprintf(error, error_size, "LCM cannot receive");
            return false;
        }
    }
    if (wait->scalar_heard[0] == '\0') {
        snprintf(error, error_size,
                 "no planner on %s said within %g s what it computes in, which --scalar waits for; start "
                 "ssv-plannerd there, or give it more time with --timeout",
                 url_in_use(url), timeout_s);
    } else if (strcmp(wait->scalar_heard, wait->scalar) != 0) {
        snprintf(error, error_size,
                 "the planner on %s computes in %s, not in %s; start one that does (ssv-plannerd --version "
                 "says which), or ask without --scalar",
                 url_in_use(url), wait->scalar_heard, wait->scalar);
    }
    return strcmp(wait->scalar_heard, wait->scalar) == 0;
}

/// Sends the encoded question and waits for its answer. @return false with the error set if there is none.
static bool ask(const char* url, double timeout_s, const uint8_t* message, unsigned size, lcm_msg_handler_t received,
                wait_t* wait, char* error, size_t error_size) {
    lcm_t* lcm = lcm_create(url);
    if (lcm == NULL) {
        snprintf(error, error_size,
                 "no LCM on %s; for UDP multicast the machine needs a route, e.g. ip route add 224.0.0.0/4 dev lo",
                 url_in_use(url));
        return false;
    }
    bool sound = lcm_subscribe(lcm, wait->answer_channel, received, wait) != NULL;
    if (!sound) {
        snprintf(error, error_size, "cannot set up LCM on %s", url_in_use(url));
    } else {
        sound = (wait->scalar == NULL || check_scalar(lcm, url, timeout_s, wait, error, error_size)) &&
                exchange(lcm, message, size, timeout_s, wait, error, error_size);
    }
    lcm_destroy(lcm);
    if (!sound || wait->answered) {
        return sound;
    }
    char foreign[160] = "";
    if (wait->foreign > 0) {
        snprintf(foreign, sizeof foreign,
                 " (%d messages on %s are of another type: is the planner of another version?)", wait->foreign,
                 wait->answer_channel);
    }
    snprintf(error, error_size,
             "nobody answered on %s within %g s%s; start ssv-plannerd there, give it more time "
             "with --timeout, or ask without --lcm",
             url_in_use(url), timeout_s, foreign);
    return false;
}

bool ask_plan(const char* url, const char* scalar, double timeout_s, const lcm_ssv_scenario_t* question,
              lcm_ssv_plan_t* answer, char* error, size_t error_size) {
    static uint8_t message[1024];
    wait_t wait = {.ask_channel = "SSV_SCENARIO",
                   .answer_channel = "SSV_PLAN",
                   .request_id = question->request_id,
                   .plan = answer,
                   .scalar = scalar};
    const int size = lcm_ssv_scenario_t_encode(message, 0, sizeof message, question);
    assert(size > 0);
    return ask(url, timeout_s, message, (unsigned)size, plan_received, &wait, error, error_size);
}

bool ask_quotes(const char* url, const char* scalar, double timeout_s, const lcm_ssv_scenario_batch_t* question,
                lcm_ssv_quote_batch_t* answer, char* error, size_t error_size) {
    static uint8_t message[1024 * SSV_MAX_BATCH];
    wait_t wait = {.ask_channel = "SSV_SCENARIO_BATCH",
                   .answer_channel = "SSV_QUOTE_BATCH",
                   .request_id = question->request_id,
                   .quotes = answer,
                   .num_quotes = (uint32_t)question->num_scenarios,
                   .scalar = scalar};
    const int size = lcm_ssv_scenario_batch_t_encode(message, 0, sizeof message, question);
    assert(size > 0);
    return ask(url, timeout_s, message, (unsigned)size, quotes_received, &wait, error, error_size);
}
