// The governor against simulated GPUs: steps, ramps, spikes, noise, timers that report late, and
// ladders whose costs are wrong.
#include "../../examples/common/governor.h"
#include "../support/test.h"

#include <math.h>

enum { LEVELS = 6, LATE = 3 };
static const quality ladder[LEVELS] = {{1, 1, 4, MSSM_LAYERED, 1},    {2, 1, 4, MSSM_LAYERED, 1.5f},
                                       {3, 1, 4, MSSM_LAYERED, 2.5f}, {4, 1, 4, MSSM_LAYERED, 4},
                                       {5, 1, 4, MSSM_LAYERED, 7},    {6, 1, 4, MSSM_LAYERED, 10}};

typedef struct gpu {
    governor governor;
    double cost[LEVELS]; // the true ones
    double noise;
    uint64_t seed;
    int queue[LATE]; // levels of the frames whose times are not known yet
    double load[LATE];
    int frames, changes, ups, late, worst_late, late_now;
} gpu;

static void gpu_start(gpu *u, int first, double noise)
{
    *u = (gpu){.noise = noise, .seed = 11};
    CHECK(governor_start(&u->governor, ladder, LEVELS, first, 16), "start");
    for (int i = 0; i < LEVELS; i++) u->cost[i] = (double)ladder[i].cost;
    for (int i = 0; i < LATE; i++) {
        u->queue[i] = first;
        u->load[i] = 1;
    }
}

// One frame under a load (milliseconds at cost 1): drawn now, reported LATE frames later.
static void gpu_frame(gpu *u, double load)
{
    const int slot = u->frames++ % LATE, before = u->governor.level;
    const double time =
        u->load[slot] * u->cost[u->queue[slot]] * (1 + u->noise * (2 * test_uniform(&u->seed) - 1));
    const int level = governor_frame(&u->governor, (float)time, u->queue[slot]);
    u->changes += level != before;
    u->ups += level > before;
    u->queue[slot] = level;
    u->load[slot] = load;
    u->late_now = load * u->cost[level] > 16 ? u->late_now + 1 : 0;
    u->late += u->late_now > 0;
    if (u->late_now > u->worst_late) u->worst_late = u->late_now;
}

static void gpu_run(gpu *u, int frames, double from, double to)
{
    u->changes = u->ups = u->late = u->worst_late = u->late_now = 0;
    for (int i = 0; i < frames; i++) gpu_frame(u, from + (to - from) * i / frames);
}

// The highest level that fits with a tenth to spare, and the highest that fits at all.
static void expect_best(const gpu *u, double load, const char *after)
{
    int sure = 0, most = 0;
    for (int i = 1; i < LEVELS; i++) {
        if (load * u->cost[i] <= 0.85 * 16) sure = i;
        if (load * u->cost[i] <= 16) most = i;
    }
    CHECK(u->governor.level >= sure && u->governor.level <= most, "level %d after %s, not %d to %d",
          u->governor.level, after, sure, most);
}

static void steady_load_is_answered_once(void)
{
    int most = 0;
    for (double load = 0.5; load < 30; load *= 1.07) {
        for (int first = 0; first < LEVELS; first += LEVELS - 1) {
            gpu u;
            gpu_start(&u, first, 0.05);
            gpu_run(&u, 600, load, load);
            expect_best(&u, load, "a start");
            gpu_run(&u, 20000, load, load);
            if (u.changes > most) most = u.changes;
            expect_best(&u, load, "a long time");
        }
    }
    test_note("changes in 20000 more frames under any steady load with 5%% noise: %d", most);
    CHECK(most <= 1, "%d changes", most);
}

