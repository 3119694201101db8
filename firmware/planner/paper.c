#include "planner/search.h"

// What a straight flight costs at least. The drag of a beam might take load off some thruster: nothing is said of it then.
static real_t straight_price(const ssv_problem_t* problem, const ssv_assembly_t* assembly, const ssv_move_t* translation) {
    const ssv_beam_t* beam = assembly->beam;
    if (beam != NULL && (beam->drag_strip_kg_m2 > REAL(0) || beam->body.drag_lin_kg_s > REAL(0) ||
                         beam->body.drag_quad_kg_m > REAL(0))) {
        return REAL(0);
    }
    return real_mul(translation->length, ssv_metre_price(problem, translation->twist.v));
}

// Fly to the grasp with the attitude held, then turn +x onto the beam's axis the shortest way; half a turn has no shortest
// way, so the cheapest of several.
static bool transit(const ssv_problem_t* problem, const ssv_grasp_t* grasp, real_t give_up, ssv_flight_t* best,
                    int* num_priced) {
    const ssv_scenario_t* scenario = &problem->scenario;
    const ssv_assembly_t alone = ssv_vehicle_alone(problem);
    const quat_t q_SI = quat_conj(scenario->X_IS.q);
    const vec3_t origin = vec3(REAL(0), REAL(0), REAL(0));
    const vec3_t d_S = quat_apply(q_SI, vec3_sub(ssv_grasp_position(scenario, grasp), scenario->X_IS.p));
    const vec3_t goal_S = quat_apply(q_SI, vec3_neg(ssv_grasp_radial(scenario, grasp)));
    vec3_t axis[SSV_NUM_TURN_AXES];
    real_t angle;
    const int num_axes = ssv_grasp_turn_axes(vec3(REAL(1), REAL(0), REAL(0)), goal_S, axis, &angle);
    int priced = 0;
    for (int k = 0; k < num_axes; k++) {
        ssv_flight_t trial;
        trial.num_moves = 2;
        trial.move[0] = ssv_move_translate(SSV_TRANSIT, d_S);
        trial.move[1] = ssv_move_turn(SSV_TRANSIT, axis[k], angle, origin);
        if (straight_price(problem, &alone, &trial.move[0]) >= give_up) continue;
        ssv_flight_price(problem, &alone, scenario->X_IS, &trial);
        if (priced == 0 || ssv_price_beats(&trial.price, &best->price)) *best = trial;
        priced++;
    }
    *num_priced += priced;
    return priced > 0;
}

// Turn about C until the beam's outward axis faces the port, then fly its contact there.
static bool transfer(const ssv_problem_t* problem, const ssv_assembly_t* pair, int contact, pose_t X_IS, real_t give_up,
                     ssv_flight_t* best, int* num_priced) {
    const ssv_scenario_t* scenario = &problem->scenario;
    const vec3_t p_BE = ssv_grasp_contact(scenario, contact);
    const vec3_t outward_S = quat_apply(pair->X_SB.q, vec3_unit(p_BE));
    const vec3_t goal_S = quat_apply(quat_conj(X_IS.q), vec3_neg(scenario->axis_I));
    const vec3_t centre_S = ssv_body_centre(pair);
    vec3_t axis[SSV_NUM_TURN_AXES];
    real_t angle;
    const int num_axes = ssv_grasp_turn_axes(outward_S, goal_S, axis, &angle);
    int priced = 0;
    for (int k = 0; k < num_axes; k++) {
        ssv_flight_t trial;
        trial.num_moves = 2;
        trial.move[0] = ssv_move_turn(SSV_TRANSFER, axis[k], angle, centre_S);
        const pose_t turned = ssv_move_pose(X_IS, trial.move[0].twist, trial.move[0].length);
        const vec3_t p_IE = pose_mul(turned, pose_mul(pair->X_SB, (pose_t){p_BE, quat_identity()})).p;
        const vec3_t d_I = vec3_sub(scenario->p_IP_m, p_IE);
        trial.move[1] = ssv_move_translate(SSV_TRANSFER, quat_apply(quat_conj(turned.q), d_I));
        if (straight_price(problem, pair, &trial.move[1]) >= give_up) continue;
        ssv_flight_price(problem, pair, X_IS, &trial);
        if (priced == 0 || ssv_price_beats(&trial.price, &best->price)) *best = trial;
        priced++;
    }
    *num_priced += priced;
    return priced > 0;
}

bool ssv_search_paper(const ssv_problem_t* problem, int contact, real_t height_m, real_t give_up, ssv_chain_t* best,
                      int* num_priced) {
    real_t ring_angle_rad[SSV_NUM_RING_ANGLES];
    const int num_rings = ssv_grasp_ring_angles(&problem->scenario, ring_angle_rad);
    bool found = false;
    for (int k = 0; k < num_rings; k++) {
        const ssv_grasp_t grasp = {contact, height_m, ring_angle_rad[k]};
        ssv_flight_t to_beam, to_port;
        ssv_chain_t trial;
        int priced = 0;
        if (!transit(problem, &grasp, give_up, &to_beam, &priced)) continue;
        const ssv_assembly_t pair = ssv_vehicle_with_beam(problem, to_beam.X_IS_end);
        const real_t left = give_up - to_beam.price.cost;
        if (!transfer(problem, &pair, contact, to_beam.X_IS_end, left, &to_port, &priced)) continue;
        *num_priced += priced - 1; // the axes of a half turn are tried in one phase at a time
        ssv_chain_join(&grasp, &to_beam, &to_port, pair.X_SB, &trial);
        if (!found || ssv_price_beats(&trial.price, &best->price)) *best = trial;
        found = true;
    }
    return found;
}
