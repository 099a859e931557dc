// Pictures of probes: panoramas, crosses and strips to cubes, against sums of their own pixels and
// against points spread over texels; cubes without lights against what was to be taken off.
#include "../support/test.h"

#include "../../lightprobe.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

static void *allocate(size_t bytes)
{
    void *memory = malloc(bytes);
    if (!memory) abort();
    return memory;
}

static double corner(double s, double t)
{
    return atan2(s * t, sqrt(1 + s * s + t * t));
}

// The usual difference of four corners, in double.
static double solid_angle(int side, int x, int y)
{
    const double s = 2.0 * x / side - 1, t = 2.0 * y / side - 1, u = s + 2.0 / side,
                 v = t + 2.0 / side;
    return corner(u, v) - corner(s, v) - corner(u, t) + corner(s, t);
}

// DESIGN 2, written out.
static void direction(int face, double s, double t, double d[3])
{
    const double all[6][3] = {{1, -t, -s}, {-1, -t, s}, {s, 1, t},
                              {s, -1, -t}, {s, -t, 1},  {-s, -t, -1}};
    memcpy(d, all[face], sizeof all[face]);
}

static double energy(const float *texels, int side, int channel)
{
    double sum = 0;
    for (int i = 0; i < 6 * side * side; i++)
        sum += solid_angle(side, i % side, i / side % side) * (double)texels[3 * i + channel];
    return sum;
}

// ---- Panoramas

static double panorama_energy(const float *rgb, int width, int height, int channel)
{
    double sum = 0;
    for (int i = 0; i < width * height; i++) {
        const int y = i / width;
        sum += 2 * PI / width * (cos(PI * y / height) - cos(PI * (y + 1) / height)) *
               (double)rgb[3 * i + channel];
    }
    return sum;
}

static void panoramas_keep_their_energy(void)
{
    const int sizes[][3] = {{1, 1, 1},    {2, 1, 1},      {1, 1, 8},      {2, 1, 5},
                            {3, 5, 7},    {5, 2, 2},      {16, 8, 16},    {7, 300, 6},
                            {3, 700, 2},  {300, 3, 9},    {37, 91, 9},    {64, 32, 4},
                            {128, 64, 1}, {511, 255, 12}, {640, 320, 32}, {12, 6, 40}};
    uint64_t random = 4;
    double off = 0, flat = 0;
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        const int w = sizes[k][0], h = sizes[k][1], side = sizes[k][2];
        const size_t values = 3 * (size_t)w * (size_t)h;
        float *rgb = allocate(values * sizeof *rgb),
              *texels = allocate(18 * (size_t)(side * side) * sizeof *texels);
        const lightprobe_image image = {rgb, w, h, 3, 0, LIGHTPROBE_LAT_LONG};
        for (int mode = 0; mode < 3; mode++) {
            lightprobe_cube cube;
            int repaired = -1;
            for (size_t i = 0; i < values; i++)
                rgb[i] = mode == 0 ? 2.5f : (float)pow(test_uniform(&random), mode == 1 ? 1 : 20);
            if (mode == 2) rgb[test_random(&random) % values] = 65504;
            CHECK(!lightprobe_cube_from_image(&image, side, texels, &cube, &repaired), "failed");
            CHECK(repaired == 0 && cube.side == side && cube.channels == 3 &&
                      cube.face[5] == texels + 15 * side * side,
                  "cube");
            for (int c = 0; c < 3; c++) {
                const double want = panorama_energy(rgb, w, h, c), got = energy(texels, side, c);
                off = fmax(off, fabs(got / want - 1));
                CHECK(fabs(got / want - 1) < 1e-6, "%d x %d to %d, mode %d: %.9g for %.9g", w, h,
                      side, mode, got, want);
            }
            for (int i = 0; i < 18 * side * side; i++) {
                if (mode == 0) flat = fmax(flat, fabs((double)texels[i] / 2.5 - 1));
                CHECK(texels[i] >= 0 && texels[i] <= 65504, "texel %d", i / 3);
            }
        }
        free(rgb);
        free(texels);
    }
    CHECK(flat < 1e-6, "a constant is off by %g", flat);
    test_note("energy is off by at most %.1e, a constant by %.1e", off, flat);
}

