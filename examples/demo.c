// Renders a scene lit by a light probe, with soft shadows:
//     cc -O2 -I. examples/demo.c examples/common/*.c -lm -lpthread && ./a.out --out demo.png
// common/lighting.c uses the two headers on the CPU, common/gl_lighting.c with OpenGL; this file
// calls them in order and measures times.
#include "common/gl_context.h"
#include "common/gl_lighting.h"
#include "common/lighting.h"
#include "common/options.h"
#include "common/report.h"
#include "common/threads.h"

#include <stdio.h>

#define MAP_SIDE 256
#define MAP_SAMPLES 4
#define TRUTH_RAYS 256

typedef struct demo {
    options o;
    probe source, turned;
    mesh centre;
    lighting light;
    bool gl; // whether the next two are in use
    gl_context context;
    gl_lighting gl_light;
    double view_seconds, shading_seconds;
    float exposure;               // of the first frame, kept for all
    image picture, truth, second; // the truth is traced twice, which tells how noisy it is
} demo;

// OpenGL where it can be had, the CPU where it cannot, unless the command line wants one of them.
static bool choose_pipeline(demo *d, message *why)
{
    const options *o = &d->o;
    const char *reason = "asked for";
    message error;
    d->gl = o->pipeline != PIPELINE_CPU && gl_context_create(&d->context, &reason);
    if (d->gl && !gl_lighting_create(&d->gl_light, &d->light, gl_context_function, o->width,
                                     o->height, &error)) {
        gl_context_destroy(&d->context);
        d->gl = false;
        reason = error.text;
    }
    if (!d->gl && o->pipeline == PIPELINE_GL) return fail(why, "no OpenGL: %.200s", reason);
    printf("pipeline   %s, %s\n", d->gl ? "OpenGL" : "CPU",
           d->gl ? (const char *)gl.GetString(GL_RENDERER) : reason);
    return true;
}

static bool demo_open(demo *d, message *why)
{
    const options *o = &d->o;
    const double start = seconds_now();
    const bool loaded = o->probe ? probe_load(&d->source, o->probe, 0, why)
                                 : probe_default(&d->source, PROBE_DEFAULT_SIDE);
    if (!loaded) return o->probe ? false : fail(why, "no memory for the probe");
    if (o->mesh && !mesh_load_obj(&d->centre, o->mesh, why)) return false;
    const lighting_settings settings = {
        .probe = {.max_lights = o->lights, .tolerance = o->tolerance, .min_shadow = o->min_shadow},
        .shadows = {.moments = o->moments, .estimator = (mssm_estimator)o->estimator},
        .map_side = MAP_SIDE,
        .map_samples = MAP_SAMPLES,
        .back_faces = o->back_faces,
    };
    if (!lighting_create(&d->light, &settings, d->source.side, why)) return false;
    if (!choose_pipeline(d, why)) return false;
    if (!probe_create(&d->turned, d->source.side) ||
        !image_create(&d->picture, o->width, o->height) ||
        !image_create(&d->truth, o->width, o->height) ||
        !image_create(&d->second, o->width, o->height)) {
        return fail(why, "no memory for a picture of %d x %d", o->width, o->height);
    }
    printf("probe      %s, 6 x %d^2 texels, %.2f s\n", o->probe ? o->probe : "built in",
           d->source.side, seconds_now() - start);
    if (d->source.broken)
        printf("           %d broken pixels: negative and NaN are black, infinite ones bright\n",
               d->source.broken);
    return true;
}

static void demo_close(demo *d)
{
    probe_free(&d->source);
    probe_free(&d->turned);
    mesh_free(&d->centre);
    gl_lighting_free(&d->gl_light);
    if (d->gl) gl_context_destroy(&d->context);
    lighting_free(&d->light);
    image_free(&d->picture);
    image_free(&d->truth);
    image_free(&d->second);
}

static bool render_with_cpu(demo *d, const scene *s, const camera *eye, message *why)
{
    const light_source maps = {&d->light, NULL, NULL, 0, 0};
    view v;
    if (!lighting_draw_maps(&d->light, s, why)) return false;
    const double start = seconds_now();
    if (!view_create(&v, s, eye, d->o.width, d->o.height)) return fail(why, "no memory");
    d->view_seconds = seconds_now() - start;
    lighting_render(&v, s, &d->turned, &maps, &d->picture);
    d->shading_seconds = seconds_now() - start - d->view_seconds;
    view_free(&v);
    return true;
}

