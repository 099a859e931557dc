// The OpenGL half of mssm.h: the numbers of the CPU half, whatever state the caller is in, whatever
// fails, and nothing left behind.
#include "../support/gl_fakes.h"
#include "../support/gl_state.h"
#include "../support/gl_test.h"
#include "../support/scenes.h"
#include "../support/test.h"

#include "../../lightprobe.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Where the tests bind their own buffers, away from mssm's.
enum { DEPTH_BINDING = 7, POINT_BINDING = 8, RESULT_BINDING = 9, GROUP = 64 };

// Under valgrind a shader takes seconds to compile: every how many cases are run.
static int stride(void)
{
    return test_trials(100) < 3 ? 6 : 1;
}

static void *allocate(size_t bytes)
{
    void *memory = malloc(bytes ? bytes : 1);
    if (!memory) abort();
    return memory;
}

// ---- A context, and programs to draw with --------------------------------------------------------

static struct {
    gl_context context;
    GLuint fill; // draws a known depth into every sample
    GLuint casters;
    GLuint array; // without attributes
} stage;

static GLuint link_program(const char *const texts[2])
{
    static const GLenum types[2] = {GL_VERTEX_SHADER, GL_FRAGMENT_SHADER};
    const GLuint program = gl.CreateProgram();
    GLint linked = 0;
    char log[1000] = "";
    for (int i = 0; i < 2; i++) {
        const char *const text[] = {texts[i], NULL};
        const GLuint shader = gl_test_shader(types[i], "shader", text);
        gl.AttachShader(program, shader);
        gl.DeleteShader(shader);
    }
    gl.LinkProgram(program);
    gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
    gl.GetProgramInfoLog(program, sizeof log, NULL, log);
    CHECK(linked && gl_test_quiet(log), "program: %s", log);
    return program;
}

static void make_programs(void)
{
    static const char *const fill[2] = {
        "uniform bool clockwise;\n"
        "void main()\n"
        "{\n"
        "    vec2 p = vec2(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1);\n"
        "    gl_Position = vec4(clockwise ? p.yx : p, 0, 1);\n"
        "}\n",
        "layout(std430, binding = 7) readonly buffer depths { float depth[]; };\n"
        "uniform int side, samples;\n"
        "void main()\n"
        "{\n"
        "    ivec2 p = ivec2(gl_FragCoord.xy);\n"
        "    gl_FragDepth = depth[(p.y * side + p.x) * samples + min(gl_SampleID, samples - 1)];\n"
        "}\n"};
    static const char *const casters[2] = {
        "layout(location = 0) in vec3 position;\n"
        "uniform mat4 world_to_shadow;\n"
        "void main() { gl_Position = world_to_shadow * vec4(position, 1); }\n",
        "void main() {}\n"};
    stage.fill = link_program(fill);
    stage.casters = link_program(casters);
    gl.CreateVertexArrays(1, &stage.array);
}

static bool begin_gl(void)
{
    gl_fakes_reset();
    gl_fakes_forget_living();
    if (!gl_test_begin(&stage.context)) return false;
    gl_fakes_watch();
    make_programs();
    return true;
}

static void nothing_is_left(const char *after)
{
    char text[200];
    CHECK(!gl_fakes_living(false, text, sizeof text), "left after %s:%s", after, text);
    CHECK(!gl_fakes_living_memory(), "%d pieces of memory left after %s", gl_fakes_living_memory(),
          after);
    const GLenum error = gl.GetError();
    CHECK(error == GL_NO_ERROR, "GL error 0x%04X left after %s", error, after);
}

// Ends a test in which nothing was made to fail.
static void end_gl(void)
{
    nothing_is_left("the test");
    CHECK(!fakes.debug_messages, "the driver said: %s", fakes.debug_message);
    CHECK(!fakes.unwatched, "%s is not watched by gl_fakes.c", fakes.unwatched_name);
    CHECK(!fakes.bad_logs, "%d shaders or programs with a log", fakes.bad_logs);
    gl_context_destroy(&stage.context);
    gl_fakes_reset();
}

// ---- A subject: GL's maps and the CPU's of the same depth ----------------------------------------

enum { MOST_LIGHTS = 300 };

typedef struct subject {
    mssm_gl_desc desc;
    mssm_gl *gl;
    GLuint asking; // program that asks for visibility
    mssm_light light[MOST_LIGHTS];
    mssm_map *map[MOST_LIGHTS];
    void *memory[MOST_LIGHTS];
} subject;

static mssm_gl_desc description(int lights, int side, int samples, int moments)
{
    mssm_gl_desc d;
    memset(&d, 0, sizeof d);
    d.load = gl_fakes_load;
    d.lights = lights;
    d.side = side;
    d.samples = samples;
    d.moments = moments;
    d.log = gl_fakes_log;
    d.user = &fakes;
    d.first_texture_unit = 5;
    d.first_buffer_binding = 3;
    return d;
}

static GLuint asking_program(const mssm_gl *g)
{
    static const char tail[] =
        "layout(local_size_x = 64) in;\n"
        "layout(std430, binding = 8) readonly buffer test_points { vec4 test_point[]; };\n"
        "layout(std430, binding = 9) writeonly buffer test_results { float test_result[]; };\n"
        "uniform int test_light;\n"
        "uniform bool test_in_shadow_space;\n"
        "void main()\n"
        "{\n"
        "    uint i = gl_GlobalInvocationID.x;\n"
        "    vec3 p = test_point[i].xyz;\n"
        "    test_result[i] = test_in_shadow_space ? mssm_visibility_at(test_light, p)\n"
        "                                          : mssm_visibility(test_light, p);\n"
        "}\n";
    const char *shading = mssm_gl_shader(g);
    if (!shading) return 0;
    const char *const text[] = {shading, tail, NULL};
    return gl_test_compute("asking", text);
}

static void make_maps(subject *s)
{
    const size_t bytes = mssm_map_bytes(s->desc.side, s->desc.moments);
    for (int i = 0; i < s->desc.lights; i++) {
        s->memory[i] = allocate(bytes);
        CHECK(mssm_map_init(&s->map[i], s->memory[i], bytes, s->desc.side, s->desc.moments) ==
                  MSSM_OK,
              "map");
    }
}

// Drivers may give more samples a texel than asked for: llvmpipe has 4 or none.
static int driver_samples(int asked)
{
    GLuint texture;
    GLint samples = 0;
    gl.CreateTextures(GL_TEXTURE_2D_MULTISAMPLE, 1, &texture);
    gl.TextureStorage2DMultisample(texture, asked, GL_DEPTH_COMPONENT32F, 1, 1, GL_TRUE);
    gl.GetTextureLevelParameteriv(texture, 0, GL_TEXTURE_SAMPLES, &samples);
    gl.DeleteTextures(1, &texture);
    return samples;
}

static bool make_subject(subject *s, const mssm_gl_desc *desc)
{
    memset(s, 0, sizeof *s);
    s->desc = *desc;
    s->desc.samples = driver_samples(desc->samples);
    const mssm_result r = mssm_gl_create(&s->gl, desc);
    CHECK(r == MSSM_OK, "create: %s, %s", mssm_result_string(r), fakes.message);
    if (r != MSSM_OK) return false;
    make_maps(s);
    return true;
}

static void drop_maps(subject *s)
{
    for (int i = 0; i < MOST_LIGHTS; i++) free(s->memory[i]);
    memset(s->memory, 0, sizeof s->memory);
}

static void drop_subject(subject *s)
{
    if (s->asking) gl.DeleteProgram(s->asking);
    mssm_gl_destroy(s->gl);
    drop_maps(s);
    memset(s, 0, sizeof *s);
}

// ---- Depth by value ------------------------------------------------------------------------------

// What window depth a linear depth is stored as.
static float window_depth(const mssm_light *light, float z)
{
    double d = 0.5 * (double)z + 0.5;
    if (light->perspective) {
        const double n = (double)light->z_near, f = (double)light->z_far;
        const double distance = n + d * (f - n);
        d = f / (f - n) * (1 - n / distance);
    }
    return (float)fmin(fmax(d, 0), 1);
}

// And back: exactly what the CPU must be given for the stored window depth.
static float linear_depth(const mssm_light *light, float window)
{
    if (!light->perspective) return 2 * window - 1;
    const double n = (double)light->z_near, f = (double)light->z_far, d = (double)window;
    const double distance = f * n / (f - d * (f - n));
    return (float)(-1 + 2 * (distance - n) / (f - n));
}

// Uploads window depths for every sample to where the fill program reads them.
static GLuint bind_window(const float *window, int width, int height, int samples)
{
    GLuint buffer;
    gl.CreateBuffers(1, &buffer);
    gl.NamedBufferStorage(buffer, (GLsizeiptr)sizeof *window * width * height * samples, window, 0);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, DEPTH_BINDING, buffer);
    gl.ProgramUniform1i(stage.fill, gl.GetUniformLocation(stage.fill, "side"), width);
    gl.ProgramUniform1i(stage.fill, gl.GetUniformLocation(stage.fill, "samples"), samples);
    return buffer;
}

static GLuint bind_depth(const mssm_light *light, const float *z, int side, int samples)
{
    const int count = side * side * samples;
    float *window = allocate(sizeof *window * (size_t)count);
    for (int i = 0; i < count; i++) window[i] = window_depth(light, z[i]);
    const GLuint buffer = bind_window(window, side, side, samples);
    free(window);
    return buffer;
}

static void bind_fill(bool back)
{
    GLint front = GL_CCW;
    gl.GetIntegerv(GL_FRONT_FACE, &front);
    gl.ProgramUniform1i(stage.fill, gl.GetUniformLocation(stage.fill, "clockwise"),
                        back != (front == GL_CW));
    gl.UseProgram(stage.fill);
    gl.BindVertexArray(stage.array);
}

// One depth pass of one light, with depth z at every sample.
static void fill_pass(subject *s, int index, bool back, const float *z)
{
    const GLuint buffer = bind_depth(&s->light[index], z, s->desc.side, s->desc.samples);
    bind_fill(back);
    mssm_result r = mssm_gl_begin_depth(s->gl, index, back);
    CHECK(r == MSSM_OK, "begin: %s", mssm_result_string(r));
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    r = mssm_gl_end_depth(s->gl);
    CHECK(r == MSSM_OK, "end: %s", mssm_result_string(r));
    gl.DeleteBuffers(1, &buffer);
    gl.UseProgram(0);
    gl.BindVertexArray(0);
}

// The CPU's map of the depth that GL has stored.
static void fill_map(subject *s, int index, const float *front, const float *back)
{
    const int count = s->desc.side * s->desc.side * s->desc.samples;
    const mssm_light *light = &s->light[index];
    float *z = allocate(2 * sizeof *z * (size_t)count);
    for (int i = 0; i < count; i++) {
        z[i] = linear_depth(light, window_depth(light, front[i]));
        if (back) z[count + i] = linear_depth(light, window_depth(light, back[i]));
    }
    CHECK(mssm_map_update(s->map[index], z, back ? z + count : NULL, s->desc.samples) == MSSM_OK,
          "update");
    free(z);
}

// Both maps of a light from the same depth (back may be null); mssm_gl_build is left to the caller.
static void fill(subject *s, int index, const float *front, const float *back)
{
    CHECK(mssm_gl_set_light(s->gl, index, &s->light[index]) == MSSM_OK, "set light");
    fill_pass(s, index, false, front);
    if (back) fill_pass(s, index, true, back);
    fill_map(s, index, front, back);
}

static void build(subject *s)
{
    const mssm_result r = mssm_gl_build(s->gl);
    CHECK(r == MSSM_OK, "build: %s", mssm_result_string(r));
}

// ---- Reading GL's maps ---------------------------------------------------------------------------

// Whether this C compiler fuses a*b + c: then its T_k may round to another integer than GL's.
static bool fuses(void)
{
    volatile float a = 1 + 0x1p-23f, b = 1 - 0x1p-23f, c = -1;
    const float x = a, y = b, z = c;
    return x * y + z != 0;
}

// By how much a texel's integer may then be off.
static int slack(void)
{
    return fuses() ? 4 : 0;
}

typedef struct difference {
    double values, unequal; // how many
    int largest;            // of a single texel's value, recovered from the sums
} difference;

// The value of one texel in a table with a row stride, from four sums.
static int texel_value(const uint32_t *at, size_t right, size_t up)
{
    return (int)(at[right + up] - at[right] - at[up] + at[0]);
}

// Sums of one level of one light with a first row and column of zeros, as the CPU lays them out.
static uint32_t *read_level(const subject *s, int index, int level, int size)
{
    const int moments = s->desc.moments;
    const size_t stride = (size_t)(size + 1) * (size_t)moments;
    uint32_t *table = allocate(sizeof *table * stride * (size_t)(size + 1));
    memset(table, 0, sizeof *table * stride * (size_t)(size + 1));
    for (int which = 0; which < (moments == 6 ? 2 : 1); which++) {
        const GLuint texture = mssm_gl_texture(s->gl, which);
        const int channels = which ? 2 : 4;
        GLint width = 0, height = 0, depth = 0;
        gl.GetTextureLevelParameteriv(texture, level, GL_TEXTURE_WIDTH, &width);
        gl.GetTextureLevelParameteriv(texture, level, GL_TEXTURE_HEIGHT, &height);
        gl.GetTextureLevelParameteriv(texture, level, GL_TEXTURE_DEPTH, &depth);
        CHECK(width >= size && height >= size && depth >= s->desc.lights,
              "texture %d, level %d: %d x %d x %d, not %d x %d x %d", which, level, width, height,
              depth, size, size, s->desc.lights);
        if (width < size || height < size || depth <= index) break;
        const size_t count = (size_t)width * (size_t)height * (size_t)(depth * channels);
        uint32_t *texels = allocate(count * sizeof *texels);
        gl.MemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
        gl.GetTextureImage(texture, level, which ? GL_RG_INTEGER : GL_RGBA_INTEGER, GL_INT,
                           (GLsizei)(count * sizeof *texels), texels);
        for (int y = 0; y < size; y++) {
            for (int x = 0; x < size; x++) {
                memcpy(table + (size_t)(y + 1) * stride + (size_t)((x + 1) * moments + 4 * which),
                       texels + (((size_t)index * (size_t)height + (size_t)y) * (size_t)width +
                                 (size_t)x) *
                                    (size_t)channels,
                       (size_t)channels * sizeof *texels);
            }
        }
        free(texels);
    }
    return table;
}

static int levels_of(const subject *s)
{
    GLint levels = 0;
    gl.GetTextureParameteriv(mssm_gl_texture(s->gl, 0), GL_TEXTURE_IMMUTABLE_LEVELS, &levels);
    return levels;
}

static void compare_level(const subject *s, int index, int level, difference *d)
{
    int size;
    const uint32_t *cpu = gl_fakes_map_table(s->map[index], level, &size);
    if (!cpu) return;
    uint32_t *gpu = read_level(s, index, level, size);
    const size_t right = (size_t)s->desc.moments, up = (size_t)(size + 1) * right;
    for (int y = 0; y < size; y++) {
        for (size_t i = (size_t)y * up; i < (size_t)y * up + (size_t)size * right; i++) {
            const int off = abs(texel_value(cpu + i, right, up) - texel_value(gpu + i, right, up));
            d->values++;
            d->unequal += cpu[i + right + up] != gpu[i + right + up];
            if (off > d->largest) d->largest = off;
        }
    }
    free(gpu);
}

// Adds the difference of all levels that a light asks for; returns how many were compared.
static int compare_tables(const subject *s, int index, difference *d)
{
    const int levels = levels_of(s);
    int level = 0;
    for (int size; level < levels && gl_fakes_map_table(s->map[index], level, &size); level++) {
        compare_level(s, index, level, d);
    }
    return level;
}

// result[i] = visibility of the light at points[3 i ...].
static void ask(subject *s, int index, bool in_shadow_space, int count, const float *points,
                float *result)
{
    const int padded = (count + GROUP - 1) / GROUP * GROUP;
    float *four = allocate(sizeof *four * 4 * (size_t)padded);
    GLuint buffers[2];
    if (!s->asking) s->asking = asking_program(s->gl);
    memset(four, 0, sizeof *four * 4 * (size_t)padded);
    for (int i = 0; i < count; i++) memcpy(four + 4 * i, points + 3 * i, 3 * sizeof *four);
    gl.CreateBuffers(2, buffers);
    gl.NamedBufferStorage(buffers[0], (GLsizeiptr)sizeof *four * 4 * padded, four, 0);
    gl.NamedBufferStorage(buffers[1], (GLsizeiptr)sizeof *four * padded, NULL, 0);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, POINT_BINDING, buffers[0]);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, RESULT_BINDING, buffers[1]);
    CHECK(mssm_gl_bind(s->gl) == MSSM_OK, "bind");
    gl.UseProgram(s->asking);
    gl.ProgramUniform1i(s->asking, gl.GetUniformLocation(s->asking, "test_light"), index);
    gl.ProgramUniform1i(s->asking, gl.GetUniformLocation(s->asking, "test_in_shadow_space"),
                        in_shadow_space);
    gl.DispatchCompute((GLuint)(padded / GROUP), 1, 1);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl.GetNamedBufferSubData(buffers[1], 0, (GLsizeiptr)sizeof *result * count, result);
    gl.DeleteBuffers(2, buffers);
    gl.UseProgram(0);
    free(four);
}

// ---- Lights and depth for tests ------------------------------------------------------------------

static mssm_light wide_light(bool spot, float size)
{
    const float low[3] = {-2, -1, -2}, high[3] = {2, 2, 2}, to_light[3] = {0.3f, 1, 0.45f};
    const float axis[3] = {1, 0, 0.2f}, eye[3] = {1, 5, 1.5f};
    mssm_light light;
    const mssm_result r =
        spot ? mssm_light_spot(&light, eye, to_light, axis, 0.7f, 1.5f, 8, size, 0.7f * size)
             : mssm_light_directional(&light, to_light, axis, size, 0.7f * size, low, high);
    CHECK(r == MSSM_OK, "light");
    return light;
}

// Hostile depth: noise, slopes, few layers, the ends of the range.
static void random_depth(float *z, int side, int samples, uint64_t *seed)
{
    const int kind = (int)test_range(seed, 0, 5);
    const double a = test_range(seed, -1, 1), b = test_range(seed, -1, 1);
    for (int i = 0; i < side * side * samples; i++) {
        const int texel = i / samples;
        const double x = (double)(texel % side) / side, y = (double)texel / (side * side);
        const double r = test_range(seed, -1, 1);
        z[i] = (float)(kind == 0   ? r
                       : kind == 1 ? a * x + b * y + 0.01 * r
                       : kind == 2 ? (r < a     ? a
                                      : r < 0.5 ? b
                                                : 1)
                       : kind == 3 ? (r < 0 ? -1 : 1)
                                   : fmod(7 * x + 3 * y, 1) + 1e-6 * r);
        z[i] = fminf(fmaxf(z[i], -1), 1);
    }
}

// ---- 1. The CPU's numbers ------------------------------------------------------------------------

static void tables_are_equal(void)
{
    static const struct {
        int side, lights, samples, moments, back;
    } cases[] = {{256, 1, 4, 6, 0}, {100, 3, 4, 6, 1}, {300, 2, 1, 6, 0}, {1, 2, 4, 6, 0},
                 {27, 1, 1, 6, 1},  {28, 5, 4, 6, 0},  {300, 1, 4, 4, 1}, {2, 1, 1, 4, 0},
                 {55, 2, 4, 4, 0},  {109, 1, 1, 6, 0}};
    uint64_t seed = 21;
    difference all = {0, 0, 0};
    if (!begin_gl()) return;
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c += (size_t)stride()) {
        const int side = cases[c].side;
        const mssm_gl_desc d =
            description(cases[c].lights, side, cases[c].samples, cases[c].moments);
        subject s;
        difference here = {0, 0, 0};
        if (!make_subject(&s, &d)) continue;
        const int samples = s.desc.samples, count = side * side * samples;
        float *z = allocate(2 * sizeof *z * (size_t)count);
        for (int round = 0; round < 2; round++) { // the second over the first
            for (int i = 0; i < d.lights; i++) {
                s.light[i] = wide_light(false, 3); // asks for every level
                random_depth(z, side, samples, &seed);
                random_depth(z + count, side, samples, &seed);
                fill(&s, i, z, cases[c].back ? z + count : NULL);
            }
            build(&s);
        }
        int levels = 0, size;
        for (int i = 0; i < d.lights; i++) levels = compare_tables(&s, i, &here);
        CHECK(!gl_fakes_map_table(s.map[0], levels, &size), "side %d: only %d levels", side,
              levels);
        CHECK(here.unequal == 0 || slack(),
              "side %d, %d lights, %d samples, %d moments: %g of %g "
              "sums differ, texels by up to %d",
              side, d.lights, samples, d.moments, here.unequal, here.values, here.largest);
        CHECK(here.largest <= slack(), "side %d: a texel differs by %d", side, here.largest);
        all.values += here.values;
        all.unequal += here.unequal;
        all.largest = here.largest > all.largest ? here.largest : all.largest;
        free(z);
        drop_subject(&s);
    }
    test_note("%.0f sums, %.0f differ, a texel by at most %d", all.values, all.unequal,
              all.largest);
    end_gl();
}