// A texel's mean against 250 x 250 points in it.
static void panoramas_are_where_they_belong(void)
{
    const int sizes[][3] = {{24, 12, 6},  {24, 12, 5}, {37, 91, 4}, {9, 4, 16},
                            {100, 50, 1}, {3, 2, 3},   {1, 9, 2}};
    uint64_t random = 14;
    double worst = 0;
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        const int w = sizes[k][0], h = sizes[k][1], side = sizes[k][2];
        static float rgb[3 * 37 * 200], texels[18 * 16 * 16];
        const lightprobe_image image = {rgb, w, h, 3, 0, LIGHTPROBE_LAT_LONG};
        for (int i = 0; i < 3 * w * h; i++) rgb[i] = (float)test_uniform(&random);
        CHECK(!lightprobe_cube_from_image(&image, side, texels, NULL, NULL), "failed");
        for (int trial = 0; trial < 40; trial++) {
            const int texel = (int)(test_random(&random) % (unsigned)(6 * side * side));
            const int x = texel % side, y = texel / side % side;
            double sum = 0, weights = 0;
            for (int i = 0; i < 250 * 250; i++) {
                const double s = 2 * (x + (i % 250 + 0.5) / 250) / side - 1,
                             t = 2 * (y + (i / 250 + 0.5) / 250) / side - 1;
                double d[3];
                direction(texel / side / side, s, t, d);
                const double length = sqrt(1 + s * s + t * t),
                             weight = 1 / (length * length * length);
                const int column = (int)((atan2(d[0], -d[2]) / (2 * PI) + 0.5) * w) % w;
                const int row = (int)(acos(d[1] / length) / PI * h);
                weights += weight;
                sum += weight * (double)rgb[3 * ((row < h ? row : h - 1) * w + column) + 1];
            }
            const double off = fabs((double)texels[3 * texel + 1] - sum / weights);
            worst = fmax(worst, off);
            CHECK(off < 2e-3, "%d x %d to %d, texel %d: %g for %g", w, h, side, texel,
                  (double)texels[3 * texel + 1], sum / weights);
        }
    }
    test_note("texels are off by at most %.1e, which the points are", worst);
}

static void halves_are_floats(void)
{
    for (int h = 0; h < 65536; h++) {
        const uint16_t half[4] = {(uint16_t)h, 0x3c00, 0x4000, 0xffff}; // -, 1, 2, not read
        const lightprobe_image image = {half, 1, 1, 4, 1, LIGHTPROBE_LAT_LONG};
        const int exponent = h >> 10 & 31, fraction = h & 1023;
        double want = exponent ? ldexp(1024 + fraction, exponent - 25) : ldexp(fraction, -24);
        int repaired = -1, bad = (h & 0x8000) && h != 0x8000;
        float texels[18];
        if (exponent == 31) want = fraction ? 0 : 65504, bad = 1;
        if (h & 0x8000) want = 0;
        CHECK(!lightprobe_cube_from_image(&image, 1, texels, NULL, &repaired), "failed");
        CHECK((double)texels[0] == want && texels[1] == 1 && texels[17] == 2, "%04x is %g, not %g",
              h, (double)texels[0], want);
        CHECK(repaired == bad, "%04x: %d repaired", h, repaired);
        const lightprobe_image grey = {half, 1, 1, 1, 1, LIGHTPROBE_LAT_LONG};
        CHECK(!lightprobe_cube_from_image(&grey, 1, texels, NULL, NULL), "failed");
        CHECK((double)texels[0] == want && texels[1] == texels[0] && texels[17] == texels[0],
              "grey %04x", h);
    }
}

