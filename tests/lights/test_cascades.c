// One sun over a large scene by maps of growing size: a camera walks through it, and still shadows
// stand still.
#include "../support/scenes.h"
#include "../support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../../examples/common/cascades.h"

enum { SIDE = 256, MAPS = 3, POINTS = 400 };

static const float to_light[3] = {-0.5f, 1, 0.35f}, axis[3] = {1, 0, 0};

typedef struct stage {
    scene s;
    cascades c;
    mssm_map *map[MAPS];
    void *memory;
    float *depth;
    float point[POINTS][3], normal[POINTS][3], seen[MAPS][POINTS];
    float eye[3], ahead[3];
    float offset; // of the texels, in texels: a control
} stage;

// Posts, balls and slabs along a road of 60, and a house.
static void make(stage *t, float tan_half)
{
    cascades_desc desc = {MAPS, SIDE, 5, 45, 0.7f, 0.4f, {0}, {0}, tan_half, tan_half, 4};
    uint64_t state = 11;
    memset(t, 0, sizeof *t);
    for (int i = 0; i < 40; i++) {
        const double x = test_range(&state, -8, 52), z = test_range(&state, -8, 8);
        if (i % 3 == 0) scene_add_box(&t->s, x, 1, z, 0.08, 1, 0.08);
        if (i % 3 == 1)
            scene_add_sphere(&t->s, x, test_range(&state, 0.4, 2), z, test_range(&state, 0.2, 0.6));
        if (i % 3 == 2) scene_add_box(&t->s, x, test_range(&state, 0.5, 2.2), z, 0.8, 0.05, 0.5);
    }
    scene_add_box(&t->s, 20, 1.2, -3, 1.5, 1.2, 1);
    for (int i = 0; i < 3; i++) {
        t->s.sun[i] = (double)to_light[i];
        desc.to_light[i] = to_light[i];
        desc.axis_u[i] = axis[i];
    }
    scene_finish(&t->s);
    t->s.ground = 0;
    CHECK(cascades_create(&t->c, &desc), "create");
    const size_t bytes = mssm_map_bytes(SIDE, 6);
    t->memory = malloc(MAPS * bytes);
    t->depth = malloc(SIDE * SIDE * sizeof *t->depth);
    if (!t->memory || !t->depth) abort();
    for (int i = 0; i < MAPS; i++) {
        CHECK(!mssm_map_init(&t->map[i], (char *)t->memory + (size_t)i * bytes, bytes, SIDE, 6),
              "init");
    }
    // Receivers near the road, half of them close to the ground's shadows.
    for (int i = 0; i < POINTS; i++) {
        double p[3], n[3];
        do {
            if (i % 2) {
                scene_receiver(&t->s, &state, p, n);
            } else {
                p[0] = test_range(&state, -2, 40), p[1] = 0, p[2] = test_range(&state, -5, 5);
                n[0] = n[2] = 0, n[1] = 1;
            }
        } while (p[0] < -4 || p[0] > 45 || fabs(p[2]) > 8);
        for (int k = 0; k < 3; k++) t->point[i][k] = (float)p[k], t->normal[i][k] = (float)n[k];
    }
}

static void finish(stage *t)
{
    free(t->memory);
    free(t->depth);
}

static void aim(stage *t, float x, float turn)
{
    const float eye[3] = {x, 1.7f, 0.5f * sinf(0.2f * x)},
                ahead[3] = {cosf(turn), -0.1f, sinf(turn)};
    memcpy(t->eye, eye, sizeof eye);
    memcpy(t->ahead, ahead, sizeof ahead);
    cascades_aim(&t->c, eye, ahead);
    for (int i = 0; i < MAPS; i++) {
        mssm_light l = t->c.light[i];
        l.world_to_shadow[12] += t->offset * 2 / SIDE;
        if (t->offset == 0 && !(t->c.moved >> i & 1u)) continue;
        scene_depth(&t->s, &l, SIDE, 1, t->depth, NULL);
        CHECK(!mssm_map_update(t->map[i], t->depth, NULL, 1), "update");
        mssm_map_visibility_many(t->map[i], &l, NULL, POINTS, (const float(*)[3])t->point,
                                 (const float(*)[3])t->normal, t->seen[i]);
    }
}

static float mixed(const stage *t, int i, float *next)
{
    const int map = cascades_choose(&t->c, t->point[i], next);
    const float after = map + 1 < MAPS ? t->seen[map + 1][i] : 1;
    return t->seen[map][i] + *next * (after - t->seen[map][i]);
}

