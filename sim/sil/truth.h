/// Tells the bus where the simulated vehicle and its beam really are, for who watches: lcm-spy, lcm-logger.
#ifndef SIM_TRUTH_H
#define SIM_TRUTH_H

#include <stdbool.h>
#include <stddef.h>

#include "sil.h"

typedef struct truth truth_t;

/// @param url LCM provider; empty for LCM's default.
/// @return NULL with a sentence in `error`.
truth_t* truth_open(const char* url, char* error, size_t error_size);

/// Tells where they are now, on SSV_VEHICLE_TRUTH, if 0.1 s of simulated time have gone by since it was last told.
void truth_tell(truth_t* truth, const sil_t* sil);

void truth_close(truth_t* truth);

#endif
