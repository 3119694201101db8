#include "live.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "channels.h"
#include "lcm_ssv_planner_status_t.h"
#include "picture.h"
#include "track.h"
#include "wire/message.h"
#include "wire/names.h"

/// Questions whose plans may still come, and plans that may still be flown.
enum { QUESTIONS = 32, PLANS = 16, PLANNERS = 8 };
/// Most tasks of an assembly that stay in the picture.
#define TASKS_MAX 64
/// [s] A flight of which nothing was told for so long is no longer one.
#define SILENCE_S 5.0
/// [m] A task begins where the one before ended if it is no farther from there.
#define SAME_PLACE_M 0.1

struct live {
    lcm_ssv_task_t question[QUESTIONS];
    int num_questions, num_plans; ///< heard so far; the newest ones are kept
    record_task_t plan[PLANS];
    record_t shown; ///< tasks that were docked, and the one that is under way or planned
    track_t* track; ///< of the last of them
    bool flies;
    int64_t asker_id, request_id; ///< of the flight
    double now_s, told_s;         ///< the time, and when it was last told of
    lcm_ssv_planner_status_t planner[PLANNERS];
    int num_planners;
    long taken, refused;
};

// ---- Memory ---------------------------------------------------------------------------------------------------------

live_t* live_begin(void) {
    live_t* const live = calloc(1, sizeof *live);
    if (live == NULL) return NULL;
    live->shown.tasks = calloc(TASKS_MAX, sizeof *live->shown.tasks);
    live->track = calloc(1, sizeof *live->track);
    if (live->shown.tasks != NULL && live->track != NULL) return live;
    live_end(live);
    return NULL;
}

void live_end(live_t* live) {
    for (int i = 0; i < PLANS; i++) record_task_free(&live->plan[i]);
    for (int i = 0; i < PLANNERS; i++) wire_clear("planner_status_t", &live->planner[i]);
    if (live->track != NULL) track_free(live->track);
    free(live->track);
    if (live->shown.tasks != NULL) record_free(&live->shown);
    free(live);
}

/// Another one with the same message, since both own what it points to.
static bool copy_task(const record_task_t* from, record_task_t* to) {
    const int size = lcm_ssv_plan_t_encoded_size(&from->plan);
    uint8_t* const message = malloc((size_t)size);
    *to = (record_task_t){.question = from->question};
    memcpy(to->name, from->name, sizeof to->name);
    const bool copied = message != NULL && lcm_ssv_plan_t_encode(message, 0, size, &from->plan) == size &&
                        wire_decode("plan_t", message, (size_t)size, &to->plan);
    free(message);
    return copied;
}

// ---- What is shown --------------------------------------------------------------------------------------------------

static record_task_t* current(const live_t* live) {
    return live->shown.count > 0 ? &live->shown.tasks[live->shown.count - 1] : NULL;
}

/// The last task goes, with its track.
static void drop_current(live_t* live) {
    if (live->shown.count == 0) return;
    record_task_free(&live->shown.tasks[--live->shown.count]);
    track_free(live->track);
}

/// Puts a plan into the picture as its last task. @return false if it cannot be drawn.
static bool show_plan(live_t* live, const record_task_t* plan) {
    char error[256];
    if (live->shown.count == TASKS_MAX) { // the oldest goes
        record_task_free(&live->shown.tasks[0]);
        memmove(&live->shown.tasks[0], &live->shown.tasks[1], (TASKS_MAX - 1) * sizeof live->shown.tasks[0]);
        live->shown.count--;
    }
    record_task_t* const task = &live->shown.tasks[live->shown.count];
    track_free(live->track);
    if (!copy_task(plan, task) || !track_of_plan(&task->question, &task->plan, live->track, error, sizeof error)) {
        record_task_free(task);
        return false;
    }
    live->shown.count++;
    return true;
}

static bool is_docked(const record_task_t* task) {
    return task->flight != NULL && task->flight->end.outcome == LCM_SSV_EXECUTION_T_OUTCOME_DOCKED;
}

