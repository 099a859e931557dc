// Filtered hard shadows and translucent casters on the CPU, against sums over the samples of the
// depth map in double precision and against stacks of layers whose transmittance is a product.
#include "../../mssm.h"
#include "../support/scenes.h"
#include "../support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 64, SAMPLES = 4 };

static void *allocate(size_t bytes)
{
    void *memory = malloc(bytes);
    if (!memory) abort();
    return memory;
}

static mssm_filtered *make_filtered(void **memory, int side, int moments)
{
    const size_t bytes = mssm_filtered_bytes(side, moments);
    mssm_filtered *map = NULL;
    *memory = allocate(bytes);
    CHECK(!mssm_filtered_init(&map, *memory, bytes, side, moments), "init");
    return map;
}

static int held(int i, int side)
{
    return i < 0 ? 0 : i >= side ? side - 1 : i;
}

// Sum over all samples under the Gaussian round texel (x,y): of z^power, or for power 0 of z <
// limit.
static double gaussian_sum(const float *depth, int x, int y, int radius, int power, double limit)
{
    double sum = 0, weights = 0;
    for (int j = -radius; j <= radius; j++) {
        for (int i = -radius; i <= radius; i++) {
            const double d = radius ? 2.0 / radius : 0, w = exp(-0.5 * d * d * (i * i + j * j));
            const int u = held(x + i, SIDE), v = held(y + j, SIDE);
            weights += w;
            for (int s = 0; s < SAMPLES; s++) {
                const double z = depth[(v * SIDE + u) * SAMPLES + s];
                sum += w / SAMPLES * (power ? pow(z, power) : z < limit);
            }
        }
    }
    return sum / weights;
}

static float centre_of(int texel)
{
    return (2.0f * (float)texel + 1) / SIDE - 1;
}

static void one_look_gives_the_gaussian(void)
{
    static float depth[SIDE * SIDE * SAMPLES];
    uint64_t seed = 61;
    double worst = 0;
    for (int i = 0; i < SIDE * SIDE * SAMPLES; i++) depth[i] = (float)test_range(&seed, -1, 1);
    for (int moments = 4; moments <= 6; moments += 2) {
        void *memory;
        mssm_filtered *map = make_filtered(&memory, SIDE, moments);
        for (int radius = 0; radius <= 7; radius += 7) {
            CHECK(!mssm_filtered_update(map, depth, SAMPLES, radius), "update");
            for (int t = 0; t < 60; t++) {
                const int x = (int)test_range(&seed, 0, SIDE), y = (int)test_range(&seed, 0, SIDE);
                const mssm_moments6 m = mssm_filtered_moments(map, centre_of(x), centre_of(y), 0);
                for (int k = 0; k < moments; k++) {
                    const double b = gaussian_sum(depth, x, y, radius, k + 1, 0);
                    worst = fmax(worst, fabs(m.b[k] - b));
                }
            }
        }
        free(memory);
    }
    // 16 bits: half a step, times at most 3.75 (the row of b5), and float sums.
    CHECK(worst < 3.75 * 0.5 / 65535 + 2e-6, "worst error %g", worst);
    test_note("worst error of a moment %.2g", worst);
}

