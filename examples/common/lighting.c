#include "lighting.h"

#include "threads.h"

#include <stdlib.h>
#include <string.h>

bool lighting_create(lighting *l, const lighting_settings *settings, int probe_side, message *why)
{
    const size_t most = (size_t)settings->probe.max_lights;
    memset(l, 0, sizeof *l);
    l->settings = *settings;
    l->scratch_bytes = lightprobe_scratch_bytes(probe_side, settings->probe.max_lights);
    l->light = malloc(most * sizeof *l->light);
    l->frustum = malloc(most * sizeof *l->frustum);
    l->map = malloc(most * sizeof(mssm_map *));
    l->map_memory = calloc(most, sizeof *l->map_memory);
    l->scratch = malloc(l->scratch_bytes);
    if (l->light && l->frustum && l->map && l->map_memory && l->scratch) return true;
    lighting_free(l);
    return fail(why, "no memory for %d lights", settings->probe.max_lights);
}

void lighting_free(lighting *l)
{
    const int most = l->map_memory ? l->settings.probe.max_lights : 0;
    for (int i = 0; i < most; i++) free(l->map_memory[i]);
    free(l->light);
    free(l->frustum);
    free(l->map);
    free(l->map_memory);
    free(l->scratch);
    memset(l, 0, sizeof *l);
}

bool lighting_extract(lighting *l, const probe *p, message *why)
{
    const double start = seconds_now();
    lightprobe_cube cube = {{NULL}, p->side, 3};
    lightprobe_settings settings = l->settings.probe;
    if (l->lights > 0) settings.previous = l->light;
    settings.previous_count = l->lights;
    for (int f = 0; f < 6; f++) cube.face[f] = p->face[f];
    const lightprobe_result result = lightprobe_extract(
        &cube, &settings, l->scratch, l->scratch_bytes, l->light, &l->lights, &l->stats);
    l->extract_seconds = seconds_now() - start;
    return result == LIGHTPROBE_OK || fail(why, "%s", lightprobe_result_string(result));
}

// ---- Maps

typedef struct drawing {
    lighting *l;
    const scene *s;
    double *seconds; // two per light: depth, map
    bool *failed;    // one per light, so that threads do not share
} drawing;

int lighting_map_side(const lighting *l, int i)
{
    const bool narrow = l->light[i].tan_half_v < LIGHTING_NARROW;
    return narrow ? 2 * l->settings.map_side : l->settings.map_side;
}

static bool open_map(lighting *l, const scene *s, int i, int side)
{
    const lightprobe_light *light = &l->light[i];
    const float low[3] = {s->low.x, s->low.y, s->low.z},
                high[3] = {s->high.x, s->high.y, s->high.z};
    const size_t bytes = mssm_map_bytes(side, 6);
    void *memory = realloc(l->map_memory[i], bytes);
    if (!memory) return false;
    l->map_memory[i] = memory;
    return mssm_light_directional(&l->frustum[i], light->direction, light->axis_u,
                                  light->tan_half_u, light->tan_half_v, low, high) == MSSM_OK &&
           mssm_map_init(&l->map[i], memory, bytes, side, 6) == MSSM_OK;
}

static bool draw_map(lighting *l, const scene *s, int i, double seconds[2])
{
    const int side = lighting_map_side(l, i), samples = l->settings.map_samples;
    const size_t count = (size_t)side * (size_t)side * (size_t)samples;
    const double start = seconds_now();
    if (!open_map(l, s, i, side)) return false;
    const raster_frustum frustum = {l->frustum[i].world_to_shadow, false, 0, 0};
    const bool both = l->settings.back_faces;
    float *front = malloc((both ? 2 : 1) * count * sizeof *front);
    float *back = front && both ? front + count : NULL;
    bool drawn = front && raster_depth(s, &frustum, RASTER_FRONT, side, samples, front) &&
                 (!back || raster_depth(s, &frustum, RASTER_BACK, side, samples, back));
    seconds[0] = seconds_now() - start;
    if (drawn) drawn = mssm_map_update(l->map[i], front, back, samples) == MSSM_OK;
    seconds[1] = seconds_now() - start - seconds[0];
    free(front);
    return drawn;
}

static void draw_one(void *context, int i)
{
    const drawing *d = context;
    d->failed[i] = !draw_map(d->l, d->s, i, d->seconds + 2 * i);
}

bool lighting_draw_maps(lighting *l, const scene *s, message *why)
{
    const size_t lights = (size_t)l->lights + 1; // none is allowed
    drawing d = {l, s, calloc(lights, 2 * sizeof *d.seconds), calloc(lights, sizeof *d.failed)};
    const double start = seconds_now();
    double depth = 0, maps = 0;
    bool drawn = d.seconds && d.failed;
    if (drawn) parallel_for(l->lights, draw_one, &d, "drawing shadow maps");
    for (int i = 0; i < l->lights && drawn; i++) {
        depth += d.seconds[2 * i];
        maps += d.seconds[2 * i + 1];
        drawn = !d.failed[i];
    }
    free(d.seconds);
    free(d.failed);
    // The threads' seconds overlap: share out what the clock on the wall says.
    const double wall = seconds_now() - start;
    l->depth_seconds = depth + maps > 0 ? wall * depth / (depth + maps) : wall;
    l->map_seconds = wall - l->depth_seconds;
    return drawn || fail(why, "no memory for shadow maps");
}

