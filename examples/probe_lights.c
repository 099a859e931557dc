// From a light probe to area lights: a table of them, and the probe with their rectangles drawn on
// it.
//     probe_lights [FILE.hdr|FILE.pfm] [LIGHTS] [OUT.png]
// FILE is a lat-long picture or a strip of six cube faces; without it, the built-in probe is used.
// LIGHTS 0 (the default) takes as many as the probe needs.
#include "common/probe.h"
#include "common/png.h"
#include "lightprobe.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 1024, HEIGHT = 512 };

static const float pi = 3.14159265f;

// Where a direction lies in the lat-long picture: the middle column looks along -Z.
static void plot(unsigned char *rgb8, vec3 d, const unsigned char color[3])
{
    const float length = sqrtf(d.x * d.x + d.y * d.y + d.z * d.z);
    const int x = (int)((0.5f + atan2f(d.x, -d.z) / (2 * pi)) * WIDTH) % WIDTH;
    const int y = (int)(acosf(d.y / length) / pi * HEIGHT);
    memcpy(rgb8 + 3 * ((y < HEIGHT ? y : HEIGHT - 1) * WIDTH + x), color, 3);
}

// The outline of the light's rectangle, and a cross at its centre.
static void draw_light(unsigned char *rgb8, const lightprobe_light *l)
{
    static const unsigned char outline[3] = {255, 60, 0}, centre[3] = {0, 90, 255};
    const vec3 d = vec_of(l->direction);
    const vec3 u = vec_scale(vec_of(l->axis_u), l->tan_half_u);
    const vec3 v = vec_scale(vec_of(l->axis_v), l->tan_half_v);
    for (int i = 0; i <= 1000; i++) {
        const float t = -1 + 0.002f * (float)i;
        for (int sign = -1; sign <= 1; sign += 2) {
            plot(rgb8, vec_mad(vec_mad(d, u, t), v, (float)sign), outline);
            plot(rgb8, vec_mad(vec_mad(d, v, t), u, (float)sign), outline);
        }
        plot(rgb8, vec_mad(d, vec_of(l->axis_u), 0.01f * t), centre);
        plot(rgb8, vec_mad(d, vec_of(l->axis_v), 0.01f * t), centre);
    }
}

static bool draw(const probe *p, const lightprobe_light *lights, int count, const char *path,
                 message *why)
{
    image im;
    unsigned char *rgb8 = malloc(3 * WIDTH * HEIGHT);
    if (!image_create(&im, WIDTH, HEIGHT) || !rgb8) return fail(why, "no memory for the picture");
    for (int y = 0; y < HEIGHT; y++) {
        const float theta = pi * ((float)y + 0.5f) / HEIGHT;
        for (int x = 0; x < WIDTH; x++) {
            const float phi = 2 * pi * (((float)x + 0.5f) / WIDTH - 0.5f);
            const vec3 d = vec(sinf(theta) * sinf(phi), cosf(theta), -sinf(theta) * cosf(phi));
            image_set(&im, x, y, probe_sample(p, d));
        }
    }
    image_tonemap(&im, image_exposure(&im), rgb8);
    for (int i = 0; i < count; i++) draw_light(rgb8, lights + i);
    const bool good = png_write(path, rgb8, WIDTH, HEIGHT, why);
    image_free(&im);
    free(rgb8);
    return good;
}

static float degrees(float radians)
{
    return radians * 180 / pi;
}

static void print_table(const lightprobe_light *lights, const lightprobe_stats *stats)
{
    printf("  id   direction               half-size       disc    irradiance (R G B)         "
           "share\n");
    for (int i = 0; i < stats->lights; i++) {
        const lightprobe_light *l = lights + i;
        printf("%4d   %6.3f %6.3f %6.3f   %5.2f x%5.2f   %5.2f   %8.4f %8.4f %8.4f   %5.2f%%\n",
               l->id, (double)l->direction[0], (double)l->direction[1], (double)l->direction[2],
               (double)degrees(atanf(l->tan_half_u)), (double)degrees(atanf(l->tan_half_v)),
               (double)degrees(acosf(l->cos_alpha)), (double)l->irradiance[0],
               (double)l->irradiance[1], (double)l->irradiance[2],
               (double)(100 * l->irradiance[1] / stats->total[1]));
    }
    printf("(angles in degrees, share of green)\n");
    printf("%d lights, error %.4f; probe %.5g %.5g %.5g, left to ambient %.2g %.2g %.2g; "
           "%d bad texels\n",
           stats->lights, (double)stats->error, (double)stats->total[0], (double)stats->total[1],
           (double)stats->total[2], (double)stats->residual[0], (double)stats->residual[1],
           (double)stats->residual[2], stats->repaired_texels);
}

static void log_line(void *user, const char *text)
{
    snprintf(((message *)user)->text, sizeof((message *)user)->text, "%s", text);
}

static bool run(const char *file, int most, const char *out, message *why)
{
    probe p;
    if (file ? !probe_load(&p, file, 0, why) : !probe_default(&p, PROBE_DEFAULT_SIDE))
        return file ? false : fail(why, "no memory for the probe");
    lightprobe_cube cube = {{NULL}, p.side, 3};
    memcpy(cube.face, p.face, sizeof cube.face);
    static lightprobe_light lights[LIGHTPROBE_MAX_LIGHTS];
    lightprobe_stats stats;
    lightprobe_settings settings;
    memset(&settings, 0, sizeof settings);
    settings.max_lights = most;
    settings.log = log_line;
    settings.user = why;
    const size_t bytes = lightprobe_scratch_bytes(p.side, most);
    void *scratch = malloc(bytes + !bytes);
    int count;
    bool good = !lightprobe_extract(&cube, &settings, scratch, bytes, lights, &count, &stats);
    if (good) print_table(lights, &stats);
    if (good && out) good = draw(&p, lights, count, out, why);
    free(scratch);
    probe_free(&p);
    return good;
}

int main(int argc, char **argv)
{
    message why = {""};
    if (run(argc > 1 ? argv[1] : NULL, argc > 2 ? atoi(argv[2]) : 0, argc > 3 ? argv[3] : NULL,
            &why))
        return 0;
    fprintf(stderr, "probe_lights: %s\n", why.text);
    return 1;
}
