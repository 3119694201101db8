// The friendly layout of scenario and model files, laid out as the message.
#define _POSIX_C_SOURCE 200809L
#include "scenario_file.h"

#include <dirent.h>
#include <inttypes.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ssv/planner.h"
#include "wire/message.h"

/// Of a hub.
#define MAX_PORTS 8
#define NAMES_MAX 64
/// Keys of a scenario that are dealt with one by one.
#define FIXED_KEYS 13
#define LENGTH(array) ((int)(sizeof(array) / sizeof(array)[0]))

/// What is being laid out.
typedef struct {
    tree_memory_t* memory;
    tree_error_t* error;
    const char* models_dir;
} layout_t;

/// A key of a file, and where the message has what stands there: the key `to` of a map. No map: it is dealt with by
/// hand.
typedef struct {
    const char* from;
    bool required;
    tree_t* map;
    const char* to;
} move_t;

/// A map of the message, which takes the fields of its type by their own names.
typedef struct {
    tree_t* map;
    const char* type;
} target_t;

/// A value that no file has, at the place of one that it follows from.
static tree_t* derived(layout_t* layout, tree_kind_t kind, const tree_t* from) {
    tree_t* const value = tree_memory_take(layout->memory, sizeof *value);
    if (value == NULL) {
        tree_fail(layout->error, from, "out of memory");
        return NULL;
    }
    value->kind = kind;
    value->file = from->file;
    value->line = from->line;
    value->column = from->column;
    value->parent = from->parent;
    value->key = from->key;
    value->index = from->index;
    return value;
}

static bool put(layout_t* layout, tree_t* map, const char* key, const tree_t* value) {
    if (value == NULL || map == NULL) {
        return false;
    }
    if (tree_get(map, key) != NULL) {
        return tree_fail(layout->error, tree_get(map, key), "given twice, or it follows from other keys; leave it out");
    }
    return tree_graft(layout->memory, map, key, value) || tree_fail(layout->error, value, "out of memory");
}

static bool put_integer(layout_t* layout, tree_t* map, const char* key, int64_t integer, const tree_t* from) {
    tree_t* const value = derived(layout, TREE_INTEGER, from);
    if (value != NULL) {
        value->integer = integer;
        value->real = (double)integer;
    }
    return put(layout, map, key, value);
}

static bool put_text(layout_t* layout, tree_t* map, const char* key, const char* text, const tree_t* from) {
    tree_t* const value = derived(layout, TREE_TEXT, from);
    if (value != NULL) {
        value->text = text;
    }
    return put(layout, map, key, value);
}

/// 64 bits as the message has them in a file.
static bool put_bits(layout_t* layout, tree_t* map, const char* key, uint64_t bits, const tree_t* from) {
    char* const text = tree_memory_take(layout->memory, 17);
    if (text == NULL) {
        return tree_fail(layout->error, from, "out of memory");
    }
    snprintf(text, 17, "%016" PRIx64, bits);
    return put_text(layout, map, key, text, from);
}

static bool put_real(layout_t* layout, tree_t* map, const char* key, double real, const tree_t* from) {
    tree_t* const value = derived(layout, TREE_REAL, from);
    if (value != NULL) {
        value->real = real;
    }
    return put(layout, map, key, value);
}

static bool put_reals(layout_t* layout, tree_t* map, const char* key, const double* reals, int count,
                      const tree_t* from) {
    tree_t* const list = derived(layout, TREE_LIST, from);
    bool sound = list != NULL;
    for (int i = 0; i < count && sound; i++) {
        tree_t* const value = derived(layout, TREE_REAL, from);
        sound = value != NULL && tree_graft(layout->memory, list, NULL, value);
        if (sound) {
            value->real = reals[i];
        }
    }
    return sound && put(layout, map, key, list);
}

/// A map of the message for what stands in a map of a file, so that faults of it are told by the file's words.
static tree_t* map_for(layout_t* layout, tree_t* within, const char* key, const tree_t* from) {
    tree_t* const map = derived(layout, TREE_MAP, from);
    return put(layout, within, key, map) ? map : NULL;
}

static bool unknown_key(layout_t* layout, const tree_t* from, const tree_entry_t* entry, const char* const* known,
                        int count) {
    const char* const nearest = tree_nearest(entry->key, known, count);
    return nearest != NULL
               ? tree_fail_key(layout->error, from, entry, entry->key, "unknown key; did you mean %s?", nearest)
               : tree_fail_key(layout->error, from, entry, entry->key, "unknown key");
}

static bool lay_out_entry(layout_t* layout, const tree_t* from, const tree_entry_t* entry, const move_t* moves,
                          int num_moves, const target_t* targets, int num_targets) {
    const char* known[NAMES_MAX];
    int count = 0;
    for (int i = 0; i < num_moves; i++) {
        known[count++] = moves[i].from;
        if (strcmp(moves[i].from, entry->key) == 0) {
            return moves[i].map == NULL || put(layout, moves[i].map, moves[i].to, entry->value);
        }
    }
    for (int i = 0; i < num_targets; i++) {
        const int first = count;
        count += wire_field_names(targets[i].type, &known[count], NAMES_MAX - count);
        for (int k = first; k < count; k++) {
            if (strcmp(known[k], entry->key) == 0) {
                return put(layout, targets[i].map, entry->key, entry->value);
            }
        }
    }
    return unknown_key(layout, from, entry, known, count);
}

/// Lays out a map of a file: the keys of the table by it, all others by their own names in the target whose type has
/// them.
static bool lay_out(layout_t* layout, const tree_t* from, const move_t* moves, int num_moves, const target_t* targets,
                    int num_targets) {
    if (from->kind != TREE_MAP) {
        return tree_fail(layout->error, from, "not a map of keys and values");
    }
    for (int i = 0; i < from->count; i++) {
        if (!lay_out_entry(layout, from, &from->entries[i], moves, num_moves, targets, num_targets)) {
            return false;
        }
    }
    for (int i = 0; i < num_moves; i++) {
        if (moves[i].required && tree_get(from, moves[i].from) == NULL) {
            return tree_fail_key(layout->error, from, NULL, moves[i].from, "this key is missing");
        }
    }
    return true;
}

