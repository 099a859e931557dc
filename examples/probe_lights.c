// Prints the area lights of a light probe, and draws their rectangles on it:
//     probe_lights --probe FILE --out lights.png
#include "common/options.h"
#include "common/probe.h"
#include "common/png.h"
#include "lightprobe.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 1024, HEIGHT = 512 };

static const char names[] = "--probe --lights --tolerance --exposure --out --help";
static const char help[] =
    "Prints the area lights of a light probe, and draws them on it.\n"
    "\n"
    "  --probe FILE      .hdr or .pfm: lat-long, cross or strip of six cube faces (built in)\n"
    "  --lights N        at most N lights, 1..1024 (64)\n"
    "  --tolerance T     stop adding lights at this error behind edges, 0..1 (0.02)\n"
    "  --out FILE        a lat-long PNG of the probe with the lights' rectangles (none)\n"
    "  --exposure E      of that PNG, 1e-6..1e6 (by default the median becomes middle grey)\n"
    "  --help            print this text\n";

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

static bool draw(const probe *p, const lightprobe_light *lights, int count, const options *o,
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
    image_tonemap(&im, o->exposure > 0 ? o->exposure : image_exposure(&im), rgb8);
    for (int i = 0; i < count; i++) draw_light(rgb8, lights + i);
    const bool good = png_write(o->out, rgb8, WIDTH, HEIGHT, why);
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

static bool run(const options *o, message *why)
{
    probe p;
    if (o->probe ? !probe_load(&p, o->probe, 0, why) : !probe_default(&p, PROBE_DEFAULT_SIDE))
        return o->probe ? false : fail(why, "no memory for the probe");
    lightprobe_cube cube = {{NULL}, p.side, 3};
    memcpy(cube.face, p.face, sizeof cube.face);
    static lightprobe_light lights[LIGHTPROBE_MAX_LIGHTS];
    lightprobe_stats stats;
    lightprobe_settings settings;
    memset(&settings, 0, sizeof settings);
    settings.max_lights = o->lights;
    settings.tolerance = o->tolerance;
    settings.log = log_line;
    settings.user = why;
    const size_t bytes = lightprobe_scratch_bytes(p.side, o->lights);
    void *scratch = malloc(bytes + !bytes);
    int count;
    bool good = !lightprobe_extract(&cube, &settings, scratch, bytes, lights, &count, &stats);
    if (good) print_table(lights, &stats);
    if (good && o->out) good = draw(&p, lights, count, o, why);
    free(scratch);
    probe_free(&p);
    return good;
}

int main(int argc, char **argv)
{
    message why = {""};
    options o = {.lights = 64, .tolerance = 0.02f};
    bool done = options_parse_some(&o, names, argc, argv, &why);
    if (o.help)
        fputs(help, stdout);
    else if (done)
        done = run(&o, &why);
    if (!done) fprintf(stderr, "probe_lights: %s\n", why.text);
    return done ? 0 : 1;
}
