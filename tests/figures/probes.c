// Kneiphof's figure 3: what it takes to find the lights of a probe, step by step.
#include "median_cut.h"
#include "page.h"

#include "../../examples/common/gl_context.h"
#include "../../examples/common/gl_draw.h"
#include "../../examples/common/probe.h"
#include "../../examples/common/threads.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDES = 5, NUMBERS = 5, ROUNDS = 9, MIDDLE = 2, LAST = 4 };

// What is measured: all sides with the middle number of lights, and all numbers with the middle side.
typedef struct range {
    int side[SIDES], number[NUMBERS], rounds;
} range;
static const range whole = {{32, 64, 128, 256, 512}, {16, 32, 64, 128, 256}, ROUNDS},
                   quick = {{32, 64, 96, 128, 160}, {8, 12, 16, 24, 32}, 1};

// Milliseconds, [side][number], 0 where none were measured; tables do not depend on the number.
typedef struct times {
    double sums[SIDES], cuts[SIDES][NUMBERS], lights[SIDES][NUMBERS], ours[SIDES][NUMBERS];
    bool done;
} times;

// Other programs may run beside.
static double least_of(const double v[ROUNDS], int rounds)
{
    double least = HUGE_VAL;
    for (int i = 0; i < rounds; i++) least = fmin(least, v[i]);
    return 1e3 * least;
}

static lightprobe_cube cube_of(const probe *p)
{
    lightprobe_cube cube = {{NULL}, p->side, 3};
    for (int face = 0; face < 6; face++) cube.face[face] = p->face[face];
    return cube;
}

// ---- CPU ----------------------------------------------------------------------------------------

static bool time_cpu(times *t, const range *r, int at, const lightprobe_cube *cube,
                     lightprobe_light *lights, int *count, message *why)
{
    static light_cut cuts[MEDIAN_CUT_MOST];
    median_cut m;
    double v[4][ROUNDS] = {{0}};
    const size_t bytes = lightprobe_scratch_bytes(cube->side, MEDIAN_CUT_MOST);
    void *scratch = malloc(bytes);
    if (!scratch || !median_cut_create(&m, cube->side)) return fail(why, "no memory for tables");
    for (int n = 0; n < NUMBERS; n++) {
        const lightprobe_settings settings = {.max_lights = r->number[n]};
        for (int i = 0; i < r->rounds; i++) {
            int found = 0;
            double now[5];
            now[0] = seconds_now();
            if (n == 0 || i == 0) median_cut_sums(&m, cube);
            now[1] = seconds_now();
            *count = median_cut_cuts(&m, r->number[n], cuts);
            now[2] = seconds_now();
            median_cut_lights(&m, cuts, *count, lights);
            now[3] = seconds_now();
            static lightprobe_light own[MEDIAN_CUT_MOST];
            if (lightprobe_extract(cube, &settings, scratch, bytes, own, &found, NULL))
                return fail(why, "no lights");
            now[4] = seconds_now();
            for (int k = 0; k < 4; k++) v[k][i] = now[k + 1] - now[k];
        }
        if (n == 0) t->sums[at] = least_of(v[0], r->rounds);
        t->cuts[at][n] = least_of(v[1], r->rounds);
        t->lights[at][n] = least_of(v[2], r->rounds);
        t->ours[at][n] = least_of(v[3], r->rounds);
    }
    median_cut_free(&m);
    free(scratch);
    t->done = true;
    return true;
}

// ---- OpenGL -------------------------------------------------------------------------------------

static double finish(void)
{
    gl.Finish();
    return seconds_now();
}

