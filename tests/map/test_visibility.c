// Visibility against ray tracing, next to rivals that read every texel, and what must hold for any
// light, map and point.
#include "../support/scenes.h"
#include "../support/test.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

// ---- a scene, its light and its map --------------------------------------------------------

typedef struct setup {
    scene scene;
    mssm_light light;
    mssm_map *map;
    int side, samples;
    float *front, *back; // what the map was made from
    void *memory;
} setup;

static void *allocate(size_t bytes)
{
    void *memory = malloc(bytes);
    if (!memory) abort();
    return memory;
}

// Builds the map of u->scene from u->light. with_back: front and back faces averaged.
static void setup_map(setup *u, int side, int samples, int moments, int with_back)
{
    const size_t count = (size_t)(side * side * samples), bytes = mssm_map_bytes(side, moments);
    u->side = side;
    u->samples = samples;
    u->front = allocate(count * sizeof *u->front);
    u->back = allocate(count * sizeof *u->back);
    u->memory = allocate(bytes);
    scene_depth(&u->scene, &u->light, side, samples, u->front, u->back);
    CHECK(mssm_map_init(&u->map, u->memory, bytes, side, moments) == MSSM_OK, "init");
    CHECK(mssm_map_update(u->map, u->front, with_back ? u->back : NULL, samples) == MSSM_OK,
          "update");
}

static void setup_scene(setup *u, int which, double tangent, int side)
{
    scene_make(&u->scene, which);
    CHECK(scene_light(&u->scene, tangent, tangent, &u->light) == MSSM_OK, "light");
    setup_map(u, side, 1, 6, 0);
}

static void setup_free(setup *u)
{
    free(u->front);
    free(u->back);
    free(u->memory);
}

static double visibility(const setup *u, const mssm_settings *settings, const double point[3])
{
    const float p[3] = {(float)point[0], (float)point[1], (float)point[2]};
    return (double)mssm_map_visibility(u->map, &u->light, settings, p);
}

// Comparisons of errors say something from this many receivers on; below, the code only runs.
static int enough(int receivers)
{
    return receivers >= 100;
}

static int usual_side(void)
{
    return test_trials(256) > 20 ? 256 : 64; // valgrind has no time for more
}

// ---- rivals that read every texel, for one sample a texel -------------------------------------

// The receiver in texels, and its depth with the bias taken off. A blocker at depth z blurs over
// wide * (spread(receiver) - spread(z)) texels to each side.
typedef struct place {
    double x, y, z, wide_u, wide_v;
    const mssm_light *light;
} place;

static double spread(const place *r, double z)
{
    if (!r->light->perspective) return z;
    const double z_near = (double)r->light->z_near, z_far = (double)r->light->z_far;
    return -1 / (z_near + 0.5 * (z + 1) * (z_far - z_near));
}

static place place_of(const setup *u, const double point[3], double bias_in_texels)
{
    const mssm_light *light = &u->light;
    const float p[3] = {(float)point[0], (float)point[1], (float)point[2]};
    float shadow[3] = {0, 0, -2};
    mssm_light_project(light, p, shadow);
    const double extent_u = (double)light->extent_u, extent_v = (double)light->extent_v;
    const double world = 0.5 * ((double)light->z_far - (double)light->z_near), side = u->side;
    place r = {0, 0, 0, 0, 0, light};
    r.x = (0.5 + 0.5 * (double)shadow[0]) * side;
    r.y = (0.5 + 0.5 * (double)shadow[1]) * side;
    r.z = (double)shadow[2];
    const double away = light->perspective ? -1 / spread(&r, r.z) : 1;
    r.z -= bias_in_texels * away * 2 * fmax(extent_u, extent_v) / side / world;
    r.wide_u = (double)light->half_u / extent_u * 0.5 * side * (light->perspective ? 1 : world);
    r.wide_v = (double)light->half_v / extent_v * 0.5 * side * (light->perspective ? 1 : world);
    return r;
}

static double overlap(double low, double high, int texel)
{
    const double a = fmax(low, texel), b = fmin(high, texel + 1);
    return b > a ? b - a : 0;
}

// The share of the kernel for blockers at depth z0 that lies nearer than the receiver, and the mean
// depth of that.
static double nearer(const setup *u, const place *r, double z0, double *mean)
{
    const double distance = spread(r, r->z) - spread(r, z0);
    const double hx = fmax(r->wide_u * distance, 0.5), hy = fmax(r->wide_v * distance, 0.5);
    const int x0 = (int)fmax(floor(r->x - hx), 0), x1 = (int)fmin(ceil(r->x + hx), u->side);
    const int y0 = (int)fmax(floor(r->y - hy), 0), y1 = (int)fmin(ceil(r->y + hy), u->side);
    double sum = 0, first = 0;
    for (int y = y0; y < y1; y++) {
        for (int x = x0; x < x1; x++) {
            const double z = (double)u->front[y * u->side + x];
            if (z >= r->z || z >= 1) continue;
            const double area = overlap(r->x - hx, r->x + hx, x) * overlap(r->y - hy, r->y + hy, y);
            sum += area;
            first += area * z;
        }
    }
    *mean = sum > 0 ? first / sum : r->z;
    return sum / (4 * hx * hy);
}

// Percentage-closer soft shadows, every texel read.
static double percentage_closer(const setup *u, const double point[3], double bias)
{
    const place r = place_of(u, point, bias);
    double mean;
    if (r.z <= -1 || nearer(u, &r, -1, &mean) <= 0) return 1;
    return 1 - nearer(u, &r, mean, &mean);
}

// Each texel projected onto the light from the receiver.
static double back_projection(const setup *u, const double point[3], double bias)
{
    const place r = place_of(u, point, bias);
    if (r.z <= -1) return 1;
    const double here = spread(&r, r.z), search = here - spread(&r, -1);
    const double hx = fmax(r.wide_u * search, 0.5), hy = fmax(r.wide_v * search, 0.5);
    const int x0 = (int)fmax(floor(r.x - hx), 0), x1 = (int)fmin(ceil(r.x + hx), u->side);
    const int y0 = (int)fmax(floor(r.y - hy), 0), y1 = (int)fmin(ceil(r.y + hy), u->side);
    double occlusion = 0;
    for (int y = y0; y < y1; y++) {
        for (int x = x0; x < x1; x++) {
            const double z = (double)u->front[y * u->side + x];
            if (z >= r.z || z >= 1) continue;
            const double distance = here - spread(&r, z);
            const double ax = fmax(r.wide_u * distance, 0.5), ay = fmax(r.wide_v * distance, 0.5);
            occlusion +=
                overlap(r.x - ax, r.x + ax, x) * overlap(r.y - ay, r.y + ay, y) / (4 * ax * ay);
        }
    }
    return 1 - fmin(occlusion, 1);
}

// ---- one chart of errors that several tests read ---------------------------------------------

enum {
    LAYERED_6,
    LAYERED_4,
    AUTOMATIC,
    LOWER_6,
    UPPER_6,
    CLOSER, // rivals with a bias of 1, 2 and 4 texels
    PROJECTION = CLOSER + 3,
    METHODS = PROJECTION + 3
};

enum { LIGHTS = 4 };
static const double tangents[LIGHTS] = {0.05, 0.1, 0.2, 0.5};
static const double rival_bias[3] = {1, 2, 4};

typedef struct chart {
    int receivers;
    const char *name[SCENE_COUNT];
    double rms[SCENE_COUNT][LIGHTS][METHODS];
    double mean[METHODS];
} chart;

