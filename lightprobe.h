// lightprobe.h - v0.1 - area lights from a light probe - MIT or public domain (see the end)
//
// Turns an environment cube map into a few area lights: direction, rectangle, colour, and the
// opening angle of a disc for shading. The lights hold all the energy of the probe, none is spent
// where the scene does not need it, they do not care where the faces of the cube meet, and they
// follow a moving probe without jumping. The header holds the extraction, the irradiance of a disc
// light that is cut by the receiver's horizon, and that same function as GLSL text. No dependency
// but the C standard library.
//
// QUICK START
//
// In ONE source file:
//
//     #define LIGHTPROBE_IMPLEMENTATION
//     #include "lightprobe.h"
//
// In all others only the #include. At most 16 lights from six faces of 128 x 128 RGB floats:
//
//     int lights_of(const float *const faces[6], lightprobe_light lights[16])
//     {
//         lightprobe_cube cube = {{0}, 128, 3};
//         for (int i = 0; i < 6; i++) cube.face[i] = faces[i];
//         lightprobe_settings settings = {0};
//         settings.max_lights = 16;
//         static unsigned char scratch[2 << 20];  // lightprobe_scratch_bytes(128, 16) is less
//         int count = 0;
//         if (lightprobe_extract(&cube, &settings, scratch, sizeof scratch, lights, &count, NULL))
//             return 0;
//         return count;
//     }
//
// The red irradiance that a surface with this normal gets from them, nothing standing in between:
//
//     float red_irradiance(const lightprobe_light *lights, int count, const float normal[3])
//     {
//         float sum = 0;
//         for (int i = 0; i < count; i++) {
//             const float *d = lights[i].direction;
//             const float cosine = d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2];
//             sum += lights[i].irradiance[0] *
//                    lightprobe_disc_irradiance(lights[i].cos_alpha, cosine);
//         }
//         return sum;  // times albedo / pi is the radiance of a diffuse surface
//     }
//
// CONVENTIONS
//
//   cube maps     six faces in the order +X -X +Y -Y +Z -Z, oriented as in OpenGL, row by row:
//                 texel (column x, row y) at s = -1 + (2x+1)/side, t = -1 + (2y+1)/side looks along
//                 +X (1,-t,-s)  -X (-1,-t,s)  +Y (s,1,t)  -Y (s,-1,-t)  +Z (s,-t,1)  -Z (-s,-t,-1).
//                 Tightly packed: its first float is at (y*side + x)*channels.
//   radiance      linear RGB, Rec. 709 primaries, any unit. Irradiance has that unit times sr.
//   luminance     0.2126 R + 0.7152 G + 0.0722 B. All decisions are made on it.
//   directions    point from the scene to the light. Angles are given by their cosines or tangents.
//
// MACROS, each to be defined before the #include
//
//   LIGHTPROBE_IMPLEMENTATION   in one source file: compiles the functions
//
// Threads: no global state; calls with different scratch memory may run in parallel.

#ifndef LIGHTPROBE_H
#define LIGHTPROBE_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

// ------------------------------------------------------------------------------------------------
// Interface
// ------------------------------------------------------------------------------------------------

typedef enum lightprobe_result {
    LIGHTPROBE_OK = 0,
    LIGHTPROBE_ERROR_NULL,     // a pointer that must be given is null
    LIGHTPROBE_ERROR_SIDE,     // side below 1 or above LIGHTPROBE_MAX_SIDE
    LIGHTPROBE_ERROR_CHANNELS, // neither 3 nor 4
    LIGHTPROBE_ERROR_LIGHTS,   // max_lights, previous_count: below 0, above LIGHTPROBE_MAX_LIGHTS
    LIGHTPROBE_ERROR_SETTINGS, // tolerance or min_share negative or not finite, or an unknown mode
    LIGHTPROBE_ERROR_SCRATCH    // scratch memory below lightprobe_scratch_bytes()
} lightprobe_result;

// A sentence for people, never null, also for numbers that are no result.
const char *lightprobe_result_string(lightprobe_result result);

#define LIGHTPROBE_MAX_SIDE 8192
#define LIGHTPROBE_MAX_LIGHTS 4096
#define LIGHTPROBE_DEFAULT_LIGHTS 32
#define LIGHTPROBE_DEFAULT_TOLERANCE 0.01f // one disc of 11 degrees around its centre

// The probe. The caller keeps the texels; they are read only.
typedef struct lightprobe_cube {
    const float *face[6];
    int side;
    int channels; // floats per texel, 3 or 4; the fourth is skipped
} lightprobe_cube;

typedef struct lightprobe_light {
    float direction[3];           // unit; that of the region's vector irradiance
    float axis_u[3], axis_v[3];   // unit, orthogonal to direction; the longer side is u
    float tan_half_u, tan_half_v; // half-size of the rectangle at distance 1, at most 4
    float irradiance[3];          // integral of RGB radiance over the region's solid angle
    float solid_angle;            // of the region; all of them sum to 4 pi less black regions
    float cos_alpha;              // opening angle of the disc that stands for it in shading
    int id;                       // survives from frame to frame: lightprobe_settings.previous
} lightprobe_light;

typedef enum lightprobe_mode {
    LIGHTPROBE_BEST = 0,
    LIGHTPROBE_MEDIAN_CUT = 1 // the paper's way (section 3.1 and 4.1): for comparison
} lightprobe_mode;

// Zero means default everywhere.
typedef struct lightprobe_settings {
    int max_lights;  // 0: as many as the probe needs, at most LIGHTPROBE_DEFAULT_LIGHTS
    float tolerance; // no more lights once stats.error is at most this; 0: use all of max_lights
                     // or, where that is 0 too, LIGHTPROBE_DEFAULT_TOLERANCE
    int mode;        // lightprobe_mode
    float min_share; // what has a smaller share of the probe's luminance is left to the residual
    // Lights of the previous frame, for a probe that moves: the new lights go on from them, keep
    // their places in the array and their ids, and change in number or region only where that pays.
    // May be the array that receives the new lights. NULL: start afresh, brightest light first.
    // Both are ignored by LIGHTPROBE_MEDIAN_CUT.
    const lightprobe_light *previous;
    int previous_count;
    void (*log)(void *user, const char *message); // told in one line why a call failed; or NULL
    void *user;
} lightprobe_settings;

typedef struct lightprobe_stats {
    float total[3];      // irradiance[] of the whole probe, bad channels counting as 0
    float residual[3];   // what the lights do not carry, total - their sum: shade it as ambient
    float error;         // how wide the lights are: mean over the flux of half the square angle to
                         // the light's centre (exactly: sum of flux (1 - R) over sum of flux)
    int lights;          // how many were written
    int repaired_texels; // with a negative, NaN or infinite channel; that channel counts as 0
} lightprobe_stats;

// Bytes of scratch memory for probes of this side and up to max_lights lights (0: the default):
// about 19 side^2, 320 a light and 24,000. 0 where side or max_lights is out of range.
size_t lightprobe_scratch_bytes(int side, int max_lights);

// Finds the lights of a probe. lights has room for settings->max_lights; settings may be NULL (all
// defaults), stats too; scratch may have any alignment, and what it holds afterwards is of no use.
//
// The lights carry all of the probe: each texel belongs to exactly one, and the residual is
// rounding (1e-7 of total, of either sign) unless min_share, or LIGHTPROBE_MEDIAN_CUT with fewer
// than its six first regions, left something out. There may be fewer lights than asked for: where
// texels run out, where the tolerance is met, and for black regions: none for a black probe.
//
// Deterministic. Scaling the radiance by a power of two scales irradiance, total and residual and
// changes nothing else, bit for bit. Any finite texel is fine; sums beyond the range of float come
// out as FLT_MAX. Whatever fails leaves lights, light_count and stats untouched.
lightprobe_result lightprobe_extract(const lightprobe_cube *cube,
                                     const lightprobe_settings *settings, void *scratch,
                                     size_t scratch_bytes, lightprobe_light *lights,
                                     int *light_count, lightprobe_stats *stats);

// Solid angle of a texel of any face, to 1e-7 relative at every side (van Oosterom and Strackee
// 1983). The sum over six faces is 4 pi. 0 outside the face.
float lightprobe_texel_solid_angle(int side, int x, int y);

// Unit direction of the point (s, t) in [-1,1]^2 of a face 0..5 (others count as the nearest of
// these).
void lightprobe_texel_direction(int face, float s, float t, float direction[3]);

// Irradiance of a surface under a disc light of uniform radiance with half-angle alpha whose centre
// is theta away from the surface's normal, per unit of lightprobe_light.irradiance (the integral of
// radiance over the disc). Exact, also where the horizon cuts the disc and where the disc is wider
// than a hemisphere; above the horizon it is cos(theta) cos^2(alpha/2), the paper's Eq. 18. In
// [0,1], error below 1e-6. Arguments outside [-1,1] count as the nearest number inside.
float lightprobe_disc_irradiance(float cos_alpha, float cos_theta);

// GLSL 4.50 text that defines the same lightprobe_disc_irradiance. Goes behind #version; static
// memory.
const char *lightprobe_glsl_math(void);

#ifdef __cplusplus
}
#endif

#endif // LIGHTPROBE_H

// ================================================================================================
// Stop here: below is the implementation.
// ================================================================================================

#if defined LIGHTPROBE_IMPLEMENTATION && !defined LIGHTPROBE_IMPLEMENTED
#define LIGHTPROBE_IMPLEMENTED

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

// ------------------------------------------------------------------------------------------------
// Disc irradiance, shared with GLSL
// ------------------------------------------------------------------------------------------------

// What stands between the [glsl] markers is written in the subset that C99 and GLSL 4.50 share and
// is quoted by `make glsl` into lightprobe__glsl_text further down.
#define LIGHTPROBE_SHARED static inline

// [glsl begin]

// The angle of the point (x, y) with y >= 0 to the x axis, in [0, pi], to 3e-7. Written out
// (Hastings' polynomial) since GLSL allows its own atan 4096 units in the last place.
LIGHTPROBE_SHARED float lightprobe_angle(float y, float x)
{
    float ax = fabsf(x);
    float most = ax < y ? y : ax;
    float t = most > 0.0f ? (ax < y ? ax : y) / most : 0.0f;
    float t2 = t * t;
    float p = 0.0028662257f;
    p = p * t2 - 0.0161657367f;
    p = p * t2 + 0.0429096138f;
    p = p * t2 - 0.0752896400f;
    p = p * t2 + 0.1065626393f;
    p = p * t2 - 0.1420889944f;
    p = p * t2 + 0.1999355085f;
    p = p * t2 - 0.3333314528f;
    p = p * t2 * t + t;
    p = ax < y ? 1.57079633f - p : p;
    return x < 0.0f ? 3.14159265f - p : p;
}

