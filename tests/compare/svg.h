// Line pictures as SVG text: shapes, axes, and labels that keep out of each other's way. Colours
// come as classes, so that a picture follows its page from light to dark.
#ifndef SVG_H
#define SVG_H

#include <stdbool.h>
#include <stdio.h>

typedef struct svg {
    FILE *file;
    double width, height;
    double top; // below the title
} svg;

// The palette. Every colour has a contrast of at least 3.4 against its page, and they stay apart
// for the colour-blind; text is always written in ink.
typedef enum colour {
    COLOUR_INK,
    COLOUR_FAINT,
    COLOUR_GRID,
    COLOUR_LAYERED,
    COLOUR_MSSM,
    COLOUR_PCSS,
    COLOUR_CONVOLUTION,
    COLOUR_VARIANCE,
    COLOUR_BACK_PROJECTION,
    COLOUR_HARD
} colour;

typedef enum marker {
    MARKER_CIRCLE,
    MARKER_SQUARE,
    MARKER_DIAMOND,
    MARKER_UP,
    MARKER_DOWN,
    MARKER_CROSS,
    MARKER_PLUS
} marker;

// Opens the file and writes the title over as many lines as it needs, with that much room below
// it. False if it cannot.
bool svg_open(svg *s, const char *path, double width, double below, const char *title);
bool svg_close(svg *s);

// anchor is "start", "middle" or "end"; size in pixels, bold where negative.
void svg_text(svg *s, double x, double y, const char *anchor, colour ink, double size,
              const char *text);
void svg_text_upwards(svg *s, double x, double y, colour ink, double size, const char *text);
void svg_line(svg *s, double x0, double y0, double x1, double y1, colour ink, double width,
              bool dashed);
void svg_polyline(svg *s, int count, const double *x, const double *y, colour ink, double width,
                  bool dashed);
void svg_bar(svg *s, double x, double y, double width, double height, colour ink);
void svg_marker(svg *s, double x, double y, marker shape, colour ink, double size);
// Never less than what common sans-serif fonts need.
double svg_text_width(const char *text, double size);

enum { AXIS_TICKS = 16 };

typedef struct axis {
    double low, high; // empty while low > high
    bool log;
    const char *name;
    int given; // numbers to write; 0: round ones
    double tick[AXIS_TICKS];
} axis;

axis axis_make(const char *name, bool log);
void axis_include(axis *a, double value);
// Numbers that the axis shows instead of round ones.
void axis_tick(axis *a, double value);
// Some air at both ends; a linear axis starts at 0.
void axis_finish(axis *a);

typedef struct plot {
    svg *svg;
    double x, y, width, height; // of the frame, without numbers and names
    axis across, up;
} plot;

double plot_x(const plot *p, double value);
double plot_y(const plot *p, double value);
// Grid, numbers and the names of both axes.
void plot_grid(const plot *p);

enum { LABEL_ROOM = 64 };

typedef struct label {
    double x, y;           // what it names
    double left, baseline; // where it went
    double size;           // as in svg_text
    char text[56];
    colour ink;
} label;

typedef struct labels {
    int count;
    label list[LABEL_ROOM];
    double clear; // pixels around every named point that stay free
} labels;

// Without a text: a point that labels keep away from.
void labels_add(labels *l, double x, double y, colour ink, double size, const char *text);
// Moves the labels around their points until they overlap each other, the points and the frame as
// little as can be, and draws them; a thin line leads to those that went far.
void labels_scatter(labels *l, const plot *p);
// Stacks the labels beside the right end of the plot, each as near its own height as the others let
// it.
void labels_stack(labels *l, const plot *p);

#endif
