#define _POSIX_C_SOURCE 200809L
#include "scenario_file.h"

#include <cyaml/cyaml.h>
#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ssv/planner.h"

#define NUM_PORTS 3

const char* const scenario_methods[2] = {"optimal", "paper"};
const char* const scenario_efforts[2] = {"quick", "best"};

// What the files hold. Every scalar is kept as text: libcyaml reads "1,5" as 1 and does not know ".nan", and the
// planner must see exactly what was written. NULL stands for an optional value that is absent.
typedef struct {
    char* mass_kg;
    char* inertia_kg_m2[3];
    char* added_mass_kg[3];
    char* drag_lin_kg_s;
    char* drag_quad_kg_m;
    char* drag_lin_ang_Nm_s;
    char* drag_quad_ang_Nm_s2;
} body_text_t;

typedef struct {
    char* p_ST_m[3];
    char* n_T_S[3];
} thruster_text_t;

typedef struct {
    body_text_t body;
    char* radius_m;
    char* force_max_N;
    thruster_text_t thrusters[SSV_NUM_THRUSTERS];
} vehicle_model_text_t;

typedef struct {
    body_text_t body;
    char* radius_m;
    char* length_m;
    char* drag_strip_kg_m2;
} beam_model_text_t;

typedef struct {
    char* p_HP_m[3];
    char* axis_H[3];
} hub_port_text_t;

typedef struct {
    hub_port_text_t ports[NUM_PORTS];
} hub_model_text_t;

typedef struct {
    vehicle_model_text_t vehicle;
    beam_model_text_t beam;
    hub_model_text_t hub;
} model_text_t;

typedef struct {
    char* p_IS_m[3];
    char* q_IS[4];
} vehicle_text_t;

typedef struct {
    char* p_IB_m[3];
    char* q_IB[4];
    char* contact;
} beam_text_t;

typedef struct {
    char* p_IP_m[3];
    char* axis_I[3];
} port_text_t;

typedef struct {
    char* p_IH_m[3];
    char* q_IH[4];
    char* port;
} hub_text_t;

typedef struct {
    char* time;
    char* impulse;
} weights_text_t;

typedef struct {
    char* model;
    vehicle_text_t vehicle;
    beam_text_t beam;
    port_text_t* port;
    hub_text_t* hub;
    char* standoff_m;
    weights_text_t weights;
    char** attach_heights_m;
    unsigned attach_heights_m_count;
    char* attach_anywhere;
    char* ring_angle_rad;
    char* method;
    char* effort;
    char* candidates;
    char* front;
} scenario_text_t;

#define REQUIRED CYAML_FLAG_DEFAULT
#define OPTIONAL CYAML_FLAG_OPTIONAL
#define SCALAR(flag, type, key) CYAML_FIELD_STRING_PTR(#key, flag, type, key, 0, CYAML_UNLIMITED)
#define VECTOR(flag, type, key, count) CYAML_FIELD_SEQUENCE_FIXED(#key, flag, type, key, &scalar, count)
#define MAPPING(type, key, fields) CYAML_FIELD_MAPPING(#key, REQUIRED, type, key, fields)

static const cyaml_schema_value_t scalar = {CYAML_VALUE_STRING(CYAML_FLAG_POINTER, char*, 0, CYAML_UNLIMITED)};

// A body's keys stand beside those of the thing it is the body of.
#define BODY_SCALAR(flag, type, key) CYAML_FIELD_STRING_PTR(#key, flag, type, body.key, 0, CYAML_UNLIMITED)
#define BODY_VECTOR(flag, type, key) CYAML_FIELD_SEQUENCE_FIXED(#key, flag, type, body.key, &scalar, 3)
#define BODY(type)                                                                                                     \
    BODY_SCALAR(REQUIRED, type, mass_kg), BODY_VECTOR(REQUIRED, type, inertia_kg_m2),                                  \
        BODY_VECTOR(OPTIONAL, type, added_mass_kg), BODY_SCALAR(OPTIONAL, type, drag_lin_kg_s),                        \
        BODY_SCALAR(OPTIONAL, type, drag_quad_kg_m), BODY_SCALAR(OPTIONAL, type, drag_lin_ang_Nm_s),                   \
        BODY_SCALAR(OPTIONAL, type, drag_quad_ang_Nm_s2)