static void wide_looks_average(void)
{
    static float depth[SIDE * SIDE * SAMPLES];
    uint64_t seed = 62;
    double mean[6] = {0}, worst = 0;
    void *memory;
    mssm_filtered *map = make_filtered(&memory, SIDE, 6);
    for (int i = 0; i < SIDE * SIDE * SAMPLES; i++) depth[i] = (float)test_range(&seed, -1, 1);
    CHECK(!mssm_filtered_update(map, depth, SAMPLES, 0), "update");
    // The level of 16 texels a side, at the middle of one of its texels; then half-way to the next.
    for (int level = 2; level <= 3; level++) {
        const int width = 1 << level, x0 = 3 * width, y0 = 2 * width;
        memset(mean, 0, sizeof mean);
        for (int i = 0; i < width * width * SAMPLES; i++) {
            const int x = x0 + i / SAMPLES % width, y = y0 + i / SAMPLES / width;
            const double z = depth[(y * SIDE + x) * SAMPLES + i % SAMPLES];
            for (int k = 0; k < 6; k++) mean[k] += pow(z, k + 1) / (width * width * SAMPLES);
        }
        const mssm_moments6 m =
            mssm_filtered_moments(map, (float)(2 * x0 + width) / SIDE - 1,
                                  (float)(2 * y0 + width) / SIDE - 1, 2.0f * (float)width / SIDE);
        for (int k = 0; k < 6; k++) worst = fmax(worst, fabs(m.b[k] - mean[k]));
    }
    CHECK(worst < 3.75 * 0.5 / 65535 + 2e-6, "worst error %g: levels are rounded once", worst);
    // Between two levels: between their answers.
    const mssm_moments6 a = mssm_filtered_moments(map, 0.1f, 0.2f, 8.0f / SIDE),
                        b = mssm_filtered_moments(map, 0.1f, 0.2f, 16.0f / SIDE),
                        c = mssm_filtered_moments(map, 0.1f, 0.2f, 8 * sqrtf(2) / SIDE);
    for (int k = 0; k < 6; k++) {
        CHECK(fabs(0.5 * (a.b[k] + b.b[k]) - c.b[k]) < 1e-5, "moment %d is not half-way", k + 1);
    }
    for (int i = 0; i < 2; i++) {
        const mssm_moments6 out = mssm_filtered_moments(map, i ? 0 : 3, i ? -1.01f : 0, 0.5f);
        for (int k = 0; k < 6; k++) CHECK(out.b[k] == 1, "outside is empty");
    }
    free(memory);
}

// Moments 1 to 4 of a map of any side after the blur, all of it in double precision; rows go along
// the other axis on each call, so that two calls blur both.
static void blur_rows(const double *from, double *to, int side, int radius)
{
    for (int i = 0; i < side * side * 4; i++) {
        const int x = i / 4 % side, y = i / 4 / side;
        double sum = 0, weights = 0;
        for (int t = -radius; t <= radius; t++) {
            const double d = radius ? 2.0 / radius : 0, w = exp(-0.5 * d * d * t * t);
            sum += w * from[i + 4 * (held(x + t, side) - x)];
            weights += w;
        }
        to[4 * (x * side + y) + i % 4] = sum / weights;
    }
}

static void halve(const double *from, double *to, int side)
{
    const int half = (side + 1) / 2;
    for (int i = 0; i < half * half * 4; i++) {
        double sum = 0;
        int count = 0;
        for (int j = 0; j < 4; j++) {
            const int x = i / 4 % half * 2 + j % 2, y = i / 4 / half * 2 + j / 2;
            if (x >= side || y >= side) continue;
            sum += from[4 * (y * side + x) + i % 4];
            count++;
        }
        to[i] = sum / count;
    }
}

// Maps narrower than the Gaussian, odd levels, edges: beyond the map its outermost texels go on.
static void odd_maps_go_on_beyond_their_edges(void)
{
    enum { MOST = 67 };
    static const int sides[6] = {1, 2, 7, 17, 33, MOST}, radii[3] = {0, 3, 32};
    static double table[2][MOST * MOST * 4];
    static float depth[MOST * MOST];
    uint64_t seed = 64;
    double worst = 0;
    for (int which = 0; which < 6 * 3 * 2; which++) {
        const int side = sides[which / 6], radius = radii[which % 3];
        void *memory;
        mssm_filtered *map = make_filtered(&memory, side, which / 3 % 2 ? 6 : 4);
        for (int i = 0; i < side * side * 4; i++) {
            if (i % 4 == 0) depth[i / 4] = (float)test_range(&seed, -1, 1);
            table[0][i] = pow((double)depth[i / 4], i % 4 + 1);
        }
        CHECK(!mssm_filtered_update(map, depth, 1, radius), "update");
        blur_rows(table[0], table[1], side, radius);
        blur_rows(table[1], table[0], side, radius);
        for (int size = side, width = 1, level = 0;; size = (size + 1) / 2, width *= 2, level++) {
            const double *t = table[level % 2];
            for (int i = 0; i < size * size; i++) {
                const float x = (float)((2 * (i % size) + 1) * width) / (float)side - 1,
                            y = (float)((2 * (i / size) + 1) * width) / (float)side - 1;
                const mssm_moments6 m =
                    mssm_filtered_moments(map, x, y, 2 * (float)width / (float)side);
                for (int k = 0; k < 4; k++) worst = fmax(worst, fabs(m.b[k] - t[4 * i + k]));
            }
            if (size <= 27) break; // the last level
            halve(t, table[(level + 1) % 2], size);
        }
        free(memory);
    }
    CHECK(worst < 3.75 * 0.5 / 65535 + 3e-6, "worst error %g", worst);
}

