// Kneiphof's figure 4 and Annen's table 1: what soft shadows cost in OpenGL, against the side of
// the maps, the size of the picture and the number of lights.
#include "page.h"

#include "../../examples/common/gl_context.h"
#include "../../examples/common/threads.h"
#include "../compare/gl_convolution.h"
#include "../compare/gl_percentage_closer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PROBE_SIDE = 128, ROUNDS = 3, FIRST_FREE_UNIT = 4, FIRST_FREE_BUFFER = 1 };

// ---- The scene, and methods at work in it -------------------------------------------------------

typedef struct bench {
    gl_context context;
    lighting lights;
    gl_lighting view;
    gl_reference depth; // of one sample a texel, for the rivals
    probe source;
    scene scene;
    camera eye;
    int side;
    bool back_faces; // maps are means of front and back, as in Kneiphof's paper
} bench;

typedef enum kind { LIBRARY, PERCENTAGE_CLOSER, TABLES, MIPS } kind;

typedef struct technique {
    const char *name;
    kind kind;
    int variant; // moments, gl_percentage_closer_kind, terms
    mssm_settings settings;
    colour ink;
    marker shape;
    bool dashed;
} technique;

typedef struct subject {
    const technique *t;
    mssm_gl *maps;
    gl_convolution convolution;
    GLuint program;
} subject;

static void bench_close(bench *b)
{
    gl_reference_free(&b->depth);
    gl_lighting_free(&b->view);
    lighting_free(&b->lights);
    scene_free(&b->scene);
    probe_free(&b->source);
    gl_context_destroy(&b->context);
}

static bool make_scene(bench *b, int lights, int side, message *why)
{
    const lighting_settings settings = {
        .probe = {.max_lights = lights}, .map_side = side, .map_samples = 1};
    gl_lighting *v = &b->view;
    b->side = side;
    b->eye = camera_look(vec(0.3f, 2.25f, 7.7f), vec(-0.05f, 0.86f, 0), 0.57f, 16.0f / 9);
    if (!probe_default(&b->source, PROBE_SIDE) || !scene_create(&b->scene, 0, NULL))
        return fail(why, "no memory for the scene");
    if (!lighting_create(&b->lights, &settings, PROBE_SIDE, why) ||
        !lighting_extract(&b->lights, &b->source, why) ||
        !gl_lighting_create(v, &b->lights, gl_context_function, 64, 36, why) ||
        !gl_reference_create(&b->depth, side, lights, why)) {
        return false;
    }
    gl_probe_upload(&v->probe, b->source.face, PROBE_SIDE);
    return gl_lighting_draw_maps(v, &b->lights, &b->scene, why); // for its casters and its order
}

static bool bench_open(bench *b, int lights, int side, message *why)
{
    const char *missing;
    memset(b, 0, sizeof *b);
    if (!gl_context_create(&b->context, &missing)) return fail(why, "%.200s", missing);
    if (make_scene(b, lights, side, why)) return true;
    bench_close(b);
    return false;
}

static bool bench_size(bench *b, int width, message *why)
{
    if (!gl_lighting_resize(&b->view, width, width * 9 / 16, why)) return false;
    gl_lighting_draw_view(&b->view, &b->scene, &b->eye);
    return true;
}

static void subject_close(subject *s)
{
    mssm_gl_destroy(s->maps);
    if (s->program && !s->convolution.program) gl.DeleteProgram(s->program);
    gl_convolution_free(&s->convolution);
    memset(s, 0, sizeof *s);
}

