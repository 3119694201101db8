#include "planner/search/bound.h"

#include "planner/model/grasp.h"
#include "planner/motion/tolerance.h"
#include "planner/search/budget.h"
#include "planner/search/tolerance.h"
#include "ssv/planner.h"
#include "ssv/vec3.h"

// Least cost of a metre for the vehicle's centre. For any vector y of length Y, a motion from rest to rest costs at
// least y . (drag_lin dx) if no attitude lets the thrusters win more from y than a second costs:
//     sum of F max(0, Y |n . n_i| - W2) <= W1 for every unit n.
// The |n . n_i| have squares that sum to at most the largest eigenvalue of sum n_i n_i^T, so the left side is largest
// with m of them equal and the rest zero, for some m.
real_t ssv_least_metre_price(const ssv_question_t* question) {
    const ssv_scenario_t* s = &question->problem->scenario;
    real_t m[3][3] = {{REAL(0)}}, eigenvalue = REAL(0);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        const vec3_t v = s->vehicle.thruster[i].n_T_S;
        const real_t n[3] = {v.x, v.y, v.z};
        for (int r = 0; r < 3; r++) {
            for (int c = 0; c < 3; c++) m[r][c] += real_mul(n[r], n[c]);
        }
    }
    for (int r = 0; r < 3; r++) {
        // Gershgorin: no eigenvalue is larger than the largest sum of a row.
        eigenvalue = real_max(eigenvalue, real_abs(m[r][0]) + real_abs(m[r][1]) + real_abs(m[r][2]));
    }
    real_t least = REAL(0);
    for (int k = 1; k <= SSV_NUM_THRUSTERS; k++) {
        // No |n . n_i| is above 1.
        const real_t spread = real_sqrt(real_max(REAL(1), real_div(real_from_int(k), eigenvalue)));
        const real_t share = real_div(question->weight_time_per_s, real_mul(real_from_int(k), s->vehicle.force_max_N));
        const real_t y = real_mul(spread, share + question->weight_impulse_per_Ns);
        if (k == 1 || y < least) least = y;
    }
    return real_mul(least, s->vehicle.body.drag_lin_kg_s);
}

// Forces that the balance leaves out could help a pair along: a beam that is turned about a pivot rows.
static bool can_row(const ssv_scenario_t* s) {
    return s->beam.drag_strip_kg_m2 > REAL(0) || s->beam.body.drag_lin_kg_s > REAL(0) ||
           s->beam.body.drag_quad_kg_m > REAL(0) || s->vehicle.body.drag_quad_kg_m > REAL(0);
}

// How much farther or nearer the vehicle must go for a metre of height: the ring, where the transfer starts and where
// it ends each move by as much as the height.
#define METRES_PER_HEIGHT REAL(3)

// What the geometry of a plan may leave undone, and what rounding makes of where things are [m]: a flight that is no
// longer may be none.
static real_t negligible_m(const ssv_scenario_t* s) {
    const real_t size_m = vec3_norm(s->X_IS.p) + vec3_norm(s->X_IB.p) + vec3_norm(s->p_IP_m);
    return real_mul(SSV_LEFT_OUT, SSV_LENGTH_MIN) + real_mul(16 * REAL_NOISE, size_m);
}

real_t ssv_least_price(const ssv_question_t* question) {
    const ssv_scenario_t* s = &question->problem->scenario;
    const uint32_t overflows = real_overflows();
    const vec3_t p_BS = pose_between(s->X_IB, s->X_IS).p;
    const real_t off_ring = vec3_norm(vec3(p_BS.x, p_BS.y, REAL(0))) - s->standoff_m;
    const vec3_t axis_B = quat_apply(s->X_IB.q, vec3(REAL(0), REAL(0), REAL(1)));
    const bool anywhere = s->attach_anywhere && question->method == SSV_METHOD_OPTIMAL;
    const int num = anywhere ? SSV_NUM_BOUND_STEPS + 1 : s->num_attach_heights;
    const real_t step = real_div(s->beam.length_m, REAL(SSV_NUM_BOUND_STEPS));
    const real_t slack_m = negligible_m(s);
    real_t least = REAL(0);
    bool first = true;
    for (int contact = 1; contact <= SSV_NUM_CONTACTS; contact++) {
        if (s->contact != 0 && s->contact != contact) continue;
        const real_t end = ssv_grasp_contact(s, contact).z;
        for (int k = 0; k < num; k++) {
            const real_t height =
                anywhere ? real_mul(step, real_from_int(k - SSV_NUM_BOUND_STEPS / 2)) : s->attach_heights_m[k];
            // The vehicle mates on a ring about the beam and ends on the same ring about the docked beam, outward axis
            // against the port's.
            real_t length_m = vec3_norm(vec3(off_ring, REAL(0), p_BS.z - height));
            if (!can_row(s)) {
                const vec3_t from = vec3_add(s->X_IB.p, vec3_scale(height, axis_B));
                const vec3_t to = vec3_add(s->p_IP_m, vec3_scale(real_abs(end - height), s->axis_I));
                length_m += real_max(REAL(0), vec3_norm(vec3_sub(to, from)) - real_mul(REAL(2), s->standoff_m));
            }
            if (anywhere)
                length_m = real_max(REAL(0), length_m - real_mul(METRES_PER_HEIGHT, real_mul(REAL(0.5), step)));
            if (length_m < slack_m) length_m = REAL(0);
            if (first || length_m < least) least = length_m;
            first = false;
        }
    }
    const real_t bound = real_mul(ssv_least_metre_price(question), least);
    return real_overflows() == overflows && real_is_finite(bound) ? bound : REAL(0);
}

real_t ssv_lower_bound(const ssv_problem_t* problem) {
    const ssv_question_t question = ssv_question_of(problem);
    return ssv_least_price(&question);
}
