// lightprobe.h - v0.2 - area lights from a light probe - MIT or public domain (see >>licence)
// SPDX-License-Identifier: MIT OR Unlicense
//
// Turns an environment cube map into a few area lights: direction, rectangle, colour, and the
// opening angle of a disc for shading. They are chosen for the shadows that they cast: a sun is
// told from its haze with 8 lights. They hold all the energy of the probe, do not care where the
// faces of the cube meet, and follow a moving probe without jumping. On the CPU, and the same in
// OpenGL 4.5 compute shaders; how surfaces reflect the lights is there in C and GLSL. No dependency
// but the C standard library.
//
// QUICK START
//
// In ONE source file (in all others only the #include):
//
//     #define LIGHTPROBE_IMPLEMENTATION
//     #include "lightprobe.h"
//
// At most 16 lights from six faces of 128 x 128 RGB floats:
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
// CONTENTS: search for the mark. Calls come first, then what is behind them in the same order
//
//   >>light calls       lights of a cube map          >>math >>angles >>scratch >>vectors >>specular
//                                                     >>tiles >>cells >>leaves >>clusters >>lights
//                                                     >>median cut >>extraction
//   >>gl calls          the OpenGL 4.5 half           >>texts >>gl >>shaders >>plumbing >>state >>updates
//   >>picture calls     panoramas, crosses, strips    >>pictures >>panoramas >>crosses >>without
//   >>licence           references, licence
//   >>generated         quoted GLSL: nothing to read, nothing to edit
//
// GLSL TEXTS, after #version in this order
//
//   lightprobe_glsl_math()     disc irradiance, harmonics
//   lightprobe_glsl_lights()   the buffer of lights. Texts of mssm.h come before it
//   lightprobe_glsl_specular() what shiny surfaces reflect of them
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
//   LIGHTPROBE_STATIC           in the only file that uses it: the functions are static
//   LIGHTPROBE_API              everywhere: what stands before each function, __declspec(dllexport) say
//   LIGHTPROBE_NO_GL            there: without the OpenGL half (which needs no GL header or library)
//   LIGHTPROBE_MALLOC(bytes), LIGHTPROBE_FREE(memory)   there: memory of the OpenGL half, else malloc
//
// Threads: no global state; calls with different scratch memory may run in parallel.

#ifndef LIGHTPROBE_H
#define LIGHTPROBE_H

#include <stddef.h>

#define LIGHTPROBE_VERSION 200 // 10000 * major + 100 * minor + patch: 0.2.0

#ifndef LIGHTPROBE_API
#ifndef LIGHTPROBE_STATIC
#define LIGHTPROBE_API
#elif defined __GNUC__
#define LIGHTPROBE_API static __attribute__((unused))
#else
#define LIGHTPROBE_API static
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

// ---- Lights of a cube map ---- >>light calls

typedef enum lightprobe_result {
    LIGHTPROBE_OK = 0,
    LIGHTPROBE_ERROR_NULL,     // a pointer that must be given is null
    LIGHTPROBE_ERROR_SIDE,     // side below 1 or above LIGHTPROBE_MAX_SIDE
    LIGHTPROBE_ERROR_CHANNELS, // neither 3 nor 4, or no fourth one for distances
    LIGHTPROBE_ERROR_LIGHTS,   // max_lights, previous_count: below 0, or above the largest number
    LIGHTPROBE_ERROR_SETTINGS, // a setting out of its range; a texture unit or binding that the driver lacks
    LIGHTPROBE_ERROR_SCRATCH,    // scratch memory below lightprobe_scratch_bytes()
    LIGHTPROBE_ERROR_MEMORY,     // LIGHTPROBE_MALLOC gave none
    LIGHTPROBE_ERROR_GL_VERSION, // the context is below OpenGL 4.5
    LIGHTPROBE_ERROR_GL,         // the driver refused storage or a shader
    LIGHTPROBE_ERROR_TEXTURE,    // not a whole cube map of colours with a level of this side
    LIGHTPROBE_ERROR_NOT_READY,  // the GPU has not finished any lights
    LIGHTPROBE_ERROR_ORDER,      // transform feedback is active, GL allows nothing else then
    LIGHTPROBE_ERROR_IMAGE       // a picture without texels, or whose proportions fit no layout
} lightprobe_result;

// A sentence for people, never null, also for numbers that are no result.
LIGHTPROBE_API const char *lightprobe_result_string(lightprobe_result result);

#define LIGHTPROBE_MAX_SIDE 8192
#define LIGHTPROBE_MAX_LIGHTS 4096
#define LIGHTPROBE_GL_MAX_LIGHTS 1024 // as many as one work group divides on every driver
#define LIGHTPROBE_DEFAULT_LIGHTS 32
#define LIGHTPROBE_DEFAULT_TOLERANCE 0.02f // one disc of 12 degrees around its centre

// The probe. The caller keeps the texels; they are read only.
typedef struct lightprobe_cube {
    const float *face[6];
    int side;
    int channels; // floats per texel, 3 or 4; the fourth is skipped, or a distance: lightprobe_settings
} lightprobe_cube;

typedef struct lightprobe_light {
    float direction[3];         // unit; that of the region's vector irradiance
    float axis_u[3], axis_v[3]; // unit, orthogonal to direction and each other; u: the longer side
    float tan_half_u, tan_half_v; // half-size of the rectangle at distance 1, at most 4
    float irradiance[3];          // integral of RGB radiance over the region's solid angle
    float solid_angle; // of the region, 0 of what fades out; they sum to 4 pi less what is black
    float cos_alpha;   // opening angle of the disc that stands for it in shading
    int id;            // survives from frame to frame: lightprobe_settings.previous
    float distance;    // from the probe's centre, world units; 0: infinitely far
    // Of a flat emitter: by how much it recedes from the probe per length along axis_u and axis_v,
    // at most 2.4. 0 where it faces the probe, where no plane fits and without distances.
    float slope_u, slope_v;
    float state[18]; // what the next frame goes on from; of no other use
} lightprobe_light;

typedef enum lightprobe_mode {
    LIGHTPROBE_BEST = 0,
    // The paper's way (sections 3.1 and 4.1), for comparison. Its axes are the face's, projected:
    // not always the longer first, and up to 30 degrees askew towards a corner of the cube.
    LIGHTPROBE_MEDIAN_CUT = 1
} lightprobe_mode;

// Zero means default everywhere.
typedef struct lightprobe_settings {
    int max_lights;  // 0: as many as the probe needs, at most LIGHTPROBE_DEFAULT_LIGHTS
    float tolerance; // no more lights once their error (lightprobe_stats) is at most this; 0: use
                     // all of max_lights or, where that is 0 too, LIGHTPROBE_DEFAULT_TOLERANCE
    int mode;        // lightprobe_mode
    float min_share; // what has a smaller share of the probe's luminance is left to the residual
    // The weakest lights, dim or wide, are left to the residual too, a map less for each, while the
    // shadows lost change irradiance behind a random edge by at most this, in parts as tolerance.
    float min_shadow;
    // All lights of the previous frame, for a probe that moves: the new ones go on from them, keep
    // order and ids, and change in number or region only where that pays. Changes fade over 32
    // frames, or 8 degrees of the lights' own way where they move faster, unless the map's light
    // changed by a tenth or min_share or min_shadow leave lights out: the tolerance may be met some
    // frames late. May be the array that receives the new lights. NULL: start afresh, brightest
    // first. Ignored by LIGHTPROBE_MEDIAN_CUT.
    const lightprobe_light *previous;
    int previous_count;
    void (*log)(void *user, const char *message); // told in one line why a call failed; or NULL
    void *user;
    // Gives lights a place. 1: the cube's fourth channel is the distance of what the texel shows
    // from the probe's centre, in world units; what is not in [1e-9, 1e9], NaN say, is infinitely
    // far. 2: it is luminance over that distance, for cubes with several samples a texel or mip
    // maps: means of that keep lamps where they are, those of distances put edges too far off.
    int distances;
} lightprobe_settings;

typedef struct lightprobe_stats {
    float total[3];          // irradiance[] of the whole probe, bad channels counting as 0
    float residual[3];       // what the lights do not carry, total - their sum
    float residual_sh[9][3]; // of it, for lightprobe_residual_irradiance
    // Estimate of the root mean square error of irradiance behind a random half-space (its border
    // any great circle; receivers of all orientations), in parts of the mean when nothing stands in
    // between. Of 303 probes with 4 to 64 lights within 15% in 95% of the cases, at worst 27% too
    // low or 34% too high; with one light mostly 40% too high. An estimate below .002 may be a
    // quarter of the true error, below .005 three quarters. Of LIGHTPROBE_MEDIAN_CUT: mean half
    // square angle to a light's centre.
    float error;
    int lights;          // how many were written
    int repaired_texels; // with a negative, NaN or infinite channel; that channel counts as 0
} lightprobe_stats;

// Bytes of scratch memory for probes of this side and up to max_lights lights (0: the default):
// about 19 side^2, 650 a light and 37,000. 0 where side or max_lights is out of range.
LIGHTPROBE_API size_t lightprobe_scratch_bytes(int side, int max_lights);

// Finds the lights of a probe. lights has room for settings->max_lights; settings may be NULL (all
// defaults), stats too; scratch may have any alignment, and what it holds afterwards is of no use.
//
// The lights carry all of the probe: each texel belongs to one (with settings->previous, those
// between lights are shared), and the residual is rounding (1e-7 of total, of either sign) unless
// min_share, min_shadow, or LIGHTPROBE_MEDIAN_CUT with fewer than six lights, left something out.
// There are fewer than asked for where texels run out or the tolerance is met, none for black ones,
// whose luminance sums to less than 1.6e-29.
//
// Deterministic. Radiance times a power of two changes irradiance, total and residual so, and
// nothing else, bit for bit. Any finite texel is fine; sums beyond the range of float come out as
// FLT_MAX. A failure leaves lights, light_count and stats untouched.
LIGHTPROBE_API lightprobe_result lightprobe_extract(const lightprobe_cube *cube,
                                                    const lightprobe_settings *settings,
                                                    void *scratch, size_t scratch_bytes,
                                                    lightprobe_light *lights, int *light_count,
                                                    lightprobe_stats *stats);

// Solid angle of a texel of any face, to 1e-7 relative at every side (van Oosterom and Strackee
// 1983). The sum over six faces is 4 pi. 0 outside the face.
LIGHTPROBE_API float lightprobe_texel_solid_angle(int side, int x, int y);

// Unit direction of the point (s, t) in [-1,1]^2 of a face 0..5; others count as the nearest.
LIGHTPROBE_API void lightprobe_texel_direction(int face, float s, float t, float direction[3]);

// Irradiance of a surface under a disc light of uniform radiance with half-angle alpha whose centre
// is theta away from the surface's normal, per unit of lightprobe_light.irradiance. Exact, also
// where the horizon cuts the disc or it is wider than a hemisphere; above the horizon the paper's
// Eq. 18, cos(theta) cos^2(alpha/2). In [0,1], error below 1e-6. Arguments outside [-1,1] count as
// the nearest inside.
LIGHTPROBE_API float lightprobe_disc_irradiance(float cos_alpha, float cos_theta);

// A light at a finite distance for a receiver that stands (x, y, z) from the probe's centre: with
// direction, irradiance and cos_alpha as seen from there, for lightprobe_disc_irradiance; the rest
// stays. The emitter is taken for a disc with the light's slopes: its vector irradiance is exact,
// at most pi times its radiance, and nothing comes from behind it. Slopes count as at most 4, of
// axes that are unit and orthogonal, and as what so wide a disc can have (docs/lightprobe.md).
// Just before its plane, within a tenth of its radius, it fades out (docs/lightprobe.md). Lights at
// infinity (distances up to 1e-30) or of half-angles from 89.95 degrees on stay. Finite numbers give
// finite ones, at least 0, for cos_alpha in [-1,1] and irradiance from 0 to 1e26.
LIGHTPROBE_API lightprobe_light lightprobe_light_at(lightprobe_light light, float x, float y,
                                                    float z);
// The same for emitters that shine to all sides alike, lamps without a shade say, which only the
// caller knows: the light is taken for a sphere as wide as its disc.
LIGHTPROBE_API lightprobe_light lightprobe_sphere_at(lightprobe_light light, float x, float y,
                                                     float z);

// How a surface reflects light towards a viewer without scattering it inside: GGX with
// height-correlated Smith shadowing and Schlick's Fresnel term, a single bounce. Made once a point,
// for all lights.
typedef struct lightprobe_lobe {
    float normal[3], view[3], away[3], f0[3]; // away: unit, along the surface, from the viewer
    float along, across, shear, width;        // matrix from directions of light to a cosine lobe
    float whole, fresnel; // sum over all directions where f0 is 1; Fresnel term, mean less middle
} lightprobe_lobe;

// normal and view (to the viewer) are unit vectors; alpha is GGX's, often the square of an artist's
// roughness, in [0.02,1]; f0 the reflectance at normal incidence, 0.04 for most that is no metal.
// What is out of range counts as the nearest number inside, a viewer below the surface as one along
// it.
LIGHTPROBE_API lightprobe_lobe lightprobe_specular_lobe(const float normal[3], const float view[3],
                                                        float alpha, const float f0[3]);

// Radiance to the viewer from one light, nothing in between, at a surface (x, y, z) from the
// probe's centre, which matters where the light has a distance. The light, as extracted and not as
// lightprobe_light_at gives it, looks from the probe like a uniform rectangle in a plane at
// cos_alpha, its half-sizes the sines for tan_half_u and tan_half_v (0.001 to 4), up to the whole
// sphere; it lies in the plane of its slopes. Its part of the lobe is exact, also where the horizon
// cuts it; the lobe is a linearly transformed cosine (Heitz, Dupuy, Hill, Neubelt 2016; errors:
// docs/lightprobe.md). At least 0, and at most the light's radiance, for any finite arguments.
LIGHTPROBE_API void lightprobe_specular(lightprobe_light light, lightprobe_lobe lobe, float x,
                                        float y, float z, float rgb[3]);

// Irradiance, at least 0, of a surface with this unit normal from what the lights do not carry, in
// no shadow: add it to that of the lights, nothing is counted twice. From nine spherical harmonics.
LIGHTPROBE_API void lightprobe_residual_irradiance(const lightprobe_stats *stats,
                                                   const float normal[3], float rgb[3]);

// GLSL 4.50 text with the same lightprobe_disc_irradiance, to put after #version; static memory.
LIGHTPROBE_API const char *lightprobe_glsl_math(void);

#if !(defined LIGHTPROBE_STATIC && defined LIGHTPROBE_NO_GL) // a static function must be defined
// ---- OpenGL 4.5: the same lights from a cube-map texture, without a trip to the CPU ---- >>gl calls
//
//     lightprobe_gl_desc desc = {0};
//     desc.load = my_get_proc_address;                 // of GLFW, SDL, EGL ...
//     desc.side = 128;
//     desc.max_lights = 32;
//     lightprobe_gl *probe;
//     if (lightprobe_gl_create(&probe, &desc)) return 0;
//     ... each frame:
//     lightprobe_gl_update(probe, cube_texture);
//     lightprobe_gl_read(probe, 0, lights, &count, NULL);    // for the frusta of the depth passes
//     lightprobe_gl_range r = lightprobe_gl_lights(probe, 1); // for the shading: the same lights
//     glBindBufferRange(GL_SHADER_STORAGE_BUFFER, 0, r.buffer, r.offset, r.bytes);
//
// Arithmetic and order are those of lightprobe_extract: where neither compiler fuses a * b + c and
// the GPU rounds quotients and roots as C does, the lights are the same; else some cut is another
// one, as good. No shader takes doubles. Every call wants the context current that it was created
// in (or one that shares its objects), leaves GL's state as it found it and raises no GL error. Not
// with transform feedback active (LIGHTPROBE_ERROR_ORDER), nor between glBeginConditionalRender and
// its end, which GL cannot be asked about.

typedef void (*lightprobe_gl_function)(void);
typedef lightprobe_gl_function (*lightprobe_gl_loader)(const char *name);
typedef struct lightprobe_gl lightprobe_gl;

typedef struct lightprobe_gl_desc {
    lightprobe_gl_loader load;
    int side;       // of the faces; 0: 128. A texture is read at the mip level of this side
    int max_lights; // these four as in lightprobe_settings, but at most LIGHTPROBE_GL_MAX_LIGHTS
    float tolerance;
    float min_share;
    float min_shadow;
    int first_texture_unit;   // this one, and six shader storage bindings from first_buffer_binding
    int first_buffer_binding; // on, are used inside lightprobe_gl_update and then put back
    void (*log)(void *user, const char *message); // told why a call failed, shader logs; or NULL
    void *user;
    int distances; // as in lightprobe_settings: in the texture's alpha
} lightprobe_gl_desc;

typedef struct lightprobe_gl_range { // for glBindBufferRange
    unsigned buffer;
    ptrdiff_t offset, bytes;
} lightprobe_gl_range;

// *gl is untouched on failure, and nothing is left behind.
LIGHTPROBE_API lightprobe_result lightprobe_gl_create(lightprobe_gl **gl,
                                                      const lightprobe_gl_desc *desc);
LIGHTPROBE_API void lightprobe_gl_destroy(lightprobe_gl *gl); // NULL is fine

// Finds the lights of a cube-map texture, or of a view of six layers of an array of these, of any
// colour format that can be sampled as float; its swizzle counts, its filters do not. Never waits.
// Goes on from the update before (lightprobe_settings.previous). What image stores wrote needs
// glMemoryBarrier first.
LIGHTPROBE_API lightprobe_result lightprobe_gl_update(lightprobe_gl *gl, unsigned cube_texture);
// The next update starts afresh, brightest light first: after a change of scene.
LIGHTPROBE_API void lightprobe_gl_restart(lightprobe_gl *gl);

// The lights that the GPU has finished last, for the CPU: mssm_light_directional() takes direction,
// axis_u, tan_half_u and tan_half_v. Without wait this does not stall and is about one frame late,
// or LIGHTPROBE_ERROR_NOT_READY before there are any; with wait they are those of the last update.
// A failure leaves lights, light_count and stats untouched. lights has room for max_lights; stats
// may be NULL.
LIGHTPROBE_API lightprobe_result lightprobe_gl_read(lightprobe_gl *gl, int wait,
                                                    lightprobe_light *lights, int *light_count,
                                                    lightprobe_stats *stats);

// Where the lights are in GPU memory: those of the last update, or (as_read) those that the last
// lightprobe_gl_read gave out, which shading should use together with depth maps made from them.
// Good for two more updates. Written by shaders, with the barrier for reading it already done.
LIGHTPROBE_API lightprobe_gl_range lightprobe_gl_lights(const lightprobe_gl *gl, int as_read);

// GLSL 4.50 text, to put after #version and lightprobe_glsl_math(): the buffer with
// lightprobe_count, lightprobe_lights[] (members as in C), lightprobe_error, lightprobe_total and
// lightprobe_residual, at binding LIGHTPROBE_BINDING (0 unless defined before), and
//     vec3 lightprobe_irradiance(int light, vec3 normal)  // times visibility; nothing in between
//     vec3 lightprobe_irradiance(int light, vec3 offset, vec3 normal)  // lightprobe_light_at
//     vec3 lightprobe_sphere_irradiance(int light, vec3 offset, vec3 normal)  // lightprobe_sphere_at
//     vec3 lightprobe_residual_irradiance(vec3 normal)    // what the lights do not carry
LIGHTPROBE_API const char *lightprobe_glsl_lights(void);

// Text to put after lightprobe_glsl_lights(), for shaders that want it: lightprobe_lobe and
//     lightprobe_lobe lightprobe_specular_lobe(vec3 normal, vec3 view, float alpha, vec3 f0)
//     vec3 lightprobe_specular(int light, lightprobe_lobe lobe)  // times visibility
//     vec3 lightprobe_specular(int light, vec3 offset, lightprobe_lobe lobe)  // from the probe's centre
LIGHTPROBE_API const char *lightprobe_glsl_specular(void);

// With LIGHTPROBE_UNIFORMS defined before, as a number of lights, lightprobe_glsl_lights needs no
// lightprobe_gl but GLSL from 330 or 300 es on: the buffer is the uniform block lightprobe_buffer,
// of 192 bytes and 80 a light. This fills it in from what lightprobe_extract found. Fails, with
// block untouched, if a pointer is null (lights may be, without any) or, LIGHTPROBE_ERROR_LIGHTS,
// if count is below 0 or too many.
LIGHTPROBE_API lightprobe_result lightprobe_uniforms(const lightprobe_light *lights, int count,
                                                     const lightprobe_stats *stats, void *block,
                                                     size_t bytes);
#endif // LIGHTPROBE_STATIC, LIGHTPROBE_NO_GL

// ---- Pictures of probes: from panoramas, crosses and strips to cubes; cubes without lights ---- >>picture calls
//
//     lightprobe_image panorama = {pixels, 4096, 2048, 3, 0, LIGHTPROBE_AUTO};
//     static float texels[18 * 128 * 128];
//     lightprobe_cube cube;
//     lightprobe_cube_from_image(&panorama, 128, texels, &cube, NULL);

typedef enum lightprobe_layout {
    LIGHTPROBE_AUTO = 0, // by its proportions: 2:1 to a pixel is a panorama, the others exactly
    LIGHTPROBE_LAT_LONG, // a panorama of any size: the top is +Y, the middle -Z, right of it is +X
    LIGHTPROBE_CROSS,    // 4:3, -X +Z +X -Z from left to right and +Y and -Y above and below +Z; or
                         // 3:4, where -Z is below -Y, upside down
    LIGHTPROBE_STRIP     // 1:6 or 6:1, the faces in their order
} lightprobe_layout;

typedef struct lightprobe_image {
    const void *texels; // rows from top to bottom, tightly packed; read only
    int width, height;  // up to LIGHTPROBE_MAX_IMAGE
    int channels;       // 1 (grey), 3, or 4, of which the fourth is skipped
    int half;           // 0: floats; 1: half floats, as uint16_t
    int layout;         // lightprobe_layout
} lightprobe_image;

#define LIGHTPROBE_MAX_IMAGE 32768

// Side of the faces in a cross or strip; a quarter of a panorama's width, at least 1; 0: no layout.
LIGHTPROBE_API int lightprobe_image_side(const lightprobe_image *image);

// Fills texels, 18 side^2 floats, with the means of the picture over the solid angles of the cube's
// texels, of any sizes: areas are exact, so that the energy is the picture's to 1e-6. Faces of the
// same side are copied. cube, unless NULL, is set to texels. Negative and NaN channels count as 0,
// infinite ones (suns that a half float could not hold) as 65504 or the picture's largest number if
// that is more; *repaired, unless NULL, says how many pixels had one. Takes about 0.2 s for 128^2
// texels from 1024 x 512 pixels, 3 s from 8192 x 4096. A failure leaves everything untouched.
LIGHTPROBE_API lightprobe_result lightprobe_cube_from_image(const lightprobe_image *image, int side,
                                                            float *texels, lightprobe_cube *cube,
                                                            int *repaired);

// What lights leave of the probe that they were found in, for engines that shade the rest with a
// prefiltered environment of their own: fills texels, 18 side^2 floats, with the cube less
// irradiance[] of each light, channel by channel and to 1e-5 of it. Taken off are the peaks within
// the light's rectangle, and around where that holds too little; nothing becomes negative. Bad
// channels of the cube count as 0.
LIGHTPROBE_API lightprobe_result lightprobe_cube_without(const lightprobe_cube *cube,
                                                         const lightprobe_light *lights, int count,
                                                         float *texels);

#ifdef __cplusplus
}
#endif

#endif // LIGHTPROBE_H

// ================================================================================================
// Stop here if you only use the library: below is the implementation.
// ================================================================================================

#if defined LIGHTPROBE_IMPLEMENTATION && !defined LIGHTPROBE_IMPLEMENTED
#define LIGHTPROBE_IMPLEMENTED

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

// With -ffast-math compilers take NaN for a number and add in any order: not in here. Clang 14
// obeys for x86 and s390x; elsewhere it warns.
#if defined __FINITE_MATH_ONLY__ && __FINITE_MATH_ONLY__
#define LIGHTPROBE__PRECISE_MATH
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

// ---- Disc irradiance, shared with GLSL ---- >>math

// What stands between the [glsl] markers is written in the subset that C99 and GLSL 4.50 share and
// is quoted by `make glsl` at the end (>>generated), one text for every program that needs it. So
// structs go in and out by value, what w points to lies in buffers there (the quote has no w), and
// these names stand for what the languages call differently.
#define LIGHTPROBE_SHARED static inline
#define LIGHTPROBE_PRECISE       // in GLSL: nothing may be fused or reordered
#define LIGHTPROBE_INOUT         // in GLSL: what the function changes,
#define LIGHTPROBE_OUT           // or makes
#define LIGHTPROBE_ROLLED(n) (n) // in GLSL: rounds of a loop that is not to be unrolled
#define LIGHTPROBE_FLOAT(x) ((float)(x))
#define LIGHTPROBE_INT(x) ((int)(x))
typedef float lightprobe_vec3[3], lightprobe_vec4[4];
// Sums that keep more digits than their floats; in GLSL two floats, since many GPUs have no double.
typedef double lightprobe_wide;
#define LIGHTPROBE_ZERO 0.0
#define LIGHTPROBE_ADD(sum, x) ((sum) += (double)(x))
#define LIGHTPROBE_VALUE(sum) ((float)(sum))

// [glsl begin]

// The angle of the point (x, y) with y >= 0 to the x axis, in [0, pi], to 3e-7. Written out
// (Hastings' polynomial) since GLSL allows its own atan 4096 units in the last place.
LIGHTPROBE_SHARED float lightprobe_angle(float y, float x)
{
    float ax = fabsf(x);
    float most = ax < y ? y : ax;
    float t = (ax < y ? ax : y) / (most + 1e-37f);
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
    return e > 0.0f ? e : 0.0f; // at most 0.65
}
// [glsl end]

// [glsl begin places]
// Vector irradiance of a disc over pi * radiance * radius2, seen from height below its plane and
// aside from its axis: along the axis, and towards it per distance from it; its length.
typedef struct lightprobe_disc {
    float facing, inward, size;
} lightprobe_disc;

LIGHTPROBE_SHARED lightprobe_disc lightprobe_disc_from(float height, float aside2, float radius2)
{
    lightprobe_disc o;
    float beyond = height * height + aside2 - radius2;
    float root = sqrtf(beyond * beyond + 4.0f * radius2 * height * height) + 1e-12f;
    o.facing = 2.0f * height * height / (root * (root + beyond));
    if (beyond <= 0.0f) o.facing = 0.5f * (1.0f - beyond / root) / (radius2 + 1e-12f);
    o.inward = 2.0f * height / (root * (root + beyond + 2.0f * radius2));
    o.size = sqrtf(o.facing * o.facing + o.inward * o.inward * aside2);
    return o;
}

// What counts of a wide light just before its plane, or who crosses that would see it at once.
LIGHTPROBE_SHARED float lightprobe_fade_in(float height, float radius2)
{
    float whole = 0.1f * sqrtf(radius2 < 1.0f ? radius2 : 1.0f);
    return height < whole ? (height > 0.0f ? height / whole : 0.0f) : 1.0f;
}

lightprobe_light lightprobe_light_at(lightprobe_light light, float x, float y, float z)
{
    lightprobe_light seen = light;
    float c = light.cos_alpha, scale = light.distance > 1e-30f ? 1.0f / light.distance : 0.0f;
    if (!(scale > 0.0f) || !(c > 1e-3f)) return seen;
    // In units of the distance: height over the disc, squared distance from its axis, radius2.
    float u = light.slope_u > -4.0f ? (light.slope_u < 4.0f ? light.slope_u : 4.0f) : -4.0f;
    float v = light.slope_v > -4.0f ? (light.slope_v < 4.0f ? light.slope_v : 4.0f) : -4.0f;
    float tilt2 = u * u + v * v, steep = tilt2 / (1.0f + sqrtf(1.0f + tilt2)), height = 0.0f;
    float first = (1.0f - c) * (1.0f + c), c2 = c * c, flatter = 1.0f, aside2 = 0.0f;
    if (steep * first > 0.875f * c2) { // some discs are too wide to be as steep
        steep = 0.875f * c2 / first;
        flatter = sqrtf(steep * (2.0f + steep) / tilt2);
        tilt2 = steep * (2.0f + steep);
    }
    // The one disc in this plane whose vector irradiance at the probe is the light's: turned away
    // larger, and further, since its nearer half looks larger than the other (docs/lightprobe.md).
    float slant = 1.0f + steep, gap = c2 - steep * first;
    float radius2 = first * (c2 + steep) / (gap * gap);
    float off = first / (slant * gap), up = 1.0f + off * tilt2;
    float axis[3], aside[3];
    for (int i = 0; i < 3; i++) {
        float tilt = flatter * (u * light.axis_u[i] + v * light.axis_v[i]);
        axis[i] = (light.direction[i] - tilt) / slant;
        aside[i] = up * light.direction[i] + off * tilt - scale * (i == 0 ? x : i == 1 ? y : z);
        height += aside[i] * axis[i];
    }
    for (int i = 0; i < 3; i++) {
        aside[i] -= height * axis[i];
        aside2 += aside[i] * aside[i];
    }
    lightprobe_disc o = lightprobe_disc_from(height, aside2, radius2);
    float sine2 = o.size * radius2;
    float bright = 0.0f; // behind it, or too far
    if (height > 0.0f && o.size > 1e-12f) bright = o.size * lightprobe_fade_in(height, radius2);
    seen.cos_alpha = sine2 < 1.0f ? sqrtf(1.0f - sine2) : 0.0f; // a disc with this irradiance
    float part = bright * (c2 + steep) / (gap * gap) * (1.0f + c) / (1.0f + seen.cos_alpha);
    for (int i = 0; i < 3; i++) {
        if (bright > 0.0f) seen.direction[i] = (o.facing * axis[i] + o.inward * aside[i]) / o.size;
        seen.irradiance[i] = part * light.irradiance[i];
    }
    return seen;
}

lightprobe_light lightprobe_sphere_at(lightprobe_light light, float x, float y, float z)
{
    lightprobe_light seen = light;
    float c = light.cos_alpha, radius2 = (1.0f - c) * (1.0f + c);
    float scale = light.distance > 1e-30f ? 1.0f / light.distance : 0.0f;
    if (!(scale > 0.0f) || !(c > 1e-3f)) return seen;
    // The probe sees its surface, of a small one on average 2/3 of the radius before its centre. In
    // units of the centre's distance: the way there, its square, and the radius' square.
    scale *= 1.0f - 0.6666667f * sqrtf(radius2);
    float a = light.direction[0] - scale * x, b = light.direction[1] - scale * y;
    float d = light.direction[2] - scale * z, away2 = a * a + b * b + d * d + 1e-12f;
    float away = away2 < 1e30f ? sqrtf(away2) : 0.0f, outside = radius2 < away2 ? away2 : radius2;
    seen.cos_alpha = sqrtf(1.0f - radius2 / outside);
    // Solid angle over solid angle; of a point the inverse square.
    float part = (1.0f + c) / ((1.0f + seen.cos_alpha) * outside);
    for (int i = 0; i < 3; i++) {
        float way = i == 0 ? a : i == 1 ? b : d;
        if (away > 0.0f) seen.direction[i] = way / away;
        seen.irradiance[i] = away > 0.0f ? part * light.irradiance[i] : 0.0f;
    }
    return seen;
}
// [glsl end]

// [glsl begin harmonics]

// Function number i of nine that sum up to irradiance: the real spherical harmonics of order 0, 1
// and 2 at a unit vector, without their constants.
LIGHTPROBE_SHARED float lightprobe_harmonic(int i, float x, float y, float z)
{
    if (i < 4) return i == 0 ? 1.0f : i == 1 ? y : i == 2 ? z : x;
    if (i == 6) return 3.0f * z * z - 1.0f;
    return i == 4 ? x * y : i == 5 ? y * z : i == 7 ? z * x : x * x - y * y;
}

// What a disc in direction (x, y, z) adds to number i per unit of its irradiance. The clamped
// cosine is 1/4 + cos/2 + 5/32 (3 cos^2 - 1) to order 2; the disc weakens order 1 and 2.
LIGHTPROBE_SHARED float lightprobe_harmonic_weight(int i, float cos_alpha, float x, float y,
                                                   float z)
{
    float half_sum = 0.5f * (1.0f + cos_alpha);
    float weight = i == 6 ? 0.078125f : i == 8 ? 0.234375f : 0.9375f;
    if (i == 0) return 0.25f;
    weight = i < 4 ? 0.5f * half_sum : weight * cos_alpha * half_sum;
    return weight * lightprobe_harmonic(i, x, y, z);
}
// [glsl end]

void lightprobe_residual_irradiance(const lightprobe_stats *stats, const float normal[3],
                                    float rgb[3])
{
    float sum[3] = {0, 0, 0};
    for (int i = 0; i < 9; i++) {
        const float y = lightprobe_harmonic(i, normal[0], normal[1], normal[2]);
        for (int c = 0; c < 3; c++) sum[c] += y * stats->residual_sh[i][c];
    }
    for (int c = 0; c < 3; c++) rgb[c] = sum[c] > 0 ? sum[c] : 0;
}

// ---- Directions and solid angles ---- >>angles

// [glsl begin cells]
// Vector with components along a face's middle, +s and +t. 0 is added so that nothing becomes -0.
LIGHTPROBE_SHARED void lightprobe_to_world(int face, float m, float s, float t,
                                           LIGHTPROBE_OUT lightprobe_vec3 v)
{
    int axis = face / 2;
    float sign = face % 2 == 0 ? 1.0f : -1.0f;
    v[0] = 0.0f + (axis == 0 ? sign * m : face == 5 ? -s : s);
    v[1] = 0.0f + (axis == 1 ? sign * m : -t);
    v[2] = 0.0f + sign * (axis == 0 ? -s : axis == 1 ? t : m);
}

void lightprobe_texel_direction(int face, float s, float t,
                                LIGHTPROBE_OUT lightprobe_vec3 direction)
{
    LIGHTPROBE_PRECISE float scale = 1.0f / sqrtf(1.0f + s * s + t * t);
    int nearest = face < 0 ? 0 : face < 5 ? face : 5;
    lightprobe_to_world(nearest, scale, scale * s, scale * t, direction);
}

// Cells of 2^level texels along an edge.
LIGHTPROBE_SHARED int lightprobe_level_side(int side, int level)
{
    return (side + (1 << level) - 1) >> level;
}
// [glsl end]

// Solid angle of the triangle whose corners have these lengths, scalar products, triple product n.
// Nothing cancels, as it does in the usual difference of four atan (0.87% off in float at 256^2).
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

// ---- Scratch memory ---- >>scratch

// Sums over texels are kept as float and this much too small, so that a probe full of FLT_MAX
// (4 pi FLT_MAX in all) does not overflow; a power of two costs no digit.
#define LIGHTPROBE_SCALE 0.0625f
// A probe whose luminance sums to less counts as black: squares of shares would underflow.
#define LIGHTPROBE_BLACK 1e-30f

#define LIGHTPROBE_TILE_LEVEL 2 // a tile has 4 x 4 texels
#define LIGHTPROBE__LEVELS 14   // level 13 of the largest side is one cell
// Leaves to make so many lights from: enough that few lights have a choice. Four times as many take
// a tenth off the error of 32 lights and double the time.
#define LIGHTPROBE__LEAVES(lights) ((lights) + 200)
// Room to divide all cells of the same error or none: so a turned probe gives the same leaves.
#define LIGHTPROBE_MORE_LEAVES 96
#define LIGHTPROBE_ROUNDS 3 // of relaxation: none errs 5 to 16% more, two up to 1%
// One e-fold of radiance counts as much as so many radians: what keeps a sun out of its haze. From
// 0.15 to 0.25 no probe changes much; with half of that city_sun's sun is lost at 4 lights.
#define LIGHTPROBE_TONE 0.2f
// Radians by which what is as far away as the mean shifts for a typical receiver: what sets the
// near apart from what is far behind it (docs/lightprobe.md, "Places").
#define LIGHTPROBE_PARALLAX 0.25f
// Weight of a light's width next to its unevenness: its shadow is shaded as if the receiver saw all
// of it at one cosine. 0.1 to 0.35 do alike; without it a night sky's 8 lights err twice as much.
#define LIGHTPROBE_WIDTH 0.2f
#define LIGHTPROBE_BINS 8     // places for a cut, over so many standard deviations to both sides
#define LIGHTPROBE_REACH 2.0f // of the mean
#define LIGHTPROBE_NEAR 6     // clusters that a leaf may move to: with 3 errors grow by 3%
// On a moving probe. Half as soft flickers up to 1.7 times as much, twice as soft errs twice as
// much at 32 lights.
#define LIGHTPROBE_SOFT 0.15f // radians further than the nearest seed: such lights share a leaf
#define LIGHTPROBE_RATE 0.03f // part of its way to the light that a seed goes in a frame,
#define LIGHTPROBE_TURN 0.07f // a slope; at once a flat lamp's light flickers 3 to 10 times as much
#define LIGHTPROBE_FADE 32.0f // frames in which other changes fade in: at once they step 2.4 times
#define LIGHTPROBE_LATE 0.5f  // part of what changes sizes that comes a frame late,
#define LIGHTPROBE_WIDEN 0.1f // and of 1 - cosine the largest change in a frame
#define LIGHTPROBE_ROUND 0.25f // squares of sizes apart by less than so much of their sum are round
// All of these are for lights that move by so many radians a frame, or less. Of faster ones as much
// more is done in a frame, or seeds and what fades stay where bulbs were.
#define LIGHTPROBE_STEP 0.0044f
#define LIGHTPROBE_FASTEST 16.0f // half of the way at once

// [glsl begin work]

// Sums over a square of 2^level texels: RGB radiance and 1, and luminance times direction, in the
// face's own axes (middle, s, t), and over distance.
typedef struct lightprobe_cell {
    lightprobe_vec4 flux, resultant;
} lightprobe_cell;

// A cell that is not divided further. Leaves tile the sphere; clusters of them become lights.
typedef struct lightprobe_leaf {
    lightprobe_vec3 flux;
    float solid_angle;
    lightprobe_vec3 direction; // vector irradiance = strength * direction
    float strength, luminance;
    float tone; // LIGHTPROBE_TONE times the logarithm of radiance over its mean, plus parallax
    float inverse, parallax; // mean of 1 / distance; that times the reach of receivers, at most 1
    float half_width;        // of the square that it spreads its light over
    int face, level, x, y, cluster;
    float least, parts; // distance of the nearest seed, sum of what all lights take
} lightprobe_leaf;

// Sums over the leaves of a light, of RGB and of luminance times tone, direction, and the squares
// and products of it, xx yy zz xy yz zx.
typedef struct lightprobe_moments {
    lightprobe_vec3 flux;
    float tones;
    lightprobe_vec3 resultant;
    float second[6];
} lightprobe_moments;

// Sums over leaves: of luminance, of it times direction, tone and squared tone.
typedef struct lightprobe_sum {
    lightprobe_vec3 resultant;
    float luminance, tones, tones2;
    int count;
} lightprobe_sum;

// The plane, or the tone, at which a cluster is split best. Along the axis lie LIGHTPROBE_BINS bins
// of width 1 / scale from low on.
typedef struct lightprobe_axis {
    lightprobe_vec3 direction;
    float threshold, low, scale;
    int by_tone;
} lightprobe_axis;

typedef struct lightprobe_cluster {
    lightprobe_sum sum;
    lightprobe_vec3 centre; // means
    float tone;
    lightprobe_axis axis, tone_axis;
    float error, gain; // behind edges; what the planned split takes off the cost
    int planned, changed, id;
    int brightest; // leaf: it adds most
    int first;     // of sum.count leaves in order[]
    int nearby[LIGHTPROBE_NEAR], near_count;
    lightprobe_vec3 seed; // on a moving probe leaves go to the nearest
    float seed_tone, seed_share;
    int lives; // takes leaves, 2: and those of one that does no more; 0: fades out
    // Mean direction that the light may have (else lamps' discs step 9 times as far); what it was
    // when it had leaves.
    float longest, distance;
    lightprobe_vec3 slopes; // along both axes, in the world
    lightprobe_vec3 across; // axis_u in the last frame, 0: of a new light
    lightprobe_vec3 sizes;  // variances along both axes, and 1 - cosine, then
    // Of the leaves, now and in the last frame; what the light has besides, until it has faded.
    // With energy alone steps are 4 times as large, without second moments those of rectangles 2 to
    // 3 times.
    lightprobe_moments now, past, late;
} lightprobe_cluster;
// [glsl end]

// [glsl begin lights]
// What a light is made from: the sums over its leaves, its frame (e, f, d) by the direction of
// these, and luminance times squares and product of direction along e and f, and over distance.
typedef struct lightprobe_region {
    lightprobe_wide flux[3], resultant[3], luminance, solid_angle, inverse;
    lightprobe_vec3 d, e, f;
    lightprobe_wide second[3];
} lightprobe_region;

// Sums over leaves around a light, by luminance: of squares and product of direction along e and f,
// of these times what a plane across d leaves of 1 / distance, in parts of it, of the square of
// that, of the leaves' own spread. scale: 1 / distance becomes parts by it; reach: 1 - cosine from
// which on a leaf does not count.
typedef struct lightprobe_tilt {
    float ee, ff, ef, e, f, squares, own, scale, reach;
} lightprobe_tilt;
// [glsl end]

// The clusters that share a leaf, and what they take of it; with more than 4 all are asked again.
typedef struct lightprobe__share {
    int count, cluster[4];
    float part[4];
} lightprobe__share;

typedef struct lightprobe__work {
    const lightprobe_cube *cube;
    int side, half, tiles, top, max_lights, max_leaves, distances;
    float *omega, *weight;  // of the texels of a quarter face: solid angle, that over the distance
    float *band;            // of a row of tiles: weights of the texels, sums
    lightprobe_cell *cells; // tiles and larger squares; of each level from here on, all there are:
    int first_cell[LIGHTPROBE__LEVELS], cell_count;
    lightprobe_leaf *leaves;
    lightprobe__share *shares;
    float *leaf_errors;
    int *order;
    lightprobe_cluster *clusters;
    float *gains; // errors of the clusters that can be split, or what that gains; else 0
    lightprobe_region *regions;
    int leaf_count, cluster_count, repaired;
    double sum_of_all[3];
    float total, mean, reach; // mean: of 1 sr; reach: 1 / distance becomes parallax by it
    int jumps;    // the map is another one than in the last frame, or there was none: nothing fades
    float fading; // frames to go; below 0: the last frame was the first
    float pace;   // how many frames this one counts for
    float unit;   // LIGHTPROBE_SOFT as a distance to seeds
    int wants_error;
    float error, residual_sh[9][3];
} lightprobe__work;

static void *lightprobe__take(char *base, size_t *used, size_t bytes)
{
    void *p = base ? base + *used : NULL;
    *used += (bytes + 15) & ~(size_t)15;
    return p;
}

// Points into base (null: only counts) and returns the bytes used.
static size_t lightprobe__layout(lightprobe__work *w, char *base, int side, int max_lights)
{
    size_t used = 0;
    w->side = side;
    w->half = (side + 1) / 2;
    w->tiles = lightprobe_level_side(side, LIGHTPROBE_TILE_LEVEL);
    w->max_lights = max_lights;
    w->max_leaves = LIGHTPROBE__LEAVES(max_lights) + LIGHTPROBE_MORE_LEAVES;
    const size_t quarter = (size_t)w->half * (size_t)w->half, tiles = (size_t)w->tiles;
    const size_t leaves = (size_t)w->max_leaves, lights = (size_t)max_lights;
#define LIGHTPROBE__TAKE(type, count) (type *)lightprobe__take(base, &used, (count) * sizeof(type))
    w->omega = LIGHTPROBE__TAKE(float, quarter);
    w->weight = LIGHTPROBE__TAKE(float, quarter);
    w->band = LIGHTPROBE__TAKE(float, (4 * 24 + 12 + 1 + 24) * tiles);
    w->cell_count = 0;
    for (int level = LIGHTPROBE_TILE_LEVEL, n = 0; n != 1; level++) {
        n = lightprobe_level_side(side, level);
        w->first_cell[level] = w->cell_count;
        w->cell_count += 6 * n * n;
        w->top = level;
    }
    w->cells = LIGHTPROBE__TAKE(lightprobe_cell, (size_t)w->cell_count);
    w->leaves = LIGHTPROBE__TAKE(lightprobe_leaf, leaves);
    w->shares = LIGHTPROBE__TAKE(lightprobe__share, leaves);
    w->leaf_errors = LIGHTPROBE__TAKE(float, leaves);
    w->order = LIGHTPROBE__TAKE(int, leaves);
    w->clusters = LIGHTPROBE__TAKE(lightprobe_cluster, lights);
    w->gains = LIGHTPROBE__TAKE(float, lights);
    w->regions = LIGHTPROBE__TAKE(lightprobe_region, lights);
#undef LIGHTPROBE__TAKE
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

// ---- Small vector math ---- >>vectors

static unsigned lightprobe__bits_of(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

// Finite. Looks at the bits: with -ffast-math a comparison need not see a NaN.
static int lightprobe__is_number(float x)
{
    return (lightprobe__bits_of(x) & 0x7fffffffu) < 0x7f800000u;
}

// Rounded once: squares of float neither overflow nor underflow in double. GLSL has one of its own.
static float lightprobe_length(const lightprobe_vec3 v)
{
    const double x = v[0], y = v[1], z = v[2];
    return (float)sqrt(x * x + y * y + z * z);
}

// [glsl begin work]

LIGHTPROBE_SHARED float lightprobe_luminance(const lightprobe_vec3 rgb)
{
    LIGHTPROBE_PRECISE float l = 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
    return l;
}

LIGHTPROBE_SHARED float lightprobe_dot(const lightprobe_vec3 a, const lightprobe_vec3 b)
{
    LIGHTPROBE_PRECISE float d = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    return d;
}

// Of two vectors by a symmetric matrix (xx yy zz xy yz zx).
LIGHTPROBE_SHARED float lightprobe_product(const float m[6], const lightprobe_vec3 a,
                                           const lightprobe_vec3 b)
{
    LIGHTPROBE_PRECISE float sum = m[0] * a[0] * b[0] + m[1] * a[1] * b[1] + m[2] * a[2] * b[2];
    LIGHTPROBE_PRECISE float xy = a[0] * b[1] + a[1] * b[0], yz = a[1] * b[2] + a[2] * b[1];
    LIGHTPROBE_PRECISE float zx = a[2] * b[0] + a[0] * b[2];
    sum = sum + m[3] * xy + m[4] * yz + m[5] * zx;
    return sum;
}

// Returns the length; a null vector stays.
LIGHTPROBE_SHARED float lightprobe_normalize(LIGHTPROBE_INOUT lightprobe_vec3 v)
{
    float size = lightprobe_length(v);
    for (int i = 0; i < 3; i++) {
        LIGHTPROBE_PRECISE float part = size > 0.0f ? v[i] / size : v[i];
        v[i] = part;
    }
    return size;
}
// [glsl end]

// ---- Specular reflection, shared with GLSL ---- >>specular

// [glsl begin specular]
LIGHTPROBE_SHARED float lightprobe_between(float x, float low, float high)
{
    return x > low ? (x < high ? x : high) : low;
}

LIGHTPROBE_SHARED float lightprobe_cubic(float x, float a, float b, float c, float d)
{
    return ((d * x + c) * x + b) * x + a;
}

// Schlick's term of the half vector for the cosine between light and viewer.
LIGHTPROBE_SHARED float lightprobe_fresnel(float cosine)
{
    float t = 1.0f - sqrtf(0.5f + 0.5f * lightprobe_between(cosine, -1.0f, 1.0f));
    return t * t * t * t * t;
}

// The lobe of alpha a for the cosine m to the viewer. Directions of light, x away from the viewer
// and z along the normal, become those of a cosine lobe by x' = along x - shear z, y' = across y,
// z' = width z: the horizon stays where it is, so nothing is reflected from below it. All numbers
// are fitted and checked by tests/proofs/specular.c.
LIGHTPROBE_SHARED lightprobe_lobe lightprobe_fitted_lobe(lightprobe_lobe lobe, float a, float m)
{
    lightprobe_lobe l = lobe;
    float r = m > 0.0349f ? m : 0.0349f; // fitted up to 88 degrees, from there on polynomials swing
    float sine = sqrtf((1.0f - m) * (1.0f + m));
    r = r / (r + a);
    float along = lightprobe_cubic(a, lightprobe_cubic(r, -0.53912f, 1.8974f, -2.5446f, 1.2342f),
                                   lightprobe_cubic(r, 9.5959f, -18.368f, 35.922f, -24.477f),
                                   lightprobe_cubic(r, -13.108f, 26.053f, -23.067f, -23.278f),
                                   lightprobe_cubic(r, 5.3654f, -10.166f, 0.6215f, 22.296f));
    float shear = lightprobe_cubic(a, lightprobe_cubic(r, 1.0225f, 0.56181f, -2.6402f, 1.1447f),
                                   lightprobe_cubic(r, 3.5093f, -9.2535f, 29.787f, -28.027f),
                                   lightprobe_cubic(r, -10.008f, 11.951f, -31.701f, 5.4128f),
                                   lightprobe_cubic(r, 5.5156f, -3.3794f, -2.1185f, 28.337f));
    float across = lightprobe_cubic(a, lightprobe_cubic(r, 1.1531f, 14.567f, -37.403f, 22.137f),
                                    lightprobe_cubic(r, -4.9333f, -55.706f, 140.44f, -81.959f),
                                    lightprobe_cubic(r, 7.7695f, 76.784f, -189.68f, 115.76f),
                                    lightprobe_cubic(r, -3.7285f, -34.908f, 90.516f, -63.043f));
    float whole = lightprobe_cubic(a, lightprobe_cubic(r, 1.1328f, -1.4348f, 2.4262f, -1.1276f),
                                   lightprobe_cubic(r, -0.70429f, 5.782f, -11.612f, 6.8001f),
                                   lightprobe_cubic(r, 0.92783f, -9.0341f, 9.2648f, -0.16572f),
                                   lightprobe_cubic(r, -0.38267f, 1.986f, 4.6633f, -9.5373f));
    float schlick = lightprobe_cubic(a, lightprobe_cubic(r, 0.098366f, 2.6263f, -3.1047f, 1.392f),
                                     lightprobe_cubic(r, -0.33385f, -1.3897f, -26.167f, 31.217f),
                                     lightprobe_cubic(r, 0.60429f, -4.8188f, 49.946f, -17.16f),
                                     lightprobe_cubic(r, -0.31576f, 3.1057f, -16.608f, -24.181f));
    l.along = m * m + a * along;
    l.across = 1.0f + a * across;
    l.shear = sine * (m + a * shear);
    l.width = 2.0f * a;
    l.whole = lightprobe_between(whole, 0.0f, 1.0f);
    float x = l.shear / l.along, dim = (1.0f - m) * (1.0f - m);
    float middle = lightprobe_fresnel((m - sine * x) / sqrtf(1.0f + x * x));
    l.fresnel = dim * dim * (1.0f - m) * schlick / (l.whole + 1e-3f) - middle;
    return l;
}

lightprobe_lobe lightprobe_specular_lobe(const lightprobe_vec3 normal, const lightprobe_vec3 view,
                                         float alpha, const lightprobe_vec3 f0)
{
    lightprobe_lobe lobe;
    float cosine = 0.0f, sine2 = 0.0f;
    for (int i = 0; i < 3; i++) {
        lobe.normal[i] = lightprobe_between(normal[i], -1.0f, 1.0f);
        lobe.view[i] = lightprobe_between(view[i], -1.0f, 1.0f);
        cosine += lobe.normal[i] * lobe.view[i];
    }
    for (int i = 0; i < 3; i++) {
        lobe.away[i] = cosine * lobe.normal[i] - lobe.view[i];
        sine2 += lobe.away[i] * lobe.away[i];
    }
    float sine = sine2 > 1e-6f ? sqrtf(sine2) : 1e-3f;
    for (int i = 0; i < 3; i++) {
        lobe.away[i] = lightprobe_between(lobe.away[i] / sine, -1.0f, 1.0f);
        if (cosine < 0.0f) lobe.view[i] = -lobe.away[i]; // smooth normals turn from the viewer
        lobe.f0[i] = lightprobe_between(f0[i], 0.0f, 1.0f);
    }
    return lightprobe_fitted_lobe(lobe, lightprobe_between(alpha, 0.02f, 1.0f),
                                  lightprobe_between(cosine, 0.0f, 1.0f));
}

LIGHTPROBE_SHARED void lightprobe_into_lobe(lightprobe_lobe lobe,
                                            LIGHTPROBE_INOUT lightprobe_vec3 w)
{
    float x = lightprobe_dot(w, lobe.away), z = lightprobe_dot(w, lobe.normal);
    float forth = (lobe.along - lobe.across) * x - lobe.shear * z;
    float up = (lobe.width - lobe.across) * z;
    for (int i = 0; i < 3; i++)
        w[i] = lobe.across * w[i] + forth * lobe.away[i] + up * lobe.normal[i];
}

// The cosine between the viewer and the direction that went into the lobe as this one.
LIGHTPROBE_SHARED float lightprobe_to_viewer(lightprobe_lobe lobe, const lightprobe_vec3 into)
{
    lightprobe_vec3 d;
    float x = lightprobe_dot(into, lobe.away), z = lightprobe_dot(into, lobe.normal);
    float forth = (x + lobe.shear * z / lobe.width) / lobe.along - x / lobe.across;
    float up = z / lobe.width - z / lobe.across;
    for (int i = 0; i < 3; i++)
        d[i] = into[i] / lobe.across + forth * lobe.away[i] + up * lobe.normal[i];
    return lightprobe_dot(d, lobe.view) / sqrtf(lightprobe_dot(d, d) + 1e-30f);
}

// Adds Lambert's integral along the edge from p to p + e, a vector times 2 pi. The part below the
// horizon is put straight up on it, where it is its azimuth along n. sum[3]: of whole azimuths.
LIGHTPROBE_SHARED void lightprobe_add_edge(const lightprobe_vec3 n, const lightprobe_vec3 p,
                                           const lightprobe_vec3 e,
                                           LIGHTPROBE_INOUT lightprobe_vec4 sum)
{
    lightprobe_vec3 q, plane, flat_p, flat_q;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        q[i] = p[i] + e[i];
        plane[i] = p[j] * e[k] - p[k] * e[j]; // by q a small light would have no digits left
    }
    float at_p = lightprobe_dot(p, n), at_q = lightprobe_dot(q, n), both = lightprobe_dot(p, q);
    // Straight below n azimuths hang on few digits, which must be the same ones.
    for (int i = 0; i < 3; i++) {
        flat_p[i] = p[i] - at_p * n[i];
        flat_q[i] = q[i] - at_q * n[i];
    }
    float side = lightprobe_dot(plane, n), size = sqrtf(lightprobe_dot(plane, plane));
    float turn = side < 0.0f ? -1.0f : 1.0f, flat_both = lightprobe_dot(flat_p, flat_q);
    float azimuth = turn * lightprobe_angle(fabsf(side), flat_both);
    float high = at_p > at_q ? at_p : at_q, low = at_p > at_q ? at_q : at_p;
    float high2 = at_p > at_q ? lightprobe_dot(p, p) : lightprobe_dot(q, q);
    float low2 = at_p > at_q ? lightprobe_dot(flat_q, flat_q) : lightprobe_dot(flat_p, flat_p);
    float below = azimuth, above = 0.0f;
    if (high > 0.0f) { // the edge meets the horizon at high * (lower end) - low * (higher end)
        low = low < 0.0f ? low : 0.0f;
        above = lightprobe_angle(high * size, high * both - low * high2) / (size + 1e-37f);
        below = turn * lightprobe_angle(-low * fabsf(side), high * low2 - low * flat_both);
    }
    for (int i = 0; i < 3; i++) sum[i] += above * plane[i] + below * n[i];
    sum[3] += azimuth;
}

// Adds the edges from corner to corner, unless all that they enclose is below the lobe's horizon.
LIGHTPROBE_SHARED void lightprobe_add_edges(const lightprobe_vec3 n, lightprobe_vec3 corner[4],
                                            float c, LIGHTPROBE_INOUT lightprobe_vec4 sum)
{
    lightprobe_vec3 e;
    float top = -1.0f;
    for (int k = 0; k < 4; k++) top = lightprobe_dot(corner[k], n) < 0.0f ? top : 1.0f;
    if (c >= 0.0f && top < 0.0f) return;
    for (int k = 0; k < 4; k++) {
        for (int i = 0; i < 3; i++) e[i] = corner[(k + 1) % 4][i] - corner[k][i];
        lightprobe_add_edge(n, corner[k], e, sum);
    }
}

// The light from (x, y, z): corners, in the lobe, of the rectangle with these sines of half-sizes
// in the plane at c, moved along their rays from the probe into the plane of its slopes. Returns
// what counts of it there; 0: it shines the other way.
LIGHTPROBE_SHARED float lightprobe_corners(lightprobe_light light, lightprobe_lobe lobe, float c,
                                           float u, float v, float x, float y, float z,
                                           LIGHTPROBE_OUT lightprobe_vec3 corner[4])
{
    float scale = c > 0.0f && light.distance > 1e-30f ? 1.0f / light.distance : 0.0f, before = 1.0f;
    float slope_u = scale > 0.0f ? lightprobe_between(light.slope_u, -4.0f, 4.0f) : 0.0f;
    float slope_v = scale > 0.0f ? lightprobe_between(light.slope_v, -4.0f, 4.0f) : 0.0f;
    lightprobe_vec3 at, d, axis_u, axis_v, tilt;
    for (int i = 0; i < 3; i++) {
        at[i] = lightprobe_between(scale * (i == 0 ? x : i == 1 ? y : z), -1e4f, 1e4f);
        d[i] = lightprobe_between(light.direction[i], -1.0f, 1.0f);
        axis_u[i] = lightprobe_between(light.axis_u[i], -1.0f, 1.0f);
        tilt[i] = slope_u * axis_u[i] + slope_v * lightprobe_between(light.axis_v[i], -1.0f, 1.0f);
        before -= at[i] * (d[i] - tilt[i]);
    }
    for (int i = 0; i < 3; i++) { // right-handed, as axis_v need not be
        int j = (i + 1) % 3, k = (i + 2) % 3;
        axis_v[i] = d[j] * axis_u[k] - d[k] * axis_u[j];
    }
    float rise_u = lightprobe_dot(axis_u, tilt), rise_v = lightprobe_dot(axis_v, tilt);
    lightprobe_into_lobe(lobe, d);
    lightprobe_into_lobe(lobe, axis_u);
    lightprobe_into_lobe(lobe, axis_v);
    if (scale > 0.0f) lightprobe_into_lobe(lobe, at);
    for (int k = 0; k < 4; k++) {
        float right = k == 1 || k == 2 ? -u : u, up = k < 2 ? v : -v, reach = 1.0f;
        float along = c - right * rise_u - up * rise_v;
        if (scale > 0.0f) reach = c / lightprobe_between(along, 0.25f * c, 4.0f * c);
        for (int i = 0; i < 3; i++)
            corner[k][i] = reach * (c * d[i] + right * axis_u[i] + up * axis_v[i]) - c * at[i];
    }
    float slant = sqrtf(1.0f + slope_u * slope_u + slope_v * slope_v), c2 = c * c + 1e-6f;
    return lightprobe_fade_in(before / slant, slant * (1.0f - c * c) / c2);
}

void lightprobe_specular(lightprobe_light light, lightprobe_lobe lobe, float x, float y, float z,
                         LIGHTPROBE_OUT lightprobe_vec3 rgb)
{
    // Half-sizes shrink again beyond a hemisphere.
    float c = lightprobe_between(light.cos_alpha, -1.0f, 1.0f);
    float u = lightprobe_between(light.tan_half_u, 1e-3f, 4.0f);
    float v = lightprobe_between(light.tan_half_v, 1e-3f, 4.0f);
    float most = c < 0.0f ? sqrtf(1.0f - c * c) : 1.0f;
    lightprobe_vec3 corner[4], flux;
    lightprobe_vec4 sum;
    u = most * u / sqrtf(1.0f + u * u);
    v = most * v / sqrtf(1.0f + v * v);
    for (int i = 0; i < 3; i++) sum[i] = sum[3] = rgb[i] = 0.0f;
    float part = lightprobe_corners(light, lobe, c, u, v, x, y, z, corner);
    if (part <= 0.0f) return;
    lightprobe_add_edges(lobe.normal, corner, c, sum);
    // An outline around the point straight below leaves the whole horizon out (Stokes).
    float missing = 0.15915494f * sum[3] < (c < 0.0f ? 0.5f : -0.5f) ? 6.28318531f : 0.0f;
    for (int i = 0; i < 3; i++) flux[i] = sum[i] + missing * lobe.normal[i];
    float share = lightprobe_between(0.15915494f * lightprobe_dot(flux, lobe.normal), 0.0f, 1.0f);
    float density = share / (4.0f * lightprobe_angle(u * v, c * sqrtf(c * c + u * u + v * v)));
    // Fresnel's term is that where the light is; of a light that fills the lobe, the lobe's mean.
    float fresnel = lightprobe_fresnel(lightprobe_to_viewer(lobe, flux));
    fresnel = lightprobe_between(fresnel + share * share * lobe.fresnel, 0.0f, 1.0f);
    for (int i = 0; i < 3; i++)
        rgb[i] = part * light.irradiance[i] * lobe.whole * density *
                 (lobe.f0[i] + (1.0f - lobe.f0[i]) * fresnel);
}
// [glsl end]

// ---- Sums over tiles: the one pass over all texels ---- >>tiles

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
static inline lightprobe__bits lightprobe__or4(lightprobe__bits bits, lightprobe__four a)
{
    return bits | (lightprobe__bits)a;
}
#else
typedef struct lightprobe__four {
    float v[4];
} lightprobe__four;
typedef struct lightprobe__bits {
    uint32_t v[4];
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
static lightprobe__bits lightprobe__or4(lightprobe__bits bits, lightprobe__four a)
{
    for (int i = 0; i < 4; i++) bits.v[i] |= lightprobe__bits_of(a.v[i]);
    return bits;
}
#endif

static inline lightprobe__four lightprobe__load4(const float *p)
{
    lightprobe__four a;
    memcpy(&a, p, sizeof a);
    return a;
}

static inline void lightprobe__store4(float *p, lightprobe__four a)
{
    memcpy(p, &a, sizeof a);
}

// sum + a * b
static inline lightprobe__four lightprobe__add_product4(lightprobe__four sum, lightprobe__four a,
                                                        const float *b)
{
    return lightprobe__add4(sum, lightprobe__mul4(a, lightprobe__load4(b)));
}

static inline float lightprobe__sum4(const float v[4])
{
    return (v[0] + v[1]) + (v[2] + v[3]);
}

// [glsl begin cells]

// Index of a texel's weights; they are the same in all quarters of all faces.
LIGHTPROBE_SHARED int lightprobe_quarter(const lightprobe__work *w, int x, int y)
{
    int right = 2 * x + 1 - w->side, down = 2 * y + 1 - w->side;
    int dx = (right < 0 ? -right : right) / 2, dy = (down < 0 ? -down : down) / 2;
    return dy * ((w->side + 1) / 2) + dx;
}

// Index of a cell of tiles or larger.
LIGHTPROBE_SHARED int lightprobe_cell_index(const lightprobe__work *w, int face, int level, int x,
                                            int y)
{
    int n = lightprobe_level_side(w->side, level);
    return w->first_cell[level] + (face * n + y) * n + x;
}

// Centre of a texel in [-1,1].
LIGHTPROBE_SHARED float lightprobe_centre(int side, int x)
{
    return LIGHTPROBE_FLOAT(2 * x + 1 - side) / LIGHTPROBE_FLOAT(side);
}

// 0 where it is none.
LIGHTPROBE_SHARED float lightprobe_whole_distance(const lightprobe_vec3 rgb, float over_distance)
{
    LIGHTPROBE_PRECISE float distance = lightprobe_luminance(rgb) / over_distance;
    return over_distance > 0.0f ? distance : 0.0f;
}

// Weights: solid angle, and that over the distance to its centre (s, t). texel_rgb[3]: how far.
LIGHTPROBE_SHARED lightprobe_cell lightprobe_texel_cell(const lightprobe_vec4 texel_rgb,
                                                        float omega, float weight, float s, float t)
{
    lightprobe_vec3 rgb;
    for (int i = 0; i < 3; i++) rgb[i] = texel_rgb[i];
    float distance = texel_rgb[3];
    LIGHTPROBE_PRECISE float over_distance = lightprobe_luminance(rgb) * omega / distance;
    LIGHTPROBE_PRECISE float m = lightprobe_luminance(rgb) * weight, ms = m * s, mt = m * t;
    LIGHTPROBE_PRECISE lightprobe_cell texel;
    for (int i = 0; i < 3; i++) texel.flux[i] = rgb[i] * omega;
    texel.flux[3] = omega;
    texel.resultant[0] = m;
    texel.resultant[1] = ms;
    texel.resultant[2] = mt;
    // 0 where it is infinitely far, or no distance.
    texel.resultant[3] = distance >= 1e-9f && distance <= 1e9f ? over_distance : 0.0f;
    return texel;
}
// [glsl end]

// A texel's vector irradiance is shorter than its solid angle by omega / 12, the mean half square
// angle of a square: else a face of one texel counts as a point (17% too long, now 0.7% too short).
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
            const float weight = omega * (1 - omega * (1 / 12.0f)) * inverse * LIGHTPROBE_SCALE;
            const size_t a = (size_t)y * (size_t)w->half + (size_t)x;
            const size_t b = (size_t)x * (size_t)w->half + (size_t)y;
            w->omega[a] = w->omega[b] = omega * LIGHTPROBE_SCALE;
            w->weight[a] = w->weight[b] = weight;
        }
    }
}

static const float *lightprobe__texel(const lightprobe__work *w, int face, int x, int y)
{
    return w->cube->face[face] +
           ((size_t)y * (size_t)w->side + (size_t)x) * (size_t)w->cube->channels;
}

// Copies a texel with 0 for bad channels, told by their bits; returns 1 if there was one.
static int lightprobe__repair(const float *texel, float rgb[3])
{
    int bad = 0;
    for (int i = 0; i < 3; i++) {
        const unsigned bits = lightprobe__bits_of(texel[i]);
        rgb[i] = bits < 0x7f800000u ? texel[i] : 0.0f;
        bad |= bits >= 0x7f800000u && bits != 0x80000000u; // -0 is fine
    }
    return bad;
}

// A texel and its distance, 0 where it is infinite or there is none. Returns 1 if a channel is bad.
LIGHTPROBE_SHARED int lightprobe_read(const lightprobe__work *w, int face, int x, int y,
                                      float rgbd[4])
{
    const float *texel = lightprobe__texel(w, face, x, y);
    const int bad = lightprobe__repair(texel, rgbd);
    rgbd[3] = w->distances && lightprobe__is_number(texel[3]) ? texel[3] : 0;
    if (w->distances == 2) rgbd[3] = lightprobe_whole_distance(rgbd, rgbd[3]);
    return bad;
}

// Copies a tile that the border cuts, that has a fourth channel or bad texels. Counts the bad ones.
static int lightprobe__gather(const lightprobe__work *w, int face, int tx, int ty, float out[48])
{
    int bad = 0;
    memset(out, 0, 48 * sizeof *out);
    for (int y = 4 * ty; y < 4 * ty + 4 && y < w->side; y++)
        for (int x = 4 * tx; x < 4 * tx + 4 && x < w->side; x++)
            bad += lightprobe__repair(lightprobe__texel(w, face, x, y),
                                      out + 12 * (y & 3) + 3 * (x & 3));
    return bad;
}

// texels and step: four rows of four RGB texels. band: four rows of weights, 12 floats of solid
// angle and, so many floats after, 12 of solid angle times luminance coefficient over distance. s:
// of the 12 floats. sums: 12 floats of flux and 4 each of the resultant's components, which are
// left to lightprobe__tile_cell. Returns 0 where a texel was negative, NaN or infinite (then the
// sums are worthless): the sign bits are gathered on the way, the rest shows in the sums. Written
// out, three registers of four floats each: arrays of them gcc -O2 keeps in memory, twice as slow.
static inline int lightprobe__sum_tile(const float *texels, ptrdiff_t step, const float *band,
                                       ptrdiff_t after, const float *s, float sums[24])
{
    static const float none[4] = {0, 0, 0, 0};
    const lightprobe__four zero = lightprobe__load4(none);
    lightprobe__four f0 = zero, f1 = zero, f2 = zero, m0 = zero, m1 = zero, m2 = zero;
    lightprobe__four n0 = zero, n1 = zero, n2 = zero;
    lightprobe__bits sign;
    memset(&sign, 0, sizeof sign);
    for (int row = 0; row < 4; row++, texels += step, band += 2 * after) {
        const lightprobe__four x0 = lightprobe__load4(texels), x1 = lightprobe__load4(texels + 4);
        const lightprobe__four x2 = lightprobe__load4(texels + 8);
        f0 = lightprobe__add_product4(f0, x0, band);
        f1 = lightprobe__add_product4(f1, x1, band + 4);
        f2 = lightprobe__add_product4(f2, x2, band + 8);
        m0 = lightprobe__add_product4(m0, x0, band + after);
        m1 = lightprobe__add_product4(m1, x1, band + after + 4);
        m2 = lightprobe__add_product4(m2, x2, band + after + 8);
        n0 = lightprobe__add4(n0, m0); // sums of sums: the first row counts 4 times
        n1 = lightprobe__add4(n1, m1);
        n2 = lightprobe__add4(n2, m2);
        sign = lightprobe__or4(lightprobe__or4(lightprobe__or4(sign, x0), x1), x2);
    }
    uint64_t signs[2];
    float all[4];
    memcpy(signs, &sign, sizeof signs);
    lightprobe__store4(sums, f0);
    lightprobe__store4(sums + 4, f1);
    lightprobe__store4(sums + 8, f2);
    lightprobe__store4(sums + 12, lightprobe__add4(lightprobe__add4(m0, m1), m2));
    m0 = lightprobe__mul4(m0, lightprobe__load4(s));
    m1 = lightprobe__mul4(m1, lightprobe__load4(s + 4));
    m2 = lightprobe__mul4(m2, lightprobe__load4(s + 8));
    lightprobe__store4(sums + 16, lightprobe__add4(lightprobe__add4(m0, m1), m2));
    lightprobe__store4(sums + 20, lightprobe__add4(lightprobe__add4(n0, n1), n2));
    // A sum that overflows is looked at again by lightprobe__gather, which finds nothing.
    lightprobe__store4(all, lightprobe__add4(lightprobe__add4(f0, f1), f2));
    return !((signs[0] | signs[1]) & 0x8000000080000000u) &&
           lightprobe__is_number(lightprobe__sum4(all));
}

// Adds up a tile's sums. Called a whole row of tiles later: what has just been stored is slow to
// load in other fours. t: of the row after the last, next to the one before it.
static inline void lightprobe__tile_cell(const float sums[24], const float t[2], float omega,
                                         lightprobe_cell *cell)
{
    lightprobe__four a = lightprobe__load4(sums), b = lightprobe__load4(sums + 6);
    a = lightprobe__add4(a, lightprobe__load4(sums + 3));
    b = lightprobe__add4(b, lightprobe__load4(sums + 9));
    lightprobe__store4(cell->flux, lightprobe__add4(a, b)); // and what is no flux
    cell->flux[3] = omega;
    cell->resultant[0] = lightprobe__sum4(sums + 12);
    cell->resultant[1] = lightprobe__sum4(sums + 16);
    const float n = lightprobe__sum4(sums + 20);
    cell->resultant[2] = t[0] * cell->resultant[0] + (t[1] - t[0]) * n;
    cell->resultant[3] = 0;
}

// Weights of the texels in a row of tiles. What lies beyond the side may hold anything finite.
static void lightprobe__make_band(lightprobe__work *w, int ty)
{
    const int stride = 24 * w->tiles;
    float *tile_omega = w->band + (4 * 24 + 12) * w->tiles;
    for (int y = 4 * ty; y < 4 * ty + 4 && y < w->side; y++) {
        float *row = w->band + (y & 3) * stride; // twice three floats a texel
        if (y == 4 * ty) memset(tile_omega, 0, (size_t)w->tiles * sizeof(float));
        for (int x = 0; x < w->side; x++) {
            const int at = lightprobe_quarter(w, x, y);
            const float omega = w->omega[at], q = w->weight[at];
            float *to = row + 3 * (ptrdiff_t)x, *v = to + stride / 2;
            to[0] = to[1] = to[2] = omega;
            v[0] = 0.2126f * q;
            v[1] = 0.7152f * q;
            v[2] = 0.0722f * q;
            tile_omega[x >> 2] += omega;
        }
    }
}

// [glsl begin cells]
LIGHTPROBE_SHARED lightprobe_cell lightprobe_add_cell(lightprobe_cell a, lightprobe_cell b)
{
    LIGHTPROBE_PRECISE lightprobe_cell sum = a;
    for (int i = 0; i < 4; i++) {
        sum.flux[i] += b.flux[i];
        sum.resultant[i] += b.resultant[i];
    }
    return sum;
}

// Again for GLSL, whose own comes later.
LIGHTPROBE_SHARED int lightprobe_read(const lightprobe__work *w, int face, int x, int y,
                                      LIGHTPROBE_OUT lightprobe_vec4 rgbd);

// A cell no larger than a tile, straight from its texels.
LIGHTPROBE_SHARED lightprobe_cell lightprobe_small_cell(const lightprobe__work *w, int face,
                                                        int level, int cx, int cy)
{
    int size = 1 << level, end_x = size * cx + LIGHTPROBE_ROLLED(size);
    int end_y = size * cy + LIGHTPROBE_ROLLED(size);
    lightprobe_cell sum;
    for (int i = 0; i < 4; i++) sum.flux[i] = sum.resultant[i] = 0.0f;
    for (int y = size * cy; y < end_y && y < w->side; y++) {
        for (int x = size * cx; x < end_x && x < w->side; x++) {
            int at = lightprobe_quarter(w, x, y);
            lightprobe_vec4 rgbd;
            lightprobe_read(w, face, x, y, rgbd);
            lightprobe_cell texel =
                lightprobe_texel_cell(rgbd, w->omega[at], w->weight[at],
                                      lightprobe_centre(w->side, x), lightprobe_centre(w->side, y));
            sum = lightprobe_add_cell(sum, texel);
        }
    }
    return sum;
}
// [glsl end]

// One row of tiles of one face.
static void lightprobe__sum_band(lightprobe__work *w, int face, int ty)
{
    const ptrdiff_t after = 12 * w->tiles, row = 3 * (ptrdiff_t)w->side;
    float *s = w->band + 8 * after, *omega = s + after, *sums = omega + w->tiles;
    const float *texels = w->cube->face[face] + 4 * ty * row;
    const int plain = w->cube->channels == 3 && 4 * ty + 4 <= w->side ? w->side / 4 : 0;
    const float t[2] = {lightprobe_centre(w->side, 4 * ty + 4),
                        lightprobe_centre(w->side, 4 * ty + 3)};
    lightprobe_cell *cell = w->cells + lightprobe_cell_index(w, face, LIGHTPROBE_TILE_LEVEL, 0, ty);
    for (int tx = 0; tx < w->tiles; tx++) {
        float copy[48];
        int copied = tx >= plain;
        if (copied) w->repaired += lightprobe__gather(w, face, tx, ty, copy);
        // Called in one place, so that tiles are summed alike; a copy is always good.
        while (!lightprobe__sum_tile(copied ? copy : texels + 12 * tx, copied ? 12 : row,
                                     w->band + 12 * tx, after, s + 12 * tx, sums + 24 * tx)) {
            w->repaired += lightprobe__gather(w, face, tx, ty, copy);
            copied = 1;
        }
    }
    for (int tx = 0; tx < w->tiles; tx++)
        lightprobe__tile_cell(sums + 24 * tx, t, omega[tx], cell + tx);
    for (int tx = 0; tx < w->tiles && w->distances; tx++)
        cell[tx].resultant[3] =
            lightprobe_small_cell(w, face, LIGHTPROBE_TILE_LEVEL, tx, ty).resultant[3];
}

static void lightprobe__sum_tiles(lightprobe__work *w)
{
    float *s = w->band + 4 * 24 * w->tiles; // of the 12 floats of every tile, after the weights
    memset(w->band, 0, (size_t)(4 * 24 + 12) * (size_t)w->tiles * sizeof(float));
    for (int x = 0; x < 3 * w->side; x++) s[x] = lightprobe_centre(w->side, x / 3);
    for (int ty = 0; ty < w->tiles; ty++) {
        lightprobe__make_band(w, ty);
        for (int face = 0; face < 6; face++) lightprobe__sum_band(w, face, ty);
    }
}

// ---- Cells of all sizes ---- >>cells

// [glsl begin cells]

// Makes a cell from the (up to) four of the level below.
LIGHTPROBE_SHARED void lightprobe_halve(lightprobe__work *w, int face, int level, int x, int y)
{
    int m = lightprobe_level_side(w->side, level - 1);
    int from = lightprobe_cell_index(w, face, level - 1, 2 * x, 2 * y);
    lightprobe_cell sum = w->cells[from];
    for (int i = 1; i < LIGHTPROBE_ROLLED(4); i++)
        if (2 * x + i % 2 < m && 2 * y + i / 2 < m)
            sum = lightprobe_add_cell(sum, w->cells[from + i / 2 * m + i % 2]);
    w->cells[lightprobe_cell_index(w, face, level, x, y)] = sum;
}

LIGHTPROBE_SHARED lightprobe_cell lightprobe_cell_at(const lightprobe__work *w, int face, int level,
                                                     int x, int y)
{
    if (level < LIGHTPROBE_TILE_LEVEL) return lightprobe_small_cell(w, face, level, x, y);
    return w->cells[lightprobe_cell_index(w, face, level, x, y)];
}
// [glsl end]

// Up to one cell per face.
static void lightprobe__make_pyramid(lightprobe__work *w)
{
    for (int level = LIGHTPROBE_TILE_LEVEL + 1; level <= w->top; level++) {
        const int n = lightprobe_level_side(w->side, level);
        for (int face = 0; face < 6; face++)
            for (int y = 0; y < n; y++)
                for (int x = 0; x < n; x++) lightprobe_halve(w, face, level, x, y);
    }
}

// In double, over the cells of 8 x 8 texels.
static void lightprobe__find_total(lightprobe__work *w)
{
    const int level = w->top > LIGHTPROBE_TILE_LEVEL ? LIGHTPROBE_TILE_LEVEL + 1 : w->top;
    const int n = lightprobe_level_side(w->side, level);
    for (int i = 0; i < 6 * n * n; i++)
        for (int c = 0; c < 3; c++)
            w->sum_of_all[c] += (double)w->cells[w->first_cell[level] + i].flux[c];
    const float rgb[3] = {(float)w->sum_of_all[0], (float)w->sum_of_all[1],
                          (float)w->sum_of_all[2]};
    w->total = lightprobe_luminance(rgb);
}

// ---- Leaves: the cell with the largest error is divided first ---- >>leaves

// [glsl begin cells]
// Of tones and parallaxes, for a probe of this luminance over distance.
LIGHTPROBE_SHARED void lightprobe_set_scales(lightprobe__work *w, float inverse)
{
    w->mean = w->total / 12.5663706f;
    w->reach = inverse > 0.0f ? LIGHTPROBE_PARALLAX * (w->total / inverse) : 0.0f;
}

// Whether leaves are fine enough where the largest error is this one: the rest is rounding, or
// there is no room. Of those with last's error, the one before, all or none are divided.
LIGHTPROBE_SHARED int lightprobe_is_enough(int count, int room, float error, float last,
                                           float total)
{
    if (count + 3 > room || error <= 1e-7f * total) return 1;
    return count + LIGHTPROBE_MORE_LEAVES >= room && error < 0.9999f * last ? 1 : 0;
}

// -1: a texel, which is not divided.
LIGHTPROBE_SHARED float lightprobe_leaf_error(lightprobe_leaf leaf)
{
    return leaf.level > 0 ? leaf.luminance - leaf.strength : -1.0f;
}
// [glsl end]

// Of equals the first, so that the GPU's way to find it agrees.
static int lightprobe__largest(const float *x, int count)
{
    int most = 0;
    for (int i = 1; i < count; i++)
        if (x[i] > x[most]) most = i;
    return most;
}

// [glsl begin work]

// Natural logarithm of a ratio, kept in [1e-3, 1e6], to 1e-6. Written out: drivers round their
// own as they like, and which leaves go together hangs on it.
LIGHTPROBE_SHARED float lightprobe_log(float ratio)
{
    float r = 1024.0f * (ratio > 1e-3f ? (ratio < 1e6f ? ratio : 1e6f) : 1e-3f);
    float e = -10.0f;
    while (r >= 2.0f) {
        r = 0.5f * r;
        e = e + 1.0f;
    }
    LIGHTPROBE_PRECISE float t = (r - 1.0f) / (r + 1.0f), t2 = t * t;
    LIGHTPROBE_PRECISE float p = t2 * 0.11111111f + 0.14285714f;
    p = p * t2 + 0.2f;
    p = p * t2 + 0.33333333f;
    p = 0.69314718f * e + 2.0f * (p * t2 * t + t);
    return p;
}

// mean: luminance of 1 sr of the whole probe; solid_angle is more than 0.
LIGHTPROBE_SHARED float lightprobe_tone(float luminance, float solid_angle, float mean)
{
    LIGHTPROBE_PRECISE float most = 1e6f * mean * solid_angle, unit = mean * solid_angle;
    return LIGHTPROBE_TONE * lightprobe_log(luminance < most ? luminance / unit : 1e6f);
}

// [glsl end]

// [glsl begin cells]

// Middle of a cell on its face; 1 where it is cut off before that.
LIGHTPROBE_SHARED float lightprobe_cell_middle(int side, int level, int x)
{
    float h = LIGHTPROBE_FLOAT(2 << level) / LIGHTPROBE_FLOAT(side);
    LIGHTPROBE_PRECISE float s = (LIGHTPROBE_FLOAT(x) + 0.5f) * h - 1.0f;
    return s < 1.0f ? s : 1.0f;
}

// The leaf of a cell. A black one must belong somewhere, too: its direction is that of its middle.
LIGHTPROBE_SHARED lightprobe_leaf lightprobe_leaf_of(const lightprobe__work *w, int face, int level,
                                                     int x, int y)
{
    lightprobe_cell cell = lightprobe_cell_at(w, face, level, x, y);
    lightprobe_leaf leaf;
    leaf.face = face;
    leaf.level = level;
    leaf.x = x;
    leaf.y = y;
    leaf.cluster = 0;
    for (int i = 0; i < 3; i++) leaf.flux[i] = cell.flux[i];
    lightprobe_to_world(face, cell.resultant[0], cell.resultant[1], cell.resultant[2],
                        leaf.direction);
    leaf.solid_angle = cell.flux[3];
    leaf.luminance = lightprobe_luminance(leaf.flux);
    leaf.strength = lightprobe_normalize(leaf.direction);
    leaf.tone = lightprobe_tone(leaf.luminance, leaf.solid_angle / LIGHTPROBE_SCALE, w->mean);
    LIGHTPROBE_PRECISE float r = leaf.luminance > 0.0f ? leaf.strength / leaf.luminance : 1.0f;
    LIGHTPROBE_PRECISE float square = 1.5f * (1.0f - r * r); // uniform: half-width^2 / 3
    leaf.half_width = square > 0.0f ? sqrtf(square) : 0.0f;
    LIGHTPROBE_PRECISE float inverse =
        leaf.luminance > 0.0f ? cell.resultant[3] / leaf.luminance : 0.0f;
    leaf.inverse = inverse;
    LIGHTPROBE_PRECISE float angle = inverse * w->reach; // sums may be infinite
    leaf.parallax = angle < 1.0f ? angle : 1.0f;
    LIGHTPROBE_PRECISE float tone = leaf.tone + leaf.parallax; // sets the near apart from the far
    leaf.tone = tone;
    leaf.least = leaf.parts = 0.0f;
    if (!(leaf.strength > 0.0f))
        lightprobe_texel_direction(face, lightprobe_cell_middle(w->side, level, x),
                                   lightprobe_cell_middle(w->side, level, y), leaf.direction);
    return leaf;
}
// [glsl end]

static void lightprobe__set_leaf(lightprobe__work *w, int index, int face, int level, int x, int y)
{
    w->leaves[index] = lightprobe_leaf_of(w, face, level, x, y);
    w->leaf_errors[index] = lightprobe_leaf_error(w->leaves[index]);
}

// Six faces, then down to single texels where the light is.
static void lightprobe__make_leaves(lightprobe__work *w)
{
    float inverse = 0, last = 0;
    for (int face = 0; face < 6; face++)
        inverse += w->cells[w->first_cell[w->top] + face].resultant[3];
    lightprobe_set_scales(w, inverse);
    for (int face = 0; face < 6; face++) lightprobe__set_leaf(w, face, face, w->top, 0, 0);
    w->leaf_count = 6;
    for (;;) {
        const int index = lightprobe__largest(w->leaf_errors, w->leaf_count);
        const lightprobe_leaf parent = w->leaves[index];
        const float error = w->leaf_errors[index];
        if (lightprobe_is_enough(w->leaf_count, w->max_leaves, error, last, w->total)) break;
        last = error;
        const int level = parent.level - 1, n = lightprobe_level_side(w->side, level);
        for (int k = 0; k < 4; k++) {
            const int x = 2 * parent.x + (k & 1), y = 2 * parent.y + (k >> 1);
            if (x < n && y < n)
                lightprobe__set_leaf(w, k ? w->leaf_count++ : index, parent.face, level, x, y);
        }
    }
}

// ---- Clusters: leaves that become one light, wherever the faces meet ---- >>clusters

// [glsl begin work]
LIGHTPROBE_SHARED lightprobe_sum lightprobe_nothing(void)
{
    lightprobe_sum s;
    s.resultant[0] = s.resultant[1] = s.resultant[2] = s.luminance = s.tones = s.tones2 = 0.0f;
    s.count = 0;
    return s;
}

LIGHTPROBE_SHARED lightprobe_sum lightprobe_add_leaf(lightprobe_sum sum, lightprobe_leaf leaf)
{
    LIGHTPROBE_PRECISE lightprobe_sum s = sum;
    LIGHTPROBE_PRECISE float tones = leaf.luminance * leaf.tone;
    s.resultant[0] += leaf.strength * leaf.direction[0];
    s.resultant[1] += leaf.strength * leaf.direction[1];
    s.resultant[2] += leaf.strength * leaf.direction[2];
    s.luminance += leaf.luminance;
    s.tones += tones;
    s.tones2 += tones * leaf.tone;
    s.count++;
    return s;
}

LIGHTPROBE_SHARED lightprobe_sum lightprobe_add_sum(lightprobe_sum a, lightprobe_sum b)
{
    for (int i = 0; i < 3; i++) a.resultant[i] += b.resultant[i];
    a.luminance += b.luminance;
    a.tones += b.tones;
    a.tones2 += b.tones2;
    a.count += b.count;
    return a;
}

// What a leaf adds to the vector of a cluster with this centre. The one that adds most never
// leaves: not the brightest, since mirrored cells are equally bright, and either may come first.
// Without that clusters can run empty: of 32 lights of lamps 11 did, with a tone of 0.18.
LIGHTPROBE_SHARED float lightprobe_worth(lightprobe_leaf leaf, const lightprobe_vec3 centre)
{
    LIGHTPROBE_PRECISE float worth = leaf.strength * lightprobe_dot(leaf.direction, centre);
    return worth;
}

// Variance of direction: flux times half the mean square angle to the centre.
LIGHTPROBE_SHARED float lightprobe_sum_error(lightprobe_sum s)
{
    return s.luminance - lightprobe_length(s.resultant);
}

// What a cluster with this share of the flux holds against a leaf, which belongs where it is least:
// a squared distance by flux, since errors count squared: bright lights are kept small.
LIGHTPROBE_SHARED float lightprobe_distance(float share, const lightprobe_vec3 a, float tone_a,
                                            const lightprobe_vec3 b, float tone_b)
{
    LIGHTPROBE_PRECISE float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    LIGHTPROBE_PRECISE float tone = tone_a - tone_b;
    LIGHTPROBE_PRECISE float apart = 0.5f * (x * x + y * y + z * z + tone * tone);
    LIGHTPROBE_PRECISE float d = share * apart * apart;
    return d;
}

// What lights err by, summed over clusters: squares of what unevenness does to each, and width,
// whose share goes one way for all lights along an edge and is summed before it is squared.
typedef struct lightprobe_errors {
    float squares, width;
} lightprobe_errors;

// lightprobe_stats.error. A half-space cuts off each place of a small light with probability 1/2 a
// radian; the cosine at receivers of all orientations has the mean 1/4 and the mean square 1/6.
LIGHTPROBE_SHARED float lightprobe_root_error(lightprobe_errors e, float total)
{
    LIGHTPROBE_PRECISE float width = e.width / total, squares = e.squares / total * 1.3333333f;
    width = 0.6f * width * (1.0f - 0.5f * width);
    squares = squares + width * width;
    return squares > 0.0f ? sqrtf(squares) : 0.0f;
}
// [glsl end]

// [glsl begin splits]

// What cuts and merges are chosen by: flux squared times the variance of direction and tone, of the
// total's flux. Unevenness shows in tone: so it stands for the error behind edges.
LIGHTPROBE_SHARED float lightprobe_cost(lightprobe_sum s, float total)
{
    if (!(s.luminance > 0.0f)) return 0.0f;
    LIGHTPROBE_PRECISE float mean2 = s.tones / s.luminance * s.tones;
    LIGHTPROBE_PRECISE float spread = lightprobe_sum_error(s) + 0.5f * (s.tones2 - mean2);
    LIGHTPROBE_PRECISE float cost = s.luminance / total * spread;
    return cost > 0.0f ? cost : 0.0f;
}
// [glsl end]

// [glsl begin moving]

// Of a leaf to a cluster's seed on a moving probe, however fine the leaves are: the 4th root of the
// distance grows about as the angle does. The tone counts half, since it jumps as cells change.
LIGHTPROBE_SHARED float lightprobe_seed_distance(const lightprobe__work *w, int leaf, int k)
{
    LIGHTPROBE_PRECISE float share = w->clusters[k].seed_share + 0.01f;
    if (w->clusters[k].lives == 0) return FLT_MAX;
    return sqrtf(
        sqrtf(lightprobe_distance(share, w->leaves[leaf].direction, 0.5f * w->leaves[leaf].tone,
                                  w->clusters[k].seed, 0.5f * w->clusters[k].seed_tone)));
}

// Tone of what shines in a leaf, however dark the rest of it is: 7% less error of 8 lights at rest.
LIGHTPROBE_SHARED float lightprobe_own_tone(lightprobe_leaf leaf, float mean)
{
    float all = leaf.solid_angle / LIGHTPROBE_SCALE;
    LIGHTPROBE_PRECISE float least = all / LIGHTPROBE_FLOAT(1 << (2 * leaf.level));
    LIGHTPROBE_PRECISE float lit = 4.0f * leaf.half_width * leaf.half_width;
    lit = lit < all ? (lit > least ? lit : least) : all;
    LIGHTPROBE_PRECISE float tone = lightprobe_tone(leaf.luminance, lit, mean) + leaf.parallax;
    return tone;
}

// What a cluster takes of a leaf, to be divided by the sum of all. least: distance of the nearest.
// Wide leaves are shared further: with one width for all, lights of noise step 1.7 times as far.
LIGHTPROBE_SHARED float lightprobe_part(float distance, float least, float half_width, float unit)
{
    LIGHTPROBE_PRECISE float softness = unit * (1.0f + 5.0f * half_width);
    LIGHTPROBE_PRECISE float part = 1.0f - (distance - least) / softness;
    return part > 0.0f ? part : 0.0f;
}

LIGHTPROBE_SHARED float lightprobe_takes(const lightprobe__work *w, int leaf, int k)
{
    return lightprobe_part(lightprobe_seed_distance(w, leaf, k), w->leaves[leaf].least,
                           w->leaves[leaf].half_width, w->unit) /
           w->leaves[leaf].parts;
}

LIGHTPROBE_SHARED lightprobe_moments lightprobe_no_moments(void)
{
    lightprobe_moments m;
    for (int i = 0; i < 3; i++) m.flux[i] = m.resultant[i] = m.second[i] = m.second[3 + i] = 0.0f;
    m.tones = 0.0f;
    return m;
}

LIGHTPROBE_SHARED lightprobe_moments lightprobe_add_moments(lightprobe_moments sum,
                                                            lightprobe_leaf leaf, float part)
{
    LIGHTPROBE_PRECISE lightprobe_moments m = sum;
    LIGHTPROBE_PRECISE float mean = leaf.luminance > 0.0f ? leaf.strength / leaf.luminance : 0.0f;
    LIGHTPROBE_PRECISE float spread =
        0.5f * part * (leaf.luminance - leaf.strength) * (1.0f + mean);
    LIGHTPROBE_PRECISE float strength = part * leaf.strength, along = strength * mean - spread;
    LIGHTPROBE_PRECISE float luminance = part * leaf.luminance, tones = luminance * leaf.tone;
    m.tones += tones;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        LIGHTPROBE_PRECISE float flux = part * leaf.flux[i], vector = strength * leaf.direction[i];
        LIGHTPROBE_PRECISE float square = along * leaf.direction[i] * leaf.direction[i] + spread;
        LIGHTPROBE_PRECISE float product = along * leaf.direction[i] * leaf.direction[j];
        m.flux[i] += flux;
        m.resultant[i] += vector;
        m.second[i] += square;
        m.second[3 + i] += product;
    }
    return m;
}

LIGHTPROBE_SHARED lightprobe_moments lightprobe_more(lightprobe_moments a, lightprobe_moments b,
                                                     float times)
{
    LIGHTPROBE_PRECISE lightprobe_moments m = a;
    for (int i = 0; i < 3; i++) {
        m.flux[i] += times * b.flux[i];
        m.resultant[i] += times * b.resultant[i];
        m.second[i] += times * b.second[i];
        m.second[3 + i] += times * b.second[3 + i];
    }
    return m;
}

// Length of the mean direction.
LIGHTPROBE_SHARED float lightprobe_evenness(lightprobe_moments m)
{
    float luminance = lightprobe_luminance(m.flux);
    return luminance > 0.0f ? lightprobe_length(m.resultant) / luminance : 0.0f;
}

// state[]: 0 seed, 3 its tone, 4 its share (-1: fades out), 5 frames to fade, 6 late flux, 9
// resultant and 12 second moments, of the total's luminance.

// Whether lights can go on from the previous ones, whose irradiance in all is given: not if the map
// has jumped by a tenth.
LIGHTPROBE_SHARED int lightprobe_goes_on(float all, float total)
{
    LIGHTPROBE_PRECISE float flux = all * LIGHTPROBE_SCALE, apart = fabsf(flux - total);
    return apart < 0.1f * total ? 1 : 0;
}

// The variance of lightprobe_half_size.
LIGHTPROBE_SHARED float lightprobe_variance(float tangent)
{
    LIGHTPROBE_PRECISE float square = tangent * tangent, variance = square / (3.0f + 3.0f * square);
    return variance;
}

// What a previous light had of its leaves.
LIGHTPROBE_SHARED lightprobe_moments lightprobe_past(lightprobe_light l, lightprobe_moments late)
{
    LIGHTPROBE_PRECISE lightprobe_moments m = lightprobe_no_moments();
    LIGHTPROBE_PRECISE float luminance = LIGHTPROBE_SCALE * lightprobe_luminance(l.irradiance);
    LIGHTPROBE_PRECISE float strength = luminance * (0.5f + 0.5f * l.cos_alpha);
    LIGHTPROBE_PRECISE float u = luminance * lightprobe_variance(l.tan_half_u);
    LIGHTPROBE_PRECISE float v = luminance * lightprobe_variance(l.tan_half_v),
                             d = luminance - u - v;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        LIGHTPROBE_PRECISE float flux = LIGHTPROBE_SCALE * l.irradiance[i];
        LIGHTPROBE_PRECISE float vector = strength * l.direction[i];
        LIGHTPROBE_PRECISE float du = u * l.axis_u[i], dv = v * l.axis_v[i],
                                 dd = d * l.direction[i];
        m.flux[i] = flux;
        m.resultant[i] = vector;
        m.second[i] = du * l.axis_u[i] + dv * l.axis_v[i] + dd * l.direction[i];
        m.second[3 + i] = du * l.axis_u[j] + dv * l.axis_v[j] + dd * l.direction[j];
    }
    return lightprobe_more(m, late, -1.0f);
}

// A cluster that has no leaves yet.
LIGHTPROBE_SHARED lightprobe_cluster lightprobe_fresh(void)
{
    lightprobe_cluster c;
    c.sum = lightprobe_nothing();
    c.now = c.past = c.late = lightprobe_no_moments();
    for (int i = 0; i < 3; i++)
        c.centre[i] = c.seed[i] = c.slopes[i] = c.across[i] = c.sizes[i] = 0.0f;
    c.tone = c.seed_tone = c.seed_share = c.longest = c.distance = 0.0f;
    c.error = c.gain = 0.0f;
    c.planned = c.changed = c.brightest = c.first = c.near_count = 0;
    c.id = -1;
    c.lives = 1;
    return c;
}

// The cluster of a previous light. jumps: nothing fades that it had besides its leaves.
LIGHTPROBE_SHARED lightprobe_cluster lightprobe_recalled(lightprobe_light l, float total, int jumps)
{
    LIGHTPROBE_PRECISE lightprobe_cluster c = lightprobe_fresh();
    for (int i = 0; i < 3; i++) {
        c.seed[i] = l.state[i];
        c.slopes[i] = l.slope_u * l.axis_u[i] + l.slope_v * l.axis_v[i];
        c.across[i] = l.axis_u[i];
    }
    lightprobe_normalize(c.seed);
    c.seed_tone = l.state[3];
    c.seed_share = l.state[4];
    c.lives = c.seed_share > 0.0f ? 1 : 0;
    c.id = l.id;
    c.distance = l.distance > 0.0f && l.distance <= 1e9f ? l.distance : 0.0f;
    c.sizes[0] = lightprobe_variance(l.tan_half_u);
    c.sizes[1] = lightprobe_variance(l.tan_half_v);
    c.sizes[2] = 1.0f - l.cos_alpha;
    if (jumps != 0) return c;
    for (int i = 0; i < 3; i++) {
        c.late.flux[i] = total * l.state[6 + i];
        c.late.resultant[i] = total * l.state[9 + i];
        c.late.second[i] = total * l.state[12 + i];
        c.late.second[3 + i] = total * l.state[15 + i];
    }
    c.past = lightprobe_past(l, c.late);
    c.longest = 0.5f + 0.5f * l.cos_alpha;
    return c;
}

// Radians by which the light of this light's leaves has turned since the last frame, by its share.
LIGHTPROBE_SHARED float lightprobe_moved(lightprobe_moments now, lightprobe_moments past,
                                         float total)
{
    lightprobe_vec3 way;
    lightprobe_normalize(now.resultant);
    if (!(lightprobe_normalize(past.resultant) > 0.0f)) return 0.0f;
    for (int i = 0; i < 3; i++) {
        LIGHTPROBE_PRECISE float step = now.resultant[i] - past.resultant[i];
        way[i] = step;
    }
    LIGHTPROBE_PRECISE float moved =
        lightprobe_luminance(now.flux) / total * lightprobe_length(way);
    return moved;
}

// Sums of lights' late flux below 0 and above, and of it times the light's flux, or 0 for these.
typedef struct lightprobe_excess {
    lightprobe_wide sum[2][3], weighted[2][3];
} lightprobe_excess;

// A light's flux in this frame or the last, whichever is more.
LIGHTPROBE_SHARED float lightprobe_most(float late, float now)
{
    return late > 0.0f ? now + late : now;
}

// weighted: 1, or 0 for sums alone.
LIGHTPROBE_SHARED lightprobe_excess lightprobe_all_excess(const lightprobe__work *w, int weighted)
{
    lightprobe_excess e;
    for (int i = 0; i < 6; i++) e.sum[i / 3][i % 3] = e.weighted[i / 3][i % 3] = LIGHTPROBE_ZERO;
    for (int k = 0; k < w->cluster_count; k++) {
        for (int i = 0; i < 3; i++) {
            float late = w->clusters[k].late.flux[i], now = w->clusters[k].now.flux[i];
            int over = late > 0.0f ? 1 : 0;
            float weight = weighted != 0 ? lightprobe_most(late, now) : 0.0f;
            LIGHTPROBE_PRECISE float more = weight * fabsf(late);
            LIGHTPROBE_ADD(e.sum[over][i], fabsf(late));
            LIGHTPROBE_ADD(e.weighted[over][i], more);
        }
    }
    return e;
}

// Late moments cut so that the flux of all lights' becomes 0. What the map itself has gained or
// lost changes at once, where bright lights have changed: the larger of the two sums is cut down to
// the other, with the lights' flux as weight, and what is then left without. So a sky stays as it
// is while a sun brightens. Direction and width of what is shown stay.
LIGHTPROBE_SHARED lightprobe_moments lightprobe_balanced(lightprobe_moments late,
                                                         lightprobe_moments now,
                                                         lightprobe_excess e)
{
    LIGHTPROBE_PRECISE lightprobe_moments m = late;
    for (int i = 0; i < 3; i++) {
        int over = late.flux[i] > 0.0f ? 1 : 0;
        float own = LIGHTPROBE_VALUE(e.sum[over][i]);
        float other = LIGHTPROBE_VALUE(e.sum[1 - over][i]);
        float weights = LIGHTPROBE_VALUE(e.weighted[over][i]);
        LIGHTPROBE_PRECISE float cut = (own - other) * lightprobe_most(late.flux[i], now.flux[i]);
        LIGHTPROBE_PRECISE float kept = 1.0f;
        if (own > other) kept = weights > 0.0f ? 1.0f - cut / weights : other / own;
        m.flux[i] *= kept > 0.0f ? kept : 0.0f;
    }
    LIGHTPROBE_PRECISE float change =
        lightprobe_luminance(m.flux) - lightprobe_luminance(late.flux);
    lightprobe_moments shape = lightprobe_more(now, late, 1.0f);
    float whole = lightprobe_luminance(shape.flux);
    if (change > whole) { // it shows little yet
        shape = now;
        whole = lightprobe_luminance(now.flux);
    }
    LIGHTPROBE_PRECISE float part = change / (whole + 1e-30f);
    for (int i = 0; i < 3; i++) shape.flux[i] = 0.0f; // that is cut already
    return lightprobe_more(m, shape, part);
}

// Sums and means of a cluster, and which leaf adds most, from count leaves that are sorted; without
// light it keeps its centre and tone.
LIGHTPROBE_SHARED void lightprobe_sum_cluster(lightprobe__work *w, int k, int count)
{
    lightprobe_sum sum = lightprobe_nothing();
    int first = w->clusters[k].first;
    for (int at = first; at < first + count; at++)
        sum = lightprobe_add_leaf(sum, w->leaves[w->order[at]]);
    w->clusters[k].sum = sum;
    float size = lightprobe_normalize(sum.resultant), most = -FLT_MAX;
    for (int i = 0; i < 3 && size > 0.0f; i++) w->clusters[k].centre[i] = sum.resultant[i];
    if (sum.luminance > LIGHTPROBE_BLACK) w->clusters[k].tone = sum.tones / sum.luminance;
    for (int at = first; at < first + count; at++) {
        float worth = lightprobe_worth(w->leaves[w->order[at]], w->clusters[k].centre);
        if (worth <= most) continue;
        most = worth;
        w->clusters[k].brightest = w->order[at];
    }
}
// [glsl end]

// Sorts the leaves by cluster (counting sort) and sums them.
static void lightprobe__sum_clusters(lightprobe__work *w)
{
    int end = 0;
    for (int k = 0; k < w->cluster_count; k++) w->clusters[k].sum.count = 0;
    for (int i = 0; i < w->leaf_count; i++) w->clusters[w->leaves[i].cluster].sum.count++;
    for (int k = 0; k < w->cluster_count; k++)
        w->clusters[k].first = end += w->clusters[k].sum.count;
    for (int i = w->leaf_count - 1; i >= 0; i--)
        w->order[--w->clusters[w->leaves[i].cluster].first] = i;
    for (int k = 0; k < w->cluster_count; k++)
        lightprobe_sum_cluster(w, k, w->clusters[k].sum.count);
}

// [glsl begin splits]

// Second moments of direction (xx yy zz xy yz zx) and tone around their means; variance of the
// leaves' own spread along any axis.
typedef struct lightprobe_spread {
    float m[6], tone2, own;
} lightprobe_spread;

// scale: 1 over the luminance of all.
LIGHTPROBE_SHARED lightprobe_spread lightprobe_add_spread(lightprobe_spread all,
                                                          lightprobe_leaf leaf,
                                                          const lightprobe_vec3 mean,
                                                          float mean_tone, float scale)
{
    LIGHTPROBE_PRECISE lightprobe_spread s = all;
    LIGHTPROBE_PRECISE float f = leaf.luminance * scale, tone = leaf.tone - mean_tone;
    LIGHTPROBE_PRECISE float x = leaf.direction[0] - mean[0];
    LIGHTPROBE_PRECISE float y = leaf.direction[1] - mean[1], z = leaf.direction[2] - mean[2];
    s.m[0] += f * x * x;
    s.m[1] += f * y * y;
    s.m[2] += f * z * z;
    s.m[3] += f * x * y;
    s.m[4] += f * y * z;
    s.m[5] += f * z * x;
    s.tone2 += f * tone * tone;
    s.own += f * leaf.half_width * leaf.half_width * 0.33333333f;
    return s;
}

// First eigenvector of a symmetric matrix (xx yy zz xy yz zx): three squarings leave little but it
// (ratio of eigenvalues to the 8th power), and the longest copy of it is a column.
LIGHTPROBE_SHARED void lightprobe_eigenvector(const float matrix[6],
                                              LIGHTPROBE_OUT lightprobe_vec3 v)
{
    LIGHTPROBE_PRECISE float m[6];
    for (int i = 0; i < 6; i++) m[i] = matrix[i];
    for (int round = 0; round < 3; round++) {
        LIGHTPROBE_PRECISE float trace = m[0] + m[1] + m[2];
        float s = trace > 1e-18f ? 1.0f / trace : 0.0f;
        LIGHTPROBE_PRECISE float a = m[0] * s, b = m[1] * s, d = m[2] * s;
        LIGHTPROBE_PRECISE float ab = m[3] * s, bd = m[4] * s, da = m[5] * s;
        m[0] = a * a + ab * ab + da * da;
        m[1] = ab * ab + b * b + bd * bd;
        m[2] = da * da + bd * bd + d * d;
        m[3] = a * ab + ab * b + da * bd;
        m[4] = ab * da + b * bd + bd * d;
        m[5] = da * a + bd * ab + d * da;
    }
    int k = m[0] >= m[1] ? (m[0] >= m[2] ? 0 : 2) : (m[1] >= m[2] ? 1 : 2);
    v[0] = k == 0 ? m[0] : k == 1 ? m[3] : m[5];
    v[1] = k == 0 ? m[3] : k == 1 ? m[1] : m[4];
    v[2] = k == 0 ? m[5] : k == 1 ? m[4] : m[2];
    if (!(lightprobe_normalize(v) > 0.0f)) v[1] = 1.0f;
}

// Bins around a mean; scale is 0 where nothing varies.
LIGHTPROBE_SHARED lightprobe_axis lightprobe_axis_around(float middle, float variance)
{
    lightprobe_axis axis;
    float deviation = variance > 0.0f ? sqrtf(variance) : 0.0f;
    LIGHTPROBE_PRECISE float width = LIGHTPROBE_REACH * deviation;
    LIGHTPROBE_PRECISE float low = middle - width;
    for (int i = 0; i < 3; i++) axis.direction[i] = 0.0f;
    axis.by_tone = 1;
    axis.low = low;
    axis.scale = deviation < 1e-7f ? 0.0f : LIGHTPROBE_FLOAT(LIGHTPROBE_BINS) / (2.0f * width);
    axis.threshold = 0.0f;
    return axis;
}

LIGHTPROBE_SHARED lightprobe_axis lightprobe_axis_along(const lightprobe_vec3 d,
                                                        lightprobe_spread spread,
                                                        const lightprobe_vec3 mean)
{
    LIGHTPROBE_PRECISE float variance = fabsf(lightprobe_product(spread.m, d, d)) + spread.own;
    lightprobe_axis axis = lightprobe_axis_around(lightprobe_dot(mean, d), variance);
    for (int i = 0; i < 3; i++) axis.direction[i] = d[i];
    axis.by_tone = 0;
    return axis;
}

// Across an axis. Light from all around has no such axis: the same one once more.
LIGHTPROBE_SHARED lightprobe_axis lightprobe_axis_across(lightprobe_axis axis,
                                                         lightprobe_spread spread,
                                                         const lightprobe_vec3 mean)
{
    lightprobe_vec3 d;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        LIGHTPROBE_PRECISE float across = mean[j] * axis.direction[k] - mean[k] * axis.direction[j];
        d[i] = across;
    }
    if (!(lightprobe_normalize(d) > 1e-3f)) return axis;
    return lightprobe_axis_along(d, spread, mean);
}

// Along which a cluster is split, or its unevenness measured.
typedef struct lightprobe_axes {
    lightprobe_axis along, across, by_tone;
} lightprobe_axes;

// first: in order[], of sum.count leaves. The second axis and the leaves' own spread change errors
// by .2%, but without them rounding chooses the cut of what is as wide as high.
LIGHTPROBE_SHARED lightprobe_axes lightprobe_axes_of(const lightprobe__work *w, int first,
                                                     lightprobe_sum sum)
{
    lightprobe_axes axes;
    lightprobe_spread spread;
    lightprobe_vec3 mean, longest;
    LIGHTPROBE_PRECISE float scale = sum.luminance > LIGHTPROBE_BLACK ? 1.0f / sum.luminance : 0.0f;
    LIGHTPROBE_PRECISE float tone = sum.tones * scale;
    for (int i = 0; i < 3; i++) {
        LIGHTPROBE_PRECISE float part = sum.resultant[i] * scale;
        mean[i] = part;
        spread.m[i] = spread.m[3 + i] = spread.tone2 = spread.own = 0.0f;
    }
    for (int at = first; at < first + sum.count; at++)
        spread = lightprobe_add_spread(spread, w->leaves[w->order[at]], mean, tone, scale);
    lightprobe_eigenvector(spread.m, longest);
    axes.along = lightprobe_axis_along(longest, spread, mean);
    axes.across = lightprobe_axis_across(axes.along, spread, mean);
    axes.by_tone = lightprobe_axis_around(tone, spread.tone2);
    return axes;
}

// Where a leaf lies on an axis, and in which bin.
LIGHTPROBE_SHARED float lightprobe_along(lightprobe_axis axis, lightprobe_leaf leaf)
{
    return axis.by_tone != 0 ? leaf.tone : lightprobe_dot(leaf.direction, axis.direction);
}

LIGHTPROBE_SHARED int lightprobe_bin(lightprobe_axis axis, lightprobe_leaf leaf)
{
    LIGHTPROBE_PRECISE float p = (lightprobe_along(axis, leaf) - axis.low) * axis.scale;
    float last = LIGHTPROBE_FLOAT(LIGHTPROBE_BINS - 1);
    return p > 0.0f ? (p < last ? LIGHTPROBE_INT(p) : LIGHTPROBE_BINS - 1) : 0;
}

LIGHTPROBE_SHARED float lightprobe_threshold(lightprobe_axis axis, int bin)
{
    LIGHTPROBE_PRECISE float at = axis.low + LIGHTPROBE_FLOAT(bin + 1) / axis.scale;
    return at;
}

// Where along the bins of an axis a leaf begins, and its luminance a bin.
typedef struct lightprobe_streak {
    float low, density, luminance;
} lightprobe_streak;

LIGHTPROBE_SHARED lightprobe_streak lightprobe_streak_of(lightprobe_axis axis, lightprobe_leaf leaf)
{
    lightprobe_streak s;
    LIGHTPROBE_PRECISE float middle = (lightprobe_along(axis, leaf) - axis.low) * axis.scale;
    LIGHTPROBE_PRECISE float half_width = leaf.half_width * axis.scale + 1e-3f;
    LIGHTPROBE_PRECISE float low = middle - half_width;
    s.low = low;
    s.density = leaf.luminance / (2.0f * half_width);
    s.luminance = leaf.luminance;
    return s;
}

// Luminance below the end of a bin.
LIGHTPROBE_SHARED float lightprobe_below(lightprobe_streak s, int bin)
{
    LIGHTPROBE_PRECISE float part = (LIGHTPROBE_FLOAT(bin + 1) - s.low) * s.density;
    float most = part < s.luminance ? part : s.luminance;
    return most > 0.0f ? most : 0.0f;
}

// Cramer's distance between the light along an axis (luminance below the end of each bin) and that
// of a uniform light of the same variance, from -sqrt(3) to sqrt(3) deviations: the integral of
// their squared difference. Its mean over all axes is the energy distance, but for a factor.
LIGHTPROBE_SHARED float lightprobe_unevenness(lightprobe_axis axis,
                                              const float below[LIGHTPROBE_BINS], float luminance)
{
    LIGHTPROBE_PRECISE float sum = 0.0f;
    if (!(axis.scale > 0.0f)) return 0.0f;
    for (int i = 0; i + 1 < LIGHTPROBE_BINS; i++) {
        float place =
            LIGHTPROBE_FLOAT(2 * i + 2 - LIGHTPROBE_BINS) / LIGHTPROBE_FLOAT(LIGHTPROBE_BINS);
        LIGHTPROBE_PRECISE float even = 0.5f + 0.28867513f * LIGHTPROBE_REACH * place;
        LIGHTPROBE_PRECISE float off = below[i] / luminance - even;
        sum += off * off;
    }
    return sum / axis.scale;
}

// Mean squared error behind a random straight edge of a light for this cluster, of the total's
// flux, but for a factor. unevenness: the mean of two axes.
LIGHTPROBE_SHARED float lightprobe_edge_error(lightprobe_sum s, float unevenness, float total)
{
    if (!(s.luminance > 0.0f)) return 0.0f;
    float variance = lightprobe_sum_error(s) / s.luminance;
    if (!(variance > 0.0f)) variance = 0.0f;
    LIGHTPROBE_PRECISE float wide = variance * sqrtf(variance) * (1.0f - 0.5f * variance);
    LIGHTPROBE_PRECISE float e = unevenness + LIGHTPROBE_WIDTH * wide;
    e = s.luminance / total * (s.luminance * e);
    return e;
}

// Of the two parts of a cut; FLT_MAX where one holds no light.
LIGHTPROBE_SHARED float lightprobe_cut_cost(lightprobe_sum below, lightprobe_sum above, float total)
{
    if (!(below.luminance > 0.0f) || !(above.luminance > 0.0f)) return FLT_MAX;
    LIGHTPROBE_PRECISE float cost = lightprobe_cost(below, total) + lightprobe_cost(above, total);
    return cost;
}

// What giving one light to two clusters adds to the cost.
LIGHTPROBE_SHARED float lightprobe_merge_cost(lightprobe_sum a, lightprobe_sum b, float total)
{
    LIGHTPROBE_PRECISE float apart = lightprobe_cost(a, total) + lightprobe_cost(b, total);
    LIGHTPROBE_PRECISE float cost = lightprobe_cost(lightprobe_add_sum(a, b), total) - apart;
    return cost;
}

// Moves the leaves beyond the planned plane from one cluster to another, fresh one, and sums both.
LIGHTPROBE_SHARED void lightprobe_split(lightprobe__work *w, int k, int fresh)
{
    int i = w->clusters[k].first, end = i + w->clusters[k].sum.count;
    lightprobe_sum below = lightprobe_nothing(), above = below;
    lightprobe_axis axis = w->clusters[k].axis;
    while (i < end) {
        int index = w->order[i];
        lightprobe_leaf leaf = w->leaves[index];
        if (lightprobe_along(axis, leaf) < axis.threshold) {
            below = lightprobe_add_leaf(below, leaf);
            i++;
        } else {
            above = lightprobe_add_leaf(above, leaf);
            w->leaves[index].cluster = fresh;
            w->order[i] = w->order[--end];
            w->order[end] = index;
        }
    }
    w->clusters[k].sum = below;
    w->clusters[fresh].sum = above;
    w->clusters[fresh].first = i;
}

// With the errors of a cluster, times 1 or -1.
LIGHTPROBE_SHARED lightprobe_errors lightprobe_add_error(const lightprobe__work *w,
                                                         lightprobe_errors all, int k, float times)
{
    LIGHTPROBE_PRECISE lightprobe_errors e = all;
    e.squares += times * w->clusters[k].error;
    e.width += times * lightprobe_sum_error(w->clusters[k].sum);
    return e;
}

LIGHTPROBE_SHARED lightprobe_errors lightprobe_all_errors(const lightprobe__work *w)
{
    lightprobe_errors e;
    e.squares = e.width = 0.0f;
    for (int k = 0; k < w->cluster_count; k++) e = lightprobe_add_error(w, e, k, 1.0f);
    return e;
}

// Two neighbours, and what merging them costs.
typedef struct lightprobe_pair {
    int a, b;
    float cost;
} lightprobe_pair;

// The cheapest so far, or that of this cluster, which takes two unchanged ones.
LIGHTPROBE_SHARED lightprobe_pair lightprobe_cheaper_pair(const lightprobe__work *w,
                                                          lightprobe_pair so_far, int a,
                                                          int not_this)
{
    lightprobe_pair least = so_far;
    if (w->clusters[a].changed != 0 || a == not_this) return least;
    for (int n = 0; n < w->clusters[a].near_count; n++) {
        int b = w->clusters[a].nearby[n];
        if (w->clusters[b].changed != 0 || b == not_this) continue;
        float cost = lightprobe_merge_cost(w->clusters[a].sum, w->clusters[b].sum, w->total);
        if (cost >= least.cost) continue;
        least.a = a;
        least.b = b;
        least.cost = cost;
    }
    return least;
}

// Errors once a pair shares a light: more, unless the two are very uneven.
LIGHTPROBE_SHARED lightprobe_errors lightprobe_merged(const lightprobe__work *w,
                                                      lightprobe_errors all, lightprobe_pair pair)
{
    lightprobe_sum a = w->clusters[pair.a].sum, b = w->clusters[pair.b].sum;
    lightprobe_sum both = lightprobe_add_sum(a, b);
    if (!(both.luminance > 0.0f)) return all;
    LIGHTPROBE_PRECISE float share = both.luminance / w->total * both.luminance;
    LIGHTPROBE_PRECISE float variance = lightprobe_cost(both, w->total) / share;
    LIGHTPROBE_PRECISE lightprobe_errors e = all;
    LIGHTPROBE_PRECISE float apart = w->clusters[pair.a].error + w->clusters[pair.b].error;
    LIGHTPROBE_PRECISE float widths = lightprobe_sum_error(a) + lightprobe_sum_error(b);
    e.squares = e.squares - apart + lightprobe_edge_error(both, 0.1f * sqrtf(variance), w->total);
    e.width = e.width - widths + lightprobe_sum_error(both);
    return e;
}

// The dimmer's light fades out; the brighter keeps its id. from: the cluster that gets one for it.
LIGHTPROBE_SHARED void lightprobe_merge(lightprobe__work *w, lightprobe_pair pair, int from)
{
    int a = pair.a, b = pair.b;
    w->clusters[a].lives = w->clusters[a].sum.luminance >= w->clusters[b].sum.luminance ? 2 : 0;
    w->clusters[b].lives = 2 - w->clusters[a].lives;
    w->clusters[a].changed = w->clusters[b].changed = w->clusters[from].changed = 1;
    w->gains[a] = w->gains[b] = w->gains[from] = 0.0f;
}

// For a moving probe: whether a pair of clusters may give up a light, since it does not need it any
// more or another gains 16 times what that costs (errors squared). error: with the pair merged.
LIGHTPROBE_SHARED int lightprobe_should_reassign(float error, float tolerance, float gain,
                                                 float cost, float total)
{
    LIGHTPROBE_PRECISE float least = 1e-5f * total + 16.0f * cost;
    return error < 0.8f * tolerance || gain >= least ? 1 : 0;
}
// [glsl end]

// Finds the error of a cluster, and the axes for a split. Leaves as points in the bins, instead of
// streaks, would add 5% to the errors of 32 lights.
static void lightprobe__measure(lightprobe__work *w, lightprobe_cluster *c)
{
    float u[LIGHTPROBE_BINS] = {0}, v[LIGHTPROBE_BINS] = {0};
    const float luminance = c->sum.luminance;
    const lightprobe_axes axes = lightprobe_axes_of(w, c->first, c->sum);
    for (int k = 0; k < c->sum.count; k++) {
        const lightprobe_leaf *leaf = w->leaves + w->order[c->first + k];
        const lightprobe_streak a = lightprobe_streak_of(axes.along, *leaf);
        const lightprobe_streak b = lightprobe_streak_of(axes.across, *leaf);
        for (int bin = 0; bin < LIGHTPROBE_BINS; bin++) { // the last too: eight are vectors
            u[bin] += lightprobe_below(a, bin);
            v[bin] += lightprobe_below(b, bin);
        }
    }
    LIGHTPROBE_PRECISE float uneven = lightprobe_unevenness(axes.along, u, luminance) +
                                      lightprobe_unevenness(axes.across, v, luminance);
    c->error = lightprobe_edge_error(c->sum, 0.5f * uneven, w->total);
    c->axis = axes.along;
    c->tone_axis = axes.by_tone;
    c->planned = 0;
    w->gains[c - w->clusters] = c->error;
}

// The cheapest of BINS - 1 cuts across an axis: enough, since clusters are relaxed afterwards.
static void lightprobe__find_cut(const lightprobe__work *w, lightprobe_cluster *c,
                                 lightprobe_axis axis, float *least)
{
    lightprobe_sum bins[LIGHTPROBE_BINS], above[LIGHTPROBE_BINS], below = lightprobe_nothing();
    if (!(axis.scale > 0)) return;
    for (int bin = 0; bin < LIGHTPROBE_BINS; bin++) bins[bin] = lightprobe_nothing();
    above[LIGHTPROBE_BINS - 1] = below;
    for (int k = 0; k < c->sum.count; k++) {
        const lightprobe_leaf *leaf = w->leaves + w->order[c->first + k];
        lightprobe_sum *bin = bins + lightprobe_bin(axis, *leaf);
        *bin = lightprobe_add_leaf(*bin, *leaf);
    }
    for (int bin = LIGHTPROBE_BINS - 1; bin > 0; bin--)
        above[bin - 1] = lightprobe_add_sum(above[bin], bins[bin]);
    for (int cut = 0; cut + 1 < LIGHTPROBE_BINS; cut++) {
        if (!bins[cut].count) continue;
        below = lightprobe_add_sum(below, bins[cut]);
        const float cost = lightprobe_cut_cost(below, above[cut], w->total);
        if (cost >= *least) continue;
        *least = cost;
        c->axis = axis;
        c->axis.threshold = lightprobe_threshold(axis, cut);
    }
}

// Finds the best split of a measured cluster, by place or by tone (4% less error at 32 lights); its
// gain is 0 if there is none.
static void lightprobe__plan_split(lightprobe__work *w, lightprobe_cluster *c)
{
    float least = FLT_MAX;
    lightprobe__find_cut(w, c, c->axis, &least);
    lightprobe__find_cut(w, c, c->tone_axis, &least);
    c->gain = least < FLT_MAX ? lightprobe_cost(c->sum, w->total) - least : 0;
    if (!(least < FLT_MAX)) w->gains[c - w->clusters] = 0;
    c->planned = 1;
}

static lightprobe_errors lightprobe__measure_all(lightprobe__work *w)
{
    for (int k = 0; k < w->cluster_count; k++) lightprobe__measure(w, w->clusters + k);
    return lightprobe_all_errors(w);
}

// Splits the cluster with the largest error until there are enough or the error is small enough.
static void lightprobe__divide(lightprobe__work *w, float tolerance)
{
    lightprobe_errors e = lightprobe__measure_all(w);
    while (w->cluster_count < w->max_lights && lightprobe_root_error(e, w->total) > tolerance) {
        const int most = lightprobe__largest(w->gains, w->cluster_count);
        lightprobe_cluster *parent = w->clusters + most, *fresh = w->clusters + w->cluster_count;
        if (!(w->gains[most] > 0)) break;
        if (!parent->planned) { // most small clusters never come to this
            lightprobe__plan_split(w, parent);
            continue;
        }
        e = lightprobe_add_error(w, e, most, -1);
        *fresh = lightprobe_fresh();
        lightprobe_split(w, most, w->cluster_count++);
        lightprobe__measure(w, parent);
        lightprobe__measure(w, fresh);
        e = lightprobe_add_error(w, lightprobe_add_error(w, e, most, 1), w->cluster_count - 1, 1);
    }
}

// [glsl begin moving]
// The clusters whose centres are nearest to this one's.
LIGHTPROBE_SHARED void lightprobe_find_near(lightprobe__work *w, int a)
{
    float score[LIGHTPROBE_NEAR];
    int n = 0;
    for (int b = 0; b < w->cluster_count; b++) {
        if (b == a || !(w->clusters[b].sum.luminance > 0.0f)) continue;
        // 1 - cosine is half the squared distance of directions: so is this of tones.
        LIGHTPROBE_PRECISE float apart = w->clusters[a].tone - w->clusters[b].tone;
        LIGHTPROBE_PRECISE float cosine =
            lightprobe_dot(w->clusters[a].centre, w->clusters[b].centre);
        LIGHTPROBE_PRECISE float s = cosine - 0.5f * apart * apart;
        if (n == LIGHTPROBE_NEAR && s <= score[n - 1]) continue;
        int at = n < LIGHTPROBE_NEAR ? n++ : n - 1;
        for (; at > 0; at--) {
            if (score[at - 1] >= s) break;
            score[at] = score[at - 1];
            w->clusters[a].nearby[at] = w->clusters[a].nearby[at - 1];
        }
        score[at] = s;
        w->clusters[a].nearby[at] = b;
    }
    w->clusters[a].near_count = n;
}

// Of a leaf's cluster and its neighbours, across cuts and faces, the one that holds least against
// it. The leaf that adds most stays, so that no cluster runs empty.
LIGHTPROBE_SHARED int lightprobe_nearest_cluster(const lightprobe__work *w, int leaf)
{
    int own = w->leaves[leaf].cluster, to = own;
    float best = FLT_MAX;
    if (w->clusters[own].brightest == leaf) return own;
    for (int j = -1; j < w->clusters[own].near_count; j++) {
        int k = j < 0 ? own : w->clusters[own].nearby[j];
        float added = j < 0 ? 0.0f : w->leaves[leaf].luminance;
        LIGHTPROBE_PRECISE float share = (w->clusters[k].sum.luminance + added) / w->total;
        float d = lightprobe_distance(share, w->leaves[leaf].direction, w->leaves[leaf].tone,
                                      w->clusters[k].centre, w->clusters[k].tone);
        if (d >= best) continue;
        best = d;
        to = k;
    }
    return to;
}
// [glsl end]

static void lightprobe__find_near(lightprobe__work *w)
{
    for (int a = 0; a < w->cluster_count; a++) lightprobe_find_near(w, a);
}

// Lloyd's iteration.
static void lightprobe__relax(lightprobe__work *w, int rounds)
{
    for (int round = 0; round < rounds; round++) {
        int moved = 0;
        for (int i = 0; i < w->leaf_count; i++) {
            const int to = lightprobe_nearest_cluster(w, i);
            if (to == w->leaves[i].cluster) continue;
            w->leaves[i].cluster = to;
            moved = 1;
        }
        if (!moved) break;
        lightprobe__sum_clusters(w);
    }
}

// For a moving probe: lets a light fade into another where two do little more than one does, so
// that the next frame has one for where one is not enough, or none if the tolerance can spare it.
static void lightprobe__reassign_lights(lightprobe__work *w, float tolerance)
{
    const float total = w->total;
    int fades = w->fading < 0 || w->fading > 1; // one change after the other
    for (int k = 0; k < w->cluster_count; k++) fades |= !w->clusters[k].lives;
    if (fades) return;
    lightprobe_errors e = lightprobe__measure_all(w);
    for (int k = 0; k < w->cluster_count; k++) {
        w->clusters[k].changed = 0;
        lightprobe__plan_split(w, w->clusters + k);
        w->gains[k] = w->clusters[k].gain;
    }
    for (int changes = w->cluster_count / 4; changes >= 0; changes--) {
        const int most = lightprobe__largest(w->gains, w->cluster_count);
        lightprobe_pair pair = {0, 0, FLT_MAX};
        for (int k = 0; k < w->cluster_count; k++) pair = lightprobe_cheaper_pair(w, pair, k, most);
        const lightprobe_errors merged = lightprobe_merged(w, e, pair);
        if (pair.cost >= FLT_MAX ||
            !lightprobe_should_reassign(lightprobe_root_error(merged, total), tolerance,
                                        w->gains[most], pair.cost, total))
            break;
        e = merged; // at most: what the split gains is not counted
        lightprobe_merge(w, pair, most);
    }
    lightprobe__sum_clusters(w);
    lightprobe__find_near(w);
}

// Shares the leaves out among the lights of a moving probe; each belongs to the nearest.
static void lightprobe__share_out(lightprobe__work *w)
{
    for (int k = 0; k < w->cluster_count; k++) w->clusters[k].now = lightprobe_no_moments();
    for (int i = 0; i < w->leaf_count; i++) {
        lightprobe_leaf *leaf = w->leaves + i;
        lightprobe__share *share = w->shares + i;
        float least = FLT_MAX, parts = 0;
        int nearest = 0;
        for (int k = 0; k < w->cluster_count; k++) {
            w->gains[k] = lightprobe_seed_distance(w, i, k);
            if (!(w->gains[k] < least)) continue;
            least = w->gains[k];
            nearest = k;
        }
        leaf->cluster = nearest;
        leaf->least = least;
        share->count = 0;
        for (int k = 0; k < w->cluster_count; k++) {
            w->gains[k] = lightprobe_part(w->gains[k], least, leaf->half_width, w->unit);
            if (!(w->gains[k] > 0)) continue;
            parts += w->gains[k];
            share->cluster[share->count & 3] = k;
            share->part[share->count++ & 3] = w->gains[k];
        }
        for (int j = 0; j < share->count && j < 4; j++) share->part[j] /= parts;
        leaf->parts = parts;
        for (int k = 0; k < w->cluster_count; k++)
            if (w->gains[k] > 0)
                w->clusters[k].now =
                    lightprobe_add_moments(w->clusters[k].now, *leaf, w->gains[k] / parts);
    }
}

// Whether a previous light can be gone on from: not if it was not made here or has been spoiled,
// nor if it is there twice, as what an earlier frame left behind the last light is.
static int lightprobe__is_sound(const lightprobe_light *all, int i)
{
    const lightprobe_light *l = all + i;
    int sound = l->cos_alpha >= -1 && l->cos_alpha <= 1 && l->solid_angle >= 0 &&
                l->solid_angle < 13 && l->tan_half_u >= 0 && l->tan_half_u <= 4 &&
                l->tan_half_v >= 0 && l->tan_half_v <= 4 && fabsf(l->slope_u) <= 2.5f &&
                fabsf(l->slope_v) <= 2.5f;
    for (int c = 0; c < 3; c++)
        sound &= l->irradiance[c] >= 0 && l->irradiance[c] <= FLT_MAX &&
                 fabsf(l->direction[c]) <= 2 && fabsf(l->axis_u[c]) <= 2 &&
                 fabsf(l->axis_v[c]) <= 2;
    for (int k = 0; k < 18; k++) sound &= fabsf(l->state[k]) <= LIGHTPROBE_FADE;
    for (int k = 0; k < i && l->id >= 0; k++) sound &= all[k].id != l->id;
    return sound && lightprobe_dot(l->state, l->state) > 0.1f;
}

// One cluster of everything, or those of the previous frame's lights.
static void lightprobe__start(lightprobe__work *w, const lightprobe_light *previous, int count)
{
    double all = 0;
    w->cluster_count = 0;
    for (int i = 0; i < count; i++)
        all += lightprobe__is_sound(previous, i)
                   ? (double)lightprobe_luminance(previous[i].irradiance)
                   : 0;
    w->jumps = w->jumps || count > w->max_lights || !lightprobe_goes_on((float)all, w->total);
    w->fading = 0;
    for (int i = 0; i < count && w->cluster_count < w->max_lights; i++) {
        if (!lightprobe__is_sound(previous, i)) continue;
        w->clusters[w->cluster_count++] = lightprobe_recalled(previous[i], w->total, w->jumps);
        w->fading = w->jumps ? 0 : previous[i].state[5];
    }
    int lives = 0;
    for (int k = 0; k < w->cluster_count; k++) lives |= w->clusters[k].lives;
    if (!lives) {
        w->jumps = 1;
        w->fading = 0;
        w->clusters[0] = lightprobe_fresh();
        w->cluster_count = 1;
    }
    for (int i = 0; i < w->leaf_count && count; i++)
        w->leaves[i].tone = lightprobe_own_tone(w->leaves[i], w->mean);
    if (count) lightprobe__share_out(w);
    lightprobe__sum_clusters(w);
}

// [glsl begin moving]
// Of a light that has none, as all are in a first frame or where the map jumped: at the light.
LIGHTPROBE_SHARED void lightprobe_set_seed(lightprobe__work *w, int k)
{
    int end = w->clusters[k].first + w->clusters[k].sum.count;
    lightprobe_moments now = lightprobe_no_moments();
    for (int at = w->clusters[k].first; at < end; at++) {
        lightprobe_leaf leaf = w->leaves[w->order[at]];
        leaf.tone = lightprobe_own_tone(leaf, w->mean);
        now = lightprobe_add_moments(now, leaf, 1.0f);
    }
    w->clusters[k].now = now;
    if (!(lightprobe_normalize(now.resultant) > 0.0f)) now.resultant[1] = 1.0f;
    for (int i = 0; i < 3; i++) w->clusters[k].seed[i] = now.resultant[i];
    float luminance = lightprobe_luminance(now.flux);
    LIGHTPROBE_PRECISE float tone = luminance > LIGHTPROBE_BLACK ? now.tones / luminance : 0.0f;
    LIGHTPROBE_PRECISE float share = luminance / w->total + 1e-9f;
    w->clusters[k].seed_tone = tone;
    w->clusters[k].seed_share = share;
    if (!(luminance > 0.0f)) w->clusters[k].lives = 0;
}

// Whether a light is new, or has taken over another's place.
LIGHTPROBE_SHARED int lightprobe_is_changed(const lightprobe__work *w)
{
    for (int k = 0; k < w->cluster_count; k++)
        if (w->clusters[k].id < 0 || w->clusters[k].lives == 2) return 1;
    return 0;
}

// How many frames one counts for in which all lights have moved so far; that is not known where
// leaves have been given away.
LIGHTPROBE_SHARED float lightprobe_pace(const lightprobe__work *w, int changes)
{
    LIGHTPROBE_PRECISE float moved = 0.0f;
    for (int k = 0; k < w->cluster_count && changes == 0; k++)
        moved += lightprobe_moved(w->clusters[k].now, w->clusters[k].past, w->total);
    moved = moved / LIGHTPROBE_STEP;
    return moved > 1.0f ? (moved < LIGHTPROBE_FASTEST ? moved : LIGHTPROBE_FASTEST) : 1.0f;
}

// What a light has of lights that have changed, so that nothing jumps. A part of it is left a frame
// later, in the end nothing. No light becomes negative.
LIGHTPROBE_SHARED void lightprobe_fade(lightprobe__work *w, int k, int changes, float pace,
                                       float frames)
{
    lightprobe_moments now = w->clusters[k].now, past = w->clusters[k].past;
    lightprobe_moments late = w->clusters[k].late;
    LIGHTPROBE_PRECISE float slow = w->clusters[k].lives != 0 ? 9.0f / (9.0f + pace) : 0.0f;
    LIGHTPROBE_PRECISE float rest = frames > pace ? 1.0f - pace / frames : slow;
    float longest = lightprobe_evenness(now);
    if (longest > w->clusters[k].longest) w->clusters[k].longest = longest;
    if (changes != 0) late = lightprobe_more(lightprobe_more(late, past, 1.0f), now, -1.0f);
    late = lightprobe_more(lightprobe_no_moments(), late, rest);
    for (int i = 0; i < 3; i++) {
        LIGHTPROBE_PRECISE float least = -0.999f * now.flux[i];
        if (late.flux[i] < least) late.flux[i] = least;
    }
    w->clusters[k].late = late;
}
// [glsl end]

static void lightprobe__fade(lightprobe__work *w)
{
    const int changes = w->fading < 0 || lightprobe_is_changed(w);
    const float frames = changes ? LIGHTPROBE_FADE : w->fading;
    w->pace = lightprobe_pace(w, changes);
    for (int k = 0; k < w->cluster_count; k++) lightprobe_fade(w, k, changes, w->pace, frames);
    w->fading = frames > w->pace ? frames - w->pace : 0;
    for (int weighted = 1; weighted >= 0; weighted--) {
        const lightprobe_excess e = lightprobe_all_excess(w, weighted);
        for (int k = 0; k < w->cluster_count; k++)
            w->clusters[k].late = lightprobe_balanced(w->clusters[k].late, w->clusters[k].now, e);
    }
}

// ---- Lights ---- >>lights

// [glsl begin lights]
// Standard deviation of a light's irradiance behind random half-spaces, in parts of the total's
// mean, which is the shadow that is lost without a map: share of the flux times the root of 8/3
// (1/4 - a / (2 pi)), a the mean angle between two points of it (a disc's, and 1.57 all around).
LIGHTPROBE_SHARED float lightprobe_shadow(lightprobe_sum s, float total)
{
    float variance = lightprobe_sum_error(s) / s.luminance;
    float root = sqrtf(fabsf(variance)); // rounding may be negative
    LIGHTPROBE_PRECISE float angle = root * (1.81f - 0.24f * root);
    LIGHTPROBE_PRECISE float square = 0.66666667f - 0.42441318f * angle;
    LIGHTPROBE_PRECISE float shadow = s.luminance / total * sqrtf(fabsf(square));
    return shadow;
}

LIGHTPROBE_SHARED lightprobe_region lightprobe_no_region(void)
{
    lightprobe_region r;
    for (int i = 0; i < 3; i++) {
        r.flux[i] = r.resultant[i] = r.second[i] = LIGHTPROBE_ZERO;
        r.d[i] = r.e[i] = r.f[i] = 0.0f;
    }
    r.luminance = r.solid_angle = r.inverse = LIGHTPROBE_ZERO;
    return r;
}

// Adds so much of a leaf.
LIGHTPROBE_SHARED lightprobe_region lightprobe_add_region(lightprobe_region region,
                                                          lightprobe_leaf leaf, float part)
{
    lightprobe_region r = region;
    LIGHTPROBE_PRECISE float luminance = part * leaf.luminance, omega = part * leaf.solid_angle;
    LIGHTPROBE_PRECISE float strength = part * leaf.strength, inverse = luminance * leaf.inverse;
    for (int i = 0; i < 3; i++) {
        LIGHTPROBE_PRECISE float flux = part * leaf.flux[i], vector = strength * leaf.direction[i];
        LIGHTPROBE_ADD(r.flux[i], flux);
        LIGHTPROBE_ADD(r.resultant[i], vector);
    }
    LIGHTPROBE_ADD(r.luminance, luminance);
    LIGHTPROBE_ADD(r.solid_angle, omega);
    LIGHTPROBE_ADD(r.inverse, inverse);
    return r;
}

// Two unit vectors that make a right-handed frame (e, f, d).
LIGHTPROBE_SHARED void lightprobe_frame(const lightprobe_vec3 d, LIGHTPROBE_OUT lightprobe_vec3 e,
                                        LIGHTPROBE_OUT lightprobe_vec3 f)
{
    float x = fabsf(d[0]), y = fabsf(d[1]), z = fabsf(d[2]);
    int k = x < y ? (x < z ? 0 : 2) : (y < z ? 1 : 2);
    for (int i = 0; i < 3; i++) {
        LIGHTPROBE_PRECISE float across = (i == k ? 1.0f : 0.0f) - d[k] * d[i];
        e[i] = across;
    }
    lightprobe_normalize(e);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, l = (i + 2) % 3;
        LIGHTPROBE_PRECISE float cross = d[j] * e[l] - d[l] * e[j];
        f[i] = cross;
    }
}

// Then the leaves again: along e and f nothing cancels, however narrow the light. A leaf's light is
// spread evenly around its mean direction, as far as the length of the vector irradiance tells.
LIGHTPROBE_SHARED lightprobe_region lightprobe_add_second(lightprobe_region region,
                                                          lightprobe_leaf leaf, float part)
{
    lightprobe_region r = region;
    LIGHTPROBE_PRECISE float luminance = part * leaf.luminance, strength = part * leaf.strength;
    LIGHTPROBE_PRECISE float mean = luminance > 0.0f ? strength / luminance : 0.0f;
    LIGHTPROBE_PRECISE float spread = 0.5f * (luminance - strength) * (1.0f + mean);
    LIGHTPROBE_PRECISE float along = strength * mean - spread;
    float e = lightprobe_dot(leaf.direction, r.e);
    float f = lightprobe_dot(leaf.direction, r.f);
    LIGHTPROBE_PRECISE float ee = along * e * e + spread;
    LIGHTPROBE_PRECISE float ff = along * f * f + spread;
    LIGHTPROBE_PRECISE float ef = along * e * f;
    LIGHTPROBE_ADD(r.second[0], ee);
    LIGHTPROBE_ADD(r.second[1], ff);
    LIGHTPROBE_ADD(r.second[2], ef);
    return r;
}

// Whatever light a leaf belongs to: by its own leaves alone one of few has no plane, or a wrong
// one. They count the less the further they are, and nothing from sqrt(5) times the light's own
// spread on.
LIGHTPROBE_SHARED lightprobe_tilt lightprobe_no_tilt(lightprobe_region r)
{
    LIGHTPROBE_PRECISE lightprobe_tilt t;
    LIGHTPROBE_PRECISE float size = 0.0f, inverse = LIGHTPROBE_VALUE(r.inverse);
    for (int i = 0; i < 3; i++) size = size + LIGHTPROBE_VALUE(r.resultant[i]) * r.d[i];
    t.scale = size < 2e9f * inverse ? size / inverse : 0.0f;                 // 0: infinitely far
    t.reach = 5.0f * (1.0f - size / LIGHTPROBE_VALUE(r.luminance)) + 0.001f; // beyond a texel
    t.ee = t.ff = t.ef = t.e = t.f = t.squares = t.own = 0.0f;
    return t;
}

LIGHTPROBE_SHARED lightprobe_tilt lightprobe_add_tilt(lightprobe_tilt tilt, lightprobe_region r,
                                                      lightprobe_leaf leaf)
{
    LIGHTPROBE_PRECISE lightprobe_tilt t = tilt;
    LIGHTPROBE_PRECISE float along = lightprobe_dot(leaf.direction, r.d), off = 1.0f - along;
    if (!(off < t.reach && leaf.luminance > 0.0f && t.scale > 0.0f)) return t;
    LIGHTPROBE_PRECISE float share = leaf.luminance / LIGHTPROBE_VALUE(r.luminance);
    LIGHTPROBE_PRECISE float inside = 1.0f - off / t.reach;
    LIGHTPROBE_PRECISE float part = (share < 1.0f ? share : 1.0f) * inside * inside;
    LIGHTPROBE_PRECISE float mean = leaf.strength / leaf.luminance;
    LIGHTPROBE_PRECISE float x = mean * lightprobe_dot(leaf.direction, r.e), sx = part * x;
    LIGHTPROBE_PRECISE float y = mean * lightprobe_dot(leaf.direction, r.f), sy = part * y;
    LIGHTPROBE_PRECISE float rest = leaf.inverse * t.scale;
    rest = (rest < 4.0f ? rest : 4.0f) - mean * along;
    t.own = t.own + part * (1.0f - mean * mean);
    t.ee = t.ee + sx * x;
    t.ff = t.ff + sy * y;
    t.ef = t.ef + sx * y;
    t.e = t.e + sx * rest;
    t.f = t.f + sy * rest;
    t.squares = t.squares + part * rest * rest;
    return t;
}

// What a light has besides its leaves, before its direction is found; no narrower than its parts.
// distance: of the light in the last frame.
LIGHTPROBE_SHARED lightprobe_region lightprobe_add_late(lightprobe_region region,
                                                        lightprobe_moments late, float longest,
                                                        float distance)
{
    lightprobe_region r = region;
    lightprobe_vec3 v;
    for (int i = 0; i < 3; i++) {
        LIGHTPROBE_ADD(r.flux[i], late.flux[i]);
        LIGHTPROBE_ADD(r.resultant[i], late.resultant[i]);
        v[i] = LIGHTPROBE_VALUE(r.resultant[i]);
    }
    // It lies where the light did: leaves that are left of one that has given a lamp away are the
    // wall behind. What is taken off lies as far as the leaves do.
    float leaves = LIGHTPROBE_VALUE(r.luminance), more = lightprobe_luminance(late.flux);
    LIGHTPROBE_PRECISE float inverse = distance > 0.0f ? more / distance : 0.0f;
    if (more < 0.0f) inverse = LIGHTPROBE_VALUE(r.inverse) * (more / (leaves + 1e-30f));
    LIGHTPROBE_ADD(r.inverse, inverse);
    LIGHTPROBE_ADD(r.luminance, more);
    LIGHTPROBE_PRECISE float most = longest * LIGHTPROBE_VALUE(r.luminance);
    float size = lightprobe_length(v);
    for (int i = 0; i < 3 && size > most; i++) {
        LIGHTPROBE_PRECISE float off = v[i] * (most / size - 1.0f);
        LIGHTPROBE_ADD(r.resultant[i], off);
    }
    return r;
}

// When all leaves have been added. jumps: nothing fades that the light has besides them.
LIGHTPROBE_SHARED lightprobe_region lightprobe_direct(lightprobe_region region,
                                                      lightprobe_cluster c, int jumps)
{
    lightprobe_region r = region;
    if (jumps == 0) r = lightprobe_add_late(r, c.late, c.longest, c.distance);
    for (int i = 0; i < 3; i++) r.d[i] = LIGHTPROBE_VALUE(r.resultant[i]);
    // Light from all around has no direction: any will do.
    float size = lightprobe_normalize(r.d);
    if (size < 1e-36f) lightprobe_normalize(r.d); // the length of denormal numbers has few digits
    for (int i = 0; i < 3 && size <= 1e-9f * LIGHTPROBE_VALUE(r.luminance); i++)
        r.d[i] = i == 1 ? 1.0f : 0.0f;
    lightprobe_frame(r.d, r.e, r.f);
    if (jumps != 0) return r;
    LIGHTPROBE_ADD(r.second[0], lightprobe_product(c.late.second, r.e, r.e));
    LIGHTPROBE_ADD(r.second[1], lightprobe_product(c.late.second, r.f, r.f));
    LIGHTPROBE_ADD(r.second[2], lightprobe_product(c.late.second, r.e, r.f));
    return r;
}

// Of a sum over texels, which has been scaled so that it does not overflow; what it stands for may.
LIGHTPROBE_SHARED float lightprobe_unscaled(float sum)
{
    return sum < FLT_MAX * LIGHTPROBE_SCALE ? sum / LIGHTPROBE_SCALE : FLT_MAX;
}

// Half-size d of the uniform distribution with this variance of the sine, d^2 / 3 (4.1.2: d / 3).
LIGHTPROBE_SHARED float lightprobe_half_size(float variance)
{
    LIGHTPROBE_PRECISE float sine2 = 3.0f * variance;
    LIGHTPROBE_PRECISE float rest = 1.0f - sine2;
    if (17.0f * sine2 >= 16.0f) return 4.0f;
    return sqrtf(sine2 > 0.0f ? sine2 / rest : 0.0f);
}

// Long, as GLSL has no pointers to hand parts of a light on with.
LIGHTPROBE_SHARED lightprobe_light lightprobe_light_of(lightprobe_region r)
{
    float luminance = LIGHTPROBE_VALUE(r.luminance);
    lightprobe_vec3 resultant;
    for (int i = 0; i < 3; i++) resultant[i] = LIGHTPROBE_VALUE(r.resultant[i]);
    // Principal axes of the second moments in the plane across d.
    LIGHTPROBE_PRECISE float a = LIGHTPROBE_VALUE(r.second[0]) / luminance;
    LIGHTPROBE_PRECISE float c = LIGHTPROBE_VALUE(r.second[1]) / luminance;
    LIGHTPROBE_PRECISE float b = LIGHTPROBE_VALUE(r.second[2]) / luminance;
    LIGHTPROBE_PRECISE float middle = 0.5f * (a + c);
    LIGHTPROBE_PRECISE float half_apart = 0.5f * (a - c);
    // Over the larger of the two: squares of what is left by rounding would underflow.
    float most = fabsf(half_apart) > fabsf(b) ? fabsf(half_apart) : fabsf(b);
    LIGHTPROBE_PRECISE float x = most > 0.0f ? half_apart / most : 1.0f;
    LIGHTPROBE_PRECISE float y = most > 0.0f ? fabsf(b) / most : 0.0f;
    LIGHTPROBE_PRECISE float root = sqrtf(x * x + y * y);
    LIGHTPROBE_PRECISE float wide = most * root;
    // Cosine and sine of the angle from e to u, from those of its double: the larger is a root.
    LIGHTPROBE_PRECISE float larger = sqrtf(0.5f + 0.5f * (fabsf(x) / root));
    LIGHTPROBE_PRECISE float smaller = 0.5f * (y / root) / larger;
    float cosine = x < 0.0f ? smaller : larger;
    float sine = x < 0.0f ? larger : smaller;
    sine = b < 0.0f ? -sine : sine;
    // The disc whose mean direction is as long as the region's: R = (1 + cos alpha) / 2.
    LIGHTPROBE_PRECISE float cos_alpha =
        1.0f - 2.0f * ((luminance - lightprobe_length(resultant)) / luminance);
    lightprobe_light light;
    for (int i = 0; i < 3; i++) {
        LIGHTPROBE_PRECISE float u = cosine * r.e[i] + sine * r.f[i];
        LIGHTPROBE_PRECISE float v = cosine * r.f[i] - sine * r.e[i];
        light.direction[i] = r.d[i];
        light.axis_u[i] = u;
        light.axis_v[i] = v;
        light.irradiance[i] = lightprobe_unscaled(LIGHTPROBE_VALUE(r.flux[i]));
    }
    light.tan_half_u = lightprobe_half_size(middle + wide);
    light.tan_half_v = lightprobe_half_size(middle - wide);
    light.solid_angle = LIGHTPROBE_VALUE(r.solid_angle) / LIGHTPROBE_SCALE;
    light.cos_alpha = cos_alpha < 1.0f ? cos_alpha : 1.0f;
    light.id = -1;
    // What shifts it for a receiver is 1 / distance, so that is averaged. 0 beyond 1e9.
    float inverse = LIGHTPROBE_VALUE(r.inverse);
    LIGHTPROBE_PRECISE float distance = luminance / inverse;
    light.distance = inverse > 0.0f && distance <= 1e9f ? distance : 0.0f;
    for (int i = 0; i < 18; i++) light.state[i] = 0.0f;
    light.slope_u = light.slope_v = 0.0f;
    return light;
}

// Leaves are divided as a probe turns, so half of what changes a light's sizes comes late: the less
// the more its flux has changed, or a sun that gains a texel would be bright before it is wide; and
// 1 - cosine changes by at most a tenth, or a texel. And the axes of a round light may be any: the
// least change of its leaves would turn its rectangle by up to 45 degrees. So they go only part of
// the way from axis_u in the last frame (0: there was none), all of it where squares of the sizes
// are as 5 to 3. Quarter turns are the same rectangle. side: of the map's faces.
LIGHTPROBE_SHARED lightprobe_light lightprobe_steadied(lightprobe_light light, lightprobe_cluster c,
                                                       float pace, float side)
{
    LIGHTPROBE_PRECISE lightprobe_light l = light;
    if (!(pace > 0.0f)) return l;
    float flux = lightprobe_luminance(c.now.flux), past = lightprobe_luminance(c.past.flux);
    LIGHTPROBE_PRECISE float held = (LIGHTPROBE_LATE * past - 10.0f * fabsf(flux - past)) / pace;
    held = held > 0.0f ? held / past : 0.0f;
    LIGHTPROBE_PRECISE float wide = 1.0f - l.cos_alpha;
    LIGHTPROBE_PRECISE float now = wide + held * (c.sizes[2] - wide) + 1e-7f;
    LIGHTPROBE_PRECISE float up = 1.0f + LIGHTPROBE_WIDEN * pace, texel = 2.0f / (side * side);
    LIGHTPROBE_PRECISE float least = c.sizes[2] / up - texel, most = c.sizes[2] * up + texel;
    float to = now < least ? least : now > most ? most : now;
    l.cos_alpha = 1.0f - to;
    LIGHTPROBE_PRECISE float a = lightprobe_variance(l.tan_half_u);
    LIGHTPROBE_PRECISE float b = lightprobe_variance(l.tan_half_v);
    a = (a + held * (c.sizes[0] - a)) * (to / now);
    b = (b + held * (c.sizes[1] - b)) * (to / now);
    LIGHTPROBE_PRECISE float cosine = lightprobe_dot(c.across, l.axis_u);
    LIGHTPROBE_PRECISE float sine = lightprobe_dot(c.across, l.axis_v);
    LIGHTPROBE_PRECISE float x = fabsf(cosine) > fabsf(sine) ? cosine : sine;
    LIGHTPROBE_PRECISE float y = fabsf(cosine) > fabsf(sine) ? sine : -cosine;
    LIGHTPROBE_PRECISE float part = pace * (a - b) / (LIGHTPROBE_ROUND * (a + b) + 1e-30f);
    y = part < 1.0f && fabsf(x) > 0.1f ? (1.0f - part) * (y / x) : 0.0f;
    x = 1.0f / sqrtf(1.0f + y * y);
    y = y * x;
    for (int i = 0; i < 3; i++) {
        LIGHTPROBE_PRECISE float u = light.axis_u[i], v = light.axis_v[i];
        l.axis_u[i] = x * u + y * v;
        l.axis_v[i] = x * v - y * u;
    }
    LIGHTPROBE_PRECISE float along = a * x * x + b * y * y, across = a * y * y + b * x * x;
    l.tan_half_u = lightprobe_half_size(along);
    l.tan_half_v = lightprobe_half_size(across < along ? across : along); // rounding apart
    return l;
}

// Slopes of a light's plane: 1 / distance is linear on it, and so are the leaves' means. Where they
// lie in a row, along a tube say, a dim wall beside it, a thousandth of its light, would tell the
// slope across: to squares that are less than a tenth of the leaves' own (or their rounding), so
// much is added. Counts from 80% explained on, fully from 97%, of discs up to 29 degrees, less and
// less up to 41; an edge is at most 25% nearer than the middle.
LIGHTPROBE_SHARED lightprobe_light lightprobe_tilted(lightprobe_light light, lightprobe_region r,
                                                     lightprobe_tilt t)
{
    lightprobe_light l = light;
    LIGHTPROBE_PRECISE float least = 0.1f * t.own + 1e-6f * (t.ee + t.ff) + 1e-30f;
    LIGHTPROBE_PRECISE float across = (t.ee * t.ff - t.ef * t.ef) / (t.ee + t.ff + 1e-30f);
    LIGHTPROBE_PRECISE float ridge = least / ((across > 0.0f ? across : 0.0f) + least) * least;
    LIGHTPROBE_PRECISE float ee = t.ee + ridge, ff = t.ff + ridge;
    LIGHTPROBE_PRECISE float whole = ee * ff - t.ef * t.ef + 1e-30f;
    if (!(l.distance > 0.0f)) return l;
    LIGHTPROBE_PRECISE float x = (t.e * ff - t.f * t.ef) / whole;
    LIGHTPROBE_PRECISE float y = (t.f * ee - t.e * t.ef) / whole;
    LIGHTPROBE_PRECISE float explained = x * t.e + y * t.f + ridge * (x * x + y * y);
    LIGHTPROBE_PRECISE float part = 6.0f * (explained / (t.squares + 1e-30f)) - 4.8f;
    LIGHTPROBE_PRECISE float narrow = 8.0f * l.cos_alpha - 6.0f; // wide ones are often two things
    part = part > 0.0f ? (part < 1.0f ? part : 1.0f) : 0.0f;
    part = part * (narrow > 0.0f ? (narrow < 1.0f ? narrow : 1.0f) : 0.0f);
    LIGHTPROBE_PRECISE float u =
        x * lightprobe_dot(r.e, l.axis_u) + y * lightprobe_dot(r.f, l.axis_u);
    LIGHTPROBE_PRECISE float v =
        x * lightprobe_dot(r.e, l.axis_v) + y * lightprobe_dot(r.f, l.axis_v);
    float wide = 0.10416667f; // slopes are at most 2.4
    LIGHTPROBE_PRECISE float edge = fabsf(u) * (l.tan_half_u > wide ? l.tan_half_u : wide);
    edge = edge + fabsf(v) * (l.tan_half_v > wide ? l.tan_half_v : wide);
    part = part * edge > 0.25f ? 0.25f / edge : part;
    l.slope_u = -part * u;
    l.slope_v = -part * v;
    return l;
}

// What the next frame goes on from. pace: frames that the seed goes on its way; 0 where it is new.
LIGHTPROBE_SHARED lightprobe_light lightprobe_carry_on(lightprobe_light light, lightprobe_cluster c,
                                                       float pace, float fading, float total)
{
    LIGHTPROBE_PRECISE lightprobe_light l = light;
    float luminance = lightprobe_luminance(c.now.flux);
    l.distance = luminance > 0.0f ? l.distance : c.distance; // it fades out where it was
    // Leaves that change hands would tilt it at once.
    LIGHTPROBE_PRECISE float u = lightprobe_dot(c.slopes, l.axis_u);
    LIGHTPROBE_PRECISE float v = lightprobe_dot(c.slopes, l.axis_v);
    LIGHTPROBE_PRECISE float go = luminance > 0.0f ? LIGHTPROBE_RATE * pace : 0.0f;
    LIGHTPROBE_PRECISE float turn = luminance > 0.0f ? LIGHTPROBE_TURN * pace : 0.0f;
    turn = pace > 0.0f && turn < 1.0f ? turn : 1.0f;
    l.slope_u = u + turn * (l.slope_u - u);
    l.slope_v = v + turn * (l.slope_v - v);
    lightprobe_vec3 seed;
    lightprobe_normalize(c.now.resultant);
    for (int i = 0; i < 3; i++) {
        LIGHTPROBE_PRECISE float moved = c.seed[i] + go * (c.now.resultant[i] - c.seed[i]);
        seed[i] = moved;
    }
    lightprobe_normalize(seed);
    LIGHTPROBE_PRECISE float tone = c.seed_tone, share = c.seed_share;
    if (go > 0.0f) tone = tone + go * (c.now.tones / luminance - tone);
    share = share + go * (luminance / total - share);
    for (int i = 0; i < 3; i++) {
        l.state[i] = seed[i];
        l.state[6 + i] = c.late.flux[i] / total;
        l.state[9 + i] = c.late.resultant[i] / total;
        l.state[12 + i] = c.late.second[i] / total;
        l.state[15 + i] = c.late.second[3 + i] / total;
    }
    l.state[3] = tone;
    l.state[4] = c.lives != 0 ? share : -1.0f;
    l.state[5] = fading;
    return l;
}

// Of a cluster and the region of all that it takes.
LIGHTPROBE_SHARED lightprobe_light lightprobe_make_light(const lightprobe__work *w, int k,
                                                         lightprobe_region region)
{
    float pace = w->jumps != 0 || w->clusters[k].id < 0 ? 0.0f : w->pace;
    lightprobe_tilt tilt = lightprobe_no_tilt(region);
    for (int i = 0; i < w->leaf_count && w->distances != 0; i++)
        tilt = lightprobe_add_tilt(tilt, region, w->leaves[i]);
    lightprobe_light light = lightprobe_light_of(region);
    light = lightprobe_steadied(light, w->clusters[k], pace, LIGHTPROBE_FLOAT(w->side));
    light = lightprobe_tilted(light, region, tilt);
    return lightprobe_carry_on(light, w->clusters[k], pace, w->fading, w->total);
}
// [glsl end]

static float lightprobe__clamp(double x)
{
    return (float)(x > FLT_MAX ? FLT_MAX : x < -FLT_MAX ? -FLT_MAX : x);
}

// ---- The paper's way: median cut (image-based lighting paper, sections 3.1 and 4.1) ---- >>median cut

// Texels [x0, x1) x [y0, y1) of a face.
typedef struct lightprobe__rectangle {
    int face, x0, y0, x1, y1;
} lightprobe__rectangle;

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
    for (int y = a->y0; y < a->y1; y++) {
        for (int x = a->x0; x < a->x1; x++) {
            const lightprobe_cell texel = lightprobe_small_cell(w, a->face, 0, x, y);
            profile[wide ? x - a->x0 : y - a->y0] += (double)lightprobe_luminance(texel.flux);
        }
    }
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

// Sums over the texels of a rectangle: m gets the moments of s and t (times luminance: s, t, s^2,
// t^2), v the resultant and what is over distance. Returns the luminance.
static double lightprobe__rectangle_sums(const lightprobe__work *w, const lightprobe__rectangle *r,
                                         double flux[3], double m[4], double v[4])
{
    double f = 0;
    for (int y = r->y0; y < r->y1; y++) {
        for (int x = r->x0; x < r->x1; x++) {
            const lightprobe_cell texel = lightprobe_small_cell(w, r->face, 0, x, y);
            const double l = (double)lightprobe_luminance(texel.flux);
            const double s = (double)lightprobe_centre(w->side, x);
            const double t = (double)lightprobe_centre(w->side, y);
            f += l;
            m[0] += l * s;
            m[1] += l * t;
            m[2] += l * s * s;
            m[3] += l * t * t;
            for (int i = 0; i < 3; i++) flux[i] += (double)texel.flux[i];
            for (int i = 0; i < 4; i++) v[i] += (double)texel.resultant[i];
        }
    }
    return f;
}

// Eq. 9, 10 (with 4.1.2 mended: variance = d^2 / 3) and 11 of one rectangle; returns its error.
// Sizes are divided by the centroid's distance from the origin, to be sizes at distance 1.
static double lightprobe__paper_light(const lightprobe__work *w, const lightprobe__rectangle *r,
                                      lightprobe_light *light, double *luminance)
{
    double m[4] = {0}, flux[3] = {0}, v[4] = {0}, size[2];
    const double f = lightprobe__rectangle_sums(w, r, flux, m, v);
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
        float side[3];
        lightprobe_to_world(r->face, 0, i ? 0.0f : 1.0f, i ? 1.0f : 0.0f, side);
        const float along = lightprobe_dot(side, light->direction);
        for (int k = 0; k < 3; k++) axis[k] = side[k] - along * light->direction[k];
        const double half = size[i] * (double)lightprobe_normalize(axis) / distance;
        *(i ? &light->tan_half_v : &light->tan_half_u) = (float)fmin(half, 4);
    }
    for (int i = 0; i < 3; i++)
        light->irradiance[i] = lightprobe__clamp(flux[i] / (double)LIGHTPROBE_SCALE);
    light->distance = f <= 1e9 * v[3] ? (float)(f / v[3]) : 0;
    const double h = 2.0 / w->side;
    light->solid_angle =
        (float)lightprobe__solid_angle(r->x0 * h - 1, r->y0 * h - 1, r->x1 * h - 1, r->y1 * h - 1);
    // The paper does not say how its discs follow from its rectangles: with the same solid angle.
    const double disc =
        lightprobe__solid_angle(m[0] - size[0], m[1] - size[1], m[0] + size[0], m[1] + size[1]);
    light->cos_alpha = (float)(1 - disc / 6.283185307179586);
    light->slope_u = light->slope_v = 0;
    memset(light->state, 0, sizeof light->state);
    return f - sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

// ---- Extraction ---- >>extraction

// What a light that is not written leaves to the residual, scaled as sums over texels are.
static void lightprobe__add_residual(lightprobe__work *w, const lightprobe_light *light)
{
    const float *d = light->direction;
    for (int i = 0; i < 9; i++) {
        const float weight = lightprobe_harmonic_weight(i, light->cos_alpha, d[0], d[1], d[2]);
        for (int c = 0; c < 3; c++)
            w->residual_sh[i][c] += weight * (light->irradiance[c] * LIGHTPROBE_SCALE);
    }
}

// Puts k into a list of so many by the least of a key, after its equals.
static void lightprobe__insert(int *list, int count, const float *key, int k)
{
    for (; count > 0 && key[list[count - 1]] > key[k]; count--) list[count] = list[count - 1];
    list[count] = k;
}

// Marks the clusters (as changed) that are no lights: too dim, or the weakest.
static void lightprobe__find_weak(lightprobe__work *w, const lightprobe_settings *settings)
{
    const float least = settings->min_share * w->total;
    int count = 0;
    float lost = 0;
    for (int k = 0; k < w->cluster_count; k++) {
        const float luminance = (float)w->regions[k].luminance;
        w->clusters[k].changed = luminance < least;
        if (!(luminance > 0) || luminance < least || !(settings->min_shadow > 0)) continue;
        w->gains[k] = lightprobe_shadow(w->clusters[k].sum, w->total);
        lightprobe__insert(w->order, count++, w->gains, k);
    }
    for (int i = 0; i < count; i++) {
        lost += w->gains[w->order[i]];
        if (lost > settings->min_shadow) break;
        w->clusters[w->order[i]].changed = 1;
    }
}

// Adds a part of a leaf to a region: second moments, or what comes before.
static void lightprobe__give(lightprobe__work *w, int leaf, int k, float part, int second)
{
    lightprobe_region *r = w->regions + k;
    *r = second ? lightprobe_add_second(*r, w->leaves[leaf], part)
                : lightprobe_add_region(*r, w->leaves[leaf], part);
}

static void lightprobe__give_all(lightprobe__work *w, int shared, int second)
{
    for (int i = 0; i < w->leaf_count; i++) {
        const lightprobe__share *s = w->shares + i;
        if (!shared) lightprobe__give(w, i, w->leaves[i].cluster, 1, second);
        for (int j = 0; shared && j < s->count && s->count <= 4; j++)
            lightprobe__give(w, i, s->cluster[j], s->part[j], second);
        for (int k = 0; shared && k < w->cluster_count && s->count > 4; k++) {
            const float part = lightprobe_takes(w, i, k);
            if (part > 0) lightprobe__give(w, i, k, part, second);
        }
    }
}

static void lightprobe__sum_regions(lightprobe__work *w, int shared)
{
    for (int k = 0; k < w->cluster_count; k++) w->regions[k] = lightprobe_no_region();
    lightprobe__give_all(w, shared, 0);
    for (int k = 0; k < w->cluster_count; k++)
        w->regions[k] = lightprobe_direct(w->regions[k], w->clusters[k], w->jumps);
    lightprobe__give_all(w, shared, 1);
}

// Of clusters that are not weak, brightest first unless they go on from a frame; returns how many.
static int lightprobe__write_lights(lightprobe__work *w, int animated,
                                    const lightprobe_settings *settings, lightprobe_light *out)
{
    int count = 0, next_id = 0;
    lightprobe__sum_regions(w, animated);
    lightprobe__find_weak(w, settings);
    for (int k = 0; k < w->cluster_count; k++) {
        const int id = w->clusters[k].id;
        if (id >= next_id && id < INT_MAX - LIGHTPROBE_MAX_LIGHTS) next_id = id + 1;
        if (!(w->regions[k].luminance > 0)) continue;
        w->gains[k] = animated ? 0 : -(float)w->regions[k].luminance;
        if (w->clusters[k].changed) {
            const lightprobe_light light = lightprobe_light_of(w->regions[k]);
            lightprobe__add_residual(w, &light);
        } else {
            lightprobe__insert(w->order, count++, w->gains, k);
        }
    }
    for (int i = 0; i < count; i++) {
        const int k = w->order[i];
        out[i] = lightprobe_make_light(w, k, w->regions[k]);
        out[i].id = w->clusters[k].id < 0 ? next_id++ : w->clusters[k].id;
    }
    return count;
}

// LIGHTPROBE_SOFT as the distance to the seed of a light with the mean share.
static float lightprobe__unit(int max_lights)
{
    return LIGHTPROBE_SOFT * 0.70710678f * sqrtf(sqrtf(1 / (float)max_lights));
}

// Everything but the checks of arguments.
static int lightprobe__best(lightprobe__work *w, const lightprobe_settings *settings,
                            lightprobe_light *lights)
{
    const int animated = settings->previous && settings->previous_count > 0;
    const int leaves_out = settings->min_share > 0 || settings->min_shadow > 0;
    w->jumps = !animated || leaves_out;
    w->unit = lightprobe__unit(w->max_lights);
    lightprobe__make_leaves(w);
    lightprobe__start(w, settings->previous, animated ? settings->previous_count : 0);
    lightprobe__divide(w, settings->tolerance);
    lightprobe__sum_clusters(w);
    lightprobe__find_near(w);
    // The start from previous lights was a round already; one a frame keeps the steps small.
    if (!animated)
        lightprobe__relax(w, LIGHTPROBE_ROUNDS);
    else if (!w->jumps || leaves_out || settings->tolerance > 0) // else one is missing for a frame
        lightprobe__reassign_lights(w, settings->tolerance);
    if (settings->tolerance > 0)
        lightprobe__divide(w, settings->tolerance); // if it is not met any more
    if (w->wants_error) w->error = lightprobe_root_error(lightprobe__measure_all(w), w->total);
    for (int k = 0; k < w->cluster_count; k++)
        if (w->jumps || w->clusters[k].id < 0) lightprobe_set_seed(w, k);
    if (animated && (w->jumps || lightprobe_is_changed(w))) lightprobe__share_out(w);
    if (!w->jumps) lightprobe__fade(w);
    if (!animated) w->fading = -1;
    return lightprobe__write_lights(w, animated, settings, lights);
}

static int lightprobe__paper(lightprobe__work *w, const lightprobe_settings *settings,
                             lightprobe_light *lights)
{
    // The memory of the leaves (72 bytes each, more than one per light) holds the ring, that of the
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
        if (!(luminance > 0)) continue;
        if (luminance < (double)(settings->min_share * w->total) || written == w->max_lights) {
            lightprobe__add_residual(w, &light);
            continue;
        }
        light.id = written;
        lights[written++] = light;
    }
    w->error = (float)(sum / (double)w->total);
    return written;
}

typedef struct lightprobe__range {
    const char *name;
    double value, low, high;
    lightprobe_result otherwise;
} lightprobe__range;

// The first that is out of its range, by name and number.
static lightprobe_result lightprobe__check_ranges(void (*log)(void *, const char *), void *user,
                                                  const lightprobe__range *r, int count)
{
    char high[32] = " or more", line[160];
    for (int i = 0; i < count; i++, r++) {
        if (lightprobe__is_number((float)r->value) && r->value >= r->low && r->value <= r->high)
            continue;
        if (r->high < (double)FLT_MAX) snprintf(high, sizeof high, " to %.9g", r->high);
        snprintf(line, sizeof line, "lightprobe: %s %.9g: %.9g%s", r->name, r->value, r->low, high);
        if (log) log(user, line);
        return r->otherwise;
    }
    return LIGHTPROBE_OK;
}

// Also fills in defaults.
static lightprobe_result lightprobe__check(const lightprobe_cube *cube, lightprobe_settings *s,
                                           int most_lights)
{
    const lightprobe__range ranges[] = {
        {"side", (double)cube->side, 1, LIGHTPROBE_MAX_SIDE, LIGHTPROBE_ERROR_SIDE},
        {"channels", (double)cube->channels, 3, 4, LIGHTPROBE_ERROR_CHANNELS},
        {"max_lights", (double)s->max_lights, 0, (double)most_lights, LIGHTPROBE_ERROR_LIGHTS},
        {"previous_count", (double)s->previous_count, 0, LIGHTPROBE_MAX_LIGHTS,
         LIGHTPROBE_ERROR_LIGHTS},
        {"tolerance", (double)s->tolerance, 0, (double)FLT_MAX, LIGHTPROBE_ERROR_SETTINGS},
        {"min_share", (double)s->min_share, 0, (double)FLT_MAX, LIGHTPROBE_ERROR_SETTINGS},
        {"min_shadow", (double)s->min_shadow, 0, (double)FLT_MAX, LIGHTPROBE_ERROR_SETTINGS},
        {"mode", (double)s->mode, LIGHTPROBE_BEST, LIGHTPROBE_MEDIAN_CUT,
         LIGHTPROBE_ERROR_SETTINGS},
        {"distances", (double)s->distances, 0, 2, LIGHTPROBE_ERROR_SETTINGS},
        {"channels of a cube with distances", (double)cube->channels, s->distances ? 4.0 : 3.0, 4,
         LIGHTPROBE_ERROR_CHANNELS}};
    const lightprobe_result r =
        lightprobe__check_ranges(s->log, s->user, ranges, (int)(sizeof ranges / sizeof *ranges));
    if (r) return r;
    if (s->max_lights == 0 && !(s->tolerance > 0)) s->tolerance = LIGHTPROBE_DEFAULT_TOLERANCE;
    if (s->max_lights == 0) s->max_lights = LIGHTPROBE_DEFAULT_LIGHTS;
    if (s->tolerance > 1) s->tolerance = 1;
    if (s->min_share > 1) s->min_share = 1;
    return LIGHTPROBE_OK;
}

static void lightprobe__fill_stats(const lightprobe__work *w, const lightprobe_light *lights,
                                   int count, lightprobe_stats *stats)
{
    for (int i = 0; i < 3; i++) {
        for (int k = 1; k < 9; k++) {
            const double sum = (double)w->residual_sh[k][i];
            stats->residual_sh[k][i] = lightprobe__clamp(sum / (double)LIGHTPROBE_SCALE);
        }
        const double all = w->sum_of_all[i] / (double)LIGHTPROBE_SCALE;
        double carried = 0;
        for (int k = 0; k < count; k++) carried += (double)lights[k].irradiance[i];
        stats->total[i] = lightprobe__clamp(all);
        stats->residual[i] = lightprobe__clamp(all - carried);
        stats->residual_sh[0][i] = 0.25f * stats->residual[i]; // to the last digit
    }
    stats->error = w->error > 0 ? w->error : 0;
    stats->lights = count;
    stats->repaired_texels = w->repaired;
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
    int missing = !cube || !scratch || !lights || !light_count;
    for (int face = 0; face < 6 && !missing; face++) missing = !cube->face[face];
    if (missing && s.log) s.log(s.user, lightprobe_result_string(LIGHTPROBE_ERROR_NULL));
    if (missing) return LIGHTPROBE_ERROR_NULL;
    const lightprobe_result result = lightprobe__check(cube, &s, LIGHTPROBE_MAX_LIGHTS);
    if (result) return result;
    const lightprobe__range bytes = {"scratch_bytes", (double)scratch_bytes,
                                     (double)lightprobe_scratch_bytes(cube->side, s.max_lights),
                                     1e300, LIGHTPROBE_ERROR_SCRATCH};
    if (lightprobe__check_ranges(s.log, s.user, &bytes, 1)) return LIGHTPROBE_ERROR_SCRATCH;
    lightprobe__layout(&work, (char *)scratch + (15 & (0 - (uintptr_t)scratch)), cube->side,
                       s.max_lights);
    work.cube = cube;
    work.distances = s.distances;
    work.wants_error = stats != NULL;
    lightprobe__make_tables(&work);
    lightprobe__sum_tiles(&work);
    lightprobe__make_pyramid(&work);
    lightprobe__find_total(&work);
    *light_count = 0; // of a black probe
    if (work.total >= LIGHTPROBE_BLACK)
        *light_count = (s.mode ? lightprobe__paper : lightprobe__best)(&work, &s, lights);
    if (stats) lightprobe__fill_stats(&work, lights, *light_count, stats);
    return LIGHTPROBE_OK;
}

const char *lightprobe_result_string(lightprobe_result result)
{
    static const char *const text[] = {
        "lightprobe: no error",
        "lightprobe: a pointer that must be given is null",
        "lightprobe: the side of the cube's faces must be 1 to 8192",
        "lightprobe: texels must have 3 or 4 channels",
        "lightprobe: max_lights and previous_count must be 0 to 4096, in OpenGL 0 to 1024",
        ("lightprobe: tolerance, min_share and min_shadow must be 0 or more, mode one of "
         "lightprobe_mode"),
        "lightprobe: less scratch memory than lightprobe_scratch_bytes() asks for",
        "lightprobe: no memory",
        "lightprobe: OpenGL 4.5 is needed",
        "lightprobe: the driver refused storage or a shader",
        "lightprobe: the texture is no whole cube map with a level of the side asked for",
        "lightprobe: the GPU has not finished any lights yet",
        "lightprobe: transform feedback must be paused or ended before lightprobe_gl_update",
        "lightprobe: the picture has no texels, or its proportions fit no layout"};
    const size_t i = (size_t)result; // below 0: very large
    return i < sizeof text / sizeof *text ? text[i] : "lightprobe: unknown result";
}

// ---- GLSL texts: what stands around the quotes of >>generated ---- >>texts

#if defined __GNUC__
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Woverlength-strings"
#endif

// clang-format off
// Names that stand for what C and GLSL call differently (>>math).
#define LIGHTPROBE__C_NAMES \
    "#define LIGHTPROBE_SHARED\n#define LIGHTPROBE_INOUT inout\n#define LIGHTPROBE_OUT out\n" \
    "#define lightprobe_vec3 vec3\n#define lightprobe_vec4 vec4\n" \
    "#define sqrtf sqrt\n#define fabsf abs\n"
#define LIGHTPROBE__NO_C_NAMES \
    "#undef LIGHTPROBE_SHARED\n#undef LIGHTPROBE_INOUT\n#undef LIGHTPROBE_OUT\n" \
    "#undef lightprobe_vec3\n#undef lightprobe_vec4\n#undef sqrtf\n#undef fabsf\n"

#define LIGHTPROBE__MATH_BEGIN \
    "#ifdef GL_ES\nprecision highp float;\nprecision highp int;\n#endif\n" LIGHTPROBE__C_NAMES

// The lights as shading reads them; our own shaders read the previous ones by it. Uniforms keep no
// state; both layouts are the same. Texts of mssm.h before it have defined what they take.
#define LIGHTPROBE__TAKEN(n) " || (LIGHTPROBE_BINDING == " #n " && defined MSSM_BINDING_" #n ")"
#define LIGHTPROBE__LIGHTS_BEGIN \
    "#if __VERSION__ < 430 && !defined LIGHTPROBE_UNIFORMS\n" \
    "#error lightprobe.h needs #version 430 or higher, or LIGHTPROBE_UNIFORMS, above its text\n" \
    "#endif\n" \
    "#ifndef LIGHTPROBE_BINDING\n" \
    "#define LIGHTPROBE_BINDING 0\n" \
    "#endif\n" \
    "#ifdef LIGHTPROBE_UNIFORMS\n" \
    "#elif 0" \
    LIGHTPROBE__TAKEN(0) LIGHTPROBE__TAKEN(1) LIGHTPROBE__TAKEN(2) LIGHTPROBE__TAKEN(3) \
    LIGHTPROBE__TAKEN(4) LIGHTPROBE__TAKEN(5) LIGHTPROBE__TAKEN(6) LIGHTPROBE__TAKEN(7) \
    LIGHTPROBE__TAKEN(8) LIGHTPROBE__TAKEN(9) LIGHTPROBE__TAKEN(10) LIGHTPROBE__TAKEN(11) \
    LIGHTPROBE__TAKEN(12) LIGHTPROBE__TAKEN(13) LIGHTPROBE__TAKEN(14) LIGHTPROBE__TAKEN(15) "\n" \
    "#error first_buffer_binding of mssm.h is LIGHTPROBE_BINDING: change one of them\n" \
    "#endif\n" \
    "struct lightprobe_light {\n" \
    "    vec3 direction; float cos_alpha;\n" \
    "    vec3 axis_u; float tan_half_u;\n" \
    "    vec3 axis_v; float tan_half_v;\n" \
    "    vec3 irradiance; float solid_angle;\n" \
    "    int id; float distance, slope_u, slope_v;\n" \
    "#ifndef LIGHTPROBE_UNIFORMS\n" \
    "    float state[18];\n" \
    "#endif\n" \
    "};\n" \
    "#ifdef LIGHTPROBE_UNIFORMS\n" \
    "#define LIGHTPROBE_ROOM LIGHTPROBE_UNIFORMS\n" \
    "layout(std140) uniform lightprobe_buffer {\n" \
    "#else\n" \
    "#define LIGHTPROBE_ROOM\n" \
    "layout(std430, binding = LIGHTPROBE_BINDING) readonly buffer lightprobe_buffer {\n" \
    "#endif\n" \
    "    int lightprobe_count;\n" \
    "    int lightprobe_repaired_texels;\n" \
    "    float lightprobe_error;\n" \
    "    vec4 lightprobe_total; // RGB\n" \
    "    vec4 lightprobe_residual, lightprobe_residual_sh[9];\n" \
    "    lightprobe_light lightprobe_lights[LIGHTPROBE_ROOM];\n" \
    "};\n" \
    "#ifndef LIGHTPROBE_LIGHTS_ONLY\n" \
    LIGHTPROBE__C_NAMES
#define LIGHTPROBE__LIGHTS_END \
    LIGHTPROBE__NO_C_NAMES \
    "vec3 lightprobe_irradiance(int light, vec3 normal)\n" \
    "{\n" \
    "    lightprobe_light l = lightprobe_lights[light];\n" \
    "    return l.irradiance * lightprobe_disc_irradiance(l.cos_alpha, dot(l.direction, normal));\n" \
    "}\n" \
    "vec3 lightprobe_irradiance(int light, vec3 offset, vec3 normal)\n" \
    "{\n" \
    "    lightprobe_light l = lightprobe_light_at(lightprobe_lights[light], offset.x, offset.y, offset.z);\n" \
    "    return l.irradiance * lightprobe_disc_irradiance(l.cos_alpha, dot(l.direction, normal));\n" \
    "}\n" \
    "vec3 lightprobe_sphere_irradiance(int light, vec3 offset, vec3 normal)\n" \
    "{\n" \
    "    lightprobe_light l = lightprobe_sphere_at(lightprobe_lights[light], offset.x, offset.y, offset.z);\n" \
    "    return l.irradiance * lightprobe_disc_irradiance(l.cos_alpha, dot(l.direction, normal));\n" \
    "}\n" \
    "vec3 lightprobe_residual_irradiance(vec3 normal)\n" \
    "{\n" \
    "    vec3 sum = vec3(0.0);\n" \
    "    for (int i = 0; i < 9; i++)\n" \
    "        sum += lightprobe_residual_sh[i].rgb * lightprobe_harmonic(i, normal.x, normal.y, normal.z);\n" \
    "    return max(sum, vec3(0.0));\n" \
    "}\n" \
    "#endif\n" \
    "#line 1\n"

#define LIGHTPROBE__SPECULAR_BEGIN \
    "struct lightprobe_lobe {\n    vec3 normal, view, away, f0;\n" \
    "    float along, across, shear, width, whole, fresnel;\n};\n" \
    LIGHTPROBE__C_NAMES "#define lightprobe_dot dot\n"
#define LIGHTPROBE__SPECULAR_END \
    LIGHTPROBE__NO_C_NAMES "#undef lightprobe_dot\n" \
    "vec3 lightprobe_specular(int light, vec3 offset, lightprobe_lobe lobe)\n{\n" \
    "    lightprobe_light l = lightprobe_lights[light];\n    vec3 rgb;\n" \
    "    lightprobe_specular(l, lobe, offset.x, offset.y, offset.z, rgb);\n" \
    "    return rgb;\n}\n" \
    "vec3 lightprobe_specular(int light, lightprobe_lobe lobe)\n{\n" \
    "    return lightprobe_specular(light, vec3(0.0), lobe);\n}\n#line 1\n"
// clang-format on

// ---- Pictures of probes ---- >>pictures

static const double lightprobe__pi = 3.14159265358979323846;

static float lightprobe__from_half(unsigned h)
{
    const unsigned exponent = h >> 10 & 31, fraction = h & 1023;
    uint32_t bits =
        exponent == 31 ? 0x7f800000u | fraction << 13 : (exponent + 112) << 23 | fraction << 13;
    float value;
    memcpy(&value, &bits, sizeof value);
    if (exponent == 0) value = (float)fraction / 16777216.0f;
    return h & 0x8000 ? -value : value;
}

typedef struct lightprobe__picture {
    const lightprobe_image *image;
    float infinite; // what infinite channels count as
    int flip;       // rows from below
} lightprobe__picture;

// Channels of a pixel as they count; returns whether one was bad.
static int lightprobe__pixel(const lightprobe__picture *p, int x, int y, float rgb[3])
{
    const lightprobe_image *im = p->image;
    const size_t row = (size_t)(p->flip ? im->height - 1 - y : y), grey = im->channels == 1;
    const size_t at = (row * (size_t)im->width + (size_t)x) * (size_t)im->channels;
    if (im->half) {
        const uint16_t *h = (const uint16_t *)im->texels + at;
        for (size_t c = 0; c < 3; c++) rgb[c] = lightprobe__from_half(h[grey ? 0 : c]);
    } else {
        const float *f = (const float *)im->texels + at;
        for (size_t c = 0; c < 3; c++) rgb[c] = f[grey ? 0 : c];
    }
    // Also false for NaN.
    if (rgb[0] >= 0 && rgb[1] >= 0 && rgb[2] >= 0 && rgb[0] + rgb[1] + rgb[2] <= FLT_MAX) return 0;
    int bad = 0;
    for (int c = 0; c < 3; c++) {
        const float v = rgb[c];
        rgb[c] = !(v >= 0) ? 0 : v > FLT_MAX ? p->infinite : v;
        bad |= rgb[c] != v;
    }
    return bad;
}

static int lightprobe__layout_of(const lightprobe_image *im)
{
    const int w = im->width, h = im->height;
    const int cross = w % 4 == 0 && w / 4 * 3 == h, tall = h % 4 == 0 && h / 4 * 3 == w;
    if (w < 1 || h < 1 || w > LIGHTPROBE_MAX_IMAGE || h > LIGHTPROBE_MAX_IMAGE) return 0;
    if (im->layout < 0 || im->layout > LIGHTPROBE_STRIP) return 0;
    if (im->layout == LIGHTPROBE_LAT_LONG) return im->layout;
    if (cross || tall) return im->layout == LIGHTPROBE_STRIP ? 0 : LIGHTPROBE_CROSS;
    if (w == 6 * h || h == 6 * w) return im->layout == LIGHTPROBE_CROSS ? 0 : LIGHTPROBE_STRIP;
    return im->layout == LIGHTPROBE_AUTO && w - 2 * h <= 1 && 2 * h - w <= 1 ? LIGHTPROBE_LAT_LONG
                                                                             : 0;
}

int lightprobe_image_side(const lightprobe_image *image)
{
    const int layout = image ? lightprobe__layout_of(image) : 0;
    const int w = layout ? image->width : 0, h = layout ? image->height : 0;
    if (layout == LIGHTPROBE_LAT_LONG) return w > 4 ? w / 4 : 1;
    return (w > h ? w : h) / (layout == LIGHTPROBE_CROSS ? 4 : 6);
}

// ---- From panoramas ---- >>panoramas
//
// The edges of a texel are arcs of great circles, of which those that do not run from pole to pole
// are tan(elevation) = k cos u, u the azimuth from where they are steepest. Seen in azimuth and
// sin(elevation) areas are solid angles. So with M(azimuth, elevation) the sum of the pixels above
// in a column, the integral over a texel is that of M along its edges (Green), and the texels'
// integrals add up to the panorama's, since each edge is in two. Pixels cut the edges into pieces,
// and on a piece M is linear in sin(elevation), whose integral is atan2(k sin u, sqrt(1 + k^2 cos^2
// u)).

typedef struct lightprobe__footprint { // of a texel
    const lightprobe__picture *picture;
    double integral[3];
    int top; // M counts from here: the rows above cancel
} lightprobe__footprint;

// tangent at least -1: below 45 degrees the panorama is turned upside down.
static int lightprobe__row(const lightprobe__picture *p, double tangent)
{
    return (int)((0.5 - atan(tangent) / lightprobe__pi) * p->image->height);
}

typedef struct lightprobe__point { // of an edge
    double u, tangent;             // of the elevation
    double integral;               // of its sine, from u = 0
    int row;
} lightprobe__point;

static lightprobe__point lightprobe__point_at(double k, double u)
{
    lightprobe__point p = {u, k * cos(u), 0, 0};
    p.integral = atan2(k * sin(u), sqrt(1 + p.tangent * p.tangent));
    return p;
}

// The piece of an edge from a down to b, both on one side of 0 and in one column, row by row.
static void lightprobe__piece(lightprobe__footprint *t, int column, double k, lightprobe__point a,
                              lightprobe__point b, double sign)
{
    const double row_angle = lightprobe__pi / t->picture->image->height;
    const double low = fmin(a.u, b.u), high = fmax(a.u, b.u), side = low + high < 0 ? -1 : 1;
    double above[3] = {0, 0, 0}, sine = cos(row_angle * t->top); // of the elevation
    for (int row = t->top; row <= b.row; row++) {
        const double angle = row_angle * (row + 1), next = cos(angle);
        float rgb[3];
        lightprobe__pixel(t->picture, column, row, rgb);
        if (row >= a.row) {
            lightprobe__point end = b;
            if (row < b.row) { // where it leaves the row
                const double u = side * acos(fmin(next / (sin(angle) * k), 1.0));
                end = lightprobe__point_at(k, fmin(fmax(u, low), high));
            }
            const double span = end.u - a.u, area = sine * span - (end.integral - a.integral);
            for (int c = 0; c < 3; c++) t->integral[c] += sign * (above[c] * span + rgb[c] * area);
            a.u = end.u;
            a.integral = end.integral;
        }
        for (int c = 0; c < 3; c++) above[c] += (sine - next) * rgb[c];
        sine = next;
    }
}

typedef struct lightprobe__edge {
    double middle, k; // azimuth of u = 0, from the panorama's middle
    double from, to;  // u
} lightprobe__edge;

static void lightprobe__along_edge(lightprobe__footprint *t, const lightprobe__edge *e)
{
    const lightprobe__picture *p = t->picture;
    const int columns = p->image->width;
    const double width = 2 * lightprobe__pi / columns, left = e->middle + lightprobe__pi;
    const double end = fmax(e->from, e->to), sign = e->from < e->to ? 1 : -1;
    lightprobe__point a = lightprobe__point_at(e->k, fmin(e->from, e->to));
    a.row = lightprobe__row(p, a.tangent);
    for (int column = (int)((left + a.u) / width); a.u < end;) {
        double u = fmin((column + 1) * width - left, end);
        const int cut = a.u < 0 && u > 0; // where it is steepest
        lightprobe__point b = lightprobe__point_at(e->k, cut ? 0 : u);
        b.row = lightprobe__row(p, b.tangent);
        if (a.tangent > b.tangent)
            lightprobe__piece(t, column % columns, e->k, a, b, sign);
        else
            lightprobe__piece(t, column % columns, e->k, b, a, -sign);
        a = b;
        column += !cut;
    }
}

// The edges of [s0,s1] x [t0,t1], counter-clockwise seen from outside, without those from pole to
// pole; returns how many. Face 3 is face 2 upside down.
static int lightprobe__edges(int face, double s0, double t0, double s1, double t1,
                             lightprobe__edge edge[4])
{
    static const double quarters[6] = {1, -1, 0, 0, 2, 0};
    const double quarter = lightprobe__pi / 2;
    int count = 0;
    if (face != 2 && face != 3) {
        const double middle = quarters[face] * quarter, right = -atan(s0), left = -atan(s1);
        const lightprobe__edge lower = {middle, -t1, left, right},
                               upper = {middle, -t0, right, left};
        edge[0] = lower;
        edge[1] = upper;
        return 2;
    }
    const double corner[5][2] = {{s0, t0}, {s1, t0}, {s1, t1}, {s0, t1}, {s0, t0}};
    for (int i = 0; i < 4; i++) {
        const int along_t = i & 1;
        const double at = corner[i][!along_t]; // the coordinate that stays
        const double a = corner[i][along_t] / at, b = corner[i + 1][along_t] / at;
        const lightprobe__edge s = {at < 0 ? 0 : 2 * quarter, 1 / fabs(at), atan(-a), atan(-b)};
        const lightprobe__edge t = {at < 0 ? -quarter : quarter, 1 / fabs(at), atan(a), atan(b)};
        if (at != 0) edge[count++] = along_t ? t : s;
    }
    return count;
}

static void lightprobe__panorama_texel(const lightprobe__picture *picture, int face, double s0,
                                       double t0, double s1, double t1, float rgb[3])
{
    lightprobe__picture p = *picture;
    lightprobe__edge edge[4];
    p.flip = face == 3;
    const double low = p.flip ? -t1 : t0, high = p.flip ? -t0 : t1;
    const int count = lightprobe__edges(face, s0, low, s1, high, edge);
    const double omega = lightprobe__solid_angle(s0, t0, s1, t1);
    lightprobe__footprint t = {&p, {0}, p.image->height};
    for (int i = 0; i < count; i++) {
        const double k = edge[i].k, steepest = edge[i].from * edge[i].to < 0 ? 1 : cos(edge[i].to);
        const double most = fmax(k * cos(edge[i].from), k * steepest);
        const int row = lightprobe__row(&p, fmax(most, k * cos(edge[i].to)));
        t.top = row < t.top ? row : t.top;
    }
    if (t.top > 0) t.top--; // for what rounding does
    if ((face == 2 || face == 3) && s0 <= 0 && s1 >= 0 && low <= 0 && high >= 0)
        t.top = 0; // a pole
    for (int i = 0; i < count; i++) lightprobe__along_edge(&t, &edge[i]);
    for (int c = 0; c < 3; c++) rgb[c] = (float)fmin(fmax(t.integral[c] / omega, 0.0), FLT_MAX);
}

// ---- From crosses and strips ---- >>crosses

static void lightprobe__cell_texel(const lightprobe__picture *p, int layout, int n, int face,
                                   int side, int x, int y, float rgb[3])
{
    static const int crosses[6][2] = {{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {3, 1}};
    const int wide = p->image->width > p->image->height, cross = layout == LIGHTPROBE_CROSS;
    const int turned = cross && !wide && face == 5;
    // The face's upper left corner in the picture.
    const int left = n * (turned ? 1 : cross ? crosses[face][0] : wide ? face : 0);
    const int top = n * (turned ? 3 : cross ? crosses[face][1] : wide ? 0 : face);
    const double cell = 2.0 / n, step = 2.0 / side;
    double sum[3] = {0, 0, 0}, all = 0;
    // The pixels that overlap this texel, in whole numbers.
    const int x0 = (int)((int64_t)x * n / side), x1 = (int)((((int64_t)x + 1) * n - 1) / side);
    const int y0 = (int)((int64_t)y * n / side), y1 = (int)((((int64_t)y + 1) * n - 1) / side);
    for (int v = y0; v <= y1; v++) {
        for (int u = x0; u <= x1; u++) {
            float one[3];
            const double omega = lightprobe__solid_angle(
                fmax(u * cell, x * step) - 1, fmax(v * cell, y * step) - 1,
                fmin((u + 1) * cell, (x + 1) * step) - 1, fmin((v + 1) * cell, (y + 1) * step) - 1);
            lightprobe__pixel(p, left + (turned ? n - 1 - u : u), top + (turned ? n - 1 - v : v),
                              one);
            for (int c = 0; c < 3; c++) sum[c] += omega * one[c];
            all += omega;
        }
    }
    for (int c = 0; c < 3; c++) rgb[c] = (float)(sum[c] / all);
}

lightprobe_result lightprobe_cube_from_image(const lightprobe_image *image, int side, float *texels,
                                             lightprobe_cube *cube, int *repaired)
{
    if (!image || !image->texels || !texels) return LIGHTPROBE_ERROR_NULL;
    if (side < 1 || side > LIGHTPROBE_MAX_SIDE) return LIGHTPROBE_ERROR_SIDE;
    if (image->channels != 1 && image->channels != 3 && image->channels != 4)
        return LIGHTPROBE_ERROR_CHANNELS;
    const int layout = lightprobe__layout_of(image), n = lightprobe_image_side(image);
    if (!layout) return LIGHTPROBE_ERROR_IMAGE;
    lightprobe__picture p = {image, 0, 0};
    float largest = 65504, rgb[3];
    int bad = 0;
    for (int y = 0; y < image->height; y++) {
        for (int x = 0; x < image->width; x++) {
            bad += lightprobe__pixel(&p, x, y, rgb);
            for (int c = 0; c < 3; c++) largest = rgb[c] > largest ? rgb[c] : largest;
        }
    }
    p.infinite = largest;
    const double step = 2.0 / side;
    for (int i = 0; i < 6 * side * side; i++, texels += 3) {
        const int face = i / side / side, x = i % side, y = i / side % side;
        if (layout == LIGHTPROBE_LAT_LONG)
            lightprobe__panorama_texel(&p, face, x * step - 1, y * step - 1, (x + 1) * step - 1,
                                       (y + 1) * step - 1, texels);
        else
            lightprobe__cell_texel(&p, layout, n, face, side, x, y, texels);
        if (cube && !x && !y) cube->face[face] = texels;
    }
    if (cube) cube->side = side, cube->channels = 3;
    if (repaired) *repaired = bad;
    return LIGHTPROBE_OK;
}

// ---- Cubes without lights ---- >>without

typedef struct lightprobe__removal {
    const lightprobe_light *light;
    float *texels;
    int side;
    double reach;    // half-sizes of the rectangle are multiplied by this; 0: all of the sphere
    double level[3]; // what is above is taken off
    double share[3]; // so much of it
    double above[3]; // sums found: of what is above,
    double omega[3]; // and the solid angle where something is
} lightprobe__removal;

// Measures what is above the levels in the light's reach, or takes it off.
static void lightprobe__over_peaks(lightprobe__removal *r, int take)
{
    const lightprobe_light *l = r->light;
    const double most_u = fmax(l->tan_half_u, 1.0 / r->side) * r->reach;
    const double most_v = fmax(l->tan_half_v, 1.0 / r->side) * r->reach;
    float *texel = r->texels;
    for (int c = 0; c < 3; c++) r->above[c] = r->omega[c] = 0;
    for (int row = 0; row < 6 * r->side; row++) {
        const int face = row / r->side, y = row % r->side;
        for (int x = 0; x < r->side; x++, texel += 3) {
            double along = 0, u = 0, v = 0;
            float d[3];
            lightprobe_to_world(face, 1, (float)(2 * x + 1) / (float)r->side - 1,
                                (float)(2 * y + 1) / (float)r->side - 1, d);
            for (int i = 0; i < 3; i++) {
                along += (double)d[i] * l->direction[i];
                u += (double)d[i] * l->axis_u[i];
                v += (double)d[i] * l->axis_v[i];
            }
            if (r->reach > 0 &&
                !(along > 0 && fabs(u) <= most_u * along && fabs(v) <= most_v * along))
                continue;
            const double omega = lightprobe_texel_solid_angle(r->side, x, y);
            for (int c = 0; c < 3; c++) {
                const double peak = texel[c] - r->level[c];
                if (!(peak > 0)) continue;
                r->above[c] += omega * peak;
                r->omega[c] += omega;
                if (take) texel[c] = (float)(texel[c] - r->share[c] * peak);
            }
        }
    }
}

static void lightprobe__remove(float *texels, int side, const lightprobe_light *light)
{
    lightprobe__removal r = {light, texels, side, 0, {0}, {0}, {0}, {0}};
    for (r.reach = 1;; r.reach *= 1.5) {
        if (r.reach > 1000) r.reach = 0;
        lightprobe__over_peaks(&r, 0);
        int enough = 1;
        for (int c = 0; c < 3; c++) enough &= r.above[c] >= light->irradiance[c];
        if (enough || r.reach == 0) break;
    }
    // Newton from below: what is above falls with the level, ever slower, so it never goes too far.
    for (int more = 1; more;) {
        more = 0;
        for (int c = 0; c < 3; c++) {
            const double wanted = fmax(light->irradiance[c], 0.0);
            r.share[c] = wanted < r.above[c] ? wanted / r.above[c] : 1;
            if (!(r.share[c] < 1 - 1e-7)) continue;
            const double level = r.level[c] + (r.above[c] - wanted) / r.omega[c];
            more |= level > r.level[c]; // or digits have run out
            r.level[c] = level;
        }
        lightprobe__over_peaks(&r, !more);
    }
}

lightprobe_result lightprobe_cube_without(const lightprobe_cube *cube,
                                          const lightprobe_light *lights, int count, float *texels)
{
    if (!cube || (!lights && count > 0) || !texels) return LIGHTPROBE_ERROR_NULL;
    for (int face = 0; face < 6; face++)
        if (!cube->face[face]) return LIGHTPROBE_ERROR_NULL;
    if (cube->side < 1 || cube->side > LIGHTPROBE_MAX_SIDE) return LIGHTPROBE_ERROR_SIDE;
    if (cube->channels != 3 && cube->channels != 4) return LIGHTPROBE_ERROR_CHANNELS;
    if (count < 0) return LIGHTPROBE_ERROR_LIGHTS;
    const size_t size = (size_t)cube->side * (size_t)cube->side;
    for (size_t i = 0; i < 18 * size; i++) {
        const float v = cube->face[i / 3 / size][i / 3 % size * (size_t)cube->channels + i % 3];
        texels[i] = v >= 0 && v <= FLT_MAX ? v : 0;
    }
    for (int i = 0; i < count; i++) lightprobe__remove(texels, cube->side, &lights[i]);
    return LIGHTPROBE_OK;
}

// ---- OpenGL 4.5 ---- >>gl

#ifndef LIGHTPROBE_NO_GL

// What lightprobe.h alone calls.
#define LIGHTPROBE__GL_OWN(X)                                                                \
    X(void, GetInteger64i_v, (lightprobe__glenum, unsigned, int64_t *))                      \
    X(void, CopyBufferSubData,                                                               \
      (lightprobe__glenum, lightprobe__glenum, ptrdiff_t, ptrdiff_t, ptrdiff_t))             \
    X(void *, MapBufferRange, (lightprobe__glenum, ptrdiff_t, ptrdiff_t, unsigned))          \
    X(void, BindBufferRange, (lightprobe__glenum, unsigned, unsigned, ptrdiff_t, ptrdiff_t)) \
    X(void *, FenceSync, (lightprobe__glenum, unsigned))                                     \
    X(lightprobe__glenum, ClientWaitSync, (void *, unsigned, uint64_t))                      \
    X(void, DeleteSync, (void *))                                                            \
    X(void, Flush, (void))                                                                   \
    X(void, ObjectPtrLabel, (const void *, int, const char *))

// clang-format off
enum {
    // limits, textures
    LIGHTPROBE__GL_MAX_SHADER_STORAGE_BLOCK_SIZE = 0x90DE, LIGHTPROBE__GL_TEXTURE_MAX_LEVEL = 0x813D,
    LIGHTPROBE__GL_TEXTURE_IMMUTABLE_LEVELS = 0x82DF, LIGHTPROBE__GL_TEXTURE_VIEW_NUM_LEVELS = 0x82DC,
    LIGHTPROBE__GL_TEXTURE_MIN_LOD = 0x813A, LIGHTPROBE__GL_TEXTURE_MAX_LOD = 0x813B,
    LIGHTPROBE__GL_TEXTURE_INTERNAL_FORMAT = 0x1003,
    LIGHTPROBE__GL_TEXTURE_RED_TYPE = 0x8C10, LIGHTPROBE__GL_TEXTURE_DEPTH_SIZE = 0x884A,
    LIGHTPROBE__GL_TEXTURE_STENCIL_SIZE = 0x88F1,
    LIGHTPROBE__GL_INT = 0x1404, LIGHTPROBE__GL_UNSIGNED_INT = 0x1405,
    // buffers; MAP_READ: persistent, coherent
    LIGHTPROBE__GL_SHADER_STORAGE_BUFFER_START = 0x90D4, LIGHTPROBE__GL_SHADER_STORAGE_BUFFER_SIZE = 0x90D5,
    LIGHTPROBE__GL_COPY_WRITE_BUFFER = 0x8F37, LIGHTPROBE__GL_DYNAMIC_STORAGE = 0x0100,
    LIGHTPROBE__GL_CLIENT_STORAGE = 0x0200, LIGHTPROBE__GL_MAP_READ = 0x0001 | 0x0040 | 0x0080,
    // order of work
    LIGHTPROBE__GL_STORAGE_BARRIER = 0x2000, LIGHTPROBE__GL_UPDATE_BARRIER = 0x0200,
    LIGHTPROBE__GL_SYNC_COMPLETE = 0x9117, LIGHTPROBE__GL_SYNC_FLUSH = 0x0001,
    LIGHTPROBE__GL_ALREADY_SIGNALED = 0x911A, LIGHTPROBE__GL_TIMEOUT_EXPIRED = 0x911B,
    LIGHTPROBE__GL_CONDITION_SATISFIED = 0x911C
};

// [plumbing begin], which `make glsl` copies from mssm.h: edit it there

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#ifndef LIGHTPROBE_MALLOC
#define LIGHTPROBE_MALLOC(bytes) malloc(bytes)
#define LIGHTPROBE_FREE(memory) free(memory)
#endif

#if defined _WIN32 && !defined _WIN64
#define LIGHTPROBE__GLAPI __stdcall
#else
#define LIGHTPROBE__GLAPI
#endif

// Types and constants under names of our own, so that any GL header may be included too.
typedef unsigned int lightprobe__glenum;
typedef unsigned char lightprobe__glboolean;

// X(result, name without "gl", parameters): what both headers call, and what this one alone does.
// Not those by name that Intel's driver for Windows takes without a word and does not carry out:
// clears, buffers, cube maps, glBindTextureUnit, queries.
#define LIGHTPROBE__GL_FUNCTIONS(X)                                                  \
    X(void, GetIntegerv, (lightprobe__glenum, int *))                                \
    X(const unsigned char *, GetString, (lightprobe__glenum))                        \
    X(lightprobe__glenum, GetError, (void))                                          \
    X(void, GetIntegeri_v, (lightprobe__glenum, unsigned, int *))                    \
    X(lightprobe__glboolean, IsTexture, (unsigned))                                  \
    X(lightprobe__glboolean, IsBuffer, (unsigned))                                   \
    X(lightprobe__glboolean, IsSampler, (unsigned))                                  \
    X(lightprobe__glboolean, IsProgram, (unsigned))                                  \
    X(void, GetTexLevelParameteriv, (lightprobe__glenum, int, lightprobe__glenum, int *))  \
    X(void, ActiveTexture, (lightprobe__glenum))                                     \
    X(void, BindTexture, (lightprobe__glenum, unsigned))                             \
    X(void, BindSampler, (unsigned, unsigned))                                 \
    X(void, CreateSamplers, (int, unsigned *))                                 \
    X(void, DeleteSamplers, (int, const unsigned *))                           \
    X(void, SamplerParameteri, (unsigned, lightprobe__glenum, int))                  \
    X(void, GetTexParameteriv, (lightprobe__glenum, lightprobe__glenum, int *))            \
    X(void, CreateBuffers, (int, unsigned *))                                  \
    X(void, DeleteBuffers, (int, const unsigned *))                            \
    X(void, BufferStorage, (lightprobe__glenum, ptrdiff_t, const void *, unsigned))  \
    X(void, BufferSubData, (lightprobe__glenum, ptrdiff_t, ptrdiff_t, const void *)) \
    X(void, BindBuffer, (lightprobe__glenum, unsigned))                              \
    X(void, BindBufferBase, (lightprobe__glenum, unsigned, unsigned))                \
    X(unsigned, CreateShader, (lightprobe__glenum))                                  \
    X(void, DeleteShader, (unsigned))                                          \
    X(void, ShaderSource, (unsigned, int, const char *const *, const int *))   \
    X(void, CompileShader, (unsigned))                                         \
    X(void, GetShaderiv, (unsigned, lightprobe__glenum, int *))                      \
    X(void, GetShaderInfoLog, (unsigned, int, int *, char *))                  \
    X(unsigned, CreateProgram, (void))                                         \
    X(void, DeleteProgram, (unsigned))                                         \
    X(void, AttachShader, (unsigned, unsigned))                                \
    X(void, LinkProgram, (unsigned))                                           \
    X(void, GetProgramiv, (unsigned, lightprobe__glenum, int *))                     \
    X(void, GetProgramInfoLog, (unsigned, int, int *, char *))                 \
    X(void, UseProgram, (unsigned))                                            \
    X(void, ProgramUniform1i, (unsigned, int, int))                            \
    X(void, DispatchCompute, (unsigned, unsigned, unsigned))                   \
    X(void, MemoryBarrier, (unsigned))                                         \
    X(void, ObjectLabel, (lightprobe__glenum, unsigned, int, const char *))          \
    LIGHTPROBE__GL_OWN(X)

typedef struct lightprobe__gl_functions {
#define LIGHTPROBE__GL_MEMBER(result, name, parameters) result(LIGHTPROBE__GLAPI *name) parameters;
    LIGHTPROBE__GL_FUNCTIONS(LIGHTPROBE__GL_MEMBER)
#undef LIGHTPROBE__GL_MEMBER
} lightprobe__gl_functions;

// Of both headers, and what stands with these in one expression: C++ wants that of one enum.
// clang-format off
enum {
    // limits and questions
    LIGHTPROBE__GL_OUT_OF_MEMORY = 0x0505, LIGHTPROBE__GL_VERSION = 0x1F02, LIGHTPROBE__GL_MAJOR_VERSION = 0x821B,
    LIGHTPROBE__GL_MINOR_VERSION = 0x821C, LIGHTPROBE__GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS = 0x8B4D,
    LIGHTPROBE__GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS = 0x90DD,
    LIGHTPROBE__GL_TRANSFORM_FEEDBACK_ACTIVE = 0x8E24, LIGHTPROBE__GL_TRANSFORM_FEEDBACK_PAUSED = 0x8E23,
    // what is bound
    LIGHTPROBE__GL_CURRENT_PROGRAM = 0x8B8D, LIGHTPROBE__GL_ACTIVE_TEXTURE = 0x84E0,
    LIGHTPROBE__GL_SAMPLER_BINDING = 0x8919, LIGHTPROBE__GL_SHADER_STORAGE_BUFFER_BINDING = 0x90D3,
    // textures and what is bound of them
    LIGHTPROBE__GL_TEXTURE0 = 0x84C0, LIGHTPROBE__GL_TEXTURE_CUBE_MAP_POSITIVE_X = 0x8515,
    LIGHTPROBE__GL_TEXTURE_CUBE_MAP = 0x8513, LIGHTPROBE__GL_TEXTURE_BINDING_CUBE_MAP = 0x8514,
    // their properties
    LIGHTPROBE__GL_TEXTURE_BASE_LEVEL = 0x813C, LIGHTPROBE__GL_TEXTURE_WIDTH = 0x1000,
    LIGHTPROBE__GL_TEXTURE_MIN_FILTER = 0x2801, LIGHTPROBE__GL_TEXTURE_MAG_FILTER = 0x2800,
    LIGHTPROBE__GL_NEAREST = 0x2600, LIGHTPROBE__GL_NEAREST_MIPMAP_NEAREST = 0x2700, LIGHTPROBE__GL_LINEAR = 0x2601,
    LIGHTPROBE__GL_LINEAR_MIPMAP_LINEAR = 0x2703,
    // access
    LIGHTPROBE__GL_SHADER_STORAGE_BUFFER = 0x90D2,
    // shaders
    LIGHTPROBE__GL_COMPUTE_SHADER = 0x91B9, LIGHTPROBE__GL_VERTEX_SHADER = 0x8B31,
    LIGHTPROBE__GL_FRAGMENT_SHADER = 0x8B30, LIGHTPROBE__GL_COMPILE_STATUS = 0x8B81,
    LIGHTPROBE__GL_LINK_STATUS = 0x8B82, LIGHTPROBE__GL_INFO_LOG_LENGTH = 0x8B84,
    // kinds of objects, for labels
    LIGHTPROBE__GL_BUFFER = 0x82E0, LIGHTPROBE__GL_SAMPLER = 0x82E6, LIGHTPROBE__GL_PROGRAM = 0x82E2
};
// clang-format on

// [plumbing end]

enum {
    LIGHTPROBE__TILES,
    LIGHTPROBE__DIVIDE_FACES,
    LIGHTPROBE__GATHER,
    LIGHTPROBE__DIVIDE,
    LIGHTPROBE__REASSIGN,
    LIGHTPROBE__SETTLE,
    LIGHTPROBE__WRITE,
    LIGHTPROBE__PROGRAMS
};
// Stages of LIGHTPROBE__GATHER. Behind them come further rounds of relaxation.
enum { LIGHTPROBE__START, LIGHTPROBE__START_AGAIN, LIGHTPROBE__FIND_NEAR, LIGHTPROBE__RELAX };
// Stage of LIGHTPROBE__DIVIDE that only finds the errors; the others are parts of the division.
enum { LIGHTPROBE__MEASURE = 1000000 };
enum {
    LIGHTPROBE__LIGHTS, // of so many updates
    LIGHTPROBE__WORK,
    LIGHTPROBE__MAPPED,
    LIGHTPROBE__BUFFERS,
    LIGHTPROBE__PARTS = 4,    // of the work: numbers, leaves, clusters, cells
    LIGHTPROBE__BINDINGS = 6, // previous lights, parts of the work, new lights
    LIGHTPROBE__SLOTS = 3     // lights of so many updates are kept
};
// Threads of a work group. llvmpipe ends a thread's loops, without a word, after 65535 rounds of
// them all together. So many threads stay below that with 1024 lights, and the division, of which
// each step hangs on the one before, is cut into several dispatches.
#define LIGHTPROBE__GROUP 128
#define LIGHTPROBE__MAX_ROUNDS 60000

// As in GLSL.
typedef struct lightprobe__gl_light {
    float direction[3], cos_alpha, axis_u[3], tan_half_u, axis_v[3], tan_half_v;
    float irradiance[3], solid_angle;
    int id;
    float distance, slope_u, slope_v, state[18], unused[2]; // a multiple of vec3's alignment
} lightprobe__gl_light;

typedef struct lightprobe__gl_header {
    int count, repaired_texels;
    float error, unused, total[4], residual[4], residual_sh[9][4];
} lightprobe__gl_header;

struct lightprobe_gl {
    lightprobe_gl_desc desc;
    lightprobe__gl_functions f;
    unsigned program[LIGHTPROBE__PROGRAMS], buffer[LIGHTPROBE__BUFFERS], sampler;
    lightprobe__work work; // only its sizes
    int splits;            // that one dispatch may do
    size_t slot_bytes, part_bytes[LIGHTPROBE__PARTS];
    const char *mapped;
    void *fence[LIGHTPROBE__SLOTS];
    unsigned updates; // so many were made; the lights of number n are in slot n % SLOTS
    unsigned given;   // number of the one that was read last
    int again;        // go on from previous lights
};

// ---- GLSL by hand, each text for the C of its name ---- >>shaders

// Quotes of the C above, in >>generated.
static const char *lightprobe__quote_work(void);
static const char *lightprobe__quote_cells(void);
static const char *lightprobe__quote_moving(void);
static const char *lightprobe__quote_splits(void);
static const char *lightprobe__quote_lights(void);

// clang-format off
// What the C half goes by, too. `precise` keeps GLSL compilers from fusing and reordering.
#define LIGHTPROBE__TEXT(x) LIGHTPROBE__TEXT_OF(x)
#define LIGHTPROBE__TEXT_OF(x) #x
#define LIGHTPROBE__DEFINE(name) "#define " #name " " LIGHTPROBE__TEXT(name) "\n"
static const char lightprobe__glsl_shared[] =
    LIGHTPROBE__DEFINE(LIGHTPROBE_SCALE) LIGHTPROBE__DEFINE(LIGHTPROBE_BLACK)
    LIGHTPROBE__DEFINE(LIGHTPROBE_TONE) LIGHTPROBE__DEFINE(LIGHTPROBE_PARALLAX)
    LIGHTPROBE__DEFINE(LIGHTPROBE_WIDTH) LIGHTPROBE__DEFINE(LIGHTPROBE_BINS)
    LIGHTPROBE__DEFINE(LIGHTPROBE_REACH) LIGHTPROBE__DEFINE(LIGHTPROBE_NEAR)
    LIGHTPROBE__DEFINE(LIGHTPROBE_RATE) LIGHTPROBE__DEFINE(LIGHTPROBE_TURN)
    LIGHTPROBE__DEFINE(LIGHTPROBE_FADE) LIGHTPROBE__DEFINE(LIGHTPROBE_LATE)
    LIGHTPROBE__DEFINE(LIGHTPROBE_WIDEN) LIGHTPROBE__DEFINE(LIGHTPROBE_ROUND)
    LIGHTPROBE__DEFINE(LIGHTPROBE_STEP) LIGHTPROBE__DEFINE(LIGHTPROBE_FASTEST)
    LIGHTPROBE__DEFINE(LIGHTPROBE_MAX_LIGHTS) LIGHTPROBE__DEFINE(LIGHTPROBE_TILE_LEVEL)
    LIGHTPROBE__DEFINE(LIGHTPROBE_MORE_LEAVES)
    "#define GROUP " LIGHTPROBE__TEXT(LIGHTPROBE__GROUP) "\n"
    "const int START = 0, START_AGAIN = 1, NEAR = 2, RELAX = 3, MEASURE = 1000000;\n"
    LIGHTPROBE__C_NAMES
    "#define LIGHTPROBE_PRECISE precise\n"
    "#define LIGHTPROBE_FLOAT float\n"
    "#define LIGHTPROBE_INT int\n"
    "#define FLT_MAX 3.402823466e38\n"
    "#define lightprobe_wide vec2\n"
    "#define LIGHTPROBE_ZERO vec2(0.0)\n"
    "#define LIGHTPROBE_ADD lightprobe_add\n"
    "#define LIGHTPROBE_VALUE(sum) (sum.x + sum.y)\n"
    "// The sum's float, and what rounding has taken from it (Knuth's two-sum).\n"
    "void lightprobe_add(inout vec2 sum, float x)\n"
    "{\n"
    "    precise float high = sum.x + x, of_x = high - sum.x;\n"
    "    precise float low = sum.y + ((sum.x - (high - of_x)) + (x - of_x));\n"
    "    sum = vec2(high, low);\n"
    "}\n"
    "// Squares as two floats (Dekker's product) after an exact scale, and a step of Newton's: rounded once,\n"
    "// as from double, whatever the driver's square root.\n"
    "float lightprobe_length(vec3 v)\n"
    "{\n"
    "    float top = max(max(abs(v.x), abs(v.y)), abs(v.z));\n"
    "    float up = uintBitsToFloat(207u << 23), down = uintBitsToFloat(47u << 23); // 2^80, 2^-80\n"
    "    float scale = top > 1e12 ? down : top < 1e-12 ? up : 1.0;\n"
    "    precise vec3 s = v * scale, t = 4097.0 * s, h = t - (t - s), l = s - h;\n"
    "    precise vec3 p = s * s, e = ((h * h - p) + 2.0 * h * l) + l * l;\n"
    "    vec2 sum = vec2(p.x, (e.x + e.y) + e.z);\n"
    "    lightprobe_add(sum, p.y);\n"
    "    lightprobe_add(sum, p.z);\n"
    "    if (!(sum.x > 0.0)) return 0.0;\n"
    "    precise float r = sqrt(sum.x), q = r * r, u = 4097.0 * r, m = u - (u - r), n = r - m;\n"
    "    precise float rest = ((sum.x - q) - (((m * m - q) + 2.0 * m * n) + n * n)) + sum.y;\n"
    "    precise float root = r + 0.5 * rest / r;\n"
    "    return root * (top > 1e12 ? up : top < 1e-12 ? down : 1.0);\n"
    "}\n";

// What the kernels have in common. All but the sums over tiles are one work group, one after the
// other: lightprobe__best under the same names. Sums run over the leaves in their order, one thread
// a cluster, so that they are the CPU's. Several programs, since llvmpipe takes half a minute to
// compile them as one.
static const char lightprobe__glsl_work[] =
    "layout(std430, binding = LIGHTPROBE_BINDING1) coherent buffer numbers {\n"
    "    int repaired;\n"
    "    float omega[HALF * HALF], weight[HALF * HALF]; // of a quarter face\n"
    "    vec2 sum_of_all[3];\n"
    "    float bright[LIGHTS], total, mean, reach, gains[LIGHTS];\n"
    "    lightprobe_errors left;\n"
    "    int leaf_count, cluster_count, going_on, jumps;\n"
    "    float fading, pace;\n"
    "    int rank[LIGHTS], order[LEAVES];\n"
    "};\n"
    "// Arrays without a length: of those with one Mesa lists every member of every element,\n"
    "// 18 s for 1000 lights.\n"
    "layout(std430, binding = LIGHTPROBE_BINDING2) coherent buffer all_leaves {\n"
    "    lightprobe_leaf leaves[];\n"
    "};\n"
    "layout(std430, binding = LIGHTPROBE_BINDING3) coherent buffer all_clusters {\n"
    "    lightprobe_cluster clusters[];\n"
    "};\n"
    "layout(std430, binding = LIGHTPROBE_BINDING4) coherent buffer all_cells {\n"
    "    lightprobe_cell cells[];\n"
    "};\n"
    "layout(location = 0) uniform int stage; // the mip level, or what is to be done\n"
    "int lane = int(gl_LocalInvocationIndex);\n"
    "\n"
    "// n, unknown to the compiler: unrolled, reads of buffers take llvmpipe long to compile. Not by a\n"
    "// uniform, for which zink of Mesa 22 takes what that was some dispatches ago.\n"
    "int LIGHTPROBE_ROLLED(int n)\n"
    "{\n"
    "    return gl_NumWorkGroups.x == 0u ? 0 : n;\n"
    "}\n"
    "void sync()\n"
    "{\n"
    "    memoryBarrierBuffer();\n"
    "    memoryBarrierShared();\n"
    "    barrier();\n"
    "}\n"
    "bool is_black()\n"
    "{\n"
    "    return !(total >= LIGHTPROBE_BLACK);\n"
    "}\n"
    "shared float values[GROUP];\n"
    "shared int places[GROUP];\n"
    "// That lane's, of equals the lower place; a place below 0 does not count.\n"
    "bool is_larger(int a, float value, int place)\n"
    "{\n"
    "    if (places[a] < 0 || place < 0) return place < 0;\n"
    "    return values[a] > value || (values[a] == value && places[a] < place);\n"
    "}\n"
    "// Place of the largest value of all lanes. Few barriers: each costs compile time. The caller\n"
    "// has one before the next call.\n"
    "int largest(float value, int place, out float top)\n"
    "{\n"
    "    values[lane] = value;\n"
    "    places[lane] = place;\n"
    "    sync();\n"
    "    for (int i = lane + 8; lane < 8 && i < GROUP; i += 8) {\n"
    "        if (is_larger(lane, values[i], places[i])) continue;\n"
    "        values[lane] = values[i];\n"
    "        places[lane] = places[i];\n"
    "    }\n"
    "    sync();\n"
    "    int at = 0;\n"
    "    for (int i = 1; i < LIGHTPROBE_ROLLED(8); i++)\n"
    "        if (!is_larger(at, values[i], places[i])) at = i;\n"
    "    top = values[at];\n"
    "    return places[at];\n"
    "}\n";

// Texels, and cells of all sizes.
static const char lightprobe__glsl_cells[] =
    "layout(binding = LIGHTPROBE_UNIT) uniform samplerCube probe;\n"
    "\n"
    "// Returns 1 where a channel is negative, NaN or infinite; it counts as 0. The fourth: distance.\n"
    "int lightprobe_read(int face, int x, int y, out vec4 rgb)\n"
    "{\n"
    "    vec3 to;\n"
    "    lightprobe_to_world(face, 1.0, lightprobe_centre(side, x), lightprobe_centre(side, y), to);\n"
    "    rgb = textureLod(probe, to, float(stage));\n"
    "    if (distances == 0 || !(floatBitsToUint(rgb.a) < 0x7f800000u)) rgb.a = 0.0;\n"
    "    uvec3 bits = floatBitsToUint(rgb.rgb);\n"
    "    bvec3 good = lessThan(bits, uvec3(0x7f800000u));\n"
    "    bvec3 minus_0 = equal(bits, uvec3(0x80000000u));\n"
    "    for (int i = 0; i < 3; i++) if (!good[i]) rgb[i] = 0.0;\n"
    "    if (distances == 2) rgb.a = lightprobe_whole_distance(rgb.rgb, rgb.a);\n"
    "    return all(bvec3(uvec3(good) | uvec3(minus_0))) ? 0 : 1;\n"
    "}\n";

// lightprobe__sum_tiles, one thread a tile, and three levels of cells above.
static const char lightprobe__glsl_tiles[] =
    "layout(local_size_x = 8, local_size_y = 8) in;\n"
    "\n"
    "float sum_12(vec3 c[4]) // in the order of the CPU's registers of four floats\n"
    "{\n"
    "    precise vec4 s = vec4(c[0], c[1].r) + vec4(c[1].gb, c[2].rg) + vec4(c[2].b, c[3]);\n"
    "    precise float all = (s.x + s.y) + (s.z + s.w);\n"
    "    return all;\n"
    "}\n"
    "void sum_tile(ivec3 p)\n"
    "{\n"
    "    precise vec3 f[4], m[4], n[4];\n"
    "    precise float solid_angle = 0.0, inverse = 0.0;\n"
    "    int bad = 0;\n"
    "    for (int j = 0; j < 4; j++) f[j] = m[j] = n[j] = vec3(0.0);\n"
    "    for (int row = 0; row < LIGHTPROBE_ROLLED(4); row++) {\n"
    "        int y = 4 * p.y + row;\n"
    "        for (int j = 0; j < 4; j++) {\n"
    "            int x = 4 * p.x + j;\n"
    "            if (x < side && y < side) {\n"
    "                int at = lightprobe_quarter(x, y);\n"
    "                vec4 rgb;\n"
    "                bad += lightprobe_read(p.z, x, y, rgb);\n"
    "                solid_angle += omega[at];\n"
    "                f[j] += rgb.rgb * omega[at];\n"
    "                m[j] += rgb.rgb * (vec3(0.2126, 0.7152, 0.0722) * weight[at]);\n"
    "            }\n"
    "            n[j] += m[j];\n"
    "        }\n"
    "    }\n"
    "    if (distances != 0)\n"
    "        inverse = lightprobe_small_cell(p.z, LIGHTPROBE_TILE_LEVEL, p.x, p.y).resultant.w;\n"
    "    float t0 = lightprobe_centre(side, 4 * p.y + 4);\n"
    "    float t1 = lightprobe_centre(side, 4 * p.y + 3);\n"
    "    precise vec3 flux = (f[0] + f[1]) + (f[2] + f[3]), v;\n"
    "    v[0] = sum_12(m);\n"
    "    v[2] = t0 * v[0] + (t1 - t0) * sum_12(n);\n"
    "    for (int j = 0; j < 4; j++) {\n"
    "        int x = 4 * p.x + j;\n"
    "        m[j] *= x < side ? lightprobe_centre(side, x) : 0.0;\n"
    "    }\n"
    "    v[1] = sum_12(m);\n"
    "    int to = lightprobe_cell_index(p.z, LIGHTPROBE_TILE_LEVEL, p.x, p.y);\n"
    "    cells[to] = lightprobe_cell(vec4(flux, solid_angle), vec4(v, inverse));\n"
    "    if (bad > 0) atomicAdd(repaired, bad);\n"
    "}\n"
    "void main()\n"
    "{\n"
    "    ivec3 p = ivec3(gl_GlobalInvocationID), group = ivec3(gl_WorkGroupID);\n"
    "    ivec3 l = ivec3(gl_LocalInvocationID);\n"
    "    if (p.x < TILES && p.y < TILES) sum_tile(p);\n"
    "    for (int up = 1; up <= min(TOP - LIGHTPROBE_TILE_LEVEL, 3); up++) {\n"
    "        int level = LIGHTPROBE_TILE_LEVEL + up, n = lightprobe_level_side(side, level), edge = 8 >> up;\n"
    "        int x = edge * group.x + l.x, y = edge * group.y + l.y;\n"
    "        sync();\n"
    "        if (l.x < edge && l.y < edge && x < n && y < n) lightprobe_halve(p.z, level, x, y);\n"
    "    }\n"
    "}\n";

static const char lightprobe__glsl_leaves[] =
    "layout(local_size_x = GROUP) in;\n"
    "shared vec2 sums[3][GROUP];\n"
    "shared float leaf_errors[LEAVES];\n"
    "\n"
    "void find_total()\n"
    "{\n"
    "    int level = min(TOP, LIGHTPROBE_TILE_LEVEL + 1), n = lightprobe_level_side(side, level);\n"
    "    vec2 all[3] = vec2[3](vec2(0.0), vec2(0.0), vec2(0.0));\n"
    "    for (int i = lane; i < 6 * n * n; i += GROUP)\n"
    "        for (int c = 0; c < 3; c++) lightprobe_add(all[c], cells[first_cell[level] + i].flux[c]);\n"
    "    for (int c = 0; c < 3; c++) sums[c][lane] = all[c];\n"
    "    sync();\n"
    "    if (lane < 3) {\n"
    "        vec2 sum = vec2(0.0);\n"
    "        for (int i = 0; i < GROUP; i++) {\n"
    "            lightprobe_add(sum, sums[lane][i].x);\n"
    "            sum.y += sums[lane][i].y;\n"
    "        }\n"
    "        sum_of_all[lane] = sum;\n"
    "        sums[lane][0] = sum;\n"
    "    }\n"
    "    sync();\n"
    "    if (lane == 0) {\n"
    "        total = lightprobe_luminance(vec3(LIGHTPROBE_VALUE(sums[0][0]), LIGHTPROBE_VALUE(sums[1][0]),\n"
    "                                          LIGHTPROBE_VALUE(sums[2][0])));\n"
    "        float inverse = 0.0;\n"
    "        for (int i = 0; i < LIGHTPROBE_ROLLED(6); i++) inverse += cells[first_cell[TOP] + i].resultant.w;\n"
    "        lightprobe_set_scales(inverse);\n"
    "    }\n"
    "    sync();\n"
    "}\n"
    "void set_leaf(int i, int face, int level, int x, int y)\n"
    "{\n"
    "    leaves[i] = lightprobe_leaf_of(face, level, x, y);\n"
    "    leaf_errors[i] = lightprobe_leaf_error(leaves[i]);\n"
    "}\n"
    "// Six faces, then again and again the parts of a leaf, the first of them in its place.\n"
    "void make_leaves()\n"
    "{\n"
    "    int count = 6, face = lane, level = TOP, x = 0, y = 0, place = lane < 6 ? lane : -1;\n"
    "    float last = 0.0;\n"
    "    for (;;) {\n"
    "        if (place >= 0) set_leaf(place, face, level, x, y);\n"
    "        sync();\n"
    "        float top;\n"
    "        int at = -1;\n"
    "        for (int i = lane; i < count; i += GROUP)\n"
    "            if (at < 0 || leaf_errors[i] > leaf_errors[at]) at = i;\n"
    "        at = largest(at < 0 ? 0.0 : leaf_errors[at], at, top);\n"
    "        if (lightprobe_is_enough(count, LEAVES, top, last, total) == 1) break;\n"
    "        last = top;\n"
    "        face = leaves[at].face;\n"
    "        level = leaves[at].level - 1;\n"
    "        x = 2 * leaves[at].x + lane % 2;\n"
    "        y = 2 * leaves[at].y + lane / 2;\n"
    "        place = -1;\n"
    "        int n = lightprobe_level_side(side, level), x0 = x - lane % 2, y0 = y - lane / 2;\n"
    "        for (int k = 0; k < 4; k++) {\n"
    "            if (x0 + k % 2 >= n || y0 + k / 2 >= n) continue;\n"
    "            if (lane == k) place = k == 0 ? at : count;\n"
    "            if (k > 0) count++;\n"
    "        }\n"
    "        sync();\n"
    "    }\n"
    "    if (lane == 0) leaf_count = count;\n"
    "}\n"
    "void main()\n"
    "{\n"
    "    for (int level = LIGHTPROBE_TILE_LEVEL + 4; level <= TOP; level++) {\n"
    "        int n = lightprobe_level_side(side, level);\n"
    "        for (int i = lane; i < 6 * n * n; i += GROUP)\n"
    "            lightprobe_halve(i / (n * n), level, i % n, i / n % n);\n"
    "        sync();\n"
    "    }\n"
    "    find_total();\n"
    "    if (!is_black()) make_leaves();\n"
    "}\n";

// Which leaf belongs to which cluster, and sums over them: lightprobe__start, __find_near, __relax.
static const char lightprobe__glsl_gather[] =
    "layout(local_size_x = GROUP) in;\n"
    "shared int owners[LEAVES]; // clusters of the leaves, which each lane goes through one by one\n"
    "\n"
    "// One cluster of everything, or those of the previous lights.\n"
    "void start()\n"
    "{\n"
    "    int count = stage == START_AGAIN ? min(lightprobe_count, LIGHTS) : 0, living = 0;\n"
    "    vec2 all = vec2(0.0);\n"
    "    for (int k = 0; k < count; k++) {\n"
    "        lightprobe_add(all, lightprobe_luminance(lightprobe_lights[k].irradiance));\n"
    "        living += lightprobe_lights[k].state[4] > 0.0 ? 1 : 0;\n"
    "    }\n"
    "    bool again = living > 0 && lightprobe_goes_on(LIGHTPROBE_VALUE(all), total) == 1;\n"
    "    if (MIN_SHARE > 0.0 || MIN_SHADOW > 0.0) again = false;\n"
    "    for (int k = lane; k < LIGHTS; k += GROUP) {\n"
    "        lightprobe_cluster c = lightprobe_fresh();\n"
    "        if (k < count && living > 0) c = lightprobe_recalled(lightprobe_lights[k], total, again ? 0 : 1);\n"
    "        clusters[k] = c;\n"
    "    }\n"
    "    if (lane == 0) {\n"
    "        cluster_count = living > 0 ? count : 1;\n"
    "        going_on = count;\n"
    "        jumps = again ? 0 : 1;\n"
    "        fading = again ? lightprobe_lights[0].state[5] : 0.0;\n"
    "    }\n"
    "    sync();\n"
    "    for (int i = lane; i < leaf_count; i += GROUP) {\n"
    "        float best = FLT_MAX;\n"
    "        int to = 0;\n"
    "        if (count > 0) leaves[i].tone = lightprobe_own_tone(leaves[i], mean);\n"
    "        for (int k = 0; k < cluster_count && count > 0; k++) {\n"
    "            float d = lightprobe_seed_distance(i, k);\n"
    "            if (d >= best) continue;\n"
    "            best = d;\n"
    "            to = k;\n"
    "        }\n"
    "        leaves[i].cluster = to;\n"
    "    }\n"
    "    sync();\n"
    "}\n"
    "// Sorts the leaves by cluster on the way.\n"
    "void sum_clusters()\n"
    "{\n"
    "    int all = leaf_count;\n"
    "    for (int i = lane; i < all; i += GROUP) owners[i] = leaves[i].cluster;\n"
    "    sync();\n"
    "    for (int k = lane; k < cluster_count; k += GROUP) {\n"
    "        int at = 0, count = 0;\n"
    "        for (int i = 0; i < all; i++) at += owners[i] < k ? 1 : 0;\n"
    "        for (int i = 0; i < all; i++)\n"
    "            if (owners[i] == k) order[at + count++] = i;\n"
    "        clusters[k].first = at;\n"
    "        lightprobe_sum_cluster(k, count);\n"
    "    }\n"
    "    sync();\n"
    "}\n"
    "void main()\n"
    "{\n"
    "    if (is_black() || (going_on > 0 && stage > RELAX)) return;\n"
    "    if (stage < NEAR) start();\n"
    "    for (int i = lane; stage > NEAR && going_on == 0 && i < leaf_count; i += GROUP)\n"
    "        leaves[i].cluster = lightprobe_nearest_cluster(i);\n"
    "    sum_clusters();\n"
    "    for (int a = lane; stage == NEAR && a < cluster_count; a += GROUP)\n"
    "        lightprobe_find_near(a);\n"
    "}\n";

// lightprobe__plan_split for several clusters at once, each by as many lanes as there are bins.
static const char lightprobe__glsl_plan[] =
    "layout(local_size_x = GROUP) in;\n"
    "shared lightprobe_sum bins[2 * GROUP]; // along the axis, then by tone\n"
    "shared float costs[2 * GROUP];\n"
    "shared vec2 profiles[GROUP];\n"
    "\n"
    "// Cost of the cut behind a bin; first: bin 0.\n"
    "float cut_cost(int first, int bin)\n"
    "{\n"
    "    lightprobe_sum below = lightprobe_nothing(), above = below;\n"
    "    for (int i = first; i <= bin; i++) below = lightprobe_add_sum(below, bins[i]);\n"
    "    for (int i = first + LIGHTPROBE_BINS - 1; i > bin; i--)\n"
    "        above = lightprobe_add_sum(above, bins[i]);\n"
    "    return lightprobe_cut_cost(below, above, total);\n"
    "}\n"
    "// k: the cluster of these lanes, or -1: then they only keep step.\n"
    "void plan_split(int k)\n"
    "{\n"
    "    int bin = lane % LIGHTPROBE_BINS, zero = lane - bin;\n"
    "    lightprobe_sum whole = lightprobe_nothing(), own = whole, own_tone = whole;\n"
    "    if (k >= 0) whole = clusters[k].sum;\n"
    "    int first = k >= 0 ? clusters[k].first : 0, end = first + whole.count;\n"
    "    lightprobe_axes axes = lightprobe_axes_of(first, whole);\n"
    "    precise vec2 profile = vec2(0.0);\n"
    "    for (int at = first; at < end; at++) {\n"
    "        lightprobe_leaf leaf = leaves[order[at]];\n"
    "        profile += vec2(lightprobe_below(lightprobe_streak_of(axes.along, leaf), bin),\n"
    "                        lightprobe_below(lightprobe_streak_of(axes.across, leaf), bin));\n"
    "        if (lightprobe_bin(axes.along, leaf) == bin) own = lightprobe_add_leaf(own, leaf);\n"
    "        if (lightprobe_bin(axes.by_tone, leaf) == bin) own_tone = lightprobe_add_leaf(own_tone, leaf);\n"
    "    }\n"
    "    bins[lane] = own;\n"
    "    bins[GROUP + lane] = own_tone;\n"
    "    profiles[lane] = profile;\n"
    "    sync();\n"
    "    costs[lane] = axes.along.scale > 0.0 ? cut_cost(zero, lane) : FLT_MAX;\n"
    "    costs[GROUP + lane] = axes.by_tone.scale > 0.0 ? cut_cost(GROUP + zero, GROUP + lane) : FLT_MAX;\n"
    "    sync();\n"
    "    if (bin == 0 && k >= 0) {\n"
    "        float least = FLT_MAX, below_u[LIGHTPROBE_BINS], below_v[LIGHTPROBE_BINS];\n"
    "        lightprobe_axis axis = axes.along;\n"
    "        for (int i = 0; i < LIGHTPROBE_ROLLED(2 * LIGHTPROBE_BINS); i++) {\n"
    "            int at = i % LIGHTPROBE_BINS;\n"
    "            bool by_tone = i >= LIGHTPROBE_BINS;\n"
    "            float cost = costs[lane + at + (by_tone ? GROUP : 0)];\n"
    "            if (at == LIGHTPROBE_BINS - 1 || cost >= least) continue;\n"
    "            least = cost;\n"
    "            axis = axes.along;\n"
    "            if (by_tone) axis = axes.by_tone;\n"
    "            axis.threshold = lightprobe_threshold(axis, at);\n"
    "        }\n"
    "        for (int i = 0; i < LIGHTPROBE_BINS; i++) {\n"
    "            below_u[i] = profiles[lane + i].x;\n"
    "            below_v[i] = profiles[lane + i].y;\n"
    "        }\n"
    "        precise float uneven = lightprobe_unevenness(axes.along, below_u, whole.luminance) +\n"
    "                               lightprobe_unevenness(axes.across, below_v, whole.luminance);\n"
    "        float error = lightprobe_edge_error(whole, 0.5 * uneven, total);\n"
    "        bool good = least < FLT_MAX;\n"
    "        precise float gain = lightprobe_cost(whole, total) - least;\n"
    "        clusters[k].axis = axis;\n"
    "        clusters[k].gain = good ? gain : 0.0;\n"
    "        clusters[k].error = error;\n"
    "        gains[k] = good ? error : 0.0;\n"
    "    }\n"
    "    sync();\n"
    "}\n"
    "// Of count clusters; each by as many lanes as there are bins.\n"
    "void plan_all(int count)\n"
    "{\n"
    "    for (int first = 0; first < count; first += GROUP / LIGHTPROBE_BINS) {\n"
    "        int at = first + lane / LIGHTPROBE_BINS;\n"
    "        plan_split(at < count ? at : -1);\n"
    "    }\n"
    "}\n"
    "int largest_gain(int count, out float top)\n"
    "{\n"
    "    int at = -1;\n"
    "    for (int k = lane; k < count; k += GROUP)\n"
    "        if (at < 0 || gains[k] > gains[at]) at = k;\n"
    "    return largest(at < 0 ? 0.0 : gains[at], at, top);\n"
    "}\n";

static const char lightprobe__glsl_divide[] =
    "// Plans all clusters, then the two parts of each split. The CPU plans as late as it can; the\n"
    "// same clusters come first. MEASURE: only finds the errors.\n"
    "void main()\n"
    "{\n"
    "    if (is_black()) return;\n"
    "    int count = cluster_count, most = 0;\n"
    "    if (stage == 0 || stage == MEASURE) plan_all(count);\n"
    "    if (lane == 0 && (stage == 0 || stage == MEASURE)) left = lightprobe_all_errors();\n"
    "    sync();\n"
    "    for (int splits = 0; splits < SPLITS && stage != MEASURE; splits++) {\n"
    "        float top;\n"
    "        if (count >= LIGHTS || !(lightprobe_root_error(left, total) > TOLERANCE)) break;\n"
    "        most = largest_gain(count, top);\n"
    "        if (!(top > 0.0)) break;\n"
    "        if (lane == 0) {\n"
    "            left = lightprobe_add_error(left, most, -1.0);\n"
    "            lightprobe_split(most, count);\n"
    "        }\n"
    "        sync();\n"
    "        plan_split(lane < LIGHTPROBE_BINS ? most : lane < 2 * LIGHTPROBE_BINS ? count : -1);\n"
    "        if (lane == 0) left = lightprobe_add_error(lightprobe_add_error(left, most, 1.0), count, 1.0);\n"
    "        sync();\n"
    "        count++;\n"
    "    }\n"
    "    if (lane == 0) cluster_count = count;\n"
    "}\n";

static const char lightprobe__glsl_reassign[] =
    "shared lightprobe_pair pairs[GROUP];\n"
    "void main()\n"
    "{\n"
    "    if (is_black() || going_on == 0) return;\n"
    "    bool fades = fading < 0.0 || fading > 1.0;\n"
    "    for (int k = 0; k < cluster_count; k++) fades = fades || clusters[k].lives == 0;\n"
    "    if (fades || (jumps != 0 && !(MIN_SHARE > 0.0 || MIN_SHADOW > 0.0 || TOLERANCE > 0.0)))\n"
    "        return;\n"
    "    plan_all(cluster_count);\n"
    "    for (int k = lane; k < cluster_count; k += GROUP) {\n"
    "        clusters[k].changed = 0;\n"
    "        gains[k] = clusters[k].gain;\n"
    "    }\n"
    "    lightprobe_errors e = lightprobe_all_errors();\n"
    "    sync();\n"
    "    for (int changes = cluster_count / 4; changes >= 0; changes--) {\n"
    "        float gain, top;\n"
    "        int most = largest_gain(cluster_count, gain);\n"
    "        lightprobe_pair pair = lightprobe_pair(-1, -1, FLT_MAX);\n"
    "        for (int k = lane; k < cluster_count; k += GROUP) pair = lightprobe_cheaper_pair(pair, k, most);\n"
    "        pairs[lane] = pair;\n"
    "        sync();\n"
    "        int first = largest(-pair.cost, pair.a, top);\n"
    "        if (first < 0) break;\n"
    "        pair = pairs[first % GROUP];\n"
    "        lightprobe_errors merged = lightprobe_merged(e, pair);\n"
    "        float error = lightprobe_root_error(merged, total);\n"
    "        if (lightprobe_should_reassign(error, TOLERANCE, gain, pair.cost, total) == 0) break;\n"
    "        e = merged;\n"
    "        sync();\n"
    "        if (lane == 0) lightprobe_merge(pair, most);\n"
    "        sync();\n"
    "    }\n"
    "}\n";

// Seeds, lightprobe__share_out, __fade.
static const char lightprobe__glsl_settle[] =
    "layout(local_size_x = GROUP) in;\n"
    "void share_out(int i)\n"
    "{\n"
    "    float least = FLT_MAX;\n"
    "    precise float parts = 0.0;\n"
    "    for (int k = 0; k < 2 * cluster_count; k++) {\n"
    "        int at = k % cluster_count;\n"
    "        float d = lightprobe_seed_distance(i, at);\n"
    "        if (k < cluster_count) least = min(least, d);\n"
    "        else parts += lightprobe_part(d, least, leaves[i].half_width, unit);\n"
    "    }\n"
    "    leaves[i].least = least;\n"
    "    leaves[i].parts = parts;\n"
    "}\n"
    "void fade()\n"
    "{\n"
    "    int changes = fading < 0.0 ? 1 : lightprobe_is_changed();\n"
    "    float passed = lightprobe_pace(changes), frames = changes != 0 ? LIGHTPROBE_FADE : fading;\n"
    "    for (int k = lane; k < cluster_count; k += GROUP) lightprobe_fade(k, changes, passed, frames);\n"
    "    sync();\n"
    "    for (int weighted = 1; weighted >= 0; weighted--) {\n"
    "        lightprobe_excess e = lightprobe_all_excess(weighted);\n"
    "        sync();\n"
    "        for (int k = lane; k < cluster_count; k += GROUP)\n"
    "            clusters[k].late = lightprobe_balanced(clusters[k].late, clusters[k].now, e);\n"
    "        sync();\n"
    "    }\n"
    "    if (lane == 0) fading = frames > passed ? frames - passed : 0.0;\n"
    "    if (lane == 0) pace = passed;\n"
    "    sync();\n"
    "}\n"
    "// Seeds, parts of leaves, what fades.\n"
    "void main()\n"
    "{\n"
    "    if (is_black()) return;\n"
    "    for (int k = lane; k < cluster_count; k += GROUP)\n"
    "        if (jumps != 0 || clusters[k].id < 0) lightprobe_set_seed(k);\n"
    "    sync();\n"
    "    for (int i = lane; i < leaf_count && going_on > 0; i += GROUP) share_out(i);\n"
    "    sync();\n"
    "    for (int k = lane; k < cluster_count && going_on > 0; k += GROUP) {\n"
    "        lightprobe_moments now = lightprobe_no_moments();\n"
    "        for (int i = 0; i < leaf_count; i++) {\n"
    "            float part = lightprobe_takes(i, k);\n"
    "            if (part > 0.0) now = lightprobe_add_moments(now, leaves[i], part);\n"
    "        }\n"
    "        clusters[k].now = now;\n"
    "    }\n"
    "    sync();\n"
    "    if (jumps == 0) fade();\n"
    "    if (lane == 0 && going_on == 0) fading = -1.0;\n"
    "}\n";

static const char lightprobe__glsl_write[] =
    "layout(local_size_x = GROUP) in;\n"
    "layout(std430, binding = LIGHTPROBE_BINDING5) coherent buffer result {\n"
    "    int count, repaired_texels;\n"
    "    float error;\n"
    "    vec4 total, residual, residual_sh[9];\n"
    "    lightprobe_light lights[];\n"
    "} made;\n"
    "\n"
    "vec4 rgb_of(vec2 sum[3])\n"
    "{\n"
    "    vec4 rgb = vec4(0.0);\n"
    "    for (int i = 0; i < 3; i++) rgb[i] = lightprobe_unscaled(LIGHTPROBE_VALUE(sum[i]));\n"
    "    return rgb;\n"
    "}\n"
    "void write_light(int i, int k, int id)\n"
    "{\n"
    "    lightprobe_region region = lightprobe_no_region();\n"
    "    for (int turn = 0; turn < 2; turn++) {\n"
    "        for (int leaf = 0; leaf < leaf_count; leaf++) {\n"
    "            float part = leaves[leaf].cluster == k ? 1.0 : 0.0;\n"
    "            if (going_on > 0) part = lightprobe_takes(leaf, k);\n"
    "            if (!(part > 0.0)) continue;\n"
    "            if (turn == 0) region = lightprobe_add_region(region, leaves[leaf], part);\n"
    "            else region = lightprobe_add_second(region, leaves[leaf], part);\n"
    "        }\n"
    "        if (turn == 0) region = lightprobe_direct(region, clusters[k], jumps);\n"
    "    }\n"
    "    lightprobe_light light = lightprobe_make_light(k, region);\n"
    "    light.id = id;\n"
    "    made.lights[i] = light;\n"
    "}\n"
    "// Luminance; below 0 of those that are too dim, 0 of black ones.\n"
    "void find_bright(int k)\n"
    "{\n"
    "    vec2 sum = vec2(0.0);\n"
    "    int first = clusters[k].first, end = going_on > 0 ? 0 : first + clusters[k].sum.count;\n"
    "    for (int at = first; at < end; at++) lightprobe_add(sum, leaves[order[at]].luminance);\n"
    "    if (going_on > 0) lightprobe_add(sum, lightprobe_luminance(clusters[k].now.flux));\n"
    "    if (jumps == 0) lightprobe_add(sum, lightprobe_luminance(clusters[k].late.flux));\n"
    "    float luminance = LIGHTPROBE_VALUE(sum);\n"
    "    bright[k] = luminance < MIN_SHARE * total ? -luminance : luminance;\n"
    "    gains[k] = luminance > 0.0 ? lightprobe_shadow(clusters[k].sum, total) : 0.0;\n"
    "}\n"
    "// The weakest shadows first; then lane 0 leaves out the first ones.\n"
    "void leave_weak()\n"
    "{\n"
    "    int count = 0;\n"
    "    for (int k = lane; k < cluster_count; k += GROUP) {\n"
    "        int at = 0;\n"
    "        for (int j = 0; j < cluster_count; j++) {\n"
    "            bool before = gains[j] == gains[k] ? j < k : gains[j] < gains[k];\n"
    "            at += bright[j] > 0.0 && before ? 1 : 0;\n"
    "        }\n"
    "        if (bright[k] > 0.0) rank[at] = k;\n"
    "    }\n"
    "    for (int k = 0; k < cluster_count; k++) count += bright[k] > 0.0 ? 1 : 0;\n"
    "    sync();\n"
    "    precise float lost = 0.0;\n"
    "    for (int i = 0; lane == 0 && i < count; i++) {\n"
    "        lost += gains[rank[i]];\n"
    "        if (lost > MIN_SHADOW) break;\n"
    "        bright[rank[i]] = -bright[rank[i]];\n"
    "    }\n"
    "    sync();\n"
    "}\n"
    "// Brightest first unless they go on from previous ones.\n"
    "void find_rank(int k)\n"
    "{\n"
    "    int at = 0;\n"
    "    for (int j = 0; j < cluster_count; j++) {\n"
    "        bool equal = going_on > 0 || bright[j] == bright[k];\n"
    "        bool before = equal ? j < k : bright[j] > bright[k];\n"
    "        at += bright[j] > 0.0 && before ? 1 : 0;\n"
    "    }\n"
    "    if (bright[k] > 0.0) rank[at] = k;\n"
    "    if (bright[k] >= 0.0) return;\n"
    "    at = LIGHTS - 1; // what is left out comes last, from behind\n"
    "    for (int j = 0; j < k; j++) at -= bright[j] < 0.0 ? 1 : 0;\n"
    "    rank[at] = k;\n"
    "}\n"
    "void write_lights()\n"
    "{\n"
    "    int count = 0, weak = 0, next_id = 0;\n"
    "    for (int k = lane; k < cluster_count; k += GROUP) find_bright(k);\n"
    "    sync();\n"
    "    if (MIN_SHADOW > 0.0) leave_weak();\n"
    "    for (int k = lane; k < cluster_count; k += GROUP) find_rank(k);\n"
    "    for (int k = 0; k < cluster_count; k++) {\n"
    "        count += bright[k] > 0.0 ? 1 : 0;\n"
    "        weak += bright[k] < 0.0 ? 1 : 0;\n"
    "        if (clusters[k].id < 0x7fffffff - LIGHTPROBE_MAX_LIGHTS)\n"
    "            next_id = max(next_id, clusters[k].id + 1);\n"
    "    }\n"
    "    sync();\n"
    "    for (int i = lane; i < LIGHTS; i += GROUP) {\n"
    "        if (i >= count && i < LIGHTS - weak) continue;\n"
    "        int k = rank[i], id = clusters[k].id, fresh = next_id;\n"
    "        for (int j = 0; j < i && j < count; j++) fresh += clusters[rank[j]].id < 0 ? 1 : 0;\n"
    "        write_light(i, k, i >= count ? -1 : id < 0 ? fresh : id);\n"
    "    }\n"
    "    if (lane == 0) made.count = count;\n"
    "    sync();\n"
    "    for (int n = lane; n < 9; n += GROUP) {\n"
    "        precise vec3 sum = vec3(0.0);\n"
    "        for (int i = LIGHTS - 1; i >= LIGHTS - weak; i--) {\n"
    "            vec3 d = made.lights[i].direction;\n"
    "            sum += lightprobe_harmonic_weight(n, made.lights[i].cos_alpha, d.x, d.y, d.z) *\n"
    "                   (made.lights[i].irradiance * LIGHTPROBE_SCALE);\n"
    "        }\n"
    "        vec3 most = vec3(FLT_MAX * LIGHTPROBE_SCALE);\n"
    "        made.residual_sh[n] = vec4(clamp(sum, -most, most) / LIGHTPROBE_SCALE, 0.0);\n"
    "    }\n"
    "}\n"
    "void main()\n"
    "{\n"
    "    if (lane < 9) made.residual_sh[lane] = vec4(0.0);\n"
    "    if (lane == 0) {\n"
    "        made.count = 0;\n"
    "        made.repaired_texels = repaired;\n"
    "        made.total = rgb_of(sum_of_all);\n"
    "        repaired = 0;\n"
    "    }\n"
    "    sync();\n"
    "    if (!is_black()) write_lights();\n"
    "    if (lane != 0) return;\n"
    "    vec2 rest[3] = sum_of_all;\n"
    "    for (int i = 0; i < made.count; i++)\n"
    "        for (int c = 0; c < 3; c++) lightprobe_add(rest[c], -made.lights[i].irradiance[c] * LIGHTPROBE_SCALE);\n"
    "    made.error = is_black() ? 0.0 : lightprobe_root_error(left, total);\n"
    "    made.residual = rgb_of(rest);\n"
    "    made.residual_sh[0] = 0.25 * made.residual;\n"
    "}\n";
// clang-format on
// ---- Loader, log, programs ---- >>plumbing

static const struct {
    const char *name, *common, *body;
    const char *(*quote)(void);
} lightprobe__stages[] = {
    {"lightprobe tiles", lightprobe__glsl_cells, lightprobe__glsl_tiles, lightprobe__quote_cells},
    {"lightprobe leaves", lightprobe__glsl_cells, lightprobe__glsl_leaves, lightprobe__quote_cells},
    {"lightprobe gather", "", lightprobe__glsl_gather, lightprobe__quote_moving},
    {"lightprobe divide", lightprobe__glsl_plan, lightprobe__glsl_divide, lightprobe__quote_splits},
    {"lightprobe reassign", lightprobe__glsl_plan, lightprobe__glsl_reassign,
     lightprobe__quote_splits},
    {"lightprobe settle", "", lightprobe__glsl_settle, lightprobe__quote_moving},
    {"lightprobe write", "", lightprobe__glsl_write, lightprobe__quote_moving}};

static const char *lightprobe__program_name(int which)
{
    return lightprobe__stages[which].name;
}

// clang-format off
// [plumbing begin], which `make glsl` copies from mssm.h: edit it there

// Tells the log, where there is one, why a call fails; returns its result.
static lightprobe_result lightprobe__report(const lightprobe_gl *gl, lightprobe_result result, const char *format, ...)
{
    char line[256] = "lightprobe: ";
    const size_t start = strlen(line);
    va_list list;
    if (!gl->desc.log) return result;
    va_start(list, format);
    vsnprintf(line + start, sizeof line - start, format, list);
    va_end(list);
    gl->desc.log(gl->desc.user, line);
    return result;
}

static int lightprobe__get(const lightprobe_gl *gl, lightprobe__glenum name)
{
    int value[4] = {0}; // four: some drivers write more than one
    gl->f.GetIntegerv(name, value);
    return value[0];
}

// The first error since the last call. Bounded: a lost context reports one forever.
static lightprobe__glenum lightprobe__take_error(const lightprobe_gl *gl)
{
    const lightprobe__glenum first = gl->f.GetError();
    for (int i = 1; first && i < 16 && gl->f.GetError(); i++) continue;
    return first;
}

// What the caller has left would be taken for ours.
static void lightprobe__drop_errors(const lightprobe_gl *gl, const char *call)
{
    if (lightprobe__take_error(gl))
        lightprobe__report(gl, LIGHTPROBE_ERROR_GL, "a GL error was pending before %s", call);
}

static lightprobe_result lightprobe__load(lightprobe_gl *gl)
{
    const char *missing = NULL;
#define LIGHTPROBE__GL_LOAD(result, name, parameters)               \
    {                                                         \
        const lightprobe_gl_function f = gl->desc.load("gl" #name); \
        memcpy(&gl->f.name, &f, sizeof f);                    \
        if (!f && !missing) missing = "gl" #name;             \
    }
    LIGHTPROBE__GL_FUNCTIONS(LIGHTPROBE__GL_LOAD)
#undef LIGHTPROBE__GL_LOAD
    if (gl->f.GetIntegerv && gl->f.GetString && gl->f.GetError) {
        const char *text = (const char *)gl->f.GetString(LIGHTPROBE__GL_VERSION);
        const int major = lightprobe__get(gl, LIGHTPROBE__GL_MAJOR_VERSION);
        const int old = major < 4 || (major == 4 && lightprobe__get(gl, LIGHTPROBE__GL_MINOR_VERSION) < 5);
        if (!text) return lightprobe__report(gl, LIGHTPROBE_ERROR_GL_VERSION, "no context is current");
        if (old || !strncmp(text, "OpenGL ES", 9))
            return lightprobe__report(gl, LIGHTPROBE_ERROR_GL_VERSION,
                                "OpenGL 4.5 is needed, this context is %s", text);
    }
    if (!missing) return LIGHTPROBE_OK;
    return lightprobe__report(gl, LIGHTPROBE_ERROR_GL_VERSION,
                        "OpenGL 4.5 is needed (is a context current?), the loader does not find %s",
                        missing);
}

// Passes the whole log of a shader, or of the program, on.
static lightprobe_result lightprobe__report_build(const lightprobe_gl *gl, unsigned name, int program, int which)
{
    int length = 0;
    (program ? gl->f.GetProgramiv : gl->f.GetShaderiv)(name, LIGHTPROBE__GL_INFO_LOG_LENGTH, &length);
    lightprobe__report(gl, LIGHTPROBE_ERROR_GL, "cannot build %s", lightprobe__program_name(which));
    if (!gl->desc.log || length <= 1 || length > 1 << 20) return LIGHTPROBE_ERROR_GL;
    char *text = (char *)LIGHTPROBE_MALLOC((size_t)length + 1);
    if (!text) return LIGHTPROBE_ERROR_GL;
    memset(text, 0, (size_t)length + 1);
    (program ? gl->f.GetProgramInfoLog : gl->f.GetShaderInfoLog)(name, length, NULL, text);
    gl->desc.log(gl->desc.user, text);
    LIGHTPROBE_FREE(text);
    return LIGHTPROBE_ERROR_GL;
}

static lightprobe_result lightprobe__add_shader(lightprobe_gl *gl, int which, lightprobe__glenum type,
                                    const char *const *text, int count)
{
    int good = 0;
    const unsigned shader = gl->f.CreateShader(type);
    if (!gl->program[which]) gl->program[which] = gl->f.CreateProgram();
    if (!shader || !gl->program[which]) {
        gl->f.DeleteShader(shader); // GL passes over 0
        return lightprobe__report(gl, LIGHTPROBE_ERROR_GL, "no shader or program object for %s",
                            lightprobe__program_name(which));
    }
    gl->f.ShaderSource(shader, count, text, NULL);
    gl->f.CompileShader(shader);
    gl->f.GetShaderiv(shader, LIGHTPROBE__GL_COMPILE_STATUS, &good);
    const lightprobe_result r = good ? LIGHTPROBE_OK : lightprobe__report_build(gl, shader, 0, which);
    if (good) gl->f.AttachShader(gl->program[which], shader);
    gl->f.DeleteShader(shader);
    return r;
}

static lightprobe_result lightprobe__link(lightprobe_gl *gl, int which)
{
    const unsigned program = gl->program[which];
    int good = 0;
    gl->f.LinkProgram(program);
    gl->f.GetProgramiv(program, LIGHTPROBE__GL_LINK_STATUS, &good);
    gl->f.ObjectLabel(LIGHTPROBE__GL_PROGRAM, program, -1, lightprobe__program_name(which));
    return good ? LIGHTPROBE_OK : lightprobe__report_build(gl, program, 1, which);
}

// A name to bind again; 0 where the object has been deleted since, perhaps in another context.
static unsigned lightprobe__living(int name, lightprobe__glboolean(LIGHTPROBE__GLAPI *is)(unsigned))
{
    return name && is((unsigned)name) ? (unsigned)name : 0;
}

// GL does not take back a program that was deleted while in use, or whose last link failed.
static void lightprobe__use_again(const lightprobe_gl *gl, int program)
{
    int good = 0;
    const unsigned living = lightprobe__living(program, gl->f.IsProgram);
    if (living) gl->f.GetProgramiv(living, LIGHTPROBE__GL_LINK_STATUS, &good);
    if (living && !good)
        lightprobe__report(gl, LIGHTPROBE_OK, "program %d is in use no longer: its last link failed", program);
    gl->f.UseProgram(good ? living : 0);
}

// Puts the generic binding of storage buffers back.
static void lightprobe__bind_buffer_again(const lightprobe_gl *gl, int buffer)
{
    gl->f.BindBuffer(LIGHTPROBE__GL_SHADER_STORAGE_BUFFER, lightprobe__living(buffer, gl->f.IsBuffer));
}

// A buffer. Mesa forgets the generic binding too when one with an indexed binding is deleted.
static void lightprobe__delete_buffer(const lightprobe_gl *gl, unsigned buffer)
{
    if (!buffer) return;
    const int generic = lightprobe__get(gl, LIGHTPROBE__GL_SHADER_STORAGE_BUFFER_BINDING);
    gl->f.DeleteBuffers(1, &buffer); // which also unmaps it
    lightprobe__bind_buffer_again(gl, generic);
}

// [plumbing end]
// clang-format on

static lightprobe_result lightprobe__build_stage(lightprobe_gl *gl, int which, const char *defines)
{
    const int write = which == LIGHTPROBE__WRITE;
    const char *const text[] = {"#version 450 core\n",
                                defines,
                                write ? lightprobe_glsl_math() : "",
                                lightprobe_glsl_lights(),
                                lightprobe__glsl_shared,
                                lightprobe__quote_work(),
                                lightprobe__glsl_work,
                                lightprobe__stages[which].quote(),
                                write ? lightprobe__quote_lights() : "",
                                lightprobe__stages[which].common,
                                lightprobe__stages[which].body};
    const lightprobe_result r = lightprobe__add_shader(gl, which, LIGHTPROBE__GL_COMPUTE_SHADER,
                                                       text, (int)(sizeof text / sizeof *text));
    return r ? r : lightprobe__link(gl, which);
}

static lightprobe_result lightprobe__build_programs(lightprobe_gl *gl)
{
    const lightprobe_gl_desc *d = &gl->desc;
    const lightprobe__work *w = &gl->work;
    char defines[900];
    int at = snprintf(defines, sizeof defines,
                      "#define LIGHTPROBE_LIGHTS_ONLY\nconst int first_cell[] = int[](");
    for (int level = 0; level <= w->top; level++)
        at += snprintf(defines + at, sizeof defines - (size_t)at, "%d%s", w->first_cell[level],
                       level < w->top ? ", " : ");\n");
    // Floats by their bits: there are countries where printf has no point.
    at += snprintf(
        defines + at, sizeof defines - (size_t)at,
        "const int side = %d, distances = %d;\nfloat unit = uintBitsToFloat(%uu);\n"
        "#define HALF %d\n#define TILES %d\n#define TOP %d\n"
        "#define LIGHTS %d\n#define LEAVES %d\n#define SPLITS %d\n"
        "#define TOLERANCE uintBitsToFloat(%uu)\n#define MIN_SHARE uintBitsToFloat(%uu)\n"
        "#define MIN_SHADOW uintBitsToFloat(%uu)\n"
        "#define LIGHTPROBE_BINDING %d\n#define LIGHTPROBE_UNIT %d\n",
        d->side, d->distances, lightprobe__bits_of(lightprobe__unit(d->max_lights)), w->half,
        w->tiles, w->top, d->max_lights, w->max_leaves, gl->splits,
        lightprobe__bits_of(d->tolerance), lightprobe__bits_of(d->min_share),
        lightprobe__bits_of(d->min_shadow), d->first_buffer_binding, d->first_texture_unit);
    for (int i = 1; i < LIGHTPROBE__BINDINGS; i++) // some compilers want a number there, not a sum
        at += snprintf(defines + at, sizeof defines - (size_t)at,
                       "#define LIGHTPROBE_BINDING%d %d\n", i, d->first_buffer_binding + i);
    for (int i = 0; i < LIGHTPROBE__PROGRAMS; i++) {
        const lightprobe_result r = lightprobe__build_stage(gl, i, defines);
        if (r) return r;
    }
    return LIGHTPROBE_OK;
}

// Stays bound to the generic binding.
static int lightprobe__create_buffer(lightprobe_gl *gl, int which, size_t bytes, unsigned flags)
{
    static const char *const names[] = {"lightprobe lights", "lightprobe work",
                                        "lightprobe lights for the CPU"};
    if (bytes > (size_t)lightprobe__get(gl, LIGHTPROBE__GL_MAX_SHADER_STORAGE_BLOCK_SIZE)) return 0;
    gl->f.CreateBuffers(1, &gl->buffer[which]);
    if (!gl->buffer[which]) return 0;
    gl->f.BindBuffer(LIGHTPROBE__GL_SHADER_STORAGE_BUFFER, gl->buffer[which]);
    gl->f.BufferStorage(LIGHTPROBE__GL_SHADER_STORAGE_BUFFER, (ptrdiff_t)bytes, NULL, flags);
    gl->f.ObjectLabel(LIGHTPROBE__GL_BUFFER, gl->buffer[which], -1, names[which]);
    return 1;
}

// Of the work buffer: no repaired texels yet, and the CPU's weights of a quarter face's texels.
static lightprobe_result lightprobe__upload_weights(lightprobe_gl *gl)
{
    lightprobe__work w = gl->work;
    const size_t quarter = (size_t)w.half * (size_t)w.half;
    const size_t bytes = (1 + 2 * quarter) * sizeof(float);
    float *memory = (float *)LIGHTPROBE_MALLOC(bytes);
    if (!memory) return lightprobe__report(gl, LIGHTPROBE_ERROR_MEMORY, "no memory");
    memory[0] = 0;
    w.omega = memory + 1;
    w.weight = w.omega + quarter;
    lightprobe__make_tables(&w);
    gl->f.BindBuffer(LIGHTPROBE__GL_SHADER_STORAGE_BUFFER, gl->buffer[LIGHTPROBE__WORK]);
    gl->f.BufferSubData(LIGHTPROBE__GL_SHADER_STORAGE_BUFFER, 0, (ptrdiff_t)bytes, memory);
    LIGHTPROBE_FREE(memory);
    return LIGHTPROBE_OK;
}

static size_t lightprobe__aligned(size_t bytes)
{
    return (bytes + 255) & ~(size_t)255; // the coarsest alignment of bindings that GL allows
}

// Returns the sum.
static size_t lightprobe__size_parts(lightprobe_gl *gl)
{
    const size_t half = (size_t)gl->work.half, lights = (size_t)gl->desc.max_lights;
    const size_t leaves = (size_t)gl->work.max_leaves;
    const size_t bytes[] = {128 + 8 * half * half + 3 * 4 * lights + 4 * leaves, 80 * leaves,
                            448 * lights, 32 * (size_t)gl->work.cell_count};
    size_t sum = 0;
    for (int i = 0; i < LIGHTPROBE__PARTS; i++)
        sum += gl->part_bytes[i] = lightprobe__aligned(bytes[i]);
    return sum;
}

static lightprobe_result lightprobe__create_storage(lightprobe_gl *gl)
{
    const lightprobe__gl_functions *f = &gl->f;
    gl->slot_bytes = lightprobe__aligned(
        sizeof(lightprobe__gl_header) + (size_t)gl->desc.max_lights * sizeof(lightprobe__gl_light));
    const size_t ring = LIGHTPROBE__SLOTS * gl->slot_bytes;
    int good = lightprobe__create_buffer(gl, LIGHTPROBE__LIGHTS, ring, 0) &&
               lightprobe__create_buffer(gl, LIGHTPROBE__WORK, lightprobe__size_parts(gl),
                                         LIGHTPROBE__GL_DYNAMIC_STORAGE) &&
               lightprobe__create_buffer(gl, LIGHTPROBE__MAPPED, ring,
                                         LIGHTPROBE__GL_MAP_READ | LIGHTPROBE__GL_CLIENT_STORAGE);
    if (good) f->CreateSamplers(1, &gl->sampler);
    lightprobe__glenum error = lightprobe__take_error(gl);
    good = good && gl->sampler && !error;
    if (good) {
        f->SamplerParameteri(gl->sampler, LIGHTPROBE__GL_TEXTURE_MAG_FILTER,
                             LIGHTPROBE__GL_NEAREST);
        f->ObjectLabel(LIGHTPROBE__GL_SAMPLER, gl->sampler, -1, "lightprobe texels");
        gl->mapped = (const char *)f->MapBufferRange(LIGHTPROBE__GL_SHADER_STORAGE_BUFFER, 0,
                                                     (ptrdiff_t)ring, LIGHTPROBE__GL_MAP_READ);
        error = lightprobe__take_error(gl);
    }
    if (good && gl->mapped && !error) return lightprobe__upload_weights(gl);
    return lightprobe__report(
        gl, LIGHTPROBE_ERROR_GL, "no storage for this side and so many lights: %s",
        error == LIGHTPROBE__GL_OUT_OF_MEMORY ? "out of memory" : "the driver refuses it");
}

// Defaults filled in.
static lightprobe_result lightprobe__check_desc(lightprobe_gl *gl)
{
    lightprobe_gl_desc *d = &gl->desc;
    lightprobe_settings s;
    memset(&s, 0, sizeof s);
    if (d->side == 0) d->side = 128;
    const lightprobe_cube cube = {{NULL, NULL, NULL, NULL, NULL, NULL}, d->side, 4};
    s.max_lights = d->max_lights;
    s.tolerance = d->tolerance;
    s.min_share = d->min_share;
    s.min_shadow = d->min_shadow;
    s.distances = d->distances;
    s.log = d->log;
    s.user = d->user;
    const lightprobe_result r = lightprobe__check(&cube, &s, LIGHTPROBE_GL_MAX_LIGHTS);
    d->max_lights = s.max_lights;
    d->tolerance = s.tolerance;
    d->min_share = s.min_share;
    return r;
}

static lightprobe_result lightprobe__check_units(const lightprobe_gl *gl)
{
    const lightprobe__range ranges[] = {
        {"first_texture_unit", (double)gl->desc.first_texture_unit, 0,
         (double)lightprobe__get(gl, LIGHTPROBE__GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS) - 1,
         LIGHTPROBE_ERROR_SETTINGS},
        {"first_buffer_binding", (double)gl->desc.first_buffer_binding, 0,
         (double)lightprobe__get(gl, LIGHTPROBE__GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS) -
             (double)LIGHTPROBE__BINDINGS,
         LIGHTPROBE_ERROR_SETTINGS}};
    return lightprobe__check_ranges(gl->desc.log, gl->desc.user, ranges, 2);
}

lightprobe_result lightprobe_gl_create(lightprobe_gl **gl, const lightprobe_gl_desc *desc)
{
    lightprobe_gl start;
    memset(&start, 0, sizeof start);
    if (desc) start.desc = *desc;
    if (!gl || !start.desc.load)
        return lightprobe__report(&start, LIGHTPROBE_ERROR_NULL, "desc.load or gl is null");
    lightprobe_result r = lightprobe__check_desc(&start);
    if (!r) r = lightprobe__load(&start);
    if (r) return r;
    lightprobe_gl *g = (lightprobe_gl *)LIGHTPROBE_MALLOC(sizeof *g);
    if (!g) return lightprobe__report(&start, LIGHTPROBE_ERROR_MEMORY, "no memory");
    *g = start;
    lightprobe__drop_errors(g, "lightprobe_gl_create");
    lightprobe__layout(&g->work, NULL, g->desc.side, g->desc.max_lights);
    // A split takes three loops over the leaves of a cluster, all of them at worst.
    g->splits = LIGHTPROBE__MAX_ROUNDS / (3 * g->work.max_leaves + 100);
    r = lightprobe__check_units(g);
    if (!r) r = lightprobe__build_programs(g);
    const int generic = lightprobe__get(g, LIGHTPROBE__GL_SHADER_STORAGE_BUFFER_BINDING);
    if (!r) r = lightprobe__create_storage(g);
    lightprobe__bind_buffer_again(g, generic);
    if (r) {
        lightprobe_gl_destroy(g);
        return r;
    }
    *gl = g;
    return LIGHTPROBE_OK;
}

void lightprobe_gl_destroy(lightprobe_gl *gl)
{
    if (!gl) return;
    const lightprobe__gl_functions *f = &gl->f;
    for (int i = 0; i < LIGHTPROBE__SLOTS; i++)
        if (gl->fence[i]) f->DeleteSync(gl->fence[i]);
    for (int i = 0; i < LIGHTPROBE__BUFFERS; i++) lightprobe__delete_buffer(gl, gl->buffer[i]);
    f->DeleteSamplers(1, &gl->sampler); // GL passes over names that are 0
    for (int i = 0; i < LIGHTPROBE__PROGRAMS; i++) f->DeleteProgram(gl->program[i]);
    LIGHTPROBE_FREE(gl);
}

// ---- State that is put back ---- >>state

// What our own dispatches displace.
typedef struct lightprobe__gl_bindings {
    int program, active, texture, sampler, generic, copied, buffer[LIGHTPROBE__BINDINGS];
    int64_t start[LIGHTPROBE__BINDINGS], size[LIGHTPROBE__BINDINGS];
} lightprobe__gl_bindings;

static void lightprobe__save_bindings(const lightprobe_gl *gl, lightprobe__gl_bindings *b)
{
    const lightprobe__gl_functions *f = &gl->f;
    memset(b, 0, sizeof *b); // a lost context writes nothing
    b->program = lightprobe__get(gl, LIGHTPROBE__GL_CURRENT_PROGRAM);
    b->active = lightprobe__get(gl, LIGHTPROBE__GL_ACTIVE_TEXTURE);
    f->ActiveTexture(LIGHTPROBE__GL_TEXTURE0 + (unsigned)gl->desc.first_texture_unit);
    b->texture = lightprobe__get(gl, LIGHTPROBE__GL_TEXTURE_BINDING_CUBE_MAP);
    b->sampler = lightprobe__get(gl, LIGHTPROBE__GL_SAMPLER_BINDING);
    b->generic = lightprobe__get(gl, LIGHTPROBE__GL_SHADER_STORAGE_BUFFER_BINDING);
    b->copied = lightprobe__get(gl, LIGHTPROBE__GL_COPY_WRITE_BUFFER); // asked by the target's name
    for (int i = 0; i < LIGHTPROBE__BINDINGS; i++) {
        const unsigned at = (unsigned)(gl->desc.first_buffer_binding + i);
        f->GetIntegeri_v(LIGHTPROBE__GL_SHADER_STORAGE_BUFFER_BINDING, at, &b->buffer[i]);
        f->GetInteger64i_v(LIGHTPROBE__GL_SHADER_STORAGE_BUFFER_START, at, &b->start[i]);
        f->GetInteger64i_v(LIGHTPROBE__GL_SHADER_STORAGE_BUFFER_SIZE, at, &b->size[i]);
    }
}

static void lightprobe__restore_bindings(const lightprobe_gl *gl, const lightprobe__gl_bindings *b)
{
    const lightprobe__gl_functions *f = &gl->f;
    for (int i = 0; i < LIGHTPROBE__BINDINGS; i++) {
        const unsigned at = (unsigned)(gl->desc.first_buffer_binding + i);
        const unsigned buffer = lightprobe__living(b->buffer[i], f->IsBuffer);
        if (buffer && b->size[i] > 0)
            f->BindBufferRange(LIGHTPROBE__GL_SHADER_STORAGE_BUFFER, at, buffer,
                               (ptrdiff_t)b->start[i], (ptrdiff_t)b->size[i]);
        else
            f->BindBufferBase(LIGHTPROBE__GL_SHADER_STORAGE_BUFFER, at, buffer);
    }
    lightprobe__bind_buffer_again(gl, b->generic);
    f->BindBuffer(LIGHTPROBE__GL_COPY_WRITE_BUFFER, lightprobe__living(b->copied, f->IsBuffer));
    f->BindTexture(LIGHTPROBE__GL_TEXTURE_CUBE_MAP, lightprobe__living(b->texture, f->IsTexture));
    f->BindSampler((unsigned)gl->desc.first_texture_unit,
                   lightprobe__living(b->sampler, f->IsSampler));
    f->ActiveTexture((lightprobe__glenum)b->active);
    lightprobe__use_again(gl, b->program);
}

// Of a face of the texture that is bound.
static int lightprobe__ask_face(const lightprobe_gl *gl, int face, int level,
                                lightprobe__glenum what)
{
    int value = 0; // a lost context writes nothing
    gl->f.GetTexLevelParameteriv(
        (lightprobe__glenum)(LIGHTPROBE__GL_TEXTURE_CUBE_MAP_POSITIVE_X + face), level, what,
        &value);
    return value;
}

// Side of a level; 0 if a face is missing or unlike that of the base level: all would be black.
static int lightprobe__level_width(const lightprobe_gl *gl, int level, int base, int immutable)
{
    const int width = lightprobe__ask_face(gl, 0, level, LIGHTPROBE__GL_TEXTURE_WIDTH);
    if (immutable || width <= 0) return width;
    const int format = lightprobe__ask_face(gl, 0, base, LIGHTPROBE__GL_TEXTURE_INTERNAL_FORMAT);
    for (int face = 0; face < 6; face++) {
        if (lightprobe__ask_face(gl, face, level, LIGHTPROBE__GL_TEXTURE_WIDTH) != width ||
            lightprobe__ask_face(gl, face, level, LIGHTPROBE__GL_TEXTURE_INTERNAL_FORMAT) != format)
            return 0;
    }
    return width;
}

// Binds the texture to the active unit and finds the mip level of our side, counted from its base
// level. Not all contexts know a texture's target: whether it binds tells.
static lightprobe_result lightprobe__bind_texture(const lightprobe_gl *gl, unsigned texture,
                                                  int *mip)
{
    const lightprobe__glenum cube = LIGHTPROBE__GL_TEXTURE_CUBE_MAP;
    const lightprobe__gl_functions *f = &gl->f;
    int base = 0, last = 0, levels = 0, viewed = 0;
    if (!texture || !f->IsTexture(texture))
        return lightprobe__report(gl, LIGHTPROBE_ERROR_TEXTURE, "the cube-map texture is none");
    f->BindTexture(cube, texture);
    if (lightprobe__get(gl, LIGHTPROBE__GL_TEXTURE_BINDING_CUBE_MAP) != (int)texture) {
        lightprobe__take_error(gl);
        return lightprobe__report(gl, LIGHTPROBE_ERROR_TEXTURE, "the texture is no cube map");
    }
    f->GetTexParameteriv(cube, LIGHTPROBE__GL_TEXTURE_BASE_LEVEL, &base);
    f->GetTexParameteriv(cube, LIGHTPROBE__GL_TEXTURE_MAX_LEVEL, &last);
    f->GetTexParameteriv(cube, LIGHTPROBE__GL_TEXTURE_IMMUTABLE_LEVELS, &levels);
    if (levels > 0) f->GetTexParameteriv(cube, LIGHTPROBE__GL_TEXTURE_VIEW_NUM_LEVELS, &viewed);
    if (viewed > 0 && viewed < levels) levels = viewed; // of a view; those above are the texture's
    if (levels > 0 && last >= levels) last = levels - 1;
    *mip = -1;
    // Where another level than the first is read, all there may be must be there.
    for (int level = base, side = 0; level >= 0 && level < LIGHTPROBE__LEVELS; level++) {
        const int width = lightprobe__level_width(gl, level, base, levels > 0);
        if (width == gl->desc.side) *mip = level - base;
        if (level > base && width != side) *mip = -1;
        if (width <= 1 || *mip == 0 || level >= last || (level > base && width != side)) break;
        side = width / 2;
    }
    if (*mip < 0 || (last < base && levels <= 0)) {
        return lightprobe__report(gl, LIGHTPROBE_ERROR_TEXTURE,
                                  "the texture has no level of side %d among its levels %d to %d, "
                                  "or lacks one of these or some of its faces",
                                  gl->desc.side, base, last);
    }
    const int type = lightprobe__ask_face(gl, 0, base, LIGHTPROBE__GL_TEXTURE_RED_TYPE);
    if (type != LIGHTPROBE__GL_INT && type != LIGHTPROBE__GL_UNSIGNED_INT &&
        lightprobe__ask_face(gl, 0, base, LIGHTPROBE__GL_TEXTURE_DEPTH_SIZE) <= 0 &&
        lightprobe__ask_face(gl, 0, base, LIGHTPROBE__GL_TEXTURE_STENCIL_SIZE) <= 0) {
        return LIGHTPROBE_OK;
    }
    return lightprobe__report(gl, LIGHTPROBE_ERROR_TEXTURE,
                              "the texture holds integers or depth, not colours");
}

// stage: the uniform of that name.
static void lightprobe__dispatch(const lightprobe_gl *gl, int which, int stage, unsigned side,
                                 unsigned faces)
{
    gl->f.ProgramUniform1i(gl->program[which], 0, stage);
    gl->f.UseProgram(gl->program[which]);
    gl->f.DispatchCompute(side, side, faces);
    // In brackets: windows.h may have a macro of that name.
    (gl->f.MemoryBarrier)(LIGHTPROBE__GL_STORAGE_BARRIER | LIGHTPROBE__GL_UPDATE_BARRIER);
}

// ---- Updates and what they leave ---- >>updates

static ptrdiff_t lightprobe__slot(const lightprobe_gl *gl, unsigned number)
{
    return (ptrdiff_t)(number % LIGHTPROBE__SLOTS * gl->slot_bytes);
}

static void lightprobe__bind(const lightprobe_gl *gl, int mip)
{
    const lightprobe__gl_functions *f = &gl->f;
    const unsigned first = (unsigned)gl->desc.first_buffer_binding;
    const unsigned ring = gl->buffer[LIGHTPROBE__LIGHTS];
    const ptrdiff_t bytes = (ptrdiff_t)gl->slot_bytes;
    f->BindSampler((unsigned)gl->desc.first_texture_unit, gl->sampler);
    // Without mipmaps where they are not needed: they may be incomplete.
    f->SamplerParameteri(gl->sampler, LIGHTPROBE__GL_TEXTURE_MIN_FILTER,
                         mip ? LIGHTPROBE__GL_NEAREST_MIPMAP_NEAREST : LIGHTPROBE__GL_NEAREST);
    // In compatibility contexts the unit may have a bias of its own.
    f->SamplerParameteri(gl->sampler, LIGHTPROBE__GL_TEXTURE_MIN_LOD, mip);
    f->SamplerParameteri(gl->sampler, LIGHTPROBE__GL_TEXTURE_MAX_LOD, mip);
    f->BindBufferRange(LIGHTPROBE__GL_SHADER_STORAGE_BUFFER, first, ring,
                       lightprobe__slot(gl, gl->updates - 1), bytes);
    for (unsigned i = 0, at = 0; i < LIGHTPROBE__PARTS; at += (unsigned)gl->part_bytes[i++])
        f->BindBufferRange(LIGHTPROBE__GL_SHADER_STORAGE_BUFFER, first + 1 + i,
                           gl->buffer[LIGHTPROBE__WORK], (ptrdiff_t)at,
                           (ptrdiff_t)gl->part_bytes[i]);
    f->BindBufferRange(LIGHTPROBE__GL_SHADER_STORAGE_BUFFER, first + 1 + LIGHTPROBE__PARTS, ring,
                       lightprobe__slot(gl, gl->updates), bytes);
}

static void lightprobe__divide_all(const lightprobe_gl *gl)
{
    for (int part = 0; part == 0 || part * gl->splits < gl->desc.max_lights - 1; part++)
        lightprobe__dispatch(gl, LIGHTPROBE__DIVIDE, part, 1, 1);
}

// The steps of lightprobe__best, and sums over texels before them.
static void lightprobe__run(const lightprobe_gl *gl, int mip)
{
    lightprobe__dispatch(gl, LIGHTPROBE__TILES, mip, (unsigned)(gl->work.tiles + 7) / 8, 6);
    lightprobe__dispatch(gl, LIGHTPROBE__DIVIDE_FACES, mip, 1, 1);
    lightprobe__dispatch(gl, LIGHTPROBE__GATHER,
                         gl->again ? LIGHTPROBE__START_AGAIN : LIGHTPROBE__START, 1, 1);
    lightprobe__divide_all(gl);
    lightprobe__dispatch(gl, LIGHTPROBE__GATHER, LIGHTPROBE__FIND_NEAR, 1, 1);
    if (gl->again) lightprobe__dispatch(gl, LIGHTPROBE__REASSIGN, 0, 1, 1);
    for (int round = 0; round < LIGHTPROBE_ROUNDS; round++)
        lightprobe__dispatch(gl, LIGHTPROBE__GATHER, LIGHTPROBE__RELAX + round, 1, 1);
    if (gl->desc.tolerance > 0) // it may not be met any more
        lightprobe__divide_all(gl);
    else
        lightprobe__dispatch(gl, LIGHTPROBE__DIVIDE, LIGHTPROBE__MEASURE, 1, 1);
    lightprobe__dispatch(gl, LIGHTPROBE__SETTLE, 0, 1, 1);
    lightprobe__dispatch(gl, LIGHTPROBE__WRITE, 0, 1, 1);
}

lightprobe_result lightprobe_gl_update(lightprobe_gl *gl, unsigned cube_texture)
{
    if (!gl) return LIGHTPROBE_ERROR_NULL;
    const lightprobe__gl_functions *f = &gl->f;
    if (lightprobe__get(gl, LIGHTPROBE__GL_TRANSFORM_FEEDBACK_ACTIVE) &&
        !lightprobe__get(gl, LIGHTPROBE__GL_TRANSFORM_FEEDBACK_PAUSED)) {
        return lightprobe__report(
            gl, LIGHTPROBE_ERROR_ORDER,
            "transform feedback must be paused or ended before lightprobe_gl_update");
    }
    lightprobe__gl_bindings saved;
    lightprobe__save_bindings(gl, &saved);
    int mip = 0;
    const lightprobe_result r = lightprobe__bind_texture(gl, cube_texture, &mip);
    if (r) {
        lightprobe__restore_bindings(gl, &saved);
        return r;
    }
    gl->updates++;
    lightprobe__bind(gl, mip);
    lightprobe__run(gl, mip);
    gl->again = 1;
    const ptrdiff_t at = lightprobe__slot(gl, gl->updates);
    void **fence = gl->fence + gl->updates % LIGHTPROBE__SLOTS;
    f->BindBuffer(LIGHTPROBE__GL_SHADER_STORAGE_BUFFER, gl->buffer[LIGHTPROBE__LIGHTS]);
    f->BindBuffer(LIGHTPROBE__GL_COPY_WRITE_BUFFER, gl->buffer[LIGHTPROBE__MAPPED]);
    f->CopyBufferSubData(LIGHTPROBE__GL_SHADER_STORAGE_BUFFER, LIGHTPROBE__GL_COPY_WRITE_BUFFER, at,
                         at, (ptrdiff_t)gl->slot_bytes);
    lightprobe__restore_bindings(gl, &saved);
    if (*fence) f->DeleteSync(*fence);
    *fence = f->FenceSync(LIGHTPROBE__GL_SYNC_COMPLETE, 0);
    if (*fence) f->ObjectPtrLabel(*fence, -1, "lightprobe lights are written");
    f->Flush(); // a context that shares our objects could wait for it forever
    return LIGHTPROBE_OK;
}

void lightprobe_gl_restart(lightprobe_gl *gl)
{
    if (gl) gl->again = 0;
}

lightprobe_gl_range lightprobe_gl_lights(const lightprobe_gl *gl, int as_read)
{
    lightprobe_gl_range range = {0, 0, 0};
    if (!gl) return range;
    range.buffer = gl->buffer[LIGHTPROBE__LIGHTS];
    range.offset = lightprobe__slot(gl, as_read && gl->given ? gl->given : gl->updates);
    range.bytes = (ptrdiff_t)gl->slot_bytes;
    return range;
}

// Number of the newest update that has finished; 0: none.
static unsigned lightprobe__newest(const lightprobe_gl *gl, int wait)
{
    for (unsigned age = 0; age < LIGHTPROBE__SLOTS && age < gl->updates; age++) {
        void *fence = gl->fence[(gl->updates - age) % LIGHTPROBE__SLOTS];
        lightprobe__glenum state = 0;
        do {
            if (fence)
                state =
                    gl->f.ClientWaitSync(fence, LIGHTPROBE__GL_SYNC_FLUSH, wait ? 1000000000u : 0);
        } while (wait && state == LIGHTPROBE__GL_TIMEOUT_EXPIRED);
        if (state == LIGHTPROBE__GL_ALREADY_SIGNALED || state == LIGHTPROBE__GL_CONDITION_SATISFIED)
            return gl->updates - age;
        if (wait) break;
    }
    return 0;
}

// Where a light's members are for the CPU and for the GPU; the state is the last.
// clang-format off
#define LIGHTPROBE__MEMBER(m) \
    {offsetof(lightprobe_light, m), offsetof(lightprobe__gl_light, m), sizeof ((lightprobe_light *)0)->m}
// clang-format on
static const struct {
    size_t cpu, gpu, bytes;
} lightprobe__members[] = {
    LIGHTPROBE__MEMBER(direction),  LIGHTPROBE__MEMBER(cos_alpha),   LIGHTPROBE__MEMBER(axis_u),
    LIGHTPROBE__MEMBER(tan_half_u), LIGHTPROBE__MEMBER(axis_v),      LIGHTPROBE__MEMBER(tan_half_v),
    LIGHTPROBE__MEMBER(irradiance), LIGHTPROBE__MEMBER(solid_angle), LIGHTPROBE__MEMBER(id),
    LIGHTPROBE__MEMBER(distance),   LIGHTPROBE__MEMBER(slope_u),     LIGHTPROBE__MEMBER(slope_v),
    LIGHTPROBE__MEMBER(state)};
enum { LIGHTPROBE__MEMBERS = sizeof lightprobe__members / sizeof *lightprobe__members };

lightprobe_result lightprobe_gl_read(lightprobe_gl *gl, int wait, lightprobe_light *lights,
                                     int *light_count, lightprobe_stats *stats)
{
    if (!gl || !lights || !light_count) return LIGHTPROBE_ERROR_NULL;
    const unsigned number = lightprobe__newest(gl, wait);
    if (!number) return LIGHTPROBE_ERROR_NOT_READY;
    const char *slot = gl->mapped + lightprobe__slot(gl, number);
    lightprobe__gl_header h;
    memcpy(&h, slot, sizeof h);
    gl->given = number;
    // The array's room, whatever a driver has put there.
    h.count = h.count < 0 ? 0 : h.count > gl->desc.max_lights ? gl->desc.max_lights : h.count;
    for (int i = 0; i < h.count; i++) {
        const char *from = slot + sizeof h + (size_t)i * sizeof(lightprobe__gl_light);
        for (int m = 0; m < LIGHTPROBE__MEMBERS; m++)
            memcpy((char *)(lights + i) + lightprobe__members[m].cpu,
                   from + lightprobe__members[m].gpu, lightprobe__members[m].bytes);
    }
    *light_count = h.count;
    if (!stats) return LIGHTPROBE_OK;
    memcpy(stats->total, h.total, sizeof stats->total);
    memcpy(stats->residual, h.residual, sizeof stats->residual);
    for (int i = 0; i < 9; i++)
        memcpy(stats->residual_sh[i], h.residual_sh[i], sizeof stats->residual_sh[i]);
    stats->error = h.error;
    stats->lights = h.count;
    stats->repaired_texels = h.repaired_texels;
    return LIGHTPROBE_OK;
}

lightprobe_result lightprobe_uniforms(const lightprobe_light *lights, int count,
                                      const lightprobe_stats *stats, void *block, size_t bytes)
{
    const size_t head = sizeof(lightprobe__gl_header), each = 80; // without the state
    if (!block || !stats || (!lights && count > 0)) return LIGHTPROBE_ERROR_NULL;
    if (count < 0 || bytes < head || (bytes - head) / each < (size_t)count)
        return LIGHTPROBE_ERROR_LIGHTS;
    lightprobe__gl_header h = {count, stats->repaired_texels, stats->error, 0, {0}, {0}, {{0}}};
    memcpy(h.total, stats->total, 12);
    memcpy(h.residual, stats->residual, 12);
    for (int i = 0; i < 9; i++) memcpy(h.residual_sh[i], stats->residual_sh[i], 12);
    memcpy(block, &h, head);
    for (int i = 0; i < count; i++) {
        char *to = (char *)block + head + (size_t)i * each;
        for (int m = 0; m < LIGHTPROBE__MEMBERS - 1; m++)
            memcpy(to + lightprobe__members[m].gpu,
                   (const char *)(lights + i) + lightprobe__members[m].cpu,
                   lightprobe__members[m].bytes);
    }
    return LIGHTPROBE_OK;
}

#endif // LIGHTPROBE_NO_GL

// ================================================================================================
// References, licence >>licence
//
//   Kneiphof (supervised by Krumpen): Real-Time Image-Based Lighting of Dynamic Scenes with Moment
//       Soft Shadow Mapping, CESCG 2017. "The paper" above; equation numbers are its own. Mended:
//       Eq. 8 (exponent -3/2), 4.1.2 (the variance is d^2/3), Eq. 18 (only above the horizon).
//   Debevec: A Median Cut Algorithm for Light Probe Sampling, SIGGRAPH 2005 posters.
//   van Oosterom, Strackee: The Solid Angle of a Plane Triangle, IEEE Trans. Biomed. Eng. 30, 1983.
//   Szekely, Rizzo: Energy Statistics, J. Stat. Plan. Inference 143, 2013.
//   Lloyd: Least Squares Quantization in PCM, IEEE Trans. Inf. Theory 28, 1982.
//   Hastings: Approximations for Digital Computers, Princeton 1955, sheet 13.
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

const char *lightprobe_glsl_math(void)
{
    return LIGHTPROBE__MATH_BEGIN
    // [glsl text begin] made by "make glsl", do not edit
    "// The angle of the point (x, y) with y >= 0 to the x axis, in [0, pi], to 3e-7. Written out\n"
    "// (Hastings' polynomial) since GLSL allows its own atan 4096 units in the last place.\n"
    "LIGHTPROBE_SHARED float lightprobe_angle(float y, float x)\n"
    "{\n"
    "    float ax = fabsf(x);\n"
    "    float most = ax < y ? y : ax;\n"
    "    float t = (ax < y ? ax : y) / (most + 1e-37f);\n"
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
    "    return e > 0.0f ? e : 0.0f; // at most 0.65\n"
    "}\n"
    // [glsl text end]
    // [glsl text begin harmonics] made by "make glsl", do not edit
    "// Function number i of nine that sum up to irradiance: the real spherical harmonics of order 0, 1\n"
    "// and 2 at a unit vector, without their constants.\n"
    "LIGHTPROBE_SHARED float lightprobe_harmonic(int i, float x, float y, float z)\n"
    "{\n"
    "    if (i < 4) return i == 0 ? 1.0f : i == 1 ? y : i == 2 ? z : x;\n"
    "    if (i == 6) return 3.0f * z * z - 1.0f;\n"
    "    return i == 4 ? x * y : i == 5 ? y * z : i == 7 ? z * x : x * x - y * y;\n"
    "}\n"
    "\n"
    "// What a disc in direction (x, y, z) adds to number i per unit of its irradiance. The clamped\n"
    "// cosine is 1/4 + cos/2 + 5/32 (3 cos^2 - 1) to order 2; the disc weakens order 1 and 2.\n"
    "LIGHTPROBE_SHARED float lightprobe_harmonic_weight(int i, float cos_alpha, float x, float y,\n"
    "                                                   float z)\n"
    "{\n"
    "    float half_sum = 0.5f * (1.0f + cos_alpha);\n"
    "    float weight = i == 6 ? 0.078125f : i == 8 ? 0.234375f : 0.9375f;\n"
    "    if (i == 0) return 0.25f;\n"
    "    weight = i < 4 ? 0.5f * half_sum : weight * cos_alpha * half_sum;\n"
    "    return weight * lightprobe_harmonic(i, x, y, z);\n"
    "}\n"
    // [glsl text end]
    LIGHTPROBE__NO_C_NAMES;
}

#ifndef LIGHTPROBE_NO_GL
const char *lightprobe_glsl_lights(void)
{
    return LIGHTPROBE__LIGHTS_BEGIN
    // [glsl text begin places] made by "make glsl", do not edit
    "// Vector irradiance of a disc over pi * radiance * radius2, seen from height below its plane and\n"
    "// aside from its axis: along the axis, and towards it per distance from it; its length.\n"
    "struct lightprobe_disc {\n"
    "    float facing, inward, size;\n"
    "};\n"
    "\n"
    "LIGHTPROBE_SHARED lightprobe_disc lightprobe_disc_from(float height, float aside2, float radius2)\n"
    "{\n"
    "    lightprobe_disc o;\n"
    "    float beyond = height * height + aside2 - radius2;\n"
    "    float root = sqrtf(beyond * beyond + 4.0f * radius2 * height * height) + 1e-12f;\n"
    "    o.facing = 2.0f * height * height / (root * (root + beyond));\n"
    "    if (beyond <= 0.0f) o.facing = 0.5f * (1.0f - beyond / root) / (radius2 + 1e-12f);\n"
    "    o.inward = 2.0f * height / (root * (root + beyond + 2.0f * radius2));\n"
    "    o.size = sqrtf(o.facing * o.facing + o.inward * o.inward * aside2);\n"
    "    return o;\n"
    "}\n"
    "\n"
    "// What counts of a wide light just before its plane, or who crosses that would see it at once.\n"
    "LIGHTPROBE_SHARED float lightprobe_fade_in(float height, float radius2)\n"
    "{\n"
    "    float whole = 0.1f * sqrtf(radius2 < 1.0f ? radius2 : 1.0f);\n"
    "    return height < whole ? (height > 0.0f ? height / whole : 0.0f) : 1.0f;\n"
    "}\n"
    "\n"
    "lightprobe_light lightprobe_light_at(lightprobe_light light, float x, float y, float z)\n"
    "{\n"
    "    lightprobe_light seen = light;\n"
    "    float c = light.cos_alpha, scale = light.distance > 1e-30f ? 1.0f / light.distance : 0.0f;\n"
    "    if (!(scale > 0.0f) || !(c > 1e-3f)) return seen;\n"
    "    // In units of the distance: height over the disc, squared distance from its axis, radius2.\n"
    "    float u = light.slope_u > -4.0f ? (light.slope_u < 4.0f ? light.slope_u : 4.0f) : -4.0f;\n"
    "    float v = light.slope_v > -4.0f ? (light.slope_v < 4.0f ? light.slope_v : 4.0f) : -4.0f;\n"
    "    float tilt2 = u * u + v * v, steep = tilt2 / (1.0f + sqrtf(1.0f + tilt2)), height = 0.0f;\n"
    "    float first = (1.0f - c) * (1.0f + c), c2 = c * c, flatter = 1.0f, aside2 = 0.0f;\n"
    "    if (steep * first > 0.875f * c2) { // some discs are too wide to be as steep\n"
    "        steep = 0.875f * c2 / first;\n"
    "        flatter = sqrtf(steep * (2.0f + steep) / tilt2);\n"
    "        tilt2 = steep * (2.0f + steep);\n"
    "    }\n"
    "    // The one disc in this plane whose vector irradiance at the probe is the light's: turned away\n"
    "    // larger, and further, since its nearer half looks larger than the other (docs/lightprobe.md).\n"
    "    float slant = 1.0f + steep, gap = c2 - steep * first;\n"
    "    float radius2 = first * (c2 + steep) / (gap * gap);\n"
    "    float off = first / (slant * gap), up = 1.0f + off * tilt2;\n"
    "    float axis[3], aside[3];\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        float tilt = flatter * (u * light.axis_u[i] + v * light.axis_v[i]);\n"
    "        axis[i] = (light.direction[i] - tilt) / slant;\n"
    "        aside[i] = up * light.direction[i] + off * tilt - scale * (i == 0 ? x : i == 1 ? y : z);\n"
    "        height += aside[i] * axis[i];\n"
    "    }\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        aside[i] -= height * axis[i];\n"
    "        aside2 += aside[i] * aside[i];\n"
    "    }\n"
    "    lightprobe_disc o = lightprobe_disc_from(height, aside2, radius2);\n"
    "    float sine2 = o.size * radius2;\n"
    "    float bright = 0.0f; // behind it, or too far\n"
    "    if (height > 0.0f && o.size > 1e-12f) bright = o.size * lightprobe_fade_in(height, radius2);\n"
    "    seen.cos_alpha = sine2 < 1.0f ? sqrtf(1.0f - sine2) : 0.0f; // a disc with this irradiance\n"
    "    float part = bright * (c2 + steep) / (gap * gap) * (1.0f + c) / (1.0f + seen.cos_alpha);\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        if (bright > 0.0f) seen.direction[i] = (o.facing * axis[i] + o.inward * aside[i]) / o.size;\n"
    "        seen.irradiance[i] = part * light.irradiance[i];\n"
    "    }\n"
    "    return seen;\n"
    "}\n"
    "\n"
    "lightprobe_light lightprobe_sphere_at(lightprobe_light light, float x, float y, float z)\n"
    "{\n"
    "    lightprobe_light seen = light;\n"
    "    float c = light.cos_alpha, radius2 = (1.0f - c) * (1.0f + c);\n"
    "    float scale = light.distance > 1e-30f ? 1.0f / light.distance : 0.0f;\n"
    "    if (!(scale > 0.0f) || !(c > 1e-3f)) return seen;\n"
    "    // The probe sees its surface, of a small one on average 2/3 of the radius before its centre. In\n"
    "    // units of the centre's distance: the way there, its square, and the radius' square.\n"
    "    scale *= 1.0f - 0.6666667f * sqrtf(radius2);\n"
    "    float a = light.direction[0] - scale * x, b = light.direction[1] - scale * y;\n"
    "    float d = light.direction[2] - scale * z, away2 = a * a + b * b + d * d + 1e-12f;\n"
    "    float away = away2 < 1e30f ? sqrtf(away2) : 0.0f, outside = radius2 < away2 ? away2 : radius2;\n"
    "    seen.cos_alpha = sqrtf(1.0f - radius2 / outside);\n"
    "    // Solid angle over solid angle; of a point the inverse square.\n"
    "    float part = (1.0f + c) / ((1.0f + seen.cos_alpha) * outside);\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        float way = i == 0 ? a : i == 1 ? b : d;\n"
    "        if (away > 0.0f) seen.direction[i] = way / away;\n"
    "        seen.irradiance[i] = away > 0.0f ? part * light.irradiance[i] : 0.0f;\n"
    "    }\n"
    "    return seen;\n"
    "}\n"
    // [glsl text end]
    LIGHTPROBE__LIGHTS_END;
}

const char *lightprobe_glsl_specular(void)
{
    return LIGHTPROBE__SPECULAR_BEGIN
    // [glsl text begin specular] made by "make glsl", do not edit
    "LIGHTPROBE_SHARED float lightprobe_between(float x, float low, float high)\n"
    "{\n"
    "    return x > low ? (x < high ? x : high) : low;\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED float lightprobe_cubic(float x, float a, float b, float c, float d)\n"
    "{\n"
    "    return ((d * x + c) * x + b) * x + a;\n"
    "}\n"
    "\n"
    "// Schlick's term of the half vector for the cosine between light and viewer.\n"
    "LIGHTPROBE_SHARED float lightprobe_fresnel(float cosine)\n"
    "{\n"
    "    float t = 1.0f - sqrtf(0.5f + 0.5f * lightprobe_between(cosine, -1.0f, 1.0f));\n"
    "    return t * t * t * t * t;\n"
    "}\n"
    "\n"
    "// The lobe of alpha a for the cosine m to the viewer. Directions of light, x away from the viewer\n"
    "// and z along the normal, become those of a cosine lobe by x' = along x - shear z, y' = across y,\n"
    "// z' = width z: the horizon stays where it is, so nothing is reflected from below it. All numbers\n"
    "// are fitted and checked by tests/proofs/specular.c.\n"
    "LIGHTPROBE_SHARED lightprobe_lobe lightprobe_fitted_lobe(lightprobe_lobe lobe, float a, float m)\n"
    "{\n"
    "    lightprobe_lobe l = lobe;\n"
    "    float r = m > 0.0349f ? m : 0.0349f; // fitted up to 88 degrees, from there on polynomials swing\n"
    "    float sine = sqrtf((1.0f - m) * (1.0f + m));\n"
    "    r = r / (r + a);\n"
    "    float along = lightprobe_cubic(a, lightprobe_cubic(r, -0.53912f, 1.8974f, -2.5446f, 1.2342f),\n"
    "                                   lightprobe_cubic(r, 9.5959f, -18.368f, 35.922f, -24.477f),\n"
    "                                   lightprobe_cubic(r, -13.108f, 26.053f, -23.067f, -23.278f),\n"
    "                                   lightprobe_cubic(r, 5.3654f, -10.166f, 0.6215f, 22.296f));\n"
    "    float shear = lightprobe_cubic(a, lightprobe_cubic(r, 1.0225f, 0.56181f, -2.6402f, 1.1447f),\n"
    "                                   lightprobe_cubic(r, 3.5093f, -9.2535f, 29.787f, -28.027f),\n"
    "                                   lightprobe_cubic(r, -10.008f, 11.951f, -31.701f, 5.4128f),\n"
    "                                   lightprobe_cubic(r, 5.5156f, -3.3794f, -2.1185f, 28.337f));\n"
    "    float across = lightprobe_cubic(a, lightprobe_cubic(r, 1.1531f, 14.567f, -37.403f, 22.137f),\n"
    "                                    lightprobe_cubic(r, -4.9333f, -55.706f, 140.44f, -81.959f),\n"
    "                                    lightprobe_cubic(r, 7.7695f, 76.784f, -189.68f, 115.76f),\n"
    "                                    lightprobe_cubic(r, -3.7285f, -34.908f, 90.516f, -63.043f));\n"
    "    float whole = lightprobe_cubic(a, lightprobe_cubic(r, 1.1328f, -1.4348f, 2.4262f, -1.1276f),\n"
    "                                   lightprobe_cubic(r, -0.70429f, 5.782f, -11.612f, 6.8001f),\n"
    "                                   lightprobe_cubic(r, 0.92783f, -9.0341f, 9.2648f, -0.16572f),\n"
    "                                   lightprobe_cubic(r, -0.38267f, 1.986f, 4.6633f, -9.5373f));\n"
    "    float schlick = lightprobe_cubic(a, lightprobe_cubic(r, 0.098366f, 2.6263f, -3.1047f, 1.392f),\n"
    "                                     lightprobe_cubic(r, -0.33385f, -1.3897f, -26.167f, 31.217f),\n"
    "                                     lightprobe_cubic(r, 0.60429f, -4.8188f, 49.946f, -17.16f),\n"
    "                                     lightprobe_cubic(r, -0.31576f, 3.1057f, -16.608f, -24.181f));\n"
    "    l.along = m * m + a * along;\n"
    "    l.across = 1.0f + a * across;\n"
    "    l.shear = sine * (m + a * shear);\n"
    "    l.width = 2.0f * a;\n"
    "    l.whole = lightprobe_between(whole, 0.0f, 1.0f);\n"
    "    float x = l.shear / l.along, dim = (1.0f - m) * (1.0f - m);\n"
    "    float middle = lightprobe_fresnel((m - sine * x) / sqrtf(1.0f + x * x));\n"
    "    l.fresnel = dim * dim * (1.0f - m) * schlick / (l.whole + 1e-3f) - middle;\n"
    "    return l;\n"
    "}\n"
    "\n"
    "lightprobe_lobe lightprobe_specular_lobe(const lightprobe_vec3 normal, const lightprobe_vec3 view,\n"
    "                                         float alpha, const lightprobe_vec3 f0)\n"
    "{\n"
    "    lightprobe_lobe lobe;\n"
    "    float cosine = 0.0f, sine2 = 0.0f;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        lobe.normal[i] = lightprobe_between(normal[i], -1.0f, 1.0f);\n"
    "        lobe.view[i] = lightprobe_between(view[i], -1.0f, 1.0f);\n"
    "        cosine += lobe.normal[i] * lobe.view[i];\n"
    "    }\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        lobe.away[i] = cosine * lobe.normal[i] - lobe.view[i];\n"
    "        sine2 += lobe.away[i] * lobe.away[i];\n"
    "    }\n"
    "    float sine = sine2 > 1e-6f ? sqrtf(sine2) : 1e-3f;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        lobe.away[i] = lightprobe_between(lobe.away[i] / sine, -1.0f, 1.0f);\n"
    "        if (cosine < 0.0f) lobe.view[i] = -lobe.away[i]; // smooth normals turn from the viewer\n"
    "        lobe.f0[i] = lightprobe_between(f0[i], 0.0f, 1.0f);\n"
    "    }\n"
    "    return lightprobe_fitted_lobe(lobe, lightprobe_between(alpha, 0.02f, 1.0f),\n"
    "                                  lightprobe_between(cosine, 0.0f, 1.0f));\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED void lightprobe_into_lobe(lightprobe_lobe lobe,\n"
    "                                            LIGHTPROBE_INOUT lightprobe_vec3 w)\n"
    "{\n"
    "    float x = lightprobe_dot(w, lobe.away), z = lightprobe_dot(w, lobe.normal);\n"
    "    float forth = (lobe.along - lobe.across) * x - lobe.shear * z;\n"
    "    float up = (lobe.width - lobe.across) * z;\n"
    "    for (int i = 0; i < 3; i++)\n"
    "        w[i] = lobe.across * w[i] + forth * lobe.away[i] + up * lobe.normal[i];\n"
    "}\n"
    "\n"
    "// The cosine between the viewer and the direction that went into the lobe as this one.\n"
    "LIGHTPROBE_SHARED float lightprobe_to_viewer(lightprobe_lobe lobe, const lightprobe_vec3 into)\n"
    "{\n"
    "    lightprobe_vec3 d;\n"
    "    float x = lightprobe_dot(into, lobe.away), z = lightprobe_dot(into, lobe.normal);\n"
    "    float forth = (x + lobe.shear * z / lobe.width) / lobe.along - x / lobe.across;\n"
    "    float up = z / lobe.width - z / lobe.across;\n"
    "    for (int i = 0; i < 3; i++)\n"
    "        d[i] = into[i] / lobe.across + forth * lobe.away[i] + up * lobe.normal[i];\n"
    "    return lightprobe_dot(d, lobe.view) / sqrtf(lightprobe_dot(d, d) + 1e-30f);\n"
    "}\n"
    "\n"
    "// Adds Lambert's integral along the edge from p to p + e, a vector times 2 pi. The part below the\n"
    "// horizon is put straight up on it, where it is its azimuth along n. sum[3]: of whole azimuths.\n"
    "LIGHTPROBE_SHARED void lightprobe_add_edge(const lightprobe_vec3 n, const lightprobe_vec3 p,\n"
    "                                           const lightprobe_vec3 e,\n"
    "                                           LIGHTPROBE_INOUT lightprobe_vec4 sum)\n"
    "{\n"
    "    lightprobe_vec3 q, plane, flat_p, flat_q;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        int j = (i + 1) % 3, k = (i + 2) % 3;\n"
    "        q[i] = p[i] + e[i];\n"
    "        plane[i] = p[j] * e[k] - p[k] * e[j]; // by q a small light would have no digits left\n"
    "    }\n"
    "    float at_p = lightprobe_dot(p, n), at_q = lightprobe_dot(q, n), both = lightprobe_dot(p, q);\n"
    "    // Straight below n azimuths hang on few digits, which must be the same ones.\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        flat_p[i] = p[i] - at_p * n[i];\n"
    "        flat_q[i] = q[i] - at_q * n[i];\n"
    "    }\n"
    "    float side = lightprobe_dot(plane, n), size = sqrtf(lightprobe_dot(plane, plane));\n"
    "    float turn = side < 0.0f ? -1.0f : 1.0f, flat_both = lightprobe_dot(flat_p, flat_q);\n"
    "    float azimuth = turn * lightprobe_angle(fabsf(side), flat_both);\n"
    "    float high = at_p > at_q ? at_p : at_q, low = at_p > at_q ? at_q : at_p;\n"
    "    float high2 = at_p > at_q ? lightprobe_dot(p, p) : lightprobe_dot(q, q);\n"
    "    float low2 = at_p > at_q ? lightprobe_dot(flat_q, flat_q) : lightprobe_dot(flat_p, flat_p);\n"
    "    float below = azimuth, above = 0.0f;\n"
    "    if (high > 0.0f) { // the edge meets the horizon at high * (lower end) - low * (higher end)\n"
    "        low = low < 0.0f ? low : 0.0f;\n"
    "        above = lightprobe_angle(high * size, high * both - low * high2) / (size + 1e-37f);\n"
    "        below = turn * lightprobe_angle(-low * fabsf(side), high * low2 - low * flat_both);\n"
    "    }\n"
    "    for (int i = 0; i < 3; i++) sum[i] += above * plane[i] + below * n[i];\n"
    "    sum[3] += azimuth;\n"
    "}\n"
    "\n"
    "// Adds the edges from corner to corner, unless all that they enclose is below the lobe's horizon.\n"
    "LIGHTPROBE_SHARED void lightprobe_add_edges(const lightprobe_vec3 n, lightprobe_vec3 corner[4],\n"
    "                                            float c, LIGHTPROBE_INOUT lightprobe_vec4 sum)\n"
    "{\n"
    "    lightprobe_vec3 e;\n"
    "    float top = -1.0f;\n"
    "    for (int k = 0; k < 4; k++) top = lightprobe_dot(corner[k], n) < 0.0f ? top : 1.0f;\n"
    "    if (c >= 0.0f && top < 0.0f) return;\n"
    "    for (int k = 0; k < 4; k++) {\n"
    "        for (int i = 0; i < 3; i++) e[i] = corner[(k + 1) % 4][i] - corner[k][i];\n"
    "        lightprobe_add_edge(n, corner[k], e, sum);\n"
    "    }\n"
    "}\n"
    "\n"
    "// The light from (x, y, z): corners, in the lobe, of the rectangle with these sines of half-sizes\n"
    "// in the plane at c, moved along their rays from the probe into the plane of its slopes. Returns\n"
    "// what counts of it there; 0: it shines the other way.\n"
    "LIGHTPROBE_SHARED float lightprobe_corners(lightprobe_light light, lightprobe_lobe lobe, float c,\n"
    "                                           float u, float v, float x, float y, float z,\n"
    "                                           LIGHTPROBE_OUT lightprobe_vec3 corner[4])\n"
    "{\n"
    "    float scale = c > 0.0f && light.distance > 1e-30f ? 1.0f / light.distance : 0.0f, before = 1.0f;\n"
    "    float slope_u = scale > 0.0f ? lightprobe_between(light.slope_u, -4.0f, 4.0f) : 0.0f;\n"
    "    float slope_v = scale > 0.0f ? lightprobe_between(light.slope_v, -4.0f, 4.0f) : 0.0f;\n"
    "    lightprobe_vec3 at, d, axis_u, axis_v, tilt;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        at[i] = lightprobe_between(scale * (i == 0 ? x : i == 1 ? y : z), -1e4f, 1e4f);\n"
    "        d[i] = lightprobe_between(light.direction[i], -1.0f, 1.0f);\n"
    "        axis_u[i] = lightprobe_between(light.axis_u[i], -1.0f, 1.0f);\n"
    "        tilt[i] = slope_u * axis_u[i] + slope_v * lightprobe_between(light.axis_v[i], -1.0f, 1.0f);\n"
    "        before -= at[i] * (d[i] - tilt[i]);\n"
    "    }\n"
    "    for (int i = 0; i < 3; i++) { // right-handed, as axis_v need not be\n"
    "        int j = (i + 1) % 3, k = (i + 2) % 3;\n"
    "        axis_v[i] = d[j] * axis_u[k] - d[k] * axis_u[j];\n"
    "    }\n"
    "    float rise_u = lightprobe_dot(axis_u, tilt), rise_v = lightprobe_dot(axis_v, tilt);\n"
    "    lightprobe_into_lobe(lobe, d);\n"
    "    lightprobe_into_lobe(lobe, axis_u);\n"
    "    lightprobe_into_lobe(lobe, axis_v);\n"
    "    if (scale > 0.0f) lightprobe_into_lobe(lobe, at);\n"
    "    for (int k = 0; k < 4; k++) {\n"
    "        float right = k == 1 || k == 2 ? -u : u, up = k < 2 ? v : -v, reach = 1.0f;\n"
    "        float along = c - right * rise_u - up * rise_v;\n"
    "        if (scale > 0.0f) reach = c / lightprobe_between(along, 0.25f * c, 4.0f * c);\n"
    "        for (int i = 0; i < 3; i++)\n"
    "            corner[k][i] = reach * (c * d[i] + right * axis_u[i] + up * axis_v[i]) - c * at[i];\n"
    "    }\n"
    "    float slant = sqrtf(1.0f + slope_u * slope_u + slope_v * slope_v), c2 = c * c + 1e-6f;\n"
    "    return lightprobe_fade_in(before / slant, slant * (1.0f - c * c) / c2);\n"
    "}\n"
    "\n"
    "void lightprobe_specular(lightprobe_light light, lightprobe_lobe lobe, float x, float y, float z,\n"
    "                         LIGHTPROBE_OUT lightprobe_vec3 rgb)\n"
    "{\n"
    "    // Half-sizes shrink again beyond a hemisphere.\n"
    "    float c = lightprobe_between(light.cos_alpha, -1.0f, 1.0f);\n"
    "    float u = lightprobe_between(light.tan_half_u, 1e-3f, 4.0f);\n"
    "    float v = lightprobe_between(light.tan_half_v, 1e-3f, 4.0f);\n"
    "    float most = c < 0.0f ? sqrtf(1.0f - c * c) : 1.0f;\n"
    "    lightprobe_vec3 corner[4], flux;\n"
    "    lightprobe_vec4 sum;\n"
    "    u = most * u / sqrtf(1.0f + u * u);\n"
    "    v = most * v / sqrtf(1.0f + v * v);\n"
    "    for (int i = 0; i < 3; i++) sum[i] = sum[3] = rgb[i] = 0.0f;\n"
    "    float part = lightprobe_corners(light, lobe, c, u, v, x, y, z, corner);\n"
    "    if (part <= 0.0f) return;\n"
    "    lightprobe_add_edges(lobe.normal, corner, c, sum);\n"
    "    // An outline around the point straight below leaves the whole horizon out (Stokes).\n"
    "    float missing = 0.15915494f * sum[3] < (c < 0.0f ? 0.5f : -0.5f) ? 6.28318531f : 0.0f;\n"
    "    for (int i = 0; i < 3; i++) flux[i] = sum[i] + missing * lobe.normal[i];\n"
    "    float share = lightprobe_between(0.15915494f * lightprobe_dot(flux, lobe.normal), 0.0f, 1.0f);\n"
    "    float density = share / (4.0f * lightprobe_angle(u * v, c * sqrtf(c * c + u * u + v * v)));\n"
    "    // Fresnel's term is that where the light is; of a light that fills the lobe, the lobe's mean.\n"
    "    float fresnel = lightprobe_fresnel(lightprobe_to_viewer(lobe, flux));\n"
    "    fresnel = lightprobe_between(fresnel + share * share * lobe.fresnel, 0.0f, 1.0f);\n"
    "    for (int i = 0; i < 3; i++)\n"
    "        rgb[i] = part * light.irradiance[i] * lobe.whole * density *\n"
    "                 (lobe.f0[i] + (1.0f - lobe.f0[i]) * fresnel);\n"
    "}\n"
    // [glsl text end]
    LIGHTPROBE__SPECULAR_END;
}

static const char *lightprobe__quote_work(void)
{
    return
    // [glsl text begin work] made by "make glsl", do not edit
    "// Sums over a square of 2^level texels: RGB radiance and 1, and luminance times direction, in the\n"
    "// face's own axes (middle, s, t), and over distance.\n"
    "struct lightprobe_cell {\n"
    "    lightprobe_vec4 flux, resultant;\n"
    "};\n"
    "\n"
    "// A cell that is not divided further. Leaves tile the sphere; clusters of them become lights.\n"
    "struct lightprobe_leaf {\n"
    "    lightprobe_vec3 flux;\n"
    "    float solid_angle;\n"
    "    lightprobe_vec3 direction; // vector irradiance = strength * direction\n"
    "    float strength, luminance;\n"
    "    float tone; // LIGHTPROBE_TONE times the logarithm of radiance over its mean, plus parallax\n"
    "    float inverse, parallax; // mean of 1 / distance; that times the reach of receivers, at most 1\n"
    "    float half_width;        // of the square that it spreads its light over\n"
    "    int face, level, x, y, cluster;\n"
    "    float least, parts; // distance of the nearest seed, sum of what all lights take\n"
    "};\n"
    "\n"
    "// Sums over the leaves of a light, of RGB and of luminance times tone, direction, and the squares\n"
    "// and products of it, xx yy zz xy yz zx.\n"
    "struct lightprobe_moments {\n"
    "    lightprobe_vec3 flux;\n"
    "    float tones;\n"
    "    lightprobe_vec3 resultant;\n"
    "    float second[6];\n"
    "};\n"
    "\n"
    "// Sums over leaves: of luminance, of it times direction, tone and squared tone.\n"
    "struct lightprobe_sum {\n"
    "    lightprobe_vec3 resultant;\n"
    "    float luminance, tones, tones2;\n"
    "    int count;\n"
    "};\n"
    "\n"
    "// The plane, or the tone, at which a cluster is split best. Along the axis lie LIGHTPROBE_BINS bins\n"
    "// of width 1 / scale from low on.\n"
    "struct lightprobe_axis {\n"
    "    lightprobe_vec3 direction;\n"
    "    float threshold, low, scale;\n"
    "    int by_tone;\n"
    "};\n"
    "\n"
    "struct lightprobe_cluster {\n"
    "    lightprobe_sum sum;\n"
    "    lightprobe_vec3 centre; // means\n"
    "    float tone;\n"
    "    lightprobe_axis axis, tone_axis;\n"
    "    float error, gain; // behind edges; what the planned split takes off the cost\n"
    "    int planned, changed, id;\n"
    "    int brightest; // leaf: it adds most\n"
    "    int first;     // of sum.count leaves in order[]\n"
    "    int nearby[LIGHTPROBE_NEAR], near_count;\n"
    "    lightprobe_vec3 seed; // on a moving probe leaves go to the nearest\n"
    "    float seed_tone, seed_share;\n"
    "    int lives; // takes leaves, 2: and those of one that does no more; 0: fades out\n"
    "    // Mean direction that the light may have (else lamps' discs step 9 times as far); what it was\n"
    "    // when it had leaves.\n"
    "    float longest, distance;\n"
    "    lightprobe_vec3 slopes; // along both axes, in the world\n"
    "    lightprobe_vec3 across; // axis_u in the last frame, 0: of a new light\n"
    "    lightprobe_vec3 sizes;  // variances along both axes, and 1 - cosine, then\n"
    "    // Of the leaves, now and in the last frame; what the light has besides, until it has faded.\n"
    "    // With energy alone steps are 4 times as large, without second moments those of rectangles 2 to\n"
    "    // 3 times.\n"
    "    lightprobe_moments now, past, late;\n"
    "};\n"
    "\n"
    "LIGHTPROBE_SHARED float lightprobe_luminance(const lightprobe_vec3 rgb)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float l = 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];\n"
    "    return l;\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED float lightprobe_dot(const lightprobe_vec3 a, const lightprobe_vec3 b)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float d = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];\n"
    "    return d;\n"
    "}\n"
    "\n"
    "// Of two vectors by a symmetric matrix (xx yy zz xy yz zx).\n"
    "LIGHTPROBE_SHARED float lightprobe_product(const float m[6], const lightprobe_vec3 a,\n"
    "                                           const lightprobe_vec3 b)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float sum = m[0] * a[0] * b[0] + m[1] * a[1] * b[1] + m[2] * a[2] * b[2];\n"
    "    LIGHTPROBE_PRECISE float xy = a[0] * b[1] + a[1] * b[0], yz = a[1] * b[2] + a[2] * b[1];\n"
    "    LIGHTPROBE_PRECISE float zx = a[2] * b[0] + a[0] * b[2];\n"
    "    sum = sum + m[3] * xy + m[4] * yz + m[5] * zx;\n"
    "    return sum;\n"
    "}\n"
    "\n"
    "// Returns the length; a null vector stays.\n"
    "LIGHTPROBE_SHARED float lightprobe_normalize(LIGHTPROBE_INOUT lightprobe_vec3 v)\n"
    "{\n"
    "    float size = lightprobe_length(v);\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        LIGHTPROBE_PRECISE float part = size > 0.0f ? v[i] / size : v[i];\n"
    "        v[i] = part;\n"
    "    }\n"
    "    return size;\n"
    "}\n"
    "\n"
    "// Natural logarithm of a ratio, kept in [1e-3, 1e6], to 1e-6. Written out: drivers round their\n"
    "// own as they like, and which leaves go together hangs on it.\n"
    "LIGHTPROBE_SHARED float lightprobe_log(float ratio)\n"
    "{\n"
    "    float r = 1024.0f * (ratio > 1e-3f ? (ratio < 1e6f ? ratio : 1e6f) : 1e-3f);\n"
    "    float e = -10.0f;\n"
    "    while (r >= 2.0f) {\n"
    "        r = 0.5f * r;\n"
    "        e = e + 1.0f;\n"
    "    }\n"
    "    LIGHTPROBE_PRECISE float t = (r - 1.0f) / (r + 1.0f), t2 = t * t;\n"
    "    LIGHTPROBE_PRECISE float p = t2 * 0.11111111f + 0.14285714f;\n"
    "    p = p * t2 + 0.2f;\n"
    "    p = p * t2 + 0.33333333f;\n"
    "    p = 0.69314718f * e + 2.0f * (p * t2 * t + t);\n"
    "    return p;\n"
    "}\n"
    "\n"
    "// mean: luminance of 1 sr of the whole probe; solid_angle is more than 0.\n"
    "LIGHTPROBE_SHARED float lightprobe_tone(float luminance, float solid_angle, float mean)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float most = 1e6f * mean * solid_angle, unit = mean * solid_angle;\n"
    "    return LIGHTPROBE_TONE * lightprobe_log(luminance < most ? luminance / unit : 1e6f);\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED lightprobe_sum lightprobe_nothing(void)\n"
    "{\n"
    "    lightprobe_sum s;\n"
    "    s.resultant[0] = s.resultant[1] = s.resultant[2] = s.luminance = s.tones = s.tones2 = 0.0f;\n"
    "    s.count = 0;\n"
    "    return s;\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED lightprobe_sum lightprobe_add_leaf(lightprobe_sum sum, lightprobe_leaf leaf)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE lightprobe_sum s = sum;\n"
    "    LIGHTPROBE_PRECISE float tones = leaf.luminance * leaf.tone;\n"
    "    s.resultant[0] += leaf.strength * leaf.direction[0];\n"
    "    s.resultant[1] += leaf.strength * leaf.direction[1];\n"
    "    s.resultant[2] += leaf.strength * leaf.direction[2];\n"
    "    s.luminance += leaf.luminance;\n"
    "    s.tones += tones;\n"
    "    s.tones2 += tones * leaf.tone;\n"
    "    s.count++;\n"
    "    return s;\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED lightprobe_sum lightprobe_add_sum(lightprobe_sum a, lightprobe_sum b)\n"
    "{\n"
    "    for (int i = 0; i < 3; i++) a.resultant[i] += b.resultant[i];\n"
    "    a.luminance += b.luminance;\n"
    "    a.tones += b.tones;\n"
    "    a.tones2 += b.tones2;\n"
    "    a.count += b.count;\n"
    "    return a;\n"
    "}\n"
    "\n"
    "// What a leaf adds to the vector of a cluster with this centre. The one that adds most never\n"
    "// leaves: not the brightest, since mirrored cells are equally bright, and either may come first.\n"
    "// Without that clusters can run empty: of 32 lights of lamps 11 did, with a tone of 0.18.\n"
    "LIGHTPROBE_SHARED float lightprobe_worth(lightprobe_leaf leaf, const lightprobe_vec3 centre)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float worth = leaf.strength * lightprobe_dot(leaf.direction, centre);\n"
    "    return worth;\n"
    "}\n"
    "\n"
    "// Variance of direction: flux times half the mean square angle to the centre.\n"
    "LIGHTPROBE_SHARED float lightprobe_sum_error(lightprobe_sum s)\n"
    "{\n"
    "    return s.luminance - lightprobe_length(s.resultant);\n"
    "}\n"
    "\n"
    "// What a cluster with this share of the flux holds against a leaf, which belongs where it is least:\n"
    "// a squared distance by flux, since errors count squared: bright lights are kept small.\n"
    "LIGHTPROBE_SHARED float lightprobe_distance(float share, const lightprobe_vec3 a, float tone_a,\n"
    "                                            const lightprobe_vec3 b, float tone_b)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];\n"
    "    LIGHTPROBE_PRECISE float tone = tone_a - tone_b;\n"
    "    LIGHTPROBE_PRECISE float apart = 0.5f * (x * x + y * y + z * z + tone * tone);\n"
    "    LIGHTPROBE_PRECISE float d = share * apart * apart;\n"
    "    return d;\n"
    "}\n"
    "\n"
    "// What lights err by, summed over clusters: squares of what unevenness does to each, and width,\n"
    "// whose share goes one way for all lights along an edge and is summed before it is squared.\n"
    "struct lightprobe_errors {\n"
    "    float squares, width;\n"
    "};\n"
    "\n"
    "// lightprobe_stats.error. A half-space cuts off each place of a small light with probability 1/2 a\n"
    "// radian; the cosine at receivers of all orientations has the mean 1/4 and the mean square 1/6.\n"
    "LIGHTPROBE_SHARED float lightprobe_root_error(lightprobe_errors e, float total)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float width = e.width / total, squares = e.squares / total * 1.3333333f;\n"
    "    width = 0.6f * width * (1.0f - 0.5f * width);\n"
    "    squares = squares + width * width;\n"
    "    return squares > 0.0f ? sqrtf(squares) : 0.0f;\n"
    "}\n"
    // [glsl text end]
        ;
}

static const char *lightprobe__quote_cells(void)
{
    return
    // [glsl text begin cells] made by "make glsl", do not edit
    "// Vector with components along a face's middle, +s and +t. 0 is added so that nothing becomes -0.\n"
    "LIGHTPROBE_SHARED void lightprobe_to_world(int face, float m, float s, float t,\n"
    "                                           LIGHTPROBE_OUT lightprobe_vec3 v)\n"
    "{\n"
    "    int axis = face / 2;\n"
    "    float sign = face % 2 == 0 ? 1.0f : -1.0f;\n"
    "    v[0] = 0.0f + (axis == 0 ? sign * m : face == 5 ? -s : s);\n"
    "    v[1] = 0.0f + (axis == 1 ? sign * m : -t);\n"
    "    v[2] = 0.0f + sign * (axis == 0 ? -s : axis == 1 ? t : m);\n"
    "}\n"
    "\n"
    "void lightprobe_texel_direction(int face, float s, float t,\n"
    "                                LIGHTPROBE_OUT lightprobe_vec3 direction)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float scale = 1.0f / sqrtf(1.0f + s * s + t * t);\n"
    "    int nearest = face < 0 ? 0 : face < 5 ? face : 5;\n"
    "    lightprobe_to_world(nearest, scale, scale * s, scale * t, direction);\n"
    "}\n"
    "\n"
    "// Cells of 2^level texels along an edge.\n"
    "LIGHTPROBE_SHARED int lightprobe_level_side(int side, int level)\n"
    "{\n"
    "    return (side + (1 << level) - 1) >> level;\n"
    "}\n"
    "\n"
    "// Index of a texel's weights; they are the same in all quarters of all faces.\n"
    "LIGHTPROBE_SHARED int lightprobe_quarter(int x, int y)\n"
    "{\n"
    "    int right = 2 * x + 1 - side, down = 2 * y + 1 - side;\n"
    "    int dx = (right < 0 ? -right : right) / 2, dy = (down < 0 ? -down : down) / 2;\n"
    "    return dy * ((side + 1) / 2) + dx;\n"
    "}\n"
    "\n"
    "// Index of a cell of tiles or larger.\n"
    "LIGHTPROBE_SHARED int lightprobe_cell_index(int face, int level, int x,\n"
    "                                            int y)\n"
    "{\n"
    "    int n = lightprobe_level_side(side, level);\n"
    "    return first_cell[level] + (face * n + y) * n + x;\n"
    "}\n"
    "\n"
    "// Centre of a texel in [-1,1].\n"
    "LIGHTPROBE_SHARED float lightprobe_centre(int side, int x)\n"
    "{\n"
    "    return LIGHTPROBE_FLOAT(2 * x + 1 - side) / LIGHTPROBE_FLOAT(side);\n"
    "}\n"
    "\n"
    "// 0 where it is none.\n"
    "LIGHTPROBE_SHARED float lightprobe_whole_distance(const lightprobe_vec3 rgb, float over_distance)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float distance = lightprobe_luminance(rgb) / over_distance;\n"
    "    return over_distance > 0.0f ? distance : 0.0f;\n"
    "}\n"
    "\n"
    "// Weights: solid angle, and that over the distance to its centre (s, t). texel_rgb[3]: how far.\n"
    "LIGHTPROBE_SHARED lightprobe_cell lightprobe_texel_cell(const lightprobe_vec4 texel_rgb,\n"
    "                                                        float omega, float weight, float s, float t)\n"
    "{\n"
    "    lightprobe_vec3 rgb;\n"
    "    for (int i = 0; i < 3; i++) rgb[i] = texel_rgb[i];\n"
    "    float distance = texel_rgb[3];\n"
    "    LIGHTPROBE_PRECISE float over_distance = lightprobe_luminance(rgb) * omega / distance;\n"
    "    LIGHTPROBE_PRECISE float m = lightprobe_luminance(rgb) * weight, ms = m * s, mt = m * t;\n"
    "    LIGHTPROBE_PRECISE lightprobe_cell texel;\n"
    "    for (int i = 0; i < 3; i++) texel.flux[i] = rgb[i] * omega;\n"
    "    texel.flux[3] = omega;\n"
    "    texel.resultant[0] = m;\n"
    "    texel.resultant[1] = ms;\n"
    "    texel.resultant[2] = mt;\n"
    "    // 0 where it is infinitely far, or no distance.\n"
    "    texel.resultant[3] = distance >= 1e-9f && distance <= 1e9f ? over_distance : 0.0f;\n"
    "    return texel;\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED lightprobe_cell lightprobe_add_cell(lightprobe_cell a, lightprobe_cell b)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE lightprobe_cell sum = a;\n"
    "    for (int i = 0; i < 4; i++) {\n"
    "        sum.flux[i] += b.flux[i];\n"
    "        sum.resultant[i] += b.resultant[i];\n"
    "    }\n"
    "    return sum;\n"
    "}\n"
    "\n"
    "// Again for GLSL, whose own comes later.\n"
    "LIGHTPROBE_SHARED int lightprobe_read(int face, int x, int y,\n"
    "                                      LIGHTPROBE_OUT lightprobe_vec4 rgbd);\n"
    "\n"
    "// A cell no larger than a tile, straight from its texels.\n"
    "LIGHTPROBE_SHARED lightprobe_cell lightprobe_small_cell(int face,\n"
    "                                                        int level, int cx, int cy)\n"
    "{\n"
    "    int size = 1 << level, end_x = size * cx + LIGHTPROBE_ROLLED(size);\n"
    "    int end_y = size * cy + LIGHTPROBE_ROLLED(size);\n"
    "    lightprobe_cell sum;\n"
    "    for (int i = 0; i < 4; i++) sum.flux[i] = sum.resultant[i] = 0.0f;\n"
    "    for (int y = size * cy; y < end_y && y < side; y++) {\n"
    "        for (int x = size * cx; x < end_x && x < side; x++) {\n"
    "            int at = lightprobe_quarter(x, y);\n"
    "            lightprobe_vec4 rgbd;\n"
    "            lightprobe_read(face, x, y, rgbd);\n"
    "            lightprobe_cell texel =\n"
    "                lightprobe_texel_cell(rgbd, omega[at], weight[at],\n"
    "                                      lightprobe_centre(side, x), lightprobe_centre(side, y));\n"
    "            sum = lightprobe_add_cell(sum, texel);\n"
    "        }\n"
    "    }\n"
    "    return sum;\n"
    "}\n"
    "\n"
    "// Makes a cell from the (up to) four of the level below.\n"
    "LIGHTPROBE_SHARED void lightprobe_halve(int face, int level, int x, int y)\n"
    "{\n"
    "    int m = lightprobe_level_side(side, level - 1);\n"
    "    int from = lightprobe_cell_index(face, level - 1, 2 * x, 2 * y);\n"
    "    lightprobe_cell sum = cells[from];\n"
    "    for (int i = 1; i < LIGHTPROBE_ROLLED(4); i++)\n"
    "        if (2 * x + i % 2 < m && 2 * y + i / 2 < m)\n"
    "            sum = lightprobe_add_cell(sum, cells[from + i / 2 * m + i % 2]);\n"
    "    cells[lightprobe_cell_index(face, level, x, y)] = sum;\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED lightprobe_cell lightprobe_cell_at(int face, int level,\n"
    "                                                     int x, int y)\n"
    "{\n"
    "    if (level < LIGHTPROBE_TILE_LEVEL) return lightprobe_small_cell(face, level, x, y);\n"
    "    return cells[lightprobe_cell_index(face, level, x, y)];\n"
    "}\n"
    "\n"
    "// Of tones and parallaxes, for a probe of this luminance over distance.\n"
    "LIGHTPROBE_SHARED void lightprobe_set_scales(float inverse)\n"
    "{\n"
    "    mean = total / 12.5663706f;\n"
    "    reach = inverse > 0.0f ? LIGHTPROBE_PARALLAX * (total / inverse) : 0.0f;\n"
    "}\n"
    "\n"
    "// Whether leaves are fine enough where the largest error is this one: the rest is rounding, or\n"
    "// there is no room. Of those with last's error, the one before, all or none are divided.\n"
    "LIGHTPROBE_SHARED int lightprobe_is_enough(int count, int room, float error, float last,\n"
    "                                           float total)\n"
    "{\n"
    "    if (count + 3 > room || error <= 1e-7f * total) return 1;\n"
    "    return count + LIGHTPROBE_MORE_LEAVES >= room && error < 0.9999f * last ? 1 : 0;\n"
    "}\n"
    "\n"
    "// -1: a texel, which is not divided.\n"
    "LIGHTPROBE_SHARED float lightprobe_leaf_error(lightprobe_leaf leaf)\n"
    "{\n"
    "    return leaf.level > 0 ? leaf.luminance - leaf.strength : -1.0f;\n"
    "}\n"
    "\n"
    "// Middle of a cell on its face; 1 where it is cut off before that.\n"
    "LIGHTPROBE_SHARED float lightprobe_cell_middle(int side, int level, int x)\n"
    "{\n"
    "    float h = LIGHTPROBE_FLOAT(2 << level) / LIGHTPROBE_FLOAT(side);\n"
    "    LIGHTPROBE_PRECISE float s = (LIGHTPROBE_FLOAT(x) + 0.5f) * h - 1.0f;\n"
    "    return s < 1.0f ? s : 1.0f;\n"
    "}\n"
    "\n"
    "// The leaf of a cell. A black one must belong somewhere, too: its direction is that of its middle.\n"
    "LIGHTPROBE_SHARED lightprobe_leaf lightprobe_leaf_of(int face, int level,\n"
    "                                                     int x, int y)\n"
    "{\n"
    "    lightprobe_cell cell = lightprobe_cell_at(face, level, x, y);\n"
    "    lightprobe_leaf leaf;\n"
    "    leaf.face = face;\n"
    "    leaf.level = level;\n"
    "    leaf.x = x;\n"
    "    leaf.y = y;\n"
    "    leaf.cluster = 0;\n"
    "    for (int i = 0; i < 3; i++) leaf.flux[i] = cell.flux[i];\n"
    "    lightprobe_to_world(face, cell.resultant[0], cell.resultant[1], cell.resultant[2],\n"
    "                        leaf.direction);\n"
    "    leaf.solid_angle = cell.flux[3];\n"
    "    leaf.luminance = lightprobe_luminance(leaf.flux);\n"
    "    leaf.strength = lightprobe_normalize(leaf.direction);\n"
    "    leaf.tone = lightprobe_tone(leaf.luminance, leaf.solid_angle / LIGHTPROBE_SCALE, mean);\n"
    "    LIGHTPROBE_PRECISE float r = leaf.luminance > 0.0f ? leaf.strength / leaf.luminance : 1.0f;\n"
    "    LIGHTPROBE_PRECISE float square = 1.5f * (1.0f - r * r); // uniform: half-width^2 / 3\n"
    "    leaf.half_width = square > 0.0f ? sqrtf(square) : 0.0f;\n"
    "    LIGHTPROBE_PRECISE float inverse =\n"
    "        leaf.luminance > 0.0f ? cell.resultant[3] / leaf.luminance : 0.0f;\n"
    "    leaf.inverse = inverse;\n"
    "    LIGHTPROBE_PRECISE float angle = inverse * reach; // sums may be infinite\n"
    "    leaf.parallax = angle < 1.0f ? angle : 1.0f;\n"
    "    LIGHTPROBE_PRECISE float tone = leaf.tone + leaf.parallax; // sets the near apart from the far\n"
    "    leaf.tone = tone;\n"
    "    leaf.least = leaf.parts = 0.0f;\n"
    "    if (!(leaf.strength > 0.0f))\n"
    "        lightprobe_texel_direction(face, lightprobe_cell_middle(side, level, x),\n"
    "                                   lightprobe_cell_middle(side, level, y), leaf.direction);\n"
    "    return leaf;\n"
    "}\n"
    // [glsl text end]
        ;
}

static const char *lightprobe__quote_splits(void)
{
    return
    // [glsl text begin splits] made by "make glsl", do not edit
    "// What cuts and merges are chosen by: flux squared times the variance of direction and tone, of the\n"
    "// total's flux. Unevenness shows in tone: so it stands for the error behind edges.\n"
    "LIGHTPROBE_SHARED float lightprobe_cost(lightprobe_sum s, float total)\n"
    "{\n"
    "    if (!(s.luminance > 0.0f)) return 0.0f;\n"
    "    LIGHTPROBE_PRECISE float mean2 = s.tones / s.luminance * s.tones;\n"
    "    LIGHTPROBE_PRECISE float spread = lightprobe_sum_error(s) + 0.5f * (s.tones2 - mean2);\n"
    "    LIGHTPROBE_PRECISE float cost = s.luminance / total * spread;\n"
    "    return cost > 0.0f ? cost : 0.0f;\n"
    "}\n"
    "\n"
    "// Second moments of direction (xx yy zz xy yz zx) and tone around their means; variance of the\n"
    "// leaves' own spread along any axis.\n"
    "struct lightprobe_spread {\n"
    "    float m[6], tone2, own;\n"
    "};\n"
    "\n"
    "// scale: 1 over the luminance of all.\n"
    "LIGHTPROBE_SHARED lightprobe_spread lightprobe_add_spread(lightprobe_spread all,\n"
    "                                                          lightprobe_leaf leaf,\n"
    "                                                          const lightprobe_vec3 mean,\n"
    "                                                          float mean_tone, float scale)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE lightprobe_spread s = all;\n"
    "    LIGHTPROBE_PRECISE float f = leaf.luminance * scale, tone = leaf.tone - mean_tone;\n"
    "    LIGHTPROBE_PRECISE float x = leaf.direction[0] - mean[0];\n"
    "    LIGHTPROBE_PRECISE float y = leaf.direction[1] - mean[1], z = leaf.direction[2] - mean[2];\n"
    "    s.m[0] += f * x * x;\n"
    "    s.m[1] += f * y * y;\n"
    "    s.m[2] += f * z * z;\n"
    "    s.m[3] += f * x * y;\n"
    "    s.m[4] += f * y * z;\n"
    "    s.m[5] += f * z * x;\n"
    "    s.tone2 += f * tone * tone;\n"
    "    s.own += f * leaf.half_width * leaf.half_width * 0.33333333f;\n"
    "    return s;\n"
    "}\n"
    "\n"
    "// First eigenvector of a symmetric matrix (xx yy zz xy yz zx): three squarings leave little but it\n"
    "// (ratio of eigenvalues to the 8th power), and the longest copy of it is a column.\n"
    "LIGHTPROBE_SHARED void lightprobe_eigenvector(const float matrix[6],\n"
    "                                              LIGHTPROBE_OUT lightprobe_vec3 v)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float m[6];\n"
    "    for (int i = 0; i < 6; i++) m[i] = matrix[i];\n"
    "    for (int round = 0; round < 3; round++) {\n"
    "        LIGHTPROBE_PRECISE float trace = m[0] + m[1] + m[2];\n"
    "        float s = trace > 1e-18f ? 1.0f / trace : 0.0f;\n"
    "        LIGHTPROBE_PRECISE float a = m[0] * s, b = m[1] * s, d = m[2] * s;\n"
    "        LIGHTPROBE_PRECISE float ab = m[3] * s, bd = m[4] * s, da = m[5] * s;\n"
    "        m[0] = a * a + ab * ab + da * da;\n"
    "        m[1] = ab * ab + b * b + bd * bd;\n"
    "        m[2] = da * da + bd * bd + d * d;\n"
    "        m[3] = a * ab + ab * b + da * bd;\n"
    "        m[4] = ab * da + b * bd + bd * d;\n"
    "        m[5] = da * a + bd * ab + d * da;\n"
    "    }\n"
    "    int k = m[0] >= m[1] ? (m[0] >= m[2] ? 0 : 2) : (m[1] >= m[2] ? 1 : 2);\n"
    "    v[0] = k == 0 ? m[0] : k == 1 ? m[3] : m[5];\n"
    "    v[1] = k == 0 ? m[3] : k == 1 ? m[1] : m[4];\n"
    "    v[2] = k == 0 ? m[5] : k == 1 ? m[4] : m[2];\n"
    "    if (!(lightprobe_normalize(v) > 0.0f)) v[1] = 1.0f;\n"
    "}\n"
    "\n"
    "// Bins around a mean; scale is 0 where nothing varies.\n"
    "LIGHTPROBE_SHARED lightprobe_axis lightprobe_axis_around(float middle, float variance)\n"
    "{\n"
    "    lightprobe_axis axis;\n"
    "    float deviation = variance > 0.0f ? sqrtf(variance) : 0.0f;\n"
    "    LIGHTPROBE_PRECISE float width = LIGHTPROBE_REACH * deviation;\n"
    "    LIGHTPROBE_PRECISE float low = middle - width;\n"
    "    for (int i = 0; i < 3; i++) axis.direction[i] = 0.0f;\n"
    "    axis.by_tone = 1;\n"
    "    axis.low = low;\n"
    "    axis.scale = deviation < 1e-7f ? 0.0f : LIGHTPROBE_FLOAT(LIGHTPROBE_BINS) / (2.0f * width);\n"
    "    axis.threshold = 0.0f;\n"
    "    return axis;\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED lightprobe_axis lightprobe_axis_along(const lightprobe_vec3 d,\n"
    "                                                        lightprobe_spread spread,\n"
    "                                                        const lightprobe_vec3 mean)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float variance = fabsf(lightprobe_product(spread.m, d, d)) + spread.own;\n"
    "    lightprobe_axis axis = lightprobe_axis_around(lightprobe_dot(mean, d), variance);\n"
    "    for (int i = 0; i < 3; i++) axis.direction[i] = d[i];\n"
    "    axis.by_tone = 0;\n"
    "    return axis;\n"
    "}\n"
    "\n"
    "// Across an axis. Light from all around has no such axis: the same one once more.\n"
    "LIGHTPROBE_SHARED lightprobe_axis lightprobe_axis_across(lightprobe_axis axis,\n"
    "                                                         lightprobe_spread spread,\n"
    "                                                         const lightprobe_vec3 mean)\n"
    "{\n"
    "    lightprobe_vec3 d;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        int j = (i + 1) % 3, k = (i + 2) % 3;\n"
    "        LIGHTPROBE_PRECISE float across = mean[j] * axis.direction[k] - mean[k] * axis.direction[j];\n"
    "        d[i] = across;\n"
    "    }\n"
    "    if (!(lightprobe_normalize(d) > 1e-3f)) return axis;\n"
    "    return lightprobe_axis_along(d, spread, mean);\n"
    "}\n"
    "\n"
    "// Along which a cluster is split, or its unevenness measured.\n"
    "struct lightprobe_axes {\n"
    "    lightprobe_axis along, across, by_tone;\n"
    "};\n"
    "\n"
    "// first: in order[], of sum.count leaves. The second axis and the leaves' own spread change errors\n"
    "// by .2%, but without them rounding chooses the cut of what is as wide as high.\n"
    "LIGHTPROBE_SHARED lightprobe_axes lightprobe_axes_of(int first,\n"
    "                                                     lightprobe_sum sum)\n"
    "{\n"
    "    lightprobe_axes axes;\n"
    "    lightprobe_spread spread;\n"
    "    lightprobe_vec3 mean, longest;\n"
    "    LIGHTPROBE_PRECISE float scale = sum.luminance > LIGHTPROBE_BLACK ? 1.0f / sum.luminance : 0.0f;\n"
    "    LIGHTPROBE_PRECISE float tone = sum.tones * scale;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        LIGHTPROBE_PRECISE float part = sum.resultant[i] * scale;\n"
    "        mean[i] = part;\n"
    "        spread.m[i] = spread.m[3 + i] = spread.tone2 = spread.own = 0.0f;\n"
    "    }\n"
    "    for (int at = first; at < first + sum.count; at++)\n"
    "        spread = lightprobe_add_spread(spread, leaves[order[at]], mean, tone, scale);\n"
    "    lightprobe_eigenvector(spread.m, longest);\n"
    "    axes.along = lightprobe_axis_along(longest, spread, mean);\n"
    "    axes.across = lightprobe_axis_across(axes.along, spread, mean);\n"
    "    axes.by_tone = lightprobe_axis_around(tone, spread.tone2);\n"
    "    return axes;\n"
    "}\n"
    "\n"
    "// Where a leaf lies on an axis, and in which bin.\n"
    "LIGHTPROBE_SHARED float lightprobe_along(lightprobe_axis axis, lightprobe_leaf leaf)\n"
    "{\n"
    "    return axis.by_tone != 0 ? leaf.tone : lightprobe_dot(leaf.direction, axis.direction);\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED int lightprobe_bin(lightprobe_axis axis, lightprobe_leaf leaf)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float p = (lightprobe_along(axis, leaf) - axis.low) * axis.scale;\n"
    "    float last = LIGHTPROBE_FLOAT(LIGHTPROBE_BINS - 1);\n"
    "    return p > 0.0f ? (p < last ? LIGHTPROBE_INT(p) : LIGHTPROBE_BINS - 1) : 0;\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED float lightprobe_threshold(lightprobe_axis axis, int bin)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float at = axis.low + LIGHTPROBE_FLOAT(bin + 1) / axis.scale;\n"
    "    return at;\n"
    "}\n"
    "\n"
    "// Where along the bins of an axis a leaf begins, and its luminance a bin.\n"
    "struct lightprobe_streak {\n"
    "    float low, density, luminance;\n"
    "};\n"
    "\n"
    "LIGHTPROBE_SHARED lightprobe_streak lightprobe_streak_of(lightprobe_axis axis, lightprobe_leaf leaf)\n"
    "{\n"
    "    lightprobe_streak s;\n"
    "    LIGHTPROBE_PRECISE float middle = (lightprobe_along(axis, leaf) - axis.low) * axis.scale;\n"
    "    LIGHTPROBE_PRECISE float half_width = leaf.half_width * axis.scale + 1e-3f;\n"
    "    LIGHTPROBE_PRECISE float low = middle - half_width;\n"
    "    s.low = low;\n"
    "    s.density = leaf.luminance / (2.0f * half_width);\n"
    "    s.luminance = leaf.luminance;\n"
    "    return s;\n"
    "}\n"
    "\n"
    "// Luminance below the end of a bin.\n"
    "LIGHTPROBE_SHARED float lightprobe_below(lightprobe_streak s, int bin)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float part = (LIGHTPROBE_FLOAT(bin + 1) - s.low) * s.density;\n"
    "    float most = part < s.luminance ? part : s.luminance;\n"
    "    return most > 0.0f ? most : 0.0f;\n"
    "}\n"
    "\n"
    "// Cramer's distance between the light along an axis (luminance below the end of each bin) and that\n"
    "// of a uniform light of the same variance, from -sqrt(3) to sqrt(3) deviations: the integral of\n"
    "// their squared difference. Its mean over all axes is the energy distance, but for a factor.\n"
    "LIGHTPROBE_SHARED float lightprobe_unevenness(lightprobe_axis axis,\n"
    "                                              const float below[LIGHTPROBE_BINS], float luminance)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float sum = 0.0f;\n"
    "    if (!(axis.scale > 0.0f)) return 0.0f;\n"
    "    for (int i = 0; i + 1 < LIGHTPROBE_BINS; i++) {\n"
    "        float place =\n"
    "            LIGHTPROBE_FLOAT(2 * i + 2 - LIGHTPROBE_BINS) / LIGHTPROBE_FLOAT(LIGHTPROBE_BINS);\n"
    "        LIGHTPROBE_PRECISE float even = 0.5f + 0.28867513f * LIGHTPROBE_REACH * place;\n"
    "        LIGHTPROBE_PRECISE float off = below[i] / luminance - even;\n"
    "        sum += off * off;\n"
    "    }\n"
    "    return sum / axis.scale;\n"
    "}\n"
    "\n"
    "// Mean squared error behind a random straight edge of a light for this cluster, of the total's\n"
    "// flux, but for a factor. unevenness: the mean of two axes.\n"
    "LIGHTPROBE_SHARED float lightprobe_edge_error(lightprobe_sum s, float unevenness, float total)\n"
    "{\n"
    "    if (!(s.luminance > 0.0f)) return 0.0f;\n"
    "    float variance = lightprobe_sum_error(s) / s.luminance;\n"
    "    if (!(variance > 0.0f)) variance = 0.0f;\n"
    "    LIGHTPROBE_PRECISE float wide = variance * sqrtf(variance) * (1.0f - 0.5f * variance);\n"
    "    LIGHTPROBE_PRECISE float e = unevenness + LIGHTPROBE_WIDTH * wide;\n"
    "    e = s.luminance / total * (s.luminance * e);\n"
    "    return e;\n"
    "}\n"
    "\n"
    "// Of the two parts of a cut; FLT_MAX where one holds no light.\n"
    "LIGHTPROBE_SHARED float lightprobe_cut_cost(lightprobe_sum below, lightprobe_sum above, float total)\n"
    "{\n"
    "    if (!(below.luminance > 0.0f) || !(above.luminance > 0.0f)) return FLT_MAX;\n"
    "    LIGHTPROBE_PRECISE float cost = lightprobe_cost(below, total) + lightprobe_cost(above, total);\n"
    "    return cost;\n"
    "}\n"
    "\n"
    "// What giving one light to two clusters adds to the cost.\n"
    "LIGHTPROBE_SHARED float lightprobe_merge_cost(lightprobe_sum a, lightprobe_sum b, float total)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float apart = lightprobe_cost(a, total) + lightprobe_cost(b, total);\n"
    "    LIGHTPROBE_PRECISE float cost = lightprobe_cost(lightprobe_add_sum(a, b), total) - apart;\n"
    "    return cost;\n"
    "}\n"
    "\n"
    "// Moves the leaves beyond the planned plane from one cluster to another, fresh one, and sums both.\n"
    "LIGHTPROBE_SHARED void lightprobe_split(int k, int fresh)\n"
    "{\n"
    "    int i = clusters[k].first, end = i + clusters[k].sum.count;\n"
    "    lightprobe_sum below = lightprobe_nothing(), above = below;\n"
    "    lightprobe_axis axis = clusters[k].axis;\n"
    "    while (i < end) {\n"
    "        int index = order[i];\n"
    "        lightprobe_leaf leaf = leaves[index];\n"
    "        if (lightprobe_along(axis, leaf) < axis.threshold) {\n"
    "            below = lightprobe_add_leaf(below, leaf);\n"
    "            i++;\n"
    "        } else {\n"
    "            above = lightprobe_add_leaf(above, leaf);\n"
    "            leaves[index].cluster = fresh;\n"
    "            order[i] = order[--end];\n"
    "            order[end] = index;\n"
    "        }\n"
    "    }\n"
    "    clusters[k].sum = below;\n"
    "    clusters[fresh].sum = above;\n"
    "    clusters[fresh].first = i;\n"
    "}\n"
    "\n"
    "// With the errors of a cluster, times 1 or -1.\n"
    "LIGHTPROBE_SHARED lightprobe_errors lightprobe_add_error(\n"
    "                                                         lightprobe_errors all, int k, float times)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE lightprobe_errors e = all;\n"
    "    e.squares += times * clusters[k].error;\n"
    "    e.width += times * lightprobe_sum_error(clusters[k].sum);\n"
    "    return e;\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED lightprobe_errors lightprobe_all_errors()\n"
    "{\n"
    "    lightprobe_errors e;\n"
    "    e.squares = e.width = 0.0f;\n"
    "    for (int k = 0; k < cluster_count; k++) e = lightprobe_add_error(e, k, 1.0f);\n"
    "    return e;\n"
    "}\n"
    "\n"
    "// Two neighbours, and what merging them costs.\n"
    "struct lightprobe_pair {\n"
    "    int a, b;\n"
    "    float cost;\n"
    "};\n"
    "\n"
    "// The cheapest so far, or that of this cluster, which takes two unchanged ones.\n"
    "LIGHTPROBE_SHARED lightprobe_pair lightprobe_cheaper_pair(\n"
    "                                                          lightprobe_pair so_far, int a,\n"
    "                                                          int not_this)\n"
    "{\n"
    "    lightprobe_pair least = so_far;\n"
    "    if (clusters[a].changed != 0 || a == not_this) return least;\n"
    "    for (int n = 0; n < clusters[a].near_count; n++) {\n"
    "        int b = clusters[a].nearby[n];\n"
    "        if (clusters[b].changed != 0 || b == not_this) continue;\n"
    "        float cost = lightprobe_merge_cost(clusters[a].sum, clusters[b].sum, total);\n"
    "        if (cost >= least.cost) continue;\n"
    "        least.a = a;\n"
    "        least.b = b;\n"
    "        least.cost = cost;\n"
    "    }\n"
    "    return least;\n"
    "}\n"
    "\n"
    "// Errors once a pair shares a light: more, unless the two are very uneven.\n"
    "LIGHTPROBE_SHARED lightprobe_errors lightprobe_merged(\n"
    "                                                      lightprobe_errors all, lightprobe_pair pair)\n"
    "{\n"
    "    lightprobe_sum a = clusters[pair.a].sum, b = clusters[pair.b].sum;\n"
    "    lightprobe_sum both = lightprobe_add_sum(a, b);\n"
    "    if (!(both.luminance > 0.0f)) return all;\n"
    "    LIGHTPROBE_PRECISE float share = both.luminance / total * both.luminance;\n"
    "    LIGHTPROBE_PRECISE float variance = lightprobe_cost(both, total) / share;\n"
    "    LIGHTPROBE_PRECISE lightprobe_errors e = all;\n"
    "    LIGHTPROBE_PRECISE float apart = clusters[pair.a].error + clusters[pair.b].error;\n"
    "    LIGHTPROBE_PRECISE float widths = lightprobe_sum_error(a) + lightprobe_sum_error(b);\n"
    "    e.squares = e.squares - apart + lightprobe_edge_error(both, 0.1f * sqrtf(variance), total);\n"
    "    e.width = e.width - widths + lightprobe_sum_error(both);\n"
    "    return e;\n"
    "}\n"
    "\n"
    "// The dimmer's light fades out; the brighter keeps its id. from: the cluster that gets one for it.\n"
    "LIGHTPROBE_SHARED void lightprobe_merge(lightprobe_pair pair, int from)\n"
    "{\n"
    "    int a = pair.a, b = pair.b;\n"
    "    clusters[a].lives = clusters[a].sum.luminance >= clusters[b].sum.luminance ? 2 : 0;\n"
    "    clusters[b].lives = 2 - clusters[a].lives;\n"
    "    clusters[a].changed = clusters[b].changed = clusters[from].changed = 1;\n"
    "    gains[a] = gains[b] = gains[from] = 0.0f;\n"
    "}\n"
    "\n"
    "// For a moving probe: whether a pair of clusters may give up a light, since it does not need it any\n"
    "// more or another gains 16 times what that costs (errors squared). error: with the pair merged.\n"
    "LIGHTPROBE_SHARED int lightprobe_should_reassign(float error, float tolerance, float gain,\n"
    "                                                 float cost, float total)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float least = 1e-5f * total + 16.0f * cost;\n"
    "    return error < 0.8f * tolerance || gain >= least ? 1 : 0;\n"
    "}\n"
    // [glsl text end]
        ;
}

static const char *lightprobe__quote_moving(void)
{
    return
    // [glsl text begin moving] made by "make glsl", do not edit
    "// Of a leaf to a cluster's seed on a moving probe, however fine the leaves are: the 4th root of the\n"
    "// distance grows about as the angle does. The tone counts half, since it jumps as cells change.\n"
    "LIGHTPROBE_SHARED float lightprobe_seed_distance(int leaf, int k)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float share = clusters[k].seed_share + 0.01f;\n"
    "    if (clusters[k].lives == 0) return FLT_MAX;\n"
    "    return sqrtf(\n"
    "        sqrtf(lightprobe_distance(share, leaves[leaf].direction, 0.5f * leaves[leaf].tone,\n"
    "                                  clusters[k].seed, 0.5f * clusters[k].seed_tone)));\n"
    "}\n"
    "\n"
    "// Tone of what shines in a leaf, however dark the rest of it is: 7% less error of 8 lights at rest.\n"
    "LIGHTPROBE_SHARED float lightprobe_own_tone(lightprobe_leaf leaf, float mean)\n"
    "{\n"
    "    float all = leaf.solid_angle / LIGHTPROBE_SCALE;\n"
    "    LIGHTPROBE_PRECISE float least = all / LIGHTPROBE_FLOAT(1 << (2 * leaf.level));\n"
    "    LIGHTPROBE_PRECISE float lit = 4.0f * leaf.half_width * leaf.half_width;\n"
    "    lit = lit < all ? (lit > least ? lit : least) : all;\n"
    "    LIGHTPROBE_PRECISE float tone = lightprobe_tone(leaf.luminance, lit, mean) + leaf.parallax;\n"
    "    return tone;\n"
    "}\n"
    "\n"
    "// What a cluster takes of a leaf, to be divided by the sum of all. least: distance of the nearest.\n"
    "// Wide leaves are shared further: with one width for all, lights of noise step 1.7 times as far.\n"
    "LIGHTPROBE_SHARED float lightprobe_part(float distance, float least, float half_width, float unit)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float softness = unit * (1.0f + 5.0f * half_width);\n"
    "    LIGHTPROBE_PRECISE float part = 1.0f - (distance - least) / softness;\n"
    "    return part > 0.0f ? part : 0.0f;\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED float lightprobe_takes(int leaf, int k)\n"
    "{\n"
    "    return lightprobe_part(lightprobe_seed_distance(leaf, k), leaves[leaf].least,\n"
    "                           leaves[leaf].half_width, unit) /\n"
    "           leaves[leaf].parts;\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED lightprobe_moments lightprobe_no_moments(void)\n"
    "{\n"
    "    lightprobe_moments m;\n"
    "    for (int i = 0; i < 3; i++) m.flux[i] = m.resultant[i] = m.second[i] = m.second[3 + i] = 0.0f;\n"
    "    m.tones = 0.0f;\n"
    "    return m;\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED lightprobe_moments lightprobe_add_moments(lightprobe_moments sum,\n"
    "                                                            lightprobe_leaf leaf, float part)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE lightprobe_moments m = sum;\n"
    "    LIGHTPROBE_PRECISE float mean = leaf.luminance > 0.0f ? leaf.strength / leaf.luminance : 0.0f;\n"
    "    LIGHTPROBE_PRECISE float spread =\n"
    "        0.5f * part * (leaf.luminance - leaf.strength) * (1.0f + mean);\n"
    "    LIGHTPROBE_PRECISE float strength = part * leaf.strength, along = strength * mean - spread;\n"
    "    LIGHTPROBE_PRECISE float luminance = part * leaf.luminance, tones = luminance * leaf.tone;\n"
    "    m.tones += tones;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        int j = (i + 1) % 3;\n"
    "        LIGHTPROBE_PRECISE float flux = part * leaf.flux[i], vector = strength * leaf.direction[i];\n"
    "        LIGHTPROBE_PRECISE float square = along * leaf.direction[i] * leaf.direction[i] + spread;\n"
    "        LIGHTPROBE_PRECISE float product = along * leaf.direction[i] * leaf.direction[j];\n"
    "        m.flux[i] += flux;\n"
    "        m.resultant[i] += vector;\n"
    "        m.second[i] += square;\n"
    "        m.second[3 + i] += product;\n"
    "    }\n"
    "    return m;\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED lightprobe_moments lightprobe_more(lightprobe_moments a, lightprobe_moments b,\n"
    "                                                     float times)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE lightprobe_moments m = a;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        m.flux[i] += times * b.flux[i];\n"
    "        m.resultant[i] += times * b.resultant[i];\n"
    "        m.second[i] += times * b.second[i];\n"
    "        m.second[3 + i] += times * b.second[3 + i];\n"
    "    }\n"
    "    return m;\n"
    "}\n"
    "\n"
    "// Length of the mean direction.\n"
    "LIGHTPROBE_SHARED float lightprobe_evenness(lightprobe_moments m)\n"
    "{\n"
    "    float luminance = lightprobe_luminance(m.flux);\n"
    "    return luminance > 0.0f ? lightprobe_length(m.resultant) / luminance : 0.0f;\n"
    "}\n"
    "\n"
    "// state[]: 0 seed, 3 its tone, 4 its share (-1: fades out), 5 frames to fade, 6 late flux, 9\n"
    "// resultant and 12 second moments, of the total's luminance.\n"
    "\n"
    "// Whether lights can go on from the previous ones, whose irradiance in all is given: not if the map\n"
    "// has jumped by a tenth.\n"
    "LIGHTPROBE_SHARED int lightprobe_goes_on(float all, float total)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float flux = all * LIGHTPROBE_SCALE, apart = fabsf(flux - total);\n"
    "    return apart < 0.1f * total ? 1 : 0;\n"
    "}\n"
    "\n"
    "// The variance of lightprobe_half_size.\n"
    "LIGHTPROBE_SHARED float lightprobe_variance(float tangent)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float square = tangent * tangent, variance = square / (3.0f + 3.0f * square);\n"
    "    return variance;\n"
    "}\n"
    "\n"
    "// What a previous light had of its leaves.\n"
    "LIGHTPROBE_SHARED lightprobe_moments lightprobe_past(lightprobe_light l, lightprobe_moments late)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE lightprobe_moments m = lightprobe_no_moments();\n"
    "    LIGHTPROBE_PRECISE float luminance = LIGHTPROBE_SCALE * lightprobe_luminance(l.irradiance);\n"
    "    LIGHTPROBE_PRECISE float strength = luminance * (0.5f + 0.5f * l.cos_alpha);\n"
    "    LIGHTPROBE_PRECISE float u = luminance * lightprobe_variance(l.tan_half_u);\n"
    "    LIGHTPROBE_PRECISE float v = luminance * lightprobe_variance(l.tan_half_v),\n"
    "                             d = luminance - u - v;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        int j = (i + 1) % 3;\n"
    "        LIGHTPROBE_PRECISE float flux = LIGHTPROBE_SCALE * l.irradiance[i];\n"
    "        LIGHTPROBE_PRECISE float vector = strength * l.direction[i];\n"
    "        LIGHTPROBE_PRECISE float du = u * l.axis_u[i], dv = v * l.axis_v[i],\n"
    "                                 dd = d * l.direction[i];\n"
    "        m.flux[i] = flux;\n"
    "        m.resultant[i] = vector;\n"
    "        m.second[i] = du * l.axis_u[i] + dv * l.axis_v[i] + dd * l.direction[i];\n"
    "        m.second[3 + i] = du * l.axis_u[j] + dv * l.axis_v[j] + dd * l.direction[j];\n"
    "    }\n"
    "    return lightprobe_more(m, late, -1.0f);\n"
    "}\n"
    "\n"
    "// A cluster that has no leaves yet.\n"
    "LIGHTPROBE_SHARED lightprobe_cluster lightprobe_fresh(void)\n"
    "{\n"
    "    lightprobe_cluster c;\n"
    "    c.sum = lightprobe_nothing();\n"
    "    c.now = c.past = c.late = lightprobe_no_moments();\n"
    "    for (int i = 0; i < 3; i++)\n"
    "        c.centre[i] = c.seed[i] = c.slopes[i] = c.across[i] = c.sizes[i] = 0.0f;\n"
    "    c.tone = c.seed_tone = c.seed_share = c.longest = c.distance = 0.0f;\n"
    "    c.error = c.gain = 0.0f;\n"
    "    c.planned = c.changed = c.brightest = c.first = c.near_count = 0;\n"
    "    c.id = -1;\n"
    "    c.lives = 1;\n"
    "    return c;\n"
    "}\n"
    "\n"
    "// The cluster of a previous light. jumps: nothing fades that it had besides its leaves.\n"
    "LIGHTPROBE_SHARED lightprobe_cluster lightprobe_recalled(lightprobe_light l, float total, int jumps)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE lightprobe_cluster c = lightprobe_fresh();\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        c.seed[i] = l.state[i];\n"
    "        c.slopes[i] = l.slope_u * l.axis_u[i] + l.slope_v * l.axis_v[i];\n"
    "        c.across[i] = l.axis_u[i];\n"
    "    }\n"
    "    lightprobe_normalize(c.seed);\n"
    "    c.seed_tone = l.state[3];\n"
    "    c.seed_share = l.state[4];\n"
    "    c.lives = c.seed_share > 0.0f ? 1 : 0;\n"
    "    c.id = l.id;\n"
    "    c.distance = l.distance > 0.0f && l.distance <= 1e9f ? l.distance : 0.0f;\n"
    "    c.sizes[0] = lightprobe_variance(l.tan_half_u);\n"
    "    c.sizes[1] = lightprobe_variance(l.tan_half_v);\n"
    "    c.sizes[2] = 1.0f - l.cos_alpha;\n"
    "    if (jumps != 0) return c;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        c.late.flux[i] = total * l.state[6 + i];\n"
    "        c.late.resultant[i] = total * l.state[9 + i];\n"
    "        c.late.second[i] = total * l.state[12 + i];\n"
    "        c.late.second[3 + i] = total * l.state[15 + i];\n"
    "    }\n"
    "    c.past = lightprobe_past(l, c.late);\n"
    "    c.longest = 0.5f + 0.5f * l.cos_alpha;\n"
    "    return c;\n"
    "}\n"
    "\n"
    "// Radians by which the light of this light's leaves has turned since the last frame, by its share.\n"
    "LIGHTPROBE_SHARED float lightprobe_moved(lightprobe_moments now, lightprobe_moments past,\n"
    "                                         float total)\n"
    "{\n"
    "    lightprobe_vec3 way;\n"
    "    lightprobe_normalize(now.resultant);\n"
    "    if (!(lightprobe_normalize(past.resultant) > 0.0f)) return 0.0f;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        LIGHTPROBE_PRECISE float step = now.resultant[i] - past.resultant[i];\n"
    "        way[i] = step;\n"
    "    }\n"
    "    LIGHTPROBE_PRECISE float moved =\n"
    "        lightprobe_luminance(now.flux) / total * lightprobe_length(way);\n"
    "    return moved;\n"
    "}\n"
    "\n"
    "// Sums of lights' late flux below 0 and above, and of it times the light's flux, or 0 for these.\n"
    "struct lightprobe_excess {\n"
    "    lightprobe_wide sum[2][3], weighted[2][3];\n"
    "};\n"
    "\n"
    "// A light's flux in this frame or the last, whichever is more.\n"
    "LIGHTPROBE_SHARED float lightprobe_most(float late, float now)\n"
    "{\n"
    "    return late > 0.0f ? now + late : now;\n"
    "}\n"
    "\n"
    "// weighted: 1, or 0 for sums alone.\n"
    "LIGHTPROBE_SHARED lightprobe_excess lightprobe_all_excess(int weighted)\n"
    "{\n"
    "    lightprobe_excess e;\n"
    "    for (int i = 0; i < 6; i++) e.sum[i / 3][i % 3] = e.weighted[i / 3][i % 3] = LIGHTPROBE_ZERO;\n"
    "    for (int k = 0; k < cluster_count; k++) {\n"
    "        for (int i = 0; i < 3; i++) {\n"
    "            float late = clusters[k].late.flux[i], now = clusters[k].now.flux[i];\n"
    "            int over = late > 0.0f ? 1 : 0;\n"
    "            float weight = weighted != 0 ? lightprobe_most(late, now) : 0.0f;\n"
    "            LIGHTPROBE_PRECISE float more = weight * fabsf(late);\n"
    "            LIGHTPROBE_ADD(e.sum[over][i], fabsf(late));\n"
    "            LIGHTPROBE_ADD(e.weighted[over][i], more);\n"
    "        }\n"
    "    }\n"
    "    return e;\n"
    "}\n"
    "\n"
    "// Late moments cut so that the flux of all lights' becomes 0. What the map itself has gained or\n"
    "// lost changes at once, where bright lights have changed: the larger of the two sums is cut down to\n"
    "// the other, with the lights' flux as weight, and what is then left without. So a sky stays as it\n"
    "// is while a sun brightens. Direction and width of what is shown stay.\n"
    "LIGHTPROBE_SHARED lightprobe_moments lightprobe_balanced(lightprobe_moments late,\n"
    "                                                         lightprobe_moments now,\n"
    "                                                         lightprobe_excess e)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE lightprobe_moments m = late;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        int over = late.flux[i] > 0.0f ? 1 : 0;\n"
    "        float own = LIGHTPROBE_VALUE(e.sum[over][i]);\n"
    "        float other = LIGHTPROBE_VALUE(e.sum[1 - over][i]);\n"
    "        float weights = LIGHTPROBE_VALUE(e.weighted[over][i]);\n"
    "        LIGHTPROBE_PRECISE float cut = (own - other) * lightprobe_most(late.flux[i], now.flux[i]);\n"
    "        LIGHTPROBE_PRECISE float kept = 1.0f;\n"
    "        if (own > other) kept = weights > 0.0f ? 1.0f - cut / weights : other / own;\n"
    "        m.flux[i] *= kept > 0.0f ? kept : 0.0f;\n"
    "    }\n"
    "    LIGHTPROBE_PRECISE float change =\n"
    "        lightprobe_luminance(m.flux) - lightprobe_luminance(late.flux);\n"
    "    lightprobe_moments shape = lightprobe_more(now, late, 1.0f);\n"
    "    float whole = lightprobe_luminance(shape.flux);\n"
    "    if (change > whole) { // it shows little yet\n"
    "        shape = now;\n"
    "        whole = lightprobe_luminance(now.flux);\n"
    "    }\n"
    "    LIGHTPROBE_PRECISE float part = change / (whole + 1e-30f);\n"
    "    for (int i = 0; i < 3; i++) shape.flux[i] = 0.0f; // that is cut already\n"
    "    return lightprobe_more(m, shape, part);\n"
    "}\n"
    "\n"
    "// Sums and means of a cluster, and which leaf adds most, from count leaves that are sorted; without\n"
    "// light it keeps its centre and tone.\n"
    "LIGHTPROBE_SHARED void lightprobe_sum_cluster(int k, int count)\n"
    "{\n"
    "    lightprobe_sum sum = lightprobe_nothing();\n"
    "    int first = clusters[k].first;\n"
    "    for (int at = first; at < first + count; at++)\n"
    "        sum = lightprobe_add_leaf(sum, leaves[order[at]]);\n"
    "    clusters[k].sum = sum;\n"
    "    float size = lightprobe_normalize(sum.resultant), most = -FLT_MAX;\n"
    "    for (int i = 0; i < 3 && size > 0.0f; i++) clusters[k].centre[i] = sum.resultant[i];\n"
    "    if (sum.luminance > LIGHTPROBE_BLACK) clusters[k].tone = sum.tones / sum.luminance;\n"
    "    for (int at = first; at < first + count; at++) {\n"
    "        float worth = lightprobe_worth(leaves[order[at]], clusters[k].centre);\n"
    "        if (worth <= most) continue;\n"
    "        most = worth;\n"
    "        clusters[k].brightest = order[at];\n"
    "    }\n"
    "}\n"
    "\n"
    "// The clusters whose centres are nearest to this one's.\n"
    "LIGHTPROBE_SHARED void lightprobe_find_near(int a)\n"
    "{\n"
    "    float score[LIGHTPROBE_NEAR];\n"
    "    int n = 0;\n"
    "    for (int b = 0; b < cluster_count; b++) {\n"
    "        if (b == a || !(clusters[b].sum.luminance > 0.0f)) continue;\n"
    "        // 1 - cosine is half the squared distance of directions: so is this of tones.\n"
    "        LIGHTPROBE_PRECISE float apart = clusters[a].tone - clusters[b].tone;\n"
    "        LIGHTPROBE_PRECISE float cosine =\n"
    "            lightprobe_dot(clusters[a].centre, clusters[b].centre);\n"
    "        LIGHTPROBE_PRECISE float s = cosine - 0.5f * apart * apart;\n"
    "        if (n == LIGHTPROBE_NEAR && s <= score[n - 1]) continue;\n"
    "        int at = n < LIGHTPROBE_NEAR ? n++ : n - 1;\n"
    "        for (; at > 0; at--) {\n"
    "            if (score[at - 1] >= s) break;\n"
    "            score[at] = score[at - 1];\n"
    "            clusters[a].nearby[at] = clusters[a].nearby[at - 1];\n"
    "        }\n"
    "        score[at] = s;\n"
    "        clusters[a].nearby[at] = b;\n"
    "    }\n"
    "    clusters[a].near_count = n;\n"
    "}\n"
    "\n"
    "// Of a leaf's cluster and its neighbours, across cuts and faces, the one that holds least against\n"
    "// it. The leaf that adds most stays, so that no cluster runs empty.\n"
    "LIGHTPROBE_SHARED int lightprobe_nearest_cluster(int leaf)\n"
    "{\n"
    "    int own = leaves[leaf].cluster, to = own;\n"
    "    float best = FLT_MAX;\n"
    "    if (clusters[own].brightest == leaf) return own;\n"
    "    for (int j = -1; j < clusters[own].near_count; j++) {\n"
    "        int k = j < 0 ? own : clusters[own].nearby[j];\n"
    "        float added = j < 0 ? 0.0f : leaves[leaf].luminance;\n"
    "        LIGHTPROBE_PRECISE float share = (clusters[k].sum.luminance + added) / total;\n"
    "        float d = lightprobe_distance(share, leaves[leaf].direction, leaves[leaf].tone,\n"
    "                                      clusters[k].centre, clusters[k].tone);\n"
    "        if (d >= best) continue;\n"
    "        best = d;\n"
    "        to = k;\n"
    "    }\n"
    "    return to;\n"
    "}\n"
    "\n"
    "// Of a light that has none, as all are in a first frame or where the map jumped: at the light.\n"
    "LIGHTPROBE_SHARED void lightprobe_set_seed(int k)\n"
    "{\n"
    "    int end = clusters[k].first + clusters[k].sum.count;\n"
    "    lightprobe_moments now = lightprobe_no_moments();\n"
    "    for (int at = clusters[k].first; at < end; at++) {\n"
    "        lightprobe_leaf leaf = leaves[order[at]];\n"
    "        leaf.tone = lightprobe_own_tone(leaf, mean);\n"
    "        now = lightprobe_add_moments(now, leaf, 1.0f);\n"
    "    }\n"
    "    clusters[k].now = now;\n"
    "    if (!(lightprobe_normalize(now.resultant) > 0.0f)) now.resultant[1] = 1.0f;\n"
    "    for (int i = 0; i < 3; i++) clusters[k].seed[i] = now.resultant[i];\n"
    "    float luminance = lightprobe_luminance(now.flux);\n"
    "    LIGHTPROBE_PRECISE float tone = luminance > LIGHTPROBE_BLACK ? now.tones / luminance : 0.0f;\n"
    "    LIGHTPROBE_PRECISE float share = luminance / total + 1e-9f;\n"
    "    clusters[k].seed_tone = tone;\n"
    "    clusters[k].seed_share = share;\n"
    "    if (!(luminance > 0.0f)) clusters[k].lives = 0;\n"
    "}\n"
    "\n"
    "// Whether a light is new, or has taken over another's place.\n"
    "LIGHTPROBE_SHARED int lightprobe_is_changed()\n"
    "{\n"
    "    for (int k = 0; k < cluster_count; k++)\n"
    "        if (clusters[k].id < 0 || clusters[k].lives == 2) return 1;\n"
    "    return 0;\n"
    "}\n"
    "\n"
    "// How many frames one counts for in which all lights have moved so far; that is not known where\n"
    "// leaves have been given away.\n"
    "LIGHTPROBE_SHARED float lightprobe_pace(int changes)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float moved = 0.0f;\n"
    "    for (int k = 0; k < cluster_count && changes == 0; k++)\n"
    "        moved += lightprobe_moved(clusters[k].now, clusters[k].past, total);\n"
    "    moved = moved / LIGHTPROBE_STEP;\n"
    "    return moved > 1.0f ? (moved < LIGHTPROBE_FASTEST ? moved : LIGHTPROBE_FASTEST) : 1.0f;\n"
    "}\n"
    "\n"
    "// What a light has of lights that have changed, so that nothing jumps. A part of it is left a frame\n"
    "// later, in the end nothing. No light becomes negative.\n"
    "LIGHTPROBE_SHARED void lightprobe_fade(int k, int changes, float pace,\n"
    "                                       float frames)\n"
    "{\n"
    "    lightprobe_moments now = clusters[k].now, past = clusters[k].past;\n"
    "    lightprobe_moments late = clusters[k].late;\n"
    "    LIGHTPROBE_PRECISE float slow = clusters[k].lives != 0 ? 9.0f / (9.0f + pace) : 0.0f;\n"
    "    LIGHTPROBE_PRECISE float rest = frames > pace ? 1.0f - pace / frames : slow;\n"
    "    float longest = lightprobe_evenness(now);\n"
    "    if (longest > clusters[k].longest) clusters[k].longest = longest;\n"
    "    if (changes != 0) late = lightprobe_more(lightprobe_more(late, past, 1.0f), now, -1.0f);\n"
    "    late = lightprobe_more(lightprobe_no_moments(), late, rest);\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        LIGHTPROBE_PRECISE float least = -0.999f * now.flux[i];\n"
    "        if (late.flux[i] < least) late.flux[i] = least;\n"
    "    }\n"
    "    clusters[k].late = late;\n"
    "}\n"
    // [glsl text end]
        ;
}

static const char *lightprobe__quote_lights(void)
{
    return
    // [glsl text begin lights] made by "make glsl", do not edit
    "// What a light is made from: the sums over its leaves, its frame (e, f, d) by the direction of\n"
    "// these, and luminance times squares and product of direction along e and f, and over distance.\n"
    "struct lightprobe_region {\n"
    "    lightprobe_wide flux[3], resultant[3], luminance, solid_angle, inverse;\n"
    "    lightprobe_vec3 d, e, f;\n"
    "    lightprobe_wide second[3];\n"
    "};\n"
    "\n"
    "// Sums over leaves around a light, by luminance: of squares and product of direction along e and f,\n"
    "// of these times what a plane across d leaves of 1 / distance, in parts of it, of the square of\n"
    "// that, of the leaves' own spread. scale: 1 / distance becomes parts by it; reach: 1 - cosine from\n"
    "// which on a leaf does not count.\n"
    "struct lightprobe_tilt {\n"
    "    float ee, ff, ef, e, f, squares, own, scale, reach;\n"
    "};\n"
    "\n"
    "// Standard deviation of a light's irradiance behind random half-spaces, in parts of the total's\n"
    "// mean, which is the shadow that is lost without a map: share of the flux times the root of 8/3\n"
    "// (1/4 - a / (2 pi)), a the mean angle between two points of it (a disc's, and 1.57 all around).\n"
    "LIGHTPROBE_SHARED float lightprobe_shadow(lightprobe_sum s, float total)\n"
    "{\n"
    "    float variance = lightprobe_sum_error(s) / s.luminance;\n"
    "    float root = sqrtf(fabsf(variance)); // rounding may be negative\n"
    "    LIGHTPROBE_PRECISE float angle = root * (1.81f - 0.24f * root);\n"
    "    LIGHTPROBE_PRECISE float square = 0.66666667f - 0.42441318f * angle;\n"
    "    LIGHTPROBE_PRECISE float shadow = s.luminance / total * sqrtf(fabsf(square));\n"
    "    return shadow;\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED lightprobe_region lightprobe_no_region(void)\n"
    "{\n"
    "    lightprobe_region r;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        r.flux[i] = r.resultant[i] = r.second[i] = LIGHTPROBE_ZERO;\n"
    "        r.d[i] = r.e[i] = r.f[i] = 0.0f;\n"
    "    }\n"
    "    r.luminance = r.solid_angle = r.inverse = LIGHTPROBE_ZERO;\n"
    "    return r;\n"
    "}\n"
    "\n"
    "// Adds so much of a leaf.\n"
    "LIGHTPROBE_SHARED lightprobe_region lightprobe_add_region(lightprobe_region region,\n"
    "                                                          lightprobe_leaf leaf, float part)\n"
    "{\n"
    "    lightprobe_region r = region;\n"
    "    LIGHTPROBE_PRECISE float luminance = part * leaf.luminance, omega = part * leaf.solid_angle;\n"
    "    LIGHTPROBE_PRECISE float strength = part * leaf.strength, inverse = luminance * leaf.inverse;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        LIGHTPROBE_PRECISE float flux = part * leaf.flux[i], vector = strength * leaf.direction[i];\n"
    "        LIGHTPROBE_ADD(r.flux[i], flux);\n"
    "        LIGHTPROBE_ADD(r.resultant[i], vector);\n"
    "    }\n"
    "    LIGHTPROBE_ADD(r.luminance, luminance);\n"
    "    LIGHTPROBE_ADD(r.solid_angle, omega);\n"
    "    LIGHTPROBE_ADD(r.inverse, inverse);\n"
    "    return r;\n"
    "}\n"
    "\n"
    "// Two unit vectors that make a right-handed frame (e, f, d).\n"
    "LIGHTPROBE_SHARED void lightprobe_frame(const lightprobe_vec3 d, LIGHTPROBE_OUT lightprobe_vec3 e,\n"
    "                                        LIGHTPROBE_OUT lightprobe_vec3 f)\n"
    "{\n"
    "    float x = fabsf(d[0]), y = fabsf(d[1]), z = fabsf(d[2]);\n"
    "    int k = x < y ? (x < z ? 0 : 2) : (y < z ? 1 : 2);\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        LIGHTPROBE_PRECISE float across = (i == k ? 1.0f : 0.0f) - d[k] * d[i];\n"
    "        e[i] = across;\n"
    "    }\n"
    "    lightprobe_normalize(e);\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        int j = (i + 1) % 3, l = (i + 2) % 3;\n"
    "        LIGHTPROBE_PRECISE float cross = d[j] * e[l] - d[l] * e[j];\n"
    "        f[i] = cross;\n"
    "    }\n"
    "}\n"
    "\n"
    "// Then the leaves again: along e and f nothing cancels, however narrow the light. A leaf's light is\n"
    "// spread evenly around its mean direction, as far as the length of the vector irradiance tells.\n"
    "LIGHTPROBE_SHARED lightprobe_region lightprobe_add_second(lightprobe_region region,\n"
    "                                                          lightprobe_leaf leaf, float part)\n"
    "{\n"
    "    lightprobe_region r = region;\n"
    "    LIGHTPROBE_PRECISE float luminance = part * leaf.luminance, strength = part * leaf.strength;\n"
    "    LIGHTPROBE_PRECISE float mean = luminance > 0.0f ? strength / luminance : 0.0f;\n"
    "    LIGHTPROBE_PRECISE float spread = 0.5f * (luminance - strength) * (1.0f + mean);\n"
    "    LIGHTPROBE_PRECISE float along = strength * mean - spread;\n"
    "    float e = lightprobe_dot(leaf.direction, r.e);\n"
    "    float f = lightprobe_dot(leaf.direction, r.f);\n"
    "    LIGHTPROBE_PRECISE float ee = along * e * e + spread;\n"
    "    LIGHTPROBE_PRECISE float ff = along * f * f + spread;\n"
    "    LIGHTPROBE_PRECISE float ef = along * e * f;\n"
    "    LIGHTPROBE_ADD(r.second[0], ee);\n"
    "    LIGHTPROBE_ADD(r.second[1], ff);\n"
    "    LIGHTPROBE_ADD(r.second[2], ef);\n"
    "    return r;\n"
    "}\n"
    "\n"
    "// Whatever light a leaf belongs to: by its own leaves alone one of few has no plane, or a wrong\n"
    "// one. They count the less the further they are, and nothing from sqrt(5) times the light's own\n"
    "// spread on.\n"
    "LIGHTPROBE_SHARED lightprobe_tilt lightprobe_no_tilt(lightprobe_region r)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE lightprobe_tilt t;\n"
    "    LIGHTPROBE_PRECISE float size = 0.0f, inverse = LIGHTPROBE_VALUE(r.inverse);\n"
    "    for (int i = 0; i < 3; i++) size = size + LIGHTPROBE_VALUE(r.resultant[i]) * r.d[i];\n"
    "    t.scale = size < 2e9f * inverse ? size / inverse : 0.0f;                 // 0: infinitely far\n"
    "    t.reach = 5.0f * (1.0f - size / LIGHTPROBE_VALUE(r.luminance)) + 0.001f; // beyond a texel\n"
    "    t.ee = t.ff = t.ef = t.e = t.f = t.squares = t.own = 0.0f;\n"
    "    return t;\n"
    "}\n"
    "\n"
    "LIGHTPROBE_SHARED lightprobe_tilt lightprobe_add_tilt(lightprobe_tilt tilt, lightprobe_region r,\n"
    "                                                      lightprobe_leaf leaf)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE lightprobe_tilt t = tilt;\n"
    "    LIGHTPROBE_PRECISE float along = lightprobe_dot(leaf.direction, r.d), off = 1.0f - along;\n"
    "    if (!(off < t.reach && leaf.luminance > 0.0f && t.scale > 0.0f)) return t;\n"
    "    LIGHTPROBE_PRECISE float share = leaf.luminance / LIGHTPROBE_VALUE(r.luminance);\n"
    "    LIGHTPROBE_PRECISE float inside = 1.0f - off / t.reach;\n"
    "    LIGHTPROBE_PRECISE float part = (share < 1.0f ? share : 1.0f) * inside * inside;\n"
    "    LIGHTPROBE_PRECISE float mean = leaf.strength / leaf.luminance;\n"
    "    LIGHTPROBE_PRECISE float x = mean * lightprobe_dot(leaf.direction, r.e), sx = part * x;\n"
    "    LIGHTPROBE_PRECISE float y = mean * lightprobe_dot(leaf.direction, r.f), sy = part * y;\n"
    "    LIGHTPROBE_PRECISE float rest = leaf.inverse * t.scale;\n"
    "    rest = (rest < 4.0f ? rest : 4.0f) - mean * along;\n"
    "    t.own = t.own + part * (1.0f - mean * mean);\n"
    "    t.ee = t.ee + sx * x;\n"
    "    t.ff = t.ff + sy * y;\n"
    "    t.ef = t.ef + sx * y;\n"
    "    t.e = t.e + sx * rest;\n"
    "    t.f = t.f + sy * rest;\n"
    "    t.squares = t.squares + part * rest * rest;\n"
    "    return t;\n"
    "}\n"
    "\n"
    "// What a light has besides its leaves, before its direction is found; no narrower than its parts.\n"
    "// distance: of the light in the last frame.\n"
    "LIGHTPROBE_SHARED lightprobe_region lightprobe_add_late(lightprobe_region region,\n"
    "                                                        lightprobe_moments late, float longest,\n"
    "                                                        float distance)\n"
    "{\n"
    "    lightprobe_region r = region;\n"
    "    lightprobe_vec3 v;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        LIGHTPROBE_ADD(r.flux[i], late.flux[i]);\n"
    "        LIGHTPROBE_ADD(r.resultant[i], late.resultant[i]);\n"
    "        v[i] = LIGHTPROBE_VALUE(r.resultant[i]);\n"
    "    }\n"
    "    // It lies where the light did: leaves that are left of one that has given a lamp away are the\n"
    "    // wall behind. What is taken off lies as far as the leaves do.\n"
    "    float leaves = LIGHTPROBE_VALUE(r.luminance), more = lightprobe_luminance(late.flux);\n"
    "    LIGHTPROBE_PRECISE float inverse = distance > 0.0f ? more / distance : 0.0f;\n"
    "    if (more < 0.0f) inverse = LIGHTPROBE_VALUE(r.inverse) * (more / (leaves + 1e-30f));\n"
    "    LIGHTPROBE_ADD(r.inverse, inverse);\n"
    "    LIGHTPROBE_ADD(r.luminance, more);\n"
    "    LIGHTPROBE_PRECISE float most = longest * LIGHTPROBE_VALUE(r.luminance);\n"
    "    float size = lightprobe_length(v);\n"
    "    for (int i = 0; i < 3 && size > most; i++) {\n"
    "        LIGHTPROBE_PRECISE float off = v[i] * (most / size - 1.0f);\n"
    "        LIGHTPROBE_ADD(r.resultant[i], off);\n"
    "    }\n"
    "    return r;\n"
    "}\n"
    "\n"
    "// When all leaves have been added. jumps: nothing fades that the light has besides them.\n"
    "LIGHTPROBE_SHARED lightprobe_region lightprobe_direct(lightprobe_region region,\n"
    "                                                      lightprobe_cluster c, int jumps)\n"
    "{\n"
    "    lightprobe_region r = region;\n"
    "    if (jumps == 0) r = lightprobe_add_late(r, c.late, c.longest, c.distance);\n"
    "    for (int i = 0; i < 3; i++) r.d[i] = LIGHTPROBE_VALUE(r.resultant[i]);\n"
    "    // Light from all around has no direction: any will do.\n"
    "    float size = lightprobe_normalize(r.d);\n"
    "    if (size < 1e-36f) lightprobe_normalize(r.d); // the length of denormal numbers has few digits\n"
    "    for (int i = 0; i < 3 && size <= 1e-9f * LIGHTPROBE_VALUE(r.luminance); i++)\n"
    "        r.d[i] = i == 1 ? 1.0f : 0.0f;\n"
    "    lightprobe_frame(r.d, r.e, r.f);\n"
    "    if (jumps != 0) return r;\n"
    "    LIGHTPROBE_ADD(r.second[0], lightprobe_product(c.late.second, r.e, r.e));\n"
    "    LIGHTPROBE_ADD(r.second[1], lightprobe_product(c.late.second, r.f, r.f));\n"
    "    LIGHTPROBE_ADD(r.second[2], lightprobe_product(c.late.second, r.e, r.f));\n"
    "    return r;\n"
    "}\n"
    "\n"
    "// Of a sum over texels, which has been scaled so that it does not overflow; what it stands for may.\n"
    "LIGHTPROBE_SHARED float lightprobe_unscaled(float sum)\n"
    "{\n"
    "    return sum < FLT_MAX * LIGHTPROBE_SCALE ? sum / LIGHTPROBE_SCALE : FLT_MAX;\n"
    "}\n"
    "\n"
    "// Half-size d of the uniform distribution with this variance of the sine, d^2 / 3 (4.1.2: d / 3).\n"
    "LIGHTPROBE_SHARED float lightprobe_half_size(float variance)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE float sine2 = 3.0f * variance;\n"
    "    LIGHTPROBE_PRECISE float rest = 1.0f - sine2;\n"
    "    if (17.0f * sine2 >= 16.0f) return 4.0f;\n"
    "    return sqrtf(sine2 > 0.0f ? sine2 / rest : 0.0f);\n"
    "}\n"
    "\n"
    "// Long, as GLSL has no pointers to hand parts of a light on with.\n"
    "LIGHTPROBE_SHARED lightprobe_light lightprobe_light_of(lightprobe_region r)\n"
    "{\n"
    "    float luminance = LIGHTPROBE_VALUE(r.luminance);\n"
    "    lightprobe_vec3 resultant;\n"
    "    for (int i = 0; i < 3; i++) resultant[i] = LIGHTPROBE_VALUE(r.resultant[i]);\n"
    "    // Principal axes of the second moments in the plane across d.\n"
    "    LIGHTPROBE_PRECISE float a = LIGHTPROBE_VALUE(r.second[0]) / luminance;\n"
    "    LIGHTPROBE_PRECISE float c = LIGHTPROBE_VALUE(r.second[1]) / luminance;\n"
    "    LIGHTPROBE_PRECISE float b = LIGHTPROBE_VALUE(r.second[2]) / luminance;\n"
    "    LIGHTPROBE_PRECISE float middle = 0.5f * (a + c);\n"
    "    LIGHTPROBE_PRECISE float half_apart = 0.5f * (a - c);\n"
    "    // Over the larger of the two: squares of what is left by rounding would underflow.\n"
    "    float most = fabsf(half_apart) > fabsf(b) ? fabsf(half_apart) : fabsf(b);\n"
    "    LIGHTPROBE_PRECISE float x = most > 0.0f ? half_apart / most : 1.0f;\n"
    "    LIGHTPROBE_PRECISE float y = most > 0.0f ? fabsf(b) / most : 0.0f;\n"
    "    LIGHTPROBE_PRECISE float root = sqrtf(x * x + y * y);\n"
    "    LIGHTPROBE_PRECISE float wide = most * root;\n"
    "    // Cosine and sine of the angle from e to u, from those of its double: the larger is a root.\n"
    "    LIGHTPROBE_PRECISE float larger = sqrtf(0.5f + 0.5f * (fabsf(x) / root));\n"
    "    LIGHTPROBE_PRECISE float smaller = 0.5f * (y / root) / larger;\n"
    "    float cosine = x < 0.0f ? smaller : larger;\n"
    "    float sine = x < 0.0f ? larger : smaller;\n"
    "    sine = b < 0.0f ? -sine : sine;\n"
    "    // The disc whose mean direction is as long as the region's: R = (1 + cos alpha) / 2.\n"
    "    LIGHTPROBE_PRECISE float cos_alpha =\n"
    "        1.0f - 2.0f * ((luminance - lightprobe_length(resultant)) / luminance);\n"
    "    lightprobe_light light;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        LIGHTPROBE_PRECISE float u = cosine * r.e[i] + sine * r.f[i];\n"
    "        LIGHTPROBE_PRECISE float v = cosine * r.f[i] - sine * r.e[i];\n"
    "        light.direction[i] = r.d[i];\n"
    "        light.axis_u[i] = u;\n"
    "        light.axis_v[i] = v;\n"
    "        light.irradiance[i] = lightprobe_unscaled(LIGHTPROBE_VALUE(r.flux[i]));\n"
    "    }\n"
    "    light.tan_half_u = lightprobe_half_size(middle + wide);\n"
    "    light.tan_half_v = lightprobe_half_size(middle - wide);\n"
    "    light.solid_angle = LIGHTPROBE_VALUE(r.solid_angle) / LIGHTPROBE_SCALE;\n"
    "    light.cos_alpha = cos_alpha < 1.0f ? cos_alpha : 1.0f;\n"
    "    light.id = -1;\n"
    "    // What shifts it for a receiver is 1 / distance, so that is averaged. 0 beyond 1e9.\n"
    "    float inverse = LIGHTPROBE_VALUE(r.inverse);\n"
    "    LIGHTPROBE_PRECISE float distance = luminance / inverse;\n"
    "    light.distance = inverse > 0.0f && distance <= 1e9f ? distance : 0.0f;\n"
    "    for (int i = 0; i < 18; i++) light.state[i] = 0.0f;\n"
    "    light.slope_u = light.slope_v = 0.0f;\n"
    "    return light;\n"
    "}\n"
    "\n"
    "// Leaves are divided as a probe turns, so half of what changes a light's sizes comes late: the less\n"
    "// the more its flux has changed, or a sun that gains a texel would be bright before it is wide; and\n"
    "// 1 - cosine changes by at most a tenth, or a texel. And the axes of a round light may be any: the\n"
    "// least change of its leaves would turn its rectangle by up to 45 degrees. So they go only part of\n"
    "// the way from axis_u in the last frame (0: there was none), all of it where squares of the sizes\n"
    "// are as 5 to 3. Quarter turns are the same rectangle. side: of the map's faces.\n"
    "LIGHTPROBE_SHARED lightprobe_light lightprobe_steadied(lightprobe_light light, lightprobe_cluster c,\n"
    "                                                       float pace, float side)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE lightprobe_light l = light;\n"
    "    if (!(pace > 0.0f)) return l;\n"
    "    float flux = lightprobe_luminance(c.now.flux), past = lightprobe_luminance(c.past.flux);\n"
    "    LIGHTPROBE_PRECISE float held = (LIGHTPROBE_LATE * past - 10.0f * fabsf(flux - past)) / pace;\n"
    "    held = held > 0.0f ? held / past : 0.0f;\n"
    "    LIGHTPROBE_PRECISE float wide = 1.0f - l.cos_alpha;\n"
    "    LIGHTPROBE_PRECISE float now = wide + held * (c.sizes[2] - wide) + 1e-7f;\n"
    "    LIGHTPROBE_PRECISE float up = 1.0f + LIGHTPROBE_WIDEN * pace, texel = 2.0f / (side * side);\n"
    "    LIGHTPROBE_PRECISE float least = c.sizes[2] / up - texel, most = c.sizes[2] * up + texel;\n"
    "    float to = now < least ? least : now > most ? most : now;\n"
    "    l.cos_alpha = 1.0f - to;\n"
    "    LIGHTPROBE_PRECISE float a = lightprobe_variance(l.tan_half_u);\n"
    "    LIGHTPROBE_PRECISE float b = lightprobe_variance(l.tan_half_v);\n"
    "    a = (a + held * (c.sizes[0] - a)) * (to / now);\n"
    "    b = (b + held * (c.sizes[1] - b)) * (to / now);\n"
    "    LIGHTPROBE_PRECISE float cosine = lightprobe_dot(c.across, l.axis_u);\n"
    "    LIGHTPROBE_PRECISE float sine = lightprobe_dot(c.across, l.axis_v);\n"
    "    LIGHTPROBE_PRECISE float x = fabsf(cosine) > fabsf(sine) ? cosine : sine;\n"
    "    LIGHTPROBE_PRECISE float y = fabsf(cosine) > fabsf(sine) ? sine : -cosine;\n"
    "    LIGHTPROBE_PRECISE float part = pace * (a - b) / (LIGHTPROBE_ROUND * (a + b) + 1e-30f);\n"
    "    y = part < 1.0f && fabsf(x) > 0.1f ? (1.0f - part) * (y / x) : 0.0f;\n"
    "    x = 1.0f / sqrtf(1.0f + y * y);\n"
    "    y = y * x;\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        LIGHTPROBE_PRECISE float u = light.axis_u[i], v = light.axis_v[i];\n"
    "        l.axis_u[i] = x * u + y * v;\n"
    "        l.axis_v[i] = x * v - y * u;\n"
    "    }\n"
    "    LIGHTPROBE_PRECISE float along = a * x * x + b * y * y, across = a * y * y + b * x * x;\n"
    "    l.tan_half_u = lightprobe_half_size(along);\n"
    "    l.tan_half_v = lightprobe_half_size(across < along ? across : along); // rounding apart\n"
    "    return l;\n"
    "}\n"
    "\n"
    "// Slopes of a light's plane: 1 / distance is linear on it, and so are the leaves' means. Where they\n"
    "// lie in a row, along a tube say, a dim wall beside it, a thousandth of its light, would tell the\n"
    "// slope across: to squares that are less than a tenth of the leaves' own (or their rounding), so\n"
    "// much is added. Counts from 80% explained on, fully from 97%, of discs up to 29 degrees, less and\n"
    "// less up to 41; an edge is at most 25% nearer than the middle.\n"
    "LIGHTPROBE_SHARED lightprobe_light lightprobe_tilted(lightprobe_light light, lightprobe_region r,\n"
    "                                                     lightprobe_tilt t)\n"
    "{\n"
    "    lightprobe_light l = light;\n"
    "    LIGHTPROBE_PRECISE float least = 0.1f * t.own + 1e-6f * (t.ee + t.ff) + 1e-30f;\n"
    "    LIGHTPROBE_PRECISE float across = (t.ee * t.ff - t.ef * t.ef) / (t.ee + t.ff + 1e-30f);\n"
    "    LIGHTPROBE_PRECISE float ridge = least / ((across > 0.0f ? across : 0.0f) + least) * least;\n"
    "    LIGHTPROBE_PRECISE float ee = t.ee + ridge, ff = t.ff + ridge;\n"
    "    LIGHTPROBE_PRECISE float whole = ee * ff - t.ef * t.ef + 1e-30f;\n"
    "    if (!(l.distance > 0.0f)) return l;\n"
    "    LIGHTPROBE_PRECISE float x = (t.e * ff - t.f * t.ef) / whole;\n"
    "    LIGHTPROBE_PRECISE float y = (t.f * ee - t.e * t.ef) / whole;\n"
    "    LIGHTPROBE_PRECISE float explained = x * t.e + y * t.f + ridge * (x * x + y * y);\n"
    "    LIGHTPROBE_PRECISE float part = 6.0f * (explained / (t.squares + 1e-30f)) - 4.8f;\n"
    "    LIGHTPROBE_PRECISE float narrow = 8.0f * l.cos_alpha - 6.0f; // wide ones are often two things\n"
    "    part = part > 0.0f ? (part < 1.0f ? part : 1.0f) : 0.0f;\n"
    "    part = part * (narrow > 0.0f ? (narrow < 1.0f ? narrow : 1.0f) : 0.0f);\n"
    "    LIGHTPROBE_PRECISE float u =\n"
    "        x * lightprobe_dot(r.e, l.axis_u) + y * lightprobe_dot(r.f, l.axis_u);\n"
    "    LIGHTPROBE_PRECISE float v =\n"
    "        x * lightprobe_dot(r.e, l.axis_v) + y * lightprobe_dot(r.f, l.axis_v);\n"
    "    float wide = 0.10416667f; // slopes are at most 2.4\n"
    "    LIGHTPROBE_PRECISE float edge = fabsf(u) * (l.tan_half_u > wide ? l.tan_half_u : wide);\n"
    "    edge = edge + fabsf(v) * (l.tan_half_v > wide ? l.tan_half_v : wide);\n"
    "    part = part * edge > 0.25f ? 0.25f / edge : part;\n"
    "    l.slope_u = -part * u;\n"
    "    l.slope_v = -part * v;\n"
    "    return l;\n"
    "}\n"
    "\n"
    "// What the next frame goes on from. pace: frames that the seed goes on its way; 0 where it is new.\n"
    "LIGHTPROBE_SHARED lightprobe_light lightprobe_carry_on(lightprobe_light light, lightprobe_cluster c,\n"
    "                                                       float pace, float fading, float total)\n"
    "{\n"
    "    LIGHTPROBE_PRECISE lightprobe_light l = light;\n"
    "    float luminance = lightprobe_luminance(c.now.flux);\n"
    "    l.distance = luminance > 0.0f ? l.distance : c.distance; // it fades out where it was\n"
    "    // Leaves that change hands would tilt it at once.\n"
    "    LIGHTPROBE_PRECISE float u = lightprobe_dot(c.slopes, l.axis_u);\n"
    "    LIGHTPROBE_PRECISE float v = lightprobe_dot(c.slopes, l.axis_v);\n"
    "    LIGHTPROBE_PRECISE float go = luminance > 0.0f ? LIGHTPROBE_RATE * pace : 0.0f;\n"
    "    LIGHTPROBE_PRECISE float turn = luminance > 0.0f ? LIGHTPROBE_TURN * pace : 0.0f;\n"
    "    turn = pace > 0.0f && turn < 1.0f ? turn : 1.0f;\n"
    "    l.slope_u = u + turn * (l.slope_u - u);\n"
    "    l.slope_v = v + turn * (l.slope_v - v);\n"
    "    lightprobe_vec3 seed;\n"
    "    lightprobe_normalize(c.now.resultant);\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        LIGHTPROBE_PRECISE float moved = c.seed[i] + go * (c.now.resultant[i] - c.seed[i]);\n"
    "        seed[i] = moved;\n"
    "    }\n"
    "    lightprobe_normalize(seed);\n"
    "    LIGHTPROBE_PRECISE float tone = c.seed_tone, share = c.seed_share;\n"
    "    if (go > 0.0f) tone = tone + go * (c.now.tones / luminance - tone);\n"
    "    share = share + go * (luminance / total - share);\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        l.state[i] = seed[i];\n"
    "        l.state[6 + i] = c.late.flux[i] / total;\n"
    "        l.state[9 + i] = c.late.resultant[i] / total;\n"
    "        l.state[12 + i] = c.late.second[i] / total;\n"
    "        l.state[15 + i] = c.late.second[3 + i] / total;\n"
    "    }\n"
    "    l.state[3] = tone;\n"
    "    l.state[4] = c.lives != 0 ? share : -1.0f;\n"
    "    l.state[5] = fading;\n"
    "    return l;\n"
    "}\n"
    "\n"
    "// Of a cluster and the region of all that it takes.\n"
    "LIGHTPROBE_SHARED lightprobe_light lightprobe_make_light(int k,\n"
    "                                                         lightprobe_region region)\n"
    "{\n"
    "    float pace = jumps != 0 || clusters[k].id < 0 ? 0.0f : pace;\n"
    "    lightprobe_tilt tilt = lightprobe_no_tilt(region);\n"
    "    for (int i = 0; i < leaf_count && distances != 0; i++)\n"
    "        tilt = lightprobe_add_tilt(tilt, region, leaves[i]);\n"
    "    lightprobe_light light = lightprobe_light_of(region);\n"
    "    light = lightprobe_steadied(light, clusters[k], pace, LIGHTPROBE_FLOAT(side));\n"
    "    light = lightprobe_tilted(light, region, tilt);\n"
    "    return lightprobe_carry_on(light, clusters[k], pace, fading, total);\n"
    "}\n"
    // [glsl text end]
        ;
}
#endif

#if defined __GNUC__
#pragma GCC diagnostic pop
#endif

#ifdef __cplusplus
}
#endif

#if defined LIGHTPROBE__PRECISE_MATH && defined __clang__
#pragma float_control(pop)
#elif defined LIGHTPROBE__PRECISE_MATH
#pragma GCC pop_options
#endif

#endif // LIGHTPROBE_IMPLEMENTATION