static double measure(const setup *u, int method, const double point[3])
{
    static const mssm_settings settings[CLOSER] = {{6, MSSM_LAYERED, 0, 0, 0, 0},
                                                   {4, MSSM_LAYERED, 0, 0, 0, 0},
                                                   {0, MSSM_LAYERED, 0, 0, 0, 0},
                                                   {6, MSSM_LOWER_BLOCKER, 0, 0, 0, 0},
                                                   {6, MSSM_UPPER_BLOCKER, 0, 0, 0, 0}};
    if (method < CLOSER) return visibility(u, &settings[method], point);
    if (method < PROJECTION) return percentage_closer(u, point, rival_bias[method - CLOSER]);
    return back_projection(u, point, rival_bias[method - PROJECTION]);
}

static void measure_scene(setup *u, int receivers, uint64_t *state, double rms[METHODS])
{
    double squares[METHODS] = {0};
    for (int i = 0; i < receivers; i++) {
        double point[3], normal[3];
        scene_receiver(&u->scene, state, point, normal);
        const double truth = scene_visibility(&u->scene, &u->light, point, normal, 12, state);
        for (int m = 0; m < METHODS; m++) squares[m] += pow(measure(u, m, point) - truth, 2);
    }
    for (int m = 0; m < METHODS; m++) rms[m] = sqrt(squares[m] / receivers);
}

static const chart *measured(void)
{
    static chart c;
    if (c.receivers) return &c;
    c.receivers = test_trials(400);
    uint64_t state = 2026;
    for (int s = 0; s < SCENE_COUNT; s++) {
        setup u;
        setup_scene(&u, s, 0, usual_side());
        c.name[s] = u.scene.name;
        for (int l = 0; l < LIGHTS; l++) {
            CHECK(scene_light(&u.scene, tangents[l], tangents[l], &u.light) == MSSM_OK, "light");
            measure_scene(&u, c.receivers, &state, c.rms[s][l]);
            for (int m = 0; m < METHODS; m++) {
                c.mean[m] += c.rms[s][l][m] / (SCENE_COUNT * LIGHTS);
            }
        }
        setup_free(&u);
    }
    return &c;
}

// The bias with which a rival does best over all scenes.
static int best_of(const chart *c, int first)
{
    int best = first;
    for (int m = first + 1; m < first + 3; m++) {
        if (c->mean[m] < c->mean[best]) best = m;
    }
    return best;
}

// PCSS gets the bias that suits it best over all scenes, and where that happens to be the very bias
// of one scene it may come out a little ahead there: a sixth of its error, or less than the truth's
// own noise. Dense foliage under the largest light is the one case known to need that.
static void layered_beats_percentage_closer(void)
{
    const chart *c = measured();
    const int rival = best_of(c, CLOSER);
    int lost = 0;
    for (int s = 0; s < SCENE_COUNT && enough(c->receivers); s++) {
        for (int l = 0; l < LIGHTS; l++) {
            const double *rms = c->rms[s][l];
            lost += rms[LAYERED_6] >= rms[rival];
            CHECK(rms[LAYERED_6] < fmax(rms[rival] * 7 / 6, rms[rival] + 0.005),
                  "%s, tangent %g: rms %.4f, PCSS %.4f", c->name[s], tangents[l], rms[LAYERED_6],
                  rms[rival]);
        }
    }
    test_note(
        "mean rms %.4f, PCSS with its best bias (%g texels) %.4f; behind it in %d of %d cases",
        c->mean[LAYERED_6], rival_bias[rival - CLOSER], c->mean[rival], lost, SCENE_COUNT * LIGHTS);
    CHECK(!enough(c->receivers) || c->mean[LAYERED_6] < 0.7 * c->mean[rival],
          "mean %.4f against %.4f", c->mean[LAYERED_6], c->mean[rival]);
}

static void layered_beats_the_published_estimators(void)
{
    const chart *c = measured();
    const double best = fmin(c->mean[LOWER_6], c->mean[UPPER_6]);
    test_note("mean rms %.4f; lower blocker %.4f, upper blocker %.4f", c->mean[LAYERED_6],
              c->mean[LOWER_6], c->mean[UPPER_6]);
    // Issue 4 asks for 25% less.
    CHECK(!enough(c->receivers) || c->mean[LAYERED_6] < 0.75 * best, "%.4f against %.4f",
          c->mean[LAYERED_6], best);
}

static void layered_keeps_up_with_back_projection(void)
{
    const chart *c = measured();
    const int rival = best_of(c, PROJECTION);
    test_note("mean rms %.4f; back-projection with its best bias (%g texels) %.4f",
              c->mean[LAYERED_6], rival_bias[rival - PROJECTION], c->mean[rival]);
    CHECK(!enough(c->receivers) || c->mean[LAYERED_6] < 1.15 * c->mean[rival], "%.4f against %.4f",
          c->mean[LAYERED_6], c->mean[rival]);
}

static void fewer_moments_cost_little(void)
{
    const chart *c = measured();
    test_note("mean rms: 6 moments %.4f, 4 moments %.4f, automatic %.4f", c->mean[LAYERED_6],
              c->mean[LAYERED_4], c->mean[AUTOMATIC]);
    if (!enough(c->receivers)) return;
    CHECK(c->mean[LAYERED_4] < 1.25 * c->mean[LAYERED_6], "4 moments");
    CHECK(c->mean[AUTOMATIC] < 1.05 * c->mean[LAYERED_6], "automatic");
}

// ---- light and dark --------------------------------------------------------------------------

// Lowest visibility of random points above or on a lonely tilted plate.
static double darkest_on_plate(double tilt, double tangent, int moments)
{
    setup u;
    memset(&u, 0, sizeof u);
    const double along_slope[3] = {cos(tilt), -sin(tilt), 0}, side[3] = {0, 0, 1};
    scene_add_box(&u.scene, 0, 0, 0, 2, 0.1, 2);
    scene_turn_last(&u.scene, along_slope, side);
    u.scene.sun[1] = 1;
    scene_finish(&u.scene);
    CHECK(scene_light(&u.scene, tangent, tangent, &u.light) == MSSM_OK, "light");
    setup_map(&u, usual_side(), 1, moments, 0);
    uint64_t state = 7;
    double darkest = 1;
    for (int i = 0; i < test_trials(200); i++) {
        const double a = test_range(&state, -1.8, 1.8), b = test_range(&state, -1.8, 1.8);
        const double lift = i % 2 ? 0 : test_range(&state, 0, 0.5);
        const double p[3] = {a * cos(tilt) + 0.1 * sin(tilt),
                             -a * sin(tilt) + 0.1 * cos(tilt) + lift, b};
        darkest = fmin(darkest, visibility(&u, NULL, p));
    }
    setup_free(&u);
    return darkest;
}

static void a_lonely_plate_is_lit(void)
{
    double darkest = 1;
    for (int l = 0; l < LIGHTS; l++) {
        for (int degrees = 0; degrees <= 60; degrees += 15) {
            const double tilt = degrees * 0.0174532925199433;
            // Steeper, the plate all but hides a part of the light itself.
            if (tan(tilt) * tangents[l] > 0.3) continue;
            for (int moments = 4; moments <= 6; moments += 2) {
                const double v = darkest_on_plate(tilt, tangents[l], moments);
                CHECK(v > 0.97, "tilt %d, tangent %g, %d moments: %.4f", degrees, tangents[l],
                      moments, v);
                darkest = fmin(darkest, v);
            }
        }
    }
    test_note("lowest visibility %.4f", darkest);
}

