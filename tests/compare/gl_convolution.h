// Convolution soft shadows (Annen and others, Real-Time, All-Frequency Shadows in Dynamic Scenes, 2008)
// with 16 terms in OpenGL, as a rival of moment maps: basis images of the depth maps, filtered ahead of
// time, average blocker depth and visibility from them. Shades through the path of gl_lighting.h.
#ifndef GL_CONVOLUTION_H
#define GL_CONVOLUTION_H

#include "../../examples/common/gl_reference.h"

#define GL_CONVOLUTION_TERMS 16

// The paper offers both ways of filtering: summed-area tables are exact, mip maps small and quick.
typedef enum gl_convolution_filter {
    GL_CONVOLUTION_TABLES,
    GL_CONVOLUTION_MIPS
} gl_convolution_filter;

typedef struct gl_convolution {
    gl_convolution_filter filter;
    int side, room;
    GLuint basis, weighted, mean; // B_i(z) and z B_i(z), four values a layer; z
    GLuint update[2], program;
} gl_convolution;

// For maps of that side, a multiple of 64.
bool gl_convolution_create(gl_convolution *c, gl_convolution_filter filter, int side, int lights,
                           message *why);
void gl_convolution_free(gl_convolution *c);

// Basis images and their tables (or mip maps) of the depth maps that gl_reference_draw() has drawn.
void gl_convolution_update(gl_convolution *c, const gl_reference *r, int lights);
// What c->program reads besides gl_reference_bind().
void gl_convolution_bind(const gl_convolution *c);

// The text behind the shading program, to be compiled into others.
enum { GL_CONVOLUTION_TEXT = 12288 };
void gl_convolution_visibility(gl_convolution_filter filter, char *text, size_t room);

#endif
