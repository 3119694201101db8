// ssv-plannerd: answers scenarios that arrive over LCM. What it promises is in its --help, below.
#define _GNU_SOURCE
#include <argp.h>
#include <errno.h>
#include <inttypes.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/signalfd.h>
#include <time.h>
#include <unistd.h>

#include <lcm/lcm.h>

#include "lcm_ssv_planner_status_t.h"
#include "log.h"
#include "ssv/answer.h"

#define CHANNEL_SCENARIO "SSV_SCENARIO"
#define CHANNEL_PLAN "SSV_PLAN"
#define CHANNEL_STATUS "SSV_PLANNER_STATUS"

#define STATUS_PERIOD_US INT64_C(1000000)
/// Answers kept for repeated request ids.
#define STORE_SIZE 256
/// Scenarios waiting for their turn. No more than STORE_SIZE, so that the answer to an id that waits here twice is still
/// stored when the second one's turn comes.
#define PENDING_SIZE 256
/// Scenarios that liblcm holds for us beyond those; when that is full too it drops the newest.
#define LCM_QUEUE_SIZE 1024
/// The longest answer, by the sizes of the wire types; a candidate's reason is one of the core's sentences.
#define CANDIDATE_REASON_MAX 128
#define ANSWER_BYTES_MAX                                                                                                 \
    (227 + SSV_REASON_SIZE + 147 * SSV_MAX_LEGS + 113 * SSV_MAX_SEGMENTS + 9 * SSV_MAX_EVENTS +                          \
     (46 + CANDIDATE_REASON_MAX) * SSV_MAX_CANDIDATES)

enum { EXIT_LCM = 4 };

typedef struct {
    int64_t request_id;
    int size; // bytes in use; 0 = free
    uint8_t bytes[ANSWER_BYTES_MAX];
} stored_t;

typedef struct {
    lcm_ssv_scenario_t question;
    bool valid;
} pending_t;

/// Everything the daemon knows: some 6 MB, static, so that no message makes it allocate.
typedef struct {
    lcm_t* lcm;
    lcm_subscription_t* subscription;
    int signal_fd;
    int64_t started_us, next_status_us;
    int64_t newest_epoch_us;          // of the valid scenarios; 0 accepts any
    int64_t publish_failures;
    int64_t undecodable_reported;     // status.rejected_undecodable when the log last spoke of it
    lcm_ssv_planner_status_t status;  // its counters are ours
    pending_t pending[PENDING_SIZE];  // ring
    int pending_first, pending_count;
    stored_t store[STORE_SIZE];       // ring
    int store_next;
    ssv_answer_t answer;
    uint8_t status_bytes[512];
} plannerd_t;

static int64_t now_us(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000 + t.tv_nsec / 1000;
}

static void publish(plannerd_t* self, const char* channel, const uint8_t* bytes, int size) {
    if (lcm_publish(self->lcm, channel, bytes, (unsigned)size) != 0) {
        self->publish_failures++;
        log_line(LOG_WARN, "cannot send %d bytes on %s: %s (%" PRId64 " failures so far)", size, channel, strerror(errno),
                 self->publish_failures);
    }
}

static const stored_t* store_find(const plannerd_t* self, int64_t request_id) {
    for (int i = 0; i < STORE_SIZE; i++) {
        if (self->store[i].size > 0 && self->store[i].request_id == request_id) {
            return &self->store[i];
        }
    }
    return NULL;
}

static bool pending_has(const plannerd_t* self, int64_t request_id) {
    for (int i = 0; i < self->pending_count; i++) {
        if (self->pending[(self->pending_first + i) % PENDING_SIZE].question.request_id == request_id) {
            return true;
        }
    }
    return false;
}

static bool question_is_valid(const lcm_ssv_scenario_t* question) {
    ssv_scenario_t scenario;
    ssv_problem_t problem;
    ssv_fault_t fault;
    ssv_scenario_from_wire(&scenario, question);
    return question->epoch_us >= 0 && ssv_problem_init(&problem, &scenario, &fault) == SSV_OK;
}