// Linear depth is computed by the GPU in float: T6 changes 36 times as fast as depth does.
static void spot_depth_is_linear_per_sample(void)
{
    enum { SIDE = 100, SAMPLES = 4, COUNT = SIDE * SIDE * SAMPLES };
    const mssm_gl_desc d = description(2, SIDE, SAMPLES, 6);
    uint64_t seed = 22;
    subject s;
    difference all = {0, 0, 0};
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        float *z = allocate(2 * sizeof *z * COUNT);
        for (int i = 0; i < 2; i++) {
            s.light[i] = wide_light(true, 3);
            random_depth(z, SIDE, SAMPLES, &seed);
            random_depth(z + COUNT, SIDE, SAMPLES, &seed);
            fill(&s, i, z, i ? z + COUNT : NULL);
        }
        build(&s);
        for (int i = 0; i < 2; i++) compare_tables(&s, i, &all);
        test_note("a texel differs by at most %.2g of a value", all.largest / 2945788.0);
        CHECK(all.largest < 60, "%d units", all.largest);
        free(z);
        drop_subject(&s);
    }
    end_gl();
}

// However many samples the driver has, equal ones are one.
static void equal_samples_are_one(void)
{
    enum { SIDE = 40, COUNT = SIDE * SIDE };
    float z[COUNT];
    uint64_t seed = 23;
    if (!begin_gl()) return;
    for (int samples = 1; samples <= 4; samples += stride()) {
        const mssm_gl_desc d = description(1, SIDE, samples, 6);
        subject s;
        difference all = {0, 0, 0};
        if (!make_subject(&s, &d)) continue;
        s.light[0] = wide_light(false, 0.5f);
        random_depth(z, SIDE, 1, &seed);
        s.desc.samples = 1; // what there is to fill in
        fill(&s, 0, z, NULL);
        build(&s);
        compare_tables(&s, 0, &all);
        CHECK(all.largest <= 1 + slack(), "%d samples: a texel differs by %d", samples,
              all.largest);
        drop_subject(&s);
    }
    end_gl();
}

typedef struct agreement {
    int count, beyond; // by more than 2e-3 and not at a limit
    double squares, largest, largest_at_limit;
} agreement;

// Does C itself answer that differently a hair away? Positions are rounded to about 1e-7 of the map
// on both sides, by different instructions.
static double sensitivity(const subject *s, int index, const float point[3], float v)
{
    double largest = 0;
    for (int i = 0; i < 48; i++) {
        const float off = (i % 2 ? 1e-6f : -1e-6f) * (float)(1 << (i / 12));
        float p[3] = {point[0], point[1], point[2]};
        mssm_light light = s->light[index];
        mssm_settings settings = s->desc.settings;
        const int what = i / 2 % 6;
        if (what < 3)
            p[what] += off;
        else if (what == 3)
            light.half_u *= 1 + off;
        else if (what == 4)
            light.half_v *= 1 + off;
        else // narrower kernels are left out where they could change less than this
            settings.tolerance = (1 + 3e3f * off) / 256;
        const float moved = mssm_map_visibility(s->map[index], &light, &settings, p);
        largest = fmax(largest, fabs((double)(moved - v)));
    }
    return largest;
}

static void compare_visibility(subject *s, int index, const char *what, int count,
                               const float *points, agreement *a)
{
    float *gpu = allocate(sizeof *gpu * (size_t)count);
    ask(s, index, false, count, points, gpu);
    for (int i = 0; i < count; i++) {
        const float *p = points + 3 * i;
        const float v = mssm_map_visibility(s->map[index], &s->light[index], &s->desc.settings, p);
        const double off = fabs((double)(gpu[i] - v));
        a->count++;
        a->squares += off * off;
        if (!(off > 2e-3)) {
            a->largest = fmax(a->largest, off);
        } else if (off <= 2e-3 + 4 * sensitivity(s, index, p, v)) {
            a->largest_at_limit = fmax(a->largest_at_limit, off);
        } else {
            a->beyond++;
            CHECK(0, "%s: at %a %a %a GL says %g, C %g", what, (double)p[0], (double)p[1],
                  (double)p[2], (double)gpu[i], (double)v);
        }
    }
    free(gpu);
}

// Half of the points on surfaces, half anywhere near.
static void random_points(const scene *c, int count, float *points, uint64_t *seed)
{
    for (int i = 0; i < count; i++) {
        double p[3], normal[3];
        scene_receiver(c, seed, p, normal);
        for (int k = 0; k < 3; k++) {
            points[3 * i + k] = (float)(i % 2 ? p[k] : test_range(seed, -4, 4));
        }
    }
}

// Three lights over three scenes, the last one a spot.
static void fill_scenes(subject *s, scene scenes[3])
{
    static const int which[3] = {1, 6, 8};
    const size_t count = (size_t)(s->desc.side * s->desc.side * s->desc.samples);
    float *z = allocate(2 * count * sizeof *z);
    for (int i = 0; i < 3; i++) {
        scene_make(&scenes[i], which[i]);
        if (i == 2)
            s->light[i] = wide_light(true, 0.4f);
        else
            CHECK(scene_light(&scenes[i], i ? 0.3 : 0.1, i ? 0.2 : 0.1, &s->light[i]) == 0,
                  "light");
        scene_depth(&scenes[i], &s->light[i], s->desc.side, s->desc.samples, z, z + count);
        fill(s, i, z, i == 1 ? NULL : z + count);
    }
    build(s);
    free(z);
}

static void visibility_is_equal(void)
{
    static const char *const names[3] = {"layered", "lower blocker", "upper blocker"};
    const int count = test_trials(20000);
    float *points = allocate(sizeof *points * 3 * (size_t)count);
    uint64_t seed = 24;
    if (!begin_gl()) {
        free(points);
        return;
    }
    for (int estimator = 0; estimator < 3; estimator += stride()) {
        for (int moments = 0; moments <= 6; moments += moments ? 2 : 4) {
            mssm_gl_desc d = description(3, 128, 4, moments == 4 ? 4 : 6);
            char what[60];
            subject s;
            scene scenes[3];
            agreement a = {0, 0, 0, 0, 0};
            d.settings.estimator = (mssm_estimator)estimator;
            d.settings.moments = moments;
            snprintf(what, sizeof what, "%s, %d moments", names[estimator], moments);
            if (!make_subject(&s, &d)) continue;
            fill_scenes(&s, scenes);
            for (int i = 0; i < 3; i++) {
                random_points(&scenes[i], count, points, &seed);
                compare_visibility(&s, i, what, count, points, &a);
            }
            test_note("%-24s rms %.1e, largest %.1e, at limits %.1e", what,
                      sqrt(a.squares / a.count), a.largest, a.largest_at_limit);
            CHECK(sqrt(a.squares / a.count) < 5e-4, "%s: rms %g", what, sqrt(a.squares / a.count));
            drop_subject(&s);
        }
    }
    free(points);
    end_gl();
}

// All members of mssm_settings take part, one at a time and all at once.
static void settings_are_obeyed(void)
{
    static const mssm_settings settings[] = {
        {0, MSSM_LAYERED, 1e-3f, 0, 0, 0}, {0, MSSM_LAYERED, 0, 0.05f, 0, 0},
        {0, MSSM_LAYERED, 0, 0, 9, 0},     {0, MSSM_LAYERED, 0, 0, 0, 0.1f},
        {4, MSSM_LAYERED, 0, 0, 0, 0},     {6, MSSM_UPPER_BLOCKER, 1e-4f, 0.02f, 33, 0.02f}};
    const int count = test_trials(4000);
    float *points = allocate(sizeof *points * 3 * (size_t)count);
    uint64_t seed = 25;
    if (begin_gl()) {
        for (size_t i = 0; i < sizeof settings / sizeof *settings; i += (size_t)stride()) {
            mssm_gl_desc d = description(3, 100, 1, 6);
            char what[60];
            subject s;
            scene scenes[3];
            agreement a = {0, 0, 0, 0, 0};
            d.settings = settings[i];
            snprintf(what, sizeof what, "settings %d", (int)i);
            if (!make_subject(&s, &d)) continue;
            fill_scenes(&s, scenes);
            for (int k = 0; k < 3; k++) {
                random_points(&scenes[k], count, points, &seed);
                compare_visibility(&s, k, what, count, points, &a);
            }
            test_note("%s: rms %.1e, largest %.1e, at limits %.1e", what, sqrt(a.squares / a.count),
                      a.largest, a.largest_at_limit);
            drop_subject(&s);
        }
        end_gl();
    }
    free(points);
}

// However far below the casters the ground is: kernels grow with the distance.
static void far_receivers_are_equal(void)
{
    enum { SIDE = 256, COUNT = SIDE * SIDE * 4, POINTS = 4000 };
    static float points[3 * POINTS];
    const mssm_gl_desc d = description(1, SIDE, 4, 6);
    uint64_t seed = 44;
    scene c;
    subject s;
    agreement a = {0, 0, 0, 0, 0};
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        float *z = allocate(sizeof *z * COUNT);
        scene_make(&c, 1);
        CHECK(!scene_light(&c, 0.05, 0.05, &s.light[0]), "light");
        scene_depth(&c, &s.light[0], SIDE, 4, z, NULL);
        fill(&s, 0, z, NULL);
        build(&s);
        for (int i = 0; i < POINTS; i++) {
            const double below = test_range(&seed, 0, i % 2 ? 20 : 200);
            for (int k = 0; k < 3; k++) {
                points[3 * i + k] = (float)(test_range(&seed, -2, 2) - below * c.sun[k]);
            }
        }
        compare_visibility(&s, 0, "far below", POINTS, points, &a);
        test_note("rms %.1e, largest %.1e, at limits %.1e", sqrt(a.squares / a.count), a.largest,
                  a.largest_at_limit);
        free(z);
        drop_subject(&s);
    }
    end_gl();
}

// mssm_visibility_at is mssm_visibility of a point that is in shadow space already.
static void shadow_space_is_the_same(void)
{
    enum { COUNT = 1000 };
    static float world[3 * COUNT], shadow[3 * COUNT], a[COUNT], b[COUNT];
    const mssm_gl_desc d = description(3, 64, 1, 6);
    uint64_t seed = 26;
    scene scenes[3];
    subject s;
    double worst = 0, squares = 0;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        fill_scenes(&s, scenes);
        for (int i = 0; i < 3; i++) {
            random_points(&scenes[i], COUNT, world, &seed);
            for (int k = 0; k < COUNT; k++) {
                float *q = shadow + 3 * k;
                if (!mssm_light_project(&s.light[i], world + 3 * k, q)) q[0] = 9;
            }
            ask(&s, i, false, COUNT, world, a);
            ask(&s, i, true, COUNT, shadow, b);
            for (int k = 0; k < COUNT; k++) {
                const double off = fabs((double)(a[k] - b[k]));
                worst = fmax(worst, off);
                squares += off * off / (3 * COUNT);
            }
        }
        test_note("rms %.1e, largest %.1e", sqrt(squares), worst);
        CHECK(sqrt(squares) < 1e-3, "rms %g", sqrt(squares));
        drop_subject(&s);
    }
    end_gl();
}

static void hostile_points_are_in_range(void)
{
    enum { COUNT = 4096 };
    static const float odd[] = {0, 1, -1, 1e30f, -1e30f, 3e38f, 1e-42f, INFINITY, -INFINITY, NAN};
    static float points[3 * COUNT], v[COUNT];
    uint64_t seed = 27;
    scene scenes[3];
    if (!begin_gl()) return;
    for (int estimator = 0; estimator < 3; estimator += stride()) {
        mssm_gl_desc d = description(3, 32, 1, 6);
        subject s;
        d.settings.estimator = (mssm_estimator)estimator;
        if (!make_subject(&s, &d)) continue;
        fill_scenes(&s, scenes);
        for (int i = 0; i < 3; i++) {
            for (int k = 0; k < 3 * COUNT; k++) {
                const uint64_t pick = test_random(&seed) % 20;
                points[k] = pick < 10 ? odd[pick] : (float)test_range(&seed, -3, 3);
            }
            ask(&s, i, i == 1, COUNT, points, v);
            for (int k = 0; k < COUNT; k++) {
                CHECK(v[k] >= 0 && v[k] <= 1, "%g at %g %g %g", (double)v[k], (double)points[3 * k],
                      (double)points[3 * k + 1], (double)points[3 * k + 2]);
            }
        }
        drop_subject(&s);
    }
    end_gl();
}

// A shader's loop may run on beyond the lights that there are.
static void lights_that_are_not_there_are_lit(void)
{
    enum { COUNT = 64 };
    static const int indices[] = {-1, 3, 4, 100000, INT_MAX, INT_MIN};
    static float points[3 * COUNT], v[COUNT];
    uint64_t seed = 28;
    scene scenes[3];
    subject s;
    const mssm_gl_desc d = description(3, 32, 1, 6);
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        fill_scenes(&s, scenes);
        for (int k = 0; k < 3 * COUNT; k++) points[k] = (float)test_range(&seed, -1, 1);
        for (int i = 0; i < 12; i++) {
            ask(&s, indices[i / 2], i % 2, COUNT, points, v);
            for (int k = 0; k < COUNT; k++) CHECK(v[k] == 1, "light %d: %g", indices[i / 2], (double)v[k]);
        }
        drop_subject(&s);
    }
    end_gl();
}

static void new_maps_are_lit(void)
{
    enum { COUNT = 500 };
    static float points[3 * COUNT], v[COUNT];
    const mssm_gl_desc d = description(2, 64, 4, 6);
    uint64_t seed = 28;
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        for (int k = 0; k < 3 * COUNT; k++) points[k] = (float)test_range(&seed, -4, 4);
        for (int pass = 0; pass < 3; pass++) { // new; with lights; built
            for (int i = 0; i < 2; i++) {
                s.light[i] = wide_light(i, 0.3f);
                if (pass == 1) CHECK(!mssm_gl_set_light(s.gl, i, &s.light[i]), "set light");
                if (pass == 2 && i == 0) build(&s);
                ask(&s, i, false, COUNT, points, v);
                for (int k = 0; k < COUNT; k++) {
                    CHECK(v[k] > 0.999f, "pass %d, light %d: %g", pass, i, (double)v[k]);
                }
            }
        }
        drop_subject(&s);
    }
    end_gl();
}

// ---- 2. The picture against ray tracing ------------------------------------------------------------

// Triangles of a scene's shapes, counter-clockwise from outside; discs have two sides.
typedef struct mesh {
    float *xyz;
    int vertices, capacity;
    GLuint buffer, array;
} mesh;

static void add_vertex(mesh *m, const double p[3])
{
    if (m->vertices == m->capacity) {
        m->capacity = m->capacity ? 2 * m->capacity : 4096;
        m->xyz = realloc(m->xyz, sizeof *m->xyz * 3 * (size_t)m->capacity);
        if (!m->xyz) abort();
    }
    for (int k = 0; k < 3; k++) m->xyz[3 * m->vertices + k] = (float)p[k];
    m->vertices++;
}

// Turned so that it faces away from the centre.
static void add_triangle(mesh *m, const double centre[3], const double a[3], const double b[3],
                         const double c[3])
{
    double u[3], v[3], out[3];
    for (int k = 0; k < 3; k++) {
        u[k] = b[k] - a[k];
        v[k] = c[k] - a[k];
        out[k] = a[k] + b[k] + c[k] - 3 * centre[k];
    }
    const double side = out[0] * (u[1] * v[2] - u[2] * v[1]) +
                        out[1] * (u[2] * v[0] - u[0] * v[2]) + out[2] * (u[0] * v[1] - u[1] * v[0]);
    add_vertex(m, a);
    add_vertex(m, side > 0 ? b : c);
    add_vertex(m, side > 0 ? c : b);
}

// A point of a shape from coordinates in units of its half-sizes.
static void shape_point(const shape *o, double x, double y, double z, double p[3])
{
    for (int k = 0; k < 3; k++) {
        p[k] = o->centre[k] + x * o->half[0] * o->axis[0][k] + y * o->half[1] * o->axis[1][k] +
               z * o->half[2] * o->axis[2][k];
    }
}

static void sphere_point(const shape *o, int i, int j, int n, double p[3])
{
    const double a = 3.14159265358979 * i / n, b = 3.14159265358979 * j / n;
    shape_point(o, sin(a) * cos(b), cos(a), sin(a) * sin(b), p);
}

static void add_sphere(mesh *m, const shape *o)
{
    enum { N = 40 };
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < 2 * N; j++) {
            double p[4][3];
            for (int k = 0; k < 4; k++) sphere_point(o, i + k / 2, j + k % 2, N, p[k]);
            if (i > 0) add_triangle(m, o->centre, p[0], p[1], p[2]);
            if (i < N - 1) add_triangle(m, o->centre, p[1], p[3], p[2]);
        }
    }
}

static void add_box(mesh *m, const shape *o)
{
    for (int axis = 0; axis < 3; axis++) {
        for (int end = -1; end <= 1; end += 2) {
            double p[4][3];
            for (int k = 0; k < 4; k++) {
                double c[3];
                c[axis] = end;
                c[(axis + 1) % 3] = k % 2 ? 1 : -1;
                c[(axis + 2) % 3] = k / 2 ? 1 : -1;
                shape_point(o, c[0], c[1], c[2], p[k]);
            }
            add_triangle(m, o->centre, p[0], p[1], p[2]);
            add_triangle(m, o->centre, p[1], p[3], p[2]);
        }
    }
}

static void add_disc(mesh *m, const shape *o)
{
    enum { N = 48 };
    for (int j = 0; j < N; j++) {
        const double a = 6.28318530717959 * j / N, b = 6.28318530717959 * (j + 1) / N;
        double p[3], q[3];
        shape_point(o, cos(a), sin(a), 0, p);
        shape_point(o, cos(b), sin(b), 0, q);
        for (int side = 0; side < 2; side++) {
            add_vertex(m, o->centre);
            add_vertex(m, side ? p : q);
            add_vertex(m, side ? q : p);
        }
    }
}

static void make_mesh(mesh *m, const scene *s)
{
    memset(m, 0, sizeof *m);
    for (int i = 0; i < s->count; i++) {
        const shape *o = &s->shapes[i];
        if (o->kind == SHAPE_SPHERE)
            add_sphere(m, o);
        else if (o->kind == SHAPE_BOX)
            add_box(m, o);
        else
            add_disc(m, o);
    }
    gl.CreateBuffers(1, &m->buffer);
    gl.NamedBufferStorage(m->buffer, (GLsizeiptr)sizeof *m->xyz * 3 * m->vertices, m->xyz, 0);
    gl.CreateVertexArrays(1, &m->array);
    gl.VertexArrayVertexBuffer(m->array, 0, m->buffer, 0, 3 * sizeof *m->xyz);
    gl.VertexArrayAttribFormat(m->array, 0, 3, GL_FLOAT, GL_FALSE, 0);
    gl.VertexArrayAttribBinding(m->array, 0, 0);
    gl.EnableVertexArrayAttrib(m->array, 0);
}

static void drop_mesh(mesh *m)
{
    gl.DeleteBuffers(1, &m->buffer);
    gl.DeleteVertexArrays(1, &m->array);
    free(m->xyz);
}

static void draw_casters(const mesh *m, const mssm_light *light)
{
    gl.ProgramUniformMatrix4fv(stage.casters,
                               gl.GetUniformLocation(stage.casters, "world_to_shadow"), 1, GL_FALSE,
                               light->world_to_shadow);
    gl.UseProgram(stage.casters);
    gl.BindVertexArray(m->array);
    gl.DrawArrays(GL_TRIANGLES, 0, m->vertices);
}

// All passes of light 0, as an application would.
static void draw_light(subject *s, const mesh *m, bool with_back)
{
    CHECK(mssm_gl_set_light(s->gl, 0, &s->light[0]) == MSSM_OK, "set light");
    for (int back = 0; back <= (with_back ? 1 : 0); back++) {
        CHECK(mssm_gl_begin_depth(s->gl, 0, back) == MSSM_OK, "begin");
        draw_casters(m, &s->light[0]);
        CHECK(mssm_gl_end_depth(s->gl) == MSSM_OK, "end");
    }
    build(s);
    gl.UseProgram(0);
    gl.BindVertexArray(0);
}

