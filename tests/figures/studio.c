#include "studio.h"

#include "../../examples/common/report.h"
#include "../../examples/common/threads.h"

#include <stdlib.h>
#include <string.h>

enum { MAP_SIDE = 256, MAP_SAMPLES = 4 };

static bool trace_truth(studio *s, int rays_a_pixel, message *why)
{
    image second = {0, 0, NULL};
    light_source rays = {NULL, s->tree, &s->sampler, rays_a_pixel / 2, 1};
    if (!image_create(&s->truth, s->view.width, s->view.height) ||
        !image_create(&second, s->view.width, s->view.height)) {
        return fail(why, "no memory");
    }
    lighting_render(&s->view, &s->scene, &s->probe, &rays, &s->truth);
    rays.seed = 2;
    lighting_render(&s->view, &s->scene, &s->probe, &rays, &second);
    const double noise = studio_error(s, &second, &s->truth) / 2,
                 edge_noise = studio_edges(s, &second, &s->truth) / 2;
    s->noise = noise; // of the mean; only now, since both take it off
    s->edge_noise = edge_noise;
    image_average(&s->truth, &second);
    image_free(&second);
    s->exposure = lighting_exposure(&s->truth, &s->scene, &s->eye);
    return true;
}

static void collect(studio *s)
{
    const int width = s->view.width;
    for (int i = 0; i < width * s->view.height; i++) {
        surface found[VIEW_SAMPLES];
        s->count[i] = view_surfaces(&s->view, &s->scene, i % width, i / width, found);
        for (int k = 0; k < s->count[i]; k++) {
            s->pieces[i][k] = (piece){found[k].position, found[k].normal,
                                      s->scene.albedo[found[k].object], found[k].share};
        }
    }
}

bool studio_open(studio *s, const shot *of, int width, int rays, message *why)
{
    const int height = width * 9 / 16;
    const size_t pixels = (size_t)width * (size_t)height;
    probe still;
    memset(s, 0, sizeof *s);
    s->eye = camera_look(of->from, of->to, of->vertical_angle, (float)width / (float)height);
    s->pieces = malloc(sizeof *s->pieces * pixels);
    s->count = malloc(sizeof *s->count * pixels);
    if (!s->pieces || !s->count || !scene_create(&s->scene, of->time, NULL) ||
        !probe_default(&still, PROBE_DEFAULT_SIDE) ||
        !probe_create(&s->probe, PROBE_DEFAULT_SIDE) ||
        !probe_rotate(&s->probe, &still, of->turn) || !(s->tree = bvh_create(&s->scene)) ||
        !probe_sampler_create(&s->sampler, &s->probe) ||
        !view_create(&s->view, &s->scene, &s->eye, width, height)) {
        return fail(why, "no memory for the scene");
    }
    probe_free(&still);
    collect(s);
    return trace_truth(s, rays, why);
}

void studio_close(studio *s)
{
    image_free(&s->truth);
    view_free(&s->view);
    probe_sampler_free(&s->sampler);
    bvh_free(s->tree);
    scene_free(&s->scene);
    probe_free(&s->probe);
    free(s->pieces);
    free(s->count);
}

bool studio_extract(const studio *s, studio_lights *lights, int count, bool paper, message *why)
{
    const lighting_settings settings = {
        .probe = {.max_lights = count, .mode = paper ? LIGHTPROBE_MEDIAN_CUT : LIGHTPROBE_BEST},
        .map_side = MAP_SIDE,
        .map_samples = 1};
    lights->paper = paper;
    return lighting_create(&lights->l, &settings, s->probe.side, why) &&
           lighting_extract(&lights->l, &s->probe, why);
}

// ---- Shading ------------------------------------------------------------------------------------

typedef struct shading {
    const studio *s;
    const studio_lights *lights;
    const shadowing *how;
    const lightprobe_light *light; // the one that is added
    void *state, *memory, *depth;  // rivals read the depth map itself
    mssm_map *map;                 // of the library
    mssm_light frustum;
    image *out;
} shading;

