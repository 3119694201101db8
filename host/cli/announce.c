#include "announce.h"

#include <lcm/lcm.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "ask.h"
#include "channels.h"

bool announce_begin(announce_t* announce, const structure_t* structure, const char* shown,
                    const assembly_result_t* result, char* error, size_t error_size) {
    lcm_ssv_schedule_t* const wire = &announce->wire;
    *wire = (lcm_ssv_schedule_t){.structure = (char*)(uintptr_t)shown,
                                 .weight_time_per_s = structure->task.weight_time_per_s,
                                 .weight_impulse_per_Ns = structure->task.weight_impulse_per_Ns,
                                 .cost = result->best.cost,
                                 .lower_bound = result->lower_bound,
                                 .optimal = result->status == HTN_OPTIMAL,
                                 .num_parts = result->best.num_parts,
                                 .parts = announce->part};
    for (int i = 0; i < result->best.num_parts; i++) {
        const assembly_part_t* const part = &result->best.part[i];
        announce->part[i] = (lcm_ssv_schedule_part_t){.beam = (char*)(uintptr_t)structure->beam[part->beam].name,
                                                      .slot = (char*)(uintptr_t)structure->slot[part->slot].name,
                                                      .cost = part->price.cost,
                                                      .time_s = part->price.time_s,
                                                      .impulse_Ns = part->price.impulse_Ns};
        wire->time_s += part->price.time_s;
        wire->impulse_Ns += part->price.impulse_Ns;
    }
    return ask_stamp(&wire->asker, error, error_size);
}

bool announce_tell(const announce_t* announce, const char* url, char* error, size_t error_size) {
    lcm_t* const lcm = lcm_create(url);
    const int size = lcm_ssv_schedule_t_encoded_size(&announce->wire);
    uint8_t* const message = lcm == NULL ? NULL : malloc((size_t)size);
    const bool told = message != NULL && lcm_ssv_schedule_t_encode(message, 0, size, &announce->wire) == size &&
                      lcm_publish(lcm, CHANNEL_SCHEDULE, message, (unsigned)size) == 0;
    if (!told) snprintf(error, error_size, "cannot tell of the schedule over LCM");
    free(message);
    if (lcm != NULL) lcm_destroy(lcm);
    return told;
}
