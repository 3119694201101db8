// In place of the board where the tests of the target run on a desktop: nothing is counted there.
#include "board.h"

uint64_t board_instructions(void) { return 0; }
void board_stack_paint(void) {}
size_t board_stack_used(void) { return 0; }