static bool subject_open(subject *s, const technique *t, const bench *b, message *why)
{
    char text[GL_PERCENTAGE_CLOSER_TEXT];
    memset(s, 0, sizeof *s);
    s->t = t;
    if (t->kind == LIBRARY) {
        const mssm_gl_desc desc = {.load = gl_context_function,
                                   .lights = b->lights.lights,
                                   .side = b->side,
                                   .moments = t->variant,
                                   .settings = t->settings,
                                   .first_texture_unit = FIRST_FREE_UNIT,
                                   .first_buffer_binding = FIRST_FREE_BUFFER};
        const mssm_result result = mssm_gl_create(&s->maps, &desc);
        if (result != MSSM_OK) return fail(why, "%s: %s", t->name, mssm_result_string(result));
        s->program = gl_lighting_program(t->name, mssm_gl_shader(s->maps), false, why);
    } else if (t->kind == PERCENTAGE_CLOSER) {
        gl_percentage_closer_visibility((gl_percentage_closer_kind)t->variant, text, sizeof text);
        s->program = gl_lighting_program(t->name, text, false, why);
    } else {
        gl_convolution_create(&s->convolution,
                              t->kind == MIPS ? GL_CONVOLUTION_MIPS : GL_CONVOLUTION_TABLES,
                              t->variant, NULL, b->side, b->lights.lights, why);
        s->program = s->convolution.program;
    }
    if (s->program) return true;
    subject_close(s);
    return false;
}

static double finish(void)
{
    gl.Finish();
    return seconds_now();
}

// Milliseconds of one frame's steps; drawing casters counts only for the whole.
typedef struct frame_times {
    double tables, shade, all;
} frame_times;

static void draw_own(bench *b, subject *s, frame_times *t)
{
    const scene *c = &b->scene;
    const float low[3] = {c->low.x, c->low.y, c->low.z},
                high[3] = {c->high.x, c->high.y, c->high.z};
    for (int i = 0; i < b->lights.lights; i++) {
        const lightprobe_light *l = &b->view.ordered[i];
        mssm_light f;
        mssm_light_directional(&f, l->direction, l->axis_u, l->tan_half_u, l->tan_half_v, low,
                               high);
        mssm_gl_set_light(s->maps, i, &f);
        gl.ProgramUniformMatrix4fv(b->view.depth_program, 0, 1, GL_FALSE, f.world_to_shadow);
        for (int back = 0; back <= b->back_faces; back++) {
            mssm_gl_begin_depth(s->maps, i, back);
            gl.UseProgram(b->view.depth_program);
            gl_mesh_draw(&b->view.casters);
            mssm_gl_end_depth(s->maps);
        }
    }
    const double start = finish();
    mssm_gl_build(s->maps); // of all lights: resolve, then tables
    t->tables = 1e3 * (finish() - start);
}

static void draw_rival(bench *b, subject *s, frame_times *t)
{
    gl_reference_draw(&b->depth, &b->view, b->lights.lights, &b->scene, GL_REFERENCE_HARD, 0);
    const double start = finish();
    if (s->convolution.program) gl_convolution_update(&s->convolution, &b->depth, b->lights.lights);
    t->tables = s->convolution.program ? 1e3 * (finish() - start) : 0;
}

static frame_times frame_of(bench *b, subject *s)
{
    frame_times t = {0, 0, 0};
    const gl_target *to = &b->view.picture;
    const double start = finish();
    (s->maps ? draw_own : draw_rival)(b, s, &t);
    gl.BindFramebuffer(GL_FRAMEBUFFER, to->framebuffer);
    gl.Viewport(0, 0, to->width, to->height);
    if (s->maps) {
        mssm_gl_bind(s->maps);
    } else {
        gl_reference_bind(&b->depth);
        if (s->convolution.program) gl_convolution_bind(&s->convolution);
    }
    const double shading = finish();
    gl_lighting_pass(&b->view, s->program, &b->lights, &b->eye, 0, b->lights.lights,
                     GL_LIGHTING_BASE);
    const double end = finish();
    t.shade = 1e3 * (end - shading);
    t.all = 1e3 * (end - start);
    return t;
}

// The least of some frames, step by step, after one that compiles.
static frame_times best_of(bench *b, subject *s)
{
    frame_times best = {HUGE_VAL, HUGE_VAL, HUGE_VAL};
    gl.Enable(GL_SCISSOR_TEST);
    gl.Scissor(0, 0, 8, 8);
    frame_of(b, s);
    gl.Disable(GL_SCISSOR_TEST);
    double spent = 0;
    for (int i = 0; i < ROUNDS && spent < 2e3; i++) {
        const frame_times t = frame_of(b, s);
        spent += t.all;
        best.tables = fmin(best.tables, t.tables);
        best.shade = fmin(best.shade, t.shade);
        best.all = fmin(best.all, t.all);
    }
    return best;
}