// ---- Shading

// The share of a light's irradiance that reaches an unshadowed surface.
static float share_of(const lightprobe_light *light, vec3 normal)
{
    return lightprobe_disc_irradiance(light->cos_alpha, vec_dot(normal, vec_of(light->direction)));
}

// What the lights do not carry.
static vec3 ambient(const lighting *l, vec3 normal)
{
    const float n[3] = {normal.x, normal.y, normal.z};
    float rgb[3];
    lightprobe_residual_irradiance(&l->stats, n, rgb);
    return vec_of(rgb);
}

vec3 lighting_at(const lighting *l, vec3 point, vec3 normal)
{
    const float at[3] = {point.x, point.y, point.z}, n[3] = {normal.x, normal.y, normal.z};
    const float little = 2e-5f * vec_luminance(vec_of(l->stats.total));
    vec3 sum = ambient(l, normal);
    for (int i = 0; i < l->lights; i++) {
        const float share = share_of(&l->light[i], normal);
        // Below the horizon, or not worth looking up what is in its way.
        if (share * vec_luminance(vec_of(l->light[i].irradiance)) < little) continue;
        const float seen =
            mssm_map_visibility_normal(l->map[i], &l->frustum[i], &l->settings.shadows, at, n);
        sum = vec_mad(sum, vec_of(l->light[i].irradiance), share * seen);
    }
    return sum;
}

static vec3 trace_lights(const light_source *source, vec3 point, vec3 normal, unsigned seed)
{
    const lighting *l = source->maps;
    vec3 sum = ambient(l, normal);
    for (int i = 0; i < l->lights; i++) {
        const lightprobe_light *light = &l->light[i];
        const float share = share_of(light, normal);
        if (share <= 0) continue;
        const float seen =
            trace_rectangle(source->tree, point, &normal, vec_of(light->direction),
                            vec_of(light->axis_u), vec_of(light->axis_v), light->tan_half_u,
                            light->tan_half_v, source->rays, seed * 64 + (unsigned)i);
        sum = vec_mad(sum, vec_of(light->irradiance), share * seen);
    }
    return sum;
}

static vec3 irradiance_of(const light_source *source, vec3 point, vec3 normal, unsigned seed)
{
    // Rays start a little above the surface, so that they do not hit it.
    const vec3 above = vec_mad(point, normal, 2e-3f);
    if (!source->tree) return lighting_at(source->maps, point, normal);
    if (!source->sampler) return trace_lights(source, above, normal, seed);
    return trace_irradiance(source->tree, source->sampler, above, normal, source->rays, seed);
}

typedef struct rendering {
    const view *v;
    const scene *s;
    const probe *p;
    const light_source *source;
    image *out;
} rendering;

static void render_row(void *context, int y)
{
    const rendering *r = context;
    for (int x = 0; x < r->v->width; x++) {
        surface piece[VIEW_SAMPLES];
        const int pieces = view_surfaces(r->v, r->s, x, y, piece);
        const unsigned seed = r->source->seed * 0x51ed27u + (unsigned)(y * r->v->width + x);
        vec3 sum = vec(0, 0, 0);
        float background = 1;
        for (int k = 0; k < pieces; k++) {
            const vec3 light = irradiance_of(r->source, piece[k].position, piece[k].normal, seed);
            const vec3 reflected = vec_mul(light, r->s->albedo[piece[k].object]);
            sum = vec_mad(sum, reflected, piece[k].share / VEC_PI);
            background -= piece[k].share;
        }
        if (background > 0) {
            const vec3 d = camera_ray(&r->v->eye, ((float)x + 0.5f) / (float)r->v->width,
                                      ((float)y + 0.5f) / (float)r->v->height);
            sum = vec_mad(sum, probe_sample(r->p, d), background);
        }
        image_set(r->out, x, y, sum);
    }
}

void lighting_render(const view *v, const scene *s, const probe *p, const light_source *source,
                     image *out)
{
    rendering r = {v, s, p, source, out};
    parallel_for(v->height, render_row, &r, source->tree ? "tracing the truth" : "shading");
}

float lighting_exposure(const image *picture, const scene *s, const camera *eye)
{
    enum { STEP = 4 }; // a median needs no more, and the view costs little
    const int width = (picture->width + STEP - 1) / STEP,
              height = (picture->height + STEP - 1) / STEP;
    image lit;
    view v;
    int count = 0;
    float exposure = image_exposure(picture);
    if (!image_create(&lit, width * height, 1)) return exposure;
    if (view_create(&v, s, eye, width, height)) {
        for (int i = 0; i < width * height; i++) {
            const int *triangle = v.triangle + (size_t)i * VIEW_SAMPLES;
            bool all = true;
            for (int k = 0; k < VIEW_SAMPLES; k++) all = all && triangle[k] >= 0;
            const int x = i % width * picture->width / width,
                      y = i / width * picture->height / height;
            if (all) image_set(&lit, count++, 0, image_get(picture, x, y));
        }
        view_free(&v);
    }
    lit.width = count;
    // What is lit is mostly the bright ground: brighter than a middle grey.
    if (count > 0) exposure = 2.7f * image_exposure(&lit);
    image_free(&lit);
    return exposure;
}
