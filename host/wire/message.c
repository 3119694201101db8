// The walk over the message types and what is done on the way: write JSON, read a tree, free, check bytes.
#define _POSIX_C_SOURCE 200809L
#include "message.h"

#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lcm_ssv_control_t.h"
#include "lcm_ssv_execution_t.h"
#include "lcm_ssv_plan_t.h"
#include "lcm_ssv_planner_status_t.h"
#include "lcm_ssv_quote_batch_t.h"
#include "lcm_ssv_scenario_batch_t.h"
#include "lcm_ssv_schedule_t.h"
#include "lcm_ssv_task_t.h"
#include "lcm_ssv_vehicle_state_t.h"
#include "names.h"

/// Room for one message of any type without what it points to.
#define MESSAGE_SIZE_MAX 8192
#define FIELDS_MAX 48

static const lcm_type_info_t* info_of(const char* type) {
    static const struct {
        const char* type;
        const lcm_type_info_t* (*info)(void);
    } types[] = {
        {"answer_t", lcm_ssv_answer_t_get_type_info},
        {"arc_t", lcm_ssv_arc_t_get_type_info},
        {"arrival_t", lcm_ssv_arrival_t_get_type_info},
        {"asker_t", lcm_ssv_asker_t_get_type_info},
        {"beam_t", lcm_ssv_beam_t_get_type_info},
        {"body_t", lcm_ssv_body_t_get_type_info},
        {"candidate_t", lcm_ssv_candidate_t_get_type_info},
        {"choice_t", lcm_ssv_choice_t_get_type_info},
        {"clearance_t", lcm_ssv_clearance_t_get_type_info},
        {"control_t", lcm_ssv_control_t_get_type_info},
        {"event_t", lcm_ssv_event_t_get_type_info},
        {"execution_t", lcm_ssv_execution_t_get_type_info},
        {"leg_t", lcm_ssv_leg_t_get_type_info},
        {"obstacle_t", lcm_ssv_obstacle_t_get_type_info},
        {"options_t", lcm_ssv_options_t_get_type_info},
        {"plan_t", lcm_ssv_plan_t_get_type_info},
        {"planner_status_t", lcm_ssv_planner_status_t_get_type_info},
        {"planner_t", lcm_ssv_planner_t_get_type_info},
        {"port_t", lcm_ssv_port_t_get_type_info},
        {"pose_t", lcm_ssv_pose_t_get_type_info},
        {"quote_batch_t", lcm_ssv_quote_batch_t_get_type_info},
        {"quote_t", lcm_ssv_quote_t_get_type_info},
        {"scenario_batch_t", lcm_ssv_scenario_batch_t_get_type_info},
        {"scenario_t", lcm_ssv_scenario_t_get_type_info},
        {"scene_t", lcm_ssv_scene_t_get_type_info},
        {"schedule_part_t", lcm_ssv_schedule_part_t_get_type_info},
        {"schedule_t", lcm_ssv_schedule_t_get_type_info},
        {"segment_t", lcm_ssv_segment_t_get_type_info},
        {"tank_t", lcm_ssv_tank_t_get_type_info},
        {"task_t", lcm_ssv_task_t_get_type_info},
        {"thruster_t", lcm_ssv_thruster_t_get_type_info},
        {"vehicle_state_t", lcm_ssv_vehicle_state_t_get_type_info},
        {"vehicle_t", lcm_ssv_vehicle_t_get_type_info},
    };
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++) {
        if (strcmp(types[i].type, type) == 0) {
            return types[i].info();
        }
    }
    assert(!"a message type of ours");
    abort();
}

/// A field of one message: its elements, one if it is no list, and where they are.
typedef struct {
    const char* of; ///< the type that has it
    const char* name;
    const char* type;
    lcm_field_type_t kind;
    bool is_list, is_variable; ///< variable: the message states how many there are, and points to them
    int32_t count, most;       ///< most: those that there is room for, where another field says how many of them count
    size_t element_size;
    char* elements;
    void** pointer; ///< of a variable list
} field_t;

static size_t size_of(lcm_field_type_t kind, const char* type) {
    switch (kind) {
        case LCM_FIELD_INT8_T:
        case LCM_FIELD_BOOLEAN: return sizeof(int8_t);
        case LCM_FIELD_INT16_T: return sizeof(int16_t);
        case LCM_FIELD_INT32_T: return sizeof(int32_t);
        case LCM_FIELD_INT64_T: return sizeof(int64_t);
        case LCM_FIELD_DOUBLE: return sizeof(double);
        case LCM_FIELD_STRING: return sizeof(char*);
        case LCM_FIELD_USER_TYPE: return (size_t)info_of(type)->struct_size();
        default: assert(!"a kind of field that our messages have"); return 0;
    }
}

