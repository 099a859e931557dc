// Error of each method where two depths come close: what a depth buffer's last digits do at
// contact.
#ifndef DISTANCE_H
#define DISTANCE_H

#include "measure.h"

enum { DISTANCES = 29 };

typedef struct distance_row {
    double distance;       // of the two depths
    int failures[METHODS]; // not finite, out of range or crossed
    double error[METHODS]; // 99.9th percentile against the oracle; a reply that is not finite is 1
    double largest[METHODS];
} distance_row;

// Two depths in a patch, receivers at both, between them and at most their distance outside; at the
// safe bias of the format.
void distance_run(int m, int format, int trials, distance_row rows[DISTANCES]);

#endif
