// Lights and summed-area tables, against sums in double precision over the texels themselves.

#include "mssm.h"
#include "../support/test.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const float up[3] = {0, 1, 0}, axis_x[3] = {1, 0, 0};

typedef struct fixture {
    void *memory;
    mssm_map *map;
    float *depth;
    int side, moments, samples;
} fixture;

static fixture make_map(int side, int moments, int samples)
{
    fixture f = {NULL, NULL, NULL, side, moments, samples};
    const size_t bytes = mssm_map_bytes(side, moments);
    f.memory = malloc(bytes);
    f.depth = (float *)malloc(sizeof(float) * (size_t)(side * side * samples));
    if (mssm_map_init(&f.map, f.memory, bytes, side, moments)) exit(2);
    return f;
}

static void drop_map(fixture *f)
{
    free(f->memory);
    free(f->depth);
}

static void fill_random(fixture *f, uint64_t *seed)
{
    for (int i = 0; i < f->side * f->side * f->samples; i++) {
        f->depth[i] = (float)test_range(seed, -1, 1);
    }
    if (mssm_map_update(f->map, f->depth, NULL, f->samples)) exit(2);
}

// How much of an axis' [low, high] a texel stands for at a level: its own width; one of the last
// texel of the level, 2^level wide, its part of that; and those of an outermost one their part of
// as much beyond as the rectangle has inside.
static double stands_for(int texel, int side, int level, double low, double high)
{
    const int grain = 1 << level, last = (side - 1) >> level, end = (last + 1) * grain;
    const double inside = fmax(fmin(high, end) - fmax(low, 0), 0);
    const int is_last = texel >> level == last;
    const double of_last =
        fmax(fmin(end, high) - fmax(last * grain, low), 0) + fmin(inside, fmax(high - end, 0));
    double width = is_last ? of_last / (side - last * grain)
                           : fmax(fmin(texel + 1, high) - fmax(texel, low), 0);
    if (texel >> level == 0) width += fmin(inside, fmax(-low, 0)) / fmin(grain, side);
    return width;
}

// Mean of z^k over a rectangle in texels; 1 where no texel stands for it.
static void exact_moments(const fixture *f, int level, double x0, double y0, double x1, double y1,
                          double b[6])
{
    double known = 0;
    for (int k = 0; k < 6; k++) b[k] = 0;
    for (int y = 0; y < f->side; y++) {
        const double h = stands_for(y, f->side, level, y0, y1);
        for (int x = 0; x < f->side && h > 0; x++) {
            const double w = stands_for(x, f->side, level, x0, x1);
            known += w * h;
            for (int s = 0; s < f->samples; s++) {
                const double z = f->depth[(y * f->side + x) * f->samples + s];
                double power = w * h / f->samples;
                for (int k = 0; k < 6; k++) b[k] += power *= z;
            }
        }
    }
    const double area = (x1 - x0) * (y1 - y0);
    for (int k = 0; k < 6; k++) b[k] = (b[k] + area - known) / area;
}

static double query_error(const fixture *f, int level, double x, double y, double hx, double hy)
{
    double b[6], worst = 0;
    exact_moments(f, level, x - hx, y - hy, x + hx, y + hy, b);
    const double to_shadow = 2.0 / f->side;
    const mssm_moments6 m =
        mssm_map_moments(f->map, (float)(x * to_shadow - 1), (float)(y * to_shadow - 1),
                         (float)(hx * to_shadow), (float)(hy * to_shadow));
    for (int k = 0; k < f->moments; k++) worst = fmax(worst, fabs(m.b[k] - b[k]));
    return worst;
}