static int64_t read_integer(lcm_field_type_t kind, const void* element) {
    switch (kind) {
        case LCM_FIELD_INT8_T: return *(const int8_t*)element;
        case LCM_FIELD_INT16_T: return *(const int16_t*)element;
        case LCM_FIELD_INT32_T: return *(const int32_t*)element;
        default: return *(const int64_t*)element;
    }
}

/// The whole number in the field of this name.
static int64_t number_in(const lcm_type_info_t* info, const void* message, const char* name) {
    for (int i = 0; i < info->num_fields(); i++) {
        lcm_field_t field;
        info->get_field(message, i, &field);
        if (strcmp(field.name, name) == 0) {
            return read_integer(field.type, field.data);
        }
    }
    assert(!"a field of this message");
    return 0;
}

/// Field number i of a message; its elements are NULL if it is a list that is not there yet.
static field_t field_at(const char* type, const lcm_type_info_t* info, const void* message, int i) {
    lcm_field_t found;
    info->get_field(message, i, &found);
    assert(found.num_dim <= 1);
    field_t field = {.of = type,
                     .name = found.name,
                     .type = found.typestr,
                     .kind = found.type,
                     .is_list = found.num_dim == 1,
                     .is_variable = found.num_dim == 1 && found.dim_is_variable[0],
                     .count = found.num_dim == 1 ? found.dim_size[0] : 1,
                     .element_size = size_of(found.type, found.typestr),
                     .elements = found.data};
    if (field.is_variable) {
        field.pointer = found.data;
        field.elements = *field.pointer;
    }
    const char* const counter = field.is_list ? names_counter_of(type, found.name) : NULL;
    field.most = field.count;
    if (counter != NULL) {
        field.count = (int32_t)number_in(info, message, counter);
    }
    return field;
}

int wire_field_names(const char* type, const char** names, int most) {
    _Alignas(max_align_t) char message[MESSAGE_SIZE_MAX] = {0};
    const lcm_type_info_t* const info = info_of(type);
    int count = 0;
    for (; count < info->num_fields() && count < most; count++) {
        names[count] = field_at(type, info, message, count).name;
    }
    return count;
}

/// Whether a field has all its 64 bits, hashes, random ids and choices, of which JSON readers with nothing but doubles
/// would lose eleven.
static bool is_hex(const field_t* field) {
    const char* const last = strrchr(field->name, '_');
    return field->kind == LCM_FIELD_INT64_T &&
           (names_is_choice(field->of, field->name) ||
            (last != NULL && (strcmp(last, "_hash") == 0 || strcmp(last, "_id") == 0)));
}

/// How many elements of a list may be looked at, whatever its message says.
static int32_t sound_count(const field_t* field) {
    return field->count < 0 ? 0 : field->count < field->most ? field->count : field->most;
}

/// Text that JSON can hold: what is not UTF-8 loses its non-ASCII bytes.
static json_t* text_json(const char* text) {
    json_t* json = json_string(text);
    char* const ascii = json == NULL ? strdup(text) : NULL;
    for (char* c = ascii; c != NULL && *c != '\0'; c++) {
        *c = (unsigned char)*c >= 0x80 ? '?' : *c;
    }
    json = ascii == NULL ? json : json_string(ascii);
    free(ascii);
    return json;
}

static json_t* element_json(const field_t* field, const void* element) {
    const names_t* const names = names_of_field(field->of, field->name);
    if (field->kind == LCM_FIELD_USER_TYPE) {
        return wire_to_json(field->type, element);
    }
    if (field->kind == LCM_FIELD_DOUBLE) {
        return json_real(*(const double*)element);
    }
    if (field->kind == LCM_FIELD_STRING) {
        const char* const text = *(char* const*)element;
        return text_json(text == NULL ? "" : text);
    }
    if (field->kind == LCM_FIELD_BOOLEAN) {
        return json_boolean(*(const int8_t*)element != 0);
    }
    const int64_t value = read_integer(field->kind, element);
    if (is_hex(field)) {
        return json_sprintf("%016" PRIx64, (uint64_t)value);
    }
    return names != NULL && value >= 0 && value < names->count ? json_string(names->words[value])
                                                               : json_integer((json_int_t)value);
}