/// Whether a task goes on where the last one that was docked left the vehicle.
static bool goes_on(const live_t* live, const record_task_t* task) {
    const record_task_t* const last = current(live);
    if (last == NULL || !is_docked(last)) return false;
    const double *from = last->plan.quote.X_IS_final.p_m, *to = task->question.scenario.X_IS.p_m;
    return hypot(hypot(from[0] - to[0], from[1] - to[1]), from[2] - to[2]) < SAME_PLACE_M;
}

/// Makes room in the picture for a task: all of it, unless the task belongs to the same assembly.
static void make_room(live_t* live, const record_task_t* task) {
    if (live->shown.count > 0 && !is_docked(current(live))) drop_current(live); // planned only, or not to its end
    if (goes_on(live, task)) return;
    while (live->shown.count > 0) drop_current(live);
}

// ---- Events ---------------------------------------------------------------------------------------------------------

static json_t* picture_json(const live_t* live) {
    char error[512];
    record_t shown = live->shown;
    snprintf(shown.title, sizeof shown.title, "%s",
             live->flies                ? "A flight under way"
             : shown.count == 0         ? "Waiting for a plan"
             : is_docked(current(live)) ? "A flight: docked"
                                        : "The newest plan");
    json_t* const picture = picture_of(&shown, error, sizeof error);
    return picture != NULL ? picture : json_null();
}

static json_t* picture_event(const live_t* live) {
    return json_pack("{s:s,s:o}", "kind", "picture", "picture", picture_json(live));
}

static json_t* planner_json(const lcm_ssv_planner_status_t* status) {
    char id[17], flying[17];
    snprintf(id, sizeof id, "%016" PRIx64, (uint64_t)status->planner.planner_id);
    snprintf(flying, sizeof flying, "%016" PRIx64, (uint64_t)status->flying_request_id);
    return json_pack("{s:s,s:s?,s:s,s:i,s:s,s:I,s:i,s:I,s:I,s:I,s:f}", "planner_id", id, "version",
                     status->planner.version, "scalar", name_of(&names_scalar, status->planner.scalar), "link",
                     (int)status->link, "flying_request_id", flying, "flights", (json_int_t)status->flights, "waiting",
                     (int)status->waiting, "accepted", (json_int_t)status->accepted, "quoted",
                     (json_int_t)status->quoted, "lost", (json_int_t)status->datagrams_lost, "uptime_s",
                     1e-6 * (double)status->uptime_us);
}

static json_t* planners_json(const live_t* live) {
    json_t* const list = json_array();
    for (int i = 0; i < live->num_planners; i++) json_array_append_new(list, planner_json(&live->planner[i]));
    return list;
}

static json_t* execution_json(const lcm_ssv_execution_t* news) {
    return json_pack("{s:s,s:s,s:s,s:s,s:i,s:i,s:i,s:i,s:i,s:f,s:f,s:f,s:f,s:f,s:f,s:I,s:I,s:f}", "state",
                     name_of(&names_state, news->state), "outcome", name_of(&names_outcome, news->outcome), "goal",
                     name_of(&names_goal, news->goal), "reason", news->reason, "sequence", news->sequence, "attempts",
                     news->attempts, "num_plans", news->num_plans, "uploaded_bytes", news->uploaded_bytes,
                     "upload_bytes", news->upload_bytes, "flown_s", news->flown_s, "plan_time_s", news->plan_time_s,
                     "impulse_Ns", news->impulse_Ns, "clock_rate", news->clock_rate, "behind_m", news->behind_m,
                     "beside_m", news->beside_m, "link_received", (json_int_t)news->link_received, "link_lost",
                     (json_int_t)news->link_lost, "link_silence_s", news->link_silence_s);
}

json_t* live_snapshot(const live_t* live) {
    const record_task_t* const task = current(live);
    const bool has_flight = task != NULL && task->flight != NULL;
    return json_pack("{s:s,s:o,s:o,s:o,s:b}", "kind", "snapshot", "picture", picture_json(live), "planners",
                     planners_json(live), "execution", has_flight ? execution_json(&task->flight->end) : json_null(),
                     "flies", (int)live->flies);
}

