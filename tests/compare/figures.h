// What the comparison measured: one line of docs/accuracy.csv a figure. measure.c writes them,
// charts, tables and claims read them.
#ifndef FIGURES_H
#define FIGURES_H

#include <stdbool.h>
#include <stdio.h>

enum { FIGURE_NAME = 48 };

// experiment,scene,method,x,metric,value,low,high
// value is a median (or the one value there is), low and high its spread (equal to it without one;
// the file then leaves them out).
typedef struct figure {
    char experiment[FIGURE_NAME]; // see the list below
    char scene[FIGURE_NAME];      // "all" for means over scenes
    char method[FIGURE_NAME];
    double x; // what the experiment sweeps
    char metric[FIGURE_NAME];
    double value, low, high;
} figure;

// experiment  x                           metrics
// error       tangent of the half-angle   rms                    some methods, every scene and light size
//                                         scene "all": means over scenes of all methods
// speed       tangent                     ns                     scene "all"
// overall     0                           means over all scenes and light sizes: rms ns, bias
//                                         (texels; of rivals), step_rms
// new         tangent                     rms                    scenes that reviewers made up;
//                                         x 0, scene "all": mean over them
// unseen      the same                    of scenes made after all tuning
// eye         0                           falling_rows (%) deepest_fall (rows outwards over the shadow of
//                                         one box, against the truth), structure (rms of the difference
//                                         between the errors of receivers a texel apart), flip (mean of two
//                                         pictures); scene "all"
// kernel      widest kernel, texels       ns
// side        side of the map             rms ns update_ms bytes
// temporal    tangent                     step_rms               method "truth": the truth's own step
// setting     0                           rms ns                 method: name of the setting, the
//                                         first one "default"; scene "all"
// lights      number of lights            irradiance_rms picture_rms (% of the mean), found (lights),
//                                         ms (extraction); scene: probe; methods "largest error
//                                         first", "median cut", "point lights", ...
// edges       number of lights            blocked_rms (irradiance behind straight edges, % of the mean);
//                                         scene: probe; methods as for lights, "one sun and ambient"
// weak        min_shadow                  maps (of 32) blocked_rms picture_rms; scene: probe
// tolerance   tolerance, 0: 64 lights     lights picture_rms shade_ns; scene: probe
// array       0                           ns, methods "6 moments, arrays, mssm.h" or "published";
//                                         speedup, "6 moments, arrays"; scene: how it was compiled,
//                                         "as built" or "vectorised"
// bandwidth   side                        update_gbs copy_gbs share
// hard        radius of a Gaussian        rms (against rays) shaded_rms (each receiver weighted by
//                                         its cosine to the light) pcf_rms (against percentage-closer
//                                         filtering) leak (visibility where all rays are blocked)
//                                         false_shadow (occlusion where none is) ns update_ms, bias
//                                         (texels; of rivals); scene "all"
// hard_scene  radius of a Gaussian        rms                    every scene, one radius
// picture     threads                     seconds lights         scene: size; methods "all" (from
//                                         probe to picture) and "shading"
// truth       as in the experiment        noise noise_most       method: the experiment; scene "all"
// gl          lights                      shade_ms frame_ms update_ms bytes reads dispatches, rms (% of the
//                                         mean, whole picture, against rays; method "truth": the error
//                                         of the rays), flip (the pictures as shown), bias (texels; of
//                                         rivals)
// gl_bias     bias in texels              rms
// gl_kernel   widest kernel, texels       shade_ms

typedef struct figures {
    figure *list;
    int count, room;
} figures;

// Convolution soft shadows with 4, 8 and 16 terms, 4M + 1 values a texel: the first two as Kneiphof
// counts the values of a filter, the last with the most terms of Annen's pictures. PCSS and ways of
// filtering in OpenGL.
#define CSSM8 "CSSM8, 17 values"
#define CSSM16 "CSSM16, 33 values"
#define CSSM_ANNEN "CSSM M=16, 65 values"
#define LAYERED_HORIZON "layered, 6 moments, horizon"
#define PCSS_TAPS "PCSS, 27 x 27 taps"
#define PCSS_GATHER "PCSS, textureGather"
#define PCSS_POISSON "PCSS, 16 Poisson samples"
#define PCSS_GATHER_NORMAL PCSS_GATHER ", normal"
#define PCSS_POISSON_NORMAL PCSS_POISSON ", normal"
#define PCSS_MORE "PCSS, 32 Poisson samples"
#define PCSS_MORE_NORMAL PCSS_MORE ", normal"
#define CSSM_TABLES ", tables"
#define CSSM_MIPS ", mip maps"

// False when memory runs out, for a name that is too long and for a number that is not finite.
bool figures_add(figures *f, const char *experiment, const char *scene, const char *method,
                 double x, const char *metric, double value, double low, double high);
// The only figure with all of that, or NULL. x is compared to 1e-6 relative.
const figure *figures_find(const figures *f, const char *experiment, const char *scene,
                           const char *method, double x, const char *metric);
bool figures_save(const figures *f, const char *path);
// Replaces f. False, with a message on stderr naming the line, for a file that is not one of these.
bool figures_load(figures *f, const char *path);
void figures_free(figures *f);

#endif
