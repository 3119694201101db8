// Where a plan's timeline ends if it is flown open loop. What the wrench of each line is beside what the motion asks
// for is followed through the flight: deviations of the velocity obey the linearised motion of the body, which needs
// no pose; those of the pose are their sum, carried along.
#include <string.h>

#include "planner/math/gauss.h"
#include "planner/model/body.h"
#include "planner/profile/profile.h"
#include "ssv/planner.h"
#include "ssv/vec3.h"

#define N 6
// Steps of a segment at least, and of a leg: what grows e-fold in one comes out a tenth too large.
#define STEPS_OF_SEGMENT 4
#define STEPS_OF_LEG 64
// How far the twist is varied for the slope of drag. Smaller, and float has no digits left.
#define VARIATION REAL(0.0078125)
// What deviates by more [m or rad, per second or not] is lost: how far does not matter. Larger, and fixed point
// overflows.
#define LOST REAL(1000)
// What is said to end farther from its goal than this does not arrive: three times what a replay judges by, 5 mm and
// 0.5 deg. Of a hundred of which that is said, one arrives (property.arrival).
#define MISS_M REAL(0.015)
#define MISS_RAD REAL(0.026)

enum { ROUNDING, LINES, NUM_CAUSES };

// What one cause has done so far, in axes of S.
typedef struct {
    vec3_t p, q; // of the pose: position, small turn
    real_t twist[N];
    bool lost;
} deviation_t;

static void put(const ssv_wrench_t* wrench, real_t scale, real_t column[N]) {
    column[0] = real_mul(scale, wrench->force.x);
    column[1] = real_mul(scale, wrench->force.y);
    column[2] = real_mul(scale, wrench->force.z);
    column[3] = real_mul(scale, wrench->moment.x);
    column[4] = real_mul(scale, wrench->moment.y);
    column[5] = real_mul(scale, wrench->moment.z);
}

static ssv_twist_t plus(ssv_twist_t a, real_t scale, ssv_twist_t b) {
    return (ssv_twist_t){vec3_add(a.v, vec3_scale(scale, b.v)), vec3_add(a.w, vec3_scale(scale, b.w))};
}

// The motion of an assembly along a twist, linearised: mass dw/dt = -(linear + speed quadratic) w + wrench, and the
// demands of the motion itself.
typedef struct {
    real_t mass[N][N], linear[N][N], quadratic[N][N];
    ssv_demand_t demand;
    ssv_twist_t twist;
} motion_t;

static void linearise(const ssv_assembly_t* assembly, ssv_twist_t twist, motion_t* motion) {
    const vec3_t zero = vec3(REAL(0), REAL(0), REAL(0));
    const real_t slope = real_div(REAL(0.5), VARIATION);
    motion->twist = twist;
    ssv_body_demand(assembly, twist, &motion->demand);
    for (int k = 0; k < N; k++) {
        const vec3_t e = vec3(real_from_int(k % 3 == 0), real_from_int(k % 3 == 1), real_from_int(k % 3 == 2));
        const ssv_twist_t unit = k < 3 ? (ssv_twist_t){e, zero} : (ssv_twist_t){zero, e};
        ssv_demand_t alone, more, less;
        ssv_body_demand(assembly, unit, &alone);
        ssv_body_demand(assembly, plus(twist, VARIATION, unit), &more);
        ssv_body_demand(assembly, plus(twist, -VARIATION, unit), &less);
        real_t mass[N], linear[N], up[N], down[N];
        put(&alone.accel, REAL(1), mass);
        put(&alone.linear, REAL(1), linear);
        put(&more.quadratic, slope, up);
        put(&less.quadratic, slope, down);
        for (int r = 0; r < N; r++) {
            motion->mass[r][k] = mass[r];
            motion->linear[r][k] = linear[r];
            motion->quadratic[r][k] = up[r] - down[r];
        }
    }
}

