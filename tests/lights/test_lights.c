// Lights of every kind against ray tracing: point lights and their seams, wide lights close to
// their blockers, fitted depth ranges; and falloffs against their definitions.
#include "../support/scenes.h"
#include "../support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 256, FACES = 6 };

static void *allocate(size_t bytes)
{
    void *memory = malloc(bytes);
    if (!memory) abort();
    return memory;
}

static mssm_map *make_map(const scene *s, const mssm_light *light, void *memory)
{
    const size_t bytes = mssm_map_bytes(SIDE, 6);
    float *depth = allocate(SIDE * SIDE * sizeof *depth);
    mssm_map *map = NULL;
    scene_depth(s, light, SIDE, 1, depth, NULL);
    CHECK(!mssm_map_init(&map, memory, bytes, SIDE, 6), "init");
    CHECK(!mssm_map_update(map, depth, NULL, 1), "update");
    free(depth);
    return map;
}

static double seen(const mssm_map *map, const mssm_light *light, const double p[3])
{
    const float q[3] = {(float)p[0], (float)p[1], (float)p[2]};
    return (double)mssm_map_visibility(map, light, NULL, q);
}

// ---- Point lights --------------------------------------------------------------------------------

typedef struct lamp {
    scene s;
    float position[3];
    mssm_light light[FACES];
    mssm_map *map[FACES];
    void *memory;
} lamp;

// Rods and balls all around a light in the middle of a room.
static void make_lamp(lamp *l, float half_width)
{
    const size_t bytes = mssm_map_bytes(SIDE, 6);
    uint64_t state = 31;
    memset(l, 0, sizeof *l);
    for (int i = 0; i < 60; i++) {
        double p[3], r;
        do {
            for (int k = 0; k < 3; k++) p[k] = test_range(&state, -2, 2);
            r = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        } while (r < 0.9);
        scene_add_sphere(&l->s, p[0], p[1], p[2], test_range(&state, 0.05, 0.25));
    }
    l->s.sun[1] = 1;
    scene_finish(&l->s);
    CHECK(!mssm_light_point(l->light, l->position, 0.6f, 6, half_width), "light");
    l->memory = allocate(FACES * bytes);
    for (int i = 0; i < FACES; i++) {
        l->map[i] = make_map(&l->s, &l->light[i], (char *)l->memory + (size_t)i * bytes);
    }
}

static double lamp_seen(const lamp *l, const double p[3])
{
    const mssm_faces f = mssm_point_faces((float)p[0], (float)p[1], (float)p[2]);
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        if (f.weight[i] > 0)
            sum += (double)f.weight[i] * seen(l->map[f.face[i]], &l->light[f.face[i]], p);
    }
    return sum;
}

static double lamp_truth(const lamp *l, const double p[3], uint64_t *state)
{
    const double out[3] = {-p[0], -p[1], -p[2]}; // faces the light
    const mssm_faces f = mssm_point_faces((float)p[0], (float)p[1], (float)p[2]);
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        if (f.weight[i] > 0)
            sum += (double)f.weight[i] *
                   scene_visibility(&l->s, &l->light[f.face[i]], p, out, 16, state);
    }
    return sum;
}

// A receiver on the walls of the room, or free in it.
static void point_lights_agree_with_ray_tracing(void)
{
    static const float widths[2] = {0.05f, 0.3f};
    const int receivers = test_trials(600);
    uint64_t state = 5;
    for (int w = 0; w < 2; w++) {
        lamp l;
        double squares = 0;
        make_lamp(&l, widths[w]);
        for (int i = 0; i < receivers; i++) {
            double p[3];
            for (int k = 0; k < 3; k++) p[k] = test_range(&state, -2.6, 2.6);
            p[i % 3] = test_uniform(&state) < 0.5 ? -2.6 : 2.6;
            squares += pow(lamp_seen(&l, p) - lamp_truth(&l, p, &state), 2);
        }
        const double rms = sqrt(squares / receivers);
        test_note("half-width %.2f: rms %.4f", (double)widths[w], rms);
        CHECK(receivers < 100 || rms < 0.06, "half-width %.2f: rms %.4f", (double)widths[w], rms);
        free(l.memory);
    }
}

