// Several objects of the OpenGL half in one shader: soft ones of different side, moments and
// settings, filtered ones, and the texts of both headers, in any order.
#include "../support/gl_fakes.h"
#include "../support/gl_test.h"
#include "../support/test.h"

#include "../../lightprobe.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../examples/common/gl_draw.h"

enum { SIDE = 64, OBJECTS = 4, TEXELS = SIDE * SIDE };

static struct {
    gl_context context;
    gl_mesh triangle;
    GLuint fill;
    mssm_gl *object[OBJECTS];
} stage;

// What each adds to the picture, and what stands for it where it is left out.
static const char *const calls[OBJECTS] = {
    "mssm_visibility(0, p)", "lamp(1, p, vec3(0, 1, 0))",
    "mssm_filtered_visibility(0, p, vec3(0), vec3(0))",
    "tree_shadow_bounds(0, p, vec3(0.1, 0, 0), vec3(0)).lower"};
static const char probe[] = "float(lightprobe_count)";

// clang-format off
static const char fill_fragment[] =
    "void main()\n"
    "{\n"
    "    ivec2 p = ivec2(gl_FragCoord.xy) / 8;\n"
    "    gl_FragDepth = 0.1 * float((3 * p.x + 5 * p.y) % 11);\n"
    "}\n";
static const char picture[] =
    "in vec2 place;\n"
    "layout(location = 0) out vec4 color;\n"
    "layout(location = 1) out vec4 others;\n"
    "void main()\n"
    "{\n"
    "    vec3 p = vec3(2.0 * place.x - 1.0, -0.8, 2.0 * place.y - 1.0);\n"
    "    color = vec4(FIRST, SECOND, THIRD, FOURTH);\n"
    "    others = vec4(FIFTH);\n"
    "}\n";
// clang-format on

static mssm_gl_desc description(int unit, int binding)
{
    mssm_gl_desc d;
    memset(&d, 0, sizeof d);
    d.load = gl_fakes_load;
    d.lights = 2;
    d.first_texture_unit = unit;
    d.first_buffer_binding = binding;
    d.log = gl_fakes_log;
    d.user = &fakes;
    return d;
}

static void draw_maps(mssm_gl *g, const mssm_light *light)
{
    for (int i = 0; i < 2; i++) {
        CHECK(!mssm_gl_set_light(g, i, light) && !mssm_gl_begin_depth(g, i, 0), "begin");
        gl_mesh_draw(&stage.triangle);
        CHECK(!mssm_gl_end_depth(g), "end");
    }
    CHECK(!mssm_gl_build(g) && !mssm_gl_bind(g), "build");
}

static bool begin(void)
{
    const float to_light[3] = {0.2f, 0.9f, 0.3f}, axis[3] = {1, 0, 0};
    const float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};
    char name[] = "lamp"; // not kept
    message why;
    mssm_light light;
    gl_fakes_reset();
    gl_fakes_forget_living();
    memset(&stage, 0, sizeof stage);
    if (!gl_test_begin(&stage.context)) return false;
    gl_fakes_watch();
    gl_mesh_triangle(&stage.triangle);
    stage.fill = gl_program_simple("fill", gl_triangle_vertex, fill_fragment, &why);
    CHECK(stage.fill && !mssm_light_directional(&light, to_light, axis, 0.1f, 0.1f, low, high),
          "stage");
    mssm_gl_desc d[OBJECTS] = {description(20, 0), description(3, 4), description(23, 0),
                               description(10, 5)};
    d[0].side = SIDE;
    d[1].side = SIDE / 2;
    d[1].moments = 4;
    d[1].settings.estimator = MSSM_LOWER_BLOCKER;
    d[1].name = name;
    d[2].filtered = 1;
    d[2].side = 2 * SIDE;
    d[3].filtered = 1;
    d[3].side = SIDE;
    d[3].moments = 6;
    d[3].radius = 5;
    d[3].name = "tree_shadow";
    for (int i = 0; i < OBJECTS; i++)
        CHECK(!mssm_gl_create(&stage.object[i], &d[i]), "%d: %s", i, fakes.message);
    memset(name, '?', sizeof name);
    gl.UseProgram(stage.fill);
    for (int i = 0; i < OBJECTS && stage.object[i]; i++) draw_maps(stage.object[i], &light);
    return stage.object[OBJECTS - 1] != NULL;
}

