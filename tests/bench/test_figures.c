// The clock that the benchmark judges by.
#define _POSIX_C_SOURCE 200809L
#include <time.h>

#include "figures.h"
#include "unity.h"

void setUp(void) {}
void tearDown(void) {}

// A process that is kept from the processor, as on a loaded machine, is to the clock as one that sleeps.
static void test_time_without_the_processor_does_not_count(void) {
    const struct timespec pause = {0, 200000000};
    const double wall = wall_ms(), spent = spent_ms();
    nanosleep(&pause, NULL);
    TEST_ASSERT_TRUE(wall_ms() - wall >= 200);
    TEST_ASSERT_TRUE(spent_ms() - spent < 20);
}

static void test_time_on_the_processor_counts(void) {
    const double wall = wall_ms(), spent = spent_ms();
    double counted = 0;
    while (counted < 20) counted += calibrate_ms();
    const double spent_in_all = spent_ms() - spent;
    TEST_ASSERT_TRUE(spent_in_all >= 20 && spent_in_all < 1.5 * counted);
    TEST_ASSERT_TRUE(wall_ms() - wall >= 0.99 * spent_in_all);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_time_without_the_processor_does_not_count);
    RUN_TEST(test_time_on_the_processor_counts);
    return UNITY_END();
}
