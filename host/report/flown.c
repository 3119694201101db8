#include "flown.h"

#include <math.h>
#include <string.h>

#include "near.h"

/// [s] How far the clocks of what belongs together may be apart: a state and its execution_t are of one instant, a
/// truth is told at most a period earlier or later.
#define SAME_S 1e-4
#define NEAR_S 0.5
/// [s] What the simulator tells later than so long before the end may not have been heard yet.
#define HEARD_S 0.05

/// [m] No vehicle of ours is farther away.
#define FAR_M 1e6
#define UNIT_TOLERANCE 1e-2

enum { POSE_NUMBERS = 7, ESTIMATE_NUMBERS = 18, TRUTH_NUMBERS = 11 };

void flown_begin(flown_t* flown) {
    memset(flown, 0, sizeof *flown);
    flown->estimate.spacing = flown->truth.spacing = 1;
    flown->early[0].time_s = flown->early[1].time_s = -INFINITY;
}

static double norm(const double v[3]) { return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

static bool has_changed(const flown_track_t* track, const flown_row_t* row) {
    if (track->count == 0) return true;
    const flown_row_t* const last = &track->row[track->count - 1];
    double cosine = 0, way[3];
    for (int i = 0; i < 3; i++) way[i] = row->X_IS.p_m[i] - last->X_IS.p_m[i];
    for (int i = 0; i < 4; i++) cosine += row->X_IS.q[i] * last->X_IS.q[i];
    return row->beam != last->beam || row->t_s - last->t_s >= track->spacing * FLOWN_STEP_S - SAME_S ||
           norm(way) >= track->spacing * FLOWN_STEP_M ||
           fabs(cosine) <= cos(fmin(track->spacing * FLOWN_STEP_RAD, 3) / 2);
}

/// Leaves out every second row, but none in which the beam changes hands.
static void thin_out(flown_track_t* track) {
    int kept = 1;
    for (int i = 1; i < track->count; i++) {
        flown_row_t* const row = &track->row[i];
        const bool goes = i % 2 == 1 && i + 1 < track->count && row->beam == track->row[kept - 1].beam &&
                          row->beam == track->row[i + 1].beam;
        if (!goes) {
            track->row[kept++] = *row;
            continue;
        }
        flown_row_t* const next = &track->row[i + 1];
        const double first_s = row->t_s - track->row[kept - 1].t_s, both_s = next->t_s - track->row[kept - 1].t_s;
        for (int k = 0; k < 6; k++) next->u_N[k] += first_s / both_s * (row->u_N[k] - next->u_N[k]);
    }
    track->count = kept;
    track->spacing *= 2;
}

flown_row_t flown_row_of(const flown_t* flown, const lcm_ssv_vehicle_state_t* state) {
    flown_row_t row = {.t_s = state->time_s - flown->start_s,
                       .plan_time_s = flown->plan_time_s,
                       .X_IS = state->X_IS,
                       .speed_m_s = norm(state->v_IS_S_m_s),
                       .rate_rad_s = norm(state->w_IS_S_rad_s),
                       .beam = state->docked  ? FLOWN_DOCKED
                               : state->mated ? FLOWN_MATED
                                              : FLOWN_LIES};
    memcpy(row.u_N, state->u_N, sizeof row.u_N);
    return row;
}

static void note(const flown_t* flown, flown_track_t* track, const lcm_ssv_vehicle_state_t* state) {
    flown_row_t row = flown_row_of(flown, state);
    const flown_beam_t before = track->count == 0 ? FLOWN_LIES : track->row[track->count - 1].beam;
    for (int k = 0; k < 6; k++) track->sum_N[k] += state->u_N[k];
    track->num_summed++;
    if (!has_changed(track, &row)) return;
    if (row.beam != FLOWN_LIES && before == FLOWN_LIES) {
        const lcm_ssv_pose_t X_SI = near_inverse(&state->X_IS);
        track->X_SB = near_compose(&X_SI, &state->X_IB);
    }
    if (row.beam == FLOWN_DOCKED && before != FLOWN_DOCKED) track->X_IB_docked = state->X_IB;
    for (int k = 0; k < 6; k++) row.u_N[k] = track->sum_N[k] / track->num_summed;
    memset(track->sum_N, 0, sizeof track->sum_N);
    track->num_summed = 0;
    if (track->count == FLOWN_ROWS_MAX) thin_out(track);
    track->row[track->count++] = row;
}

static bool is_later(const flown_track_t* track, double t_s) {
    return track->count == 0 || t_s > track->row[track->count - 1].t_s;
}

static bool is_place(const lcm_ssv_pose_t* X) {
    double square = 0;
    for (int i = 0; i < 4; i++) square += X->q[i] * X->q[i];
    return norm(X->p_m) < FAR_M && fabs(square - 1) < UNIT_TOLERANCE;
}

/// Whether the numbers are some that a vehicle may have.
static bool is_sound(const lcm_ssv_vehicle_state_t* state) {
    double sum = 0 * (norm(state->v_IS_S_m_s) + norm(state->w_IS_S_rad_s) + state->time_s);
    for (int i = 0; i < 6; i++) sum += 0 * state->u_N[i];
    return sum == 0 && is_place(&state->X_IS) && is_place(&state->X_IB);
}

bool flown_note_execution(flown_t* flown, const lcm_ssv_execution_t* news) {
    if (!isfinite(news->flown_s) || !isfinite(news->plan_time_s) || news->flown_s < flown->flown_s) return false;
    flown->is_told = news->flown_s > 0;
    flown->flown_s = news->flown_s;
    flown->plan_time_s = news->plan_time_s;
    return true;
}

bool flown_note_estimate(flown_t* flown, const lcm_ssv_vehicle_state_t* state) {
    if (!is_sound(state) || !flown->is_told) return false;
    if (!flown->has_started) {
        flown->has_started = true;
        flown->start_s = state->time_s - flown->flown_s;
        for (int i = 0; i < 2; i++) (void)flown_note_truth(flown, &flown->early[i]);
    }
    const double t_s = state->time_s - flown->start_s;
    if (!(fabs(t_s - flown->flown_s) <= SAME_S) || !is_later(&flown->estimate, t_s)) return false;
    flown->is_told = false;
    note(flown, &flown->estimate, state);
    return true;
}

bool flown_note_truth(flown_t* flown, const lcm_ssv_vehicle_state_t* state) {
    if (!is_sound(state)) return false;
    if (!flown->has_started) {
        flown->early[0] = flown->early[1];
        flown->early[1] = *state;
        return true;
    }
    const double t_s = state->time_s - flown->start_s;
    if (t_s < 0 || !(fabs(t_s - flown->flown_s) <= NEAR_S) || !is_later(&flown->truth, t_s)) return false;
    note(flown, &flown->truth, state);
    return true;
}

// ---- As JSON --------------------------------------------------------------------------------------------------------

static int numbers_of(const flown_row_t* row, bool is_estimate, double numbers[ESTIMATE_NUMBERS]) {
    int n = 0;
    numbers[n++] = row->t_s;
    if (is_estimate) numbers[n++] = row->plan_time_s;
    for (int i = 0; i < 3; i++) numbers[n++] = row->X_IS.p_m[i];
    for (int i = 0; i < 4; i++) numbers[n++] = row->X_IS.q[i];
    numbers[n++] = row->speed_m_s;
    numbers[n++] = row->rate_rad_s;
    numbers[n++] = row->beam;
    for (int i = 0; i < 6 && is_estimate; i++) numbers[n++] = row->u_N[i];
    return n;
}

static json_t* list_of(const double* numbers, int count) {
    json_t* const list = json_array();
    bool sound = list != NULL;
    for (int i = 0; i < count; i++) sound = json_array_append_new(list, json_real(numbers[i])) == 0 && sound;
    if (sound) return list;
    json_decref(list);
    return NULL;
}

static json_t* pose_json(const lcm_ssv_pose_t* X) {
    double numbers[POSE_NUMBERS];
    memcpy(numbers, X->p_m, sizeof X->p_m);
    memcpy(&numbers[3], X->q, sizeof X->q);
    return list_of(numbers, POSE_NUMBERS);
}

static json_t* track_json(const flown_track_t* track, bool is_estimate, double until_s) {
    json_t* const rows = json_array();
    flown_beam_t beam = FLOWN_LIES;
    bool sound = rows != NULL;
    for (int i = 0; i < track->count && track->row[i].t_s <= until_s && sound; i++) {
        double numbers[ESTIMATE_NUMBERS];
        const int count = numbers_of(&track->row[i], is_estimate, numbers);
        beam = track->row[i].beam;
        sound = json_array_append_new(rows, list_of(numbers, count)) == 0;
    }
    json_t* const X_SB = beam == FLOWN_LIES ? json_null() : pose_json(&track->X_SB);
    json_t* const X_IB = beam == FLOWN_DOCKED ? pose_json(&track->X_IB_docked) : json_null();
    json_t* const json = sound ? json_pack("{s:O,s:O,s:O}", "X_SB", X_SB, "X_IB_docked", X_IB, "rows", rows) : NULL;
    json_decref(X_SB);
    json_decref(X_IB);
    json_decref(rows);
    return json;
}

json_t* flown_to_json(const flown_t* flown) {
    const int count = flown->estimate.count;
    const double end_s = count > 0 ? flown->estimate.row[count - 1].t_s : 0;
    json_t* const estimate = track_json(&flown->estimate, true, INFINITY);
    json_t* const truth = flown->truth.count > 0 ? track_json(&flown->truth, false, end_s - HEARD_S) : json_null();
    json_t* const json = json_pack("{s:O,s:O}", "estimate", estimate, "truth", truth);
    json_decref(estimate);
    json_decref(truth);
    return json;
}

// ---- From JSON ------------------------------------------------------------------------------------------------------

static bool read_numbers(const tree_t* list, double* numbers, int count, tree_error_t* error) {
    if (list->kind != TREE_LIST || list->count != count)
        return tree_fail(error, list, "must be a list of %d numbers", count);
    for (int i = 0; i < count; i++) {
        const tree_t* const value = list->entries[i].value;
        if ((value->kind != TREE_REAL && value->kind != TREE_INTEGER) || !isfinite(value->real))
            return tree_fail(error, value, "must be a number");
        numbers[i] = value->real;
    }
    return true;
}

static bool is_unit(const double q[4]) {
    return fabs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1) < UNIT_TOLERANCE;
}

