// Methods that keep a mean and a variance of depth: variance and exponential variance shadow maps
// with a fixed filter, variance soft shadow maps, and exponential variance shadow maps with a
// blocker search.
#include "rivals.h"

#include <string.h>

enum { CHANNELS_MAX = 5, SUBDIVISIONS = 1, LEVELS_MAX = 20 };

typedef struct state {
    view view;
    int channels;
    float nearest, range; // of casters, and a little more behind: depth is 0 to 1 below
    float *filtered;      // fixed filters: means a texel, filtered
    float *work;          // of two passes, with a border as wide as the filter
    int radius;
    bool halves;              // the map holds floats of 16 bits
    float weight[TAPS_MOST];  // of the filter
    float empty[4];           // a texel without depth
    float bleeding, variance; // cut off, at least
    double *table;            // the others: summed-area table, (side + 1)^2 times the channels
    float *ranges; // VSSM: least and largest depth, level after level, each half the side
    size_t level[LEVELS_MAX]; // where they start
} state;

// Measured: the least mean error over the scenes of tests/support/scenes.h. Depth is 0 to 1, see
// scaled().
static const float bleeding_vsm = 0.0f, bleeding_vssm = 0.12f, bleeding_evsm = 0.10f;
static const float variance_vsm = 1e-7f, variance_vssm = 1e-3f, variance_evsm = 1e-8f;
static const float exponent_positive = 0.55f, exponent_negative = 11.7f;

// The same for hard shadows, over Gaussians of 1 to 16 texels and the scenes of cases.c, by descent at
// other receivers than the chart's. The exponents of 40 and 5 in common use err by a tenth more.
static const float bleeding_hard_vsm = 0.05f, bleeding_hard_evsm = 0.05f, variance_hard = 1e-5f;
static const float hard_positive = 1.1f, hard_negative = 10.4f;
// Floats of 16 bits hold the squares of warps up to exponents of 11 (5.5 for depth in [-1,1]).
static const float half_positive = 3, half_negative = 10, bleeding_half = 0.05f,
                   variance_half = 3e-5f;

// ---- depth ready for filtering -----------------------------------------------------------------

// Depth is scaled to what casters take up. Empty texels at 1 would lie far behind everything and
// make up most of the variance, so they move up to two texels behind the farthest caster, and so do
// receivers that are farther.
static void find_range(state *p)
{
    p->range = most(view_range(&p->view, &p->nearest), 0) + 2 * p->view.texel;
}

static float scaled(const state *p, float z)
{
    return z < 1 ? limited((z - p->nearest) / p->range, 0, 1) : 1;
}

static float unscaled(const state *p, float depth)
{
    return p->nearest + p->range * depth;
}

// Upper bound on the share of depths not nearer than t (Chebyshev, one-sided). The lowest part of
// it, where light bleeds, is cut off (Lauritzen 2007).
static float chebyshev(float mean, float square, float t, float floor_of_variance, float bleeding)
{
    if (t <= mean) return 1;
    const float variance = most(square - mean * mean, floor_of_variance);
    const float bound = variance / (variance + (t - mean) * (t - mean));
    return most(bound - bleeding, 0) / (1 - bleeding);
}

// ---- variance shadow maps ----------------------------------------------------------------------

static void *filter_create(int side, int channels, int radius, size_t *bytes)
{
    state *p = view_create(sizeof *p, side);
    const size_t count = (size_t)channels * (size_t)side * (size_t)side;
    if (!p) return NULL;
    const size_t wide = (size_t)(side + 2 * radius), row = (size_t)channels * wide;
    p->channels = channels;
    p->radius = radius;
    p->filtered = calloc(count, sizeof *p->filtered);
    p->work = calloc(row * (wide + 1), sizeof *p->work);
    if (!p->filtered || !p->work) {
        variance_destroy(p);
        return NULL;
    }
    *bytes = count * sizeof(float);
    return p;
}

// Five texels.
void *variance_create(const struct method *m, int side, size_t *bytes)
{
    static const float binomial[5] = {0.0625f, 0.25f, 0.375f, 0.25f, 0.0625f};
    state *p = filter_create(side, 2, 2, bytes);
    (void)m;
    if (!p) return NULL;
    p->bleeding = bleeding_vsm;
    p->variance = variance_vsm;
    memcpy(p->weight, binomial, sizeof binomial);
    return p;
}

