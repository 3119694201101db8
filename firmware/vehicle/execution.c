#include "vehicle/execution.h"

#define TICK_NS (1000 * SSV_VEHICLE_TICK_US)

void ssv_execution_begin(ssv_execution_t* execution, const uint8_t* file) {
    execution->file = file;
    execution->num_events = ssv_timeline_read_events(file, &execution->num_segments, execution->event);
    execution->segment = execution->next_event = 0;
    execution->in_segment_ns = execution->plan_time_ns = 0;
}

bool ssv_execution_is_at_event(const ssv_execution_t* execution) {
    return execution->next_event < execution->num_events && execution->in_segment_ns == 0 &&
           execution->event[execution->next_event].segment == execution->segment;
}

void ssv_execution_pass_event(ssv_execution_t* execution) { execution->next_event++; }

bool ssv_execution_is_over(const ssv_execution_t* execution) {
    return execution->segment == execution->num_segments && execution->next_event == execution->num_events;
}

// A thrust runs on a straight line, so its mean over a stretch is its value in the middle.
void ssv_execution_advance(ssv_execution_t* execution, float mean_N[SSV_NUM_THRUSTERS]) {
    int64_t left_ns = TICK_NS;
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) mean_N[k] = 0;
    while (left_ns > 0 && execution->segment < execution->num_segments && !ssv_execution_is_at_event(execution)) {
        ssv_timeline_segment_t segment;
        ssv_timeline_read_segment(execution->file, execution->segment, &segment);
        const int64_t from_ns = execution->in_segment_ns, rest_ns = segment.duration_ns - from_ns;
        const int64_t stretch_ns = rest_ns < left_ns ? rest_ns : left_ns;
        const float middle = (float)(2 * from_ns + stretch_ns) / (float)(2 * segment.duration_ns);
        const float share = (float)stretch_ns / (float)TICK_NS;
        for (int k = 0; k < SSV_NUM_THRUSTERS; k++)
            mean_N[k] += share * (segment.u_start_N[k] + middle * (segment.u_end_N[k] - segment.u_start_N[k]));
        left_ns -= stretch_ns;
        execution->plan_time_ns += stretch_ns;
        execution->in_segment_ns += stretch_ns;
        if (stretch_ns == rest_ns) {
            execution->segment++;
            execution->in_segment_ns = 0;
        }
    }
}
