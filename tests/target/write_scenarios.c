/// Writes scenario files as a C table, for programs on cores without files: write_scenarios MODELS_DIR FILE... >
/// shipped.h The numbers are the doubles that go over the wire, to the last bit; REAL() rounds them to the scalar of
/// whoever compiles the table. Scenes are left out. Exit codes: 0, 1 if a file is refused, 64 if none is given.
#include <stdio.h>
#include <string.h>

#include "planner/model/fields.def"
#include "scenario_file.h"
#include "ssv/planner.h"

static void print_list(const double* values, int count) {
    for (int i = 0; i < count; i++) printf("%sREAL(%a)", i == 0 ? "{" : ", ", values[i]);
    printf("}");
}

// How a field is written, by its kind.
#define PRINT_REAL(value) printf("REAL(%a)", value)
#define PRINT_VEC3(value) print_list(value, 3)
#define PRINT_UNIT(value) print_list(value, 3)
#define PRINT_QUAT(value) print_list(value, 4)
#define PRINT_INT(value) printf("%d", value)
#define PRINT_BOOL(value) printf("%d", value)
#define PRINT_ENUM(type) printf("(" #type ")"), PRINT_INT
#define PRINT_HEIGHT(k) PRINT_REAL
#define PRINT_RING(value) PRINT_REAL(value)
#define PRINT_ADDED(value) PRINT_REAL(value)
#define PRINT_FIELD(kind, core, wire, min, max, unit, text)                                                            \
    printf("     ." #core " = ");                                                                                      \
    PRINT_##kind(scenario->wire);                                                                                      \
    printf(",\n");

static void print_scenario(const lcm_ssv_scenario_t* scenario) { SSV_FIELDS(PRINT_FIELD) }

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
        lcm_ssv_task_t task;
        char error[1024];
        if (!scenario_file_read(argv[i], argv[1], &task, error, sizeof error)) {
            fprintf(stderr, "%s\n", error);
            return 1;
        }
        const char* const slash = strrchr(argv[i], '/');
        const char* const name = slash == NULL ? argv[i] : slash + 1;
        printf("    {\"%.*s\",\n     {\n", (int)strcspn(name, "."), name);
        print_scenario(&task.scenario);
        puts("     }},");
    }
    puts("};");
    return 0;
}