static bool time_rival(times *t, const range *r, int at, const lightprobe_cube *cube,
                       lightprobe_light *lights, int *count, message *why)
{
    gl_median_cut m;
    double v[3][ROUNDS] = {{0}};
    if (!gl_median_cut_create(&m, cube, why)) return false;
    for (int n = 0; n < NUMBERS; n++) {
        if (n != MIDDLE && at != MIDDLE && n != LAST) continue; // the last is compared
        for (int i = -1; i < r->rounds; i++) {                  // the first compiles
            double now[4];
            now[0] = finish();
            gl_median_cut_sums(&m);
            now[1] = finish();
            gl_median_cut_cuts(&m, r->number[n]);
            now[2] = finish();
            gl_median_cut_lights(&m, r->number[n]);
            now[3] = finish();
            for (int k = 0; k < 3 && i >= 0; k++) v[k][i] = now[k + 1] - now[k];
        }
        t->sums[at] = least_of(v[0], r->rounds);
        t->cuts[at][n] = least_of(v[1], r->rounds);
        t->lights[at][n] = least_of(v[2], r->rounds);
    }
    *count = gl_median_cut_read(&m, lights);
    gl_median_cut_free(&m);
    return gl.GetError() == GL_NO_ERROR || fail(why, "median cut: OpenGL reports an error");
}

static bool time_own(times *t, const range *r, int at, const lightprobe_cube *cube, message *why)
{
    GLuint texture = 0;
    gl_probe_upload(&texture, cube->face, cube->side);
    for (int n = 0; n < NUMBERS; n++) { // what is drawn: each takes seconds to compile
        if (n != MIDDLE && (at != MIDDLE || n % 2)) continue;
        if (r->rounds == 1 && (at != MIDDLE || n != MIDDLE)) continue;
        const lightprobe_gl_desc desc = {
            .load = gl_context_function, .side = cube->side, .max_lights = r->number[n]};
        lightprobe_gl *own;
        double v[ROUNDS] = {0};
        if (lightprobe_gl_create(&own, &desc)) return fail(why, "no lights in OpenGL");
        for (int i = -1; i < r->rounds; i++) {
            lightprobe_gl_restart(own);
            const double start = finish();
            lightprobe_gl_update(own, texture);
            if (i >= 0) v[i] = finish() - start;
        }
        t->ours[at][n] = least_of(v, r->rounds);
        lightprobe_gl_destroy(own);
    }
    gl.DeleteTextures(1, &texture);
    return true;
}

// Both sides of the rival find the same lights, whatever their order, and lose nothing.
static bool same_lights(const lightprobe_light *a, int count_a, const lightprobe_light *b,
                        int count_b, message *why)
{
    float sum[2] = {0, 0};
    int missing = 0;
    for (int i = 0; i < count_a; i++) {
        float nearest = -1;
        for (int k = 0; k < count_b; k++) {
            float cosine = 0;
            for (int j = 0; j < 3; j++) cosine += a[i].direction[j] * b[k].direction[j];
            nearest = fmaxf(nearest, cosine);
        }
        missing += nearest < 0.9999f;
        sum[0] += a[i].irradiance[1];
    }
    for (int k = 0; k < count_b; k++) sum[1] += b[k].irradiance[1];
    // Tables of floats, summed in another order, may cut a column beside.
    if (count_a == count_b && missing <= count_a / 16 && fabsf(sum[0] / sum[1] - 1) < 1e-3f)
        return true;
    return fail(why, "median cut: %d lights of %g on the CPU, %d of %g in OpenGL, %d elsewhere",
                count_a, (double)sum[0], count_b, (double)sum[1], missing);
}

// ---- The figure ---------------------------------------------------------------------------------

static series *add(panel *p, const char *name, colour ink, marker shape, bool dashed)
{
    series *s = &p->list[p->count++];
    *s = (series){.name = name, .ink = ink, .shape = shape, .dashed = dashed};
    return s;
}

static const struct {
    const char *sums, *cuts, *lights, *all, *ours;
    colour ink;
    bool dashed;
} looks[2] = {{"tables, CPU", "cuts, CPU", "lights, CPU", "paper's way, all steps, CPU",
               "lightprobe.h, CPU", COLOUR_PCSS, true},
              {"tables, OpenGL", "cuts, OpenGL", "lights, OpenGL", "paper's way, all steps, OpenGL",
               "lightprobe.h, OpenGL", COLOUR_CONVOLUTION, false}};

