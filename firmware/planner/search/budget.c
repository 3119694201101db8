#include "planner/search/budget.h"

#include "planner/profile/estimate.h"
#include "ssv/plan.h"

const ssv_draws_t ssv_draws[SSV_NUM_REGIMES] = {
    [SSV_LINEAR_DRAG] = {.screening = {{[SSV_HELD] = 2, [SSV_SWUNG] = 2}},
                         .best = {{[SSV_HELD] = 3, [SSV_SWUNG] = 3, [SSV_ROLLED] = 3}}},
    [SSV_ANY_DRAG] = {
        .screening = {{[SSV_SWUNG] = 2, [SSV_LENGTHWISE] = 1, [SSV_STEADY] = 1}},
        .num_transits = 2,
        .best = {{[SSV_HELD] = 2, [SSV_SWUNG] = 3, [SSV_ROLLED] = 1, [SSV_LENGTHWISE] = 2, [SSV_STEADY] = 1}}}};

const ssv_draw_t ssv_evasion_draw = {{[SSV_HELD] = 3, [SSV_SWUNG] = 3, [SSV_ROLLED] = 3}};

static const ssv_budget_t quick[SSV_NUM_REGIMES] = {
    [SSV_LINEAR_DRAG] = {.num_screened = 2,
                         .num_searched = 1,
                         .closeness = SSV_ESTIMATE_ROUGHLY,
                         .acceptance = {.promise = REAL(1e-4), .least_bend = REAL(3e-3), .clearly = REAL(2e-4)},
                         .rounds = {{SSV_SCREENED_SEEDS, 1, false}},
                         .evasion = {[SSV_TRANSIT] = {2, 2, false}, [SSV_TRANSFER] = {6, 1, false}}},
    [SSV_ANY_DRAG] = {
        .num_screened = SSV_MAX_CANDIDATES,
        .num_searched = 1,
        .closeness = SSV_ESTIMATE_ROUGHLY,
        .acceptance = {.promise = REAL(1e-4), .least_bend = REAL(3e-3), .clearly = REAL(2e-4), .goes_on = REAL(0.03)},
        .rounds = {{SSV_SCREENED_SEEDS, 3, false}},
        .transit = {1, 2, false},
        .evasion = {[SSV_TRANSIT] = {2, 2, false}, [SSV_TRANSFER] = {6, 1, false}}}};

static const ssv_budget_t best = {
    .num_screened = SSV_MAX_CANDIDATES,
    .num_searched = SSV_MAX_CANDIDATES,
    .closeness = SSV_ESTIMATE_CLOSELY,
    .acceptance = {.promise = REAL(1e-5), .least_bend = REAL(1e-5), .clearly = REAL(2e-6)},
    .draws = true,
    .rounds = {{SSV_MAX_SEEDS, 1, false}, {3, 3, false}, {1, 3, true}},
    .transit = {1, 3, false},
    .joint = {1, 4, true},
};

const ssv_budget_t* ssv_budget(ssv_regime_t regime, ssv_effort_t effort) {
    return effort == SSV_EFFORT_QUICK ? &quick[regime] : &best;
}

const ssv_detour_t ssv_detours[SSV_NUM_DETOURS] = {{SSV_EFFORT_QUICK, REAL(0.5), REAL(0.5)},
                                                   {SSV_EFFORT_QUICK, REAL(0.5), REAL(1)},
                                                   {SSV_EFFORT_BEST, REAL(0), REAL(0)},
                                                   {SSV_EFFORT_BEST, REAL(0.5), REAL(0.5)},
                                                   {SSV_EFFORT_BEST, REAL(0.5), REAL(1)}};