// Along lines across edges and corners of the cube no step is larger than elsewhere.
static void point_lights_have_no_seams(void)
{
    lamp l;
    double across = 0, elsewhere = 0;
    uint64_t state = 7;
    const int lines = test_trials(300);
    make_lamp(&l, 0.3f);
    for (int i = 0; i < lines; i++) {
        double p[3], v[2];
        for (int k = 0; k < 3; k++) p[k] = test_range(&state, -2.4, 2.4);
        const int a = i % 3, b = (i + 1) % 3;
        p[a] = 2.5;
        p[b] = p[b] < 0 ? -2.5 : 2.5;
        for (int end = 0; end < 2; end++) { // 1 mm on either side of the edge's middle
            double q[3] = {p[0], p[1], p[2]};
            q[a] += end ? 1e-3 : -1e-3;
            v[end] = lamp_seen(&l, q);
        }
        across = fmax(across, fabs(v[1] - v[0]));
        for (int end = 0; end < 2; end++) {
            double q[3] = {p[0], p[1], p[2]};
            q[b] *= 0.6;
            q[a] += end ? 1e-3 : -1e-3;
            v[end] = lamp_seen(&l, q);
        }
        elsewhere = fmax(elsewhere, fabs(v[1] - v[0]));
    }
    test_note("largest step over 2 mm: %.4f across edges, %.4f elsewhere", across, elsewhere);
    CHECK(across < 0.05, "a seam of %.4f", across);
    free(l.memory);
}

// No receiver that asks a face searches outside of its map.
static void point_light_faces_cover_all_kernels(void)
{
    const float zero[3] = {0, 0, 0};
    uint64_t state = 9;
    for (int i = 0; i < test_trials(20000); i++) {
        mssm_light light[FACES];
        const float z_near = (float)test_range(&state, 0.05, 2), z_far = z_near + 6;
        const float half = (float)test_range(&state, 0, 1);
        float p[3], length = 0, sum = 0;
        CHECK(!mssm_light_point(light, zero, z_near, z_far, half), "light");
        for (int k = 0; k < 3; k++) {
            p[k] = (float)test_range(&state, -z_far, z_far);
            length = fmaxf(length, fabsf(p[k]));
        }
        const mssm_faces f = mssm_point_faces(p[0], p[1], p[2]);
        for (int k = 0; k < 3; k++) {
            sum += f.weight[k];
            if (!(f.weight[k] > 0)) continue;
            const mssm_light *l = &light[f.face[k]];
            float at[3];
            const float along = fabsf(p[f.face[k] / 2]);
            CHECK(along >= 0.9f * length && (p[f.face[k] / 2] > 0) == !(f.face[k] & 1), "face");
            CHECK(mssm_light_project(l, p, at), "behind its face");
            const float reach = along > z_near ? half / l->extent_u * (1 / z_near - 1 / along) : 0;
            CHECK(fmaxf(fabsf(at[0]), fabsf(at[1])) + reach <= 1.00001f, "%g + %g",
                  (double)fmaxf(fabsf(at[0]), fabsf(at[1])), (double)reach);
        }
        CHECK(fabsf(sum - 1) < 1e-6f, "weights sum to %g", (double)sum);
    }
    mssm_faces f = mssm_point_faces(0, 0, 0);
    CHECK(fabsf(f.weight[0] + f.weight[1] + f.weight[2] - 1) < 1e-6f, "no direction");
    f = mssm_point_faces(NAN, INFINITY, -INFINITY);
    for (int k = 0; k < 3; k++) CHECK(f.face[k] >= 0 && f.face[k] < FACES, "face %d", f.face[k]);
}

