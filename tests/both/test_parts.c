// The parts of lightprobe.h whose faults a finished light hardly shows: sums, cuts and choices,
// each against its definition in double. The header is compiled once more here, under other names.
#define lightprobe_extract parts_extract
#define lightprobe_scratch_bytes parts_scratch_bytes
#define lightprobe_result_string parts_result_string
#define lightprobe_texel_solid_angle parts_texel_solid_angle
#define lightprobe_texel_direction parts_texel_direction
#define lightprobe_disc_irradiance parts_disc_irradiance
#define lightprobe_glsl_math parts_glsl_math
#define lightprobe_image_side parts_image_side
#define lightprobe_cube_from_image parts_cube_from_image
#define lightprobe_cube_without parts_cube_without
#define lightprobe_residual_irradiance parts_residual_irradiance
#define lightprobe_light_at parts_light_at
#define lightprobe_specular_lobe parts_specular_lobe
#define lightprobe_specular parts_specular
#define lightprobe_sphere_at parts_sphere_at
#ifndef LIGHTPROBE_NO_GL
#define LIGHTPROBE_NO_GL
#endif
#define LIGHTPROBE_IMPLEMENTATION
#include "../support/oracle_lightprobe.h"
#include "../support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static lightprobe_axis longest_axis(lightprobe_spread spread, const float mean[3])
{
    float d[3];
    lightprobe_eigenvector(spread.m, d);
    return lightprobe_axis_along(d, spread, mean);
}

// 1 less half the squared distance of unit directions and tones.
static float nearness_of(const float *a, float tone_a, const float *b, float tone_b)
{
    return lightprobe_dot(a, b) - 0.5f * (tone_a - tone_b) * (tone_a - tone_b);
}

// ---- Leaves ----

// Unit direction anywhere, luminance over four decades, tone over its range.
static lightprobe_leaf random_leaf(uint64_t *seed)
{
    lightprobe_leaf leaf;
    memset(&leaf, 0, sizeof leaf);
    do {
        for (int i = 0; i < 3; i++) leaf.direction[i] = (float)test_range(seed, -1, 1);
    } while (!(lightprobe_dot(leaf.direction, leaf.direction) > 0.01f));
    lightprobe_normalize(leaf.direction);
    leaf.luminance = (float)exp(test_range(seed, -5, 4));
    leaf.strength = leaf.luminance * (float)test_range(seed, 0.7, 1);
    leaf.tone = (float)test_range(seed, -0.6, 1.3);
    leaf.half_width = (float)test_range(seed, 0.01, 0.3);
    leaf.solid_angle = (float)test_range(seed, 0.001, 0.02);
    for (int i = 0; i < 3; i++) leaf.flux[i] = leaf.luminance * (float)test_range(seed, 0.5, 1.5);
    return leaf;
}

static lightprobe_sum sum_of(const lightprobe_leaf *leaf, int count)
{
    lightprobe_sum s = lightprobe_nothing();
    for (int i = 0; i < count; i++) s = lightprobe_add_leaf(s, leaf[i]);
    return s;
}

// What clusters cost: luminance times half the square distance of direction and tone to their
// means.
typedef struct cost {
    double direction, tone, luminance;
} cost;

static cost cost_of(const lightprobe_leaf *leaf, const int *in, int which, int count)
{
    double vector[3] = {0}, tones = 0;
    cost c = {0, 0, 0};
    for (int i = 0; i < count; i++) {
        if (in && in[i] != which) continue;
        const double l = (double)leaf[i].luminance;
        for (int k = 0; k < 3; k++)
            vector[k] += (double)leaf[i].strength * (double)leaf[i].direction[k];
        tones += l * (double)leaf[i].tone;
        c.luminance += l;
    }
    if (!(c.luminance > 0)) return c;
    c.direction =
        c.luminance - sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
    for (int i = 0; i < count; i++) {
        const double off = (double)leaf[i].tone - tones / c.luminance;
        if (!in || in[i] == which) c.tone += 0.5 * (double)leaf[i].luminance * off * off;
    }
    return c;
}

static void logarithms_and_tones_are_exact(void)
{
    double worst = 0;
    for (double r = 1e-4; r < 1e7; r *= 1.0037) {
        const double inside = r < 1e-3 ? 1e-3 : r < 1e6 ? r : 1e6;
        const double off = fabs((double)lightprobe_log((float)r) - log(inside));
        worst = off > worst ? off : worst;
        const double tone = (double)lightprobe_tone((float)(r * 3.5 * 0.25), 0.25f, 3.5f);
        CHECK(fabs(tone - (double)LIGHTPROBE_TONE * log(inside)) < 1e-6, "tone of %g is %g", r,
              tone);
    }
    test_note("logarithm to %.1e", worst);
    CHECK(worst < 2e-6, "the logarithm is off by %g", worst);
    CHECK(fabsf(lightprobe_tone(1e30f, 1e-12f, 1) - LIGHTPROBE_TONE * logf(1e6f)) < 1e-6f,
          "no largest tone");
}

