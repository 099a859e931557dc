// The OpenGL half of lightprobe.h: the lights of the CPU half, whatever the probe and whatever
// state the caller is in, nothing left behind, whatever fails.
#include "../support/gl_fakes.h"
#include "../support/gl_state.h"
#include "../support/gl_test.h"
#include "../support/oracle_lightprobe.h"
#include "../support/test.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    MOST = 1024,
    TIMEOUT_EXPIRED = 0x911B,
    TEXTURE_BASE_LEVEL = 0x813C,
    TEXTURE_MAX_LEVEL = 0x813D,
    TEXTURE_CUBE_MAP_POSITIVE_X = 0x8515
};

// ---- A context, and a loader that watches fences -------------------------------------------------

static gl_context context;
static int living_fences;
static bool map_fails;
static int timeouts; // so many waits end before the GPU has finished
static struct {
    GLenum(GL_CALL *ClientWaitSync)(void *fence, GLbitfield flags, GLuint64 nanoseconds);
    void *(GL_CALL *FenceSync)(GLenum condition, GLbitfield flags);
    void(GL_CALL *DeleteSync)(void *fence);
} sync;

static void *GL_CALL watch_FenceSync(GLenum condition, GLbitfield flags)
{
    living_fences++;
    return sync.FenceSync(condition, flags);
}

static void GL_CALL watch_DeleteSync(void *fence)
{
    living_fences--;
    sync.DeleteSync(fence);
}

static GLenum GL_CALL watch_ClientWaitSync(void *fence, GLbitfield flags, GLuint64 nanoseconds)
{
    return timeouts > 0 && timeouts-- ? TIMEOUT_EXPIRED
                                      : sync.ClientWaitSync(fence, flags, nanoseconds);
}

static void *GL_CALL no_map(GLuint buffer, GLintptr offset, GLsizeiptr size, GLbitfield access)
{
    (void)buffer, (void)offset, (void)size, (void)access;
    return NULL;
}

static lightprobe_gl_function load(const char *name)
{
    const lightprobe_gl_function f = gl_fakes_load(name);
    if (!f) return NULL;
    if (!strcmp(name, "glFenceSync")) {
        memcpy(&sync.FenceSync, &f, sizeof f);
        return (lightprobe_gl_function)watch_FenceSync;
    }
    if (!strcmp(name, "glDeleteSync")) {
        memcpy(&sync.DeleteSync, &f, sizeof f);
        return (lightprobe_gl_function)watch_DeleteSync;
    }
    if (!strcmp(name, "glClientWaitSync")) {
        memcpy(&sync.ClientWaitSync, &f, sizeof f);
        return (lightprobe_gl_function)watch_ClientWaitSync;
    }
    if (map_fails && !strcmp(name, "glMapBufferRange")) return (lightprobe_gl_function)no_map;
    return f;
}

static bool begin_gl(void)
{
    gl_fakes_reset();
    gl_fakes_forget_living();
    if (!gl_test_begin(&context)) return false;
    gl_fakes_watch();
    return true;
}

static void nothing_is_left(const char *after)
{
    char text[200];
    CHECK(!gl_fakes_living(false, text, sizeof text), "left after %s:%s", after, text);
    CHECK(!gl_fakes_living_memory(), "memory left after %s", after);
    CHECK(!living_fences, "%d fences left after %s", living_fences, after);
    const GLenum error = gl.GetError();
    CHECK(error == GL_NO_ERROR, "GL error 0x%04X left after %s", error, after);
}

static void end_gl(void)
{
    nothing_is_left("the test");
    CHECK(!fakes.debug_messages, "the driver said: %s", fakes.debug_message);
    CHECK(!fakes.bad_logs, "%d shaders or programs with a log", fakes.bad_logs);
    gl_context_destroy(&context);
    gl_fakes_reset();
}

// ---- Both halves side by side --------------------------------------------------------------------

static lightprobe_gl_desc description(int side, int max_lights)
{
    lightprobe_gl_desc d;
    memset(&d, 0, sizeof d);
    d.load = load;
    d.side = side;
    d.max_lights = max_lights;
    d.log = gl_fakes_log;
    d.user = &fakes;
    return d;
}

static GLuint new_texture(int levels, int side)
{
    GLuint texture;
    gl.CreateTextures(GL_TEXTURE_CUBE_MAP, 1, &texture);
    gl.TextureStorage2D(texture, levels, GL_RGB32F, side, side);
    return texture;
}

static void upload(GLuint texture, int level, const test_probe *p)
{
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (int face = 0; face < 6; face++)
        gl.TextureSubImage3D(texture, level, 0, 0, face, p->side, p->side, 1, GL_RGB, GL_FLOAT,
                             p->face[face]);
}

typedef struct lights {
    lightprobe_light light[MOST];
    lightprobe_stats stats;
    int count;
} lights;

typedef struct subject {
    lightprobe_gl *gl;
    lightprobe_gl_desc desc;
    GLuint texture;
    void *scratch;
    lights cpu, gpu;
    double direction, energy; // largest differences
    int frames, same;         // lights that are the same bit for bit
    int all;
    bool alike;  // the GPU and this compiler round as IEEE 754 says
    bool jumped; // so far that, where they don't, either may miss a lamp for a frame
} subject;

// (1 + e) (1 - e) - 1 is 0 where the product is rounded, and -e^2 where it is fused with the sum.
static bool rounds_alike(void)
{
    volatile float a = 1 + FLT_EPSILON, b = 1 - FLT_EPSILON, c = -1;
    const float x = a, y = b, z = c, sum = x * y + z;
    return !(sum < 0) && sizeof(void *) > 4;
}

static bool make_subject(subject *s, const lightprobe_gl_desc *d)
{
    memset(s, 0, sizeof *s);
    s->desc = *d;
    const lightprobe_result r = lightprobe_gl_create(&s->gl, d);
    CHECK(!r, "%s: %s", lightprobe_result_string(r), fakes.message);
    if (r) return false;
    s->alike = rounds_alike() && gl_test_rounds();
    if (!s->alike) test_note("errors of the lights are compared, not the lights");
    s->texture = new_texture(1, d->side);
    s->scratch = malloc(lightprobe_scratch_bytes(d->side, d->max_lights));
    return true;
}

static void drop_subject(subject *s)
{
    lightprobe_gl_destroy(s->gl);
    gl.DeleteTextures(1, &s->texture);
    free(s->scratch);
}

static double apart(const float *a, const float *b, double unit)
{
    double sum = 0;
    for (int i = 0; i < 3; i++) sum += pow((double)a[i] - (double)b[i], 2);
    return sqrt(sum) / unit;
}

static void compare(subject *s, const char *what)
{
    const lights *a = &s->cpu, *b = &s->gpu;
    const double all =
        (double)a->stats.total[0] + (double)a->stats.total[1] + (double)a->stats.total[2] + 1e-30;
    CHECK(apart(a->stats.total, b->stats.total, all) < 1e-6, "%s: total", what);
    if (s->alike)
        CHECK(apart(a->stats.residual, b->stats.residual, all) < 1e-6, "%s: residual", what);
    // Where decisions may differ, so may what goes to the residual, but not what all of it adds up
    // to. Sums beyond the range of floats are cut off there.
    const bool cut_off = all > 3e38;
    float carried[3];
    for (int c = 0; c < 3; c++) {
        double sum = (double)b->stats.residual[c];
        for (int i = 0; i < b->count; i++) sum += (double)b->light[i].irradiance[c];
        carried[c] = (float)sum;
    }
    CHECK(cut_off || apart(carried, b->stats.total, all) < 1e-6, "%s: lights and residual", what);
    for (int i = 0; i < 9 && s->alike; i++)
        CHECK(apart(a->stats.residual_sh[i], b->stats.residual_sh[i], all) < 1e-6,
              "%s: harmonic %d", what, i);
    CHECK(a->stats.repaired_texels == b->stats.repaired_texels, "%s: %d texels repaired, not %d",
          what, b->stats.repaired_texels, a->stats.repaired_texels);
    CHECK(b->stats.lights == b->count, "%s: %d lights in stats", what, b->stats.lights);
    CHECK(s->alike || s->jumped ||
              fabs((double)(a->stats.error - b->stats.error)) <=
                  0.1 * (double)a->stats.error + 1e-4,
          "%s: error %g, not %g", what, (double)b->stats.error, (double)a->stats.error);
    if (!s->alike) return; // then decisions differ
    CHECK(a->count == b->count, "%s: %d lights, not %d", what, b->count, a->count);
    CHECK(fabs((double)(a->stats.error - b->stats.error)) <= 1e-6, "%s: error %g, not %g", what,
          (double)b->stats.error, (double)a->stats.error);
    for (int i = 0; i < a->count && i < b->count; i++) {
        const lightprobe_light *c = &a->light[i], *g = &b->light[i];
        const double brightness = apart(c->irradiance, (float[3]){0, 0, 0}, 1);
        const double energy = apart(c->irradiance, g->irradiance, brightness);
        const double direction = apart(c->direction, g->direction, 1);
        s->direction = fmax(s->direction, direction);
        s->energy = fmax(s->energy, energy);
        s->all++;
        s->same += !memcmp(c, g, sizeof *c);
        CHECK(direction <= 1e-4 && energy <= 1e-5, "%s: light %d is %g off, its energy %g", what, i,
              direction, energy);
        CHECK(apart(c->axis_u, g->axis_u, 1) < 1e-3 && apart(c->axis_v, g->axis_v, 1) < 1e-3 &&
                  fabs((double)(c->tan_half_u - g->tan_half_u)) < 1e-4 &&
                  fabs((double)(c->tan_half_v - g->tan_half_v)) < 1e-4 &&
                  fabs((double)(c->cos_alpha - g->cos_alpha)) < 1e-5 &&
                  fabs((double)(c->solid_angle - g->solid_angle)) < 1e-5 &&
                  fabs((double)(c->distance - g->distance)) <= 1e-5 * (double)c->distance &&
                  fabsf(c->slope_u - g->slope_u) < 1e-3f && fabsf(c->slope_v - g->slope_v) < 1e-3f,
              "%s: light %d has another shape", what, i);
        CHECK(c->id == g->id, "%s: light %d has id %d, not %d", what, i, g->id, c->id);
    }
}

