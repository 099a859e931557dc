// Light shafts on the CPU: the moment math of single scattering against plain geometry, and the
// whole way from a depth map to the light along a view ray against closed forms and against
// marching.
#include "../../examples/common/raytrace.h"
#include "../../examples/common/shafts.h"
#include "../support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { SIDE = 512, FINE = 2048 };
static const float axis[3] = {1, 0, 0};

// ---- Two depths ----

static void two_depths_have_three_moments(void)
{
    uint64_t seed = 91;
    double worst = 0, worst_moment = 0;
    for (int trial = 0; trial < test_trials(200000); trial++) {
        const int n = (int)test_range(&seed, 2, 6);
        double z[6], w[6], sum = 0, b[3] = {0}, got[3] = {0};
        for (int i = 0; i < n; i++) {
            z[i] = test_range(&seed, -1, 1);
            sum += w[i] = test_range(&seed, 0.01, 1);
        }
        for (int i = 0; i < n; i++) {
            for (int k = 0; k < 3; k++) b[k] += w[i] / sum * pow(z[i], k + 1);
        }
        const mssm_points2 p = mssm_reconstruct3((float)b[0], (float)b[1], (float)b[2]);
        const double spread = sqrt(b[1] - b[0] * b[0]);
        for (int i = 0; i < 2; i++) {
            CHECK(p.z[i] >= -1 && p.z[i] <= 1 && p.w[i] >= 0 && p.w[i] <= 1, "seed 91, trial %d",
                  trial);
            for (int k = 0; k < 3; k++) got[k] += (double)p.w[i] * pow((double)p.z[i], k + 1);
        }
        CHECK(p.z[0] <= p.z[1], "descending in trial %d", trial);
        for (int k = 0; k < 3; k++) worst_moment = fmax(worst_moment, fabs(got[k] - b[k]));
        if (n > 2 || spread < 0.05) continue;
        const int low = z[0] < z[1] ? 0 : 1;
        worst = fmax(worst, fmax(fabs((double)p.z[0] - z[low]), fabs((double)p.z[1] - z[1 - low])) *
                                spread);
    }
    test_note("moments off by %.2g; two depths by %.2g over their spread", worst_moment, worst);
    CHECK(worst_moment < 1e-3, "%g", worst_moment); // depths that rounding has driven out of [-1,1]
    CHECK(worst < 1e-5, "%g", worst);
    const mssm_points2 one = mssm_reconstruct3(0.25f, 0.0625f, 0.015625f);
    CHECK(fabsf(one.w[0] * one.z[0] + one.w[1] * one.z[1] - 0.25f) < 1e-6f,
          "the mean of one surface");
    CHECK(one.z[1] - one.z[0] < 0.005f, "%g wide", (double)(one.z[1] - one.z[0]));
}

// ---- Geometry ----

typedef struct situation {
    mssm_light light;
    camera eye;
    mssm_scattering from;
    vec3 to_light;
} situation;

// A camera anywhere in and around a box from -2 to 2, looking past its middle.
static situation random_situation(uint64_t *seed)
{
    static const float low[3] = {-2, -2, -2}, high[3] = {2, 2, 2};
    situation s;
    float v[6];
    for (int k = 0; k < 6; k++) v[k] = (float)test_range(seed, -1, 1);
    s.to_light = vec_unit(vec(v[0], v[1], v[2]));
    const float far_off = powf(10, (float)test_range(seed, -1, 1.5));
    const vec3 at = vec_scale(vec(v[3], v[4], v[5]), far_off);
    const vec3 to = vec((float)test_range(seed, -2, 2), (float)test_range(seed, -2, 2), 0.1f);
    s.eye = camera_look(at, to, (float)test_range(seed, 0.05, 1.5), 1.5f);
    const float direction[3] = {s.to_light.x, s.to_light.y, s.to_light.z};
    CHECK(!mssm_light_directional(&s.light, direction, axis, 0, 0, low, high), "light");
    CHECK(shafts_look(&s.from, &s.light, &s.eye, (float)test_range(seed, 0, 1)), "look");
    return s;
}

