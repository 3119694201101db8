#include "stages.h"

#include <math.h>
#include <stdlib.h>

/// A way so far.
typedef struct {
    set_t built, used;
    int pose, last;     ///< the slot that was filled last, or -1 at the start
    double cost, above; ///< what it has cost, and how much of it above what was due
    int before;         ///< number of the way in the stage before
    assembly_part_t part;
} way_t;

/// A part that may come next, before it is priced.
typedef struct {
    int beam, slot;
    double above;
} next_t;

typedef struct {
    const structure_t* structure;
    const estimate_t* estimate;
    int num_ways, num_parts, num_stages; ///< a stage for each slot that is open
    way_t* ways;                         ///< of the start and all stages, num_ways each
    int* count;                          ///< of ways in each
    way_t* found;                        ///< of the next stage, before the best are chosen
    int num_found;
    next_t* next;
    assembly_question_t* questions;
    assembly_price_t* answers;
    int* from; ///< way that a question belongs to
} stages_t;

/// The ways of one stage.
static way_t* stage_of(const stages_t* stages, int stage) {
    return &stages->ways[(size_t)stage * (size_t)stages->num_ways];
}

static int by_above(const void* a, const void* b) {
    const double one = ((const next_t*)a)->above, other = ((const next_t*)b)->above;
    return (one > other) - (one < other);
}

static int by_state(const void* a, const void* b) {
    const way_t *one = a, *other = b;
    if (one->built != other->built) return one->built < other->built ? -1 : 1;
    if (one->used != other->used) return one->used < other->used ? -1 : 1;
    if (one->pose != other->pose) return one->pose < other->pose ? -1 : 1;
    if (one->last != other->last) return one->last < other->last ? -1 : 1;
    return (one->cost > other->cost) - (one->cost < other->cost);
}

static int by_promise(const void* a, const void* b) {
    const way_t *one = a, *other = b;
    if (one->above != other->above) return one->above < other->above ? -1 : 1;
    return by_state(a, b);
}

/// Adds questions of one way, of those after the first so many. @return how many there are now.
static int ask_from(stages_t* stages, const way_t* way, int number, int skipped, int count) {
    const structure_t* const structure = stages->structure;
    const bool counts = structure->obstacles;
    const int left = way->last < 0 ? structure->left : way->last;
    int num_next = 0;
    for (int s = 0; s < structure->num_slots; s++) {
        for (int b = 0; b < structure->num_beams && structure_may_build(structure, way->built, s); b++) {
            const double part = estimate_part(stages->estimate, way->last, b, s);
            if (!isfinite(part) || !structure_may_take(structure, way->used, b, s)) continue;
            stages->next[num_next++] = (next_t){b, s, part - estimate_due(stages->estimate, way->last, b, s)};
        }
    }
    qsort(stages->next, (size_t)num_next, sizeof *stages->next, by_above);
    for (int i = skipped; i < num_next && i < skipped + stages->num_parts; i++) {
        stages->from[count] = number;
        stages->questions[count++] = (assembly_question_t){way->pose, stages->next[i].beam, stages->next[i].slot,
                                                           counts ? left : -1, counts ? way->built : 0};
    }
    return count;
}

static way_t carried_on(const stages_t* stages, const way_t* way, int number, const assembly_question_t* question,
                        const assembly_price_t* price) {
    const double due = estimate_due(stages->estimate, way->last, question->beam, question->slot);
    return (way_t){.built = way->built | set_of(question->slot),
                   .used = way->used | set_of(question->beam),
                   .pose = price->pose,
                   .last = question->slot,
                   .cost = way->cost + price->cost,
                   .above = way->above + price->cost - due,
                   .before = number,
                   .part = {question->beam, question->slot, *question, *price}};
}

/// The best of what was found, each state once, become the next stage.
static void choose(stages_t* stages, int stage) {
    int kept = 0;
    qsort(stages->found, (size_t)stages->num_found, sizeof *stages->found, by_state);
    for (int i = 0; i < stages->num_found; i++) {
        const way_t *one = &stages->found[i], *before = kept == 0 ? NULL : &stages->found[kept - 1];
        const bool is_known = before != NULL && before->built == one->built && before->used == one->used &&
                              before->pose == one->pose && before->last == one->last;
        if (!is_known) stages->found[kept++] = *one;
    }
    qsort(stages->found, (size_t)kept, sizeof *stages->found, by_promise);
    stages->count[stage] = kept < stages->num_ways ? kept : stages->num_ways;
    for (int i = 0; i < stages->count[stage]; i++) stage_of(stages, stage)[i] = stages->found[i];
}

