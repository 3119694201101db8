// The layout of structure files, and what must hold of a structure before anybody is asked for a price.
#include "structure.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/scenario_file.h"
#include "wire/tree.h"

#define LENGTH(array) ((int)(sizeof(array) / sizeof(array)[0]))
#define DEG_PER_RAD 57.295779513082321
#define UNIT_TOLERANCE 1e-3
#define TOLERANCE_M 0.005  ///< how far a docked beam's end may be from its second port, unless the file says
#define TOLERANCE_RAD 0.01 ///< and how far off its axis
#define RADIUS_M 0.15      ///< of a hub
#define OVERLAP_M 1e-6     ///< beams that touch along their sides are not in one place

/// What is being read.
typedef struct {
    structure_t* structure;
    tree_error_t* error;
    const tree_t* root;
    const tree_t* hubs;
    const tree_t* beams;
    const tree_t* slots;
} reading_t;

// ---- Values ---------------------------------------------------------------------------------------------------------

/// A map with no other keys than the known ones, of which the first so many are required.
static bool check_keys(reading_t* reading, const tree_t* map, const char* const* known, int count, int num_required) {
    if (map->kind != TREE_MAP) {
        return tree_fail(reading->error, map, "not a map of keys and values");
    }
    for (int i = 0; i < map->count; i++) {
        const tree_entry_t* const entry = &map->entries[i];
        bool is_known = false;
        for (int k = 0; k < count; k++) is_known = is_known || strcmp(known[k], entry->key) == 0;
        if (!is_known) {
            const char* const nearest = tree_nearest(entry->key, known, count);
            return nearest == NULL ? tree_fail_key(reading->error, map, entry, entry->key, "unknown key")
                                   : tree_fail_key(reading->error, map, entry, entry->key,
                                                   "unknown key; did you mean %s?", nearest);
        }
    }
    for (int k = 0; k < num_required; k++) {
        if (tree_get(map, known[k]) == NULL) {
            return tree_fail_key(reading->error, map, NULL, known[k], "this key is missing");
        }
    }
    return true;
}

static const tree_t* get_list(reading_t* reading, const tree_t* map, const char* key, int least, int most) {
    const tree_t* const list = tree_get(map, key);
    if (list->kind != TREE_LIST || list->count < least || list->count > most) {
        tree_fail(reading->error, list, "there must be a list of %d to %d entries", least, most);
        return NULL;
    }
    return list;
}

static bool get_number(reading_t* reading, const tree_t* value, double least, double most, double* number) {
    if (value->kind != TREE_INTEGER && value->kind != TREE_REAL) {
        return tree_fail(reading->error, value, "'%.40s' is not a number", value->text == NULL ? "" : value->text);
    }
    *number = value->real;
    return (value->real >= least && value->real <= most) ||
           tree_fail(reading->error, value, "%.9g is not in [%.9g, %.9g]", value->real, least, most);
}

/// A number that may be left out, and keeps its value then.
static bool get_option(reading_t* reading, const tree_t* map, const char* key, double least, double most,
                       double* number) {
    const tree_t* const value = tree_get(map, key);
    return value == NULL || get_number(reading, value, least, most, number);
}

static bool get_truth(reading_t* reading, const tree_t* map, const char* key, bool* truth) {
    const tree_t* const value = tree_get(map, key);
    if (value == NULL) return true;
    *truth = value->boolean;
    return value->kind == TREE_BOOLEAN || tree_fail(reading->error, value, "neither true nor false");
}

static bool get_numbers(reading_t* reading, const tree_t* map, const char* key, int count, double* numbers) {
    const tree_t* const list = get_list(reading, map, key, count, count);
    for (int i = 0; list != NULL && i < count; i++) {
        if (!get_number(reading, list->entries[i].value, -1000, 1000, &numbers[i])) return false;
    }
    return list != NULL;
}

/// Likewise of unit length, and made so.
static bool get_unit(reading_t* reading, const tree_t* map, const char* key, int count, double* numbers) {
    double square = 0;
    if (!get_numbers(reading, map, key, count, numbers)) return false;
    for (int i = 0; i < count; i++) square += numbers[i] * numbers[i];
    const double length = sqrt(square);
    if (fabs(length - 1) > UNIT_TOLERANCE) {
        return tree_fail(reading->error, tree_get(map, key), "length %.9g is not 1 within %.3g", length,
                         UNIT_TOLERANCE);
    }
    for (int i = 0; i < count; i++) numbers[i] /= length;
    return true;
}