static void an_empty_map_is_lit(void)
{
    setup u;
    setup_scene(&u, 0, 0.2, 64);
    CHECK(mssm_map_init(&u.map, u.memory, mssm_map_bytes(64, 6), 64, 6) == MSSM_OK, "init");
    uint64_t state = 5;
    for (int i = 0; i < test_trials(2000); i++) {
        const double p[3] = {test_range(&state, -9, 9), test_range(&state, -9, 9),
                             test_range(&state, -9, 9)};
        CHECK(visibility(&u, NULL, p) > 0.999, "at %g %g %g: %g", p[0], p[1], p[2],
              visibility(&u, NULL, p));
        const float at[3] = {(float)p[0], (float)p[1], (float)p[2]}, normal[3] = {1, 8, 1};
        const float v = mssm_map_visibility_normal(u.map, &u.light, NULL, at, normal);
        CHECK(v > 0.999f, "with a normal, at %g %g %g: %g", p[0], p[1], p[2], (double)v);
    }
    setup_free(&u);
}

// Outside of what the kernels can reach, and nearer to the light than all casters.
static void points_beyond_the_map_are_lit(void)
{
    uint64_t state = 6;
    for (int s = 0; s < SCENE_COUNT; s++) {
        setup u;
        setup_scene(&u, s, 0.2, 64);
        for (int i = 0; i < test_trials(300); i++) {
            const double height = test_range(&state, 8, 50), far = test_range(&state, 15, 99);
            const double angle = test_range(&state, 0, 6.28);
            double above[3];
            for (int k = 0; k < 3; k++)
                above[k] = height * u.scene.sun[k] + test_range(&state, -1, 1);
            const double aside[3] = {far * cos(angle), 0, far * sin(angle)};
            CHECK(visibility(&u, NULL, above) >= 1, "%s: above all", u.scene.name);
            CHECK(visibility(&u, NULL, aside) >= 1, "%s: %g aside", u.scene.name, far);
        }
        setup_free(&u);
    }
}

// Highest visibility of points under the middle of a plate and a ball, some far behind all casters.
// With next to no moment bias, where weights add up to more than 1 by rounding, it stays a share.
static double lightest_in_umbra(double tangent, int moments)
{
    const mssm_settings settings = {moments, MSSM_LAYERED, 0, 0, 0, 0};
    const mssm_settings unbiased = {moments, MSSM_LAYERED, 1e-12f, 0, 0, 0};
    setup u;
    memset(&u, 0, sizeof u);
    scene_add_box(&u.scene, 0, 2, 0, 2, 0.05, 2);
    scene_add_sphere(&u.scene, 0, 3, 0, 0.5);
    u.scene.sun[1] = 1;
    scene_finish(&u.scene);
    CHECK(scene_light(&u.scene, tangent, tangent, &u.light) == MSSM_OK, "light");
    setup_map(&u, usual_side(), 1, 6, 0);
    uint64_t state = 8;
    double lightest = 0;
    for (int i = 0; i < test_trials(300); i++) {
        const double drop = test_range(&state, 0.2, 0.8 / tangent);
        const double p[3] = {test_range(&state, -0.9, 0.9), 2 - drop,
                             test_range(&state, -0.9, 0.9)};
        lightest = fmax(lightest, visibility(&u, &settings, p));
        const double bare = visibility(&u, &unbiased, p);
        CHECK(bare >= 0 && bare <= 1, "without bias: %g", bare);
    }
    setup_free(&u);
    return lightest;
}

// Four moments cannot tell apart the plate, the ball's curve and the depth that is asked about.
static void the_umbra_is_dark(void)
{
    static const int moments[3] = {0, 4, 6};
    static const double limit[3] = {0.03, 0.12, 0.03};
    double lightest[3] = {0};
    for (int m = 0; m < 3; m++) {
        for (int l = 0; l < LIGHTS; l++) {
            const double v = lightest_in_umbra(tangents[l], moments[m]);
            CHECK(v < limit[m], "tangent %g, %d moments: %.4f", tangents[l], moments[m], v);
            lightest[m] = fmax(lightest[m], v);
        }
    }
    test_note("highest visibility %.4f, with 4 moments %.4f, with 6 %.4f", lightest[0], lightest[1],
              lightest[2]);
}

// Two small plates in a corner each of a wide, flat box: a texel is as wide as the whole range of
// depth, and still receivers far behind the casters must be in their shadow.
static void a_wide_flat_scene_keeps_its_shadows(void)
{
    setup u;
    memset(&u, 0, sizeof u);
    scene_add_box(&u.scene, -30, 0.1, -30, 10, 0.02, 10);
    scene_add_box(&u.scene, 30, 0, 30, 10, 0.02, 10);
    u.scene.sun[1] = 1;
    scene_finish(&u.scene);
    CHECK(scene_light(&u.scene, 0.1, 0.1, &u.light) == MSSM_OK, "light");
    setup_map(&u, 256, 1, 6, 0);
    double lightest = 0;
    for (int i = 0; i < 40; i++) {
        const double p[3] = {i % 2 ? 30 : -30, -2 - i, i % 2 ? 31 : -29};
        lightest = fmax(lightest, visibility(&u, NULL, p));
    }
    setup_free(&u);
    CHECK(lightest < 0.03, "visibility %.4f", lightest);
}

// ---- any input -------------------------------------------------------------------------------

static float any_float(uint64_t *state)
{
    static const float odd[] = {0, -1, 1, 1e30f, -1e30f, 1e-38f, 3.4e38f, -3.4e38f, 0.8f, 0.9f};
    const uint64_t pick = test_random(state) % 16;
    if (pick == 0) return (float)NAN;
    if (pick == 1) return (float)INFINITY;
    if (pick == 2) return -(float)INFINITY;
    if (pick < 7) return odd[test_random(state) % (sizeof odd / sizeof *odd)];
    return (float)test_range(state, -2, 2);
}

static void fill_any(float *depth, int count, uint64_t *state)
{
    const uint64_t kind = test_random(state) % 3;
    for (int i = 0; i < count; i++) {
        depth[i] = kind == 0 ? any_float(state) : (float)test_range(state, -1, 1);
        if (kind == 2 && i > 0) depth[i] = depth[0];
    }
}

// One random light; half of them of extreme shape.
static mssm_result any_light(mssm_light *light, uint64_t *state)
{
    float v[3], a[3], low[3], high[3], size[2];
    for (int i = 0; i < 3; i++) {
        v[i] = (float)test_range(state, -1, 1);
        a[i] = (float)test_range(state, -1, 1);
        low[i] = (float)test_range(state, -2, 0);
        high[i] = low[i] + (float)pow(10, test_range(state, -3, 1));
    }
    for (int i = 0; i < 2; i++) {
        size[i] = test_uniform(state) < 0.2 ? 0 : (float)pow(10, test_range(state, -4, 3));
    }
    if (test_uniform(state) < 0.5) {
        return mssm_light_directional(light, v, a, size[0], size[1], low, high);
    }
    const float z_near = (float)pow(10, test_range(state, -4, 0));
    return mssm_light_spot(light, low, v, a, (float)test_range(state, 0.01, 3), z_near,
                           z_near * (float)test_range(state, 1.001, 1000), size[0], size[1]);
}

