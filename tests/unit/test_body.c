// Demands and thrust coefficients of moving bodies: the model's check values, closed forms, momentum.
#include "planner/model/allocation.h"
#include "planner/motion/maneuver.h"
#include "sample.h"
#include "unity.h"

static ssv_problem_t problem;
static const vec3_t none = {0, 0, 0};

void setUp(void) {}
void tearDown(void) {}

static void init(const ssv_scenario_t* scenario) {
    ssv_fault_t fault;
    TEST_ASSERT_EQUAL_INT(SSV_OK, ssv_problem_init(&problem, scenario, &fault));
}

static void assert_vec3(double tolerance, vec3_t expected, vec3_t actual) {
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, expected.x, actual.x);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, expected.y, actual.y);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, expected.z, actual.z);
}

// Beam centre at (0.3025, -1.524, 0) in S with its tube along y of S.
static ssv_assembly_t held_at_the_end(void) {
    const ssv_assembly_t pair = {
        &problem.scenario.vehicle, &problem.scenario.beam, {{0.3025, -1.524, 0}, {sqrt(0.5), -sqrt(0.5), 0, 0}}};
    return pair;
}

static void test_turn_of_the_pair_has_the_coefficients_of_the_model(void) {
    static const double table[2][3][6] = {
        {{0, 0, 58.494, 58.494, 0, 0},
         {-40.909, 40.909, -8.120, 8.120, 0, 0},
         {257.16, -257.16, 1989.69, 1989.69, 0, 0}},
        {{8.659, -8.659, 66.097, 62.660, 0, 0}, {0, 0, 0, 0, 0, 0}, {312.88, -312.88, 2389.74, 2372.42, 0, 0}}};
    const ssv_scenario_t scenario = scenario_case_study(true);
    init(&scenario);
    const ssv_assembly_t pair = held_at_the_end();
    for (int pivot = 0; pivot < 2; pivot++) {
        const vec3_t p = pivot == 0 ? ssv_body_centre(&pair) : none;
        const ssv_maneuver_t turn = ssv_maneuver_turn(SSV_TRANSFER, vec3(0, 0, 1), 1, p);
        ssv_thrusts_t t;
        ssv_maneuver_thrusts(&problem, &pair, turn.twist, &t);
        for (int i = 0; i < 6; i++) { // tolerance: the table's printed digits
            TEST_ASSERT_DOUBLE_WITHIN(5.1e-4, table[pivot][0][i], t.accel[i]);
            TEST_ASSERT_DOUBLE_WITHIN(5.1e-4, table[pivot][1][i], t.linear[i]);
            TEST_ASSERT_DOUBLE_WITHIN(5.1e-3, table[pivot][2][i], t.quadratic[i]);
        }
    }
}

static ssv_demand_t demand_of(const ssv_beam_t* beam, vec3_t p_SB, ssv_twist_t twist) {
    static ssv_vehicle_t still;
    still = model_vehicle();
    still.body.mass_kg = still.body.drag_lin_kg_s = still.body.drag_quad_ang_Nm_s2 = 0;
    still.body.inertia_kg_m2 = none;
    const ssv_assembly_t pair = {&still, beam, {p_SB, {1, 0, 0, 0}}};
    ssv_demand_t demand;
    ssv_body_demand(&pair, twist, &demand);
    return demand;
}

static ssv_beam_t weightless_tube(void) {
    ssv_beam_t beam = model_beam(true);
    beam.body.mass_kg = 0;
    beam.body.inertia_kg_m2 = none;
    return beam;
}

static void test_tube_flown_broadside_feels_the_drag_of_its_length(void) {
    const ssv_beam_t tube = weightless_tube();
    const ssv_demand_t d = demand_of(&tube, none, (ssv_twist_t){{0.6, 0.8, 5}, {0, 0, 0}});
    assert_vec3(1e-10, vec3(66.66 * 3.048 * 0.6, 66.66 * 3.048 * 0.8, 0), d.quadratic.force); // none along the axis
    assert_vec3(1e-10, none, d.quadratic.moment);
}

static void test_tube_turned_about_its_centre_feels_the_fourth_power_of_its_length(void) {
    const ssv_beam_t tube = weightless_tube();
    const ssv_demand_t d = demand_of(&tube, none, (ssv_twist_t){{0, 0, 0}, {1, 0, 0}});
    assert_vec3(1e-10, none, d.quadratic.force);
    assert_vec3(1e-9, vec3(66.66 * pow(3.048, 4) / 32, 0, 0), d.quadratic.moment);
}