static bool render_with_gl(demo *d, const scene *s, const camera *eye, message *why)
{
    gl_lighting *g = &d->gl_light;
    gl_probe_upload(&g->probe, d->turned.face, d->turned.side);
    if (!gl_lighting_draw_maps(g, &d->light, s, why)) return false;
    gl_lighting_draw_view(g, s, eye);
    gl_target_begin(&g->picture);
    gl_lighting_shade(g, 0, &d->light, eye);
    image_free(&d->picture);
    if (!gl_target_read(&g->picture, &d->picture, why)) return false;
    d->light.depth_seconds = gl_lighting_seconds(g, GL_LIGHTING_DEPTH);
    d->light.map_seconds = gl_lighting_seconds(g, GL_LIGHTING_TABLES);
    d->view_seconds = gl_lighting_seconds(g, GL_LIGHTING_VIEW);
    d->shading_seconds = gl_lighting_seconds(g, GL_LIGHTING_SHADING);
    return true;
}

static bool compare_with_truth(demo *d, const camera *eye, const scene *s, const char *out,
                               message *why)
{
    char name[1024];
    const double start = seconds_now();
    const bool lights = d->o.truth == TRUTH_LIGHTS;
    probe_sampler sampler;
    view v;
    bvh *tree = bvh_create(s);
    if (!probe_sampler_create(&sampler, &d->turned) || !tree ||
        !view_create(&v, s, eye, d->o.width, d->o.height)) {
        return fail(why, "no memory for rays");
    }
    light_source rays = {&d->light, tree, lights ? NULL : &sampler, lights ? 5 : TRUTH_RAYS / 2, 1};
    lighting_render(&v, s, &d->turned, &rays, &d->truth);
    rays.seed = 2;
    lighting_render(&v, s, &d->turned, &rays, &d->second);
    bvh_free(tree);
    probe_sampler_free(&sampler);
    const double noise = report_difference(&d->truth, &d->second, &v) / 2;
    image_average(&d->truth, &d->second);
    const double error = report_difference(&d->picture, &d->truth, &v);
    view_free(&v);
    report_name(name, sizeof name, out, "-truth");
    printf(
        "truth      %.2f s, %s: rms difference %.2f%% of the mean, of which its own noise %.2f%%; "
        "%s\n",
        seconds_now() - start, lights ? "rays to the lights" : "rays to the probe", 100 * error,
        100 * noise, name);
    return image_save_png(&d->truth, d->exposure, name, why);
}

static bool demo_frame(demo *d, float turn, const char *out, message *why)
{
    const options *o = &d->o;
    const double start = seconds_now();
    const camera eye = camera_look(vec(0.3f, 2.25f, 7.7f), vec(-0.05f, 0.86f, 0), 0.57f,
                                   (float)o->width / (float)o->height);
    scene s;
    if (!probe_rotate(&d->turned, &d->source, 2 * VEC_PI * turn)) return fail(why, "no memory");
    if (!lighting_extract(&d->light, &d->turned, why)) return false;
    report_lights(&d->light);
    if (!scene_create(&s, 8 * turn, d->o.mesh ? &d->centre : NULL)) return fail(why, "no memory");
    bool done = (d->gl ? render_with_gl : render_with_cpu)(d, &s, &eye, why);
    if (done) {
        report_maps(&d->light, s.triangles);
        if (o->exposure > 0) d->exposure = o->exposure;
        if (!(d->exposure > 0)) d->exposure = lighting_exposure(&d->picture, &s, &eye);
        done = image_save_png(&d->picture, d->exposure, out, why);
    }
    if (done) {
        printf("picture    %d x %d: view %.2f s, shading %.2f s, all %.2f s; exposure %.4g; %s\n",
               o->width, o->height, d->view_seconds, d->shading_seconds, seconds_now() - start,
               (double)d->exposure, out);
        done = o->truth == TRUTH_NONE || compare_with_truth(d, &eye, &s, out, why);
    }
    scene_free(&s);
    return done;
}

static bool demo_run(demo *d, message *why)
{
    char name[1024];
    if (!demo_open(d, why)) return false;
    if (d->o.orbit == 0) return demo_frame(d, 0, d->o.out, why);
    for (int i = 0; i < d->o.orbit; i++) {
        report_frame_name(name, sizeof name, d->o.out, i);
        printf("frame %d of %d\n", i + 1, d->o.orbit);
        if (!demo_frame(d, (float)i / (float)d->o.orbit, name, why)) return false;
    }
    return true;
}

int main(int argc, char **argv)
{
    static demo d;
    message why = {{0}};
    bool done = options_parse(&d.o, argc, argv, &why);
    if (d.o.help)
        fputs(options_help, stdout);
    else if (done)
        done = demo_run(&d, &why);
    if (!done) fprintf(stderr, "demo: %s\n", why.text);
    demo_close(&d);
    return done ? 0 : 1;
}
