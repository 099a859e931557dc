// What the figures stand on: the paper's own way to find lights, in OpenGL as on the CPU.
#include "median_cut.h"
#include "../support/gl_test.h"
#include "../support/oracle_lightprobe.h"
#include "../support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double distance(const float a[3], const float b[3])
{
    double squared = 0;
    for (int k = 0; k < 3; k++) squared += pow((double)a[k] - (double)b[k], 2);
    return sqrt(squared);
}

static double square_difference(float a, float b)
{
    return fabs((double)a * (double)a - (double)b * (double)b);
}

// The largest difference of what a light is made of; irradiance in parts of the brightest channel,
// half-sizes by their squares, which tables hold: single precision takes small ones from large sums.
static double difference(const lightprobe_light *a, const lightprobe_light *b)
{
    double worst = fmax(distance(a->direction, b->direction),
                        fmax(distance(a->axis_u, b->axis_u), distance(a->axis_v, b->axis_v)));
    worst = fmax(worst, square_difference(a->tan_half_u, b->tan_half_u));
    worst = fmax(worst, square_difference(a->tan_half_v, b->tan_half_v));
    worst = fmax(worst, fabs((double)a->cos_alpha - (double)b->cos_alpha));
    double most = 0;
    for (int k = 0; k < 3; k++) most = fmax(most, (double)a->irradiance[k]);
    return fmax(worst, distance(a->irradiance, b->irradiance) / most);
}

// In full rounds every region is split, so that the order among equals does not matter. The last
// number is as many as there is room for, less what is one texel wide.
static void gl_finds_the_cpus_median_cut(void)
{
    enum { SIDE = 64, NUMBERS = 4 };
    static const int numbers[NUMBERS] = {6, 48, 96, MEDIAN_CUT_MOST};
    static light_cut cuts[MEDIAN_CUT_MOST];
    static lightprobe_light cpu[MEDIAN_CUT_MOST], found[MEDIAN_CUT_MOST];
    gl_context context;
    message why = {{0}};
    if (!gl_test_begin(&context)) return;
    test_probe p = test_scene_probe(SCENE_SKY_SUN, SIDE);
    const lightprobe_cube cube = test_probe_cube(&p);
    double total[3], worst = 0;
    median_cut m;
    gl_median_cut g;
    oracle_total(&p, total);
    CHECK(median_cut_create(&m, SIDE), "no memory");
    median_cut_sums(&m, &cube);
    const bool created = gl_median_cut_create(&g, &cube, &why);
    CHECK(created, "%s", why.text);
    if (created) gl_median_cut_sums(&g);
    for (int n = 0; n < NUMBERS && created; n++) {
        const int count = median_cut_cuts(&m, numbers[n], cuts);
        median_cut_lights(&m, cuts, count, cpu);
        gl_median_cut_cuts(&g, numbers[n]);
        gl_median_cut_lights(&g, numbers[n]);
        const int read = gl_median_cut_read(&g, found);
        const bool full = n < NUMBERS - 1;
        CHECK(read == count && (full ? count == numbers[n] : count > numbers[n] * 3 / 4),
              "%d and %d lights, not %d", read, count, numbers[n]);
        double sum = 0;
        for (int i = 0; i < read; i++) {
            int nearest = 0;
            for (int k = 1; k < count; k++) {
                if (distance(found[i].direction, cpu[k].direction) <
                    distance(found[i].direction, cpu[nearest].direction))
                    nearest = k;
            }
            const double off = difference(&found[i], &cpu[nearest]);
            CHECK(!full || off < 1e-3, "light %d of %d differs by %g", i, read, off);
            if (full) worst = fmax(worst, off);
            sum += (double)found[i].irradiance[1];
        }
        CHECK(fabs(sum / total[1] - 1) < 1e-3, "%d lights carry %g of %g", read, sum, total[1]);
    }
    CHECK(gl.GetError() == GL_NO_ERROR, "a GL error is pending");
    test_note("lights differ by %.1e at most", worst);
    if (created) gl_median_cut_free(&g);
    median_cut_free(&m);
    test_probe_free(&p);
    gl_context_destroy(&context);
}

const test_case figures_tests[] = {
    {"figures: OpenGL finds the CPU's median cut", gl_finds_the_cpus_median_cut},
    {NULL, NULL},
};
