// The live timeline tick by tick: impulse and moment against fine sums, nothing left out, events in their place.
#include <math.h>
#include <string.h>

#include "two_ends.h"
#include "unity.h"
#include "vehicle/execution.h"

#define TICK_S 0.005
#define TICK_NS INT64_C(5000000)
#define MOST_N 7.5F
#define ROOM_N 1.5F

static uint8_t file[SSV_TIMELINE_FILE_BYTES_MAX];
static ssv_timeline_t timeline;
static ssv_execution_t execution;

void setUp(void) { draw_seed(7); }
void tearDown(void) {}

static void begin(void) {
    const ssv_timeline_stamp_t stamp = {EPOCH_US, 600000};
    TEST_ASSERT_GREATER_THAN(0, ssv_timeline_encode(&timeline, &stamp, file, sizeof file));
    ssv_execution_begin(&execution, file);
}

// Segments of a nanosecond to 0.2 s, so that ticks hold parts of many.
static void draw(int num_segments) {
    timeline = draw_timeline(num_segments);
    for (int i = 0; i < num_segments; i++) {
        timeline.segment[i].duration_ns =
            1 + (int64_t)(draw_bits() % (draw_below(3) == 0 ? UINT64_C(3000000) : UINT64_C(200000000)));
    }
}

// Impulse up to the time t and its moment about 0, in double.
static void integrate(int thruster, double* impulse, double* moment) {
    double t = 0;
    *impulse = *moment = 0;
    for (int i = 0; i < timeline.num_segments; i++) {
        const ssv_timeline_segment_t* s = &timeline.segment[i];
        const double d = 1e-9 * (double)s->duration_ns, a = (double)s->u_start_N[thruster],
                     b = (double)s->u_end_N[thruster];
        *impulse += d * (a + b) / 2;
        *moment += d * ((a + b) / 2 * t + d * (a / 6 + b / 3));
        t += d;
    }
}

// Between stops ticks are contiguous: without events the sums over all ticks are those of the timeline.
static void test_the_ticks_have_the_impulse_and_the_moment_of_the_timeline(void) {
    for (int trial = 0; trial < 200; trial++) {
        double impulse_Ns[SSV_NUM_THRUSTERS] = {0}, moment_Ns2[SSV_NUM_THRUSTERS] = {0};
        int ticks = 0;
        float u_N[SSV_NUM_THRUSTERS];
        draw(1 + draw_below(SSV_MAX_SEGMENTS));
        timeline.num_events = 0;
        begin();
        // So much room that no correction is cut; four ticks more give what was put off.
        for (int more = 0; more < 4; ticks++) {
            ssv_execution_advance(&execution, TICK_NS, 1000, 500, u_N);
            if (ssv_execution_is_over(&execution)) more++;
            for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
                impulse_Ns[k] += TICK_S * (double)u_N[k];
                moment_Ns2[k] += TICK_S * (double)u_N[k] * (ticks + 0.5) * TICK_S;
            }
        }
        for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
            double impulse, moment;
            integrate(k, &impulse, &moment);
            // A binary32 of 6 N is good to 0.3 uN in each tick.
            TEST_ASSERT_DOUBLE_WITHIN(1e-6 * TICK_S * ticks, impulse, impulse_Ns[k]);
            TEST_ASSERT_DOUBLE_WITHIN(1e-6 * TICK_S * ticks * TICK_S * ticks, moment, moment_Ns2[k]);
        }
    }
}

