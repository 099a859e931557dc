// Objects, order of calls, arguments, sizes, several contexts.
#include "gl_subject.h"

#include "../../lightprobe.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- Objects ----------------------------------------------------------------------------------

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

static void the_last_places_are_enough(void)
{
    GLint units = 0, bindings = 0;
    if (!begin_gl()) return;
    gl.GetIntegerv(0x8B4D, &units);    // GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS
    gl.GetIntegerv(0x90DD, &bindings); // GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS
    for (int i = 0; i < 2; i++) {
        mssm_gl_desc d = description(1, 16, 1, 6);
        mssm_gl *g = NULL;
        d.filtered = i;
        d.first_texture_unit = units - (i ? 2 : 3);
        d.first_buffer_binding = bindings - 1;
        CHECK(!mssm_gl_create(&g, &d) && !mssm_gl_bind(g), "%s", fakes.message);
        CHECK(gl.GetError() == GL_NO_ERROR, "GL error, filtered %d", i);
        mssm_gl_destroy(g);
    }
    end_gl();
}

// Descriptors left at zero: beside a program's own texture at unit 0 and a probe's lights at
// binding 0.
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
                  !mssm_gl_end_depth(s.gl) && !mssm_gl_build(s.gl),
              "passes");
        fakes.messages = 0;
        gl_state_take(&before);
        CHECK(!mssm_gl_bind(s.gl) && !fakes.messages, "\"%s\"", fakes.message);
        same_state(
            "bind",
            "SHADER_STORAGE_BUFFER[7] TEXTURE_BINDING_2D_ARRAY[80] TEXTURE_BINDING_2D_ARRAY[81] "
            "TEXTURE_BINDING_2D_ARRAY[82]");
        // All in one shader, in either order; the program is one that draws.
        const char *const probe[2] = {lightprobe_glsl_math(), lightprobe_glsl_lights()};
        const char *const one = "float mssm_filtered_or_one() { return 1.0; }\n";
        const char *const orders[2][5] = {{probe[0], probe[1], mssm_gl_shader(s.gl), one, body},
                                          {mssm_gl_shader(s.gl), probe[0], probe[1], one, body}};
        for (int i = 0; i < 2; i++)
            CHECK(compiles("#version 450 core\n", orders[i], 5, log), "%s", log);
        const char *const twice[2][3] = {
            {mssm_glsl_math(), mssm_gl_shader(s.gl), "void main() {}\n"},
            {mssm_gl_shader(s.gl), mssm_glsl_math(), "void main() {}\n"}};
        for (int i = 0; i < 2; i++)
            CHECK(compiles("#version 450 core\n", twice[i], 3, log), "%s", log);
        // A second object on the same places says so, once.
        mssm_gl *other = NULL;
        CHECK(!mssm_gl_create(&other, &d), "%s", fakes.message);
        fakes.messages = 0;
        CHECK(!mssm_gl_bind(other) && fakes.messages == 4 && strstr(fakes.message, "binding 7"),
              "%d: \"%s\"", fakes.messages, fakes.message);
        CHECK(!mssm_gl_bind(s.gl) && !mssm_gl_bind(other) && fakes.messages == 4, "%d messages",
              fakes.messages);
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
        const char *const same[] = {"#define LIGHTPROBE_BINDING 3\n", lightprobe_glsl_math(),
                                    lightprobe_glsl_lights(), mssm_gl_shader(s.gl),
                                    "void main() {}\n"};
        const char *const turned[] = {"#define LIGHTPROBE_BINDING 3\n", mssm_gl_shader(s.gl),
                                      lightprobe_glsl_math(), lightprobe_glsl_lights(),
                                      "void main() {}\n"};
        CHECK(!compiles("#version 450 core\n", same, 5, log) && strstr(log, "first_buffer_binding"),
              "%s", log);
        CHECK(!compiles("#version 450 core\n", turned, 5, log) &&
                  strstr(log, "first_buffer_binding"),
              "%s", log);
        const char *const alone[] = {mssm_gl_shader(s.gl), "void main() {}\n"};
        CHECK(compiles("#version 430 core\n", alone, 2, log), "%s", log);
        CHECK(!compiles("#version 330 core\n", alone, 2, log) && strstr(log, "#version 430"), "%s",
              log);
        const char *const wrong[] = {mssm_gl_shader(s.gl), "void main()\n{\n    wrong = 1.0;\n}\n"};
        CHECK(!compiles("#version 450 core\n", wrong, 2, log) && strstr(log, ":3("),
              "not line 3: %s", log);
        mssm_gl_destroy(s.gl);
    }
    end_gl();
}