/// A text for a file's name, kept as long as the trees that name it.
static const char* keep_text(layout_t* layout, const char* text) {
    const size_t size = strlen(text) + 1;
    char* const kept = tree_memory_take(layout->memory, size);
    return kept == NULL ? NULL : memcpy(kept, text, size);
}

/// What a text holds that stands in a file, "-" being standard input.
static const tree_t* parse(layout_t* layout, const char* path, const char* text, size_t size) {
    const char* const shown = strcmp(path, "-") == 0 ? "standard input" : keep_text(layout, path);
    return shown == NULL ? NULL : tree_from_yaml(layout->memory, layout->error, shown, text, size);
}

// Models.

/// Whether the water's drag on a body is written down: each of its drag keys, or the word that there is none.
static bool lay_out_drag(layout_t* layout, const tree_t* from, const target_t* targets, int num_targets) {
    const tree_t* const drag = tree_get(from, "drag");
    if (drag != NULL && (drag->kind != TREE_TEXT || strcmp(drag->text, "none") != 0)) {
        return tree_fail(layout->error, drag, "only none may stand here, for a body that feels no water");
    }
    const char* names[NAMES_MAX];
    tree_t* maps[NAMES_MAX];
    int count = 0;
    for (int i = 0; i < num_targets; i++) {
        const char* all[NAMES_MAX];
        const int num_all = wire_field_names(targets[i].type, all, NAMES_MAX);
        for (int k = 0; k < num_all; k++) {
            if (strncmp(all[k], "drag_", 5) == 0) {
                names[count] = all[k];
                maps[count++] = targets[i].map;
            }
        }
    }
    for (int i = 0; i < count; i++) {
        const bool given = tree_get(from, names[i]) != NULL;
        if (given && drag != NULL) {
            return tree_fail(layout->error, tree_get(from, names[i]),
                             "drag: none stands there, too; leave one of them out");
        }
        if (!given && drag == NULL) {
            return tree_fail_key(
                layout->error, from, NULL, names[i],
                "this key is missing; give all %d drag keys (0 is a value), or `drag: none` for a body that "
                "feels no water",
                count);
        }
        if (!given && !put_real(layout, maps[i], names[i], 0, drag)) {
            return false;
        }
    }
    return true;
}

/// A vehicle or a beam: the keys of its body stand beside its own.
static bool lay_out_body(layout_t* layout, const tree_t* from, const char* key, const char* type, tree_t* message) {
    static const double none[3] = {0, 0, 0};
    tree_t* const thing = map_for(layout, message, key, from);
    tree_t* const body = map_for(layout, thing, "body", from);
    if (body == NULL) {
        return false;
    }
    const move_t moves[] = {{"drag", false, NULL, NULL}, {"thrusters", true, thing, "thruster"}};
    const target_t targets[] = {{body, "body_t"}, {thing, type}};
    const int num_moves = strcmp(type, "vehicle_t") == 0 ? 2 : 1; // a beam has no thrusters
    return lay_out(layout, from, moves, num_moves, targets, LENGTH(targets)) &&
           lay_out_drag(layout, from, targets, LENGTH(targets)) &&
           (tree_get(body, "added_mass_kg") != NULL || put_reals(layout, body, "added_mass_kg", none, 3, from));
}

static int is_model_file(const struct dirent* entry) {
    const char* const dot = strrchr(entry->d_name, '.');
    return dot != NULL && strcmp(dot, ".yaml") == 0;
}

/// Says which models there are.
static bool unknown_model(layout_t* layout, const tree_t* model) {
    char names[256] = "";
    struct dirent** entries = NULL;
    const int count = scandir(layout->models_dir, &entries, is_model_file, alphasort);
    for (int i = 0; i < count; i++) {
        const size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%.*s", i > 0 ? ", " : "",
                 (int)(strrchr(entries[i]->d_name, '.') - entries[i]->d_name), entries[i]->d_name);
        free(entries[i]);
    }
    free(entries);
    return tree_fail(layout->error, model,
                     "'%.64s' is none of the models (%s) in %s; give one of your own by its path, %.64s.yaml",
                     model->text, names, layout->models_dir, model->text);
}

/// A path from the folder of the scenario file. @return whether it fits.
static bool path_from(const char* scenario_path, const char* text, char* path, size_t size) {
    const char* const slash = strrchr(scenario_path, '/');
    const int folder_length = slash == NULL || text[0] == '/' ? 0 : (int)(slash + 1 - scenario_path);
    const int written = snprintf(path, size, "%.*s%s", folder_length, scenario_path, text);
    return written >= 0 && (size_t)written < size;
}

/// The model's file: a name stands for one in models_dir, anything with a slash or .yaml is a path from the scenario
/// file.
static bool model_path(layout_t* layout, const tree_t* model, const char* scenario_path, char* path, size_t size) {
    if (model->kind != TREE_TEXT || model->text[0] == '\0') {
        return tree_fail(layout->error, model, "neither the name of a model nor a path to one");
    }
    const size_t length = strlen(model->text);
    const bool has_suffix = length > 5 && strcmp(model->text + length - 5, ".yaml") == 0;
    const bool is_path = has_suffix || strchr(model->text, '/') != NULL;
    const int written = is_path ? 0 : snprintf(path, size, "%s/%s.yaml", layout->models_dir, model->text);
    const bool fits =
        is_path ? path_from(scenario_path, model->text, path, size) : written >= 0 && (size_t)written < size;
    if (!fits) {
        return tree_fail(layout->error, model, "the path is too long");
    }
    return is_path || access(path, F_OK) == 0 || unknown_model(layout, model);
}

/// What a file holds that another one names. @return NULL with the error set.
static const tree_t* read_file(layout_t* layout, const char* path) {
    size_t size = 0;
    char* const text = tree_file_read(path, &size, layout->error);
    const tree_t* const root = text == NULL ? NULL : parse(layout, path, text, size);
    free(text);
    return root;
}

