// The domain of assembly: tasks, state, operators and methods.
#include "assembly.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bound.h"
#include "estimate.h"
#include "stages.h"

/// A price among obstacles is sought down to this share of the least one past the hubs alone: what stands makes the
/// planner look at more ways, and seldom it finds a better one.
#define FIRST_SHARE 0.9
/// In how many steps it is proved that nothing is better; what one has proved holds if the next is not done in time.
#define PASSES 5

/// How many ways are carried on together at most before the search that may prove something, or else in all; and how
/// many parts of each are priced.
#define WAYS_BEFORE 64
#define WAYS_MAX 256
#define PARTS_PRICED 16

#define PRICES_PER_TURN 256

/// About how many prices the search asks for ahead.
#define LOOK_AHEAD 256

/// Beyond so many parts the cheapest of all each time takes too many prices.
#define GREEDY_PARTS_MAX 300

#define CERTAIN_SHARE (1 - 1e-9) ///< but for rounding of sums

enum { ASSEMBLE_STRUCTURE, ASSEMBLE_PART, FLY_TO_BEAM, FLY_BEAM_TO_HUB };

const htn_kind_t assembly_kinds[] = {
    {"assemble-structure", 2}, {"assemble-part", 1}, {"fly-to-beam", 0}, {"fly-beam-to-hub", 0}};

/// A part that may come next.
typedef struct {
    int beam, slot;
    assembly_price_t price;
    double promise; ///< what it and the rest cost at least
} choice_t;

/// Those that may come next at one depth of the search, the most promising first.
typedef struct {
    int count;
    choice_t* choice;
} choices_t;

typedef struct {
    const structure_t* structure;
    const assembly_prices_t* source; ///< of prices,
    assembly_prices_t prices;        ///< and the same in turns
    const assembly_limits_t* limits;
    set_t built, used;
    int num_built, pose;
    bound_last_t last;
    double spent;
    bound_t* bound;                        ///< NULL = none
    double share;                          ///< of the bound's prices that is believed to be the least,
    double lowest_share;                   ///< and the least that was seen
    choices_t at[STRUCTURE_MAX_SLOTS + 1]; ///< by num_built
    choice_t under_way;                    ///< what the vehicle has flown to
    assembly_question_t* questions;
    assembly_price_t* answers;
    double proved; ///< that no schedule costs less
    double below;  ///< only schedules that cost less are of interest
    bool stopped;  ///< while prices were asked for: they are in vain, too
    bool in_vain;
    assembly_schedule_t best;
} assembly_t;

typedef struct {
    int pose;
    bound_last_t last;
    double spent;
} before_t;

static bool must_stop(void* context) {
    const assembly_limits_t* const limits = ((const assembly_t*)context)->limits;
    return limits->stop != NULL && limits->stop(limits->context);
}

/// Asks for so many at a time that whoever wants to stop need not wait long.
static bool ask_in_turns(void* context, const assembly_question_t* questions, int count, assembly_price_t* prices) {
    assembly_t* const assembly = context;
    for (int i = 0; i < count; i += PRICES_PER_TURN) {
        const int turn = count - i < PRICES_PER_TURN ? count - i : PRICES_PER_TURN;
        assembly->stopped = assembly->stopped || must_stop(assembly);
        if (assembly->stopped) return false;
        if (!assembly->source->ask(assembly->source->context, &questions[i], turn, &prices[i])) return false;
    }
    return true;
}

static assembly_question_t question_of(const assembly_t* assembly, int beam, int slot) {
    const bool counts = assembly->structure->obstacles;
    const assembly_question_t question = {assembly->pose, beam, slot, counts ? assembly->last.slot : -1,
                                          counts ? assembly->built : 0};
    return question;
}

/// Ties go by numbers that no name or order in the file has a part in.
static int by_promise(const void* a, const void* b) {
    const choice_t *one = a, *other = b;
    const double d = one->promise != other->promise         ? one->promise - other->promise
                     : one->price.cost != other->price.cost ? one->price.cost - other->price.cost
                                                            : one->price.time_s - other->price.time_s;
    return d < 0 ? -1 : d > 0;
}

