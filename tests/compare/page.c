// docs/accuracy.md, see page.h. The words are here, every number and every choice comes from the
// figures.
#include "page.h"

#include <math.h>
#include <string.h>

#include "charts.h"
#include "summary.h"

const char page_mark[] =
    "<!-- Written by `make chart` from accuracy.csv: change tests/compare/page.c instead. -->\n";

// Columns of tables with a row a scene or size.
enum { COLUMNS_MOST = 10 };
typedef struct columns {
    int count;
    const char *name[COLUMNS_MOST];
} columns;

static const columns soft = {10,
                             {"hard", PCSS_ALL, PCSS_NORMAL, CONVOLUTION_MIPS,
                              "MSSM 6, lower blocker", "MSSM 6, upper blocker",
                              "layered, 4 moments", LAYERED, LAYERED_NORMAL, BACK_PROJECTION}};
static const columns hard = {
    7, {"hard", PCF_GAUSSIAN, "VSM, Gaussian", EVSM_HALVES, EVSM_GAUSSIAN, FILTERED_4, FILTERED_6}};

// ---- Choices

typedef struct choice {
    bool constant_time;
    double ns, error; // at most
} choice;

// The most accurate method, or the fastest, of those that fit; NULL if none does.
static const char *choose(const figures *f, choice limit, bool fastest)
{
    const names methods = methods_of(f, "error");
    const char *best = NULL;
    double lowest = HUGE_VAL;
    for (int i = 0; i < methods.count; i++) {
        const char *m = methods.list[i];
        const double error = method_error(f, m), ns = method_ns(f, m), value = fastest ? ns : error;
        if (!(error <= limit.error && ns <= limit.ns) ||
            (limit.constant_time && !method_constant_time(f, m)))
            continue;
        if (value >= lowest) continue;
        lowest = value;
        best = m;
    }
    if (!best) return NULL;
    for (int i = 0; i < f->count; i++) // the name in the figures outlives the next call
        if (!strcmp(f->list[i].method, best)) return f->list[i].method;
    return NULL;
}

static const char *best_constant(const figures *f)
{
    return choose(f, (choice){true, HUGE_VAL, HUGE_VAL}, false);
}

// The widest kernel of those measured at which that PCSS is still faster; 0: none.
static double pcss_faster_up_to(const figures *f, const char *pcss, const char *method)
{
    const numbers widths = sweep_of(f, "kernel", method, "ns");
    double up_to = 0;
    for (int i = 0; i < widths.count; i++)
        if (mean_of(f, "kernel", NULL, pcss, widths.list[i], "ns") <
            mean_of(f, "kernel", NULL, method, widths.list[i], "ns"))
            up_to = widths.list[i];
    return up_to;
}

// What the columns of both tables of methods hold; the first table has the first ones.
static const struct {
    const char *name, *experiment, *metric;
    int decimals;
} method_columns[] = {{"rms", "overall", "rms", 3},
                      {"unseen", "unseen", "rms", 3},
                      {"rows that fall, %", "eye", "falling_rows", 1},
                      {"flicker", "overall", "step_rms", 4},
                      {"ns", "overall", "ns", 0},
                      {"new", "new", "rms", 3},
                      {"structure", "eye", "structure", 3},
                      {"deepest", "eye", "deepest_fall", 3},
                      {"FLIP", "eye", "flip", 3},
                      {"bias", "overall", "bias", 0}};
enum { COLUMNS_FIRST = 5, COLUMNS_ALL = sizeof method_columns / sizeof *method_columns };

static void write_methods(const figures *f, FILE *page, const names *methods, int width)
{
    fprintf(page, "| method |");
    for (int k = 0; k < width; k++) fprintf(page, " %s |", method_columns[k].name);
    fprintf(page, " at any width | MiB |\n|---|");
    for (int k = 0; k < width + 2; k++) fprintf(page, "---|");
    for (int i = 0; i < methods->count; i++) {
        fprintf(page, "\n| %s |", methods->list[i]);
        for (int k = 0; k < width; k++) {
            const double v = mean_of(f, method_columns[k].experiment, "all", methods->list[i], 0,
                                     method_columns[k].metric);
            if (isnan(v))
                fprintf(page, " - |");
            else
                fprintf(page, " %.*f |", method_columns[k].decimals, v);
        }
        const double bytes = method_bytes(f, methods->list[i]);
        fprintf(page, " %s |", method_constant_time(f, methods->list[i]) ? "yes" : "no");
        fprintf(page, isnan(bytes) ? " - |" : " %.2f |", bytes / 1048576);
    }
    fprintf(page, "\n\n");
}

// What a reader has to choose between.
static void write_choice(const figures *f, FILE *page)
{
    static const names methods = {11,
                                  {"hard", "PCSS, 16 samples", PCSS_ALL, PCSS_NORMAL, "EVSM",
                                   CONVOLUTION_MIPS, BACK_PROJECTION, "MSSM 6, lower blocker",
                                   "layered, 4 moments", LAYERED, LAYERED_NORMAL}};
    write_methods(f, page, &methods, COLUMNS_FIRST);
    fprintf(
        page,
        "rms: error of visibility against rays, over %d scenes and all light sizes; unseen: over "
        "%d that were made after all tuning. rows that fall: of rows of receivers outwards over "
        "the shadow of one box, those in which visibility falls by more than 0.03 where the truth "
        "rises. flicker: rms error of the change from frame to frame while sun or caster move. ns: "
        "per receiver on one core, mean over light sizes; the library takes many at once. at any "
        "width: does the widest kernel cost less than 1.5 times the narrowest? MiB: of a map of "
        "256 x 256 texels. \"normal\": knows the receiver's normal; PCSS takes from it a bias that "
        "follows the receiver's plane (Isidoro 2006). [All methods](#all-methods) are below.\n\n",
        scenes_of(f, "error").count, scenes_of(f, "unseen").count);
}

