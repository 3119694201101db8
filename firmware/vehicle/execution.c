#include "vehicle/execution.h"

#define TICK_NS (1000 * SSV_VEHICLE_TICK_US)

void ssv_execution_begin(ssv_execution_t* execution, const uint8_t* file) {
    execution->file = file;
    execution->num_events = ssv_timeline_read_events(file, &execution->num_segments, execution->event);
    execution->segment = execution->next_event = 0;
    execution->in_segment_ns = execution->plan_time_ns = 0;
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) execution->put_off_N[k] = execution->moment_N[k] = 0;
}

bool ssv_execution_is_at_event(const ssv_execution_t* execution) {
    return execution->next_event < execution->num_events && execution->in_segment_ns == 0 &&
           execution->event[execution->next_event].segment == execution->segment;
}

void ssv_execution_pass_event(ssv_execution_t* execution) { execution->next_event++; }

bool ssv_execution_is_over(const ssv_execution_t* execution) {
    return execution->segment == execution->num_segments && execution->next_event == execution->num_events;
}

static float clip(float value, float most) { return value > most ? most : value < -most ? -most : value; }

// A stretch of a segment from `from_ns` on, which begins `since_ns` after the tick of `passing_ns` on the timeline's
// clock. Each thrust runs on a straight line, so its mean is its value in the middle; its moment about the middle of
// the stretch is a twelfth of its rise. What the clock is slower, thrusts are smaller.
static void pass(ssv_execution_t* execution, const ssv_timeline_segment_t* segment, int64_t from_ns, int64_t stretch_ns,
                 int64_t since_ns, int64_t passing_ns, float u_N[SSV_NUM_THRUSTERS]) {
    const float middle = (float)(2 * from_ns + stretch_ns) / (float)(2 * segment->duration_ns);
    const float part_of = (float)stretch_ns / (float)segment->duration_ns;
    const float part = (float)stretch_ns / (float)TICK_NS;
    const float late = (float)(2 * since_ns + stretch_ns - passing_ns) / (float)(2 * passing_ns);
    const float width = (float)stretch_ns / (float)passing_ns;
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
        const float rise_N = segment->u_end_N[k] - segment->u_start_N[k];
        const float mean_N = segment->u_start_N[k] + middle * rise_N;
        u_N[k] += part * mean_N;
        execution->moment_N[k] += part * (mean_N * late + part_of * rise_N * width / 12);
    }
}

void ssv_execution_advance(ssv_execution_t* execution, int64_t passing_ns, float most_N, float room_N,
                           float u_N[SSV_NUM_THRUSTERS]) {
    int64_t left_ns = passing_ns;
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) u_N[k] = execution->put_off_N[k];
    while (left_ns > 0 && execution->segment < execution->num_segments && !ssv_execution_is_at_event(execution)) {
        ssv_timeline_segment_t segment;
        ssv_timeline_read_segment(execution->file, execution->segment, &segment);
        const int64_t from_ns = execution->in_segment_ns, rest_ns = segment.duration_ns - from_ns;
        const int64_t stretch_ns = rest_ns < left_ns ? rest_ns : left_ns;
        pass(execution, &segment, from_ns, stretch_ns, passing_ns - left_ns, passing_ns, u_N);
        left_ns -= stretch_ns;
        execution->plan_time_ns += stretch_ns;
        execution->in_segment_ns += stretch_ns;
        if (stretch_ns == rest_ns) {
            execution->segment++;
            execution->in_segment_ns = 0;
        }
    }
    // Thrust that is put off by a tick acts a tick later: its moment is its size.
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
        const float now_N = clip(u_N[k] - clip(execution->moment_N[k], room_N), most_N);
        execution->put_off_N[k] = u_N[k] - now_N;
        execution->moment_N[k] = clip(execution->moment_N[k] - execution->put_off_N[k], most_N);
        u_N[k] = now_N;
    }
}
