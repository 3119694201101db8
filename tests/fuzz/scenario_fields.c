#include "scenario_fields.h"

#include <math.h>

#define FIELD(member, count, min, max) {#member, offsetof(lcm_ssv_scenario_t, member), count, min, max}
#define BODY(body)                                                                                                     \
    FIELD(body.mass_kg, 1, 0.01, 10000), FIELD(body.inertia_kg_m2, 3, 0x1p-16, 10000000),                              \
        FIELD(body.added_mass_kg, 3, 0, 10000), FIELD(body.drag_lin_kg_s, 1, 0, 100000),                               \
        FIELD(body.drag_quad_kg_m, 1, 0, 100000), FIELD(body.drag_lin_ang_Nm_s, 1, 0, 100000),                         \
        FIELD(body.drag_quad_ang_Nm_s2, 1, 0, 100000)

// The ranges as the planner checks them. Were one of them wider than the planner's, the share of legal inputs that the
// fuzzer prints would fall; what lies beyond the ranges comes from libFuzzer's own mutations.
const scenario_field_t scenario_fields[] = {
    BODY(vehicle.body),
    FIELD(vehicle.radius_m, 1, 0.001, 10),
    FIELD(vehicle.force_max_N, 1, 0.001, 10000),
    BODY(beam.body),
    FIELD(beam.radius_m, 1, 0.001, 10),
    FIELD(beam.length_m, 1, 0.01, 100),
    FIELD(beam.drag_strip_kg_m2, 1, 0, 100000),
    FIELD(X_IS.p_m, 3, -1000, 1000),
    FIELD(X_IS.q, 4, -1, 1),
    FIELD(X_IB.p_m, 3, -1000, 1000),
    FIELD(X_IB.q, 4, -1, 1),
    FIELD(port.p_IP_m, 3, -1000, 1000),
    FIELD(port.axis_I, 3, -1, 1),
    FIELD(standoff_m, 1, 0.001, 20),
    FIELD(weight_time_per_s, 1, 0, 1000),
    FIELD(weight_impulse_per_Ns, 1, 0, 1000),
    FIELD(thrust_reserve, 1, 0, 0x1.cccccp-1), // below 0.9 in every scalar
    FIELD(options.attach_heights_m, 8, -50, 50),
    FIELD(options.ring_angle_rad, 1, -6.28, 6.28),
    FIELD(margin_m, 1, 0, 10),
    FIELD(approach_mate_m, 1, 0, 10),
    FIELD(approach_dock_m, 1, 0, 10),
    FIELD(contact_speed_max_m_s, 1, 0, 100),
    FIELD(transit_speed_max_m_s, 1, 0, 100),
    FIELD(transit_rate_max_rad_s, 1, 0, 100),
    FIELD(transfer_speed_max_m_s, 1, 0, 100),
    FIELD(transfer_beam_speed_max_m_s, 1, 0, 100),
    FIELD(transfer_rate_max_rad_s, 1, 0, 100),
};
const int num_scenario_fields = (int)(sizeof scenario_fields / sizeof scenario_fields[0]);

double* scenario_field_of(lcm_ssv_scenario_t* scenario, const scenario_field_t* field) {
    return (double*)(void*)((char*)scenario + field->offset);
}

static double clamped(double x, double min, double max) { return !(x >= min) ? min : x > max ? max : x; }

static void to_unit_length(double* v, int count) {
    double square = 0;
    for (int i = 0; i < count; i++) {
        v[i] = clamped(v[i], -1, 1);
        square += v[i] * v[i];
    }
    if (square < 1e-6) {
        for (int i = 0; i < count; i++) {
            v[i] = i == 0;
        }
    } else if (fabs(sqrt(square) - 1) > 5e-4) {
        for (int i = 0; i < count; i++) {
            v[i] /= sqrt(square);
        }
    }
}

// Axes of a scene are taken as they stand, so a rounding is all that they may be off.
static void to_exact_unit_length(double* v) {
    to_unit_length(v, 3);
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; i++) {
        v[i] /= length;
    }
}

