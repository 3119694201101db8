// The plan's timeline in the vehicle's form (ssv/timeline.h).
#include "ssv/planner.h"

static void add_segment(const ssv_segment_t* from, int64_t duration_ns, ssv_timeline_t* timeline) {
    ssv_timeline_segment_t* to = &timeline->segment[timeline->num_segments++];
    to->duration_ns = duration_ns;
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        to->u_start_N[i] = real_to_float(from->u_start_N[i]);
        to->u_end_N[i] = real_to_float(from->u_end_N[i]);
    }
}

static void add_event(ssv_event_kind_t kind, ssv_timeline_t* timeline) {
    timeline->event[timeline->num_events++] = (ssv_timeline_event_t){timeline->num_segments, kind};
}

static real_t largest_thrust(const ssv_plan_t* plan) {
    real_t most_N = REAL(0);
    for (const ssv_segment_t* segment = plan->segment; segment < plan->segment + plan->num_segments; segment++) {
        for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
            most_N = real_max(most_N, real_max(real_abs(segment->u_start_N[i]), real_abs(segment->u_end_N[i])));
        }
    }
    return most_N;
}

// Of the plan's events the kinds and the order count, not the times: mating is where the legs with the beam begin.
static bool happens_before(ssv_event_kind_t kind, const ssv_plan_t* plan, const ssv_segment_t* segment) {
    return kind == SSV_MATE && plan->leg[segment->leg].phase == SSV_TRANSFER;
}

void ssv_timeline_of_plan(const ssv_plan_t* plan, ssv_timeline_t* timeline) {
    memset(timeline, 0, sizeof *timeline);
    const pose_t X_IS = plan->num_legs > 0 ? plan->leg[0].X_IS_start : plan->X_IS_final;
    const real_t p_m[3] = {X_IS.p.x, X_IS.p.y, X_IS.p.z}, q[4] = {X_IS.q.w, X_IS.q.x, X_IS.q.y, X_IS.q.z};
    for (int i = 0; i < 3; i++) timeline->p_IS_m[i] = real_to_float(p_m[i]);
    for (int i = 0; i < 4; i++) timeline->q_IS[i] = real_to_float(q[i]);
    timeline->plan_hash = plan->plan_hash;
    timeline->u_max_N = real_to_float(largest_thrust(plan));
    const int64_t end_ns = real_to_nano(plan->quote.time_s);
    int64_t start_ns = 0;
    for (int k = 0; k < plan->num_segments; k++) {
        const ssv_segment_t* segment = &plan->segment[k];
        while (timeline->num_events < plan->num_events &&
               happens_before(plan->event[timeline->num_events].kind, plan, segment)) {
            add_event(plan->event[timeline->num_events].kind, timeline);
        }
        // In float a time has 24 bits: two starts may be one, or the sum of the legs a digit behind the last start.
        int64_t next_ns = k + 1 < plan->num_segments ? real_to_nano(plan->segment[k + 1].t_s) : end_ns;
        if (next_ns > end_ns) next_ns = end_ns;
        if (next_ns <= start_ns) continue;
        add_segment(segment, next_ns - start_ns, timeline);
        start_ns = next_ns;
    }
    while (timeline->num_events < plan->num_events) add_event(plan->event[timeline->num_events].kind, timeline);
}
