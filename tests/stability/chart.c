// The pictures, drawn with the plotter of tests/compare.
#include "chart.h"

#include "../compare/svg.h"

#include <math.h>

static double held(double v, double low, double high)
{
    return v > low ? (v < high ? v : high) : low;
}

static axis fixed_axis(const char *name, double low, double high)
{
    axis a = axis_make(name, true);
    a.low = low;
    a.high = high;
    return a;
}

int chart_write(const chart *c, const char *path)
{
    static const colour inks[CHART_SERIES] = {
        COLOUR_LAYERED, COLOUR_MSSM,     COLOUR_PCSS,        COLOUR_HARD,
        COLOUR_INK,     COLOUR_VARIANCE, COLOUR_CONVOLUTION, COLOUR_BACK_PROJECTION};
    static const marker shapes[CHART_SERIES] = {MARKER_CIRCLE, MARKER_PLUS,   MARKER_UP,
                                                MARKER_DOWN,   MARKER_SQUARE, MARKER_DIAMOND,
                                                MARKER_CROSS,  MARKER_CIRCLE};
    svg s;
    if (!svg_open(&s, path, 810, 400, c->title)) return 0;
    plot p = {&s,
              92,
              s.top + 16,
              440,
              330,
              fixed_axis(c->x_name, c->x_low, c->x_high),
              fixed_axis(c->y_name, c->y_low, c->y_high)};
    plot_grid(&p);
    for (int k = c->series - 1; k >= 0; k--) { // the library's on top
        double x[CHART_POINTS], y[CHART_POINTS];
        for (int i = 0; i < c->points; i++) {
            x[i] = plot_x(&p, held(c->x[i], c->x_low, c->x_high));
            y[i] = plot_y(&p, held(c->y[k][i], c->y_low, c->y_high));
            if ((i + k) % 4 == 0) svg_marker(&s, x[i], y[i], shapes[k], inks[k], 3.5);
        }
        svg_polyline(&s, c->points, x, y, inks[k], k ? 1.5 : 3, k > 1);
        const double left = p.x + p.width + 18, at = p.y + 12 + 22 * k;
        svg_line(&s, left, at, left + 26, at, inks[k], k ? 1.5 : 3, k > 1);
        svg_marker(&s, left + 13, at, shapes[k], inks[k], 3.5);
        svg_text(&s, left + 33, at + 4, "start", COLOUR_INK, 12, c->name[k]);
    }
    return svg_close(&s);
}
