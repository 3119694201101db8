#define _DEFAULT_SOURCE
#include "line.h"

#include <assert.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "channels.h"
#include "lcm_ssv_planner_status_t.h"
#include "ssv/address.h"
#include "wire/message.h"
#include "wire/names.h"

/// Messages that wait while we look at one; liblcm's own 30 are soon filled by a stranger, or by a flight that goes
/// much faster than the clock.
#define QUEUE_CAPACITY 4096
/// [bytes] Of the socket's buffer. A simulated flight tells in a second what a real one tells in ten minutes.
#define ROOM_MAX 4194304
#define REFUSALS_SHOWN 3

double line_now_s(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static const char* url_in_use(const char* url) {
    const char* const from_environment = getenv("LCM_DEFAULT_URL");
    return url != NULL ? url : from_environment != NULL ? from_environment : "udpm://239.255.76.67:7667?ttl=0";
}

bool line_wants(const line_t* line, int8_t scalar) {
    return line->scalar == NULL || strcmp(name_of(&names_scalar, scalar), line->scalar) == 0;
}

void line_refuse(line_t* line, char* reason) {
    tree_make_harmless(reason);
    if (line->refused++ < REFUSALS_SHOWN) {
        fprintf(stderr, "ssv: refused an answer on %s, still waiting for a right one: %s\n", line->answer_channel,
                reason);
    }
}

bool line_check_scalar(const line_t* line, const lcm_ssv_answer_t* answer, char reason[SSV_CHECK_REASON_SIZE]) {
    if (line_wants(line, answer->planner.scalar)) return true;
    snprintf(reason, SSV_CHECK_REASON_SIZE, "planner.scalar: %s, but %s was asked for",
             name_of(&names_scalar, answer->planner.scalar), line->scalar);
    return false;
}

bool line_is_message(const char* type, const lcm_recv_buf_t* datagram) {
    return datagram->data_size <= LINE_DATAGRAM_MAX && wire_is_message(type, datagram->data, datagram->data_size);
}

static void status_received(const lcm_recv_buf_t* datagram, const char* channel, void* context) {
    (void)channel;
    line_t* line = context;
    lcm_ssv_planner_status_t status;
    if (!line_is_message("planner_status_t", datagram) ||
        lcm_ssv_planner_status_t_decode(datagram->data, 0, (int)datagram->data_size, &status) < 0) {
        return;
    }
    int i = 0;
    while (i < line->num_heard && line->heard[i].planner_id != status.planner.planner_id) i++;
    if (i < LINE_PLANNERS_MAX && status.planner.planner_id != 0) {
        if (i == line->num_heard) {
            line->heard[line->num_heard++] =
                (line_planner_t){.planner_id = status.planner.planner_id, .scalar = status.planner.scalar, .batch = -1};
        }
        line->heard[i].link = status.link;
        line->heard[i].heard_s = line_now_s();
    }
    lcm_ssv_planner_status_t_decode_cleanup(&status);
}

void line_close(line_t* line) {
    lcm_destroy(line->lcm);
    if (line->refused > REFUSALS_SHOWN) {
        fprintf(stderr, "ssv: refused %d more answers on %s\n", line->refused - REFUSALS_SHOWN, line->answer_channel);
    }
}

/// The URL with as much room for what arrives while we are busy as the system gives; it doubles what one asks for.
static void with_room(const char* url, char* roomy, size_t size) {
    long most = 0;
    FILE* const limit = fopen("/proc/sys/net/core/rmem_max", "r");
    if (limit != NULL && fscanf(limit, "%ld", &most) != 1) most = 0;
    if (limit != NULL) fclose(limit);
    const bool may = most > 0 && strncmp(url, "udpm:", 5) == 0 && strstr(url, "recv_buf_size") == NULL;
    const long room = most < ROOM_MAX / 2 ? 2 * most : ROOM_MAX;
    const int length =
        may ? snprintf(roomy, size, "%s%crecv_buf_size=%ld", url, strchr(url, '?') != NULL ? '&' : '?', room) : -1;
    if (length < 0 || (size_t)length >= size) snprintf(roomy, size, "%s", url);
}

static void tell_no_lcm(const line_t* line, char* error, size_t error_size) {
    char advice[SSV_ADVICE_SIZE];
    ssv_address_advice(url_in_use(line->url), advice);
    snprintf(error, error_size, "no LCM on %s: %s", url_in_use(line->url), advice);
}

bool line_open(line_t* line, lcm_msg_handler_t received, void* context, char* error, size_t error_size) {
    char url[1024];
    with_room(url_in_use(line->url), url, sizeof url);
    line->lcm = lcm_create(url);
    if (line->lcm == NULL) {
        tell_no_lcm(line, error, error_size);
        return false;
    }
    if (line_hear(line, line->answer_channel, received, context, error, error_size) &&
        line_hear(line, CHANNEL_STATUS, status_received, line, error, error_size)) {
        return true;
    }
    line_close(line);
    return false;
}

bool line_hear(line_t* line, const char* channel, lcm_msg_handler_t received, void* context, char* error,
               size_t error_size) {
    lcm_subscription_t* const subscription = lcm_subscribe(line->lcm, channel, received, context);
    if (subscription == NULL || lcm_subscription_set_queue_capacity(subscription, QUEUE_CAPACITY) != 0) {
        tell_no_lcm(line, error, error_size);
        return false;
    }
    return true;
}

bool line_wait(line_t* line, double until_s, int wake_fd, char* error, size_t error_size) {
    const double wait_s = fmax(until_s - line_now_s(), 0);
    struct pollfd fds[] = {{.fd = lcm_get_fileno(line->lcm), .events = POLLIN, .revents = 0},
                           {.fd = wake_fd, .events = POLLIN, .revents = 0}};
    poll(fds, 2, (int)ceil(1000 * wait_s));
    int handled = 1;
    for (int i = 0; i < QUEUE_CAPACITY && handled > 0; i++) handled = lcm_handle_timeout(line->lcm, 0);
    if (handled < 0) snprintf(error, error_size, "LCM cannot receive on %s", url_in_use(line->url));
    return handled >= 0;
}

bool line_send(line_t* line, const char* channel, const uint8_t* message, int size, char* error, size_t error_size) {
    assert(size > 0);
    if (lcm_publish(line->lcm, channel, message, (unsigned)size) != 0) {
        snprintf(error, error_size, "LCM cannot send the question on %s", url_in_use(line->url));
        return false;
    }
    return true;
}

const line_planner_t* line_first_wanted(const line_t* line) {
    for (int i = 0; i < line->num_heard; i++) {
        if (line_wants(line, line->heard[i].scalar)) return &line->heard[i];
    }
    return NULL;
}

void line_tell_silence(const line_t* line, char* error, size_t error_size) {
    const char* const url = url_in_use(line->url);
    char foreign[160] = "";
    if (line->foreign > 0) {
        snprintf(foreign, sizeof foreign,
                 " (%d messages on %s are of another type: is the planner of another version?)", line->foreign,
                 line->answer_channel);
    }
    if (line->scalar != NULL && line_first_wanted(line) == NULL && line->num_heard > 0) {
        snprintf(error, error_size,
                 "the planner on %s computes in %s, not in %s; start one that does (ssv-plannerd --version "
                 "says which), or ask without --scalar",
                 url, name_of(&names_scalar, line->heard[0].scalar), line->scalar);
    } else if (line->scalar != NULL && line_first_wanted(line) == NULL) {
        snprintf(error, error_size,
                 "no planner on %s said within %g s what it computes in, which --scalar waits for; start "
                 "ssv-plannerd there, or give it more time with --timeout",
                 url, line->timeout_s);
    } else {
        snprintf(error, error_size,
                 "nobody answered on %s within %g s%s; start ssv-plannerd there, give it more time "
                 "with --timeout, or ask without --lcm",
                 url, line->timeout_s, foreign);
    }
}
