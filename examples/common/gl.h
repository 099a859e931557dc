// The part of OpenGL 4.5 that the examples and tests use, declared here so that no GL header
// package is needed. The functions live in one table, filled by one call:
//
//     const char *missing;
//     if (!gl_load(glfwGetProcAddress, &missing)) ...   // gl_context_create() has done it already
//     GLuint buffer;
//     gl.CreateBuffers(1, &buffer);
//
// Not for a file that also includes glad, GLEW or the system's GL headers: the types would clash.
#ifndef GL_H
#define GL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if defined _WIN32
#define GL_CALL __stdcall
#else
#define GL_CALL
#endif

typedef unsigned int GLenum, GLuint, GLbitfield;
typedef int GLint, GLsizei;
typedef unsigned char GLboolean;
typedef char GLchar;
typedef float GLfloat;
typedef double GLdouble;
typedef intptr_t GLintptr;
typedef ptrdiff_t GLsizeiptr;
typedef int64_t GLint64;
typedef uint64_t GLuint64;
typedef void(GL_CALL *gl_debug_function)(GLenum source, GLenum type, GLuint id, GLenum severity,
                                         GLsizei length, const GLchar *message, const void *user);

// clang-format off
// X(result, name without "gl", parameters)
#define GL_FUNCTIONS(X)                                                                            \
    /* shaders */                                                                                  \
    X(GLuint, CreateShader, (GLenum type))                                                         \
    X(void, ShaderSource,                                                                          \
      (GLuint shader, GLsizei count, const GLchar *const *text, const GLint *length))              \
    X(void, CompileShader, (GLuint shader))                                                        \
    X(void, GetShaderiv, (GLuint shader, GLenum name, GLint *value))                               \
    X(void, GetShaderInfoLog, (GLuint shader, GLsizei size, GLsizei *length, GLchar *log))         \
    X(void, DeleteShader, (GLuint shader))                                                         \
    X(GLuint, CreateProgram, (void))                                                               \
    X(GLuint, CreateShaderProgramv, (GLenum type, GLsizei count, const GLchar *const *text))       \
    X(void, AttachShader, (GLuint program, GLuint shader))                                         \
    X(void, LinkProgram, (GLuint program))                                                         \
    X(void, GetProgramiv, (GLuint program, GLenum name, GLint *value))                             \
    X(void, GetProgramInfoLog, (GLuint program, GLsizei size, GLsizei *length, GLchar *log))       \
    X(void, DeleteProgram, (GLuint program))                                                       \
    X(void, UseProgram, (GLuint program))                                                          \
    X(GLint, GetUniformLocation, (GLuint program, const GLchar *name))                             \
    X(void, ProgramUniform1i, (GLuint program, GLint location, GLint x))                           \
    X(void, ProgramUniform1f, (GLuint program, GLint location, GLfloat x))                         \
    X(void, ProgramUniform2f, (GLuint program, GLint location, GLfloat x, GLfloat y))              \
    X(void, ProgramUniform3fv,                                                                     \
      (GLuint program, GLint location, GLsizei count, const GLfloat *xyz))                         \
    X(void, ProgramUniform4fv,                                                                     \
      (GLuint program, GLint location, GLsizei count, const GLfloat *xyzw))                        \
    X(void, ProgramUniformMatrix4fv,                                                               \
      (GLuint program, GLint location, GLsizei count, GLboolean transpose, const GLfloat *matrix)) \
    X(void, DispatchCompute, (GLuint x, GLuint y, GLuint z))                                       \
    X(void, MemoryBarrier, (GLbitfield barriers))                                                  \
    /* buffers */                                                                                  \
    X(void, CreateBuffers, (GLsizei count, GLuint *buffers))                                       \
    X(void, DeleteBuffers, (GLsizei count, const GLuint *buffers))                                 \
    X(GLboolean, IsBuffer, (GLuint buffer))                                                        \
    X(void, BufferStorage, (GLenum target, GLsizeiptr size, const void *data, GLbitfield flags))   \
    X(void, NamedBufferStorage,                                                                    \
      (GLuint buffer, GLsizeiptr size, const void *data, GLbitfield flags))                        \
    X(void, NamedBufferSubData,                                                                    \
      (GLuint buffer, GLintptr offset, GLsizeiptr size, const void *data))                         \
    X(void, GetNamedBufferSubData, (GLuint buffer, GLintptr offset, GLsizeiptr size, void *data))  \
    X(void *, MapNamedBufferRange,                                                                 \
      (GLuint buffer, GLintptr offset, GLsizeiptr size, GLbitfield access))                        \
    X(GLboolean, UnmapNamedBuffer, (GLuint buffer))                                                \
    X(void, BindBuffer, (GLenum target, GLuint buffer))                                            \
    X(void, BindBufferBase, (GLenum target, GLuint index, GLuint buffer))                          \
    X(void, BindBufferRange,                                                                       \
      (GLenum target, GLuint index, GLuint buffer, GLintptr offset, GLsizeiptr size))              \
    /* textures */                                                                                 \
    X(void, CreateTextures, (GLenum target, GLsizei count, GLuint *textures))                      \
    X(void, DeleteTextures, (GLsizei count, const GLuint *textures))                               \
    X(GLboolean, IsTexture, (GLuint texture))                                                      \
    X(void, GenTextures, (GLsizei count, GLuint *textures))                                        \
    X(void, TextureView,                                                                           \
      (GLuint view, GLenum target, GLuint texture, GLenum format, GLuint level, GLuint levels,     \
       GLuint layer, GLuint layers))                                                               \
    X(void, TextureStorage2D,                                                                      \
      (GLuint texture, GLsizei levels, GLenum format, GLsizei width, GLsizei height))              \
    X(void, TextureStorage3D,                                                                      \
      (GLuint texture, GLsizei levels, GLenum format, GLsizei width, GLsizei height,               \
       GLsizei depth))                                                                             \
    X(void, TextureStorage2DMultisample,                                                           \
      (GLuint texture, GLsizei samples, GLenum format, GLsizei width, GLsizei height,              \
       GLboolean fixed))                                                                           \
    X(void, TextureStorage3DMultisample,                                                           \
      (GLuint texture, GLsizei samples, GLenum format, GLsizei width, GLsizei height,              \
       GLsizei depth, GLboolean fixed))                                                            \
    X(void, TextureSubImage2D,                                                                     \
      (GLuint texture, GLint level, GLint x, GLint y, GLsizei width, GLsizei height,               \
       GLenum format, GLenum type, const void *pixels))                                            \
    X(void, TextureSubImage3D,                                                                     \
      (GLuint texture, GLint level, GLint x, GLint y, GLint z, GLsizei width, GLsizei height,      \
       GLsizei depth, GLenum format, GLenum type, const void *pixels))                             \
    X(void, GetTextureImage,                                                                       \
      (GLuint texture, GLint level, GLenum format, GLenum type, GLsizei size, void *pixels))       \
    X(void, TextureParameteri, (GLuint texture, GLenum name, GLint value))                         \
    X(void, TextureParameterfv, (GLuint texture, GLenum name, const GLfloat *value))               \
    X(void, GenerateTextureMipmap, (GLuint texture))                                               \
    X(void, ActiveTexture, (GLenum unit))                                                          \
    X(void, BindTexture, (GLenum target, GLuint texture))                                          \
    X(void, BindTextureUnit, (GLuint unit, GLuint texture))                                        \
    X(void, BindImageTexture,                                                                      \
      (GLuint unit, GLuint texture, GLint level, GLboolean layered, GLint layer, GLenum access,    \
       GLenum format))                                                                             \
    X(void, CreateSamplers, (GLsizei count, GLuint *samplers))                                     \
    X(void, DeleteSamplers, (GLsizei count, const GLuint *samplers))                               \
    X(void, SamplerParameteri, (GLuint sampler, GLenum name, GLint value))                         \
    X(void, BindSampler, (GLuint unit, GLuint sampler))                                            \
    X(void, PixelStorei, (GLenum name, GLint value))                                               \
    /* framebuffers */                                                                             \
    X(void, CreateFramebuffers, (GLsizei count, GLuint *framebuffers))                             \
    X(void, DeleteFramebuffers, (GLsizei count, const GLuint *framebuffers))                       \
    X(void, NamedFramebufferTexture,                                                               \
      (GLuint framebuffer, GLenum attachment, GLuint texture, GLint level))                        \
    X(void, NamedFramebufferTextureLayer,                                                          \
      (GLuint framebuffer, GLenum attachment, GLuint texture, GLint level, GLint layer))           \
    X(void, NamedFramebufferDrawBuffers,                                                           \
      (GLuint framebuffer, GLsizei count, const GLenum *buffers))                                  \
    X(void, NamedFramebufferReadBuffer, (GLuint framebuffer, GLenum buffer))                       \
    X(GLenum, CheckNamedFramebufferStatus, (GLuint framebuffer, GLenum target))                    \
    X(void, GetNamedFramebufferAttachmentParameteriv,                                              \
      (GLuint framebuffer, GLenum attachment, GLenum name, GLint *value))                          \
    X(void, ClearNamedFramebufferfv,                                                               \
      (GLuint framebuffer, GLenum buffer, GLint drawbuffer, const GLfloat *value))                 \
    X(void, BlitNamedFramebuffer,                                                                  \
      (GLuint source, GLuint target, GLint sx0, GLint sy0, GLint sx1, GLint sy1, GLint tx0,        \
       GLint ty0, GLint tx1, GLint ty1, GLbitfield mask, GLenum filter))                           \
    X(void, BindFramebuffer, (GLenum target, GLuint framebuffer))                                  \
    X(void, ReadPixels,                                                                            \
      (GLint x, GLint y, GLsizei width, GLsizei height, GLenum format, GLenum type, void *pixels)) \
    /* vertices and drawing */                                                                     \
    X(void, CreateVertexArrays, (GLsizei count, GLuint *arrays))                                   \
    X(void, DeleteVertexArrays, (GLsizei count, const GLuint *arrays))                             \
    X(void, BindVertexArray, (GLuint array))                                                       \
    X(void, VertexArrayVertexBuffer,                                                               \
      (GLuint array, GLuint binding, GLuint buffer, GLintptr offset, GLsizei stride))              \
    X(void, VertexArrayElementBuffer, (GLuint array, GLuint buffer))                               \
    X(void, VertexArrayAttribFormat,                                                               \
      (GLuint array, GLuint attribute, GLint size, GLenum type, GLboolean normalized,              \
       GLuint offset))                                                                             \
    X(void, VertexArrayAttribBinding, (GLuint array, GLuint attribute, GLuint binding))            \
    X(void, EnableVertexArrayAttrib, (GLuint array, GLuint attribute))                             \
    X(void, DrawArrays, (GLenum mode, GLint first, GLsizei count))                                 \
    X(void, DrawElements, (GLenum mode, GLsizei count, GLenum type, const void *offset))           \
    X(void, DrawArraysInstanced, (GLenum mode, GLint first, GLsizei count, GLsizei instances))     \
    X(void, Finish, (void))                                                                        \
    /* state */                                                                                    \
    X(void, Enable, (GLenum name))                                                                 \
    X(void, Disable, (GLenum name))                                                                \
    X(GLboolean, IsEnabled, (GLenum name))                                                         \
    X(void, Viewport, (GLint x, GLint y, GLsizei width, GLsizei height))                           \
    X(void, Scissor, (GLint x, GLint y, GLsizei width, GLsizei height))                            \
    X(void, ClearColor, (GLfloat r, GLfloat g, GLfloat b, GLfloat a))                              \
    X(void, ClearDepth, (GLdouble depth))                                                          \
    X(void, Clear, (GLbitfield mask))                                                              \
    X(void, DepthFunc, (GLenum compare))                                                           \
    X(void, DepthMask, (GLboolean write))                                                          \
    X(void, ColorMask, (GLboolean r, GLboolean g, GLboolean b, GLboolean a))                       \
    X(void, CullFace, (GLenum face))                                                               \
    X(void, FrontFace, (GLenum winding))                                                           \
    X(void, PolygonOffset, (GLfloat factor, GLfloat units))                                        \
    X(void, BlendFunc, (GLenum source, GLenum target))                                             \
    X(void, ClipControl, (GLenum origin, GLenum depth))                                            \
    X(const unsigned char *, GetString, (GLenum name))                                             \
    X(void, GetBooleanv, (GLenum name, GLboolean *value))                                          \
    X(void, GetIntegerv, (GLenum name, GLint *value))                                              \
    X(void, GetIntegeri_v, (GLenum name, GLuint index, GLint *value))                              \
    X(void, GetInteger64i_v, (GLenum name, GLuint index, GLint64 * value))                         \
    X(void, GetFloatv, (GLenum name, GLfloat *value))                                              \
    X(GLenum, GetError, (void))                                                                    \
    /* time and debugging */                                                                       \
    X(void, CreateQueries, (GLenum target, GLsizei count, GLuint *queries))                        \
    X(void, DeleteQueries, (GLsizei count, const GLuint *queries))                                 \
    X(void, QueryCounter, (GLuint query, GLenum target))                                           \
    X(void, GetQueryObjectui64v, (GLuint query, GLenum name, GLuint64 * value))                    \
    X(void, DebugMessageCallback, (gl_debug_function callback, const void *user))                  \
    X(void, DebugMessageControl,                                                                   \
      (GLenum source, GLenum type, GLenum severity, GLsizei count, const GLuint *ids,              \
       GLboolean enabled))                                                                         \
    X(void, ObjectLabel, (GLenum kind, GLuint name, GLsizei length, const GLchar *label))          \
    X(void, GetObjectLabel,                                                                        \
      (GLenum kind, GLuint name, GLsizei size, GLsizei *length, GLchar *label))                    \
    /* what only the tests of other callers' state need */                                         \
    X(void, GetDoublev, (GLenum name, GLdouble * value))                                           \
    X(void, GetFloati_v, (GLenum name, GLuint index, GLfloat *value))                              \
    X(void, GetDoublei_v, (GLenum name, GLuint index, GLdouble * value))                           \
    X(void, GetBooleani_v, (GLenum name, GLuint index, GLboolean *value))                          \
    X(GLboolean, IsEnabledi, (GLenum name, GLuint index))                                          \
    X(void, GetQueryiv, (GLenum target, GLenum name, GLint *value))                                \
    X(void, GetTextureParameteriv, (GLuint texture, GLenum name, GLint *value))                    \
    X(void, GetTextureLevelParameteriv,                                                            \
      (GLuint texture, GLint level, GLenum name, GLint *value))                                    \
    X(void, GetMultisamplefv, (GLenum name, GLuint index, GLfloat *value))                         \
    X(void, DepthRange, (GLdouble low, GLdouble high))                                             \
    X(void, PolygonMode, (GLenum face, GLenum mode))                                               \
    X(void, StencilFunc, (GLenum compare, GLint reference, GLuint mask))                           \
    X(void, StencilOp, (GLenum fail, GLenum depth_fail, GLenum pass))                              \
    X(void, StencilMask, (GLuint mask))                                                            \
    X(void, SampleMaski, (GLuint index, GLbitfield mask))                                          \
    X(void, SampleCoverage, (GLfloat value, GLboolean invert))                                     \
    X(void, MinSampleShading, (GLfloat value))                                                     \
    X(void, PrimitiveRestartIndex, (GLuint index))                                                 \
    X(void, LineWidth, (GLfloat width))                                                            \
    X(void, PointSize, (GLfloat size))                                                             \
    X(void, LogicOp, (GLenum operation))                                                           \
    X(void, ProvokingVertex, (GLenum which))                                                       \
    X(void, ViewportIndexedf,                                                                      \
      (GLuint index, GLfloat x, GLfloat y, GLfloat width, GLfloat height))                         \
    X(void, ScissorIndexed,                                                                        \
      (GLuint index, GLint x, GLint y, GLsizei width, GLsizei height))                             \
    X(void, DepthRangeIndexed, (GLuint index, GLdouble low, GLdouble high))                        \
    X(void, Enablei, (GLenum name, GLuint index))                                                  \
    X(void, Disablei, (GLenum name, GLuint index))                                                 \
    X(void, ColorMaski, (GLuint index, GLboolean r, GLboolean g, GLboolean b, GLboolean a))        \
    X(void, CreateRenderbuffers, (GLsizei count, GLuint *renderbuffers))                           \
    X(void, DeleteRenderbuffers, (GLsizei count, const GLuint *renderbuffers))                     \
    X(void, BindRenderbuffer, (GLenum target, GLuint renderbuffer))                                \
    X(void, NamedRenderbufferStorage,                                                              \
      (GLuint renderbuffer, GLenum format, GLsizei width, GLsizei height))                         \
    X(void, NamedFramebufferRenderbuffer,                                                          \
      (GLuint framebuffer, GLenum attachment, GLenum target, GLuint renderbuffer))                 \
    X(void, CreateProgramPipelines, (GLsizei count, GLuint *pipelines))                            \
    X(void, DeleteProgramPipelines, (GLsizei count, const GLuint *pipelines))                      \
    X(void, BindProgramPipeline, (GLuint pipeline))                                                \
    X(void, UseProgramStages, (GLuint pipeline, GLbitfield stages, GLuint program))                \
    X(void, CreateTransformFeedbacks, (GLsizei count, GLuint *feedbacks))                          \
    X(void, DeleteTransformFeedbacks, (GLsizei count, const GLuint *feedbacks))                    \
    X(void, BindTransformFeedback, (GLenum target, GLuint feedback))                               \
    X(void, TransformFeedbackVaryings,                                                             \
      (GLuint program, GLsizei count, const GLchar *const *names, GLenum mode))                    \
    X(void, BeginTransformFeedback, (GLenum primitive))                                            \
    X(void, PauseTransformFeedback, (void))                                                        \
    X(void, ResumeTransformFeedback, (void))                                                       \
    X(void, EndTransformFeedback, (void))                                                          \
    X(void, BeginQuery, (GLenum target, GLuint query))                                             \
    X(void, EndQuery, (GLenum target))                                                             \
    X(void, BeginConditionalRender, (GLuint query, GLenum mode))                                   \
    X(void, EndConditionalRender, (void))
