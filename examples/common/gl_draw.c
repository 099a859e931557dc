#include "gl_draw.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- Meshes

static void attribute(GLuint array, GLuint index, size_t offset)
{
    gl.EnableVertexArrayAttrib(array, index);
    gl.VertexArrayAttribFormat(array, index, 3, GL_FLOAT, GL_FALSE, (GLuint)offset);
    gl.VertexArrayAttribBinding(array, index, 0);
}

static void mesh_room(gl_mesh *m, GLsizeiptr vertices, GLsizeiptr indices)
{
    if (m->array && m->bytes == vertices + indices) return;
    gl_mesh_free(m);
    gl.CreateVertexArrays(1, &m->array);
    gl.CreateBuffers(1, &m->vertices);
    gl.CreateBuffers(1, &m->indices);
    gl.NamedBufferStorage(m->vertices, vertices, NULL, GL_DYNAMIC_STORAGE_BIT);
    gl.NamedBufferStorage(m->indices, indices, NULL, GL_DYNAMIC_STORAGE_BIT);
    gl.VertexArrayVertexBuffer(m->array, 0, m->vertices, 0, sizeof(scene_vertex));
    gl.VertexArrayElementBuffer(m->array, m->indices);
    attribute(m->array, 0, offsetof(scene_vertex, position));
    attribute(m->array, 1, offsetof(scene_vertex, normal));
    attribute(m->array, 2, offsetof(scene_vertex, albedo));
    m->bytes = vertices + indices;
}

bool gl_mesh_upload(gl_mesh *m, const scene *s, message *why)
{
    const size_t vertex_bytes = (size_t)s->vertices * sizeof(scene_vertex);
    const size_t index_bytes = (size_t)s->triangles * sizeof *s->triangle;
    scene_vertex *v = scene_vertices(s);
    if (!v) return fail(why, "no memory for %d vertices", s->vertices);
    mesh_room(m, (GLsizeiptr)vertex_bytes, (GLsizeiptr)index_bytes);
    gl.NamedBufferSubData(m->vertices, 0, (GLsizeiptr)vertex_bytes, v);
    gl.NamedBufferSubData(m->indices, 0, (GLsizeiptr)index_bytes, s->triangle);
    m->count = 3 * s->triangles;
    free(v);
    return true;
}

void gl_mesh_triangle(gl_mesh *m)
{
    *m = (gl_mesh){.count = 3};
    gl.CreateVertexArrays(1, &m->array);
}

void gl_mesh_draw(const gl_mesh *m)
{
    gl.BindVertexArray(m->array);
    if (m->indices)
        gl.DrawElements(GL_TRIANGLES, m->count, GL_UNSIGNED_INT, NULL);
    else
        gl.DrawArrays(GL_TRIANGLES, 0, m->count);
}

void gl_mesh_free(gl_mesh *m)
{
    if (m->array) gl.DeleteVertexArrays(1, &m->array);
    if (m->vertices) gl.DeleteBuffers(1, &m->vertices);
    if (m->indices) gl.DeleteBuffers(1, &m->indices);
    *m = (gl_mesh){0};
}

// ---- Programs

// clang-format off
const char gl_triangle_vertex[] =
    "uniform vec3 camera_rays[3];\n"
    "out vec2 place;\n"
    "out vec3 ray;\n"
    "void main()\n"
    "{\n"
    "    vec2 at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4 - 1;\n"
    "    place = 0.5 * at + 0.5;\n"
    "    ray = at.x * camera_rays[0] + at.y * camera_rays[1] - camera_rays[2];\n"
    "    gl_Position = vec4(at, 0, 1);\n"
    "}\n";

const char gl_depth_vertex[] =
    "layout(location = 0) uniform mat4 world_to_clip;\n"
    "layout(location = 0) in vec3 position;\n"
    "void main() { gl_Position = world_to_clip * vec4(position, 1); }\n";