static void panels_of(const times *t, const range *r, panel p[3])
{
    static char across[2][64];
    memset(p, 0, 3 * sizeof *p);
    snprintf(across[0], sizeof across[0], "side of the probe's faces, %d lights",
             r->number[MIDDLE]);
    snprintf(across[1], sizeof across[1], "lights, faces of %d x %d", r->side[MIDDLE],
             r->side[MIDDLE]);
    p[0].across = across[0];
    p[1].across = p[2].across = across[1];
    for (int g = 0; g < 2; g++) {
        if (!t[g].done) continue;
        const colour ink = looks[g].ink;
        const bool dashed = looks[g].dashed;
        for (int i = 0; i < SIDES; i++) {
            if (i == 0) {
                add(&p[0], looks[g].sums, ink, MARKER_SQUARE, dashed);
                add(&p[0], looks[g].cuts, ink, MARKER_UP, dashed);
                add(&p[0], looks[g].lights, ink, MARKER_DOWN, dashed);
                add(&p[0], looks[g].ours, COLOUR_LAYERED, MARKER_CIRCLE, dashed);
            }
            series *s = &p[0].list[p[0].count - 4];
            series_add(&s[0], r->side[i], t[g].sums[i]);
            series_add(&s[1], r->side[i], t[g].cuts[i][MIDDLE]);
            series_add(&s[2], r->side[i], t[g].lights[i][MIDDLE]);
            if (t[g].ours[i][MIDDLE] > 0) series_add(&s[3], r->side[i], t[g].ours[i][MIDDLE]);
        }
        series *cuts = add(&p[1], looks[g].cuts, ink, MARKER_UP, dashed);
        series *lights = add(&p[1], looks[g].lights, ink, MARKER_DOWN, dashed);
        series *all = add(&p[2], looks[g].all, ink, MARKER_DIAMOND, dashed);
        series *ours = add(&p[2], looks[g].ours, COLOUR_LAYERED, MARKER_CIRCLE, dashed);
        for (int n = 0; n < NUMBERS; n++) {
            series_add(cuts, r->number[n], t[g].cuts[MIDDLE][n]);
            series_add(lights, r->number[n], t[g].lights[MIDDLE][n]);
            series_add(all, r->number[n],
                       t[g].sums[MIDDLE] + t[g].cuts[MIDDLE][n] + t[g].lights[MIDDLE][n]);
            if (t[g].ours[MIDDLE][n] > 0) series_add(ours, r->number[n], t[g].ours[MIDDLE][n]);
        }
    }
}

// The paper's claims about its own way, and what was measured.
typedef struct growths {
    double power;            // of the side, by which tables grow
    double share;            // of the tables in the whole, at the next to largest side
    double side, number;     // by which cuts grow from the first to the last
    double lights;           // the same of the last step, by the number
    double halvings, rounds; // what bisection and rounds would make of side and number
} growths;

static growths growths_of(const times *t, const range *r)
{
    const int n = MIDDLE, wide = SIDES - 2;
    const double all = t->sums[wide] + t->cuts[wide][n] + t->lights[wide][n];
    const double sides = (double)r->side[LAST] / r->side[0];
    return (growths){log(t->sums[LAST] / t->sums[0]) / log(sides), t->sums[wide] / all,
                     t->cuts[LAST][n] / t->cuts[0][n], t->cuts[MIDDLE][LAST] / t->cuts[MIDDLE][0],
                     t->lights[MIDDLE][LAST] / t->lights[MIDDLE][0],
                     log(r->side[LAST]) / log(r->side[0]),
                     // six regions double round by round
                     ceil(log2(r->number[LAST] / 6.0)) / ceil(log2(r->number[0] / 6.0))};
}