/// What all but the part costs at least once it is done.
static double rest_after(const assembly_t* assembly, int beam, int slot) {
    const bound_last_t next = {beam, slot};
    if (assembly->bound == NULL) return 0;
    return assembly->share *
           bound_rest(assembly->bound, assembly->built | set_of(slot), assembly->used | set_of(beam), next);
}

static double least_of_part(const assembly_t* assembly, int beam, int slot) {
    if (assembly->bound == NULL) return 0;
    return assembly->share * bound_part(assembly->bound, assembly->last, beam, slot);
}

static void note_share(assembly_t* assembly, int beam, int slot, double cost) {
    const double least = assembly->bound == NULL ? 0 : bound_part(assembly->bound, assembly->last, beam, slot);
    if (least > 0) assembly->lowest_share = fmin(assembly->lowest_share, cost / least);
}

/// Whether the least that a part and all before and after it cost is less than the best schedule, and what is of
/// interest, does. The search adds up in the same order, and so leaves out exactly the parts that have no price for
/// this reason.
static bool is_of_use(const assembly_t* assembly, double promise) {
    const double best = assembly->best.num_parts > 0 ? assembly->best.cost : (double)INFINITY;
    return assembly->spent + promise < fmin(best, assembly->below);
}

/// Adds a question for every part that may come next and is of use. @return how many there are now; `useless`, which
/// may be NULL, takes the others.
static int add_questions(assembly_t* assembly, int count, choices_t* useless) {
    const structure_t* const structure = assembly->structure;
    for (int s = 0; s < structure->num_slots; s++) {
        for (int b = 0; b < structure->num_beams && structure_may_build(structure, assembly->built, s); b++) {
            if (!structure_may_take(structure, assembly->used, b, s)) continue;
            const double promise = least_of_part(assembly, b, s) + rest_after(assembly, b, s);
            if (is_of_use(assembly, promise)) {
                assembly->questions[count++] = question_of(assembly, b, s);
            } else if (useless != NULL) {
                useless->choice[useless->count++] = (choice_t){.beam = b, .slot = s, .promise = promise};
            }
        }
    }
    return count;
}

/// Finds all parts that may come next, and has those priced that are of use. @return false if that was in vain.
static bool find_choices(assembly_t* assembly) {
    choices_t* const choices = &assembly->at[assembly->num_built];
    choices->count = 0;
    const int count = add_questions(assembly, 0, choices);
    if (!assembly->prices.ask(assembly->prices.context, assembly->questions, count, assembly->answers)) {
        assembly->in_vain = true;
        return false;
    }
    for (int i = 0; i < count; i++) {
        const int b = assembly->questions[i].beam, s = assembly->questions[i].slot;
        const assembly_price_t* const price = &assembly->answers[i];
        if (!price->feasible) continue;
        note_share(assembly, b, s, price->cost);
        choices->choice[choices->count++] = (choice_t){b, s, *price, price->cost + rest_after(assembly, b, s)};
    }
    qsort(choices->choice, (size_t)choices->count, sizeof *choices->choice, by_promise);
    return true;
}

// ---- The domain -----------------------------------------------------------------------------------------------------

static void fly_to_beam(assembly_t* assembly, const choice_t* choice) {
    assembly->used |= set_of(choice->beam);
    assembly->under_way = *choice;
}

static void dock(assembly_t* assembly) {
    assembly->built |= set_of(assembly->under_way.slot);
    assembly->num_built++;
    assembly->last = (bound_last_t){assembly->under_way.beam, assembly->under_way.slot};
    assembly->pose = assembly->under_way.price.pose;
    assembly->spent += assembly->under_way.price.cost;
}

/// Both flights are one plan with one price, which counts when the beam is docked.
static bool apply(void* state, const htn_task_t* task, void* undo, double* cost) {
    assembly_t* const assembly = state;
    if (task->kind == FLY_TO_BEAM) {
        const choice_t* const choice = &assembly->at[assembly->num_built].choice[task->argument[2]];
        memcpy(undo, &assembly->under_way, sizeof assembly->under_way);
        fly_to_beam(assembly, choice);
        *cost = 0;
    } else {
        const before_t before = {assembly->pose, assembly->last, assembly->spent};
        memcpy(undo, &before, sizeof before);
        *cost = assembly->under_way.price.cost;
        dock(assembly);
    }
    return true;
}

