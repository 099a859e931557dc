// What the horizon leaves of a light, number by number, against polygons, brute force and the whole
// light. The header is compiled once more here, for its private functions.
#define MSSM_STATIC
#ifndef MSSM_NO_GL
#define MSSM_NO_GL
#endif
#define MSSM_NO_FILTERED
#define MSSM_NO_SCATTERING
#define MSSM_IMPLEMENTATION
#include "../../mssm.h"
#include "../support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 64 };

// Share of (a, b) in [-1,1]^2 where facing + u a + v b > 0: the square clipped to a polygon.
static double share_above(double facing, double u, double v)
{
    static const double corner[5][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {-1, -1}};
    double kept[8][2], area = 0;
    int count = 0;
    for (int i = 0; i < 4; i++) {
        const double *a = corner[i], *b = corner[i + 1];
        const double ha = facing + u * a[0] + v * a[1], hb = facing + u * b[0] + v * b[1];
        if (ha > 0) memcpy(kept[count++], a, sizeof *kept);
        if ((ha > 0) == (hb > 0)) continue;
        for (int k = 0; k < 2; k++) kept[count][k] = a[k] + ha / (ha - hb) * (b[k] - a[k]);
        count++;
    }
    for (int i = 0; i < count; i++) {
        const double *a = kept[i], *b = kept[(i + 1) % count];
        area += 0.5 * (a[0] * b[1] - a[1] * b[0]);
    }
    return area / 4;
}

// Least depth, or least of -depth, of the texels that touch a square and are on the map; 1: none.
static float least_of(const float *depth, int side, double x, double y, double half, int which)
{
    float least = 1;
    for (int i = 0; i < side * side; i++) {
        const double u = i % side, v = i / side, z = which ? -(double)depth[i] : (double)depth[i];
        if (u + 1 > x - half && u < x + half && v + 1 > y - half && v < y + half)
            least = fminf(least, (float)z);
    }
    return least;
}

// Nothing in the square is passed over, and nothing counts that is further off than two texels of its
// level.
static void least_depths_are_those_of_the_square(void)
{
    uint64_t seed = 9;
    int exact = 0, count = 0;
    for (int trial = 0; trial < test_trials(400); trial++) {
        const int side = 1 + (int)test_range(&seed, 0, 70);
        float *depth = malloc((size_t)(side * side) * sizeof *depth);
        const size_t bytes = mssm_map_bytes(side, 4);
        void *memory = malloc(bytes);
        mssm_map *map;
        for (int i = 0; i < side * side; i++) depth[i] = (float)test_range(&seed, -1, 1);
        CHECK(!mssm_map_init(&map, memory, bytes, side, 4), "init");
        CHECK(!mssm_map_update(map, depth, NULL, 1), "update");
        for (int i = 0; i < 50; i++) {
            const double half = pow(10, test_range(&seed, -0.3, 1.5));
            const float x = (float)test_range(&seed, 0, side),
                        y = (float)test_range(&seed, 0, side);
            const double texel = half <= 1 ? 2 : fmax(4, exp2(ceil(log2(half))));
            const double reach = half <= 1 ? half + texel : 2 * texel; // that at the map's rim
            for (int which = 0; which < 2; which++) {
                const float got = mssm__least(map, x, y, (float)half, which);
                const float most = least_of(depth, side, x, y, half - 1e-4, which);
                const float least = least_of(depth, side, x, y, reach, which);
                CHECK(got <= most && got >= least, "side %d, %g around (%g, %g): %g, not %g to %g",
                      side, half, (double)x, (double)y, (double)got, (double)least, (double)most);
                exact += got >= most;
                count++;
            }
        }
        free(depth);
        free(memory);
    }
    test_note("%d of %d are those of the square alone", exact, count);
}

static struct mssm_receiver receiver(void)
{
    struct mssm_receiver r;
    memset(&r, 0, sizeof r);
    r.x = 30;
    r.y = 20;
    r.d_max = 2;
    r.plane = 1;
    return r;
}