/// The name of an entry, which no entry before has.
static bool get_name(reading_t* reading, const tree_t* list, int i, char name[STRUCTURE_NAME_SIZE]) {
    const tree_t* const value = tree_get(list->entries[i].value, "name");
    if (value->kind != TREE_TEXT || value->text[0] == '\0' || strlen(value->text) >= STRUCTURE_NAME_SIZE) {
        return tree_fail(reading->error, value, "not a name of 1 to %d bytes that does not read as a number",
                         STRUCTURE_NAME_SIZE - 1);
    }
    for (int k = 0; k < i; k++) {
        const tree_t* const other = tree_get(list->entries[k].value, "name");
        if (strcmp(other->text, value->text) == 0) {
            return tree_fail(reading->error, value, "'%s' is used twice, here and in line %d", value->text,
                             other->line);
        }
    }
    snprintf(name, STRUCTURE_NAME_SIZE, "%s", value->text);
    tree_make_harmless(name);
    return true;
}

/// The number of the entry with this name. @return -1 with the error set.
static int find_name(reading_t* reading, const tree_t* list, const tree_t* name, const char* what) {
    const char* known[STRUCTURE_MAX_BEAMS];
    for (int i = 0; i < list->count; i++) {
        known[i] = tree_get(list->entries[i].value, "name")->text;
        if (name->text != NULL && known[i] != NULL && strcmp(name->text, known[i]) == 0) return i;
    }
    const char* const nearest = name->text == NULL ? NULL : tree_nearest(name->text, known, list->count);
    tree_fail(reading->error, name, "'%.40s' is no %s of this file%s%s%s", name->text == NULL ? "" : name->text, what,
              nearest == NULL ? "" : "; did you mean ", nearest == NULL ? "" : nearest, nearest == NULL ? "" : "?");
    return -1;
}

// ---- Geometry -------------------------------------------------------------------------------------------------------

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void along(const double p[3], double s, const double d[3], double r[3]) {
    for (int i = 0; i < 3; i++) r[i] = p[i] + s * d[i];
}

static double distance(const double a[3], const double b[3]) {
    double r[3];
    along(a, -1, b, r);
    return sqrt(dot(r, r));
}

/// v turned by the unit quaternion q.
static void turn(const double q[4], const double v[3], double turned[3]) {
    const double* e = &q[1];
    double t[3];
    for (int i = 0, j = 1, k = 2; i < 3; i++, j = (j + 1) % 3, k = (k + 1) % 3) {
        t[i] = 2 * (e[j] * v[k] - e[k] * v[j]);
    }
    for (int i = 0, j = 1, k = 2; i < 3; i++, j = (j + 1) % 3, k = (k + 1) % 3) {
        turned[i] = v[i] + q[0] * t[i] + (e[j] * t[k] - e[k] * t[j]);
    }
}

typedef struct {
    double a[3], b[3];
} line_t;

static double point_to_line(const double p[3], const line_t* line) {
    double d[3], r[3], foot[3];
    along(line->b, -1, line->a, d);
    along(p, -1, line->a, r);
    along(line->a, fmin(1, fmax(0, dot(r, d) / dot(d, d))), d, foot);
    return distance(p, foot);
}

/// Lines of some length are nearest at an end of one, or where their common perpendicular meets both.
static double line_to_line(const line_t* one, const line_t* other) {
    double least = fmin(fmin(point_to_line(one->a, other), point_to_line(one->b, other)),
                        fmin(point_to_line(other->a, one), point_to_line(other->b, one)));
    double u[3], v[3], r[3], on_one[3], on_other[3];
    along(one->b, -1, one->a, u);
    along(other->b, -1, other->a, v);
    along(other->a, -1, one->a, r);
    const double uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), det = uu * vv - uv * uv;
    if (det > 1e-12 * uu * vv) {
        const double s = (dot(r, u) * vv - dot(r, v) * uv) / det, t = (dot(r, u) * uv - dot(r, v) * uu) / det;
        if (s >= 0 && s <= 1 && t >= 0 && t <= 1) {
            along(one->a, s, u, on_one);
            along(other->a, t, v, on_other);
            least = fmin(least, distance(on_one, on_other));
        }
    }
    return least;
}