// Errors of GL (meshes drawn), of the CPU (depth by ray tracing) against the truth, and of the one
// against the other; added to sums of squares.
static void measure_scene(subject *s, const scene *c, int receivers, uint64_t *seed, double sums[3])
{
    float *points = allocate(sizeof *points * 3 * (size_t)receivers);
    float *v = allocate(sizeof *v * (size_t)receivers);
    double *truth = allocate(sizeof *truth * (size_t)receivers);
    for (int i = 0; i < receivers; i++) {
        double p[3], normal[3];
        scene_receiver(c, seed, p, normal);
        for (int k = 0; k < 3; k++) points[3 * i + k] = (float)p[k];
        truth[i] = scene_visibility(c, &s->light[0], p, normal, 12, seed);
    }
    ask(s, 0, false, receivers, points, v);
    for (int i = 0; i < receivers; i++) {
        const double cpu =
            (double)mssm_map_visibility(s->map[0], &s->light[0], NULL, points + 3 * i);
        sums[0] += pow((double)v[i] - truth[i], 2) / receivers;
        sums[1] += pow(cpu - truth[i], 2) / receivers;
        sums[2] += pow((double)v[i] - cpu, 2) / receivers;
    }
    free(points);
    free(v);
    free(truth);
}

static void picture_agrees_with_ray_tracing(void)
{
    static const struct {
        int which, spot, back;
        double size;
    } cases[] = {{0, 0, 0, 0.05}, {0, 0, 1, 0.2}, {1, 0, 0, 0.2}, {2, 0, 1, 0.1}, {3, 0, 0, 0.2},
                 {6, 0, 0, 0.1},  {8, 1, 0, 0.3}, {0, 1, 1, 0.1}, {7, 1, 0, 0.6}, {4, 0, 0, 0.4}};
    enum { CASES = sizeof cases / sizeof *cases };
    const int receivers = test_trials(300), side = receivers < 100 ? 64 : 256;
    double sums[3] = {0, 0, 0};
    uint64_t seed = 29;
    if (!begin_gl()) return;
    for (int asked = 1; asked <= 4; asked += 3 * stride()) {
        const mssm_gl_desc d = description(1, side, asked, 6);
        subject s;
        if (!make_subject(&s, &d)) continue;
        const int samples = s.desc.samples;
        const size_t count = (size_t)(side * side * samples);
        float *z = allocate(2 * count * sizeof *z);
        for (int i = 0; i < CASES; i += stride()) {
            scene c;
            mesh m;
            double here[3] = {0, 0, 0};
            scene_make(&c, cases[i].which);
            if (cases[i].spot)
                s.light[0] = wide_light(true, (float)cases[i].size);
            else
                CHECK(!scene_light(&c, cases[i].size, cases[i].size, &s.light[0]), "light");
            make_mesh(&m, &c);
            draw_light(&s, &m, cases[i].back);
            scene_depth(&c, &s.light[0], side, samples, z, z + count);
            CHECK(!mssm_map_update(s.map[0], z, cases[i].back ? z + count : NULL, samples),
                  "update");
            measure_scene(&s, &c, receivers, &seed, here);
            CHECK(receivers < 100 || here[0] < 1.2 * here[1] + 3e-4,
                  "%s%s%s, %d samples: rms %.4f, CPU %.4f", c.name, cases[i].spot ? ", spot" : "",
                  cases[i].back ? ", both faces" : "", asked, sqrt(here[0]), sqrt(here[1]));
            for (int k = 0; k < 3; k++) sums[k] += here[k] / (2 * CASES);
            drop_mesh(&m);
        }
        free(z);
        drop_subject(&s);
    }
    test_note("rms against ray tracing: GL %.4f, CPU %.4f; GL against CPU %.4f", sqrt(sums[0]),
              sqrt(sums[1]), sqrt(sums[2]));
    end_gl();
}

// ---- 7. From frame to frame ----------------------------------------------------------------------

enum { FRAME_POINTS = 100 };

typedef struct motion {
    double squares, truth_squares, largest, step;
    int steps;
} motion;

// Adds the steps from before to now: of the estimate, and of the truth.
static void add_steps(motion *m, const float v[2][FRAME_POINTS], const double t[2][FRAME_POINTS])
{
    for (int i = 0; i < FRAME_POINTS; i++) {
        const double step = (double)v[1][i] - (double)v[0][i], truth = t[1][i] - t[0][i];
        m->squares += pow(step - truth, 2);
        m->truth_squares += truth * truth;
        m->largest = fmax(m->largest, fabs(step) - fabs(truth));
        m->step = fmax(m->step, fabs(truth));
        m->steps++;
    }
}

// One frame of a scene: the light is fitted, the casters are drawn, all points are asked.
static void make_frame(subject *s, const scene *c, const double points[][3], float v[FRAME_POINTS],
                       double truth[FRAME_POINTS])
{
    const double up[3] = {0, 1, 0};
    float world[3 * FRAME_POINTS];
    mesh m;
    uint64_t same = 12; // the truth's noise must not move
    CHECK(scene_light(c, 0.15, 0.15, &s->light[0]) == MSSM_OK, "light");
    make_mesh(&m, c);
    draw_light(s, &m, false);
    for (int i = 0; i < FRAME_POINTS; i++) {
        for (int k = 0; k < 3; k++) world[3 * i + k] = (float)points[i][k];
        truth[i] = scene_visibility(c, &s->light[0], points[i], up, 16, &same);
    }
    ask(s, 0, false, FRAME_POINTS, world, v);
    drop_mesh(&m);
}

static motion play(subject *s, int which, bool light_turns, int frames)
{
    static double points[FRAME_POINTS][3];
    motion m = {0, 0, 0, 0, 0};
    float v[2][FRAME_POINTS];
    double t[2][FRAME_POINTS];
    uint64_t seed = 31;
    scene c;
    scene_make(&c, which);
    for (int i = 0; i < FRAME_POINTS; i++) {
        points[i][0] = test_range(&seed, -1.5, 1.5);
        points[i][1] = 1e-4;
        points[i][2] = test_range(&seed, -1.5, 1.5);
    }
    const double sun[3] = {c.sun[0], c.sun[1], c.sun[2]};
    for (int frame = 0; frame < frames; frame++) {
        if (light_turns) {
            const double angle = frame * 0.25 * 0.0174532925199433;
            c.sun[0] = cos(angle) * sun[0] - sin(angle) * sun[1];
            c.sun[1] = sin(angle) * sun[0] + cos(angle) * sun[1];
        } else {
            c.shapes[0].centre[0] += 0.1 * 2 * (double)s->light[0].extent_u / s->desc.side;
        }
        scene_finish(&c);
        make_frame(s, &c, (const double(*)[3])points, v[1], t[1]);
        if (frame > 0)
            add_steps(&m, (const float(*)[FRAME_POINTS])v, (const double(*)[FRAME_POINTS])t);
        memcpy(v[0], v[1], sizeof v[0]);
        memcpy(t[0], t[1], sizeof t[0]);
    }
    return m;
}

static void visibility_does_not_flicker(void)
{
    static const int which[3] = {0, 6, 2};
    const int frames = test_trials(16) < 2 ? 2 : test_trials(16);
    const mssm_gl_desc d = description(1, 256, 4, 6);
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        s.light[0] = wide_light(false, 0.15f);
        for (int turns = 1; turns >= 0; turns--) {
            for (int i = 0; i < 3; i += stride()) {
                const motion m = play(&s, which[i], turns, frames);
                scene c;
                scene_make(&c, which[i]);
                test_note("%s, %s: rms step %.4f off the truth's %.4f, largest excess %.3f, the "
                          "truth's largest %.3f",
                          turns ? "light turns" : "caster moves", c.name, sqrt(m.squares / m.steps),
                          sqrt(m.truth_squares / m.steps), m.largest, m.step);
                // Not GL's but the estimator's: the CPU takes the same steps, with 16 samples, too.
                CHECK(m.largest < (turns ? 0.15 : 0.1),
                      "%s, %s: a step of %.3f more than the truth's",
                      turns ? "light turns" : "caster moves", c.name, m.largest);
            }
        }
        drop_subject(&s);
    }
    end_gl();
}

// ---- 3. A good citizen ---------------------------------------------------------------------------

static gl_state before, after;

// The state as it is now must be that of the last snapshot, but for what is allowed.
static void same_state(const char *call, const char *allowed)
{
    char text[800];
    gl_state_take(&after);
    const int n = gl_state_differences(&before, &after, allowed, text, sizeof text);
    CHECK(!n, "%s changed %d: %s", call, n, text);
    const GLenum error = gl.GetError();
    CHECK(error == GL_NO_ERROR, "%s left GL error 0x%04X", call, error);
}

