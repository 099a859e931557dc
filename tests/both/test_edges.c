// Ends of ranges and refusals that the tests of single subjects do not come by: with these every
// branch of both headers' CPU halves is taken (tests/coverage.sh shows it).
#include "../support/oracle_lightprobe.h"
#include "../support/test.h"

#include "../../mssm.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- Lights of mssm.h ----

// All arguments of a light: a directional one takes 11 + 2 + 3 of them, a spot 9 + 5.
typedef struct arguments {
    float a[3], direction[3], axis[3], b[3]; // a, b: box, or a: position
    float number[5];
} arguments;

static mssm_result make_light(int spot, const arguments *g, int null, mssm_light *light)
{
    const float *a = null == 0 ? NULL : g->a, *direction = null == 1 ? NULL : g->direction;
    const float *axis = null == 2 ? NULL : g->axis, *b = null == 3 ? NULL : g->b, *n = g->number;
    if (null == 4) light = NULL;
    if (spot) return mssm_light_spot(light, a, direction, axis, n[0], n[1], n[2], n[3], n[4]);
    return mssm_light_directional(light, direction, axis, n[0], n[1], a, b);
}

static void each_bad_argument_alone_is_refused(void)
{
    static const arguments good[2] = {
        {{-1, -2, -3}, {0.3f, 1, 0.2f}, {1, 0, 0}, {1, 2, 3}, {0.1f, 0.2f, 0, 0, 0}},
        {{-1, -2, -3}, {0.3f, 1, 0.2f}, {1, 0, 0}, {0, 0, 0}, {0.5f, 1, 2, 0.1f, 0.2f}}};
    static const float bad[] = {NAN, -NAN, INFINITY, -INFINITY, -1};
    for (int spot = 0; spot < 2; spot++) {
        mssm_light light, before;
        memset(&light, 0x5a, sizeof light);
        before = light;
        for (int null = 0; null < 5; null++) {
            if (spot && null == 3) continue; // has no box
            CHECK(make_light(spot, &good[spot], null, &light) == MSSM_ERROR_ARGUMENT,
                  "spot %d, null %d", spot, null);
        }
        const int numbers = spot ? 5 : 2, vectors = spot ? 9 : 12;
        for (int i = 0; i < vectors + numbers; i++) {
            for (int k = 0; k < (i < vectors ? 4 : 5); k++) {
                arguments g = good[spot];
                float *at = i < 3   ? g.a + i
                            : i < 6 ? g.direction + (i - 3)
                            : i < 9 ? g.axis + (i - 6)
                                    : g.b + (i - 9);
                if (i >= vectors) at = g.number + (i - vectors);
                *at = bad[k];
                CHECK(make_light(spot, &g, -1, &light) == MSSM_ERROR_ARGUMENT,
                      "spot %d, argument %d is %g", spot, i, (double)bad[k]);
            }
        }
        CHECK(!memcmp(&light, &before, sizeof light), "a failed call changed its output");
        CHECK(!make_light(spot, &good[spot], -1, &light), "spot %d: the good one is refused", spot);
        for (int i = 0; i < 3 && !spot; i++) {
            arguments g = good[0];
            g.a[i] = g.b[i] + 1e-3f;
            CHECK(make_light(0, &g, -1, &light) == MSSM_ERROR_ARGUMENT, "box inside out, axis %d",
                  i);
        }
    }
}

// What is finite as it comes in need not stay so in the light's matrix.
static void frusta_beyond_the_range_of_float_are_refused(void)
{
    static const arguments wrong[] = {
        {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {2e-38f, 0, 0}, {0.1f, 0.1f, 0, 0, 0}},
        {{-3e38f, 0, 0}, {1, 0, 0}, {0, 1, 0}, {3e38f, 1, 1}, {0.1f, 0.1f, 0, 0, 0}},
        {{0, 3e38f, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 0}, {1e-3f, 1, 1.5f, 0, 0}},
        {{3e38f, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 0}, {1e-3f, 1, 2, 0, 0}}};
    for (int i = 0; i < 4; i++) {
        mssm_light light, before;
        memset(&light, 0x5a, sizeof light);
        before = light;
        const mssm_result r = make_light(i >= 2, &wrong[i], -1, &light);
        CHECK(r == MSSM_ERROR_ARGUMENT && !memcmp(&light, &before, sizeof light), "case %d: %s", i,
              mssm_result_string(r));
    }
    // The largest and smallest boxes that still fit.
    for (int e = -34; e <= 36; e += 10) {
        const float s = powf(10, (float)e);
        const arguments g = {{-s, -s, -s}, {1, 2, 3}, {1, 0, 0}, {s, s, s}, {0.1f, 0.1f, 0, 0, 0}};
        mssm_light light;
        float shadow[3];
        CHECK(!make_light(0, &g, -1, &light) && mssm_light_project(&light, g.a, shadow) &&
                  fabsf(shadow[0]) <= 1.001f && fabsf(shadow[2]) <= 1,
              "a box of 1e%d", e);
    }
}