static mssm_view view_of(double kernel_u, double kernel_v)
{
    mssm_view v;
    memset(&v, 0, sizeof v);
    v.kernel_u = (float)kernel_u;
    v.kernel_v = (float)kernel_v;
    v.max_half = MSSM_FAR_AWAY;
    v.side = SIDE;
    return v;
}

static struct mssm_receiver cut(mssm_view v, double facing, double u, double w)
{
    struct mssm_receiver r = receiver();
    r.kernel_u = v.kernel_u;
    r.kernel_v = v.kernel_v;
    return mssm_cut_light(v, r, (float)facing, (float)u, (float)w);
}

static void cut_lights_have_the_area_above(void)
{
    uint64_t state = 51;
    for (int i = 0; i < test_trials(20000); i++) {
        const double scale = exp(test_range(&state, -9, 9));
        const double u = test_range(&state, -1, 1), w = test_range(&state, -1, 1);
        const double p = fabs(u), q = fabs(w), s = test_range(&state, -1, 1) * (p + q);
        const double kernel_u = test_range(&state, 1, 40), kernel_v = test_range(&state, 1, 40);
        if (fmin(p, q) < 0.06 * (fabs(s) + p + q)) continue;
        const struct mssm_receiver r =
            cut(view_of(kernel_u, kernel_v), s * scale, u * scale, w * scale);
        const double share = share_above(s, u, w), off = fmax(2 * share - 1, 0.8);
        const double half_u = (double)r.kernel_u / kernel_u, half_v = (double)r.kernel_v / kernel_v;
        // Narrower in equal parts of the slopes' squares, to the area above; then off the horizon.
        const double loss = (1 - share) / (p * p + q * q);
        const double narrow_u = 1 - loss * p * p, narrow_v = 1 - loss * q * q;
        CHECK(fabs(half_u * half_v - share * off * off) < 1e-5, "%g of %g above", half_u * half_v,
              share);
        CHECK(fabs(half_u * narrow_v - half_v * narrow_u) < 1e-5, "%g by %g", half_u, half_v);
        CHECK(fabs((double)r.shift_u / kernel_u - copysign(1 - half_u, u)) < 1e-5 &&
                  fabs((double)r.shift_v / kernel_v - copysign(1 - half_v, w)) < 1e-5,
              "away from the corner by %g %g", (double)r.shift_u / kernel_u + half_u,
              (double)r.shift_v / kernel_v + half_v);
        CHECK(r.plane == 2, "not cut");
        // Seen from behind the plane ends at (p + q) / |s| times the distance of its near end.
        const double far_end = s < 0 ? (p + q) / -s : 2;
        if (far_end > 1.1)
            CHECK(s >= 0 ? r.sink == 0 : fabs(1 / (double)r.sink - (far_end - 1)) < 1e-4 * far_end,
                  "sink %g, the plane ends at %g", (double)r.sink, far_end);
        const float half_way = (float)(0.5 + 0.5 * far_end);
        const double left = (double)mssm_off_plane(r, half_way, 1e30f);
        CHECK(s >= 0 ? left == 1 : far_end < 1.2 || fabs(left - 0.5) < 0.06, "%g half way", left);
    }
}