static void queries_equal_sums(void)
{
    static const int sides[] = {1, 2, 3, 27, 28, 64};
    uint64_t seed = 11;
    double worst = 0;
    for (int i = 0; i < 6; i++) {
        for (int moments = 4; moments <= 6; moments += 2) {
            fixture f = make_map(sides[i], moments, 1 + 3 * (i % 2));
            fill_random(&f, &seed);
            for (int trial = 0; trial < test_trials(400); trial++) {
                // Widths that level 0 serves; also partly and wholly outside of the map.
                const double hx = test_range(&seed, 0.5, 13.5), hy = test_range(&seed, 0.5, 13.5);
                const double x = test_range(&seed, -15, f.side + 15);
                const double y = test_range(&seed, -15, f.side + 15);
                worst = fmax(worst, query_error(&f, 0, x, y, hx, hy));
            }
            drop_map(&f);
        }
    }
    test_note("largest error of a moment %.2e", worst);
    // 6e-8 a stored value; the coordinates themselves are rounded to 1e-7 of the map.
    CHECK(worst < 6e-6, "error %g", worst);
}

static void coarse_levels_equal_sums(void)
{
    uint64_t seed = 12;
    double worst = 0, worst_any = 0;
    static const int sides[] = {256, 100};
    for (int i = 0; i < 2; i++) {
        fixture f = make_map(sides[i], 6, 1);
        fill_random(&f, &seed);
        for (int trial = 0; trial < test_trials(120); trial++) {
            const int level = 1 + trial % (i ? 2 : 3),
                      size = 1 << level; // 100 texels end with level 2
            // On the level's own grid the sums are those of the texels; off it each edge is blurred
            // over one coarse texel, of at least 13 across the kernel.
            const int half = size * (7 + (int)(test_random(&seed) % 7));
            const int x = size * (int)(test_random(&seed) % (unsigned)(f.side / size));
            const int y = size * (int)(test_random(&seed) % (unsigned)(f.side / size));
            worst = fmax(worst, query_error(&f, level, x, y, half, half));
            worst_any = fmax(worst_any,
                             query_error(&f, level, x + test_range(&seed, 0, size), y, half, half));
        }
        drop_map(&f);
    }
    test_note("largest error of a moment %.2e on the grid, %.2e off it (noise as depth)", worst,
              worst_any);
    CHECK(worst < 6e-6, "error %g", worst);
    CHECK(worst_any < 0.1, "error %g", worst_any);
}

static void full_kernels_do_not_wrap(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        fixture f = make_map(300, 6, 2);
        for (int i = 0; i < 300 * 300 * 2; i++) f.depth[i] = (float)sign;
        CHECK(mssm_map_update(f.map, f.depth, NULL, 2) == MSSM_OK, "update failed");
        for (double half = 0.5; half < 140; half *= 1.07) {
            const double error = query_error(&f, 0, 150.3, 149.7, half, half);
            CHECK(error < 1e-6, "half-width %g, depth %d: error %g", half, sign, error);
        }
        drop_map(&f);
    }
}

// Slides, 72: scale 2^32/n. A fully lit region of n texels then sums to 2^32, which is 0.
static void printed_scale_wraps(void)
{
    const uint32_t n = 27 * 27;
    const float printed = (float)(4294967296.0 / n);
    uint32_t sum = 0, ours = 0;
    for (uint32_t i = 0; i < n; i++) {
        sum += (uint32_t)(1.0f * printed + 0.5f);
        ours += (uint32_t)((4294967295u) / ((27 + 2) * (27 + 2)));
    }
    CHECK((float)sum / (float)n / printed < 0.01f, "the printed scale gives %g",
          sum / (double)n / printed);
    CHECK(ours / (double)n * 841 / 4294967295.0 > 0.999,
          "floor((2^32-1)/n) with a border does not");
}