// ---- A wide light close to its blockers ----------------------------------------------------------

// A light as wide as it is far from a ball: the penumbra is wider than the ball and has no core.
static void wide_lights_near_their_blockers(void)
{
    const float eye[3] = {0, 2, 0}, up[3] = {0, 1, 0}, axis[3] = {1, 0, 0};
    static const float half[3] = {0.15f, 0.4f, 0.8f};
    static const double limit[3] = {0.045, 0.08, 0.085};
    const double normal[3] = {0, 1, 0};
    const int receivers = test_trials(500);
    for (int w = 0; w < 3; w++) {
        scene s;
        mssm_light light;
        uint64_t state = 3;
        double squares = 0;
        memset(&s, 0, sizeof s);
        scene_add_sphere(&s, 0, 1.1, 0, 0.35);
        scene_add_box(&s, 0.9, 0.7, 0.2, 0.1, 0.3, 0.4);
        scene_add_sphere(&s, -0.7, 0.9, -0.5, 0.2);
        s.sun[1] = 1;
        scene_finish(&s);
        CHECK(!mssm_light_spot(&light, eye, up, axis, 2.2f, 0.5f, 2.4f, half[w], half[w]), "light");
        void *memory = allocate(mssm_map_bytes(SIDE, 6));
        mssm_map *map = make_map(&s, &light, memory);
        for (int i = 0; i < receivers; i++) {
            const double p[3] = {test_range(&state, -2, 2), 0, test_range(&state, -2, 2)};
            const double truth = scene_visibility(&s, &light, p, normal, 24, &state);
            squares += pow(seen(map, &light, p) - truth, 2);
        }
        const double rms = sqrt(squares / receivers);
        test_note("half-width %.2f at 0.55 from the blocker: rms %.4f", (double)half[w], rms);
        CHECK(receivers < 100 || rms < limit[w], "half-width %.2f: rms %.4f", (double)half[w], rms);
        free(memory);
    }
}

// ---- Frusta that fit -----------------------------------------------------------------------------

static mssm_light scene_spot(float half)
{
    const float down[3] = {0.2f, 1, 0.3f}, axis[3] = {1, 0, 0.2f}, eye[3] = {1, 5, 1.5f};
    mssm_light light;
    CHECK(!mssm_light_spot(&light, eye, down, axis, 0.7f, 1.5f, 8, half, half), "spot");
    return light;
}

// Fitting changes depth and nothing else: same x and y, depths from -0.99 to 0.8, same w.
static void fitting_maps_the_drawn_range(void)
{
    static float depth[2][SIDE * SIDE];
    for (int which = 0; which < SCENE_COUNT; which++) {
        for (int spot = 0; spot < 2; spot++) {
            scene s;
            mssm_light whole = scene_spot(0.3f), fitted;
            float low = 0, high = 0;
            scene_make(&s, which);
            if (!spot) CHECK(!scene_light(&s, 0.2, 0.2, &whole), "light");
            scene_depth(&s, &whole, SIDE, 1, depth[0], NULL);
            CHECK(mssm_depth_range(depth[0], SIDE * SIDE, &low, &high), "%s: nothing drawn",
                  s.name);
            fitted = whole;
            CHECK(!mssm_light_fit(&fitted, low, high), "%s: fit", s.name);
            scene_depth(&s, &fitted, SIDE, 1, depth[1], NULL);
            CHECK(mssm_depth_range(depth[1], SIDE * SIDE, &low, &high), "%s: nothing left", s.name);
            CHECK(fabsf(low + 0.99f) < 2e-3f && fabsf(high - 0.8f) < 2e-3f, "%s: %g to %g", s.name,
                  (double)low, (double)high);
            for (int i = 0; i < SIDE * SIDE; i++) {
                CHECK((depth[0][i] < 1) == (depth[1][i] < 1), "%s: texel %d", s.name, i);
            }
            const float p[3] = {0.3f, 0.1f, -0.2f};
            float a[3], b[3];
            CHECK(mssm_light_project(&whole, p, a) && mssm_light_project(&fitted, p, b), "project");
            CHECK(fabsf(a[0] - b[0]) + fabsf(a[1] - b[1]) < 1e-6f, "%s: moved", s.name);
        }
    }
}