/// Takes one datagram off SSV_SCENARIO. There is room: `drain` sees to it.
static void on_scenario(const lcm_recv_buf_t* datagram, const char* channel, void* user) {
    (void)channel;
    plannerd_t* self = user;
    pending_t* slot = &self->pending[(self->pending_first + self->pending_count) % PENDING_SIZE];
    self->status.received++;
    const int size = (int)datagram->data_size;
    if (size < 0 || lcm_ssv_scenario_t_decode(datagram->data, 0, size, &slot->question) != size) {
        self->status.rejected_undecodable++;
        log_line(LOG_DEBUG, "%d bytes on " CHANNEL_SCENARIO " are not a scenario", size);
        return;
    }
    slot->valid = question_is_valid(&slot->question);
    const int64_t id = slot->question.request_id;
    const bool repeated = store_find(self, id) != NULL || pending_has(self, id);
    if (slot->valid && !repeated && slot->question.epoch_us > self->newest_epoch_us) {
        self->newest_epoch_us = slot->question.epoch_us;
    }
    self->pending_count++;
}

/// Moves what liblcm holds into our ring. Bounded also where nothing stays in the ring: datagrams that are not scenarios may
/// come faster than they go. @return false when the transport is gone.
static bool drain(plannerd_t* self) {
    int handled = 1;
    for (int i = 0; i < LCM_QUEUE_SIZE && self->pending_count < PENDING_SIZE && handled > 0; i++) {
        handled = lcm_handle_timeout(self->lcm, 0);
    }
    return handled >= 0;
}

static void count_answer(lcm_ssv_planner_status_t* status, ssv_status_t outcome) {
    switch (outcome) {
        case SSV_OK: status->accepted++; break;
        case SSV_INFEASIBLE: status->infeasible++; break;
        case SSV_E_NOT_FINITE: status->rejected_not_finite++; break;
        case SSV_E_RANGE: status->rejected_range++; break;
        case SSV_E_NOT_UNIT: status->rejected_not_unit++; break;
        case SSV_E_SINGULAR: status->rejected_singular++; break;
        case SSV_E_WEIGHTS: status->rejected_weights++; break;
    }
}

/// Fills in the answer to a question that was not answered before.
static void answer_new(plannerd_t* self, const pending_t* next) {
    const lcm_ssv_scenario_t* question = &next->question;
    const lcm_ssv_plan_t* wire = &self->answer.wire;
    if (next->valid && question->epoch_us < self->newest_epoch_us) {
        char reason[160];
        snprintf(reason, sizeof reason, "epoch_us: %" PRId64 " is older than %" PRId64 ", the newest one seen",
                 question->epoch_us, self->newest_epoch_us);
        ssv_answer_refuse(question, reason, &self->answer);
        self->status.rejected_stale_epoch++;
        log_line(LOG_INFO, "scenario %" PRId64 ": invalid: %s", question->request_id, reason);
        return;
    }
    const int64_t start_us = now_us();
    const ssv_status_t outcome = ssv_answer(question, &self->answer);
    const int64_t plan_us = now_us() - start_us;
    count_answer(&self->status, outcome);
    if (outcome < 0) {
        log_line(LOG_INFO, "scenario %" PRId64 ": invalid: %s", question->request_id, wire->reason);
        return;
    }
    self->status.last_plan_us = plan_us;
    if (plan_us > self->status.worst_plan_us) {
        self->status.worst_plan_us = plan_us;
    }
    const double plan_ms = (double)plan_us / 1e3;
    if (outcome == SSV_INFEASIBLE) {
        log_line(LOG_INFO, "scenario %" PRId64 ": infeasible after %.3f ms: %s", question->request_id, plan_ms,
                 wire->reason);
    } else {
        log_line(LOG_INFO, "scenario %" PRId64 ": ok, J %.6g, %.6g s, %.6g N s, %d segments, %d bytes, planned in %.3f ms",
                 question->request_id, wire->cost, wire->time_s, wire->impulse_Ns, wire->num_segments,
                 lcm_ssv_plan_t_encoded_size(wire), plan_ms);
    }
}