// A wall closes all of a lamp's cone: behind it all is dark up to the rim, beside the map all is
// lit.
static void no_light_from_beyond_the_rim(void)
{
    static const int sides[5] = {64, 61, 33, 27, 1}, radii[4] = {0, 2, 8, 32};
    static const float parts[5] = {0.5f, 0.9f, 0.99f, 0.9999f, 1.0001f}, widths[3] = {0, 0.3f, 6};
    static float depth[SIDE * SIDE];
    const float lamp[3] = {0, 0, 8}, up[3] = {0, 0, 1}, axis[3] = {1, 0, 0};
    mssm_light light;
    CHECK(!mssm_light_spot(&light, lamp, up, axis, 0.57735f, 0.5f, 12, 0, 0), "light");
    for (int i = 0; i < SIDE * SIDE; i++) depth[i] = -1 + 2 * (2 - 0.5f) / 11.5f;
    for (int which = 0; which < 5 * 4 * 2; which++) {
        void *memory;
        mssm_filtered *map = make_filtered(&memory, sides[which / 8], which % 2 ? 6 : 4);
        CHECK(!mssm_filtered_update(map, depth, 1, radii[which / 2 % 4]), "update");
        for (int i = 0; i < 5 * 3 * 8; i++) {
            const float part = parts[i % 5], far = 8 * 0.57735f * part, near = i / 60 ? far : 0.3f;
            const float sign = i / 30 % 2 ? -1.0f : 1.0f, u = sign * far, v = sign * near;
            const float p[3] = {i / 15 % 2 ? v : u, i / 15 % 2 ? u : v, 0};
            const float seen = mssm_filtered_visibility(map, &light, NULL, p, widths[i / 5 % 3]);
            if (part > 1)
                CHECK(seen == 1, "beside the map: %g", (double)seen);
            else
                CHECK(seen <= 0.001f, "%d texels, radius %d, %g of the cone, width %g: light %g",
                      sides[which / 8], radii[which / 2 % 4], (double)part,
                      (double)widths[i / 5 % 3], (double)seen);
        }
        free(memory);
    }
}

// The bound never darkens: it is at least what percentage-closer filtering with the same kernel
// says.
static void never_darker_than_percentage_closer(void)
{
    static float depth[SIDE * SIDE * SAMPLES];
    uint64_t seed = 63;
    const mssm_filter plain = {0, 1e-4f, 1};
    for (int moments = 4; moments <= 6; moments += 2) {
        double darker = 0, error = 0, leak = 0;
        int count = 0;
        void *memory;
        mssm_filtered *map = make_filtered(&memory, SIDE, moments);
        for (int which = 0; which < SCENE_COUNT; which++) {
            scene s;
            mssm_light light;
            scene_make(&s, which);
            CHECK(!scene_light(&s, 0, 0, &light), "light");
            scene_depth(&s, &light, SIDE, SAMPLES, depth, NULL);
            CHECK(!mssm_filtered_update(map, depth, SAMPLES, 4), "update");
            const float *m = light.world_to_shadow;
            for (int t = 0; t < test_trials(400); t++) {
                const int x = (int)test_range(&seed, 0, SIDE), y = (int)test_range(&seed, 0, SIDE);
                const double z = test_range(&seed, -1, 0.85);
                // Back to the world: rows of the matrix are orthogonal.
                float point[3];
                const double at[3] = {centre_of(x), centre_of(y), z};
                for (int k = 0; k < 3; k++) {
                    double p = 0;
                    for (int r = 0; r < 3; r++) {
                        const double l = (double)m[r] * m[r] + (double)m[4 + r] * m[4 + r] +
                                         (double)m[8 + r] * m[8 + r];
                        p += m[4 * k + r] * (at[r] - m[12 + r]) / l;
                    }
                    point[k] = (float)p;
                }
                const double seen = mssm_filtered_visibility(map, &light, &plain, point, 0);
                const double pcf = 1 - gaussian_sum(depth, x, y, 4, 0, z - 1e-4);
                darker = fmax(darker, pcf - seen);
                error += (seen - pcf) * (seen - pcf);
                leak = fmax(leak, seen - pcf);
                count++;
            }
        }
        free(memory);
        // Shadow that is not there: no more than the bias that 16 bits ask for.
        CHECK(darker < 2e-3, "%d moments: darker than all samples by %g", moments, darker);
        test_note("%d moments: rms %.3f against percentage-closer filtering, at most %.3f lighter",
                  moments, sqrt(error / count), leak);
    }
}

