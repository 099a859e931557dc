// The pictures of docs/, see charts.h.
#include "charts.h"

#include <math.h>
#include <string.h>

#include "summary.h"

enum { WIDTH = 800, SENTENCE = 400 };

// One of each family that a user would choose from, for charts that have no room for all.
static const char *const selection[] = {"hard",
                                        "PCF",
                                        "PCSS, 16 samples",
                                        PCSS_ALL,
                                        PCSS_NORMAL,
                                        "VSSM",
                                        "EVSM",
                                        CONVOLUTION_MIPS,
                                        "MSSM 6, lower blocker",
                                        "MSSM 6, upper blocker",
                                        LAYERED,
                                        LAYERED_NORMAL,
                                        BACK_PROJECTION,
                                        PCF_GAUSSIAN,
                                        "VSM, Gaussian",
                                        EVSM_GAUSSIAN,
                                        FILTERED_4,
                                        FILTERED_6};
enum { SELECTED = sizeof selection / sizeof *selection };

// Markers and names of the families, in one row.
static void draw_key(svg *s, double y)
{
    double x = 20;
    for (int i = 0; i < style_count && styles[i].title; i++) {
        svg_marker(s, x, y - 4, styles[i].shape, styles[i].ink, 5);
        svg_text(s, x + 10, y, "start", COLOUR_INK, 12, styles[i].title);
        x += 26 + svg_text_width(styles[i].title, 12);
    }
}

// This library's methods stand out.
static double name_size(const char *method)
{
    static const char *const own[] = {LAYERED, FILTERED_4, FILTERED_6};
    for (int i = 0; i < 3; i++)
        if (!strcmp(method, own[i])) return -12;
    return 12;
}

// ---- error against time

static void message_error_time(const figures *f, char *text, size_t room)
{
    const names methods = methods_of(f, "error");
    const char *best = "", *other = "";
    int better = 0;
    double lowest = HUGE_VAL;
    for (int i = 0; i < methods.count; i++) {
        const char *m = methods.list[i];
        if (!method_constant_time(f, m) || method_error(f, m) >= lowest) continue;
        lowest = method_error(f, best = m);
    }
    if (!*best) {
        snprintf(text, room, "Error against time of %d methods.", methods.count);
        return;
    }
    for (int i = 0; i < methods.count; i++) { // what still beats it, at whatever time
        if (method_error(f, methods.list[i]) >= lowest) continue;
        other = methods.list[i];
        better++;
    }
    char rest[96] = "No other method is better.";
    if (better == 1) snprintf(rest, sizeof rest, "Only %s is better.", other);
    if (better > 1) snprintf(rest, sizeof rest, "%d others are better.", better);
    const double ratio = method_ns(f, PCSS_NORMAL) / method_ns(f, best);
    snprintf(text, room,
             "Of all methods whose time does not depend on the light's size, \"%s\" is the most "
             "accurate: rms error "
             "%.3f, where \"%s\" has %.3f in %.2g times its time. %s",
             best, lowest, PCSS_NORMAL, method_error(f, PCSS_NORMAL), ratio, rest);
}

static bool draw_error_time(const figures *f, const char *path)
{
    char text[SENTENCE];
    svg s;
    message_error_time(f, text, sizeof text);
    if (!svg_open(&s, path, WIDTH, 550, text)) return false;
    draw_key(&s, s.top + 8);
    plot p = {&s,
              66,
              s.top + 24,
              WIDTH - 66 - 16,
              s.height - s.top - 24 - 48,
              axis_make("nanoseconds a receiver, one core, mean over light sizes", true),
              axis_make("rms error of visibility, all scenes and light sizes", true)};
    const names methods = methods_of(f, "error");
    for (int i = 0; i < methods.count; i++) {
        axis_include(&p.across, method_ns(f, methods.list[i]));
        axis_include(&p.up, method_error(f, methods.list[i]));
    }
    axis_finish(&p.across);
    axis_finish(&p.up);
    plot_grid(&p);
    labels l = {.clear = 7};
    for (int i = 0; i < methods.count; i++) {
        const char *m = methods.list[i];
        const style *look = style_of(m);
        const double x = plot_x(&p, method_ns(f, m)), y = plot_y(&p, method_error(f, m));
        svg_marker(&s, x, y, look->shape, look->ink, 5.5);
        labels_add(&l, x, y, COLOUR_INK, name_size(m), m);
    }
    labels_scatter(&l, &p);
    return svg_close(&s);
}