// A point of a view ray lies at the ray's inclination, on the light ray of its row and r.
static void points_of_a_view_ray_share_its_depth(void)
{
    uint64_t seed = 92, other = 93;
    double worst = 0, worst_angle = 0, worst_place = 0;
    for (int trial = 0; trial < test_trials(100000); trial++) {
        const situation s = random_situation(&seed);
        const vec3 d = vec_unit(
            camera_ray(&s.eye, (float)test_range(&seed, 0, 1), (float)test_range(&seed, 0, 1)));
        const float t = (float)test_range(&seed, 0.1, 5);
        const mssm_view_ray ray = mssm_scattering_ray(s.from, d.x, d.y, d.z, t);
        CHECK(ray.row >= -1e-3f && ray.row <= 1.001f && fabsf(ray.depth) <= 0.981f,
              "trial %d: row %g, depth %g", trial, (double)ray.row, (double)ray.depth);
        const vec3 p = vec_mad(s.eye.position, d, t);
        const float point[3] = {p.x, p.y, p.z};
        float shadow[3];
        CHECK(mssm_light_project(&s.light, point, shadow), "projection");
        const double up = (double)vec_dot(d, s.to_light), sine = sqrt(fmax(1 - up * up, 0));
        const double angle =
            (double)ray.depth / (double)s.from.inclination[1] + (double)s.from.inclination[0];
        worst_angle = fmax(worst_angle, fabs(cos(angle) - up));
        // Whatever the camera does not see has an inclination in range, too.
        const float far_off = 10 * (float)test_uniform(&other),
                    any = 2 * (float)test_uniform(&other) - 1;
        CHECK(fabsf(mssm_inclination(s.from, far_off, any)) <= 1 &&
                  mssm_inclination(s.from, far_off, any - 2) ==
                      mssm_inclination(s.from, far_off, -1),
              "inclination at %g, depth %g", (double)far_off, (double)any);
        if (sine < 0.02) continue;
        const float r = (float)(t * sine);
        if (shadow[2] > -1 && shadow[2] < 0.8f) { // as sharp as depths of far cameras are in float
            const double blur = 1e-6 * (1 + fabs((double)s.from.eye[2])) * 6 / (t * sine);
            const double off =
                fabs((double)mssm_inclination(s.from, r, shadow[2]) - (double)ray.depth) /
                (double)s.from.inclination[1];
            worst = fmax(worst, off / (blur + 1e-6));
        }
        const mssm_epipolar row =
            mssm_scattering_row(s.from, s.from.azimuth[0] + ray.row * s.from.azimuth[1]);
        const double x = (double)s.from.eye[0] + (double)row.x * (double)r - (double)shadow[0];
        const double y = (double)s.from.eye[1] + (double)row.y * (double)r - (double)shadow[1];
        worst_place = fmax(worst_place,
                           hypot(x, y) / (1 + hypot((double)s.from.eye[0], (double)s.from.eye[1])));
        if (row.extent > 0 && r > row.first && r < row.first + row.extent) {
            const double back = (double)mssm_scattering_distance(row, ray.column);
            CHECK(fabs(back - (double)r) < 2e-4 * exp((double)row.fade) * (1 + (double)row.extent),
                  "trial %d: r %g, back %g", trial, (double)r, back);
        }
    }
    test_note("inclination off by %.2g of its blur, cosine by %.2g, place by %.2g", worst,
              worst_angle, worst_place);
    CHECK(worst < 3 && worst_angle < 1e-5 && worst_place < 1e-4, "too far");
}

