// Summed-area tables: wrap-around at full kernels, kernels wider than planned, float32 sums, map
// edges.
#include "further.h"

#include "../support/families.h"
#include "stored.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

void say(char *text, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vsnprintf(text, FINDING_TEXT, format, list);
    va_end(list);
}

typedef struct depth_map {
    mssm_map *map;
    void *memory;
    float *depth;
    int side;
} depth_map;

static depth_map new_map(int side, int moments)
{
    depth_map m;
    const size_t bytes = mssm_map_bytes(side, moments);
    m.side = side;
    m.memory = malloc(bytes);
    m.depth = (float *)malloc((size_t)(side * side) * sizeof(float));
    if (!m.memory || !m.depth || mssm_map_init(&m.map, m.memory, bytes, side, moments)) abort();
    return m;
}

static void fill(depth_map *m, float z)
{
    for (int i = 0; i < m->side * m->side; i++) m->depth[i] = z;
    if (mssm_map_update(m->map, m->depth, NULL, 1)) abort();
}

static void drop(depth_map *m)
{
    free(m->memory);
    free(m->depth);
}

// Moments of the square of that half-width (texels) around (x, y), in texels.
static mssm_moments6 moments_at(const depth_map *m, double x, double y, double half)
{
    const double scale = 2.0 / m->side;
    return mssm_map_moments(m->map, (float)(x * scale - 1), (float)(y * scale - 1),
                            (float)(half * scale), (float)(half * scale));
}

// Largest error of a moment of a map of one depth, 1 or -1, over kernels of up to `widest` texels.
static double full_kernel_error(int side, double widest)
{
    double worst = 0;
    for (int sign = -1; sign <= 1; sign += 2) {
        depth_map m = new_map(side, 6);
        fill(&m, (float)sign);
        for (double half = 0.5; half <= widest / 2; half *= 1.05) {
            const mssm_moments6 b = moments_at(&m, side * 0.5 + 0.3, side * 0.5 - 0.2, half);
            for (int k = 0; k < 6; k++) {
                const double exact = k % 2 ? 1 : sign;
                worst = fmax(worst, fabs((double)b.b[k] - exact));
            }
        }
        drop(&m);
    }
    return worst;
}

// What a table with this scale says about a lit square (value 1) of that many texels.
static double unsigned_mean(float scale, uint32_t texels)
{
    uint32_t sum = 0;
    for (uint32_t i = 0; i < texels; i++) sum += (uint32_t)((double)scale + 0.5);
    return (double)((float)sum / (scale * (float)texels));
}

static void full_kernels(finding *f)
{
    const double ours = full_kernel_error(64, 27);
    const float slides = (float)(4294967296.0 / 729), tight = (float)floor(4294967295.0 / 729);
    say(f->what, "a kernel of 27 x 27 texels of depth 1 or -1: all that 32 bits were planned for");
    say(f->ours, "moments off by at most %.1e", ours);
    say(f->others,
        "scale 2^32/n: 1 reads as %.3f; floor((2^32-1)/n) without the border of an "
        "interpolated query: 28 x 28 texels read as %.3f",
        unsigned_mean(slides, 729), unsigned_mean(tight, 28 * 28));
    f->holds = ours < 1e-6;
}

static void wider_kernels(finding *f)
{
    const double ours = full_kernel_error(300, 280);
    const float scale = (float)floor(4294967295.0 / (29 * 29));
    say(f->what, "kernels wider than 32 bits were planned for, up to 280 texels");
    say(f->ours, "served by coarser levels: moments off by at most %.1e", ours);
    say(f->others, "one table: value 1 reads as %.3f at 31 x 31 and %.3f at 101 x 101 texels",
        unsigned_mean(scale, 31 * 31), unsigned_mean(scale, 101 * 101));
    f->holds = ours < 1e-6;
}

// Largest error of the mean depth over 9 x 9 kernels near the far corner, float32 prefix sums.
static double float_table_error(int side, uint64_t seed)
{
    const int width = side + 1;
    float *table = (float *)calloc((size_t)(width * width), sizeof *table);
    float *depth = (float *)malloc((size_t)(side * side) * sizeof *depth);
    double worst = 0;
    if (!table || !depth) abort();
    for (int i = 0; i < side * side; i++) depth[i] = (float)family_range(&seed, 0.2, 0.8);
    for (int y = 0; y < side; y++) {
        float run = 0;
        for (int x = 0; x < side; x++) {
            run += depth[y * side + x];
            table[(y + 1) * width + x + 1] = table[y * width + x + 1] + run;
        }
    }
    for (int y = side - 40; y < side - 9; y++) {
        for (int x = side - 40; x < side - 9; x++) {
            double exact = 0;
            for (int i = 0; i < 81; i++) exact += (double)depth[(y + i / 9) * side + x + i % 9];
            const float sum = table[(y + 9) * width + x + 9] - table[(y + 9) * width + x] -
                              table[y * width + x + 9] + table[y * width + x];
            worst = fmax(worst, fabs((double)sum - exact) / 81);
        }
    }
    free(table);
    free(depth);
    return worst;
}

