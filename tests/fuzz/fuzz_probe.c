// Extraction of lights: probes of any size, channels and values, any settings, lights of any
// previous frame. Directions are unit, energy is that of the probe, bad texels are counted, nothing
// is read or written beyond what was handed over, and failures write nothing.
//     make fuzz FUZZ=probe
#include "fuzz.h"

#define LIGHTPROBE_IMPLEMENTATION
#define LIGHTPROBE_NO_GL
#include "../../lightprobe.h"

enum { MOST = 300 };

// Six faces, each in a block of exactly its size; a few values from the input scattered over a
// background.
static void make_faces(fuzz_input *in, lightprobe_cube *cube)
{
    const int count = cube->side * cube->side * (cube->channels > 0 ? cube->channels : 1);
    const float background = fuzz_byte(in) & 1 ? fabsf(fuzz_unit(in)) : 0;
    const int kind = fuzz_int(in, 0, 2), some = fuzz_int(in, 1, 30);
    const float scale = fuzz_byte(in) & 7 ? 1 : fabsf(fuzz_float(in));
    float *face[6];
    for (int f = 0; f < 6; f++) {
        cube->face[f] = face[f] = (float *)fuzz_allocate((size_t)count * sizeof(float));
        for (int i = 0; i < count; i++) face[f][i] = background;
    }
    for (int k = 0; k < some; k++) {
        const float value =
            kind == 0 ? fuzz_float(in) : fabsf(fuzz_unit(in)) * (kind == 1 ? 1 : scale);
        const int at = fuzz_int(in, 0, 65535) % count, f = fuzz_int(in, 0, 5);
        for (int i = at; i < count && i < at + (kind == 2 ? 3 * cube->side : 3); i++)
            face[f][i] = value;
    }
}

static lightprobe_settings make_settings(fuzz_input *in, const lightprobe_cube *cube,
                                         lightprobe_light *previous)
{
    lightprobe_settings s;
    memset(&s, 0, sizeof s);
    s.max_lights = fuzz_byte(in) & 1 ? fuzz_int(in, 0, 40) : fuzz_int(in, -1, MOST);
    s.tolerance = fuzz_byte(in) & 3 ? 0 : fuzz_float(in);
    s.min_share = fuzz_byte(in) & 3 ? 0 : fuzz_float(in);
    s.min_shadow = fuzz_byte(in) & 3 ? 0 : fuzz_float(in);
    s.mode = fuzz_byte(in) & 3 ? 0 : fuzz_int(in, -1, 2);
    if (cube->channels == 4) s.distances = (int)(fuzz_byte(in) % 3);
    if (fuzz_byte(in) & 1) return s;
    s.previous = previous;
    s.previous_count = fuzz_int(in, -1, 20);
    for (int i = 0; i < s.previous_count; i++) {
        float *at = (float *)(void *)&previous[i];
        const int tame = fuzz_byte(in) & 1;
        for (size_t k = 0; k < sizeof *previous / sizeof(float); k++)
            at[k] = tame ? fuzz_unit(in) : fuzz_float(in);
        previous[i].id = tame ? i * fuzz_int(in, 0, 9) : fuzz_int(in, -32768, 32767) * 65536;
    }
    return s;
}

// What the texels add up to, in double and with other formulas; counts the bad ones.
static int sum_of_probe(const lightprobe_cube *cube, double total[3])
{
    int bad = 0;
    total[0] = total[1] = total[2] = 0;
    for (int i = 0; i < 6 * cube->side * cube->side; i++) {
        const int x = i % cube->side, y = i / cube->side % cube->side,
                  f = i / (cube->side * cube->side);
        const float *texel = cube->face[f] + (size_t)(y * cube->side + x) * (size_t)cube->channels;
        const double omega = (double)lightprobe_texel_solid_angle(cube->side, x, y);
        int broken = 0;
        for (int c = 0; c < 3; c++) {
            if (isfinite(texel[c]) && texel[c] >= 0)
                total[c] += omega * (double)texel[c];
            else
                broken = 1;
        }
        bad += broken;
    }
    return bad;
}