// ---- Messages -------------------------------------------------------------------------------------------------------

static json_t* refuse(live_t* live) {
    live->refused++;
    return NULL;
}

static json_t* take_question(live_t* live, const void* data, size_t size) {
    lcm_ssv_task_t question;
    if (!wire_decode("task_t", data, size, &question)) return refuse(live);
    live->question[live->num_questions++ % QUESTIONS] = question; // it points to nothing
    return NULL;
}

static bool is_of(const lcm_ssv_asker_t* a, const lcm_ssv_asker_t* b) {
    return a->asker_id == b->asker_id && a->request_id == b->request_id;
}

/// The newest question that this plan can be the answer to.
static const lcm_ssv_task_t* question_of(const live_t* live, const lcm_ssv_plan_t* plan) {
    char reason[SSV_CHECK_REASON_SIZE];
    const int oldest = live->num_questions > QUESTIONS ? live->num_questions - QUESTIONS : 0;
    for (int i = live->num_questions - 1; i >= oldest; i--) {
        const lcm_ssv_task_t* const question = &live->question[i % QUESTIONS];
        if (is_of(&question->scenario.asker, &plan->answer.asker) && ssv_check_plan(question, plan, reason))
            return question;
    }
    return NULL;
}

static bool flies_now(const live_t* live) { return live->flies && live->now_s - live->told_s < SILENCE_S; }

static json_t* take_plan(live_t* live, const void* data, size_t size) {
    lcm_ssv_plan_t plan;
    if (!wire_decode("plan_t", data, size, &plan)) return refuse(live);
    const lcm_ssv_task_t* const question = question_of(live, &plan);
    if (question == NULL || plan.quote.status != LCM_SSV_QUOTE_T_STATUS_OK) {
        wire_clear("plan_t", &plan);
        return question == NULL ? refuse(live) : NULL;
    }
    record_task_t* const place = &live->plan[live->num_plans++ % PLANS];
    record_task_free(place);
    place->question = *question;
    place->plan = plan;
    snprintf(place->name, sizeof place->name, "%016" PRIx64, (uint64_t)plan.answer.asker.request_id);
    if (flies_now(live)) return NULL;
    live->flies = false;
    make_room(live, place);
    return show_plan(live, place) ? picture_event(live) : refuse(live);
}

static const record_task_t* plan_of(const live_t* live, const lcm_ssv_execution_t* news) {
    for (int i = 0; i < PLANS; i++) {
        const lcm_ssv_plan_t* const plan = &live->plan[i].plan;
        if (plan->num_legs > 0 && is_of(&plan->answer.asker, &news->answer.asker) &&
            plan->answer.planner.planner_id == news->answer.planner.planner_id) {
            return &live->plan[i];
        }
    }
    return NULL;
}

static bool is_sound(const lcm_ssv_execution_t* news) {
    return isfinite(news->time_s + news->flown_s + news->plan_time_s + news->clock_rate + news->impulse_Ns +
                    news->behind_m + news->beside_m + news->link_silence_s);
}

static bool is_current(const live_t* live, const lcm_ssv_execution_t* news) {
    return live->flies && news->answer.asker.asker_id == live->asker_id &&
           news->answer.asker.request_id == live->request_id;
}

/// Begins to show a flight whose plan was heard. @return false if there is none such.
static bool begin_flight(live_t* live, const lcm_ssv_execution_t* news) {
    const record_task_t* const plan = plan_of(live, news);
    if (plan == NULL || news->state == LCM_SSV_EXECUTION_T_STATE_ENDED) return false;
    make_room(live, plan);
    record_flight_t* const flight = calloc(1, sizeof *flight);
    if (flight == NULL || !show_plan(live, plan)) {
        free(flight);
        return false;
    }
    flown_begin(&flight->track);
    current(live)->flight = flight;
    live->flies = true;
    live->asker_id = news->answer.asker.asker_id;
    live->request_id = news->answer.asker.request_id;
    return true;
}

