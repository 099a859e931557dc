// A plume of smoke made of soft round puffs, always the same: drawn as billboards from far to near,
// for a camera or into a shadow map, and the truth about the same puffs by rays.
#ifndef GL_SMOKE_PLUME_H
#define GL_SMOKE_PLUME_H

#include "gl_draw.h"
#include "raytrace.h"

#define GL_SMOKE_PUFFS 600
#define GL_SMOKE_GROUP 8 // puffs that lie together, within one sphere

// A ray that passes the centre at a distance d loses opacity (1 - (d / radius)^2)^2 of its light,
// all at once where it comes nearest to the centre.
typedef struct gl_smoke_puff {
    vec3 centre;
    float radius, opacity;
} gl_smoke_puff;

typedef struct gl_smoke_plume {
    gl_smoke_puff puff[GL_SMOKE_PUFFS], group[GL_SMOKE_PUFFS / GL_SMOKE_GROUP];
    vec3 low, high; // bounds
    GLuint buffer;  // the puffs as they were drawn last
    gl_mesh quads;
} gl_smoke_plume;

void gl_smoke_create(gl_smoke_plume *p, vec3 foot, float height);
void gl_smoke_free(gl_smoke_plume *p);

// What examples/gl_smoke.c shows, out of zeroed parts: a fence and a ball, which cast shadow; these
// with floor and wall, which only receive it; the plume between them; the box of all casters.
bool gl_smoke_scene(scene *s, gl_mesh *casters, gl_mesh *receivers, gl_smoke_plume *p, float low[3],
                    float high[3], message *why);

// Vertex shader with out vec3 position; out vec2 place, from -1 to 1 over the puff; flat out float
// puff_opacity. It reads shader storage binding 0, which gl_smoke_draw binds. The other is for the
// fragment shader behind it: float opacity().
extern const char gl_smoke_vertex[], gl_smoke_opacity[];

// From far to near as seen from a place (eye_w = 1) or from a direction (eye_w = 0), blended by
// source alpha; program has gl_smoke_vertex. Leaves blending off and depth writes on.
void gl_smoke_draw(gl_smoke_plume *p, GLuint program, const float world_to_clip[16], vec3 eye,
                   float eye_w);

// The share of light that comes through along a ray of unit direction.
float gl_smoke_transmittance(const gl_smoke_plume *p, vec3 origin, vec3 direction);

// GLSL: float surface(float light, float up) and float scattered(float light), the radiance of
// white surfaces (up: y of the normal) and of smoke by the sunlight that arrives at them.
extern const char gl_smoke_shading[];

// A square sun.
typedef struct gl_smoke_sun {
    float direction[3], axis[3]; // towards it, unit; two of its sides run across the axis
    float half;                  // tangent of its half-angle; 0: hard shadows
} gl_smoke_sun;

// The truth: a picture of that size, 4 x 4 samples a pixel, with rays to all of the sun.
bool gl_smoke_trace(const gl_smoke_plume *p, const scene *s, const camera *eye,
                    const gl_smoke_sun *sun, int width, int height, image *out, message *why);

#endif
