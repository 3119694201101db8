// ssv-plannerd: answers questions that arrive over LCM. What it promises is in its --help, below.
#define _GNU_SOURCE
#include <argp.h>
#include <errno.h>
#include <inttypes.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/signalfd.h>
#include <time.h>
#include <unistd.h>

#include <lcm/lcm.h>

#include "channels.h"
#include "drops.h"
#include "flight.h"
#include "lcm_ssv_planner_status_t.h"
#include "log.h"
#include "questions.h"
#include "ssv/address.h"
#include "ssv/answer.h"
#include "ssv/check.h"

#define STATUS_PERIOD_US INT64_C(1000000)
/// A turn ends after this time, at the end of a slice; the longest slice is some 25 ms more.
#define TURN_US INT64_C(20000)
/// Questions of different askers that may be under way at once.
#define NUM_DESKS 8
/// Datagrams of each kind that liblcm holds for us until we take them; when that is full it drops the newest.
#define LCM_QUEUE_SIZE 1024
#define QUESTION_BYTES_MAX 24576
#define ANSWER_BYTES_MAX                                                                                               \
    (SSV_QUOTE_BATCH_BYTES_MAX > SSV_PLAN_BYTES_MAX ? SSV_QUOTE_BATCH_BYTES_MAX : SSV_PLAN_BYTES_MAX)
/// Memory that grows by this much more is worth a line in the log.
#define GROWTH_BYTES (INT64_C(32) << 20)
/// How long a vehicle is told to stop before the daemon ends all the same; its dead-man does the rest.
#define FAREWELL_US INT64_C(3000000)

enum { EXIT_LCM = 4, EXIT_LINK = 69 };

/// A question that is worked on, with the memory for its answer. A task counts as a batch of one.
typedef struct {
    waiting_t* question; ///< NULL = free
    lcm_ssv_task_t task;
    lcm_ssv_scenario_batch_t batch;
    lcm_ssv_scenario_t scenarios[SSV_MAX_BATCH];
    union {
        ssv_answer_t plan;
        ssv_batch_answer_t quotes;
    } answer;
    int64_t spent_us;    ///< on it so far
    int64_t scenario_us; ///< on the scenario under way
} desk_t;