// ---- Versions, order, arguments, life -----------------------------------------------------------

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
        CHECK(strstr(fakes.message, bad[i].what), "not \"%s\" but \"%s\"", bad[i].what,
              fakes.message);
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
    d.settings.estimator = (mssm_estimator)4;
    CHECK(mssm_gl_create(&g, &d) == MSSM_ERROR_ARGUMENT && g == nothing, "estimator 4");
    CHECK(strstr(fakes.message, "settings.estimator 4: 0 to 3"), "\"%s\"", fakes.message);
    d = good;
    d.log = NULL;
    d.moments = 5;
    CHECK(mssm_gl_create(&g, &d) == MSSM_ERROR_ARGUMENT && g == nothing, "no log");
    CHECK(mssm_gl_create(&g, &good) == MSSM_OK, "good description");
    for (int i = -1; i <= 2; i += 3) {
        WATCH_FAIL(mssm_gl_set_light(g, i, &light), MSSM_ERROR_ARGUMENT);
        WATCH_FAIL(mssm_gl_begin_depth(g, i, 0), MSSM_ERROR_ARGUMENT);
        CHECK(strstr(fakes.message, i < 0 ? "light -1: 0 to 1" : "light 2: 0 to 1"), "\"%s\"",
              fakes.message);
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
    // Moments of another kind would be read as 0: an array of one layer, a small one, other numbers,
    // a base level that is not the one read; and what is no array.
    gl.DebugMessageCallback(NULL,
                            NULL); // to find out a target raises an error, which is taken away
    for (int i = 0; i < 6; i++) {
        GLuint texture;
        gl.CreateTextures(i < 5 ? GL_TEXTURE_2D_ARRAY : 0x0DE1, 1, &texture);
        if (i < 5)
            gl.TextureStorage3D(texture, 2, i == 3 ? 0x881A : GL_RGBA32F, i == 2 ? 31 : 40, 32,
                                i == 1 ? 1 : 2); // GL_RGBA16F
        else
            gl.TextureStorage2D(texture, 1, GL_RGBA32F, 40, 40);
        if (i == 4) gl.TextureParameteri(texture, 0x813C, 1); // base level
        if (!i) WATCH_OK(mssm_gl_set_moments(g, 0, texture), NULL);
        if (i) WATCH_FAIL(mssm_gl_set_moments(g, 0, texture), MSSM_ERROR_ARGUMENT);
        CHECK(!i || strstr(fakes.message, i < 5 ? "two layers of GL_RGBA32F, of side 32" : "is no"),
              "\"%s\"", fakes.message);
        gl.DeleteTextures(1, &texture);
    }
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

// The most pages in each quarter of them. The driver returns a fifth of all now and then, but what leaks
// does so in each quarter.
static void many_lives_do_not_grow(void)
{
    const int lives = test_trials(200);
    const mssm_gl_desc d = description(4, 256, 4, 6);
    long most[4] = {0, 0, 0, 0};
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
        long *quarter = most + 4 * i / lives;
        const long pages = resident_pages();
        if (pages > *quarter) *quarter = pages;
    }
    const long third = most[2] - most[1], last = most[3] - most[2];
    const long growth = third < last ? third : last;
    test_note("%d lives, %ld and %ld pages more a quarter", lives, third, last);
    CHECK(lives < 100 || growth < 500, "%ld pages", growth);
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

// Front faces wait for their back faces. Whatever comes instead, each map is that of its own
// passes, and of the light as it was then.
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
            const float eye[3] = {1, 5, 1.5f}, to_light[3] = {0.3f, 1, 0.45f},
                        axis[3] = {1, 0, 0.2f};
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

// Lights that become moments together have the tables of those that do so alone: with and without
// back faces, directional and spot, drawn again before the build.
static void together_is_as_alone(void)
{
    enum { SIDE = 40, LIGHTS = 40, COUNT = SIDE * SIDE * 4 };
    static float z[2 * COUNT];
    static subject both[2];
    const mssm_gl_desc d = description(LIGHTS, SIDE, 4, 6);
    int unequal = 0, filled = 0;
    if (!begin_gl()) return;
    if (make_subject(&both[0], &d) && make_subject(&both[1], &d)) {
        for (int alone = 0; alone < 2; alone++) {
            subject *s = &both[alone];
            uint64_t seed = 90;
            for (int i = 0; i < LIGHTS; i++) {
                s->light[i] = wide_light(i % 3 == 0, 0.5f);
                for (int again = i % 5 == 2; again >= 0; again--) {
                    random_depth(z, SIDE, 4, &seed);
                    random_depth(z + COUNT, SIDE, 4, &seed);
                    fill(s, i, z, (i + again) % 4 == 1 ? z + COUNT : NULL);
                    CHECK(mssm_gl_layer(s->gl) == -1, "a layer between passes");
                }
                if (alone) CHECK(!mssm_gl_build(s->gl), "build");
            }
            build(s);
        }
        for (int i = 0; i < LIGHTS; i++) {
            uint32_t *a = read_level(&both[0], i, 0, SIDE), *b = read_level(&both[1], i, 0, SIDE);
            const size_t values = (size_t)(SIDE + 1) * (SIDE + 1) * 6;
            for (size_t k = 0; k < values; k++) unequal += a[k] != b[k], filled += a[k] != 0;
            free(a);
            free(b);
        }
        CHECK(!unequal && filled > LIGHTS * SIDE * SIDE * 5, "%d of %d differ", unequal, filled);
    }
    drop_subject(&both[0]);
    drop_subject(&both[1]);
    end_gl();
}

// The largest difference of a light's least depths, of all levels, from those of the CPU's map.
static double compare_least_depths(const subject *s, int index)
{
    const GLuint texture = mssm_gl_texture(s->gl, 2);
    double worst = 0;
    mssm_texels t;
    gl.MemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
    for (int level = 0, size = (s->desc.side + 1) / 2;
         !mssm_map_texels(s->map[index], 2, level, &t, NULL, 0); level++, size = (size + 1) / 2) {
        GLint width = 0;
        gl.GetTextureLevelParameteriv(texture, level, GL_TEXTURE_WIDTH, &width);
        const size_t layer = 2 * (size_t)width * (size_t)width;
        const size_t bytes = layer * (size_t)s->desc.lights * sizeof(float);
        float *gpu = allocate(bytes), *cpu = allocate(t.bytes);
        gl.GetTextureImage(texture, level, GL_RG, GL_FLOAT, (GLsizei)bytes, gpu);
        CHECK(!mssm_map_texels(s->map[index], 2, level, &t, cpu, t.bytes), "texels");
        for (int i = 0; i < 2 * size * size; i++) {
            const int x = i % (2 * size), y = i / (2 * size);
            const float a = gpu[layer * (size_t)index + (size_t)(2 * width * y + x)];
            worst = fmax(worst, fabs((double)a - (double)cpu[2 * t.side * y + x]));
        }
        free(gpu);
        free(cpu);
    }
    return worst;
}

// One pass that binds what it needs when the pass has begun, as within a frame.
static void bound_within(subject *s, int index, bool back, const float *z)
{
    const GLuint buffer = bind_depth(&s->light[index], z, s->desc.side, s->desc.samples);
    CHECK(!mssm_gl_begin_depth(s->gl, index, back), "begin");
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, DEPTH_BINDING, buffer);
    bind_fill(back);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    CHECK(!mssm_gl_end_depth(s->gl), "end");
    gl.DeleteBuffers(1, &buffer);
    gl.UseProgram(0);
    gl.BindVertexArray(0);
}