static void test_tube_turned_about_its_end_feels_the_integral_of_its_strips(void) {
    const ssv_beam_t tube = weightless_tube();
    const ssv_demand_t d = demand_of(&tube, vec3(0, 0, 1.524), (ssv_twist_t){{0, 0, 0}, {0, 1, 0}});
    const double L = 3.048;
    assert_vec3(1e-9, vec3(66.66 * L * L * L / 3, 0, 0), d.quadratic.force);
    assert_vec3(1e-9, vec3(0, 66.66 * L * L * L * L / 4, 0), d.quadratic.moment);
}

static void test_strip_drag_of_any_twist_matches_a_fine_sum_over_strips(void) {
    const uint64_t seed = 11;
    sample_seed(seed);
    const ssv_beam_t tube = weightless_tube();
    for (int trial = 0; trial < 200; trial++) {
        const ssv_twist_t twist = {sample_vector(trial % 3 == 0 ? 0.1 : 2), sample_vector(1)};
        const ssv_demand_t d = demand_of(&tube, none, twist);
        vec3_t force = none, moment = none;
        const int strips = 20000;
        for (int k = 0; k < strips; k++) {
            const double z = 3.048 * ((k + 0.5) / strips - 0.5);
            vec3_t v = vec3_add(twist.v, vec3_cross(twist.w, vec3(0, 0, z)));
            v.z = 0;
            const vec3_t f = vec3_scale(66.66 * 3.048 / strips * vec3_norm(v), v);
            force = vec3_add(force, f);
            moment = vec3_add(moment, vec3_cross(vec3(0, 0, z), f));
        }
        // 16 Gauss points across the kink: 2e-5 of the largest at worst, a thousandth of what moves a plan by a
        // millimetre.
        const double scale = vec3_norm(force) + vec3_norm(moment);
        assert_vec3(2e-5 * scale, force, d.quadratic.force);
        assert_vec3(2e-5 * scale, moment, d.quadratic.moment);
    }
}

static void test_vehicle_alone_demands_its_mass_drag_and_added_mass_along_each_axis(void) {
    ssv_vehicle_t vehicle = model_vehicle();
    vehicle.body.added_mass_kg = vec3(10, 20, 30);
    vehicle.body.drag_quad_kg_m = 7;
    const ssv_assembly_t alone = {&vehicle, NULL, {{0, 0, 0}, {1, 0, 0, 0}}};
    ssv_demand_t d;
    ssv_body_demand(&alone, (ssv_twist_t){{0, 2, 0}, {0, 0, 0}}, &d);
    assert_vec3(1e-12, vec3(0, 2 * 96.2, 0), d.accel.force);
    assert_vec3(1e-12, vec3(0, 2 * 413.685, 0), d.linear.force);
    assert_vec3(1e-12, vec3(0, 4 * 7, 0), d.quadratic.force);
    // Unequal added mass turns the body towards its broad side (Munk): v x P with P = M v.
    ssv_body_demand(&alone, (ssv_twist_t){{1, 1, 0}, {0, 0, 0}}, &d);
    assert_vec3(1e-12, vec3(0, 0, 96.2 - 86.2), d.quadratic.moment);
}

static void test_pair_centre_is_that_of_table_6(void) {
    const ssv_scenario_t scenario = scenario_case_study(false);
    init(&scenario);
    const ssv_assembly_t pair = held_at_the_end();
    const vec3_t c = ssv_body_centre(&pair);
    TEST_ASSERT_DOUBLE_WITHIN(5e-5, 0.3025 - 0.2632, c.x); // 0.0393 m
    TEST_ASSERT_DOUBLE_WITHIN(5e-5, 6.3262 - 6.524, c.y);
}

static void test_flight_of_the_pair_holds_full_wrench_with_10_62_newtons(void) {
    // Table 6: along y the thrusters at x = +-R_S share 6 N and 6 (R_S - c) / (R_S + c) N when the force acts at C.
    const ssv_scenario_t scenario = scenario_case_study(false);
    init(&scenario);
    const ssv_assembly_t pair = held_at_the_end();
    const vec3_t c = ssv_body_centre(&pair), force = vec3(0, 1, 0);
    double u[6];
    ssv_alloc(&problem.allocation, force, vec3(0, 0, c.x), u);
    TEST_ASSERT_DOUBLE_WITHIN(0.005, 10.62, 6 * (fabs(u[2]) + fabs(u[3])) / fmax(fabs(u[2]), fabs(u[3])));
}