static void undo(void* state, const htn_task_t* task, const void* undo) {
    assembly_t* const assembly = state;
    if (task->kind == FLY_TO_BEAM) {
        assembly->used &= ~set_of(task->argument[0]);
        memcpy(&assembly->under_way, undo, sizeof assembly->under_way);
    } else {
        before_t before;
        memcpy(&before, undo, sizeof before);
        assembly->built &= ~set_of(task->argument[1]);
        assembly->num_built--;
        assembly->pose = before.pose;
        assembly->last = before.last;
        assembly->spent = before.spent;
    }
}

_Static_assert(sizeof(choice_t) <= HTN_MAX_UNDO, "what is undone must fit");

/// Asks at once for what the proof would ask for choice by choice: whoever answers in parallel then has enough to do.
/// @return false if that was in vain.
static bool look_ahead(assembly_t* assembly) {
    const choices_t* const choices = &assembly->at[assembly->num_built];
    int count = 0;
    if (assembly->bound == NULL) return true;
    for (int i = 0; i < choices->count && count <= LOOK_AHEAD; i++) {
        const choice_t* const choice = &choices->choice[i];
        const htn_task_t flight = {FLY_TO_BEAM, {choice->beam, choice->slot, i}};
        const htn_task_t carrying = {FLY_BEAM_TO_HUB, {choice->beam, choice->slot, i}};
        unsigned char flown[HTN_MAX_UNDO], carried[HTN_MAX_UNDO];
        double cost;
        if (!is_of_use(assembly, choice->promise)) break;
        apply(assembly, &flight, flown, &cost);
        apply(assembly, &carrying, carried, &cost);
        count = add_questions(assembly, count, NULL);
        undo(assembly, &carrying, carried);
        undo(assembly, &flight, flown);
    }
    assembly->in_vain = !assembly->prices.ask(assembly->prices.context, assembly->questions, count, assembly->answers);
    return !assembly->in_vain;
}

static htn_binding_t method(void* state, const htn_task_t* task, int number, int binding, htn_subtasks_t* subtasks) {
    assembly_t* const assembly = state;
    const choices_t* const choices = &assembly->at[assembly->num_built];
    const bool done = assembly->num_built == assembly->structure->num_slots;
    if (task->kind == ASSEMBLE_PART) {
        if (binding > 0) return HTN_NO_MORE;
        subtasks->task[0] = (htn_task_t){FLY_TO_BEAM, {task->argument[0], task->argument[1], task->argument[2]}};
        subtasks->task[1] = (htn_task_t){FLY_BEAM_TO_HUB, {task->argument[0], task->argument[1], task->argument[2]}};
        subtasks->count = 2;
        return HTN_BOUND;
    }
    if (number == 0) return binding == 0 && done ? HTN_BOUND : HTN_NO_MORE;
    if (done || assembly->in_vain || (binding == 0 && !(find_choices(assembly) && look_ahead(assembly))) ||
        binding >= choices->count) {
        return HTN_NO_MORE;
    }
    const choice_t* const choice = &choices->choice[binding];
    subtasks->task[0] = (htn_task_t){ASSEMBLE_PART, {choice->beam, choice->slot, binding}};
    subtasks->task[1] = (htn_task_t){ASSEMBLE_STRUCTURE, {0}};
    subtasks->count = 2;
    return HTN_BOUND;
}

/// Before a part is chosen nothing else matters: what is built, which beams are gone, where the vehicle is.
static bool memory_key(void* state, const htn_agenda_t* agenda, unsigned char key[HTN_MAX_KEY]) {
    const assembly_t* const assembly = state;
    if (agenda->task.kind != ASSEMBLE_STRUCTURE) return false;
    memcpy(&key[0], &assembly->built, 16);
    memcpy(&key[16], &assembly->used, 16);
    memcpy(&key[32], &assembly->pose, 4);
    memcpy(&key[36], &assembly->last.slot, 4);
    return true;
}

