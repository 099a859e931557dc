// What the page, the charts and the claims ask of the figures: which methods, scenes and sizes
// there are, means over them, and how a method looks.
#ifndef SUMMARY_H
#define SUMMARY_H

#include "figures.h"
#include "svg.h"

enum { NAMES_ROOM = 64 };

typedef struct names {
    int count;
    char list[NAMES_ROOM][FIGURE_NAME];
} names;

// In order of appearance. Scenes leave "all" out.
names methods_of(const figures *f, const char *experiment);
names metrics_of(const figures *f, const char *experiment);
names scenes_of(const figures *f, const char *experiment);
bool names_has(const names *n, const char *name);

typedef struct numbers {
    int count;
    double list[NAMES_ROOM];
} numbers;

// What an experiment sweeps, ascending; method and metric may be NULL.
numbers sweep_of(const figures *f, const char *experiment, const char *method, const char *metric);

typedef struct summary {
    int count;              // 0: nothing was measured, and all else is NAN
    double mean, low, high; // means of values and spreads
    double least, most;     // of the values
} summary;

// Over all figures that fit. scene NULL: every scene, but "all" only where there are no others;
// x NAN: every x.
summary summarize(const figures *f, const char *experiment, const char *scene, const char *method,
                  double x, const char *metric);
// The mean alone.
double mean_of(const figures *f, const char *experiment, const char *scene, const char *method,
               double x, const char *metric);
// One to one over scenes and x: how method's figure relates to other's.
typedef struct comparison {
    int cases, lower;        // in how many it is less
    double least, most;      // ratio
    double ratio;            // of the means
    char worst[FIGURE_NAME]; // the scene of the largest ratio
} comparison;

comparison compare(const figures *f, const char *experiment, const char *scene, const char *method,
                   const char *other, const char *metric);

// Error over all scenes and light sizes; nanoseconds a receiver, from the interleaved runs; bytes
// of a map of 256 texels a side, or of the side next to it.
double method_error(const figures *f, const char *method);
double method_ns(const figures *f, const char *method);
double method_bytes(const figures *f, const char *method);
// The widest kernel costs less than 1.5 times the narrowest.
bool method_constant_time(const figures *f, const char *method);
// Nearest to x among those measured; NAN without any.
double nearest(const numbers *n, double x);

typedef struct style {
    const char *family; // how its methods' names begin
    const char *title;  // of the family
    colour ink;
    marker shape;
} style;

extern const style styles[];
extern const int style_count;
const style *style_of(const char *method);

// The names the page speaks of.
#define LAYERED "layered, 6 moments"
#define LARGEST_FIRST "largest error first" // of lights
#define LAYERED_NORMAL "layered, 6 moments, normal"
#define PCSS_ALL "PCSS, all texels"
#define PCSS_NORMAL "PCSS, all texels, normal"
#define BACK_PROJECTION "back-projection, all texels, normal"
#define CONVOLUTION_TABLES CSSM16 CSSM_TABLES
#define CONVOLUTION_MIPS CSSM16 CSSM_MIPS
#define PCSS_VECTORS "PCSS, all texels in vectors"
#define FILTERED_4 "filtered, 4 moments"
#define FILTERED_PLAIN "filtered, 4 moments, full_shadow 1"
#define FILTERED_6 "filtered, 6 moments"
#define PCF_GAUSSIAN "PCF, Gaussian"
#define EVSM_GAUSSIAN "EVSM, Gaussian"
#define EVSM_HALVES "EVSM, Gaussian, 64 bits"

#endif