static void test_allocation_makes_the_wrench_that_was_asked_for(void) {
    const uint64_t seed = 3;
    sample_seed(seed);
    for (int trial = 0; trial < 100; trial++) {
        const ssv_scenario_t scenario = sample_scenario();
        init(&scenario);
        const vec3_t force = sample_vector(5), moment = sample_vector(2);
        double u[6];
        ssv_alloc(&problem.allocation, force, moment, u);
        vec3_t f = none, m = none;
        for (int i = 0; i < 6; i++) {
            const ssv_thruster_t* t = &problem.scenario.vehicle.thruster[i];
            f = vec3_add(f, vec3_scale(u[i], t->n_T_S));
            m = vec3_add(m, vec3_cross(t->p_ST_m, vec3_scale(u[i], t->n_T_S)));
        }
        assert_vec3(1e-11, force, f);
        assert_vec3(1e-11, moment, m);
    }
}

// What one layout lacks follows from its geometry; where that is more than one thing, what is named is checked alone:
// no thruster serves it.
static void test_thrusters_that_miss_a_direction_are_singular_and_it_is_named(void) {
    enum { NUM = 6 };
    static const double r = 0.3025; // of the hull
    static const struct {
        const char* name;
        ssv_lack_t lack;
    } expected[NUM] = {
        {"one thruster twice", {{0, 0, 1}, {1, 0, 0}, true}}, // what is left pushes along z and turns about x at once
        {"two next to one another", {{0, 0, 1}, {1, 0, 0}, true}},
        {"nothing along z or about x", {{0, 0, 1}, {1, 0, 0}, false}},
        {"nothing about x", {{0, 0, 0}, {1, 0, 0}, false}},
        {"no moment at all", {{0, 0, 0}, {1, 0, 0}, false}},
        {"a plane of thrusters along z", {{0, 1, 0}, {0, 0, 1}, false}},
    };
    ssv_vehicle_t layout[NUM];
    for (int k = 0; k < NUM; k++) layout[k] = model_vehicle();
    layout[0].thruster[5] = layout[0].thruster[4];
    layout[1].thruster[5].p_ST_m = vec3(0, 0.3024, 0); // six directions on paper, five in the water
    for (int i = 4; i < 6; i++) layout[2].thruster[i].n_T_S = vec3(i == 4 ? 1 : -1, 0, 0);
    for (int i = 4; i < 6; i++) layout[3].thruster[i].p_ST_m = vec3(i == 4 ? r : -r, 0, 0);
    for (int i = 0; i < 6; i++) layout[4].thruster[i].p_ST_m = none;
    for (int i = 0; i < 6; i++) {
        const double angle = i * acos(-1) / 3; // x is lacking, too
        layout[5].thruster[i] = (ssv_thruster_t){{r * cos(angle), r * sin(angle), 0}, {0, 0, 1}};
    }
    for (int k = 0; k < NUM; k++) {
        ssv_allocation_t inverse;
        ssv_lack_t lack;
        const ssv_lack_t* e = &expected[k].lack;
        const char* const name = expected[k].name;
        TEST_ASSERT_EQUAL_INT_MESSAGE(SSV_E_SINGULAR, ssv_alloc_init(&layout[k], &inverse, &lack), name);
        // Either way along it is the same direction. Thrusters that are a little off make it so, too.
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.001, vec3_norm(e->push_S), fabs(vec3_dot(lack.push_S, e->push_S)), name);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.001, vec3_norm(e->turn_S), fabs(vec3_dot(lack.turn_S, e->turn_S)), name);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-12, vec3_norm(e->push_S), vec3_norm(lack.push_S), name);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-12, vec3_norm(e->turn_S), vec3_norm(lack.turn_S), name);
        TEST_ASSERT_EQUAL_MESSAGE(e->coupled, lack.coupled, name);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_turn_of_the_pair_has_the_coefficients_of_the_model);
    RUN_TEST(test_tube_flown_broadside_feels_the_drag_of_its_length);
    RUN_TEST(test_tube_turned_about_its_centre_feels_the_fourth_power_of_its_length);
    RUN_TEST(test_tube_turned_about_its_end_feels_the_integral_of_its_strips);
    RUN_TEST(test_strip_drag_of_any_twist_matches_a_fine_sum_over_strips);
    RUN_TEST(test_vehicle_alone_demands_its_mass_drag_and_added_mass_along_each_axis);
    RUN_TEST(test_pair_centre_is_that_of_table_6);
    RUN_TEST(test_flight_of_the_pair_holds_full_wrench_with_10_62_newtons);
    RUN_TEST(test_allocation_makes_the_wrench_that_was_asked_for);
    RUN_TEST(test_thrusters_that_miss_a_direction_are_singular_and_it_is_named);
    return UNITY_END();
}
