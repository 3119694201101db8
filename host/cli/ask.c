#define _POSIX_C_SOURCE 200809L
#include "ask.h"

#include <lcm/lcm.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "ssv/planner.h"

#define RESEND_PERIOD_S 0.5

typedef struct {
    int64_t request_id;
    lcm_ssv_plan_t* answer;
    bool answered;
    int foreign;                  ///< messages on the channel that are no plan_t of our version
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

/// Whether the datagram is a plan_t through and through: the generated decoder allocates what the counts and the string
/// lengths say, does not look for the strings' terminators, and forgets what it allocated when the datagram ends early.
/// Offsets follow plan_t.lcm and candidate_t.lcm; the fingerprint vouches for them.
static bool plan_is_decodable(const uint8_t* data, size_t size) {
    static const uint32_t count_max[4] = {SSV_MAX_CANDIDATES, SSV_MAX_LEGS, SSV_MAX_SEGMENTS, SSV_MAX_EVENTS};
    const size_t reason_at = 8 + 4 * 4 + 4 * 8 + 1;
    if (size < reason_at || read_u64(data) != (uint64_t)__lcm_ssv_plan_t_get_hash()) {
        return false;
    }
    for (size_t i = 0; i < 4; i++) {
        if (read_u32(data + 8 + 4 * i) > count_max[i]) {
            return false;
        }
    }
    size_t at = reason_at;
    if (!skip_string(data, size, &at)) {
        return false;
    }
    at += 4 * 8 + (1 + 2 * 8 + 4);
    for (uint32_t i = 0; i < read_u32(data + 8); i++) {
        at += 1 + 2 * 8;
        if (!skip_string(data, size, &at)) {
            return false;
        }
        at += 3 * 8;
    }
    // What follows has no strings. encoded_size counts the fingerprint, which parts of a message do not have.
    at += read_u32(data + 12) * ((size_t)lcm_ssv_leg_t_encoded_size(&(lcm_ssv_leg_t){0}) - 8);
    at += read_u32(data + 16) * ((size_t)lcm_ssv_segment_t_encoded_size(&(lcm_ssv_segment_t){0}) - 8);
    at += read_u32(data + 20) * ((size_t)lcm_ssv_event_t_encoded_size(&(lcm_ssv_event_t){0}) - 8);
    at += 2 * ((size_t)lcm_ssv_pose_t_encoded_size(&(lcm_ssv_pose_t){0}) - 8);
    return at == size;
}

static void plan_received(const lcm_recv_buf_t* datagram, const char* channel, void* context) {
    (void)channel;
    wait_t* wait = context;
    const uint8_t* data = datagram->data;
    if (!plan_is_decodable(data, datagram->data_size)) {
        wait->foreign++;
        return;
    }
    if (wait->answered || (int64_t)read_u64(data + 8 + 4 * 4) != wait->request_id) {
        return;
    }
    wait->answered = lcm_ssv_plan_t_decode(data, 0, (int)datagram->data_size, wait->answer) >= 0;
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
            if (lcm_publish(lcm, "SSV_SCENARIO", message, size) != 0) {
                snprintf(error, error_size, "LCM cannot send the scenario");
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

bool ask(const char* url, double timeout_s, const lcm_ssv_scenario_t* question, lcm_ssv_plan_t* answer, char* error,
         size_t error_size) {
    lcm_t* lcm = lcm_create(url);
    if (lcm == NULL) {
        snprintf(error, error_size,
                 "no LCM on %s; for UDP multicast the machine needs a route, e.g. ip route add 224.0.0.0/4 dev lo",
                 url_in_use(url));
        return false;
    }
    wait_t wait = {.request_id = question->request_id, .answer = answer};
    bool sound = lcm_subscribe(lcm, "SSV_PLAN", plan_received, &wait) != NULL;
    const int size = lcm_ssv_scenario_t_encoded_size(question);
    uint8_t* message = malloc((size_t)size);
    sound = sound && message != NULL && lcm_ssv_scenario_t_encode(message, 0, size, question) == size;
    if (!sound) {
        snprintf(error, error_size, "cannot set up LCM on %s", url_in_use(url));
    } else {
        sound = exchange(lcm, message, (unsigned)size, timeout_s, &wait, error, error_size);
    }
    free(message);
    lcm_destroy(lcm);
    if (!sound || wait.answered) {
        return sound;
    }
    char foreign[128] = "";
    if (wait.foreign > 0) {
        snprintf(foreign, sizeof foreign,
                 " (%d messages on SSV_PLAN are of another type: is the planner of another version?)", wait.foreign);
    }
    snprintf(error, error_size, "nobody answered on %s within %g s%s; start ssv-plannerd there, or plan without --lcm",
             url_in_use(url), timeout_s, foreign);
    return false;
}
