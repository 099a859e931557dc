// The OpenGL half of filtered shadows and translucent casters: the numbers of the CPU half,
// whatever state the caller is in, whatever fails, and nothing left behind.
#include "../support/gl_fakes.h"
#include "../support/gl_state.h"
#include "../support/gl_test.h"
#include "../support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "../../examples/common/gl_draw.h"

enum { SIDE = 64, SAMPLES = 4, POINTS = 512, LAYERS = 5 };

static struct {
    gl_context context;
    gl_mesh triangle;
    GLuint fill, layer;
    float depth[SIDE * SIDE * SAMPLES]; // in [-1,1]
    mssm_light light;
} stage;

// clang-format off
static const char fill_fragment[] =
    "layout(std430, binding = 7) readonly buffer depths { float depth[]; };\n"
    "void main()\n"
    "{\n"
    "    ivec2 p = ivec2(gl_FragCoord.xy);\n"
    "    gl_FragDepth = depth[(p.y * 64 + p.x) * 4 + gl_SampleID];\n"
    "}\n";
static const char layer_fragment[] =
    "uniform float depth, opacity;\n"
    "void main() { gl_FragDepth = 0.5 + 0.5 * depth; mssm_translucent(depth, opacity); }\n";
static const char asking[] =
    "layout(local_size_x = 64) in;\n"
    "layout(std430, binding = 8) readonly buffer points { vec4 point[]; };\n"
    "layout(std430, binding = 9) writeonly buffer results { float result[]; };\n";
// clang-format on

static bool begin(void)
{
    const float to_light[3] = {0.2f, 0.9f, 0.3f}, axis[3] = {1, 0, 0};
    const float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};
    message why;
    gl_fakes_reset();
    gl_fakes_forget_living();
    if (!gl_test_begin(&stage.context)) return false;
    gl_fakes_watch();
    gl_mesh_triangle(&stage.triangle);
    const char *const vertices[] = {gl_triangle_vertex, NULL};
    const char *const fragments[] = {mssm_glsl_math(), mssm_glsl_translucent(), layer_fragment,
                                     NULL};
    stage.fill = gl_program_simple("fill", gl_triangle_vertex, fill_fragment, &why);
    stage.layer = gl_program("layer", vertices, fragments, &why);
    CHECK(stage.fill && stage.layer, "%s", why.text);
    CHECK(!mssm_light_directional(&stage.light, to_light, axis, 0.1f, 0.1f, low, high), "light");
    uint64_t seed = 71;
    for (int i = 0; i < SIDE * SIDE; i++) { // patches of 8 x 8 at depths of their own
        static float patch[64];
        const int at = i % SIDE / 8 + i / SIDE / 8 * 8;
        if (i % 8 == 0 && i / SIDE % 8 == 0) patch[at] = (float)test_range(&seed, -0.9, 0.8);
        for (int s = 0; s < SAMPLES; s++) {
            stage.depth[i * SAMPLES + s] = patch[at] + 0.002f * (float)(i % 8 + s);
        }
    }
    return true;
}

static void end(void)
{
    char text[200];
    CHECK(!gl_fakes_living(false, text, sizeof text), "left:%s", text);
    CHECK(!gl_fakes_living_memory(), "memory left");
    CHECK(gl.GetError() == GL_NO_ERROR, "GL error");
    CHECK(!fakes.debug_messages, "the driver said: %s", fakes.debug_message);
    CHECK(!fakes.unwatched, "%s is not watched by gl_fakes.c", fakes.unwatched_name);
    CHECK(!fakes.bad_logs, "%d shaders or programs with a log", fakes.bad_logs);
    gl_context_destroy(&stage.context);
    gl_fakes_reset();
}

static mssm_gl_desc description(int moments, int radius)
{
    mssm_gl_desc d;
    memset(&d, 0, sizeof d);
    d.load = gl_fakes_load;
    d.lights = 2;
    d.filtered = 1;
    d.side = SIDE;
    d.samples = SAMPLES;
    d.moments = moments;
    d.radius = radius;
    d.first_texture_unit = 3;
    d.first_buffer_binding = 4;
    d.log = gl_fakes_log;
    d.user = &fakes;
    return d;
}

static GLuint buffer_of(const void *data, size_t bytes, GLuint binding)
{
    GLuint buffer;
    gl.CreateBuffers(1, &buffer);
    gl.NamedBufferStorage(buffer, (GLsizeiptr)bytes, data, 0);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer);
    return buffer;
}

static void draw_depth(mssm_gl *g, int index)
{
    static float window[SIDE * SIDE * SAMPLES];
    for (int i = 0; i < SIDE * SIDE * SAMPLES; i++) window[i] = 0.5f + 0.5f * stage.depth[i];
    const GLuint buffer = buffer_of(window, sizeof window, 7);
    CHECK(!mssm_gl_set_light(g, index, &stage.light), "set_light");
    CHECK(!mssm_gl_begin_depth(g, index, 0), "begin");
    gl.UseProgram(stage.fill);
    gl_mesh_draw(&stage.triangle);
    CHECK(!mssm_gl_end_depth(g), "end");
    gl.UseProgram(0);
    gl.DeleteBuffers(1, &buffer);
}

