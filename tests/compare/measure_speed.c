// Speed of the moment math one by one and over arrays, next to the published algorithms; and of the
// map's update next to copying its bytes.
//
// Arrays are fast only where the compiler vectorises: build this program with config=vector for
// that (`make chart` does); figures carry the way of building in the method's name.
#include "measure.h"

#include "../support/published_moments.h"
#include "../support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#if defined __GNUC__
#define NOINLINE __attribute__((noinline))
#else
#define NOINLINE
#endif

// ---- Bounds --------------------------------------------------------------------------------

enum { BOUNDS = 4096, BOUND_ROUNDS = 31, BOUND_REPEATS = 32 };

static float rows[6][BOUNDS], depth[BOUNDS], lower[BOUNDS], upper[BOUNDS];

// 1 to 12 depths and a receiver anywhere, at a bias where the published algorithms do not break
// down.
static void fill_bounds(void)
{
    uint64_t state = 1;
    for (int i = 0; i < BOUNDS; i++) {
        mssm_moments6 m;
        double sum[6] = {0}, total = 0;
        const int depths = 1 + (int)test_range(&state, 0, 12);
        for (int k = 0; k < depths; k++) {
            const double z = test_range(&state, -1, 1), w = test_range(&state, 0.05, 1.05);
            double power = w;
            for (int j = 0; j < 6; j++) sum[j] += power *= z;
            total += w;
        }
        for (int j = 0; j < 6; j++) m.b[j] = (float)(sum[j] / total);
        m = mssm_moments6_bias(m, 1e-4f);
        for (int j = 0; j < 6; j++) rows[j][i] = m.b[j];
        depth[i] = (float)test_range(&state, -1, 1);
    }
}

NOINLINE static float published4_call(mssm_moments4 m, float z)
{
    return published4(m.b, z);
}

NOINLINE static float published6_call(mssm_moments6 m, float z)
{
    return published6(m.b, z);
}

NOINLINE static float published6_short_call(mssm_moments6 m, float z)
{
    return published6_short(m.b, z);
}

static void each_published4(void)
{
    for (int i = 0; i < BOUNDS; i++) {
        const mssm_moments4 m = {{rows[0][i], rows[1][i], rows[2][i], rows[3][i]}};
        upper[i] = published4_call(m, depth[i]);
    }
}

static void each_published6(void)
{
    for (int i = 0; i < BOUNDS; i++) {
        const mssm_moments6 m = {
            {rows[0][i], rows[1][i], rows[2][i], rows[3][i], rows[4][i], rows[5][i]}};
        upper[i] = published6_call(m, depth[i]);
    }
}

static void each_published6_short(void)
{
    for (int i = 0; i < BOUNDS; i++) {
        const mssm_moments6 m = {
            {rows[0][i], rows[1][i], rows[2][i], rows[3][i], rows[4][i], rows[5][i]}};
        upper[i] = published6_short_call(m, depth[i]);
    }
}

static void each_mssm4(void)
{
    for (int i = 0; i < BOUNDS; i++) {
        const mssm_moments4 m = {{rows[0][i], rows[1][i], rows[2][i], rows[3][i]}};
        upper[i] = mssm_visibility4(m, depth[i]).upper;
    }
}

static void each_mssm6(void)
{
    for (int i = 0; i < BOUNDS; i++) {
        const mssm_moments6 m = {
            {rows[0][i], rows[1][i], rows[2][i], rows[3][i], rows[4][i], rows[5][i]}};
        upper[i] = mssm_visibility6(m, depth[i]).upper;
    }
}

NOINLINE static void array_published4(void)
{
    for (int i = 0; i < BOUNDS; i++) {
        const float b[4] = {rows[0][i], rows[1][i], rows[2][i], rows[3][i]};
        upper[i] = published4(b, depth[i]);
    }
}

NOINLINE static void array_published6(void)
{
    for (int i = 0; i < BOUNDS; i++) {
        const float b[6] = {rows[0][i], rows[1][i], rows[2][i], rows[3][i], rows[4][i], rows[5][i]};
        upper[i] = published6(b, depth[i]);
    }
}

NOINLINE static void array_published6_short(void)
{
    for (int i = 0; i < BOUNDS; i++) {
        const float b[6] = {rows[0][i], rows[1][i], rows[2][i], rows[3][i], rows[4][i], rows[5][i]};
        upper[i] = published6_short(b, depth[i]);
    }
}

static void array_mssm4(void)
{
    const float *const b[4] = {rows[0], rows[1], rows[2], rows[3]};
    mssm_visibility4_array(BOUNDS, b, depth, lower, upper);
}

static void array_mssm6(void)
{
    const float *const b[6] = {rows[0], rows[1], rows[2], rows[3], rows[4], rows[5]};
    mssm_visibility6_array(BOUNDS, b, depth, lower, upper);
}

typedef struct contest {
    const char *name;
    void (*run[2])(void); // published, library
    double times[2][BOUND_ROUNDS];
} contest;

