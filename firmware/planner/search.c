#include "planner/search.h"

#define MOVES_PER_PHASE 2

// One phase: its moves and what each costs, where the vehicle ends, and what all of it costs.
typedef struct {
    ssv_move_t move[MOVES_PER_PHASE];
    ssv_price_t move_price[MOVES_PER_PHASE];
    pose_t X_IS_end;
    ssv_price_t price;
} phase_t;

static void add_price(ssv_price_t* sum, const ssv_price_t* price) {
    if (sum->outcome == SSV_FEASIBLE) sum->outcome = price->outcome;
    sum->time_s += price->time_s;
    sum->impulse_Ns += price->impulse_Ns;
    sum->cost += price->cost;
}

static void price_phase(const ssv_problem_t* problem, const ssv_assembly_t* assembly, pose_t X_IS, phase_t* phase) {
    phase->X_IS_end = X_IS;
    phase->price = (ssv_price_t){SSV_FEASIBLE, REAL(0), REAL(0), REAL(0)};
    for (int k = 0; k < MOVES_PER_PHASE; k++) {
        const ssv_move_t* move = &phase->move[k];
        ssv_thrusts_t thrusts;
        ssv_profile_t profile;
        ssv_ramp_t ramp;
        ssv_move_thrusts(problem, assembly, move->twist, &thrusts);
        phase->move_price[k] = ssv_move_solve(problem, move, &thrusts, &profile, &ramp);
        add_price(&phase->price, &phase->move_price[k]);
        phase->X_IS_end = ssv_move_pose(phase->X_IS_end, move->twist, move->length);
    }
}

// Fly to the grasp with the attitude held, then turn +x onto the beam's axis the shortest way; half a turn has no shortest
// way, so the cheapest of several.
static void transit(const ssv_problem_t* problem, const ssv_grasp_t* grasp, phase_t* best, int* num_priced) {
    const ssv_scenario_t* scenario = &problem->scenario;
    const ssv_assembly_t alone = {&scenario->vehicle, NULL, {{REAL(0), REAL(0), REAL(0)}, quat_identity()}};
    const quat_t q_SI = quat_conj(scenario->X_IS.q);
    const vec3_t origin = vec3(REAL(0), REAL(0), REAL(0));
    const vec3_t d_S = quat_apply(q_SI, vec3_sub(ssv_grasp_position(scenario, grasp), scenario->X_IS.p));
    const vec3_t goal_S = quat_apply(q_SI, vec3_neg(ssv_grasp_radial(scenario, grasp)));
    vec3_t axis[SSV_NUM_TURN_AXES];
    real_t angle;
    const int num_axes = ssv_grasp_turn_axes(vec3(REAL(1), REAL(0), REAL(0)), goal_S, axis, &angle);
    for (int k = 0; k < num_axes; k++) {
        phase_t trial;
        trial.move[0] = ssv_move_translate(SSV_TRANSIT, d_S);
        trial.move[1] = ssv_move_turn(SSV_TRANSIT, axis[k], angle, origin);
        price_phase(problem, &alone, scenario->X_IS, &trial);
        if (k == 0 || ssv_price_beats(&trial.price, &best->price)) *best = trial;
    }
    *num_priced += num_axes - 1;
}

// Turn about C until the beam's outward axis faces the port, then fly its contact there.
static void transfer(const ssv_problem_t* problem, const ssv_assembly_t* pair, int contact, pose_t X_IS, phase_t* best,
                     int* num_priced) {
    const ssv_scenario_t* scenario = &problem->scenario;
    const vec3_t p_BE = ssv_grasp_contact(scenario, contact);
    const vec3_t outward_S = quat_apply(pair->X_SB.q, vec3_unit(p_BE));
    const vec3_t goal_S = quat_apply(quat_conj(X_IS.q), vec3_neg(scenario->axis_I));
    const vec3_t centre_S = ssv_body_centre(pair);
    vec3_t axis[SSV_NUM_TURN_AXES];
    real_t angle;
    const int num_axes = ssv_grasp_turn_axes(outward_S, goal_S, axis, &angle);
    for (int k = 0; k < num_axes; k++) {
        phase_t trial;
        trial.move[0] = ssv_move_turn(SSV_TRANSFER, axis[k], angle, centre_S);
        const pose_t turned = ssv_move_pose(X_IS, trial.move[0].twist, trial.move[0].length);
        const vec3_t p_IE = pose_mul(turned, pose_mul(pair->X_SB, (pose_t){p_BE, quat_identity()})).p;
        const vec3_t d_I = vec3_sub(scenario->p_IP_m, p_IE);
        trial.move[1] = ssv_move_translate(SSV_TRANSFER, quat_apply(quat_conj(turned.q), d_I));
        price_phase(problem, pair, X_IS, &trial);
        if (k == 0 || ssv_price_beats(&trial.price, &best->price)) *best = trial;
    }
    *num_priced += num_axes - 1;
}

static void price_grasp(const ssv_problem_t* problem, const ssv_grasp_t* grasp, ssv_chain_t* chain, int* num_priced) {
    const ssv_scenario_t* scenario = &problem->scenario;
    phase_t to_beam, to_port;
    *num_priced += 1;
    chain->grasp = *grasp;
    transit(problem, grasp, &to_beam, num_priced);
    chain->X_IS_mate = to_beam.X_IS_end;
    chain->X_SB = pose_mul(pose_inv(to_beam.X_IS_end), scenario->X_IB);
    const ssv_assembly_t pair = {&scenario->vehicle, &scenario->beam, chain->X_SB};
    transfer(problem, &pair, grasp->contact, to_beam.X_IS_end, &to_port, num_priced);
    chain->num_moves = 0;
    for (int k = 0; k < MOVES_PER_PHASE; k++) chain->move[chain->num_moves++] = to_beam.move[k];
    for (int k = 0; k < MOVES_PER_PHASE; k++) chain->move[chain->num_moves++] = to_port.move[k];
    // Move by move, as the plan's legs will be added up: the price quoted is the price of the plan, to the last bit.
    chain->price = to_beam.price;
    for (int k = 0; k < MOVES_PER_PHASE; k++) add_price(&chain->price, &to_port.move_price[k]);
    if (chain->price.outcome == SSV_FEASIBLE && chain->price.time_s > SSV_DURATION_MAX_S) chain->price.outcome = SSV_TOO_LONG;
}

void ssv_search(const ssv_problem_t* problem, int contact, real_t height_m, const real_t* ring_angle_rad, int num_rings,
                ssv_chain_t* best, int* num_priced) {
    for (int k = 0; k < num_rings; k++) {
        const ssv_grasp_t grasp = {contact, height_m, ring_angle_rad[k]};
        ssv_chain_t trial;
        price_grasp(problem, &grasp, &trial, num_priced);
        if (k == 0 || ssv_price_beats(&trial.price, &best->price)) *best = trial;
    }
}