// Layers over all of the map, from far to near.
static const float layer_depth[LAYERS] = {0.6f, 0.3f, -0.1f, -0.4f, -0.8f};
static const float layer_opacity[LAYERS] = {0.3f, 0.02f, 0.5f, 0.1f, 0.25f};

static void draw_layers(mssm_gl *g)
{
    CHECK(!mssm_gl_begin_translucent(g), "begin");
    gl.Enable(GL_BLEND);
    gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    gl.UseProgram(stage.layer);
    for (int i = 0; i < LAYERS; i++) {
        gl.ProgramUniform1f(stage.layer, gl.GetUniformLocation(stage.layer, "depth"),
                            layer_depth[i]);
        gl.ProgramUniform1f(stage.layer, gl.GetUniformLocation(stage.layer, "opacity"),
                            layer_opacity[i]);
        gl_mesh_draw(&stage.triangle);
    }
    CHECK(!mssm_gl_end_translucent(g), "end");
    gl.Disable(GL_BLEND);
    gl.UseProgram(0);
}

// Answers at points (world position, and the footprint in w), by a text that declares ask(vec4).
static void ask_gl(const char *shader, const char *ask, const float *point, float *result)
{
    const char *const text[] = {asking, shader, ask,
                                "void main() { uint i = gl_GlobalInvocationID.x;\n"
                                "    result[i] = ask(point[i]); }\n",
                                NULL};
    const GLuint program = gl_test_compute("asking", text);
    const GLuint points = buffer_of(point, POINTS * 16, 8),
                 results = buffer_of(NULL, POINTS * 4, 9);
    gl.UseProgram(program);
    gl.DispatchCompute(POINTS / 64, 1, 1);
    gl.MemoryBarrier(0xFFFFFFFFu);
    gl.GetNamedBufferSubData(results, 0, POINTS * 4, result);
    gl.UseProgram(0);
    gl.DeleteBuffers(1, &points);
    gl.DeleteBuffers(1, &results);
    gl.DeleteProgram(program);
}

static void random_points(float *point, uint64_t seed)
{
    for (int i = 0; i < POINTS; i++) {
        for (int k = 0; k < 3; k++) point[4 * i + k] = (float)test_range(&seed, -1.2, 1.2);
        point[4 * i + 3] = i % 2 ? 0 : (float)test_range(&seed, 0.02, 0.3);
    }
}

static mssm_filtered *cpu_map(void **memory, int side, int moments)
{
    const size_t bytes = mssm_filtered_bytes(side, moments);
    mssm_filtered *map = NULL;
    *memory = malloc(bytes);
    CHECK(!mssm_filtered_init(&map, *memory, bytes, side, moments), "init");
    return map;
}

// Texels that the texture of light 1 has beyond the map, on all levels, are the map's outermost.
static void repeats_its_rim(const mssm_gl *g, int side)
{
    static float texel[2 * SIDE * SIDE * 4];
    int wrong = 0;
    for (int level = 0, size = side; level < 3; level++, size = (size + 1) / 2) {
        const int stride = (side + 3) / 4 * 4 >> level;
        gl.GetTextureImage(mssm_gl_texture(g, 0), level, GL_RGBA, GL_FLOAT, sizeof texel, texel);
        for (int i = 0; i < stride * stride; i++) {
            const int x = i % stride, y = i / stride;
            const int inside = (y < size ? y : size - 1) * stride + (x < size ? x : size - 1);
            const float *layer = texel + stride * stride * 4;
            wrong += memcmp(layer + 4 * i, layer + 4 * inside, 4 * sizeof *layer) != 0;
        }
    }
    CHECK(!wrong, "%d texels, %d texels beyond the map are none of its rim", side, wrong);
}