static void time_contest(contest *c, int round)
{
    for (int who = 0; who < 2; who++) {
        const double start = cpu_seconds();
        for (int i = 0; i < BOUND_REPEATS; i++) c->run[who]();
        c->times[who][round] = 1e9 * (cpu_seconds() - start) / (BOUND_REPEATS * BOUNDS);
    }
}

// How this program was compiled.
static const char *building(void)
{
#if defined __NO_MATH_ERRNO__ || defined __FAST_MATH__
    return "vectorised";
#else
    return "as built";
#endif
}

// "and shares": the published algorithm that also finds the shares of all depths, as the blocker
// search of its paper needs them; the library's bounds are the same in both rows.
bool measure_array(measurement *m, message *why)
{
    static contest contests[] = {
        {"4 moments, one by one", {each_published4, each_mssm4}, {{0}, {0}}},
        {"6 moments, one by one", {each_published6_short, each_mssm6}, {{0}, {0}}},
        {"6 moments and shares, one by one", {each_published6, each_mssm6}, {{0}, {0}}},
        {"4 moments, arrays", {array_published4, array_mssm4}, {{0}, {0}}},
        {"6 moments, arrays", {array_published6_short, array_mssm6}, {{0}, {0}}},
        {"6 moments and shares, arrays", {array_published6, array_mssm6}, {{0}, {0}}}};
    enum { CONTESTS = sizeof contests / sizeof *contests };
    (void)why;
    fill_bounds();
    for (int round = 0; round < BOUND_ROUNDS; round++) {
        for (int c = 0; c < CONTESTS; c++) time_contest(&contests[c], round);
    }
    for (int c = 0; c < CONTESTS; c++) {
        static const char *const sides[2] = {"published", "mssm.h"};
        spread ns[2];
        for (int who = 0; who < 2; who++) {
            char name[FIGURE_NAME];
            ns[who] = spread_of(contests[c].times[who], BOUND_ROUNDS);
            snprintf(name, sizeof name, "%s, %s", contests[c].name, sides[who]);
            put(m, "array", building(), name, 0, "ns", ns[who].value, ns[who].low, ns[who].high);
        }
        const double faster = ns[0].value / ns[1].value;
        put(m, "array", building(), contests[c].name, 0, "speedup", faster, ns[0].low / ns[1].high,
            ns[0].high / ns[1].low);
    }
    return true;
}

// ---- Update against copying ----------------------------------------------------------------

enum { COPY_ROUNDS = 9 };

static bool bandwidth_at(measurement *m, int side, int moments, message *why)
{
    const size_t bytes = mssm_map_bytes(side, moments), texels = (size_t)side * (size_t)side;
    const int repeats = side < 512 ? 16 : 2;
    void *memory = malloc(bytes), *copy = malloc(bytes);
    float *front = malloc(texels * sizeof *front);
    double update[COPY_ROUNDS], copying[COPY_ROUNDS];
    mssm_map *map;
    uint64_t state = 31;
    bool done =
        memory && copy && front && mssm_map_init(&map, memory, bytes, side, moments) == MSSM_OK;
    for (size_t i = 0; i < texels && done; i++) front[i] = (float)test_range(&state, -1, 1);
    for (int round = 0; round < COPY_ROUNDS && done; round++) {
        const double start = cpu_seconds();
        for (int i = 0; i < repeats && done; i++)
            done = mssm_map_update(map, front, NULL, 1) == MSSM_OK;
        const double middle = cpu_seconds();
        for (int i = 0; i < repeats; i++) {
            memcpy(copy, memory, bytes);
            ((volatile char *)copy)[(size_t)i] = 1; // or the compiler leaves copies out
        }
        update[round] = 1e-9 * (double)bytes * repeats / (middle - start);
        copying[round] = 1e-9 * (double)bytes * repeats / (cpu_seconds() - middle);
    }
    free(memory);
    free(copy);
    free(front);
    if (!done) return fail(why, "no memory for a map of %d^2", side);
    const spread u = spread_of(update, COPY_ROUNDS), c = spread_of(copying, COPY_ROUNDS);
    const char *name = moments == 4 ? "4 moments" : "6 moments";
    put(m, "bandwidth", "all", name, side, "update_gbs", u.value, u.low, u.high);
    put(m, "bandwidth", "all", name, side, "copy_gbs", c.value, c.low, c.high);
    put(m, "bandwidth", "all", name, side, "share", u.value / c.value, u.low / c.high,
        u.high / c.low);
    return true;
}

bool measure_bandwidth(measurement *m, message *why)
{
    static const int sides[] = {128, 256, 512, 1024};
    bool done = true;
    for (size_t k = 0; k < sizeof sides / sizeof *sides && done; k++)
        done = bandwidth_at(m, sides[k], 4, why) && bandwidth_at(m, sides[k], 6, why);
    return done;
}