static void end(void)
{
    char text[200];
    for (int i = 0; i < OBJECTS; i++) mssm_gl_destroy(stage.object[i]);
    CHECK(!gl_fakes_living(false, text, sizeof text), "left:%s", text);
    CHECK(!gl_fakes_living_memory(), "memory left");
    CHECK(gl.GetError() == GL_NO_ERROR, "GL error");
    CHECK(!fakes.debug_messages, "the driver said: %s", fakes.debug_message);
    CHECK(!fakes.bad_logs, "%d shaders or programs with a log", fakes.bad_logs);
    gl_context_destroy(&stage.context);
    gl_fakes_reset();
}

// The texts of the objects in an order, the last of them the probe's, and a picture of those in the
// set.
static char *write_text(const int order[OBJECTS + 1], int set)
{
    static const char *const places[OBJECTS + 1] = {"FIRST", "SECOND", "THIRD", "FOURTH", "FIFTH"};
    static char text[1 << 20];
    strcpy(text, "#version 450 core\n");
    for (int i = 0; i <= OBJECTS; i++) {
        if (!(set >> order[i] & 1)) continue;
        if (order[i] < OBJECTS)
            strcat(text, mssm_gl_shader(stage.object[order[i]]));
        else
            strcat(strcat(text, lightprobe_glsl_math()), lightprobe_glsl_lights());
    }
    for (int i = 0; i <= OBJECTS; i++) {
        const char *what = !(set >> i & 1) ? "0.0" : i < OBJECTS ? calls[i] : probe;
        sprintf(text + strlen(text), "#define %s %s\n", places[i], what);
    }
    return strcat(text, picture);
}

static bool compiles(const char *const *pieces, int count, char log[600])
{
    GLint good = 0;
    const GLuint shader = gl.CreateShader(GL_FRAGMENT_SHADER);
    gl.ShaderSource(shader, count, pieces, NULL);
    gl.CompileShader(shader);
    gl.GetShaderiv(shader, GL_COMPILE_STATUS, &good);
    log[0] = 0;
    gl.GetShaderInfoLog(shader, 600, NULL, log);
    gl.DeleteShader(shader);
    return good;
}

// Both colours of the picture.
static void draw(const char *text, float *values)
{
    const GLenum formats[GL_TARGET_COLORS] = {GL_RGBA32F, GL_RGBA32F};
    const char *const vertex[] = {gl_triangle_vertex, NULL};
    const char *const fragment[] = {strchr(text, '\n') + 1, NULL};
    gl_target target;
    message why = {""};
    const GLuint program = gl_program("several", vertex, fragment, &why);
    CHECK(program && gl_target_create(&target, SIDE, SIDE, 1, formats, &why), "%s", why.text);
    if (!program) return;
    gl_target_begin(&target);
    gl.UseProgram(program);
    gl_mesh_draw(&stage.triangle);
    for (int i = 0; i < 2; i++) {
        gl.GetTextureImage(target.color[i], 0, GL_RGBA, GL_FLOAT, TEXELS * 16,
                           values + i * TEXELS * 4);
    }
    gl.UseProgram(0);
    gl.DeleteProgram(program);
    gl_target_free(&target);
}

static void validate(const char *text)
{
    FILE *f = system("command -v glslangValidator >/dev/null 2>&1")
                  ? NULL
                  : fopen("build/several.frag", "w");
    if (!f) {
        CHECK(!getenv("TEST_REQUIRE_GL"), "no glslangValidator: apt-get install glslang-tools");
        return;
    }
    fputs(text, f);
    fclose(f);
    CHECK(!system("glslangValidator build/several.frag >build/several.log 2>&1"),
          "see build/several.log");
}

