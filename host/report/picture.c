#include "picture.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "track.h"
#include "wire/message.h"
#include "wire/names.h"

// ---- Small parts ----------------------------------------------------------------------------------------------------

static json_t* numbers(const double* values, int count) {
    json_t* const list = json_array();
    for (int i = 0; i < count; i++) json_array_append_new(list, json_real(values[i]));
    return list;
}

/// [x, y, z, w, x, y, z]: position in m, then the quaternion, scalar first.
static json_t* pose(const lcm_ssv_pose_t* X) {
    json_t* const list = numbers(X->p_m, 3);
    for (int i = 0; i < 4; i++) json_array_append_new(list, json_real(X->q[i]));
    return list;
}

static json_t* hash(int64_t bits) {
    char text[17];
    snprintf(text, sizeof text, "%016" PRIx64, (uint64_t)bits);
    return json_string(text);
}

// ---- What stands and moves there ------------------------------------------------------------------------------------

/// Those that count for this task.
static json_t* obstacles(const track_t* track) {
    const lcm_ssv_task_t* const task = track->scene.task;
    json_t* const list = json_array();
    for (int i = 0; i < task->scene.num_obstacles; i++) {
        const lcm_ssv_obstacle_t* const obstacle = &task->scene.obstacles[i];
        if (((uint64_t)task->scenario.obstacles >> i & 1) == 0) continue;
        json_array_append_new(
            list, json_pack("{s:i,s:s,s:o,s:o,s:f,s:f}", "number", i, "kind", name_of(&names_obstacle, obstacle->kind),
                            "p_I_m", numbers(obstacle->p_I_m, 3), "axis_I", numbers(obstacle->axis_I, 3), "length_m",
                            obstacle->length_m, "radius_m", obstacle->radius_m));
    }
    return list;
}

static json_t* tank(const lcm_ssv_tank_t* from) {
    if (from->kind == LCM_SSV_TANK_T_KIND_NONE) return json_null();
    return json_pack("{s:s,s:o,s:o,s:f}", "kind", name_of(&names_tank, from->kind), "from_I_m",
                     numbers(from->from_I_m, 3), "to_I_m", numbers(from->to_I_m, 3), "radius_m", from->radius_m);
}

static json_t* thrusters(const lcm_ssv_vehicle_t* vehicle) {
    json_t* const list = json_array();
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        json_array_append_new(list, json_pack("{s:o,s:o}", "p_ST_m", numbers(vehicle->thruster[i].p_ST_m, 3), "n_T_S",
                                              numbers(vehicle->thruster[i].n_T_S, 3)));
    }
    return list;
}

static json_t* bodies(const track_t* track, const lcm_ssv_plan_t* plan) {
    const lcm_ssv_scenario_t* const scenario = &track->scene.task->scenario;
    return json_pack("{s:{s:f,s:f,s:o},s:{s:f,s:f},s:o,s:o,s:o,s:o,s:o,s:{s:o,s:o},s:o,s:o,s:f}", "vehicle", "radius_m",
                     scenario->vehicle.radius_m, "force_max_N", scenario->vehicle.force_max_N, "thrusters",
                     thrusters(&scenario->vehicle), "beam", "length_m", scenario->beam.length_m, "radius_m",
                     scenario->beam.radius_m, "X_IS_start", pose(&scenario->X_IS), "X_IS_final",
                     pose(&plan->quote.X_IS_final), "X_IB_start", pose(&scenario->X_IB), "X_IB_final",
                     pose(&plan->quote.X_IB_final), "X_SB", pose(&plan->X_SB), "port", "p_IP_m",
                     numbers(scenario->port.p_IP_m, 3), "axis_I", numbers(scenario->port.axis_I, 3), "obstacles",
                     obstacles(track), "tank", tank(&track->scene.task->scene.tank), "margin_m", scenario->margin_m);
}

// ---- What was planned -----------------------------------------------------------------------------------------------