static void repair_scene(lcm_ssv_scenario_t* scenario, lcm_ssv_scene_t* scene) {
    scene->num_obstacles = (int8_t)clamped(scene->num_obstacles, 0, 64);
    const int num = scene->num_obstacles;
    scenario->obstacles &= num == 0 ? 0 : (int64_t)(UINT64_MAX >> (64 - num));
    for (int k = 0; k < scene->num_obstacles; k++) {
        lcm_ssv_obstacle_t* obstacle = &scene->obstacles[k];
        obstacle->kind = (int8_t)clamped(obstacle->kind, LCM_SSV_OBSTACLE_T_KIND_CAPSULE, LCM_SSV_OBSTACLE_T_KIND_WALL);
        obstacle->length_m = clamped(obstacle->length_m, 0, 1000);
        obstacle->radius_m = clamped(obstacle->radius_m, 0, 100);
        to_exact_unit_length(obstacle->axis_I);
        for (int i = 0; i < 3; i++) {
            obstacle->p_I_m[i] = clamped(obstacle->p_I_m[i], -1000, 1000);
        }
    }
    lcm_ssv_tank_t* tank = &scene->tank;
    tank->kind = (int8_t)clamped(tank->kind, LCM_SSV_TANK_T_KIND_NONE, LCM_SSV_TANK_T_KIND_CYLINDER);
    tank->radius_m = clamped(tank->radius_m, 0.001, 1000);
    for (int i = 0; i < 3; i++) {
        tank->from_I_m[i] = clamped(tank->from_I_m[i], -1000, 1000);
        tank->to_I_m[i] = clamped(tank->to_I_m[i], tank->from_I_m[i], 1000);
    }
}

// None larger than the other two together.
static void repair_moments(double moments[3]) {
    for (int i = 0; i < 3; i++) {
        const double others = moments[(i + 1) % 3] + moments[(i + 2) % 3];
        moments[i] = fmin(moments[i], others);
    }
}

void scenario_repair(lcm_ssv_scenario_t* scenario, lcm_ssv_scene_t* scene) {
    repair_scene(scenario, scene);
    for (int k = 0; k < num_scenario_fields; k++) {
        double* number = scenario_field_of(scenario, &scenario_fields[k]);
        for (int i = 0; i < scenario_fields[k].count; i++) {
            number[i] = clamped(number[i], scenario_fields[k].min, scenario_fields[k].max);
        }
    }
    for (int i = 0; i < 6; i++) {
        lcm_ssv_thruster_t* thruster = &scenario->vehicle.thruster[i];
        to_unit_length(thruster->n_T_S, 3);
        for (int k = 0; k < 3; k++) {
            thruster->p_ST_m[k] = clamped(thruster->p_ST_m[k], -10, 10);
        }
    }
    repair_moments(scenario->vehicle.body.inertia_kg_m2);
    repair_moments(scenario->beam.body.inertia_kg_m2);
    const double hull_m = scenario->vehicle.radius_m, outside_m = fmin(20, hull_m + scenario->beam.radius_m);
    if (scenario->standoff_m != hull_m) {
        scenario->standoff_m = fmax(scenario->standoff_m, outside_m);
    }
    to_unit_length(scenario->X_IS.q, 4);
    to_unit_length(scenario->X_IB.q, 4);
    to_unit_length(scenario->port.axis_I, 3);
    if (scenario->weight_time_per_s < 0x1p-32 && scenario->weight_impulse_per_Ns < 0x1p-32) {
        scenario->weight_impulse_per_Ns = 0x1p-32; // the smallest number of the fixed scalar, where less is zero
    }
    scenario->asker.epoch_us = scenario->asker.epoch_us < 0 ? 0 : scenario->asker.epoch_us;
    scenario->contact = (int8_t)clamped(scenario->contact, 0, 2);

    lcm_ssv_options_t* options = &scenario->options;
    options->method =
        (int8_t)clamped(options->method, LCM_SSV_OPTIONS_T_METHOD_OPTIMAL, LCM_SSV_OPTIONS_T_METHOD_PAPER);
    options->effort = (int8_t)clamped(options->effort, LCM_SSV_OPTIONS_T_EFFORT_QUICK, LCM_SSV_OPTIONS_T_EFFORT_BEST);
    options->num_attach_heights = (int8_t)clamped(options->num_attach_heights, 0, 8);
    // Half a length, one unit of the fixed scalar inwards: there the two round each for itself.
    const double half_m = scenario->beam.length_m / 2, inner_m = half_m - 0x1p-32;
    for (int i = 0; i < 8; i++) {
        if (fabs(options->attach_heights_m[i]) != half_m) {
            options->attach_heights_m[i] = clamped(options->attach_heights_m[i], -inner_m, inner_m);
        }
    }
    if (options->effort == LCM_SSV_OPTIONS_T_EFFORT_BEST) {
        options->attach_anywhere = 0;
        options->num_attach_heights = (int8_t)clamped(options->num_attach_heights, 0, 2);
    }
    if (options->effort == LCM_SSV_OPTIONS_T_EFFORT_BEST || options->attach_anywhere) {
        options->want_front = 0;
    }
}
