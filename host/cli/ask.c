#define _DEFAULT_SOURCE
#include "ask.h"

#include <assert.h>
#include <inttypes.h>
#include <lcm/lcm.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <time.h>

#include "channels.h"
#include "lcm_ssv_planner_status_t.h"
#include "ssv/answer.h"
#include "ssv/check.h"
#include "wire/message.h"
#include "wire/names.h"

#define RESEND_PERIOD_S 0.5
/// No datagram is larger. liblcm gives the start of one, cut within its channel's name, a negative size.
#define DATAGRAM_SIZE_MAX 65535
/// Messages that wait while we look at one; liblcm's own 30 are soon filled by a stranger.
#define QUEUE_CAPACITY 256
#define PLANNERS_MAX 64
/// Status comes once a second: how long to listen for the first one, and after which silence a planner is gone.
#define LISTEN_S 1.2
#define SILENCE_S 3.0
/// How long a planner may keep its first batch without an answer. Doubled each time that a batch changes hands, so that
/// one that takes long is answered in the end.
#define PATIENCE_S 3.0
#define REFUSALS_SHOWN 3

/// A planner that was heard.
typedef struct {
    int64_t planner_id; ///< 0 = whoever hears it, where none was heard
    int8_t scalar;
    double heard_s;
    int failures; ///< batches that it lost
    int batch;    ///< number of the one that it has, -1 = none
} heard_t;

/// One connection, and what came over it.
typedef struct {
    const ask_target_t* target;
    lcm_t* lcm;
    const char* answer_channel;
    heard_t heard[PLANNERS_MAX];
    int num_heard;
    int foreign; ///< messages on the channel that are none of our version
    int refused; ///< answers to us that were not right
} line_t;