static void *filter_create_gaussian(int radius, int side, int channels, float bleeding,
                                    size_t *bytes)
{
    state *p = filter_create(side, channels, radius, bytes);
    if (!p) return NULL;
    p->bleeding = bleeding;
    p->variance = variance_hard;
    gaussian(radius, p->weight);
    return p;
}

void *variance_hard_create(const struct method *m, int side, size_t *bytes)
{
    return filter_create_gaussian(m->variant, side, 2, bleeding_hard_vsm, bytes);
}

void variance_destroy(void *state_)
{
    state *p = state_;
    free(p->filtered);
    free(p->work);
    free(p->table);
    free(p->ranges);
    view_destroy(&p->view);
}

typedef void channels_of(float z, double *value);

static void powers_of(float z, double *value)
{
    value[0] = (double)z;
    value[1] = (double)z * (double)z;
}

// As the map holds it: rounded to 11 bits (Veltkamp's split), and below 2^-14 to multiples of 2^-24.
static inline float half_of(float x)
{
    const float split = 8193 * x;
    return fabsf(x) < 0x1p-14f ? (x + 0.75f) - 0.75f : split - (split - x);
}

static void store(const state *p, float *x, size_t count)
{
    for (size_t i = 0; i < count && p->halves; i++) x[i] = half_of(x[i]);
}

// Weighted sums of values that lie so far apart, four at a time.
static void filter_values(const state *p, const float *from, float *to, size_t count, size_t step)
{
    const int taps = 2 * p->radius + 1;
    size_t i = 0;
    for (; i + LANES <= count; i += LANES) {
        floats sum = {0};
        for (int k = 0; k < taps; k++)
            sum += all_of(p->weight[k]) * load(from + i + (size_t)k * step);
        memcpy(to + i, &sum, sizeof sum);
    }
    for (; i < count; i++) {
        to[i] = 0;
        for (int k = 0; k < taps; k++) to[i] += p->weight[k] * from[i + (size_t)k * step];
    }
    store(p, to, count);
}

static void fill_empty(const state *p, float *to, size_t texels)
{
    const size_t n = (size_t)p->channels;
    for (size_t i = 0; i < n * texels; i++) to[i] = p->empty[i % n];
}

// Along rows, each made with its border in front of where all of them go, then along columns.
static void make_filtered(state *p, const depth_map *map, channels_of *channels)
{
    double value[CHANNELS_MAX];
    view_update(&p->view, map);
    find_range(p);
    const size_t n = (size_t)p->channels, side = (size_t)p->view.side, border = (size_t)p->radius;
    const size_t row = n * side;
    float *first = p->work, *rows = first + n * (side + 2 * border);
    channels(1, value);
    for (size_t c = 0; c < n; c++) p->empty[c] = (float)value[c];
    store(p, p->empty, n);
    fill_empty(p, first, side + 2 * border);
    fill_empty(p, rows, border * side);
    fill_empty(p, rows + (border + side) * row, border * side);
    for (size_t y = 0; y < side; y++) {
        float *to = first + n * border;
        for (size_t x = 0; x < side; x++) {
            channels(scaled(p, p->view.depth[y * side + x]), value);
            for (size_t c = 0; c < n; c++) to[n * x + c] = (float)value[c];
        }
        store(p, to, row);
        filter_values(p, first, rows + (border + y) * row, row, n);
    }
    for (size_t y = 0; y < side; y++)
        filter_values(p, rows + y * row, p->filtered + y * row, row, row);
}

// The filtered map read bilinearly.
static inline void read_filtered(const state *p, const place *r, int n, float *mean)
{
    const float x = floorf(r->x - 0.5f), y = floorf(r->y - 0.5f), side = (float)p->view.side;
    for (int c = 0; c < n; c++) mean[c] = 0;
    for (int i = 0; i < 4; i++) {
        const float tx = x + (float)(i % 2), ty = y + (float)(i / 2);
        const float weight = (1 - fabsf(r->x - 0.5f - tx)) * (1 - fabsf(r->y - 0.5f - ty));
        const float *at = p->empty;
        if (tx >= 0 && ty >= 0 && tx < side && ty < side)
            at = p->filtered + (size_t)n * ((size_t)ty * (size_t)p->view.side + (size_t)tx);
        for (int c = 0; c < n; c++) mean[c] += weight * at[c];
    }
}

