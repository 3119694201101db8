// Threads that ask the planner, and what it said.
#define _POSIX_C_SOURCE 200809L
#include "pricing.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ssv/answer.h"
#include "ssv/check.h"
#include "wire/message.h"

#define THREADS_MAX 64

/// Of the cache's prices the first so many are priced anew, and then every so manyth.
#define CHECKED_FIRST 8
#define CHECKED_EVERY 64

/// A pose in whole steps.
typedef struct {
    int64_t step[7];
} pose_steps_t;

/// A question as it stands in the table: no padding, and all zero where there is none.
typedef struct {
    set_t built;
    int32_t pose, left, beam, slot;
} key_t;

typedef struct {
    key_t key;
    assembly_price_t price;
    bool used;
    uint64_t asked; ///< the call that asks for it, while it has no price
} entry_t;

/// One that is asked now.
typedef struct {
    assembly_question_t question;
    uint64_t hash;
    bool is_kept, is_checked, is_wrong; ///< of what the cache has
    bool feasible;
    double cost, time_s, impulse_Ns;
    pose_steps_t end;
} work_t;

struct pricing {
    const structure_t* structure;
    lcm_ssv_scene_t wire_scene;
    ssv_scene_t scene; ///< the same
    pose_steps_t* poses;
    int num_poses, room_poses;
    entry_t* entries;
    size_t num_entries, room;
    uint64_t calls; ///< of pricing_ask
    cache_t* cache; ///< or NULL
    bool is_cache_wrong;
    work_t* works;
    int num_works, room_works;
    pricing_counts_t counts;
    bool (*ask)(void* context, const lcm_ssv_task_t* tasks, int count, lcm_ssv_quote_t* quotes); ///< NULL: in process
    void* context;
    int num_threads; ///< beside this one
    pthread_t thread[THREADS_MAX];
    pthread_mutex_t lock;
    pthread_cond_t begun, ended;
    uint64_t round; ///< of questions, this and the next three under the lock
    int busy;
    bool closing;
    atomic_int next; ///< work that nobody has taken yet
};

// ---- Poses ----------------------------------------------------------------------------------------------------------

static pose_steps_t steps_of(const double p[3], const double q[4]) {
    pose_steps_t steps;
    int sign = 0;
    for (int i = 0; i < 7; i++) steps.step[i] = llround((i < 3 ? p[i] : q[i - 3]) * PRICING_STEPS);
    for (int i = 3; i < 7 && sign == 0; i++) sign = (steps.step[i] > 0) - (steps.step[i] < 0);
    for (int i = 3; i < 7; i++) steps.step[i] *= sign;
    return steps;
}

/// The pose's number; it gets the next one if it is new. @return -1 if out of memory.
static int number_of(pricing_t* pricing, const pose_steps_t* steps) {
    for (int i = 0; i < pricing->num_poses; i++) {
        if (memcmp(&pricing->poses[i], steps, sizeof *steps) == 0) return i;
    }
    if (pricing->num_poses == pricing->room_poses) {
        const int room = pricing->room_poses == 0 ? 256 : 2 * pricing->room_poses;
        pose_steps_t* const larger = realloc(pricing->poses, (size_t)room * sizeof *larger);
        if (larger == NULL) return -1;
        pricing->poses = larger;
        pricing->room_poses = room;
    }
    pricing->poses[pricing->num_poses] = *steps;
    return pricing->num_poses++;
}

// ---- Questions ------------------------------------------------------------------------------------------------------