/// Everything the daemon knows, static, so that no message makes it allocate; most of it is never touched.
typedef struct {
    lcm_t* lcm;
    int signal_fd;
    int64_t started_us, next_status_us;
    int64_t publish_failures;
    int64_t undecodable_reported, crowded_reported, lost_reported; ///< counters when the log last spoke of them
    int64_t resident_reported;
    lcm_ssv_planner_status_t status; ///< its counters are ours
    questions_t questions;
    uint8_t question_bytes[QUESTIONS_MAX * QUESTION_BYTES_MAX];
    uint8_t answer_bytes[ANSWERS_MAX * ANSWER_BYTES_MAX];
    desk_t desk[NUM_DESKS];
    desk_t refusal; ///< where answers are made that need no work
    flight_t flight;
    int64_t flown_epoch_us; ///< of the task that was flown last
    int64_t farewell_us;    ///< when the flight was told to stop since we end; 0 before
    uint8_t message[ANSWER_BYTES_MAX];
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

static void count_answer(lcm_ssv_planner_status_t* status, int64_t* good, ssv_status_t outcome) {
    switch (outcome) {
        case SSV_OK: (*good)++; break;
        case SSV_INFEASIBLE: status->infeasible++; break;
        case SSV_NUMERIC_OVERFLOW: status->numeric_overflow++; break;
        case SSV_E_NOT_FINITE: status->rejected_not_finite++; break;
        case SSV_E_RANGE:
        case SSV_E_IMPOSSIBLE:
        case SSV_E_TOO_FINE: status->rejected_range++; break;
        case SSV_E_NOT_UNIT: status->rejected_not_unit++; break;
        case SSV_E_SINGULAR: status->rejected_singular++; break;
        case SSV_E_WEIGHTS: status->rejected_weights++; break;
    }
}

static void note_time(int64_t spent_us, int64_t* last_us, int64_t* worst_us) {
    *last_us = spent_us;
    if (spent_us > *worst_us) *worst_us = spent_us;
}

static const char* status_word(int8_t status) {
    return status == LCM_SSV_QUOTE_T_STATUS_INVALID      ? "invalid"
           : status == LCM_SSV_QUOTE_T_STATUS_INFEASIBLE ? "infeasible"
           : status == LCM_SSV_QUOTE_T_STATUS_OK         ? "ok"
                                                         : "numeric overflow";
}

// ---- Kinds of questions ---------------------------------------------------------------------------------------------

static bool task_decode(const void* data, int size, desk_t* desk) {
    if (lcm_ssv_task_t_decode(data, 0, size, &desk->task) != size) return false;
    desk->batch.asker = desk->task.scenario.asker;
    desk->batch.num_scenarios = 1;
    return true;
}

static bool batch_decode(const void* data, int size, desk_t* desk) {
    return size >= 0 && ssv_scenario_batch_decode(data, (size_t)size, desk->scenarios, &desk->batch);
}

static void plan_begin(plannerd_t* self, desk_t* desk, uint64_t hash) {
    (void)hash; // that of one task is soon had
    ssv_answer_begin(&desk->task, &self->status.planner, &desk->answer.plan);
}

static void quotes_begin(plannerd_t* self, desk_t* desk, uint64_t hash) {
    self->status.batches++;
    ssv_answer_batch_begin(&desk->batch, hash, &self->status.planner, &desk->answer.quotes);
}

static void plan_refuse(desk_t* desk, const char* reason) { ssv_answer_refuse(reason, &desk->answer.plan); }

static void quotes_refuse(desk_t* desk, const char* reason) {
    ssv_answer_batch_refuse(&desk->batch, reason, &desk->answer.quotes);
}

/// Why this task cannot be flown now, NULL if it can. That it names this planner keeps a recording from being flown
/// again.
static const char* grounding(const plannerd_t* self, const lcm_ssv_asker_t* asker) {
    if (!self->flight.is_open) return "this planner has no vehicle; start it with --link";
    if (asker->planner_id == 0) return "asker.planner_id: a task to be flown must name its planner";
    if (flight_is_under_way(&self->flight)) return "the vehicle flies another task";
    if (asker->epoch_us <= self->flown_epoch_us)
        return "asker.epoch_us: must be newer than that of the task that was flown last";
    return NULL;
}

static void task_begin(plannerd_t* self, desk_t* desk, uint64_t hash) {
    plan_begin(self, desk, hash);
    const char* reason = grounding(self, &desk->task.scenario.asker);
    if (reason != NULL) plan_refuse(desk, reason);
}

/// A task that is planned is flown. One that came in between may have been faster.
static void task_done(plannerd_t* self, desk_t* desk) {
    const lcm_ssv_asker_t* asker = &desk->task.scenario.asker;
    const char* reason = grounding(self, asker);
    if (desk->answer.plan.wire.quote.status != LCM_SSV_QUOTE_T_STATUS_OK) return;
    if (reason == NULL && flight_begin(&self->flight, &desk->answer.plan)) {
        self->flown_epoch_us = asker->epoch_us;
        self->status.flights++;
    } else {
        plan_refuse(desk, reason != NULL ? reason : "the plan makes no timeline that a vehicle takes");
    }
}

static bool plan_step(plannerd_t* self, desk_t* desk) {
    const int64_t start_us = now_us();
    const bool done = ssv_answer_step(&desk->task, &desk->answer.plan);
    desk->spent_us += now_us() - start_us;
    if (!done) return false;
    const ssv_status_t outcome = desk->answer.plan.working.status;
    count_answer(&self->status, &self->status.accepted, outcome);
    if (outcome >= 0) questions_note_epoch(desk->question);
    if (outcome >= 0) note_time(desk->spent_us, &self->status.last_plan_us, &self->status.worst_plan_us);
    return true;
}

static bool quotes_step(plannerd_t* self, desk_t* desk) {
    ssv_batch_answer_t* answer = &desk->answer.quotes;
    const int64_t start_us = now_us();
    const bool done = ssv_answer_batch_step(&desk->batch, answer);
    const int64_t slice_us = now_us() - start_us;
    desk->spent_us += slice_us;
    desk->scenario_us += slice_us;
    if (answer->scenario_done) {
        const ssv_status_t outcome = answer->working.status;
        count_answer(&self->status, &self->status.quoted, outcome);
        if (outcome >= 0) questions_note_epoch(desk->question);
        if (outcome >= 0) note_time(desk->scenario_us, &self->status.last_quote_us, &self->status.worst_quote_us);
        desk->scenario_us = 0;
    }
    return done;
}

static int plan_encode(const desk_t* desk, uint8_t bytes[ANSWER_BYTES_MAX]) {
    return lcm_ssv_plan_t_encode(bytes, 0, ANSWER_BYTES_MAX, &desk->answer.plan.wire);
}

static int quotes_encode(const desk_t* desk, uint8_t bytes[ANSWER_BYTES_MAX]) {
    return lcm_ssv_quote_batch_t_encode(bytes, 0, ANSWER_BYTES_MAX, &desk->answer.quotes.wire);
}

static void plan_log(const desk_t* desk) {
    const lcm_ssv_plan_t* wire = &desk->answer.plan.wire;
    const lcm_ssv_quote_t* quote = &wire->quote;
    const int64_t id = wire->answer.asker.request_id;
    const double spent_ms = (double)desk->spent_us / 1e3;
    if (quote->status != LCM_SSV_QUOTE_T_STATUS_OK) {
        log_line(LOG_INFO, "scenario %016" PRIx64 ": %s after %.3f ms: %s", (uint64_t)id, status_word(quote->status),
                 spent_ms, quote->reason);
        return;
    }
    log_line(LOG_INFO, "scenario %016" PRIx64 ": ok, J %.6g, %.6g s, %.6g N s, %d segments, planned in %.3f ms",
             (uint64_t)id, quote->cost, quote->time_s, quote->impulse_Ns, wire->num_segments, spent_ms);
}

static void quotes_log(const desk_t* desk) {
    const lcm_ssv_quote_batch_t* wire = &desk->answer.quotes.wire;
    const uint64_t id = (uint64_t)wire->answer.asker.request_id;
    int num_ok = 0;
    for (int i = 0; i < wire->num_quotes; i++) {
        const lcm_ssv_quote_t* quote = &wire->quotes[i];
        if (quote->status == LCM_SSV_QUOTE_T_STATUS_OK) {
            num_ok++;
        } else {
            log_line(LOG_INFO, "batch %016" PRIx64 ", scenario %d: %s: %s", id, i, status_word(quote->status),
                     quote->reason);
        }
    }
    log_line(LOG_INFO, "batch %016" PRIx64 ": %d of %d scenarios ok, priced in %.3f ms", id, num_ok, wire->num_quotes,
             (double)desk->spent_us / 1e3);
}

/// What there is to a kind of question.
static const struct {
    const char *channel_in, *channel_out, *what;
    bool (*decode)(const void* data, int size, desk_t* desk); ///< whether it is such a question, through and through
    void (*begin)(plannerd_t* self, desk_t* desk, uint64_t hash);
    bool (*step)(plannerd_t* self, desk_t* desk); ///< whether it is answered
    void (*refuse)(desk_t* desk, const char* reason);
    int (*encode)(const desk_t* desk, uint8_t bytes[ANSWER_BYTES_MAX]);
    void (*log)(const desk_t* desk);
    void (*done)(plannerd_t* self, desk_t* desk); ///< before the answer goes out; may be NULL
} kinds[] = {
    {CHANNEL_SCENARIO, CHANNEL_PLAN, "scenario", task_decode, plan_begin, plan_step, plan_refuse, plan_encode, plan_log,
     NULL},
    {CHANNEL_BATCH, CHANNEL_QUOTES, "batch", batch_decode, quotes_begin, quotes_step, quotes_refuse, quotes_encode,
     quotes_log, NULL},
    {CHANNEL_EXECUTE, CHANNEL_PLAN, "task", task_decode, task_begin, plan_step, plan_refuse, plan_encode, plan_log,
     task_done},
};

#define NUM_KINDS ((int)(sizeof kinds / sizeof kinds[0]))

// ---- What arrives ---------------------------------------------------------------------------------------------------

/// Answers with a refusal that needs no work and is not kept.
static void refuse_at_once(plannerd_t* self, const question_key_t* key, const char* reason) {
    desk_t* desk = &self->refusal;
    desk->spent_us = 0;
    kinds[key->kind].begin(self, desk, key->hash);
    kinds[key->kind].refuse(desk, reason);
    kinds[key->kind].log(desk);
    const int size = kinds[key->kind].encode(desk, self->message);
    if (size > 0) publish(self, kinds[key->kind].channel_out, self->message, size);
}

/// Takes one datagram off its channel: it waits for its turn, or has its answer at once.
static void on_question(const lcm_recv_buf_t* datagram, const char* channel, void* user) {
    plannerd_t* self = user;
    desk_t* desk = &self->refusal;
    int kind = 0;
    while (kind < NUM_KINDS && strcmp(channel, kinds[kind].channel_in) != 0) kind++;
    self->status.received++;
    const bool fits = datagram->data_size <= QUESTION_BYTES_MAX;
    if (kind == NUM_KINDS || !fits || !kinds[kind].decode(datagram->data, (int)datagram->data_size, desk)) {
        self->status.rejected_undecodable++;
        log_line(LOG_DEBUG, "%u bytes on %s are not what belongs there", datagram->data_size, channel);
        return;
    }
    const lcm_ssv_asker_t* asker = &desk->batch.asker;
    if (asker->planner_id != 0 && asker->planner_id != self->status.planner.planner_id) {
        self->status.not_for_us++;
        return;
    }
    const question_key_t key = {.kind = kind,
                                .asker_id = asker->asker_id,
                                .request_id = asker->request_id,
                                .epoch_us = asker->epoch_us,
                                .hash = ssv_question_hash(datagram->data, datagram->data_size)};
    const kept_answer_t* answer = NULL;
    switch (questions_admit(&self->questions, &key, datagram->data, (int)datagram->data_size, &answer)) {
        case ADMIT_NEW:
        case ADMIT_WAITING:
        case ADMIT_CROWDED: break; // an answer to come; another copy of one; counted
        case ADMIT_ANSWERED:
            self->status.repeated++;
            log_line(LOG_INFO, "%s %016" PRIx64 ": asked again, stored answer sent again", kinds[kind].what,
                     (uint64_t)key.request_id);
            publish(self, kinds[kind].channel_out, answer->bytes, answer->size);
            break;
        case ADMIT_REUSED:
            self->status.rejected_reused_id += desk->batch.num_scenarios;
            refuse_at_once(self, &key,
                           "asker.request_id: stands for another question of this asker; take a new one for each");
            break;
    }
}

static void on_control(const lcm_recv_buf_t* datagram, const char* channel, void* user) {
    plannerd_t* self = user;
    lcm_ssv_control_t control;
    const int size = (int)datagram->data_size;
    (void)channel;
    if (size >= 0 && lcm_ssv_control_t_decode(datagram->data, 0, size, &control) == size)
        flight_control(&self->flight, &control);
}

/// Takes what liblcm holds. Bounded: datagrams may come faster than they go. @return false when the transport is gone.
static bool drain(plannerd_t* self) {
    int handled = 1;
    for (int i = 0; i < LCM_QUEUE_SIZE && handled > 0; i++) handled = lcm_handle_timeout(self->lcm, 0);
    return handled >= 0;
}

// ---- Turns ----------------------------------------------------------------------------------------------------------

static desk_t* desk_of(plannerd_t* self, const waiting_t* question) {
    for (int i = 0; i < NUM_DESKS; i++) {
        if (self->desk[i].question == question) return &self->desk[i];
    }
    return NULL;
}

/// Sits down to a question. @return whether it is refused, being older than another one of its asker's.
static bool begin(plannerd_t* self, desk_t* desk, waiting_t* question) {
    const int kind = question->key.kind;
    desk->question = question;
    desk->spent_us = desk->scenario_us = 0;
    question->begun = true;
    (void)kinds[kind].decode(question->bytes, question->size, desk); // it did when it came
    kinds[kind].begin(self, desk, question->key.hash);
    if (question->key.epoch_us < 0 || !questions_is_stale(question)) return false; // what is no epoch is told as such
    char reason[160];
    snprintf(reason, sizeof reason, "asker.epoch_us: %" PRId64 " is older than %" PRId64 ", the newest of this asker",
             question->key.epoch_us, question->asker->newest_epoch_us);
    self->status.rejected_stale_epoch += desk->batch.num_scenarios;
    kinds[kind].refuse(desk, reason);
    return true;
}

static void finish(plannerd_t* self, desk_t* desk) {
    waiting_t* question = desk->question;
    const int kind = question->key.kind;
    if (kinds[kind].done != NULL) kinds[kind].done(self, desk);
    const int size = kinds[kind].encode(desk, self->message);
    kinds[kind].log(desk);
    if (size < 0) log_line(LOG_ERROR, "an answer is longer than %d bytes", ANSWER_BYTES_MAX);
    self->status.last_request_id = question->key.request_id;
    questions_done(&self->questions, question, self->message, size > 0 ? size : 0);
    desk->question = NULL;
    if (size > 0) publish(self, kinds[kind].channel_out, self->message, size);
}

/// Gives the next asker its turn. @return false if nobody waits.
static bool take_turn(plannerd_t* self) {
    desk_t* desk = desk_of(self, NULL);
    waiting_t* question = questions_next(&self->questions, desk == NULL);
    if (question == NULL) return false;
    if (question->begun) desk = desk_of(self, question);
    if (desk == NULL) return false; // not so: what is begun has a desk, and without a free one nothing else comes up
    bool done = !question->begun && begin(self, desk, question);
    const int64_t end_us = now_us() + TURN_US;
    while (!done && now_us() < end_us) done = kinds[question->key.kind].step(self, desk);
    if (done) {
        finish(self, desk);
    } else {
        questions_yield(&self->questions, question);
    }
    return true;
}

// ---- The sign of life -----------------------------------------------------------------------------------------------

/// Memory in use [B], 0 where that cannot be told.
static int64_t resident_bytes(void) {
    long long pages = 0;
    FILE* file = fopen("/proc/self/statm", "r");
    if (file == NULL) return 0;
    const int read = fscanf(file, "%*s %lld", &pages);
    fclose(file);
    return read == 1 ? pages * sysconf(_SC_PAGESIZE) : 0;
}

/// Tells the log what went wrong since it was last told.
static void report_troubles(plannerd_t* self) {
    lcm_ssv_planner_status_t* status = &self->status;
    if (status->rejected_undecodable > self->undecodable_reported) {
        log_line(LOG_WARN,
                 "%" PRId64 " datagrams on " CHANNEL_SCENARIO " or " CHANNEL_BATCH
                 " were not what belongs there; is their sender of another version?",
                 status->rejected_undecodable - self->undecodable_reported);
        self->undecodable_reported = status->rejected_undecodable;
    }
    if (status->crowded_out > self->crowded_reported) {
        log_line(LOG_WARN, "%" PRId64 " questions were given up: some asker asks faster than can be answered",
                 status->crowded_out - self->crowded_reported);
        self->crowded_reported = status->crowded_out;
    }
    if (status->datagrams_lost > self->lost_reported) {
        log_line(LOG_WARN, "%" PRId64 " datagrams were lost in this machine: the receive buffer was full",
                 status->datagrams_lost - self->lost_reported);
        self->lost_reported = status->datagrams_lost;
    }
    if (self->resident_reported == 0) self->resident_reported = status->resident_bytes;
    if (status->resident_bytes > self->resident_reported + GROWTH_BYTES) {
        log_line(LOG_WARN,
                 "memory has grown to %" PRId64 " MB: are there ever new channel names on the bus? liblcm keeps each",
                 status->resident_bytes >> 20);
        self->resident_reported = status->resident_bytes;
    }
}

/// The sign of life, when it is due.
static void report(plannerd_t* self) {
    const int64_t now = now_us();
    if (now < self->next_status_us) return;
    // From the due time, not from now, so that the rate does not drift; after a long stop, afresh.
    self->next_status_us += STATUS_PERIOD_US;
    if (self->next_status_us <= now) self->next_status_us = now + STATUS_PERIOD_US;
    lcm_ssv_planner_status_t* status = &self->status;
    status->uptime_us = now - self->started_us;
    status->crowded_out = self->questions.num_crowded;
    status->waiting = self->questions.num_waiting;
    status->link = !self->flight.is_open         ? LCM_SSV_PLANNER_STATUS_T_LINK_NONE
                   : flight_hears(&self->flight) ? LCM_SSV_PLANNER_STATUS_T_LINK_HEARD
                                                 : LCM_SSV_PLANNER_STATUS_T_LINK_SILENT;
    status->flying_request_id = flight_is_under_way(&self->flight) ? self->flight.answer.asker.request_id : 0;
    status->datagrams_lost = drops_count();
    status->log_lines_lost = log_lines_lost();
    status->resident_bytes = resident_bytes();
    const int size = lcm_ssv_planner_status_t_encode(self->status_bytes, 0, sizeof self->status_bytes, status);
    publish(self, CHANNEL_STATUS, self->status_bytes, size);
    report_troubles(self);
}

static bool asked_to_stop(const plannerd_t* self) {
    struct pollfd fd = {.fd = self->signal_fd, .events = POLLIN, .revents = 0};
    return poll(&fd, 1, 0) > 0;
}

static void wait_for_work(const plannerd_t* self) {
    const bool is_ending = self->farewell_us > 0; // then the signal is known
    struct pollfd fds[] = {{.fd = lcm_get_fileno(self->lcm), .events = POLLIN, .revents = 0},
                           {.fd = is_ending ? -1 : self->signal_fd, .events = POLLIN, .revents = 0},
                           {.fd = self->flight.is_open ? self->flight.port.fd : -1, .events = POLLIN, .revents = 0}};
    int64_t wait_us = self->next_status_us - now_us();
    const int64_t flight_us = flight_wait_us(&self->flight);
    if (flight_us < wait_us) wait_us = flight_us;
    struct timespec wait = {0, 0};
    if (wait_us > 0) wait = (struct timespec){wait_us / 1000000, 1000 * (wait_us % 1000000)};
    ppoll(fds, 3, &wait, NULL);
}

/// Whether the daemon may end: at once without a flight, else when the vehicle has been told to stop.
static bool may_end(plannerd_t* self) {
    if (!flight_is_under_way(&self->flight)) return true;
    if (self->farewell_us == 0) {
        self->farewell_us = now_us();
        flight_stop(&self->flight);
    }
    return now_us() - self->farewell_us > FAREWELL_US;
}

/// Turn after turn, and between any two of them new arrivals, the clock and signals get theirs. @return the exit code.
static int serve(plannerd_t* self) {
    while (!asked_to_stop(self) || !may_end(self)) {
        if (!drain(self)) {
            log_line(LOG_ERROR, "the LCM connection is lost");
            return EXIT_LCM;
        }
        report(self);
        flight_turn(&self->flight);
        if (!take_turn(self)) wait_for_work(self);
    }
    return EXIT_SUCCESS;
}

// ---- Start ----------------------------------------------------------------------------------------------------------

/// Signals arrive through a descriptor. Call it before LCM starts its threads, so that they inherit the mask.
/// @return false on failure.
static bool open_signals(plannerd_t* self) {
    sigset_t stop;
    sigemptyset(&stop);
    sigaddset(&stop, SIGHUP);
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
    if (self->lcm == NULL) return false;
    for (int kind = 0; kind < NUM_KINDS; kind++) {
        lcm_subscription_t* subscription = lcm_subscribe(self->lcm, kinds[kind].channel_in, on_question, self);
        if (subscription == NULL || lcm_subscription_set_queue_capacity(subscription, LCM_QUEUE_SIZE) != 0) {
            return false;
        }
    }
    lcm_subscription_t* subscription = lcm_subscribe(self->lcm, CHANNEL_CONTROL, on_control, self);
    return subscription != NULL && lcm_subscription_set_queue_capacity(subscription, LCM_QUEUE_SIZE) == 0;
}

/// Another number for each run, never 0. @return false where the system gives none.
static bool draw_id(int64_t* id) {
    do {
        if (getrandom(id, sizeof *id, 0) != (ssize_t)sizeof *id) return false;
    } while (*id == 0);
    return true;
}

typedef struct {
    const char* lcm_url; // NULL = LCM's default
    bool verbose;
    flight_options_t flight;
} options_t;

static const char manual[] =
    "The onboard planner: answers every task on LCM channel " CHANNEL_SCENARIO
    " with a plan, or the reason why there "
    "is none, on " CHANNEL_PLAN ", every batch of scenarios on " CHANNEL_BATCH " with their prices on " CHANNEL_QUOTES
    ", and gives a sign of life with counters on " CHANNEL_STATUS
    " once a second. With --link it also flies tasks: one on " CHANNEL_EXECUTE
    " that names this planner is planned, answered and flown; " CHANNEL_EXECUTION " and " CHANNEL_STATE
    " tell how that gets on, and " CHANNEL_CONTROL
    " stops it."
    "\v"
    "Askers take turns, and no one of them can hold up another; a question asked again gets the same bytes again, as "
    "long as its answer is among the last 256. Of one asker's questions the newest epoch wins. The log goes to "
    "standard "
    "error, one line per answer, at most 200 a second; it never waits for its reader.\n\n"
    "LCM's own default URL is udpm://239.255.76.67:7667?ttl=0, this machine only; it needs a multicast route, e.g. "
    "`sudo ip route add 224.0.0.0/4 dev lo`.\n\n"
    "Examples:\n"
    "  ssv-plannerd\n"
    "  ssv-plannerd --verbose 2> planner.log\n"
    "  ssv-plannerd --link serial:/dev/ttyUSB0:57600\n"
    "  ssv-plannerd --link udp:127.0.0.1:14550\n"
    "  ssv-plannerd --lcm-url 'udpm://239.255.76.67:7667?ttl=1'\n\n"
    "Exit codes:\n"
    "  0   stopped by SIGINT, SIGTERM or SIGHUP\n"
    "  1   the system refused something else\n"
    "  4   LCM cannot be opened, or was lost\n"
    "  64  wrong usage\n"
    "  69  the link to the vehicle, or its key, cannot be opened\n";

static const struct argp_option option_table[] = {
    {"lcm-url", 'l', "URL", 0, "LCM provider; default: the environment's LCM_DEFAULT_URL, else LCM's own", 0},
    {"link", 'L', "WHERE", 0,
     "fly tasks with the vehicle at WHERE: udp:ADDRESS:PORT, udp-listen:PORT or serial:DEVICE:BAUD", 0},
    {"key", 'K', "FILE", 0, "sign the link, and hear only what is signed with the key in FILE (64 hex digits)", 0},
    {"thruster-lag", 't', "S", 0, "time constant of the thrusters that guidance reckons with, in seconds (default 0)",
     0},
    {"lockstep", 'k', "PORT", 0, "the vehicle is an ssv-sim that waits for leave at this UDP port of this machine", 0},
    {"rate", 'r', "R", 0, "in lockstep, simulated seconds per second (default: as fast as it goes)", 0},
    {"verbose", 'v', NULL, 0, "log at level DEBUG: also each datagram that is no question", 0},
    {NULL, 0, NULL, 0, NULL, 0}};

static double number(struct argp_state* state, const char* name, const char* text, double least, double most) {
    char* end;
    const double value = strtod(text, &end);
    if (end == text || *end != '\0' || !(value >= least && value <= most))
        argp_error(state, "%s takes a number from %g to %g", name, least, most);
    return value;
}

static error_t parse_option(int key, char* argument, struct argp_state* state) {
    options_t* options = state->input;
    switch (key) {
        case 'l': options->lcm_url = argument; return 0;
        case 'v': options->verbose = true; return 0;
        case 'L': options->flight.link = argument; return 0;
        case 'k': options->flight.lockstep = argument; return 0;
        case 'K': options->flight.key = argument; return 0;
        case 'r': options->flight.rate = number(state, "--rate", argument, 1e-3, 1e6); return 0;
        case 't': options->flight.thruster_lag_s = number(state, "--thruster-lag", argument, 0, 10); return 0;
        case ARGP_KEY_END:
            if (options->flight.link == NULL &&
                (options->flight.lockstep != NULL || options->flight.rate > 0 || options->flight.key != NULL))
                argp_error(state, "--lockstep, --rate and --key need --link");
            if (options->flight.lockstep == NULL && options->flight.rate > 0)
                argp_error(state, "--rate needs --lockstep: a real vehicle has a clock of its own");
            return 0;
        case ARGP_KEY_ARG: argp_error(state, "unexpected argument '%s'", argument); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

const char* argp_program_version = "ssv-plannerd " SSV_VERSION " (" REAL_NAME ")";

int main(int argc, char** argv) {
    static plannerd_t self;
    static const struct argp parser = {option_table, parse_option, NULL, manual, NULL, NULL, NULL};
    options_t options = {NULL, false, {NULL, NULL, NULL, 0, 0}};
    char error[400];
    argp_parse(&parser, argc, argv, 0, NULL, &options);
    log_set_verbose(options.verbose);

    const char* default_url = getenv("LCM_DEFAULT_URL");
    const char* url = options.lcm_url != NULL ? options.lcm_url
                      : default_url != NULL   ? default_url
                                              : "udpm://239.255.76.67:7667?ttl=0";
    if (!open_signals(&self)) {
        log_line(LOG_ERROR, "cannot receive signals: %s", strerror(errno));
        return EXIT_FAILURE;
    }
    if (!open_lcm(&self, options.lcm_url)) {
        char advice[SSV_ADVICE_SIZE];
        ssv_address_advice(url, advice);
        log_line(LOG_ERROR, "cannot open LCM at %s: %s", url, advice);
        return EXIT_LCM;
    }
    if (!draw_id(&self.status.planner.planner_id)) {
        log_line(LOG_ERROR, "the system gives no random number for the planner's id: %s", strerror(errno));
        return EXIT_FAILURE;
    }
    if (options.flight.link != NULL &&
        !flight_open(&self.flight, self.lcm, &options.flight, (uint32_t)self.status.planner.planner_id | 1, error,
                     sizeof error)) {
        log_line(LOG_ERROR, "%s", error);
        return EXIT_LINK;
    }
    self.status.planner = ssv_planner_identity(self.status.planner.planner_id);
    questions_init(&self.questions, self.question_bytes, QUESTION_BYTES_MAX, self.answer_bytes, ANSWER_BYTES_MAX);
    self.started_us = now_us();
    self.next_status_us = self.started_us;
    self.status.task_type_hash = __lcm_ssv_task_t_get_hash();
    self.status.plan_type_hash = __lcm_ssv_plan_t_get_hash();
    self.status.scenario_batch_type_hash = __lcm_ssv_scenario_batch_t_get_hash();
    self.status.quote_batch_type_hash = __lcm_ssv_quote_batch_t_get_hash();
    self.status.planner_status_type_hash = __lcm_ssv_planner_status_t_get_hash();
    log_line(LOG_INFO,
             "ssv-plannerd " SSV_VERSION " (" REAL_NAME "), planner %016" PRIx64 ", listens for " CHANNEL_SCENARIO
             " and " CHANNEL_BATCH " at %s",
             (uint64_t)self.status.planner.planner_id, url);

    if (self.flight.is_open && self.flight.port.listens)
        log_line(LOG_INFO, "listens for the vehicle on UDP port %d", port_number(&self.flight.port));
    const int code = serve(&self);
    flight_close(&self.flight);
    log_line(LOG_INFO,
             "stops: %" PRId64 " received, %" PRId64 " planned, %" PRId64 " quoted, %" PRId64 " infeasible, %" PRId64
             " repeated, worst planning time %.3f ms",
             self.status.received, self.status.accepted, self.status.quoted, self.status.infeasible,
             self.status.repeated, (double)self.status.worst_plan_us / 1e3);
    lcm_destroy(self.lcm);
    close(self.signal_fd);
    return code;
}