json_t* wire_to_json(const char* type, const void* message) {
    const lcm_type_info_t* const info = info_of(type);
    json_t* const object = json_object();
    bool complete = object != NULL;
    for (int i = 0; complete && i < info->num_fields(); i++) {
        const field_t field = field_at(type, info, message, i);
        json_t* value = field.is_list ? json_array() : element_json(&field, field.elements);
        for (int32_t k = 0; field.is_list && complete && k < sound_count(&field); k++) {
            complete = json_array_append_new(
                           value, element_json(&field, field.elements + (size_t)k * field.element_size)) == 0;
        }
        complete = json_object_set_new(object, field.name, value) == 0 && complete;
    }
    if (!complete) {
        json_decref(object);
        return NULL;
    }
    return object;
}

bool wire_json_write(FILE* out, json_t* json) {
    const bool complete =
        json != NULL && json_dumpf(json, out, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) == 0 && fputc('\n', out) != EOF;
    json_decref(json);
    return complete;
}

static const char* kind_word(const tree_t* tree) {
    static const char* const words[] = {"nothing", "true or false", "a number", "a number",
                                        "a text",  "a list",        "a map"};
    return words[tree->kind];
}

/// What stands there, for a sentence: the text itself where that is known and short.
static void describe(const tree_t* tree, char* text, size_t size) {
    if (tree->text != NULL && strlen(tree->text) < 40) {
        snprintf(text, size, "'%s'", tree->text);
    } else {
        snprintf(text, size, "%s", kind_word(tree));
    }
}

static bool read_double(const tree_t* tree, double* value, tree_error_t* error) {
    char there[64];
    describe(tree, there, sizeof there);
    if (tree->kind != TREE_INTEGER && tree->kind != TREE_REAL) {
        return tree_fail(error, tree, "%s is not a number", there);
    }
    if (!isfinite(tree->real)) {
        return tree_fail(error, tree, "%s is not a finite number",
                         isnan(tree->real) ? "nan"
                         : tree->real < 0  ? "-inf"
                                           : "inf");
    }
    *value = tree->real;
    return true;
}

static bool read_hex(const tree_t* tree, int64_t* value, tree_error_t* error) {
    if (tree->kind != TREE_TEXT || strlen(tree->text) != 16 || strspn(tree->text, "0123456789abcdef") != 16) {
        return tree_fail(error, tree, "not a text of 16 hex digits");
    }
    *value = (int64_t)strtoull(tree->text, NULL, 16);
    return true;
}

static bool read_word(const names_t* names, const tree_t* tree, int8_t* value, tree_error_t* error) {
    char all[128] = "", there[64];
    *value = tree->kind == TREE_TEXT ? name_find(names, tree->text) : -1;
    if (*value >= 0) {
        return true;
    }
    for (int i = 0; i < names->count; i++) {
        const size_t used = strlen(all);
        snprintf(all + used, sizeof all - used, "%s%s", i > 0 ? ", " : "", names->words[i]);
    }
    describe(tree, there, sizeof there);
    return tree_fail(error, tree, "%s is none of %s", there, all);
}

static bool read_whole(lcm_field_type_t kind, const tree_t* tree, void* element, tree_error_t* error) {
    const int64_t max = kind == LCM_FIELD_INT8_T    ? INT8_MAX
                        : kind == LCM_FIELD_INT16_T ? INT16_MAX
                        : kind == LCM_FIELD_INT32_T ? INT32_MAX
                                                    : INT64_MAX;
    char there[64];
    describe(tree, there, sizeof there);
    if (tree->kind != TREE_INTEGER) {
        return tree_fail(error, tree, "%s is not a whole number", there);
    }
    const int64_t value = tree->integer;
    if (value > max || value < -max - 1) {
        return tree_fail(error, tree, "%" PRId64 " is outside [%" PRId64 ", %" PRId64 "]", value, -max - 1, max);
    }
    switch (kind) {
        case LCM_FIELD_INT8_T: *(int8_t*)element = (int8_t)value; break;
        case LCM_FIELD_INT16_T: *(int16_t*)element = (int16_t)value; break;
        case LCM_FIELD_INT32_T: *(int32_t*)element = (int32_t)value; break;
        default: *(int64_t*)element = value;
    }
    return true;
}

static bool fill(const char* type, const tree_t* tree, void* message, tree_error_t* error);

