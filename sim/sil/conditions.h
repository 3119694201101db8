/// Reads a file of conditions: what disturbs a simulated flight, and what counts as a hit. README.md lists the keys.
#ifndef SIM_CONDITIONS_H
#define SIM_CONDITIONS_H

#include <stdbool.h>
#include <stddef.h>

#include "physics/world.h"

/// Puts what the file says into `world`; what it does not mention stays. `path` "-" is standard input.
/// @return false with a sentence in `error` that names file, line and key.
bool conditions_read(const char* path, sim_world_config_t* world, char* error, size_t error_size);

#endif
