// Sums over the figures, see summary.h.
#include "summary.h"

#include <math.h>
#include <string.h>

const style styles[] = {
    {"layered", "layered", COLOUR_LAYERED, MARKER_CIRCLE},
    {"MSSM", "MSSM", COLOUR_MSSM, MARKER_SQUARE},
    {"PCSS", "PCSS", COLOUR_PCSS, MARKER_UP},
    {"CSSM", "convolution", COLOUR_CONVOLUTION, MARKER_DIAMOND},
    {"VS", "variance (VSM, VSSM, EVSM)", COLOUR_VARIANCE, MARKER_DOWN},
    {"back-projection", "back-projection", COLOUR_BACK_PROJECTION, MARKER_PLUS},
    {"PCF", "hard, PCF", COLOUR_HARD, MARKER_CROSS},
    {"hard", NULL, COLOUR_HARD, MARKER_CROSS},
    {"EVSM", NULL, COLOUR_VARIANCE, MARKER_DOWN},
    {"truth", NULL, COLOUR_INK, MARKER_CIRCLE},
    {FILTERED_4, NULL, COLOUR_MSSM, MARKER_SQUARE},
    {FILTERED_6, NULL, COLOUR_LAYERED, MARKER_CIRCLE},
    {"median cut", NULL, COLOUR_MSSM, MARKER_SQUARE},
    {"point lights", NULL, COLOUR_HARD, MARKER_CROSS},
    {"greedy rectangles", NULL, COLOUR_CONVOLUTION, MARKER_DIAMOND},
    {"variance cuts", NULL, COLOUR_VARIANCE, MARKER_DOWN},
    {"one sun and ambient", NULL, COLOUR_HARD, MARKER_PLUS},
};
const int style_count = sizeof styles / sizeof *styles;

const style *style_of(const char *method)
{
    for (int i = 0; i < style_count; i++)
        if (!strncmp(method, styles[i].family, strlen(styles[i].family))) return &styles[i];
    return &styles[0]; // what has no family of its own is this library's
}

bool names_has(const names *n, const char *name)
{
    for (int i = 0; i < n->count; i++)
        if (!strcmp(n->list[i], name)) return true;
    return false;
}

static void names_add(names *n, const char *name)
{
    if (n->count == NAMES_ROOM || names_has(n, name)) return;
    snprintf(n->list[n->count++], FIGURE_NAME, "%s", name);
}

names methods_of(const figures *f, const char *experiment)
{
    names n = {0};
    for (int i = 0; i < f->count; i++)
        if (!strcmp(f->list[i].experiment, experiment)) names_add(&n, f->list[i].method);
    return n;
}

names metrics_of(const figures *f, const char *experiment)
{
    names n = {0};
    for (int i = 0; i < f->count; i++)
        if (!strcmp(f->list[i].experiment, experiment)) names_add(&n, f->list[i].metric);
    return n;
}

names scenes_of(const figures *f, const char *experiment)
{
    names n = {0};
    for (int i = 0; i < f->count; i++)
        if (!strcmp(f->list[i].experiment, experiment) && strcmp(f->list[i].scene, "all"))
            names_add(&n, f->list[i].scene);
    return n;
}

static bool same(double a, double b)
{
    return fabs(a - b) <= 1e-6 * fabs(b);
}

static void numbers_add(numbers *n, double x)
{
    int at = 0;
    while (at < n->count && n->list[at] < x && !same(n->list[at], x)) at++;
    if (n->count == NAMES_ROOM || (at < n->count && same(n->list[at], x))) return;
    memmove(&n->list[at + 1], &n->list[at], (size_t)(n->count - at) * sizeof *n->list);
    n->list[at] = x;
    n->count++;
}

numbers sweep_of(const figures *f, const char *experiment, const char *method, const char *metric)
{
    numbers n = {0};
    for (int i = 0; i < f->count; i++) {
        const figure *one = &f->list[i];
        if (!strcmp(one->experiment, experiment) && (!metric || !strcmp(one->metric, metric)) &&
            (!method || !strcmp(one->method, method)))
            numbers_add(&n, one->x);
    }
    return n;
}

