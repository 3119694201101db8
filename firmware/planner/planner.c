#include "ssv/planner.h"

#include "planner/quote.h"
#include "planner/timeline.h"

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
    leg->t_start_s = plan->quote.time_s;
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
        const real_t t_s = plan->quote.time_s + piece->t_s;
        const ssv_outcome_t cut = ssv_timeline_append(&thrusts, piece, t_s, index, drift_max_s2, plan);
        if (cut != SSV_FEASIBLE) return cut;
    }
    plan->quote.time_s += price.time_s;
    plan->quote.impulse_Ns += price.impulse_Ns;
    plan->quote.cost += price.cost;
    return SSV_FEASIBLE;
}

static void add_event(ssv_plan_t* plan, ssv_event_kind_t kind) {
    plan->event[plan->num_events++] = (ssv_event_t){plan->quote.time_s, kind};
}

// Writes the motion of a chain: legs, pieces, timeline, events, final poses.
static ssv_outcome_t write_motion(const ssv_problem_t* problem, const ssv_chain_t* chain, real_t drift_max_s2, ssv_plan_t* plan) {
    const ssv_scenario_t* scenario = &problem->scenario;
    ssv_assembly_t assembly = {&scenario->vehicle, NULL, chain->X_SB};
    pose_t X_IS = scenario->X_IS;
    plan->quote.time_s = plan->quote.impulse_Ns = plan->quote.cost = REAL(0);
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

// How closely the timeline is cut [s2]: as finely as the plan's memory allows.
#define NUM_DRIFTS 6
static const real_t drift_max_s2[NUM_DRIFTS] = {REAL(1e-6), REAL(4e-6), REAL(1.6e-5), REAL(6.4e-5), REAL(2.5e-4), REAL(1e-3)};

// Writes the chain with the finest timeline that fits.
static ssv_outcome_t write_plan(const ssv_problem_t* problem, const ssv_chain_t* chain, ssv_plan_t* plan) {
    ssv_outcome_t outcome = SSV_TOO_MANY_SEGMENTS;
    for (int n = 0; n < NUM_DRIFTS && outcome == SSV_TOO_MANY_SEGMENTS; n++) {
        outcome = write_motion(problem, chain, drift_max_s2[n], plan);
    }
    return outcome;
}

ssv_status_t ssv_plan(const ssv_problem_t* problem, ssv_plan_t* plan) {
    ssv_chain_t chain;
    memset(plan, 0, sizeof *plan);
    bool found = ssv_choose(problem, &plan->quote, &chain);
    ssv_outcome_t outcome = found ? write_plan(problem, &chain, plan) : SSV_FEASIBLE;
    if (outcome != SSV_FEASIBLE) {
        // It does not fit the plan's memory. Then the paper's method is asked, candidate by candidate.
        ssv_problem_t plain = *problem;
        plain.scenario.method = SSV_METHOD_PAPER;
        found = ssv_choose(&plain, &plan->quote, &chain);
        for (int n = 0; n < SSV_MAX_CANDIDATES && found; n++) {
            outcome = write_plan(&plain, &chain, plan);
            if (outcome == SSV_FEASIBLE) break;
            found = ssv_choose_another(&plain, outcome, &plan->quote, &chain);
        }
    }
    if (found) {
        ssv_quote_settle(problem, &chain, &plan->quote);
        plan->plan_hash = ssv_plan_hash(plan);
        return SSV_OK;
    }
    const ssv_quote_t quote = plan->quote;
    memset(plan, 0, sizeof *plan);
    plan->quote = quote;
    return SSV_INFEASIBLE;
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
    if (t_s >= plan->quote.time_s) return;
    sample_motion(plan, &plan->leg[sample->leg], t_s, sample);
    int k = 0;
    while (k + 1 < plan->num_segments && plan->segment[k + 1].t_s <= t_s) k++;
    const ssv_segment_t* segment = &plan->segment[k];
    const real_t along = clamp(real_div(t_s - segment->t_s, segment->duration_s), REAL(0), REAL(1));
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        sample->u_N[i] = segment->u_start_N[i] + real_mul(along, segment->u_end_N[i] - segment->u_start_N[i]);
    }
}