static void pictures_are_those_of_each_alone(void)
{
    static float alone[TEXELS * 8], together[2][TEXELS * 8];
    const int orders[2][OBJECTS + 1] = {{0, 1, 2, 3, 4}, {4, 3, 2, 1, 0}};
    GLuint lights;
    if (!begin()) return;
    gl.CreateBuffers(1, &lights);
    const int count[300] = {77};
    gl.NamedBufferStorage(lights, sizeof count, count, 0);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, lights);
    for (int i = 0; i < 2; i++) {
        const char *text = write_text(orders[i], 31);
        draw(text, together[i]);
        validate(text);
    }
    for (int k = 0; k <= OBJECTS; k++) {
        float worst = 0, least = 2, most = -1;
        draw(write_text(orders[0], 1 << k), alone);
        for (int i = 0; i < TEXELS; i++) {
            const int at = k < OBJECTS ? 4 * i + k : 4 * TEXELS + 4 * i;
            for (int turn = 0; turn < 2; turn++)
                worst = fmaxf(worst, fabsf(together[turn][at] - alone[at]));
            least = fminf(least, alone[at]);
            most = fmaxf(most, alone[at]);
        }
        CHECK(worst <= 1e-5f, "object %d: a picture differs by %g", k, (double)worst);
        CHECK(k == OBJECTS ? most == 77 : least < 0.1f && most > 0.9f, "object %d: from %g to %g",
              k, (double)least, (double)most);
    }
    gl.DeleteBuffers(1, &lights);
    end();
}

// All orders of the five, each followed by every other text of mssm.h, which come first in every
// second.
static void texts_come_in_any_order(void)
{
    char log[600];
    int tried = 0;
    if (!begin()) return;
    for (int n = 0; n < 120; n += test_trials(100) < 50 ? 31 : 7) {
        int order[OBJECTS + 1], left[OBJECTS + 1] = {0, 1, 2, 3, 4}, rest = n;
        for (int i = 0; i <= OBJECTS; i++) {
            const int at = rest % (OBJECTS + 1 - i);
            rest /= OBJECTS + 1 - i;
            order[i] = left[at];
            for (int k = at; k < OBJECTS; k++) left[k] = left[k + 1];
        }
        char *text = write_text(order, 31), *body = text + strlen(text) - strlen(picture);
        static char head[1 << 20];
        memcpy(head, text, (size_t)(body - text));
        head[body - text] = 0;
        static const char query[] =
            "mssm_moments6 mssm_query(int map, int moments, float x, float y, float half_x, float half_y)\n"
            "{ return mssm_moments6_of_depth(0.5); }\n";
        const char *const others[] = {
            mssm_glsl_math(),    mssm_glsl_shading(), query,
            mssm_glsl_shading(), mssm_glsl_lights(),  mssm_glsl_scattering(),
            mssm_glsl_lights()};
        const char *pieces[10] = {"#version 450 core\n"};
        int count = 1;
        if (n % 2 == 0) pieces[count++] = strchr(head, '\n') + 1;
        for (int i = 0; i < 7; i++) pieces[count++] = others[i];
        if (n % 2) pieces[count++] = strchr(head, '\n') + 1;
        pieces[count++] = picture;
        CHECK(compiles(pieces, count, log) && gl_test_quiet(log), "order %d%d%d%d%d: %s", order[0],
              order[1], order[2], order[3], order[4], log);
        tried++;
    }
    test_note("%d orders", tried);
    end();
}

// What the compiler says of the texts of two objects.
static void collide(mssm_gl_desc first, mssm_gl_desc second, const char *expected)
{
    mssm_gl *g[2] = {NULL, NULL};
    char log[600];
    CHECK(!mssm_gl_create(&g[0], &first) && !mssm_gl_create(&g[1], &second), "%s", fakes.message);
    if (g[1]) {
        const char *const pieces[] = {"#version 450 core\n", mssm_gl_shader(g[0]),
                                      mssm_gl_shader(g[1]), "void main() {}\n"};
        const bool good = compiles(pieces, 4, log);
        CHECK(good == !expected && (good || strstr(log, expected)), "%s: %s",
              expected ? expected : "nothing", log);
    }
    mssm_gl_destroy(g[0]);
    mssm_gl_destroy(g[1]);
}

