#include "planner/search/optimal.h"

#include "planner/math/assert.h"
#include "planner/model/grasp.h"
#include "planner/motion/maneuver.h"
#include "planner/motion/path.h"
#include "planner/motion/question.h"
#include "planner/search/budget.h"
#include "planner/search/decision.h"
#include "planner/search/minimize.h"
#include "planner/search/seed.h"
#include "ssv/vec3.h"

static ssv_seeds_t fresh(ssv_phase_context_t* context, ssv_memory_t* memory, const ssv_draw_t* draw) {
    const ssv_seeds_t seeds = ssv_screen_transfers(context, memory, draw);
    for (int k = 0; k < seeds.num; k++) ssv_screen_both_ways_up(context, &memory->capability, &seeds.seed[k]);
    return seeds;
}

// Seeds of the transfer with the price of their transits: those that screening kept, or fresh ones.
static ssv_seeds_t begin(ssv_phase_context_t* context, ssv_memory_t* memory, const ssv_budget_t* budget) {
    if (!budget->draws) {
        SSV_ASSERT(0 < memory->num_screened && memory->num_screened <= SSV_SCREENED_SEEDS);
        const ssv_seeds_t seeds = {memory->seed, memory->num_screened, SSV_MAX_SEEDS};
        for (int k = 0; k < seeds.num; k++) seeds.seed[k] = memory->screened[k];
        return seeds;
    }
    return fresh(context, memory, &ssv_draws[memory->capability.regime].best);
}

// Refines fresh seeds, one after the other, until one is clear. @return which.
static int evade(ssv_phase_context_t* context, const ssv_budget_t* budget, ssv_seeds_t* seeds) {
    const ssv_stage_t* stage = &budget->evasion[SSV_TRANSFER];
    ssv_seeds_sort(seeds, seeds->num);
    ssv_seeds_drop_duplicates(seeds);
    for (int k = 0; k < stage->num_refined && k < seeds->num; k++) {
        ssv_seed_t* seed = &seeds->seed[k];
        ssv_minimize(context, &budget->acceptance, stage, &seed->decision, &seed->price);
        if (ssv_decision_keeps_clear(context, &seed->decision)) return k;
    }
    return 0;
}

// The best transfer and its transit that the budget finds.
SSV_OWN_FRAME static void find(ssv_phase_context_t* context, ssv_memory_t* memory, const ssv_budget_t* budget,
                               ssv_decision_t* transfer, ssv_decision_t* transit) {
    ssv_seeds_t seeds = begin(context, memory, budget);
    ssv_seeds_sort(&seeds, seeds.num);
    ssv_seeds_drop_duplicates(&seeds);
    for (int n = 0; n < SSV_NUM_ROUNDS; n++) {
        ssv_minimize_seeds(context, &budget->acceptance, &budget->rounds[n], &seeds);
    }
    int best = 0;
    if (budget->evasion[SSV_TRANSFER].num_refined > 0 && !ssv_decision_keeps_clear(context, &seeds.seed[0].decision)) {
        seeds = fresh(context, memory, &ssv_evasion_draw);
        best = evade(context, budget, &seeds);
    }
    *transfer = seeds.seed[best].decision;
    real_t price = seeds.seed[best].price +
                   ssv_screen_transit(context, &memory->capability, SSV_MAX_TRANSIT_SEEDS, budget, transfer, transit);
    context->transit_before = transit;
    ssv_minimize(context, &budget->acceptance, &budget->joint, transfer, &price);
}

static void price_phase(const ssv_question_t* question, const ssv_motion_t* motion, ssv_phase_path_t* phase) {
    phase->num_maneuvers = motion->num_maneuvers;
    for (int k = 0; k < motion->num_maneuvers; k++) phase->maneuver[k] = motion->maneuver[k];
    ssv_phase_path_price(question, &motion->assembly, NULL, phase);
}

// A motion that comes too near something is none, whatever it costs.
static void refuse_contact(const ssv_phase_context_t* context, const ssv_motion_t* motion, ssv_phase_path_t* phase,
                           ssv_clearance_t* clearance) {
    if (!context->question->problem->around.counts || phase->price.outcome != SSV_FEASIBLE) return;
    if (!ssv_motion_keeps_clear(context, motion, clearance)) phase->maneuver_price[0].outcome = SSV_NO_WAY;
}

// The exact price of what was found, and its path in *best if that is cheaper.
SSV_OWN_FRAME static ssv_candidate_t price_exactly(const ssv_phase_context_t* context, const ssv_decision_t* transfer,
                                                   const ssv_decision_t* transit, ssv_path_t* best) {
    ssv_motion_t motion;
    ssv_phase_path_t to_port, to_beam;
    ssv_clearance_t clearance;
    ssv_decision_motion(context, transfer, &motion);
    const ssv_grasp_t grasp = ssv_phase_grasp(context, &motion.X_from);
    const pose_t X_SB = motion.assembly.X_SB;
    price_phase(context->question, &motion, &to_port);
    refuse_contact(context, &motion, &to_port, &clearance);
    const ssv_phase_context_t before = ssv_transit_context(context, &motion.X_from);
    ssv_decision_motion(&before, transit, &motion);
    price_phase(context->question, &motion, &to_beam);
    if (ssv_path_price(&to_beam, &to_port).outcome == SSV_FEASIBLE)
        refuse_contact(&before, &motion, &to_beam, &clearance);
    const ssv_price_t price = ssv_path_price(&to_beam, &to_port);
    if (ssv_price_beats(&price, &best->price)) ssv_path_join(&grasp, &to_beam, &to_port, X_SB, best);
    return ssv_candidate_of(&grasp, &price, &clearance);
}

ssv_candidate_t ssv_optimal_search(const ssv_search_t* search, int contact, real_t height_m, ssv_effort_t effort) {
    const ssv_budget_t* budget = ssv_budget(search->memory->capability.regime, effort);
    ssv_phase_context_t context = ssv_transfer_context(search->question, contact, height_m);
    context.closeness = budget->closeness;
    ssv_decision_t transfer, transit;
    find(&context, search->memory, budget, &transfer, &transit);
    *search->num_priced += context.num_priced;
    return price_exactly(&context, &transfer, &transit, search->best);
}