// Without OpenGL the figure is left out, and says so.
static bool has_gl(const page *p)
{
    gl_context context;
    const char *missing;
    if (gl_context_create(&context, &missing)) return gl_context_destroy(&context), true;
    fprintf(p->file, "**Left out**, since this machine has no OpenGL: %s\n\n", missing);
    return false;
}

static bool no_gl_error(message *why)
{
    return gl.GetError() == GL_NO_ERROR || fail(why, "soft shadows: OpenGL reports an error");
}

// ---- Kneiphof's figure 4 ------------------------------------------------------------------------

enum { POINTS = 4, TECHNIQUES = 7, LIGHTS = 4 };
enum { PCSS, GATHER, CSSM8_ROW, CSSM16_ROW, MSSM4, MSSM6, LAYERED };
static const int sides[POINTS] = {128, 256, 512, 1024}, widths[POINTS] = {160, 320, 640, 960};

// Sides and widths that are measured, and the one of each that the other's growth is measured with.
typedef struct range {
    int sides, widths, side, width;
} range;

static range range_of(const page *p)
{
    return p->quick ? (range){2, 2, 128, 160} : (range){POINTS, POINTS, 256, 320};
}

static const technique techniques[TECHNIQUES] = {
    {"PCSS, 27 x 27 taps",
     PERCENTAGE_CLOSER,
     GL_PERCENTAGE_CLOSER_TAPS,
     {0},
     COLOUR_PCSS,
     MARKER_SQUARE,
     false},
    {"PCSS, every texel by textureGather",
     PERCENTAGE_CLOSER,
     GL_PERCENTAGE_CLOSER_GATHER,
     {0},
     COLOUR_PCSS,
     MARKER_PLUS,
     true},
    {"CSSM8", TABLES, 4, {0}, COLOUR_CONVOLUTION, MARKER_UP, true},
    {"CSSM16", TABLES, 8, {0}, COLOUR_CONVOLUTION, MARKER_DOWN, false},
    {"MSSM4, upper blocker, 27 x 27",
     LIBRARY,
     4,
     {4, MSSM_UPPER_BLOCKER, 0, 0, 27, 0},
     COLOUR_MSSM,
     MARKER_DIAMOND,
     true},
    {"MSSM6, upper blocker, 27 x 27",
     LIBRARY,
     6,
     {6, MSSM_UPPER_BLOCKER, 0, 0, 27, 0},
     COLOUR_MSSM,
     MARKER_CROSS,
     false},
    {"layered, 6 moments", LIBRARY, 6, {.moments = 6}, COLOUR_LAYERED, MARKER_CIRCLE, false},
};

static bool time_side(panel p[3], int side, range r, message *why)
{
    bench b;
    if (!bench_open(&b, LIGHTS, side, why)) return false;
    b.back_faces = true;
    bool done = bench_size(&b, r.width, why);
    for (int k = 0; k < TECHNIQUES && done; k++) {
        subject s;
        done = subject_open(&s, &techniques[k], &b, why);
        if (!done) break;
        const frame_times t = best_of(&b, &s);
        if (t.tables > 0) series_add(&p[0].list[k], side, t.tables);
        series_add(&p[1].list[k], side, t.shade);
        for (int i = 0; i < r.widths && side == r.side && done; i++) {
            done = bench_size(&b, widths[i], why);
            if (done) series_add(&p[2].list[k], widths[i], best_of(&b, &s).shade);
        }
        if (done) done = bench_size(&b, r.width, why);
        subject_close(&s);
    }
    done = done && no_gl_error(why);
    bench_close(&b);
    return done;
}

static double growth(const series *s)
{
    return s->y[s->count - 1] / s->y[0];
}

