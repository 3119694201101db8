// Checks a scenario against the field table, and caches what follows from it.
#include "planner/model/allocation.h"
#include "planner/model/fields.def"
#include "planner/model/shape.h"

const char ssv_scalar[] = REAL_NAME;

// Every check stops at the first fault; the caller's fault is written there.
typedef struct {
    ssv_fault_t* fault;
    int index; // of what is being checked, -1 where there is only one
    bool ok;
} checker_t;

static void fail(checker_t* checker, ssv_status_t status, const char* field, real_t value, real_t min, real_t max) {
    *checker->fault = (ssv_fault_t){
        .status = status, .field = field, .index = checker->index, .value = value, .min = min, .max = max};
    checker->ok = false;
}

static void check(checker_t* checker, const char* field, real_t value, real_t min, real_t max) {
    if (!checker->ok) return;
    if (!real_is_finite(value)) {
        fail(checker, SSV_E_NOT_FINITE, field, value, min, max);
    } else if (value < min || value > max) {
        fail(checker, SSV_E_RANGE, field, value, min, max);
    }
}

static void check_vec3(checker_t* checker, const char* field, vec3_t v, real_t min, real_t max) {
    check(checker, field, v.x, min, max);
    check(checker, field, v.y, min, max);
    check(checker, field, v.z, min, max);
}

static void check_length(checker_t* checker, const char* field, real_t length, real_t tolerance) {
    if (!checker->ok) return;
    const real_t min = REAL(1) - tolerance, max = REAL(1) + tolerance;
    if (length < min || length > max) fail(checker, SSV_E_NOT_UNIT, field, length, min, max);
}

// A component beyond 2 is not of a unit vector, and its square might overflow.
static vec3_t check_unit(checker_t* checker, const char* field, vec3_t v, real_t min, real_t max) {
    check_vec3(checker, field, v, min, max);
    if (!checker->ok) return v;
    check_length(checker, field, vec3_norm(v), SSV_UNIT_TOLERANCE);
    return checker->ok ? vec3_unit(v) : v;
}

static quat_t check_quat(checker_t* checker, const char* field, quat_t q, real_t min, real_t max) {
    check(checker, field, q.w, min, max);
    check_vec3(checker, field, vec3(q.x, q.y, q.z), min, max);
    if (!checker->ok) return q;
    check_length(checker, field, quat_norm(q), SSV_UNIT_TOLERANCE);
    return checker->ok ? quat_unit(q) : q;
}

// What is checked of a field, by its kind.
#define CHECK_REAL(field, value, min, max) check(checker, field, value, min, max);
#define CHECK_VEC3(field, value, min, max) check_vec3(checker, field, value, min, max);
#define CHECK_UNIT(field, value, min, max) value = check_unit(checker, field, value, min, max);
#define CHECK_QUAT(field, value, min, max) value = check_quat(checker, field, value, min, max);
#define CHECK_INT(field, value, min, max) check(checker, field, real_from_int((int)(value)), min, max);
#define CHECK_BOOL(field, value, min, max)
#define CHECK_ENUM(type) CHECK_INT
#define CHECK_HEIGHT(k)                                                                                                \
    if ((k) < s->num_attach_heights) CHECK_REAL
#define CHECK_RING(field, value, min, max)                                                                             \
    if (s->ring_angle_given) CHECK_REAL(field, value, min, max)
#define CHECK_ADDED(field, value, min, max) CHECK_REAL(field, value, min, max)
#define CHECK_FIELD(kind, core, wire, min, max, unit, text) CHECK_##kind(#wire, s->core, min, max)

// What a scene holds is nobody's but the caller's, and stays as it is.
static void check_axis(checker_t* checker, const char* field, vec3_t v, real_t min, real_t max) {
    check_vec3(checker, field, v, min, max);
    if (checker->ok) check_length(checker, field, vec3_norm(v), SSV_AXIS_TOLERANCE);
}

#define CHECK_KEPT_REAL(field, value, min, max) check(checker, field, value, min, max);
#define CHECK_KEPT_VEC3(field, value, min, max) check_vec3(checker, field, value, min, max);
#define CHECK_KEPT_ENUM(type) CHECK_INT
#define CHECK_KEPT_UNIT(field, value, min, max) check_axis(checker, field, value, min, max);
#define CHECK_KEPT_FIELD(kind, core, wire, min, max, unit, text) CHECK_KEPT_##kind(#wire, core, min, max)

// Of a body that stands by itself, its paths in order.
#define CHECK_BODY_FIELD(kind, core, wire, min, max, unit, text) CHECK_##kind(*path++, core, min, max)
#define PATH(kind, core, wire, min, max, unit, text) #wire,