static json_t* price(const lcm_ssv_scenario_t* scenario, const lcm_ssv_plan_t* plan) {
    const lcm_ssv_quote_t* const quote = &plan->quote;
    return json_pack(
        "{s:f,s:f,s:f,s:f,s:f,s:f,s:f,s:i,s:f,s:f,s:i,s:s,s:s,s:s,s:o,s:o}", "cost", quote->cost, "cost_lower_bound",
        quote->cost_lower_bound, "time_s", quote->time_s, "impulse_Ns", quote->impulse_Ns, "weight_time_per_s",
        scenario->weight_time_per_s, "weight_impulse_per_Ns", scenario->weight_impulse_per_Ns, "thrust_reserve",
        scenario->thrust_reserve, "contact", quote->choice.contact, "attach_height_m", quote->choice.attach_height_m,
        "ring_angle_rad", quote->choice.ring_angle_rad, "candidates", (int)quote->choice.candidates, "method",
        name_of(&names_method, scenario->options.method), "effort", name_of(&names_effort, scenario->options.effort),
        "scalar", name_of(&names_scalar, plan->answer.planner.scalar), "scenario_hash", hash(quote->scenario_hash),
        "plan_hash", hash(plan->plan_hash));
}

static json_t* legs(const lcm_ssv_plan_t* plan) {
    json_t* const list = json_array();
    for (int i = 0; i < plan->num_legs; i++) {
        const lcm_ssv_leg_t* const leg = &plan->legs[i];
        json_array_append_new(
            list, json_pack("{s:s,s:s,s:s,s:f,s:f,s:f,s:f,s:f}", "phase", name_of(&names_phase, leg->phase), "kind",
                            name_of(&names_kind, leg->kind), "ramp", name_of(&names_ramp, leg->ramp), "t_start_s",
                            leg->t_start_s, "duration_s", leg->duration_s, "impulse_Ns", leg->impulse_Ns, "length",
                            leg->length, "peak_speed", leg->peak_speed));
    }
    return list;
}

/// The least clearance of the plan; null where there is nothing around.
static json_t* clearance(const track_t* track) {
    const ssv_clearance_t* const c = &track->clearance;
    if (c->obstacle == SSV_OBSTACLE_NONE) return json_null();
    return json_pack("{s:f,s:f,s:i,s:s,s:i,s:f}", "certified_m", real_to_double(c->certified_m), "seen_m",
                     real_to_double(c->seen_m), "leg", c->leg, "body", name_of(&names_body, (int8_t)c->body),
                     "obstacle", c->obstacle, "t_s", track->rows[track->closest].t_s);
}

/// The timeline: each thrust runs on a straight line from row to row of [time, six thrusts].
static json_t* thrust(const lcm_ssv_plan_t* plan) {
    json_t* const rows = json_array();
    for (int i = 0; i < plan->num_segments; i++) {
        const lcm_ssv_segment_t* const segment = &plan->segments[i];
        for (int end = 0; end < 2; end++) {
            const double t_s = segment->t_s + end * segment->duration_s;
            json_t* const row = numbers(&t_s, 1);
            const double* const u_N = end == 0 ? segment->u_start_N : segment->u_end_N;
            for (int k = 0; k < SSV_NUM_THRUSTERS; k++) json_array_append_new(row, json_real(u_N[k]));
            json_array_append_new(rows, row);
        }
    }
    return rows;
}

/// The pair that is nearest there: [distance in m, body, obstacle, point on the one, point on the other]; null if none.
static json_t* near_json(const near_t* near) {
    if (near->obstacle == LCM_SSV_CLEARANCE_T_OBSTACLE_NONE) return json_null();
    json_t* const list = numbers(&near->distance_m, 1);
    json_array_append_new(list, json_integer(near->body));
    json_array_append_new(list, json_integer(near->obstacle));
    for (int i = 0; i < 3; i++) json_array_append_new(list, json_real(near->p_body_I_m[i]));
    for (int i = 0; i < 3; i++) json_array_append_new(list, json_real(near->p_obstacle_I_m[i]));
    return list;
}

