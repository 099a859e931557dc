// What the methods are compared on: scenes of triangles and lights, with the truth by ray tracing.
// Each scene was made to hurt somebody.
#ifndef CASES_H
#define CASES_H

#include <stdint.h>

#include "../../examples/common/raytrace.h"
#include "methods.h"

typedef struct compare_case {
    char name[48];
    scene scene; // the casters, which receive too
    bvh *tree;
    vec3 sun;     // unit, towards the light
    bool closed;  // every part is a closed surface: back faces may be averaged
    float ground; // height of a plane that receives but is in no depth map; NAN: there is none
    int moving;   // the object that moves and therefore receives nothing; -1: there is none
} compare_case;

// The chart's own scenes; those that reviewers made up to find its faults; and those that were made
// after all tuning, whose figures are reported apart.
enum {
    CASE_COUNT = 14,
    CASE_NEW = 20,
    CASE_UNSEEN = 6,
    CASE_ALL = CASE_COUNT + CASE_NEW + CASE_UNSEEN
};
const char *case_group(int which); // "chart", "new", "unseen"
// Builds case number which; shared meshes come from that folder (NULL: where they are by default),
// and a case that needs one that is not there fails and says so.
bool case_make(compare_case *c, int which, const char *data, message *why);
// Any triangle mesh in OBJ format (v and f lines, +Y up, any unit) with a ground under it.
bool case_load(compare_case *c, const char *path, vec3 sun, message *why);
void case_free(compare_case *c);
// The case a little later: step 0 is case_make's; the sun or a caster moves by about a quarter
// texel of a 256^2 map a step.
bool case_make_step(compare_case *c, int which, int step, const char *data, message *why);

// A light of that size along the sun, fitted to the casters.
mssm_result case_light(const compare_case *c, float tan_half_u, float tan_half_v,
                       mssm_light *light);
// Depth maps of the case, one sample a texel; back may be NULL. False when memory runs out.
bool case_depth(const compare_case *c, const mssm_light *light, int side, float *front,
                float *back);

typedef struct receiver {
    vec3 point, normal;
    float truth, noise; // visibility by rays and the standard error of it
} receiver;

// Receivers drawn evenly from the surfaces (half of them from the ground, where there is one), of
// what can be seen from outside and has the whole light above its own horizon: a light that sinks
// below it is the shading's business, which clips it. Truth by about that many rays. On all cores.
// False where no surface is like that: some lights are too large for some scenes.
bool case_receivers(const compare_case *c, const mssm_light *light, int count, int rays,
                    uint64_t seed, receiver *out);
// The truth alone, for receivers that stay while the case moves on. Same seed, same pattern of
// rays.
void case_truth(const compare_case *c, const mssm_light *light, int count, int rays, uint64_t seed,
                receiver *receivers);
// The same for a light without size, seen through the Gaussian of methods.h over a map of that
// side: rays along the light from all over the receiver's tangent plane under the kernel. That is
// what percentage-closer filtering would give with endless texels and a bias that follows the
// surface.
void case_truth_filtered(const compare_case *c, const mssm_light *light, int side, int radius,
                         int count, int rays, uint64_t seed, receiver *receivers);

#endif