static const structure_port_t* port_of(const structure_t* structure, const structure_slot_t* slot, int end) {
    return &structure->hub[slot->hub[end]].port[slot->port[end]];
}

static line_t slot_line(const structure_t* structure, int s) {
    const structure_port_t* const port = port_of(structure, &structure->slot[s], 0);
    line_t line;
    memcpy(line.a, port->p_IP_m, sizeof line.a);
    along(port->p_IP_m, structure->task.beam.length_m, port->axis_I, line.b);
    return line;
}

static line_t beam_line(const structure_t* structure, int b) {
    static const double z[3] = {0, 0, 1};
    const structure_beam_t* const beam = &structure->beam[b];
    double axis[3];
    line_t line;
    turn(beam->q_IB, z, axis);
    along(beam->p_IB_m, -structure->task.beam.length_m / 2, axis, line.a);
    along(beam->p_IB_m, structure->task.beam.length_m / 2, axis, line.b);
    return line;
}

// ---- Parts of a file ------------------------------------------------------------------------------------------------

static bool read_ports(reading_t* reading, const tree_t* map, const double q_IH[4], structure_hub_t* hub) {
    static const char* const keys[] = {"p_HP_m", "axis_H"};
    const tree_t* const ports = get_list(reading, map, "ports", 1, STRUCTURE_MAX_PORTS);
    for (int i = 0; ports != NULL && i < ports->count; i++) {
        const tree_t* const value = ports->entries[i].value;
        structure_port_t* const port = &hub->port[i];
        double p_HP_m[3], axis_H[3], turned[3];
        if (!check_keys(reading, value, keys, 2, 2) || !get_numbers(reading, value, "p_HP_m", 3, p_HP_m) ||
            !get_unit(reading, value, "axis_H", 3, axis_H)) {
            return false;
        }
        turn(q_IH, p_HP_m, turned);
        along(hub->p_IH_m, 1, turned, port->p_IP_m);
        turn(q_IH, axis_H, port->axis_I);
        hub->num_ports = i + 1;
    }
    return ports != NULL;
}

/// Ports and radius of a hub are its own, or those that the file has for all.
static bool read_hubs(reading_t* reading) {
    static const char* const shared_keys[] = {"ports", "radius_m"};
    static const char* const keys[] = {"name", "p_IH_m", "q_IH", "ports", "radius_m"};
    structure_t* const structure = reading->structure;
    const tree_t* const shared = tree_get(reading->root, "hub");
    double radius_m = RADIUS_M;
    if (shared != NULL && (!check_keys(reading, shared, shared_keys, 2, 1) ||
                           !get_option(reading, shared, "radius_m", 0, 100, &radius_m))) {
        return false;
    }
    reading->hubs = get_list(reading, reading->root, "hubs", 1, STRUCTURE_MAX_HUBS);
    for (int i = 0; reading->hubs != NULL && i < reading->hubs->count; i++) {
        const tree_t* const value = reading->hubs->entries[i].value;
        structure_hub_t* const hub = &structure->hub[i];
        double q_IH[4];
        hub->radius_m = radius_m;
        if (!check_keys(reading, value, keys, 5, 3) || !get_name(reading, reading->hubs, i, hub->name) ||
            !get_numbers(reading, value, "p_IH_m", 3, hub->p_IH_m) || !get_unit(reading, value, "q_IH", 4, q_IH) ||
            !get_option(reading, value, "radius_m", 0, 100, &hub->radius_m)) {
            return false;
        }
        if (tree_get(value, "ports") == NULL && shared == NULL) {
            return tree_fail_key(reading->error, value, NULL, "ports",
                                 "this key is missing; give it here, or in hub: at the top for all hubs");
        }
        if (!read_ports(reading, tree_get(value, "ports") != NULL ? value : shared, q_IH, hub)) return false;
        structure->num_hubs = i + 1;
    }
    return reading->hubs != NULL;
}