// One frame: both halves go on from their own lights unless told to start afresh.
static void frame(subject *s, const test_probe *p, bool afresh, const char *what)
{
    const lightprobe_cube cube = test_probe_cube(p);
    lightprobe_settings settings;
    memset(&settings, 0, sizeof settings);
    settings.max_lights = s->desc.max_lights;
    settings.tolerance = s->desc.tolerance;
    settings.min_share = s->desc.min_share;
    settings.min_shadow = s->desc.min_shadow;
    settings.previous = afresh ? NULL : s->cpu.light;
    settings.previous_count = afresh ? 0 : s->cpu.count;
    lightprobe_result r = lightprobe_extract(
        &cube, &settings, s->scratch, lightprobe_scratch_bytes(s->desc.side, s->desc.max_lights),
        s->cpu.light, &s->cpu.count, &s->cpu.stats);
    CHECK(!r, "%s: %s", what, lightprobe_result_string(r));
    if (afresh) lightprobe_gl_restart(s->gl);
    upload(s->texture, 0, p);
    r = lightprobe_gl_update(s->gl, s->texture);
    if (!r) r = lightprobe_gl_read(s->gl, 1, s->gpu.light, &s->gpu.count, &s->gpu.stats);
    CHECK(!r, "%s: %s", what, lightprobe_result_string(r));
    s->frames++;
    compare(s, what);
}

static void note(const subject *s)
{
    test_note("side %d: %d frames, %d of %d lights the same bit for bit, worst direction %.2g, "
              "energy %.2g",
              s->desc.side, s->frames, s->same, s->all, s->direction, s->energy);
}

// ---- 1. Parity -----------------------------------------------------------------------------------

static void lights_are_the_cpus(void)
{
    static const char *const names[3] = {"interior_128", "city_sun_128", "overcast_128"};
    const lightprobe_gl_desc d = description(128, 32);
    subject s;
    char what[60];
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        for (int scene = 0; scene < SCENE_COUNT; scene++) {
            test_probe p = test_scene_probe((test_scene)scene, d.side);
            frame(&s, &p, true, test_scene_names[scene]);
            test_probe_free(&p);
        }
        for (int i = 0; i < 3; i++) {
            test_probe p = test_probe_load(names[i]);
            if (p.side) frame(&s, &p, true, names[i]);
            for (int step = 1; p.side && step < 13; step++) {            // ids included
                const double quarters = step < 9 ? step : 8 * step - 56; // the last ones are faster
                test_probe turned = test_probe_turned(&p, quarters * 0.0043633, quarters * 0.001);
                snprintf(what, sizeof what, "%s, %g steps of 0.25 degrees", names[i], quarters);
                frame(&s, &turned, false, what);
                test_probe_free(&turned);
            }
            test_probe_free(&p);
        }
        note(&s);
        drop_subject(&s);
    }
    end_gl();
}

// Of texel i from one plane a face.
static float plane_distance(int i, int side)
{
    const float s = (2 * (float)(i % side) + 1) / (float)side - 1;
    const float t = (2 * (float)(i / side % side) + 1) / (float)side - 1;
    return 2 * sqrtf(1 + s * s + t * t) / (1 + 0.4f * s - 0.3f * t);
}

// Distances in the fourth channel, or luminance over them (2), among them all that are none, and planes.
static void places_are_the_cpus(int distances)
{
    static const float distance[8] = {1, 2, 30, 0, -1, NAN, HUGE_VALF, 1e-30f};
    lightprobe_gl_desc d = description(37, 24);
    subject s;
    char what[60];
    int slopes = 0;
    d.distances = distances;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        const int texels = d.side * d.side;
        float *rgba = malloc(24 * (size_t)texels * sizeof *rgba);
        lightprobe_cube cube = {{NULL}, d.side, 4};
        lightprobe_settings settings;
        memset(&settings, 0, sizeof settings);
        settings.max_lights = d.max_lights;
        settings.distances = distances;
        gl.DeleteTextures(1, &s.texture);
        gl.CreateTextures(GL_TEXTURE_CUBE_MAP, 1, &s.texture);
        gl.TextureStorage2D(s.texture, 1, GL_RGBA32F, d.side, d.side);
        for (int step = 0; step < 2 * SCENE_COUNT; step++) { // each again from its own lights
            test_probe p = test_scene_probe((test_scene)(step / 2), d.side);
            for (int i = 0; i < 6 * texels; i++) {
                for (int c = 0; c < 3; c++)
                    rgba[4 * i + c] = p.face[i / texels][3 * (i % texels) + c];
                rgba[4 * i + 3] =
                    distance[(i / 5 + i / texels) % 8] * (1 + 0.01f * (float)(i % (7 + step)));
                if (step % 4 > 1) rgba[4 * i + 3] = plane_distance(i, d.side);
                if (distances == 2 && rgba[4 * i + 3] > 0)
                    rgba[4 * i + 3] = (0.2126f * rgba[4 * i] + 0.7152f * rgba[4 * i + 1] +
                                       0.0722f * rgba[4 * i + 2]) /
                                      rgba[4 * i + 3];
            }
            for (int face = 0; face < 6; face++) {
                cube.face[face] = rgba + 4 * face * texels;
                gl.TextureSubImage3D(s.texture, 0, 0, 0, face, d.side, d.side, 1, GL_RGBA, GL_FLOAT,
                                     cube.face[face]);
            }
            settings.previous = step % 2 ? s.cpu.light : NULL;
            settings.previous_count = step % 2 ? s.cpu.count : 0;
            if (step % 2 == 0) lightprobe_gl_restart(s.gl);
            snprintf(what, sizeof what, "%s with distances = %d, step %d",
                     test_scene_names[step / 2], distances, step);
            CHECK(!lightprobe_extract(&cube, &settings, s.scratch,
                                      lightprobe_scratch_bytes(d.side, d.max_lights), s.cpu.light,
                                      &s.cpu.count, &s.cpu.stats) &&
                      !lightprobe_gl_update(s.gl, s.texture) &&
                      !lightprobe_gl_read(s.gl, 1, s.gpu.light, &s.gpu.count, &s.gpu.stats),
                  "%s: %s", what, fakes.message);
            s.frames++;
            compare(&s, what);
            int places = 0;
            for (int i = 0; i < s.gpu.count; i++) {
                places += s.gpu.light[i].distance > 0;
                slopes += s.gpu.light[i].slope_u != 0;
            }
            CHECK(places > s.gpu.count / 2, "%s: %d of %d lights have a place", what, places,
                  s.gpu.count);
            test_probe_free(&p);
        }
        CHECK(slopes > 20, "%d lights have a slope", slopes);
        note(&s);
        free(rgba);
        drop_subject(&s);
    }
    end_gl();
}

static void lights_have_the_cpus_places(void)
{
    places_are_the_cpus(1);
    places_are_the_cpus(2);
}