// Where axis_u cannot be used, another is found; the frame is orthonormal whatever comes in.
static void any_axis_gives_an_orthonormal_frame(void)
{
    static const float v[9][3] = {{1, 0, 0},      {0, 1, 0},      {0, 0, -1},
                                  {1, 2, 3},      {3, 2, 1},      {2, 3, 1},
                                  {1, -1e-4f, 2}, {0, 0, 1e-20f}, {1e19f, -2e19f, 1e18f}};
    static const float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};
    for (int i = 0; i < 9 * 11; i++) {
        const float *direction = v[i % 9];
        float axis[3];
        for (int k = 0; k < 3; k++)
            axis[k] = i / 9 == 9 ? 0 : i / 9 == 10 ? direction[k] * -0.5f : v[i / 9][k];
        mssm_light light;
        CHECK(!mssm_light_directional(&light, direction, axis, 0, 0, low, high),
              "case %d is refused", i);
        const float *m = light.world_to_shadow;
        double row[3][3], length = 0, towards = 0;
        for (int r = 0; r < 3; r++) {
            double sum = 0;
            for (int k = 0; k < 3; k++) sum += (double)m[4 * k + r] * (double)m[4 * k + r];
            for (int k = 0; k < 3; k++) row[r][k] = (double)m[4 * k + r] / sqrt(sum);
        }
        for (int k = 0; k < 3; k++) length += (double)direction[k] * (double)direction[k];
        for (int k = 0; k < 3; k++) towards -= row[2][k] * (double)direction[k] / sqrt(length);
        for (int r = 0; r < 3; r++) {
            const double *a = row[r], *b = row[(r + 1) % 3], *c = row[(r + 2) % 3];
            CHECK(fabs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) < 1e-6, "case %d: not orthogonal",
                  i);
            // Depth grows away from the light, so the rows are left-handed.
            CHECK(fabs(a[1] * b[2] - a[2] * b[1] + c[0]) < 1e-6, "case %d: handedness", i);
        }
        CHECK(towards > 1 - 1e-6, "case %d: looks the wrong way", i);
    }
}

static void points_without_a_shadow_position_are_refused(void)
{
    static const float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1}, up[3] = {0, 1, 0},
                       x[3] = {1, 0, 0};
    static const float points[][3] = {{NAN, 0, 0},
                                      {0, INFINITY, 0},
                                      {0, 0, -INFINITY},
                                      {3e38f, 3e38f, 0},
                                      {-3e38f, -3e38f, -3e38f}};
    mssm_light light[2];
    CHECK(!mssm_light_directional(&light[0], up, x, 0, 0, low, high) &&
              !mssm_light_spot(&light[1], high, up, x, 1e-3f, 1, 2, 0, 0),
          "no lights");
    for (int i = 0; i < 10; i++) {
        float s[3] = {7, 8, 9};
        const float *p = points[i / 2];
        // A directional light may well project a distant point that a spot cannot.
        if (mssm_light_project(&light[i % 2], p, s)) {
            CHECK(i >= 6 && isfinite(s[0]) && isfinite(s[1]) && isfinite(s[2]), "case %d", i);
        } else {
            CHECK(s[0] == 7 && s[1] == 8 && s[2] == 9, "case %d writes", i);
        }
    }
    const float far_off[3] = {3e38f, 0, 3e38f};
    light[0].world_to_shadow[0] = 1e10f; // a frustum of one's own
    float s[3] = {7, 8, 9};
    CHECK(!mssm_light_project(&light[0], far_off, s) && s[0] == 7, "overflow is projected");
}

// ---- Moments ----

// What is stored is in [0,1]; anything else counts as the nearest of these, NaN as 1.
static void stored_moments_are_clamped(void)
{
    static const float bad[] = {-0.5f, -INFINITY, 1.5f, INFINITY, NAN}, good[] = {0, 0, 1, 1, 1};
    for (int i = 0; i < 6 * 5; i++) {
        const int k = i % 6, which = i / 6;
        mssm_moments6 six = {{0.5f, 0.6f, 0.4f, 0.7f, 0.3f, 0.5f}}, clamped = six;
        six.b[k] = bad[which];
        clamped.b[k] = good[which];
        mssm_moments4 four, clamped4;
        memcpy(four.b, six.b, sizeof four.b);
        memcpy(clamped4.b, clamped.b, sizeof clamped4.b);
        const mssm_moments6 a = mssm_moments6_decode(six), b = mssm_moments6_decode(clamped);
        const mssm_moments4 c = mssm_moments4_decode(four), d = mssm_moments4_decode(clamped4);
        CHECK(!memcmp(&a, &b, sizeof a) && !memcmp(&c, &d, sizeof c), "channel %d is %g", k,
              (double)bad[which]);
        const mssm_moments6 e = mssm_moments6_encode(six);
        const mssm_moments4 f = mssm_moments4_encode(four);
        for (int j = 0; j < 6; j++)
            CHECK(e.b[j] >= 0 && e.b[j] <= 1 && (j > 3 || (f.b[j] >= 0 && f.b[j] <= 1)),
                  "encoded %d", j);
    }
    for (int i = 0; i < 3; i++) { // far outside, both ends are reached in each channel
        const float x = i == 0 ? 100.0f : i == 1 ? -100.0f : 0;
        const mssm_moments6 e =
            mssm_moments6_encode((mssm_moments6){{x, x, x * 9, x * 9, x * 99, x * 99}});
        for (int j = 0; j < 6 && i < 2; j++)
            CHECK(e.b[j] == (i == 0 ? 1.0f : 0.0f), "%d: %g", j, (double)e.b[j]);
    }
}