static bool read_element(const field_t* field, const tree_t* tree, void* element, tree_error_t* error) {
    const names_t* const names = names_of_field(field->of, field->name);
    if (field->kind == LCM_FIELD_USER_TYPE) {
        return fill(field->type, tree, element, error);
    }
    if (field->kind == LCM_FIELD_DOUBLE) {
        return read_double(tree, element, error);
    }
    if (field->kind == LCM_FIELD_STRING) {
        char* const text = tree->kind == TREE_TEXT ? strdup(tree->text) : NULL;
        *(char**)element = text;
        return text != NULL || tree_fail(error, tree, tree->kind == TREE_TEXT ? "out of memory" : "not a text");
    }
    if (field->kind == LCM_FIELD_BOOLEAN) {
        char there[64];
        describe(tree, there, sizeof there);
        *(int8_t*)element = tree->kind == TREE_BOOLEAN && tree->boolean;
        return tree->kind == TREE_BOOLEAN || tree_fail(error, tree, "%s is none of false, true", there);
    }
    if (is_hex(field)) {
        return read_hex(tree, element, error);
    }
    return names != NULL ? read_word(names, tree, element, error) : read_whole(field->kind, tree, element, error);
}

static bool read_list(field_t* field, const tree_t* tree, tree_error_t* error) {
    if (tree->kind != TREE_LIST) {
        return tree_fail(error, tree, "not a list of %d", (int)field->count);
    }
    const int32_t most = field->is_variable ? names_most_elements(field->of, field->name) : field->most;
    if (field->count < 0 || field->count > most) {
        return tree_fail(error, tree, "%d entries are counted, there may be 0 to %d", (int)field->count, (int)most);
    }
    if (tree->count != field->count) {
        return tree_fail(error, tree, "%d entries, there must be exactly %d", tree->count, (int)field->count);
    }
    if (field->is_variable) {
        field->elements = calloc((size_t)field->count + 1, field->element_size);
        *field->pointer = field->elements;
        if (field->elements == NULL) {
            return tree_fail(error, tree, "out of memory");
        }
    }
    for (int k = 0; k < tree->count; k++) {
        if (!read_element(field, tree->entries[k].value, field->elements + (size_t)k * field->element_size, error)) {
            return false;
        }
    }
    return true;
}

static bool all_known(const char* type, const tree_t* map, tree_error_t* error) {
    const char* names[FIELDS_MAX];
    const int count = wire_field_names(type, names, FIELDS_MAX);
    for (int i = 0; i < map->count; i++) {
        bool known = false;
        for (int k = 0; k < count && !known; k++) {
            known = strcmp(map->entries[i].key, names[k]) == 0;
        }
        if (!known) {
            const char* const nearest = tree_nearest(map->entries[i].key, names, count);
            return tree_fail_key(error, map, &map->entries[i], map->entries[i].key, "unknown key%s%s%s",
                                 nearest == NULL ? "" : "; did you mean ", nearest == NULL ? "" : nearest,
                                 nearest == NULL ? "" : "?");
        }
    }
    return true;
}

static bool fill(const char* type, const tree_t* tree, void* message, tree_error_t* error) {
    const lcm_type_info_t* const info = info_of(type);
    if (tree->kind != TREE_MAP) {
        return tree_fail(error, tree, "not a map of keys and values");
    }
    if (!all_known(type, tree, error)) {
        return false;
    }
    // Counts stand before their lists in every message, so a list finds its own.
    for (int i = 0; i < info->num_fields(); i++) {
        field_t field = field_at(type, info, message, i);
        const tree_t* const value = tree_get(tree, field.name);
        if (value == NULL) {
            return tree_fail_key(error, tree, NULL, field.name, "this key is missing");
        }
        if (!(field.is_list ? read_list(&field, value, error) : read_element(&field, value, field.elements, error))) {
            return false;
        }
    }
    return true;
}

bool wire_from_tree(const char* type, const tree_t* tree, void* message, tree_error_t* error) {
    memset(message, 0, (size_t)info_of(type)->struct_size());
    if (!fill(type, tree, message, error)) {
        wire_clear(type, message);
        return false;
    }
    return true;
}

