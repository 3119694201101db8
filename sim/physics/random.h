/// Seeded random numbers for the simulator: xoshiro256++ of Blackman and Vigna, started by their splitmix64.
///
/// The same seed and stream give the same integers everywhere, and the same Gaussian numbers wherever libm's log, sqrt
/// and cos round alike. Each source of disturbance has a stream of its own, so that one more source changes no other.
#ifndef SIM_RANDOM_H
#define SIM_RANDOM_H

#include <stdint.h>

typedef struct {
    uint64_t s[4];
} sim_random_t;

void sim_random_init(sim_random_t* random, uint64_t seed, uint64_t stream);

uint64_t sim_random_bits(sim_random_t* random);

/// In [0, 1), a multiple of 2^-53.
double sim_random_uniform(sim_random_t* random);

/// Mean 0, standard deviation 1, by Box and Muller's formula: two uniform numbers for each.
double sim_random_gauss(sim_random_t* random);

#endif
