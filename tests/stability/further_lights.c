// Lights and receivers at their limits, and maps of open meshes.
#include "further.h"

#include "../support/scenes.h"
#include "../support/test.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

enum { SIDE = 128 };

typedef struct setup {
    scene s;
    mssm_light light;
    mssm_map *map;
    void *memory;
    float *front, *back;
} setup;

static void setup_new(setup *u, int which)
{
    const size_t bytes = mssm_map_bytes(SIDE, 6);
    scene_make(&u->s, which);
    u->memory = malloc(bytes);
    u->front = (float *)malloc(SIDE * SIDE * sizeof(float));
    u->back = (float *)malloc(SIDE * SIDE * sizeof(float));
    if (!u->memory || !u->front || !u->back || mssm_map_init(&u->map, u->memory, bytes, SIDE, 6)) {
        abort();
    }
}

static int setup_light(setup *u, double tan_u, double tan_v)
{
    if (scene_light(&u->s, tan_u, tan_v, &u->light)) return 0;
    scene_depth(&u->s, &u->light, SIDE, 1, u->front, u->back);
    return mssm_map_update(u->map, u->front, NULL, 1) == MSSM_OK;
}

static void setup_free(setup *u)
{
    free(u->memory);
    free(u->front);
    free(u->back);
}

static float visibility(const setup *u, mssm_estimator e, const double point[3])
{
    mssm_settings set = {0};
    const float p[3] = {(float)point[0], (float)point[1], (float)point[2]};
    set.estimator = e;
    return mssm_map_visibility(u->map, &u->light, &set, p);
}

static int in_range(float v)
{
    return v >= 0 && v <= 1;
}

// The usual shadow map: one texel, a bias of two texels' worth of depth.
static double hard_shadow(const setup *u, const double point[3])
{
    const float p[3] = {(float)point[0], (float)point[1], (float)point[2]};
    float s[3];
    if (!mssm_light_project(&u->light, p, s)) return 1;
    const int x = (int)floorf((s[0] + 1) * 0.5f * SIDE), y = (int)floorf((s[1] + 1) * 0.5f * SIDE);
    if (x < 0 || y < 0 || x >= SIDE || y >= SIDE) return 1;
    return u->front[y * SIDE + x] < s[2] - 2 * 2.0f / SIDE ? 0 : 1;
}

typedef struct errors {
    double layered, published, hard;
    int bad;
} errors;

// Root mean square errors against ray tracing, over three scenes.
static errors errors_of(double tan_u, double tan_v)
{
    errors e = {0, 0, 0, 0};
    int count = 0;
    for (int which = 0; which < 3; which++) {
        static setup u;
        uint64_t state = 77 + (uint64_t)which;
        setup_new(&u, which);
        if (!setup_light(&u, tan_u, tan_v)) abort();
        for (int i = 0; i < 2000; i++) {
            double p[3], n[3];
            scene_receiver(&u.s, &state, p, n);
            const double truth = scene_visibility(&u.s, &u.light, p, n, 12, &state);
            const float a = visibility(&u, MSSM_LAYERED, p);
            const float b = visibility(&u, MSSM_LOWER_BLOCKER, p);
            e.bad += !in_range(a) || !in_range(b);
            e.layered += pow((double)a - truth, 2);
            e.published += pow((double)b - truth, 2);
            e.hard += pow(hard_shadow(&u, p) - truth, 2);
            count++;
        }
        setup_free(&u);
    }
    e.layered = sqrt(e.layered / count);
    e.published = sqrt(e.published / count);
    e.hard = sqrt(e.hard / count);
    return e;
}

static void report(finding *f, errors e, double limit)
{
    say(f->ours, "rms error %.3f (layered), %d values outside of [0,1]", e.layered, e.bad);
    say(f->others, "hard shadow map %.3f, published estimator %.3f", e.hard, e.published);
    f->holds = !e.bad && e.layered < limit;
}

static void size_zero(finding *f)
{
    say(f->what, "a light of size 0, three scenes against ray tracing");
    report(f, errors_of(0, 0), 0.2);
}

static void one_sided(finding *f)
{
    say(f->what, "a light of tangent 0.5 by 0: a line");
    report(f, errors_of(0.5, 0), 0.15);
}

static void half_sphere(finding *f)
{
    say(f->what, "a light of tangent 4 (152 degrees across)");
    report(f, errors_of(4, 4), 0.5);
}

static void endless_light(finding *f)
{
    static const double tangents[] = {1e3, 1e6, 1e12, 1e30, (double)FLT_MAX};
    int refused = 0, bad = 0;
    static setup u;
    uint64_t state = 3;
    setup_new(&u, 0);
    for (int i = 0; i < 5; i++) {
        if (!setup_light(&u, tangents[i], tangents[i])) {
            refused++;
            continue;
        }
        for (int k = 0; k < 500; k++) {
            double p[3], n[3];
            scene_receiver(&u.s, &state, p, n);
            bad += !in_range(visibility(&u, MSSM_LAYERED, p));
        }
    }
    setup_free(&u);
    say(f->what, "tangents 1e3 to FLT_MAX: wider than a half-sphere in float32");
    say(f->ours,
        "%d of 5 refused with a result code; of the others %d of %d values outside of [0,1]",
        refused, bad, (5 - refused) * 500);
    const float texels = (float)tangents[3] * SIDE;
    say(f->others, "at 1e30 the kernel's area is %g in float32, and the mean over it %g",
        (double)(texels * texels), (double)(1 / (texels * texels)));
    f->holds = bad == 0;
}