// ---- lines

typedef struct panel {
    const char *experiment, *metric, *across, *up;
    bool log_across, log_up;
    double least; // methods that stay below everywhere are left out
} panel;

static bool is_shown(const figures *f, const panel *what, const char *method, bool selected)
{
    if (!(summarize(f, what->experiment, NULL, method, NAN, what->metric).most >= what->least))
        return false;
    for (int i = 0; i < SELECTED && selected; i++)
        if (!strcmp(method, selection[i])) return true;
    // Its error is that of PCSS with all texels, its time is not.
    if (!strcmp(method, PCSS_VECTORS) && !strcmp(what->metric, "ns")) return true;
    return !selected;
}

// The lines of one panel: every method or the selection, with their names at the right.
static void draw_lines(const figures *f, svg *s, const panel *what, double x, double y,
                       double width, double height, bool selected)
{
    const names methods = methods_of(f, what->experiment);
    double margin = 0;
    axis across = axis_make(what->across, what->log_across), up = axis_make(what->up, what->log_up);
    for (int i = 0; i < methods.count; i++) {
        const char *m = methods.list[i];
        const numbers sweep = sweep_of(f, what->experiment, m, what->metric);
        if (!sweep.count || !is_shown(f, what, m, selected)) continue;
        margin = fmax(margin, svg_text_width(m, name_size(m)));
        for (int k = 0; k < sweep.count; k++) {
            axis_include(&across, sweep.list[k]);
            axis_tick(&across, sweep.list[k]);
            axis_include(&up, mean_of(f, what->experiment, NULL, m, sweep.list[k], what->metric));
        }
    }
    axis_finish(&across);
    axis_finish(&up);
    const plot p = {s, x + 62, y, width - 62 - 26 - margin, height - 46, across, up};
    plot_grid(&p);
    labels ends = {.clear = 4};
    for (int i = 0; i < methods.count; i++) {
        const char *m = methods.list[i];
        const style *look = style_of(m);
        const numbers sweep = sweep_of(f, what->experiment, m, what->metric);
        if (!sweep.count || !is_shown(f, what, m, selected)) continue;
        double px[NAMES_ROOM], py[NAMES_ROOM];
        for (int k = 0; k < sweep.count; k++) {
            px[k] = plot_x(&p, sweep.list[k]);
            py[k] = plot_y(&p, mean_of(f, what->experiment, NULL, m, sweep.list[k], what->metric));
        }
        svg_polyline(s, sweep.count, px, py, look->ink, name_size(m) < 0 ? 2.6 : 1.5, false);
        for (int k = 0; k < sweep.count; k++)
            svg_marker(s, px[k], py[k], look->shape, look->ink, 4);
        labels_add(&ends, px[sweep.count - 1], py[sweep.count - 1], COLOUR_INK, name_size(m), m);
    }
    labels_stack(&ends, &p);
}

// Against the PCSS that knows more than it does.
static void message_light(const figures *f, char *text, size_t room)
{
    const numbers sizes = sweep_of(f, "error", LAYERED, "rms");
    int wins = 0;
    double first = NAN, last = NAN;
    for (int i = 0; i < sizes.count; i++) {
        if (mean_of(f, "error", NULL, LAYERED, sizes.list[i], "rms") >=
            mean_of(f, "error", NULL, PCSS_NORMAL, sizes.list[i], "rms"))
            continue;
        if (!wins++) first = sizes.list[i];
        last = sizes.list[i];
    }
    if (wins == sizes.count)
        snprintf(text, room, "\"%s\" has less error than \"%s\" at every light size.", LAYERED,
                 PCSS_NORMAL);
    else if (wins)
        snprintf(text, room,
                 "\"%s\" has less error than \"%s\" at %d of %d light sizes, between %g and %g.",
                 LAYERED, PCSS_NORMAL, wins, sizes.count, first, last);
    else
        snprintf(text, room, "\"%s\" has less error than \"%s\" at every light size.", PCSS_NORMAL,
                 LAYERED);
}

