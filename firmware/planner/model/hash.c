// 64-bit FNV-1a over values in a fixed byte order, so that a hash says the same on every machine.
#include "planner/model/fields.def"
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

static uint64_t hash_vec3(uint64_t hash, const vec3_t* value) {
    return hash_real(hash_real(hash_real(hash, value->x), value->y), value->z);
}

static uint64_t hash_quat(uint64_t hash, const quat_t* value) {
    return hash_real(hash_real(hash_real(hash_real(hash, value->w), value->x), value->y), value->z);
}

static uint64_t hash_pose(uint64_t hash, const pose_t* value) {
    return hash_quat(hash_vec3(hash, &value->p), &value->q);
}

// What a field counts for, by its kind.
#define HASH_REAL(value) hash_real(hash, value)
#define HASH_VEC3(value) hash_vec3(hash, &(value))
#define HASH_UNIT(value) hash_vec3(hash, &(value))
#define HASH_QUAT(value) hash_quat(hash, &(value))
#define HASH_INT(value) hash_int(hash, (int)(value))
#define HASH_BOOL(value) hash_int(hash, (value) ? 1 : 0)
#define HASH_ENUM(type) HASH_INT
#define HASH_HEIGHT(k) (k) >= scenario->num_attach_heights ? hash : HASH_REAL
#define HASH_RING(value) hash_real(hash, scenario->ring_angle_given ? (value) : REAL(0))
#define HASH_ADDED(value) (value) == REAL(0) ? hash : HASH_REAL(value)
#define HASH_FIELD(kind, core, wire, min, max, unit, text) hash = HASH_##kind(scenario->core);

// Of a body that stands by itself.
#define HASH_BODY_FIELD(kind, core, wire, min, max, unit, text) hash = HASH_##kind(core);

static uint64_t hash_body(uint64_t hash, const ssv_body_t* body) {
    SSV_BODY_FIELDS(HASH_BODY_FIELD, (*body))
    return hash;
}

#define HASH_KEPT_FIELD(kind, core, wire, min, max, unit, text) hash = HASH_##kind(core);

// What the mask selects, with its number: the answer names obstacles by it.
static uint64_t hash_scene(uint64_t hash, const ssv_scene_t* scene, uint64_t obstacles, uint64_t left) {
    for (int k = 0; k < SSV_MAX_OBSTACLES; k++) {
        if ((obstacles >> k & 1) == 0 || scene == NULL) continue;
        const ssv_obstacle_t obstacle = scene->obstacle[k];
        hash = hash_int(hash, k);
        if ((left >> k & 1) != 0) hash = hash_int(hash, -1);
        SSV_OBSTACLE_FIELDS(HASH_KEPT_FIELD)
        if (obstacle.kind == SSV_CAPSULE) {
            SSV_CAPSULE_FIELDS(HASH_KEPT_FIELD)
        }
        if (obstacle.kind == SSV_WALL || obstacle.length_m > REAL(0)) {
            SSV_AXIS_FIELDS(HASH_KEPT_FIELD)
        }
    }
    if (scene == NULL || scene->tank.kind == SSV_NO_TANK) return hash;
    const ssv_tank_t tank = scene->tank;
    hash = hash_int(hash, SSV_OBSTACLE_TANK);
    hash = hash_int(hash, (int)tank.kind);
    SSV_TANK_FIELDS(HASH_KEPT_FIELD)
    if (tank.kind == SSV_CYLINDER) {
        SSV_CYLINDER_FIELDS(HASH_KEPT_FIELD)
    }
    return hash;
}

// What came later leaves the hash as it was where nobody asks for it.
#define IS_ASKED_FOR(kind, core, wire, min, max, unit, text) || scenario->core != REAL(0)

static uint64_t hash_later(uint64_t hash, const ssv_scenario_t* scenario) {
    if (false SSV_LATER_FIELDS(IS_ASKED_FOR)) {
        SSV_LATER_FIELDS(HASH_FIELD)
    }
    return hash_scene(hash, scenario->scene, scenario->obstacles, scenario->left);
}

uint64_t ssv_scenario_hash(const ssv_scenario_t* scenario) {
    uint64_t hash = hash_body(FNV_START, &scenario->vehicle.body);
    SSV_VEHICLE_FIELDS(HASH_FIELD)
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        SSV_THRUSTER_FIELDS(HASH_FIELD, i)
    }
    hash = hash_body(hash, &scenario->beam.body);
    SSV_BEAM_FIELDS(HASH_FIELD)
    SSV_TASK_FIELDS(HASH_FIELD)
    SSV_METHOD_FIELDS(HASH_FIELD)
    for (int k = 0; k < SSV_MAX_ATTACH_HEIGHTS; k++) {
        SSV_HEIGHT_FIELDS(HASH_FIELD, k)
    }
    SSV_OPTION_FIELDS(HASH_FIELD)
    return hash_later(hash, scenario);
}

static uint64_t hash_candidate(uint64_t hash, const ssv_candidate_t* candidate) {
    hash = hash_int(hash, candidate->contact);
    hash = hash_real(hash, candidate->attach_height_m);
    hash = hash_real(hash, candidate->ring_angle_rad);
    hash = hash_int(hash, (int)candidate->outcome);
    hash = hash_real(hash, candidate->time_s);
    hash = hash_real(hash, candidate->impulse_Ns);
    hash = hash_real(hash, candidate->cost);
    if (candidate->outcome < SSV_NO_WAY) return hash;
    hash = hash_int(hash_int(hash, (int)candidate->body), candidate->obstacle);
    return hash_real(hash, candidate->clearance_m);
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
    hash = hash_vec3(hash, &leg->v_S);
    hash = hash_vec3(hash, &leg->w_S);
    hash = hash_pose(hash, &leg->X_IS_start);
    hash = hash_pose(hash, &leg->X_IS_end);
    hash = hash_int(hash, leg->first_arc);
    return hash_int(hash, leg->num_arcs);
}

static uint64_t hash_arc(uint64_t hash, const ssv_arc_t* arc) {
    hash = hash_real(hash, arc->t_s);
    hash = hash_real(hash, arc->duration_s);
    hash = hash_real(hash, arc->s);
    hash = hash_real(hash, arc->v_start);
    hash = hash_real(hash, arc->v_end);
    for (int i = 0; i < 3; i++) hash = hash_real(hash, arc->dv_dt[i]);
    return hash;
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
    if (plan->clearance.obstacle != SSV_OBSTACLE_NONE) {
        hash = hash_real(hash_real(hash, plan->clearance.certified_m), plan->clearance.seen_m);
        hash = hash_real(hash_int(hash, plan->clearance.leg), plan->clearance.s);
        hash = hash_int(hash_int(hash, (int)plan->clearance.body), plan->clearance.obstacle);
    }
    hash = hash_pose(hash, &plan->X_SB);
    hash = hash_pose(hash, &plan->quote.X_IS_final);
    return hash_pose(hash, &plan->quote.X_IB_final);
}
