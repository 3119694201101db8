#include "planner/search/screen.h"

#include "planner/math/assert.h"
#include "planner/motion/price_order.h"
#include "planner/search/minimize.h"
#include "planner/search/tolerance.h"
#include "ssv/scenario.h"
#include "ssv/vec3.h"

real_t ssv_screen_flights(const ssv_search_t* search, int contact, real_t height_m) {
    const ssv_scenario_t* s = &search->question->problem->scenario;
    const ssv_phase_context_t transfer = ssv_transfer_context(search->question, contact, height_m);
    const real_t to_beam_m = vec3_norm(vec3_sub(transfer.hold_I[0], s->X_IS.p));
    const real_t to_port_m = vec3_norm(vec3_sub(transfer.hold_I[1], transfer.hold_I[0]));
    const real_t least_m =
        real_max(REAL(0), to_beam_m - s->standoff_m) + real_max(REAL(0), to_port_m - real_mul(REAL(2), s->standoff_m));
    return real_mul(search->memory->capability.least, least_m);
}

real_t ssv_screen_transit(ssv_phase_context_t* context, const ssv_capability_t* capability, int num_seeds,
                          const ssv_budget_t* budget, const ssv_decision_t* transfer, ssv_decision_t* transit) {
    SSV_ASSERT(0 < num_seeds && num_seeds <= SSV_MAX_TRANSIT_SEEDS);
    ssv_seed_t list[SSV_MAX_TRANSIT_SEEDS];
    ssv_seeds_t seeds = {list, 0, num_seeds};
    const pose_t X_to = ssv_decision_start(context, transfer);
    ssv_phase_context_t before = ssv_transit_context(context, &X_to);
    ssv_seed_transit(&before, capability, &seeds);
    ssv_seeds_price(&before, &seeds);
    if (budget != NULL) {
        ssv_minimize_seeds(&before, &budget->acceptance, &budget->transit, &seeds);
        if (!ssv_decision_keeps_clear(&before, &list[0].decision))
            ssv_minimize_seeds(&before, &budget->acceptance, &budget->evasion[SSV_TRANSIT], &seeds);
    }
    context->num_priced += before.num_priced;
    if (transit != NULL) *transit = list[0].decision;
    return list[0].price;
}

static real_t screened_transit_price(ssv_phase_context_t* context, const ssv_capability_t* capability,
                                     const ssv_decision_t* transfer) {
    return ssv_screen_transit(context, capability, SSV_SCREENED_TRANSIT_SEEDS, NULL, transfer, NULL);
}

void ssv_screen_both_ways_up(ssv_phase_context_t* context, const ssv_capability_t* capability, ssv_seed_t* transfer) {
    ssv_seed_t other = *transfer;
    other.decision = ssv_other_way_up(&transfer->decision);
    if (!capability->either_way_up) other.price = ssv_decision_price(context, &other.decision);
    transfer->transit_price = screened_transit_price(context, capability, &transfer->decision);
    other.transit_price = screened_transit_price(context, capability, &other.decision);
    if (ssv_clearly_less(ssv_seed_total(&other), ssv_seed_total(transfer))) *transfer = other;
}

ssv_seeds_t ssv_screen_transfers(ssv_phase_context_t* context, ssv_memory_t* memory, const ssv_draw_t* draw) {
    ssv_seeds_t all = {memory->seed, 0, SSV_MAX_SEEDS};
    ssv_seed_begin(context, &memory->capability);
    for (int mode = 0; mode < SSV_NUM_ATTITUDE_MODES; mode++) {
        if (draw->num[mode] == 0) continue;
        SSV_ASSERT(all.num + draw->num[mode] <= SSV_MAX_SEEDS);
        ssv_seeds_t seeds = {&memory->seed[all.num], 0, draw->num[mode]};
        ssv_seed_transfer(context, &memory->capability, (ssv_attitude_mode_t)mode, &seeds);
        all.num += seeds.num;
    }
    ssv_seeds_price(context, &all);
    return all;
}

real_t ssv_screen(const ssv_search_t* search, int contact, real_t height_m, const real_t* to_beat) {
    ssv_memory_t* memory = search->memory;
    ssv_phase_context_t context = ssv_transfer_context(search->question, contact, height_m);
    const ssv_draws_t* draws = &ssv_draws[memory->capability.regime];
    ssv_seeds_t seeds = ssv_screen_transfers(&context, memory, &draws->screening);
    const ssv_seed_t* list = seeds.seed;
    SSV_ASSERT(seeds.num > 0);
    // A transfer that costs a little more may have a transit that costs much less. Where both together cost the same,
    // refinement decides.
    const real_t least = list[0].price, worth = real_mul(SSV_TRANSIT_DECIDES, least);
    int num = 0;
    for (; num < seeds.num; num++) {
        const bool near = num < draws->num_transits && list[num].price < worth;
        if (!near && !ssv_alike(least, list[num].price)) break;
        ssv_screen_both_ways_up(&context, &memory->capability, &seeds.seed[num]);
    }
    ssv_seeds_sort(&seeds, num);
    *search->num_priced += context.num_priced;
    const real_t price = ssv_seed_total(&list[0]);
    if (to_beat != NULL && !ssv_clearly_less(price, *to_beat)) return price;
    memory->screened[0] = list[0];
    memory->num_screened = 1;
    for (int k = 1; k < num && ssv_alike(price, ssv_seed_total(&list[k])); k++) {
        memory->screened[memory->num_screened++] = list[k];
    }
    return price;
}