// What linear depth maps of a renderer's hold, in place of passes.
static void give_depth(subject *s, int index, float *z)
{
    const int side = s->desc.side;
    mssm_gl_depth given = {.stored = MSSM_STORED_LINEAR};
    for (int i = 0; i < side * side; i++) z[i] = fminf(0.5f + 0.5f * z[i], 0.99f);
    gl.CreateTextures(GL_TEXTURE_2D, 1, &given.texture);
    gl.TextureStorage2D(given.texture, 1, GL_R32F, side, side);
    gl.TextureSubImage2D(given.texture, 0, 0, 0, side, side, GL_RED, GL_FLOAT, z);
    CHECK(!mssm_gl_set_depth(s->gl, index, &given, NULL), "set depth: %s", fakes.message);
    gl.DeleteTextures(1, &given.texture);
    for (int i = 0; i < side * side; i++) z[i] = 2 * z[i] - 1;
    CHECK(!mssm_map_update(s->map[index], z, NULL, 1), "update");
}

// Passes, given depth, builds, frames and refusals as they come: each map is what its light had last.
static void passes_come_in_any_order(void)
{
    enum { SIDES = 6, LIGHTS = 20, LARGEST = 70 * 70 * 4 };
    static const int sides[SIDES] = {1, 2, 3, 17, 40, 70};
    static float z[2][LARGEST];
    static subject s;
    uint64_t seed = 91;
    if (!begin_gl()) return;
    // Of sums of 4,900 roundings: 60 with quotients and roots that are two units off.
    const int most = gl_test_rounds() ? 60 : 90;
    for (int round = 0; round < 2 * SIDES; round += stride()) {
        const int lights = round % 3 ? LIGHTS : 2, side = sides[round % SIDES];
        const mssm_gl_desc d = description(lights, side, 4, round % 4 ? 6 : 4);
        int drawn[LIGHTS] = {0}, framed = 0, front = -1;
        if (!make_subject(&s, &d)) break;
        for (int i = 0; i < lights; i++) {
            s.light[i] = wide_light(i % 3 == 0, 2.5f);
            CHECK(!mssm_gl_set_light(s.gl, i, &s.light[i]), "light");
        }
        for (int step = 0; step < 60; step++) {
            const int i = (int)test_range(&seed, 0, lights), what = (int)test_range(&seed, 0, 12);
            const bool back = what > 5 && what < 8 && front >= 0,
                       built = what == 10 && step % 3 == 0;
            if (what < 8 || what == 9) random_depth(z[back], side, s.desc.samples, &seed);
            if (what == 8)
                CHECK(mssm_gl_set_depth(s.gl, i, NULL, NULL) &&
                          mssm_gl_begin_depth(s.gl, lights, 0) && mssm_gl_end_depth(s.gl) &&
                          (i == front || mssm_gl_begin_depth(s.gl, i, 1)),
                      "nothing is refused");
            if (what < 6) bound_within(&s, i, false, z[0]);
            if (what < 6) fill_map(&s, i, z[0], NULL);
            if (back) bound_within(&s, front, true, z[1]);
            if (back) fill_map(&s, front, z[0], z[1]);
            if (what == 9) give_depth(&s, i, z[0]);
            if (built) build(&s);
            if (what == 11)
                CHECK(!(framed ? mssm_gl_end_frame : mssm_gl_begin_frame)(s.gl), "frame");
            framed ^= what == 11;
            drawn[i] |= what < 6 || what == 9;
            if (what < 8 || what == 9 || built) front = what < 6 ? i : -1;
        }
        build(&s);
        if (framed) CHECK(!mssm_gl_end_frame(s.gl), "end of the frame");
        for (int i = 0; i < lights; i++) {
            difference all = {0, 0, 0};
            if (!drawn[i]) continue;
            compare_tables(&s, i, &all);
            const double least = compare_least_depths(&s, i);
            CHECK(all.largest < most && least < 1e-5, "light %d of side %d is off by %d and %g", i,
                  side, all.largest, least);
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

// ---- To look at and to plan with ----------------------------------------------------------------

// Bytes of all textures and buffers of the context.
static size_t bytes_in_use(void)
{
    static const GLenum bits[] = {0x805C, 0x805D, 0x805E, 0x805F,
                                  0x884A}; // red, green, blue, alpha, depth
    GLboolean(GL_CALL * is_texture)(GLuint), (GL_CALL * is_buffer)(GLuint);
    void(GL_CALL * buffer_parameter)(GLuint, GLenum, GLint *);
    const gl_fakes_function f[3] = {gl_context_function("glIsTexture"),
                                    gl_context_function("glIsBuffer"),
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
            sum += (size_t)size[0] * (size_t)size[1] * (size_t)size[2] *
                   (size_t)(texel / 8 * (samples ? samples : 1));
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
    static const int cases[][5] = {{1, 256, 4, 6, 0}, {3, 100, 4, 4, 0}, {7, 1, 4, 6, 0},
                                   {2, 300, 4, 6, 0}, {1, 27, 4, 4, 0},  {1, 28, 4, 6, 0},
                                   {2, 100, 4, 4, 1}, {1, 256, 4, 6, 1}};
    if (!begin_gl()) return;
    gl.DebugMessageCallback(NULL, NULL); // a level that is not there may be asked for
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        mssm_gl_desc d = description(cases[i][0], cases[i][1], cases[i][2], cases[i][3]);
        mssm_gl *g = NULL;
        const size_t had = bytes_in_use();
        d.filtered = cases[i][4];
        CHECK(!mssm_gl_create(&g, &d), "create");
        const size_t has = bytes_in_use() - had, said = mssm_gl_bytes(&d);
        CHECK(had == bytes_in_use() - has && said == has, "%d lights of %d: %lu bytes, said %lu",
              cases[i][0], cases[i][1], (unsigned long)has, (unsigned long)said);
        mssm_gl_destroy(g);
        gl.GetError();
    }
    // A light more: side^2 * 26 bytes and a third more, filtered 8.
    for (int filtered = 0; filtered < 2; filtered++) {
        mssm_gl_desc few = description(40, 256, 4, filtered ? 4 : 6), more = few;
        few.filtered = more.filtered = filtered;
        more.lights++;
        const double each =
            (double)(mssm_gl_bytes(&more) - mssm_gl_bytes(&few)) * 3 / (4 * 256 * 256);
        CHECK(fabs(each - (filtered ? 8 : 26)) < 0.1, "%g bytes", each);
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
        CHECK(!mssm_gl_set_light(s.gl, 0, &s.light[0]) && !mssm_gl_stale(s.gl, 0),
              "the same light");
        s.light[0] = wide_light(false, 3);
        CHECK(!mssm_gl_set_light(s.gl, 0, &s.light[0]) &&
                  mssm_gl_stale(s.gl, 0) == MSSM_STALE_TABLES,
              "another size");
        CHECK(!mssm_gl_bind(s.gl) && mssm_gl_stale(s.gl, 0) == MSSM_STALE_TABLES,
              "bound, not built");
        build(&s);
        CHECK(!mssm_gl_stale(s.gl, 0), "built");
        s.light[0].world_to_shadow[12] += 0.1f;
        CHECK(!mssm_gl_set_light(s.gl, 0, &s.light[0]) && mssm_gl_stale(s.gl, 0) == BOTH, "moved");
        build(&s);
        CHECK(mssm_gl_stale(s.gl, 0) == MSSM_STALE_MAP, "moved, not drawn");
        CHECK(!mssm_gl_resize(s.gl, 2, SIDE) && mssm_gl_stale(s.gl, 0) == MSSM_STALE_MAP,
              "resized");
        CHECK(!mssm_gl_stale(s.gl, 2) && strstr(fakes.message, "light 2: 0 to 1") &&
                  !mssm_gl_stale(NULL, 0),
              "none");
        drop_subject(&s);
    }
    end_gl();
}

// Blending that GL refuses with shaders that do not name it, where there is such a thing.
static void multiply_colours(void)
{
    void(GL_CALL * equation)(GLenum);
    const unsigned char *(GL_CALL * extension)(GLenum, GLuint);
    const gl_fakes_function f[2] = {gl_context_function("glBlendEquation"),
                                    gl_context_function("glGetStringi")};
    GLint extensions = 0;
    gl.GetIntegerv(0x821D, &extensions); // GL_NUM_EXTENSIONS
    memcpy(&equation, &f[0], sizeof f[0]);
    memcpy(&extension, &f[1], sizeof f[1]);
    for (GLuint i = 0; (GLint)i < extensions; i++) {
        const char *name = (const char *)extension(0x1F03, i);                 // GL_EXTENSIONS
        if (!strcmp(name, "GL_KHR_blend_equation_advanced")) equation(0x9294); // GL_MULTIPLY_KHR
    }
}

// A map as a picture is the depth that was drawn, whatever the caller's state would do to it.
static void maps_can_be_seen(void)
{
    enum { SIDE = 27, COUNT = SIDE * SIDE * 4, SCALE = 2, SIZE = SCALE * SIDE, WIDTH = SIZE + 3 };
    static float z[COUNT], seen[WIDTH * (SIZE + 5)];
    const mssm_gl_desc d = description(2, SIDE, 4, 6);
    uint64_t seed = 74;
    static const GLenum drawn[4] = {0x8CE0, 0x8CE1, 0, 0x8CE3}; // GL_COLOR_ATTACHMENT0 ...
    GLuint texture, framebuffer, others[2];
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        for (int i = 0; i < 2; i++) s.light[i] = wide_light(false, 3);
        random_depth(z, SIDE, 4, &seed);
        fill(&s, 1, z, NULL);
        WATCH_FAIL(mssm_gl_show(s.gl, 1, MSSM_SHOW_MEAN), MSSM_ERROR_ORDER);
        build(&s);
        gl.CreateTextures(0x0DE1, 1, &texture);
        gl.TextureStorage2D(texture, 1, GL_R32F, WIDTH, SIZE + 5);
        gl.CreateFramebuffers(1, &framebuffer);
        gl.NamedFramebufferTexture(framebuffer, 0x8CE0, texture, 0); // GL_COLOR_ATTACHMENT0
        // A G-buffer: its other colours are none of the picture's.
        gl.CreateTextures(0x0DE1, 2, others);
        for (int i = 0; i < 2; i++) {
            gl.TextureStorage2D(others[i], 1, GL_R32F, WIDTH, SIZE + 5);
            gl.NamedFramebufferTexture(framebuffer, drawn[1 + 2 * i], others[i], 0);
        }
        gl.NamedFramebufferDrawBuffers(framebuffer, 4, drawn);
        gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
        gl.ClearColor(0.75f, 0, 0, 0);
        gl.Clear(0x4000); // GL_COLOR_BUFFER_BIT
        gl.Viewport(3, 5, SIZE, SIZE);
        gl.Enable(GL_DEPTH_TEST);
        gl.Enable(GL_CULL_FACE);
        gl.CullFace(GL_FRONT_AND_BACK);
        gl.Enablei(0x0BE2, 0); // GL_BLEND
        gl.Enablei(0x0BE2, 3);
        multiply_colours();
        gl.Enablei(GL_SCISSOR_TEST, 0);
        gl.ScissorIndexed(0, 0, 0, 1, 1);
        gl.ColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
        gl.Enable(GL_RASTERIZER_DISCARD);
        for (int what = 0; what < 2; what++) {
            double worst = 0;
            WATCH_OK(mssm_gl_show(s.gl, 1, (mssm_show)what), NULL);
            gl.GetTextureImage(texture, 0, 0x1903, GL_FLOAT, sizeof seen, seen);
            for (int i = 0; i < SIZE * SIZE; i++) {
                const int x = i % SIZE / SCALE, y = i / SIZE / SCALE;
                double wanted = what ? 1 : 0;
                for (int k = 0; k < 4 && !what; k++)
                    wanted += 0.25 * (double)z[(y * SIDE + x) * 4 + k];
                for (int k = 0; k < 16 && what; k++) {
                    const int u = x / 2 * 2 + k % 2, v = y / 2 * 2 + k / 2 % 2;
                    if (u < SIDE && v < SIDE)
                        wanted = fmin(wanted, (double)z[(v * SIDE + u) * 4 + k / 4]);
                }
                worst = fmax(worst, fabs((double)seen[(i / SIZE + 5) * WIDTH + i % SIZE + 3] -
                                         (0.5 + 0.5 * wanted)));
            }
            CHECK(worst < 2e-6, "%d: off by %g", what, worst);
        }
        for (int i = 0; i < 2; i++) {
            int changed = 0;
            gl.GetTextureImage(others[i], 0, 0x1903, GL_FLOAT, sizeof seen, seen);
            for (int k = 0; k < WIDTH * (SIZE + 5); k++) changed += seen[k] != 0.75f;
            CHECK(!changed, "%d texels of another draw buffer were changed", changed);
        }
        WATCH_FAIL(mssm_gl_show(s.gl, 0, MSSM_SHOW_MEAN), MSSM_ERROR_ORDER); // has no map
        WATCH_FAIL(mssm_gl_show(s.gl, 2, MSSM_SHOW_MEAN), MSSM_ERROR_ARGUMENT);
        WATCH_FAIL(mssm_gl_show(s.gl, 1, (mssm_show)2), MSSM_ERROR_ARGUMENT);
        for (int i = 0; i < 4; i++)
            gl.NamedFramebufferTexture(framebuffer, 0x8CE0 + (GLenum)i, 0, 0);
        WATCH_FAIL(mssm_gl_show(s.gl, 1, MSSM_SHOW_MEAN), MSSM_ERROR_GL); // into nothing
        WATCH_FAIL(mssm_gl_show(NULL, 1, MSSM_SHOW_MEAN), MSSM_ERROR_ARGUMENT);
        gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
        gl.DeleteFramebuffers(1, &framebuffer);
        gl.DeleteTextures(1, &texture);
        gl.DeleteTextures(2, others);
        drop_subject(&s);
    }
    end_gl();
}

const test_case gl_life_tests[] = {
    {"GL objects are labelled and deleted", objects_are_labelled_and_deleted},
    {"GL's bad arguments are refused", bad_arguments_are_refused},
    {"GL's wrong order of calls is refused", wrong_order_is_refused},
    {"GL's zeroed descriptors disturb nobody", zeroed_descriptors_disturb_nobody},
    {"GL's last texture units and bindings are enough", the_last_places_are_enough},
    {"GL's defaults are those of the description", defaults},
    {"GL's memory does not grow with many lives", many_lives_do_not_grow},
    {"GL's resize keeps lights and empties maps", resize_keeps_lights_and_empties_maps},
    {"GL's lights are updated one by one", lights_are_updated_alone},
    {"GL's front faces wait for their back faces", front_faces_wait},
    {"GL's lights that become moments together are as those alone", together_is_as_alone},
    {"GL's passes come in any order", passes_come_in_any_order},
    {"GL builds more lights than one dispatch takes", many_lights},
    {"GL's lights may change their size without being drawn", sizes_change_without_drawing},
    {"GL works in two contexts at once", two_contexts_at_once},
    {"GL's bytes are counted", bytes_are_counted},
    {"GL's stale lights are told", stale_lights_are_told},
    {"GL's maps can be seen", maps_can_be_seen},
    {0, 0}};
