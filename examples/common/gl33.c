#include "gl33.h"

#include "raster.h"

#include <stdlib.h>
#include <string.h>

gl33_functions gl33;

// Framebuffers to draw into and to read the mean of the samples from, with their renderbuffers; of
// the current context.
static struct {
    GLuint name, buffers[2];
} targets[2];

bool gl33_load(void (*(*load)(const char *name))(void), const char **missing)
{
    void (*f)(void);
#define GL33_LOAD(result, name, parameters) \
    f = load("gl" #name);                   \
    if (!f) {                               \
        *missing = "gl" #name;              \
        return false;                       \
    }                                       \
    gl33.name = (result(GL_CALL *) parameters)f;
    GL33_FUNCTIONS(GL33_LOAD)
#undef GL33_LOAD
    memset(targets, 0, sizeof targets);
    return true;
}

// ---- Meshes

bool gl33_mesh_upload(gl33_mesh *m, const scene *s, message *why)
{
    const size_t vertex_bytes = (size_t)s->vertices * sizeof(scene_vertex);
    scene_vertex *v = scene_vertices(s);
    if (!v) return fail(why, "no memory for %d vertices", s->vertices);
    if (!m->array) {
        gl33.GenVertexArrays(1, &m->array);
        gl33.GenBuffers(2, m->buffers);
    }
    gl33.BindVertexArray(m->array);
    gl33.BindBuffer(GL_ARRAY_BUFFER, m->buffers[0]);
    gl33.BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)vertex_bytes, v, 0x88E4); // GL_STATIC_DRAW
    gl33.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, m->buffers[1]);
    gl33.BufferData(GL_ELEMENT_ARRAY_BUFFER,
                    (GLsizeiptr)s->triangles * (GLsizeiptr)sizeof *s->triangle, s->triangle,
                    0x88E4);
    for (GLuint i = 0; i < 3; i++) {
        gl33.EnableVertexAttribArray(i);
        gl33.VertexAttribPointer(i, 3, GL_FLOAT, GL_FALSE, sizeof *v,
                                 (const void *)(i * sizeof(vec3)));
    }
    m->count = 3 * s->triangles;
    free(v);
    return true;
}

void gl33_mesh_draw(const gl33_mesh *m)
{
    gl33.BindVertexArray(m->array);
    gl33.DrawElements(GL_TRIANGLES, m->count, GL_UNSIGNED_INT, NULL);
}

// ---- Programs

const char gl33_scene_vertex[] = "uniform mat4 world_to_clip;\n"
                                 "layout(location = 0) in vec3 position_in;\n"
                                 "layout(location = 1) in vec3 normal_in;\n"
                                 "layout(location = 2) in vec3 albedo_in;\n"
                                 "out vec3 position, normal, albedo;\n"
                                 "void main()\n"
                                 "{\n"
                                 "    position = position_in;\n"
                                 "    normal = normal_in;\n"
                                 "    albedo = albedo_in;\n"
                                 "    gl_Position = world_to_clip * vec4(position_in, 1.0);\n"
                                 "}\n";

GLuint gl33_shader(GLenum type, const char *version, const char *const *text, char *log,
                   GLsizei room)
{
    const char *piece[16] = {version};
    GLsizei pieces = 1;
    GLint compiled = 0;
    while (*text && pieces < 16) piece[pieces++] = *text++;
    const GLuint shader = gl33.CreateShader(type);
    gl33.ShaderSource(shader, pieces, piece, NULL);
    gl33.CompileShader(shader);
    gl33.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    log[0] = 0;
    gl33.GetShaderInfoLog(shader, room, NULL, log);
    if (compiled) return shader;
    gl33.DeleteShader(shader);
    return 0;
}

static bool attach(GLuint program, GLenum type, const char *version, const char *const *text,
                   message *why)
{
    char log[200];
    const GLuint shader = gl33_shader(type, version, text, log, sizeof log);
    if (!shader) return fail(why, "%.13s: %s", version, log);
    gl33.AttachShader(program, shader);
    gl33.DeleteShader(shader); // the program keeps it
    return true;
}