static void same_as_cpu(int side, int moments, int radius)
{
    static float point[POINTS * 4], result[POINTS], depth[SIDE * SIDE * SAMPLES];
    mssm_gl_desc desc = description(moments, radius);
    mssm_gl *g = NULL;
    void *memory;
    mssm_filtered *map = cpu_map(&memory, side, moments);
    for (int i = 0; i < side * side * SAMPLES; i++) {
        const int row = i / SAMPLES / side;
        depth[i] = stage.depth[i + row * (SIDE - side) * SAMPLES];
    }
    desc.side = side;
    // A square footprint that faces the light: along the rows of its matrix.
    const float *m = stage.light.world_to_shadow;
    char ask[500];
    const double u = sqrt(m[0] * m[0] + m[4] * m[4] + m[8] * m[8]),
                 v = sqrt(m[1] * m[1] + m[5] * m[5] + m[9] * m[9]);
    snprintf(ask, sizeof ask,
             "float ask(vec4 p) { return mssm_filtered_visibility(1, p.xyz, p.w * vec3(%.9g, %.9g, "
             "%.9g),"
             " p.w * vec3(%.9g, %.9g, %.9g)); }\n",
             m[0] / u, m[4] / u, m[8] / u, m[1] / v, m[5] / v, m[9] / v);
    CHECK(!mssm_gl_create(&g, &desc), "create: %s", fakes.message);
    if (!g) return;
    draw_depth(g, 1);
    CHECK(!mssm_gl_build(g), "build");
    CHECK(!mssm_gl_bind(g), "bind");
    repeats_its_rim(g, side);
    CHECK(!mssm_filtered_update(map, depth, SAMPLES, radius < 0 ? 0 : radius), "update");
    random_points(point, 72);
    ask_gl(mssm_gl_shader(g), ask, point, result);
    double worst = 0, mean = 0;
    int shadowed = 0;
    for (int i = 0; i < POINTS; i++) {
        const float cpu =
            mssm_filtered_visibility(map, &stage.light, NULL, point + 4 * i, point[4 * i + 3]);
        worst = fmax(worst, fabs(cpu - result[i]));
        mean += fabs(cpu - result[i]) / POINTS;
        shadowed += cpu > 0.05f && cpu < 0.95f;
    }
    CHECK(shadowed > POINTS / 10, "only %d points in part shadow", shadowed);
    CHECK(mean < 1e-3 && worst < 0.06, "GL differs by %.2g, at worst %.2g", mean, worst);
    test_note("%d texels, %d moments, radius %d: GL differs by %.1e, at worst %.1e", side, moments,
              radius, mean, worst);
    mssm_gl_destroy(g);
    free(memory);
}

static void gl_agrees_with_cpu(void)
{
    if (!begin()) return;
    for (int moments = 4; moments <= 6; moments += 2) {
        same_as_cpu(SIDE, moments, -1);
        same_as_cpu(SIDE, moments, 3);
        same_as_cpu(SIDE - 7, moments, 3); // the texture has three texels more
    }
    end();
}

// A wall closes all of a lamp's cone: behind it all is dark up to the rim, under footprints of any
// length too, whatever number of texels the texture has beyond the map; beside the map all is lit.
static void no_light_from_beyond_the_rim(void)
{
    static const int sides[4] = {SIDE, 61, 33, 1}, radii[2] = {-1, 8};
    static float point[POINTS * 4], result[POINTS];
    const float lamp[3] = {0, 0, 8}, up[3] = {0, 0, 1}, axis[3] = {1, 0, 0};
    if (!begin()) return;
    CHECK(!mssm_light_spot(&stage.light, lamp, up, axis, 0.57735f, 0.5f, 12, 0, 0), "light");
    for (int i = 0; i < SIDE * SIDE * SAMPLES; i++) stage.depth[i] = -1 + 2 * (2 - 0.5f) / 11.5f;
    uint64_t seed = 76;
    for (int i = 0; i < POINTS; i++) {
        const float part = i % 3 ? (float)test_range(&seed, 0.95, 0.9999) : 1.0001f;
        const float u = 8 * 0.57735f * part * (i & 1 ? -1.0f : 1.0f),
                    v = (float)test_range(&seed, -1, 1) * u;
        const float p[4] = {i & 2 ? v : u, i & 2 ? u : v, 0,
                            i & 4 ? 0 : (float)test_range(&seed, 0, 3)};
        memcpy(point + 4 * i, p, sizeof p);
    }
    for (int which = 0; which < 4 * 2 * 2; which++) {
        mssm_gl_desc desc = description(which % 2 ? 6 : 4, radii[which / 2 % 2]);
        mssm_gl *g = NULL;
        desc.side = sides[which / 4];
        desc.anisotropy = 16;
        CHECK(!mssm_gl_create(&g, &desc), "create: %s", fakes.message);
        if (!g) break;
        draw_depth(g, 1);
        CHECK(!mssm_gl_build(g) && !mssm_gl_bind(g), "build");
        ask_gl(mssm_gl_shader(g),
               "float ask(vec4 p) { return mssm_filtered_visibility(1, p.xyz, vec3(p.w, 0.0, 0.0),"
               " vec3(0.0, 0.2 * p.w, 0.0)); }\n",
               point, result);
        for (int i = 0; i < POINTS; i++) {
            CHECK(i % 3 ? result[i] <= 0.001f : result[i] == 1,
                  "%d texels, %d moments, point %d: light %g", desc.side, desc.moments, i,
                  (double)result[i]);
        }
        mssm_gl_destroy(g);
    }
    end();
}

