// A light probe and a scene in, a picture with soft shadows out:
//     cc -O2 -I. examples/demo.c examples/common/*.c -lm -lpthread && ./a.out --out demo.png
// What the two headers are used for happens in common/lighting.c; this file says in which order, and
// reports times and errors.
#include "common/lighting.h"
#include "common/options.h"
#include "common/threads.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAP_SIDE 256
#define MAP_SAMPLES 4
#define TRUTH_RAYS 256

typedef struct demo {
    options o;
    probe source, turned;
    mesh centre;
    lighting light;
    image picture, truth, second;  // the truth is traced twice, which tells how noisy it is
} demo;

static bool demo_open(demo *d, message *why)
{
    const options *o = &d->o;
    const double start = seconds_now();
    const bool loaded = o->probe ? probe_load(&d->source, o->probe, 0, why)
                                 : probe_default(&d->source, PROBE_DEFAULT_SIDE);
    if (!loaded) return o->probe ? false : fail(why, "no memory for the probe");
    if (o->mesh && !mesh_load_obj(&d->centre, o->mesh, why)) return false;
    const lighting_settings settings = {
        .probe = {.max_lights = o->lights, .tolerance = o->tolerance},
        .shadows = {.moments = o->moments, .estimator = (mssm_estimator)o->estimator},
        .map_side = MAP_SIDE,
        .map_samples = MAP_SAMPLES,
    };
    if (!lighting_create(&d->light, &settings, d->source.side, why)) return false;
    if (!probe_create(&d->turned, d->source.side) ||
        !image_create(&d->picture, o->width, o->height) ||
        !image_create(&d->truth, o->width, o->height) ||
        !image_create(&d->second, o->width, o->height)) {
        return fail(why, "no memory for a picture of %d x %d", o->width, o->height);
    }
    printf("probe      %s, 6 x %d^2 texels, %.2f s\n", o->probe ? o->probe : "built in",
           d->source.side, seconds_now() - start);
    if (d->source.broken) printf("           %d broken pixels taken as black\n", d->source.broken);
    return true;
}

static void demo_close(demo *d)
{
    probe_free(&d->source);
    probe_free(&d->turned);
    mesh_free(&d->centre);
    lighting_free(&d->light);
    image_free(&d->picture);
    image_free(&d->truth);
    image_free(&d->second);
}

static void report_lights(const lighting *l)
{
    const lightprobe_stats *s = &l->stats;
    const float total = vec_luminance(vec_of(s->total)), rest = vec_luminance(vec_of(s->residual));
    printf("lights     %d of at most %d, %.1f ms: estimated error %.2f%%%s; they carry %.2f%% of the "
           "light\n",
           l->lights, l->settings.probe.max_lights, 1e3 * l->extract_seconds,
           100 * (double)s->error,
           l->lights < l->settings.probe.max_lights ? ", more would not lower it noticeably" : "",
           total > 0 ? 100 * (1 - (double)(rest / total)) : 100.0);
    if (s->repaired_texels) printf("           %d broken texels taken as black\n", s->repaired_texels);
}

// The root of the mean square difference over the pixels of the scene, in shares of the mean of b.
static double difference(const image *a, const image *b, const view *v)
{
    double squares = 0, sum = 0, values = 0;
    for (size_t i = 0; i < (size_t)v->width * (size_t)v->height; i++) {
        if (v->triangle[i * VIEW_SAMPLES] < 0) continue;
        for (size_t k = 3 * i; k < 3 * i + 3; k++, values++) {
            const double d = (double)a->rgb[k] - (double)b->rgb[k];
            squares += d * d;
            sum += (double)b->rgb[k];
        }
    }
    return sum > 0 ? sqrt(squares * values) / sum : 0;
}

// "build/demo.png" with "-012" or "-truth" before its ending.
static void file_name(char *name, size_t room, const char *out, const char *insert)
{
    const char *dot = strrchr(out, '.');
    const int stem = dot && !strchr(dot, '/') ? (int)(dot - out) : (int)strlen(out);
    snprintf(name, room, "%.*s%s%s", stem, out, insert, out + stem);
}