lcm_ssv_scenario_t pricing_scenario(const pricing_t* pricing, const assembly_question_t* question) {
    const structure_t* const structure = pricing->structure;
    const structure_beam_t* const beam = &structure->beam[question->beam];
    const structure_slot_t* const slot = &structure->slot[question->slot];
    const structure_port_t* const port = &structure->hub[slot->hub[0]].port[slot->port[0]];
    const int64_t* const step = pricing->poses[question->pose].step;
    lcm_ssv_scenario_t s = structure->task;
    for (int i = 0; i < 3; i++) s.X_IS.p_m[i] = (double)step[i] / PRICING_STEPS;
    for (int i = 0; i < 4; i++) s.X_IS.q[i] = (double)step[3 + i] / PRICING_STEPS;
    memcpy(s.X_IB.p_m, beam->p_IB_m, sizeof s.X_IB.p_m);
    memcpy(s.X_IB.q, beam->q_IB, sizeof s.X_IB.q);
    memcpy(s.port.p_IP_m, port->p_IP_m, sizeof s.port.p_IP_m);
    memcpy(s.port.axis_I, port->axis_I, sizeof s.port.axis_I);
    if (structure->obstacles) {
        const int num_hubs = structure->num_hubs;
        s.obstacles = (int64_t)(((UINT64_C(1) << num_hubs) - 1) | (uint64_t)question->built << num_hubs);
        s.left = question->left < 0 ? 0 : (int64_t)(UINT64_C(1) << (num_hubs + question->left));
    }
    return s;
}

static void make_scene(pricing_t* pricing) {
    const structure_t* const structure = pricing->structure;
    lcm_ssv_scene_t* const scene = &pricing->wire_scene;
    for (int h = 0; h < structure->num_hubs && structure->obstacles; h++) {
        lcm_ssv_obstacle_t* const hub = &scene->obstacles[scene->num_obstacles++];
        hub->kind = LCM_SSV_OBSTACLE_T_KIND_CAPSULE;
        memcpy(hub->p_I_m, structure->hub[h].p_IH_m, sizeof hub->p_I_m);
        hub->radius_m = structure->hub[h].radius_m;
    }
    for (int i = 0; i < structure->num_slots && structure->obstacles; i++) {
        const structure_slot_t* const slot = &structure->slot[i];
        const structure_port_t* const at = (structure->stands >> i & 1) != 0
                                               ? &structure->stands_at[i]
                                               : &structure->hub[slot->hub[0]].port[slot->port[0]];
        lcm_ssv_obstacle_t* const beam = &scene->obstacles[scene->num_obstacles++];
        beam->kind = LCM_SSV_OBSTACLE_T_KIND_CAPSULE;
        memcpy(beam->p_I_m, at->p_IP_m, sizeof beam->p_I_m);
        memcpy(beam->axis_I, at->axis_I, sizeof beam->axis_I);
        beam->length_m = structure->task.beam.length_m;
        beam->radius_m = structure->task.beam.radius_m;
    }
    ssv_scene_from_wire(&pricing->scene, scene);
}

static lcm_ssv_task_t task_of(const pricing_t* pricing, const assembly_question_t* question) {
    const lcm_ssv_task_t task = {.scenario = pricing_scenario(pricing, question), .scene = pricing->wire_scene};
    return task;
}

const lcm_ssv_scene_t* pricing_scene(const pricing_t* pricing) { return &pricing->wire_scene; }

bool pricing_check(const pricing_t* pricing, char* error, size_t error_size) {
    const assembly_question_t first = {.left = -1};
    const lcm_ssv_scenario_t wire = pricing_scenario(pricing, &first);
    ssv_scenario_t scenario;
    ssv_problem_t problem;
    ssv_fault_t fault;
    ssv_scenario_from_wire(&scenario, &wire, &pricing->scene);
    if (ssv_problem_init(&problem, &scenario, &fault) == SSV_OK) return true;
    snprintf(error, error_size, "%s: %.9g: %s", fault.field, real_to_double(fault.value), ssv_status_str(fault.status));
    return false;
}

static void price(const pricing_t* pricing, ssv_work_t* memory, work_t* work) {
    const lcm_ssv_scenario_t wire = pricing_scenario(pricing, &work->question);
    ssv_scenario_t scenario;
    ssv_problem_t problem;
    ssv_fault_t fault;
    ssv_quote_t quote;
    ssv_scenario_from_wire(&scenario, &wire, &pricing->scene);
    work->feasible =
        ssv_problem_init(&problem, &scenario, &fault) == SSV_OK && ssv_quote(&problem, memory, &quote) == SSV_OK;
    if (!work->feasible) return;
    work->cost = real_to_double(quote.cost);
    work->time_s = real_to_double(quote.time_s);
    work->impulse_Ns = real_to_double(quote.impulse_Ns);
    const pose_t X = quote.X_IS_final;
    const double p_m[3] = {real_to_double(X.p.x), real_to_double(X.p.y), real_to_double(X.p.z)};
    const double q[4] = {real_to_double(X.q.w), real_to_double(X.q.x), real_to_double(X.q.y), real_to_double(X.q.z)};
    work->end = steps_of(p_m, q);
}