// What a shader sees of a light at a place is what the CPU sees.
static void shading_at_places_is_the_cpus(void)
{
    static const char *const body = "#define LIGHTPROBE_BINDING 3\n";
    static const char *const test =
        "layout(local_size_x = 1) in;\n"
        "layout(std430, binding = 1) buffer result { vec4 sums[]; };\n"
        "void main()\n"
        "{\n"
        "    uint i = gl_GlobalInvocationID.x;\n"
        "    vec3 offset = vec3(i % 5u, i % 7u, i % 3u) * 0.3 - vec3(0.6, 0.9, 0.3);\n"
        "    vec3 normal = normalize(vec3(1, 2, 0.5) - offset);\n"
        "    int light = int(i) % lightprobe_count;\n"
        "    lightprobe_lobe lobe = lightprobe_specular_lobe(normal, vec3(0, 1, 0), 0.05 * i, vec3(0.2, 0.5, 1));\n"
        "    sums[3 * i] = vec4(lightprobe_irradiance(light, offset, normal), 0);\n"
        "    sums[3 * i + 1] = vec4(lightprobe_sphere_irradiance(light, offset, normal), 0);\n"
        "    sums[3 * i + 2] = vec4(lightprobe_specular(light, offset, lobe), 0);\n"
        "}\n";
    lightprobe_gl_desc d = description(16, 24);
    subject s;
    d.distances = 1;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        enum { SUMS = 105 };
        int slopes = 0;
        static float sums[3 * SUMS][4], rgba[6 * 16 * 16 * 4];
        const float up[3] = {0, 1, 0}, f0[3] = {0.2f, 0.5f, 1};
        const char *const text[] = {body,
                                    lightprobe_glsl_math(),
                                    lightprobe_glsl_lights(),
                                    lightprobe_glsl_specular(),
                                    test,
                                    NULL};
        const GLuint program = gl_test_compute("places", text);
        GLuint result;
        for (int i = 0; i < 6 * 256 * 4; i++)
            rgba[i] = i % 4 < 3 ? 1 + (float)(i / 64 % 9) : plane_distance(i / 4, 16);
        gl.DeleteTextures(1, &s.texture);
        gl.CreateTextures(GL_TEXTURE_CUBE_MAP, 1, &s.texture);
        gl.TextureStorage2D(s.texture, 1, GL_RGBA32F, d.side, d.side);
        for (int face = 0; face < 6; face++)
            gl.TextureSubImage3D(s.texture, 0, 0, 0, face, 16, 16, 1, GL_RGBA, GL_FLOAT,
                                 rgba + 1024 * face);
        CHECK(!lightprobe_gl_update(s.gl, s.texture) &&
                  !lightprobe_gl_read(s.gl, 1, s.gpu.light, &s.gpu.count, NULL),
              "lights");
        for (int i = 0; i < s.gpu.count; i++) slopes += s.gpu.light[i].slope_u != 0;
        CHECK(slopes > 1, "%d lights have a slope", slopes);
        const lightprobe_gl_range range = lightprobe_gl_lights(s.gl, 1);
        gl.CreateBuffers(1, &result);
        gl.NamedBufferStorage(result, sizeof sums, NULL, 0);
        gl.BindBufferRange(GL_SHADER_STORAGE_BUFFER, 3, range.buffer, range.offset, range.bytes);
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, result);
        gl.UseProgram(program);
        gl.DispatchCompute(SUMS, 1, 1);
        gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        gl.GetNamedBufferSubData(result, 0, sizeof sums, sums);
        gl.UseProgram(0);
        for (int k = 0; k < 3 * SUMS; k++) {
            const int i = k / 3;
            const lightprobe_light from = s.gpu.light[i % s.gpu.count];
            const float x = (float)(i % 5) * 0.3f - 0.6f, y = (float)(i % 7) * 0.3f - 0.9f;
            const float z = (float)(i % 3) * 0.3f - 0.3f;
            float n[3] = {1 - x, 2 - y, 0.5f - z};
            const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
            for (int c = 0; c < 3; c++) n[c] /= length;
            if (k % 3 == 2) {
                float shine[3];
                lightprobe_specular(from, lightprobe_specular_lobe(n, up, 0.05f * (float)i, f0), x,
                                    y, z, shine);
                for (int c = 0; c < 3; c++)
                    CHECK(fabsf(sums[k][c] - shine[c]) < 1e-4f * (shine[c] + 0.1f),
                          "shine of %d: %g, not %g", i, (double)sums[k][c], (double)shine[c]);
                continue;
            }
            const lightprobe_light l =
                k % 3 ? lightprobe_sphere_at(from, x, y, z) : lightprobe_light_at(from, x, y, z);
            const float cosine =
                l.direction[0] * n[0] + l.direction[1] * n[1] + l.direction[2] * n[2];
            for (int c = 0; c < 3; c++) {
                const float e = l.irradiance[c] * lightprobe_disc_irradiance(l.cos_alpha, cosine);
                CHECK(fabsf(sums[k][c] - e) < 1e-5f * (l.irradiance[c] + 1),
                      "receiver %d: %g, not %g", k, (double)sums[k][c], (double)e);
            }
        }
        gl.DeleteBuffers(1, &result);
        gl.DeleteProgram(program);
        drop_subject(&s);
    }
    end_gl();
}

// The names of doubles in a text, outside of comments.
static bool has_doubles(const char *text)
{
    for (; *text; text++) {
        if (!strncmp(text, "//", 2)) text += strcspn(text, "\n");
        if (!strncmp(text, "double", 6) || !strncmp(text, "dvec", 4) || !strncmp(text, "dmat", 4))
            return true;
    }
    return false;
}

// Many GPUs have no doubles. What stands for them: lengths are rounded once at every exponent, and
// sums of a thousand numbers of any size and sign keep what a float loses.
static void shaders_take_no_doubles(void)
{
    enum { COUNT = 1024 };
    static const char *const body =
        "layout(local_size_x = 64) in;\n"
        "layout(std430, binding = 0) buffer numbers { float x[]; };\n"
        "void main()\n"
        "{\n"
        "    uint i = gl_GlobalInvocationID.x;\n"
        "    x[3072 + i] = lightprobe_length(vec3(x[3 * i], x[3 * i + 1], x[3 * i + 2]));\n"
        "    vec2 sum = vec2(0.0);\n"
        "    for (int k = 0; k < 1024; k++) lightprobe_add(sum, x[(3 * i + k) % 3072]);\n"
        "    x[4096 + i] = sum.x + sum.y;\n"
        "}\n";
    static float x[5 * COUNT];
    const lightprobe_gl_desc d = description(16, 8);
    lightprobe_gl *g = NULL;
    GLuint buffer;
    if (!begin_gl()) return;
    CHECK(!lightprobe_gl_create(&g, &d), "%s", fakes.message);
    for (int i = 0; i < fakes.text_count; i++) CHECK(!has_doubles(fakes.texts[i]), "text %d", i);
    const char *from = fakes.text_count ? strstr(fakes.texts[0], "void lightprobe_add(") : NULL;
    const char *to = from ? strstr(strstr(from, "float lightprobe_length("), "\n}\n") : NULL;
    if (to) {
        char functions[3000] = "";
        strncat(functions, from, (size_t)(to + 3 - from));
        const char *const text[] = {functions, body, NULL};
        const GLuint program = gl_test_compute("lengths", text);
        uint64_t seed = 92;
        double worst_length = 0, worst_sum = 0;
        for (int i = 0; i < COUNT; i++) {
            const float scale = ldexpf(1, i % 240 - 120);
            for (int k = 0; k < 3; k++) {
                const float part = i % 5 && k ? 1e-4f : 1;
                x[3 * i + k] = scale * part * (float)test_range(&seed, -1, 1);
            }
        }
        memset(x, 0, 3 * sizeof *x);
        gl.CreateBuffers(1, &buffer);
        gl.NamedBufferStorage(buffer, sizeof x, x, 0);
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer);
        gl.UseProgram(program);
        gl.DispatchCompute(COUNT / 64, 1, 1);
        gl.MemoryBarrier(~0u);
        gl.GetNamedBufferSubData(buffer, 0, sizeof x, x);
        for (int i = 0; i < COUNT; i++) {
            double square = 0, sum = 0, all = 0;
            for (int k = 0; k < 3; k++) square += (double)x[3 * i + k] * (double)x[3 * i + k];
            for (int k = 0; k < 1024; k++) {
                sum += (double)x[(3 * i + k) % 3072];
                all += fabs((double)x[(3 * i + k) % 3072]);
            }
            const double error = fabs((double)x[3072 + i] - sqrt(square));
            if (square > 0) worst_length = fmax(worst_length, error / sqrt(square));
            CHECK(square > 0 || x[3072 + i] == 0, "length of zero %g", (double)x[3072 + i]);
            worst_sum =
                fmax(worst_sum, (fabs((double)x[4096 + i] - sum) - 6.1e-8 * fabs(sum)) / all);
        }
        CHECK(worst_length < 6.1e-8, "a length is %.3g off", worst_length);
        CHECK(worst_sum < 1e-12, "a sum is %.3g off", worst_sum);
        gl.UseProgram(0);
        gl.DeleteProgram(program);
        gl.DeleteBuffers(1, &buffer);
    }
    CHECK(to != NULL, "no functions for wide sums in the texts");
    lightprobe_gl_destroy(g);
    end_gl();
}