static float visibility_of(const shading *h, const piece *at, unsigned seed)
{
    const lightprobe_light *l = h->light;
    const float point[3] = {at->position.x, at->position.y, at->position.z};
    const float normal[3] = {at->normal.x, at->normal.y, at->normal.z};
    if (h->how->method) {
        const method *m = h->how->method;
        const float bias = h->how->bias * (h->how->tuning ? 2.0f : 1.0f);
        float seen;
        if (!m->many) return m->visibility(h->state, point, bias, seed);
        m->many(h->state, 1, &point, &normal, bias, &seen);
        return seen;
    }
    if (h->how->own)
        return mssm_map_visibility_normal(h->map, &h->frustum, h->how->own, point,
                                          h->how->own->estimator == MSSM_HORIZON ? normal : NULL);
    const vec3 above = vec_mad(at->position, at->normal, 2e-3f), towards = vec_of(l->direction);
    if (h->how->grid == 0) return bvh_hit_any(h->s->tree, above, towards, 100) ? 0.0f : 1.0f;
    return trace_rectangle(h->s->tree, above, &at->normal, towards, vec_of(l->axis_u),
                           vec_of(l->axis_v), l->tan_half_u, l->tan_half_v, h->how->grid, seed);
}

// What a surface gets of a light when nothing is in between.
static float share_of(const shading *h, vec3 normal)
{
    const lightprobe_light *l = h->light;
    const float cosine = vec_dot(normal, vec_of(l->direction));
    const bool point = !h->how->method && !h->how->own && h->how->grid == 0;
    const float cos_alpha = point ? 1 : l->cos_alpha;
    if (!h->lights->paper) return lightprobe_disc_irradiance(cos_alpha, cosine);
    return cosine > 0 ? 0.5f * (1 + cos_alpha) * cosine : 0; // Eq. 18
}

static void add_row(void *context, int y)
{
    const shading *h = context;
    const float little = 2e-5f * vec_luminance(vec_of(h->lights->l.stats.total));
    const vec3 flux = vec_of(h->light->irradiance);
    const int width = h->s->view.width;
    for (int i = y * width; i < (y + 1) * width; i++) {
        vec3 sum = vec_of(h->out->rgb + 3 * i);
        for (int k = 0; k < h->s->count[i]; k++) {
            const piece *at = &h->s->pieces[i][k];
            const float share = share_of(h, at->normal);
            if (share * vec_luminance(flux) < little) continue;
            const unsigned seed = (unsigned)i * 64u + (unsigned)(h->light - h->lights->l.light);
            const float seen = share * visibility_of(h, at, seed);
            sum = vec_mad(sum, vec_mul(at->albedo, flux), seen * at->share / VEC_PI);
        }
        image_set(h->out, i % width, y, sum);
    }
}

// What no light carries, and the probe behind the scene.
static void start_row(void *context, int y)
{
    const shading *h = context;
    const int width = h->s->view.width, height = h->s->view.height;
    for (int i = y * width; i < (y + 1) * width; i++) {
        vec3 sum = vec(0, 0, 0);
        float rest = 1;
        for (int k = 0; k < h->s->count[i]; k++) {
            const piece *at = &h->s->pieces[i][k];
            const float n[3] = {at->normal.x, at->normal.y, at->normal.z};
            float rgb[3] = {0, 0, 0};
            if (!h->lights->paper) lightprobe_residual_irradiance(&h->lights->l.stats, n, rgb);
            sum = vec_mad(sum, vec_mul(at->albedo, vec_of(rgb)), at->share / VEC_PI);
            rest -= at->share;
        }
        const vec3 ray = camera_ray(&h->s->eye, ((float)(i % width) + 0.5f) / (float)width,
                                    ((float)y + 0.5f) / (float)height);
        if (rest > 0) sum = vec_mad(sum, probe_sample(&h->s->probe, ray), rest);
        image_set(h->out, i % width, y, sum);
    }
}

static void close_map(shading *h)
{
    if (h->state) h->how->method->destroy(h->state);
    free(h->memory);
    free(h->depth);
    h->state = h->memory = h->depth = NULL;
}