// Receivers search from the nearest caster on: less error, fewer levels.
static void fitting_does_not_cost_accuracy(void)
{
    static float depth[SIDE * SIDE];
    const int receivers = test_trials(300);
    void *memory = allocate(mssm_map_bytes(SIDE, 6));
    double squares[2] = {0, 0};
    for (int which = 0; which < SCENE_COUNT; which++) {
        scene s;
        mssm_light light[2] = {scene_spot(0.6f), scene_spot(0.6f)};
        float low = 0, high = 0;
        scene_make(&s, which);
        scene_depth(&s, &light[0], SIDE, 1, depth, NULL);
        CHECK(mssm_depth_range(depth, SIDE * SIDE, &low, &high), "nothing drawn");
        CHECK(!mssm_light_fit(&light[1], low, high), "fit");
        for (int f = 0; f < 2; f++) {
            uint64_t state = 5;
            mssm_map *map = make_map(&s, &light[f], memory);
            for (int i = 0; i < receivers; i++) {
                double p[3], n[3];
                scene_receiver(&s, &state, p, n);
                const double truth = scene_visibility(&s, &light[f], p, n, 12, &state);
                squares[f] += pow(seen(map, &light[f], p) - truth, 2);
            }
        }
    }
    const double rms[2] = {sqrt(squares[0] / (SCENE_COUNT * receivers)),
                           sqrt(squares[1] / (SCENE_COUNT * receivers))};
    test_note("rms %.4f with the planes as set up, %.4f fitted", rms[0], rms[1]);
    CHECK(receivers < 100 || rms[1] < rms[0], "%.4f against %.4f", rms[1], rms[0]);
    free(memory);
}

// ---- Falloffs and arguments ----------------------------------------------------------------------

static void falloffs(void)
{
    uint64_t state = 2;
    for (int i = 0; i < test_trials(10000); i++) {
        const double d = test_range(&state, 0, 50), c = test_range(&state, 0, 2),
                     l = test_range(&state, 0, 2), q = test_range(&state, 0.01, 2);
        const double want = 1 / (c + l * d + q * d * d);
        const double got = (double)mssm_attenuation((float)d, (float)c, (float)l, (float)q);
        CHECK(fabs(got - want) < 1e-5 * want, "%g, not %g", got, want);
        const double outer = test_range(&state, -0.5, 0.9),
                     inner = test_range(&state, outer + 0.05, 1);
        const double x = test_range(&state, -1, 1), y = x + 1e-4;
        const double a = (double)mssm_cone((float)x, (float)inner, (float)outer, 2),
                     b = (double)mssm_cone((float)y, (float)inner, (float)outer, 2);
        CHECK(a >= 0 && a <= 1 && (x > outer || a == 0), "cone(%g) = %g", x, a);
        CHECK(x < inner || fabs(a - (x > 0 ? x * x : 0)) < 1e-5, "inside: cone(%g) = %g", x, a);
        CHECK(fabs(b - a) < 0.02, "a step of %g at %g", b - a, x);
        CHECK(x < 0 || b >= a - 1e-6, "cone falls towards the axis at %g", x);
    }
    CHECK(mssm_attenuation(0, 0, 0, 1) == 0, "at the light itself");
}

