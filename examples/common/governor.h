// Holds a frame time: fewer lights, smaller maps, fewer moments when the GPU is late, more again
// when it has time to spare. It never tries a quality blindly: from the time measured at one
// quality and the relative costs it predicts the time of the others, and learns where a prediction
// was wrong, so that the same mistake is not made twice under the same load.
#ifndef GOVERNOR_H
#define GOVERNOR_H

#include "../../mssm.h"

#include <stdbool.h>

typedef struct quality {
    int lights, map_side, moments;
    mssm_estimator estimator;
    float cost; // of a frame, relative to any other of the ladder (docs/accuracy.md has figures)
} quality;

enum { GOVERNOR_LEVELS = 16, GOVERNOR_WINDOW = 7 };

typedef struct governor {
    float budget;      // milliseconds a frame may take
    int levels, level; // level 0 is the cheapest
    // Private.
    float given[GOVERNOR_LEVELS], cost[GOVERNOR_LEVELS]; // what the ladder says, what turned out
    float recent[GOVERNOR_WINDOW];                       // times of the latest frames at this level
    int measured;                                        // how many there are
    int spare;          // frames for which the next level would have fitted
    int from;           // the level below, while its successor is on trial; -1: none is
    float before;       // and its time
    int blocked, retry; // frames that only a learnt cost kept from a trial; when to doubt it
} governor;

// The best lights, map sides, moments and estimators for every cost: what the demo uses.
extern const quality governor_ladder[];
extern const int governor_ladder_levels;

// Starts at the lowest level that is at least `first`. Costs must ascend and be positive; false
// otherwise, or for a budget that is not above 0, with g untouched.
bool governor_start(governor *g, const quality *ladder, int levels, int first, float budget);

// Takes the GPU's time of one frame and the level that this frame was drawn at (timer queries come
// a few frames late; a frame of another level than g->level tells nothing and is left out). Returns
// the level to draw the next frame at: g->level.
int governor_frame(governor *g, float milliseconds, int drawn_at);

#endif
