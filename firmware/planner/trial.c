#include "planner/trial.h"

// Steps to and fro between how the vehicle travels and where.
#define NUM_AIMS 2

quat_t ssv_attitude(vec3_t a_S, vec3_t b_S, vec3_t a_I, vec3_t b_I) {
    const quat_t q = quat_between(a_S, a_I);
    const vec3_t b = quat_apply(q, b_S);
    const vec3_t from = vec3_sub(b, vec3_scale(vec3_dot(b, a_I), a_I)), to = vec3_sub(b_I, vec3_scale(vec3_dot(b_I, a_I), a_I));
    if (!(real_min(vec3_norm(from), vec3_norm(to)) > REAL(1e-6))) return q;
    // Half a turn goes about a_I too.
    const vec3_t u = vec3_unit(from), v = vec3_unit(to), e = vec3_cross(u, v);
    const quat_t roll = {REAL(1) + vec3_dot(u, v), e.x, e.y, e.z}, half_turn = {REAL(0), a_I.x, a_I.y, a_I.z};
    return quat_unit(quat_mul(quat_norm(roll) > REAL(1e-6) ? quat_unit(roll) : half_turn, q));
}

quat_t ssv_turned_by(quat_t q, vec3_t rotation) {
    const real_t angle = vec3_norm(rotation);
    if (!(angle > REAL(0))) return q;
    return quat_unit(quat_mul(q, quat_from_axis_angle(vec3_unit(rotation), angle)));
}

// Where the vehicle stands after turning about a pivot from X to another attitude.
static pose_t turned(pose_t X, quat_t q_to, vec3_t pivot_S) {
    return (pose_t){vec3_add(X.p, vec3_sub(quat_apply(X.q, pivot_S), quat_apply(q_to, pivot_S))), q_to};
}

vec3_t ssv_beam_axis_S(real_t mate_roll) { return vec3(REAL(0), real_cos(mate_roll), real_sin(mate_roll)); }

vec3_t ssv_beam_axis_start(const ssv_task_t* task) {
    return quat_apply(task->problem->scenario.X_IB.q, vec3(REAL(0), REAL(0), REAL(1)));
}

vec3_t ssv_beam_axis_end(const ssv_task_t* task) {
    return vec3_scale(task->contact == 1 ? REAL(1) : REAL(-1), task->problem->scenario.axis_I);
}

void ssv_trial_ends(const ssv_task_t* task, const ssv_trial_t* trial, const quat_t q_IT[SSV_NUM_ENDS], quat_t q_IS[SSV_NUM_ENDS]) {
    if (task->phase == SSV_TRANSIT) {
        q_IS[0] = task->X_from.q;
        q_IS[1] = task->X_to.q;
        return;
    }
    const ssv_scenario_t* s = &task->problem->scenario;
    const vec3_t axis_S = ssv_beam_axis_S(trial->x[SSV_X_MATE_ROLL]);
    const vec3_t axis_I[SSV_NUM_ENDS] = {ssv_beam_axis_start(task), ssv_beam_axis_end(task)};
    for (int end = 0; end < SSV_NUM_ENDS; end++) {
        const quat_t smallest = quat_mul(quat_between(quat_apply(q_IT[end], axis_S), axis_I[end]), q_IT[end]);
        q_IS[end] = quat_unit(quat_mul(quat_from_axis_angle(axis_I[end], trial->x[SSV_X_SPIN + end]), smallest));
    }
    if (s->ring_angle_given) {
        const vec3_t inward_B = vec3(-real_cos(s->ring_angle_rad), -real_sin(s->ring_angle_rad), REAL(0));
        q_IS[0] = ssv_attitude(axis_S, vec3(REAL(1), REAL(0), REAL(0)), axis_I[0], quat_apply(s->X_IB.q, inward_B));
    }
}

static vec3_t part(const ssv_trial_t* trial, int first) { return vec3(trial->x[first], trial->x[first + 1], trial->x[first + 2]); }

