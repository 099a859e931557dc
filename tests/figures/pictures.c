// Kneiphof's figures 2, 5, 6 and 7: pictures, each with its error.
#include "page.h"
#include "studio.h"

#include <string.h>

static const vec3 front_from = {0.3f, 2.25f, 7.7f}, front_to = {-0.05f, 0.86f, 0};

// The library's methods by the names that they have in the charts.
static const struct {
    const char *name;
    mssm_settings settings;
} own[] = {
    {"MSSM 4, lower blocker", {.moments = 4, .estimator = MSSM_LOWER_BLOCKER}},
    {"MSSM 4, upper blocker", {.moments = 4, .estimator = MSSM_UPPER_BLOCKER}},
    {"MSSM 6, lower blocker", {.moments = 6, .estimator = MSSM_LOWER_BLOCKER}},
    {"MSSM 6, upper blocker", {.moments = 6, .estimator = MSSM_UPPER_BLOCKER}},
    {"layered, 6 moments", {.moments = 6}},
};

static bool shadowing_of(shadowing *how, const char *name, bool back_faces, int grid, message *why)
{
    *how = (shadowing){NULL, NULL, back_faces, grid};
    if (!name) return true;
    for (size_t i = 0; i < sizeof own / sizeof *own; i++)
        if (!strcmp(own[i].name, name)) how->own = &own[i].settings;
    if (!how->own) how->method = method_named(name);
    return how->own || how->method || fail(why, "no method %s", name);
}

// ---- Figure 2 -----------------------------------------------------------------------------------

typedef struct source_row {
    const char *name;
    int lights;
    bool paper;
    const char *method; // PCSS, or the library's; NULL: points, by one ray each
    double error, edges;
} source_row;

static bool add_source(const studio *s, source_row *row, sheet *to, message *why)
{
    studio_lights lights;
    shadowing how;
    image picture = {0, 0, NULL};
    char line[64];
    const bool done = shadowing_of(&how, row->method, false, 0, why) &&
                      studio_extract(s, &lights, row->lights, row->paper, why) &&
                      studio_shade(s, &lights, &how, &picture, why);
    if (done) {
        row->error = studio_error(s, &picture, &s->truth);
        row->edges = studio_edges(s, &picture, &s->truth);
        snprintf(line, sizeof line, "rms %.1f%%, edges %.1f%%", row->error, row->edges);
        sheet_add(to, &picture, s->exposure, row->name, line);
    }
    image_free(&picture);
    lighting_free(&lights.l);
    return done;
}

static const char *less_or_more(double a, double b)
{
    return a < b ? "less" : "more";
}

bool light_sources(page *p, message *why)
{
    enum { P64, P256, A16, A32, A64, B16, B32, B64, ROWS };
    source_row rows[ROWS] = {
        {"median cut, 64 points", 64, true, NULL, 0, 0},
        {"median cut, 256 points", 256, true, NULL, 0, 0},
        {"median cut, 16 area lights", 16, true, "PCSS, all texels in vectors", 0, 0},
        {"median cut, 32 area lights", 32, true, "PCSS, all texels in vectors", 0, 0},
        {"median cut, 64 area lights", 64, true, "PCSS, all texels in vectors", 0, 0},
        {"lightprobe.h, 16 area lights", 16, false, "layered, 6 moments", 0, 0},
        {"lightprobe.h, 32 area lights", 32, false, "layered, 6 moments", 0, 0},
        {"lightprobe.h, 64 area lights", 64, false, "layered, 6 moments", 0, 0}};
    studio s;
    sheet to;
    char line[64];
    bool done = studio_open(&s, 0, 0, front_from, front_to, 0.57f, why) &&
                (sheet_create(&to, ROWS + 1) || fail(why, "no memory"));
    if (done) {
        snprintf(line, sizeof line, "256 rays a pixel, their noise %.1f%%", s.noise);
        sheet_add(&to, &s.truth, s.exposure, "truth: rays to the probe", line);
    }
    for (int i = 0; i < ROWS && done; i++) done = add_source(&s, &rows[i], &to, why);
    if (done) {
        fprintf(p->file, "## Light sources\n\nKneiphof's Figure 2: the probe as points and as area "
                         "lights, beside the truth. Median cut as in the paper, area "
                         "lights under PCSS (all texels of the kernel), points under one exact ray "
                         "each; in the last row this library's lights under "
                         "layered shadows, 6 moments. Maps of 256² (narrow lights, as the sun: "
                         "512²), this library's of 4 samples a texel. *Edges*: rms of "
                         "the steps between neighbouring pixels that the truth does not have, "
                         "which is what hard shadow boundaries make.\n\n");
        fprintf(p->file, "![Light sources](figure_light_sources.png)\n\n");
        done = sheet_close(&to, page_path(p, "figure_light_sources.png"), why);
        const source_row *points = &rows[P256], *area = &rows[A32], *ours = &rows[B32];
        const bool agrees = area->edges < points->edges, rms = area->error < points->error;
        fprintf(p->file,
                "**%s** \"Less area lights result in more plausible shadows than many point "
                "lights\": 32 area lights have %s error at edges than 256 points "
                "(%.1f%% against %.1f%%), and %s rms error (%.1f%% against %.1f%%). With this "
                "library's 32 lights it is %.1f%% at edges and %.1f%% rms.%s\n\n",
                agrees && rms ? "Agrees."
                : agrees      ? "Agrees for what the eye sees, not by rms."
                              : "Does not agree.",
                less_or_more(area->edges, points->edges), area->edges, points->edges,
                less_or_more(area->error, points->error), area->error, points->error, ours->edges,
                ours->error,
                rms ? ""
                    : " Points are exact for what is not near an edge, and 256 of them leave steps "
                      "of 1/256 of the light; large area lights are wrong "
                      "wherever one blocker depth does not describe what is in between.");
        fprintf(p->file,
                "16 area lights have %.1f times the error of 64 (%.1f with this library's): the "
                "paper's \"artifacts of very large lights\".\n\n",
                rows[A16].error / rows[A64].error, rows[B16].error / rows[B64].error);
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
                               {"PCSS, every texel", "PCSS, all texels in vectors", 0, 0, 0},
                               {"CSSM8 (17 values)", CSSM8, 0, 0, 0},
                               {"CSSM16 (33 values)", CSSM16, 0, 0, 0},
                               {"MSSM4, lower blocker", "MSSM 4, lower blocker", 0, 0, 0},
                               {"MSSM4, upper blocker", "MSSM 4, upper blocker", 0, 0, 0},
                               {"MSSM6, upper blocker", "MSSM 6, upper blocker", 0, 0, 0},
                               {"layered, 6 moments", "layered, 6 moments", 0, 0, 0}};
    studio_lights lights;
    bool done = studio_extract(s, &lights, 64, false, why) &&
                draw_techniques(s, &lights, t, TECHNIQUES, false, page_path(p, name), why);
    lighting_free(&lights.l);
    if (!done) return false;
    fprintf(p->file, "![%s](%s)\n\n", title, name);
    const bool order = t[UPPER6].error < t[UPPER4].error && t[LAYERED].error < t[UPPER6].error;
    const bool dark = t[SMALL].brightness < 1 && t[LARGE].brightness < 1;
    fprintf(
        p->file,
        "**%s** The paper finds CSSM \"slightly darkened\": here the picture has %.3f (CSSM8) and "
        "%.3f (CSSM16) of the true brightness%s. It finds "
        "6 moments better than 4: rms %.1f%% against %.1f%%, where PCSS has %.1f%%, CSSM16 %.1f%% "
        "and layered %.1f%%.\n\n",
        dark && order ? "Agrees."
        : order       ? "Agrees, but for CSSM's darkness."
                      : "Agrees in part.",
        t[SMALL].brightness, t[LARGE].brightness,
        dark ? ""
             : ", since its scale and shift are tuned to the least error instead of to no ringing",
        t[UPPER6].error, t[UPPER4].error, t[PCSS].error, t[LARGE].error, t[LAYERED].error);
    return true;
}

