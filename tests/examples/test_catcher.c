// gl_catcher's picture against rays, and where nothing is in between.
#define main gl_catcher_main
#include "../../examples/gl_catcher.c"
#undef main
#include "../support/gl_test.h"
#include "../support/test.h"

#include <stdlib.h>
#include <string.h>

enum { GL_WIDTH = 160, GL_HEIGHT = 90 };
static const char no_ratio[] =
    "vec3 shadow_ratio(vec3 position, vec3 normal) { return vec3(1); }\n";

static GLuint programs[2]; // with the ratio and without

static bool begin(gl_context *context, int side)
{
    message why = {"no memory"};
    probe p;
    if (!gl_test_begin(context)) return false;
    if (!probe_default(&p, side)) abort();
    bool good = create(&p, GL_WIDTH, GL_HEIGHT, &why);
    programs[1] = program;
    good = good && (programs[0] = program_with(no_ratio, &why));
    CHECK(good, "%s", why.text);
    probe_free(&p);
    return good;
}

static void end(gl_context *context)
{
    program = programs[0];
    destroy();
    gl.DeleteProgram(programs[1]);
    cube = irradiance = 0;
    gl_context_destroy(context);
}

// The example's picture of a probe, over a photograph or, without one, over white.
static image picture_of(const probe *p, bool shadowed, bool occluded, const image *photo)
{
    const camera eye = photograph_camera(16.0f / 9);
    const int count = casters.count;
    image white, out = {0};
    message why;
    if (!image_create(&white, 1, 1)) abort();
    white.rgb[0] = white.rgb[1] = white.rgb[2] = 1;
    gl_probe_upload(&cube, p->face, p->side);
    lightprobe_gl_restart(lights.probe);
    program = programs[shadowed];
    if (!occluded) casters.count = 0;
    bool drawn = !shadowed || draw_shadows(&why);
    casters.count = count;
    drawn = drawn && draw(&eye, photo ? photo : &white, &out, &why);
    CHECK(drawn, "%s", why.text);
    image_free(&white);
    return out;
}

static bool same_pictures(const image *a, const image *b)
{
    return a->rgb && b->rgb && !memcmp(a->rgb, b->rgb, 3 * sizeof(float) * GL_WIDTH * GL_HEIGHT);
}

static void nothing_in_between_changes_nothing(void)
{
    enum { N = 32 };
    gl_context context;
    probe p, dark, below;
    if (!begin(&context, N)) return;
    if (!probe_default(&p, N) || !probe_create(&dark, N) || !probe_create(&below, N)) abort();
    for (int i = 0; i < 3 * N * N; i++) below.texels[3 * 3 * N * N + i] = 1; // all of -y
    image with = picture_of(&p, true, false, NULL), without = picture_of(&p, false, false, NULL);
    image night = picture_of(&dark, true, true, NULL), unlit = picture_of(&dark, false, true, NULL);
    image up = picture_of(&below, true, true, NULL);
    CHECK(same_pictures(&with, &without), "a ratio without casters");
    CHECK(same_pictures(&night, &unlit), "a ratio without light");
    for (int i = 3 * GL_WIDTH * (GL_HEIGHT - 1); i < 3 * GL_WIDTH * GL_HEIGHT && up.rgb;
         i++) // the row in front: ground
        CHECK(up.rgb[i] >= 1 && up.rgb[i] <= 1, "the ground catches %g from below",
              (double)up.rgb[i]);
    image_free(&with), image_free(&without), image_free(&night), image_free(&unlit),
        image_free(&up);
    probe_free(&p), probe_free(&dark), probe_free(&below);
    end(&context);
}

static void catcher_darkens_at_most(void)
{
    gl_context context;
    probe p;
    int dark = 0;
    if (!begin(&context, 64)) return;
    if (!probe_default(&p, 64)) abort();
    for (int i = 0; i < 18 * 64 * 64; i++) p.texels[i] *= 0x1p-30f; // the ratio is what it was
    gl.DeleteTextures(1, &irradiance);                              // objects are black
    irradiance = 0;
    image out = picture_of(&p, true, true, NULL);
    for (int i = 0; i < 3 * GL_WIDTH * GL_HEIGHT && out.rgb; i++) {
        CHECK(out.rgb[i] >= 0 && out.rgb[i] <= 1, "%g", (double)out.rgb[i]);
        dark += out.rgb[i] > 0.01f && out.rgb[i] < 0.9f;
    }
    test_note("%.1f%% of the values in shadow", 100.0 * dark / (3 * GL_WIDTH * GL_HEIGHT));
    CHECK(dark > GL_WIDTH * GL_HEIGHT / 10, "no shadow: %d", dark);
    image_free(&out);
    probe_free(&p);
    end(&context);
}

static void catcher_is_near_to_rays(void)
{
    const camera eye = photograph_camera(16.0f / 9);
    gl_context context;
    probe p;
    image photo, truth;
    double mean = 0;
    const int rays = test_trials(1000) < 300 ? 300 : test_trials(1000); // less would be their noise
    if (!begin(&context, 64)) return;
    if (!probe_default(&p, 64) || !photograph_take(&p, &eye, GL_WIDTH, GL_HEIGHT, &photo) ||
        !photograph_truth(&p, &eye, &photo, rays, &truth)) {
        abort();
    }
    image with = picture_of(&p, true, true, &photo), without = picture_of(&p, false, true, &photo);
    for (int i = 0; i < 3 * GL_WIDTH * GL_HEIGHT; i++)
        mean += (double)truth.rgb[i] / (3 * GL_WIDTH * GL_HEIGHT);
    if (with.rgb && without.rgb) {
        const double error = (double)image_rms(&with, &truth) / mean,
                     unshadowed = (double)image_rms(&without, &truth) / mean;
        test_note("rms error %.4f of the mean, %.4f without shadows", error, unshadowed);
        CHECK(error < 0.065 && error < 0.25 * unshadowed, "%.4f, %.4f without shadows", error,
              unshadowed);
    }
    image_free(&with), image_free(&without), image_free(&photo), image_free(&truth);
    probe_free(&p);
    end(&context);
}

const test_case catcher_tests[] = {
    {"gl_catcher changes nothing where nothing is in between", nothing_in_between_changes_nothing},
    {"gl_catcher's shadow ratio is in [0,1]", catcher_darkens_at_most},
    {"gl_catcher's picture is near to rays", catcher_is_near_to_rays},
    {NULL, NULL},
};
