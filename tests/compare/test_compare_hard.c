// What the chart's section on filtered hard shadows rests on: the truth against closed forms, and
// the methods against sums over all texels. Apart from test_compare.c, which has scenes of another
// kind.
#include "cases.h"
#include "../support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 64 };

// The Gaussian, once more: standard deviation radius / 2, cut off at the radius.
static double tap(int i, int radius)
{
    double sum = 0;
    for (int k = -radius; k <= radius; k++) sum += exp(-2.0 * k * k / (radius * radius));
    return abs(i) > radius ? 0 : exp(-2.0 * i * i / (radius * radius)) / sum;
}

// Its share on one side of an edge d texels away, its taps joined by straight lines.
static double share_below(double d, int radius)
{
    double sum = 0;
    for (int i = -radius; i <= radius; i++) {
        const double t = fmin(fmax(d - i, -1), 1);
        sum += tap(i, radius) * (t < 0 ? 0.5 * (1 + t) * (1 + t) : 1 - 0.5 * (1 - t) * (1 - t));
    }
    return sum;
}

// ---- the truth ---------------------------------------------------------------------------------

// The casters: a plate that ends at z = 0, and what receives.
typedef enum stage { GROUND, BOWL, STEP } stage;

static float bowl(float z)
{
    return 0.4f * z * z;
}

static void make_stage(compare_case *c, stage kind)
{
    const scene_frame plate = scene_frame_at(vec(0, kind == STEP ? 0.02f : 1.5f, -2), 0, 0);
    memset(c, 0, sizeof *c);
    scene_begin_object(&c->scene, 0.5f, 0.5f, 0.5f);
    scene_put_box(&c->scene, &plate, vec(2, 0.02f, 2));
    for (int i = 0; i <= 80 && kind == BOWL; i++) {
        const float z = 0.05f * (float)(i - 40);
        const int v = scene_put_vertex(&c->scene, vec(-2, bowl(z), z), vec(0, 1, 0));
        scene_put_vertex(&c->scene, vec(2, bowl(z), z), vec(0, 1, 0));
        if (i > 0) scene_put_triangle(&c->scene, v - 2, v, v + 1);
        if (i > 0) scene_put_triangle(&c->scene, v - 2, v + 1, v - 1);
    }
    CHECK(scene_end(&c->scene), "no memory");
    c->tree = bvh_create(&c->scene);
    c->ground = kind == BOWL ? (float)NAN : 0;
}

// How many texels of the map a receiver stands outside the plate's shadow.
static double texels_outside(const mssm_light *light, vec3 p, float height)
{
    const float edge[3] = {0, height, 0}, beside[3] = {0, height, 1}, point[3] = {p.x, p.y, p.z};
    float a[3], b[3], at[3];
    CHECK(mssm_light_project(light, edge, a) && mssm_light_project(light, beside, b) &&
              mssm_light_project(light, point, at),
          "project");
    return 0.5 * SIDE * (b[1] > a[1] ? 1 : -1) * ((double)at[1] - (double)a[1]);
}

// Receivers across the edge of the shadow; those of the step stand outside of what casts it.
static int place_receivers(receiver *r, stage kind, float middle, float reach)
{
    int count = 0;
    for (int i = 0; i < 60; i++) {
        const float z = middle + reach * (2 * (float)i / 59 - 1);
        if (kind == STEP && z < 1e-3f) continue;
        r[count].point = vec(0.01f * (float)(i % 9), kind == BOWL ? bowl(z) : 0, z);
        r[count++].normal = vec_unit(vec(0, 1, kind == BOWL ? -0.8f * z : 0));
    }
    return count;
}