// Half the line integral of r x dr around what the horizon leaves of the disc: psi is half its
// arc of the horizon, phi half the rim above it (docs/lightprobe.md).
float lightprobe_disc_irradiance(float cos_alpha, float cos_theta)
{
    float c = cos_alpha > -1.0f ? (cos_alpha < 1.0f ? cos_alpha : 1.0f) : -1.0f;
    float n = cos_theta > -1.0f ? (cos_theta < 1.0f ? cos_theta : 1.0f) : -1.0f;
    float size = 1.0f - c;
    float sin_alpha = sqrtf(size * (1.0f + c));
    float chord2 = (sin_alpha - n) * (sin_alpha + n);
    if (chord2 <= 0.0f) {                            // the horizon misses the rim
        float below = c < 0.0f ? 0.5f / size : 0.0f; // of the disc opposite
        float seen = c < 0.0f ? (n < 0.0f ? n : 0.0f) : (n > 0.0f ? n : 0.0f);
        float whole = below + 0.5f * (1.0f + c) * seen;
        return whole > 0.0f ? whole : 0.0f;
    }
    float chord = sqrtf(chord2);
    float sin_theta2 = (1.0f - n) * (1.0f + n);
    float s2 = chord2 / sin_theta2; // sin^2 psi
    float arc;                      // psi - sin psi cos psi
    if (c > 0.0f && s2 < 0.0625f) {
        // The difference would lose all digits: it is 2/3 psi^3, and a sun has psi < 5e-3.
        // Series of asin x - x sqrt(1 - x^2); the first term left out is 1e-7 of the sum.
        arc = 0.03976073f;
        arc = arc * s2 + 0.04971591f;
        arc = arc * s2 + 0.06944444f;
        arc = arc * s2 + 0.10714286f;
        arc = arc * s2 + 0.2f;
        arc = arc * s2 + 0.66666667f;
        arc = arc * s2 * sqrtf(s2);
    } else {
        arc = lightprobe_angle(chord, c) - chord * c / sin_theta2;
    }
    float e = (arc + n * n * chord * c / sin_theta2) / size;
    e = 0.15915494f * (e + (1.0f + c) * n * lightprobe_angle(chord, -c * n));
    return e > 0.0f ? (e < 1.0f ? e : 1.0f) : 0.0f;
}
// [glsl end]

// ------------------------------------------------------------------------------------------------
// Directions and solid angles
// ------------------------------------------------------------------------------------------------

// Where the middle, +s and +t of each face point.
static const float lightprobe__axes[6][3][3] = {
    {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
    {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},   {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
    {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},  {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}},
};

// Vector of a face with components along its middle, s and t.
static void lightprobe__to_world(int face, float m, float s, float t, float v[3])
{
    const float(*axes)[3] = lightprobe__axes[face];
    for (int i = 0; i < 3; i++) v[i] = m * axes[0][i] + s * axes[1][i] + t * axes[2][i];
}

void lightprobe_texel_direction(int face, float s, float t, float direction[3])
{
    const float scale = 1.0f / sqrtf(1.0f + s * s + t * t);
    if (face < 0) face = 0;
    if (face > 5) face = 5;
    lightprobe__to_world(face, scale, scale * s, scale * t, direction);
}

// Solid angle of the triangle whose corners have lengths a, b, c and these scalar products; n is
// their triple product, twice the triangle's area in the plane of the face. Every term is far from
// cancellation, unlike in the usual difference of four atan (0.87% off in float at 256^2).
static double lightprobe__triangle(double n, double a, double b, double c, double ab, double bc,
                                   double ca)
{
    const double z = n / (a * b * c + ab * c + bc * a + ca * b), z2 = z * z;
    if (z > 0.03) return 2 * atan(z);
    return 2 * z * (1 - z2 * (1.0 / 3 - z2 * (1.0 / 5 - z2 / 7))); // 1e-14, and fast
}

// Solid angle of [s, s1] x [t, t1] on a face.
static double lightprobe__solid_angle(double s, double t, double s1, double t1)
{
    const double n = (s1 - s) * (t1 - t), ss = 1 + s * s1, tt = 1 + t * t1;
    const double a = sqrt(1 + s * s + t * t), b = sqrt(1 + s1 * s1 + t * t);
    const double c = sqrt(1 + s1 * s1 + t1 * t1), d = sqrt(1 + s * s + t1 * t1);
    const double ac = ss + tt - 1;
    return lightprobe__triangle(n, a, b, c, ss + t * t, tt + s1 * s1, ac) +
           lightprobe__triangle(n, a, c, d, ac, ss + t1 * t1, tt + s * s);
}

float lightprobe_texel_solid_angle(int side, int x, int y)
{
    if (side <= 0 || x < 0 || y < 0 || x >= side || y >= side) return 0.0f;
    const double h = 2.0 / side, s = x * h - 1, t = y * h - 1;
    return (float)lightprobe__solid_angle(s, t, s + h, t + h);
}

// ------------------------------------------------------------------------------------------------
// Scratch memory
// ------------------------------------------------------------------------------------------------

// Sums over texels are kept as float and this much too small, so that a probe full of FLT_MAX
// (4 pi FLT_MAX in all) does not overflow; a power of two costs no digit.
#define LIGHTPROBE__SCALE 0.0625f
// A probe whose luminance sums to less counts as black: squares of shares would underflow.
#define LIGHTPROBE__BLACK 1e-30f

#define LIGHTPROBE__TILE_LEVEL 2 // a tile has 4 x 4 texels
#define LIGHTPROBE__LEVELS 14    // level 13 of the largest side is one cell
// Leaves to make so many lights from: enough that few lights have a choice. Four times as many take
// a tenth off the error of 32 lights and double the time.
#define LIGHTPROBE__LEAVES(lights) ((lights) + 200)
// Room to divide all cells of the same error or none, so that a turned probe gives the same leaves.
#define LIGHTPROBE__MORE_LEAVES 96
#define LIGHTPROBE__ROUNDS 2 // of Lloyd's iteration; more change the error of 32 lights by 2%
// One e-fold of radiance counts as much as so many radians. Without it (0) a small sun comes out
// with the haze around it: 3.9 degrees wide instead of 0.9 at 32 lights in city_sun.
#define LIGHTPROBE__TONE 0.1f
#define LIGHTPROBE__BINS 8     // places for a cut, over so many standard deviations to both sides
#define LIGHTPROBE__REACH 2.0f // of the mean
#define LIGHTPROBE__NEAR 6     // clusters that a leaf may move to

// Sums over a square of 2^level texels: RGB radiance and 1, and luminance times direction, in the
// face's own axes (middle, s, t; the fourth is unused: sums of four floats are faster).
typedef struct lightprobe__cell {
    float flux[4], vector[4];
} lightprobe__cell;

// A cell that is not divided further. Leaves tile the sphere; clusters of them become lights.
typedef struct lightprobe__leaf {
    float flux[3], solid_angle, luminance;
    float direction[3], strength; // vector irradiance = strength * direction
    float tone;                   // LIGHTPROBE__TONE times the logarithm of radiance over its mean
    int face, level, x, y, cluster;
} lightprobe__leaf;

typedef struct lightprobe__cluster {
    float vector[3], luminance, tones, tones2; // sums; of luminance times tone, times its square
    float centre[3], tone;                     // means
    float axis[3], threshold;                  // the best plane to split it, or the best tone
    int by_tone;
    int planned;
    int first, count; // its leaves in lightprobe__work.order
    int nearby[LIGHTPROBE__NEAR], near_count;
    int id, changed;
} lightprobe__cluster;

// What a light is made from.
typedef struct lightprobe__region {
    double flux[3], vector[3], luminance, solid_angle;
    double second[6]; // luminance times d d^T: xx yy zz xy yz zx
} lightprobe__region;

typedef struct lightprobe__work {
    const lightprobe_cube *cube;
    int side, half, tiles, top, max_lights, max_leaves;
    float *omega, *weight; // of the texels of a quarter face: solid angle, that over the distance
    float *band;           // weights of the texels in a row of tiles
    lightprobe__cell *cells[LIGHTPROBE__LEVELS]; // of tiles and larger squares
    lightprobe__leaf *leaves;
    int *heap, *order;
    lightprobe__cluster *clusters;
    float *gains; // what the best split of each cluster takes off the error, or a bound on it
    lightprobe__region *regions;
    int heap_count, leaf_count, cluster_count, repaired;
    double total[3];
    float mean; // luminance of 1 sr
} lightprobe__work;

static void *lightprobe__take(char *base, size_t *used, size_t bytes)
{
    void *p = base ? base + *used : NULL;
    *used += (bytes + 15) & ~(size_t)15;
    return p;
}

static int lightprobe__level_side(int side, int level)
{
    return (side + (1 << level) - 1) >> level;
}

// Points into base (null: only counts) and returns the bytes used.
static size_t lightprobe__layout(lightprobe__work *w, char *base, int side, int max_lights)
{
    size_t used = 0;
    w->side = side;
    w->half = (side + 1) / 2;
    w->tiles = lightprobe__level_side(side, LIGHTPROBE__TILE_LEVEL);
    w->max_lights = max_lights;
    w->max_leaves = LIGHTPROBE__LEAVES(max_lights) + LIGHTPROBE__MORE_LEAVES;
    const size_t quarter = (size_t)w->half * (size_t)w->half, tiles = (size_t)w->tiles;
    const size_t leaves = (size_t)w->max_leaves, lights = (size_t)max_lights;
    w->omega = (float *)lightprobe__take(base, &used, quarter * sizeof(float));
    w->weight = (float *)lightprobe__take(base, &used, quarter * sizeof(float));
    w->band = (float *)lightprobe__take(base, &used, tiles * (4 * 24 + 12 + 1) * sizeof(float));
    for (int level = LIGHTPROBE__TILE_LEVEL;; level++) {
        const size_t n = (size_t)lightprobe__level_side(side, level);
        w->cells[level] =
            (lightprobe__cell *)lightprobe__take(base, &used, 6 * n * n * sizeof(lightprobe__cell));
        w->top = level;
        if (n == 1) break;
    }
    w->leaves =
        (lightprobe__leaf *)lightprobe__take(base, &used, leaves * sizeof(lightprobe__leaf));
    w->heap = (int *)lightprobe__take(base, &used, leaves * sizeof(int));
    w->order = (int *)lightprobe__take(base, &used, leaves * sizeof(int));
    w->clusters =
        (lightprobe__cluster *)lightprobe__take(base, &used, lights * sizeof(lightprobe__cluster));
    w->gains = (float *)lightprobe__take(base, &used, lights * sizeof(float));
    w->regions =
        (lightprobe__region *)lightprobe__take(base, &used, lights * sizeof(lightprobe__region));
    return used;
}

size_t lightprobe_scratch_bytes(int side, int max_lights)
{
    lightprobe__work w;
    if (side < 1 || side > LIGHTPROBE_MAX_SIDE) return 0;
    if (max_lights < 0 || max_lights > LIGHTPROBE_MAX_LIGHTS) return 0;
    return lightprobe__layout(&w, NULL, side, max_lights ? max_lights : LIGHTPROBE_DEFAULT_LIGHTS) +
           15;
}

// ------------------------------------------------------------------------------------------------
// Small vector math
// ------------------------------------------------------------------------------------------------

static float lightprobe__luminance(const float rgb[3])
{
    return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
}

static float lightprobe__dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// In double: squares of float neither overflow nor underflow.
static double lightprobe__length(const float v[3])
{
    const double x = (double)v[0], y = (double)v[1], z = (double)v[2];
    return sqrt(x * x + y * y + z * z);
}

// Returns the length; a null vector stays.
static float lightprobe__normalize(float v[3])
{
    const double length = lightprobe__length(v), scale = length > 0 ? 1 / length : 0;
    for (int i = 0; i < 3; i++) v[i] = (float)((double)v[i] * scale);
    return (float)length;
}

// Finite. Looks at the bits: with -ffast-math a comparison need not see a NaN.
static int lightprobe__is_number(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & 0x7fffffffu) < 0x7f800000u;
}