typedef void (*spoil_function)(test_probe *p, uint64_t *seed);

static float *any_texel(test_probe *p, uint64_t *seed)
{
    return p->face[(int)test_range(seed, 0, 6)] + (int)test_range(seed, 0, 3.0 * p->side * p->side);
}

static void fill(test_probe *p, float value)
{
    for (int i = 0; i < 18 * p->side * p->side; i++)
        p->face[i / (3 * p->side * p->side)][i % (3 * p->side * p->side)] = value;
}

static void spoil_negative(test_probe *p, uint64_t *seed)
{
    for (int i = 0; i < 9 * p->side; i++) *any_texel(p, seed) *= -1;
}

static void spoil_nan(test_probe *p, uint64_t *seed)
{
    for (int i = 0; i < 9 * p->side; i++) *any_texel(p, seed) = i % 2 ? NAN : -INFINITY;
}

static void spoil_infinite(test_probe *p, uint64_t *seed)
{
    for (int i = 0; i < 9 * p->side; i++) *any_texel(p, seed) = INFINITY;
}

static void spoil_black(test_probe *p, uint64_t *seed)
{
    (void)seed;
    fill(p, 0);
}

static void spoil_constant(test_probe *p, uint64_t *seed)
{
    (void)seed;
    fill(p, 0.75f);
}

static void spoil_hot(test_probe *p, uint64_t *seed)
{
    fill(p, 1e-3f);
    *any_texel(p, seed) = 1e6f;
}

static void spoil_alone(test_probe *p, uint64_t *seed)
{
    fill(p, 0);
    *any_texel(p, seed) = 3;
}

static void spoil_huge(test_probe *p, uint64_t *seed)
{
    for (int i = 0; i < 40; i++) *any_texel(p, seed) = FLT_MAX;
}

static void spoil_all(test_probe *p, uint64_t *seed)
{
    (void)seed;
    fill(p, NAN);
}

static void hostile_probes_agree(void)
{
    static const struct {
        const char *name;
        spoil_function spoil;
    } kinds[] = {
        {"negative", spoil_negative}, {"NaN", spoil_nan},           {"infinite", spoil_infinite},
        {"black", spoil_black},       {"constant", spoil_constant}, {"one hot texel", spoil_hot},
        {"one texel", spoil_alone},   {"FLT_MAX", spoil_huge},      {"all NaN", spoil_all}};
    static const int sides[] = {1, 2, 5, 32};
    uint64_t seed = 17;
    char what[60];
    if (!begin_gl()) return;
    for (int i = 0; i < 4; i++) {
        lightprobe_gl_desc d = description(sides[i], 20);
        d.min_share = i == 2 ? 0.02f : 0;
        d.min_shadow = i == 1 || i == 3 ? 0.1f : 0;
        d.tolerance = i == 3 ? 0.03f : 0;
        subject s;
        if (!make_subject(&s, &d)) continue;
        for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
            test_probe p = test_scene_probe(SCENE_SKY_SUN, sides[i]);
            kinds[k].spoil(&p, &seed);
            for (int again = 0; again < 2; again++) { // a frame that goes on from whatever was
                snprintf(what, sizeof what, "%s, side %d%s", kinds[k].name, sides[i],
                         again ? ", afresh" : "");
                frame(&s, &p, again, what);
            }
            test_probe_free(&p);
        }
        note(&s);
        drop_subject(&s);
    }
    end_gl();
}

// 1 in compatibility contexts.
static int compatible(void)
{
    GLint profile = 0;
    gl.GetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
    return profile & 2 ? 1 : 0;
}

// Of the active texture unit, in compatibility contexts.
static void set_unit_bias(float bias)
{
    void(GL_CALL * TexEnvf)(GLenum, GLenum, GLfloat);
    const gl_fakes_function f = gl_context_function("glTexEnvf");
    memcpy(&TexEnvf, &f, sizeof f);
    TexEnvf(0x8500, 0x8501, bias); // GL_TEXTURE_FILTER_CONTROL, GL_TEXTURE_LOD_BIAS
}

// A coarser level of a texture, of which the finer one is something else.
static void side_chooses_the_level(void)
{
    const lightprobe_gl_desc d = description(32, 20);
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        test_probe p = test_scene_probe(SCENE_LAMPS, 32), other = test_scene_probe(SCENE_NOISE, 64);
        const GLuint texture = new_texture(3, 64);
        // Each twice and more, with programs in between: a driver may keep what a uniform was.
        static const int turn[] = {0, 0, 1, 1, 0, 0, 0, 1, 1, 1, 0, 1};
        lights first, again;
        upload(texture, 0, &other);
        upload(texture, 1, &p);
        upload(s.texture, 0, &p);
        for (size_t i = 0; i < sizeof turn / sizeof *turn; i++) {
            lights *to = i ? &again : &first;
            memset(to, 0, sizeof *to);
            lightprobe_gl_restart(s.gl);
            CHECK(!lightprobe_gl_update(s.gl, turn[i] ? texture : s.texture), "%s", fakes.message);
            lightprobe_gl_read(s.gl, 1, to->light, &to->count, &to->stats);
            CHECK(to->count == 20 && !memcmp(to, &first, sizeof first), "other lights in turn %d",
                  (int)i);
        }
        // Of a view what is in it counts; compatibility contexts have a bias of the unit.
        static const struct {
            int from, levels, base;
        } views[] = {{0, 2, 0}, {1, 1, 0}, {0, 2, 1}};
        for (size_t i = 0; i < sizeof views / sizeof *views * (size_t)(1 + compatible()); i++) {
            const size_t k = i % (sizeof views / sizeof *views);
            const float bias = i > k ? 1 : 0;
            GLuint view;
            gl.GenTextures(1, &view);
            gl.TextureView(view, GL_TEXTURE_CUBE_MAP, texture, GL_RGB32F, (GLuint)views[k].from,
                           (GLuint)views[k].levels, 0, 6);
            gl.TextureParameteri(view, TEXTURE_BASE_LEVEL, views[k].base);
            if (bias > 0) set_unit_bias(bias);
            memset(&again, 0, sizeof again);
            lightprobe_gl_restart(s.gl);
            CHECK(!lightprobe_gl_update(s.gl, view), "view %d: %s", (int)k, fakes.message);
            lightprobe_gl_read(s.gl, 1, again.light, &again.count, &again.stats);
            CHECK(again.count == 20 && !memcmp(&again, &first, sizeof first),
                  "other lights of view %d%s", (int)k, bias > 0 ? " with a bias" : "");
            if (bias > 0) set_unit_bias(0);
            gl.DeleteTextures(1, &view);
        }
        gl.DeleteTextures(1, &texture);
        test_probe_free(&p);
        test_probe_free(&other);
        drop_subject(&s);
    }
    end_gl();
}

// Storage a level and a face at a time, as renderers before OpenGL 4.2 make it.
typedef void(GL_CALL *tex_image_function)(GLenum, GLint, GLint, GLsizei, GLsizei, GLint, GLenum,
                                          GLenum, const void *);
static tex_image_function tex_image(void)
{
    const gl_fakes_function f = gl_context_function("glTexImage2D");
    tex_image_function to;
    memcpy(&to, &f, sizeof f);
    return to;
}