static const cyaml_schema_field_t thruster_fields[] = {
    VECTOR(REQUIRED, thruster_text_t, p_ST_m, 3),
    VECTOR(REQUIRED, thruster_text_t, n_T_S, 3),
    CYAML_FIELD_END,
};
static const cyaml_schema_value_t thruster_value = {
    CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, thruster_text_t, thruster_fields)};

static const cyaml_schema_field_t vehicle_model_fields[] = {
    BODY(vehicle_model_text_t),
    SCALAR(REQUIRED, vehicle_model_text_t, radius_m),
    SCALAR(REQUIRED, vehicle_model_text_t, force_max_N),
    CYAML_FIELD_SEQUENCE_FIXED("thrusters", REQUIRED, vehicle_model_text_t, thrusters, &thruster_value,
                               SSV_NUM_THRUSTERS),
    CYAML_FIELD_END,
};

static const cyaml_schema_field_t beam_model_fields[] = {
    BODY(beam_model_text_t),
    SCALAR(REQUIRED, beam_model_text_t, radius_m),
    SCALAR(REQUIRED, beam_model_text_t, length_m),
    SCALAR(OPTIONAL, beam_model_text_t, drag_strip_kg_m2),
    CYAML_FIELD_END,
};

static const cyaml_schema_field_t hub_port_fields[] = {
    VECTOR(REQUIRED, hub_port_text_t, p_HP_m, 3),
    VECTOR(REQUIRED, hub_port_text_t, axis_H, 3),
    CYAML_FIELD_END,
};
static const cyaml_schema_value_t hub_port_value = {
    CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, hub_port_text_t, hub_port_fields)};

static const cyaml_schema_field_t hub_model_fields[] = {
    CYAML_FIELD_SEQUENCE_FIXED("ports", REQUIRED, hub_model_text_t, ports, &hub_port_value, NUM_PORTS),
    CYAML_FIELD_END,
};

static const cyaml_schema_field_t model_fields[] = {
    MAPPING(model_text_t, vehicle, vehicle_model_fields),
    MAPPING(model_text_t, beam, beam_model_fields),
    MAPPING(model_text_t, hub, hub_model_fields),
    CYAML_FIELD_END,
};
static const cyaml_schema_value_t model_schema = {CYAML_VALUE_MAPPING(CYAML_FLAG_POINTER, model_text_t, model_fields)};

static const cyaml_schema_field_t vehicle_fields[] = {
    VECTOR(REQUIRED, vehicle_text_t, p_IS_m, 3),
    VECTOR(REQUIRED, vehicle_text_t, q_IS, 4),
    CYAML_FIELD_END,
};

static const cyaml_schema_field_t beam_fields[] = {
    VECTOR(REQUIRED, beam_text_t, p_IB_m, 3),
    VECTOR(REQUIRED, beam_text_t, q_IB, 4),
    SCALAR(REQUIRED, beam_text_t, contact),
    CYAML_FIELD_END,
};

static const cyaml_schema_field_t port_fields[] = {
    VECTOR(REQUIRED, port_text_t, p_IP_m, 3),
    VECTOR(REQUIRED, port_text_t, axis_I, 3),
    CYAML_FIELD_END,
};

static const cyaml_schema_field_t hub_fields[] = {
    VECTOR(REQUIRED, hub_text_t, p_IH_m, 3),
    VECTOR(REQUIRED, hub_text_t, q_IH, 4),
    SCALAR(REQUIRED, hub_text_t, port),
    CYAML_FIELD_END,
};

static const cyaml_schema_field_t weights_fields[] = {
    SCALAR(REQUIRED, weights_text_t, time),
    SCALAR(REQUIRED, weights_text_t, impulse),
    CYAML_FIELD_END,
};