static void surfaces_are_lit_and_walls_are_dark(void)
{
    static float depth[SIDE * SIDE];
    const float to_light[3] = {0, 0, 1}, axis[3] = {1, 0, 0}, low[3] = {-1, -1, -1},
                high[3] = {1, 1, 1};
    mssm_light light;
    void *memory;
    CHECK(!mssm_light_directional(&light, to_light, axis, 0, 0, low, high), "light");
    for (int moments = 4; moments <= 6; moments += 2) {
        mssm_filtered *map = make_filtered(&memory, SIDE, moments);
        for (int tilted = 0; tilted < 2; tilted++) {
            float darkest = 1, lightest = 0;
            for (int i = 0; i < SIDE * SIDE; i++) {
                const float x = (float)(i % SIDE * 2 + 1) / SIDE - 1;
                const float p[3] = {x * light.extent_u, 0, tilted ? -0.7f * x * light.extent_u : 0};
                float shadow[3];
                CHECK(mssm_light_project(&light, p, shadow), "project");
                depth[i] = shadow[2];
            }
            CHECK(!mssm_filtered_update(map, depth, 1, 4), "update");
            for (int i = -30; i <= 30; i++) {
                const float x = 0.015f * (float)i;
                const float on[3] = {x, 0, tilted ? -0.7f * x : 0},
                            behind[3] = {x, 0, on[2] - 0.5f};
                darkest = fminf(darkest, mssm_filtered_visibility(map, &light, NULL, on, 0.05f));
                lightest = fmaxf(lightest, mssm_filtered_visibility(map, &light, NULL, behind, 0));
            }
            CHECK(darkest > 0.97f, "tilted %d, %d moments: a lit surface at %g", tilted, moments,
                  darkest);
            CHECK(lightest == 0, "tilted %d, %d moments: %g behind a wall", tilted, moments,
                  lightest);
        }
        free(memory);
    }
}

// Depths along x of a light that shines down the z axis: a plane that falls by slope, and a step of
// a texel's height at x = 0, whose right half is the lower one, or the only one (open).
static void fill_profile(float *depth, const mssm_light *light, float slope, float step, int open)
{
    for (int i = 0; i < SIDE * SIDE; i++) {
        const float x = centre_of(i % SIDE) * light->extent_u;
        const float p[3] = {x, 0, x < 0 ? step - slope * x : -slope * x};
        float shadow[3];
        CHECK(mssm_light_project(light, p, shadow), "project");
        depth[i] = x < 0 && open ? 1 : shadow[2];
    }
}

// The depth bias knows steep surfaces from level ones, and their edges, by what lies beyond them.
static void bias_is_for_steep_surfaces_and_edges(void)
{
    static float depth[SIDE * SIDE];
    const float to_light[3] = {0, 0, 1}, axis[3] = {1, 0, 0}, low[3] = {-1, -1, -1},
                high[3] = {1, 1, 1};
    mssm_light light;
    CHECK(!mssm_light_directional(&light, to_light, axis, 0, 0, low, high), "light");
    const float texel = 2 * light.extent_u / SIDE;
    for (int moments = 4; moments <= 6; moments += 2) {
        void *memory;
        mssm_filtered *map = make_filtered(&memory, SIDE, moments);
        for (int radius = 1; radius <= 8; radius *= 2) {
            float plane = 1, edge = 1, covered = 0;
            fill_profile(depth, &light, 1.5f, 0, 0);
            CHECK(!mssm_filtered_update(map, depth, 1, radius), "update");
            for (int i = -25; i <= 25; i++) {
                const float p[3] = {0.4f * texel * (float)i, 0, -0.6f * texel * (float)i};
                plane = fminf(plane, mssm_filtered_visibility(map, &light, NULL, p, 0));
            }
            fill_profile(depth, &light, 3, 0, 1); // falls away from its upper edge
            CHECK(!mssm_filtered_update(map, depth, 1, radius), "update");
            for (int i = 0; i <= radius; i++) {
                const float p[3] = {0.4f * texel * (float)i, 0, -1.2f * texel * (float)i};
                edge = fminf(edge, mssm_filtered_visibility(map, &light, NULL, p, 0));
            }
            fill_profile(depth, &light, 0, texel, 0);
            CHECK(!mssm_filtered_update(map, depth, 1, radius), "update");
            for (int i = 0; i < 15; i++) {
                const float p[3] = {-((float)radius + 1.5f + 0.4f * (float)i) * texel, 0, 0};
                covered = fmaxf(covered, mssm_filtered_visibility(map, &light, NULL, p, 0));
            }
            test_note("%d moments, radius %d: plane %.3f, edge %.3f, one texel under a step %.3f",
                      moments, radius, plane, edge, covered);
            CHECK(plane > 0.99f, "%d moments, radius %d: a steep plane at %g", moments, radius,
                  plane);
            CHECK(edge > 0.99f, "%d moments, radius %d: an edge at %g", moments, radius, edge);
            CHECK(covered < 0.08f, "%d moments, radius %d: %g one texel under a caster", moments,
                  radius, covered);
        }
        free(memory);
    }
}

