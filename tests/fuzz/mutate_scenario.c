// libFuzzer's mutator for scenarios and batches of them: most of the time it sets whole numbers to legal values, with a
// liking for the ends of their ranges; else it leaves the bytes to libFuzzer.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scenario_fields.h"
#include "ssv/answer.h"

// What libFuzzer gives and asks for; clang has no header for it in C.
size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);
size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned seed);

static uint64_t random_state;

static uint64_t random_bits(void) { // splitmix64
    uint64_t z = random_state += 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return z ^ z >> 31;
}

static int random_below(int n) { return (int)(random_bits() % (uint64_t)n); }

static double random_unit(void) { return (double)(random_bits() >> 11) * 0x1p-53; }

/// A legal value of the range: an end, next to an end, zero, of any order of size, evenly drawn, or near the old value.
static double random_value(double old, double min, double max) {
    const double largest = fmax(fabs(min), fabs(max));
    const double sign = min < 0 && random_below(2) ? -1 : 1;
    double x = 0;
    switch (random_below(8)) {
        case 0: x = min; break;
        case 1: x = max; break;
        case 2: x = 0; break;
        case 3: x = sign * largest * exp(-30 * random_unit()); break;
        case 4: x = sign * 0x1p-32 * random_below(9); break; // units of the fixed scalar
        case 5: x = min + (max - min) * random_unit(); break;
        case 6: x = old * (1 + 1e-6 * (random_unit() - 0.5)); break;
        default: x = old * exp(4 * (random_unit() - 0.5)); break;
    }
    return fmin(fmax(x, min), max);
}

/// Positions of all thrusters by one factor, or one of them moved or turned a little: most layouts drawn freely could
/// not hold every force.
static void mutate_thrusters(lcm_ssv_vehicle_t* vehicle) {
    const double factor = exp(4 * (random_unit() - 0.5));
    const int some = random_below(12); // one of them, or all
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < 3; k++) {
            if (some >= 6) {
                vehicle->thruster[i].p_ST_m[k] *= factor;
            } else if (some == i) {
                vehicle->thruster[i].p_ST_m[k] += 0.1 * (random_unit() - 0.5);
                vehicle->thruster[i].n_T_S[k] += 0.2 * (random_unit() - 0.5);
            }
        }
    }
}

/// Start, beam and port upon each other, or nearly so.
static void mutate_to_coincide(lcm_ssv_scenario_t* scenario) {
    const double apart = random_below(2) ? 0 : exp(-30 * random_unit());
    for (int k = 0; k < 3; k++) {
        scenario->X_IS.p_m[k] = scenario->X_IB.p_m[k] + apart;
        scenario->port.p_IP_m[k] = scenario->X_IB.p_m[k] - apart;
    }
}

static void mutate_options(lcm_ssv_options_t* options) {
    switch (random_below(7)) {
        case 0: options->method = (int8_t)random_below(2); break;
        case 1: options->effort = (int8_t)(random_below(4) == 0); break; // best is slow
        case 2: options->num_attach_heights = (int8_t)random_below(9); break;
        case 3: options->attach_anywhere = (int8_t)(random_below(4) == 0); break;
        case 4: options->ring_angle_given = (int8_t)random_below(2); break;
        case 5: options->want_candidates = (int8_t)random_below(2); break;
        default: options->want_front = (int8_t)(random_below(4) == 0); break;
    }
}

static void mutate_numbers(lcm_ssv_scenario_t* scenario) {
    const scenario_field_t* field = &scenario_fields[random_below(num_scenario_fields)];
    double* number = scenario_field_of(scenario, field);
    const int all = random_below(2); // numbers of the field, or one
    const int one = random_below(field->count);
    for (int i = 0; i < field->count; i++) {
        if (all || i == one) {
            number[i] = random_value(number[i], field->min, field->max);
        }
    }
}

