#include "planner/motion/path.h"

#include "planner/math/assert.h"
#include "planner/profile/estimate.h"
#include "planner/profile/limits.h"

static void add_price(ssv_price_t* sum, const ssv_price_t* price) {
    if (sum->outcome == SSV_FEASIBLE) sum->outcome = price->outcome;
    sum->time_s += price->time_s;
    sum->impulse_Ns += price->impulse_Ns;
    sum->cost += price->cost;
}

ssv_assembly_t ssv_vehicle_alone(const ssv_problem_t* problem) {
    return (ssv_assembly_t){&problem->scenario.vehicle, NULL, {{REAL(0), REAL(0), REAL(0)}, quat_identity()}};
}

ssv_assembly_t ssv_vehicle_with_beam(const ssv_problem_t* problem, real_t height_m, quat_t q_IS) {
    const ssv_scenario_t* scenario = &problem->scenario;
    const quat_t q_SB = quat_unit(quat_mul(quat_conj(q_IS), scenario->X_IB.q));
    const vec3_t ahead = vec3(scenario->standoff_m, REAL(0), REAL(0));
    const vec3_t p_SB_m = vec3_sub(ahead, quat_apply(q_SB, vec3(REAL(0), REAL(0), height_m)));
    return (ssv_assembly_t){&scenario->vehicle, &scenario->beam, {p_SB_m, q_SB}};
}

static bool same(vec3_t a, vec3_t b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

static bool same_maneuver(const ssv_maneuver_t* a, const ssv_maneuver_t* b) {
    return a->kind == b->kind && a->length == b->length && a->speed_max == b->speed_max &&
           same(a->twist.v, b->twist.v) && same(a->twist.w, b->twist.w);
}

void ssv_phase_path_price(const ssv_question_t* question, const ssv_assembly_t* assembly, const ssv_phase_path_t* known,
                          ssv_phase_path_t* phase) {
    SSV_ASSERT(0 <= phase->num_maneuvers && phase->num_maneuvers <= SSV_MAX_PHASE_MANEUVERS);
    phase->price = (ssv_price_t){SSV_FEASIBLE, REAL(0), REAL(0), REAL(0)};
    for (int k = 0; k < phase->num_maneuvers; k++) {
        const ssv_maneuver_t* maneuver = &phase->maneuver[k];
        if (known != NULL && k < known->num_maneuvers && same_maneuver(maneuver, &known->maneuver[k])) {
            phase->maneuver_price[k] = known->maneuver_price[k];
        } else {
            ssv_thrusts_t thrusts;
            ssv_ramp_t ramp;
            ssv_maneuver_thrusts(question->problem, assembly, maneuver->twist, &thrusts);
            phase->maneuver_price[k] = ssv_maneuver_price(question, maneuver, &thrusts, &ramp);
        }
        add_price(&phase->price, &phase->maneuver_price[k]);
    }
}

bool ssv_maneuvers_estimate(const ssv_question_t* question, const ssv_assembly_t* assembly,
                            const ssv_maneuver_t maneuver[], int num_maneuvers, real_t closeness, real_t* price) {
    const real_t weight_time = ssv_leg_weight_time(question);
    *price = REAL(0);
    for (int k = 0; k < num_maneuvers; k++) {
        if (!(maneuver[k].length > REAL(0))) continue;
        ssv_thrusts_t thrusts;
        real_t cost, peak_speed;
        ssv_maneuver_thrusts(question->problem, assembly, maneuver[k].twist, &thrusts);
        if (!ssv_profile_estimate(&thrusts, weight_time, question->weight_impulse_per_Ns, maneuver[k].length,
                                  maneuver[k].speed_max, closeness, &cost, &peak_speed)) {
            return false;
        }
        *price += cost;
    }
    return true;
}

ssv_price_t ssv_path_price(const ssv_phase_path_t* transit, const ssv_phase_path_t* transfer) {
    const ssv_phase_path_t* phases[2] = {transit, transfer};
    ssv_price_t price = {SSV_FEASIBLE, REAL(0), REAL(0), REAL(0)};
    for (int phase = 0; phase < 2; phase++) {
        for (int k = 0; k < phases[phase]->num_maneuvers; k++) add_price(&price, &phases[phase]->maneuver_price[k]);
    }
    if (price.outcome == SSV_FEASIBLE && price.time_s > SSV_DURATION_MAX_S) price.outcome = SSV_TOO_LONG;
    return price;
}

ssv_candidate_t ssv_candidate_of(const ssv_grasp_t* grasp, const ssv_price_t* price, const ssv_clearance_t* clearance) {
    ssv_candidate_t candidate = {.contact = grasp->contact,
                                 .attach_height_m = grasp->height_m,
                                 .ring_angle_rad = grasp->ring_angle_rad,
                                 .outcome = price->outcome};
    if (price->outcome == SSV_NO_WAY) {
        candidate.body = clearance->body;
        candidate.obstacle = clearance->obstacle;
        candidate.clearance_m = clearance->seen_m;
    }
    if (price->outcome == SSV_FEASIBLE) {
        candidate.time_s = price->time_s;
        candidate.impulse_Ns = price->impulse_Ns;
        candidate.cost = price->cost;
    }
    return candidate;
}

void ssv_path_join(const ssv_grasp_t* grasp, const ssv_phase_path_t* transit, const ssv_phase_path_t* transfer,
                   pose_t X_SB, ssv_path_t* path) {
    const ssv_phase_path_t* phases[2] = {transit, transfer};
    path->grasp = *grasp;
    path->X_SB = X_SB;
    path->num_maneuvers = 0;
    path->price = ssv_path_price(transit, transfer);
    for (int phase = 0; phase < 2; phase++) {
        for (int k = 0; k < phases[phase]->num_maneuvers; k++)
            path->maneuver[path->num_maneuvers++] = phases[phase]->maneuver[k];
    }
}
