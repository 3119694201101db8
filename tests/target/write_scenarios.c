/// Writes scenario files as a C table, for programs on cores without files: write_scenarios MODELS_DIR FILE... >
/// shipped.h The numbers are the doubles that go over the wire, to the last bit; REAL() rounds them to the scalar of
/// whoever compiles the table. Exit codes: 0, 1 if a file is refused, 64 if none is given.
#include <stdio.h>
#include <string.h>

#include "scenario_file.h"
#include "ssv/planner.h"

static void print_list(const double* values, int count) {
    for (int i = 0; i < count; i++) printf("%sREAL(%a)", i == 0 ? "{" : ", ", values[i]);
    printf("}");
}

static void print_number(const char* field, double value) { printf("     .%s = REAL(%a),\n", field, value); }

static void print_numbers(const char* field, const double* values, int count) {
    printf("     .%s = ", field);
    print_list(values, count);
    printf(",\n");
}

static void print_pose(const char* field, const lcm_ssv_pose_t* X) {
    printf("     .%s = {", field);
    print_list(X->p_m, 3);
    printf(", ");
    print_list(X->q, 4);
    printf("},\n");
}

static void print_body(const char* field, const lcm_ssv_body_t* body) {
    printf("     .%s = {REAL(%a), ", field, body->mass_kg);
    print_list(body->inertia_kg_m2, 3);
    printf(", ");
    print_list(body->added_mass_kg, 3);
    printf(", REAL(%a), REAL(%a), REAL(%a), REAL(%a)},\n", body->drag_lin_kg_s, body->drag_quad_kg_m,
           body->drag_lin_ang_Nm_s, body->drag_quad_ang_Nm_s2);
}

static void print_scenario(const lcm_ssv_scenario_t* scenario) {
    print_body("vehicle.body", &scenario->vehicle.body);
    print_number("vehicle.radius_m", scenario->vehicle.radius_m);
    print_number("vehicle.force_max_N", scenario->vehicle.force_max_N);
    printf("     .vehicle.thruster = {");
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        printf("%s\n      {", i == 0 ? "" : ",");
        print_list(scenario->vehicle.thruster[i].p_ST_m, 3);
        printf(", ");
        print_list(scenario->vehicle.thruster[i].n_T_S, 3);
        printf("}");
    }
    printf("},\n");
    print_body("beam.body", &scenario->beam.body);
    print_number("beam.radius_m", scenario->beam.radius_m);
    print_number("beam.length_m", scenario->beam.length_m);
    print_number("beam.drag_strip_kg_m2", scenario->beam.drag_strip_kg_m2);
    print_pose("X_IS", &scenario->X_IS);
    print_pose("X_IB", &scenario->X_IB);
    print_numbers("p_IP_m", scenario->port.p_IP_m, 3);
    print_numbers("axis_I", scenario->port.axis_I, 3);
    printf("     .contact = %d,\n", scenario->contact);
    print_number("standoff_m", scenario->standoff_m);
    print_number("weight_time_per_s", scenario->weight_time_per_s);
    print_number("weight_impulse_per_Ns", scenario->weight_impulse_per_Ns);
    printf("     .method = (ssv_method_t)%d,\n", scenario->options.method);
    printf("     .effort = (ssv_effort_t)%d,\n", scenario->options.effort);
    printf("     .num_attach_heights = %d,\n", scenario->options.num_attach_heights);
    print_numbers("attach_heights_m", scenario->options.attach_heights_m, SSV_MAX_ATTACH_HEIGHTS);
    printf("     .attach_anywhere = %d,\n", scenario->options.attach_anywhere);
    printf("     .want_candidates = %d,\n", scenario->options.want_candidates);
    printf("     .ring_angle_given = %d,\n", scenario->options.ring_angle_given);
    print_number("ring_angle_rad", scenario->options.ring_angle_rad);
}

int main(int argc, char** argv) {
    if (argc < 3) {
        fputs("Usage: write_scenarios MODELS_DIR SCENARIO.yaml...\n", stderr);
        return 64;
    }
    puts(
        "// The shipped scenarios by the names of their files. Written by write_scenarios.\n"
        "#include \"ssv/planner.h\"\n\n"
        "static const struct {\n    const char* name;\n    ssv_scenario_t scenario;\n} shipped[] = {");
    for (int i = 2; i < argc; i++) {
        lcm_ssv_scenario_t scenario;
        char error[1024];
        if (!scenario_file_read(argv[i], argv[1], &scenario, error, sizeof error)) {
            fprintf(stderr, "%s\n", error);
            return 1;
        }
        const char* const slash = strrchr(argv[i], '/');
        const char* const name = slash == NULL ? argv[i] : slash + 1;
        printf("    {\"%.*s\",\n     {\n", (int)strcspn(name, "."), name);
        print_scenario(&scenario);
        puts("     }},");
    }
    puts("};");
    return 0;
}
