// The plan's timeline in the vehicle's form (ssv/timeline.h).
#include "ssv/planner.h"

void ssv_timeline_of_plan(const ssv_plan_t* plan, ssv_timeline_t* timeline) {
    memset(timeline, 0, sizeof *timeline);
    timeline->plan_hash = plan->plan_hash;
    const pose_t* X_IS = plan->num_legs > 0 ? &plan->leg[0].X_IS_start : &plan->quote.X_IS_final;
    timeline->p_IS_m[0] = real_to_float(X_IS->p.x);
    timeline->p_IS_m[1] = real_to_float(X_IS->p.y);
    timeline->p_IS_m[2] = real_to_float(X_IS->p.z);
    timeline->q_IS[0] = real_to_float(X_IS->q.w);
    timeline->q_IS[1] = real_to_float(X_IS->q.x);
    timeline->q_IS[2] = real_to_float(X_IS->q.y);
    timeline->q_IS[3] = real_to_float(X_IS->q.z);
    const int64_t end_ns = real_to_nano(plan->quote.time_s);
    int64_t start_ns = 0;
    real_t most_N = REAL(0);
    int num = 0, num_alone = 0; // segments, and those of them that are flown without the beam
    for (int k = 0; k < plan->num_segments; k++) {
        const ssv_segment_t* from = &plan->segment[k];
        // In float a time has 24 bits: two starts may be one, or the sum of the legs a digit behind the last start.
        int64_t next_ns = k + 1 < plan->num_segments ? real_to_nano(from[1].t_s) : end_ns;
        if (next_ns > end_ns) next_ns = end_ns;
        if (next_ns <= start_ns) continue;
        ssv_timeline_segment_t* to = &timeline->segment[num++];
        to->duration_ns = next_ns - start_ns;
        for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
            const real_t u_start_N = from->u_start_N[i], u_end_N = from->u_end_N[i];
            to->u_start_N[i] = real_to_float(u_start_N);
            to->u_end_N[i] = real_to_float(u_end_N);
            most_N = real_max(most_N, real_max(real_abs(u_start_N), real_abs(u_end_N)));
        }
        if (plan->leg[from->leg].phase == SSV_TRANSIT) num_alone = num;
        start_ns = next_ns;
    }
    timeline->num_segments = num;
    timeline->u_max_N = real_to_float(most_N);
    timeline->num_events = plan->num_events;
    for (int k = 0; k < plan->num_events; k++) {
        const ssv_event_kind_t kind = plan->event[k].kind;
        timeline->event[k] = (ssv_timeline_event_t){kind == SSV_MATE ? num_alone : num, kind};
    }
}