static void write_all_methods(const figures *f, FILE *page)
{
    const names methods = methods_of(f, "error");
    fprintf(page, "## All methods\n\n");
    write_methods(f, page, &methods, COLUMNS_ALL);
    fprintf(page,
            "As in the first table; new: rms over %d scenes that reviewers made up to show faults. "
            "structure: rms difference between the errors of receivers a texel apart. deepest: the "
            "deepest fall of a row. FLIP (Andersson and others 2020): mean of two pictures against "
            "those by rays. bias: in texels, the one with which a rival errs least over the "
            "scenes.\n\n",
            scenes_of(f, "new").count);
}

static void write_advice(const figures *f, FILE *page)
{
    const char *best = best_constant(f);
    if (!best) return;
    const double error = method_error(f, best);
    fprintf(page,
            "**Take \"%s\".** Of all methods whose time does not depend on the light's size it has "
            "the least error over the chart's scenes: %.3f, where a hard shadow map has %.3f, PCSS "
            "that reads every texel %.3f and PCSS whose bias follows the receiver's plane %.3f, in "
            "%.1f microseconds a receiver on one core. Within 5%% of that error the fastest is "
            "\"%s\"; with at most half of its time the most accurate is \"%s\". ",
            best, error, method_error(f, "hard"), method_error(f, PCSS_ALL),
            method_error(f, PCSS_NORMAL), method_ns(f, best) / 1e3,
            choose(f, (choice){true, HUGE_VAL, 1.05 * error}, true),
            choose(f, (choice){true, 0.5 * method_ns(f, best), HUGE_VAL}, false));
    const comparison pcss = compare(f, "error", NULL, best, PCSS_NORMAL, "rms"),
                     exact = compare(f, "error", NULL, best, BACK_PROJECTION, "rms");
    fprintf(
        page,
        "Where it loses: of %d pairs of scene and light size, that PCSS has less error in %d and "
        "back-projection in %d; ",
        pcss.cases, pcss.cases - pcss.lower, exact.cases - exact.lower);
    fprintf(page,
            "PCSS that reads every texel is faster where kernels stay below about %g texels, or in "
            "vectors of four below about %g; on a GPU, PCSS of 16 samples takes less than either "
            "([OpenGL](#opengl)).\n\n",
            pcss_faster_up_to(f, PCSS_ALL, best), pcss_faster_up_to(f, PCSS_VECTORS, best));
    write_choice(f, page);
}

// ---- Sections

// The heading, and the picture with its message.
static bool write_section(const figures *f, FILE *page, const char *heading, const char *file)
{
    const chart *c = chart_named(file);
    char text[512];
    if (!chart_possible(f, c)) return false;
    c->message(f, text, sizeof text);
    fprintf(page, "## %s\n\n%s\n\n![%s](%s)\n\n", heading, text, heading, file);
    return true;
}

// "0.043 (0.029-0.054)", or the value alone if it has no spread.
static void write_spread(FILE *page, const summary *s, int decimals)
{
    if (!s->count)
        fprintf(page, " - |");
    else if (s->low == s->high)
        fprintf(page, " %.*f |", decimals, s->mean);
    else
        fprintf(page, " %.*f (%.*f to %.*f) |", decimals, s->mean, decimals, s->low, decimals,
                s->high);
}

static void write_columns(FILE *page, const columns *c, const char *first)
{
    fprintf(page, "| %s |", first);
    for (int i = 0; i < c->count; i++) fprintf(page, " %s |", c->name[i]);
    fprintf(page, "\n|---|");
    for (int i = 0; i < c->count; i++) fprintf(page, "---|");
    fprintf(page, "\n");
}

// One row of a table with those columns; the least is bold.
static void write_row(const figures *f, FILE *page, const columns *c, const char *experiment,
                      const char *scene, double x, const char *metric, int decimals)
{
    double value[COLUMNS_MOST], least = HUGE_VAL;
    for (int i = 0; i < c->count; i++) {
        value[i] = mean_of(f, experiment, scene, c->name[i], x, metric);
        if (!isnan(value[i])) least = fmin(least, value[i]);
    }
    for (int i = 0; i < c->count; i++) {
        char text[32];
        if (isnan(value[i]))
            snprintf(text, sizeof text, "-");
        else
            snprintf(text, sizeof text, "%.*f", decimals, value[i]);
        fprintf(page, value[i] == least ? " **%s** |" : " %s |", text);
    }
    fprintf(page, "\n");
}

static void write_scenes(const figures *f, FILE *page)
{
    static const char *const group[] = {"error", "new", "unseen"};
    if (!scenes_of(f, "error").count) return;
    fprintf(
        page,
        "## Scene by scene\n\n"
        "Rms error of visibility, mean over light sizes; the least is bold. The chart's scenes, "
        "then those that reviewers made up, then those made after all tuning.\n\n");
    write_columns(page, &soft, "scene");
    for (int k = 0; k < 3; k++) {
        const names scenes = scenes_of(f, group[k]);
        for (int i = 0; i < scenes.count; i++) {
            fprintf(page, "| %s |", scenes.list[i]);
            write_row(f, page, &soft, group[k], scenes.list[i], NAN, "rms", 3);
        }
    }
    fprintf(page, "\n");
}

