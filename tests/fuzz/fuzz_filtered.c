// Filtered maps and translucent layers: any depth, moments, radius, light, settings and points.
// Bounds stay in range, failures change nothing, and nothing is read or written beyond the memory
// that mssm_filtered_bytes asked for.
//     make fuzz FUZZ=filtered
#include "fuzz_light.h"

// Memory for a map, of exactly the size asked for behind an offset.
typedef struct block {
    char *memory;
    size_t bytes, offset;
} block;

static block make_block(fuzz_input *in, size_t bytes)
{
    block b = {NULL, bytes, (size_t)fuzz_int(in, 0, 15)};
    b.memory = (char *)fuzz_allocate(bytes + b.offset);
    return b;
}

// NULL where the arguments are out of range.
static mssm_filtered *make_map(const block *b, int side, int moments)
{
    mssm_filtered *map = NULL;
    const int good = side > 0 && (moments == 4 || moments == 6);
    char *at = b->memory + b->offset;
    const mssm_result r =
        mssm_filtered_init(&map, at, b->bytes > 0 ? b->bytes - 1 : 0, side, moments);
    EXPECT(r == (good ? MSSM_ERROR_MEMORY : MSSM_ERROR_ARGUMENT) && !map, "side %d, %d moments",
           side, moments);
    EXPECT((mssm_filtered_init(&map, at, b->bytes, side, moments) == MSSM_OK) == good,
           "side %d, %d moments", side, moments);
    EXPECT((map != NULL) == good, "side %d, %d moments", side, moments);
    return map;
}

// Depths or moments, the latter into a map of soft shadows too. Whether the map holds depths now.
static int update(fuzz_input *in, const block *b, mssm_filtered *map, mssm_map *soft, int side,
                  int moments, int held_depths)
{
    const int from_depth = fuzz_byte(in) & 1;
    const int samples = fuzz_byte(in) & 7 ? fuzz_int(in, 0, 5) : fuzz_int(in, 63, 65);
    const int radius = fuzz_byte(in) & 7 ? fuzz_int(in, -1, 4) : fuzz_int(in, 31, 33);
    const int count = side * side * (from_depth ? (samples > 0 ? samples : 1) : moments);
    const int good =
        radius >= 0 && radius <= 32 && (!from_depth || (samples >= 1 && samples <= 64));
    float *values = make_depth(in, count, fuzz_int(in, 1, 16));
    char *before = (char *)fuzz_allocate(b->bytes);
    memcpy(before, b->memory + b->offset, b->bytes);
    if (!from_depth) EXPECT(!mssm_map_update_moments(soft, values), "soft shadows");
    const mssm_result r = from_depth ? mssm_filtered_update(map, values, samples, radius)
                                     : mssm_filtered_update_moments(map, values, radius);
    EXPECT((r == MSSM_OK) == good, "%d samples, radius %d: %s", samples, radius,
           mssm_result_string(r));
    EXPECT(!r || !memcmp(before, b->memory + b->offset, b->bytes), "a failure has changed the map");
    free(before);
    free(values);
    return r ? held_depths : from_depth;
}

static void check_point(fuzz_input *in, const mssm_filtered *map, const mssm_map *soft,
                        const mssm_light *light, int of_depths)
{
    mssm_filter f = {0, 0, 0};
    float p[3];
    for (int i = 0; i < 3; i++) p[i] = fuzz_byte(in) & 3 ? fuzz_tame(in, 4) : fuzz_float(in);
    if (fuzz_byte(in) & 1) f.moment_bias = fuzz_float(in);
    if (fuzz_byte(in) & 1) f.depth_bias = fuzz_float(in);
    if (fuzz_byte(in) & 1) f.full_shadow = fuzz_float(in);
    const mssm_filter *filter = fuzz_byte(in) & 1 ? &f : NULL;
    const float x = fuzz_float(in), y = fuzz_float(in), width = fuzz_float(in);
    const mssm_bounds b = mssm_filtered_bounds(map, light, filter, p, width);
    EXPECT(b.lower >= 0 && b.lower <= b.upper && b.upper <= 1, "bounds %a %a", (double)b.lower,
           (double)b.upper);
    const float v = mssm_filtered_visibility(map, light, filter, p, width);
    EXPECT(v == b.upper, "visibility %a, upper bound %a", (double)v, (double)b.upper);
    const float s = mssm_map_visibility(soft, light, NULL, p);
    EXPECT(s >= 0 && s <= 1, "soft visibility %a", (double)s);
    check_moments(mssm_filtered_moments(map, x, y, width), of_depths);
}

// Layers of any depth and opacity over nothing.
static void check_layers(fuzz_input *in)
{
    mssm_moments4 four = mssm_moments4_of_depth(1);
    mssm_moments6 six = mssm_moments6_of_depth(1);
    for (int i = fuzz_int(in, 0, 5); i > 0; i--) {
        const float z = fuzz_unit(in), opacity = fuzz_float(in);
        four = mssm_moments4_blend(four, z, opacity);
        six = mssm_moments6_blend(six, z, opacity);
    }
    check_moments(six, 1);
    for (int k = 0; k < 4; k++)
        EXPECT(fabsf(four.b[k] - six.b[k]) < 1e-6f, "moment %d is %a of four", k + 1,
               (double)four.b[k]);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_input in = {data, size};
    const int side = fuzz_byte(&in) & 7 ? fuzz_int(&in, 0, 24) : fuzz_int(&in, -1, 70);
    const int moments = fuzz_byte(&in) & 15 ? 4 + 2 * fuzz_int(&in, 0, 1) : fuzz_int(&in, 3, 7);
    const block b = make_block(&in, mssm_filtered_bytes(side, moments));
    const block soft_block = make_block(&in, mssm_map_bytes(side, moments));
    mssm_filtered *map = make_map(&b, side, moments);
    mssm_map *soft = NULL;
    int of_depths = 1;
    if (map)
        mssm_map_init(&soft, soft_block.memory + soft_block.offset, soft_block.bytes, side,
                      moments);
    while (map && in.left > 0) {
        mssm_light light;
        of_depths = update(&in, &b, map, soft, side, moments, of_depths);
        check_layers(&in);
        for (int k = fuzz_int(&in, 1, 3); k > 0; k--) {
            if (make_light(&in, &light)) continue;
            for (int i = fuzz_int(&in, 1, 6); i > 0; i--)
                check_point(&in, map, soft, &light, of_depths);
        }
    }
    free(b.memory);
    free(soft_block.memory);
    return 0;
}
