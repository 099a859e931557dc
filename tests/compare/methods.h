// Soft shadow methods behind one interface, over the same depth maps: the library's own and its
// rivals, each from its paper. What a method cannot do (perspective lights, several samples a
// texel) it is not asked for: maps here have one sample a texel and lights at infinity.
#ifndef METHODS_H
#define METHODS_H

#include <stddef.h>

#include "../../mssm.h"
#include "figures.h"

typedef struct depth_map {
    const mssm_light *light;
    int side;
    const float *front, *back; // as in mssm_map_update; back is NULL for open meshes
} depth_map;

typedef struct method {
    const char *name;   // of legends and the CSV file, e.g. "PCSS, all texels"
    const char *family; // decides the colour: "MSSM", "layered", "PCSS", "VSM", ...
    const char *source; // author, year, title
    int constant_time;  // the cost of a receiver does not depend on the kernel's width
    int variant;        // for methods that share functions: samples, terms, moments...
    // Room for maps of that side; NULL when memory runs out. bytes is what has to stay in memory
    // for shading, depth map included where the method still reads it.
    void *(*create)(const struct method *m, int side, size_t *bytes);
    void (*destroy)(void *state);
    // What a frame has to do when the depth map is new. The map stays valid while points are asked
    // for.
    void (*update)(void *state, const depth_map *map);
    // Visibility in [0,1] of a world-space point; bias in texels of level 0, for methods that need
    // one (the library's own take their default); pixel seeds whatever is random.
    float (*visibility)(const void *state, const float point[3], float bias, unsigned pixel);
    float bias; // that suits the method best over scenes and lights; measured, in texels
    // NULL, or many points at once, for methods that have a faster way for that or use the normals.
    void (*many)(const void *state, int count, const float (*points)[3], const float (*normals)[3],
                 float bias, float *out);
} method;

extern const method methods[];
extern const int method_count;

// Hard shadows under a Gaussian of the map, for lights without size; the variant of a copy is set
// to its radius before create.
extern const method hard_methods[];
extern const int hard_method_count;

const method *method_named(const char *name); // of either; NULL if there is none

// What Annen's paper leaves to the reader of convolution soft shadows. The methods have what suits
// the chart best; for other pictures, tune what create made, ahead of update.
typedef struct convolution_tuning {
    float period;  // share of half a period that the depths of the map take up
    float gap;     // how far behind the farthest caster empty texels lie, in depths of the map
    float offset;  // of the receiver towards the light, in depths of the map
    float scale;   // of the series around 1/2, so that it rings outside of [0,1]
    float shift;   // of the series, towards light
    float damping; // of the terms, exp(-damping (k / terms)^2)
    float a, b;    // of the sharpening exponent, Eq. 9
    float finer;   // levels of mip maps below the one whose texels are as wide as the kernel
} convolution_tuning;
void convolution_tune(void *state, const convolution_tuning *to);

// The Gaussian all of them share: weights of 2 * radius + 1 texels, standard deviation radius / 2,
// sum 1. It is read bilinearly, so that its taps are joined by straight lines.
enum { RADIUS_MOST = 32, TAPS_MOST = 2 * RADIUS_MOST + 1 };
void gaussian(int radius, float weight[TAPS_MOST]);

// Samples of percentage-closer soft shadows: the square ring that each lies on (0 to 1) and where
// on its perimeter (0 to 8), so that rotating is adding.
enum { SAMPLES_MAX = 64 };
typedef struct ring_sample {
    float ring, at;
} ring_sample;
void poisson_pattern(int samples, ring_sample *to);

#endif