// A pair of roots that rounding of the coefficients can have made complex is one double root; no
// other is.
static void only_rounding_makes_double_roots(void)
{
    static const float off[] = {-1e-3f, -1e-5f, 0, 1.2e-6f, 2.5e-6f, 1e-5f, 1e-3f};
    for (int i = 0; i < 7; i++) {
        // (x + 1)^2 + off: rounding of 2 and 1 + off makes up to 1.9e-6 of it.
        const mssm_roots3 r = mssm_solve_cubic(1 + off[i], 2, 1, 0);
        CHECK(r.count == (off[i] < 2e-6f ? 2 : 0), "%d roots at %g", r.count, (double)off[i]);
        // (x + 1)^2 (x - far), moved by a part of the sum of its terms there: 1.2e-6 is noise, 4e-6
        // is not.
        for (int k = 0; k < 4; k++) {
            static const double fars[] = {0.5, 3, 20, 300}, parts[] = {0.5e-6, 1.2e-6, 4e-6, 1e-5};
            const double far = fars[k], b = 2 - far, c = 1 - 2 * far;
            const double move = parts[i % 4] * (1 + fabs(b) + fabs(c) + far);
            const mssm_roots3 s = mssm_solve_cubic((float)(-far - move), (float)c, (float)b, 1);
            CHECK(s.count == (i % 4 < 2 ? 3 : 1), "%d roots, %g from a double one", s.count,
                  parts[i % 4]);
        }
        CHECK(off[i] < 0 || r.count == 0 || (fabsf(r.x[0] + 1) < 1e-3f && r.x[0] == r.x[1]),
              "root %g", (double)r.x[0]);
    }
}

// ---- Maps ----

static void nothing_given_is_lit(void)
{
    enum { side = 8 };
    static float depth[side * side];
    static const float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1}, up[3] = {0, 1, 0},
                       x[3] = {1, 0, 0};
    static const float below[3] = {0, -0.9f, 0}, nowhere[3] = {0, NAN, 0};
    const size_t bytes = mssm_map_bytes(side, 6);
    void *memory = malloc(bytes);
    mssm_map *map;
    mssm_light light;
    for (int i = 0; i < side * side; i++) depth[i] = -0.9f;
    CHECK(memory && !mssm_map_init(&map, memory, bytes, side, 6) &&
              !mssm_map_update(map, depth, NULL, 1) &&
              !mssm_light_directional(&light, up, x, 0.1f, 0.1f, low, high),
          "no map");
    CHECK(mssm_map_visibility(map, &light, NULL, below) < 0.01f, "a covered point is lit");
    CHECK(mssm_map_visibility(NULL, &light, NULL, below) == 1 &&
              mssm_map_visibility(map, NULL, NULL, below) == 1 &&
              mssm_map_visibility(map, &light, NULL, NULL) == 1 &&
              mssm_map_visibility(map, &light, NULL, nowhere) == 1,
          "nothing is not lit");
    const mssm_moments6 m = mssm_map_moments(map, 0, 0, 1, 1),
                        n = mssm_map_moments(NULL, 0, 0, 1, 1);
    for (int k = 0; k < 6; k++) {
        CHECK(fabsf(m.b[k] - powf(-0.9f, (float)(k + 1))) < 1e-5f, "moment %d is %g", k + 1,
              (double)m.b[k]);
        CHECK(n.b[k] == 1, "moment %d without a map is %g", k + 1, (double)n.b[k]);
    }
    free(memory);
}

static void depth_outside_counts_as_the_nearest_inside(void)
{
    enum { side = 5 };
    static const float wild[4] = {-3, 7, -1.0001f, 2}, tame[4] = {-1, 1, -1, 1};
    float a[side * side], b[side * side];
    const size_t bytes = mssm_map_bytes(side, 6);
    void *memory[2] = {malloc(bytes), malloc(bytes)};
    mssm_map *map[2];
    for (int i = 0; i < side * side; i++) {
        a[i] = wild[i % 4];
        b[i] = tame[i % 4];
    }
    for (int i = 0; i < 2; i++)
        CHECK(memory[i] && !mssm_map_init(&map[i], memory[i], bytes, side, 6) &&
                  !mssm_map_update(map[i], i ? b : a, i ? b : a, 1),
              "no map");
    for (int i = 0; i < side * side; i++) {
        const float x = -1 + (2 * (float)(i % side) + 1) / side,
                    y = -1 + (2 * (float)(i / side) + 1) / side;
        const mssm_moments6 m = mssm_map_moments(map[0], x, y, 0, 0),
                            n = mssm_map_moments(map[1], x, y, 0, 0);
        CHECK(!memcmp(&m, &n, sizeof m) && fabsf(m.b[0] - tame[i % 4]) < 1e-5f, "texel %d: %g", i,
              (double)m.b[0]);
    }
    for (int i = 0; i < 2; i++) free(memory[i]);
}

// Levels of odd sizes: texels that stick out are the mean of what there is.
static void odd_levels_hold_what_there_is(void)
{
    static const struct {
        int side;
        float low_x, low_y, width; // of the query, in texels
    } cases[] = {{57, 17, 0, 40}, {57, 17, 17, 40}, {57, 4, 6, 40}, {29, 0, 0, 29}, {58, 0, 0, 58}};
    static float depth[58 * 58];
    for (int i = 0; i < 58 * 58; i++) depth[i] = -1;
    for (int i = 0; i < 5; i++) {
        for (int moments = 4; moments <= 6; moments += 2) {
            const size_t bytes = mssm_map_bytes(cases[i].side, moments);
            void *memory = malloc(bytes);
            mssm_map *map;
            CHECK(memory && !mssm_map_init(&map, memory, bytes, cases[i].side, moments) &&
                      !mssm_map_update(map, depth, NULL, 1),
                  "no map");
            const float unit = 2 / (float)cases[i].side, half = 0.5f * cases[i].width;
            const mssm_moments6 m =
                mssm_map_moments(map, (cases[i].low_x + half) * unit - 1,
                                 (cases[i].low_y + half) * unit - 1, half * unit, half * unit);
            CHECK(fabs((double)m.b[0] - -1.0) < 1e-5, "case %d, %d moments: %.9g, not %.9g", i,
                  moments, (double)m.b[0], -1.0);
            CHECK(fabs((double)m.b[1] - 1) < 1e-5 && fabs((double)m.b[3] - 1) < 1e-5,
                  "case %d: even moments", i);
            free(memory);
        }
    }
}

