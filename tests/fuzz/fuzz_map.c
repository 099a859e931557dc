// Moment maps: any depth, samples, back faces, light, settings and points. Visibility and moments
// stay in range, the same question gets the same answer, and nothing is read or written beyond the
// memory that mssm_map_bytes asked for.
//     make fuzz FUZZ=map
#include "fuzz_light.h"

static mssm_settings make_settings(fuzz_input *in)
{
    mssm_settings s;
    s.moments = fuzz_int(in, 0, 7);
    s.estimator = (mssm_estimator)fuzz_int(in, 0, 3);
    s.moment_bias = fuzz_byte(in) & 1 ? 0 : fuzz_float(in);
    s.depth_bias = fuzz_byte(in) & 1 ? 0 : fuzz_float(in);
    s.max_kernel = fuzz_int(in, -2, 200);
    s.tolerance = fuzz_byte(in) & 1 ? 0 : fuzz_float(in);
    return s;
}

static void check_point(fuzz_input *in, const mssm_map *map, const mssm_light *light,
                        const mssm_settings *s)
{
    float p[3], shadow[3] = {7, 8, 9};
    for (int i = 0; i < 3; i++) p[i] = fuzz_byte(in) & 3 ? fuzz_tame(in, 4) : fuzz_float(in);
    if (!mssm_light_project(light, p, shadow))
        EXPECT(shadow[0] == 7 && shadow[1] == 8 && shadow[2] == 9, "output of a failed projection");
    else
        EXPECT(isfinite(shadow[0]) && isfinite(shadow[1]) && isfinite(shadow[2]),
               "shadow position");
    const float v = mssm_map_visibility(map, light, s, p);
    EXPECT(v >= 0 && v <= 1, "visibility %a", (double)v);
    const float again = mssm_map_visibility(map, light, s, p);
    EXPECT(v == again, "visibility %a, then %a", (double)v, (double)again);
    const float x = fuzz_float(in), y = fuzz_float(in), half_x = fuzz_float(in),
                half_y = fuzz_float(in);
    check_moments(mssm_map_moments(map, x, y, half_x, half_y), 1);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_input in = {data, size};
    const int small = fuzz_byte(&in) & 7,
              side = small ? fuzz_int(&in, 1, 24) : fuzz_int(&in, 1, 130);
    const int moments = fuzz_byte(&in) & 1 ? 4 : 6, offset = fuzz_int(&in, 0, 3);
    const size_t bytes = mssm_map_bytes(side, moments);
    char *memory = (char *)fuzz_allocate(bytes + (size_t)offset);
    mssm_map *map = NULL;
    EXPECT(mssm_map_init(&map, memory + offset, bytes - 1, side, moments) == MSSM_ERROR_MEMORY &&
               !map,
           "a byte too few");
    EXPECT(mssm_map_init(&map, memory + offset, bytes, side, moments) == MSSM_OK, "side %d", side);
    while (in.left > 0) {
        const int samples = fuzz_byte(&in) & 15 ? fuzz_int(&in, 1, 5) : fuzz_int(&in, 0, 65);
        const int count = side * side * (samples > 0 ? samples : 1), some = fuzz_int(&in, 1, 16);
        float *front = make_depth(&in, count, some);
        float *back = fuzz_byte(&in) & 1 ? make_depth(&in, count, some) : NULL;
        const mssm_result updated = mssm_map_update(map, front, back, samples);
        EXPECT((updated == MSSM_OK) == (samples >= 1 && samples <= 64), "%d samples", samples);
        free(front);
        free(back);
        mssm_light light;
        for (int k = fuzz_int(&in, 1, 3); k > 0; k--) {
            if (make_light(&in, &light)) continue;
            const mssm_settings s = make_settings(&in);
            for (int i = fuzz_int(&in, 1, 6); i > 0; i--)
                check_point(&in, map, &light, i & 1 ? &s : NULL);
        }
    }
    free(memory);
    return 0;
}