// Of depth 0 all odd polynomials are 0, and so is any sum of them: at every border, across rows and
// levels.
static void sums_of_nothing_are_nothing(void)
{
    uint64_t seed = 20;
    for (int moments = 4; moments <= 6; moments += 2) {
        fixture f = make_map(70, moments, 1);
        for (int i = 0; i < 70 * 70; i++) f.depth[i] = 0;
        CHECK(mssm_map_update(f.map, f.depth, NULL, 1) == MSSM_OK, "update failed");
        for (int trial = 0; trial < 400; trial++) {
            // From the border on, or anywhere inside.
            const double hx = test_range(&seed, 0.5, 12), hy = test_range(&seed, 0.5, 12);
            const double x = trial % 3 ? test_range(&seed, 12, 58) : hx,
                         y = trial % 5 ? test_range(&seed, 12, 58) : hy;
            const mssm_moments6 m =
                mssm_map_moments(f.map, (float)(x / 35 - 1), (float)(y / 35 - 1), (float)(hx / 35),
                                 (float)(hy / 35));
            // Rounding of coordinates reaches out of the map, fused products into the digits.
            const double tiny = trial % 3 && trial % 5 ? 1e-7 : 1e-6;
            CHECK(fabs(m.b[0]) <= tiny && fabs(m.b[2]) <= tiny && fabs(m.b[4]) <= tiny,
                  "moments %g %g %g", (double)m.b[0], (double)m.b[2], (double)m.b[4]);
        }
        const mssm_moments6 corner = mssm_map_moments(f.map, 0.5f / 35 - 1, 0.5f / 35 - 1, 0, 0);
        CHECK(fabs(corner.b[0]) <= 1e-7 && fabs(corner.b[2]) <= 1e-7, "the first texel has %g",
              (double)corner.b[0]);
        drop_map(&f);
    }
}

static void samples_are_averaged(void)
{
    uint64_t seed = 13;
    fixture many = make_map(40, 6, 8);
    fill_random(&many, &seed);
    double worst = 0;
    for (int i = 0; i < 100; i++) {
        worst = fmax(
            worst, query_error(&many, 0, test_range(&seed, 0, 40), test_range(&seed, 0, 40), 3, 5));
    }
    CHECK(worst < 6e-6, "error %g", worst);
    drop_map(&many);
}

static void back_faces_average_depth(void)
{
    uint64_t seed = 14;
    fixture f = make_map(32, 6, 4);
    float *back = (float *)malloc(sizeof(float) * 32 * 32 * 4);
    for (int i = 0; i < 32 * 32 * 4; i++) {
        f.depth[i] = (float)test_range(&seed, -1, 1);
        back[i] = (float)test_range(&seed, -1, 1);
    }
    CHECK(mssm_map_update(f.map, f.depth, back, 4) == MSSM_OK, "update failed");
    for (int i = 0; i < 32 * 32 * 4; i++) f.depth[i] = 0.5f * (f.depth[i] + back[i]);
    double worst = 0;
    for (int i = 0; i < 100; i++) {
        worst = fmax(worst,
                     query_error(&f, 0, test_range(&seed, 0, 32), test_range(&seed, 0, 32), 2, 2));
    }
    CHECK(worst < 6e-6, "error %g", worst);
    free(back);
    drop_map(&f);
}

// A map that is covered to its rim stands for as much again beyond; further out all is lit.
static void the_rim_stands_for_what_lies_beyond(void)
{
    fixture f = make_map(64, 6, 1);
    mssm_light light;
    const float low[3] = {-1, 0, -1}, high[3] = {1, 1, 1};
    CHECK(!mssm_light_directional(&light, up, axis_x, 0.2f, 0.2f, low, high), "light failed");
    for (int i = 0; i < 64 * 64; i++) f.depth[i] = -0.99f; // the whole map is covered
    CHECK(mssm_map_update(f.map, f.depth, NULL, 1) == MSSM_OK, "update failed");
    const float under[3] = {0, 0.2f, 0}, beside[3] = {2.5f, 0.2f, 0}, above[3] = {0, 1.5f, 0};
    const float far_below[3] = {0, -50, 0}, edge[3] = {1, 0.2f, 0};
    CHECK(mssm_map_visibility(f.map, &light, NULL, under) < 0.01f, "below the cover");
    CHECK(mssm_map_visibility(f.map, &light, NULL, beside) == 1, "beside the map");
    CHECK(mssm_map_visibility(f.map, &light, NULL, above) == 1, "nearer than the near plane");
    CHECK(mssm_map_visibility(f.map, &light, NULL, far_below) > 0.88f,
          "the cover is small from afar: %g",
          (double)mssm_map_visibility(f.map, &light, NULL, far_below));
    const float v = mssm_map_visibility(f.map, &light, NULL, edge);
    CHECK(v < 0.01f, "light past the rim: %g", (double)v);
    drop_map(&f);
}

