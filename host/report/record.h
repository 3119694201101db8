/// What a file tells that can be shown: a plan, a flight, or the plans of an assembly one after the other
/// (host/FORMATS.md).
#ifndef SSV_RECORD_H
#define SSV_RECORD_H

#include <stdbool.h>
#include <stddef.h>

#include "flown.h"
#include "lcm_ssv_execution_t.h"
#include "lcm_ssv_plan_t.h"
#include "lcm_ssv_task_t.h"
#include "ssv/check.h"
#include "ssv/plan.h"

/// How an attempt to mate or dock went, by the simulator's truth.
typedef struct {
    char outcome[32]; ///< empty where nobody tells
    double position_m, angle_rad, speed_m_s;
} record_attempt_t;

/// How a leg was flown; not at all where it was not begun.
typedef struct {
    bool begun;
    double time_s, wait_s, impulse_Ns;
} record_leg_t;

/// How a task was flown.
typedef struct {
    flown_t track;
    lcm_ssv_execution_t end; ///< what was told last
    record_leg_t leg[SSV_MAX_LEGS];
    record_attempt_t mate, dock;
    char conditions[64], seed[32]; ///< of a simulated flight; empty otherwise
} record_flight_t;

/// A task: what was asked, what was planned, and how it was flown.
typedef struct {
    char name[64];
    lcm_ssv_task_t question;
    lcm_ssv_plan_t plan;
    char breach[SSV_CHECK_REASON_SIZE]; ///< why the plan cannot be the answer to the question; empty if it can
    record_flight_t* flight;            ///< NULL where it was not flown
} record_task_t;

typedef struct {
    char title[256]; ///< the file's name, harmless
    int count;
    record_task_t* tasks;
} record_t;

/// Reads a file, "-" for standard input. @return false with a sentence in `error`, and nothing to free.
bool record_read(const char* path, record_t* record, char* error, size_t error_size);

void record_free(record_t* record);

/// Frees what a task points to, and empties it.
void record_task_free(record_task_t* task);

#endif