static void broken_pixels_are_repaired(void)
{
    const float hostile[6] = {-1, NAN, INFINITY, -INFINITY, FLT_MAX, 1e30f};
    float rgb[3 * 8 * 4], texels[18 * 4];
    const lightprobe_image image = {rgb, 8, 4, 3, 0, LIGHTPROBE_AUTO};
    for (int k = 0; k < 6; k++) {
        int repaired = -1;
        for (int i = 0; i < 3 * 32; i++) rgb[i] = 1;
        rgb[3 * 10 + 1] = rgb[3 * 20 + 2] = rgb[3 * 20] = rgb[3 * 25 + 2] = hostile[k];
        CHECK(!lightprobe_cube_from_image(&image, 2, texels, NULL, &repaired), "failed");
        CHECK(repaired == (k < 4 ? 3 : 0), "%g: %d repaired", (double)hostile[k], repaired);
        rgb[3 * 10 + 1] = k == 2 ? 65504 : k < 4 ? 0 : hostile[k];
        const double want = panorama_energy(rgb, 8, 4, 1), got = energy(texels, 2, 1);
        CHECK(fabs(got / want - 1) < 1e-6, "%g: energy %g for %g", (double)hostile[k], got, want);
    }
    // As bright as the brightest, where the picture holds more than half floats can.
    rgb[0] = INFINITY;
    rgb[3] = 1e6f;
    CHECK(!lightprobe_cube_from_image(&image, 2, texels, NULL, NULL), "failed");
    rgb[0] = 1e30f; // at 20
    CHECK(fabs(energy(texels, 2, 0) / panorama_energy(rgb, 8, 4, 0) - 1) < 1e-6, "the sun is lost");
    // Grey is all three.
    const lightprobe_image grey = {rgb, 8, 4, 1, 0, LIGHTPROBE_AUTO};
    for (int i = 0; i < 32; i++) rgb[i] = (float)i;
    CHECK(!lightprobe_cube_from_image(&grey, 2, texels, NULL, NULL), "failed");
    for (int i = 0; i < 24; i++)
        CHECK(texels[3 * i] == texels[3 * i + 2], "texel %d is coloured", i);
}

// ---- Crosses and strips

// Every pixel has a number of its own; those that are neighbours in the picture, also across the
// edges of faces, are neighbours on the sphere.
static void layouts_fold_to_cubes(void)
{
    enum { N = 6, SIZE = 6 * N };
    static float rgb[3 * SIZE * SIZE], texels[18 * N * N];
    static double at[SIZE * SIZE][3];
    // Width and height in faces, and the faces of the picture that are +Z and +Y.
    const int sizes[4][6] = {
        {4, 3, 1, 1, 1, 0}, {3, 4, 1, 1, 1, 0}, {6, 1, 4, 0, 2, 0}, {1, 6, 0, 4, 0, 2}};
    for (int k = 0; k < 8; k++) {
        const int *size = sizes[k % 4], w = N * size[0], h = N * size[1], strip = k % 4 > 1;
        const lightprobe_image image = {
            rgb, w, h, 3, 0, k < 4 ? LIGHTPROBE_AUTO : strip ? LIGHTPROBE_STRIP : LIGHTPROBE_CROSS};
        int joins = 0, repaired = -1;
        for (int i = 0; i < w * h; i++) {
            rgb[3 * i] = rgb[3 * i + 1] = rgb[3 * i + 2] = (float)i;
            at[i][0] = at[i][1] = at[i][2] = 0;
        }
        CHECK(lightprobe_image_side(&image) == N, "side %d", lightprobe_image_side(&image));
        CHECK(!lightprobe_cube_from_image(&image, N, texels, NULL, &repaired) && repaired == 0,
              "failed");
        for (int i = 0; i < 6 * N * N; i++) {
            const double s = (2 * (i % N) + 1.0) / N - 1, t = (2 * (i / N % N) + 1.0) / N - 1;
            const int pixel = (int)texels[3 * i];
            CHECK((float)pixel == texels[3 * i] && at[pixel][0] == 0 && at[pixel][1] == 0,
                  "pixel %d twice", pixel);
            direction(i / N / N, s, t, at[pixel]);
        }
        for (int i = 0; i < w * h; i++) {
            for (int way = 0; way < 2; way++) {
                const int other = way ? i + w : i + 1, x = i % w, y = i / w;
                if (way ? y + 1 == h || (strip && (y + 1) % N == 0)
                        : x + 1 == w || (strip && (x + 1) % N == 0))
                    continue;
                double far = 0, used = 1;
                for (int c = 0; c < 3; c++) far = fmax(far, fabs(at[i][c] - at[other][c]));
                for (int c = 0, a = 0, b = 0; c < 3; c++) {
                    a |= at[i][c] != 0, b |= at[other][c] != 0;
                    used = a && b;
                }
                joins += used && (way ? (y + 1) % N : (x + 1) % N) == 0;
                CHECK(!used || far <= 2.0 / N + 1e-9, "layout %d: pixels %d and %d are %g apart", k,
                      i, other, far);
            }
        }
        CHECK(strip || joins == 5 * N, "layout %d: %d pixels join", k, joins);
        const double *z = at[(size[3] * N + N / 2) * w + size[2] * N + N / 2],
                     *y = at[(size[5] * N + N / 2) * w + size[4] * N + N / 2];
        CHECK(z[2] == 1 && y[1] == 1, "layout %d: +Z is at %g, +Y at %g", k, z[2], y[1]);
    }
}