static void write_sweep(const figures *f, FILE *page, const char *heading, const char *file,
                        const char *experiment, const char *metric, const char *words, int decimals)
{
    const numbers sweep = sweep_of(f, experiment, LAYERED, metric);
    if (!write_section(f, page, heading, file)) return;
    fprintf(page, "%s\n\n", words);
    write_columns(page, &soft, experiment[0] == 'k' ? "texels" : "tangent");
    for (int i = 0; i < sweep.count; i++) {
        fprintf(page, "| %g |", sweep.list[i]);
        write_row(f, page, &soft, experiment, NULL, sweep.list[i], metric, decimals);
    }
    fprintf(page, "\n");
}

static void write_side(const figures *f, FILE *page)
{
    const numbers sides = sweep_of(f, "side", LAYERED, "rms");
    if (!write_section(f, page, "Side of the map", "map_side.svg")) return;
    fprintf(page,
            "Methods that read the depth map itself have nothing to update. \"%s\":\n\n| side | "
            "rms error | ns a receiver | ms an update | MiB "
            "|\n|---|---|---|---|---|\n",
            LAYERED);
    for (int i = 0; i < sides.count; i++) {
        const double x = sides.list[i];
        const summary update = summarize(f, "side", NULL, LAYERED, x, "update_ms");
        fprintf(page, "| %g | %.3f | %.0f |", x, mean_of(f, "side", NULL, LAYERED, x, "rms"),
                mean_of(f, "side", NULL, LAYERED, x, "ns"));
        write_spread(page, &update, 2);
        fprintf(page, " %.2f |\n", mean_of(f, "side", NULL, LAYERED, x, "bytes") / 1048576);
    }
    fprintf(page, "\n");
    write_section(f, page, "Memory", "memory.svg");
}

static void write_temporal(const figures *f, FILE *page)
{
    const names scenes = scenes_of(f, "temporal");
    if (!write_section(f, page, "Moving suns and casters", "temporal.svg") || !scenes.count) return;
    fprintf(
        page,
        "The rms difference between a method's change from one frame to the next and the "
        "truth's; \"truth\" is the truth's own change. Mean over light sizes; the least is bold."
        "\n\n");
    write_columns(page, &soft, "scene");
    for (int i = 0; i < scenes.count; i++) {
        fprintf(page, "| %s |", scenes.list[i]);
        write_row(f, page, &soft, "temporal", scenes.list[i], NAN, "step_rms", 4);
    }
    fprintf(page, "\n");
}

// Lights too weak for a shadow map, left to nine harmonics.
static void write_weak_lights(const figures *f, FILE *page)
{
    const numbers least = sweep_of(f, "weak", "min_shadow", "maps");
    if (!least.count) return;
    fprintf(page,
            "32 lights, of which the weakest are left to nine harmonics without a shadow map "
            "(`min_shadow` of `lightprobe_extract`); means over probes:\n\n"
            "| min_shadow | maps | behind edges, %% | with shadows, %% |\n|---|---|---|---|\n");
    for (int i = 0; i < least.count; i++)
        fprintf(page, "| %g | %.1f | %.2f | %.2f |\n", least.list[i],
                mean_of(f, "weak", NULL, "min_shadow", least.list[i], "maps"),
                mean_of(f, "weak", NULL, "min_shadow", least.list[i], "blocked_rms"),
                mean_of(f, "weak", NULL, "min_shadow", least.list[i], "picture_rms"));
    fprintf(page, "\n");
}

static void write_lights(const figures *f, FILE *page)
{
    const names probes = scenes_of(f, "lights"), methods = methods_of(f, "lights");
    if (!write_section(f, page, "Lights of a probe", "lights.svg")) return;
    fprintf(
        page,
        "Rms errors in %% of the mean: of the irradiance behind 1200 random straight edges, of "
        "surface points of a scene with shadows, and of the irradiance where nothing is in "
        "between; and milliseconds to find the lights. \"One sun and ambient\" (in the picture) "
        "is the brightest light and nine harmonics of all else. Each way is shaded as its paper "
        "does: median cut by discs (Eq. 18), greedy rectangles (Annen and others 2008, section "
        "4.2) as area lights by the cosine to their middle, variance cuts (Viriyothai and "
        "Debevec 2009) as points at the regions' centroids. This library's irradiance is clipped at "
        "the horizon and has the visibility of the part above it (MSSM_HORIZON); the others are "
        "shadowed by the default estimator with the normal, which is better for them. Greedy rectangles have a threshold "
        "instead of a number: the one that comes nearest from below is searched for, which is "
        "not timed. The last two are written plainly, so their times are those of a first "
        "implementation; median cut and its points are timed as the library does them, from texels: "
        "with the paper's tables they take less ([figures.md](figures.md#time-to-find-the-lights))."
        "\n\n"
        "| probe | lights by, 8 / 32 | lights | behind edges | with shadows | nothing between | "
        "ms |\n"
        "|---|---|---|---|---|---|---|\n");
    static const char *const metric[][2] = {{"edges", "blocked_rms"},
                                            {"lights", "picture_rms"},
                                            {"lights", "irradiance_rms"},
                                            {"lights", "ms"}};
    for (int i = 0; i < probes.count; i++)
        for (int k = 0; k < methods.count; k++) {
            const char *probe = probes.list[i], *m = methods.list[k];
            fprintf(page, "| %s | %s | %.0f / %.0f |", probe, m,
                    mean_of(f, "lights", probe, m, 8, "found"),
                    mean_of(f, "lights", probe, m, 32, "found"));
            for (int j = 0; j < 4; j++)
                fprintf(page, " %.2f / %.2f |", mean_of(f, metric[j][0], probe, m, 8, metric[j][1]),
                        mean_of(f, metric[j][0], probe, m, 32, metric[j][1]));
            fprintf(page, "\n");
        }
    fprintf(page, "\n");
    write_weak_lights(f, page);
}

