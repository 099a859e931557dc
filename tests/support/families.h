// Depth patches on which moment methods fail, and receivers for them: the stability suite. Every
// generator is deterministic in its seed and says which case it made through its arguments alone.
#ifndef FAMILIES_H
#define FAMILIES_H

#include <stdint.h>

enum {
    FAMILY_FLAT,      // one depth anywhere
    FAMILY_EXACT,     // one depth, exactly -1, 0 or 1
    FAMILY_SLOPE,     // a plane, 1e-4 to 1 steep over the patch
    FAMILY_TWO,       // two depths anywhere
    FAMILY_CLOSE,     // two depths 1e-7 to 1e-2 apart
    FAMILY_EDGE,      // an edge with a slope on each side
    FAMILY_THREE,     // three layers
    FAMILY_FOLIAGE,   // 4 to 16 depths, scattered
    FAMILY_CONTINUUM, // depths uniform in an interval
    FAMILY_NEAR_FAR,  // -1 and 1, or nearly so
    FAMILY_OUTLIER,   // one sample away from an otherwise flat patch
    FAMILY_BIMODAL,   // two depths, each with noise
    FAMILY_COUNT
};

enum {
    RECEIVER_ON_DEPTH, // exactly at a depth of the patch
    RECEIVER_NEAR,     // 1e-7 to 3e-2 away from one
    RECEIVER_HULL,     // 1e-7 to 1e-2 outside all of them
    RECEIVER_FAR,      // anywhere in [-1.5,1.5] outside all of them
    RECEIVER_INSIDE,   // uniform in [-1,1]
    RECEIVER_COUNT
};

extern const char *const family_names[FAMILY_COUNT];

// The 64 bits after *state of the splitmix64 sequence, and a number in [low,high) made from them.
uint64_t family_random(uint64_t *state);
double family_range(uint64_t *state, double low, double high);

// The Chebyshev polynomial T_k, k >= 1, by its recurrence.
double family_chebyshev(int k, double z);

// Writes side*side depths in [-1,1], row by row. Side at most 32.
void family_patch(int family, int side, uint64_t *state, float *depth);

// A receiver for a patch of `count` depths.
float family_receiver(int kind, int count, const float *depth, uint64_t *state);

#endif
