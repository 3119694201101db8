#include "plan_file.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_FILE_BYTES ((size_t)16 << 20)
#define MAX_SEGMENTS ((size_t)100000)
#define MAX_LEGS ((size_t)100000)
#define MAX_DURATION_S 1e5
#define UNIT_TOLERANCE 1e-3
#define PI 3.14159265358979323846

/// Ranges wide enough for any vehicle in any tank; they keep the arithmetic finite.
typedef enum { POSITIVE, NOT_NEGATIVE, ANY } sign_t;
#define LARGEST 1e10
#define SMALLEST 1e-6

/// The first thing found wrong stays; reading goes on with zeros, so callers need not look after each step.
typedef struct {
    const char* file;
    char* error;
    size_t error_size;
    bool failed;
} reader_t;

/// A value and where it stands, e.g. "timeline.segments[3].t_s". The value of a missing one is NULL.
typedef struct {
    json_t* json;
    char path[112];
} node_t;

__attribute__((format(printf, 3, 4))) static void fail(reader_t* reader, const char* path, const char* format, ...) {
    if (reader->failed) {
        return;
    }
    reader->failed = true;
    const int used = snprintf(reader->error, reader->error_size, "%s: %s%s", reader->file, path, *path ? ": " : "");
    if (used >= 0 && (size_t)used < reader->error_size) {
        va_list arguments;
        va_start(arguments, format);
        vsnprintf(reader->error + used, reader->error_size - (size_t)used, format, arguments);
        va_end(arguments);
    }
}

static node_t member(reader_t* reader, const node_t* object, const char* key) {
    node_t node = {NULL, ""};
    snprintf(node.path, sizeof node.path, "%.80s%s%.24s", object->path, *object->path ? "." : "", key);
    if (object->json == NULL) {
        return node;
    }
    if (!json_is_object(object->json)) {
        fail(reader, object->path, "must be an object with the key \"%s\"", key);
        return node;
    }
    node.json = json_object_get(object->json, key);
    if (node.json == NULL) {
        fail(reader, node.path, "is missing");
    }
    return node;
}

static node_t element(const node_t* array, size_t index) {
    node_t node = {json_array_get(array->json, index), ""};
    snprintf(node.path, sizeof node.path, "%.90s[%zu]", array->path, index);
    return node;
}

static size_t length(reader_t* reader, const node_t* array, size_t max) {
    if (array->json == NULL) {
        return 0;
    }
    if (!json_is_array(array->json)) {
        fail(reader, array->path, "must be a list");
        return 0;
    }
    const size_t n = json_array_size(array->json);
    if (n > max) {
        fail(reader, array->path, "has %zu elements, at most %zu are accepted", n, max);
        return 0;
    }
    return n;
}

static double number(reader_t* reader, const node_t* node, sign_t sign) {
    if (node->json == NULL) {
        return 0;
    }
    if (!json_is_number(node->json)) {
        fail(reader, node->path, "must be a number");
        return 0;
    }
    const double value = json_number_value(node->json);
    const double min = sign == POSITIVE ? SMALLEST : sign == NOT_NEGATIVE ? 0 : -LARGEST;
    if (!(value >= min && value <= LARGEST)) {
        fail(reader, node->path, "%.9g is outside [%g, %g]", value, min, LARGEST);
        return 0;
    }
    return value;
}

static double number_at(reader_t* reader, const node_t* object, const char* key, sign_t sign) {
    const node_t node = member(reader, object, key);
    return number(reader, &node, sign);
}

static long long integer_at(reader_t* reader, const node_t* object, const char* key) {
    const node_t node = member(reader, object, key);
    if (node.json != NULL && !json_is_integer(node.json)) {
        fail(reader, node.path, "must be a whole number");
    }
    return json_integer_value(node.json);
}

static const char* string_at(reader_t* reader, const node_t* object, const char* key) {
    const node_t node = member(reader, object, key);
    if (node.json != NULL && !json_is_string(node.json)) {
        fail(reader, node.path, "must be a text");
    }
    const char* text = json_string_value(node.json);
    return text == NULL ? "" : text;
}

static void numbers_at(reader_t* reader, const node_t* object, const char* key, size_t count, sign_t sign,
                       double* out) {
    const node_t node = member(reader, object, key);
    const size_t n = length(reader, &node, count);
    if (node.json != NULL && n != count) {
        fail(reader, node.path, "must be a list of %zu numbers", count);
    }
    for (size_t i = 0; i < count; i++) {
        const node_t item = element(&node, i);
        out[i] = number(reader, &item, sign);
    }
}

