#include "ssv/answer.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static vec3_t vec3_from_wire(const double v[3]) {
    return vec3(real_from_double(v[0]), real_from_double(v[1]), real_from_double(v[2]));
}

static pose_t pose_from_wire(const lcm_ssv_pose_t* wire) {
    const pose_t pose = {vec3_from_wire(wire->p_m),
                         {real_from_double(wire->q[0]), real_from_double(wire->q[1]), real_from_double(wire->q[2]),
                          real_from_double(wire->q[3])}};
    return pose;
}

static ssv_body_t body_from_wire(const lcm_ssv_body_t* wire) {
    const ssv_body_t body = {.mass_kg = real_from_double(wire->mass_kg),
                             .inertia_kg_m2 = vec3_from_wire(wire->inertia_kg_m2),
                             .added_mass_kg = vec3_from_wire(wire->added_mass_kg),
                             .drag_lin_kg_s = real_from_double(wire->drag_lin_kg_s),
                             .drag_quad_kg_m = real_from_double(wire->drag_quad_kg_m),
                             .drag_lin_ang_Nm_s = real_from_double(wire->drag_lin_ang_Nm_s),
                             .drag_quad_ang_Nm_s2 = real_from_double(wire->drag_quad_ang_Nm_s2)};
    return body;
}

void ssv_scenario_from_wire(ssv_scenario_t* scenario, const lcm_ssv_scenario_t* wire) {
    scenario->vehicle.body = body_from_wire(&wire->vehicle.body);
    scenario->vehicle.radius_m = real_from_double(wire->vehicle.radius_m);
    scenario->vehicle.force_max_N = real_from_double(wire->vehicle.force_max_N);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        scenario->vehicle.thruster[i].p_ST_m = vec3_from_wire(wire->vehicle.thruster[i].p_ST_m);
        scenario->vehicle.thruster[i].n_T_S = vec3_from_wire(wire->vehicle.thruster[i].n_T_S);
    }
    scenario->beam.body = body_from_wire(&wire->beam.body);
    scenario->beam.radius_m = real_from_double(wire->beam.radius_m);
    scenario->beam.length_m = real_from_double(wire->beam.length_m);
    scenario->beam.drag_strip_kg_m2 = real_from_double(wire->beam.drag_strip_kg_m2);
    scenario->X_IS = pose_from_wire(&wire->X_IS);
    scenario->X_IB = pose_from_wire(&wire->X_IB);
    scenario->p_IP_m = vec3_from_wire(wire->port.p_IP_m);
    scenario->axis_I = vec3_from_wire(wire->port.axis_I);
    scenario->contact = wire->contact;
    scenario->standoff_m = real_from_double(wire->standoff_m);
    scenario->weight_time_per_s = real_from_double(wire->weight_time_per_s);
    scenario->weight_impulse_per_Ns = real_from_double(wire->weight_impulse_per_Ns);
    scenario->method = (ssv_method_t)wire->options.method;
    scenario->effort = (ssv_effort_t)wire->options.effort;
    scenario->num_attach_heights = wire->options.num_attach_heights;
    for (int i = 0; i < SSV_MAX_ATTACH_HEIGHTS; i++) {
        scenario->attach_heights_m[i] = real_from_double(wire->options.attach_heights_m[i]);
    }
    scenario->want_candidates = true;
    scenario->ring_angle_given = wire->options.ring_angle_given != 0;
    scenario->ring_angle_rad = real_from_double(wire->options.ring_angle_rad);
}

static void vec3_to_wire(double wire[3], vec3_t v) {
    wire[0] = real_to_double(v.x);
    wire[1] = real_to_double(v.y);
    wire[2] = real_to_double(v.z);
}

static lcm_ssv_pose_t pose_to_wire(pose_t pose) {
    lcm_ssv_pose_t wire;
    vec3_to_wire(wire.p_m, pose.p);
    wire.q[0] = real_to_double(pose.q.w);
    wire.q[1] = real_to_double(pose.q.x);
    wire.q[2] = real_to_double(pose.q.y);
    wire.q[3] = real_to_double(pose.q.z);
    return wire;
}