/// Reads the model and lays out its vehicle and its beam. @return the file's tree; NULL with the error set.
static const tree_t* lay_out_model(layout_t* layout, const tree_t* model, const char* scenario_path, tree_t* message) {
    char path[PATH_MAX];
    if (!model_path(layout, model, scenario_path, path, sizeof path)) {
        return NULL;
    }
    const tree_t* const root = read_file(layout, path);
    if (root == NULL) {
        return NULL;
    }
    // Before anything of a file that is none is repeated.
    if (tree_get(root, "vehicle") == NULL && tree_get(root, "beam") == NULL) {
        tree_fail(layout->error, root, "no model, which has the keys vehicle, beam and hub");
        return NULL;
    }
    const move_t moves[] = {{"vehicle", true, NULL, NULL}, {"beam", true, NULL, NULL}, {"hub", false, NULL, NULL}};
    return lay_out(layout, root, moves, LENGTH(moves), NULL, 0) &&
                   lay_out_body(layout, tree_get(root, "vehicle"), "vehicle", "vehicle_t", message) &&
                   lay_out_body(layout, tree_get(root, "beam"), "beam", "beam_t", message)
               ? root
               : NULL;
}

// The hub, of which the planner sees the port, and what is to be avoided.

static bool as_number(layout_t* layout, const tree_t* value, double* number) {
    *number = value->real;
    if (value->kind != TREE_INTEGER && value->kind != TREE_REAL) {
        return tree_fail(layout->error, value, "'%.40s' is not a number", value->text == NULL ? "" : value->text);
    }
    return isfinite(value->real) || tree_fail(layout->error, value, "%s is not a finite number",
                                              isnan(value->real) ? "nan"
                                              : value->real < 0  ? "-inf"
                                                                 : "inf");
}

/// A list of numbers under a key of a map.
static bool read_numbers(layout_t* layout, const tree_t* map, const char* key, int count, double* numbers) {
    const tree_t* const list = tree_get(map, key);
    for (int i = 0; i < count; i++) {
        numbers[i] = 0;
    }
    if (list == NULL) {
        return tree_fail_key(layout->error, map, NULL, key, "this key is missing");
    }
    if (list->kind != TREE_LIST || list->count != count) {
        return tree_fail(layout->error, list, "%d entries, there must be exactly %d", list->count, count);
    }
    for (int i = 0; i < count; i++) {
        if (!as_number(layout, list->entries[i].value, &numbers[i])) {
            return false;
        }
    }
    return true;
}

/// A number under a key of a map, which is there.
static bool read_number(layout_t* layout, const tree_t* map, const char* key, double* number) {
    return as_number(layout, tree_get(map, key), number);
}

static bool check_unit(layout_t* layout, const tree_t* list, const double* numbers, int count) {
    double square = 0;
    for (int i = 0; i < count; i++) {
        square += numbers[i] * numbers[i];
    }
    const double tolerance = real_to_double(SSV_UNIT_TOLERANCE);
    return fabs(sqrt(square) - 1) <= tolerance ||
           tree_fail(layout->error, list, "length %.9g is not 1 within %.3g", sqrt(square), tolerance);
}

/// v turned by the attitude q. Plain doubles: this file serves programs of every scalar, and ssv/vec3.h is that of one.
static void turn(const double q[4], const double v[3], double turned[3]) {
    const double n = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const double w = q[0] / n, e[3] = {q[1] / n, q[2] / n, q[3] / n};
    double t[3];
    for (int i = 0, j = 1, k = 2; i < 3; i++, j = (j + 1) % 3, k = (k + 1) % 3) {
        t[i] = 2 * (e[j] * v[k] - e[k] * v[j]);
    }
    for (int i = 0, j = 1, k = 2; i < 3; i++, j = (j + 1) % 3, k = (k + 1) % 3) {
        turned[i] = v[i] + (w * t[i] + (e[j] * t[k] - e[k] * t[j]));
    }
}

/// A direction of the file in three numbers of length 1.
static bool read_direction(layout_t* layout, const tree_t* map, const char* key, double direction[3]) {
    if (!read_numbers(layout, map, key, 3, direction) || !check_unit(layout, tree_get(map, key), direction, 3)) {
        return false;
    }
    const double length = hypot(hypot(direction[0], direction[1]), direction[2]);
    for (int i = 0; i < 3; i++) {
        direction[i] /= length;
    }
    return true;
}

/// A hub where it stands.
typedef struct {
    double p_IH_m[3], p_IP_m[MAX_PORTS][3], axis_I[MAX_PORTS][3];
    int num_ports;
    int port;               ///< [0, num_ports) that the scenario names
    const tree_t* radius_m; ///< of its sphere; NULL if the model does not say
} hub_t;

/// The ports of a model's hub, all of which must make sense.
static bool read_ports(layout_t* layout, const tree_t* hub, double p_HP_m[MAX_PORTS][3], double axis_H[MAX_PORTS][3],
                       int* num_ports) {
    const move_t of_hub[] = {{"ports", true, NULL, NULL}, {"radius_m", false, NULL, NULL}};
    const move_t of_port[] = {{"p_HP_m", true, NULL, NULL}, {"axis_H", true, NULL, NULL}};
    if (!lay_out(layout, hub, of_hub, LENGTH(of_hub), NULL, 0)) {
        return false;
    }
    const tree_t* const ports = tree_get(hub, "ports");
    if (ports->kind != TREE_LIST || ports->count < 1 || ports->count > MAX_PORTS) {
        return tree_fail(layout->error, ports, "%d entries, there must be 1 to %d", ports->count, MAX_PORTS);
    }
    *num_ports = ports->count;
    for (int i = 0; i < ports->count; i++) {
        const tree_t* const port = ports->entries[i].value;
        if (!lay_out(layout, port, of_port, LENGTH(of_port), NULL, 0) ||
            !read_numbers(layout, port, "p_HP_m", 3, p_HP_m[i]) ||
            !read_numbers(layout, port, "axis_H", 3, axis_H[i]) ||
            !check_unit(layout, tree_get(port, "axis_H"), axis_H[i], 3)) {
            return false;
        }
    }
    return true;
}

