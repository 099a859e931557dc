// What OpenGL 3.3, OpenGL ES 3.0 and WebGL 2 have in common, in a table of its own: gl33_load()
// fills it. Objects are bound to be changed; the calls below leave theirs bound.
#ifndef GL33_H
#define GL33_H

#include "gl.h"
#include "image.h"
#include "scene.h"

// clang-format off
// X(result, name without "gl", parameters)
#define GL33_FUNCTIONS(X)                                                                                     \
    X(GLuint, CreateShader, (GLenum type))                                                                    \
    X(void, ShaderSource, (GLuint shader, GLsizei count, const GLchar *const *text, const GLint *length))     \
    X(void, CompileShader, (GLuint shader))                                                                   \
    X(void, GetShaderiv, (GLuint shader, GLenum name, GLint *value))                                          \
    X(void, GetShaderInfoLog, (GLuint shader, GLsizei room, GLsizei *length, GLchar *log))                    \
    X(void, DeleteShader, (GLuint shader))                                                                    \
    X(GLuint, CreateProgram, (void))                                                                          \
    X(void, AttachShader, (GLuint program, GLuint shader))                                                    \
    X(void, LinkProgram, (GLuint program))                                                                    \
    X(void, GetProgramiv, (GLuint program, GLenum name, GLint *value))                                        \
    X(void, GetProgramInfoLog, (GLuint program, GLsizei room, GLsizei *length, GLchar *log))                  \
    X(void, DeleteProgram, (GLuint program))                                                                  \
    X(void, UseProgram, (GLuint program))                                                                     \
    X(GLint, GetUniformLocation, (GLuint program, const GLchar *name))                                        \
    X(void, Uniform1i, (GLint location, GLint x))                                                             \
    X(void, Uniform1f, (GLint location, GLfloat x))                                                           \
    X(void, Uniform3fv, (GLint location, GLsizei count, const GLfloat *value))                                \
    X(void, UniformMatrix4fv, (GLint location, GLsizei count, GLboolean transpose, const GLfloat *value))     \
    X(GLuint, GetUniformBlockIndex, (GLuint program, const GLchar *name))                                     \
    X(void, UniformBlockBinding, (GLuint program, GLuint index, GLuint binding))                              \
    X(void, GenBuffers, (GLsizei count, GLuint *names))                                                       \
    X(void, DeleteBuffers, (GLsizei count, const GLuint *names))                                              \
    X(void, BindBuffer, (GLenum target, GLuint name))                                                         \
    X(void, BindBufferBase, (GLenum target, GLuint index, GLuint name))                                       \
    X(void, BufferData, (GLenum target, GLsizeiptr bytes, const void *data, GLenum usage))                    \
    X(void, GenVertexArrays, (GLsizei count, GLuint *names))                                                  \
    X(void, DeleteVertexArrays, (GLsizei count, const GLuint *names))                                         \
    X(void, BindVertexArray, (GLuint name))                                                                   \
    X(void, EnableVertexAttribArray, (GLuint index))                                                          \
    X(void, VertexAttribPointer,                                                                              \
      (GLuint index, GLint size, GLenum type, GLboolean normalized, GLsizei stride, const void *offset))      \
    X(void, DrawElements, (GLenum mode, GLsizei count, GLenum type, const void *offset))                      \
    X(void, GenTextures, (GLsizei count, GLuint *names))                                                      \
    X(void, DeleteTextures, (GLsizei count, const GLuint *names))                                             \
    X(void, ActiveTexture, (GLenum unit))                                                                     \
    X(void, BindTexture, (GLenum target, GLuint name))                                                        \
    X(void, TexParameteri, (GLenum target, GLenum name, GLint value))                                         \
    X(void, TexImage3D, (GLenum target, GLint level, GLint format, GLsizei width, GLsizei height,             \
      GLsizei depth, GLint border, GLenum layout, GLenum type, const void *texels))                           \
    X(void, TexSubImage3D, (GLenum target, GLint level, GLint x, GLint y, GLint z, GLsizei width,             \
      GLsizei height, GLsizei depth, GLenum layout, GLenum type, const void *texels))                         \
    X(void, GenFramebuffers, (GLsizei count, GLuint *names))                                                  \
    X(void, DeleteFramebuffers, (GLsizei count, const GLuint *names))                                         \
    X(void, DeleteRenderbuffers, (GLsizei count, const GLuint *names))                                        \
    X(void, BindFramebuffer, (GLenum target, GLuint name))                                                    \
    X(GLenum, CheckFramebufferStatus, (GLenum target))                                                        \
    X(void, GenRenderbuffers, (GLsizei count, GLuint *names))                                                 \
    X(void, BindRenderbuffer, (GLenum target, GLuint name))                                                   \
    X(void, RenderbufferStorageMultisample,                                                                   \
      (GLenum target, GLsizei samples, GLenum format, GLsizei width, GLsizei height))                         \
    X(void, FramebufferRenderbuffer, (GLenum target, GLenum attachment, GLenum kind, GLuint name))            \
    X(void, BlitFramebuffer, (GLint x0, GLint y0, GLint x1, GLint y1, GLint to_x0, GLint to_y0, GLint to_x1,  \
      GLint to_y1, GLbitfield mask, GLenum filter))                                                           \
    X(void, ReadPixels,                                                                                       \
      (GLint x, GLint y, GLsizei width, GLsizei height, GLenum format, GLenum type, void *pixels))            \
    X(void, Viewport, (GLint x, GLint y, GLsizei width, GLsizei height))                                      \
    X(void, ClearColor, (GLfloat r, GLfloat g, GLfloat b, GLfloat a))                                         \
    X(void, Clear, (GLbitfield mask))                                                                         \
    X(void, Enable, (GLenum capability))                                                                      \
    X(void, Disable, (GLenum capability))                                                                     \
    X(GLenum, GetError, (void))