// Evaluates a call between two snapshots.
#define WATCH(call, allowed)        \
    do {                            \
        gl_state_take(&before);     \
        call;                       \
        same_state(#call, allowed); \
    } while (0)

#define WATCH_OK(call, allowed)                                                  \
    do {                                                                         \
        mssm_result result_;                                                     \
        gl_state_take(&before);                                                  \
        result_ = call;                                                          \
        CHECK(result_ == MSSM_OK, "%s: %s, %s", #call, mssm_result_string(result_), fakes.message); \
        same_state(#call, allowed);                                              \
    } while (0)

#define WATCH_FAIL(call, expected)                                                \
    do {                                                                          \
        mssm_result result_;                                                      \
        gl_state_take(&before);                                                   \
        result_ = call;                                                           \
        CHECK(result_ == expected, "%s: %s", #call, mssm_result_string(result_)); \
        same_state(#call, NULL);                                                  \
    } while (0)

// The snapshot itself: sees what gl_state_make_unusual does, and that make_usual undoes it.
static void the_snapshot_sees_all(void)
{
    gl_unusual unusual;
    gl_state fresh = {NULL, 0, 0};
    char text[800];
    if (!begin_gl()) return;
    gl_state_take(&fresh);
    gl_state_make_unusual(&unusual);
    gl_state_take(&before);
    CHECK(gl.GetError() == GL_NO_ERROR, "GL error from making it unusual");
    const int changed = gl_state_differences(&fresh, &before, NULL, text, sizeof text);
    test_note("%d numbers, %d of them made unusual", fresh.count, changed);
    CHECK(fresh.count > 1000 && changed > 400, "%d of %d", changed, fresh.count);
    same_state("taking a snapshot", NULL);
    gl_state_make_usual(&unusual);
    memcpy(before.entry, fresh.entry, (size_t)fresh.count * sizeof *fresh.entry);
    same_state("making it unusual and back", NULL);
    gl_state_free(&fresh);
    end_gl();
}

enum { CITIZEN_SIDE = 60, CITIZEN_SAMPLES = 4 };

// One watched depth pass; the caller's program, array and buffer are bound before.
static void watched_pass(subject *s, int index, bool back, const float *z)
{
    const GLuint buffer = bind_depth(&s->light[index], z, CITIZEN_SIDE, CITIZEN_SAMPLES);
    gl_state at_begin = {NULL, 0, 0};
    bind_fill(back);
    gl_state_take(&at_begin);
    mssm_result r = mssm_gl_begin_depth(s->gl, index, back);
    CHECK(r == MSSM_OK, "begin: %s", mssm_result_string(r));
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    WATCH_FAIL(mssm_gl_begin_depth(s->gl, index, back), MSSM_ERROR_ORDER);
    WATCH_FAIL(mssm_gl_build(s->gl), MSSM_ERROR_ORDER);
    r = mssm_gl_end_depth(s->gl);
    CHECK(r == MSSM_OK, "end: %s", mssm_result_string(r));
    if (before.capacity < at_begin.count) gl_state_take(&before);
    memcpy(before.entry, at_begin.entry, (size_t)at_begin.count * sizeof *at_begin.entry);
    same_state("begin, draw, end", NULL);
    gl_state_free(&at_begin);
    gl.DeleteBuffers(1, &buffer);
}

static const char bound_by_bind[] = "SHADER_STORAGE_BUFFER[3] TEXTURE_BINDING_2D_ARRAY[5] "
                                    "TEXTURE_BINDING_2D_ARRAY[6] TEXTURE_BINDING_2D_ARRAY[7] "
                                    "SAMPLER_BINDING[5] SAMPLER_BINDING[6] SAMPLER_BINDING[7]";

// Every call between snapshots. The subject's maps are those of random depth at the end.
static bool call_everything(subject *s)
{
    enum { COUNT = CITIZEN_SIDE * CITIZEN_SIDE * CITIZEN_SAMPLES };
    const mssm_gl_desc d = description(2, 100, CITIZEN_SAMPLES, 6);
    float *z = allocate(2 * sizeof *z * COUNT);
    uint64_t seed = 33;
    memset(s, 0, sizeof *s);
    s->desc = d;
    WATCH_OK(mssm_gl_create(&s->gl, &d), NULL);
    if (!s->gl) {
        free(z);
        return false;
    }
    s->desc.side = CITIZEN_SIDE;
    s->desc.lights = 3;
    make_maps(s);
    WATCH_OK(mssm_gl_bind(s->gl), bound_by_bind);
    WATCH_OK(mssm_gl_build(s->gl), NULL); // nothing to build yet
    // What was bound is gone with its storage.
    WATCH_OK(mssm_gl_resize(s->gl, s->desc.lights, s->desc.side), bound_by_bind);
    for (int i = 0; i < 3; i++) {
        s->light[i] = wide_light(false, 3);
        random_depth(z, CITIZEN_SIDE, CITIZEN_SAMPLES, &seed);
        random_depth(z + COUNT, CITIZEN_SIDE, CITIZEN_SAMPLES, &seed);
        WATCH_OK(mssm_gl_set_light(s->gl, i, &s->light[i]), NULL);
        watched_pass(s, i, false, z);
        if (i == 1) watched_pass(s, i, true, z + COUNT);
        fill_map(s, i, z, i == 1 ? z + COUNT : NULL);
    }
    WATCH_OK(mssm_gl_build(s->gl), NULL);
    WATCH_OK(mssm_gl_bind(s->gl), bound_by_bind);
    WATCH_FAIL(mssm_gl_end_depth(s->gl), MSSM_ERROR_ORDER);
    WATCH_FAIL(mssm_gl_set_light(s->gl, 3, &s->light[0]), MSSM_ERROR_ARGUMENT);
    WATCH_FAIL(mssm_gl_begin_depth(s->gl, -1, 0), MSSM_ERROR_ARGUMENT);
    WATCH(CHECK(mssm_gl_shader(s->gl) && mssm_gl_texture(s->gl, 0), "no shader"), NULL);
    free(z);
    return true;
}

static void check_numbers(const subject *s, const char *state)
{
    difference all = {0, 0, 0};
    for (int i = 0; i < s->desc.lights; i++) compare_tables(s, i, &all);
    test_note("%s: %.0f sums, %.0f differ", state, all.values, all.unequal);
    CHECK(all.values > 0 && all.largest <= slack(), "%s: %g of %g sums differ, by %d", state,
          all.unequal, all.values, all.largest);
}

static void state_is_left_alone(void)
{
    subject s;
    if (!begin_gl()) return;
    if (call_everything(&s)) {
        check_numbers(&s, "usual state");
        WATCH(mssm_gl_destroy(s.gl), bound_by_bind); // what was bound is gone
        drop_maps(&s);
    }
    gl.UseProgram(0);
    end_gl();
}

static void unusual_state_is_left_alone(void)
{
    gl_unusual unusual;
    subject s;
    if (!begin_gl()) return;
    gl_state_make_unusual(&unusual);
    const bool called = call_everything(&s);
    gl_state_make_usual(&unusual);
    if (called) {
        check_numbers(&s, "unusual state");
        gl_state_make_unusual(&unusual);
        mssm_gl_bind(s.gl);
        WATCH(mssm_gl_destroy(s.gl), bound_by_bind);
        gl_state_make_usual(&unusual);
        drop_maps(&s);
    }
    end_gl();
}

// Each switch alone: two that are wrong may hide each other.
static void each_state_alone_is_harmless(void)
{
    static const struct {
        const char *name;
        GLenum value;
        bool usual;
    } switches[] = {
        {"blend", GL_BLEND, 0},
        {"logic op", GL_COLOR_LOGIC_OP, 0},
        {"depth clamp", GL_DEPTH_CLAMP, 0},
        {"sRGB", GL_FRAMEBUFFER_SRGB, 0},
        {"multisample", GL_MULTISAMPLE, 1},
        {"polygon offset", GL_POLYGON_OFFSET_FILL, 0},
        {"primitive restart", GL_PRIMITIVE_RESTART, 0},
        {"rasterizer discard", GL_RASTERIZER_DISCARD, 0},
        {"alpha to coverage", GL_SAMPLE_ALPHA_TO_COVERAGE, 0},
        {"sample coverage", GL_SAMPLE_COVERAGE, 0},
        {"sample mask", GL_SAMPLE_MASK, 0},
        {"sample shading", GL_SAMPLE_SHADING, 0},
        {"scissor", GL_SCISSOR_TEST, 0},
        {"stencil", GL_STENCIL_TEST, 0},
        {"cull face", GL_CULL_FACE, 0},
        {"clip distance", GL_CLIP_DISTANCE0, 0},
        {"depth test", GL_DEPTH_TEST, 0},
        {"alpha test", GL_ALPHA_TEST, 0}, // the last two in compatibility contexts only
        {"polygon stipple", GL_POLYGON_STIPPLE, 0},
    };
    const size_t all_switches = sizeof switches / sizeof *switches;
    enum { COUNT = 40 * 40 * 4 };
    const mssm_gl_desc d = description(1, 40, 4, 6);
    static float z[COUNT];
    uint64_t seed = 34;
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        s.light[0] = wide_light(false, 1);
        gl.SampleCoverage(0.3f, GL_TRUE);
        gl.SampleMaski(0, 4);
        gl.PolygonOffset(20, 1e6f);
        gl.CullFace(GL_FRONT_AND_BACK);
        void(GL_CALL * AlphaFunc)(GLenum, GLfloat);
        void(GL_CALL * PolygonStipple)(const unsigned char *);
        GLint profile = 0;
        gl.GetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
        if (profile & 2) {
            static const unsigned char holes[128];
            gl_fakes_function f = gl_context_function("glAlphaFunc");
            memcpy(&AlphaFunc, &f, sizeof f);
            AlphaFunc(GL_NEVER, 0);
            f = gl_context_function("glPolygonStipple");
            memcpy(&PolygonStipple, &f, sizeof f);
            PolygonStipple(holes);
        }
        for (size_t i = 0; i < all_switches - (profile & 2 ? 0 : 2); i++) {
            difference all = {0, 0, 0};
            random_depth(z, 40, 4, &seed);
            (switches[i].usual ? gl.Disable : gl.Enable)(switches[i].value);
            fill(&s, 0, z, NULL);
            build(&s);
            (switches[i].usual ? gl.Enable : gl.Disable)(switches[i].value);
            compare_tables(&s, 0, &all);
            CHECK(all.largest <= slack(), "%s: a texel differs by %d", switches[i].name,
                  all.largest);
        }
        drop_subject(&s);
    }
    gl.SampleCoverage(1, GL_FALSE);
    gl.SampleMaski(0, ~0u);
    gl.PolygonOffset(0, 0);
    gl.CullFace(GL_BACK);
    end_gl();
}

// On a driver with GL_EXT_depth_bounds_test.
static void depth_bounds_are_off_in_the_pass(void)
{
    const mssm_gl_desc d = description(1, 32, 4, 6);
    const mssm_light light = wide_light(false, 1);
    mssm_gl *g = NULL;
    if (!begin_gl()) return;
    for (int on = 1; on < 3; on++) {
        fakes.depth_bounds = on;
        CHECK(!mssm_gl_create(&g, &d), "%s", fakes.message);
        if (!g) break;
        CHECK(!mssm_gl_set_light(g, 0, &light) && !mssm_gl_begin_depth(g, 0, 0), "begin");
        CHECK(fakes.depth_bounds == 1, "the depth bounds test is on in the pass");
        CHECK(!mssm_gl_end_depth(g) && fakes.depth_bounds == on, "it was %d and is %d", on, fakes.depth_bounds);
        mssm_gl_destroy(g);
    }
    end_gl();
}

// GL forbids other programs then: no call does its work, and all say so.
static void transform_feedback_is_refused(void)
{
    static const char *const texts[2] = {"void main() { gl_Position = vec4(0); }\n", "void main() {}\n"};
    static const char *const names[] = {"gl_Position"};
    const mssm_gl_desc d = description(1, 32, 4, 6);
    const mssm_light light = wide_light(false, 1);
    GLuint feedback, buffer;
    mssm_gl *g = NULL;
    if (!begin_gl()) return;
    const GLuint program = link_program(texts);
    gl.TransformFeedbackVaryings(program, 1, names, GL_INTERLEAVED_ATTRIBS);
    gl.LinkProgram(program);
    gl.CreateTransformFeedbacks(1, &feedback);
    gl.CreateBuffers(1, &buffer);
    gl.NamedBufferStorage(buffer, 4096, NULL, 0);
    gl.BindTransformFeedback(GL_TRANSFORM_FEEDBACK, feedback);
    gl.BindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, buffer);
    CHECK(!mssm_gl_create(&g, &d), "%s", fakes.message);
    if (g) {
        CHECK(!mssm_gl_set_light(g, 0, &light), "set light");
        gl.UseProgram(program);
        gl.BeginTransformFeedback(GL_TRIANGLES);
        for (int step = 0; step < 3; step++) {
            fakes.messages = 0;
            if (step == 0) WATCH_FAIL(mssm_gl_begin_depth(g, 0, 0), MSSM_ERROR_ORDER);
            if (step == 1) WATCH_FAIL(mssm_gl_end_depth(g), MSSM_ERROR_ORDER);
            if (step == 2) WATCH_FAIL(mssm_gl_build(g), MSSM_ERROR_ORDER);
            CHECK(fakes.messages == 1 && strstr(fakes.message, "transform feedback"), "\"%s\"", fakes.message);
            WATCH_FAIL(mssm_gl_set_moments(g, 0, 1), MSSM_ERROR_ORDER);
            const mssm_gl_depth given = {1, 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0};
            WATCH_FAIL(mssm_gl_set_depth(g, 0, &given, NULL), MSSM_ERROR_ORDER);
            WATCH_FAIL(mssm_gl_show(g, 0, MSSM_SHOW_MEAN), MSSM_ERROR_ORDER);
            gl.PauseTransformFeedback();
            if (step == 0) CHECK(!mssm_gl_begin_depth(g, 0, 0), "begin while paused");
            if (step == 1) CHECK(!mssm_gl_end_depth(g), "end while paused");
            if (step == 2) CHECK(!mssm_gl_build(g), "build while paused");
            gl.ResumeTransformFeedback();
        }
        gl.EndTransformFeedback();
        mssm_gl_destroy(g);
    }
    gl.UseProgram(0);
    gl.DeleteProgram(program);
    gl.BindTransformFeedback(GL_TRANSFORM_FEEDBACK, 0);
    gl.DeleteTransformFeedbacks(1, &feedback);
    gl.DeleteBuffers(1, &buffer);
    end_gl();
}

// What was bound before a pass may have been deleted when it is put back: nothing is bound then.
static void names_that_died_raise_no_error(void)
{
    static const char *const texts[2] = {"void main() { gl_Position = vec4(0); }\n", "void main() {}\n"};
    const mssm_gl_desc d = description(1, 32, 4, 6);
    const mssm_light light = wide_light(false, 1);
    GLuint framebuffer, texture, sampler;
    mssm_gl *g = NULL;
    if (!begin_gl()) return;
    CHECK(!mssm_gl_create(&g, &d) && !mssm_gl_set_light(g, 0, &light), "%s", fakes.message);
    if (g) {
        const GLuint program = link_program(texts);
        gl.UseProgram(program);
        gl.DeleteProgram(program); // lives on as long as it is current
        gl.CreateFramebuffers(1, &framebuffer);
        gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
        CHECK(!mssm_gl_begin_depth(g, 0, 0), "begin");
        gl.DeleteFramebuffers(1, &framebuffer);
        CHECK(!mssm_gl_end_depth(g), "end");
        // In another context that shares its objects with this one, they go from there alone.
        gl_context other;
        if (gl_test_share(&stage.context, &other)) {
            gl.CreateTextures(GL_TEXTURE_2D_MULTISAMPLE, 1, &texture);
            gl.TextureStorage2DMultisample(texture, 4, GL_RGBA8, 8, 8, GL_TRUE);
            gl.CreateSamplers(1, &sampler);
            gl.BindTextureUnit(5, texture);
            gl.BindSampler(5, sampler);
            gl.BindImageTexture(1, texture, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA8);
            gl_test_make_current(&other);
            gl.DeleteTextures(1, &texture);
            gl.DeleteSamplers(1, &sampler);
            gl_test_make_current(&stage.context);
            CHECK(!mssm_gl_build(g) && !mssm_gl_begin_depth(g, 0, 0) && !mssm_gl_end_depth(g), "passes");
            gl.BindTextureUnit(5, 0);
            gl.BindSampler(5, 0);
            gl_test_unshare(&other);
        }
        CHECK(gl.GetError() == GL_NO_ERROR, "GL error");
        mssm_gl_destroy(g);
    }
    end_gl();
}

// Which faces are front faces is the caller's to say, as he winds his meshes.
static void winding_is_the_callers(void)
{
    enum { SIDE = 40, COUNT = SIDE * SIDE * 4 };
    static float z[2 * COUNT];
    const mssm_gl_desc d = description(1, SIDE, 4, 6);
    uint64_t seed = 41;
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        s.light[0] = wide_light(false, 3);
        for (int clockwise = 0; clockwise < 2; clockwise++) {
            for (int upper = 0; upper < 2; upper++) {
                difference all = {0, 0, 0};
                gl.FrontFace(clockwise ? GL_CW : GL_CCW);
                gl.ClipControl(upper ? GL_UPPER_LEFT : GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
                random_depth(z, SIDE, 4, &seed);
                random_depth(z + COUNT, SIDE, 4, &seed);
                fill(&s, 0, z, z + COUNT);
                build(&s);
                compare_tables(&s, 0, &all);
                CHECK(all.largest <= slack(), "front faces %s, origin %s: off by %d",
                      clockwise ? "clockwise" : "counter-clockwise", upper ? "above" : "below",
                      all.largest);
            }
        }
        gl.FrontFace(GL_CCW);
        gl.ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
        drop_subject(&s);
    }
    end_gl();
}

// What begin set is put back to what it was before begin, also where the caller changed it in
// between; what begin did not set, and the caller changed, stays as he left it.
static void changes_in_between(void)
{
    const mssm_gl_desc d = description(1, 32, 4, 6);
    gl_unusual unusual;
    gl_state at_begin = {NULL, 0, 0}, within = {NULL, 0, 0};
    subject s;
    int set = 0, kept = 0;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        s.light[0] = wide_light(false, 1);
        CHECK(mssm_gl_set_light(s.gl, 0, &s.light[0]) == MSSM_OK, "set light");
        gl_state_take(&at_begin);
        CHECK(mssm_gl_begin_depth(s.gl, 0, 0) == MSSM_OK, "begin");
        gl_state_take(&within);
        gl_state_make_unusual(&unusual);
        gl_state_take(&before);
        CHECK(mssm_gl_end_depth(s.gl) == MSSM_OK, "end");
        gl_state_take(&after);
        for (int i = 0; i < after.count; i++) {
            const bool begin_set =
                memcmp(at_begin.entry[i].value, within.entry[i].value, sizeof(double[4])) != 0;
            const gl_state_entry *expected = begin_set ? &at_begin.entry[i] : &before.entry[i];
            const bool same = !memcmp(expected->value, after.entry[i].value, sizeof(double[4]));
            // What begin set to the very value that it had is put back, too: nobody can tell.
            const bool back =
                !memcmp(at_begin.entry[i].value, after.entry[i].value, sizeof(double[4]));
            CHECK(begin_set ? same : same || back, "%s is %g", after.entry[i].name,
                  after.entry[i].value[0]);
            set += begin_set;
            kept += same && !back;
        }
        static const char *const callers[] = {"CURRENT_PROGRAM",
                                              "VERTEX_ARRAY_BINDING",
                                              "ACTIVE_TEXTURE",
                                              "TEXTURE_BINDING_2D[0]",
                                              "UNIFORM_BUFFER[2]",
                                              "SHADER_STORAGE_BUFFER[7]",
                                              "PIXEL_UNPACK_BUFFER_BINDING"};
        for (int i = 0; i < 7; i++) {
            CHECK(gl_state_find(&after, callers[i])->value[0] ==
                      gl_state_find(&before, callers[i])->value[0],
                  "%s is not as the caller left it", callers[i]);
        }
        test_note("%d numbers set by begin and put back, %d others stay as the caller left them",
                  set, kept);
        gl_state_make_usual(&unusual);
        drop_subject(&s);
    }
    gl_state_free(&at_begin);
    gl_state_free(&within);
    end_gl();
}

// One bracket round all passes of a frame: the same numbers, whatever the drawing changes, and the state
// as it was at the end.
static void frames_are_the_passes(void)
{
    enum { SIDE = 40, COUNT = SIDE * SIDE * 4 };
    static float z[6 * COUNT];
    const mssm_gl_desc d = description(3, SIDE, 4, 6);
    gl_state at_begin = {NULL, 0, 0};
    gl_unusual unusual;
    uint64_t seed = 44;
    subject s;
    if (!begin_gl()) return;
    for (int round = 0; round < 2; round++) {
        if (!make_subject(&s, &d)) break;
        GLuint buffer[6];
        for (int i = 0; i < 6; i++) {
            s.light[i / 2] = wide_light(false, 3);
            random_depth(z + i * COUNT, SIDE, 4, &seed);
            buffer[i] = bind_depth(&s.light[i / 2], z + i * COUNT, SIDE, 4);
        }
        if (round) gl_state_make_unusual(&unusual);
        for (int i = 0; i < 3; i++) CHECK(!mssm_gl_set_light(s.gl, i, &s.light[i]), "light");
        WATCH_FAIL(mssm_gl_end_frame(s.gl), MSSM_ERROR_ORDER);
        gl_state_take(&at_begin);
        CHECK(!mssm_gl_begin_frame(s.gl), "%s", fakes.message);
        WATCH_FAIL(mssm_gl_begin_frame(s.gl), MSSM_ERROR_ORDER);
        WATCH_FAIL(mssm_gl_bind(s.gl), MSSM_ERROR_ORDER);
        WATCH_FAIL(mssm_gl_resize(s.gl, 1, 16), MSSM_ERROR_ORDER);
        for (int i = 0; i < 6; i++) {
            if (i == 3) continue; // the second light has no back faces
            CHECK(!mssm_gl_begin_depth(s.gl, i / 2, i % 2), "begin: %s", fakes.message);
            WATCH_FAIL(mssm_gl_end_frame(s.gl), MSSM_ERROR_ORDER);
            bind_fill(i % 2);
            gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, DEPTH_BINDING, buffer[i]);
            gl.DrawArrays(GL_TRIANGLES, 0, 3);
            // As drawing casters of many materials leaves it.
            gl.Enable(GL_CULL_FACE);
            gl.CullFace(GL_BACK);
            gl.DepthMask(GL_FALSE);
            gl.DepthFunc(GL_LEQUAL);
            gl.Disable(GL_DEPTH_TEST);
            gl.Enable(GL_SCISSOR_TEST);
            gl.Scissor(0, 0, 3, 3);
            gl.Viewport(0, 0, 7, 7);
            CHECK(!mssm_gl_end_depth(s.gl), "end: %s", fakes.message);
        }
        CHECK(!mssm_gl_build(s.gl) && !mssm_gl_end_frame(s.gl), "%s", fakes.message);
        if (before.capacity < at_begin.count) gl_state_take(&before);
        memcpy(before.entry, at_begin.entry, (size_t)at_begin.count * sizeof *at_begin.entry);
        same_state("a frame", "SHADER_STORAGE_BUFFER[7] SCISSOR_BOX SCISSOR_TEST VIEWPORT");
        if (round) gl_state_make_usual(&unusual);
        for (int i = 1; i < 16; i++) gl.Disablei(GL_SCISSOR_TEST, (GLuint)i);
        difference all = {0, 0, 0};
        for (int i = 0; i < 3; i++) {
            fill_map(&s, i, z + 2 * i * COUNT, i == 1 ? NULL : z + (2 * i + 1) * COUNT);
            compare_tables(&s, i, &all);
        }
        CHECK(all.values > 0 && all.largest <= slack(), "tables differ by %d", all.largest);
        gl.DeleteBuffers(6, buffer);
        // Destroyed within a frame and a pass: the state is as before both.
        gl_state_take(&at_begin);
        CHECK(!mssm_gl_begin_frame(s.gl) && !mssm_gl_begin_depth(s.gl, 0, 0), "begin");
        mssm_gl_destroy(s.gl);
        memcpy(before.entry, at_begin.entry, (size_t)at_begin.count * sizeof *at_begin.entry);
        same_state("destroy", NULL);
        s.gl = NULL;
        drop_maps(&s);
    }
    gl_state_free(&at_begin);
    end_gl();
}

// An error that the caller has not asked about yet is not ours.
static void callers_error_is_not_ours(void)
{
    const mssm_gl_desc d = description(1, 32, 1, 4);
    subject s;
    if (!begin_gl()) return;
    gl.DebugMessageCallback(NULL, NULL);
    gl.Enable(0xFFFF);
    if (make_subject(&s, &d)) {
        s.light[0] = wide_light(false, 0.2f);
        gl.Enable(0xFFFF);
        CHECK(mssm_gl_set_light(s.gl, 0, &s.light[0]) == MSSM_OK, "set light");
        gl.Enable(0xFFFF);
        CHECK(mssm_gl_begin_depth(s.gl, 0, 0) == MSSM_OK, "begin");
        gl.Enable(0xFFFF);
        CHECK(mssm_gl_end_depth(s.gl) == MSSM_OK, "end");
        gl.Enable(0xFFFF);
        CHECK(mssm_gl_build(s.gl) == MSSM_OK, "build");
        gl.Enable(0xFFFF);
        CHECK(mssm_gl_resize(s.gl, 2, 40) == MSSM_OK, "resize");
        gl.Enable(0xFFFF);
        CHECK(mssm_gl_bind(s.gl) == MSSM_OK, "bind");
        drop_subject(&s);
    }
    while (gl.GetError() != GL_NO_ERROR) {
    }
    end_gl();
}

// ---- 4. Objects ----------------------------------------------------------------------------------

static void objects_are_labelled_and_deleted(void)
{
    char text[200];
    if (!begin_gl()) return;
    for (int moments = 4; moments <= 6; moments += 2 * stride()) {
        const mssm_gl_desc d = description(2, 64, 4, moments);
        enum { COUNT = 64 * 64 * 4 };
        static float z[COUNT];
        uint64_t seed = 35;
        subject s;
        if (!make_subject(&s, &d)) continue;
        s.light[0] = wide_light(false, 1);
        random_depth(z, 64, 4, &seed);
        fill(&s, 0, z, z);
        build(&s);
        CHECK(!gl_fakes_living(true, text, sizeof text), "without a label:%s", text);
        test_note("%d moments: %d objects", moments, gl_fakes_living(false, text, sizeof text));
        CHECK(mssm_gl_resize(s.gl, 3, 50) == MSSM_OK, "resize");
        CHECK(!gl_fakes_living(true, text, sizeof text), "without a label after resize:%s", text);
        drop_subject(&s);
        nothing_is_left("destroy");
    }
    mssm_gl_destroy(NULL);
    end_gl();
}

// Compiles under another #version; what the driver said first.
static bool compiles(const char *version, const char *const *text, int count, char log[300])
{
    const char *piece[8] = {version};
    GLint good = 0;
    for (int i = 0; i < count; i++) piece[1 + i] = text[i];
    const GLuint shader = gl.CreateShader(GL_FRAGMENT_SHADER);
    gl.ShaderSource(shader, 1 + count, piece, NULL);
    gl.CompileShader(shader);
    gl.GetShaderiv(shader, GL_COMPILE_STATUS, &good);
    log[0] = 0;
    gl.GetShaderInfoLog(shader, 300, NULL, log);
    gl.DeleteShader(shader);
    return good;
}

// Descriptors left at zero: beside a program's own texture at unit 0 and a probe's lights at binding 0.
static void zeroed_descriptors_disturb_nobody(void)
{
    static const char *const body =
        "uniform sampler2D own;\n"
        "layout(location = 0) out vec4 c;\n"
        "void main()\n"
        "{\n"
        "    c = vec4(mssm_visibility(0, vec3(0)), mssm_filtered_or_one(), texture(own, vec2(0.5)).x,\n"
        "             float(lightprobe_count));\n"
        "}\n";
    enum { SIDE = 32 };
    char log[300];
    subject s;
    mssm_gl_desc d;
    if (!begin_gl()) return;
    memset(&d, 0, sizeof d);
    d.load = gl_fakes_load;
    d.side = SIDE;
    d.log = gl_fakes_log;
    d.user = &fakes;
    memset(&s, 0, sizeof s);
    CHECK(!mssm_gl_create(&s.gl, &d), "%s", fakes.message);
    if (s.gl) {
        GLuint own, buffer;
        static const unsigned char white[4] = {255, 255, 255, 255};
        gl.CreateTextures(GL_TEXTURE_2D, 1, &own);
        gl.TextureStorage2D(own, 1, GL_RGBA8, 1, 1);
        gl.TextureSubImage2D(own, 0, 0, 0, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, white);
        gl.BindTextureUnit(0, own);
        gl.CreateBuffers(1, &buffer);
        gl.NamedBufferStorage(buffer, 4096, NULL, 0);
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer);
        s.light[0] = wide_light(false, 1);
        CHECK(!mssm_gl_set_light(s.gl, 0, &s.light[0]) && !mssm_gl_begin_depth(s.gl, 0, 0) &&
                  !mssm_gl_end_depth(s.gl) && !mssm_gl_build(s.gl), "passes");
        fakes.messages = 0;
        gl_state_take(&before);
        CHECK(!mssm_gl_bind(s.gl) && !fakes.messages, "\"%s\"", fakes.message);
        same_state("bind", "SHADER_STORAGE_BUFFER[7] TEXTURE_BINDING_2D_ARRAY[80] TEXTURE_BINDING_2D_ARRAY[81] "
                           "TEXTURE_BINDING_2D_ARRAY[82]");
        // All in one shader, in either order; the program is one that draws.
        const char *const probe[2] = {lightprobe_glsl_math(), lightprobe_glsl_lights()};
        const char *const one = "float mssm_filtered_or_one() { return 1.0; }\n";
        const char *const orders[2][5] = {{probe[0], probe[1], mssm_gl_shader(s.gl), one, body},
                                          {mssm_gl_shader(s.gl), probe[0], probe[1], one, body}};
        for (int i = 0; i < 2; i++) CHECK(compiles("#version 450 core\n", orders[i], 5, log), "%s", log);
        const char *const twice[2][3] = {{mssm_glsl_math(), mssm_gl_shader(s.gl), "void main() {}\n"},
                                         {mssm_gl_shader(s.gl), mssm_glsl_math(), "void main() {}\n"}};
        for (int i = 0; i < 2; i++) CHECK(compiles("#version 450 core\n", twice[i], 3, log), "%s", log);
        // A second object on the same places says so, once.
        mssm_gl *other = NULL;
        CHECK(!mssm_gl_create(&other, &d), "%s", fakes.message);
        fakes.messages = 0;
        CHECK(!mssm_gl_bind(other) && fakes.messages == 4 && strstr(fakes.message, "binding 7"), "%d: \"%s\"",
              fakes.messages, fakes.message);
        CHECK(!mssm_gl_bind(s.gl) && !mssm_gl_bind(other) && fakes.messages == 4, "%d messages", fakes.messages);
        mssm_gl_destroy(other);
        gl.BindTextureUnit(0, 0);
        gl.DeleteTextures(1, &own);
        gl.DeleteBuffers(1, &buffer);
        mssm_gl_destroy(s.gl);
    }
    gl.DebugMessageCallback(NULL, NULL); // what follows does not compile, and must not
    gl_fakes_reset();
    d.first_buffer_binding = 3;
    s.gl = NULL;
    CHECK(!mssm_gl_create(&s.gl, &d), "%s", fakes.message);
    if (s.gl) {
        const char *const same[] = {"#define LIGHTPROBE_BINDING 3\n", lightprobe_glsl_math(), lightprobe_glsl_lights(),
                                    mssm_gl_shader(s.gl), "void main() {}\n"};
        const char *const turned[] = {"#define LIGHTPROBE_BINDING 3\n", mssm_gl_shader(s.gl), lightprobe_glsl_math(),
                                      lightprobe_glsl_lights(), "void main() {}\n"};
        CHECK(!compiles("#version 450 core\n", same, 5, log) && strstr(log, "first_buffer_binding"), "%s", log);
        CHECK(!compiles("#version 450 core\n", turned, 5, log) && strstr(log, "first_buffer_binding"), "%s", log);
        const char *const alone[] = {mssm_gl_shader(s.gl), "void main() {}\n"};
        CHECK(compiles("#version 430 core\n", alone, 2, log), "%s", log);
        CHECK(!compiles("#version 330 core\n", alone, 2, log) && strstr(log, "#version 430"), "%s", log);
        const char *const wrong[] = {mssm_gl_shader(s.gl), "void main()\n{\n    wrong = 1.0;\n}\n"};
        CHECK(!compiles("#version 450 core\n", wrong, 2, log) && strstr(log, ":3("), "not line 3: %s", log);
        mssm_gl_destroy(s.gl);
    }
    end_gl();
}

// ---- 5. Failures ---------------------------------------------------------------------------------