/// The number of a port, counted from 0.
static bool read_port(layout_t* layout, const tree_t* number, int num_ports, int* port) {
    if (number->kind != TREE_INTEGER || number->integer < 1 || number->integer > num_ports) {
        char all[3 * MAX_PORTS + 1] = "";
        for (int i = 0; i < num_ports; i++) {
            const size_t used = strlen(all);
            snprintf(all + used, sizeof all - used, "%s%d", i > 0 ? ", " : "", i + 1);
        }
        return tree_fail(layout->error, number, "'%.40s' is none of %s", number->text == NULL ? "" : number->text, all);
    }
    *port = (int)number->integer - 1;
    return true;
}

/// The hub in I from its pose (scenario file) and the ports in H (model file).
static bool read_hub(layout_t* layout, const tree_t* from, const tree_t* model, hub_t* hub) {
    const move_t moves[] = {{"p_IH_m", true, NULL, NULL}, {"q_IH", true, NULL, NULL}, {"port", true, NULL, NULL}};
    double q_IH[4] = {0}, p_HP_m[MAX_PORTS][3] = {{0}}, axis_H[MAX_PORTS][3] = {{0}};
    if (!lay_out(layout, from, moves, LENGTH(moves), NULL, 0) ||
        !read_numbers(layout, from, "p_IH_m", 3, hub->p_IH_m) || !read_numbers(layout, from, "q_IH", 4, q_IH) ||
        !check_unit(layout, tree_get(from, "q_IH"), q_IH, 4)) {
        return false;
    }
    if (tree_get(model, "hub") == NULL) {
        return tree_fail_key(layout->error, model, NULL, "hub", "this key is missing; the scenario names a port of it");
    }
    if (!read_ports(layout, tree_get(model, "hub"), p_HP_m, axis_H, &hub->num_ports) ||
        !read_port(layout, tree_get(from, "port"), hub->num_ports, &hub->port)) {
        return false;
    }
    hub->radius_m = tree_get(tree_get(model, "hub"), "radius_m");
    for (int k = 0; k < hub->num_ports; k++) {
        turn(q_IH, p_HP_m[k], hub->p_IP_m[k]);
        turn(q_IH, axis_H[k], hub->axis_I[k]);
        for (int i = 0; i < 3; i++) {
            hub->p_IP_m[k][i] += hub->p_IH_m[i];
        }
    }
    return true;
}

static bool lay_out_hub(layout_t* layout, const tree_t* from, const hub_t* hub, tree_t* message) {
    tree_t* const port = map_for(layout, message, "port", from);
    return put_reals(layout, port, "p_IP_m", hub->p_IP_m[hub->port], 3, from) &&
           put_reals(layout, port, "axis_I", hub->axis_I[hub->port], 3, from);
}

// What stands around.

/// A new map at the end of a list of the message.
static tree_t* add_map(layout_t* layout, tree_t* list, const tree_t* from) {
    tree_t* const map = derived(layout, TREE_MAP, from);
    if (map != NULL && !tree_graft(layout->memory, list, NULL, map)) {
        tree_fail(layout->error, from, "out of memory");
        return NULL;
    }
    return map;
}

/// An obstacle on a line; NULL stands for what the file says by the same key.
static bool put_obstacle(layout_t* layout, tree_t* list, const char* kind, const tree_t* from, const double* p_I_m,
                         const double axis_I[3], double length_m, const tree_t* radius_m) {
    tree_t* const map = add_map(layout, list, from);
    return map != NULL && put_text(layout, map, "kind", kind, from) &&
           (p_I_m != NULL ? put_reals(layout, map, "p_I_m", p_I_m, 3, from)
                          : put(layout, map, "p_I_m", tree_get(from, "p_I_m"))) &&
           put_reals(layout, map, "axis_I", axis_I, 3, from) && put_real(layout, map, "length_m", length_m, from) &&
           (radius_m != NULL ? put(layout, map, "radius_m", radius_m) : put_real(layout, map, "radius_m", 0, from));
}

static bool lay_out_sphere(layout_t* layout, const tree_t* from, tree_t* list) {
    static const double no_axis[3] = {0, 0, 0};
    const move_t moves[] = {{"p_I_m", true, NULL, NULL}, {"radius_m", true, NULL, NULL}};
    return lay_out(layout, from, moves, LENGTH(moves), NULL, 0) &&
           put_obstacle(layout, list, "capsule", from, NULL, no_axis, 0, tree_get(from, "radius_m"));
}

/// From an end of its line to the other one, or along an axis.
static bool lay_out_capsule(layout_t* layout, const tree_t* from, tree_t* list) {
    const bool has_end = tree_get(from, "to_I_m") != NULL;
    const move_t moves[] = {{"p_I_m", true, NULL, NULL},
                            {"radius_m", true, NULL, NULL},
                            {"to_I_m", false, NULL, NULL},
                            {"axis_I", !has_end, NULL, NULL},
                            {"length_m", !has_end, NULL, NULL}};
    double from_m[3] = {0}, to_m[3] = {0}, axis_I[3] = {0}, length_m = 0;
    if (!lay_out(layout, from, moves, LENGTH(moves), NULL, 0) || !read_numbers(layout, from, "p_I_m", 3, from_m)) {
        return false;
    }
    if (!has_end) {
        return read_direction(layout, from, "axis_I", axis_I) && read_number(layout, from, "length_m", &length_m) &&
               put_obstacle(layout, list, "capsule", from, NULL, axis_I, length_m, tree_get(from, "radius_m"));
    }
    if (tree_get(from, "axis_I") != NULL || tree_get(from, "length_m") != NULL) {
        return tree_fail(layout->error, tree_get(from, "to_I_m"),
                         "axis_I or length_m is given too; give the other end, or those two");
    }
    if (!read_numbers(layout, from, "to_I_m", 3, to_m)) {
        return false;
    }
    length_m = hypot(hypot(to_m[0] - from_m[0], to_m[1] - from_m[1]), to_m[2] - from_m[2]);
    for (int i = 0; i < 3 && length_m > 0; i++) {
        axis_I[i] = (to_m[i] - from_m[i]) / length_m;
    }
    return put_obstacle(layout, list, "capsule", from, NULL, axis_I, length_m, tree_get(from, "radius_m"));
}

