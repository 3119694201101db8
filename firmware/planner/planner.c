#include "ssv/planner.h"

#include "planner/search.h"
#include "planner/timeline.h"

static ssv_candidate_t candidate_of(const ssv_chain_t* chain) {
    ssv_candidate_t candidate = {chain->grasp.contact, chain->grasp.height_m, chain->grasp.ring_angle_rad, chain->price.outcome,
                                 REAL(0), REAL(0), REAL(0)};
    if (chain->price.outcome == SSV_FEASIBLE) {
        candidate.time_s = chain->price.time_s;
        candidate.impulse_Ns = chain->price.impulse_Ns;
        candidate.cost = chain->price.cost;
    }
    return candidate;
}

// Solves the move once more and writes its leg, pieces and segments.
static ssv_outcome_t add_leg(const ssv_problem_t* problem, const ssv_assembly_t* assembly, const ssv_move_t* move, pose_t X_IS,
                             real_t drift_max_s2, ssv_plan_t* plan) {
    ssv_thrusts_t thrusts;
    ssv_profile_t profile;
    ssv_ramp_t ramp;
    ssv_move_thrusts(problem, assembly, move->twist, &thrusts);
    const ssv_price_t price = ssv_move_solve(problem, move, &thrusts, &profile, &ramp);
    if (price.outcome != SSV_FEASIBLE) return price.outcome;
    if (plan->num_pieces + profile.num_pieces > SSV_MAX_PIECES) return SSV_TOO_MANY_PIECES;
    const int index = plan->num_legs++;
    ssv_leg_t* leg = &plan->leg[index];
    leg->phase = move->phase;
    leg->kind = move->kind;
    leg->ramp = ramp;
    leg->t_start_s = plan->time_s;
    leg->duration_s = price.time_s;
    leg->impulse_Ns = price.impulse_Ns;
    leg->length = move->length;
    leg->peak_speed = profile.peak_speed;
    leg->v_S = move->twist.v;
    leg->w_S = move->twist.w;
    leg->X_IS_start = X_IS;
    leg->X_IS_end = ssv_move_pose(X_IS, move->twist, move->length);
    leg->first_piece = plan->num_pieces;
    leg->num_pieces = profile.num_pieces;
    for (int k = 0; k < profile.num_pieces; k++) {
        const ssv_piece_t* piece = &profile.piece[k];
        plan->piece[plan->num_pieces++] = *piece;
        const real_t t_s = plan->time_s + piece->t_s;
        const ssv_outcome_t cut = ssv_timeline_append(&thrusts, piece, t_s, index, drift_max_s2, plan);
        if (cut != SSV_FEASIBLE) return cut;
    }
    plan->time_s += price.time_s;
    plan->impulse_Ns += price.impulse_Ns;
    plan->cost += price.cost;
    return SSV_FEASIBLE;
}

static void add_event(ssv_plan_t* plan, ssv_event_kind_t kind) {
    plan->event[plan->num_events++] = (ssv_event_t){plan->time_s, kind};
}

// Writes the motion of a chain: legs, pieces, timeline, events, final poses.
static ssv_outcome_t write_motion(const ssv_problem_t* problem, const ssv_chain_t* chain, real_t drift_max_s2, ssv_plan_t* plan) {
    const ssv_scenario_t* scenario = &problem->scenario;
    ssv_assembly_t assembly = {&scenario->vehicle, NULL, chain->X_SB};
    pose_t X_IS = scenario->X_IS;
    plan->time_s = plan->impulse_Ns = plan->cost = REAL(0);
    plan->num_legs = plan->num_pieces = plan->num_segments = plan->num_events = 0;
    for (int k = 0; k < chain->num_moves; k++) {
        const ssv_move_t* move = &chain->move[k];
        if (move->phase == SSV_TRANSFER && assembly.beam == NULL) {
            add_event(plan, SSV_MATE);
            assembly.beam = &scenario->beam;
        }
        if (!(move->length > REAL(0))) continue;
        const ssv_outcome_t outcome = add_leg(problem, &assembly, move, X_IS, drift_max_s2, plan);
        if (outcome != SSV_FEASIBLE) return outcome;
        X_IS = plan->leg[plan->num_legs - 1].X_IS_end;
    }
    add_event(plan, SSV_DOCK);
    plan->X_SB = chain->X_SB;
    plan->X_IS_final = X_IS;
    plan->X_IB_final = pose_mul(X_IS, chain->X_SB);
    return SSV_FEASIBLE;
}

// The cheapest candidate that is still feasible.
static int cheapest(const ssv_plan_t* plan) {
    int best = -1;
    for (int k = 0; k < plan->num_candidates; k++) {
        const ssv_candidate_t* candidate = &plan->candidate[k];
        if (candidate->outcome != SSV_FEASIBLE) continue;
        if (best < 0 || candidate->cost < plan->candidate[best].cost) best = k;
    }
    return best;
}