// A lamp three units above a floor, a square sheet one unit below it.
static void a_lamp_throws_the_outline_of_a_sheet(void)
{
    static float depth[SIDE * SIDE];
    const float lamp[3] = {0, 0, 3}, up[3] = {0, 0, 1}, axis[3] = {1, 0, 0};
    const float before[3] = {0, 0, 2.6f};
    const double half = 0.2, tangent = 0.6;
    mssm_light light;
    void *memory;
    CHECK(!mssm_light_spot(&light, lamp, up, axis, (float)tangent, 0.5f, 4, 0, 0), "light");
    for (int i = 0; i < SIDE * SIDE; i++) {
        const double u = fabs(centre_of(i % SIDE)) * tangent,
                     v = fabs(centre_of(i / SIDE)) * tangent;
        const double distance = fmax(u, v) < half ? 1 : 3;
        depth[i] = (float)(-1 + 2 * (distance - 0.5) / 3.5);
    }
    for (int moments = 4; moments <= 6; moments += 2) {
        mssm_filtered *map = make_filtered(&memory, SIDE, moments);
        CHECK(!mssm_filtered_update(map, depth, 1, 2), "update");
        for (int i = 0; i <= 40; i++) {
            const float floor_point[3] = {0.04f * (float)i, 0.1f, 0};
            // The Gaussian reaches two texels, the look one more: .12 on the floor.
            const double from_edge = floor_point[0] - 3 * half;
            const mssm_bounds b = mssm_filtered_bounds(map, &light, NULL, floor_point, 0.01f);
            CHECK(0 <= b.lower && b.lower <= b.upper && b.upper <= 1, "bounds %g %g", b.lower,
                  b.upper);
            CHECK(from_edge > -0.13 || b.upper < 0.02f, "%d: %g in the dark", moments, b.upper);
            CHECK(from_edge < 0.13 || b.upper > 0.98f, "%d: %g in the light", moments, b.upper);
        }
        CHECK(mssm_filtered_visibility(map, &light, NULL, before, 0) == 1, "before the near plane");
        free(memory);
    }
}

// A wall all over the map: lit up to the bias that was asked for, in units of depth, and dark soon after:
// 16-bit moments keep a wall and a receiver apart by some hundredths.
static void a_given_bias_is_that_bias(void)
{
    static float depth[SIDE * SIDE];
    const float to_light[3] = {0, 0, 1}, axis[3] = {1, 0, 0}, low[3] = {-1, -1, -1},
                high[3] = {1, 1, 1}, wall = -0.2f;
    mssm_light light;
    CHECK(!mssm_light_directional(&light, to_light, axis, 0, 0, low, high), "light");
    for (int i = 0; i < SIDE * SIDE; i++) depth[i] = wall;
    for (int moments = 4; moments <= 6; moments += 2) {
        void *memory;
        mssm_filtered *map = make_filtered(&memory, SIDE, moments);
        CHECK(!mssm_filtered_update(map, depth, 1, 2), "update");
        for (int i = 0; i < 3; i++) {
            const float *m = light.world_to_shadow, bias = 0.02f * (float)(1 << i);
            const mssm_filter filter = {0, bias, 0};
            for (int behind = 0; behind < 2; behind++) {
                const float z = wall + (behind ? bias + 0.06f : 0.8f * bias);
                const float point[3] = {0.1f, 0.2f, (z - m[14]) / m[10]};
                const float v = mssm_filtered_visibility(map, &light, &filter, point, 0);
                CHECK(behind ? v < 0.05f : v > 0.9999f, "bias %g, %s it: %g", (double)bias,
                      behind ? "behind" : "before", (double)v);
            }
        }
        free(memory);
    }
}