static void collisions_are_named(void)
{
    if (!begin()) return;
    gl.DebugMessageCallback(NULL, NULL); // most of it does not compile, and must not
    mssm_gl_desc a = description(3, 3), b = description(6, 4);
    a.side = b.side = 32;
    collide(a, b, "two mssm_gl declare mssm_visibility");
    b.name = "mssm_visibility";
    collide(a, b, "two mssm_gl declare mssm_visibility");
    a.name = b.name = "sun";
    collide(a, b, "two mssm_gl declare sun");
    b.name = "lamp";
    collide(a, b, NULL);
    b.first_texture_unit = 5;
    collide(a, b, "first_texture_unit: 5 of lamp");
    a.moments = 4; // unit 4 is not used
    b.first_texture_unit = 4;
    collide(a, b, "first_texture_unit: 5 of lamp");
    b.first_texture_unit = 6;
    b.first_buffer_binding = 3;
    collide(a, b, "first_buffer_binding: 3 of lamp");
    a.filtered = 1;
    a.moments = 6;
    b.first_buffer_binding = 4;
    b.first_texture_unit = 5;
    collide(a, b, NULL);
    b.first_texture_unit = 4;
    collide(a, b, "first_texture_unit: 4 of lamp");
    fakes.debug_messages = fakes.bad_logs = 0;
    end();
}

static void names_are_checked(void)
{
    static const char *const bad[] = {
        "",     "2a",
        "a__b", "gl_x",
        "_a",   "a_",
        "a b",  "a-b",
        "a.b",  "\xc3\xa9t\xc3\xa9",
        "a\n",  "a2345678901234567890123456789012345678901234567890123456789012345"};
    static const char *const good[] = {
        "a",   "Z9",       "a_b_2c",
        "gla", "mssm_sun", "a234567890123456789012345678901234567890123456789012345678901234"};
    char log[600], body[200];
    if (!begin()) return;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        mssm_gl_desc d = description(5, 3);
        mssm_gl *g = NULL;
        d.name = bad[i];
        fakes.messages = 0;
        CHECK(mssm_gl_create(&g, &d) == MSSM_ERROR_ARGUMENT && !g, "\"%s\" is taken", bad[i]);
        CHECK(fakes.messages == 1 && strstr(fakes.message, "name "), "\"%s\": \"%s\"", bad[i],
              fakes.message);
    }
    for (size_t i = 0; i < 2 * sizeof good / sizeof *good; i++) {
        mssm_gl_desc d = description(5, 3);
        mssm_gl *g = NULL;
        const char *const name = d.name = good[i / 2];
        d.filtered = i % 2;
        d.side = 16;
        CHECK(!mssm_gl_create(&g, &d), "\"%s\": %s", name, fakes.message);
        if (!g) continue;
        snprintf(body, sizeof body,
                 d.filtered ? "void main() { gl_FragDepth = %s(0, vec3(0), vec3(0), vec3(0)); }\n"
                            : "void main() { gl_FragDepth = %s_at(0, vec3(0)); }\n",
                 name);
        const char *const pieces[] = {"#version 450 core\n", mssm_gl_shader(g), body};
        CHECK(compiles(pieces, 3, log), "\"%s\": %s", name, log);
        CHECK(!mssm_gl_resize(g, 3, 24), "resize of \"%s\"", name);
        mssm_gl_destroy(g);
    }
    end();
}

const test_case names_gl_tests[] = {
    {"names GL: the picture of several objects is that of each alone",
     pictures_are_those_of_each_alone},
    {"names GL: texts come in any order", texts_come_in_any_order},
    {"names GL: collisions are named", collisions_are_named},
    {"names GL: names are checked", names_are_checked},
    {0, 0}};
