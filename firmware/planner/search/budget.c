#include "planner/search/budget.h"

#include "planner/profile/estimate.h"
#include "ssv/plan.h"

const ssv_budget_t ssv_budgets[2] = {
    [SSV_EFFORT_QUICK] = {.num_screened = 2,
                          .num_searched = 1,
                          .closeness = SSV_ESTIMATE_ROUGHLY,
                          .acceptance = {.promise = REAL(1e-4), .least_bend = REAL(3e-3), .clearly = REAL(2e-4)},
                          .rounds = {{SSV_SCREENED_SEEDS, 1, false}},
                          .evasion = {[SSV_TRANSIT] = {2, 2, false}, [SSV_TRANSFER] = {6, 1, false}}},
    [SSV_EFFORT_BEST] = {.num_screened = SSV_MAX_CANDIDATES,
                         .num_searched = SSV_MAX_CANDIDATES,
                         .closeness = SSV_ESTIMATE_CLOSELY,
                         .acceptance = {.promise = REAL(1e-5), .least_bend = REAL(1e-5), .clearly = REAL(2e-6)},
                         .num_modes = 3,
                         .num_seeds = 3,
                         .rounds = {{SSV_MAX_SEEDS, 1, false}, {3, 3, false}, {1, 3, true}},
                         .transit = {1, 3, false},
                         .joint = {1, 4, true}}};

const ssv_detour_t ssv_detours[SSV_NUM_DETOURS] = {{SSV_EFFORT_QUICK, REAL(0.5), REAL(0.5)},
                                                   {SSV_EFFORT_QUICK, REAL(0.5), REAL(1)},
                                                   {SSV_EFFORT_BEST, REAL(0), REAL(0)},
                                                   {SSV_EFFORT_BEST, REAL(0.5), REAL(0.5)},
                                                   {SSV_EFFORT_BEST, REAL(0.5), REAL(1)}};
