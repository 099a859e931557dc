// The page: one function a section, every figure from the results.
#include "page.h"

#include "chart.h"
#include "distance.h"
#include "further.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const plan page_plan = {
    400,
    -1,
    -1,
    -1,
    -1,
    12,
    {0, 1e-8f, 1e-7f, 3e-7f, 1e-6f, 3e-6f, 1e-5f, 3e-5f, 1e-4f, 3e-4f, 1e-3f, -1},
    0};

enum { NO_BIAS = 0, OWN_FORMATS = FORMAT_TABLE + 1 }; // the formats before it have a safe bias

static int safe_of(const results *r)
{
    return r->p.biases - 1;
}

// Short enough for a table: 0, 3.1e-05, 0.12, or a dash where nothing could be compared.
static const char *cell(double x)
{
    static char text[16][16];
    static int next;
    char *t = text[next++ % 16];
    if (x != x)
        snprintf(t, 16, "-");
    else if (x <= 0)
        snprintf(t, 16, "0");
    else
        snprintf(t, 16, x < 0.01 ? "%.1e" : "%.2f", x);
    return t;
}

// ---- one line ------------------------------------------------------------------------------

void page_line_head(void)
{
    printf("method,moments,format,bias,family,queries,not_finite,out_of_range,crossed,"
           "invalid_moments,false_shadow,leak,error_50,error_99,error_999,error_max,blocker_999,"
           "blocker_max\n");
}

static void write_line(FILE *f, results *r, int method, int m, int format, int bias, int family)
{
    const figures g = results_figures(r, method, m, format, bias, family);
    fprintf(f, "%s,%d,%s,%g,%s,%d,%d,%d,%d,%d,%.3g,%.3g,%.3g,%.3g,%.3g,%.3g,%.3g,%.3g\n",
            methods[method].name, m, format_names[format],
            (double)plan_alpha(&r->p, bias, method, m, format),
            family < 0 ? "all" : family_keys[family], g.samples, g.not_finite, g.out_of_range,
            g.crossed, g.unrepaired, g.dark, g.leak, g.error[0], g.error[1], g.error[2], g.error[3],
            g.blocker[2], g.blocker[3]);
}

static void print_query(const char *what, const query *q)
{
    if (!q->m) return;
    const answer a = methods[q->method].run(q->m, q->b, q->t, q->alpha, q->z);
    const judgement j = judge(q, &a);
    printf("%s: %s, moments", what, family_keys[q->family]);
    for (int k = 0; k < q->m; k++) printf(" %a", (double)(q->b[k]));
    printf(" z %a\n    returns [%.9g, %.9g], blockers at %.9g", (double)q->z, (double)a.lower,
           (double)a.upper, (double)a.blocker);
    if (j.valid)
        printf("; exact [%.9g, %.9g], %.9g\n", j.lower, j.upper, j.depth);
    else
        printf("; no distribution has these moments\n");
}

void page_line(results *r, int method, int m, int format, int bias, int family)
{
    const figures g = results_figures(r, method, m, format, bias, family);
    write_line(stdout, r, method, m, format, bias, family);
    print_query("largest error", &g.worst);
    print_query("first failure", &g.first_failure);
}

static int write_csv(results *r, const char *path)
{
    FILE *f = fopen(path, "w");
    if (!f) return 0;
    fprintf(f, "method,moments,format,bias,family,queries,not_finite,out_of_range,crossed,"
               "invalid_moments,false_shadow,leak,error_50,error_99,error_999,error_max,"
               "blocker_999,blocker_max\n");
    for (int i = 0; i < METHODS * 2 * FORMATS * r->p.biases * (FAMILY_COUNT + 1); i++) {
        const int family = i % (FAMILY_COUNT + 1) - 1, row = i / (FAMILY_COUNT + 1);
        const int bias = row % r->p.biases, rest = row / r->p.biases;
        const int format = rest % FORMATS, m = rest / FORMATS % 2 ? 6 : 4;
        const int method = rest / FORMATS / 2;
        if (applies(method, format)) write_line(f, r, method, m, format, bias, family);
    }
    return fclose(f) == 0;
}