/// Prices it again if that is wanted of what the cache has.
static void price_or_check(const pricing_t* pricing, ssv_work_t* memory, work_t* work) {
    if (!work->is_kept) {
        price(pricing, memory, work);
    } else if (work->is_checked) {
        work_t again = {.question = work->question};
        price(pricing, memory, &again);
        work->is_wrong = again.feasible != work->feasible || again.cost != work->cost || again.time_s != work->time_s ||
                         again.impulse_Ns != work->impulse_Ns || memcmp(&again.end, &work->end, sizeof again.end) != 0;
    }
}

/// Has what the cache does not have priced elsewhere.
static bool price_elsewhere(pricing_t* pricing) {
    const size_t most = (size_t)pricing->num_works;
    lcm_ssv_task_t* const tasks = calloc(most, sizeof *tasks);
    lcm_ssv_quote_t* const quotes = calloc(most, sizeof *quotes);
    ssv_work_t memory;
    int count = 0, next = 0;
    bool sound = tasks != NULL && quotes != NULL;
    for (size_t i = 0; i < most && sound; i++) {
        if (pricing->works[i].is_kept) {
            price_or_check(pricing, &memory, &pricing->works[i]);
        } else {
            tasks[count++] = task_of(pricing, &pricing->works[i].question);
        }
    }
    sound = sound && (count == 0 || pricing->ask(pricing->context, tasks, count, quotes));
    for (size_t i = 0; i < most && sound; i++) {
        work_t* const work = &pricing->works[i];
        if (work->is_kept) continue;
        lcm_ssv_quote_t* const quote = &quotes[next++];
        work->feasible = quote->status == LCM_SSV_QUOTE_T_STATUS_OK;
        work->cost = quote->cost;
        work->time_s = quote->time_s;
        work->impulse_Ns = quote->impulse_Ns;
        work->end = steps_of(quote->X_IS_final.p_m, quote->X_IS_final.q);
        wire_clear("quote_t", quote);
    }
    free(tasks);
    free(quotes);
    return sound;
}

/// Takes work until there is none.
static void price_all(pricing_t* pricing, ssv_work_t* memory) {
    for (int i = atomic_fetch_add(&pricing->next, 1); i < pricing->num_works; i = atomic_fetch_add(&pricing->next, 1)) {
        price_or_check(pricing, memory, &pricing->works[i]);
    }
}

static void* run(void* context) {
    pricing_t* const pricing = context;
    ssv_work_t memory;
    uint64_t seen = 0;
    pthread_mutex_lock(&pricing->lock);
    for (;;) {
        while (pricing->round == seen && !pricing->closing) pthread_cond_wait(&pricing->begun, &pricing->lock);
        if (pricing->closing) break;
        seen = pricing->round;
        pthread_mutex_unlock(&pricing->lock);
        price_all(pricing, &memory);
        pthread_mutex_lock(&pricing->lock);
        if (--pricing->busy == 0) pthread_cond_signal(&pricing->ended);
    }
    pthread_mutex_unlock(&pricing->lock);
    return NULL;
}

/// Has all threads price what is to be priced, and waits for them.
static void price_together(pricing_t* pricing) {
    ssv_work_t memory;
    atomic_store(&pricing->next, 0);
    pthread_mutex_lock(&pricing->lock);
    pricing->round++;
    pricing->busy = pricing->num_threads;
    pthread_cond_broadcast(&pricing->begun);
    pthread_mutex_unlock(&pricing->lock);
    price_all(pricing, &memory); // this thread is one of them
    pthread_mutex_lock(&pricing->lock);
    while (pricing->busy > 0) pthread_cond_wait(&pricing->ended, &pricing->lock);
    pthread_mutex_unlock(&pricing->lock);
}

