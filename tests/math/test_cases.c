// Regression cases: single queries of the moment math that once were the worst of their kind, kept
// as text in tests/cases/. Written by the stability suite, or by hand; lines are
//     # comment
//     case NAME                   starts a case
//     why TEXT                    where it comes from and what goes wrong there
//     moments B1 ... B4 [B5 B6]   biased, as hexadecimal floats; also nan and inf
//     z DEPTH                     of the receiver
//     lower LOW HIGH              interval in which the lower bound of visibility must lie
//     upper LOW HIGH              the same for the upper bound
//     tolerance T                 by which both intervals are widened: rounding of float32
//     blocker DEPTH SHARE T       optional: blocker depth (self weight 1e-3), right to T / SHARE,
//                                 SHARE being what stands behind it
// Every case asks the bounds, the array form, the full reconstruction and the blocker depth. All of
// them must be finite, the bounds in [0,1] and in order, whatever else the case says.
#include "../support/test.h"

#include "../../mssm.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct kept {
    char name[120], why[400];
    int moments, line, has_blocker;
    float b[6], z;
    double lower[2], upper[2], tolerance, blocker[3];
} kept;

static int finite(float x)
{
    return x - x == 0;
}

// Numbers after the keyword; -1 where there is something else among them.
static int numbers(const char *text, int most, double *value)
{
    int count = 0;
    for (;;) {
        char *end;
        const double v = strtod(text, &end);
        if (end == text) break;
        if (count == most) return -1;
        value[count++] = v;
        text = end;
    }
    return text[strspn(text, " \r\n")] ? -1 : count;
}

// One line of a case; 0 if it is none of the above.
static int read_line(kept *k, const char *line)
{
    double v[6];
    char word[16];
    int skip = 0;
    if (sscanf(line, "%15s %n", word, &skip) != 1) return 1; // an empty line
    const char *rest = line + skip;
    if (!strcmp(word, "why")) {
        snprintf(k->why, sizeof k->why, "%.*s", (int)strcspn(rest, "\r\n"), rest);
        return 1;
    }
    const int count = numbers(rest, 6, v);
    if (!strcmp(word, "moments") && (count == 4 || count == 6)) {
        k->moments = count;
        for (int i = 0; i < count; i++) k->b[i] = (float)v[i];
        return 1;
    }
    double *pair = !strcmp(word, "lower") ? k->lower : !strcmp(word, "upper") ? k->upper : NULL;
    if (pair && count == 2) {
        memcpy(pair, v, 2 * sizeof *v);
        return 1;
    }
    if (!strcmp(word, "blocker") && count == 3) {
        k->has_blocker = 1;
        memcpy(k->blocker, v, sizeof k->blocker);
        return 1;
    }
    if (count != 1) return 0;
    if (!strcmp(word, "z")) return k->z = (float)v[0], 1;
    if (!strcmp(word, "tolerance")) return k->tolerance = v[0], 1;
    return 0;
}

typedef struct reply {
    const char *of;
    double lower, upper;
} reply;

// The bounds by each of the ways to them, and the blocker depth; 0 where something is not finite.
static int ask(const kept *k, reply r[3], float *blocker)
{
    mssm_moments4 m4;
    mssm_moments6 m6;
    const float *rows[6];
    float low, high, z[4], w[4];
    memcpy(m4.b, k->b, sizeof m4.b);
    memcpy(m6.b, k->b, sizeof m6.b);
    for (int i = 0; i < 6; i++) rows[i] = k->b + i;
    const int four = k->moments == 4;
    const mssm_bounds v = four ? mssm_visibility4(m4, k->z) : mssm_visibility6(m6, k->z);
    if (four) {
        const mssm_points3 p = mssm_reconstruct4(m4, k->z);
        memcpy(z, p.z, sizeof p.z);
        memcpy(w, p.w, sizeof p.w);
        mssm_visibility4_array(1, rows, &k->z, &low, &high);
    } else {
        const mssm_points4 p = mssm_reconstruct6(m6, k->z);
        memcpy(z, p.z, sizeof p.z);
        memcpy(w, p.w, sizeof p.w);
        mssm_visibility6_array(1, rows, &k->z, &low, &high);
    }
    *blocker = four ? mssm_blocker_depth4(m4, k->z, 1e-3f, 1e-3f)
                    : mssm_blocker_depth6(m6, k->z, 1e-3f, 1e-3f);
    double nearer = 0;
    int good =
        finite(*blocker) && finite(v.lower) && finite(v.upper) && finite(low) && finite(high);
    for (int i = 0; i <= k->moments / 2; i++) {
        good = good && finite(z[i]) && finite(w[i]);
        if (i > 0 && z[i] < z[0]) nearer += (double)w[i];
    }
    r[0] = (reply){"bounds", (double)v.lower, (double)v.upper};
    r[1] = (reply){"array", (double)low, (double)high};
    r[2] = (reply){"reconstruction", 1 - nearer - (double)w[0], 1 - nearer};
    return good;
}