static void new_map_is_lit(void)
{
    fixture f = make_map(50, 4, 1);
    mssm_light light;
    const float low[3] = {-1, 0, -1}, high[3] = {1, 1, 1};
    CHECK(!mssm_light_directional(&light, up, axis_x, 0.5f, 0.5f, low, high), "light failed");
    uint64_t seed = 15;
    for (int i = 0; i < 1000; i++) {
        const float p[3] = {(float)test_range(&seed, -3, 3), (float)test_range(&seed, -3, 3),
                            (float)test_range(&seed, -3, 3)};
        CHECK(mssm_map_visibility(f.map, &light, NULL, p) == 1, "at %a %a %a", (double)p[0],
              (double)p[1], (double)p[2]);
    }
    drop_map(&f);
}

static void garbage_depth_counts_as_nothing_or_clamped(void)
{
    static const float garbage[] = {NAN,    INFINITY, -INFINITY, FLT_MAX, -FLT_MAX,
                                    1e-42f, -0.0f,    2,         -2};
    static const float means[] = {1, 1, 1, 1, -1, 0, 0, 1, -1};
    for (int i = 0; i < 9; i++) {
        fixture f = make_map(5, 6, 1);
        for (int k = 0; k < 25; k++) f.depth[k] = garbage[i];
        CHECK(mssm_map_update(f.map, f.depth, NULL, 1) == MSSM_OK, "update failed");
        const mssm_moments6 m = mssm_map_moments(f.map, 0, 0, 0.5f, 0.5f);
        CHECK(fabsf(m.b[0] - means[i]) < 1e-6f, "%g counts as %g", (double)garbage[i],
              (double)m.b[0]);
        drop_map(&f);
    }
}

static void memory_may_be_anywhere(void)
{
    const size_t bytes = mssm_map_bytes(20, 6);
    unsigned char *memory = (unsigned char *)malloc(bytes + 16);
    float depth[400];
    uint64_t seed = 16;
    for (int i = 0; i < 400; i++) depth[i] = (float)test_range(&seed, -1, 1);
    mssm_moments6 first = {{0}};
    for (int shift = 0; shift < 16; shift++) {
        mssm_map *map = NULL;
        CHECK(mssm_map_init(&map, memory + shift, bytes, 20, 6) == MSSM_OK, "shift %d", shift);
        CHECK(mssm_map_update(map, depth, NULL, 1) == MSSM_OK, "shift %d", shift);
        const mssm_moments6 m = mssm_map_moments(map, 0.1f, 0.2f, 0.3f, 0.4f);
        CHECK((uintptr_t)map % sizeof(void *) == 0 && (unsigned char *)map >= memory + shift,
              "shift %d: the map lies badly", shift);
        if (shift == 0) first = m;
        CHECK(!memcmp(&m, &first, sizeof m), "shift %d changes the result", shift);
    }
    free(memory);
}

