#define _POSIX_C_SOURCE 200809L
#include "tables.h"

#include <errno.h>
#include <inttypes.h>
#include <jansson.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "wire/message.h"
#include "wire/tree.h"

/// The kinds of messages, and the tables that they go to.
static const struct {
    const char *type, *table;
} kinds[] = {
    {"task_t", "tasks"},          {"scenario_batch_t", "batches"},      {"plan_t", "plans"},
    {"quote_batch_t", "answers"}, {"planner_status_t", "status"},       {"execution_t", "execution"},
    {"control_t", "control"},     {"vehicle_state_t", "vehicle_state"}, {"schedule_t", "schedules"},
};
enum { NUM_KINDS = sizeof kinds / sizeof kinds[0] };

/// What a message lists, by the field's name, and the tables that these go to.
static const struct {
    const char *field, *type, *table;
} lists[] = {
    {"scenarios", "scenario_t", "scenarios"},
    {"obstacles", "obstacle_t", "obstacles"},
    {"legs", "leg_t", "legs"},
    {"arcs", "arc_t", "arcs"},
    {"segments", "segment_t", "segments"},
    {"events", "event_t", "events"},
    {"quotes", "quote_t", "quotes"},
    {"candidates", "candidate_t", "candidates"},
    {"front", "candidate_t", "front"},
    {"parts", "schedule_part_t", "parts"},
};
enum { NUM_LISTS = sizeof lists / sizeof lists[0], NUM_TABLES = 1 + NUM_KINDS + NUM_LISTS };

typedef struct {
    const char* name;
    json_t* blank; ///< an empty message of the type: what its columns are
    FILE* file;
    long rows;
} table_t;

struct tables {
    char folder[PATH_MAX - 64];
    table_t table[NUM_TABLES]; ///< messages, then those of the kinds, then those of the lists
    bool failed;
};

/// Where a row comes from: its message, the quote of a batch that has it, and its number there; -1 where it has none.
typedef struct {
    const tables_message_t* message;
    int quote, index;
} origin_t;

// ---- Cells ----------------------------------------------------------------------------------------------------------

/// A text that steers no terminal, in quotes.
static void write_text(FILE* out, const char* text) {
    char* const harmless = strdup(text);
    if (harmless != NULL) tree_make_harmless(harmless);
    fputc('"', out);
    for (const char* c = harmless == NULL ? "" : harmless; *c != '\0'; c++) {
        if (*c == '"') fputc('"', out);
        fputc(*c, out);
    }
    fputc('"', out);
    free(harmless);
}

static void write_scalar(FILE* out, const json_t* value) {
    switch (json_typeof(value)) {
        case JSON_STRING: write_text(out, json_string_value(value)); break;
        case JSON_REAL: fprintf(out, "%.17g", json_real_value(value)); break;
        case JSON_INTEGER: fprintf(out, "%" JSON_INTEGER_FORMAT, json_integer_value(value)); break;
        case JSON_TRUE: fputs("1", out); break;
        default: fputs("0", out); break;
    }
}

/// The name of an element of a list of fixed length: coordinates of vectors and quaternions have theirs.
static void element_name(const json_t* list, size_t i, char* name, size_t size) {
    static const char axes[] = "wxyz";
    const size_t count = json_array_size(list);
    const bool is_vector = (count == 3 || count == 4) && json_is_number(json_array_get(list, 0));
    if (is_vector)
        snprintf(name, size, "%c", axes[i + 4 - count]);
    else
        snprintf(name, size, "%zu", i + 1);
}

static bool is_listed(const char* field, const json_t* blank) {
    for (int i = 0; i < NUM_LISTS; i++) {
        if (strcmp(lists[i].field, field) == 0 && json_is_array(blank)) return true;
    }
    return false;
}

/// The columns of what an empty message has there.
static void write_header(FILE* out, const char* name, const json_t* blank) {
    const char* key;
    json_t* value;
    size_t i;
    char path[512];
    if (json_is_object(blank)) {
        json_object_foreach((json_t*)(uintptr_t)blank, key, value) {
            snprintf(path, sizeof path, "%s%s%s", name, name[0] == '\0' ? "" : ".", key);
            if (!is_listed(key, value)) write_header(out, path, value);
        }
    } else if (json_array_size(blank) > 0) {
        json_array_foreach(blank, i, value) {
            char element[24];
            element_name(blank, i, element, sizeof element);
            snprintf(path, sizeof path, "%s.%s", name, element);
            write_header(out, path, value);
        }
    } else {
        fprintf(out, ",%s", name);
    }
}

/// The cells of a value, in the columns of what an empty message has there. A list whose length the message states
/// stands in one cell.
static void write_cells(FILE* out, const json_t* blank, const json_t* value) {
    const char* key;
    json_t* part;
    size_t i;
    if (json_is_object(blank)) {
        json_object_foreach((json_t*)(uintptr_t)blank, key, part) {
            if (!is_listed(key, part)) write_cells(out, part, json_object_get(value, key));
        }
    } else if (json_array_size(blank) > 0) {
        json_array_foreach(blank, i, part) { write_cells(out, part, json_array_get(value, i)); }
    } else if (json_is_array(blank)) {
        fputs(",\"", out);
        json_array_foreach(value, i, part) {
            if (i > 0) fputc(' ', out);
            write_scalar(out, part);
        }
        fputc('"', out);
    } else {
        fputc(',', out);
        write_scalar(out, value);
    }
}

// ---- Rows -----------------------------------------------------------------------------------------------------------

static void add_row(table_t* table, const origin_t* from, const json_t* value) {
    fprintf(table->file, "%" PRId64 ",%" PRId64 ",", from->message->number, from->message->received_us);
    write_text(table->file, from->message->channel);
    if (from->index >= 0) fprintf(table->file, ",%d,%d", from->quote, from->index);
    write_cells(table->file, table->blank, value);
    fputc('\n', table->file);
    table->rows++;
}

