// Depth ranges that fit what is drawn into shadow maps: a compute pass finds the least and the
// greatest depth of each map, the CPU reads them when the next frame begins and fits the frusta to
// them.
#ifndef GL_RANGE_H
#define GL_RANGE_H

#include "../../mssm.h"
#include "gl_draw.h"

// Of the range, left free on both sides for casters that move.
#define GL_RANGE_MARGIN 0.1f

typedef struct gl_range {
    GLuint program, buffer; // per light and row of its map: least and greatest window depth
    float (*rows)[2];       // of one light
    mssm_light *drawn;      // the frusta of the last frame
    int side;
} gl_range;

// For maps of that side. On failure what was made is kept for gl_range_free.
bool gl_range_create(gl_range *r, int lights, int side, message *why);
void gl_range_free(gl_range *r);

// The light to draw this frame's map with; needs last frame's gl_range_reduce. Casters may move by
// a tenth of the range a frame. Where one has used up more than half of that, or nothing was drawn,
// it is the whole frustum for a frame. whole is the light as set up; it should not turn by much at
// once.
mssm_light gl_range_fit(gl_range *r, int index, const mssm_light *whole);
// Between mssm_gl_begin_depth and mssm_gl_end_depth of maps, after the casters. Leaves a program
// bound, and what is at texture unit 0 and shader storage binding 0.
void gl_range_reduce(gl_range *r, int index, const mssm_gl *maps);

#endif