static void unit_at(reader_t* reader, const node_t* object, const char* key, size_t count, double* out) {
    numbers_at(reader, object, key, count, ANY, out);
    double square = 0;
    for (size_t i = 0; i < count; i++) {
        square += out[i] * out[i];
    }
    const double norm = sqrt(square);
    if (reader->failed) {
        return;
    }
    if (fabs(norm - 1) > UNIT_TOLERANCE) {
        const node_t node = member(reader, object, key);
        fail(reader, node.path, "has length %.9g, must be 1 within %g", norm, UNIT_TOLERANCE);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        out[i] /= norm;
    }
}

static rb_body_t body(reader_t* reader, const node_t* object) {
    rb_body_t b = {0};
    b.mass_kg = number_at(reader, object, "mass_kg", POSITIVE);
    numbers_at(reader, object, "inertia_kg_m2", 3, POSITIVE, b.inertia_kg_m2);
    numbers_at(reader, object, "added_mass_kg", 3, NOT_NEGATIVE, b.added_mass_kg);
    b.drag_lin_kg_s = number_at(reader, object, "drag_lin_kg_s", NOT_NEGATIVE);
    b.drag_quad_kg_m = number_at(reader, object, "drag_quad_kg_m", NOT_NEGATIVE);
    b.drag_lin_ang_Nm_s = number_at(reader, object, "drag_lin_ang_Nm_s", NOT_NEGATIVE);
    b.drag_quad_ang_Nm_s2 = number_at(reader, object, "drag_quad_ang_Nm_s2", NOT_NEGATIVE);
    return b;
}

static void read_task(reader_t* reader, const node_t* scenario, plan_file_t* plan) {
    const node_t vehicle = member(reader, scenario, "vehicle"), beam = member(reader, scenario, "beam");
    plan->vehicle = body(reader, &vehicle);
    plan->force_max_N = number_at(reader, &vehicle, "force_max_N", POSITIVE);
    const node_t thrusters = member(reader, &vehicle, "thrusters");
    if (length(reader, &thrusters, PLAN_THRUSTERS) != PLAN_THRUSTERS) {
        fail(reader, thrusters.path, "must be a list of %d thrusters", PLAN_THRUSTERS);
    }
    for (size_t i = 0; i < PLAN_THRUSTERS; i++) {
        const node_t thruster = element(&thrusters, i);
        numbers_at(reader, &thruster, "p_ST_m", 3, ANY, plan->thruster[i].r_m);
        unit_at(reader, &thruster, "n_T_S", 3, plan->thruster[i].n);
    }
    plan->beam = body(reader, &beam);
    plan->beam.length_m = number_at(reader, &beam, "length_m", POSITIVE);
    plan->beam.strip_kg_m2 = number_at(reader, &beam, "drag_strip_kg_m2", NOT_NEGATIVE);

    const node_t X_IS = member(reader, scenario, "X_IS"), X_IB = member(reader, scenario, "X_IB");
    numbers_at(reader, &X_IS, "p_IS_m", 3, ANY, plan->X_IS.p_m);
    unit_at(reader, &X_IS, "q_IS", 4, plan->X_IS.q);
    numbers_at(reader, &X_IB, "p_IB_m", 3, ANY, plan->X_IB.p_m);
    unit_at(reader, &X_IB, "q_IB", 4, plan->X_IB.q);
    const node_t port = member(reader, scenario, "port");
    numbers_at(reader, &port, "p_IP_m", 3, ANY, plan->p_IP_m);
    unit_at(reader, &port, "axis_I", 3, plan->axis_I);
    plan->standoff_m = number_at(reader, scenario, "standoff_m", POSITIVE);
}

