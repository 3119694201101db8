// When the replay knows its figures well enough, and when it says that it does not: on flights that are exact without
// any solver, since speed runs on straight lines in time, against linear drag.
#include <math.h>
#include <string.h>
#include <time.h>

#include "replay/replay.h"
#include "unity.h"

#define NUM_SEGMENTS 4
#define LEVER_M 0.3
#define STANDOFF_M 0.36
#define TRANSIT_M 2.0

static plan_segment_t segment[NUM_SEGMENTS];
static plan_file_t plan;
static replay_flight_t flight;
static const double direction[3] = {0.8, 0.36, 0.48};

void setUp(void) { memset(&plan, 0, sizeof plan); }
void tearDown(void) {}

/// Thrusts that give a force along the direction, and its moment about a point ahead, each so many newtons.
static void push(double force_N, double ahead_N, double u_N[PLAN_THRUSTERS]) {
    const double ahead[3] = {STANDOFF_M, 0, 0};
    double moment[3], wanted[3];
    for (int i = 0; i < 3; i++) {
        wanted[i] = ahead_N * direction[i];
    }
    rb_cross(ahead, wanted, moment);
    // Pairs along x, y, z turn about y, z, x.
    for (int i = 0; i < 3; i++) {
        const double turns_N = moment[(i + 1) % 3] / LEVER_M;
        u_N[2 * i] = (turns_N + force_N * direction[i]) / 2;
        u_N[2 * i + 1] = (turns_N - force_N * direction[i]) / 2;
    }
}

/// Two segments that carry what moves a length along the direction: speed rises and falls.
static void carry(plan_segment_t at[2], const rb_body_t* beam, double length_m, double time_s) {
    const double half_s = time_s / 2, rate = length_m / (half_s * half_s);
    for (int k = 0; k < 2; k++) {
        const double sign = k == 0 ? 1 : -1, from_m_s = k == 0 ? 0 : rate * half_s, to_m_s = k == 0 ? rate * half_s : 0;
        const double mass_N = sign * rate * (plan.vehicle.mass_kg + (beam ? beam->mass_kg : 0));
        const double drag_kg_s = plan.vehicle.drag_lin_kg_s + (beam ? beam->drag_lin_kg_s : 0);
        const double beam_N = beam ? sign * rate * beam->mass_kg : 0, beam_kg_s = beam ? beam->drag_lin_kg_s : 0;
        at[k].duration_s = half_s;
        push(mass_N + drag_kg_s * from_m_s, beam_N + beam_kg_s * from_m_s, at[k].u_start_N);
        push(mass_N + drag_kg_s * to_m_s, beam_N + beam_kg_s * to_m_s, at[k].u_end_N);
    }
}

/// The vehicle goes to a beam that stands upright and carries it on, both along the direction.
static void plan_flight(double mass_kg, double beam_mass_kg, double transfer_m, double transfer_s) {
    static const double axis[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    plan.vehicle = (rb_body_t){.mass_kg = mass_kg, .inertia_kg_m2 = {2.7, 2.7, 2.7}, .drag_lin_kg_s = 40};
    plan.beam = (rb_body_t){.mass_kg = beam_mass_kg, .inertia_kg_m2 = {3, 3, 0.04}};
    plan.beam.length_m = 3;
    plan.force_max_N = 100;
    plan.X_IS.q[0] = plan.X_IB.q[0] = 1;
    plan.standoff_m = STANDOFF_M;
    plan.ring_angle_rad = 3.14159265358979323846;
    plan.contact = 2;
    plan.axis_I[2] = -1;
    for (int t = 0; t < PLAN_THRUSTERS; t++) {
        for (int i = 0; i < 3; i++) {
            plan.thruster[t].n[i] = (t % 2 == 0 ? 1 : -1) * axis[t / 2][i];
            plan.thruster[t].r_m[i] = (t % 2 == 0 ? LEVER_M : -LEVER_M) * axis[(t / 2 + 2) % 3][i];
        }
    }
    for (int i = 0; i < 3; i++) {
        plan.X_IB.p_m[i] = TRANSIT_M * direction[i] + STANDOFF_M * (i == 0);
        plan.p_IP_m[i] = plan.X_IB.p_m[i] + transfer_m * direction[i] + plan.beam.length_m / 2 * (i == 2);
    }
    carry(segment, NULL, TRANSIT_M, 40);
    carry(segment + 2, &plan.beam, transfer_m, transfer_s);
    plan.segment = segment;
    plan.num_segments = NUM_SEGMENTS;
    plan.num_transit_segments = 2;
}

static void test_a_flight_that_holds_its_way_arrives_exactly(void) {
    plan_flight(76, 11, 3, 60);
    TEST_ASSERT_EQUAL_INT(REPLAY_JUDGED, replay_fly(&plan, NULL, &flight));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0, flight.mate.position_mm);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0, flight.dock.position_mm);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0, flight.dock.pointing_deg);
    TEST_ASSERT_DOUBLE_WITHIN(1e-10, 0, flight.dock.speed_m_s);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 100, flight.time_s);
}