static bool lay_out_wall(layout_t* layout, const tree_t* from, tree_t* list) {
    const move_t moves[] = {{"p_I_m", true, NULL, NULL}, {"axis_I", true, NULL, NULL}};
    double axis_I[3] = {0};
    return lay_out(layout, from, moves, LENGTH(moves), NULL, 0) && read_direction(layout, from, "axis_I", axis_I) &&
           put_obstacle(layout, list, "wall", from, NULL, axis_I, 0, NULL);
}

/// The one key of a map that says of what kind a thing is, and what stands under it. @return NULL with the error set.
static const tree_t* kind_of(layout_t* layout, const tree_t* from, const char* const* kinds, int count, int* kind) {
    if (from->kind != TREE_MAP || from->count != 1) {
        char all[128] = "";
        for (int i = 0; i < count; i++) {
            const size_t used = strlen(all);
            snprintf(all + used, sizeof all - used, "%s%s: {...}", i > 0 ? ", " : "", kinds[i]);
        }
        tree_fail(layout->error, from, "not one of %s", all);
        return NULL;
    }
    for (*kind = 0; *kind < count; (*kind)++) {
        if (strcmp(from->entries[0].key, kinds[*kind]) == 0) {
            return from->entries[0].value;
        }
    }
    unknown_key(layout, from, &from->entries[0], kinds, count);
    return NULL;
}

static bool lay_out_obstacles(layout_t* layout, const tree_t* from, tree_t* list) {
    static const char* const kinds[] = {"sphere", "capsule", "wall"};
    if (from->kind != TREE_LIST) {
        return tree_fail(layout->error, from, "not a list of obstacles");
    }
    if (from->count > SSV_MAX_OBSTACLES) {
        return tree_fail(layout->error, from, "%d entries, there may be %d at most", from->count, SSV_MAX_OBSTACLES);
    }
    for (int i = 0; i < from->count; i++) {
        int kind = 0;
        const tree_t* const shape = kind_of(layout, from->entries[i].value, kinds, LENGTH(kinds), &kind);
        if (shape == NULL || !(kind == 0   ? lay_out_sphere(layout, shape, list)
                               : kind == 1 ? lay_out_capsule(layout, shape, list)
                                           : lay_out_wall(layout, shape, list))) {
            return false;
        }
    }
    return true;
}

static bool lay_out_box(layout_t* layout, const tree_t* from, tree_t* tank) {
    const move_t moves[] = {{"from_I_m", true, tank, "from_I_m"}, {"to_I_m", true, tank, "to_I_m"}};
    return put_text(layout, tank, "kind", "box", from) && lay_out(layout, from, moves, LENGTH(moves), NULL, 0) &&
           put_real(layout, tank, "radius_m", 0, from);
}

static bool lay_out_cylinder(layout_t* layout, const tree_t* from, tree_t* tank) {
    const move_t moves[] = {
        {"p_I_m", true, tank, "from_I_m"}, {"height_m", true, NULL, NULL}, {"radius_m", true, tank, "radius_m"}};
    double lid_m[3] = {0}, height_m = 0;
    if (!put_text(layout, tank, "kind", "cylinder", from) || !lay_out(layout, from, moves, LENGTH(moves), NULL, 0) ||
        !read_numbers(layout, from, "p_I_m", 3, lid_m) || !read_number(layout, from, "height_m", &height_m)) {
        return false;
    }
    lid_m[2] += height_m;
    return put_reals(layout, tank, "to_I_m", lid_m, 3, tree_get(from, "height_m"));
}

static bool lay_out_tank(layout_t* layout, const tree_t* from, const tree_t* root, tree_t* scene) {
    static const char* const kinds[] = {"box", "cylinder"};
    static const double nowhere[3] = {0, 0, 0};
    tree_t* const tank = map_for(layout, scene, "tank", from == NULL ? root : from);
    int kind = 0;
    if (from == NULL) {
        return put_text(layout, tank, "kind", "none", root) && put_reals(layout, tank, "from_I_m", nowhere, 3, root) &&
               put_reals(layout, tank, "to_I_m", nowhere, 3, root) && put_real(layout, tank, "radius_m", 0, root);
    }
    const tree_t* const shape = kind_of(layout, from, kinds, LENGTH(kinds), &kind);
    return shape != NULL && tank != NULL &&
           (kind == 0 ? lay_out_box(layout, shape, tank) : lay_out_cylinder(layout, shape, tank));
}

/// What follows from the hub: its sphere, and the beams that are built on its other ports.
static bool lay_out_avoid(layout_t* layout, const tree_t* from, const hub_t* hub, const tree_t* message, tree_t* list) {
    static const double no_axis[3] = {0, 0, 0};
    const move_t moves[] = {{"hub", false, NULL, NULL}, {"built", false, NULL, NULL}};
    const tree_t* const beam_radius_m = tree_get(tree_get(message, "beam"), "radius_m");
    double beam_length_m = 0;
    bool is_built[MAX_PORTS] = {false};
    if (!lay_out(layout, from, moves, LENGTH(moves), NULL, 0) ||
        !read_number(layout, tree_get(message, "beam"), "length_m", &beam_length_m)) {
        return false;
    }
    const tree_t* const sphere = tree_get(from, "hub");
    const tree_t* const built = tree_get(from, "built");
    if (sphere != NULL && sphere->kind != TREE_BOOLEAN) {
        return tree_fail(layout->error, sphere, "neither true nor false");
    }
    if (sphere != NULL && sphere->boolean && hub->radius_m == NULL) {
        return tree_fail(layout->error, sphere, "the model's hub has no radius_m");
    }
    if (sphere != NULL && sphere->boolean &&
        !put_obstacle(layout, list, "capsule", sphere, hub->p_IH_m, no_axis, 0, hub->radius_m)) {
        return false;
    }
    if (built != NULL && built->kind != TREE_LIST) {
        return tree_fail(layout->error, built, "not a list of ports");
    }
    for (int i = 0; built != NULL && i < built->count; i++) {
        const tree_t* const number = built->entries[i].value;
        int port = 0;
        if (!read_port(layout, number, hub->num_ports, &port)) {
            return false;
        }
        if (port == hub->port || is_built[port]) {
            return tree_fail(layout->error, number, "port %d is %s", port + 1,
                             is_built[port] ? "named twice" : "the one that the beam is to dock at");
        }
        is_built[port] = true;
        const double* const axis_I = hub->axis_I[port];
        const double length = hypot(hypot(axis_I[0], axis_I[1]), axis_I[2]);
        const double unit_I[3] = {axis_I[0] / length, axis_I[1] / length, axis_I[2] / length};
        if (!put_obstacle(layout, list, "capsule", number, hub->p_IP_m[port], unit_I, beam_length_m, beam_radius_m)) {
            return false;
        }
    }
    return true;
}