// How closely the timeline is cut [s2]: as finely as the plan's memory allows.
#define NUM_DRIFTS 6
static const real_t drift_max_s2[NUM_DRIFTS] = {REAL(1e-6), REAL(4e-6), REAL(1.6e-5), REAL(6.4e-5), REAL(2.5e-4), REAL(1e-3)};
// No price is above it.
#define NEVER_GIVE_UP REAL(1e9)
// Candidates that method optimal searches thoroughly, by effort: the cheapest after a first look at all.
static const int num_thorough[] = {[SSV_EFFORT_QUICK] = 1, [SSV_EFFORT_BEST] = 3};

// Enters what a search of a candidate found, if it is cheaper than what is there.
static void improve(ssv_plan_t* plan, int k, const ssv_chain_t* chain, ssv_chain_t* best) {
    const ssv_candidate_t found = candidate_of(chain);
    const ssv_candidate_t* known = &plan->candidate[k];
    if (known->outcome != SSV_FEASIBLE || (found.outcome == SSV_FEASIBLE && found.cost < known->cost)) plan->candidate[k] = found;
    if (ssv_price_beats(&chain->price, &best->price)) *best = *chain;
}

static void list_candidates(const ssv_scenario_t* scenario, ssv_plan_t* plan) {
    for (int contact = 1; contact <= SSV_NUM_CONTACTS; contact++) {
        if (scenario->contact != 0 && scenario->contact != contact) continue;
        for (int k = 0; k < scenario->num_attach_heights; k++) {
            plan->candidate[plan->num_candidates++] = (ssv_candidate_t){
                contact, scenario->attach_heights_m[k], REAL(0), SSV_NO_AUTHORITY, REAL(0), REAL(0), REAL(0)};
        }
    }
}

// The paper's chain of each candidate; not those whose straight flights alone cost give_up.
static void search_paper(const ssv_problem_t* problem, real_t give_up, ssv_plan_t* plan, ssv_chain_t* best) {
    ssv_chain_t chain;
    for (int k = 0; k < plan->num_candidates; k++) {
        const ssv_candidate_t* candidate = &plan->candidate[k];
        if (ssv_search_paper(problem, candidate->contact, candidate->attach_height_m, give_up, &chain, &plan->num_priced)) {
            improve(plan, k, &chain, best);
        }
    }
}

// A first look at every candidate, then a thorough search of the cheapest.
static void search_optimal(const ssv_problem_t* problem, ssv_effort_t effort, ssv_plan_t* plan, ssv_chain_t* best) {
    bool done[SSV_MAX_CANDIDATES] = {false};
    ssv_chain_t chain;
    for (int k = 0; k < plan->num_candidates; k++) {
        const ssv_candidate_t* candidate = &plan->candidate[k];
        ssv_search_optimal(problem, candidate->contact, candidate->attach_height_m, effort, false, &chain, &plan->num_priced);
        improve(plan, k, &chain, best);
    }
    for (int n = 0; n < num_thorough[effort]; n++) {
        int next = -1;
        for (int k = 0; k < plan->num_candidates; k++) {
            if (done[k] || plan->candidate[k].outcome != SSV_FEASIBLE) continue;
            if (next < 0 || plan->candidate[k].cost < plan->candidate[next].cost) next = k;
        }
        if (next < 0) break;
        const ssv_candidate_t* candidate = &plan->candidate[next];
        done[next] = true;
        ssv_search_optimal(problem, candidate->contact, candidate->attach_height_m, effort, true, &chain, &plan->num_priced);
        improve(plan, next, &chain, best);
    }
}

// Writes the chain with the finest timeline that fits.
static ssv_outcome_t write_plan(const ssv_problem_t* problem, const ssv_chain_t* chain, ssv_plan_t* plan) {
    ssv_outcome_t outcome = SSV_TOO_MANY_SEGMENTS;
    for (int n = 0; n < NUM_DRIFTS && outcome == SSV_TOO_MANY_SEGMENTS; n++) {
        outcome = write_motion(problem, chain, drift_max_s2[n], plan);
    }
    return outcome;
}

