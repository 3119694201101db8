/// The choice by J: for one way to take hold of the beam, the cheapest chain of moves that does the task.
#ifndef SSV_SEARCH_H
#define SSV_SEARCH_H

#include "planner/grasp.h"
#include "planner/leg.h"

/// A way to do the whole task.
typedef struct {
    ssv_grasp_t grasp;
    int num_moves;
    ssv_move_t move[SSV_MAX_LEGS]; ///< transit moves first
    pose_t X_IS_mate;            ///< vehicle when it takes hold
    pose_t X_SB;                 ///< beam in S from then on
    ssv_price_t price;
} ssv_chain_t;

/// Prices the grasp at each of the ring angles and keeps the cheapest; *num_priced grows by the chains that were priced.
void ssv_search(const ssv_problem_t* problem, int contact, real_t height_m, const real_t* ring_angle_rad, int num_rings,
                ssv_chain_t* best, int* num_priced);

#endif