static bool draw_light(const figures *f, const char *path)
{
    static const panel what = {"error",
                               "rms",
                               "light size: tangent of the half-angle",
                               "rms error of visibility, all scenes",
                               true,
                               true,
                               0};
    char text[SENTENCE];
    svg s;
    message_light(f, text, sizeof text);
    if (!svg_open(&s, path, WIDTH, 430, text)) return false;
    draw_lines(f, &s, &what, 0, s.top + 4, WIDTH - 8, s.height - 10 - s.top, true);
    return svg_close(&s);
}

static void message_kernel(const figures *f, char *text, size_t room)
{
    const summary own = summarize(f, "kernel", NULL, LAYERED, NAN, "ns");
    const numbers widths = sweep_of(f, "kernel", LAYERED, "ns");
    const double x = nearest(&widths, 101);
    const double slow = mean_of(f, "kernel", NULL, PCSS_ALL, x, "ns");
    const double own_ns = mean_of(f, "kernel", NULL, LAYERED, x, "ns");
    const double vectors = mean_of(f, "kernel", NULL, PCSS_VECTORS, x, "ns");
    char rest[64] = "";
    if (!isnan(vectors))
        snprintf(rest, sizeof rest, ", in vectors of four %.2g times", vectors / own_ns);
    snprintf(text, room,
             "From %g to %g texels of kernel the time of \"%s\" stays within %.0f%%; PCSS that "
             "reads every texel takes "
             "%.2g times as long at %g texels%s.",
             widths.list[0], widths.list[widths.count ? widths.count - 1 : 0], LAYERED,
             100 * (own.most / own.least - 1), slow / own_ns, x, rest);
}

static bool draw_kernel(const figures *f, const char *path)
{
    static const panel what = {
        "kernel", "ns", "widest kernel, texels", "nanoseconds a receiver", true, true, 0};
    char text[SENTENCE];
    svg s;
    message_kernel(f, text, sizeof text);
    if (!svg_open(&s, path, WIDTH, 415, text)) return false;
    draw_lines(f, &s, &what, 0, s.top + 4, WIDTH - 8, s.height - 10 - s.top, true);
    return svg_close(&s);
}

// The smallest side whose error is within a tenth of the least.
static double enough_side(const figures *f)
{
    const numbers sides = sweep_of(f, "side", LAYERED, "rms");
    const double least = summarize(f, "side", NULL, LAYERED, NAN, "rms").least;
    for (int i = 0; i < sides.count; i++)
        if (mean_of(f, "side", NULL, LAYERED, sides.list[i], "rms") <= 1.1 * least)
            return sides.list[i];
    return NAN;
}

static void message_side(const figures *f, char *text, size_t room)
{
    const double side = enough_side(f);
    const numbers sides = sweep_of(f, "side", LAYERED, "rms");
    if (!sides.count) return;
    const double first = sides.list[0], last = sides.list[sides.count - 1];
    const double slower = mean_of(f, "side", NULL, LAYERED, last, "update_ms") /
                          mean_of(f, "side", NULL, LAYERED, first, "update_ms");
    snprintf(
        text, room,
        "%g texels a side are enough for \"%s\": up to %g no side has less than nine tenths of "
        "that error, and with each doubling an update takes %.1f times as long.",
        side, LAYERED, last, pow(slower, 1 / log2(last / first)));
}

static bool draw_side(const figures *f, const char *path)
{
    static const panel what[] = {
        {"side", "rms", "side of the map, texels", "rms error of visibility", true, true, 0},
        {"side", "update_ms", "side of the map, texels", "milliseconds an update", true, true,
         0.01}};
    char text[SENTENCE];
    svg s;
    message_side(f, text, sizeof text);
    if (!svg_open(&s, path, WIDTH, 690, text)) return false;
    const double height = (s.height - 5 - s.top) / 2;
    for (int i = 0; i < 2; i++)
        draw_lines(f, &s, &what[i], 0, s.top + 4 + i * height, WIDTH - 8, height - 6, true);
    return svg_close(&s);
}