// ------------------------------------------------------------------------------------------------
// Sums over tiles: the one pass over all texels
// ------------------------------------------------------------------------------------------------

// Four floats at a time. gcc 12 -O2 makes code that takes twice as long out of plain loops.
#if defined __GNUC__ && (defined __SSE2__ || defined __ARM_NEON)
typedef float lightprobe__four __attribute__((vector_size(16)));
typedef int32_t lightprobe__bits __attribute__((vector_size(16)));
static inline lightprobe__four lightprobe__add4(lightprobe__four a, lightprobe__four b)
{
    return a + b;
}
static inline lightprobe__four lightprobe__mul4(lightprobe__four a, lightprobe__four b)
{
    return a * b;
}
static inline lightprobe__bits lightprobe__or4(lightprobe__bits a, lightprobe__bits b)
{
    return a | b;
}
#else
typedef struct lightprobe__four {
    float v[4];
} lightprobe__four;
typedef struct lightprobe__bits {
    int32_t v[4];
} lightprobe__bits;
static lightprobe__four lightprobe__add4(lightprobe__four a, lightprobe__four b)
{
    for (int i = 0; i < 4; i++) a.v[i] += b.v[i];
    return a;
}
static lightprobe__four lightprobe__mul4(lightprobe__four a, lightprobe__four b)
{
    for (int i = 0; i < 4; i++) a.v[i] *= b.v[i];
    return a;
}
static lightprobe__bits lightprobe__or4(lightprobe__bits a, lightprobe__bits b)
{
    for (int i = 0; i < 4; i++) a.v[i] |= b.v[i];
    return a;
}
#endif

static inline lightprobe__four lightprobe__load4(const float *p)
{
    lightprobe__four a;
    memcpy(&a, p, sizeof a);
    return a;
}

// The band is aligned to 16 bytes: then gcc multiplies straight from memory, 5% of the extraction.
static inline lightprobe__four lightprobe__band4(const float *p)
{
    lightprobe__four a;
#if defined __GNUC__
    memcpy(&a, __builtin_assume_aligned(p, 16), sizeof a);
#else
    memcpy(&a, p, sizeof a);
#endif
    return a;
}

static inline void lightprobe__store4(float *p, lightprobe__four a)
{
    memcpy(p, &a, sizeof a);
}

static inline lightprobe__four lightprobe__set4(float x)
{
    const float v[4] = {x, x, x, x};
    return lightprobe__load4(v);
}

static inline lightprobe__bits lightprobe__bits4(lightprobe__four a)
{
    lightprobe__bits bits;
    memcpy(&bits, &a, sizeof bits);
    return bits;
}

static inline float lightprobe__sum4(lightprobe__four a)
{
    float v[4];
    memcpy(v, &a, sizeof v);
    return (v[0] + v[1]) + (v[2] + v[3]);
}

// Index of a texel's weights; they are the same in all quarters of all faces.
static size_t lightprobe__quarter(const lightprobe__work *w, int x, int y)
{
    const int right = 2 * x + 1 - w->side, down = 2 * y + 1 - w->side;
    const int dx = (right < 0 ? -right : right) / 2, dy = (down < 0 ? -down : down) / 2;
    return (size_t)dy * (size_t)w->half + (size_t)dx;
}

// Centre of a texel in [-1,1].
static float lightprobe__centre(int side, int x)
{
    return (float)(2 * x + 1 - side) / (float)side;
}

// A texel's vector irradiance is shorter than its solid angle by omega / 12, the mean half square
// angle of a square: without it a face of one texel would count as a point (17% too long, now 0.7%
// too short).
static void lightprobe__make_tables(lightprobe__work *w)
{
    const double h = 2.0 / w->side, first = w->side & 1 ? -0.5 * h : 0.0;
    const float area = (float)(h * h), bend = (float)(h * h / 24);
    for (int y = 0; y < w->half; y++) {
        const float t = (float)first + ((float)y + 0.5f) * (float)h;
        for (int x = 0; x <= y; x++) {
            const float s = (float)first + ((float)x + 0.5f) * (float)h;
            const float inverse = 1 / sqrtf(1 + s * s + t * t), i2 = inverse * inverse;
            // The middle of the texel plus the second derivative: at most 4e-7 off.
            // The exact way for all would take a fifth of the whole extraction at side 128.
            float omega = area * i2 * inverse * (1 + bend * i2 * (9 - 15 * i2));
            if (w->side < 64)
                omega = (float)lightprobe__solid_angle(first + x * h, first + y * h,
                                                       first + (x + 1) * h, first + (y + 1) * h);
            const float weight = omega * (1 - omega * (1 / 12.0f)) * inverse * LIGHTPROBE__SCALE;
            const size_t a = (size_t)y * (size_t)w->half + (size_t)x;
            const size_t b = (size_t)x * (size_t)w->half + (size_t)y;
            w->omega[a] = w->omega[b] = omega * LIGHTPROBE__SCALE;
            w->weight[a] = w->weight[b] = weight;
        }
    }
}

static const float *lightprobe__texel(const lightprobe__work *w, int face, int x, int y)
{
    return w->cube->face[face] +
           ((size_t)y * (size_t)w->side + (size_t)x) * (size_t)w->cube->channels;
}

// Copies a texel and puts 0 for bad channels; returns 1 if there was one. Looks at the bits: with
// -ffast-math a comparison need not see a NaN.
static int lightprobe__read(const float *texel, float rgb[3])
{
    int bad = 0;
    for (int i = 0; i < 3; i++) {
        uint32_t bits;
        memcpy(&bits, texel + i, sizeof bits);
        rgb[i] = bits < 0x7f800000u ? texel[i] : 0.0f;
        bad |= bits >= 0x7f800000u && bits != 0x80000000u; // -0 is fine
    }
    return bad;
}

// Copies a tile that the border cuts, that has a fourth channel or bad texels. Counts the bad ones.
static int lightprobe__gather(const lightprobe__work *w, int face, int tx, int ty, float out[48])
{
    int bad = 0;
    memset(out, 0, 48 * sizeof *out);
    for (int y = 4 * ty; y < 4 * ty + 4 && y < w->side; y++) {
        for (int x = 4 * tx; x < 4 * tx + 4 && x < w->side; x++)
            bad += lightprobe__read(lightprobe__texel(w, face, x, y),
                                    out + 12 * (y & 3) + 3 * (x & 3));
    }
    return bad;
}

// texels and step: four rows of four RGB texels. band: four rows of weights, 12 floats of solid
// angle and 12 of solid angle times luminance coefficient over distance per tile. s: of the 12
// floats. t: of the row behind the last, next to the one before it. omega: of the tile. Returns 0
// where a texel was negative, NaN or infinite (then the sums are worthless): the sign bits are
// gathered on the way, the rest shows in the sums. Written out, three registers of four floats
// each: gcc -O2 keeps arrays of them in memory, at twice the time.
static inline int lightprobe__sum_tile(const float *texels, ptrdiff_t step, const float *band,
                                       ptrdiff_t stride, const float *s, const float t[2],
                                       float omega, lightprobe__cell *cell)
{
    const lightprobe__four zero = lightprobe__set4(0);
    lightprobe__four f0 = zero, f1 = zero, f2 = zero, m0 = zero, m1 = zero, m2 = zero;
    lightprobe__four n0 = zero, n1 = zero, n2 = zero;
    lightprobe__bits sign = lightprobe__bits4(zero);
    for (int row = 0; row < 4; row++, texels += step, band += stride) {
        const lightprobe__four x0 = lightprobe__load4(texels), x1 = lightprobe__load4(texels + 4);
        const lightprobe__four x2 = lightprobe__load4(texels + 8);
        f0 = lightprobe__add4(f0, lightprobe__mul4(x0, lightprobe__band4(band)));
        f1 = lightprobe__add4(f1, lightprobe__mul4(x1, lightprobe__band4(band + 4)));
        f2 = lightprobe__add4(f2, lightprobe__mul4(x2, lightprobe__band4(band + 8)));
        m0 = lightprobe__add4(m0, lightprobe__mul4(x0, lightprobe__band4(band + 12)));
        m1 = lightprobe__add4(m1, lightprobe__mul4(x1, lightprobe__band4(band + 16)));
        m2 = lightprobe__add4(m2, lightprobe__mul4(x2, lightprobe__band4(band + 20)));
        n0 = lightprobe__add4(n0, m0); // sums of sums: the first row counts 4 times
        n1 = lightprobe__add4(n1, m1);
        n2 = lightprobe__add4(n2, m2);
        sign = lightprobe__or4(sign, lightprobe__or4(lightprobe__bits4(x0), lightprobe__bits4(x1)));
        sign = lightprobe__or4(sign, lightprobe__bits4(x2));
    }
    float f[12];
    lightprobe__store4(f, f0);
    lightprobe__store4(f + 4, f1);
    lightprobe__store4(f + 8, f2);
    cell->flux[0] = (f[0] + f[3]) + (f[6] + f[9]);
    cell->flux[1] = (f[1] + f[4]) + (f[7] + f[10]);
    cell->flux[2] = (f[2] + f[5]) + (f[8] + f[11]);
    cell->flux[3] = omega;
    cell->vector[0] = lightprobe__sum4(lightprobe__add4(lightprobe__add4(m0, m1), m2));
    m0 = lightprobe__mul4(m0, lightprobe__band4(s));
    m1 = lightprobe__mul4(m1, lightprobe__band4(s + 4));
    m2 = lightprobe__mul4(m2, lightprobe__band4(s + 8));
    cell->vector[1] = lightprobe__sum4(lightprobe__add4(lightprobe__add4(m0, m1), m2));
    const float n = lightprobe__sum4(lightprobe__add4(lightprobe__add4(n0, n1), n2));
    cell->vector[2] = t[0] * cell->vector[0] + (t[1] - t[0]) * n;
    cell->vector[3] = 0;
    uint32_t signs[4], bits[3];
    memcpy(signs, &sign, sizeof signs);
    memcpy(bits, cell->flux, sizeof bits);
    return (signs[0] | signs[1] | signs[2] | signs[3]) < 0x80000000u && bits[0] < 0x7f800000u &&
           bits[1] < 0x7f800000u && bits[2] < 0x7f800000u;
}

