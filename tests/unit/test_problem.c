// What a scenario must be, field by field.
#include <string.h>

#include "sample.h"
#include "unity.h"

static ssv_problem_t problem;
static ssv_fault_t fault;

void setUp(void) {}
void tearDown(void) {}

// A field of a scenario by its offset, a bad value.
typedef struct {
    size_t offset;
    double value;
    ssv_status_t status;
    const char* field;
    int index;
} bad_t;

#define AT(member) offsetof(ssv_scenario_t, member)

static const bad_t bad[] = {
    {AT(vehicle.body.mass_kg), 0, SSV_E_RANGE, "vehicle.body.mass_kg", -1},
    {AT(vehicle.body.mass_kg), -1, SSV_E_RANGE, "vehicle.body.mass_kg", -1},
    {AT(vehicle.body.mass_kg), (double)NAN, SSV_E_NOT_FINITE, "vehicle.body.mass_kg", -1},
    {AT(vehicle.body.mass_kg), (double)INFINITY, SSV_E_NOT_FINITE, "vehicle.body.mass_kg", -1},
    {AT(vehicle.body.inertia_kg_m2.y), 0, SSV_E_RANGE, "vehicle.body.inertia_kg_m2", -1},
    {AT(vehicle.body.inertia_kg_m2.y), 1.1e7, SSV_E_RANGE, "vehicle.body.inertia_kg_m2", -1},
    {AT(vehicle.body.inertia_kg_m2.z), 5.5, SSV_E_IMPOSSIBLE, "vehicle.body.inertia_kg_m2", -1}, // 2.7 + 2.7 < 5.5
    {AT(vehicle.body.added_mass_kg.z), -1, SSV_E_RANGE, "vehicle.body.added_mass_kg", -1},
    {AT(vehicle.body.drag_lin_kg_s), -1, SSV_E_RANGE, "vehicle.body.drag_lin_kg_s", -1},
    {AT(vehicle.body.drag_quad_kg_m), 1e6, SSV_E_RANGE, "vehicle.body.drag_quad_kg_m", -1},
    {AT(vehicle.body.drag_lin_ang_Nm_s), (double)NAN, SSV_E_NOT_FINITE, "vehicle.body.drag_lin_ang_Nm_s", -1},
    {AT(vehicle.body.drag_quad_ang_Nm_s2), -2, SSV_E_RANGE, "vehicle.body.drag_quad_ang_Nm_s2", -1},
    {AT(vehicle.radius_m), 0, SSV_E_RANGE, "vehicle.radius_m", -1},
    {AT(vehicle.force_max_N), 0, SSV_E_RANGE, "vehicle.force_max_N", -1},
    {AT(vehicle.thruster[2].p_ST_m.x), 11, SSV_E_RANGE, "vehicle.thruster[i].p_ST_m", 2},
    {AT(vehicle.thruster[3].n_T_S.y), -1.1, SSV_E_NOT_UNIT, "vehicle.thruster[i].n_T_S", 3},
    {AT(vehicle.thruster[0].n_T_S.x), 1e200, SSV_E_RANGE, "vehicle.thruster[i].n_T_S", 0},
    {AT(beam.body.mass_kg), 0, SSV_E_RANGE, "beam.body.mass_kg", -1},
    {AT(beam.body.inertia_kg_m2.z), -1, SSV_E_RANGE, "beam.body.inertia_kg_m2", -1},
    {AT(beam.body.inertia_kg_m2.z), 18, SSV_E_IMPOSSIBLE, "beam.body.inertia_kg_m2", -1},
    {AT(beam.body.inertia_kg_m2.x), 1e-9, SSV_E_IMPOSSIBLE, "beam.body.inertia_kg_m2", -1}, // y is above z
    {AT(beam.radius_m), -1, SSV_E_RANGE, "beam.radius_m", -1},
    {AT(beam.length_m), 0, SSV_E_RANGE, "beam.length_m", -1},
    {AT(beam.drag_strip_kg_m2), -1, SSV_E_RANGE, "beam.drag_strip_kg_m2", -1},
    {AT(X_IS.p.x), -1001, SSV_E_RANGE, "X_IS.p_m", -1},
    {AT(X_IS.q.z), 0, SSV_E_NOT_UNIT, "X_IS.q", -1}, // the only component: a zero quaternion
    {AT(X_IS.q.z), 1.002, SSV_E_NOT_UNIT, "X_IS.q", -1},
    {AT(X_IB.p.z), (double)INFINITY, SSV_E_NOT_FINITE, "X_IB.p_m", -1},
    {AT(X_IB.q.w), (double)NAN, SSV_E_NOT_FINITE, "X_IB.q", -1},
    {AT(p_IP_m.y), 2000, SSV_E_RANGE, "port.p_IP_m", -1},
    {AT(axis_I.y), 0, SSV_E_NOT_UNIT, "port.axis_I", -1},
    {AT(standoff_m), 0, SSV_E_RANGE, "standoff_m", -1},
    {AT(standoff_m), 0.25, SSV_E_IMPOSSIBLE, "standoff_m", -1}, // inside the hull
    {AT(standoff_m), 0.36, SSV_E_IMPOSSIBLE, "standoff_m", -1}, // 0.3025 + 0.0606 is more
    {AT(weight_time_per_s), -1, SSV_E_RANGE, "weight_time_per_s", -1},
    {AT(weight_impulse_per_Ns), -0.1, SSV_E_RANGE, "weight_impulse_per_Ns", -1},
};