static void visibility_stays_in_range(void)
{
    enum { SIDES = 8 };
    static const int sides[SIDES] = {1, 2, 3, 5, 16, 27, 55, 100};
    uint64_t state = 9;
    for (int i = 0; i < test_trials(400); i++) {
        const uint64_t seed = state;
        const int side = sides[i % SIDES], moments = i % 3 ? 6 : 4, samples = 1 + i % 8;
        const int count = side * side * samples;
        const size_t bytes = mssm_map_bytes(side, moments);
        float *depth = allocate(2 * (size_t)count * sizeof *depth);
        void *memory = allocate(bytes);
        mssm_map *map;
        mssm_light light;
        fill_any(depth, 2 * count, &state);
        CHECK(mssm_map_init(&map, memory, bytes, side, moments) == MSSM_OK, "init");
        CHECK(mssm_map_update(map, depth, i % 4 ? NULL : depth + count, samples) == MSSM_OK,
              "update");
        CHECK(any_light(&light, &state) == MSSM_OK, "light of seed %llu", (unsigned long long)seed);
        for (int n = 0; n < 100; n++) {
            const mssm_settings settings = {n % 3 * 2 + (n % 3 > 0 ? 2 : 0),
                                            (mssm_estimator)(n / 3 % 3),
                                            n % 5 ? 0 : any_float(&state),
                                            n % 7 ? 0 : any_float(&state),
                                            n % 4 ? 0 : n,
                                            n % 6 ? 0 : any_float(&state)};
            const float point[3] = {any_float(&state), any_float(&state), any_float(&state)};
            const float v = mssm_map_visibility(map, &light, &settings, point);
            CHECK(v >= 0 && v <= 1, "%g from seed %llu, point %d", (double)v,
                  (unsigned long long)seed, n);
        }
        free(depth);
        free(memory);
    }
}

// ---- how visibility changes ------------------------------------------------------------------

// Whether rays from all of a grid of points around this one agree: within two texels and a half of
// a map of 256 there is no edge, or none that so many points show.
static int is_away_from_edges(const setup *u, const double point[3], const double normal[3],
                              int grid, uint64_t *state)
{
    double least = 1, most = 0;
    for (int n = 0; n < grid * grid; n++) {
        const double off = 0.08 / (grid - 1);
        const double p[3] = {point[0] + off * (n % grid - grid / 2), point[1],
                             point[2] + off * (n / grid - grid / 2)};
        const double v = scene_visibility(&u->scene, &u->light, p, normal, 1, state);
        least = fmin(least, v);
        most = fmax(most, v);
    }
    return least >= most;
}

// Without size a light casts the filtered hard shadow: all or nothing a texel or two off any edge.
static void a_light_without_size_casts_a_hard_shadow(void)
{
    uint64_t state = 10;
    int counted = 0;
    for (int s = 0; s < SCENE_COUNT; s++) {
        setup u;
        setup_scene(&u, s, 0, usual_side());
        for (int i = 0; i < test_trials(400); i++) {
            double point[3], normal[3];
            scene_receiver(&u.scene, &state, point, normal);
            if (u.scene.ground_casts || point[1] > u.scene.ground)
                continue; // the ground has no texels
            const double exact = scene_visibility(&u.scene, &u.light, point, normal, 1, &state);
            const double v = visibility(&u, NULL, point);
            if (!is_away_from_edges(&u, point, normal, 3, &state)) continue;
            counted++;
            // Three by three points may miss a leaf seen edge-on.
            CHECK(usual_side() < 256 || fabs(v - exact) < 0.02 ||
                      !is_away_from_edges(&u, point, normal, 33, &state),
                  "%s: %g, truth %g", u.scene.name, v, exact);
        }
        setup_free(&u);
    }
    test_note("%d receivers away from edges", counted);
}

// Under the middle of a plate a larger light is seen more, beyond its edge less.
static void a_larger_light_softens_monotonically(void)
{
    double umbra = 0, lit = 1, worst = 0;
    for (int i = 0; i <= 60; i++) {
        setup u;
        memset(&u, 0, sizeof u);
        scene_add_box(&u.scene, 0, 1, 0, 0.5, 0.02, 0.5);
        u.scene.sun[1] = 1;
        scene_finish(&u.scene);
        CHECK(scene_light(&u.scene, 0.02 * i, 0.02 * i, &u.light) == MSSM_OK, "light");
        setup_map(&u, 64, 1, 6, 0);
        const double under[3] = {0, 0, 0}, beside[3] = {0.7, 0, 0};
        const double a = visibility(&u, NULL, under), b = visibility(&u, NULL, beside);
        if (0.02 * i < 1.1)
            worst = fmax(worst, b - lit); // past that the plate falls into the middle
        worst = fmax(worst, umbra - a);
        umbra = a;
        lit = b;
        setup_free(&u);
    }
    test_note("largest step back %.4f", worst);
    CHECK(worst < 0.02, "%.4f", worst);
}

// ---- How many texels a penumbra needs (docs/integration.md, "How large a map?") ------------------

// The part of the square [-half,half]^2 that lies where x * n[0] + y * n[1] > least.
static double square_share(const double n[2], double least, double half)
{
    static const double corner[5][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {-1, -1}};
    double p[8][2], area = 0;
    int count = 0;
    for (int i = 0; i < 4; i++) {
        const double *a = corner[i], *b = corner[i + 1];
        const double u = half * (n[0] * a[0] + n[1] * a[1]) - least,
                     v = half * (n[0] * b[0] + n[1] * b[1]) - least;
        if (u > 0) memcpy(p[count++], a, sizeof *p);
        if ((u > 0) == (v > 0)) continue;
        for (int k = 0; k < 2; k++) p[count][k] = a[k] + u / (u - v) * (b[k] - a[k]);
        count++;
    }
    for (int i = 0; i < count; i++) {
        const double *a = p[i], *b = p[(i + 1) % count];
        area += (a[0] * b[1] - b[0] * a[1]) / 8;
    }
    return area;
}

// The guide's.
static double penumbra_texels(const mssm_light *l, int side, double blocker, double receiver)
{
    const double part = l->perspective ? 1 / (blocker * receiver) : 1;
    return (double)l->half_u * (receiver - blocker) * part * side / (double)l->extent_u;
}

