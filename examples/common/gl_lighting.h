// The way of lighting.h through OpenGL: depth maps, moments and tables of all lights, a
// multisampled G-buffer, and a pass that shades it by every light. The lights themselves come from
// a `lighting`. Pictures agree with lighting_render() to less than one step of 8 bits.
#ifndef GL_LIGHTING_H
#define GL_LIGHTING_H

#include "gl_draw.h"
#include "gl_timer.h"
#include "lighting.h"

// Lights with sharp shadows get larger maps (lighting_map_side), so there are two sets of maps.
#define GL_LIGHTING_SETS 2

typedef struct gl_shadow_set {
    mssm_gl *maps;
    int side, lights, room;
    int *light; // their numbers in `lighting`
} gl_shadow_set;

typedef struct gl_lighting {
    gl_shadow_set set[GL_LIGHTING_SETS];
    gl_mesh casters, triangle;
    gl_target view, picture;
    GLuint depth_program, view_program, program;
    GLuint lights, probe;      // buffer of lightprobe_light, cube map
    lightprobe_light *ordered; // the lights as in the buffer, set by set
    float size;                // of the lights as the shadows see them, 1 for what they are
    gl_timer timer;
} gl_lighting;

// For as many lights and the shadow settings as l was made with; load must be the loader that
// filled gl. On failure nothing is kept.
bool gl_lighting_create(gl_lighting *g, const lighting *l, mssm_gl_loader load, int width,
                        int height, message *why);
void gl_lighting_free(gl_lighting *g);
bool gl_lighting_resize(gl_lighting *g, int width, int height, message *why);

// Steps of a frame, in this order, after lighting_extract() and gl_probe_upload(&g->probe, ...).
bool gl_lighting_draw_maps(gl_lighting *g, const lighting *l, const scene *s, message *why);
void gl_lighting_draw_view(gl_lighting *g, const scene *s, const camera *eye);
// Into the target that is bound; program 0: g->program.
void gl_lighting_shade(gl_lighting *g, GLuint program, const lighting *l, const camera *eye);

// Seconds of a step of the last frame. Waits until it is done; gl_timer_latest(&g->timer, step)
// does not.
enum { GL_LIGHTING_DEPTH = 1, GL_LIGHTING_TABLES, GL_LIGHTING_VIEW, GL_LIGHTING_SHADING };
double gl_lighting_seconds(const gl_lighting *g, int step);

// The shading pass behind another text that declares float mssm_visibility(int light, vec3
// position), with normals also (..., vec3 normal), and one run of it over some of the lights in
// g->ordered.
GLuint gl_lighting_program(const char *name, const char *visibility, bool normals, message *why);
enum { GL_LIGHTING_BASE = 1, GL_LIGHTING_ADD = 2 }; // with ambient and background; onto the picture
void gl_lighting_pass(gl_lighting *g, GLuint program, const lighting *l, const camera *eye,
                      int first, int count, unsigned flags);

#endif