// What cannot be read at the level of the side asked for is refused in so many words.
static void levels_that_are_not_there_are_refused(void)
{
    static const struct {
        int levels, base, last; // of a texture of side 64
        bool good;
    } cases[] = {{7, 0, 1000, 1}, {7, 0, 1, 1},    {7, 0, 0, 0}, {1, 0, 1000, 0},
                 {7, 1, 1000, 1}, {7, 2, 1000, 0}, {7, 1, 1, 1}, {2, 0, 1000, 1}};
    const lightprobe_gl_desc d = description(32, 20);
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        test_probe p = test_scene_probe(SCENE_LAMPS, 32);
        for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
            const GLuint texture = new_texture(cases[i].levels, 64);
            lights l = {.count = 0};
            if (cases[i].levels > 1) upload(texture, 1, &p);
            gl.TextureParameteri(texture, TEXTURE_BASE_LEVEL, cases[i].base);
            gl.TextureParameteri(texture, TEXTURE_MAX_LEVEL, cases[i].last);
            fakes.messages = 0;
            const lightprobe_result r = lightprobe_gl_update(s.gl, texture);
            CHECK(r == (cases[i].good ? LIGHTPROBE_OK : LIGHTPROBE_ERROR_TEXTURE) &&
                      (!r || strstr(fakes.message, "side 32")),
                  "%d levels, %d to %d: result %d, \"%s\"", cases[i].levels, cases[i].base,
                  cases[i].last, r, fakes.message);
            if (!r) lightprobe_gl_read(s.gl, 1, l.light, &l.count, &l.stats);
            CHECK(r || l.count == 20, "%d levels, %d to %d: %d lights", cases[i].levels,
                  cases[i].base, cases[i].last, l.count);
            gl.DeleteTextures(1, &texture);
        }
        // Storage made level by level: where one is missing it would be read as black.
        const tex_image_function TexImage2D = tex_image();
        for (int levels = 2; levels < 8; levels += 5) {
            GLuint texture;
            gl.CreateTextures(GL_TEXTURE_CUBE_MAP, 1, &texture);
            gl.BindTexture(GL_TEXTURE_CUBE_MAP, texture);
            for (int level = 0; level < levels; level++) {
                for (GLenum face = 0; face < 6; face++)
                    TexImage2D(TEXTURE_CUBE_MAP_POSITIVE_X + face, level, GL_RGB32F, 64 >> level,
                               64 >> level, 0, GL_RGB, GL_FLOAT, level == 1 ? p.face[face] : NULL);
            }
            const lightprobe_result r = lightprobe_gl_update(s.gl, texture);
            CHECK(r == (levels == 7 ? LIGHTPROBE_OK : LIGHTPROBE_ERROR_TEXTURE),
                  "%d levels: result %d", levels, r);
            gl.DeleteTextures(1, &texture);
        }
        test_probe_free(&p);
        drop_subject(&s);
    }
    end_gl();
}

// What GL reads as black without an error, a cube map without some of its faces or with different
// ones, or as anything, integers and depth, is refused: it would be a probe without lights.
static void what_reads_as_black_is_refused(void)
{
    enum { SIDE = 32, LEVELS = 2 };
    static const struct {
        const char *said; // NULL: is good
        int level, face;  // that is other than the rest
        int side;         // of that, 0: missing
        GLenum format;
    } odd[] = {{NULL, 0, 0, SIDE, GL_RGB32F},        {"faces", 0, 5, 0, GL_RGB32F},
               {"faces", 0, 1, SIDE / 2, GL_RGB32F}, {"faces", 0, 3, SIDE, GL_RGBA32F},
               {"faces", 1, 2, 0, GL_RGB32F},        {"faces", 1, 4, SIDE / 4, GL_RGB32F},
               {"faces", 1, 5, SIDE / 2, GL_RGBA32F}};
    // GL_RGBA8UI, GL_RGBA8I, depth, GL_STENCIL_INDEX8
    static const GLenum formats[] = {0x8D7C, 0x8D8E, GL_DEPTH_COMPONENT32F, 0x8D48};
    tex_image_function TexImage2D;
    GLuint texture;
    subject s;
    if (!begin_gl()) return;
    TexImage2D = tex_image();
    for (int level = 0; level < LEVELS; level++) { // which is read
        const lightprobe_gl_desc d = description(SIDE >> level, 4);
        if (!make_subject(&s, &d)) continue;
        for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
            gl.CreateTextures(GL_TEXTURE_CUBE_MAP, 1, &texture);
            gl.BindTexture(GL_TEXTURE_CUBE_MAP, texture);
            gl.TextureParameteri(texture, TEXTURE_MAX_LEVEL, LEVELS - 1);
            for (int k = 0; k < 6 * LEVELS; k++) {
                const bool is = odd[i].level == k / 6 && odd[i].face == k % 6;
                const int side = is ? odd[i].side : SIDE >> k / 6;
                if (side)
                    TexImage2D(TEXTURE_CUBE_MAP_POSITIVE_X + (GLenum)k % 6, k / 6,
                               (GLint)(is ? odd[i].format : GL_RGB32F), side, side, 0, GL_RGB,
                               GL_FLOAT, NULL);
            }
            // Level 0 by itself is whole where level 1 is not.
            const bool good = !odd[i].said || odd[i].level > level;
            fakes.message[0] = 0;
            const lightprobe_result r = lightprobe_gl_update(s.gl, texture);
            CHECK(r == (good ? LIGHTPROBE_OK : LIGHTPROBE_ERROR_TEXTURE) &&
                      (good || strstr(fakes.message, odd[i].said)),
                  "level %d, case %d: result %d, \"%s\"", level, (int)i, r, fakes.message);
            gl.DeleteTextures(1, &texture);
        }
        for (size_t i = 0; i < sizeof formats / sizeof *formats; i++) {
            gl.CreateTextures(GL_TEXTURE_CUBE_MAP, 1, &texture);
            gl.TextureStorage2D(texture, LEVELS, formats[i], SIDE, SIDE);
            const lightprobe_result r = lightprobe_gl_update(s.gl, texture);
            CHECK(r == LIGHTPROBE_ERROR_TEXTURE && strstr(fakes.message, "integers or depth"),
                  "format 0x%X: result %d, \"%s\"", formats[i], r, fakes.message);
            gl.DeleteTextures(1, &texture);
        }
        drop_subject(&s);
    }
    end_gl();
}

// So many that two of them hardly differ, and that one dispatch would take too many steps. The loud
// texels make clusters that are divided one leaf at a time.
static void many_lights_agree(void)
{
    static const int counts[] = {200, 1000, MOST};
    static subject s;
    uint64_t seed = 5;
    if (!begin_gl()) return;
    for (int i = 0; i < 3; i++) {
        const lightprobe_gl_desc d = description(64, counts[i]);
        if (!make_subject(&s, &d)) continue;
        test_probe p = test_scene_probe(i > 0 ? SCENE_NOISE : SCENE_LAMPS, d.side);
        for (int frames = 0; frames < 3; frames++) {
            s.jumped = frames > 0;
            frame(&s, &p, frames == 0, test_scene_names[i > 0 ? SCENE_NOISE : SCENE_LAMPS]);
            CHECK(frames > 0 || s.gpu.count == counts[i] || (!s.alike && s.gpu.count > 195),
                  "%d lights, not %d", s.gpu.count, counts[i]);
            for (int k = 0; k < 40; k++) *any_texel(&p, &seed) += (float)pow(2, k);
        }
        test_probe_free(&p);
        note(&s);
        drop_subject(&s);
    }
    end_gl();
}

// What surfaces of some normals get behind some half-spaces; a light is hidden or is not, softly.
static void irradiance_behind(const lights *l, double out[8])
{
    for (int i = 0; i < 8; i++) {
        const double a = i * 0.785398 + 0.1;
        out[i] = 0;
        for (int k = 0; k < l->count; k++) {
            const lightprobe_light *p = &l->light[k];
            const double alpha = acos((double)p->cos_alpha) + 1e-6;
            double x = asin((double)p->direction[0] * cos(a) + (double)p->direction[2] * sin(a));
            x = fmax(-1, fmin(1, x / alpha));
            out[i] += (double)lightprobe_disc_irradiance(p->cos_alpha, p->direction[1]) *
                      (double)p->irradiance[1] *
                      (0.5 + (x * sqrt(1 - x * x) + asin(x)) / 3.14159265);
        }
    }
}

// As the same test of the CPU half, by the way of lightprobe_gl_read without waiting: what is read
// is late by a frame or so, but never jumps.
static void a_turning_probe_does_not_jump(void)
{
    const lightprobe_gl_desc d = description(128, 32);
    static subject s;
    const int frames = test_trials(60) + 1;
    double last[8] = {0}, now[8], worst = 0, mean = 0;
    if (!begin_gl()) return;
    test_probe p = test_probe_load("city_sun_128");
    if (!p.side) p = test_scene_probe(SCENE_SKY_SUN, d.side);
    if (make_subject(&s, &d)) {
        for (int i = 0; i < frames; i++) {
            test_probe turned = test_probe_turned(&p, i * 0.0043633, 0);
            upload(s.texture, 0, &turned);
            test_probe_free(&turned);
            CHECK(!lightprobe_gl_update(s.gl, s.texture), "%s", fakes.message);
            CHECK(!lightprobe_gl_read(s.gl, 1, s.gpu.light, &s.gpu.count, NULL), "read");
            irradiance_behind(&s.gpu, now);
            for (int k = 0; k < 8; k++) {
                mean += now[k] / 8 / frames;
                if (i > 0) worst = fmax(worst, fabs(now[k] - last[k]));
            }
            memcpy(last, now, sizeof last);
        }
        worst *= 100 / mean;
        test_note("%d steps of 0.25 degrees, largest step %.1f%% of the mean", frames - 1, worst);
        CHECK(worst < 9, "%.1f%%", worst); // 0.6 times the paper's way, as on the CPU
        drop_subject(&s);
    }
    test_probe_free(&p);
    end_gl();
}

