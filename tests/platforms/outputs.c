// A fixed set of results of both headers, to be compared between compilers and processors.
//     outputs                 prints them, one a line: group, bits
//     outputs THIS REFERENCE  compares two such files: a cell of a table per group, = or the largest
//                             difference (relative to the largest value of the group, at least 1)
// All inputs are small integers over powers of two, so that they are the same everywhere.
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../lightprobe.h"
#include "../../mssm.h"

enum { BOUNDS4, BOUNDS6, SHARES, CUBIC, TABLES, VISIBILITY, DISC, LIGHTS, GROUPS };
static const char *const group_names[GROUPS] = {"bounds, 4",   "bounds, 6", "depths, shares",
                                                "cubic roots", "tables",    "visibility",
                                                "disc",        "lights"};

static void put(int group, float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    printf("%d %08lx\n", group, (unsigned long)bits);
}

static uint32_t state = 12345;

static int number(int below)
{
    state = state * 1664525u + 1013904223u;
    return (int)((state >> 8) % (uint32_t)below);
}

static void put_bounds(int group, mssm_bounds b)
{
    put(group, b.lower);
    put(group, b.upper);
}

static void put_moments(void)
{
    for (int trial = 0; trial < 2000; trial++) {
        double b[6] = {0};
        for (int i = 0; i < 4; i++) { // a quarter each; exact in double
            const double z = (number(33) - 16) / 16.0;
            double power = 0.25;
            for (int k = 0; k < 6; k++) b[k] += power *= z;
        }
        mssm_moments4 four;
        mssm_moments6 six;
        for (int k = 0; k < 4; k++) four.b[k] = (float)b[k];
        for (int k = 0; k < 6; k++) six.b[k] = (float)b[k];
        four = mssm_moments4_bias(four, 1e-4f);
        six = mssm_moments6_bias(six, 1e-4f);
        const float z = (float)(number(257) - 128) / 128;
        put_bounds(BOUNDS4, mssm_visibility4(four, z));
        put_bounds(BOUNDS6, mssm_visibility6(six, z));
        const mssm_points4 p = mssm_reconstruct6(six, z);
        for (int k = 0; k < 4; k++) {
            if (fabsf(p.z[k]) < 1.5f) put(SHARES, p.z[k]);
            put(SHARES, p.w[k]);
        }
        float c[4];
        for (int k = 0; k < 4; k++) c[k] = (float)(number(2001) - 1000) / 1024;
        const mssm_roots3 r = mssm_solve_cubic(c[0], c[1], c[2], c[3] + 2);
        for (int k = 0; k < 3; k++) put(CUBIC, r.x[k]);
    }
}

static void put_map(void)
{
    enum { side = 96 };
    static float depth[side * side];
    const float direction[3] = {1, 3, 2}, axis[3] = {1, 0, 0}, low[3] = {-1, -1, -1},
                high[3] = {1, 1, 1};
    const size_t bytes = mssm_map_bytes(side, 6);
    void *memory = malloc(bytes);
    mssm_map *map;
    mssm_light light;
    for (int i = 0; i < side * side; i++)
        depth[i] = (i / 7 + i / (side * 9)) % 3 ? 1.0f : (float)(i % 50 - 45) / 64;
    if (!memory || mssm_map_init(&map, memory, bytes, side, 6) ||
        mssm_map_update(map, depth, NULL, 1) ||
        mssm_light_directional(&light, direction, axis, 0.25f, 0.125f, low, high))
        exit(2);
    for (int i = 0; i < 16; i++) put(LIGHTS, light.world_to_shadow[i]);
    for (int trial = 0; trial < 2000; trial++) {
        float p[3];
        for (int k = 0; k < 3; k++) p[k] = (float)(number(257) - 128) / 128;
        put(VISIBILITY, mssm_map_visibility(map, &light, NULL, p));
        const float half = (float)(number(64) + 1) / 64;
        const mssm_moments6 m = mssm_map_moments(map, p[0], p[1], half, half);
        for (int k = 0; k < 6; k++) put(TABLES, m.b[k]);
    }
    free(memory);
}

static void put_probe(void)
{
    enum { side = 20, lights = 24 };
    static float face[6][3 * side * side];
    lightprobe_cube cube = {{0}, side, 3};
    lightprobe_settings s;
    lightprobe_light out[lights];
    int count;
    memset(&s, 0, sizeof s);
    s.max_lights = lights;
    for (int f = 0; f < 6; f++) {
        cube.face[f] = face[f];
        for (int i = 0; i < 3 * side * side; i++)
            face[f][i] = (float)(number(64) + (number(50) ? 0 : 4096)) / 64;
    }
    const size_t bytes = lightprobe_scratch_bytes(side, lights);
    void *scratch = malloc(bytes);
    if (!scratch || lightprobe_extract(&cube, &s, scratch, bytes, out, &count, NULL)) exit(2);
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++) put(LIGHTS, out[i].direction[k]);
        for (int k = 0; k < 3; k++) put(LIGHTS, out[i].irradiance[k]);
        put(LIGHTS, out[i].tan_half_u);
        put(LIGHTS, out[i].cos_alpha);
    }
    for (int i = 0; i < 4000; i++) {
        const float cos_alpha = (float)(number(257) - 128) / 128,
                    cos_theta = (float)(number(257) - 128) / 128;
        put(DISC, lightprobe_disc_irradiance(cos_alpha, cos_theta));
    }
    free(scratch);
}

static int compare(const char *this_one, const char *reference)
{
    FILE *a = fopen(this_one, "r"), *b = fopen(reference, "r");
    double worst[GROUPS] = {0}, largest[GROUPS];
    int group, other, same = a && b;
    unsigned long bits, reference_bits;
    for (int i = 0; i < GROUPS; i++) largest[i] = 1;
    while (same && fscanf(b, "%d %lx", &group, &reference_bits) == 2) {
        float x, y;
        same = fscanf(a, "%d %lx", &other, &bits) == 2 && other == group && group >= 0 &&
               group < GROUPS;
        const uint32_t x_bits = (uint32_t)bits, y_bits = (uint32_t)reference_bits;
        memcpy(&x, &x_bits, sizeof x);
        memcpy(&y, &y_bits, sizeof y);
        if (!same) break;
        largest[group] = fmax(largest[group], fabs((double)y));
        if (x_bits == y_bits) continue;
        const double off = fabs((double)x - (double)y);
        if (!(off <= worst[group]) && worst[group] <= 1e300)
            worst[group] = off + 1e-30; // NaN stays
    }
    if (!same) printf(" not the same results |");
    for (int i = 0; i < GROUPS && same; i++) {
        if (worst[i] > 0 || worst[i] != worst[i])
            printf(" %.0e |", worst[i] / largest[i]);
        else
            printf(" = |");
    }
    printf("\n");
    return !same;
}

int main(int argc, char **argv)
{
    if (argc == 3) return compare(argv[1], argv[2]);
    if (argc == 2) { // the head of the table
        for (int i = 0; i < GROUPS; i++) printf(" %s |", group_names[i]);
        printf("\n");
        return 0;
    }
    put_moments();
    put_map();
    put_probe();
    return 0;
}