/// Asks for the parts of all ways, after the first so many of each. @return how many it asked for, or -1 in vain.
static int ask_stage(stages_t* stages, const assembly_prices_t* prices, int stage, int skipped,
                     stages_result_t* result) {
    int count = 0;
    for (int i = 0; i < stages->count[stage]; i++) {
        count = ask_from(stages, &stage_of(stages, stage)[i], i, skipped, count);
    }
    if (!prices->ask(prices->context, stages->questions, count, stages->answers)) return -1;
    stages->num_found = 0;
    for (int i = 0; i < count; i++) {
        const way_t* const way = &stage_of(stages, stage)[stages->from[i]];
        const assembly_question_t* const question = &stages->questions[i];
        if (!stages->answers[i].feasible) continue;
        const double part = estimate_part(stages->estimate, way->last, question->beam, question->slot);
        result->lowest_share = fmin(result->lowest_share, stages->answers[i].cost / part);
        stages->found[stages->num_found++] = carried_on(stages, way, stages->from[i], question, &stages->answers[i]);
    }
    return count;
}

/// Where none of the most promising parts has a plan, the next ones are asked for.
static bool do_stage(stages_t* stages, const assembly_prices_t* prices, int stage, stages_result_t* result) {
    int count = 1;
    stages->num_found = 0;
    for (int skipped = 0; count > 0 && stages->num_found == 0; skipped += stages->num_parts) {
        count = ask_stage(stages, prices, stage, skipped, result);
    }
    result->in_vain = count < 0;
    choose(stages, stage + 1);
    return !result->in_vain;
}

/// The cheapest way to the last stage.
static void take_best(const stages_t* stages, stages_result_t* result) {
    const int last = stages->num_stages;
    int best = -1;
    for (int i = 0; i < stages->count[last]; i++) {
        if (best < 0 || stage_of(stages, last)[i].cost < stage_of(stages, last)[best].cost) best = i;
    }
    if (best < 0) return;
    result->best.num_parts = last;
    result->best.cost = stage_of(stages, last)[best].cost;
    for (int stage = last; stage > 0; stage--) {
        result->best.part[stage - 1] = stage_of(stages, stage)[best].part;
        best = stage_of(stages, stage)[best].before;
    }
}

static void close_stages(stages_t* stages) {
    if (stages == NULL) return;
    free(stages->count);
    free(stages->ways);
    free(stages->found);
    free(stages->questions);
    free(stages->answers);
    free(stages->from);
    free(stages->next);
    free(stages);
}

static stages_t* open_stages(const structure_t* structure, const estimate_t* estimate, int num_ways, int num_parts) {
    const size_t most = (size_t)num_ways * (size_t)num_parts;
    stages_t* const stages = calloc(1, sizeof *stages);
    if (stages == NULL) return NULL;
    stages->structure = structure;
    stages->estimate = estimate;
    stages->num_ways = num_ways;
    stages->num_parts = num_parts;
    for (int s = 0; s < structure->num_slots; s++) stages->num_stages += (structure->stands >> s & 1) == 0;
    stages->count = calloc((size_t)stages->num_stages + 1, sizeof *stages->count);
    stages->ways = calloc((size_t)stages->num_stages + 1, (size_t)num_ways * sizeof *stages->ways);
    stages->found = calloc(most, sizeof *stages->found);
    stages->questions = calloc(most, sizeof *stages->questions);
    stages->answers = calloc(most, sizeof *stages->answers);
    stages->from = calloc(most, sizeof *stages->from);
    stages->next = calloc((size_t)structure->num_beams, (size_t)structure->num_slots * sizeof *stages->next);
    if (stages->count != NULL && stages->ways != NULL && stages->found != NULL && stages->questions != NULL &&
        stages->answers != NULL && stages->from != NULL && stages->next != NULL) {
        stages->ways[0] = (way_t){.built = structure->stands, .used = structure->gone, .last = -1};
        stages->count[0] = 1;
        return stages;
    }
    close_stages(stages);
    return NULL;
}

stages_result_t stages_search(const structure_t* structure, const assembly_prices_t* prices, const estimate_t* estimate,
                              int num_ways, int num_parts, bool (*stop)(void* context), void* context) {
    stages_result_t result = {.lowest_share = 1};
    stages_t* const stages = open_stages(structure, estimate, num_ways, num_parts);
    bool going_on = stages != NULL;
    result.out_of_memory = !going_on;
    for (int stage = 0; going_on && stage < stages->num_stages; stage++) {
        result.stopped = stop(context);
        going_on = !result.stopped && do_stage(stages, prices, stage, &result);
    }
    if (going_on) take_best(stages, &result);
    close_stages(stages);
    return result;
}