static void judge(page *p, const times *t, const range *r, const char *name)
{
    const growths g = growths_of(t, r);
    const double sides = (double)r->side[LAST] / r->side[0],
                 numbers = (double)r->number[LAST] / r->number[0];
    const bool tables = nearer(pow(sides, g.power), pow(sides, 2), sides), most = g.share > 0.5,
               side = nearer(g.side, g.halvings, sides),
               number = nearer(g.number, g.rounds, numbers);
    const int held = tables + most + side + number;
    const double all = t->sums[MIDDLE] + t->cuts[MIDDLE][MIDDLE] + t->lights[MIDDLE][MIDDLE];
    fprintf(
        p->file,
        "- *%s.* **%s** Tables grow with the side to the power %.1f (paper: \"quadratic\") and "
        "take %.0f%% of the time at %d² (\"the major amount\"). From %d² to %d² cuts take %.1f "
        "times as long (\"little impacted\"; their bisections %.1f); from %d to %d lights %.1f "
        "times (\"logarithmic\": %.1f times the rounds; in proportion %.0f)%s. Making lights of "
        "regions takes %.1f times as long. At %d² and %d lights all steps take %.2f ms, "
        "lightprobe.h %.2f ms.\n",
        name,
        held == 4  ? "Agrees."
        : held > 0 ? "Agrees in part."
                   : "Does not agree.",
        g.power, 100 * g.share, r->side[SIDES - 2], r->side[0], r->side[LAST], g.side, g.halvings,
        r->number[0], r->number[LAST], g.number, g.rounds, numbers,
        number ? "" : ", since a processor cuts and sorts one region after the other", g.lights,
        r->side[MIDDLE], r->number[MIDDLE], all, t->ours[MIDDLE][MIDDLE]);
}

static bool measure(times t[2], const range *r, bool opened, message *why)
{
    static lightprobe_light lights[2][MEDIAN_CUT_MOST];
    bool done = true;
    for (int i = 0; i < SIDES && done; i++) {
        probe source;
        int count[2] = {0, 0};
        if (!probe_default(&source, r->side[i])) return fail(why, "no memory for a probe");
        const lightprobe_cube cube = cube_of(&source);
        done = time_cpu(&t[0], r, i, &cube, lights[0], &count[0], why);
        if (done && opened) {
            done = time_rival(&t[1], r, i, &cube, lights[1], &count[1], why) &&
                   time_own(&t[1], r, i, &cube, why) &&
                   same_lights(lights[0], count[0], lights[1], count[1], why);
        }
        probe_free(&source);
    }
    t[1].done = opened && done;
    return done;
}

bool probe_times(page *p, message *why)
{
    static times t[2];
    const range *r = p->quick ? &quick : &whole;
    gl_context context;
    const char *missing = "";
    const bool opened = gl_context_create(&context, &missing);
    const bool done = measure(t, r, opened, why);
    if (opened) gl_context_destroy(&context);
    if (!done) return false;
    panel panels[3];
    panels_of(t, r, panels);
    fprintf(
        p->file,
        "## Time to find the lights\n\n"
        "Kneiphof's Figure 3. The paper's way is summed-area tables of XYZ and of the moments of "
        "luminance, median cut in them, and lights from them; in OpenGL by compute shaders, with "
        "one group of 256 threads and a bitonic sorter for the cuts. Both sides find the same "
        "lights. CPU times are of one thread, the least of %d runs; lightprobe.h in OpenGL is timed at "
        "every second number of lights, since it compiles for seconds.\n\n"
        "![Time to find the lights](figure_probe_times.svg)\n\n",
        r->rounds);
    chart_table(p->file, "ms, by the side of the faces", &panels[0]);
    fprintf(p->file, "By the number of lights, faces of %d²:\n\n", r->side[MIDDLE]);
    panel numbers_panel = panels[1];
    for (int k = 0; k < panels[2].count; k++)
        numbers_panel.list[numbers_panel.count++] = panels[2].list[k];
    chart_table(p->file, "ms, by the number of lights", &numbers_panel);
    judge(p, &t[0], r, "CPU");
    if (t[1].done)
        judge(p, &t[1], r, "OpenGL");
    else
        fprintf(p->file, "- *OpenGL* is **left out**, since this machine has none: %s\n", missing);
    fputs("\n", p->file);
    return chart_draw(
        page_path(p, "figure_probe_times.svg"),
        "Time to find the lights of a probe: the paper's way step by step, and lightprobe.h",
        panels, 3, why);
}