// ---- tables --------------------------------------------------------------------------------

// What a reader wants to know first.
typedef struct sums {
    double queries, failures;
} sums;

static sums sums_of(results *r, int method, int first_bias, int last_bias, int formats)
{
    sums s = {0, 0};
    for (int i = 0; i < 2 * formats; i++) {
        for (int bias = first_bias; bias <= last_bias; bias++) {
            if (!applies(method, i / 2)) continue;
            const figures g = results_figures(r, method, i % 2 ? 6 : 4, i / 2, bias, -1);
            s.queries += g.samples;
            s.failures += g.not_finite + g.out_of_range + g.crossed;
        }
    }
    return s;
}

// What `make stability` fails beyond: 99.9% and all errors by format, and a false shadow above the
// bias.
static const double limit_999[OWN_FORMATS] = {8e-3, 1e-3, 1e-3, 2.5e-2};
static const double limit_max[OWN_FORMATS] = {2e-2, 3e-3, 3e-3, 6e-2};

static int beyond_limits(results *r)
{
    int count = 0;
    for (int i = 0; i < 3 * 2 * OWN_FORMATS; i++) {
        const int method = i / 2 / OWN_FORMATS, format = i / 2 % OWN_FORMATS, m = i % 2 ? 6 : 4;
        if (!applies(method, format)) continue;
        const figures g = results_figures(r, method, m, format, safe_of(r), -1);
        const double bias = (double)plan_alpha(&r->p, safe_of(r), method, m, format);
        // Of few queries 99.9% are all of them.
        const int bad = (g.samples >= 10000 && g.error[2] > limit_999[format]) ||
                        g.error[3] > limit_max[format] || g.dark > bias + 6e-8 || g.unrepaired > 0;
        if (bad)
            printf("beyond its limits: %s, %d, %s\n", methods[method].name, m,
                   format_names[format]);
        count += bad;
    }
    return count;
}

static int write_minute(FILE *f, results *r)
{
    const sums ours = sums_of(r, METHOD_BOUNDS, 0, safe_of(r), FORMATS);
    const sums tables = sums_of(r, METHOD_STORED, 0, safe_of(r), FORMATS);
    const sums points = sums_of(r, METHOD_POINTS, 0, safe_of(r), FORMATS);
    const sums published = sums_of(r, METHOD_PUBLISHED, safe_of(r), safe_of(r), OWN_FORMATS);
    const sums inverse = sums_of(r, METHOD_INVERSE, safe_of(r), safe_of(r), OWN_FORMATS);
    const sums bare = sums_of(r, METHOD_CHOLESKY, NO_BIAS, NO_BIAS, OWN_FORMATS);
    sums paper[3];
    for (int i = 0; i < 3; i++)
        paper[i] = sums_of(r, METHOD_PAPER_INVERSE + i, safe_of(r), safe_of(r), OWN_FORMATS);
    fprintf(f,
            "## In a minute\n\n"
            "- **No NaN, nothing out of [0,1], no crossed bounds** from `mssm_visibility4/6`, "
            "`mssm_blocker_depth4/6` and the library's own\n  way of reading its tables, in %.1f "
            "million queries of twelve families at every bias from 0 to 1e-3 in six storage "
            "formats\n  (%.0f failures, without any tolerance). `mssm_reconstruct4/6`: %.0f in "
            "%.1f million, with 1e-5 for the rounding of sums.\n",
            (ours.queries + tables.queries) / 1e6, ours.failures + tables.failures, points.failures,
            points.queries / 1e6);
    fprintf(
        f,
        "- The published algorithm (Cholesky, roots, customary bias vector) fails in %.2f%% of "
        "the queries at the bias that is\n  provably safe for its vector, in %.0f%% without "
        "bias; with an explicit inverse of the moment matrix, in %.0f%% at a safe bias.\n"
        "- The methods that the image-based lighting paper tried for the weights, with the cubic "
        "of its reference [8], at the same safe bias: an explicit inverse\n  of the system fails "
        "in %.2f%%, LU in %.2f%%, QR in %.2f%% of the queries.\n",
        100 * published.failures / published.queries, 100 * bare.failures / bare.queries,
        100 * inverse.failures / inverse.queries, 100 * paper[0].failures / paper[0].queries,
        100 * paper[1].failures / paper[1].queries, 100 * paper[2].failures / paper[2].queries);
    fprintf(
        f, "- **Error of the bounds** against `__float128` at the safe bias, 99.9%% of queries / "
           "the worst of them:\n\n"
           "| storage | moments | safe bias | mssm.h | published | inverse of the moment matrix | "
           "LU of both systems | divided differences | paper: inverse of the weights | paper: LU | "
           "paper: QR |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (int i = 0; i < 2 * OWN_FORMATS; i++) {
        static const int shown[] = {METHOD_BOUNDS,   METHOD_PUBLISHED, METHOD_INVERSE,
                                    METHOD_LU,       METHOD_NEWTON,    METHOD_PAPER_INVERSE,
                                    METHOD_PAPER_LU, METHOD_PAPER_QR};
        const int m = i % 2 ? 6 : 4, format = i / 2;
        fprintf(f, "| %s | %d | %.3g |", format_titles[format], m,
                (double)safe_bias(m, format, VECTOR_OURS));
        for (int k = 0; k < 8; k++) {
            const figures g = results_figures(r, shown[k], m, format, safe_of(r), -1);
            fprintf(f, k ? " %s / %s |" : " **%s / %s** |", cell(g.error[2]), cell(g.error[3]));
        }
        fprintf(f, "\n");
    }
    fprintf(
        f, "\nNaN counts as an error of 1. `make stability` fails if an error of mssm.h is above "
           "8e-3 / 2e-2 in float32,\n1e-3 / 3e-3 in 16 bits or 2.5e-2 / 6e-2 in tables, if a false "
           "shadow exceeds the safe bias, or if that bias leaves moments invalid.\n\n"
           "![Distance to the truth against the bias](stability-bias.svg)\n\n"
           "![Error against the distance of two depths](stability-distance.svg)\n\n");
    return (ours.failures + tables.failures + points.failures > 0) + beyond_limits(r);
}