static void write_settings(const figures *f, FILE *page)
{
    const names tolerances = methods_of(f, "tolerance"), settings = methods_of(f, "setting");
    if (write_section(f, page, "As little as the scene needs", "settings.svg")) {
        fprintf(page, "| setting | rms error | ns a receiver |\n|---|---|---|\n");
        for (int i = 0; i < settings.count; i++)
            fprintf(page, "| %s | %.4f | %.0f |\n", settings.list[i],
                    mean_of(f, "setting", NULL, settings.list[i], NAN, "rms"),
                    mean_of(f, "setting", NULL, settings.list[i], NAN, "ns"));
        fprintf(page, "\n");
    }
    if (!tolerances.count) return;
    fprintf(page,
            "As many lights as a tolerance of `lightprobe_extract` asks for, means over probes:\n\n"
            "| setting | lights | rms error with shadows, %% | us a surface point "
            "|\n|---|---|---|---|\n");
    for (int i = 0; i < tolerances.count; i++) {
        const char *m = tolerances.list[i];
        fprintf(page, "| %s | %.0f | %.2f | %.1f |\n", m,
                mean_of(f, "tolerance", NULL, m, NAN, "lights"),
                mean_of(f, "tolerance", NULL, m, NAN, "picture_rms"),
                mean_of(f, "tolerance", NULL, m, NAN, "shade_ns") / 1e3);
    }
    fprintf(page, "\n");
}

// Rows by radius.
static void write_hard_sweep(const figures *f, FILE *page, const char *words, const char *metric,
                             int decimals)
{
    const numbers radii = sweep_of(f, "hard", FILTERED_4, metric);
    fprintf(page, "%s; the least is bold.\n\n", words);
    write_columns(page, &hard, "radius");
    for (int i = 0; i < radii.count; i++) {
        fprintf(page, "| %g |", radii.list[i]);
        write_row(f, page, &hard, "hard", NULL, radii.list[i], metric, decimals);
    }
    fprintf(page, "\n");
}

// What a method does wrong, and what a new map costs it, at the radius of the table of scenes.
static void write_hard_faults(const figures *f, FILE *page, double x)
{
    const names methods = methods_of(f, "hard");
    fprintf(page,
            "At a radius of %g: the error weighted by the receiver's cosine to the light, as it is "
            "shaded; light where all rays are blocked; darkness where none is; the rms difference "
            "from percentage-closer filtering of the same map; the cost of a new map.\n\n"
            "| method | as shaded | leak | false shadow | against PCF | ms an update |\n"
            "|---|---|---|---|---|---|\n",
            x);
    for (int i = 0; i < methods.count; i++) {
        const char *m = methods.list[i];
        fprintf(
            page, "| %s | %.3f | %.4f | %.4f | %.3f | %.2f |\n", m,
            mean_of(f, "hard", NULL, m, x, "shaded_rms"), mean_of(f, "hard", NULL, m, x, "leak"),
            mean_of(f, "hard", NULL, m, x, "false_shadow"),
            mean_of(f, "hard", NULL, m, x, "pcf_rms"), mean_of(f, "hard", NULL, m, x, "update_ms"));
    }
    fprintf(page, "\n");
}

static void write_hard_wins(const figures *f, FILE *page, const char *method)
{
    const comparison pcf = compare(f, "hard_scene", NULL, method, PCF_GAUSSIAN, "rms"),
                     evsm = compare(f, "hard_scene", NULL, method, EVSM_GAUSSIAN, "rms");
    fprintf(page,
            " \"%s\" has less error than percentage-closer filtering in %d of %d scenes and than "
            "EVSM in %d.",
            method, pcf.lower, pcf.cases, evsm.lower);
}

static void write_hard(const figures *f, FILE *page)
{
    const names scenes = scenes_of(f, "hard_scene");
    const numbers radii = sweep_of(f, "hard_scene", FILTERED_4, "rms");
    if (!write_section(f, page, "Filtered hard shadows", "hard.svg")) return;
    fprintf(
        page,
        "A light without size over the same scenes; one map of 256 x 256 under a Gaussian of 2 "
        "radius + 1 texels, read bilinearly. The truth is what percentage-closer filtering would "
        "give with infinitely small texels and a bias that follows the surface: rays along the "
        "light, all over the kernel, from the receiver's tangent plane or the surface that bends "
        "out of it. Percentage-closer filtering reads every texel under the kernel, four at a "
        "time in vectors. Rivals get the bias that suits them best at each radius, the library "
        "its default. A texel takes 32 bits with depth alone, 64 with VSM, \"" EVSM_HALVES
        "\" and \"" FILTERED_4 "\", 96 with \"" FILTERED_6 "\" and 128 with \"" EVSM_GAUSSIAN
        "\". EVSM has the exponents with the least error here "
        "(about 1 and 10); 40 and 5, which are common, leak less and err by a tenth more.\n\n");
    write_hard_sweep(f, page, "Rms error of visibility, mean over scenes", "rms", 3);
    write_hard_sweep(f, page, "Nanoseconds a receiver", "ns", 0);
    if (!radii.count) return;
    write_hard_faults(f, page, radii.list[0]);
    fprintf(page, "Rms error of visibility at that radius; the least is bold.");
    write_hard_wins(f, page, FILTERED_4);
    write_hard_wins(f, page, FILTERED_6);
    fprintf(page, "\n\n");
    write_columns(page, &hard, "scene");
    for (int i = 0; i < scenes.count; i++) {
        fprintf(page, "| %s |", scenes.list[i]);
        write_row(f, page, &hard, "hard_scene", scenes.list[i], radii.list[0], "rms", 3);
    }
    fprintf(page, "\n");
}