static void test_a_flight_whose_time_constants_are_too_short_is_given_up_early(void) {
    plan_flight(1e-5, 11, 3, 60); // 0.25 us
    const clock_t start = clock();
    TEST_ASSERT_EQUAL_INT(REPLAY_TOO_LONG, replay_fly(&plan, NULL, &flight));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 100, flight.time_s);
    TEST_ASSERT_TRUE((double)(clock() - start) / CLOCKS_PER_SEC < 20);
    plan_flight(1e-2, 11, 3, 60); // a thousand times as long: known, and no number is lost on the way
    TEST_ASSERT_EQUAL_INT(REPLAY_JUDGED, replay_fly(&plan, NULL, &flight));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0, flight.dock.position_mm);
}

typedef struct {
    int words, run;
    double share;
} heard_t;

static void hear(void* context, int run, double share) {
    heard_t* heard = context;
    TEST_ASSERT_TRUE(run == heard->run || run == heard->run + 1);
    TEST_ASSERT_TRUE(run > heard->run || share >= heard->share);
    TEST_ASSERT_TRUE(share >= 0 && share <= 1);
    *heard = (heard_t){heard->words + 1, run, share};
}

static void test_a_long_flight_tells_how_far_it_is(void) {
    heard_t heard = {0, 0, 0};
    const replay_listener_t listener = {hear, &heard};
    plan_flight(1e-2, 11, 3, 60);
    TEST_ASSERT_EQUAL_INT(REPLAY_JUDGED, replay_fly(&plan, &listener, &flight));
    TEST_ASSERT_GREATER_THAN_INT(5, heard.words);
    TEST_ASSERT_GREATER_THAN_INT(0, heard.run);
}

static void test_what_is_off_shows_and_what_cancels_does_not(void) {
    // All forces and all that they work against larger by the same: the same flight.
    const replay_off_t all = {1.05, 1.05, {1.05, 1.05, 1.05, 1.05, 1.05, 1.05}};
    plan_flight(76, 11, 3, 60);
    replay_put_off(&all, &plan);
    TEST_ASSERT_EQUAL_INT(REPLAY_JUDGED, replay_fly(&plan, NULL, &flight));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0, flight.dock.position_mm);
    // Weaker thrusters alone: motion is linear in them, so the mate is as much too short.
    const replay_off_t weak = {1, 1, {0.99, 0.99, 0.99, 0.99, 0.99, 0.99}};
    plan_flight(76, 11, 3, 60);
    replay_put_off(&weak, &plan);
    TEST_ASSERT_EQUAL_INT(REPLAY_JUDGED, replay_fly(&plan, NULL, &flight));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1000 * 0.01 * TRANSIT_M, flight.mate.position_mm);
    TEST_ASSERT_TRUE(flight.thrust_ratio < 1); // that of the plan
    // Against more drag than mass the way ends where the impulse is used up: m v + c x = integral of F.
    const replay_off_t drag = {1, 1.25, {1, 1, 1, 1, 1, 1}};
    plan_flight(76, 11, 3, 60);
    replay_put_off(&drag, &plan);
    TEST_ASSERT_EQUAL_INT(REPLAY_JUDGED, replay_fly(&plan, NULL, &flight));
    const double speed_m_s = -flight.mate.speed_m_s; // it has begun to fly back
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1000 * (TRANSIT_M - (40 * TRANSIT_M - 76 * speed_m_s) / 50),
                              flight.mate.position_mm);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_a_flight_that_holds_its_way_arrives_exactly);
    RUN_TEST(test_a_flight_whose_time_constants_are_too_short_is_given_up_early);
    RUN_TEST(test_a_long_flight_tells_how_far_it_is);
    RUN_TEST(test_what_is_off_shows_and_what_cancels_does_not);
    return UNITY_END();
}
