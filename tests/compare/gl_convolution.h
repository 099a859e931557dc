// Convolution soft shadows (Annen and others, Real-Time, All-Frequency Shadows in Dynamic Scenes,
// 2008) in OpenGL, as a rival of moment maps: basis images of the depth maps, filtered ahead of
// time, average blocker depth and visibility from them. Shades through the path of gl_lighting.h.
//
// A term is a cosine and a sine, each filtered alone and times the depth: M terms are 4M + 1 values
// a texel. Annen's pictures use M of 4 to 16. Kneiphof counts the values of a filter: CSSM8 is M =
// 4 (17 values), CSSM16 is M = 8 (33 values).
#ifndef GL_CONVOLUTION_H
#define GL_CONVOLUTION_H

#include "../../examples/common/gl_reference.h"

enum { GL_CONVOLUTION_TERMS_MOST = 16 };

// The paper offers both ways of filtering: summed-area tables are exact, mip maps small and quick.
typedef enum gl_convolution_filter {
    GL_CONVOLUTION_TABLES,
    GL_CONVOLUTION_MIPS
} gl_convolution_filter;

typedef struct gl_convolution {
    gl_convolution_filter filter;
    int side, room, terms;
    GLuint basis, weighted, mean; // B_i(z) and z B_i(z), four values a layer; z
    GLuint update[2], program;
} gl_convolution;

// What the paper leaves to its reader.
typedef struct gl_convolution_tuning {
    float margin;  // of the series' half period at both ends, where it bends back
    float offset;  // of the receiver towards the light, in depths of the map
    float scale;   // of the series around 1/2, so that it rings outside of [0,1]
    float shift;   // of the series, towards light
    float damping; // of the terms, exp(-damping (k / terms)^2)
    float a, b;    // of the sharpening exponent, Eq. 9
    float finer;   // mip levels below the one whose texels are as wide as the kernel
} gl_convolution_tuning;
// The one that was found best, for 4, 8 or 16 terms.
gl_convolution_tuning gl_convolution_best(gl_convolution_filter filter, int terms);

// For maps of that side, a multiple of 64; an even number of terms. Tuning NULL: the best.
bool gl_convolution_create(gl_convolution *c, gl_convolution_filter filter, int terms,
                           const gl_convolution_tuning *tuning, int side, int lights, message *why);
void gl_convolution_free(gl_convolution *c);

// Basis images and their tables (or mip maps) of the depth maps that gl_reference_draw() has drawn.
void gl_convolution_update(gl_convolution *c, const gl_reference *r, int lights);
// What c->program reads besides gl_reference_bind().
void gl_convolution_bind(const gl_convolution *c);

// The text behind the shading program, to be compiled into others.
enum { GL_CONVOLUTION_TEXT = 12288 };
void gl_convolution_visibility(gl_convolution_filter filter, int terms,
                               const gl_convolution_tuning *tuning, char *text, size_t room);

#endif
