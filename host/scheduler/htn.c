// Depth-first branch and bound over the decompositions of a task network.
#include "htn.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/// What was proved about a state: what is left to do costs no less.
typedef struct {
    unsigned char key[HTN_MAX_KEY];
    double bound;
    bool used;
} memory_t;

typedef struct {
    const htn_domain_t* domain;
    void* state;
    const htn_limits_t* limits;
    htn_step_t* trail; ///< what is begun on the way to where the search is
    int depth;
    memory_t* memories;
    size_t room; ///< for memories, a power of two or 0
    bool stopped, out_of_memory;
    htn_result_t result;
} search_t;

static uint64_t hash_of(const unsigned char key[HTN_MAX_KEY]) {
    uint64_t hash = 14695981039346656037u;
    for (int i = 0; i < HTN_MAX_KEY; i++) {
        hash = (hash ^ key[i]) * 1099511628211u;
    }
    return hash ^ (hash >> 32);
}

/// Where the key is in the table, or would be; the table has room.
static memory_t* slot_of(memory_t* memories, size_t room, const unsigned char key[HTN_MAX_KEY]) {
    size_t i = (size_t)hash_of(key) & (room - 1);
    while (memories[i].used && memcmp(memories[i].key, key, HTN_MAX_KEY) != 0) {
        i = (i + 1) & (room - 1);
    }
    return &memories[i];
}

static bool grow(search_t* search) {
    const size_t room = search->room == 0 ? 1024 : 2 * search->room;
    memory_t* const memories = calloc(room, sizeof *memories);
    if (memories == NULL) return false;
    for (size_t i = 0; i < search->room; i++) {
        if (search->memories[i].used) *slot_of(memories, room, search->memories[i].key) = search->memories[i];
    }
    free(search->memories);
    search->memories = memories;
    search->room = room;
    return true;
}

static void remember(search_t* search, const unsigned char key[HTN_MAX_KEY], double bound) {
    const size_t most = search->limits->max_memories;
    memory_t* memory = search->room == 0 ? NULL : slot_of(search->memories, search->room, key);
    const bool is_new = memory == NULL || !memory->used;
    if (is_new) {
        if (most != 0 && search->result.memories >= most) return;
        if (2 * (search->result.memories + 1) > search->room && !grow(search)) return; // it is searched again
        memory = slot_of(search->memories, search->room, key);
        memcpy(memory->key, key, HTN_MAX_KEY);
        memory->used = true;
        memory->bound = bound;
        search->result.memories++;
    }
    memory->bound = fmax(memory->bound, bound);
}

static double recall(const search_t* search, const unsigned char key[HTN_MAX_KEY]) {
    const memory_t* const memory = search->room == 0 ? NULL : slot_of(search->memories, search->room, key);
    return memory != NULL && memory->used ? memory->bound : 0;
}

static double cost_of(const htn_plan_t* plan) { return plan->steps == NULL ? (double)INFINITY : plan->cost; }

/// What a plan must cost less than to be of interest.
static double best(const search_t* search) {
    if (search->limits->all) return INFINITY;
    const double most = search->limits->most > 0 ? search->limits->most : (double)INFINITY;
    return fmin(most, cost_of(&search->result.plan));
}

/// Tells the way to where the search is, and keeps it if it is the best plan.
static void keep(search_t* search, double cost) {
    const size_t size = (size_t)search->depth * sizeof(htn_step_t);
    const htn_plan_t plan = {search->depth, malloc(size > 0 ? size : 1), cost};
    const bool is_best = cost < cost_of(&search->result.plan);
    if (plan.steps == NULL) {
        search->out_of_memory = search->stopped = true;
        return;
    }
    if (size > 0) memcpy(plan.steps, search->trail, size);
    if (search->limits->found != NULL && !search->limits->found(search->limits->context, &plan)) {
        search->stopped = true;
    }
    free(is_best ? search->result.plan.steps : plan.steps);
    if (is_best) search->result.plan = plan;
}

static bool must_stop(search_t* search) {
    const htn_limits_t* limits = search->limits;
    if (limits->max_nodes != 0 && search->result.nodes >= limits->max_nodes) search->stopped = true;
    if (limits->stop != NULL && limits->stop(limits->context)) search->stopped = true;
    return search->stopped;
}

static double explore(search_t* search, const htn_agenda_t* agenda, double spent);