static void bad_arguments_are_refused(void)
{
    mssm_map *map = (mssm_map *)(void *)&map, *before = map;
    char memory[64];
    CHECK(mssm_map_bytes(0, 4) == 0 && mssm_map_bytes(-1, 4) == 0 &&
              mssm_map_bytes(16385, 6) == 0 && mssm_map_bytes(64, 5) == 0 &&
              mssm_map_bytes(64, 0) == 0,
          "sizes out of range have no bytes");
    CHECK(mssm_map_init(&map, memory, sizeof memory, 0, 4) == MSSM_ERROR_ARGUMENT, "side 0");
    CHECK(mssm_map_init(&map, memory, sizeof memory, 64, 5) == MSSM_ERROR_ARGUMENT, "5 moments");
    CHECK(mssm_map_init(&map, NULL, 1u << 20, 64, 4) == MSSM_ERROR_ARGUMENT, "no memory");
    CHECK(mssm_map_init(NULL, memory, sizeof memory, 1, 4) == MSSM_ERROR_ARGUMENT, "no map");
    CHECK(mssm_map_init(&map, memory, sizeof memory, 64, 4) == MSSM_ERROR_MEMORY,
          "too little memory");
    CHECK(map == before, "a failed init changed its output");
    fixture f = make_map(4, 4, 1);
    for (int i = 0; i < 16; i++) f.depth[i] = 0;
    CHECK(mssm_map_update(f.map, f.depth, NULL, 1) == MSSM_OK, "update failed");
    const mssm_moments6 m = mssm_map_moments(f.map, 0, 0, 1, 1);
    CHECK(mssm_map_update(NULL, f.depth, NULL, 1) == MSSM_ERROR_ARGUMENT, "no map");
    CHECK(mssm_map_update(f.map, NULL, NULL, 1) == MSSM_ERROR_ARGUMENT, "no depth");
    CHECK(mssm_map_update(f.map, f.depth, NULL, 0) == MSSM_ERROR_ARGUMENT, "no samples");
    CHECK(mssm_map_update(f.map, f.depth, NULL, 65) == MSSM_ERROR_ARGUMENT, "65 samples");
    const mssm_moments6 after = mssm_map_moments(f.map, 0, 0, 1, 1);
    CHECK(!memcmp(&m, &after, sizeof m), "a failed update changed the map");
    drop_map(&f);
    for (int i = -1; i < 10; i++) {
        const char *text = mssm_result_string((mssm_result)i);
        CHECK(text && strlen(text) > 5, "result %d has no text", i);
    }
}

// Random lights over random boxes.
static void random_light(uint64_t *seed, mssm_light *light, float axis[3], float low[3],
                         float high[3])
{
    float direction[3];
    for (int i = 0; i < 3; i++) {
        direction[i] = (float)test_range(seed, -1, 1);
        axis[i] = (float)test_range(seed, -1, 1);
        low[i] = (float)test_range(seed, -10, 10);
        high[i] = low[i] + (float)test_range(seed, 0, 5);
    }
    CHECK(!mssm_light_directional(light, direction, axis, 0.1f, 0.2f, low, high), "light failed");
}

static void directional_frusta_hold_the_box(void)
{
    uint64_t seed = 17;
    for (int trial = 0; trial < test_trials(2000); trial++) {
        mssm_light light;
        float axis[3], low[3], high[3], nearest = 2, farthest = -2, widest = 0;
        random_light(&seed, &light, axis, low, high);
        for (int corner = 0; corner < 8; corner++) {
            const float p[3] = {corner & 1 ? high[0] : low[0], corner & 2 ? high[1] : low[1],
                                corner & 4 ? high[2] : low[2]};
            float s[3];
            CHECK(mssm_light_project(&light, p, s), "no projection");
            widest = fmaxf(widest, fmaxf(fabsf(s[0]), fabsf(s[1])));
            nearest = fminf(nearest, s[2]);
            farthest = fmaxf(farthest, s[2]);
        }
        CHECK(nearest > -1 && nearest < -0.95f && farthest < 0.81f && farthest > 0.78f &&
                  widest < 1.001f && widest > 0.98f,
              "depth %g to %g, width %g", (double)nearest, (double)farthest, (double)widest);
    }
}

static void depth_grows_away_from_the_light(void)
{
    uint64_t seed = 18;
    for (int trial = 0; trial < test_trials(500); trial++) {
        mssm_light light;
        float axis[3], low[3], high[3], s[3], t[3];
        random_light(&seed, &light, axis, low, high);
        // Along the third row lies the direction towards the light, negated and scaled.
        const float *m = light.world_to_shadow;
        const float p[3] = {low[0], low[1], low[2]};
        const float q[3] = {p[0] + m[2], p[1] + m[6], p[2] + m[10]};
        CHECK(mssm_light_project(&light, p, s) && mssm_light_project(&light, q, t),
              "no projection");
        CHECK(t[2] > s[2], "depth %g behind %g", (double)t[2], (double)s[2]);
        CHECK(fabsf(t[0] - s[0]) < 1e-3f && fabsf(t[1] - s[1]) < 1e-3f, "the axis is not straight");
        // Shadow-space x grows along the axis asked for.
        const float along[3] = {p[0] + axis[0], p[1] + axis[1], p[2] + axis[2]};
        CHECK(mssm_light_project(&light, along, t) && t[0] > s[0] && fabsf(t[1] - s[1]) < 1e-3f,
              "x is not along the axis");
        // Right-handed: u x v points towards the light, so front faces stay front faces.
        const double u[3] = {m[0], m[4], m[8]}, v[3] = {m[1], m[5], m[9]},
                     w[3] = {m[2], m[6], m[10]};
        const double handed = (u[1] * v[2] - u[2] * v[1]) * w[0] +
                              (u[2] * v[0] - u[0] * v[2]) * w[1] +
                              (u[0] * v[1] - u[1] * v[0]) * w[2];
        CHECK(handed < 0, "left-handed");
    }
}