// Squared errors across the penumbra that half a plane at height .5 casts on the ground, below a sun or a lamp at
// height 2, as many texels wide on it.
static double edge_error(bool spot, double texels, double turn)
{
    enum { SIDE = 128, SAMPLES = 4, COUNT = SIDE * SIDE * SAMPLES, POINTS = 200 };
    static float z[COUNT];
    const double n[2] = {cos(turn), sin(turn)}, off = 0.2 * sin(9 * turn), height = 0.5;
    const double apart =
        spot ? 2 / (2 - height) : 1; // of points on the ground whose rays are 1 apart there
    const float low[3] = {-1, 0, -1}, high[3] = {1, 0.5f, 1}, up[3] = {0, 1, 0}, at[3] = {0, 2, 0};
    const float axis[3] = {1, 0, 0};
    float corner[4][3] = {{0, 0.5f, 0}, {1, 0.5f, 0}, {0, 0.5f, 1}, {0, 0, 0}}, q[4][3];
    double sum = 0;
    setup u;
    CHECK(!(spot ? mssm_light_spot(&u.light, at, up, axis, 0.6f, 0.5f, 2.5f, 1, 1)
                 : mssm_light_directional(&u.light, up, axis, 1, 1, low, high)),
          "light");
    u.light.half_u =
        (float)(texels / penumbra_texels(&u.light, SIDE, spot ? 2 - height : 0, spot ? 2 : height));
    u.light.half_v = u.light.half_u;
    for (int i = 0; i < 4; i++) CHECK(mssm_light_project(&u.light, corner[i], q[i]), "project");
    const double a = q[1][0] - q[0][0], b = q[2][0] - q[0][0], c = q[1][1] - q[0][1],
                 d = q[2][1] - q[0][1];
    for (int i = 0; i < COUNT; i++) { // where the texel's ray meets the height of the plane
        const double x = (2.0 * (i / SAMPLES % SIDE) + 0.5 + i % 2) / SIDE - 1 - (double)q[0][0],
                     y = (2.0 * (i / SAMPLES / SIDE) + 0.5 + i / 2 % 2) / SIDE - 1 -
                         (double)q[0][1],
                     det = a * d - b * c;
        z[i] =
            n[0] * (d * x - b * y) / det + n[1] * (a * y - c * x) / det > off ? q[0][2] : q[3][2];
    }
    u.memory = allocate(mssm_map_bytes(SIDE, 6));
    CHECK(!mssm_map_init(&u.map, u.memory, mssm_map_bytes(SIDE, 6), SIDE, 6) &&
              !mssm_map_update(u.map, z, NULL, SAMPLES),
          "map");
    // The light's half-size as seen from the ground: at height 1, or where the lamp is.
    const double half = (double)u.light.half_u,
                 wide = half * (spot ? height / 2 : height) * (fabs(n[0]) + fabs(n[1]));
    for (int i = 0; i < POINTS; i++) {
        const double across = wide * (2.0 * i / POINTS - 1), along = 0.2 * sin(40.0 * i);
        const double r =
            apart * (off + across); // across is where the middle's ray meets the plane's height
        const float p[3] = {(float)(n[0] * r - n[1] * along), 0, (float)(n[1] * r + n[0] * along)};
        const double dark = square_share(n, -across * (spot ? 2 / height : 1 / height), half);
        sum +=
            pow((double)mssm_map_visibility_normal(u.map, &u.light, NULL, p, up) - (1 - dark), 2) /
            POINTS;
    }
    free(u.memory);
    return sum;
}

static void penumbras_of_four_texels_are_enough(void)
{
    double before = 1;
    for (int texels = 1; texels <= 16; texels *= 2) {
        double rms[2] = {0, 0};
        for (int i = 0; i < 40; i++)
            rms[i % 2] += edge_error(i % 2, texels, 0.02 + 0.16 * (i / 2)) / 20;
        for (int i = 0; i < 2; i++) rms[i] = sqrt(rms[i]);
        test_note("%2d texels: rms %.4f, of a lamp %.4f", texels, rms[0], rms[1]);
        CHECK(rms[0] < 0.6 * before && rms[1] < 0.6 * before, "%d texels: no gain", texels);
        before = fmax(rms[0], rms[1]);
        if (texels == 4) CHECK(before < 0.02, "4 texels: %.4f", before);
    }
}

// Within a shape, or so close that a map of 256 cannot tell.
static int is_inside(const scene *s, const double p[3])
{
    for (int i = 0; i < s->count; i++) {
        const shape *a = s->shapes + i;
        double along[3], length = 0, most = -1;
        for (int k = 0; k < 3; k++) {
            along[k] = 0;
            for (int m = 0; m < 3; m++) along[k] += a->axis[k][m] * (p[m] - a->centre[m]);
            length += pow(p[k] - a->centre[k], 2);
            most = fmax(most, fabs(along[k]) - a->half[k]);
        }
        if (a->kind == SHAPE_BOX ? most < 0.03 : sqrt(length) < a->half[0] + 0.03) return 1;
    }
    return 0;
}

// Along lines on the ground in steps of a quarter texel of 256: the steps of the estimate against those of
// the truth, and of PCSS, whose temporal error is the bar.
static void visibility_does_not_jump(void)
{
    enum { LINES = 3 };
    double layered = 0, rival = 0, largest = 0;
    for (int way = 0; way < SCENE_COUNT * LIGHTS * LINES; way++) {
        setup u;
        uint64_t state = (uint64_t)(100 + way % LINES);
        const double x = test_range(&state, -1, 1), z = test_range(&state, -1, 1);
        const double angle = test_range(&state, 0, 6.28);
        double before[3] = {0, 0, 0};
        int known = 0;
        setup_scene(&u, way / LINES / LIGHTS, tangents[way / LINES % LIGHTS], usual_side());
        const double step = 0.5 * (double)u.light.extent_u / 256;
        for (int i = 0; i < 2 + test_trials(118); i++) {
            const double p[3] = {x + cos(angle) * step * i, 1e-4, z + sin(angle) * step * i};
            const double up[3] = {0, 1, 0};
            uint64_t same = 12; // the truth's noise must not move
            const double now[3] = {scene_visibility(&u.scene, &u.light, p, up, 16, &same),
                                   visibility(&u, NULL, p), percentage_closer(&u, p, 2)};
            if (is_inside(&u.scene, p)) {
                known = 0;
                continue;
            }
            if (known) {
                const double truth = now[0] - before[0];
                layered += pow(now[1] - before[1] - truth, 2);
                rival += pow(now[2] - before[2] - truth, 2);
                largest = fmax(largest, fabs(now[1] - before[1]) - fabs(truth));
            }
            memcpy(before, now, sizeof before);
            known = 1;
        }
        setup_free(&u);
    }
    test_note("error of steps %.2f times that of PCSS, largest excess %.3f", sqrt(layered / rival),
              largest);
    CHECK(!enough(test_trials(120)) || layered < rival, "%g against %g", layered, rival);
    CHECK(largest < 0.15, "a step of %.3f more than the truth's", largest);
}

// ---- lights and maps of other kinds ----------------------------------------------------------

static void spot(setup *u, double half_u, double half_v)
{
    const float down[3] = {0.2f, 1, 0.3f}, axis[3] = {1, 0, 0.2f};
    const float eye[3] = {1, 5, 1.5f};
    CHECK(mssm_light_spot(&u->light, eye, down, axis, 0.7f, 1.5f, 8, (float)half_u,
                          (float)half_v) == MSSM_OK,
          "spot");
}

// Against the truth, and against PCSS with the best of its biases.
static void spot_lights_agree_with_ray_tracing(void)
{
    static const double sizes[3][2] = {{0.1, 0.1}, {0.3, 0.6}, {1, 1}};
    const int receivers = test_trials(200);
    uint64_t state = 13;
    double mean[4] = {0};
    for (int s = 0; s < SCENE_COUNT; s++) {
        setup u;
        scene_make(&u.scene, s);
        spot(&u, 0.1, 0.1);
        setup_map(&u, usual_side(), 1, 6, 0);
        for (int l = 0; l < 3; l++) {
            double squares[4] = {0};
            spot(&u, sizes[l][0], sizes[l][1]);
            for (int i = 0; i < receivers; i++) {
                double point[3], normal[3];
                scene_receiver(&u.scene, &state, point, normal);
                const double truth =
                    scene_visibility(&u.scene, &u.light, point, normal, 12, &state);
                squares[0] += pow(visibility(&u, NULL, point) - truth, 2);
                for (int b = 0; b < 3; b++) {
                    squares[1 + b] += pow(percentage_closer(&u, point, rival_bias[b]) - truth, 2);
                }
            }
            for (int m = 0; m < 4; m++) mean[m] += sqrt(squares[m] / receivers) / (3 * SCENE_COUNT);
        }
        setup_free(&u);
    }
    test_note("mean rms %.4f, PCSS with a bias of 1, 2, 4 texels %.4f %.4f %.4f", mean[0], mean[1],
              mean[2], mean[3]);
    if (!enough(receivers)) return;
    CHECK(mean[0] < 0.1, "%.4f", mean[0]);
    CHECK(mean[0] < 0.8 * fmin(mean[1], fmin(mean[2], mean[3])), "PCSS is as good");
}