static const cyaml_schema_field_t scenario_fields[] = {
    SCALAR(REQUIRED, scenario_text_t, model),
    MAPPING(scenario_text_t, vehicle, vehicle_fields),
    MAPPING(scenario_text_t, beam, beam_fields),
    CYAML_FIELD_MAPPING_PTR("port", OPTIONAL, scenario_text_t, port, port_fields),
    CYAML_FIELD_MAPPING_PTR("hub", OPTIONAL, scenario_text_t, hub, hub_fields),
    SCALAR(OPTIONAL, scenario_text_t, standoff_m),
    MAPPING(scenario_text_t, weights, weights_fields),
    CYAML_FIELD_SEQUENCE("attach_heights_m", CYAML_FLAG_POINTER | OPTIONAL, scenario_text_t, attach_heights_m, &scalar,
                         1, SSV_MAX_ATTACH_HEIGHTS),
    SCALAR(OPTIONAL, scenario_text_t, attach_anywhere),
    SCALAR(OPTIONAL, scenario_text_t, ring_angle_rad),
    SCALAR(OPTIONAL, scenario_text_t, method),
    SCALAR(OPTIONAL, scenario_text_t, effort),
    SCALAR(OPTIONAL, scenario_text_t, candidates),
    SCALAR(OPTIONAL, scenario_text_t, front),
    CYAML_FIELD_END,
};
static const cyaml_schema_value_t scenario_schema = {
    CYAML_VALUE_MAPPING(CYAML_FLAG_POINTER, scenario_text_t, scenario_fields)};

/// Where the first thing that is wrong is told.
typedef struct {
    const char* file;
    char* text; ///< empty as long as nothing is wrong
    size_t size;
} error_t;

/// "FILE: sentence", or "FILE:LINE: sentence" when the line is known (> 0). Only the first call counts.
__attribute__((format(printf, 3, 4))) static void error_set(error_t* error, int line, const char* format, ...) {
    if (error->text[0] != '\0') {
        return;
    }
    char sentence[512];
    va_list args;
    va_start(args, format);
    vsnprintf(sentence, sizeof sentence, format, args);
    va_end(args);
    if (line > 0) {
        snprintf(error->text, error->size, "%s:%d: %s", error->file, line, sentence);
    } else {
        snprintf(error->text, error->size, "%s: %s", error->file, sentence);
    }
    // Keys and values come from the file: what would steer a terminal is not passed on.
    for (char* c = error->text; *c != '\0'; c++) {
        if ((unsigned char)*c < ' ' || *c == 0x7f) {
            *c = '?';
        }
    }
}

static bool error_is_set(const error_t* error) { return error->text[0] != '\0'; }

int8_t word_find(const char* text, const char* const* words, int count) {
    for (int i = 0; i < count; i++) {
        if (strcmp(text, words[i]) == 0) {
            return (int8_t)i;
        }
    }
    return -1;
}

bool number_parse(const char* text, double* value) {
    const char* const sign_end = text + (*text == '-' || *text == '+');
    if (strcmp(text, ".nan") == 0 || strcmp(text, ".NaN") == 0 || strcmp(text, ".NAN") == 0) {
        *value = (double)NAN;
        return true;
    }
    if (strcmp(sign_end, ".inf") == 0 || strcmp(sign_end, ".Inf") == 0 || strcmp(sign_end, ".INF") == 0) {
        *value = *text == '-' ? -(double)INFINITY : (double)INFINITY;
        return true;
    }
    if (*text == '\0' || text[strspn(text, "0123456789.eE+-")] != '\0') {
        return false;
    }
    char* end = NULL;
    const double parsed = strtod(text, &end);
    if (*end != '\0') {
        return false;
    }
    *value = parsed;
    return true;
}

/// What libcyaml logs on its way out of a file that it refuses: a message, then the places around it, innermost first.
typedef struct {
    char message[256];
    char path[256]; ///< of the keys, "vehicle.thrusters[2].n_T_S"
    int line;       ///< of the innermost place, 0 = unknown
} refusal_t;

