// Maps as textures: what mssm_map_texels and mssm_map_view give for shading without an mssm_gl,
// against sums, means and least depths of the depth map itself. Shading by them is tested in
// tests/dialects.
#include "../../mssm.h"
#include "../support/test.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { SCALE = 2945788 }; // of a table entry that is 1 (MSSM_SCALE)

static double chebyshev(int k, double z)
{
    return cos(k * acos(z));
}

static mssm_map *make(void **memory, float **depth, int side, int moments, uint64_t *state)
{
    mssm_map *map = NULL;
    const size_t bytes = mssm_map_bytes(side, moments);
    *memory = malloc(bytes);
    *depth = malloc((size_t)side * (size_t)side * sizeof **depth);
    for (int i = 0; i < side * side; i++) (*depth)[i] = (float)test_range(state, -1, 1);
    CHECK(!mssm_map_init(&map, *memory, bytes, side, moments), "init");
    CHECK(!mssm_map_update(map, *depth, NULL, 1), "update");
    return map;
}

// Mean of a Chebyshev polynomial over the texels of the map in [x0,x1) x [y0,y1), as far as there
// are any.
static double mean(const float *depth, int side, int k, int x0, int y0, int x1, int y1,
                   double least[2])
{
    double sum = 0;
    int count = 0;
    const bool outside = x0 >= side || y0 >= side;
    least[0] = least[1] = outside ? 0 : 1;
    for (int y = y0; y < y1 && y < side; y++) {
        for (int x = x0; x < x1 && x < side; x++, count++) {
            sum += chebyshev(k, depth[y * side + x]);
            least[0] = fmin(least[0], depth[y * side + x]);
            least[1] = fmin(least[1], -depth[y * side + x]);
        }
    }
    return count ? sum / count : 0;
}

// Each texel of a level is one entry less its neighbours: the mean of the texels of the map that it
// covers. Those of least depth, but for the finest, stand for the next ones too.
static void check_level(const mssm_map *map, const float *depth, int side, int which, int level)
{
    mssm_texels t;
    CHECK(!mssm_map_texels(map, which, level, &t, NULL, 0), "sizes of %d, level %d", which, level);
    const size_t all = t.bytes;
    unsigned char *bytes = malloc(all + 1);
    bytes[all] = 77;
    memset(&t, 0, sizeof t);
    CHECK(!mssm_map_texels(map, which, level, &t, bytes, all), "level %d", level);
    CHECK(t.bytes == all && bytes[all] == 77, "beyond the end");
    const int channels = which ? 2 : 4, shift = which == 2 ? level + 1 : level, texel = 1 << shift;
    const int size = (side + texel - 1) >> shift;
    CHECK(t.side >= size && t.bytes == (size_t)(t.side * t.side * channels * 4),
          "side %d, %d bytes", t.side, (int)t.bytes);
    const int32_t *table = (const int32_t *)(const void *)bytes;
    const float *depths = (const float *)(const void *)bytes;
    const int wide = which == 2 && level ? 2 * texel : texel;
    double worst = 0, least[2];
    for (int y = 0; y < t.side; y++) {
        for (int x = 0; x < t.side; x++) {
            const int at = y * t.side + x;
            for (int c = 0; c < channels; c++) {
                const double truth = mean(depth, side, 4 * which + c + 1, x * texel, y * texel,
                                          x * texel + wide, y * texel + wide, least);
                if (which == 2) {
                    CHECK(depths[2 * at + c] == (float)least[c],
                          "least depth at (%d, %d) of level %d", x, y, level);
                } else if (x >= size || y >= size) {
                    CHECK(!table[at * channels + c], "(%d, %d) is beyond the map", x, y);
                } else {
                    uint32_t sum = 0;
                    for (int i = 0; i < 4; i++) {
                        const int left = i & 1, below = i >> 1;
                        if (x < left || y < below) continue;
                        const uint32_t entry =
                            (uint32_t)table[(at - left - below * t.side) * channels + c];
                        sum += left != below ? 0u - entry : entry;
                    }
                    worst = fmax(worst, fabs((int32_t)sum / (double)SCALE - truth));
                }
            }
        }
    }
    CHECK(worst < 1e-6 * (1 + level), "moments of level %d are off by %g", level, worst);
    free(bytes);
}

static void levels_are_the_maps(void)
{
    static const int sides[] = {1, 2, 27, 28, 37, 64, 101};
    uint64_t state = 3;
    for (int i = 0; i < 14; i++) {
        const int side = sides[i / 2], moments = 4 + 2 * (i % 2);
        void *memory;
        float *depth;
        mssm_map *map = make(&memory, &depth, side, moments, &state);
        int most[3] = {0, 0, 0};
        for (int which = 0; which < 3; which++) {
            mssm_texels t = {0, 0, 0, 0, 0, 0};
            int first = 0;
            for (int level = 0; !mssm_map_texels(map, which, level, &t, NULL, 0); level++) {
                if (!level) first = t.side;
                CHECK(t.side == first >> level, "level %d of side %d halves to %d", level, first,
                      t.side);
                check_level(map, depth, side, which, level);
                most[which] = level + 1;
            }
            CHECK(t.levels == most[which], "%d levels, %d given", t.levels, most[which]);
            CHECK(most[which] == 0 || first >> (most[which] - 1) >= 1,
                  "the last level has no texels");
        }
        CHECK(most[0] > 0 && most[2] > 0 && (most[1] > 0) == (moments == 6),
              "side %d: textures are missing", side);
        free(memory);
        free(depth);
    }
}

