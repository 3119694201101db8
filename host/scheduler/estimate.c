// Prices from the start and from each slot, and the cheapest flow over them.
#include "estimate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PLACES_MAX (STRUCTURE_MAX_SLOTS + 1)

/// Where the vehicle comes from: the start, or a slot and one.
struct estimate {
    int num_beams, num_slots;
    set_t stands;                                          ///< slots that are filled already
    double part[STRUCTURE_MAX_BEAMS][STRUCTURE_MAX_SLOTS]; ///< price from the start
    double way[PLACES_MAX][STRUCTURE_MAX_BEAMS];           ///< what it costs more to come from there
    double place_due[PLACES_MAX], beam_due[STRUCTURE_MAX_BEAMS], slot_due[STRUCTURE_MAX_SLOTS];
    double least;
};

double estimate_part(const estimate_t* estimate, int last, int beam, int slot) {
    return estimate->way[last + 1][beam] + estimate->part[beam][slot];
}

double estimate_due(const estimate_t* estimate, int last, int beam, int slot) {
    return estimate->slot_due[slot] - estimate->place_due[last + 1] - estimate->beam_due[beam];
}

double estimate_least(const estimate_t* estimate) { return estimate->least; }

void estimate_close(estimate_t* estimate) { free(estimate); }

// ---- Prices ---------------------------------------------------------------------------------------------------------

typedef struct {
    const structure_t* structure;
    const assembly_prices_t* prices;
    assembly_question_t* questions;
    assembly_price_t* answers;
    int* lasts; ///< where each question comes from
} asking_t;

/// All parts from the start. *pose_at gets where the vehicle is after the cheapest part of each slot, or -1.
static bool price_parts(estimate_t* estimate, const asking_t* asking, int* pose_at) {
    double cheapest[STRUCTURE_MAX_SLOTS];
    int count = 0;
    for (int s = 0; s < estimate->num_slots; s++) {
        pose_at[s] = -1;
        cheapest[s] = INFINITY;
        for (int b = 0; b < estimate->num_beams; b++) {
            estimate->part[b][s] = INFINITY;
            const bool is_open = (estimate->stands >> s & 1) == 0;
            if (is_open && structure_may_take(asking->structure, asking->structure->gone, b, s)) {
                asking->questions[count++] = (assembly_question_t){.beam = b, .slot = s, .left = -1};
            }
        }
    }
    if (!asking->prices->ask(asking->prices->context, asking->questions, count, asking->answers)) return false;
    for (int i = 0; i < count; i++) {
        const assembly_price_t* const price = &asking->answers[i];
        const int s = asking->questions[i].slot;
        if (!price->feasible) continue;
        estimate->part[asking->questions[i].beam][s] = price->cost;
        if (price->cost < cheapest[s]) pose_at[s] = price->pose;
        cheapest[s] = fmin(cheapest[s], price->cost);
    }
    return true;
}

/// Each beam from each slot, to the slot that it goes to at the least cost.
static bool price_ways(estimate_t* estimate, const asking_t* asking, const int* pose_at) {
    int count = 0;
    for (int b = 0; b < estimate->num_beams; b++) estimate->way[0][b] = 0;
    for (int last = 0; last < estimate->num_slots; last++) {
        for (int b = 0; b < estimate->num_beams; b++) {
            int to = -1;
            for (int s = 0; s < estimate->num_slots; s++) {
                const double part = estimate->part[b][s];
                if (s != last && isfinite(part) && (to < 0 || part < estimate->part[b][to])) to = s;
            }
            estimate->way[last + 1][b] = 0;
            if (to >= 0 && pose_at[last] >= 0) {
                asking->lasts[count] = last;
                asking->questions[count++] = (assembly_question_t){pose_at[last], b, to, -1, 0};
            }
        }
    }
    const bool sound = asking->prices->ask(asking->prices->context, asking->questions, count, asking->answers);
    for (int i = 0; sound && i < count; i++) {
        const assembly_question_t* const question = &asking->questions[i];
        if (!asking->answers[i].feasible) continue;
        estimate->way[asking->lasts[i] + 1][question->beam] =
            asking->answers[i].cost - estimate->part[question->beam][question->slot];
    }
    return sound;
}