/// A path too long to hold keeps its inner end.
static void path_prepend(char* path, size_t size, const char* name, size_t name_length) {
    const size_t tail = strlen(path);
    const bool joint = tail > 0 && path[0] != '[';
    const size_t head = name_length + (joint ? 1 : 0);
    if (head + tail >= size) {
        return;
    }
    memmove(path + head, path, tail + 1);
    memcpy(path, name, name_length);
    if (joint) {
        path[name_length] = '.';
    }
}

static void refusal_note(cyaml_log_t level, void* context, const char* format, va_list args) {
    (void)level;
    refusal_t* refusal = context;
    char entry[256];
    vsnprintf(entry, sizeof entry, format, args);
    entry[strcspn(entry, "\n")] = '\0';

    if (strncmp(entry, "  in ", 5) != 0) {
        if (refusal->message[0] == '\0') {
            const char* const load = "Load: ";
            const size_t skip = strncmp(entry, load, strlen(load)) == 0 ? strlen(load) : 0;
            snprintf(refusal->message, sizeof refusal->message, "%s", entry + skip);
        }
        return;
    }
    const char* const line = strstr(entry, "(line: ");
    if (line != NULL && refusal->line == 0) {
        refusal->line = (int)strtol(line + strlen("(line: "), NULL, 10);
    }
    const char* const name = strchr(entry, '\'');
    const char* const name_end = name == NULL ? NULL : strchr(name + 1, '\'');
    if (name_end == NULL) {
        return;
    }
    if (strncmp(entry, "  in sequence", strlen("  in sequence")) == 0) {
        const long entry_number = strtol(name + 1, NULL, 10);
        char index[32];
        snprintf(index, sizeof index, "[%ld]", entry_number - 1);
        // A wrong number of entries is the sequence's fault, not that of the entry where the reader stood.
        if (entry_number > 0 && strstr(refusal->message, " entries ") == NULL) {
            path_prepend(refusal->path, sizeof refusal->path, index, strlen(index));
        }
        return;
    }
    // A key is found missing when its mapping ends; the innermost place is then the key that came last, which is no
    // fault.
    const char* const missing = "Missing required mapping field: ";
    if (refusal->path[0] == '\0' && strncmp(refusal->message, missing, strlen(missing)) == 0) {
        snprintf(refusal->path, sizeof refusal->path, "%s", refusal->message + strlen(missing));
        return;
    }
    path_prepend(refusal->path, sizeof refusal->path, name + 1, (size_t)(name_end - name - 1));
}

/// The first line, not before the one given, on which the key stands: libcyaml knows only where the value before it is.
static int line_of_key(const char* text, int from_line, const char* key) {
    const size_t key_length = strlen(key);
    for (int line = 1; *text != '\0'; line++) {
        const size_t code_length = strcspn(text, "#\n");
        for (size_t i = 0; line >= from_line && i + key_length < code_length; i++) {
            if (strncmp(text + i, key, key_length) == 0 && text[i + key_length] == ':' &&
                (i == 0 || strchr(" -{,\"'", text[i - 1]) != NULL)) {
                return line;
            }
        }
        text += strcspn(text, "\n");
        text += *text == '\n';
    }
    return from_line;
}

