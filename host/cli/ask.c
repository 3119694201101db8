#define _DEFAULT_SOURCE
#include "ask.h"

#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <time.h>

#include "channels.h"
#include "lcm_ssv_control_t.h"
#include "lcm_ssv_planner_status_t.h"
#include "line.h"
#include "ssv/answer.h"
#include "ssv/check.h"
#include "wire/message.h"

/// Room for a task, whose scene is most of it, and for each scenario of a batch.
#define TASK_BYTES_MAX 6144
#define SCENARIO_BYTES_MAX 1024
#define RESEND_PERIOD_S 0.5
/// A stop is urgent.
#define STOP_PERIOD_S 0.2
/// How long a planner may keep its first batch without an answer. Doubled each time that a batch changes hands, so that
/// one that takes long is answered in the end.
#define PATIENCE_S 3.0

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

static line_t line_to(const ask_target_t* target, const char* answer_channel) {
    return (line_t){
        .url = target->url, .scalar = target->scalar, .timeout_s = target->timeout_s, .answer_channel = answer_channel};
}

// ---- A plan ---------------------------------------------------------------------------------------------------------

typedef struct {
    line_t line;
    const lcm_ssv_task_t* question;
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
    if (!line_is_message("plan_t", datagram) ||
        lcm_ssv_plan_t_decode(datagram->data, 0, (int)datagram->data_size, &plan) < 0) {
        wait->line.foreign++;
        return;
    }
    if (wait->sent && is_for(&plan.answer.asker, &wait->question->scenario.asker)) {
        wait->answered =
            ssv_check_plan(wait->question, &plan, reason) && line_check_scalar(&wait->line, &plan.answer, reason);
        if (wait->answered) {
            *wait->answer = plan;
            return;
        }
        line_refuse(&wait->line, reason);
    }
    lcm_ssv_plan_t_decode_cleanup(&plan);
}

static bool exchange_plan(plan_wait_t* wait, lcm_ssv_task_t* question, char* error, size_t error_size) {
    static uint8_t message[TASK_BYTES_MAX];
    line_t* line = &wait->line;
    double deadline_s = line_now_s() + line->timeout_s, send_at_s = 0;
    if (line->scalar != NULL) {
        while (line_first_wanted(line) == NULL && line_now_s() < deadline_s) {
            if (!line_wait(line, deadline_s, -1, error, error_size)) return false;
        }
        if (line_first_wanted(line) == NULL) {
            line_tell_silence(line, error, error_size);
            return false;
        }
        question->scenario.asker.planner_id = line_first_wanted(line)->planner_id;
        deadline_s = line_now_s() + line->timeout_s;
    }
    const int size = lcm_ssv_task_t_encode(message, 0, sizeof message, question);
    wait->sent = true;
    for (double t_s = line_now_s(); !wait->answered && t_s < deadline_s; t_s = line_now_s()) {
        if (t_s >= send_at_s) {
            if (!line_send(line, CHANNEL_SCENARIO, message, size, error, error_size)) return false;
            send_at_s = t_s + RESEND_PERIOD_S;
        }
        if (!line_wait(line, fmin(send_at_s, deadline_s), -1, error, error_size)) return false;
    }
    if (!wait->answered) line_tell_silence(line, error, error_size);
    return wait->answered;
}

bool ask_plan(const ask_target_t* target, lcm_ssv_task_t* question, lcm_ssv_plan_t* answer, char* error,
              size_t error_size) {
    plan_wait_t wait = {.line = line_to(target, CHANNEL_PLAN), .question = question, .answer = answer};
    if (!line_open(&wait.line, plan_received, &wait, error, error_size)) return false;
    const bool answered = exchange_plan(&wait, question, error, error_size);
    line_close(&wait.line);
    return answered;
}

// ---- A flight -------------------------------------------------------------------------------------------------------

