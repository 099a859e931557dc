// Shadows by the ways that moment maps are compared with: hard ones, percentage-closer soft shadows
// that read every tap, and the mean of many hard ones from all over the light, which is the truth.
#ifndef GL_REFERENCE_H
#define GL_REFERENCE_H

#include "gl_lighting.h"

#define GL_REFERENCE_TAPS 27 // of PCSS, along each side of the search and of the filter region

typedef enum gl_reference_kind {
    GL_REFERENCE_HARD,
    GL_REFERENCE_PCSS,
    GL_REFERENCE_TRUTH
} gl_reference_kind;

typedef struct gl_reference {
    float bias; // in texels; the next draw takes it. gl_reference_create() sets a good one
    int frame;  // turns what shaders make random; the same
    GLuint depth, framebuffer, lights, program[2]; // plain depth maps, one layer a light
    int side, room, slot; // the part of the buffer that the last draw filled
} gl_reference;

// GLSL: the depth maps as a sampler2DArray depth_maps at unit 4, 1 beside them; at buffer binding 1
// what a light is, reference[light].kernel.xy being the half-width of its penumbra in texture
// coordinates per unit of depth, .z the bias of depth, .w the frame; vec3 shadow_place(int light,
// vec3 position): texture coordinates, and depth in [-1,1].
extern const char gl_reference_text[];
void gl_reference_bind(const gl_reference *r); // both of them
// The text behind the shading programs, to be compiled into others.
enum { GL_REFERENCE_TEXT = 4096 };
void gl_reference_visibility(gl_reference_kind kind, char *text, size_t room);

bool gl_reference_create(gl_reference *r, int side, int lights, message *why);
void gl_reference_free(gl_reference *r);

// Depth maps of g->ordered. GL_REFERENCE_TRUTH draws them from another point of each light for
// every index: shade them as hard shadows and add the pictures up.
void gl_reference_draw(gl_reference *r, const gl_lighting *g, int lights, const scene *s,
                       gl_reference_kind kind, int index);
void gl_reference_shade(gl_reference *r, gl_lighting *g, const lighting *l, const camera *eye,
                        gl_reference_kind kind, bool add);

#endif