// Gauss-Jordan elimination with pivoting: what stands right of the first six columns becomes the solution.
static void solve(real_t m[N][3 * N]) {
    for (int c = 0; c < N; c++) {
        int pivot = c;
        for (int r = c + 1; r < N; r++) {
            if (real_abs(m[r][c]) > real_abs(m[pivot][c])) pivot = r;
        }
        const real_t by = m[pivot][c];
        for (int k = c; k < 3 * N; k++) {
            const real_t from = by == REAL(0) ? REAL(0) : real_div(m[pivot][k], by);
            m[pivot][k] = m[c][k];
            m[c][k] = from;
        }
        for (int r = 0; r < N; r++) {
            const real_t factor = m[r][c];
            if (r == c || factor == REAL(0)) continue;
            for (int k = c; k < 3 * N; k++) m[r][k] -= real_mul(factor, m[c][k]);
        }
    }
}

// What the lines of a segment give beyond what the motion asks for, as a quadratic over it: its mean, and what the
// second and third polynomial of Legendre are multiplied by.
typedef struct {
    real_t rounding[N];
    real_t part[3][N];
} excess_t;

// The same at one place of the segment.
static void excess_at(const ssv_vehicle_t* vehicle, const motion_t* motion, const ssv_arc_t* arc, real_t t,
                      const ssv_segment_t* segment, real_t at, real_t excess[N]) {
    const real_t v = ssv_arc_speed(arc, t + real_mul(at, segment->duration_s));
    real_t accel[N], linear[N], quadratic[N];
    put(&motion->demand.accel, ssv_quadratic_at(arc->dv_dt, v), accel);
    put(&motion->demand.linear, v, linear);
    put(&motion->demand.quadratic, real_sq(v), quadratic);
    for (int r = 0; r < N; r++) excess[r] = -accel[r] - linear[r] - quadratic[r];
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        const vec3_t n = vehicle->thruster[i].n_T_S;
        const ssv_wrench_t unit = {n, vec3_cross(vehicle->thruster[i].p_ST_m, n)};
        const real_t u = segment->u_start_N[i] + real_mul(at, segment->u_end_N[i] - segment->u_start_N[i]);
        real_t wrench[N];
        put(&unit, u, wrench);
        for (int r = 0; r < N; r++) excess[r] += wrench[r];
    }
}

// Lines are fitted by Gauss's rule with four points: by that rule their mean is off by rounding alone.
static void excess_of(const ssv_vehicle_t* vehicle, const motion_t* motion, const ssv_arc_t* arc, real_t t,
                      const ssv_segment_t* segment, excess_t* excess) {
    real_t at[N];
    memset(excess, 0, sizeof *excess);
    for (int k = 0; k < GAUSS_4_POINTS; k++) {
        excess_at(vehicle, motion, arc, t, segment, gauss_4[k].node, at);
        for (int r = 0; r < N; r++) excess->rounding[r] += real_mul(gauss_4[k].weight, at[r]);
    }
    for (int k = 0; k < GAUSS_8_POINTS; k++) {
        const real_t x = gauss_8[k].node, weight = real_mul(REAL(0.5), gauss_8[k].weight);
        const real_t second = real_mul(REAL(1.5), real_sq(x)) - REAL(0.5);
        excess_at(vehicle, motion, arc, t, segment, real_mul(REAL(0.5), REAL(1) + x), at);
        for (int r = 0; r < N; r++) {
            const real_t share = real_mul(weight, at[r]);
            excess->part[0][r] += share;
            excess->part[1][r] += real_mul(real_mul(REAL(3), x), share);
            excess->part[2][r] += real_mul(real_mul(REAL(5), second), share);
        }
    }
    for (int r = 0; r < N; r++) excess->part[0][r] -= excess->rounding[r];
}

