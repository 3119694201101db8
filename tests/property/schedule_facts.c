// Prints seeded structures and what the scheduler says of them, for judges in Python: lines of "key value value" and so
// on.
//
//   schedule_facts decompositions FIRST COUNT   small structures with every decomposition, from the domain itself
//   schedule_facts graph FIRST COUNT            structures of 4 to 6 slots past no obstacles, the graph of all their
//                                               prices, and what the schedule costs
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pricing.h"
#include "sample.h"
#include "structures.h"

#define SEED 20261201
#define POSES_MAX 4000

static structure_t sample(int number, int num_slots) {
    sample_seed(SEED + (uint64_t)number);
    return structures_sample(num_slots);
}

static void print_rules(int number, const structure_t* structure) {
    printf("structure %d %d %d %d\n", number, structure->num_slots, structure->num_beams, structure->touching);
    for (int s = 0; s < structure->num_slots; s++) {
        printf("slot %d %" PRIu64 " %" PRIu64 "\n", structure->slot[s].beam, (uint64_t)structure->slot[s].after,
               (uint64_t)structure->slot[s].touches);
    }
}

static bool give_nothing_a_price(void* context, const assembly_question_t* questions, int count,
                                 assembly_price_t* prices) {
    (void)context;
    (void)questions;
    for (int i = 0; i < count; i++) prices[i] = (assembly_price_t){.feasible = true};
    return true;
}

static bool print_decomposition(void* context, const assembly_schedule_t* schedule) {
    (void)context;
    printf("way");
    for (int i = 0; i < schedule->num_parts; i++) printf(" %d %d", schedule->part[i].beam, schedule->part[i].slot);
    printf("\n");
    return true;
}

static bool print_decompositions(int number) {
    const structure_t structure = sample(number, 2 + number % 3);
    const assembly_prices_t prices = {give_nothing_a_price, NULL};
    print_rules(number, &structure);
    return assembly_each(&structure, &prices, print_decomposition, NULL);
}

/// Prices every part from every pose that any part leads to. @return false if they are too many.
static bool print_arcs(const structure_t* structure, pricing_t* pricing) {
    static assembly_question_t questions[STRUCTURE_MAX_BEAMS * STRUCTURE_MAX_SLOTS];
    static assembly_price_t prices[STRUCTURE_MAX_BEAMS * STRUCTURE_MAX_SLOTS];
    for (int pose = 0; pose < pricing_counts(pricing).poses; pose++) {
        int count = 0;
        for (int b = 0; b < structure->num_beams; b++) {
            for (int s = 0; s < structure->num_slots; s++) {
                questions[count++] = (assembly_question_t){pose, b, s, -1, 0};
            }
        }
        if (pose == POSES_MAX || !pricing_ask(pricing, questions, count, prices)) return false;
        for (int i = 0; i < count; i++) {
            if (!prices[i].feasible) continue;
            printf("arc %d %d %d %d %.17g\n", pose, questions[i].beam, questions[i].slot, prices[i].pose,
                   prices[i].cost);
        }
    }
    return true;
}

static bool print_graph(int number) {
    static const assembly_limits_t limits = {0};
    assembly_result_t result;
    structure_t structure = sample(number, 4 + number % 3);
    structure.obstacles = false;
    pricing_t* const pricing = pricing_open(&structure, 0);
    if (pricing == NULL) return false;
    const assembly_prices_t prices = {pricing_ask, pricing};
    print_rules(number, &structure);
    const bool sound = assembly_schedule(&structure, &prices, &limits, &result) && print_arcs(&structure, pricing);
    if (result.best.num_parts > 0) printf("cost %.17g\n", result.best.cost);
    pricing_close(pricing);
    return sound;
}

int main(int argc, char** argv) {
    char error[512];
    if (argc != 4 || !structures_open(error, sizeof error)) return 1;
    const bool of_graph = strcmp(argv[1], "graph") == 0;
    const int first = atoi(argv[2]), end = first + atoi(argv[3]);
    for (int number = first; number < end; number++) {
        if (!(of_graph ? print_graph(number) : print_decompositions(number))) return 1;
    }
    return 0;
}
