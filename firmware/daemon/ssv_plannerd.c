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

#include "channels.h"
#include "lcm_ssv_planner_status_t.h"
#include "log.h"
#include "ssv/answer.h"

#define STATUS_PERIOD_US INT64_C(1000000)
/// Answers kept for repeated request ids.
#define STORE_SIZE 256
/// Questions waiting for their turn. No more than STORE_SIZE, so that the answer to an id that waits here twice is
/// still stored when the second one's turn comes.
#define PENDING_SIZE 256
/// Questions of each kind that liblcm holds for us beyond those; when that is full too it drops the newest.
#define LCM_QUEUE_SIZE 1024
#define ANSWER_BYTES_MAX                                                                                               \
    (SSV_QUOTE_BATCH_BYTES_MAX > SSV_PLAN_BYTES_MAX ? SSV_QUOTE_BATCH_BYTES_MAX : SSV_PLAN_BYTES_MAX)

enum { EXIT_LCM = 4 };

/// Each kind of question has its own ids.
typedef enum { ASK_PLAN, ASK_QUOTES } kind_t;

typedef struct {
    kind_t kind;
    int64_t request_id;
    int size; // bytes in use; 0 = free
    uint8_t bytes[ANSWER_BYTES_MAX];
} stored_t;

/// A scenario waits as a batch of one.
typedef struct {
    kind_t kind;
    lcm_ssv_scenario_batch_t question;
    lcm_ssv_scenario_t scenarios[SSV_MAX_BATCH];
    bool valid; // one of them at least
} pending_t;

/// Everything the daemon knows: some 17 MB, static, so that no message makes it allocate; most of that is never
/// touched.
typedef struct {
    lcm_t* lcm;
    lcm_subscription_t *scenario_subscription, *batch_subscription;
    int signal_fd;
    int64_t started_us, next_status_us;
    int64_t newest_epoch_us; // of the valid questions; 0 accepts any
    int64_t publish_failures;
    int64_t undecodable_reported;    // status.rejected_undecodable when the log last spoke of it
    lcm_ssv_planner_status_t status; // its counters are ours
    pending_t pending[PENDING_SIZE]; // ring
    int pending_first, pending_count;
    stored_t store[STORE_SIZE]; // ring
    int store_next;
    ssv_answer_t answer;
    ssv_batch_answer_t quotes;
    bool quoting;       // the first of those that wait is a batch of which some are priced
    int64_t quoting_us; // spent on it so far
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
        log_line(LOG_WARN, "cannot send %d bytes on %s: %s (%" PRId64 " failures so far)", size, channel,
                 strerror(errno), self->publish_failures);
    }
}

static const stored_t* store_find(const plannerd_t* self, kind_t kind, int64_t request_id) {
    for (int i = 0; i < STORE_SIZE; i++) {
        const stored_t* stored = &self->store[i];
        if (stored->size > 0 && stored->kind == kind && stored->request_id == request_id) {
            return stored;
        }
    }
    return NULL;
}

static bool pending_has(const plannerd_t* self, kind_t kind, int64_t request_id) {
    for (int i = 0; i < self->pending_count; i++) {
        const pending_t* pending = &self->pending[(self->pending_first + i) % PENDING_SIZE];
        if (pending->kind == kind && pending->question.request_id == request_id) {
            return true;
        }
    }
    return false;
}

static bool question_is_valid(const lcm_ssv_scenario_batch_t* question) {
    for (int i = 0; i < question->num_scenarios && question->epoch_us >= 0; i++) {
        ssv_scenario_t scenario;
        ssv_problem_t problem;
        ssv_fault_t fault;
        ssv_scenario_from_wire(&scenario, &question->scenarios[i]);
        if (ssv_problem_init(&problem, &scenario, &fault) == SSV_OK) {
            return true;
        }
    }
    return false;
}

/// Decodes one datagram into the slot. @return false if it is no question of that kind.
static bool decode(const lcm_recv_buf_t* datagram, kind_t kind, pending_t* slot) {
    if (kind == ASK_QUOTES) {
        return ssv_scenario_batch_decode(datagram->data, datagram->data_size, slot->scenarios, &slot->question);
    }
    const int size = (int)datagram->data_size;
    lcm_ssv_scenario_t* scenario = &slot->scenarios[0];
    if (size < 0 || lcm_ssv_scenario_t_decode(datagram->data, 0, size, scenario) != size) {
        return false;
    }
    slot->question = (lcm_ssv_scenario_batch_t){1, scenario->request_id, scenario->epoch_us, slot->scenarios};
    return true;
}

