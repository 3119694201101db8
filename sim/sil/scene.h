/// The simulated scene of a plan: its bodies, poses, where it mates and docks, and what stands around.
#ifndef SIM_SCENE_H
#define SIM_SCENE_H

#include "replay/plan_file.h"
#include "sil.h"

/// Without disturbances and without limits to what counts as a hit.
void scene_of_plan(const plan_file_t* plan, sil_config_t* config);

#endif
