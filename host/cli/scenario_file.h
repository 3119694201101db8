/// Reads a scenario file (YAML) and the model file that it names into the wire type.
///
/// The files are held to a schema: an unknown, missing or repeated key, or a value of the wrong shape, is refused. Whether
/// the numbers make sense is not judged here but by the planner, except for what never reaches it (the hub's attitude).
#ifndef SSV_SCENARIO_FILE_H
#define SSV_SCENARIO_FILE_H

#include <stdbool.h>
#include <stddef.h>

#include "lcm_ssv_scenario_t.h"

/// Largest file that is read [bytes].
#define SCENARIO_FILE_SIZE_MAX (1 << 20)

/// Reads the scenario at `path`. A model given by name is looked for in `models_dir`; one given by path, relative to the
/// scenario file. Writes everything but request_id and epoch_us.
/// @return true; or false with a sentence in `error` that names file, line or key, and *scenario in an undefined state.
bool scenario_file_read(const char* path, const char* models_dir, lcm_ssv_scenario_t* scenario, char* error,
                        size_t error_size);

/// A number as YAML 1.2 writes it (.nan and .inf included), all of the text or nothing.
/// @return whether it is one; if not, *value is untouched.
bool number_parse(const char* text, double* value);

#endif
