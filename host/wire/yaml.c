// YAML into a tree, by the events of libfyaml.
#include <libfyaml.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tree.h"

typedef struct {
    tree_memory_t* memory;
    tree_error_t* error;
    struct fy_parser* parser;
    struct fy_diag* diag;
    const char* file;
} reader_t;

static bool fill(reader_t* reader, tree_t* value, struct fy_event* event);

static void set_place(tree_t* value, struct fy_event* event) {
    const struct fy_mark* const mark = fy_event_start_mark(event);
    if (mark != NULL) {
        value->line = mark->line + 1;
        value->column = mark->column + 1;
    }
}

/// The next event; NULL with the error set at the end of what is YAML.
static struct fy_event* next(reader_t* reader) {
    struct fy_event* const event = fy_parser_parse(reader->parser);
    if (event == NULL) {
        void* first = NULL;
        const struct fy_diag_error* const found = fy_diag_errors_iterate(reader->diag, &first);
        const tree_t there = {
            .file = reader->file, .line = found == NULL ? 0 : found->line, .column = found == NULL ? 0 : found->column};
        tree_fail(reader->error, &there, "not YAML from here on%s%s", found == NULL ? "" : ": ",
                  found == NULL ? "" : found->msg);
    }
    return event;
}

/// The text of a scalar; NULL with the error set if a '\0' would cut it.
static const char* text_of(reader_t* reader, const tree_t* value, struct fy_token* token) {
    size_t size = 0;
    const char* const text = fy_token_get_text(token, &size);
    char* const kept = text == NULL ? NULL : tree_memory_take(reader->memory, size + 1);
    if (kept == NULL) {
        tree_fail(reader->error, value, "out of memory");
        return NULL;
    }
    memcpy(kept, text, size);
    if (strlen(kept) != size) {
        tree_fail(reader->error, value, "a text with a zero character in it");
        return NULL;
    }
    return kept;
}

static bool is_one_of(const char* text, const char* a, const char* b, const char* c) {
    return strcmp(text, a) == 0 || strcmp(text, b) == 0 || strcmp(text, c) == 0;
}

/// A number by YAML's core schema, without its octal and hexadecimal forms. @return whether it is one.
static bool number(const char* text, tree_t* value) {
    const char* const digits = text + (*text == '-' || *text == '+');
    if (is_one_of(digits, ".inf", ".Inf", ".INF")) {
        value->kind = TREE_REAL;
        value->real = *text == '-' ? -(double)INFINITY : (double)INFINITY;
        return true;
    }
    if (is_one_of(text, ".nan", ".NaN", ".NAN")) {
        value->kind = TREE_REAL;
        value->real = (double)NAN;
        return true;
    }
    if (text[strspn(text, "0123456789.eE+-")] != '\0' || strpbrk(text, "0123456789") == NULL) {
        return false;
    }
    char* end = NULL;
    const double real = strtod(text, &end);
    if (*end != '\0') {
        return false;
    }
    value->real = real;
    const size_t length = strlen(digits);
    const bool whole = digits[strspn(digits, "0123456789")] == '\0' && length < 20;
    const double limit = 9223372036854775808.0;
    value->kind = whole && value->real >= -limit && value->real < limit ? TREE_INTEGER : TREE_REAL;
    value->integer = value->kind == TREE_INTEGER ? strtoll(text, NULL, 10) : 0;
    return true;
}

bool tree_number(const char* text, double* value) {
    tree_t parsed = {.kind = TREE_NULL};
    const bool is_number = number(text, &parsed);
    *value = is_number ? parsed.real : *value;
    return is_number;
}

static bool fill_scalar(reader_t* reader, tree_t* value, struct fy_event* event) {
    struct fy_token* const token = event->scalar.value;
    if (event->scalar.tag != NULL) {
        return tree_fail(reader->error, value, "a tag (!...), which no file of ours needs; write the value alone");
    }
    value->kind = TREE_NULL;
    value->text = token == NULL ? "" : text_of(reader, value, token);
    if (value->text == NULL) {
        return false;
    }
    const bool quoted = token != NULL && fy_token_scalar_style(token) != FYSS_PLAIN;
    if (!quoted &&
        (is_one_of(value->text, "true", "True", "TRUE") || is_one_of(value->text, "false", "False", "FALSE"))) {
        value->kind = TREE_BOOLEAN;
        value->boolean = *value->text == 't' || *value->text == 'T';
    } else if (quoted || (!number(value->text, value) && !is_one_of(value->text, "null", "Null", "NULL") &&
                          !is_one_of(value->text, "", "~", "~"))) {
        value->kind = TREE_TEXT;
    }
    return true;
}

/// Reads the events up to the one that ends a list.
static bool fill_list(reader_t* reader, tree_t* list) {
    list->kind = TREE_LIST;
    bool more = true, sound = true;
    while (more && sound) {
        struct fy_event* const event = next(reader);
        more = event != NULL && event->type != FYET_SEQUENCE_END;
        sound = event != NULL;
        if (more) {
            tree_t* const value = tree_add(reader->memory, reader->error, list, NULL, 0, 0);
            sound = value != NULL && fill(reader, value, event);
        }
        fy_parser_event_free(reader->parser, event);
    }
    return sound;
}

/// Reads a key, which is a scalar. @return a tree for it that stands nowhere; NULL with the error set.
static const tree_t* read_key(reader_t* reader, const tree_t* map, struct fy_event* event) {
    tree_t* const key = tree_memory_take(reader->memory, sizeof *key);
    if (key == NULL) {
        tree_fail(reader->error, map, "out of memory");
        return NULL;
    }
    key->file = reader->file;
    set_place(key, event);
    if (event->type != FYET_SCALAR) {
        tree_fail(reader->error, key, "a key that is no word");
        return NULL;
    }
    return fill_scalar(reader, key, event) ? key : NULL;
}

