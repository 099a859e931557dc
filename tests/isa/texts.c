#include "texts.h"

#include <stdio.h>
#include <string.h>

#include "../../lightprobe.h"

// ---- A driver that notes texts and does nothing else ----
// Functions that are not below take any arguments and return 0.

static char source[TEXTS_ROOM]; // the last one
static struct {
    const char *label;
    char *text;
} wanted; // program

static int nothing(void)
{
    return 0;
}

static void get_integer(GLenum name, int *value)
{
    (void)name;
    *value = 1 << 24; // limits, and a version that is new enough
}

static const unsigned char *get_string(GLenum name)
{
    (void)name;
    return (const unsigned char *)"4.5, of nothing";
}

static void create(int count, GLuint *names)
{
    for (int i = 0; i < count; i++) names[i] = 1;
}

static void create_textures(GLenum target, int count, GLuint *names)
{
    (void)target;
    create(count, names);
}

static GLuint create_one(void)
{
    return 1;
}

static void is_good(GLuint name, GLenum what, int *value)
{
    (void)name;
    (void)what;
    *value = 1;
}

static GLenum is_complete(GLuint name, GLenum target)
{
    (void)name;
    (void)target;
    return GL_FRAMEBUFFER_COMPLETE;
}

static void *map_buffer(void)
{
    static char bytes[1 << 20];
    return bytes;
}

static void shader_source(GLuint shader, int count, const char *const *pieces, const int *lengths)
{
    (void)shader;
    (void)lengths;
    source[0] = 0;
    for (int i = 0; i < count; i++) {
        snprintf(source + strlen(source), sizeof source - strlen(source), "%s", pieces[i]);
    }
}

static void object_label(GLenum kind, GLuint name, int length, const char *label)
{
    (void)name;
    (void)length;
    if (kind == GL_PROGRAM && wanted.label && !strcmp(label, wanted.label)) {
        memcpy(wanted.text, source, strlen(source) + 1);
        wanted.label = NULL;
    }
}

typedef void (*function)(void);

static function load(const char *name)
{
    static const struct {
        const char *name;
        function f;
    } known[] = {{"glGetIntegerv", (function)get_integer},
                 {"glGetString", (function)get_string},
                 {"glCreateTextures", (function)create_textures},
                 {"glCreateShader", (function)create_one},
                 {"glCreateProgram", (function)create_one},
                 {"glGetShaderiv", (function)is_good},
                 {"glGetProgramiv", (function)is_good},
                 {"glCheckNamedFramebufferStatus", (function)is_complete},
                 {"glShaderSource", (function)shader_source},
                 {"glObjectLabel", (function)object_label}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        if (!strcmp(known[i].name, name)) return known[i].f;
    }
    if (!strncmp(name, "glCreate", 8)) return (function)create;
    return strncmp(name, "glMap", 5) ? (function)nothing : (function)map_buffer;
}

// ---- Texts ----

static bool wrap(char *text, const char *visibility, const char *call)
{
    const int length = snprintf(text, TEXTS_ROOM,
                                "#version 450 core\n%s\n"
                                "layout(local_size_x = 8, local_size_y = 8) in;\n"
                                "layout(binding = 0) uniform sampler2D positions;\n"
                                "layout(binding = 0, r32f) writeonly uniform image2D result;\n"
                                "uniform int light;\n"
                                "vec3 at(ivec2 p) { return texelFetch(positions, p, 0).xyz; }\n"
                                "void main()\n"
                                "{\n"
                                "    ivec2 p = ivec2(gl_GlobalInvocationID.xy);\n"
                                "    vec3 position = at(p);\n"
                                "    imageStore(result, p, vec4(%s));\n"
                                "}\n",
                                visibility, call);
    return visibility[0] && length > 0 && length < TEXTS_ROOM;
}

static const char plain_call[] = "mssm_visibility(light, position)";
static const char normal_call[] = "mssm_visibility(light, position, at(p + ivec2(0, 1)))";

bool texts_layered(char *text, int moments, const mssm_settings *settings)
{
    const mssm_gl_desc desc = {
        .load = load, .moments = moments, .settings = *settings, .first_texture_unit = 8};
    mssm_gl *maps;
    if (mssm_gl_create(&maps, &desc)) return false;
    const bool normal = settings->estimator == MSSM_HORIZON;
    const bool good = wrap(text, mssm_gl_shader(maps), normal ? normal_call : plain_call);
    mssm_gl_destroy(maps);
    return good;
}

bool texts_filtered(char *text, int moments)
{
    const mssm_gl_desc desc = {
        .load = load, .filtered = 1, .moments = moments, .first_texture_unit = 8};
    mssm_gl *maps;
    if (mssm_gl_create(&maps, &desc)) return false;
    const bool good = wrap(text, mssm_gl_shader(maps),
                           "mssm_filtered_visibility(light, position, at(p + ivec2(1, 0)) - "
                           "position, at(p + ivec2(0, 1)) - position)");
    mssm_gl_destroy(maps);
    return good;
}

bool texts_reference(char *text, gl_reference_kind kind)
{
    char visibility[GL_REFERENCE_TEXT];
    gl_reference_visibility(kind, visibility, sizeof visibility);
    return wrap(text, visibility, plain_call);
}

bool texts_samples(char *text, gl_percentage_closer_kind kind)
{
    static const char pixel[] = "#define PIXEL vec2(gl_GlobalInvocationID.xy)\n";
    char visibility[GL_PERCENTAGE_CLOSER_TEXT + sizeof pixel];
    memcpy(visibility, pixel, sizeof pixel);
    gl_percentage_closer_visibility(kind, visibility + sizeof pixel - 1, GL_PERCENTAGE_CLOSER_TEXT);
    return wrap(text, visibility, gl_percentage_closer_normal(kind) ? normal_call : plain_call);
}

bool texts_convolution(char *text, gl_convolution_filter filter, int terms)
{
    char visibility[GL_CONVOLUTION_TEXT];
    gl_convolution_visibility(filter, terms, NULL, visibility, sizeof visibility);
    return wrap(text, visibility, plain_call);
}

bool texts_kernel(char *text, const char *label, int moments)
{
    const mssm_gl_desc maps_desc = {.load = load, .moments = moments};
    const lightprobe_gl_desc lights_desc = {.load = load};
    mssm_gl *maps;
    lightprobe_gl *lights;
    wanted.label = label;
    wanted.text = text;
    if (mssm_gl_create(&maps, &maps_desc)) return false;
    mssm_gl_destroy(maps);
    if (lightprobe_gl_create(&lights, &lights_desc)) return false;
    lightprobe_gl_destroy(lights);
    return !wanted.label;
}
