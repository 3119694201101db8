// The archive that tests link stops where a precondition of the core does not hold.
#define _POSIX_C_SOURCE 200809L
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "planner/profile/profile.h"
#include "unity.h"

void setUp(void) {}
void tearDown(void) {}

// Whether a process that asks for the thrust of thruster i ends by a signal.
static bool is_stopped(int i) {
    const pid_t child = fork();
    TEST_ASSERT_TRUE(child >= 0);
    if (child == 0) {
        (void)setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
        // Three sets of six coefficients: an index that is off by a few still reads within the struct.
        const ssv_thrusts_t thrusts = {{1}, {2}, {3}, 4};
        const ssv_arc_t arc = {.dv_dt = {1}};
        double c[3];
        ssv_arc_thrust(&thrusts, &arc, i, c);
        _exit(0);
    }
    int status;
    TEST_ASSERT_EQUAL_INT(child, waitpid(child, &status, 0));
    return WIFSIGNALED(status);
}

static void test_a_broken_precondition_stops_the_program_and_a_kept_one_does_not(void) {
    TEST_ASSERT_FALSE(is_stopped(0));
    TEST_ASSERT_FALSE(is_stopped(SSV_NUM_THRUSTERS - 1));
    TEST_ASSERT_TRUE(is_stopped(SSV_NUM_THRUSTERS));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_a_broken_precondition_stops_the_program_and_a_kept_one_does_not);
    return UNITY_END();
}