// Weights of the texels in a row of tiles. What lies beyond the side may hold anything finite.
static void lightprobe__make_band(lightprobe__work *w, int ty)
{
    const int stride = 24 * w->tiles;
    float *tile_omega = w->band + (4 * 24 + 12) * w->tiles;
    for (int y = 4 * ty; y < 4 * ty + 4 && y < w->side; y++) {
        const size_t first = lightprobe__quarter(w, w->side / 2, y);
        if (y == 4 * ty) memset(tile_omega, 0, (size_t)w->tiles * sizeof(float));
        for (int d = 0; d < w->half; d++) { // from the middle to both sides
            const float omega = w->omega[first + (size_t)d], q = w->weight[first + (size_t)d];
            for (int x = w->side / 2 + d;; x = w->side - 1 - x) {
                float *to = w->band + (y & 3) * stride + (x >> 2) * 24 + (x & 3) * 3;
                to[0] = to[1] = to[2] = omega;
                to[12] = 0.2126f * q;
                to[13] = 0.7152f * q;
                to[14] = 0.0722f * q;
                tile_omega[x >> 2] += omega;
                if (2 * x < w->side) break;
            }
        }
    }
}

// One row of tiles of one face. The band was made for row band_ty, which is ty or its mirror image.
static void lightprobe__sum_band(lightprobe__work *w, int face, int ty, int band_ty)
{
    const int flip = ty != band_ty;
    const ptrdiff_t stride = 24 * w->tiles, row = 3 * (ptrdiff_t)w->side;
    const ptrdiff_t step = flip ? -row : row, copy_step = flip ? -12 : 12;
    const float *s = w->band + 4 * stride, *omega = s + 12 * w->tiles, *band = w->band;
    const float *texels = w->cube->face[face] + 4 * ty * row + (flip ? 3 * row : 0);
    const int plain = w->cube->channels == 3 && 4 * ty + 4 <= w->side ? w->side / 4 : 0;
    const float t[2] = {lightprobe__centre(w->side, 4 * ty + (flip ? -1 : 4)),
                        lightprobe__centre(w->side, 4 * ty + (flip ? 0 : 3))};
    lightprobe__cell *cell = w->cells[LIGHTPROBE__TILE_LEVEL] + (face * w->tiles + ty) * w->tiles;
    for (int tx = 0; tx < w->tiles; tx++, cell++, texels += 12, band += 24, s += 12) {
        float copy[48];
        for (int copied = tx >= plain;; copied = 1) {
            if (copied) w->repaired += lightprobe__gather(w, face, tx, ty, copy);
            const float *from = copied ? copy + (flip ? 36 : 0) : texels;
            const ptrdiff_t by = copied ? copy_step : step;
            if (lightprobe__sum_tile(from, by, band, stride, s, t, omega[tx], cell)) break;
            if (copied) break;
        }
    }
}

static void lightprobe__sum_tiles(lightprobe__work *w)
{
    const int symmetric = w->side % 4 == 0;
    float *s = w->band + 4 * 24 * w->tiles; // of the 12 floats of every tile, behind the weights
    memset(w->band, 0, (size_t)(4 * 24 + 12) * (size_t)w->tiles * sizeof(float));
    for (int x = 0; x < 3 * w->side; x++) s[x] = lightprobe__centre(w->side, x / 3);
    for (int ty = 0; ty < (symmetric ? (w->tiles + 1) / 2 : w->tiles); ty++) {
        const int mirror = w->tiles - 1 - ty;
        lightprobe__make_band(w, ty);
        for (int face = 0; face < 6; face++) {
            lightprobe__sum_band(w, face, ty, ty);
            if (symmetric && mirror != ty) lightprobe__sum_band(w, face, mirror, ty);
        }
    }
}

// ------------------------------------------------------------------------------------------------
// Cells of all sizes
// ------------------------------------------------------------------------------------------------

static void lightprobe__add_cell(lightprobe__cell *sum, const lightprobe__cell *cell)
{
    for (int i = 0; i < 4; i++) sum->flux[i] += cell->flux[i];
    for (int i = 0; i < 4; i++) sum->vector[i] += cell->vector[i];
}

// Halves the tiles again and again, up to one cell per face.
static void lightprobe__make_pyramid(lightprobe__work *w)
{
    for (int level = LIGHTPROBE__TILE_LEVEL + 1; level <= w->top; level++) {
        const int n = lightprobe__level_side(w->side, level);
        const int m = lightprobe__level_side(w->side, level - 1);
        lightprobe__cell *to = w->cells[level];
        for (int row = 0; row < 6 * n; row++) {
            const int y = 2 * (row % n);
            const lightprobe__cell *from = w->cells[level - 1] + (row / n * m + y) * m;
            for (int x = 0; x < m; x += 2) {
                lightprobe__cell sum = from[x];
                if (x + 1 < m) lightprobe__add_cell(&sum, from + x + 1);
                if (y + 1 < m) lightprobe__add_cell(&sum, from + m + x);
                if (x + 1 < m && y + 1 < m) lightprobe__add_cell(&sum, from + m + x + 1);
                *to++ = sum;
            }
        }
    }
}

// In double, over the cells of 8 x 8 texels.
static float lightprobe__find_total(lightprobe__work *w)
{
    const int level = w->top > LIGHTPROBE__TILE_LEVEL ? LIGHTPROBE__TILE_LEVEL + 1 : w->top;
    const int n = lightprobe__level_side(w->side, level);
    for (int i = 0; i < 6 * n * n; i++)
        for (int c = 0; c < 3; c++) w->total[c] += (double)w->cells[level][i].flux[c];
    const float rgb[3] = {(float)w->total[0], (float)w->total[1], (float)w->total[2]};
    return lightprobe__luminance(rgb);
}

// A cell smaller than a tile, straight from its texels.
static lightprobe__cell lightprobe__small_cell(const lightprobe__work *w, int face, int level,
                                               int cx, int cy)
{
    const int size = 1 << level;
    lightprobe__cell sum;
    memset(&sum, 0, sizeof sum);
    for (int y = size * cy; y < size * cy + size && y < w->side; y++) {
        for (int x = size * cx; x < size * cx + size && x < w->side; x++) {
            const size_t i = lightprobe__quarter(w, x, y);
            lightprobe__cell texel;
            lightprobe__read(lightprobe__texel(w, face, x, y), texel.flux);
            const float m = lightprobe__luminance(texel.flux) * w->weight[i];
            for (int c = 0; c < 3; c++) texel.flux[c] *= w->omega[i];
            texel.vector[0] = m;
            texel.vector[1] = m * lightprobe__centre(w->side, x);
            texel.vector[2] = m * lightprobe__centre(w->side, y);
            texel.flux[3] = w->omega[i];
            texel.vector[3] = 0;
            lightprobe__add_cell(&sum, &texel);
        }
    }
    return sum;
}

static lightprobe__cell lightprobe__cell_at(const lightprobe__work *w, int face, int level, int x,
                                            int y)
{
    if (level < LIGHTPROBE__TILE_LEVEL) return lightprobe__small_cell(w, face, level, x, y);
    const int n = lightprobe__level_side(w->side, level);
    return w->cells[level][(face * n + y) * n + x];
}

// ------------------------------------------------------------------------------------------------
// Leaves: the cell with the largest error is divided first
// ------------------------------------------------------------------------------------------------

static float lightprobe__leaf_error(const lightprobe__leaf *leaf)
{
    return leaf->luminance - leaf->strength;
}

static void lightprobe__heap_push(lightprobe__work *w, int leaf)
{
    const float error = lightprobe__leaf_error(w->leaves + leaf);
    int i = w->heap_count++;
    for (; i > 0; i = (i - 1) / 2) {
        const int parent = w->heap[(i - 1) / 2];
        if (lightprobe__leaf_error(w->leaves + parent) >= error) break;
        w->heap[i] = parent;
    }
    w->heap[i] = leaf;
}

static int lightprobe__heap_pop(lightprobe__work *w)
{
    const int top = w->heap[0], last = w->heap[--w->heap_count];
    const float error = lightprobe__leaf_error(w->leaves + last);
    int i = 0;
    for (int child = 1; child < w->heap_count; child = 2 * i + 1) {
        if (child + 1 < w->heap_count && lightprobe__leaf_error(w->leaves + w->heap[child + 1]) >
                                             lightprobe__leaf_error(w->leaves + w->heap[child]))
            child++;
        if (lightprobe__leaf_error(w->leaves + w->heap[child]) <= error) break;
        w->heap[i] = w->heap[child];
        i = child;
    }
    w->heap[i] = last;
    return top;
}

static float lightprobe__tone(const lightprobe__work *w, float luminance, float solid_angle)
{
    if (!(solid_angle > 0)) return 0;
    const float ratio =
        luminance < 1e6f * w->mean * solid_angle ? luminance / (w->mean * solid_angle) : 1e6f;
    return LIGHTPROBE__TONE * logf(ratio > 1e-3f ? ratio : 1e-3f);
}

static void lightprobe__set_leaf(lightprobe__work *w, int index, int face, int level, int x, int y)
{
    const lightprobe__cell cell = lightprobe__cell_at(w, face, level, x, y);
    lightprobe__leaf *leaf = w->leaves + index;
    memcpy(leaf->flux, cell.flux, sizeof leaf->flux);
    lightprobe__to_world(face, cell.vector[0], cell.vector[1], cell.vector[2], leaf->direction);
    leaf->solid_angle = cell.flux[3];
    leaf->luminance = lightprobe__luminance(cell.flux);
    leaf->strength = lightprobe__normalize(leaf->direction);
    leaf->tone = lightprobe__tone(w, leaf->luminance, leaf->solid_angle / LIGHTPROBE__SCALE);
    leaf->face = face;
    leaf->level = level;
    leaf->x = x;
    leaf->y = y;
    leaf->cluster = 0;
    if (!(leaf->strength > 0)) { // black, but it must belong somewhere
        const float h = (float)(2 << level) / (float)w->side;
        const float s = ((float)x + 0.5f) * h - 1, t = ((float)y + 0.5f) * h - 1;
        lightprobe_texel_direction(face, s < 1 ? s : 1, t < 1 ? t : 1, leaf->direction);
    }
    if (level > 0) lightprobe__heap_push(w, index);
}

// Six faces, then down to single texels where the light is.
static void lightprobe__make_leaves(lightprobe__work *w, float total)
{
    const int enough = w->max_leaves - LIGHTPROBE__MORE_LEAVES;
    float last = 0;
    w->heap_count = 0;
    w->mean = total / 12.5663706f;
    for (int face = 0; face < 6; face++) lightprobe__set_leaf(w, face, face, w->top, 0, 0);
    w->leaf_count = 6;
    while (w->heap_count > 0 && w->leaf_count + 3 <= w->max_leaves) {
        const int index = lightprobe__heap_pop(w);
        const lightprobe__leaf parent = w->leaves[index];
        const float error = lightprobe__leaf_error(&parent);
        if (error <= 1e-7f * total) break; // rounding
        if (w->leaf_count >= enough && error < 0.9999f * last) break;
        last = error;
        const int level = parent.level - 1, n = lightprobe__level_side(w->side, level);
        for (int k = 0; k < 4; k++) {
            const int x = 2 * parent.x + (k & 1), y = 2 * parent.y + (k >> 1);
            if (x < n && y < n)
                lightprobe__set_leaf(w, k ? w->leaf_count++ : index, parent.face, level, x, y);
        }
    }
}

