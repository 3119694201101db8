// The graph of poses and parts past the hubs alone, and the smaller problem over it.
#include "bound.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PARTS_MAX 80     ///< beams times slots; their square is about the number of prices
#define NODES_MAX 4000   ///< of the graph
#define REST_MAX 2097152 ///< room for states of the smaller problem, a power of two; half of it is used at most
#define STATES_PER_LOOK 1024

/// Where the vehicle may be, and after which part.
typedef struct {
    int pose;
    bound_last_t last;
} node_t;

typedef struct {
    set_t built, used;
    double cost;
    int last;
    bool known;
} rest_t;

struct bound {
    const structure_t* structure;
    double least[PARTS_MAX + 1][PARTS_MAX]; ///< by part before, or PARTS_MAX, and part
    node_t node[NODES_MAX];
    int num_nodes;
    rest_t* rests;
    int num_rests;
    bool (*stop)(void* context); ///< asked now and then whether to give up the rest of the smaller problem
    void* context;
    bool given_up;
};

static int part_of(const bound_t* bound, int beam, int slot) { return beam * bound->structure->num_slots + slot; }

static int before_of(const bound_t* bound, bound_last_t last) {
    return last.beam < 0 ? PARTS_MAX : part_of(bound, last.beam, last.slot);
}

double bound_part(const bound_t* bound, bound_last_t last, int beam, int slot) {
    const double least = bound->least[before_of(bound, last)][part_of(bound, beam, slot)];
    return isfinite(least) ? least : 0;
}

// ---- The graph ------------------------------------------------------------------------------------------------------

/// @return false if there are too many.
static bool add_node(bound_t* bound, node_t node) {
    for (int i = 0; i < bound->num_nodes; i++) {
        const node_t* const other = &bound->node[i];
        if (other->pose == node.pose && other->last.beam == node.last.beam && other->last.slot == node.last.slot) {
            return true;
        }
    }
    if (bound->num_nodes == NODES_MAX) return false;
    bound->node[bound->num_nodes++] = node;
    return true;
}

/// All parts that may follow a node.
static int questions_from(const structure_t* structure, const node_t* node, assembly_question_t* questions) {
    const set_t used = structure->gone | (node->last.beam < 0 ? 0 : set_of(node->last.beam));
    int count = 0;
    for (int b = 0; b < structure->num_beams; b++) {
        for (int s = 0; s < structure->num_slots; s++) {
            if (s == node->last.slot || (structure->stands >> s & 1) != 0) continue;
            if (!structure_may_take(structure, used, b, s)) continue;
            questions[count++] = (assembly_question_t){node->pose, b, s, -1, 0};
        }
    }
    return count;
}

/// Prices all parts from the nodes of one round together. @return false if they are too many or not to be had.
static bool price_round(bound_t* bound, const assembly_prices_t* prices, int first, int end) {
    const size_t most = (size_t)(end - first) * PARTS_MAX;
    assembly_question_t* const questions = calloc(most, sizeof *questions);
    assembly_price_t* const answers = calloc(most, sizeof *answers);
    int* const node_of = calloc(most, sizeof *node_of);
    int count = 0;
    bool sound = questions != NULL && answers != NULL && node_of != NULL;
    for (int n = first; sound && n < end; n++) {
        const int more = questions_from(bound->structure, &bound->node[n], &questions[count]);
        for (int i = 0; i < more; i++) node_of[count + i] = n;
        count += more;
    }
    sound = sound && prices->ask(prices->context, questions, count, answers);
    for (int i = 0; sound && i < count; i++) {
        const bound_last_t part = {questions[i].beam, questions[i].slot};
        double* const least =
            &bound->least[before_of(bound, bound->node[node_of[i]].last)][part_of(bound, part.beam, part.slot)];
        if (!answers[i].feasible) continue;
        *least = fmin(*least, answers[i].cost);
        sound = add_node(bound, (node_t){answers[i].pose, part});
    }
    free(questions);
    free(answers);
    free(node_of);
    return sound;
}

bool bound_fits(const structure_t* structure) { return structure->num_beams * structure->num_slots <= PARTS_MAX; }

bound_t* bound_open(const structure_t* structure, const assembly_prices_t* prices, bool (*stop)(void* context),
                    void* context) {
    if (!bound_fits(structure)) return NULL;
    bound_t* const bound = calloc(1, sizeof *bound);
    bool sound = bound != NULL;
    if (sound) {
        bound->structure = structure;
        bound->stop = stop;
        bound->context = context;
        bound->rests = calloc(REST_MAX, sizeof *bound->rests);
        for (int i = 0; i <= PARTS_MAX; i++) {
            for (int k = 0; k < PARTS_MAX; k++) bound->least[i][k] = INFINITY;
        }
        sound = bound->rests != NULL && add_node(bound, (node_t){0, {-1, -1}});
    }
    for (int first = 0, end; sound && first < bound->num_nodes; first = end) {
        end = bound->num_nodes;
        sound = !stop(context) && price_round(bound, prices, first, end);
    }
    if (sound) return bound;
    bound_close(bound);
    return NULL;
}

// ---- The smaller problem --------------------------------------------------------------------------------------------

static rest_t* rest_of(const bound_t* bound, set_t built, set_t used, int last) {
    uint64_t hash = (uint64_t)built * 0x9e3779b97f4a7c15u; // slots are few
    hash = (hash ^ (uint64_t)used ^ (uint64_t)(used >> 64) << 32) * 0x9e3779b97f4a7c15u;
    hash = (hash ^ (uint64_t)last) * 0x9e3779b97f4a7c15u;
    size_t i = (size_t)(hash >> 32) & (REST_MAX - 1);
    while (bound->rests[i].known &&
           (bound->rests[i].built != built || bound->rests[i].used != used || bound->rests[i].last != last)) {
        i = (i + 1) & (REST_MAX - 1);
    }
    return &bound->rests[i];
}

double bound_rest(bound_t* bound, set_t built, set_t used, bound_last_t last) {
    const structure_t* const structure = bound->structure;
    const int before = before_of(bound, last);
    const rest_t* const known = rest_of(bound, built, used, before);
    double cost = INFINITY;
    if (built == set_of(structure->num_slots) - 1) return 0;
    if (known->known) return known->cost;
    if (bound->given_up) return 0;
    for (int s = 0; s < structure->num_slots; s++) {
        for (int b = 0; b < structure->num_beams && structure_may_build(structure, built, s); b++) {
            if (!structure_may_take(structure, used, b, s)) continue;
            const double part = bound_part(bound, last, b, s);
            if (part >= cost) continue;
            const bound_last_t next = {b, s};
            cost = fmin(cost, part + bound_rest(bound, built | set_of(s), used | set_of(b), next));
        }
    }
    *rest_of(bound, built, used, before) = (rest_t){built, used, cost, before, true};
    bound->num_rests++;
    if (bound->num_rests % STATES_PER_LOOK == 0 && bound->stop(bound->context)) bound->given_up = true;
    if (2 * bound->num_rests >= REST_MAX) bound->given_up = true;
    return cost;
}

void bound_close(bound_t* bound) {
    if (bound != NULL) free(bound->rests);
    free(bound);
}
