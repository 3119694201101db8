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

#include "channels.h"
#include "lcm_ssv_planner_status_t.h"
#include "ssv/answer.h"
#include "wire/message.h"

#define RESEND_PERIOD_S 0.5
/// No datagram is larger. liblcm gives the start of one, cut within its channel's name, a negative size.
#define DATAGRAM_SIZE_MAX 65535

/// One question and the wait for its answer, which is a plan or quotes.
typedef struct {
    const char *ask_channel, *answer_channel;
    int64_t request_id;
    lcm_ssv_plan_t* plan;
    lcm_ssv_quote_batch_t* quotes;
    int32_t num_quotes;    ///< as many as there must be
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

// The generated decoders may read only what wire_is_message vouches for.

static void plan_received(const lcm_recv_buf_t* datagram, const char* channel, void* context) {
    (void)channel;
    wait_t* wait = context;
    lcm_ssv_plan_t plan;
    if (wait->answered) {
        return;
    }
    if (datagram->data_size > DATAGRAM_SIZE_MAX || !wire_is_message("plan_t", datagram->data, datagram->data_size) ||
        lcm_ssv_plan_t_decode(datagram->data, 0, (int)datagram->data_size, &plan) < 0) {
        wait->foreign++;
        return;
    }
    wait->answered = plan.quote.request_id == wait->request_id;
    if (wait->answered) {
        *wait->plan = plan;
    } else {
        lcm_ssv_plan_t_decode_cleanup(&plan);
    }
}

static void quotes_received(const lcm_recv_buf_t* datagram, const char* channel, void* context) {
    (void)channel;
    wait_t* wait = context;
    lcm_ssv_quote_batch_t quotes;
    if (wait->answered) {
        return;
    }
    if (datagram->data_size > DATAGRAM_SIZE_MAX ||
        !wire_is_message("quote_batch_t", datagram->data, datagram->data_size) ||
        lcm_ssv_quote_batch_t_decode(datagram->data, 0, (int)datagram->data_size, &quotes) < 0) {
        wait->foreign++;
        return;
    }
    const bool is_ours = quotes.request_id == wait->request_id;
    wait->answered = is_ours && quotes.num_quotes == wait->num_quotes;
    if (wait->answered) {
        *wait->quotes = quotes;
    } else {
        wait->foreign += is_ours;
        lcm_ssv_quote_batch_t_decode_cleanup(&quotes);
    }
}

static void status_received(const lcm_recv_buf_t* datagram, const char* channel, void* context) {
    (void)channel;
    wait_t* wait = context;
    lcm_ssv_planner_status_t status;
    if (datagram->data_size <= DATAGRAM_SIZE_MAX &&
        wire_is_message("planner_status_t", datagram->data, datagram->data_size) &&
        lcm_ssv_planner_status_t_decode(datagram->data, 0, (int)datagram->data_size, &status) >= 0) {
        snprintf(wait->scalar_heard, sizeof wait->scalar_heard, "%s", status.scalar);
        tree_make_harmless(wait->scalar_heard);
        lcm_ssv_planner_status_t_decode_cleanup(&status);
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
    if (lcm_subscribe(lcm, CHANNEL_STATUS, status_received, wait) == NULL) {
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
    wait_t wait = {.ask_channel = CHANNEL_SCENARIO,
                   .answer_channel = CHANNEL_PLAN,
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
    wait_t wait = {.ask_channel = CHANNEL_BATCH,
                   .answer_channel = CHANNEL_QUOTES,
                   .request_id = question->request_id,
                   .quotes = answer,
                   .num_quotes = question->num_scenarios,
                   .scalar = scalar};
    const int size = lcm_ssv_scenario_batch_t_encode(message, 0, sizeof message, question);
    assert(size > 0);
    return ask(url, timeout_s, message, (unsigned)size, quotes_received, &wait, error, error_size);
}
