// Side-by-side pictures for the docs: one area light, the truth by rays, every method from the same
// depth map, and beneath each where it is too bright or too dark.
//     pictures OUT.png CASE TANGENT EYE_X EYE_Y EYE_Z AT_X AT_Y AT_Z
// CASE is a name from cases.c; TANGENT is of the light's half-angle.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../examples/common/font.h"
#include "../../examples/common/png.h"
#include "../../examples/common/raster.h"
#include "../../examples/common/threads.h"
#include "cases.h"
#include "flip.h"

enum { WIDTH = 456, HEIGHT = 257, LABEL = 24, GAP = 8, COLUMNS = 3, ROWS = 2 };
enum { ROW = 2 * (HEIGHT + LABEL) + GAP };
enum { SHEET_WIDTH = COLUMNS * (WIDTH + GAP) + GAP, SHEET_HEIGHT = ROWS * ROW };
enum { MAP_SIDE = 256, RAYS = 32, PANELS = COLUMNS * ROWS };
// The error of visibility that is drawn in the strongest colour, and the steps up to it: with as
// many as 256 the rays' noise would make up most of the file.
#define FULL_SCALE 0.5f
#define STEPS 10

// In reading order; the first is the truth.
static const char *const panels[PANELS] = {NULL,
                                           "PCSS, all texels, normal",
                                           CSSM16 CSSM_MIPS,
                                           "MSSM 6, lower blocker",
                                           "MSSM 6, upper blocker",
                                           "layered, 6 moments, normal"};

// A piece of surface in a pixel.
typedef struct piece {
    vec3 point, normal, albedo;
    float share, cosine; // of the pixel; towards the middle of the light
    bool counts;         // the whole light is above its horizon
    float truth, seen;
} piece;

typedef struct pixel {
    piece part[VIEW_SAMPLES + 1];
    int parts;
} pixel;

typedef struct pictures {
    compare_case c;
    camera eye;
    mssm_light light;
    vec3 axis_u, axis_v, towards;
    float *depth;
    image truth, seen; // as the sheet shows them, in linear colours
    pixel *pixels;
    unsigned char *sheet;
    const method *method; // at work; NULL: rays
    void *state;
} pictures;

// ---- Letters and areas --------------------------------------------------------------------------

static void put_pixel(unsigned char *sheet, int x, int y, vec3 srgb)
{
    const float rgb[3] = {srgb.x, srgb.y, srgb.z};
    if (x < 0 || y < 0 || x >= SHEET_WIDTH || y >= SHEET_HEIGHT) return;
    for (int k = 0; k < 3; k++) {
        const float value = fminf(fmaxf(rgb[k], 0), 1);
        sheet[3 * (y * SHEET_WIDTH + x) + k] = (unsigned char)(255 * value + 0.5f);
    }
}

static void put_text(unsigned char *sheet, int x, int y, const char *text)
{
    static const unsigned glyphs[64] = {FONT_GLYPHS};
    enum { SCALE = 2 };
    for (; *text; text++, x += 6 * SCALE) {
        const int code = *text >= 'a' && *text <= 'z' ? *text - 'a' + 'A' : *text;
        for (int i = 0; i < 30 * SCALE * SCALE && code >= 32 && code < 96; i++) {
            const int column = i % (5 * SCALE), row = i / (5 * SCALE);
            if (glyphs[code - 32] >> (5 * (row / SCALE) + column / SCALE) & 1) {
                put_pixel(sheet, x + column, y + row, vec(0.1f, 0.1f, 0.1f));
            }
        }
    }
}

// Grey where equal, blue where too bright, orange where too dark.
static vec3 error_colour(float error)
{
    const float t = fminf(roundf(fabsf(error) * (STEPS / FULL_SCALE)) / STEPS, 1);
    const vec3 end = error > 0 ? vec(0.05f, 0.30f, 0.95f) : vec(1.0f, 0.50f, 0.0f);
    return vec_mix(vec(0.80f, 0.80f, 0.80f), end, t);
}

static float to_srgb(float x)
{
    return powf(fminf(fmaxf(x, 0), 1), 1 / 2.2f);
}

// ---- Receivers ----------------------------------------------------------------------------------

static void add_piece(pictures *p, pixel *to, vec3 point, vec3 normal, vec3 albedo, float share)
{
    const mssm_light *l = &p->light;
    const float reach = l->half_u * fabsf(vec_dot(normal, p->axis_u)) +
                        l->half_v * fabsf(vec_dot(normal, p->axis_v));
    const float cosine = vec_dot(normal, p->towards);
    to->part[to->parts++] =
        (piece){point, normal, albedo, share, cosine, cosine > reach + 0.02f, 0, 0};
}