static double our_table_error(int side, uint64_t seed)
{
    depth_map m = new_map(side, 4);
    double worst = 0;
    for (int i = 0; i < side * side; i++) m.depth[i] = (float)family_range(&seed, 0.2, 0.8);
    if (mssm_map_update(m.map, m.depth, NULL, 1)) abort();
    for (int y = side - 40; y < side - 9; y++) {
        for (int x = side - 40; x < side - 9; x++) {
            double exact = 0;
            for (int i = 0; i < 81; i++) exact += (double)m.depth[(y + i / 9) * side + x + i % 9];
            const mssm_moments6 b = moments_at(&m, x + 4.5, y + 4.5, 4.5);
            worst = fmax(worst, fabs((double)b.b[0] - exact / 81));
        }
    }
    drop(&m);
    return worst;
}

static void float_tables(finding *f)
{
    const double ours = our_table_error(1024, 5);
    say(f->what, "9 x 9 kernels in the far corner of maps of noise, 256^2 to 2048^2: mean depth");
    say(f->ours, "1024^2: off by at most %.1e, whatever the side", ours);
    say(f->others, "float32 prefix sums: off by %.1e at 256^2, %.1e at 1024^2, %.1e at 2048^2",
        float_table_error(256, 5), float_table_error(1024, 5), float_table_error(2048, 5));
    f->holds = ours < 2e-6;
}

// A map all at depth -.5, kernels of 20 x 20 around its border and past it. The rim stands for as
// much of what lies outside as the kernel has inside, the rest is depth 1; a table that clamps
// coordinates instead reads nothing there and divides by everything.
static void map_edges(finding *f)
{
    depth_map m = new_map(64, 6);
    double worst = 0, missing = 0;
    fill(&m, -0.5f);
    for (double x = -30; x <= 94; x += 0.7) {
        const double inside = fmax(0, (fmin(x + 10, 64) - fmax(x - 10, 0)) / 20);
        const double known = fmin(1, 2 * inside);
        const mssm_moments6 b = moments_at(&m, x, 32, 10);
        double power = 1;
        for (int k = 0; k < 6; k++) {
            power *= -0.5;
            worst = fmax(worst, fabs((double)b.b[k] - (known * power + 1 - known)));
        }
        missing = fmax(missing, 1 - inside);
    }
    drop(&m);
    say(f->what, "kernels of 20 x 20 texels across the edge of a map and past it, depth -0.5");
    say(f->ours,
        "the rim stands for as much outside as is inside, the rest is depth 1: moments off by at "
        "most %.1e",
        worst);
    say(f->others,
        "clamped coordinates: up to %.0f%% of the zeroth moment is missing; of powers, "
        "that share then lies at depth 0 and casts a shadow",
        100 * missing);
    f->holds = worst < 6e-6;
}

static void depth_not_a_number(finding *f)
{
    static const float bad[] = {NAN, INFINITY, -INFINITY, 3e38f, -3e38f};
    depth_map m = new_map(64, 6);
    double worst = 0;
    for (int i = 0; i < 64 * 64; i++) m.depth[i] = -0.25f;
    for (int i = 0; i < 5; i++) m.depth[64 * (10 + 10 * i) + 30] = bad[i];
    if (mssm_map_update(m.map, m.depth, NULL, 1)) abort();
    const mssm_moments6 b = moments_at(&m, 32, 32, 32);
    // What is not finite counts as 1, nothing hit; the others are clamped.
    const double exact = (-0.25 * (4096 - 5) + 1 + 1 + 1 + 1 - 1) / 4096;
    worst = fabs((double)b.b[0] - exact);
    drop(&m);
    float sum = 0; // of a row in a float table
    for (int i = 0; i < 64; i++) sum += i == 30 ? NAN : -0.25f;
    say(f->what, "five texels of a depth map are NaN, Inf, -Inf, 3e38 and -3e38");
    say(f->ours,
        "what is not finite counts as nothing hit, the rest is clamped: the mean is off by %.1e",
        worst);
    say(f->others, "float32 prefix sums: every sum past the texel is %s",
        sum == sum ? "finite" : "NaN");
    f->holds = worst < 1e-6;
}

const further further_tables[] = {
    {"full-kernels", full_kernels},    {"wider-kernels", wider_kernels},
    {"float-tables", float_tables},    {"map-edges", map_edges},
    {"depth-nan", depth_not_a_number}, {0, 0}};