static void check_truth(stage kind, int radius, const float sun[3])
{
    static const float axis[3] = {1, 0, 0}, low[3] = {-2, 0, -2}, high[3] = {2, 2, 2};
    const float height = kind == STEP ? 0.04f : 1.48f; // where the shadow's edge comes from
    compare_case c;
    mssm_light light;
    receiver r[60];
    double worst = 0, gauss = 0;
    make_stage(&c, kind);
    CHECK(!mssm_light_directional(&light, sun, axis, 0, 0, low, high), "light");
    const float reach = 2.6f * light.extent_v / SIDE * (float)(radius + 1);
    const int count = place_receivers(r, kind, -height * sun[2] / sun[1], reach);
    case_truth_filtered(&c, &light, SIDE, radius, count, 1024, 5, r);
    for (int i = 0; i < count; i++) {
        const double d = texels_outside(&light, r[i].point, height);
        const double wide = sqrt(2 * (0.25 * radius * radius + 1.0 / 6));
        worst = fmax(worst, fabs((double)r[i].truth - share_below(d, radius)));
        gauss = fmax(gauss, fabs((double)r[i].truth - 0.5 * erfc(-d / wide)));
    }
    test_note("stage %d, radius %d, sun %g: off by %.4f, from a Gaussian's integral by %.4f",
              (int)kind, radius, (double)sun[2], worst, gauss);
    CHECK(worst < 0.02, "stage %d, radius %d, sun %g: off by %g", (int)kind, radius, (double)sun[2],
          worst);
    CHECK(radius < 4 || gauss < 0.04, "stage %d: %g off a Gaussian", (int)kind, gauss);
    case_free(&c);
}

static void truth_is_the_kernels_share(void)
{
    static const float suns[2][3] = {{0, 1, 0}, {0, 1, 0.5f}};
    for (int radius = 1; radius <= 4; radius += 3) {
        for (int k = 0; k < 2; k++) {
            check_truth(GROUND, radius, suns[k]);
            check_truth(BOWL, radius, suns[k]);
        }
        check_truth(STEP, radius, suns[0]);
    }
}

// ---- the methods -------------------------------------------------------------------------------

typedef struct setup {
    mssm_light light;
    float front[SIDE * SIDE];
} setup;

static void open_setup(setup *s)
{
    static const float sun[3] = {0.3f, 1, 0.2f}, axis[3] = {1, 0.1f, -0.3f};
    static const float low[3] = {-2, 0, -1.5f}, high[3] = {2, 3, 1.5f};
    CHECK(!mssm_light_directional(&s->light, sun, axis, 0, 0, low, high), "light");
}

static void *make_hard(const setup *s, int which, int radius)
{
    const depth_map map = {&s->light, SIDE, s->front, NULL};
    method m = hard_methods[which];
    size_t bytes = 0;
    m.variant = radius;
    void *state = m.create(&m, SIDE, &bytes);
    CHECK(state && bytes > 0, "%s: no state", m.name);
    m.update(state, &map);
    return state;
}

// The world-space point at that place of the map, in texels, and that depth.
static void point_at(const setup *s, double x, double y, double z, float point[3])
{
    const double shadow[3] = {-1 + 2 * x / SIDE, -1 + 2 * y / SIDE, z};
    const float *m = s->light.world_to_shadow;
    double sum[3] = {0, 0, 0};
    for (int i = 0; i < 3; i++) {
        const double a = (double)m[i], b = (double)m[4 + i], c = (double)m[8 + i];
        const double along = (shadow[i] - (double)m[12 + i]) / (a * a + b * b + c * c);
        sum[0] += along * a;
        sum[1] += along * b;
        sum[2] += along * c;
    }
    for (int i = 0; i < 3; i++) point[i] = (float)sum[i];
}

// Every tap compared bilinearly: four texels each.
static double brute_force(const setup *s, double x, double y, double z, int radius)
{
    const int left = (int)floor(x - 0.5), low = (int)floor(y - 0.5);
    const double fx = x - 0.5 - left, fy = y - 0.5 - low;
    double blocked = 0;
    for (int j = -radius; j <= radius; j++) {
        for (int i = -radius; i <= radius; i++) {
            for (int k = 0; k < 4; k++) {
                const int u = left + i + k % 2, v = low + j + k / 2;
                const double w = (k % 2 ? fx : 1 - fx) * (k / 2 ? fy : 1 - fy);
                const int inside = u >= 0 && v >= 0 && u < SIDE && v < SIDE;
                if (inside && (double)s->front[v * SIDE + u] < fmin(z, 1))
                    blocked += w * tap(i, radius) * tap(j, radius);
            }
        }
    }
    return 1 - blocked;
}