/// Likewise the end of a map.
static bool fill_map(reader_t* reader, tree_t* map) {
    map->kind = TREE_MAP;
    bool more = true, sound = true;
    while (more && sound) {
        struct fy_event* event = next(reader);
        more = event != NULL && event->type != FYET_MAPPING_END;
        sound = event != NULL;
        if (more) {
            const tree_t* const key = read_key(reader, map, event);
            const tree_entry_t entry = {key == NULL ? NULL : key->text, key == NULL ? 0 : key->line,
                                        key == NULL ? 0 : key->column, NULL};
            fy_parser_event_free(reader->parser, event);
            event = NULL;
            sound = key != NULL;
            if (sound && tree_get(map, key->text) != NULL) {
                sound = tree_fail_key(reader->error, map, &entry, key->text, "this key stands there twice");
            }
            tree_t* const value =
                sound ? tree_add(reader->memory, reader->error, map, key->text, key->line, key->column) : NULL;
            if (value != NULL) { // an empty value stands nowhere else
                value->line = key->line;
                value->column = key->column;
            }
            event = value == NULL ? NULL : next(reader);
            sound = event != NULL && fill(reader, value, event);
        }
        fy_parser_event_free(reader->parser, event);
    }
    return sound;
}

/// Fills in what an event begins.
static bool fill(reader_t* reader, tree_t* value, struct fy_event* event) {
    set_place(value, event);
    switch (event->type) {
        case FYET_SCALAR: return fill_scalar(reader, value, event);
        case FYET_SEQUENCE_START:
        case FYET_MAPPING_START:
            if ((event->type == FYET_MAPPING_START ? event->mapping_start.tag : event->sequence_start.tag) != NULL) {
                return tree_fail(reader->error, value,
                                 "a tag (!...), which no file of ours needs; write the value alone");
            }
            return event->type == FYET_MAPPING_START ? fill_map(reader, value) : fill_list(reader, value);
        case FYET_ALIAS: return tree_fail(reader->error, value, "an alias (*...); write out what it stands for");
        default: return tree_fail(reader->error, value, "not YAML from here on");
    }
}

/// Steps over an event that must be of this type.
static bool expect(reader_t* reader, enum fy_event_type type, const char* otherwise) {
    struct fy_event* const event = next(reader);
    const bool met = event != NULL && event->type == type;
    if (event != NULL && !met) {
        tree_t there = {.file = reader->file};
        set_place(&there, event);
        tree_fail(reader->error, &there, "%s", otherwise);
    }
    fy_parser_event_free(reader->parser, event);
    return met;
}

static const tree_t* read_document(reader_t* reader) {
    if (!expect(reader, FYET_STREAM_START, "not YAML") ||
        !expect(reader, FYET_DOCUMENT_START, "empty: no key is in it")) {
        return NULL;
    }
    tree_t* const root = tree_add(reader->memory, reader->error, NULL, NULL, 0, 0);
    struct fy_event* const event = root == NULL ? NULL : next(reader);
    if (root != NULL) {
        root->file = reader->file;
    }
    const bool filled = event != NULL && fill(reader, root, event);
    fy_parser_event_free(reader->parser, event);
    return filled && expect(reader, FYET_DOCUMENT_END, "not YAML from here on") &&
                   expect(reader, FYET_STREAM_END, "a second document begins here; one is read at a time")
               ? root
               : NULL;
}

/// Keeps from the parser what no file of ours has and what it has been seen to loop on without end: bytes that are no
/// UTF-8, and directives.
static bool is_for_parser(tree_error_t* error, const char* file, const char* text, size_t size) {
    tree_t there = {.file = file};
    if (size > TREE_YAML_MAX) {
        return tree_fail(error, &there, "larger than 4 MiB, no file of ours is");
    }
    there.column = 1;
    there.line = tree_find_no_text(text, size);
    if (there.line > 0) {
        return tree_fail(error, &there, "a control character, or bytes that are no UTF-8");
    }
    there.line = 1;
    for (size_t i = 0; i < size; i++) {
        if (text[i] == '%' && (i == 0 || strchr("\n\r", text[i - 1]) != NULL)) {
            return tree_fail(error, &there, "a directive (%%...), which no file of ours needs");
        }
        there.line += text[i] == '\n';
    }
    return true;
}

const tree_t* tree_from_yaml(tree_memory_t* memory, tree_error_t* error, const char* file, const char* text,
                             size_t size) {
    const tree_t whole = {.file = file};
    if (!is_for_parser(error, file, text, size)) {
        return NULL;
    }
    struct fy_diag_cfg quiet;
    fy_diag_cfg_default(&quiet);
    quiet.fp = NULL;
    quiet.level = FYET_ERROR;
    quiet.colorize = false;
    reader_t reader = {.memory = memory, .error = error, .file = file, .diag = fy_diag_create(&quiet)};
    const tree_t* root = NULL;
    if (reader.diag != NULL) {
        fy_diag_set_collect_errors(reader.diag, true);
        const struct fy_parse_cfg config = {.flags = FYPCF_QUIET | FYPCF_COLLECT_DIAG | FYPCF_JSON_NONE,
                                            .diag = reader.diag};
        reader.parser = fy_parser_create(&config);
    }
    if (reader.parser != NULL && fy_parser_set_string(reader.parser, text, size) == 0) {
        root = read_document(&reader);
    }
    if (reader.parser != NULL) {
        fy_parser_destroy(reader.parser);
    }
    if (reader.diag != NULL) {
        fy_diag_destroy(reader.diag);
    }
    if (root == NULL) {
        tree_fail(error, &whole, "out of memory");
    }
    return root;
}