/// Answers the scenario whose turn it is.
static void answer_next(plannerd_t* self) {
    const pending_t* next = &self->pending[self->pending_first];
    const int64_t id = next->question.request_id;
    self->pending_first = (self->pending_first + 1) % PENDING_SIZE;
    self->pending_count--;
    self->status.last_request_id = id;

    const stored_t* stored = store_find(self, id);
    if (stored != NULL) {
        self->status.repeated++;
        log_line(LOG_INFO, "scenario %" PRId64 ": repeated, stored answer sent again", id);
        publish(self, CHANNEL_PLAN, stored->bytes, stored->size);
        return;
    }
    answer_new(self, next);
    stored_t* slot = &self->store[self->store_next];
    self->store_next = (self->store_next + 1) % STORE_SIZE;
    slot->request_id = id;
    slot->size = lcm_ssv_plan_t_encode(slot->bytes, 0, sizeof slot->bytes, &self->answer.wire);
    if (slot->size < 0) {
        log_line(LOG_ERROR, "the answer to scenario %" PRId64 " is longer than %d bytes", id, ANSWER_BYTES_MAX);
        return;
    }
    publish(self, CHANNEL_PLAN, slot->bytes, slot->size);
}

/// The sign of life, when it is due, and what went wrong since the last one.
static void report(plannerd_t* self) {
    const int64_t now = now_us();
    if (now < self->next_status_us) {
        return;
    }
    // From the due time, not from now, so that the rate does not drift; after a long stop, afresh.
    self->next_status_us += STATUS_PERIOD_US;
    if (self->next_status_us <= now) {
        self->next_status_us = now + STATUS_PERIOD_US;
    }
    self->status.uptime_us = now - self->started_us;
    const int size = lcm_ssv_planner_status_t_encode(self->status_bytes, 0, sizeof self->status_bytes, &self->status);
    publish(self, CHANNEL_STATUS, self->status_bytes, size);

    const int64_t undecodable = self->status.rejected_undecodable - self->undecodable_reported;
    if (undecodable > 0) {
        log_line(LOG_WARN,
                 "%" PRId64 " datagrams on " CHANNEL_SCENARIO " were not scenarios; is their sender of another version?",
                 undecodable);
        self->undecodable_reported = self->status.rejected_undecodable;
    }
    if (lcm_subscription_get_queue_size(self->subscription) >= LCM_QUEUE_SIZE) {
        log_line(LOG_WARN, "more scenarios arrive than can be answered: some are lost");
    }
}

static bool asked_to_stop(const plannerd_t* self) {
    struct pollfd fd = {.fd = self->signal_fd, .events = POLLIN, .revents = 0};
    return poll(&fd, 1, 0) > 0;
}

static void wait_for_work(const plannerd_t* self) {
    struct pollfd fds[] = {{.fd = lcm_get_fileno(self->lcm), .events = POLLIN, .revents = 0},
                           {.fd = self->signal_fd, .events = POLLIN, .revents = 0}};
    const int64_t wait_us = self->next_status_us - now_us();
    poll(fds, 2, wait_us > 0 ? (int)(wait_us / 1000) + 1 : 0);
}

/// One answer per turn, and between any two of them new arrivals, the clock and signals get theirs. @return the exit code.
static int serve(plannerd_t* self) {
    while (!asked_to_stop(self)) {
        if (!drain(self)) {
            log_line(LOG_ERROR, "the LCM connection is lost");
            return EXIT_LCM;
        }
        report(self);
        if (self->pending_count > 0) {
            answer_next(self);
        } else {
            wait_for_work(self);
        }
    }
    return EXIT_SUCCESS;
}

/// Signals arrive through a descriptor. Call it before LCM starts its threads, so that they inherit the mask.
/// @return false on failure.
static bool open_signals(plannerd_t* self) {
    sigset_t stop;
    sigemptyset(&stop);
    sigaddset(&stop, SIGINT);
    sigaddset(&stop, SIGTERM);
    // A reader of our log that goes away must not take the planner along.
    signal(SIGPIPE, SIG_IGN);
    sigprocmask(SIG_BLOCK, &stop, NULL);
    self->signal_fd = signalfd(-1, &stop, SFD_CLOEXEC);
    return self->signal_fd >= 0;
}

static bool open_lcm(plannerd_t* self, const char* url) {
    self->lcm = lcm_create(url);
    if (self->lcm == NULL) {
        return false;
    }
    self->subscription = lcm_subscribe(self->lcm, CHANNEL_SCENARIO, on_scenario, self);
    return self->subscription != NULL && lcm_subscription_set_queue_capacity(self->subscription, LCM_QUEUE_SIZE) == 0;
}