static void spot_depth_is_linear(void)
{
    uint64_t seed = 19;
    const float position[3] = {1, 5, -2}, direction[3] = {0.2f, 1, 0.1f};
    mssm_light light;
    CHECK(!mssm_light_spot(&light, position, direction, axis_x, 0.7f, 0.5f, 8, 0.1f, 0.1f),
          "light failed");
    const double length = sqrt(0.04 + 1 + 0.01);
    for (int i = 0; i < 1000; i++) {
        const float p[3] = {(float)test_range(&seed, -3, 5), (float)test_range(&seed, -3, 4),
                            (float)test_range(&seed, -5, 2)};
        double distance = 0;
        for (int k = 0; k < 3; k++)
            distance -= (p[k] - (double)position[k]) * direction[k] / length;
        float s[3] = {7, 7, 7};
        const int seen = mssm_light_project(&light, p, s);
        CHECK(seen == (distance > 0), "distance %g", distance);
        if (seen) {
            CHECK(fabs(s[2] - (-1 + 2 * (distance - 0.5) / 7.5)) < 1e-5, "depth %g at %g",
                  (double)s[2], distance);
        } else {
            CHECK(s[0] == 7 && s[1] == 7 && s[2] == 7, "a failed projection changed its output");
        }
    }
    static const float asked[] = {0.7f, 0.5f, 8, 0.1f, 0.3f};
    CHECK(!mssm_light_spot(&light, position, direction, axis_x, asked[0], asked[1], asked[2],
                           asked[3], asked[4]),
          "light failed");
    const float fields[] = {light.extent_u, light.z_near, light.z_far, light.half_u, light.half_v};
    CHECK(!memcmp(fields, asked, sizeof asked) && light.perspective == 1 &&
              light.extent_v >= light.extent_u && light.extent_v <= light.extent_u,
          "the light is not what was asked for");
    // The matrix itself is a projection for gl_Position: clip.z / clip.w is -1 at near and 1 at
    // far.
    for (int end = 0; end < 2; end++) {
        const double distance = end ? 8 : 0.5;
        double clip[4];
        for (int r = 0; r < 4; r++) {
            clip[r] = light.world_to_shadow[12 + r];
            for (int k = 0; k < 3; k++) {
                clip[r] += light.world_to_shadow[4 * k + r] *
                           (position[k] - distance * direction[k] / length);
            }
        }
        CHECK(fabs(clip[2] / clip[3] - (end ? 1 : -1)) < 1e-5, "clip depth %g", clip[2] / clip[3]);
        CHECK(fabs(clip[0] / clip[3]) < 1e-5 && fabs(clip[1] / clip[3]) < 1e-5, "axis off centre");
    }
}

