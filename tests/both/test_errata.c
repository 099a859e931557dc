// What the four papers print and what is right, as formulas: each test computes both, and the truth
// by another way. docs/errata.md has the derivations. Five older ones are beside what they are
// about: "erratum" in test_moments.c, test_lightprobe.c and test_map.c.
#include "../../lightprobe.h"
#include "../../mssm.h"
#include "../support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Direction of (s, t) on a cube face, in its own axes: s, t, the face's normal.
static void direction_of(double s, double t, double d[3])
{
    const double r = sqrt(1 + s * s + t * t);
    d[0] = s / r;
    d[1] = t / r;
    d[2] = 1 / r;
}

// The k-th axis of the face, projected as 4.1.2 does: made orthogonal to the direction.
static void projected(int k, const double d[3], double axis[3])
{
    for (int i = 0; i < 3; i++) axis[i] = (i == k) - d[k] * d[i];
}

// ---- image-based lighting ----------------------------------------------------------------------

// 4.1.2 scales a size on the face by the length of the projected axis; at distance 1 from the
// receiver it is also nearer by 1/r.
static void sizes_need_the_distance(void)
{
    double worst = 0;
    for (int i = 0; i <= 40; i++) {
        for (int j = 0; j <= 40; j++) {
            const double s = -1 + i / 20.0, t = -1 + j / 20.0, h = 1e-4;
            double a[3], b[3], d[3], axis[3], cross = 0;
            direction_of(s - h, t, a);
            direction_of(s + h, t, b);
            direction_of(s, t, d);
            for (int k = 0; k < 3; k++) cross += (b[k] - a[k]) * (b[k] - a[k]);
            const double truth = 0.5 * sqrt(cross); // half of the angle between the ends
            projected(0, d, axis);
            const double printed = h * sqrt(dot(axis, axis)), r = sqrt(1 + s * s + t * t);
            CHECK(fabs(printed / r / truth - 1) < 1e-6, "(%g, %g): %g, not %g", s, t, printed / r,
                  truth);
            worst = fmax(worst, printed / truth);
        }
    }
    CHECK(fabs(worst - sqrt(3.0)) < 1e-6, "the printed size is at worst %g times the true one",
          worst);
    test_note("the printed size is up to %.1f%% too large", 100 * (worst - 1));
}

static void projected_axes_are_oblique(void)
{
    double worst = 0;
    for (int i = 0; i <= 40; i++) {
        for (int j = 0; j <= 40; j++) {
            const double s = -1 + i / 20.0, t = -1 + j / 20.0;
            double d[3], u[3], v[3];
            direction_of(s, t, d);
            projected(0, d, u);
            projected(1, d, v);
            const double cosine = dot(u, v) / sqrt(dot(u, u) * dot(v, v));
            const double closed = -s * t / sqrt((1 + s * s) * (1 + t * t));
            CHECK(fabs(cosine - closed) < 1e-12, "(%g, %g): %g, not %g", s, t, cosine, closed);
            worst = fmax(worst, acos(cosine) * 180 / pi);
        }
    }
    CHECK(fabs(worst - 120) < 1e-6, "at most %g degrees", worst);
}

enum { SIDE = 64 };

