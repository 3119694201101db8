// A whole flight of a shipped scenario: executive, link, controller and physics. Writes every frame that was sent,
// those to the vehicle to DIR/up.bin and those from it to DIR/down.bin.
#include <stdio.h>

#include "guided.h"
#include "shipped.h"

static bool keep(void* context, bool up, int64_t now_us, const uint8_t* frame, size_t length) {
    FILE** file = context;
    (void)now_us;
    return fwrite(frame, 1, length, file[up ? 1 : 0]) == length;
}

static FILE* open_in(const char* folder, const char* name) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE* file = fopen(path, "wb");
    if (file == NULL) perror(path);
    return file;
}

int main(int argc, char** argv) {
    static ssv_problem_t problem;
    static ssv_work_t work;
    static ssv_plan_t plan;
    static flown_t flown;
    ssv_fault_t fault;
    if (argc != 2) return 2;
    FILE* file[2] = {open_in(argv[1], "down.bin"), open_in(argv[1], "up.bin")};
    const ssv_scenario_t* scenario = &shipped[0].scenario;
    if (file[0] == NULL || file[1] == NULL || ssv_problem_init(&problem, scenario, &fault) != SSV_OK ||
        ssv_plan(&problem, &work, &plan) != SSV_OK)
        return 1;
    const conditions_t conditions = {.rate_Hz = 10, .line = keep, .context = file};
    const bool flies =
        guided_flight(&problem, &plan, real_to_double(scenario->vehicle.force_max_N), &conditions, 1, &flown);
    const bool kept = fclose(file[0]) == 0 && fclose(file[1]) == 0;
    return flies && kept && flown.docked ? 0 : 1;
}