GLuint gl33_program(const char *version, const char *vertex, const char *const *fragment,
                    message *why)
{
    const char *const vertices[] = {vertex, NULL};
    const GLuint program = gl33.CreateProgram();
    GLint linked = 0;
    char log[200] = "";
    if (attach(program, GL_VERTEX_SHADER, version, vertices, why) &&
        attach(program, GL_FRAGMENT_SHADER, version, fragment, why)) {
        gl33.LinkProgram(program);
        gl33.GetProgramiv(program, GL_LINK_STATUS, &linked);
        gl33.GetProgramInfoLog(program, sizeof log, NULL, log);
        if (linked) return program;
        fail(why, "%.13s: %s", version, log);
    }
    gl33.DeleteProgram(program);
    return 0;
}

// ---- Pictures

// In place of the one before. Returns its name, or 0.
static GLuint framebuffer(int which, GLenum target, int samples, int width, int height)
{
    const GLenum formats[2] = {GL_RGBA32F, GL_DEPTH_COMPONENT32F};
    const GLenum attachments[2] = {GL_COLOR_ATTACHMENT0, GL_DEPTH_ATTACHMENT};
    GLuint *name = &targets[which].name, *buffers = targets[which].buffers;
    gl33.DeleteFramebuffers(1, name);
    gl33.DeleteRenderbuffers(2, buffers);
    gl33.GenFramebuffers(1, name);
    gl33.BindFramebuffer(target, *name);
    gl33.GenRenderbuffers(2, buffers);
    for (int i = 0; i < 2; i++) {
        gl33.BindRenderbuffer(GL_RENDERBUFFER, buffers[i]);
        gl33.RenderbufferStorageMultisample(GL_RENDERBUFFER, samples, formats[i], width, height);
        gl33.FramebufferRenderbuffer(target, attachments[i], GL_RENDERBUFFER, buffers[i]);
    }
    return gl33.CheckFramebufferStatus(target) == GL_FRAMEBUFFER_COMPLETE ? *name : 0;
}

bool gl33_target_begin(int width, int height, int samples, message *why)
{
    if (!framebuffer(0, GL_FRAMEBUFFER, samples, width, height))
        return fail(why, "no framebuffer of floats");
    gl33.Viewport(0, 0, width, height);
    gl33.ClearColor(0, 0, 0, 0);
    gl33.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    gl33.Enable(GL_DEPTH_TEST);
    return true;
}

bool gl33_target_read(int width, int height, image *out, message *why)
{
    float *pixels = malloc((size_t)width * (size_t)height * 4 * sizeof *pixels);
    const GLuint mean = framebuffer(1, GL_DRAW_FRAMEBUFFER, 0, width, height);
    const bool good = pixels && mean && image_create(out, width, height);
    if (good) {
        gl33.BlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT,
                             GL_NEAREST);
        gl33.BindFramebuffer(GL_READ_FRAMEBUFFER, mean);
        gl33.ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, pixels);
        for (int i = 0; i < width * height; i++) // row 0 is at the bottom in GL
            image_set(out, i % width, height - 1 - i / width, vec_of(pixels + (size_t)i * 4));
    }
    free(pixels);
    return good || fail(why, "no memory for a picture of %d x %d", width, height);
}

// How much nearer than the far end, so that 0 is nothing hit.
static const char depth_fragment[] = "in vec3 position, normal, albedo;\n"
                                     "out vec4 color;\n"
                                     "void main() { color = vec4(2.0 - 2.0 * gl_FragCoord.z); }\n";

bool gl33_depth(const char *version, const gl33_mesh *m, const float world_to_shadow[16], int side,
                int samples, float *depth, message *why)
{
    const char *const fragments[] = {depth_fragment, NULL};
    const GLuint program = gl33_program(version, gl33_scene_vertex, fragments, why);
    bool good = program != 0;
    gl33.UseProgram(program);
    for (int s = 0; s < samples && good; s++) {
        float moved[16], x, y;
        image map;
        memcpy(moved, world_to_shadow, sizeof moved);
        raster_sample_position(samples, s, &x, &y);
        moved[12] += (1 - 2 * x) / (float)side; // w is 1
        moved[13] += (1 - 2 * y) / (float)side;
        good = gl33_target_begin(side, side, 0, why);
        if (good) {
            gl33.UniformMatrix4fv(gl33.GetUniformLocation(program, "world_to_clip"), 1, GL_FALSE,
                                  moved);
            gl33_mesh_draw(m);
        }
        good = good && gl33_target_read(side, side, &map, why);
        for (int i = 0; i < side * side && good; i++)
            depth[i * samples + s] = 1 - image_get(&map, i % side, side - 1 - i / side).x;
        if (good) image_free(&map);
    }
    if (program) gl33.DeleteProgram(program);
    return good;
}