static void a_stack_of_layers_is_enclosed(void)
{
    uint64_t seed = 64;
    double gap[2] = {0, 0}, outside = 0;
    const int trials = test_trials(20000);
    for (int t = 0; t < trials; t++) {
        const int layers = 1 + (int)test_range(&seed, 0, 12);
        float z[12], opacity[12];
        mssm_moments4 m4 = mssm_moments4_of_depth(1);
        mssm_moments6 m6 = mssm_moments6_of_depth(1);
        for (int i = layers - 1; i >= 0; i--) { // i: from the light; drawn from far to near
            z[i] = (float)(-0.9 + 1.7 * (i + test_uniform(&seed)) / layers);
            opacity[i] = (float)test_uniform(&seed);
            m4 = mssm_moments4_blend(m4, z[i], opacity[i]);
            m6 = mssm_moments6_blend(m6, z[i], opacity[i]);
        }
        const float at = (float)test_range(&seed, -1, 0.99);
        double truth = 1;
        for (int i = 0; i < layers; i++) truth *= z[i] < at ? 1.0 - opacity[i] : 1.0;
        const mssm_bounds b[2] = {mssm_visibility4(mssm_moments4_bias(m4, 3e-6f), at),
                                  mssm_visibility6(mssm_moments6_bias(m6, 1e-5f), at)};
        for (int i = 0; i < 2; i++) {
            outside = fmax(outside, fmax(b[i].lower - truth, truth - b[i].upper));
            gap[i] += fabs(0.5 * (b[i].upper + b[i].lower) - truth) / trials;
        }
    }
    CHECK(outside < 1e-3, "the transmittance is outside of its bounds by %g", outside);
    CHECK(gap[1] < gap[0] && gap[0] < 0.1, "middle of the bounds: off by %g and %g", gap[0],
          gap[1]);
    test_note("middle of the bounds off by %.3f with 4 moments, %.3f with 6; outside by %.1g",
              gap[0], gap[1], outside);
}

// A veil of one opacity over a half of the map: soft and hard shadows of it are what it lets
// through.
static void a_veil_casts_its_share_of_shadow(void)
{
    static float encoded[SIDE * SIDE * 6];
    const float to_light[3] = {0, 0, 1}, axis[3] = {1, 0, 0}, low[3] = {-1, -1, -1},
                high[3] = {1, 1, 1};
    const float veiled[3] = {-0.6f, 0, -0.5f}, free_point[3] = {0.8f, 0, -0.5f},
                above[3] = {-0.6f, 0, 0.9f};
    mssm_light light;
    CHECK(!mssm_light_directional(&light, to_light, axis, 0.1f, 0.1f, low, high), "light");
    for (int moments = 4; moments <= 6; moments += 2) {
        for (int i = 0; i < SIDE * SIDE; i++) {
            const float opacity = i % SIDE < SIDE / 2 ? 0.3f : 0.0f;
            const mssm_moments6 q = mssm_moments6_encode(
                mssm_moments6_blend(mssm_moments6_of_depth(1), -0.5f, opacity));
            memcpy(encoded + i * moments, q.b, (size_t)moments * sizeof(float));
        }
        void *memory, *soft_memory = allocate(mssm_map_bytes(SIDE, moments));
        mssm_map *soft;
        mssm_filtered *map = make_filtered(&memory, SIDE, moments);
        CHECK(!mssm_map_init(&soft, soft_memory, mssm_map_bytes(SIDE, moments), SIDE, moments),
              "init");
        CHECK(!mssm_filtered_update_moments(map, encoded, 2), "hard");
        CHECK(!mssm_map_update_moments(soft, encoded), "soft");
        const mssm_filter plain = {0, 0, 1};
        const float hard[3] = {mssm_filtered_visibility(map, &light, &plain, veiled, 0),
                               mssm_filtered_visibility(map, &light, &plain, free_point, 0),
                               mssm_filtered_visibility(map, &light, &plain, above, 0)};
        const float wide[3] = {mssm_map_visibility(soft, &light, NULL, veiled),
                               mssm_map_visibility(soft, &light, NULL, free_point),
                               mssm_map_visibility(soft, &light, NULL, above)};
        // Nothing is at the receiver's depth: both bounds are what the veil lets through, and where a
        // tenth may lack to full shadow, .7 of light is (.7 - .1) / .9.
        const mssm_filter firm = {0, 0, 0.9f};
        const mssm_bounds b = mssm_filtered_bounds(map, &light, &firm, veiled, 0);
        CHECK(fabsf(b.lower - 0.6f / 0.9f) < 0.01f && fabsf(b.upper - 0.6f / 0.9f) < 0.01f,
              "%d moments: %g to %g", moments, (double)b.lower, (double)b.upper);
        const float truth[3] = {0.7f, 1, 1};
        for (int i = 0; i < 3; i++) {
            CHECK(fabsf(hard[i] - truth[i]) < 0.01f, "%d moments: hard %d is %g", moments, i,
                  hard[i]);
            CHECK(fabsf(wide[i] - truth[i]) < 0.01f, "%d moments: soft %d is %g", moments, i,
                  wide[i]);
        }
        free(memory);
        free(soft_memory);
    }
}

