// Plans of random tasks, flown open loop in the independent physics of sim/. SSV_LONG=1 flies a thousand of method
// optimal.
#include <stdio.h>

#include "flight.h"
#include "sample.h"
#include "sweep.h"
#include "unity.h"

// Case k of a sweep starts with sample_seed(SEED + k).
#define SEED 20261123
#define MAX_FLIGHTS 1000
#define POSITION_MAX_MM 5.0
#define POINTING_MAX_DEG 0.5

static char text[100];

void setUp(void) {}
void tearDown(void) {}

static const char* say(const char* what, int k) {
    (void)snprintf(text, sizeof text, "%s, sample_seed(%d)", what, SEED + k);
    return text;
}

// The worse of both arrivals, and what the plan said.
typedef struct {
    bool planned, judged;
    double position_mm, pointing_deg, speed_m_s, rate_rad_s, thrust_ratio;
    double time_s, impulse_Ns, plan_time_s, plan_impulse_Ns;
} flown_t;

static void fly(ssv_method_t method, int k, flown_t* flown) {
    static ssv_plan_t plan;
    ssv_problem_t problem;
    ssv_work_t work;
    ssv_fault_t fault;
    replay_flight_t flight;
    sample_seed(SEED + (uint64_t)k);
    ssv_scenario_t s = sample_scenario();
    // The bodies of the model as they are: what open-loop flight is promised for.
    s.vehicle = model_vehicle();
    s.beam = model_beam(true);
    s.method = method;
    flown->planned = ssv_problem_init(&problem, &s, &fault) == SSV_OK && ssv_plan(&problem, &work, &plan) == SSV_OK;
    if (!flown->planned) return;
    flown->judged = flight_of_plan(&problem, &plan, &flight);
    flown->position_mm = fmax(flight.mate.position_mm, flight.dock.position_mm);
    flown->pointing_deg = fmax(flight.mate.pointing_deg, flight.dock.pointing_deg);
    flown->speed_m_s = fmax(flight.mate.speed_m_s, flight.dock.speed_m_s);
    flown->rate_rad_s = fmax(flight.mate.rate_rad_s, flight.dock.rate_rad_s);
    flown->thrust_ratio = flight.thrust_ratio;
    flown->time_s = flight.time_s;
    flown->impulse_Ns = flight.impulse_Ns;
    flown->plan_time_s = plan.quote.time_s;
    flown->plan_impulse_Ns = plan.quote.impulse_Ns;
}

static void fly_paper(int k, void* result) { fly(SSV_METHOD_PAPER, k, result); }
static void fly_optimal(int k, void* result) { fly(SSV_METHOD_OPTIMAL, k, result); }

static void print_distribution(const char* name, double position_mm[], double pointing_deg[], int count) {
    static const double q[3] = {0.5, 0.99, 1};
    double mm[3], deg[3];
    for (int n = 0; n < 3; n++) {
        mm[n] = sweep_quantile(position_mm, count, q[n]);
        deg[n] = sweep_quantile(pointing_deg, count, q[n]);
    }
    printf("%s: %d flights, position median %.3f, p99 %.3f, worst %.3f mm; pointing %.5f, %.5f, %.5f deg\n", name,
           count, mm[0], mm[1], mm[2], deg[0], deg[1], deg[2]);
}

static void fly_tasks(const char* name, int count, void (*run)(int k, void* result)) {
    const flown_t* f = sweep(name, count, sizeof *f, run);
    static double position_mm[MAX_FLIGHTS], pointing_deg[MAX_FLIGHTS];
    TEST_ASSERT_NOT_NULL(f);
    for (int k = 0; k < count; k++) {
        TEST_ASSERT_TRUE_MESSAGE(f[k].planned, say("no plan", k));
        TEST_ASSERT_TRUE_MESSAGE(f[k].judged, say("no verdict", k));
        position_mm[k] = f[k].position_mm;
        pointing_deg[k] = f[k].pointing_deg;
    }
    print_distribution(name, position_mm, pointing_deg, count);
    for (int k = 0; k < count; k++) {
        TEST_ASSERT_TRUE_MESSAGE(f[k].thrust_ratio <= 1 + 1e-9, say("thrust beyond its limit", k));
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-6, f[k].plan_time_s, f[k].time_s, say("time", k));
        // Lines through a thruster's change of sign have a little more |u| than the curve.
        const double impulse_Ns = f[k].plan_impulse_Ns;
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(5e-3 * impulse_Ns, impulse_Ns, f[k].impulse_Ns, say("impulse", k));
        TEST_ASSERT_TRUE_MESSAGE(f[k].position_mm < POSITION_MAX_MM, say("position", k));
        TEST_ASSERT_TRUE_MESSAGE(f[k].pointing_deg < POINTING_MAX_DEG, say("pointing", k));
        TEST_ASSERT_TRUE_MESSAGE(f[k].speed_m_s < 1e-4, say("speed", k));
        TEST_ASSERT_TRUE_MESSAGE(f[k].rate_rad_s < 1e-4, say("rate", k));
    }
}

static void test_plans_of_method_paper_fly_open_loop_to_both_goals(void) {
    fly_tasks("paper", sweep_count(100, MAX_FLIGHTS), fly_paper);
}

static void test_plans_of_method_optimal_fly_open_loop_to_both_goals(void) {
    fly_tasks("optimal", sweep_count(30, MAX_FLIGHTS), fly_optimal);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_plans_of_method_paper_fly_open_loop_to_both_goals);
    RUN_TEST(test_plans_of_method_optimal_fly_open_loop_to_both_goals);
    return UNITY_END();
}
