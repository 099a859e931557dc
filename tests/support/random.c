#include "test.h"

uint64_t test_random(uint64_t *state)
{
    uint64_t x = *state;
    x ^= x >> 12;
    x ^= x << 25;
    x ^= x >> 27;
    *state = x;
    return x * UINT64_C(2685821657736338717);
}

double test_uniform(uint64_t *state)
{
    return (double)(test_random(state) >> 11) * (1.0 / 9007199254740992.0);
}

double test_range(uint64_t *state, double low, double high)
{
    return low + (high - low) * test_uniform(state);
}
