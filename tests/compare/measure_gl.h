// Times of soft shadow methods in OpenGL, side by side in one run: the shading pass, the update of
// what it reads, and whole frames.
#ifndef MEASURE_GL_H
#define MEASURE_GL_H

#include "../../examples/common/file.h"
#include "figures.h"

// Experiments gl and gl_kernel. Without an OpenGL context nothing is added, and stderr says why.
void measure_gl(figures *f, bool quick);

enum { MEASURE_GL_METHODS = 23, MEASURE_GL_ROUNDS = 9 };

// One run of some of the methods: milliseconds of every round, which go round in turns.
typedef struct gl_times {
    int count; // of rounds
    double shade[MEASURE_GL_ROUNDS], update[MEASURE_GL_ROUNDS], frame[MEASURE_GL_ROUNDS];
} gl_times;

// times[i] belongs to names[i]; the height is 9/16 of the width.
bool measure_gl_times(int lights, int width, int rounds, const char *const *names, int count,
                      gl_times *times, message *why);
double measure_gl_median(const double *values, int count);

#endif