// From all above over the horizon to all of it again, and past the axes: nothing jumps.
static void cut_lights_change_bit_by_bit(void)
{
    enum { STEPS = 4000 };
    uint64_t state = 52;
    double worst = 0;
    for (int way = 0; way < 40; way++) {
        const mssm_view v = view_of(1, 1);
        const double u = test_range(&state, -1, 1), w = test_range(&state, -1, 1);
        const double facing = test_range(&state, -1.5, 1.5);
        struct mssm_receiver before = receiver();
        for (int i = 0; i <= STEPS; i++) {
            const double at = 2.6 * i / STEPS - 1.3;
            const struct mssm_receiver r =
                way % 2 ? cut(v, -2 * at * (fabs(u) + fabs(w) + 0.1), u, w) : cut(v, facing, at, w);
            const double step[5] = {
                (double)(r.kernel_u - before.kernel_u), (double)(r.kernel_v - before.kernel_v),
                (double)(r.shift_u - before.shift_u), (double)(r.shift_v - before.shift_v),
                (double)(1 / (1 + r.sink) - 1 / (1 + before.sink))};
            for (int k = 0; k < 5 && i; k++) worst = fmax(worst, fabs(step[k]) * (k < 4 ? 4 : 1));
            const double depth = at / (fabs(u) + fabs(w)) * 2 * (fabs(u) + fabs(w) + 0.1);
            if (way % 2 && fmin(fabs(u), fabs(w)) > 0.06 * (fabs(u) + fabs(w)) * (1 + depth))
                CHECK(depth < 1 || fabs(1 / (1 + (double)r.sink) - fmin(depth - 1, 1)) < 1e-4,
                      "%g deep, sink %g", depth, (double)r.sink);
            before = r;
            if (way % 2 == 0 || (i > 0 && i < STEPS)) continue;
            CHECK(r.plane == 1 && r.kernel_u == 1 && r.kernel_v == 1 && r.shift_u == 0 &&
                      r.shift_v == 0 && r.sink == 0,
                  "cut at the end: %g %g", (double)r.kernel_u, (double)r.kernel_v);
        }
    }
    test_note("steps up to %.4f", worst);
    CHECK(worst < 0.06, "a step of %g", worst);
}

// The square is the least around the receiver's end and the widest kernel; all others lie in it.
static void searches_hold_all_kernels(void)
{
    uint64_t state = 53;
    for (int i = 0; i < test_trials(4000); i++) {
        const mssm_view v = view_of(test_range(&state, 1, 30), test_range(&state, 1, 30));
        const double u = test_range(&state, -1, 1), w = test_range(&state, -1, 1);
        const struct mssm_receiver r = cut(v, test_range(&state, -2.2, 1.2), u, w);
        const float d = (float)test_range(&state, 0.6, 2);
        const struct mssm_square s = mssm_search_square(v, r, d);
        double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
        for (int k = 0; k <= 16; k++) {
            const double e = (double)d * k / 16;
            const double x[2] = {(double)r.shift_u * e, (double)r.shift_v * e};
            const double half[2] = {fmax((double)r.kernel_u * e, 0.5),
                                    fmax((double)r.kernel_v * e, 0.5)};
            for (int n = 0; n < 2; n++) low[n] = fmin(low[n], x[n] - half[n]);
            for (int n = 0; n < 2; n++) high[n] = fmax(high[n], x[n] + half[n]);
        }
        const double at[2] = {(double)(s.x - r.x), (double)(s.y - r.y)}, size = (double)s.half_size;
        double need = 0.5;
        const double out = (fabs((double)r.shift_u) + fabs((double)r.shift_v)) * (double)d;
        for (int n = 0; n < 2; n++) {
            need = fmax(need, 0.5 * (high[n] - low[n]));
            CHECK(at[n] - size < low[n] + 1e-4 && at[n] + size > high[n] - 1e-4,
                  "%g to %g searched, kernels %g to %g", at[n] - size, at[n] + size, low[n],
                  high[n]);
        }
        CHECK(size < 1.0001 * need + fmin(out, 0.5), "%g searched, %g needed", size, need);
    }
}

