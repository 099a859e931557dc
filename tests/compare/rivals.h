// What the methods of the comparison share: a light and its depth map made ready, a receiver in
// texels, and rectangles cut into strips of whole texels for summed-area tables.
#ifndef RIVALS_H
#define RIVALS_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "methods.h"

static inline float least(float a, float b)
{
    return a < b ? a : b;
}

static inline float most(float a, float b)
{
    return a > b ? a : b;
}

// NaN gives high.
static inline float limited(float x, float low, float high)
{
    return x < high ? (x > low ? x : low) : high;
}

// Four texels or channels at a time, written out with what gcc and clang both have for it, because
// gcc leaves such loops scalar at -O2.
enum { LANES = 4 };
typedef float floats __attribute__((vector_size(16)));
typedef int32_t ints __attribute__((vector_size(16)));

static inline floats all_of(float x)
{
    const floats all = {x, x, x, x};
    return all;
}

static inline floats load(const float *from)
{
    floats x;
    memcpy(&x, from, sizeof x);
    return x;
}

static inline ints load_ints(const int32_t *from)
{
    ints x;
    memcpy(&x, from, sizeof x);
    return x;
}

// The first member of every rival's state.
typedef struct view {
    float row[3][4];      // world space to texels, texels, depth
    float wide_u, wide_v; // half-width of the kernel in texels per unit of depth to the blocker
    float texel;          // its width in units of depth
    int side;
    const float *depth;
    float *mean; // of front and back faces, where both are given; memory of the state
} view;

// Room for a state with the view at its front.
static inline void *view_create(size_t state_bytes, int side)
{
    view *v = calloc(1, state_bytes);
    if (!v) return NULL;
    v->side = side;
    v->mean = malloc((size_t)side * (size_t)side * sizeof *v->mean);
    if (v->mean) return v;
    free(v);
    return NULL;
}

static inline size_t view_bytes(int side)
{
    return (size_t)side * (size_t)side * sizeof(float);
}

static inline void view_destroy(view *v)
{
    free(v->mean);
    free(v);
}

static inline void view_update(view *v, const depth_map *map)
{
    const mssm_light *light = map->light;
    const float side = (float)map->side, range = 0.5f * (light->z_far - light->z_near);
    for (int i = 0; i < 3; i++) {
        const float scale = i < 2 ? 0.5f * side : 1.0f;
        for (int j = 0; j < 4; j++) v->row[i][j] = scale * light->world_to_shadow[4 * j + i];
    }
    v->row[0][3] += 0.5f * side;
    v->row[1][3] += 0.5f * side;
    v->wide_u = 0.5f * side * light->half_u / light->extent_u * range;
    v->wide_v = 0.5f * side * light->half_v / light->extent_v * range;
    v->texel = 2 * most(light->extent_u, light->extent_v) / (side * range);
    v->depth = map->front;
    if (!map->back) return;
    const size_t count = (size_t)map->side * (size_t)map->side;
    for (size_t i = 0; i < count; i++) v->mean[i] = 0.5f * (map->front[i] + map->back[i]);
    v->depth = v->mean;
}

// The nearest depth of the map, 1 if it is empty, and how much farther the farthest caster lies
// (negative if there is none).
static inline float view_range(const view *v, float *nearest)
{
    const size_t count = (size_t)v->side * (size_t)v->side;
    float farthest = -1;
    *nearest = 1;
    for (size_t i = 0; i < count; i++) {
        const float z = limited(v->depth[i], -1, 1);
        *nearest = least(*nearest, z);
        if (z < 1) farthest = most(farthest, z);
    }
    return farthest - *nearest;
}

// A receiver: texels, and depth with the bias taken off.
typedef struct place {
    float x, y, z;
} place;

// False where all is lit: nearer than the near plane, or nowhere.
static inline bool place_of(const view *v, const float point[3], float bias, place *r)
{
    float at[3];
    for (int i = 0; i < 3; i++) {
        const float *row = v->row[i];
        at[i] = row[0] * point[0] + row[1] * point[1] + row[2] * point[2] + row[3];
    }
    r->x = limited(at[0], -1e6f, 1e6f);
    r->y = limited(at[1], -1e6f, 1e6f);
    r->z = least(at[2] - bias * v->texel, 1e6f);
    return r->z > -1 && at[0] == at[0] && at[1] == at[1];
}

// Half-widths of the kernel for blockers at that depth: never less than half a texel.
typedef struct kernel {
    float u, v;
} kernel;

static inline kernel kernel_of(const view *v, const place *r, float blocker)
{
    const float distance = r->z - blocker;
    const kernel k = {limited(v->wide_u * distance, 0.5f, 1e6f),
                      limited(v->wide_v * distance, 0.5f, 1e6f)};
    return k;
}

// An interval of one axis over a map: edges of three strips, of which the middle one counts in full
// and the outer two with the shares first and last. The interval is at least a texel wide.
typedef struct strips {
    int edge[4];
    float first, last, width;
    float inside; // how much of width lies in the map
} strips;

static inline strips strips_of(float centre, float half, int side)
{
    const float low = centre - half, high = centre + half, end = (float)side;
    const float at[4] = {floorf(low), ceilf(low), floorf(high), ceilf(high)};
    strips s;
    for (int i = 0; i < 4; i++) s.edge[i] = (int)limited(at[i], 0, end);
    s.first = at[1] - low;
    s.last = high - at[2];
    s.width = high - low;
    s.inside = limited(high, 0, end) - limited(low, 0, end);
    return s;
}

// What methods.c puts into the table.
typedef void *method_create(const struct method *m, int side, size_t *bytes);
typedef void method_destroy(void *state);
typedef void method_update(void *state, const depth_map *map);
typedef float method_visibility(const void *state, const float point[3], float bias,
                                unsigned pixel);

method_create percentage_closer_create, gaussian_create;
method_destroy percentage_closer_destroy;
method_update percentage_closer_update;
method_visibility hard_visibility, pcf_visibility, pcss_sampled_visibility, pcss_visibility,
    back_projection_visibility, gaussian_visibility;

// The same for methods that take the receivers' normals.
typedef void method_many(const void *state, int count, const float (*points)[3],
                         const float (*normals)[3], float bias, float *out);
method_many pcss_plane_many, back_projection_many;

method_create variance_create, variance_soft_create, exponential_create, variance_hard_create,
    exponential_hard_create, exponential_half_create, moments_float_create;
method_destroy variance_destroy;
method_update variance_update, variance_soft_update, exponential_update, exponential_hard_update,
    exponential_half_update, moments_float_update;
method_visibility variance_visibility, variance_soft_visibility, exponential_visibility,
    exponential_hard_visibility, exponential_half_visibility, moments_float_visibility;

method_create convolution_create, convolution_mips_create;
method_destroy convolution_destroy;
method_update convolution_update;
method_visibility convolution_visibility;

#endif
