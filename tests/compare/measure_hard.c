// Hard shadows of a light without size under Gaussians of one map: moments, percentage-closer
// filtering and variance against rays, in every scene and by the radius of the Gaussian.
#include "measure.h"

#include "../../examples/common/threads.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 256, RADII = 5, RECEIVERS = 1000, HARD_MOST = 12, TIMES = 5, SCENES_AT = 2 };
static const int radii[RADII] = {1, 2, 4, 8, 16};

// Sums over the receivers of one scene, or over scenes.
typedef struct tally {
    double rms, shaded, pcf[BIASES]; // see figures.h; the latter with each bias
    double leak, false_dark; // visibility where all rays are blocked, occlusion where none is
    double dark, lit;        // how many such receivers
} tally;

typedef struct hard_bench {
    void *state[RADII][HARD_MOST]; // of hard_methods[]
    float *front;
    mssm_light light;
    vec3 sun;
    receiver r[RECEIVERS];
    float value[HARD_MOST][BIASES][RECEIVERS];
    int count, radius, pcf; // the latter two are indices
    // Results
    tally sum[RADII][HARD_MOST][BIASES], scene[CASE_COUNT][HARD_MOST][BIASES];
    double ns[RADII][HARD_MOST][TIMES], update[RADII][HARD_MOST][CASE_COUNT], noise[RADII];
    char name[CASE_COUNT][48];
    int cases;
} hard_bench;

static bool bench_open(hard_bench *b, message *why)
{
    bool made =
        (b->front = malloc(SIDE * SIDE * sizeof *b->front)) && hard_method_count <= HARD_MOST;
    for (int i = 0; i < RADII * hard_method_count && made; i++) {
        size_t bytes;
        method m = hard_methods[i % hard_method_count];
        m.variant = radii[i / hard_method_count];
        void *state = m.create(&m, SIDE, &bytes);
        b->state[i / hard_method_count][i % hard_method_count] = state;
        made = state;
    }
    b->pcf = (int)(method_named("PCF, Gaussian") - hard_methods);
    return made || fail(why, "no memory for filtered maps");
}

static void bench_close(hard_bench *b)
{
    for (int i = 0; i < RADII * hard_method_count; i++) {
        void *state = b->state[i / hard_method_count][i % hard_method_count];
        if (state) hard_methods[i % hard_method_count].destroy(state);
    }
    free(b->front);
    free(b);
}

static float ask_hard(const hard_bench *b, int radius, int which, float bias, int index)
{
    const vec3 p = b->r[index].point;
    const float point[3] = {p.x, p.y, p.z};
    return hard_methods[which].visibility(b->state[radius][which], point, bias, (unsigned)index);
}

static void evaluate_one(void *context, int index)
{
    hard_bench *b = context;
    for (int i = 0; i < hard_method_count * BIASES; i++)
        b->value[i / BIASES][i % BIASES][index] =
            ask_hard(b, b->radius, i / BIASES, biases[i % BIASES], index);
}

// One method and bias over the receivers of a scene.
static tally tally_of(const hard_bench *b, int which, int bias)
{
    const float *value = b->value[which][bias];
    tally t = {0, 0, {0}, 0, 0, 0, 0};
    double cosines = 0;
    for (int i = 0; i < b->count; i++) {
        const double v = (double)value[i], truth = (double)b->r[i].truth;
        const double cosine = (double)vec_dot(b->r[i].normal, b->sun);
        t.rms += pow(v - truth, 2) / b->count;
        t.shaded += pow(cosine * (v - truth), 2);
        cosines += cosine * cosine;
        for (int k = 0; k < BIASES; k++)
            t.pcf[k] += pow(v - (double)b->value[b->pcf][k][i], 2) / b->count;
        t.leak += truth > 0 ? 0 : v;
        t.dark += truth > 0 ? 0 : 1;
        t.false_dark += truth < 1 ? 0 : 1 - v;
        t.lit += truth < 1 ? 0 : 1;
    }
    t.rms = sqrt(t.rms);
    t.shaded = sqrt(t.shaded / cosines);
    for (int k = 0; k < BIASES; k++) t.pcf[k] = sqrt(t.pcf[k]);
    return t;
}

static void add_tally(tally *sum, const tally *t)
{
    sum->rms += t->rms;
    sum->shaded += t->shaded;
    for (int k = 0; k < BIASES; k++) sum->pcf[k] += t->pcf[k];
    sum->leak += t->leak;
    sum->dark += t->dark;
    sum->false_dark += t->false_dark;
    sum->lit += t->lit;
}

// All receivers one after the other on one core.
static double seconds_of(const hard_bench *b, int radius, int which)
{
    static volatile float sink;
    const double start = cpu_seconds();
    for (int k = 0; k < b->count; k++) sink = ask_hard(b, radius, which, 2, k); // any bias
    (void)sink;
    return cpu_seconds() - start;
}

