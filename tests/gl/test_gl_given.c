// Depth maps that the renderer already has.
#include "gl_subject.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- Depth maps that the renderer already has ---------------------------------------------------

enum {
    FLAT = 0x0DE1,
    FLAT_ARRAY = 0x8C1A,
    CUBE = 0x8513,
    CUBE_ARRAY = 0x9009,
    SAMPLES = 0x9100,
    SAMPLES_ARRAY = 0x9102,
    DEPTH16 = 0x81A5,
    DEPTH24_STENCIL = 0x88F0,
    DEPTH32F_STENCIL = 0x8CAD,
    RED16 = 0x822A,
    RED32F = 0x822E,
    RED8UI = 0x8232,
    COMPARE_MODE = 0x884C,
    COMPARE = 0x884E,
    SWIZZLE_RED = 0x8E42,
    STENCIL_MODE = 0x90EA,
    STENCIL = 0x1901,
    ZERO = 0
};

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
static GLuint given_texture(GLenum target, GLenum format, int width, int height, int layers,
                            int samples, const float *v)
{
    const bool multisampled = target == SAMPLES || target == SAMPLES_ARRAY,
               red = format == RED16 || format == RED32F;
    const GLenum from = red ? 0x1903 : 0x1902; // GL_RED, GL_DEPTH_COMPONENT
    GLuint texture, framebuffer;
    gl.CreateTextures(target, 1, &texture);
    if (target == SAMPLES)
        gl.TextureStorage2DMultisample(texture, samples, format, width, height, GL_TRUE);
    if (target == SAMPLES_ARRAY) {
        gl.TextureStorage3DMultisample(texture, samples, format, width, height, layers, GL_TRUE);
    }
    if (target == FLAT || target == CUBE) gl.TextureStorage2D(texture, 1, format, width, height);
    if (target == FLAT_ARRAY || target == CUBE_ARRAY)
        gl.TextureStorage3D(texture, 1, format, width, height, layers);
    if (target == FLAT)
        gl.TextureSubImage2D(texture, 0, 0, 0, width, height, from, GL_FLOAT, v);
    else if (!multisampled)
        gl.TextureSubImage3D(texture, 0, 0, 0, 0, width, height, layers, from, GL_FLOAT, v);
    for (int i = 0; i < layers && multisampled; i++) {
        const GLuint buffer = bind_window(v + i * width * height * samples, width, height, samples);
        gl.CreateFramebuffers(1, &framebuffer);
        if (target == SAMPLES)
            gl.NamedFramebufferTexture(framebuffer, 0x8D00, texture, 0);
        else
            gl.NamedFramebufferTextureLayer(framebuffer, 0x8D00, texture, 0, i);
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
    static const GLint state[][2] = {
        {COMPARE_MODE, COMPARE}, {GL_TEXTURE_MIN_FILTER, 0x2703}, {GL_TEXTURE_MAG_FILTER, 0x2601}};
    for (int i = 0; i < 3 && !multisampled; i++)
        gl.TextureParameteri(texture, (GLenum)state[i][0], state[i][1]);
    gl.TextureParameteri(texture, SWIZZLE_RED, ZERO);
    if (format == DEPTH24_STENCIL || format == DEPTH32F_STENCIL)
        gl.TextureParameteri(texture, STENCIL_MODE, STENCIL);
    return texture;
}

static void texture_state_is_kept(GLuint texture, GLenum target, GLenum format)
{
    const bool stencil = format == DEPTH24_STENCIL || format == DEPTH32F_STENCIL;
    GLint swizzle = -1, mode = -1, compare = COMPARE;
    gl.GetTextureParameteriv(texture, SWIZZLE_RED, &swizzle);
    gl.GetTextureParameteriv(texture, STENCIL_MODE, &mode);
    if (target != SAMPLES && target != SAMPLES_ARRAY)
        gl.GetTextureParameteriv(texture, COMPARE_MODE, &compare);
    CHECK(swizzle == ZERO && (mode == STENCIL) == stencil && compare == COMPARE,
          "swizzle 0x%X, mode 0x%X, compare 0x%X", swizzle, mode, compare);
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

// By how much a texel of two lights' tables differs at most, in units of the tables, or a least
// depth.
static int maps_differ(const subject *s, int a, int b)
{
    int most = 0, width = 0;
    for (int level = 0, size; level < levels_of(s) && gl_fakes_map_table(s->map[0], level, &size);
         level++) {
        uint32_t *t[2] = {read_level(s, a, level, size), read_level(s, b, level, size)};
        const size_t right = (size_t)s->desc.moments, up = (size_t)(size + 1) * right;
        for (int y = 0; y < size; y++) {
            for (size_t i = (size_t)y * up; i < (size_t)y * up + (size_t)size * right; i++) {
                const int off =
                    abs(texel_value(t[0] + i, right, up) - texel_value(t[1] + i, right, up));
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
    gl.GetTextureImage(least, 0, 0x1903, GL_FLOAT,
                       (GLsizei)(sizeof *z * texels * (size_t)s->desc.lights), z);
    for (size_t i = 0; i < texels; i++) {
        const int off = (int)ceil(
            2945788 * fabs((double)z[(size_t)a * texels + i] - (double)z[(size_t)b * texels + i]));
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

// Every kind of texture, front alone and with back faces, in an atlas' corner: what a pass of our
// own makes of the same depth, to the last bit. The state is left alone, the texture's too.
static void given_depth_is_a_pass(void)
{
    enum { SIDE = 24, X = 5, Y = 8, WIDTH = SIDE + 9, LAYERS = 12, TEXELS = WIDTH * WIDTH * 4 };
    static const struct {
        GLenum target, format;
        int layers, samples;
    } cases[] = {{FLAT, GL_DEPTH_COMPONENT32F, 1, 1},
                 {FLAT, DEPTH16, 1, 1},
                 {FLAT, DEPTH24_STENCIL, 1, 1},
                 {FLAT, RED32F, 1, 1},
                 {FLAT_ARRAY, GL_DEPTH_COMPONENT32F, 5, 1},
                 {FLAT_ARRAY, DEPTH32F_STENCIL, 3, 1},
                 {CUBE, GL_DEPTH_COMPONENT32F, 6, 1},
                 {CUBE_ARRAY, GL_DEPTH_COMPONENT32F, 12, 1},
                 {SAMPLES, GL_DEPTH_COMPONENT32F, 1, 4},
                 {SAMPLES_ARRAY, GL_DEPTH_COMPONENT32F, 4, 4},
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
                texture[k] =
                    given_texture(cases[c].target, cases[c].format, WIDTH, WIDTH, layers, n, v[k]);
                if (n == 1) {
                    float *back = v[k]; // as the format rounds it
                    gl.GetTextureImage(texture[k], 0, cases[c].format == RED32F ? 0x1903 : 0x1902,
                                       GL_FLOAT, (GLsizei)(sizeof *back) * layers * size, back);
                }
                for (int i = 0; i < SIDE * SIDE * s.desc.samples; i++) { // equal samples are one
                    const int texel = i / s.desc.samples, x = texel % SIDE + X,
                              y = texel / SIDE + Y;
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
                for (int k = 0; k < 2; k++)
                    texture_state_is_kept(texture[k], cases[c].target, cases[c].format);
                build(&s);
                // 24 bits are not floats: drivers read them back and sample them with roundings of
                // their own.
                const int off = maps_differ(&s, 0, 1);
                CHECK(off <= (cases[c].format == DEPTH24_STENCIL ? 100 : 0),
                      "target 0x%X, format 0x%X, round %d: off by %d", cases[c].target,
                      cases[c].format, round, off);
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

// Maps of any number of samples a texel, in any order, are each read whole: zink (Mesa 22.3) takes
// for a loop's end what a uniform was some dispatches ago, where it hangs on nothing else.
static void sizes_may_change_from_map_to_map(void)
{
    enum { SIDE = 20, MOST = 4 * SIDE };
    static const int order[] = {1, 1, 2, 2, 4, 4, 1, 1, 4, 4, 2, 2, 1, 4, 2};
    const mssm_gl_desc d = description(4, SIDE, 4, 6);
    static float v[MOST * MOST];
    GLuint texture[3];
    uint64_t seed = 65;
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        for (int i = 0; i < 4; i++) {
            s.light[i] = wide_light(false, 3);
            CHECK(!mssm_gl_set_light(s.gl, i, &s.light[i]), "light");
        }
        for (int i = 0; i < 3; i++) { // each size once, in a light of its own
            mssm_gl_depth given;
            memset(&given, 0, sizeof given);
            dyadic_depth(v, MOST * MOST, &seed);
            given.texture = texture[i] =
                given_texture(FLAT, GL_DEPTH_COMPONENT32F, SIDE << i, SIDE << i, 1, 1, v);
            CHECK(!mssm_gl_set_depth(s.gl, i, &given, NULL), "%s", fakes.message);
        }
        build(&s);
        for (size_t i = 0; i < sizeof order / sizeof *order; i++) {
            const int which = order[i] / 2;
            mssm_gl_depth given;
            memset(&given, 0, sizeof given);
            given.texture = texture[which];
            CHECK(!mssm_gl_set_depth(s.gl, 3, &given, NULL), "%s", fakes.message);
            build(&s);
            const int off = maps_differ(&s, 3, which);
            CHECK(!off, "turn %d, %d samples: off by %d", (int)i, order[i] * order[i], off);
        }
        gl.DeleteTextures(3, texture);
        drop_subject(&s);
    }
    end_gl();
}

// Depth of a stored value by hand: an oracle in double.
static double stored_depth(const mssm_light *light, const mssm_gl_depth *d, double v, double x,
                           double y)
{
    const bool ours = d->z_near == 0 && d->z_far == 0;
    const double n = (double)(ours ? light->z_near : d->z_near),
                 f = (double)(ours ? light->z_far : d->z_far);
    const double far = d->reversed ? 1 - v : v;
    double w = n + far * (f - n);
    if (far >= 1) return 1;
    if (light->perspective && d->stored == MSSM_STORED_WINDOW)
        w = isinf(f) ? n / (1 - far) : n * f / (f - far * (f - n));
    if (d->stored == MSSM_STORED_RADIAL) {
        w /= sqrt(1 + x * x * (double)(light->extent_u * light->extent_u) +
                  y * y * (double)(light->extent_v * light->extent_v));
    }
    const double a = (double)light->z_near, b = (double)light->z_far;
    return fmin(fmax(-1 + 2 * (w - a) / (b - a), -1), 1);
}

// However depth is stored, and whatever part of a texture it fills: the CPU's map of what that
// means.
static void given_depth_means_what_it_says(void)
{
    enum { SIDE = 20, MOST = SIDE * SIDE * 64 };
    static const struct {
        int spot, across, up, samples;
        mssm_stored stored;
        int reversed;
        float z_near, z_far;
    } cases[] = {{0, 1, 1, 1, MSSM_STORED_WINDOW, 1, 0, 0},
                 {0, 1, 1, 4, MSSM_STORED_WINDOW, 1, 0, 0},
                 {0, 2, 2, 1, MSSM_STORED_WINDOW, 0, 0, 0},
                 {0, 4, 2, 1, MSSM_STORED_LINEAR, 0, 0, 0},
                 {0, 8, 8, 1, MSSM_STORED_WINDOW, 1, 0, 0},
                 {0, 2, 4, 4, MSSM_STORED_WINDOW, 0, 0, 0},
                 {0, 1, 1, 1, MSSM_STORED_WINDOW, 0, -3, 9},
                 {0, 1, 1, 1, MSSM_STORED_LINEAR, 1, -3, 9},
                 {1, 1, 1, 1, MSSM_STORED_WINDOW, 1, 0, 0},
                 {1, 1, 1, 1, MSSM_STORED_WINDOW, 0, 0.5f, 30},
                 {1, 1, 1, 1, MSSM_STORED_WINDOW, 1, 0.5f, 30},
                 {1, 1, 1, 4, MSSM_STORED_WINDOW, 1, 1.25f, INFINITY},
                 {1, 2, 1, 1, MSSM_STORED_WINDOW, 0, 1.25f, INFINITY},
                 {1, 1, 1, 1, MSSM_STORED_LINEAR, 0, 0, 0},
                 {1, 1, 1, 1, MSSM_STORED_LINEAR, 1, 0, 0},
                 {1, 1, 3, 1, MSSM_STORED_LINEAR, 0, 0, 12},
                 {1, 1, 1, 1, MSSM_STORED_RADIAL, 0, 0, 0},
                 {1, 1, 1, 1, MSSM_STORED_RADIAL, 1, 0, 12}};
    static float v[MOST], z[MOST];
    const mssm_gl_desc d = description(1, SIDE, 1, 6);
    uint64_t seed = 62;
    int worst = 0;
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
            const int across = cases[c].across, up = cases[c].up, n = cases[c].samples,
                      each = across * up * n;
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
            given.texture =
                given_texture(given.target, GL_DEPTH_COMPONENT32F, width, height, 1, n, v);
            for (int i = 0; i < width * height * n; i++) {
                const int x = i / n % width, y = i / n / width, texel = y / up * SIDE + x / across;
                const double at[2] = {(2.0 * (x / across) + 1) / SIDE - 1,
                                      (2.0 * (y / up) + 1) / SIDE - 1};
                z[texel * each + (y % up * across + x % across) * n + i % n] =
                    (float)stored_depth(&s.light[0], &given, (double)v[i], at[0], at[1]);
            }
            CHECK(!mssm_gl_set_light(s.gl, 0, &s.light[0]), "light");
            CHECK(!mssm_gl_set_depth(s.gl, 0, &given, NULL), "case %d: %s", (int)c, fakes.message);
            CHECK(!mssm_map_update(s.map[0], z, NULL, each), "update");
            build(&s);
            compare_tables(&s, 0, &all);
            CHECK(all.values > 0 && all.largest <= (exact ? slack() : 60), "case %d: off by %d",
                  (int)c, all.largest);
            if (!exact && all.largest > worst) worst = all.largest;
            gl.DeleteTextures(1, &given.texture);
        }
        test_note("a texel differs by at most %.2g of a value where depth is computed",
                  worst / 2945788.0);
        drop_subject(&s);
    }
    end_gl();
}

// A renderer's own depth pass: casters by its matrix into a layer of its texture, single-sampled.
static void own_pass(const mesh *m, const mssm_light *drawn, GLuint texture, int layer,
                     const int area[3], bool reversed, GLuint program)
{
    const GLfloat farthest = reversed ? 0 : 1;
    GLuint framebuffer;
    gl.CreateFramebuffers(1, &framebuffer);
    if (layer < 0)
        gl.NamedFramebufferTexture(framebuffer, 0x8D00, texture, 0);
    else
        gl.NamedFramebufferTextureLayer(framebuffer, 0x8D00, texture, 0, layer);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl.ClearNamedFramebufferfv(framebuffer, 0x1801, 0, &farthest); // GL_DEPTH
    gl.Viewport(area[0], area[1], area[2], area[2]);
    gl.ClipControl(0x8CA1, 0x935F); // lower left, zero to one
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(reversed ? 0x0204 : GL_LESS); // GL_GREATER
    gl.ProgramUniformMatrix4fv(program, gl.GetUniformLocation(program, "world_to_shadow"), 1,
                               GL_FALSE, drawn->world_to_shadow);
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

// As docs/integration.md has it: a sun with depth of 0 to 1, normal and reversed, a lamp in an
// atlas, reversed and without a far plane, and a face of distances. The shadows are those of the
// library's own pass.
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
    const float eye[3] = {0.5f, 6, 1}, to_light[3] = {0.05f, 1, 0.1f}, axis[3] = {1, 0, 0},
                far = 12;
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
            if (sun)
                CHECK(!scene_light(&c, 0.1, 0.1, &light), "light");
            else
                CHECK(!mssm_light_spot(&light, eye, to_light, axis, 1, 0.5f, far, 0.5f, 0.5f),
                      "light");
            drawn = light;
            for (int i = 0; i < 4; i++) { // the matrix of a clip space from 0 to 1
                float *row = &drawn.world_to_shadow[4 * i];
                if (sun)
                    row[2] = reversed ? 0.5f * (row[3] - row[2]) : 0.5f * (row[3] + row[2]);
                else
                    row[2] = reversed ? (i == 3 ? light.z_near : 0) : 0.5f * row[3];
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
            own_pass(&m, &drawn, given.texture, kind == 3 ? 3 : -1, area, reversed,
                     kind == 3 ? program : stage.casters);
            s.light[0] = light;
            draw_light(&s, &m, false);
            CHECK(!mssm_gl_set_light(s.gl, 1, &light) && !mssm_gl_set_depth(s.gl, 1, &given, NULL),
                  "%s", fakes.message);
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
            test_note(
                "%d: visibility differs by %.2g in the mean, by more than .1 for %.0f; %.0f of %d in shadow",
                kind, sum / POINTS, far_off, dark, (int)POINTS);
            CHECK(dark > 100 && sum / POINTS < 0.01 && far_off < 0.01 * POINTS, "%d: other shadows",
                  kind);
            gl.DeleteTextures(1, &given.texture);
        }
        drop_subject(&s);
    }
    gl.DeleteProgram(program);
    drop_mesh(&m);
    end_gl();
}

// What cannot be read is refused by name and range, and the light's map stays as it was.
// Storage made level by level and face by face, of which GL reads 0 without an error: five faces,
// one face of another format, a level that the texture's last one is before, one beyond all levels.
static void make_parts(GLuint part[4], int side)
{
    void(GL_CALL * TexImage2D)(GLenum, GLint, GLint, GLsizei, GLsizei, GLint, GLenum, GLenum,
                               const void *);
    const gl_fakes_function f = gl_context_function("glTexImage2D");
    memcpy(&TexImage2D, &f, sizeof f);
    for (int i = 0; i < 4; i++) {
        const GLenum target = i < 2 ? CUBE : FLAT;
        gl.CreateTextures(target, 1, &part[i]);
        gl.BindTexture(target, part[i]);
        for (int k = 0; k < 6; k++) {
            if (i >= 2 ? k > 1 : i == 0 && k == 3) continue;
            TexImage2D(i < 2 ? 0x8515 + (GLenum)k : FLAT, i < 2 ? 0 : k, // _CUBE_MAP_POSITIVE_X
                       i == 1 && k == 4 ? DEPTH16 : GL_DEPTH_COMPONENT32F, side, side, 0, 0x1902,
                       GL_FLOAT, NULL); // GL_DEPTH_COMPONENT
        }
        gl.BindTexture(target, 0);
    }
    gl.TextureParameteri(part[2], 0x813C, 1); // base level
    gl.TextureParameteri(part[2], 0x813D, 0); // last level
    gl.TextureParameteri(part[3], 0x813C, 1000);
}

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
    GLuint other[3], part[4];
    make_parts(part, SIDE);
    gl.CreateTextures(FLAT, 3, other);
    gl.TextureStorage2D(other[0], 1, RED8UI, SIDE, SIDE);
    gl.TextureStorage2D(other[1], 1, GL_DEPTH_COMPONENT32F, 9 * SIDE,
                        9 * SIDE); // other[2] has no storage
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
        {{flat, 0, 0, 0, 1, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "height 47: 1, 2 ... 8 times"},
        {{flat, 0, 0, 0, 0, 24, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "width 24: 1, 2 ... 8 times"},
        {{flat, 0, 0, 0, 0, INT_MAX, 0, MSSM_STORED_WINDOW, 0, 0, 0},
         0,
         "width 2147483647: 1 to 48"},
        {{other[1], 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0},
         0,
         "width 144: 1, 2 ... 8 times"},
        {{flat, 0, 0, 0, 0, 0, 0, MSSM_STORED_RADIAL, 0, 0, 0}, 0, "stored 2: 0 to 1"},
        {{flat, 0, 0, 0, 0, 0, 0, (mssm_stored)3, 0, 0, 0}, 1, "stored 3: 0 to 2"},
        {{flat, 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 5},
         1,
         "z_near 0, z_far 5: 0 < z_near < z_far"},
        {{flat, 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 5, 2}, 1, "z_near 5, z_far 2"},
        {{flat, 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, NAN, 2}, 1, "z_far 2: 0 <"},
        {{flat, 0, 0, 0, 0, 0, 0, MSSM_STORED_LINEAR, 0, 1, INFINITY}, 1, "both finite"},
        {{flat, 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 1, INFINITY}, 0, "both finite"},
        {{other[0], 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "neither depth nor red"},
        {{part[0], CUBE, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "not complete"},
        {{part[1], CUBE, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "not complete"},
        {{part[2], 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "base level beyond"},
        {{part[3], 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "level 1000 has no storage"},
        {{other[2], 0, 0, 0, 0, 0, 0, MSSM_STORED_WINDOW, 0, 0, 0}, 0, "level 0 has no storage"}};
    WATCH_FAIL(mssm_gl_set_depth(s.gl, 0, &good, NULL), MSSM_ERROR_ORDER); // there is no light yet
    CHECK(strstr(fakes.message, "mssm_gl_set_light"), "\"%s\"", fakes.message);
    for (int i = 0; i < 2; i++) {
        s.light[i] = wide_light(false, 3);
        CHECK(!mssm_gl_set_light(s.gl, i, &s.light[i]), "light");
        CHECK(!mssm_gl_set_depth(s.gl, i, &good, &good), "good: %s", fakes.message);
    }
    build(&s);
    gl.DebugMessageCallback(NULL,
                            NULL); // to find out a target raises an error, which is taken away
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const mssm_light light = wide_light(bad[i].spot, 3);
        CHECK(!mssm_gl_set_light(s.gl, 0, &light), "light");
        for (int framed = 0; framed < 2; framed++) {
            fakes.message[0] = 0;
            if (framed) CHECK(!mssm_gl_begin_frame(s.gl), "begin");
            if (!framed)
                WATCH_FAIL(mssm_gl_set_depth(s.gl, 0, &bad[i].given, NULL), MSSM_ERROR_ARGUMENT);
            else
                CHECK(mssm_gl_set_depth(s.gl, 0, &bad[i].given, NULL) == MSSM_ERROR_ARGUMENT, "%s",
                      bad[i].said);
            if (framed) CHECK(!mssm_gl_end_frame(s.gl), "end");
            CHECK(strstr(fakes.message, bad[i].said), "not \"%s\" but \"%s\"", bad[i].said,
                  fakes.message);
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
    gl.DeleteTextures(4, part);
    drop_subject(&s);
    end_gl();
}

// Given depth maps in a bracket beside passes, in any state of the caller's: all bindings come
// back.
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
            // As drawing may, which binds what it likes.
            gl.BindTextureUnit((GLuint)d.first_texture_unit, cube);
            gl.BindTextureUnit((GLuint)d.first_texture_unit + 1, flat);
            for (int k = 0; k < 2; k++)
                CHECK(!mssm_gl_set_depth(s.gl, k, &given[k], NULL), "%s", fakes.message);
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

const test_case gl_given_tests[] = {
    {"GL's given depth maps are what a pass makes of them", given_depth_is_a_pass},
    {"GL's given depth maps may change their size", sizes_may_change_from_map_to_map},
    {"GL's given depth maps mean what they say", given_depth_means_what_it_says},
    {"GL's own depth maps cast the same shadows", own_depth_maps_cast_the_same_shadows},
    {"GL's given depth maps that cannot be read are refused", bad_depth_maps_are_refused},
    {"GL's given depth maps leave the caller's bindings alone", given_depth_leaves_bindings_alone},
    {0, 0}};