static void faces_change_their_side(void)
{
    static float rgb[3 * 44 * 33], texels[18 * 40 * 40];
    const lightprobe_image image = {rgb, 44, 33, 3, 0, LIGHTPROBE_AUTO}; // faces of 11 x 11
    uint64_t random = 6;
    double want = 0;
    for (int i = 0; i < 3 * 44 * 33; i++) rgb[i] = (float)test_uniform(&random);
    CHECK(!lightprobe_cube_from_image(&image, 11, texels, NULL, NULL), "failed");
    want = energy(texels, 11, 2);
    for (int side = 1; side <= 40; side++) {
        CHECK(!lightprobe_cube_from_image(&image, side, texels, NULL, NULL), "failed");
        const double got = energy(texels, side, 2);
        CHECK(fabs(got / want - 1) < 1e-6, "side %d: %.9g for %.9g", side, got, want);
    }
    // Two by two texels to one: their mean by solid angle.
    CHECK(!lightprobe_cube_from_image(&image, 22, texels, NULL, NULL), "failed");
    const float fine = texels[0];
    CHECK(fine == rgb[3 * (11 * 44 + 22)], "an upper left texel of +X is %g", (double)fine);
}

static void bad_pictures_are_refused(void)
{
    float rgb[3 * 8] = {0}, texels[18] = {7};
    lightprobe_cube cube = {{NULL}, 77, 4};
    int repaired = 5;
    const lightprobe_image good = {rgb, 4, 2, 3, 0, 0};
    const struct {
        lightprobe_image image;
        int side;
        lightprobe_result result;
    } bad[] = {
        {{NULL, 4, 2, 3, 0, 0}, 1, LIGHTPROBE_ERROR_NULL},
        {{rgb, 4, 2, 3, 0, 0}, 0, LIGHTPROBE_ERROR_SIDE},
        {{rgb, 4, 2, 3, 0, 0}, LIGHTPROBE_MAX_SIDE + 1, LIGHTPROBE_ERROR_SIDE},
        {{rgb, 4, 2, 2, 0, 0}, 1, LIGHTPROBE_ERROR_CHANNELS},
        {{rgb, 4, 2, 5, 0, 0}, 1, LIGHTPROBE_ERROR_CHANNELS},
        {{rgb, 0, 0, 3, 0, 1}, 1, LIGHTPROBE_ERROR_IMAGE},
        {{rgb, 2, -1, 3, 0, 1}, 1, LIGHTPROBE_ERROR_IMAGE},
        {{rgb, 32769, 1, 3, 0, 1}, 1, LIGHTPROBE_ERROR_IMAGE},
        {{rgb, 1, 32769, 3, 0, 1}, 1, LIGHTPROBE_ERROR_IMAGE},
        {{rgb, 5, 1, 3, 0, 0}, 1, LIGHTPROBE_ERROR_IMAGE},
        {{rgb, 1, 5, 3, 0, 0}, 1, LIGHTPROBE_ERROR_IMAGE},
        {{rgb, 2, 1, 3, 0, LIGHTPROBE_CROSS}, 1, LIGHTPROBE_ERROR_IMAGE},
        {{rgb, 2, 1, 3, 0, LIGHTPROBE_STRIP}, 1, LIGHTPROBE_ERROR_IMAGE},
        {{rgb, 4, 3, 3, 0, LIGHTPROBE_STRIP}, 1, LIGHTPROBE_ERROR_IMAGE},
        {{rgb, 6, 1, 3, 0, LIGHTPROBE_CROSS}, 1, LIGHTPROBE_ERROR_IMAGE},
        {{rgb, 2, 1, 3, 0, 9}, 1, LIGHTPROBE_ERROR_IMAGE},
        {{rgb, 4, 3, 3, 0, -1}, 1, LIGHTPROBE_ERROR_IMAGE},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        CHECK(lightprobe_cube_from_image(&bad[i].image, bad[i].side, texels, &cube, &repaired) ==
                  bad[i].result,
              "case %d", (int)i);
        if (bad[i].result == LIGHTPROBE_ERROR_IMAGE)
            CHECK(lightprobe_image_side(&bad[i].image) == 0, "case %d has a side", (int)i);
    }
    CHECK(lightprobe_cube_from_image(NULL, 1, texels, &cube, &repaired) == LIGHTPROBE_ERROR_NULL,
          "no picture");
    CHECK(lightprobe_cube_from_image(&good, 1, NULL, &cube, &repaired) == LIGHTPROBE_ERROR_NULL,
          "no texels");
    CHECK(texels[0] == 7 && cube.side == 77 && cube.channels == 4 && !cube.face[0] && repaired == 5,
          "touched");
    CHECK(lightprobe_image_side(NULL) == 0 && lightprobe_image_side(&good) == 1, "sides");
    const lightprobe_image odd[4] = {
        {rgb, 3, 2, 3, 0, 0}, {rgb, 1, 1, 3, 0, 0}, {rgb, 17, 8, 3, 0, 0}, {rgb, 900, 20, 3, 0, 1}};
    for (int i = 0; i < 4; i++)
        CHECK(lightprobe_image_side(&odd[i]) == (i < 2 ? 1 : odd[i].width / 4), "odd panorama %d",
              i);
    CHECK(strstr(lightprobe_result_string(LIGHTPROBE_ERROR_IMAGE), "proportions"), "words");
}

