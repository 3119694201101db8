#include "record.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ssv/check.h"
#include "wire/message.h"
#include "wire/tree.h"

/// Most tasks of an assembly.
#define TASKS_MAX 256

static bool read_message(const tree_t* within, const char* key, const char* type, void* message, tree_error_t* error) {
    const tree_t* const part = tree_get(within, key);
    if (part == NULL) return tree_fail_key(error, within, NULL, key, "this key is missing");
    return wire_from_tree(type, part, message, error);
}

void record_task_free(record_task_t* task) {
    if (task->flight != NULL) wire_clear("execution_t", &task->flight->end);
    free(task->flight);
    wire_clear("plan_t", &task->plan);
    memset(task, 0, sizeof *task); // a question points to nothing
}

static void copy_text(const tree_t* value, char* text, size_t size) {
    if (value == NULL || value->kind == TREE_NULL || value->text == NULL) return;
    snprintf(text, size, "%s", value->text);
    tree_make_harmless(text);
}

/// A number that a map holds by this key, 0 if it holds none.
static double number_of(const tree_t* map, const char* key) {
    const tree_t* const value = map == NULL ? NULL : tree_get(map, key);
    const bool is_number = value != NULL && (value->kind == TREE_REAL || value->kind == TREE_INTEGER);
    return is_number && isfinite(value->real) ? value->real : 0;
}

static void read_attempt(const tree_t* truth, const char* key, record_attempt_t* attempt) {
    const tree_t* const from = truth == NULL ? NULL : tree_get(truth, key);
    if (from == NULL || number_of(from, "attempts") == 0) return;
    copy_text(tree_get(from, "outcome"), attempt->outcome, sizeof attempt->outcome);
    attempt->position_m = number_of(from, "position_m");
    attempt->angle_rad = number_of(from, "angle_rad");
    attempt->speed_m_s = number_of(from, "speed_m_s");
}

/// What `ssv fly` tells beside the track. What is missing of it is not shown.
static void read_legs(const tree_t* from, record_flight_t* flight) {
    const tree_t* const legs = tree_get(from, "legs");
    for (int i = 0; legs != NULL && legs->kind == TREE_LIST && i < legs->count && i < SSV_MAX_LEGS; i++) {
        const tree_t* const flown = tree_get(legs->entries[i].value, "flown");
        flight->leg[i] = (record_leg_t){flown != NULL && flown->kind == TREE_MAP, number_of(flown, "time_s"),
                                        number_of(flown, "wait_s"), number_of(flown, "impulse_Ns")};
    }
}

static bool read_flight(const tree_t* from, record_task_t* task, tree_error_t* error) {
    const tree_t *const flown = tree_get(from, "flown"), *const simulation = tree_get(from, "simulation");
    if (flown == NULL) return true;
    record_flight_t* const flight = calloc(1, sizeof *flight);
    task->flight = flight;
    if (flight == NULL) return tree_fail(error, from, "out of memory");
    if (!flown_from_tree(flown, &flight->track, error) ||
        !read_message(from, "execution", "execution_t", &flight->end, error)) {
        return false;
    }
    tree_make_harmless(flight->end.reason);
    tree_make_harmless(flight->end.text);
    read_legs(from, flight);
    if (simulation == NULL) return true;
    copy_text(tree_get(simulation, "conditions"), flight->conditions, sizeof flight->conditions);
    copy_text(tree_get(simulation, "seed"), flight->seed, sizeof flight->seed);
    read_attempt(tree_get(simulation, "truth"), "mate", &flight->mate);
    read_attempt(tree_get(simulation, "truth"), "dock", &flight->dock);
    return true;
}

/// @return false with the error set and nothing to free.
static bool read_task(const tree_t* from, int number, record_task_t* task, tree_error_t* error) {
    const tree_t* const name = tree_get(from, "name");
    memset(task, 0, sizeof *task);
    snprintf(task->name, sizeof task->name, "task %d", number + 1);
    copy_text(name, task->name, sizeof task->name);
    // A refusal comes without its question, so the plan is looked at first.
    if (!read_message(from, "plan", "plan_t", &task->plan, error)) return false;
    tree_make_harmless(task->plan.quote.reason);
    tree_make_harmless(task->plan.answer.planner.version);
    if (task->plan.quote.status != LCM_SSV_QUOTE_T_STATUS_OK) {
        tree_fail(error, tree_get(from, "plan"), "there is no plan to show: %.300s", task->plan.quote.reason);
        record_task_free(task);
        return false;
    }
    if (!read_message(from, "scenario", "scenario_t", &task->question.scenario, error) ||
        !read_message(from, "scene", "scene_t", &task->question.scene, error) || !read_flight(from, task, error)) {
        record_task_free(task);
        return false;
    }
    if (ssv_check_plan(&task->question, &task->plan, task->breach)) task->breach[0] = '\0';
    return true;
}

static bool read_tasks(const tree_t* root, record_t* record, tree_error_t* error) {
    const tree_t* const tasks = tree_get(root, "tasks");
    const int count = tasks == NULL ? 1 : tasks->count;
    if (tasks != NULL && (tasks->kind != TREE_LIST || count < 1 || count > TASKS_MAX))
        return tree_fail(error, tasks, "must be a list of 1 to %d tasks", TASKS_MAX);
    record->tasks = calloc((size_t)count, sizeof *record->tasks);
    if (record->tasks == NULL) return tree_fail(error, root, "out of memory");
    for (; record->count < count; record->count++) {
        const tree_t* const from = tasks == NULL ? root : tasks->entries[record->count].value;
        if (!read_task(from, record->count, &record->tasks[record->count], error)) return false;
    }
    return true;
}

bool record_read(const char* path, record_t* record, char* error_text, size_t error_size) {
    const char* const file = strcmp(path, "-") == 0 ? "standard input" : path;
    const char* const slash = strrchr(file, '/');
    tree_memory_t memory = {NULL};
    tree_error_t error = {error_text, error_size};
    size_t size = 0;
    error_text[0] = '\0';
    *record = (record_t){.count = 0};
    snprintf(record->title, sizeof record->title, "%s", slash == NULL ? file : slash + 1);
    tree_make_harmless(record->title);
    char* const text = tree_file_read(path, &size, &error);
    const tree_t* const root = text == NULL ? NULL : tree_from_json(&memory, &error, file, text, size);
    const bool sound = root != NULL && read_tasks(root, record, &error);
    if (!sound) record_free(record);
    tree_memory_free(&memory);
    free(text);
    return sound;
}

void record_free(record_t* record) {
    for (int i = 0; i < record->count; i++) record_task_free(&record->tasks[i]);
    free(record->tasks);
    *record = (record_t){.count = 0};
}
