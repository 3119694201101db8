#include "track.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ssv/answer.h"

/// What a scenario is given for a margin that has none, so that its own beam counts as something to keep clear of.
#define SOME_MARGIN_M 1e-6
/// Halves of halves of a stretch under way.
#define MAX_STRETCHES 40
/// Rows of a motion that is none: no plan that a planner makes comes near them.
#define ROWS_SANE (20 * TRACK_ROWS_MAX)
/// How far from 1 the length of a quaternion may be.
#define UNIT_TOLERANCE 1e-3

// ---- Whether there is something to sample ---------------------------------------------------------------------------

static bool are_finite(const double* numbers, int count) {
    double sum = 0;
    for (int i = 0; i < count; i++) sum += numbers[i] * 0;
    return sum == 0;
}

static bool is_pose(const lcm_ssv_pose_t* X) {
    const double* const q = X->q;
    const double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    return are_finite(X->p_m, 3) && fabs(square - 1) < 2 * UNIT_TOLERANCE;
}

static bool fail(char* error, size_t size, const char* what) {
    snprintf(error, size, "%s", what);
    return false;
}

static bool check_legs(const lcm_ssv_plan_t* plan, char* error, size_t size) {
    double end_s = 0;
    for (int i = 0; i < plan->num_legs; i++) {
        const lcm_ssv_leg_t* const leg = &plan->legs[i];
        const bool has_arcs =
            leg->first_arc >= 0 && leg->num_arcs > 0 && leg->first_arc + leg->num_arcs <= plan->num_arcs;
        const double numbers[] = {leg->duration_s, leg->length, leg->v_S[0], leg->v_S[1],
                                  leg->v_S[2],     leg->w_S[0], leg->w_S[1], leg->w_S[2]};
        if (!has_arcs || !are_finite(numbers, 8) || !is_pose(&leg->X_IS_start) || !is_pose(&leg->X_IS_end) ||
            !(leg->t_start_s >= end_s - 1e-3) || !(leg->duration_s >= 0)) {
            snprintf(error, size, "plan.legs[%d] is no motion: arcs, times or poses are none", i);
            return false;
        }
        end_s = leg->t_start_s + leg->duration_s;
    }
    for (int i = 0; i < plan->num_arcs; i++) {
        const lcm_ssv_arc_t* const arc = &plan->arcs[i];
        const double numbers[] = {arc->t_s,   arc->duration_s, arc->s,        arc->v_start,
                                  arc->v_end, arc->dv_dt[0],   arc->dv_dt[1], arc->dv_dt[2]};
        if (!are_finite(numbers, 8)) return fail(error, size, "plan.arcs holds a number that is none");
    }
    return true;
}

/// What ssv_plan_from_wire and the sampler must be able to rely on; whether the plan is any good is another question.
static bool check(const lcm_ssv_plan_t* plan, char* error, size_t size) {
    if (plan->quote.status != LCM_SSV_QUOTE_T_STATUS_OK) {
        snprintf(error, size, "there is no plan to show: %s", plan->quote.reason);
        return false;
    }
    if (plan->num_legs < 1 || plan->num_arcs < 1 || plan->num_segments < 1 || plan->num_events != 2) {
        return fail(error, size, "plan: legs, arcs, segments and two events are what a plan has");
    }
    if (!(plan->quote.time_s > 0 && plan->quote.time_s <= real_to_double(SSV_DURATION_MAX_S)) ||
        !(plan->events[0].t_s >= 0 && plan->events[0].t_s <= plan->events[1].t_s)) {
        return fail(error, size, "plan: time_s or the times of mate and dock are none of a plan");
    }
    if (!is_pose(&plan->X_SB) || !is_pose(&plan->quote.X_IS_final) || !is_pose(&plan->quote.X_IB_final)) {
        return fail(error, size, "plan: X_SB, X_IS_final or X_IB_final is no pose");
    }
    for (int i = 0; i < plan->num_segments; i++) {
        const lcm_ssv_segment_t* const segment = &plan->segments[i];
        if (!are_finite(segment->u_start_N, 6) || !are_finite(segment->u_end_N, 6) || !(segment->duration_s >= 0) ||
            !are_finite(&segment->t_s, 1)) {
            return fail(error, size, "plan.segments holds a number that is none");
        }
    }
    return check_legs(plan, error, size);
}

// ---- Rows -----------------------------------------------------------------------------------------------------------

static lcm_ssv_pose_t wire_pose(const pose_t* X) {
    return (lcm_ssv_pose_t){
        .p_m = {real_to_double(X->p.x), real_to_double(X->p.y), real_to_double(X->p.z)},
        .q = {real_to_double(X->q.w), real_to_double(X->q.x), real_to_double(X->q.y), real_to_double(X->q.z)}};
}

static double norm_of(vec3_t v) {
    return sqrt(real_to_double(v.x) * real_to_double(v.x) + real_to_double(v.y) * real_to_double(v.y) +
                real_to_double(v.z) * real_to_double(v.z));
}