static bool read_beams(reading_t* reading) {
    static const char* const keys[] = {"name", "p_IB_m", "q_IB"};
    structure_t* const structure = reading->structure;
    reading->beams = get_list(reading, reading->root, "beams", 1, STRUCTURE_MAX_BEAMS);
    for (int i = 0; reading->beams != NULL && i < reading->beams->count; i++) {
        const tree_t* const value = reading->beams->entries[i].value;
        structure_beam_t* const beam = &structure->beam[i];
        if (!check_keys(reading, value, keys, 3, 3) || !get_name(reading, reading->beams, i, beam->name) ||
            !get_numbers(reading, value, "p_IB_m", 3, beam->p_IB_m) ||
            !get_unit(reading, value, "q_IB", 4, beam->q_IB)) {
            return false;
        }
        structure->num_beams = i + 1;
    }
    return reading->beams != NULL;
}

/// The ports that a slot joins; no slot before has one of them.
static bool read_join(reading_t* reading, const tree_t* value, int s) {
    static const char* const keys[] = {"hub", "port"};
    structure_t* const structure = reading->structure;
    structure_slot_t* const slot = &structure->slot[s];
    const tree_t* const join = get_list(reading, value, "join", 2, 2);
    for (int end = 0; join != NULL && end < 2; end++) {
        const tree_t* const at = join->entries[end].value;
        if (!check_keys(reading, at, keys, 2, 2)) return false;
        slot->hub[end] = find_name(reading, reading->hubs, tree_get(at, "hub"), "hub");
        if (slot->hub[end] < 0) return false;
        const tree_t* const number = tree_get(at, "port");
        const int num_ports = structure->hub[slot->hub[end]].num_ports;
        if (number->kind != TREE_INTEGER || number->integer < 1 || number->integer > num_ports) {
            return tree_fail(reading->error, number, "'%.40s' is no port of this hub, which has 1 to %d",
                             number->text == NULL ? "" : number->text, num_ports);
        }
        slot->port[end] = (int)number->integer - 1;
        for (int k = 0; k < 2 * s + end; k++) {
            const structure_slot_t* const other = &structure->slot[k / 2];
            if (other->hub[k % 2] == slot->hub[end] && other->port[k % 2] == slot->port[end]) {
                return tree_fail(reading->error, at, "port %d of hub '%s' is used twice, here and by slot '%s'",
                                 slot->port[end] + 1, structure->hub[slot->hub[end]].name, other->name);
            }
        }
    }
    return join != NULL;
}

/// Whether the beam that is docked at the slot's first port reaches its second.
static bool check_closes(reading_t* reading, const tree_t* value, int s, double tolerance_m, double tolerance_rad) {
    const structure_t* const structure = reading->structure;
    const structure_port_t* const first = port_of(structure, &structure->slot[s], 0);
    const structure_port_t* const second = port_of(structure, &structure->slot[s], 1);
    const line_t line = slot_line(structure, s);
    const double off_m = distance(line.b, second->p_IP_m);
    const double off_rad = acos(fmin(1, fmax(-1, -dot(first->axis_I, second->axis_I))));
    return (off_m <= tolerance_m && off_rad <= tolerance_rad) ||
           tree_fail(reading->error, tree_get(value, "join"),
                     "does not close: a beam at port %d of hub '%s' ends %.4f m from port %d of hub '%s', %.2f deg "
                     "off its axis; tolerances are %.4f m and %.2f deg",
                     structure->slot[s].port[0] + 1, structure->hub[structure->slot[s].hub[0]].name, off_m,
                     structure->slot[s].port[1] + 1, structure->hub[structure->slot[s].hub[1]].name,
                     off_rad * DEG_PER_RAD, tolerance_m, tolerance_rad * DEG_PER_RAD);
}