static void test_without_room_a_tick_is_the_mean_of_the_timeline_over_it(void) {
    for (int trial = 0; trial < 50; trial++) {
        draw(1 + draw_below(40));
        timeline.num_events = 0;
        begin();
        int segment = 0;
        double into_s = 0; // of the fine sum, in the segment
        while (!ssv_execution_is_over(&execution)) {
            float u_N[SSV_NUM_THRUSTERS];
            double sum_N[SSV_NUM_THRUSTERS] = {0};
            ssv_execution_advance(&execution, TICK_NS, MOST_N, 0, u_N);
            // Trapezia between the bends, a tenth of a tick long at most.
            for (double left_s = TICK_S; left_s > 1e-13 && segment < timeline.num_segments;) {
                const ssv_timeline_segment_t* s = &timeline.segment[segment];
                const double duration_s = 1e-9 * (double)s->duration_ns;
                const double step_s = fmin(fmin(left_s, TICK_S / 10), duration_s - into_s);
                for (int k = 0; k < SSV_NUM_THRUSTERS; k++)
                    sum_N[k] += step_s / TICK_S *
                                ((double)s->u_start_N[k] + (into_s + step_s / 2) / duration_s *
                                                               ((double)s->u_end_N[k] - (double)s->u_start_N[k]));
                into_s += step_s;
                left_s -= step_s;
                if (into_s >= duration_s - 1e-13) {
                    segment++;
                    into_s = 0;
                }
            }
            for (int k = 0; k < SSV_NUM_THRUSTERS; k++) TEST_ASSERT_DOUBLE_WITHIN(4e-6, sum_N[k], (double)u_N[k]);
        }
    }
}

static void test_no_tick_asks_for_more_than_the_most(void) {
    for (int trial = 0; trial < 100; trial++) {
        draw(SSV_MAX_SEGMENTS);
        timeline.num_events = 0;
        begin();
        while (!ssv_execution_is_over(&execution)) {
            float u_N[SSV_NUM_THRUSTERS];
            ssv_execution_advance(&execution, TICK_NS, MOST_N, ROOM_N, u_N);
            for (int k = 0; k < SSV_NUM_THRUSTERS; k++) TEST_ASSERT_TRUE(fabsf(u_N[k]) <= MOST_N);
        }
    }
}

static void test_it_stands_before_each_event_until_it_is_passed(void) {
    for (int trial = 0; trial < 100; trial++) {
        draw(2 + draw_below(20));
        const int mate = draw_below(timeline.num_segments + 1);
        timeline.event[0].segment = mate;
        timeline.event[1].segment = mate + draw_below(timeline.num_segments - mate + 1);
        begin();
        for (int e = 0; e < 2; e++) {
            float u_N[SSV_NUM_THRUSTERS];
            int64_t before_ns = 0;
            for (int i = 0; i < timeline.event[e].segment; i++) before_ns += timeline.segment[i].duration_ns;
            for (int tick = 0; !ssv_execution_is_at_event(&execution); tick++) {
                TEST_ASSERT_LESS_THAN(10000, tick);
                TEST_ASSERT_FALSE(ssv_execution_is_over(&execution));
                ssv_execution_advance(&execution, TICK_NS, MOST_N, ROOM_N, u_N);
            }
            for (int tick = 0; tick < 10; tick++) ssv_execution_advance(&execution, TICK_NS, MOST_N, ROOM_N, u_N);
            for (int k = 0; k < SSV_NUM_THRUSTERS; k++) TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0, (double)u_N[k]);
            TEST_ASSERT_TRUE(ssv_execution_is_at_event(&execution));
            TEST_ASSERT_EQUAL_INT32(timeline.event[e].segment, execution.segment);
            TEST_ASSERT_EQUAL_INT64(before_ns, execution.plan_time_ns);
            TEST_ASSERT_EQUAL(timeline.event[e].kind, execution.event[execution.next_event].kind);
            ssv_execution_pass_event(&execution);
        }
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_the_ticks_have_the_impulse_and_the_moment_of_the_timeline);
    RUN_TEST(test_without_room_a_tick_is_the_mean_of_the_timeline_over_it);
    RUN_TEST(test_no_tick_asks_for_more_than_the_most);
    RUN_TEST(test_it_stands_before_each_event_until_it_is_passed);
    return UNITY_END();
}