// clang-format on

typedef struct gl_functions {
#define GL_MEMBER(result, name, parameters) result(GL_CALL *name) parameters;
    GL_FUNCTIONS(GL_MEMBER)
#undef GL_MEMBER
} gl_functions;

extern gl_functions gl;

// Fills the table for the current context. False if the driver lacks a function, and *missing names
// it.
bool gl_load(void (*(*load)(const char *name))(void), const char **missing);

// Constants, grouped as the functions are.
enum {
    GL_FALSE = 0,
    GL_TRUE = 1,
    GL_NONE = 0,
    GL_NO_ERROR = 0,

    GL_BYTE = 0x1400,
    GL_UNSIGNED_BYTE = 0x1401,
    GL_UNSIGNED_SHORT = 0x1403,
    GL_INT = 0x1404,
    GL_UNSIGNED_INT = 0x1405,
    GL_FLOAT = 0x1406,

    GL_FRAGMENT_SHADER = 0x8B30,
    GL_VERTEX_SHADER = 0x8B31,
    GL_COMPUTE_SHADER = 0x91B9,
    GL_COMPILE_STATUS = 0x8B81,
    GL_LINK_STATUS = 0x8B82,
    GL_INFO_LOG_LENGTH = 0x8B84,
    GL_CURRENT_PROGRAM = 0x8B8D,
    GL_SHADER_STORAGE_BARRIER_BIT = 0x2000,
    GL_SHADER_IMAGE_ACCESS_BARRIER_BIT = 0x20,
    GL_TEXTURE_FETCH_BARRIER_BIT = 0x8,
    GL_BUFFER_UPDATE_BARRIER_BIT = 0x200,

