// mssm.h without its OpenGL 4.5 half: maps that the CPU made, as textures for shading in OpenGL
// 3.3, OpenGL ES 3.0 and WebGL 2. What a renderer of its own needs of this is in
// docs/integration.md, 9.
#ifndef GL33_SHADOWS_H
#define GL33_SHADOWS_H

#include "../../mssm.h"
#include "gl33.h"

#define GL33_LIGHTS 16 // at most

typedef struct gl33_shadows {
    int lights;
    GLuint texture[3], uniforms;
    int view[GL33_LIGHTS][28]; // 0: no such light, all is lit
    void *texels;              // of one level
    size_t bytes;
} gl33_shadows;

// A program of the scene's vertex shader and a fragment shader that has mssm_visibility(), at units
// 0 to 2 and uniform buffer binding 0. before: texts that come before the shadows', up to a NULL;
// or NULL. 0 on failure.
GLuint gl33_shadows_program(const char *version, int lights, const char *const *before,
                            const char *fragment, message *why);

// The map of a light whenever it or its casters have moved. The first makes the textures: all have
// its side and moments.
bool gl33_shadows_upload(gl33_shadows *s, int light, const mssm_map *map, const mssm_light *frustum,
                         message *why);
void gl33_shadows_bind(const gl33_shadows *s);
void gl33_shadows_free(gl33_shadows *s);

#endif
