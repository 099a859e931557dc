// Nanoseconds per bound on visibility, next to the published algorithms in the same run.
//     make bench                                          calls one by one, as -O2 compiles them
//     CFLAGS="-O3 -march=native -fno-math-errno -fno-trapping-math" make bench config=vector
//                                                         arrays, vectorised
// The published side returns one bound, the library both. Rounds are interleaved, medians printed.
#define _POSIX_C_SOURCE 199309L // clock_gettime
#include "../../mssm.h"
#include "../support/published_moments.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#if defined __GNUC__
#define NOINLINE __attribute__((noinline))
#else
#define NOINLINE
#endif

enum { COUNT = 4096, ROUNDS = 31 };

// ---- what is measured ----------------------------------------------------------------------

static float rows[6][COUNT], depth[COUNT], lower[COUNT], upper[COUNT];
static float moments4[COUNT][4], moments6[COUNT][6];
static volatile float sink;

NOINLINE static float call_published4(mssm_moments4 m, float z)
{
    return published4(m.b, z);
}

NOINLINE static float call_published6(mssm_moments6 m, float z)
{
    return published6(m.b, z);
}

NOINLINE static float call_published6_short(mssm_moments6 m, float z)
{
    return published6_short(m.b, z);
}

NOINLINE static void scalar_published4(void)
{
    for (int i = 0; i < COUNT; i++) {
        mssm_moments4 m;
        memcpy(m.b, moments4[i], sizeof m.b);
        upper[i] = call_published4(m, depth[i]);
    }
}

NOINLINE static void scalar_published6(void)
{
    for (int i = 0; i < COUNT; i++) {
        mssm_moments6 m;
        memcpy(m.b, moments6[i], sizeof m.b);
        upper[i] = call_published6(m, depth[i]);
    }
}

NOINLINE static void scalar_published6_short(void)
{
    for (int i = 0; i < COUNT; i++) {
        mssm_moments6 m;
        memcpy(m.b, moments6[i], sizeof m.b);
        upper[i] = call_published6_short(m, depth[i]);
    }
}

NOINLINE static void scalar_mssm4(void)
{
    for (int i = 0; i < COUNT; i++) {
        mssm_moments4 m;
        memcpy(m.b, moments4[i], sizeof m.b);
        upper[i] = mssm_visibility4(m, depth[i]).upper;
    }
}

NOINLINE static void scalar_mssm6(void)
{
    for (int i = 0; i < COUNT; i++) {
        mssm_moments6 m;
        memcpy(m.b, moments6[i], sizeof m.b);
        upper[i] = mssm_visibility6(m, depth[i]).upper;
    }
}

NOINLINE static void array_published4(void)
{
    for (int i = 0; i < COUNT; i++) {
        const float b[4] = {rows[0][i], rows[1][i], rows[2][i], rows[3][i]};
        upper[i] = published4(b, depth[i]);
    }
}

NOINLINE static void array_published6(void)
{
    for (int i = 0; i < COUNT; i++) {
        const float b[6] = {rows[0][i], rows[1][i], rows[2][i], rows[3][i], rows[4][i], rows[5][i]};
        upper[i] = published6(b, depth[i]);
    }
}

NOINLINE static void array_published6_short(void)
{
    for (int i = 0; i < COUNT; i++) {
        const float b[6] = {rows[0][i], rows[1][i], rows[2][i], rows[3][i], rows[4][i], rows[5][i]};
        upper[i] = published6_short(b, depth[i]);
    }
}

NOINLINE static void array_mssm4(void)
{
    const float *b[4] = {rows[0], rows[1], rows[2], rows[3]};
    mssm_visibility4_array(COUNT, b, depth, lower, upper);
}

NOINLINE static void array_mssm6(void)
{
    const float *b[6] = {rows[0], rows[1], rows[2], rows[3], rows[4], rows[5]};
    mssm_visibility6_array(COUNT, b, depth, lower, upper);
}

// ---- inputs and clock ----------------------------------------------------------------------

static double uniform(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (double)(*state >> 11) * (1.0 / 9007199254740992.0);
}

// 1 to 12 depths and a receiver anywhere, at a bias where the published algorithms do not break
// down.
static void fill(void)
{
    uint64_t state = 1;
    for (int i = 0; i < COUNT; i++) {
        mssm_moments6 m = {{0}};
        double sum[6] = {0}, total = 0;
        const int depths = 1 + (int)(uniform(&state) * 12);
        for (int k = 0; k < depths; k++) {
            const double z = uniform(&state) * 2 - 1, w = uniform(&state) + 0.05;
            double power = w;
            for (int j = 0; j < 6; j++) sum[j] += power *= z;
            total += w;
        }
        for (int j = 0; j < 6; j++) m.b[j] = (float)(sum[j] / total);
        m = mssm_moments6_bias(m, 1e-4f);
        for (int j = 0; j < 6; j++) rows[j][i] = moments6[i][j] = m.b[j];
        memcpy(moments4[i], m.b, sizeof moments4[i]);
        depth[i] = (float)(uniform(&state) * 2 - 1);
    }
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

typedef struct contest {
    const char *name;
    void (*run[2])(void); // published, library
    double time[2][ROUNDS];
} contest;

static void measure(contest *c, int round)
{
    for (int side = 0; side < 2; side++) {
        const double start = seconds();
        for (int i = 0; i < 8; i++) c->run[side]();
        c->time[side][round] = (seconds() - start) / (8.0 * COUNT) * 1e9;
        sink = upper[round];
    }
}

// Largest and mean difference of the two sides' results: both must compute the same.
static void compare(const contest *c)
{
    static float first[COUNT];
    double sum = 0;
    int broken = 0, apart = 0;
    c->run[0]();
    memcpy(first, upper, sizeof first);
    c->run[1]();
    for (int i = 0; i < COUNT; i++) {
        const double d = fabs((double)first[i] - (double)upper[i]);
        if (d - d != 0)
            broken++;
        else
            sum += d;
        apart += d > 0.01;
    }
    printf("%-18s differ by %.1e on average, by over .01 in %d of %d, published not finite in %d\n",
           c->name, sum / COUNT, apart, COUNT, broken);
}

int main(void)
{
    static contest contests[] = {
        {"4 moments, calls", {scalar_published4, scalar_mssm4}, {{0}, {0}}},
        {"6 moments, calls", {scalar_published6, scalar_mssm6}, {{0}, {0}}},
        {"  without shares", {scalar_published6_short, scalar_mssm6}, {{0}, {0}}},
        {"4 moments, arrays", {array_published4, array_mssm4}, {{0}, {0}}},
        {"6 moments, arrays", {array_published6, array_mssm6}, {{0}, {0}}},
        {"  without shares", {array_published6_short, array_mssm6}, {{0}, {0}}}};
    enum { CONTESTS = sizeof contests / sizeof *contests };
    fill();
    for (int c = 0; c < CONTESTS; c++) compare(&contests[c]);
    for (int round = 0; round < ROUNDS; round++) {
        for (int c = 0; c < CONTESTS; c++) measure(&contests[c], round);
    }
    printf("\n%-18s %12s %12s %8s\n", "ns per bound", "published", "mssm.h", "ratio");
    for (int c = 0; c < CONTESTS; c++) {
        double median[2];
        for (int side = 0; side < 2; side++) {
            qsort(contests[c].time[side], ROUNDS, sizeof(double), ascending);
            median[side] = contests[c].time[side][ROUNDS / 2];
        }
        printf("%-18s %12.2f %12.2f %8.2f\n", contests[c].name, median[0], median[1],
               median[0] / median[1]);
    }
    return 0;
}