static void costs_and_gains_are_those_of_the_leaves(void)
{
    uint64_t seed = 201;
    enum { N = 30 };
    lightprobe_leaf leaf[N];
    int in[N];
    for (int trial = 0; trial < test_trials(3000); trial++) {
        const int count = 2 + (int)test_range(&seed, 0, N - 2);
        lightprobe_sum part = lightprobe_nothing(), rest = part;
        for (int i = 0; i < count; i++) {
            leaf[i] = random_leaf(&seed);
            in[i] = i == 0 ? 0 : i == 1 ? 1 : (int)test_range(&seed, 0, 2);
            if (in[i])
                rest = lightprobe_add_leaf(rest, leaf[i]);
            else
                part = lightprobe_add_leaf(part, leaf[i]);
        }
        const lightprobe_sum whole = sum_of(leaf, count), both = lightprobe_add_sum(part, rest);
        const cost all = cost_of(leaf, NULL, 0, count), a = cost_of(leaf, in, 0, count),
                   b = cost_of(leaf, in, 1, count);
        const double total = 3 * all.luminance, slack = 3e-6 * all.luminance;
        const double one = all.luminance / total * (all.direction + all.tone);
        const double two = a.luminance / total * (a.direction + a.tone) +
                           b.luminance / total * (b.direction + b.tone);
        CHECK(both.count == count && fabs((double)(both.luminance - whole.luminance)) < slack,
              "sums differ");
        CHECK(fabs((double)lightprobe_sum_error(both) - all.direction) < slack,
              "error of a cluster");
        CHECK(fabs((double)lightprobe_cost(both, (float)total) - one) < slack, "cost of a cluster");
        CHECK(fabs((double)lightprobe_cut_cost(part, rest, (float)total) - two) < slack,
              "a cut of %d leaves costs %g", count, two);
        CHECK(fabs((double)lightprobe_merge_cost(part, rest, (float)total) - (one - two)) < slack,
              "a merger costs %g", one - two);
        const double dots = (double)lightprobe_dot(leaf[0].direction, leaf[1].direction);
        const double tones = (double)(leaf[0].tone - leaf[1].tone);
        const double nearness = dots - 0.5 * tones * tones;
        const double square = 0.3 * (1 - nearness) * (1 - nearness);
        CHECK(fabs((double)lightprobe_distance(0.3f, leaf[0].direction, leaf[0].tone,
                                               leaf[1].direction, leaf[1].tone) -
                   square) < 2e-6 * (1 + square),
              "distance");
    }
    const lightprobe_sum nothing = lightprobe_nothing(), some = sum_of(leaf, 2);
    const lightprobe_errors few = {0.5f, 0.25f};
    const lightprobe_pair pair = {0, 1, 0};
    lightprobe_cluster black[2];
    black[0] = black[1] = lightprobe_fresh();
    lightprobe__work w = {0};
    w.clusters = black;
    w.total = 1;
    CHECK(lightprobe_cost(nothing, 1) == 0 && lightprobe_edge_error(nothing, 1, 1) == 0 &&
              lightprobe_merged(&w, few, pair).squares == 0.5f,
          "nothing costs");
    CHECK(lightprobe_cut_cost(nothing, some, 1) > 1e30f &&
              lightprobe_cut_cost(some, nothing, 1) > 1e30f,
          "a cut of nothing");
    const float far_away[3] = {0, 1, 0};
    CHECK(lightprobe_distance(1, far_away, 1, far_away, 1) == 0, "no distance to itself");
}

// The error of a cluster against the integral of squared differences, along two axes in steps.
static double exact_unevenness(const lightprobe_leaf *leaf, int count, const float axis[3])
{
    double luminance = 0, mean = 0, variance = 0, sum = 0, place[64], half[64];
    for (int i = 0; i < count; i++) {
        place[i] = (double)lightprobe_dot(leaf[i].direction, axis);
        half[i] = (double)leaf[i].half_width;
        luminance += (double)leaf[i].luminance;
        mean += (double)leaf[i].luminance * place[i];
    }
    mean /= luminance;
    for (int i = 0; i < count; i++)
        variance += (double)leaf[i].luminance / luminance *
                    ((place[i] - mean) * (place[i] - mean) + half[i] * half[i] / 3);
    const double deviation = sqrt(variance), step = deviation / 500;
    for (double x = -4 * deviation; x < 4 * deviation; x += step) {
        double below = 0;
        for (int i = 0; i < count; i++)
            below += (double)leaf[i].luminance / luminance *
                     fmin(1, fmax(0, (x + mean - place[i] + half[i]) / (2 * half[i])));
        const double even = fmin(1, fmax(0, 0.5 + x / (2 * sqrt(3) * deviation)));
        sum += (below - even) * (below - even) * step;
    }
    return sum;
}

