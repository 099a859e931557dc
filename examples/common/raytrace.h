// The truth: visibility and illumination by tracing rays, slow and without tricks.
#ifndef RAYTRACE_H
#define RAYTRACE_H

#include "probe.h"
#include "raster.h"

typedef struct bvh bvh; // a tree of boxes over the scene's triangles

bvh *bvh_create(const scene *s); // NULL when memory runs out; the scene is not needed afterwards
void bvh_free(bvh *tree);

// Whether anything lies on the ray between 0 and the distance, in units of the direction's length.
bool bvh_hit_any(const bvh *tree, vec3 origin, vec3 direction, float distance);
// How far the nearest hit is; HUGE_VALF without one.
float bvh_hit_nearest(const bvh *tree, vec3 origin, vec3 direction);

// Share of a far rectangular light that a point sees: grid x grid rays through a light with the
// given half-sizes at distance 1. The seed shifts the grid. With a normal (else NULL):
// of the irradiance that the light's part above the horizon would send, the share that arrives; the
// light is equally bright everywhere; 0 if no part is above.
float trace_rectangle(const bvh *tree, vec3 point, const vec3 *normal, vec3 direction, vec3 axis_u,
                      vec3 axis_v, float tan_half_u, float tan_half_v, int grid, unsigned seed);

// Directions drawn from a probe in proportion to the light that comes from them.
typedef struct probe_sampler {
    const probe *source;
    double *cumulative; // per texel, in shares of all luminance; from malloc
} probe_sampler;

bool probe_sampler_create(probe_sampler *sampler, const probe *p);
void probe_sampler_free(probe_sampler *sampler);

// Irradiance of a point from the probe, shadowed by the scene, by that many rays; the seed shifts
// them.
vec3 trace_irradiance(const bvh *tree, const probe_sampler *sampler, vec3 point, vec3 normal,
                      int rays, unsigned seed);

// A picture of the scene under a far light without size in that direction, 16 samples a pixel:
// albedo times what light() says of a normal, and of whether the light is seen. False when memory
// runs out.
typedef float trace_light(vec3 normal, bool seen);
bool trace_picture(const scene *s, const camera *eye, vec3 direction, trace_light *light, int width,
                   int height, image *out);

#endif