/// Takes one datagram off its channel. There is room: `drain` sees to it.
static void on_question(const lcm_recv_buf_t* datagram, const char* channel, void* user) {
    plannerd_t* self = user;
    const kind_t kind = strcmp(channel, CHANNEL_BATCH) == 0 ? ASK_QUOTES : ASK_PLAN;
    pending_t* slot = &self->pending[(self->pending_first + self->pending_count) % PENDING_SIZE];
    self->status.received++;
    if (!decode(datagram, kind, slot)) {
        self->status.rejected_undecodable++;
        log_line(LOG_DEBUG, "%u bytes on %s are not a %s", datagram->data_size,
                 kind == ASK_QUOTES ? CHANNEL_BATCH : CHANNEL_SCENARIO, kind == ASK_QUOTES ? "batch" : "scenario");
        return;
    }
    slot->kind = kind;
    slot->valid = question_is_valid(&slot->question);
    const int64_t id = slot->question.request_id;
    const bool repeated = store_find(self, kind, id) != NULL || pending_has(self, kind, id);
    if (slot->valid && !repeated && slot->question.epoch_us > self->newest_epoch_us) {
        self->newest_epoch_us = slot->question.epoch_us;
    }
    self->pending_count++;
}

/// Moves what liblcm holds into our ring. Bounded also where nothing stays in the ring: datagrams that are no questions
/// may come faster than they go. @return false when the transport is gone.
static bool drain(plannerd_t* self) {
    int handled = 1;
    for (int i = 0; i < LCM_QUEUE_SIZE && self->pending_count < PENDING_SIZE && handled > 0; i++) {
        handled = lcm_handle_timeout(self->lcm, 0);
    }
    return handled >= 0;
}

static void count_answer(lcm_ssv_planner_status_t* status, kind_t kind, ssv_status_t outcome) {
    switch (outcome) {
        case SSV_OK: kind == ASK_PLAN ? status->accepted++ : status->quoted++; break;
        case SSV_INFEASIBLE: status->infeasible++; break;
        case SSV_NUMERIC_OVERFLOW: status->numeric_overflow++; break;
        case SSV_E_NOT_FINITE: status->rejected_not_finite++; break;
        case SSV_E_RANGE: status->rejected_range++; break;
        case SSV_E_NOT_UNIT: status->rejected_not_unit++; break;
        case SSV_E_SINGULAR: status->rejected_singular++; break;
        case SSV_E_WEIGHTS: status->rejected_weights++; break;
    }
}

static void note_time(int64_t spent_us, int64_t* last_us, int64_t* worst_us) {
    *last_us = spent_us;
    if (spent_us > *worst_us) {
        *worst_us = spent_us;
    }
}

/// Whether the question is older than another one seen, and the words for it.
static bool is_stale(const plannerd_t* self, const pending_t* next, char* reason, size_t size) {
    const int64_t epoch_us = next->question.epoch_us;
    snprintf(reason, size, "epoch_us: %" PRId64 " is older than %" PRId64 ", the newest one seen", epoch_us,
             self->newest_epoch_us);
    return next->valid && epoch_us < self->newest_epoch_us;
}

/// Plans a scenario that was not answered before.
static void plan_new(plannerd_t* self, const pending_t* next) {
    const lcm_ssv_scenario_t* question = &next->scenarios[0];
    const lcm_ssv_plan_t* wire = &self->answer.wire;
    const lcm_ssv_quote_t* quote = &wire->quote;
    char reason[160];
    if (is_stale(self, next, reason, sizeof reason)) {
        ssv_answer_refuse(question, reason, &self->answer);
        self->status.rejected_stale_epoch++;
        log_line(LOG_INFO, "scenario %" PRId64 ": invalid: %s", question->request_id, reason);
        return;
    }
    const int64_t start_us = now_us();
    const ssv_status_t outcome = ssv_answer(question, &self->answer);
    const int64_t plan_us = now_us() - start_us;
    count_answer(&self->status, ASK_PLAN, outcome);
    if (outcome < 0) {
        log_line(LOG_INFO, "scenario %" PRId64 ": invalid: %s", question->request_id, quote->reason);
        return;
    }
    note_time(plan_us, &self->status.last_plan_us, &self->status.worst_plan_us);
    const double plan_ms = (double)plan_us / 1e3;
    if (outcome != SSV_OK) {
        log_line(LOG_INFO, "scenario %" PRId64 ": %s after %.3f ms: %s", question->request_id,
                 outcome == SSV_INFEASIBLE ? "infeasible" : "numeric overflow", plan_ms, quote->reason);
    } else {
        log_line(LOG_INFO,
                 "scenario %" PRId64 ": ok, J %.6g, %.6g s, %.6g N s, %d segments, %d bytes, planned in %.3f ms",
                 question->request_id, quote->cost, quote->time_s, quote->impulse_Ns, wire->num_segments,
                 lcm_ssv_plan_t_encoded_size(wire), plan_ms);
    }
}