typedef struct {
    plan_wait_t plan; ///< begins with the line
    const ask_flight_t* flight;
    lcm_ssv_execution_t* news; ///< the newest; all zero before the first
    double heard_s;
    ask_wish_t wish;
} flight_wait_t;

/// Whether the numbers are some, and name what there is.
static bool is_sound(const lcm_ssv_execution_t* news) {
    const double sum = news->time_s + news->flown_s + news->plan_time_s + news->plan_duration_s + news->clock_rate +
                       news->impulse_Ns + news->behind_m + news->beside_m + news->angle_rad + news->goal_distance_m +
                       news->goal_angle_rad + news->link_silence_s;
    return isfinite(sum) && news->state >= 0 && news->state <= LCM_SSV_EXECUTION_T_STATE_ENDED && news->outcome >= 0 &&
           news->outcome <= LCM_SSV_EXECUTION_T_OUTCOME_SILENT && news->goal >= 0 &&
           news->goal <= LCM_SSV_EXECUTION_T_GOAL_DOCK;
}

static bool has_ended(const flight_wait_t* wait) { return wait->news->state == LCM_SSV_EXECUTION_T_STATE_ENDED; }

static ask_wish_t turn(const flight_wait_t* wait, const lcm_ssv_execution_t* news) {
    return wait->flight->turn(wait->plan.answered ? wait->plan.answer : NULL, news, wait->flight->context);
}

static void execution_received(const lcm_recv_buf_t* datagram, const char* channel, void* context) {
    (void)channel;
    flight_wait_t* wait = context;
    const lcm_ssv_asker_t* asker = &wait->plan.question->scenario.asker;
    lcm_ssv_execution_t news;
    if (!line_is_message("execution_t", datagram) ||
        lcm_ssv_execution_t_decode(datagram->data, 0, (int)datagram->data_size, &news) < 0) {
        return;
    }
    if (!is_for(&news.answer.asker, asker) || news.answer.planner.planner_id != asker->planner_id || !is_sound(&news) ||
        has_ended(wait)) {
        lcm_ssv_execution_t_decode_cleanup(&news);
        return;
    }
    tree_make_harmless(news.reason);
    tree_make_harmless(news.text);
    wire_clear("execution_t", wait->news);
    *wait->news = news;
    wait->heard_s = line_now_s();
    wait->wish = turn(wait, wait->news);
}

/// A vehicle_state_t names nobody but its plan.
static void state_received(const lcm_recv_buf_t* datagram, const char* channel, void* context) {
    const flight_wait_t* const wait = context;
    lcm_ssv_vehicle_state_t state;
    if (!line_is_message("vehicle_state_t", datagram) ||
        lcm_ssv_vehicle_state_t_decode(datagram->data, 0, (int)datagram->data_size, &state) < 0) {
        return;
    }
    if (!has_ended(wait) && state.plan_hash != 0 && state.plan_hash == wait->news->plan_hash)
        wait->flight->state(&state, strcmp(channel, CHANNEL_TRUTH) == 0, wait->flight->context);
}

/// The one planner that hears its vehicle. With two of them nobody can know which vehicle is meant.
static bool find_vehicle(line_t* line, int64_t* planner_id, char* error, size_t error_size) {
    const double start_s = line_now_s(), deadline_s = start_s + line->timeout_s;
    int found = 0, deaf = 0;
    for (double t_s = start_s; t_s < deadline_s && (found == 0 || t_s < start_s + LINE_LISTEN_S); t_s = line_now_s()) {
        if (!line_wait(line, t_s + LINE_LISTEN_S / 4, -1, error, error_size)) return false;
        found = deaf = 0;
        for (int i = 0; i < line->num_heard; i++) {
            if (!line_wants(line, line->heard[i].scalar)) continue;
            const bool hears = line->heard[i].link == LCM_SSV_PLANNER_STATUS_T_LINK_HEARD;
            if (hears) *planner_id = line->heard[i].planner_id;
            found += hears;
            deaf += !hears;
        }
    }
    if (found > 1) {
        snprintf(
            error, error_size,
            "%d planners hear a vehicle, and a task must be flown by one; ask on a bus with one of them (--lcm URL)",
            found);
    } else if (found == 0 && deaf > 0) {
        snprintf(error, error_size, "none of the planners that answer (%d) hears a vehicle; see ssv-plannerd --link",
                 deaf);
    } else if (found == 0) {
        line_tell_silence(line, error, error_size);
    }
    return found == 1;
}

