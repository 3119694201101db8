/// Preconditions that only a mistake of the core itself can break. What comes from outside is checked by
/// ssv_problem_init and answered with a fault, never with a trap.
#ifndef SSV_ASSERT_H
#define SSV_ASSERT_H

/// With SSV_ASSERTIONS defined (tests and fuzzer) it stops the program where the condition does not hold; without
/// (target) it makes no code. The condition must have no effect of its own, and must hold for overflowed numbers, too:
/// a motion that is only tried may overflow, and that is an honest answer.
#if defined SSV_ASSERTIONS
#define SSV_ASSERT(condition) ((condition) ? (void)0 : __builtin_trap())
#else
#define SSV_ASSERT(condition) ((void)sizeof((condition) ? 1 : 0))
#endif

#endif