static track_row_t row_at(const track_t* track, double t_s) {
    ssv_sample_t sample;
    ssv_plan_sample(&track->plan, real_from_double(t_s), &sample);
    return (track_row_t){.t_s = t_s,
                         .X_IS = wire_pose(&sample.X_IS),
                         .speed_m_s = norm_of(sample.v_IS_S_m_s),
                         .rate_rad_s = norm_of(sample.w_IS_S_rad_s),
                         .leg = sample.leg,
                         .mated = sample.mated};
}

static double distance(const double a[3], const double b[3]) {
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

static double angle(const double a[4], const double b[4]) {
    const double cosine = fabs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]);
    return 2 * acos(fmin(cosine, 1));
}

/// Whether a straight line from one row to the other will do, given the one in the middle of the time between.
static bool is_close(const track_row_t* a, const track_row_t* middle, const track_row_t* b, double scale) {
    const double* const p = a->X_IS.p_m;
    const double* const q = b->X_IS.p_m;
    const double half[3] = {(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2};
    const double turned = angle(a->X_IS.q, b->X_IS.q);
    return distance(p, q) <= scale * TRACK_STEP_M && turned <= scale * TRACK_STEP_RAD &&
           distance(half, middle->X_IS.p_m) <= scale * TRACK_BEND_M &&
           fabs(angle(a->X_IS.q, middle->X_IS.q) - turned / 2) <= scale * TRACK_BEND_RAD;
}

static bool is_row(const track_row_t* row) {
    return is_pose(&row->X_IS) && are_finite(&row->speed_m_s, 1) && are_finite(&row->rate_rad_s, 1);
}

static bool add(track_t* track, int* room, const track_row_t* row) {
    if (track->count == *room) {
        track_row_t* const more = realloc(track->rows, 2 * (size_t)(*room + 64) * sizeof *more);
        if (more == NULL) return false;
        track->rows = more;
        *room = 2 * (*room + 64);
    }
    track->rows[track->count++] = *row;
    return true;
}

/// Adds the rows after the last one up to and with that at to_s. @return false if they are none, or out of memory.
static bool add_stretch(track_t* track, int* room, double to_s, double scale) {
    track_row_t from = track->rows[track->count - 1], end[MAX_STRETCHES];
    int num = 1;
    end[0] = row_at(track, to_s);
    while (num > 0) {
        if (track->count > ROWS_SANE || !is_row(&end[num - 1])) return false;
        const track_row_t middle = row_at(track, from.t_s + (end[num - 1].t_s - from.t_s) / 2);
        if (num == MAX_STRETCHES || is_close(&from, &middle, &end[num - 1], scale)) {
            from = end[--num];
            if (!add(track, room, &from)) return false;
        } else {
            end[num++] = middle;
        }
    }
    return true;
}

/// The rows with all distances in them this many times as long.
static bool sample_all(track_t* track, int* room, double scale) {
    const ssv_plan_t* const plan = &track->plan;
    const double end_s = real_to_double(plan->quote.time_s);
    const track_row_t first = row_at(track, 0);
    track->count = 0;
    bool sound = add(track, room, &first);
    for (int leg = 0; leg < plan->num_legs && sound; leg++) {
        for (int k = 0; k < plan->leg[leg].num_arcs && sound; k++) {
            const ssv_arc_t* const arc = &plan->arc[plan->leg[leg].first_arc + k];
            const double to_s =
                real_to_double(plan->leg[leg].t_start_s) + real_to_double(arc->t_s) + real_to_double(arc->duration_s);
            if (to_s > track->rows[track->count - 1].t_s) sound = add_stretch(track, room, fmin(to_s, end_s), scale);
        }
    }
    if (sound && track->rows[track->count - 1].t_s < end_s) sound = add_stretch(track, room, end_s, scale);
    return sound;
}

// ---- What is near ---------------------------------------------------------------------------------------------------

/// The point whose way counts for the contacts that are allowed: the vehicle's origin, later the beam's contact.
static void tip_of(const track_t* track, const track_row_t* row, double tip[3]) {
    const double half_m = track->scene.task->scenario.beam.length_m / 2;
    const double p_BE[3] = {0, 0, track->plan.quote.choice.contact == 1 ? -half_m : half_m};
    double p_SE[3] = {0};
    if (row->mated) near_point(&track->scene.X_SB, p_BE, p_SE);
    near_point(&row->X_IS, p_SE, tip);
}

static double step_m(const track_t* track, int i) {
    double before[3], after[3];
    tip_of(track, &track->rows[i - 1], before);
    tip_of(track, &track->rows[i], after);
    return distance(before, after);
}

/// Fills in what is near each row of a phase, rows [first, end).
static void look_around(track_t* track, int first, int end) {
    double whole_m = 0, behind_m = 0;
    for (int i = first + 1; i < end; i++) whole_m += step_m(track, i);
    for (int i = first; i < end; i++) {
        if (i > first) behind_m += step_m(track, i);
        track_row_t* const row = &track->rows[i];
        row->behind_m = behind_m;
        row->ahead_m = whole_m - behind_m;
        const near_place_t place = {row->X_IS, row->mated, row->behind_m, row->ahead_m};
        row->near = near_at(&track->scene, &place);
    }
}

near_t track_near(const track_t* track, double t_s, const lcm_ssv_pose_t* X_IS, bool mated) {
    int low = 0, high = track->count;
    while (high - low > 1) {
        const int middle = low + (high - low) / 2;
        if (track->rows[middle].t_s <= t_s)
            low = middle;
        else
            high = middle;
    }
    const track_row_t* const row = &track->rows[low];
    near_place_t place = {*X_IS, mated, row->behind_m, row->ahead_m};
    if (row->mated != mated) { // it waits to mate, or has mated early
        place.behind_m = mated ? 0 : INFINITY;
        place.ahead_m = mated ? INFINITY : 0;
    }
    return near_at(&track->scene, &place);
}

/// A row of its own where the planner saw the least clearance: so far along that leg.
static bool mark_closest(track_t* track, int* room) {
    const ssv_clearance_t* const c = &track->clearance;
    if (c->obstacle == SSV_OBSTACLE_NONE || c->leg >= track->plan.num_legs) return true;
    const bool turns = track->plan.leg[c->leg].kind == SSV_TURN;
    const double start_s = real_to_double(track->plan.leg[c->leg].t_start_s), s = real_to_double(c->s);
    double along = 0, step = 0;
    int i = 0;
    while (i + 1 < track->count && track->rows[i].t_s < start_s) i++;
    for (; i + 1 < track->count; i++, along += step) {
        const lcm_ssv_pose_t *a = &track->rows[i].X_IS, *b = &track->rows[i + 1].X_IS;
        step = turns ? angle(a->q, b->q) : distance(a->p_m, b->p_m);
        if (along + step >= s) break;
    }
    if (i + 1 == track->count) i--;
    const double part = step > 0 ? fmin(fmax((s - along) / step, 0), 1) : 0;
    track_row_t row = row_at(track, track->rows[i].t_s + part * (track->rows[i + 1].t_s - track->rows[i].t_s));
    const near_place_t place = {row.X_IS, row.mated, INFINITY, INFINITY};
    row.near = near_pair(&track->scene, &place, (int8_t)c->body, (int8_t)c->obstacle);
    row.behind_m = track->rows[i].behind_m;
    row.ahead_m = track->rows[i].ahead_m;
    if (!add(track, room, &row)) return false;
    memmove(&track->rows[i + 2], &track->rows[i + 1], (size_t)(track->count - i - 2) * sizeof row);
    track->rows[i + 1] = row;
    track->closest = i + 1;
    return true;
}

track_row_t track_at(const track_t* track, double t_s) {
    track_row_t row = row_at(track, t_s);
    row.near = track_near(track, t_s, &row.X_IS, row.mated);
    return row;
}

// ---- All of it ------------------------------------------------------------------------------------------------------

static bool pose_problem(track_t* track, const lcm_ssv_task_t* task, char* error, size_t size) {
    ssv_scenario_t scenario;
    ssv_fault_t fault;
    ssv_scene_from_wire(&track->core_scene, &task->scene);
    ssv_scenario_from_wire(&scenario, &task->scenario, &track->core_scene);
    scenario.margin_m = real_max(scenario.margin_m, real_from_double(SOME_MARGIN_M));
    if (ssv_problem_init(&track->problem, &scenario, &fault) == SSV_OK) return true;
    snprintf(error, size, "scenario.%s: %s", fault.field, ssv_status_str(fault.status));
    return false;
}

bool track_of_plan(const lcm_ssv_task_t* task, const lcm_ssv_plan_t* plan, track_t* track, char* error,
                   size_t error_size) {
    *track = (track_t){.rows = NULL};
    if (!check(plan, error, error_size) || !pose_problem(track, task, error, error_size)) return false;
    ssv_plan_from_wire(&track->plan, plan);
    track->scene = (near_scene_t){task, &track->problem.around, plan->X_SB};
    ssv_plan_clearance(&track->problem, &track->plan, &track->core_scene, (uint64_t)task->scenario.obstacles,
                       &track->clearance);
    int room = 0;
    bool sound = sample_all(track, &room, 1);
    if (sound && track->count > TRACK_ROWS_MAX) sound = sample_all(track, &room, (double)track->count / TRACK_ROWS_MAX);
    int mate = 0;
    while (sound && mate < track->count && !track->rows[mate].mated) mate++;
    if (sound) {
        look_around(track, 0, mate);
        look_around(track, mate, track->count);
        sound = mark_closest(track, &room);
    }
    if (!sound) {
        track_free(track);
        return fail(error, error_size, "plan: its arcs lead to no motion, or memory ran out");
    }
    return true;
}

void track_free(track_t* track) {
    free(track->rows);
    track->rows = NULL;
    track->count = 0;
}