// A light without size under a wide bias: the bounds of one texel's stored moments are those of the
// same moments decoded and biased. Only there does the bias of the tables show in more than the
// last digits.
static void tables_are_biased_towards_the_encoded_vector(void)
{
    enum { side = 8 };
    float depth[side * side * 4];
    static const float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1}, up[3] = {0, 1, 0},
                       x[3] = {1, 0, 0};
    uint64_t seed = 41;
    double worst = 0;
    int proved = 0, before = 0;
    for (int trial = 0; trial < 2000; trial++) {
        const int moments = trial & 1 ? 6 : 4;
        const size_t bytes = mssm_map_bytes(side, moments);
        void *memory = malloc(bytes);
        mssm_map *map;
        mssm_light light;
        for (int i = 0; i < side * side * 4; i++) depth[i] = (float)test_range(&seed, -1, 0.8);
        CHECK(memory && !mssm_map_init(&map, memory, bytes, side, moments) &&
                  !mssm_map_update(map, depth, NULL, 4) &&
                  !mssm_light_directional(&light, up, x, 0, 0, low, high),
              "no map");
        mssm_settings s = {0, MSSM_LOWER_BLOCKER, 0, 1e-7f, 0, 1e-9f};
        s.moments = moments;
        s.moment_bias = (float)pow(10, test_range(&seed, -3, -0.05));
        const float p[3] = {(float)test_range(&seed, -0.8, 0.8),
                            (float)test_range(&seed, -0.9, 0.9),
                            (float)test_range(&seed, -0.8, 0.8)};
        float at[3];
        CHECK(mssm_light_project(&light, p, at), "no projection");
        const mssm_moments6 six = mssm_map_moments(map, at[0], at[1], 0, 0);
        mssm_moments4 four;
        memcpy(four.b, six.b, sizeof four.b);
        const float want =
            moments == 6
                ? mssm_visibility6(mssm_moments6_bias_encoded(six, s.moment_bias), at[2]).upper
                : mssm_visibility4(mssm_moments4_bias_encoded(four, s.moment_bias), at[2]).upper;
        const float got = mssm_map_visibility(map, &light, &s, p);
        const int column = (int)(0.5f * side * (1 + at[0])), row = (int)(0.5f * side * (1 + at[1]));
        const float *own = depth + 4 * (row * side + column);
        // All in front of the receiver: dark, and proved.
        if (got == 0 && fmaxf(fmaxf(own[0], own[1]), fmaxf(own[2], own[3])) < at[2]) proved++;
        const double off = proved > before ? 0 : fabs((double)got - (double)want);
        before = proved;
        worst = off > worst ? off : worst;
        CHECK(off < 2e-3, "trial %d, bias %g: off by %g", trial, (double)s.moment_bias, off);
        free(memory);
    }
    test_note("to %.1e; %d are proved dark", worst, proved);
    CHECK(proved < 200, "%d", proved);
}

static void casters_beyond_the_box_cast_shadows(void)
{
    enum { side = 32 };
    static float depth[side * side];
    static const float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1}, up[3] = {0, 1, 0},
                       x[3] = {1, 0, 0};
    const size_t bytes = mssm_map_bytes(side, 6);
    void *memory = malloc(bytes);
    mssm_map *map;
    mssm_light light;
    for (int i = 0; i < side * side; i++)
        depth[i] = 0.87f; // past all casters that the light knows of
    CHECK(memory && !mssm_map_init(&map, memory, bytes, side, 6) &&
              !mssm_map_update(map, depth, NULL, 1) &&
              !mssm_light_directional(&light, up, x, 0.1f, 0.1f, low, high),
          "no map");
    for (float y = -1.5f; y > -4; y -= 0.25f) {
        const float below[3] = {0, y, 0};
        const float v = mssm_map_visibility(map, &light, NULL, below);
        CHECK(v < 0.02f, "visibility %g at %g", (double)v, (double)y);
    }
    free(memory);
}

