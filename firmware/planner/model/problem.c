#include "planner/model/allocation.h"

const char ssv_scalar[] = REAL_NAME;

#define NUM_BODY_FIELDS 7

// Every check stops at the first fault; the caller's fault is written there.
typedef struct {
    ssv_fault_t* fault;
    bool ok;
} checker_t;

static void fail(checker_t* checker, ssv_status_t status, const char* field, int index, real_t value, real_t min,
                 real_t max) {
    *checker->fault = (ssv_fault_t){status, field, index, value, min, max};
    checker->ok = false;
}

static void check_at(checker_t* checker, const char* field, int index, real_t value, real_t min, real_t max) {
    if (!checker->ok) return;
    if (!real_is_finite(value)) {
        fail(checker, SSV_E_NOT_FINITE, field, index, value, min, max);
    } else if (value < min || value > max) {
        fail(checker, SSV_E_RANGE, field, index, value, min, max);
    }
}

static void check(checker_t* checker, const char* field, real_t value, real_t min, real_t max) {
    check_at(checker, field, -1, value, min, max);
}

static void check_vec3(checker_t* checker, const char* field, int index, vec3_t v, real_t min, real_t max) {
    check_at(checker, field, index, v.x, min, max);
    check_at(checker, field, index, v.y, min, max);
    check_at(checker, field, index, v.z, min, max);
}

static void check_length(checker_t* checker, const char* field, int index, real_t length) {
    if (!checker->ok) return;
    const real_t min = REAL(1) - SSV_UNIT_TOLERANCE, max = REAL(1) + SSV_UNIT_TOLERANCE;
    if (length < min || length > max) fail(checker, SSV_E_NOT_UNIT, field, index, length, min, max);
}

// A component beyond 2 is not of a unit vector, and its square might overflow.
static vec3_t check_direction(checker_t* checker, const char* field, int index, vec3_t v) {
    check_vec3(checker, field, index, v, REAL(-2), REAL(2));
    if (!checker->ok) return v;
    check_length(checker, field, index, vec3_norm(v));
    return checker->ok ? vec3_unit(v) : v;
}

static quat_t check_quat(checker_t* checker, const char* field, quat_t q) {
    check(checker, field, q.w, REAL(-2), REAL(2));
    check_vec3(checker, field, -1, vec3(q.x, q.y, q.z), REAL(-2), REAL(2));
    if (!checker->ok) return q;
    check_length(checker, field, -1, quat_norm(q));
    return checker->ok ? quat_unit(q) : q;
}

static void check_body(checker_t* checker, const char* const field[NUM_BODY_FIELDS], const ssv_body_t* body) {
    check(checker, field[0], body->mass_kg, REAL(0.01), REAL(10000));
    check_vec3(checker, field[1], -1, body->inertia_kg_m2, REAL(1e-4), REAL(100000));
    check_vec3(checker, field[2], -1, body->added_mass_kg, REAL(0), REAL(10000));
    check(checker, field[3], body->drag_lin_kg_s, REAL(0), REAL(100000));
    check(checker, field[4], body->drag_quad_kg_m, REAL(0), REAL(100000));
    check(checker, field[5], body->drag_lin_ang_Nm_s, REAL(0), REAL(100000));
    check(checker, field[6], body->drag_quad_ang_Nm_s2, REAL(0), REAL(100000));
}

static void check_vehicle(checker_t* checker, ssv_vehicle_t* vehicle) {
    static const char* const field[NUM_BODY_FIELDS] = {
        "vehicle.mass_kg",        "vehicle.inertia_kg_m2",     "vehicle.added_mass_kg",      "vehicle.drag_lin_kg_s",
        "vehicle.drag_quad_kg_m", "vehicle.drag_lin_ang_Nm_s", "vehicle.drag_quad_ang_Nm_s2"};
    check_body(checker, field, &vehicle->body);
    check(checker, "vehicle.radius_m", vehicle->radius_m, REAL(0.001), REAL(10));
    check(checker, "vehicle.force_max_N", vehicle->force_max_N, REAL(0.001), REAL(10000));
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        ssv_thruster_t* thruster = &vehicle->thruster[i];
        check_vec3(checker, "vehicle.thrusters[].p_ST_m", i, thruster->p_ST_m, REAL(-10), REAL(10));
        thruster->n_T_S = check_direction(checker, "vehicle.thrusters[].n_T_S", i, thruster->n_T_S);
    }
}

static void check_beam(checker_t* checker, const ssv_beam_t* beam) {
    static const char* const field[NUM_BODY_FIELDS] = {
        "beam.mass_kg",        "beam.inertia_kg_m2",     "beam.added_mass_kg",      "beam.drag_lin_kg_s",
        "beam.drag_quad_kg_m", "beam.drag_lin_ang_Nm_s", "beam.drag_quad_ang_Nm_s2"};
    check_body(checker, field, &beam->body);
    check(checker, "beam.radius_m", beam->radius_m, REAL(0.001), REAL(10));
    check(checker, "beam.length_m", beam->length_m, REAL(0.01), REAL(100));
    check(checker, "beam.drag_strip_kg_m2", beam->drag_strip_kg_m2, REAL(0), REAL(100000));
}

