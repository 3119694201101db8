// 64-bit FNV-1a over values in a fixed byte order, so that a hash says the same on every machine.
#include "ssv/planner.h"

#define FNV_START UINT64_C(0xcbf29ce484222325)
#define FNV_PRIME UINT64_C(0x100000001b3)

static uint64_t hash_u64(uint64_t hash, uint64_t value) {
    for (int byte = 0; byte < 8; byte++) {
        hash ^= (value >> (8 * byte)) & 0xffu;
        hash *= FNV_PRIME;
    }
    return hash;
}

static uint64_t hash_int(uint64_t hash, int value) { return hash_u64(hash, (uint64_t)(int64_t)value); }

static uint64_t hash_real(uint64_t hash, real_t value) { return hash_u64(hash, real_bits(value)); }

static uint64_t hash_vec3(uint64_t hash, vec3_t value) {
    return hash_real(hash_real(hash_real(hash, value.x), value.y), value.z);
}

static uint64_t hash_pose(uint64_t hash, pose_t value) {
    hash = hash_vec3(hash, value.p);
    return hash_vec3(hash_real(hash, value.q.w), vec3(value.q.x, value.q.y, value.q.z));
}

static uint64_t hash_body(uint64_t hash, const ssv_body_t* body) {
    hash = hash_real(hash, body->mass_kg);
    hash = hash_vec3(hash, body->inertia_kg_m2);
    hash = hash_vec3(hash, body->added_mass_kg);
    hash = hash_real(hash, body->drag_lin_kg_s);
    hash = hash_real(hash, body->drag_quad_kg_m);
    hash = hash_real(hash, body->drag_lin_ang_Nm_s);
    return hash_real(hash, body->drag_quad_ang_Nm_s2);
}

uint64_t ssv_scenario_hash(const ssv_scenario_t* scenario) {
    const ssv_vehicle_t* vehicle = &scenario->vehicle;
    uint64_t hash = hash_body(FNV_START, &vehicle->body);
    hash = hash_real(hash, vehicle->radius_m);
    hash = hash_real(hash, vehicle->force_max_N);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        hash = hash_vec3(hash, vehicle->thruster[i].p_ST_m);
        hash = hash_vec3(hash, vehicle->thruster[i].n_T_S);
    }
    hash = hash_body(hash, &scenario->beam.body);
    hash = hash_real(hash, scenario->beam.radius_m);
    hash = hash_real(hash, scenario->beam.length_m);
    hash = hash_real(hash, scenario->beam.drag_strip_kg_m2);
    hash = hash_pose(hash, scenario->X_IS);
    hash = hash_pose(hash, scenario->X_IB);
    hash = hash_vec3(hash, scenario->p_IP_m);
    hash = hash_vec3(hash, scenario->axis_I);
    hash = hash_int(hash, scenario->contact);
    hash = hash_real(hash, scenario->standoff_m);
    hash = hash_real(hash, scenario->weight_time_per_s);
    hash = hash_real(hash, scenario->weight_impulse_per_Ns);
    hash = hash_int(hash, (int)scenario->method);
    hash = hash_int(hash, (int)scenario->effort);
    hash = hash_int(hash, scenario->num_attach_heights);
    for (int k = 0; k < scenario->num_attach_heights && k < SSV_MAX_ATTACH_HEIGHTS; k++) {
        hash = hash_real(hash, scenario->attach_heights_m[k]);
    }
    hash = hash_int(hash, scenario->attach_anywhere ? 1 : 0);
    hash = hash_int(hash, scenario->want_candidates ? 1 : 0);
    hash = hash_int(hash, scenario->ring_angle_given ? 1 : 0);
    return hash_real(hash, scenario->ring_angle_given ? scenario->ring_angle_rad : REAL(0));
}

static uint64_t hash_candidate(uint64_t hash, const ssv_candidate_t* candidate) {
    hash = hash_int(hash, candidate->contact);
    hash = hash_real(hash, candidate->attach_height_m);
    hash = hash_real(hash, candidate->ring_angle_rad);
    hash = hash_int(hash, (int)candidate->outcome);
    hash = hash_real(hash, candidate->time_s);
    hash = hash_real(hash, candidate->impulse_Ns);
    return hash_real(hash, candidate->cost);
}

static uint64_t hash_leg(uint64_t hash, const ssv_leg_t* leg) {
    hash = hash_int(hash, (int)leg->phase);
    hash = hash_int(hash, (int)leg->kind);
    hash = hash_int(hash, (int)leg->ramp);
    hash = hash_real(hash, leg->t_start_s);
    hash = hash_real(hash, leg->duration_s);
    hash = hash_real(hash, leg->impulse_Ns);
    hash = hash_real(hash, leg->length);
    hash = hash_real(hash, leg->peak_speed);
    hash = hash_vec3(hash, leg->v_S);
    hash = hash_vec3(hash, leg->w_S);
    hash = hash_pose(hash, leg->X_IS_start);
    hash = hash_pose(hash, leg->X_IS_end);
    hash = hash_int(hash, leg->first_arc);
    return hash_int(hash, leg->num_arcs);
}

static uint64_t hash_arc(uint64_t hash, const ssv_arc_t* arc) {
    hash = hash_real(hash, arc->t_s);
    hash = hash_real(hash, arc->duration_s);
    hash = hash_real(hash, arc->s);
    hash = hash_real(hash, arc->v_start);
    hash = hash_real(hash, arc->v_end);
    return hash_vec3(hash, vec3(arc->dv_dt[0], arc->dv_dt[1], arc->dv_dt[2]));
}

static uint64_t hash_segment(uint64_t hash, const ssv_segment_t* segment) {
    hash = hash_real(hash, segment->t_s);
    hash = hash_real(hash, segment->duration_s);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) hash = hash_real(hash, segment->u_start_N[i]);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) hash = hash_real(hash, segment->u_end_N[i]);
    return hash_int(hash, segment->leg);
}

uint64_t ssv_plan_hash(const ssv_plan_t* plan) {
    uint64_t hash = hash_int(FNV_START, (int)plan->quote.status);
    hash = hash_u64(hash, plan->quote.scenario_hash);
    hash = hash_real(hash, plan->quote.cost);
    hash = hash_real(hash, plan->quote.lower_bound);
    hash = hash_real(hash, plan->quote.time_s);
    hash = hash_real(hash, plan->quote.impulse_Ns);
    hash = hash_candidate(hash, &plan->quote.choice);
    hash = hash_int(hash, plan->quote.num_priced);
    hash = hash_int(hash, plan->quote.num_candidates);
    for (int k = 0; k < plan->quote.num_candidates; k++) hash = hash_candidate(hash, &plan->quote.candidate[k]);
    hash = hash_int(hash, plan->num_legs);
    for (int k = 0; k < plan->num_legs; k++) hash = hash_leg(hash, &plan->leg[k]);
    hash = hash_int(hash, plan->num_arcs);
    for (int k = 0; k < plan->num_arcs; k++) hash = hash_arc(hash, &plan->arc[k]);
    hash = hash_int(hash, plan->num_segments);
    for (int k = 0; k < plan->num_segments; k++) hash = hash_segment(hash, &plan->segment[k]);
    hash = hash_int(hash, plan->num_events);
    for (int k = 0; k < plan->num_events; k++) {
        hash = hash_int(hash_real(hash, plan->event[k].t_s), (int)plan->event[k].kind);
    }
    hash = hash_pose(hash, plan->X_SB);
    hash = hash_pose(hash, plan->X_IS_final);
    return hash_pose(hash, plan->X_IB_final);
}