static void bad_lights_are_refused(void)
{
    const float zero[3] = {0, 0, 0}, bad[3] = {0, NAN, 0}, huge[3] = {0, INFINITY, 0};
    const float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};
    mssm_light light, before;
    memset(&light, 0x5a, sizeof light);
    before = light;
    mssm_result r[16];
    int n = 0;
    r[n++] = mssm_light_directional(&light, zero, axis_x, 0.1f, 0.1f, low, high);
    r[n++] = mssm_light_directional(&light, bad, axis_x, 0.1f, 0.1f, low, high);
    r[n++] = mssm_light_directional(&light, huge, axis_x, 0.1f, 0.1f, low, high);
    r[n++] = mssm_light_directional(&light, up, bad, 0.1f, 0.1f, low, high);
    r[n++] = mssm_light_directional(&light, up, axis_x, -0.1f, 0.1f, low, high);
    r[n++] = mssm_light_directional(&light, up, axis_x, 0.1f, NAN, low, high);
    r[n++] = mssm_light_directional(&light, up, axis_x, 0.1f, 0.1f, high, low);
    r[n++] = mssm_light_directional(&light, up, axis_x, 0.1f, 0.1f, low, bad);
    r[n++] = mssm_light_directional(&light, NULL, axis_x, 0.1f, 0.1f, low, high);
    r[n++] = mssm_light_spot(&light, zero, zero, axis_x, 1, 1, 2, 0, 0);
    r[n++] = mssm_light_spot(&light, zero, up, axis_x, 0, 1, 2, 0, 0);
    r[n++] = mssm_light_spot(&light, zero, up, axis_x, 1, 0, 2, 0, 0);
    r[n++] = mssm_light_spot(&light, zero, up, axis_x, 1, 2, 2, 0, 0);
    r[n++] = mssm_light_spot(&light, zero, up, axis_x, 1, 1, 2, -1, 0);
    r[n++] = mssm_light_spot(&light, bad, up, axis_x, 1, 1, 2, 0, 0);
    for (int i = 0; i < n; i++)
        CHECK(r[i] == MSSM_ERROR_ARGUMENT, "case %d: %s", i, mssm_result_string(r[i]));
    CHECK(!memcmp(&light, &before, sizeof light), "a failed call changed its output");
    CHECK(mssm_light_directional(NULL, up, axis_x, 0, 0, low, high) == MSSM_ERROR_ARGUMENT,
          "no light");
}

static void degenerate_lights_still_work(void)
{
    const float point[3] = {3, 3, 3}, low[3] = {-1, 0, -1}, flat[3] = {1, 0, 1};
    mssm_light light;
    float s[3];
    CHECK(!mssm_light_directional(&light, up, up, 0, 0, low, flat),
          "axis along the light, flat box");
    CHECK(mssm_light_project(&light, low, s) && fabsf(s[0]) <= 1.001f && s[2] > -1 && s[2] < 1,
          "not inside");
    CHECK(!mssm_light_directional(&light, up, axis_x, 1e6f, 1e6f, point, point),
          "a point, a half-sphere");
    CHECK(mssm_light_project(&light, point, s) && fabsf(s[0]) < 0.01f && s[2] > -1 && s[2] < 1,
          "not inside");
}

const test_case map_tests[] = {
    {"table queries equal sums over the texels", queries_equal_sums},
    {"coarse levels equal sums over the texels", coarse_levels_equal_sums},
    {"full kernels do not wrap around", full_kernels_do_not_wrap},
    {"erratum: the printed scale 2^32/n wraps a lit region to zero", printed_scale_wraps},
    {"sums of nothing are nothing", sums_of_nothing_are_nothing},
    {"samples of a texel are averaged", samples_are_averaged},
    {"back faces average depth, not moments", back_faces_average_depth},
    {"the rim of the map stands for what lies beyond", the_rim_stands_for_what_lies_beyond},
    {"a new map is lit everywhere", new_map_is_lit},
    {"depth that is no depth is clamped or nothing", garbage_depth_counts_as_nothing_or_clamped},
    {"a map may lie at any address", memory_may_be_anywhere},
    {"bad map arguments are refused and change nothing", bad_arguments_are_refused},
    {"directional frusta hold the casters' box", directional_frusta_hold_the_box},
    {"depth grows away from the light", depth_grows_away_from_the_light},
    {"spot depth is linear in distance", spot_depth_is_linear},
    {"bad lights are refused and change nothing", bad_lights_are_refused},
    {"degenerate lights still work", degenerate_lights_still_work},
    {NULL, NULL},
};
