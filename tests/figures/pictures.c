// Kneiphof's figures 2, 5, 6 and 7: pictures, each with its error.
#include "../compare/figures.h"
#include "page.h"
#include "studio.h"

#include <math.h>
#include <string.h>

static const shot front = {0, 0, {0.3f, 2.25f, 7.7f}, {-0.05f, 0.86f, 0}, 0.57f},
                  close_up = {2.5f, 2.2f, {-3.4f, 1.5f, 2.9f}, {-0.3f, 0.55f, 0}, 0.62f};

// Convolution soft shadows for these shots: coordinate descent, from what the OpenGL rival has, to
// the least rms error of both under 64 lights, in smaller pictures. The chart's own tuning is for
// other casters and has two to three times the error here.
static const struct {
    const char *name;
    float bias;
    convolution_tuning tuning;
} tuned[] = {
    {CSSM8 CSSM_TABLES, 2.25f, {0.955f, 0.14f, 0.04f, 1.484f, 0.087f, 0.26f, 60, 40, 0}},
    {CSSM16 CSSM_TABLES, 2.25f, {0.926f, 0.136f, 0.025f, 1.278f, 0.108f, 0.84f, 55, 52, 0}},
};

// The library's methods by the names that they have in the charts.
static const struct {
    const char *name;
    mssm_settings settings;
} own[] = {
    {"MSSM 4, lower blocker", {.moments = 4, .estimator = MSSM_LOWER_BLOCKER}},
    {"MSSM 4, upper blocker", {.moments = 4, .estimator = MSSM_UPPER_BLOCKER}},
    {"MSSM 6, lower blocker", {.moments = 6, .estimator = MSSM_LOWER_BLOCKER}},
    {"MSSM 6, upper blocker", {.moments = 6, .estimator = MSSM_UPPER_BLOCKER}},
    {LAYERED_HORIZON, {.moments = 6, .estimator = MSSM_HORIZON}},
};

static bool shadowing_of(shadowing *how, const char *name, bool back_faces, int grid, message *why)
{
    *how = (shadowing){.back_faces = back_faces, .grid = grid};
    if (!name) return true;
    for (size_t i = 0; i < sizeof own / sizeof *own; i++)
        if (!strcmp(own[i].name, name)) how->own = &own[i].settings;
    if (!how->own) how->method = method_named(name);
    if (how->method) how->bias = how->method->bias;
    for (size_t i = 0; i < sizeof tuned / sizeof *tuned; i++) {
        if (strcmp(tuned[i].name, name)) continue;
        how->tuning = &tuned[i].tuning;
        how->bias = tuned[i].bias;
    }
    return how->own || how->method || fail(why, "no method %s", name);
}

static int width_of(const page *p)
{
    return p->quick ? PANEL_WIDTH / 5 : PANEL_WIDTH;
}

// ---- Figure 2 -----------------------------------------------------------------------------------

typedef struct source_row {
    const char *name;
    int lights;
    bool paper;
    const char *method; // PCSS, or the library's; NULL: points, by one ray each
    double error, edges;
    double rays, ray_edges; // the same of area lights when rays take the method's place
} source_row;

static bool add_source(const studio *s, source_row *row, sheet *to, message *why)
{
    studio_lights lights;
    const shadowing rays = {.grid = 6};
    shadowing how;
    image picture = {0, 0, NULL}, exact = {0, 0, NULL};
    char line[64];
    const bool done = shadowing_of(&how, row->method, false, 0, why) &&
                      studio_extract(s, &lights, row->lights, row->paper, why) &&
                      studio_shade(s, &lights, &how, &picture, why) &&
                      (!row->method || studio_shade(s, &lights, &rays, &exact, why));
    if (done) {
        row->error = studio_error(s, &picture, &s->truth);
        row->edges = studio_edges(s, &picture, &s->truth);
        int used = snprintf(line, sizeof line, "rms %.1f%%, edges %.1f%%", row->error, row->edges);
        if (row->method) {
            row->rays = studio_error(s, &exact, &s->truth);
            row->ray_edges = studio_edges(s, &exact, &s->truth);
            snprintf(line + used, sizeof line - (size_t)used, "; by rays %.1f%%, %.1f%%", row->rays,
                     row->ray_edges);
        }
        sheet_add(to, &picture, s->exposure, row->name, line);
    }
    image_free(&picture);
    image_free(&exact);
    lighting_free(&lights.l);
    return done;
}