static bool send_stop(flight_wait_t* wait, char* error, size_t error_size) {
    uint8_t message[64];
    const lcm_ssv_asker_t* asker = &wait->plan.question->scenario.asker;
    const lcm_ssv_control_t stop = {asker->planner_id, asker->request_id, LCM_SSV_CONTROL_T_COMMAND_STOP};
    const int size = lcm_ssv_control_t_encode(message, 0, sizeof message, &stop);
    return line_send(&wait->plan.line, CHANNEL_CONTROL, message, size, error, error_size);
}

static bool exchange_flight(flight_wait_t* wait, char* error, size_t error_size) {
    static uint8_t message[TASK_BYTES_MAX];
    const ask_flight_t* flight = wait->flight;
    line_t* line = &wait->plan.line;
    const int size = lcm_ssv_task_t_encode(message, 0, sizeof message, wait->plan.question);
    double send_at_s = 0, stop_at_s = 0;
    bool is_other = false;
    wait->plan.sent = true;
    wait->heard_s = line_now_s();
    while (!wait->plan.answered || !has_ended(wait)) {
        const double t_s = line_now_s();
        wait->wish = turn(wait, NULL);
        is_other = wait->plan.answered && flight->plan_hash != 0 && wait->plan.answer->plan_hash != flight->plan_hash;
        if (wait->wish == ASK_LEAVE) {
            snprintf(error, error_size, "left the flight to itself");
            return false;
        }
        if (wait->plan.answered && wait->plan.answer->quote.status != LCM_SSV_QUOTE_T_STATUS_OK) return true;
        const bool asks = wait->wish == ASK_GO_ON || has_ended(wait);
        if (!wait->plan.answered && asks && t_s >= send_at_s) {
            if (!line_send(line, CHANNEL_EXECUTE, message, size, error, error_size)) return false;
            send_at_s = t_s + RESEND_PERIOD_S;
        }
        if ((wait->wish == ASK_STOP || is_other) && t_s >= stop_at_s) {
            if (!send_stop(wait, error, error_size)) return false;
            stop_at_s = t_s + STOP_PERIOD_S;
        }
        if (t_s - wait->heard_s > line->timeout_s) {
            if (wait->plan.answered) {
                snprintf(error, error_size, "the planner has told nothing of the flight for %g s", line->timeout_s);
            } else {
                line_tell_silence(line, error, error_size);
            }
            return false;
        }
        if (!line_wait(line, t_s + STOP_PERIOD_S, flight->wake_fd, error, error_size)) return false;
    }
    if (is_other) {
        snprintf(error, error_size,
                 "the planner's plan %016" PRIx64 " is not the one that is planned here, %016" PRIx64
                 ": is it of another version? The flight was stopped",
                 (uint64_t)wait->plan.answer->plan_hash, (uint64_t)flight->plan_hash);
    }
    return !is_other;
}