static double do_primitive(search_t* search, const htn_agenda_t* agenda, double spent) {
    const htn_domain_t* domain = search->domain;
    _Alignas(max_align_t) unsigned char undo[HTN_MAX_UNDO];
    double cost = 0;
    if (!domain->apply(search->state, &agenda->task, undo, &cost)) return INFINITY;
    search->trail[search->depth++] = (htn_step_t){agenda->task, agenda->level, -1, cost};
    const double rest = explore(search, agenda->rest, spent + cost);
    search->depth--;
    domain->undo(search->state, &agenda->task, undo);
    return cost + rest;
}

static double do_method(search_t* search, const htn_agenda_t* agenda, int method, const htn_subtasks_t* subtasks,
                        double spent) {
    htn_agenda_t cells[HTN_MAX_SUBTASKS];
    const htn_agenda_t* next = agenda->rest;
    for (int i = subtasks->count - 1; i >= 0; i--) {
        cells[i] = (htn_agenda_t){subtasks->task[i], agenda->level + 1, next};
        next = &cells[i];
    }
    search->trail[search->depth++] = (htn_step_t){agenda->task, agenda->level, method, 0};
    const double rest = explore(search, next, spent);
    search->depth--;
    return rest;
}

static double do_compound(search_t* search, const htn_agenda_t* agenda, double spent) {
    double least = INFINITY;
    for (int m = 0; m < search->domain->kinds[agenda->task.kind].num_methods && !search->stopped; m++) {
        htn_subtasks_t subtasks;
        for (int n = 0; !search->stopped; n++) {
            subtasks.count = 0;
            const htn_binding_t binding = search->domain->method(search->state, &agenda->task, m, n, &subtasks);
            if (binding == HTN_NO_MORE) break;
            if (binding == HTN_BOUND) least = fmin(least, do_method(search, agenda, m, &subtasks, spent));
        }
    }
    return least;
}

/// Looks for a plan for the agenda that is better, in all, than the best one so far. @return what the agenda costs at
/// least, as far as this proved it: every plan for it is kept, or is no better than what the search has. Its depth is
/// that of the trail.
static double explore(search_t* search, const htn_agenda_t* agenda, double spent) {
    const htn_domain_t* domain = search->domain;
    unsigned char key[HTN_MAX_KEY] = {0};
    if (agenda == NULL) {
        if (spent < best(search)) keep(search, spent);
        return 0;
    }
    double bound = domain->bound == NULL ? 0 : domain->bound(search->state, agenda);
    if (spent + bound >= best(search)) return bound;
    const bool has_key =
        !search->limits->all && domain->memory_key != NULL && domain->memory_key(search->state, agenda, key);
    if (has_key) {
        bound = fmax(bound, recall(search, key));
        if (spent + bound >= best(search)) {
            search->result.recalled++;
            return bound;
        }
    }
    if (must_stop(search)) return bound;
    if (search->depth >= HTN_MAX_DEPTH) {
        search->stopped = true;
        return bound;
    }
    search->result.nodes++;
    const double proved = domain->kinds[agenda->task.kind].num_methods == 0 ? do_primitive(search, agenda, spent)
                                                                            : do_compound(search, agenda, spent);
    if (search->stopped) return bound;
    bound = fmax(bound, proved);
    if (has_key) remember(search, key, bound);
    return bound;
}

htn_result_t htn_search(const htn_domain_t* domain, void* state, const htn_task_t* tasks, int num_tasks,
                        const htn_limits_t* limits) {
    search_t search = {.domain = domain, .state = state, .limits = limits};
    htn_agenda_t* const cells = calloc((size_t)num_tasks + 1, sizeof *cells);
    search.trail = calloc(HTN_MAX_DEPTH, sizeof *search.trail);
    search.result.status = HTN_NO_MEMORY;
    if (cells != NULL && search.trail != NULL) {
        for (int i = 0; i < num_tasks; i++) {
            cells[i] = (htn_agenda_t){tasks[i], 0, i + 1 < num_tasks ? &cells[i + 1] : NULL};
        }
        const double bound = explore(&search, num_tasks > 0 ? cells : NULL, 0);
        search.result.lower_bound = search.stopped ? fmin(bound, best(&search)) : best(&search);
        search.result.status = search.out_of_memory               ? HTN_NO_MEMORY
                               : search.stopped                   ? HTN_STOPPED
                               : search.result.plan.steps != NULL ? HTN_OPTIMAL
                                                                  : HTN_NO_PLAN;
    }
    free(cells);
    free(search.trail);
    free(search.memories);
    return search.result;
}
