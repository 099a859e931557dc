// A scene under the lights of a probe, seen by one camera and shadowed by any method, light by
// light.
#ifndef STUDIO_H
#define STUDIO_H

#include "../../examples/common/lighting.h"
#include "../compare/methods.h"

typedef struct piece {
    vec3 position, normal, albedo;
    float share; // of the pixel
} piece;

typedef struct studio {
    scene scene;
    camera eye;
    probe probe;
    view view;
    bvh *tree;
    probe_sampler sampler;
    piece (*pieces)[VIEW_SAMPLES]; // of each pixel
    int *count;
    float exposure;           // that suits the truth
    image truth;              // rays to the probe
    double noise, edge_noise; // of the truth, as studio_error() and studio_edges() count
} studio;

// The default scene at a time, under the built-in probe turned by an angle; see camera_look().
typedef struct shot {
    float time, turn;
    vec3 from, to;
    float vertical_angle;
} shot;

// For pictures so many pixels wide, of 16:9; the truth from so many rays a pixel.
bool studio_open(studio *s, const shot *of, int width, int rays, message *why);
void studio_close(studio *s);

typedef struct studio_lights {
    lighting l;
    bool paper; // median cut, shaded by Eq. 18
} studio_lights;

bool studio_extract(const studio *s, studio_lights *lights, int count, bool paper, message *why);

// How the lights are shadowed.
typedef struct shadowing {
    const method *method; // of maps with one sample a texel; NULL: by rays, or by the library
    float bias;           // of that, in texels of the side that lighting_map_side() has
    // Of convolution soft shadows, whose maps are then of twice the side, in place of the 4 samples
    // that the papers' filterable maps have; NULL: any other method.
    const convolution_tuning *tuning;
    const mssm_settings *own; // this library's, of four samples a texel as in the paper; or NULL
    bool back_faces;          // depth maps are means of front and back
    int grid; // grid x grid rays to a light; 0: one ray to its middle, all light from there
} shadowing;

bool studio_shade(const studio *s, const studio_lights *lights, const shadowing *how, image *out,
                  message *why);

// Over the pixels that show the scene: rms of the difference in % of the mean of the truth; the
// same of the steps between neighbours that the truth does not have, which hard edges make (both
// less the noise of the studio's truth, where it is that); what share of the light there is; and
// how much too bright it is where it is too bright, in % of the mean: what weak shadows let through.
double studio_error(const studio *s, const image *a, const image *truth);
double studio_edges(const studio *s, const image *a, const image *truth);
double studio_brightness(const studio *s, const image *a, const image *truth);
double studio_leak(const studio *s, const image *a, const image *truth);

#endif
