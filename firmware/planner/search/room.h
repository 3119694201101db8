/// Room: whether start, mating place and goal of a candidate are free at all, before anything is searched.
#ifndef SSV_ROOM_H
#define SSV_ROOM_H

#include "planner/motion/question.h"
#include "ssv/plan.h"

/// Looks at the ends of both phases of the candidate. If one is blocked, whatever the motion, its outcome says so and
/// it names the obstacle. Costs some tens of distances.
void ssv_room_check(const ssv_question_t* question, ssv_candidate_t* candidate);

#endif
