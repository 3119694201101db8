/// The words of the message types' enums, and how many elements their lists may have.
#ifndef SSV_WIRE_NAMES_H
#define SSV_WIRE_NAMES_H

#include <stdbool.h>
#include <stdint.h>

/// The words for the values 0, 1, ... of a field of type int8_t.
typedef struct {
    const char* type; ///< as in its .lcm file, e.g. "leg_t"
    const char* field;
    int count;
    const char* words[8];
} names_t;

extern const names_t names_status, names_phase, names_kind, names_ramp, names_event, names_method, names_effort,
    names_scalar, names_state, names_outcome, names_goal, names_obstacle, names_tank, names_body;

/// The words of a field; NULL if it is no enum.
const names_t* names_of_field(const char* type, const char* field);

/// A value from the wire may name nothing: then "unknown".
const char* name_of(const names_t* names, int8_t value);

/// @return the value of a word, -1 if it is none.
int8_t name_find(const names_t* names, const char* word);

/// Most elements of a list whose length a message states; 0 if the field is no such list.
int32_t names_most_elements(const char* type, const char* field);

/// The field that says how many elements of a list of fixed length count; NULL if all do.
const char* names_counter_of(const char* type, const char* field);

/// Whether a field of 64 bits is a choice, a bit for each of what is chosen from.
bool names_is_choice(const char* type, const char* field);

#endif