/// The obstacles that the vehicle lets go of, by their numbers.
static bool lay_out_left(layout_t* layout, const tree_t* root, int num_obstacles, tree_t* message) {
    const tree_t* const left = tree_get(root, "left");
    uint64_t bits = 0;
    if (left != NULL && left->kind != TREE_LIST) {
        return tree_fail(layout->error, left, "not a list of obstacles' numbers");
    }
    for (int i = 0; left != NULL && i < left->count; i++) {
        const tree_t* const number = left->entries[i].value;
        if (number->kind != TREE_INTEGER || number->integer < 0 || number->integer >= num_obstacles) {
            return tree_fail(layout->error, number, "'%.40s' is no number of an obstacle; there are %d, from 0 on",
                             number->text == NULL ? "" : number->text, num_obstacles);
        }
        bits |= UINT64_C(1) << number->integer;
    }
    return put_bits(layout, message, "left", bits, left == NULL ? root : left);
}

/// The scene of a file: in it, or in another one that it names. NULL in *scene if there is none.
static bool read_scene(layout_t* layout, const tree_t* root, const char* path, const tree_t** scene) {
    char scene_path[PATH_MAX];
    *scene = tree_get(root, "scene");
    if (*scene == NULL || (*scene)->kind == TREE_MAP) {
        return true;
    }
    if ((*scene)->kind != TREE_TEXT || (*scene)->text[0] == '\0') {
        return tree_fail(layout->error, *scene, "neither a map {obstacles, tank} nor a path to a file of one");
    }
    if (!path_from(path, (*scene)->text, scene_path, sizeof scene_path)) {
        return tree_fail(layout->error, *scene, "the path is too long");
    }
    *scene = read_file(layout, scene_path);
    return *scene != NULL;
}

/// The scene of the message, of which all counts, and what the scenario says of it. `hub` is NULL where the file names
/// the port itself.
static bool lay_out_scene(layout_t* layout, const tree_t* root, const char* path, const hub_t* hub, tree_t* message,
                          tree_t* scene) {
    const move_t moves[] = {{"obstacles", false, NULL, NULL}, {"tank", false, NULL, NULL}};
    const tree_t* const avoid = tree_get(root, "avoid");
    const tree_t* from = NULL;
    if (!read_scene(layout, root, path, &from) ||
        (from != NULL && !lay_out(layout, from, moves, LENGTH(moves), NULL, 0))) {
        return false;
    }
    const tree_t* const obstacles = tree_get(from, "obstacles");
    const tree_t* const place = obstacles != NULL ? obstacles : avoid != NULL ? avoid : root;
    tree_t* const list = derived(layout, TREE_LIST, place);
    if (list == NULL || (obstacles != NULL && !lay_out_obstacles(layout, obstacles, list))) {
        return false;
    }
    if (avoid != NULL && hub == NULL) {
        return tree_fail(layout->error, avoid, "hub is missing, of which this is; give obstacles in scene");
    }
    if (avoid != NULL && !lay_out_avoid(layout, avoid, hub, message, list)) {
        return false;
    }
    if (list->count > SSV_MAX_OBSTACLES) {
        return tree_fail(layout->error, avoid, "makes %d obstacles, there may be %d at most", list->count,
                         SSV_MAX_OBSTACLES);
    }
    const uint64_t all = list->count == 0 ? 0 : UINT64_MAX >> (SSV_MAX_OBSTACLES - list->count);
    return put_integer(layout, scene, "num_obstacles", list->count, place) && put(layout, scene, "obstacles", list) &&
           lay_out_tank(layout, tree_get(from, "tank"), root, scene) &&
           put_bits(layout, message, "obstacles", all, place) && lay_out_left(layout, root, list->count, message);
}

// Scenarios.

/// The beam's contact, as a number; 0 stands for either.
static bool lay_out_contact(layout_t* layout, const tree_t* contact, tree_t* message) {
    if (contact->kind == TREE_TEXT && strcmp(contact->text, "either") == 0) {
        return put_integer(layout, message, "contact", 0, contact);
    }
    if (contact->kind == TREE_INTEGER && (contact->integer == 1 || contact->integer == 2)) {
        return put(layout, message, "contact", contact);
    }
    return tree_fail(layout->error, contact, "'%.40s' is none of either, 1, 2",
                     contact->text == NULL ? "" : contact->text);
}

/// Heights come as many as they are; the message has room for the most, and counts them.
static bool lay_out_heights(layout_t* layout, const tree_t* heights, tree_t* options) {
    if (heights->kind != TREE_LIST || heights->count < 1 || heights->count > SSV_MAX_ATTACH_HEIGHTS) {
        return tree_fail(layout->error, heights, "%d entries, there must be 1 to %d", heights->count,
                         SSV_MAX_ATTACH_HEIGHTS);
    }
    tree_t* const all = derived(layout, TREE_LIST, heights);
    tree_t* const zero = derived(layout, TREE_REAL, heights);
    for (int i = 0; all != NULL && zero != NULL && i < SSV_MAX_ATTACH_HEIGHTS; i++) {
        if (!tree_graft(layout->memory, all, NULL, i < heights->count ? heights->entries[i].value : zero)) {
            return false;
        }
    }
    return put(layout, options, "attach_heights_m", all) &&
           put_integer(layout, options, "num_attach_heights", heights->count, heights);
}