// Moments after opaque casters and layers, with the layers behind an opaque caster left out.
static void blend_on_cpu(float *encoded, int moments)
{
    for (int i = 0; i < SIDE * SIDE; i++) {
        mssm_moments6 m = {{0}};
        for (int s = 0; s < SAMPLES; s++) {
            const mssm_moments6 t = mssm_moments6_of_depth(stage.depth[i * SAMPLES + s]);
            for (int k = 0; k < 6; k++) m.b[k] += t.b[k] / SAMPLES;
        }
        for (int j = 0; j < LAYERS; j++) {
            if (layer_depth[j] >= stage.depth[i * SAMPLES]) continue;
            m = mssm_moments6_blend(m, layer_depth[j], layer_opacity[j]);
        }
        const mssm_moments6 q = mssm_moments6_encode(m);
        memcpy(encoded + i * moments, q.b, (size_t)moments * sizeof(float));
    }
}

static void layers_are_blended_behind_and_before(void)
{
    static float point[POINTS * 4], hard[POINTS], soft[POINTS], encoded[SIDE * SIDE * 6];
    if (!begin()) return;
    const mssm_gl_desc desc = description(6, 2);
    mssm_gl_desc tables;
    mssm_gl *g = NULL;
    mssm_gl *t = NULL;
    void *memory, *soft_memory = malloc(mssm_map_bytes(SIDE, 6));
    mssm_filtered *map = cpu_map(&memory, SIDE, 6);
    mssm_map *soft_map;
    memset(&tables, 0, sizeof tables);
    tables.load = gl_fakes_load;
    tables.side = SIDE;
    tables.first_texture_unit = 3;
    tables.first_buffer_binding = 4;
    tables.log = gl_fakes_log;
    tables.user = &fakes;
    CHECK(!mssm_gl_create(&g, &desc) && !mssm_gl_create(&t, &tables), "%s", fakes.message);
    if (!g || !t) return;
    draw_depth(g, 0);
    draw_layers(g);
    CHECK(!mssm_gl_set_light(t, 0, &stage.light), "light");
    CHECK(!mssm_gl_set_moments(t, 0, mssm_gl_texture(g, 3)), "moments");
    CHECK(!mssm_gl_build(t) && !mssm_gl_build(g), "build");
    blend_on_cpu(encoded, 6);
    CHECK(!mssm_map_init(&soft_map, soft_memory, mssm_map_bytes(SIDE, 6), SIDE, 6), "init");
    CHECK(!mssm_map_update_moments(soft_map, encoded), "soft");
    CHECK(!mssm_filtered_update_moments(map, encoded, 2), "hard");
    random_points(point, 73);
    mssm_gl_bind(g);
    ask_gl(mssm_gl_shader(g),
           "float ask(vec4 p) { return mssm_filtered_visibility(0, p.xyz, vec3(0), vec3(0)); }\n",
           point, hard);
    mssm_gl_bind(t);
    ask_gl(mssm_gl_shader(t), "float ask(vec4 p) { return mssm_visibility(0, p.xyz); }\n", point,
           soft);
    double mean[2] = {0, 0};
    for (int i = 0; i < POINTS; i++) {
        mean[0] +=
            fabs(hard[i] - mssm_filtered_visibility(map, &stage.light, NULL, point + 4 * i, 0));
        mean[1] += fabs(soft[i] - mssm_map_visibility(soft_map, &stage.light, NULL, point + 4 * i));
    }
    CHECK(mean[0] / POINTS < 2e-3, "hard shadows of layers differ by %g", mean[0] / POINTS);
    CHECK(mean[1] / POINTS < 2e-3, "soft shadows of layers differ by %g", mean[1] / POINTS);
    test_note("GL differs by %.1e (hard) and %.1e (soft)", mean[0] / POINTS, mean[1] / POINTS);
    mssm_gl_destroy(g);
    mssm_gl_destroy(t);
    free(memory);
    free(soft_memory);
    end();
}

static void compare_state(gl_state *before, gl_state *after, const char *allowed, const char *call)
{
    char text[300];
    gl_state_take(after);
    CHECK(!gl_state_differences(before, after, allowed, text, sizeof text), "%s changes %s", call,
          text);
    gl_state_take(before);
}

static void state_is_left_alone(void)
{
    gl_state before = {0}, after = {0};
    gl_unusual unusual;
    if (!begin()) return;
    for (int round = 0; round < 2; round++) {
        const mssm_gl_desc desc = description(6, 2);
        mssm_gl *g = NULL;
        if (round) gl_state_make_unusual(&unusual);
        gl_state_take(&before);
        CHECK(!mssm_gl_create(&g, &desc), "%s", fakes.message);
        compare_state(&before, &after, NULL, "create");
        CHECK(!mssm_gl_set_light(g, 0, &stage.light), "light");
        CHECK(!mssm_gl_begin_depth(g, 0, 0), "begin");
        CHECK(!mssm_gl_end_depth(g), "end");
        compare_state(&before, &after, NULL, "a depth pass");
        CHECK(!mssm_gl_begin_translucent(g), "begin");
        CHECK(!mssm_gl_end_translucent(g), "end");
        compare_state(&before, &after, NULL, "a translucent pass");
        CHECK(!mssm_gl_build(g), "build");
        compare_state(&before, &after, NULL, "build");
        CHECK(!mssm_gl_begin_depth(g, 1, 0) && !mssm_gl_end_depth(g) &&
                  !mssm_gl_begin_translucent(g),
              "begin");
        mssm_gl_destroy(g);
        compare_state(&before, &after, NULL, "destroy within a translucent pass");
        if (round) gl_state_make_usual(&unusual);
    }
    gl_state_free(&before);
    gl_state_free(&after);
    end();
}