static void unevenness_is_cramers_distance(void)
{
    uint64_t seed = 209;
    double worst = 0;
    for (int trial = 0; trial < test_trials(400); trial++) {
        enum { N = 40 };
        lightprobe_leaf leaf[N];
        lightprobe_sum sum = lightprobe_nothing();
        lightprobe_spread spread = {{0}, 0, 0};
        const int sun = trial % 2; // in the middle, or a patch with holes
        for (int i = 0; i < N; i++) {
            leaf[i] = random_leaf(&seed);
            leaf[i].direction[0] = (float)test_range(&seed, -0.2, 0.2);
            leaf[i].direction[1] = (float)test_range(&seed, -0.1, 0.1);
            leaf[i].direction[2] = 1;
            leaf[i].luminance = (float)test_range(&seed, 0.5, 1.5);
            leaf[i].half_width = 0.02f;
            if (i == 0 && sun) {
                leaf[i].direction[0] = leaf[i].direction[1] = 0;
                leaf[i].luminance = 30;
                leaf[i].half_width = 0.002f;
            }
            leaf[i].strength = leaf[i].luminance;
            sum = lightprobe_add_leaf(sum, leaf[i]);
        }
        float mean[3], below[LIGHTPROBE_BINS] = {0};
        for (int i = 0; i < 3; i++) mean[i] = sum.resultant[i] / sum.luminance;
        for (int i = 0; i < N; i++)
            spread = lightprobe_add_spread(spread, leaf[i], mean, 0, 1 / sum.luminance);
        const lightprobe_axis axis = longest_axis(spread, mean);
        for (int i = 0; i < N; i++)
            for (int bin = 0; bin < LIGHTPROBE_BINS; bin++)
                below[bin] += lightprobe_below(lightprobe_streak_of(axis, leaf[i]), bin);
        CHECK(below[LIGHTPROBE_BINS - 1] < 1.0001f * sum.luminance, "light is made");
        const double exact = exact_unevenness(leaf, N, axis.direction);
        const double got = (double)lightprobe_unevenness(axis, below, sum.luminance);
        const double off = fabs(got - exact) / (exact + 0.002);
        CHECK(off < 0.4, "%s: %g, not %g", sun ? "sun in haze" : "patch", got, exact);
        worst = fmax(worst, off);
        const lightprobe_axis across = lightprobe_axis_across(axis, spread, mean);
        CHECK(fabsf(lightprobe_dot(across.direction, axis.direction)) < 1e-5f &&
                  fabsf(lightprobe_dot(across.direction, mean)) < 1e-5f,
              "not across");
    }
    test_note("seven places of the distribution instead of its integral: %.0f%% off", 100 * worst);
}

static void swaps_pay_when_the_gain_is_16_times_the_cost(void)
{
    CHECK(lightprobe_should_reassign(0.79f, 1, 0, 1, 10) == 1,
          "what the tolerance spares by a margin is kept");
    CHECK(lightprobe_should_reassign(0.81f, 1, 0, 1, 10) == 0, "a swap without gain");
    CHECK(lightprobe_should_reassign(5, 1, 1.61f, 0.1f, 10) == 1, "16 times the cost do not do");
    CHECK(lightprobe_should_reassign(5, 1, 1.59f, 0.1f, 10) == 0,
          "less than 16 times the cost does");
    CHECK(lightprobe_should_reassign(5, 1, 0.9e-4f, 0, 10) == 0 &&
              lightprobe_should_reassign(5, 1, 1.1e-4f, 0, 10) == 1,
          "gains below 1e-5 of all count");
}

// ---- Axes of cuts ----

// Largest eigenvalue of a symmetric matrix (xx yy zz xy yz zx): power iteration in double.
static double largest_eigenvalue(const float m[6], double v[3])
{
    double value = 0;
    v[0] = 0.61, v[1] = 0.53, v[2] = 0.59;
    for (int i = 0; i < 400; i++) {
        const double x = (double)m[0] * v[0] + (double)m[3] * v[1] + (double)m[5] * v[2];
        const double y = (double)m[3] * v[0] + (double)m[1] * v[1] + (double)m[4] * v[2];
        const double z = (double)m[5] * v[0] + (double)m[4] * v[1] + (double)m[2] * v[2];
        value = sqrt(x * x + y * y + z * z);
        v[0] = x / value, v[1] = y / value, v[2] = z / value;
    }
    return value;
}

static void eigenvectors_belong_to_the_largest_eigenvalue(void)
{
    uint64_t seed = 202;
    double worst = 0;
    for (int trial = 0; trial < test_trials(3000); trial++) {
        lightprobe_leaf a = random_leaf(&seed), b = random_leaf(&seed);
        const float *d = a.direction, *e = b.direction;
        const float second = (float)test_range(&seed, 0, 0.5),
                    third = (float)test_range(&seed, 0, 0.1);
        const float size = (float)exp(test_range(&seed, -10, 10));
        float m[6], v[3];
        double want[3];
        for (int i = 0; i < 3; i++) {
            const int k = (i + 1) % 3;
            m[i] = size * (d[i] * d[i] + second * e[i] * e[i] + third);
            m[3 + i] = size * (d[i] * d[k] + second * e[i] * e[k]);
        }
        largest_eigenvalue(m, want);
        lightprobe_eigenvector(m, v);
        const double along =
            (double)v[0] * want[0] + (double)v[1] * want[1] + (double)v[2] * want[2];
        worst = fmax(worst, 1 - fabs(along));
        CHECK(fabs((double)lightprobe_dot(v, v) - 1) < 1e-6, "not unit");
    }
    test_note("cosine to the first eigenvector 1 - %.1e at worst", worst);
    // The second eigenvalue is at most 0.6 of the first: 0.6^8 of it is left.
    CHECK(worst < 2e-4, "%g", worst);
    static const float zero[6] = {0};
    float v[3];
    lightprobe_eigenvector(zero, v);
    CHECK(v[0] == 0 && v[1] == 1 && v[2] == 0, "no matrix, no axis");
}