static double dot(const float a[3], const float b[3])
{
    return (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] + (double)a[2] * (double)b[2];
}

static void check_light(const lightprobe_light *l, int paper, int previous)
{
    // The paper's rectangles lie in the plane of the face: their axes need not be orthogonal.
    const float *axes[3] = {l->direction, l->axis_u, l->axis_v};
    for (int i = 0; i < 3; i++) {
        EXPECT(fabs(dot(axes[i], axes[i]) - 1) < 1e-5, "axis %d of length^2 %.9g", i,
               dot(axes[i], axes[i]));
        EXPECT(fabs(dot(axes[i], axes[(i + 1) % 3])) < 1e-5 || (paper && i == 1), "axes %d", i);
        EXPECT(l->irradiance[i] >= 0 && l->irradiance[i] <= FLT_MAX, "irradiance %a",
               (double)l->irradiance[i]);
    }
    EXPECT(l->tan_half_u >= 0 && l->tan_half_u <= 4 && l->tan_half_v >= 0 && l->tan_half_v <= 4,
           "size %a %a", (double)l->tan_half_u, (double)l->tan_half_v);
    EXPECT(paper || l->tan_half_u >= l->tan_half_v, "size %a %a", (double)l->tan_half_u,
           (double)l->tan_half_v);
    EXPECT(previous || l->solid_angle > 0, "no solid angle"); // what fades out has none
    EXPECT(l->solid_angle >= 0 && l->solid_angle < 12.57f, "solid angle %a",
           (double)l->solid_angle);
    EXPECT(l->distance >= 0 && l->distance <= 1e9f, "distance %a", (double)l->distance);
    // 2.4 but where previous lights were made up.
    EXPECT(fabsf(l->slope_u) <= 20 && fabsf(l->slope_v) <= 20, "slopes %a %a", (double)l->slope_u,
           (double)l->slope_v);
    const float away = 0.7f * l->distance;
    const lightprobe_light seen = lightprobe_light_at(*l, away, -away, 0.1f);
    EXPECT(fabs(dot(seen.direction, seen.direction) - 1) < 1e-3 && seen.irradiance[1] >= 0,
           "direction of length^2 %.9g", dot(seen.direction, seen.direction));
    EXPECT(l->cos_alpha >= -1 && l->cos_alpha <= 1, "opening angle %a", (double)l->cos_alpha);
    float rgb[3];
    lightprobe_specular(*l, lightprobe_specular_lobe(l->axis_u, l->direction, 0.1f, l->axis_v),
                        away, -away, 0.1f, rgb);
    for (int i = 0; i < 3; i++) EXPECT(rgb[i] >= 0, "reflects %a", (double)rgb[i]);
}

static void check_energy(const lightprobe_cube *cube, const lightprobe_light *lights, int count,
                         const lightprobe_stats *stats)
{
    double total[3], brightest = 0;
    const int bad = sum_of_probe(cube, total);
    EXPECT(stats->repaired_texels == bad, "%d repaired of %d", stats->repaired_texels, bad);
    for (int c = 0; c < 3; c++) brightest = total[c] > brightest ? total[c] : brightest;
    for (int c = 0; c < 3; c++) {
        double sum = 0;
        for (int i = 0; i < count; i++) sum += (double)lights[i].irradiance[c];
        const double all = (double)stats->total[c], rest = (double)stats->residual[c];
        EXPECT(isfinite(all) && isfinite(rest), "total %g, residual %g", all, rest);
        for (int i = 0; i < 9; i++)
            EXPECT(isfinite(stats->residual_sh[i][c]), "harmonic %d is %g", i,
                   (double)stats->residual_sh[i][c]);
        if (total[c] > 3e38) continue; // clamped
        EXPECT(fabs(all - total[c]) <= 2e-6 * total[c] + 1e-36, "total %.9g for %.9g", all,
               total[c]);
        // Denormal numbers have few digits.
        EXPECT(fabs(sum + rest - all) <= 1e-6 * all + 1e-36, "%.9g in lights, %.9g left of %.9g",
               sum, rest, all);
        EXPECT(rest >= -1e-6 * all - 1e-36, "residual %g of %g", rest, all);
    }
    if (brightest < 1e-29) return;
    EXPECT(stats->error >= 0 && stats->error <= 1.00001f, "error %a", (double)stats->error);
}