static void test_each_bad_number_is_refused_by_the_name_of_its_field(void) {
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        ssv_scenario_t s = scenario_case_study(true);
        memcpy((char*)&s + bad[k].offset, &bad[k].value, sizeof(double));
        TEST_ASSERT_EQUAL_INT_MESSAGE(bad[k].status, ssv_problem_init(&problem, &s, &fault), bad[k].field);
        TEST_ASSERT_EQUAL_STRING(bad[k].field, fault.field);
        TEST_ASSERT_EQUAL_INT_MESSAGE(bad[k].index, fault.index, bad[k].field);
        TEST_ASSERT_EQUAL_INT(bad[k].status, fault.status);
    }
}

static void refuse(const ssv_scenario_t* s, ssv_status_t status, const char* field) {
    TEST_ASSERT_EQUAL_INT_MESSAGE(status, ssv_problem_init(&problem, s, &fault), field);
    TEST_ASSERT_EQUAL_STRING(field, fault.field);
}

static void test_each_bad_choice_is_refused_by_the_name_of_its_field(void) {
    ssv_scenario_t s = scenario_case_study(true);
    s.contact = 3;
    refuse(&s, SSV_E_RANGE, "contact");
    s = scenario_case_study(true);
    s.method = (ssv_method_t)7;
    refuse(&s, SSV_E_RANGE, "options.method");
    s = scenario_case_study(true);
    s.num_attach_heights = 9;
    refuse(&s, SSV_E_RANGE, "options.num_attach_heights");
    s.num_attach_heights = 2;
    s.attach_heights_m[1] = 1.6;
    refuse(&s, SSV_E_RANGE, "options.attach_heights_m[k]");
    TEST_ASSERT_EQUAL_INT(1, fault.index);
    s = scenario_case_study(true);
    s.ring_angle_given = true;
    s.ring_angle_rad = 7;
    refuse(&s, SSV_E_RANGE, "options.ring_angle_rad");
    s = scenario_case_study(true);
    s.weight_time_per_s = s.weight_impulse_per_Ns = 0;
    refuse(&s, SSV_E_WEIGHTS, "weight_time_per_s");
    s = scenario_case_study(true);
    s.vehicle.thruster[1] = s.vehicle.thruster[0];
    refuse(&s, SSV_E_SINGULAR, "vehicle.thruster");
    s = ssv_scenario_default();
    refuse(&s, SSV_E_RANGE, "vehicle.body.mass_kg");
}

static void test_what_just_touches_is_no_impossible_number(void) {
    ssv_scenario_t s = scenario_case_study(true);
    const double standoffs_m[] = {0.3025, 0.3631, 0.5}; // the hull's radius, as in the paper's tables; both; outside
    for (int k = 0; k < 3; k++) {
        s.standoff_m = standoffs_m[k];
        TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &s, &fault));
    }
    s.vehicle.body.inertia_kg_m2 = vec3(1.23, 2.34, 3.573); // a plate, rounded
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &s, &fault));
    s.vehicle.body.inertia_kg_m2 = s.beam.body.inertia_kg_m2 = vec3(1e-9, 1e-9, 1e-9);
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &s, &fault));
    s.vehicle.body.inertia_kg_m2 = s.beam.body.inertia_kg_m2 = vec3(1e7, 1e7, 1e7);
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &s, &fault));
}