static void axes_hold_two_deviations_to_each_side(void)
{
    uint64_t seed = 203;
    enum { N = 12 };
    for (int trial = 0; trial < test_trials(3000); trial++) {
        lightprobe_leaf leaf[N];
        lightprobe_sum sum = lightprobe_nothing();
        lightprobe_spread spread = {{0}, 0, 0};
        float mean[3];
        for (int i = 0; i < N; i++) {
            leaf[i] = random_leaf(&seed);
            leaf[i].strength = leaf[i].luminance;
            if (trial % 2) leaf[i].tone *= 0.1f;
            if (trial % 3 == 0) leaf[i].direction[0] = 3; // not unit, but the formulas hold
            sum = lightprobe_add_leaf(sum, leaf[i]);
        }
        const double whole = (double)sum.luminance;
        for (int i = 0; i < 3; i++) mean[i] = sum.resultant[i] / sum.luminance;
        const float tone = sum.tones / sum.luminance;
        for (int i = 0; i < N; i++)
            spread = lightprobe_add_spread(spread, leaf[i], mean, tone, 1 / sum.luminance);
        const lightprobe_axis axis =
            trial % 2 ? lightprobe_axis_around(tone, spread.tone2) : longest_axis(spread, mean);
        double m[6] = {0}, along = 0, tones = 0, centre = 0, own = 0;
        for (int i = 0; i < N; i++) {
            const double f = (double)leaf[i].luminance / whole,
                         off = (double)leaf[i].tone - (double)tone;
            double at = 0, d[3];
            for (int k = 0; k < 3; k++) {
                d[k] = (double)leaf[i].direction[k] - (double)mean[k];
                at += d[k] * (double)axis.direction[k];
            }
            for (int k = 0; k < 3; k++) {
                m[k] += f * d[k] * d[k];
                m[3 + k] += f * d[k] * d[(k + 1) % 3];
            }
            along += f * at * at;
            own += f * (double)leaf[i].half_width * (double)leaf[i].half_width / 3;
            tones += f * off * off;
        }
        for (int k = 0; k < 6; k++)
            CHECK(fabs((double)spread.m[k] - m[k]) < 1e-5, "second moment %d", k);
        CHECK(fabs((double)spread.tone2 - tones) < 1e-6, "variance of tone");
        CHECK(axis.by_tone == trial % 2, "the wrong kind of axis");
        CHECK(fabs((double)spread.own - own) < 1e-6, "own spread of the leaves");
        for (int k = 0; k < 3; k++) centre += (double)mean[k] * (double)axis.direction[k];
        if (axis.by_tone) centre = (double)tone;
        const double deviation = sqrt(axis.by_tone ? tones : along + own);
        CHECK(fabs((double)axis.low - (centre - 2 * deviation)) < 1e-5 * (3 + deviation),
              "starts at %g", (double)axis.low);
        CHECK(fabs((double)axis.scale * deviation / 2 - 1) < 1e-4, "%g bins a deviation",
              (double)axis.scale * deviation);
        for (int i = 0; i < N; i++) {
            double at = (double)leaf[i].tone;
            if (!axis.by_tone) at = (double)lightprobe_dot(leaf[i].direction, axis.direction);
            CHECK((double)lightprobe_along(axis, leaf[i]) == at, "place on the axis");
            const double place = (at - (double)axis.low) * (double)axis.scale;
            const int bin = lightprobe_bin(axis, leaf[i]);
            CHECK((place < 1e-4 && bin == 0) || (place > 7 - 1e-4 && bin == 7) ||
                      (place > bin - 1e-4 && place < bin + 1 + 1e-4),
                  "bin %d at %g", bin, place);
        }
        for (int bin = 0; bin < 7; bin++) {
            const double at = (double)axis.low + (bin + 1) / (double)axis.scale;
            CHECK(fabs((double)lightprobe_threshold(axis, bin) - at) < 1e-5, "end of bin %d", bin);
        }
    }
    const float nowhere[3] = {0, 1, 0};
    const lightprobe_spread none = {{0}, 0, 0};
    const lightprobe_axis no_axis = longest_axis(none, nowhere);
    const float flat[LIGHTPROBE_BINS] = {0};
    CHECK(no_axis.scale == 0 && lightprobe_axis_around(1, 0).scale == 0,
          "what does not vary has an axis");
    CHECK(lightprobe_unevenness(no_axis, flat, 1) == 0, "a point is uneven");
    CHECK(lightprobe_axis_across(no_axis, none, nowhere).direction[1] == 1,
          "light from all around");
}

// ---- Texels, tiles, cells ----

typedef struct parts {
    lightprobe__work work;
    test_probe probe;
    lightprobe_cube cube;
    void *scratch;
} parts;

static void open_parts(parts *p, test_scene scene, int side, int max_lights)
{
    memset(p, 0, sizeof *p);
    p->probe = test_scene_probe(scene, side);
    p->cube = test_probe_cube(&p->probe);
    p->scratch = malloc(lightprobe_scratch_bytes(side, max_lights));
    if (!p->scratch) abort();
    lightprobe__layout(&p->work, (char *)p->scratch + (15 & (0 - (uintptr_t)p->scratch)), side,
                       max_lights);
    p->work.cube = &p->cube;
    lightprobe__make_tables(&p->work);
    lightprobe__sum_tiles(&p->work);
    lightprobe__make_pyramid(&p->work);
}

static void close_parts(parts *p)
{
    test_probe_free(&p->probe);
    free(p->scratch);
}

