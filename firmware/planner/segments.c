// Fits straight lines to the thrusts of an arc, each as long as its error allows.
#include "planner/segments.h"

#include <stdbool.h>

#include "planner/math/assert.h"
#include "planner/math/gauss.h"
#include "planner/profile/arc.h"
#include "planner/profile/profile.h"
#include "ssv/scenario.h"

#define N SSV_NUM_THRUSTERS
// Errors are looked at where Gauss's rule looks and at both ends.
#define NUM_CHECKS (GAUSS_4_POINTS + 2)
// Between these places an error may be a tenth larger, so this much is allowed at them. Larger: the timeline leaves
// SSV_TIMELINE_TOLERANCE. Smaller: more segments.
#define CHECKED_TOLERANCE (9 * (SSV_TIMELINE_TOLERANCE / 10))
// Errors beyond this are too large in any case. Larger: what they drift in the longest plan overflows fixed point.
#define ERROR_MAX REAL(0.1)
// Lengths aim at this share of the error that is allowed. Larger: more of them fail their check and are fitted twice.
// Smaller: more segments.
#define AIMED_SHARE REAL(0.9)
// A length that fails shrinks a little more than the error asks for, but to no less than a tenth at once. Other values
// take more trials; after the last of them the timeline is given up.
#define SHRINK_FURTHER REAL(0.95)
#define SHRINK_MIN REAL(0.1)
#define MAX_LENGTH_TRIALS 24

// The straight line with the impulse and the first moment of a thrust, so that neither speed nor distance is lost.
// Where it would leave the thruster's limits it is turned flatter.
static void fit(const real_t u[NUM_CHECKS], real_t limit, real_t* u_start, real_t* u_end) {
    // The sums are of differences to the thrust at the start: a constant thrust is then met to the last bit.
    const real_t start = u[GAUSS_4_POINTS];
    real_t mean = start, lean = REAL(0);
    for (int k = 0; k < GAUSS_4_POINTS; k++) {
        const real_t share = real_mul(gauss_4[k].weight, u[k] - start);
        mean += share;
        lean += real_mul(gauss_4[k].node - REAL(0.5), share);
    }
    mean = real_max(-limit, real_min(limit, mean));
    const real_t room = limit - real_abs(mean), swing = real_max(-room, real_min(room, real_mul(REAL(6), lean)));
    *u_start = mean - swing;
    *u_end = mean + swing;
}

// An arc and the thrusts on it.
typedef struct {
    const ssv_arc_t* arc;
    real_t thrust[N][3]; // as quadratics in v
    real_t force_max_N;
    int unit; // their derivatives are per 2^unit s, which is shorter where the arc is short
} track_t;

static track_t track_of(const ssv_thrusts_t* thrusts, const ssv_arc_t* arc) {
    const int unit = real_exponent(arc->duration_s);
    track_t track = {.arc = arc, .force_max_N = thrusts->force_max_N, .unit = unit < 0 ? unit : 0};
    for (int i = 0; i < N; i++) ssv_arc_thrust(thrusts, arc, i, track.thrust[i]);
    return track;
}

static bool is_constant(const real_t c[3]) { return c[1] == REAL(0) && c[2] == REAL(0); }

// The greatest length, up to h, whose lines err no more than allowed if the thrusts bent everywhere as they do at time
// t. The error of a line is a twelfth of the second derivative times the square of the length.
static real_t length_at(const track_t* track, real_t t, real_t h, real_t drift_max_s2) {
    const real_t* dv_dt = track->arc->dv_dt;
    const real_t v = ssv_arc_speed(track->arc, t);
    const real_t slope = real_scale(dv_dt[1] + real_mul(REAL(2), real_mul(dv_dt[2], v)), track->unit);
    const real_t accel = real_scale(ssv_quadratic_at(dv_dt, v), track->unit), jerk = real_mul(accel, slope);
    const real_t squared = real_mul(REAL(2), real_sq(accel) + real_mul(v, jerk));
    real_t most = REAL(0);
    for (int i = 0; i < N; i++) {
        const real_t* c = track->thrust[i];
        if (!is_constant(c)) most = real_max(most, real_abs(real_mul(c[1], jerk) + real_mul(c[2], squared)));
    }
    const real_t bend = real_div(most, real_mul(REAL(12), track->force_max_N));
    if (!(bend > REAL(0))) return h;
    const real_t units =
        real_min(real_scale(h, -track->unit), real_sqrt(real_div(real_mul(AIMED_SHARE, CHECKED_TOLERANCE), bend)));
    h = real_scale(units, track->unit);
    const real_t drift = real_mul(real_mul(bend, real_sq(units)), real_sq(h)),
                 most_drift = real_mul(AIMED_SHARE, drift_max_s2);
    return drift > most_drift ? real_mul(h, real_sqrt(real_sqrt(real_div(most_drift, drift)))) : h;
}