    GL_ARRAY_BUFFER = 0x8892,
    GL_ELEMENT_ARRAY_BUFFER = 0x8893,
    GL_PIXEL_PACK_BUFFER = 0x88EB,
    GL_PIXEL_UNPACK_BUFFER = 0x88EC,
    GL_UNIFORM_BUFFER = 0x8A11,
    GL_SHADER_STORAGE_BUFFER = 0x90D2,
    GL_DYNAMIC_STORAGE_BIT = 0x100,
    GL_MAP_READ_BIT = 0x1,
    GL_MAP_WRITE_BIT = 0x2,
    GL_MAP_PERSISTENT_BIT = 0x40,
    GL_MAP_COHERENT_BIT = 0x80,

    GL_TEXTURE_2D = 0x0DE1,
    GL_TEXTURE_2D_ARRAY = 0x8C1A,
    GL_TEXTURE_2D_MULTISAMPLE = 0x9100,
    GL_TEXTURE_2D_MULTISAMPLE_ARRAY = 0x9102,
    GL_TEXTURE_CUBE_MAP = 0x8513,
    GL_TEXTURE_CUBE_MAP_SEAMLESS = 0x884F,
    GL_TEXTURE0 = 0x84C0,
    GL_TEXTURE_MAG_FILTER = 0x2800,
    GL_TEXTURE_MIN_FILTER = 0x2801,
    GL_TEXTURE_WRAP_S = 0x2802,
    GL_TEXTURE_WRAP_T = 0x2803,
    GL_NEAREST = 0x2600,
    GL_LINEAR = 0x2601,
    GL_LINEAR_MIPMAP_LINEAR = 0x2703,
    GL_CLAMP_TO_EDGE = 0x812F,
    GL_CLAMP_TO_BORDER = 0x812D,
    GL_TEXTURE_BORDER_COLOR = 0x1004,
    GL_REPEAT = 0x2901,
    GL_RED = 0x1903,
    GL_RG = 0x8227,
    GL_RGB = 0x1907,
    GL_RGBA = 0x1908,
    GL_RED_INTEGER = 0x8D94,
    GL_RGBA_INTEGER = 0x8D99,
    GL_DEPTH_COMPONENT = 0x1902,
    GL_R32F = 0x822E,
    GL_R32UI = 0x8236,
    GL_RGBA8 = 0x8058,
    GL_SRGB8_ALPHA8 = 0x8C43,
    GL_RGBA16F = 0x881A,
    GL_RGBA16 = 0x805B,
    GL_RG16 = 0x822C,
    GL_RGBA32F = 0x8814,
    GL_RGB32F = 0x8815,
    GL_RGBA32UI = 0x8D70,
    GL_DEPTH_COMPONENT32F = 0x8CAC,
    GL_READ_ONLY = 0x88B8,
    GL_WRITE_ONLY = 0x88B9,
    GL_READ_WRITE = 0x88BA,
    GL_PACK_ALIGNMENT = 0x0D05,
    GL_UNPACK_ALIGNMENT = 0x0CF5,