// From finite numbers of any size and sign.
static void cones_are_shares(void)
{
    static const float ends[] = {0,    1e-37f, 1e-30f,  1e-3f, 0.5f, 1,     1.5f,
                                 4e4f, 3e38f,  -1e-37f, -0.4f, -1,   -4e4f, -3e38f};
    enum { ENDS = sizeof ends / sizeof *ends };
    for (int i = 0; i < ENDS * ENDS * ENDS * ENDS; i++) {
        const float cosine = ends[i % ENDS], inner = ends[i / ENDS % ENDS],
                    outer = ends[i / ENDS / ENDS % ENDS], exponent = ends[i / ENDS / ENDS / ENDS];
        const float share = mssm_cone(cosine, inner, outer, exponent);
        CHECK(share >= 0 && share <= 1, "cone(%g, %g, %g, %g) = %g", (double)cosine, (double)inner,
              (double)outer, (double)exponent, (double)share);
        if (outer >= inner || fmin((double)cosine, 1) < (double)inner) continue;
        const double x = fmin(fmax((double)cosine, 0), 1);
        const double want = exponent > 0 ? pow(x, (double)exponent) : 1;
        CHECK(fabs((double)share - want) < 1e-6, "cone(%g, %g, %g, %g) = %g", (double)cosine,
              (double)inner, (double)outer, (double)exponent, (double)share);
    }
}

// Columns below a sun whose box follows a camera: at fixed points visibility stays what it was,
// where without the help it changes with each step.
static void boxes_that_follow_do_not_crawl(void)
{
    enum { STEPS = 6, POINTS = 400 };
    static float was[2][POINTS];
    const float sun[3] = {0.5f, 1, 0.3f}, axis[3] = {1, 0, 0};
    scene s = {0};
    double crawl[2] = {0, 0}, moved = 0;
    for (int i = 0; i < 25; i++) scene_add_box(&s, i % 5 - 2, 0.5, i / 5 - 2, 0.06, 0.5, 0.06);
    scene_finish(&s);
    void *memory = allocate(mssm_map_bytes(SIDE, 6));
    for (int step = 0; step < STEPS; step++) {
        const float x = 0.0137f * (float)step, z = -0.0091f * (float)step;
        const float low[3] = {-4 + x, -0.2f, -4 + z}, high[3] = {4 + x, 1.4f, 4 + z};
        mssm_light light[2];
        CHECK(!mssm_light_directional(&light[0], sun, axis, 0.01f, 0.01f, low, high), "light");
        light[1] = light[0];
        CHECK(!mssm_light_snap(&light[1], SIDE), "snap");
        for (int i = 12; i < 14; i++) {
            const double off =
                fabs((double)light[1].world_to_shadow[i] - (double)light[0].world_to_shadow[i]);
            moved = off > moved ? off : moved;
        }
        for (int k = 0; k < 2; k++) {
            mssm_map *map = make_map(&s, &light[k], memory);
            for (int i = 0; i < POINTS; i++) {
                const double p[3] = {-2 + 4 * (i % 20 + 0.5) / 20, 0, -2 + 4 * (i / 20 + 0.5) / 20};
                const float v = (float)seen(map, &light[k], p);
                const double off = fabs((double)v - (double)was[k][i]);
                if (step > 0 && off > crawl[k]) crawl[k] = off;
                was[k][i] = v;
            }
        }
    }
    free(memory);
    test_note("visibility moves by %.3f from step to step, snapped by %.4f", crawl[0], crawl[1]);
    CHECK(crawl[0] > 0.05 && crawl[1] < 0.005, "%g and %g", crawl[0], crawl[1]);
    CHECK(moved > 0.1 / SIDE && moved <= 1.000001 / SIDE, "moved by %g texels", moved * SIDE / 2);
}

