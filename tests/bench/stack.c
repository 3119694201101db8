#include "stack.h"

#include <stdint.h>
#include <string.h>
#include <ucontext.h>

#define STACK_SIZE (256 * 1024)
#define PAINT 0xA5

static uint8_t stack[STACK_SIZE];
static ucontext_t outside, inside;
static void (*call)(void* argument);
static void* call_argument;

static void enter(void) { call(call_argument); }

static void nothing(void* argument) { (void)argument; }

static size_t measure(void (*run)(void* argument), void* argument) {
    call = run;
    call_argument = argument;
    memset(stack, PAINT, sizeof stack);
    getcontext(&inside);
    inside.uc_stack.ss_sp = stack;
    inside.uc_stack.ss_size = sizeof stack;
    inside.uc_link = &outside;
    makecontext(&inside, enter, 0);
    swapcontext(&outside, &inside);
    size_t untouched = 0;
    while (untouched < sizeof stack && stack[untouched] == PAINT) untouched++;
    return sizeof stack - untouched;
}

size_t stack_high_water(void (*run)(void* argument), void* argument) {
    return measure(run, argument) - measure(nothing, NULL);
}