// A map of steps, and the same light with and without the cut.
static void lights_not_cut_are_whole(void)
{
    static const float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1}, axis[3] = {1, 0, 0},
                       up[3] = {0, 1, 0};
    const mssm_settings horizon = {0, MSSM_HORIZON, 0, 0, 0, 0};
    const size_t bytes = mssm_map_bytes(SIDE, 6);
    float *depth = (float *)malloc(SIDE * SIDE * sizeof *depth);
    void *memory = malloc(bytes);
    mssm_map *map = NULL;
    mssm_light light;
    uint64_t state = 54;
    int cut_ones = 0;
    if (!depth || !memory) abort();
    for (int i = 0; i < SIDE * SIDE; i++)
        depth[i] = 0.1f * (float)((i / SIDE / 8 + i % SIDE / 8) % 5);
    CHECK(mssm_light_directional(&light, up, axis, 0.5f, 0.3f, low, high) == MSSM_OK, "light");
    CHECK(mssm_map_init(&map, memory, bytes, SIDE, 6) == MSSM_OK, "init");
    CHECK(mssm_map_update(map, depth, NULL, 1) == MSSM_OK, "update");
    for (int i = 0; i < test_trials(20000); i++) {
        const float p[3] = {(float)test_range(&state, -1.2, 1.2), (float)test_range(&state, -1, 1),
                            (float)test_range(&state, -1.2, 1.2)};
        const float n[3] = {(float)test_range(&state, -1, 1), (float)test_range(&state, -1, 1),
                            (float)test_range(&state, -1, 1)};
        const double edge = 0.5 * fabs((double)n[0]) + 0.3 * fabs((double)n[2]);
        const double size = edge + fabs((double)n[1]), facing = (double)n[1] / edge;
        const float whole = mssm_map_visibility_normal(map, &light, NULL, p, n);
        const float v = mssm_map_visibility_normal(map, &light, &horizon, p, n);
        const double margin = 1 + 0.1 * size / edge; // slopes count as a twentieth at least, each
        CHECK(v >= 0 && v <= 1, "%g", (double)v);
        if (facing > margin || facing < -2 * margin)
            CHECK(v == whole, "%g of a light that is %g above, %g of all", (double)v, facing,
                  (double)whole);
        else
            cut_ones += v != whole;
        const float without = mssm_map_visibility_normal(map, &light, &horizon, p, NULL);
        CHECK(without == mssm_map_visibility(map, &light, NULL, p), "cut without a normal");
    }
    CHECK(cut_ones > test_trials(20000) / 20, "only %d are cut", cut_ones);
    free(depth);
    free(memory);
}

// Kernels and slopes of any size: what is asked of the map stays finite.
static void cut_lights_of_any_size_stay_finite(void)
{
    uint64_t state = 55;
    for (int i = 0; i < test_trials(40000); i++) {
        const mssm_view v =
            view_of(exp(test_range(&state, -80, 88)), exp(test_range(&state, -80, 88)));
        const double u = test_range(&state, -1, 1) * exp(test_range(&state, -88, 87));
        const double w = i % 3 ? u * test_range(&state, -1, 1) : 0;
        struct mssm_receiver r = receiver();
        r.d_max = (float)exp(test_range(&state, -80, 80));
        r.kernel_u = v.kernel_u;
        r.kernel_v = v.kernel_v;
        r = mssm_cut_light(v, r, (float)(test_range(&state, -2, 1) * u), (float)u, (float)w);
        const double furthest =
            fmax(fabs((double)(r.shift_u * r.d_max)), fabs((double)(r.shift_v * r.d_max)));
        CHECK(furthest <= 1.0001 * (double)MSSM_FAR_AWAY, "%g texels off", furthest);
        CHECK(r.kernel_u >= 0 && r.kernel_v >= 0 && r.sink >= 0 && r.sink < 2e6,
              "kernels %g %g, sink %g", (double)r.kernel_u, (double)r.kernel_v, (double)r.sink);
    }
}

const test_case horizon_tests[] = {
    {"least depths are those of the square and its surroundings",
     least_depths_are_those_of_the_square},
    {"cut lights have the area above the horizon", cut_lights_have_the_area_above},
    {"cut lights change bit by bit", cut_lights_change_bit_by_bit},
    {"searches hold all kernels of cut lights", searches_hold_all_kernels},
    {"lights that the horizon does not cut are whole", lights_not_cut_are_whole},
    {"cut lights of any size stay finite", cut_lights_of_any_size_stay_finite},
    {0, 0}};
