// The demo's picture, by its two ways.
#include "../../examples/common/gl_lighting.h"
#include "../support/gl_test.h"
#include "../support/test.h"

#include <math.h>
#include <stdlib.h>

typedef struct stage {
    lighting light;
    probe source;
    scene casters;
    camera eye;
    image cpu, gl;
} stage;

static bool stage_create(stage *s, int width, int height, message *why)
{
    const lighting_settings settings = {
        .probe = {.max_lights = 8}, .map_side = 128, .map_samples = 4};
    s->eye = camera_look(vec(0.3f, 2.25f, 7.7f), vec(-0.05f, 0.86f, 0), 0.57f,
                         (float)width / (float)height);
    return probe_default(&s->source, 64) && lighting_create(&s->light, &settings, 64, why) &&
           lighting_extract(&s->light, &s->source, why) && scene_create(&s->casters, 1, NULL) &&
           image_create(&s->cpu, width, height);
}

static void stage_free(stage *s)
{
    probe_free(&s->source);
    lighting_free(&s->light);
    scene_free(&s->casters);
    image_free(&s->cpu);
    image_free(&s->gl);
}

static bool render_cpu(stage *s, message *why)
{
    const light_source maps = {&s->light, NULL, NULL, 0, 0};
    view v;
    if (!lighting_draw_maps(&s->light, &s->casters, why)) return false;
    if (!view_create(&v, &s->casters, &s->eye, s->cpu.width, s->cpu.height)) return false;
    lighting_render(&v, &s->casters, &s->source, &maps, &s->cpu);
    view_free(&v);
    return true;
}

static bool render_gl(stage *s, message *why)
{
    gl_lighting g;
    if (!gl_lighting_create(&g, &s->light, gl_context_function, s->cpu.width, s->cpu.height, why)) {
        return false;
    }
    gl_probe_upload(&g.probe, s->source.face, s->source.side);
    bool done = gl_lighting_draw_maps(&g, &s->light, &s->casters, why);
    if (done) {
        gl_lighting_draw_view(&g, &s->casters, &s->eye);
        gl_target_begin(&g.picture);
        gl_lighting_shade(&g, 0, &s->light, &s->eye);
        done = gl_target_read(&g.picture, &s->gl, why);
    }
    gl_lighting_free(&g);
    return done;
}

// In steps of the 8 bits that a picture file holds, and how much the CPU's picture varies itself.
static double difference(const stage *s, double *contrast)
{
    const size_t count = (size_t)s->cpu.width * (size_t)s->cpu.height * 3;
    unsigned char *a = malloc(count), *b = malloc(count);
    double squares = 0, sum = 0, sum2 = 0;
    if (!a || !b) abort();
    image_tonemap(&s->cpu, image_exposure(&s->cpu), a);
    image_tonemap(&s->gl, image_exposure(&s->cpu), b);
    for (size_t i = 0; i < count; i++) {
        squares += pow(a[i] - b[i], 2);
        sum += a[i];
        sum2 += pow(a[i], 2);
    }
    free(a);
    free(b);
    const double n = (double)count;
    *contrast = sqrt(sum2 / n - pow(sum / n, 2));
    return sqrt(squares / n);
}

static void pictures_agree(void)
{
    gl_context context;
    if (!gl_test_begin(&context)) return;
    stage s = {.light = {.lights = 0}};
    message why = {{0}};
    const int width =
        test_trials(640) < 192 ? 192 : test_trials(640); // edges count for more in less
    const bool done = stage_create(&s, width, width * 9 / 16, &why) && render_cpu(&s, &why) &&
                      render_gl(&s, &why);
    CHECK(done, "%s", why.text);
    if (done) {
        double contrast;
        const double rms = difference(&s, &contrast);
        test_note("%d x %d, %d lights: rms %.3f of 255; contrast of the picture %.1f", s.cpu.width,
                  s.cpu.height, s.light.lights, rms, contrast);
        CHECK(s.light.lights >= 4 && contrast > 20, "not much of a picture");
        CHECK(rms < 1, "rms %.3f of 255", rms);
    }
    stage_free(&s);
    gl_context_destroy(&context);
}

const test_case demo_tests[] = {
    {"GL and the CPU draw the same demo picture", pictures_agree},
    {0, 0},
};