/// The rows of all lists that a value has in it, at any depth.
static void add_lists(tables_t* tables, const origin_t* from, const json_t* value) {
    const char* key;
    json_t *part, *element;
    size_t i;
    json_object_foreach((json_t*)(uintptr_t)value, key, part) {
        if (json_is_object(part)) add_lists(tables, from, part);
        for (int k = 0; k < NUM_LISTS && json_is_array(part); k++) {
            if (strcmp(lists[k].field, key) != 0) continue;
            json_array_foreach(part, i, element) {
                const origin_t origin = {from->message, from->index >= 0 ? from->index : 0, (int)i};
                add_row(&tables->table[1 + NUM_KINDS + k], &origin, element);
                add_lists(tables, &origin, element);
            }
        }
    }
}

/// A message as JSON; NULL if it is none, or holds a number that is none.
static json_t* read_message(const char* type, const tables_message_t* message) {
    void* const memory = malloc(wire_struct_size(type));
    json_t* json = NULL;
    if (memory != NULL && wire_decode(type, message->data, message->size, memory)) {
        json = wire_to_json(type, memory);
        wire_clear(type, memory);
    }
    free(memory);
    return json;
}

const char* tables_add(tables_t* tables, const tables_message_t* message) {
    const char* types[NUM_KINDS + 1] = {NULL};
    for (int i = 0; i < NUM_KINDS; i++) types[i] = kinds[i].type;
    const char* type = wire_type_of(types, message->data, message->size);
    json_t* const json = type == NULL ? NULL : read_message(type, message);
    table_t* const all = &tables->table[0];
    fprintf(all->file, "%" PRId64 ",%" PRId64 ",", message->number, message->received_us);
    write_text(all->file, message->channel);
    fprintf(all->file, ",%s,%zu,%s\n", type == NULL ? "" : type, message->size,
            json != NULL   ? "read"
            : type == NULL ? "not ours"
                           : "broken");
    all->rows++;
    for (int i = 0; i < NUM_KINDS && json != NULL; i++) {
        if (strcmp(kinds[i].type, type) != 0) continue;
        const origin_t origin = {message, 0, -1};
        add_row(&tables->table[1 + i], &origin, json);
        add_lists(tables, &origin, json);
    }
    const bool is_read = json != NULL;
    json_decref(json);
    return is_read ? type : NULL;
}

// ---- The folder -----------------------------------------------------------------------------------------------------

static bool fail(const char* path, char* error, size_t size) {
    snprintf(error, size, "cannot write %.512s: %s", path, strerror(errno));
    tree_make_harmless(error);
    return false;
}

static json_t* blank_of(const char* type) {
    void* const message = calloc(1, wire_struct_size(type));
    json_t* const blank = message == NULL ? NULL : wire_to_json(type, message);
    free(message);
    return blank;
}

static bool begin_table(tables_t* tables, int number, const char* name, const char* type, char* error, size_t size) {
    table_t* const table = &tables->table[number];
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s/%s.csv", tables->folder, name);
    table->name = name;
    table->blank = type == NULL ? NULL : blank_of(type);
    table->file = fopen(path, "w");
    if (table->file == NULL) return fail(path, error, size);
    fputs("message,received_us,channel", table->file);
    if (type == NULL) fputs(",type,bytes,outcome", table->file);
    if (number > NUM_KINDS) fputs(",quote,index", table->file);
    if (type != NULL) write_header(table->file, "", table->blank);
    fputc('\n', table->file);
    return true;
}

static void free_tables(tables_t* tables) {
    for (int i = 0; i < NUM_TABLES; i++) {
        if (tables->table[i].file != NULL) (void)fclose(tables->table[i].file);
        json_decref(tables->table[i].blank);
    }
    free(tables);
}

tables_t* tables_open(const char* folder, char* error, size_t error_size) {
    tables_t* const tables = calloc(1, sizeof *tables);
    if (tables == NULL || strlen(folder) >= sizeof tables->folder) {
        snprintf(error, error_size, tables == NULL ? "out of memory" : "the folder's name is too long");
        free(tables);
        return NULL;
    }
    snprintf(tables->folder, sizeof tables->folder, "%s", folder);
    bool sound = mkdir(folder, 0777) == 0 || errno == EEXIST || fail(folder, error, error_size);
    sound = sound && begin_table(tables, 0, "messages", NULL, error, error_size);
    for (int i = 0; i < NUM_KINDS && sound; i++)
        sound = begin_table(tables, 1 + i, kinds[i].table, kinds[i].type, error, error_size);
    for (int i = 0; i < NUM_LISTS && sound; i++)
        sound = begin_table(tables, 1 + NUM_KINDS + i, lists[i].table, lists[i].type, error, error_size);
    if (sound) return tables;
    free_tables(tables);
    return NULL;
}

const char* tables_name(const tables_t* tables, int table, long* rows) {
    if (table >= NUM_TABLES) return NULL;
    *rows = tables->table[table].rows;
    return tables->table[table].name;
}

bool tables_close(tables_t* tables, char* error, size_t error_size) {
    bool sound = true;
    for (int i = 0; i < NUM_TABLES; i++) {
        FILE* const file = tables->table[i].file;
        char path[PATH_MAX];
        snprintf(path, sizeof path, "%s/%s.csv", tables->folder, tables->table[i].name);
        const bool written = ferror(file) == 0;
        tables->table[i].file = NULL;
        if ((fclose(file) != 0 || !written) && sound) sound = fail(path, error, error_size);
    }
    free_tables(tables);
    return sound;
}
