// Scenarios of the core as the messages that ask for them, field by field.
#include "question.h"

#include <string.h>

#include "planner/model/fields.def"

static void vec3_to(double wire[3], vec3_t v) {
    wire[0] = real_to_double(v.x);
    wire[1] = real_to_double(v.y);
    wire[2] = real_to_double(v.z);
}

static void quat_to(double wire[4], quat_t q) {
    wire[0] = real_to_double(q.w);
    wire[1] = real_to_double(q.x);
    wire[2] = real_to_double(q.y);
    wire[3] = real_to_double(q.z);
}

// How a field goes out, by its kind.
#define TO_REAL(to, from) question.to = real_to_double(scenario->from)
#define TO_VEC3(to, from) vec3_to(question.to, scenario->from)
#define TO_UNIT(to, from) vec3_to(question.to, scenario->from)
#define TO_QUAT(to, from) quat_to(question.to, scenario->from)
#define TO_INT(to, from) question.to = (int8_t)scenario->from
#define TO_BOOL(to, from) question.to = (int8_t)scenario->from
#define TO_ENUM(type) TO_INT
#define TO_HEIGHT(k) TO_REAL
#define TO_RING(to, from) TO_REAL(to, from)
#define TO_ADDED(to, from) TO_REAL(to, from)
#define TO_FIELD(kind, core, wire, min, max, unit, text) TO_##kind(wire, core);

static void scene_to(lcm_ssv_scene_t* wire, const ssv_scene_t* scene) {
    wire->num_obstacles = (int8_t)scene->num_obstacles;
    for (int i = 0; i < SSV_MAX_OBSTACLES; i++) {
        const ssv_obstacle_t* from = &scene->obstacle[i];
        wire->obstacles[i].kind = (int8_t)from->kind;
        vec3_to(wire->obstacles[i].p_I_m, from->p_I_m);
        vec3_to(wire->obstacles[i].axis_I, from->axis_I);
        wire->obstacles[i].length_m = real_to_double(from->length_m);
        wire->obstacles[i].radius_m = real_to_double(from->radius_m);
    }
    wire->tank.kind = (int8_t)scene->tank.kind;
    vec3_to(wire->tank.from_I_m, scene->tank.from_I_m);
    vec3_to(wire->tank.to_I_m, scene->tank.to_I_m);
    wire->tank.radius_m = real_to_double(scene->tank.radius_m);
}

lcm_ssv_task_t question_of(const ssv_scenario_t* scenario) {
    lcm_ssv_task_t task;
    memset(&task, 0, sizeof task);
    lcm_ssv_scenario_t question = task.scenario;
    SSV_FIELDS(TO_FIELD)
    question.asker = (lcm_ssv_asker_t){.asker_id = 11, .request_id = 12, .epoch_us = 13};
    question.obstacles = (int64_t)scenario->obstacles;
    question.left = (int64_t)scenario->left;
    task.scenario = question;
    if (scenario->scene != NULL) scene_to(&task.scene, scenario->scene);
    return task;
}
