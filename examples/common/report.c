#include "report.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void report_lights(const lighting *l)
{
    const lightprobe_stats *s = &l->stats;
    const lightprobe_settings *asked = &l->settings.probe;
    const float total = vec_luminance(vec_of(s->total)), rest = vec_luminance(vec_of(s->residual));
    const bool enough = s->error <= asked->tolerance;
    printf("lights     %d in %.1f ms: %s, of at most %d; error behind edges %.2f%% of the mean, "
           "%.2f%% "
           "asked for; they carry %.2f%% of the light, the rest needs no map\n",
           l->lights, 1e3 * l->extract_seconds,
           enough ? "one less would err more than asked for" : "all that are allowed",
           asked->max_lights, 100 * (double)s->error, 100 * (double)asked->tolerance,
           total > 0 ? 100 * (1 - (double)(rest / total)) : 100.0);
    if (s->repaired_texels) printf("           %d broken texels repaired\n", s->repaired_texels);
}

void report_maps(const lighting *l, int triangles)
{
    const int side = l->settings.map_side;
    int large = 0;
    for (int i = 0; i < l->lights; i++) large += lighting_map_side(l, i) > side;
    const int moments = l->settings.shadows.moments;
    printf("maps       %d of %d^2 and %d of %d^2 for narrow lights, %d samples a texel, %d "
           "triangles: depth "
           "%.2f s, moments %.2f s\n",
           l->lights - large, side, large, 2 * side, l->settings.map_samples, triangles,
           l->depth_seconds, l->map_seconds);
    printf("moments    %s, %s\n",
           moments == 4   ? "4 of 6"
           : moments == 6 ? "6"
                          : "4 to search for blockers, 6 to weigh them",
           l->settings.shadows.estimator == MSSM_LAYERED ? "every layer of blockers by itself"
           : l->settings.shadows.estimator == MSSM_HORIZON
               ? "every layer of blockers by itself, above the horizon"
           : l->settings.shadows.estimator == MSSM_LOWER_BLOCKER
               ? "lower estimate of blocker depth"
               : "upper estimate of blocker depth");
}

double report_difference(const image *a, const image *b, const view *v)
{
    double squares = 0, sum = 0, values = 0;
    for (size_t i = 0; i < (size_t)v->width * (size_t)v->height; i++) {
        if (v->triangle[i * VIEW_SAMPLES] < 0) continue;
        for (size_t k = 3 * i; k < 3 * i + 3; k++, values++) {
            const double d = (double)a->rgb[k] - (double)b->rgb[k];
            squares += d * d;
            sum += (double)b->rgb[k];
        }
    }
    return sum > 0 ? sqrt(squares * values) / sum : 0;
}

void report_name(char *name, size_t room, const char *out, const char *insert)
{
    const char *dot = strrchr(out, '.');
    const int stem = dot && !strchr(dot, '/') ? (int)(dot - out) : (int)strlen(out);
    snprintf(name, room, "%.*s%s%s", stem, out, insert, out + stem);
}

void report_frame_name(char *name, size_t room, const char *out, int frame)
{
    char number[16];
    snprintf(number, sizeof number, "-%04d", frame);
    report_name(name, room, out, number);
}