static void percentage_closer_sums_all_texels(void)
{
    static const int radii[4] = {1, 3, 16, 32};
    const int pcf = (int)(method_named("PCF, Gaussian") - hard_methods);
    uint64_t state = 71;
    double worst = 0;
    static setup s;
    open_setup(&s);
    for (int i = 0; i < SIDE * SIDE; i++)
        s.front[i] = i % 5 ? (float)(0.1 * floor(test_range(&state, -9, 9))) : 1;
    for (int k = 0; k < 4; k++) {
        void *p = make_hard(&s, pcf, radii[k]);
        for (int t = 0; t < test_trials(200) / radii[k] + 4; t++) {
            const double x = test_range(&state, -20, SIDE + 20),
                         y = test_range(&state, -5, SIDE + 5);
            const double z = 0.05 + 0.1 * floor(test_range(&state, -9, 12)); // between depths
            float point[3];
            point_at(&s, x, y, z, point);
            const double seen = (double)hard_methods[pcf].visibility(p, point, 0, 0);
            worst = fmax(worst, fabs(seen - brute_force(&s, x, y, z, radii[k])));
        }
        hard_methods[pcf].destroy(p);
    }
    test_note("off by %.2g at most", worst);
    CHECK(worst < 5e-5, "off by %g", worst);
}

// A half-plane at one depth in front of nothing, receivers far behind it: all methods but the
// first, which has no Gaussian, have its integral. What is cut off against leaks adds to that: 0.05
// for VSM and EVSM, 0.02 for moments of 32-bit floats and by full_shadow.
static void half_planes_have_the_gaussians_edge(void)
{
    static const double limits[] = {0, 0.006, 0.056, 0.056, 0.056, 0.026, 0.026, 0.006, 0.026};
    static setup s;
    open_setup(&s);
    CHECK(hard_method_count == (int)(sizeof limits / sizeof *limits), "%d methods",
          hard_method_count);
    for (int i = 0; i < SIDE * SIDE; i++) s.front[i] = i % SIDE < SIDE / 2 ? -0.4f : 1;
    for (int which = 1; which < hard_method_count; which++) {
        for (int radius = 4; radius <= 8; radius += 4) {
            void *p = make_hard(&s, which, radius);
            double worst = 0;
            for (int i = -30; i <= 30; i++) {
                const double d = 0.04 * i * (radius + 1);
                float point[3];
                point_at(&s, SIDE / 2 + d, 31.3, 0.9, point);
                const double seen = (double)hard_methods[which].visibility(p, point, 1, 0);
                worst = fmax(worst, fabs(seen - share_below(d, radius)));
            }
            hard_methods[which].destroy(p);
            test_note("%-36s radius %d: off by %.4f", hard_methods[which].name, radius, worst);
            CHECK(worst < limits[which], "%s: off by %g", hard_methods[which].name, worst);
        }
    }
}

// Whatever the depths and the points: visibility is a share, and all is lit under an empty map.
static void shares_stay_shares(void)
{
    uint64_t state = 72;
    static setup s;
    open_setup(&s);
    for (int k = 0; k < 2 * hard_method_count; k++) {
        const method *m = &hard_methods[k / 2];
        for (int i = 0; i < SIDE * SIDE; i++)
            s.front[i] = k % 2 ? (float)test_range(&state, -1.2, 1.2) : 1;
        if (k % 2) s.front[0] = (float)NAN;
        void *p = make_hard(&s, k / 2, 1 + 31 * (k % 3) / 2);
        for (int t = 0; t < test_trials(300); t++) {
            float point[3];
            for (int i = 0; i < 3; i++) point[i] = (float)test_range(&state, -5, 5);
            if (t % 50 == 49) point[t % 3] = t % 4 ? (float)NAN : (float)1e30;
            const float seen = m->visibility(p, point, 1, 0);
            CHECK(seen >= (k % 2 ? 0 : 0.999f) && seen <= 1, "%s: %g at %g %g %g", m->name,
                  (double)seen, (double)point[0], (double)point[1], (double)point[2]);
        }
        m->destroy(p);
    }
}

const test_case compare_hard_tests[] = {
    {"truth of filtered hard shadows is the kernel's share", truth_is_the_kernels_share},
    {"percentage-closer filtering by a Gaussian sums all texels",
     percentage_closer_sums_all_texels},
    {"filtered hard shadows give half-planes the Gaussian's edge",
     half_planes_have_the_gaussians_edge},
    {"filtered hard shadows stay shares for any depth and point", shares_stay_shares},
    {0, 0}};
