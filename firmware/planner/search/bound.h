/// What no motion can undercut (DESIGN.md 11).
#ifndef SSV_BOUND_H
#define SSV_BOUND_H

#include "planner/motion/question.h"

/// Cost per metre of the vehicle's centre, whatever the attitude: no flight costs less as long as nothing else than
/// thrust helps it along. That is so for every straight flight, also with a beam that feels drag.
real_t ssv_least_metre_price(const ssv_question_t* question);

/// What no plan undercuts, as ssv_lower_bound tells it of the scenario's own question.
real_t ssv_least_price(const ssv_question_t* question);

#endif