/// Once a part is chosen, its price is known.
static double bound(void* state, const htn_agenda_t* agenda) {
    const assembly_t* const assembly = state;
    switch (agenda->task.kind) {
        case ASSEMBLE_PART:
        case FLY_TO_BEAM: return assembly->at[assembly->num_built].choice[agenda->task.argument[2]].promise;
        case FLY_BEAM_TO_HUB: return assembly->under_way.promise;
        default:
            return assembly->bound == NULL
                       ? 0
                       : assembly->share * bound_rest(assembly->bound, assembly->built, assembly->used, assembly->last);
    }
}

static const htn_domain_t domain = {assembly_kinds, 4, apply, undo, method, bound, memory_key};

// ---- Schedules ------------------------------------------------------------------------------------------------------

static void add_part(const assembly_t* assembly, const choice_t* choice, assembly_schedule_t* schedule) {
    schedule->part[schedule->num_parts++] =
        (assembly_part_t){choice->beam, choice->slot, question_of(assembly, choice->beam, choice->slot), choice->price};
    schedule->cost += choice->price.cost;
}

/// Takes the cheapest part each time, until all stands or nothing can follow. @return whether all stands.
static bool be_greedy(assembly_t* assembly, assembly_schedule_t* schedule) {
    const assembly_t start = *assembly;
    *schedule = (assembly_schedule_t){0};
    while (assembly->num_built < assembly->structure->num_slots) {
        const choices_t* const choices = &assembly->at[assembly->num_built];
        if (!find_choices(assembly) || choices->count == 0) break;
        add_part(assembly, &choices->choice[0], schedule);
        fly_to_beam(assembly, &choices->choice[0]);
        dock(assembly);
    }
    const bool complete = assembly->num_built == assembly->structure->num_slots, in_vain = assembly->in_vain;
    if (!complete) *schedule = (assembly_schedule_t){0};
    *assembly = start;
    assembly->in_vain = in_vain;
    return complete;
}

/// What every schedule costs at least, before any search.
static double least_of_all(const assembly_t* assembly) {
    const structure_t* const structure = assembly->structure;
    const bound_last_t start = {-1, structure->left};
    return assembly->bound == NULL
               ? 0
               : assembly->share * bound_rest(assembly->bound, structure->stands, structure->gone, start);
}

/// Tells the best schedule, and what is proved by now.
static void report_found(const assembly_t* assembly) {
    const assembly_limits_t* const limits = assembly->limits;
    if (limits->found != NULL) limits->found(limits->context, assembly->best.cost, assembly->proved);
}

/// Where the vehicle starts, with what stands then.
static void begin(assembly_t* assembly) {
    const structure_t* const structure = assembly->structure;
    assembly->built = structure->stands;
    assembly->used = structure->gone;
    assembly->num_built = 0;
    for (int s = 0; s < structure->num_slots; s++) assembly->num_built += (int)(structure->stands >> s & 1);
    assembly->pose = 0;
    assembly->last = (bound_last_t){-1, structure->left};
    assembly->spent = 0;
}

/// The schedule of a plan, whose choices stand in `at` now, and nowhere later.
static assembly_schedule_t schedule_of(assembly_t* assembly, const htn_plan_t* plan) {
    const assembly_t now = *assembly;
    assembly_schedule_t schedule = {0};
    begin(assembly);
    for (int i = 0; i < plan->num_steps; i++) {
        if (plan->steps[i].task.kind != ASSEMBLE_PART) continue;
        const choice_t* const choice = &assembly->at[assembly->num_built].choice[plan->steps[i].task.argument[2]];
        add_part(assembly, choice, &schedule);
        fly_to_beam(assembly, choice);
        dock(assembly);
    }
    *assembly = now;
    return schedule;
}

/// Keeps a better plan.
static bool found(void* context, const htn_plan_t* plan) {
    assembly_t* const assembly = context;
    assembly->best = schedule_of(assembly, plan);
    report_found(assembly);
    return true;
}

