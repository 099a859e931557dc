#include "photograph.h"

#include "lighting.h"
#include "threads.h"

#include <string.h>

// ---- Objects

static void put_chair(scene *s, vec3 at, float turn)
{
    // Centres and half-sizes: four legs, the seat, four slats and the rail of the back, a bar
    // between the legs.
    static const float part[11][6] = {
        {-.21f, .22f, -.2f, .02f, .22f, .02f}, {.21f, .22f, -.2f, .02f, .22f, .02f},
        {-.21f, .46f, .2f, .02f, .46f, .02f},  {.21f, .46f, .2f, .02f, .46f, .02f},
        {0, .45f, 0, .24f, .018f, .23f},       {-.13f, .67f, .2f, .02f, .2f, .01f},
        {-.043f, .67f, .2f, .02f, .2f, .01f},  {.043f, .67f, .2f, .02f, .2f, .01f},
        {.13f, .67f, .2f, .02f, .2f, .01f},    {0, .89f, .2f, .23f, .03f, .014f},
        {0, .2f, -.2f, .2f, .012f, .012f}};
    for (int i = 0; i < 11; i++) {
        const scene_frame f = scene_frame_at(vec_add(at, vec_turn(vec_of(part[i]), turn)), turn, 0);
        scene_put_box(s, &f, vec_of(part[i] + 3));
    }
}

static void put_objects(scene *s)
{
    const scene_frame large = scene_frame_at(vec(0.72f, 0.3f, 0.75f), 0, 0);
    const scene_frame small = scene_frame_at(vec(-0.4f, 0.14f, 1.0f), 0, 0);
    const scene_frame crate = scene_frame_at(vec(1.1f, 0.28f, -0.65f), 0.5f, 0);
    const scene_frame parcel = scene_frame_at(vec(1.1f, 0.68f, -0.65f), 0.1f, 0);
    scene_begin_object(s, 0.62f, 0.40f, 0.20f);
    put_chair(s, vec(-0.75f, 0, 0), 2.6f);
    scene_begin_object(s, 0.75f, 0.75f, 0.74f);
    scene_put_sphere(s, &large, 0.3f, 40);
    scene_begin_object(s, 0.70f, 0.09f, 0.06f);
    scene_put_sphere(s, &small, 0.14f, 32);
    scene_begin_object(s, 0.16f, 0.30f, 0.50f);
    scene_put_box(s, &crate, vec(0.28f, 0.28f, 0.28f));
    scene_begin_object(s, 0.70f, 0.55f, 0.25f);
    scene_put_box(s, &parcel, vec(0.17f, 0.12f, 0.2f));
}

enum { GROUND_HALF = 30 }; // metres

static void put_ground(scene *s)
{
    int corner[4];
    scene_begin_object(s, 1, 1, 1);
    for (int i = 0; i < 4; i++) { // counter-clockwise from above
        const float x = i == 1 || i == 2 ? GROUND_HALF : -GROUND_HALF,
                    z = i < 2 ? GROUND_HALF : -GROUND_HALF;
        corner[i] = scene_put_vertex(s, vec(x, 0, z), vec(0, 1, 0));
    }
    scene_put_triangle(s, corner[0], corner[1], corner[2]);
    scene_put_triangle(s, corner[0], corner[2], corner[3]);
}

bool photograph_scene(scene *s, bool objects, bool ground)
{
    memset(s, 0, sizeof *s);
    if (objects) put_objects(s);
    if (ground) put_ground(s);
    return scene_end(s);
}

// ---- The photograph

camera photograph_camera(float aspect)
{
    return camera_look(vec(0.6f, 2.2f, 4.3f), vec(0.25f, 0.32f, 0.1f), 0.48f, aspect);
}

// A number in [0,1) for each place of a grid.
static float grain(int x, int z)
{
    unsigned h = (unsigned)x * 0x8da6b343u ^ (unsigned)z * 0xd8163841u;
    h = (h ^ h >> 13) * 0x5bd1e995u;
    return (float)((h ^ h >> 15) & 0xffff) / 65536;
}

static float noise(float x, float z)
{
    const float i = floorf(x), k = floorf(z), u = x - i, v = z - k;
    const int a = (int)i, b = (int)k;
    const float low = grain(a, b) * (1 - u) + grain(a + 1, b) * u;
    return low * (1 - v) + (grain(a, b + 1) * (1 - u) + grain(a + 1, b + 1) * u) * v;
}