/// Rows of [time, pose of the vehicle, speed in m/s, rate in rad/s, leg, 1 if mated, nearest pair].
static json_t* rows(const track_t* track) {
    json_t* const list = json_array();
    for (int i = 0; i < track->count; i++) {
        const track_row_t* const row = &track->rows[i];
        json_array_append_new(list, json_pack("[f,o,f,f,i,i,o]", row->t_s, pose(&row->X_IS), row->speed_m_s,
                                              row->rate_rad_s, row->leg, (int)row->mated, near_json(&row->near)));
    }
    return list;
}

// ---- What was flown -------------------------------------------------------------------------------------------------

static double clock_at(const flown_track_t* estimate, double t_s) {
    int i = 0;
    while (i + 1 < estimate->count && estimate->row[i + 1].t_s <= t_s) i++;
    if (i + 1 >= estimate->count) return estimate->count > 0 ? estimate->row[i].plan_time_s : 0;
    const flown_row_t *const a = &estimate->row[i], *const b = &estimate->row[i + 1];
    return a->plan_time_s + (t_s - a->t_s) / (b->t_s - a->t_s) * (b->plan_time_s - a->plan_time_s);
}

/// [time, pose of the vehicle, speed in m/s, rate in rad/s, 0 the beam lies, 1 it is mated, 2 docked, nearest pair,
/// time of the plan, six thrusts]; of a truth without thrusts, of an estimate beside a truth without a pair.
static json_t* flown_row_json(const flown_row_t* row, double plan_time_s, const track_t* track, bool is_truth,
                              bool is_beside_truth) {
    const near_t near = track_near(track, plan_time_s, &row->X_IS, row->beam != FLOWN_LIES);
    const bool has_pair = row->beam != FLOWN_DOCKED && !is_beside_truth;
    return json_pack("[f,o,f,f,i,o,f,o]", row->t_s, pose(&row->X_IS), row->speed_m_s, row->rate_rad_s, (int)row->beam,
                     has_pair ? near_json(&near) : json_null(), plan_time_s,
                     numbers(row->u_N, is_truth ? 0 : SSV_NUM_THRUSTERS));
}

static json_t* flown_rows(const flown_track_t* from, const flown_t* flown, const track_t* track) {
    json_t* const list = json_array();
    const bool is_truth = from == &flown->truth;
    for (int i = 0; i < from->count; i++) {
        const flown_row_t* const row = &from->row[i];
        const double plan_time_s = is_truth ? clock_at(&flown->estimate, row->t_s) : row->plan_time_s;
        json_array_append_new(list,
                              flown_row_json(row, plan_time_s, track, is_truth, !is_truth && flown->truth.count > 0));
    }
    return list;
}

/// Where the beam is held in the vehicle, and where it was docked; null before.
static json_t* held(const flown_track_t* from) {
    const flown_beam_t beam = from->count > 0 ? from->row[from->count - 1].beam : FLOWN_LIES;
    return json_pack("{s:o,s:o}", "X_SB", beam == FLOWN_LIES ? json_null() : pose(&from->X_SB), "X_IB_docked",
                     beam == FLOWN_DOCKED ? pose(&from->X_IB_docked) : json_null());
}

json_t* picture_row(const track_t* track, const flown_t* flown, const lcm_ssv_vehicle_state_t* state, bool is_truth) {
    const flown_row_t row = flown_row_of(flown, state);
    return json_pack("{s:s,s:s,s:o,s:o}", "kind", "row", "track", is_truth ? "truth" : "estimate", "row",
                     flown_row_json(&row, flown->plan_time_s, track, is_truth, false), "held",
                     held(is_truth ? &flown->truth : &flown->estimate));
}