// ---- 2. What the shading sees --------------------------------------------------------------------

static GLuint irradiance_program(void)
{
    static const char *const body =
        "layout(local_size_x = 1) in;\n"
        "layout(std430, binding = 1) writeonly buffer result { vec4 sums[]; };\n"
        "void main()\n"
        "{\n"
        "    int i = int(gl_WorkGroupID.x);\n"
        "    vec3 normal = normalize(vec3(i % 3 - 1, i / 3 - 1, 0.5));\n"
        "    vec3 sum = lightprobe_residual_irradiance(normal);\n"
        "    for (int k = 0; k < lightprobe_count; k++) sum += lightprobe_irradiance(k, normal);\n"
        "    sums[i] = vec4(sum, lightprobe_lights[0].id);\n"
        "}\n";
    const char *const text[] = {"#define LIGHTPROBE_BINDING 3\n", lightprobe_glsl_math(),
                                lightprobe_glsl_lights(), body, NULL};
    return gl_test_compute("irradiance", text);
}

static void check_shading(const subject *s, GLuint program, lightprobe_gl_range range)
{
    float sums[9][4];
    GLuint result;
    gl.CreateBuffers(1, &result);
    gl.NamedBufferStorage(result, sizeof sums, NULL, 0);
    gl.BindBufferRange(GL_SHADER_STORAGE_BUFFER, 3, range.buffer, range.offset, range.bytes);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, result);
    gl.UseProgram(program);
    gl.DispatchCompute(9, 1, 1);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl.GetNamedBufferSubData(result, 0, sizeof sums, sums);
    gl.UseProgram(0);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, 0);
    gl.DeleteBuffers(1, &result);
    for (int i = 0; i < 9; i++) {
        const double x = i % 3 - 1, y = i / 3 - 1, length = sqrt(x * x + y * y + 0.25);
        const float normal[3] = {(float)(x / length), (float)(y / length), (float)(0.5 / length)};
        float rgb[3];
        lightprobe_residual_irradiance(&s->gpu.stats, normal, rgb);
        double sum = (double)rgb[1];
        for (int k = 0; k < s->gpu.count; k++) {
            const lightprobe_light *l = &s->gpu.light[k];
            const double cosine = ((double)l->direction[0] * x + (double)l->direction[1] * y +
                                   (double)l->direction[2] * 0.5) /
                                  length;
            sum += (double)l->irradiance[1] *
                   (double)lightprobe_disc_irradiance(l->cos_alpha, (float)cosine);
        }
        CHECK(fabs((double)sums[i][1] / sum - 1) < 1e-5, "normal %d: %g, not %g", i,
              (double)sums[i][1], sum);
        CHECK((int)sums[i][3] == s->gpu.light[0].id, "first id %g", (double)sums[i][3]);
    }
}

// The CPU may be late, but what it was given stays where it says for two more updates.
static void shading_and_cpu_see_the_same(void)
{
    lightprobe_gl_desc d = description(32, 20);
    d.min_shadow = 0.1f;
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        const GLuint program = irradiance_program();
        lights *g = &s.gpu;
        CHECK(lightprobe_gl_read(s.gl, 0, g->light, &g->count, NULL) == LIGHTPROBE_ERROR_NOT_READY,
              "lights before the first update");
        for (int i = 0; i < 7; i++) {
            test_probe p = test_scene_probe((test_scene)(i % SCENE_COUNT), d.side);
            upload(s.texture, 0, &p);
            test_probe_free(&p);
            CHECK(!lightprobe_gl_update(s.gl, s.texture), "%s", fakes.message);
            const lightprobe_result r =
                lightprobe_gl_read(s.gl, i == 0 || i == 5, g->light, &g->count, &g->stats);
            CHECK(!r || r == LIGHTPROBE_ERROR_NOT_READY, "%s", lightprobe_result_string(r));
            if (!r) check_shading(&s, program, lightprobe_gl_lights(s.gl, 1));
            if (i == 5) check_shading(&s, program, lightprobe_gl_lights(s.gl, 0));
        }
        for (int i = 0; i < 2; i++) lightprobe_gl_update(s.gl, s.texture);
        gl.DeleteProgram(program);
        drop_subject(&s);
    }
    end_gl();
}

// ---- 3. The caller's state -----------------------------------------------------------------------

static gl_state before, after;

static void same_state(const char *what)
{
    char text[800];
    gl_state_take(&after);
    const int n = gl_state_differences(&before, &after, NULL, text, sizeof text);
    CHECK(!n, "%s changed %d: %s", what, n, text);
}

// Every call once; expected: what creating gives. shaders: also an update.
static void call_all(lightprobe_gl_desc d, lightprobe_result expected, bool shaders,
                     const char *what)
{
    lightprobe_gl *const nothing = (lightprobe_gl *)(void *)&d, *g = nothing;
    lights l;
    memset(&l, 0, sizeof l);
    gl_state_take(&before);
    const lightprobe_result r = lightprobe_gl_create(&g, &d);
    CHECK(r == expected, "%s: \"%s\", not \"%s\"", what, lightprobe_result_string(r),
          lightprobe_result_string(expected));
    CHECK((r == LIGHTPROBE_OK) == (g != nothing), "%s: the pointer is %p", what, (void *)g);
    CHECK(!r || (fakes.messages > 0 && fakes.message[0]), "%s: no message", what);
    same_state(what);
    if (!r) {
        char text[200];
        CHECK(!gl_fakes_living(true, text, sizeof text), "without a label:%s", text);
        if (shaders) {
            test_probe p = test_scene_probe(SCENE_LAMPS, d.side);
            const GLuint texture = new_texture(1, d.side);
            GLint buffer = 0, alignment = 0;
            gl.GetIntegerv(0x88EF, &buffer); // GL_PIXEL_UNPACK_BUFFER_BINDING
            gl.GetIntegerv(GL_UNPACK_ALIGNMENT, &alignment);
            if (!buffer) upload(texture, 0, &p);
            gl.PixelStorei(GL_UNPACK_ALIGNMENT, alignment);
            for (int i = 0; i < 2; i++) {
                gl_state_take(&before);
                CHECK(!lightprobe_gl_update(g, texture), "%s: %s", what, fakes.message);
                same_state("lightprobe_gl_update");
                CHECK(!lightprobe_gl_read(g, 1, l.light, &l.count, &l.stats), "%s", what);
                CHECK(buffer || l.count == d.max_lights, "%d lights", l.count);
                same_state("lightprobe_gl_read");
            }
            gl.DeleteTextures(1, &texture);
            test_probe_free(&p);
        }
        lightprobe_gl_destroy(g);
        same_state("lightprobe_gl_destroy");
    }
    nothing_is_left(what);
}

static void state_is_left_as_found(void)
{
    lightprobe_gl_desc d = description(5, 20);
    if (!begin_gl()) return;
    call_all(d, LIGHTPROBE_OK, true, "usual state");
    gl_unusual unusual;
    gl_state_make_unusual(&unusual);
    d.first_texture_unit = 3; // active, and others
    d.first_buffer_binding = 2;
    call_all(d, LIGHTPROBE_OK, true, "unusual state");
    d.first_texture_unit = 20;
    call_all(d, LIGHTPROBE_OK, true, "unusual state, another unit");
    gl_state_make_usual(&unusual);
    gl_state_free(&before);
    gl_state_free(&after);
    end_gl();
}

// Each with its own probe, by turns.
static void two_contexts_at_once(void)
{
    static subject s[2];
    gl_context contexts[2];
    if (!begin_gl()) return;
    contexts[0] = context;
    if (!gl_test_make_current(&contexts[0])) {
        end_gl();
        return;
    }
    const lightprobe_gl_desc a = description(32, 20), b = description(20, 9);
    const bool made = make_subject(&s[0], &a);
    if (made && gl_test_begin(&contexts[1])) {
        if (make_subject(&s[1], &b)) {
            for (int i = 0; i < 6; i++) {
                test_probe p = test_scene_probe((test_scene)(i % 5), s[i % 2].desc.side);
                gl_test_make_current(&contexts[i % 2]);
                frame(&s[i % 2], &p, i < 2, test_scene_names[i % 5]);
                test_probe_free(&p);
            }
            drop_subject(&s[1]);
        }
        CHECK(gl.GetError() == GL_NO_ERROR, "second context");
        gl_context_destroy(&contexts[1]);
    }
    gl_test_make_current(&contexts[0]);
    if (made) drop_subject(&s[0]);
    end_gl();
}

