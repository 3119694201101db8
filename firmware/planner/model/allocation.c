#include "planner/model/allocation.h"

#define N SSV_NUM_THRUSTERS
// A smaller pivot, of a matrix with entries near 1, is rounding.
#define PIVOT_MIN REAL(1e-6)

static real_t norm_inf(real_t m[N][N]) {
    real_t norm = REAL(0);
    for (int r = 0; r < N; r++) {
        real_t sum = REAL(0);
        for (int c = 0; c < N; c++) sum += real_abs(m[r][c]);
        norm = real_max(norm, sum);
    }
    return norm;
}

// Gauss-Jordan with row pivoting. Pivots that are rounding count as if they were a little larger, so that there is an
// inverse, and its large rows say what thrusters of any size can hardly do. @return whether it is the inverse.
static bool invert(real_t m[N][N], real_t inverse[N][N]) {
    bool regular = true;
    for (int r = 0; r < N; r++) {
        for (int c = 0; c < N; c++) inverse[r][c] = r == c ? REAL(1) : REAL(0);
    }
    for (int c = 0; c < N; c++) {
        int pivot = c;
        for (int r = c + 1; r < N; r++) {
            if (real_abs(m[r][c]) > real_abs(m[pivot][c])) pivot = r;
        }
        if (real_abs(m[pivot][c]) < PIVOT_MIN) {
            m[pivot][c] = PIVOT_MIN;
            regular = false;
        }
        for (int k = 0; k < N; k++) {
            const real_t swap_m = m[c][k], swap_i = inverse[c][k];
            m[c][k] = m[pivot][k];
            m[pivot][k] = swap_m;
            inverse[c][k] = inverse[pivot][k];
            inverse[pivot][k] = swap_i;
        }
        const real_t scale = m[c][c];
        for (int k = 0; k < N; k++) {
            m[c][k] = real_div(m[c][k], scale);
            inverse[c][k] = real_div(inverse[c][k], scale);
        }
        for (int r = 0; r < N; r++) {
            if (r == c) continue;
            const real_t factor = m[r][c];
            for (int k = 0; k < N; k++) {
                m[r][k] -= real_mul(factor, m[c][k]);
                inverse[r][k] -= real_mul(factor, inverse[c][k]);
            }
        }
    }
    return regular;
}

// The direction that none of these have a part along, or next to none. @return zero if there is no such direction.
static vec3_t missing(vec3_t v[N]) {
    const vec3_t zero = vec3(REAL(0), REAL(0), REAL(0));
    vec3_t longest = zero, across = zero;
    for (int i = 0; i < N; i++) {
        if (vec3_norm(v[i]) > vec3_norm(longest)) longest = v[i];
    }
    const real_t length = vec3_norm(longest);
    if (!(length > REAL(0))) return vec3(REAL(1), REAL(0), REAL(0)); // any will do
    for (int i = 0; i < N; i++) {
        v[i] = vec3(real_div(v[i].x, length), real_div(v[i].y, length), real_div(v[i].z, length));
        for (int k = 0; k < i; k++) {
            const vec3_t square = vec3_cross(v[k], v[i]);
            if (vec3_norm(square) > vec3_norm(across)) across = square;
        }
    }
    const vec3_t n = vec3_norm(across) > SSV_LACK_MIN ? vec3_unit(across) : vec3_perpendicular(longest);
    for (int i = 0; i < N; i++) {
        if (real_abs(vec3_dot(n, v[i])) > SSV_LACK_MIN) return zero;
    }
    return n;
}

static real_t or_zero(real_t part) { return real_abs(part) < SSV_LACK_MIN ? REAL(0) : part; }

static vec3_t unit_or_zero(const real_t w[3]) {
    const vec3_t v = vec3(or_zero(w[0]), or_zero(w[1]), or_zero(w[2]));
    return vec3_norm(v) > REAL(0) ? vec3_unit(v) : v;
}

// A row of the inverse is the wrench for which its thruster has to give most: the longest row is what they do worst.
static void find_coupled(real_t inverse[N][N], ssv_lack_t* lack) {
    real_t most = REAL(0), w[N];
    int worst = 0;
    for (int i = 0; i < N; i++) {
        for (int c = 0; c < N; c++) {
            if (real_abs(inverse[i][c]) <= real_abs(most)) continue;
            most = inverse[i][c];
            worst = i;
        }
    }
    for (int c = 0; c < N; c++) w[c] = real_div(inverse[worst][c], most);
    *lack = (ssv_lack_t){unit_or_zero(w), unit_or_zero(w + 3), true};
}

ssv_status_t ssv_alloc_init(const ssv_vehicle_t* vehicle, ssv_allocation_t* allocation, ssv_lack_t* lack) {
    real_t matrix[N][N], inverse[N][N];
    vec3_t push[N], turn[N];
    for (int i = 0; i < N; i++) {
        const vec3_t n = vehicle->thruster[i].n_T_S;
        const vec3_t m = vec3_cross(vehicle->thruster[i].p_ST_m, n);
        const real_t R = vehicle->radius_m;
        push[i] = n;
        turn[i] = vec3(real_div(m.x, R), real_div(m.y, R), real_div(m.z, R));
        const real_t column[N] = {n.x, n.y, n.z, turn[i].x, turn[i].y, turn[i].z};
        for (int r = 0; r < N; r++) matrix[r][i] = column[r];
    }
    const real_t norm = norm_inf(matrix);
    if (!invert(matrix, inverse) || real_mul(norm, norm_inf(inverse)) > SSV_CONDITION_MAX) {
        *lack = (ssv_lack_t){missing(push), missing(turn), false};
        if (!(vec3_norm(lack->push_S) + vec3_norm(lack->turn_S) > REAL(0))) find_coupled(inverse, lack);
        return SSV_E_SINGULAR;
    }
    for (int i = 0; i < N; i++) {
        for (int c = 0; c < N; c++) {
            allocation->u_per_wrench[i][c] = c < 3 ? inverse[i][c] : real_div(inverse[i][c], vehicle->radius_m);
        }
    }
    return SSV_OK;
}

void ssv_alloc(const ssv_allocation_t* allocation, vec3_t force, vec3_t moment, real_t u_N[SSV_NUM_THRUSTERS]) {
    for (int i = 0; i < N; i++) {
        const real_t* row = allocation->u_per_wrench[i];
        u_N[i] = real_mul(row[0], force.x) + real_mul(row[1], force.y) + real_mul(row[2], force.z) +
                 real_mul(row[3], moment.x) + real_mul(row[4], moment.y) + real_mul(row[5], moment.z);
    }
}