// ---- Cubes without lights

enum { SIDE = 24, VALUES = 18 * SIDE * SIDE };

// A small sun of this radiance in a sky that grows towards it, on a dark ground.
static void make_sky(float *texels, lightprobe_cube *cube, float sun)
{
    for (int i = 0; i < VALUES; i++) {
        const int texel = i / 3;
        double d[3], length = 0, towards = 0;
        direction(texel / SIDE / SIDE, (2 * (texel % SIDE) + 1.0) / SIDE - 1,
                  (2 * (texel / SIDE % SIDE) + 1.0) / SIDE - 1, d);
        for (int k = 0; k < 3; k++) length += d[k] * d[k];
        towards = (0.6 * d[0] + 0.64 * d[1] + 0.48 * d[2]) / sqrt(length);
        texels[i] =
            (float)(d[1] < 0 ? 0.1 : 1 + 3 * pow(fmax(towards, 0), 20)) * (i % 3 == 2 ? 1.5f : 1);
        if (towards > 0.994) texels[i] += sun;
    }
    *cube = (lightprobe_cube){{NULL}, SIDE, 3};
    for (int f = 0; f < 6; f++) cube->face[f] = texels + 3 * f * SIDE * SIDE;
}

static void lights_are_taken_off(void)
{
    static float texels[VALUES], rest[VALUES];
    lightprobe_cube cube;
    lightprobe_light light[16];
    for (int most = 1; most <= 16; most *= 4) {
        const lightprobe_settings settings = {.max_lights = most, .tolerance = 1e-6f};
        const size_t bytes = lightprobe_scratch_bytes(SIDE, most);
        void *scratch = allocate(bytes);
        int found = 0;
        make_sky(texels, &cube, 500);
        CHECK(!lightprobe_extract(&cube, &settings, scratch, bytes, light, &found, NULL) &&
                  found > 0,
              "no lights");
        free(scratch);
        for (int count = 0; count <= found; count += found > 4 ? 4 : 1) {
            CHECK(!lightprobe_cube_without(&cube, light, count, rest), "failed");
            for (int c = 0; c < 3; c++) {
                double want = energy(texels, SIDE, c), off;
                for (int i = 0; i < count; i++) want -= (double)light[i].irradiance[c];
                off = (energy(rest, SIDE, c) - want) / energy(texels, SIDE, c);
                CHECK(fabs(off) < 1e-5, "%d of %d lights, channel %d: off by %g", count, found, c,
                      off);
            }
            for (int i = 0; i < VALUES; i++)
                CHECK(rest[i] >= 0 && rest[i] <= texels[i], "texel %d became %g", i / 3,
                      (double)rest[i]);
            if (count == 0) CHECK(!memcmp(rest, texels, sizeof rest), "nothing taken off changes");
        }
    }
}