// Creating and destroying again and again leaves no object, no memory and no fence.
static void nothing_grows(void)
{
    static subject s;
    if (!begin_gl()) return;
    for (int i = 0; i < 6; i++) {
        const lightprobe_gl_desc d = description(8, 6);
        if (!make_subject(&s, &d)) continue;
        test_probe p = test_scene_probe(SCENE_LAMPS, d.side);
        for (int k = 0; k < 5; k++) frame(&s, &p, k == 0, "lamps");
        CHECK(living_fences == 3, "%d fences after five updates", living_fences);
        test_probe_free(&p);
        drop_subject(&s);
        nothing_is_left("destroy");
    }
    end_gl();
}

// ---- 4. Failures, and drivers as they are -----------------------------------------------------------

// Intel's driver for Windows: buffers and cube maps by name.
static void silent_calls_are_not_relied_on(void)
{
    const lightprobe_gl_desc d = description(16, 8);
    static subject s;
    if (!begin_gl()) return;
    fakes.silent_names = true;
    if (make_subject(&s, &d)) {
        test_probe p = test_scene_probe(SCENE_LAMPS, d.side);
        for (int k = 0; k < 3; k++) frame(&s, &p, k == 0, "lamps");
        test_probe_free(&p);
        drop_subject(&s);
    }
    end_gl();
}

// However long the GPU takes: a wait is one for the lights of the last update.
static void waiting_is_for_the_last_update(void)
{
    const lightprobe_gl_desc d = description(16, 8);
    static subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        test_probe p = test_scene_probe(SCENE_LAMPS, d.side);
        frame(&s, &p, true, "lamps");
        upload(s.texture, 0, &p);
        CHECK(!lightprobe_gl_update(s.gl, s.texture), "update");
        timeouts = 100;
        CHECK(!lightprobe_gl_read(s.gl, 1, s.gpu.light, &s.gpu.count, NULL) && timeouts == 0,
              "%d waits are left", timeouts);
        const lightprobe_gl_range last = lightprobe_gl_lights(s.gl, 0),
                                  read = lightprobe_gl_lights(s.gl, 1);
        CHECK(last.offset == read.offset, "read %d, made %d", (int)read.offset, (int)last.offset);
        timeouts = 100; // nobody who does not wait is kept
        CHECK(lightprobe_gl_read(s.gl, 0, s.gpu.light, &s.gpu.count, NULL) ==
                      LIGHTPROBE_ERROR_NOT_READY &&
                  timeouts > 90,
              "%d waits are left", timeouts);
        timeouts = 0;
        test_probe_free(&p);
        drop_subject(&s);
    }
    end_gl();
}

static void transform_feedback_is_refused(void)
{
    static const char *const texts[2] = {"void main() { gl_Position = vec4(0); }\n",
                                         "void main() {}\n"};
    static const char *const names[] = {"gl_Position"};
    const lightprobe_gl_desc d = description(8, 4);
    static subject s;
    GLuint feedback, buffer;
    if (!begin_gl()) return;
    const GLuint program = gl.CreateProgram();
    for (int i = 0; i < 2; i++) {
        const char *const text[] = {texts[i], NULL};
        const GLuint shader =
            gl_test_shader(i ? GL_FRAGMENT_SHADER : GL_VERTEX_SHADER, "shader", text);
        gl.AttachShader(program, shader);
        gl.DeleteShader(shader);
    }
    gl.TransformFeedbackVaryings(program, 1, names, GL_INTERLEAVED_ATTRIBS);
    gl.LinkProgram(program);
    gl.CreateTransformFeedbacks(1, &feedback);
    gl.CreateBuffers(1, &buffer);
    gl.NamedBufferStorage(buffer, 4096, NULL, 0);
    gl.BindTransformFeedback(GL_TRANSFORM_FEEDBACK, feedback);
    gl.BindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, buffer);
    if (make_subject(&s, &d)) {
        test_probe p = test_scene_probe(SCENE_LAMPS, d.side);
        upload(s.texture, 0, &p);
        gl.UseProgram(program);
        gl.BeginTransformFeedback(GL_TRIANGLES);
        CHECK(lightprobe_gl_update(s.gl, s.texture) == LIGHTPROBE_ERROR_ORDER &&
                  fakes.messages == 1,
              "update");
        gl.PauseTransformFeedback();
        CHECK(!lightprobe_gl_update(s.gl, s.texture), "update while paused");
        gl.ResumeTransformFeedback();
        gl.EndTransformFeedback();
        test_probe_free(&p);
        drop_subject(&s);
    }
    gl.UseProgram(0);
    gl.DeleteProgram(program);
    gl.BindTransformFeedback(GL_TRANSFORM_FEEDBACK, 0);
    gl.DeleteTransformFeedbacks(1, &feedback);
    gl.DeleteBuffers(1, &buffer);
    end_gl();
}

static void names_that_died_raise_no_error(void)
{
    const lightprobe_gl_desc d = description(8, 4);
    static subject s;
    gl_context other;
    GLuint texture, sampler, buffer;
    if (!begin_gl()) return;
    const bool shared = gl_test_share(&context, &other);
    if (shared && make_subject(&s, &d)) {
        test_probe p = test_scene_probe(SCENE_LAMPS, d.side);
        upload(s.texture, 0, &p);
        texture = new_texture(1, 8);
        gl.CreateSamplers(1, &sampler);
        gl.CreateBuffers(1, &buffer);
        gl.NamedBufferStorage(buffer, 4096, NULL, 0);
        gl.BindTextureUnit(0, texture);
        gl.BindSampler(0, sampler);
        for (GLuint i = 0; i < 6; i++)
            gl.BindBufferRange(GL_SHADER_STORAGE_BUFFER, i, buffer, 256, 256);
        gl.BindBuffer(GL_COPY_WRITE_BUFFER, buffer);
        gl_test_make_current(&other);
        gl.DeleteTextures(1, &texture);
        gl.DeleteSamplers(1, &sampler);
        gl.DeleteBuffers(1, &buffer);
        gl_test_make_current(&context);
        CHECK(!lightprobe_gl_update(s.gl, s.texture), "update");
        CHECK(gl.GetError() == GL_NO_ERROR, "GL error");
        lightprobe_gl *second = NULL;
        for (int destroy = 0; destroy < 2; destroy++) {
            GLint left = -1;
            gl.CreateBuffers(1, &buffer);
            gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
            gl_test_make_current(&other);
            gl.DeleteBuffers(1, &buffer);
            gl_test_make_current(&context);
            if (destroy)
                lightprobe_gl_destroy(second);
            else
                CHECK(!lightprobe_gl_create(&second, &d), "%s", fakes.message);
            gl.GetIntegerv(0x90D3, &left); // GL_SHADER_STORAGE_BUFFER_BINDING
            CHECK(gl.GetError() == GL_NO_ERROR && !gl.IsBuffer((GLuint)left) &&
                      (!left || left == (GLint)buffer),
                  "buffer %d after %u", left, buffer);
        }
        test_probe_free(&p);
        drop_subject(&s);
    }
    if (shared) gl_test_unshare(&other);
    end_gl();
}

static void a_program_linked_in_vain_raises_no_error(void)
{
    const lightprobe_gl_desc d = description(8, 4);
    static const char *const text[] = {"layout(local_size_x = 1) in;\nvoid main() {}\n", NULL};
    static subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        test_probe p = test_scene_probe(SCENE_LAMPS, d.side);
        const GLuint program = gl_test_compute("the caller's", text);
        GLint current = -1;
        upload(s.texture, 0, &p);
        gl.UseProgram(program);
        gl_test_link_in_vain(program);
        CHECK(!lightprobe_gl_update(s.gl, s.texture), "update");
        CHECK(strstr(fakes.message, "link failed"), "\"%s\"", fakes.message);
        gl.GetIntegerv(GL_CURRENT_PROGRAM, &current);
        CHECK(gl.GetError() == GL_NO_ERROR && current == 0, "program %d in use", current);
        gl.DeleteProgram(program);
        test_probe_free(&p);
        drop_subject(&s);
    }
    end_gl();
}