// Shares of the ray's light before, over and behind the map, by many small steps.
static void shares_are_those_of_the_medium(void)
{
    uint64_t seed = 93;
    double worst = 0;
    for (int trial = 0; trial < test_trials(2000); trial++) {
        situation s = random_situation(&seed);
        const vec3 d = vec_unit(
            camera_ray(&s.eye, (float)test_range(&seed, 0, 1), (float)test_range(&seed, 0, 1)));
        float t = (float)test_range(&seed, 0.1, 30);
        if (trial % 2) { // a few steps into what is all but opaque
            t *= 0.03f;
            s.from.extinction = 40 * (float)test_uniform(&seed) / t;
            s.from.balance = 0.5f;
        }
        const mssm_view_ray ray = mssm_scattering_ray(s.from, d.x, d.y, d.z, t);
        double inside = 0, all = 0;
        CHECK(ray.balance == s.from.balance, "balance %g", (double)ray.balance);
        for (int i = 0; i < 4000; i++) {
            const double at = (i + 0.5) / 4000 * (double)t,
                         w = exp(-(double)s.from.extinction * at);
            const vec3 p = vec_mad(s.eye.position, d, (float)at);
            const float point[3] = {p.x, p.y, p.z};
            float shadow[3];
            mssm_light_project(&s.light, point, shadow);
            all += w;
            if (fabsf(shadow[0]) < 1 && fabsf(shadow[1]) < 1) inside += w;
        }
        worst = fmax(worst, fabs(inside / all - (double)ray.share));
    }
    test_note("share over the map off by %.2g", worst);
    CHECK(worst < 5e-3, "%g", worst);
}

// Points at equal steps of what the medium has let through, and the shares of columns, for optical
// depths up to 1e6 and rays into the sky.
static void dense_media_and_the_sky_have_their_shares(void)
{
    uint64_t seed = 94;
    double worst = 0, worst_column = 0;
    for (int trial = 0; trial < test_trials(1000); trial++) {
        situation s = random_situation(&seed);
        const vec3 d = vec_unit(
            camera_ray(&s.eye, (float)test_range(&seed, 0, 1), (float)test_range(&seed, 0, 1)));
        const double extinction = pow(10, test_range(&seed, -2, 4));
        const float t = trial % 2 ? INFINITY : (float)(pow(10, test_range(&seed, 1, 6)));
        int inside = 0;
        s.from.fade *= (float)extinction / s.from.extinction;
        s.from.extinction = (float)extinction;
        const mssm_view_ray ray = mssm_scattering_ray(s.from, d.x, d.y, d.z, t);
        for (int i = 0; i < 4000; i++) {
            const double through = -expm1(-extinction * (double)t) * (i + 0.5) / 4000;
            const vec3 p = vec_mad(s.eye.position, d, (float)(-log1p(-through) / extinction));
            const float point[3] = {p.x, p.y, p.z};
            float shadow[3];
            mssm_light_project(&s.light, point, shadow);
            inside += fabsf(shadow[0]) < 1 && fabsf(shadow[1]) < 1;
        }
        worst = fmax(worst, fabs(inside / 4000.0 - (double)ray.share));
        const mssm_epipolar row =
            mssm_scattering_row(s.from, (float)test_range(&seed, -3.14, 3.14));
        const double fade = (double)s.from.fade, all = -expm1(-fade * (double)row.extent);
        if (fade * (double)row.extent < 0.1) continue; // rounding of r over so little
        for (int i = 0; i <= 16; i++) {
            const double r = (double)(mssm_scattering_distance(row, (float)i / 16) - row.first);
            const double rounding = 1e-7 * fade * (double)(row.first + row.extent / 16);
            const double off = fabs(-expm1(-fade * r) / all - i / 16.0);
            worst_column = fmax(worst_column, off / (1e-3 + rounding));
        }
    }
    test_note("share over the map off by %.2g, up to a column by %.2g of what is allowed", worst,
              worst_column);
    CHECK(worst < 5e-3, "%g", worst);
    CHECK(worst_column < 1, "%g", worst_column);
}

// ---- From a depth map to the light along a view ray ----

typedef struct stage {
    mssm_light light;
    mssm_filtered *map;
    void *memory;
    float *depth;
} stage;

static const float sky[3] = {0, 1, 0}, low_corner[3] = {-4, -1, -4}, high_corner[3] = {4, 3, 4};