// ---- The flow -------------------------------------------------------------------------------------------------------

// Nodes: places, beams as they are taken, beams as they are held, slots; and one more where dues are found.
#define NODES_MAX (PLACES_MAX + 2 * STRUCTURE_MAX_BEAMS + STRUCTURE_MAX_SLOTS + 1)

typedef struct {
    estimate_t* estimate;
    int num_nodes, beams_at, held_at, slots_at;
    int beam_of_place[PLACES_MAX], slot_of_beam[STRUCTURE_MAX_BEAMS]; ///< where the flow goes on, -1 = nowhere
    int place_of_beam[STRUCTURE_MAX_BEAMS], beam_of_slot[STRUCTURE_MAX_SLOTS];
    double distance[NODES_MAX];
    int before[NODES_MAX];
} flow_t;

static bool relax(flow_t* flow, int from, int to, double cost) {
    if (!(flow->distance[from] + cost < flow->distance[to] - 1e-9)) return false;
    flow->distance[to] = flow->distance[from] + cost;
    flow->before[to] = from;
    return true;
}

/// One round over all arcs that have room, and back along those with flow. @return whether anything got nearer.
static bool relax_all(flow_t* flow) {
    const estimate_t* const e = flow->estimate;
    bool nearer = false;
    for (int b = 0; b < e->num_beams; b++) {
        const int taken = flow->beams_at + b, held = flow->held_at + b;
        for (int p = 0; p <= e->num_slots; p++) {
            const bool flows = flow->beam_of_place[p] == b;
            if (flows && relax(flow, taken, p, -e->way[p][b])) nearer = true;
            if (relax(flow, p, taken, e->way[p][b])) nearer = true;
        }
        const bool used = flow->place_of_beam[b] >= 0;
        if (relax(flow, used ? held : taken, used ? taken : held, 0)) nearer = true;
        for (int s = 0; s < e->num_slots; s++) {
            if (!isfinite(e->part[b][s])) continue;
            const bool flows = flow->slot_of_beam[b] == s;
            if (flows && relax(flow, flow->slots_at + s, held, -e->part[b][s])) nearer = true;
            if (relax(flow, held, flow->slots_at + s, e->part[b][s])) nearer = true;
        }
    }
    return nearer;
}

/// Whether the vehicle can come from there: from the start, or from a slot that it fills.
static bool is_place(const estimate_t* estimate, int place) {
    return place == 0 || (estimate->stands >> (place - 1) & 1) == 0;
}

/// Shortest ways from all places that are not left yet, the start before any other.
static void find_ways(flow_t* flow) {
    for (int i = 0; i < flow->num_nodes; i++) {
        flow->distance[i] = INFINITY;
        flow->before[i] = -1;
    }
    for (int p = 0; p <= flow->estimate->num_slots; p++) {
        const bool is_free = flow->beam_of_place[p] < 0 && (p == 0 || flow->beam_of_place[0] >= 0);
        if (is_free && is_place(flow->estimate, p)) flow->distance[p] = 0;
    }
    for (int round = 0; round < flow->num_nodes && relax_all(flow); round++) {}
}

/// Sends one more along the way that ends at a node.
static void send(flow_t* flow, int node) {
    const int num_places = flow->estimate->num_slots + 1;
    for (int to = node, from; (from = flow->before[to]) >= 0; to = from) {
        if (from < num_places) {
            flow->beam_of_place[from] = to - flow->beams_at;
            flow->place_of_beam[to - flow->beams_at] = from;
        } else if (to >= flow->slots_at) {
            flow->slot_of_beam[from - flow->held_at] = to - flow->slots_at;
            flow->beam_of_slot[to - flow->slots_at] = from - flow->held_at;
        } else if (from >= flow->held_at && from < flow->slots_at && to < flow->held_at) {
            flow->place_of_beam[to - flow->beams_at] = flow->slot_of_beam[to - flow->beams_at] = -1; // is let go
        }
    }
}

