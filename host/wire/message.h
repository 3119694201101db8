/// The message types as the one schema: what they hold is written as JSON and read back, and bytes that claim to be one
/// are checked, all by one walk over the types' own description (lcm-gen --c-typeinfo). No field is named here.
///
/// In JSON a message is an object with the fields' names as keys, nested as the messages are; lists are arrays, also
/// empty ones; enums are words (wire/names.h); a 64-bit hash or id is 16 hex digits. Types go by their names, e.g.
/// "plan_t".
#ifndef SSV_WIRE_MESSAGE_H
#define SSV_WIRE_MESSAGE_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "wire/tree.h"

/// One message and the key that it stands under.
typedef struct {
    const char* key;
    const char* type;
    void* message;
} wire_part_t;

/// @return the message as JSON; NULL if it holds a number that is not finite, which JSON has no word for, or out of
/// memory.
json_t* wire_to_json(const char* type, const void* message);

/// Writes JSON as a text that gives the same doubles when read, and a newline, and frees it; NULL counts as a failure.
bool wire_json_write(FILE* out, json_t* json);

/// Fills a message from a tree that must hold all its fields and nothing else, each of its kind. Lists and texts are
/// allocated; wire_clear frees them. @return false with the error set and the message empty.
bool wire_from_tree(const char* type, const tree_t* tree, void* message, tree_error_t* error);

/// Reads JSON whose top is an object that holds these parts, beside others that are not looked at. @return false with
/// a sentence in `error` and every part empty.
bool wire_json_read(const char* file, const char* text, size_t size, const wire_part_t* parts, int count, char* error,
                    size_t error_size);

/// Frees what wire_from_tree or a generated decoder allocated, and empties the message.
void wire_clear(const char* type, void* message);

/// Whether bytes are one message of this type, through and through: type hash, counts within their limits, strings that
/// end where they say, and nothing behind. The generated decoders allocate what the counts and the string lengths say
/// and look at none of it, so nothing else may read a message from outside before.
bool wire_is_message(const char* type, const void* data, size_t size);

/// Reads a message from bytes that may come from anywhere. Lists and texts are allocated; wire_clear frees them.
/// @return false if they are none of this type, and the message empty.
bool wire_decode(const char* type, const void* data, size_t size, void* message);

/// The type among these, a list with NULL behind, whose hash the bytes begin with; NULL if none has it.
const char* wire_type_of(const char* const* types, const void* data, size_t size);

/// Bytes of memory that a message takes, without what it points to.
size_t wire_struct_size(const char* type);

/// The names of a type's fields. @return how many there are, at most `most`.
int wire_field_names(const char* type, const char** names, int most);

#endif