// ------------------------------------------------------------------------------------------------
// Clusters: leaves that become one light, wherever the faces meet
// ------------------------------------------------------------------------------------------------

static inline void lightprobe__add_leaf(const lightprobe__leaf *leaf, lightprobe__cluster *c)
{
    const float tones = leaf->luminance * leaf->tone;
    for (int i = 0; i < 3; i++) c->vector[i] += leaf->strength * leaf->direction[i];
    c->luminance += leaf->luminance;
    c->tones += tones;
    c->tones2 += tones * leaf->tone;
    c->count++;
}

static void lightprobe__clear_cluster(lightprobe__cluster *c)
{
    c->vector[0] = c->vector[1] = c->vector[2] = c->luminance = c->tones = c->tones2 = 0;
    c->count = 0;
}

// Half the distance between directions squared is 1 - cosine; so is half that between tones.
static inline float lightprobe__nearness(const float a[3], float tone_a, const float b[3],
                                         float tone_b)
{
    return lightprobe__dot(a, b) - 0.5f * (tone_a - tone_b) * (tone_a - tone_b);
}

// What stats.error adds up: the variance of direction.
static float lightprobe__cluster_error(const lightprobe__cluster *c)
{
    return c->luminance - (float)lightprobe__length(c->vector);
}

// Nothing can be gained by a split beyond the variance of direction and tone.
static float lightprobe__gain_bound(const lightprobe__cluster *c)
{
    const float mean2 = c->luminance > LIGHTPROBE__BLACK ? c->tones / c->luminance * c->tones : 0;
    return lightprobe__cluster_error(c) + 0.5f * (c->tones2 - mean2);
}

// Sums of all clusters from the leaves' numbers.
static void lightprobe__sum_clusters(lightprobe__work *w)
{
    for (int k = 0; k < w->cluster_count; k++) lightprobe__clear_cluster(w->clusters + k);
    for (int i = 0; i < w->leaf_count; i++)
        lightprobe__add_leaf(w->leaves + i, w->clusters + w->leaves[i].cluster);
    for (int k = 0; k < w->cluster_count; k++) {
        lightprobe__cluster *c = w->clusters + k;
        float v[3];
        memcpy(v, c->vector, sizeof v);
        if (lightprobe__normalize(v) > 0) memcpy(c->centre, v, sizeof v);
        if (c->luminance > LIGHTPROBE__BLACK) c->tone = c->tones / c->luminance;
    }
}

// Sorts the leaves by cluster (counting sort); needs the counts.
static void lightprobe__sort_leaves(lightprobe__work *w)
{
    int first = 0;
    for (int k = 0; k < w->cluster_count; k++) {
        w->clusters[k].first = first;
        first += w->clusters[k].count;
        w->clusters[k].count = 0;
    }
    for (int i = 0; i < w->leaf_count; i++) {
        lightprobe__cluster *c = w->clusters + w->leaves[i].cluster;
        w->order[c->first + c->count++] = i;
    }
}

// First eigenvector of a symmetric matrix (xx yy zz xy yz zx): three squarings leave little but it
// (ratio of eigenvalues to the 8th power), and the longest copy of it is a column.
static void lightprobe__eigenvector(const float matrix[6], float v[3])
{
    float m[6];
    memcpy(m, matrix, sizeof m);
    for (int round = 0; round < 3; round++) {
        const float trace = m[0] + m[1] + m[2], s = trace > 1e-18f ? 1 / trace : 0;
        const float a = m[0] * s, b = m[1] * s, d = m[2] * s;
        const float ab = m[3] * s, bd = m[4] * s, da = m[5] * s;
        m[0] = a * a + ab * ab + da * da;
        m[1] = ab * ab + b * b + bd * bd;
        m[2] = da * da + bd * bd + d * d;
        m[3] = a * ab + ab * b + da * bd;
        m[4] = ab * da + b * bd + bd * d;
        m[5] = da * a + bd * ab + d * da;
    }
    const int k = m[0] >= m[1] ? (m[0] >= m[2] ? 0 : 2) : (m[1] >= m[2] ? 1 : 2);
    v[0] = k == 0 ? m[0] : k == 1 ? m[3] : m[5];
    v[1] = k == 0 ? m[3] : k == 1 ? m[1] : m[4];
    v[2] = k == 0 ? m[5] : k == 1 ? m[4] : m[2];
    if (!(lightprobe__normalize(v) > 0)) v[1] = 1;
}

// Where a leaf lies on the axis of a cluster.
static inline float lightprobe__along(const lightprobe__cluster *c, const lightprobe__leaf *leaf)
{
    return c->by_tone ? leaf->tone : lightprobe__dot(leaf->direction, c->axis);
}

// Finds the direction of the largest variance, or that tone varies more. Returns the standard
// deviation, and the mean along the axis.
static float lightprobe__find_axis(const lightprobe__work *w, lightprobe__cluster *c, float *middle)
{
    float m[6] = {0}, mean[3], tone2 = 0;
    const float scale = c->luminance > LIGHTPROBE__BLACK ? 1 / c->luminance : 0;
    const float mean_tone = c->tones * scale;
    for (int i = 0; i < 3; i++) mean[i] = c->vector[i] * scale;
    for (int k = c->first; k < c->first + c->count; k++) {
        const lightprobe__leaf *leaf = w->leaves + w->order[k];
        const float f = leaf->luminance * scale, x = leaf->direction[0] - mean[0];
        const float y = leaf->direction[1] - mean[1], z = leaf->direction[2] - mean[2];
        m[0] += f * x * x;
        m[1] += f * y * y;
        m[2] += f * z * z;
        m[3] += f * x * y;
        m[4] += f * y * z;
        m[5] += f * z * x;
        tone2 += f * (leaf->tone - mean_tone) * (leaf->tone - mean_tone);
    }
    lightprobe__eigenvector(m, c->axis);
    const float x = c->axis[0], y = c->axis[1], z = c->axis[2];
    const float variance = fabsf(x * x * m[0] + y * y * m[1] + z * z * m[2] +
                                 2 * (x * y * m[3] + y * z * m[4] + z * x * m[5]));
    c->by_tone = tone2 > variance;
    *middle = c->by_tone ? mean_tone : lightprobe__dot(mean, c->axis);
    return sqrtf(c->by_tone ? tone2 : variance);
}

// What cutting off a part takes off half the variance of tone.
static float lightprobe__tone_gain(const lightprobe__cluster *whole,
                                   const lightprobe__cluster *part)
{
    const float rest = whole->luminance - part->luminance;
    if (!(part->luminance > LIGHTPROBE__BLACK) || !(rest > LIGHTPROBE__BLACK)) return 0;
    const float apart = part->tones / part->luminance - (whole->tones - part->tones) / rest;
    return 0.5f * apart * apart * part->luminance * (rest / whole->luminance);
}

// Finds where on the axis a cut takes most off the error: of BINS - 1 places, which is enough since
// the clusters are relaxed afterwards.
static void lightprobe__plan_split(lightprobe__work *w, lightprobe__cluster *c)
{
    lightprobe__cluster bins[LIGHTPROBE__BINS], left;
    float *best = w->gains + (c - w->clusters), middle;
    *best = 0;
    c->planned = 1;
    if (c->count < 2) return;
    const float deviation = lightprobe__find_axis(w, c, &middle);
    if (deviation < 1e-7f) return;
    const float width = LIGHTPROBE__REACH * deviation, scale = LIGHTPROBE__BINS / (2 * width);
    const float low = middle - width;
    for (int bin = 0; bin < LIGHTPROBE__BINS; bin++) lightprobe__clear_cluster(bins + bin);
    for (int k = c->first; k < c->first + c->count; k++) {
        const lightprobe__leaf *leaf = w->leaves + w->order[k];
        const float p = (lightprobe__along(c, leaf) - low) * scale;
        const int bin = p > 0 ? (p < LIGHTPROBE__BINS - 1 ? (int)p : LIGHTPROBE__BINS - 1) : 0;
        lightprobe__add_leaf(leaf, bins + bin);
    }
    const double whole = lightprobe__length(c->vector);
    lightprobe__clear_cluster(&left);
    for (int bin = 0; bin + 1 < LIGHTPROBE__BINS; bin++) {
        float right[3];
        for (int i = 0; i < 3; i++) left.vector[i] += bins[bin].vector[i];
        for (int i = 0; i < 3; i++) right[i] = c->vector[i] - left.vector[i];
        left.luminance += bins[bin].luminance;
        left.tones += bins[bin].tones;
        left.count += bins[bin].count;
        if (left.count == 0 || left.count == c->count) continue;
        const double apart = lightprobe__length(left.vector) + lightprobe__length(right) - whole;
        const float gain = (float)apart + lightprobe__tone_gain(c, &left);
        if (gain <= *best) continue;
        *best = gain;
        c->threshold = low + (float)(bin + 1) / scale;
    }
}

// Moves the leaves behind the planned plane from one cluster to another, empty one, and sums both.
static void lightprobe__split(lightprobe__work *w, lightprobe__cluster *c, lightprobe__cluster *d)
{
    int i = c->first, end = c->first + c->count;
    const int number = (int)(d - w->clusters);
    lightprobe__clear_cluster(c);
    lightprobe__clear_cluster(d);
    c->first = i;
    while (i < end) {
        const int index = w->order[i];
        lightprobe__leaf *leaf = w->leaves + index;
        lightprobe__cluster *to = lightprobe__along(c, leaf) < c->threshold ? c : d;
        lightprobe__add_leaf(leaf, to);
        if (to == c) {
            i++;
        } else {
            leaf->cluster = number;
            w->order[i] = w->order[--end];
            w->order[end] = index;
        }
    }
    d->first = i;
    w->gains[c - w->clusters] = lightprobe__gain_bound(c);
    w->gains[number] = lightprobe__gain_bound(d);
    c->planned = d->planned = 0;
}

static int lightprobe__largest_gain(const lightprobe__work *w)
{
    float top = w->gains[0];
    int most = 0;
    for (int k = 1; k < w->cluster_count; k++) {
        if (w->gains[k] <= top) continue;
        top = w->gains[k];
        most = k;
    }
    return most;
}

// Splits whatever gains most until there are enough clusters or the error is small enough.
static void lightprobe__divide(lightprobe__work *w, float total, float tolerance)
{
    float error = 0;
    for (int k = 0; k < w->cluster_count; k++) {
        w->clusters[k].planned = 0;
        w->gains[k] = lightprobe__gain_bound(w->clusters + k);
        error += lightprobe__cluster_error(w->clusters + k);
    }
    while (w->cluster_count < w->max_lights && error > tolerance * total) {
        const int most = lightprobe__largest_gain(w);
        if (w->gains[most] <= 1e-7f * total) break;
        lightprobe__cluster *best = w->clusters + most, *fresh = w->clusters + w->cluster_count;
        if (!best->planned) { // most small clusters never come to this, which saves half the time
            lightprobe__plan_split(w, best);
            continue;
        }
        error -= lightprobe__cluster_error(best);
        w->cluster_count++;
        memset(fresh, 0, sizeof *fresh);
        fresh->id = -1;
        lightprobe__split(w, best, fresh);
        error += lightprobe__cluster_error(best) + lightprobe__cluster_error(fresh);
    }
}

