/// Method paper: nearest ring angle (or the cheapest of several where none is nearest); translate, then turn the
/// shortest way; turn about C, then translate (DESIGN.md 6).
#ifndef SSV_SEARCH_PAPER_H
#define SSV_SEARCH_PAPER_H

#include "planner/motion/maneuver.h"
#include "planner/motion/path.h"
#include "planner/motion/question.h"

/// A search of candidates by the paper's paths.
typedef struct {
    const ssv_question_t* question;
    ssv_price_t to_beat;      ///< ring angles that a bound, or an estimate with a margin, rules out against it are left
                              ///< out; none if it is not feasible
    ssv_phase_path_t transit; ///< priced last: from one candidate to the next the turn is often the same
    int num_priced;           ///< paths so far
    ssv_clearance_t clearance; ///< of the last path that came too near something
} ssv_paper_search_t;

/// Begins a search that leaves out what cannot beat this price.
void ssv_paper_search_begin(ssv_paper_search_t* search, const ssv_question_t* question, const ssv_price_t* to_beat);

/// The cheapest path of a candidate. @return false if all of it was left out; then *path is not meaningful.
bool ssv_paper_search(ssv_paper_search_t* search, int contact, real_t height_m, ssv_path_t* path);

#endif