void variance_update(void *state_, const depth_map *map)
{
    make_filtered(state_, map, powers_of);
}

// Donnelly and Lauritzen 2006: a filtered map, read bilinearly.
float variance_visibility(const void *state_, const float point[3], float bias, unsigned pixel)
{
    const state *p = state_;
    float mean[2];
    place r;
    (void)pixel;
    if (!place_of(&p->view, point, bias, &r)) return 1;
    read_filtered(p, &r, 2, mean);
    return chebyshev(mean[0], mean[1], scaled(p, r.z), p->variance, p->bleeding);
}

// ---- summed-area tables ------------------------------------------------------------------------

// The papers' tables are of 32-bit numbers. Sums of float squares would break here from kernels of
// a few texels on, so sums are double, but count as 32 bits: to the methods' advantage.
static void *table_create(int side, int channels, size_t *bytes)
{
    state *p = view_create(sizeof *p, side);
    if (!p) return NULL;
    const size_t count = (size_t)(side + 1) * (size_t)(side + 1) * (size_t)channels;
    p->channels = channels;
    p->table = calloc(count, sizeof *p->table);
    if (!p->table) {
        variance_destroy(p);
        return NULL;
    }
    *bytes = count * 4;
    return p;
}

static void add_texel(state *p, int x, int y, double running[CHANNELS_MAX], const double *value)
{
    const size_t n = (size_t)p->channels, row = ((size_t)p->view.side + 1) * n;
    double *to = p->table + (size_t)(y + 1) * row + (size_t)(x + 1) * n;
    for (size_t c = 0; c < n; c++) {
        running[c] += value[c];
        to[c] = (to - row)[c] + running[c];
    }
}

static void make_table(state *p, channels_of *channels)
{
    const int side = p->view.side;
    for (int y = 0; y < side; y++) {
        double running[CHANNELS_MAX] = {0}, value[CHANNELS_MAX];
        for (int x = 0; x < side; x++) {
            const float z = p->view.depth[(size_t)y * (size_t)side + (size_t)x];
            channels(scaled(p, z), value);
            add_texel(p, x, y, running, value);
        }
    }
}

// Means over a rectangle of at least a texel; empty texels surround the map.
static void means_of(const state *p, const strips *x, const strips *y, const double *empty,
                     float *mean)
{
    const size_t n = (size_t)p->channels, row = ((size_t)p->view.side + 1) * n;
    const double wx[3] = {(double)x->first, 1, (double)x->last};
    const double wy[3] = {(double)y->first, 1, (double)y->last};
    const double area = (double)x->width * (double)y->width;
    const double outside = area - (double)x->inside * (double)y->inside;
    double sum[CHANNELS_MAX];
    for (size_t c = 0; c < n; c++) sum[c] = outside * empty[c];
    for (int j = 0; j < 3; j++) {
        const double *low = p->table + (size_t)y->edge[j] * row;
        const double *high = p->table + (size_t)y->edge[j + 1] * row;
        for (int i = 0; i < 3; i++) {
            const size_t a = (size_t)x->edge[i] * n, b = (size_t)x->edge[i + 1] * n;
            const double w = wx[i] * wy[j];
            for (size_t c = 0; c < n; c++) {
                sum[c] += w * ((high[b + c] - low[b + c]) - (high[a + c] - low[a + c]));
            }
        }
    }
    for (size_t c = 0; c < n; c++) mean[c] = (float)(sum[c] / area);
}

// ---- variance soft shadow maps -----------------------------------------------------------------

static int half_side(int side, int level)
{
    return (side + (1 << level) - 1) >> level;
}