// Depths spread before the receiver fill all but the rim of the widest kernel, and next to no bias
// lets the rest escape: shares of blockers add up to 1 and, rounded, to more.
static void visibility_stays_in_range_behind_full_kernels(void)
{
    enum { side = 64 };
    static float depth[side * side];
    static const float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1}, up[3] = {0, 1, 0},
                       x[3] = {1, 0, 0};
    const size_t bytes = mssm_map_bytes(side, 6);
    void *memory = malloc(bytes);
    mssm_map *map;
    uint64_t seed = 31;
    for (int trial = 0; memory && trial < 40; trial++) {
        const double hole = test_range(&seed, 8, 30), spread = test_range(&seed, 0.2, 0.9);
        for (int i = 0; i < side * side; i++) {
            const double r = hypot(i % side - side / 2, i / side - side / 2);
            depth[i] = r < hole ? (float)test_range(&seed, -1, -1 + spread) : 1.0f;
        }
        mssm_light light;
        const float tangent = (float)test_range(&seed, 0.05, 1);
        CHECK(!mssm_light_directional(&light, up, x, tangent, tangent, low, high) &&
                  !mssm_map_init(&map, memory, bytes, side, 6) &&
                  !mssm_map_update(map, depth, NULL, 1),
              "no map");
        for (int i = 0; i < 50; i++) {
            const float p[3] = {(float)test_range(&seed, -0.3, 0.3),
                                (float)test_range(&seed, -1.5, 0),
                                (float)test_range(&seed, -0.3, 0.3)};
            mssm_settings s = {0, MSSM_LAYERED, 0, 0, 0, 0};
            s.moments = i % 2 ? 6 : 0;
            s.tolerance = i % 3 ? 0 : 1e-9f;
            s.moment_bias = i % 5 ? 1e-12f : 0;
            const float v = mssm_map_visibility(map, &light, &s, p);
            CHECK(v >= 0 && v <= 1, "trial %d, point %d: visibility %a", trial, i, (double)v);
        }
    }
    free(memory);
}

static void texts_say_what_they_should(void)
{
    for (int a = -1; a < 8; a++) {
        const char *text = mssm_result_string((mssm_result)a);
        for (int b = -1; b < a; b++) {
            const int both_unknown = b == -1 && a > MSSM_ERROR_ORDER;
            CHECK(both_unknown || a == 7 || strcmp(text, mssm_result_string((mssm_result)b)),
                  "results %d and %d are both \"%s\"", a, b, text);
        }
    }
    for (int a = -1; a <= LIGHTPROBE_ERROR_ORDER; a++) {
        for (int b = -1; b < a; b++) {
            CHECK(strcmp(lightprobe_result_string((lightprobe_result)a),
                         lightprobe_result_string((lightprobe_result)b)),
                  "results %d and %d have the same text", a, b);
        }
    }
    CHECK(strstr(mssm_glsl_math(), "mssm_bounds mssm_visibility6(mssm_moments6 m, float z)\n{"),
          "moment math without visibility");
    CHECK(strstr(mssm_glsl_shading(), "float mssm_layered(MSSM_MAP map, ") ||
              strstr(mssm_glsl_shading(), "mssm_estimate("),
          "shading without estimator");
    CHECK(strstr(lightprobe_glsl_math(),
                 "float lightprobe_disc_irradiance(float cos_alpha, float cos_theta)\n{"),
          "probe math without disc irradiance");
}

// ---- lightprobe.h ----

static void probe_functions_clamp_their_arguments(void)
{
    static const int faces[][2] = {{-1, 0}, {INT_MIN, 0}, {6, 5}, {INT_MAX, 5}};
    for (int i = 0; i < 4; i++) {
        float a[3], b[3];
        lightprobe_texel_direction(faces[i][0], 0.3f, -0.7f, a);
        lightprobe_texel_direction(faces[i][1], 0.3f, -0.7f, b);
        CHECK(!memcmp(a, b, sizeof a), "face %d is not %d", faces[i][0], faces[i][1]);
    }
    for (int i = 0; i < 3 * 4; i++) { // beyond -1 and 1 both cosines count as these
        static const float wide[4] = {-1.5f, -FLT_MAX, 1.5f, FLT_MAX}, n[3] = {-0.5f, 0.1f, 0.7f};
        const float end = i % 4 < 2 ? -1.0f : 1.0f, at = n[i / 4];
        CHECK(lightprobe_disc_irradiance(wide[i % 4], at) == lightprobe_disc_irradiance(end, at) &&
                  lightprobe_disc_irradiance(at, wide[i % 4]) ==
                      lightprobe_disc_irradiance(at, end),
              "a cosine of %g", (double)wide[i % 4]);
    }
    static const int outside[][3] = {{0, 0, 0},  {-4, 0, 0}, {4, -1, 0},
                                     {4, 0, -1}, {4, 4, 0},  {4, 0, 4}};
    for (int i = 0; i < 6; i++)
        CHECK(lightprobe_texel_solid_angle(outside[i][0], outside[i][1], outside[i][2]) == 0,
              "case %d has a solid angle", i);
    CHECK(lightprobe_texel_solid_angle(4, 3, 3) > 0, "the last texel has none");
    static const int refused[][2] = {
        {8, -1}, {8, LIGHTPROBE_MAX_LIGHTS + 1}, {0, 8}, {LIGHTPROBE_MAX_SIDE + 1, 8}};
    for (int i = 0; i < 4; i++)
        CHECK(!lightprobe_scratch_bytes(refused[i][0], refused[i][1]), "case %d has scratch bytes",
              i);
    CHECK(lightprobe_scratch_bytes(LIGHTPROBE_MAX_SIDE, LIGHTPROBE_MAX_LIGHTS) > 0,
          "the largest fits");
    CHECK(lightprobe_scratch_bytes(8, 0) == lightprobe_scratch_bytes(8, LIGHTPROBE_DEFAULT_LIGHTS),
          "0 lights are not the default");
}

// A disc that all but sinks below the horizon gives next to nothing, however the terms round.
static void sinking_discs_give_nothing(void)
{
    uint64_t seed = 51;
    for (int i = 0; i < 200000; i++) {
        const double alpha = pow(10, test_range(&seed, -3, 0)),
                     left = pow(10, test_range(&seed, -7, -3));
        const float e =
            lightprobe_disc_irradiance((float)cos(alpha), (float)-sin(alpha - left * alpha));
        CHECK(e >= 0 && e < 1e-3f, "%g of a disc of %g, %g of it seen", (double)e, alpha, left);
    }
}

