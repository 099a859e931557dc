// What the fuzzers of mssm.h share: its implementation, depth maps, lights and what moments may be.
#ifndef FUZZ_LIGHT_H
#define FUZZ_LIGHT_H

#include "fuzz.h"

#define MSSM_IMPLEMENTATION
#define MSSM_NO_GL
#include "../../mssm.h"

// A depth map of exactly count values: a few from the input, over and over.
static inline float *make_depth(fuzz_input *in, int count, int some)
{
    float *depth = (float *)fuzz_allocate((size_t)count * sizeof(float)), value[16];
    const int kind = fuzz_int(in, 0, 3);
    for (int i = 0; i < some; i++) value[i] = kind == 0 ? fuzz_float(in) : fuzz_unit(in);
    for (int i = 0; i < count; i++) {
        // A flat map, bands, or scattered.
        const int at = kind == 1   ? 0
                       : kind == 2 ? i * some / count
                                   : (int)((unsigned)i * 2654435761u >> 24);
        depth[i] = value[at % some];
    }
    return depth;
}

static inline mssm_result make_light(fuzz_input *in, mssm_light *light)
{
    float a[3], direction[3], axis[3], b[3], n[5];
    const int kind = fuzz_int(in, 0, 7);
    memset(light, 0, sizeof *light);
    for (int i = 0; i < 3; i++) {
        direction[i] = kind & 1 ? fuzz_unit(in) : fuzz_float(in);
        axis[i] = kind & 1 ? fuzz_unit(in) : fuzz_float(in);
        a[i] = kind & 1 ? fuzz_tame(in, 3) : fuzz_float(in);
        b[i] = kind & 1 ? a[i] + fabsf(fuzz_tame(in, 3)) : fuzz_float(in);
    }
    for (int i = 0; i < 5; i++) n[i] = fabsf(kind & 1 ? fuzz_unit(in) : fuzz_float(in));
    if (kind < 3) return mssm_light_directional(light, direction, axis, n[0], n[1], a, b);
    if (kind < 6)
        return mssm_light_spot(light, a, direction, axis, n[0], n[1], n[1] + 9 * n[2], n[3], n[4]);
    // By hand, anything.
    for (int i = 0; i < 16; i++) light->world_to_shadow[i] = fuzz_float(in);
    light->perspective = fuzz_int(in, -1, 2);
    light->half_u = fuzz_float(in);
    light->half_v = fuzz_float(in);
    light->extent_u = fuzz_float(in);
    light->extent_v = fuzz_float(in);
    light->z_near = fuzz_float(in);
    light->z_far = fuzz_float(in);
    return MSSM_OK;
}

// Of depths; moments of one's own may be those of none, but Chebyshev ones are in [-1,1] all the
// same.
static inline void check_moments(mssm_moments6 m, int of_depths)
{
    for (int k = 0; k < 6; k++) {
        const float least = of_depths && k & 1 ? 0.0f : -1.0f;
        EXPECT(m.b[k] >= least - 1e-5f && m.b[k] <= 1.00001f, "moment %d is %a", k + 1,
               (double)m.b[k]);
    }
}

#endif