/// Takes news of the flight that is shown. @return whether they are new; then they are kept.
static bool note_news(live_t* live, const lcm_ssv_execution_t* news, bool begins) {
    record_flight_t* const flight = current(live)->flight;
    if (!begins && news->sequence <= flight->end.sequence) return false;
    if (!flown_note_execution(&flight->track, news)) return false;
    wire_clear("execution_t", &flight->end);
    flight->end = *news;
    live->flies = news->state != LCM_SSV_EXECUTION_T_STATE_ENDED;
    live->told_s = live->now_s;
    return true;
}

static json_t* take_execution(live_t* live, const void* data, size_t size) {
    lcm_ssv_execution_t news;
    if (!wire_decode("execution_t", data, size, &news)) return refuse(live);
    if (!is_sound(&news)) {
        wire_clear("execution_t", &news);
        return refuse(live);
    }
    const bool begins = !is_current(live, &news) && !flies_now(live) && begin_flight(live, &news);
    if (is_current(live, &news)) {
        if (note_news(live, &news, begins)) {
            json_t* const event = begins ? picture_event(live) : json_pack("{s:s}", "kind", "execution");
            if (event != NULL) json_object_set_new(event, "execution", execution_json(&news));
            return event;
        }
        wire_clear("execution_t", &news);
        return NULL;
    }
    json_t* event = NULL;
    if (!flies_now(live) && news.state != LCM_SSV_EXECUTION_T_STATE_ENDED)
        event = json_pack("{s:s,s:o}", "kind", "unknown", "execution", execution_json(&news));
    wire_clear("execution_t", &news);
    return event;
}

static json_t* take_state(live_t* live, bool is_truth, const void* data, size_t size) {
    lcm_ssv_vehicle_state_t state;
    if (!wire_decode("vehicle_state_t", data, size, &state)) return refuse(live);
    record_task_t* const task = current(live);
    if (task == NULL || task->flight == NULL || state.plan_hash == 0 || state.plan_hash != task->flight->end.plan_hash)
        return NULL;
    flown_t* const flown = &task->flight->track;
    if (!(is_truth ? flown_note_truth : flown_note_estimate)(flown, &state)) return NULL;
    if (!flown->has_started) return NULL;
    return picture_row(live->track, flown, &state, is_truth);
}

static json_t* take_status(live_t* live, const void* data, size_t size) {
    lcm_ssv_planner_status_t status;
    if (!wire_decode("planner_status_t", data, size, &status)) return refuse(live);
    int i = 0;
    while (i < live->num_planners && live->planner[i].planner.planner_id != status.planner.planner_id) i++;
    if (i == PLANNERS) i = 0; // more than anybody looks at
    if (i == live->num_planners) live->num_planners++;
    wire_clear("planner_status_t", &live->planner[i]);
    live->planner[i] = status;
    return json_pack("{s:s,s:o}", "kind", "planners", "planners", planners_json(live));
}

json_t* live_take(live_t* live, const char* channel, const void* data, size_t size, double now_s) {
    live->taken++;
    live->now_s = now_s;
    if (strcmp(channel, CHANNEL_SCENARIO) == 0 || strcmp(channel, CHANNEL_EXECUTE) == 0)
        return take_question(live, data, size);
    if (strcmp(channel, CHANNEL_PLAN) == 0) return take_plan(live, data, size);
    if (strcmp(channel, CHANNEL_EXECUTION) == 0) return take_execution(live, data, size);
    if (strcmp(channel, CHANNEL_STATE) == 0) return take_state(live, false, data, size);
    if (strcmp(channel, CHANNEL_TRUTH) == 0) return take_state(live, true, data, size);
    if (strcmp(channel, CHANNEL_STATUS) == 0) return take_status(live, data, size);
    return NULL;
}

void live_counts(const live_t* live, long* taken, long* refused) {
    *taken = live->taken;
    *refused = live->refused;
}
