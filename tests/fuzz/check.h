/// What a fuzzer demands: a rule that does not hold is printed and ends the program.
#ifndef TESTS_FUZZ_CHECK_H
#define TESTS_FUZZ_CHECK_H

#include <stdio.h>
#include <stdlib.h>

#define check(rule) ((rule) ? (void)0 : (fprintf(stderr, "broken: %s\n", #rule), abort()))

#endif
