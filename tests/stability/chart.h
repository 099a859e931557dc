// Line charts with logarithmic axes: the two pictures of the page.
#ifndef CHART_H
#define CHART_H

enum { CHART_SERIES = 8, CHART_POINTS = 32 };

typedef struct chart {
    const char *title, *x_name, *y_name;
    double x_low, x_high, y_low, y_high; // values outside are drawn at the edge
    int points, series;
    double x[CHART_POINTS];
    const char *name[CHART_SERIES]; // the first one is the library's
    double y[CHART_SERIES][CHART_POINTS];
} chart;

int chart_write(const chart *c, const char *path); // 0 when the file cannot be written

#endif