// A light almost in the plane of a ground that is in the map.
static void grazing(finding *f)
{
    static setup u;
    double worst = 0, mean = 0, hard = 0;
    int bad = 0, count = 0;
    uint64_t state = 9;
    setup_new(&u, 0);
    u.s.count = 0;
    scene_add_box(&u.s, 0, -0.05, 0, 2, 0.05, 2);
    scene_finish(&u.s);
    u.s.sun[0] = cos(0.03);
    u.s.sun[1] = sin(0.03);
    u.s.sun[2] = 0;
    if (!setup_light(&u, 0.02, 0.02)) abort();
    for (int i = 0; i < 1000; i++) {
        const double p[3] = {test_range(&state, -1.8, 1.8), 0, test_range(&state, -1.8, 1.8)};
        const float v = visibility(&u, MSSM_LAYERED, p);
        bad += !in_range(v);
        worst = fmax(worst, 1 - (double)v);
        mean += (double)v;
        hard += 1 - hard_shadow(&u, p);
        count++;
    }
    setup_free(&u);
    say(f->what, "an unoccluded plate that a light grazes at 1.7 degrees: all of it is lit");
    say(f->ours, "visibility %.3f on average, %.3f where it is darkest", mean / count, 1 - worst);
    say(f->others, "hard shadow map with a bias of 2 texels: %.0f%% of the receivers dark",
        100 * hard / count);
    f->holds = !bad && mean / count > 0.97 && worst < 0.3;
}

// A map that a plate at depth -.5 covers, with or without back faces at that depth.
static mssm_map *plate_map(mssm_light *light, int averaged, float back_depth)
{
    static unsigned char memory[4 << 20];
    static float front[SIDE * SIDE], back[SIDE * SIDE];
    const float to_light[3] = {0, 1, 0}, axis[3] = {1, 0, 0}, low[3] = {-1, 0, -1},
                high[3] = {1, 1, 1};
    mssm_map *map;
    if (mssm_light_directional(light, to_light, axis, 0.1f, 0.1f, low, high) ||
        mssm_map_init(&map, memory, sizeof memory, SIDE, 6)) {
        abort();
    }
    for (int i = 0; i < SIDE * SIDE; i++) {
        front[i] = -0.5f;
        back[i] = back_depth;
    }
    if (mssm_map_update(map, front, averaged ? back : NULL, 1)) abort();
    return map;
}

static void outside_frustum(finding *f)
{
    mssm_light light;
    const mssm_map *map = plate_map(&light, 0, 1);
    int bad = 0, dark = 0;
    uint64_t state = 21;
    for (int i = 0; i < 4000; i++) {
        const double r = pow(10, test_range(&state, 0.5, 38)), angle = test_range(&state, 0, 6.28);
        const float p[3] = {(float)(r * cos(angle)), 0.3f, (float)(r * sin(angle))};
        const float v = mssm_map_visibility(map, &light, NULL, p);
        bad += !in_range(v);
        dark += v < 1;
    }
    const float strange[3][3] = {{NAN, 0, 0}, {0, INFINITY, 0}, {1, 2, -INFINITY}};
    for (int i = 0; i < 3; i++) bad += mssm_map_visibility(map, &light, NULL, strange[i]) != 1;
    say(f->what, "4000 receivers 3 to 1e38 units beside a covered map, and at NaN and Inf");
    say(f->ours, "%d of them not lit, %d values outside of [0,1]; NaN and Inf are lit", dark, bad);
    const float beside = -0.5f; // what the nearest texel of the map holds
    say(f->others, "clamped texture coordinates: %d of them dark", beside < 0.3f ? 4000 : 0);
    f->holds = bad == 0 && dark == 0;
}

static float under_plate(int averaged, float back_depth)
{
    const float point[3] = {0, 0.6f, 0};
    mssm_light light;
    const mssm_map *map = plate_map(&light, averaged, back_depth);
    return mssm_map_visibility(map, &light, NULL, point);
}

static void open_meshes(finding *f)
{
    const float alone = under_plate(0, 1), closed = under_plate(1, -0.4f), open = under_plate(1, 1);
    say(f->what, "an open sheet over the receiver: it has a front face and no back face (depth 1)");
    say(f->ours,
        "back = NULL, as the header says for open meshes: visibility %.3f; a closed plate, "
        "averaged: %.3f",
        (double)alone, (double)closed);
    say(f->others,
        "averaged all the same: visibility %.3f, the sheet moves halfway to the far plane",
        (double)open);
    f->holds = alone < 0.02f && closed < 0.02f;
}

const further further_lights[] = {
    {"light-size-0", size_zero},        {"light-line", one_sided},
    {"light-half-sphere", half_sphere}, {"light-endless", endless_light},
    {"light-grazing", grazing},         {"outside-frustum", outside_frustum},
    {"open-mesh", open_meshes},         {0, 0}};