static void write_method_row(FILE *f, results *r, int method, int m, int format, int bias)
{
    const figures g = results_figures(r, method, m, format, bias, -1);
    const int bare = bias == NO_BIAS;
    const char *title = !bare                     ? methods[method].title
                        : method == METHOD_BOUNDS ? "mssm.h, no bias"
                                                  : "Cholesky, roots, no bias";
    fprintf(f, "| %s | %d | %d | %d | %d | %s | %s |", title, m, g.not_finite, g.out_of_range,
            g.crossed, cell(g.dark), cell(g.leak));
    for (int i = 0; i < 4; i++) fprintf(f, " %s |", bare ? "-" : cell(g.error[i]));
    fprintf(f, " %s |\n", bare ? "-" : cell(g.blocker[2]));
}

static void write_formats(FILE *f, results *r)
{
    fprintf(
        f, "## Method by method, at the safe bias\n\n"
           "All families together. *False shadow*: how far the upper bound lies below the share of "
           "depths that are not nearer than the\nreceiver; *leak*: how far the lower bound lies "
           "above the share that is behind it. In exact arithmetic neither exceeds\nthe bias. "
           "Errors are those of the worse bound against sharp bounds of the same moments in "
           "`__float128`; the last column is the\nblocker depth's, times the share that it stands "
           "for. Without bias most moments are of no distribution, so no error is defined.\n");
    for (int format = 0; format < OWN_FORMATS; format++) {
        const int per = results_figures(r, METHOD_BOUNDS, 4, format, safe_of(r), -1).samples;
        fprintf(f,
                "\n**%s** (%d queries a row)\n\n| method | moments | NaN or Inf | out of range | "
                "crossed | false shadow | leak | error 50%% | 99%% | 99.9%% | max | blocker "
                "99.9%% |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n",
                format_titles[format], per);
        for (int m = 4; m <= 6; m += 2) {
            for (int i = 0; i < METHODS; i++) {
                if (applies(i, format)) write_method_row(f, r, i, m, format, safe_of(r));
            }
            write_method_row(f, r, METHOD_BOUNDS, m, format, NO_BIAS);
            write_method_row(f, r, METHOD_CHOLESKY, m, format, NO_BIAS);
        }
    }
}