static void step(real_t m[N][3 * N], const motion_t* motion, const real_t push[N], real_t h, real_t way,
                 deviation_t* d) {
    real_t to[N], mean[N];
    for (int r = 0; r < N; r++) {
        to[r] = REAL(0);
        for (int c = 0; c < N; c++) to[r] += real_mul(m[r][N + c], d->twist[c]) + real_mul(m[r][2 * N + c], push[c]);
        mean[r] = real_mul(REAL(0.5), d->twist[r] + to[r]);
        if (real_abs(to[r]) > LOST) d->lost = true;
    }
    const vec3_t v = vec3(mean[0], mean[1], mean[2]), w = vec3(mean[3], mean[4], mean[5]);
    const vec3_t carried = vec3_add(vec3_cross(motion->twist.w, d->p), vec3_cross(motion->twist.v, d->q));
    const vec3_t turned = vec3_cross(motion->twist.w, d->q);
    d->p = vec3_sub(vec3_add(d->p, vec3_scale(h, v)), vec3_scale(way, carried));
    d->q = vec3_sub(vec3_add(d->q, vec3_scale(h, w)), vec3_scale(way, turned));
    if (!(vec3_norm(d->p) < LOST) || !(vec3_norm(d->q) < LOST)) d->lost = true;
    for (int r = 0; r < N; r++) d->twist[r] = to[r];
}

// The body has this speed along its leg where the motion asks for that one.
static void jump(const motion_t* motion, real_t has, real_t asked, deviation_t* d) {
    const real_t twist[N] = {motion->twist.v.x, motion->twist.v.y, motion->twist.v.z,
                             motion->twist.w.x, motion->twist.w.y, motion->twist.w.z};
    for (int r = 0; r < N; r++) d->twist[r] += real_mul(has - asked, twist[r]);
}

static void fly_segment(const ssv_vehicle_t* vehicle, const motion_t* motion, const ssv_leg_t* leg,
                        const ssv_arc_t* arc, real_t t, const ssv_segment_t* segment,
                        deviation_t deviation[NUM_CAUSES]) {
    excess_t excess;
    real_t m[N][3 * N];
    excess_of(vehicle, motion, arc, t, segment, &excess);
    int num = STEPS_OF_SEGMENT;
    while (num < STEPS_OF_LEG &&
           real_mul(real_from_int(num), leg->duration_s) < real_mul(real_from_int(STEPS_OF_LEG), segment->duration_s))
        num += STEPS_OF_SEGMENT;
    const real_t h = real_div(segment->duration_s, real_from_int(num)), half = real_mul(REAL(0.5), h);
    const real_t speed = ssv_arc_speed(arc, t + real_mul(REAL(0.5), segment->duration_s));
    for (int r = 0; r < N; r++) {
        for (int c = 0; c < N; c++) {
            const real_t drag = real_mul(half, motion->linear[r][c] + real_mul(speed, motion->quadratic[r][c]));
            m[r][c] = motion->mass[r][c] + drag;
            m[r][N + c] = motion->mass[r][c] - drag;
            m[r][2 * N + c] = r == c ? h : REAL(0);
        }
    }
    solve(m);
    for (int n = 0; n < num; n++) {
        // Means of Legendre's polynomials over the step.
        const real_t a = real_div(real_from_int(2 * n), real_from_int(num)) - REAL(1),
                     b = real_div(real_from_int(2 * n + 2), real_from_int(num)) - REAL(1);
        const real_t first = real_mul(REAL(0.5), a + b);
        const real_t second = real_mul(REAL(0.5), real_sq(a) + real_mul(a, b) + real_sq(b) - REAL(1));
        real_t push[N];
        for (int r = 0; r < N; r++)
            push[r] = excess.part[0][r] + real_mul(first, excess.part[1][r]) + real_mul(second, excess.part[2][r]);
        if (!deviation[ROUNDING].lost) step(m, motion, excess.rounding, h, real_mul(speed, h), &deviation[ROUNDING]);
        if (!deviation[LINES].lost) step(m, motion, push, h, real_mul(speed, h), &deviation[LINES]);
    }
}