/// libcyaml's message in the words of a user who knows keys and lists, not libcyaml; any other message as it is.
static void error_set_refusal(error_t* error, const refusal_t* refusal, const char* text, cyaml_err_t status) {
    const char* const missing = "Missing required mapping field: ";
    const char* const unknown = "Unexpected key: ";
    const char* const parser = "libyaml: ";
    const char* const message = refusal->message[0] != '\0' ? refusal->message : cyaml_strerror(status);
    int entries = 0, entries_limit = 0;
    if (strncmp(message, missing, strlen(missing)) == 0) {
        const char* const path = refusal->path[0] != '\0' ? refusal->path : message + strlen(missing);
        error_set(error, refusal->line, "%s: this key is missing", path);
        return;
    }
    if (strncmp(message, unknown, strlen(unknown)) == 0) {
        const char* const joint = refusal->path[0] != '\0' ? "." : "";
        const char* const key = message + strlen(unknown);
        error_set(error, line_of_key(text, refusal->line, key), "%s%s%s: unknown key", refusal->path, joint, key);
        return;
    }
    if (strncmp(message, parser, strlen(parser)) == 0) {
        error_set(error, refusal->line, "not YAML: %s", message + strlen(parser));
        return;
    }
    if (sscanf(message, "Insufficient entries (%d of %d min)", &entries, &entries_limit) == 2) {
        error_set(error, refusal->line, "%s: %d entries, there must be %d or more", refusal->path, entries,
                  entries_limit);
        return;
    }
    if (sscanf(message, "Excessive entries (%d max)", &entries_limit) == 1) {
        error_set(error, refusal->line, "%s: more than %d entries", refusal->path, entries_limit);
        return;
    }
    if (strncmp(message, "Mapping field already seen", strlen("Mapping field already seen")) == 0) {
        error_set(error, refusal->line, "%s: this key stands there twice", refusal->path);
        return;
    }
    error_set(error, refusal->line, "%s%s%s", refusal->path, refusal->path[0] != '\0' ? ": " : "", message);
}

/// The whole file with a '\0' after it, or NULL with the error set. The caller frees it.
static uint8_t* file_read(error_t* error, size_t* size) {
    FILE* file = fopen(error->file, "rb");
    if (file == NULL) {
        error_set(error, 0, "cannot open: %s", strerror(errno));
        return NULL;
    }
    uint8_t* data = malloc(SCENARIO_FILE_SIZE_MAX + 1);
    if (data == NULL) {
        error_set(error, 0, "cannot read: out of memory");
        fclose(file);
        return NULL;
    }
    *size = fread(data, 1, SCENARIO_FILE_SIZE_MAX + 1, file);
    if (ferror(file)) {
        error_set(error, 0, "cannot read: %s", strerror(errno));
    } else if (*size > SCENARIO_FILE_SIZE_MAX) {
        error_set(error, 0, "larger than %d bytes, so not a file of ours", SCENARIO_FILE_SIZE_MAX);
    }
    fclose(file);
    if (error_is_set(error)) {
        free(data);
        return NULL;
    }
    data[*size] = '\0';
    return data;
}

/// What the file holds by its schema, or NULL with the error set. The caller frees it with text_free.
static void* text_read(error_t* error, const cyaml_schema_value_t* schema) {
    size_t size = 0;
    uint8_t* data = file_read(error, &size);
    if (data == NULL) {
        return NULL;
    }
    refusal_t refusal = {.line = 0};
    const cyaml_config_t config = {
        .log_fn = refusal_note, .log_ctx = &refusal, .log_level = CYAML_LOG_WARNING, .mem_fn = cyaml_mem};
    cyaml_data_t* text = NULL;
    const cyaml_err_t status = cyaml_load_data(data, size, &config, schema, &text, NULL);
    // A warning says that something in the file was passed over, which nobody who wrote it expects.
    if (status != CYAML_OK || refusal.message[0] != '\0') {
        error_set_refusal(error, &refusal, (const char*)data, status);
    } else if (text == NULL) {
        error_set(error, 0, "empty: no key is in it");
    }
    free(data);
    if (error_is_set(error)) {
        cyaml_free(&config, schema, text, 0);
        return NULL;
    }
    return text;
}

static void text_free(void* text, const cyaml_schema_value_t* schema) {
    const cyaml_config_t config = {.mem_fn = cyaml_mem};
    cyaml_free(&config, schema, text, 0);
}

/// The number that the text of a key is; 0 if it is absent.
static double number(error_t* error, const char* where, const char* key, const char* text) {
    double value = 0;
    if (text != NULL && !number_parse(text, &value)) {
        error_set(error, 0, "%s%s: '%s' is not a number", where, key, text);
    }
    return value;
}

