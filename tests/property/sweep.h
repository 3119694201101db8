/// The same check for very many seeded cases, on every core.
#ifndef TESTS_SWEEP_H
#define TESTS_SWEEP_H

#include <stddef.h>

/// `quick` cases, or with SSV_LONG=1 in the environment `full`.
int sweep_count(int quick, int full);

/// Calls run(k, result) for every k in [0, count), in one process per core, and gathers the results, `size` bytes each.
/// run must depend on k alone, so that a case found here can be run by itself. A terminal sees how far it is.
/// @return results[count], valid until the next sweep; NULL if a process died.
void* sweep(const char* name, int count, size_t size, void (*run)(int k, void* result));

/// Sorts value[0..count); @return its quantile q in [0, 1].
double sweep_quantile(double* value, int count, double q);

#endif
