#include "planner/search/paper.h"

#include "planner/model/body.h"
#include "planner/model/grasp.h"
#include "planner/motion/clearance.h"
#include "planner/motion/maneuver.h"
#include "planner/profile/estimate.h"
#include "planner/search/bound.h"
#include "planner/search/tolerance.h"
#include "ssv/planner.h"
#include "ssv/vec3.h"

// What a straight flight costs at least. With the drag of a beam some thruster may have less to do than without.
static real_t straight_price(const ssv_question_t* question, const ssv_assembly_t* assembly,
                             const ssv_maneuver_t* translation) {
    const ssv_beam_t* beam = assembly->beam;
    const bool beam_drags = beam != NULL && (beam->drag_strip_kg_m2 > REAL(0) || beam->body.drag_lin_kg_s > REAL(0) ||
                                             beam->body.drag_quad_kg_m > REAL(0));
    const real_t per_metre =
        beam_drags ? ssv_least_metre_price(question) : ssv_metre_price(question, translation->twist.v);
    return real_mul(translation->length, per_metre);
}

// The last of three maneuvers is an approach.
static void limit(const ssv_scenario_t* scenario, const ssv_assembly_t* assembly, ssv_phase_path_t* phase) {
    for (int k = 0; k < phase->num_maneuvers; k++) ssv_maneuver_limit(scenario, assembly, k == 2, &phase->maneuver[k]);
}

// Fly to the grasp with the attitude held, then turn +x onto the beam's axis the shortest way. Half a turn has no
// shortest way: axis k of several. @return how many there are.
static int lay_transit(const ssv_scenario_t* scenario, const ssv_grasp_t* grasp, int k, ssv_phase_path_t* phase) {
    const quat_t q_SI = quat_conj(scenario->X_IS.q);
    const vec3_t radial_I = ssv_grasp_radial(scenario, grasp), mate_I = ssv_grasp_position(scenario, grasp);
    const real_t approach_m = scenario->approach_mate_m;
    const vec3_t to_I = approach_m > REAL(0) ? vec3_add(mate_I, vec3_scale(approach_m, radial_I)) : mate_I;
    const vec3_t d_S = quat_apply(q_SI, vec3_sub(to_I, scenario->X_IS.p));
    const vec3_t goal_S = quat_apply(q_SI, vec3_neg(radial_I));
    vec3_t axis[SSV_NUM_TURN_AXES];
    real_t angle;
    const int num_axes = ssv_grasp_turn_axes(vec3(REAL(1), REAL(0), REAL(0)), goal_S, axis, &angle);
    phase->num_maneuvers = 2;
    phase->maneuver[0] = ssv_maneuver_translate(SSV_TRANSIT, d_S);
    phase->maneuver[1] = ssv_maneuver_turn(SSV_TRANSIT, axis[k], angle, vec3(REAL(0), REAL(0), REAL(0)));
    if (approach_m > REAL(0)) {
        phase->maneuver[phase->num_maneuvers++] =
            ssv_maneuver_translate(SSV_TRANSIT, vec3(approach_m, REAL(0), REAL(0)));
    }
    const ssv_assembly_t alone = {&scenario->vehicle, NULL, {{REAL(0), REAL(0), REAL(0)}, quat_identity()}};
    limit(scenario, &alone, phase);
    return num_axes;
}

// Turn about C until the beam's outward axis faces the port, then fly its contact there. @return how many axes there
// are.
static int lay_transfer(const ssv_scenario_t* scenario, const ssv_assembly_t* pair, int contact, pose_t X_IS, int k,
                        ssv_phase_path_t* phase) {
    const vec3_t p_BE = ssv_grasp_contact(scenario, contact);
    const vec3_t outward_S = quat_apply(pair->X_SB.q, vec3_unit(p_BE));
    const vec3_t goal_S = quat_apply(quat_conj(X_IS.q), vec3_neg(scenario->axis_I));
    vec3_t axis[SSV_NUM_TURN_AXES];
    real_t angle;
    const int num_axes = ssv_grasp_turn_axes(outward_S, goal_S, axis, &angle);
    phase->num_maneuvers = 2;
    phase->maneuver[0] = ssv_maneuver_turn(SSV_TRANSFER, axis[k], angle, ssv_body_centre(pair));
    const pose_t turned = ssv_maneuver_pose(X_IS, phase->maneuver[0].twist, phase->maneuver[0].length);
    const vec3_t p_IE = pose_mul(turned, pose_mul(pair->X_SB, (pose_t){p_BE, quat_identity()})).p;
    const vec3_t d_I = vec3_sub(scenario->p_IP_m, p_IE);
    const vec3_t way_I = vec3_scale(-scenario->approach_dock_m, scenario->axis_I);
    const bool approaches = scenario->approach_dock_m > REAL(0);
    phase->maneuver[1] =
        ssv_maneuver_translate(SSV_TRANSFER, quat_apply(quat_conj(turned.q), approaches ? vec3_sub(d_I, way_I) : d_I));
    if (approaches) {
        phase->maneuver[phase->num_maneuvers++] =
            ssv_maneuver_translate(SSV_TRANSFER, quat_apply(quat_conj(turned.q), way_I));
    }
    limit(scenario, pair, phase);
    return num_axes;
}

static pose_t end_of(const ssv_phase_path_t* phase, pose_t X_IS) {
    for (int k = 0; k < phase->num_maneuvers; k++)
        X_IS = ssv_maneuver_pose(X_IS, phase->maneuver[k].twist, phase->maneuver[k].length);
    return X_IS;
}