// Of a light that is the sun alone the sky stays, with no hole, and nothing else is touched.
static void a_sun_leaves_its_sky(void)
{
    static float bright[VALUES], dull[VALUES], rest[VALUES];
    lightprobe_cube cube, without;
    lightprobe_light sun = {{0.6f, 0.64f, 0.48f},
                            {0.8f, -0.48f, -0.36f},
                            {0, 0.6f, -0.8f},
                            0.11f,
                            0.11f,
                            {0, 0, 0},
                            0.04f,
                            0.99f,
                            1,
                            0,
                            0,
                            0,
                            {0}};
    make_sky(dull, &without, 0);
    make_sky(bright, &cube, 500);
    for (int c = 0; c < 3; c++)
        sun.irradiance[c] = (float)(energy(bright, SIDE, c) - energy(dull, SIDE, c));
    CHECK(!lightprobe_cube_without(&cube, &sun, 1, rest), "failed");
    double worst = 0;
    for (int i = 0; i < VALUES; i++) {
        worst = fmax(worst, fabs((double)rest[i] / (double)dull[i] - 1));
        if (bright[i] < 100 && dull[i] < 3)
            CHECK(rest[i] == bright[i], "texel %d is touched", i / 3);
    }
    CHECK(worst < 0.2, "the sky behind is off by %g", worst);
    test_note("the sky behind the sun is right to %.1f%%", 100 * worst);
}