static void write_storage(FILE *f, results *r)
{
    fprintf(f,
            "\n## Tables that do not hold their moments\n\n"
            "No bias repairs what a float32 summed-area table loses, or a uint32 table that wraps. "
            "The math then gets moments of no\ndistribution; mssm.h uses their longest valid part, "
            "so results are in range but not right. (At the safe bias of its own table.)\n\n"
            "| table | moments | invalid moments | mssm.h: failures | false shadow | leak | "
            "published: failures |\n"
            "|---|---|---|---|---|---|---|\n");
    for (int i = 0; i < 6; i++) {
        const int m = i % 2 ? 6 : 4, format = FORMAT_TABLE + i / 2;
        const figures g = results_figures(r, METHOD_BOUNDS, m, format, safe_of(r), -1);
        const figures h = results_figures(r, METHOD_PUBLISHED, m, format, safe_of(r), -1);
        fprintf(f, "| %s | %d | %.1f%% | %d | %s | %s | %.2f%% |\n", format_titles[format], m,
                100.0 * g.unrepaired / g.samples, g.not_finite + g.out_of_range + g.crossed,
                cell(g.dark), cell(g.leak),
                100.0 * (h.not_finite + h.out_of_range + h.crossed) / h.samples);
    }
}

static void write_families(FILE *f, results *r)
{
    enum { SHOWN = 11 };
    static const int shown[SHOWN] = {METHOD_BOUNDS,   METHOD_POINTS,  METHOD_PUBLISHED,
                                     METHOD_CHOLESKY, METHOD_INVERSE, METHOD_LU,
                                     METHOD_NEWTON,   METHOD_CUBIC,   METHOD_PAPER_INVERSE,
                                     METHOD_PAPER_LU, METHOD_PAPER_QR};
    static const char *const about[FAMILY_COUNT] = {"one depth anywhere",
                                                    "one depth, exactly -1, 0 or 1",
                                                    "a plane, 1e-4 to 1 steep",
                                                    "two depths",
                                                    "two depths 1e-7 to 1e-2 apart",
                                                    "an edge with a slope on each side",
                                                    "three layers",
                                                    "4 to 16 depths, scattered",
                                                    "depths uniform in an interval",
                                                    "-1 and 1, or nearly so",
                                                    "one sample away from a flat patch",
                                                    "two depths with noise"};
    fprintf(f, "\n## Family by family, at the safe bias\n\n");
    for (int i = 0; i < FAMILY_COUNT; i++) {
        fprintf(f, "%s`%s` %s", !i ? "" : i % 3 ? "; " : ";\n", family_keys[i], about[i]);
    }
    fprintf(
        f,
        "\n\nLargest error, and in brackets how many of the %d queries failed (NaN, out of range "
        "or crossed).\n",
        r->p.patches * RECEIVERS);
    for (int i = 0; i < 2 * OWN_FORMATS; i++) {
        const int m = i % 2 ? 6 : 4, format = i / 2;
        fprintf(f, "\n**%s, %d moments**\n\n| family |", format_titles[format], m);
        for (int k = 0; k < SHOWN; k++) fprintf(f, " %s |", methods[shown[k]].name);
        fprintf(f, "\n|---|");
        for (int k = 0; k < SHOWN; k++) fprintf(f, "---|");
        fprintf(f, "\n");
        for (int family = 0; family < FAMILY_COUNT; family++) {
            fprintf(f, "| %s |", family_keys[family]);
            for (int k = 0; k < SHOWN; k++) {
                const figures g = results_figures(r, shown[k], m, format, safe_of(r), family);
                const int failures = g.not_finite + g.out_of_range + g.crossed;
                fprintf(f, " %s", cell(g.error[3]));
                if (failures) fprintf(f, " (%d)", failures);
                fprintf(f, " |");
            }
            fprintf(f, "\n");
        }
    }
}