typedef struct {
    const char* lcm_url; // NULL = LCM's default
    bool verbose;
} options_t;

static const char manual[] =
    "The onboard planner: answers every scenario on LCM channel " CHANNEL_SCENARIO " with a plan, or the reason why there "
    "is none, on " CHANNEL_PLAN ", and gives a sign of life with counters on " CHANNEL_STATUS " once a second."
    "\v"
    "Each request id is answered once; a repeated id gets the same bytes again, as long as its answer is among the last "
    "256. The newest planning epoch wins: a new scenario older than the newest valid one seen is refused. Waiting scenarios "
    "are answered in the order of arrival. The log goes to standard error, one line per answer.\n\n"
    "LCM's own default URL is udpm://239.255.76.67:7667?ttl=0, this machine only; it needs a multicast route, e.g. "
    "`sudo ip route add 224.0.0.0/4 dev lo`.\n\n"
    "Examples:\n"
    "  ssv-plannerd\n"
    "  ssv-plannerd --verbose 2> planner.log\n"
    "  ssv-plannerd --lcm-url 'udpm://239.255.76.67:7667?ttl=1'\n\n"
    "Exit codes:\n"
    "  0   stopped by SIGINT or SIGTERM\n"
    "  1   the system refused something else\n"
    "  4   LCM cannot be opened, or was lost\n"
    "  64  wrong usage\n";

static const struct argp_option option_table[] = {
    {"lcm-url", 'l', "URL", 0, "LCM provider; default: the environment's LCM_DEFAULT_URL, else LCM's own", 0},
    {"verbose", 'v', NULL, 0, "log at level DEBUG: also each datagram that is not a scenario", 0},
    {NULL, 0, NULL, 0, NULL, 0}};

static error_t parse_option(int key, char* argument, struct argp_state* state) {
    options_t* options = state->input;
    switch (key) {
        case 'l': options->lcm_url = argument; return 0;
        case 'v': options->verbose = true; return 0;
        case ARGP_KEY_ARG: argp_error(state, "unexpected argument '%s'", argument); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

const char* argp_program_version = "ssv-plannerd " SSV_VERSION;

int main(int argc, char** argv) {
    static plannerd_t self;
    static const struct argp parser = {option_table, parse_option, NULL, manual, NULL, NULL, NULL};
    options_t options = {NULL, false};
    argp_parse(&parser, argc, argv, 0, NULL, &options);
    log_set_verbose(options.verbose);

    const char* default_url = getenv("LCM_DEFAULT_URL");
    const char* url = options.lcm_url != NULL ? options.lcm_url : default_url != NULL ? default_url : "LCM's default URL";
    if (!open_signals(&self)) {
        log_line(LOG_ERROR, "cannot receive signals: %s", strerror(errno));
        return EXIT_FAILURE;
    }
    if (!open_lcm(&self, options.lcm_url)) {
        log_line(LOG_ERROR,
                 "cannot open LCM at %s. If the machine has no multicast route, add one: "
                 "`sudo ip route add 224.0.0.0/4 dev lo`; or name another provider with --lcm-url", url);
        return EXIT_LCM;
    }
    self.started_us = now_us();
    self.next_status_us = self.started_us;
    self.status.version = (char[]){SSV_VERSION};
    self.status.scenario_type_hash = __lcm_ssv_scenario_t_get_hash();
    self.status.plan_type_hash = __lcm_ssv_plan_t_get_hash();
    self.status.planner_status_type_hash = __lcm_ssv_planner_status_t_get_hash();
    log_line(LOG_INFO, "ssv-plannerd " SSV_VERSION " listens for " CHANNEL_SCENARIO " at %s", url);

    const int code = serve(&self);
    log_line(LOG_INFO, "stops: %" PRId64 " received, %" PRId64 " planned, %" PRId64 " repeated, worst planning time %.3f ms",
             self.status.received, self.status.accepted + self.status.infeasible, self.status.repeated,
             (double)self.status.worst_plan_us / 1e3);
    lcm_destroy(self.lcm);
    close(self.signal_fd);
    return code;
}