// Whatever was measured, a row for each method and x, a column for each metric; medians.
static void write_all(const figures *f, FILE *page, const char *heading, const char *words,
                      const char *experiment, const char *swept)
{
    const names methods = methods_of(f, experiment), metrics = metrics_of(f, experiment);
    if (!methods.count) return;
    fprintf(page, "## %s\n\n%s\n\n| | %s |", heading, words, swept);
    for (int i = 0; i < metrics.count; i++) fprintf(page, " %s |", metrics.list[i]);
    fprintf(page, "\n|---|---|");
    for (int i = 0; i < metrics.count; i++) fprintf(page, "---|");
    fprintf(page, "\n");
    for (int k = 0; k < methods.count; k++) {
        const numbers sweep = sweep_of(f, experiment, methods.list[k], NULL);
        for (int j = 0; j < sweep.count; j++) {
            fprintf(page, "| %s | %g |", methods.list[k], sweep.list[j]);
            for (int i = 0; i < metrics.count; i++) {
                const double value =
                    mean_of(f, experiment, NULL, methods.list[k], sweep.list[j], metrics.list[i]);
                if (isnan(value))
                    fprintf(page, " - |");
                else
                    fprintf(page, value >= 1000 ? " %.0f |" : " %.3g |", value);
            }
            fprintf(page, "\n");
        }
    }
    fprintf(page, "\n");
}

static void write_arrays(const figures *f, FILE *page)
{
    const names methods = methods_of(f, "array");
    if (!methods.count) return;
    fprintf(page,
            "## Bounds one by one and over arrays\n\n"
            "Nanoseconds a receiver, and how many times faster than the published algorithm in "
            "the same run.\n\n| | published | mssm.h | times faster |\n|---|---|---|---|\n");
    for (int i = 0; i < methods.count; i++) {
        const char *m = methods.list[i];
        const summary faster = summarize(f, "array", NULL, m, NAN, "speedup");
        char published[FIGURE_NAME + 16], own[FIGURE_NAME + 16];
        if (!faster.count) continue;
        snprintf(published, sizeof published, "%s, published", m);
        snprintf(own, sizeof own, "%s, mssm.h", m);
        fprintf(page, "| %s | %.1f | %.1f |", m, mean_of(f, "array", NULL, published, NAN, "ns"),
                mean_of(f, "array", NULL, own, NAN, "ns"));
        write_spread(page, &faster, 2);
        fprintf(page, "\n");
    }
    fprintf(page, "\n");
}

// ---- OpenGL

// How many times another's figure that of a method is, at the largest number of lights.
static double gl_ratio(const figures *f, const char *own, const char *other, const char *metric)
{
    const numbers lights = sweep_of(f, "gl", own, metric);
    const double x = lights.count ? lights.list[lights.count - 1] : NAN;
    return mean_of(f, "gl", NULL, own, x, metric) / mean_of(f, "gl", NULL, other, x, metric);
}

// What the page says first of the tables: against each rival, in time, error and memory.
static void write_gl_conclusion(const figures *f, FILE *page)
{
    static const char *const rivals[] = {LAYERED,
                                         PCSS_TAPS,
                                         PCSS_GATHER,
                                         PCSS_POISSON,
                                         PCSS_GATHER_NORMAL,
                                         PCSS_POISSON_NORMAL,
                                         PCSS_MORE_NORMAL,
                                         CONVOLUTION_TABLES,
                                         CONVOLUTION_MIPS,
                                         "MSSM 4, upper blocker",
                                         "MSSM 6, upper blocker"};
    static const char *const metric[] = {"shade_ms", "frame_ms", "rms", "flip", "bytes"};
    const numbers lights = sweep_of(f, "gl", LAYERED, "frame_ms");
    fprintf(page,
            "\"%s\" with %g lights, in shares of each rival's; below 1 it needs less:\n\n"
            "| against | shading | frame | error | FLIP | memory |\n|---|---|---|---|---|---|\n",
            LAYERED_HORIZON, lights.list[lights.count - 1]);
    for (size_t i = 0; i < sizeof rivals / sizeof *rivals; i++) {
        fprintf(page, "| %s |", rivals[i]);
        for (int k = 0; k < 5; k++)
            fprintf(page, " %.2f |", gl_ratio(f, LAYERED_HORIZON, rivals[i], metric[k]));
        fprintf(page, "\n");
    }
    const numbers widths = sweep_of(f, "gl_kernel", LAYERED, "shade_ms");
    const summary all = summarize(f, "gl_kernel", NULL, LAYERED, NAN, "shade_ms");
    if (all.count)
        fprintf(
            page,
            "\nFrom kernels of %g to %g texels the time of shading with \"%s\" stays within %.0f%%.",
            widths.list[0], widths.list[widths.count - 1], LAYERED,
            100 * (all.most / all.least - 1));
    fprintf(page,
            "\nTimes are of llvmpipe, a rasterizer on the CPU. What GPUs execute is in "
            "[gpu.md](gpu.md): there convolution and PCSS of few samples need less arithmetic and "
            "fewer reads than layered shadows; only methods that read every texel need more.\n\n");
}

