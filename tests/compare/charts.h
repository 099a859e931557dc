// The pictures of docs/: each shows one thing, says it in its title, and takes all numbers from the
// figures.
#ifndef CHARTS_H
#define CHARTS_H

#include "figures.h"

typedef struct chart {
    const char *file; // in the folder of the page
    // Writes the picture; false if it cannot be written.
    bool (*draw)(const figures *f, const char *path);
    // The sentence that the picture shows.
    void (*message)(const figures *f, char *text, size_t room);
    const char *experiment; // without its figures there is no picture
    bool speaks_of_layered; // and compares it with PCSS reading every texel
} chart;

extern const chart charts[];
extern const int chart_count;

const chart *chart_named(const char *file);
// Whether its experiment was run.
bool chart_possible(const figures *f, const chart *c);

#endif