// What an engine leaves behind and what only drivers do: none of the smoke is lost by it.
static void translucent_casters_are_whole(void)
{
    enum { COUNT = SIDE * SIDE * 8 };
    static float clean[COUNT], got[COUNT];
    static const char *const names[] = {"nothing",         "colour mask",
                                        "logic op",        "polygon mode",
                                        "clip distance",   "calls by name do nothing",
                                        "sample coverage", "a second source",
                                        "alpha test",      "polygon stipple"};
    const mssm_gl_desc desc = description(6, 2);
    GLint profile = 0;
    if (!begin()) return;
    gl.GetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
    for (int i = 0; i < (profile & 2 ? 10 : 8); i++) {
        const GLenum switches[] = {0,
                                   0,
                                   GL_COLOR_LOGIC_OP,
                                   0,
                                   GL_CLIP_DISTANCE0,
                                   0,
                                   GL_SAMPLE_COVERAGE,
                                   0,
                                   GL_ALPHA_TEST,
                                   GL_POLYGON_STIPPLE};
        gl_state before = {0}, after = {0};
        mssm_gl *g = NULL;
        fakes.silent_names = i == 5;
        CHECK(!mssm_gl_create(&g, &desc), "%s", fakes.message);
        if (!g) break;
        if (switches[i]) gl.Enable(switches[i]);
        if (i == 1) gl.ColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_FALSE);
        if (i == 2) gl.LogicOp(GL_CLEAR);
        if (i == 3) gl.PolygonMode(GL_FRONT_AND_BACK, GL_LINE);
        if (i == 6) gl.SampleCoverage(0, GL_FALSE);
        if (i > 7) {
            static const unsigned char holes[128];
            void(GL_CALL * alpha)(GLenum, GLfloat);
            void(GL_CALL * stipple)(const unsigned char *);
            const gl_fakes_function f[2] = {gl_context_function("glAlphaFunc"),
                                            gl_context_function("glPolygonStipple")};
            memcpy(&alpha, &f[0], sizeof f[0]);
            memcpy(&stipple, &f[1], sizeof f[1]);
            alpha(GL_NEVER, 0);
            stipple(holes);
        }
        gl.BlendFunc(GL_SRC_ALPHA, i == 7 ? GL_SRC1_COLOR : GL_ONE_MINUS_SRC_ALPHA);
        if (i == 7) gl.Enable(GL_BLEND); // GL draws to one buffer only with it
        gl_state_take(&before);
        draw_depth(g, 0);
        draw_layers(g);
        if (i == 7) {
            gl.BlendFunc(GL_SRC_ALPHA, GL_SRC1_COLOR);
            gl.Enable(GL_BLEND);
        }
        compare_state(&before, &after,
                      "SHADER_STORAGE_BUFFER SHADER_STORAGE_BUFFER_BINDING VERTEX_ARRAY_BINDING",
                      names[i]);
        gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        gl.PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
        gl.SampleCoverage(1, GL_FALSE);
        if (switches[i]) gl.Disable(switches[i]);
        if (i == 7) gl.Disable(GL_BLEND);
        gl.GetTextureImage(mssm_gl_texture(g, 3), 0, GL_RGBA, GL_FLOAT, sizeof got,
                           i ? got : clean);
        for (int k = 0; k < COUNT && i; k++) {
            CHECK(got[k] == clean[k], "%s: value %d is %g, not %g", names[i], k, (double)got[k],
                  (double)clean[k]);
        }
        mssm_gl_destroy(g);
        gl_state_free(&before);
        gl_state_free(&after);
    }
    end();
}

