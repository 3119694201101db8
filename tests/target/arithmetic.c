/// Every operation of the scalar over seeded arguments. Prints a line for each: its name, a hash of all results, the
/// mean and the most instructions of a call. The hashes of fixed point are the same everywhere.
#include <inttypes.h>
#include <stdio.h>

#include "board.h"
#include "ssv/real.h"

#define COUNT 4000
#define SEED 20261122u

static uint64_t random_state;

// splitmix64
static uint64_t random_bits(void) {
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

// Up to 1000 in size, of every order of magnitude down to 2^-22, exact in every scalar.
static real_t random_real(void) {
    const uint64_t r = random_bits();
    const double size = (double)(r >> 44) / (double)(1u << (10 + r % 13));
    return real_from_double((r & 0x100) != 0 ? -size : size);
}

static real_t nothing(real_t a, real_t b) { return a < b ? a : b; }
static real_t root(real_t a, real_t b) { return (void)b, real_sqrt(real_abs(a)); }
static real_t log1p_of(real_t a, real_t b) { return (void)b, real_log1p(real_abs(a)); }
static real_t expm1_of(real_t a, real_t b) { return (void)b, real_expm1(-real_abs(a)); }
static real_t sine(real_t a, real_t b) { return (void)b, real_sin(a); }
static real_t cosine(real_t a, real_t b) { return (void)b, real_cos(a); }
static real_t tangent(real_t a, real_t b) { return (void)b, real_tan(a); }

static const struct {
    const char* name;
    real_t (*call)(real_t a, real_t b);
} operations[] = {{"nothing", nothing}, {"mul", real_mul}, {"div", real_div}, {"sqrt", root},   {"log1p", log1p_of},
                  {"expm1", expm1_of},  {"sin", sine},     {"cos", cosine},   {"tan", tangent}, {"atan2", real_atan2}};

int main(void) {
    for (size_t k = 0; k < sizeof operations / sizeof *operations; k++) {
        uint64_t hash = 0xcbf29ce484222325u, sum = 0, most = 0;
        random_state = SEED;
        for (int n = 0; n < COUNT; n++) {
            const real_t a = random_real(), b = random_real();
            const uint64_t before = board_instructions();
            const real_t result = operations[k].call(a, b);
            const uint64_t instructions = board_instructions() - before;
            hash = (hash ^ real_bits(result)) * 0x100000001b3u;
            sum += instructions;
            if (instructions > most) most = instructions;
        }
        printf("%s %08" PRIx32 "%08" PRIx32 " %u %u\n", operations[k].name, (uint32_t)(hash >> 32), (uint32_t)hash,
               (unsigned)(sum / COUNT), (unsigned)most);
    }
    return 0;
}
