#include "planner/search.h"

// Fly to the grasp with the attitude held, then turn +x onto the beam's axis the shortest way; half a turn has no shortest
// way, so the cheapest of several.
static void transit(const ssv_problem_t* problem, const ssv_grasp_t* grasp, ssv_flight_t* best, int* num_priced) {
    const ssv_scenario_t* scenario = &problem->scenario;
    const ssv_assembly_t alone = ssv_vehicle_alone(problem);
    const quat_t q_SI = quat_conj(scenario->X_IS.q);
    const vec3_t origin = vec3(REAL(0), REAL(0), REAL(0));
    const vec3_t d_S = quat_apply(q_SI, vec3_sub(ssv_grasp_position(scenario, grasp), scenario->X_IS.p));
    const vec3_t goal_S = quat_apply(q_SI, vec3_neg(ssv_grasp_radial(scenario, grasp)));
    vec3_t axis[SSV_NUM_TURN_AXES];
    real_t angle;
    const int num_axes = ssv_grasp_turn_axes(vec3(REAL(1), REAL(0), REAL(0)), goal_S, axis, &angle);
    for (int k = 0; k < num_axes; k++) {
        ssv_flight_t trial;
        trial.num_moves = 2;
        trial.move[0] = ssv_move_translate(SSV_TRANSIT, d_S);
        trial.move[1] = ssv_move_turn(SSV_TRANSIT, axis[k], angle, origin);
        ssv_flight_price(problem, &alone, scenario->X_IS, &trial);
        if (k == 0 || ssv_price_beats(&trial.price, &best->price)) *best = trial;
    }
    *num_priced += num_axes - 1;
}

// Turn about C until the beam's outward axis faces the port, then fly its contact there.
static void transfer(const ssv_problem_t* problem, const ssv_assembly_t* pair, int contact, pose_t X_IS, ssv_flight_t* best,
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
        ssv_flight_t trial;
        trial.num_moves = 2;
        trial.move[0] = ssv_move_turn(SSV_TRANSFER, axis[k], angle, centre_S);
        const pose_t turned = ssv_move_pose(X_IS, trial.move[0].twist, trial.move[0].length);
        const vec3_t p_IE = pose_mul(turned, pose_mul(pair->X_SB, (pose_t){p_BE, quat_identity()})).p;
        const vec3_t d_I = vec3_sub(scenario->p_IP_m, p_IE);
        trial.move[1] = ssv_move_translate(SSV_TRANSFER, quat_apply(quat_conj(turned.q), d_I));
        ssv_flight_price(problem, pair, X_IS, &trial);
        if (k == 0 || ssv_price_beats(&trial.price, &best->price)) *best = trial;
    }
    *num_priced += num_axes - 1;
}

void ssv_search_paper(const ssv_problem_t* problem, int contact, real_t height_m, ssv_chain_t* best, int* num_priced) {
    real_t ring_angle_rad[SSV_NUM_RING_ANGLES];
    const int num_rings = ssv_grasp_ring_angles(&problem->scenario, ring_angle_rad);
    for (int k = 0; k < num_rings; k++) {
        const ssv_grasp_t grasp = {contact, height_m, ring_angle_rad[k]};
        ssv_flight_t to_beam, to_port;
        ssv_chain_t trial;
        transit(problem, &grasp, &to_beam, num_priced);
        const ssv_assembly_t pair = ssv_vehicle_with_beam(problem, to_beam.X_IS_end);
        transfer(problem, &pair, contact, to_beam.X_IS_end, &to_port, num_priced);
        ssv_chain_join(&grasp, &to_beam, &to_port, pair.X_SB, &trial);
        *num_priced += 1;
        if (k == 0 || ssv_price_beats(&trial.price, &best->price)) *best = trial;
    }
}