// The light from above over 8 x 8, a roof at height h over x from a to b.
static stage make_roof(float a, float b, float h)
{
    stage s;
    const size_t bytes = mssm_filtered_bytes(SIDE, 4);
    CHECK(!mssm_light_directional(&s.light, sky, axis, 0, 0, low_corner, high_corner), "light");
    s.memory = malloc(bytes);
    s.depth = malloc(sizeof(float) * SIDE * SIDE);
    if (!s.memory || !s.depth) abort();
    for (int i = 0; i < SIDE * SIDE; i++) {
        const float x = 4 * (2 * ((float)(i % SIDE) + 0.5f) / SIDE - 1);
        const float point[3] = {x, h, 0};
        float shadow[3];
        mssm_light_project(&s.light, point, shadow);
        s.depth[i] = x > a && x < b ? shadow[2] : 1;
    }
    CHECK(!mssm_filtered_init(&s.map, s.memory, bytes, SIDE, 4) &&
              !mssm_filtered_update(s.map, s.depth, 1, 1),
          "map");
    return s;
}

static void free_stage(stage *s)
{
    free(s->memory);
    free(s->depth);
}

// Share of a ray's light that comes from under the roof: from x in (a,b) below h.
static double under_roof(vec3 at, vec3 d, double t, double extinction, double a, double b, double h)
{
    double from = 0, to = t;
    const double start[2] = {(double)at.x, (double)at.y}, step[2] = {(double)d.x, (double)d.y};
    const double low[2] = {a, -1e9}, high[2] = {b, h};
    for (int k = 0; k < 2; k++) {
        const double p = (low[k] - start[k]) / step[k], q = (high[k] - start[k]) / step[k];
        from = fmax(from, fmin(p, q));
        to = fmin(to, fmax(p, q));
    }
    if (to <= from) return 0;
    return (exp(-extinction * from) - exp(-extinction * to)) / (1 - exp(-extinction * t));
}

static void compare_roof(float a, float b, double limit)
{
    const float h = 1.5f, extinction = 0.3f;
    const camera eye = camera_look(vec(-0.3f, 0.4f, 0.7f), vec(1.5f, 0.9f, -2.2f), 1.2f, 1.5f);
    stage s = make_roof(a, b, h);
    shafts all;
    mssm_scattering from;
    double sum = 0, worst = 0;
    const bool ready =
        shafts_create(&all, 512, 512) && shafts_look(&from, &s.light, &eye, extinction);
    CHECK(ready, "shafts");
    shafts_update(&all, s.map, &from);
    for (int i = 0; i < 10000; i++) {
        const vec3 d = vec_unit(
            camera_ray(&eye, ((float)(i % 100) + 0.5f) / 100, ((float)i / 100 + 0.5f) / 100));
        const float t = 0.5f + 2.7f * fmodf((float)i * 0.618034f, 1);
        const double truth = 1 - under_roof(eye.position, d, (double)t, (double)extinction,
                                            (double)a, (double)b, (double)h);
        const double e = (double)shafts_visibility(&all, d, t) - truth;
        sum += e * e;
        worst = fmax(worst, fabs(e));
    }
    test_note("roof from %g to %g: rms error %.4f, worst %.3f", (double)a, (double)b,
              sqrt(sum / 10000), worst);
    CHECK(sqrt(sum / 10000) < limit, "rms %g", sqrt(sum / 10000));
    shafts_free(&all);
    free_stage(&s);
}

static void roofs_shadow_as_computed(void)
{
    compare_roof(5, 6, 2e-4);  // nothing, but for rounding
    compare_roof(-5, 5, 0.02); // everything below a height: the camera is under it
    compare_roof(0, 5, 0.02);  // half
    compare_roof(0.5f, 1.2f, 0.012);
}

// ---- Against marching ----

enum { WIDTH = 96, HEIGHT = 54 };

static struct pictures {
    mssm_scattering from;
    mssm_filtered *map;
    shafts shafts;
    image positions, truth, got;
    float depth[SIDE * SIDE * 4];
    void *memory;
} pictures;

static void make_pictures(void)
{
    struct pictures *p = &pictures;
    const size_t bytes = mssm_filtered_bytes(SIDE, 4);
    p->memory = malloc(bytes);
    if (!p->memory || !shafts_create(&p->shafts, 256, 128) ||
        !image_create(&p->positions, WIDTH, HEIGHT) || !image_create(&p->truth, WIDTH, HEIGHT) ||
        !image_create(&p->got, WIDTH, HEIGHT)) {
        abort();
    }
    CHECK(!mssm_filtered_init(&p->map, p->memory, bytes, SIDE, 4), "map");
}