// The far plane may lie right at the ground, or a little before it: low things that stand or hang there
// keep their shadows.
static void a_spot_lights_far_plane_may_be_near(void)
{
    static const float far_planes[] = {8, 5.3f, 5.1f, 5.02f, 5, 4.98f};
    const float up[3] = {0, 1, 0}, axis[3] = {1, 0, 0}, eye[3] = {1, 5, 0};
    const double normal[3] = {0, 1, 0};
    enum { RECEIVERS = 400 }; // few give no error to compare
    double best = 1, worst = 0, umbra = 0;
    for (int k = 0; k < 6; k++) {
        setup u;
        uint64_t state = 18;
        memset(&u, 0, sizeof u);
        scene_add_box(&u.scene, 0, -0.05, 0, 3, 0.05, 3);
        scene_add_box(&u.scene, -0.3, 0.05, 0, 0.3, 0.05, 0.4);
        scene_add_box(&u.scene, 0.8, 0.15, 0, 0.4, 0.02, 0.5);
        u.scene.ground_casts = 1;
        u.scene.sun[1] = 1;
        scene_finish(&u.scene);
        CHECK(mssm_light_spot(&u.light, eye, up, axis, 0.6f, 1, far_planes[k], 0.5f, 0.5f) ==
                  MSSM_OK,
              "spot");
        setup_map(&u, usual_side(), 1, 6, 0);
        double squares = 0;
        for (int i = 0; i < RECEIVERS; i++) {
            const double point[3] = {i % 2 ? test_range(&state, -1.1, -0.6)
                                           : test_range(&state, 0.2, 1.4),
                                     0, test_range(&state, -0.6, 0.6)};
            const double truth = scene_visibility(&u.scene, &u.light, point, normal, 12, &state);
            squares += pow(visibility(&u, NULL, point) - truth, 2);
        }
        const double rms = sqrt(squares / RECEIVERS);
        best = fmin(best, rms);
        worst = fmax(worst, rms);
        for (int which = 0; which < 8; which++) {
            mssm_settings settings = {which / 4 ? 4 : 6, (mssm_estimator)(which % 4), 0, 0, 0, 0};
            const double point[3] = {0.8, 0, 0.1};
            umbra = fmax(umbra, visibility(&u, &settings, point));
        }
        setup_free(&u);
    }
    test_note("rms %.4f to %.4f, umbra at most %.4f", best, worst, umbra);
    CHECK(worst < best + 0.01, "the far plane costs accuracy");
    CHECK(usual_side() < 256 || umbra < 0.01, "umbra %.3f", umbra);
}

// With kernels of k texels nothing further than that from the edge of a hard shadow is grey.
static void no_kernel_is_wider_than_asked(void)
{
    setup u;
    memset(&u, 0, sizeof u);
    scene_add_box(&u.scene, 0, 2, 0, 1, 0.02, 1);
    scene_add_box(&u.scene, 0, 2, 0, 2, 0.001, 0.01); // widens the map
    u.scene.sun[1] = 1;
    scene_finish(&u.scene);
    CHECK(scene_light(&u.scene, 0.4, 0.4, &u.light) == MSSM_OK, "light");
    setup_map(&u, 256, 1, 6, 0);
    const double texel = 2 * fmax((double)u.light.extent_u, (double)u.light.extent_v) / 256;
    for (int k = 1; k <= 33; k += 4) {
        const mssm_settings settings = {0, MSSM_LAYERED, 0, 0, k, 0};
        const double off = (0.5 * k + 2) * texel;
        const double inside[3] = {1 - off, 0, 0.3}, outside[3] = {1 + off, 0, 0.3};
        CHECK(visibility(&u, &settings, inside) < 0.02, "%d: %g inside", k,
              visibility(&u, &settings, inside));
        CHECK(visibility(&u, &settings, outside) > 0.98, "%d: %g outside", k,
              visibility(&u, &settings, outside));
    }
    setup_free(&u);
}

// Root mean square error over four scenes of closed meshes with a small light, where the map is
// what limits accuracy.
static double error_of_map(int side, int samples, int with_back)
{
    static const int closed[4] = {0, 1, 2, 8};
    const int receivers = test_trials(300);
    double squares = 0;
    for (int s = 0; s < 4; s++) {
        setup u;
        uint64_t state = 15;
        scene_make(&u.scene, closed[s]);
        CHECK(scene_light(&u.scene, 0.05, 0.05, &u.light) == MSSM_OK, "light");
        setup_map(&u, side, samples, 6, with_back);
        for (int i = 0; i < receivers; i++) {
            double point[3], normal[3];
            scene_receiver(&u.scene, &state, point, normal);
            const double truth = scene_visibility(&u.scene, &u.light, point, normal, 12, &state);
            squares += pow(visibility(&u, NULL, point) - truth, 2);
        }
        setup_free(&u);
    }
    return sqrt(squares / (4 * receivers));
}

static void a_finer_map_is_nearer_to_the_truth(void)
{
    enum { SIDES = 6 };
    static const int sides[SIDES] = {1, 2, 3, 100, 256, 300};
    double rms[SIDES];
    for (int n = 0; n < SIDES; n++) rms[n] = error_of_map(sides[n], 1, 0);
    test_note("rms with sides 1 2 3 100 256 300: %.3f %.3f %.3f %.3f %.3f %.3f", rms[0], rms[1],
              rms[2], rms[3], rms[4], rms[5]);
    if (!enough(test_trials(300))) return;
    CHECK(rms[3] < 0.5 * rms[2] && rms[4] < 0.8 * rms[3] && rms[5] < 1.1 * rms[4], "no gain");
}

// More samples a texel, or front and back faces averaged.
static void better_depth_is_not_wasted(void)
{
    const int side = usual_side();
    const double one = error_of_map(side, 1, 0), four = error_of_map(side, 4, 0);
    const double back = error_of_map(side, 1, 1);
    test_note("rms with 1 sample %.4f, 4 samples %.4f, front and back %.4f", one, four, back);
    if (!enough(test_trials(300))) return;
    CHECK(four < one, "4 samples");
    // Front faces alone have come down from .046 to .035 since back faces were first worth 5% of
    // it, so what is held here is the error itself.
    CHECK(back < one && back < 0.036, "front and back");
}