// Sums of a cell from its texels, in double: RGB, 1, and luminance times direction in the face's
// axes.
static void exact_cell(const parts *p, int face, int level, int cx, int cy, double flux[4],
                       double vector[3])
{
    const int n = p->work.side, size = 1 << level;
    memset(flux, 0, 4 * sizeof *flux);
    memset(vector, 0, 3 * sizeof *vector);
    for (int y = cy * size; y < (cy + 1) * size && y < n; y++) {
        for (int x = cx * size; x < (cx + 1) * size && x < n; x++) {
            const float *rgb = p->probe.face[face] + 3 * (y * n + x);
            const double omega = (double)oracle_solid_angle(n, x, y) / 16;
            const double s = (2 * x + 1.0) / n - 1, t = (2 * y + 1.0) / n - 1;
            double y709 = 0;
            for (int c = 0; c < 3; c++) {
                flux[c] += omega * (double)rgb[c];
                y709 += (c == 0 ? 0.2126 : c == 1 ? 0.7152 : 0.0722) * (double)rgb[c];
            }
            flux[3] += omega;
            // The texel's own width takes a twelfth of its solid angle off.
            const double length = y709 * omega * (1 - 16 * omega / 12) / sqrt(1 + s * s + t * t);
            vector[0] += length;
            vector[1] += length * s;
            vector[2] += length * t;
        }
    }
}

static void cells_are_sums_over_their_texels(void)
{
    static const int sides[] = {1,  2,  3,  4,  5,  6,  7,  8,  9,  12, 15, 16,
                                17, 31, 32, 33, 60, 63, 64, 65, 66, 67, 68, 99};
    for (size_t i = 0; i < sizeof sides / sizeof *sides; i++) {
        parts p;
        open_parts(&p, i % 2 ? SCENE_NOISE : SCENE_SKY_SUN, sides[i], 8);
        const double least = (double)oracle_solid_angle(sides[i], 0, 0) / 16;
        double total[3] = {0}, flux[4], vector[3];
        for (int level = 0; level <= p.work.top; level++) {
            const int n = lightprobe_level_side(sides[i], level);
            for (int k = 0; k<6 * n * n; k += n> 16 ? 17 : 1) {
                const int face = k / (n * n), y = k / n % n, x = k % n;
                const lightprobe_cell cell = lightprobe_cell_at(&p.work, face, level, x, y);
                exact_cell(&p, face, level, x, y, flux, vector);
                for (int c = 0; c < 4; c++)
                    CHECK(fabs((double)cell.flux[c] - flux[c]) < 3e-6 * flux[c] + 1e-6 * least,
                          "side %d, level %d, cell %d: channel %d is %.9g, not %.9g", sides[i],
                          level, k, c, (double)cell.flux[c], flux[c]);
                for (int c = 0; c < 3; c++)
                    CHECK(fabs((double)cell.resultant[c] - vector[c]) <
                              4e-6 * vector[0] + 1e-6 * least,
                          "side %d, level %d, cell %d: vector %d is %.9g, not %.9g", sides[i],
                          level, k, c, (double)cell.resultant[c], vector[c]);
                for (int c = 0; c < 3 && level == p.work.top; c++) total[c] += flux[c];
                const double middle = (x + 0.5) * (2 << level) / sides[i] - 1;
                CHECK(fabs((double)lightprobe_cell_middle(sides[i], level, x) - fmin(middle, 1)) <
                          1e-6,
                      "side %d, level %d: middle of cell %d", sides[i], level, x);
            }
        }
        lightprobe__find_total(&p.work);
        for (int c = 0; c < 3; c++)
            CHECK(fabs(p.work.sum_of_all[c] / total[c] - 1) < 2e-6, "side %d: total", sides[i]);
        close_parts(&p);
    }
}

// ---- Leaves, clusters ----

static void the_largest_comes_first(void)
{
    uint64_t seed = 204;
    float x[300];
    for (int trial = 0; trial < test_trials(500); trial++) {
        const int count = 1 + (int)test_range(&seed, 0, 300);
        for (int i = 0; i < count; i++)
            x[i] = (float)(int)test_range(&seed, -1, 50); // some are equal
        const int top = lightprobe__largest(x, count);
        for (int i = 0; i < count; i++)
            CHECK(x[i] < x[top] || (x[i] <= x[top] && i >= top), "%d, not %d", top, i);
    }
}

// Leaves and clusters of a probe, as an extraction has them before it relaxes the clusters.
static float open_clusters(parts *p, test_scene scene, int side, int lights)
{
    open_parts(p, scene, side, lights);
    lightprobe__find_total(&p->work);
    lightprobe__make_leaves(&p->work);
    lightprobe__start(&p->work, NULL, 0);
    lightprobe__divide(&p->work, 0);
    lightprobe__sum_clusters(&p->work);
    return p->work.total;
}

