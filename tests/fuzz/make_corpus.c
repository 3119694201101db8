// Writes where the fuzzer starts from, as the bytes that go over LCM, one file each: the shipped scenarios by each
// method and effort, some with candidates and front, batches of two ways, and tasks at the edges of what is legal.
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lcm_ssv_scenario_batch_t.h"
#include "scenario_fields.h"
#include "scenario_file.h"

#define NUM_WAYS 4
#define BYTES_MAX 16384

static bool write_file(const char* folder, const char* kind, int number, const uint8_t* bytes, int size) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s%d", folder, kind, number);
    FILE* file = fopen(path, "wb");
    bool written = false;
    if (file != NULL) {
        written = size >= 0 && fwrite(bytes, 1, (size_t)size, file) == (size_t)size;
        written = fclose(file) == 0 && written;
    }
    if (!written) perror(path);
    return written;
}

/// One scenario in each way, and a batch of two of them: by effort quick, and by the paper with a front.
static bool write_scenario(const char* folder, int number, const lcm_ssv_task_t* task) {
    lcm_ssv_task_t ways[NUM_WAYS];
    uint8_t bytes[BYTES_MAX];
    for (int k = 0; k < NUM_WAYS; k++) {
        ways[k] = *task;
        lcm_ssv_options_t* const options = &ways[k].scenario.options;
        options->method = k / 2 == 0 ? LCM_SSV_OPTIONS_T_METHOD_OPTIMAL : LCM_SSV_OPTIONS_T_METHOD_PAPER;
        options->effort = k % 2 == 0 ? LCM_SSV_OPTIONS_T_EFFORT_QUICK : LCM_SSV_OPTIONS_T_EFFORT_BEST;
        options->attach_anywhere = k == 0;
        options->want_candidates = k != 1;
        options->want_front = k == 2;
        const int size = lcm_ssv_task_t_encode(bytes, 0, sizeof bytes, &ways[k]);
        if (!write_file(folder, "scenario", NUM_WAYS * number + k, bytes, size)) {
            return false;
        }
    }
    lcm_ssv_scenario_t both[] = {ways[0].scenario, ways[2].scenario};
    const lcm_ssv_scenario_batch_t batch = {.num_scenarios = 2, .scene = task->scene, .scenarios = both};
    return write_file(folder, "batch", number, bytes, lcm_ssv_scenario_batch_t_encode(bytes, 0, sizeof bytes, &batch));
}

static bool write_edge(const char* folder, int* number, lcm_ssv_task_t* task) {
    uint8_t bytes[BYTES_MAX];
    scenario_repair(&task->scenario, &task->scene);
    return write_file(folder, "edge", (*number)++, bytes, lcm_ssv_task_t_encode(bytes, 0, sizeof bytes, task));
}

static void set_drag(lcm_ssv_body_t* body, double drag) {
    body->drag_lin_kg_s = body->drag_quad_kg_m = body->drag_lin_ang_Nm_s = body->drag_quad_ang_Nm_s2 = drag;
}

/// The smallest and the largest value of every field, one at a time.
static bool write_ends(const char* folder, int* number, const lcm_ssv_task_t* task) {
    for (int k = 0; k < 2 * num_scenario_fields; k++) {
        const scenario_field_t* field = &scenario_fields[k / 2];
        lcm_ssv_task_t edge = *task;
        for (int i = 0; i < field->count; i++) {
            scenario_field_of(&edge.scenario, field)[i] = k % 2 ? field->max : field->min;
        }
        edge.scenario.options.ring_angle_given = strcmp(field->name, "options.ring_angle_rad") == 0;
        if (!write_edge(folder, number, &edge)) {
            return false;
        }
    }
    return true;
}