/// Puts the message's zeros where the file says nothing: that is the default of every option.
static bool fill_options(layout_t* layout, tree_t* options) {
    const lcm_ssv_options_t zero = {0};
    json_t* const json = wire_to_json("options_t", &zero);
    char* const text = json_dumps(json, 0);
    const tree_t* const defaults =
        text == NULL ? NULL : tree_from_json(layout->memory, layout->error, NULL, text, strlen(text));
    json_decref(json);
    free(text);
    for (int i = 0; defaults != NULL && i < defaults->count; i++) {
        const tree_entry_t* const entry = &defaults->entries[i];
        if (tree_get(options, entry->key) == NULL && !put(layout, options, entry->key, entry->value)) {
            return false;
        }
    }
    return defaults != NULL;
}

/// What a file asks beside poses and bodies.
static bool lay_out_options(layout_t* layout, const tree_t* root, tree_t* options) {
    const tree_t* const heights = tree_get(root, "attach_heights_m");
    const tree_t* const ring = tree_get(root, "ring_angle_rad");
    tree_t* const given = derived(layout, TREE_BOOLEAN, root);
    if (given == NULL) {
        return false;
    }
    given->boolean = ring != NULL;
    return (heights == NULL ? put_integer(layout, options, "num_attach_heights", 0, root)
                            : lay_out_heights(layout, heights, options)) &&
           put(layout, options, "ring_angle_given", given) && fill_options(layout, options);
}

static bool lay_out_standoff(layout_t* layout, const tree_t* root, tree_t* message) {
    const tree_t* const vehicle = tree_get(tree_get(message, "vehicle"), "radius_m");
    const tree_t* const beam = tree_get(tree_get(message, "beam"), "radius_m");
    if (tree_get(root, "standoff_m") != NULL) {
        return put(layout, message, "standoff_m", tree_get(root, "standoff_m"));
    }
    return put_real(layout, message, "standoff_m",
                    (vehicle == NULL ? 0 : vehicle->real) + (beam == NULL ? 0 : beam->real), root);
}

/// Numbers of the scenario that a file may give by the same key, and that are 0 if it does not.
static const char* const limits[] = {"thrust_reserve",
                                     "margin_m",
                                     "approach_mate_m",
                                     "approach_dock_m",
                                     "contact_speed_max_m_s",
                                     "transit_speed_max_m_s",
                                     "transit_rate_max_rad_s",
                                     "transfer_speed_max_m_s",
                                     "transfer_beam_speed_max_m_s",
                                     "transfer_rate_max_rad_s"};

static bool lay_out_limits(layout_t* layout, const tree_t* root, tree_t* message) {
    for (int i = 0; i < LENGTH(limits); i++) {
        const tree_t* const limit = tree_get(root, limits[i]);
        if (!(limit != NULL ? put(layout, message, limits[i], limit) : put_real(layout, message, limits[i], 0, root))) {
            return false;
        }
    }
    return true;
}

/// The port, by itself or as the hub's, and what stands around.
static bool lay_out_place(layout_t* layout, const tree_t* root, const tree_t* model, const char* path, tree_t* message,
                          tree_t* scene) {
    const tree_t* const port = tree_get(root, "port");
    const tree_t* const from = tree_get(root, "hub");
    hub_t hub = {.port = 0};
    if (port != NULL) {
        return put(layout, message, "port", port) && lay_out_scene(layout, root, path, NULL, message, scene);
    }
    return read_hub(layout, from, model, &hub) && lay_out_hub(layout, from, &hub, message) &&
           lay_out_scene(layout, root, path, &hub, message, scene);
}

static bool lay_out_start(layout_t* layout, const tree_t* root, tree_t* message) {
    const tree_t* const vehicle = tree_get(root, "vehicle");
    const tree_t* const beam = tree_get(root, "beam");
    tree_t* const X_IS = map_for(layout, message, "X_IS", vehicle);
    tree_t* const X_IB = map_for(layout, message, "X_IB", beam);
    const move_t of_vehicle[] = {{"p_IS_m", true, X_IS, "p_m"}, {"q_IS", true, X_IS, "q"}};
    const move_t of_beam[] = {{"p_IB_m", true, X_IB, "p_m"}, {"q_IB", true, X_IB, "q"}, {"contact", true, NULL, NULL}};
    const move_t of_weights[] = {{"time", true, message, "weight_time_per_s"},
                                 {"impulse", true, message, "weight_impulse_per_Ns"}};
    return X_IS != NULL && X_IB != NULL && lay_out(layout, vehicle, of_vehicle, LENGTH(of_vehicle), NULL, 0) &&
           lay_out(layout, beam, of_beam, LENGTH(of_beam), NULL, 0) &&
           lay_out_contact(layout, tree_get(beam, "contact"), message) &&
           lay_out(layout, tree_get(root, "weights"), of_weights, LENGTH(of_weights), NULL, 0);
}