static void steps_and_ramps_are_followed(void)
{
    gpu u;
    gpu_start(&u, 3, 0.05);
    gpu_run(&u, 400, 1.5, 1.5);
    expect_best(&u, 1.5, "the start");
    gpu_run(&u, 400, 6, 6);
    expect_best(&u, 6, "a step up");
    test_note("frames over the budget after the load became four times as heavy: %d", u.late);
    CHECK(u.late <= 20, "%d late frames", u.late);
    gpu_run(&u, 600, 1.5, 1.5);
    expect_best(&u, 1.5, "a step down");
    CHECK(u.late == 0, "late while the load fell");
    gpu_run(&u, 3000, 1.5, 12);
    expect_best(&u, 12, "a ramp up");
    CHECK(u.ups == 0 && u.worst_late <= 20, "%d up, late for %d", u.ups, u.worst_late);
    gpu_run(&u, 3000, 12, 1);
    expect_best(&u, 1.1, "a ramp down");
    CHECK(u.changes == u.ups && u.late == 0, "%d changes, %d of them up, %d late", u.changes, u.ups,
          u.late);
}

static void spikes_are_ignored(void)
{
    gpu u;
    gpu_start(&u, 0, 0.05);
    gpu_run(&u, 600, 2, 2);
    u.changes = 0;
    for (int i = 0; i < 3000; i++) gpu_frame(&u, i % 50 < 3 ? 12 : 2);
    CHECK(u.changes == 0, "%d changes", u.changes);
    expect_best(&u, 2, "spikes");
}

// The thesis' controller applied and undid one action for ever: a level that is said to fit, and
// doesn't.
static void wrong_costs_are_learnt(void)
{
    for (double wrong = 0.6; wrong < 5; wrong *= 1.3) {
        gpu u;
        gpu_start(&u, 0, 0.05);
        for (int i = 3; i < LEVELS; i++) u.cost[i] *= wrong;
        gpu_run(&u, 2000, 2.5, 2.5);
        if (wrong >= 1) expect_best(&u, 2.5, "learning");
        const int first = u.changes;
        gpu_run(&u, 100000, 2.5, 2.5);
        test_note("costs wrong by %.2f: %d changes in the first 2000 frames, %d in 100000 more",
                  wrong, first, u.changes);
        CHECK(first <= 8 && u.changes <= 16, "it swings");
    }
}

// A trial that met a heavier load by accident must not shut a level out for ever.
static void accidents_are_forgotten(void)
{
    gpu u;
    gpu_start(&u, 2, 0);
    while (u.governor.level == 2 && u.frames < 200) gpu_frame(&u, 3);
    for (int i = 0; i < 40; i++) gpu_frame(&u, 9);
    gpu_run(&u, 4000, 3, 3);
    expect_best(&u, 3, "an accident");
}

static void nonsense_is_refused(void)
{
    governor g;
    const quality falling[2] = {{1, 1, 4, MSSM_LAYERED, 2}, {1, 1, 4, MSSM_LAYERED, 1}};
    const quality unknown[1] = {{1, 1, 4, MSSM_LAYERED, NAN}};
    CHECK(!governor_start(&g, falling, 2, 0, 16), "falling costs");
    CHECK(!governor_start(&g, unknown, 1, 0, 16), "NaN");
    CHECK(!governor_start(&g, ladder, 0, 0, 16), "no level");
    CHECK(!governor_start(&g, ladder, LEVELS, 0, 0), "no budget");
    CHECK(governor_start(&g, ladder, LEVELS, 99, 16) && g.level == LEVELS - 1, "clamped start");
    const float hostile[] = {NAN, INFINITY, -1, 0};
    for (int i = 0; i < 400; i++) {
        CHECK(governor_frame(&g, hostile[i % 4], g.level) == LEVELS - 1, "moved by nonsense");
    }
    CHECK(governor_start(&g, governor_ladder, governor_ladder_levels, 0, 16), "the demo's ladder");
}

const test_case governor_tests[] = {
    {"the governor answers a steady load once and then rests", steady_load_is_answered_once},
    {"the governor follows steps and ramps of the load", steps_and_ramps_are_followed},
    {"the governor ignores spikes", spikes_are_ignored},
    {"the governor learns costs that are wrong", wrong_costs_are_learnt},
    {"the governor forgets accidents", accidents_are_forgotten},
    {"the governor refuses nonsense", nonsense_is_refused},
    {0, 0},
};
