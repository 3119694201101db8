// Writes the shipped scenarios, by each method and effort, as the bytes that go over LCM, one file each: where the fuzzer
// starts from.
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scenario_file.h"

int main(int argc, char** argv) {
    if (argc < 4) {
        fprintf(stderr, "Usage: make_corpus MODELS_DIR OUTPUT_DIR SCENARIO.yaml...\n");
        return 64;
    }
    for (int i = 3; i < argc; i++) {
        lcm_ssv_scenario_t scenario;
        char error[1024], path[4096];
        uint8_t bytes[4096];
        memset(&scenario, 0, sizeof scenario);
        if (!scenario_file_read(argv[i], argv[1], &scenario, error, sizeof error)) {
            fprintf(stderr, "%s\n", error);
            return EXIT_FAILURE;
        }
        for (int k = 0; k < 4; k++) {
            scenario.options.method = k / 2 == 0 ? LCM_SSV_OPTIONS_T_METHOD_OPTIMAL : LCM_SSV_OPTIONS_T_METHOD_PAPER;
            scenario.options.effort = k % 2 == 0 ? LCM_SSV_OPTIONS_T_EFFORT_QUICK : LCM_SSV_OPTIONS_T_EFFORT_BEST;
            const int size = lcm_ssv_scenario_t_encode(bytes, 0, sizeof bytes, &scenario);
            snprintf(path, sizeof path, "%s/%d", argv[2], 4 * (i - 3) + k);
            FILE* file = fopen(path, "wb");
            if (file == NULL || size < 0 || fwrite(bytes, 1, (size_t)size, file) != (size_t)size || fclose(file) != 0) {
                perror(path);
                return EXIT_FAILURE;
            }
        }
    }
    return EXIT_SUCCESS;
}
