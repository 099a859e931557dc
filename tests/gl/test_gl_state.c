// The caller's state: left alone whatever it is, and harmless to what is computed.
#include "gl_subject.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
        CHECK(!mssm_gl_end_depth(g) && fakes.depth_bounds == on, "it was %d and is %d", on,
              fakes.depth_bounds);
        mssm_gl_destroy(g);
    }
    end_gl();
}

// GL forbids other programs then: no call does its work, and all say so.
static void transform_feedback_is_refused(void)
{
    static const char *const texts[2] = {"void main() { gl_Position = vec4(0); }\n",
                                         "void main() {}\n"};
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
            CHECK(fakes.messages == 1 && strstr(fakes.message, "transform feedback"), "\"%s\"",
                  fakes.message);
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
    static const char *const texts[2] = {"void main() { gl_Position = vec4(0); }\n",
                                         "void main() {}\n"};
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
            gl.CreateTextures(GL_TEXTURE_2D_MULTISAMPLE_ARRAY, 1, &texture);
            gl.TextureStorage3DMultisample(texture, 4, GL_RGBA8, 8, 8, 2, GL_TRUE);
            gl.CreateSamplers(1, &sampler);
            gl.BindTextureUnit(5, texture);
            gl.BindSampler(5, sampler);
            gl.BindImageTexture(1, texture, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA8);
            gl_test_make_current(&other);
            gl.DeleteTextures(1, &texture);
            gl.DeleteSamplers(1, &sampler);
            gl_test_make_current(&stage.context);
            CHECK(!mssm_gl_build(g) && !mssm_gl_begin_depth(g, 0, 0) && !mssm_gl_end_depth(g),
                  "passes");
            gl.BindTextureUnit(5, 0);
            gl.BindSampler(5, 0);
            // A buffer and a texture whose turn comes when objects are made, bound and deleted.
            const mssm_light second = wide_light(false, 0.5f);
            mssm_gl *h = NULL;
            for (int what = 0; what < 6; what++) {
                GLint left[2] = {-1, -1};
                GLuint died;
                gl.CreateTextures(GL_TEXTURE_2D_MULTISAMPLE_ARRAY, 1, &texture);
                gl.TextureStorage3DMultisample(texture, 4, GL_RGBA8, 8, 8, 2, GL_TRUE);
                gl.BindTexture(GL_TEXTURE_2D_MULTISAMPLE_ARRAY, texture);
                gl.CreateBuffers(1, &died);
                gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, died);
                gl_test_make_current(&other);
                gl.DeleteTextures(1, &texture);
                gl.DeleteBuffers(1, &died);
                gl_test_make_current(&stage.context);
                mssm_result r = MSSM_OK;
                if (what == 0) r = mssm_gl_create(&h, &d);
                if (what == 1) r = mssm_gl_bind(g);
                if (what == 2) r = mssm_gl_set_light(g, 0, &second);
                if (what == 2 && !r) r = mssm_gl_build(g);
                if (what == 3) r = mssm_gl_build(g); // nothing to do
                if (what == 4) r = mssm_gl_resize(g, 1, 48);
                if (what == 5) mssm_gl_destroy(h);
                const GLenum error = gl.GetError();
                gl.GetIntegerv(0x90D3, &left[0]); // GL_SHADER_STORAGE_BUFFER_BINDING
                gl.GetIntegerv(0x9105, &left[1]); // GL_TEXTURE_BINDING_2D_MULTISAMPLE_ARRAY
                CHECK(!r && !error && (!left[0] || left[0] == (GLint)died) &&
                          !gl.IsBuffer((GLuint)left[0]),
                      "call %d: %s, error 0x%X, buffer %d of %u", what, mssm_result_string(r),
                      error, left[0], died);
                CHECK(!gl.IsTexture((GLuint)left[1]), "call %d: texture %d lives", what, left[1]);
                gl.BindTexture(GL_TEXTURE_2D_MULTISAMPLE_ARRAY, 0);
                gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, 0);
            }
            gl_test_unshare(&other);
        }
        // A frame's names are kept longest. Bound again in a compatibility context, it would live.
        GLuint buffer;
        gl.CreateBuffers(1, &buffer);
        gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
        CHECK(!mssm_gl_begin_frame(g), "begin");
        gl.DeleteBuffers(1, &buffer);
        CHECK(!mssm_gl_begin_depth(g, 0, 0) && !mssm_gl_end_depth(g) && !mssm_gl_build(g) &&
                  !mssm_gl_end_frame(g),
              "frame");
        GLint bound = -1;
        gl.GetIntegerv(0x90D3, &bound); // GL_SHADER_STORAGE_BUFFER_BINDING
        CHECK(bound == 0, "buffer %d is bound", bound);
        CHECK(gl.GetError() == GL_NO_ERROR, "GL error");
        mssm_gl_destroy(g);
    }
    end_gl();
}