// In rounds over all radii and methods, each with its map in the cache.
static void time_methods(hard_bench *b)
{
    for (int round = 0; round < TIMES; round++) {
        for (int i = 0; i < RADII * hard_method_count; i++) {
            const int radius = i / hard_method_count, which = i % hard_method_count;
            seconds_of(b, radius, which);
            b->ns[radius][which][round] += 1e9 * seconds_of(b, radius, which) / b->count;
        }
    }
}

static void one_radius(hard_bench *b, const compare_case *c, int rays)
{
    const depth_map map = {&b->light, SIDE, b->front, NULL};
    double squares = 0;
    for (int i = 0; i < hard_method_count; i++) {
        const double start = cpu_seconds();
        hard_methods[i].update(b->state[b->radius][i], &map);
        b->update[b->radius][i][b->cases] = 1e3 * (cpu_seconds() - start);
    }
    case_truth_filtered(c, &b->light, SIDE, radii[b->radius], b->count, rays, 9, b->r);
    parallel_for(b->count, evaluate_one, b, NULL);
    for (int i = 0; i < hard_method_count * BIASES; i++) {
        const tally t = tally_of(b, i / BIASES, i % BIASES);
        add_tally(&b->sum[b->radius][i / BIASES][i % BIASES], &t);
        if (b->radius == SCENES_AT) b->scene[b->cases][i / BIASES][i % BIASES] = t;
    }
    for (int i = 0; i < b->count; i++) squares += pow((double)b->r[i].noise, 2) / b->count;
    b->noise[b->radius] += sqrt(squares);
}

static bool one_case(const measurement *m, hard_bench *b, int which, message *why)
{
    compare_case c;
    message missing;
    if (!case_make(&c, which, m->data, &missing)) {
        say("  a scene is left out: %s", missing.text);
        return true;
    }
    const bool done = case_light(&c, 0, 0, &b->light) == MSSM_OK &&
                      case_depth(&c, &b->light, SIDE, b->front, NULL) &&
                      case_receivers(&c, &b->light, b->count, 4, (uint64_t)which + 1, b->r);
    memcpy(b->name[b->cases], c.name, sizeof c.name);
    b->sun = c.sun;
    for (b->radius = 0; b->radius < RADII && done; b->radius++)
        one_radius(b, &c, m->quick ? 64 : 576);
    if (done) time_methods(b);
    case_free(&c);
    b->cases++;
    return done || fail(why, "%s: no receivers", b->name[b->cases - 1]);
}

// The bias with the least error over all scenes.
static int best_bias(const tally t[BIASES], const method *m)
{
    int best = 0;
    for (int k = 1; k < BIASES && takes_bias(m); k++) best = t[k].rms < t[best].rms ? k : best;
    return best;
}

static void put_one(measurement *m, const char *who, double x, const char *metric, double value)
{
    put(m, "hard", "all", who, x, metric, value, value, value);
}

static void put_method(measurement *m, hard_bench *b, int radius, int which)
{
    const char *who = hard_methods[which].name;
    const double x = radii[radius];
    const int bias = best_bias(b->sum[radius][which], &hard_methods[which]);
    const int pcf_bias = best_bias(b->sum[radius][b->pcf], &hard_methods[b->pcf]);
    const tally *t = &b->sum[radius][which][bias];
    const spread ns = spread_of(b->ns[radius][which], TIMES);
    const spread update = spread_of(b->update[radius][which], b->cases);
    put_one(m, who, x, "rms", t->rms / b->cases);
    put_one(m, who, x, "shaded_rms", t->shaded / b->cases);
    put_one(m, who, x, "pcf_rms", t->pcf[pcf_bias] / b->cases);
    put_one(m, who, x, "leak", t->leak / fmax(t->dark, 1));
    put_one(m, who, x, "false_shadow", t->false_dark / fmax(t->lit, 1));
    if (takes_bias(&hard_methods[which])) put_one(m, who, x, "bias", (double)biases[bias]);
    put(m, "hard", "all", who, x, "ns", ns.value / b->cases, ns.low / b->cases, ns.high / b->cases);
    put(m, "hard", "all", who, x, "update_ms", update.value, update.low, update.high);
    for (int k = 0; k < b->cases && radius == SCENES_AT; k++) {
        const double rms = b->scene[k][which][bias].rms;
        put(m, "hard_scene", b->name[k], who, x, "rms", rms, rms, rms);
    }
}

bool measure_hard(measurement *m, message *why)
{
    hard_bench *b = calloc(1, sizeof *b);
    if (!b) return fail(why, "no memory");
    b->count = m->quick ? RECEIVERS / 4 : RECEIVERS;
    bool done = bench_open(b, why);
    for (int which = 0; which < CASE_COUNT && done; which++) done = one_case(m, b, which, why);
    for (int radius = 0; radius < RADII && done; radius++) {
        const double noise = b->noise[radius] / b->cases;
        put(m, "truth", "all", "hard", radii[radius], "noise", noise, noise, noise);
        for (int i = 0; i < hard_method_count; i++) put_method(m, b, radius, i);
    }
    bench_close(b);
    return done;
}