// The error with each bias that was tried.
static void write_gl_bias(const figures *f, FILE *page)
{
    const names methods = methods_of(f, "gl_bias");
    const numbers tried = sweep_of(f, "gl_bias", NULL, "rms");
    if (!methods.count) return;
    fprintf(page, "Error, %%, by the bias in texels; the tables above have the least.\n\n| bias |");
    for (int k = 0; k < tried.count; k++) fprintf(page, " %g |", tried.list[k]);
    fprintf(page, "\n|---|");
    for (int k = 0; k < tried.count; k++) fprintf(page, "---|");
    for (int i = 0; i < methods.count; i++) {
        fprintf(page, "\n| %s |", methods.list[i]);
        for (int k = 0; k < tried.count; k++)
            fprintf(page, " %.1f |",
                    mean_of(f, "gl_bias", NULL, methods.list[i], tried.list[k], "rms"));
    }
    fprintf(page, "\n\n");
}

static void write_gl(const figures *f, FILE *page)
{
    static const char *const metric[] = {"rms",      "flip",  "shade_ms",   "update_ms",
                                         "frame_ms", "reads", "dispatches", "bytes"};
    static const int decimals[] = {2, 3, 1, 1, 1, 1, 0, 1};
    const names methods = methods_of(f, "gl");
    const numbers lights = sweep_of(f, "gl", LAYERED, "frame_ms");
    if (!lights.count) return;
    fprintf(page, "## OpenGL\n\n"
                  "The same comparison in OpenGL, with the driver of the machine that measured. ");
    write_gl_conclusion(f, page);
    fprintf(
        page,
        "Medians of rounds in which all methods take turns. The error is that of the whole "
        "picture, in %% of its mean, against rays to the lights from every surface, which count "
        "by solid angle and cosine what each light sends from above the horizon; \"truth\" "
        "is the rays' own error. Every method's visibility multiplies the irradiance that is "
        "clipped at the horizon; \"horizon\" is MSSM_HORIZON, which the guide takes for such "
        "lights. PCSS with the normal does not count the receiver's plane as a blocker. "
        "Rivals have the bias that is best here, one for the whole map; "
        "with \"normal\" that of PCSS follows the receiver's plane. The library's depth maps "
        "have 4 samples a texel, its default; the rivals' have one: PCSS has no use for more, "
        "and convolution with 4 is in "
        "[figures.md](figures.md#64-lights-of-a-probe-by-every-technique). MSSM uses front faces "
        "alone, with which it errs less here than with its paper's means of front and back. "
        "Convolution has the offset, scale, sharpening and mip level that are best for this "
        "picture. "
        "Samples over 8 frames add up under a light and a view that stand still, the best case "
        "for any history; a frame pays for one of them. Reads are texels per receiver and light; "
        "an update is everything between depth maps and shading, a frame depth maps, update and "
        "shading; memory is what shading reads for all lights, with maps of 256 x 256. The "
        "picture is %g pixels wide, for errors 192.\n\n",
        mean_of(f, "gl", NULL, LAYERED, lights.list[0], "width"));
    for (int j = 0; j < lights.count; j++) {
        fprintf(page,
                "| %g lights | error, %% | FLIP | shading, ms | update, ms | frame, ms | reads | "
                "dispatches | MiB |\n|---|---|---|---|---|---|---|---|---|\n",
                lights.list[j]);
        for (int i = 0; i < methods.count; i++) {
            fprintf(page, "| %s |", methods.list[i]);
            for (int k = 0; k < 8; k++) {
                const double unit = k == 7 ? 1.0 / 1048576 : 1;
                const double v =
                    unit * mean_of(f, "gl", NULL, methods.list[i], lights.list[j], metric[k]);
                if (isnan(v))
                    fprintf(page, " - |");
                else
                    fprintf(page, " %.*f |", v >= 100 ? 0 : decimals[k], v);
            }
            fprintf(page, "\n");
        }
        fprintf(page, "\n");
    }
    write_gl_bias(f, page);
}

// ---- Pictures

// Drawn by pictures.c, which has these sizes and colours.
static void write_pictures(const figures *f, FILE *page)
{
    const names methods = methods_of(f, "error");
    if (!methods.count) return;
    fprintf(
        page,
        "## Side by side\n\n"
        "The light is a square of tangent 0.25; every method sees the same depth map of 256 x "
        "256 texels, and the truth takes 1024 rays a pixel. Below each picture is its error: "
        "blue where it is too bright, orange where too dark, grey where right, at full strength "
        "from a difference of 0.5 in visibility on. The rms error is over all points whose "
        "horizon is below the whole light.\n\n"
        "![The demo's scene by five methods, beside the truth](methods_demo.png)\n\n"
        "Stacked grids, where blockers at several depths overlap and methods that know one "
        "blocker depth fail:\n\n"
        "![Grids above each other by five methods, beside the truth](methods_grids.png)\n\n");
}

// ---- Figures to reach