enum { P64, P256, A16, A32, A64, B16, B32, B64, SOURCES };

static void judge_sources(page *p, const source_row rows[SOURCES])
{
    const source_row *points = &rows[P256], *area = &rows[A32], *library = &rows[B32];
    const bool shown = area->edges < points->edges && area->error < points->error;
    const bool lights = area->ray_edges < points->edges;
    fprintf(
        p->file,
        "**%s** \"Utilizing less area lights results in more plausible shadows than many point "
        "lights\": 32 area lights have %.1f%% error at edges and %.1f%% rms under PCSS, and "
        "%.1f%% and %.1f%% when rays take its place; 256 points, by one ray each, have %.1f%% "
        "and %.1f%%.%s This library's 32 lights have %.1f%% and %.1f%% under layered shadows, "
        "%.1f%% and %.1f%% by rays.\n\n",
        shown    ? "Agrees."
        : lights ? "Agrees for the lights, not for their shadows under PCSS."
                 : "Does not agree.",
        area->edges, area->error, area->ray_edges, area->rays, points->edges, points->error,
        shown ? ""
        : lights
            ? " PCSS is off by more wherever one blocker depth does not describe what is "
              "in between."
            : " Even by rays, 32 uniform rectangles are further off than 256 points, each of which "
              "leaves a step of a 256th of the light; PCSS adds error wherever one blocker depth does "
              "not describe the occluders.",
        library->edges, library->error, library->ray_edges, library->rays);
    fprintf(p->file,
            "16 area lights have %.1f times the rms error of 64 (%.1f by rays; this library's %.1f "
            "and %.1f): the paper's artifacts of \"very large area lights\" are %s.\n\n",
            rows[A16].error / rows[A64].error, rows[A16].rays / rows[A64].rays,
            rows[B16].error / rows[B64].error, rows[B16].rays / rows[B64].rays,
            rows[A16].error > rows[A64].error ? "there" : "not seen");
}

bool light_sources(page *p, message *why)
{
    static const char pcss[] = "PCSS, all texels, normal", layered[] = LAYERED_HORIZON;
    source_row rows[SOURCES] = {{"median cut, 64 points", 64, true, NULL, 0, 0, 0, 0},
                                {"median cut, 256 points", 256, true, NULL, 0, 0, 0, 0},
                                {"median cut, 16 area lights", 16, true, pcss, 0, 0, 0, 0},
                                {"median cut, 32 area lights", 32, true, pcss, 0, 0, 0, 0},
                                {"median cut, 64 area lights", 64, true, pcss, 0, 0, 0, 0},
                                {"lightprobe.h, 16 area lights", 16, false, layered, 0, 0, 0, 0},
                                {"lightprobe.h, 32 area lights", 32, false, layered, 0, 0, 0, 0},
                                {"lightprobe.h, 64 area lights", 64, false, layered, 0, 0, 0, 0}};
    const int rays = p->quick ? 32 : 1024;
    studio s;
    sheet to;
    char line[64];
    bool done = studio_open(&s, &front, width_of(p), rays, why) &&
                (sheet_create(&to, SOURCES + 1) || fail(why, "no memory"));
    if (done) {
        snprintf(line, sizeof line, "%d rays a pixel, their noise %.1f%%", rays, s.noise);
        sheet_add(&to, &s.truth, s.exposure, "truth: rays to the probe", line);
    }
    for (int i = 0; i < SOURCES && done; i++) done = add_source(&s, &rows[i], &to, why);
    if (done) {
        fprintf(
            p->file,
            "## Light sources\n\n"
            "Kneiphof's Figure 2: the probe as points and as area lights, beside the truth. Median "
            "cut as in the paper, area lights under PCSS (all texels of the kernel, the bias along "
            "the receiver's plane), points under one exact ray each; the last row has this library's "
            "lights under layered shadows, 6 moments, above the horizon (MSSM_HORIZON). Maps are of "
            "256² (narrow lights, as the sun: "
            "512²), this library's of 4 samples a texel. *Edges*: rms of the steps between "
            "neighbouring pixels that the truth does not have, as hard shadow boundaries make. *By "
            "rays*: the area lights without the errors of shadow maps: by solid angle and cosine, what "
            "each sends from above the receiver's horizon. The truth's noise is subtracted.\n\n");
        fprintf(p->file, "![Light sources](figure_light_sources.png)\n\n");
        done = sheet_close(&to, page_path(p, "figure_light_sources.png"), why);
        judge_sources(p, rows);
    }
    studio_close(&s);
    return done;
}