static void write_onset(FILE *f, results *r)
{
    fprintf(
        f,
        "\n## Where each method starts to fail\n\n"
        "The largest bias up to 1e-3 at which a query returned NaN, left [0,1] or crossed its "
        "bounds, what the method did there, and\nwhat mssm.h does at the same bias. A bias below "
        "the safe one is the user's choice; the floors of the pivots then step in.\n\n"
        "| method | storage | moments | fails up to | NaN or Inf | out or crossed | false shadow "
        "| leak | mssm.h there: failures | false shadow | leak |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (int i = 0; i < METHODS * 2 * OWN_FORMATS; i++) {
        const int method = i / 2 / OWN_FORMATS, format = i / 2 % OWN_FORMATS, m = i % 2 ? 6 : 4;
        if (method < METHOD_PUBLISHED) continue;
        int bias = safe_of(r) - 1;
        figures g = results_figures(r, method, m, format, bias, -1);
        while (bias > 0 && !g.first_failure.m)
            g = results_figures(r, method, m, format, --bias, -1);
        const figures h = results_figures(r, METHOD_BOUNDS, m, format, bias, -1);
        fprintf(f, "| %s | %s | %d | %g%s | %d | %d | %s | %s | %d | %s | %s |\n",
                methods[method].name, format_names[format], m, (double)r->p.bias[bias],
                bias == safe_of(r) - 1 ? " or more" : "", g.not_finite, g.out_of_range + g.crossed,
                cell(g.dark), cell(g.leak), h.not_finite + h.out_of_range + h.crossed, cell(h.dark),
                cell(h.leak));
    }
}

static int write_further(FILE *f)
{
    const further *all[] = {further_tables, further_lights, further_probes};
    int broken = 0;
    fprintf(f, "\n## Tables, lights and probes at their limits\n\n"
               "`build/release/stability --case NAME` runs one row.\n\n"
               "| case | input | here | the usual way |\n"
               "|---|---|---|---|\n");
    for (int i = 0; i < 3; i++) {
        for (const further *c = all[i]; c->name; c++) {
            finding x;
            memset(&x, 0, sizeof x);
            c->run(&x);
            broken += !x.holds;
            fprintf(f, "| `%s` | %s | %s%s | %s |\n", c->name, x.what,
                    x.holds ? "" : "**broken:** ", x.ours, x.others);
            if (!x.holds) printf("broken: %s: %s\n", c->name, x.ours);
        }
    }
    return broken;
}

static void write_reproduce(FILE *f, results *r, double seconds)
{
    fprintf(
        f,
        "\n## To run it again\n\n"
        "`make stability` writes this page (%.0f seconds here); `--quick` takes one patch in 16. "
        "To run one line, with the queries of its largest error\nand first failure as "
        "hexadecimal floats:\n\n    build/release/stability --method cholesky --moments 6 "
        "--format float32 --family outlier --bias safe\n    build/release/stability --case "
        "full-kernels\n    build/release/stability --distance --moments 6 --format float32\n\n"
        "Methods: `mssm` (bounds and blocker depth), `mssm-points` (full reconstruction), "
        "`mssm-stored` (tables as the library reads them),\n`cholesky`, `cholesky-our-vector`, "
        "`inverse`, `lu`, `newton`, `cubic`, `paper-inverse`, `paper-lu`, `paper-qr`; \"no "
        "bias\" is `cholesky-our-vector --bias 0`. Formats: `float32`, `unorm16`,\n`filtered`, "
        "`table`, `float-sat`, `slides-table`. Leaving an option out means all. Each family has "
        "%d patches of 2 x 2 to 27 x 27\ntexels with five receivers: on a depth, 1e-7 to 3e-2 "
        "beside one, just outside of all, far outside, anywhere. Every run takes the same "
        "patches (others with `--seed N`); last digits\ndepend on the compiler. "
        "`build/stability.csv` has all lines at all biases.\n\n"
        "The other methods are textbook versions, written for this comparison in plain float32, "
        "without the clamps that a shader may add: a clamp hides a\nvalue out of range, and "
        "turns NaN into light or shadow. Customary bias vectors: even moments .375 .375 "
        "(float32) and .628 .628 (16 bits and tables) with 4,\n.5566 .489 .4787 with 6; the safe "
        "bias is that of the vector in use (`make bias`), so the published method gets a larger "
        "one.\n\n"
        "How much the tests notice: `make mutants` changes operators, constants, signs and "
        "statements of the moment math, the tables and the probe's cuts one at a time,\n240 of "
        "about 3600, and reports those that no test notices: 224 were noticed, 16 change nothing "
        "promised (each with its reason in `tests/mutants.txt`), 0 survived.\n\n"
        "The worst queries are kept in `tests/cases/` and run with `make test`. What is trusted "
        "and what is not: [security.md](security.md).\n",
        seconds, r->p.patches);
}

