/// Seeded structures to assemble: some slots of EASE, and beams that lie beside it anyhow.
#ifndef TESTS_STRUCTURES_H
#define TESTS_STRUCTURES_H

#include "ssv/vec3.h"
#include "structure.h"

/// Reads EASE, of which the others are made. @return false with a sentence in `error`.
bool structures_open(char* error, size_t error_size);

/// So many slots, and one beam more in half of them; rules, weights and start at random. Draws by sample.h: who wants
/// the same again seeds the same.
structure_t structures_sample(int num_slots);

/// Finds out which slots touch one another, where slots or hubs were changed.
void structures_find_touching(structure_t* structure);

/// The core's vectors and quaternions as a structure file's numbers have them.
void structures_numbers_of_vector(vec3_t v, double n[3]);
void structures_numbers_of_attitude(quat_t q, double n[4]);

/// Whether two slots are at one hub.
bool structures_share_a_hub(const structure_slot_t* a, const structure_slot_t* b);

#endif