static void free_pictures(void)
{
    image_free(&pictures.positions);
    image_free(&pictures.truth);
    image_free(&pictures.got);
    shafts_free(&pictures.shafts);
    free(pictures.memory);
}

// A picture whose rays end at surfaces, and the positions of these.
static void take_picture(const bvh *tree, const camera *eye, float extinction, float far_end)
{
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const int x = i % WIDTH, y = i / WIDTH;
        const vec3 d =
            vec_unit(camera_ray(eye, ((float)x + 0.5f) / WIDTH, ((float)y + 0.5f) / HEIGHT));
        const float hit = bvh_hit_nearest(tree, eye->position, d);
        image_set(&pictures.positions, x, y,
                  hit < 1e6f ? vec_mad(eye->position, d, hit) : vec(0, 0, 0));
        const float t = shafts_distance(eye, &pictures.positions, far_end, x, y);
        const float v = (1 - expf(-extinction * t)) * shafts_visibility(&pictures.shafts, d, t);
        CHECK(v >= 0 && v <= 1, "out of range at %d, %d", x, y);
        image_set(&pictures.got, x, y, vec(v, v, v));
    }
}

// What a lookup and 128 steps cost on this machine.
static void compare_times(const shafts_march *march, const camera *eye)
{
    enum { RAYS = 20000 };
    double seconds[2];
    float sum = 0;
    for (int k = 0; k < 2; k++) {
        const clock_t start = clock();
        for (int i = 0; i < RAYS; i++) {
            const float x = (float)i / RAYS;
            const vec3 d = vec_unit(camera_ray(eye, x, fmodf(97 * x, 1)));
            sum += k ? shafts_marched(march, eye->position, d, 8)
                     : shafts_visibility(&pictures.shafts, d, 8);
        }
        seconds[k] = (double)(clock() - start) / CLOCKS_PER_SEC / RAYS;
    }
    test_note("a ray by moments %.2f us, by %d steps %.2f us (mean of both %.3f)", 1e6 * seconds[0],
              march->steps, 1e6 * seconds[1], (double)sum / RAYS / 2);
}

// The depth map that the truth marches through is the scene: by rays towards the sun from every
// step.
static double rays_against_map(const bvh *tree, const shafts_march *m, const camera *eye,
                               const float to_sun[3])
{
    uint64_t seed = 97;
    double sum = 0;
    for (int i = 0; i < 200; i++) {
        const vec3 d = vec_unit(
            camera_ray(eye, (float)test_range(&seed, 0, 1), (float)test_range(&seed, 0, 1)));
        const float hit = fminf(bvh_hit_nearest(tree, eye->position, d), 8);
        const float all = 1 - expf(-m->extinction * hit);
        int lit = 0;
        for (int k = 0; k < m->steps; k++) {
            const float t = -logf(1 - ((float)k + 0.5f) / (float)m->steps * all) / m->extinction;
            lit += !bvh_hit_any(tree, vec_mad(eye->position, d, t), vec_of(to_sun), 100);
        }
        const float marched = shafts_marched(m, eye->position, d, hit);
        sum += pow((double)(marched - (float)lit / (float)m->steps), 2);
    }
    return sqrt(sum / 200);
}