// The flight is a screw; its middle attitude turns the chord of its arc to the way.
void ssv_travel_attitudes(const ssv_trial_t* trial, vec3_t way, quat_t q_IT[SSV_NUM_ENDS]) {
    const vec3_t turn = part(trial, SSV_X_TURN), twist = part(trial, SSV_X_TWIST);
    quat_t q_middle = ssv_turned_by(trial->q_IT, turn);
    const vec3_t n = quat_apply(ssv_turned_by(quat_identity(), vec3_neg(turn)), trial->n_S);
    const real_t angle = vec3_norm(twist), distance = vec3_norm(way);
    if (distance > SSV_NO_WAY_M) {
        vec3_t chord = n;
        if (angle > REAL(1e-6)) {
            const vec3_t axis = vec3_scale(real_div(REAL(1), angle), twist), along = vec3_scale(vec3_dot(axis, n), axis);
            chord = vec3_add(along, vec3_scale(real_div(real_sin(angle), angle), vec3_sub(n, along)));
        }
        q_middle = quat_mul(quat_between(quat_apply(q_middle, vec3_unit(chord)), vec3_unit(way)), q_middle);
    }
    q_IT[0] = ssv_turned_by(q_middle, vec3_neg(twist));
    q_IT[1] = ssv_turned_by(q_middle, twist);
}

void ssv_hold_points(const ssv_task_t* task, vec3_t p_I[SSV_NUM_ENDS]) {
    const ssv_scenario_t* s = &task->problem->scenario;
    const real_t from_contact = real_abs(ssv_grasp_contact(s, task->contact).z - task->height_m);
    p_I[0] = vec3_add(s->X_IB.p, vec3_scale(task->height_m, ssv_beam_axis_start(task)));
    p_I[1] = vec3_add(s->p_IP_m, vec3_scale(from_contact, s->axis_I));
}

void ssv_stands(const ssv_task_t* task, const vec3_t hold_I[SSV_NUM_ENDS], const quat_t q_IS[SSV_NUM_ENDS], vec3_t p_IS[SSV_NUM_ENDS]) {
    const vec3_t ahead = vec3(task->problem->scenario.standoff_m, REAL(0), REAL(0));
    for (int end = 0; end < SSV_NUM_ENDS; end++) p_IS[end] = vec3_sub(hold_I[end], quat_apply(q_IS[end], ahead));
}

void ssv_trial_lay(const ssv_task_t* task, const ssv_trial_t* trial, ssv_motion_t* motion) {
    const ssv_scenario_t* s = &task->problem->scenario;
    quat_t q_IT[SSV_NUM_ENDS], q_IS[SSV_NUM_ENDS];
    vec3_t p_IS[SSV_NUM_ENDS] = {task->X_from.p, task->X_to.p};
    pose_t X_IT[SSV_NUM_ENDS];
    if (task->phase == SSV_TRANSIT) {
        motion->assembly = ssv_vehicle_alone(task->problem);
        ssv_travel_attitudes(trial, vec3_sub(p_IS[1], p_IS[0]), q_IT);
        ssv_trial_ends(task, trial, q_IT, q_IS);
        for (int end = 0; end < SSV_NUM_ENDS; end++) X_IT[end] = (pose_t){p_IS[end], q_IT[end]};
    } else {
        // Where the flight starts and ends depends on how the vehicle travels, and that on the way from one to the other: a few
        // steps to and fro.
        vec3_t hold_I[SSV_NUM_ENDS];
        ssv_hold_points(task, hold_I);
        vec3_t way = vec3_sub(hold_I[1], hold_I[0]);
        for (int n = 0; n < NUM_AIMS; n++) {
            ssv_travel_attitudes(trial, way, q_IT);
            ssv_trial_ends(task, trial, q_IT, q_IS);
            ssv_stands(task, hold_I, q_IS, p_IS);
            for (int end = 0; end < SSV_NUM_ENDS; end++) {
                X_IT[end] = turned((pose_t){p_IS[end], q_IS[end]}, q_IT[end], part(trial, SSV_X_PIVOT + 3 * end));
            }
            way = vec3_sub(X_IT[1].p, X_IT[0].p);
        }
        const vec3_t outward_B =
            quat_apply(quat_conj(s->X_IB.q), vec3_neg(quat_apply(q_IS[0], vec3(REAL(1), REAL(0), REAL(0)))));
        const real_t ring_angle = s->ring_angle_given ? s->ring_angle_rad : real_atan2(outward_B.y, outward_B.x);
        motion->grasp = (ssv_grasp_t){task->contact, task->height_m, ring_angle};
        motion->assembly = ssv_vehicle_with_beam(task->problem, (pose_t){p_IS[0], q_IS[0]});
    }
    motion->X_from = (pose_t){p_IS[0], q_IS[0]};
    const pose_t via[] = {motion->X_from, X_IT[0], X_IT[1], {p_IS[1], q_IS[1]}};
    motion->flight.num_moves = SSV_MAX_PHASE_MOVES;
    for (int k = 0; k < SSV_MAX_PHASE_MOVES; k++) {
        motion->flight.move[k] = ssv_move_between(task->phase, via[k], via[k + 1]);
    }
}
