// Words and limits of the message types, field by field.
#include "names.h"

#include <stddef.h>
#include <string.h>

#include "ssv/answer.h"

/// Parts of a schedule that is heard: more than any structure file can have.
#define SCHEDULE_PARTS_MAX 128

const names_t names_status = {"quote_t", "status", 4, {"ok", "infeasible", "invalid", "numeric_overflow"}};
const names_t names_phase = {"leg_t", "phase", 2, {"transit", "transfer"}};
const names_t names_kind = {"leg_t", "kind", 3, {"translate", "turn", "screw"}};
const names_t names_ramp = {"leg_t", "ramp", 3, {"full_reverse", "drag_only", "optimal"}};
const names_t names_event = {"event_t", "kind", 2, {"mate", "dock"}};
const names_t names_method = {"options_t", "method", 2, {"optimal", "paper"}};
const names_t names_effort = {"options_t", "effort", 2, {"quick", "best"}};
const names_t names_scalar = {"planner_t", "scalar", 3, {"double", "float", "fixed"}};
const names_t names_state = {
    "execution_t",
    "state",
    8,
    {"seeking", "uploading", "committing", "arming", "starting", "tracking", "stopping", "ended"}};
const names_t names_outcome = {"execution_t",
                               "outcome",
                               8,
                               {"under_way", "docked", "missed", "strayed", "stopped", "halted", "refused", "silent"}};
const names_t names_goal = {"execution_t", "goal", 2, {"mate", "dock"}};
static const names_t of_part = {"schedule_part_t", "state", 4, {"waits", "flies", "stands", "failed"}};
const names_t names_obstacle = {"obstacle_t", "kind", 2, {"capsule", "wall"}};
const names_t names_tank = {"tank_t", "kind", 3, {"none", "box", "cylinder"}};
const names_t names_body = {"clearance_t", "body", 2, {"vehicle", "beam"}};
static const names_t of_candidate = {"candidate_t", "body", 2, {"vehicle", "beam"}};

const names_t* names_of_field(const char* type, const char* field) {
    static const names_t* const all[] = {&names_status, &names_phase,   &names_kind,   &names_ramp,
                                         &names_event,  &names_method,  &names_effort, &names_scalar,
                                         &names_state,  &names_outcome, &names_goal,   &names_obstacle,
                                         &names_tank,   &names_body,    &of_candidate, &of_part};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        if (strcmp(all[i]->type, type) == 0 && strcmp(all[i]->field, field) == 0) {
            return all[i];
        }
    }
    return NULL;
}

const char* name_of(const names_t* names, int8_t value) {
    return value >= 0 && value < names->count ? names->words[value] : "unknown";
}

int8_t name_find(const names_t* names, const char* word) {
    for (int8_t value = 0; value < names->count; value++) {
        if (strcmp(names->words[value], word) == 0) {
            return value;
        }
    }
    return -1;
}

int32_t names_most_elements(const char* type, const char* field) {
    static const struct {
        const char *type, *field;
        int32_t most;
    } lists[] = {
        {"quote_t", "candidates", SSV_MAX_CANDIDATES},
        {"quote_t", "front", SSV_MAX_FRONT},
        {"plan_t", "legs", SSV_MAX_LEGS},
        {"plan_t", "arcs", SSV_MAX_ARCS},
        {"plan_t", "segments", SSV_MAX_SEGMENTS},
        {"plan_t", "events", SSV_MAX_EVENTS},
        {"quote_batch_t", "quotes", SSV_MAX_BATCH},
        {"scenario_batch_t", "scenarios", SSV_MAX_BATCH},
        {"schedule_t", "parts", SCHEDULE_PARTS_MAX},
    };
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++) {
        if (strcmp(lists[i].type, type) == 0 && strcmp(lists[i].field, field) == 0) {
            return lists[i].most;
        }
    }
    return 0;
}

const char* names_counter_of(const char* type, const char* field) {
    return strcmp(type, "scene_t") == 0 && strcmp(field, "obstacles") == 0 ? "num_obstacles" : NULL;
}

bool names_is_choice(const char* type, const char* field) {
    return strcmp(type, "scenario_t") == 0 && (strcmp(field, "obstacles") == 0 || strcmp(field, "left") == 0);
}