bool probe_lights_one(page *p, message *why)
{
    studio s;
    fprintf(
        p->file,
        "## 64 lights of a probe, by every technique\n\nKneiphof's Figures 5 and 6. All from depth "
        "maps of 256² (narrow lights: 512²), rivals with "
        "the bias that suits each best, moments from 4 samples a texel, which rivals cannot "
        "filter; the lights are this library's. Errors are against rays to the same lights; "
        "*leaks* is what is too bright, in %% of "
        "all light.\n\n");
    const bool done = studio_open(&s, 0, 0, front_from, front_to, 0.57f, why) &&
                      probe_lights(p, &s, "figure_probe_lights_1.png", "64 lights of a probe", why);
    studio_close(&s);
    return done;
}

bool probe_lights_two(page *p, message *why)
{
    studio s;
    fprintf(p->file, "Closer, later, and under the turned probe:\n\n");
    const bool done =
        studio_open(&s, 2.5f, 2.2f, vec(-3.4f, 1.5f, 2.9f), vec(-0.3f, 0.55f, 0), 0.62f, why) &&
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
                              {"layered, 6 moments", "layered, 6 moments", 0, 0, 0}};
    const technique *r = t + 1;
    studio s;
    studio_lights lights;
    bool done = studio_open(&s, 0, 0, front_from, front_to, 0.57f, why) &&
                studio_extract(&s, &lights, 16, false, why);
    fprintf(p->file, "## Lower and upper blocker, 4 and 6 moments\n\nKneiphof's Figure 7: 16 "
                     "lights of the probe, so large ones; means of front and back faces, as in the "
                     "paper. LB: the receiver's own weight counts 1e-3 (Eq. 7). UB: it counts in "
                     "full (Eq. 19).\n\n![Lower and upper blocker](figure_blocker_bounds.png)\n\n");
    if (done)
        done = draw_techniques(&s, &lights, t, COUNT + 1, true,
                               page_path(p, "figure_blocker_bounds.png"), why);
    const bool moments = r[LB6].leak < r[LB4].leak && r[UB6].leak < r[UB4].leak;
    const bool upper = r[UB4].leak < r[LB4].leak && r[UB6].leak < r[LB6].leak;
    if (done) {
        fprintf(
            p->file,
            "**%s** \"The shadows from MSSM4 are quite weak; with 6 moments they are stronger; "
            "in both cases an upper bound of the blocker depth makes "
            "them less weak\". Light that leaks, in %% of all: %.2f (LB4), %.2f (LB6), %.2f (UB4), "
            "%.2f (UB6), layered %.2f; rms %.1f, %.1f, %.1f, %.1f, layered %.1f%%.\n\n",
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
