/// The secret that both ends of the link sign their frames with, as a file.
#ifndef BENCH_KEY_H
#define BENCH_KEY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ssv/link.h"

/// Makes the signing of an end whose clock has stood at `now_us` when this is called. The file holds 64 hexadecimal
/// digits and nobody but its owner may read it.
/// @return false with a sentence in `error`.
bool key_read(const char* path, int64_t now_us, ssv_link_signing_t* signing, char* error, size_t error_size);

#endif