// Extracts with exactly the scratch memory asked for.
static lightprobe_result extract(const lightprobe_cube *cube, const lightprobe_settings *s,
                                 lightprobe_light *lights, int *count, lightprobe_stats *stats)
{
    const size_t bytes = lightprobe_scratch_bytes(cube->side, s->max_lights);
    void *scratch = malloc(bytes ? bytes : 1);
    if (!scratch) abort();
    const lightprobe_result r = lightprobe_extract(cube, s, scratch, bytes, lights, count, stats);
    free(scratch);
    return r;
}

static void settings_have_the_defaults_and_ends_they_say(void)
{
    test_probe p = test_scene_probe(SCENE_LAMPS, 32);
    const lightprobe_cube cube = test_probe_cube(&p);
    static lightprobe_light a[64], b[64];
    lightprobe_stats sa, sb;
    lightprobe_settings s = {0}, t;
    int ca = 0, cb = 0;
    // 0 lights with a tolerance of its own: up to 32, at that tolerance.
    t = s;
    s.tolerance = t.tolerance = 0.1f;
    t.max_lights = LIGHTPROBE_DEFAULT_LIGHTS;
    CHECK(!extract(&cube, &s, a, &ca, &sa) && !extract(&cube, &t, b, &cb, &sb) && ca == cb &&
              ca < 32 && sa.error <= 0.1f && !memcmp(a, b, sizeof *a * (size_t)ca),
          "%d lights, error %g; %d lights", ca, (double)sa.error, cb);
    // Beyond 1 there is nothing to tolerate or to leave out.
    s.tolerance = 1e30f;
    CHECK(!extract(&cube, &s, a, &ca, &sa) && ca == 1, "%d lights at tolerance 1e30", ca);
    for (int mode = 0; mode < 2; mode++) {
        memset(&s, 0, sizeof s);
        s.max_lights = 64;
        s.mode = mode;
        s.min_share = 1e30f;
        CHECK(!extract(&cube, &s, a, &ca, &sa) && ca == 0 && sa.residual[0] == sa.total[0],
              "mode %d: %d lights with a share of all", mode, ca);
        s.min_share = 0.02f;
        CHECK(!extract(&cube, &s, a, &ca, &sa) && ca > 0 && ca < 64, "mode %d: %d lights of 2%%",
              mode, ca);
        const float coefficient[3] = {0.2126f, 0.7152f, 0.0722f};
        double whole = 0, left = 0;
        for (int c = 0; c < 3; c++) {
            whole += (double)(coefficient[c] * sa.total[c]);
            left += (double)(coefficient[c] * sa.residual[c]);
        }
        for (int i = 0; i < ca; i++) {
            double y = 0;
            for (int c = 0; c < 3; c++) y += (double)(coefficient[c] * a[i].irradiance[c]);
            CHECK(y >= 0.01999 * whole, "mode %d: a light has %g of all", mode, y / whole);
        }
        CHECK(left > 0.1 * whole, "mode %d: the residual has %g of all", mode, left / whole);
    }
    memset(&s, 0, sizeof s);
    s.previous_count = LIGHTPROBE_MAX_LIGHTS + 1;
    ca = -7;
    CHECK(extract(&cube, &s, a, &ca, NULL) == LIGHTPROBE_ERROR_LIGHTS && ca == -7,
          "too many previous lights");
    test_probe_free(&p);
}

// Tiles of 4 x 4 texels and squares of tiles, cut by the border in every way.
static void energy_is_conserved_at_every_side(void)
{
    static lightprobe_light lights[16];
    for (int side = 1; side <= 99;
         side += side < 48 ? 1 : 17) { // 65, 82, 99: tables by another way
        test_probe p = test_scene_probe(SCENE_NOISE, side);
        const lightprobe_cube cube = test_probe_cube(&p);
        lightprobe_settings s = {0};
        s.max_lights = 16;
        lightprobe_stats stats;
        int count = 0;
        double total[3], omega = 0;
        oracle_total(&p, total);
        CHECK(!extract(&cube, &s, lights, &count, &stats), "side %d fails", side);
        for (int c = 0; c < 3; c++) {
            double sum = (double)stats.residual[c];
            for (int i = 0; i < count; i++) sum += (double)lights[i].irradiance[c];
            CHECK(fabs(sum / total[c] - 1) < 2e-6, "side %d: %.9g of the energy", side,
                  sum / total[c]);
        }
        for (int i = 0; i < count; i++) omega += (double)lights[i].solid_angle;
        CHECK(fabs(omega / 12.566370614 - 1) < 2e-6, "side %d: the lights fill %.9g of the sphere",
              side, omega / 12.566370614);
        test_probe_free(&p);
    }
}