static void message_lights(const figures *f, char *text, size_t room)
{
    const names methods = methods_of(f, "edges");
    const numbers counts = sweep_of(f, "edges", LARGEST_FIRST, "blocked_rms");
    const double n = nearest(&counts, 8);
    const double ours = mean_of(f, "edges", NULL, LARGEST_FIRST, n, "blocked_rms");
    const char *second = "";
    double next = HUGE_VAL;
    for (int i = 0; i < methods.count; i++) {
        const double error = mean_of(f, "edges", NULL, methods.list[i], n, "blocked_rms");
        if (!strcmp(methods.list[i], LARGEST_FIRST) || !(error < next)) continue;
        next = error, second = methods.list[i];
    }
    snprintf(text, room,
             "Behind straight edges %g lights by \"%s\" err by %.1f%%, in the mean over probes; "
             "the best other way, \"%s\", by %.1f%%.",
             n, LARGEST_FIRST, ours, second, next);
}

// Panels beneath each other, those that have figures.
static bool draw_panels(const figures *f, const char *path, const char *text, const panel *what,
                        int panels, bool selected)
{
    const double height = 230;
    int shown = 0;
    svg s;
    for (int i = 0; i < panels; i++)
        shown += sweep_of(f, what[i].experiment, NULL, what[i].metric).count > 0;
    if (!svg_open(&s, path, WIDTH, shown * height, text)) return false;
    double y = s.top + 4;
    for (int i = 0; i < panels; i++) {
        if (!sweep_of(f, what[i].experiment, NULL, what[i].metric).count) continue;
        draw_lines(f, &s, &what[i], 0, y, WIDTH - 8, height - 10, selected);
        y += height;
    }
    return svg_close(&s);
}

static bool draw_lights(const figures *f, const char *path)
{
    static const panel what[] = {
        {"edges", "blocked_rms", "lights", "behind edges, rms error, %", true, true, 0},
        {"lights", "picture_rms", "lights", "shadowed picture, rms error, %", true, true, 0},
        {"lights", "irradiance_rms", "lights", "nothing between, rms error, %", true, true, 0},
        {"lights", "ms", "lights", "ms to find them", true, true, 0}};
    char text[SENTENCE];
    message_lights(f, text, sizeof text);
    return draw_panels(f, path, text, what, 4, false);
}

// ---- hard shadows

static void message_hard(const figures *f, char *text, size_t room)
{
    const summary own = summarize(f, "hard", NULL, FILTERED_4, NAN, "ns"),
                  pcf = summarize(f, "hard", NULL, PCF_GAUSSIAN, NAN, "ns");
    const numbers radii = sweep_of(f, "hard", FILTERED_4, "ns");
    const double error = mean_of(f, "hard", NULL, FILTERED_4, NAN, "rms");
    char slower[48] = "stays shorter";
    for (int i = radii.count - 1; i >= 0; i--)
        if (mean_of(f, "hard", NULL, PCF_GAUSSIAN, radii.list[i], "ns") >
            mean_of(f, "hard", NULL, FILTERED_4, radii.list[i], "ns"))
            snprintf(slower, sizeof slower, "is longer from %g on", radii.list[i]);
    snprintf(
        text, room,
        "From a radius of %g texel to %g the time of \"" FILTERED_4
        "\" stays within %.0f%%, that of percentage-closer filtering grows %.1f times and %s; "
        "error: %.2f times that of percentage-closer filtering, %.2f times that of EVSM at the "
        "same memory and %.2f times at twice the memory.",
        radii.list[0], radii.list[radii.count - 1], 100 * (own.most / own.least - 1),
        pcf.most / pcf.least, slower, error / mean_of(f, "hard", NULL, PCF_GAUSSIAN, NAN, "rms"),
        error / mean_of(f, "hard", NULL, EVSM_HALVES, NAN, "rms"),
        error / mean_of(f, "hard", NULL, EVSM_GAUSSIAN, NAN, "rms"));
}

static bool draw_hard(const figures *f, const char *path)
{
    static const char radius[] = "radius of the Gaussian, texels";
    static const panel what[] = {
        {"hard", "rms", radius, "rms error of visibility", true, true, 0},
        {"hard", "leak", radius, "light where all is dark", true, false, 0},
        {"hard", "ns", radius, "nanoseconds a receiver", true, true, 0}};
    char text[SENTENCE];
    message_hard(f, text, sizeof text);
    return draw_panels(f, path, text, what, 3, true);
}

// ---- bars

typedef struct bar {
    char name[FIGURE_NAME];
    double value;
    char text[64];
} bar;

