// Writes the shipped scenarios, by each method and effort, as the bytes that go over LCM, one file each, some with
// candidates and front, and batches of two ways: where the fuzzer starts from.
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lcm_ssv_scenario_batch_t.h"
#include "scenario_file.h"

#define NUM_WAYS 4

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
static bool write_scenario(const char* folder, int number, const lcm_ssv_scenario_t* scenario) {
    lcm_ssv_scenario_t ways[NUM_WAYS];
    uint8_t bytes[4096];
    for (int k = 0; k < NUM_WAYS; k++) {
        ways[k] = *scenario;
        ways[k].options.method = k / 2 == 0 ? LCM_SSV_OPTIONS_T_METHOD_OPTIMAL : LCM_SSV_OPTIONS_T_METHOD_PAPER;
        ways[k].options.effort = k % 2 == 0 ? LCM_SSV_OPTIONS_T_EFFORT_QUICK : LCM_SSV_OPTIONS_T_EFFORT_BEST;
        ways[k].options.attach_anywhere = k == 0;
        ways[k].options.want_candidates = k != 1;
        ways[k].options.want_front = k == 2;
        const int size = lcm_ssv_scenario_t_encode(bytes, 0, sizeof bytes, &ways[k]);
        if (!write_file(folder, "scenario", NUM_WAYS * number + k, bytes, size)) {
            return false;
        }
    }
    lcm_ssv_scenario_t both[] = {ways[0], ways[2]};
    const lcm_ssv_scenario_batch_t batch = {.num_scenarios = 2, .scenarios = both};
    return write_file(folder, "batch", number, bytes, lcm_ssv_scenario_batch_t_encode(bytes, 0, sizeof bytes, &batch));
}

int main(int argc, char** argv) {
    if (argc < 4) {
        fprintf(stderr, "Usage: make_corpus MODELS_DIR OUTPUT_DIR SCENARIO.yaml...\n");
        return 64;
    }
    for (int i = 3; i < argc; i++) {
        lcm_ssv_scenario_t scenario;
        char error[1024];
        memset(&scenario, 0, sizeof scenario);
        if (!scenario_file_read(argv[i], argv[1], &scenario, error, sizeof error)) {
            fprintf(stderr, "%s\n", error);
            return EXIT_FAILURE;
        }
        if (!write_scenario(argv[2], i - 3, &scenario)) {
            return EXIT_FAILURE;
        }
    }
    return EXIT_SUCCESS;
}
