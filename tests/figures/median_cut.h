// Lights of a probe in the image-based lighting paper's own way (sections 3.1, 4.1 and 5):
// summed-area tables of XYZ and of the moments of Y, cuts by luminance, lights from tables; on the
// CPU, and in OpenGL by compute shaders with one group of 256 threads for the cuts and a bitonic
// sorter. With the mended formulas of docs/errata.md. A rival of lightprobe.h, in three steps that
// can be timed.
#ifndef MEDIAN_CUT_H
#define MEDIAN_CUT_H

#include "../../examples/common/gl.h"
#include "../compare/light_cuts.h"
#include "../../examples/common/file.h"

enum { MEDIAN_CUT_MOST = 256, MEDIAN_CUT_SUMS = 8 };

typedef struct median_cut {
    int side;
    float *table; // [((face * side + y) * side + x) * 8]: X Y Z - Yu Yv Yuu Yvv, Eq. 1
} median_cut;

bool median_cut_create(median_cut *m, int side);
void median_cut_free(median_cut *m);
void median_cut_sums(median_cut *m, const lightprobe_cube *cube); // of three channels
int median_cut_cuts(const median_cut *m, int most, light_cut *cuts);
// All but solid_angle and id.
void median_cut_lights(const median_cut *m, const light_cut *cuts, int count,
                       lightprobe_light *lights);

typedef struct gl_median_cut {
    int side;
    GLuint probe, table[2], regions, lights; // textures of six layers; buffers
    GLuint rows, columns, cuts, resolve;     // programs
} gl_median_cut;

// For lights from 6 on.
bool gl_median_cut_create(gl_median_cut *m, const lightprobe_cube *cube, message *why);
void gl_median_cut_free(gl_median_cut *m);
// The three steps; they do not wait.
void gl_median_cut_sums(const gl_median_cut *m);
void gl_median_cut_cuts(const gl_median_cut *m, int most);
void gl_median_cut_lights(const gl_median_cut *m, int most);
int gl_median_cut_read(const gl_median_cut *m, lightprobe_light lights[MEDIAN_CUT_MOST]);

#endif
