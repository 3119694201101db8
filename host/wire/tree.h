/// What a JSON or YAML text holds, as a tree that remembers where everything stands, so that whoever finds a fault in
/// it can name file, line and key. Scalars are what YAML's core schema says of them, which is what JSON says of them,
/// too.
#ifndef SSV_WIRE_TREE_H
#define SSV_WIRE_TREE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Largest text that is read, and largest that may be YAML [bytes]: what people write is short, a flown assembly is
/// not.
#define TREE_TEXT_MAX (1 << 26)
#define TREE_YAML_MAX (1 << 22)

typedef enum { TREE_NULL, TREE_BOOLEAN, TREE_INTEGER, TREE_REAL, TREE_TEXT, TREE_LIST, TREE_MAP } tree_kind_t;

typedef struct tree tree_t;

/// What a list or a map holds; key is NULL in a list. Lines and columns count from 1; 0 stands for unknown.
typedef struct {
    const char* key;
    int line, column; ///< of the key
    const tree_t* value;
} tree_entry_t;

struct tree {
    tree_kind_t kind;
    const char* file; ///< or "standard input"
    int line, column;
    const tree_t* parent; ///< where it was written; NULL for the root
    const char* key;      ///< likewise its key there, NULL in a list
    int index;            ///< likewise its number in a list
    bool boolean;
    int64_t integer;
    double real;      ///< of an integer, too; it may be infinite or no number
    const char* text; ///< of a scalar, as it was written, without quotes
    int count;
    tree_entry_t* entries;
};

/// Owns every tree that was made with it.
typedef struct {
    void* newest;
} tree_memory_t;

/// The first fault found, as a sentence.
typedef struct {
    char* text; ///< empty as long as there is none
    size_t size;
} tree_error_t;

void tree_memory_free(tree_memory_t* memory);

/// @return zeroed memory that is freed with the rest; NULL if there is none.
void* tree_memory_take(tree_memory_t* memory, size_t size);

/// A new value that stands in `entries` of `within`, a list or a map; NULL as root. NULL with the error set if memory
/// is out or the list or map is too large.
tree_t* tree_add(tree_memory_t* memory, tree_error_t* error, tree_t* within, const char* key, int line, int column);

/// Puts a value that stands elsewhere into a map, too, by the name `key`. @return false if out of memory.
bool tree_graft(tree_memory_t* memory, tree_t* map, const char* key, const tree_t* value);

/// What a map holds by this key; NULL if nothing, or if it is no map.
const tree_t* tree_get(const tree_t* map, const char* key);

/// Sets the error to "FILE:LINE:COLUMN: PATH: sentence"; PATH is how the file writes the place, e.g. "vehicle.q_IS[2]".
/// Only the first one counts. @return false.
__attribute__((format(printf, 3, 4))) bool tree_fail(tree_error_t* error, const tree_t* at, const char* format, ...);

/// Likewise about a key that a map holds or lacks; its place is that of the map if `entry` is NULL.
__attribute__((format(printf, 5, 6))) bool tree_fail_key(tree_error_t* error, const tree_t* map,
                                                         const tree_entry_t* entry, const char* key, const char* format,
                                                         ...);

/// "FILE:LINE:COLUMN: PATH" of a value.
void tree_place(const tree_t* at, char* place, size_t size);

/// Replaces what would steer a terminal, control characters and bytes that are no UTF-8, by '?'.
void tree_make_harmless(char* text);

/// The first line with a byte that is no UTF-8, or with a control character; 0 if there is none.
int tree_find_no_text(const char* text, size_t size);

/// A number as a YAML file may have it, all of the text or nothing. @return whether it is one.
bool tree_number(const char* text, double* value);

/// The known word that is nearest to one with a slip in it; NULL if none is near.
const char* tree_nearest(const char* word, const char* const* known, int count);

/// Reads a whole file of at most TREE_TEXT_MAX bytes; "-" is standard input. What is no regular file is refused, since
/// reading it might never end. @return the text, which the caller frees; NULL with the error set.
char* tree_file_read(const char* path, size_t* size, tree_error_t* error);

/// What the text of one JSON value holds. @return NULL with the error set if it is none.
const tree_t* tree_from_json(tree_memory_t* memory, tree_error_t* error, const char* file, const char* text,
                             size_t size);

/// What a YAML document holds, which may be written as JSON. Repeated keys, aliases, tags and
/// directives are refused.
/// @return NULL with the error set if it is none.
const tree_t* tree_from_yaml(tree_memory_t* memory, tree_error_t* error, const char* file, const char* text,
                             size_t size);

#endif
