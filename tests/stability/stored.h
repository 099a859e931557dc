// Depth patches as they come out of storage: what a filter region's moments are by the time that a
// shader reads them, for each storage format, and the blend with a bias vector.
#ifndef STORED_H
#define STORED_H

#include <stdint.h>

#include "../../mssm.h"

enum { PATCH_SIDE = 27, RECEIVERS = 5 };

typedef struct patch {
    int side, count;
    float depth[PATCH_SIDE * PATCH_SIDE];
    float z[RECEIVERS]; // one receiver of each kind
} patch;

enum {
    FORMAT_FLOAT32,   // float32 powers, stored once
    FORMAT_UNORM16,   // 16-bit Chebyshev values, stored once
    FORMAT_FILTERED,  // the same, stored by a resolve and two blur passes
    FORMAT_TABLE,     // mssm.h's own integer table
    FORMAT_FLOAT_SAT, // float32 summed-area table of 256 x 256 powers, the patch in the far corner
    FORMAT_SLIDES,    // uint32 table of (T+1)/2 with the slides' scale, (float)(2^32 / 27^2)
    FORMATS
};
extern const char *const format_names[FORMATS];  // for the command line
extern const char *const format_titles[FORMATS]; // for people

enum { VECTOR_OURS, VECTOR_CUSTOMARY, VECTORS };

// Unbiased powers b[0..5] of the patch after that storage, and what the table holds: E[T_k].
// Four moments are the first four of six.
typedef struct stored {
    float b[6], t[6];
} stored;

// The same patch and receivers for the same family, number and seed on every run.
patch patch_make(int family, int number, unsigned seed);
stored patch_store(const patch *p, int format);

// The safe strength of that format for that vector. The last two formats have none: that of the
// table stands in.
float safe_bias(int m, int format, int vector);
void bias_moments(int m, int format, int vector, float alpha, const float b[6], float out[6]);

#endif
