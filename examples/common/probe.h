// Light probes: a cube map of linear radiance, from a file or made up.
//
// Faces in OpenGL's order and orientation: +X -X +Y -Y +Z -Z; the texel in column x and row y, with
// s = -1 + (2x+1)/side and t = -1 + (2y+1)/side, looks along
//   +X (1,-t,-s)  -X (-1,-t,s)  +Y (s,1,t)  -Y (s,-1,-t)  +Z (s,-t,1)  -Z (-s,-t,-1).
// +Y is up. The middle column of a lat-long picture looks along -Z, a quarter to its right is +X.
#ifndef PROBE_H
#define PROBE_H

#include "image.h"

typedef struct probe {
    int side;
    float *texels;        // [((face * side + y) * side + x) * 3 + channel]; from malloc
    const float *face[6]; // the six faces in texels, for lightprobe_cube
    int broken;           // pixels of the picture with a negative, NaN or infinite channel
} probe;

#define PROBE_DEFAULT_SIDE 128

bool probe_create(probe *p, int side); // black
void probe_free(probe *p);

// A lat-long picture (2:1), which becomes a cube of the given side, 0 for one that suits its size;
// or a cross (4:3, 3:4) or strip (6:1, 1:6) of faces, which are taken as they stand. Layouts, and
// what becomes of broken pixels, are those of lightprobe_cube_from_image.
bool probe_load(probe *p, const char *path, int side, message *why);
bool probe_from_image(probe *p, const image *im, int side, message *why);
// The cube as a strip of six faces, which probe_from_image takes back.
bool probe_to_image(const probe *p, image *im);

// The built-in probe: evening sky, low sun, a soft box. The same on every machine.
bool probe_default(probe *p, int side);

// Turns the probe by an angle about +Y (counter-clockwise seen from above) into out, which has been
// created with any side. Texels are split where they come to overlap several, so that energy is
// kept and steps far below a texel still show.
bool probe_rotate(probe *out, const probe *in, float angle);

// Not normalized; face 0..5, s and t in [-1,1].
vec3 probe_direction(int face, float s, float t);
// The inverse of probe_direction; returns the face.
int probe_locate(vec3 direction, float *s, float *t);
// Radiance along a direction, interpolated between texels, also across the edges of faces.
vec3 probe_sample(const probe *p, vec3 direction);

// Irradiance of surfaces with these unit normals, nothing standing in between: sums over all
// texels, of which those with a negative, NaN or infinite channel count as 0 there.
void probe_irradiance(const probe *p, const vec3 *normal, int normals, vec3 *irradiance);
// The same for the normals of all texels of a new probe: an irradiance map. False when memory runs
// out.
bool probe_irradiance_map(const probe *p, int side, probe *map);

#endif
