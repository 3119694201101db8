/// Tells the bus of a schedule: SSV_SCHEDULE, for whoever watches.
#ifndef SSV_ANNOUNCE_H
#define SSV_ANNOUNCE_H

#include <stdbool.h>
#include <stddef.h>

#include "lcm_ssv_schedule_t.h"
#include "scheduler/assembly.h"

/// A schedule as the bus has it: room for the parts of any structure. Its texts are lent from the structure.
typedef struct {
    lcm_ssv_schedule_t wire;
    lcm_ssv_schedule_part_t part[STRUCTURE_MAX_SLOTS];
} announce_t;

/// What the search found; no part has a plan yet. `shown` is the structure's file.
/// @return false with a sentence in `error`: ask_stamp.
bool announce_begin(announce_t* announce, const structure_t* structure, const char* shown,
                    const assembly_result_t* result, char* error, size_t error_size);

/// Publishes it as it is now. @param url  LCM provider; NULL for LCM's default. @return false with a sentence in
/// `error`.
bool announce_tell(const announce_t* announce, const char* url, char* error, size_t error_size);

#endif
