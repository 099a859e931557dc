// Light shafts in OpenGL: single scattering of a directional light from its filtered moment map,
// one lookup a pixel, as a pass over a picture whose positions are in a texture. shafts.h does the
// same on the CPU.
#ifndef GL_SHAFTS_H
#define GL_SHAFTS_H

#include "../../mssm.h"
#include "gl_draw.h"

#define GL_SHAFTS_TEXTURE 8 // units of the two textures, and of positions after them
#define GL_SHAFTS_BINDING 8 // of the shader storage buffer

typedef struct gl_shafts {
    GLuint fill, view, texture[2]; // RGBA16 and RG16: encoded, means of all columns up to each
    int rows, columns;
} gl_shafts;

// columns: a multiple of 64. On failure nothing is kept.
bool gl_shafts_create(gl_shafts *s, int rows, int columns, message *why);
void gl_shafts_free(gl_shafts *s);

// Resamples layer 0 of a filtered map (mssm_gl_texture(gl, 0)) and adds up the rows, in one
// dispatch; leaves the map, the textures, also as images 0 and 1, the buffer and a program bound.
void gl_shafts_update(gl_shafts *s, const mssm_scattering *from, GLuint map);

// A pass over the picture from GLSL that declares float shafts_visibility(vec3 direction, float
// distance); NULL: from the textures. It may read vec3 eye, and medium.x, the extinction. 0 on
// failure.
GLuint gl_shafts_program(const char *name, const char *visibility, message *why);

// Such text, for comparison: marches along the ray by uniform int steps through the depth map (a
// texture without comparison at unit GL_SHAFTS_TEXTURE) of uniform mat4 world_to_shadow.
extern const char gl_shafts_marched[];

// Draws it onto the framebuffer that is bound: fades what is there by the medium, and adds
// scattered times the share of light that the medium scatters to the camera. positions: w = 0 where
// there is no surface and the medium ends at far_end. Leaves the program and positions bound, no
// vertex array, blending off and its function (one, source alpha).
void gl_shafts_draw(GLuint program, GLuint positions, const camera *eye, float extinction,
                    float far_end, vec3 scattered);

#endif
