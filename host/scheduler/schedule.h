/// What comes out in the end: parts in order, with their prices.
#ifndef SSV_SCHEDULER_SCHEDULE_H
#define SSV_SCHEDULER_SCHEDULE_H

#include "prices.h"
#include "structure.h"

typedef struct {
    int beam, slot;
    assembly_question_t question;
    assembly_price_t price;
} assembly_part_t;

typedef struct {
    int num_parts; ///< 0: there is no schedule
    assembly_part_t part[STRUCTURE_MAX_SLOTS];
    double cost;
} assembly_schedule_t;

#endif