// The paper's way keeps the oblique axes but mends the size; a shadow map's axes are orthogonal.
static void oblique_axes_are_straightened(void)
{
    const lightprobe_settings settings = {.max_lights = 6, .mode = LIGHTPROBE_MEDIAN_CUT};
    static float texels[6][3 * SIDE * SIDE];
    const float *const faces[6] = {texels[0], texels[1], texels[2],
                                   texels[3], texels[4], texels[5]};
    lightprobe_cube cube = {{0}, SIDE, 3};
    lightprobe_light lights[6];
    mssm_light map;
    memcpy(cube.face, faces, sizeof faces);
    memset(texels, 0, sizeof texels);
    for (int i = 0; i < 64; i++) // 8 x 8 texels of +Z, in the corner of largest s and t
        for (int k = 0; k < 3; k++)
            texels[4][3 * ((SIDE - 8 + i / 8) * SIDE + SIDE - 8 + i % 8) + k] = 1;
    const size_t bytes = lightprobe_scratch_bytes(SIDE, 6);
    void *scratch = malloc(bytes);
    int count = 6;
    const lightprobe_result made =
        lightprobe_extract(&cube, &settings, scratch, bytes, lights, &count, NULL);
    free(scratch);
    CHECK(!made && count == 1, "%d lights: %s", count, lightprobe_result_string(made));
    if (made || count != 1) return;
    const lightprobe_light *l = &lights[0];
    const double at = 1 - 8.0 / SIDE, half = sqrt(63.0 / 64) * 8 / SIDE; // of 8 texels' middles
    double d[3], axis[3];
    direction_of(at, at, d);
    projected(0, d, axis);
    const double printed = half * sqrt(dot(axis, axis)), right = printed / sqrt(1 + 2 * at * at);
    CHECK(fabs((double)l->tan_half_u / right - 1) < 0.01, "%g, not %g", (double)l->tan_half_u,
          right);
    CHECK(printed / (double)l->tan_half_u > 1.5, "the printed size would do as well");
    const float along =
        l->axis_u[0] * l->axis_v[0] + l->axis_u[1] * l->axis_v[1] + l->axis_u[2] * l->axis_v[2];
    CHECK(fabs(fabs((double)along) - at * at / (1 + at * at)) < 0.01, "cosine of the axes %g",
          (double)along);
    const float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};
    const mssm_result light = mssm_light_directional(&map, l->direction, l->axis_u, l->tan_half_u,
                                                     l->tan_half_v, low, high);
    double rows = 0, u = 0, v = 0;
    for (int k = 0; k < 3 && !light; k++) {
        const double a = (double)map.world_to_shadow[4 * k],
                     b = (double)map.world_to_shadow[4 * k + 1];
        rows += a * b;
        u += a * a;
        v += b * b;
    }
    CHECK(!light && fabs(rows) < 1e-6 * sqrt(u * v), "axes of the map: cosine %g",
          rows / sqrt(u * v));
}

// Eq. 11 calls the integral of radiance irradiance. It is that only for a light without size: a
// receiver that faces a disc of half-angle alpha gets cos^2(alpha / 2) of it.
static void flux_is_not_irradiance(void)
{
    for (int degrees = 0; degrees <= 90; degrees += 15) {
        const double c = cos(degrees * pi / 180);
        enum { STEPS = 20000 };
        double sum = 0, flux = 0;
        for (int i = 0; i < STEPS; i++) {
            const double height = c + (1 - c) * (i + 0.5) / STEPS; // equal heights, equal areas
            sum += height;
            flux += 1;
        }
        const double got = (double)lightprobe_disc_irradiance((float)c, 1);
        CHECK(fabs(got - sum / flux) < 1e-6 && fabs(got - 0.5 * (1 + c)) < 1e-6, "%d: %g, not %g",
              degrees, got, sum / flux);
    }
}

// ---- slides -------------------------------------------------------------------------------------

// Slide 72: with a scale of 2^32/n, rounded, n texels of 1 overflow to about nothing for every n
// whose 2^32/n rounds up.
static void rounded_scales_wrap(void)
{
    int wraps = 0;
    for (uint64_t n = 1; n <= 4000; n++) {
        const uint64_t all = (uint64_t)1 << 32, rounded = (2 * all + n) / (2 * n);
        const uint32_t printed = (uint32_t)(n * rounded), mended = (uint32_t)(n * ((all - 1) / n));
        wraps += printed < all / 2;
        CHECK(mended > all - 1 - n, "n = %d: floor((2^32-1)/n) sums to %u", (int)n, mended);
    }
    // Those that divide 2^32 wrap to 0 exactly.
    test_note("2^32/n wraps for %.1f%% of all n to 4000", wraps / 40.0);
    CHECK(wraps > 1900 && wraps < 2100, "%d of 4000 wrap", wraps);
    CHECK((uint32_t)(729 * (uint64_t)5891588) < 1000, "729 texels do not wrap");
}

