#include "board.h"

#include <stdlib.h>

// From the linker script.
extern uint64_t data_start[], data_end[], data_image[], bss_start[], bss_end[], stack_limit[], stack_top[];

extern void initialise_monitor_handles(void);
extern void __libc_init_array(void);
extern int main(void);

void reset(void);
// Newlib calls these around its own set-up; there is nothing for them to do.
void _init(void);
void _fini(void);

#define REGISTER(address) (*(volatile uint32_t*)(uintptr_t)(address))
#define SYSTICK_CONTROL REGISTER(0xe000e010)
#define SYSTICK_RELOAD REGISTER(0xe000e014)
#define SYSTICK_VALUE REGISTER(0xe000e018)
#define COPROCESSOR_ACCESS REGISTER(0xe000ed88)

// ---- Instructions ---------------------------------------------------------------------------------------------------

// The clock runs at 25 MHz, and `-icount shift=5` has an instruction take 2^5 ns.
#define TICK_NS 40
#define INSTRUCTION_NS 32
#define TICKS_PER_TURN 0x1000000

static volatile uint32_t turns;

static void systick_turned(void) { turns++; }

uint64_t board_instructions(void) {
    uint32_t turn, left;
    do {
        turn = turns;
        left = SYSTICK_VALUE;
    } while (turn != turns);
    return ((uint64_t)turn * TICKS_PER_TURN + (TICKS_PER_TURN - 1 - left)) * TICK_NS / INSTRUCTION_NS;
}

// ---- Stack ----------------------------------------------------------------------------------------------------------

#define PAINT 0x5aa5c33c5aa5c33cu
// What the painter's own frame may take.
#define OWN_BYTES 64

static uint64_t* painted_to;

void board_stack_paint(void) {
    painted_to = (uint64_t*)(((uintptr_t)__builtin_frame_address(0) - OWN_BYTES) & ~(uintptr_t)7);
    for (volatile uint64_t* p = stack_limit; p < painted_to; p++) *p = PAINT;
}

size_t board_stack_used(void) {
    const volatile uint64_t* p = stack_limit;
    while (p < painted_to && *p == PAINT) p++;
    return (size_t)((const volatile uint8_t*)painted_to - (const volatile uint8_t*)p);
}

// ---- Start ----------------------------------------------------------------------------------------------------------

void _init(void) {}
void _fini(void) {}

static void fault(void) { _Exit(70); }

void reset(void) {
    for (uint64_t *from = data_image, *to = data_start; to < data_end;) *to++ = *from++;
    for (uint64_t* to = bss_start; to < bss_end;) *to++ = 0;
#if defined __ARM_FP
    COPROCESSOR_ACCESS |= 0xf00000;
    __asm__ volatile("dsb\n\tisb");
#endif
    SYSTICK_RELOAD = TICKS_PER_TURN - 1;
    SYSTICK_VALUE = 0;
    SYSTICK_CONTROL = 7;
    initialise_monitor_handles();
    __libc_init_array();
    exit(main());
}

typedef void (*handler_t)(void);

typedef struct {
    uint64_t* stack;
    handler_t handler[15]; // reset, faults, SysTick
} vectors_t;

__attribute__((section(".vectors"), used)) static const vectors_t vectors = {
    stack_top, {reset, fault, fault, fault, fault, fault, [14] = systick_turned}};
