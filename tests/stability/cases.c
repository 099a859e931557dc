// Picks the worst queries and writes them with what the oracle says about them.
#include "cases.h"

#include <math.h>
#include <stdio.h>

// How much the exact bounds and blocker depth move when each moment errs by a rounding of float32.
typedef struct condition {
    double bounds, depth;
} condition;

static condition condition_of(const query *q, const judgement *at)
{
    static const double rounding = 1 / 33554432.0;
    const answer none = {0, 0, 0};
    condition c = {0, 0};
    for (int k = 0; k < q->m; k++) {
        double bounds = 0, depth = 0;
        for (int sign = -1; sign <= 1; sign += 2) {
            query moved = *q;
            moved.b[k] += (float)(2 * sign * rounding); // at least the next float
            const judgement j = judge(&moved, &none);
            if (!j.valid) continue;
            bounds = fmax(bounds, fmax(fabs(j.lower - at->lower), fabs(j.upper - at->upper)));
            depth = fmax(depth, fabs(j.depth - at->depth) * (1 - at->upper + 1e-3));
        }
        c.bounds += bounds;
        c.depth += depth;
    }
    return c;
}

// Room for other compilers, fused multiply-adds and x87: their rounding errors are as large as
// those that were found here, but not the same. One digit, rounded up.
static double tolerance_of(double error, double moved)
{
    const double least = fmax(fmax(2 * error, moved), 1e-5);
    const double digit = pow(10, floor(log10(least)));
    return ceil(least / digit) * digit;
}

static void write_case(FILE *f, const char *name, const char *why, query q)
{
    q.method = METHOD_BOUNDS;
    const answer a = methods[q.method].run(q.m, q.b, q.t, q.alpha, q.z);
    const answer p = methods[METHOD_POINTS].run(q.m, q.b, q.t, q.alpha, q.z);
    const judgement j = judge(&q, &a), k = judge(&q, &p);
    fprintf(f, "\ncase %s\nwhy %s\nmoments", name, why);
    for (int i = 0; i < q.m; i++) fprintf(f, " %a", (double)q.b[i]);
    fprintf(f, "\nz %a\n", (double)q.z);
    if (!j.valid) {
        fprintf(f, "lower 0 1\nupper 0 1\ntolerance 0\n");
        return;
    }
    const condition c = condition_of(&q, &j);
    const double bounds = fmax(j.error, k.error), depth = j.blocker;
    fprintf(f, "lower %.9g %.9g\nupper %.9g %.9g\ntolerance %.1g\n", j.lower, j.lower, j.upper,
            j.upper, tolerance_of(bounds, c.bounds));
    // Beyond the depths of a map only the bounds are defined by the oracle alone.
    if (q.z >= -1 && q.z <= 1) {
        fprintf(f, "blocker %.9g %.9g %.1g\n", j.depth, 1 - j.upper + 1e-3,
                tolerance_of(depth, c.depth));
    }
}

static FILE *open_cases(const char *folder, const char *name, const char *title)
{
    char path[400];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *f = fopen(path, "w");
    if (f) {
        fprintf(f,
                "# %s\n# Written by `build/release/stability --cases tests/cases`; the format is "
                "described in tests/math/test_cases.c.\n",
                title);
    }
    return f;
}

static int write_worst(results *r, int bias, const char *folder)
{
    FILE *f =
        open_cases(folder, "worst.txt",
                   "The largest error of mssm.h in each family, at the safe bias of each format.");
    if (!f) return 0;
    for (int i = 0; i < 2 * 4 * FAMILY_COUNT; i++) {
        const int m = i % 2 ? 6 : 4, format = i / 2 % 4, family = i / 8;
        const figures g = results_figures(r, METHOD_BOUNDS, m, format, bias, family);
        char name[100], why[200];
        if (!g.worst.m) continue;
        snprintf(name, sizeof name, "%d-%s-%s", m, format_names[format], family_keys[family]);
        snprintf(why, sizeof why, "%s, %s, bias %g: off by %.1e", family_names[family],
                 format_titles[format], (double)g.worst.alpha, g.error[3]);
        write_case(f, name, why, g.worst);
    }
    return fclose(f) == 0;
}

static int write_rivals(results *r, int safe, const char *folder)
{
    FILE *f = open_cases(
        folder, "rivals.txt",
        "Where each other method first returns NaN, leaves [0,1] or crosses its bounds.");
    if (!f) return 0;
    for (int i = 0; i < METHODS * 2 * FORMATS; i++) {
        const int method = i / 2 / FORMATS, m = i % 2 ? 6 : 4, format = i / 2 % FORMATS;
        if (method < METHOD_PUBLISHED) continue;
        // At the safe bias where it fails there, or else at the largest at which it does.
        figures g = results_figures(r, method, m, format, safe, -1);
        for (int bias = r->p.biases - 1; bias >= 0 && !g.first_failure.m; bias--) {
            g = results_figures(r, method, m, format, bias, -1);
        }
        if (!g.first_failure.m) continue;
        const query q = g.first_failure;
        const answer a = methods[method].run(q.m, q.b, q.t, q.alpha, q.z);
        char name[100], why[200];
        snprintf(name, sizeof name, "%d-%s-%s", m, format_names[format], methods[method].name);
        const int number = a.lower - a.lower == 0 && a.upper - a.upper == 0;
        int length =
            snprintf(why, sizeof why, "%s, %s, bias %g: %s returns ", family_names[q.family],
                     format_titles[format], (double)q.alpha, methods[method].title);
        if (number)
            snprintf(why + length, sizeof why - (size_t)length, "[%g, %g]", (double)a.lower,
                     (double)a.upper);
        else
            snprintf(why + length, sizeof why - (size_t)length, "no numbers");
        write_case(f, name, why, q);
    }
    return fclose(f) == 0;
}

int cases_write(results *r, int bias, const char *folder)
{
    return write_worst(r, bias, folder) && write_rivals(r, bias, folder);
}