static void log_quotes(const plannerd_t* self) {
    const lcm_ssv_quote_batch_t* wire = &self->quotes.wire;
    int num_ok = 0;
    for (int i = 0; i < wire->num_quotes; i++) {
        const lcm_ssv_quote_t* quote = &wire->quotes[i];
        if (quote->status == LCM_SSV_QUOTE_T_STATUS_OK) {
            num_ok++;
            continue;
        }
        log_line(LOG_INFO, "batch %" PRId64 ", scenario %d: %s: %s", wire->request_id, i,
                 quote->status == LCM_SSV_QUOTE_T_STATUS_INVALID      ? "invalid"
                 : quote->status == LCM_SSV_QUOTE_T_STATUS_INFEASIBLE ? "infeasible"
                                                                      : "numeric overflow",
                 quote->reason);
    }
    log_line(LOG_INFO, "batch %" PRId64 ": %d of %d scenarios ok, %d bytes, priced in %.3f ms", wire->request_id,
             num_ok, wire->num_quotes, lcm_ssv_quote_batch_t_encoded_size(wire), (double)self->quoting_us / 1e3);
}

/// Prices the next scenario of a batch that was not answered before. @return whether that was the last one.
static bool quote_new(plannerd_t* self, const pending_t* next) {
    const lcm_ssv_scenario_batch_t* question = &next->question;
    if (!self->quoting) {
        self->quoting_us = 0;
        self->status.batches++;
        char reason[160];
        if (is_stale(self, next, reason, sizeof reason)) {
            ssv_answer_batch_refuse(question, reason, &self->quotes);
            self->status.rejected_stale_epoch += question->num_scenarios;
            log_quotes(self);
            return true;
        }
        ssv_answer_batch_begin(question, &self->quotes);
    }
    const int64_t start_us = now_us();
    const ssv_status_t outcome = ssv_answer_batch_next(question, &self->quotes);
    const int64_t quote_us = now_us() - start_us;
    self->quoting_us += quote_us;
    count_answer(&self->status, ASK_QUOTES, outcome);
    if (outcome >= 0) {
        note_time(quote_us, &self->status.last_quote_us, &self->status.worst_quote_us);
    }
    self->quoting = self->quotes.wire.num_quotes < question->num_scenarios;
    if (self->quoting) {
        return false;
    }
    log_quotes(self);
    return true;
}

/// Encodes the answer to the question into the store, over the oldest one there. @return NULL if it is too long.
static const stored_t* store_answer(plannerd_t* self, const pending_t* question) {
    stored_t* slot = &self->store[self->store_next];
    self->store_next = (self->store_next + 1) % STORE_SIZE;
    slot->kind = question->kind;
    slot->request_id = question->question.request_id;
    slot->size = slot->kind == ASK_PLAN
                     ? lcm_ssv_plan_t_encode(slot->bytes, 0, sizeof slot->bytes, &self->answer.wire)
                     : lcm_ssv_quote_batch_t_encode(slot->bytes, 0, sizeof slot->bytes, &self->quotes.wire);
    if (slot->size < 0) {
        log_line(LOG_ERROR, "the answer to %" PRId64 " is longer than %d bytes", slot->request_id, ANSWER_BYTES_MAX);
        return NULL;
    }
    return slot;
}