// ---- Figures 5, 6 and 7 -------------------------------------------------------------------------

typedef struct technique {
    const char *label, *method; // NULL: rays to the lights
    double error, brightness, leak;
} technique;

enum { TECHNIQUES_MOST = 9 };

static bool draw_techniques(studio *s, const studio_lights *lights, technique *t, int count,
                            bool back_faces, const char *path, message *why)
{
    sheet to;
    image truth = {0, 0, NULL};
    const bool both = count > 6; // room for the probe's truth too
    if (!sheet_create(&to, count + both)) return fail(why, "no memory");
    bool done = true;
    char line[64];
    for (int i = 0; i < count && done; i++) {
        shadowing how;
        image picture = {0, 0, NULL};
        done = shadowing_of(&how, t[i].method, back_faces, 4, why) &&
               studio_shade(s, lights, &how, &picture, why);
        if (!done) break;
        if (i == 0) {
            truth = picture;
            snprintf(line, sizeof line, "truth: 16 rays a light and pixel");
        } else {
            t[i].error = studio_error(s, &picture, &truth);
            t[i].brightness = studio_brightness(s, &picture, &truth);
            t[i].leak = studio_leak(s, &picture, &truth);
            snprintf(line, sizeof line, "rms %.1f%%, leaks %.2f%%, bright %.3f", t[i].error,
                     t[i].leak, t[i].brightness);
        }
        sheet_add(&to, &picture, s->exposure, t[i].label, line);
        if (i == 0 && both) {
            snprintf(line, sizeof line, "differs from the lights' by %.1f%%",
                     studio_error(s, &truth, &s->truth));
            sheet_add(&to, &s->truth, s->exposure, "rays to the probe", line);
        }
        if (i > 0) image_free(&picture);
    }
    image_free(&truth);
    return done && sheet_close(&to, path, why);
}

enum { RAYS, PCSS, SMALL, LARGE, LOWER4, UPPER4, UPPER6, LAYERED, TECHNIQUES };

static bool probe_lights(page *p, studio *s, const char *name, const char *title, message *why)
{
    technique t[TECHNIQUES] = {{"the same 64 lights, by rays", NULL, 0, 0, 0},
                               {"PCSS, every texel", "PCSS, all texels, normal", 0, 0, 0},
                               {"CSSM8 (17 values)", CSSM8 CSSM_TABLES, 0, 0, 0},
                               {"CSSM16 (33 values)", CSSM16 CSSM_TABLES, 0, 0, 0},
                               {"MSSM4, lower blocker", "MSSM 4, lower blocker", 0, 0, 0},
                               {"MSSM4, upper blocker", "MSSM 4, upper blocker", 0, 0, 0},
                               {"MSSM6, upper blocker", "MSSM 6, upper blocker", 0, 0, 0},
                               {"layered, above the horizon", LAYERED_HORIZON, 0, 0, 0}};
    studio_lights lights;
    bool done = studio_extract(s, &lights, p->quick ? 8 : 64, false, why) &&
                draw_techniques(s, &lights, t, TECHNIQUES, false, page_path(p, name), why);
    lighting_free(&lights.l);
    if (!done) return false;
    fprintf(p->file, "![%s](%s)\n\n", title, name);
    const bool moments = t[UPPER6].error < t[UPPER4].error;
    const bool dark = fmax(t[SMALL].brightness, t[LARGE].brightness) < t[PCSS].brightness;
    fprintf(
        p->file,
        "**%s** The paper finds CSSM \"slightly darkened\" beside PCSS: here the picture has "
        "%.3f (CSSM8) and %.3f (CSSM16) of the true brightness, PCSS %.3f%s. It finds 6 moments "
        "better than 4: here 6 have an rms error of %.2f%%, 4 of %.2f%% (upper blocker), PCSS of "
        "%.2f%%, CSSM8 of %.2f%%, CSSM16 of %.2f%% and layered above the horizon of %.2f%%.\n\n",
        moments && dark ? "Agrees."
        : moments       ? "Agrees, but for CSSM's darkness."
        : dark          ? "Agrees for CSSM, not for the moments."
                        : "Does not agree.",
        t[SMALL].brightness, t[LARGE].brightness, t[PCSS].brightness,
        dark ? "" : "; CSSM is tuned to the least error here instead of to the least ringing",
        t[UPPER6].error, t[UPPER4].error, t[PCSS].error, t[SMALL].error, t[LARGE].error,
        t[LAYERED].error);
    return true;
}

