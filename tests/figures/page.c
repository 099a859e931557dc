#include "page.h"

#include "../../examples/common/font.h"
#include "../../examples/common/png.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *page_path(const page *p, const char *name)
{
    static char path[1024];
    snprintf(path, sizeof path, "%s/%s", p->folder, name);
    return path;
}

// ---- Sheets -------------------------------------------------------------------------------------

enum { GAP = 6, LABEL = 26 };

bool sheet_create(sheet *s, int panels)
{
    s->rows = (panels + SHEET_COLUMNS - 1) / SHEET_COLUMNS;
    s->width = SHEET_COLUMNS * (PANEL_WIDTH + GAP) + GAP;
    s->height = s->rows * (PANEL_HEIGHT + LABEL + GAP);
    s->panels = 0;
    const size_t bytes = 3 * (size_t)s->width * (size_t)s->height;
    s->rgb = malloc(bytes);
    if (s->rgb) memset(s->rgb, 255, bytes);
    return s->rgb;
}

static void put_text(const sheet *s, int x, int y, const char *text)
{
    static const unsigned glyphs[64] = {FONT_GLYPHS};
    for (; *text; text++, x += 6) {
        const int code = *text >= 'a' && *text <= 'z' ? *text - 'a' + 'A' : *text;
        for (int i = 0; i < 30 && code >= 32 && code < 96; i++) {
            if (glyphs[code - 32] >> i & 1)
                memset(s->rgb + 3 * ((size_t)(y + i / 5) * (size_t)s->width + (size_t)(x + i % 5)),
                       26, 3);
        }
    }
}

void sheet_add(sheet *s, const image *picture, float exposure, const char *first,
               const char *second)
{
    static unsigned char rgb[3 * PANEL_WIDTH * PANEL_HEIGHT];
    const int left = GAP + s->panels % SHEET_COLUMNS * (PANEL_WIDTH + GAP);
    const int top = s->panels / SHEET_COLUMNS * (PANEL_HEIGHT + LABEL + GAP);
    s->panels++;
    image_tonemap(picture, exposure, rgb);
    for (int y = 0; y < picture->height; y++) {
        memcpy(s->rgb + 3 * ((size_t)(top + LABEL + y) * (size_t)s->width + (size_t)left),
               rgb + 3 * y * picture->width, 3 * (size_t)picture->width);
    }
    put_text(s, left, top + 7, first);
    put_text(s, left, top + 17, second);
}

bool sheet_close(sheet *s, const char *path, message *why)
{
    const bool done = png_write(path, s->rgb, s->width, s->height, why);
    free(s->rgb);
    return done;
}

// ---- Charts -------------------------------------------------------------------------------------

void series_add(series *s, double x, double y)
{
    if (s->count == SERIES_POINTS) return;
    s->x[s->count] = x;
    s->y[s->count++] = y;
}

double series_at(const series *s, double x)
{
    for (int i = 0; i < s->count; i++)
        if (s->x[i] == x) return s->y[i];
    return NAN;
}

bool nearer(double growth, double one, double other)
{
    return fabs(log(growth / one)) < fabs(log(growth / other));
}

static bool shown_before(const panel *panels, int panel_index, int series_index)
{
    const char *name = panels[panel_index].list[series_index].name;
    for (int i = 0; i <= panel_index; i++) {
        for (int k = 0; k < panels[i].count && (i < panel_index || k < series_index); k++)
            if (!strcmp(panels[i].list[k].name, name)) return true;
    }
    return false;
}

// Names and looks of all series, in as many rows as they need; returns the height.
static double draw_key(svg *s, const panel *panels, int count, double top, bool draw)
{
    double x = 24, y = top + 10;
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < panels[i].count; k++) {
            const series *one = &panels[i].list[k];
            if (shown_before(panels, i, k)) continue;
            const double wide = 48 + svg_text_width(one->name, 12);
            if (x + wide > s->width) {
                x = 24;
                y += 18;
            }
            if (draw) {
                svg_line(s, x - 12, y - 4, x + 12, y - 4, one->ink, 2, one->dashed);
                svg_marker(s, x, y - 4, one->shape, one->ink, 4);
                svg_text(s, x + 16, y, "start", COLOUR_INK, 12, one->name);
            }
            x += wide;
        }
    }
    return y + 16 - top;
}