void *variance_soft_create(const struct method *m, int side, size_t *bytes)
{
    (void)m;
    state *p = table_create(side, 2, bytes);
    if (!p) return NULL;
    size_t count = 0;
    for (int l = 0; l < LEVELS_MAX; l++) {
        const size_t size = (size_t)half_side(side, l);
        p->level[l] = count;
        count += 2 * size * size;
        if (size == 1) break;
    }
    p->ranges = malloc(count * sizeof *p->ranges);
    if (!p->ranges) {
        variance_destroy(p);
        return NULL;
    }
    // The finest level is the depth map, twice, to have one kind of level: it counts once.
    *bytes += (count - (size_t)side * (size_t)side) * sizeof *p->ranges;
    return p;
}

static void halve_ranges(state *p, int level)
{
    const int from = half_side(p->view.side, level), to = half_side(p->view.side, level + 1);
    const float *fine = p->ranges + p->level[level];
    float *coarse = p->ranges + p->level[level + 1];
    for (int y = 0; y < to; y++) {
        for (int x = 0; x < to; x++) {
            float low = 1, high = 0;
            for (int i = 0; i < 4; i++) {
                const int u = 2 * x + i % 2, v = 2 * y + i / 2;
                if (u >= from || v >= from) continue;
                low = least(low, fine[2 * (v * from + u)]);
                high = most(high, fine[2 * (v * from + u) + 1]);
            }
            coarse[2 * (y * to + x)] = low;
            coarse[2 * (y * to + x) + 1] = high;
        }
    }
}

void variance_soft_update(void *state_, const depth_map *map)
{
    state *p = state_;
    const size_t texels = (size_t)map->side * (size_t)map->side;
    view_update(&p->view, map);
    find_range(p);
    make_table(p, powers_of);
    for (size_t i = 0; i < texels; i++) {
        p->ranges[2 * i] = p->ranges[2 * i + 1] = scaled(p, p->view.depth[i]);
    }
    for (int l = 0; half_side(p->view.side, l) > 1; l++) halve_ranges(p, l);
}

// Range of depths in a kernel or a little around it, from the level where it is a few texels wide.
static void range_of(const state *p, const place *r, kernel k, float *low, float *high)
{
    const strips x = strips_of(r->x, k.u, p->view.side), y = strips_of(r->y, k.v, p->view.side);
    const bool beside = x.inside < x.width || y.inside < y.width;
    int l = 0;
    while (half_side(p->view.side, l) > 1 && most(x.width, y.width) > (float)(2 << l)) l++;
    const float *level = p->ranges + p->level[l];
    const int size = half_side(p->view.side, l);
    *low = 1;
    *high = beside ? 1 : 0;
    for (int j = y.edge[0] >> l; j << l < y.edge[3]; j++) {
        for (int i = x.edge[0] >> l; i << l < x.edge[3]; i++) {
            *low = least(*low, level[2 * (j * size + i)]);
            *high = most(*high, level[2 * (j * size + i) + 1]);
        }
    }
}

// Areas, and the sum of blockers' depths over their area.
typedef struct share {
    float lit, blocked, depths;
} share;

static void compare_four(const state *p, float x, float y, kernel k, float t, share *s)
{
    const float side = (float)p->view.side, area = k.u * k.v;
    for (int i = 0; i < 4; i++) {
        const float u = x + (i % 2 ? 0.5f : -0.5f) * k.u, v = y + (i / 2 ? 0.5f : -0.5f) * k.v;
        float z = 1;
        if (u >= 0 && v >= 0 && u < side && v < side) {
            z = p->view.depth[(size_t)(int)v * (size_t)p->view.side + (size_t)(int)u];
        }
        z = scaled(p, z);
        s->lit += z < t ? 0 : area;
        s->blocked += z < t ? area : 0;
        s->depths += z < t ? area * z : 0;
    }
}