static bool read_pose(const tree_t* within, const char* key, lcm_ssv_pose_t* X, tree_error_t* error) {
    const tree_t* const list = tree_get(within, key);
    double numbers[POSE_NUMBERS] = {0};
    if (list == NULL) return tree_fail_key(error, within, NULL, key, "this key is missing");
    if (list->kind == TREE_NULL) return true;
    if (!read_numbers(list, numbers, POSE_NUMBERS, error)) return false;
    if (!is_unit(&numbers[3])) return tree_fail(error, list, "its quaternion is not of unit length");
    memcpy(X->p_m, numbers, sizeof X->p_m);
    memcpy(X->q, &numbers[3], sizeof X->q);
    return true;
}

static bool read_row(const tree_t* list, bool is_estimate, flown_row_t* row, tree_error_t* error) {
    double numbers[ESTIMATE_NUMBERS] = {0};
    const double* n = numbers;
    if (!read_numbers(list, numbers, is_estimate ? ESTIMATE_NUMBERS : TRUTH_NUMBERS, error)) return false;
    row->t_s = *n++;
    if (is_estimate) row->plan_time_s = *n++;
    memcpy(row->X_IS.p_m, n, sizeof row->X_IS.p_m);
    memcpy(row->X_IS.q, n + 3, sizeof row->X_IS.q);
    n += POSE_NUMBERS;
    row->speed_m_s = *n++;
    row->rate_rad_s = *n++;
    row->beam = *n >= 2 ? FLOWN_DOCKED : *n >= 1 ? FLOWN_MATED : FLOWN_LIES;
    if (is_estimate) memcpy(row->u_N, n + 1, sizeof row->u_N);
    return is_unit(row->X_IS.q) || tree_fail(error, list, "its quaternion is not of unit length");
}