// Texels lie on one lattice of the world wherever the box is.
static void snapped_texels_are_a_lattice(void)
{
    uint64_t state = 15;
    for (int trial = 0; trial < 2000; trial++) {
        const int side =
            trial % 3 ? 1 << test_random(&state) % 12 : 1 + (int)(test_random(&state) % 2000);
        float direction[3], axis[3], low[3], high[3];
        mssm_light light, kept;
        for (int i = 0; i < 3; i++) {
            direction[i] = (float)test_range(&state, -1, 1);
            axis[i] = (float)test_range(&state, -1, 1);
            low[i] = (float)test_range(&state, -100, 100);
            high[i] = low[i] + (float)test_range(&state, 0.1, 20);
        }
        if (mssm_light_directional(&kept, direction, axis, 0.1f, 0.1f, low, high)) continue;
        light = kept;
        CHECK(!mssm_light_snap(&light, side), "trial %d", trial);
        for (int i = 12; i < 14; i++) {
            const double now = (double)light.world_to_shadow[i],
                         before = (double)kept.world_to_shadow[i];
            const double corner = (now + 1) * side / 2;
            CHECK(fabs(corner - floor(corner + 0.5)) <=
                      (trial % 3 ? 0 : 1e-7 * side * (1 + fabs(now))),
                  "trial %d: corner %.9g", trial, corner);
            CHECK(fabs(now - before) <= (1 + 2e-7 * side * (1 + fabs(now))) / side,
                  "trial %d: moved by %g", trial, now - before);
            kept.world_to_shadow[i] = light.world_to_shadow[i];
        }
        CHECK(!memcmp(&kept, &light, sizeof light), "trial %d: something else has changed", trial);
    }
}

// To the last bit, from the smallest denormal number on.
static void directions_may_have_any_length(void)
{
    const float low[3] = {-1, -2, -3}, high[3] = {3, 2, 1};
    mssm_light unit[3];
    for (int k = 0; k >= -147; k--) {
        mssm_light l[3];
        float to_light[3] = {0.5f, 1, -0.25f}, axis_u[3] = {1, -0.5f, 0.25f};
        for (int i = 0; i < 3; i++) {
            to_light[i] = ldexpf(to_light[i], k % 2 ? -k - 21 : k);
            axis_u[i] = ldexpf(axis_u[i], k);
        }
        CHECK(!mssm_light_directional(&l[0], to_light, axis_u, 0.1f, 0.2f, low, high) &&
                  !mssm_light_spot(&l[1], low, to_light, axis_u, 1, 1, 9, 0.1f, 0.2f) &&
                  !mssm_light_area(&l[2], high, to_light, axis_u, 0.1f, 0.2f, 20, low, high),
              "refused at 2^%d", k);
        if (k == 0) memcpy(unit, l, sizeof l);
        CHECK(!memcmp(unit, l, sizeof l), "others at 2^%d", k);
    }
}

