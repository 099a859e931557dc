// What the demo prints about its work.
#ifndef REPORT_H
#define REPORT_H

#include "lighting.h"

// How many lights, why that many and how good; how many maps of which size, and their times.
void report_lights(const lighting *l);
void report_maps(const lighting *l, int triangles);

// The root of the mean square difference over the pixels that show the scene, as a share of the
// mean of b.
double report_difference(const image *a, const image *b, const view *v);

// "build/demo.png" with "-012" or "-truth" before its ending.
void report_name(char *name, size_t room, const char *out, const char *insert);
void report_frame_name(char *name, size_t room, const char *out, int frame);

#endif