static void failures_leave_nothing(void)
{
    char text[200];
    if (!begin()) return;
    const mssm_gl_desc desc = description(6, 2);
    for (int what = 0; what < 4; what++) {
        for (int n = 1; n < 40; n++) {
            mssm_gl *g = NULL;
            gl_fakes_reset();
            int *const fail[4] = {&fakes.fail_allocation, &fakes.fail_malloc, &fakes.fail_compile,
                                  &fakes.fail_link};
            *fail[what] = n;
            const mssm_result r = mssm_gl_create(&g, &desc);
            if (!r) {
                mssm_gl_destroy(g);
                CHECK(n > (what == 0 ? 8 : 2), "failure %d.%d went unseen", what, n);
                break;
            }
            CHECK(!g && fakes.messages, "failure %d.%d: no word, or an object", what, n);
            CHECK(!gl_fakes_living(false, text, sizeof text), "failure %d.%d left %s", what, n,
                  text);
            CHECK(!gl_fakes_living_memory(), "failure %d.%d left memory", what, n);
            while (gl.GetError()) {
            }
        }
    }
    gl_fakes_reset();
    mssm_gl *g = NULL;
    CHECK(!mssm_gl_create(&g, &desc), "create");
    CHECK(!mssm_gl_build(g), "build before a light");
    CHECK(mssm_gl_begin_translucent(g) == MSSM_ERROR_ORDER, "smoke before its light");
    CHECK(mssm_gl_end_depth(g) == MSSM_ERROR_ORDER, "end without begin");
    CHECK(mssm_gl_end_translucent(g) == MSSM_ERROR_ORDER, "end without begin");
    CHECK(mssm_gl_begin_depth(g, 0, 1) == MSSM_ERROR_ARGUMENT &&
              strstr(fakes.message, "back faces"),
          "back faces");
    CHECK(mssm_gl_set_moments(g, 0, mssm_gl_texture(g, 3)) == MSSM_ERROR_ARGUMENT &&
              strstr(fakes.message, "soft"),
          "moments of a filtered object");
    CHECK(!mssm_gl_set_light(g, 0, &stage.light) && !mssm_gl_begin_depth(g, 0, 0), "begin");
    CHECK(mssm_gl_begin_translucent(g) == MSSM_ERROR_ORDER, "smoke within a pass");
    CHECK(!mssm_gl_end_depth(g) && !mssm_gl_begin_translucent(g), "smoke");
    CHECK(mssm_gl_end_depth(g) == MSSM_ERROR_ORDER && mssm_gl_build(g) == MSSM_ERROR_ORDER,
          "within smoke");
    CHECK(!mssm_gl_end_translucent(g), "end");
    CHECK(!gl_fakes_living(true, text, sizeof text), "without a label: %s", text);
    mssm_gl_destroy(g);
    end();
}

// Footprints of no size, beyond all sizes and of no number, at points behind a spot light too.
static void any_footprint_is_answered(void)
{
    static float point[POINTS * 4], result[POINTS];
    const float from[3] = {0, 1.5f, 0}, down[3] = {0, 1, 0}, axis[3] = {1, 0, 0};
    if (!begin()) return;
    const mssm_gl_desc base = description(6, 2);
    const mssm_light sun = stage.light;
    for (int spot = 0; spot < 2; spot++) {
        mssm_gl_desc desc = base;
        mssm_gl *g = NULL;
        desc.anisotropy = 16;
        CHECK(!spot || !mssm_light_spot(&stage.light, from, down, axis, 0.8f, 0.1f, 4, 0, 0),
              "spot");
        CHECK(!mssm_gl_create(&g, &desc), "create: %s", fakes.message);
        if (!g) break;
        draw_depth(g, 1);
        CHECK(!mssm_gl_build(g) && !mssm_gl_bind(g), "build");
        random_points(point, 74);
        for (int i = 0; i < POINTS; i++) point[4 * i + 3] = powf(10, (float)(i % 80) - 40);
        ask_gl(mssm_gl_shader(g),
               "float ask(vec4 p) { return mssm_filtered_visibility(1, p.xyz, vec3(p.w, 0.0, 0.0),"
               " p.w > 1e38 ? vec3(sqrt(-p.w)) : vec3(0.0, 1e-3 * p.w, p.w)); }\n",
               point, result);
        for (int i = 0; i < POINTS; i++) {
            CHECK(result[i] >= 0 && result[i] <= 1, "footprint %g: %g", point[4 * i + 3],
                  result[i]);
        }
        mssm_gl_destroy(g);
    }
    stage.light = sun;
    end();
}

// Shading takes as long after a wide Gaussian as after a narrow one: in time of this process, which
// is where a software rasterizer's goes.
static void cost_does_not_depend_on_the_radius(void)
{
    static float point[POINTS * 4], result[POINTS];
    const char *const ask =
        "float ask(vec4 p) { float s = 0.0; for (int i = 0; i < 300; i++) s +="
        " mssm_filtered_visibility(1, p.xyz + 1e-3 * float(i), vec3(0), vec3(0));"
        " return s; }\n";
    double least[2] = {1e9, 1e9};
    if (!begin()) return;
    random_points(point, 75);
    for (int i = 0; i < 8; i++) {
        const mssm_gl_desc desc = description(4, i % 2 ? 32 : 1);
        mssm_gl *g = NULL;
        CHECK(!mssm_gl_create(&g, &desc), "create: %s", fakes.message);
        if (!g) break;
        draw_depth(g, 1);
        CHECK(!mssm_gl_build(g) && !mssm_gl_bind(g), "build");
        gl.Finish();
        const clock_t start = clock();
        ask_gl(mssm_gl_shader(g), ask, point, result);
        const double seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
        least[i % 2] = fmin(least[i % 2], seconds);
        mssm_gl_destroy(g);
    }
    CHECK(least[1] < 1.3 * least[0], "radius 32 takes %g s, radius 1 %g s", least[1], least[0]);
    test_note("radius 32 takes %.2f times as long to shade as radius 1", least[1] / least[0]);
    end();
}