const char gl_scene_vertex[] =
    "layout(location = 0) uniform mat4 world_to_clip;\n"
    "layout(location = 0) in vec3 position_in;\n"
    "layout(location = 1) in vec3 normal_in;\n"
    "layout(location = 2) in vec3 albedo_in;\n"
    "out vec3 position, normal, albedo;\n"
    "out float one;\n"
    "void main()\n"
    "{\n"
    "    one = 1;\n"
    "    position = position_in;\n"
    "    normal = normal_in;\n"
    "    albedo = albedo_in;\n"
    "    gl_Position = world_to_clip * vec4(position_in, 1);\n"
    "}\n";

// At each sample of its own: in the middle of a pixel the surface may have ended already. Mesa's
// llvmpipe (22.3) then divides by the w of the middle; the quotient with 1, interpolated like the
// rest, is right everywhere.
const char gl_scene_fragment[] =
    "in vec3 position, normal, albedo;\n"
    "in float one;\n"
    "layout(location = 0) out vec4 position_out;\n"
    "layout(location = 1) out vec4 normal_out;\n"
    "layout(location = 2) out vec4 albedo_out;\n"
    "void main()\n"
    "{\n"
    "    vec3 at = interpolateAtSample(position, gl_SampleID);\n"
    "    position_out = vec4(at / interpolateAtSample(one, gl_SampleID), 1);\n"
    "    normal_out = vec4(normalize(interpolateAtSample(normal, gl_SampleID)), 0);\n"
    "    albedo_out = vec4(albedo, 1);\n"
    "}\n";
// clang-format on

// The driver's log names lines of the text that it got, so say which text that was.
static bool report(const char *name, const char *log, message *why)
{
    fprintf(stderr, "%s:\n%s\n", name, log);
    return fail(why, "%s: %.*s", name, (int)strcspn(log, "\n"), log);
}

GLuint gl_shader(GLenum type, const char *const *text, char **log)
{
    const char *piece[16] = {"#version 450 core\n"};
    GLsizei pieces = 1;
    GLint compiled = 0, length = 0;
    while (*text && pieces < 16) piece[pieces++] = *text++;
    const GLuint shader = gl.CreateShader(type);
    gl.ShaderSource(shader, pieces, piece, NULL);
    gl.CompileShader(shader);
    gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    gl.GetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
    *log = calloc((size_t)length + 1, 1);
    if (*log) gl.GetShaderInfoLog(shader, length, NULL, *log);
    if (compiled) return shader;
    gl.DeleteShader(shader);
    return 0;
}

static bool attach(GLuint program, GLenum type, const char *name, const char *const *text,
                   message *why)
{
    char *log;
    const GLuint shader = gl_shader(type, text, &log);
    if (shader) {
        gl.AttachShader(program, shader);
        gl.DeleteShader(shader); // the program keeps it
    } else {
        report(name, log ? log : "(no memory for the log)", why);
    }
    free(log);
    return shader != 0;
}

static bool link(GLuint program, const char *name, message *why)
{
    GLint linked = 0, length = 0;
    gl.LinkProgram(program);
    gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked) return true;
    gl.GetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
    char *log = calloc((size_t)length + 1, 1);
    if (log) gl.GetProgramInfoLog(program, length, NULL, log);
    report(name, log ? log : "(no memory for the log)", why);
    free(log);
    return false;
}

GLuint gl_program(const char *name, const char *const *vertex, const char *const *fragment,
                  message *why)
{
    const GLuint program = gl.CreateProgram();
    gl.ObjectLabel(GL_PROGRAM, program, -1, name);
    if (attach(program, GL_VERTEX_SHADER, name, vertex, why) &&
        (!*fragment || attach(program, GL_FRAGMENT_SHADER, name, fragment, why)) &&
        link(program, name, why)) {
        return program;
    }
    gl.DeleteProgram(program);
    return 0;
}