// Of which a map of front faces has no sides or backs, that a wide light sees: boxes about as high as
// wide, under lights that look as wide, on the ground below.
static void back_faces_halve_the_error_behind_thick_casters(void)
{
    enum { BOXES = 6 };
    const int receivers = test_trials(200), side = usual_side();
    double rms[2] = {0};
    for (int b = 0; b < 2 * BOXES; b++) {
        setup u;
        uint64_t state = 100 + (uint64_t)(b / 2);
        const double turn = test_range(&state, 0, 3), tilt = test_range(&state, 0, 1.5);
        const double axis_0[3] = {cos(turn), 0, sin(turn)};
        const double axis_2[3] = {-sin(turn) * cos(tilt), sin(tilt), cos(turn) * cos(tilt)};
        memset(&u.scene, 0, sizeof u.scene);
        scene_add_box(&u.scene, 0, 0.75, 0, 0.25, 0.22, 0.28);
        scene_turn_last(&u.scene, axis_0, axis_2);
        u.scene.sun[0] = 0.1 * (b / 4);
        u.scene.sun[1] = 1;
        scene_finish(&u.scene);
        CHECK(scene_light(&u.scene, 0.4, 0.4, &u.light) == MSSM_OK, "light");
        setup_map(&u, side, 1, 6, b % 2);
        for (int i = 0; i < receivers; i++) {
            const double a = test_range(&state, 0, 6.2831853), d = test_range(&state, 0, 0.8);
            const double point[3] = {d * cos(a) - 0.75 * u.scene.sun[0], 0, d * sin(a)};
            const double up[3] = {0, 1, 0};
            const double truth = scene_visibility(&u.scene, &u.light, point, up, 20, &state);
            rms[b % 2] += pow(visibility(&u, NULL, point) - truth, 2) / (BOXES * receivers);
        }
        setup_free(&u);
    }
    for (int k = 0; k < 2; k++) rms[k] = sqrt(rms[k]);
    test_note("rms %.3f, with back faces %.3f", rms[0], rms[1]);
    if (enough(receivers)) CHECK(rms[1] < 0.6 * rms[0] && rms[1] < 0.09, "no gain");
}

static void any_number_of_samples_is_one_map(void)
{
    setup one;
    setup_scene(&one, 1, 0.2, 100);
    for (int samples = 2; samples <= 8; samples++) {
        const size_t count = 100 * 100, bytes = mssm_map_bytes(100, 6);
        float *depth = allocate(count * (size_t)samples * sizeof *depth);
        void *memory = allocate(bytes);
        setup many = one;
        for (size_t i = 0; i < count * (size_t)samples; i++)
            depth[i] = one.front[i / (size_t)samples];
        CHECK(mssm_map_init(&many.map, memory, bytes, 100, 6) == MSSM_OK, "init");
        CHECK(mssm_map_update(many.map, depth, NULL, samples) == MSSM_OK, "update");
        uint64_t state = 16;
        for (int i = 0; i < test_trials(300); i++) {
            double point[3], normal[3];
            scene_receiver(&one.scene, &state, point, normal);
            const double a = visibility(&one, NULL, point), b = visibility(&many, NULL, point);
            CHECK(fabs(a - b) < 0.01, "%d equal samples: %g against %g", samples, b, a);
        }
        free(depth);
        free(memory);
    }
    setup_free(&one);
}

// The coarsest level of a small map serves kernels much wider than the map. Its rim stands for as
// much again on each side, and beside that all is lit; seeing nothing gives 1.
static void kernels_wider_than_the_map_see_all_of_it(void)
{
    enum { SIDE = 16 };
    static const float receiver[3] = {0, 0, 0.5f};
    const float kernel =
        0.5f * SIDE * 15 * 0.5f; // half of the one that the plate asks for, in texels
    const double expected = 1 - pow(3 * SIDE / (2.0 * (double)kernel), 2);
    for (int moments = 0; moments <= 6; moments += moments ? 2 : 4) {
        const mssm_settings settings = {.moments = moments};
        float depth[SIDE * SIDE];
        mssm_map *map;
        mssm_light light = {{0}, 0, 15, 15, 1, 1, 0, 2};
        const size_t bytes = mssm_map_bytes(SIDE, 6);
        void *memory = allocate(bytes);
        for (int i = 0; i < 4; i++) light.world_to_shadow[5 * i] = 1;
        for (int i = 0; i < SIDE * SIDE; i++) depth[i] = 0;
        CHECK(mssm_map_init(&map, memory, bytes, SIDE, 6) == MSSM_OK, "init");
        CHECK(mssm_map_update(map, depth, NULL, 1) == MSSM_OK, "update");
        const double v = (double)mssm_map_visibility(map, &light, &settings, receiver);
        CHECK(fabs(v - expected) < 0.15, "%d moments: %.4f instead of %.4f", moments, v, expected);
        free(memory);
    }
}

// Turning the light's axes by a quarter exchanges its half-sizes, and changes nothing else.
static void the_choice_of_axes_does_not_matter(void)
{
    static const float sizes[3][2] = {{0.3f, 0.1f}, {0.4f, 0}, {0.5f, 0.15f}};
    for (int l = 0; l < 3; l++) {
        const float wide = sizes[l][0], slim = sizes[l][1], u[3] = {1, 0, 0}, eye[3] = {1, 6, 2};
        setup a, b;
        scene_make(&a.scene, 0);
        b.scene = a.scene;
        float sun[3], low[3], high[3], v[3];
        for (int i = 0; i < 3; i++) {
            sun[i] = l < 2 ? (float)a.scene.sun[i] : eye[i];
            low[i] = (float)a.scene.low[i];
            high[i] = (float)a.scene.high[i];
        }
        CHECK((l < 2
                   ? mssm_light_directional(&a.light, sun, u, wide, slim, low, high)
                   : mssm_light_spot(&a.light, eye, sun, u, 0.7f, 1.5f, 12, wide, slim)) == MSSM_OK,
              "light");
        for (int i = 0; i < 3; i++) v[i] = a.light.world_to_shadow[4 * i + 1];
        CHECK((l < 2
                   ? mssm_light_directional(&b.light, sun, v, slim, wide, low, high)
                   : mssm_light_spot(&b.light, eye, sun, v, 0.7f, 1.5f, 12, slim, wide)) == MSSM_OK,
              "light");
        setup_map(&a, 128, 1, 6, 0);
        setup_map(&b, 128, 1, 6, 0);
        uint64_t state = 17;
        double worst = 0;
        for (int i = 0; i < test_trials(1000); i++) {
            double point[3], normal[3];
            scene_receiver(&a.scene, &state, point, normal);
            // A little off surfaces: on them, rounding decides what is in front.
            for (int k = 0; k < 3; k++) point[k] += 0.02 * normal[k];
            worst = fmax(worst, fabs(visibility(&a, NULL, point) - visibility(&b, NULL, point)));
        }
        setup_free(&a);
        setup_free(&b);
        test_note("light %d: %.1e", l, worst);
        CHECK(worst < 0.05, "light %d: %.3f", l, worst);
    }
}

// A map of count depths, drawn at random for each texel, under a directional light or a spot. The
// depths' shares are equal. Directional: depth is linear in -y from -1 to 1; spot: at (0, 5, 0),
// from 1 to 5 below it.
static void setup_depths(setup *u, int is_spot, float size, int count, const float *depth,
                         int with_back)
{
    const float up[3] = {0, 1, 0}, x[3] = {1, 0, 0}, eye[3] = {0, 5, 0}, low[3] = {-1, -1, -1},
                high[3] = {1, 1, 1};
    const size_t bytes = mssm_map_bytes(128, 6);
    uint64_t state = 19;
    memset(u, 0, sizeof *u);
    u->side = 128;
    u->front = allocate(128 * 128 * sizeof *u->front);
    u->memory = allocate(bytes);
    for (int i = 0; i < 128 * 128; i++) u->front[i] = depth[(int)test_range(&state, 0, count)];
    CHECK((is_spot ? mssm_light_spot(&u->light, eye, up, x, 0.5f, 1, 5, size, size)
                   : mssm_light_directional(&u->light, up, x, size, size, low, high)) == MSSM_OK,
          "light");
    CHECK(mssm_map_init(&u->map, u->memory, bytes, 128, 6) == MSSM_OK &&
              mssm_map_update(u->map, u->front, with_back ? u->front : NULL, 1) == MSSM_OK,
          "map");
}