static void judge(page *p, const panel panels[3], range r)
{
    const series *tables = panels[0].list, *shade = panels[1].list;
    double t[TECHNIQUES];
    for (int k = 0; k < TECHNIQUES; k++) t[k] = series_at(&shade[k], r.side);
    const double update =
        series_at(&tables[CSSM16_ROW], r.side) / series_at(&tables[MSSM6], r.side);
    const double four = growth(&shade[MSSM4]), sixteen = growth(&shade[CSSM16_ROW]);
    const bool slowest = fmin(t[PCSS], t[GATHER]) > fmax(t[MSSM6], t[CSSM16_ROW]),
               shading = fmax(t[MSSM4], t[MSSM6]) < t[CSSM16_ROW], scaling = four < sixteen;
    const int held = slowest + (update > 1) + shading + scaling;
    fprintf(p->file,
            "**%s** At %d² PCSS shades in %.0f ms (by textureGather %.0f), CSSM8 in %.0f, CSSM16 "
            "in %.0f, MSSM4 in %.0f, MSSM6 in %.0f. PCSS, \"not suitable for real-time "
            "applications\", is %s; CSSM16's maps take %.1f times as long as MSSM6's; that MSSM "
            "\"scores a better runtime in the shading pass\" than CSSM16 %s%s. From %d² to %d² "
            "shading takes %.1f times as long with MSSM4 (\"not affected\") and %.1f times with "
            "CSSM16 (\"scales poorly\")%s. Layered shadows, which the paper does not have, take "
            "%.1f times as long as MSSM6 to shade: they filter one to four kernels.\n\n",
            held == 4  ? "Agrees."
            : held > 0 ? "Agrees in part."
                       : "Does not agree.",
            r.side, t[PCSS], t[GATHER], t[CSSM8_ROW], t[CSSM16_ROW], t[MSSM4], t[MSSM6],
            slowest ? "the slowest" : "not the slowest at this size of the picture", update,
            shading ? "holds" : "does not hold here",
            shading ? ""
                    : ": a processor pays for the arithmetic of moments and reads 33 values out of "
                      "its caches, where a GPU waits for memory",
            sides[0], sides[r.sides - 1], four, sixteen,
            scaling ? "" : ", which a processor's caches even out", t[LAYERED] / t[MSSM6]);
}

bool shadow_times(page *p, message *why)
{
    static panel panels[3];
    const range r = range_of(p);
    fprintf(p->file,
            "## Time of soft shadows\n\n"
            "Kneiphof's Figure 4, for %d lights instead of 16 (times grow in proportion): resolve "
            "and tables, and shading, against the side of the maps (pictures of %d x %d), and "
            "shading against the picture (maps of %d²). MSSM and layered shadows resolve front and "
            "back faces of 4 samples a texel, as in the paper; CSSM computes its terms from one "
            "sample a texel while it sums, less work than the paper's. Resolve and tables of all "
            "lights are one call. MSSM4 and MSSM6 have the paper's largest kernel of 27 x 27.\n\n",
            LIGHTS, r.width, r.width * 9 / 16, r.side);
    if (!has_gl(p)) return true;
    memset(panels, 0, sizeof panels);
    panels[0].across = "resolve and tables: side of the maps";
    panels[1].across = "shading: side of the maps";
    panels[2].across = "shading: width of the picture";
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < TECHNIQUES; k++) {
            const technique *t = &techniques[k];
            panels[i].list[panels[i].count++] =
                (series){.name = t->name, .ink = t->ink, .shape = t->shape, .dashed = t->dashed};
        }
    }
    for (int i = 0; i < r.sides; i++)
        if (!time_side(panels, sides[i], r, why)) return false;
    fprintf(p->file, "![Time of soft shadows](figure_shadow_times.svg)\n\n");
    static const char *const corner[3] = {"resolve and tables, ms", "shading, ms",
                                          "shading, ms, by width"};
    for (int i = 0; i < 3; i++) chart_table(p->file, corner[i], &panels[i]);
    judge(p, panels, r);
    return chart_draw(page_path(p, "figure_shadow_times.svg"),
                      "Soft shadows in OpenGL: time against the side of the maps and the picture",
                      panels, 3, why);
}