bool ask_flight(const ask_target_t* target, const ask_flight_t* flight, lcm_ssv_task_t* question,
                lcm_ssv_plan_t* answer, lcm_ssv_execution_t* end, char* error, size_t error_size) {
    flight_wait_t wait = {
        .plan = {.line = line_to(target, CHANNEL_PLAN), .question = question, .answer = answer},
        .flight = flight,
        .news = end,
    };
    line_t* line = &wait.plan.line;
    *end = (lcm_ssv_execution_t){0};
    question->scenario.asker.planner_id = flight->planner_id;
    if (!line_open(line, plan_received, &wait, error, error_size)) return false;
    const bool flown =
        line_hear(line, CHANNEL_EXECUTION, execution_received, &wait, error, error_size) &&
        line_hear(line, CHANNEL_STATE, state_received, &wait, error, error_size) &&
        line_hear(line, CHANNEL_TRUTH, state_received, &wait, error, error_size) &&
        (flight->planner_id != 0 || find_vehicle(line, &question->scenario.asker.planner_id, error, error_size)) &&
        exchange_flight(&wait, error, error_size);
    line_close(line);
    if (!flown) {
        wire_clear("execution_t", end);
        if (wait.plan.answered) lcm_ssv_plan_t_decode_cleanup(answer);
    }
    return flown;
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

#define BATCHES_MAX (LINE_PLANNERS_MAX + 1)

typedef struct ask_prices {
    line_t line;
    const lcm_ssv_task_t* tasks;
    lcm_ssv_scenario_t* scenarios; ///< theirs, one after the other
    int count, dealt, priced;
    lcm_ssv_quote_t* quotes;
    int64_t epoch_us;           ///< the same for all, since the newest wins
    batch_t batch[BATCHES_MAX]; ///< one of each planner, and the one without a planner
    double progress_s;          ///< when the last right answer came
    bool (*stop)(void* context);
    void* stop_context;
    void (*progress)(int priced, int count, void* context);
    void* context;
} deal_t;

static void quotes_received(const lcm_recv_buf_t* datagram, const char* channel, void* context) {
    (void)channel;
    deal_t* deal = context;
    lcm_ssv_quote_batch_t answer;
    char reason[SSV_CHECK_REASON_SIZE];
    if (!line_is_message("quote_batch_t", datagram) ||
        lcm_ssv_quote_batch_t_decode(datagram->data, 0, (int)datagram->data_size, &answer) < 0) {
        deal->line.foreign++;
        return;
    }
    for (int i = 0; i < BATCHES_MAX; i++) {
        batch_t* batch = &deal->batch[i];
        if (!batch->is_open || !is_for(&answer.answer.asker, &batch->question.asker)) continue;
        if (!ssv_check_quotes(&batch->question, batch->question_hash, &answer, reason) ||
            !line_check_scalar(&deal->line, &answer.answer, reason)) {
            line_refuse(&deal->line, reason);
            break;
        }
        memcpy(&deal->quotes[batch->first], answer.quotes, (size_t)answer.num_quotes * sizeof *answer.quotes);
        deal->priced += answer.num_quotes;
        deal->progress_s = line_now_s();
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
    batch->dealt_s = line_now_s();
    batch->send_at_s = 0;
    return true;
}

static bool send_batch(deal_t* deal, batch_t* batch, double t_s, char* error, size_t error_size) {
    static uint8_t message[TASK_BYTES_MAX + SCENARIO_BYTES_MAX * SSV_MAX_BATCH];
    const int size = lcm_ssv_scenario_batch_t_encode(message, 0, sizeof message, &batch->question);
    batch->question_hash = ssv_question_hash(message, (size_t)size);
    batch->send_at_s = t_s + RESEND_PERIOD_S;
    return line_send(&deal->line, CHANNEL_BATCH, message, size, error, error_size);
}

/// The planner without a batch that failed least; NULL if there is none.
static line_planner_t* idle_planner(deal_t* deal, double t_s) {
    line_planner_t* best = NULL;
    for (int i = 0; i < deal->line.num_heard; i++) {
        line_planner_t* planner = &deal->line.heard[i];
        if (planner->batch < 0 && line_wants(&deal->line, planner->scalar) &&
            t_s - planner->heard_s <= LINE_SILENCE_S && (best == NULL || planner->failures < best->failures)) {
            best = planner;
        }
    }
    return best;
}

static int planners_there(const deal_t* deal, double t_s) {
    int there = 0;
    for (int i = 0; i < deal->line.num_heard; i++) {
        there +=
            line_wants(&deal->line, deal->line.heard[i].scalar) && t_s - deal->line.heard[i].heard_s <= LINE_SILENCE_S;
    }
    return there;
}

static bool is_same_obstacle(const lcm_ssv_obstacle_t* a, const lcm_ssv_obstacle_t* b) {
    bool same = a->kind == b->kind && a->length_m == b->length_m && a->radius_m == b->radius_m;
    for (int i = 0; i < 3; i++) same = same && a->p_I_m[i] == b->p_I_m[i] && a->axis_I[i] == b->axis_I[i];
    return same;
}

static bool is_same_scene(const lcm_ssv_scene_t* a, const lcm_ssv_scene_t* b) {
    bool same =
        a->num_obstacles == b->num_obstacles && a->tank.kind == b->tank.kind && a->tank.radius_m == b->tank.radius_m;
    for (int i = 0; i < 3; i++)
        same = same && a->tank.from_I_m[i] == b->tank.from_I_m[i] && a->tank.to_I_m[i] == b->tank.to_I_m[i];
    for (int k = 0; k < SSV_MAX_OBSTACLES && same; k++) same = is_same_obstacle(&a->obstacles[k], &b->obstacles[k]);
    return same;
}

/// How many of the tasks from here on have the scene of the first, up to so many.
static int with_one_scene(const lcm_ssv_task_t* tasks, int most) {
    int count = 1;
    while (count < most && is_same_scene(&tasks[count].scene, &tasks[0].scene)) count++;
    return count;
}

/// The next scenarios as a batch for this planner: at most half of its share of what is left, so that all end at once.
static bool deal_next(deal_t* deal, line_planner_t* planner, int planners, double t_s, char* error, size_t error_size) {
    int i = 0;
    while (deal->batch[i].is_open) i++;
    const int rest = deal->count - deal->dealt, parts = planners > 1 ? 2 * planners : 1;
    const int share = (rest + parts - 1) / parts, most = share < SSV_MAX_BATCH ? share : SSV_MAX_BATCH;
    const lcm_ssv_task_t* first = &deal->tasks[deal->dealt];
    const int size = with_one_scene(first, most);
    deal->batch[i] = (batch_t){
        .question = {.num_scenarios = size, .scene = first->scene, .scenarios = &deal->scenarios[deal->dealt]},
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
    line_planner_t* holder = NULL;
    for (int i = 0; i < deal->line.num_heard; i++) {
        if (deal->line.heard[i].batch == number) holder = &deal->line.heard[i];
    }
    const double patience_s = PATIENCE_S * (1 << (batch->moves < 10 ? batch->moves : 10));
    const bool is_gone = holder != NULL && t_s - holder->heard_s > LINE_SILENCE_S;
    if (holder == NULL || (!is_gone && t_s - batch->dealt_s < patience_s)) return true;
    line_planner_t* const next = idle_planner(deal, t_s);
    if (next == NULL) return true;
    holder->failures++;
    holder->batch = -1;
    next->batch = number;
    batch->moves++;
    return hand_out(deal, batch, next->planner_id, error, error_size);
}

/// One round over all batches. @return when the next one is due, or a negative time with the error set.
static double deal_round(deal_t* deal, double start_s, char* error, size_t error_size) {
    const double t_s = line_now_s();
    const int there = planners_there(deal, t_s);
    const bool to_anyone = deal->line.scalar == NULL && there == 0;
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
    for (line_planner_t* planner; sound && deal->dealt < deal->count && (planner = idle_planner(deal, t_s)) != NULL;) {
        sound = deal_next(deal, planner, there, t_s, error, error_size);
        open++;
    }
    if (sound && to_anyone && open == 0 && deal->dealt < deal->count) {
        const double from_s = deal->count <= SSV_MAX_BATCH ? start_s : start_s + LINE_LISTEN_S;
        if (t_s >= from_s) sound = deal_next(deal, NULL, 1, t_s, error, error_size);
        next_s = t_s < from_s ? fmin(next_s, from_s) : next_s;
    }
    return sound ? next_s : -1;
}

static bool exchange_quotes(deal_t* deal, char* error, size_t error_size) {
    const double start_s = line_now_s();
    deal->progress_s = start_s;
    while (deal->priced < deal->count) {
        const double next_s = deal_round(deal, start_s, error, error_size);
        const double deadline_s = deal->progress_s + deal->line.timeout_s;
        if (next_s < 0 || !line_wait(&deal->line, fmin(next_s, deadline_s), -1, error, error_size)) return false;
        if (deal->stop != NULL && deal->stop(deal->stop_context)) {
            snprintf(error, error_size, "stopped before all prices had come");
            return false;
        }
        if (line_now_s() >= deal->progress_s + deal->line.timeout_s && deal->priced < deal->count) {
            line_tell_silence(&deal->line, error, error_size);
            return false;
        }
    }
    return true;
}

ask_prices_t* ask_prices_open(const ask_target_t* target, char* error, size_t error_size) {
    lcm_ssv_asker_t asker;
    ask_prices_t* const deal = calloc(1, sizeof *deal);
    if (deal == NULL) {
        snprintf(error, error_size, "out of memory");
        return NULL;
    }
    deal->line = line_to(target, CHANNEL_QUOTES);
    if (ask_stamp(&asker, error, error_size) && line_open(&deal->line, quotes_received, deal, error, error_size)) {
        deal->epoch_us = asker.epoch_us;
        return deal;
    }
    free(deal);
    return NULL;
}

void ask_prices_stop(ask_prices_t* deal, bool (*stop)(void* context), void* context) {
    deal->stop = stop;
    deal->stop_context = context;
}

/// Nothing is under way: what is open from an exchange that failed is nobody's.
static void start_over(deal_t* deal) {
    memset(deal->batch, 0, sizeof deal->batch);
    for (int i = 0; i < deal->line.num_heard; i++) deal->line.heard[i].batch = -1;
    deal->dealt = deal->priced = 0;
}

bool ask_prices(ask_prices_t* deal, const lcm_ssv_task_t* tasks, int count, lcm_ssv_quote_t* quotes,
                void (*progress)(int priced, int count, void* context), void* context, char* error, size_t error_size) {
    memset(quotes, 0, (size_t)count * sizeof *quotes);
    start_over(deal);
    deal->tasks = tasks;
    deal->scenarios = calloc((size_t)count, sizeof *deal->scenarios);
    deal->count = count;
    deal->quotes = quotes;
    deal->progress = progress;
    deal->context = context;
    if (deal->scenarios == NULL) {
        snprintf(error, error_size, "out of memory");
        return false;
    }
    for (int i = 0; i < count; i++) {
        deal->scenarios[i] = tasks[i].scenario;
        deal->scenarios[i].asker = (lcm_ssv_asker_t){0};
    }
    const bool answered = exchange_quotes(deal, error, error_size);
    for (int i = 0; i < count && !answered; i++) wire_clear("quote_t", &quotes[i]);
    free(deal->scenarios);
    return answered;
}

void ask_prices_close(ask_prices_t* deal) {
    if (deal == NULL) return;
    line_close(&deal->line);
    free(deal);
}

bool ask_quotes(const ask_target_t* target, const lcm_ssv_task_t* tasks, int count, lcm_ssv_quote_t* quotes,
                void (*progress)(int priced, int count, void* context), void* context, char* error, size_t error_size) {
    ask_prices_t* const deal = ask_prices_open(target, error, error_size);
    const bool answered = deal != NULL && ask_prices(deal, tasks, count, quotes, progress, context, error, error_size);
    ask_prices_close(deal);
    return answered;
}
