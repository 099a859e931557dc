// Mip maps of the images that convolution soft shadows filter, in the bits of the paper: 8 for the
// waves, 16 for what is weighted by depth. A square of any width is one trilinear read.
#ifndef MIP_MAPS_H
#define MIP_MAPS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { LEVELS_MOST = 16 };

// Texels of all levels, the finest first; channels of a texel lie side by side.
typedef struct mip_maps {
    int levels, side[LEVELS_MOST];
    size_t first[LEVELS_MOST]; // texel of the level
    int channels;              // of waves; a multiple of four
    int8_t *waves;             // -1 to 1 as -127 to 127
    int16_t *weighted;         // waves times a phase, -1 to 1 as -32767 to 32767
    int16_t *phases;           // one a texel
} mip_maps;

bool mip_maps_create(mip_maps *m, int side, int channels, size_t *bytes);
void mip_maps_free(mip_maps *m);
void mip_maps_set(mip_maps *m, size_t texel, const float *waves, float phase);
void mip_maps_build(mip_maps *m); // the coarser levels, once all texels are set

// The texels of a trilinear read around a place in texels of the finest level.
typedef struct mip_read {
    size_t at[8];
    float weight[8];
    float outside; // share of the read that lies beside the map; with it the weights sum to 1
} mip_read;
mip_read mip_maps_read(const mip_maps *m, float x, float y, float level);

void mip_maps_waves(const mip_maps *m, const mip_read *r, float *mean);
void mip_maps_weighted(const mip_maps *m, const mip_read *r, float *mean);
float mip_maps_phase(const mip_maps *m, const mip_read *r);

#endif
