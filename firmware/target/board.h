/// What a bare-metal program needs of the board: where it starts, how many instructions it has run, how deep its stack
/// went.
///
/// The reset handler sets up memory and the floating-point unit where there is one, calls main, and ends the emulator
/// through semihosting with main's result as the exit code. A fault ends it with 70.
#ifndef SSV_BOARD_H
#define SSV_BOARD_H

#include <stddef.h>
#include <stdint.h>

/// Instructions since the start. Exact and repeatable under `qemu-system-arm -icount shift=5`, meaningless elsewhere.
uint64_t board_instructions(void);

/// Marks the unused stack below the caller, so that board_stack_used can tell how deep it went since.
void board_stack_paint(void);

/// Bytes of stack used since board_stack_paint was called, below its caller.
size_t board_stack_used(void);

#endif