static void collect_pixel(pictures *p, const view *v, int x, int y)
{
    pixel *to = &p->pixels[y * WIDTH + x];
    surface found[VIEW_SAMPLES];
    const int count = view_surfaces(v, &p->c.scene, x, y, found);
    float rest = 1;
    for (int i = 0; i < count; i++) {
        add_piece(p, to, found[i].position, found[i].normal, p->c.scene.albedo[found[i].object],
                  found[i].share);
        rest -= found[i].share;
    }
    const vec3 ray = camera_ray(&p->eye, ((float)x + 0.5f) / WIDTH, ((float)y + 0.5f) / HEIGHT);
    const float distance = (p->c.ground - p->eye.position.y) / ray.y;
    if (rest > 0.01f && distance > 0) { // the casters are all above the ground
        add_piece(p, to, vec_mad(p->eye.position, ray, distance), vec(0, 1, 0),
                  vec(0.6f, 0.6f, 0.6f), rest);
    }
}

static float visibility_of(const pictures *p, const piece *at, unsigned seed)
{
    const float point[3] = {at->point.x, at->point.y, at->point.z};
    const float normal[3] = {at->normal.x, at->normal.y, at->normal.z};
    float seen;
    if (p->method && p->method->many) {
        p->method->many(p->state, 1, &point, &normal, p->method->bias, &seen);
        return seen;
    }
    if (p->method) return p->method->visibility(p->state, point, p->method->bias, seed);
    return trace_rectangle(p->c.tree, vec_mad(at->point, at->normal, 2e-3f), NULL, p->towards,
                           p->axis_u, p->axis_v, p->light.half_u, p->light.half_v, RAYS, seed);
}

static void see_row(void *context, int y)
{
    const pictures *p = context;
    for (int x = 0; x < WIDTH; x++) {
        pixel *at = &p->pixels[y * WIDTH + x];
        for (int i = 0; i < at->parts; i++) {
            piece *s = &at->part[i];
            s->seen = s->cosine > 0 ? visibility_of(p, s, (unsigned)(y * WIDTH + x)) : 0;
            if (!p->method) s->truth = s->seen;
        }
    }
}

// ---- Panels -------------------------------------------------------------------------------------

static vec3 lit_colour(const pixel *at)
{
    const vec3 sky = vec(0.75f, 0.80f, 0.86f);
    vec3 sum = vec(0, 0, 0);
    float rest = 1;
    for (int i = 0; i < at->parts; i++) {
        const piece *s = &at->part[i];
        const float light = 0.14f + 0.03f * s->normal.y + 0.9f * fmaxf(s->cosine, 0) * s->seen;
        sum = vec_mad(sum, s->albedo, 1.15f * light * s->share);
        rest -= s->share;
    }
    sum = vec_mad(sum, sky, fmaxf(rest, 0));
    return vec(to_srgb(sum.x), to_srgb(sum.y), to_srgb(sum.z));
}

static float error_of(const pixel *at)
{
    float error = 0;
    for (int i = 0; i < at->parts; i++) {
        if (at->part[i].counts) error += at->part[i].share * (at->part[i].seen - at->part[i].truth);
    }
    return error;
}

static double rms_of(const pictures *p)
{
    double sum = 0, weight = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const pixel *at = &p->pixels[i];
        for (int k = 0; k < at->parts; k++) {
            const double error = (double)at->part[k].seen - at->part[k].truth;
            if (!at->part[k].counts) continue;
            sum += at->part[k].share * error * error;
            weight += at->part[k].share;
        }
    }
    return weight > 0 ? sqrt(sum / weight) : 0;
}

static void draw_panel(pictures *p, int panel)
{
    const int left = GAP + panel % COLUMNS * (WIDTH + GAP);
    const int top = LABEL + panel / COLUMNS * ROW;
    const int below = top + HEIGHT + LABEL;
    char label[96];
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const int x = left + i % WIDTH, y = i / WIDTH;
        const vec3 shown = lit_colour(&p->pixels[i]);
        for (int k = 0; k < 3; k++)
            (panel ? &p->seen : &p->truth)->rgb[3 * i + k] = powf(k == 0   ? shown.x
                                                                  : k == 1 ? shown.y
                                                                           : shown.z,
                                                                  2.2f);
        put_pixel(p->sheet, x, top + y, shown);
        if (panel > 0) put_pixel(p->sheet, x, below + y, error_colour(error_of(&p->pixels[i])));
    }
    put_text(p->sheet, left, top - 17, panel ? panels[panel] : "truth: rays");
    if (panel == 0) return;
    snprintf(label, sizeof label, "rms error %.3f, FLIP %.3f", rms_of(p),
             flip_mean(&p->truth, &p->seen));
    put_text(p->sheet, left, below - 17, label);
}

