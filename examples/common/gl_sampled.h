// The true shadow of an area light, sample by sample: hard shadows from points all over it, added
// up over as many frames as it takes, and begun anew whenever anything has changed.
#ifndef GL_SAMPLED_H
#define GL_SAMPLED_H

#include "../../mssm.h"
#include "gl_draw.h"

#define GL_SAMPLED_POINTS 1024 // no picture of 8 bits needs more

// The frustum of one point of the light, x and y in [-1,1] over it; whatever kind of light that is.
typedef mssm_light gl_sampled_frustum(const void *light, float x, float y);

typedef struct gl_sampled {
    gl_target map, sum; // depth of the point in hand; shadows so far, as many as sum.w says
    gl_mesh triangle;
    GLuint depth_program, add_program;
    float point[GL_SAMPLED_POINTS][2];
    unsigned long long state; // of all that the sum depends on
    int samples;              // in the sum
} gl_sampled;

// On failure what was made is kept for gl_sampled_free.
bool gl_sampled_create(gl_sampled *s, int map_side, int width, int height, message *why);
void gl_sampled_free(gl_sampled *s);

// A number for all that the sum depends on: start with 0, then go on with camera, light, scene's
// time.
unsigned long long gl_sampled_hash(unsigned long long hash, const void *bytes, size_t count);

// Adds up to that many points to the sum (GL_SAMPLED_POINTS are the end of it), for the surfaces of
// a G-buffer of that size: position, w = 0 where there is none, and normal. normal_offset, in world
// units, keeps surfaces from shading themselves. Begins anew when state is not that of the last
// call. The mean visibility is sum.color[0].x / .w. The first point is the light's middle: a hard
// shadow. Leaves its framebuffer, viewport, program, a vertex array and texture units 0 to 2 bound,
// the clear color zero, depth test and blending off and the blend function (one, one).
void gl_sampled_add(gl_sampled *s, unsigned long long state, int points,
                    gl_sampled_frustum *frustum, const void *light, const gl_mesh *casters,
                    const GLuint surfaces[2], float normal_offset);

#endif
