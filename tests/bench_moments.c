// Nanoseconds per bound on visibility, next to the published algorithms in the same run.
//     make bench                                          calls one by one, as -O2 compiles them
//     CFLAGS="-O3 -march=native -fno-math-errno -fno-trapping-math" make bench config=vector
//                                                         arrays, vectorised
// The published side returns one bound, the library both. Rounds are interleaved, medians printed.
#define _POSIX_C_SOURCE 199309L // clock_gettime
#include "../mssm.h"

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

// ---- the published algorithms, written from their papers' description ----------------------

// Moment shadow mapping (Peters and Klein 2015): Cholesky factorisation of the Hankel matrix, its
// solution for (1, z, z^2), the roots of that quadratic, the share of what is nearer in closed
// form.
static inline float published4(const float b[4], float z)
{
    const float l21 = b[2] - b[0] * b[1];
    const float d1 = b[1] - b[0] * b[0];
    const float c21 = l21 / d1;
    const float d2 = (b[3] - b[1] * b[1]) - l21 * c21;
    float c0 = 1, c1 = z, c2 = z * z;
    c1 -= b[0];
    c2 -= b[1] + c21 * c1;
    c1 /= d1;
    c2 /= d2;
    c1 -= c21 * c2;
    c0 -= c1 * b[0] + c2 * b[1];
    const float p = c1 / c2, q = c0 / c2;
    const float root = sqrtf(p * p * 0.25f - q);
    const float z1 = -0.5f * p - root, z2 = -0.5f * p + root;
    if (z <= z1) return 1;
    const float other = z <= z2 ? z : z1;
    const float share =
        (other * z2 - b[0] * (other + z2) + b[1]) / ((z2 - (z <= z2 ? z1 : z)) * (z - z1));
    const float nearer = z <= z2 ? share : 1 + share;
    return 1 - (nearer < 0 ? 0 : nearer > 1 ? 1 : nearer);
}

// The real roots of c0 + c1 x + c2 x^2 + c3 x^3, all assumed real: the trigonometric closed form.
static inline void published_cubic(float c0, float c1, float c2, float c3, float x[3])
{
    const float b = c2 / (3 * c3), c = c1 / (3 * c3), d = c0 / c3;
    const float e = c - b * b, f = d - b * c, g = b * d - c * c;
    const float disc = 4 * e * g - f * f;
    const float depressed = f - 2 * b * e;
    const float angle = atan2f(sqrtf(disc), -depressed) * (1.0f / 3.0f);
    const float cosine = cosf(angle), sine = sinf(angle), size = 2 * sqrtf(-e);
    x[0] = size * cosine - b;
    x[1] = size * (-0.5f * cosine - 0.8660254f * sine) - b;
    x[2] = size * (-0.5f * cosine + 0.8660254f * sine) - b;
}

// The same for six moments: a 4x4 factorisation and the roots of the cubic ...
static inline void published6_depths(const float b[6], float z, float x[3])
{
    const float l21 = b[2] - b[0] * b[1], d1 = b[1] - b[0] * b[0], c21 = l21 / d1;
    const float d2 = (b[3] - b[1] * b[1]) - l21 * c21;
    const float l31 = b[3] - b[0] * b[2], c31 = l31 / d1;
    const float l32 = b[4] - b[1] * b[2] - l31 * c21, c32 = l32 / d2;
    const float d3 = b[5] - b[2] * b[2] - l31 * c31 - l32 * c32;
    float c0 = 1, c1 = z, c2 = z * z, c3 = z * z * z;
    c1 -= b[0];
    c2 -= b[1] + c21 * c1;
    c3 -= b[2] + c31 * c1 + c32 * c2;
    c1 /= d1;
    c2 /= d2;
    c3 /= d3;
    c2 -= c32 * c3;
    c1 -= c21 * c2 + c31 * c3;
    c0 -= b[0] * c1 + b[1] * c2 + b[2] * c3;
    published_cubic(c0, c1, c2, c3, x);
}

// ... and then the shares as solution of the 4x4 Vandermonde system by elimination (image-based
// lighting paper, 4.2: the shares are needed one by one for the blocker depth) ...
static inline float published6(const float b[6], float z)
{
    float n[4], a[4][5];
    n[0] = z;
    published6_depths(b, z, n + 1);
    for (int j = 0; j < 4; j++) {
        a[0][j] = 1;
        a[1][j] = n[j];
        a[2][j] = n[j] * n[j];
        a[3][j] = n[j] * n[j] * n[j];
    }
    a[0][4] = 1;
    a[1][4] = b[0];
    a[2][4] = b[1];
    a[3][4] = b[2];
    for (int i = 0; i < 3; i++) {
        const float inverse = 1 / a[i][i];
        for (int k = i + 1; k < 4; k++) {
            const float factor = a[k][i] * inverse;
            for (int j = i + 1; j < 5; j++) a[k][j] -= factor * a[i][j];
        }
    }
    float w[4];
    for (int i = 3; i >= 0; i--) {
        float sum = a[i][4];
        for (int j = i + 1; j < 4; j++) sum -= a[i][j] * w[j];
        w[i] = sum / a[i][i];
    }
    float nearer = 0;
    for (int j = 1; j < 4; j++) nearer += n[j] < z ? w[j] : 0;
    return 1 - (nearer < 0 ? 0 : nearer > 1 ? 1 : nearer);
}

// ... or, where only the bound is asked for (Peters et al. 2017), the moment of the polynomial
// that is 1 at the depths nearer than z and 0 at the others, interpolated by divided differences.
static inline float published6_short(const float b[6], float z)
{
    float x[3];
    published6_depths(b, z, x);
    const float f1 = x[0] < z ? 1.0f : 0.0f, f2 = x[1] < z ? 1.0f : 0.0f,
                f3 = x[2] < z ? 1.0f : 0.0f;
    const float f01 = f1 / (x[0] - z), f12 = (f2 - f1) / (x[1] - x[0]),
                f23 = (f3 - f2) / (x[2] - x[1]);
    const float f012 = (f12 - f01) / (x[1] - z), f123 = (f23 - f12) / (x[2] - x[0]);
    const float f0123 = (f123 - f012) / (x[2] - z);
    float p0 = f012 - f0123 * x[1], p1 = f0123, p2, p3;
    p2 = p1;
    p1 = p0 - p1 * x[0];
    p0 = f01 - p0 * x[0];
    p3 = p2;
    p2 = p1 - p2 * z;
    p1 = p0 - p1 * z;
    p0 = -p0 * z;
    const float nearer = p0 + p1 * b[0] + p2 * b[1] + p3 * b[2];
    return 1 - (nearer < 0 ? 0 : nearer > 1 ? 1 : nearer);
}

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