// Beneath the truth, which has no error: what the colours mean, and what was drawn.
static void draw_legend(const pictures *p)
{
    enum { LEFT = GAP, TOP = 2 * LABEL + HEIGHT + 30, BAR = WIDTH - 40, HIGH = 28 };
    char line[96];
    put_text(p->sheet, LEFT, TOP - 17, "visibility less truth:");
    for (int i = 0; i < BAR * HIGH; i++) {
        const float error = FULL_SCALE * (2 * (float)(i % BAR) / (BAR - 1) - 1);
        put_pixel(p->sheet, LEFT + i % BAR, TOP + 8 + i / BAR, error_colour(error));
    }
    put_text(p->sheet, LEFT, TOP + 44, "-0.5");
    put_text(p->sheet, LEFT + BAR / 2 - 5, TOP + 44, "0");
    put_text(p->sheet, LEFT + BAR - 48, TOP + 44, "+0.5");
    put_text(p->sheet, LEFT, TOP + 66, "too dark");
    put_text(p->sheet, LEFT + BAR / 2 - 29, TOP + 66, "equal");
    put_text(p->sheet, LEFT + BAR - 120, TOP + 66, "too bright");
    snprintf(line, sizeof line, "scene: %s", p->c.name);
    put_text(p->sheet, LEFT, TOP + 116, line);
    snprintf(line, sizeof line, "light: tangent of half-angle %.2f", (double)p->light.half_u);
    put_text(p->sheet, LEFT, TOP + 138, line);
    snprintf(line, sizeof line, "depth map: %d x %d for all", MAP_SIDE, MAP_SIDE);
    put_text(p->sheet, LEFT, TOP + 160, line);
    snprintf(line, sizeof line, "truth: %d rays a pixel", RAYS * RAYS);
    put_text(p->sheet, LEFT, TOP + 182, line);
}

// ---- The program --------------------------------------------------------------------------------

static bool find_case(compare_case *c, const char *name, message *why)
{
    for (int i = 0; i < CASE_ALL; i++) {
        if (!case_make(c, i, NULL, why)) continue; // a mesh that is not here
        if (!strcmp(c->name, name)) return true;
        case_free(c);
    }
    return fail(why, "no case is called %s", name);
}

static bool prepare(pictures *p, float tangent, vec3 from, vec3 to, message *why)
{
    view v;
    const float *m = p->light.world_to_shadow;
    if (case_light(&p->c, tangent, tangent, &p->light) != MSSM_OK)
        return fail(why, "no such light");
    p->axis_u = vec_unit(vec(m[0], m[4], m[8]));
    p->axis_v = vec_unit(vec(m[1], m[5], m[9]));
    p->towards = vec_unit(vec(-m[2], -m[6], -m[10]));
    p->eye = camera_look(from, to, 0.57f, (float)WIDTH / HEIGHT);
    p->depth = malloc(2 * MAP_SIDE * MAP_SIDE * sizeof *p->depth);
    p->pixels = calloc(WIDTH * HEIGHT, sizeof *p->pixels);
    p->sheet = malloc(3 * SHEET_WIDTH * SHEET_HEIGHT);
    if (!p->depth || !p->pixels || !p->sheet || !image_create(&p->truth, WIDTH, HEIGHT) ||
        !image_create(&p->seen, WIDTH, HEIGHT) ||
        !case_depth(&p->c, &p->light, MAP_SIDE, p->depth,
                    p->c.closed ? p->depth + MAP_SIDE * MAP_SIDE : NULL) ||
        !view_create(&v, &p->c.scene, &p->eye, WIDTH, HEIGHT)) {
        return fail(why, "no memory for the picture");
    }
    memset(p->sheet, 255, 3 * SHEET_WIDTH * SHEET_HEIGHT);
    for (int i = 0; i < WIDTH * HEIGHT; i++) collect_pixel(p, &v, i % WIDTH, i / WIDTH);
    view_free(&v);
    return true;
}

static bool draw_method(pictures *p, int panel, message *why)
{
    size_t bytes;
    p->method = panels[panel] ? method_named(panels[panel]) : NULL;
    const bool mean = p->c.closed && p->method && !strcmp(p->method->family, "MSSM"); // Kneiphof
    const depth_map map = {&p->light, MAP_SIDE, p->depth,
                           mean ? p->depth + MAP_SIDE * MAP_SIDE : NULL};
    if (panels[panel] && !p->method) return fail(why, "no method is called %s", panels[panel]);
    if (p->method) {
        p->state = p->method->create(p->method, MAP_SIDE, &bytes);
        if (!p->state) return fail(why, "no memory for %s", panels[panel]);
        p->method->update(p->state, &map);
    }
    parallel_for(HEIGHT, see_row, p, panels[panel] ? panels[panel] : "tracing the truth");
    draw_panel(p, panel);
    if (p->method) p->method->destroy(p->state);
    return true;
}

int main(int argc, char **argv)
{
    static pictures p;
    message why = {"usage: pictures OUT.png CASE TANGENT EYE_X EYE_Y EYE_Z AT_X AT_Y AT_Z"};
    float number[7] = {0};
    for (int i = 0; i < 7 && argc == 10; i++) number[i] = (float)atof(argv[i + 3]);
    bool done = argc == 10 && find_case(&p.c, argv[2], &why) &&
                prepare(&p, number[0], vec_of(number + 1), vec_of(number + 4), &why);
    for (int i = 0; i < PANELS && done; i++) done = draw_method(&p, i, &why);
    if (done) draw_legend(&p);
    if (done) done = png_write(argv[1], p.sheet, SHEET_WIDTH, SHEET_HEIGHT, &why);
    if (!done) fprintf(stderr, "pictures: %s\n", why.text);
    return done ? 0 : 1;
}
