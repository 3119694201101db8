/// Method optimal: turn, fly, turn in both phases, with everything that is free decided by J (DESIGN.md 6).
#ifndef SSV_SEARCH_OPTIMAL_H
#define SSV_SEARCH_OPTIMAL_H

#include "planner/search/screen.h"
#include "ssv/plan.h"

/// Searches one candidate with this effort: by estimates, then priced exactly. Effort quick goes on from the last
/// screening, which must be of this candidate. *search->best is replaced if what is found costs less. @return what was
/// found.
ssv_candidate_t ssv_optimal_search(const ssv_search_t* search, int contact, real_t height_m, ssv_effort_t effort);

#endif