    GL_FRAMEBUFFER = 0x8D40,
    GL_READ_FRAMEBUFFER = 0x8CA8,
    GL_DRAW_FRAMEBUFFER = 0x8CA9,
    GL_DRAW_FRAMEBUFFER_BINDING = 0x8CA6,
    GL_FRAMEBUFFER_ATTACHMENT_OBJECT_NAME = 0x8CD1,
    GL_COLOR_ATTACHMENT0 = 0x8CE0,
    GL_DEPTH_ATTACHMENT = 0x8D00,
    GL_FRAMEBUFFER_COMPLETE = 0x8CD5,
    GL_COLOR = 0x1800,
    GL_DEPTH = 0x1801,
    GL_COLOR_BUFFER_BIT = 0x4000,
    GL_DEPTH_BUFFER_BIT = 0x100,

    GL_POINTS = 0x0,
    GL_LINES = 0x1,
    GL_TRIANGLES = 0x4,
    GL_TRIANGLE_STRIP = 0x5,

    GL_DEPTH_TEST = 0x0B71,
    GL_SCISSOR_TEST = 0x0C11,
    GL_CULL_FACE = 0x0B44,
    GL_BLEND = 0x0BE2,
    GL_MULTISAMPLE = 0x809D,
    GL_FRAMEBUFFER_SRGB = 0x8DB9,
    GL_POLYGON_OFFSET_FILL = 0x8037,
    GL_PRIMITIVE_RESTART = 0x8F9D,
    GL_DEPTH_CLAMP = 0x864F,
    GL_LESS = 0x0201,
    GL_LEQUAL = 0x0203,
    GL_GREATER = 0x0204,
    GL_ALWAYS = 0x0207,
    GL_FRONT = 0x0404,
    GL_BACK = 0x0405,
    GL_CW = 0x0900,
    GL_CCW = 0x0901,
    GL_ZERO = 0,
    GL_ONE = 1,
    GL_SRC_COLOR = 0x0300,
    GL_SRC_ALPHA = 0x0302,
    GL_SRC1_COLOR = 0x88F9,
    GL_ONE_MINUS_SRC_ALPHA = 0x0303,
    GL_LOWER_LEFT = 0x8CA1,
    GL_UPPER_LEFT = 0x8CA2,
    GL_NEGATIVE_ONE_TO_ONE = 0x935E,
    GL_ZERO_TO_ONE = 0x935F,
    GL_VENDOR = 0x1F00,
    GL_RENDERER = 0x1F01,
    GL_VERSION = 0x1F02,
    GL_VIEWPORT = 0x0BA2,