// The clusters whose centres are nearest to each cluster's.
static void lightprobe__find_near(lightprobe__work *w)
{
    for (int a = 0; a < w->cluster_count; a++) {
        lightprobe__cluster *c = w->clusters + a;
        float score[LIGHTPROBE__NEAR];
        int n = 0;
        for (int b = 0; b < w->cluster_count; b++) {
            const lightprobe__cluster *d = w->clusters + b;
            if (b == a || !(d->luminance > 0)) continue;
            const float s = lightprobe__nearness(c->centre, c->tone, d->centre, d->tone);
            if (n == LIGHTPROBE__NEAR && s <= score[n - 1]) continue;
            int at = n < LIGHTPROBE__NEAR ? n++ : n - 1;
            for (; at > 0 && score[at - 1] < s; at--) {
                score[at] = score[at - 1];
                c->nearby[at] = c->nearby[at - 1];
            }
            score[at] = s;
            c->nearby[at] = b;
        }
        c->near_count = n;
    }
}

// Lloyd's iteration on the sphere: each leaf goes to the nearest centre among its cluster's
// neighbours, which never raises the error, and takes no heed of cuts and faces.
static void lightprobe__relax(lightprobe__work *w, int rounds)
{
    for (int round = 0; round < rounds; round++) {
        int moved = 0;
        for (int i = 0; i < w->leaf_count; i++) {
            lightprobe__leaf *leaf = w->leaves + i;
            const lightprobe__cluster *own = w->clusters + leaf->cluster;
            float best = lightprobe__nearness(leaf->direction, leaf->tone, own->centre, own->tone);
            for (int k = 0; k < own->near_count; k++) {
                const lightprobe__cluster *c = w->clusters + own->nearby[k];
                const float s =
                    lightprobe__nearness(leaf->direction, leaf->tone, c->centre, c->tone);
                if (s <= best) continue;
                best = s;
                leaf->cluster = own->nearby[k];
                moved = 1;
            }
        }
        if (!moved) break;
        lightprobe__sum_clusters(w);
    }
}

// The two neighbours that cost least to merge; returns the cost, or FLT_MAX. Leaves out what has
// changed.
static float lightprobe__cheapest_merge(const lightprobe__work *w, int not_this, int pair[2])
{
    float least = FLT_MAX;
    for (int a = 0; a < w->cluster_count; a++) {
        const lightprobe__cluster *c = w->clusters + a;
        if (c->changed || a == not_this) continue;
        for (int k = 0; k < c->near_count; k++) {
            const lightprobe__cluster *d = w->clusters + c->nearby[k];
            if (d->changed || c->nearby[k] == not_this) continue;
            lightprobe__cluster sum;
            for (int i = 0; i < 3; i++) sum.vector[i] = c->vector[i] + d->vector[i];
            sum.luminance = c->luminance + d->luminance;
            sum.tones = c->tones + d->tones;
            const double apart = lightprobe__length(c->vector) + lightprobe__length(d->vector);
            const float cost =
                (float)(apart - lightprobe__length(sum.vector)) + lightprobe__tone_gain(&sum, c);
            if (cost >= least) continue;
            least = cost;
            const int brighter = c->luminance >= d->luminance; // keeps its id
            pair[0] = brighter ? a : c->nearby[k];
            pair[1] = brighter ? c->nearby[k] : a;
        }
    }
    return least;
}

// Gives the leaves of b to a, and those of a third cluster behind its planned plane to b.
static void lightprobe__swap(lightprobe__work *w, const int pair[2], int from)
{
    lightprobe__cluster *a = w->clusters + pair[0], *b = w->clusters + pair[1];
    lightprobe__cluster *c = w->clusters + from;
    for (int k = b->first; k < b->first + b->count; k++) w->leaves[w->order[k]].cluster = pair[0];
    for (int k = c->first; k < c->first + c->count; k++) {
        lightprobe__leaf *leaf = w->leaves + w->order[k];
        if (lightprobe__along(c, leaf) >= c->threshold) leaf->cluster = pair[1];
    }
    a->changed = b->changed = c->changed = 1;
    w->gains[pair[0]] = w->gains[pair[1]] = w->gains[from] = 0;
    b->id = -1;
}

// For a moving probe: takes lights from where two do little more than one does, and spends them
// where one is not enough. Only where that gains four times what it costs: a light that changes
// hands jumps. A light that the tolerance can spare by a margin is not spent again.
static void lightprobe__respend(lightprobe__work *w, float total, float tolerance)
{
    float error = 0;
    lightprobe__sort_leaves(w);
    for (int k = 0; k < w->cluster_count; k++) {
        w->clusters[k].changed = 0;
        lightprobe__plan_split(w, w->clusters + k);
        error += lightprobe__cluster_error(w->clusters + k);
    }
    for (int swaps = w->cluster_count / 4; swaps >= 0; swaps--) {
        const int most = lightprobe__largest_gain(w);
        int pair[2] = {0, 0};
        const float cost = lightprobe__cheapest_merge(w, most, pair);
        const int spare = error + cost < 0.8f * tolerance * total;
        if (cost >= FLT_MAX || (!spare && w->gains[most] < 1e-5f * total + 4 * cost)) break;
        if (spare) w->clusters[most].count = 0; // nothing to split off
        error += cost;                          // at most: what the swap gains is not counted
        lightprobe__swap(w, pair, most);
    }
    lightprobe__sum_clusters(w);
    lightprobe__find_near(w);
}

// One cluster of everything, or those of the previous frame's lights.
static void lightprobe__start(lightprobe__work *w, const lightprobe_light *previous, int count)
{
    w->cluster_count = 0;
    for (int i = 0; i < count && w->cluster_count < w->max_lights; i++) {
        lightprobe__cluster *c = w->clusters + w->cluster_count;
        const float *d = previous[i].direction;
        memset(c, 0, sizeof *c);
        if (!lightprobe__is_number(d[0] + d[1] + d[2])) continue;
        memcpy(c->centre, d, sizeof c->centre);
        if (!(lightprobe__normalize(c->centre) > 0)) continue;
        const float luminance = lightprobe__luminance(previous[i].irradiance) * LIGHTPROBE__SCALE;
        c->tone = lightprobe__tone(w, luminance, previous[i].solid_angle);
        c->id = previous[i].id;
        w->cluster_count++;
    }
    if (w->cluster_count == 0) {
        memset(w->clusters, 0, sizeof *w->clusters);
        w->clusters->id = -1;
        w->cluster_count = 1;
    }
    for (int i = 0; i < w->leaf_count; i++) {
        lightprobe__leaf *leaf = w->leaves + i;
        float best = -FLT_MAX;
        for (int k = 0; k < w->cluster_count; k++) {
            const lightprobe__cluster *c = w->clusters + k;
            const float s = lightprobe__nearness(leaf->direction, leaf->tone, c->centre, c->tone);
            if (s <= best) continue;
            best = s;
            leaf->cluster = k;
        }
    }
    lightprobe__sum_clusters(w);
    lightprobe__sort_leaves(w);
}

// ------------------------------------------------------------------------------------------------
// Lights
// ------------------------------------------------------------------------------------------------

// Adds a leaf whose light is spread evenly around its mean direction: the spread is known from the
// length of the vector irradiance, only its shape is not.
static void lightprobe__add_to_region(const lightprobe__leaf *leaf, lightprobe__region *r)
{
    const double f = (double)leaf->luminance, mean = f > 0 ? (double)leaf->strength / f : 0;
    const double spread = 0.5 * f * (1 - mean * mean), along = f * mean * mean - spread;
    const double d[3] = {(double)leaf->direction[0], (double)leaf->direction[1],
                         (double)leaf->direction[2]};
    for (int i = 0; i < 3; i++) {
        r->flux[i] += (double)leaf->flux[i];
        r->vector[i] += f * mean * d[i];
        r->second[i] += along * d[i] * d[i] + spread;
        r->second[3 + i] += along * d[i] * d[(i + 1) % 3];
    }
    r->luminance += f;
    r->solid_angle += (double)leaf->solid_angle;
}

// a^T M b
static double lightprobe__form(const double m[6], const double a[3], const double b[3])
{
    return a[0] * (m[0] * b[0] + m[3] * b[1] + m[5] * b[2]) +
           a[1] * (m[3] * b[0] + m[1] * b[1] + m[4] * b[2]) +
           a[2] * (m[5] * b[0] + m[4] * b[1] + m[2] * b[2]);
}

static float lightprobe__to_float(double x)
{
    const double most = (double)FLT_MAX;
    return x > most ? FLT_MAX : x < -most ? -FLT_MAX : (float)x;
}

// Half-size of the uniform distribution with this variance: d^2 / 3 (4.1.2 of the paper prints d /
// 3). The variance is that of the sine of the angle.
static float lightprobe__half_size(double variance)
{
    const double sine2 = 3 * variance;
    return sine2 < 16.0 / 17 ? (float)sqrt(sine2 > 0 ? sine2 / (1 - sine2) : 0) : 4.0f;
}

// Two unit vectors that make a right-handed frame (e, f, d).
static void lightprobe__frame(const double d[3], double e[3], double f[3])
{
    const double x = fabs(d[0]), y = fabs(d[1]), z = fabs(d[2]);
    const int k = x < y ? (x < z ? 0 : 2) : (y < z ? 1 : 2);
    const double scale = 1 / sqrt(1 - d[k] * d[k]);
    for (int i = 0; i < 3; i++) e[i] = ((i == k) - d[k] * d[i]) * scale;
    for (int i = 0; i < 3; i++)
        f[i] = d[(i + 1) % 3] * e[(i + 2) % 3] - d[(i + 2) % 3] * e[(i + 1) % 3];
}

static void lightprobe__make_light(const lightprobe__region *r, lightprobe_light *light)
{
    const double length = sqrt(r->vector[0] * r->vector[0] + r->vector[1] * r->vector[1] +
                               r->vector[2] * r->vector[2]);
    double d[3] = {0, 1, 0}, e[3], f[3]; // light from all around has no direction: any will do
    for (int i = 0; i < 3; i++)
        if (length > 1e-9 * r->luminance) d[i] = r->vector[i] / length;
    lightprobe__frame(d, e, f);
    // Principal axes of the second moments in the plane across d.
    const double a = lightprobe__form(r->second, e, e), b = lightprobe__form(r->second, e, f);
    const double c = lightprobe__form(r->second, f, f), middle = 0.5 * (a + c);
    const double wide = sqrt(0.25 * (a - c) * (a - c) + b * b);
    const double cos2 = wide > 0 ? 0.5 * (a - c) / wide : 1; // of twice the angle from e to u
    const double cosine = sqrt(0.5 * (1 + cos2)), sine = (b < 0 ? -1 : 1) * sqrt(0.5 * (1 - cos2));
    for (int i = 0; i < 3; i++) {
        light->direction[i] = (float)d[i];
        light->axis_u[i] = (float)(cosine * e[i] + sine * f[i]);
        light->axis_v[i] = (float)(cosine * f[i] - sine * e[i]);
        light->irradiance[i] = lightprobe__to_float(r->flux[i] / (double)LIGHTPROBE__SCALE);
    }
    light->tan_half_u = lightprobe__half_size((middle + wide) / r->luminance);
    light->tan_half_v = lightprobe__half_size((middle - wide) / r->luminance);
    light->solid_angle = (float)(r->solid_angle / (double)LIGHTPROBE__SCALE);
    // The disc whose mean direction is as long as the region's: R = (1 + cos alpha) / 2.
    const double cos_alpha = 2 * length / r->luminance - 1;
    light->cos_alpha = cos_alpha < 1 ? (float)cos_alpha : 1;
}

