// The plan at one instant: where the vehicle is, how it moves, and what its thrusters do.
#include "planner/model/body.h"
#include "planner/motion/maneuver.h"
#include "planner/profile/profile.h"
#include "ssv/planner.h"

static real_t clamp(real_t x, real_t low, real_t high) { return real_max(low, real_min(high, x)); }

static int leg_at(const ssv_plan_t* plan, real_t t_s) {
    int leg = 0;
    while (leg + 1 < plan->num_legs && plan->leg[leg + 1].t_start_s <= t_s) leg++;
    return leg;
}

static void sample_motion(const ssv_plan_t* plan, const ssv_leg_t* leg, real_t t_s, ssv_sample_t* sample) {
    const real_t t = clamp(t_s - leg->t_start_s, REAL(0), leg->duration_s);
    int k = leg->first_arc;
    while (k + 1 < leg->first_arc + leg->num_arcs && plan->arc[k + 1].t_s <= t) k++;
    const ssv_arc_t* arc = &plan->arc[k];
    const real_t t_arc = clamp(t - arc->t_s, REAL(0), arc->duration_s);
    const real_t v = ssv_arc_speed(arc, t_arc);
    const real_t s = arc->s + ssv_arc_moments(arc, arc->v_start, v, t_arc).distance;
    const ssv_twist_t twist = {leg->v_S, leg->w_S};
    sample->X_IS = ssv_maneuver_pose(leg->X_IS_start, twist, s);
    sample->v_IS_S_m_s = vec3_scale(v, leg->v_S);
    sample->w_IS_S_rad_s = vec3_scale(v, leg->w_S);
}

void ssv_plan_sample(const ssv_plan_t* plan, real_t t_s, ssv_sample_t* sample) {
    memset(sample, 0, sizeof *sample);
    sample->X_IS = plan->quote.X_IS_final;
    sample->mated = t_s >= plan->event[0].t_s;
    if (plan->num_legs == 0) return;
    sample->leg = leg_at(plan, t_s);
    if (t_s < REAL(0)) {
        sample->X_IS = plan->leg[0].X_IS_start;
        return;
    }
    if (t_s >= plan->quote.time_s) return;
    sample_motion(plan, &plan->leg[sample->leg], t_s, sample);
    int k = 0;
    while (k + 1 < plan->num_segments && plan->segment[k + 1].t_s <= t_s) k++;
    const ssv_segment_t* segment = &plan->segment[k];
    const real_t along = clamp(real_div(t_s - segment->t_s, segment->duration_s), REAL(0), REAL(1));
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        sample->u_N[i] = segment->u_start_N[i] + real_mul(along, segment->u_end_N[i] - segment->u_start_N[i]);
    }
}