// ---- Annen's table 1 ----------------------------------------------------------------------------

enum { NUMBERS = 4, ROWS = 3, SMALL_PICTURE = 160 };
static const int numbers[NUMBERS] = {1, 10, 20, 40};
static const technique rows[ROWS] = {
    {"CSSM8, mip maps", MIPS, 4, {0}, COLOUR_CONVOLUTION, MARKER_UP, true},
    {"CSSM8, tables", TABLES, 4, {0}, COLOUR_CONVOLUTION, MARKER_DOWN, false},
    {"layered, 6 moments", LIBRARY, 6, {.moments = 6}, COLOUR_LAYERED, MARKER_CIRCLE, false}};

// Frames per second, 0 where none were measured: [row][side][number].
typedef double frames[ROWS][POINTS][NUMBERS];

static bool measure_frames(frames fps, int side, int number, message *why)
{
    bench b;
    if (!bench_open(&b, numbers[number], sides[side], why)) return false;
    bool done = bench_size(&b, SMALL_PICTURE, why);
    for (int k = 0; k < ROWS && done; k++) {
        subject s;
        done = subject_open(&s, &rows[k], &b, why);
        if (done) fps[k][side][number] = 1e3 / best_of(&b, &s).all;
        if (done) subject_close(&s);
    }
    done = done && no_gl_error(why);
    bench_close(&b);
    return done;
}

static void write_frames(const page *p, frames fps, int points)
{
    fprintf(p->file, "| fps | 1 light | 10 | 20 | 40 |\n|---|---|---|---|---|\n");
    for (int k = 0; k < ROWS; k++) {
        for (int i = 0; i < points; i++) {
            fprintf(p->file, "| %s, %d² |", rows[k].name, sides[i]);
            for (int n = 0; n < NUMBERS; n++)
                fprintf(p->file,
                        fps[k][i][n] > 0 ? fps[k][i][n] < 10 ? " %.2f |" : " %.1f |" : " - |",
                        fps[k][i][n]);
            fputs("\n", p->file);
        }
    }
}

bool many_lights(page *p, message *why)
{
    static frames fps;
    const int points = p->quick ? 1 : POINTS, at = p->quick ? 0 : 1;
    fprintf(p->file,
            "## Frames per second by lights\n\n"
            "Annen's Table 1: M = 4 terms (CSSM8) with mip maps and tables, beside this library's "
            "layered shadows; whole frames of the built-in scene, %d x %d. Convolution's maps have "
            "one sample a texel, this library's 4. 1024² with 40 lights is left out, as in the "
            "paper.\n\n",
            SMALL_PICTURE, SMALL_PICTURE * 9 / 16);
    if (!has_gl(p)) return true;
    for (int n = 0; n < NUMBERS; n++) {
        for (int i = 0; i < points; i++) {
            if (p->quick ? n % 2 : sides[i] == 1024 && numbers[n] == 40) continue;
            if (!measure_frames(fps, i, n, why)) return false;
        }
    }
    write_frames(p, fps, points);
    const double mips = fps[0][at][2] / fps[1][at][2], own = fps[2][at][2] / fps[1][at][2];
    const double lights = fps[1][at][0] / fps[1][at][2];
    fprintf(p->file,
            "\n**%s** With 20 lights of %d² mip maps give %.1f times the frames of tables (paper: "
            "25 against 7.5, 3.3 times%s). 20 lights instead of 1 take %.1f times as long with "
            "tables (paper: 110 against 7.5, 15 times). Layered shadows have tables of 6 values "
            "instead of 17, more arithmetic and less error ([accuracy.md](accuracy.md)): they give "
            "%.1f times the frames of convolution's tables.\n\n",
            mips > 1 ? "Agrees." : "Does not agree.", sides[at], mips,
            mips < 2 ? "; a GPU has units that filter mip maps, which a processor does in steps"
                     : "",
            lights, own);
    return true;
}