// clang-format on

typedef struct gl33_functions {
#define GL33_MEMBER(result, name, parameters) result(GL_CALL *name) parameters;
    GL33_FUNCTIONS(GL33_MEMBER)
#undef GL33_MEMBER
} gl33_functions;

extern gl33_functions gl33;

bool gl33_load(void (*(*load)(const char *name))(void), const char **missing);

// Attributes 0, 1, 2: position, normal, albedo, each three floats.
typedef struct gl33_mesh {
    GLuint array, buffers[2];
    int count;
} gl33_mesh;

bool gl33_mesh_upload(gl33_mesh *m, const scene *s,
                      message *why); // into a zeroed mesh, or over an older one
void gl33_mesh_draw(const gl33_mesh *m);

// Vertex shader of such meshes: uniform world_to_clip; out vec3 position, normal, albedo.
extern const char gl33_scene_vertex[];

// A shader of version and texts up to NULL; 0 on failure. The log is cut to its room.
GLuint gl33_shader(GLenum type, const char *version, const char *const *text, char *log,
                   GLsizei room);
// Both begin with version, "#version 300 es\n" say; fragment ends in NULL. 0 on failure, with the
// log in *why.
GLuint gl33_program(const char *version, const char *vertex, const char *const *fragment,
                    message *why);

// Colours of floats and depth, bound and cleared to zero; samples 0: one a pixel. ES wants
// EXT_color_buffer_float.
bool gl33_target_begin(int width, int height, int samples, message *why);
bool gl33_target_read(int width, int height, image *out, message *why); // the mean of the samples

// The depth map of a directional light as mssm_map_update takes it, drawn once for each sample of a
// texel since OpenGL ES 3.0 has no multisampled textures. samples: 1, 2, 4 or 8.
bool gl33_depth(const char *version, const gl33_mesh *m, const float world_to_shadow[16], int side,
                int samples, float *depth, message *why);

#endif