// No principal moment is larger than the other two together. Given ones are rounded.
#define MOMENTS_TOLERANCE REAL(1e-3)

static void check_moments(checker_t* checker, const char* path, vec3_t moments_kg_m2) {
    const vec3_t m = moments_kg_m2;
    const real_t largest = real_max(m.x, real_max(m.y, m.z));
    if (!checker->ok) return;
    const real_t others = m.x + m.y + m.z - largest;
    if (largest > others + real_mul(MOMENTS_TOLERANCE, others) + 2 * REAL_STEP)
        fail(checker, SSV_E_IMPOSSIBLE, path, largest, REAL(0), others);
}

// Where the moments stand in SSV_BODY_FIELDS.
#define MOMENTS 1

static void check_body(checker_t* checker, const char* const* all, const ssv_body_t* body) {
    const char* const* path = all;
    SSV_BODY_FIELDS(CHECK_BODY_FIELD, (*body))
    check_moments(checker, all[MOMENTS], body->inertia_kg_m2);
}

// Turning the vehicle by itself takes thrusts as small as its moments: in a scalar without an exponent these must have
// digits. Those of the beam are only added to them.
#define VEHICLE_INERTIA_MIN_KG_M2 ((1 << 16) * REAL_STEP)

static void check_digits(checker_t* checker, const char* path, vec3_t moments_kg_m2) {
    const vec3_t m = moments_kg_m2;
    const real_t least = real_min(m.x, real_min(m.y, m.z));
    if (!checker->ok || !(least < VEHICLE_INERTIA_MIN_KG_M2)) return;
    fail(checker, SSV_E_TOO_FINE, path, least, VEHICLE_INERTIA_MIN_KG_M2, REAL_MAX);
}

static void check_vehicle(checker_t* checker, ssv_scenario_t* s) {
    static const char* const path[] = {SSV_BODY_FIELDS(PATH, vehicle.body)};
    check_body(checker, path, &s->vehicle.body);
    check_digits(checker, path[MOMENTS], s->vehicle.body.inertia_kg_m2);
    SSV_VEHICLE_FIELDS(CHECK_FIELD)
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        checker->index = i;
        SSV_THRUSTER_FIELDS(CHECK_FIELD, i)
    }
    checker->index = -1;
}

static void check_beam(checker_t* checker, ssv_scenario_t* s) {
    static const char* const path[] = {SSV_BODY_FIELDS(PATH, beam.body)};
    check_body(checker, path, &s->beam.body);
    SSV_BEAM_FIELDS(CHECK_FIELD)
}

// The beam's axis may be on the hull, as in the paper's tables, where the beam is a line; else the tube must be
// outside.
#define TOUCH REAL(0.99999)

static void check_standoff(checker_t* checker, const ssv_scenario_t* s) {
    const real_t radii = s->vehicle.radius_m + s->beam.radius_m;
    if (!checker->ok || s->standoff_m == s->vehicle.radius_m || s->standoff_m >= real_mul(TOUCH, radii)) return;
    fail(checker, SSV_E_IMPOSSIBLE, "standoff_m", s->standoff_m, radii, REAL(20));
}

static void check_task(checker_t* checker, ssv_scenario_t* s) {
    SSV_TASK_FIELDS(CHECK_FIELD)
    check_standoff(checker, s);
    if (checker->ok && !(s->weight_time_per_s > REAL(0)) && !(s->weight_impulse_per_Ns > REAL(0))) {
        fail(checker, SSV_E_WEIGHTS, "weight_time_per_s", REAL(0), REAL(0), REAL(1000));
    }
    if (checker->ok && s->thrust_reserve >= REAL(0.9)) {
        fail(checker, SSV_E_RANGE, "thrust_reserve", s->thrust_reserve, REAL(0), REAL(0.9));
    }
}

static void check_options(checker_t* checker, ssv_scenario_t* s) {
    const real_t half = real_mul(REAL(0.5), s->beam.length_m);
    SSV_METHOD_FIELDS(CHECK_FIELD)
    if (!checker->ok) return;
    for (int k = 0; k < SSV_MAX_ATTACH_HEIGHTS; k++) {
        checker->index = k;
        SSV_HEIGHT_FIELDS(CHECK_FIELD, k)
    }
    checker->index = -1;
    SSV_OPTION_FIELDS(CHECK_FIELD)
    if (checker->ok && s->num_attach_heights == 0) {
        s->num_attach_heights = 3;
        s->attach_heights_m[0] = half;
        s->attach_heights_m[1] = REAL(0);
        s->attach_heights_m[2] = -half;
    }
}