// All levels of both maps.
static void read_maps(const mssm_gl *g, int lights, float *texel)
{
    enum { MOST = 3 * SIDE * SIDE * 6 * 4 / 3 };
    memset(texel, 0, MOST * sizeof *texel);
    for (int which = 0; which < 2; which++) {
        for (int level = 0; level < 3; level++) {
            const int channels = which ? 2 : 4;
            gl.GetTextureImage(mssm_gl_texture(g, which), level, which ? 0x8227 : GL_RGBA,
                               GL_FLOAT, // RG
                               lights * SIDE * SIDE * channels * 4, texel);
            texel += lights * (SIDE >> level) * (SIDE >> level) * channels;
        }
    }
}

// A depth map that the renderer has, four texels for the four samples of a texel: the map of our
// own pass, bit for bit. It has no back faces, and no depth for smoke to hide behind.
static void given_depth_is_a_pass(void)
{
    enum { WIDTH = 2 * SIDE };
    static float window[WIDTH * WIDTH], got[2][SIDE * SIDE * 4], seen[SIDE * SIDE * 4];
    const mssm_gl_desc desc = description(4, 3);
    mssm_gl *g = NULL;
    mssm_gl_depth given;
    if (!begin()) return;
    CHECK(!mssm_gl_create(&g, &desc), "create: %s", fakes.message);
    memset(&given, 0, sizeof given);
    for (int i = 0; i < WIDTH * WIDTH; i++) {
        const int x = i % WIDTH, y = i / WIDTH, s = y % 2 * 2 + x % 2;
        window[i] = 0.5f + 0.5f * stage.depth[(y / 2 * SIDE + x / 2) * SAMPLES + s];
    }
    gl.CreateTextures(GL_TEXTURE_2D, 1, &given.texture);
    gl.TextureStorage2D(given.texture, 1, GL_DEPTH_COMPONENT32F, WIDTH, WIDTH);
    gl.TextureSubImage2D(given.texture, 0, 0, 0, WIDTH, WIDTH, GL_DEPTH_COMPONENT, GL_FLOAT,
                         window);
    CHECK(mssm_gl_stale(g, 0) == MSSM_STALE_MAP, "new");
    draw_depth(g, 0);
    CHECK(mssm_gl_stale(g, 0) == MSSM_STALE_TABLES, "drawn: %d", mssm_gl_stale(g, 0));
    CHECK(!mssm_gl_set_light(g, 1, &stage.light), "light");
    CHECK(mssm_gl_set_depth(g, 1, &given, &given) == MSSM_ERROR_ARGUMENT, "back faces");
    CHECK(!mssm_gl_set_depth(g, 1, &given, NULL), "set_depth: %s", fakes.message);
    CHECK(!mssm_gl_stale(g, 0) && mssm_gl_stale(g, 1) == MSSM_STALE_TABLES, "given");
    CHECK(mssm_gl_begin_translucent(g) == MSSM_ERROR_ORDER, "smoke without depth");
    CHECK(!mssm_gl_build(g) && !mssm_gl_stale(g, 1), "build");
    float *texel = malloc(2 * sizeof got[0]);
    gl.GetTextureImage(mssm_gl_texture(g, 0), 0, GL_RGBA, GL_FLOAT, 2 * sizeof got[0], texel);
    memcpy(got, texel, sizeof got);
    free(texel);
    CHECK(!memcmp(got[0], got[1], sizeof got[0]), "another map");
    // And as a picture.
    GLuint target, framebuffer;
    gl.CreateTextures(GL_TEXTURE_2D, 1, &target);
    gl.TextureStorage2D(target, 1, 0x8814, SIDE, SIDE); // GL_RGBA32F
    gl.CreateFramebuffers(1, &framebuffer);
    gl.NamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, target, 0);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl.Viewport(0, 0, SIDE, SIDE);
    CHECK(!mssm_gl_show(g, 1, MSSM_SHOW_MEAN), "show: %s", fakes.message);
    CHECK(mssm_gl_show(g, 1, MSSM_SHOW_LEAST) == MSSM_ERROR_ARGUMENT, "no least depths");
    gl.GetTextureImage(target, 0, GL_RGBA, GL_FLOAT, sizeof seen, seen);
    double worst = 0;
    for (int i = 0; i < SIDE * SIDE; i++)
        worst = fmax(worst, fabs((double)(seen[4 * i] - got[1][4 * i])));
    CHECK(worst < 1e-6, "the picture is off by %g", worst);
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl.DeleteFramebuffers(1, &framebuffer);
    gl.DeleteTextures(1, &target);
    gl.DeleteTextures(1, &given.texture);
    mssm_gl_destroy(g);
    end();
}