static void draw_panel(svg *s, const panel *from, double x, double y, double width, double height,
                       bool first)
{
    plot p = {s,
              x,
              y,
              width,
              height,
              axis_make(from->across, true),
              axis_make(first ? "milliseconds" : "", true)};
    for (int k = 0; k < from->count; k++) {
        for (int i = 0; i < from->list[k].count; i++) {
            axis_include(&p.across, from->list[k].x[i]);
            axis_include(&p.up, from->list[k].y[i]);
        }
    }
    int full = 0; // tables have no percentage-closer shadows, and their row of the key is first
    while (full < from->count && !from->list[full].count) full++;
    for (int i = 0; full < from->count && i < from->list[full].count; i++)
        axis_tick(&p.across, from->list[full].x[i]);
    axis_finish(&p.across);
    axis_finish(&p.up);
    plot_grid(&p);
    for (int k = 0; k < from->count; k++) {
        const series *one = &from->list[k];
        double across[SERIES_POINTS], up[SERIES_POINTS];
        for (int i = 0; i < one->count; i++) {
            across[i] = plot_x(&p, one->x[i]);
            up[i] = plot_y(&p, one->y[i]);
            svg_marker(s, across[i], up[i], one->shape, one->ink, 4);
        }
        if (one->count) svg_polyline(s, one->count, across, up, one->ink, 2, one->dashed);
    }
}

bool chart_draw(const char *path, const char *title, const panel *panels, int count, message *why)
{
    enum { WIDTH = 960, HEIGHT = 300 };
    svg s = {.width = WIDTH};
    const double key = draw_key(&s, panels, count, 0, false);
    if (!svg_open(&s, path, WIDTH, key + HEIGHT + 60, title))
        return fail(why, "cannot write %s", path);
    const double top = s.top + draw_key(&s, panels, count, s.top, true) + 8;
    const double each = (WIDTH - 16.0) / count;
    for (int i = 0; i < count; i++)
        draw_panel(&s, &panels[i], 60 + i * each, top, each - 60, HEIGHT, i == 0);
    return svg_close(&s) || fail(why, "cannot write %s", path);
}

void chart_table(FILE *file, const char *corner, const panel *p)
{
    double x[4 * SERIES_POINTS];
    int columns = 0;
    for (int k = 0; k < p->count; k++) {
        for (int i = 0; i < p->list[k].count; i++) {
            int at = 0;
            while (at < columns && x[at] < p->list[k].x[i]) at++;
            if (at < columns && x[at] == p->list[k].x[i]) continue;
            memmove(x + at + 1, x + at, (size_t)(columns - at) * sizeof *x);
            x[at] = p->list[k].x[i];
            columns++;
        }
    }
    fprintf(file, "| %s |", corner);
    for (int i = 0; i < columns; i++) fprintf(file, " %g |", x[i]);
    fputs("\n|---|", file);
    for (int i = 0; i < columns; i++) fputs("---|", file);
    for (int k = 0; k < p->count; k++) {
        if (!p->list[k].count) continue;
        fprintf(file, "\n| %s |", p->list[k].name);
        for (int i = 0; i < columns; i++) {
            const double y = series_at(&p->list[k], x[i]);
            if (isnan(y))
                fputs(" - |", file);
            else
                fprintf(file,
                        y >= 100  ? " %.0f |"
                        : y >= 10 ? " %.1f |"
                        : y >= 1  ? " %.2f |"
                                  : " %.3f |",
                        y);
        }
    }
    fputs("\n\n", file);
}
