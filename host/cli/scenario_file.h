/// Reads a scenario file (YAML) and the model file that it names into the wire type.
///
/// The files are held to a schema: an unknown, missing or repeated key, or a value of the wrong shape, is refused.
/// Whether the numbers make sense is not judged here but by the planner, except for what never reaches it (the hub's
/// attitude).
#ifndef SSV_SCENARIO_FILE_H
#define SSV_SCENARIO_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "lcm_ssv_scenario_t.h"

/// Largest file that is read [bytes].
#define SCENARIO_FILE_SIZE_MAX (1 << 20)

/// The method of a scenario that names none.
#define SCENARIO_METHOD_DEFAULT "optimal"
/// Likewise its effort.
#define SCENARIO_EFFORT_DEFAULT "quick"

/// The words for options_t.method and options_t.effort, in the order of their values.
extern const char* const scenario_methods[2];
extern const char* const scenario_efforts[2];

/// Reads the scenario at `path`. A model given by name is looked for in `models_dir`; one given by path, relative to
/// the scenario file. Writes everything but request_id and epoch_us.
/// @return true; or false with a sentence in `error` that names file, line or key, and *scenario in an undefined state.
bool scenario_file_read(const char* path, const char* models_dir, lcm_ssv_scenario_t* scenario, char* error,
                        size_t error_size);

/// @return which of the words it is, -1 if none.
int8_t word_find(const char* text, const char* const* words, int count);

/// A number as YAML 1.2 writes it (.nan and .inf included), all of the text or nothing.
/// @return whether it is one; if not, *value is untouched.
bool number_parse(const char* text, double* value);

#endif