ssv_status_t ssv_plan(const ssv_problem_t* problem, ssv_plan_t* plan) {
    const ssv_scenario_t* scenario = &problem->scenario;
    ssv_chain_t best;
    memset(plan, 0, sizeof *plan);
    plan->scenario_hash = problem->scenario_hash;
    best.price.outcome = SSV_TOO_LONG;
    list_candidates(scenario, plan);
    // More effort starts with what less effort does, and method optimal ends with the paper's chains where these could still
    // be cheaper: neither ever costs more.
    if (scenario->method == SSV_METHOD_OPTIMAL) {
        for (int effort = SSV_EFFORT_QUICK; effort <= (int)scenario->effort; effort++) {
            search_optimal(problem, (ssv_effort_t)effort, plan, &best);
        }
    }
    search_paper(problem, best.price.outcome == SSV_FEASIBLE ? best.price.cost : NEVER_GIVE_UP, plan, &best);
    // What is found may fail to fit the plan's memory. Then the paper's chain of the cheapest candidate is written instead,
    // and if that fails too, of the next.
    ssv_outcome_t outcome = best.price.outcome == SSV_FEASIBLE ? write_plan(problem, &best, plan) : best.price.outcome;
    for (int k = cheapest(plan); outcome != SSV_FEASIBLE && k >= 0; k = cheapest(plan)) {
        ssv_candidate_t* candidate = &plan->candidate[k];
        int num_priced = 0;
        (void)ssv_search_paper(problem, candidate->contact, candidate->attach_height_m, NEVER_GIVE_UP, &best, &num_priced);
        outcome = best.price.outcome == SSV_FEASIBLE ? write_plan(problem, &best, plan) : best.price.outcome;
        if (outcome != SSV_FEASIBLE) {
            *candidate = (ssv_candidate_t){candidate->contact, candidate->attach_height_m, candidate->ring_angle_rad, outcome,
                                           REAL(0), REAL(0), REAL(0)};
        }
    }
    if (outcome == SSV_FEASIBLE) {
        plan->choice = candidate_of(&best);
        for (int k = 0; k < plan->num_candidates; k++) {
            ssv_candidate_t* candidate = &plan->candidate[k];
            const bool chosen = candidate->contact == best.grasp.contact && candidate->attach_height_m == best.grasp.height_m;
            if (chosen) *candidate = plan->choice;
        }
        plan->lower_bound = ssv_lower_bound(problem);
        plan->status = SSV_OK;
        plan->plan_hash = ssv_plan_hash(plan);
        return plan->status;
    }
    const int num_priced = plan->num_priced, num_candidates = plan->num_candidates;
    ssv_candidate_t candidates[SSV_MAX_CANDIDATES];
    memcpy(candidates, plan->candidate, sizeof candidates);
    memset(plan, 0, sizeof *plan);
    memcpy(plan->candidate, candidates, sizeof candidates);
    plan->num_priced = num_priced;
    plan->num_candidates = num_candidates;
    plan->scenario_hash = problem->scenario_hash;
    plan->status = SSV_INFEASIBLE;
    return plan->status;
}

static real_t clamp(real_t x, real_t low, real_t high) { return real_max(low, real_min(high, x)); }

static int leg_at(const ssv_plan_t* plan, real_t t_s) {
    int leg = 0;
    while (leg + 1 < plan->num_legs && plan->leg[leg + 1].t_start_s <= t_s) leg++;
    return leg;
}

static void sample_motion(const ssv_plan_t* plan, const ssv_leg_t* leg, real_t t_s, ssv_sample_t* sample) {
    const real_t t = clamp(t_s - leg->t_start_s, REAL(0), leg->duration_s);
    int k = leg->first_piece;
    while (k + 1 < leg->first_piece + leg->num_pieces && plan->piece[k + 1].t_s <= t) k++;
    const ssv_piece_t* piece = &plan->piece[k];
    const real_t t_piece = clamp(t - piece->t_s, REAL(0), piece->duration_s);
    const real_t v = ssv_piece_speed(piece, t_piece);
    const real_t s = piece->s + ssv_piece_moments(piece, piece->v_start, v, t_piece).distance;
    const ssv_twist_t twist = {leg->v_S, leg->w_S};
    sample->X_IS = ssv_move_pose(leg->X_IS_start, twist, s);
    sample->v_IS_S_m_s = vec3_scale(v, leg->v_S);
    sample->w_IS_S_rad_s = vec3_scale(v, leg->w_S);
}

void ssv_plan_sample(const ssv_plan_t* plan, real_t t_s, ssv_sample_t* sample) {
    memset(sample, 0, sizeof *sample);
    sample->X_IS = plan->X_IS_final;
    sample->mated = t_s >= plan->event[0].t_s;
    if (plan->num_legs == 0) return;
    sample->leg = leg_at(plan, t_s);
    if (t_s < REAL(0)) {
        sample->X_IS = plan->leg[0].X_IS_start;
        return;
    }
    if (t_s >= plan->time_s) return;
    sample_motion(plan, &plan->leg[sample->leg], t_s, sample);
    int k = 0;
    while (k + 1 < plan->num_segments && plan->segment[k + 1].t_s <= t_s) k++;
    const ssv_segment_t* segment = &plan->segment[k];
    const real_t along = clamp(real_div(t_s - segment->t_s, segment->duration_s), REAL(0), REAL(1));
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        sample->u_N[i] = segment->u_start_N[i] + real_mul(along, segment->u_end_N[i] - segment->u_start_N[i]);
    }
}
