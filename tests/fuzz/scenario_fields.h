// Which numbers a scenario has on the wire and which of them are legal: what the corpus and the mutator both draw from.
#ifndef SCENARIO_FIELDS_H
#define SCENARIO_FIELDS_H

#include <stddef.h>

#include "lcm_ssv_task_t.h"

typedef struct {
    const char* name;
    size_t offset; ///< of the first number in lcm_ssv_scenario_t
    int count;     ///< numbers in a row
    double min, max;
} scenario_field_t;

extern const scenario_field_t scenario_fields[];
extern const int num_scenario_fields;

/// The first number of a field.
double* scenario_field_of(lcm_ssv_scenario_t* scenario, const scenario_field_t* field);

/// Makes agree what has to agree among the fields: heights lie on the beam, some weight is positive, directions and
/// quaternions have length 1, choices are ones that exist, the scene's too. Of what makes an answer many times slower
/// (effort best, heights between the rings, a front) one remains, so that a fuzzer gets on.
void scenario_repair(lcm_ssv_scenario_t* scenario, lcm_ssv_scene_t* scene);

#endif