static bool read_slots(reading_t* reading) {
    static const char* const keys[] = {"name", "join", "after", "beam"};
    structure_t* const structure = reading->structure;
    double tolerance_m = TOLERANCE_M, tolerance_rad = TOLERANCE_RAD;
    if (!get_option(reading, reading->root, "tolerance_m", 0, 10, &tolerance_m) ||
        !get_option(reading, reading->root, "tolerance_rad", 0, 3.2, &tolerance_rad)) {
        return false;
    }
    reading->slots = get_list(reading, reading->root, "slots", 1, STRUCTURE_MAX_SLOTS);
    if (reading->slots != NULL && structure->obstacles &&
        structure->num_hubs + reading->slots->count > STRUCTURE_MAX_OBSTACLES) {
        return tree_fail(reading->error, reading->slots,
                         "%d slots and %d hubs are more than the %d obstacles that a flight can have in its way; leave "
                         "some out, or say obstacles: false",
                         reading->slots->count, structure->num_hubs, STRUCTURE_MAX_OBSTACLES);
    }
    for (int s = 0; reading->slots != NULL && s < reading->slots->count; s++) {
        const tree_t* const value = reading->slots->entries[s].value;
        structure_slot_t* const slot = &structure->slot[s];
        slot->beam = -1;
        slot->line = value->line;
        if (!check_keys(reading, value, keys, 4, 2) || !get_name(reading, reading->slots, s, slot->name) ||
            !read_join(reading, value, s) || !check_closes(reading, value, s, tolerance_m, tolerance_rad)) {
            return false;
        }
        const tree_t* const beam = tree_get(value, "beam");
        if (beam != NULL) {
            slot->beam = find_name(reading, reading->beams, beam, "beam");
            if (slot->beam < 0) return false;
        }
        for (int k = 0; k < s; k++) {
            if (slot->beam >= 0 && slot->beam == structure->slot[k].beam) {
                return tree_fail(reading->error, beam, "'%s' is used twice, here and by slot '%s'",
                                 structure->beam[slot->beam].name, structure->slot[k].name);
            }
        }
        structure->num_slots = s + 1;
    }
    if (reading->slots != NULL && structure->num_beams < structure->num_slots) {
        return tree_fail(reading->error, reading->beams, "%d beams for %d slots", structure->num_beams,
                         structure->num_slots);
    }
    return reading->slots != NULL;
}

// ---- Rules ----------------------------------------------------------------------------------------------------------

static bool read_precedence(reading_t* reading) {
    structure_t* const structure = reading->structure;
    set_t possible = 0;
    for (int s = 0; s < structure->num_slots; s++) {
        const tree_t* const value = reading->slots->entries[s].value;
        if (tree_get(value, "after") == NULL) continue;
        const tree_t* const after = get_list(reading, value, "after", 0, STRUCTURE_MAX_SLOTS);
        for (int i = 0; after != NULL && i < after->count; i++) {
            const int other = find_name(reading, reading->slots, after->entries[i].value, "slot");
            if (other < 0) return false;
            structure->slot[s].after |= set_of(other);
        }
        if (after == NULL) return false;
    }
    // Whatever can be built is; what is left then waits for itself.
    for (int round = 0; round < structure->num_slots; round++) {
        for (int s = 0; s < structure->num_slots; s++) {
            if ((structure->slot[s].after & ~possible) == 0) possible |= set_of(s);
        }
    }
    for (int s = 0; s < structure->num_slots; s++) {
        if ((possible >> s & 1) == 0) {
            return tree_fail(reading->error, tree_get(reading->slots->entries[s].value, "after"),
                             "precedence is cyclic: '%s' can never be built", structure->slot[s].name);
        }
    }
    return true;
}

bool structure_may_build(const structure_t* structure, set_t built, int slot) {
    const structure_slot_t* const at = &structure->slot[slot];
    return (built >> slot & 1) == 0 && (at->after & ~built) == 0 &&
           (!structure->touching || built == 0 || (at->touches & built) != 0);
}

bool structure_may_take(const structure_t* structure, set_t used, int beam, int slot) {
    if ((used >> beam & 1) != 0) return false;
    if (structure->slot[slot].beam >= 0) return structure->slot[slot].beam == beam;
    for (int k = 0; k < structure->num_slots; k++) {
        if (structure->slot[k].beam == beam) return false;
    }
    return true;
}