// Chebyshev's inequality asks for a mean nearer than the receiver. Where a kernel's is not, it is
// split in four; what is left at the bottom is compared at two by two points, and what is flat is
// lit.
static void add_kernel(const state *p, float x, float y, kernel k, float t, float bleeding,
                       int level, share *s)
{
    const float area = 4 * k.u * k.v;
    const strips sx = strips_of(x, k.u, p->view.side), sy = strips_of(y, k.v, p->view.side);
    double empty[2];
    float m[2];
    powers_of(1, empty);
    means_of(p, &sx, &sy, empty, m);
    const float variance = m[1] - m[0] * m[0];
    if (m[0] < t) {
        const float lit = chebyshev(m[0], m[1], t, variance_vssm, bleeding);
        s->lit += area * lit;
        s->blocked += area * (1 - lit);
        s->depths += area * (m[0] - lit * t); // what is lit is taken to lie at the receiver
    } else if (variance < variance_vssm) {
        s->lit += area;
    } else if (level < SUBDIVISIONS && k.u >= 1 && k.v >= 1) {
        const kernel half = {0.5f * k.u, 0.5f * k.v};
        for (int i = 0; i < 4; i++) {
            add_kernel(p, x + (i % 2 ? half.u : -half.u), y + (i / 2 ? half.v : -half.v), half, t,
                       bleeding, level + 1, s);
        }
    } else {
        compare_four(p, x, y, k, t, s);
    }
}

// Yang, Dong, Feng, Seidel and Kautz 2010.
float variance_soft_visibility(const void *state_, const float point[3], float bias, unsigned pixel)
{
    const state *p = state_;
    place r;
    (void)pixel;
    if (!place_of(&p->view, point, bias, &r)) return 1;
    const float t = scaled(p, r.z);
    share found = {0, 0, 0}, s = {0, 0, 0};
    kernel k = kernel_of(&p->view, &r, -1);
    // What is wholly lit or wholly dark shows in the range of depths.
    float low, high;
    range_of(p, &r, k, &low, &high);
    if (low >= t) return 1;
    if (high < t) return 0;
    add_kernel(p, r.x, r.y, k, t, 0, 0, &found);
    if (found.blocked <= 1e-4f * (found.lit + found.blocked)) return 1;
    k = kernel_of(&p->view, &r, unscaled(p, limited(found.depths / found.blocked, 0, t)));
    add_kernel(p, r.x, r.y, k, t, bleeding_vssm, 0, &s);
    return limited(s.lit / (s.lit + s.blocked), 0, 1);
}

// ---- exponential variance ----------------------------------------------------------------------

// Values and squares of both warps. Around the middle of depth, so that floats of 16 bits use both
// ends of their range.
static void warp(float z, float positive, float negative, double value[4])
{
    const double a = (double)expf(positive * (z - 0.5f)), b = -(double)expf(negative * (0.5f - z));
    value[0] = a;
    value[1] = a * a;
    value[2] = b;
    value[3] = b * b;
}

static void warps_of(float z, double *value)
{
    value[0] = (double)z;
    warp(z, exponent_positive, exponent_negative, value + 1);
}

static void hard_warps_of(float z, double *value)
{
    warp(z, hard_positive, hard_negative, value);
}

void *exponential_create(const struct method *m, int side, size_t *bytes)
{
    (void)m;
    return table_create(side, 5, bytes);
}

void exponential_update(void *state_, const depth_map *map)
{
    state *p = state_;
    view_update(&p->view, map);
    find_range(p);
    make_table(p, warps_of);
}

// The lesser of the bounds from both warps. The floor of the variance is carried over by their
// slopes.
static float bound_of_warps(const float mean[4], float t, float positive, float negative,
                            float floor_of_variance, float bleeding)
{
    double at[4];
    warp(t, positive, negative, at);
    const float a = (float)at[0], b = (float)at[2], slope_a = positive * a, slope_b = negative * b;
    return least(chebyshev(mean[0], mean[1], a, slope_a * slope_a * floor_of_variance, bleeding),
                 chebyshev(mean[2], mean[3], b, slope_b * slope_b * floor_of_variance, bleeding));
}

// mean is that of depth itself.
static float exponential_bound(const state *p, const place *r, kernel k, float t, float bleeding,
                               float *mean)
{
    const strips x = strips_of(r->x, k.u, p->view.side), y = strips_of(r->y, k.v, p->view.side);
    double empty[CHANNELS_MAX];
    float m[CHANNELS_MAX];
    warps_of(1, empty);
    means_of(p, &x, &y, empty, m);
    *mean = m[0];
    return bound_of_warps(m + 1, t, exponent_positive, exponent_negative, variance_evsm, bleeding);
}