bool wire_json_read(const char* file, const char* text, size_t size, const wire_part_t* parts, int count,
                    char* error_text, size_t error_size) {
    tree_memory_t memory = {NULL};
    tree_error_t error = {error_text, error_size};
    error_text[0] = '\0';
    const tree_t* const root = tree_from_json(&memory, &error, file, text, size);
    bool sound = root != NULL;
    for (int i = 0; i < count; i++) {
        const tree_t* const part = sound ? tree_get(root, parts[i].key) : NULL;
        memset(parts[i].message, 0, (size_t)info_of(parts[i].type)->struct_size());
        if (sound && part == NULL) {
            sound = tree_fail_key(&error, root, NULL, parts[i].key, "this key is missing");
        }
        sound = sound && part != NULL && wire_from_tree(parts[i].type, part, parts[i].message, &error);
    }
    for (int i = 0; i < count && !sound; i++) {
        wire_clear(parts[i].type, parts[i].message);
    }
    tree_memory_free(&memory);
    return sound;
}

void wire_clear(const char* type, void* message) {
    const lcm_type_info_t* const info = info_of(type);
    for (int i = 0; i < info->num_fields(); i++) {
        const field_t field = field_at(type, info, message, i);
        for (int32_t k = 0; field.elements != NULL && k < sound_count(&field); k++) {
            char* const element = field.elements + (size_t)k * field.element_size;
            if (field.kind == LCM_FIELD_USER_TYPE) {
                wire_clear(field.type, element);
            } else if (field.kind == LCM_FIELD_STRING) {
                free(*(char**)element);
            }
        }
        if (field.is_variable) {
            free(field.elements);
            *field.pointer = NULL; // counts are emptied below, after the lists that they count
        }
    }
    memset(message, 0, (size_t)info->struct_size());
}

/// What is left of the bytes of a message.
typedef struct {
    const uint8_t* data;
    size_t size;
} bytes_t;

static bool skip(bytes_t* bytes, size_t size) {
    if (size > bytes->size) {
        return false;
    }
    bytes->data += size;
    bytes->size -= size;
    return true;
}

static uint32_t read_u32(const uint8_t* data) {
    return (uint32_t)data[0] << 24 | (uint32_t)data[1] << 16 | (uint32_t)data[2] << 8 | data[3];
}

/// Steps over a string, which ends with its only terminator.
static bool skip_text(bytes_t* bytes) {
    const uint32_t length = bytes->size < 4 ? 0 : read_u32(bytes->data);
    if (length == 0 || !skip(bytes, 4) || length > bytes->size || bytes->data[length - 1] != '\0') {
        return false;
    }
    return skip(bytes, length);
}

/// Steps over the fields of a message. What it counts is noted in a message without content, where its lists find it.
static bool skip_message(const char* type, bytes_t* bytes) {
    _Alignas(max_align_t) char noted[MESSAGE_SIZE_MAX] = {0};
    const lcm_type_info_t* const info = info_of(type);
    assert((size_t)info->struct_size() <= sizeof noted);
    for (int i = 0; i < info->num_fields(); i++) {
        const field_t field = field_at(type, info, noted, i);
        if (field.is_variable && (field.count < 0 || field.count > names_most_elements(type, field.name))) {
            return false;
        }
        if (field.kind == LCM_FIELD_INT32_T && !field.is_list && bytes->size >= 4) {
            *(int32_t*)(void*)field.elements = (int32_t)read_u32(bytes->data);
        }
        for (int32_t k = 0; k < (field.is_variable ? field.count : field.most); k++) {
            if (!(field.kind == LCM_FIELD_USER_TYPE ? skip_message(field.type, bytes)
                  : field.kind == LCM_FIELD_STRING  ? skip_text(bytes)
                                                    : skip(bytes, field.element_size))) {
                return false;
            }
        }
    }
    return true;
}

static uint64_t read_hash(const void* data, size_t size) {
    return size < 8 ? 0 : (uint64_t)read_u32(data) << 32 | read_u32((const uint8_t*)data + 4);
}

bool wire_is_message(const char* type, const void* data, size_t size) {
    bytes_t bytes = {data, size};
    return skip(&bytes, 8) && read_hash(data, size) == (uint64_t)info_of(type)->get_hash() &&
           skip_message(type, &bytes) && bytes.size == 0;
}

bool wire_decode(const char* type, const void* data, size_t size, void* message) {
    memset(message, 0, wire_struct_size(type));
    return wire_is_message(type, data, size) && info_of(type)->decode(data, 0, (int)size, message) >= 0;
}

const char* wire_type_of(const char* const* types, const void* data, size_t size) {
    while (*types != NULL && read_hash(data, size) != (uint64_t)info_of(*types)->get_hash()) types++;
    return *types;
}

size_t wire_struct_size(const char* type) { return (size_t)info_of(type)->struct_size(); }
