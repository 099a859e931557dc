// Two published ways from a probe to a few lights, as rivals of lightprobe.h: greedy rectangles
// (Annen et al. 2008, section 4.2) and variance minimization (Viriyothai and Debevec 2009). Both
// look at the faces of the cube one by one; solid angles are exact.
#ifndef LIGHT_CUTS_H
#define LIGHT_CUTS_H

#include "../../lightprobe.h"

enum { LIGHT_CUTS_MOST = 256 };

typedef struct light_cut {
    int face, x0, y0, x1, y1; // texels x0 <= x < x1, y0 <= y < y1
} light_cut;

// At most `most` lights (up to LIGHT_CUTS_MOST), the brightest where there are more, with the
// rectangle that each was made from; direction, axes, tangents, irradiance and solid angle are
// filled in, and cos_alpha is 1: both papers shade by the cosine to one direction. Returns how
// many; 0 without memory and for a black probe.

// Rectangles grow from the brightest texel as long as a side adds more than this share of their
// energy. They may overlap; a texel's energy is divided among those that cover it.
int light_cuts_greedy(const lightprobe_cube *cube, float threshold, int most,
                      lightprobe_light *lights, light_cut *cuts);
// The threshold that gives as many lights as possible without exceeding `most`.
float light_cuts_threshold(const lightprobe_cube *cube, int most);

// Regions are cut where the variance of direction, weighted by luminance and summed over both
// parts, is least, that of largest variance first. Lights are points at the centroids; each texel
// is in one region.
int light_cuts_variance(const lightprobe_cube *cube, int most, lightprobe_light *lights,
                        light_cut *cuts);

#endif