/// What each node adds to what a part is due: distances from anywhere, by which no arc with room is too short. Places
/// that are left and those that are not hang together over one more node, but for the start, which must be left.
static void find_dues(flow_t* flow) {
    estimate_t* const e = flow->estimate;
    bool nearer = true;
    for (int i = 0; i <= flow->num_nodes; i++) flow->distance[i] = 0;
    for (int round = 0; round <= flow->num_nodes && nearer; round++) {
        nearer = relax_all(flow);
        for (int p = 1; p <= e->num_slots; p++) {
            if (!is_place(e, p)) continue;
            const bool is_left = flow->beam_of_place[p] >= 0;
            if (relax(flow, is_left ? p : flow->num_nodes, is_left ? flow->num_nodes : p, 0)) nearer = true;
        }
    }
    for (int p = 0; p <= e->num_slots; p++) e->place_due[p] = flow->distance[p];
    for (int b = 0; b < e->num_beams; b++) {
        e->beam_due[b] = flow->distance[flow->held_at + b] - flow->distance[flow->beams_at + b];
    }
    for (int s = 0; s < e->num_slots; s++) e->slot_due[s] = flow->distance[flow->slots_at + s];
}

static bool find_flow(estimate_t* estimate) {
    flow_t* const flow = calloc(1, sizeof *flow);
    if (flow == NULL) return false;
    flow->estimate = estimate;
    flow->beams_at = estimate->num_slots + 1;
    flow->held_at = flow->beams_at + estimate->num_beams;
    flow->slots_at = flow->held_at + estimate->num_beams;
    flow->num_nodes = flow->slots_at + estimate->num_slots;
    memset(flow->beam_of_place, -1, sizeof flow->beam_of_place);
    memset(flow->place_of_beam, -1, sizeof flow->place_of_beam);
    memset(flow->slot_of_beam, -1, sizeof flow->slot_of_beam);
    memset(flow->beam_of_slot, -1, sizeof flow->beam_of_slot);
    estimate->least = 0;
    for (int slot = 0; slot < estimate->num_slots && isfinite(estimate->least); slot++) {
        int best = -1;
        if ((estimate->stands >> slot & 1) != 0) continue; // as many as are open, whichever comes first
        find_ways(flow);
        for (int s = 0; s < estimate->num_slots; s++) {
            const int node = flow->slots_at + s;
            const bool is_open = flow->beam_of_slot[s] < 0 && isfinite(flow->distance[node]);
            if (is_open && (best < 0 || flow->distance[node] < flow->distance[best])) best = node;
        }
        estimate->least = best < 0 ? (double)INFINITY : estimate->least + flow->distance[best];
        if (best >= 0) send(flow, best);
    }
    if (isfinite(estimate->least)) find_dues(flow);
    free(flow);
    return true;
}

estimate_t* estimate_open(const structure_t* structure, const assembly_prices_t* prices, bool (*stop)(void* context),
                          void* context) {
    int pose_at[STRUCTURE_MAX_SLOTS];
    const size_t most = (size_t)structure->num_beams * (size_t)structure->num_slots;
    const asking_t asking = {structure, prices, calloc(most, sizeof *asking.questions),
                             calloc(most, sizeof *asking.answers), calloc(most, sizeof *asking.lasts)};
    estimate_t* estimate = calloc(1, sizeof *estimate);
    bool sound = estimate != NULL && asking.questions != NULL && asking.answers != NULL && asking.lasts != NULL;
    if (sound) {
        estimate->num_beams = structure->num_beams;
        estimate->num_slots = structure->num_slots;
        estimate->stands = structure->stands;
        sound = price_parts(estimate, &asking, pose_at) && !stop(context) && price_ways(estimate, &asking, pose_at) &&
                find_flow(estimate);
    }
    free(asking.questions);
    free(asking.answers);
    free(asking.lasts);
    if (sound) return estimate;
    estimate_close(estimate);
    return NULL;
}
