/// The file that `ssv schedule --cache` keeps prices in.
#ifndef SSV_PRICE_FILE_H
#define SSV_PRICE_FILE_H

#include <stdbool.h>
#include <stddef.h>

#include "scheduler/cache.h"

/// Reads what the file holds, if there is one. Prices of another planner, and what is not whole, are not used, with a
/// line on standard error.
/// @return false with a sentence in `error`: it is no file of prices, or cannot be read.
bool price_file_read(cache_t* cache, const char* path, char* error, size_t error_size);

/// Writes the file in one step, with what others have written there since. @return false after a line on standard
/// error.
bool price_file_write(cache_t* cache, const char* path);

#endif