static lcm_ssv_candidate_t candidate_to_wire(const ssv_candidate_t* candidate) {
    const char* reason = candidate->outcome == SSV_FEASIBLE ? "" : ssv_outcome_str(candidate->outcome);
    const lcm_ssv_candidate_t wire = {.contact = (int8_t)candidate->contact,
                                      .attach_height_m = real_to_double(candidate->attach_height_m),
                                      .ring_angle_rad = real_to_double(candidate->ring_angle_rad),
                                      .reason = (char*)reason, // encoders only read it
                                      .time_s = real_to_double(candidate->time_s),
                                      .impulse_Ns = real_to_double(candidate->impulse_Ns),
                                      .cost = real_to_double(candidate->cost)};
    return wire;
}

static lcm_ssv_leg_t leg_to_wire(const ssv_leg_t* leg) {
    const lcm_ssv_leg_t wire = {.phase = (int8_t)leg->phase,
                                .kind = (int8_t)leg->kind,
                                .ramp = (int8_t)leg->ramp,
                                .t_start_s = real_to_double(leg->t_start_s),
                                .duration_s = real_to_double(leg->duration_s),
                                .impulse_Ns = real_to_double(leg->impulse_Ns),
                                .peak_speed = real_to_double(leg->peak_speed),
                                .X_IS_start = pose_to_wire(leg->X_IS_start),
                                .X_IS_end = pose_to_wire(leg->X_IS_end)};
    return wire;
}

static lcm_ssv_segment_t segment_to_wire(const ssv_segment_t* segment) {
    lcm_ssv_segment_t wire = {.t_s = real_to_double(segment->t_s),
                              .duration_s = real_to_double(segment->duration_s),
                              .leg = (int8_t)segment->leg};
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        wire.u_start_N[i] = real_to_double(segment->u_start_N[i]);
        wire.u_end_N[i] = real_to_double(segment->u_end_N[i]);
    }
    return wire;
}

/// Appends to the reason; what does not fit is cut.
__attribute__((format(printf, 2, 3))) static void reason_add(ssv_answer_t* answer, const char* format, ...) {
    const size_t used = strlen(answer->reason);
    va_list args;
    va_start(args, format);
    vsnprintf(answer->reason + used, sizeof answer->reason - used, format, args);
    va_end(args);
}

/// "vehicle.thrusters[].n_T_S" and 2 give "vehicle.thrusters[2].n_T_S".
static void reason_add_field(ssv_answer_t* answer, const char* field, int index) {
    const char* bracket = strchr(field, ']');
    if (bracket == NULL || index < 0) {
        reason_add(answer, "%s", field);
        return;
    }
    reason_add(answer, "%.*s%d%s", (int)(bracket - field), field, index, bracket);
}

/// The fault in words: where, what, and what would be right.
static void reason_add_fault(ssv_answer_t* answer, const ssv_fault_t* fault) {
    const double value = real_to_double(fault->value);
    const double min = real_to_double(fault->min);
    const double max = real_to_double(fault->max);
    reason_add_field(answer, fault->field, fault->index);
    switch (fault->status) {
        case SSV_E_NOT_FINITE:
            // printf would show the sign of a NaN, which means nothing.
            reason_add(answer, ": %s is not a finite number", isnan(value) ? "nan" : value < 0 ? "-inf" : "inf");
            break;
        case SSV_E_RANGE:
            reason_add(answer, ": %.9g is outside its range [%.9g, %.9g]", value, min, max);
            break;
        case SSV_E_NOT_UNIT:
            reason_add(answer, ": length %.9g is not 1 within %.3g", value, real_to_double(SSV_UNIT_TOLERANCE));
            break;
        case SSV_E_SINGULAR:
            reason_add(answer, ": placed so that they cannot hold every force and moment");
            break;
        case SSV_E_WEIGHTS:
            reason_add(answer, ": both are zero, one must be positive");
            break;
        case SSV_OK:
        case SSV_INFEASIBLE:
            break;
    }
}