static void leaves_tile_the_sphere(void)
{
    for (int scene = 0; scene < SCENE_COUNT; scene++) {
        for (int side = 5; side <= 64; side += 59) {
            parts p;
            open_parts(&p, (test_scene)scene, side, 32);
            lightprobe__work *w = &p.work;
            char *seen = calloc((size_t)(6 * side * side), 1);
            if (!seen) abort();
            lightprobe__find_total(w);
            lightprobe__make_leaves(w);
            float largest = 0, divided = 1e30f;
            for (int i = 0; i < w->leaf_count; i++) {
                const lightprobe_leaf *l = w->leaves + i;
                const int size = 1 << l->level;
                for (int y = l->y * size; y < (l->y + 1) * size && y < side; y++)
                    for (int x = l->x * size; x < (l->x + 1) * size && x < side; x++) {
                        char *texel = seen + (l->face * side + y) * side + x;
                        CHECK(!*texel, "texel %d %d of face %d is in two leaves", x, y, l->face);
                        *texel = 1;
                    }
                if (l->level == 0) continue;
                largest = fmaxf(largest, lightprobe_leaf_error(*l));
                // What was divided had at least the error of what was not.
                if (l->level >= w->top) continue;
                lightprobe_cell up =
                    lightprobe_cell_at(w, l->face, l->level + 1, l->x / 2, l->y / 2);
                const float y709 = lightprobe_luminance(up.flux);
                divided = fminf(divided, y709 - (float)lightprobe_length(up.resultant));
            }
            CHECK(!memchr(seen, 0, (size_t)(6 * side * side)), "a texel is in no leaf");
            CHECK(w->leaf_count >= 100, "%s: %d leaves", test_scene_names[scene], w->leaf_count);
            CHECK(largest <= divided * 1.001f + 2e-7f * w->mean,
                  "%s, side %d: %g is left, %g divided", test_scene_names[scene], side,
                  (double)largest, (double)divided);
            free(seen);
            close_parts(&p);
        }
    }
}

static void sorted_leaves_are_those_of_their_cluster(void)
{
    parts p;
    open_clusters(&p, SCENE_LAMPS, 32, 30);
    int next = 0;
    for (int k = 0; k < p.work.cluster_count; k++) {
        const lightprobe_cluster *c = p.work.clusters + k;
        CHECK(c->first == next && c->sum.count > 0, "cluster %d starts at %d, not %d", k, c->first,
              next);
        for (int i = 0; i < c->sum.count; i++)
            CHECK(p.work.leaves[p.work.order[c->first + i]].cluster == k,
                  "a leaf of another cluster");
        next += c->sum.count;
    }
    CHECK(next == p.work.leaf_count, "%d of %d leaves are sorted", next, p.work.leaf_count);
    close_parts(&p);
}

// Of the seven places for a cut none is better than the one planned, by brute force over the
// leaves.
static void planned_cuts_are_the_best_of_fourteen(void)
{
    uint64_t seed = 205;
    parts p;
    open_parts(&p, SCENE_NOISE, 8, 4);
    lightprobe__work *w = &p.work;
    for (int trial = 0; trial < test_trials(1000); trial++) {
        const int count = 2 + (int)test_range(&seed, 0, 12);
        w->leaf_count = count;
        w->cluster_count = 1;
        memset(w->clusters, 0, sizeof *w->clusters);
        for (int i = 0; i < count; i++) w->leaves[i] = random_leaf(&seed);
        lightprobe__sum_clusters(w);
        w->clusters->sum.count = count;
        w->total = 2 * w->clusters->sum.luminance;
        lightprobe__measure(w, w->clusters);
        const lightprobe_axis axes[2] = {w->clusters->axis, w->clusters->tone_axis};
        lightprobe__plan_split(w, w->clusters);
        const lightprobe_axis chosen = w->clusters->axis;
        const cost all = cost_of(w->leaves, NULL, 0, count);
        double best = 0, planned = 0;
        for (int k = 0; k <= 14; k++) {
            const lightprobe_axis axis = k < 14 ? axes[k / 7] : chosen;
            const float at = k < 14 ? lightprobe_threshold(axis, k % 7) : axis.threshold;
            int in[16], near_border = 0;
            for (int i = 0; i < count; i++) {
                const float place = lightprobe_along(axis, w->leaves[i]);
                in[i] = place >= at;
                near_border |= fabsf(place - at) < 1e-5f;
            }
            const cost a = cost_of(w->leaves, in, 0, count), b = cost_of(w->leaves, in, 1, count);
            const double gain =
                (all.luminance * (all.direction + all.tone) - a.luminance * (a.direction + a.tone) -
                 b.luminance * (b.direction + b.tone)) /
                (double)w->total;
            if (k == 14)
                planned = gain;
            else if (!near_border && gain > best)
                best = gain;
        }
        CHECK(planned > best - 1e-5 * all.luminance, "the planned cut gains %g, another %g",
              planned, best);
        CHECK(fabs((double)w->clusters->gain - planned) < 1e-5 * all.luminance,
              "%g is planned, %g gained", (double)w->clusters->gain, planned);
        CHECK(w->gains[0] > 0 && w->gains[0] >= w->clusters->error, "the error counts until then");
    }
    close_parts(&p);
}

