#include "vehicle/thrust.h"

static bool is_sound(const ssv_thrust_branch_t* branch) {
    if (branch->num_points == 0) return true;
    if (branch->num_points < 2 || branch->num_points > SSV_THRUST_MAX_POINTS) return false;
    if (!(branch->effort[0] > 0 && branch->force_N[0] >= 0)) return false;
    for (int32_t i = 1; i < branch->num_points; i++) {
        if (!(branch->effort[i] > branch->effort[i - 1] && branch->force_N[i] > branch->force_N[i - 1])) return false;
    }
    return branch->effort[branch->num_points - 1] <= 1 && branch->force_N[branch->num_points - 1] <= 1e6F;
}

bool ssv_thrust_is_sound(const ssv_thrust_curve_t* curve) {
    return is_sound(&curve->forward) && is_sound(&curve->reverse);
}

// The effort for a force between the edge and the last point, at the nominal supply.
static float effort_of(const ssv_thrust_branch_t* branch, float force_N) {
    int32_t i = 1;
    while (i < branch->num_points - 1 && force_N > branch->force_N[i]) i++;
    const float share = (force_N - branch->force_N[i - 1]) / (branch->force_N[i] - branch->force_N[i - 1]);
    return branch->effort[i - 1] + share * (branch->effort[i] - branch->effort[i - 1]);
}

float ssv_thrust_effort(const ssv_thrust_curve_t* curve, float force_scale, float force_max_N, float demand_N,
                        float* carried_N, float* given_N) {
    const float wanted_N = demand_N + *carried_N;
    const float sign = wanted_N < 0 ? -1.0F : 1.0F;
    const float size_N = sign * wanted_N;
    const ssv_thrust_branch_t* branch = wanted_N < 0 ? &curve->reverse : &curve->forward;
    const bool is_table = branch->num_points > 0;
    const float edge_N = is_table ? force_scale * branch->force_N[0] : 0;
    const float strongest_N = force_scale * (is_table ? branch->force_N[branch->num_points - 1] : force_max_N);
    const float most_N = strongest_N < force_max_N ? strongest_N : force_max_N;
    *given_N = 0;
    if (edge_N > most_N) { // a supply so strong or so weak that the band has no thrust that is allowed
        *carried_N = 0;
        return 0;
    }
    if (size_N < edge_N) {
        if (2 * size_N < edge_N) {
            *carried_N = wanted_N;
            return 0;
        }
        *given_N = sign * edge_N;
        *carried_N = wanted_N - *given_N;
        return sign * branch->effort[0];
    }
    const float give_N = size_N < most_N ? size_N : most_N;
    *given_N = sign * give_N;
    *carried_N = 0;
    float effort = is_table ? effort_of(branch, give_N / force_scale) : give_N / (force_scale * force_max_N);
    if (effort > 1) effort = 1;
    return sign * effort;
}