static void write_goal(FILE *page, const char *goal, double measured, double limit,
                       const comparison *scenes)
{
    if (isnan(measured)) {
        fprintf(page, "| %s | not measured | - | - |\n", goal);
        return;
    }
    fprintf(page, "| %s | %.2f | ", goal, measured);
    if (scenes && scenes->cases > 1)
        fprintf(page, "%.2f to %.2f (%s) | ", scenes->least, scenes->most, scenes->worst);
    else
        fprintf(page, "- | ");
    fprintf(page, "%s |\n", measured <= limit ? "reached" : "**missed**");
}

static void write_error_goals(const figures *f, FILE *page)
{
    static const struct {
        const char *goal, *other;
        double limit;
    } goals[] = {
        {"error / PCSS reading every texel, below 1", PCSS_ALL, 1},
        {"error / PCSS that knows the normal, below 1", PCSS_NORMAL, 1},
        {"error / full back-projection, at most 1.15", BACK_PROJECTION, 1.15},
        {"error / CSSM16 in mip maps, below 1", CONVOLUTION_MIPS, 1},
        {"error / MSSM with 6 moments, lower blocker, at most 0.75", "MSSM 6, lower blocker", 0.75},
        {"error / MSSM with 6 moments, upper blocker, at most 0.75", "MSSM 6, upper blocker",
         0.75}};
    for (size_t i = 0; i < sizeof goals / sizeof *goals; i++) {
        const comparison c = compare(f, "error", NULL, LAYERED, goals[i].other, "rms");
        write_goal(page, goals[i].goal, c.ratio, goals[i].limit, &c);
    }
}

static void write_time_goals(const figures *f, FILE *page)
{
    const numbers widths = sweep_of(f, "kernel", LAYERED, "ns");
    const double x = nearest(&widths, 101), own = mean_of(f, "kernel", NULL, LAYERED, x, "ns");
    const summary all = summarize(f, "kernel", NULL, LAYERED, NAN, "ns");
    const double ns = method_ns(f, LAYERED);
    write_goal(page, "time / PCSS reading every texel at 101 x 101 kernels, at most 0.1",
               own / mean_of(f, "kernel", NULL, PCSS_ALL, x, "ns"), 0.1, NULL);
    write_goal(page, "time / CSSM16 in mip maps, below 1", ns / method_ns(f, CONVOLUTION_MIPS), 1,
               NULL);
    write_goal(page, "time / MSSM with 6 moments, lower blocker, below 2",
               ns / method_ns(f, "MSSM 6, lower blocker"), 2, NULL);
    write_goal(page, "time / MSSM with 6 moments, upper blocker, below 2",
               ns / method_ns(f, "MSSM 6, upper blocker"), 2, NULL);
    write_goal(page, "time, slowest / fastest kernel width, at most 1.15", all.most / all.least,
               1.15, NULL);
    write_goal(page, "memory / CSSM16 in tables, below 0.33",
               method_bytes(f, LAYERED) / method_bytes(f, CONVOLUTION_TABLES), 1.0 / 3, NULL);
    write_goal(page, "memory / CSSM16 in mip maps, below 1",
               method_bytes(f, LAYERED) / method_bytes(f, CONVOLUTION_MIPS), 1, NULL);
}

static void write_other_goals(const figures *f, FILE *page)
{
    const comparison steps = compare(f, "temporal", NULL, LAYERED, PCSS_ALL, "step_rms");
    double worst = NAN;
    const names probes = scenes_of(f, "lights");
    const numbers counts = sweep_of(f, "lights", NULL, "irradiance_rms");
    const double x = nearest(&counts, 32);
    for (int i = 0; i < probes.count; i++) {
        const char *probe = probes.list[i];
        const double ours = mean_of(f, "lights", probe, LARGEST_FIRST, x, "irradiance_rms");
        worst = fmax(worst, ours / mean_of(f, "lights", probe, "median cut", x, "irradiance_rms"));
    }
    write_goal(page, "temporal error / PCSS reading every texel, at most 1", steps.ratio, 1,
               &steps);
    const comparison fairest = compare(f, "temporal", NULL, LAYERED, PCSS_NORMAL, "step_rms");
    write_goal(page, "temporal error / PCSS that knows the normal, at most 1", fairest.ratio, 1,
               &fairest);
    write_goal(page,
               "irradiance error of 32 lights / the paper's median cut, on every probe at most 0.2",
               worst, 0.2, NULL);
}

// Against the rivals that come nearest.
static void write_gl_goals(const figures *f, FILE *page)
{
    const summary kernels = summarize(f, "gl_kernel", NULL, LAYERED, NAN, "shade_ms");
    write_goal(page, "OpenGL, above the horizon: frame / CSSM16 in tables, below 1",
               gl_ratio(f, LAYERED_HORIZON, CONVOLUTION_TABLES, "frame_ms"), 1, NULL);
    write_goal(page, "OpenGL, above the horizon: error / CSSM16 in tables, below 1",
               gl_ratio(f, LAYERED_HORIZON, CONVOLUTION_TABLES, "rms"), 1, NULL);
    write_goal(page, "OpenGL, above the horizon: memory / CSSM16 in tables, below 1",
               gl_ratio(f, LAYERED_HORIZON, CONVOLUTION_TABLES, "bytes"), 1, NULL);
    write_goal(
        page,
        "OpenGL, above the horizon: error / PCSS by textureGather that knows the normal, below 1",
        gl_ratio(f, LAYERED_HORIZON, PCSS_GATHER_NORMAL, "rms"), 1, NULL);
    write_goal(page, "OpenGL, above the horizon: shading / PCSS by textureGather, below 1",
               gl_ratio(f, LAYERED_HORIZON, PCSS_GATHER, "shade_ms"), 1, NULL);
    write_goal(page, "OpenGL: shading, slowest / fastest kernel width, at most 1.2",
               kernels.count ? kernels.most / kernels.least : NAN, 1.2, NULL);
}

