#include "cascades.h"

#include <math.h>
#include <string.h>

// Texels that a map moves by at once: a multiple of what a texel of its coarser levels holds, so
// that these stay where they are in the world, too.
enum { STEP = 16 };

// One text for C and GLSL, which goes on with `rest`.
#define SHARED(name, rest, ...) static __VA_ARGS__ const char name[] = #__VA_ARGS__ rest;

// The share of the next map: 0 up to 3/4 of a map's end, 1 at its end.
// clang-format off
SHARED(cascades_glsl,
    "\nuniform vec3 cascades_eye;\n"
    "uniform float cascades_end[4];\n"
    "uniform int cascades_count;\n"
    "float cascades_visibility(vec3 position, vec3 normal)\n"
    "{\n"
    "    float far = distance(position, cascades_eye);\n"
    "    for (int i = 0; i < cascades_count; i++) {\n"
    "        if (far >= cascades_end[i]) continue;\n"
    "        float next = cascades_blend(far, cascades_end[i]);\n"
    "        float v = mssm_visibility(i, position, normal);\n"
    "        if (next == 0.0) return v;\n"
    "        return mix(v, i + 1 < cascades_count ? mssm_visibility(i + 1, position, normal) : 1.0, next);\n"
    "    }\n"
    "    return 1.0;\n"
    "}\n",
float cascades_blend(float far, float end) {
    float t = 4.0f * far / end - 3.0f;
    t = t < 0.0f ? 0.0f : (t < 1.0f ? t : 1.0f);
    return t * t * (3.0f - 2.0f * t);
})
// clang-format on

int cascades_choose(const cascades *c, const float point[3], float *next)
{
    const float far =
        hypotf(hypotf(point[0] - c->eye[0], point[1] - c->eye[1]), point[2] - c->eye[2]);
    for (int i = 0; i < c->desc.count; i++) {
        if (far >= c->end[i]) continue;
        *next = cascades_blend(far, c->end[i]);
        return i;
    }
    *next = 1;
    return c->desc.count - 1;
}

// Radius of the sphere around what the camera can see up to a map's end, and how far ahead its
// centre is.
static float sphere(const cascades_desc *desc, float end, float *ahead)
{
    const float widest = hypotf(desc->tan_x, desc->tan_y), secant = hypotf(1, widest);
    *ahead = end * (widest < 1 ? 0.5f * secant : 1 / secant);
    return end * (widest < 1 ? 0.5f * secant : widest / secant);
}

// A map holds that sphere, whichever way the camera looks, so that its texels keep their size; what
// blocks light from beside it; and room for its steps.
int cascades_create(cascades *c, const cascades_desc *desc)
{
    static const float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};
    mssm_light frame;
    if (desc->count < 1 || desc->count > CASCADES_MOST || desc->side < 4 * STEP ||
        !(desc->first > 1e-9f) || !(desc->farthest >= desc->first) || !(desc->height >= 0) ||
        !(desc->tan_x > 0) || !(desc->tan_y > 0) ||
        !(desc->farthest + desc->tan_x + desc->tan_y < 1e9f) ||
        !((1 + desc->tan_half_u + desc->tan_half_v) * desc->height < 1e9f) ||
        mssm_light_directional(&frame, desc->to_light, desc->axis_u, desc->tan_half_u,
                               desc->tan_half_v, low, high)) {
        return 0;
    }
    memset(c, 0, sizeof *c);
    c->desc = *desc;
    for (int i = 0; i < desc->count; i++) {
        const float end =
            desc->first * powf(desc->farthest / desc->first,
                               desc->count > 1 ? (float)i / (float)(desc->count - 1) : 1);
        float ahead;
        const float radius = sphere(desc, end, &ahead);
        const float room = 1 - (float)STEP / (float)desc->side;
        mssm_light *l = &c->light[i];
        *l = frame;
        l->extent_u = (radius + desc->tan_half_u * desc->height) / room;
        l->extent_v = (radius + desc->tan_half_v * desc->height) / room;
        // Casters from -0.99 to 0.8, as mssm_light_directional has them, and a sixteenth for the
        // steps.
        l->z_far = (2 * radius + desc->height) * (17.0f / 16) * (2 / 1.79f);
        for (int k = 0; k < 3; k++) {
            l->world_to_shadow[4 * k] *= frame.extent_u / l->extent_u;
            l->world_to_shadow[4 * k + 1] *= frame.extent_v / l->extent_v;
            l->world_to_shadow[4 * k + 2] *= frame.z_far / l->z_far;
        }
        l->world_to_shadow[14] = HUGE_VALF; // so that the first cascades_aim moves it
        c->end[i] = end;
    }
    return 1;
}

// What a row of the matrix gives for the centre, in steps.
static double steps(const float *row, const float centre[3], double step)
{
    return floor(
        ((double)row[0] * centre[0] + (double)row[4] * centre[1] + (double)row[8] * centre[2]) /
            step +
        0.5);
}

void cascades_aim(cascades *c, const float eye[3], const float looks_at[3])
{
    const float length = hypotf(hypotf(looks_at[0], looks_at[1]), looks_at[2]);
    c->moved = 0;
    for (int i = 0; i < c->desc.count; i++) {
        mssm_light *l = &c->light[i];
        float *m = l->world_to_shadow, before[3], centre[3], ahead;
        const float radius = sphere(&c->desc, c->end[i], &ahead);
        const double texels = 2.0 * STEP / c->desc.side;
        for (int k = 0; k < 3; k++)
            centre[k] = eye[k] + (length > 0 ? ahead * looks_at[k] / length : 0);
        memcpy(before, m + 12, sizeof before);
        m[12] = (float)(-texels * steps(m, centre, texels));
        m[13] = (float)(-texels * steps(m + 1, centre, texels));
        // Half a step of depth in front of the sphere and what stands before it.
        const double span = 1.79 * 16 / 17, half_step = span / 32;
        m[14] =
            (float)(-0.99 + half_step + 2 * ((double)radius + c->desc.height) / (double)l->z_far -
                    2 * half_step * steps(m + 2, centre, 2 * half_step));
        if (memcmp(before, m + 12, sizeof before)) c->moved |= 1u << i;
    }
    memcpy(c->eye, eye, sizeof c->eye);
}