static void pictures_are_those_of_marching(void)
{
    // clang-format off
    static const struct {
        const char *name;
        int hall;
        float sun[3];
        vec3 from, to;
        float angle, extinction, far_end, limit;
    } cases[] = {
        {"hall, windows ahead", 1, {-.4f, .8f, -1}, {2.5f, 1.4f, 3.2f}, {-.5f, 1.2f, -2}, .9f, .2f, 14, .02f},
        {"hall, thick smoke", 1, {-.4f, .8f, -1}, {2.5f, 1.4f, 3.2f}, {-.5f, 1.2f, -2}, .9f, .5f, 14, .01f},
        {"the sun in the picture", 1, {-.4f, .8f, -1}, {1.2f, 1, 2.2f}, {.8f, 1.9f, -1}, .9f, .2f, 14, .027f},
        {"the camera's own shadow", 1, {-.4f, .8f, -1}, {-1, 1.4f, -1.5f}, {-.4f, .2f, 0}, 1.2f, .2f, 14, .015f},
        {"demo, sun behind", 0, {-.6f, 1, .5f}, {.3f, 2.25f, 7.7f}, {0, .9f, 0}, .57f, .15f, 14, .01f},
        {"demo, sun ahead", 0, {-.6f, .5f, .8f}, {2, 1, -4}, {0, 1, 0}, .7f, .15f, 14, .035f},
        {"demo, from above", 0, {-.6f, 1, .5f}, {-6, 9, 5}, {0, 0, 0}, .6f, .15f, 14, .01f},
        {"demo, from far away", 0, {-.6f, 1, .5f}, {8, 6, 100}, {0, 1, 0}, .08f, .01f, 120, .01f},
    };
    // clang-format on
    scene scenes[2];
    const bool made = scene_create(&scenes[0], 0, NULL) && shafts_hall(&scenes[1]);
    bvh *tree[2] = {bvh_create(&scenes[0]), bvh_create(&scenes[1])};
    if (!made || !tree[0] || !tree[1]) abort();
    make_pictures();
    // Short runs take fewer scenes; the truth needs its steps.
    const int steps_of_truth = test_trials(1024) > 128 ? test_trials(1024) : 128;
    for (int i = 0; i < (int)(sizeof cases / sizeof *cases) && i < test_trials(80); i++) {
        const camera eye = camera_look(cases[i].from, cases[i].to, cases[i].angle, 16.0f / 9);
        const scene *s = &scenes[cases[i].hall];
        const mssm_light light = shafts_sun(s, cases[i].sun);
        const raster_frustum frustum = {light.world_to_shadow, false, 0, 0};
        const float extinction = cases[i].extinction, far_end = cases[i].far_end;
        double error[2], steps, bands;
        CHECK(raster_depth(s, &frustum, RASTER_FRONT, SIDE, 4, pictures.depth) &&
                  !mssm_filtered_update(pictures.map, pictures.depth, 4, 1) &&
                  shafts_look(&pictures.from, &light, &eye, extinction),
              "map");
        for (int k = 0; k < 2; k++) {
            pictures.from.balance = 0.5f * (float)k;
            shafts_update(&pictures.shafts, pictures.map, &pictures.from);
            take_picture(tree[cases[i].hall], &eye, extinction, far_end);
            CHECK(k == 1 || shafts_truth(s, &light, FINE, steps_of_truth, extinction, &eye,
                                         &pictures.positions, far_end, &pictures.truth),
                  "truth");
            shafts_errors(&pictures.got, &pictures.truth, &error[k], &bands);
        }
        CHECK(raster_depth(s, &frustum, RASTER_FRONT, SIDE, 1, pictures.depth), "depth");
        const shafts_march march = {&light, pictures.depth, SIDE, 128, extinction};
        const double rays = rays_against_map(tree[cases[i].hall], &march, &eye, cases[i].sun);
        shafts_march_image(&march, &eye, &pictures.positions, far_end, &pictures.got);
        shafts_errors(&pictures.got, &pictures.truth, &steps, &bands);
        if (i == 0) compare_times(&march, &eye);
        test_note("%-24s rms error %.4f, with balance 0.5 %.4f; 128 steps %.4f, from rays %.4f",
                  cases[i].name, error[0], error[1], steps, rays);
        CHECK(error[0] < (double)cases[i].limit, "%s: %g", cases[i].name, error[0]);
        CHECK(rays < 0.02, "%s: marching is %g off", cases[i].name, rays);
    }
    free_pictures();
    for (int i = 0; i < 2; i++) {
        bvh_free(tree[i]);
        scene_free(&scenes[i]);
    }
}

// ---- Promises ----