// Lights of known probes, first afresh and then from those of a changed probe, as two sums each
// that every light's place, energy, direction and size goes into. Recorded with gcc 12 -O2: a
// change of these numbers is a change of the lights that people get.
static void lights_of_known_probes_are_as_recorded(void)
{
    static const double recorded[SCENE_COUNT][4] = {{1.129265, 1.962702, 1.124410, 1.969225},
                                                    {0.198449, 1.996089, 0.322816, 2.001262},
                                                    {-0.449091, 1.593627, -0.156728, 1.742691},
                                                    {0.338882, 2.023304, 0.471419, 2.154842},
                                                    {-2.008483, 2.015581, -1.805590, 2.023609}};
    static lightprobe_light lights[24];
    for (int scene = 0; scene < SCENE_COUNT; scene++) {
        test_probe p = test_scene_probe((test_scene)scene, 24);
        const lightprobe_cube cube = test_probe_cube(&p);
        int count = 0;
        for (int frame = 0; frame < 2; frame++) {
            lightprobe_settings s = {0};
            s.max_lights = 24;
            s.previous = lights;
            s.previous_count = count;
            lightprobe_stats stats;
            CHECK(!extract(&cube, &s, lights, &count, &stats), "%s fails", test_scene_names[scene]);
            double sum = 0, sizes = 0;
            for (int i = 0; i < count; i++) {
                const lightprobe_light *l = &lights[i];
                const double along = 0.3 * (double)l->direction[0] + 0.5 * (double)l->direction[1] +
                                     0.7 * (double)l->direction[2];
                sum += (i + 1) * along * (double)l->irradiance[1] / (double)stats.total[1];
                sizes += (double)(l->tan_half_u + 2 * l->tan_half_v + l->cos_alpha) / 24;
            }
            CHECK(fabs(sum - recorded[scene][2 * frame]) < 1e-3 &&
                      fabs(sizes - recorded[scene][2 * frame + 1]) < 1e-3,
                  "%s, frame %d: %.6f, %.6f", test_scene_names[scene], frame, sum, sizes);
            for (int i = 0; i < 3 * 24 * 8; i++) p.face[2][i] *= 3; // a third of the sky brightens
        }
        test_probe_free(&p);
    }
}

// Lights of the previous frame that never were in a probe, brighter than any, without extent, count as none.
static void foreign_previous_lights_do_no_harm(void)
{
    test_probe p = test_scene_probe(SCENE_WINDOW, 16);
    const lightprobe_cube cube = test_probe_cube(&p);
    lightprobe_light lights[6], previous[6];
    for (int i = 0; i < 6; i++) {
        memset(&previous[i], 0, sizeof previous[i]);
        previous[i].direction[i % 3] = i < 3 ? 2.0f : -3.0f;
        previous[i].solid_angle = i % 2 ? 1e-12f : -1;
        previous[i].irradiance[1] = i % 3 ? 1e30f : -1e30f;
        previous[i].id = 10 * i;
    }
    lightprobe_settings s = {0};
    s.max_lights = s.previous_count = 6;
    s.previous = previous;
    lightprobe_stats stats;
    int count = 0;
    CHECK(!extract(&cube, &s, lights, &count, &stats) && count >= 1, "%d lights", count);
    double sum = 0;
    for (int i = 0; i < count; i++) {
        const float *d = lights[i].direction;
        CHECK(fabsf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - 1) < 1e-5f,
              "light %d has no direction", i);
        sum += (double)lights[i].irradiance[1];
    }
    CHECK(fabs(sum / (double)stats.total[1] - 1) < 1e-6, "the lights carry %g of all",
          sum / (double)stats.total[1]);
    test_probe_free(&p);
}

// Texels 1e6 times as bright as the mean, far above what a tone tells apart, in the corners of
// large faces: so small that rounding can make their vector irradiance longer than their flux.
enum { HOT_SIDE = 1024, HOT = 6 };

static void check_hot_texel(const lightprobe_light *l, int count, int face, int texel, double value)
{
    const int x = texel % HOT_SIDE, y = texel / HOT_SIDE;
    int found = 0;
    double d[3];
    oracle_direction(face, -1 + (x + 0.5) * 2 / HOT_SIDE, -1 + (y + 0.5) * 2 / HOT_SIDE, d);
    for (; count > 0; count--, l++) {
        double off = 0;
        for (int c = 0; c < 3; c++) off += fabs((double)l->direction[c] - d[c]);
        if (off > 1e-5) continue;
        const double flux = value * (double)oracle_solid_angle(HOT_SIDE, x, y);
        CHECK(fabs((double)l->irradiance[1] / flux - 1) < 1e-5, "%g of %g",
              (double)l->irradiance[1], flux);
        CHECK(l->cos_alpha <= 1 && l->cos_alpha > 0.99999f && l->tan_half_u >= l->tan_half_v &&
                  l->tan_half_v >= 0 && l->tan_half_u < 2e-3f,
              "cos %.9g, %g x %g", (double)l->cos_alpha, (double)l->tan_half_u,
              (double)l->tan_half_v);
        found++;
    }
    CHECK(found == 1, "%d lights at %d, %d of face %d", found, x, y, face);
}

static void hot_texels_are_lights_of_their_size(void)
{
    static lightprobe_light lights[2048];
    float *face = calloc((size_t)HOT_SIDE * HOT_SIDE, 3 * sizeof(float));
    lightprobe_cube cube = {{0}, HOT_SIDE, 3};
    if (!face) abort();
    uint64_t seed = 71;
    for (int f = 0; f < 6; f++) cube.face[f] = face;
    for (int round = 0; round < 6; round++) {
        int at[HOT], count = 0;
        for (int i = 0; i < HOT; i++) {
            const int x = 30 + 50 * i + (int)test_range(&seed, 0, 9), y = 1000 - 100 * round + i;
            at[i] = y * HOT_SIDE + x;
            for (int c = 0; c < 3; c++) face[3 * at[i] + c] = (float)(1 + i);
        }
        lightprobe_settings set = {0};
        set.max_lights = 2048; // and with them the leaves
        lightprobe_stats stats;
        CHECK(!extract(&cube, &set, lights, &count, &stats) && count == 6 * HOT && stats.error >= 0,
              "round %d: %d lights", round, count);
        for (int i = 0; i < 6 * HOT; i++)
            check_hot_texel(lights, count, i / HOT, at[i % HOT], 1 + i % HOT);
        for (int i = 0; i < HOT; i++) memset(face + 3 * at[i], 0, 3 * sizeof(float));
    }
    free(face);
}