static void write_goals(const figures *f, FILE *page)
{
    const comparison pcss = compare(f, "error", NULL, LAYERED, PCSS_ALL, "rms"),
                     normal = compare(f, "error", NULL, LAYERED, PCSS_NORMAL, "rms");
    fprintf(
        page,
        "## Figures to reach\n\n\"%s\" against the others, all scenes and light sizes together. "
        "The third column is the range "
        "of the same ratio over single scenes and lights, with the scene where it is largest.\n\n"
        "| ratio | measured | single cases | |\n|---|---|---|---|\n",
        LAYERED);
    write_error_goals(f, page);
    write_time_goals(f, page);
    write_other_goals(f, page);
    write_gl_goals(f, page);
    if (pcss.cases)
        fprintf(page,
                "\nIts error is below that of PCSS reading every texel in %d of %d pairs of scene "
                "and light size, and below that of PCSS that knows the normal in %d.\n\n",
                pcss.lower, pcss.cases, normal.lower);
}

// ---- How

static void write_method(const figures *f, FILE *page)
{
    const names scenes = scenes_of(f, "error"), methods = methods_of(f, "error");
    const numbers sizes = sweep_of(f, "error", NULL, "rms");
    const double noise = mean_of(f, "truth", "all", "error", 0, "noise");
    fprintf(page,
            "## How it was measured\n\n"
            "- %d scenes (%s",
            scenes.count, scenes.count ? scenes.list[0] : "none");
    for (int i = 1; i < scenes.count; i++) fprintf(page, ", %s", scenes.list[i]);
    fprintf(page,
            "), each lit by a square light at infinity of %d sizes. A light that is too large for "
            "a scene is left out there.\n"
            "- Receivers are drawn evenly from the surfaces that face the light. The truth is the "
            "share of rays to the light "
            "that nothing blocks",
            sizes.count);
    if (!isnan(noise))
        fprintf(page, "; its own rms error is %.4f on average, %.4f at most", noise,
                mean_of(f, "truth", "all", "error", 0, "noise_most"));
    fprintf(
        page,
        ".\n"
        "- All %d methods see the same depth map, 256 texels a side, one sample a texel, without "
        "back faces; MSSM sees, as its paper asks, the mean of front and back faces where all "
        "parts of a scene are closed. The rivals are written from their papers, in "
        "`tests/compare/`. Those that need a depth bias get the one that is best for them over "
        "all scenes. Back-projection goes without the gap filling of its paper, with which it errs "
        "by a third more here, and without its pyramid of depth ranges, which would make it faster."
        "\n"
        "- The library and its rivals are scalar C, compiled by gcc with -O2, which vectorises "
        "hardly any loop. Exceptions, all in favour of rivals: convolution reads the channels of "
        "its tables and mip maps four at a time, \"" PCF_GAUSSIAN "\" and "
        "\"" PCSS_NORMAL
        "\" their texels, and \"%s\" is \"%s\" with four texels at a time, charted beside it. "
        "The bounds over arrays are measured with other flags and have a section of their own.\n"
        "- Times are of one core, in rounds that go through all methods, so that whatever "
        "disturbs the machine disturbs all of them. Compare ratios: nanoseconds are those of the "
        "machine that ran this.\n"
        "- A method's time counts as constant if the widest kernel costs less than 1.5 times the "
        "narrowest.\n\n"
        "Run it again:\n\n"
        "```sh\nmake chart          # everything: accuracy.csv, this page, its pictures; about "
        "ten minutes\nmake chart-quick    # the same with fewer receivers, to build/\nmake "
        "chart-check    # do README and docs still say what the figures say?\n```\n\n"
        "On a mesh or a light probe of your own, after `make build/release/measure`:\n\n"
        "```sh\nbuild/release/measure --scene mesh.obj --sun 0.3,1,0.45   # v and f lines, +Y "
        "up, any unit; a ground is put under it\nbuild/release/measure --probe probe.hdr --out "
        "mine.csv    # lat-long, or six faces from top to bottom; .hdr or .pfm\n```\n",
        methods.count, PCSS_VECTORS, PCSS_ALL);
}

void page_write(const figures *f, FILE *page)
{
    fprintf(page, "%s\n# Speed against accuracy\n\n", page_mark);
    write_advice(f, page);
    write_section(f, page, "Error against time", "error_time.svg");
    write_all_methods(f, page);
    write_scenes(f, page);
    write_pictures(f, page);
    write_sweep(f, page, "Size of the light", "error_light.svg", "error", "rms",
                "Rms error of visibility, mean over scenes; the least is bold.", 3);
    write_sweep(f, page, "Width of the kernel", "time_kernel.svg", "kernel", "ns",
                "Nanoseconds a receiver under casters that allow no early exit; the least is bold.",
                0);
    write_side(f, page);
    write_temporal(f, page);
    write_hard(f, page);
    write_lights(f, page);
    write_settings(f, page);
    write_arrays(f, page);
    write_all(f, page, "Map updates",
              "Bytes read and written by an update, against a plain copy in the same run.",
              "bandwidth", "side");
    write_all(f, page, "A whole picture", "Through the public functions, from probe to picture.",
              "picture", "threads");
    write_gl(f, page);
    write_goals(f, page);
    write_method(f, page);
}