static void bounds_hold_what_lies_between(void)
{
    uint64_t seed = 94;
    for (int trial = 0; trial < test_trials(100000); trial++) {
        float z = (float)test_range(&seed, -1, 1), low = 1;
        mssm_moments6 m = {{0}};
        for (int i = 0; i < 5; i++) {
            const mssm_moments6 t = mssm_moments6_of_depth((float)test_range(&seed, -1, 1));
            for (int k = 0; k < 6; k++) m.b[k] += 0.2f * t.b[k];
        }
        m = mssm_moments6_bias(m, MSSM_BIAS6_FLOAT32);
        const mssm_bounds b = mssm_visibility6(m, z);
        for (int step = 0; step <= 4; step++) { // from the light behind the camera to ahead
            mssm_view_ray ray = {0.5f, 0.5f, z, 1, 0.25f * (float)(4 - step), 0};
            const float seen = mssm_scattering_visibility(ray, m);
            CHECK(seen >= b.lower - 1e-6f && seen <= b.upper + 1e-6f && seen <= low, "trial %d",
                  trial);
            CHECK(step > 0 || fabsf(seen - b.upper) < 1e-6f, "not the upper bound");
            CHECK(step < 4 || fabsf(seen - b.lower) < 1e-6f, "not the lower bound");
            low = seen + 1e-6f;
            ray.balance = (float)test_range(&seed, -2, 3);
            const float other = mssm_scattering_visibility(ray, m);
            CHECK(other >= b.lower - 1e-6f && other <= b.upper + 1e-6f, "trial %d, balance", trial);
            // Halfway to the share of what is surely lit in all that is sure (docs/shafts.md).
            ray.balance = 0.5f;
            const double sure = (double)b.lower + 1 - (double)b.upper;
            const double beta = 0.5 * ((double)ray.upper + (double)b.lower / sure);
            const double want = (double)b.lower + beta * (double)(b.upper - b.lower);
            CHECK(sure < 1e-3 || fabs((double)mssm_scattering_visibility(ray, m) - want) < 1e-4,
                  "trial %d: %g, not %g", trial, (double)mssm_scattering_visibility(ray, m), want);
            ray.share = 0;
            CHECK(mssm_scattering_visibility(ray, m) >= 1, "lit beyond the map");
        }
    }
}

static float hostile(uint64_t *seed)
{
    static const float extreme[] = {0, -0.0f, 1, -1, 1e-30f, 1e30f, -1e30f, 1e12f, 0.999f};
    const double kind = test_uniform(seed);
    return kind < 0.5 ? (float)test_range(seed, -2, 2)
                      : extreme[(int)test_range(seed, 0, sizeof extreme / sizeof *extreme)];
}

static void nothing_hostile_gets_through(void)
{
    uint64_t seed = 95;
    for (int trial = 0; trial < test_trials(200000); trial++) {
        float v[12], c[12];
        mssm_light light;
        mssm_scattering s;
        for (int k = 0; k < 12; k++) v[k] = hostile(&seed), c[k] = hostile(&seed);
        if (mssm_light_directional(&light, v, axis, 0, 0, low_corner, high_corner)) continue;
        if (mssm_scattering_init(&s, &light, v + 3, c, fabsf(v[6]))) continue;
        const mssm_epipolar row = mssm_scattering_row(s, v[7]);
        const float r = mssm_scattering_distance(row, v[8]);
        const mssm_moments6 m = mssm_scattering_moments(s, r, v[9], v[10], v[11]);
        const vec3 d = vec_unit(vec(v[9], v[10], v[11]));
        const mssm_view_ray ray = mssm_scattering_ray(s, d.x, d.y, d.z, fabsf(v[8]));
        const float seen = mssm_scattering_visibility(ray, m);
        CHECK(isfinite(row.first) && isfinite(row.extent) && isfinite(r) && isfinite(ray.row) &&
                  isfinite(ray.column),
              "trial %d: row %g %g, r %g, ray %g %g", trial, (double)row.first, (double)row.extent,
              (double)r, (double)ray.row, (double)ray.column);
        CHECK(seen >= 0 && seen <= 1 && ray.share >= 0 && ray.share <= 1 && ray.column >= 0 &&
                  ray.column <= 1.0001f,
              "trial %d: %g", trial, (double)seen);
        for (int k = 0; k < 6; k++)
            CHECK(fabsf(m.b[k]) <= 1.001f, "trial %d: moment %g", trial, (double)m.b[k]);
    }
}

