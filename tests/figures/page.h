// docs/figures.md and its pictures: every figure is a function that measures, draws, and says in
// one sentence whether it agrees with the paper.
#ifndef FIGURES_PAGE_H
#define FIGURES_PAGE_H

#include <stdio.h>

#include "../../examples/common/image.h"
#include "../compare/svg.h"

typedef struct page {
    FILE *file;
    const char *folder;
    bool quick; // small and few: whether it works, not what it says
} page;

// The path of a file beside the page, in a buffer of the page's own.
const char *page_path(const page *p, const char *name);

typedef bool page_figure(page *p, message *why);
page_figure light_sources, probe_times, shadow_times, probe_lights_one, probe_lights_two,
    blocker_bounds, many_lights, hard_shadow_times;

// ---- Sheets of pictures -------------------------------------------------------------------------

enum { PANEL_WIDTH = 320, PANEL_HEIGHT = 180, SHEET_COLUMNS = 3 };

typedef struct sheet {
    int width, height, rows, panels;
    unsigned char *rgb;
} sheet;

bool sheet_create(sheet *s, int panels);
// The next panel: a picture of at most PANEL_WIDTH x PANEL_HEIGHT, and two lines over it.
void sheet_add(sheet *s, const image *picture, float exposure, const char *first,
               const char *second);
// Saves and frees.
bool sheet_close(sheet *s, const char *path, message *why);

// ---- Charts -------------------------------------------------------------------------------------

enum { SERIES_POINTS = 8, CHART_SERIES = 10, CHART_PANELS = 3 };

typedef struct series {
    const char *name;
    colour ink;
    marker shape;
    bool dashed;
    int count;
    double x[SERIES_POINTS], y[SERIES_POINTS];
} series;

typedef struct panel {
    const char *across; // axes are logarithmic; times are in milliseconds
    int count;
    series list[CHART_SERIES];
} panel;

void series_add(series *s, double x, double y);
double series_at(const series *s, double x); // NAN where there is none
// Whether a growth is more like the one than like the other, by ratios.
bool nearer(double growth, double one, double other);
// Panels side by side, with one key: series of the same name look the same.
bool chart_draw(const char *path, const char *title, const panel *panels, int count, message *why);
// The same as a table: a row a series, a column an x.
void chart_table(FILE *file, const char *corner, const panel *p);

#endif