// ------------------------------------------------------------------------------------------------
// The paper's way: median cut (image-based lighting paper, sections 3.1 and 4.1)
// ------------------------------------------------------------------------------------------------

// Texels [x0, x1) x [y0, y1) of a face.
typedef struct lightprobe__rectangle {
    int face, x0, y0, x1, y1;
} lightprobe__rectangle;

// Luminance of a texel times its solid angle; adds up RGB if asked.
static double lightprobe__texel_flux(const lightprobe__work *w, int face, int x, int y,
                                     double *flux)
{
    float rgb[3];
    lightprobe__read(lightprobe__texel(w, face, x, y), rgb);
    const float omega = w->omega[lightprobe__quarter(w, x, y)];
    for (int i = 0; flux && i < 3; i++) flux[i] += (double)(rgb[i] * omega);
    return (double)(lightprobe__luminance(rgb) * omega);
}

// Cuts across the longer side where the luminance is halved; 0 for a single texel. The sums of the
// columns (or rows) go into profile, side doubles.
static int lightprobe__cut(const lightprobe__work *w, double *profile, lightprobe__rectangle *a,
                           lightprobe__rectangle *b)
{
    const int wide = a->x1 - a->x0 >= a->y1 - a->y0;
    const int length = wide ? a->x1 - a->x0 : a->y1 - a->y0;
    if (length < 2) return 0;
    double whole = 0, sum = 0;
    for (int i = 0; i < length; i++) profile[i] = 0;
    for (int y = a->y0; y < a->y1; y++)
        for (int x = a->x0; x < a->x1; x++)
            profile[wide ? x - a->x0 : y - a->y0] += lightprobe__texel_flux(w, a->face, x, y, NULL);
    for (int i = 0; i < length; i++) whole += profile[i];
    int at = 1;
    double nearest = 2 * whole;
    for (int i = 1; i < length && whole > 0; i++) {
        sum += profile[i - 1];
        const double off = fabs(2 * sum - whole);
        if (off >= nearest) continue;
        nearest = off;
        at = i;
    }
    *b = *a;
    if (wide)
        a->x1 = b->x0 = a->x0 + at;
    else
        a->y1 = b->y0 = a->y0 + at;
    return 1;
}

// Breadth first: the rectangle that has waited longest is next. Returns how many there are; the
// queue is a ring of max_lights places (at least 6).
static int lightprobe__median_cut(const lightprobe__work *w, lightprobe__rectangle *ring,
                                  int capacity, double *profile, int *ring_first)
{
    int count = 6, first = 0, stuck = 0;
    for (int face = 0; face < 6; face++) {
        const lightprobe__rectangle whole = {face, 0, 0, w->side, w->side};
        ring[face] = whole;
    }
    while (count < capacity && stuck < count) {
        lightprobe__rectangle a = ring[first], b;
        const int cut = lightprobe__cut(w, profile, &a, &b);
        first = (first + 1) % capacity;
        ring[(first + count - 1) % capacity] = a;
        if (cut) ring[(first + count++) % capacity] = b;
        stuck = cut ? 0 : stuck + 1;
    }
    *ring_first = first;
    return count;
}