static void bad_arguments_are_refused(void)
{
    const camera eye = camera_look(vec(0, 0, 5), vec(0, 0, 0), 1, 1);
    const float at[3] = {0, 0, 5}, wild[3] = {NAN, 0, 0}, low[3] = {0, 0, 0};
    float corners[12] = {-1, 1, -1, 1, 1, -1, 1, -1, -1, -1, -1, -1}, bad[12];
    mssm_light light, spot, flat;
    mssm_scattering s, before;
    CHECK(!mssm_light_directional(&light, sky, axis, 0, 0, low_corner, high_corner), "light");
    CHECK(!mssm_light_spot(&spot, at, sky, axis, 1, 0.1f, 5, 0, 0), "spot");
    flat = light;
    for (int i = 0; i < 4; i++) flat.world_to_shadow[4 * i] = 0;
    CHECK(shafts_look(&s, &light, &eye, 0.1f) && !shafts_look(&s, &spot, &eye, 0.1f), "looks");
    memset(&s, 7, sizeof s);
    before = s;
    CHECK(mssm_scattering_init(NULL, &light, at, corners, 0.1f), "no result");
    CHECK(mssm_scattering_init(&s, NULL, at, corners, 0.1f), "no light");
    CHECK(mssm_scattering_init(&s, &light, NULL, corners, 0.1f), "no camera");
    CHECK(mssm_scattering_init(&s, &light, at, NULL, 0.1f), "no corners");
    CHECK(mssm_scattering_init(&s, &spot, at, corners, 0.1f), "a spot");
    CHECK(mssm_scattering_init(&s, &flat, at, corners, 0.1f), "a light without width");
    CHECK(mssm_scattering_init(&s, &light, wild, corners, 0.1f), "a camera nowhere");
    CHECK(mssm_scattering_init(&s, &light, at, corners, -1), "negative extinction");
    CHECK(mssm_scattering_init(&s, &light, at, corners, INFINITY), "infinite extinction");
    memcpy(bad, corners, sizeof bad);
    bad[4] = NAN;
    CHECK(mssm_scattering_init(&s, &light, at, bad, 0.1f), "a corner nowhere");
    memset(bad, 0, sizeof bad);
    CHECK(mssm_scattering_init(&s, &light, at, bad, 0.1f), "no directions");
    const float upwards[12] = {-0.1f, 1, 0.1f, 0.1f, 1, 0.1f, 0.1f, 1, -0.1f, -0.1f, 1, -0.1f};
    CHECK(mssm_scattering_init(&s, &light, at, upwards, 2e38f),
          "ten times the extinction leaves float");
    flat = light;
    for (int i = 0; i < 3; i++)
        flat.world_to_shadow[4 * i] = flat.world_to_shadow[4 * i + 1] = 3e38f;
    CHECK(mssm_scattering_init(&s, &flat, low, corners, 0.1f), "slopes beyond float");
    CHECK(!memcmp(&s, &before, sizeof s), "touched");
    for (int i = 1; i < 4; i++) memcpy(corners + 3 * i, corners, 3 * sizeof *corners);
    CHECK(!mssm_scattering_init(&s, &light, at, corners, 0), "one direction is a picture too");
    CHECK(isfinite(s.inclination[1]) && s.azimuth[1] > 0, "no range");
}

static void text_is_the_source(void)
{
    static const char start[] = "mssm_points2 mssm_reconstruct3(float b1, float b2, float b3)\n{";
    CHECK(strstr(mssm_glsl_scattering(), start), "not there");
}

const test_case scattering_tests[] = {
    {"two depths have the three moments that they stand for", two_depths_have_three_moments},
    {"all points of a view ray have its inclination", points_of_a_view_ray_share_its_depth},
    {"shares of a view ray's light are those of the medium", shares_are_those_of_the_medium},
    {"dense media and rays into the sky have their shares",
     dense_media_and_the_sky_have_their_shares},
    {"light under a roof is what geometry says", roofs_shadow_as_computed},
    {"light shafts are those of ray marching", pictures_are_those_of_marching},
    {"scattering goes from bound to bound with the angle to the light",
     bounds_hold_what_lies_between},
    {"scattering is finite for any camera, light and moments", nothing_hostile_gets_through},
    {"the text of scattering is its source", text_is_the_source},
    {"scattering refuses bad arguments", bad_arguments_are_refused},
    {0, 0}};
