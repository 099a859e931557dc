// Pictures of probes: any size, layout, channels and values, floats and halves. The cube has the
// picture's energy, nothing is negative or too large, nothing beyond the pixels is read, and a
// failure writes nothing. Then any lights are taken off: no texel grows, or loses more than they
// have.
//     make fuzz FUZZ=images
#include "fuzz.h"

#define LIGHTPROBE_IMPLEMENTATION
#define LIGHTPROBE_NO_GL
#include "../../lightprobe.h"

static double energy(const float *texels, int side, int channel)
{
    double sum = 0;
    for (int i = 0; i < 6 * side * side; i++)
        sum += (double)lightprobe_texel_solid_angle(side, i % side, i / side % side) *
               (double)texels[3 * i + channel];
    return sum;
}

// Pixels as floats; NULL where they are halves. Few values over a background.
static void *make_pixels(fuzz_input *in, size_t values, int half)
{
    const float background = fabsf(fuzz_unit(in));
    float *f = (float *)fuzz_allocate(values * (half ? sizeof(uint16_t) : sizeof(float)));
    uint16_t *h = (uint16_t *)(void *)f;
    for (size_t i = 0; i < values; i++) {
        if (half)
            h[i] = 0x3c00;
        else
            f[i] = background;
    }
    for (int k = fuzz_int(in, 0, 40); k > 0 && values > 0; k--) {
        const size_t at = (size_t)fuzz_int(in, 0, 65535) % values;
        if (half)
            h[at] = (uint16_t)fuzz_int(in, 0, 65535);
        else
            f[at] = fuzz_float(in);
    }
    return f;
}

static void check_lights(fuzz_input *in, const lightprobe_cube *cube)
{
    const size_t values = 18 * (size_t)cube->side * (size_t)cube->side;
    float *rest = (float *)fuzz_allocate(values * sizeof *rest);
    lightprobe_light lights[4];
    const int count = fuzz_int(in, 0, 4);
    for (int i = 0; i < count; i++) {
        float *at = (float *)(void *)&lights[i];
        const int tame = fuzz_byte(in) & 1;
        memset(&lights[i], 0, sizeof lights[i]);
        for (int k = 0; k < 16; k++) at[k] = tame ? fuzz_unit(in) : fuzz_float(in);
    }
    EXPECT(!lightprobe_cube_without(cube, lights, count, rest), "failed");
    for (size_t i = 0; i < values; i++)
        EXPECT(rest[i] >= 0 && rest[i] <= cube->face[0][i], "texel of %a became %a",
               (double)cube->face[0][i], (double)rest[i]);
    for (int c = 0; c < 3; c++) {
        const double before = energy(cube->face[0], cube->side, c),
                     after = energy(rest, cube->side, c);
        double most = 0;
        for (int i = 0; i < count; i++)
            most += lights[i].irradiance[c] > 0 ? (double)lights[i].irradiance[c] : 0;
        EXPECT(before - after <= most * 1.00001 + 1e-5 * before, "%g taken off for %g",
               before - after, most);
    }
    free(rest);
}

static void check_picture(fuzz_input *in)
{
    lightprobe_image im;
    lightprobe_cube cube;
    const int unit = fuzz_int(in, 1, 9), shape = fuzz_int(in, 0, 7);
    const int sizes[8][2] = {{2, 1}, {4, 3}, {3, 4}, {6, 1}, {1, 6}, {0, 0}, {0, 0}, {0, 0}};
    im.width = shape < 5 ? unit * sizes[shape][0] : fuzz_int(in, shape == 7 ? -1 : 1, 60);
    im.height = shape < 5 ? unit * sizes[shape][1] : fuzz_int(in, shape == 7 ? -1 : 1, 60);
    im.channels = fuzz_byte(in) & 15 ? 1 + 2 * (int)(fuzz_byte(in) & 1) : fuzz_int(in, 0, 5);
    im.layout =
        fuzz_byte(in) & 7 ? LIGHTPROBE_LAT_LONG * (int)(fuzz_byte(in) & 1) : fuzz_int(in, -1, 4);
    im.half = fuzz_byte(in) & 1;
    const int side = fuzz_byte(in) & 31 ? fuzz_int(in, 1, 9) : fuzz_int(in, -1, 20);
    const size_t pixels = im.width > 0 && im.height > 0 ? (size_t)im.width * (size_t)im.height : 0;
    const size_t texels = side > 0 ? 18 * (size_t)side * (size_t)side : 0;
    void *data = make_pixels(in, pixels * (size_t)(im.channels > 0 ? im.channels : 0), im.half);
    float *out = (float *)fuzz_allocate(texels * sizeof *out);
    int repaired = -7;
    im.texels = data;
    for (size_t i = 0; i < texels; i++) out[i] = -7;
    const lightprobe_result r = lightprobe_cube_from_image(&im, side, out, &cube, &repaired);
    if (r) {
        EXPECT(repaired == -7 && (texels == 0 || out[0] == -7), "a failure wrote something");
        EXPECT(side < 1 || lightprobe_image_side(&im) == 0 ||
                   (im.channels != 1 && im.channels != 3 && im.channels != 4),
               "refused: %s", lightprobe_result_string(r));
    } else {
        EXPECT(repaired >= 0 && (size_t)repaired <= pixels && lightprobe_image_side(&im) > 0,
               "%d repaired", repaired);
        for (size_t i = 0; i < texels; i++)
            EXPECT(out[i] >= 0 && out[i] <= FLT_MAX, "texel %a", (double)out[i]);
        const double pi = 3.14159265358979323846;
        double sum = 0, most = 65504;
        const lightprobe__picture p = {&im, 0, 0};
        for (int pass = 0; pass < 2; pass++) {
            for (size_t i = 0; i < pixels; i++) {
                float rgb[3];
                const int x = (int)i % im.width, y = (int)i / im.width;
                lightprobe__picture q = p;
                q.infinite = pass ? (float)most : 0;
                lightprobe__pixel(&q, x, y, rgb);
                for (int c = 0; c < 3 && !pass; c++) most = fmax(most, (double)rgb[c]);
                if (pass)
                    sum += 2 * pi / im.width *
                           (cos(pi * y / im.height) - cos(pi * (y + 1) / im.height)) *
                           (double)rgb[1];
            }
        }
        const int faces = im.layout != LIGHTPROBE_LAT_LONG && abs(im.width - 2 * im.height) > 1;
        EXPECT(faces || fabs(energy(out, side, 1) - sum) <= 2e-6 * sum + 1e-30,
               "energy %.9g for %.9g", energy(out, side, 1), sum);
        check_lights(in, &cube);
    }
    free(out);
    free(data);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_input in = {data, size};
    while (in.left > 0) check_picture(&in);
    return 0;
}
