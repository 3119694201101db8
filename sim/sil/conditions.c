#include "conditions.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "wire/tree.h"

typedef struct {
    const char *group, *part, *key; ///< group.key, or group.part.key
    size_t offset;                  ///< in sim_world_config_t
    int count;                      ///< numbers; above 1 they stand in a list
} field_t;

#define FIELD(group, key, count) {#group, NULL, #key, offsetof(sim_world_config_t, group.key), count}
#define PART(group, part, key, count) {#group, #part, #key, offsetof(sim_world_config_t, group.part.key), count}
#define ERRORS(part)                                                                                                   \
    PART(navigation, part, white, 1), PART(navigation, part, bias, 3), PART(navigation, part, walk_sqrt_s, 1)
#define LIMITS(group)                                                                                                  \
    FIELD(group, position_m, 1), FIELD(group, angle_rad, 1), FIELD(group, speed_m_s, 1), FIELD(group, rate_rad_s, 1)

static const field_t fields[] = {
    FIELD(water, mean_n_m_s, 3),
    FIELD(water, wander_m_s, 3),
    FIELD(water, wander_time_s, 1),
    FIELD(thrusters, quantum, 1),
    FIELD(thrusters, dead_band, 1),
    FIELD(thrusters, gain_error, SIM_THRUSTERS),
    FIELD(thrusters, gain_spread, 1),
    FIELD(thrusters, force_forward_max_N, 1),
    FIELD(thrusters, force_reverse_max_N, 1),
    FIELD(thrusters, lag_s, 1),
    PART(thrusters, curve, voltage_ratio, 1),
    PART(thrusters, curve, voltage_exponent, 1),
    FIELD(navigation, rate_Hz, 1),
    FIELD(navigation, delay_s, 1),
    FIELD(navigation, dropout, 1),
    ERRORS(position_m),
    ERRORS(attitude_rad),
    ERRORS(velocity_m_s),
    ERRORS(rate_rad_s),
    LIMITS(mate_limit),
    LIMITS(dock_limit),
};
#define NUM_FIELDS ((int)(sizeof fields / sizeof *fields))

static bool is_number(const tree_t* value) {
    return (value->kind == TREE_REAL || value->kind == TREE_INTEGER) && isfinite(value->real);
}

static bool read_numbers(tree_error_t* error, const tree_t* value, int count, double* out) {
    if (count == 1) {
        if (!is_number(value)) return tree_fail(error, value, "must be a number");
        *out = value->real;
        return true;
    }
    if (value->kind != TREE_LIST || value->count != count)
        return tree_fail(error, value, "must be a list of %d numbers", count);
    for (int i = 0; i < count; i++) {
        if (!is_number(value->entries[i].value)) return tree_fail(error, value->entries[i].value, "must be a number");
        out[i] = value->entries[i].value->real;
    }
    return true;
}

// The curve is the one thing of as many numbers as one likes: two lists, as long as each other.
static bool read_points(tree_error_t* error, const tree_t* value, sim_curve_t* curve, double* out) {
    if (value->kind != TREE_LIST || value->count < 2 || value->count > SIM_CURVE_POINTS)
        return tree_fail(error, value, "must be a list of 2 to %d numbers", SIM_CURVE_POINTS);
    if (curve->num_points != 0 && curve->num_points != value->count)
        return tree_fail(error, value, "must be as long as the other list of the curve");
    curve->num_points = value->count;
    return read_numbers(error, value, value->count, out);
}

static const field_t* find(const char* group, const char* part, const char* key) {
    for (int i = 0; i < NUM_FIELDS; i++) {
        const field_t* field = &fields[i];
        if (strcmp(field->group, group) == 0 && (field->part == NULL) == (part == NULL) &&
            (part == NULL || strcmp(field->part, part) == 0) && (key == NULL || strcmp(field->key, key) == 0))
            return field;
    }
    return NULL;
}

static bool read_map(tree_error_t* error, const tree_t* map, const char* group, const char* part,
                     sim_world_config_t* world) {
    sim_curve_t* curve = &world->thrusters.curve;
    const bool is_curve = part != NULL && strcmp(part, "curve") == 0;
    if (map->kind != TREE_MAP) return tree_fail(error, map, "must be a map");
    for (int i = 0; i < map->count; i++) {
        const tree_entry_t* entry = &map->entries[i];
        const field_t* field = find(group, part, entry->key);
        bool fine;
        if (field != NULL) {
            fine = read_numbers(error, entry->value, field->count,
                                (double*)(void*)((unsigned char*)world + field->offset));
        } else if (is_curve && strcmp(entry->key, "effort") == 0) {
            fine = read_points(error, entry->value, curve, curve->effort);
        } else if (is_curve && strcmp(entry->key, "force_N") == 0) {
            fine = read_points(error, entry->value, curve, curve->force_N);
        } else if (part == NULL && find(group, entry->key, NULL) != NULL) {
            fine = read_map(error, entry->value, group, entry->key, world);
        } else {
            fine = tree_fail_key(error, map, entry, entry->key, "is no condition");
        }
        if (!fine) return false;
    }
    if (is_curve && (tree_get(map, "effort") == NULL) != (tree_get(map, "force_N") == NULL))
        return tree_fail(error, map, "must have effort and force_N, or neither");
    return true;
}

static bool is_group(const char* key) {
    for (int i = 0; i < NUM_FIELDS; i++) {
        if (strcmp(fields[i].group, key) == 0) return true;
    }
    return false;
}

static bool read_all(tree_error_t* error, const tree_t* root, sim_world_config_t* world) {
    if (root->kind == TREE_NULL) return true; // an empty file disturbs nothing
    if (root->kind != TREE_MAP) return tree_fail(error, root, "must be a map");
    for (int i = 0; i < root->count; i++) {
        const tree_entry_t* entry = &root->entries[i];
        if (!is_group(entry->key)) return tree_fail_key(error, root, entry, entry->key, "is no group of conditions");
        if (!read_map(error, entry->value, entry->key, NULL, world)) return false;
    }
    return true;
}

bool conditions_read(const char* path, sim_world_config_t* world, char* error, size_t error_size) {
    tree_error_t fault = {.text = error, .size = error_size};
    tree_memory_t memory = {NULL};
    size_t size;
    error[0] = '\0';
    char* text = tree_file_read(path, &size, &fault);
    const tree_t* root = text == NULL ? NULL : tree_from_yaml(&memory, &fault, path, text, size);
    const bool fine = root != NULL && read_all(&fault, root, world);
    tree_memory_free(&memory);
    free(text);
    return fine;
}
