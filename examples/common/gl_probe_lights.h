// The lights of a probe, found on the GPU, with a shadow map each: what gl_deferred.c spells out,
// for the examples that are about what is done with them.
#ifndef GL_PROBE_LIGHTS_H
#define GL_PROBE_LIGHTS_H

#include "../../lightprobe.h"
#include "../../mssm.h"
#include "gl_draw.h"

#define GL_PROBE_LIGHTS 64

typedef struct gl_probe_lights {
    lightprobe_gl *probe;
    mssm_gl *shadows;
    GLuint depth;
    lightprobe_light light[GL_PROBE_LIGHTS];
    int count; // of lights that have maps
} gl_probe_lights;

// For a probe of that side, with distances in its alpha or without; at most that many lights. On
// failure what was made is kept for gl_probe_lights_free.
bool gl_probe_lights_create(gl_probe_lights *p, int side, int lights, bool distances, message *why);
void gl_probe_lights_free(gl_probe_lights *p);

// Finds the lights of a cube map that was taken at a place, and draws their maps of casters within
// a box. Waits for the lights, so that all is of this frame.
bool gl_probe_lights_update(gl_probe_lights *p, GLuint cube, vec3 place, vec3 low, vec3 high,
                            const gl_mesh *casters, message *why);

// For shading behind the texts of both headers: lights at shader storage binding 0, shadows at 1.
void gl_probe_lights_bind(const gl_probe_lights *p);

#endif