static double now_s(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static bool draw_id(int64_t* id) {
    *id = 0;
    while (*id == 0) {
        if (getrandom(id, sizeof *id, 0) != (ssize_t)sizeof *id) return false;
    }
    return true;
}

bool ask_stamp(lcm_ssv_asker_t* asker, char* error, size_t error_size) {
    static int64_t asker_id;
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    *asker = (lcm_ssv_asker_t){.epoch_us = (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000};
    if ((asker_id == 0 && !draw_id(&asker_id)) || !draw_id(&asker->request_id)) {
        snprintf(error, error_size, "the system gives no random numbers, which the question's ids are made of");
        return false;
    }
    asker->asker_id = asker_id;
    return true;
}

static const char* url_in_use(const char* url) {
    const char* const from_environment = getenv("LCM_DEFAULT_URL");
    return url != NULL ? url : from_environment != NULL ? from_environment : "udpm://239.255.76.67:7667?ttl=0";
}

static bool is_wanted(const line_t* line, int8_t scalar) {
    return line->target->scalar == NULL || strcmp(name_of(&names_scalar, scalar), line->target->scalar) == 0;
}

/// An answer that is not used. The first few are told; what it holds may steer a terminal.
static void refuse(line_t* line, char* reason) {
    tree_make_harmless(reason);
    if (line->refused++ < REFUSALS_SHOWN) {
        fprintf(stderr, "ssv: refused an answer on %s, still waiting for a right one: %s\n", line->answer_channel,
                reason);
    }
}

/// What a check leaves open: the scalar that was asked for.
static bool check_scalar(const line_t* line, const lcm_ssv_answer_t* answer, char reason[SSV_CHECK_REASON_SIZE]) {
    if (is_wanted(line, answer->planner.scalar)) return true;
    snprintf(reason, SSV_CHECK_REASON_SIZE, "planner.scalar: %s, but %s was asked for",
             name_of(&names_scalar, answer->planner.scalar), line->target->scalar);
    return false;
}

// The generated decoders may read only what wire_is_message vouches for.
static bool is_message(const char* type, const lcm_recv_buf_t* datagram) {
    return datagram->data_size <= DATAGRAM_SIZE_MAX && wire_is_message(type, datagram->data, datagram->data_size);
}

static void status_received(const lcm_recv_buf_t* datagram, const char* channel, void* context) {
    (void)channel;
    line_t* line = context;
    lcm_ssv_planner_status_t status;
    if (!is_message("planner_status_t", datagram) ||
        lcm_ssv_planner_status_t_decode(datagram->data, 0, (int)datagram->data_size, &status) < 0) {
        return;
    }
    int i = 0;
    while (i < line->num_heard && line->heard[i].planner_id != status.planner.planner_id) i++;
    if (i < PLANNERS_MAX && status.planner.planner_id != 0) {
        if (i == line->num_heard) {
            line->heard[line->num_heard++] =
                (heard_t){.planner_id = status.planner.planner_id, .scalar = status.planner.scalar, .batch = -1};
        }
        line->heard[i].heard_s = now_s();
    }
    lcm_ssv_planner_status_t_decode_cleanup(&status);
}

static void line_close(line_t* line) {
    lcm_destroy(line->lcm);
    if (line->refused > REFUSALS_SHOWN) {
        fprintf(stderr, "ssv: refused %d more answers on %s\n", line->refused - REFUSALS_SHOWN, line->answer_channel);
    }
}

/// @param context  what `received` gets; begins with the line.
static bool line_open(line_t* line, lcm_msg_handler_t received, void* context, char* error, size_t error_size) {
    line->lcm = lcm_create(line->target->url);
    if (line->lcm == NULL) {
        snprintf(error, error_size,
                 "no LCM on %s; for UDP multicast the machine needs a route, e.g. ip route add 224.0.0.0/4 dev lo",
                 url_in_use(line->target->url));
        return false;
    }
    lcm_subscription_t* const answers = lcm_subscribe(line->lcm, line->answer_channel, received, context);
    lcm_subscription_t* const statuses = lcm_subscribe(line->lcm, CHANNEL_STATUS, status_received, line);
    if (answers == NULL || statuses == NULL) {
        snprintf(error, error_size, "cannot set up LCM on %s", url_in_use(line->target->url));
        line_close(line);
        return false;
    }
    lcm_subscription_set_queue_capacity(answers, QUEUE_CAPACITY);
    lcm_subscription_set_queue_capacity(statuses, QUEUE_CAPACITY);
    return true;
}

/// Waits for the next message. @return false with the error set if LCM fails.
static bool line_wait(line_t* line, double until_s, char* error, size_t error_size) {
    const double wait_s = fmax(until_s - now_s(), 0);
    if (lcm_handle_timeout(line->lcm, (int)ceil(1000 * wait_s)) < 0) {
        snprintf(error, error_size, "LCM cannot receive on %s", url_in_use(line->target->url));
        return false;
    }
    return true;
}

static bool line_send(line_t* line, const char* channel, const uint8_t* message, int size, char* error,
                      size_t error_size) {
    assert(size > 0);
    if (lcm_publish(line->lcm, channel, message, (unsigned)size) != 0) {
        snprintf(error, error_size, "LCM cannot send the question on %s", url_in_use(line->target->url));
        return false;
    }
    return true;
}

/// The first planner of the scalar that is wanted; NULL if none was heard.
static const heard_t* wanted_planner(const line_t* line) {
    for (int i = 0; i < line->num_heard; i++) {
        if (is_wanted(line, line->heard[i].scalar)) return &line->heard[i];
    }
    return NULL;
}

/// Why nobody answered, in a sentence.
static void tell_silence(const line_t* line, char* error, size_t error_size) {
    const ask_target_t* target = line->target;
    const char* const url = url_in_use(target->url);
    char foreign[160] = "";
    if (line->foreign > 0) {
        snprintf(foreign, sizeof foreign,
                 " (%d messages on %s are of another type: is the planner of another version?)", line->foreign,
                 line->answer_channel);
    }
    if (target->scalar != NULL && wanted_planner(line) == NULL && line->num_heard > 0) {
        snprintf(error, error_size,
                 "the planner on %s computes in %s, not in %s; start one that does (ssv-plannerd --version "
                 "says which), or ask without --scalar",
                 url, name_of(&names_scalar, line->heard[0].scalar), target->scalar);
    } else if (target->scalar != NULL && wanted_planner(line) == NULL) {
        snprintf(error, error_size,
                 "no planner on %s said within %g s what it computes in, which --scalar waits for; start "
                 "ssv-plannerd there, or give it more time with --timeout",
                 url, target->timeout_s);
    } else {
        snprintf(error, error_size,
                 "nobody answered on %s within %g s%s; start ssv-plannerd there, give it more time "
                 "with --timeout, or ask without --lcm",
                 url, target->timeout_s, foreign);
    }
}

// ---- A plan ---------------------------------------------------------------------------------------------------------

typedef struct {
    line_t line;
    const lcm_ssv_scenario_t* question;
    lcm_ssv_plan_t* answer;
    bool sent, answered;
} plan_wait_t;

static bool is_for(const lcm_ssv_asker_t* asker, const lcm_ssv_asker_t* question) {
    return asker->asker_id == question->asker_id && asker->request_id == question->request_id;
}

static void plan_received(const lcm_recv_buf_t* datagram, const char* channel, void* context) {
    (void)channel;
    plan_wait_t* wait = context;
    lcm_ssv_plan_t plan;
    char reason[SSV_CHECK_REASON_SIZE];
    if (wait->answered) return;
    if (!is_message("plan_t", datagram) ||
        lcm_ssv_plan_t_decode(datagram->data, 0, (int)datagram->data_size, &plan) < 0) {
        wait->line.foreign++;
        return;
    }
    if (wait->sent && is_for(&plan.answer.asker, &wait->question->asker)) {
        wait->answered =
            ssv_check_plan(wait->question, &plan, reason) && check_scalar(&wait->line, &plan.answer, reason);
        if (wait->answered) {
            *wait->answer = plan;
            return;
        }
        refuse(&wait->line, reason);
    }
    lcm_ssv_plan_t_decode_cleanup(&plan);
}

static bool exchange_plan(plan_wait_t* wait, lcm_ssv_scenario_t* question, char* error, size_t error_size) {
    static uint8_t message[1024];
    line_t* line = &wait->line;
    double deadline_s = now_s() + line->target->timeout_s, send_at_s = 0;
    if (line->target->scalar != NULL) {
        while (wanted_planner(line) == NULL && now_s() < deadline_s) {
            if (!line_wait(line, deadline_s, error, error_size)) return false;
        }
        if (wanted_planner(line) == NULL) {
            tell_silence(line, error, error_size);
            return false;
        }
        question->asker.planner_id = wanted_planner(line)->planner_id;
        deadline_s = now_s() + line->target->timeout_s;
    }
    const int size = lcm_ssv_scenario_t_encode(message, 0, sizeof message, question);
    wait->sent = true;
    for (double t_s = now_s(); !wait->answered && t_s < deadline_s; t_s = now_s()) {
        if (t_s >= send_at_s) {
            if (!line_send(line, CHANNEL_SCENARIO, message, size, error, error_size)) return false;
            send_at_s = t_s + RESEND_PERIOD_S;
        }
        if (!line_wait(line, fmin(send_at_s, deadline_s), error, error_size)) return false;
    }
    if (!wait->answered) tell_silence(line, error, error_size);
    return wait->answered;
}

bool ask_plan(const ask_target_t* target, lcm_ssv_scenario_t* question, lcm_ssv_plan_t* answer, char* error,
              size_t error_size) {
    plan_wait_t wait = {
        .line = {.target = target, .answer_channel = CHANNEL_PLAN}, .question = question, .answer = answer};
    if (!line_open(&wait.line, plan_received, &wait, error, error_size)) return false;
    const bool answered = exchange_plan(&wait, question, error, error_size);
    line_close(&wait.line);
    return answered;
}

// ---- Prices ---------------------------------------------------------------------------------------------------------

/// A batch that is on its way.
typedef struct {
    lcm_ssv_scenario_batch_t question;
    uint64_t question_hash;
    int first; ///< number of its first scenario
    int moves; ///< how often it changed hands
    double dealt_s, send_at_s;
    bool is_open; ///< without an answer yet
} batch_t;

typedef struct {
    line_t line;
    lcm_ssv_scenario_t* scenarios;
    int count, dealt, priced;
    lcm_ssv_quote_t* quotes;
    int64_t epoch_us;  ///< the same for all, since the newest wins
    batch_t* batch;    ///< room for one of each planner, and the one without a planner
    double progress_s; ///< when the last right answer came
    void (*progress)(int priced, int count, void* context);
    void* context;
} deal_t;

#define BATCHES_MAX (PLANNERS_MAX + 1)

static void quotes_received(const lcm_recv_buf_t* datagram, const char* channel, void* context) {
    (void)channel;
    deal_t* deal = context;
    lcm_ssv_quote_batch_t answer;
    char reason[SSV_CHECK_REASON_SIZE];
    if (!is_message("quote_batch_t", datagram) ||
        lcm_ssv_quote_batch_t_decode(datagram->data, 0, (int)datagram->data_size, &answer) < 0) {
        deal->line.foreign++;
        return;
    }
    for (int i = 0; i < BATCHES_MAX; i++) {
        batch_t* batch = &deal->batch[i];
        if (!batch->is_open || !is_for(&answer.answer.asker, &batch->question.asker)) continue;
        if (!ssv_check_quotes(&batch->question, batch->question_hash, &answer, reason) ||
            !check_scalar(&deal->line, &answer.answer, reason)) {
            refuse(&deal->line, reason);
            break;
        }
        memcpy(&deal->quotes[batch->first], answer.quotes, (size_t)answer.num_quotes * sizeof *answer.quotes);
        deal->priced += answer.num_quotes;
        deal->progress_s = now_s();
        batch->is_open = false;
        for (int k = 0; k < deal->line.num_heard; k++) {
            if (deal->line.heard[k].batch == i) deal->line.heard[k].batch = -1; // the place may be another's next
        }
        answer.num_quotes = 0; // what the quotes point to is the caller's now
        if (deal->progress != NULL) deal->progress(deal->priced, deal->count, deal->context);
        break;
    }
    lcm_ssv_quote_batch_t_decode_cleanup(&answer);
}

/// Puts a batch into the hands of a planner under a new id: a late answer of the one before is then nobody's.
static bool hand_out(deal_t* deal, batch_t* batch, int64_t planner_id, char* error, size_t error_size) {
    if (!ask_stamp(&batch->question.asker, error, error_size)) return false;
    batch->question.asker.epoch_us = deal->epoch_us;
    batch->question.asker.planner_id = planner_id;
    batch->dealt_s = now_s();
    batch->send_at_s = 0;
    return true;
}

static bool send_batch(deal_t* deal, batch_t* batch, double t_s, char* error, size_t error_size) {
    static uint8_t message[1024 * SSV_MAX_BATCH];
    const int size = lcm_ssv_scenario_batch_t_encode(message, 0, sizeof message, &batch->question);
    batch->question_hash = ssv_question_hash(message, (size_t)size);
    batch->send_at_s = t_s + RESEND_PERIOD_S;
    return line_send(&deal->line, CHANNEL_BATCH, message, size, error, error_size);
}

/// The planner without a batch that failed least; NULL if there is none.
static heard_t* idle_planner(deal_t* deal, double t_s) {
    heard_t* best = NULL;
    for (int i = 0; i < deal->line.num_heard; i++) {
        heard_t* planner = &deal->line.heard[i];
        if (planner->batch < 0 && is_wanted(&deal->line, planner->scalar) && t_s - planner->heard_s <= SILENCE_S &&
            (best == NULL || planner->failures < best->failures)) {
            best = planner;
        }
    }
    return best;
}

static int planners_there(const deal_t* deal, double t_s) {
    int there = 0;
    for (int i = 0; i < deal->line.num_heard; i++) {
        there += is_wanted(&deal->line, deal->line.heard[i].scalar) && t_s - deal->line.heard[i].heard_s <= SILENCE_S;
    }
    return there;
}

/// The next scenarios as a batch for this planner: at most half of its share of what is left, so that all end at once.
static bool deal_next(deal_t* deal, heard_t* planner, int planners, double t_s, char* error, size_t error_size) {
    int i = 0;
    while (deal->batch[i].is_open) i++;
    const int rest = deal->count - deal->dealt, parts = planners > 1 ? 2 * planners : 1;
    const int share = (rest + parts - 1) / parts, size = share < SSV_MAX_BATCH ? share : SSV_MAX_BATCH;
    deal->batch[i] = (batch_t){.question = {.num_scenarios = size, .scenarios = &deal->scenarios[deal->dealt]},
                               .first = deal->dealt,
                               .is_open = true};
    deal->dealt += size;
    if (planner != NULL) planner->batch = i;
    return hand_out(deal, &deal->batch[i], planner == NULL ? 0 : planner->planner_id, error, error_size) &&
           send_batch(deal, &deal->batch[i], t_s, error, error_size);
}

/// Whoever has had this batch for too long loses it, if another can take it.
static bool move_on(deal_t* deal, int number, double t_s, char* error, size_t error_size) {
    batch_t* batch = &deal->batch[number];
    heard_t* holder = NULL;
    for (int i = 0; i < deal->line.num_heard; i++) {
        if (deal->line.heard[i].batch == number) holder = &deal->line.heard[i];
    }
    const double patience_s = PATIENCE_S * (1 << (batch->moves < 10 ? batch->moves : 10));
    const bool is_gone = holder != NULL && t_s - holder->heard_s > SILENCE_S;
    if (holder == NULL || (!is_gone && t_s - batch->dealt_s < patience_s)) return true;
    heard_t* const next = idle_planner(deal, t_s);
    if (next == NULL) return true;
    holder->failures++;
    holder->batch = -1;
    next->batch = number;
    batch->moves++;
    return hand_out(deal, batch, next->planner_id, error, error_size);
}

/// One round over all batches. @return when the next one is due, or a negative time with the error set.
static double deal_round(deal_t* deal, double start_s, char* error, size_t error_size) {
    const double t_s = now_s();
    const int there = planners_there(deal, t_s);
    const bool to_anyone = deal->line.target->scalar == NULL && there == 0;
    double next_s = t_s + RESEND_PERIOD_S;
    bool sound = true;
    int open = 0;
    for (int i = 0; i < BATCHES_MAX && sound; i++) {
        batch_t* batch = &deal->batch[i];
        if (!batch->is_open) continue;
        open++;
        sound = move_on(deal, i, t_s, error, error_size) &&
                (t_s < batch->send_at_s || send_batch(deal, batch, t_s, error, error_size));
        next_s = fmin(next_s, batch->send_at_s);
    }
    for (heard_t* planner; sound && deal->dealt < deal->count && (planner = idle_planner(deal, t_s)) != NULL;) {
        sound = deal_next(deal, planner, there, t_s, error, error_size);
        open++;
    }
    if (sound && to_anyone && open == 0 && deal->dealt < deal->count) {
        const double from_s = deal->count <= SSV_MAX_BATCH ? start_s : start_s + LISTEN_S;
        if (t_s >= from_s) sound = deal_next(deal, NULL, 1, t_s, error, error_size);
        next_s = t_s < from_s ? fmin(next_s, from_s) : next_s;
    }
    return sound ? next_s : -1;
}

static bool exchange_quotes(deal_t* deal, char* error, size_t error_size) {
    const double start_s = now_s();
    deal->progress_s = start_s;
    while (deal->priced < deal->count) {
        const double next_s = deal_round(deal, start_s, error, error_size);
        const double deadline_s = deal->progress_s + deal->line.target->timeout_s;
        if (next_s < 0 || !line_wait(&deal->line, fmin(next_s, deadline_s), error, error_size)) return false;
        if (now_s() >= deal->progress_s + deal->line.target->timeout_s && deal->priced < deal->count) {
            tell_silence(&deal->line, error, error_size);
            return false;
        }
    }
    return true;
}

bool ask_quotes(const ask_target_t* target, const lcm_ssv_scenario_t* scenarios, int count, lcm_ssv_quote_t* quotes,
                void (*progress)(int priced, int count, void* context), void* context, char* error, size_t error_size) {
    static batch_t batches[BATCHES_MAX];
    lcm_ssv_asker_t asker;
    memset(batches, 0, sizeof batches);
    memset(quotes, 0, (size_t)count * sizeof *quotes);
    deal_t deal = {.line = {.target = target, .answer_channel = CHANNEL_QUOTES},
                   .scenarios = calloc((size_t)count, sizeof *scenarios),
                   .count = count,
                   .quotes = quotes,
                   .batch = batches,
                   .progress = progress,
                   .context = context};
    if (deal.scenarios == NULL) {
        snprintf(error, error_size, "out of memory");
        return false;
    }
    for (int i = 0; i < count; i++) {
        deal.scenarios[i] = scenarios[i];
        deal.scenarios[i].asker = (lcm_ssv_asker_t){0};
    }
    bool answered = ask_stamp(&asker, error, error_size);
    if (answered) {
        deal.epoch_us = asker.epoch_us;
        answered = line_open(&deal.line, quotes_received, &deal, error, error_size);
    }
    if (answered) {
        answered = exchange_quotes(&deal, error, error_size);
        line_close(&deal.line);
    }
    for (int i = 0; i < count && !answered; i++) wire_clear("quote_t", &quotes[i]);
    free(deal.scenarios);
    return answered;
}