// A shader that is mended while the program runs may fail to link: GL goes on with the old one, but
// does not take it back after another. In a frame or not, no error, a word, and 0 in use.
static void programs_linked_in_vain_raise_no_error(void)
{
    static const char *const texts[2] = {"void main() { gl_Position = vec4(0); }\n",
                                         "void main() {}\n"};
    const mssm_gl_desc d = description(1, 32, 4, 6);
    const mssm_light light = wide_light(false, 1);
    mssm_gl *g = NULL;
    if (!begin_gl()) return;
    CHECK(!mssm_gl_create(&g, &d) && !mssm_gl_set_light(g, 0, &light), "%s", fakes.message);
    for (int framed = 0; framed < 2 && g; framed++) {
        const GLuint program = link_program(texts);
        GLint current = -1;
        gl.UseProgram(program);
        gl_test_link_in_vain(program);
        fakes.messages = 0;
        if (framed) CHECK(!mssm_gl_begin_frame(g), "begin of a frame");
        CHECK(!mssm_gl_begin_depth(g, 0, 0) && !mssm_gl_end_depth(g) && !mssm_gl_build(g), "pass");
        if (framed) CHECK(!mssm_gl_end_frame(g), "end of a frame");
        CHECK(fakes.messages == 1 && strstr(fakes.message, "link failed"), "%d messages: \"%s\"",
              fakes.messages, fakes.message);
        gl.GetIntegerv(GL_CURRENT_PROGRAM, &current);
        CHECK(gl.GetError() == GL_NO_ERROR && current == 0, "program %d in use", current);
        gl.DeleteProgram(program);
    }
    mssm_gl_destroy(g);
    end_gl();
}