// ---- pictures ------------------------------------------------------------------------------

static const int drawn[] = {METHOD_BOUNDS,  METHOD_POINTS, METHOD_PUBLISHED, METHOD_CHOLESKY,
                            METHOD_INVERSE, METHOD_LU,     METHOD_NEWTON};
static const char *const drawn_names[] = {"mssm.h",
                                          "mssm.h, reconstruction",
                                          "published, customary vector",
                                          "published, our vector",
                                          "inverse of the moment matrix",
                                          "LU",
                                          "divided differences"};

static void add_series(chart *c)
{
    c->series = 7;
    for (int k = 0; k < 7; k++) c->name[k] = drawn_names[k];
}

static int write_bias_chart(results *r, const char *path)
{
    static chart c;
    c.title = "Six moments in float32: how far bounds lie on the wrong side of the truth (99% of "
              "queries of twelve families; NaN counts as 1)";
    c.x_name = "bias";
    c.y_name = "distance to the truth";
    c.x_low = 1e-8;
    c.x_high = 1e-3;
    c.y_low = 1e-7;
    c.y_high = 1;
    add_series(&c);
    for (int bias = 1; bias < safe_of(r); bias++) {
        c.x[c.points] = (double)r->p.bias[bias];
        for (int k = 0; k < 7; k++) {
            c.y[k][c.points] = results_figures(r, drawn[k], 6, FORMAT_FLOAT32, bias, -1).wrong[1];
        }
        c.points++;
    }
    return chart_write(&c, path);
}

static int write_distance_chart(int trials, const char *path)
{
    static chart c;
    static distance_row rows[DISTANCES];
    distance_run(6, FORMAT_FLOAT32, trials, rows);
    c.title = "Six moments in float32 at the safe bias: two depths that close up, error of the "
              "bounds (99.9% of queries; NaN counts as 1)";
    c.x_name = "distance of the two depths";
    c.y_name = "error against quad precision";
    c.x_low = 1e-7;
    c.x_high = 1;
    c.y_low = 1e-7;
    c.y_high = 1;
    add_series(&c);
    c.points = DISTANCES;
    for (int i = 0; i < DISTANCES; i++) {
        c.x[i] = rows[i].distance;
        for (int k = 0; k < 7; k++) c.y[k][i] = rows[i].error[drawn[k]];
    }
    return chart_write(&c, path);
}

int page_write(results *r, const char *folder, const char *csv, int trials, double seconds,
               int *broken)
{
    char path[400];
    snprintf(path, sizeof path, "%s/stability.md", folder);
    FILE *f = fopen(path, "w");
    if (!f) return 0;
    fprintf(
        f, "# Stability\n\n"
           "Where moment methods fail, and what `mssm.h` and `lightprobe.h` do there. Every number "
           "on this page was written by\n`make stability`; each line can be run again by itself "
           "(see the end).\n\n");
    *broken += write_minute(f, r);
    write_formats(f, r);
    write_onset(f, r);
    write_storage(f, r);
    *broken += write_further(f);
    write_families(f, r);
    write_reproduce(f, r, seconds);
    if (fclose(f)) return 0;
    snprintf(path, sizeof path, "%s/stability-bias.svg", folder);
    if (!write_bias_chart(r, path)) return 0;
    snprintf(path, sizeof path, "%s/stability-distance.svg", folder);
    return write_distance_chart(trials, path) && write_csv(r, csv);
}
