// Speed of the moment map, medians of interleaved runs: update against copying its data, a receiver
// against the width of its kernel, and against percentage-closer soft shadows that read every
// texel.

#include "../../examples/common/threads.h"
#include "mssm.h"
#include "../support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 256, RUNS = 9, RECEIVERS = 2000 };

static float depth[SIDE * SIDE];

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *times)
{
    qsort(times, RUNS, sizeof *times, compare);
    return times[RUNS / 2];
}

// Squares at random heights over the ground y = 0, in a box of 4 x 1 x 4.
static void draw_scene(void)
{
    uint64_t seed = 3;
    for (int i = 0; i < SIDE * SIDE; i++) depth[i] = 0.8f;
    for (int n = 0; n < 60; n++) {
        const int x0 = (int)test_range(&seed, 0, SIDE - 25),
                  y0 = (int)test_range(&seed, 0, SIDE - 25);
        const int width = (int)test_range(&seed, 5, 25);
        const float z = (float)test_range(&seed, -0.99, 0.75);
        for (int y = y0; y < y0 + width; y++) {
            for (int x = x0; x < x0 + width; x++) {
                if (z < depth[y * SIDE + x]) depth[y * SIDE + x] = z;
            }
        }
    }
}

// Blocker search and filter over whole texels, without any sampling.
static float pcss(const mssm_light *light, const float point[3])
{
    float s[3];
    if (!mssm_light_project(light, point, s)) return 1;
    const float x = (0.5f + 0.5f * s[0]) * SIDE, y = (0.5f + 0.5f * s[1]) * SIDE, z = s[2] - 0.01f;
    const float kernel = 0.25f * SIDE * light->half_u * light->z_far / light->extent_u;
    float half = kernel * (s[2] + 1), sum = 0, count = 0, lit = 0, all = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (int j = (int)floorf(y - half); j < y + half; j++) {
            for (int i = (int)floorf(x - half); i < x + half; i++) {
                const int inside = i >= 0 && j >= 0 && i < SIDE && j < SIDE;
                const float d = inside ? depth[j * SIDE + i] : 1;
                if (pass == 0 && d < z) sum += d, count++;
                if (pass == 1) lit += d >= z, all++;
            }
        }
        if (count == 0) return 1;
        half = fmaxf(kernel * (s[2] - sum / count), 0.5f);
    }
    return lit / all;
}

static void bench_update(mssm_map *map, const void *memory, void *copy, size_t bytes)
{
    double update[RUNS], copying[RUNS];
    for (int r = 0; r < RUNS; r++) {
        const double t0 = seconds_now();
        for (int i = 0; i < 20; i++) {
            if (mssm_map_update(map, depth, NULL, 1)) return;
        }
        const double t1 = seconds_now();
        for (int i = 0; i < 20; i++) {
            memcpy(copy, memory, bytes);
            ((volatile char *)copy)[i] = 1;
        }
        const double t2 = seconds_now();
        update[r] = (t1 - t0) / 20;
        copying[r] = (t2 - t1) / 20;
    }
    const double u = median(update), c = median(copying);
    printf("update of %d^2, 6 moments: %.3f ms, %.1f ns a texel; copying its tables %.3f ms: %.1f "
           "times\n",
           SIDE, u * 1e3, u * 1e9 / SIDE / SIDE, c * 1e3, u / c);
}

static void bench_width(mssm_map *map, const float *points, float width)
{
    static const float up[3] = {0, 1, 0}, axis[3] = {1, 0, 0}, low[3] = {-2, 0, -2},
                       high[3] = {2, 1, 2};
    mssm_light light;
    // A caster at the near plane is about one unit above the ground, a texel 4/256 wide.
    const float tangent = 0.5f * width * 4 / SIDE;
    if (mssm_light_directional(&light, up, axis, tangent, tangent, low, high)) return;
    static const char *const names[] = {"layered 6", "layered auto", "layered 4",
                                        "lower 6",   "upper 6",      "PCSS, all texels"};
    const mssm_settings settings[] = {{.moments = 6},
                                      {0},
                                      {.moments = 4},
                                      {.moments = 6, .estimator = MSSM_LOWER_BLOCKER},
                                      {.moments = 6, .estimator = MSSM_UPPER_BLOCKER}};
    double times[6][RUNS];
    volatile float sink = 0;
    for (int r = 0; r < RUNS; r++) {
        for (int m = 0; m < 6; m++) {
            const int count = m < 5 ? RECEIVERS : RECEIVERS / 50;
            const double t = seconds_now();
            for (int i = 0; i < count; i++) {
                const float *p = points + 3 * i;
                sink = sink + (m < 5 ? mssm_map_visibility(map, &light, &settings[m], p)
                                     : pcss(&light, p));
            }
            times[m][r] = (seconds_now() - t) / count;
        }
    }
    printf("%4.0f", (double)width);
    for (int m = 0; m < 6; m++) printf("  %s %.0f ns", names[m], median(times[m]) * 1e9);
    printf("\n");
}

int main(void)
{
    const size_t bytes = mssm_map_bytes(SIDE, 6);
    void *memory = malloc(bytes), *copy = malloc(bytes);
    float *points = (float *)malloc(sizeof(float) * 3 * RECEIVERS);
    mssm_map *map;
    if (!memory || !copy || !points || mssm_map_init(&map, memory, bytes, SIDE, 6)) return 1;
    uint64_t seed = 4;
    for (int i = 0; i < RECEIVERS; i++) {
        points[3 * i] = (float)test_range(&seed, -1.5, 1.5);
        points[3 * i + 1] = 0;
        points[3 * i + 2] = (float)test_range(&seed, -1.5, 1.5);
    }
    draw_scene();
    bench_update(map, memory, copy, bytes);
    printf("time per receiver against the kernel of a caster at the near plane, in texels:\n");
    for (int i = 0; i < 6; i++) {
        static const float widths[] = {9, 27, 51, 101, 151, 255};
        bench_width(map, points, widths[i]);
    }
    free(memory);
    free(copy);
    free(points);
    return 0;
}