static bool make_room(assembly_t* assembly) {
    const structure_t* const structure = assembly->structure;
    const size_t most = (size_t)structure->num_beams * (size_t)structure->num_slots;
    assembly->questions = calloc(LOOK_AHEAD + most, sizeof *assembly->questions);
    assembly->answers = calloc(LOOK_AHEAD + most, sizeof *assembly->answers);
    bool sound = assembly->questions != NULL && assembly->answers != NULL;
    for (int i = 0; i <= structure->num_slots; i++) {
        assembly->at[i].choice = calloc(most, sizeof *assembly->at[i].choice);
        sound = sound && assembly->at[i].choice != NULL;
    }
    return sound;
}

static void assembly_close(assembly_t* assembly) {
    for (int i = 0; i <= assembly->structure->num_slots; i++) free(assembly->at[i].choice);
    free(assembly->questions);
    free(assembly->answers);
    free(assembly);
}

/// One search, with the share as it is, for schedules that cost less than so much. @return whether it was not stopped:
/// then there is none that costs less than the best and than so much.
static bool search_below(assembly_t* assembly, double below, assembly_result_t* result) {
    static const htn_task_t all = {ASSEMBLE_STRUCTURE, {0}};
    const htn_limits_t limits = {
        .most = isfinite(below) ? below : 0, .stop = must_stop, .found = found, .context = assembly};
    assembly->below = below;
    htn_result_t plan = htn_search(&domain, assembly, &all, 1, &limits);
    free(plan.plan.steps);
    result->nodes += plan.nodes;
    result->states = plan.memories;
    result->status = assembly->in_vain ? HTN_STOPPED : plan.status;
    return result->status == HTN_OPTIMAL || result->status == HTN_NO_PLAN;
}

/// Proves more and more, with the share as it is, until the best schedule is proved or the search is stopped.
static void prove_more(assembly_t* assembly, assembly_result_t* result) {
    const double least = least_of_all(assembly);
    bool going_on = true;
    assembly->proved = least;
    for (int pass = 1; pass <= PASSES && going_on; pass++) {
        const double best = assembly->best.num_parts > 0 ? assembly->best.cost : (double)INFINITY;
        const bool is_last = pass == PASSES || !isfinite(best) || least >= best;
        const double below = is_last ? best : least + (best - least) * pass / PASSES;
        going_on = search_below(assembly, below, result);
        const bool has_better = assembly->best.num_parts > 0 && assembly->best.cost < below;
        if (going_on) assembly->proved = has_better ? assembly->best.cost : below;
        if (going_on && (is_last || has_better)) {
            result->status = assembly->best.num_parts > 0 ? HTN_OPTIMAL : HTN_NO_PLAN;
            going_on = false;
        }
        if (going_on && assembly->best.num_parts > 0) report_found(assembly);
    }
    result->lower_bound = assembly->proved;
}

static void take(assembly_t* assembly, const assembly_schedule_t* schedule) {
    if (schedule->num_parts == 0) return;
    if (assembly->best.num_parts > 0 && assembly->best.cost <= schedule->cost) return;
    assembly->best = *schedule;
    report_found(assembly);
}

/// Carries on so many ways together. @return whether there is time for more.
static bool search_stages(assembly_t* assembly, const estimate_t* estimate, int ways) {
    const stages_result_t result =
        stages_search(assembly->structure, &assembly->prices, estimate, ways, PARTS_PRICED, must_stop, assembly);
    take(assembly, &result.best);
    assembly->in_vain = assembly->in_vain || result.in_vain;
    return !result.in_vain && !result.stopped && !result.out_of_memory;
}

/// Finds schedules, good ones soon and better ones later.
static void find_good(assembly_t* assembly, int most_ways, assembly_result_t* result) {
    const structure_t* const structure = assembly->structure;
    estimate_t* const estimate = estimate_open(structure, &assembly->prices, must_stop, assembly);
    bool going_on = estimate != NULL;
    int ways = 1;
    if (going_on) result->estimated_least = estimate_least(estimate);
    for (; ways <= most_ways && going_on && assembly->best.num_parts == 0; ways *= 4) {
        going_on = search_stages(assembly, estimate, ways);
    }
    result->greedy_tried = structure->num_beams * structure->num_slots <= GREEDY_PARTS_MAX;
    if (result->greedy_tried && !assembly->in_vain && be_greedy(assembly, &result->greedy)) {
        take(assembly, &result->greedy);
    }
    for (; ways <= most_ways && going_on && !assembly->in_vain; ways *= 4) {
        going_on = search_stages(assembly, estimate, ways);
    }
    estimate_close(estimate);
}