static void bad_lights_are_refused(void)
{
    const float zero[3] = {0, 0, 0}, bad[3] = {0, NAN, 0};
    mssm_light six[FACES], kept[FACES], l;
    float low = 7, high = 7;
    memset(six, 3, sizeof six);
    memcpy(kept, six, sizeof six);
    CHECK(mssm_light_point(NULL, zero, 1, 2, 0) && mssm_light_point(six, NULL, 1, 2, 0) &&
              mssm_light_point(six, bad, 1, 2, 0) && mssm_light_point(six, zero, 0, 2, 0) &&
              mssm_light_point(six, zero, 2, 1, 0) && mssm_light_point(six, zero, 1, 2, -1) &&
              mssm_light_point(six, zero, 1, 2, INFINITY),
          "taken");
    CHECK(!memcmp(six, kept, sizeof six), "touched");
    l = scene_spot(0.1f);
    kept[0] = l;
    CHECK(mssm_light_fit(NULL, 0, 1) && mssm_light_fit(&l, 0.5f, 0.4f) &&
              mssm_light_fit(&l, NAN, 0) && mssm_light_fit(&l, -2, 0) && mssm_light_fit(&l, 0, 2),
          "taken");
    CHECK(!memcmp(&l, kept, sizeof l), "touched");
    CHECK(mssm_light_snap(NULL, 64) && mssm_light_snap(&l, 64), "taken");
    CHECK(!memcmp(&l, kept, sizeof l), "touched");
    for (int i = 0; i < 3; i++) {
        l.perspective = 0;
        l.world_to_shadow[12] = i == 1 ? NAN : 0;
        l.world_to_shadow[13] = i == 2 ? INFINITY : 0;
        kept[0] = l;
        CHECK(mssm_light_snap(&l, i > 0) && !memcmp(&l, kept, sizeof l), "snap %d", i);
    }
    const float none[3] = {1, NAN, INFINITY}, some[3] = {1, 0.5f, -0.5f};
    CHECK(!mssm_depth_range(none, 3, &low, &high) && !mssm_depth_range(some, 0, &low, &high) &&
              low == 7 && high == 7,
          "a range of nothing");
    const mssm_light good = scene_spot(0.1f);
    const float ahead[3] = {0, 0, 0};
    float at[3] = {7, 7, 7};
    CHECK(!mssm_depth_range(NULL, 3, &low, &high) && !mssm_depth_range(some, 3, NULL, &high) &&
              !mssm_depth_range(some, 3, &low, NULL) && !mssm_light_project(NULL, ahead, at) &&
              !mssm_light_project(&good, NULL, at) && !mssm_light_project(&good, ahead, NULL) &&
              low == 7 && high == 7 && at[0] == 7,
          "no pointers");
    CHECK(mssm_light_project(&good, ahead, at), "ahead");
    CHECK(mssm_light_depth(NULL, 0.5f, 0) == 1, "depth without a light");
    CHECK(mssm_depth_range(some, 3, &low, &high) && low == -0.5f && high == 0.5f, "range");
    // A diagonal of 8.5e38 leaves float; half of it does where the range is opened to 1.12 times.
    const float up[3] = {0, 1, 0}, across[3] = {1, 0, 1}, ends[3] = {3e38f, 0, 3e38f},
                starts[3] = {-3e38f, 0, -3e38f}, tall[3] = {1, 3e38f, 1};
    l = scene_spot(0.1f);
    memcpy(kept, &l, sizeof l);
    CHECK(mssm_light_directional(&l, up, across, 0.1f, 0.1f, starts, ends) &&
              !memcmp(&l, kept, sizeof l),
          "a box beyond float");
    CHECK(!mssm_light_directional(&l, up, across, 0.1f, 0.1f, zero, tall), "a tall box");
    kept[0] = l;
    CHECK(mssm_light_fit(&l, -1, 1) && !memcmp(&l, kept, sizeof l), "a range beyond float: %g",
          (double)l.z_far);
}

// Depth of what a GPU stores is what mssm_light_project says of the same point; in [-1,1], whatever
// is stored.
static void stored_depth_is_that_of_the_point(void)
{
    const float low[3] = {-2, -1, -2}, high[3] = {2, 2, 2}, to_light[3] = {0.3f, 1, 0.45f},
                axis[3] = {1, 0, 0};
    const float eye[3] = {1, 5, 1.5f}, odd[] = {-1, 2, NAN, INFINITY, -INFINITY, 1e-38f, 0, 1};
    const int count = test_trials(20000);
    mssm_light light[2];
    double worst = 0;
    uint64_t seed = 71;
    CHECK(!mssm_light_directional(&light[0], to_light, axis, 0.1f, 0.1f, low, high) &&
              !mssm_light_spot(&light[1], eye, to_light, axis, 0.7f, 0.05f, 20, 0.1f, 0.1f),
          "lights");
    for (int i = 0; i < count; i++) {
        const mssm_light *l = &light[i % 2];
        const double n = (double)l->z_near, f = (double)l->z_far, w = test_range(&seed, n, f);
        const double z = -1 + 2 * (w - n) / (f - n),
                     far = i % 2 ? f / (f - n) * (1 - n / w) : 0.5 + 0.5 * z;
        const double off = fabs((double)mssm_light_depth(l, (float)(1 - far), 1) - z);
        worst = fmax(worst, off);
        // A normal one has lost what floats next to 1 cannot hold: 6e-8 of it, times the slope.
        const double slope = i % 2 ? 2 * w * w / n / f : 2;
        const double coarse = fabs((double)mssm_light_depth(l, (float)far, 0) - z);
        CHECK(coarse <= 2e-6 + 6e-8 * slope, "depth %.9g is off by %g", z, coarse);
    }
    test_note("reversed depth is right to %.2g", worst);
    CHECK(worst < 1e-6, "reversed depth is off by %g", worst);
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        for (int k = 0; k < 4; k++) {
            const float z = mssm_light_depth(&light[k % 2], odd[i], k / 2);
            CHECK(z >= -1 && z <= 1, "%g: %g", (double)odd[i], (double)z);
        }
    }
    CHECK(mssm_light_depth(&light[1], 1, 0) == 1 && mssm_light_depth(&light[1], 0, 1) == 1 &&
              mssm_light_depth(&light[1], 0, 0) == -1 && mssm_light_depth(&light[0], 1, 1) == -1 &&
              mssm_light_depth(&light[0], 0.25f, 0) == -0.5f,
          "ends");
}