static void bad_arguments_change_nothing(void)
{
    uint64_t state = 5;
    void *memory;
    float *depth;
    mssm_map *map = make(&memory, &depth, 30, 4, &state);
    mssm_texels t, same;
    int row[28], kept[28];
    unsigned char texels[32 * 32 * 16], untouched[sizeof texels];
    memset(&t, 9, sizeof t);
    memset(texels, 9, sizeof texels);
    memset(row, 9, sizeof row);
    memcpy(&same, &t, sizeof t);
    memcpy(untouched, texels, sizeof texels);
    memcpy(kept, row, sizeof row);
    CHECK(mssm_map_texels(NULL, 0, 0, &t, texels, sizeof texels) == MSSM_ERROR_ARGUMENT, "no map");
    CHECK(mssm_map_texels(map, 0, 0, NULL, texels, sizeof texels) == MSSM_ERROR_ARGUMENT,
          "no info");
    CHECK(mssm_map_texels(map, -1, 0, &t, texels, sizeof texels) == MSSM_ERROR_ARGUMENT,
          "texture -1");
    CHECK(mssm_map_texels(map, 3, 0, &t, texels, sizeof texels) == MSSM_ERROR_ARGUMENT,
          "texture 3");
    CHECK(mssm_map_texels(map, 1, 0, &t, texels, sizeof texels) == MSSM_ERROR_ARGUMENT,
          "moments 5 and 6 of 4");
    CHECK(mssm_map_texels(map, 0, -1, &t, texels, sizeof texels) == MSSM_ERROR_ARGUMENT,
          "level -1");
    CHECK(mssm_map_texels(map, 0, 2, &t, texels, sizeof texels) == MSSM_ERROR_ARGUMENT, "level 2");
    CHECK(mssm_map_texels(map, 2, 5, &t, texels, sizeof texels) == MSSM_ERROR_ARGUMENT,
          "least depths, level 5");
    CHECK(mssm_map_texels(map, 0, 0, &t, texels, 30 * 30 * 16 - 1) == MSSM_ERROR_MEMORY,
          "a byte too few");

    const float up[3] = {0, 1, 0}, axis[3] = {1, 0, 0}, low[3] = {-1, 0, -1}, high[3] = {1, 1, 1};
    mssm_light light, bad;
    CHECK(!mssm_light_directional(&light, up, axis, 0.1f, 0.2f, low, high), "light");
    CHECK(mssm_map_view(NULL, &light, NULL, row) == MSSM_ERROR_ARGUMENT, "no map");
    CHECK(mssm_map_view(map, NULL, NULL, row) == MSSM_ERROR_ARGUMENT, "no light");
    CHECK(mssm_map_view(map, &light, NULL, NULL) == MSSM_ERROR_ARGUMENT, "no view");
    bad = light;
    bad.z_far = bad.z_near;
    CHECK(mssm_map_view(map, &bad, NULL, row) == MSSM_ERROR_ARGUMENT, "a light without depth");
    bad = light;
    bad.world_to_shadow[5] = NAN;
    CHECK(mssm_map_view(map, &bad, NULL, row) == MSSM_ERROR_ARGUMENT, "a matrix with a NaN");
    CHECK(!memcmp(&t, &same, sizeof t) && !memcmp(texels, untouched, sizeof texels) &&
              !memcmp(row, kept, sizeof row),
          "a failure has left something behind");
    mssm_settings set = {0, MSSM_LAYERED, 0, 0, 0, 0};
    set.max_kernel = 14;
    CHECK(!mssm_map_view(map, &light, &set, row), "view");
    float number[28];
    memcpy(number, row, sizeof number);
    CHECK(!memcmp(number, light.world_to_shadow, sizeof light.world_to_shadow), "the matrix");
    CHECK(number[21] == 30 && number[22] == 7 && !row[23] && !row[24] && row[25] == 2 && !row[26] &&
              !row[27],
          "side %g, kernel %g, %d levels", (double)number[21], (double)number[22], row[25]);
    bad = light; // sizes that are no numbers are none, also where shaders read them
    bad.half_u = NAN;
    bad.half_v = bad.extent_u = 0;
    CHECK(!mssm_map_view(map, &bad, &set, row), "view");
    memcpy(number, row, sizeof number);
    for (int i = 0; i < 23; i++)
        CHECK(fabsf(number[i]) < 1e30f, "number %d of a spoiled view: %g", i, (double)number[i]);
    CHECK(number[16] == 0 && number[17] == 0, "kernels of %g and %g", (double)number[16],
          (double)number[17]);
    free(memory);
    free(depth);
}

const test_case texels_tests[] = {
    {"texels: levels hold what the map holds", levels_are_the_maps},
    {"texels: bad arguments change nothing", bad_arguments_change_nothing},
    {0, 0}};