/// The two messages that a file of the friendly layout stands for, into the file. @return false with the error set.
static bool lay_out_scenario(layout_t* layout, const tree_t* root, const char* path, scenario_file_t* file) {
    tree_t* const message = derived(layout, TREE_MAP, root);
    tree_t* const scene = derived(layout, TREE_MAP, root);
    tree_t* const options = message == NULL || scene == NULL ? NULL : map_for(layout, message, "options", root);
    if (options == NULL) {
        return false;
    }
    move_t moves[FIXED_KEYS + LENGTH(limits)] = {
        {"model", true, NULL, NULL},
        {"vehicle", true, NULL, NULL},
        {"beam", true, NULL, NULL},
        {"port", false, NULL, NULL},
        {"hub", false, NULL, NULL},
        {"standoff_m", false, NULL, NULL},
        {"weights", true, NULL, NULL},
        {"attach_heights_m", false, NULL, NULL},
        {"candidates", false, options, "want_candidates"},
        {"front", false, options, "want_front"},
        {"scene", false, NULL, NULL},
        {"avoid", false, NULL, NULL},
        {"left", false, NULL, NULL},
    };
    for (int i = 0; i < LENGTH(limits); i++) {
        moves[FIXED_KEYS + i] = (move_t){limits[i], false, NULL, NULL};
    }
    const target_t targets[] = {{options, "options_t"}};
    if (!lay_out(layout, root, moves, LENGTH(moves), targets, LENGTH(targets))) {
        return false;
    }
    const tree_t* const port = tree_get(root, "port");
    const tree_t* const hub = tree_get(root, "hub");
    if (port == NULL && hub == NULL) {
        tree_fail_key(layout->error, root, NULL, "port",
                      "this key is missing; give port {p_IP_m, axis_I} or hub {p_IH_m, q_IH, port}");
        return false;
    }
    if (port != NULL && hub != NULL) {
        return tree_fail(layout->error, hub, "port is given too; give one of the two");
    }
    const tree_t* const model = lay_out_model(layout, tree_get(root, "model"), path, message);
    file->tree = message;
    file->scene = scene;
    return model != NULL && lay_out_limits(layout, root, message) && lay_out_start(layout, root, message) &&
           lay_out_place(layout, root, model, path, message, scene) && lay_out_standoff(layout, root, message) &&
           lay_out_options(layout, root, options);
}

/// The message with nobody as its asker: who asked before, if the file tells, has no part in asking again.
static const tree_t* without_asker(layout_t* layout, const tree_t* message) {
    tree_t* const question = derived(layout, TREE_MAP, message);
    tree_t* const nobody = derived(layout, TREE_MAP, message);
    if (question == NULL || nobody == NULL || message->kind != TREE_MAP) {
        return message;
    }
    *question = *message;
    question->count = 0;
    question->entries = NULL;
    bool sound = put(layout, question, "asker", nobody) && put_bits(layout, nobody, "asker_id", 0, message) &&
                 put_bits(layout, nobody, "request_id", 0, message) &&
                 put_integer(layout, nobody, "epoch_us", 0, message) &&
                 put_bits(layout, nobody, "planner_id", 0, message);
    for (int i = 0; i < message->count && sound; i++) {
        const tree_entry_t* entry = &message->entries[i];
        if (strcmp(entry->key, "asker") != 0) {
            sound = tree_graft(layout->memory, question, entry->key, entry->value);
            if (sound) {
                question->entries[question->count - 1] = *entry;
            }
        }
    }
    return sound ? question : NULL;
}

bool scenario_text_open(scenario_file_t* file, const char* path, const char* text, size_t size, const char* models_dir,
                        lcm_ssv_task_t* task, char* error_text, size_t error_size) {
    tree_error_t error = {error_text, error_size};
    layout_t layout = {&file->memory, &error, models_dir};
    *file = (scenario_file_t){.tree = NULL};
    error_text[0] = '\0';
    const tree_t* const root = parse(&layout, path, text, size);
    if (root == NULL) {
        return false;
    }
    if (root->kind != TREE_MAP) {
        return tree_fail(&error, root, "no scenario, which is a map of keys and values");
    }
    file->tree = tree_get(root, "scenario");
    file->scene = tree_get(root, "scene");
    if (file->tree == NULL && !lay_out_scenario(&layout, root, path, file)) {
        return false;
    }
    const tree_t* const question = without_asker(&layout, file->tree);
    memset(task, 0, sizeof *task);
    return question != NULL && wire_from_tree("scenario_t", question, &task->scenario, &error) &&
           (file->scene == NULL || wire_from_tree("scene_t", file->scene, &task->scene, &error));
}

bool scenario_file_open(scenario_file_t* file, const char* path, const char* models_dir, lcm_ssv_task_t* task,
                        char* error_text, size_t error_size) {
    tree_error_t error = {error_text, error_size};
    size_t size = 0;
    *file = (scenario_file_t){.tree = NULL};
    error_text[0] = '\0';
    char* const text = tree_file_read(path, &size, &error);
    const bool sound =
        text != NULL && scenario_text_open(file, path, text, size, models_dir, task, error_text, error_size);
    free(text);
    return sound;
}

/// What stands at a path like "vehicle.thruster[2].n_T_S", or the last on the way to it.
static const tree_t* find(const tree_t* tree, const char* path, size_t length) {
    const char* const end = path + length;
    while (path < end) {
        const tree_t* next = NULL;
        if (*path == '[') {
            char* after = NULL;
            const long index = strtol(path + 1, &after, 10);
            next = tree->kind == TREE_LIST && index >= 0 && index < tree->count ? tree->entries[index].value : NULL;
            path = after + (*after == ']');
        } else {
            char key[64];
            path += *path == '.';
            const size_t size = strcspn(path, ".[: ");
            snprintf(key, sizeof key, "%.*s", (int)size, path);
            next = tree_get(tree, key);
            path += size;
        }
        if (next == NULL) {
            return tree;
        }
        tree = next;
    }
    return tree;
}

void scenario_file_explain(const scenario_file_t* file, const char* reason, char* text, size_t size) {
    const bool is_scene = strncmp(reason, "scene.", strlen("scene.")) == 0;
    const char* const path = is_scene ? reason + strlen("scene.") : reason;
    const char* const sentence = strstr(reason, ": ");
    const tree_t* const tree = is_scene ? file->scene : file->tree;
    const tree_t* const found = tree == NULL ? NULL : find(tree, path, strcspn(path, ": "));
    if (sentence == NULL || found == NULL || found == tree || found->file == NULL) {
        snprintf(text, size, "%s", reason);
        return;
    }
    char place[768];
    tree_place(found, place, sizeof place);
    snprintf(text, size, "%s%s", place, sentence);
}

void scenario_file_close(scenario_file_t* file) {
    tree_memory_free(&file->memory);
    file->tree = file->scene = NULL;
}

bool scenario_file_read(const char* path, const char* models_dir, lcm_ssv_task_t* task, char* error,
                        size_t error_size) {
    scenario_file_t file;
    const bool sound = scenario_file_open(&file, path, models_dir, task, error, error_size);
    scenario_file_close(&file);
    return sound;
}