/// Answers the question whose turn it is; of a batch it prices one scenario, and the turn remains until all are.
static void answer_next(plannerd_t* self) {
    const pending_t* next = &self->pending[self->pending_first];
    const int64_t id = next->question.request_id;
    const bool is_plan = next->kind == ASK_PLAN;
    const stored_t* answer = self->quoting ? NULL : store_find(self, next->kind, id);
    if (answer != NULL) {
        self->status.repeated++;
        log_line(LOG_INFO, "%s %" PRId64 ": repeated, stored answer sent again", is_plan ? "scenario" : "batch", id);
    } else {
        if (is_plan) {
            plan_new(self, next);
        } else if (!quote_new(self, next)) {
            return;
        }
        answer = store_answer(self, next);
    }
    self->status.last_request_id = id;
    self->pending_first = (self->pending_first + 1) % PENDING_SIZE;
    self->pending_count--;
    if (answer != NULL) {
        publish(self, is_plan ? CHANNEL_PLAN : CHANNEL_QUOTES, answer->bytes, answer->size);
    }
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
                 "%" PRId64 " datagrams on " CHANNEL_SCENARIO " or " CHANNEL_BATCH
                 " were not what belongs there; is their sender of another version?",
                 undecodable);
        self->undecodable_reported = self->status.rejected_undecodable;
    }
    if (lcm_subscription_get_queue_size(self->scenario_subscription) >= LCM_QUEUE_SIZE ||
        lcm_subscription_get_queue_size(self->batch_subscription) >= LCM_QUEUE_SIZE) {
        log_line(LOG_WARN, "more questions arrive than can be answered: some are lost");
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

/// One scenario per turn, and between any two of them new arrivals, the clock and signals get theirs. @return the exit
/// code.
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

static lcm_subscription_t* subscribe(plannerd_t* self, const char* channel) {
    lcm_subscription_t* subscription = lcm_subscribe(self->lcm, channel, on_question, self);
    const bool sound = subscription != NULL && lcm_subscription_set_queue_capacity(subscription, LCM_QUEUE_SIZE) == 0;
    return sound ? subscription : NULL;
}

static bool open_lcm(plannerd_t* self, const char* url) {
    self->lcm = lcm_create(url);
    if (self->lcm == NULL) {
        return false;
    }
    self->scenario_subscription = subscribe(self, CHANNEL_SCENARIO);
    self->batch_subscription = subscribe(self, CHANNEL_BATCH);
    return self->scenario_subscription != NULL && self->batch_subscription != NULL;
}

typedef struct {
    const char* lcm_url; // NULL = LCM's default
    bool verbose;
} options_t;

static const char manual[] =
    "The onboard planner: answers every scenario on LCM channel " CHANNEL_SCENARIO
    " with a plan, or the reason why there "
    "is none, on " CHANNEL_PLAN ", every batch of scenarios on " CHANNEL_BATCH " with their prices on " CHANNEL_QUOTES
    ", and gives a sign of life with counters on " CHANNEL_STATUS
    " once a second."
    "\v"
    "Each request id is answered once; a repeated id gets the same bytes again, as long as its answer is among the "
    "last "
    "256. The newest planning epoch wins: a new question older than the newest valid one seen is refused. Waiting "
    "questions "
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
    {"verbose", 'v', NULL, 0, "log at level DEBUG: also each datagram that is no question", 0},
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

const char* argp_program_version = "ssv-plannerd " SSV_VERSION " (" REAL_NAME ")";

int main(int argc, char** argv) {
    static plannerd_t self;
    static const struct argp parser = {option_table, parse_option, NULL, manual, NULL, NULL, NULL};
    options_t options = {NULL, false};
    argp_parse(&parser, argc, argv, 0, NULL, &options);
    log_set_verbose(options.verbose);

    const char* default_url = getenv("LCM_DEFAULT_URL");
    const char* url = options.lcm_url != NULL ? options.lcm_url
                      : default_url != NULL   ? default_url
                                              : "LCM's default URL";
    if (!open_signals(&self)) {
        log_line(LOG_ERROR, "cannot receive signals: %s", strerror(errno));
        return EXIT_FAILURE;
    }
    if (!open_lcm(&self, options.lcm_url)) {
        log_line(LOG_ERROR,
                 "cannot open LCM at %s. If the machine has no multicast route, add one: "
                 "`sudo ip route add 224.0.0.0/4 dev lo`; or name another provider with --lcm-url",
                 url);
        return EXIT_LCM;
    }
    self.started_us = now_us();
    self.next_status_us = self.started_us;
    static char version[] = SSV_VERSION, scalar[] = REAL_NAME; // as long as the status that names them
    self.status.version = version;
    self.status.scalar = scalar;
    self.status.scenario_type_hash = __lcm_ssv_scenario_t_get_hash();
    self.status.plan_type_hash = __lcm_ssv_plan_t_get_hash();
    self.status.scenario_batch_type_hash = __lcm_ssv_scenario_batch_t_get_hash();
    self.status.quote_batch_type_hash = __lcm_ssv_quote_batch_t_get_hash();
    self.status.planner_status_type_hash = __lcm_ssv_planner_status_t_get_hash();
    log_line(LOG_INFO,
             "ssv-plannerd " SSV_VERSION " (" REAL_NAME ") listens for " CHANNEL_SCENARIO " and " CHANNEL_BATCH
             " at %s",
             url);

    const int code = serve(&self);
    log_line(LOG_INFO,
             "stops: %" PRId64 " received, %" PRId64 " planned, %" PRId64 " quoted, %" PRId64 " infeasible, %" PRId64
             " repeated, worst planning time %.3f ms",
             self.status.received, self.status.accepted, self.status.quoted, self.status.infeasible,
             self.status.repeated, (double)self.status.worst_plan_us / 1e3);
    lcm_destroy(self.lcm);
    close(self.signal_fd);
    return code;
}