// The whole life of an mssm_gl up to the first failure.
// Of a texture that is not counted.
static mssm_result give_depth(mssm_gl *g)
{
    mssm_gl_depth given;
    memset(&given, 0, sizeof given);
    gl.CreateTextures(0x0DE1, 1, &given.texture); // GL_TEXTURE_2D
    gl.TextureStorage2D(given.texture, 1, GL_DEPTH_COMPONENT32F, 64, 64);
    const mssm_result r = mssm_gl_set_depth(g, 0, &given, &given);
    gl.DeleteTextures(1, &given.texture);
    return r;
}

static mssm_result show_map(mssm_gl *g)
{
    GLuint texture, framebuffer;
    gl.CreateTextures(0x0DE1, 1, &texture); // GL_TEXTURE_2D
    gl.TextureStorage2D(texture, 1, GL_R32F, 8, 8);
    gl.CreateFramebuffers(1, &framebuffer);
    gl.NamedFramebufferTexture(framebuffer, 0x8CE0, texture, 0); // GL_COLOR_ATTACHMENT0
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    const mssm_result r = mssm_gl_show(g, 0, MSSM_SHOW_LEAST);
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl.DeleteFramebuffers(1, &framebuffer);
    gl.DeleteTextures(1, &texture);
    return r;
}

static mssm_result whole_life(mssm_gl **g)
{
    const mssm_gl_desc d = description(2, 64, 4, 6);
    const mssm_light light = wide_light(false, 1);
    mssm_result r = mssm_gl_create(g, &d);
    if (!r) r = mssm_gl_set_light(*g, 0, &light);
    for (int back = 0; back < 2 && !r; back++) {
        r = mssm_gl_begin_depth(*g, 0, back);
        if (!r) r = mssm_gl_end_depth(*g);
    }
    if (!r) r = mssm_gl_build(*g);
    if (!r) r = give_depth(*g);
    if (!r) r = mssm_gl_build(*g);
    if (!r) r = show_map(*g);
    if (!r) r = mssm_gl_bind(*g);
    if (!r) r = mssm_gl_resize(*g, 3, 100);
    if (!r) r = mssm_gl_build(*g);
    return r;
}

// Runs it with what fakes say is to fail; all must be as before. The context lives on.
static void fail_once(const char *what, mssm_result expected)
{
    mssm_gl *const nothing = (mssm_gl *)(void *)&before;
    mssm_gl *g = nothing;
    gl_state start = {NULL, 0, 0};
    char text[800];
    gl_state_take(&start);
    const mssm_result r = whole_life(&g);
    CHECK(r == expected, "%s: %s", what, mssm_result_string(r));
    CHECK(r == MSSM_OK || (fakes.messages > 0 && fakes.message[0]), "%s: no message", what);
    gl_state_take(&after);
    const int n = gl_state_differences(&start, &after, bound_by_bind, text, sizeof text);
    CHECK(!n, "%s changed %d: %s", what, n, text);
    if (g != nothing) mssm_gl_destroy(g);
    nothing_is_left(what);
    gl_state_free(&start);
}

// Intel's driver for Windows: clears, buffers and bindings by name do nothing, and raise no error.
static void silent_calls_are_not_relied_on(void)
{
    enum { COUNT = 64 * 64 * 4 };
    const mssm_gl_desc d = description(2, 64, 4, 6);
    static float z[COUNT];
    uint64_t seed = 52;
    subject s;
    if (!begin_gl()) return;
    fakes.silent_names = true;
    if (make_subject(&s, &d)) {
        difference all = {0, 0, 0};
        for (int i = 0; i < 2; i++) {
            s.light[i] = wide_light(false, 3);
            random_depth(z, 64, 4, &seed);
            fill(&s, i, z, z);
        }
        build(&s);
        for (int i = 0; i < 2; i++) compare_tables(&s, i, &all);
        CHECK(all.values > 0 && all.largest <= slack(), "sums differ by %d", all.largest);
        const float point[3] = {0.3f, -0.5f, 0.2f};
        float v;
        ask(&s, 0, false, 1, point, &v);
        const double truth = (double)mssm_map_visibility(s.map[0], &s.light[0], &d.settings, point);
        CHECK(fabs((double)v - truth) < 1e-3, "visibility %g, the CPU's %g", (double)v, truth);
        drop_subject(&s);
    }
    end_gl();
}

static void missing_functions(void)
{
    if (!begin_gl()) return;
    const char *names[GL_FAKES_NAMES];
    fail_once("nothing", MSSM_OK);
    const int count = fakes.name_count;
    memcpy(names, fakes.names, sizeof names);
    CHECK(count > 20 && count < GL_FAKES_NAMES, "%d functions asked for", count);
    for (int i = 0; i < count; i++) {
        gl_fakes_reset();
        fakes.missing = names[i];
        fail_once(names[i], MSSM_ERROR_GL_VERSION);
        CHECK(strstr(fakes.message, names[i]), "%s: the message is \"%s\"", names[i],
              fakes.message);
    }
    test_note("%d functions, each missing once; last message: %s", count, fakes.message);
    gl_fakes_reset();
    end_gl();
}

static void allocations_fail(void)
{
    char what[40];
    if (!begin_gl()) return;
    fail_once("nothing", MSSM_OK);
    const int allocations = fakes.allocations, mallocs = fakes.mallocs;
    gl.DebugMessageCallback(NULL, NULL); // what follows from a failure may be an error
    for (int i = 1; i <= allocations; i += stride()) {
        gl_fakes_reset();
        fakes.fail_allocation = i;
        snprintf(what, sizeof what, "GL allocation %d", i);
        fail_once(what, MSSM_ERROR_GL);
    }
    for (int i = 1; i <= mallocs; i += stride()) {
        gl_fakes_reset();
        fakes.fail_malloc = i;
        snprintf(what, sizeof what, "malloc %d", i);
        fail_once(what, MSSM_ERROR_MEMORY);
    }
    test_note("%d allocations by GL, %d by malloc", allocations, mallocs);
    CHECK(allocations > 5 && mallocs > 0, "hardly any allocation is seen");
    gl_fakes_reset();
    end_gl();
}

static void shaders_fail(void)
{
    char what[40];
    if (!begin_gl()) return;
    fail_once("nothing", MSSM_OK);
    const int compiles = fakes.compiles, links = fakes.links;
    gl.DebugMessageCallback(NULL, NULL);
    for (int i = 1; i <= compiles + links; i += stride()) {
        gl_fakes_reset();
        if (i <= compiles)
            fakes.fail_compile = i;
        else
            fakes.fail_link = i - compiles;
        snprintf(what, sizeof what, "%s %d", i <= compiles ? "shader" : "program",
                 i <= compiles ? i : i - compiles);
        fail_once(what, MSSM_ERROR_GL);
        CHECK(strstr(fakes.message, "%s%n"), "%s: the log is not passed on: %.60s", what,
              fakes.message);
    }
    test_note("%d shaders, %d programs", compiles, links);
    CHECK(compiles > 0 && links > 0, "no shader is seen");
    gl_fakes_reset();
    end_gl();
}

static void drivers_with_less(void)
{
    if (!begin_gl()) return;
    gl.DebugMessageCallback(NULL, NULL);
    fakes.incomplete = true;
    fail_once("incomplete framebuffer", MSSM_ERROR_GL);
    gl_fakes_reset();
    fakes.max_samples = 2;
    fail_once("two samples at most", MSSM_ERROR_GL);
    test_note("message: %s", fakes.message);
    gl_fakes_reset();
    end_gl();
}

// A resize that fails leaves everything as it was.
static void failed_resize_changes_nothing(void)
{
    enum { SIDE = 40, COUNT = SIDE * SIDE * 4 };
    const mssm_gl_desc d = description(2, SIDE, 4, 6);
    static float z[COUNT];
    uint64_t seed = 36;
    subject s;
    char text[800];
    if (!begin_gl()) return;
    gl.DebugMessageCallback(NULL, NULL);
    if (make_subject(&s, &d)) {
        for (int i = 0; i < 2; i++) {
            s.light[i] = wide_light(false, 1);
            random_depth(z, SIDE, 4, &seed);
            fill(&s, i, z, NULL);
        }
        build(&s);
        int failures = 0;
        for (int i = 1; i < 40; i += stride()) {
            difference all = {0, 0, 0};
            const int had = gl_fakes_living(false, text, sizeof text);
            gl_fakes_reset();
            fakes.fail_allocation = i;
            gl_state_take(&before);
            const mssm_result r = mssm_gl_resize(s.gl, 3, 50);
            same_state("failed resize", NULL);
            if (!r) break;
            failures++;
            CHECK(r == MSSM_ERROR_GL && fakes.messages > 0, "%d: %s", i, mssm_result_string(r));
            gl_fakes_reset();
            CHECK(gl_fakes_living(false, text, sizeof text) == had, "%d: objects left:%s", i, text);
            for (int k = 0; k < 2; k++) compare_tables(&s, k, &all);
            CHECK(all.largest <= slack(), "%d: maps changed", i);
            random_depth(z, SIDE, 4, &seed);
            fill(&s, i % 2, z, NULL);
            build(&s);
        }
        test_note("%d allocations", failures);
        CHECK(failures > 0, "only %d allocations in resize", failures);
        gl_fakes_reset();
        WATCH_FAIL(mssm_gl_resize(s.gl, -1, 64), MSSM_ERROR_ARGUMENT);
        WATCH_FAIL(mssm_gl_resize(s.gl, 1, 1 << 20), MSSM_ERROR_ARGUMENT);
        drop_subject(&s);
    }
    end_gl();
}

// ---- 6. Versions, order, arguments, life -----------------------------------------------------------

static void old_versions_are_refused(void)
{
    static const struct {
        int major, minor;
        const char *version, *named;
    } contexts[] = {{4, 4, "4.4 (Core Profile) Mesa 22.3.6", "4.4"},
                    {3, 3, "3.3.0 NVIDIA 535.54", "3.3"},
                    {2, 1, "2.1 Metal - 76.3", "2.1"},
                    {3, 2, "OpenGL ES 3.2 Mesa 22.3.6", "ES"},
                    {9, 9, "", NULL}};
    if (!begin_gl()) return;
    for (size_t i = 0; i < sizeof contexts / sizeof *contexts; i++) {
        gl_fakes_reset();
        fakes.major = contexts[i].major;
        fakes.minor = contexts[i].minor;
        fakes.version = contexts[i].version;
        fail_once(contexts[i].named ? contexts[i].version : "no context", MSSM_ERROR_GL_VERSION);
        CHECK(!contexts[i].named || strstr(fakes.message, contexts[i].named),
              "%s: the message is \"%s\"", contexts[i].version, fakes.message);
        test_note("\"%s\": %s", contexts[i].version, fakes.message);
    }
    gl_fakes_reset();
    fakes.major = 4;
    fakes.minor = 6;
    fakes.version = "4.6.0 - Build 31.0.101.2111";
    fail_once("4.6", MSSM_OK);
    gl_fakes_reset();
    end_gl();
}

static void bad_arguments_are_refused(void)
{
    const mssm_gl_desc good = description(2, 32, 1, 6);
    const struct {
        const char *what;
        mssm_gl_desc desc;
    } bad[] = {{"lights -1: 1 to ", description(-1, 32, 1, 6)},
               {"lights 100000: 1 to ", description(100000, 32, 1, 6)},
               {"side -1: 1 to 16384", description(1, -1, 1, 6)},
               {"side 20000: 1 to 16384", description(1, 20000, 1, 6)},
               {"samples -1: 1 to 64", description(1, 32, -1, 6)},
               {"samples 65: 1 to 64", description(1, 32, 65, 6)},
               {"moments 5: 4 or 6", description(1, 32, 1, 5)},
               {"moments -4: 4 to 6", description(1, 32, 1, -4)}};
    mssm_gl *const nothing = (mssm_gl *)(void *)&before;
    mssm_gl *g = nothing;
    mssm_gl_desc d = good;
    if (!begin_gl()) return;
    const mssm_light light = wide_light(false, 0.1f);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        gl_fakes_reset();
        const mssm_result r = mssm_gl_create(&g, &bad[i].desc);
        CHECK(r == MSSM_ERROR_ARGUMENT && g == nothing, "%s %d %d %d %d: %s", bad[i].what,
              bad[i].desc.lights, bad[i].desc.side, bad[i].desc.samples, bad[i].desc.moments,
              mssm_result_string(r));
        CHECK(strstr(fakes.message, bad[i].what), "not \"%s\" but \"%s\"", bad[i].what, fakes.message);
    }
    CHECK(mssm_gl_create(NULL, &good) == MSSM_ERROR_ARGUMENT, "no place");
    CHECK(mssm_gl_create(&g, NULL) == MSSM_ERROR_ARGUMENT && g == nothing, "no description");
    d.load = NULL;
    CHECK(mssm_gl_create(&g, &d) == MSSM_ERROR_ARGUMENT && g == nothing, "no loader");
    CHECK(strstr(fakes.message, "load"), "\"%s\"", fakes.message);
    d = good;
    d.first_texture_unit = -1;
    CHECK(mssm_gl_create(&g, &d) == MSSM_ERROR_ARGUMENT && g == nothing, "texture unit -1");
    d.first_texture_unit = 100000;
    CHECK(mssm_gl_create(&g, &d) == MSSM_ERROR_ARGUMENT && g == nothing, "texture unit 100000");
    CHECK(strstr(fakes.message, "first_texture_unit 100000: 0 to "), "\"%s\"", fakes.message);
    d = good;
    d.first_buffer_binding = -1;
    CHECK(mssm_gl_create(&g, &d) == MSSM_ERROR_ARGUMENT && g == nothing, "buffer binding -1");
    d.first_texture_unit = INT_MAX;
    d.first_buffer_binding = 0;
    CHECK(mssm_gl_create(&g, &d) == MSSM_ERROR_ARGUMENT && g == nothing, "last texture unit");
    d = good;
    d.first_buffer_binding = 100000;
    CHECK(mssm_gl_create(&g, &d) == MSSM_ERROR_ARGUMENT && g == nothing, "buffer binding 100000");
    d = good;
    d.log = NULL;
    d.moments = 5;
    CHECK(mssm_gl_create(&g, &d) == MSSM_ERROR_ARGUMENT && g == nothing, "no log");
    CHECK(mssm_gl_create(&g, &good) == MSSM_OK, "good description");
    for (int i = -1; i <= 2; i += 3) {
        WATCH_FAIL(mssm_gl_set_light(g, i, &light), MSSM_ERROR_ARGUMENT);
        WATCH_FAIL(mssm_gl_begin_depth(g, i, 0), MSSM_ERROR_ARGUMENT);
        CHECK(strstr(fakes.message, i < 0 ? "light -1: 0 to 1" : "light 2: 0 to 1"), "\"%s\"", fakes.message);
    }
    WATCH_FAIL(mssm_gl_set_light(g, 0, NULL), MSSM_ERROR_ARGUMENT);
    WATCH_FAIL(mssm_gl_set_light(NULL, 0, &light), MSSM_ERROR_ARGUMENT);
    WATCH_FAIL(mssm_gl_begin_depth(NULL, 0, 0), MSSM_ERROR_ARGUMENT);
    WATCH_FAIL(mssm_gl_end_depth(NULL), MSSM_ERROR_ARGUMENT);
    WATCH_FAIL(mssm_gl_build(NULL), MSSM_ERROR_ARGUMENT);
    WATCH_FAIL(mssm_gl_bind(NULL), MSSM_ERROR_ARGUMENT);
    WATCH_FAIL(mssm_gl_resize(NULL, 1, 32), MSSM_ERROR_ARGUMENT);
    CHECK(!mssm_gl_texture(NULL, 0) && !mssm_gl_texture(g, -1) && !mssm_gl_texture(g, 3),
          "textures that are none");
    CHECK(mssm_gl_shader(NULL) == NULL || mssm_gl_shader(NULL)[0] == '\0', "shader of nothing");
    mssm_light broken = light;
    broken.world_to_shadow[5] = NAN;
    fakes.messages = 0;
    WATCH_FAIL(mssm_gl_set_light(g, 0, &broken), MSSM_ERROR_ARGUMENT);
    WATCH_FAIL(mssm_gl_set_moments(g, 0, 0), MSSM_ERROR_ARGUMENT);
    WATCH_FAIL(mssm_gl_set_moments(g, 0, 12345), MSSM_ERROR_ARGUMENT);
    WATCH_FAIL(mssm_gl_set_moments(g, 2, 1), MSSM_ERROR_ARGUMENT);
    CHECK(fakes.messages == 4, "%d messages for 4 refusals", fakes.messages);
    mssm_gl_destroy(g);
    end_gl();
}

static void wrong_order_is_refused(void)
{
    const mssm_gl_desc d = description(2, 32, 4, 6);
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        s.light[0] = wide_light(false, 1);
        CHECK(mssm_gl_set_light(s.gl, 0, &s.light[0]) == MSSM_OK, "set light");
        WATCH_FAIL(mssm_gl_end_depth(s.gl), MSSM_ERROR_ORDER);
        WATCH_FAIL(mssm_gl_begin_depth(s.gl, 0, 1), MSSM_ERROR_ORDER); // back faces first
        CHECK(mssm_gl_begin_depth(s.gl, 0, 0) == MSSM_OK, "begin");
        WATCH_FAIL(mssm_gl_begin_depth(s.gl, 0, 0), MSSM_ERROR_ORDER);
        WATCH_FAIL(mssm_gl_begin_depth(s.gl, 1, 1), MSSM_ERROR_ORDER);
        WATCH_FAIL(mssm_gl_build(s.gl), MSSM_ERROR_ORDER);
        WATCH_FAIL(mssm_gl_resize(s.gl, 1, 64), MSSM_ERROR_ORDER);
        CHECK(mssm_gl_end_depth(s.gl) == MSSM_OK, "end");
        WATCH_FAIL(mssm_gl_end_depth(s.gl), MSSM_ERROR_ORDER);
        WATCH_FAIL(mssm_gl_begin_depth(s.gl, 1, 1), MSSM_ERROR_ORDER); // of another light
        CHECK(mssm_gl_build(s.gl) == MSSM_OK, "build");
        WATCH_FAIL(mssm_gl_begin_depth(s.gl, 0, 1), MSSM_ERROR_ORDER); // front faces are gone
        CHECK(mssm_gl_begin_depth(s.gl, 0, 0) == MSSM_OK, "begin");
        CHECK(mssm_gl_end_depth(s.gl) == MSSM_OK, "end");
        CHECK(mssm_gl_resize(s.gl, 2, 32) == MSSM_OK, "resize");
        WATCH_FAIL(mssm_gl_begin_depth(s.gl, 0, 1), MSSM_ERROR_ORDER); // again
        // Destroyed in the middle of a pass: the state comes back all the same.
        gl_state_take(&before);
        CHECK(mssm_gl_begin_depth(s.gl, 0, 0) == MSSM_OK, "begin");
        mssm_gl_destroy(s.gl);
        same_state("begin, destroy", NULL);
        drop_maps(&s);
    }
    end_gl();
}

// Zero means the default, in every member.
static void defaults(void)
{
    enum { SIDE = 256, COUNT = SIDE * SIDE * 4 };
    mssm_gl_desc d;
    uint64_t seed = 37;
    subject s;
    if (!begin_gl()) return;
    memset(&d, 0, sizeof d);
    d.load = gl_fakes_load;
    memset(&s, 0, sizeof s);
    CHECK(mssm_gl_create(&s.gl, &d) == MSSM_OK, "create");
    if (s.gl) {
        enum { POINTS = 1000 };
        static float points[3 * POINTS];
        agreement a = {0, 0, 0, 0, 0};
        difference all = {0, 0, 0};
        scene c;
        float *z = allocate(sizeof *z * COUNT);
        s.desc = description(1, SIDE, 4, 6);
        make_maps(&s);
        scene_make(&c, 0);
        CHECK(scene_light(&c, 0.2, 0.2, &s.light[0]) == MSSM_OK, "light");
        scene_depth(&c, &s.light[0], SIDE, 4, z, NULL);
        fill(&s, 0, z, NULL);
        build(&s);
        compare_level(&s, 0, 0, &all); // this light needs no more
        CHECK(all.largest <= slack(), "tables differ by %d", all.largest);
        random_points(&c, POINTS, points, &seed);
        compare_visibility(&s, 0, "defaults", POINTS, points, &a);
        free(z);
        drop_subject(&s);
    }
    end_gl();
}

static long resident_pages(void)
{
    FILE *f = fopen("/proc/self/statm", "r");
    long total = 0, resident = 0;
    if (!f) return 0;
    if (fscanf(f, "%ld %ld", &total, &resident) != 2) resident = 0;
    fclose(f);
    return resident;
}

