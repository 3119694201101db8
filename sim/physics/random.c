#include "random.h"

#include <math.h>

#define TWO_PI 6.28318530717958647693

static uint64_t splitmix64(uint64_t* state) {
    uint64_t z = *state += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

static uint64_t rotated_left(uint64_t x, int bits) { return (x << bits) | (x >> (64 - bits)); }

void sim_random_init(sim_random_t* random, uint64_t seed, uint64_t stream) {
    // The stream is mixed before it meets the seed; a plain sum would make stream 1 of seed 1 stream 0 of seed 2.
    uint64_t state = seed ^ splitmix64(&stream);
    for (int i = 0; i < 4; i++) {
        random->s[i] = splitmix64(&state);
    }
}

uint64_t sim_random_bits(sim_random_t* random) {
    uint64_t* s = random->s;
    const uint64_t result = rotated_left(s[0] + s[3], 23) + s[0], t = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = rotated_left(s[3], 45);
    return result;
}

double sim_random_uniform(sim_random_t* random) { return (double)(sim_random_bits(random) >> 11) * 0x1p-53; }

double sim_random_gauss(sim_random_t* random) {
    const double radius = sqrt(-2 * log(1 - sim_random_uniform(random)));
    return radius * cos(TWO_PI * sim_random_uniform(random));
}
