#include "governor.h"

#include <math.h>
#include <string.h>

// Lower when the time is over the budget; higher when the next level is predicted to leave a tenth
// of it unused, for half a second on end. Between the two nothing changes, whatever the noise.
#define ROOM 0.9f
#define PATIENCE 30
// A trial that failed may have met a load that happened to rise just then. Frames until what it
// taught is doubted; twice as many after every failure, so that a true cost is not paid for again
// and again.
#define RETRY 600
#define RETRY_MOST (1 << 20)

// Costs as build/release/bench_governor measured them with llvmpipe: frames of 480 x 270, medians.
// They hold for the demo's scene; what another GPU makes of them is learnt on the way.
const quality governor_ladder[] = {
    {4, 128, 4, MSSM_LOWER_BLOCKER, 1.0f}, {4, 256, 4, MSSM_LAYERED, 1.5f},
    {8, 256, 4, MSSM_LAYERED, 2.5f},       {16, 256, 4, MSSM_LAYERED, 4.3f},
    {16, 256, 6, MSSM_LAYERED, 5.5f},      {32, 256, 6, MSSM_LAYERED, 9.7f},
    {32, 512, 6, MSSM_LAYERED, 15.5f},
};
const int governor_ladder_levels = sizeof governor_ladder / sizeof *governor_ladder;

bool governor_start(governor *g, const quality *ladder, int levels, int first, float budget)
{
    if (levels < 1 || levels > GOVERNOR_LEVELS || !(budget > 0 && budget < HUGE_VALF)) return false;
    for (int i = 0; i < levels; i++) {
        const float below = i > 0 ? ladder[i - 1].cost : 0;
        if (!(ladder[i].cost > below && ladder[i].cost < HUGE_VALF)) return false;
    }
    memset(g, 0, sizeof *g);
    g->budget = budget;
    g->levels = levels;
    g->level = first < 0 ? 0 : first < levels ? first : levels - 1;
    for (int i = 0; i < levels; i++) g->given[i] = g->cost[i] = ladder[i].cost;
    g->from = -1;
    g->retry = RETRY;
    return true;
}

// Medians don't move for a spike, and follow a step after half the window.
static float median(const float times[GOVERNOR_WINDOW])
{
    float sorted[GOVERNOR_WINDOW];
    for (int i = 0; i < GOVERNOR_WINDOW; i++) {
        int j = i;
        for (; j > 0 && sorted[j - 1] > times[i]; j--) sorted[j] = sorted[j - 1];
        sorted[j] = times[i];
    }
    return sorted[GOVERNOR_WINDOW / 2];
}

static void change(governor *g, int level)
{
    g->level = level;
    g->measured = 0;
    g->spare = 0;
    g->from = -1;
}

static float predicted(const governor *g, const float *cost, int level, float now)
{
    return now * cost[level] / cost[g->level];
}

// The first full window after a step up: what that step really costs, for it and those above.
static void learn(governor *g, float now)
{
    const float step = now / g->before;
    const float factor = (step > 1.01f ? step : 1.01f) * g->cost[g->from] / g->cost[g->level];
    for (int i = g->level; i < g->levels; i++) g->cost[i] *= factor;
    if (now > g->budget && g->retry < RETRY_MOST) g->retry *= 2;
    g->from = -1;
}

static void step_down(governor *g, float now)
{
    int level = g->level - 1;
    while (level > 0 && predicted(g, g->cost, level, now) > ROOM * g->budget) level--;
    change(g, level);
}

static void step_up(governor *g, float now)
{
    const int from = g->level;
    change(g, from + 1);
    g->from = from;
    g->before = now;
}

// Whether there has been room for the next level for long enough.
static bool room_above(governor *g, float now)
{
    if (g->level + 1 == g->levels) return false;
    const float room = ROOM * g->budget;
    const bool fits = predicted(g, g->cost, g->level + 1, now) <= room;
    const bool should = predicted(g, g->given, g->level + 1, now) <= room;
    g->spare = fits ? g->spare + 1 : 0;
    g->blocked = should && !fits ? g->blocked + 1 : 0;
    return g->spare >= PATIENCE || g->blocked >= g->retry;
}

int governor_frame(governor *g, float milliseconds, int drawn_at)
{
    if (drawn_at != g->level || !(milliseconds > 0 && milliseconds < HUGE_VALF)) return g->level;
    memmove(g->recent + 1, g->recent, sizeof g->recent - sizeof *g->recent);
    g->recent[0] = milliseconds;
    if (g->measured < GOVERNOR_WINDOW) g->measured++;
    if (g->measured < GOVERNOR_WINDOW) return g->level;
    const float now = median(g->recent);
    if (g->from >= 0) learn(g, now);
    if (now > g->budget) {
        if (g->level > 0) step_down(g, now);
    } else if (room_above(g, now)) {
        g->blocked = 0;
        step_up(g, now);
    }
    return g->level;
}