static void many_lives_do_not_grow(void)
{
    const int lives = test_trials(200);
    const mssm_gl_desc d = description(4, 256, 4, 6);
    long half = 0;
    if (!begin_gl()) return;
    for (int i = 0; i < lives; i++) {
        mssm_gl *g = NULL;
        const mssm_light light = wide_light(false, 1);
        CHECK(mssm_gl_create(&g, &d) == MSSM_OK, "life %d: %s", i, fakes.message);
        CHECK(mssm_gl_set_light(g, 0, &light) == MSSM_OK, "set light");
        CHECK(mssm_gl_begin_depth(g, 0, 0) == MSSM_OK && mssm_gl_end_depth(g) == MSSM_OK, "pass");
        CHECK(mssm_gl_build(g) == MSSM_OK, "build");
        mssm_gl_destroy(g);
        gl.Finish();
        nothing_is_left("a life");
        if (i == lives / 2) half = resident_pages();
    }
    const long growth = resident_pages() - half;
    test_note("%d lives, %ld pages more after the second half", lives, growth);
    CHECK(lives < 100 || growth < 1000, "%ld pages", growth);
    end_gl();
}

static void resize_keeps_lights_and_empties_maps(void)
{
    static const int sizes[][2] = {{4, 50}, {1, 50}, {3, 20}, {3, 130}, {5, 64}};
    const mssm_gl_desc d = description(3, 64, 4, 6);
    uint64_t seed = 38;
    subject s;
    static float points[3 * 200], v[200];
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        for (size_t n = 0; n < sizeof sizes / sizeof *sizes; n++) {
            CHECK(mssm_gl_resize(s.gl, sizes[n][0], sizes[n][1]) == MSSM_OK, "resize %d", (int)n);
            const int had = s.desc.lights;
            drop_maps(&s);
            s.desc.lights = sizes[n][0];
            s.desc.side = sizes[n][1];
            make_maps(&s);
            const int count = s.desc.side * s.desc.side * 4;
            float *z = allocate(sizeof *z * (size_t)count);
            for (int i = 0; i < 600; i++) points[i] = (float)test_range(&seed, -3, 3);
            for (int i = 0; i < s.desc.lights; i++) {
                ask(&s, i, false, 200, points, v);
                for (int k = 0; k < 200; k++) CHECK(v[k] > 0.999f, "not empty: %g", (double)v[k]);
                random_depth(z, s.desc.side, 4, &seed);
                if (i >= had || n == 0) {
                    s.light[i] = wide_light(false, 3);
                    fill(&s, i, z, NULL);
                } else {
                    fill_pass(&s, i, false, z); // the light of before
                    fill_map(&s, i, z, NULL);
                }
            }
            build(&s);
            for (int i = 0; i < s.desc.lights; i++) {
                difference all = {0, 0, 0};
                agreement a = {0, 0, 0, 0, 0};
                compare_tables(&s, i, &all);
                CHECK(all.largest <= slack(), "resize %d, light %d: off by %d", (int)n, i,
                      all.largest);
                compare_visibility(&s, i, "after resize", 200, points, &a);
            }
            free(z);
        }
        drop_subject(&s);
    }
    end_gl();
}

// Only what was drawn since is built; other lights keep their maps.
static void lights_are_updated_alone(void)
{
    enum { SIDE = 64, COUNT = SIDE * SIDE * 4 };
    static float z[COUNT];
    const mssm_gl_desc d = description(4, SIDE, 4, 6);
    uint64_t seed = 39;
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        for (int i = 0; i < 4; i++) s.light[i] = wide_light(false, 2);
        for (int round = 0; round < 12; round++) {
            const int drawn = round ? 1 + (int)(test_random(&seed) % 15) : 15; // lights, as bits
            for (int i = 3; i >= 0; i--) {
                if (!(drawn >> i & 1)) continue;
                random_depth(z, SIDE, 4, &seed);
                fill(&s, i, z, round % 3 ? NULL : z);
            }
            build(&s);
            for (int i = 0; i < 4; i++) {
                difference all = {0, 0, 0};
                compare_tables(&s, i, &all);
                CHECK(all.largest <= slack(), "round %d, drawn %d, light %d: off by %d", round,
                      drawn, i, all.largest);
            }
        }
        drop_subject(&s);
    }
    end_gl();
}

// Front faces wait for their back faces. Whatever comes instead, each map is that of its own passes, and of the
// light as it was then.
static void front_faces_wait(void)
{
    enum { SIDE = 40, COUNT = SIDE * SIDE * 4 };
    static float z[3 * COUNT];
    const mssm_gl_desc d = description(3, SIDE, 4, 6);
    uint64_t seed = 72;
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        for (int next = 0; next < 6; next++) {
            const mssm_light spot = wide_light(true, 3);
            const float eye[3] = {1, 5, 1.5f}, to_light[3] = {0.3f, 1, 0.45f}, axis[3] = {1, 0, 0.2f};
            difference all = {0, 0, 0};
            mssm_light moved;
            CHECK(!mssm_light_spot(&moved, eye, to_light, axis, 0.7f, 0.5f, 9, 3, 3), "light");
            for (int i = 0; i < 3; i++) {
                s.light[i] = i ? wide_light(false, 3) : spot;
                random_depth(z + i * COUNT, SIDE, 4, &seed);
                fill(&s, i, z + i * COUNT, NULL);
            }
            random_depth(z, SIDE, 4, &seed);
            fill(&s, 0, z, NULL);
            if (next == 0) build(&s); // nothing comes between
            if (next == 1) CHECK(!mssm_gl_set_light(s.gl, 0, &moved), "light");
            if (next == 2) fill(&s, 1, z + COUNT, NULL);
            if (next == 3) fill(&s, 1, z + COUNT, z + 2 * COUNT);
            if (next == 4) CHECK(!mssm_gl_bind(s.gl), "bind");
            if (next == 5) CHECK(mssm_gl_set_depth(s.gl, 0, NULL, NULL), "nothing given");
            build(&s);
            for (int i = 0; i < 3; i++) compare_tables(&s, i, &all);
            CHECK(all.largest < 60, "after %d: off by %d", next, all.largest);
        }
        drop_subject(&s);
    }
    end_gl();
}

// More lights than one dispatch builds.
static void many_lights(void)
{
    enum { SIDE = 12, LIGHTS = 300, COUNT = SIDE * SIDE * 4 };
    static float z[COUNT];
    static subject s;
    const mssm_gl_desc d = description(LIGHTS, SIDE, 4, 6);
    uint64_t seed = 42;
    difference all = {0, 0, 0};
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        for (int i = 0; i < LIGHTS; i++) {
            if (stride() > 1 && i % 50) continue; // not drawn: lit
            s.light[i] = wide_light(false, 0.5f);
            random_depth(z, SIDE, 4, &seed);
            fill(&s, i, z, NULL);
        }
        build(&s);
        for (int i = 0; i < LIGHTS; i += 50) compare_tables(&s, i, &all);
        for (int i = 254; i < 258 && stride() == 1; i++) compare_tables(&s, i, &all);
        CHECK(all.largest <= slack(), "off by %d", all.largest);
        drop_subject(&s);
    }
    end_gl();
}

// The size of a light is no matter of its depth map: it may change without another pass, and then
// ask for coarser levels than were built, of its own map or of another's.
static void sizes_change_without_drawing(void)
{
    enum { SIDE = 200, COUNT = SIDE * SIDE * 4, POINTS = 2000 };
    static float z[COUNT], points[3 * POINTS];
    static const float sizes[] = {0.01f, 0.6f, 0.02f, 1.5f, 0.3f, 3};
    const mssm_gl_desc d = description(2, SIDE, 4, 6);
    uint64_t seed = 43;
    scene c;
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        scene_make(&c, 1);
        for (int i = 0; i < 2; i++) {
            CHECK(!scene_light(&c, 0.01, 0.01, &s.light[i]), "light");
            scene_depth(&c, &s.light[i], SIDE, 4, z, NULL);
            fill(&s, i, z, NULL);
        }
        build(&s);
        for (size_t n = 0; n < sizeof sizes / sizeof *sizes; n++) {
            agreement a = {0, 0, 0, 0, 0};
            CHECK(!scene_light(&c, (double)sizes[n], (double)sizes[n], &s.light[n % 2]), "light");
            CHECK(mssm_gl_set_light(s.gl, (int)(n % 2), &s.light[n % 2]) == MSSM_OK, "set light");
            if (n % 3) build(&s); // nothing was drawn: an application may leave it out
            random_points(&c, POINTS, points, &seed);
            for (int i = 0; i < 2; i++) {
                compare_visibility(&s, i, "after a change of size", POINTS, points, &a);
            }
        }
        drop_subject(&s);
    }
    end_gl();
}

static void two_contexts_at_once(void)
{
    enum { COUNT = 70 * 70 * 4 };
    static float z[COUNT];
    const mssm_gl_desc d[2] = {description(1, 70, 4, 6), description(2, 33, 4, 4)};
    uint64_t seed = 40;
    gl_context contexts[2];
    subject s[2];
    if (!begin_gl()) return;
    contexts[0] = stage.context;
    if (!gl_test_make_current(&contexts[0])) {
        end_gl();
        return;
    }
    bool made = make_subject(&s[0], &d[0]);
    CHECK(made, "first context");
    if (made && gl_test_begin(&contexts[1])) {
        const GLuint first_fill = stage.fill, first_array = stage.array;
        GLuint fills[2], arrays[2];
        make_programs(); // in the second context
        fills[0] = first_fill, fills[1] = stage.fill;
        arrays[0] = first_array, arrays[1] = stage.array;
        made = make_subject(&s[1], &d[1]);
        for (int round = 0; round < 6 && made; round++) {
            const int k = round % 2;
            difference all = {0, 0, 0};
            gl_test_make_current(&contexts[k]);
            stage.fill = fills[k], stage.array = arrays[k];
            s[k].light[0] = wide_light(k, 1);
            random_depth(z, s[k].desc.side, 4, &seed);
            fill(&s[k], 0, z, NULL);
            build(&s[k]);
            compare_tables(&s[k], 0, &all);
            CHECK(all.largest <= (k ? 60 : slack()), "context %d: off by %d", k, all.largest);
        }
        gl_test_make_current(&contexts[1]);
        if (made) drop_subject(&s[1]);
        CHECK(gl.GetError() == GL_NO_ERROR, "second context");
        gl_context_destroy(&contexts[1]);
    }
    gl_test_make_current(&contexts[0]);
    if (s[0].gl) drop_subject(&s[0]);
    end_gl();
}

// ---- 8. Depth maps that the renderer already has ---------------------------------------------------

enum { FLAT = 0x0DE1, FLAT_ARRAY = 0x8C1A, CUBE = 0x8513, CUBE_ARRAY = 0x9009, SAMPLES = 0x9100, SAMPLES_ARRAY = 0x9102,
       DEPTH16 = 0x81A5, DEPTH24_STENCIL = 0x88F0, DEPTH32F_STENCIL = 0x8CAD, RED16 = 0x822A, RED32F = 0x822E, RED8UI = 0x8232,
       COMPARE_MODE = 0x884C, COMPARE = 0x884E, SWIZZLE_RED = 0x8E42, STENCIL_MODE = 0x90EA, STENCIL = 0x1901, ZERO = 0 };

// Depths in [0,1] that floats, and sums and differences of a few of them, hold exactly.
static void dyadic_depth(float *v, int count, uint64_t *seed)
{
    const double low = test_uniform(seed);
    for (int i = 0; i < count; i++) {
        const double r = test_range(seed, i % 7 ? low : 0, 1);
        v[i] = i % 5 == 4 ? 1 : (float)(floor(r * 65536) / 65536);
    }
}

// A texture whose layers hold v, samples of a texel side by side: [layer][y][x][sample].
static GLuint given_texture(GLenum target, GLenum format, int width, int height, int layers, int samples, const float *v)
{
    const bool multisampled = target == SAMPLES || target == SAMPLES_ARRAY, red = format == RED16 || format == RED32F;
    const GLenum from = red ? 0x1903 : 0x1902; // GL_RED, GL_DEPTH_COMPONENT
    GLuint texture, framebuffer;
    gl.CreateTextures(target, 1, &texture);
    if (target == SAMPLES) gl.TextureStorage2DMultisample(texture, samples, format, width, height, GL_TRUE);
    if (target == SAMPLES_ARRAY) {
        void(GL_CALL * storage)(GLuint, GLsizei, GLenum, GLsizei, GLsizei, GLsizei, GLboolean);
        const gl_fakes_function f = gl_context_function("glTextureStorage3DMultisample");
        memcpy(&storage, &f, sizeof f);
        storage(texture, samples, format, width, height, layers, GL_TRUE);
    }
    if (target == FLAT || target == CUBE) gl.TextureStorage2D(texture, 1, format, width, height);
    if (target == FLAT_ARRAY || target == CUBE_ARRAY) gl.TextureStorage3D(texture, 1, format, width, height, layers);
    if (target == FLAT) gl.TextureSubImage2D(texture, 0, 0, 0, width, height, from, GL_FLOAT, v);
    else if (!multisampled) gl.TextureSubImage3D(texture, 0, 0, 0, 0, width, height, layers, from, GL_FLOAT, v);
    for (int i = 0; i < layers && multisampled; i++) {
        const GLuint buffer = bind_window(v + i * width * height * samples, width, height, samples);
        gl.CreateFramebuffers(1, &framebuffer);
        if (target == SAMPLES) gl.NamedFramebufferTexture(framebuffer, 0x8D00, texture, 0);
        else gl.NamedFramebufferTextureLayer(framebuffer, 0x8D00, texture, 0, i);
        gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
        gl.Viewport(0, 0, width, height);
        gl.Enable(GL_DEPTH_TEST);
        gl.DepthFunc(GL_ALWAYS);
        bind_fill(false);
        gl.DrawArrays(GL_TRIANGLES, 0, 3);
        gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
        gl.DeleteFramebuffers(1, &framebuffer);
        gl.DeleteBuffers(1, &buffer);
        gl.Disable(GL_DEPTH_TEST);
        gl.DepthFunc(GL_LESS);
        gl.UseProgram(0);
        gl.BindVertexArray(0);
    }
    // As the renderer uses it: shadow samplers, other channels, the stencil of both.
    static const GLint state[][2] = {{COMPARE_MODE, COMPARE}, {GL_TEXTURE_MIN_FILTER, 0x2703}, {GL_TEXTURE_MAG_FILTER, 0x2601}};
    for (int i = 0; i < 3 && !multisampled; i++) gl.TextureParameteri(texture, (GLenum)state[i][0], state[i][1]);
    gl.TextureParameteri(texture, SWIZZLE_RED, ZERO);
    if (format == DEPTH24_STENCIL || format == DEPTH32F_STENCIL) gl.TextureParameteri(texture, STENCIL_MODE, STENCIL);
    return texture;
}

static void texture_state_is_kept(GLuint texture, GLenum target, GLenum format)
{
    const bool stencil = format == DEPTH24_STENCIL || format == DEPTH32F_STENCIL;
    GLint swizzle = -1, mode = -1, compare = COMPARE;
    gl.GetTextureParameteriv(texture, SWIZZLE_RED, &swizzle);
    gl.GetTextureParameteriv(texture, STENCIL_MODE, &mode);
    if (target != SAMPLES && target != SAMPLES_ARRAY) gl.GetTextureParameteriv(texture, COMPARE_MODE, &compare);
    CHECK(swizzle == ZERO && (mode == STENCIL) == stencil && compare == COMPARE, "swizzle 0x%X, mode 0x%X, compare 0x%X",
          swizzle, mode, compare);
}

// One pass of our own that draws these window depths.
static void window_pass(subject *s, int index, bool back, const float *window)
{
    const GLuint buffer = bind_window(window, s->desc.side, s->desc.side, s->desc.samples);
    bind_fill(back);
    CHECK(!mssm_gl_begin_depth(s->gl, index, back), "begin");
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    CHECK(!mssm_gl_end_depth(s->gl), "end");
    gl.DeleteBuffers(1, &buffer);
    gl.UseProgram(0);
    gl.BindVertexArray(0);
}

// By how much a texel of two lights' tables differs at most, in units of the tables, or a least depth.
static int maps_differ(const subject *s, int a, int b)
{
    int most = 0, width = 0;
    for (int level = 0, size; level < levels_of(s) && gl_fakes_map_table(s->map[0], level, &size); level++) {
        uint32_t *t[2] = {read_level(s, a, level, size), read_level(s, b, level, size)};
        const size_t right = (size_t)s->desc.moments, up = (size_t)(size + 1) * right;
        for (int y = 0; y < size; y++) {
            for (size_t i = (size_t)y * up; i < (size_t)y * up + (size_t)size * right; i++) {
                const int off = abs(texel_value(t[0] + i, right, up) - texel_value(t[1] + i, right, up));
                most = off > most ? off : most;
            }
        }
        free(t[0]);
        free(t[1]);
    }
    const GLuint least = mssm_gl_texture(s->gl, 2);
    gl.GetTextureLevelParameteriv(least, 0, GL_TEXTURE_WIDTH, &width);
    const size_t texels = (size_t)width * (size_t)width;
    float *z = allocate(sizeof *z * texels * (size_t)s->desc.lights);
    gl.GetTextureImage(least, 0, 0x1903, GL_FLOAT, (GLsizei)(sizeof *z * texels * (size_t)s->desc.lights), z);
    for (size_t i = 0; i < texels; i++) {
        const int off = (int)ceil(2945788 * fabs((double)z[(size_t)a * texels + i] - (double)z[(size_t)b * texels + i]));
        most = off > most ? off : most;
    }
    free(z);
    return most;
}

// Within a frame, where the second time nothing is asked.
static mssm_result given_frame(mssm_gl *g, int index, const mssm_gl_depth given[2])
{
    mssm_result r = mssm_gl_begin_frame(g);
    for (int i = 0; i < 2 && !r; i++) r = mssm_gl_set_depth(g, index, &given[0], &given[1]);
    return r ? r : mssm_gl_end_frame(g);
}

// Every kind of texture, front alone and with back faces, in an atlas' corner: what a pass of our own makes of
// the same depth, to the last bit. The state is left alone, the texture's too.
static void given_depth_is_a_pass(void)
{
    enum { SIDE = 24, X = 5, Y = 8, WIDTH = SIDE + 9, LAYERS = 12, TEXELS = WIDTH * WIDTH * 4 };
    static const struct {
        GLenum target, format;
        int layers, samples;
    } cases[] = {{FLAT, GL_DEPTH_COMPONENT32F, 1, 1},        {FLAT, DEPTH16, 1, 1},
                 {FLAT, DEPTH24_STENCIL, 1, 1},              {FLAT, RED32F, 1, 1},
                 {FLAT_ARRAY, GL_DEPTH_COMPONENT32F, 5, 1},  {FLAT_ARRAY, DEPTH32F_STENCIL, 3, 1},
                 {CUBE, GL_DEPTH_COMPONENT32F, 6, 1},        {CUBE_ARRAY, GL_DEPTH_COMPONENT32F, 12, 1},
                 {SAMPLES, GL_DEPTH_COMPONENT32F, 1, 4},     {SAMPLES_ARRAY, GL_DEPTH_COMPONENT32F, 4, 4},
                 {SAMPLES, DEPTH32F_STENCIL, 1, 4}};
    static float v[2][LAYERS * TEXELS], own[2][SIDE * SIDE * 4];
    uint64_t seed = 61;
    int compared = 0;
    if (!begin_gl()) return;
    const mssm_gl_desc d = description(2, SIDE, 4, 6);
    subject s;
    if (make_subject(&s, &d)) {
        for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
            const int layers = cases[c].layers, layer = layers - 1, n = cases[c].samples;
            if (n > 1 && n != s.desc.samples) continue;
            GLuint texture[2];
            for (int k = 0; k < 2; k++) {
                const int size = WIDTH * WIDTH * n;
                dyadic_depth(v[k], layers * size, &seed);
                texture[k] = given_texture(cases[c].target, cases[c].format, WIDTH, WIDTH, layers, n, v[k]);
                if (n == 1) {
                    float *back = v[k]; // as the format rounds it
                    gl.GetTextureImage(texture[k], 0, cases[c].format == RED32F ? 0x1903 : 0x1902, GL_FLOAT,
                                       (GLsizei)(sizeof *back) * layers * size, back);
                }
                for (int i = 0; i < SIDE * SIDE * s.desc.samples; i++) { // equal samples are one
                    const int texel = i / s.desc.samples, x = texel % SIDE + X, y = texel / SIDE + Y;
                    own[k][i] = v[k][layer * size + (y * WIDTH + x) * n + i % n];
                }
            }
            for (int round = 0; round < 4; round++) {
                const bool spot = round & 1, back = round & 2;
                mssm_gl_depth given[2];
                memset(given, 0, sizeof given);
                for (int k = 0; k < 2; k++) {
                    given[k].texture = texture[k];
                    given[k].target = cases[c].target == FLAT && round ? 0 : cases[c].target;
                    given[k].layer = layer;
                    given[k].x = X;
                    given[k].y = Y;
                    given[k].width = given[k].height = SIDE;
                }
                for (int i = 0; i < 2; i++) {
                    s.light[i] = wide_light(spot, 3);
                    CHECK(!mssm_gl_set_light(s.gl, i, &s.light[i]), "light");
                }
                window_pass(&s, 0, false, own[0]);
                if (back) window_pass(&s, 0, true, own[1]);
                if (round < 3) {
                    WATCH_OK(mssm_gl_set_depth(s.gl, 1, &given[0], back ? &given[1] : NULL), NULL);
                } else {
                    WATCH_OK(given_frame(s.gl, 1, given), NULL);
                }
                for (int k = 0; k < 2; k++) texture_state_is_kept(texture[k], cases[c].target, cases[c].format);
                build(&s);
                // 24 bits are not floats: drivers read them back and sample them with roundings of their own.
                const int off = maps_differ(&s, 0, 1);
                CHECK(off <= (cases[c].format == DEPTH24_STENCIL ? 100 : 0), "target 0x%X, format 0x%X, round %d: off by %d",
                      cases[c].target, cases[c].format, round, off);
                compared++;
            }
            gl.DeleteTextures(2, texture);
        }
        drop_subject(&s);
    }
    test_note("%d maps", compared);
    CHECK(compared >= 32, "only %d", compared);
    end_gl();
}