double nearest(const numbers *n, double x)
{
    double best = NAN;
    for (int i = 0; i < n->count; i++)
        if (isnan(best) || fabs(n->list[i] - x) < fabs(best - x)) best = n->list[i];
    return best;
}

static summary summarize_scene(const figures *f, const char *experiment, const char *scene,
                               const char *method, double x, const char *metric)
{
    summary s = {.least = HUGE_VAL, .most = -HUGE_VAL};
    for (int i = 0; i < f->count; i++) {
        const figure *one = &f->list[i];
        if (strcmp(one->experiment, experiment) || strcmp(one->metric, metric) ||
            strcmp(one->method, method) || (!isnan(x) && !same(one->x, x)))
            continue;
        if (scene ? strcmp(one->scene, scene) != 0 : !strcmp(one->scene, "all")) continue;
        s.count++;
        s.mean += one->value;
        s.low += one->low;
        s.high += one->high;
        s.least = fmin(s.least, one->value);
        s.most = fmax(s.most, one->value);
    }
    if (!s.count) return (summary){0, NAN, NAN, NAN, NAN, NAN};
    s.mean /= s.count;
    s.low /= s.count;
    s.high /= s.count;
    return s;
}

summary summarize(const figures *f, const char *experiment, const char *scene, const char *method,
                  double x, const char *metric)
{
    const summary s = summarize_scene(f, experiment, scene, method, x, metric);
    return s.count || scene ? s : summarize_scene(f, experiment, "all", method, x, metric);
}

double mean_of(const figures *f, const char *experiment, const char *scene, const char *method,
               double x, const char *metric)
{
    return summarize(f, experiment, scene, method, x, metric).mean;
}

comparison compare(const figures *f, const char *experiment, const char *scene, const char *method,
                   const char *other, const char *metric)
{
    comparison c = {.least = HUGE_VAL, .most = -HUGE_VAL};
    double own = 0, its = 0;
    for (int i = 0; i < f->count; i++) {
        const figure *one = &f->list[i];
        if (strcmp(one->experiment, experiment) || strcmp(one->metric, metric) ||
            strcmp(one->method, method) ||
            (scene ? strcmp(one->scene, scene) != 0 : !strcmp(one->scene, "all")))
            continue;
        const figure *that = figures_find(f, experiment, one->scene, other, one->x, metric);
        if (!that) continue;
        const double ratio = one->value / that->value;
        c.cases++;
        c.lower += one->value < that->value;
        c.least = fmin(c.least, ratio);
        if (ratio > c.most) snprintf(c.worst, sizeof c.worst, "%s", one->scene);
        c.most = fmax(c.most, ratio);
        own += one->value;
        its += that->value;
    }
    if (!c.cases && !scene) return compare(f, experiment, "all", method, other, metric);
    if (!c.cases) return (comparison){0, 0, NAN, NAN, NAN, ""};
    c.ratio = own / its;
    return c;
}

double method_error(const figures *f, const char *method)
{
    const double all = mean_of(f, "overall", "all", method, NAN, "rms");
    return isnan(all) ? mean_of(f, "error", NULL, method, NAN, "rms") : all;
}

double method_ns(const figures *f, const char *method)
{
    return mean_of(f, "overall", "all", method, NAN, "ns");
}

double method_bytes(const figures *f, const char *method)
{
    const numbers sides = sweep_of(f, "side", method, "bytes");
    return mean_of(f, "side", NULL, method, nearest(&sides, 256), "bytes");
}

bool method_constant_time(const figures *f, const char *method)
{
    const numbers widths = sweep_of(f, "kernel", method, "ns");
    if (!widths.count) return false;
    return mean_of(f, "kernel", NULL, method, widths.list[widths.count - 1], "ns") <
           1.5 * mean_of(f, "kernel", NULL, method, widths.list[0], "ns");
}