// "Retrieve moments": (.5, 0, .5, 0) is taken off before the product, not after as the text has it.
// The forward transform is an image there; solved for, it is what these polynomials say.
static void quantization_is_undone_before_the_product(void)
{
    static const double inverse[4][4] = {{-1.0 / 3, 0, 1.7320508075688772, 0},
                                         {0, 0.125, 0, 1},
                                         {-0.75, 0, 0.75 * 1.7320508075688772, 0},
                                         {0, -0.125, 0, 1}};
    double worst = 0;
    for (int i = 0; i <= 20; i++) {
        const double z = -1 + i / 10.0, z2 = z * z;
        const double stored[4] = {1.5 * z - 2 * z * z2 + 0.5, 4 * z2 - 4 * z2 * z2,
                                  sqrt(3.0) / 2 * z - sqrt(12.0) / 9 * z * z2 + 0.5,
                                  0.5 * z2 + 0.5 * z2 * z2};
        double power = 1;
        for (int k = 0; k < 4; k++) {
            CHECK(stored[k] > -1e-12 && stored[k] < 1 + 1e-12, "channel %d holds %g", k, stored[k]);
            double before = 0, after = k % 2 ? 0 : -0.5;
            for (int j = 0; j < 4; j++) {
                before += inverse[k][j] * (stored[j] - (j % 2 ? 0 : 0.5));
                after += inverse[k][j] * stored[j];
            }
            power *= z;
            CHECK(fabs(before - power) < 1e-12, "depth %g, moment %d: %g", z, k + 1, before);
            worst = fmax(worst, fabs(after - power));
        }
    }
    CHECK(worst > 0.1, "after the product it would do as well: %g", worst);
}

// ---- convolution soft shadows ------------------------------------------------------------------

// Eq. 11 has 2/c_k, which depends on k, in front of the sum over k.
static double blocked_depth(int terms, int inside, double receiver, const double *z, int count)
{
    double sum = 0;
    for (int i = 0; i < count; i++) sum += 0.5 * z[i] / count;
    for (int k = 1; k <= terms; k++) {
        const double c = pi * (2 * k - 1);
        double cosine = 0, sine = 0;
        for (int i = 0; i < count; i++) {
            cosine += z[i] * cos(c * z[i]) / count;
            sine += z[i] * sin(c * z[i]) / count;
        }
        const double wave = sin(c * receiver) * cosine - cos(c * receiver) * sine;
        sum +=
            2 / (inside ? c : pi * (2 * terms - 1)) * wave; // outside: the last k is as good as any
    }
    return sum;
}

static void weights_of_the_series_stay_inside(void)
{
    static const double z[8] = {0.11, 0.17, 0.23, 0.31, 0.62, 0.68, 0.74, 0.83};
    const double truth = (0.11 + 0.17 + 0.23 + 0.31) / 8;
    double before = 1;
    for (int terms = 4; terms <= 256; terms *= 4) {
        const double error = fabs(blocked_depth(terms, 1, 0.47, z, 8) - truth);
        CHECK(error < before, "%d terms: %g", terms, error);
        before = error;
    }
    CHECK(before < 1e-3, "256 terms are off by %g", before);
    const double printed = fabs(blocked_depth(256, 0, 0.47, z, 8) - truth);
    CHECK(printed > 0.05, "as printed it would do as well: %g", printed);
}

// ---- thesis -------------------------------------------------------------------------------------

// 2.8 calls M2 - M1^2 sigma, 2.9 squares it again; and a fragment is occluded where d > mu.
static void variance_is_squared_once(void)
{
    for (int i = 1; i < 10; i++) {
        const double lit = i / 10.0, nearer = 0.3, d = 0.8; // a planar occluder, a planar receiver
        const double mean = lit * d + (1 - lit) * nearer;
        const double variance = lit * d * d + (1 - lit) * nearer * nearer - mean * mean;
        const double off2 = (d - mean) * (d - mean);
        CHECK(d > mean, "the receiver is not behind the mean");
        CHECK(fabs(variance / (variance + off2) - lit) < 1e-12, "%g of %g is lit",
              variance / (variance + off2), lit);
        const double printed = variance * variance / (variance * variance + off2);
        CHECK(printed < 0.75 * lit, "as printed %g of %g is lit", printed, lit);
    }
}