static void neighbours_are_the_nearest_clusters(void)
{
    parts p;
    open_clusters(&p, SCENE_LAMPS, 32, 40);
    lightprobe__work *w = &p.work;
    lightprobe__find_near(w);
    for (int a = 0; a < w->cluster_count; a++) {
        const lightprobe_cluster *c = w->clusters + a;
        CHECK(c->near_count == LIGHTPROBE_NEAR, "%d neighbours", c->near_count);
        float last = 2;
        for (int i = 0; i < c->near_count; i++) {
            const lightprobe_cluster *d = w->clusters + c->nearby[i];
            const float near = nearness_of(c->centre, c->tone, d->centre, d->tone);
            CHECK(c->nearby[i] != a && near <= last, "cluster %d: neighbour %d", a, i);
            last = near;
        }
        int nearer = 0; // than the last of them
        for (int b = 0; b < w->cluster_count; b++) {
            const lightprobe_cluster *d = w->clusters + b;
            nearer += b != a && nearness_of(c->centre, c->tone, d->centre, d->tone) > last;
        }
        CHECK(nearer < LIGHTPROBE_NEAR, "cluster %d: %d are nearer than the last neighbour", a,
              nearer);
    }
    // The merger that costs least, of neighbours that have not changed.
    for (int round = 0; round < 6; round++) {
        const int not_this = round * 5 % w->cluster_count;
        lightprobe_pair pair = {-1, -1, FLT_MAX};
        for (int k = 0; k < w->cluster_count; k++)
            pair = lightprobe_cheaper_pair(w, pair, k, not_this);
        for (int a = 0; a < w->cluster_count; a++) {
            const lightprobe_cluster *c = w->clusters + a;
            for (int i = 0; i < c->near_count && !c->changed && a != not_this; i++) {
                const lightprobe_cluster *d = w->clusters + c->nearby[i];
                if (d->changed || c->nearby[i] == not_this) continue;
                CHECK(lightprobe_merge_cost(c->sum, d->sum, w->total) >= pair.cost,
                      "%d and %d cost less", a, c->nearby[i]);
            }
        }
        const lightprobe_cluster *a = w->clusters + pair.a, *b = w->clusters + pair.b;
        CHECK(pair.a != not_this && pair.b != not_this && !a->changed && !b->changed,
              "a pair left out");
        CHECK(lightprobe_merge_cost(a->sum, b->sum, w->total) <= pair.cost * 1.00001f,
              "another pair's cost");
        lightprobe_merge(w, pair, not_this);
        CHECK(a->changed && b->changed &&
                  (a->sum.luminance >= b->sum.luminance ? a : b)->lives == 2 &&
                  a->lives + b->lives == 2,
              "the dimmer keeps its id");
        w->clusters[not_this].changed = 0;
    }
    close_parts(&p);
}

// The error that Lloyd's iteration lowers: of direction and tone.
static double cost_of_clusters(const lightprobe__work *w)
{
    int in[LIGHTPROBE__LEAVES(64) + LIGHTPROBE_MORE_LEAVES];
    double sum = 0;
    for (int i = 0; i < w->leaf_count; i++) in[i] = w->leaves[i].cluster;
    for (int k = 0; k < w->cluster_count; k++) {
        const cost c = cost_of(w->leaves, in, k, w->leaf_count);
        sum += sqrt(c.luminance) * (c.direction + c.tone);
    }
    return sum;
}

static void relaxing_lowers_the_error(void)
{
    for (int scene = 0; scene < SCENE_COUNT; scene++) {
        parts p;
        const float total = open_clusters(&p, (test_scene)scene, 32, 40);
        double last = cost_of_clusters(&p.work);
        const double first = last;
        lightprobe__find_near(&p.work);
        for (int round = 0; round < 4; round++) {
            lightprobe__relax(&p.work, 1);
            const double now = cost_of_clusters(&p.work);
            CHECK(now <= last + 2e-6 * (double)total, "%s: %g after %g", test_scene_names[scene],
                  now, last);
            last = now;
        }
        CHECK(last < first, "%s: %g, not less than %g", test_scene_names[scene], last, first);
        close_parts(&p);
    }
}

// Each light that fades out has another that takes over, and neither has to do with a second change.
static void reassigned_lights_come_in_pairs(void)
{
    int all = 0;
    for (int scene = 0; scene < SCENE_COUNT; scene++) {
        parts p;
        int kinds[3] = {0}, changed = 0;
        open_clusters(&p, (test_scene)scene, 32, 40);
        lightprobe__work *w = &p.work;
        lightprobe__find_near(w);
        lightprobe__reassign_lights(w, 0.1f);
        for (int k = 0; k < w->cluster_count; k++) {
            kinds[w->clusters[k].lives]++;
            changed += w->clusters[k].changed;
        }
        CHECK(kinds[0] == kinds[2] && kinds[0] <= w->cluster_count / 4 + 1,
              "%s: %d lights fade into %d", test_scene_names[scene], kinds[0], kinds[2]);
        CHECK(changed == 3 * kinds[0], "%s: %d lights have to do with %d changes",
              test_scene_names[scene], changed, kinds[0]);
        all += kinds[0];
        lightprobe__reassign_lights(w, 0.1f);
        for (int k = 0; k < w->cluster_count && kinds[0]; k++) kinds[0] -= !w->clusters[k].lives;
        CHECK(kinds[0] == 0, "%s: a change before the last one is over", test_scene_names[scene]);
        close_parts(&p);
    }
    CHECK(all > 0, "nothing changes");
}

static void lights_without_a_place_or_a_plane_have_no_slope(void)
{
    lightprobe_light light;
    lightprobe_region r = lightprobe_no_region();
    lightprobe_tilt t = {0};
    memset(&light, 0, sizeof light);
    for (int placed = 0; placed < 2; placed++) {
        light.distance = (float)placed;
        const lightprobe_light same = lightprobe_tilted(light, r, t);
        CHECK(same.slope_u == 0 && same.slope_v == 0 && same.distance == light.distance,
              "at distance %d", placed);
    }
}