// Slabs of stone in staggered rows, with joints.
static vec3 paving(float x, float z)
{
    const float row = floorf(z / 0.45f), across = x / 0.7f + 0.5f * row + 0.3f * grain((int)row, 7);
    const float u = across - floorf(across), v = z / 0.45f - row;
    const float joint = fminf(0.7f * fminf(u, 1 - u), 0.45f * fminf(v, 1 - v)); // metres from it
    const float slab = grain((int)floorf(across) + 50, (int)row);
    const float stains = 0.6f * noise(1.7f * x, 1.7f * z) + 0.4f * noise(6 * x, 6 * z),
                fine = noise(90 * x, 90 * z);
    const float tone =
        (0.75f + 0.2f * slab + 0.25f * stains + 0.12f * fine) * (joint < 0.006f ? 0.45f : 1);
    return vec_scale(vec_mix(vec(0.36f, 0.34f, 0.31f), vec(0.40f, 0.36f, 0.30f), slab), tone);
}

typedef struct exposure {
    const probe *p;
    const camera *eye;
    vec3 irradiance; // of the ground
    image *out;
} exposure;

static vec3 seen_along(const exposure *e, vec3 ray)
{
    const float far = ray.y < 0 ? -e->eye->position.y / ray.y : GROUND_HALF;
    const vec3 at = vec_mad(e->eye->position, ray, far), around = probe_sample(e->p, ray);
    const float paved =
        fminf(fmaxf(3.5f - 0.5f * hypotf(at.x, at.z), 0), 1); // the paving ends at 5 to 7 m
    if (paved <= 0 || ray.y >= 0) return around;
    return vec_mix(around, vec_scale(vec_mul(paving(at.x, at.z), e->irradiance), 1 / VEC_PI),
                   paved);
}

static void expose_row(void *context, int y)
{
    enum { GRID = 4 }; // samples along the side of a pixel
    const exposure *e = context;
    for (int x = 0; x < e->out->width; x++) {
        vec3 sum = vec(0, 0, 0);
        for (int k = 0; k < GRID * GRID; k++) {
            const float u = ((float)x + ((float)(k % GRID) + 0.5f) / GRID) / (float)e->out->width;
            const float v = ((float)y + ((float)(k / GRID) + 0.5f) / GRID) / (float)e->out->height;
            sum = vec_mad(sum, seen_along(e, camera_ray(e->eye, u, v)), 1.0f / (GRID * GRID));
        }
        image_set(e->out, x, y, sum);
    }
}

bool photograph_take(const probe *p, const camera *eye, int width, int height, image *out)
{
    const vec3 up = vec(0, 1, 0);
    exposure e = {p, eye, vec(0, 0, 0), out};
    probe_irradiance(p, &up, 1, &e.irradiance);
    if (!image_create(out, width, height)) return false;
    parallel_for(height, expose_row, &e, NULL);
    return true;
}

// ---- The truth

// Both under the probe, with a ground of this albedo; a background of one radiance. Objects may be
// black.
static bool trace(const light_source *rays, const camera *eye, vec3 ground, bool objects,
                  float background, image *out)
{
    scene s;
    probe around;
    view v;
    if (!photograph_scene(&s, true, true)) return false;
    for (int i = 0; i < s.objects - 1 && !objects; i++) s.albedo[i] = vec(0, 0, 0);
    s.albedo[s.objects - 1] = ground;
    const bool created = probe_create(&around, 1);
    for (int i = 0; i < 18 && created; i++) around.texels[i] = background;
    const bool viewed = created && view_create(&v, &s, eye, out->width, out->height);
    if (viewed) {
        lighting_render(&v, &s, &around, rays, out);
        view_free(&v);
    }
    if (created) probe_free(&around);
    scene_free(&s);
    return viewed;
}

bool photograph_truth(const probe *p, const camera *eye, const image *empty, int rays, image *out)
{
    const vec3 up = vec(0, 1, 0);
    vec3 e;
    scene casters;
    probe_sampler sampler;
    image shadow = {0};
    if (!photograph_scene(&casters, true, false)) return false;
    bvh *tree = bvh_create(&casters);
    const light_source source = {NULL, tree, &sampler, rays, 1};
    scene_free(&casters);
    probe_irradiance(p, &up, 1, &e);
    const bool sampled = probe_sampler_create(&sampler, p);
    bool done = tree && sampled && image_create(&shadow, empty->width, empty->height) &&
                image_create(out, empty->width, empty->height);
    // What the ground reflects becomes the share of light that is left, 1 beside it; then the
    // objects alone.
    const vec3 share =
        vec(e.x > 0 ? VEC_PI / e.x : 0, e.y > 0 ? VEC_PI / e.y : 0, e.z > 0 ? VEC_PI / e.z : 0);
    done = done && trace(&source, eye, share, false, 1, &shadow) &&
           trace(&source, eye, vec(0, 0, 0), true, 0, out);
    for (int i = 0; i < 3 * empty->width * empty->height && done; i++)
        out->rgb[i] += empty->rgb[i] * shadow.rgb[i];
    image_free(&shadow);
    bvh_free(tree);
    if (sampled) probe_sampler_free(&sampler);
    return done;
}