static void sort_bars(bar *bars, int count)
{
    for (int i = 1; i < count; i++) {
        for (int k = i; k > 0 && bars[k].value < bars[k - 1].value; k--) {
            const bar swap = bars[k];
            bars[k] = bars[k - 1];
            bars[k - 1] = swap;
        }
    }
}

static double draw_bars(svg *s, double y, const bar *bars, int count)
{
    double most = 0, left = 24, texts = 0;
    for (int i = 0; i < count; i++) {
        most = fmax(most, bars[i].value);
        left = fmax(left, 24 + svg_text_width(bars[i].name, -12));
        texts = fmax(texts, svg_text_width(bars[i].text, 12));
    }
    const double room = s->width - left - texts - 24;
    for (int i = 0; i < count; i++, y += 22) {
        const double length = room * bars[i].value / most;
        svg_text(s, left - 8, y + 13, "end", COLOUR_INK, name_size(bars[i].name), bars[i].name);
        svg_bar(s, left, y + 1, length, 16, style_of(bars[i].name)->ink);
        svg_text(s, left + length + 6, y + 13, "start", COLOUR_INK, 12, bars[i].text);
    }
    return y;
}

static void message_memory(const figures *f, char *text, size_t room)
{
    const double own = method_bytes(f, LAYERED), its = method_bytes(f, CONVOLUTION_MIPS);
    const numbers sides = sweep_of(f, "side", LAYERED, "bytes");
    snprintf(text, room,
             "A map of %g texels a side takes %.1f MiB with six moments, %.2g times as much as %s "
             "needs.",
             nearest(&sides, 256), own / 1048576, own / its, CONVOLUTION_MIPS);
}

static bool draw_memory(const figures *f, const char *path)
{
    const names methods = methods_of(f, "side");
    bar bars[NAMES_ROOM];
    int count = 0;
    for (int i = 0; i < methods.count; i++) {
        bar *b = &bars[count];
        b->value = method_bytes(f, methods.list[i]) / 1048576;
        if (!(b->value > 0)) continue;
        snprintf(b->name, sizeof b->name, "%s", methods.list[i]);
        snprintf(b->text, sizeof b->text, "%.2f MiB", b->value);
        count++;
    }
    sort_bars(bars, count);
    char text[SENTENCE];
    svg s;
    message_memory(f, text, sizeof text);
    if (!svg_open(&s, path, WIDTH, 8 + 22 * count, text)) return false;
    draw_bars(&s, s.top, bars, count);
    return svg_close(&s);
}

static void message_temporal(const figures *f, char *text, size_t room)
{
    const double own = mean_of(f, "temporal", NULL, LAYERED, NAN, "step_rms");
    const double its = mean_of(f, "temporal", NULL, PCSS_ALL, NAN, "step_rms");
    snprintf(text, room,
             "While sun or caster move by a quarter texel a frame, shadows by \"%s\" are %s PCSS "
             "that reads every "
             "texel: error from frame to frame %.4f against %.4f.",
             LAYERED, own <= its ? "no less steady than those by" : "less steady than those by",
             own, its);
}

static bool draw_temporal(const figures *f, const char *path)
{
    const names methods = methods_of(f, "temporal");
    bar bars[NAMES_ROOM];
    for (int i = 0; i < methods.count; i++) {
        const summary step = summarize(f, "temporal", NULL, methods.list[i], NAN, "step_rms");
        snprintf(bars[i].name, sizeof bars[i].name, "%s", methods.list[i]);
        bars[i].value = step.mean;
        snprintf(bars[i].text, sizeof bars[i].text, "%.4f", step.mean);
    }
    sort_bars(bars, methods.count);
    char text[SENTENCE];
    svg s;
    message_temporal(f, text, sizeof text);
    if (!svg_open(&s, path, WIDTH, 8 + 22 * methods.count, text)) return false;
    draw_bars(&s, s.top, bars, methods.count);
    return svg_close(&s);
}

// ---- settings

// What the other settings are compared with: "default", or else the first.
static const char *setting_reference(const names *settings)
{
    return names_has(settings, "default") ? "default" : settings->list[0];
}

static double setting_change(const figures *f, const char *setting, const char *reference,
                             const char *metric)
{
    return 100 * (mean_of(f, "setting", NULL, setting, NAN, metric) /
                      mean_of(f, "setting", NULL, reference, NAN, metric) -
                  1);
}

