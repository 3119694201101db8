// JSON into a tree, by jansson.
#include <jansson.h>
#include <string.h>

#include "tree.h"

static bool fill(tree_memory_t* memory, tree_error_t* error, tree_t* value, json_t* json);

static char* copy(tree_memory_t* memory, const char* text, size_t size) {
    char* const kept = tree_memory_take(memory, size + 1);
    if (kept != NULL) {
        memcpy(kept, text, size);
    }
    return kept;
}

static bool fill_map(tree_memory_t* memory, tree_error_t* error, tree_t* map, json_t* json) {
    const char* name;
    json_t* member;
    json_object_foreach(json, name, member) {
        const char* const key = copy(memory, name, strlen(name));
        tree_t* const value = key == NULL ? NULL : tree_add(memory, error, map, key, 0, 0);
        if (value == NULL || !fill(memory, error, value, member)) {
            return false;
        }
    }
    return true;
}

static bool fill_list(tree_memory_t* memory, tree_error_t* error, tree_t* list, json_t* json) {
    for (size_t i = 0; i < json_array_size(json); i++) {
        tree_t* const value = tree_add(memory, error, list, NULL, 0, 0);
        if (value == NULL || !fill(memory, error, value, json_array_get(json, i))) {
            return false;
        }
    }
    return true;
}

static bool fill(tree_memory_t* memory, tree_error_t* error, tree_t* value, json_t* json) {
    switch (json_typeof(json)) {
        case JSON_OBJECT: value->kind = TREE_MAP; return fill_map(memory, error, value, json);
        case JSON_ARRAY: value->kind = TREE_LIST; return fill_list(memory, error, value, json);
        case JSON_STRING:
            value->kind = TREE_TEXT;
            value->text = copy(memory, json_string_value(json), json_string_length(json));
            return value->text != NULL;
        case JSON_INTEGER:
            value->kind = TREE_INTEGER;
            value->integer = json_integer_value(json);
            value->real = (double)value->integer;
            return true;
        case JSON_REAL:
            value->kind = TREE_REAL;
            value->real = json_real_value(json);
            return true;
        case JSON_TRUE:
        case JSON_FALSE:
            value->kind = TREE_BOOLEAN;
            value->boolean = json_is_true(json);
            return true;
        default: value->kind = TREE_NULL; return true;
    }
}

const tree_t* tree_from_json(tree_memory_t* memory, tree_error_t* error, const char* file, const char* text,
                             size_t size) {
    json_error_t where;
    const tree_t whole = {.file = file};
    json_t* const json =
        size > TREE_TEXT_MAX ? NULL : json_loadb(text, size, JSON_REJECT_DUPLICATES | JSON_DECODE_ANY, &where);
    if (json == NULL) {
        if (size > TREE_TEXT_MAX) {
            tree_fail(error, &whole, "larger than 64 MiB, no text of ours is");
        } else {
            const tree_t there = {.file = file, .line = where.line, .column = where.column};
            tree_fail(error, &there, "not JSON from here on: %s", where.text);
        }
        return NULL;
    }
    tree_t* const root = tree_add(memory, error, NULL, NULL, 0, 0);
    if (root != NULL) {
        root->file = file;
    }
    const bool whole_read = root != NULL && fill(memory, error, root, json);
    json_decref(json);
    if (!whole_read) {
        tree_fail(error, &whole, "out of memory");
    }
    return whole_read ? root : NULL;
}
