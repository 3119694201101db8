// Light and heavy bodies: what a scalar accepts, it can turn.
#include <math.h>

#include "sample.h"
#include "unity.h"

#define ANGLE_RAD 1.0
#define RADIUS_M 0.3025 // of the hull, on which the thrusters stand

void setUp(void) {}
void tearDown(void) {}

// All that is left to do is turn by one radian about the vehicle's z: the beam lies where it is to dock, and the
// vehicle stands where it is to hold it. Without drag, and with time alone to count, half of the turn speeds up with
// all that two thrusters give, and half slows down.
static ssv_scenario_t turn(double inertia_kg_m2, double force_N) {
    ssv_scenario_t s = scenario_case_study(false);
    const real_t inertia = real_from_double(inertia_kg_m2);
    s.method = SSV_METHOD_OPTIMAL;
    s.want_candidates = false;
    s.vehicle.body.inertia_kg_m2 = vec3(inertia, inertia, inertia);
    s.vehicle.body.drag_quad_ang_Nm_s2 = REAL(0);
    s.vehicle.force_max_N = real_from_double(force_N);
    s.weight_impulse_per_Ns = REAL(0);
    s.standoff_m = s.vehicle.radius_m;
    s.X_IB = (pose_t){vec3(REAL(0), REAL(0), REAL(0)), quat_identity()};
    s.X_IS.p = vec3(-s.standoff_m, REAL(0), REAL(0));
    s.X_IS.q = quat_from_axis_angle(vec3(REAL(0), REAL(0), REAL(1)), real_from_double(ANGLE_RAD));
    s.p_IP_m = vec3(REAL(0), REAL(0), real_mul(REAL(0.5), s.beam.length_m));
    s.axis_I = vec3(REAL(0), REAL(0), REAL(-1));
    s.contact = 2;
    s.num_attach_heights = 1;
    s.attach_heights_m[0] = REAL(0);
    s.ring_angle_given = true; // or a strong vehicle would rather fly around the beam than turn
    s.ring_angle_rad = REAL_PI;
    return s;
}

static ssv_status_t price(const ssv_scenario_t* s, double* cost) {
    ssv_problem_t problem;
    ssv_work_t work;
    ssv_fault_t fault;
    ssv_quote_t quote;
    ssv_status_t status = ssv_problem_init(&problem, s, &fault);
    if (status != SSV_OK) return status;
    status = ssv_quote(&problem, &work, &quote);
    *cost = real_to_double(quote.cost);
    return status;
}

static bool is_fixed(void) { return REAL_STEP > REAL(0); }

static void test_a_vehicle_turns_in_the_time_of_its_moment_of_inertia_or_is_refused_by_the_scalar(void) {
    // Float has 7 digits and plans in some tens of operations; in fixed point the least moment has 5.
    const double tolerance = is_fixed() ? 1e-5 : sizeof(real_t) == sizeof(float) ? 1e-5 : 1e-9;
    int num_turned = 0;
    for (int exponent = -9; exponent <= 7; exponent++) {
        const double inertia = pow(10, exponent), force = fmin(100, fmax(0.01, inertia));
        const ssv_scenario_t s = turn(inertia, force);
        double cost = 0;
        const ssv_status_t status = price(&s, &cost);
        if (is_fixed() && exponent < -4) {
            TEST_ASSERT_EQUAL_INT(SSV_E_TOO_FINE, status);
            continue;
        }
        if (is_fixed() && status == SSV_NUMERIC_OVERFLOW && exponent > 3) continue; // which says so, too
        TEST_ASSERT_EQUAL_INT(SSV_OK, status);
        const double expected = 2 * sqrt(ANGLE_RAD * inertia / (2 * force * RADIUS_M));
        TEST_ASSERT_DOUBLE_WITHIN(tolerance * expected, expected, cost);
        num_turned++;
    }
    TEST_ASSERT_GREATER_OR_EQUAL(is_fixed() ? 8 : 17, num_turned);
}

// A carbon strut of 50 g: what it has about its own axis is nothing beside the vehicle.
static void test_a_strut_of_grams_is_carried_whatever_its_least_moment_of_inertia(void) {
    static const double least[] = {1.5e-6, 1e-7, 1e-9};
    double cost[3] = {0};
    for (int k = 0; k < 3; k++) {
        ssv_scenario_t s = scenario_case_study(true);
        s.method = SSV_METHOD_OPTIMAL;
        s.beam.body.mass_kg = real_from_double(0.05);
        s.beam.length_m = real_from_double(0.5);
        s.beam.body.inertia_kg_m2 =
            vec3(real_from_double(1.042e-3), real_from_double(1.042e-3), real_from_double(least[k]));
        TEST_ASSERT_EQUAL_INT(SSV_OK, price(&s, &cost[k]));
        TEST_ASSERT_DOUBLE_WITHIN(1e-5 * cost[0], cost[0],
                                  cost[k]); // 1.5e-6 of 2.7 is less, as are the digits of float
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_a_vehicle_turns_in_the_time_of_its_moment_of_inertia_or_is_refused_by_the_scalar);
    RUN_TEST(test_a_strut_of_grams_is_carried_whatever_its_least_moment_of_inertia);
    return UNITY_END();
}