// Depth of a stored value by hand: an oracle in double.
static double stored_depth(const mssm_light *light, const mssm_gl_depth *d, double v, double x, double y)
{
    const bool ours = d->z_near == 0 && d->z_far == 0;
    const double n = (double)(ours ? light->z_near : d->z_near), f = (double)(ours ? light->z_far : d->z_far);
    const double far = d->reversed ? 1 - v : v;
    double w = n + far * (f - n);
    if (far >= 1) return 1;
    if (light->perspective && d->stored == MSSM_STORED_WINDOW) w = isinf(f) ? n / (1 - far) : n * f / (f - far * (f - n));
    if (d->stored == MSSM_STORED_RADIAL) {
        w /= sqrt(1 + x * x * (double)(light->extent_u * light->extent_u) + y * y * (double)(light->extent_v * light->extent_v));
    }
    const double a = (double)light->z_near, b = (double)light->z_far;
    return fmin(fmax(-1 + 2 * (w - a) / (b - a), -1), 1);
}

// However depth is stored, and whatever part of a texture it fills: the CPU's map of what that means.
static void given_depth_means_what_it_says(void)
{
    enum { SIDE = 20, MOST = SIDE * SIDE * 64 };
    static const struct {
        int spot, across, up, samples;
        mssm_stored stored;
        int reversed;
        float z_near, z_far;
    } cases[] = {{0, 1, 1, 1, MSSM_STORED_WINDOW, 1, 0, 0},     {0, 1, 1, 4, MSSM_STORED_WINDOW, 1, 0, 0},
                 {0, 2, 2, 1, MSSM_STORED_WINDOW, 0, 0, 0},     {0, 4, 2, 1, MSSM_STORED_LINEAR, 0, 0, 0},
                 {0, 8, 8, 1, MSSM_STORED_WINDOW, 1, 0, 0},     {0, 2, 4, 4, MSSM_STORED_WINDOW, 0, 0, 0},
                 {0, 1, 1, 1, MSSM_STORED_WINDOW, 0, -3, 9},    {0, 1, 1, 1, MSSM_STORED_LINEAR, 1, -3, 9},
                 {1, 1, 1, 1, MSSM_STORED_WINDOW, 1, 0, 0},     {1, 1, 1, 1, MSSM_STORED_WINDOW, 0, 0.5f, 30},
                 {1, 1, 1, 1, MSSM_STORED_WINDOW, 1, 0.5f, 30}, {1, 1, 1, 4, MSSM_STORED_WINDOW, 1, 1.25f, INFINITY},
                 {1, 2, 1, 1, MSSM_STORED_WINDOW, 0, 1.25f, INFINITY},
                 {1, 1, 1, 1, MSSM_STORED_LINEAR, 0, 0, 0},     {1, 1, 1, 1, MSSM_STORED_LINEAR, 1, 0, 0},
                 {1, 1, 3, 1, MSSM_STORED_LINEAR, 0, 0, 12},    {1, 1, 1, 1, MSSM_STORED_RADIAL, 0, 0, 0},
                 {1, 1, 1, 1, MSSM_STORED_RADIAL, 1, 0, 12}};
    static float v[MOST], z[MOST];
    const mssm_gl_desc d = description(1, SIDE, 1, 6);
    uint64_t seed = 62;
    int worst = 0;
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
            const int across = cases[c].across, up = cases[c].up, n = cases[c].samples, each = across * up * n;
            const int width = SIDE * across, height = SIDE * up;
            const bool exact = !cases[c].spot && cases[c].z_near == cases[c].z_far;
            mssm_gl_depth given;
            difference all = {0, 0, 0};
            memset(&given, 0, sizeof given);
            given.target = n > 1 ? SAMPLES : FLAT;
            given.stored = cases[c].stored;
            given.reversed = cases[c].reversed;
            given.z_near = cases[c].z_near;
            given.z_far = cases[c].z_far;
            s.light[0] = wide_light(cases[c].spot, 3);
            dyadic_depth(v, width * height * n, &seed);
            for (int i = 0; i < width * height * n && given.reversed; i++) v[i] = 1 - v[i];
            given.texture = given_texture(given.target, GL_DEPTH_COMPONENT32F, width, height, 1, n, v);
            for (int i = 0; i < width * height * n; i++) {
                const int x = i / n % width, y = i / n / width, texel = y / up * SIDE + x / across;
                const double at[2] = {(2.0 * (x / across) + 1) / SIDE - 1, (2.0 * (y / up) + 1) / SIDE - 1};
                z[texel * each + (y % up * across + x % across) * n + i % n] =
                    (float)stored_depth(&s.light[0], &given, (double)v[i], at[0], at[1]);
            }
            CHECK(!mssm_gl_set_light(s.gl, 0, &s.light[0]), "light");
            CHECK(!mssm_gl_set_depth(s.gl, 0, &given, NULL), "case %d: %s", (int)c, fakes.message);
            CHECK(!mssm_map_update(s.map[0], z, NULL, each), "update");
            build(&s);
            compare_tables(&s, 0, &all);
            CHECK(all.values > 0 && all.largest <= (exact ? slack() : 60), "case %d: off by %d", (int)c, all.largest);
            if (!exact && all.largest > worst) worst = all.largest;
            gl.DeleteTextures(1, &given.texture);
        }
        test_note("a texel differs by at most %.2g of a value where depth is computed", worst / 2945788.0);
        drop_subject(&s);
    }
    end_gl();
}

// A renderer's own depth pass: casters by its matrix into a layer of its texture, single-sampled.
static void own_pass(const mesh *m, const mssm_light *drawn, GLuint texture, int layer, const int area[3], bool reversed,
                     GLuint program)
{
    const GLfloat farthest = reversed ? 0 : 1;
    GLuint framebuffer;
    gl.CreateFramebuffers(1, &framebuffer);
    if (layer < 0) gl.NamedFramebufferTexture(framebuffer, 0x8D00, texture, 0);
    else gl.NamedFramebufferTextureLayer(framebuffer, 0x8D00, texture, 0, layer);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl.ClearNamedFramebufferfv(framebuffer, 0x1801, 0, &farthest); // GL_DEPTH
    gl.Viewport(area[0], area[1], area[2], area[2]);
    gl.ClipControl(0x8CA1, 0x935F); // lower left, zero to one
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(reversed ? 0x0204 : GL_LESS); // GL_GREATER
    gl.ProgramUniformMatrix4fv(program, gl.GetUniformLocation(program, "world_to_shadow"), 1, GL_FALSE,
                               drawn->world_to_shadow);
    gl.UseProgram(program);
    gl.BindVertexArray(m->array);
    gl.DrawArrays(GL_TRIANGLES, 0, m->vertices);
    gl.UseProgram(0);
    gl.BindVertexArray(0);
    gl.ClipControl(0x8CA1, 0x935E);
    gl.DepthFunc(GL_LESS);
    gl.Disable(GL_DEPTH_TEST);
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl.DeleteFramebuffers(1, &framebuffer);
}

// As docs/integration.md has it: a sun with depth of 0 to 1, normal and reversed, a lamp in an atlas, reversed and
// without a far plane, and a face of distances. The shadows are those of the library's own pass.
static void own_depth_maps_cast_the_same_shadows(void)
{
    enum { SIDE = 128, POINTS = 3000 };
    static const char *const distances[2] = {
        "layout(location = 0) in vec3 position;\n"
        "uniform mat4 world_to_shadow;\n"
        "out vec3 world;\n"
        "void main() { world = position; gl_Position = world_to_shadow * vec4(position, 1); }\n",
        "in vec3 world;\n"
        "uniform vec4 lamp;\n"
        "void main() { gl_FragDepth = distance(world, lamp.xyz) / lamp.w; }\n"};
    static float points[3 * POINTS], v[2][POINTS];
    const mssm_gl_desc d = description(2, SIDE, 4, 6);
    const float eye[3] = {0.5f, 6, 1}, to_light[3] = {0.05f, 1, 0.1f}, axis[3] = {1, 0, 0}, far = 12;
    uint64_t seed = 65;
    scene c;
    mesh m;
    subject s;
    if (!begin_gl()) return;
    scene_make(&c, 1);
    make_mesh(&m, &c);
    const GLuint program = link_program(distances);
    const float lamp[4] = {eye[0], eye[1], eye[2], far};
    gl.ProgramUniform4fv(program, gl.GetUniformLocation(program, "lamp"), 1, lamp);
    if (make_subject(&s, &d)) {
        for (int kind = 0; kind < 4; kind++) {
            const bool sun = kind < 2, reversed = kind == 1 || kind == 2;
            const int size = 2 * SIDE, at = kind == 2 ? 31 : 0, area[3] = {at, at, size};
            mssm_gl_depth given;
            memset(&given, 0, sizeof given);
            mssm_light light, drawn;
            if (sun) CHECK(!scene_light(&c, 0.1, 0.1, &light), "light");
            else CHECK(!mssm_light_spot(&light, eye, to_light, axis, 1, 0.5f, far, 0.5f, 0.5f), "light");
            drawn = light;
            for (int i = 0; i < 4; i++) { // the matrix of a clip space from 0 to 1
                float *row = &drawn.world_to_shadow[4 * i];
                if (sun) row[2] = reversed ? 0.5f * (row[3] - row[2]) : 0.5f * (row[3] + row[2]);
                else row[2] = reversed ? (i == 3 ? light.z_near : 0) : 0.5f * row[3];
            }
            given.target = kind == 3 ? CUBE : FLAT;
            given.layer = kind == 3 ? 3 : 0;
            given.x = given.y = at;
            given.width = given.height = size;
            given.reversed = reversed;
            given.stored = kind == 3 ? MSSM_STORED_RADIAL : MSSM_STORED_WINDOW;
            given.z_near = kind == 2 ? light.z_near : 0;
            given.z_far = kind == 2 ? INFINITY : kind == 3 ? far : 0;
            gl.CreateTextures(given.target, 1, &given.texture);
            gl.TextureStorage2D(given.texture, 1, GL_DEPTH_COMPONENT32F, at + size, at + size);
            own_pass(&m, &drawn, given.texture, kind == 3 ? 3 : -1, area, reversed, kind == 3 ? program : stage.casters);
            s.light[0] = light;
            draw_light(&s, &m, false);
            CHECK(!mssm_gl_set_light(s.gl, 1, &light) && !mssm_gl_set_depth(s.gl, 1, &given, NULL), "%s", fakes.message);
            build(&s);
            random_points(&c, POINTS, points, &seed);
            for (int i = 0; i < 2; i++) ask(&s, i, false, POINTS, points, v[i]);
            double sum = 0, far_off = 0, dark = 0; // samples lie elsewhere in a texel
            for (int i = 0; i < POINTS; i++) {
                const double off = fabs((double)(v[0][i] - v[1][i]));
                sum += off;
                far_off += off > 0.1;
                dark += v[0][i] < 0.9f;
            }
            test_note("%d: visibility differs by %.2g in the mean, by more than .1 for %.0f; %.0f of %d in shadow", kind,
                      sum / POINTS, far_off, dark, (int)POINTS);
            CHECK(dark > 100 && sum / POINTS < 0.01 && far_off < 0.01 * POINTS, "%d: other shadows", kind);
            gl.DeleteTextures(1, &given.texture);
        }
        drop_subject(&s);
    }
    gl.DeleteProgram(program);
    drop_mesh(&m);
    end_gl();
}