// Whether the camera of make() sees it: the maps hold no more.
static int in_view(const stage *t, const float p[3])
{
    const float *a = t->ahead, right[3] = {-a[2], 0, a[0]};
    const float up[3] = {-a[0] * a[1], a[0] * a[0] + a[2] * a[2], -a[2] * a[1]};
    float sum[3] = {0, 0, 0}, length[3] = {0, 0, 0};
    for (int k = 0; k < 3; k++) {
        const float d = p[k] - t->eye[k];
        sum[0] += d * a[k], sum[1] += d * right[k], sum[2] += d * up[k];
        length[0] += a[k] * a[k], length[1] += right[k] * right[k], length[2] += up[k] * up[k];
    }
    for (int k = 0; k < 3; k++) sum[k] /= sqrtf(length[k]);
    return sum[0] > 0 && fabsf(sum[1]) < 0.7f * sum[0] && fabsf(sum[2]) < 0.4f * sum[0];
}

typedef struct walked {
    double seam, still, redrawn, hard,
        squares; // largest changes between two frames, of a hard switch; all
    int seams, count, drawn;
} walked;

// 5 cm a frame, looking to and fro. Change of what the camera sees in both frames, by where it is:
// in a blend, or in one map that was not, or was, drawn again.
static walked walk(stage *t, int frames, int shifted)
{
    static float before[POINTS], next_before[POINTS];
    walked w = {0, 0, 0, 0, 0, 0, 0, 0};
    for (int f = 0; f < frames; f++) {
        if (shifted) t->offset = fmodf((float)f * 0.377f, 1.0f);
        aim(t, (float)f * 0.05f, 0.3f * sinf((float)f * 0.05f));
        for (int i = 0; i < MAPS; i++) w.drawn += (int)(t->c.moved >> i & 1u);
        for (int i = 0; i < POINTS; i++) {
            float next;
            const float v = mixed(t, i, &next);
            const int map = cascades_choose(&t->c, t->point[i], &next),
                      seen = in_view(t, t->point[i]);
            const double d = fabs((double)v - (double)before[i]);
            if (seen && f && before[i] >= 0) {
                w.squares += d * d;
                w.count++;
                if (next > 0 && next < 1 && map + 1 < MAPS) {
                    w.seam = fmax(w.seam, d);
                    w.hard =
                        fmax(w.hard, fabs((double)t->seen[map][i] - (double)t->seen[map + 1][i]));
                    w.seams++;
                } else if (next == 0 && next_before[i] == 0) {
                    double *most = t->c.moved ? &w.redrawn : &w.still;
                    *most = fmax(*most, d);
                }
            }
            before[i] = seen ? v : -1;
            next_before[i] = next;
        }
    }
    return w;
}

static void a_walk_shows_no_seam_and_no_shimmer(void)
{
    static const float sizes[3] = {0.02f, 0.05f, 0.15f};
    static stage t;
    for (int i = 0; i < test_trials(3); i++) {
        make(&t, sizes[i]);
        const walked w = walk(&t, 120, 0);
        test_note(
            "tan %.2f: %.4f across seams (%.2f by a hard switch), %.4f where maps were drawn again, %d of %d were",
            (double)sizes[i], w.seam, w.hard, w.redrawn, w.drawn, 120 * MAPS);
        CHECK(w.seams > 2000 && w.hard > 0.2, "%d points in seams, %.3f between maps", w.seams,
              w.hard);
        CHECK(w.seam < 0.02, "tan %.2f: a step of %.4f at a seam", (double)sizes[i], w.seam);
        CHECK(w.still == 0, "tan %.2f: %.2g while no map changed", (double)sizes[i], w.still);
        CHECK(w.redrawn < 0.005, "tan %.2f: shadows shimmer by %.4f", (double)sizes[i], w.redrawn);
        CHECK(w.drawn < 120, "%d of %d maps drawn again", w.drawn, 120 * MAPS);
        finish(&t);
    }
    make(&t, 0.05f); // what the steps are for: texels that move with the camera
    const walked w = walk(&t, 20, 1);
    test_note("texels that go with the camera: %.4f rms, %.2f at most", sqrt(w.squares / w.count),
              w.redrawn);
    CHECK(sqrt(w.squares / w.count) > 0.01, "the walk does not see shimmer");
    finish(&t);
}