// ---- The table ------------------------------------------------------------------------------------------------------

static key_t key_of(const assembly_question_t* question) {
    const key_t key = {question->built, question->pose, question->left, question->beam, question->slot};
    return key;
}

static entry_t* place_of(entry_t* entries, size_t room, const key_t* key) {
    uint64_t hash = (uint64_t)key->built * 0x9e3779b97f4a7c15u;
    hash = (hash ^ (uint64_t)(key->built >> 64)) * 0x9e3779b97f4a7c15u;
    hash = (hash ^ (uint32_t)key->pose) * 0x9e3779b97f4a7c15u;
    hash = (hash ^ (uint32_t)key->left) * 0x9e3779b97f4a7c15u;
    hash = (hash ^ (uint32_t)(key->beam * STRUCTURE_MAX_SLOTS + key->slot)) * 0x9e3779b97f4a7c15u;
    size_t i = (size_t)(hash >> 20) & (room - 1);
    while (entries[i].used && memcmp(&entries[i].key, key, sizeof *key) != 0) i = (i + 1) & (room - 1);
    return &entries[i];
}

/// Room for so many more, at most half of the table being in use.
static bool make_room(pricing_t* pricing, int count) {
    size_t room = pricing->room == 0 ? 4096 : pricing->room;
    while (2 * (pricing->num_entries + (size_t)count) > room) room *= 2;
    if (room != pricing->room) {
        entry_t* const entries = calloc(room, sizeof *entries);
        if (entries == NULL) return false;
        for (size_t i = 0; i < pricing->room; i++) {
            if (pricing->entries[i].used) *place_of(entries, room, &pricing->entries[i].key) = pricing->entries[i];
        }
        free(pricing->entries);
        pricing->entries = entries;
        pricing->room = room;
    }
    if (count > pricing->room_works) {
        work_t* const works = realloc(pricing->works, (size_t)count * sizeof *works);
        if (works == NULL) return false;
        pricing->works = works;
        pricing->room_works = count;
    }
    return true;
}

// ---- The cache ------------------------------------------------------------------------------------------------------

void pricing_use(pricing_t* pricing, cache_t* cache) { pricing->cache = cache; }

bool pricing_is_cache_wrong(const pricing_t* pricing) { return pricing->is_cache_wrong; }

/// Takes from the cache what it has.
static void look_up(pricing_t* pricing, work_t* work) {
    const lcm_ssv_task_t task = task_of(pricing, &work->question);
    work->hash = ssv_task_question_hash(&task);
    const cache_price_t* const kept = cache_find(pricing->cache, work->hash);
    if (kept == NULL) return;
    work->is_kept = true;
    work->is_checked = pricing->counts.kept < CHECKED_FIRST || pricing->counts.kept % CHECKED_EVERY == 0;
    work->feasible = kept->feasible;
    work->cost = kept->cost;
    work->time_s = kept->time_s;
    work->impulse_Ns = kept->impulse_Ns;
    memcpy(work->end.step, kept->end, sizeof work->end.step);
    pricing->counts.kept++;
}

static bool keep(pricing_t* pricing, const work_t* work) {
    cache_price_t price = {work->hash, work->feasible, work->cost, work->time_s, work->impulse_Ns, {0}};
    memcpy(price.end, work->end.step, sizeof price.end);
    return cache_add(pricing->cache, &price);
}

// ---- Asking ---------------------------------------------------------------------------------------------------------

/// Puts what is priced now where it is found again. @return false if out of memory.
static bool remember(pricing_t* pricing, const work_t* work) {
    const key_t key = key_of(&work->question);
    entry_t* const entry = place_of(pricing->entries, pricing->room, &key);
    const int end = work->feasible ? number_of(pricing, &work->end) : 0;
    if (end < 0 || (pricing->cache != NULL && !work->is_kept && !keep(pricing, work))) return false;
    *entry = (entry_t){key, {work->feasible, work->cost, work->time_s, work->impulse_Ns, end}, true, 0};
    pricing->counts.asked += !work->is_kept;
    return true;
}