/// The choice must be one that the scenario leaves open, else the plan answers another question.
static void read_choice(reader_t* reader, const node_t* root, const node_t* scenario, plan_file_t* plan) {
    const node_t choice = member(reader, root, "choice");
    const long long contact = integer_at(reader, &choice, "beam_contact"),
                    asked = integer_at(reader, scenario, "contact");
    if (contact != 1 && contact != 2) {
        fail(reader, "choice.beam_contact", "%lld is neither 1 nor 2", contact);
    }
    if (asked != 0 && asked != contact) {
        fail(reader, "choice.beam_contact", "%lld is not the %lld of scenario.contact", contact, asked);
    }
    plan->contact = contact == 1 ? 1 : 2;

    const double h = number_at(reader, &choice, "attach_height_m", ANY);
    const node_t heights = member(reader, scenario, "attach_heights_m");
    const size_t num_heights = length(reader, &heights, MAX_SEGMENTS);
    bool listed = num_heights == 0;
    for (size_t i = 0; i < num_heights; i++) {
        const node_t item = element(&heights, i);
        listed = fabs(number(reader, &item, ANY) - h) <= 1e-9 || listed;
    }
    if (!listed) {
        fail(reader, "choice.attach_height_m", "%.9g is not among scenario.attach_heights_m", h);
    }
    if (fabs(h) > plan->beam.length_m / 2 + 1e-9) {
        fail(reader, "choice.attach_height_m", "%.9g is off the beam, which ends at +-%.9g", h,
             plan->beam.length_m / 2);
    }
    plan->attach_height_m = h;

    plan->ring_angle_rad = number_at(reader, &choice, "ring_angle_rad", ANY);
    const node_t ring = member(reader, scenario, "ring_angle_rad");
    if (ring.json != NULL && !json_is_null(ring.json)) {
        const double asked_rad = number(reader, &ring, ANY);
        if (fabs(remainder(plan->ring_angle_rad - asked_rad, 2 * PI)) > 1e-9) {
            fail(reader, "choice.ring_angle_rad", "%.9g is not the %.9g of scenario.ring_angle_rad",
                 plan->ring_angle_rad, asked_rad);
        }
    }
}

/// Where an event falls: how many segments end at or before it. An event within a segment is refused.
static size_t segments_before(reader_t* reader, const node_t* events, size_t index, const char* kind,
                              const double* end_s, size_t num_segments) {
    const node_t event = element(events, index);
    if (strcmp(string_at(reader, &event, "kind"), kind) != 0) {
        fail(reader, event.path, "must be of kind \"%s\": a plan mates, then docks", kind);
    }
    const double t_s = number_at(reader, &event, "t_s", NOT_NEGATIVE);
    size_t n = 0;
    while (n < num_segments && end_s[n] <= t_s + PLAN_TIME_TOLERANCE_S) {
        n++;
    }
    if (fabs((n == 0 ? 0 : end_s[n - 1]) - t_s) > PLAN_TIME_TOLERANCE_S) {
        fail(reader, event.path, "t_s %.9g is not where a timeline segment ends", t_s);
    }
    return n;
}

static void read_timeline(reader_t* reader, const node_t* root, plan_file_t* plan) {
    const node_t legs = member(reader, root, "legs"), timeline = member(reader, root, "timeline");
    const node_t segments = member(reader, &timeline, "segments"), events = member(reader, root, "events");
    const size_t num_legs = length(reader, &legs, MAX_LEGS), n = length(reader, &segments, MAX_SEGMENTS);
    plan->segment = calloc(n + 1, sizeof *plan->segment);
    double* end_s = calloc(n + 1, sizeof *end_s);
    long long* leg = calloc(n + 1, sizeof *leg);
    if (plan->segment == NULL || end_s == NULL || leg == NULL) {
        fail(reader, segments.path, "not enough memory for %zu segments", n);
        free(end_s);
        free(leg);
        return;
    }
    plan->num_segments = n;
    for (size_t i = 0; i < n && !reader->failed; i++) {
        const node_t segment = element(&segments, i);
        const double t_s = number_at(reader, &segment, "t_s", NOT_NEGATIVE), expected_s = i == 0 ? 0 : end_s[i - 1];
        if (fabs(t_s - expected_s) > PLAN_TIME_TOLERANCE_S) {
            fail(reader, segment.path, "starts at t_s %.9g, must start at %.9g where the one before ends", t_s,
                 expected_s);
        }
        plan->segment[i].duration_s = number_at(reader, &segment, "duration_s", NOT_NEGATIVE);
        if (!(plan->segment[i].duration_s > 0)) {
            fail(reader, segment.path, "duration_s must be positive");
        }
        end_s[i] = t_s + plan->segment[i].duration_s;
        numbers_at(reader, &segment, "u_start_N", PLAN_THRUSTERS, ANY, plan->segment[i].u_start_N);
        numbers_at(reader, &segment, "u_end_N", PLAN_THRUSTERS, ANY, plan->segment[i].u_end_N);
        leg[i] = integer_at(reader, &segment, "leg");
        if (leg[i] < (i == 0 ? 0 : leg[i - 1]) || leg[i] >= (long long)num_legs) {
            fail(reader, segment.path, "leg %lld must count up from 0 and stay below the %zu legs", leg[i], num_legs);
        }
    }
    if (n > 0 && end_s[n - 1] > MAX_DURATION_S) {
        fail(reader, timeline.path, "lasts %.9g s, at most %g s are accepted", end_s[n - 1], MAX_DURATION_S);
    }
    if (length(reader, &events, 2) != 2) {
        fail(reader, events.path, "must be two: mate, then dock");
    }
    plan->num_transit_segments = segments_before(reader, &events, 0, "mate", end_s, n);
    if (segments_before(reader, &events, 1, "dock", end_s, n) != n) {
        fail(reader, "events[1]", "must be where the timeline ends, at t_s %.9g", n == 0 ? 0 : end_s[n - 1]);
    }
    for (size_t i = 0; i < n && !reader->failed; i++) {
        const node_t flown = element(&legs, (size_t)leg[i]);
        const char* phase = i < plan->num_transit_segments ? "transit" : "transfer";
        if (strcmp(string_at(reader, &flown, "phase"), phase) != 0) {
            fail(reader, flown.path, "must be of phase \"%s\": that is when timeline.segments[%zu] flies it", phase, i);
        }
    }
    free(end_s);
    free(leg);
}