// The tables from encoded moments are those from the depths.
static void moments_and_depths_fill_the_same_tables(void)
{
    static float depth[SIDE * SIDE], encoded[SIDE * SIDE * 6];
    uint64_t seed = 65;
    const size_t bytes = mssm_map_bytes(SIDE, 6);
    void *memory[2] = {allocate(bytes), allocate(bytes)};
    mssm_map *map[2];
    for (int i = 0; i < SIDE * SIDE; i++) {
        depth[i] = (float)test_range(&seed, -1, 1);
        const mssm_moments6 q = mssm_moments6_encode(mssm_moments6_of_depth(depth[i]));
        memcpy(encoded + i * 6, q.b, sizeof q.b);
    }
    for (int i = 0; i < 2; i++) CHECK(!mssm_map_init(&map[i], memory[i], bytes, SIDE, 6), "init");
    CHECK(!mssm_map_update(map[0], depth, NULL, 1), "depth");
    CHECK(!mssm_map_update_moments(map[1], encoded), "moments");
    CHECK(mssm_map_update_moments(map[1], NULL) == MSSM_ERROR_ARGUMENT, "no moments");
    double worst = 0;
    for (int t = 0; t < 500; t++) {
        const float x = (float)test_range(&seed, -1.2, 1.2),
                    y = (float)test_range(&seed, -1.2, 1.2),
                    h = (float)test_range(&seed, 0.02, 0.9);
        const mssm_moments6 a = mssm_map_moments(map[0], x, y, h, h),
                            b = mssm_map_moments(map[1], x, y, h, h);
        for (int k = 0; k < 6; k++) worst = fmax(worst, fabs(a.b[k] - b.b[k]));
    }
    CHECK(worst < 4e-6, "moments differ by %g", worst);
    free(memory[0]);
    free(memory[1]);
}