/// Proves that the best schedule is best, until no price that was seen is below the share of the bound's that the proof
/// has relied on.
static void prove(assembly_t* assembly, assembly_result_t* result) {
    const bool certain = !assembly->structure->obstacles;
    assembly->bound = bound_open(assembly->structure, &assembly->prices, must_stop, assembly);
    assembly->share = certain ? CERTAIN_SHARE : FIRST_SHARE;
    assembly->lowest_share = 1;
    for (bool again = true; again;) {
        prove_more(assembly, result);
        again = result->status != HTN_STOPPED && result->status != HTN_NO_MEMORY &&
                assembly->lowest_share < assembly->share;
        if (again) assembly->share = fmax(0, 1 - 2 * (1 - assembly->lowest_share));
    }
    result->relied_share = assembly->bound == NULL || certain ? 0 : assembly->share;
    result->lowest_share = assembly->lowest_share;
    bound_close(assembly->bound);
    assembly->bound = NULL;
}

static void search(assembly_t* assembly, assembly_result_t* result) {
    const bool is_small = bound_fits(assembly->structure);
    result->status = HTN_STOPPED;
    find_good(assembly, is_small ? WAYS_BEFORE : WAYS_MAX, result);
    if (!assembly->in_vain && is_small) prove(assembly, result);
    result->best = assembly->best;
    result->asked_in_vain = assembly->in_vain && !assembly->stopped;
}

static assembly_t* assembly_open(const structure_t* structure, const assembly_prices_t* prices,
                                 const assembly_limits_t* limits) {
    assembly_t* const assembly = calloc(1, sizeof *assembly);
    if (assembly == NULL) return NULL;
    assembly->structure = structure;
    assembly->source = prices;
    assembly->prices = (assembly_prices_t){ask_in_turns, assembly};
    assembly->limits = limits;
    begin(assembly);
    assembly->below = INFINITY;
    if (make_room(assembly)) return assembly;
    assembly_close(assembly);
    return NULL;
}

bool assembly_schedule(const structure_t* structure, const assembly_prices_t* prices, const assembly_limits_t* limits,
                       assembly_result_t* result) {
    assembly_t* const assembly = assembly_open(structure, prices, limits);
    *result = (assembly_result_t){.status = HTN_NO_MEMORY, .estimated_least = INFINITY};
    if (assembly == NULL) return false;
    search(assembly, result);
    assembly_close(assembly);
    return result->status != HTN_NO_MEMORY;
}

// ---- Every decomposition --------------------------------------------------------------------------------------------

typedef struct {
    assembly_t* assembly;
    bool (*told)(void* context, const assembly_schedule_t* schedule);
    void* context;
} each_t;

static bool found_one(void* context, const htn_plan_t* plan) {
    const each_t* const each = context;
    const assembly_schedule_t schedule = schedule_of(each->assembly, plan);
    return each->told(each->context, &schedule);
}

bool assembly_each(const structure_t* structure, const assembly_prices_t* prices,
                   bool (*told)(void* context, const assembly_schedule_t* schedule), void* context) {
    static const assembly_limits_t none = {0};
    static const htn_task_t all = {ASSEMBLE_STRUCTURE, {0}};
    assembly_t* const assembly = assembly_open(structure, prices, &none);
    each_t each = {assembly, told, context};
    const htn_limits_t limits = {.all = true, .found = found_one, .context = &each};
    if (assembly == NULL) return false;
    htn_result_t plan = htn_search(&domain, assembly, &all, 1, &limits);
    const bool sound = !assembly->in_vain && plan.status != HTN_STOPPED && plan.status != HTN_NO_MEMORY;
    free(plan.plan.steps);
    assembly_close(assembly);
    return sound;
}
