/// What the parts of an assembly are asked for and cost: between the search and whoever knows prices.
#ifndef SSV_SCHEDULER_PRICES_H
#define SSV_SCHEDULER_PRICES_H

#include <stdbool.h>

#include "set.h"

/// One part to be assembled.
typedef struct {
    int pose; ///< number of the vehicle's pose at the start; 0 is the structure's
    int beam, slot;
    int left;    ///< slot of the beam that the vehicle stands at, or -1
    set_t built; ///< slots with a beam
} assembly_question_t;

typedef struct {
    bool feasible; ///< the rest holds if so
    double cost, time_s, impulse_Ns;
    int pose; ///< where the vehicle ends
} assembly_price_t;

/// Where prices come from. @return false if there are none to be had, which ends the search.
typedef struct {
    bool (*ask)(void* context, const assembly_question_t* questions, int count, assembly_price_t* prices);
    void* context;
} assembly_prices_t;

#endif