// At mate S arrives, at dock the beam's contact, which is at r in S.
static void worsen(const deviation_t* deviation, vec3_t r, ssv_miss_t* miss) {
    const vec3_t p = vec3_add(deviation->p, vec3_cross(deviation->q, r));
    miss->position_m = real_max(miss->position_m, deviation->lost ? LOST : vec3_norm(p));
    miss->angle_rad = real_max(miss->angle_rad, deviation->lost ? LOST : vec3_norm(deviation->q));
}

static void worsen_both(const deviation_t deviation[NUM_CAUSES], vec3_t r, ssv_arrival_t* arrival) {
    worsen(&deviation[ROUNDING], r, &arrival->rounding);
    worsen(&deviation[LINES], r, &arrival->lines);
}

static bool arrives(const ssv_miss_t* miss) { return miss->position_m <= MISS_M && miss->angle_rad <= MISS_RAD; }

// By the durations alone, as a timeline is flown. One arc does not quite lead to the start of the next, and a thrust
// that is taken off late makes too much speed. @return the first segment of the next leg.
static int fly_leg(const ssv_vehicle_t* vehicle, const ssv_plan_t* plan, int index, int next, const motion_t* motion,
                   deviation_t deviation[NUM_CAUSES]) {
    const ssv_leg_t* leg = &plan->leg[index];
    const ssv_arc_t *arc = &plan->arc[leg->first_arc], *last = arc + leg->num_arcs - 1;
    real_t t = REAL(0), rounded = REAL(0); // since the start of the arc, and what that sum has lost by rounding
    jump(motion, REAL(0), ssv_arc_speed_free(arc, t), &deviation[ROUNDING]);
    for (; next < plan->num_segments && plan->segment[next].leg == index; next++) {
        const ssv_segment_t* segment = &plan->segment[next];
        const real_t middle = segment->t_s - leg->t_start_s + real_mul(REAL(0.5), segment->duration_s);
        for (; arc < last && arc[1].t_s <= middle; arc++) {
            const real_t has = ssv_arc_speed_free(arc, t + rounded);
            t = t - arc->duration_s + rounded;
            rounded = REAL(0);
            jump(motion, has, ssv_arc_speed_free(arc + 1, t), &deviation[ROUNDING]);
        }
        fly_segment(vehicle, motion, leg, arc, real_max(REAL(0), t), segment, deviation);
        const real_t sum = t + segment->duration_s;
        rounded += t < segment->duration_s ? t - (sum - segment->duration_s) : segment->duration_s - (sum - t);
        t = sum;
    }
    jump(motion, ssv_arc_speed_free(arc, t + rounded), REAL(0), &deviation[ROUNDING]);
    return next;
}

bool ssv_plan_arrival(const ssv_problem_t* problem, const ssv_plan_t* plan, ssv_arrival_t* arrival) {
    const ssv_scenario_t* s = &problem->scenario;
    const vec3_t centre = vec3(REAL(0), REAL(0), REAL(0));
    const real_t end_m = real_mul(plan->quote.choice.contact == 1 ? REAL(-0.5) : REAL(0.5), s->beam.length_m);
    const vec3_t contact = vec3_add(plan->X_SB.p, quat_apply(plan->X_SB.q, vec3(REAL(0), REAL(0), end_m)));
    deviation_t deviation[NUM_CAUSES];
    memset(deviation, 0, sizeof deviation);
    memset(arrival, 0, sizeof *arrival);
    int next = 0;
    bool mated = false;
    for (int index = 0; index < plan->num_legs; index++) {
        const ssv_leg_t* leg = &plan->leg[index];
        if (!mated && leg->phase == SSV_TRANSFER) {
            worsen_both(deviation, centre, arrival);
            mated = true;
        }
        const ssv_assembly_t assembly = {&s->vehicle, mated ? &s->beam : NULL, plan->X_SB};
        motion_t motion;
        linearise(&assembly, (ssv_twist_t){leg->v_S, leg->w_S}, &motion);
        next = fly_leg(&s->vehicle, plan, index, next, &motion, deviation);
    }
    worsen_both(deviation, contact, arrival);
    return arrives(&arrival->rounding) || !arrives(&arrival->lines);
}
