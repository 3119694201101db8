/// What the page shows, as plain data: bodies, motions, thrusts and tables of one task after another. report.js is its
/// only reader; picture.c says field by field what there is.
#ifndef SSV_PICTURE_H
#define SSV_PICTURE_H

#include <jansson.h>
#include <stddef.h>

#include "record.h"
#include "track.h"

/// @return the data of the page, which the caller frees with json_decref; NULL with a sentence in `error`.
json_t* picture_of(const record_t* record, char* error, size_t error_size);

/// What the page is told of a state of a flight as it is heard, likewise; `flown` has noted it.
json_t* picture_row(const track_t* track, const flown_t* flown, const lcm_ssv_vehicle_state_t* state, bool is_truth);

#endif