// Depth map of h->light, as large as the library's examples take it, and the method's map of that.
static bool open_map(shading *h, int side, message *why)
{
    const scene *s = &h->s->scene;
    const lightprobe_light *l = h->light;
    const int samples = h->how->own ? MAP_SAMPLES : 1;
    const size_t texels = (size_t)samples * (size_t)side * (size_t)side;
    const float low[3] = {s->low.x, s->low.y, s->low.z},
                high[3] = {s->high.x, s->high.y, s->high.z};
    const int moments = h->how->own && h->how->own->moments == 4 ? 4 : 6;
    const raster_frustum frustum = {h->frustum.world_to_shadow, false, 0, 0};
    size_t bytes = mssm_map_bytes(side, moments);
    float *front = malloc(2 * texels * sizeof *front),
          *back = h->how->back_faces ? front + texels : NULL;
    const depth_map map = {&h->frustum, side, front, back};
    h->memory = malloc(bytes);
    h->depth = front;
    bool done = front && h->memory &&
                mssm_light_directional(&h->frustum, l->direction, l->axis_u, l->tan_half_u,
                                       l->tan_half_v, low, high) == MSSM_OK &&
                raster_depth(s, &frustum, RASTER_FRONT, side, samples, front) &&
                (!back || raster_depth(s, &frustum, RASTER_BACK, side, samples, back));
    if (done && h->how->own) {
        done = mssm_map_init(&h->map, h->memory, bytes, side, moments) == MSSM_OK &&
               mssm_map_update(h->map, front, back, samples) == MSSM_OK;
    } else if (done) {
        h->state = h->how->method->create(h->how->method, side, &bytes);
        done = h->state;
        if (done && h->how->tuning) convolution_tune(h->state, h->how->tuning);
        if (done) h->how->method->update(h->state, &map);
    }
    return done || fail(why, "no memory for a map");
}

bool studio_shade(const studio *s, const studio_lights *lights, const shadowing *how, image *out,
                  message *why)
{
    shading h = {.s = s, .lights = lights, .how = how, .out = out};
    bool done = image_create(out, s->view.width, s->view.height) || fail(why, "no memory");
    if (done) parallel_for(s->view.height, start_row, &h, NULL);
    for (int i = 0; i < lights->l.lights && done; i++) {
        h.light = &lights->l.light[i];
        if (how->method || how->own)
            done = open_map(&h, lighting_map_side(&lights->l, i) * (how->tuning ? 2 : 1), why);
        if (done) parallel_for(s->view.height, add_row, &h, NULL);
        close_map(&h);
    }
    return done;
}

// ---- Comparing ----------------------------------------------------------------------------------

static double beyond(double error, double noise)
{
    return sqrt(fmax(error * error - noise * noise, 0));
}

double studio_error(const studio *s, const image *a, const image *truth)
{
    const double error = 100 * report_difference(a, truth, &s->view);
    return beyond(error, truth == &s->truth ? s->noise : 0);
}

double studio_edges(const studio *s, const image *a, const image *truth)
{
    const int width = s->view.width;
    double squares = 0, sum = 0, steps = 0;
    for (int i = 0; i < width * (s->view.height - 1) - 1; i++) {
        if (!s->count[i] || !s->count[i + 1] || !s->count[i + width]) continue;
        for (int k = 0; k < 6; k++) {
            const int from = 3 * i + k % 3, to = k < 3 ? from + 3 : from + 3 * width;
            const double step = fabs((double)a->rgb[to] - (double)a->rgb[from]);
            const double right = fabs((double)truth->rgb[to] - (double)truth->rgb[from]);
            const double excess = step > right ? step - right : 0;
            squares += excess * excess;
            sum += (double)truth->rgb[from];
            steps++;
        }
    }
    return beyond(100 * sqrt(squares * steps) / sum, truth == &s->truth ? s->edge_noise : 0);
}

double studio_brightness(const studio *s, const image *a, const image *truth)
{
    double one = 0, other = 0;
    for (int i = 0; i < s->view.width * s->view.height; i++) {
        if (s->view.triangle[i * VIEW_SAMPLES] < 0) continue;
        one += (double)vec_luminance(vec_of(a->rgb + 3 * i));
        other += (double)vec_luminance(vec_of(truth->rgb + 3 * i));
    }
    return one / other;
}

double studio_leak(const studio *s, const image *a, const image *truth)
{
    double more = 0, sum = 0;
    for (int i = 0; i < s->view.width * s->view.height; i++) {
        if (s->view.triangle[i * VIEW_SAMPLES] < 0) continue;
        const double right = (double)vec_luminance(vec_of(truth->rgb + 3 * i));
        more += fmax((double)vec_luminance(vec_of(a->rgb + 3 * i)) - right, 0);
        sum += right;
    }
    return 100 * more / sum;
}