// Of faces, lines and points: llvmpipe offsets faces by any of the three.
static void polygon_offsets_move_nothing(void)
{
    enum { SIDE = 32, COUNT = SIDE * SIDE * 4 };
    static const char *const texts[2] = {
        "void main() { gl_Position = vec4(vec2(gl_VertexID % 2, gl_VertexID / 2) * 4.0 - 1.0, "
        "0.25, 1.0); }\n",
        "void main() {}\n"};
    static const GLenum switches[] = {0, GL_POLYGON_OFFSET_FILL, GL_POLYGON_OFFSET_LINE,
                                      GL_POLYGON_OFFSET_POINT};
    static int32_t table[2][COUNT];
    const mssm_gl_desc d = description(1, SIDE, 4, 6);
    const mssm_light light = wide_light(false, 1);
    mssm_gl *g = NULL;
    if (!begin_gl()) return;
    CHECK(!mssm_gl_create(&g, &d) && !mssm_gl_set_light(g, 0, &light), "%s", fakes.message);
    const GLuint program = link_program(texts);
    gl.PolygonOffset(20, 1e5f);
    for (int i = 0; i < 4 && g; i++) {
        if (switches[i]) gl.Enable(switches[i]);
        CHECK(!mssm_gl_begin_depth(g, 0, 0), "begin");
        gl.UseProgram(program);
        gl.BindVertexArray(stage.array);
        gl.DrawArrays(GL_TRIANGLES, 0, 3);
        gl.UseProgram(0);
        gl.BindVertexArray(0);
        CHECK(!mssm_gl_end_depth(g) && !mssm_gl_build(g), "end");
        if (switches[i]) gl.Disable(switches[i]);
        gl.MemoryBarrier(0x100); // GL_TEXTURE_UPDATE_BARRIER_BIT
        gl.GetTextureImage(mssm_gl_texture(g, 0), 0, 0x8D99, 0x1404, sizeof table[0],
                           table[i > 0]); // GL_RGBA_INTEGER, GL_INT
        CHECK(!i || !memcmp(table[0], table[1], sizeof table[0]), "offset %d moves faces", i);
    }
    CHECK(table[0][COUNT - 1] != table[0][0], "nothing was drawn");
    gl.PolygonOffset(0, 0);
    gl.DeleteProgram(program);
    mssm_gl_destroy(g);
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

// One bracket round all passes of a frame: the same numbers, whatever the drawing changes, and the
// state as it was at the end.
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

// Programs in use come before pipelines: none of ours may stay when the target was full.
static void frames_are_for_pipelines_too(void)
{
    enum { LIGHTS = 40, SIDE = 8 };
    static const GLchar *const text =
        "#version 450 core\n"
        "out gl_PerVertex { vec4 gl_Position; };\n"
        "layout(location = 0) uniform float z;\n"
        "void main() { gl_Position = vec4(vec2(gl_VertexID % 2, gl_VertexID / 2) * 4.0 - 1.0, z, "
        "1.0); }\n";
    static int32_t table[2][LIGHTS * SIDE * SIDE * 4];
    const mssm_gl_desc d = description(LIGHTS, SIDE, 1, 6);
    const mssm_light light = wide_light(false, 1);
    mssm_gl *g = NULL;
    GLuint pipeline;
    if (!begin_gl()) return;
    CHECK(!mssm_gl_create(&g, &d), "%s", fakes.message);
    const GLuint program = gl.CreateShaderProgramv(GL_VERTEX_SHADER, 1, &text);
    gl.CreateProgramPipelines(1, &pipeline);
    gl.UseProgramStages(pipeline, 1, program); // GL_VERTEX_SHADER_BIT
    for (int framed = 0; framed < 2 && g; framed++) {
        if (framed) CHECK(!mssm_gl_begin_frame(g), "begin of a frame");
        for (int i = 0; i < LIGHTS; i++) {
            CHECK(!mssm_gl_set_light(g, i, &light) && !mssm_gl_begin_depth(g, i, 0), "begin");
            gl.BindProgramPipeline(pipeline);
            gl.BindVertexArray(stage.array);
            gl.ProgramUniform1f(program, 0, (float)i / LIGHTS);
            gl.DrawArrays(GL_TRIANGLES, 0, 3);
            CHECK(!mssm_gl_end_depth(g), "end");
        }
        CHECK(!mssm_gl_build(g), "build");
        if (framed) CHECK(!mssm_gl_end_frame(g), "end of a frame");
        gl.MemoryBarrier(0x100); // GL_TEXTURE_UPDATE_BARRIER_BIT
        gl.GetTextureImage(mssm_gl_texture(g, 0), 0, 0x8D99, 0x1404, sizeof table[0],
                           table[framed]); // GL_RGBA_INTEGER, GL_INT
    }
    CHECK(table[0][0] != table[0][(LIGHTS - 1) * SIDE * SIDE * 4], "nothing was drawn");
    CHECK(!memcmp(table[0], table[1], sizeof table[0]), "a pipeline draws otherwise in a frame");
    gl.BindProgramPipeline(0);
    gl.BindVertexArray(0);
    gl.DeleteProgramPipelines(1, &pipeline);
    gl.DeleteProgram(program);
    mssm_gl_destroy(g);
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

const test_case gl_state_tests[] = {
    {"the snapshot of GL state sees all of it", the_snapshot_sees_all},
    {"GL state is left alone by every call", state_is_left_alone},
    {"GL state is left alone where it is unusual, and the numbers are right",
     unusual_state_is_left_alone},
    {"GL numbers are right with each switch of the state turned", each_state_alone_is_harmless},
    {"GL's depth bounds are off in a pass", depth_bounds_are_off_in_the_pass},
    {"GL's transform feedback is refused while it is active", transform_feedback_is_refused},
    {"GL's names that died raise no error", names_that_died_raise_no_error},
    {"GL's caller may link his program again in vain", programs_linked_in_vain_raise_no_error},
    {"GL's polygon offsets move nothing in a pass", polygon_offsets_move_nothing},
    {"GL's front faces are the caller's", winding_is_the_callers},
    {"GL state that the caller changes between begin and end is his", changes_in_between},
    {"GL state is saved once a frame in brackets", frames_are_the_passes},
    {"GL's frames are for pipelines too", frames_are_for_pipelines_too},
    {"GL errors of the caller are not ours", callers_error_is_not_ours},
    {0, 0}};