static void mutate_heights(lcm_ssv_scenario_t* scenario) {
    const double half_m = scenario->beam.length_m / 2;
    for (int i = 0; i < 8; i++) {
        scenario->options.attach_heights_m[i] = random_value(0, -half_m, half_m);
    }
}

/// One obstacle more, less, or moved: near where something starts, ends or passes; or another tank.
static void mutate_scene(lcm_ssv_scenario_t* scenario, lcm_ssv_scene_t* scene) {
    const double* const places[] = {scenario->X_IS.p_m, scenario->X_IB.p_m, scenario->port.p_IP_m};
    const int number = random_below(scene->num_obstacles > 0 ? scene->num_obstacles : 1);
    lcm_ssv_obstacle_t* obstacle = &scene->obstacles[number];
    switch (random_below(8)) {
        case 0: scene->num_obstacles = (int8_t)random_below(65); break;
        case 1: scenario->obstacles = (int64_t)random_bits(); break;
        case 2: scenario->left = (int64_t)random_bits(); break;
        case 3: obstacle->kind = (int8_t)random_below(2); break;
        case 4: scene->tank.kind = (int8_t)random_below(3); break;
        case 5:
            for (int i = 0; i < 3; i++) {
                scene->tank.from_I_m[i] = random_value(-10, -1000, 1000);
                scene->tank.to_I_m[i] = random_value(10, -1000, 1000);
            }
            scene->tank.radius_m = random_value(10, 0.001, 1000);
            break;
        default:
            scene->num_obstacles = (int8_t)(scene->num_obstacles < 1 ? 1 : scene->num_obstacles);
            scenario->obstacles |= INT64_C(1) << number;
            for (int i = 0; i < 3; i++) {
                obstacle->p_I_m[i] = places[random_below(3)][i] + random_value(1, -10, 10);
                obstacle->axis_I[i] = 2 * random_unit() - 1;
            }
            obstacle->length_m = random_value(1, 0, 1000);
            obstacle->radius_m = random_value(0.1, 0, 100);
            break;
    }
}

static void mutate(lcm_ssv_scenario_t* scenario, lcm_ssv_scene_t* scene) {
    const int changes = 1 + random_below(3);
    for (int i = 0; i < changes; i++) {
        switch (random_below(20)) {
            case 0: mutate_thrusters(&scenario->vehicle); break;
            case 1: mutate_to_coincide(scenario); break;
            case 2: mutate_options(&scenario->options); break;
            case 3: mutate_heights(scenario); break;
            case 4: scenario->contact = (int8_t)random_below(3); break;
            case 5: // one weight alone
                *(random_below(2) ? &scenario->weight_time_per_s : &scenario->weight_impulse_per_Ns) = 0;
                break;
            case 6:
            case 7:
            case 8:
            case 9: mutate_scene(scenario, scene); break;
            default: mutate_numbers(scenario); break;
        }
    }
    scenario_repair(scenario, scene);
}

size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned seed) {
    static lcm_ssv_scenario_t scenarios[SSV_MAX_BATCH];
    static lcm_ssv_scenario_batch_t batch;
    static lcm_ssv_task_t task;
    random_state = seed;
    if (random_below(16) != 0 && size <= INT32_MAX) {
        int encoded = -1;
        if (ssv_scenario_batch_decode(data, size, scenarios, &batch)) {
            mutate(&scenarios[random_below(batch.num_scenarios)], &batch.scene);
            encoded = lcm_ssv_scenario_batch_t_encode(data, 0, (int)max_size, &batch);
        } else if (lcm_ssv_task_t_decode(data, 0, (int)size, &task) == (int)size) {
            mutate(&task.scenario, &task.scene);
            encoded = lcm_ssv_task_t_encode(data, 0, (int)max_size, &task);
        }
        if (encoded > 0) {
            return (size_t)encoded;
        }
    }
    return LLVMFuzzerMutate(data, size, max_size);
}
