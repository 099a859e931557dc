// What a program that draws with OpenGL needs around the two headers: meshes, programs, targets to
// draw into, pictures back from them, and how long it took. Everything belongs to the current
// context.
#ifndef GL_DRAW_H
#define GL_DRAW_H

#include "gl.h"
#include "image.h"
#include "raster.h"

// ---- Meshes

typedef struct gl_mesh {
    GLuint array, vertices, indices;
    int count;       // of vertices to draw
    ptrdiff_t bytes; // of both buffers, to see whether another scene still fits
} gl_mesh;

// Attributes 0, 1, 2: position, normal, albedo, each three floats.
bool gl_mesh_upload(gl_mesh *m, const scene *s,
                    message *why); // into a zeroed mesh, or over an older one
void gl_mesh_triangle(gl_mesh *m); // no attributes; gl_triangle_vertex makes it cover everything
void gl_mesh_draw(const gl_mesh *m);
void gl_mesh_free(gl_mesh *m);

// ---- Programs

// Vertex shader for gl_mesh_triangle: out vec2 place, from (0,0) at the lower left to (1,1), and
// out vec3 ray, the direction in which the camera of gl_camera_uniforms() looks there (not
// normalized).
extern const char gl_triangle_vertex[];
// Vertex shaders for gl_mesh_upload that transform by the uniform world_to_clip at location 0: one
// for depth maps, and one with out vec3 position, normal, albedo in world space.
extern const char gl_depth_vertex[], gl_scene_vertex[];
// Fragment shader behind the latter: position (w = 1), normal, albedo into three colours.
extern const char gl_scene_fragment[];

// Texts end in NULL and get "#version 450 core" in front. An empty list of fragment texts makes a
// program that writes depth alone. 0 on failure, with the compiler's whole log on stderr.
GLuint gl_program(const char *name, const char *const *vertex, const char *const *fragment,
                  message *why);
// One shader of them; 0 on failure. The log, NULL when memory ran out, is the caller's to free.
GLuint gl_shader(GLenum type, const char *const *text, char **log);
// The usual case of one text each; fragment may be NULL.
GLuint gl_program_simple(const char *name, const char *vertex, const char *fragment, message *why);

// ---- Targets

#define GL_TARGET_COLORS 3

typedef struct gl_target {
    GLuint framebuffer, color[GL_TARGET_COLORS], depth;
    int width, height, samples;
} gl_target;

// Textures of these formats (up to a 0) with a depth buffer; samples 0 or 1: not multisampled.
bool gl_target_create(gl_target *t, int width, int height, int samples,
                      const GLenum formats[GL_TARGET_COLORS], message *why);
void gl_target_free(gl_target *t);
void gl_target_begin(const gl_target *t); // binds it, sets the viewport, clears it to zero
// Of the first colour, where it is multisampled the mean of the samples.
bool gl_target_read(const gl_target *t, image *out, message *why);
// The same into a file as image_save has them; exposure 0: as the picture asks for.
bool gl_target_save(const gl_target *t, float exposure, const char *file, message *why);

// Draws a picture over all of the target that is bound, whatever the size of either.
bool gl_image_draw(const image *picture, message *why);

// ---- Camera, surfaces, probe

void gl_camera_uniforms(const camera *c, GLuint program);
// Uses a program that transforms by world_to_clip at location 0, for what the camera sees.
void gl_camera_use(const camera *c, float near, float far, GLuint program);

// What the camera sees, one sample a pixel: colours position (w = 0 where there is nothing),
// normal, albedo.
typedef struct gl_surfaces {
    gl_target target;
    GLuint program;
} gl_surfaces;

bool gl_surfaces_create(gl_surfaces *s, int width, int height, message *why);
void gl_surfaces_draw(const gl_surfaces *s, const gl_mesh *m, const camera *eye);
void gl_surfaces_free(gl_surfaces *s);

// Six faces of RGB floats as a cube map with linear filtering, into *texture (0 makes one).
void gl_probe_upload(GLuint *texture, const float *const face[6], int side);

#endif