// 2.15: the mean of all is P z_unocc + (1 - P) z_b.
static void mean_of_the_blockers(void)
{
    uint64_t state = 15;
    double worst = 0;
    for (int i = 0; i < 1000; i++) {
        const double d = test_range(&state, 0.3, 0.9);
        double all = 0, sum[2] = {0, 0}, count[2] = {0, 0};
        for (int k = 0; k < 64; k++) {
            const double z = k < 2 ? d + (k ? 0.05 : -0.05) : test_uniform(&state);
            sum[z < d] += z;
            count[z < d]++;
            all += z / 64;
        }
        const double lit = count[0] / 64, unoccluded = sum[0] / count[0], truth = sum[1] / count[1];
        CHECK(fabs((all - lit * unoccluded) / (1 - lit) - truth) < 1e-12, "not %g", truth);
        worst = fmax(worst, fabs((all - lit) / (1 - lit) * unoccluded - truth));
    }
    CHECK(worst > 0.3, "as printed it is off by %g at most", worst);
}

// 3.12: shading times shadow is the integral of the product only after a division by the light's
// area.
static void shadow_term_is_a_mean(void)
{
    enum { N = 64 };
    const double width = 0.7, height = 0.4, area = width * height, radiance = 3;
    double truth = 0, shading = 0, shadow = 0;
    for (int i = 0; i < N * N; i++) { // a light above, parallel to the receiver, half of it covered
        const double x = width * ((i % N + 0.5) / N - 0.5), y = height * ((i / N + 0.5) / N - 0.5);
        const double r2 = 1 + x * x + y * y, g = 1 / (r2 * r2), part = area / (N * N);
        const int visible = x < 0;
        truth += radiance * visible * g * part;
        shading += g * part;
        shadow += radiance * visible * part;
    }
    CHECK(fabs(shading * shadow / area / truth - 1) < 1e-9, "%g, not %g", shading * shadow / area,
          truth);
    CHECK(fabs(shading * shadow / truth - area) < 1e-9, "as printed it is off by the light's area");
}

// 5.2.8: 1e45 is not how many floats there are in [0,1] but one over the least of them.
static void floats_between_0_and_1(void)
{
    uint32_t one;
    const float f = 1;
    memcpy(&one, &f, sizeof one); // positive floats are in the order of their bits
    CHECK(one + 1 == 1065353217u, "%u floats", one + 1);
    CHECK(one + 1.0 < 4294967296.0 / 4, "not fewer than a quarter of 32 bits");
    const double step = 1 - (double)nextafterf(1, 0);
    CHECK(step > 200 * pow(2, -32), "beneath 1 they are %g apart", step);
}

const test_case errata_tests[] = {
    {"erratum: 4.1.2, sizes on a cube face are divided by the distance", sizes_need_the_distance},
    {"erratum: 4.1.2, projected axes are up to 120 degrees apart", projected_axes_are_oblique},
    {"erratum: 4.1.2, the paper's lights have mended sizes, maps straight axes",
     oblique_axes_are_straightened},
    {"erratum: Eq. 11 is no irradiance of a light with size", flux_is_not_irradiance},
    {"erratum: slides, half of all scales 2^32/n wrap", rounded_scales_wrap},
    {"erratum: slides, quantization is undone before the product",
     quantization_is_undone_before_the_product},
    {"erratum: convolution Eq. 11, weights belong inside the sum",
     weights_of_the_series_stay_inside},
    {"erratum: thesis 2.9, the variance is squared once", variance_is_squared_once},
    {"erratum: thesis 2.15, the mean depth of the blockers", mean_of_the_blockers},
    {"erratum: thesis 3.12, the shadow term is a mean over the light", shadow_term_is_a_mean},
    {"erratum: thesis 5.2.8, floats between 0 and 1", floats_between_0_and_1},
    {0, 0}};