static json_t* flown_track(const flown_track_t* from, const flown_t* flown, const track_t* track) {
    if (from->count == 0) return json_null();
    json_t* const json = held(from);
    json_object_set_new(json, "rows", flown_rows(from, flown, track));
    return json;
}

static json_t* attempt(const record_attempt_t* from) {
    if (from->outcome[0] == '\0') return json_null();
    return json_pack("{s:s,s:f,s:f,s:f}", "outcome", from->outcome, "position_m", from->position_m, "angle_rad",
                     from->angle_rad, "speed_m_s", from->speed_m_s);
}

static json_t* flown_legs(const record_flight_t* flight, int count) {
    json_t* const list = json_array();
    for (int i = 0; i < count; i++) {
        const record_leg_t* const leg = &flight->leg[i];
        json_array_append_new(list, leg->begun ? json_pack("{s:f,s:f,s:f}", "time_s", leg->time_s, "wait_s",
                                                           leg->wait_s, "impulse_Ns", leg->impulse_Ns)
                                               : json_null());
    }
    return list;
}

static json_t* flight_json(const record_flight_t* flight, const track_t* track) {
    if (flight == NULL) return json_null();
    const lcm_ssv_execution_t* const end = &flight->end;
    return json_pack("{s:s,s:s,s:i,s:i,s:f,s:f,s:s,s:s,s:o,s:o,s:o,s:o,s:o}", "outcome",
                     name_of(&names_outcome, end->outcome), "reason", end->reason, "attempts", (int)end->attempts,
                     "num_plans", (int)end->num_plans, "flown_s", end->flown_s, "impulse_Ns", end->impulse_Ns,
                     "conditions", flight->conditions, "seed", flight->seed, "mate", attempt(&flight->mate), "dock",
                     attempt(&flight->dock), "legs", flown_legs(flight, track->plan.num_legs), "estimate",
                     flown_track(&flight->track.estimate, &flight->track, track), "truth",
                     flown_track(&flight->track.truth, &flight->track, track));
}

static json_t* task_json(const record_task_t* task, const track_t* track) {
    json_t* const json = bodies(track, &task->plan);
    json_t* const parts =
        json_pack("{s:s,s:s,s:o,s:o,s:[f,f],s:o,s:o,s:o,s:o}", "name", task->name, "breach", task->breach, "price",
                  price(&task->question.scenario, &task->plan), "legs", legs(&task->plan), "events_s",
                  task->plan.events[0].t_s, task->plan.events[1].t_s, "clearance", clearance(track), "thrust",
                  thrust(&task->plan), "rows", rows(track), "flight", flight_json(task->flight, track));
    if (json_object_update(json, parts) != 0) {
        json_decref(json);
        return NULL;
    }
    json_decref(parts);
    return json;
}

json_t* picture_of(const record_t* record, char* error, size_t error_size) {
    json_t* const tasks = json_array();
    track_t* const track = malloc(sizeof *track);
    bool sound = tasks != NULL && track != NULL;
    if (!sound) snprintf(error, error_size, "out of memory");
    for (int i = 0; i < record->count && sound; i++) {
        char reason[300];
        sound = track_of_plan(&record->tasks[i].question, &record->tasks[i].plan, track, reason, sizeof reason);
        if (!sound) {
            snprintf(error, error_size, "%s: %s%s%s", record->title, record->count > 1 ? record->tasks[i].name : "",
                     record->count > 1 ? ": " : "", reason);
            break;
        }
        sound = json_array_append_new(tasks, task_json(&record->tasks[i], track)) == 0;
        if (!sound) snprintf(error, error_size, "%s: a number of it is not finite, or memory ran out", record->title);
        track_free(track);
    }
    free(track);
    json_t* const data = sound ? json_pack("{s:s,s:O}", "title", record->title, "tasks", tasks) : NULL;
    json_decref(tasks);
    return data;
}
