/// Flies the schedule of a structure in simulation, part after part, and schedules anew what a failed flight leaves.
#ifndef SSV_FLY_STRUCTURE_H
#define SSV_FLY_STRUCTURE_H

#include "scheduler/structure.h"
#include "task_options.h"

/// Each flight begins where the one before left vehicle and beams, and plans past what really stands; its seed is one
/// more than that of the flight before. `structure` becomes what stands at the end.
/// @return the exit code.
int fly_structure(const task_options_t* options, structure_t* structure);

#endif