static void check_obstacle(checker_t* checker, const ssv_obstacle_t* o) {
    const ssv_obstacle_t obstacle = *o;
    SSV_OBSTACLE_FIELDS(CHECK_KEPT_FIELD)
    if (!checker->ok) return;
    if (obstacle.kind == SSV_CAPSULE) {
        SSV_CAPSULE_FIELDS(CHECK_KEPT_FIELD)
    }
    if (obstacle.kind == SSV_WALL || obstacle.length_m > REAL(0)) {
        SSV_AXIS_FIELDS(CHECK_KEPT_FIELD)
    }
}

static void check_tank(checker_t* checker, const ssv_scene_t* scene) {
    const ssv_tank_t tank = scene->tank;
    check(checker, "scene.tank.kind", real_from_int((int)tank.kind), REAL(0), real_from_int((int)SSV_CYLINDER));
    if (!checker->ok || tank.kind == SSV_NO_TANK) return;
    SSV_TANK_FIELDS(CHECK_KEPT_FIELD)
    const vec3_t from = tank.from_I_m, to = tank.to_I_m;
    if (tank.kind == SSV_CYLINDER) {
        SSV_CYLINDER_FIELDS(CHECK_KEPT_FIELD)
    } else {
        check(checker, "scene.tank.to_I_m", to.x, from.x, REAL(1000));
        check(checker, "scene.tank.to_I_m", to.y, from.y, REAL(1000));
    }
    check(checker, "scene.tank.to_I_m", to.z, from.z, REAL(1000));
}

// Only then may its obstacles be looked at.
static void check_scene(checker_t* checker, const ssv_scene_t* scene, uint64_t obstacles) {
    const int num = scene == NULL ? 0 : scene->num_obstacles;
    check(checker, "scene.num_obstacles", real_from_int(num), REAL(0), real_from_int(SSV_MAX_OBSTACLES));
    for (int k = 0; checker->ok && k < num; k++) {
        checker->index = k;
        check_obstacle(checker, &scene->obstacle[k]);
    }
    if (checker->ok) checker->index = -1;
    if (scene != NULL) check_tank(checker, scene);
    for (int k = num; checker->ok && k < SSV_MAX_OBSTACLES; k++) {
        if ((obstacles >> k & 1) == 0) continue;
        fail(checker, SSV_E_RANGE, "obstacles", real_from_int(k), REAL(0), real_from_int(num - 1));
    }
}

ssv_status_t ssv_scene_check(const ssv_scene_t* scene, uint64_t obstacles, ssv_fault_t* fault) {
    checker_t checker = {fault, -1, true};
    check_scene(&checker, scene, obstacles);
    return checker.ok ? SSV_OK : fault->status;
}

static void check_later(checker_t* checker, ssv_scenario_t* s) {
    SSV_LATER_FIELDS(CHECK_FIELD)
    check_scene(checker, s->scene, s->obstacles);
}

ssv_status_t ssv_problem_init(ssv_problem_t* problem, const ssv_scenario_t* scenario, ssv_fault_t* fault) {
    ssv_scenario_t s = *scenario;
    ssv_allocation_t allocation;
    checker_t checker = {fault, -1, true};
    check_vehicle(&checker, &s);
    check_beam(&checker, &s);
    check_task(&checker, &s);
    check_options(&checker, &s);
    check_later(&checker, &s);
    // An inverse that overflows is too large in any case.
    ssv_lack_t lack;
    if (checker.ok && ssv_alloc_init(&s.vehicle, &allocation, &lack) != SSV_OK) {
        fail(&checker, SSV_E_SINGULAR, "vehicle.thruster", REAL(0), REAL(0), REAL(0));
        fault->lack = lack;
    }
    if (!checker.ok) return fault->status;
    // From here on the thrusters are those that the plan may use.
    s.vehicle.force_max_N = real_mul(s.vehicle.force_max_N, REAL(1) - s.thrust_reserve);
    problem->scenario = s;
    problem->scenario_hash = ssv_scenario_hash(scenario);
    problem->allocation = allocation;
    ssv_surroundings_of(&problem->scenario, s.scene, s.obstacles, &problem->around);
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
        case SSV_E_IMPOSSIBLE: return "nothing can be so";
        case SSV_E_TOO_FINE: return "too small for the planner's arithmetic";
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
        case SSV_NO_WAY: return "no way was found that keeps clear of what stands there";
        case SSV_START_BLOCKED: return "what stands there is too near where it starts";
        case SSV_MATE_BLOCKED: return "what stands there leaves no room to mate";
        case SSV_GOAL_BLOCKED: return "what stands there leaves no room to dock";
    }
    return "unknown outcome";
}
