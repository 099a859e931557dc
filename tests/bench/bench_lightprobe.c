// Time of the extraction against the least one can do with a probe: reading it once and summing its
// luminance. Medians of interleaved runs.
#define _POSIX_C_SOURCE 199309L
#include "../../lightprobe.h"
#include "../support/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { RUNS = 101, SIDES = 3 };

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static double median(double *times)
{
    qsort(times, RUNS, sizeof *times, compare);
    return times[RUNS / 2];
}

static float plain_pass(const lightprobe_cube *cube)
{
    float sum = 0;
    for (int f = 0; f < 6; f++) {
        const float *t = cube->face[f];
        for (int i = 0; i < cube->side * cube->side; i++, t += 3)
            sum += 0.2126f * t[0] + 0.7152f * t[1] + 0.0722f * t[2];
    }
    return sum;
}

static void bench(int side)
{
    static const int counts[] = {16, 32, 64, 256};
    const size_t texels = (size_t)side * (size_t)side;
    float *data = malloc(6 * texels * 3 * sizeof *data);
    lightprobe_cube cube = {{NULL}, side, 3};
    uint64_t random = 1;
    for (size_t i = 0; i < 18 * texels; i++) { // smooth, with some hot spots
        const double u = test_uniform(&random), wave = (double)(i / 3 % texels) / (double)texels;
        data[i] = (float)(0.2 + wave + 0.1 * u + (u > 0.9999 ? 500 : 0));
    }
    for (int f = 0; f < 6; f++) cube.face[f] = data + (size_t)f * texels * 3;
    static lightprobe_light lights[256];
    const size_t bytes = lightprobe_scratch_bytes(side, 256);
    void *scratch = malloc(bytes);
    volatile float sink = 0;
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
        double plain[RUNS], ours[RUNS];
        lightprobe_settings settings;
        memset(&settings, 0, sizeof settings);
        settings.max_lights = counts[k];
        int count = 0;
        for (int run = 0; run < RUNS; run++) {
            const double start = now();
            sink += plain_pass(&cube);
            const double middle = now();
            lightprobe_extract(&cube, &settings, scratch, bytes, lights, &count, NULL);
            plain[run] = middle - start;
            ours[run] = now() - middle;
        }
        const double a = median(plain), b = median(ours);
        printf("6 x %3d^2, %3d lights: %7.1f us, plain pass %6.1f us, %.2f times\n", side, count,
               1e6 * b, 1e6 * a, b / a);
    }
    (void)sink;
    free(scratch);
    free(data);
}

int main(void)
{
    static const int sides[SIDES] = {64, 128, 256};
    printf("extraction of lights, single-threaded\n");
    for (int i = 0; i < SIDES; i++) bench(sides[i]);
    return 0;
}