// About how long the next segment may be: judged at its start, then at the middle of what that allows.
static real_t next_length(const track_t* track, real_t t, real_t drift_max_s2) {
    const real_t left = track->arc->duration_s - t, h = length_at(track, t, left, drift_max_s2);
    return length_at(track, t + real_mul(REAL(0.5), h), left, drift_max_s2);
}

int ssv_timeline_count(const ssv_thrusts_t* thrusts, const ssv_arc_t* arc, real_t drift_max_s2) {
    const track_t track = track_of(thrusts, arc);
    int num = 0;
    real_t t = REAL(0);
    for (; num < SSV_MAX_SEGMENTS && t < arc->duration_s; num++) t += next_length(&track, t, drift_max_s2);
    return num;
}

// Fills the segment's thrusts for the arc from t to t + h; returns the largest error over force_max.
static real_t fit_all(const track_t* track, real_t t, real_t h, ssv_segment_t* segment) {
    real_t at[NUM_CHECKS], v[NUM_CHECKS], worst = REAL(0);
    for (int k = 0; k < NUM_CHECKS; k++) {
        at[k] = k < GAUSS_4_POINTS ? gauss_4[k].node : real_from_int(k - GAUSS_4_POINTS);
        v[k] = ssv_arc_speed(track->arc, t + real_mul(h, at[k]));
    }
    for (int i = 0; i < N; i++) {
        const real_t* c = track->thrust[i];
        if (is_constant(c)) {
            segment->u_start_N[i] = segment->u_end_N[i] =
                real_max(-track->force_max_N, real_min(track->force_max_N, c[0]));
            continue;
        }
        real_t u[NUM_CHECKS];
        for (int k = 0; k < NUM_CHECKS; k++) u[k] = ssv_quadratic_at(c, v[k]);
        fit(u, track->force_max_N, &segment->u_start_N[i], &segment->u_end_N[i]);
        const real_t rise = segment->u_end_N[i] - segment->u_start_N[i];
        for (int k = 0; k < NUM_CHECKS; k++) {
            worst = real_max(worst, real_abs(u[k] - segment->u_start_N[i] - real_mul(at[k], rise)));
        }
    }
    return real_div(worst, track->force_max_N);
}

ssv_outcome_t ssv_timeline_append(const ssv_thrusts_t* thrusts, const ssv_arc_t* arc, real_t t_s, int leg,
                                  real_t drift_max_s2, ssv_plan_t* plan) {
    SSV_ASSERT(plan->num_segments >= 0 && plan->num_segments <= SSV_MAX_SEGMENTS && leg >= 0 && leg < SSV_MAX_LEGS);
    const track_t track = track_of(thrusts, arc);
    real_t t = REAL(0);
    while (t < arc->duration_s) {
        if (plan->num_segments == SSV_MAX_SEGMENTS) return SSV_TOO_MANY_SEGMENTS;
        ssv_segment_t* segment = &plan->segment[plan->num_segments++];
        const real_t left = arc->duration_s - t;
        real_t h = next_length(&track, t, drift_max_s2);
        bool fits = false;
        for (int n = 0; n < MAX_LENGTH_TRIALS; n++) {
            const real_t error = fit_all(&track, t, h, segment);
            const real_t drift = real_mul(real_mul(real_min(error, ERROR_MAX), h), h);
            fits = error <= CHECKED_TOLERANCE && drift <= drift_max_s2;
            if (fits) break;
            // The error of a line grows with the square of its length, the drift with the fourth power.
            const real_t shrink = real_sqrt(real_min(real_div(CHECKED_TOLERANCE, real_max(CHECKED_TOLERANCE, error)),
                                                     real_sqrt(real_div(drift_max_s2, real_max(drift_max_s2, drift)))));
            h = real_mul(h, real_max(SHRINK_MIN, real_mul(SHRINK_FURTHER, shrink)));
        }
        if (!fits) return SSV_TOO_MANY_SEGMENTS;
        segment->t_s = t_s + t;
        segment->duration_s = h;
        segment->leg = leg;
        t = h < left ? t + h : arc->duration_s;
    }
    return SSV_FEASIBLE;
}