// Eq. 9, 10 (with 4.1.2 mended: variance = d^2 / 3) and 11 of one rectangle; returns its error. The
// size is also divided by the distance of the centroid from the origin, so that it is one at
// distance 1.
static double lightprobe__paper_light(const lightprobe__work *w, const lightprobe__rectangle *r,
                                      lightprobe_light *light, double *luminance)
{
    double f = 0, m[4] = {0}, flux[3] = {0}, v[3] = {0}, size[2];
    for (int y = r->y0; y < r->y1; y++) {
        for (int x = r->x0; x < r->x1; x++) {
            const double l = lightprobe__texel_flux(w, r->face, x, y, flux);
            const double s = (double)lightprobe__centre(w->side, x);
            const double t = (double)lightprobe__centre(w->side, y);
            const double d = l / sqrt(1 + s * s + t * t);
            f += l;
            m[0] += l * s;
            m[1] += l * t;
            m[2] += l * s * s;
            m[3] += l * t * t;
            v[0] += d;
            v[1] += d * s;
            v[2] += d * t;
        }
    }
    *luminance = f;
    if (!(f > 0)) return 0;
    for (int i = 0; i < 4; i++) m[i] /= f;
    for (int i = 0; i < 2; i++) {
        const double variance = m[2 + i] - m[i] * m[i];
        size[i] = variance > 0 ? sqrt(3 * variance) : 0;
    }
    const double distance = sqrt(1 + m[0] * m[0] + m[1] * m[1]);
    lightprobe_texel_direction(r->face, (float)m[0], (float)m[1], light->direction);
    for (int i = 0; i < 2; i++) {
        float *axis = i ? light->axis_v : light->axis_u;
        const float *side = lightprobe__axes[r->face][1 + i];
        const float along = lightprobe__dot(side, light->direction);
        for (int k = 0; k < 3; k++) axis[k] = side[k] - along * light->direction[k];
        const double half = size[i] * (double)lightprobe__normalize(axis) / distance;
        *(i ? &light->tan_half_v : &light->tan_half_u) = (float)(half < 4 ? half : 4);
    }
    for (int i = 0; i < 3; i++)
        light->irradiance[i] = lightprobe__to_float(flux[i] / (double)LIGHTPROBE__SCALE);
    const double h = 2.0 / w->side;
    light->solid_angle =
        (float)lightprobe__solid_angle(r->x0 * h - 1, r->y0 * h - 1, r->x1 * h - 1, r->y1 * h - 1);
    // The paper does not say how its discs follow from its rectangles: with the same solid angle.
    const double disc =
        lightprobe__solid_angle(m[0] - size[0], m[1] - size[1], m[0] + size[0], m[1] + size[1]);
    light->cos_alpha = (float)(1 - disc / 6.283185307179586);
    return f - sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

// ------------------------------------------------------------------------------------------------
// Extraction
// ------------------------------------------------------------------------------------------------

// Lights of clusters that are bright enough, brightest first unless they carry on from a previous
// frame. Returns how many.
static int lightprobe__write_lights(lightprobe__work *w, int animated, float least,
                                    lightprobe_light *out)
{
    int count = 0, next_id = 0;
    memset(w->regions, 0, (size_t)w->cluster_count * sizeof *w->regions);
    for (int i = 0; i < w->leaf_count; i++)
        lightprobe__add_to_region(w->leaves + i, w->regions + w->leaves[i].cluster);
    for (int k = 0; k < w->cluster_count; k++) {
        if (!(w->regions[k].luminance > 0) || w->regions[k].luminance < (double)least) continue;
        int at = count++;
        for (; at > 0 && !animated; at--) {
            if (w->regions[w->order[at - 1]].luminance >= w->regions[k].luminance) break;
            w->order[at] = w->order[at - 1];
        }
        w->order[at] = k;
    }
    for (int k = 0; k < w->cluster_count; k++)
        if (w->clusters[k].id >= next_id && w->clusters[k].id < INT_MAX - LIGHTPROBE_MAX_LIGHTS)
            next_id = w->clusters[k].id + 1;
    for (int i = 0; i < count; i++) {
        lightprobe__make_light(w->regions + w->order[i], out + i);
        out[i].id = w->clusters[w->order[i]].id;
        if (out[i].id < 0) out[i].id = next_id++;
    }
    return count;
}

// Everything but the checks of arguments.
static int lightprobe__best(lightprobe__work *w, const lightprobe_settings *settings, float total,
                            lightprobe_light *lights, float *error)
{
    const int animated = settings->previous && settings->previous_count > 0;
    lightprobe__make_leaves(w, total);
    lightprobe__start(w, settings->previous, animated ? settings->previous_count : 0);
    lightprobe__divide(w, total, settings->tolerance);
    lightprobe__sum_clusters(w);
    lightprobe__find_near(w);
    // The start from previous lights was a round already; one a frame keeps the steps small.
    if (animated) lightprobe__respend(w, total, settings->tolerance);
    else lightprobe__relax(w, LIGHTPROBE__ROUNDS);
    *error = 0;
    for (int k = 0; k < w->cluster_count; k++) *error += lightprobe__cluster_error(w->clusters + k);
    *error /= total;
    return lightprobe__write_lights(w, animated, settings->min_share * total, lights);
}

static int lightprobe__paper(lightprobe__work *w, const lightprobe_settings *settings, float total,
                             lightprobe_light *lights, float *error)
{
    // The memory of the leaves (64 bytes each, more than one per light) holds the ring, that of the
    // band (over 100 bytes per row of texels) the profile.
    lightprobe__rectangle *ring = (lightprobe__rectangle *)(void *)w->leaves;
    double *profile = (double *)(void *)w->band;
    int first, written = 0;
    const int capacity = w->max_lights > 6 ? w->max_lights : 6;
    const int count = lightprobe__median_cut(w, ring, capacity, profile, &first);
    double sum = 0;
    for (int i = 0; i < count; i++) {
        lightprobe_light light;
        double luminance;
        sum += lightprobe__paper_light(w, ring + (first + i) % capacity, &light, &luminance);
        if (!(luminance > 0) || luminance < (double)(settings->min_share * total)) continue;
        if (written == w->max_lights) continue;
        light.id = written;
        lights[written++] = light;
    }
    *error = (float)(sum / (double)total);
    return written;
}

static lightprobe_result lightprobe__fail(const lightprobe_settings *settings,
                                          lightprobe_result result)
{
    if (settings->log) settings->log(settings->user, lightprobe_result_string(result));
    return result;
}

static lightprobe_result lightprobe__check(const lightprobe_cube *cube,
                                           const lightprobe_settings *s)
{
    if (!cube) return LIGHTPROBE_ERROR_NULL;
    for (int face = 0; face < 6; face++)
        if (!cube->face[face]) return LIGHTPROBE_ERROR_NULL;
    if (cube->side < 1 || cube->side > LIGHTPROBE_MAX_SIDE) return LIGHTPROBE_ERROR_SIDE;
    if (cube->channels != 3 && cube->channels != 4) return LIGHTPROBE_ERROR_CHANNELS;
    if (s->max_lights < 0 || s->max_lights > LIGHTPROBE_MAX_LIGHTS) return LIGHTPROBE_ERROR_LIGHTS;
    if (s->previous_count < 0 || s->previous_count > LIGHTPROBE_MAX_LIGHTS)
        return LIGHTPROBE_ERROR_LIGHTS;
    if (!lightprobe__is_number(s->tolerance) || s->tolerance < 0) return LIGHTPROBE_ERROR_SETTINGS;
    if (!lightprobe__is_number(s->min_share) || s->min_share < 0) return LIGHTPROBE_ERROR_SETTINGS;
    if (s->mode != LIGHTPROBE_BEST && s->mode != LIGHTPROBE_MEDIAN_CUT)
        return LIGHTPROBE_ERROR_SETTINGS;
    return LIGHTPROBE_OK;
}

lightprobe_result lightprobe_extract(const lightprobe_cube *cube,
                                     const lightprobe_settings *settings, void *scratch,
                                     size_t scratch_bytes, lightprobe_light *lights,
                                     int *light_count, lightprobe_stats *stats)
{
    lightprobe__work work;
    lightprobe_settings s;
    memset(&work, 0, sizeof work);
    memset(&s, 0, sizeof s);
    if (settings) s = *settings;
    lightprobe_result result = lightprobe__check(cube, &s);
    if (!result && (!scratch || !lights || !light_count)) result = LIGHTPROBE_ERROR_NULL;
    if (result) return lightprobe__fail(&s, result);
    if (s.max_lights == 0) {
        s.max_lights = LIGHTPROBE_DEFAULT_LIGHTS;
        if (!(s.tolerance > 0)) s.tolerance = LIGHTPROBE_DEFAULT_TOLERANCE;
    }
    if (s.tolerance > 1) s.tolerance = 1;
    if (s.min_share > 1) s.min_share = 1;
    if (scratch_bytes < lightprobe_scratch_bytes(cube->side, s.max_lights))
        return lightprobe__fail(&s, LIGHTPROBE_ERROR_SCRATCH);

    lightprobe__layout(&work, (char *)scratch + (15 & (0 - (uintptr_t)scratch)), cube->side,
                       s.max_lights);
    work.cube = cube;
    lightprobe__make_tables(&work);
    lightprobe__sum_tiles(&work);
    lightprobe__make_pyramid(&work);
    const float total = lightprobe__find_total(&work);
    float error = 0;
    int count = 0;  // a black probe has no lights
    if (total >= LIGHTPROBE__BLACK) {
        count = (s.mode == LIGHTPROBE_MEDIAN_CUT ? lightprobe__paper : lightprobe__best)(
            &work, &s, total, lights, &error);
    }
    *light_count = count;
    if (!stats) return LIGHTPROBE_OK;
    for (int i = 0; i < 3; i++) {
        const double all = work.total[i] / (double)LIGHTPROBE__SCALE;
        double carried = 0;
        for (int k = 0; k < count; k++) carried += (double)lights[k].irradiance[i];
        stats->total[i] = lightprobe__to_float(all);
        stats->residual[i] = lightprobe__to_float(all - carried);
    }
    stats->error = error > 0 ? error : 0;
    stats->lights = count;
    stats->repaired_texels = work.repaired;
    return LIGHTPROBE_OK;
}

const char *lightprobe_result_string(lightprobe_result result)
{
    switch (result) {
    case LIGHTPROBE_OK:
        return "lightprobe: no error";
    case LIGHTPROBE_ERROR_NULL:
        return "lightprobe: a pointer that must be given is null";
    case LIGHTPROBE_ERROR_SIDE:
        return "lightprobe: the side of the cube's faces must be 1 to 8192";
    case LIGHTPROBE_ERROR_CHANNELS:
        return "lightprobe: texels must have 3 or 4 channels";
    case LIGHTPROBE_ERROR_LIGHTS:
        return "lightprobe: max_lights and previous_count must be 0 to 4096";
    case LIGHTPROBE_ERROR_SETTINGS:
        return "lightprobe: tolerance and min_share must be 0 or more, mode one of lightprobe_mode";
    case LIGHTPROBE_ERROR_SCRATCH:
        return "lightprobe: less scratch memory than lightprobe_scratch_bytes() asks for";
    }
    return "lightprobe: unknown result";
}

// ------------------------------------------------------------------------------------------------
// GLSL
// ------------------------------------------------------------------------------------------------

#if defined __GNUC__
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Woverlength-strings"
#endif
static const char lightprobe__glsl_text[] =
    "#define LIGHTPROBE_SHARED\n"
    "#define sqrtf sqrt\n"
    "#define fabsf abs\n"
    // [glsl text begin] made by "make glsl", do not edit
    "// The angle of the point (x, y) with y >= 0 to the x axis, in [0, pi], to 3e-7. Written out\n"
    "// (Hastings' polynomial) since GLSL allows its own atan 4096 units in the last place.\n"
    "LIGHTPROBE_SHARED float lightprobe_angle(float y, float x)\n"
    "{\n"
    "    float ax = fabsf(x);\n"
    "    float most = ax < y ? y : ax;\n"
    "    float t = most > 0.0f ? (ax < y ? ax : y) / most : 0.0f;\n"
    "    float t2 = t * t;\n"
    "    float p = 0.0028662257f;\n"
    "    p = p * t2 - 0.0161657367f;\n"
    "    p = p * t2 + 0.0429096138f;\n"
    "    p = p * t2 - 0.0752896400f;\n"
    "    p = p * t2 + 0.1065626393f;\n"
    "    p = p * t2 - 0.1420889944f;\n"
    "    p = p * t2 + 0.1999355085f;\n"
    "    p = p * t2 - 0.3333314528f;\n"
    "    p = p * t2 * t + t;\n"
    "    p = ax < y ? 1.57079633f - p : p;\n"
    "    return x < 0.0f ? 3.14159265f - p : p;\n"
    "}\n"
    "\n"
    "// Half the line integral of r x dr around what the horizon leaves of the disc: psi is half its\n"
    "// arc of the horizon, phi half the rim above it (docs/lightprobe.md).\n"
    "float lightprobe_disc_irradiance(float cos_alpha, float cos_theta)\n"
    "{\n"
    "    float c = cos_alpha > -1.0f ? (cos_alpha < 1.0f ? cos_alpha : 1.0f) : -1.0f;\n"
    "    float n = cos_theta > -1.0f ? (cos_theta < 1.0f ? cos_theta : 1.0f) : -1.0f;\n"
    "    float size = 1.0f - c;\n"
    "    float sin_alpha = sqrtf(size * (1.0f + c));\n"
    "    float chord2 = (sin_alpha - n) * (sin_alpha + n);\n"
    "    if (chord2 <= 0.0f) {                            // the horizon misses the rim\n"
    "        float below = c < 0.0f ? 0.5f / size : 0.0f; // of the disc opposite\n"
    "        float seen = c < 0.0f ? (n < 0.0f ? n : 0.0f) : (n > 0.0f ? n : 0.0f);\n"
    "        float whole = below + 0.5f * (1.0f + c) * seen;\n"
    "        return whole > 0.0f ? whole : 0.0f;\n"
    "    }\n"
    "    float chord = sqrtf(chord2);\n"
    "    float sin_theta2 = (1.0f - n) * (1.0f + n);\n"
    "    float s2 = chord2 / sin_theta2; // sin^2 psi\n"
    "    float arc;                      // psi - sin psi cos psi\n"
    "    if (c > 0.0f && s2 < 0.0625f) {\n"
    "        // The difference would lose all digits: it is 2/3 psi^3, and a sun has psi < 5e-3.\n"
    "        // Series of asin x - x sqrt(1 - x^2); the first term left out is 1e-7 of the sum.\n"
    "        arc = 0.03976073f;\n"
    "        arc = arc * s2 + 0.04971591f;\n"
    "        arc = arc * s2 + 0.06944444f;\n"
    "        arc = arc * s2 + 0.10714286f;\n"
    "        arc = arc * s2 + 0.2f;\n"
    "        arc = arc * s2 + 0.66666667f;\n"
    "        arc = arc * s2 * sqrtf(s2);\n"
    "    } else {\n"
    "        arc = lightprobe_angle(chord, c) - chord * c / sin_theta2;\n"
    "    }\n"
    "    float e = (arc + n * n * chord * c / sin_theta2) / size;\n"
    "    e = 0.15915494f * (e + (1.0f + c) * n * lightprobe_angle(chord, -c * n));\n"
    "    return e > 0.0f ? (e < 1.0f ? e : 1.0f) : 0.0f;\n"
    "}\n"
    // [glsl text end]
    "#undef LIGHTPROBE_SHARED\n"
    "#undef sqrtf\n"
    "#undef fabsf\n";
#if defined __GNUC__
#pragma GCC diagnostic pop
#endif

const char *lightprobe_glsl_math(void)
{
    return lightprobe__glsl_text;
}

#ifdef __cplusplus
}
#endif

#endif // LIGHTPROBE_IMPLEMENTATION

// ================================================================================================
// References
//
//   Kneiphof (supervised by Krumpen): Real-Time Image-Based Lighting of Dynamic Scenes with Moment
//       Soft Shadow Mapping, CESCG 2017. "The paper" above; equation numbers are its own. Mended:
//       Eq. 8 (exponent -3/2), 4.1.2 (the variance is d^2/3), Eq. 18 (only above the horizon).
//   Debevec: A Median Cut Algorithm for Light Probe Sampling, SIGGRAPH 2005 posters.
//   van Oosterom, Strackee: The Solid Angle of a Plane Triangle, IEEE Trans. Biomed. Eng. 30, 1983.
//   Lloyd: Least Squares Quantization in PCM, IEEE Trans. Inf. Theory 28, 1982.
//   Hastings: Approximations for Digital Computers, Princeton 1955, sheet 13.
//
// Changelog
//
//   0.1  first version
//
// Licence: choose whichever of the two you prefer.
//
// A - MIT License
//
//   Copyright (c) 2026 the mssm authors
//
//   Permission is hereby granted, free of charge, to any person obtaining a copy of this software
//   and associated documentation files (the "Software"), to deal in the Software without
//   restriction, including without limitation the rights to use, copy, modify, merge, publish,
//   distribute, sublicense, and/or sell copies of the Software, and to permit persons to whom the
//   Software is furnished to do so, subject to the following conditions:
//
//   The above copyright notice and this permission notice shall be included in all copies or
//   substantial portions of the Software.
//
//   THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING
//   BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND
//   NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM,
//   DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING
//   FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.
//
// B - Public Domain (www.unlicense.org)
//
//   This is free and unencumbered software released into the public domain.
//
//   Anyone is free to copy, modify, publish, use, compile, sell, or distribute this software,
//   either in source code form or as a compiled binary, for any purpose, commercial or
//   non-commercial, and by any means.
//
//   In jurisdictions that recognize copyright laws, the author or authors of this software
//   dedicate any and all copyright interest in the software to the public domain. We make this
//   dedication for the benefit of the public at large and to the detriment of our heirs and
//   successors. We intend this dedication to be an overt act of relinquishment in perpetuity of
//   all present and future rights to this software under copyright law.
//
//   THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING
//   BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND
//   NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER
//   LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT OF OR IN
//   CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.