/// Several extremes at once.
static bool write_corners(const char* folder, int* number, const lcm_ssv_task_t* task) {
    enum {
        TINY_WEIGHTS,
        TIME_ALONE,
        IMPULSE_ALONE,
        NO_DRAG,
        ALL_DRAG,
        COINCIDENT,
        NEARLY,
        FAR,
        ENDS,
        LONG_BEAM,
        COUNT
    };
    for (int k = 0; k < COUNT; k++) {
        lcm_ssv_task_t whole = *task;
        lcm_ssv_scenario_t edge = whole.scenario;
        const int places = k == COINCIDENT ? 0 : k == NEARLY ? 1 : 2;
        switch (k) {
            case TINY_WEIGHTS: edge.weight_time_per_s = edge.weight_impulse_per_Ns = 1e-6; break;
            case TIME_ALONE: edge.weight_impulse_per_Ns = 0; break;
            case IMPULSE_ALONE: edge.weight_time_per_s = 0; break;
            case NO_DRAG:
            case ALL_DRAG:
                set_drag(&edge.vehicle.body, k == NO_DRAG ? 0 : 100000);
                set_drag(&edge.beam.body, k == NO_DRAG ? 0 : 100000);
                edge.beam.drag_strip_kg_m2 = k == NO_DRAG ? 0 : 100000;
                break;
            case COINCIDENT:
            case NEARLY:
            case FAR:
                for (int i = 0; i < 3; i++) {
                    const double apart_m[] = {0, 1e-7, 1000};
                    edge.X_IS.p_m[i] = -apart_m[places];
                    edge.X_IB.p_m[i] = 0;
                    edge.port.p_IP_m[i] = apart_m[places];
                }
                break;
            case ENDS:
                edge.options.num_attach_heights = 2;
                edge.options.attach_heights_m[0] = edge.beam.length_m / 2;
                edge.options.attach_heights_m[1] = -edge.beam.length_m / 2;
                break;
            default: // a strong vehicle holds a long beam far from its centre, in water that hardly lets it move
                set_drag(&edge.vehicle.body, 0);
                edge.vehicle.body.drag_lin_kg_s = 400;
                edge.vehicle.body.drag_quad_ang_Nm_s2 = 2;
                edge.vehicle.force_max_N = 10000;
                set_drag(&edge.beam.body, 0);
                edge.beam.body.drag_quad_kg_m = 100000;
                edge.beam.drag_strip_kg_m2 = 67;
                edge.beam.length_m = 100;
                edge.weight_time_per_s = 0;
                edge.weight_impulse_per_Ns = 1e-3;
                edge.options.num_attach_heights = 4;
                for (int i = 0; i < 4; i++) {
                    edge.options.attach_heights_m[i] = 20 * (i - 1.5);
                }
                break;
        }
        whole.scenario = edge;
        if (!write_edge(folder, number, &whole)) {
            return false;
        }
    }
    return true;
}

/// As many obstacles as there may be, of which one is left.
static bool write_full_scene(const char* folder, int* number, const lcm_ssv_task_t* task) {
    lcm_ssv_task_t full = *task;
    for (int k = full.scene.num_obstacles; k < 64; k++) {
        full.scene.obstacles[k] = (lcm_ssv_obstacle_t){
            .kind = LCM_SSV_OBSTACLE_T_KIND_CAPSULE, .p_I_m = {0.5 * k, 10, 0}, .axis_I = {0, 0, 1}, .radius_m = 0.1};
        full.scene.obstacles[k].length_m = k % 3;
    }
    full.scene.num_obstacles = 64;
    full.scenario.obstacles = -1;
    full.scenario.left = INT64_C(1) << 40;
    return write_edge(folder, number, &full);
}

int main(int argc, char** argv) {
    if (argc < 4) {
        fprintf(stderr, "Usage: make_corpus MODELS_DIR OUTPUT_DIR SCENARIO.yaml...\n");
        return 64;
    }
    int num_edges = 0;
    for (int i = 3; i < argc; i++) {
        lcm_ssv_task_t task;
        char error[1024];
        memset(&task, 0, sizeof task);
        if (!scenario_file_read(argv[i], argv[1], &task, error, sizeof error)) {
            fprintf(stderr, "%s\n", error);
            return EXIT_FAILURE;
        }
        const bool is_written = write_scenario(argv[2], i - 3, &task) &&
                                (task.scenario.margin_m > 0 ? write_full_scene(argv[2], &num_edges, &task)
                                                            : write_corners(argv[2], &num_edges, &task)) &&
                                (i > 3 || write_ends(argv[2], &num_edges, &task));
        if (!is_written) {
            return EXIT_FAILURE;
        }
    }
    return EXIT_SUCCESS;
}