static void read_plan(reader_t* reader, json_t* json, plan_file_t* plan) {
    const node_t root = {json, ""};
    const char* status = string_at(reader, &root, "status");
    if (!reader->failed && strcmp(status, "ok") != 0) {
        fail(reader, "status", "is \"%.20s\", only an \"ok\" plan can be flown (reason: %.300s)", status,
             string_at(reader, &root, "reason"));
    }
    plan->request_id = integer_at(reader, &root, "request_id");
    const node_t scenario = member(reader, &root, "scenario"), cost = member(reader, &root, "cost");
    plan->time_s = number_at(reader, &cost, "time_s", NOT_NEGATIVE);
    plan->impulse_Ns = number_at(reader, &cost, "impulse_Ns", NOT_NEGATIVE);
    read_task(reader, &scenario, plan);
    if (!reader->failed) {
        read_choice(reader, &root, &scenario, plan);
        read_timeline(reader, &root, plan);
    }
}

/// The whole stream; NULL with the reason in reader.
static char* slurp(reader_t* reader, FILE* stream, size_t* size) {
    char* text = NULL;
    for (size_t capacity = 1 << 16; capacity <= MAX_FILE_BYTES; capacity *= 2) {
        char* larger = realloc(text, capacity);
        if (larger == NULL) {
            break;
        }
        text = larger;
        *size += fread(text + *size, 1, capacity - *size, stream);
        if (ferror(stream)) {
            fail(reader, "", "cannot read it: %s", strerror(errno));
            free(text);
            return NULL;
        }
        if (*size < capacity) {
            return text;
        }
    }
    fail(reader, "", "is larger than %zu MiB, no plan is", MAX_FILE_BYTES >> 20);
    free(text);
    return NULL;
}

bool plan_file_read(const char* path, plan_file_t* plan, char* error, size_t error_size) {
    const bool standard_input = strcmp(path, "-") == 0;
    reader_t reader = {standard_input ? "standard input" : path, error, error_size, false};
    memset(plan, 0, sizeof *plan);
    FILE* stream = standard_input ? stdin : fopen(path, "rb");
    if (stream == NULL) {
        fail(&reader, "", "cannot open it: %s", strerror(errno));
        return false;
    }
    size_t size = 0;
    char* text = slurp(&reader, stream, &size);
    if (!standard_input) {
        fclose(stream);
    }
    if (text == NULL) {
        return false;
    }
    json_error_t where;
    json_t* json = json_loadb(text, size, JSON_REJECT_DUPLICATES, &where);
    free(text);
    if (json == NULL) {
        fail(&reader, "", "line %d, column %d: not a plan in JSON, as `ssv plan --format json` writes it: %s",
             where.line, where.column, where.text);
        return false;
    }
    read_plan(&reader, json, plan);
    json_decref(json);
    if (reader.failed) {
        plan_file_free(plan);
    }
    return !reader.failed;
}

void plan_file_free(plan_file_t* plan) {
    free(plan->segment);
    plan->segment = NULL;
}
