// mssm.h - v0.2 - moment soft shadow mapping - MIT or public domain, at your choice (see >>licence)
// SPDX-License-Identifier: MIT OR Unlicense
//
// Soft shadows of area lights in constant time per receiver. A shadow map is turned into a few
// moments of depth per texel; a summed-area table gives the moments of any rectangle of it; and
// from four or six moments follow sharp bounds on the share of the light that a receiver sees. This
// header holds the moment math (usable and testable on its own), the tables, the search for
// blockers, the filter, and the same math as GLSL text. No dependency but the C standard library.
//
// QUICK START
//
// In ONE source file:
//
//     #define MSSM_IMPLEMENTATION
//     #include "mssm.h"
//
// In all others only the #include. Visibility of one point under one light:
//
//     float visibility_of(const float *depth_256x256, const float point[3])
//     {
//         static unsigned char memory[3 << 20];
//         const float to_light[3] = {0.3f, 0.9f, 0.3f}, axis[3] = {1, 0, 0};
//         const float box_min[3] = {-2, 0, -2}, box_max[3] = {2, 2, 2};  // of the casters
//         mssm_light light;
//         mssm_map *map;
//         if (mssm_light_directional(&light, to_light, axis, 0.1f, 0.1f, box_min, box_max))
//             return 1;
//         if (mssm_map_init(&map, memory, sizeof memory, 256, 6)) return 1;
//         // depth_256x256 was drawn with light.world_to_shadow
//         if (mssm_map_update(map, depth_256x256, NULL, 1)) return 1;
//         return mssm_map_visibility(map, &light, NULL, point);
//     }
//
// The moment math alone, with two surfaces at depths -0.5 (30% of the texels) and 0.5 (70%):
//
//     mssm_bounds two_surfaces(void)
//     {
//         const mssm_moments4 a = mssm_moments4_of_depth(-0.5f), b = mssm_moments4_of_depth(0.5f);
//         mssm_moments4 m;
//         for (int k = 0; k < 4; k++) m.b[k] = 0.3f * a.b[k] + 0.7f * b.b[k];
//         return mssm_visibility4(mssm_moments4_bias(m, 1e-6f), 0.0f);  // both bounds close to 0.7
//     }
//
// CONTENTS: search for the mark. Calls come first, then what is behind them in the same order
//
//   >>math calls        moments, bias, bounds         >>math >>bounds >>roots >>stored
//   >>light calls       lights, frusta, falloffs      >>lights
//   >>map calls         soft shadows on the CPU       >>tables >>estimators
//   >>filtered calls    filtered hard shadows         >>filtered
//   >>scattering calls  light shafts                  >>scattering
//   >>text calls        GLSL for your own pipeline    >>texts
//   >>gl calls          the OpenGL 4.5 half           >>gl >>shaders >>plumbing >>state >>passes
//                                                     >>filtered gl
//   >>licence           references, licence
//   >>generated         quoted GLSL: nothing to read, nothing to edit
//
// GLSL TEXTS, after #version; each counts once in a shader
//
//   mssm_glsl_math()           moment math; before the next three
//   mssm_glsl_shading()        estimators over tables of your own
//   mssm_glsl_scattering()     visibility along view rays
//   mssm_glsl_translucent()    for fragment shaders of translucent casters
//   mssm_glsl_lights()         falloffs, faces of point lights; needs none
//   mssm_gl_shader(gl)         visibility in the maps of one mssm_gl; needs none. Several in any order
//
// CONVENTIONS
//
//   depth z       in [-1,1], -1 nearest the light, linear in the distance along the light's axis,
//                 also for perspective (spot) lights. 1 where nothing is hit.
//   moments       b[k] = E[z^(k+1)]. The zeroth moment is 1 and is not stored.
//   visibility    1 where the whole light is seen. All bounds are bounds on visibility.
//   lights        direction points from the scene to the light. Sizes are tangents of half-angles
//                 (directional) or half-widths in world units (spot), whatever the size of the map.
//   matrices      column-major float[16], column vectors, right-handed world space.
//   shadow space  x, y in [-1,1] over the map; texel (column i, row j) covers x in
//                 [-1 + 2i/side, -1 + 2(i+1)/side] and y likewise with j.
//
// MACROS, each to be defined before the #include
//
//   MSSM_IMPLEMENTATION   in one source file: compiles the functions
//   MSSM_STATIC           in the only file that uses it: the functions are static
//   MSSM_API              everywhere: what stands before each function, __declspec(dllexport) say
//   MSSM_NO_GL            there: leaves out the OpenGL half, which needs no GL header or library
//   MSSM_NO_FILTERED      everywhere: leaves out filtered hard shadows and translucent casters
//   MSSM_NO_SCATTERING    everywhere: leaves out the math of light shafts
//   MSSM_MALLOC(bytes), MSSM_FREE(memory)   there: for the OpenGL half; the rest never allocates
//
// Threads: no global state. Functions that take a const map may run in parallel on one map.
// Floats: any finite input gives finite output. NaN and infinity are treated as a number at an end
// of the valid range; depths that are not finite as 1, nothing hit.

#ifndef MSSM_H
#define MSSM_H

#include <stddef.h>

#define MSSM_VERSION 200 // 10000 * major + 100 * minor + patch

#ifndef MSSM_API
#ifndef MSSM_STATIC
#define MSSM_API
#elif defined __GNUC__
#define MSSM_API static __attribute__((unused))
#else
#define MSSM_API static
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

// ---- Moment math ---- >>math calls

// [glsl begin]
// clang-format off
typedef struct mssm_moments4 { float b[4]; } mssm_moments4;
typedef struct mssm_moments6 { float b[6]; } mssm_moments6;
typedef struct mssm_points3 { float z[3], w[3]; } mssm_points3;
typedef struct mssm_points4 { float z[4], w[4]; } mssm_points4;
typedef struct mssm_bounds { float lower, upper; } mssm_bounds;
typedef struct mssm_roots3 { float x[3]; int count; } mssm_roots3;
// clang-format on
// [glsl end]

// The moments z, z^2, ... of one depth. z is clamped to [-1,1]; NaN counts as 1, nothing hit.
// Moments of several depths are the weighted mean of these: that is what makes them filterable.
MSSM_API mssm_moments4 mssm_moments4_of_depth(float z);
MSSM_API mssm_moments6 mssm_moments6_of_depth(float z);

// How strongly moments must be pulled towards the bias vector so that rounding cannot leave the set
// of valid moments, per storage format (docs/moments.md, "Bias"; printed by `make bias`). A larger
// value leaks a little more light, a smaller one lets false shadows of up to its size through.
#define MSSM_BIAS4_FLOAT32 4.8e-7f // moments as float; mssm_moments*_bias
#define MSSM_BIAS6_FLOAT32 2.2e-6f
#define MSSM_BIAS4_UNORM16 1.9e-5f // encoded, stored once in 16 bits; mssm_moments*_bias_encoded
#define MSSM_BIAS6_UNORM16 3.5e-5f // (mssm_moments*_bias would need 2.2e-5 and 5.2e-5)
#define MSSM_BIAS4_UNORM16_FILTERED 5.6e-5f // the same, stored by a resolve and two blur passes
#define MSSM_BIAS6_UNORM16_FILTERED 1.05e-4f
// Tables of this header as mssm_map_visibility uses them, and what mssm_map_moments gives. Proved
// for kernels of up to 27 texels; coarser levels round once more each, at the very worst 2.2 times
// as much at level 4. Sampled maps need less than half.
#define MSSM_BIAS4_TABLE 7.0e-7f
#define MSSM_BIAS6_TABLE 1.3e-6f
#define MSSM_BIAS4_DECODED 1.4e-6f
#define MSSM_BIAS6_DECODED 4.0e-6f

// (1 - alpha) m + alpha m*, m* the bias vector that repairs the rounding of moments kept as float32
// with the least alpha. alpha is clamped to [0,1].
MSSM_API mssm_moments4 mssm_moments4_bias(mssm_moments4 m, float alpha);
MSSM_API mssm_moments6 mssm_moments6_bias(mssm_moments6 m, float alpha);
// The same with the vector that is best for moments which were stored encoded (16 bits, tables).
MSSM_API mssm_moments4 mssm_moments4_bias_encoded(mssm_moments4 m, float alpha);
MSSM_API mssm_moments6 mssm_moments6_bias_encoded(mssm_moments6 m, float alpha);

// Storage form: the moments of the Chebyshev polynomials of depth, (E[T_k(z)] + 1) / 2 for k = 1...
// Each value fills [0,1] (and is clamped to it), so it suits 16-bit textures and integer tables.
// The first four values of six are the encoded four moments. decode undoes encode.
MSSM_API mssm_moments4 mssm_moments4_encode(mssm_moments4 m);
MSSM_API mssm_moments4 mssm_moments4_decode(mssm_moments4 q);
MSSM_API mssm_moments6 mssm_moments6_encode(mssm_moments6 m);
MSSM_API mssm_moments6 mssm_moments6_decode(mssm_moments6 q);

// Sharp bounds on visibility, 1 - P(depth < z), over all distributions with the moments m, already
// biased. 0 <= lower <= upper <= 1; the upper bound never darkens a lit surface. Moments of no
// distribution give the bounds of the longest valid part of them (4, 2).
MSSM_API mssm_bounds mssm_visibility4(mssm_moments4 m, float z);
MSSM_API mssm_bounds mssm_visibility6(mssm_moments6 m, float z);

// The same for count elements: b[k][i] is moment k+1 of element i. gcc vectorises the loops with
// -O3 -fno-math-errno -fno-trapping-math, clang with -O2 -fno-math-errno.
MSSM_API void mssm_visibility4_array(int count, const float *const b[4], const float *z,
                                     float *lower, float *upper);
MSSM_API void mssm_visibility6_array(int count, const float *const b[6], const float *z,
                                     float *lower, float *upper);

// The distribution with the fewest depths that has the moments m and z among its depths (canonical
// representation): z[0] is the given depth, the others ascend, w are their shares, sum 1. Depths
// that would lie at infinity are put far outside with a share of about 0.
MSSM_API mssm_points3 mssm_reconstruct4(mssm_moments4 m, float z);
MSSM_API mssm_points4 mssm_reconstruct6(mssm_moments6 m, float z);

// Mean depth of the blockers nearer than z, with the receiver's own share as one more at z, clamped
// to [self_weight_min, self_weight_max]: 1e-3, 1e-3 for the lower estimate (image-based lighting
// paper, Eq. 7), 1e-3, 1 for the upper one (Eq. 19). In [-1,z]; z without blockers.
MSSM_API float mssm_blocker_depth4(mssm_moments4 m, float z, float self_weight_min,
                                   float self_weight_max);
MSSM_API float mssm_blocker_depth6(mssm_moments6 m, float z, float self_weight_min,
                                   float self_weight_max);

// Real roots of c0 + c1 x + c2 x^2 + c3 x^3, ascending; multiple roots are repeated. A pair that
// rounding of the coefficients may have made complex counts as a double root. Zero leading
// coefficients lower the degree; count is 0 for a constant. Unused x are 0. Roots are right
// to their last digits down to 1e-28 of the largest; beyond 1e18 they count as infinite. Roots
// below 1e-37, and coefficients below 1e-36 of the largest, may count as 0.
MSSM_API mssm_roots3 mssm_solve_cubic(float c0, float c1, float c2, float c3);

// ---- Lights ---- >>light calls

typedef enum mssm_result {
    MSSM_OK = 0,
    MSSM_ERROR_ARGUMENT,   // a null pointer, a number that is not finite or out of its range
    MSSM_ERROR_MEMORY,     // the memory passed in is too small, or malloc has none
    MSSM_ERROR_GL_VERSION, // not OpenGL 4.5, or the loader does not find a function of it
    MSSM_ERROR_GL,   // a shader, a framebuffer or storage that the driver refuses: see the log
    MSSM_ERROR_ORDER // a call between begin and end, or an end without a begin
} mssm_result;

// One line for people. Never null.
MSSM_API const char *mssm_result_string(mssm_result r);

// A light and its frustum, from one of the functions below or filled in by hand.
typedef struct mssm_light {
    // clip = M (p,1), fit for gl_Position; shadow-space x, y = clip.xy / clip.w. Depth is clip.z
    // for directional lights, else linear in clip.w, the distance along the axis.
    float world_to_shadow[16];
    int perspective;      // 0: directional
    float half_u, half_v; // directional: tangents of half-angles; spot: half-widths, world units
    // Directional: half-size of the frustum, world units; spot: tan_half_fov.
    float extent_u, extent_v;
    float z_near, z_far; // distances of depth -1 and 1, world units; directional: their difference
} mssm_light;

// A light at infinity: a rectangle of the sky with tangents of half-angles tan_half_u, tan_half_v
// >= 0 along axis_u and across it. The frustum is fitted to the box of the casters, 1/64 wider;
// receivers may lie outside. Where casters go on beyond the box (a cascade, a camera's
// surroundings), what the map holds at its rim stands for them; otherwise all is lit there. Keep
// the box close to the casters, or call mssm_light_fit: past casters nearer to their receivers than
// .2% of its depth the moment bias lightens penumbras, and umbras as far in as one and a half
// penumbras: these to .03 at .1%, .1 at .05%, .7 at .01% (4 moments: .08, .25, .9). direction may
// have any length; axis_u is made orthogonal to it or replaced. Fails, with light untouched, on
// numbers that are not finite, a zero direction, box_min > box_max.
MSSM_API mssm_result mssm_light_directional(mssm_light *light, const float direction[3],
                                            const float axis_u[3], float tan_half_u,
                                            float tan_half_v, const float box_min[3],
                                            const float box_max[3]);

// A rectangle of half_width_u by half_width_v >= 0 (world units) at position, shining along
// -direction into a square pyramid of half-angle tangent tan_half_fov > 0 between the distances 0 <
// z_near < z_far. Casters must lie between the two, receivers may lie further off. A near plane
// close to the light costs nothing but depth precision (mssm_light_fit). The map's rim stands for
// casters beyond the sides; further out all counts as lit: the cone's falloff is the caller's.
// Fails as above.
MSSM_API mssm_result mssm_light_spot(mssm_light *light, const float position[3],
                                     const float direction[3], const float axis_u[3],
                                     float tan_half_fov, float z_near, float z_far,
                                     float half_width_u, float half_width_v);

// A rectangle of tangents of half-angles tan_half_u, tan_half_v at this distance from a probe, as
// in lightprobe_light. A spot light that covers the casters' box; where its plane meets the box, or
// the box is wider than a tangent of 3, it moves away by as much as it takes, and grows with it. A
// directional light for distance 0, infinity, and where the box is narrower than 1/512 or 1/64 of
// the smaller half-angle: visibility differs by less than 1/64. Fails as above, or if distance < 0.
MSSM_API mssm_result mssm_light_area(mssm_light *light, const float probe[3],
                                     const float direction[3], const float axis_u[3],
                                     float tan_half_u, float tan_half_v, float distance,
                                     const float box_min[3], const float box_max[3]);

// Shadow-space x, y, depth of a world-space point: what a depth map for mssm_map_update must hold.
// Returns 0, with shadow untouched, where a point has none (behind a spot light, not finite, NULL).
MSSM_API int mssm_light_project(const mssm_light *light, const float point[3], float shadow[3]);

// The six frusta of a light that shines everywhere: +x, -x, +y, -y, +z, -z. Each is a square of
// half_width >= 0 that faces its side, and reaches far enough beyond its 90 degrees that no kernel
// leaves it: by half_width / z_near, so z_near should be near the nearest caster. Fails as above.
MSSM_API mssm_result mssm_light_point(mssm_light light[6], const float position[3], float z_near,
                                      float z_far, float half_width);

// For a box that follows the camera: moves the frustum of a directional light sideways by at most
// half a texel of its map, so that the texels lie on the same places of the world whatever the box,
// as long as its size stays, and edges of shadows do not crawl. Leave that much of a margin in the
// box. Fails, with light untouched, for perspective lights and side < 1.
MSSM_API mssm_result mssm_light_snap(mssm_light *light, int side);

// The same light with its depth range fitted to its own map, nearest to farthest
// (mssm_depth_range): for precision, where planes set by hand are hundreds of times further apart
// than the casters are deep. For the next map: what lies before nearest is cut off, so leave a
// margin if casters move. Fails, with light untouched, unless -1 <= nearest <= farthest <= 1.
MSSM_API mssm_result mssm_light_fit(mssm_light *light, float nearest, float farthest);

// Least and greatest depth of count that something was drawn at; 0 where nothing was (all are 1).
MSSM_API int mssm_depth_range(const float *depth, size_t count, float *nearest, float *farthest);

// Depth z of what a GPU has stored as window depth, 0 to 1 or reversed, with the planes of the
// light: what mssm_map_update wants, element by element. On the GPU it is mssm_gl_set_depth.
MSSM_API float mssm_light_depth(const mssm_light *light, float stored, int reversed);

// [glsl begin lights]
// Faces of mssm_light_point that a receiver asks, and their weights, sum 1. Next to an edge of the
// cube two or three faces have a share, so that nothing jumps there; else the others have 0.
// clang-format off
typedef struct mssm_faces { int face[3]; float weight[3]; } mssm_faces;
// clang-format on
// [glsl end]

// From the vector from the light to the receiver.
MSSM_API mssm_faces mssm_point_faces(float x, float y, float z);

// Share of a light's strength that arrives at a distance >= 0: 1 / (constant + linear d + quadratic
// d^2), at most 1 for constant >= 1. (0, 0, 1) is a small lamp's. 0 where the sum is not positive.
MSSM_API float mssm_attenuation(float distance, float constant, float linear, float quadratic);

// Share of a spot light's strength by the cosine of the angle from its axis: cosine^exponent, faded
// smoothly from 1 at cos_inner to 0 at cos_outer < cos_inner. cosine is clamped to [-1,1]; its
// power is 1 for an exponent <= 0, else 0 below 0.
MSSM_API float mssm_cone(float cosine, float cos_inner, float cos_outer, float exponent);

// GLSL 4.50 text of mssm_faces and the last three functions. It stands alone. Static storage.
MSSM_API const char *mssm_glsl_lights(void);

// ---- Moment map: one light's summed-area tables, in memory that the caller owns ---- >>map calls

typedef enum mssm_estimator {
    MSSM_LAYERED = 0,   // each blocker layer gets a kernel of its own (docs/moments.md, "Layers")
    MSSM_LOWER_BLOCKER, // one kernel from the lower estimate of blocker depth, Eq. 7
    MSSM_UPPER_BLOCKER, // one kernel from the upper estimate, Eq. 19
    MSSM_HORIZON // layered, of the part of the light above the receiver's horizon, by its normal
} mssm_estimator;

typedef struct mssm_settings { // zero means default everywhere, as does what is out of range
    int moments;               // 4, 6, or 0: as many as the map has
    mssm_estimator estimator;  // others count as MSSM_LOWER_BLOCKER; mssm_gl_create refuses them
    float moment_bias;         // 0: the safe value, MSSM_BIAS4_TABLE or MSSM_BIAS6_TABLE
    float depth_bias; // in z; 0: 3/4 texel, none with back faces. Blockers fade in over twice that
    int max_kernel;   // widest filter in texels of level 0; 0: as wide as the light asks for
    float tolerance;  // error of visibility below which narrower kernels are left out; 0: 1/256
} mssm_settings;

typedef struct mssm_map mssm_map;

// Bytes for a map of side^2 texels (1 to 16384) with 4 or 6 moments: side^2 * (moments * 4 + 2),
// the 2 for least and greatest depths, and a third more for coarser levels. 0 if out of range.
MSSM_API size_t mssm_map_bytes(int side, int moments);

// Lays out a map in memory (any alignment; must not be moved while in use). The map starts empty:
// everything is lit. Fails with *map untouched.
MSSM_API mssm_result mssm_map_init(mssm_map **map, void *memory, size_t bytes, int side,
                                   int moments);

// Takes a depth map and builds all tables. Depth at [(y*side + x)*samples + s], 1 to 64 samples a
// texel, 1 where nothing is hit, clamped to [-1,1], NaN counts as 1. With back faces (or NULL) the
// mean of both is used, sample by sample: no depth bias, so firmer contact shadows of separate
// convex casters under small lights, but leaks next to concave ones. Fails with map as it was.
MSSM_API mssm_result mssm_map_update(mssm_map *map, const float *front, const float *back,
                                     int samples);

// Visibility of the light from a world-space point, in [0,1]. settings may be NULL. Points
// nearer than the near plane, not finite, or so far outside the map that their kernel misses it are
// lit; just outside what the rim holds goes on.
MSSM_API float mssm_map_visibility(const mssm_map *map, const mssm_light *light,
                                   const mssm_settings *settings, const float point[3]);

// The same with the receiver's normal, of any length, NULL or zero where it is not known. It tells
// the receiver's own surface from blockers; best is the geometric one. With MSSM_HORIZON it points
// to the side that is shaded, and visibility is to be multiplied by irradiance that is clipped at
// the horizon (lightprobe_disc_irradiance): bodies do not hide from themselves what that has left
// out already. Of a light that has set, it is that of its last part; of one far below, of all.
MSSM_API float mssm_map_visibility_normal(const mssm_map *map, const mssm_light *light,
                                          const mssm_settings *settings, const float point[3],
                                          const float normal[3]);

// The same for many points: what depends on the light alone is done once. normals may be NULL;
// visibility may not overlap the rest.
MSSM_API void mssm_map_visibility_many(const mssm_map *map, const mssm_light *light,
                                       const mssm_settings *settings, int count,
                                       const float (*points)[3], const float (*normals)[3],
                                       float *visibility);

// Moments of depth of a rectangle of the map, for estimators of one's own: centre and half-sizes in
// shadow space, at least half a texel. Beyond the map its outermost texels stand for as much as the
// rectangle has inside, and depth 1 for the rest. Not biased yet:
// mssm_moments6_bias(m, MSSM_BIAS6_DECODED) makes them safe. With 4 moments the last two are 0.
MSSM_API mssm_moments6 mssm_map_moments(const mssm_map *map, float x, float y, float half_x,
                                        float half_y);

// A level of the map as a texture, a 2D array with a layer a light, for mssm_glsl_shader.
typedef struct mssm_texels {
    int levels, side; // mip levels of the texture; texels across and up of this one
    unsigned internal_format, format, type; // as glTexImage3D takes them
    size_t bytes;                           // of this level
} mssm_texels;

// which 0: moments 1 to 4 (RGBA32I); 1: moments 5 and 6 (RG32I); 2: least depths and least -depths
// (RG32F), from level 1 on of 2 x 2 texels together. texels may be NULL, to ask for sizes.
// MSSM_ERROR_ARGUMENT, with all untouched, ends a loop over levels: there is no such level or, with
// 4 moments, no texture 1; MSSM_ERROR_MEMORY if bytes are too few.
MSSM_API mssm_result mssm_map_texels(const mssm_map *map, int which, int level, mssm_texels *info,
                                     void *texels, size_t bytes);

// The light as that shading reads it: 7 ivec4 of its uniform block; all 0 where there is none.
// Floats are in it bit for bit. settings, of which max_kernel counts, may be NULL. Fails, with view
// untouched, on lights that mssm_gl_set_light refuses.
MSSM_API mssm_result mssm_map_view(const mssm_map *map, const mssm_light *light,
                                   const mssm_settings *settings, int view[28]);

#ifndef MSSM_NO_FILTERED
// ---- Filtered hard shadows and translucent casters (docs/filtered.md) ---- >>filtered calls
//
// Lights without size: a map of 16-bit moments under a Gaussian, with mip maps, read trilinearly.

typedef struct mssm_filter { // zero means default everywhere
    float moment_bias;       // 0: MSSM_BIAS4_UNORM16_FILTERED or MSSM_BIAS6_UNORM16_FILTERED
    float depth_bias;  // in units of z; 0: by the filter's width and what lies beyond the receiver
    float full_shadow; // share of occlusion that counts as all, against weak leaks; 0: 0.98; 1: off
} mssm_filter;

typedef struct mssm_filtered mssm_filtered;

// Bytes for a map of side^2 texels (1 to 16384) with 4 or 6 moments, 0 if out of range: for each
// moment 2 and a third more for the mip chain, and 8 to work in.
MSSM_API size_t mssm_filtered_bytes(int side, int moments);

// As mssm_map_init: any alignment, not to be moved, everything lit. Fails with *map untouched.
MSSM_API mssm_result mssm_filtered_init(mssm_filtered **map, void *memory, size_t bytes, int side,
                                        int moments);

// Takes a depth map, laid out as for mssm_map_update, blurs it by a Gaussian of 2 * radius + 1
// texels (standard deviation radius / 2; 0 to 32) and makes the mip chain. Beyond the map its
// outermost texels go on, as far as Gaussian and footprint reach. Fails with the map untouched.
MSSM_API mssm_result mssm_filtered_update(mssm_filtered *map, const float *depth, int samples,
                                          int radius);

// The same from encoded moments of one's own, encoded[(y*side + x)*moments + k]: what
// mssm_moments*_encode gives, for translucent casters what mssm_moments*_blend has made of it.
MSSM_API mssm_result mssm_filtered_update_moments(mssm_filtered *map, const float *encoded,
                                                  int radius);

// Soft shadows of the same moments.
MSSM_API mssm_result mssm_map_update_moments(mssm_map *map, const float *encoded);

// Moments at shadow-space x, y under a footprint that is width wide (shadow space; 0: the finest; at
// most a texel of the last level, which has up to 27^2). Not biased yet. With 4 moments the last two
// are 0. Outside the map: of depth 1.
MSSM_API mssm_moments6 mssm_filtered_moments(const mssm_filtered *map, float x, float y,
                                             float width);

// Visibility of the light from a world-space point, in [0,1]: the upper bound. width: the pixel's
// footprint in world units at the point; 0: a point. filter may be NULL. Points outside the map,
// nearer than its near plane or not finite are lit.
MSSM_API float mssm_filtered_visibility(const mssm_filtered *map, const mssm_light *light,
                                        const mssm_filter *filter, const float point[3],
                                        float width);

// Both bounds of it. Inside of smoke their middle is nearer to the truth: the upper bound takes a
// receiver to be the last of its surface, and half of the smoke round it is behind it.
MSSM_API mssm_bounds mssm_filtered_bounds(const mssm_filtered *map, const mssm_light *light,
                                          const mssm_filter *filter, const float point[3],
                                          float width);

// A layer at depth z that lets 1 - opacity of the light through, over what is there: standard alpha
// blending. After layers from far to near, P(depth < z) is exactly the light that those nearer than
// z keep off, 1 - product(1 - opacity): so the bounds enclose the transmittance.
MSSM_API mssm_moments4 mssm_moments4_blend(mssm_moments4 m, float z, float opacity);
MSSM_API mssm_moments6 mssm_moments6_blend(mssm_moments6 m, float z, float opacity);
#endif

#ifndef MSSM_NO_SCATTERING
// ---- Single scattering: shafts of a directional light in a homogeneous medium (docs/shafts.md) ---- >>scattering calls
//
// Seen from the camera with the light as pole, a view ray is one inclination (angle from the pole)
// and one azimuth, and meets one light ray of that azimuth at each distance r from the axis. So in
// a map of azimuth (rows) and r (columns) that holds the inclination of the caster on each light
// ray, the visibility along a view ray is that of one depth in a row up to some column, and mean
// moments up to there bound it. The math is here and in mssm_glsl_scattering(); filling the map and
// adding up its rows is the application's, as in examples/common/gl_shafts.c.

// [glsl begin scattering]
// A camera under a light. Scalars only, as mssm_view.
typedef struct mssm_scattering {
    float axis[9];  // unit: across the light to the middle of the picture, aside, towards the light
    float eye[3];   // camera in shadow space
    float slope[5]; // shadow-space x, y for each world unit along two axes, world units for each z
    float azimuth[2];     // where rows begin, and their range, 2 pi where they go round
    float inclination[2]; // of depth 0, and depth in a radian
    float extinction;     // per world unit
    float fade;           // the same for r: columns scatter equal shares of unshadowed light
    float balance;        // see mssm_scattering_visibility
} mssm_scattering;

// Where a row is over the map: from r = first on (extent 0: nowhere); shadow-space x, y for each r.
// clang-format off
typedef struct mssm_epipolar { float first, extent, fade, x, y; } mssm_epipolar;

// A view ray: texture coordinates of its row and its last column's end, depth, share of its light
// that comes from over the map, weight of the upper bound.
typedef struct mssm_view_ray { float row, column, depth, share, upper, balance; } mssm_view_ray;

typedef struct mssm_points2 { float z[2], w[2]; } mssm_points2;
// clang-format on
// [glsl end]

// The camera at eye sees what is between four directions: corners of the picture, in order around
// it. The light must be directional, extinction >= 0. Fails with s untouched.
MSSM_API mssm_result mssm_scattering_init(mssm_scattering *s, const mssm_light *light,
                                          const float eye[3], const float corners[12],
                                          float extinction);

MSSM_API mssm_epipolar mssm_scattering_row(mssm_scattering s, float azimuth);
MSSM_API float mssm_scattering_distance(mssm_epipolar row,
                                        float column); // r at 0 to 1 of all columns

// Two depths, ascending, with the first three moments; a single surface gets a little variance.
MSSM_API mssm_points2 mssm_reconstruct3(float b1, float b2, float b3);

// Inclination, as a depth in [-1,1], of the point of a light ray at shadow-space depth z; what is
// behind all casters (MSSM_FAR_CASTER) goes to infinity. And its moments from those of z.
MSSM_API float mssm_inclination(mssm_scattering s, float r, float z);
MSSM_API mssm_moments6 mssm_scattering_moments(mssm_scattering s, float r, float b1, float b2,
                                               float b3);

// A unit direction in world space; distance to the surface, or to where the medium ends.
MSSM_API mssm_view_ray mssm_scattering_ray(mssm_scattering s, float x, float y, float z,
                                           float distance);

// Mean visibility along the ray, weighted by transmittance to the camera: times unshadowed single
// scattering it is the shafts. m: biased mean moments of its columns. The upper bound weighs (1 -
// cos(inclination)) / 2, as in the slides; balance 0.5: halfway to the lit share of what is sure.
MSSM_API float mssm_scattering_visibility(mssm_view_ray ray, mssm_moments6 m);

// GLSL 4.50 text of all but mssm_scattering_init, to be put after mssm_glsl_math(). Static storage.
MSSM_API const char *mssm_glsl_scattering(void);
#endif

// ---- GLSL texts for pipelines of your own ---- >>text calls

// GLSL 4.50 text of the moment math alone: same names and structs as the C functions above.
// To be put after #version; before or after other texts that include it, too. Static storage.
MSSM_API const char *mssm_glsl_math(void);

// GLSL 4.50 text of the estimators, for pipelines of one's own (Vulkan, other table formats), after
// mssm_glsl_math(). Declares mssm_view, mssm_options and float mssm_estimate(int map, mssm_view,
// mssm_options, mssm_receiver); calls mssm_moments6 mssm_query(int map, int moments, float x, float
// y, float half_x, float half_y), yours to define: the Chebyshev moments that a rectangle of the
// map holds. Macros, to be defined right before the text, which forgets them: MSSM_LEAST_DEPTH may
// name a float f(int map, float x, float y, float half_size), the least depth within half_size
// texels, which proves receivers lit and keeps near planes and far casters from harm;
// MSSM_GREATEST_DEPTH the greatest, which proves them dark; MSSM_MAP a type of map other than int.
MSSM_API const char *mssm_glsl_shading(void);

#if !(defined MSSM_STATIC && defined MSSM_NO_GL) // a static function must be defined
// ---- OpenGL 4.5 ---- >>gl calls
//
// Any number of lights; each frame:
//
//     for (int i = 0; i < lights; i++) {
//         mssm_gl_set_light(gl, i, &light[i]);            // where it changed
//         mssm_gl_begin_depth(gl, i, 0);
//         draw_casters(light[i].world_to_shadow);  // gl_Position = world_to_shadow * position
//         mssm_gl_end_depth(gl);
//     }
//     mssm_gl_build(gl);
//     mssm_gl_bind(gl);
//     draw_scene();                                       // with mssm_visibility() in its shader
//
// Calls must come with the context of mssm_gl_create current; several contexts may have one mssm_gl
// each. They leave the GL state as they found it, but for what mssm_gl_bind says it binds and,
// between begin and end, the state of the depth pass. Objects carry labels that start with "mssm".
// What is out of range is told to the log: "mssm: side 20000: 1 to 16384". While transform feedback
// is active and not paused GL forbids our programs: MSSM_ERROR_ORDER. Not between
// glBeginConditionalRender and its end: GL would leave out what a pass draws, and cannot be asked.
// Not seen either: conservative rasterization, shading rates and sample locations of vendors'
// extensions, advanced blend equations (which also forbid plain shaders to draw); active queries
// count what is drawn. For programs and framebuffers that were deleted while bound, and programs
// whose last link failed, 0 is bound in the end; subroutines are chosen anew with each program.

typedef void (*mssm_gl_function)(void);
typedef mssm_gl_function (*mssm_gl_loader)(const char *name); // glfwGetProcAddress and the like

typedef struct mssm_gl_desc { // zero means default everywhere
    mssm_gl_loader load;      // needed
    int lights;               // as many as the driver's array layers, 2048 on most; default 1
    int side;                 // of the maps, 1 to 16384; default 256, filtered 1024
    int samples;              // of the depth target, 1 to 64; default 4
    int moments; // 4 or 6; default 6, filtered 4. settings.moments chooses among what is stored
    mssm_settings settings;   // of soft shadows, compiled into the shading text
    int first_texture_unit;   // mssm_gl_bind takes three from here; default 80. Filtered: two, 83
    int first_buffer_binding; // and this binding of shader storage buffers; default 7, filtered 6
    void (*log)(void *user, const char *message); // one line, or a shader's whole log; may be NULL
    void *user;
    const char *name; // of the shading function, default mssm_(filtered_)visibility. Not kept
#ifndef MSSM_NO_FILTERED
    int filtered;       // 1: filtered hard shadows, with translucent casters; then of the
    int radius;         // Gaussian, 1 to 32 texels, -1: none; default 2
    int anisotropy;     // looks along the longer side of a pixel's footprint, 1 to 16; default 4
    mssm_filter filter; // compiled into the shading text
#endif
} mssm_gl_desc;

typedef struct mssm_gl mssm_gl;

// Compiles the shaders and makes all objects: for N lights of side^2, 6 moments, N * side^2 * 26
// bytes and a third more, and a depth target of side^2 * samples * 4 a layer: N + 1 layers, at most
// 16 and 32 MiB, but always two. Filtered: N * side^2 * 8 (12 with 6 moments) and a third more, and
// side^2 * (4 * samples + 79) to work in. On failure *gl is untouched, all freed, the log told.
MSSM_API mssm_result mssm_gl_create(mssm_gl **gl, const mssm_gl_desc *desc);

// Bytes of its textures and buffers, if the driver gives the samples asked for. Needs no context.
// 0, with a word in the log, where numbers are out of range.
MSSM_API size_t mssm_gl_bytes(const mssm_gl_desc *desc);

// Deletes all objects. gl may be NULL. A depth pass under way is ended.
MSSM_API void mssm_gl_destroy(mssm_gl *gl);

// Other numbers of lights or texels, 0 for the defaults. Lights stay set, maps must be drawn and
// bound again. On failure everything is as it was.
MSSM_API mssm_result mssm_gl_resize(mssm_gl *gl, int lights, int side);

// The light with this index, from mssm_light_directional or mssm_light_spot, or filled in by hand.
MSSM_API mssm_result mssm_gl_set_light(mssm_gl *gl, int index, const mssm_light *light);

// Between these two the application draws its casters into the light's depth map. begin binds a
// multisampled framebuffer without colour, sets viewport, depth test, depth range and clip control
// (-1 to 1) and clears depth; culling is off, or with back_faces front faces are culled; whatever
// else could keep fragments or colours out is off: clip distances, stencil, masks, alpha test ...
// end restores all of that; depth becomes moments when the target is full or with mssm_gl_build, of
// all lights at once. A pass with back_faces must directly follow the light's pass without: the
// mean of both is used then, sample by sample, as with mssm_map_update. Filtered maps take none.
MSSM_API mssm_result mssm_gl_begin_depth(mssm_gl *gl, int index, int back_faces);
MSSM_API mssm_result mssm_gl_end_depth(mssm_gl *gl);

// Where the pass under way draws: a layer of its GL_TEXTURE_2D_MULTISAMPLE_ARRAY, the framebuffer's
// depth attachment. -1: none is. Mesa does not tell it of the attachment.
MSSM_API int mssm_gl_layer(const mssm_gl *gl);

// How a depth map holds depth.
typedef enum mssm_stored {
    // As a GPU stores it from gl_Position, with a depth range of 0 to 1; clip space from -1 or 0.
    MSSM_STORED_WINDOW = 0,
    MSSM_STORED_LINEAR, // 0 to 1 linear in the distance along the light's axis
    MSSM_STORED_RADIAL  // the same from the light, as point lights often have it
} mssm_stored;

// A depth map that the renderer has already.
typedef struct mssm_gl_depth { // zero means default everywhere
    unsigned texture;          // needed: of depth or depth and stencil, or with the depth as red
    unsigned target;           // GL_TEXTURE_2D (default), _2D_ARRAY, _CUBE_MAP, _CUBE_MAP_ARRAY,
                               // _2D_MULTISAMPLE or _2D_MULTISAMPLE_ARRAY
    int layer; // of an array; face of a cube map; cube * 6 + face of an array of these
    int x, y;  // texel at which the light's rectangle begins
    // In texels, 0: to the end. Each 1, 2 ... or 8 times the side of mssm_gl: what lies in a texel
    // of the moment map, at most 64 texels times samples, is its samples.
    int width, height;
    mssm_stored stored; // default MSSM_STORED_WINDOW
    int reversed;       // 1 is nearest and 0 farthest
    // Distances that the map's ends stand for; both 0: those of the light. z_far may be INFINITY.
    float z_near, z_far;
} mssm_gl_depth;

// In place of the passes of a light that was set: front, and where not NULL back, like it but for
// texture, layer, x and y. Columns and rows are shadow-space x and y; the far end (1, reversed 0)
// counts as nothing hit. The texture's own state and samplers stay and are not in the way: compare
// mode, filters, swizzle, stencil mode; its base level is read, at once. Fails with the light's map
// as it was. Then mssm_gl_build. Filtered maps take front alone, and no translucent casters after
// it. Within mssm_gl_begin_frame GL is asked about a texture only when a light first gets it with
// these numbers: storage, swizzle and stencil mode must stay from then on.
MSSM_API mssm_result mssm_gl_set_depth(mssm_gl *gl, int index, const mssm_gl_depth *front,
                                       const mssm_gl_depth *back);

// Round the passes and the build of a frame, where their calls of GL count: GL's state is saved and
// put back once, not for each light, and nothing in between asks GL for it, which can cost a wait.
// Drawing may then change programs, buffers, textures, vertex arrays, culling, viewport, scissor
// and depth test; what else a pass sets must stay as it is. It binds its program or pipeline,
// textures and buffers after mssm_gl_begin_depth, which leaves others there, and no program,
// whenever the target was full.
// mssm_gl_bind comes after the end. Brackets of several objects nest: the last that was begun ends
// first. Depth maps of your own are drawn before: their state would be that of a pass.
MSSM_API mssm_result mssm_gl_begin_frame(mssm_gl *gl);
MSSM_API mssm_result mssm_gl_end_frame(mssm_gl *gl);

// Tables of all lights drawn since the last build: two dispatches a level for up to 256 lights, of
// as many levels as the widest light needs. Filtered: Gaussian and mip chain of the light drawn
// last; others were made when the next began. Returns at once where nothing has changed.
MSSM_API mssm_result mssm_gl_build(mssm_gl *gl);

// Binds what shading reads: textures at units first_texture_unit and the next two (and no
// samplers), a shader storage buffer at first_buffer_binding. Once a frame after the build, or
// whenever these were changed. The first time the log is told what else was bound there.
MSSM_API mssm_result mssm_gl_bind(mssm_gl *gl);

// What is not up to date, as bits. 0 for a wrong index, which the log is told.
enum {
    // Nothing was drawn, or the light's frustum was changed since: only its size may be.
    MSSM_STALE_MAP = 1,
    MSSM_STALE_TABLES = 2 // mssm_gl_build has something to do for it
};
MSSM_API int mssm_gl_stale(const mssm_gl *gl, int index);

// To look at: draws the map of a light in shades of grey, nearest black, into the viewport of the
// draw framebuffer that is bound. Needs built tables; not within mssm_gl_begin_frame.
typedef enum mssm_show {
    MSSM_SHOW_MEAN = 0, // mean depth of each texel
    MSSM_SHOW_LEAST     // least depths, a texel for four; not of filtered maps
} mssm_show;
MSSM_API mssm_result mssm_gl_show(mssm_gl *gl, int index, mssm_show what);

// GLSL 4.50 text to put after #version: float mssm_visibility(int light, vec3 world_position), and
// float mssm_visibility_at(int light, vec3 shadow) from shadow-space x, y and depth; with a name of
// your own NAME and NAME_at. Filtered: float mssm_filtered_visibility(int light, vec3
// world_position, vec3 ddx, vec3 ddy), derivatives of the position (dFdx and dFdy in a forward
// pass, zero for a point), and mssm_bounds mssm_filtered_bounds of the same, or NAME and
// NAME_bounds. 1 where there is no such light. Lives as long as gl. A shader may have those of
// several mssm_gl of other names, units and bindings, and all texts of this header, in any order.
MSSM_API const char *mssm_gl_shader(const mssm_gl *gl);

// The same for contexts without an mssm_gl (docs/integration.md, 9): GLSL from 330 and 300 es on,
// so OpenGL 3.3, macOS, OpenGL ES 3.0, WebGL 2. Units and bindings are the caller's to set: of
// isampler2DArray mssm_table0, mssm_table1 (6 moments) and sampler2DArray mssm_depths for the
// textures of mssm_map_texels, and of the uniform block mssm_view_block for the views of
// mssm_map_view, one for each of desc.lights, at most 585 (16 KiB hold 146). With desc.name NAME:
// mssm_NAME_table0 ... Of desc lights, moments, settings, name and log count; not filtered. Returns
// the bytes of the text with its final 0, and writes it if there are as many; 0: see the log.
MSSM_API size_t mssm_glsl_shader(const mssm_gl_desc *desc, char *text, size_t bytes);

// The tables, for tools and tests: integer 2D arrays with a layer a light and the levels as mip
// levels. which 0: channels 1 to 4 (RGBA32I); 1: channels 5 and 6 (RG32I), 0 with 4 moments; 2:
// least depths, and the least of -depth, from half the side down (RG32F). Filtered: 0 and 1 the
// maps (RGBA16, RG16); 3: the encoded moments of the light just drawn, before the Gaussian until it
// is built and after it from then on: an array of two layers (RGBA32F), moments 1 to 3 and 4 to 6.
// Before reading them back: glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT).
MSSM_API unsigned mssm_gl_texture(const mssm_gl *gl, int which);

#ifndef MSSM_NO_FILTERED
// Filtered hard shadows have the same life cycle, and translucent casters where wanted: after a
// light's mssm_gl_end_depth, before the next begin or the build. Between these the application
// blends them, but what opaque ones hide, from far to near, into the moments of the light just
// drawn: its fragment shader calls mssm_translucent (mssm_glsl_translucent), and blending of both
// targets is its to set: glEnable(GL_BLEND); glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA).
MSSM_API mssm_result mssm_gl_begin_translucent(mssm_gl *gl);
MSSM_API mssm_result mssm_gl_end_translucent(mssm_gl *gl);

// GLSL for that shader, after mssm_glsl_math(): void mssm_translucent(float depth, float opacity),
// depth as in shadow space (directional lights: 2 * gl_FragCoord.z - 1). Static storage.
MSSM_API const char *mssm_glsl_translucent(void);

// Soft shadows of such moments: in place of a depth pass of an mssm_gl that is not filtered.
// texture: an array of two layers as mssm_gl_texture(filtered, 3), at least as large as the map, of
// base level 0: checked but within a frame. Texels beyond the map are not read. Then mssm_gl_build.
MSSM_API mssm_result mssm_gl_set_moments(mssm_gl *gl, int index, unsigned texture);
#endif
#endif // MSSM_STATIC, MSSM_NO_GL

#ifdef __cplusplus
}
#endif

#endif // MSSM_H

// ================================================================================================
// Stop here if you only use the library: below is the implementation.
// ================================================================================================

#ifdef MSSM_IMPLEMENTATION
#ifndef MSSM_IMPLEMENTATION_DONE
#define MSSM_IMPLEMENTATION_DONE

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

// With -ffast-math compilers take NaN for a number and add in any order: not in here. Clang 14
// obeys for x86 and s390x; elsewhere it warns.
#if defined __FINITE_MATH_ONLY__ && __FINITE_MATH_ONLY__
#define MSSM__PRECISE_MATH
#if defined __clang__
#pragma float_control(precise, on, push)
#else
#pragma GCC push_options
#pragma GCC optimize("no-fast-math,no-math-errno,no-trapping-math")
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

// What stands between the [glsl] markers is in the subset that C99 and GLSL 4.50 share, and quoted
// by `make glsl` at the end (>>generated). No pointers, casts or preprocessor lines.
#if defined __GNUC__
#define MSSM_SHARED static inline __attribute__((always_inline))
#else
#define MSSM_SHARED static inline
#endif
#define MSSM_PRECISE

// Names of GLSL's own functions (MSSM__GLSL_NAMES), which an optimizer can make one instruction
// each; operands in this order, so that the specification's formula too gives b for NaN.
MSSM_SHARED float mssm_min(float a, float b)
{
    return a < b ? a : b;
}

MSSM_SHARED float mssm_max(float a, float b)
{
    return a > b ? a : b;
}

// NaN gives high, high below low gives low.
MSSM_SHARED float mssm_clamp(float x, float low, float high)
{
    return mssm_max(mssm_min(x, high), low);
}

// Without its fraction; from 0 to below 2^31. floorf() is a call or ten instructions without SSE 4.
MSSM_SHARED float mssm_whole(float x)
{
    return (float)(int)x;
}

MSSM_SHARED int mssm_bits(float x)
{
    int bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

// [glsl begin]

// ---- Moments and their storage ---- >>math

// Four moments by way of six where these have the same first four: compilers drop the rest.
MSSM_SHARED mssm_moments6 mssm_six(mssm_moments4 m)
{
    mssm_moments6 r;
    for (int k = 0; k < 4; k++) r.b[k] = m.b[k];
    r.b[4] = 0.0f;
    r.b[5] = 0.0f;
    return r;
}

MSSM_SHARED mssm_moments4 mssm_four(mssm_moments6 m)
{
    mssm_moments4 r;
    for (int k = 0; k < 4; k++) r.b[k] = m.b[k];
    return r;
}

mssm_moments6 mssm_moments6_of_depth(float z)
{
    float d = mssm_clamp(z, -1.0f, 1.0f);
    mssm_moments6 m;
    m.b[0] = d;
    m.b[1] = d * d;
    m.b[2] = d * d * d;
    m.b[3] = (d * d) * (d * d);
    m.b[4] = (d * d) * (d * d) * d;
    m.b[5] = (d * d) * (d * d) * (d * d);
    return m;
}

mssm_moments4 mssm_moments4_of_depth(float z)
{
    return mssm_four(mssm_moments6_of_depth(z));
}

// Odd entries of all bias vectors are zero: the best vector is symmetric. 4 is beyond all entries.
MSSM_SHARED float mssm_blend_to(float b, float alpha, float goal)
{
    float a = mssm_clamp(alpha, 0.0f, 1.0f);
    float start = mssm_clamp(b, -4.0f, 4.0f);
    return start - a * (start - goal);
}

MSSM_SHARED mssm_moments6 mssm_blend_to6(mssm_moments6 m, float alpha, float b2, float b4, float b6)
{
    mssm_moments6 r;
    r.b[0] = mssm_blend_to(m.b[0], alpha, 0.0f);
    r.b[1] = mssm_blend_to(m.b[1], alpha, b2);
    r.b[2] = mssm_blend_to(m.b[2], alpha, 0.0f);
    r.b[3] = mssm_blend_to(m.b[3], alpha, b4);
    r.b[4] = mssm_blend_to(m.b[4], alpha, 0.0f);
    r.b[5] = mssm_blend_to(m.b[5], alpha, b6);
    return r;
}

mssm_moments4 mssm_moments4_bias(mssm_moments4 m, float alpha)
{
    return mssm_four(mssm_blend_to6(mssm_six(m), alpha, 0.920f, 3.804f, 0.0f));
}

mssm_moments6 mssm_moments6_bias(mssm_moments6 m, float alpha)
{
    return mssm_blend_to6(m, alpha, 0.421f, 0.511f, 1.913f);
}

mssm_moments4 mssm_moments4_bias_encoded(mssm_moments4 m, float alpha)
{
    return mssm_four(mssm_blend_to6(mssm_six(m), alpha, 1.120f, 2.884f, 0.0f));
}

mssm_moments6 mssm_moments6_bias_encoded(mssm_moments6 m, float alpha)
{
    return mssm_blend_to6(m, alpha, 0.657f, 0.734f, 1.197f);
}

MSSM_SHARED float mssm_to_unit(float t)
{
    return mssm_clamp(0.5f + 0.5f * t, 0.0f, 1.0f);
}

// T_1(z) to T_6(z). In GLSL nothing here may be fused: tables are equal bit for bit.
MSSM_SHARED mssm_moments6 mssm_chebyshev(float z)
{
    MSSM_PRECISE float twice = z + z;
    MSSM_PRECISE float t2 = twice * z - 1.0f;
    MSSM_PRECISE float t3 = twice * t2 - z;
    MSSM_PRECISE float t4 = twice * t3 - t2;
    MSSM_PRECISE float t5 = twice * t4 - t3;
    MSSM_PRECISE float t6 = twice * t5 - t4;
    mssm_moments6 t;
    t.b[0] = z;
    t.b[1] = t2;
    t.b[2] = t3;
    t.b[3] = t4;
    t.b[4] = t5;
    t.b[5] = t6;
    return t;
}

// T1 = z, T2 = 2z^2 - 1, T3 = 4z^3 - 3z, T4 = 8z^4 - 8z^2 + 1, ...
mssm_moments6 mssm_moments6_encode(mssm_moments6 m)
{
    mssm_moments6 q;
    q.b[0] = mssm_to_unit(m.b[0]);
    q.b[1] = mssm_clamp(m.b[1], 0.0f, 1.0f);
    q.b[2] = mssm_to_unit(4.0f * m.b[2] - 3.0f * m.b[0]);
    q.b[3] = mssm_to_unit(8.0f * (m.b[3] - m.b[1]) + 1.0f);
    q.b[4] = mssm_to_unit(16.0f * m.b[4] - 20.0f * m.b[2] + 5.0f * m.b[0]);
    q.b[5] = mssm_to_unit(32.0f * m.b[5] - 48.0f * m.b[3] + 18.0f * m.b[1] - 1.0f);
    return q;
}

mssm_moments4 mssm_moments4_encode(mssm_moments4 m)
{
    return mssm_four(mssm_moments6_encode(mssm_six(m)));
}

// Straight from the stored values, without going through T = 2q - 1: fewer roundings.
mssm_moments6 mssm_moments6_decode(mssm_moments6 q)
{
    for (int k = 0; k < 6; k++) q.b[k] = mssm_clamp(q.b[k], 0.0f, 1.0f);
    mssm_moments6 m;
    m.b[0] = 2.0f * q.b[0] - 1.0f;
    m.b[1] = q.b[1];
    m.b[2] = 1.5f * q.b[0] + (0.5f * q.b[2] - 1.0f);
    m.b[3] = q.b[1] + (0.25f * q.b[3] - 0.25f);
    m.b[4] = 1.25f * q.b[0] + (0.625f * q.b[2] + (0.125f * q.b[4] - 1.0f));
    m.b[5] = 0.9375f * q.b[1] + (0.375f * q.b[3] + (0.0625f * q.b[5] - 0.375f));
    return m;
}

mssm_moments4 mssm_moments4_decode(mssm_moments4 q)
{
    return mssm_four(mssm_moments6_decode(mssm_six(q)));
}

// ---- Bounds without the roots (docs/moments.md, "Bounds") ---- >>bounds
//
// Notation: u = depth - mean. D1, D2, D3 are the pivots of the moment matrix (squared norms of the
// monic orthogonal polynomials p1 = u, p2 = (u - a1) p1 - D1, p3 = (u - a2) p2 - D2/D1 p1), u0 is
// the receiver. The kernel K(u) = 1 + p1(u) p1(u0)/D1 + p2(u) p2(u0)/D2 + ... vanishes at all other
// depths of the canonical representation. With v = 1/(u - u0) it reads k0 v^n + k1 v^(n-1) + ... +
// kn, where k0 > 0 is 1/w0, the inverse share of the receiver, times a positive factor. All roots
// are real, so Descartes' rule is exact: the number of sign changes is the number of depths beyond
// the receiver. The share of any depth x is 1/K(x,x) (Christoffel number).

// Floors: pivots below half of alpha times those of the bias vector (D1 = b2, D2 = b4 - b2^2, D3 =
// b6 - b4^2/b2), for the smaller of a function's two biases, are not from rounding of safely biased
// moments. The longest valid part of such moments is used: 6, 4, 2, or a single surface of the
// variance D1's floor. That cuts false shadows 90 times where a user's bias is too small.

// Factorised moment matrix (L D L^T): pivots d and the entries c of L that the polynomials need. d2
// or d3 is 0 where the moments are valid only up to there; d1 is never below its floor.
struct mssm_pivots {
    float mean, d1, c21, d2, c32, d3;
};

struct mssm_kernel4 {
    float mean, u0, i1, i2, f1, q2; // i = 1/d; q, f, e: values and slopes of polynomials at u0
    float k0, k1, k2, w0;
};

struct mssm_kernel6 {
    float mean, u0, i1, i2, i3, f1, q2, q3, e1, e2;
    float k0, k1, k2, k3, w0;
};

// nearer: share of what is surely nearer than the receiver; own: the share that its own depth can
// hold; first: sum of share times depth over what is nearer.
struct mssm_split {
    float nearer, own, first;
};

// The clamps (moments to [-4,4], depth to [-1000,1000]) keep every product below finite.
MSSM_SHARED struct mssm_pivots mssm_factorise4(float m1, float m2, float m3, float m4)
{
    float b1 = mssm_clamp(m1, -4.0f, 4.0f);
    float b2 = mssm_clamp(m2, -4.0f, 4.0f);
    float b3 = mssm_clamp(m3, -4.0f, 4.0f);
    float b4 = mssm_clamp(m4, -4.0f, 4.0f);
    float d1 = b2 - b1 * b1;
    int valid = d1 > 2.2e-7f ? 1 : 0;
    struct mssm_pivots p;
    p.mean = b1;
    p.d1 = valid == 1 ? d1 : 2.2e-7f;
    float l21 = b3 - b1 * b2;
    float c21 = l21 / p.d1;
    p.c21 = valid == 1 ? c21 : 0.0f;
    // This form loses 9 times fewer digits than (b2 b4 - b3^2 ...) / d1.
    float d2 = (b4 - b2 * b2) - l21 * p.c21;
    valid = d2 > 7.1e-7f ? valid : 0;
    p.d2 = valid == 1 ? d2 : 0.0f;
    p.c32 = 0.0f;
    p.d3 = 0.0f;
    return p;
}

MSSM_SHARED struct mssm_pivots mssm_factorise6(float m1, float m2, float m3, float m4, float m5,
                                               float m6)
{
    float b1 = mssm_clamp(m1, -4.0f, 4.0f);
    float b2 = mssm_clamp(m2, -4.0f, 4.0f);
    float b3 = mssm_clamp(m3, -4.0f, 4.0f);
    float b4 = mssm_clamp(m4, -4.0f, 4.0f);
    float b5 = mssm_clamp(m5, -4.0f, 4.0f);
    float b6 = mssm_clamp(m6, -4.0f, 4.0f);
    float d1 = b2 - b1 * b1;
    int valid = d1 > 4.6e-7f ? 1 : 0;
    struct mssm_pivots p;
    p.mean = b1;
    p.d1 = valid == 1 ? d1 : 4.6e-7f;
    float i1 = 1.0f / p.d1;
    float l21 = b3 - b1 * b2;
    float c21 = l21 * i1;
    p.c21 = valid == 1 ? c21 : 0.0f;
    float d2 = (b4 - b2 * b2) - l21 * p.c21;
    valid = d2 > 3.7e-7f ? valid : 0;
    p.d2 = valid == 1 ? d2 : 0.0f;
    float i2 = 1.0f / (valid == 1 ? d2 : 1.0f);
    float l31 = b4 - b1 * b3;
    float c31 = l31 * i1;
    float l32 = (b5 - b2 * b3) - l21 * c31;
    float c32 = l32 * i2;
    float d3 = (b6 - b3 * b3) - (l31 * c31 + l32 * c32);
    valid = d3 > 7.5e-7f ? valid : 0;
    p.c32 = valid == 1 ? c32 : 0.0f;
    p.d3 = valid == 1 ? d3 : 0.0f;
    return p;
}

MSSM_SHARED struct mssm_kernel4 mssm_make_kernel4(struct mssm_pivots p, float z)
{
    float u0 = mssm_clamp(z, -1000.0f, 1000.0f) - p.mean;
    float a1 = p.c21 - 2.0f * p.mean;
    float d2 = p.d2 > 0.0f ? p.d2 : 1.0f;
    float i2 = 1.0f / d2;
    float q2 = (u0 - a1) * u0 - p.d1;
    struct mssm_kernel4 k;
    k.mean = p.mean;
    k.u0 = u0;
    k.i1 = 1.0f / p.d1;
    k.i2 = p.d2 > 0.0f ? i2 : 0.0f;
    k.f1 = 2.0f * u0 - a1;
    k.q2 = p.d2 > 0.0f ? q2 : 0.0f;
    float s1 = 1.0f + u0 * u0 * k.i1;
    k.k0 = d2 * s1 + k.q2 * k.q2;
    k.k1 = d2 * k.i1 * u0 + k.q2 * k.f1;
    k.k2 = k.q2;
    k.w0 = 1.0f / (s1 + k.q2 * k.q2 * k.i2);
    return k;
}

MSSM_SHARED struct mssm_kernel6 mssm_make_kernel6(struct mssm_pivots p, float z)
{
    float u0 = mssm_clamp(z, -1000.0f, 1000.0f) - p.mean;
    float a1 = p.c21 - 2.0f * p.mean;
    float a2 = p.d3 > 0.0f ? p.c32 - p.c21 - p.mean : 0.0f;
    float d2 = p.d2 > 0.0f ? p.d2 : 1.0f;
    float d3 = p.d3 > 0.0f ? p.d3 : 1.0f;
    float i2 = 1.0f / d2;
    float i3 = 1.0f / d3;
    struct mssm_kernel6 k;
    k.mean = p.mean;
    k.u0 = u0;
    k.i1 = 1.0f / p.d1;
    k.i2 = p.d2 > 0.0f ? i2 : 0.0f;
    k.i3 = p.d3 > 0.0f ? i3 : 0.0f;
    float r2 = d2 * k.i1;
    float r3 = p.d3 > 0.0f ? d3 * i2 : 1.0f;
    float q2 = (u0 - a1) * u0 - p.d1;
    k.f1 = 2.0f * u0 - a1;
    k.q2 = p.d2 > 0.0f ? q2 : 0.0f;
    float q3 = (u0 - a2) * k.q2 - r2 * u0;
    k.q3 = p.d3 > 0.0f ? q3 : 0.0f;
    k.e1 = k.q2 + (u0 - a2) * k.f1 - r2;
    k.e2 = k.f1 + (u0 - a2);
    float s1 = 1.0f + u0 * u0 * k.i1;
    k.k0 = r3 * (d2 * s1 + k.q2 * k.q2) + k.q3 * k.q3;
    k.k1 = r3 * (r2 * u0 + k.q2 * k.f1) + k.q3 * k.e1;
    k.k2 = r3 * k.q2 + k.q3 * k.e2;
    k.k3 = k.q3;
    k.w0 = 1.0f / (s1 + k.q2 * k.q2 * k.i2 + k.q3 * k.q3 * k.i3);
    return k;
}

// Share of a depth at distance t from the receiver.
MSSM_SHARED float mssm_share4(struct mssm_kernel4 k, float t)
{
    float p1 = k.u0 + t;
    float p2 = k.q2 + (k.f1 + t) * t;
    return 1.0f / (1.0f + p1 * p1 * k.i1 + p2 * p2 * k.i2);
}

MSSM_SHARED float mssm_share6(struct mssm_kernel6 k, float t)
{
    float p1 = k.u0 + t;
    float p2 = k.q2 + (k.f1 + t) * t;
    float p3 = k.q3 + ((t + k.e2) * t + k.e1) * t;
    return 1.0f / (1.0f + p1 * p1 * k.i1 + p2 * p2 * k.i2 + p3 * p3 * k.i3);
}

// Two other depths: one on each side of the receiver (k2 < 0), or both on one side.
MSSM_SHARED struct mssm_split mssm_split4(struct mssm_kernel4 k)
{
    float disc = k.k1 * k.k1 - 4.0f * k.k0 * k.k2;
    float root = sqrtf(mssm_max(disc, 0.0f));
    float v_a = (-k.k1 - root) / (2.0f * k.k0);
    float v_b = 2.0f * k.k2 / (root - k.k1);
    float v = k.k1 >= 0.0f ? v_a : v_b;
    float t = 1.0f / mssm_min(v, -1e-3f);
    float lit = 1.0f - k.w0;
    float share = mssm_share4(k, t);
    share = mssm_min(share, lit);
    // The centred first moment is zero: what is nearer, the receiver and the rest add up to it.
    float first_one = share * (k.u0 + t);
    float first_all = -k.w0 * k.u0;
    float nearer_same = k.k1 > 0.0f ? lit : 0.0f;
    float first_same = k.k1 > 0.0f ? first_all : 0.0f;
    struct mssm_split r;
    r.nearer = k.k2 < 0.0f ? share : nearer_same;
    r.own = k.w0;
    r.first = (k.k2 < 0.0f ? first_one : first_same) + k.mean * r.nearer;
    return r;
}

// The only positive root of y^3 + b y^2 + c y + d, where d < 0. From above: from the
// Laguerre-Samuelson bound, or from the root without the cubic term.
MSSM_SHARED float mssm_positive_root(float b, float c, float d)
{
    float h = b * b - 3.0f * c;
    float y = (2.0f * sqrtf(mssm_max(h, 0.0f)) - b) * (1.0f / 3.0f);
    float e = c * c - 4.0f * b * d;
    float root = sqrtf(mssm_max(e, 0.0f));
    float y_a = -2.0f * d / mssm_max(c + root, 1e-37f);
    float y_b = (root - c) / (2.0f * b);
    float y_c = c >= 0.0f ? y_a : y_b;
    y_c = b > 0.0f ? y_c : y;
    y = mssm_min(y_c, y);
    for (int i = 0; i < 3; i++) { // Halley: monotone from there, error below 1e-6 after three
        float f = ((y + b) * y + c) * y + d;
        float f1 = (3.0f * y + 2.0f * b) * y + c;
        float f2 = 6.0f * y + 2.0f * b;
        float below = 2.0f * f1 * f1 - f * f2;
        y = y - 2.0f * f * f1 / mssm_max(below, 1e-37f);
    }
    return y;
}

// Three other depths. With one or two of them beyond the receiver, one depth is alone on its side.
MSSM_SHARED struct mssm_split mssm_split6(struct mssm_kernel6 k)
{
    int falling = k.k1 < 0.0f ? 1 : 0;
    int three = k.k2 > 0.0f ? falling : 0; // beyond, where their number is odd
    int two = k.k2 < 0.0f ? 1 : falling;   // beyond, where it is even
    float side_odd = three == 1 ? -1.0f : 1.0f;
    float side = k.k3 < 0.0f ? side_odd : -1.0f;
    float inverse = 1.0f / k.k0;
    float y = mssm_positive_root(side * k.k1 * inverse, k.k2 * inverse, side * k.k3 * inverse);
    float t = side / mssm_max(y, 1e-3f);
    float rest = 1.0f - k.w0;
    float share = mssm_share6(k, t);
    share = mssm_min(share, rest);
    float first_one = share * (k.u0 + t);
    float first_all = -k.w0 * k.u0;
    float first_two = first_all - first_one;
    float nearer_odd = three == 1 ? 0.0f : rest - share;
    float first_odd = three == 1 ? 0.0f : first_two;
    float nearer_even = two == 1 ? share : rest;
    float first_even = two == 1 ? first_one : first_all;
    struct mssm_split r;
    r.nearer = k.k3 < 0.0f ? nearer_odd : nearer_even;
    r.own = k.w0;
    r.first = (k.k3 < 0.0f ? first_odd : first_even) + k.mean * r.nearer;
    return r;
}

MSSM_SHARED mssm_bounds mssm_split_bounds(struct mssm_split s)
{
    mssm_bounds r;
    r.upper = mssm_clamp(1.0f - s.nearer, 0.0f, 1.0f);
    r.lower = mssm_clamp(r.upper - s.own, 0.0f, 1.0f);
    return r;
}

MSSM_SHARED struct mssm_kernel4 mssm_kernel4_of(mssm_moments4 m, float z)
{
    return mssm_make_kernel4(mssm_factorise4(m.b[0], m.b[1], m.b[2], m.b[3]), z);
}

MSSM_SHARED struct mssm_kernel6 mssm_kernel6_of(mssm_moments6 m, float z)
{
    return mssm_make_kernel6(mssm_factorise6(m.b[0], m.b[1], m.b[2], m.b[3], m.b[4], m.b[5]), z);
}

mssm_bounds mssm_visibility4(mssm_moments4 m, float z)
{
    return mssm_split_bounds(mssm_split4(mssm_kernel4_of(m, z)));
}

mssm_bounds mssm_visibility6(mssm_moments6 m, float z)
{
    return mssm_split_bounds(mssm_split6(mssm_kernel6_of(m, z)));
}

MSSM_SHARED float mssm_split_depth(struct mssm_split s, float z, float self_min, float self_max)
{
    float depth = mssm_clamp(z, -1.0f, 1.0f);
    float low = mssm_clamp(self_min, 0.0f, 1.0f);
    float own = mssm_clamp(s.own, low, mssm_clamp(self_max, low, 1.0f));
    float sum = s.nearer + own;
    float mean = (s.first + own * depth) / mssm_max(sum, 1e-7f);
    return sum > 1e-7f ? mssm_clamp(mean, -1.0f, depth) : depth;
}

float mssm_blocker_depth4(mssm_moments4 m, float z, float self_weight_min, float self_weight_max)
{
    struct mssm_split s = mssm_split4(mssm_kernel4_of(m, z));
    return mssm_split_depth(s, z, self_weight_min, self_weight_max);
}

float mssm_blocker_depth6(mssm_moments6 m, float z, float self_weight_min, float self_weight_max)
{
    struct mssm_split s = mssm_split6(mssm_kernel6_of(m, z));
    return mssm_split_depth(s, z, self_weight_min, self_weight_max);
}

// ---- Roots and the full reconstruction ---- >>roots

// One real root of a cubic and the quadratic x^2 + b x + c that is left of it.
struct mssm_deflated {
    float root, b, c;
};

// Real roots of x^2 + b x + c, or the real part twice: x, ascending.
struct mssm_pair {
    float x0, x1;
};

MSSM_SHARED struct mssm_pair mssm_quadratic(float b, float c)
{
    float middle = -0.5f * b;
    float disc = middle * middle - c;
    float root = sqrtf(mssm_max(disc, 0.0f));
    float x = middle < 0.0f ? middle - root : middle + root;
    float y = disc > 0.0f ? c / x : middle; // no cancellation; x is not 0 where disc is not
    struct mssm_pair r;
    r.x0 = mssm_min(x, y);
    r.x1 = mssm_max(y, x);
    return r;
}

// x^3 + b x^2 + c x + d divided by one of its roots: forwards, or backwards where that loses less.
MSSM_SHARED struct mssm_deflated mssm_divide(float b, float c, float d, float root)
{
    struct mssm_deflated r;
    r.root = root;
    r.b = b + root;
    r.c = c + r.b * root;
    float backwards = -d / root;
    int back = root * root > fabsf(r.c) ? 1 : 0;
    r.b = back == 1 ? (backwards - c) / root : r.b;
    r.c = back == 1 ? backwards : r.c;
    return r;
}

// Divides x^3 + b x^2 + c x + d by its simplest real root: the one furthest from the inflection
// point, simple unless all three coincide. Newton's method finds it fast from outside, no further
// than reach from that point, and deflation by it is stable (after Kahan 1986).
MSSM_SHARED struct mssm_deflated mssm_deflate(float b, float c, float d, float reach)
{
    float x = b * (-1.0f / 3.0f);
    float f = ((x + b) * x + c) * x + d;
    float side = f < 0.0f ? -1.0f : 1.0f;
    float size = reach * 1.01f;
    x = x - side * reach;
    for (int i = 0; i < 12; i++) {
        f = ((x + b) * x + c) * x + d;
        float f1 = (3.0f * x + 2.0f * b) * x + c;
        float step = f1 > 0.0f ? side * f / f1 : -size;
        if (fabsf(step) > size) break; // steps shrink, or all is rounding: three equal roots
        size = fabsf(step);
        x = x - side * step;
        if (step >= 0.0f && size <= 1e-6f * fabsf(x)) break; // next to 0 one more has its digits
    }
    return mssm_divide(b, c, d, x);
}

// The same for a cubic of real roots only: the cosine of a third of an angle as a polynomial of its
// cosine h (error 2e-4 of the roots' spread), and a step of Newton's method, to mere rounding.
MSSM_SHARED struct mssm_deflated mssm_deflate_real(float b, float c, float d)
{
    float middle = b * (-1.0f / 3.0f);
    float f = ((middle + b) * middle + c) * middle + d;
    float spread = b * b * (1.0f / 3.0f) - c;
    float unit = sqrtf(spread > 1e-30f ? spread * (1.0f / 3.0f) : 1e-30f);
    float h = mssm_clamp(0.5f * fabsf(f) / (unit * unit * unit + 1e-30f), 0.0f, 1.0f);
    float cosine = 0.8660254f + h * (0.1666667f + h * (-0.0424743f + h * 0.0097823f));
    float x = middle - (f < 0.0f ? -2.0f : 2.0f) * unit * cosine;
    f = ((x + b) * x + c) * x + d;
    float f1 = (3.0f * x + 2.0f * b) * x + c;
    float step = f / mssm_max(f1, 1e-30f); // bounded: next to a triple root it is noise
    x = x - mssm_clamp(step, -0.1f * unit, 0.1f * unit);
    return mssm_divide(b, c, d, x);
}

// How far the roots can lie from the inflection point.
MSSM_SHARED float mssm_reach(float b, float c, float d)
{
    float x = b * (-1.0f / 3.0f);
    float f = fabsf(((x + b) * x + c) * x + d);
    float cube = f > 0.0f ? powf(f, 1.0f / 3.0f) : 0.0f;
    float spread = b * b * (1.0f / 3.0f) - c;
    float root = spread > 0.0f ? sqrtf(spread) : 0.0f;
    return spread > 0.0f ? 1.324718f * mssm_max(cube, root) : cube;
}

// All three roots of a cubic with real ones only; the single one is the lowest or the highest.
MSSM_SHARED mssm_roots3 mssm_sort3(float single, struct mssm_pair p)
{
    mssm_roots3 r;
    r.count = 3;
    r.x[0] = mssm_min(single, p.x0);
    r.x[1] = single < p.x0 ? p.x0 : p.x1;
    r.x[2] = mssm_max(p.x1, single);
    return r;
}

MSSM_SHARED mssm_roots3 mssm_no_roots()
{
    mssm_roots3 r;
    r.x[0] = 0.0f;
    r.x[1] = 0.0f;
    r.x[2] = 0.0f;
    r.count = 0;
    return r;
}

// |c| <= 1. Roots beyond 1e18 count as infinite: so small a leading coefficient lowers the degree.
MSSM_SHARED mssm_roots3 mssm_solve_quadratic(float c0, float c1, float c2)
{
    mssm_roots3 r = mssm_no_roots();
    float a1 = fabsf(c1);
    float a2 = fabsf(c2);
    if (a2 > 1e-36f && a1 <= 1e18f * a2) {
        float b = c1 / c2;
        float c = c0 / c2;
        float size = mssm_max(sqrtf(fabsf(c)), fabsf(b));
        size = size > 1e-37f ? size : 1.0f;
        b = b / size;
        c = mssm_clamp(c / size, -3e38f, 3e38f) / size; // as in mssm_solve_monic
        struct mssm_pair p = mssm_quadratic(b, c);
        // Rounding of b and c alone moves the discriminant by this much.
        if (0.25f * b * b - c >= -4.8e-7f * (0.75f * b * b + fabsf(c))) {
            r.x[0] = p.x0 * size;
            r.x[1] = p.x1 * size;
            r.count = 2;
        }
    } else if (a1 > 1e-36f && fabsf(c0) <= 1e18f * a1) {
        r.x[0] = -c0 / c1;
        r.count = 1;
    }
    return r;
}

// Whether the two roots that s x^3 + b x^2 + c x + d has beside left.root / s are real. A complex
// pair is a double root where rounding of the coefficients can have made it: where the cubic at its
// real part m is noise, disc * (m - root), or next to a triple root, where m is that, |disc|^(3/2).
MSSM_SHARED int mssm_pair_is_real(struct mssm_deflated left, float s, float b, float c, float d)
{
    float m = -0.5f * left.b;
    float am = fabsf(m);
    float disc = left.c - m * m;
    float apart = fabsf(s * m - left.root);
    float imaginary = s * sqrtf(mssm_max(disc, 0.0f));
    float noise = 2e-6f * (((s * am + fabsf(b)) * am + fabsf(c)) * am + fabsf(d));
    return disc * mssm_max(apart, imaginary) <= noise ? 1 : 0;
}

// x^3 + b x^2 + c x + d. x = size * y makes the largest coefficient 1 and |y| < 2. Two roots far
// below the third are found in units of their own, or their squares would leave the range of float.
MSSM_SHARED mssm_roots3 mssm_solve_monic(float b, float c, float d)
{
    float size = mssm_max(sqrtf(fabsf(c)), fabsf(b));
    float size_d = d == 0.0f ? 0.0f : powf(fabsf(d), 1.0f / 3.0f);
    size = mssm_max(size_d, size);
    mssm_roots3 r = mssm_no_roots();
    r.count = 3;
    if (size <= 0.0f) return r;
    float pair = mssm_max(sqrtf(fabsf(d)) / sqrtf(size), fabsf(c) / size);
    float unit = pair < 0.01f * size && pair > 1e-37f ? pair : size;
    float s = unit < size ? unit / size : 1.0f; // not that of a GPU where x / x is less
    b = b / size;
    // The clamps never act: they keep GLSL and -ffast-math from powers of size beyond float.
    c = mssm_clamp(c / size, -3e38f, 3e38f) / unit;
    d = mssm_clamp(mssm_clamp(d / unit, -3e38f, 3e38f) / unit, -3e38f, 3e38f) / size;
    struct mssm_deflated left = mssm_deflate(b, c * s, d * s * s, mssm_reach(b, c * s, d * s * s));
    left.c = s < 1.0f ? -d / left.root : left.c;
    left.b = s < 1.0f ? (left.c * s - c) / left.root : left.b;
    r.x[0] = left.root * size;
    r.count = 1;
    if (mssm_pair_is_real(left, s, b, c, d) == 0) return r;
    struct mssm_pair p = mssm_quadratic(left.b, left.c);
    p.x0 = p.x0 * unit;
    p.x1 = p.x1 * unit;
    return mssm_sort3(r.x[0], p);
}

mssm_roots3 mssm_solve_cubic(float c0, float c1, float c2, float c3)
{
    // An ulp below FLT_MAX: with that itself clang's -ffast-math leaves the comparison out.
    float e0 = mssm_clamp(c0, -3.40282326e38f, 3.40282326e38f);
    float e1 = mssm_clamp(c1, -3.40282326e38f, 3.40282326e38f);
    float e2 = mssm_clamp(c2, -3.40282326e38f, 3.40282326e38f);
    float e3 = mssm_clamp(c3, -3.40282326e38f, 3.40282326e38f);
    float m01 = mssm_max(fabsf(e0), fabsf(e1));
    float m23 = mssm_max(fabsf(e2), fabsf(e3));
    float largest = mssm_max(m01, m23);
    float scale = largest > 1e18f ? 1e-18f : (largest < 1e-18f ? 1e18f : 1.0f);
    largest = largest * scale;
    if (largest <= 0.0f) return mssm_no_roots();
    e0 = e0 * scale / largest;
    e1 = e1 * scale / largest;
    e2 = e2 * scale / largest;
    e3 = e3 * scale / largest;
    float a3 = fabsf(e3);
    if (a3 <= 1e-36f || fabsf(e2) > 1e18f * a3) return mssm_solve_quadratic(e0, e1, e2);
    return mssm_solve_monic(e2 / e3, e1 / e3, e0 / e3);
}

// Distance of a depth whose inverse is v; at most 1000, on the same side.
MSSM_SHARED float mssm_distance(float v)
{
    float v_safe = v < 0.0f ? mssm_min(v, -1e-3f) : mssm_max(v, 1e-3f);
    return 1.0f / v_safe;
}

MSSM_SHARED mssm_points3 mssm_points_of4(struct mssm_kernel4 k)
{
    struct mssm_pair v = mssm_quadratic(k.k1 / k.k0, k.k2 / k.k0);
    float ta = mssm_distance(v.x0);
    float tb = mssm_distance(v.x1);
    float t1 = mssm_min(ta, tb);
    float t2 = mssm_max(tb, ta);
    float s1 = mssm_share4(k, t1);
    float s2 = mssm_share4(k, t2);
    float rest = (1.0f - k.w0) / (s1 + s2);
    mssm_points3 r;
    r.z[0] = k.mean + k.u0;
    r.z[1] = k.mean + (k.u0 + t1);
    r.z[2] = k.mean + (k.u0 + t2);
    r.w[0] = k.w0;
    r.w[1] = s1 * rest;
    r.w[2] = s2 * rest;
    return r;
}

// The given depth, a lone one, and a pair that may be close: not sorted.
MSSM_SHARED mssm_points4 mssm_points_of6(struct mssm_kernel6 k)
{
    float inverse = 1.0f / k.k0;
    struct mssm_deflated left = mssm_deflate_real(k.k1 * inverse, k.k2 * inverse, k.k3 * inverse);
    struct mssm_pair v = mssm_quadratic(left.b, left.c);
    float ta = mssm_distance(left.root);
    float tb = mssm_distance(v.x0);
    float tc = mssm_distance(v.x1);
    // The single root is the well-conditioned one, and so is its share. The shares of a close pair
    // are not, but their sum is: what the others leave.
    float total = 1.0f - k.w0;
    float share_a = mssm_share6(k, ta);
    share_a = mssm_min(share_a, total);
    float s1 = mssm_share6(k, tb);
    float s2 = mssm_share6(k, tc);
    float rest = (total - share_a) / (s1 + s2);
    mssm_points4 r;
    r.z[0] = k.mean + k.u0;
    r.z[1] = k.mean + (k.u0 + ta);
    r.z[2] = k.mean + (k.u0 + tb);
    r.z[3] = k.mean + (k.u0 + tc);
    r.w[0] = k.w0;
    r.w[1] = share_a;
    r.w[2] = s1 * rest;
    r.w[3] = s2 * rest;
    return r;
}

mssm_points3 mssm_reconstruct4(mssm_moments4 m, float z)
{
    mssm_points3 r = mssm_points_of4(mssm_kernel4_of(m, z));
    float z0 = mssm_clamp(z, -1000.0f, 1000.0f);
    float off = z0 - r.z[0]; // rounding, of all depths alike
    r.z[0] = z0;
    for (int i = 1; i < 3; i++) {
        r.z[i] = r.z[i] + off;
        r.w[i] = mssm_min(r.w[i], 1.0f); // quotients of GPUs are off by more than rounding
    }
    return r;
}

mssm_points4 mssm_reconstruct6(mssm_moments6 m, float z)
{
    mssm_points4 r = mssm_points_of6(mssm_kernel6_of(m, z));
    float z0 = mssm_clamp(z, -1000.0f, 1000.0f);
    float off = z0 - r.z[0];
    r.z[0] = z0;
    for (int i = 1; i < 4; i++) {
        r.z[i] = r.z[i] + off;
        r.w[i] = mssm_min(r.w[i], 1.0f);
    }
    for (int i = 0; i < 3; i++) { // three comparisons of neighbours sort three depths
        int j = i == 1 ? 2 : 1;
        float z_low = r.z[j];
        float w_low = r.w[j];
        if (r.z[j + 1] < z_low) {
            r.z[j] = r.z[j + 1];
            r.w[j] = r.w[j + 1];
            r.z[j + 1] = z_low;
            r.w[j + 1] = w_low;
        }
    }
    return r;
}

// ---- Stored moments: factorised in the Chebyshev basis, without decoding ---- >>stored
//
// t holds E[T_k], as a query of the tables gives it. The products T_i T_j = (T_i+j + T_|i-j|) / 2
// make the moment matrix of T_0..T_3 from them. Its pivots are those of powers times 1, 1, 4, 16.
// Skipping the conversion to powers skips its rounding, which the safe bias would have to pay for
// (4e-6, not 1.3e-6, for 6 moments). Bias vectors 1.120 2.884 and .657 .734 1.197; same floors.

MSSM_SHARED struct mssm_pivots mssm_factorise_stored4(mssm_moments4 t, float alpha)
{
    float t1 = t.b[0] - alpha * t.b[0];
    float t2 = t.b[1] - alpha * (t.b[1] - 1.24f);
    float t3 = t.b[2] - alpha * t.b[2];
    float t4 = t.b[3] - alpha * (t.b[3] - 15.112f);
    float d1 = (0.5f + 0.5f * t2) - t1 * t1;
    int valid = d1 > 3.9e-7f ? 1 : 0;
    struct mssm_pivots p;
    p.mean = t1;
    p.d1 = valid == 1 ? d1 : 3.9e-7f;
    float l21 = 0.5f * (t1 + t3) - t1 * t2;
    float c21 = l21 / p.d1;
    float d2 = ((0.5f + 0.5f * t4) - t2 * t2) - l21 * c21;
    p.c21 = valid == 1 ? 0.5f * c21 : 0.0f;
    valid = d2 > 2.3e-6f ? valid : 0;
    p.d2 = valid == 1 ? 0.25f * d2 : 0.0f;
    p.c32 = 0.0f;
    p.d3 = 0.0f;
    return p;
}

MSSM_SHARED struct mssm_pivots mssm_factorise_stored6(mssm_moments6 t, float alpha)
{
    float t1 = t.b[0] - alpha * t.b[0];
    float t2 = t.b[1] - alpha * (t.b[1] - 0.314f);
    float t3 = t.b[2] - alpha * t.b[2];
    float t4 = t.b[3] - alpha * (t.b[3] - 1.616f);
    float t5 = t.b[4] - alpha * t.b[4];
    float t6 = t.b[5] - alpha * (t.b[5] - 13.898f);
    float d1 = (0.5f + 0.5f * t2) - t1 * t1;
    int valid = d1 > 4.3e-7f ? 1 : 0;
    struct mssm_pivots p;
    p.mean = t1;
    p.d1 = valid == 1 ? d1 : 4.3e-7f;
    float i1 = 1.0f / p.d1;
    float l21 = 0.5f * (t1 + t3) - t1 * t2;
    float c21 = l21 * i1;
    float d2 = ((0.5f + 0.5f * t4) - t2 * t2) - l21 * c21;
    p.c21 = valid == 1 ? 0.5f * c21 : 0.0f;
    valid = d2 > 7.9e-7f ? valid : 0;
    p.d2 = valid == 1 ? 0.25f * d2 : 0.0f;
    float l31 = 0.5f * (t2 + t4) - t1 * t3;
    float c31 = l31 * i1;
    float l32 = (0.5f * (t1 + t5) - t2 * t3) - l21 * c31;
    float c32 = l32 / (valid == 1 ? d2 : 1.0f);
    float d3 = ((0.5f + 0.5f * t6) - t3 * t3) - (l31 * c31 + l32 * c32);
    valid = d3 > 3.9e-6f ? valid : 0;
    p.c32 = valid == 1 ? 0.5f * c32 : 0.0f;
    p.d3 = valid == 1 ? 0.0625f * d3 : 0.0f;
    return p;
}
// [glsl end]

#if defined __GNUC__ || defined _MSC_VER
#define MSSM__RESTRICT __restrict
#else
#define MSSM__RESTRICT restrict
#endif

// restrict and the absence of branches in the functions above let compilers vectorise the loops.
void mssm_visibility4_array(int count, const float *const b[4], const float *MSSM__RESTRICT z,
                            float *MSSM__RESTRICT lower, float *MSSM__RESTRICT upper)
{
    const float *b1 = b[0], *b2 = b[1], *b3 = b[2], *b4 = b[3];
    for (int i = 0; i < count; i++) {
        struct mssm_pivots p = mssm_factorise4(b1[i], b2[i], b3[i], b4[i]);
        mssm_bounds r = mssm_split_bounds(mssm_split4(mssm_make_kernel4(p, z[i])));
        lower[i] = r.lower;
        upper[i] = r.upper;
    }
}

void mssm_visibility6_array(int count, const float *const b[6], const float *MSSM__RESTRICT z,
                            float *MSSM__RESTRICT lower, float *MSSM__RESTRICT upper)
{
    const float *b1 = b[0], *b2 = b[1], *b3 = b[2], *b4 = b[3], *b5 = b[4], *b6 = b[5];
    for (int i = 0; i < count; i++) {
        struct mssm_pivots p = mssm_factorise6(b1[i], b2[i], b3[i], b4[i], b5[i], b6[i]);
        mssm_bounds r = mssm_split_bounds(mssm_split6(mssm_make_kernel6(p, z[i])));
        lower[i] = r.lower;
        upper[i] = r.upper;
    }
}

// ---- Lights ---- >>lights

const char *mssm_result_string(mssm_result r)
{
    switch (r) {
    case MSSM_OK: return "no error";
    case MSSM_ERROR_ARGUMENT: return "an argument is null, not finite or out of its range";
    case MSSM_ERROR_MEMORY: return "the memory passed in is too small, or there is none left";
    case MSSM_ERROR_GL_VERSION: return "OpenGL 4.5 is needed";
    case MSSM_ERROR_GL: return "the driver refuses a shader, a framebuffer or storage";
    case MSSM_ERROR_ORDER: return "calls of a depth pass are out of order";
    }
    return "unknown result";
}

// By bit pattern: -ffast-math may fold comparisons with NaN away.
static int mssm__is_finite(float x)
{
    return (mssm_bits(x) & 0x7f800000) != 0x7f800000;
}

// Whether there are numbers, and all finite.
static int mssm__all_finite(const float *x, int count)
{
    for (int i = 0; x && i < count; i++) {
        if (!mssm__is_finite(x[i])) return 0;
    }
    return x != NULL;
}

static int mssm__is_light(const mssm_light *light)
{
    return light->z_far > light->z_near && mssm__all_finite(light->world_to_shadow, 16);
}

static double mssm__dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void mssm__cross(const double a[3], const double b[3], double r[3])
{
    r[0] = a[1] * b[2] - a[2] * b[1];
    r[1] = a[2] * b[0] - a[0] * b[2];
    r[2] = a[0] * b[1] - a[1] * b[0];
}

static int mssm__normalise(double a[3])
{
    double length = sqrt(mssm__dot(a, a));
    if (!(length > 0)) return 0;
    for (int i = 0; i < 3; i++) a[i] /= length;
    return 1;
}

// Fitted frusta end casters here: a receiver right behind them still tells them from texels where
// nothing is hit, depth 1, on which one further off is tested.
#define MSSM_FAR_CASTER 0.8f

// The light's frame: rows u, v, direction, right-handed (u x v = direction). 0 where there is none.
static int mssm__frame(const float direction[3], const float axis_u[3], double frame[3][3])
{
    double *u = frame[0], *v = frame[1], *w = frame[2];
    if (!mssm__all_finite(direction, 3) || !mssm__all_finite(axis_u, 3)) return 0;
    for (int i = 0; i < 3; i++) {
        u[i] = axis_u[i];
        w[i] = direction[i];
    }
    if (!mssm__normalise(w)) return 0;
    int usable = mssm__normalise(u);
    mssm__cross(w, u, v);
    if (!usable || mssm__dot(v, v) < 1e-12) { // none of its own: take the least aligned axis
        int least = fabs(w[0]) < fabs(w[1]) ? (fabs(w[0]) < fabs(w[2]) ? 0 : 2)
                                            : (fabs(w[1]) < fabs(w[2]) ? 1 : 2);
        for (int i = 0; i < 3; i++) u[i] = i == least;
        mssm__cross(w, u, v);
    }
    mssm__normalise(v);
    mssm__cross(v, w, u);
    return 1;
}

static void mssm__set_row(float m[16], int row, const double axis[3], double scale, double offset)
{
    for (int i = 0; i < 3; i++) m[4 * i + row] = (float)(scale * axis[i]);
    m[12 + row] = (float)offset;
}

// Middle and half size of the box in the frame, not flat: a frustum needs an inside. 0: no box.
static int mssm__box_in_frame(double frame[3][3], const float box_min[3], const float box_max[3],
                              double centre[3], double half[3])
{
    double largest = 0;
    for (int a = 0; a < 3; a++) {
        if (box_min[a] > box_max[a]) return 0;
        centre[a] = half[a] = 0;
        for (int i = 0; i < 3; i++) {
            centre[a] += 0.5 * frame[a][i] * ((double)box_max[i] + box_min[i]);
            half[a] += 0.5 * fabs(frame[a][i]) * ((double)box_max[i] - box_min[i]);
        }
        if (half[a] > largest) largest = half[a];
    }
    const double least = largest > 0 ? 1e-3 * largest : 5e-4;
    for (int a = 0; a < 3; a++) {
        if (half[a] < least) half[a] = least;
    }
    return 1;
}

mssm_result mssm_light_directional(mssm_light *light, const float direction[3],
                                   const float axis_u[3], float tan_half_u, float tan_half_v,
                                   const float box_min[3], const float box_max[3])
{
    double frame[3][3], centre[3], half[3];
    if (!light || !mssm__all_finite(box_min, 3) || !mssm__all_finite(box_max, 3) ||
        !mssm__is_finite(tan_half_u) || !mssm__is_finite(tan_half_v) || tan_half_u < 0 ||
        tan_half_v < 0 || !mssm__frame(direction, axis_u, frame) ||
        !mssm__box_in_frame(frame, box_min, box_max, centre, half)) {
        return MSSM_ERROR_ARGUMENT;
    }
    mssm_light r;
    memset(&r, 0, sizeof r);
    // A rim without casters, two texels of 256: maps take it for what lies beyond.
    for (int a = 0; a < 2; a++) half[a] *= 1 + 1.0 / 64;
    // Casters get depths from -1 + 0.01 to MSSM_FAR_CASTER: see there.
    double range = 2 * half[2] / (MSSM_FAR_CASTER + 0.99); // world units per unit of depth
    double nearest = centre[2] + half[2] + 0.01 * range;
    for (int a = 0; a < 2; a++)
        mssm__set_row(r.world_to_shadow, a, frame[a], 1 / half[a], -centre[a] / half[a]);
    mssm__set_row(r.world_to_shadow, 2, frame[2], -1 / range, nearest / range - 1);
    r.world_to_shadow[15] = 1;
    r.half_u = tan_half_u;
    r.half_v = tan_half_v;
    r.extent_u = (float)half[0];
    r.extent_v = (float)half[1];
    r.z_far = (float)(2 * range);
    const float size[3] = {r.extent_u, r.extent_v, r.z_far};
    if (!mssm__all_finite(r.world_to_shadow, 16) || !mssm__all_finite(size, 3))
        return MSSM_ERROR_ARGUMENT;
    *light = r;
    return MSSM_OK;
}

mssm_result mssm_light_spot(mssm_light *light, const float position[3], const float direction[3],
                            const float axis_u[3], float tan_half_fov, float z_near, float z_far,
                            float half_width_u, float half_width_v)
{
    double frame[3][3], eye[3];
    const float sizes[5] = {tan_half_fov, z_near, z_far, half_width_u, half_width_v};
    if (!light || !mssm__all_finite(position, 3) || !mssm__all_finite(sizes, 5) ||
        tan_half_fov <= 0 || z_near <= 0 || z_far <= z_near || half_width_u < 0 ||
        half_width_v < 0 || !mssm__frame(direction, axis_u, frame)) {
        return MSSM_ERROR_ARGUMENT;
    }
    mssm_light r;
    memset(&r, 0, sizeof r);
    for (int i = 0; i < 3; i++) eye[i] = position[i];
    double f = z_far, n = z_near, depth = mssm__dot(frame[2], eye);
    for (int a = 0; a < 2; a++) {
        mssm__set_row(r.world_to_shadow, a, frame[a], 1 / (double)tan_half_fov,
                      -mssm__dot(frame[a], eye) / tan_half_fov);
    }
    double scale = (f + n) / (f - n);
    mssm__set_row(r.world_to_shadow, 2, frame[2], -scale, scale * depth - 2 * f * n / (f - n));
    mssm__set_row(r.world_to_shadow, 3, frame[2], -1, depth);
    r.perspective = 1;
    r.half_u = half_width_u;
    r.half_v = half_width_v;
    r.extent_u = r.extent_v = tan_half_fov;
    r.z_near = z_near;
    r.z_far = z_far;
    if (!mssm__all_finite(r.world_to_shadow, 16)) return MSSM_ERROR_ARGUMENT;
    *light = r;
    return MSSM_OK;
}

// The box's corners as seen from a point: how far along the frame's third axis, and aside of it.
// Returns the largest coordinate that has gone into them.
static double mssm__corners(const float from[3], double frame[3][3], const float box_min[3],
                            const float box_max[3], double z[8], double side[8])
{
    double largest = 0;
    for (int i = 0; i < 8; i++) {
        double p[3];
        for (int k = 0; k < 3; k++) {
            p[k] = (double)(i >> k & 1 ? box_max : box_min)[k] - from[k];
            largest = fmax(largest, fabs(p[k]) + fabs(from[k]));
        }
        z[i] = mssm__dot(frame[2], p);
        side[i] = fmax(fabs(mssm__dot(frame[0], p)), fabs(mssm__dot(frame[1], p)));
    }
    return largest;
}

mssm_result mssm_light_area(mssm_light *light, const float probe[3], const float direction[3],
                            const float axis_u[3], float tan_half_u, float tan_half_v,
                            float distance, const float box_min[3], const float box_max[3])
{
    mssm_light r;
    double frame[3][3], side[8], z[8], low = DBL_MAX, high = -DBL_MAX, away = distance, tangent = 0;
    mssm_result result =
        mssm_light_directional(&r, direction, axis_u, tan_half_u, tan_half_v, box_min, box_max);
    if (result || !light || !mssm__all_finite(probe, 3) ||
        (mssm_bits(distance) & 0x7fffffff) > 0x7f800000 || distance < 0) {
        return MSSM_ERROR_ARGUMENT;
    }
    mssm__frame(direction, axis_u, frame);
    const double largest = mssm__corners(probe, frame, box_min, box_max, z, side);
    for (int i = 0; i < 8; i++) {
        low = fmin(low, z[i]);
        high = fmax(high, z[i]);
        away = fmax(away, z[i] + side[i] / 3); // wider frusta spend their texels on the rim
    }
    // Depths as from a directional light; a flat box has some, too, and more than rounding.
    const double least = fmax(1e-3 * distance, fmax(1e-4 * largest, 1e-6));
    const double range = fmax(high - low, least) / (MSSM_FAR_CASTER + 0.99);
    away = fmax(away, high + 0.02 * range);
    for (int i = 0; i < 8; i++) tangent = fmax(tangent, side[i] / (away - z[i]));
    if (distance > 0 && distance <= FLT_MAX &&
        tangent > fmax(1.0 / 512, fmin(tan_half_u, tan_half_v) / 64.0)) {
        const double z_near = away - high - 0.01 * range;
        float place[3];
        for (int k = 0; k < 3; k++) place[k] = (float)(probe[k] + away * frame[2][k]);
        result = mssm_light_spot(&r, place, direction, axis_u, (float)(tangent * (1 + 1.0 / 64)),
                                 (float)z_near, (float)(z_near + 2 * range),
                                 (float)(away * tan_half_u), (float)(away * tan_half_v));
    }
    if (!result) *light = r;
    return result;
}

int mssm_light_project(const mssm_light *light, const float point[3], float shadow[3])
{
    if (!light || !point || !shadow) return 0;
    const float *m = light->world_to_shadow;
    float c[4];
    for (int i = 0; i < 4; i++)
        c[i] = m[i] * point[0] + m[4 + i] * point[1] + m[8 + i] * point[2] + m[12 + i];
    if (light->perspective) {
        if (!(c[3] > 0)) return 0;
        c[0] /= c[3];
        c[1] /= c[3];
        c[2] = -1 + 2 * (c[3] - light->z_near) / (light->z_far - light->z_near);
    }
    if (!mssm__all_finite(c, 3)) return 0;
    memcpy(shadow, c, 3 * sizeof *c);
    return 1;
}

// Coordinates above this part of the largest have a share: one direction in 18 asks two faces.
#define MSSM_FACE_BAND 0.95f

mssm_result mssm_light_point(mssm_light light[6], const float position[3], float z_near,
                             float z_far, float half_width)
{
    mssm_light face[6];
    if (!light || !(z_near > 0)) return MSSM_ERROR_ARGUMENT;
    // Receivers ask a face as far out as MSSM_FACE_BAND says, and search half_width / z_near there.
    const float tangent = 1.0f / MSSM_FACE_BAND + half_width / z_near;
    for (int i = 0; i < 6; i++) {
        const float sign = i & 1 ? -1.0f : 1.0f; // direction points back to the light
        float direction[3] = {0, 0, 0}, axis_u[3] = {0, 0, 0};
        direction[i / 2] = -sign;
        axis_u[(i / 2 + 1) % 3] = 1;
        const mssm_result r = mssm_light_spot(&face[i], position, direction, axis_u, tangent,
                                              z_near, z_far, half_width, half_width);
        if (r) return r;
    }
    memcpy(light, face, sizeof face);
    return MSSM_OK;
}

// The world's origin goes to a corner of the texels. Where side is a power of two, these are exact.
mssm_result mssm_light_snap(mssm_light *light, int side)
{
    if (!light || light->perspective || side < 1 ||
        !mssm__all_finite(light->world_to_shadow + 12, 2)) {
        return MSSM_ERROR_ARGUMENT;
    }
    for (int i = 12; i < 14; i++) {
        const double corner = floor((light->world_to_shadow[i] + 1.0) * 0.5 * side + 0.5);
        light->world_to_shadow[i] = (float)(corner * 2 / side - 1);
    }
    return MSSM_OK;
}

mssm_result mssm_light_fit(mssm_light *light, float nearest, float farthest)
{
    if (!light || !mssm__is_finite(nearest) || !mssm__is_finite(farthest) || nearest < -1 ||
        nearest > farthest || farthest > 1 || !(light->z_far > light->z_near)) {
        return MSSM_ERROR_ARGUMENT;
    }
    mssm_light r = *light;
    const double width = (double)farthest - nearest > 1e-3 ? (double)farthest - nearest : 1e-3;
    const double range = width / (MSSM_FAR_CASTER + 0.99); // old depth per new depth
    const double start = nearest - 0.01 * range;           // old depth that becomes -1
    const double half = 0.5 * ((double)light->z_far - light->z_near);
    float *m = r.world_to_shadow;
    if (!light->perspective) {
        for (int i = 0; i < 4; i++) m[4 * i + 2] = (float)(m[4 * i + 2] / range);
        m[14] = (float)((light->world_to_shadow[14] - start) / range - 1);
        r.z_far = (float)(r.z_near + 2 * half * range);
    } else {
        const double least = 0.5 * light->z_near;
        double n = light->z_near + (start + 1) * half;
        n = n > least ? n : least;
        const double f = n + 2 * range * half;
        for (int i = 0; i < 4; i++) m[4 * i + 2] = (float)(m[4 * i + 3] * ((f + n) / (f - n)));
        m[14] = (float)(light->world_to_shadow[15] * ((f + n) / (f - n)) - 2 * f * n / (f - n));
        r.z_near = (float)n;
        r.z_far = (float)f;
    }
    if (!mssm__is_light(&r) || !mssm__is_finite(r.z_far)) return MSSM_ERROR_ARGUMENT;
    *light = r;
    return MSSM_OK;
}

float mssm_light_depth(const mssm_light *light, float stored, int reversed)
{
    const float nearness = reversed ? stored : 1.0f - stored; // floats are finest at its 0
    if (!light || !(nearness > 0)) return 1;
    if (!light->perspective) return mssm_clamp(1.0f - 2.0f * nearness, -1.0f, 1.0f);
    const float ratio = light->z_near / light->z_far;
    const float w = light->z_near / (nearness + ratio * (1.0f - nearness));
    return mssm_clamp(-1.0f + 2.0f * (w - light->z_near) / (light->z_far - light->z_near), -1.0f,
                      1.0f);
}

int mssm_depth_range(const float *depth, size_t count, float *nearest, float *farthest)
{
    float low = 2, high = -2;
    for (size_t i = 0; depth && i < count; i++) {
        const float z = depth[i];
        if (!mssm__is_finite(z) || z >= 1) continue;
        low = z < low ? z : low;
        high = z > high ? z : high;
    }
    if (high < low || !nearest || !farthest) return 0;
    *nearest = mssm_clamp(low, -1.0f, 1.0f);
    *farthest = mssm_clamp(high, -1.0f, 1.0f);
    return 1;
}

// [glsl begin lights]
MSSM_SHARED float mssm_face_weight(float v, float largest)
{
    float size = v < 0.0f ? -v : v;
    float w = (size - MSSM_FACE_BAND * largest) / ((1.0f - MSSM_FACE_BAND) * largest);
    return w > 0.0f ? mssm_min(w, 1.0f) : 0.0f;
}

mssm_faces mssm_point_faces(float x, float y, float z)
{
    mssm_faces r;
    float largest = x < 0.0f ? -x : x;
    largest = y > largest ? y : (-y > largest ? -y : largest);
    largest = z > largest ? z : (-z > largest ? -z : largest);
    largest = mssm_max(largest, 1e-30f);
    r.face[0] = x < 0.0f ? 1 : 0;
    r.face[1] = y < 0.0f ? 3 : 2;
    r.face[2] = z < 0.0f ? 5 : 4;
    r.weight[0] = mssm_face_weight(x, largest);
    r.weight[1] = mssm_face_weight(y, largest);
    r.weight[2] = mssm_face_weight(z, largest);
    float sum = r.weight[0] + r.weight[1] + r.weight[2];
    if (!(sum > 0.0f)) {
        r.weight[0] = 1.0f;
        sum = 1.0f;
    }
    for (int i = 0; i < 3; i++) r.weight[i] = r.weight[i] / sum;
    return r;
}

float mssm_attenuation(float distance, float constant, float linear, float quadratic)
{
    float sum = constant + distance * (linear + distance * quadratic);
    return sum > 1e-30f ? 1.0f / sum : 0.0f;
}

float mssm_cone(float cosine, float cos_inner, float cos_outer, float exponent)
{
    float x = mssm_min(mssm_max(cosine, -1.0f), 1.0f);
    float t = (x - cos_outer) / (cos_inner - cos_outer);
    t = t > 0.0f ? mssm_min(t, 1.0f) : 0.0f;
    float along = exponent > 0.0f ? (x > 0.0f ? powf(x, exponent) : 0.0f) : 1.0f;
    return t > 0.0f ? t * t * (3.0f - 2.0f * t) * along : 0.0f;
}
// [glsl end]

// ---- Tables (docs/moments.md, "Tables") ---- >>tables

// A kernel of up to this many texels is served by level 0; level l, where texels are 2^l times as
// wide, serves kernels up to 2^l times as wide. One query of such a kernel reads whole texels of at
// most MSSM_KERNEL^2, so floor((2^31 - 1) / 27^2) is the largest scale that cannot overflow a
// signed difference. 5 less leave room for T_k that rounding takes an ulp or two beyond 1.
#define MSSM_KERNEL 27.0f
#define MSSM_SCALE 2945788
// Less than the inverse by so much that weights which round to a sum above 1 do no harm.
#define MSSM_INVERSE_SCALE ((1.0f - 2.4e-7f) / (float)MSSM_SCALE)
#define MSSM__LEVELS 11 // of a map of 16384^2
#define MSSM__SIDE 16384
#define MSSM__DEPTHS 14 // of such a map: least depths down to one texel

// Level l holds (size + 1)^2 sums of moments channels, with a first row and column of zeros. An
// entry is the sum of round(T_k(depth) * MSSM_SCALE) over all texels left of and below it, modulo
// 2^32: differences are exact as long as what they stand for fits 32 bits.
struct mssm_map {
    int side, moments, levels;
    int averaged; // made of front and back faces
    int size[MSSM__LEVELS];
    uint32_t *table[MSSM__LEVELS];
    int depths; // levels of least depths: level 0 has those of 2 x 2 texels, see mssm_depth_level
    int size_of_depths[MSSM__DEPTHS];
    float (*depth[MSSM__DEPTHS])[2]; // the least depth, and the least of -depth
};

// The number of levels, each half of the one before, until one is at most so wide.
static int mssm__levels(int side, int least)
{
    int levels = 1;
    for (; side > least; side = (side + 1) / 2) levels++;
    return levels;
}

// The texels of all levels, each with a border more texels across and up.
static uint64_t mssm__texels(int side, int levels, int border)
{
    uint64_t texels = 0;
    for (; levels > 0; levels--, side = (side + 1) / 2)
        texels += (uint64_t)(side + border) * (uint64_t)(side + border);
    return texels;
}

// Entries of all tables; 0 for arguments out of range.
static uint64_t mssm__entries(int side, int moments)
{
    if (side < 1 || side > MSSM__SIDE || (moments != 4 && moments != 6)) return 0;
    return (uint64_t)moments * mssm__texels(side, mssm__levels(side, (int)MSSM_KERNEL), 1);
}

size_t mssm_map_bytes(int side, int moments)
{
    const uint64_t entries = mssm__entries(side, moments);
    if (!entries) return 0;
    const int half = (side + 1) / 2;
    const uint64_t depths = mssm__texels(half, mssm__levels(half, 1), 0);
    const uint64_t bytes =
        entries * sizeof(uint32_t) + 2 * depths * sizeof(float) + sizeof(mssm_map) + 63;
    return bytes <= SIZE_MAX ? (size_t)bytes : 0;
}

static float mssm__depth(float z)
{
    return mssm__is_finite(z) ? mssm_clamp(z, -1.0f, 1.0f) : 1.0f;
}

// A row is made in blocks of this many texels: a constant that lets compilers vectorise.
#define MSSM__BLOCK 32

// Adds the Chebyshev polynomials of one sample of each texel to sum[k][texel].
MSSM_SHARED void mssm__add_samples(const float z[MSSM__BLOCK], float sum[6][MSSM__BLOCK])
{
    for (int i = 0; i < MSSM__BLOCK; i++) {
        const mssm_moments6 t = mssm_chebyshev(z[i]);
        sum[0][i] += t.b[0]; // written out: a loop here would not be vectorised
        sum[1][i] += t.b[1];
        sum[2][i] += t.b[2];
        sum[3][i] += t.b[3];
        sum[4][i] += t.b[4];
        sum[5][i] += t.b[5];
    }
}

// Made positive, truncation rounds to nearest.
MSSM_SHARED int32_t mssm__to_integer(float scaled)
{
    return (int32_t)(scaled + ((float)MSSM_SCALE + 1.5f)) - (MSSM_SCALE + 1);
}

// The table values of count texels of a row; front and back hold samples depths for each of them.
MSSM_SHARED void mssm__make_values(const float *front, const float *back, int count, int samples,
                                   int32_t value[6][MSSM__BLOCK])
{
    float sum[6][MSSM__BLOCK] = {{0}}, z[MSSM__BLOCK] = {0};
    for (int s = 0; s < samples; s++) {
        for (int i = 0; i < count; i++) {
            const int at = i * samples + s;
            z[i] = mssm__depth(front[at]);
            if (back) z[i] = 0.5f * (z[i] + mssm__depth(back[at]));
        }
        mssm__add_samples(z, sum);
    }
    const float scale = (float)MSSM_SCALE / (float)samples;
    for (int k = 0; k < 6; k++) {
        for (int i = 0; i < MSSM__BLOCK; i++) value[k][i] = mssm__to_integer(sum[k][i] * scale);
    }
}

// Appends count texels to the row above `below`, whose sums so far are run.
MSSM_SHARED void mssm__append(uint32_t *MSSM__RESTRICT row, const uint32_t *MSSM__RESTRICT below,
                              int32_t value[6][MSSM__BLOCK], int count, uint32_t run[6],
                              int moments)
{
    // In registers: run could be a part of the row for all that the compiler knows.
    uint32_t s0 = run[0], s1 = run[1], s2 = run[2], s3 = run[3], s4 = run[4], s5 = run[5];
    for (int i = 0; i < count; i++) {
        row[0] = below[0] + (s0 += (uint32_t)value[0][i]);
        row[1] = below[1] + (s1 += (uint32_t)value[1][i]);
        row[2] = below[2] + (s2 += (uint32_t)value[2][i]);
        row[3] = below[3] + (s3 += (uint32_t)value[3][i]);
        if (moments == 6) {
            row[4] = below[4] + (s4 += (uint32_t)value[4][i]);
            row[5] = below[5] + (s5 += (uint32_t)value[5][i]);
        }
        row += moments;
        below += moments;
    }
    run[0] = s0;
    run[1] = s1;
    run[2] = s2;
    run[3] = s3;
    run[4] = s4;
    run[5] = s5;
}

// count texels of a row from the level below: each is the mean of the four, or at the end of an odd
// size two or one, that are there, read off their table as one difference.
static void mssm__halve_values(const mssm_map *map, int finer, int x, int y, int count,
                               int32_t value[6][MSSM__BLOCK])
{
    const int size = map->size[finer], moments = map->moments;
    const int y1 = 2 * y + 2 < size ? 2 * y + 2 : size;
    const size_t stride = (size_t)(size + 1) * (size_t)moments;
    const uint32_t *low = map->table[finer] + (size_t)(2 * y) * stride;
    const uint32_t *high = map->table[finer] + (size_t)y1 * stride;
    for (int i = 0; i < count; i++) {
        const int x0 = 2 * (x + i), x1 = x0 + 2 < size ? x0 + 2 : size;
        const int32_t times = 4 / ((x1 - x0) * (y1 - 2 * y));
        const uint32_t *a = low + x0 * moments, *b = low + x1 * moments;
        const uint32_t *c = high + x0 * moments, *d = high + x1 * moments;
        for (int k = 0; k < moments; k++)
            value[k][i] = ((int32_t)(d[k] - c[k] - b[k] + a[k]) * times + 2) >> 2;
    }
}

// One level: from depth, or without any as if all were empty; coarser ones from the one below.
static void mssm__fill_level(mssm_map *map, int level, const float *front, const float *back,
                             int samples)
{
    const int size = map->size[level], moments = map->moments;
    const size_t stride = (size_t)(size + 1) * (size_t)moments;
    int32_t value[6][MSSM__BLOCK];
    for (int k = 0; k < 6; k++) {
        for (int i = 0; i < MSSM__BLOCK; i++) value[k][i] = MSSM_SCALE;
    }
    for (int y = 0; y < size; y++) {
        uint32_t run[6] = {0};
        uint32_t *below = map->table[level] + (size_t)y * stride + moments;
        for (int x = 0; x < size; x += MSSM__BLOCK) {
            const int count = size - x < MSSM__BLOCK ? size - x : MSSM__BLOCK;
            const size_t first = ((size_t)y * (size_t)size + (size_t)x) * (size_t)samples;
            if (level > 0) {
                mssm__halve_values(map, level - 1, x, y, count, value);
            } else if (front) {
                mssm__make_values(front + first, back ? back + first : NULL, count, samples, value);
            }
            uint32_t *at = below + x * moments;
            if (moments == 6)
                mssm__append(at + stride, at, value, count, run, 6);
            else
                mssm__append(at + stride, at, value, count, run, 4);
        }
    }
}

static void mssm__coarsen_depths(mssm_map *map)
{
    for (int level = 1; level < map->depths; level++) {
        const int size = map->size_of_depths[level], finer = map->size_of_depths[level - 1];
        const int step = level > 1 ? 2 : 1; // from level 1 on a texel has the next in it
        for (int p = 0; p < size * size; p++) {
            const int x = 2 * (p % size), y = 2 * (p / size);
            float *least = map->depth[level][p];
            least[0] = least[1] = 1;
            for (int i = y; i < y + 4 && i < finer; i += step) {
                for (int j = x; j < x + 4 && j < finer; j += step) {
                    const float *at = map->depth[level - 1][(size_t)i * (size_t)finer + (size_t)j];
                    least[0] = mssm_min(at[0], least[0]);
                    least[1] = mssm_min(at[1], least[1]);
                }
            }
        }
    }
}

// Least depths and greatest ones of all levels, or without a map 1.
static void mssm__fill_depths(mssm_map *map, const float *front, const float *back, int samples)
{
    const size_t size = (size_t)map->size_of_depths[0], side = (size_t)map->side;
    for (size_t i = 0; i < size * size; i++) {
        map->depth[0][i][0] = 1;
        map->depth[0][i][1] = front ? 1.0f : -1.0f;
    }
    for (size_t y = 0, i = 0; front && y < side; y++) {
        for (size_t x = 0; x < side; x++) {
            float *least = map->depth[0][y / 2 * size + x / 2];
            for (const size_t end = i + (size_t)samples; i < end; i++) {
                float z = mssm__depth(front[i]);
                if (back) z = 0.5f * (z + mssm__depth(back[i]));
                least[0] = mssm_min(z, least[0]);
                least[1] = mssm_min(-z, least[1]);
            }
        }
    }
    mssm__coarsen_depths(map);
}

static void mssm__fill(mssm_map *map, const float *front, const float *back, int samples)
{
    for (int level = 0; level < map->levels; level++)
        mssm__fill_level(map, level, front, back, samples);
    mssm__fill_depths(map, front, back, samples);
}

mssm_result mssm_map_init(mssm_map **map, void *memory, size_t bytes, int side, int moments)
{
    const size_t needed = mssm_map_bytes(side, moments);
    if (!map || !memory || !needed) return MSSM_ERROR_ARGUMENT;
    if (bytes < needed) return MSSM_ERROR_MEMORY;
    const size_t misfit = (size_t)((uintptr_t)memory % 16);
    mssm_map *m = (mssm_map *)(void *)((unsigned char *)memory + (misfit ? 16 - misfit : 0));
    memset(m, 0, sizeof *m);
    m->side = side;
    m->moments = moments;
    m->levels = mssm__levels(side, (int)MSSM_KERNEL);
    uint32_t *table = (uint32_t *)(void *)(m + 1);
    memset(table, 0, (size_t)mssm__entries(side, moments) * sizeof *table);
    for (int level = 0, size = side; level < m->levels; level++, size = (size + 1) / 2) {
        m->size[level] = size;
        m->table[level] = table;
        table += (size_t)(size + 1) * (size_t)(size + 1) * (size_t)moments;
    }
    m->depths = mssm__levels((side + 1) / 2, 1);
    float(*depth)[2] = (float(*)[2])(void *)table;
    for (int level = 0, size = (side + 1) / 2; level < m->depths; level++, size = (size + 1) / 2) {
        m->size_of_depths[level] = size;
        m->depth[level] = depth;
        depth += (size_t)size * (size_t)size;
    }
    mssm__fill(m, NULL, NULL, 1);
    *map = m;
    return MSSM_OK;
}

mssm_result mssm_map_update(mssm_map *map, const float *front, const float *back, int samples)
{
    if (!map || !front || samples < 1 || samples > 64) return MSSM_ERROR_ARGUMENT;
    mssm__fill(map, front, back, samples);
    map->averaged = back != NULL;
    return MSSM_OK;
}

// Larger coordinates and kernels, in texels, are clamped: half a texel is still told apart there.
#define MSSM_FAR_AWAY 1e6f

// [glsl begin shading]
// One axis of an interpolated query: four table columns (or rows), and the weights of the three
// strips between them: a part of the first texel, whole texels (weight 1), a part of the last one.
struct mssm_strips {
    float edge[4];
    float first;
    float last;
    float whole; // length of all
    float known; // and of what stands for the map
};

// What lies beyond the map is not known: its outermost texels stand for as much of it as the query
// has inside, so that a frustum may cut through the world. Further out all is lit.
MSSM_SHARED struct mssm_strips mssm_cut(float begin, float to, float size)
{
    struct mssm_strips r;
    float inside = mssm_clamp(to, 0.0f, size) - mssm_clamp(begin, 0.0f, size);
    float low = mssm_max(begin, -inside);
    float high = mssm_min(to, size + inside);
    float start = mssm_whole(mssm_clamp(begin, 0.0f, size - 1.0f));
    float end = mssm_whole(mssm_clamp(to, 0.0f, size - 1.0f));
    float next = start + 1.0f;
    r.edge[0] = start;
    r.edge[1] = next;
    r.edge[2] = mssm_max(end, next);
    r.edge[3] = mssm_min(r.edge[2] + 1.0f, size);
    r.first = mssm_max((end > start ? next : high) - low, 0.0f);
    r.last = end > start ? high - end : 0.0f;
    r.whole = to - begin;
    r.known = mssm_max(high - low, 0.0f);
    return r;
}

// One axis of a square of the map, in texels of least depth.
struct mssm_span {
    float low;
    float high;
};

// The level that serves a kernel this wide in texels of level 0, of a map with so many levels.
// From the exponents: how often MSSM_KERNEL must be doubled to hold it.
MSSM_SHARED int mssm_level_of(float width, int levels)
{
    int level = (mssm_bits(mssm_max(width, MSSM_KERNEL)) - mssm_bits(MSSM_KERNEL) + 0x7fffff) >> 23;
    return level < levels - 1 ? level : levels - 1;
}

// The level of least depth that serves such a square: 0, of 2 x 2 texels, as long as it touches no
// more than two of them on an axis; then the one whose texels, 2^(level + 1) wide, are as wide as
// half_size, so that it touches three. There each has the least of itself and the next, right and
// below: two reads on an axis see three texels.
MSSM_SHARED int mssm_depth_level(float half_size, int levels)
{
    int level = (mssm_bits(mssm_max(half_size, 4.0f)) - mssm_bits(2.0f) + 0x7fffff) >> 23;
    level = half_size > 1.0f ? level : 0;
    return level < levels - 1 ? level : levels - 1;
}

// First and last texel of least depth on one axis, with fractions; scale is one over their width.
MSSM_SHARED struct mssm_span mssm_cut_depths(float x, float half_size, float scale, float size)
{
    struct mssm_span r;
    r.low = mssm_clamp((x - half_size) * scale, 0.0f, size - 1.0f);
    r.high = mssm_clamp((x + half_size) * scale, 0.0f, size - 1.0f);
    return r;
}
// [glsl end]

// The strips of one row of a table, of four neighbouring channels: a vector loop, as is the next.
MSSM_SHARED void mssm__cut_row(const uint32_t *row, const size_t at[4], uint32_t strip[3][4])
{
    for (size_t k = 0; k < 4; k++) {
        const uint32_t a = row[at[0] + k], b = row[at[1] + k];
        const uint32_t c = row[at[2] + k], d = row[at[3] + k];
        strip[0][k] = b - a;
        strip[1][k] = c - b;
        strip[2][k] = d - c;
    }
}

// Sums between two rows. Partial strips come before whole ones, here and below: MSSM_BIAS*_TABLE
// was proved for this order of rounding.
MSSM_SHARED void mssm__add_strips(uint32_t low[3][4], uint32_t high[3][4], struct mssm_strips x,
                                  float sum[4])
{
    for (size_t k = 0; k < 4; k++) {
        const float first = (float)(int32_t)(high[0][k] - low[0][k]);
        const float whole = (float)(int32_t)(high[1][k] - low[1][k]);
        const float last = (float)(int32_t)(high[2][k] - low[2][k]);
        sum[k] = (x.first * first + x.last * last) + whole;
    }
}

// Chebyshev moments of the rectangle around (x, y) with the given half-sizes, all in texels of
// level 0 and at least half a texel. Nine rectangles of whole texels, each an exact integer, are
// summed with the share of the query that covers them; depth 1 where mssm_cut knows nothing.
static mssm_moments6 mssm_query(const mssm_map *map, int moments, float x, float y, float half_x,
                                float half_y)
{
    const int level = mssm_level_of(2.0f * mssm_max(half_x, half_y), map->levels);
    const float size = (float)map->size[level], scale = 1.0f / (float)(1 << level);
    const struct mssm_strips sx = mssm_cut((x - half_x) * scale, (x + half_x) * scale, size);
    const struct mssm_strips sy = mssm_cut((y - half_y) * scale, (y + half_y) * scale, size);
    const float area = sx.whole * sy.whole;
    const float inverse = MSSM_INVERSE_SCALE / area;
    const float outside = (area - sx.known * sy.known) / area; // exactly 0 where nothing is
    const size_t channels = (size_t)map->moments;
    const size_t stride = (size_t)(map->size[level] + 1) * channels;
    const size_t left = (size_t)sx.edge[0] * channels, right = (size_t)sx.edge[2] * channels;
    const size_t at[4] = {left, left + channels, right, (size_t)sx.edge[3] * channels};
    const size_t top = (size_t)sy.edge[0] * stride, bottom = (size_t)sy.edge[2] * stride;
    const size_t row[4] = {top, top + stride, bottom, (size_t)sy.edge[3] * stride};
    mssm_moments6 t = {{0}};
    for (int first = 0; first <= moments - 4; first += 2) { // channels 0 to 3, then 2 to 5
        const uint32_t *table = map->table[level] + first;
        uint32_t cut[4][3][4];
        float strip[3][4];
        // No loops: compilers keep all of it in registers then, and a query takes a third less.
        mssm__cut_row(table + row[0], at, cut[0]);
        mssm__cut_row(table + row[1], at, cut[1]);
        mssm__cut_row(table + row[2], at, cut[2]);
        mssm__cut_row(table + row[3], at, cut[3]);
        mssm__add_strips(cut[0], cut[1], sx, strip[0]);
        mssm__add_strips(cut[1], cut[2], sx, strip[1]);
        mssm__add_strips(cut[2], cut[3], sx, strip[2]);
        for (int k = 0; k < 4; k++) {
            const float partial = sy.first * strip[0][k] + sy.last * strip[2][k];
            t.b[first + k] = (partial + strip[1][k]) * inverse + outside;
        }
    }
    return t;
}

// Least depth, or least of -depth, of all texels within half_size texels of (x, y), and of some
// around: four reads.
static float mssm__least(const mssm_map *map, float x, float y, float half_size, int which)
{
    const int level = mssm_depth_level(half_size, map->depths), size = map->size_of_depths[level];
    const float scale = 0.5f / (float)(1 << level);
    const struct mssm_span sx = mssm_cut_depths(x, half_size, scale, (float)size);
    const struct mssm_span sy = mssm_cut_depths(y, half_size, scale, (float)size);
    const int next = level > 0, left = (int)sx.low, top = (int)sy.low;
    const int right = (int)sx.high - next > left ? (int)sx.high - next : left;
    const int bottom = (int)sy.high - next > top ? (int)sy.high - next : top;
    const float *high = &map->depth[level][(size_t)top * (size_t)size][which];
    const float *low = &map->depth[level][(size_t)bottom * (size_t)size][which];
    return mssm_min(mssm_min(high[2 * left], high[2 * right]),
                    mssm_min(low[2 * left], low[2 * right]));
}

// ---- Estimators (docs/moments.md, "Layers") ---- >>estimators
//
// Shared with GLSL, where a map is the number of a light, in a type of its mssm_gl's own.
#define MSSM_MAP const mssm_map *
#define MSSM_LEAST_DEPTH(map, x, y, half_size) mssm__least(map, x, y, half_size, 0)
#define MSSM_GREATEST_DEPTH(map, x, y, half_size) (-mssm__least(map, x, y, half_size, 1))
#define MSSM_CALLED static // shared, but called, not inlined: the bulk of the code

// [glsl begin shading]
// A light and its map as shading sees them. Scalars only: std430 lays it out as C does.
typedef struct mssm_view {
    float world_to_shadow[16];
    float kernel_u; // half-width of the kernel in texels per unit of blur depth, see below
    float kernel_v;
    float distance_scale; // distance along the axis = scale * z + offset
    float distance_offset;
    float texel; // width of a texel in units of z; perspective: at distance 1
    float side;
    float max_half; // of the kernel, in texels
    int perspective;
    int averaged; // the map is made of front and back faces
    int levels;   // of its tables
} mssm_view;

// Settings with their defaults filled in.
struct mssm_options {
    int moments;   // 4 or 6
    int estimator; // 0 layered, 1 lower, 2 upper blocker, 3 layered above the horizon
    float alpha4;
    float alpha6;
    float depth_bias; // 0: three quarters of a texel
    float tolerance;
};

// A receiver as the estimators see it. A blocker at depth zb blurs over a kernel whose half-width
// in texels is kernel * (blur_depth(z) - blur_depth(zb)). Blur depth is depth for directional
// lights; for perspective ones it is -1/distance, which makes similar triangles out of the same
// formula.
struct mssm_receiver {
    float x; // texels of level 0
    float y;
    float z_test;     // depth less the bias, and never behind the empty texels
    float z_own;      // depths from z_own - fade to z_own belong in part to the receiver's surface
    float sharp;      // 1 / fade
    float coarse;     // the same without a normal
    float blur_depth; // of the receiver
    float d_max;      // its distance from the near plane, in blur depth
    float kernel_u;   // the view's, or what the receiver's horizon leaves of it
    float kernel_v;
    float shift_u; // of the kernel's centre, in texels per unit of blur depth
    float shift_v;
    float sink;   // of what is further off than the kernel is for, below the tangent plane
    float rise_u; // of its tangent plane, in blur depth per texel
    float rise_v;
    int plane; // 0 unknown, 1 known, 2 and cuts the light
    int lit;   // whatever the map holds
};

MSSM_SHARED float mssm_blur_depth(mssm_view v, float z)
{
    return v.perspective != 0 ? -1.0f / (v.distance_scale * z + v.distance_offset) : z;
}

// Distance in blur depth from the receiver to a depth before or behind it, no further than the near
// plane.
MSSM_SHARED float mssm_blur_distance(mssm_view v, struct mssm_receiver r, float z)
{
    float d = r.blur_depth - mssm_blur_depth(v, mssm_clamp(z, -1.0f, 1.0f));
    return mssm_clamp(fabsf(d), 0.0f, r.d_max);
}

// Row of the light's matrix times a point.
MSSM_SHARED float mssm_row(mssm_view v, int row, float x, float y, float z)
{
    return v.world_to_shadow[row] * x + v.world_to_shadow[4 + row] * y +
           v.world_to_shadow[8 + row] * z + v.world_to_shadow[12 + row];
}

// From shadow-space coordinates. Overflow and NaN end up far outside of the map.
MSSM_SHARED struct mssm_receiver mssm_receive_at(mssm_view v, struct mssm_options o, float x,
                                                 float y, float depth)
{
    struct mssm_receiver r;
    float z = mssm_clamp(depth, -MSSM_FAR_AWAY, MSSM_FAR_AWAY);
    r.lit = z > -1.0f ? 0 : 1;
    r.x = mssm_clamp((0.5f + 0.5f * x) * v.side, -MSSM_FAR_AWAY, MSSM_FAR_AWAY);
    r.y = mssm_clamp((0.5f + 0.5f * y) * v.side, -MSSM_FAR_AWAY, MSSM_FAR_AWAY);
    float width = v.perspective != 0 ? v.distance_scale * z + v.distance_offset : 1.0f;
    float texel = v.texel * width;
    float bias = v.averaged != 0 ? 0.0f : 0.75f * texel;
    float fade = v.averaged != 0 ? 2.0f * texel : 1.5f * texel;
    bias = o.depth_bias > 0.0f ? o.depth_bias : bias;
    r.sharp = 1.0f / (o.depth_bias > 0.0f ? 2.0f * o.depth_bias : fade);
    r.coarse = r.sharp;
    r.z_own = z - bias;
    r.z_test = mssm_min(r.z_own, 1.0f);
    r.blur_depth = mssm_blur_depth(v, z);
    r.d_max = r.blur_depth - mssm_blur_depth(v, -1.0f);
    r.rise_u = 0.0f;
    r.rise_v = 0.0f;
    r.plane = 0;
    r.kernel_u = v.kernel_u;
    r.kernel_v = v.kernel_v;
    r.shift_u = 0.0f;
    r.shift_v = 0.0f;
    r.sink = 0.0f;
    return r;
}

MSSM_SHARED struct mssm_receiver mssm_receive(mssm_view v, struct mssm_options o, float x, float y,
                                              float z)
{
    float u = mssm_row(v, 0, x, y, z);
    float w = mssm_row(v, 1, x, y, z);
    float depth = mssm_row(v, 2, x, y, z);
    if (v.perspective != 0) {
        float axis = mssm_row(v, 3, x, y, z);
        float inverse = 1.0f / (axis > 1e-30f ? axis : 1e-30f);
        u = u * inverse;
        w = w * inverse;
        depth = axis > 0.0f ? (axis - v.distance_offset) / v.distance_scale : -1.0f;
    }
    return mssm_receive_at(v, o, u, w, depth);
}

// A normal along a row of the light's matrix, in shadow-space units.
MSSM_SHARED float mssm_along_row(mssm_view v, int row, float nx, float ny, float nz)
{
    float x = v.world_to_shadow[row];
    float y = v.world_to_shadow[4 + row];
    float z = v.world_to_shadow[8 + row];
    return (nx * x + ny * y + nz * z) / mssm_max(x * x + y * y + z * z, 1e-37f);
}

// The horizon leaves of the light, (a, b) in [-1,1]^2, where facing + slope_u a + slope_v b > 0.
// The rectangle that stands for that has its corner in the light's furthest above, as much area,
// and is narrower in equal parts of the slopes' squares. By up to a fifth it stays off the horizon,
// where the receiver's own body begins. What it covers moves with the distance: the kernels'
// centres shift. Of a light that has set, a spot at the horizon is left, where the rest of a disc
// may still be; up to twice as deep the whole light comes back: who asks then lights from behind.
MSSM_CALLED struct mssm_receiver mssm_cut_light(mssm_view v, struct mssm_receiver r, float facing,
                                                float slope_u, float slope_v)
{
    float all = mssm_max(fabsf(facing) + fabsf(slope_u) + fabsf(slope_v), 1e-37f);
    float s = facing / all;
    float u = slope_u / all;
    float w = slope_v / all;
    // Where the horizon is along an axis, its two ends are alike: no jump from one to the other.
    float p = mssm_max(fabsf(u), 0.05f);
    float q = mssm_max(fabsf(w), 0.05f);
    float cut = mssm_clamp(2.0f + s / (p + q), 0.0f, 1.0f);
    if (s >= p + q || cut <= 0.0f) return r;
    float above = mssm_max(s + p + q, 0.0f); // of the furthest corner; then of its neighbours
    float above_u = mssm_max(s + p - q, 0.0f);
    float above_v = mssm_max(s - p + q, 0.0f);
    float share = (above * above - above_u * above_u - above_v * above_v) / (8.0f * p * q);
    share = mssm_clamp(share, 0.0f, 1.0f);
    float squares = (1.0f - share) / (p * p + q * q);
    float half_u = 1.0f - p * p * squares;
    float half_v = 1.0f - q * q * squares;
    float scale = sqrtf(share / (half_u * half_v)) * mssm_max(2.0f * share - 1.0f, 0.8f);
    half_u = half_u * scale;
    half_v = half_v * scale;
    float most = MSSM_FAR_AWAY / mssm_max(r.d_max, 1e-30f);
    r.shift_u = cut * u / p * mssm_min((1.0f - half_u) * v.kernel_u, most);
    r.shift_v = cut * w / q * mssm_min((1.0f - half_v) * v.kernel_v, most);
    r.kernel_u = (1.0f - cut + cut * half_u) * v.kernel_u;
    r.kernel_v = (1.0f - cut + cut * half_v) * v.kernel_v;
    r.sink = s < 0.0f ? -s * cut / (above + (cut - 1.0f) * s + 1e-6f) : 0.0f;
    r.plane = 2;
    return r;
}

// A plane that rises by less than two texels of depth a texel is told from closer blockers: one
// that faces the light by half of the fade and two thirds of the bias. That takes 1 to 4% of the
// error; half of the bias would double it, but darken points half a texel below their surface.
MSSM_SHARED struct mssm_receiver mssm_narrow_fade(mssm_view v, struct mssm_receiver r)
{
    float per_depth = v.perspective != 0 ? v.distance_scale * r.blur_depth * r.blur_depth : 1.0f;
    float rise = 1.5f * r.sharp * (r.rise_u + r.rise_v) / per_depth; // in texels of depth
    float narrow = mssm_min(0.5f + 0.25f * rise, 1.0f);
    r.z_own += (1.0f - narrow) / (3.0f * r.sharp); // the bias is half of the fade
    r.z_test = mssm_min(r.z_own, 1.0f);
    r.sharp = r.sharp / narrow;
    return r;
}

// Adds the tangent plane; a normal of zero or NaN leaves it unknown. Blur depth is linear on the
// map along a plane also for perspective lights.
MSSM_CALLED struct mssm_receiver mssm_tangent(mssm_view v, struct mssm_options o,
                                              struct mssm_receiver r, float nx, float ny, float nz)
{
    float u = mssm_along_row(v, 0, nx, ny, nz);
    float w = mssm_along_row(v, 1, nx, ny, nz);
    float along = mssm_along_row(v, v.perspective != 0 ? 3 : 2, nx, ny, nz);
    float texel = 2.0f / mssm_max(v.side, 1.0f);
    if (v.perspective != 0) {
        along = along + u * (r.x * texel - 1.0f) + w * (r.y * texel - 1.0f);
        along = along / mssm_max(-r.blur_depth, 1e-37f);
    }
    float steep = texel / mssm_max(fabsf(along), 1e-37f);
    r.rise_u = mssm_clamp(fabsf(u) * steep, 0.0f, MSSM_FAR_AWAY);
    r.rise_v = mssm_clamp(fabsf(w) * steep, 0.0f, MSSM_FAR_AWAY);
    r.plane = fabsf(nx) + fabsf(ny) + fabsf(nz) > 0.0f ? 1 : 0;
    if (r.plane == 0) return r;
    if (v.averaged == 0 && o.depth_bias <= 0.0f) r = mssm_narrow_fade(v, r);
    if (o.estimator != 3) return r;
    return mssm_cut_light(v, r, -along, u * texel * v.kernel_u, w * texel * v.kernel_v);
}

MSSM_SHARED float mssm_half_width(mssm_view v, float kernel, float d)
{
    return mssm_clamp(kernel * d, 0.5f, v.max_half);
}

// A square of the map, in texels.
struct mssm_square {
    float x;
    float y;
    float half_size;
};

// What holds the kernels of all blockers up to distance d. Where they shift they do not lie in each
// other: all between the widest and the receiver, and as much more as the narrowest, half a texel.
MSSM_SHARED struct mssm_square mssm_search_square(mssm_view v, struct mssm_receiver r, float d)
{
    float wide = mssm_max(r.kernel_u, r.kernel_v);
    struct mssm_square s;
    s.x = r.x;
    s.y = r.y;
    s.half_size = mssm_half_width(v, wide, d);
    if (r.plane != 2) return s;
    float out_u = fabsf(r.shift_u);
    float out_v = fabsf(r.shift_v);
    float reach_u = 0.5f * (out_u + r.kernel_u);
    float reach_v = 0.5f * (out_v + r.kernel_v);
    s.x = r.x + mssm_clamp(r.shift_u, -reach_u, reach_u) * d;
    s.y = r.y + mssm_clamp(r.shift_v, -reach_v, reach_v) * d;
    wide = mssm_max(mssm_max(wide, reach_u), reach_v);
    s.half_size = mssm_half_width(v, wide, d) + mssm_min((out_u + out_v) * d, 0.5f);
    return s;
}

// [glsl end]
// [glsl begin estimate]
// Chebyshev moments of the kernel for blockers at distance d.
MSSM_SHARED mssm_moments6 mssm_filter_moments(MSSM_MAP map, mssm_view v, struct mssm_receiver r,
                                              int moments, float d)
{
    return mssm_query(map, moments, r.x + r.shift_u * d, r.y + r.shift_v * d,
                      mssm_half_width(v, r.kernel_u, d), mssm_half_width(v, r.kernel_v, d));
}
// [glsl end]

// [glsl begin shading]
MSSM_SHARED struct mssm_kernel4 mssm_kernel4_stored(mssm_moments6 t, float alpha, float z)
{
    mssm_moments4 t4;
    t4.b[0] = t.b[0];
    t4.b[1] = t.b[1];
    t4.b[2] = t.b[2];
    t4.b[3] = t.b[3];
    return mssm_make_kernel4(mssm_factorise_stored4(t4, alpha), z);
}

MSSM_SHARED struct mssm_kernel6 mssm_kernel6_stored(mssm_moments6 t, float alpha, float z)
{
    return mssm_make_kernel6(mssm_factorise_stored6(t, alpha), z);
}

// The depths that Chebyshev moments hold; z[0] is the receiver's.
MSSM_SHARED mssm_points4 mssm_layers(struct mssm_options o, int moments, mssm_moments6 t, float z)
{
    if (moments == 6) return mssm_points_of6(mssm_kernel6_stored(t, o.alpha6, z));
    mssm_points3 p = mssm_points_of4(mssm_kernel4_stored(t, o.alpha4, z));
    mssm_points4 q;
    for (int i = 0; i < 3; i++) {
        q.z[i] = p.z[i];
        q.w[i] = p.w[i];
    }
    q.z[3] = 1.0f;
    q.w[3] = 0.0f;
    return q;
}

// What a depth blocks: nothing behind the receiver, and only a part of what may be its own surface.
MSSM_SHARED float mssm_blocked(struct mssm_receiver r, float z, float w)
{
    return z < r.z_test ? w * mssm_clamp((r.z_own - z) * r.sharp, 0.0f, 1.0f) : 0.0f;
}

// How far the receiver's tangent plane comes towards the light within the kernel for distance d:
// less than d where the whole light is above the horizon.
MSSM_SHARED float mssm_plane_reach(mssm_view v, struct mssm_receiver r, float d)
{
    if (r.plane == 0) return 0.0f;
    return mssm_min(r.rise_u * mssm_half_width(v, v.kernel_u, d) +
                        r.rise_v * mssm_half_width(v, v.kernel_v, d),
                    d);
}

// The part of a blocker that is neither the receiver's tangent plane nor below it; its distance in
// units of the kernel's and of the plane's reach. A plane's moments have their points in front
// between a third and all of its reach. Seen from behind, it is at 1 where the kernel begins and 1 +
// 1 / sink where the light ends.
MSSM_SHARED float mssm_off_plane(struct mssm_receiver r, float relative, float reach)
{
    return mssm_clamp((reach - 0.3f) * (1.0f / 0.7f), 0.0f, 1.0f) *
           mssm_clamp(1.0f + r.sink - r.sink * relative, 0.0f, 1.0f);
}

// Where the range of depth is long, the moment bias lets light through: about half of alpha /
// distance^2, in depths from -1 to 1. Whether that may be all of a visibility.
MSSM_SHARED int mssm_bias_leaks(struct mssm_options o, float distance, float visible)
{
    float alpha = o.moments == 6 ? o.alpha6 : o.alpha4;
    return alpha > visible * distance * distance ? 1 : 0;
}

// [glsl end]
// [glsl begin estimate]
// Least depth in the cone up to distance d.
MSSM_SHARED float mssm_cone_least(MSSM_MAP map, mssm_view v, struct mssm_receiver r, float d)
{
    struct mssm_square s = mssm_search_square(v, r, d);
    return MSSM_LEAST_DEPTH(map, s.x, s.y, s.half_size);
}

// The least distance that the kernel of every blocker of the receiver reaches no further than, or 0
// where nothing can block: from the least depth in the cone of the light up to the near plane, and
// then in the cone up to there, as long as that helps.
MSSM_SHARED float mssm_cone_reach(MSSM_MAP map, mssm_view v, struct mssm_receiver r)
{
    float kernel = mssm_max(r.kernel_u, r.kernel_v);
    float d = r.d_max;
    float before;
    int i = 0;
    do {
        float z = mssm_cone_least(map, v, r, d);
        if (z >= r.z_test) return 0.0f;
        before = d;
        d = mssm_min(mssm_blur_distance(v, r, z), d);
        i = i + 1;
    } while (i < 6 && d < 0.8f * before && kernel * d > 0.5f);
    return d;
}

// What a receiver sees without the light that is the moment bias alone: none where all that the cone
// holds up to distance d hides it. What blocks the whole light is at least the fade in front; more
// than the bias lets through comes through gaps between layers, which the depth that is greatest does
// not tell of. Beyond the map nothing hides.
MSSM_CALLED float mssm_without_leak(MSSM_MAP map, mssm_view v, struct mssm_options o,
                                    struct mssm_receiver r, float d, float visible)
{
    if (visible <= o.tolerance || mssm_bias_leaks(o, 1.0f / r.sharp, visible) == 0) return visible;
    if (mssm_clamp(r.x, 0.0f, v.side) != r.x || mssm_clamp(r.y, 0.0f, v.side) != r.y)
        return visible;
    struct mssm_square s = mssm_search_square(v, r, d);
    float z = MSSM_GREATEST_DEPTH(map, s.x, s.y, s.half_size);
    if (mssm_bias_leaks(o, r.z_test - z, visible) == 0) return visible;
    return mssm_blocked(r, z, 1.0f) < 1.0f ? visible : 0.0f;
}

// Mean distance of the blockers in the kernel for distance d, weighted by it once more: a little of
// the receiver's own surface does no harm. Only where to look first depends on it, so that four
// moments do.
MSSM_CALLED float mssm_mean_distance(MSSM_MAP map, mssm_view v, struct mssm_options o,
                                     struct mssm_receiver r, float d)
{
    mssm_points4 p = mssm_layers(o, 4, mssm_filter_moments(map, v, r, 4, d), r.z_test);
    float sum = 1e-3f * d;
    float squares = sum * d;
    for (int j = 1; j < 3; j++) {
        if (p.z[j] >= r.z_test) continue;
        float distance = mssm_blur_distance(v, r, p.z[j]);
        sum += p.w[j] * distance;
        squares += p.w[j] * distance * distance;
    }
    return mssm_min(squares / mssm_max(sum, 1e-37f), d);
}
// [glsl end]

// [glsl begin shading]
// One of the nested kernels. It stands for blockers at distance d and beyond, as far as no wider
// one does, in part for those down to inner, where the next begins, the last for all nearer ones.
struct mssm_nested {
    float d;
    float inner;
    float outer; // of the one before; d where there is none
    float own;   // share of d up to which a blocker may be the receiver's own surface
    int last;
};

// What a kernel holds: the weight of all its blockers, of those that it or a wider one stands for,
// of those that it alone stands for, and of those so far off that wider ones have dealt with them.
struct mssm_occlusion {
    float all;
    float counted;
    float fresh;
    float past;
};

// Linear in the area of kernels: 0 at distance a, 1 at b; inverse is mssm_inverse_between(a, b).
MSSM_SHARED float mssm_between(float distance, float a, float inverse)
{
    return mssm_clamp((distance - a) * (distance + a) * inverse, 0.0f, 1.0f);
}

MSSM_SHARED float mssm_inverse_between(float a, float b)
{
    return 1.0f / mssm_max((b - a) * (b + a), 1e-37f);
}

// Share of a depth behind the receiver that counts as its own surface going on there; distance in
// units of the one that the kernel is for. Neither the empty texels beyond all casters nor what is
// further off.
MSSM_SHARED float mssm_own_surface(struct mssm_receiver r, float z, float w, float distance)
{
    float gap = 1.0f - MSSM_FAR_CASTER;
    return w * mssm_clamp((1.0f - distance) * (1.0f / 0.3f), 0.0f, 1.0f) *
           mssm_clamp((1.0f - z) * (2.0f / gap), 0.0f, 1.0f) *
           mssm_clamp((z - r.z_own) * r.sharp, 0.0f, 1.0f);
}

// What of a blocker of weight w is so close to the receiver that it may be the receiver's own
// surface in the next texel: all up to three texels of depth in front, nothing from nine on.
MSSM_SHARED float mssm_adjacent(struct mssm_receiver r, float z, float w)
{
    return w * mssm_clamp(1.4f - 0.25f * (r.z_own - z) * r.coarse, 0.0f, 1.0f);
}

// The part of what is adjacent in front that is the rim of a surface which the light grazes: the
// receiver has that surface in the next texel and none of it behind. So where the kernel is about a
// texel wide, all that lies behind, empty texels too, stands for as much in front.
MSSM_CALLED float mssm_rim(struct mssm_receiver r, mssm_points4 p, float half_width)
{
    float behind = 0.0f;
    float adjacent = 0.0f;
    for (int j = 1; j < 4; j++) {
        adjacent += mssm_adjacent(r, p.z[j], mssm_blocked(r, p.z[j], p.w[j]));
        behind += p.w[j] * mssm_clamp((p.z[j] - r.z_own) * r.sharp, 0.0f, 1.0f);
    }
    behind = behind * mssm_clamp(3.0f - 4.0f * half_width, 0.0f, 1.0f);
    return mssm_min(behind, adjacent) / (adjacent + 1e-9f);
}

// One loop over the other depths with all sums, which is what makes it long: split up it would read
// each of them as many times.
MSSM_CALLED struct mssm_occlusion mssm_kernel_occlusion(mssm_view v, struct mssm_receiver r,
                                                        struct mssm_nested k, mssm_points4 p)
{
    float kernel = mssm_max(r.kernel_u, r.kernel_v);
    float half_width = kernel * k.d;
    float inverse_reach = 1.0f / (mssm_plane_reach(v, r, k.d) + 1e-30f);
    float rim =
        half_width < 0.75f && v.averaged == 0 ? mssm_rim(r, p, mssm_max(half_width, 0.5f)) : 0.0f;
    float mirrored = v.averaged != 0 ? 0.5f : 1.0f;
    float inverse_d = 1.0f / (k.d + 1e-30f);
    // The one-texel kernel sees texel centres up to a texel away.
    float to_reach = half_width < 1.0f ? kernel : inverse_d;
    float inverse = mssm_inverse_between(k.inner, k.d);
    float inverse_outer = mssm_inverse_between(k.d, k.outer);
    float near_by = 0.0f;
    float behind = p.w[0] + 2.0f * r.sink;
    float plane = 0.0f; // what is taken for the tangent plane
    float plane_counted = 0.0f;
    struct mssm_occlusion s;
    s.all = 0.0f;
    s.counted = 0.0f;
    s.fresh = 0.0f;
    s.past = 0.0f;
    for (int j = 1; j < 4; j++) {
        if (p.w[j] < 1e-4f) continue;
        float distance = mssm_blur_distance(v, r, p.z[j]);
        float relative = distance * inverse_d;
        // The mirror reaches a fifth further: the bias keeps what is close out of the front, but
        // not out of what lies behind, whose mean is nearer then.
        float at = p.z[j] < r.z_test ? distance : 1.2f * distance;
        float counted = k.last == 1 ? 1.0f : mssm_between(at, k.inner, inverse);
        float fresh = counted - mssm_between(at, k.d, inverse_outer);
        float w;
        if (p.z[j] < r.z_test) {
            w = mssm_blocked(r, p.z[j], p.w[j]);
            if (r.plane != 0) {
                float on_plane = w - w * mssm_off_plane(r, relative, distance * inverse_reach);
                w = w - on_plane;
                // Points a little below their surface have it in front, too: twice more faded.
                on_plane = mssm_blocked(r, p.z[j], mssm_blocked(r, p.z[j], on_plane));
                plane += on_plane;
                plane_counted += on_plane * counted;
            }
            if (rim > 0.0f) w = w - rim * mssm_adjacent(r, p.z[j], w);
            s.all += w;
            s.past += w * mssm_clamp(relative - 1.5f, 0.0f, 1.0f);
            near_by += w * mssm_clamp(1.0f - relative / k.own, 0.0f, 1.0f);
        } else {
            behind += p.w[j];
            // A surface through the receiver lies as much behind it as in front, and within its
            // tangent plane's reach: without this a plane tilted by more than a third of the
            // light's reach would shadow itself. Halfway to its back, a surface is less in its own
            // way.
            w = -mirrored * mssm_own_surface(r, p.z[j], p.w[j], distance * to_reach);
            if (r.plane != 0) w = w * mssm_clamp(2.0f - distance * inverse_reach, 0.0f, 1.0f);
        }
        s.counted += w * counted;
        s.fresh += w * fresh;
    }
    // So where next to nothing lies behind, what was taken for the tangent plane blocks; unless that
    // is seen from behind.
    float covered = mssm_clamp(1.0f - 3.0f * behind / (plane + 1e-9f), 0.0f, 1.0f);
    s.all += covered * plane;
    s.counted += covered * plane_counted;
    // What is much nearer than the kernel's blockers is more often the receiver's own surface,
    // where there is as much of it at the receiver's depth.
    if (k.last == 0) s.all = s.all - mssm_min(near_by, p.w[0]);
    s.counted = mssm_clamp(s.counted, 0.0f, 1.0f);
    s.fresh = mssm_clamp(s.fresh, 0.0f, s.counted);
    s.past = k.outer > k.d ? mssm_min(s.past, s.counted) : 0.0f;
    return s;
}

// Distance of the next kernel: the mean of the blockers that this one is too wide for, and with
// some weight a third of its own.
MSSM_SHARED float mssm_next_distance(mssm_view v, struct mssm_receiver r, float d, mssm_points4 p)
{
    float sum = 0.2f;
    float first = 0.07f * d;
    float inverse = mssm_inverse_between(0.0f, d);
    for (int j = 1; j < 4; j++) {
        if (p.z[j] >= r.z_test) continue;
        float distance = mssm_blur_distance(v, r, p.z[j]);
        float w = mssm_blocked(r, p.z[j], p.w[j]) * (1.0f - mssm_between(distance, 0.0f, inverse));
        sum += w;
        first += w * distance;
    }
    return first / sum; // .06 d to .65 d
}

// [glsl end]
// [glsl begin estimate]
// Nested kernels from the widest in: each takes the part of its blockers that it stands for as what
// blocks, and leaves the rest of the light to the next. Where a kernel stands for all of its
// blockers there is one layer, and what it does not block is lit but for blockers that only
// narrower kernels show. So one layer is filtered by one kernel, nothing is counted twice or lost
// between two, and the result changes continuously with all inputs. Long: all that the loop changes
// is used in each of its steps.
MSSM_CALLED float mssm_layered(MSSM_MAP map, mssm_view v, struct mssm_options o,
                               struct mssm_receiver r)
{
    float kernel = mssm_max(r.kernel_u, r.kernel_v);
    float reach = mssm_cone_reach(map, v, r);
    if (reach <= 0.0f) return 1.0f;
    float least = 0.5f / mssm_max(kernel, 1e-30f); // of the kernel one texel wide
    struct mssm_nested k;
    k.d = least < reach ? mssm_mean_distance(map, v, o, r, reach) : reach;
    k.outer = k.d;
    k.inner = k.d;
    k.own = o.moments == 6 ? 0.6f : 0.3f; // four moments tell it from a near caster less well
    float blocked = 0.0f;
    float lit = 0.0f;  // but for fresh blockers
    float rest = 1.0f; // left to narrower kernels
    int i = 0;
    do {
        mssm_points4 p =
            mssm_layers(o, o.moments, mssm_filter_moments(map, v, r, o.moments, k.d), r.z_test);
        k.last = i == 3 || k.d <= 1.001f * least ? 1 : 0;
        if (k.last == 0) {
            k.inner = mssm_next_distance(v, r, k.d, p);
            float z = mssm_cone_least(map, v, r, k.inner);
            i = z < r.z_test ? i : 4; // nothing is nearer
            k.inner = mssm_max(mssm_min(mssm_blur_distance(v, r, z), k.inner), least);
        }
        struct mssm_occlusion s = mssm_kernel_occlusion(v, r, k, p);
        float part = k.last == 1 ? 1.0f : s.counted / (s.all + 1e-6f);
        // Of what wider kernels left, none is left to the blockers of other layers, much further
        // than this kernel's, that block beside it. 1.3, not 1: where only those are seen, they
        // stand for what they hide.
        float left = part * (1.3f * s.counted - s.past) / (1.3f * part - s.past + 1e-6f);
        float more = lit * s.fresh;
        blocked += more + rest * left;
        lit += rest * (part - left) - more;
        rest = rest * (1.0f - part);
        k.outer = k.d;
        k.d = k.inner;
        i = i + 1;
    } while (i < 4 && k.last == 0 && lit + rest > o.tolerance);
    return mssm_without_leak(map, v, o, r, reach, 1.0f - mssm_clamp(blocked, 0.0f, 1.0f));
}

// Bounds and blockers in the kernel at distance d.
MSSM_CALLED struct mssm_split mssm_split_at(MSSM_MAP map, mssm_view v, struct mssm_options o,
                                            struct mssm_receiver r, float d)
{
    mssm_moments6 t = mssm_filter_moments(map, v, r, o.moments, d);
    if (o.moments == 6) return mssm_split6(mssm_kernel6_stored(t, o.alpha6, r.z_test));
    return mssm_split4(mssm_kernel4_stored(t, o.alpha4, r.z_test));
}

// The published pipeline: one mean blocker depth, one kernel.
MSSM_CALLED float mssm_single(MSSM_MAP map, mssm_view v, struct mssm_options o,
                              struct mssm_receiver r)
{
    float reach = mssm_cone_reach(map, v, r);
    if (reach <= 0.0f) return 1.0f;
    struct mssm_split s = mssm_split_at(map, v, o, r, reach);
    float depth = mssm_split_depth(s, r.z_test, 1e-3f, o.estimator == 2 ? 1.0f : 1e-3f);
    s = mssm_split_at(map, v, o, r, mssm_min(mssm_blur_distance(v, r, depth), reach));
    return mssm_without_leak(map, v, o, r, reach, mssm_split_bounds(s).upper);
}

MSSM_SHARED float mssm_estimate(MSSM_MAP map, mssm_view v, struct mssm_options o,
                                struct mssm_receiver r)
{
    if (r.lit == 1) return 1.0f;
    if (o.estimator == 0 || o.estimator == 3) return mssm_layered(map, v, o, r);
    return mssm_single(map, v, o, r);
}
// [glsl end]

static float mssm__or_default(float value, float otherwise)
{
    return mssm__is_finite(value) && value > 0 ? value : otherwise;
}

// Sizes that are no numbers are 0.
static mssm_view mssm__view(const mssm_light *light, const mssm_settings *set, int side, int levels,
                            int averaged)
{
    mssm_view v;
    const float range = light->z_far - light->z_near, to_texels = 0.5f * (float)side;
    const float scale = to_texels * (light->perspective ? 1.0f : 0.5f * range);
    const float extent = light->extent_u > light->extent_v ? light->extent_u : light->extent_v;
    memcpy(v.world_to_shadow, light->world_to_shadow, sizeof v.world_to_shadow);
    v.kernel_u = mssm__or_default(scale * light->half_u / light->extent_u, 0.0f);
    v.kernel_v = mssm__or_default(scale * light->half_v / light->extent_v, 0.0f);
    v.distance_scale = 0.5f * range;
    v.distance_offset = 0.5f * range + light->z_near;
    v.texel = mssm__or_default(2.0f * extent / ((float)side * v.distance_scale), 0.0f);
    v.side = (float)side;
    v.max_half = set && set->max_kernel > 0 ? 0.5f * (float)set->max_kernel : MSSM_FAR_AWAY;
    v.perspective = light->perspective;
    v.averaged = averaged;
    v.levels = levels;
    return v;
}

static struct mssm_options mssm__options(const mssm_settings *set, int map_moments)
{
    static const mssm_settings defaults = {0, MSSM_LAYERED, 0, 0, 0, 0};
    if (!set) set = &defaults;
    struct mssm_options o;
    o.moments = set->moments == 4 || map_moments == 4 ? 4 : 6;
    o.estimator = (int)set->estimator;
    o.alpha4 = mssm__or_default(set->moment_bias, MSSM_BIAS4_TABLE);
    o.alpha6 = mssm__or_default(set->moment_bias, MSSM_BIAS6_TABLE);
    o.depth_bias = mssm__or_default(set->depth_bias, 0.0f);
    o.tolerance = mssm__or_default(set->tolerance, 1.0f / 256.0f);
    return o;
}

void mssm_map_visibility_many(const mssm_map *map, const mssm_light *light,
                              const mssm_settings *settings, int count, const float (*points)[3],
                              const float (*normals)[3], float *visibility)
{
    if (!points || !visibility) return;
    if (!map || !light) {
        for (int i = 0; i < count; i++) visibility[i] = 1;
        return;
    }
    const mssm_view view = mssm__view(light, settings, map->side, map->levels, map->averaged);
    const struct mssm_options options = mssm__options(settings, map->moments);
    for (int i = 0; i < count; i++) {
        const float *p = points[i], *n = normals ? normals[i] : NULL;
        visibility[i] = 1;
        if (!mssm__all_finite(p, 3)) continue;
        struct mssm_receiver r = mssm_receive(view, options, p[0], p[1], p[2]);
        if (n && mssm__all_finite(n, 3)) r = mssm_tangent(view, options, r, n[0], n[1], n[2]);
        visibility[i] = mssm_estimate(map, view, options, r);
    }
}

float mssm_map_visibility_normal(const mssm_map *map, const mssm_light *light,
                                 const mssm_settings *settings, const float point[3],
                                 const float normal[3])
{
    float visibility = 1;
    mssm_map_visibility_many(map, light, settings, 1, (const float(*)[3])point,
                             (const float(*)[3])normal, &visibility);
    return visibility;
}

float mssm_map_visibility(const mssm_map *map, const mssm_light *light,
                          const mssm_settings *settings, const float point[3])
{
    return mssm_map_visibility_normal(map, light, settings, point, NULL);
}

// Moments from those of the Chebyshev polynomials; of four the last two are 0.
static mssm_moments6 mssm__decoded(mssm_moments6 t, int moments)
{
    for (int k = 0; k < 6; k++) t.b[k] = mssm_to_unit(t.b[k]);
    t = mssm_moments6_decode(t);
    if (moments == 4) t.b[4] = t.b[5] = 0.0f;
    return t;
}

mssm_moments6 mssm_map_moments(const mssm_map *map, float x, float y, float half_x, float half_y)
{
    if (!map) return mssm_moments6_of_depth(1.0f);
    const float scale = 0.5f * (float)map->side, far_away = MSSM_FAR_AWAY;
    const mssm_moments6 t = mssm_query(
        map, map->moments, mssm_clamp((x + 1.0f) * scale, -far_away, far_away),
        mssm_clamp((y + 1.0f) * scale, -far_away, far_away),
        mssm_clamp(half_x * scale, 0.5f, far_away), mssm_clamp(half_y * scale, 0.5f, far_away));
    return mssm__decoded(t, map->moments);
}

// The least side of a texture whose levels, halved without rest, have room for those of a map.
static int mssm__padded(int side, int levels)
{
    const int grain = 1 << (levels - 1);
    return (side + grain - 1) / grain * grain;
}

// Entries without the first row and column of zeros, as inclusive sums. Beyond the map all is 0.
mssm_result mssm_map_texels(const mssm_map *map, int which, int level, mssm_texels *info,
                            void *texels, size_t bytes)
{
    static const unsigned formats[3][3] = {
        {0x8D82, 0x8D99, 0x1404}, {0x823B, 0x8228, 0x1404}, {0x8230, 0x8227, 0x1406}};
    if (!map || !info || which < 0 || which > 2 || (which == 1 && map->moments == 4))
        return MSSM_ERROR_ARGUMENT;
    const int depth = which == 2, levels = depth ? map->depths : map->levels;
    if (level < 0 || level >= levels) return MSSM_ERROR_ARGUMENT;
    const int side = (depth ? 1 << (levels - 1) : mssm__padded(map->side, levels)) >> level;
    const size_t size = (size_t)(depth ? map->size_of_depths : map->size)[level],
                 texel = which ? 8 : 16;
    const size_t row_bytes = (size_t)side * texel, all = row_bytes * (size_t)side,
                 channels = (size_t)map->moments;
    if (texels && bytes < all) return MSSM_ERROR_MEMORY;
    const mssm_texels t = {levels, side, formats[which][0], formats[which][1], formats[which][2],
                           all};
    *info = t;
    for (size_t y = 0; y < (size_t)side && texels; y++) {
        unsigned char *row = (unsigned char *)texels + y * row_bytes;
        memset(row, 0, row_bytes);
        for (size_t x = 0; x < size && y < size; x++) {
            const void *from =
                depth ? (const void *)map->depth[level][y * size + x]
                      : map->table[level] + ((y + 1) * (size + 1) + x + 1) * channels + 4 * which;
            memcpy(row + x * texel, from, texel);
        }
    }
    return MSSM_OK;
}

typedef char mssm__view_fits[sizeof(mssm_view) <= 28 * sizeof(int) ? 1 : -1]; // mssm_map_view

mssm_result mssm_map_view(const mssm_map *map, const mssm_light *light,
                          const mssm_settings *settings, int view[28])
{
    if (!map || !light || !view || !mssm__is_light(light)) return MSSM_ERROR_ARGUMENT;
    const mssm_view v = mssm__view(light, settings, map->side, map->levels, map->averaged);
    memset(view, 0, 28 * sizeof *view);
    memcpy(view, &v, sizeof v);
    return MSSM_OK;
}

#ifndef MSSM_NO_FILTERED
// ---- Filtered hard shadows ---- >>filtered

mssm_moments6 mssm_moments6_blend(mssm_moments6 m, float z, float opacity)
{
    const mssm_moments6 layer = mssm_moments6_of_depth(z);
    const float a = mssm_clamp(opacity, 0.0f, 1.0f);
    for (int k = 0; k < 6; k++) m.b[k] = (1.0f - a) * m.b[k] + a * layer.b[k];
    return m;
}

mssm_moments4 mssm_moments4_blend(mssm_moments4 m, float z, float opacity)
{
    return mssm_four(mssm_moments6_blend(mssm_six(m), z, opacity));
}

#define MSSM__RADIUS 32 // of the Gaussian, in texels

// Level l holds size^2 texels of moments channels.
struct mssm_filtered {
    int side, moments, levels, radius;
    int size[MSSM__LEVELS];
    uint16_t *texel[MSSM__LEVELS];
    float *work, *rows; // side^2 texels each and 8 floats more; what a moment lacks to 1
};

static mssm_settings mssm__filter_settings(const mssm_filter *filter, int moments)
{
    const float alpha = moments == 6 ? MSSM_BIAS6_UNORM16_FILTERED : MSSM_BIAS4_UNORM16_FILTERED;
    const float bias = mssm__or_default(filter->moment_bias, alpha);
    const mssm_settings s = {moments, MSSM_LAYERED, bias, filter->depth_bias, 0, 0};
    return s;
}

// What occlusion may lack to count as all.
static float mssm__filter_lack(const mssm_filter *filter)
{
    return 1.0f - mssm_clamp(mssm__or_default(filter->full_shadow, 0.98f), 0.5f, 1.0f - 1e-7f);
}

// [glsl begin filtered]
// Width of a texel at the receiver in units of z.
MSSM_SHARED float mssm_texel_at(mssm_view v, struct mssm_receiver r)
{
    return v.perspective != 0 ? -v.texel / r.blur_depth : v.texel;
}

MSSM_SHARED int mssm_beside(mssm_view v, struct mssm_receiver r)
{
    float middle = 0.5f * v.side;
    return mssm_max(fabsf(r.x - middle), fabsf(r.y - middle)) > middle ? 1 : 0;
}

// Bounds from Chebyshev moments under a Gaussian and footprint, width texels wide. Of all that is
// not at the receiver's depth a share lies beyond it: there its surface goes on, if it is steep or
// ends here, and then it rises before the receiver as well. The depth bias is an eighth of a texel
// and that share of three quarters of the width. Where nothing lies beyond, more would only light
// what is close behind a caster. Occlusion that lacks no more than that counts as all.
MSSM_CALLED mssm_bounds mssm_bounds_under(mssm_view v, struct mssm_options o,
                                          struct mssm_receiver r, mssm_moments6 t, float width,
                                          float lack)
{
    float texel = o.depth_bias > 0.0f ? 0.0f : mssm_texel_at(v, r);
    float z = r.z_own - 0.125f * texel;
    z = mssm_min(z, r.z_test);
    struct mssm_split s = mssm_split4(mssm_kernel4_stored(t, o.alpha4, z));
    float beyond = (1.0f - s.own - s.nearer) / (1.001f - s.own);
    z = z - 0.75f * beyond * width * texel;
    mssm_bounds b;
    if (o.moments == 6) {
        b = mssm_split_bounds(mssm_split6(mssm_kernel6_stored(t, o.alpha6, z)));
    } else {
        b = mssm_split_bounds(mssm_split4(mssm_kernel4_stored(t, o.alpha4, z)));
    }
    b.lower = mssm_clamp((b.lower - lack) / (1.0f - lack), 0.0f, 1.0f);
    b.upper = mssm_clamp((b.upper - lack) / (1.0f - lack), 0.0f, 1.0f);
    return b;
}
// [glsl end]

size_t mssm_filtered_bytes(int side, int moments)
{
    const uint64_t words = mssm__entries(side, moments);
    if (!words) return 0;
    const uint64_t floats = 2 * ((uint64_t)side * (uint64_t)side * (uint64_t)moments + 8);
    const uint64_t bytes =
        floats * sizeof(float) + words * sizeof(uint16_t) + sizeof(mssm_filtered) + 63;
    return bytes <= SIZE_MAX ? (size_t)bytes : 0;
}

// to[i] = sum of weight[t] * from[i + t * step], t held between low and high. Eight at a time
// become vectors: up to 7 floats more are read, and written, which what comes after overwrites.
static void mssm__blur(const float *from, float *to, size_t count, ptrdiff_t step, int low,
                       int high, int radius, const float *weight)
{
    for (size_t i = 0; i < count; i += 8) {
        float sum[8] = {0};
        for (int t = -radius; t <= radius; t++) {
            const float *at = from + i + (t < low ? low : t > high ? high : t) * step;
            for (int k = 0; k < 8; k++) sum[k] += weight[t] * at[k];
        }
        memcpy(to + i, sum, sizeof sum);
    }
}

// Rows, then columns. Beyond an edge the outermost texel goes on.
static void mssm__gaussian(mssm_filtered *map, int radius)
{
    float taps[2 * MSSM__RADIUS + 1], sum = 0, *weight = taps + radius;
    const float falloff = radius > 0 ? 2.0f / (float)(radius * radius) : 0.0f;
    const int side = map->side, moments = map->moments;
    const size_t stride = (size_t)side * (size_t)moments;
    for (int t = -radius; t <= radius; t++) {
        weight[t] = expf(-falloff * (float)(t * t));
        sum += weight[t];
    }
    for (int t = -radius; t <= radius; t++) weight[t] /= sum;
    for (int y = 0; y < side; y++) {
        for (int x = 0, run; x < side; x += run) {
            const int low = x < radius ? -x : -radius, left = side - 1 - x;
            const int high = left < radius ? left : radius;
            run = high - low == 2 * radius ? left - radius + 1 : 1;
            const size_t at = (size_t)y * stride + (size_t)(x * moments);
            mssm__blur(map->work + at, map->rows + at, (size_t)(run * moments), moments, low, high,
                       radius, weight);
        }
    }
    for (int y = 0; y < side; y++) {
        const int low = y < radius ? -y : -radius, left = side - 1 - y;
        mssm__blur(map->rows + (size_t)y * stride, map->work + (size_t)y * stride, stride,
                   (ptrdiff_t)stride, low, left < radius ? left : radius, radius, weight);
    }
}

// In place: nothing is written before it was read. At the end of an odd size: means of two or one.
static void mssm__halve(mssm_filtered *map, int from, int size)
{
    const size_t moments = (size_t)map->moments, stride = (size_t)from * moments;
    float *to = map->work;
    for (int y = 0; y < size; y++) {
        for (int x = 0; x < size; x++) {
            const float *a = map->work + (size_t)(2 * y) * stride + (size_t)(2 * x) * moments;
            const float *b = 2 * x + 1 < from ? a + moments : a;
            const float *c = 2 * y + 1 < from ? a + stride : a;
            const float *d = c + (b - a);
            for (size_t k = 0; k < moments; k++) *to++ = 0.25f * (a[k] + b[k] + c[k] + d[k]);
        }
    }
}

// Blurs what is in `work` and makes all levels of it, rounded eight numbers at a time too.
static void mssm__filter(mssm_filtered *map, int radius)
{
    map->radius = radius;
    mssm__gaussian(map, radius);
    for (int level = 0; level < map->levels; level++) {
        const int size = map->size[level];
        const size_t count = (size_t)size * (size_t)size * (size_t)map->moments;
        if (level > 0) mssm__halve(map, map->size[level - 1], size);
        for (size_t i = 0; i < count; i += 8) {
            const float *from = map->work + i;
            uint16_t *to = map->texel[level] + i;
            for (int k = 0; k < 8; k++) to[k] = (uint16_t)(65535.5f - 65535.0f * from[k]);
        }
    }
}

mssm_result mssm_filtered_init(mssm_filtered **map, void *memory, size_t bytes, int side,
                               int moments)
{
    const size_t needed = mssm_filtered_bytes(side, moments);
    if (!map || !memory || !needed) return MSSM_ERROR_ARGUMENT;
    if (bytes < needed) return MSSM_ERROR_MEMORY;
    const size_t misfit = (size_t)((uintptr_t)memory % 16);
    mssm_filtered *m =
        (mssm_filtered *)(void *)((unsigned char *)memory + (misfit ? 16 - misfit : 0));
    memset(m, 0, sizeof *m);
    m->side = side;
    m->moments = moments;
    m->levels = mssm__levels(side, (int)MSSM_KERNEL);
    const size_t count = (size_t)side * (size_t)side * (size_t)moments + 8;
    m->work = (float *)(void *)(m + 1);
    m->rows = m->work + count;
    uint16_t *texel = (uint16_t *)(void *)(m->rows + count);
    for (int level = 0, size = side; level < m->levels; level++, size = (size + 1) / 2) {
        m->size[level] = size;
        m->texel[level] = texel;
        texel += (size_t)size * (size_t)size * (size_t)moments;
    }
    for (size_t i = 0; i < 2 * count; i++) m->work[i] = 0;
    mssm__filter(m, 0);
    *map = m;
    return MSSM_OK;
}

mssm_result mssm_filtered_update(mssm_filtered *map, const float *depth, int samples, int radius)
{
    if (!map || !depth || samples < 1 || samples > 64 || radius < 0 || radius > MSSM__RADIUS)
        return MSSM_ERROR_ARGUMENT;
    const size_t texels = (size_t)map->side * (size_t)map->side;
    const float scale = 0.5f / (float)samples;
    float *to = map->work;
    for (size_t i = 0; i < texels; i++) {
        float sum[6] = {0};
        for (int s = 0; s < samples; s++) {
            const mssm_moments6 t = mssm_chebyshev(mssm__depth(*depth++));
            for (int k = 0; k < 6; k++) sum[k] += t.b[k];
        }
        for (int k = 0; k < map->moments; k++) *to++ = 0.5f - scale * sum[k];
    }
    mssm__filter(map, radius);
    return MSSM_OK;
}

mssm_result mssm_filtered_update_moments(mssm_filtered *map, const float *encoded, int radius)
{
    if (!map || !encoded || radius < 0 || radius > MSSM__RADIUS) return MSSM_ERROR_ARGUMENT;
    const size_t count = (size_t)map->side * (size_t)map->side * (size_t)map->moments;
    for (size_t i = 0; i < count; i++) map->work[i] = 1.0f - mssm_clamp(encoded[i], 0, 1);
    mssm__filter(map, radius);
    return MSSM_OK;
}

#define MSSM_EMPTY 0.99999f // first moment of nothing, encoded and rounded

mssm_result mssm_map_update_moments(mssm_map *map, const float *encoded)
{
    if (!map || !encoded) return MSSM_ERROR_ARGUMENT;
    const int side = map->side, moments = map->moments;
    const size_t stride = (size_t)(side + 1) * (size_t)moments;
    const float *from = encoded;
    for (int y = 0; y < side; y++) {
        uint32_t run[6] = {0};
        for (int x = 0; x < side; x++) {
            uint32_t *below = map->table[0] + (size_t)y * stride + (size_t)((x + 1) * moments);
            for (int k = 0; k < moments; k++) {
                const float t = 2.0f * mssm_clamp(*from++, 0, 1) - 1.0f;
                run[k] += (uint32_t)mssm__to_integer(t * (float)MSSM_SCALE);
                below[stride + (size_t)k] = below[k] + run[k];
            }
        }
    }
    for (int level = 1; level < map->levels; level++) mssm__fill_level(map, level, NULL, NULL, 1);
    mssm__fill_depths(map, NULL, NULL, 1);
    for (int i = 0; i < side * side; i++) {
        // Where anything is, it may be as near as depth goes.
        if (encoded[(size_t)i * (size_t)moments] >= MSSM_EMPTY) continue;
        map->depth[0][i / side / 2 * map->size_of_depths[0] + i % side / 2][0] = -1;
    }
    mssm__coarsen_depths(map);
    map->averaged = 0;
    return MSSM_OK;
}

// Adds share times the bilinear sample of a level at x, y (in texels of level 0), as T_k.
static void mssm__add_level(const mssm_filtered *map, int level, float x, float y, float share,
                            float sum[6])
{
    const float scale = 1.0f / (float)(1 << level), size = (float)map->size[level];
    const float u = mssm_clamp(x * scale - 0.5f, 0, size - 1),
                v = mssm_clamp(y * scale - 0.5f, 0, size - 1);
    const int left = (int)u, low = (int)v, last = map->size[level] - 1, moments = map->moments;
    for (int j = 0; j < 4; j++) {
        const int i = left + (left < last ? j % 2 : 0), row = low + (low < last ? j / 2 : 0);
        const float across = u - (float)left, up = v - (float)low;
        const float w = share * (j % 2 ? across : 1 - across) * (j / 2 ? up : 1 - up);
        const uint16_t *texel =
            map->texel[level] + ((size_t)row * (size_t)(last + 1) + (size_t)i) * (size_t)moments;
        for (int k = 0; k < moments; k++)
            sum[k] += w * ((float)texel[k] * (2.0f / 65535.0f) - 1.0f);
    }
}

// Trilinear Chebyshev moments: x, y and width in texels of level 0.
static mssm_moments6 mssm__sample(const mssm_filtered *map, float x, float y, float width)
{
    const float level = log2f(mssm_clamp(width, 1, (float)(1 << (map->levels - 1))));
    const int fine = (int)level;
    const float rest = level - (float)fine;
    mssm_moments6 t = {{0}};
    mssm__add_level(map, fine, x, y, 1 - rest, t.b);
    if (rest > 0) mssm__add_level(map, fine + 1, x, y, rest, t.b);
    return t;
}

mssm_moments6 mssm_filtered_moments(const mssm_filtered *map, float x, float y, float width)
{
    if (!map || !(fabsf(x) <= 1 && fabsf(y) <= 1)) return mssm_moments6_of_depth(1.0f);
    const float scale = 0.5f * (float)map->side;
    return mssm__decoded(mssm__sample(map, (x + 1) * scale, (y + 1) * scale, width * scale),
                         map->moments);
}

mssm_bounds mssm_filtered_bounds(const mssm_filtered *map, const mssm_light *light,
                                 const mssm_filter *filter, const float point[3], float width)
{
    static const mssm_filter defaults = {0, 0, 0};
    const mssm_bounds lit = {1, 1};
    if (!map || !light || !mssm__all_finite(point, 3)) return lit;
    if (!filter) filter = &defaults;
    const mssm_settings s = mssm__filter_settings(filter, map->moments);
    const mssm_view v = mssm__view(light, &s, map->side, map->levels, 1);
    const struct mssm_options o = mssm__options(&s, map->moments);
    const struct mssm_receiver r = mssm_receive(v, o, point[0], point[1], point[2]);
    if (r.lit || mssm_beside(v, r)) return lit;
    const float texels = width / (mssm_texel_at(v, r) * v.distance_scale);
    const float footprint = mssm__is_finite(texels) ? mssm_clamp(texels, 1, v.side) : 1.0f;
    const float total = footprint + 2 * (float)map->radius;
    return mssm_bounds_under(v, o, r, mssm__sample(map, r.x, r.y, footprint), total,
                             mssm__filter_lack(filter));
}

float mssm_filtered_visibility(const mssm_filtered *map, const mssm_light *light,
                               const mssm_filter *filter, const float point[3], float width)
{
    return mssm_filtered_bounds(map, light, filter, point, width).upper;
}
#endif // MSSM_NO_FILTERED

#ifndef MSSM_NO_SCATTERING
// ---- Single scattering ---- >>scattering

// [glsl begin scattering]

mssm_epipolar mssm_scattering_row(mssm_scattering s, float azimuth)
{
    float along = cosf(azimuth);
    float aside = sinf(azimuth);
    mssm_epipolar row;
    row.x = along * s.slope[0] + aside * s.slope[2];
    row.y = along * s.slope[1] + aside * s.slope[3];
    float first = 0.0f;
    float last = 1e12f;
    for (int k = 0; k < 2; k++) { // clipped by the edges of the map
        float slope = k == 0 ? row.x : row.y;
        float inverse = 1.0f / (fabsf(slope) > 1e-12f ? slope : 1e-12f);
        float a = (-1.0f - s.eye[k]) * inverse;
        float b = (1.0f - s.eye[k]) * inverse;
        first = mssm_clamp(mssm_min(a, b), first, 1e12f);
        last = mssm_clamp(mssm_max(b, a), 0.0f, last);
    }
    row.first = first;
    row.extent = last > first ? last - first : 0.0f;
    row.fade = mssm_clamp(s.fade * row.extent, 1e-2f, 1e20f);
    return row;
}

float mssm_scattering_distance(mssm_epipolar row, float column)
{
    float least = expf(-mssm_min(row.fade, 20.0f)); // light from further off is not missed
    float left = 1.0f - mssm_clamp(column, 0.0f, 1.0f) * (1.0f - least);
    return row.first - row.extent * logf(mssm_max(left, least)) / row.fade;
}

// The roots of the kernel without a given depth, u^2 - c u - d: d the variance, c third moment / d.
mssm_points2 mssm_reconstruct3(float b1, float b2, float b3)
{
    float mean = mssm_clamp(b1, -1.0f, 1.0f);
    float variance = b2 - mean * mean;
    float third = b3 - mean * (mean * mean + 3.0f * variance);
    float d = mssm_clamp(variance, 4e-6f, 1.0f);
    float c = mssm_clamp(third / d, -2.0f, 2.0f);
    float root = sqrtf(c * c + 4.0f * d);
    float larger = 0.5f * (fabsf(c) + root); // the root without cancellation
    float high = c > 0.0f ? larger : d / larger;
    mssm_points2 p;
    p.z[0] = mssm_max(mean - d / high, -1.0f);
    p.z[1] = mssm_min(mean + high, 1.0f);
    p.w[0] = high / root;
    p.w[1] = 1.0f - p.w[0];
    return p;
}

float mssm_inclination(mssm_scattering s, float r, float z)
{
    float left = 1.0f - mssm_clamp(z, -1.0f, 0.9999f); // stretched from MSSM_FAR_CASTER on
    float depth = left < 0.2f ? 0.6f + 0.04f / left : 1.0f - left;
    float angle = atan2f(r, (depth - s.eye[2]) * s.slope[4]);
    return mssm_clamp((angle - s.inclination[0]) * s.inclination[1], -1.0f, 1.0f);
}

mssm_moments6 mssm_scattering_moments(mssm_scattering s, float r, float b1, float b2, float b3)
{
    mssm_points2 p = mssm_reconstruct3(b1, b2, b3);
    mssm_moments6 m = mssm_moments6_of_depth(mssm_inclination(s, r, p.z[0]));
    mssm_moments6 behind = mssm_moments6_of_depth(mssm_inclination(s, r, p.z[1]));
    for (int k = 0; k < 6; k++) m.b[k] = p.w[0] * m.b[k] + p.w[1] * behind.b[k];
    return m;
}

mssm_view_ray mssm_scattering_ray(mssm_scattering s, float x, float y, float z, float distance)
{
    float along = s.axis[0] * x + s.axis[1] * y + s.axis[2] * z;
    float aside = s.axis[3] * x + s.axis[4] * y + s.axis[5] * z;
    float up = s.axis[6] * x + s.axis[7] * y + s.axis[8] * z;
    float across = sqrtf(along * along + aside * aside); // r for each unit of distance
    float azimuth = across > 0.0f ? atan2f(aside, along) : 0.0f;
    mssm_epipolar row = mssm_scattering_row(s, azimuth);
    float all = mssm_clamp(distance, 1e-6f, 1e12f);
    float part = mssm_clamp(all * across - row.first, 0.0f, row.extent);
    float cosecant = 1.0f / mssm_max(across, 1e-6f);
    float enter = mssm_clamp(row.first * cosecant, 0.0f, all);
    float leave = mssm_clamp((row.first + row.extent) * cosecant, enter, all);
    float e = mssm_clamp(s.extinction, 1e-3f / all, 1e20f);
    float angle = atan2f(across, up);
    mssm_view_ray r;
    r.row = (azimuth - s.azimuth[0]) / s.azimuth[1];
    r.column = row.extent > 0.0f ? 1.0f - expf(-row.fade * part / row.extent) : 0.0f;
    r.column = r.column / (1.0f - expf(-row.fade));
    r.depth = mssm_clamp((angle - s.inclination[0]) * s.inclination[1], -1.0f, 1.0f);
    r.share = (expf(-e * enter) - expf(-e * leave)) / (1.0f - expf(-e * all));
    r.share = mssm_clamp(row.extent > 0.0f ? r.share : 0.0f, 0.0f, 1.0f);
    r.upper = mssm_clamp(0.5f - 0.5f * up, 0.0f, 1.0f);
    r.balance = s.balance;
    return r;
}

float mssm_scattering_visibility(mssm_view_ray ray, mssm_moments6 m)
{
    mssm_bounds b = mssm_visibility6(m, ray.depth);
    float sure = b.lower + (1.0f - b.upper);
    float lit = sure > 1e-6f ? b.lower / sure : 0.5f;
    float upper = mssm_clamp(ray.upper + ray.balance * (lit - ray.upper), 0.0f, 1.0f);
    return 1.0f - ray.share * (1.0f - (b.lower + upper * (b.upper - b.lower)));
}
// [glsl end]

// Widens a range of angles from the pole by an edge of the picture from p to q.
static void mssm__incline(const double p[3], const double q[3], double range[2])
{
    const double d[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
    const double pd = mssm__dot(p, d), below = p[2] * mssm__dot(d, d) - d[2] * pd;
    const double t = below != 0 ? (d[2] - p[2] * pd) / below : 0; // p + t d is the extreme
    for (int k = 0; k < 2; k++) {
        const double at = k && t > 0 && t < 1 ? t : 0;
        const double x = p[0] + at * d[0], y = p[1] + at * d[1];
        const double angle = atan2(sqrt(x * x + y * y), p[2] + at * d[2]);
        if (angle < range[0]) range[0] = angle;
        if (angle > range[1]) range[1] = angle;
    }
}

// The picture's angles to the axis, and around it from its middle's azimuth, in the light's frame.
static void mssm__picture_angles(double c[4][3], const double middle[3], double along, double aside,
                                 double range[2], double turn[2])
{
    const double pi = 3.14159265358979;
    int left = 0, right = 0;
    range[0] = pi;
    range[1] = turn[0] = turn[1] = 0;
    for (int k = 0; k < 4; k++) {
        const double *p = c[k], *q = c[(k + 1) % 4];
        const double angle = atan2(along * p[1] - aside * p[0], along * p[0] + aside * p[1]);
        double normal[3];
        mssm__cross(p, q, normal);
        mssm__incline(p, q, range);
        left += normal[2] * mssm__dot(normal, middle) > 0;
        right += normal[2] * mssm__dot(normal, middle) < 0;
        if (angle < turn[0]) turn[0] = angle;
        if (angle > turn[1]) turn[1] = angle;
    }
    if (left == 4) range[0] = 0;   // inside of all edges: the light is in the picture
    if (right == 4) range[1] = pi; // or the point opposite
    if (left == 4 || right == 4) turn[0] = -pi, turn[1] = pi;
}

// Unit axes of a directional light, the third towards it, and what the matrix scales them by.
static int mssm__light_axes(const mssm_light *light, double frame[3][3], double scale[3])
{
    for (int a = 0; a < 3; a++) {
        const float sign = a < 2 ? 1.0f : -1.0f; // depth grows away from the light
        for (int i = 0; i < 3; i++) frame[a][i] = sign * light->world_to_shadow[4 * i + a];
        scale[a] = sqrt(mssm__dot(frame[a], frame[a]));
        if (!mssm__normalise(frame[a])) return 0;
    }
    return 1;
}

mssm_result mssm_scattering_init(mssm_scattering *s, const mssm_light *light, const float eye[3],
                                 const float corners[12], float extinction)
{
    double frame[3][3], scale[3], c[4][3], middle[3] = {0, 0, 0};
    double range[2], turn[2];
    mssm_scattering r;
    if (!s || !light || !eye || light->perspective || !mssm__all_finite(corners, 12) ||
        !mssm__is_finite(extinction) || extinction < 0 || !mssm_light_project(light, eye, r.eye) ||
        !mssm__light_axes(light, frame, scale)) {
        return MSSM_ERROR_ARGUMENT;
    }
    for (int k = 0; k < 4; k++) {
        const double d[3] = {corners[3 * k], corners[3 * k + 1], corners[3 * k + 2]};
        for (int a = 0; a < 3; a++) c[k][a] = mssm__dot(frame[a], d);
        if (!mssm__normalise(c[k])) return MSSM_ERROR_ARGUMENT;
        for (int a = 0; a < 3; a++) middle[a] += c[k][a];
    }
    const double azimuth = atan2(middle[1], middle[0]), along = cos(azimuth), aside = sin(azimuth);
    mssm__picture_angles(c, middle, along, aside, range, turn);
    for (int i = 0; i < 3; i++) {
        r.axis[i] = (float)(along * frame[0][i] + aside * frame[1][i]);
        r.axis[3 + i] = (float)(along * frame[1][i] - aside * frame[0][i]);
        r.axis[6 + i] = (float)frame[2][i];
    }
    r.slope[0] = (float)(along * scale[0]);
    r.slope[1] = (float)(aside * scale[1]);
    r.slope[2] = (float)(-aside * scale[0]);
    r.slope[3] = (float)(along * scale[1]);
    r.slope[4] = (float)(-1 / scale[2]);
    r.azimuth[0] = (float)turn[0];
    r.azimuth[1] = (float)(turn[1] - turn[0] > 1e-6 ? turn[1] - turn[0] : 1e-6);
    // 2% of the depths are left to casters before and behind all that is visible.
    const double half = 0.5 * (range[1] - range[0]);
    r.inclination[0] = (float)(range[0] + half);
    r.inclination[1] = (float)(0.98 / (half > 1e-6 ? half : 1e-6));
    r.extinction = extinction;
    r.fade = extinction / mssm_clamp(sinf(r.inclination[0]), 0.1f, 1.0f);
    r.balance = 0;
    if (!mssm__all_finite(r.slope, 5) || !mssm__is_finite(r.fade)) return MSSM_ERROR_ARGUMENT;
    *s = r;
    return MSSM_OK;
}
#endif // MSSM_NO_SCATTERING

// ---- GLSL texts: what stands around the quotes of >>generated ---- >>texts

// What C and GLSL call by different names.
#define MSSM__GLSL_NAMES                                                                         \
    "#ifdef GL_ES\nprecision highp float;\nprecision highp int;\n#endif\n"                       \
    "#define MSSM_SHARED\n"                                                                      \
    "#define MSSM_CALLED\n"                                                                      \
    "#if __VERSION__ < 400\n#define MSSM_PRECISE\n#else\n#define MSSM_PRECISE precise\n#endif\n" \
    "#define mssm_min(a, b) min(b, a)\n"                                                         \
    "#define mssm_max(a, b) max(b, a)\n"                                                         \
    "#define mssm_clamp(x, low, high) max(low, min(high, x))\n"                                  \
    "#define mssm_bits floatBitsToInt\n"                                                         \
    "#define sqrtf sqrt\n"                                                                       \
    "#define fabsf abs\n"                                                                        \
    "#define mssm_whole floor\n"                                                                 \
    "#define powf pow\n"
#define MSSM__GLSL_FORGET   \
    "#undef MSSM_SHARED\n"  \
    "#undef MSSM_CALLED\n"  \
    "#undef MSSM_PRECISE\n" \
    "#undef sqrtf\n"        \
    "#undef fabsf\n"        \
    "#undef mssm_whole\n"   \
    "#undef powf\n"

#define MSSM__TEXT_OF(x) #x
#define MSSM__TEXT(x) MSSM__TEXT_OF(x)

// Each text counts once in a shader.
#define MSSM__GLSL_BEGIN(name)      \
    "#ifndef MSSM_GLSL_" #name "\n" \
    "#define MSSM_GLSL_" #name "\n" MSSM__GLSL_NAMES
#define MSSM__GLSL_END MSSM__GLSL_FORGET "#endif\n"
#define MSSM__GLSL_CONSTANT(name) "#define " #name " " MSSM__TEXT(name) "\n"

#define MSSM__SHADING_NAMES          \
    MSSM__GLSL_CONSTANT(MSSM_KERNEL) \
    MSSM__GLSL_CONSTANT(MSSM_FAR_CASTER) MSSM__GLSL_CONSTANT(MSSM_FAR_AWAY)

// Once for each type of map MSSM_MAP the functions that ask it, overloaded; without one for int.
#define MSSM__ESTIMATE_BEGIN                                                                               \
    "#if !defined MSSM_MAP && !defined MSSM_GLSL_ESTIMATE && !defined MSSM_NO_ESTIMATE\n"                  \
    "#define MSSM_GLSL_ESTIMATE\n"                                                                         \
    "#define MSSM_MAP int\n"                                                                               \
    "#endif\n"                                                                                             \
    "#ifdef MSSM_MAP\n" MSSM__GLSL_NAMES                                                                   \
    "mssm_moments6 mssm_query(MSSM_MAP map, int moments, float x, float y, float half_x, float half_y);\n" \
    "#ifndef MSSM_LEAST_DEPTH\n"                                                                           \
    "#define MSSM_LEAST_DEPTH(map, x, y, half_size) (-1.0)\n"                                              \
    "#endif\n"                                                                                             \
    "#ifndef MSSM_GREATEST_DEPTH\n"                                                                        \
    "#define MSSM_GREATEST_DEPTH(map, x, y, half_size) 1.0\n"                                              \
    "#endif\n"
#define MSSM__ESTIMATE_END         \
    MSSM__GLSL_FORGET              \
    "#undef MSSM_LEAST_DEPTH\n"    \
    "#undef MSSM_GREATEST_DEPTH\n" \
    "#undef MSSM_MAP\n"            \
    "#endif\n"

#define MSSM__SCATTERING_NAMES \
    "#define atan2f atan\n#define cosf cos\n#define sinf sin\n#define expf exp\n#define logf log\n"
#define MSSM__SCATTERING_FORGET \
    "#undef atan2f\n#undef cosf\n#undef sinf\n#undef expf\n#undef logf\n"

// ---- OpenGL 4.5 ---- >>gl

#ifndef MSSM_NO_GL

#define MSSM__GL_OWN(X)                                                                 \
    X(void, GetFloati_v, (mssm__glenum, unsigned, float *))                             \
    X(void, GetDoublei_v, (mssm__glenum, unsigned, double *))                           \
    X(void, GetBooleani_v, (mssm__glenum, unsigned, mssm__glboolean *))                 \
    X(const unsigned char *, GetStringi, (mssm__glenum, unsigned))                      \
    X(void, CreateVertexArrays, (int, unsigned *))                                      \
    X(void, DeleteVertexArrays, (int, const unsigned *))                                \
    X(void, BindVertexArray, (unsigned))                                                \
    X(mssm__glboolean, IsVertexArray, (unsigned))                                       \
    X(mssm__glboolean, IsFramebuffer, (unsigned))                                       \
    X(mssm__glboolean, IsEnabled, (mssm__glenum))                                       \
    X(mssm__glboolean, IsEnabledi, (mssm__glenum, unsigned))                            \
    X(void, Enable, (mssm__glenum))                                                     \
    X(void, Disable, (mssm__glenum))                                                    \
    X(void, Enablei, (mssm__glenum, unsigned))                                          \
    X(void, Disablei, (mssm__glenum, unsigned))                                         \
    X(void, ViewportIndexedf, (unsigned, float, float, float, float))                   \
    X(void, DepthRangeIndexed, (unsigned, double, double))                              \
    X(void, DepthFunc, (mssm__glenum))                                                  \
    X(void, DepthMask, (mssm__glboolean))                                               \
    X(void, ColorMaski,                                                                 \
      (unsigned, mssm__glboolean, mssm__glboolean, mssm__glboolean, mssm__glboolean))   \
    X(void, ClipControl, (mssm__glenum, mssm__glenum))                                  \
    X(void, CullFace, (mssm__glenum))                                                   \
    X(void, PolygonMode, (mssm__glenum, mssm__glenum))                                  \
    X(void, BindFramebuffer, (mssm__glenum, unsigned))                                  \
    X(void, CreateFramebuffers, (int, unsigned *))                                      \
    X(void, DeleteFramebuffers, (int, const unsigned *))                                \
    X(void, NamedFramebufferTextureLayer, (unsigned, mssm__glenum, unsigned, int, int)) \
    X(void, NamedFramebufferDrawBuffers, (unsigned, int, const mssm__glenum *))         \
    X(void, NamedFramebufferDrawBuffer, (unsigned, mssm__glenum))                       \
    X(void, NamedFramebufferReadBuffer, (unsigned, mssm__glenum))                       \
    X(mssm__glenum, CheckNamedFramebufferStatus, (unsigned, mssm__glenum))              \
    X(void, ClearBufferfv, (mssm__glenum, int, const float *))                          \
    X(void, CreateTextures, (mssm__glenum, int, unsigned *))                            \
    X(void, DeleteTextures, (int, const unsigned *))                                    \
    X(void, TextureStorage3D, (unsigned, int, mssm__glenum, int, int, int))             \
    X(void, TextureStorage3DMultisample,                                                \
      (unsigned, int, mssm__glenum, int, int, int, mssm__glboolean))                    \
    X(void, TextureParameteri, (unsigned, mssm__glenum, int))                           \
    X(void, TexParameteri, (mssm__glenum, mssm__glenum, int))                           \
    X(void, BindImageTexture,                                                           \
      (unsigned, unsigned, int, mssm__glboolean, int, mssm__glenum, mssm__glenum))      \
    X(void, ProgramUniform1iv, (unsigned, int, int, const int *))                       \
    X(void, ProgramUniform4fv, (unsigned, int, int, const float *))                     \
    X(void, DrawArrays, (mssm__glenum, int, int))

// clang-format off
enum {
    // limits and questions
    MSSM__GL_CONTEXT_PROFILE_MASK = 0x9126, MSSM__GL_EXTENSIONS = 0x1F03,
    MSSM__GL_NUM_EXTENSIONS = 0x821D, MSSM__GL_MAX_TEXTURE_SIZE = 0x0D33,
    MSSM__GL_MAX_ARRAY_TEXTURE_LAYERS = 0x88FF, MSSM__GL_MAX_DEPTH_TEXTURE_SAMPLES = 0x910F,
    MSSM__GL_MAX_DRAW_BUFFERS = 0x8824,
    // what is bound
    MSSM__GL_VERTEX_ARRAY_BINDING = 0x85B5, MSSM__GL_DRAW_FRAMEBUFFER_BINDING = 0x8CA6,
    MSSM__GL_IMAGE_BINDING_NAME = 0x8F3A, MSSM__GL_IMAGE_BINDING_LEVEL = 0x8F3B,
    MSSM__GL_IMAGE_BINDING_LAYERED = 0x8F3C, MSSM__GL_IMAGE_BINDING_LAYER = 0x8F3D,
    MSSM__GL_IMAGE_BINDING_ACCESS = 0x8F3E, MSSM__GL_IMAGE_BINDING_FORMAT = 0x906E,
    // state of a pass
    MSSM__GL_VIEWPORT = 0x0BA2, MSSM__GL_DEPTH_RANGE = 0x0B70, MSSM__GL_DEPTH_FUNC = 0x0B74,
    MSSM__GL_DEPTH_WRITEMASK = 0x0B72, MSSM__GL_LESS = 0x0201, MSSM__GL_ALWAYS = 0x0207,
    MSSM__GL_CULL_FACE_MODE = 0x0B45, MSSM__GL_FRONT = 0x0404, MSSM__GL_BACK = 0x0405,
    MSSM__GL_FRONT_AND_BACK = 0x0408, MSSM__GL_POLYGON_MODE = 0x0B40, MSSM__GL_FILL = 0x1B02,
    MSSM__GL_COLOR_WRITEMASK = 0x0C23, MSSM__GL_CLIP_ORIGIN = 0x935C, MSSM__GL_LOWER_LEFT = 0x8CA1,
    MSSM__GL_CLIP_DEPTH_MODE = 0x935D, MSSM__GL_NEGATIVE_ONE_TO_ONE = 0x935E,
    // capabilities
    MSSM__GL_SCISSOR_TEST = 0x0C11, MSSM__GL_DEPTH_TEST = 0x0B71, MSSM__GL_STENCIL_TEST = 0x0B90,
    MSSM__GL_CULL_FACE = 0x0B44, MSSM__GL_BLEND = 0x0BE2, MSSM__GL_RASTERIZER_DISCARD = 0x8C89,
    MSSM__GL_DEPTH_CLAMP = 0x864F, MSSM__GL_POLYGON_OFFSET_FILL = 0x8037,
    MSSM__GL_POLYGON_OFFSET_LINE = 0x2A02, MSSM__GL_POLYGON_OFFSET_POINT = 0x2A01,
    MSSM__GL_MULTISAMPLE = 0x809D, MSSM__GL_SAMPLE_ALPHA_TO_COVERAGE = 0x809E,
    MSSM__GL_SAMPLE_COVERAGE = 0x80A0, MSSM__GL_SAMPLE_MASK = 0x8E51,
    MSSM__GL_SAMPLE_SHADING = 0x8C36, MSSM__GL_COLOR_LOGIC_OP = 0x0BF2,
    MSSM__GL_CLIP_DISTANCE0 = 0x3000, MSSM__GL_ALPHA_TEST = 0x0BC0,
    MSSM__GL_POLYGON_STIPPLE = 0x0B42, MSSM__GL_DEPTH_BOUNDS_TEST = 0x8890,
    // framebuffers
    MSSM__GL_DRAW_FRAMEBUFFER = 0x8CA9, MSSM__GL_FRAMEBUFFER_COMPLETE = 0x8CD5,
    MSSM__GL_DEPTH_ATTACHMENT = 0x8D00, MSSM__GL_COLOR_ATTACHMENT0 = 0x8CE0,
    MSSM__GL_DEPTH = 0x1801, MSSM__GL_TRIANGLES = 0x0004,
    // textures and what is bound of them
    MSSM__GL_TEXTURE_2D = 0x0DE1, MSSM__GL_TEXTURE_BINDING_2D = 0x8069,
    MSSM__GL_TEXTURE_2D_ARRAY = 0x8C1A, MSSM__GL_TEXTURE_BINDING_2D_ARRAY = 0x8C1D,
    MSSM__GL_TEXTURE_CUBE_MAP_ARRAY = 0x9009, MSSM__GL_TEXTURE_BINDING_CUBE_MAP_ARRAY = 0x900A,
    MSSM__GL_TEXTURE_2D_MULTISAMPLE = 0x9100, MSSM__GL_TEXTURE_BINDING_2D_MULTISAMPLE = 0x9104,
    MSSM__GL_TEXTURE_2D_MULTISAMPLE_ARRAY = 0x9102,
    MSSM__GL_TEXTURE_BINDING_2D_MULTISAMPLE_ARRAY = 0x9105,
    // their properties
    MSSM__GL_TEXTURE_SAMPLES = 0x9106, MSSM__GL_TEXTURE_HEIGHT = 0x1001,
    MSSM__GL_TEXTURE_MAX_LEVEL = 0x813D, MSSM__GL_TEXTURE_IMMUTABLE_FORMAT = 0x912F,
    MSSM__GL_TEXTURE_INTERNAL_FORMAT = 0x1003, MSSM__GL_TEXTURE_DEPTH = 0x8071,
    MSSM__GL_TEXTURE_DEPTH_SIZE = 0x884A, MSSM__GL_TEXTURE_RED_TYPE = 0x8C10,
    MSSM__GL_FLOAT = 0x1406, MSSM__GL_UNSIGNED_NORMALIZED = 0x8C17,
    MSSM__GL_SIGNED_NORMALIZED = 0x8F9C, MSSM__GL_DEPTH_STENCIL_TEXTURE_MODE = 0x90EA,
    MSSM__GL_DEPTH_COMPONENT = 0x1902, MSSM__GL_DEPTH_TEXTURE_MODE = 0x884B,
    MSSM__GL_TEXTURE_SWIZZLE_R = 0x8E42, MSSM__GL_RED = 0x1903, MSSM__GL_TEXTURE_WRAP_S = 0x2802,
    MSSM__GL_TEXTURE_WRAP_T = 0x2803, MSSM__GL_CLAMP_TO_EDGE = 0x812F,
    // formats
    MSSM__GL_RGBA32I = 0x8D82, MSSM__GL_RG32I = 0x823B, MSSM__GL_RG32F = 0x8230,
    MSSM__GL_RGBA32F = 0x8814, MSSM__GL_RGBA16 = 0x805B, MSSM__GL_RG16 = 0x822C,
    MSSM__GL_DEPTH_COMPONENT32F = 0x8CAC,
    // access
    MSSM__GL_READ_ONLY = 0x88B8, MSSM__GL_READ_WRITE = 0x88BA,
    MSSM__GL_DYNAMIC_STORAGE_BIT = 0x0100,
    // kinds of objects, for labels
    MSSM__GL_VERTEX_ARRAY = 0x8074, MSSM__GL_TEXTURE = 0x1702, MSSM__GL_FRAMEBUFFER = 0x8D40,
    // image access and texture fetch; with framebuffers
    MSSM__GL_BARRIERS = 0x20 | 0x8, MSSM__GL_ALL_BARRIERS = MSSM__GL_BARRIERS | 0x400
};
// clang-format on

// [plumbing begin], which `make glsl` copies into lightprobe.h under its own prefix

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#ifndef MSSM_MALLOC
#define MSSM_MALLOC(bytes) malloc(bytes)
#define MSSM_FREE(memory) free(memory)
#endif

#if defined _WIN32 && !defined _WIN64
#define MSSM__GLAPI __stdcall
#else
#define MSSM__GLAPI
#endif

// Types and constants under names of our own, so that any GL header may be included too.
typedef unsigned int mssm__glenum;
typedef unsigned char mssm__glboolean;

// X(result, name without "gl", parameters): what both headers call, and what this one alone does.
// Not those by name that Intel's driver for Windows takes without a word and does not carry out:
// clears, buffers, cube maps, glBindTextureUnit, queries.
#define MSSM__GL_FUNCTIONS(X)                                                  \
    X(void, GetIntegerv, (mssm__glenum, int *))                                \
    X(const unsigned char *, GetString, (mssm__glenum))                        \
    X(mssm__glenum, GetError, (void))                                          \
    X(void, GetIntegeri_v, (mssm__glenum, unsigned, int *))                    \
    X(mssm__glboolean, IsTexture, (unsigned))                                  \
    X(mssm__glboolean, IsBuffer, (unsigned))                                   \
    X(mssm__glboolean, IsSampler, (unsigned))                                  \
    X(mssm__glboolean, IsProgram, (unsigned))                                  \
    X(void, GetTexLevelParameteriv, (mssm__glenum, int, mssm__glenum, int *))  \
    X(void, ActiveTexture, (mssm__glenum))                                     \
    X(void, BindTexture, (mssm__glenum, unsigned))                             \
    X(void, BindSampler, (unsigned, unsigned))                                 \
    X(void, CreateSamplers, (int, unsigned *))                                 \
    X(void, DeleteSamplers, (int, const unsigned *))                           \
    X(void, SamplerParameteri, (unsigned, mssm__glenum, int))                  \
    X(void, GetTexParameteriv, (mssm__glenum, mssm__glenum, int *))            \
    X(void, CreateBuffers, (int, unsigned *))                                  \
    X(void, DeleteBuffers, (int, const unsigned *))                            \
    X(void, BufferStorage, (mssm__glenum, ptrdiff_t, const void *, unsigned))  \
    X(void, BufferSubData, (mssm__glenum, ptrdiff_t, ptrdiff_t, const void *)) \
    X(void, BindBuffer, (mssm__glenum, unsigned))                              \
    X(void, BindBufferBase, (mssm__glenum, unsigned, unsigned))                \
    X(unsigned, CreateShader, (mssm__glenum))                                  \
    X(void, DeleteShader, (unsigned))                                          \
    X(void, ShaderSource, (unsigned, int, const char *const *, const int *))   \
    X(void, CompileShader, (unsigned))                                         \
    X(void, GetShaderiv, (unsigned, mssm__glenum, int *))                      \
    X(void, GetShaderInfoLog, (unsigned, int, int *, char *))                  \
    X(unsigned, CreateProgram, (void))                                         \
    X(void, DeleteProgram, (unsigned))                                         \
    X(void, AttachShader, (unsigned, unsigned))                                \
    X(void, LinkProgram, (unsigned))                                           \
    X(void, GetProgramiv, (unsigned, mssm__glenum, int *))                     \
    X(void, GetProgramInfoLog, (unsigned, int, int *, char *))                 \
    X(void, UseProgram, (unsigned))                                            \
    X(void, ProgramUniform1i, (unsigned, int, int))                            \
    X(void, DispatchCompute, (unsigned, unsigned, unsigned))                   \
    X(void, MemoryBarrier, (unsigned))                                         \
    X(void, ObjectLabel, (mssm__glenum, unsigned, int, const char *))          \
    MSSM__GL_OWN(X)

typedef struct mssm__gl_functions {
#define MSSM__GL_MEMBER(result, name, parameters) result(MSSM__GLAPI *name) parameters;
    MSSM__GL_FUNCTIONS(MSSM__GL_MEMBER)
#undef MSSM__GL_MEMBER
} mssm__gl_functions;

// Of both headers, and what stands with these in one expression: C++ wants that of one enum.
// clang-format off
enum {
    // limits and questions
    MSSM__GL_OUT_OF_MEMORY = 0x0505, MSSM__GL_VERSION = 0x1F02, MSSM__GL_MAJOR_VERSION = 0x821B,
    MSSM__GL_MINOR_VERSION = 0x821C, MSSM__GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS = 0x8B4D,
    MSSM__GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS = 0x90DD,
    MSSM__GL_TRANSFORM_FEEDBACK_ACTIVE = 0x8E24, MSSM__GL_TRANSFORM_FEEDBACK_PAUSED = 0x8E23,
    // what is bound
    MSSM__GL_CURRENT_PROGRAM = 0x8B8D, MSSM__GL_ACTIVE_TEXTURE = 0x84E0,
    MSSM__GL_SAMPLER_BINDING = 0x8919, MSSM__GL_SHADER_STORAGE_BUFFER_BINDING = 0x90D3,
    // textures and what is bound of them
    MSSM__GL_TEXTURE0 = 0x84C0, MSSM__GL_TEXTURE_CUBE_MAP_POSITIVE_X = 0x8515,
    MSSM__GL_TEXTURE_CUBE_MAP = 0x8513, MSSM__GL_TEXTURE_BINDING_CUBE_MAP = 0x8514,
    // their properties
    MSSM__GL_TEXTURE_BASE_LEVEL = 0x813C, MSSM__GL_TEXTURE_WIDTH = 0x1000,
    MSSM__GL_TEXTURE_MIN_FILTER = 0x2801, MSSM__GL_TEXTURE_MAG_FILTER = 0x2800,
    MSSM__GL_NEAREST = 0x2600, MSSM__GL_NEAREST_MIPMAP_NEAREST = 0x2700, MSSM__GL_LINEAR = 0x2601,
    MSSM__GL_LINEAR_MIPMAP_LINEAR = 0x2703,
    // access
    MSSM__GL_SHADER_STORAGE_BUFFER = 0x90D2,
    // shaders
    MSSM__GL_COMPUTE_SHADER = 0x91B9, MSSM__GL_VERTEX_SHADER = 0x8B31,
    MSSM__GL_FRAGMENT_SHADER = 0x8B30, MSSM__GL_COMPILE_STATUS = 0x8B81,
    MSSM__GL_LINK_STATUS = 0x8B82, MSSM__GL_INFO_LOG_LENGTH = 0x8B84,
    // kinds of objects, for labels
    MSSM__GL_BUFFER = 0x82E0, MSSM__GL_SAMPLER = 0x82E6, MSSM__GL_PROGRAM = 0x82E2
};
// clang-format on

// [plumbing end]

// Programs: of soft shadows to MSSM__RESOLVE, of filtered ones from there to MSSM__COPY; the rest
// when needed, last those of given depth maps: each target without and with back faces.
// clang-format off
enum {
    MSSM__ROWS, MSSM__HALVE, MSSM__COLUMNS, MSSM__LEAST, MSSM__AVERAGE, MSSM__RESOLVE,
    MSSM__FILTER, MSSM__COPY, MSSM__STORE, MSSM__SHOW, MSSM__GIVEN,
    MSSM__PROGRAMS = MSSM__GIVEN + 12
};
// clang-format on

// Of filtered maps, to work in: textures after the three that shading reads, and a framebuffer.
enum { MSSM__LEAST_DEPTHS = 2, MSSM__WORK, MSSM__BLURRED_ROWS, MSSM__FARTHEST, MSSM__TABLES };
enum { MSSM__TRANSLUCENT = 1, MSSM__FRAMEBUFFERS };
static const struct {
    const char *label;
    mssm__glenum format[2]; // of soft and of filtered shadows, 0: these have none
    unsigned char bytes[2]; // of a texel
} mssm__tables[MSSM__TABLES] = {
    {"mssm tables, moments 1 to 4", {MSSM__GL_RGBA32I, MSSM__GL_RGBA16}, {16, 8}},
    {"mssm tables, moments 5 and 6", {MSSM__GL_RG32I, MSSM__GL_RG16}, {8, 4}},
    {"mssm least depths", {MSSM__GL_RG32F, 0}, {8, 0}},
    {"mssm moments", {0, MSSM__GL_RGBA32F}, {0, 16}},
    {"mssm blurred rows", {0, MSSM__GL_RGBA32F}, {0, 16}},
    {"mssm depth, one sample", {0, MSSM__GL_DEPTH_COMPONENT32F}, {0, 4}}};
// Layers of the depth target at most, and bytes if there are more than a light needs. GPUs wait for
// a target that is drawn to before they read it: the more passes it holds, the fewer waits.
enum { MSSM__LAYERS = 16, MSSM__TARGET_BYTES = 32 << 20 };
enum { MSSM__GIVEN_UNIFORM = 2 + 5 * MSSM__LAYERS }; // after the job
enum { MSSM__BATCH = 256 };       // lights whose tables are built by one dispatch
enum { MSSM__CAPABILITIES = 25 }; // at most

// State of the caller from begin to end of a depth pass.
typedef struct mssm__gl_state {
    int framebuffer, depth_func, depth_mask, cull_mode, clip_origin, clip_depth, polygon_mode[2];
    int enabled[MSSM__CAPABILITIES], scissor;
    mssm__glboolean mask[2][4]; // of the colours that translucent casters write
    float viewport[4];
    double depth_range[2];
} mssm__gl_state;

typedef struct mssm__gl_bindings {
    int program, array, active, buffer, texture[2][6], sampler[2], image[4][6];
} mssm__gl_bindings;

// A depth map given to mssm_gl_set_depth, as GL said it is.
typedef struct mssm__gl_source {
    mssm_gl_depth is;
    int kind;             // of mssm__targets
    int across, up, each; // texels of a texel of the moment map, and their samples
    int state[3];         // of the texture, where it is in the way
} mssm__gl_source;

typedef struct mssm__gl_light {
    mssm_light light;
    mssm_light drawn; // that of the map
    mssm__gl_source source[2];
    int averaged;
    int filled;   // was drawn, the map is not empty
    int built;    // levels whose tables are up to date
    int changed;  // since its view was made
    float widest; // kernel that it can need, in texels
} mssm__gl_light;

struct mssm_gl {
    mssm__gl_functions f;
    mssm_gl_desc desc;                           // with defaults filled in
    mssm__glenum capability[MSSM__CAPABILITIES]; // those that there are in this context
    int capabilities, compatible;                // with the compatibility profile
    int levels, depth_levels, padded,
        samples;               // samples that the driver gives: at least those asked for
    int drawing, back;         // light of the pass between begin and end, or -1; which faces
    int front_of;              // light of the last pass, if that was of front faces, or -1
    int layers, used;          // of the depth target; those of passes that are not moments
    int waiting[MSSM__LAYERS]; // lights whose front faces these hold, or -1; back faces follow
    int stale;                 // something has changed since the last build
    int first_changed, last_changed; // lights whose views the buffer does not have
    int bound;                       // by mssm_gl_bind, at least once
    unsigned depth, framebuffer[MSSM__FRAMEBUFFERS], table[MSSM__TABLES], views,
        program[MSSM__PROGRAMS];
    unsigned sampler;  // that of given depth maps
    unsigned array;    // without attributes
    int targets;       // that textures are bound to, as bits: those of the caller are saved
    int usual_targets; // outside of a frame
    int framing;       // between mssm_gl_begin_frame and its end: nothing is saved or put back
    mssm__gl_state saved;
    mssm__gl_bindings bindings; // of the caller
    mssm__gl_light *lights;
    mssm_view *view;
    char *shader;
    int filtered;
    int ready;       // filtered: light whose moments are in work, not built yet, or -1
    int translucent; // the pass under way is one of translucent casters
    int unbound;     // only the text of mssm_glsl_shader is wanted
};

#ifndef MSSM_NO_FILTERED
static const char *mssm__glsl_filtered(void);
static mssm_result mssm__filtered_targets(mssm_gl *gl);
static void mssm__filtered_build(mssm_gl *gl, int instead);
#else
#define mssm__filtered_targets(gl) MSSM_OK
#define mssm__filtered_build(gl, instead) // nothing
#endif

// ---- GLSL by hand, each text for the C of its name ---- >>shaders

static const char mssm__glsl_version[] = "#version 450 core\n";

// Around a text of shading: one line for what cannot work; the user's lines keep their numbers.
static const char mssm__glsl_needs[] = "#if __VERSION__ < 430\n"
                                       "#error mssm.h needs #version 430 or higher above its text\n"
                                       "#endif\n";
static const char mssm__glsl_needs_less[] =
    "#if __VERSION__ < 300 || (!defined GL_ES && __VERSION__ < 330)\n"
    "#error mssm.h needs #version 330, 300 es or higher above its text\n"
    "#endif\n";
static const char mssm__glsl_end[] = "#line 1\n";

// Depth as drawn to depth linear in distance.
static const char mssm__glsl_linear_depth[] =
    "// samples, side of the maps; of each light its index, layer of its depth, 1: perspective; near, far\n"
    "layout(location = 0) uniform int job[2 + 5 * MSSM_LAYERS];\n"
    "int first = 2 + 5 * int(gl_WorkGroupID.z), light = job[first], layer = job[first + 1];\n"
    "float near = intBitsToFloat(job[first + 3]), far = intBitsToFloat(job[first + 4]);\n"
    "float linear_depth(float d)\n"
    "{\n"
    "    precise float z = 2.0 * d - 1.0;\n"
    "    float w = 2.0 * near * far / (far + near - z * (far - near));\n"
    "    float depth = -1.0 + 2.0 * (w - near) / (far - near);\n"
    "    return d >= 1.0 ? 1.0 : clamp(job[first + 2] > 0 ? depth : z, -1.0, 1.0);\n"
    "}\n";

// Of a pass of our own: sample s of a texel; back faces have the layer after the front faces.
static const char mssm__glsl_drawn[] =
    "#define MSSM_SAMPLER sampler2DMSArray\n"
    "#define MSSM_DEPTH(map, i, p, s) linear_depth(texelFetch(front, ivec3(p, layer + i), s).x)\n";

// Of a given depth map. Nearness is 0 at the far end, where floats are finest with reversed depth.
// No branch hangs on a uniform alone: zink of Mesa 22 takes what that was some dispatches ago.
static const char mssm__glsl_given[] =
    "#define MSSM_DEPTH(map, i, p, s) given_depth(MSSM_FETCH(map, given_texel(p, s, 10 + 3 * i), job[12 + 3 * i], s % job[9]), p)\n"
    "// In job after the light: texels across and up, samples of each; x, y, layer of each map.\n"
    "layout(location = MSSM_GIVEN) uniform vec4 given[3];\n"
    "vec4 stored = given[0];  // nearness as scale and offset; half-sizes at distance 1 if radial\n"
    "vec4 law = given[1];  // distance as a quotient of polynomials of nearness\n"
    "float straight = given[2].x;  // 1: depth as a pass has it, -1: reversed, 0: by the law\n"
    "ivec2 given_texel(ivec2 p, int s, int x)\n"
    "{\n"
    "    int t = s / job[9];\n"
    "    return ivec2(job[x], job[x + 1]) + p * ivec2(job[7], job[8]) + ivec2(t % job[7], t / job[7]);\n"
    "}\n"
    "vec3 cube_direction(int face, ivec2 at, int size)\n"
    "{\n"
    "    vec2 c = (2.0 * vec2(at) + 1.0) / float(size) - 1.0;\n"
    "    float major = (face & 1) == 0 ? 1.0 : -1.0;\n"
    "    if (face < 2) return vec3(major, -c.y, -major * c.x);\n"
    "    if (face < 4) return vec3(c.x, major, major * c.y);\n"
    "    return vec3(major * c.x, -c.y, major);\n"
    "}\n"
    "float given_depth(float v, ivec2 p)\n"
    "{\n"
    "    float nearness = v * stored.x + stored.y;\n"
    "    vec2 at = (2.0 * vec2(p) + 1.0) / float(job[1]) - 1.0;\n"
    "    float w = (law.x + law.y * nearness) / ((law.z + law.w * nearness) * length(vec3(at * stored.zw, 1.0)));\n"
    "    float z = mssm_clamp(-1.0 + 2.0 * (w - near) / (far - near), -1.0, 1.0);\n"
    "    float drawn = linear_depth(v), reversed = clamp(1.0 - 2.0 * v, -1.0, 1.0);\n"
    "    z = straight > 0.0 ? drawn : z;\n"
    "    z = straight < 0.0 ? reversed : z;\n"
    "    return nearness > 0.0 ? z : 1.0;\n"
    "}\n";

// Depth, or with MSSM_STORE encoded moments, to Chebyshev moments as integers, one thread a texel;
// for filtered maps encoded, 1 to 3 in a layer, 4 to 6 in another: alpha is free for blending.
// `precise`: tables of directional lights are those of C bit for bit; linear depth has quotients.
static const char mssm__glsl_resolve[] =
    "layout(local_size_x = 32, local_size_y = 2) in;\n"
    "#ifdef MSSM_STORE\n"
    "layout(binding = 3, rgba32f) readonly uniform image2DArray source;\n"
    "#else\n"
    "layout(binding = MSSM_UNIT) uniform MSSM_SAMPLER front;\n"
    "#endif\n"
    "#ifdef MSSM_AVERAGE\n"
    "layout(binding = MSSM_NEXT_UNIT) uniform MSSM_SAMPLER back;\n"
    "#endif\n"
    "#ifdef MSSM_FILTERED\n"
    "layout(binding = 0, rgba32f) writeonly uniform image2DArray work;\n"
    "#else\n"
    "layout(binding = 0, rgba32i) writeonly uniform iimage2DArray table0;\n"
    "layout(binding = 1, rg32i) writeonly uniform iimage2DArray table1; // of six moments\n"
    "layout(binding = 2, rg32f) writeonly uniform image2DArray depths;\n"
    "#endif\n"
    "shared vec2 nearest[64];\n"
    "ivec4 to_integer(vec4 t)\n"
    "{\n"
    "    float one = float(MSSM_SCALE);\n"
    "    precise vec4 scaled = t * (one / float(job[0])) + (one + 1.5);\n"
    "    return ivec4(scaled) - (MSSM_SCALE + 1);\n"
    "}\n"
    "void main()\n"
    "{\n"
    "    ivec2 p = ivec2(gl_GlobalInvocationID.xy);\n"
    "    bool inside = all(lessThan(p, ivec2(job[1])));\n"
    "    vec2 least = vec2(1.0);\n"
    "    precise vec4 sum = vec4(0.0);\n"
    "    precise vec4 more = vec4(0.0);\n"
    "#ifdef MSSM_STORE\n"
    "    vec4 low = inside ? imageLoad(source, ivec3(p, 0)) : vec4(1.0);\n"
    "    vec4 high = inside ? imageLoad(source, ivec3(p, 1)) : vec4(1.0);\n"
    "    sum = 2.0 * clamp(vec4(low.xyz, high.x), 0.0, 1.0) - 1.0;\n"
    "    more.xy = 2.0 * clamp(high.yz, 0.0, 1.0) - 1.0;\n"
    "    least = vec2(low.x < MSSM_EMPTY ? -1.0 : 1.0, -1.0); // as near as depth goes\n"
    "#else\n"
    "    int s = 0, samples = gl_NumWorkGroups.x == 0u ? 1 : job[0];\n"
    "    do {\n"
    "        float z = inside ? MSSM_DEPTH(front, 0, p, s) : 1.0;\n"
    "#ifdef MSSM_AVERAGE\n"
    "        if (inside) z = 0.5 * (z + MSSM_DEPTH(back, 1, p, s));\n"
    "#endif\n"
    "        if (inside) least = min(vec2(z, -z), least);\n"
    "        mssm_moments6 t = mssm_chebyshev(z);\n"
    "        sum += vec4(t.b[0], t.b[1], t.b[2], t.b[3]);\n"
    "        more += vec4(t.b[4], t.b[5], 0.0, 0.0);\n"
    "    } while (++s < samples);\n"
    "#endif\n"
    "#ifdef MSSM_FILTERED\n"
    "    if (!inside) return;\n"
    "    imageStore(work, ivec3(p, 0), vec4(0.5 + 0.5 * sum.xyz / float(job[0]), 1.0));\n"
    "    imageStore(work, ivec3(p, 1), vec4(0.5 + 0.5 * vec3(sum.w, more.xy) / float(job[0]), 1.0));\n"
    "#else\n"
    "    if (all(lessThan(p, imageSize(table0).xy))) {\n"
    "        imageStore(table0, ivec3(p, light), to_integer(sum));\n"
    "#if MSSM_MOMENTS == 6\n"
    "        imageStore(table1, ivec3(p, light), to_integer(more));\n"
    "#endif\n"
    "    }\n"
    "    int i = int(gl_LocalInvocationIndex);\n"
    "    nearest[i] = least;\n"
    "    memoryBarrierShared();\n"
    "    barrier();\n"
    "    if (i >= 32 || (i & 1) == 1) return;\n"
    "    least = min(min(nearest[i], nearest[i + 1]), min(nearest[i + 32], nearest[i + 33]));\n"
    "    imageStore(depths, ivec3(p / 2, light), least.xyxy);\n" // beyond the image nothing is stored
    "#endif\n"
    "}\n";

// Least depths of three levels from the one below, by mssm__coarsen_depths: a work group's 8 x 8, 4
// x 4 and 2 x 2 texels, and as many of the next groups' as these have in them.
static const char mssm__glsl_least[] =
    "layout(local_size_x = 11, local_size_y = 11) in;\n"
    "layout(binding = 0, rg32f) readonly uniform image2DArray finer;\n"
    "layout(binding = 1, rg32f) writeonly uniform image2DArray half_size;\n"
    "layout(binding = 2, rg32f) writeonly uniform image2DArray quarter;\n"
    "layout(binding = 3, rg32f) writeonly uniform image2DArray eighth;\n"
    "layout(location = 0) uniform int layers[MSSM_BATCH];\n"
    "layout(location = MSSM_BATCH) uniform int stride;\n"
    "shared vec2 nearest[121];\n"
    "vec2 next_of(ivec2 p, vec2 least)\n"
    "{\n"
    "    barrier();\n"
    "    nearest[gl_LocalInvocationIndex] = least;\n"
    "    memoryBarrierShared();\n"
    "    barrier();\n"
    "    int i = 2 * min(p.x, 4) + 22 * min(p.y, 4);\n" // threads beyond have nothing to say
    "    return min(min(nearest[i], nearest[i + 2]), min(nearest[i + 22], nearest[i + 24]));\n"
    "}\n"
    "void main()\n"
    "{\n"
    "    ivec2 p = ivec2(gl_LocalInvocationID.xy), group = ivec2(gl_WorkGroupID.xy);\n"
    "    ivec2 from = 2 * (8 * group + p), last = imageSize(finer).xy - 1;\n"
    "    int layer = layers[gl_WorkGroupID.z];\n"
    "    vec2 least = vec2(1.0);\n"
    "    for (int y = 0; y < 4; y += stride) {\n"
    "        for (int x = 0; x < 4; x += stride) {\n"
    "            least = min(imageLoad(finer, ivec3(min(from + ivec2(x, y), last), layer)).xy, least);\n"
    "        }\n"
    "    }\n"
    "    if (max(p.x, p.y) < 8) imageStore(half_size, ivec3(8 * group + p, layer), least.xyxy);\n"
    "    least = next_of(p, least);\n"
    "    if (max(p.x, p.y) < 4) imageStore(quarter, ivec3(4 * group + p, layer), least.xyxy);\n"
    "    least = next_of(p, least);\n"
    "    if (max(p.x, p.y) < 2) imageStore(eighth, ivec3(2 * group + p, layer), least.xyxy);\n"
    "}\n";

// What the table passes share: the level in hand, and the lights of a batch.
static const char mssm__glsl_tables[] =
    "layout(binding = 0, rgba32i) uniform iimage2DArray table0;\n"
    "layout(binding = 1, rg32i) uniform iimage2DArray table1; // of six moments\n"
    "layout(location = 0) uniform int layers[MSSM_BATCH];\n"
    "struct entry { ivec4 a; ivec2 b; };\n"
    "#if MSSM_MOMENTS == 6\n"
    "#define entry_of(image0, image1, p) entry(imageLoad(image0, p), imageLoad(image1, p).xy)\n"
    "#else\n"
    "#define entry_of(image0, image1, p) entry(imageLoad(image0, p), ivec2(0))\n"
    "#endif\n"
    "void store(ivec3 p, entry e)\n"
    "{\n"
    "    imageStore(table0, p, e.a);\n"
    "#if MSSM_MOMENTS == 6\n"
    "    imageStore(table1, p, ivec4(e.b, 0, 0));\n"
    "#endif\n"
    "}\n"
    "entry add(entry e, entry f)\n"
    "{\n"
    "    return entry(e.a + f.a, e.b + f.b);\n"
    "}\n";

// Prefix sums along rows: eight texels a thread in registers, a scan of the threads' sums in shared
// memory, a carry from block to block; as many rows as there are threads for. With MSSM_HALVE
// texels are means of four of the level below, each one difference of its finished table.
static const char mssm__glsl_rows[] =
    "layout(local_size_x = 64) in;\n"
    "#ifdef MSSM_HALVE\n"
    "layout(binding = 2, rgba32i) readonly uniform iimage2DArray finer0;\n"
    "layout(binding = 3, rg32i) readonly uniform iimage2DArray finer1;\n"
    "layout(location = MSSM_BATCH) uniform int finer_size;\n"
    "entry finer(ivec3 p)\n"
    "{\n"
    "    if (p.x < 0 || p.y < 0) return entry(ivec4(0), ivec2(0));\n"
    "    return entry_of(finer0, finer1, p);\n"
    "}\n"
    "// What two rows of the level below hold up to column x.\n"
    "entry pair(int x, int y, int layer)\n"
    "{\n"
    "    int last = finer_size - 1;\n"
    "    x = min(x, last);\n"
    "    entry low = finer(ivec3(x, min(y, last), layer)), high = finer(ivec3(x, min(y + 2, last), layer));\n"
    "    return entry(high.a - low.a, high.b - low.b);\n"
    "}\n"
    "#endif\n"
    "shared ivec4 sums_a[2][64];\n"
    "shared ivec2 sums_b[2][64];\n"
    "void main()\n"
    "{\n"
    "    int size = imageSize(table0).x;\n"
    "    int threads = 1, turn = 0; // of a row\n"
    "    while (threads < 64 && 8 * threads < size) threads *= 2;\n"
    "    int thread = int(gl_LocalInvocationID.x), in_row = thread & (threads - 1);\n"
    "    int last = thread | (threads - 1);\n"
    "    ivec3 p = ivec3(0, (int(gl_WorkGroupID.y) * 64 + thread) / threads,\n"
    "                    layers[gl_WorkGroupID.z]);\n"
    "    entry none = entry(ivec4(0), ivec2(0)), carry = none;\n"
    "    for (int start = 0; start < size; start += 8 * threads) {\n"
    "        entry e[8], sum = none;\n"
    "        int x = start + 8 * in_row, count = p.y < size ? size - x : 0;\n"
    "#ifdef MSSM_HALVE\n"
    "        entry left = pair(2 * x - 1, 2 * p.y - 1, p.z);\n"
    "        int doubled = 2 * p.y + 2 > finer_size ? 1 : 0; // half of what there would be\n"
    "#endif\n"
    "        for (int i = 0; i < 8; i++) {\n"
    "            p.x = x + i;\n"
    "            e[i] = none;\n"
    "#ifdef MSSM_HALVE\n"
    "            if (i < count) {\n"
    "                entry right = pair(2 * p.x + 1, 2 * p.y - 1, p.z);\n"
    "                int twice = doubled + (2 * p.x + 2 > finer_size ? 1 : 0);\n"
    "                e[i] = entry((((right.a - left.a) << twice) + 2) >> 2,\n"
    "                             (((right.b - left.b) << twice) + 2) >> 2);\n"
    "                left = right;\n"
    "            }\n"
    "#else\n"
    "            if (i < count) e[i] = entry_of(table0, table1, p);\n"
    "#endif\n"
    "            sum = e[i] = add(sum, e[i]);\n"
    "        }\n"
    "        entry upto = sum; // all threads of the row up to this one\n"
    "        for (int step = 1; step <= threads; step *= 2) {\n"
    "            sums_a[turn][thread] = upto.a;\n"
    "            sums_b[turn][thread] = upto.b;\n"
    "            memoryBarrierShared();\n"
    "            barrier();\n"
    "            if (step < threads && in_row >= step) {\n"
    "                upto = add(upto, entry(sums_a[turn][thread - step], sums_b[turn][thread - step]));\n"
    "            }\n"
    "            turn ^= 1;\n"
    "        }\n"
    "        entry before = entry(carry.a + upto.a - sum.a, carry.b + upto.b - sum.b);\n"
    "        for (int i = 0; i < 8; i++) {\n"
    "            p.x = x + i;\n"
    "            if (i < count) store(p, add(before, e[i]));\n"
    "        }\n"
    "        carry = add(carry, entry(sums_a[turn ^ 1][last], sums_b[turn ^ 1][last]));\n"
    "    }\n"
    "}\n";

// Prefix sums along columns, a thread each: neighbours read neighbours, eight rows at a time.
static const char mssm__glsl_columns[] =
    "layout(local_size_x = 64) in;\n"
    "void main()\n"
    "{\n"
    "    ivec2 size = imageSize(table0).xy;\n"
    "    ivec3 p = ivec3(gl_GlobalInvocationID.x, 0, layers[gl_WorkGroupID.z]);\n"
    "    if (p.x >= size.x) return;\n"
    "    entry sum = entry(ivec4(0), ivec2(0)), e[8];\n"
    "    for (int y = 0; y < size.y; y += 8) {\n"
    "        for (int i = 0; i < 8; i++) {\n"
    "            p.y = min(y + i, size.y - 1);\n"
    "            e[i] = entry_of(table0, table1, p);\n"
    "        }\n"
    "        for (int i = 0; i < 8; i++) {\n"
    "            p.y = y + i;\n"
    "            sum = add(sum, e[i]);\n"
    "            if (p.y < size.y) store(p, sum);\n"
    "        }\n"
    "    }\n"
    "}\n";

// In the texts of an mssm_gl @ stands for the name of its function, $ for what its other names
// begin with. The estimators are overloaded for its own type of map. This goes before them.
static const char mssm__glsl_depths[] =
    "struct $map { int light; };\n"
    "float mssm_least($map map, float x, float y, float half_size, int which);\n"
    "#define MSSM_MAP $map\n"
    "#define MSSM_LEAST_DEPTH(map, x, y, half_size) mssm_least(map, x, y, half_size, 0)\n"
    "#define MSSM_GREATEST_DEPTH(map, x, y, half_size) (-mssm_least(map, x, y, half_size, 1))\n";

// Nine rectangles of whole texels with their weights, as mssm__add_strips does. A row of entries
// starts the differences of the next: the first takes no floats.
static const char mssm__glsl_strips[] =
    "#ifndef MSSM_GLSL_STRIPS\n"
    "#define MSSM_GLSL_STRIPS\n"
    "#ifdef GL_ES\nprecision highp isampler2DArray;\nprecision highp sampler2DArray;\n#endif\n"
    "#define MSSM_INVERSE_SCALE ((1.0 - 2.4e-7) / float(MSSM_SCALE))\n"
    "// A row of table entries of one texture, as exact differences modulo 2^32.\n"
    "struct mssm_entries { ivec4 first, whole, last; };\n"
    "mssm_entries mssm_read(isampler2DArray table, ivec4 x, int keep, ivec3 row)\n"
    "{\n"
    "    ivec4 e0 = texelFetch(table, ivec3(x.x, row.xy), row.z) & keep;\n"
    "    ivec4 e1 = texelFetch(table, ivec3(x.y, row.xy), row.z);\n"
    "    ivec4 e2 = texelFetch(table, ivec3(x.z, row.xy), row.z);\n"
    "    ivec4 e3 = texelFetch(table, ivec3(x.w, row.xy), row.z);\n"
    "    return mssm_entries(e1 - e0, e2 - e1, e3 - e2);\n"
    "}\n"
    "// Sums over the three strips between two rows.\n"
    "vec4 mssm_strip(mssm_entries low, mssm_entries high, mssm_strips x)\n"
    "{\n"
    "    return (x.first * vec4(high.first - low.first) + x.last * vec4(high.last - low.last)) +\n"
    "           vec4(high.whole - low.whole);\n"
    "}\n"
    "// Columns x and rows y of entries; the first of each may be left of the table.\n"
    "vec4 mssm_sum(isampler2DArray table, int light, int level, ivec4 x, ivec4 y, mssm_strips sx,\n"
    "              mssm_strips sy)\n"
    "{\n"
    "    int keep = x.x < 0 ? 0 : -1, keep_row = y.x < 0 ? 0 : -1;\n"
    "    x.x = max(x.x, 0);\n"
    "    mssm_entries r0 = mssm_read(table, x, keep, ivec3(max(y.x, 0), light, level));\n"
    "    r0 = mssm_entries(r0.first & keep_row, r0.whole & keep_row, r0.last & keep_row);\n"
    "    mssm_entries r1 = mssm_read(table, x, keep, ivec3(y.y, light, level));\n"
    "    vec4 parts = sy.first * mssm_strip(r0, r1, sx), whole = vec4(0.0);\n"
    "    if (y.z > y.y) { // narrow kernels have no whole row\n"
    "        r0 = r1;\n"
    "        r1 = mssm_read(table, x, keep, ivec3(y.z, light, level));\n"
    "        whole = mssm_strip(r0, r1, sx);\n"
    "    }\n"
    "    mssm_entries r3 = mssm_read(table, x, keep, ivec3(y.w, light, level));\n"
    "    parts += sy.last * mssm_strip(r1, r3, sx);\n"
    "    return parts + whole;\n"
    "}\n"
    "#endif\n";

// What shading reads, of an mssm_gl and without one; a light that is not there has no texels: lit.
static const char mssm__glsl_bound[] =
    "layout(binding = MSSM_UNIT) uniform isampler2DArray $table0;\n"
    "#if MSSM_MOMENTS == 6\n"
    "layout(binding = MSSM_NEXT_UNIT) uniform isampler2DArray $table1;\n"
    "#endif\n"
    "layout(binding = MSSM_DEPTH_UNIT) uniform sampler2DArray $depths;\n"
    "layout(std430, binding = MSSM_BINDING) readonly buffer $view_block { mssm_view $views[]; };\n"
    "#define $log2 findMSB\n"
    "mssm_view $stored_view(int light)\n"
    "{\n"
    "    bool good = uint(light) < uint($views.length());\n"
    "    mssm_view v = $views[good ? light : 0];\n"
    "    if (!good) v.side = 0.0;\n"
    "    return v;\n"
    "}\n";
static const char mssm__glsl_unbound[] =
    "uniform isampler2DArray $table0, $table1;\n"
    "uniform sampler2DArray $depths;\n"
    "layout(std140) uniform $view_block { ivec4 $views[7 * MSSM_LIGHTS]; };\n"
    "#define $log2(i) ((mssm_bits(float(i)) >> 23) - 127)\n"
    "mssm_view $stored_view(int light)\n"
    "{\n"
    "    bool good = uint(light) < uint(MSSM_LIGHTS);\n"
    "    int at = good ? 7 * light : 0;\n"
    "    ivec4 last = $views[at + 5], flags = $views[at + 6];\n"
    "    vec4 a = intBitsToFloat($views[at]), b = intBitsToFloat($views[at + 1]), c = intBitsToFloat($views[at + 2]);\n"
    "    vec4 d = intBitsToFloat($views[at + 3]), k = intBitsToFloat($views[at + 4]), s = intBitsToFloat(last);\n"
    "    return mssm_view(float[16](a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.x, c.y, c.z, c.w, d.x, d.y, d.z, d.w),\n"
    "                     k.x, k.y, k.z, k.w, s.x, good ? s.y : 0.0, s.z, last.w, flags.x, flags.y);\n"
    "}\n";

// Shading: the tables as the estimators read them: inclusive sums, 0 left of the first texel.
static const char mssm__glsl_entry[] =
    "int $side = 1, $levels = 1; // of the light at hand: read once, not for every query\n"
    "mssm_moments6 mssm_query($map map, int moments, float x, float y, float half_x, float half_y)\n"
    "{\n"
    "    int level = mssm_level_of(2.0 * mssm_max(half_x, half_y), $levels);\n"
    "    float size = float(($side + (1 << level) - 1) >> level);\n"
    "    float scale = intBitsToFloat((127 - level) << 23);\n"
    "    mssm_strips sx = mssm_cut((x - half_x) * scale, (x + half_x) * scale, size);\n"
    "    mssm_strips sy = mssm_cut((y - half_y) * scale, (y + half_y) * scale, size);\n"
    "    float area = sx.whole * sy.whole;\n"
    "    float inverse = MSSM_INVERSE_SCALE / area;\n"
    "    float outside = (area - sx.known * sy.known) / area;\n"
    "    ivec4 x4 = ivec4(int(sx.edge[0]), int(sx.edge[1]), int(sx.edge[2]), int(sx.edge[3])) - 1;\n"
    "    ivec4 y4 = ivec4(int(sy.edge[0]), int(sy.edge[1]), int(sy.edge[2]), int(sy.edge[3])) - 1;\n"
    "    vec4 low = mssm_sum($table0, map.light, level, x4, y4, sx, sy) * inverse + outside;\n"
    "    vec4 high = vec4(0.0);\n"
    "#if MSSM_MOMENTS == 6\n"
    "    if (moments == 6) {\n"
    "        high = mssm_sum($table1, map.light, level, x4, y4, sx, sy) * inverse + outside;\n"
    "    }\n"
    "#endif\n"
    "    return mssm_moments6(float[6](low.x, low.y, low.z, low.w, high.x, high.y));\n"
    "}\n";

static const char mssm__glsl_called[] =
    "mssm_view $view_of(int light)\n"
    "{\n"
    "    mssm_view v = $stored_view(light);\n"
    "    $side = int(v.side);\n"
    "    $levels = v.levels;\n"
    "    return v;\n"
    "}\n"
    "// Visibility of a light from a world-space point: 1 where the whole light is seen. The normal is the\n"
    "// receiver's, of any length, and of the light what is above its horizon counts; zero: not known.\n"
    "float @(int light, vec3 world_position, vec3 normal)\n"
    "{\n"
    "    mssm_view v = $view_of(light);\n"
    "    vec3 p = world_position, n = normal;\n"
    "    if (v.side <= 0.0) return 1.0;\n"
    "    mssm_receiver r = mssm_receive(v, $chosen, p.x, p.y, p.z);\n"
    "    return mssm_estimate($map(light), v, $chosen, mssm_tangent(v, $chosen, r, n.x, n.y, n.z));\n"
    "}\n"
    "float @(int light, vec3 world_position)\n"
    "{\n"
    "    return @(light, world_position, vec3(0.0));\n"
    "}\n"
    "\n"
    "// The same from shadow-space x, y in [-1,1] and depth, for frusta of one's own.\n"
    "float @_at(int light, vec3 shadow)\n"
    "{\n"
    "    mssm_view v = $view_of(light);\n"
    "    if (v.side <= 0.0) return 1.0;\n"
    "    return mssm_estimate($map(light), v, $chosen,\n"
    "                         mssm_receive_at(v, $chosen, shadow.x, shadow.y, shadow.z));\n"
    "}\n"
    "float mssm_least($map map, float x, float y, float half_size, int which)\n"
    "{\n"
    "    int level = mssm_depth_level(half_size, max($log2($side - 1) + 1, 1));\n"
    "    float size = float(($side + (2 << level) - 1) >> (level + 1));\n"
    "    float scale = intBitsToFloat((126 - level) << 23);\n"
    "    mssm_span sx = mssm_cut_depths(x, half_size, scale, size);\n"
    "    mssm_span sy = mssm_cut_depths(y, half_size, scale, size);\n"
    "    ivec3 low = ivec3(int(sx.low), int(sy.low), map.light);\n"
    "    ivec2 high = max(ivec2(int(sx.high), int(sy.high)) - min(level, 1), low.xy);\n"
    "    float a = texelFetch($depths, low, level)[which];\n"
    "    float b = texelFetch($depths, ivec3(high.x, low.yz), level)[which];\n"
    "    float c = texelFetch($depths, ivec3(low.x, high.y, low.z), level)[which];\n"
    "    float d = texelFetch($depths, ivec3(high, low.z), level)[which];\n"
    "    return min(min(a, b), min(c, d));\n"
    "}\n";

// One triangle over the whole viewport, and where in it a fragment is.
static const char mssm__glsl_place[] =
    "layout(location = 0) out vec2 place;\n"
    "void main()\n"
    "{\n"
    "    place = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;\n"
    "    gl_Position = vec4(place * 2.0 - 1.0, 0.0, 1.0);\n"
    "}\n";

static const char mssm__glsl_show[] =
    "#ifdef MSSM_FILTERED\n"
    "layout(binding = MSSM_UNIT) uniform sampler2DArray map;\n"
    "#else\n"
    "layout(binding = MSSM_UNIT) uniform isampler2DArray sums;\n"
    "layout(binding = MSSM_NEXT_UNIT) uniform sampler2DArray depths;\n"
    "#endif\n"
    "layout(location = 0) uniform int show[3];  // light, what, side\n"
    "layout(location = 0) in vec2 place;\n"
    "layout(location = 0) out vec4 color;\n"
    "#ifndef MSSM_FILTERED\n"
    "int sum(ivec2 p)\n"
    "{\n"
    "    return p.x < 0 || p.y < 0 ? 0 : texelFetch(sums, ivec3(p, show[0]), 0).x;\n"
    "}\n"
    "#endif\n"
    "void main()\n"
    "{\n"
    "    ivec2 p = clamp(ivec2(place * float(show[2])), ivec2(0), ivec2(show[2] - 1));\n"
    "#ifdef MSSM_FILTERED\n"
    "    float z = 2.0 * texelFetch(map, ivec3(p, show[0]), 0).x - 1.0;\n"
    "#else\n"
    "    int value = sum(p) - sum(p - ivec2(1, 0)) - sum(p - ivec2(0, 1)) + sum(p - 1);\n"
    "    float z = float(value) / float(MSSM_SCALE), least = texelFetch(depths, ivec3(p / 2, show[0]), 0).x;\n"
    "    z = show[1] == 0 ? z : least;\n"
    "#endif\n"
    "    color = vec4(vec3(0.5 + 0.5 * z), 1.0);\n"
    "}\n";

#ifndef MSSM_NO_FILTERED
// Depth of one sample for translucent casters: the farthest, or an edge of an opaque caster would
// cut a rim out of the smoke before it. Depth blits take any, and are where drivers fail.
static const char mssm__glsl_copy[] =
    "layout(binding = MSSM_UNIT) uniform sampler2DMSArray front;\n"
    "layout(location = 0) uniform int samples;\n"
    "void main()\n"
    "{\n"
    "    float farthest = 0.0;\n"
    "    for (int s = 0; s < samples; s++) {\n"
    "        farthest = max(farthest, texelFetch(front, ivec3(gl_FragCoord.xy, 0), s).x);\n"
    "    }\n"
    "    gl_FragDepth = farthest;\n"
    "}\n";

// Rows, columns and halves as in mssm__filter; each level is rounded into the map, from floats.
static const char mssm__glsl_filter[] =
    "layout(local_size_x = 8, local_size_y = 8) in;\n"
    "layout(binding = 2, rgba32f) readonly uniform image2DArray source;\n"
    "layout(binding = 3, rgba32f) writeonly uniform image2DArray target;\n"
    "layout(binding = 0, rgba16) writeonly uniform image2DArray map0;\n"
    "layout(binding = 1, rg16) writeonly uniform image2DArray map1;\n"
    "// left, low, right, high, scale, layer of the map, side of the source\n"
    "layout(location = 0) uniform int job[7];\n"
    "void main()\n"
    "{\n"
    "    ivec2 p = ivec2(gl_GlobalInvocationID.xy);\n"
    "    if (any(greaterThanEqual(p, imageSize(map0).xy))) return;\n"
    "    ivec2 last = ivec2(job[6] - 1), at = min(p, last / job[4]) * job[4];\n"
    "    vec4 low = vec4(0.0), high = vec4(0.0);\n"
    "    float radius = float(job[2] + job[3]), falloff = 2.0 / max(radius * radius, 1.0);\n"
    "    for (int y = job[1]; y <= job[3]; y++) {\n"
    "        for (int x = job[0]; x <= job[2]; x++) {\n"
    "            ivec2 q = clamp(at + ivec2(x, y), ivec2(0), last);\n"
    "            float w = job[4] > 1 ? 1.0 : exp(-falloff * float(x * x + y * y));\n"
    "            low += w * vec4(imageLoad(source, ivec3(q, 0)).xyz, 1.0);\n"
    "            high += w * imageLoad(source, ivec3(q, 1));\n"
    "        }\n"
    "    }\n"
    "    high /= low.w;  // the sum of weights\n"
    "    low /= low.w;\n"
    "    imageStore(target, ivec3(p, 0), low);\n"
    "    imageStore(target, ivec3(p, 1), high);\n"
    "    imageStore(map0, ivec3(p, job[5]), vec4(low.xyz, high.x));\n"
    "#if MSSM_MOMENTS == 6\n"
    "    imageStore(map1, ivec3(p, job[5]), vec4(high.yz, 1.0, 1.0));\n"
    "#endif\n"
    "}\n";

// Taps of our own along the footprint's longer axis: llvmpipe hangs with anisotropic samplers.
static const char mssm__glsl_filtered_entry[] =
    "layout(binding = MSSM_UNIT) uniform sampler2DArray $map0;\n"
    "#if MSSM_MOMENTS == 6\n"
    "layout(binding = MSSM_NEXT_UNIT) uniform sampler2DArray $map1;\n"
    "#endif\n"
    "layout(std430, binding = MSSM_BINDING) readonly buffer $view_block { mssm_view $views[]; };\n"
    "vec2 $ddx = vec2(1.0), $ddy = vec2(1.0); // of the place in the map, in texels\n"
    "vec2 $axis(vec2 d, vec2 least, float most)\n"
    "{\n"
    "    float l = length(d);\n"
    "    return l > 1.0 ? d * (min(l, most) / l) : least;\n"
    "}\n"
    "mssm_moments6 $sample(int light, float x, float y)\n"
    "{\n"
    "    vec2 scale = 1.0 / vec2(textureSize($map0, 0).xy), at = vec2(x, y) * scale;\n"
    "    bool swap = length($ddx) < length($ddy);\n"
    "    vec2 wide = (swap ? $ddy : $ddx) * scale, slim = (swap ? $ddx : $ddy) * scale;\n"
    "    int taps = int(clamp(floor(length(wide) / length(slim) + 0.5), 1.0, float(MSSM_ANISOTROPY)));\n"
    "    vec4 low = vec4(0.0), high = vec4(0.0);\n"
    "    wide /= float(taps);\n"
    "    for (int i = 0; i < taps; i++) {\n"
    "        vec3 p = vec3(at + (float(i) + 0.5 - 0.5 * float(taps)) * wide, float(light));\n"
    "        low += (2.0 * textureGrad($map0, p, wide, slim) - 1.0) / float(taps);\n"
    "#if MSSM_MOMENTS == 6\n"
    "        high += (2.0 * textureGrad($map1, p, wide, slim) - 1.0) / float(taps);\n"
    "#endif\n"
    "    }\n"
    "    return mssm_moments6(float[6](low.x, low.y, low.z, low.w, high.x, high.y));\n"
    "}\n"
    "mssm_bounds @_bounds(int light, vec3 world_position, vec3 ddx, vec3 ddy)\n"
    "{\n"
    "    mssm_bounds lit = mssm_bounds(1.0, 1.0);\n"
    "    if (uint(light) >= uint($views.length())) return lit;\n"
    "    mssm_view v = $views[light];\n"
    "    if (v.side == 0.0) return lit;\n"
    "    vec3 p = world_position, px = p + ddx, py = p + ddy;\n"
    "    mssm_receiver r = mssm_receive(v, $chosen, p.x, p.y, p.z);\n"
    "    mssm_receiver rx = mssm_receive(v, $chosen, px.x, px.y, px.z);\n"
    "    mssm_receiver ry = mssm_receive(v, $chosen, py.x, py.y, py.z);\n"
    "    if (r.lit != 0 || mssm_beside(v, r) != 0) return lit;\n"
    "    $ddx = $axis(vec2(rx.x - r.x, rx.y - r.y), vec2(1.0, 0.0), v.side);\n"
    "    $ddy = $axis(vec2(ry.x - r.x, ry.y - r.y), vec2(0.0, 1.0), v.side);\n"
    "    float width = min(length($ddx), length($ddy));\n"
    "    mssm_moments6 t = $sample(light, r.x, r.y);\n"
    "    return mssm_bounds_under(v, $chosen, r, t, width + MSSM_BLUR, MSSM_LACK);\n"
    "}\n"
    "float @(int light, vec3 world_position, vec3 ddx, vec3 ddy)\n"
    "{\n"
    "    return @_bounds(light, world_position, ddx, ddy).upper;\n"
    "}\n";
#else
#define mssm__glsl_filter ""
#define mssm__glsl_copy ""
#endif

// Textures that depth is read from: first that of our own passes.
#define MSSM__TARGET(kind, sampler, fetch)                                         \
    MSSM__GL_TEXTURE_##kind, MSSM__GL_TEXTURE_BINDING_##kind, "GL_TEXTURE_" #kind, \
        "#define MSSM_SAMPLER " sampler "\n#define MSSM_FETCH(map, at, layer, s) " fetch ".x\n"
static const struct {
    mssm__glenum target, binding;
    const char *name, *text;
} mssm__targets[6] = {
    {MSSM__TARGET(2D_MULTISAMPLE_ARRAY, "sampler2DMSArray",
                  "texelFetch(map, ivec3(at, layer), s)")},
    {MSSM__TARGET(2D, "sampler2D", "texelFetch(map, at, 0)")},
    {MSSM__TARGET(2D_ARRAY, "sampler2DArray", "texelFetch(map, ivec3(at, layer), 0)")},
    {MSSM__TARGET(CUBE_MAP, "samplerCube",
                  "textureLod(map, cube_direction(layer, at, textureSize(map, 0).x), 0.0)")},
    {MSSM__TARGET(CUBE_MAP_ARRAY, "samplerCubeArray",
                  "textureLod(map, vec4(cube_direction((layer) % 6, at, textureSize(map, 0).x), "
                  "float((layer) / 6)), 0.0)")},
    {MSSM__TARGET(2D_MULTISAMPLE, "sampler2DMS", "texelFetch(map, at, s)")}};
#undef MSSM__TARGET

// Programs by their numbers. Those that take depth have the math and linear depth in front of this.
typedef struct mssm__program {
    const char *name, *option, *head, *body;
} mssm__program;
static const mssm__program mssm__programs[] = {
    {"mssm rows", "", mssm__glsl_tables, mssm__glsl_rows},
    {"mssm halve", "#define MSSM_HALVE\n", mssm__glsl_tables, mssm__glsl_rows},
    {"mssm columns", "", mssm__glsl_tables, mssm__glsl_columns},
    {"mssm least depth", "", "", mssm__glsl_least},
    {"mssm average", "#define MSSM_AVERAGE\n", mssm__glsl_drawn, mssm__glsl_resolve},
    {"mssm resolve", "", mssm__glsl_drawn, mssm__glsl_resolve},
    {"mssm filter", "", "", mssm__glsl_filter},
    {"mssm copy", "", "", mssm__glsl_copy},
    {"mssm store", "#define MSSM_STORE\n" MSSM__GLSL_CONSTANT(MSSM_EMPTY), "", mssm__glsl_resolve},
    {"mssm show", "", "", mssm__glsl_show},
    {"mssm given depth", "", mssm__glsl_given, mssm__glsl_resolve},
    {"mssm given depth", "#define MSSM_AVERAGE\n", mssm__glsl_given, mssm__glsl_resolve}};

// ---- Loader, log, programs ---- >>plumbing

static const mssm__program *mssm__program_of(int which)
{
    return mssm__programs + (which < MSSM__GIVEN ? which : MSSM__GIVEN + (which - MSSM__GIVEN) % 2);
}

static const char *mssm__program_name(int which)
{
    return mssm__program_of(which)->name;
}

// [plumbing begin], which `make glsl` copies into lightprobe.h under its own prefix

// Tells the log, where there is one, why a call fails; returns its result.
static mssm_result mssm__report(const mssm_gl *gl, mssm_result result, const char *format, ...)
{
    char line[256] = "mssm: ";
    const size_t start = strlen(line);
    va_list list;
    if (!gl->desc.log) return result;
    va_start(list, format);
    vsnprintf(line + start, sizeof line - start, format, list);
    va_end(list);
    gl->desc.log(gl->desc.user, line);
    return result;
}

static int mssm__get(const mssm_gl *gl, mssm__glenum name)
{
    int value[4] = {0}; // four: some drivers write more than one
    gl->f.GetIntegerv(name, value);
    return value[0];
}

// The first error since the last call. Bounded: a lost context reports one forever.
static mssm__glenum mssm__take_error(const mssm_gl *gl)
{
    const mssm__glenum first = gl->f.GetError();
    for (int i = 1; first && i < 16 && gl->f.GetError(); i++) continue;
    return first;
}

// What the caller has left would be taken for ours.
static void mssm__drop_errors(const mssm_gl *gl, const char *call)
{
    if (mssm__take_error(gl))
        mssm__report(gl, MSSM_ERROR_GL, "a GL error was pending before %s", call);
}

static mssm_result mssm__load(mssm_gl *gl)
{
    const char *missing = NULL;
#define MSSM__GL_LOAD(result, name, parameters)               \
    {                                                         \
        const mssm_gl_function f = gl->desc.load("gl" #name); \
        memcpy(&gl->f.name, &f, sizeof f);                    \
        if (!f && !missing) missing = "gl" #name;             \
    }
    MSSM__GL_FUNCTIONS(MSSM__GL_LOAD)
#undef MSSM__GL_LOAD
    if (gl->f.GetIntegerv && gl->f.GetString && gl->f.GetError) {
        const char *text = (const char *)gl->f.GetString(MSSM__GL_VERSION);
        const int major = mssm__get(gl, MSSM__GL_MAJOR_VERSION);
        const int old = major < 4 || (major == 4 && mssm__get(gl, MSSM__GL_MINOR_VERSION) < 5);
        if (!text) return mssm__report(gl, MSSM_ERROR_GL_VERSION, "no context is current");
        if (old || !strncmp(text, "OpenGL ES", 9))
            return mssm__report(gl, MSSM_ERROR_GL_VERSION,
                                "OpenGL 4.5 is needed, this context is %s", text);
    }
    if (!missing) return MSSM_OK;
    return mssm__report(gl, MSSM_ERROR_GL_VERSION,
                        "OpenGL 4.5 is needed (is a context current?), the loader does not find %s",
                        missing);
}

// Passes the whole log of a shader, or of the program, on.
static mssm_result mssm__report_build(const mssm_gl *gl, unsigned name, int program, int which)
{
    int length = 0;
    (program ? gl->f.GetProgramiv : gl->f.GetShaderiv)(name, MSSM__GL_INFO_LOG_LENGTH, &length);
    mssm__report(gl, MSSM_ERROR_GL, "cannot build %s", mssm__program_name(which));
    if (!gl->desc.log || length <= 1 || length > 1 << 20) return MSSM_ERROR_GL;
    char *text = (char *)MSSM_MALLOC((size_t)length + 1);
    if (!text) return MSSM_ERROR_GL;
    memset(text, 0, (size_t)length + 1);
    (program ? gl->f.GetProgramInfoLog : gl->f.GetShaderInfoLog)(name, length, NULL, text);
    gl->desc.log(gl->desc.user, text);
    MSSM_FREE(text);
    return MSSM_ERROR_GL;
}

static mssm_result mssm__add_shader(mssm_gl *gl, int which, mssm__glenum type,
                                    const char *const *text, int count)
{
    int good = 0;
    const unsigned shader = gl->f.CreateShader(type);
    if (!gl->program[which]) gl->program[which] = gl->f.CreateProgram();
    if (!shader || !gl->program[which]) {
        gl->f.DeleteShader(shader); // GL passes over 0
        return mssm__report(gl, MSSM_ERROR_GL, "no shader or program object for %s",
                            mssm__program_name(which));
    }
    gl->f.ShaderSource(shader, count, text, NULL);
    gl->f.CompileShader(shader);
    gl->f.GetShaderiv(shader, MSSM__GL_COMPILE_STATUS, &good);
    const mssm_result r = good ? MSSM_OK : mssm__report_build(gl, shader, 0, which);
    if (good) gl->f.AttachShader(gl->program[which], shader);
    gl->f.DeleteShader(shader);
    return r;
}

static mssm_result mssm__link(mssm_gl *gl, int which)
{
    const unsigned program = gl->program[which];
    int good = 0;
    gl->f.LinkProgram(program);
    gl->f.GetProgramiv(program, MSSM__GL_LINK_STATUS, &good);
    gl->f.ObjectLabel(MSSM__GL_PROGRAM, program, -1, mssm__program_name(which));
    return good ? MSSM_OK : mssm__report_build(gl, program, 1, which);
}

// A name to bind again; 0 where the object has been deleted since, perhaps in another context.
static unsigned mssm__living(int name, mssm__glboolean(MSSM__GLAPI *is)(unsigned))
{
    return name && is((unsigned)name) ? (unsigned)name : 0;
}

// GL does not take back a program that was deleted while in use, or whose last link failed.
static void mssm__use_again(const mssm_gl *gl, int program)
{
    int good = 0;
    const unsigned living = mssm__living(program, gl->f.IsProgram);
    if (living) gl->f.GetProgramiv(living, MSSM__GL_LINK_STATUS, &good);
    if (living && !good)
        mssm__report(gl, MSSM_OK, "program %d is in use no longer: its last link failed", program);
    gl->f.UseProgram(good ? living : 0);
}

// Puts the generic binding of storage buffers back.
static void mssm__bind_buffer_again(const mssm_gl *gl, int buffer)
{
    gl->f.BindBuffer(MSSM__GL_SHADER_STORAGE_BUFFER, mssm__living(buffer, gl->f.IsBuffer));
}

// A buffer. Mesa forgets the generic binding too when one with an indexed binding is deleted.
static void mssm__delete_buffer(const mssm_gl *gl, unsigned buffer)
{
    if (!buffer) return;
    const int generic = mssm__get(gl, MSSM__GL_SHADER_STORAGE_BUFFER_BINDING);
    gl->f.DeleteBuffers(1, &buffer); // which also unmaps it
    mssm__bind_buffer_again(gl, generic);
}

// [plumbing end]

static int mssm__in_range(const mssm_gl *gl, const char *name, int value, int low, int high)
{
    if (value >= low && value <= high) return 1;
    mssm__report(gl, MSSM_ERROR_ARGUMENT, "%s %d: %d to %d", name, value, low, high);
    return 0;
}

// Capabilities that passes switch: the first on, the second as the pass is, the third on, the rest
// off. Asking for one that a context does not have would be an error.
static void mssm__find_capabilities(mssm_gl *gl)
{
    static const mssm__glenum names[] = {
        MSSM__GL_DEPTH_TEST, MSSM__GL_CULL_FACE, MSSM__GL_MULTISAMPLE, MSSM__GL_STENCIL_TEST,
        MSSM__GL_RASTERIZER_DISCARD, MSSM__GL_DEPTH_CLAMP, MSSM__GL_SAMPLE_SHADING,
        MSSM__GL_POLYGON_OFFSET_FILL, MSSM__GL_SAMPLE_ALPHA_TO_COVERAGE, MSSM__GL_SAMPLE_COVERAGE,
        MSSM__GL_SAMPLE_MASK, MSSM__GL_COLOR_LOGIC_OP,
        // llvmpipe offsets filled faces by these, too
        MSSM__GL_POLYGON_OFFSET_LINE, MSSM__GL_POLYGON_OFFSET_POINT, MSSM__GL_ALPHA_TEST,
        MSSM__GL_POLYGON_STIPPLE};
    // Some drivers have a mask of 0 where nobody asked for a profile.
    gl->compatible = !(mssm__get(gl, MSSM__GL_CONTEXT_PROFILE_MASK) & 1);
    memcpy(gl->capability, names, sizeof names);
    gl->capabilities = gl->compatible ? 16 : 14; // the last two are of the compatibility profile
    for (unsigned i = 0; i < 8; i++)
        gl->capability[gl->capabilities++] = MSSM__GL_CLIP_DISTANCE0 + i;
    const int extensions = mssm__get(gl, MSSM__GL_NUM_EXTENSIONS);
    for (int i = 0; i < extensions && i < 2000; i++) {
        const char *name = (const char *)gl->f.GetStringi(MSSM__GL_EXTENSIONS, (unsigned)i);
        if (!name) break;
        if (strcmp(name, "GL_EXT_depth_bounds_test")) continue;
        gl->capability[gl->capabilities++] = MSSM__GL_DEPTH_BOUNDS_TEST;
        break;
    }
}

// Whether it has this of the textures.
static int mssm__has_texture(const mssm_gl *gl, int i)
{
    return i == 1 ? gl->desc.moments == 6 : mssm__tables[i].format[gl->filtered] != 0;
}

// Whether GLSL takes it, and what is made of it: gl_ and double underscores are its own.
static int mssm__is_name(const char *name)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789";
    const size_t length = strlen(name);
    return length > 0 && length <= 64 && strspn(name, letters) == length &&
           strcspn(name, letters + 52) > 0 && name[length - 1] != '_' && !strstr(name, "__") &&
           strncmp(name, "gl_", 3) != 0;
}

// Two texts of a shader that take the same name, binding or unit say so.
static void mssm__print_collisions(const mssm_gl *gl, char *to, size_t size)
{
    const int binding = gl->unbound ? -1 : gl->desc.first_buffer_binding;
    int at = snprintf(
        to, size,
        "#ifdef MSSM_NAME_@\n#error name: two mssm_gl declare @, one needs another mssm_gl_desc.name\n"
        "#endif\n#define MSSM_NAME_@\n#ifdef LIGHTPROBE_BINDING\n#if LIGHTPROBE_BINDING == %d\n"
        "#error first_buffer_binding of mssm.h is LIGHTPROBE_BINDING: change one of them\n"
        "#endif\n#endif\n",
        binding);
    for (int i = -1; i < 3 && !gl->unbound; i++) {
        const char *what = i < 0 ? "BINDING" : "UNIT",
                   *member = i < 0 ? "buffer_binding" : "texture_unit";
        const int number = i < 0 ? binding : gl->desc.first_texture_unit + i;
        if (i >= 0 && !mssm__has_texture(gl, i)) continue;
        at += snprintf(
            to + at, size - (size_t)at,
            "#ifdef MSSM_%s_%d\n#error first_%s: %d of @ is that of another mssm_gl above\n#endif\n"
            "#define MSSM_%s_%d\n",
            what, number, member, number, what, number);
    }
}

static void mssm__print_defines(const mssm_gl *gl, char *to, size_t size)
{
    const struct mssm_options o = mssm__options(&gl->desc.settings, gl->desc.moments);
    const char *const names[] = {"MOMENTS",   "SCALE",      gl->unbound ? "LIGHTS" : "UNIT",
                                 "NEXT_UNIT", "DEPTH_UNIT", "BINDING"};
    const int unit = gl->desc.first_texture_unit, third = gl->unbound ? gl->desc.lights : unit;
    const int values[] = {gl->desc.moments, MSSM_SCALE, third,
                          unit + 1,         unit + 2,   gl->desc.first_buffer_binding};
    const float numbers[] = {o.alpha4, o.alpha6, o.depth_bias, o.tolerance};
    int at = 0;
    for (int i = 0; i < (gl->unbound ? 3 : 6); i++) {
        at += snprintf(to + at, size - (size_t)at, "#undef MSSM_%s\n#define MSSM_%s %d\n", names[i],
                       names[i], values[i]);
    }
    at += snprintf(to + at, size - (size_t)at, "#define $chosen mssm_options(%d, %d", o.moments,
                   o.estimator);
    for (int i = 0; i < 4; i++) // by their bits: there are countries where printf has no point
        at += snprintf(to + at, size - (size_t)at, ", uintBitsToFloat(0x%08xu)",
                       (unsigned)mssm_bits(numbers[i]));
    at += snprintf(to + at, size - (size_t)at, ")\n");
#ifndef MSSM_NO_FILTERED
    if (!gl->filtered) return;
    snprintf(to + at, size - (size_t)at,
             "#undef MSSM_ANISOTROPY\n#define MSSM_ANISOTROPY %d\n#undef MSSM_BLUR\n"
             "#define MSSM_BLUR %d.0\n#undef MSSM_LACK\n"
             "#define MSSM_LACK uintBitsToFloat(0x%08xu)\n",
             gl->desc.anisotropy, gl->desc.radius > 0 ? 2 * gl->desc.radius : 0,
             (unsigned)mssm_bits(mssm__filter_lack(&gl->desc.filter)));
#endif
}

// Adds a text with the object's names; counts its characters where there is nothing to write to.
static size_t mssm__add_text(char *to, size_t at, const char *text, const char *name,
                             const char *others)
{
    for (; *text; text++) {
        const char *piece = *text == '@' ? name : *text == '$' ? others : text;
        size_t length = piece == text ? 1 : strlen(piece);
        if (to) memcpy(to + at, piece, length);
        at += length;
    }
    return at;
}

// The text for shading, if to is not NULL; its length.
static size_t mssm__print_shader(const mssm_gl *gl, char *to)
{
    const char *name = gl->desc.name;
    char collisions[1400], defines[700], others[80];
    if (name)
        snprintf(others, sizeof others, "mssm_%s_", name);
    else
        snprintf(others, sizeof others, gl->filtered ? "mssm_filtered_" : "mssm_");
    mssm__print_collisions(gl, collisions, sizeof collisions);
    if (!name && gl->filtered)
        strcat(collisions, "#define mssm_filtered_bounds mssm_filtered_visibility_bounds\n");
    if (!name) name = gl->filtered ? "mssm_filtered_visibility" : "mssm_visibility";
    mssm__print_defines(gl, defines, sizeof defines);
    // Before and after what the estimators share, three at the end.
    const char *const soft[] = {mssm__glsl_depths, mssm__glsl_strips,
                                gl->unbound ? mssm__glsl_unbound : mssm__glsl_bound,
                                mssm__glsl_entry, mssm__glsl_called};
    const char *const *own = soft;
#ifndef MSSM_NO_FILTERED
    const char *const filtered[] = {"#define MSSM_NO_ESTIMATE\n", mssm__glsl_filtered(),
                                    mssm__glsl_filtered_entry, "#undef MSSM_NO_ESTIMATE\n", ""};
    if (gl->filtered) own = filtered;
#endif
    const char *const needs = gl->unbound ? mssm__glsl_needs_less : mssm__glsl_needs;
    const char *const parts[] = {
        needs,   mssm_glsl_math(), collisions, own[0], mssm_glsl_shading(), own[1],
        defines, own[2],           own[3],     own[4], mssm__glsl_end};
    size_t length = 0;
    for (int i = 0; i < (int)(sizeof parts / sizeof *parts); i++)
        length = mssm__add_text(to, length, parts[i], name, others);
    if (to) to[length] = 0;
    return length;
}

// Of a compute shader, or of a triangle's fragments, which takes a vertex array without attributes.
static mssm_result mssm__make_program(mssm_gl *gl, int which)
{
    const mssm__program *p = mssm__program_of(which);
    const int triangle = which == MSSM__COPY || which == MSSM__SHOW;
    const int given = which - MSSM__GIVEN;
    const int depth = p->body == mssm__glsl_resolve;
    const char *const math = depth ? mssm_glsl_math() : "";
    const char *const linear = depth ? mssm__glsl_linear_depth : "";
    const char *const target = given < 0 ? "" : mssm__targets[given / 2].text;
    char defines[300];
    const char *const all[] = {
        mssm__glsl_version, defines, p->option, target, math, linear, p->head, p->body};
    const char *const vertex[] = {mssm__glsl_version, mssm__glsl_place};
    if (gl->program[which]) return MSSM_OK;
    if (triangle && !gl->array) {
        gl->f.CreateVertexArrays(1, &gl->array);
        if (!gl->array) return mssm__report(gl, MSSM_ERROR_GL, "no vertex array object");
        gl->f.ObjectLabel(MSSM__GL_VERTEX_ARRAY, gl->array, -1, "mssm triangle");
    }
    snprintf(defines, sizeof defines,
             "#define MSSM_MOMENTS %d\n#define MSSM_UNIT %d\n#define MSSM_NEXT_UNIT %d\n"
             "#define MSSM_BATCH %d\n#define MSSM_LAYERS %d\n#define MSSM_GIVEN %d\n"
             "#define MSSM_SCALE %d\n%s",
             gl->desc.moments, gl->desc.first_texture_unit, gl->desc.first_texture_unit + 1,
             (int)MSSM__BATCH, (int)MSSM__LAYERS, (int)MSSM__GIVEN_UNIFORM, MSSM_SCALE,
             gl->filtered ? "#define MSSM_FILTERED\n" : "");
    const mssm__glenum type = triangle ? MSSM__GL_FRAGMENT_SHADER : MSSM__GL_COMPUTE_SHADER;
    mssm_result r = mssm__add_shader(gl, which, type, all, 8);
    if (!r && triangle) r = mssm__add_shader(gl, which, MSSM__GL_VERTEX_SHADER, vertex, 2);
    if (!r) r = mssm__link(gl, which);
    if (!r) return MSSM_OK;
    gl->f.DeleteProgram(gl->program[which]);
    gl->program[which] = 0;
    return r;
}

static mssm_result mssm__build_programs(mssm_gl *gl)
{
    const int last = gl->filtered ? MSSM__COPY : MSSM__RESOLVE;
    mssm_result r = MSSM_OK;
    for (int i = gl->filtered ? MSSM__RESOLVE : 0; i <= last && !r; i++)
        r = mssm__make_program(gl, i);
    if (r) return r;
    gl->shader = (char *)MSSM_MALLOC(mssm__print_shader(gl, NULL) + 1);
    if (!gl->shader) return mssm__report(gl, MSSM_ERROR_MEMORY, "no memory");
    mssm__print_shader(gl, gl->shader);
    return MSSM_OK;
}

static void mssm__delete_storage(mssm_gl *gl)
{
    const mssm__gl_functions *f = &gl->f;
    f->DeleteFramebuffers(MSSM__FRAMEBUFFERS, gl->framebuffer); // GL passes over names that are 0
    f->DeleteTextures(1, &gl->depth);
    f->DeleteTextures(MSSM__TABLES, gl->table);
    mssm__delete_buffer(gl, gl->views);
    MSSM_FREE(gl->lights);
    MSSM_FREE(gl->view);
}

// Of the texture that is bound.
static int mssm__ask_texture(const mssm_gl *gl, mssm__glenum target, int level, mssm__glenum what)
{
    int value = 0; // a lost context writes nothing
    gl->f.GetTexLevelParameteriv(target, level, what, &value);
    return value;
}

static int mssm__is_complete(const mssm_gl *gl, unsigned framebuffer)
{
    return gl->f.CheckNamedFramebufferStatus(framebuffer, MSSM__GL_DRAW_FRAMEBUFFER) ==
           MSSM__GL_FRAMEBUFFER_COMPLETE;
}

static mssm_result mssm__create_depth(mssm_gl *gl)
{
    const mssm__glenum target = MSSM__GL_TEXTURE_2D_MULTISAMPLE_ARRAY;
    unsigned *framebuffer = &gl->framebuffer[0];
    gl->f.CreateTextures(target, 1, &gl->depth);
    gl->f.CreateFramebuffers(1, framebuffer);
    if (!gl->depth || !*framebuffer) return MSSM_ERROR_GL;
    gl->f.TextureStorage3DMultisample(gl->depth, gl->desc.samples, MSSM__GL_DEPTH_COMPONENT32F,
                                      gl->desc.side, gl->desc.side, gl->layers, 1);
    const int bound = mssm__get(gl, MSSM__GL_TEXTURE_BINDING_2D_MULTISAMPLE_ARRAY);
    gl->f.BindTexture(target, gl->depth);
    gl->samples = mssm__ask_texture(gl, target, 0, MSSM__GL_TEXTURE_SAMPLES);
    gl->f.BindTexture(target, mssm__living(bound, gl->f.IsTexture));
    gl->f.ObjectLabel(MSSM__GL_TEXTURE, gl->depth, -1, "mssm depth");
    gl->f.NamedFramebufferTextureLayer(*framebuffer, MSSM__GL_DEPTH_ATTACHMENT, gl->depth, 0, 0);
    gl->f.NamedFramebufferDrawBuffer(*framebuffer, 0);
    gl->f.NamedFramebufferReadBuffer(*framebuffer, 0);
    gl->f.ObjectLabel(MSSM__GL_FRAMEBUFFER, *framebuffer, -1, "mssm depth");
    return mssm__is_complete(gl, *framebuffer) ? MSSM_OK : MSSM_ERROR_GL;
}

// Mip levels, side and layers of one of the 2D arrays; 0: it has none.
static int mssm__array_size(const mssm_gl *gl, int i, int *side, int *layers)
{
    // Least depths begin with half the side, and halve without rest.
    const int least = i == MSSM__LEAST_DEPTHS;
    *side = least ? 1 << (gl->depth_levels - 1) : gl->padded;
    *layers = i < MSSM__WORK ? gl->desc.lights : i == MSSM__FARTHEST ? 1 : 2;
    if (!mssm__has_texture(gl, i)) return 0;
    return least ? gl->depth_levels : i > MSSM__WORK ? 1 : gl->levels;
}

static mssm_result mssm__create_arrays(mssm_gl *gl)
{
    const mssm__gl_functions *f = &gl->f;
    for (int i = 0; i < MSSM__TABLES; i++) {
        int side, layers;
        const int levels = mssm__array_size(gl, i, &side, &layers);
        const int smooth = gl->filtered && i < MSSM__LEAST_DEPTHS;
        if (!levels) continue;
        f->CreateTextures(MSSM__GL_TEXTURE_2D_ARRAY, 1, &gl->table[i]);
        if (!gl->table[i]) return MSSM_ERROR_GL;
        const unsigned texture = gl->table[i];
        f->TextureStorage3D(texture, levels, mssm__tables[i].format[gl->filtered], side, side,
                            layers);
        // Integer textures are complete with the nearest texel only.
        f->TextureParameteri(texture, MSSM__GL_TEXTURE_MIN_FILTER,
                             smooth ? MSSM__GL_LINEAR_MIPMAP_LINEAR
                                    : MSSM__GL_NEAREST_MIPMAP_NEAREST);
        f->TextureParameteri(texture, MSSM__GL_TEXTURE_MAG_FILTER,
                             smooth ? MSSM__GL_LINEAR : MSSM__GL_NEAREST);
        // Beyond the edges of filtered maps the outermost texels go on.
        if (smooth) f->TextureParameteri(texture, MSSM__GL_TEXTURE_WRAP_S, MSSM__GL_CLAMP_TO_EDGE);
        if (smooth) f->TextureParameteri(texture, MSSM__GL_TEXTURE_WRAP_T, MSSM__GL_CLAMP_TO_EDGE);
        f->ObjectLabel(MSSM__GL_TEXTURE, texture, -1, mssm__tables[i].label);
    }
    return MSSM_OK;
}

static mssm_result mssm__check_limits(mssm_gl *gl)
{
    const mssm_gl_desc *d = &gl->desc;
    const int units = mssm__get(gl, MSSM__GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS);
    const int bindings = mssm__get(gl, MSSM__GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS);
    const int layers = mssm__get(gl, MSSM__GL_MAX_ARRAY_TEXTURE_LAYERS);
    const int texels = mssm__get(gl, MSSM__GL_MAX_TEXTURE_SIZE);
    const int samples = mssm__get(gl, MSSM__GL_MAX_DEPTH_TEXTURE_SAMPLES);
    const int own = gl->filtered ? 2 : 3;
    if (!mssm__in_range(gl, "first_texture_unit", d->first_texture_unit, 0,
                        units < own ? -1 : units - own) ||
        !mssm__in_range(gl, "first_buffer_binding", d->first_buffer_binding, 0,
                        bindings < 1 ? -1 : bindings - 1) ||
        !mssm__in_range(gl, "this driver: lights", d->lights, 1, layers)) {
        return MSSM_ERROR_ARGUMENT;
    }
    if (!mssm__in_range(gl, "this driver: side", gl->padded, 1, texels) ||
        !mssm__in_range(gl, "this driver: samples", d->samples, 1, samples)) {
        return MSSM_ERROR_GL;
    }
    return MSSM_OK;
}

static mssm_result mssm__create_views(mssm_gl *gl)
{
    const int generic = mssm__get(gl, MSSM__GL_SHADER_STORAGE_BUFFER_BINDING);
    gl->f.CreateBuffers(1, &gl->views);
    if (!gl->views) return MSSM_ERROR_GL;
    gl->f.BindBuffer(MSSM__GL_SHADER_STORAGE_BUFFER, gl->views);
    gl->f.BufferStorage(MSSM__GL_SHADER_STORAGE_BUFFER,
                        (ptrdiff_t)((size_t)gl->desc.lights * sizeof *gl->view), gl->view,
                        MSSM__GL_DYNAMIC_STORAGE_BIT);
    mssm__bind_buffer_again(gl, generic);
    gl->f.ObjectLabel(MSSM__GL_BUFFER, gl->views, -1, "mssm lights");
    return MSSM_OK;
}

static mssm_result mssm__create_storage(mssm_gl *gl)
{
    const size_t count = (size_t)gl->desc.lights;
    gl->lights = (mssm__gl_light *)MSSM_MALLOC(count * sizeof *gl->lights);
    gl->view = (mssm_view *)MSSM_MALLOC(count * sizeof *gl->view);
    if (!gl->lights || !gl->view) return mssm__report(gl, MSSM_ERROR_MEMORY, "no memory");
    memset(gl->lights, 0, count * sizeof *gl->lights);
    memset(gl->view, 0, count * sizeof *gl->view);
    mssm_result r = mssm__create_depth(gl);
    if (!r) r = mssm__create_arrays(gl);
    if (!r) r = mssm__create_views(gl);
    if (!r && gl->filtered) r = mssm__filtered_targets(gl);
    const mssm__glenum error = mssm__take_error(gl);
    if (error || r) {
        return mssm__report(gl, MSSM_ERROR_GL, "no storage for %.1f MiB of moment maps: %s",
                            (double)mssm_gl_bytes(&gl->desc) / 1048576,
                            error == MSSM__GL_OUT_OF_MEMORY ? "out of memory"
                                                            : "the driver refuses it");
    }
    gl->drawing = gl->front_of = gl->ready = gl->last_changed = -1;
    gl->used = gl->stale = 0;
    return MSSM_OK;
}

// ---- State that is put back ---- >>state

// Whether a call comes at a wrong time; under transform feedback GL allows no other program.
static mssm_result mssm__check_order(const mssm_gl *gl, int wrong, const char *call,
                                     const char *why)
{
    if (wrong) return mssm__report(gl, MSSM_ERROR_ORDER, "%s %s", call, why);
    if (gl->framing || !mssm__get(gl, MSSM__GL_TRANSFORM_FEEDBACK_ACTIVE) ||
        mssm__get(gl, MSSM__GL_TRANSFORM_FEEDBACK_PAUSED)) {
        return MSSM_OK;
    }
    return mssm__report(gl, MSSM_ERROR_ORDER,
                        "transform feedback must be paused or ended before %s", call);
}

static void mssm__activate(const mssm_gl *gl, int unit)
{
    gl->f.ActiveTexture((mssm__glenum)(MSSM__GL_TEXTURE0 + gl->desc.first_texture_unit + unit));
}

// Leaves another unit active.
static void mssm__save_target(mssm_gl *gl, int kind)
{
    for (int i = 0; i < 2; i++) {
        mssm__activate(gl, i);
        gl->bindings.texture[i][kind] = mssm__get(gl, mssm__targets[kind].binding);
    }
}

// Before the first texture of that kind is bound. From then on it is saved with the others.
static void mssm__displace(mssm_gl *gl, int kind)
{
    if (gl->targets >> kind & 1) return;
    gl->targets |= 1 << kind;
    mssm__save_target(gl, kind);
}

static void mssm__save_bindings(mssm_gl *gl)
{
    mssm__gl_bindings *b = &gl->bindings;
    static const mssm__glenum names[6] = {
        MSSM__GL_IMAGE_BINDING_NAME,  MSSM__GL_IMAGE_BINDING_LEVEL,  MSSM__GL_IMAGE_BINDING_LAYERED,
        MSSM__GL_IMAGE_BINDING_LAYER, MSSM__GL_IMAGE_BINDING_ACCESS, MSSM__GL_IMAGE_BINDING_FORMAT};
    if (gl->framing) return;
    b->program = mssm__get(gl, MSSM__GL_CURRENT_PROGRAM);
    b->array = mssm__get(gl, MSSM__GL_VERTEX_ARRAY_BINDING);
    b->active = mssm__get(gl, MSSM__GL_ACTIVE_TEXTURE);
    b->buffer = mssm__get(gl, MSSM__GL_SHADER_STORAGE_BUFFER_BINDING);
    for (int i = 0; i < 2; i++) {
        mssm__activate(gl, i);
        b->sampler[i] = mssm__get(gl, MSSM__GL_SAMPLER_BINDING);
    }
    for (int kind = 0; kind < 6; kind++) {
        if (gl->targets >> kind & 1) mssm__save_target(gl, kind);
    }
    gl->f.ActiveTexture((mssm__glenum)b->active);
    for (unsigned i = 0; i < 4; i++) {
        for (int k = 0; k < 6; k++) gl->f.GetIntegeri_v(names[k], i, &b->image[i][k]);
    }
}

static void mssm__restore_bindings(const mssm_gl *gl)
{
    const mssm__gl_bindings *b = &gl->bindings;
    if (gl->framing) {
        gl->f.UseProgram(0); // ours would be in the way of a program pipeline
        return;
    }
    for (int i = 0; i < 2; i++) {
        mssm__activate(gl, i);
        for (int k = 0; k < 6; k++) {
            if (!(gl->targets >> k & 1)) continue;
            gl->f.BindTexture(mssm__targets[k].target,
                              mssm__living(b->texture[i][k], gl->f.IsTexture));
        }
        gl->f.BindSampler((unsigned)(gl->desc.first_texture_unit + i),
                          mssm__living(b->sampler[i], gl->f.IsSampler));
    }
    gl->f.ActiveTexture((mssm__glenum)b->active);
    for (unsigned i = 0; i < 4; i++) {
        const int *m = b->image[i];
        gl->f.BindImageTexture(i, mssm__living(m[0], gl->f.IsTexture), m[1], (mssm__glboolean)m[2],
                               m[3], (mssm__glenum)m[4], (mssm__glenum)m[5]);
    }
    mssm__bind_buffer_again(gl, b->buffer);
    gl->f.BindVertexArray(mssm__living(b->array, gl->f.IsVertexArray));
    mssm__use_again(gl, b->program);
}

// The sampler also where it is 0: with another integer textures are incomplete. Unit stays active.
static void mssm__bind_texture(const mssm_gl *gl, int unit, mssm__glenum target, unsigned texture,
                               unsigned sampler)
{
    mssm__activate(gl, unit);
    gl->f.BindTexture(target, texture);
    gl->f.BindSampler((unsigned)(gl->desc.first_texture_unit + unit), sampler);
}

// A level of one of the tables, for kernels; none where there is no such table.
static void mssm__bind_image(const mssm_gl *gl, int unit, int table, int level)
{
    gl->f.BindImageTexture((unsigned)unit, gl->table[table], level, 1, 0, MSSM__GL_READ_WRITE,
                           mssm__tables[table].format[gl->filtered]);
}

static void mssm__bind_level(const mssm_gl *gl, int first_unit, int level)
{
    mssm__bind_image(gl, first_unit, 0, level);
    if (gl->table[1]) mssm__bind_image(gl, first_unit + 1, 1, level);
}

// ---- Passes and calls ---- >>passes

// Depth that is bound, of some lights, as moments into their maps, or the work of filtered ones.
static void mssm__take_depth(mssm_gl *gl, unsigned program, int count, const int *job, int numbers)
{
    // All of the least depths too, which are filled up to a power of two.
    const unsigned all = 1u << gl->depth_levels, padded = (unsigned)gl->padded;
    const unsigned side = padded > all ? padded : all;
    gl->f.ProgramUniform1iv(program, 0, numbers, job);
    gl->f.UseProgram(program);
    if (gl->filtered) {
        mssm__bind_image(gl, 0, MSSM__WORK, 0);
    } else {
        mssm__bind_level(gl, 0, 0);
        mssm__bind_image(gl, 2, MSSM__LEAST_DEPTHS, 0);
    }
    // After shading, mssm_gl_set_moments, or an earlier resolve; what follows has the build's.
    (gl->f.MemoryBarrier)(MSSM__GL_BARRIERS);
    gl->f.DispatchCompute((side + 31) / 32, (side + 1) / 2, (unsigned)count);
    if (gl->filtered) (gl->f.MemoryBarrier)(MSSM__GL_ALL_BARRIERS);
}

// Depth of all passes that wait: of lights with front faces only, then of those with back faces.
static void mssm__resolve(mssm_gl *gl)
{
    if (!gl->used) return;
    mssm__save_bindings(gl);
    mssm__bind_texture(gl, 0, mssm__targets[0].target, gl->depth, 0);
    for (int average = 0; average < 2; average++) {
        int job[2 + 5 * MSSM__LAYERS] = {gl->samples, gl->desc.side}, count = 0;
        for (int i = 0; i < gl->used; i++) {
            const int index = gl->waiting[i];
            if (index < 0 || (gl->lights[index].averaged && !gl->filtered) != average) continue;
            const mssm_light *light = &gl->lights[index].drawn;
            const int one[5] = {index, i, light->perspective, mssm_bits(light->z_near),
                                mssm_bits(light->z_far)};
            memcpy(job + 2 + 5 * count++, one, sizeof one);
        }
        const unsigned program = gl->program[average ? MSSM__AVERAGE : MSSM__RESOLVE];
        if (count) mssm__take_depth(gl, program, count, job, 2 + 5 * count);
    }
    mssm__restore_bindings(gl);
    gl->used = 0;
}

// Before a light gets other depth: what waits of it is void.
static void mssm__forget(mssm_gl *gl, int index)
{
    for (int i = 0; i < gl->used; i++) {
        if (gl->waiting[i] == index) gl->waiting[i] = -1;
    }
    gl->front_of = -1;
}

static void mssm__change(mssm_gl *gl, int index)
{
    gl->stale = gl->lights[index].changed = 1;
    if (gl->last_changed < 0 || index < gl->first_changed) gl->first_changed = index;
    if (index > gl->last_changed) gl->last_changed = index;
}

// The light's map is new, its tables are not. Of filtered maps one is in work.
static void mssm__filled(mssm_gl *gl, int index, int averaged)
{
    mssm__gl_light *light = &gl->lights[index];
    light->drawn = light->light;
    if (gl->filtered) {
        gl->ready = index;
        gl->stale = 1;
        return;
    }
    light->averaged = averaged;
    light->filled = 1;
    light->built = 0;
    mssm__change(gl, index);
}

static void mssm__save_state(mssm_gl *gl)
{
    mssm__gl_state *s = &gl->saved;
    s->framebuffer = mssm__get(gl, MSSM__GL_DRAW_FRAMEBUFFER_BINDING);
    s->depth_func = mssm__get(gl, MSSM__GL_DEPTH_FUNC);
    s->depth_mask = mssm__get(gl, MSSM__GL_DEPTH_WRITEMASK);
    s->cull_mode = mssm__get(gl, MSSM__GL_CULL_FACE_MODE);
    s->clip_origin = mssm__get(gl, MSSM__GL_CLIP_ORIGIN);
    s->clip_depth = mssm__get(gl, MSSM__GL_CLIP_DEPTH_MODE);
    gl->f.GetIntegerv(MSSM__GL_POLYGON_MODE, s->polygon_mode);
    for (int i = 0; i < gl->capabilities; i++) s->enabled[i] = gl->f.IsEnabled(gl->capability[i]);
    s->scissor = gl->f.IsEnabledi(MSSM__GL_SCISSOR_TEST, 0);
    for (unsigned i = 0; i < 2; i++) gl->f.GetBooleani_v(MSSM__GL_COLOR_WRITEMASK, i, s->mask[i]);
    gl->f.GetFloati_v(MSSM__GL_VIEWPORT, 0, s->viewport);
    gl->f.GetDoublei_v(MSSM__GL_DEPTH_RANGE, 0, s->depth_range);
}

// Within a frame only what drawing casters is likely to change.
static void mssm__set_state(const mssm_gl *gl, const mssm__gl_state *s)
{
    const int one_mode = !gl->compatible || s->polygon_mode[0] == s->polygon_mode[1];
    gl->f.BindFramebuffer(MSSM__GL_DRAW_FRAMEBUFFER, (unsigned)s->framebuffer);
    gl->f.DepthFunc((mssm__glenum)s->depth_func);
    gl->f.DepthMask((mssm__glboolean)s->depth_mask);
    gl->f.CullFace((mssm__glenum)s->cull_mode);
    for (int i = 0; i < (gl->framing ? 2 : gl->capabilities); i++)
        (s->enabled[i] ? gl->f.Enable : gl->f.Disable)(gl->capability[i]);
    (s->scissor ? gl->f.Enablei : gl->f.Disablei)(MSSM__GL_SCISSOR_TEST, 0);
    gl->f.ViewportIndexedf(0, s->viewport[0], s->viewport[1], s->viewport[2], s->viewport[3]);
    if (gl->framing) return;
    gl->f.ClipControl((mssm__glenum)s->clip_origin, (mssm__glenum)s->clip_depth);
    gl->f.PolygonMode(one_mode ? MSSM__GL_FRONT_AND_BACK : MSSM__GL_FRONT,
                      (mssm__glenum)s->polygon_mode[0]);
    if (!one_mode) gl->f.PolygonMode(MSSM__GL_BACK, (mssm__glenum)s->polygon_mode[1]);
    for (unsigned i = 0; i < 2; i++)
        gl->f.ColorMaski(i, s->mask[i][0], s->mask[i][1], s->mask[i][2], s->mask[i][3]);
    gl->f.DepthRangeIndexed(0, s->depth_range[0], s->depth_range[1]);
}

static void mssm__restore_state(mssm_gl *gl)
{
    mssm__gl_state *s = &gl->saved;
    if (gl->framing) return;
    s->framebuffer = (int)mssm__living(s->framebuffer, gl->f.IsFramebuffer);
    mssm__set_state(gl, s);
}

static void mssm__make_view(const mssm_gl *gl, mssm__gl_light *l, mssm_view *v)
{
    memset(v, 0, sizeof *v); // a map without texels: all is lit
    l->changed = 0;
    l->widest = 0;
    if (!l->filled || !(l->light.z_far > l->light.z_near)) return;
    mssm_view made =
        mssm__view(&l->light, &gl->desc.settings, gl->desc.side, l->built, l->averaged);
    // For receivers down to depth 17, eight times as deep as all casters; others get the widest.
    const float kernel = mssm_max(made.kernel_u, made.kernel_v);
    l->widest = 2.0f * kernel * (mssm_blur_depth(made, 17.0f) - mssm_blur_depth(made, -1.0f));
    if (l->built == 0) return; // drawn, but without tables
    const float limit = 0.5f * MSSM_KERNEL * (float)(1 << (l->built - 1));
    if (l->built < gl->levels) made.max_half = mssm_min(limit, made.max_half);
    *v = made;
}

// Views of the lights that have changed; returns the levels that the widest of all kernels needs.
static int mssm__make_views(mssm_gl *gl)
{
    float widest = 0;
    for (int i = 0; i < gl->desc.lights; i++) {
        if (gl->lights[i].changed) mssm__make_view(gl, &gl->lights[i], &gl->view[i]);
        widest = gl->lights[i].widest > widest ? gl->lights[i].widest : widest;
    }
    return 1 + mssm_level_of(widest, gl->levels);
}

// From the first to the last that has changed. Leaves the generic binding to the buffer.
static void mssm__upload_views(mssm_gl *gl)
{
    const int first = gl->first_changed, count = gl->last_changed - first + 1;
    if (gl->last_changed < 0) return;
    mssm__make_views(gl);
    gl->f.BindBuffer(MSSM__GL_SHADER_STORAGE_BUFFER, gl->views);
    gl->f.BufferSubData(MSSM__GL_SHADER_STORAGE_BUFFER,
                        (ptrdiff_t)((size_t)first * sizeof *gl->view),
                        (ptrdiff_t)((size_t)count * sizeof *gl->view), gl->view + first);
    gl->last_changed = -1;
}

// Least depths of coarser levels, three at a time; any beyond the last are written to it before it.
static void mssm__build_depths(mssm_gl *gl, int count)
{
    gl->f.UseProgram(gl->program[MSSM__LEAST]);
    for (int level = 0; level + 1 < gl->depth_levels; level += 3) {
        const unsigned size = 1u << (gl->depth_levels - level - 2);
        for (int i = 0; i < 4; i++) {
            const int at = level + i < gl->depth_levels ? level + i : level;
            gl->f.BindImageTexture((unsigned)i, at > level || !i ? gl->table[2] : 0, at, 1, 0,
                                   MSSM__GL_READ_WRITE, MSSM__GL_RG32F);
        }
        gl->f.ProgramUniform1i(gl->program[MSSM__LEAST], MSSM__BATCH, level > 0 ? 2 : 1);
        gl->f.DispatchCompute((size + 7) / 8, (size + 7) / 8, (unsigned)count);
        (gl->f.MemoryBarrier)(MSSM__GL_BARRIERS);
    }
}

static void mssm__build_batch(mssm_gl *gl, const int *layers, int count, int first, int levels)
{
    for (int i = MSSM__ROWS; i <= MSSM__LEAST; i++)
        gl->f.ProgramUniform1iv(gl->program[i], 0, count, layers);
    if (first == 0) mssm__build_depths(gl, count);
    for (int level = first; level < levels; level++) {
        const unsigned size = (unsigned)(gl->padded >> level);
        unsigned threads = 1; // of a row, as the shader counts them
        while (threads < 64 && 8 * threads < size) threads *= 2;
        mssm__bind_level(gl, 0, level);
        if (level > 0) {
            mssm__bind_level(gl, 2, level - 1);
            const int grain = (1 << (level - 1)) - 1;
            gl->f.ProgramUniform1i(gl->program[MSSM__HALVE], MSSM__BATCH,
                                   (gl->desc.side + grain) >> (level - 1));
        }
        gl->f.UseProgram(gl->program[level > 0 ? MSSM__HALVE : MSSM__ROWS]);
        gl->f.DispatchCompute(1, (size * threads + 63) / 64, (unsigned)count);
        (gl->f.MemoryBarrier)(MSSM__GL_BARRIERS);
        gl->f.UseProgram(gl->program[MSSM__COLUMNS]);
        gl->f.DispatchCompute((size + 63) / 64, 1, (unsigned)count);
        (gl->f.MemoryBarrier)(MSSM__GL_BARRIERS);
    }
}

static void mssm__find_sizes(mssm_gl *gl)
{
    const mssm_gl_desc *d = &gl->desc;
    const int64_t bytes = (int64_t)4 * d->samples * d->side * d->side; // of a layer
    int layers = (int)(MSSM__TARGET_BYTES / bytes);
    layers = layers < (int)MSSM__LAYERS ? layers : (int)MSSM__LAYERS;
    layers = layers > d->lights ? d->lights + 1 : layers;
    gl->layers = gl->filtered ? 1 : layers > 2 ? layers : 2;
    gl->levels = mssm__levels(d->side, (int)MSSM_KERNEL);
    gl->depth_levels = mssm__levels((d->side + 1) / 2, 1);
    gl->padded = mssm__padded(d->side, gl->levels);
}

// Defaults and sizes filled in, or MSSM_ERROR_ARGUMENT.
static mssm_result mssm__check_desc(mssm_gl *gl)
{
    mssm_gl_desc *d = &gl->desc;
#ifndef MSSM_NO_FILTERED
    gl->filtered = d->filtered != 0;
#endif
    if (d->name && !mssm__is_name(d->name)) {
        return mssm__report(
            gl, MSSM_ERROR_ARGUMENT,
            "name %.64s: up to 64 letters, digits and single _, from a letter on, not gl_",
            d->name);
    }
    if (d->lights == 0) d->lights = 1;
    if (d->side == 0) d->side = gl->filtered ? 1024 : 256;
    if (d->samples == 0) d->samples = 4;
    if (d->moments == 0) d->moments = gl->filtered ? 4 : 6;
    // Among those that every driver has, and that renderers take last.
    if (d->first_texture_unit == 0) d->first_texture_unit = gl->filtered ? 83 : 80;
    if (d->first_buffer_binding == 0) d->first_buffer_binding = gl->filtered ? 6 : 7;
    if (!mssm__in_range(gl, "lights", d->lights, 1, gl->unbound ? 585 : INT32_MAX) ||
        !mssm__in_range(gl, "side", d->side, 1, MSSM__SIDE) ||
        !mssm__in_range(gl, "samples", d->samples, 1, 64) ||
        !mssm__in_range(gl, "moments", d->moments, 4, 6)) {
        return MSSM_ERROR_ARGUMENT;
    }
#ifndef MSSM_NO_FILTERED
    if (d->radius == 0) d->radius = 2;
    if (d->anisotropy == 0) d->anisotropy = 4;
    if (gl->filtered) d->settings = mssm__filter_settings(&d->filter, d->moments);
    if (gl->filtered && (!mssm__in_range(gl, "radius", d->radius, -1, MSSM__RADIUS) ||
                         !mssm__in_range(gl, "anisotropy", d->anisotropy, 1, 16))) {
        return MSSM_ERROR_ARGUMENT;
    }
#endif
    if (!mssm__in_range(gl, "settings.estimator", (int)d->settings.estimator, 0, MSSM_HORIZON))
        return MSSM_ERROR_ARGUMENT;
    if (d->moments == 5) return mssm__report(gl, MSSM_ERROR_ARGUMENT, "moments 5: 4 or 6");
    mssm__find_sizes(gl);
    return MSSM_OK;
}

mssm_result mssm_gl_create(mssm_gl **gl, const mssm_gl_desc *desc)
{
    mssm_gl start;
    memset(&start, 0, sizeof start);
    if (desc) start.desc = *desc;
    if (!gl || !start.desc.load)
        return mssm__report(&start, MSSM_ERROR_ARGUMENT, "desc.load or gl is null");
    start.drawing = -1;
    start.targets = 1;
    mssm_result r = mssm__check_desc(&start);
    if (!r) r = mssm__load(&start);
    if (r) return r;
    mssm_gl *g = (mssm_gl *)MSSM_MALLOC(sizeof *g);
    if (!g) return mssm__report(&start, MSSM_ERROR_MEMORY, "no memory");
    *g = start;
    mssm__find_capabilities(g);
    mssm__drop_errors(g, "mssm_gl_create");
    r = mssm__check_limits(g);
    if (!r) r = mssm__build_programs(g);
    if (!r) r = mssm__create_storage(g);
    if (r) {
        mssm_gl_destroy(g);
        return r;
    }
    g->desc.name = NULL; // the caller's
    *gl = g;
    return MSSM_OK;
}

size_t mssm_gl_bytes(const mssm_gl_desc *desc)
{
    mssm_gl g;
    if (!desc) return 0;
    memset(&g, 0, sizeof g);
    g.desc = *desc;
    if (mssm__check_desc(&g)) return 0;
    const uint64_t samples = (uint64_t)g.layers * (uint64_t)g.desc.samples;
    uint64_t light = sizeof(mssm_view),
             targets = 4 * samples * (uint64_t)g.desc.side * (uint64_t)g.desc.side;
    for (int i = 0; i < MSSM__TABLES; i++) {
        int side, layers;
        for (int level = mssm__array_size(&g, i, &side, &layers); level-- > 0; side /= 2) {
            const uint64_t texel = mssm__tables[i].bytes[g.filtered];
            const uint64_t bytes = texel * (uint64_t)side * (uint64_t)side;
            if (i < MSSM__WORK)
                light += bytes;
            else
                targets += bytes * (uint64_t)layers;
        }
    }
    if (targets > SIZE_MAX || light > (SIZE_MAX - targets) / (uint64_t)g.desc.lights) {
        mssm__report(&g, MSSM_ERROR_ARGUMENT, "more bytes than a size_t holds");
        return 0;
    }
    return (size_t)(light * (uint64_t)g.desc.lights + targets);
}

size_t mssm_glsl_shader(const mssm_gl_desc *desc, char *text, size_t bytes)
{
    mssm_gl g;
    if (!desc) return 0;
    memset(&g, 0, sizeof g);
    g.desc = *desc;
    g.desc.side = g.desc.samples = 0; // not of interest
    g.unbound = 1;
    if (mssm__check_desc(&g) || !mssm__in_range(&g, "mssm_glsl_shader: filtered", g.filtered, 0, 0))
        return 0;
    const size_t length = mssm__print_shader(&g, NULL) + 1;
    if (text && bytes >= length) mssm__print_shader(&g, text);
    return length;
}

void mssm_gl_destroy(mssm_gl *gl)
{
    if (!gl) return;
    const int framing = gl->framing;
    gl->framing = 0;
    if (framing || gl->drawing >= 0) mssm__restore_state(gl);
    if (framing) mssm__restore_bindings(gl);
    mssm__delete_storage(gl);
    for (int i = 0; i < MSSM__PROGRAMS; i++) gl->f.DeleteProgram(gl->program[i]);
    gl->f.DeleteSamplers(1, &gl->sampler);
    gl->f.DeleteVertexArrays(1, &gl->array);
    MSSM_FREE(gl->shader);
    MSSM_FREE(gl);
}

mssm_result mssm_gl_resize(mssm_gl *gl, int lights, int side)
{
    if (!gl) return MSSM_ERROR_ARGUMENT;
    if (gl->drawing >= 0 || gl->framing)
        return mssm__report(gl, MSSM_ERROR_ORDER, "mssm_gl_resize within a frame or a pass");
    mssm_gl fresh = *gl;
    fresh.desc.lights = lights;
    fresh.desc.side = side;
    mssm_result r = mssm__check_desc(&fresh);
    if (r) return r;
    memset(fresh.framebuffer, 0, sizeof fresh.framebuffer);
    memset(fresh.table, 0, sizeof fresh.table);
    fresh.depth = fresh.views = 0;
    fresh.lights = NULL;
    fresh.view = NULL;
    mssm__drop_errors(gl, "mssm_gl_resize");
    r = mssm__check_limits(&fresh);
    if (!r) r = mssm__create_storage(&fresh);
    if (r) {
        mssm__delete_storage(&fresh);
        return r;
    }
    for (int i = 0; i < gl->desc.lights && i < fresh.desc.lights; i++)
        fresh.lights[i].light = gl->lights[i].light;
    mssm__delete_storage(gl);
    *gl = fresh;
    return MSSM_OK;
}

mssm_result mssm_gl_set_light(mssm_gl *gl, int index, const mssm_light *light)
{
    if (!gl || !mssm__in_range(gl, "light", index, 0, gl->desc.lights - 1))
        return MSSM_ERROR_ARGUMENT;
    if (!light || !mssm__is_light(light))
        return mssm__report(gl, MSSM_ERROR_ARGUMENT,
                            "a light needs z_near < z_far and a finite world_to_shadow");
    if (!memcmp(&gl->lights[index].light, light, sizeof *light)) return MSSM_OK;
    gl->lights[index].light = *light;
    mssm__change(gl, index);
    return MSSM_OK;
}

static void mssm__pass_state(mssm_gl *gl, unsigned framebuffer, int depth_mask, int back_faces)
{
    mssm__gl_state s;
    if (!gl->framing) mssm__save_state(gl);
    memset(&s, 0, sizeof s);
    s.framebuffer = (int)framebuffer;
    s.depth_func = MSSM__GL_LESS;
    s.depth_mask = depth_mask;
    s.cull_mode = MSSM__GL_FRONT;
    s.clip_origin = MSSM__GL_LOWER_LEFT;
    s.clip_depth = MSSM__GL_NEGATIVE_ONE_TO_ONE;
    s.polygon_mode[0] = s.polygon_mode[1] = MSSM__GL_FILL;
    s.enabled[0] = s.enabled[2] = 1;
    s.enabled[1] = back_faces; // cull front faces
    memset(s.mask, 1, sizeof s.mask);
    s.viewport[2] = s.viewport[3] = (float)gl->desc.side;
    s.depth_range[1] = 1;
    mssm__set_state(gl, &s);
}

mssm_result mssm_gl_begin_frame(mssm_gl *gl)
{
    if (!gl) return MSSM_ERROR_ARGUMENT;
    const mssm_result r = mssm__check_order(gl, gl->drawing >= 0 || gl->framing,
                                            "mssm_gl_begin_frame", "within a frame or a pass");
    if (r) return r;
    gl->usual_targets = gl->targets;
    gl->targets = 63; // any may be displaced, after the caller has bound others
    mssm__save_bindings(gl);
    mssm__pass_state(gl, gl->framebuffer[0], 1, 0);
    gl->framing = 1;
    return MSSM_OK;
}

mssm_result mssm_gl_end_frame(mssm_gl *gl)
{
    if (!gl) return MSSM_ERROR_ARGUMENT;
    if (gl->drawing >= 0 || !gl->framing)
        return mssm__report(gl, MSSM_ERROR_ORDER,
                            "mssm_gl_end_frame without mssm_gl_begin_frame, or within a pass");
    gl->framing = 0;
    mssm__restore_state(gl);
    mssm__restore_bindings(gl);
    gl->targets = gl->usual_targets;
    return MSSM_OK;
}

mssm_result mssm_gl_begin_depth(mssm_gl *gl, int index, int back_faces)
{
    if (!gl || !mssm__in_range(gl, "light", index, 0, gl->desc.lights - 1))
        return MSSM_ERROR_ARGUMENT;
    if (back_faces && gl->filtered)
        return mssm__report(gl, MSSM_ERROR_ARGUMENT, "filtered maps have no back faces");
    if (back_faces && gl->drawing < 0 && gl->front_of != index)
        return mssm__report(gl, MSSM_ERROR_ORDER,
                            "back faces must follow the front faces of their light");
    const mssm_result r =
        mssm__check_order(gl, gl->drawing >= 0, "mssm_gl_begin_depth", "before mssm_gl_end_depth");
    if (r) return r;
    const float farthest = 1;
    if (!back_faces) mssm__forget(gl, index);
    if (!back_faces && gl->used + 2 > gl->layers) mssm__resolve(gl); // back faces may follow
    mssm__filtered_build(gl, index);
    gl->drawing = index;
    gl->back = back_faces != 0;
    gl->f.NamedFramebufferTextureLayer(gl->framebuffer[0], MSSM__GL_DEPTH_ATTACHMENT, gl->depth, 0,
                                       gl->used);
    mssm__pass_state(gl, gl->framebuffer[0], 1, back_faces);
    gl->f.ClearBufferfv(MSSM__GL_DEPTH, 0, &farthest);
    return MSSM_OK;
}

mssm_result mssm_gl_end_depth(mssm_gl *gl)
{
    if (!gl) return MSSM_ERROR_ARGUMENT;
    const mssm_result r = mssm__check_order(gl, gl->drawing < 0 || gl->translucent,
                                            "mssm_gl_end_depth", "without mssm_gl_begin_depth");
    if (r) return r;
    mssm__restore_state(gl);
    mssm__filled(gl, gl->drawing, gl->back);
    gl->front_of = gl->waiting[gl->used++] = gl->back ? -1 : gl->drawing;
    gl->drawing = -1;
    if (gl->filtered) mssm__resolve(gl); // for translucent casters, and mssm_gl_texture
    return MSSM_OK;
}

// Distances that the ends of a given depth map stand for; whether they are the light's own.
static int mssm__depth_ends(const mssm_light *light, const mssm_gl_depth *d, float *low,
                            float *high)
{
    const int own = d->z_near == 0 && d->z_far == 0;
    *low = own ? light->z_near : d->z_near;
    *high = own ? light->z_far : d->z_far;
    return own;
}

// What can be said of a given depth map without GL, and its kind.
static mssm_result mssm__check_depth(const mssm_gl *gl, const mssm_light *light,
                                     const mssm_gl_depth *d, int *kind)
{
    const unsigned target = d->target ? d->target : (unsigned)MSSM__GL_TEXTURE_2D;
    const int hyperbolic = light->perspective && d->stored == MSSM_STORED_WINDOW;
    *kind = 5;
    while (*kind >= 0 && mssm__targets[*kind].target != target) --*kind;
    if (*kind < 0)
        return mssm__report(gl, MSSM_ERROR_ARGUMENT,
                            "mssm_gl_depth: target 0x%04X: a 2D, cube map or multisampled texture",
                            target);
    if (!mssm__in_range(gl, "mssm_gl_depth: stored", (int)d->stored, 0, light->perspective ? 2 : 1))
        return MSSM_ERROR_ARGUMENT;
    float low, high;
    mssm__depth_ends(light, d, &low, &high); // NaN fails all of these
    if (low >= (hyperbolic ? FLT_MIN : -FLT_MAX) && high > low && (high <= FLT_MAX || hyperbolic))
        return MSSM_OK;
    return mssm__report(gl, MSSM_ERROR_ARGUMENT, "mssm_gl_depth: z_near %g, z_far %g: %s",
                        (double)low, (double)high,
                        hyperbolic ? "0 < z_near < z_far, which may be infinite"
                                   : "z_near < z_far, both finite");
}

// One axis of a given depth map: how many texels a texel of the moment map takes, 0 after a word.
static int mssm__check_axis(const mssm_gl *gl, const char *const names[2], int at, int size,
                            int all)
{
    const int side = gl->desc.side;
    if (all < 0) all = 0; // a driver that lies
    if (!mssm__in_range(gl, names[0], at, 0, all - 1) ||
        !mssm__in_range(gl, names[1], size ? size : all - at, 1, all - at)) {
        return 0;
    }
    if (!size) size = all - at;
    if (size % side == 0 && size / side <= 8) return size / side;
    mssm__report(gl, MSSM_ERROR_ARGUMENT, "%s %d: 1, 2 ... 8 times the side of mssm_gl, %d",
                 names[1], size, side);
    return 0;
}

// Whether the base level of the texture that is bound can be read: else all would be 0, without an
// error. Storage made at once is whole; image is that of a cube map's first face.
static int mssm__is_whole(const mssm_gl *gl, mssm__glenum target, mssm__glenum image, int base)
{
    static const mssm__glenum same[2] = {MSSM__GL_TEXTURE_WIDTH, MSSM__GL_TEXTURE_INTERNAL_FORMAT};
    int last = base, immutable = 1; // a lost context writes nothing
    gl->f.GetTexParameteriv(target, MSSM__GL_TEXTURE_IMMUTABLE_FORMAT, &immutable);
    if (immutable) return 1;
    gl->f.GetTexParameteriv(target, MSSM__GL_TEXTURE_MAX_LEVEL, &last);
    for (int i = 0; i < 12 && image != target; i++) {
        if (mssm__ask_texture(gl, image + (mssm__glenum)i / 2, base, same[i % 2]) !=
            mssm__ask_texture(gl, image, base, same[i % 2]))
            return 0;
    }
    return base <= last;
}

static mssm_result mssm__ask_depth(const mssm_gl *gl, mssm__gl_source *s, const mssm_gl_depth *d)
{
    static const char *const names[2][2] = {{"mssm_gl_depth: x", "mssm_gl_depth: width"},
                                            {"mssm_gl_depth: y", "mssm_gl_depth: height"}};
    const mssm__glenum target = mssm__targets[s->kind].target;
    const int cube = target == MSSM__GL_TEXTURE_CUBE_MAP;
    const int multisampled = s->kind == 0 || s->kind == 5;
    const mssm__glenum image = cube ? (mssm__glenum)MSSM__GL_TEXTURE_CUBE_MAP_POSITIVE_X : target;
    int level = 0;
    if (!multisampled) gl->f.GetTexParameteriv(target, MSSM__GL_TEXTURE_BASE_LEVEL, &level);
    const int width = mssm__ask_texture(gl, image, level, MSSM__GL_TEXTURE_WIDTH);
    const int height = mssm__ask_texture(gl, image, level, MSSM__GL_TEXTURE_HEIGHT);
    const int layers = mssm__ask_texture(gl, image, level, MSSM__GL_TEXTURE_DEPTH);
    const int samples = mssm__ask_texture(gl, image, level, MSSM__GL_TEXTURE_SAMPLES);
    const int depth = mssm__ask_texture(gl, image, level, MSSM__GL_TEXTURE_DEPTH_SIZE);
    const int type = mssm__ask_texture(gl, image, level, MSSM__GL_TEXTURE_RED_TYPE);
    if (!depth && type != MSSM__GL_FLOAT && type != MSSM__GL_UNSIGNED_NORMALIZED &&
        type != MSSM__GL_SIGNED_NORMALIZED) {
        mssm__take_error(gl); // of a level that no texture has
        return mssm__report(gl, MSSM_ERROR_ARGUMENT,
                            "mssm_gl_depth: the texture's base level %d has no storage, or neither "
                            "depth nor red as fractions",
                            level);
    }
    if (!multisampled && !mssm__is_whole(gl, target, image, level))
        return mssm__report(gl, MSSM_ERROR_ARGUMENT,
                            "mssm_gl_depth: the texture is not complete: faces of a cube map that "
                            "are missing or differ, or a base level beyond the last");
    s->each = multisampled && samples > 0 ? samples : 1;
    if (!mssm__in_range(gl, "mssm_gl_depth: layer", d->layer, 0, cube ? 5 : layers - (layers > 0)))
        return MSSM_ERROR_ARGUMENT;
    s->across = mssm__check_axis(gl, names[0], d->x, d->width, width);
    s->up = s->across ? mssm__check_axis(gl, names[1], d->y, d->height, height) : 0;
    return s->up && mssm__in_range(
                        gl, "mssm_gl_depth: texels times samples of a texel of the moment map",
                        s->across * s->up * s->each, 1, 64)
               ? MSSM_OK
               : MSSM_ERROR_ARGUMENT;
}

// What a texture's own state must be for its depth to be read: unlike filters and compare mode no
// sampler stands in for it. `set` or put back what was there.
static void mssm__set_texture_state(const mssm_gl *gl, mssm__gl_source *s, int ask, int set)
{
    static const mssm__glenum names[3] = {MSSM__GL_DEPTH_STENCIL_TEXTURE_MODE,
                                          MSSM__GL_TEXTURE_SWIZZLE_R, MSSM__GL_DEPTH_TEXTURE_MODE};
    static const int wanted[3] = {MSSM__GL_DEPTH_COMPONENT, MSSM__GL_RED, MSSM__GL_RED};
    const mssm__glenum target = mssm__targets[s->kind].target;
    for (int i = 0; i < (gl->compatible ? 3 : 2); i++) {
        if (ask) s->state[i] = wanted[i]; // a lost context writes nothing
        if (ask) gl->f.GetTexParameteriv(target, names[i], &s->state[i]);
        if (s->state[i] != wanted[i])
            gl->f.TexParameteri(target, names[i], set ? wanted[i] : s->state[i]);
    }
}

// Binds a texture of the caller's to a unit if it is one of that kind.
static mssm_result mssm__bind_given(const mssm_gl *gl, int unit, int kind, unsigned texture,
                                    unsigned sampler, const char *call)
{
    if (!texture || !gl->f.IsTexture(texture))
        return mssm__report(gl, MSSM_ERROR_ARGUMENT, "%s: there is no such texture", call);
    mssm__drop_errors(gl, call);
    mssm__bind_texture(gl, unit, mssm__targets[kind].target, texture, sampler);
    if (mssm__get(gl, mssm__targets[kind].binding) == (int)texture) return MSSM_OK;
    mssm__take_error(gl);
    return mssm__report(gl, MSSM_ERROR_ARGUMENT, "%s: the texture is no %s", call,
                        mssm__targets[kind].name);
}

// Binds a depth map to a unit, asks GL about it if not done before, and makes it readable.
static mssm_result mssm__bind_depth(mssm_gl *gl, mssm__gl_source *s, int i, const mssm_gl_depth *d,
                                    int kind)
{
    const int ask = !gl->framing || !d->texture || memcmp(&s->is, d, sizeof *d) != 0;
    mssm_result r = MSSM_OK;
    if (ask) {
        memset(s, 0, sizeof *s);
        s->kind = kind;
        r = mssm__bind_given(gl, i, kind, d->texture, gl->sampler, "mssm_gl_set_depth");
        if (!r) r = mssm__ask_depth(gl, s, d);
    } else {
        mssm__bind_texture(gl, i, mssm__targets[kind].target, d->texture, gl->sampler);
    }
    if (r) return r;
    memcpy(&s->is, d, sizeof *d);
    mssm__set_texture_state(gl, s, ask, 1);
    return MSSM_OK;
}

// Programs of a kind of depth map and the sampler, made when first needed.
static mssm_result mssm__prepare_depth(mssm_gl *gl, int kind, int back)
{
    if (!gl->sampler) {
        gl->f.CreateSamplers(1, &gl->sampler);
        if (!gl->sampler) return mssm__report(gl, MSSM_ERROR_GL, "no sampler object");
        gl->f.SamplerParameteri(gl->sampler, MSSM__GL_TEXTURE_MIN_FILTER, MSSM__GL_NEAREST);
        gl->f.SamplerParameteri(gl->sampler, MSSM__GL_TEXTURE_MAG_FILTER, MSSM__GL_NEAREST);
        gl->f.ObjectLabel(MSSM__GL_SAMPLER, gl->sampler, -1, "mssm given depth");
    }
    return mssm__make_program(gl, MSSM__GIVEN + 2 * kind + back);
}

// Depth maps that are bound, as moments into the map of a light.
static void mssm__take_given(mssm_gl *gl, int index, const mssm__gl_source s[2], int back)
{
    const mssm_light *light = &gl->lights[index].light;
    const mssm_gl_depth *d = &s->is;
    const unsigned program = gl->program[MSSM__GIVEN + 2 * s->kind + back];
    const int hyperbolic = light->perspective && d->stored == MSSM_STORED_WINDOW;
    float low, high;
    const int ours = mssm__depth_ends(light, d, &low, &high);
    const int radial = d->stored == MSSM_STORED_RADIAL;
    const float one = d->reversed ? 1.0f : -1.0f, ratio = low / high;
    const float straight = !ours || radial || (d->reversed && hyperbolic) ? 0.0f : -one;
    const float laws[2][4] = {{high, low - high, 1, 0}, {low, 0, ratio, 1 - ratio}};
    const float *law = laws[hyperbolic];
    const float u = radial ? light->extent_u : 0.0f, v = radial ? light->extent_v : 0.0f;
    // As the texts of linear and of given depth have them.
    const float given[12] = {one,    0.5f - 0.5f * one, u, v, law[0], law[1], law[2],
                             law[3], straight};
    const int from[9] = {s->across, s->up,     s->each,   d->x,         d->y,
                         d->layer,  s[1].is.x, s[1].is.y, s[1].is.layer};
    int job[16] = {s->across * s->up * s->each, gl->desc.side, index, 0, hyperbolic};
    job[5] = mssm_bits(light->z_near);
    job[6] = mssm_bits(light->z_far);
    memcpy(job + 7, from, sizeof from);
    gl->f.ProgramUniform4fv(program, MSSM__GIVEN_UNIFORM, 3, given);
    mssm__filled(gl, index, back);
    mssm__take_depth(gl, program, 1, job, 16);
}

static mssm_result mssm__check_alike(const mssm_gl *gl, const mssm__gl_source *a,
                                     const mssm__gl_source *b)
{
    if (a->kind == b->kind && a->across == b->across && a->up == b->up && a->each == b->each &&
        a->is.stored == b->is.stored && !a->is.reversed == !b->is.reversed &&
        a->is.z_near == b->is.z_near && a->is.z_far == b->is.z_far) {
        return MSSM_OK;
    }
    return mssm__report(
        gl, MSSM_ERROR_ARGUMENT,
        "mssm_gl_set_depth: back must be like front but for texture, layer, x and y");
}

mssm_result mssm_gl_set_depth(mssm_gl *gl, int index, const mssm_gl_depth *front,
                              const mssm_gl_depth *back)
{
    if (!gl || !mssm__in_range(gl, "light", index, 0, gl->desc.lights - 1))
        return MSSM_ERROR_ARGUMENT;
    mssm__gl_light *light = &gl->lights[index];
    if (!front) return mssm__report(gl, MSSM_ERROR_ARGUMENT, "mssm_gl_set_depth: front is null");
    if (!(light->light.z_far > light->light.z_near))
        return mssm__report(gl, MSSM_ERROR_ORDER, "mssm_gl_set_depth before mssm_gl_set_light");
    mssm_result r =
        mssm__check_order(gl, gl->drawing >= 0, "mssm_gl_set_depth", "before mssm_gl_end_depth");
    if (r) return r;
    const mssm_gl_depth *const maps[2] = {front, back};
    const int count = back ? 2 : 1;
    int kinds[2], bound = 0;
    for (int i = 0; i < count && !r; i++)
        r = mssm__check_depth(gl, &light->light, maps[i], &kinds[i]);
    if (r) return r;
    if (back && gl->filtered)
        return mssm__report(gl, MSSM_ERROR_ARGUMENT, "filtered maps have no back faces");
    r = mssm__prepare_depth(gl, kinds[0], back != NULL);
    if (r) return r;
    mssm__filtered_build(gl, index);
    mssm__save_bindings(gl);
    for (int i = 0; i < count; i++) mssm__displace(gl, kinds[i]);
    for (; bound < count && !r; bound += !r)
        r = mssm__bind_depth(gl, &light->source[bound], bound, maps[bound], kinds[bound]);
    if (!r && back) r = mssm__check_alike(gl, &light->source[0], &light->source[1]);
    if (!r) mssm__take_given(gl, index, light->source, back != NULL);
    while (bound-- > 0) {
        mssm__activate(gl, bound);
        mssm__set_texture_state(gl, &light->source[bound], 0, 0);
    }
    mssm__restore_bindings(gl);
    if (!r) mssm__forget(gl, index);
    return r;
}

// All that were drawn start with level 0; a light that has only grown wants coarser levels.
static void mssm__build_tables(mssm_gl *gl, int levels)
{
    (gl->f.MemoryBarrier)(MSSM__GL_BARRIERS);
    for (int first = 0; first < levels; first++) {
        int layers[MSSM__BATCH], count = 0;
        for (int i = 0; i < gl->desc.lights; i++) {
            const mssm__gl_light *l = &gl->lights[i];
            if (l->filled && l->built == first) layers[count++] = i;
            if (count == MSSM__BATCH || (i == gl->desc.lights - 1 && count)) {
                mssm__build_batch(gl, layers, count, first, levels);
                while (count) {
                    gl->lights[layers[--count]].built = levels;
                    mssm__change(gl, layers[count]);
                }
            }
        }
    }
}

mssm_result mssm_gl_build(mssm_gl *gl)
{
    if (!gl) return MSSM_ERROR_ARGUMENT;
    if (gl->drawing < 0 && !gl->stale) return MSSM_OK;
    const mssm_result r =
        mssm__check_order(gl, gl->drawing >= 0, "mssm_gl_build", "before mssm_gl_end_depth");
    if (r) return r;
    if (gl->filtered) {
        mssm__filtered_build(gl, -1);
        gl->stale = 0;
        return MSSM_OK;
    }
    const int levels = mssm__make_views(gl), framing = gl->framing;
    int work = gl->used;
    for (int i = 0; i < gl->desc.lights; i++)
        work |= gl->lights[i].filled && gl->lights[i].built < levels;
    if (work)
        mssm__save_bindings(gl);
    else if (!framing)
        gl->bindings.buffer = mssm__get(gl, MSSM__GL_SHADER_STORAGE_BUFFER_BINDING);
    gl->framing = 1; // what follows need not save it again
    mssm__resolve(gl);
    if (work) mssm__build_tables(gl, levels);
    mssm__upload_views(gl);
    gl->framing = framing;
    gl->front_of = -1; // its texels have become sums
    gl->stale = 0;
    if (work)
        mssm__restore_bindings(gl);
    else if (!framing)
        mssm__bind_buffer_again(gl, gl->bindings.buffer);
    return MSSM_OK;
}

// Once: two that share a unit or a binding read what the other has bound last.
static void mssm__log_displaced(const mssm_gl *gl)
{
    const int unit = gl->desc.first_texture_unit, binding = gl->desc.first_buffer_binding;
    int buffer = 0;
    for (int i = 0; i < 3; i++) {
        if (!gl->table[i]) continue; // there may be no such unit
        mssm__activate(gl, i);
        const int flat = mssm__get(gl, MSSM__GL_TEXTURE_BINDING_2D);
        const int array = mssm__get(gl, MSSM__GL_TEXTURE_BINDING_2D_ARRAY);
        if (!flat && !array) continue;
        mssm__report(gl, MSSM_OK, "first_texture_unit: unit %d has texture %d of someone else",
                     unit + i, array ? array : flat);
    }
    gl->f.GetIntegeri_v(MSSM__GL_SHADER_STORAGE_BUFFER_BINDING, (unsigned)binding, &buffer);
    if (!buffer) return;
    mssm__report(gl, MSSM_OK, "first_buffer_binding: binding %d has buffer %d of someone else",
                 binding, buffer);
}

mssm_result mssm_gl_bind(mssm_gl *gl)
{
    if (!gl) return MSSM_ERROR_ARGUMENT;
    if (gl->framing)
        return mssm__report(gl, MSSM_ERROR_ORDER, "mssm_gl_bind before mssm_gl_end_frame");
    const int generic = mssm__get(gl, MSSM__GL_SHADER_STORAGE_BUFFER_BINDING);
    const int active = mssm__get(gl, MSSM__GL_ACTIVE_TEXTURE);
    mssm__upload_views(gl);
    if (!gl->bound) mssm__log_displaced(gl);
    gl->bound = 1;
    for (int i = 0; i < 3; i++) {
        if (gl->table[i]) mssm__bind_texture(gl, i, MSSM__GL_TEXTURE_2D_ARRAY, gl->table[i], 0);
    }
    gl->f.ActiveTexture((mssm__glenum)active);
    gl->f.BindBufferBase(MSSM__GL_SHADER_STORAGE_BUFFER, (unsigned)gl->desc.first_buffer_binding,
                         gl->views);
    mssm__bind_buffer_again(gl, generic);
    return MSSM_OK;
}

int mssm_gl_stale(const mssm_gl *gl, int index)
{
    if (!gl || !mssm__in_range(gl, "light", index, 0, gl->desc.lights - 1)) return 0;
    const mssm__gl_light *l = &gl->lights[index];
    mssm_light drawn = l->drawn;
    drawn.half_u = l->light.half_u;
    drawn.half_v = l->light.half_v;
    const int ready = gl->ready == index,
              moved = (!l->filled && !ready) || memcmp(&drawn, &l->light, sizeof drawn) != 0;
    const int levels = 1 + mssm_level_of(l->widest, gl->levels);
    const int coarse = !gl->filtered && l->filled && (l->changed || l->built < levels);
    return (moved ? MSSM_STALE_MAP : 0) | (ready || coarse ? MSSM_STALE_TABLES : 0);
}

static void mssm__draw_show(mssm_gl *gl, const int show[3])
{
    const unsigned most = (unsigned)mssm__get(gl, MSSM__GL_MAX_DRAW_BUFFERS),
                   buffers = most < 16 ? most : 16;
    mssm__glboolean mask[16][4] = {{0}}, blend[16] = {0};
    mssm__gl_state s = gl->saved;
    mssm__save_bindings(gl);
    mssm__displace(gl, 2); // 2D arrays
    memset(s.enabled, 0, sizeof s.enabled);
    s.enabled[2] = 1;
    s.depth_mask = s.scissor = 0;
    s.polygon_mode[0] = s.polygon_mode[1] = MSSM__GL_FILL;
    mssm__set_state(gl, &s);
    for (unsigned i = 0; i < buffers; i++) { // the shader has no colour but for the first
        const mssm__glboolean first = i == 0;
        blend[i] = gl->f.IsEnabledi(MSSM__GL_BLEND, i);
        gl->f.GetBooleani_v(MSSM__GL_COLOR_WRITEMASK, i, mask[i]);
        gl->f.Disablei(MSSM__GL_BLEND, i);
        gl->f.ColorMaski(i, first, first, first, first);
    }
    mssm__bind_texture(gl, 0, MSSM__GL_TEXTURE_2D_ARRAY, gl->table[0], 0);
    mssm__bind_texture(gl, 1, MSSM__GL_TEXTURE_2D_ARRAY, gl->table[2], 0);
    gl->f.ProgramUniform1iv(gl->program[MSSM__SHOW], 0, 3, show);
    gl->f.UseProgram(gl->program[MSSM__SHOW]);
    gl->f.BindVertexArray(gl->array);
    gl->f.DrawArrays(MSSM__GL_TRIANGLES, 0, 3);
    for (unsigned i = 0; i < buffers; i++) {
        if (blend[i]) gl->f.Enablei(MSSM__GL_BLEND, i);
        gl->f.ColorMaski(i, mask[i][0], mask[i][1], mask[i][2], mask[i][3]);
    }
    mssm__set_state(gl, &gl->saved);
    mssm__restore_bindings(gl);
}

mssm_result mssm_gl_show(mssm_gl *gl, int index, mssm_show what)
{
    if (!gl || !mssm__in_range(gl, "light", index, 0, gl->desc.lights - 1) ||
        !mssm__in_range(gl, "mssm_gl_show: what", (int)what, 0, gl->filtered ? 0 : 1)) {
        return MSSM_ERROR_ARGUMENT;
    }
    mssm_result r = mssm__check_order(
        gl, gl->drawing >= 0 || gl->framing || !gl->lights[index].built, "mssm_gl_show",
        "within a frame or a pass, or before the light's mssm_gl_build");
    if (!r) r = mssm__make_program(gl, MSSM__SHOW);
    if (r) return r;
    const int show[3] = {index, (int)what, gl->desc.side};
    mssm__save_state(gl);
    if (!mssm__is_complete(gl, (unsigned)gl->saved.framebuffer))
        return mssm__report(gl, MSSM_ERROR_GL,
                            "mssm_gl_show: the draw framebuffer is not complete");
    mssm__draw_show(gl, show);
    return MSSM_OK;
}

const char *mssm_gl_shader(const mssm_gl *gl)
{
    return gl ? gl->shader : NULL;
}

int mssm_gl_layer(const mssm_gl *gl)
{
    return gl && gl->drawing >= 0 && !gl->translucent ? gl->used : -1;
}

unsigned mssm_gl_texture(const mssm_gl *gl, int which)
{
    return gl && which >= 0 && which <= MSSM__WORK ? gl->table[which] : 0;
}

#ifndef MSSM_NO_FILTERED
// ---- Filtered hard shadows in OpenGL ---- >>filtered gl

const char *mssm_glsl_translucent(void)
{
    return "#ifndef MSSM_GLSL_TRANSLUCENT\n"
           "#define MSSM_GLSL_TRANSLUCENT\n"
           "layout(location = 0) out vec4 mssm_layer_low;\n"
           "layout(location = 1) out vec4 mssm_layer_high;\n"
           "void mssm_translucent(float depth, float opacity)\n"
           "{\n"
           "    mssm_moments6 t = mssm_chebyshev(clamp(depth, -1.0, 1.0));\n"
           "    float a = clamp(opacity, 0.0, 1.0);\n"
           "    mssm_layer_low = vec4(0.5 + 0.5 * vec3(t.b[0], t.b[1], t.b[2]), a);\n"
           "    mssm_layer_high = vec4(0.5 + 0.5 * vec3(t.b[3], t.b[4], t.b[5]), a);\n"
           "}\n"
           "#endif\n"
           "#line 1\n";
}

// That mssm_translucent writes to.
static const mssm__glenum mssm__colours[2] = {MSSM__GL_COLOR_ATTACHMENT0,
                                              MSSM__GL_COLOR_ATTACHMENT0 + 1};

static mssm_result mssm__filtered_targets(mssm_gl *gl)
{
    unsigned *target = &gl->framebuffer[MSSM__TRANSLUCENT];
    gl->f.CreateFramebuffers(1, target);
    if (!*target) return MSSM_ERROR_GL;
    for (int i = 0; i < 2; i++)
        gl->f.NamedFramebufferTextureLayer(*target, mssm__colours[i], gl->table[MSSM__WORK], 0, i);
    gl->f.NamedFramebufferTextureLayer(*target, MSSM__GL_DEPTH_ATTACHMENT,
                                       gl->table[MSSM__FARTHEST], 0, 0);
    gl->f.NamedFramebufferDrawBuffer(*target, 0);
    gl->f.ObjectLabel(MSSM__GL_FRAMEBUFFER, *target, -1, "mssm translucent casters");
    return mssm__is_complete(gl, *target) ? MSSM_OK : MSSM_ERROR_GL;
}

// Into the target whose pass has begun, which has no draw buffers so far: with two the caller's
// blending may be one that GL refuses (of a second source).
static void mssm__copy_depth(mssm_gl *gl)
{
    mssm__save_bindings(gl);
    mssm__bind_texture(gl, 0, mssm__targets[0].target, gl->depth, 0);
    gl->f.ProgramUniform1i(gl->program[MSSM__COPY], 0, gl->samples);
    gl->f.UseProgram(gl->program[MSSM__COPY]);
    gl->f.BindVertexArray(gl->array);
    gl->f.DepthFunc(MSSM__GL_ALWAYS);
    gl->f.DepthMask(1);
    gl->f.DrawArrays(MSSM__GL_TRIANGLES, 0, 3);
    gl->f.NamedFramebufferDrawBuffers(gl->framebuffer[MSSM__TRANSLUCENT], 2, mssm__colours);
    gl->f.DepthMask(0);
    gl->f.DepthFunc(MSSM__GL_LESS);
    mssm__restore_bindings(gl);
}

mssm_result mssm_gl_begin_translucent(mssm_gl *gl)
{
    if (!gl) return MSSM_ERROR_ARGUMENT;
    if (gl->drawing >= 0 || gl->ready < 0 || gl->front_of != gl->ready)
        return mssm__report(
            gl, MSSM_ERROR_ORDER,
            "translucent casters must follow the depth pass of their light, of a filtered mssm_gl");
    const mssm_result r = mssm__check_order(gl, 0, "mssm_gl_begin_translucent", "");
    if (r) return r;
    mssm__pass_state(gl, gl->framebuffer[MSSM__TRANSLUCENT], 0, 0);
    mssm__copy_depth(gl);
    gl->drawing = gl->ready;
    gl->translucent = 1;
    return MSSM_OK;
}

mssm_result mssm_gl_end_translucent(mssm_gl *gl)
{
    if (!gl) return MSSM_ERROR_ARGUMENT;
    const mssm_result r = mssm__check_order(gl, !gl->translucent, "mssm_gl_end_translucent",
                                            "without mssm_gl_begin_translucent");
    if (r) return r;
    gl->f.NamedFramebufferDrawBuffer(gl->framebuffer[MSSM__TRANSLUCENT], 0);
    mssm__restore_state(gl);
    gl->translucent = 0;
    gl->drawing = -1;
    return MSSM_OK;
}

// One dispatch: from a level of source into one of target and of the maps.
static void mssm__filter_level(const mssm_gl *gl, int source, int source_level, int target,
                               int level, const int job[7])
{
    const unsigned groups = ((unsigned)(gl->padded >> level) + 7) / 8;
    mssm__bind_level(gl, 0, level);
    mssm__bind_image(gl, 2, source, source_level);
    mssm__bind_image(gl, 3, target, level);
    gl->f.ProgramUniform1iv(gl->program[MSSM__FILTER], 0, 7, job);
    gl->f.DispatchCompute(groups, groups, 1);
    (gl->f.MemoryBarrier)(MSSM__GL_ALL_BARRIERS);
}

// Gaussian and mip chain of the light just drawn, unless it is the one that is given other depth.
static void mssm__filtered_build(mssm_gl *gl, int instead)
{
    if (gl->ready < 0 || gl->ready == instead) return;
    const int r = gl->desc.radius > 0 ? gl->desc.radius : 0, index = gl->ready;
    const int side = gl->desc.side, rows[7] = {-r, 0, r, 0, 1, index, side};
    const int columns[7] = {0, -r, 0, r, 1, index, side};
    int halve[7] = {0, 0, 1, 1, 2, index, side};
    mssm__gl_light *light = &gl->lights[index];
    (gl->f.MemoryBarrier)(MSSM__GL_ALL_BARRIERS);
    mssm__save_bindings(gl);
    gl->f.UseProgram(gl->program[MSSM__FILTER]);
    mssm__filter_level(gl, MSSM__WORK, 0, MSSM__BLURRED_ROWS, 0, rows);
    mssm__filter_level(gl, MSSM__BLURRED_ROWS, 0, MSSM__WORK, 0, columns);
    for (int i = 1; i < gl->levels; i++, halve[6] = (halve[6] + 1) / 2)
        mssm__filter_level(gl, MSSM__WORK, i - 1, MSSM__WORK, i, halve);
    mssm__restore_bindings(gl);
    light->filled = light->averaged = 1;
    light->built = gl->levels;
    mssm__change(gl, index);
    gl->ready = -1;
}

// Of any other texture the kernel would read 0, without an error. Leaves it bound.
static mssm_result mssm__check_moments(mssm_gl *gl, unsigned texture)
{
    const mssm__glenum target = MSSM__GL_TEXTURE_2D_ARRAY;
    mssm__displace(gl, 2); // 2D arrays
    const mssm_result r = mssm__bind_given(gl, 0, 2, texture, 0, "mssm_gl_set_moments");
    int base = 0; // a lost context writes nothing
    if (r) return r;
    gl->f.GetTexParameteriv(target, MSSM__GL_TEXTURE_BASE_LEVEL, &base);
    if (base || mssm__ask_texture(gl, target, 0, MSSM__GL_TEXTURE_WIDTH) < gl->desc.side ||
        mssm__ask_texture(gl, target, 0, MSSM__GL_TEXTURE_HEIGHT) < gl->desc.side ||
        mssm__ask_texture(gl, target, 0, MSSM__GL_TEXTURE_DEPTH) < 2 ||
        mssm__ask_texture(gl, target, 0, MSSM__GL_TEXTURE_INTERNAL_FORMAT) != MSSM__GL_RGBA32F) {
        return mssm__report(gl, MSSM_ERROR_ARGUMENT,
                            "mssm_gl_set_moments: two layers of GL_RGBA32F, of side %d or more, of "
                            "base level 0",
                            gl->desc.side);
    }
    return MSSM_OK;
}

mssm_result mssm_gl_set_moments(mssm_gl *gl, int index, unsigned texture)
{
    if (!gl || !mssm__in_range(gl, "light", index, 0, gl->desc.lights - 1))
        return MSSM_ERROR_ARGUMENT;
    mssm_result r =
        mssm__check_order(gl, gl->drawing >= 0, "mssm_gl_set_moments", "before mssm_gl_end_depth");
    if (r) return r;
    if (gl->filtered)
        return mssm__report(gl, MSSM_ERROR_ARGUMENT, "mssm_gl_set_moments is for soft shadows");
    const int job[3] = {1, gl->desc.side, index};
    mssm__save_bindings(gl);
    if (!gl->framing || !texture) r = mssm__check_moments(gl, texture);
    if (!r) r = mssm__make_program(gl, MSSM__STORE);
    if (!r) {
        gl->f.BindImageTexture(3, texture, 0, 1, 0, MSSM__GL_READ_ONLY, MSSM__GL_RGBA32F);
        mssm__take_depth(gl, gl->program[MSSM__STORE], 1, job, 3);
        mssm__filled(gl, index, 0);
        mssm__forget(gl, index);
    }
    mssm__restore_bindings(gl);
    return r;
}
#endif // MSSM_NO_FILTERED

#endif // MSSM_NO_GL

// ================================================================================================
// References, licence >>licence
//
//   Peters, Klein: Moment Shadow Mapping, I3D 2015. Bounds from four moments.
//   Peters, Muenstermann, Wetzstein, Klein: Beyond Hard Shadows: Moment Shadow Maps for Single
//       Scattering, Soft Shadows and Translucent Occluders, I3D 2016. Soft shadows, integer tables. Slides:
//       GDC Europe 2016; mended: the scale of the tables (slide 72).
//   Kneiphof: Real-Time Image-Based Lighting of Dynamic Scenes with Moment Soft Shadow Mapping, CESCG
//       2017. Six moments, Eq. 7 and 19; mended: Eq. 19 sums to m/2 + 1.
//   Fernando: Percentage-Closer Soft Shadows, SIGGRAPH 2005 sketches.
//   Kahan: To Solve a Real Cubic Equation, 1986.
//   Akhiezer: The Classical Moment Problem, 1965. Christoffel numbers, canonical representations.
//   New here, explained in docs/moments.md: bounds without the roots, pivots in the Chebyshev basis from
//       signed integer tables, the table pyramid, the layered estimator.
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

// ================================================================================================
// GLSL texts, quoted from the C above by `make glsl`: nothing to read, nothing to edit >>generated
// clang-format off
// ================================================================================================

#if defined __GNUC__
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Woverlength-strings"
#endif

const char *mssm_glsl_math(void)
{
    return MSSM__GLSL_BEGIN(MATH)
    // [glsl text begin] made by "make glsl", do not edit
    "// clang-format off\n"
    "struct mssm_moments4 { float b[4]; };\n"
    "struct mssm_moments6 { float b[6]; };\n"
    "struct mssm_points3 { float z[3], w[3]; };\n"
    "struct mssm_points4 { float z[4], w[4]; };\n"
    "struct mssm_bounds { float lower, upper; };\n"
    "struct mssm_roots3 { float x[3]; int count; };\n"
    "// clang-format on\n"
    "\n"
    "// ---- Moments and their storage ---- >>math\n"
    "\n"
    "// Four moments by way of six where these have the same first four: compilers drop the rest.\n"
    "MSSM_SHARED mssm_moments6 mssm_six(mssm_moments4 m)\n"
    "{\n"
    "    mssm_moments6 r;\n"
    "    for (int k = 0; k < 4; k++) r.b[k] = m.b[k];\n"
    "    r.b[4] = 0.0f;\n"
    "    r.b[5] = 0.0f;\n"
    "    return r;\n"
    "}\n"
    "\n"
    "MSSM_SHARED mssm_moments4 mssm_four(mssm_moments6 m)\n"
    "{\n"
    "    mssm_moments4 r;\n"
    "    for (int k = 0; k < 4; k++) r.b[k] = m.b[k];\n"
    "    return r;\n"
    "}\n"
    "\n"
    "mssm_moments6 mssm_moments6_of_depth(float z)\n"
    "{\n"
    "    float d = mssm_clamp(z, -1.0f, 1.0f);\n"
    "    mssm_moments6 m;\n"
    "    m.b[0] = d;\n"
    "    m.b[1] = d * d;\n"
    "    m.b[2] = d * d * d;\n"
    "    m.b[3] = (d * d) * (d * d);\n"
    "    m.b[4] = (d * d) * (d * d) * d;\n"
    "    m.b[5] = (d * d) * (d * d) * (d * d);\n"
    "    return m;\n"
    "}\n"
    "\n"
    "mssm_moments4 mssm_moments4_of_depth(float z)\n"
    "{\n"
    "    return mssm_four(mssm_moments6_of_depth(z));\n"
    "}\n"
    "\n"
    "// Odd entries of all bias vectors are zero: the best vector is symmetric. 4 is beyond all entries.\n"
    "MSSM_SHARED float mssm_blend_to(float b, float alpha, float goal)\n"
    "{\n"
    "    float a = mssm_clamp(alpha, 0.0f, 1.0f);\n"
    "    float start = mssm_clamp(b, -4.0f, 4.0f);\n"
    "    return start - a * (start - goal);\n"
    "}\n"
    "\n"
    "MSSM_SHARED mssm_moments6 mssm_blend_to6(mssm_moments6 m, float alpha, float b2, float b4, float b6)\n"
    "{\n"
    "    mssm_moments6 r;\n"
    "    r.b[0] = mssm_blend_to(m.b[0], alpha, 0.0f);\n"
    "    r.b[1] = mssm_blend_to(m.b[1], alpha, b2);\n"
    "    r.b[2] = mssm_blend_to(m.b[2], alpha, 0.0f);\n"
    "    r.b[3] = mssm_blend_to(m.b[3], alpha, b4);\n"
    "    r.b[4] = mssm_blend_to(m.b[4], alpha, 0.0f);\n"
    "    r.b[5] = mssm_blend_to(m.b[5], alpha, b6);\n"
    "    return r;\n"
    "}\n"
    "\n"
    "mssm_moments4 mssm_moments4_bias(mssm_moments4 m, float alpha)\n"
    "{\n"
    "    return mssm_four(mssm_blend_to6(mssm_six(m), alpha, 0.920f, 3.804f, 0.0f));\n"
    "}\n"
    "\n"
    "mssm_moments6 mssm_moments6_bias(mssm_moments6 m, float alpha)\n"
    "{\n"
    "    return mssm_blend_to6(m, alpha, 0.421f, 0.511f, 1.913f);\n"
    "}\n"
    "\n"
    "mssm_moments4 mssm_moments4_bias_encoded(mssm_moments4 m, float alpha)\n"
    "{\n"
    "    return mssm_four(mssm_blend_to6(mssm_six(m), alpha, 1.120f, 2.884f, 0.0f));\n"
    "}\n"
    "\n"
    "mssm_moments6 mssm_moments6_bias_encoded(mssm_moments6 m, float alpha)\n"
    "{\n"
    "    return mssm_blend_to6(m, alpha, 0.657f, 0.734f, 1.197f);\n"
    "}\n"
    "\n"
    "MSSM_SHARED float mssm_to_unit(float t)\n"
    "{\n"
    "    return mssm_clamp(0.5f + 0.5f * t, 0.0f, 1.0f);\n"
    "}\n"
    "\n"
    "// T_1(z) to T_6(z). In GLSL nothing here may be fused: tables are equal bit for bit.\n"
    "MSSM_SHARED mssm_moments6 mssm_chebyshev(float z)\n"
    "{\n"
    "    MSSM_PRECISE float twice = z + z;\n"
    "    MSSM_PRECISE float t2 = twice * z - 1.0f;\n"
    "    MSSM_PRECISE float t3 = twice * t2 - z;\n"
    "    MSSM_PRECISE float t4 = twice * t3 - t2;\n"
    "    MSSM_PRECISE float t5 = twice * t4 - t3;\n"
    "    MSSM_PRECISE float t6 = twice * t5 - t4;\n"
    "    mssm_moments6 t;\n"
    "    t.b[0] = z;\n"
    "    t.b[1] = t2;\n"
    "    t.b[2] = t3;\n"
    "    t.b[3] = t4;\n"
    "    t.b[4] = t5;\n"
    "    t.b[5] = t6;\n"
    "    return t;\n"
    "}\n"
    "\n"
    "// T1 = z, T2 = 2z^2 - 1, T3 = 4z^3 - 3z, T4 = 8z^4 - 8z^2 + 1, ...\n"
    "mssm_moments6 mssm_moments6_encode(mssm_moments6 m)\n"
    "{\n"
    "    mssm_moments6 q;\n"
    "    q.b[0] = mssm_to_unit(m.b[0]);\n"
    "    q.b[1] = mssm_clamp(m.b[1], 0.0f, 1.0f);\n"
    "    q.b[2] = mssm_to_unit(4.0f * m.b[2] - 3.0f * m.b[0]);\n"
    "    q.b[3] = mssm_to_unit(8.0f * (m.b[3] - m.b[1]) + 1.0f);\n"
    "    q.b[4] = mssm_to_unit(16.0f * m.b[4] - 20.0f * m.b[2] + 5.0f * m.b[0]);\n"
    "    q.b[5] = mssm_to_unit(32.0f * m.b[5] - 48.0f * m.b[3] + 18.0f * m.b[1] - 1.0f);\n"
    "    return q;\n"
    "}\n"
    "\n"
    "mssm_moments4 mssm_moments4_encode(mssm_moments4 m)\n"
    "{\n"
    "    return mssm_four(mssm_moments6_encode(mssm_six(m)));\n"
    "}\n"
    "\n"
    "// Straight from the stored values, without going through T = 2q - 1: fewer roundings.\n"
    "mssm_moments6 mssm_moments6_decode(mssm_moments6 q)\n"
    "{\n"
    "    for (int k = 0; k < 6; k++) q.b[k] = mssm_clamp(q.b[k], 0.0f, 1.0f);\n"
    "    mssm_moments6 m;\n"
    "    m.b[0] = 2.0f * q.b[0] - 1.0f;\n"
    "    m.b[1] = q.b[1];\n"
    "    m.b[2] = 1.5f * q.b[0] + (0.5f * q.b[2] - 1.0f);\n"
    "    m.b[3] = q.b[1] + (0.25f * q.b[3] - 0.25f);\n"
    "    m.b[4] = 1.25f * q.b[0] + (0.625f * q.b[2] + (0.125f * q.b[4] - 1.0f));\n"
    "    m.b[5] = 0.9375f * q.b[1] + (0.375f * q.b[3] + (0.0625f * q.b[5] - 0.375f));\n"
    "    return m;\n"
    "}\n"
    "\n"
    "mssm_moments4 mssm_moments4_decode(mssm_moments4 q)\n"
    "{\n"
    "    return mssm_four(mssm_moments6_decode(mssm_six(q)));\n"
    "}\n"
    "\n"
    "// ---- Bounds without the roots (docs/moments.md, \"Bounds\") ---- >>bounds\n"
    "//\n"
    "// Notation: u = depth - mean. D1, D2, D3 are the pivots of the moment matrix (squared norms of the\n"
    "// monic orthogonal polynomials p1 = u, p2 = (u - a1) p1 - D1, p3 = (u - a2) p2 - D2/D1 p1), u0 is\n"
    "// the receiver. The kernel K(u) = 1 + p1(u) p1(u0)/D1 + p2(u) p2(u0)/D2 + ... vanishes at all other\n"
    "// depths of the canonical representation. With v = 1/(u - u0) it reads k0 v^n + k1 v^(n-1) + ... +\n"
    "// kn, where k0 > 0 is 1/w0, the inverse share of the receiver, times a positive factor. All roots\n"
    "// are real, so Descartes' rule is exact: the number of sign changes is the number of depths beyond\n"
    "// the receiver. The share of any depth x is 1/K(x,x) (Christoffel number).\n"
    "\n"
    "// Floors: pivots below half of alpha times those of the bias vector (D1 = b2, D2 = b4 - b2^2, D3 =\n"
    "// b6 - b4^2/b2), for the smaller of a function's two biases, are not from rounding of safely biased\n"
    "// moments. The longest valid part of such moments is used: 6, 4, 2, or a single surface of the\n"
    "// variance D1's floor. That cuts false shadows 90 times where a user's bias is too small.\n"
    "\n"
    "// Factorised moment matrix (L D L^T): pivots d and the entries c of L that the polynomials need. d2\n"
    "// or d3 is 0 where the moments are valid only up to there; d1 is never below its floor.\n"
    "struct mssm_pivots {\n"
    "    float mean, d1, c21, d2, c32, d3;\n"
    "};\n"
    "\n"
    "struct mssm_kernel4 {\n"
    "    float mean, u0, i1, i2, f1, q2; // i = 1/d; q, f, e: values and slopes of polynomials at u0\n"
    "    float k0, k1, k2, w0;\n"
    "};\n"
    "\n"
    "struct mssm_kernel6 {\n"
    "    float mean, u0, i1, i2, i3, f1, q2, q3, e1, e2;\n"
    "    float k0, k1, k2, k3, w0;\n"
    "};\n"
    "\n"
    "// nearer: share of what is surely nearer than the receiver; own: the share that its own depth can\n"
    "// hold; first: sum of share times depth over what is nearer.\n"
    "struct mssm_split {\n"
    "    float nearer, own, first;\n"
    "};\n"
    "\n"
    "// The clamps (moments to [-4,4], depth to [-1000,1000]) keep every product below finite.\n"
    "MSSM_SHARED mssm_pivots mssm_factorise4(float m1, float m2, float m3, float m4)\n"
    "{\n"
    "    float b1 = mssm_clamp(m1, -4.0f, 4.0f);\n"
    "    float b2 = mssm_clamp(m2, -4.0f, 4.0f);\n"
    "    float b3 = mssm_clamp(m3, -4.0f, 4.0f);\n"
    "    float b4 = mssm_clamp(m4, -4.0f, 4.0f);\n"
    "    float d1 = b2 - b1 * b1;\n"
    "    int valid = d1 > 2.2e-7f ? 1 : 0;\n"
    "    mssm_pivots p;\n"
    "    p.mean = b1;\n"
    "    p.d1 = valid == 1 ? d1 : 2.2e-7f;\n"
    "    float l21 = b3 - b1 * b2;\n"
    "    float c21 = l21 / p.d1;\n"
    "    p.c21 = valid == 1 ? c21 : 0.0f;\n"
    "    // This form loses 9 times fewer digits than (b2 b4 - b3^2 ...) / d1.\n"
    "    float d2 = (b4 - b2 * b2) - l21 * p.c21;\n"
    "    valid = d2 > 7.1e-7f ? valid : 0;\n"
    "    p.d2 = valid == 1 ? d2 : 0.0f;\n"
    "    p.c32 = 0.0f;\n"
    "    p.d3 = 0.0f;\n"
    "    return p;\n"
    "}\n"
    "\n"
    "MSSM_SHARED mssm_pivots mssm_factorise6(float m1, float m2, float m3, float m4, float m5,\n"
    "                                               float m6)\n"
    "{\n"
    "    float b1 = mssm_clamp(m1, -4.0f, 4.0f);\n"
    "    float b2 = mssm_clamp(m2, -4.0f, 4.0f);\n"
    "    float b3 = mssm_clamp(m3, -4.0f, 4.0f);\n"
    "    float b4 = mssm_clamp(m4, -4.0f, 4.0f);\n"
    "    float b5 = mssm_clamp(m5, -4.0f, 4.0f);\n"
    "    float b6 = mssm_clamp(m6, -4.0f, 4.0f);\n"
    "    float d1 = b2 - b1 * b1;\n"
    "    int valid = d1 > 4.6e-7f ? 1 : 0;\n"
    "    mssm_pivots p;\n"
    "    p.mean = b1;\n"
    "    p.d1 = valid == 1 ? d1 : 4.6e-7f;\n"
    "    float i1 = 1.0f / p.d1;\n"
    "    float l21 = b3 - b1 * b2;\n"
    "    float c21 = l21 * i1;\n"
    "    p.c21 = valid == 1 ? c21 : 0.0f;\n"
    "    float d2 = (b4 - b2 * b2) - l21 * p.c21;\n"
    "    valid = d2 > 3.7e-7f ? valid : 0;\n"
    "    p.d2 = valid == 1 ? d2 : 0.0f;\n"
    "    float i2 = 1.0f / (valid == 1 ? d2 : 1.0f);\n"
    "    float l31 = b4 - b1 * b3;\n"
    "    float c31 = l31 * i1;\n"
    "    float l32 = (b5 - b2 * b3) - l21 * c31;\n"
    "    float c32 = l32 * i2;\n"
    "    float d3 = (b6 - b3 * b3) - (l31 * c31 + l32 * c32);\n"
    "    valid = d3 > 7.5e-7f ? valid : 0;\n"
    "    p.c32 = valid == 1 ? c32 : 0.0f;\n"
    "    p.d3 = valid == 1 ? d3 : 0.0f;\n"
    "    return p;\n"
    "}\n"
    "\n"
    "MSSM_SHARED mssm_kernel4 mssm_make_kernel4(mssm_pivots p, float z)\n"
    "{\n"
    "    float u0 = mssm_clamp(z, -1000.0f, 1000.0f) - p.mean;\n"
    "    float a1 = p.c21 - 2.0f * p.mean;\n"
    "    float d2 = p.d2 > 0.0f ? p.d2 : 1.0f;\n"
    "    float i2 = 1.0f / d2;\n"
    "    float q2 = (u0 - a1) * u0 - p.d1;\n"
    "    mssm_kernel4 k;\n"
    "    k.mean = p.mean;\n"
    "    k.u0 = u0;\n"
    "    k.i1 = 1.0f / p.d1;\n"
    "    k.i2 = p.d2 > 0.0f ? i2 : 0.0f;\n"
    "    k.f1 = 2.0f * u0 - a1;\n"
    "    k.q2 = p.d2 > 0.0f ? q2 : 0.0f;\n"
    "    float s1 = 1.0f + u0 * u0 * k.i1;\n"
    "    k.k0 = d2 * s1 + k.q2 * k.q2;\n"
    "    k.k1 = d2 * k.i1 * u0 + k.q2 * k.f1;\n"
    "    k.k2 = k.q2;\n"
    "    k.w0 = 1.0f / (s1 + k.q2 * k.q2 * k.i2);\n"
    "    return k;\n"
    "}\n"
    "\n"
    "MSSM_SHARED mssm_kernel6 mssm_make_kernel6(mssm_pivots p, float z)\n"
    "{\n"
    "    float u0 = mssm_clamp(z, -1000.0f, 1000.0f) - p.mean;\n"
    "    float a1 = p.c21 - 2.0f * p.mean;\n"
    "    float a2 = p.d3 > 0.0f ? p.c32 - p.c21 - p.mean : 0.0f;\n"
    "    float d2 = p.d2 > 0.0f ? p.d2 : 1.0f;\n"
    "    float d3 = p.d3 > 0.0f ? p.d3 : 1.0f;\n"
    "    float i2 = 1.0f / d2;\n"
    "    float i3 = 1.0f / d3;\n"
    "    mssm_kernel6 k;\n"
    "    k.mean = p.mean;\n"
    "    k.u0 = u0;\n"
    "    k.i1 = 1.0f / p.d1;\n"
    "    k.i2 = p.d2 > 0.0f ? i2 : 0.0f;\n"
    "    k.i3 = p.d3 > 0.0f ? i3 : 0.0f;\n"
    "    float r2 = d2 * k.i1;\n"
    "    float r3 = p.d3 > 0.0f ? d3 * i2 : 1.0f;\n"
    "    float q2 = (u0 - a1) * u0 - p.d1;\n"
    "    k.f1 = 2.0f * u0 - a1;\n"
    "    k.q2 = p.d2 > 0.0f ? q2 : 0.0f;\n"
    "    float q3 = (u0 - a2) * k.q2 - r2 * u0;\n"
    "    k.q3 = p.d3 > 0.0f ? q3 : 0.0f;\n"
    "    k.e1 = k.q2 + (u0 - a2) * k.f1 - r2;\n"
    "    k.e2 = k.f1 + (u0 - a2);\n"
    "    float s1 = 1.0f + u0 * u0 * k.i1;\n"
    "    k.k0 = r3 * (d2 * s1 + k.q2 * k.q2) + k.q3 * k.q3;\n"
    "    k.k1 = r3 * (r2 * u0 + k.q2 * k.f1) + k.q3 * k.e1;\n"
    "    k.k2 = r3 * k.q2 + k.q3 * k.e2;\n"
    "    k.k3 = k.q3;\n"
    "    k.w0 = 1.0f / (s1 + k.q2 * k.q2 * k.i2 + k.q3 * k.q3 * k.i3);\n"
    "    return k;\n"
    "}\n"
    "\n"
    "// Share of a depth at distance t from the receiver.\n"
    "MSSM_SHARED float mssm_share4(mssm_kernel4 k, float t)\n"
    "{\n"
    "    float p1 = k.u0 + t;\n"
    "    float p2 = k.q2 + (k.f1 + t) * t;\n"
    "    return 1.0f / (1.0f + p1 * p1 * k.i1 + p2 * p2 * k.i2);\n"
    "}\n"
    "\n"
    "MSSM_SHARED float mssm_share6(mssm_kernel6 k, float t)\n"
    "{\n"
    "    float p1 = k.u0 + t;\n"
    "    float p2 = k.q2 + (k.f1 + t) * t;\n"
    "    float p3 = k.q3 + ((t + k.e2) * t + k.e1) * t;\n"
    "    return 1.0f / (1.0f + p1 * p1 * k.i1 + p2 * p2 * k.i2 + p3 * p3 * k.i3);\n"
    "}\n"
    "\n"
    "// Two other depths: one on each side of the receiver (k2 < 0), or both on one side.\n"
    "MSSM_SHARED mssm_split mssm_split4(mssm_kernel4 k)\n"
    "{\n"
    "    float disc = k.k1 * k.k1 - 4.0f * k.k0 * k.k2;\n"
    "    float root = sqrtf(mssm_max(disc, 0.0f));\n"
    "    float v_a = (-k.k1 - root) / (2.0f * k.k0);\n"
    "    float v_b = 2.0f * k.k2 / (root - k.k1);\n"
    "    float v = k.k1 >= 0.0f ? v_a : v_b;\n"
    "    float t = 1.0f / mssm_min(v, -1e-3f);\n"
    "    float lit = 1.0f - k.w0;\n"
    "    float share = mssm_share4(k, t);\n"
    "    share = mssm_min(share, lit);\n"
    "    // The centred first moment is zero: what is nearer, the receiver and the rest add up to it.\n"
    "    float first_one = share * (k.u0 + t);\n"
    "    float first_all = -k.w0 * k.u0;\n"
    "    float nearer_same = k.k1 > 0.0f ? lit : 0.0f;\n"
    "    float first_same = k.k1 > 0.0f ? first_all : 0.0f;\n"
    "    mssm_split r;\n"
    "    r.nearer = k.k2 < 0.0f ? share : nearer_same;\n"
    "    r.own = k.w0;\n"
    "    r.first = (k.k2 < 0.0f ? first_one : first_same) + k.mean * r.nearer;\n"
    "    return r;\n"
    "}\n"
    "\n"
    "// The only positive root of y^3 + b y^2 + c y + d, where d < 0. From above: from the\n"
    "// Laguerre-Samuelson bound, or from the root without the cubic term.\n"
    "MSSM_SHARED float mssm_positive_root(float b, float c, float d)\n"
    "{\n"
    "    float h = b * b - 3.0f * c;\n"
    "    float y = (2.0f * sqrtf(mssm_max(h, 0.0f)) - b) * (1.0f / 3.0f);\n"
    "    float e = c * c - 4.0f * b * d;\n"
    "    float root = sqrtf(mssm_max(e, 0.0f));\n"
    "    float y_a = -2.0f * d / mssm_max(c + root, 1e-37f);\n"
    "    float y_b = (root - c) / (2.0f * b);\n"
    "    float y_c = c >= 0.0f ? y_a : y_b;\n"
    "    y_c = b > 0.0f ? y_c : y;\n"
    "    y = mssm_min(y_c, y);\n"
    "    for (int i = 0; i < 3; i++) { // Halley: monotone from there, error below 1e-6 after three\n"
    "        float f = ((y + b) * y + c) * y + d;\n"
    "        float f1 = (3.0f * y + 2.0f * b) * y + c;\n"
    "        float f2 = 6.0f * y + 2.0f * b;\n"
    "        float below = 2.0f * f1 * f1 - f * f2;\n"
    "        y = y - 2.0f * f * f1 / mssm_max(below, 1e-37f);\n"
    "    }\n"
    "    return y;\n"
    "}\n"
    "\n"
    "// Three other depths. With one or two of them beyond the receiver, one depth is alone on its side.\n"
    "MSSM_SHARED mssm_split mssm_split6(mssm_kernel6 k)\n"
    "{\n"
    "    int falling = k.k1 < 0.0f ? 1 : 0;\n"
    "    int three = k.k2 > 0.0f ? falling : 0; // beyond, where their number is odd\n"
    "    int two = k.k2 < 0.0f ? 1 : falling;   // beyond, where it is even\n"
    "    float side_odd = three == 1 ? -1.0f : 1.0f;\n"
    "    float side = k.k3 < 0.0f ? side_odd : -1.0f;\n"
    "    float inverse = 1.0f / k.k0;\n"
    "    float y = mssm_positive_root(side * k.k1 * inverse, k.k2 * inverse, side * k.k3 * inverse);\n"
    "    float t = side / mssm_max(y, 1e-3f);\n"
    "    float rest = 1.0f - k.w0;\n"
    "    float share = mssm_share6(k, t);\n"
    "    share = mssm_min(share, rest);\n"
    "    float first_one = share * (k.u0 + t);\n"
    "    float first_all = -k.w0 * k.u0;\n"
    "    float first_two = first_all - first_one;\n"
    "    float nearer_odd = three == 1 ? 0.0f : rest - share;\n"
    "    float first_odd = three == 1 ? 0.0f : first_two;\n"
    "    float nearer_even = two == 1 ? share : rest;\n"
    "    float first_even = two == 1 ? first_one : first_all;\n"
    "    mssm_split r;\n"
    "    r.nearer = k.k3 < 0.0f ? nearer_odd : nearer_even;\n"
    "    r.own = k.w0;\n"
    "    r.first = (k.k3 < 0.0f ? first_odd : first_even) + k.mean * r.nearer;\n"
    "    return r;\n"
    "}\n"
    "\n"
    "MSSM_SHARED mssm_bounds mssm_split_bounds(mssm_split s)\n"
    "{\n"
    "    mssm_bounds r;\n"
    "    r.upper = mssm_clamp(1.0f - s.nearer, 0.0f, 1.0f);\n"
    "    r.lower = mssm_clamp(r.upper - s.own, 0.0f, 1.0f);\n"
    "    return r;\n"
    "}\n"
    "\n"
    "MSSM_SHARED mssm_kernel4 mssm_kernel4_of(mssm_moments4 m, float z)\n"
    "{\n"
    "    return mssm_make_kernel4(mssm_factorise4(m.b[0], m.b[1], m.b[2], m.b[3]), z);\n"
    "}\n"
    "\n"
    "MSSM_SHARED mssm_kernel6 mssm_kernel6_of(mssm_moments6 m, float z)\n"
    "{\n"
    "    return mssm_make_kernel6(mssm_factorise6(m.b[0], m.b[1], m.b[2], m.b[3], m.b[4], m.b[5]), z);\n"
    "}\n"
    "\n"
    "mssm_bounds mssm_visibility4(mssm_moments4 m, float z)\n"
    "{\n"
    "    return mssm_split_bounds(mssm_split4(mssm_kernel4_of(m, z)));\n"
    "}\n"
    "\n"
    "mssm_bounds mssm_visibility6(mssm_moments6 m, float z)\n"
    "{\n"
    "    return mssm_split_bounds(mssm_split6(mssm_kernel6_of(m, z)));\n"
    "}\n"
    "\n"
    "MSSM_SHARED float mssm_split_depth(mssm_split s, float z, float self_min, float self_max)\n"
    "{\n"
    "    float depth = mssm_clamp(z, -1.0f, 1.0f);\n"
    "    float low = mssm_clamp(self_min, 0.0f, 1.0f);\n"
    "    float own = mssm_clamp(s.own, low, mssm_clamp(self_max, low, 1.0f));\n"
    "    float sum = s.nearer + own;\n"
    "    float mean = (s.first + own * depth) / mssm_max(sum, 1e-7f);\n"
    "    return sum > 1e-7f ? mssm_clamp(mean, -1.0f, depth) : depth;\n"
    "}\n"
    "\n"
    "float mssm_blocker_depth4(mssm_moments4 m, float z, float self_weight_min, float self_weight_max)\n"
    "{\n"
    "    mssm_split s = mssm_split4(mssm_kernel4_of(m, z));\n"
    "    return mssm_split_depth(s, z, self_weight_min, self_weight_max);\n"
    "}\n"
    "\n"
    "float mssm_blocker_depth6(mssm_moments6 m, float z, float self_weight_min, float self_weight_max)\n"
    "{\n"
    "    mssm_split s = mssm_split6(mssm_kernel6_of(m, z));\n"
    "    return mssm_split_depth(s, z, self_weight_min, self_weight_max);\n"
    "}\n"
    "\n"
    "// ---- Roots and the full reconstruction ---- >>roots\n"
    "\n"
    "// One real root of a cubic and the quadratic x^2 + b x + c that is left of it.\n"
    "struct mssm_deflated {\n"
    "    float root, b, c;\n"
    "};\n"
    "\n"
    "// Real roots of x^2 + b x + c, or the real part twice: x, ascending.\n"
    "struct mssm_pair {\n"
    "    float x0, x1;\n"
    "};\n"
    "\n"
    "MSSM_SHARED mssm_pair mssm_quadratic(float b, float c)\n"
    "{\n"
    "    float middle = -0.5f * b;\n"
    "    float disc = middle * middle - c;\n"
    "    float root = sqrtf(mssm_max(disc, 0.0f));\n"
    "    float x = middle < 0.0f ? middle - root : middle + root;\n"
    "    float y = disc > 0.0f ? c / x : middle; // no cancellation; x is not 0 where disc is not\n"
    "    mssm_pair r;\n"
    "    r.x0 = mssm_min(x, y);\n"
    "    r.x1 = mssm_max(y, x);\n"
    "    return r;\n"
    "}\n"
    "\n"
    "// x^3 + b x^2 + c x + d divided by one of its roots: forwards, or backwards where that loses less.\n"
    "MSSM_SHARED mssm_deflated mssm_divide(float b, float c, float d, float root)\n"
    "{\n"
    "    mssm_deflated r;\n"
    "    r.root = root;\n"
    "    r.b = b + root;\n"
    "    r.c = c + r.b * root;\n"
    "    float backwards = -d / root;\n"
    "    int back = root * root > fabsf(r.c) ? 1 : 0;\n"
    "    r.b = back == 1 ? (backwards - c) / root : r.b;\n"
    "    r.c = back == 1 ? backwards : r.c;\n"
    "    return r;\n"
    "}\n"
    "\n"
    "// Divides x^3 + b x^2 + c x + d by its simplest real root: the one furthest from the inflection\n"
    "// point, simple unless all three coincide. Newton's method finds it fast from outside, no further\n"
    "// than reach from that point, and deflation by it is stable (after Kahan 1986).\n"
    "MSSM_SHARED mssm_deflated mssm_deflate(float b, float c, float d, float reach)\n"
    "{\n"
    "    float x = b * (-1.0f / 3.0f);\n"
    "    float f = ((x + b) * x + c) * x + d;\n"
    "    float side = f < 0.0f ? -1.0f : 1.0f;\n"
    "    float size = reach * 1.01f;\n"
    "    x = x - side * reach;\n"
    "    for (int i = 0; i < 12; i++) {\n"
    "        f = ((x + b) * x + c) * x + d;\n"
    "        float f1 = (3.0f * x + 2.0f * b) * x + c;\n"
    "        float step = f1 > 0.0f ? side * f / f1 : -size;\n"
    "        if (fabsf(step) > size) break; // steps shrink, or all is rounding: three equal roots\n"
    "        size = fabsf(step);\n"
    "        x = x - side * step;\n"
    "        if (step >= 0.0f && size <= 1e-6f * fabsf(x)) break; // next to 0 one more has its digits\n"
    "    }\n"
    "    return mssm_divide(b, c, d, x);\n"
    "}\n"
    "\n"
    "// The same for a cubic of real roots only: the cosine of a third of an angle as a polynomial of its\n"
    "// cosine h (error 2e-4 of the roots' spread), and a step of Newton's method, to mere rounding.\n"
    "MSSM_SHARED mssm_deflated mssm_deflate_real(float b, float c, float d)\n"
    "{\n"
    "    float middle = b * (-1.0f / 3.0f);\n"
    "    float f = ((middle + b) * middle + c) * middle + d;\n"
    "    float spread = b * b * (1.0f / 3.0f) - c;\n"
    "    float unit = sqrtf(spread > 1e-30f ? spread * (1.0f / 3.0f) : 1e-30f);\n"
    "    float h = mssm_clamp(0.5f * fabsf(f) / (unit * unit * unit + 1e-30f), 0.0f, 1.0f);\n"
    "    float cosine = 0.8660254f + h * (0.1666667f + h * (-0.0424743f + h * 0.0097823f));\n"
    "    float x = middle - (f < 0.0f ? -2.0f : 2.0f) * unit * cosine;\n"
    "    f = ((x + b) * x + c) * x + d;\n"
    "    float f1 = (3.0f * x + 2.0f * b) * x + c;\n"
    "    float step = f / mssm_max(f1, 1e-30f); // bounded: next to a triple root it is noise\n"
    "    x = x - mssm_clamp(step, -0.1f * unit, 0.1f * unit);\n"
    "    return mssm_divide(b, c, d, x);\n"
    "}\n"
    "\n"
    "// How far the roots can lie from the inflection point.\n"
    "MSSM_SHARED float mssm_reach(float b, float c, float d)\n"
    "{\n"
    "    float x = b * (-1.0f / 3.0f);\n"
    "    float f = fabsf(((x + b) * x + c) * x + d);\n"
    "    float cube = f > 0.0f ? powf(f, 1.0f / 3.0f) : 0.0f;\n"
    "    float spread = b * b * (1.0f / 3.0f) - c;\n"
    "    float root = spread > 0.0f ? sqrtf(spread) : 0.0f;\n"
    "    return spread > 0.0f ? 1.324718f * mssm_max(cube, root) : cube;\n"
    "}\n"
    "\n"
    "// All three roots of a cubic with real ones only; the single one is the lowest or the highest.\n"
    "MSSM_SHARED mssm_roots3 mssm_sort3(float single, mssm_pair p)\n"
    "{\n"
    "    mssm_roots3 r;\n"
    "    r.count = 3;\n"
    "    r.x[0] = mssm_min(single, p.x0);\n"
    "    r.x[1] = single < p.x0 ? p.x0 : p.x1;\n"
    "    r.x[2] = mssm_max(p.x1, single);\n"
    "    return r;\n"
    "}\n"
    "\n"
    "MSSM_SHARED mssm_roots3 mssm_no_roots()\n"
    "{\n"
    "    mssm_roots3 r;\n"
    "    r.x[0] = 0.0f;\n"
    "    r.x[1] = 0.0f;\n"
    "    r.x[2] = 0.0f;\n"
    "    r.count = 0;\n"
    "    return r;\n"
    "}\n"
    "\n"
    "// |c| <= 1. Roots beyond 1e18 count as infinite: so small a leading coefficient lowers the degree.\n"
    "MSSM_SHARED mssm_roots3 mssm_solve_quadratic(float c0, float c1, float c2)\n"
    "{\n"
    "    mssm_roots3 r = mssm_no_roots();\n"
    "    float a1 = fabsf(c1);\n"
    "    float a2 = fabsf(c2);\n"
    "    if (a2 > 1e-36f && a1 <= 1e18f * a2) {\n"
    "        float b = c1 / c2;\n"
    "        float c = c0 / c2;\n"
    "        float size = mssm_max(sqrtf(fabsf(c)), fabsf(b));\n"
    "        size = size > 1e-37f ? size : 1.0f;\n"
    "        b = b / size;\n"
    "        c = mssm_clamp(c / size, -3e38f, 3e38f) / size; // as in mssm_solve_monic\n"
    "        mssm_pair p = mssm_quadratic(b, c);\n"
    "        // Rounding of b and c alone moves the discriminant by this much.\n"
    "        if (0.25f * b * b - c >= -4.8e-7f * (0.75f * b * b + fabsf(c))) {\n"
    "            r.x[0] = p.x0 * size;\n"
    "            r.x[1] = p.x1 * size;\n"
    "            r.count = 2;\n"
    "        }\n"
    "    } else if (a1 > 1e-36f && fabsf(c0) <= 1e18f * a1) {\n"
    "        r.x[0] = -c0 / c1;\n"
    "        r.count = 1;\n"
    "    }\n"
    "    return r;\n"
    "}\n"
    "\n"
    "// Whether the two roots that s x^3 + b x^2 + c x + d has beside left.root / s are real. A complex\n"
    "// pair is a double root where rounding of the coefficients can have made it: where the cubic at its\n"
    "// real part m is noise, disc * (m - root), or next to a triple root, where m is that, |disc|^(3/2).\n"
    "MSSM_SHARED int mssm_pair_is_real(mssm_deflated left, float s, float b, float c, float d)\n"
    "{\n"
    "    float m = -0.5f * left.b;\n"
    "    float am = fabsf(m);\n"
    "    float disc = left.c - m * m;\n"
    "    float apart = fabsf(s * m - left.root);\n"
    "    float imaginary = s * sqrtf(mssm_max(disc, 0.0f));\n"
    "    float noise = 2e-6f * (((s * am + fabsf(b)) * am + fabsf(c)) * am + fabsf(d));\n"
    "    return disc * mssm_max(apart, imaginary) <= noise ? 1 : 0;\n"
    "}\n"
    "\n"
    "// x^3 + b x^2 + c x + d. x = size * y makes the largest coefficient 1 and |y| < 2. Two roots far\n"
    "// below the third are found in units of their own, or their squares would leave the range of float.\n"
    "MSSM_SHARED mssm_roots3 mssm_solve_monic(float b, float c, float d)\n"
    "{\n"
    "    float size = mssm_max(sqrtf(fabsf(c)), fabsf(b));\n"
    "    float size_d = d == 0.0f ? 0.0f : powf(fabsf(d), 1.0f / 3.0f);\n"
    "    size = mssm_max(size_d, size);\n"
    "    mssm_roots3 r = mssm_no_roots();\n"
    "    r.count = 3;\n"
    "    if (size <= 0.0f) return r;\n"
    "    float pair = mssm_max(sqrtf(fabsf(d)) / sqrtf(size), fabsf(c) / size);\n"
    "    float unit = pair < 0.01f * size && pair > 1e-37f ? pair : size;\n"
    "    float s = unit < size ? unit / size : 1.0f; // not that of a GPU where x / x is less\n"
    "    b = b / size;\n"
    "    // The clamps never act: they keep GLSL and -ffast-math from powers of size beyond float.\n"
    "    c = mssm_clamp(c / size, -3e38f, 3e38f) / unit;\n"
    "    d = mssm_clamp(mssm_clamp(d / unit, -3e38f, 3e38f) / unit, -3e38f, 3e38f) / size;\n"
    "    mssm_deflated left = mssm_deflate(b, c * s, d * s * s, mssm_reach(b, c * s, d * s * s));\n"
    "    left.c = s < 1.0f ? -d / left.root : left.c;\n"
    "    left.b = s < 1.0f ? (left.c * s - c) / left.root : left.b;\n"
    "    r.x[0] = left.root * size;\n"
    "    r.count = 1;\n"
    "    if (mssm_pair_is_real(left, s, b, c, d) == 0) return r;\n"
    "    mssm_pair p = mssm_quadratic(left.b, left.c);\n"
    "    p.x0 = p.x0 * unit;\n"
    "    p.x1 = p.x1 * unit;\n"
    "    return mssm_sort3(r.x[0], p);\n"
    "}\n"
    "\n"
    "mssm_roots3 mssm_solve_cubic(float c0, float c1, float c2, float c3)\n"
    "{\n"
    "    // An ulp below FLT_MAX: with that itself clang's -ffast-math leaves the comparison out.\n"
    "    float e0 = mssm_clamp(c0, -3.40282326e38f, 3.40282326e38f);\n"
    "    float e1 = mssm_clamp(c1, -3.40282326e38f, 3.40282326e38f);\n"
    "    float e2 = mssm_clamp(c2, -3.40282326e38f, 3.40282326e38f);\n"
    "    float e3 = mssm_clamp(c3, -3.40282326e38f, 3.40282326e38f);\n"
    "    float m01 = mssm_max(fabsf(e0), fabsf(e1));\n"
    "    float m23 = mssm_max(fabsf(e2), fabsf(e3));\n"
    "    float largest = mssm_max(m01, m23);\n"
    "    float scale = largest > 1e18f ? 1e-18f : (largest < 1e-18f ? 1e18f : 1.0f);\n"
    "    largest = largest * scale;\n"
    "    if (largest <= 0.0f) return mssm_no_roots();\n"
    "    e0 = e0 * scale / largest;\n"
    "    e1 = e1 * scale / largest;\n"
    "    e2 = e2 * scale / largest;\n"
    "    e3 = e3 * scale / largest;\n"
    "    float a3 = fabsf(e3);\n"
    "    if (a3 <= 1e-36f || fabsf(e2) > 1e18f * a3) return mssm_solve_quadratic(e0, e1, e2);\n"
    "    return mssm_solve_monic(e2 / e3, e1 / e3, e0 / e3);\n"
    "}\n"
    "\n"
    "// Distance of a depth whose inverse is v; at most 1000, on the same side.\n"
    "MSSM_SHARED float mssm_distance(float v)\n"
    "{\n"
    "    float v_safe = v < 0.0f ? mssm_min(v, -1e-3f) : mssm_max(v, 1e-3f);\n"
    "    return 1.0f / v_safe;\n"
    "}\n"
    "\n"
    "MSSM_SHARED mssm_points3 mssm_points_of4(mssm_kernel4 k)\n"
    "{\n"
    "    mssm_pair v = mssm_quadratic(k.k1 / k.k0, k.k2 / k.k0);\n"
    "    float ta = mssm_distance(v.x0);\n"
    "    float tb = mssm_distance(v.x1);\n"
    "    float t1 = mssm_min(ta, tb);\n"
    "    float t2 = mssm_max(tb, ta);\n"
    "    float s1 = mssm_share4(k, t1);\n"
    "    float s2 = mssm_share4(k, t2);\n"
    "    float rest = (1.0f - k.w0) / (s1 + s2);\n"
    "    mssm_points3 r;\n"
    "    r.z[0] = k.mean + k.u0;\n"
    "    r.z[1] = k.mean + (k.u0 + t1);\n"
    "    r.z[2] = k.mean + (k.u0 + t2);\n"
    "    r.w[0] = k.w0;\n"
    "    r.w[1] = s1 * rest;\n"
    "    r.w[2] = s2 * rest;\n"
    "    return r;\n"
    "}\n"
    "\n"
    "// The given depth, a lone one, and a pair that may be close: not sorted.\n"
    "MSSM_SHARED mssm_points4 mssm_points_of6(mssm_kernel6 k)\n"
    "{\n"
    "    float inverse = 1.0f / k.k0;\n"
    "    mssm_deflated left = mssm_deflate_real(k.k1 * inverse, k.k2 * inverse, k.k3 * inverse);\n"
    "    mssm_pair v = mssm_quadratic(left.b, left.c);\n"
    "    float ta = mssm_distance(left.root);\n"
    "    float tb = mssm_distance(v.x0);\n"
    "    float tc = mssm_distance(v.x1);\n"
    "    // The single root is the well-conditioned one, and so is its share. The shares of a close pair\n"
    "    // are not, but their sum is: what the others leave.\n"
    "    float total = 1.0f - k.w0;\n"
    "    float share_a = mssm_share6(k, ta);\n"
    "    share_a = mssm_min(share_a, total);\n"
    "    float s1 = mssm_share6(k, tb);\n"
    "    float s2 = mssm_share6(k, tc);\n"
    "    float rest = (total - share_a) / (s1 + s2);\n"
    "    mssm_points4 r;\n"
    "    r.z[0] = k.mean + k.u0;\n"
    "    r.z[1] = k.mean + (k.u0 + ta);\n"
    "    r.z[2] = k.mean + (k.u0 + tb);\n"
    "    r.z[3] = k.mean + (k.u0 + tc);\n"
    "    r.w[0] = k.w0;\n"
    "    r.w[1] = share_a;\n"
    "    r.w[2] = s1 * rest;\n"
    "    r.w[3] = s2 * rest;\n"
    "    return r;\n"
    "}\n"
    "\n"
    "mssm_points3 mssm_reconstruct4(mssm_moments4 m, float z)\n"
    "{\n"
    "    mssm_points3 r = mssm_points_of4(mssm_kernel4_of(m, z));\n"
    "    float z0 = mssm_clamp(z, -1000.0f, 1000.0f);\n"
    "    float off = z0 - r.z[0]; // rounding, of all depths alike\n"
    "    r.z[0] = z0;\n"
    "    for (int i = 1; i < 3; i++) {\n"
    "        r.z[i] = r.z[i] + off;\n"
    "        r.w[i] = mssm_min(r.w[i], 1.0f); // quotients of GPUs are off by more than rounding\n"
    "    }\n"
    "    return r;\n"
    "}\n"
    "\n"
    "mssm_points4 mssm_reconstruct6(mssm_moments6 m, float z)\n"
    "{\n"
    "    mssm_points4 r = mssm_points_of6(mssm_kernel6_of(m, z));\n"
    "    float z0 = mssm_clamp(z, -1000.0f, 1000.0f);\n"
    "    float off = z0 - r.z[0];\n"
    "    r.z[0] = z0;\n"
    "    for (int i = 1; i < 4; i++) {\n"
    "        r.z[i] = r.z[i] + off;\n"
    "        r.w[i] = mssm_min(r.w[i], 1.0f);\n"
    "    }\n"
    "    for (int i = 0; i < 3; i++) { // three comparisons of neighbours sort three depths\n"
    "        int j = i == 1 ? 2 : 1;\n"
    "        float z_low = r.z[j];\n"
    "        float w_low = r.w[j];\n"
    "        if (r.z[j + 1] < z_low) {\n"
    "            r.z[j] = r.z[j + 1];\n"
    "            r.w[j] = r.w[j + 1];\n"
    "            r.z[j + 1] = z_low;\n"
    "            r.w[j + 1] = w_low;\n"
    "        }\n"
    "    }\n"
    "    return r;\n"
    "}\n"
    "\n"
    "// ---- Stored moments: factorised in the Chebyshev basis, without decoding ---- >>stored\n"
    "//\n"
    "// t holds E[T_k], as a query of the tables gives it. The products T_i T_j = (T_i+j + T_|i-j|) / 2\n"
    "// make the moment matrix of T_0..T_3 from them. Its pivots are those of powers times 1, 1, 4, 16.\n"
    "// Skipping the conversion to powers skips its rounding, which the safe bias would have to pay for\n"
    "// (4e-6, not 1.3e-6, for 6 moments). Bias vectors 1.120 2.884 and .657 .734 1.197; same floors.\n"
    "\n"
    "MSSM_SHARED mssm_pivots mssm_factorise_stored4(mssm_moments4 t, float alpha)\n"
    "{\n"
    "    float t1 = t.b[0] - alpha * t.b[0];\n"
    "    float t2 = t.b[1] - alpha * (t.b[1] - 1.24f);\n"
    "    float t3 = t.b[2] - alpha * t.b[2];\n"
    "    float t4 = t.b[3] - alpha * (t.b[3] - 15.112f);\n"
    "    float d1 = (0.5f + 0.5f * t2) - t1 * t1;\n"
    "    int valid = d1 > 3.9e-7f ? 1 : 0;\n"
    "    mssm_pivots p;\n"
    "    p.mean = t1;\n"
    "    p.d1 = valid == 1 ? d1 : 3.9e-7f;\n"
    "    float l21 = 0.5f * (t1 + t3) - t1 * t2;\n"
    "    float c21 = l21 / p.d1;\n"
    "    float d2 = ((0.5f + 0.5f * t4) - t2 * t2) - l21 * c21;\n"
    "    p.c21 = valid == 1 ? 0.5f * c21 : 0.0f;\n"
    "    valid = d2 > 2.3e-6f ? valid : 0;\n"
    "    p.d2 = valid == 1 ? 0.25f * d2 : 0.0f;\n"
    "    p.c32 = 0.0f;\n"
    "    p.d3 = 0.0f;\n"
    "    return p;\n"
    "}\n"
    "\n"
    "MSSM_SHARED mssm_pivots mssm_factorise_stored6(mssm_moments6 t, float alpha)\n"
    "{\n"
    "    float t1 = t.b[0] - alpha * t.b[0];\n"
    "    float t2 = t.b[1] - alpha * (t.b[1] - 0.314f);\n"
    "    float t3 = t.b[2] - alpha * t.b[2];\n"
    "    float t4 = t.b[3] - alpha * (t.b[3] - 1.616f);\n"
    "    float t5 = t.b[4] - alpha * t.b[4];\n"
    "    float t6 = t.b[5] - alpha * (t.b[5] - 13.898f);\n"
    "    float d1 = (0.5f + 0.5f * t2) - t1 * t1;\n"
    "    int valid = d1 > 4.3e-7f ? 1 : 0;\n"
    "    mssm_pivots p;\n"
    "    p.mean = t1;\n"
    "    p.d1 = valid == 1 ? d1 : 4.3e-7f;\n"
    "    float i1 = 1.0f / p.d1;\n"
    "    float l21 = 0.5f * (t1 + t3) - t1 * t2;\n"
    "    float c21 = l21 * i1;\n"
    "    float d2 = ((0.5f + 0.5f * t4) - t2 * t2) - l21 * c21;\n"
    "    p.c21 = valid == 1 ? 0.5f * c21 : 0.0f;\n"
    "    valid = d2 > 7.9e-7f ? valid : 0;\n"
    "    p.d2 = valid == 1 ? 0.25f * d2 : 0.0f;\n"
    "    float l31 = 0.5f * (t2 + t4) - t1 * t3;\n"
    "    float c31 = l31 * i1;\n"
    "    float l32 = (0.5f * (t1 + t5) - t2 * t3) - l21 * c31;\n"
    "    float c32 = l32 / (valid == 1 ? d2 : 1.0f);\n"
    "    float d3 = ((0.5f + 0.5f * t6) - t3 * t3) - (l31 * c31 + l32 * c32);\n"
    "    valid = d3 > 3.9e-6f ? valid : 0;\n"
    "    p.c32 = valid == 1 ? 0.5f * c32 : 0.0f;\n"
    "    p.d3 = valid == 1 ? 0.0625f * d3 : 0.0f;\n"
    "    return p;\n"
    "}\n"
    // [glsl text end]
    MSSM__GLSL_END;
}

const char *mssm_glsl_shading(void)
{
    return MSSM__GLSL_BEGIN(SHADING) MSSM__SHADING_NAMES
    // [glsl text begin shading] made by "make glsl", do not edit
    "// One axis of an interpolated query: four table columns (or rows), and the weights of the three\n"
    "// strips between them: a part of the first texel, whole texels (weight 1), a part of the last one.\n"
    "struct mssm_strips {\n"
    "    float edge[4];\n"
    "    float first;\n"
    "    float last;\n"
    "    float whole; // length of all\n"
    "    float known; // and of what stands for the map\n"
    "};\n"
    "\n"
    "// What lies beyond the map is not known: its outermost texels stand for as much of it as the query\n"
    "// has inside, so that a frustum may cut through the world. Further out all is lit.\n"
    "MSSM_SHARED mssm_strips mssm_cut(float begin, float to, float size)\n"
    "{\n"
    "    mssm_strips r;\n"
    "    float inside = mssm_clamp(to, 0.0f, size) - mssm_clamp(begin, 0.0f, size);\n"
    "    float low = mssm_max(begin, -inside);\n"
    "    float high = mssm_min(to, size + inside);\n"
    "    float start = mssm_whole(mssm_clamp(begin, 0.0f, size - 1.0f));\n"
    "    float end = mssm_whole(mssm_clamp(to, 0.0f, size - 1.0f));\n"
    "    float next = start + 1.0f;\n"
    "    r.edge[0] = start;\n"
    "    r.edge[1] = next;\n"
    "    r.edge[2] = mssm_max(end, next);\n"
    "    r.edge[3] = mssm_min(r.edge[2] + 1.0f, size);\n"
    "    r.first = mssm_max((end > start ? next : high) - low, 0.0f);\n"
    "    r.last = end > start ? high - end : 0.0f;\n"
    "    r.whole = to - begin;\n"
    "    r.known = mssm_max(high - low, 0.0f);\n"
    "    return r;\n"
    "}\n"
    "\n"
    "// One axis of a square of the map, in texels of least depth.\n"
    "struct mssm_span {\n"
    "    float low;\n"
    "    float high;\n"
    "};\n"
    "\n"
    "// The level that serves a kernel this wide in texels of level 0, of a map with so many levels.\n"
    "// From the exponents: how often MSSM_KERNEL must be doubled to hold it.\n"
    "MSSM_SHARED int mssm_level_of(float width, int levels)\n"
    "{\n"
    "    int level = (mssm_bits(mssm_max(width, MSSM_KERNEL)) - mssm_bits(MSSM_KERNEL) + 0x7fffff) >> 23;\n"
    "    return level < levels - 1 ? level : levels - 1;\n"
    "}\n"
    "\n"
    "// The level of least depth that serves such a square: 0, of 2 x 2 texels, as long as it touches no\n"
    "// more than two of them on an axis; then the one whose texels, 2^(level + 1) wide, are as wide as\n"
    "// half_size, so that it touches three. There each has the least of itself and the next, right and\n"
    "// below: two reads on an axis see three texels.\n"
    "MSSM_SHARED int mssm_depth_level(float half_size, int levels)\n"
    "{\n"
    "    int level = (mssm_bits(mssm_max(half_size, 4.0f)) - mssm_bits(2.0f) + 0x7fffff) >> 23;\n"
    "    level = half_size > 1.0f ? level : 0;\n"
    "    return level < levels - 1 ? level : levels - 1;\n"
    "}\n"
    "\n"
    "// First and last texel of least depth on one axis, with fractions; scale is one over their width.\n"
    "MSSM_SHARED mssm_span mssm_cut_depths(float x, float half_size, float scale, float size)\n"
    "{\n"
    "    mssm_span r;\n"
    "    r.low = mssm_clamp((x - half_size) * scale, 0.0f, size - 1.0f);\n"
    "    r.high = mssm_clamp((x + half_size) * scale, 0.0f, size - 1.0f);\n"
    "    return r;\n"
    "}\n"
    "\n"
    "// A light and its map as shading sees them. Scalars only: std430 lays it out as C does.\n"
    "struct mssm_view {\n"
    "    float world_to_shadow[16];\n"
    "    float kernel_u; // half-width of the kernel in texels per unit of blur depth, see below\n"
    "    float kernel_v;\n"
    "    float distance_scale; // distance along the axis = scale * z + offset\n"
    "    float distance_offset;\n"
    "    float texel; // width of a texel in units of z; perspective: at distance 1\n"
    "    float side;\n"
    "    float max_half; // of the kernel, in texels\n"
    "    int perspective;\n"
    "    int averaged; // the map is made of front and back faces\n"
    "    int levels;   // of its tables\n"
    "};\n"
    "\n"
    "// Settings with their defaults filled in.\n"
    "struct mssm_options {\n"
    "    int moments;   // 4 or 6\n"
    "    int estimator; // 0 layered, 1 lower, 2 upper blocker, 3 layered above the horizon\n"
    "    float alpha4;\n"
    "    float alpha6;\n"
    "    float depth_bias; // 0: three quarters of a texel\n"
    "    float tolerance;\n"
    "};\n"
    "\n"
    "// A receiver as the estimators see it. A blocker at depth zb blurs over a kernel whose half-width\n"
    "// in texels is kernel * (blur_depth(z) - blur_depth(zb)). Blur depth is depth for directional\n"
    "// lights; for perspective ones it is -1/distance, which makes similar triangles out of the same\n"
    "// formula.\n"
    "struct mssm_receiver {\n"
    "    float x; // texels of level 0\n"
    "    float y;\n"
    "    float z_test;     // depth less the bias, and never behind the empty texels\n"
    "    float z_own;      // depths from z_own - fade to z_own belong in part to the receiver's surface\n"
    "    float sharp;      // 1 / fade\n"
    "    float coarse;     // the same without a normal\n"
    "    float blur_depth; // of the receiver\n"
    "    float d_max;      // its distance from the near plane, in blur depth\n"
    "    float kernel_u;   // the view's, or what the receiver's horizon leaves of it\n"
    "    float kernel_v;\n"
    "    float shift_u; // of the kernel's centre, in texels per unit of blur depth\n"
    "    float shift_v;\n"
    "    float sink;   // of what is further off than the kernel is for, below the tangent plane\n"
    "    float rise_u; // of its tangent plane, in blur depth per texel\n"
    "    float rise_v;\n"
    "    int plane; // 0 unknown, 1 known, 2 and cuts the light\n"
    "    int lit;   // whatever the map holds\n"
    "};\n"
    "\n"
    "MSSM_SHARED float mssm_blur_depth(mssm_view v, float z)\n"
    "{\n"
    "    return v.perspective != 0 ? -1.0f / (v.distance_scale * z + v.distance_offset) : z;\n"
    "}\n"
    "\n"
    "// Distance in blur depth from the receiver to a depth before or behind it, no further than the near\n"
    "// plane.\n"
    "MSSM_SHARED float mssm_blur_distance(mssm_view v, mssm_receiver r, float z)\n"
    "{\n"
    "    float d = r.blur_depth - mssm_blur_depth(v, mssm_clamp(z, -1.0f, 1.0f));\n"
    "    return mssm_clamp(fabsf(d), 0.0f, r.d_max);\n"
    "}\n"
    "\n"
    "// Row of the light's matrix times a point.\n"
    "MSSM_SHARED float mssm_row(mssm_view v, int row, float x, float y, float z)\n"
    "{\n"
    "    return v.world_to_shadow[row] * x + v.world_to_shadow[4 + row] * y +\n"
    "           v.world_to_shadow[8 + row] * z + v.world_to_shadow[12 + row];\n"
    "}\n"
    "\n"
    "// From shadow-space coordinates. Overflow and NaN end up far outside of the map.\n"
    "MSSM_SHARED mssm_receiver mssm_receive_at(mssm_view v, mssm_options o, float x,\n"
    "                                                 float y, float depth)\n"
    "{\n"
    "    mssm_receiver r;\n"
    "    float z = mssm_clamp(depth, -MSSM_FAR_AWAY, MSSM_FAR_AWAY);\n"
    "    r.lit = z > -1.0f ? 0 : 1;\n"
    "    r.x = mssm_clamp((0.5f + 0.5f * x) * v.side, -MSSM_FAR_AWAY, MSSM_FAR_AWAY);\n"
    "    r.y = mssm_clamp((0.5f + 0.5f * y) * v.side, -MSSM_FAR_AWAY, MSSM_FAR_AWAY);\n"
    "    float width = v.perspective != 0 ? v.distance_scale * z + v.distance_offset : 1.0f;\n"
    "    float texel = v.texel * width;\n"
    "    float bias = v.averaged != 0 ? 0.0f : 0.75f * texel;\n"
    "    float fade = v.averaged != 0 ? 2.0f * texel : 1.5f * texel;\n"
    "    bias = o.depth_bias > 0.0f ? o.depth_bias : bias;\n"
    "    r.sharp = 1.0f / (o.depth_bias > 0.0f ? 2.0f * o.depth_bias : fade);\n"
    "    r.coarse = r.sharp;\n"
    "    r.z_own = z - bias;\n"
    "    r.z_test = mssm_min(r.z_own, 1.0f);\n"
    "    r.blur_depth = mssm_blur_depth(v, z);\n"
    "    r.d_max = r.blur_depth - mssm_blur_depth(v, -1.0f);\n"
    "    r.rise_u = 0.0f;\n"
    "    r.rise_v = 0.0f;\n"
    "    r.plane = 0;\n"
    "    r.kernel_u = v.kernel_u;\n"
    "    r.kernel_v = v.kernel_v;\n"
    "    r.shift_u = 0.0f;\n"
    "    r.shift_v = 0.0f;\n"
    "    r.sink = 0.0f;\n"
    "    return r;\n"
    "}\n"
    "\n"
    "MSSM_SHARED mssm_receiver mssm_receive(mssm_view v, mssm_options o, float x, float y,\n"
    "                                              float z)\n"
    "{\n"
    "    float u = mssm_row(v, 0, x, y, z);\n"
    "    float w = mssm_row(v, 1, x, y, z);\n"
    "    float depth = mssm_row(v, 2, x, y, z);\n"
    "    if (v.perspective != 0) {\n"
    "        float axis = mssm_row(v, 3, x, y, z);\n"
    "        float inverse = 1.0f / (axis > 1e-30f ? axis : 1e-30f);\n"
    "        u = u * inverse;\n"
    "        w = w * inverse;\n"
    "        depth = axis > 0.0f ? (axis - v.distance_offset) / v.distance_scale : -1.0f;\n"
    "    }\n"
    "    return mssm_receive_at(v, o, u, w, depth);\n"
    "}\n"
    "\n"
    "// A normal along a row of the light's matrix, in shadow-space units.\n"
    "MSSM_SHARED float mssm_along_row(mssm_view v, int row, float nx, float ny, float nz)\n"
    "{\n"
    "    float x = v.world_to_shadow[row];\n"
    "    float y = v.world_to_shadow[4 + row];\n"
    "    float z = v.world_to_shadow[8 + row];\n"
    "    return (nx * x + ny * y + nz * z) / mssm_max(x * x + y * y + z * z, 1e-37f);\n"
    "}\n"
    "\n"
    "// The horizon leaves of the light, (a, b) in [-1,1]^2, where facing + slope_u a + slope_v b > 0.\n"
    "// The rectangle that stands for that has its corner in the light's furthest above, as much area,\n"
    "// and is narrower in equal parts of the slopes' squares. By up to a fifth it stays off the horizon,\n"
    "// where the receiver's own body begins. What it covers moves with the distance: the kernels'\n"
    "// centres shift. Of a light that has set, a spot at the horizon is left, where the rest of a disc\n"
    "// may still be; up to twice as deep the whole light comes back: who asks then lights from behind.\n"
    "MSSM_CALLED mssm_receiver mssm_cut_light(mssm_view v, mssm_receiver r, float facing,\n"
    "                                                float slope_u, float slope_v)\n"
    "{\n"
    "    float all = mssm_max(fabsf(facing) + fabsf(slope_u) + fabsf(slope_v), 1e-37f);\n"
    "    float s = facing / all;\n"
    "    float u = slope_u / all;\n"
    "    float w = slope_v / all;\n"
    "    // Where the horizon is along an axis, its two ends are alike: no jump from one to the other.\n"
    "    float p = mssm_max(fabsf(u), 0.05f);\n"
    "    float q = mssm_max(fabsf(w), 0.05f);\n"
    "    float cut = mssm_clamp(2.0f + s / (p + q), 0.0f, 1.0f);\n"
    "    if (s >= p + q || cut <= 0.0f) return r;\n"
    "    float above = mssm_max(s + p + q, 0.0f); // of the furthest corner; then of its neighbours\n"
    "    float above_u = mssm_max(s + p - q, 0.0f);\n"
    "    float above_v = mssm_max(s - p + q, 0.0f);\n"
    "    float share = (above * above - above_u * above_u - above_v * above_v) / (8.0f * p * q);\n"
    "    share = mssm_clamp(share, 0.0f, 1.0f);\n"
    "    float squares = (1.0f - share) / (p * p + q * q);\n"
    "    float half_u = 1.0f - p * p * squares;\n"
    "    float half_v = 1.0f - q * q * squares;\n"
    "    float scale = sqrtf(share / (half_u * half_v)) * mssm_max(2.0f * share - 1.0f, 0.8f);\n"
    "    half_u = half_u * scale;\n"
    "    half_v = half_v * scale;\n"
    "    float most = MSSM_FAR_AWAY / mssm_max(r.d_max, 1e-30f);\n"
    "    r.shift_u = cut * u / p * mssm_min((1.0f - half_u) * v.kernel_u, most);\n"
    "    r.shift_v = cut * w / q * mssm_min((1.0f - half_v) * v.kernel_v, most);\n"
    "    r.kernel_u = (1.0f - cut + cut * half_u) * v.kernel_u;\n"
    "    r.kernel_v = (1.0f - cut + cut * half_v) * v.kernel_v;\n"
    "    r.sink = s < 0.0f ? -s * cut / (above + (cut - 1.0f) * s + 1e-6f) : 0.0f;\n"
    "    r.plane = 2;\n"
    "    return r;\n"
    "}\n"
    "\n"
    "// A plane that rises by less than two texels of depth a texel is told from closer blockers: one\n"
    "// that faces the light by half of the fade and two thirds of the bias. That takes 1 to 4% of the\n"
    "// error; half of the bias would double it, but darken points half a texel below their surface.\n"
    "MSSM_SHARED mssm_receiver mssm_narrow_fade(mssm_view v, mssm_receiver r)\n"
    "{\n"
    "    float per_depth = v.perspective != 0 ? v.distance_scale * r.blur_depth * r.blur_depth : 1.0f;\n"
    "    float rise = 1.5f * r.sharp * (r.rise_u + r.rise_v) / per_depth; // in texels of depth\n"
    "    float narrow = mssm_min(0.5f + 0.25f * rise, 1.0f);\n"
    "    r.z_own += (1.0f - narrow) / (3.0f * r.sharp); // the bias is half of the fade\n"
    "    r.z_test = mssm_min(r.z_own, 1.0f);\n"
    "    r.sharp = r.sharp / narrow;\n"
    "    return r;\n"
    "}\n"
    "\n"
    "// Adds the tangent plane; a normal of zero or NaN leaves it unknown. Blur depth is linear on the\n"
    "// map along a plane also for perspective lights.\n"
    "MSSM_CALLED mssm_receiver mssm_tangent(mssm_view v, mssm_options o,\n"
    "                                              mssm_receiver r, float nx, float ny, float nz)\n"
    "{\n"
    "    float u = mssm_along_row(v, 0, nx, ny, nz);\n"
    "    float w = mssm_along_row(v, 1, nx, ny, nz);\n"
    "    float along = mssm_along_row(v, v.perspective != 0 ? 3 : 2, nx, ny, nz);\n"
    "    float texel = 2.0f / mssm_max(v.side, 1.0f);\n"
    "    if (v.perspective != 0) {\n"
    "        along = along + u * (r.x * texel - 1.0f) + w * (r.y * texel - 1.0f);\n"
    "        along = along / mssm_max(-r.blur_depth, 1e-37f);\n"
    "    }\n"
    "    float steep = texel / mssm_max(fabsf(along), 1e-37f);\n"
    "    r.rise_u = mssm_clamp(fabsf(u) * steep, 0.0f, MSSM_FAR_AWAY);\n"
    "    r.rise_v = mssm_clamp(fabsf(w) * steep, 0.0f, MSSM_FAR_AWAY);\n"
    "    r.plane = fabsf(nx) + fabsf(ny) + fabsf(nz) > 0.0f ? 1 : 0;\n"
    "    if (r.plane == 0) return r;\n"
    "    if (v.averaged == 0 && o.depth_bias <= 0.0f) r = mssm_narrow_fade(v, r);\n"
    "    if (o.estimator != 3) return r;\n"
    "    return mssm_cut_light(v, r, -along, u * texel * v.kernel_u, w * texel * v.kernel_v);\n"
    "}\n"
    "\n"
    "MSSM_SHARED float mssm_half_width(mssm_view v, float kernel, float d)\n"
    "{\n"
    "    return mssm_clamp(kernel * d, 0.5f, v.max_half);\n"
    "}\n"
    "\n"
    "// A square of the map, in texels.\n"
    "struct mssm_square {\n"
    "    float x;\n"
    "    float y;\n"
    "    float half_size;\n"
    "};\n"
    "\n"
    "// What holds the kernels of all blockers up to distance d. Where they shift they do not lie in each\n"
    "// other: all between the widest and the receiver, and as much more as the narrowest, half a texel.\n"
    "MSSM_SHARED mssm_square mssm_search_square(mssm_view v, mssm_receiver r, float d)\n"
    "{\n"
    "    float wide = mssm_max(r.kernel_u, r.kernel_v);\n"
    "    mssm_square s;\n"
    "    s.x = r.x;\n"
    "    s.y = r.y;\n"
    "    s.half_size = mssm_half_width(v, wide, d);\n"
    "    if (r.plane != 2) return s;\n"
    "    float out_u = fabsf(r.shift_u);\n"
    "    float out_v = fabsf(r.shift_v);\n"
    "    float reach_u = 0.5f * (out_u + r.kernel_u);\n"
    "    float reach_v = 0.5f * (out_v + r.kernel_v);\n"
    "    s.x = r.x + mssm_clamp(r.shift_u, -reach_u, reach_u) * d;\n"
    "    s.y = r.y + mssm_clamp(r.shift_v, -reach_v, reach_v) * d;\n"
    "    wide = mssm_max(mssm_max(wide, reach_u), reach_v);\n"
    "    s.half_size = mssm_half_width(v, wide, d) + mssm_min((out_u + out_v) * d, 0.5f);\n"
    "    return s;\n"
    "}\n"
    "\n"
    "MSSM_SHARED mssm_kernel4 mssm_kernel4_stored(mssm_moments6 t, float alpha, float z)\n"
    "{\n"
    "    mssm_moments4 t4;\n"
    "    t4.b[0] = t.b[0];\n"
    "    t4.b[1] = t.b[1];\n"
    "    t4.b[2] = t.b[2];\n"
    "    t4.b[3] = t.b[3];\n"
    "    return mssm_make_kernel4(mssm_factorise_stored4(t4, alpha), z);\n"
    "}\n"
    "\n"
    "MSSM_SHARED mssm_kernel6 mssm_kernel6_stored(mssm_moments6 t, float alpha, float z)\n"
    "{\n"
    "    return mssm_make_kernel6(mssm_factorise_stored6(t, alpha), z);\n"
    "}\n"
    "\n"
    "// The depths that Chebyshev moments hold; z[0] is the receiver's.\n"
    "MSSM_SHARED mssm_points4 mssm_layers(mssm_options o, int moments, mssm_moments6 t, float z)\n"
    "{\n"
    "    if (moments == 6) return mssm_points_of6(mssm_kernel6_stored(t, o.alpha6, z));\n"
    "    mssm_points3 p = mssm_points_of4(mssm_kernel4_stored(t, o.alpha4, z));\n"
    "    mssm_points4 q;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        q.z[i] = p.z[i];\n"
    "        q.w[i] = p.w[i];\n"
    "    }\n"
    "    q.z[3] = 1.0f;\n"
    "    q.w[3] = 0.0f;\n"
    "    return q;\n"
    "}\n"
    "\n"
    "// What a depth blocks: nothing behind the receiver, and only a part of what may be its own surface.\n"
    "MSSM_SHARED float mssm_blocked(mssm_receiver r, float z, float w)\n"
    "{\n"
    "    return z < r.z_test ? w * mssm_clamp((r.z_own - z) * r.sharp, 0.0f, 1.0f) : 0.0f;\n"
    "}\n"
    "\n"
    "// How far the receiver's tangent plane comes towards the light within the kernel for distance d:\n"
    "// less than d where the whole light is above the horizon.\n"
    "MSSM_SHARED float mssm_plane_reach(mssm_view v, mssm_receiver r, float d)\n"
    "{\n"
    "    if (r.plane == 0) return 0.0f;\n"
    "    return mssm_min(r.rise_u * mssm_half_width(v, v.kernel_u, d) +\n"
    "                        r.rise_v * mssm_half_width(v, v.kernel_v, d),\n"
    "                    d);\n"
    "}\n"
    "\n"
    "// The part of a blocker that is neither the receiver's tangent plane nor below it; its distance in\n"
    "// units of the kernel's and of the plane's reach. A plane's moments have their points in front\n"
    "// between a third and all of its reach. Seen from behind, it is at 1 where the kernel begins and 1 +\n"
    "// 1 / sink where the light ends.\n"
    "MSSM_SHARED float mssm_off_plane(mssm_receiver r, float relative, float reach)\n"
    "{\n"
    "    return mssm_clamp((reach - 0.3f) * (1.0f / 0.7f), 0.0f, 1.0f) *\n"
    "           mssm_clamp(1.0f + r.sink - r.sink * relative, 0.0f, 1.0f);\n"
    "}\n"
    "\n"
    "// Where the range of depth is long, the moment bias lets light through: about half of alpha /\n"
    "// distance^2, in depths from -1 to 1. Whether that may be all of a visibility.\n"
    "MSSM_SHARED int mssm_bias_leaks(mssm_options o, float distance, float visible)\n"
    "{\n"
    "    float alpha = o.moments == 6 ? o.alpha6 : o.alpha4;\n"
    "    return alpha > visible * distance * distance ? 1 : 0;\n"
    "}\n"
    "\n"
    "// One of the nested kernels. It stands for blockers at distance d and beyond, as far as no wider\n"
    "// one does, in part for those down to inner, where the next begins, the last for all nearer ones.\n"
    "struct mssm_nested {\n"
    "    float d;\n"
    "    float inner;\n"
    "    float outer; // of the one before; d where there is none\n"
    "    float own;   // share of d up to which a blocker may be the receiver's own surface\n"
    "    int last;\n"
    "};\n"
    "\n"
    "// What a kernel holds: the weight of all its blockers, of those that it or a wider one stands for,\n"
    "// of those that it alone stands for, and of those so far off that wider ones have dealt with them.\n"
    "struct mssm_occlusion {\n"
    "    float all;\n"
    "    float counted;\n"
    "    float fresh;\n"
    "    float past;\n"
    "};\n"
    "\n"
    "// Linear in the area of kernels: 0 at distance a, 1 at b; inverse is mssm_inverse_between(a, b).\n"
    "MSSM_SHARED float mssm_between(float distance, float a, float inverse)\n"
    "{\n"
    "    return mssm_clamp((distance - a) * (distance + a) * inverse, 0.0f, 1.0f);\n"
    "}\n"
    "\n"
    "MSSM_SHARED float mssm_inverse_between(float a, float b)\n"
    "{\n"
    "    return 1.0f / mssm_max((b - a) * (b + a), 1e-37f);\n"
    "}\n"
    "\n"
    "// Share of a depth behind the receiver that counts as its own surface going on there; distance in\n"
    "// units of the one that the kernel is for. Neither the empty texels beyond all casters nor what is\n"
    "// further off.\n"
    "MSSM_SHARED float mssm_own_surface(mssm_receiver r, float z, float w, float distance)\n"
    "{\n"
    "    float gap = 1.0f - MSSM_FAR_CASTER;\n"
    "    return w * mssm_clamp((1.0f - distance) * (1.0f / 0.3f), 0.0f, 1.0f) *\n"
    "           mssm_clamp((1.0f - z) * (2.0f / gap), 0.0f, 1.0f) *\n"
    "           mssm_clamp((z - r.z_own) * r.sharp, 0.0f, 1.0f);\n"
    "}\n"
    "\n"
    "// What of a blocker of weight w is so close to the receiver that it may be the receiver's own\n"
    "// surface in the next texel: all up to three texels of depth in front, nothing from nine on.\n"
    "MSSM_SHARED float mssm_adjacent(mssm_receiver r, float z, float w)\n"
    "{\n"
    "    return w * mssm_clamp(1.4f - 0.25f * (r.z_own - z) * r.coarse, 0.0f, 1.0f);\n"
    "}\n"
    "\n"
    "// The part of what is adjacent in front that is the rim of a surface which the light grazes: the\n"
    "// receiver has that surface in the next texel and none of it behind. So where the kernel is about a\n"
    "// texel wide, all that lies behind, empty texels too, stands for as much in front.\n"
    "MSSM_CALLED float mssm_rim(mssm_receiver r, mssm_points4 p, float half_width)\n"
    "{\n"
    "    float behind = 0.0f;\n"
    "    float adjacent = 0.0f;\n"
    "    for (int j = 1; j < 4; j++) {\n"
    "        adjacent += mssm_adjacent(r, p.z[j], mssm_blocked(r, p.z[j], p.w[j]));\n"
    "        behind += p.w[j] * mssm_clamp((p.z[j] - r.z_own) * r.sharp, 0.0f, 1.0f);\n"
    "    }\n"
    "    behind = behind * mssm_clamp(3.0f - 4.0f * half_width, 0.0f, 1.0f);\n"
    "    return mssm_min(behind, adjacent) / (adjacent + 1e-9f);\n"
    "}\n"
    "\n"
    "// One loop over the other depths with all sums, which is what makes it long: split up it would read\n"
    "// each of them as many times.\n"
    "MSSM_CALLED mssm_occlusion mssm_kernel_occlusion(mssm_view v, mssm_receiver r,\n"
    "                                                        mssm_nested k, mssm_points4 p)\n"
    "{\n"
    "    float kernel = mssm_max(r.kernel_u, r.kernel_v);\n"
    "    float half_width = kernel * k.d;\n"
    "    float inverse_reach = 1.0f / (mssm_plane_reach(v, r, k.d) + 1e-30f);\n"
    "    float rim =\n"
    "        half_width < 0.75f && v.averaged == 0 ? mssm_rim(r, p, mssm_max(half_width, 0.5f)) : 0.0f;\n"
    "    float mirrored = v.averaged != 0 ? 0.5f : 1.0f;\n"
    "    float inverse_d = 1.0f / (k.d + 1e-30f);\n"
    "    // The one-texel kernel sees texel centres up to a texel away.\n"
    "    float to_reach = half_width < 1.0f ? kernel : inverse_d;\n"
    "    float inverse = mssm_inverse_between(k.inner, k.d);\n"
    "    float inverse_outer = mssm_inverse_between(k.d, k.outer);\n"
    "    float near_by = 0.0f;\n"
    "    float behind = p.w[0] + 2.0f * r.sink;\n"
    "    float plane = 0.0f; // what is taken for the tangent plane\n"
    "    float plane_counted = 0.0f;\n"
    "    mssm_occlusion s;\n"
    "    s.all = 0.0f;\n"
    "    s.counted = 0.0f;\n"
    "    s.fresh = 0.0f;\n"
    "    s.past = 0.0f;\n"
    "    for (int j = 1; j < 4; j++) {\n"
    "        if (p.w[j] < 1e-4f) continue;\n"
    "        float distance = mssm_blur_distance(v, r, p.z[j]);\n"
    "        float relative = distance * inverse_d;\n"
    "        // The mirror reaches a fifth further: the bias keeps what is close out of the front, but\n"
    "        // not out of what lies behind, whose mean is nearer then.\n"
    "        float at = p.z[j] < r.z_test ? distance : 1.2f * distance;\n"
    "        float counted = k.last == 1 ? 1.0f : mssm_between(at, k.inner, inverse);\n"
    "        float fresh = counted - mssm_between(at, k.d, inverse_outer);\n"
    "        float w;\n"
    "        if (p.z[j] < r.z_test) {\n"
    "            w = mssm_blocked(r, p.z[j], p.w[j]);\n"
    "            if (r.plane != 0) {\n"
    "                float on_plane = w - w * mssm_off_plane(r, relative, distance * inverse_reach);\n"
    "                w = w - on_plane;\n"
    "                // Points a little below their surface have it in front, too: twice more faded.\n"
    "                on_plane = mssm_blocked(r, p.z[j], mssm_blocked(r, p.z[j], on_plane));\n"
    "                plane += on_plane;\n"
    "                plane_counted += on_plane * counted;\n"
    "            }\n"
    "            if (rim > 0.0f) w = w - rim * mssm_adjacent(r, p.z[j], w);\n"
    "            s.all += w;\n"
    "            s.past += w * mssm_clamp(relative - 1.5f, 0.0f, 1.0f);\n"
    "            near_by += w * mssm_clamp(1.0f - relative / k.own, 0.0f, 1.0f);\n"
    "        } else {\n"
    "            behind += p.w[j];\n"
    "            // A surface through the receiver lies as much behind it as in front, and within its\n"
    "            // tangent plane's reach: without this a plane tilted by more than a third of the\n"
    "            // light's reach would shadow itself. Halfway to its back, a surface is less in its own\n"
    "            // way.\n"
    "            w = -mirrored * mssm_own_surface(r, p.z[j], p.w[j], distance * to_reach);\n"
    "            if (r.plane != 0) w = w * mssm_clamp(2.0f - distance * inverse_reach, 0.0f, 1.0f);\n"
    "        }\n"
    "        s.counted += w * counted;\n"
    "        s.fresh += w * fresh;\n"
    "    }\n"
    "    // So where next to nothing lies behind, what was taken for the tangent plane blocks; unless that\n"
    "    // is seen from behind.\n"
    "    float covered = mssm_clamp(1.0f - 3.0f * behind / (plane + 1e-9f), 0.0f, 1.0f);\n"
    "    s.all += covered * plane;\n"
    "    s.counted += covered * plane_counted;\n"
    "    // What is much nearer than the kernel's blockers is more often the receiver's own surface,\n"
    "    // where there is as much of it at the receiver's depth.\n"
    "    if (k.last == 0) s.all = s.all - mssm_min(near_by, p.w[0]);\n"
    "    s.counted = mssm_clamp(s.counted, 0.0f, 1.0f);\n"
    "    s.fresh = mssm_clamp(s.fresh, 0.0f, s.counted);\n"
    "    s.past = k.outer > k.d ? mssm_min(s.past, s.counted) : 0.0f;\n"
    "    return s;\n"
    "}\n"
    "\n"
    "// Distance of the next kernel: the mean of the blockers that this one is too wide for, and with\n"
    "// some weight a third of its own.\n"
    "MSSM_SHARED float mssm_next_distance(mssm_view v, mssm_receiver r, float d, mssm_points4 p)\n"
    "{\n"
    "    float sum = 0.2f;\n"
    "    float first = 0.07f * d;\n"
    "    float inverse = mssm_inverse_between(0.0f, d);\n"
    "    for (int j = 1; j < 4; j++) {\n"
    "        if (p.z[j] >= r.z_test) continue;\n"
    "        float distance = mssm_blur_distance(v, r, p.z[j]);\n"
    "        float w = mssm_blocked(r, p.z[j], p.w[j]) * (1.0f - mssm_between(distance, 0.0f, inverse));\n"
    "        sum += w;\n"
    "        first += w * distance;\n"
    "    }\n"
    "    return first / sum; // .06 d to .65 d\n"
    "}\n"
    // [glsl text end]
    MSSM__GLSL_END MSSM__ESTIMATE_BEGIN
    // [glsl text begin estimate] made by "make glsl", do not edit
    "\n"
    "// Chebyshev moments of the kernel for blockers at distance d.\n"
    "MSSM_SHARED mssm_moments6 mssm_filter_moments(MSSM_MAP map, mssm_view v, mssm_receiver r,\n"
    "                                              int moments, float d)\n"
    "{\n"
    "    return mssm_query(map, moments, r.x + r.shift_u * d, r.y + r.shift_v * d,\n"
    "                      mssm_half_width(v, r.kernel_u, d), mssm_half_width(v, r.kernel_v, d));\n"
    "}\n"
    "\n"
    "// Least depth in the cone up to distance d.\n"
    "MSSM_SHARED float mssm_cone_least(MSSM_MAP map, mssm_view v, mssm_receiver r, float d)\n"
    "{\n"
    "    mssm_square s = mssm_search_square(v, r, d);\n"
    "    return MSSM_LEAST_DEPTH(map, s.x, s.y, s.half_size);\n"
    "}\n"
    "\n"
    "// The least distance that the kernel of every blocker of the receiver reaches no further than, or 0\n"
    "// where nothing can block: from the least depth in the cone of the light up to the near plane, and\n"
    "// then in the cone up to there, as long as that helps.\n"
    "MSSM_SHARED float mssm_cone_reach(MSSM_MAP map, mssm_view v, mssm_receiver r)\n"
    "{\n"
    "    float kernel = mssm_max(r.kernel_u, r.kernel_v);\n"
    "    float d = r.d_max;\n"
    "    float before;\n"
    "    int i = 0;\n"
    "    do {\n"
    "        float z = mssm_cone_least(map, v, r, d);\n"
    "        if (z >= r.z_test) return 0.0f;\n"
    "        before = d;\n"
    "        d = mssm_min(mssm_blur_distance(v, r, z), d);\n"
    "        i = i + 1;\n"
    "    } while (i < 6 && d < 0.8f * before && kernel * d > 0.5f);\n"
    "    return d;\n"
    "}\n"
    "\n"
    "// What a receiver sees without the light that is the moment bias alone: none where all that the cone\n"
    "// holds up to distance d hides it. What blocks the whole light is at least the fade in front; more\n"
    "// than the bias lets through comes through gaps between layers, which the depth that is greatest does\n"
    "// not tell of. Beyond the map nothing hides.\n"
    "MSSM_CALLED float mssm_without_leak(MSSM_MAP map, mssm_view v, mssm_options o,\n"
    "                                    mssm_receiver r, float d, float visible)\n"
    "{\n"
    "    if (visible <= o.tolerance || mssm_bias_leaks(o, 1.0f / r.sharp, visible) == 0) return visible;\n"
    "    if (mssm_clamp(r.x, 0.0f, v.side) != r.x || mssm_clamp(r.y, 0.0f, v.side) != r.y)\n"
    "        return visible;\n"
    "    mssm_square s = mssm_search_square(v, r, d);\n"
    "    float z = MSSM_GREATEST_DEPTH(map, s.x, s.y, s.half_size);\n"
    "    if (mssm_bias_leaks(o, r.z_test - z, visible) == 0) return visible;\n"
    "    return mssm_blocked(r, z, 1.0f) < 1.0f ? visible : 0.0f;\n"
    "}\n"
    "\n"
    "// Mean distance of the blockers in the kernel for distance d, weighted by it once more: a little of\n"
    "// the receiver's own surface does no harm. Only where to look first depends on it, so that four\n"
    "// moments do.\n"
    "MSSM_CALLED float mssm_mean_distance(MSSM_MAP map, mssm_view v, mssm_options o,\n"
    "                                     mssm_receiver r, float d)\n"
    "{\n"
    "    mssm_points4 p = mssm_layers(o, 4, mssm_filter_moments(map, v, r, 4, d), r.z_test);\n"
    "    float sum = 1e-3f * d;\n"
    "    float squares = sum * d;\n"
    "    for (int j = 1; j < 3; j++) {\n"
    "        if (p.z[j] >= r.z_test) continue;\n"
    "        float distance = mssm_blur_distance(v, r, p.z[j]);\n"
    "        sum += p.w[j] * distance;\n"
    "        squares += p.w[j] * distance * distance;\n"
    "    }\n"
    "    return mssm_min(squares / mssm_max(sum, 1e-37f), d);\n"
    "}\n"
    "\n"
    "// Nested kernels from the widest in: each takes the part of its blockers that it stands for as what\n"
    "// blocks, and leaves the rest of the light to the next. Where a kernel stands for all of its\n"
    "// blockers there is one layer, and what it does not block is lit but for blockers that only\n"
    "// narrower kernels show. So one layer is filtered by one kernel, nothing is counted twice or lost\n"
    "// between two, and the result changes continuously with all inputs. Long: all that the loop changes\n"
    "// is used in each of its steps.\n"
    "MSSM_CALLED float mssm_layered(MSSM_MAP map, mssm_view v, mssm_options o,\n"
    "                               mssm_receiver r)\n"
    "{\n"
    "    float kernel = mssm_max(r.kernel_u, r.kernel_v);\n"
    "    float reach = mssm_cone_reach(map, v, r);\n"
    "    if (reach <= 0.0f) return 1.0f;\n"
    "    float least = 0.5f / mssm_max(kernel, 1e-30f); // of the kernel one texel wide\n"
    "    mssm_nested k;\n"
    "    k.d = least < reach ? mssm_mean_distance(map, v, o, r, reach) : reach;\n"
    "    k.outer = k.d;\n"
    "    k.inner = k.d;\n"
    "    k.own = o.moments == 6 ? 0.6f : 0.3f; // four moments tell it from a near caster less well\n"
    "    float blocked = 0.0f;\n"
    "    float lit = 0.0f;  // but for fresh blockers\n"
    "    float rest = 1.0f; // left to narrower kernels\n"
    "    int i = 0;\n"
    "    do {\n"
    "        mssm_points4 p =\n"
    "            mssm_layers(o, o.moments, mssm_filter_moments(map, v, r, o.moments, k.d), r.z_test);\n"
    "        k.last = i == 3 || k.d <= 1.001f * least ? 1 : 0;\n"
    "        if (k.last == 0) {\n"
    "            k.inner = mssm_next_distance(v, r, k.d, p);\n"
    "            float z = mssm_cone_least(map, v, r, k.inner);\n"
    "            i = z < r.z_test ? i : 4; // nothing is nearer\n"
    "            k.inner = mssm_max(mssm_min(mssm_blur_distance(v, r, z), k.inner), least);\n"
    "        }\n"
    "        mssm_occlusion s = mssm_kernel_occlusion(v, r, k, p);\n"
    "        float part = k.last == 1 ? 1.0f : s.counted / (s.all + 1e-6f);\n"
    "        // Of what wider kernels left, none is left to the blockers of other layers, much further\n"
    "        // than this kernel's, that block beside it. 1.3, not 1: where only those are seen, they\n"
    "        // stand for what they hide.\n"
    "        float left = part * (1.3f * s.counted - s.past) / (1.3f * part - s.past + 1e-6f);\n"
    "        float more = lit * s.fresh;\n"
    "        blocked += more + rest * left;\n"
    "        lit += rest * (part - left) - more;\n"
    "        rest = rest * (1.0f - part);\n"
    "        k.outer = k.d;\n"
    "        k.d = k.inner;\n"
    "        i = i + 1;\n"
    "    } while (i < 4 && k.last == 0 && lit + rest > o.tolerance);\n"
    "    return mssm_without_leak(map, v, o, r, reach, 1.0f - mssm_clamp(blocked, 0.0f, 1.0f));\n"
    "}\n"
    "\n"
    "// Bounds and blockers in the kernel at distance d.\n"
    "MSSM_CALLED mssm_split mssm_split_at(MSSM_MAP map, mssm_view v, mssm_options o,\n"
    "                                            mssm_receiver r, float d)\n"
    "{\n"
    "    mssm_moments6 t = mssm_filter_moments(map, v, r, o.moments, d);\n"
    "    if (o.moments == 6) return mssm_split6(mssm_kernel6_stored(t, o.alpha6, r.z_test));\n"
    "    return mssm_split4(mssm_kernel4_stored(t, o.alpha4, r.z_test));\n"
    "}\n"
    "\n"
    "// The published pipeline: one mean blocker depth, one kernel.\n"
    "MSSM_CALLED float mssm_single(MSSM_MAP map, mssm_view v, mssm_options o,\n"
    "                              mssm_receiver r)\n"
    "{\n"
    "    float reach = mssm_cone_reach(map, v, r);\n"
    "    if (reach <= 0.0f) return 1.0f;\n"
    "    mssm_split s = mssm_split_at(map, v, o, r, reach);\n"
    "    float depth = mssm_split_depth(s, r.z_test, 1e-3f, o.estimator == 2 ? 1.0f : 1e-3f);\n"
    "    s = mssm_split_at(map, v, o, r, mssm_min(mssm_blur_distance(v, r, depth), reach));\n"
    "    return mssm_without_leak(map, v, o, r, reach, mssm_split_bounds(s).upper);\n"
    "}\n"
    "\n"
    "MSSM_SHARED float mssm_estimate(MSSM_MAP map, mssm_view v, mssm_options o,\n"
    "                                mssm_receiver r)\n"
    "{\n"
    "    if (r.lit == 1) return 1.0f;\n"
    "    if (o.estimator == 0 || o.estimator == 3) return mssm_layered(map, v, o, r);\n"
    "    return mssm_single(map, v, o, r);\n"
    "}\n"
    // [glsl text end]
    MSSM__ESTIMATE_END;
}

const char *mssm_glsl_lights(void)
{
    return MSSM__GLSL_BEGIN(LIGHTS) MSSM__GLSL_CONSTANT(MSSM_FACE_BAND)
    // [glsl text begin lights] made by "make glsl", do not edit
    "// Faces of mssm_light_point that a receiver asks, and their weights, sum 1. Next to an edge of the\n"
    "// cube two or three faces have a share, so that nothing jumps there; else the others have 0.\n"
    "// clang-format off\n"
    "struct mssm_faces { int face[3]; float weight[3]; };\n"
    "// clang-format on\n"
    "\n"
    "MSSM_SHARED float mssm_face_weight(float v, float largest)\n"
    "{\n"
    "    float size = v < 0.0f ? -v : v;\n"
    "    float w = (size - MSSM_FACE_BAND * largest) / ((1.0f - MSSM_FACE_BAND) * largest);\n"
    "    return w > 0.0f ? mssm_min(w, 1.0f) : 0.0f;\n"
    "}\n"
    "\n"
    "mssm_faces mssm_point_faces(float x, float y, float z)\n"
    "{\n"
    "    mssm_faces r;\n"
    "    float largest = x < 0.0f ? -x : x;\n"
    "    largest = y > largest ? y : (-y > largest ? -y : largest);\n"
    "    largest = z > largest ? z : (-z > largest ? -z : largest);\n"
    "    largest = mssm_max(largest, 1e-30f);\n"
    "    r.face[0] = x < 0.0f ? 1 : 0;\n"
    "    r.face[1] = y < 0.0f ? 3 : 2;\n"
    "    r.face[2] = z < 0.0f ? 5 : 4;\n"
    "    r.weight[0] = mssm_face_weight(x, largest);\n"
    "    r.weight[1] = mssm_face_weight(y, largest);\n"
    "    r.weight[2] = mssm_face_weight(z, largest);\n"
    "    float sum = r.weight[0] + r.weight[1] + r.weight[2];\n"
    "    if (!(sum > 0.0f)) {\n"
    "        r.weight[0] = 1.0f;\n"
    "        sum = 1.0f;\n"
    "    }\n"
    "    for (int i = 0; i < 3; i++) r.weight[i] = r.weight[i] / sum;\n"
    "    return r;\n"
    "}\n"
    "\n"
    "float mssm_attenuation(float distance, float constant, float linear, float quadratic)\n"
    "{\n"
    "    float sum = constant + distance * (linear + distance * quadratic);\n"
    "    return sum > 1e-30f ? 1.0f / sum : 0.0f;\n"
    "}\n"
    "\n"
    "float mssm_cone(float cosine, float cos_inner, float cos_outer, float exponent)\n"
    "{\n"
    "    float x = mssm_min(mssm_max(cosine, -1.0f), 1.0f);\n"
    "    float t = (x - cos_outer) / (cos_inner - cos_outer);\n"
    "    t = t > 0.0f ? mssm_min(t, 1.0f) : 0.0f;\n"
    "    float along = exponent > 0.0f ? (x > 0.0f ? powf(x, exponent) : 0.0f) : 1.0f;\n"
    "    return t > 0.0f ? t * t * (3.0f - 2.0f * t) * along : 0.0f;\n"
    "}\n"
    // [glsl text end]
    MSSM__GLSL_END;
}

#if !defined MSSM_NO_FILTERED && !defined MSSM_NO_GL
static const char *mssm__glsl_filtered(void)
{
    return MSSM__GLSL_BEGIN(FILTERED)
    // [glsl text begin filtered] made by "make glsl", do not edit
    "// Width of a texel at the receiver in units of z.\n"
    "MSSM_SHARED float mssm_texel_at(mssm_view v, mssm_receiver r)\n"
    "{\n"
    "    return v.perspective != 0 ? -v.texel / r.blur_depth : v.texel;\n"
    "}\n"
    "\n"
    "MSSM_SHARED int mssm_beside(mssm_view v, mssm_receiver r)\n"
    "{\n"
    "    float middle = 0.5f * v.side;\n"
    "    return mssm_max(fabsf(r.x - middle), fabsf(r.y - middle)) > middle ? 1 : 0;\n"
    "}\n"
    "\n"
    "// Bounds from Chebyshev moments under a Gaussian and footprint, width texels wide. Of all that is\n"
    "// not at the receiver's depth a share lies beyond it: there its surface goes on, if it is steep or\n"
    "// ends here, and then it rises before the receiver as well. The depth bias is an eighth of a texel\n"
    "// and that share of three quarters of the width. Where nothing lies beyond, more would only light\n"
    "// what is close behind a caster. Occlusion that lacks no more than that counts as all.\n"
    "MSSM_CALLED mssm_bounds mssm_bounds_under(mssm_view v, mssm_options o,\n"
    "                                          mssm_receiver r, mssm_moments6 t, float width,\n"
    "                                          float lack)\n"
    "{\n"
    "    float texel = o.depth_bias > 0.0f ? 0.0f : mssm_texel_at(v, r);\n"
    "    float z = r.z_own - 0.125f * texel;\n"
    "    z = mssm_min(z, r.z_test);\n"
    "    mssm_split s = mssm_split4(mssm_kernel4_stored(t, o.alpha4, z));\n"
    "    float beyond = (1.0f - s.own - s.nearer) / (1.001f - s.own);\n"
    "    z = z - 0.75f * beyond * width * texel;\n"
    "    mssm_bounds b;\n"
    "    if (o.moments == 6) {\n"
    "        b = mssm_split_bounds(mssm_split6(mssm_kernel6_stored(t, o.alpha6, z)));\n"
    "    } else {\n"
    "        b = mssm_split_bounds(mssm_split4(mssm_kernel4_stored(t, o.alpha4, z)));\n"
    "    }\n"
    "    b.lower = mssm_clamp((b.lower - lack) / (1.0f - lack), 0.0f, 1.0f);\n"
    "    b.upper = mssm_clamp((b.upper - lack) / (1.0f - lack), 0.0f, 1.0f);\n"
    "    return b;\n"
    "}\n"
    // [glsl text end]
    MSSM__GLSL_END;
}
#endif

#ifndef MSSM_NO_SCATTERING
const char *mssm_glsl_scattering(void)
{
    return MSSM__GLSL_BEGIN(SCATTERING) MSSM__SCATTERING_NAMES
    // [glsl text begin scattering] made by "make glsl", do not edit
    "// A camera under a light. Scalars only, as mssm_view.\n"
    "struct mssm_scattering {\n"
    "    float axis[9];  // unit: across the light to the middle of the picture, aside, towards the light\n"
    "    float eye[3];   // camera in shadow space\n"
    "    float slope[5]; // shadow-space x, y for each world unit along two axes, world units for each z\n"
    "    float azimuth[2];     // where rows begin, and their range, 2 pi where they go round\n"
    "    float inclination[2]; // of depth 0, and depth in a radian\n"
    "    float extinction;     // per world unit\n"
    "    float fade;           // the same for r: columns scatter equal shares of unshadowed light\n"
    "    float balance;        // see mssm_scattering_visibility\n"
    "};\n"
    "\n"
    "// Where a row is over the map: from r = first on (extent 0: nowhere); shadow-space x, y for each r.\n"
    "// clang-format off\n"
    "struct mssm_epipolar { float first, extent, fade, x, y; };\n"
    "\n"
    "// A view ray: texture coordinates of its row and its last column's end, depth, share of its light\n"
    "// that comes from over the map, weight of the upper bound.\n"
    "struct mssm_view_ray { float row, column, depth, share, upper, balance; };\n"
    "\n"
    "struct mssm_points2 { float z[2], w[2]; };\n"
    "// clang-format on\n"
    "\n"
    "mssm_epipolar mssm_scattering_row(mssm_scattering s, float azimuth)\n"
    "{\n"
    "    float along = cosf(azimuth);\n"
    "    float aside = sinf(azimuth);\n"
    "    mssm_epipolar row;\n"
    "    row.x = along * s.slope[0] + aside * s.slope[2];\n"
    "    row.y = along * s.slope[1] + aside * s.slope[3];\n"
    "    float first = 0.0f;\n"
    "    float last = 1e12f;\n"
    "    for (int k = 0; k < 2; k++) { // clipped by the edges of the map\n"
    "        float slope = k == 0 ? row.x : row.y;\n"
    "        float inverse = 1.0f / (fabsf(slope) > 1e-12f ? slope : 1e-12f);\n"
    "        float a = (-1.0f - s.eye[k]) * inverse;\n"
    "        float b = (1.0f - s.eye[k]) * inverse;\n"
    "        first = mssm_clamp(mssm_min(a, b), first, 1e12f);\n"
    "        last = mssm_clamp(mssm_max(b, a), 0.0f, last);\n"
    "    }\n"
    "    row.first = first;\n"
    "    row.extent = last > first ? last - first : 0.0f;\n"
    "    row.fade = mssm_clamp(s.fade * row.extent, 1e-2f, 1e20f);\n"
    "    return row;\n"
    "}\n"
    "\n"
    "float mssm_scattering_distance(mssm_epipolar row, float column)\n"
    "{\n"
    "    float least = expf(-mssm_min(row.fade, 20.0f)); // light from further off is not missed\n"
    "    float left = 1.0f - mssm_clamp(column, 0.0f, 1.0f) * (1.0f - least);\n"
    "    return row.first - row.extent * logf(mssm_max(left, least)) / row.fade;\n"
    "}\n"
    "\n"
    "// The roots of the kernel without a given depth, u^2 - c u - d: d the variance, c third moment / d.\n"
    "mssm_points2 mssm_reconstruct3(float b1, float b2, float b3)\n"
    "{\n"
    "    float mean = mssm_clamp(b1, -1.0f, 1.0f);\n"
    "    float variance = b2 - mean * mean;\n"
    "    float third = b3 - mean * (mean * mean + 3.0f * variance);\n"
    "    float d = mssm_clamp(variance, 4e-6f, 1.0f);\n"
    "    float c = mssm_clamp(third / d, -2.0f, 2.0f);\n"
    "    float root = sqrtf(c * c + 4.0f * d);\n"
    "    float larger = 0.5f * (fabsf(c) + root); // the root without cancellation\n"
    "    float high = c > 0.0f ? larger : d / larger;\n"
    "    mssm_points2 p;\n"
    "    p.z[0] = mssm_max(mean - d / high, -1.0f);\n"
    "    p.z[1] = mssm_min(mean + high, 1.0f);\n"
    "    p.w[0] = high / root;\n"
    "    p.w[1] = 1.0f - p.w[0];\n"
    "    return p;\n"
    "}\n"
    "\n"
    "float mssm_inclination(mssm_scattering s, float r, float z)\n"
    "{\n"
    "    float left = 1.0f - mssm_clamp(z, -1.0f, 0.9999f); // stretched from MSSM_FAR_CASTER on\n"
    "    float depth = left < 0.2f ? 0.6f + 0.04f / left : 1.0f - left;\n"
    "    float angle = atan2f(r, (depth - s.eye[2]) * s.slope[4]);\n"
    "    return mssm_clamp((angle - s.inclination[0]) * s.inclination[1], -1.0f, 1.0f);\n"
    "}\n"
    "\n"
    "mssm_moments6 mssm_scattering_moments(mssm_scattering s, float r, float b1, float b2, float b3)\n"
    "{\n"
    "    mssm_points2 p = mssm_reconstruct3(b1, b2, b3);\n"
    "    mssm_moments6 m = mssm_moments6_of_depth(mssm_inclination(s, r, p.z[0]));\n"
    "    mssm_moments6 behind = mssm_moments6_of_depth(mssm_inclination(s, r, p.z[1]));\n"
    "    for (int k = 0; k < 6; k++) m.b[k] = p.w[0] * m.b[k] + p.w[1] * behind.b[k];\n"
    "    return m;\n"
    "}\n"
    "\n"
    "mssm_view_ray mssm_scattering_ray(mssm_scattering s, float x, float y, float z, float distance)\n"
    "{\n"
    "    float along = s.axis[0] * x + s.axis[1] * y + s.axis[2] * z;\n"
    "    float aside = s.axis[3] * x + s.axis[4] * y + s.axis[5] * z;\n"
    "    float up = s.axis[6] * x + s.axis[7] * y + s.axis[8] * z;\n"
    "    float across = sqrtf(along * along + aside * aside); // r for each unit of distance\n"
    "    float azimuth = across > 0.0f ? atan2f(aside, along) : 0.0f;\n"
    "    mssm_epipolar row = mssm_scattering_row(s, azimuth);\n"
    "    float all = mssm_clamp(distance, 1e-6f, 1e12f);\n"
    "    float part = mssm_clamp(all * across - row.first, 0.0f, row.extent);\n"
    "    float cosecant = 1.0f / mssm_max(across, 1e-6f);\n"
    "    float enter = mssm_clamp(row.first * cosecant, 0.0f, all);\n"
    "    float leave = mssm_clamp((row.first + row.extent) * cosecant, enter, all);\n"
    "    float e = mssm_clamp(s.extinction, 1e-3f / all, 1e20f);\n"
    "    float angle = atan2f(across, up);\n"
    "    mssm_view_ray r;\n"
    "    r.row = (azimuth - s.azimuth[0]) / s.azimuth[1];\n"
    "    r.column = row.extent > 0.0f ? 1.0f - expf(-row.fade * part / row.extent) : 0.0f;\n"
    "    r.column = r.column / (1.0f - expf(-row.fade));\n"
    "    r.depth = mssm_clamp((angle - s.inclination[0]) * s.inclination[1], -1.0f, 1.0f);\n"
    "    r.share = (expf(-e * enter) - expf(-e * leave)) / (1.0f - expf(-e * all));\n"
    "    r.share = mssm_clamp(row.extent > 0.0f ? r.share : 0.0f, 0.0f, 1.0f);\n"
    "    r.upper = mssm_clamp(0.5f - 0.5f * up, 0.0f, 1.0f);\n"
    "    r.balance = s.balance;\n"
    "    return r;\n"
    "}\n"
    "\n"
    "float mssm_scattering_visibility(mssm_view_ray ray, mssm_moments6 m)\n"
    "{\n"
    "    mssm_bounds b = mssm_visibility6(m, ray.depth);\n"
    "    float sure = b.lower + (1.0f - b.upper);\n"
    "    float lit = sure > 1e-6f ? b.lower / sure : 0.5f;\n"
    "    float upper = mssm_clamp(ray.upper + ray.balance * (lit - ray.upper), 0.0f, 1.0f);\n"
    "    return 1.0f - ray.share * (1.0f - (b.lower + upper * (b.upper - b.lower)));\n"
    "}\n"
    // [glsl text end]
    MSSM__SCATTERING_FORGET MSSM__GLSL_END;
}
#endif

#if defined __GNUC__
#pragma GCC diagnostic pop
#endif

#ifdef __cplusplus
}
#endif

#if defined MSSM__PRECISE_MATH && defined __clang__
#pragma float_control(pop)
#elif defined MSSM__PRECISE_MATH
#pragma GCC pop_options
#endif

#endif  // MSSM_IMPLEMENTATION_DONE
#endif  // MSSM_IMPLEMENTATION