static bool compare_with_truth(demo *d, const view *v, const scene *s, const char *out, message *why)
{
    char name[1024];
    const double start = seconds_now();
    const bool lights = d->o.truth == TRUTH_LIGHTS;
    probe_sampler sampler;
    bvh *tree = bvh_create(s);
    if (!probe_sampler_create(&sampler, &d->turned) || !tree) return fail(why, "no memory for rays");
    light_source rays = {&d->light, tree, lights ? NULL : &sampler, lights ? 5 : TRUTH_RAYS / 2, 1};
    lighting_render(v, s, &d->turned, &rays, &d->truth);
    rays.seed = 2;
    lighting_render(v, s, &d->turned, &rays, &d->second);
    bvh_free(tree);
    probe_sampler_free(&sampler);
    const double noise = difference(&d->truth, &d->second, v) / 2;
    for (size_t i = 0; i < 3 * (size_t)v->width * (size_t)v->height; i++) {
        d->truth.rgb[i] = 0.5f * (d->truth.rgb[i] + d->second.rgb[i]);
    }
    const double error = difference(&d->picture, &d->truth, v);
    file_name(name, sizeof name, out, "-truth");
    printf("truth      %.2f s, %s: rms difference %.2f%% of the mean, of which its own noise %.2f%%; "
           "%s\n",
           seconds_now() - start, lights ? "rays to the lights" : "rays to the probe", 100 * error,
           100 * noise, name);
    return image_save_png(&d->truth, image_exposure(&d->picture), name, why);
}

static bool demo_frame(demo *d, float turn, const char *out, message *why)
{
    const options *o = &d->o;
    const double start = seconds_now();
    const float aspect = (float)o->width / (float)o->height;
    const camera eye = camera_look(vec(0.25f, 2.45f, 7.7f), vec(-0.05f, 0.75f, 0), 0.58f, aspect);
    scene s;
    view v;
    if (!probe_rotate(&d->turned, &d->source, 2 * VEC_PI * turn)) return fail(why, "no memory");
    if (!lighting_extract(&d->light, &d->turned, why)) return false;
    report_lights(&d->light);
    if (!scene_create(&s, 8 * turn, d->o.mesh ? &d->centre : NULL)) return fail(why, "no memory");
    bool done = lighting_draw_maps(&d->light, &s, why);
    const double before_view = seconds_now();
    done = done && (view_create(&v, &s, &eye, o->width, o->height) || fail(why, "no memory"));
    if (done) {
        const double before_shading = seconds_now();
        const light_source maps = {&d->light, NULL, NULL, 0, 0};
        lighting_render(&v, &s, &d->turned, &maps, &d->picture);
        const double end = seconds_now();
        printf("scene      %d triangles\n", s.triangles);
        printf("maps       %d x %d^2, %d samples a texel, %s moments: depth %.2f s, moments %.2f s\n",
               d->light.lights, MAP_SIDE, MAP_SAMPLES,
               o->moments == 4 ? "4" : o->moments == 6 ? "6" : "4 or 6 as needed of 6",
               d->light.depth_seconds, d->light.map_seconds);
        done = image_save_png(&d->picture, image_exposure(&d->picture), out, why);
        printf("picture    %d x %d: view %.2f s, shading %.2f s, all %.2f s; %s\n", o->width, o->height,
               before_shading - before_view, end - before_shading, seconds_now() - start, out);
        done = done && (o->truth == TRUTH_NONE || compare_with_truth(d, &v, &s, out, why));
        view_free(&v);
    }
    scene_free(&s);
    return done;
}

static bool demo_run(demo *d, message *why)
{
    char name[1024], number[16];
    if (!demo_open(d, why)) return false;
    if (d->o.orbit == 0) return demo_frame(d, 0, d->o.out, why);
    for (int i = 0; i < d->o.orbit; i++) {
        snprintf(number, sizeof number, "-%04d", i);
        file_name(name, sizeof name, d->o.out, number);
        printf("frame %d of %d\n", i + 1, d->o.orbit);
        if (!demo_frame(d, (float)i / (float)d->o.orbit, name, why)) return false;
    }
    return true;
}

int main(int argc, char **argv)
{
    static demo d;
    message why;
    bool done = options_parse(&d.o, argc, argv, &why);
    if (d.o.help) fputs(options_help, stdout);
    else if (done) done = demo_run(&d, &why);
    if (!done) fprintf(stderr, "demo: %s\n", why.text);
    demo_close(&d);
    return done ? 0 : 1;
}