// Ranges of no width, next to the light, and where numbers end.
static void fitting_holds_at_its_ends(void)
{
    const float up[3] = {0, 1, 0}, axis[3] = {1, 0, 0}, low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};
    mssm_light l = scene_spot(0.1f), kept;
    CHECK(!mssm_light_fit(&l, 0.2f, 0.2f) && l.z_far > l.z_near, "one depth");
    l = scene_spot(0.1f);
    l.z_near = 0.01f;
    CHECK(!mssm_light_fit(&l, -1, 1) && fabs((double)l.z_near - 0.005) < 1e-8 && l.z_far > 1,
          "%g to %g next to it", (double)l.z_near, (double)l.z_far);
    CHECK(mssm_light_fit(&l, 0, NAN), "an end that is no number");
    CHECK(!mssm_light_directional(&l, up, axis, 0, 0, low, high), "light");
    for (int i = 0; i < 3; i++) {
        kept = l;
        if (i == 0) kept.z_far = kept.z_near;
        if (i == 1) kept.world_to_shadow[2] = 3e38f;           // divided by a small range
        if (i == 2) kept.z_near = 1e8f, kept.z_far = 1e8f + 8; // steps of 8 cannot hold less
        mssm_light fitted = kept;
        CHECK(mssm_light_fit(&fitted, 0.2f, 0.2f), "case %d is taken", i);
        CHECK(!memcmp(&fitted, &kept, sizeof kept), "case %d is touched", i);
    }
    CHECK(strstr(mssm_glsl_lights(), "float mssm_cone("), "GLSL text");
}

const test_case lights_tests[] = {
    {"point lights agree with ray tracing", point_lights_agree_with_ray_tracing},
    {"point lights have no seams", point_lights_have_no_seams},
    {"point light faces cover all kernels", point_light_faces_cover_all_kernels},
    {"wide lights near their blockers agree with ray tracing", wide_lights_near_their_blockers},
    {"a fitted light maps the drawn range and nothing else", fitting_maps_the_drawn_range},
    {"a fitted light is no less accurate", fitting_does_not_cost_accuracy},
    {"lights: stored depth is that of the point", stored_depth_is_that_of_the_point},
    {"a fitted light holds at the ends of its range", fitting_holds_at_its_ends},
    {"boxes that follow the camera do not crawl", boxes_that_follow_do_not_crawl},
    {"snapped texels are a lattice of the world", snapped_texels_are_a_lattice},
    {"falloffs are what they say", falloffs},
    {"cones of any finite numbers are shares", cones_are_shares},
    {"lights: directions may have any length", directions_may_have_any_length},
    {"bad lights are refused, and left alone", bad_lights_are_refused},
    {0, 0}};
