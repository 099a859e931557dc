// Percentage-closer soft shadows (Fernando 2005) in OpenGL as they are written for GPUs, over the
// depth maps of gl_reference.h, which has 27 x 27 taps one by one; shades through the path of
// gl_lighting.h.
#ifndef GL_PERCENTAGE_CLOSER_H
#define GL_PERCENTAGE_CLOSER_H

#include "../../examples/common/gl_reference.h"

// How the search and the filter read the map.
typedef enum gl_percentage_closer_kind {
    GL_PERCENTAGE_CLOSER_TAPS, // 27 x 27 taps, evenly over the kernel
    GL_PERCENTAGE_CLOSER_GATHER, // every texel by its share, four a textureGather; kernels of more than 27
                                 // texels by cells, each by one texel
    GL_PERCENTAGE_CLOSER_16, // Poisson samples, turned for every pixel, light and frame
    GL_PERCENTAGE_CLOSER_32,
    GL_PERCENTAGE_CLOSER_GATHER_NORMAL, // from here on with a bias that follows the receiver's plane
    GL_PERCENTAGE_CLOSER_16_NORMAL,
    GL_PERCENTAGE_CLOSER_32_NORMAL
} gl_percentage_closer_kind;

// The text with mssm_visibility(). It takes PIXEL for the pixel's place, gl_FragCoord.xy if that is
// not defined.
enum { GL_PERCENTAGE_CLOSER_TEXT = 8192 };
void gl_percentage_closer_visibility(gl_percentage_closer_kind kind, char *text, size_t room);
// Whether mssm_visibility() wants the receiver's normal too.
bool gl_percentage_closer_normal(gl_percentage_closer_kind kind);

#endif
