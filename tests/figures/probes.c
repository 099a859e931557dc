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

enum { SIDES = 5, NUMBERS = 5, ROUNDS = 9, MIDDLE = 2 };
static const int sides[SIDES] = {32, 64, 128, 256, 512}, numbers[NUMBERS] = {16, 32, 64, 128, 256};

// Milliseconds, [side][number]; what does not depend on the number is in number 0.
typedef struct times {
    double sums[SIDES], cuts[SIDES][NUMBERS], lights[SIDES][NUMBERS], ours[SIDES][NUMBERS];
    bool done;
} times;

// Other programs may run beside.
static double least_of(const double v[ROUNDS])
{
    double least = v[0];
    for (int i = 1; i < ROUNDS; i++) least = fmin(least, v[i]);
    return 1e3 * least;
}

static lightprobe_cube cube_of(const probe *p)
{
    lightprobe_cube cube = {{NULL}, p->side, 3};
    for (int face = 0; face < 6; face++) cube.face[face] = p->face[face];
    return cube;
}

// ---- CPU ----------------------------------------------------------------------------------------

static bool time_cpu(times *t, int at, const lightprobe_cube *cube, lightprobe_light *lights,
                     int *count, message *why)
{
    static light_cut cuts[MEDIAN_CUT_MOST];
    median_cut m;
    double v[4][ROUNDS];
    const size_t bytes = lightprobe_scratch_bytes(cube->side, MEDIAN_CUT_MOST);
    void *scratch = malloc(bytes);
    if (!scratch || !median_cut_create(&m, cube->side)) return fail(why, "no memory for tables");
    for (int n = 0; n < NUMBERS; n++) {
        const lightprobe_settings settings = {.max_lights = numbers[n]};
        for (int i = 0; i < ROUNDS; i++) {
            int found = 0;
            double now[5];
            now[0] = seconds_now();
            if (n == 0 || i == 0) median_cut_sums(&m, cube);
            now[1] = seconds_now();
            *count = median_cut_cuts(&m, numbers[n], cuts);
            now[2] = seconds_now();
            median_cut_lights(&m, cuts, *count, lights);
            now[3] = seconds_now();
            static lightprobe_light own[MEDIAN_CUT_MOST];
            if (lightprobe_extract(cube, &settings, scratch, bytes, own, &found, NULL))
                return fail(why, "no lights");
            now[4] = seconds_now();
            for (int k = 0; k < 4; k++) v[k][i] = now[k + 1] - now[k];
        }
        if (n == 0) t->sums[at] = least_of(v[0]);
        t->cuts[at][n] = least_of(v[1]);
        t->lights[at][n] = least_of(v[2]);
        t->ours[at][n] = least_of(v[3]);
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

static bool time_rival(times *t, int at, const lightprobe_cube *cube, lightprobe_light *lights,
                       int *count, message *why)
{
    gl_median_cut m;
    double v[3][ROUNDS];
    if (!gl_median_cut_create(&m, cube, why)) return false;
    for (int n = 0; n < NUMBERS; n++) {
        if (n != MIDDLE && at != MIDDLE && n < NUMBERS - 1) continue;
        for (int i = -1; i < ROUNDS; i++) { // the first compiles
            double now[4];
            now[0] = finish();
            gl_median_cut_sums(&m);
            now[1] = finish();
            gl_median_cut_cuts(&m, numbers[n]);
            now[2] = finish();
            gl_median_cut_lights(&m, numbers[n]);
            now[3] = finish();
            for (int k = 0; k < 3 && i >= 0; k++) v[k][i] = now[k + 1] - now[k];
        }
        t->sums[at] = least_of(v[0]);
        t->cuts[at][n] = least_of(v[1]);
        t->lights[at][n] = least_of(v[2]);
    }
    *count = gl_median_cut_read(&m, lights);
    gl_median_cut_free(&m);
    return true;
}

static bool time_own(times *t, int at, const lightprobe_cube *cube, message *why)
{
    GLuint texture = 0;
    gl_probe_upload(&texture, cube->face, cube->side);
    for (int n = 0; n < NUMBERS; n++) { // what is drawn: each takes seconds to compile
        if (n != MIDDLE && (at != MIDDLE || n % 2)) continue;
        const lightprobe_gl_desc desc = {
            .load = gl_context_function, .side = cube->side, .max_lights = numbers[n]};
        lightprobe_gl *own;
        double v[ROUNDS];
        if (lightprobe_gl_create(&own, &desc)) return fail(why, "no lights in OpenGL");
        for (int i = -1; i < ROUNDS; i++) {
            lightprobe_gl_restart(own);
            const double start = finish();
            lightprobe_gl_update(own, texture);
            if (i >= 0) v[i] = finish() - start;
        }
        t->ours[at][n] = least_of(v);
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

static void panels_of(const times *t, panel p[3])
{
    memset(p, 0, 3 * sizeof *p);
    p[0].across = "side of the probe's faces, 64 lights";
    p[1].across = "lights, faces of 128 x 128";
    p[2].across = "lights, faces of 128 x 128";
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
            series_add(&s[0], sides[i], t[g].sums[i]);
            series_add(&s[1], sides[i], t[g].cuts[i][MIDDLE]);
            series_add(&s[2], sides[i], t[g].lights[i][MIDDLE]);
            series_add(&s[3], sides[i], t[g].ours[i][MIDDLE]);
        }
        series *cuts = add(&p[1], looks[g].cuts, ink, MARKER_UP, dashed);
        series *lights = add(&p[1], looks[g].lights, ink, MARKER_DOWN, dashed);
        series *all = add(&p[2], looks[g].all, ink, MARKER_DIAMOND, dashed);
        series *ours = add(&p[2], looks[g].ours, COLOUR_LAYERED, MARKER_CIRCLE, dashed);
        for (int n = 0; n < NUMBERS; n++) {
            series_add(cuts, numbers[n], t[g].cuts[MIDDLE][n]);
            series_add(lights, numbers[n], t[g].lights[MIDDLE][n]);
            series_add(all, numbers[n],
                       t[g].sums[MIDDLE] + t[g].cuts[MIDDLE][n] + t[g].lights[MIDDLE][n]);
            if (t[g].ours[MIDDLE][n] > 0) series_add(ours, numbers[n], t[g].ours[MIDDLE][n]);
        }
    }
}

static void say(page *p, const times *t, const char *name)
{
    const int last = SIDES - 1, most = NUMBERS - 1;
    const double exponent = log(t->sums[last] / t->sums[1]) / log((double)sides[last] / sides[1]);
    const double by_side = t->cuts[last][MIDDLE] / t->cuts[0][MIDDLE];
    const double by_number = t->cuts[MIDDLE][most] / t->cuts[MIDDLE][0];
    const double lights = t->lights[MIDDLE][most] / t->lights[MIDDLE][0];
    const double all = t->sums[MIDDLE] + t->cuts[MIDDLE][MIDDLE] + t->lights[MIDDLE][MIDDLE];
    const double share = t->sums[3] / (t->sums[3] + t->cuts[3][MIDDLE] + t->lights[3][MIDDLE]);
    fprintf(p->file,
            "- *%s.* Tables grow with the side to the power %.1f (paper: quadratic). From 32² to "
            "512² cuts take %.1f times as long (\"little impacted\"), "
            "from 16 to 256 lights %.1f times (\"logarithmic\" would be 3.0, the rounds; linear "
            "16), and lights %.1f times. At 256² tables are %.0f%% of the "
            "time (\"the major amount\"). At 128² and 64 lights the paper's way takes %.2f ms, "
            "lightprobe.h %.2f ms.\n",
            name, exponent, by_side, by_number, lights, 100 * share, all, t->ours[MIDDLE][MIDDLE]);
}

bool probe_times(page *p, message *why)
{
    static times t[2];
    static lightprobe_light lights[2][MEDIAN_CUT_MOST];
    gl_context context;
    const char *missing = "";
    const bool opened = gl_context_create(&context, &missing);
    bool done = true;
    for (int i = 0; i < SIDES && done; i++) {
        probe source;
        int count[2] = {0, 0};
        done = probe_default(&source, sides[i]) || fail(why, "no memory for a probe");
        if (!done) break;
        const lightprobe_cube cube = cube_of(&source);
        done = time_cpu(&t[0], i, &cube, lights[0], &count[0], why);
        if (done && opened) {
            done = time_rival(&t[1], i, &cube, lights[1], &count[1], why) &&
                   time_own(&t[1], i, &cube, why) &&
                   same_lights(lights[0], count[0], lights[1], count[1], why);
        }
        probe_free(&source);
    }
    t[1].done = opened && done;
    if (opened) gl_context_destroy(&context);
    if (!done) return false;
    panel panels[3];
    panels_of(t, panels);
    fprintf(p->file,
            "## Time to find the lights\n\nKneiphof's Figure 3. The paper's way: summed-area "
            "tables of XYZ and of the moments of luminance, median cut in them, "
            "lights from them; in OpenGL compute shaders, with one group of 256 threads and a "
            "bitonic sorter for the cuts. Both find the same lights "
            "on either side. One thread on the CPU, the least of %d runs.\n\n![Time to find the "
            "lights](figure_probe_times.svg)\n\n",
            ROUNDS);
    chart_table(p->file, "ms, by the side of the faces", &panels[0]);
    fprintf(p->file, "By the number of lights, faces of 128²:\n\n");
    panel numbers_panel = panels[1];
    for (int k = 0; k < panels[2].count; k++)
        numbers_panel.list[numbers_panel.count++] = panels[2].list[k];
    chart_table(p->file, "ms, by the number of lights", &numbers_panel);
    const times *judge = t[1].done ? &t[1] : &t[0];
    const double exponent = log(judge->sums[SIDES - 1] / judge->sums[1]) / log(8.0);
    const double growth = judge->cuts[MIDDLE][NUMBERS - 1] / judge->cuts[MIDDLE][0];
    fprintf(p->file,
            "**%s** Tables grow as the paper says, and take most of the time; cuts hardly know the "
            "side%s.\n\n",
            exponent > 1.6 && growth < 8 ? "Agrees." : "Agrees in part.",
            growth < 8 ? " and grow slowly with the lights, round by round"
                       : "; on a processor they grow with the lights, since 256 threads of a group "
                         "share its cores");
    say(p, &t[0], "CPU");
    if (t[1].done)
        say(p, &t[1], "OpenGL (llvmpipe)");
    else
        fprintf(p->file, "- *OpenGL* is left out: %s\n", missing);
    fputs("\n", p->file);
    return chart_draw(
        page_path(p, "figure_probe_times.svg"),
        "Time to find the lights of a probe: the paper's way step by step, and lightprobe.h",
        panels, 3, why);
}