static void bad_arguments_are_refused(void)
{
    const size_t bytes = mssm_filtered_bytes(5, 4);
    float depth[25], encoded[100];
    const float at[3] = {0, 0, 0};
    for (int i = 0; i < 25; i++) depth[i] = i % 3 ? (float)NAN : -2.0f;
    for (int i = 0; i < 100; i++) encoded[i] = i % 3 ? (float)NAN : -2.0f;
    // Exactly as many bytes as asked for, at an odd address: a sanitizer would see an overrun.
    unsigned char *memory = allocate(bytes + 1);
    mssm_filtered *map = NULL;
    CHECK(mssm_filtered_bytes(0, 4) == 0 && mssm_filtered_bytes(16385, 4) == 0 &&
              mssm_filtered_bytes(5, 5) == 0,
          "bytes of impossible maps");
    CHECK(mssm_filtered_init(&map, memory, bytes - 1, 5, 4) == MSSM_ERROR_MEMORY, "memory");
    CHECK(mssm_filtered_init(&map, NULL, bytes, 5, 4) == MSSM_ERROR_ARGUMENT && !map, "null");
    CHECK(!mssm_filtered_init(&map, memory + 1, bytes, 5, 4), "init");
    CHECK(mssm_filtered_update(map, depth, 0, 1) == MSSM_ERROR_ARGUMENT, "samples");
    CHECK(mssm_filtered_update(map, depth, 1, 33) == MSSM_ERROR_ARGUMENT, "radius");
    CHECK(mssm_filtered_update_moments(map, encoded, -1) == MSSM_ERROR_ARGUMENT, "radius");
    CHECK(mssm_map_update_moments(NULL, encoded) == MSSM_ERROR_ARGUMENT, "map");
    CHECK(!mssm_filtered_update(map, depth, 1, 1), "depths that are not numbers");
    CHECK(!mssm_filtered_update_moments(map, encoded, 32), "moments that are not numbers");
    mssm_light light;
    memset(&light, 0, sizeof light);
    const float seen = mssm_filtered_visibility(map, &light, NULL, at, (float)NAN);
    CHECK(seen >= 0 && seen <= 1, "a light of zeros gives %g", seen);
    const float nowhere[3] = {0, (float)NAN, 0};
    CHECK(mssm_filtered_visibility(NULL, &light, NULL, at, 0) == 1, "no map");
    CHECK(mssm_filtered_visibility(map, NULL, NULL, at, 0) == 1, "no light");
    CHECK(mssm_filtered_visibility(map, &light, NULL, NULL, 0) == 1, "no point");
    CHECK(mssm_filtered_visibility(map, &light, NULL, nowhere, 0) == 1, "a point nowhere");
    CHECK(mssm_filtered_moments(NULL, 0, 0, 0).b[0] == 1, "moments of no map");
    CHECK(mssm_filtered_init(NULL, memory, bytes, 5, 4) == MSSM_ERROR_ARGUMENT, "no place");
    CHECK(mssm_filtered_init(&map, memory, bytes, 0, 4) == MSSM_ERROR_ARGUMENT, "no side");
    CHECK(mssm_filtered_update(NULL, depth, 1, 1) == MSSM_ERROR_ARGUMENT, "no map");
    CHECK(mssm_filtered_update(map, NULL, 1, 1) == MSSM_ERROR_ARGUMENT, "no depth");
    CHECK(mssm_filtered_update(map, depth, 65, 1) == MSSM_ERROR_ARGUMENT, "samples");
    CHECK(mssm_filtered_update(map, depth, 1, -1) == MSSM_ERROR_ARGUMENT, "radius");
    CHECK(mssm_filtered_update_moments(NULL, encoded, 1) == MSSM_ERROR_ARGUMENT, "no map");
    CHECK(mssm_filtered_update_moments(map, NULL, 1) == MSSM_ERROR_ARGUMENT, "no moments");
    CHECK(mssm_filtered_update_moments(map, encoded, 33) == MSSM_ERROR_ARGUMENT, "radius");
    free(memory);
}

const test_case filtered_tests[] = {
    {"filtered: one look gives the moments under a Gaussian", one_look_gives_the_gaussian},
    {"filtered: wide looks average, and every level is rounded once", wide_looks_average},
    {"filtered: odd maps go on beyond their edges", odd_maps_go_on_beyond_their_edges},
    {"filtered: no light from beyond the rim", no_light_from_beyond_the_rim},
    {"filtered: never darker than percentage-closer filtering",
     never_darker_than_percentage_closer},
    {"filtered: surfaces are lit, walls are dark", surfaces_are_lit_and_walls_are_dark},
    {"filtered: the depth bias is for steep surfaces and edges",
     bias_is_for_steep_surfaces_and_edges},
    {"filtered: a bias that is given is that bias", a_given_bias_is_that_bias},
    {"filtered: a lamp throws the outline of a sheet", a_lamp_throws_the_outline_of_a_sheet},
    {"translucent: bounds enclose the transmittance of a stack", a_stack_of_layers_is_enclosed},
    {"translucent: a veil casts its share of shadow, hard and soft",
     a_veil_casts_its_share_of_shadow},
    {"translucent: moments and depths fill the same tables",
     moments_and_depths_fill_the_same_tables},
    {"filtered: bad arguments are refused, odd memory is enough", bad_arguments_are_refused},
    {0, 0}};