// The point on the light's axis that has a depth.
static double visibility_at_depth(const setup *u, const mssm_settings *settings, double depth)
{
    const float *m = u->light.world_to_shadow;
    const double distance = u->light.z_near + (depth + 1) / 2 * (u->light.z_far - u->light.z_near);
    const double point[3] = {0, u->light.perspective ? 5 - distance : (depth - m[14]) / m[6], 0};
    return visibility(u, settings, point);
}

// Before a wall that covers everything: lit up to the depth bias, dark from three times as far on,
// linear between. The bias is 3/4 of a texel's width there; of back faces none, and 2 texels of
// fading.
static void blockers_fade_in_behind_the_bias(void)
{
    const float wall = -0.2f;
    double worst = 0;
    for (int way = 0; way < 6; way++) {
        const int is_spot = way % 2, back = way / 2 == 1, own = way / 2 == 2;
        setup u;
        setup_depths(&u, is_spot, 0.02f, 1, &wall, back);
        const double range = (u.light.z_far - u.light.z_near) / 2,
                     width = is_spot ? 1 + 0.8 / 2 * 4 : 1;
        const double texel = 2 * u.light.extent_u * width / 128 / range;
        mssm_settings settings = {6, MSSM_LAYERED, 0, own ? 0.03f : 0, 0, 1e-4f};
        const double bias = own    ? 0.03
                            : back ? 0
                                   : 0.75 * texel,
                     fade = own    ? 0.06
                            : back ? 2 * texel
                                   : 1.5 * texel;
        for (int i = 1; i < 40; i++) {
            const double behind = i * 0.1 * (bias + fade), t = (behind - bias) / fade;
            const double want = t < 0   ? 1
                                : t > 1 ? 0
                                        : 1 - t,
                         got = visibility_at_depth(&u, &settings, (double)wall + behind);
            worst = fmax(worst, fabs(got - want));
            CHECK(fabs(got - want) < 0.06, "way %d: %.3f at %.2f texels, not %.3f", way, got,
                  behind / texel, want);
        }
        setup_free(&u);
    }
    test_note("to %.3f", worst);
}

// Before the same wall on a plane whose normal is known: 1/2 texel of bias and 3/4 of fading where it
// faces the light, all of both where it rises by two texels of depth in one, linear between. A bias of
// the caller's and the fading of back faces stay.
static void bias_and_fade_follow_the_planes_rise(void)
{
    double worst = 0;
    for (int way = 0; way < 84; way++) {
        const int is_spot = way % 2, own = way / 28 == 1, back = way / 28 == 2;
        const float wall = way % 28 < 14 ? -0.2f : 0.76f;
        const double rise = way / 2 % 7 * 0.4;
        double fade = fmin(0.75 + 0.375 * rise, 1.5), bias = fmin(0.5 + 0.125 * rise, 0.75);
        if (own) bias = fade / 2;
        if (back) {
            bias = 0;
            fade = 2;
        }
        const float normal[3] = {(float)(0.6 * rise), 1, (float)(-0.4 * rise)};
        setup u;
        setup_depths(&u, is_spot, 0.02f, 1, &wall, back);
        const double range = (u.light.z_far - u.light.z_near) / 2,
                     width = is_spot ? 1 + ((double)wall + 1) / 2 * 4 : 1;
        const double texel = 2 * u.light.extent_u * width / 128 / range;
        const mssm_settings settings = {6, MSSM_LAYERED, 0, own ? (float)(bias * texel) : 0,
                                        0, 1e-4f};
        for (double behind = fmax(0.1, 0.5 * rise); behind < 3; behind += 0.1) {
            const double z = (double)wall + behind * texel,
                         distance = u.light.z_near + (z + 1) * range;
            const float *m = u.light.world_to_shadow;
            const float point[3] = {
                0, (float)(is_spot ? 5 - distance : (z - (double)m[14]) / (double)m[6]), 0};
            const double want = 1 - fmax(fmin((behind - bias) / fade, 1), 0),
                         got = (double)mssm_map_visibility_normal(u.map, &u.light, &settings, point,
                                                                  normal);
            worst = fmax(worst, fabs(got - want));
            CHECK(fabs(got - want) < 0.04, "spot %d, rise %.1f: %.3f at %.2f texels, not %.3f",
                  is_spot, rise, got, behind, want);
        }
        setup_free(&u);
    }
    test_note("to %.3f", worst);
}

// A surface through the receiver lies as much behind it as in front. So what lies behind may light
// a receiver by its share, and no more.
static void what_lies_behind_lights_by_its_share_at_most(void)
{
    for (int is_spot = 0; is_spot < 2; is_spot++) {
        for (double z = -0.3; z < 0.3; z += 0.04) {
            for (double behind = 0.05; behind < 0.2; behind += 0.05) {
                const float near = (float)z - 0.4f, far = (float)(z + behind), none = 1;
                const float depth[10] = {near, near, near, near, near, near, far, none, none, none};
                setup u;
                setup_depths(&u, is_spot, is_spot ? 0.5f : 0.4f, 10, depth, 0);
                const double v = visibility_at_depth(&u, NULL, z);
                CHECK(v > 0.3 && v < 0.6, "spot %d, z %.2f, %.2f behind: %.3f, not 0.4 to 0.5",
                      is_spot, z, behind, v);
                setup_free(&u);
            }
        }
    }
}

const test_case visibility_tests[] = {
    {"layered is nearer to the truth than PCSS that reads every texel",
     layered_beats_percentage_closer},
    {"layered has a quarter less error than the published estimators",
     layered_beats_the_published_estimators},
    {"layered keeps up with full back-projection", layered_keeps_up_with_back_projection},
    {"four moments, six and as few as needed differ little", fewer_moments_cost_little},
    {"a lonely plate is lit", a_lonely_plate_is_lit},
    {"an empty map is lit", an_empty_map_is_lit},
    {"points beyond the map are lit", points_beyond_the_map_are_lit},
    {"the umbra is dark, also far behind all casters", the_umbra_is_dark},
    {"a wide flat scene keeps its shadows", a_wide_flat_scene_keeps_its_shadows},
    {"visibility stays in range for any point, light and depth", visibility_stays_in_range},
    {"a light without size casts a hard shadow", a_light_without_size_casts_a_hard_shadow},
    {"a larger light softens monotonically", a_larger_light_softens_monotonically},
    {"penumbras of four texels are enough", penumbras_of_four_texels_are_enough},
    {"visibility does not jump between neighbours", visibility_does_not_jump},
    {"spot lights agree with ray tracing", spot_lights_agree_with_ray_tracing},
    {"a spot light's far plane may be near", a_spot_lights_far_plane_may_be_near},
    {"no kernel is wider than asked for", no_kernel_is_wider_than_asked},
    {"a finer map is nearer to the truth", a_finer_map_is_nearer_to_the_truth},
    {"more samples and back faces are not wasted", better_depth_is_not_wasted},
    {"back faces halve the error behind thick casters",
     back_faces_halve_the_error_behind_thick_casters},
    {"any number of equal samples makes the same map", any_number_of_samples_is_one_map},
    {"the choice of the light's axes does not matter", the_choice_of_axes_does_not_matter},
    {"blockers fade in behind the bias", blockers_fade_in_behind_the_bias},
    {"bias and fade follow the rise of a known plane", bias_and_fade_follow_the_planes_rise},
    {"what lies behind lights by its share at most", what_lies_behind_lights_by_its_share_at_most},
    {"kernels wider than the map see all of it", kernels_wider_than_the_map_see_all_of_it},
    {0, 0}};