static void failures_leave_nothing(void)
{
    const lightprobe_gl_desc d = description(5, 20);
    const char *names[GL_FAKES_NAMES];
    char what[60];
    if (!begin_gl()) return;
    call_all(d, LIGHTPROBE_OK, false, "nothing");
    const gl_fakes all = fakes;
    memcpy(names, fakes.names, sizeof names);
    gl.DebugMessageCallback(NULL, NULL); // what follows from a failure may be an error
    for (int i = 0; i < all.name_count; i++) {
        gl_fakes_reset();
        fakes.missing = names[i];
        call_all(d, LIGHTPROBE_ERROR_GL_VERSION, false, names[i]);
        CHECK(strstr(fakes.message, names[i]), "%s: the message is \"%s\"", names[i],
              fakes.message);
    }
    for (int i = 1; i <= all.allocations; i++) {
        gl_fakes_reset();
        fakes.fail_allocation = i;
        snprintf(what, sizeof what, "GL allocation %d", i);
        call_all(d, LIGHTPROBE_ERROR_GL, false, what);
    }
    for (int i = 1; i <= all.mallocs; i++) {
        gl_fakes_reset();
        fakes.fail_malloc = i;
        snprintf(what, sizeof what, "malloc %d", i);
        call_all(d, LIGHTPROBE_ERROR_MEMORY, false, what);
    }
    for (int i = 1; i <= all.compiles + all.links; i++) {
        gl_fakes_reset();
        if (i <= all.compiles)
            fakes.fail_compile = i;
        else
            fakes.fail_link = i - all.compiles;
        snprintf(what, sizeof what, "shader or program %d", i);
        call_all(d, LIGHTPROBE_ERROR_GL, false, what);
    }
    gl_fakes_reset();
    map_fails = true;
    call_all(d, LIGHTPROBE_ERROR_GL, false, "no mapping");
    map_fails = false;
    test_note("%d functions, %d allocations by GL, %d by malloc, %d shaders", all.name_count,
              all.allocations, all.mallocs, all.compiles);
    CHECK(all.name_count > 20 && all.allocations > 5 && all.mallocs > 1 && all.compiles > 2,
          "hardly anything is seen");
    gl_state_free(&before);
    gl_state_free(&after);
    gl_fakes_reset();
    end_gl();
}

static void old_contexts_are_refused(void)
{
    static const struct {
        int major, minor;
        const char *version;
    } contexts[] = {
        {4, 4, "4.4 (Core Profile) Mesa 22.3.6"}, {3, 2, "OpenGL ES 3.2 Mesa 22.3.6"}, {9, 9, ""}};
    if (!begin_gl()) return;
    for (int i = 0; i < 3; i++) {
        gl_fakes_reset();
        fakes.major = contexts[i].major;
        fakes.minor = contexts[i].minor;
        fakes.version = contexts[i].version;
        call_all(description(5, 4), LIGHTPROBE_ERROR_GL_VERSION, false, contexts[i].version);
        CHECK(strstr(fakes.message, contexts[i].version), "\"%s\"", fakes.message);
    }
    gl_state_free(&before);
    gl_state_free(&after);
    gl_fakes_reset();
    end_gl();
}

static void bad_arguments_are_refused(void)
{
    if (!begin_gl()) return;
    lightprobe_gl *g = NULL;
    lightprobe_gl_desc d = description(-1, 4);
    call_all(d, LIGHTPROBE_ERROR_SIDE, false, "side -1");
    CHECK(strstr(fakes.message, "side -1: 1 to 8192"), "\"%s\"", fakes.message);
    call_all(description(8193, 4), LIGHTPROBE_ERROR_SIDE, false, "side 8193");
    CHECK(strstr(fakes.message, "side 8193: 1 to 8192"), "\"%s\"", fakes.message);
    call_all(description(8, LIGHTPROBE_GL_MAX_LIGHTS + 1), LIGHTPROBE_ERROR_LIGHTS, false,
             "1025 lights");
    CHECK(strstr(fakes.message, "max_lights 1025: 0 to 1024"), "\"%s\"", fakes.message);
    d = description(8, 4);
    d.tolerance = -1;
    call_all(d, LIGHTPROBE_ERROR_SETTINGS, false, "tolerance -1");
    CHECK(strstr(fakes.message, "tolerance -1: 0 or more"), "\"%s\"", fakes.message);
    d.max_lights = 0; // the default's tolerance is no better
    call_all(d, LIGHTPROBE_ERROR_SETTINGS, false, "tolerance -1, no number of lights");
    d = description(8, 4);
    d.first_texture_unit = 1 << 20;
    call_all(d, LIGHTPROBE_ERROR_SETTINGS, false, "unit 2^20");
    CHECK(strstr(fakes.message, "first_texture_unit 1048576: 0 to "), "\"%s\"", fakes.message);
    d.first_texture_unit = -1;
    call_all(d, LIGHTPROBE_ERROR_SETTINGS, false, "unit -1");
    d = description(8, 4);
    d.first_buffer_binding = 1 << 20;
    call_all(d, LIGHTPROBE_ERROR_SETTINGS, false, "binding 2^20");
    CHECK(strstr(fakes.message, "first_buffer_binding 1048576: 0 to "), "\"%s\"", fakes.message);
    d = description(8, 4);
    d.load = NULL;
    CHECK(lightprobe_gl_create(&g, &d) == LIGHTPROBE_ERROR_NULL && !g &&
              strstr(fakes.message, "load"),
          "no loader");
    CHECK(lightprobe_gl_create(NULL, &d) == LIGHTPROBE_ERROR_NULL, "no pointer");
    CHECK(lightprobe_gl_update(NULL, 1) == LIGHTPROBE_ERROR_NULL, "no object");
    lightprobe_gl_destroy(NULL);
    lightprobe_gl_restart(NULL);
    d = description(8, 4);
    if (!lightprobe_gl_create(&g, &d)) {
        GLuint flat, cube = new_texture(1, 16);
        gl.CreateTextures(GL_TEXTURE_2D, 1, &flat);
        gl.TextureStorage2D(flat, 1, GL_RGBA32F, 8, 8);
        const GLuint textures[4] = {0, 12345, flat, cube};
        for (int i = 0; i < 4; i++) {
            gl_fakes_reset();
            CHECK(lightprobe_gl_update(g, textures[i]) == LIGHTPROBE_ERROR_TEXTURE &&
                      fakes.messages,
                  "texture %d is taken", i);
        }
        CHECK(gl.GetError() == GL_NO_ERROR, "GL error");
        gl.DeleteTextures(1, &flat);
        gl.DeleteTextures(1, &cube);
        lightprobe_gl_destroy(g);
    }
    gl_state_free(&before);
    gl_state_free(&after);
    end_gl();
}

const test_case lightprobe_gl_tests[] = {
#if UINTPTR_MAX <= 0xffffffffu
    {0, 0}, // as in test_glsl.c
#endif
    {"GL finds the CPU's lights of a probe, also frame after frame", lights_are_the_cpus},
    {"GL finds the CPU's places of lights", lights_have_the_cpus_places},
    {"GL: lights at places shine as on the CPU", shading_at_places_is_the_cpus},
    {"GL shaders of a probe take no doubles", shaders_take_no_doubles},
    {"GL finds the CPU's lights of hostile probes", hostile_probes_agree},
    {"GL refuses probes without the level asked for", levels_that_are_not_there_are_refused},
    {"GL refuses probes that read as black", what_reads_as_black_is_refused},
    {"GL finds the CPU's lights where there are many", many_lights_agree},
    {"GL reads a probe at the mip level of the side asked for", side_chooses_the_level},
    {"GL: lights follow a turning probe without jumps", a_turning_probe_does_not_jump},
    {"GL finds lights in two contexts at once", two_contexts_at_once},
    {"GL: probes made and dropped again leave nothing", nothing_grows},
    {"GL: shading and CPU see the same lights of a probe", shading_and_cpu_see_the_same},
    {"GL: finding lights leaves the caller's state as found", state_is_left_as_found},
    {"GL: calls that a driver leaves undone are not relied on by probes",
     silent_calls_are_not_relied_on},
    {"GL: waiting for a probe is for its last update", waiting_is_for_the_last_update},
    {"GL: transform feedback is refused while it is active, by probes",
     transform_feedback_is_refused},
    {"GL: names that died raise no error from probes", names_that_died_raise_no_error},
    {"GL: the caller of a probe may link his program again in vain",
     a_program_linked_in_vain_raises_no_error},
    {"GL: failures leave nothing of a probe behind", failures_leave_nothing},
    {"GL below 4.5 is refused for probes", old_contexts_are_refused},
    {"GL: bad arguments for probes are refused", bad_arguments_are_refused},
    {0, 0}};