// A probe whose light moves from one half of the sky to another, and spreads: lights change hands,
// are given back and are cut from what is left.
static void lights_are_spent_again_where_they_are_needed(void)
{
    static lightprobe_light lights[24];
    uint64_t seed = 91;
    for (int trial = 0; trial < 6; trial++) {
        int count = 0;
        for (int frame = 0; frame < 12; frame++) {
            test_probe p = test_probe_new(16);
            const lightprobe_cube cube = test_probe_cube(&p);
            const int lamps = frame % 3 ? 12 : 2;
            for (int i = 0; i < lamps; i++) {
                float *texel = p.face[(int)test_range(&seed, 0, frame < 6 ? 2 : 6)] +
                               3 * (int)test_range(&seed, 0, 256);
                for (int c = 0; c < 3; c++) texel[c] = (float)pow(10, test_range(&seed, -2, 3));
            }
            lightprobe_settings s = {0};
            s.max_lights = 24;
            s.previous = lights;
            s.previous_count = count;
            s.tolerance = trial % 2 ? 0.05f : 0.0f;
            lightprobe_stats stats;
            CHECK(!extract(&cube, &s, lights, &count, &stats) && count >= 1 && count <= 24,
                  "%d lights", count);
            double sum = 0;
            for (int i = 0; i < count; i++) {
                sum += (double)lights[i].irradiance[0];
                for (int k = 0; k < i; k++)
                    CHECK(lights[i].id != lights[k].id, "id %d twice", lights[i].id);
            }
            CHECK(fabs(sum / (double)stats.total[0] - 1) < 1e-6, "trial %d, frame %d: %g of all",
                  trial, frame, sum / (double)stats.total[0]);
            test_probe_free(&p);
        }
    }
}

// One texel of a corner, with a distance, in the dark: brighter than any tone tells, and without slopes.
static void a_lone_texel_is_a_light_at_its_place(void)
{
    enum { N = 512 };
    lightprobe_light light[4];
    lightprobe_cube cube = {{0}, N, 4};
    lightprobe_settings set = {0};
    int count = 0;
    float *face = calloc((size_t)2 * N * N, 4 * sizeof(float));
    if (!face) abort();
    for (int f = 0; f < 6; f++) cube.face[f] = face + (f ? (size_t)4 * N * N : 0);
    for (int c = 0; c < 4; c++) face[c] = 3;
    set.max_lights = 4;
    set.distances = 1;
    CHECK(!extract(&cube, &set, light, &count, NULL) && count == 1, "%d lights", count);
    const double flux = 3 * (double)lightprobe_texel_solid_angle(N, 0, 0);
    for (int c = 0; c < 3; c++)
        CHECK(fabs((double)light->irradiance[c] / flux - 1) < 1e-4, "flux %g, not %g",
              (double)light->irradiance[c], flux);
    CHECK(fabsf(light->distance - 3) < 1e-4f, "at %g, not 3", (double)light->distance);
    CHECK(light->slope_u == 0 && light->slope_v == 0, "slopes of a texel");
    free(face);
}

const test_case edges_tests[] = {
    {"edges: each bad argument of a light alone is refused", each_bad_argument_alone_is_refused},
    {"edges: frusta beyond the range of float are refused",
     frusta_beyond_the_range_of_float_are_refused},
    {"edges: any axis gives an orthonormal frame", any_axis_gives_an_orthonormal_frame},
    {"edges: points without a shadow position are refused",
     points_without_a_shadow_position_are_refused},
    {"edges: nothing given is lit", nothing_given_is_lit},
    {"edges: stored moments are clamped", stored_moments_are_clamped},
    {"edges: only rounding makes double roots", only_rounding_makes_double_roots},
    {"edges: depth outside counts as the nearest inside",
     depth_outside_counts_as_the_nearest_inside},
    {"edges: odd levels hold what there is", odd_levels_hold_what_there_is},
    {"edges: tables are biased towards the encoded vector",
     tables_are_biased_towards_the_encoded_vector},
    {"edges: casters beyond the box cast shadows", casters_beyond_the_box_cast_shadows},
    {"edges: visibility stays in range behind full kernels",
     visibility_stays_in_range_behind_full_kernels},
    {"edges: texts say what they should", texts_say_what_they_should},
    {"edges: probe functions clamp their arguments", probe_functions_clamp_their_arguments},
    {"edges: settings have the defaults and ends they say",
     settings_have_the_defaults_and_ends_they_say},
    {"edges: sinking discs give nothing", sinking_discs_give_nothing},
    {"edges: energy is conserved at every side", energy_is_conserved_at_every_side},
    {"edges: lights of known probes are as recorded", lights_of_known_probes_are_as_recorded},
    {"edges: foreign previous lights do no harm", foreign_previous_lights_do_no_harm},
    {"edges: hot texels are lights of their size", hot_texels_are_lights_of_their_size},
    {"edges: a lone texel is a light at its place", a_lone_texel_is_a_light_at_its_place},
    {"edges: lights are spent again where they are needed",
     lights_are_spent_again_where_they_are_needed},
    {NULL, NULL},
};
