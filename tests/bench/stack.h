/// How deep a call goes into its stack.
#ifndef BENCH_STACK_H
#define BENCH_STACK_H

#include <stddef.h>

/// Runs run(argument) on a painted stack of its own. @return bytes that it and what it calls have overwritten.
size_t stack_high_water(void (*run)(void* argument), void* argument);

#endif