// Lights drawn one after the other and built at once, or one by one, in a frame's bracket or none,
// before a resize or after it: all the same.
static void one_build_serves_all_lights(void)
{
    enum { MOST = 3 * SIDE * SIDE * 6 * 4 / 3 };
    static float got[4][MOST];
    if (!begin()) return;
    for (int way = 0; way < 4; way++) {
        mssm_gl_desc desc = description(6, 3);
        mssm_gl *g = NULL;
        desc.lights = way == 3 ? 1 : 3;
        desc.side = way == 3 ? 40 : SIDE;
        CHECK(!mssm_gl_create(&g, &desc), "create: %s", fakes.message);
        if (!g) break;
        if (way == 3) {
            draw_depth(g, 0);
            CHECK(!mssm_gl_resize(g, 3, SIDE), "resize");
        }
        if (way == 2) CHECK(!mssm_gl_begin_frame(g), "begin");
        for (int i = 0; i < 3; i++) {
            draw_depth(g, i);
            if (i == 1) draw_layers(g);
            if (i == 2) draw_depth(g, i); // again
            if (way == 1) CHECK(!mssm_gl_build(g), "build");
        }
        CHECK(!mssm_gl_build(g) && !mssm_gl_build(g), "build");
        if (way == 2) CHECK(!mssm_gl_end_frame(g), "end");
        read_maps(g, 3, got[way]);
        CHECK(!memcmp(got[way], got[0], sizeof got[0]), "way %d: other maps", way);
        mssm_gl_destroy(g);
    }
    float least = 2, most = -1;
    for (int i = 0; i < 3 * SIDE * SIDE * 4; i++)
        least = fminf(least, got[0][i]), most = fmaxf(most, got[0][i]);
    CHECK(least < 0.3f && most > 0.9f, "values from %g to %g", (double)least, (double)most);
    end();
}

static void second_compiler_agrees(void)
{
    if (system("command -v glslangValidator >/dev/null 2>&1") != 0) {
        CHECK(!getenv("TEST_REQUIRE_GL"), "no glslangValidator: apt-get install glslang-tools");
        test_skip("no glslangValidator: apt-get install glslang-tools");
        return;
    }
    if (!begin()) return;
    for (int moments = 4; moments <= 6; moments += 2) {
        const mssm_gl_desc desc = description(moments, 2);
        mssm_gl *g = NULL;
        const int before = fakes.text_count;
        CHECK(!mssm_gl_create(&g, &desc), "create: %s", fakes.message);
        if (!g) break;
        const int own = fakes.text_count - before;
        CHECK(own == 4, "%d texts", own);
        for (int i = 0; i <= own; i++) {
            const GLenum type = i < own ? fakes.text_types[before + i] : GL_COMPUTE_SHADER;
            const char *ending = type == GL_VERTEX_SHADER     ? "vert"
                                 : type == GL_FRAGMENT_SHADER ? "frag"
                                                              : "comp";
            char name[60], command[120];
            snprintf(name, sizeof name, "build/filtered.%s", ending);
            snprintf(command, sizeof command, "glslangValidator %s >build/filtered.log 2>&1", name);
            FILE *file = fopen(name, "w");
            if (!file) continue;
            if (i < own)
                fputs(fakes.texts[before + i], file);
            else
                fprintf(file,
                        "#version 450 core\n%slayout(local_size_x = 1) in;\n"
                        "layout(std430, binding = 9) buffer b { float r[]; };\n"
                        "void main() { r[0] = mssm_filtered_visibility(0, vec3(r[1]), vec3(0), "
                        "vec3(0)); }\n",
                        mssm_gl_shader(g));
            fclose(file);
            CHECK(!system(command), "text %d of %d moments: see build/filtered.log", i, moments);
        }
        mssm_gl_destroy(g);
    }
    end();
}

const test_case filtered_gl_tests[] = {
    {"filtered GL: any footprint is answered", any_footprint_is_answered},
    {"filtered GL: the cost of shading does not depend on the radius",
     cost_does_not_depend_on_the_radius},
    {"filtered GL: its shaders pass a second compiler", second_compiler_agrees},
    {"filtered GL: agrees with the CPU half", gl_agrees_with_cpu},
    {"filtered GL: one build serves all lights", one_build_serves_all_lights},
    {"filtered GL: a given depth map is a pass", given_depth_is_a_pass},
    {"filtered GL: no light from beyond the rim", no_light_from_beyond_the_rim},
    {"filtered GL: layers behind and before opaque casters, hard and soft",
     layers_are_blended_behind_and_before},
    {"filtered GL: nothing of the smoke is lost to the caller's state",
     translucent_casters_are_whole},
    {"filtered GL: the caller's state is left alone", state_is_left_alone},
    {"filtered GL: failures leave nothing behind", failures_leave_nothing},
    {0, 0}};
