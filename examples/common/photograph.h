// A photograph of an empty place, for objects to be put into: paving in the light of a probe, which
// is also what lies around it. The objects, the ground that catches their shadows, and what a
// camera would have seen.
#ifndef PHOTOGRAPH_H
#define PHOTOGRAPH_H

#include "probe.h"
#include "raster.h"

// The objects, and, as the last object, the ground: a square in y = 0. False when memory runs out.
bool photograph_scene(scene *s, bool objects, bool ground);

camera photograph_camera(float aspect); // where it is taken from

// The place without objects. False when memory runs out.
bool photograph_take(const probe *p, const camera *eye, int width, int height, image *out);

// The truth by rays: the photograph times the share of light that is left on the ground, and the
// objects. False when memory runs out.
bool photograph_truth(const probe *p, const camera *eye, const image *empty, int rays, image *out);

#endif