bool pricing_ask(void* context, const assembly_question_t* questions, int count, assembly_price_t* prices) {
    pricing_t* const pricing = context;
    if (!make_room(pricing, count)) return false;
    pricing->calls++;
    pricing->num_works = 0;
    for (int i = 0; i < count; i++) {
        const key_t key = key_of(&questions[i]);
        entry_t* const entry = place_of(pricing->entries, pricing->room, &key);
        const bool is_known = entry->used && entry->asked == 0;
        pricing->counts.known += is_known;
        if (is_known || entry->asked == pricing->calls) continue;
        work_t* const work = &pricing->works[pricing->num_works++];
        *work = (work_t){.question = questions[i]};
        if (pricing->cache != NULL) look_up(pricing, work);
        pricing->num_entries += !entry->used;
        *entry = (entry_t){.key = key, .used = true, .asked = pricing->calls};
    }
    if (pricing->num_works > 0 && pricing->ask != NULL && !price_elsewhere(pricing)) return false;
    if (pricing->num_works > 0 && pricing->ask == NULL) price_together(pricing);
    for (int k = 0; k < pricing->num_works; k++) {
        const work_t* const work = &pricing->works[k];
        pricing->is_cache_wrong = pricing->is_cache_wrong || work->is_wrong;
        if (pricing->is_cache_wrong || !remember(pricing, work)) return false;
    }
    for (int i = 0; i < count; i++) {
        const key_t key = key_of(&questions[i]);
        prices[i] = place_of(pricing->entries, pricing->room, &key)->price;
    }
    return true;
}

pricing_counts_t pricing_counts(const pricing_t* pricing) {
    pricing_counts_t counts = pricing->counts;
    counts.poses = pricing->num_poses;
    counts.threads = pricing->ask != NULL ? 0 : pricing->num_threads + 1;
    return counts;
}

// ---- Open and close -------------------------------------------------------------------------------------------------

pricing_t* pricing_open(const structure_t* structure, int threads) {
    pricing_t* const pricing = calloc(1, sizeof *pricing);
    if (pricing == NULL) return NULL;
    pricing->structure = structure;
    make_scene(pricing);
    pthread_mutex_init(&pricing->lock, NULL);
    pthread_cond_init(&pricing->begun, NULL);
    pthread_cond_init(&pricing->ended, NULL);
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    const int wanted = threads > 0 ? threads : cores < 1 ? 1 : cores > THREADS_MAX ? THREADS_MAX : (int)cores;
    const pose_steps_t start = steps_of(structure->p_IS_m, structure->q_IS);
    bool sound = number_of(pricing, &start) == 0;
    while (sound && pricing->num_threads < wanted - 1) {
        sound = pthread_create(&pricing->thread[pricing->num_threads], NULL, run, pricing) == 0;
        pricing->num_threads += sound;
    }
    if (!sound) {
        pricing_close(pricing);
        return NULL;
    }
    return pricing;
}

pricing_t* pricing_open_elsewhere(const structure_t* structure,
                                  bool (*ask)(void* context, const lcm_ssv_task_t* tasks, int count,
                                              lcm_ssv_quote_t* quotes),
                                  void* context) {
    pricing_t* const pricing = pricing_open(structure, 1);
    if (pricing == NULL) return NULL;
    pricing->ask = ask;
    pricing->context = context;
    return pricing;
}

void pricing_close(pricing_t* pricing) {
    pthread_mutex_lock(&pricing->lock);
    pricing->closing = true;
    pthread_cond_broadcast(&pricing->begun);
    pthread_mutex_unlock(&pricing->lock);
    for (int i = 0; i < pricing->num_threads; i++) pthread_join(pricing->thread[i], NULL);
    pthread_mutex_destroy(&pricing->lock);
    pthread_cond_destroy(&pricing->begun);
    pthread_cond_destroy(&pricing->ended);
    free(pricing->poses);
    free(pricing->entries);
    free(pricing->works);
    free(pricing);
}