static void numbers(error_t* error, const char* where, const char* key, char* const* text, int count, double* values) {
    for (int i = 0; i < count; i++) {
        char element[64];
        snprintf(element, sizeof element, "%s[%d]", key, i);
        values[i] = number(error, where, element, text[i]);
    }
}

/// Which of the values stands there; 0 with the error set if none does.
static int8_t one_of(error_t* error, const char* key, const char* text, const char* const* values, int count) {
    const int8_t found = word_find(text, values, count);
    if (found >= 0) {
        return found;
    }
    char all[64] = "";
    for (int i = 0; i < count; i++) {
        const size_t used = strlen(all);
        snprintf(all + used, sizeof all - used, "%s%s", i > 0 ? ", " : "", values[i]);
    }
    error_set(error, 0, "%s: '%s' is none of %s", key, text, all);
    return 0;
}

static void body_convert(error_t* error, const char* where, const body_text_t* text, lcm_ssv_body_t* body) {
    body->mass_kg = number(error, where, "mass_kg", text->mass_kg);
    numbers(error, where, "inertia_kg_m2", text->inertia_kg_m2, 3, body->inertia_kg_m2);
    numbers(error, where, "added_mass_kg", text->added_mass_kg, 3, body->added_mass_kg);
    body->drag_lin_kg_s = number(error, where, "drag_lin_kg_s", text->drag_lin_kg_s);
    body->drag_quad_kg_m = number(error, where, "drag_quad_kg_m", text->drag_quad_kg_m);
    body->drag_lin_ang_Nm_s = number(error, where, "drag_lin_ang_Nm_s", text->drag_lin_ang_Nm_s);
    body->drag_quad_ang_Nm_s2 = number(error, where, "drag_quad_ang_Nm_s2", text->drag_quad_ang_Nm_s2);
}

static void model_convert(error_t* error, const model_text_t* text, lcm_ssv_scenario_t* scenario) {
    body_convert(error, "vehicle.", &text->vehicle.body, &scenario->vehicle.body);
    scenario->vehicle.radius_m = number(error, "vehicle.", "radius_m", text->vehicle.radius_m);
    scenario->vehicle.force_max_N = number(error, "vehicle.", "force_max_N", text->vehicle.force_max_N);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        char where[64];
        snprintf(where, sizeof where, "vehicle.thrusters[%d].", i);
        numbers(error, where, "p_ST_m", text->vehicle.thrusters[i].p_ST_m, 3, scenario->vehicle.thruster[i].p_ST_m);
        numbers(error, where, "n_T_S", text->vehicle.thrusters[i].n_T_S, 3, scenario->vehicle.thruster[i].n_T_S);
    }
    body_convert(error, "beam.", &text->beam.body, &scenario->beam.body);
    scenario->beam.radius_m = number(error, "beam.", "radius_m", text->beam.radius_m);
    scenario->beam.length_m = number(error, "beam.", "length_m", text->beam.length_m);
    scenario->beam.drag_strip_kg_m2 = number(error, "beam.", "drag_strip_kg_m2", text->beam.drag_strip_kg_m2);
}

/// Faults of numbers that the planner never sees by themselves, in the planner's words.
static void check_finite(error_t* error, const char* key, const double* values, int count) {
    for (int i = 0; i < count; i++) {
        if (!isfinite(values[i])) {
            error_set(error, 0, "%s: %s is not a finite number", key,
                      isnan(values[i]) ? "nan"
                      : values[i] < 0  ? "-inf"
                                       : "inf");
        }
    }
}