bool probe_lights_one(page *p, message *why)
{
    studio s;
    fprintf(
        p->file,
        "## 64 lights of a probe, by every technique\n\n"
        "Kneiphof's Figures 5 and 6. All use depth maps of 256² (narrow lights: 512²): moments "
        "have 4 samples a texel as in the paper (of front faces alone: MSSM errs more here with "
        "the paper's means of front and back), CSSM has maps of twice the side, so as many "
        "samples. The lights are this library's. CSSM's series, bias and sharpening are tuned "
        "on these two pictures, against the same rays; PCSS has a bias that follows the receiver's plane, as in [the "
        "chart](accuracy.md). The last picture is MSSM_HORIZON, which alone "
        "of this library's knows the normal. Errors are rms, against rays to the same lights, which "
        "count what they send from above the horizon; *leaks* is excess "
        "light, in %% of all light.\n\n");
    const bool done = studio_open(&s, &front, width_of(p), p->quick ? 32 : 256, why) &&
                      probe_lights(p, &s, "figure_probe_lights_1.png", "64 lights of a probe", why);
    studio_close(&s);
    return done;
}

bool probe_lights_two(page *p, message *why)
{
    studio s;
    fprintf(p->file, "Closer, later, and under the turned probe:\n\n");
    const bool done =
        studio_open(&s, &close_up, width_of(p), p->quick ? 32 : 256, why) &&
        probe_lights(p, &s, "figure_probe_lights_2.png", "64 lights of a turned probe", why);
    studio_close(&s);
    return done;
}

bool blocker_bounds(page *p, message *why)
{
    enum { LB4, LB6, UB4, UB6, OURS, COUNT };
    technique t[COUNT + 1] = {{"16 lights, by rays", NULL, 0, 0, 0},
                              {"MSSM4 LB", "MSSM 4, lower blocker", 0, 0, 0},
                              {"MSSM6 LB", "MSSM 6, lower blocker", 0, 0, 0},
                              {"MSSM4 UB", "MSSM 4, upper blocker", 0, 0, 0},
                              {"MSSM6 UB", "MSSM 6, upper blocker", 0, 0, 0},
                              {"layered, above the horizon", LAYERED_HORIZON, 0, 0, 0}};
    const technique *r = t + 1;
    studio s;
    studio_lights lights;
    bool done = studio_open(&s, &front, width_of(p), p->quick ? 32 : 256, why) &&
                studio_extract(&s, &lights, 16, false, why);
    fprintf(p->file,
            "## Lower and upper blocker, 4 and 6 moments\n\n"
            "Kneiphof's Figure 7: 16 lights of the probe, which are large; means of front and back "
            "faces, as in the paper. LB: the receiver's own weight counts 1e-3 (Eq. 7). UB: it "
            "counts in full (Eq. 19). The last picture is MSSM_HORIZON.\n\n"
            "![Lower and upper blocker](figure_blocker_bounds.png)\n\n");
    if (done)
        done = draw_techniques(&s, &lights, t, COUNT + 1, true,
                               page_path(p, "figure_blocker_bounds.png"), why);
    const bool moments = r[LB6].leak < r[LB4].leak && r[UB6].leak < r[UB4].leak;
    const bool upper = r[UB4].leak < r[LB4].leak && r[UB6].leak < r[LB6].leak;
    if (done) {
        fprintf(
            p->file,
            "**%s** \"The shadows from MSSM4 are quite weak. When using 6 moments, the shadows are "
            "stronger [...]. In both cases, using an upper bound for the average blocker depth makes "
            "the shadows less weak.\" Leaked light, in %% of all: %.2f (LB4), %.2f (LB6), %.2f "
            "(UB4), %.2f (UB6), layered %.2f; rms %.1f, %.1f, %.1f, %.1f, layered %.1f%%.\n\n",
            moments && upper   ? "Agrees."
            : moments || upper ? "Agrees in part."
                               : "Does not agree.",
            r[LB4].leak, r[LB6].leak, r[UB4].leak, r[UB6].leak, r[OURS].leak, r[LB4].error,
            r[LB6].error, r[UB4].error, r[UB6].error, r[OURS].error);
    }
    lighting_free(&lights.l);
    studio_close(&s);
    return done;
}