// What cannot be read is refused by name and range, and the light's map stays as it was.
static void bad_depth_maps_are_refused(void)
{
    enum { SIDE = 16, WIDTH = 48 };
    const mssm_gl_desc d = description(2, SIDE, 1, 6);
    static float v[WIDTH * WIDTH * 6];
    uint64_t seed = 63;
    subject s;
    if (!begin_gl()) return;
    if (!make_subject(&s, &d)) return;
    dyadic_depth(v, WIDTH * WIDTH * 6, &seed);
    const GLuint flat = given_texture(FLAT, GL_DEPTH_COMPONENT32F, WIDTH, WIDTH, 1, 1, v);
    const GLuint array = given_texture(FLAT_ARRAY, DEPTH16, WIDTH, WIDTH, 3, 1, v);
    const GLuint cube = given_texture(CUBE, DEPTH16, WIDTH, WIDTH, 6, 1, v);
    GLuint other[3];
    gl.CreateTextures(FLAT, 3, other);
    gl.TextureStorage2D(other[0], 1, RED8UI, SIDE, SIDE);
    gl.TextureStorage2D(other[1], 1, GL_DEPTH_COMPONENT32F, 9 * SIDE, 9 * SIDE); // other[2] has no storage
    const mssm_gl_depth good = {flat, 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0};
    const struct {
        mssm_gl_depth given;
        int spot;
        const char *said;
    } bad[] = {
        {{0, 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "no such texture"},
        {{98765, 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "no such texture"},
        {{flat, 0x806F, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "target 0x806F"},
        {{flat, CUBE, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "no GL_TEXTURE_CUBE_MAP"},
        {{array, 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "no GL_TEXTURE_2D"},
        {{flat, 0, 1, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "layer 1: 0 to 0"},
        {{array, FLAT_ARRAY, 3, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "layer 3: 0 to 2"},
        {{cube, CUBE, 6, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "layer 6: 0 to 5"},
        {{cube, CUBE, -1, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "layer -1: 0 to"},
        {{flat, 0, 0, -1, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "x -1: 0 to"},
        {{flat, 0, 0, 0, 48, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "y 48: 0 to 47"},
        {{flat, 0, 0, 40, 0, 16, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "width 16: 1 to 8"},
        {{flat, 0, 0, 0, 1, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "height 47: once to 8 times"},
        {{flat, 0, 0, 0, 0, 24, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "width 24: once to 8 times"},
        {{flat, 0, 0, 0, 0, INT_MAX, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "width 2147483647: 1 to 48"},
        {{other[1], 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "width 144: once to 8 times"},
        {{flat, 0, 0, 0, 0, 0, 0, MSSM_STORED_RADIAL, 0, 0, 0}, 0, "stored 2: 0 to 1"},
        {{flat, 0, 0, 0, 0, 0, 0, (mssm_stored)3, 0, 0, 0}, 1, "stored 3: 0 to 2"},
        {{flat, 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 5}, 1, "z_near 0, z_far 5: 0 < z_near < z_far"},
        {{flat, 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 5, 2}, 1, "z_near 5, z_far 2"},
        {{flat, 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, NAN, 2}, 1, "z_far 2: 0 <"},
        {{flat, 0, 0, 0, 0, 0, 0, MSSM_STORED_LINEAR, 0, 1, INFINITY}, 1, "both finite"},
        {{flat, 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 1, INFINITY}, 0, "both finite"},
        {{other[0], 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "neither depth nor red"},
        {{other[2], 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "no storage"}};
    WATCH_FAIL(mssm_gl_set_depth(s.gl, 0, &good, NULL), MSSM_ERROR_ORDER); // there is no light yet
    CHECK(strstr(fakes.message, "mssm_gl_set_light"), "\"%s\"", fakes.message);
    for (int i = 0; i < 2; i++) {
        s.light[i] = wide_light(false, 3);
        CHECK(!mssm_gl_set_light(s.gl, i, &s.light[i]), "light");
        CHECK(!mssm_gl_set_depth(s.gl, i, &good, &good), "good: %s", fakes.message);
    }
    build(&s);
    gl.DebugMessageCallback(NULL, NULL); // to find out a target raises an error, which is taken away
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const mssm_light light = wide_light(bad[i].spot, 3);
        CHECK(!mssm_gl_set_light(s.gl, 0, &light), "light");
        for (int framed = 0; framed < 2; framed++) {
            fakes.message[0] = 0;
            if (framed) CHECK(!mssm_gl_begin_frame(s.gl), "begin");
            if (!framed) WATCH_FAIL(mssm_gl_set_depth(s.gl, 0, &bad[i].given, NULL), MSSM_ERROR_ARGUMENT);
            else CHECK(mssm_gl_set_depth(s.gl, 0, &bad[i].given, NULL) == MSSM_ERROR_ARGUMENT, "%s", bad[i].said);
            if (framed) CHECK(!mssm_gl_end_frame(s.gl), "end");
            CHECK(strstr(fakes.message, bad[i].said), "not \"%s\" but \"%s\"", bad[i].said, fakes.message);
        }
    }
    CHECK(!mssm_gl_set_light(s.gl, 0, &s.light[0]), "light");
    mssm_gl_depth back = good;
    for (int i = 0; i < 3; i++) {
        back = good;
        if (i == 0) back.texture = array, back.target = FLAT_ARRAY;
        if (i == 1) back.width = 2 * SIDE;
        if (i == 2) back.reversed = 1;
        WATCH_FAIL(mssm_gl_set_depth(s.gl, 0, &good, &back), MSSM_ERROR_ARGUMENT);
        CHECK(strstr(fakes.message, "back must be like front"), "\"%s\"", fakes.message);
    }
    WATCH_FAIL(mssm_gl_set_depth(s.gl, 0, NULL, NULL), MSSM_ERROR_ARGUMENT);
    WATCH_FAIL(mssm_gl_set_depth(s.gl, 2, &good, NULL), MSSM_ERROR_ARGUMENT);
    WATCH_FAIL(mssm_gl_set_depth(NULL, 0, &good, NULL), MSSM_ERROR_ARGUMENT);
    build(&s);
    CHECK(!maps_differ(&s, 0, 1), "a refusal changed the light's map");
    texture_state_is_kept(flat, FLAT, GL_DEPTH_COMPONENT32F);
    CHECK(!mssm_gl_begin_depth(s.gl, 0, 0), "begin");
    WATCH_FAIL(mssm_gl_set_depth(s.gl, 1, &good, NULL), MSSM_ERROR_ORDER);
    CHECK(!mssm_gl_end_depth(s.gl), "end");
    WATCH_OK(mssm_gl_set_depth(s.gl, 0, &good, NULL), NULL);
    WATCH_FAIL(mssm_gl_begin_depth(s.gl, 0, 1), MSSM_ERROR_ORDER); // the front faces are no pass's
    gl.DeleteTextures(1, &flat);
    gl.DeleteTextures(1, &array);
    gl.DeleteTextures(1, &cube);
    gl.DeleteTextures(3, other);
    drop_subject(&s);
    end_gl();
}

// Given depth maps in a bracket beside passes, in any state of the caller's: all bindings come back.
static void given_depth_leaves_bindings_alone(void)
{
    enum { SIDE = 16 };
    const mssm_gl_desc d = description(3, SIDE, 1, 6);
    static float v[SIDE * SIDE * 6], z[SIDE * SIDE * 4];
    gl_state at_begin = {NULL, 0, 0};
    gl_unusual unusual;
    uint64_t seed = 64;
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        dyadic_depth(v, SIDE * SIDE * 6, &seed);
        random_depth(z, SIDE, s.desc.samples, &seed);
        const GLuint flat = given_texture(FLAT, GL_DEPTH_COMPONENT32F, SIDE, SIDE, 1, 1, v);
        const GLuint cube = given_texture(CUBE, DEPTH16, SIDE, SIDE, 6, 1, v);
        mssm_gl_depth given[2];
        memset(given, 0, sizeof given);
        given[0].texture = flat;
        given[1].texture = cube;
        given[1].target = CUBE;
        for (int i = 0; i < 3; i++) {
            s.light[i] = wide_light(false, 3);
            CHECK(!mssm_gl_set_light(s.gl, i, &s.light[i]), "light");
        }
        gl_state_make_unusual(&unusual);
        for (int round = 0; round < 3; round++) {
            gl_state_take(&at_begin);
            CHECK(!mssm_gl_begin_frame(s.gl), "begin");
            for (int k = 0; k < 2; k++) CHECK(!mssm_gl_set_depth(s.gl, k, &given[k], NULL), "%s", fakes.message);
            CHECK(!mssm_gl_begin_depth(s.gl, 2, 0) && !mssm_gl_end_depth(s.gl), "pass");
            CHECK(!mssm_gl_build(s.gl) && !mssm_gl_end_frame(s.gl), "end");
            if (before.capacity < at_begin.count) gl_state_take(&before);
            memcpy(before.entry, at_begin.entry, (size_t)at_begin.count * sizeof *at_begin.entry);
            same_state("a frame of given maps", NULL);
        }
        WATCH_OK(mssm_gl_set_depth(s.gl, 1, &given[1], NULL), NULL);
        gl_state_make_usual(&unusual);
        difference all = {0, 0, 0};
        for (int i = 0; i < SIDE * SIDE; i++) z[i] = 2 * v[i] - 1;
        CHECK(!mssm_map_update(s.map[0], z, NULL, 1), "update");
        compare_tables(&s, 0, &all);
        CHECK(all.values > 0 && all.largest <= slack(), "off by %d", all.largest);
        gl.DeleteTextures(1, &flat);
        gl.DeleteTextures(1, &cube);
        drop_subject(&s);
    }
    gl_state_free(&at_begin);
    end_gl();
}

// ---- 9. To look at and to plan with ----------------------------------------------------------------

// Bytes of all textures and buffers of the context.
static size_t bytes_in_use(void)
{
    static const GLenum bits[] = {0x805C, 0x805D, 0x805E, 0x805F, 0x884A}; // red, green, blue, alpha, depth
    GLboolean(GL_CALL * is_texture)(GLuint), (GL_CALL * is_buffer)(GLuint);
    void(GL_CALL * buffer_parameter)(GLuint, GLenum, GLint *);
    const gl_fakes_function f[3] = {gl_context_function("glIsTexture"), gl_context_function("glIsBuffer"),
                                    gl_context_function("glGetNamedBufferParameteriv")};
    size_t sum = 0;
    memcpy(&is_texture, &f[0], sizeof *f);
    memcpy(&is_buffer, &f[1], sizeof *f);
    memcpy(&buffer_parameter, &f[2], sizeof *f);
    for (GLuint name = 1; name < 400; name++) {
        GLint bytes = 0;
        for (GLint level = 0; level < 16 && is_texture(name); level++) {
            GLint size[3] = {0, 0, 0}, texel = 0, samples = 0;
            for (int i = 0; i < 5; i++) {
                GLint n = 0;
                gl.GetTextureLevelParameteriv(name, level, bits[i], &n);
                texel += n;
            }
            gl.GetTextureLevelParameteriv(name, level, GL_TEXTURE_WIDTH, &size[0]);
            gl.GetTextureLevelParameteriv(name, level, GL_TEXTURE_HEIGHT, &size[1]);
            gl.GetTextureLevelParameteriv(name, level, GL_TEXTURE_DEPTH, &size[2]);
            gl.GetTextureLevelParameteriv(name, level, GL_TEXTURE_SAMPLES, &samples);
            sum += (size_t)size[0] * (size_t)size[1] * (size_t)size[2] * (size_t)(texel / 8 * (samples ? samples : 1));
            if (samples) break; // no levels
        }
        if (!is_buffer(name)) continue;
        buffer_parameter(name, 0x8764, &bytes); // GL_BUFFER_SIZE
        sum += (size_t)bytes;
    }
    return sum;
}

static void bytes_are_counted(void)
{
    static const int cases[][5] = {{1, 256, 4, 6, 0}, {3, 100, 4, 4, 0}, {7, 1, 4, 6, 0},  {2, 300, 4, 6, 0}, {1, 27, 4, 4, 0},
                                   {1, 28, 4, 6, 0},  {2, 100, 4, 4, 1}, {1, 256, 4, 6, 1}};
    if (!begin_gl()) return;
    gl.DebugMessageCallback(NULL, NULL); // a level that is not there may be asked for
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        mssm_gl_desc d = description(cases[i][0], cases[i][1], cases[i][2], cases[i][3]);
        mssm_gl *g = NULL;
        const size_t had = bytes_in_use();
        d.filtered = cases[i][4];
        CHECK(!mssm_gl_create(&g, &d), "create");
        const size_t has = bytes_in_use() - had, said = mssm_gl_bytes(&d);
        CHECK(had == bytes_in_use() - has && said == has, "%d lights of %d: %lu bytes, said %lu", cases[i][0], cases[i][1],
              (unsigned long)has, (unsigned long)said);
        mssm_gl_destroy(g);
        gl.GetError();
    }
    mssm_gl_desc d;
    memset(&d, 0, sizeof d);
    const size_t said = mssm_gl_bytes(&d);
    d = description(1, 256, 4, 6);
    CHECK(said == mssm_gl_bytes(&d), "defaults");
    d.moments = 5;
    CHECK(!mssm_gl_bytes(&d) && strstr(fakes.message, "moments 5"), "\"%s\"", fakes.message);
    d = description(INT_MAX, 16384, 64, 6);
    CHECK(!mssm_gl_bytes(&d) && strstr(fakes.message, "size_t"), "\"%s\"", fakes.message);
    CHECK(!mssm_gl_bytes(NULL), "nothing");
    end_gl();
}

static void stale_lights_are_told(void)
{
    enum { SIDE = 64, COUNT = SIDE * SIDE * 4, BOTH = MSSM_STALE_MAP | MSSM_STALE_TABLES };
    static float z[COUNT];
    const mssm_gl_desc d = description(2, SIDE, 4, 6);
    uint64_t seed = 73;
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        random_depth(z, SIDE, 4, &seed);
        CHECK(mssm_gl_stale(s.gl, 0) == MSSM_STALE_MAP, "new: %d", mssm_gl_stale(s.gl, 0));
        s.light[0] = s.light[1] = wide_light(false, 0.01f);
        fill(&s, 0, z, NULL);
        CHECK(mssm_gl_stale(s.gl, 0) == MSSM_STALE_TABLES, "drawn: %d", mssm_gl_stale(s.gl, 0));
        build(&s);
        CHECK(!mssm_gl_stale(s.gl, 0) && mssm_gl_stale(s.gl, 1) == MSSM_STALE_MAP, "built");
        CHECK(!mssm_gl_set_light(s.gl, 0, &s.light[0]) && !mssm_gl_stale(s.gl, 0), "the same light");
        s.light[0] = wide_light(false, 3);
        CHECK(!mssm_gl_set_light(s.gl, 0, &s.light[0]) && mssm_gl_stale(s.gl, 0) == MSSM_STALE_TABLES, "another size");
        CHECK(!mssm_gl_bind(s.gl) && mssm_gl_stale(s.gl, 0) == MSSM_STALE_TABLES, "bound, not built");
        build(&s);
        CHECK(!mssm_gl_stale(s.gl, 0), "built");
        s.light[0].world_to_shadow[12] += 0.1f;
        CHECK(!mssm_gl_set_light(s.gl, 0, &s.light[0]) && mssm_gl_stale(s.gl, 0) == BOTH, "moved");
        build(&s);
        CHECK(mssm_gl_stale(s.gl, 0) == MSSM_STALE_MAP, "moved, not drawn");
        CHECK(!mssm_gl_resize(s.gl, 2, SIDE) && mssm_gl_stale(s.gl, 0) == MSSM_STALE_MAP, "resized");
        CHECK(!mssm_gl_stale(s.gl, 2) && strstr(fakes.message, "light 2: 0 to 1") && !mssm_gl_stale(NULL, 0), "none");
        drop_subject(&s);
    }
    end_gl();
}

// A map as a picture is the depth that was drawn, whatever the caller's state would do to it.
static void maps_can_be_seen(void)
{
    enum { SIDE = 27, COUNT = SIDE * SIDE * 4, SCALE = 2, SIZE = SCALE * SIDE, WIDTH = SIZE + 3 };
    static float z[COUNT], seen[WIDTH * (SIZE + 5)];
    const mssm_gl_desc d = description(2, SIDE, 4, 6);
    uint64_t seed = 74;
    GLuint texture, framebuffer;
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        for (int i = 0; i < 2; i++) s.light[i] = wide_light(false, 3);
        random_depth(z, SIDE, 4, &seed);
        fill(&s, 1, z, NULL);
        WATCH_FAIL(mssm_gl_show(s.gl, 1, MSSM_SHOW_MEAN), MSSM_ERROR_ORDER);
        build(&s);
        gl.CreateTextures(0x0DE1, 1, &texture);
        gl.TextureStorage2D(texture, 1, RED32F, WIDTH, SIZE + 5);
        gl.CreateFramebuffers(1, &framebuffer);
        gl.NamedFramebufferTexture(framebuffer, 0x8CE0, texture, 0); // GL_COLOR_ATTACHMENT0
        gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
        gl.Viewport(3, 5, SIZE, SIZE);
        gl.Enable(GL_DEPTH_TEST);
        gl.Enable(GL_CULL_FACE);
        gl.CullFace(GL_FRONT_AND_BACK);
        gl.Enablei(0x0BE2, 0); // GL_BLEND
        gl.ColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
        gl.Enable(GL_RASTERIZER_DISCARD);
        for (int what = 0; what < 2; what++) {
            double worst = 0;
            WATCH_OK(mssm_gl_show(s.gl, 1, (mssm_show)what), NULL);
            gl.GetTextureImage(texture, 0, 0x1903, GL_FLOAT, sizeof seen, seen);
            for (int i = 0; i < SIZE * SIZE; i++) {
                const int x = i % SIZE / SCALE, y = i / SIZE / SCALE;
                double wanted = what ? 1 : 0;
                for (int k = 0; k < 4 && !what; k++) wanted += 0.25 * (double)z[(y * SIDE + x) * 4 + k];
                for (int k = 0; k < 16 && what; k++) {
                    const int u = x / 2 * 2 + k % 2, v = y / 2 * 2 + k / 2 % 2;
                    if (u < SIDE && v < SIDE) wanted = fmin(wanted, (double)z[(v * SIDE + u) * 4 + k / 4]);
                }
                worst = fmax(worst, fabs((double)seen[(i / SIZE + 5) * WIDTH + i % SIZE + 3] - (0.5 + 0.5 * wanted)));
            }
            CHECK(worst < 2e-6, "%d: off by %g", what, worst);
        }
        WATCH_FAIL(mssm_gl_show(s.gl, 0, MSSM_SHOW_MEAN), MSSM_ERROR_ORDER); // has no map
        WATCH_FAIL(mssm_gl_show(s.gl, 2, MSSM_SHOW_MEAN), MSSM_ERROR_ARGUMENT);
        WATCH_FAIL(mssm_gl_show(s.gl, 1, (mssm_show)2), MSSM_ERROR_ARGUMENT);
        gl.NamedFramebufferTexture(framebuffer, 0x8CE0, 0, 0);
        WATCH_FAIL(mssm_gl_show(s.gl, 1, MSSM_SHOW_MEAN), MSSM_ERROR_GL); // into nothing
        WATCH_FAIL(mssm_gl_show(NULL, 1, MSSM_SHOW_MEAN), MSSM_ERROR_ARGUMENT);
        gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
        gl.DeleteFramebuffers(1, &framebuffer);
        gl.DeleteTextures(1, &texture);
        drop_subject(&s);
    }
    end_gl();
}

// ---- 10. A second compiler --------------------------------------------------------------------------

static bool have_validator(void)
{
    return system("command -v glslangValidator >/dev/null 2>&1") == 0;
}

// Says what glslangValidator says about a shader, if anything.
static void validate(const char *what, const char *extension, const char *text)
{
    char name[200], command[600], line[300];
    const char *folder = getenv("TMPDIR");
    snprintf(name, sizeof name, "%.100s/mssm_test_gl_%llx.%s", folder ? folder : ".",
             (unsigned long long)(uintptr_t)&name ^ (unsigned long long)resident_pages(),
             extension);
    FILE *f = fopen(name, "w");
    if (!f) {
        CHECK(0, "cannot write %s", name);
        return;
    }
    fputs(text, f);
    fclose(f);
    snprintf(command, sizeof command, "glslangValidator %s >%s.log 2>&1", name, name);
    const int status = system(command);
    snprintf(command, sizeof command, "%s.log", name);
    f = fopen(command, "r");
    const int said = 0;
    while (f && fgets(line, sizeof line, f)) {
        if (!strncmp(line, name, strlen(name)) || line[0] == '\n') continue; // its own name
        line[strcspn(line, "\n")] = '\0';
        CHECK(said, "%s: %s", what, line);
    }
    CHECK(status == 0, "%s: glslangValidator fails", what);
    if (f) fclose(f);
    remove(command);
    remove(name);
}

static void validate_shading(const mssm_gl *g, const char *what)
{
    static const char *const mains[2] = {
        "layout(location = 0) in vec3 position;\nlayout(location = 0) out vec4 colour;\n"
        "void main() { colour = vec4(mssm_visibility(1, position), mssm_visibility_at(0, position),"
        " 0, 1); }\n",
        "layout(local_size_x = 1) in;\nlayout(std430, binding = 9) buffer b { float r[]; };\n"
        "void main() { r[0] = mssm_visibility(0, vec3(r[1])); }\n"};
    const char *shading = mssm_gl_shader(g);
    char *text = allocate(strlen(shading) + 1000);
    for (int i = 0; i < 2; i++) {
        char log[1000] = "";
        GLint compiled = 0;
        strcpy(text, "#version 450 core\n");
        strcat(text, shading);
        strcat(text, mains[i]);
        const GLuint shader = gl.CreateShader(i ? GL_COMPUTE_SHADER : GL_FRAGMENT_SHADER);
        gl.ShaderSource(shader, 1, (const char *const *)&text, NULL);
        gl.CompileShader(shader);
        gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
        gl.GetShaderInfoLog(shader, sizeof log, NULL, log);
        CHECK(compiled && gl_test_quiet(log), "%s: %s", what, log);
        gl.DeleteShader(shader);
        validate(what, i ? "comp" : "frag", text);
    }
    free(text);
}

static void second_compiler_agrees(void)
{
    if (!have_validator()) {
        CHECK(!getenv("TEST_REQUIRE_GL"), "no glslangValidator: apt-get install glslang-tools");
        test_skip("no glslangValidator: apt-get install glslang-tools");
        return;
    }
    if (!begin_gl()) return;
    int texts = 0;
    for (int variant = 0; variant < 5; variant += stride()) {
        mssm_gl_desc d = description(2, 64, variant == 1 ? 1 : 4, variant == 2 ? 4 : 6);
        mssm_gl *g = NULL;
        char what[60];
        d.settings.estimator = (mssm_estimator)(variant % 3);
        d.settings.moments = variant == 3 ? 6 : 0;
        gl_fakes_reset();
        const mssm_result r = whole_life(&g); // shaders may be made when first used
        CHECK(r == MSSM_OK, "%s", mssm_result_string(r));
        if (variant > 0) mssm_gl_destroy(g), g = NULL;
        if (variant > 0 && mssm_gl_create(&g, &d)) continue;
        for (int i = variant ? fakes.text_count / 2 : 0; i < fakes.text_count; i++) {
            const GLenum type = fakes.text_types[i];
            snprintf(what, sizeof what, "own shader %d", i);
            validate(what,
                     type == GL_COMPUTE_SHADER  ? "comp"
                     : type == GL_VERTEX_SHADER ? "vert"
                                                : "frag",
                     fakes.texts[i]);
            texts++;
        }
        snprintf(what, sizeof what, "shading, variant %d", variant);
        validate_shading(g, what);
        CHECK(!fakes.bad_logs, "%d shaders with a log", fakes.bad_logs);
        mssm_gl_destroy(g);
    }
    test_note("%d texts of its own, 10 of shading", texts);
    end_gl();
}

// The shader has the same text.
static void level_holds_kernel(void)
{
    const float hostile[] = {0, -0.0f, -1, -INFINITY, 1e-40f, INFINITY, NAN, -NAN};
    for (int levels = 1; levels <= 11; levels++) {
        for (int k = 0; k < 12; k++) {
            const float most = ldexpf(27, k), at[] = {nextafterf(most, 0), most, nextafterf(most, 1e9f)};
            for (int i = 0; i < 3; i++) {
                int level = 0;
                while (level < levels - 1 && ldexp(27, level) < (double)at[i]) level++;
                const int found = gl_fakes_level_of(at[i], levels);
                CHECK(found == level, "%a of %d levels: %d, not %d", (double)at[i], levels, found, level);
            }
        }
        for (size_t i = 0; i < sizeof hostile / sizeof *hostile; i++) {
            const int found = gl_fakes_level_of(hostile[i], levels);
            CHECK(found == (hostile[i] > 27 ? levels - 1 : 0), "%g: %d", (double)hostile[i], found);
        }
    }
}

const test_case gl_tests[] = {
#if UINTPTR_MAX <= 0xffffffffu
    {0, 0}, // a 32-bit program would need a 32-bit driver, and the text is the same
#endif
    {"levels: a kernel gets the first that holds it", level_holds_kernel},
    {"GL's tables are the CPU's, bit for bit", tables_are_equal},
    {"GL's spot lights have linear depth in every sample", spot_depth_is_linear_per_sample},
    {"GL's equal samples are one", equal_samples_are_one},
    {"GL's visibility is the CPU's", visibility_is_equal},
    {"GL's settings are obeyed", settings_are_obeyed},
    {"GL's receivers far behind all casters are the CPU's", far_receivers_are_equal},
    {"GL's visibility from shadow space is that from world space", shadow_space_is_the_same},
    {"GL's visibility of hostile points is in range", hostile_points_are_in_range},
    {"GL's new maps are lit", new_maps_are_lit},
    {"GL's lights that are not there are lit", lights_that_are_not_there_are_lit},
    {"GL's picture agrees with ray tracing as the CPU's does", picture_agrees_with_ray_tracing},
    {"GL's visibility does not flicker from frame to frame", visibility_does_not_flicker},
    {"the snapshot of GL state sees all of it", the_snapshot_sees_all},
    {"GL state is left alone by every call", state_is_left_alone},
    {"GL state is left alone where it is unusual, and the numbers are right",
     unusual_state_is_left_alone},
    {"GL numbers are right with each switch of the state turned", each_state_alone_is_harmless},
    {"GL's depth bounds are off in a pass", depth_bounds_are_off_in_the_pass},
    {"GL's transform feedback is refused while it is active", transform_feedback_is_refused},
    {"GL's names that died raise no error", names_that_died_raise_no_error},
    {"GL's front faces are the caller's", winding_is_the_callers},
    {"GL state that the caller changes between begin and end is his", changes_in_between},
    {"GL state is saved once a frame in brackets", frames_are_the_passes},
    {"GL errors of the caller are not ours", callers_error_is_not_ours},
    {"GL objects are labelled and deleted", objects_are_labelled_and_deleted},
    {"GL: calls that a driver leaves undone are not relied on", silent_calls_are_not_relied_on},
    {"GL functions may be missing", missing_functions},
    {"GL and malloc may be out of memory", allocations_fail},
    {"GL shaders may fail, with any log", shaders_fail},
    {"GL drivers may have fewer samples or framebuffers", drivers_with_less},
    {"GL: a resize that fails changes nothing", failed_resize_changes_nothing},
    {"GL before 4.5 is refused", old_versions_are_refused},
    {"GL's bad arguments are refused", bad_arguments_are_refused},
    {"GL's wrong order of calls is refused", wrong_order_is_refused},
    {"GL's zeroed descriptors disturb nobody", zeroed_descriptors_disturb_nobody},
    {"GL's defaults are those of the description", defaults},
    {"GL's memory does not grow with many lives", many_lives_do_not_grow},
    {"GL's resize keeps lights and empties maps", resize_keeps_lights_and_empties_maps},
    {"GL's lights are updated one by one", lights_are_updated_alone},
    {"GL's front faces wait for their back faces", front_faces_wait},
    {"GL builds more lights than one dispatch takes", many_lights},
    {"GL's lights may change their size without being drawn", sizes_change_without_drawing},
    {"GL works in two contexts at once", two_contexts_at_once},
    {"GL's bytes are counted", bytes_are_counted},
    {"GL's stale lights are told", stale_lights_are_told},
    {"GL's maps can be seen", maps_can_be_seen},
    {"GL's given depth maps are what a pass makes of them", given_depth_is_a_pass},
    {"GL's given depth maps mean what they say", given_depth_means_what_it_says},
    {"GL's own depth maps cast the same shadows", own_depth_maps_cast_the_same_shadows},
    {"GL's given depth maps that cannot be read are refused", bad_depth_maps_are_refused},
    {"GL's given depth maps leave the caller's bindings alone", given_depth_leaves_bindings_alone},
    {"GL shaders pass a second compiler", second_compiler_agrees},
    {0, 0}};