static void check_unit(error_t* error, const char* key, const double* values, int count) {
    double square = 0;
    for (int i = 0; i < count; i++) {
        square += values[i] * values[i];
    }
    check_finite(error, key, values, count);
    const double tolerance = real_to_double(SSV_UNIT_TOLERANCE);
    if (!(fabs(sqrt(square) - 1) <= tolerance)) {
        error_set(error, 0, "%s: length %.9g is not 1 within %.3g", key, sqrt(square), tolerance);
    }
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

/// The port in I from the hub's pose (scenario file) and the port in H (model file).
static void hub_convert(error_t* scenario_error, error_t* model_error, const hub_text_t* hub,
                        const hub_model_text_t* model, lcm_ssv_port_t* port) {
    static const char* const names[NUM_PORTS] = {"1", "2", "3"};
    double p_IH_m[3], q_IH[4], p_HP_m[NUM_PORTS][3], axis_H[NUM_PORTS][3];
    numbers(scenario_error, "hub.", "p_IH_m", hub->p_IH_m, 3, p_IH_m);
    numbers(scenario_error, "hub.", "q_IH", hub->q_IH, 4, q_IH);
    check_finite(scenario_error, "hub.p_IH_m", p_IH_m, 3);
    check_unit(scenario_error, "hub.q_IH", q_IH, 4);
    const int chosen = one_of(scenario_error, "hub.port", hub->port, names, NUM_PORTS);
    for (int i = 0; i < NUM_PORTS; i++) {
        char key[64];
        snprintf(key, sizeof key, "hub.ports[%d].", i);
        numbers(model_error, key, "p_HP_m", model->ports[i].p_HP_m, 3, p_HP_m[i]);
        numbers(model_error, key, "axis_H", model->ports[i].axis_H, 3, axis_H[i]);
        snprintf(key, sizeof key, "hub.ports[%d].p_HP_m", i);
        check_finite(model_error, key, p_HP_m[i], 3);
        snprintf(key, sizeof key, "hub.ports[%d].axis_H", i);
        check_unit(model_error, key, axis_H[i], 3);
    }
    if (error_is_set(scenario_error)) {
        return;
    }
    turn(q_IH, p_HP_m[chosen], port->p_IP_m);
    turn(q_IH, axis_H[chosen], port->axis_I);
    for (int i = 0; i < 3; i++) {
        port->p_IP_m[i] += p_IH_m[i];
    }
}

static void scenario_convert(error_t* error, const scenario_text_t* text, lcm_ssv_scenario_t* scenario) {
    static const char* const contacts[3] = {"either", "1", "2"};
    static const char* const booleans[2] = {"false", "true"};
    numbers(error, "vehicle.", "p_IS_m", text->vehicle.p_IS_m, 3, scenario->X_IS.p_m);
    numbers(error, "vehicle.", "q_IS", text->vehicle.q_IS, 4, scenario->X_IS.q);
    numbers(error, "beam.", "p_IB_m", text->beam.p_IB_m, 3, scenario->X_IB.p_m);
    numbers(error, "beam.", "q_IB", text->beam.q_IB, 4, scenario->X_IB.q);
    scenario->contact = one_of(error, "beam.contact", text->beam.contact, contacts, 3);
    if (text->port != NULL) {
        numbers(error, "port.", "p_IP_m", text->port->p_IP_m, 3, scenario->port.p_IP_m);
        numbers(error, "port.", "axis_I", text->port->axis_I, 3, scenario->port.axis_I);
    }
    scenario->standoff_m = text->standoff_m == NULL ? scenario->vehicle.radius_m + scenario->beam.radius_m
                                                    : number(error, "", "standoff_m", text->standoff_m);
    scenario->weight_time_per_s = number(error, "weights.", "time", text->weights.time);
    scenario->weight_impulse_per_Ns = number(error, "weights.", "impulse", text->weights.impulse);
    const int heights = (int)text->attach_heights_m_count;
    scenario->options.num_attach_heights = (int8_t)heights;
    numbers(error, "", "attach_heights_m", text->attach_heights_m, heights, scenario->options.attach_heights_m);
    scenario->options.attach_anywhere =
        text->attach_anywhere != NULL && one_of(error, "attach_anywhere", text->attach_anywhere, booleans, 2) == 1;
    scenario->options.ring_angle_given = text->ring_angle_rad != NULL;
    scenario->options.ring_angle_rad = number(error, "", "ring_angle_rad", text->ring_angle_rad);
    const char* const method = text->method == NULL ? SCENARIO_METHOD_DEFAULT : text->method;
    const char* const effort = text->effort == NULL ? SCENARIO_EFFORT_DEFAULT : text->effort;
    scenario->options.method = one_of(error, "method", method, scenario_methods, 2);
    scenario->options.effort = one_of(error, "effort", effort, scenario_efforts, 2);
    scenario->options.want_candidates =
        text->candidates != NULL && one_of(error, "candidates", text->candidates, booleans, 2) == 1;
    scenario->options.want_front = text->front != NULL && one_of(error, "front", text->front, booleans, 2) == 1;
}

static int is_model_file(const struct dirent* entry) {
    const char* const dot = strrchr(entry->d_name, '.');
    return dot != NULL && strcmp(dot, ".yaml") == 0;
}

/// Says which models there are.
static void error_set_unknown_model(error_t* error, const char* model, const char* models_dir) {
    char names[256] = "";
    struct dirent** entries = NULL;
    const int count = scandir(models_dir, &entries, is_model_file, alphasort);
    for (int i = 0; i < count; i++) {
        const size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%.*s", i > 0 ? ", " : "",
                 (int)(strrchr(entries[i]->d_name, '.') - entries[i]->d_name), entries[i]->d_name);
        free(entries[i]);
    }
    free(entries);
    error_set(error, 0, "model: '%s' is none of the models (%s) in %s; give one of your own by its path, %s.yaml",
              model, names, models_dir, model);
}