static void hostile_lights_do_no_harm(void)
{
    static float texels[VALUES], rest[VALUES], four[VALUES / 3 * 4];
    lightprobe_cube cube;
    const lightprobe_light good = {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}, 0.2f, 0.2f, {1, 0, 2}, 0.1f,
                                   0.9f,      1,         0,         0,    0,    {0}};
    make_sky(texels, &cube, 1);
    const double all = energy(texels, SIDE, 0);
    for (int k = 0; k < 9; k++) {
        lightprobe_light l = good;
        double want = all - 1;
        if (k == 0) l.irradiance[0] = 1e30f, want = 0;
        if (k == 1) l.irradiance[0] = INFINITY, want = 0;
        if (k == 2) l.irradiance[0] = NAN, want = all;
        if (k == 3) l.irradiance[0] = -5, want = all;
        if (k == 4) l.direction[0] = NAN;
        if (k == 5) l.tan_half_u = INFINITY;
        if (k == 6) l.tan_half_u = l.tan_half_v = 0;
        if (k == 7) l.tan_half_v = NAN;
        if (k == 8)
            l.irradiance[0] = (float)(all * 0.9), want = all * 0.1; // more than the rectangle holds
        CHECK(!lightprobe_cube_without(&cube, &l, 1, rest), "failed");
        const double got = energy(rest, SIDE, 0);
        CHECK(fabs(got - want) < 1e-5 * all, "case %d: %g for %g", k, got, want);
        for (int i = 0; i < VALUES; i++)
            CHECK(rest[i] >= 0 && rest[i] <= texels[i], "case %d, texel %d", k, i / 3);
    }
    // So little of so much that the level's digits run out.
    for (int k = 0; k < 50; k++) {
        lightprobe_light l = good;
        for (int i = 0; i < VALUES; i++) texels[i] = 1e6f;
        for (int c = 0; c < 3; c++) l.irradiance[c] = (float)exp2(-k);
        CHECK(!lightprobe_cube_without(&cube, &l, 1, rest), "failed");
        for (int i = 0; i < VALUES; i++)
            CHECK(rest[i] > 0.99e6f && rest[i] <= 1e6f, "texel %d is %g", i / 3, (double)rest[i]);
    }
    // Bad channels of the cube, and a fourth that is not read.
    for (int i = 0; i < VALUES / 3; i++) {
        memcpy(four + 4 * i, texels + 3 * i, 3 * sizeof *four);
        four[4 * i + 3] = NAN;
    }
    four[0] = NAN, four[5] = -1, four[10] = INFINITY;
    cube.channels = 4;
    for (int f = 0; f < 6; f++) cube.face[f] = four + 4 * f * SIDE * SIDE;
    CHECK(!lightprobe_cube_without(&cube, NULL, 0, rest), "no lights");
    CHECK(rest[0] == 0 && rest[4] == 0 && rest[8] == 0 &&
              !memcmp(rest + 9, texels + 9, sizeof rest - 36),
          "channels");

    rest[0] = 7;
    const lightprobe_cube kept = cube;
    CHECK(lightprobe_cube_without(NULL, &good, 1, rest) == LIGHTPROBE_ERROR_NULL, "no cube");
    CHECK(lightprobe_cube_without(&cube, NULL, 1, rest) == LIGHTPROBE_ERROR_NULL, "no lights");
    CHECK(lightprobe_cube_without(&cube, &good, 1, NULL) == LIGHTPROBE_ERROR_NULL, "no texels");
    CHECK(lightprobe_cube_without(&cube, &good, -1, rest) == LIGHTPROBE_ERROR_LIGHTS, "-1 lights");
    for (int k = 0; k < 5; k++) {
        const lightprobe_result want = k == 0  ? LIGHTPROBE_ERROR_NULL
                                       : k < 3 ? LIGHTPROBE_ERROR_SIDE
                                               : LIGHTPROBE_ERROR_CHANNELS;
        cube = kept;
        if (k == 0) cube.face[3] = NULL;
        if (k == 1) cube.side = 0;
        if (k == 2) cube.side = LIGHTPROBE_MAX_SIDE + 1;
        if (k > 2) cube.channels = k == 3 ? 2 : 5;
        CHECK(lightprobe_cube_without(&cube, &good, 1, rest) == want, "cube %d", k);
    }
    CHECK(rest[0] == 7, "touched");
}

const test_case images_tests[] = {
    {"images: panoramas of any size keep their energy", panoramas_keep_their_energy},
    {"images: panoramas are where they belong", panoramas_are_where_they_belong},
    {"images: half floats are floats", halves_are_floats},
    {"images: broken pixels are counted, infinite ones stay bright", broken_pixels_are_repaired},
    {"images: crosses and strips fold to cubes", layouts_fold_to_cubes},
    {"images: faces may change their side", faces_change_their_side},
    {"images: bad pictures are refused", bad_pictures_are_refused},
    {"images: lights are taken off with their energy", lights_are_taken_off},
    {"images: a sun leaves its sky", a_sun_leaves_its_sky},
    {"images: hostile lights do no harm", hostile_lights_do_no_harm},
    {0, 0},
};