static void test_refused_scenario_leaves_the_problem_untouched(void) {
    ssv_scenario_t s = scenario_case_study(true);
    ssv_problem_t before;
    memset(&problem, 0x5a, sizeof problem);
    memcpy(&before, &problem, sizeof before);
    s.axis_I.x = (double)NAN;
    refuse(&s, SSV_E_NOT_FINITE, "port.axis_I");
    TEST_ASSERT_EQUAL_MEMORY(&before, &problem, sizeof before);
}

static void test_quaternion_within_a_thousandth_is_normalised(void) {
    ssv_scenario_t s = scenario_case_study(true);
    s.X_IS.q.z = 0.9991;
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &s, &fault));
    TEST_ASSERT_EQUAL_DOUBLE(1, problem.scenario.X_IS.q.z);
    s.X_IS.q.z = 0.9989;
    refuse(&s, SSV_E_NOT_UNIT, "X_IS.q");
}

static void test_no_heights_means_the_three_rings(void) {
    const ssv_scenario_t s = scenario_case_study(true);
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, &s, &fault));
    TEST_ASSERT_EQUAL_INT(3, problem.scenario.num_attach_heights);
    TEST_ASSERT_EQUAL_DOUBLE(1.524, problem.scenario.attach_heights_m[0]);
    TEST_ASSERT_EQUAL_DOUBLE(0, problem.scenario.attach_heights_m[1]);
    TEST_ASSERT_EQUAL_DOUBLE(-1.524, problem.scenario.attach_heights_m[2]);
}

static void test_scenario_hash_changes_with_every_number_and_choice(void) {
    const ssv_scenario_t base = scenario_case_study(true);
    const uint64_t hash = ssv_scenario_hash(&base);
    TEST_ASSERT_TRUE(hash == ssv_scenario_hash(&base));
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        ssv_scenario_t s = base;
        memcpy((char*)&s + bad[k].offset, &bad[k].value, sizeof(double));
        TEST_ASSERT_TRUE_MESSAGE(hash != ssv_scenario_hash(&s), bad[k].field);
    }
    ssv_scenario_t s = base;
    s.contact = 2;
    TEST_ASSERT_TRUE(hash != ssv_scenario_hash(&s));
    s = base;
    s.num_attach_heights = 1;
    TEST_ASSERT_TRUE(hash != ssv_scenario_hash(&s));
    s = base;
    s.ring_angle_given = true;
    TEST_ASSERT_TRUE(hash != ssv_scenario_hash(&s));
}

static void test_every_status_and_outcome_has_its_own_sentence(void) {
    for (int a = SSV_E_TOO_FINE; a <= SSV_NUMERIC_OVERFLOW; a++) {
        for (int b = SSV_E_TOO_FINE; b < a; b++) {
            TEST_ASSERT_TRUE(strcmp(ssv_status_str((ssv_status_t)a), ssv_status_str((ssv_status_t)b)) != 0);
        }
    }
    for (int a = SSV_FEASIBLE; a <= SSV_TOO_MANY_SEGMENTS; a++) {
        for (int b = SSV_FEASIBLE; b < a; b++) {
            TEST_ASSERT_TRUE(strcmp(ssv_outcome_str((ssv_outcome_t)a), ssv_outcome_str((ssv_outcome_t)b)) != 0);
        }
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_each_bad_number_is_refused_by_the_name_of_its_field);
    RUN_TEST(test_each_bad_choice_is_refused_by_the_name_of_its_field);
    RUN_TEST(test_what_just_touches_is_no_impossible_number);
    RUN_TEST(test_refused_scenario_leaves_the_problem_untouched);
    RUN_TEST(test_quaternion_within_a_thousandth_is_normalised);
    RUN_TEST(test_no_heights_means_the_three_rings);
    RUN_TEST(test_scenario_hash_changes_with_every_number_and_choice);
    RUN_TEST(test_every_status_and_outcome_has_its_own_sentence);
    return UNITY_END();
}
