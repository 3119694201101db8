// libFuzzer target: the bytes of a file or of a datagram as they may come from anyone, given to every reader of the
// host that takes such: scenario files (YAML), plan files (JSON), and the check that stands before the decoders of
// messages. Whatever they are, a refusal has a reason, and nothing is left behind.
#include <stdlib.h>
#include <string.h>

#include "lcm_ssv_execution_t.h"
#include "lcm_ssv_plan_t.h"
#include "lcm_ssv_quote_batch_t.h"
#include "scenario_file.h"
#include "wire/message.h"

/// Where models are that a scenario names.
#ifndef SSV_MODELS
#define SSV_MODELS "host/models"
#endif

#define CHECK(condition)                                                                                               \
    if (!(condition)) abort()

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);
const char* __lsan_default_suppressions(void);

// libfyaml 0.7.12 loses a kilobyte on some texts that it refuses.
const char* __lsan_default_suppressions(void) { return "leak:libfyaml"; }

static void read_scenario(const char* text, size_t size) {
    scenario_file_t file;
    lcm_ssv_task_t task;
    char error[512] = "", sentence[600];
    if (scenario_text_open(&file, "fuzz.yaml", text, size, SSV_MODELS, &task, error, sizeof error)) {
        scenario_file_explain(&file, "vehicle.body.mass_kg: is no more than an example", sentence, sizeof sentence);
    } else {
        CHECK(error[0] != '\0');
    }
    scenario_file_close(&file);
}

static void read_plan(const char* text, size_t size) {
    lcm_ssv_plan_t plan;
    const wire_part_t part = {"plan", "plan_t", &plan};
    char error[512] = "";
    if (wire_json_read("fuzz.json", text, size, &part, 1, error, sizeof error)) {
        wire_clear("plan_t", &plan);
    } else {
        CHECK(error[0] != '\0');
    }
}

// What passes decodes, to the last byte.
static void read_message(const uint8_t* data, size_t size) {
    lcm_ssv_plan_t plan;
    lcm_ssv_quote_batch_t quotes;
    lcm_ssv_execution_t execution;
    if (wire_is_message("plan_t", data, size)) {
        CHECK(lcm_ssv_plan_t_decode(data, 0, (int)size, &plan) == (int)size);
        lcm_ssv_plan_t_decode_cleanup(&plan);
    }
    if (wire_is_message("quote_batch_t", data, size)) {
        CHECK(lcm_ssv_quote_batch_t_decode(data, 0, (int)size, &quotes) == (int)size);
        lcm_ssv_quote_batch_t_decode_cleanup(&quotes);
    }
    if (wire_is_message("execution_t", data, size)) {
        CHECK(lcm_ssv_execution_t_decode(data, 0, (int)size, &execution) == (int)size);
        lcm_ssv_execution_t_decode_cleanup(&execution);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    // A copy of its own, so that a read beyond its end is seen; texts end with a zero.
    char* const text = malloc(size + 1);
    CHECK(text != NULL);
    memcpy(text, data, size);
    text[size] = '\0';
    read_scenario(text, size);
    read_plan(text, size);
    read_message((const uint8_t*)text, size);
    free(text);
    return 0;
}