// Across the shadow of one edge: between .1 and .9 the same way in each map, the rays' way.
static void penumbrae_are_as_wide_in_every_map(void)
{
    static stage t;
    double width[MAPS + 1];
    make(&t, 0.15f);
    t.s.count = 0;
    scene_add_box(&t.s, 2, 2, 0, 1.5, 0.2, 3);
    scene_finish(&t.s);
    t.s.ground = 0;
    aim(&t, 0, 0);
    for (int map = 0; map <= MAPS; map++) {
        double at[2] = {-9, -9}, last = 0;
        uint64_t state = 3;
        for (int i = 0; i <= 400; i++) {
            const double p[3] = {1.5 + 0.01 * i + 1, 0, -1.4}, up[3] = {0, 1, 0};
            const float q[3] = {(float)p[0], 0, (float)p[2]};
            const double v = map < MAPS
                                 ? (double)mssm_map_visibility(t.map[map], &t.c.light[map], NULL, q)
                                 : scene_visibility(&t.s, &t.c.light[0], p, up, 32, &state);
            for (int k = 0; k < 2; k++) {
                const double level = k ? 0.9 : 0.1;
                if (i && at[k] < 0 && last < level && v >= level)
                    at[k] = p[0] - 0.01 * (v - level) / (v - last);
            }
            last = v;
        }
        CHECK(at[0] > 0 && at[1] > at[0], "map %d: no penumbra (%.2f %.2f)", map, at[0], at[1]);
        width[map] = at[1] - at[0];
    }
    test_note("penumbra by rays %.3f; texels of %.3f %.3f %.3f: %.3f %.3f %.3f", width[MAPS],
              (double)t.c.light[0].extent_u * 2 / SIDE, (double)t.c.light[1].extent_u * 2 / SIDE,
              (double)t.c.light[2].extent_u * 2 / SIDE, width[0], width[1], width[2]);
    for (int i = 0; i < MAPS; i++) {
        CHECK(fabs(width[i] - width[MAPS]) < 0.15 * width[MAPS], "map %d: %.3f", i, width[i]);
    }
    finish(&t);
}

// Whatever the camera sees up to a map's end lies in that map, with its casters in front of it.
static void maps_hold_what_the_camera_sees(void)
{
    uint64_t state = 17;
    for (int trial = 0; trial < test_trials(4000); trial++) {
        const cascades_desc desc = {
            4,
            256,
            (float)test_range(&state, 1, 10),
            (float)test_range(&state, 10, 1000),
            (float)test_range(&state, 0.1, 2),
            (float)test_range(&state, 0.1, 2),
            {(float)test_range(&state, -1, 1), 1, (float)test_range(&state, -1, 1)},
            {1, 0, 0},
            0.1f,
            0.05f,
            (float)test_range(&state, 0, 30)};
        cascades c;
        float eye[3], p[3], to[3], shadow[3];
        const float ahead[3] = {0, 0, -2};
        CHECK(cascades_create(&c, &desc), "create");
        for (int k = 0; k < 3; k++) eye[k] = (float)test_range(&state, -500, 500);
        cascades_aim(&c, eye, ahead);
        to[0] = desc.tan_x * (trial & 1 ? 1.0f : -1.0f), to[1] = desc.tan_y, to[2] = -1;
        for (int k = 0; k < 2 && trial & 6; k++) to[k] *= (float)test_uniform(&state);
        const double length = sqrt((double)(to[0] * to[0] + to[1] * to[1] + 1));
        for (int i = 0; i < 4; i++) {
            const double far = (double)c.end[i] * (trial & 8 ? 0.999 : test_uniform(&state));
            for (int k = 0; k < 3; k++)
                p[k] = (float)((double)eye[k] + far * (double)to[k] / length);
            CHECK(mssm_light_project(&c.light[i], p, shadow), "no place");
            CHECK(fabsf(shadow[0]) < 1.001f && fabsf(shadow[1]) < 1.001f && shadow[2] < 0.801f &&
                      shadow[2] - 2 * desc.height / c.light[i].z_far > -0.991f,
                  "map %d: %g %g %g", i, (double)shadow[0], (double)shadow[1], (double)shadow[2]);
        }
    }
}

static void bad_numbers_are_refused(void)
{
    const cascades_desc good = {2, 256, 5, 45, 0.7f, 0.4f, {0, 1, 0}, {1, 0, 0}, 0.1f, 0.1f, 4};
    cascades c, before;
    memset(&c, 7, sizeof c);
    before = c;
    for (int i = 0; i < 14; i++) {
        cascades_desc d = good;
        if (i == 0) d.count = 0;
        if (i == 1) d.count = CASCADES_MOST + 1;
        if (i == 2) d.side = 32;
        if (i == 3) d.first = 0;
        if (i == 4) d.farthest = 4;
        if (i == 5) d.tan_x = 0;
        if (i == 6) d.tan_y = -1;
        if (i == 7) d.height = -1;
        if (i == 8) d.farthest = HUGE_VALF;
        if (i == 9) d.first = (float)NAN;
        if (i == 10) d.to_light[1] = 0;
        if (i == 11) d.tan_half_u = (float)NAN;
        if (i == 12) d.first = 1e-42f;
        if (i == 13) d.tan_half_v = 1e19f;
        CHECK(!cascades_create(&c, &d), "number %d is taken", i);
    }
    CHECK(!memcmp(&c, &before, sizeof c), "changed");
    CHECK(cascades_create(&c, &good), "refused");
}

const test_case cascades_tests[] = {
    {"large scenes: a walk shows no seam and no shimmer", a_walk_shows_no_seam_and_no_shimmer},
    {"large scenes: penumbrae are as wide in every map", penumbrae_are_as_wide_in_every_map},
    {"large scenes: maps hold what the camera sees", maps_hold_what_the_camera_sees},
    {"large scenes: bad numbers are refused", bad_numbers_are_refused},
    {0, 0},
};