static void reason_add_candidates(ssv_answer_t* answer) {
    reason_add(answer, "no feasible candidate");
    for (int i = 0; i < answer->wire.num_candidates; i++) {
        const lcm_ssv_candidate_t* candidate = &answer->candidates[i];
        reason_add(answer, "; contact %d, height %.9g m: %s", candidate->contact, candidate->attach_height_m,
                   candidate->reason);
    }
}

/// An answer of this status with nothing in it yet.
static void answer_begin(const lcm_ssv_scenario_t* question, int8_t status, ssv_answer_t* answer) {
    memset(&answer->wire, 0, sizeof answer->wire);
    answer->reason[0] = '\0';
    answer->wire.request_id = question->request_id;
    answer->wire.epoch_us = question->epoch_us;
    answer->wire.status = status;
    answer->wire.reason = answer->reason;
    answer->wire.candidates = answer->candidates;
    answer->wire.legs = answer->legs;
    answer->wire.segments = answer->segments;
    answer->wire.events = answer->events;
}

void ssv_answer_refuse(const lcm_ssv_scenario_t* question, const char* reason, ssv_answer_t* answer) {
    answer_begin(question, LCM_SSV_PLAN_T_STATUS_INVALID, answer);
    reason_add(answer, "%s", reason);
}

ssv_status_t ssv_answer(const lcm_ssv_scenario_t* question, ssv_answer_t* answer) {
    answer_begin(question, LCM_SSV_PLAN_T_STATUS_INVALID, answer);
    if (question->epoch_us < 0) {
        reason_add(answer, "epoch_us: %lld is negative, it must be 0 or later", (long long)question->epoch_us);
        return SSV_E_RANGE;
    }
    ssv_scenario_t scenario;
    ssv_problem_t problem;
    ssv_fault_t fault;
    ssv_scenario_from_wire(&scenario, question);
    const ssv_status_t checked = ssv_problem_init(&problem, &scenario, &fault);
    if (checked != SSV_OK) {
        reason_add_fault(answer, &fault);
        return checked;
    }

    const ssv_plan_t* plan = &answer->plan;
    lcm_ssv_plan_t* wire = &answer->wire;
    const ssv_status_t planned = ssv_plan(&problem, &answer->plan);
    wire->scenario_hash = (int64_t)plan->quote.scenario_hash;
    wire->num_candidates = plan->quote.num_candidates;
    for (int i = 0; i < plan->quote.num_candidates; i++) {
        answer->candidates[i] = candidate_to_wire(&plan->quote.candidate[i]);
    }
    if (planned != SSV_OK) {
        wire->status = LCM_SSV_PLAN_T_STATUS_INFEASIBLE;
        reason_add_candidates(answer);
        return planned;
    }

    wire->status = LCM_SSV_PLAN_T_STATUS_OK;
    wire->plan_hash = (int64_t)plan->plan_hash;
    wire->cost = real_to_double(plan->quote.cost);
    wire->cost_lower_bound = real_to_double(plan->quote.lower_bound);
    wire->time_s = real_to_double(plan->quote.time_s);
    wire->impulse_Ns = real_to_double(plan->quote.impulse_Ns);
    wire->choice.contact = (int8_t)plan->quote.choice.contact;
    wire->choice.attach_height_m = real_to_double(plan->quote.choice.attach_height_m);
    wire->choice.ring_angle_rad = real_to_double(plan->quote.choice.ring_angle_rad);
    wire->choice.candidates = plan->quote.num_priced;
    wire->num_legs = plan->num_legs;
    for (int i = 0; i < plan->num_legs; i++) {
        answer->legs[i] = leg_to_wire(&plan->leg[i]);
    }
    wire->num_segments = plan->num_segments;
    for (int i = 0; i < plan->num_segments; i++) {
        answer->segments[i] = segment_to_wire(&plan->segment[i]);
    }
    wire->num_events = plan->num_events;
    for (int i = 0; i < plan->num_events; i++) {
        answer->events[i].t_s = real_to_double(plan->event[i].t_s);
        answer->events[i].kind = (int8_t)plan->event[i].kind;
    }
    wire->X_IS_final = pose_to_wire(plan->X_IS_final);
    wire->X_IB_final = pose_to_wire(plan->X_IB_final);
    return SSV_OK;
}