static void check_task(checker_t* checker, ssv_scenario_t* s) {
    check_vec3(checker, "vehicle.p_IS_m", -1, s->X_IS.p, REAL(-1000), REAL(1000));
    s->X_IS.q = check_quat(checker, "vehicle.q_IS", s->X_IS.q);
    check_vec3(checker, "beam.p_IB_m", -1, s->X_IB.p, REAL(-1000), REAL(1000));
    s->X_IB.q = check_quat(checker, "beam.q_IB", s->X_IB.q);
    check_vec3(checker, "port.p_IP_m", -1, s->p_IP_m, REAL(-1000), REAL(1000));
    s->axis_I = check_direction(checker, "port.axis_I", -1, s->axis_I);
    check(checker, "beam.contact", real_from_int(s->contact), REAL(0), real_from_int(SSV_NUM_CONTACTS));
    check(checker, "standoff_m", s->standoff_m, REAL(0.001), REAL(20));
    check(checker, "weights.time", s->weight_time_per_s, REAL(0), REAL(1000));
    check(checker, "weights.impulse", s->weight_impulse_per_Ns, REAL(0), REAL(1000));
    if (checker->ok && !(s->weight_time_per_s > REAL(0)) && !(s->weight_impulse_per_Ns > REAL(0))) {
        fail(checker, SSV_E_WEIGHTS, "weights", -1, REAL(0), REAL(0), REAL(1000));
    }
    check(checker, "method", real_from_int((int)s->method), REAL(0), real_from_int((int)SSV_METHOD_PAPER));
    check(checker, "effort", real_from_int((int)s->effort), REAL(0), real_from_int((int)SSV_EFFORT_BEST));
}

static void check_grasp(checker_t* checker, ssv_scenario_t* s) {
    const real_t half = real_mul(REAL(0.5), s->beam.length_m);
    check(checker, "attach_heights_m", real_from_int(s->num_attach_heights), REAL(0),
          real_from_int(SSV_MAX_ATTACH_HEIGHTS));
    if (!checker->ok) return;
    for (int k = 0; k < s->num_attach_heights; k++) {
        check_at(checker, "attach_heights_m[]", k, s->attach_heights_m[k], -half, half);
    }
    if (s->num_attach_heights == 0) {
        s->num_attach_heights = 3;
        s->attach_heights_m[0] = half;
        s->attach_heights_m[1] = REAL(0);
        s->attach_heights_m[2] = -half;
    }
    const real_t turn = real_mul(REAL(2), REAL_PI);
    if (s->ring_angle_given) check(checker, "ring_angle_rad", s->ring_angle_rad, -turn, turn);
}

ssv_status_t ssv_problem_init(ssv_problem_t* problem, const ssv_scenario_t* scenario, ssv_fault_t* fault) {
    ssv_scenario_t s = *scenario;
    ssv_allocation_t allocation;
    checker_t checker = {fault, true};
    check_vehicle(&checker, &s.vehicle);
    check_beam(&checker, &s.beam);
    check_task(&checker, &s);
    check_grasp(&checker, &s);
    // An inverse that overflows is too large in any case.
    if (checker.ok && ssv_alloc_init(&s.vehicle, &allocation) != SSV_OK) {
        fail(&checker, SSV_E_SINGULAR, "vehicle.thrusters", -1, REAL(0), REAL(0), REAL(0));
    }
    if (!checker.ok) return fault->status;
    problem->scenario = s;
    problem->scenario_hash = ssv_scenario_hash(scenario);
    problem->allocation = allocation;
    return SSV_OK;
}

ssv_scenario_t ssv_scenario_default(void) {
    ssv_scenario_t s;
    memset(&s, 0, sizeof s);
    s.X_IS.q = s.X_IB.q = quat_identity();
    s.weight_time_per_s = s.weight_impulse_per_Ns = REAL(1);
    return s;
}

const char* ssv_status_str(ssv_status_t status) {
    switch (status) {
        case SSV_OK: return "ok";
        case SSV_INFEASIBLE: return "no feasible candidate";
        case SSV_NUMERIC_OVERFLOW: return "a number does not fit the planner's arithmetic";
        case SSV_E_NOT_FINITE: return "not a finite number";
        case SSV_E_RANGE: return "outside its range";
        case SSV_E_NOT_UNIT: return "not of unit length";
        case SSV_E_SINGULAR: return "the thrusters cannot hold every force and moment";
        case SSV_E_WEIGHTS: return "both weights are zero";
    }
    return "unknown status";
}

const char* ssv_outcome_str(ssv_outcome_t outcome) {
    switch (outcome) {
        case SSV_FEASIBLE: return "feasible";
        case SSV_TOO_LONG: return "takes longer than the longest plan";
        case SSV_NO_AUTHORITY: return "the thrusters cannot move the body along a leg";
        case SSV_TOO_MANY_ARCS: return "the motion has more arcs than a plan holds";
        case SSV_TOO_MANY_SEGMENTS: return "the timeline has more segments than a plan holds";
    }
    return "unknown outcome";
}