static bool read_track(const tree_t* from, bool is_estimate, flown_track_t* track, tree_error_t* error) {
    const tree_t* const rows = tree_get(from, "rows");
    if (rows == NULL) return tree_fail_key(error, from, NULL, "rows", "this key is missing");
    if (rows->kind != TREE_LIST || rows->count > FLOWN_ROWS_MAX)
        return tree_fail(error, rows, "must be a list of at most %d rows", FLOWN_ROWS_MAX);
    for (; track->count < rows->count; track->count++) {
        const tree_t* const list = rows->entries[track->count].value;
        flown_row_t* const row = &track->row[track->count];
        if (!read_row(list, is_estimate, row, error)) return false;
        if (track->count > 0 && !(row->t_s > row[-1].t_s))
            return tree_fail(error, list, "is not later than the row before");
    }
    return read_pose(from, "X_SB", &track->X_SB, error) && read_pose(from, "X_IB_docked", &track->X_IB_docked, error);
}

bool flown_from_tree(const tree_t* tree, flown_t* flown, tree_error_t* error) {
    const tree_t *estimate = tree_get(tree, "estimate"), *truth = tree_get(tree, "truth");
    flown_begin(flown);
    if (estimate == NULL) return tree_fail_key(error, tree, NULL, "estimate", "this key is missing");
    return read_track(estimate, true, &flown->estimate, error) &&
           (truth == NULL || truth->kind == TREE_NULL || read_track(truth, false, &flown->truth, error));
}