static void message_settings(const figures *f, char *text, size_t room)
{
    const names settings = methods_of(f, "setting");
    const char *reference = setting_reference(&settings), *best = "";
    double saved = 0;
    for (int i = 0; i < settings.count; i++) {
        const double time = -setting_change(f, settings.list[i], reference, "ns");
        if (time <= saved || setting_change(f, settings.list[i], reference, "rms") > 5) continue;
        saved = time;
        best = settings.list[i];
    }
    if (*best)
        snprintf(text, room,
                 "Doing only what a receiver needs: \"%s\" saves %.0f%% of the time and adds "
                 "%.1f%% to the error.",
                 best, saved, setting_change(f, best, reference, "rms"));
    else
        snprintf(text, room, "No setting saves time without adding more than 5%% to the error.");
}

// A bar to the right for more, to the left for less, of a middle line.
static void draw_change(svg *s, double middle, double y, double change, double scale, colour ink)
{
    char text[32];
    const double length = fabs(change) * scale;
    svg_bar(s, change < 0 ? middle - length : middle, y + 1, length, 16, ink);
    snprintf(text, sizeof text, "%+.1f%%", fabs(change) < 0.05 ? 0 : change);
    svg_text(s, change < 0 ? middle - length - 5 : middle + length + 5, y + 13,
             change < 0 ? "end" : "start", COLOUR_INK, 12, text);
}

static bool draw_settings(const figures *f, const char *path)
{
    const names settings = methods_of(f, "setting");
    const char *reference = setting_reference(&settings);
    char text[SENTENCE];
    double most[2] = {1, 1}, left = 0;
    static const char *const metric[] = {"ns", "rms"}, *const heading[] = {"time", "rms error"};
    static const colour ink[] = {COLOUR_FAINT, COLOUR_LAYERED};
    svg s;
    message_settings(f, text, sizeof text);
    if (!svg_open(&s, path, WIDTH, 30 + 22 * (settings.count - 1), text)) return false;
    for (int i = 0; i < settings.count; i++) {
        left = fmax(left, svg_text_width(settings.list[i], 12));
        for (int k = 0; k < 2; k++)
            most[k] =
                fmax(most[k], fabs(setting_change(f, settings.list[i], reference, metric[k])));
    }
    const double half = (WIDTH - left - 40) / 4, room = half - 56;
    for (int k = 0; k < 2; k++) {
        const double middle = left + 30 + half * (1 + 2 * k);
        double y = s.top + 22;
        snprintf(text, sizeof text, "%s, change against \"%s\"", heading[k], reference);
        svg_text(&s, middle, s.top + 8, "middle", COLOUR_FAINT, 12, text);
        for (int i = 0; i < settings.count; i++) {
            if (!strcmp(settings.list[i], reference)) continue;
            if (!k) svg_text(&s, left + 16, y + 13, "end", COLOUR_INK, 12, settings.list[i]);
            draw_change(&s, middle, y, setting_change(f, settings.list[i], reference, metric[k]),
                        room / most[k], ink[k]);
            y += 22;
        }
        svg_line(&s, middle, s.top + 16, middle, y, COLOUR_FAINT, 1, false);
    }
    return svg_close(&s);
}

const chart charts[] = {
    {"error_time.svg", draw_error_time, message_error_time, "error", true},
    {"error_light.svg", draw_light, message_light, "error", true},
    {"time_kernel.svg", draw_kernel, message_kernel, "kernel", true},
    {"map_side.svg", draw_side, message_side, "side", true},
    {"memory.svg", draw_memory, message_memory, "side", true},
    {"temporal.svg", draw_temporal, message_temporal, "temporal", true},
    {"lights.svg", draw_lights, message_lights, "lights", false},
    {"hard.svg", draw_hard, message_hard, "hard", false},
    {"settings.svg", draw_settings, message_settings, "setting", false},
};
const int chart_count = sizeof charts / sizeof *charts;

const chart *chart_named(const char *file)
{
    for (int i = 0; i < chart_count; i++)
        if (!strcmp(charts[i].file, file)) return &charts[i];
    return NULL;
}

bool chart_possible(const figures *f, const chart *c)
{
    const names methods = methods_of(f, c->experiment);
    if (!c->speaks_of_layered) return methods.count > 0;
    return names_has(&methods, LAYERED) && names_has(&methods, PCSS_ALL);
}