static void find_neighbours(structure_t* structure) {
    for (int s = 0; s < structure->num_slots; s++) {
        for (int k = 0; k < structure->num_slots; k++) {
            const structure_slot_t *one = &structure->slot[s], *other = &structure->slot[k];
            const bool touches = one->hub[0] == other->hub[0] || one->hub[0] == other->hub[1] ||
                                 one->hub[1] == other->hub[0] || one->hub[1] == other->hub[1];
            if (s != k && touches) structure->slot[s].touches |= set_of(k);
        }
    }
}

/// Beams as they lie and beams as they are docked, each against all before.
static bool check_places(reading_t* reading) {
    const structure_t* const structure = reading->structure;
    const int count = structure->num_beams + structure->num_slots;
    for (int i = 0; i < count; i++) {
        const bool lies = i < structure->num_beams;
        const int s = i - structure->num_beams;
        const line_t line = lies ? beam_line(structure, i) : slot_line(structure, s);
        for (int k = 0; k < i; k++) {
            const bool other_lies = k < structure->num_beams;
            const line_t other = other_lies ? beam_line(structure, k) : slot_line(structure, k - structure->num_beams);
            if (line_to_line(&line, &other) < 2 * structure->task.beam.radius_m - OVERLAP_M) {
                return tree_fail(reading->error,
                                 lies ? tree_get(reading->beams->entries[i].value, "p_IB_m")
                                      : tree_get(reading->slots->entries[s].value, "join"),
                                 "two beams in one place: %s '%s' and %s '%s'", lies ? "beam" : "slot",
                                 lies ? structure->beam[i].name : structure->slot[s].name, other_lies ? "beam" : "slot",
                                 other_lies ? structure->beam[k].name : structure->slot[k - structure->num_beams].name);
            }
        }
    }
    return true;
}

// ---- The task that all have in common -------------------------------------------------------------------------------

/// A node that no file has, at a place of one.
static tree_t* derived(tree_memory_t* memory, tree_kind_t kind, const tree_t* from) {
    tree_t* const value = tree_memory_take(memory, sizeof *value);
    if (value != NULL) {
        *value = (tree_t){.kind = kind,
                          .file = from->file,
                          .line = from->line,
                          .column = from->column,
                          .parent = from->parent,
                          .key = from->key,
                          .index = from->index};
    }
    return value;
}

/// The first beam to the first slot, as a scenario file would have it; where it is told it keeps its place in the file.
static bool read_task(reading_t* reading, const char* path, const char* models_dir) {
    static const char* const shared[] = {"model",  "vehicle", "weights",         "standoff_m",      "thrust_reserve",
                                         "method", "effort",  "attach_anywhere", "attach_heights_m"};
    const tree_t* const first = tree_get(reading->root, "beams")->entries[0].value;
    scenario_file_t file = {.tree = NULL};
    lcm_ssv_task_t task;
    tree_t* const scenario = derived(&file.memory, TREE_MAP, reading->root);
    tree_t* const beam = derived(&file.memory, TREE_MAP, first);
    tree_t* const contact = derived(&file.memory, TREE_TEXT, first);
    tree_t* const port = derived(&file.memory, TREE_MAP, first);
    tree_t* const axis = derived(&file.memory, TREE_LIST, first);
    tree_t* const zero = derived(&file.memory, TREE_REAL, first);
    tree_t* const one = derived(&file.memory, TREE_REAL, first);
    bool sound = scenario != NULL && beam != NULL && contact != NULL && port != NULL && axis != NULL && zero != NULL &&
                 one != NULL;
    if (sound) {
        contact->text = "either";
        one->real = 1;
        sound = tree_graft(&file.memory, beam, "p_IB_m", tree_get(first, "p_IB_m")) &&
                tree_graft(&file.memory, beam, "q_IB", tree_get(first, "q_IB")) &&
                tree_graft(&file.memory, beam, "contact", contact) && tree_graft(&file.memory, axis, NULL, zero) &&
                tree_graft(&file.memory, axis, NULL, zero) && tree_graft(&file.memory, axis, NULL, one) &&
                tree_graft(&file.memory, port, "p_IP_m", axis) && tree_graft(&file.memory, port, "axis_I", axis) &&
                tree_graft(&file.memory, scenario, "beam", beam) && tree_graft(&file.memory, scenario, "port", port);
        for (int i = 0; i < LENGTH(shared) && sound; i++) {
            const tree_t* const value = tree_get(reading->root, shared[i]);
            sound = value == NULL || tree_graft(&file.memory, scenario, shared[i], value);
        }
    }
    if (!sound) tree_fail(reading->error, reading->root, "out of memory");
    sound = sound && scenario_tree_open(&file, path, scenario, models_dir, &task, reading->error);
    scenario_file_close(&file);
    if (sound) reading->structure->task = task.scenario;
    return sound;
}