// Lauritzen and McCool 2008 give the bound; the blocker depth is found as in variance soft shadow
// maps, from the mean of depth and the bound.
float exponential_visibility(const void *state_, const float point[3], float bias, unsigned pixel)
{
    const state *p = state_;
    place r;
    float mean;
    (void)pixel;
    if (!place_of(&p->view, point, bias, &r)) return 1;
    const float t = scaled(p, r.z);
    kernel k = kernel_of(&p->view, &r, -1);
    const float lit = exponential_bound(p, &r, k, t, 0, &mean);
    if (lit >= 1 - 1e-4f) return 1;
    k = kernel_of(&p->view, &r, unscaled(p, limited((mean - lit * t) / (1 - lit), 0, t)));
    return limited(exponential_bound(p, &r, k, t, bleeding_evsm, &mean), 0, 1);
}

// ---- exponential variance under a fixed filter --------------------------------------------------

void *exponential_hard_create(const struct method *m, int side, size_t *bytes)
{
    return filter_create_gaussian(m->variant, side, 4, bleeding_hard_evsm, bytes);
}

void exponential_hard_update(void *state_, const depth_map *map)
{
    make_filtered(state_, map, hard_warps_of);
}

// Lauritzen and McCool 2008.
float exponential_hard_visibility(const void *state_, const float point[3], float bias,
                                  unsigned pixel)
{
    const state *p = state_;
    float mean[4];
    place r;
    (void)pixel;
    if (!place_of(&p->view, point, bias, &r)) return 1;
    read_filtered(p, &r, 4, mean);
    return bound_of_warps(mean, scaled(p, r.z), hard_positive, hard_negative, p->variance,
                          p->bleeding);
}

// The same in 64 bits: floats of 16 bits, as the moments' slides compare it.
static void half_warps_of(float z, double *value)
{
    warp(z, half_positive, half_negative, value);
}

void *exponential_half_create(const struct method *m, int side, size_t *bytes)
{
    state *p = filter_create_gaussian(m->variant, side, 4, bleeding_half, bytes);
    if (!p) return NULL;
    p->halves = true;
    p->variance = variance_half;
    *bytes /= 2;
    return p;
}

void exponential_half_update(void *state_, const depth_map *map)
{
    make_filtered(state_, map, half_warps_of);
}

float exponential_half_visibility(const void *state_, const float point[3], float bias,
                                  unsigned pixel)
{
    const state *p = state_;
    float mean[4];
    place r;
    (void)pixel;
    if (!place_of(&p->view, point, bias, &r)) return 1;
    read_filtered(p, &r, 4, mean);
    return bound_of_warps(mean, scaled(p, r.z), half_positive, half_negative, p->variance,
                          p->bleeding);
}

// ---- moments of 32-bit floats under a fixed filter ----------------------------------------------

// The slides' 128 bits: four moments of depths in [-1,1] as they are, where the library's own
// filtered maps keep 16 bits of each.
static void moments_of(float z, double *value)
{
    double power = 1;
    for (int i = 0; i < 4; i++) value[i] = power *= 2 * (double)z - 1;
}

void *moments_float_create(const struct method *m, int side, size_t *bytes)
{
    return filter_create_gaussian(m->variant, side, 4, 0.02f, bytes);
}

void moments_float_update(void *state_, const depth_map *map)
{
    make_filtered(state_, map, moments_of);
}

float moments_float_visibility(const void *state_, const float point[3], float bias, unsigned pixel)
{
    const state *p = state_;
    mssm_moments4 m;
    place r;
    (void)pixel;
    if (!place_of(&p->view, point, bias, &r)) return 1;
    read_filtered(p, &r, 4, m.b);
    m = mssm_moments4_bias(m, 1e-3f); // measured; 3e-6 would do for rounding, but errs by 7% more
    const float lit = mssm_visibility4(m, 2 * scaled(p, r.z) - 1).upper;
    return limited((lit - p->bleeding) / (1 - p->bleeding), 0, 1);
}