    GL_TIMESTAMP = 0x8E28,
    GL_QUERY_RESULT = 0x8866,
    GL_DEBUG_OUTPUT = 0x92E0,
    GL_DEBUG_OUTPUT_SYNCHRONOUS = 0x8242,
    GL_DEBUG_TYPE_ERROR = 0x824C,
    GL_DEBUG_SEVERITY_NOTIFICATION = 0x826B,
    GL_DEBUG_SEVERITY_HIGH = 0x9146,
    GL_DONT_CARE = 0x1100,
    GL_BUFFER = 0x82E0,
    GL_SHADER = 0x82E1,
    GL_PROGRAM = 0x82E2,
    GL_TEXTURE = 0x1702,

    // What only the tests of state and failures name.
    GL_TEXTURE_UPDATE_BARRIER_BIT = 0x100,
    GL_NEVER = 0x0200,
    GL_FRONT_AND_BACK = 0x0408,
    GL_OUT_OF_MEMORY = 0x0505,
    GL_FRONT_FACE = 0x0B46,
    GL_STENCIL_TEST = 0x0B90,
    GL_STENCIL_WRITEMASK = 0x0B98,
    GL_DITHER = 0x0BD0,
    GL_COLOR_LOGIC_OP = 0x0BF2,
    GL_UNPACK_SWAP_BYTES = 0x0CF0,
    GL_UNPACK_ROW_LENGTH = 0x0CF2,
    GL_UNPACK_SKIP_ROWS = 0x0CF3,
    GL_UNPACK_SKIP_PIXELS = 0x0CF4,
    GL_PACK_SWAP_BYTES = 0x0D00,
    GL_PACK_ROW_LENGTH = 0x0D02,
    GL_PACK_SKIP_ROWS = 0x0D03,
    GL_PACK_SKIP_PIXELS = 0x0D04,
    GL_TEXTURE_WIDTH = 0x1000,
    GL_TEXTURE_HEIGHT = 0x1001,
    GL_COPY = 0x1503,
    GL_INVERT = 0x150A,
    GL_LINE = 0x1B01,
    GL_FILL = 0x1B02,
    GL_KEEP = 0x1E00,
    GL_REPLACE = 0x1E01,
    GL_CLIP_DISTANCE0 = 0x3000,
    GL_PACK_SKIP_IMAGES = 0x806B,
    GL_PACK_IMAGE_HEIGHT = 0x806C,
    GL_UNPACK_SKIP_IMAGES = 0x806D,
    GL_UNPACK_IMAGE_HEIGHT = 0x806E,
    GL_TEXTURE_3D = 0x806F,
    GL_TEXTURE_DEPTH = 0x8071,
    GL_VERTEX_ARRAY = 0x8074,
    GL_SAMPLE_ALPHA_TO_COVERAGE = 0x809E,
    GL_SAMPLE_COVERAGE = 0x80A0,
    GL_MAJOR_VERSION = 0x821B,
    GL_MINOR_VERSION = 0x821C,
    GL_RG_INTEGER = 0x8228,
    GL_R8 = 0x8229,
    GL_DEBUG_TYPE_DEPRECATED_BEHAVIOR = 0x824D,
    GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR = 0x824E,
    GL_DEBUG_TYPE_PORTABILITY = 0x824F,
    GL_DEBUG_TYPE_PERFORMANCE = 0x8250,
    GL_TEXTURE_IMMUTABLE_LEVELS = 0x82DF,
    GL_QUERY = 0x82E3,
    GL_PROGRAM_PIPELINE = 0x82E4,
    GL_SAMPLER = 0x82E6,
    GL_SHADER_TYPE = 0x8B4F,
    GL_TEXTURE_BUFFER = 0x8C2A,
    GL_ANY_SAMPLES_PASSED = 0x8C2F,
    GL_SAMPLE_SHADING = 0x8C36,
    GL_RASTERIZER_DISCARD = 0x8C89,
    GL_POLYGON_OFFSET_LINE = 0x2A02,
    GL_POLYGON_OFFSET_POINT = 0x2A01,
    GL_TRANSFORM_FEEDBACK_BUFFER = 0x8C8E,
    GL_FRAMEBUFFER_UNSUPPORTED = 0x8CDD,
    GL_RENDERBUFFER = 0x8D41,
    GL_MAX_SAMPLES = 0x8D57,
    GL_QUERY_WAIT = 0x8E13,
    GL_CONTEXT_PROFILE_MASK = 0x9126,
    GL_ALPHA_TEST = 0x0BC0,
    GL_POLYGON_STIPPLE = 0x0B42,
    GL_POINT = 0x1B00,
    GL_CLEAR = 0x1500,
    GL_TRANSFORM_FEEDBACK = 0x8E22,
    GL_INTERLEAVED_ATTRIBS = 0x8C8C,
    GL_FIRST_VERTEX_CONVENTION = 0x8E4D,
    GL_LAST_VERTEX_CONVENTION = 0x8E4E,
    GL_SAMPLE_MASK = 0x8E51,
    GL_COPY_READ_BUFFER = 0x8F36,
    GL_COPY_WRITE_BUFFER = 0x8F37,
    GL_DRAW_INDIRECT_BUFFER = 0x8F3F,
    GL_DISPATCH_INDIRECT_BUFFER = 0x90EE,
    GL_TEXTURE_SAMPLES = 0x9106,
    GL_MAX_COLOR_TEXTURE_SAMPLES = 0x910E,
    GL_MAX_DEPTH_TEXTURE_SAMPLES = 0x910F,
    GL_MAX_INTEGER_SAMPLES = 0x9110,
    GL_QUERY_BUFFER = 0x9192,
    GL_ATOMIC_COUNTER_BUFFER = 0x92C0,
    GL_MAX_FRAMEBUFFER_SAMPLES = 0x9318
};

#endif