/// The model's file: a name stands for one in models_dir, anything with a slash or .yaml is a path from the scenario
/// file.
static bool model_path(error_t* error, const char* model, const char* models_dir, char* path, size_t size) {
    const size_t length = strlen(model);
    const bool has_suffix = length > 5 && strcmp(model + length - 5, ".yaml") == 0;
    int written = 0;
    if (model[0] == '/') {
        written = snprintf(path, size, "%s", model);
    } else if (has_suffix || strchr(model, '/') != NULL) {
        const char* const slash = strrchr(error->file, '/');
        const int folder_length = slash == NULL ? 0 : (int)(slash + 1 - error->file);
        written = snprintf(path, size, "%.*s%s", folder_length, error->file, model);
    } else {
        written = snprintf(path, size, "%s/%s.yaml", models_dir, model);
        FILE* file = fopen(path, "rb");
        if (file == NULL) {
            error_set_unknown_model(error, model, models_dir);
            return false;
        }
        fclose(file);
    }
    if (written < 0 || (size_t)written >= size) {
        error_set(error, 0, "model: the path is too long");
        return false;
    }
    return true;
}

static bool model_read(error_t* error, const scenario_text_t* text, const char* models_dir,
                       lcm_ssv_scenario_t* scenario) {
    char path[PATH_MAX];
    if (!model_path(error, text->model, models_dir, path, sizeof path)) {
        return false;
    }
    error_t model_error = {path, error->text, error->size};
    model_text_t* model = text_read(&model_error, &model_schema);
    if (model == NULL) {
        return false;
    }
    model_convert(&model_error, model, scenario);
    if (text->hub != NULL) {
        hub_convert(error, &model_error, text->hub, &model->hub, &scenario->port);
    }
    text_free(model, &model_schema);
    return !error_is_set(error);
}

bool scenario_file_read(const char* path, const char* models_dir, lcm_ssv_scenario_t* scenario, char* error_text,
                        size_t error_size) {
    error_text[0] = '\0';
    error_t error = {path, error_text, error_size};
    scenario_text_t* text = text_read(&error, &scenario_schema);
    if (text == NULL) {
        return false;
    }
    memset(scenario, 0, sizeof *scenario);
    if (text->port == NULL && text->hub == NULL) {
        error_set(&error, 0, "port: this key is missing; give port {p_IP_m, axis_I} or hub {p_IH_m, q_IH, port}");
    } else if (text->port != NULL && text->hub != NULL) {
        error_set(&error, 0, "hub: port is given too; give one of the two");
    } else if (model_read(&error, text, models_dir, scenario)) {
        scenario_convert(&error, text, scenario);
    }
    text_free(text, &scenario_schema);
    return !error_is_set(&error);
}
