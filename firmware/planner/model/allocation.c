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

// Gauss-Jordan with row pivoting.
static bool invert(real_t m[N][N], real_t inverse[N][N]) {
    for (int r = 0; r < N; r++) {
        for (int c = 0; c < N; c++) inverse[r][c] = r == c ? REAL(1) : REAL(0);
    }
    for (int c = 0; c < N; c++) {
        int pivot = c;
        for (int r = c + 1; r < N; r++) {
            if (real_abs(m[r][c]) > real_abs(m[pivot][c])) pivot = r;
        }
        if (real_abs(m[pivot][c]) < PIVOT_MIN) return false;
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
    return true;
}

ssv_status_t ssv_alloc_init(const ssv_vehicle_t* vehicle, ssv_allocation_t* allocation) {
    real_t matrix[N][N], inverse[N][N];
    for (int i = 0; i < N; i++) {
        const vec3_t n = vehicle->thruster[i].n_T_S;
        const vec3_t m = vec3_cross(vehicle->thruster[i].p_ST_m, n);
        const real_t column[N] = {n.x,
                                  n.y,
                                  n.z,
                                  real_div(m.x, vehicle->radius_m),
                                  real_div(m.y, vehicle->radius_m),
                                  real_div(m.z, vehicle->radius_m)};
        for (int r = 0; r < N; r++) matrix[r][i] = column[r];
    }
    const real_t norm = norm_inf(matrix);
    if (!invert(matrix, inverse) || real_mul(norm, norm_inf(inverse)) > SSV_CONDITION_MAX) return SSV_E_SINGULAR;
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