static bool read_start(reading_t* reading) {
    static const char* const keys[] = {"p_IS_m", "q_IS"};
    const tree_t* const vehicle = tree_get(reading->root, "vehicle");
    return check_keys(reading, vehicle, keys, 2, 2) &&
           get_numbers(reading, vehicle, "p_IS_m", 3, reading->structure->p_IS_m) &&
           get_unit(reading, vehicle, "q_IS", 4, reading->structure->q_IS);
}

static bool read_rules(reading_t* reading) {
    structure_t* const structure = reading->structure;
    structure->obstacles = true;
    return get_truth(reading, reading->root, "touching", &structure->touching) &&
           get_truth(reading, reading->root, "obstacles", &structure->obstacles) &&
           get_option(reading, reading->root, "margin_m", 0, 10, &structure->task.margin_m) &&
           get_option(reading, reading->root, "approach_mate_m", 0, 10, &structure->task.approach_mate_m) &&
           get_option(reading, reading->root, "approach_dock_m", 0, 10, &structure->task.approach_dock_m) &&
           get_option(reading, reading->root, "contact_speed_max_m_s", 0, 100, &structure->task.contact_speed_max_m_s);
}

static bool read_root(reading_t* reading, const char* path, const char* models_dir) {
    static const char* const keys[] = {"model",       "vehicle",         "weights",
                                       "hubs",        "beams",           "slots",
                                       "hub",         "touching",        "obstacles",
                                       "margin_m",    "approach_mate_m", "approach_dock_m",
                                       "tolerance_m", "tolerance_rad",   "contact_speed_max_m_s",
                                       "standoff_m",  "thrust_reserve",  "method",
                                       "effort",      "attach_anywhere", "attach_heights_m"};
    return check_keys(reading, reading->root, keys, LENGTH(keys), 6) && read_start(reading) && read_hubs(reading) &&
           read_beams(reading) && read_task(reading, path, models_dir) && read_rules(reading) && read_slots(reading) &&
           read_precedence(reading) && check_places(reading);
}

bool structure_is_meant(const char* path) {
    char ignored[256];
    tree_error_t error = {ignored, sizeof ignored};
    tree_memory_t memory = {NULL};
    size_t size = 0;
    char* const text = strcmp(path, "-") == 0 ? NULL : tree_file_read(path, &size, &error);
    const tree_t* const root = text == NULL ? NULL : tree_from_yaml(&memory, &error, path, text, size);
    const bool is_meant = root != NULL && root->kind == TREE_MAP && tree_get(root, "slots") != NULL;
    tree_memory_free(&memory);
    free(text);
    return is_meant;
}

bool structure_text_read(structure_t* structure, const char* path, const char* text, size_t size,
                         const char* models_dir, char* error_text, size_t error_size) {
    tree_error_t error = {error_text, error_size};
    tree_memory_t memory = {NULL};
    memset(structure, 0, sizeof *structure);
    structure->left = -1;
    error_text[0] = '\0';
    const char* const shown = strcmp(path, "-") == 0 ? "standard input" : path;
    reading_t reading = {
        .structure = structure, .error = &error, .root = tree_from_yaml(&memory, &error, shown, text, size)};
    const bool sound = reading.root != NULL && read_root(&reading, path, models_dir);
    if (sound) find_neighbours(structure);
    tree_memory_free(&memory);
    return sound;
}

bool structure_read(structure_t* structure, const char* path, const char* models_dir, char* error_text,
                    size_t error_size) {
    tree_error_t error = {error_text, error_size};
    size_t size = 0;
    error_text[0] = '\0';
    char* const text = tree_file_read(path, &size, &error);
    const bool sound =
        text != NULL && structure_text_read(structure, path, text, size, models_dir, error_text, error_size);
    free(text);
    return sound;
}