// Whether a grasp cannot cost less than this: by its straight flights, or by an estimate with the optimal profile,
// which no ramp betters. As far as it does not hang on a choice of axis.
static bool costs_at_least(const ssv_question_t* question, const ssv_grasp_t* grasp, real_t price) {
    const ssv_scenario_t* scenario = &question->problem->scenario;
    const ssv_assembly_t alone = ssv_vehicle_alone(question->problem);
    ssv_phase_path_t flight;
    const int num_axes = lay_transit(scenario, grasp, 0, &flight);
    const real_t to_beam = straight_price(question, &alone, &flight.maneuver[0]);
    if (num_axes > 1 || to_beam >= price) return to_beam >= price;
    const pose_t X_IS = end_of(&flight, scenario->X_IS);
    const ssv_assembly_t pair = ssv_vehicle_with_beam(question->problem, grasp->height_m, X_IS.q);
    ssv_phase_path_t to_port;
    if (lay_transfer(scenario, &pair, grasp->contact, X_IS, 0, &to_port) > 1) return false;
    if (to_beam + straight_price(question, &pair, &to_port.maneuver[1]) >= price) return true;
    real_t estimate[2];
    return ssv_maneuvers_estimate(question, &alone, flight.maneuver, flight.num_maneuvers, SSV_ESTIMATE_CLOSELY,
                                  &estimate[0]) &&
           ssv_maneuvers_estimate(question, &pair, to_port.maneuver, to_port.num_maneuvers, SSV_ESTIMATE_CLOSELY,
                                  &estimate[1]) &&
           estimate[0] + estimate[1] >= real_mul(SSV_ESTIMATE_MARGIN, price);
}

void ssv_paper_search_begin(ssv_paper_search_t* search, const ssv_question_t* question, const ssv_price_t* to_beat) {
    search->question = question;
    search->to_beat = *to_beat;
    search->transit.num_maneuvers = 0;
    search->num_priced = 0;
}

// A path that comes too near something is none, whatever it costs.
static void refuse_contact(ssv_paper_search_t* search, const ssv_assembly_t* assembly, int contact, pose_t X_IS,
                           ssv_phase_path_t* phase) {
    const ssv_problem_t* problem = search->question->problem;
    if (!problem->around.counts || phase->price.outcome != SSV_FEASIBLE) return;
    const ssv_flight_t flight = {&problem->scenario, &problem->around,    assembly, X_IS, contact,
                                 phase->maneuver,    phase->num_maneuvers};
    if (ssv_keeps_clear(&flight, SSV_SHORTFALL_BRACKET_M, &search->clearance)) return;
    phase->maneuver_price[0].outcome = phase->price.outcome = SSV_NO_WAY;
}

// The cheapest transit to a grasp, into search->transit.
static void find_transit(ssv_paper_search_t* search, const ssv_grasp_t* grasp) {
    const ssv_question_t* question = search->question;
    const ssv_assembly_t alone = ssv_vehicle_alone(question->problem);
    int num_axes = 1;
    for (int k = 0; k < num_axes; k++) {
        ssv_phase_path_t transit;
        num_axes = lay_transit(&question->problem->scenario, grasp, k, &transit);
        ssv_phase_path_price(question, &alone, &search->transit, &transit);
        if (k == 0 || ssv_price_beats(&transit.price, &search->transit.price)) search->transit = transit;
        search->num_priced += k > 0 ? 1 : 0;
    }
}

// The cheapest transfer of a pair that has mated with the vehicle at X_IS.
static void find_transfer(ssv_paper_search_t* search, const ssv_assembly_t* pair, int contact, pose_t X_IS,
                          ssv_phase_path_t* best) {
    const ssv_question_t* question = search->question;
    int num_axes = 1;
    for (int k = 0; k < num_axes; k++) {
        ssv_phase_path_t transfer;
        num_axes = lay_transfer(&question->problem->scenario, pair, contact, X_IS, k, &transfer);
        ssv_phase_path_price(question, pair, NULL, &transfer);
        if (k == 0 || ssv_price_beats(&transfer.price, &best->price)) {
            refuse_contact(search, pair, contact, X_IS, &transfer);
            if (k == 0 || transfer.price.outcome == SSV_FEASIBLE) *best = transfer;
        }
        search->num_priced++;
    }
}

bool ssv_paper_search(ssv_paper_search_t* search, int contact, real_t height_m, ssv_path_t* path) {
    const ssv_question_t* question = search->question;
    const ssv_problem_t* problem = question->problem;
    real_t ring_angle_rad[SSV_NUM_RING_ANGLES];
    const int num_rings = ssv_grasp_ring_angles(&problem->scenario, ring_angle_rad);
    const bool may_skip = search->to_beat.outcome == SSV_FEASIBLE;
    bool found = false;
    for (int ring = 0; ring < num_rings; ring++) {
        const ssv_grasp_t grasp = {contact, height_m, ring_angle_rad[ring]};
        if (may_skip && costs_at_least(question, &grasp, search->to_beat.cost)) continue;
        find_transit(search, &grasp);
        const pose_t X_mate = end_of(&search->transit, problem->scenario.X_IS);
        const ssv_assembly_t pair = ssv_vehicle_with_beam(problem, height_m, X_mate.q);
        const ssv_assembly_t alone = ssv_vehicle_alone(problem);
        ssv_phase_path_t transit = search->transit, transfer;
        find_transfer(search, &pair, contact, X_mate, &transfer);
        if (transfer.price.outcome == SSV_FEASIBLE)
            refuse_contact(search, &alone, contact, problem->scenario.X_IS, &transit);
        const ssv_price_t price = ssv_path_price(&transit, &transfer);
        if (!found || ssv_price_beats(&price, &path->price)) {
            ssv_path_join(&grasp, &transit, &transfer, pair.X_SB, path);
        }
        found = true;
    }
    return found;
}
