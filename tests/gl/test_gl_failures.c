// Whatever fails, nothing is left behind; old versions; a second compiler.
#include "gl_subject.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- Failures ---------------------------------------------------------------------------------

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
        CHECK(strstr(fakes.message, " object") || strstr(fakes.message, " MiB of moment maps"),
              "%s: \"%s\" does not say what or how much", what, fakes.message);
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

// ---- A second compiler --------------------------------------------------------------------------

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

const test_case gl_failures_tests[] = {
    {"GL: calls that a driver leaves undone are not relied on", silent_calls_are_not_relied_on},
    {"GL functions may be missing", missing_functions},
    {"GL and malloc may be out of memory", allocations_fail},
    {"GL shaders may fail, with any log", shaders_fail},
    {"GL drivers may have fewer samples or framebuffers", drivers_with_less},
    {"GL: a resize that fails changes nothing", failed_resize_changes_nothing},
    {"GL before 4.5 is refused", old_versions_are_refused},
    {"GL shaders pass a second compiler", second_compiler_agrees},
    {0, 0}};