static void distances_come_from_luminance_over_them(void)
{
    const float rgb[3] = {3, 3, 3}, black[3] = {0, 0, 0};
    CHECK(fabsf(lightprobe_whole_distance(rgb, 1.5f) - 2) < 1e-6f, "3 over 1.5");
    CHECK(lightprobe_whole_distance(rgb, 0) == 0 && lightprobe_whole_distance(rgb, -1) == 0 &&
              lightprobe_whole_distance(black, 1) == 0,
          "none");
}

static double variance_of(double tangent)
{
    return tangent * tangent / (3 + 3 * tangent * tangent);
}

// Half of what changes a light's sizes waits for the next frame; less of it the more its flux has changed,
// and in fewer frames. 1 - cosine changes by a tenth in a frame, and by a texel. Without a pace, at once.
static void half_of_a_new_size_comes_late(void)
{
    uint64_t state = 3;
    for (int i = 0; i < test_trials(2000); i++) {
        const double past = test_range(&state, 1, 9), change = test_range(&state, -0.08, 0.08),
                     pace = test_range(&state, 1, 4), side = 16 << i % 5;
        const double held = fmax(0.5 - 10 * fabs(change), 0) / pace;
        lightprobe_cluster c = lightprobe_fresh();
        lightprobe_light light;
        memset(&light, 0, sizeof light);
        c.across[0] = light.axis_u[0] = light.axis_v[1] = 1;
        for (int k = 0; k < 3; k++) {
            c.past.flux[k] = (float)past;
            c.now.flux[k] = (float)(past * (1 + change));
        }
        const double u = test_range(&state, 0.1, 1), v = test_range(&state, 0.01, 0.1),
                     was = pow(10, test_range(&state, -4, -0.7)),
                     wide = was * test_range(&state, 0.7, 1.5);
        light.tan_half_u = (float)u;
        light.tan_half_v = (float)v;
        light.cos_alpha = (float)(1 - wide);
        c.sizes[0] = (float)test_range(&state, 0.01, 0.1);
        c.sizes[1] = (float)test_range(&state, 1e-5, 0.01);
        c.sizes[2] = (float)was;
        const lightprobe_light same = lightprobe_steadied(light, c, 0, (float)side),
                               l = lightprobe_steadied(light, c, (float)pace, (float)side);
        CHECK(!memcmp(&same, &light, sizeof light), "without a pace it changes");
        const double now = held * was + (1 - held) * wide, up = 1 + 0.1 * pace,
                     texel = 2 / (side * side),
                     to = fmax(fmin(now, was * up + texel), was / up - texel);
        const double want[3] = {
            (held * (double)c.sizes[0] + (1 - held) * variance_of(u)) * to / now,
            (held * (double)c.sizes[1] + (1 - held) * variance_of(v)) * to / now, to};
        const double got[3] = {variance_of((double)l.tan_half_u), variance_of((double)l.tan_half_v),
                               1 - (double)l.cos_alpha};
        light.tan_half_v = light.tan_half_u;
        c.across[0] = 0;
        const lightprobe_light round = lightprobe_steadied(light, c, 1, (float)side);
        CHECK(!memcmp(round.axis_u, light.axis_u, sizeof light.axis_u), "from no axis it turns");
        for (int k = 0; k < 3; k++)
            CHECK(fabs(got[k] - want[k]) < 3e-6 + 2e-3 * (k < 2) * want[k],
                  "size %d, flux %g, pace %g: %g, not %g", k, change, pace, got[k], want[k]);
    }
}

const test_case parts_tests[] = {
    {"parts: logarithms and tones are exact", logarithms_and_tones_are_exact},
    {"parts: costs and gains are those of the leaves", costs_and_gains_are_those_of_the_leaves},
    {"parts: unevenness is Cramer's distance to a uniform light", unevenness_is_cramers_distance},
    {"parts: swaps pay when the gain is 16 times the cost",
     swaps_pay_when_the_gain_is_16_times_the_cost},
    {"parts: eigenvectors belong to the largest eigenvalue",
     eigenvectors_belong_to_the_largest_eigenvalue},
    {"parts: axes hold two deviations to each side", axes_hold_two_deviations_to_each_side},
    {"parts: cells are sums over their texels", cells_are_sums_over_their_texels},
    {"parts: the largest comes first", the_largest_comes_first},
    {"parts: leaves tile the sphere", leaves_tile_the_sphere},
    {"parts: sorted leaves are those of their cluster", sorted_leaves_are_those_of_their_cluster},
    {"parts: planned cuts are the best of fourteen", planned_cuts_are_the_best_of_fourteen},
    {"parts: neighbours are the nearest clusters", neighbours_are_the_nearest_clusters},
    {"parts: reassigned lights come in pairs", reassigned_lights_come_in_pairs},
    {"parts: relaxing lowers the error", relaxing_lowers_the_error},
    {"parts: distances come from luminance over them", distances_come_from_luminance_over_them},
    {"parts: lights without a place or a plane have no slope",
     lights_without_a_place_or_a_plane_have_no_slope},
    {"parts: half of a new size comes late", half_of_a_new_size_comes_late},
    {NULL, NULL},
};