static void check_extraction(fuzz_input *in, const lightprobe_cube *cube)
{
    lightprobe_light previous[MOST];
    const lightprobe_settings s = make_settings(in, cube, previous);
    const int asked = s.max_lights > 0 ? s.max_lights : LIGHTPROBE_DEFAULT_LIGHTS,
              offset = fuzz_int(in, 0, 15);
    const size_t bytes = lightprobe_scratch_bytes(cube->side, s.max_lights);
    char *scratch = (char *)fuzz_allocate(bytes + (size_t)offset);
    lightprobe_light *lights = (lightprobe_light *)fuzz_allocate((size_t)asked * sizeof *lights);
    lightprobe_stats stats;
    memset(lights, 0x5a, (size_t)asked * sizeof *lights);
    int count = -5;
    const lightprobe_result r =
        lightprobe_extract(cube, &s, scratch + offset, bytes, lights, &count, &stats);
    if (r) {
        EXPECT(count == -5 && lights->id == 0x5a5a5a5a, "a failure wrote something");
        const int good = s.max_lights >= 0 && s.previous_count >= 0 && isfinite(s.tolerance) &&
                         s.tolerance >= 0 && isfinite(s.min_share) && s.min_share >= 0 &&
                         isfinite(s.min_shadow) && s.min_shadow >= 0 &&
                         (s.mode == 0 || s.mode == 1) &&
                         (cube->channels == 3 || cube->channels == 4);
        EXPECT(!good, "refused: %s", lightprobe_result_string(r));
    } else {
        EXPECT(count >= 0 && count <= asked && stats.lights == count, "%d lights of %d", count,
               asked);
        for (int i = 0; i < count; i++)
            check_light(&lights[i], s.mode == LIGHTPROBE_MEDIAN_CUT, s.previous != NULL);
        check_energy(cube, lights, count, &stats);
        for (int i = 0; i < count && !s.previous; i++) {
            for (int k = 0; k < i; k++)
                EXPECT(lights[i].id != lights[k].id, "id %d twice", lights[i].id);
        }
    }
    free(lights);
    free(scratch);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_input in = {data, size};
    while (in.left > 0) {
        lightprobe_cube cube;
        cube.side = fuzz_byte(&in) & 15 ? fuzz_int(&in, 1, 12) : fuzz_int(&in, 1, 70);
        cube.channels = fuzz_byte(&in) & 7 ? 3 + (int)(fuzz_byte(&in) & 1) : fuzz_int(&in, 1, 5);
        make_faces(&in, &cube);
        check_extraction(&in, &cube);
        for (int f = 0; f < 6; f++) free((void *)(uintptr_t)cube.face[f]);
        const float c = fuzz_float(&in), n = fuzz_float(&in), e = lightprobe_disc_irradiance(c, n);
        EXPECT(e >= 0 && e <= 1, "irradiance %a of %a, %a", (double)e, (double)c, (double)n);
        float d[3];
        const float s = fuzz_unit(&in), t = fuzz_unit(&in);
        lightprobe_texel_direction(fuzz_int(&in, -9, 9), s, t, d);
        EXPECT(fabs(dot(d, d) - 1) < 1e-6, "direction of length^2 %.9g", dot(d, d));
    }
    return 0;
}