GLuint gl_program_simple(const char *name, const char *vertex, const char *fragment, message *why)
{
    const char *const vertices[] = {vertex, NULL}, *const fragments[] = {fragment, NULL};
    return gl_program(name, vertices, fragments, why);
}

// ---- Targets

static GLuint target_texture(const gl_target *t, GLenum format, GLenum attachment)
{
    GLuint texture;
    gl.CreateTextures(t->samples > 1 ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D, 1, &texture);
    if (t->samples > 1) {
        gl.TextureStorage2DMultisample(texture, t->samples, format, t->width, t->height, GL_TRUE);
    } else {
        gl.TextureStorage2D(texture, 1, format, t->width, t->height);
    }
    gl.NamedFramebufferTexture(t->framebuffer, attachment, texture, 0);
    return texture;
}

bool gl_target_create(gl_target *t, int width, int height, int samples,
                      const GLenum formats[GL_TARGET_COLORS], message *why)
{
    GLenum buffers[GL_TARGET_COLORS];
    GLsizei colors = 0;
    *t = (gl_target){.width = width, .height = height, .samples = samples};
    gl.CreateFramebuffers(1, &t->framebuffer);
    for (; colors < GL_TARGET_COLORS && formats[colors]; colors++) {
        buffers[colors] = GL_COLOR_ATTACHMENT0 + (GLenum)colors;
        t->color[colors] = target_texture(t, formats[colors], buffers[colors]);
    }
    t->depth = target_texture(t, GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT);
    gl.NamedFramebufferDrawBuffers(t->framebuffer, colors, buffers);
    if (gl.CheckNamedFramebufferStatus(t->framebuffer, GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) {
        return true;
    }
    gl_target_free(t);
    return fail(why, "the driver cannot draw into a target of %d x %d with %d samples", width,
                height, samples);
}

void gl_target_free(gl_target *t)
{
    for (int i = 0; i < GL_TARGET_COLORS; i++) {
        if (t->color[i]) gl.DeleteTextures(1, &t->color[i]);
    }
    if (t->depth) gl.DeleteTextures(1, &t->depth);
    if (t->framebuffer) gl.DeleteFramebuffers(1, &t->framebuffer);
    *t = (gl_target){0};
}

void gl_target_begin(const gl_target *t)
{
    gl.BindFramebuffer(GL_FRAMEBUFFER, t->framebuffer);
    gl.Viewport(0, 0, t->width, t->height);
    gl.ClearColor(0, 0, 0, 0);
    gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

static bool read_samples(const gl_target *t, image *out, message *why)
{
    const GLenum formats[GL_TARGET_COLORS] = {GL_RGBA32F};
    gl_target mean;
    if (!gl_target_create(&mean, t->width, t->height, 1, formats, why)) return false;
    gl.BlitNamedFramebuffer(t->framebuffer, mean.framebuffer, 0, 0, t->width, t->height, 0, 0,
                            t->width, t->height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    const bool read = gl_target_read(&mean, out, why);
    gl_target_free(&mean);
    return read;
}

bool gl_target_read(const gl_target *t, image *out, message *why)
{
    if (t->samples > 1) return read_samples(t, out, why);
    const size_t row = (size_t)t->width * 3, bytes = row * (size_t)t->height * sizeof(float);
    float *pixels = malloc(bytes);
    const bool created = pixels && image_create(out, t->width, t->height);
    if (created) {
        gl.PixelStorei(GL_PACK_ALIGNMENT, 4);
        gl.GetTextureImage(t->color[0], 0, GL_RGB, GL_FLOAT, (GLsizei)bytes, pixels);
        for (int y = 0; y < t->height; y++) { // row 0 is at the bottom in GL
            memcpy(out->rgb + (size_t)y * row, pixels + (size_t)(t->height - 1 - y) * row,
                   row * sizeof(float));
        }
    }
    free(pixels);
    return created || fail(why, "no memory for a picture of %d x %d", t->width, t->height);
}

bool gl_target_save(const gl_target *t, float exposure, const char *file, message *why)
{
    image picture;
    if (!gl_target_read(t, &picture, why)) return false;
    if (!(exposure > 0)) exposure = image_exposure(&picture);
    const bool saved = image_save(&picture, exposure, file, why);
    image_free(&picture);
    return saved;
}

static const char image_fragment[] =
    "layout(binding = 0) uniform sampler2D picture;\n"
    "in vec2 place;\n"
    "out vec4 color;\n"
    "void main() { color = texture(picture, vec2(place.x, 1 - place.y)); }\n";

bool gl_image_draw(const image *picture, message *why)
{
    gl_mesh triangle;
    GLuint texture;
    const GLuint program = gl_program_simple("picture", gl_triangle_vertex, image_fragment, why);
    if (!program) return false;
    gl_mesh_triangle(&triangle);
    gl.CreateTextures(GL_TEXTURE_2D, 1, &texture);
    gl.TextureStorage2D(texture, 1, GL_RGBA32F, picture->width, picture->height);
    gl.TextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    gl.TextureSubImage2D(texture, 0, 0, 0, picture->width, picture->height, GL_RGB, GL_FLOAT,
                         picture->rgb);
    gl.BindTextureUnit(0, texture);
    gl.UseProgram(program);
    gl_mesh_draw(&triangle);
    gl.DeleteTextures(1, &texture);
    gl.DeleteProgram(program);
    gl_mesh_free(&triangle);
    return true;
}

// ---- Camera, surfaces, probe

void gl_camera_uniforms(const camera *c, GLuint program)
{
    const vec3 axes[3] = {vec_scale(c->right, c->tan_x), vec_scale(c->up, c->tan_y), c->back};
    const float rays[9] = {axes[0].x, axes[0].y, axes[0].z, axes[1].x, axes[1].y,
                           axes[1].z, axes[2].x, axes[2].y, axes[2].z};
    gl.ProgramUniform3fv(program, gl.GetUniformLocation(program, "camera_rays"), 3, rays);
}

void gl_camera_use(const camera *c, float near, float far, GLuint program)
{
    float world_to_clip[16];
    gl_camera_matrix(c, near, far, world_to_clip);
    gl.UseProgram(program);
    gl.ProgramUniformMatrix4fv(program, 0, 1, GL_FALSE, world_to_clip);
}

bool gl_surfaces_create(gl_surfaces *s, int width, int height, message *why)
{
    const GLenum formats[GL_TARGET_COLORS] = {GL_RGBA32F, GL_RGBA32F, GL_RGBA8};
    *s = (gl_surfaces){.program =
                           gl_program_simple("view", gl_scene_vertex, gl_scene_fragment, why)};
    return s->program && gl_target_create(&s->target, width, height, 1, formats, why);
}

void gl_surfaces_draw(const gl_surfaces *s, const gl_mesh *m, const camera *eye)
{
    gl_target_begin(&s->target);
    gl.Enable(GL_DEPTH_TEST);
    gl_camera_use(eye, 0.1f, 30, s->program);
    gl_mesh_draw(m);
    gl.Disable(GL_DEPTH_TEST);
}

void gl_surfaces_free(gl_surfaces *s)
{
    if (s->program) gl.DeleteProgram(s->program);
    gl_target_free(&s->target);
    s->program = 0;
}

void gl_probe_upload(GLuint *texture, const float *const face[6], int side)
{
    if (!*texture) {
        gl.CreateTextures(GL_TEXTURE_CUBE_MAP, 1, texture);
        gl.TextureStorage2D(*texture, 1, GL_RGB32F, side, side);
        gl.TextureParameteri(*texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        gl.Enable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
    }
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    for (int f = 0; f < 6; f++) {
        gl.TextureSubImage3D(*texture, 0, 0, 0, f, side, side, 1, GL_RGB, GL_FLOAT, face[f]);
    }
}