static int within(double x, const double interval[2], double tolerance)
{
    return x >= interval[0] - tolerance && x <= interval[1] + tolerance;
}

static void check_case(const char *path, const kept *k)
{
    reply r[3];
    float blocker;
    CHECK(k->moments && k->upper[1] >= k->upper[0] && k->lower[1] >= k->lower[0],
          "%s:%d: the case %s is not complete", path, k->line, k->name);
    CHECK(ask(k, r, &blocker), "%s:%d: %s: not finite (%s)", path, k->line, k->name, k->why);
    for (int i = 0; i < 3; i++) {
        // Shares are rounded one by one: their sums may pass the ends by that.
        const double rounding = i == 2 ? 1e-6 : 0;
        CHECK(r[i].lower >= -rounding && r[i].lower <= r[i].upper && r[i].upper <= 1 + rounding,
              "%s:%d: %s: %s give [%.9g, %.9g]", path, k->line, k->name, r[i].of, r[i].lower,
              r[i].upper);
        CHECK(within(r[i].lower, k->lower, k->tolerance + rounding) &&
                  within(r[i].upper, k->upper, k->tolerance + rounding),
              "%s:%d: %s: %s give [%.9g, %.9g], not [%.9g, %.9g] (%s)", path, k->line, k->name,
              r[i].of, r[i].lower, r[i].upper, k->lower[0], k->upper[0], k->why);
    }
    if (!k->has_blocker) return;
    CHECK(fabs((double)blocker - k->blocker[0]) * k->blocker[1] <= k->blocker[2],
          "%s:%d: %s: blockers at %.9g, not %.9g", path, k->line, k->name, (double)blocker,
          k->blocker[0]);
}

static void check_file(const char *name, int least)
{
    char path[200], line[1000];
    snprintf(path, sizeof path, "tests/cases/%s", name);
    FILE *f = fopen(path, "r");
    CHECK(f, "cannot open %s: run from the top of the tree", path);
    if (!f) return;
    kept k;
    int count = 0, at = 0;
    memset(&k, 0, sizeof k);
    while (fgets(line, sizeof line, f)) {
        at++;
        if (line[0] == '#') continue;
        if (!strncmp(line, "case ", 5)) {
            if (count++) check_case(path, &k);
            memset(&k, 0, sizeof k);
            k.line = at;
            k.tolerance = 0;
            snprintf(k.name, sizeof k.name, "%.*s", (int)strcspn(line + 5, "\r\n"), line + 5);
        } else {
            CHECK(read_line(&k, line), "%s:%d: cannot be read: %s", path, at, line);
        }
    }
    if (count) check_case(path, &k);
    fclose(f);
    test_note("%d cases of %s", count, path);
    CHECK(count >= least, "%s has only %d cases", path, count);
}

static void worst_cases_stay(void)
{
    check_file("worst.txt", 90);
}

static void rivals_failures_are_answered(void)
{
    check_file("rivals.txt", 30);
}

static void degenerate_moments_are_answered(void)
{
    check_file("degenerate.txt", 15);
}

const test_case cases_tests[] = {
    {"cases: the worst of each family stay where they were", worst_cases_stay},
    {"cases: where other methods fail there is an answer", rivals_failures_are_answered},
    {"cases: degenerate moments have an answer", degenerate_moments_are_answered},
    {NULL, NULL}};
