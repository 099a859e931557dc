// Error and time of every method in every scene under lights of every size, and the biases that the
// rivals get.
#include "measure.h"

#include "../../examples/common/threads.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 256, TANGENTS = 6 };

static const float tangents[TANGENTS] = {0.02f, 0.05f, 0.1f, 0.2f, 0.4f, 0.8f};
static const int every_size[TANGENTS] = {1, 1, 1, 1, 1, 1};
static const int new_sizes[TANGENTS] = {0, 1, 0, 1, 1, 0}; // of scenes that are not the chart's own

// How much work is put into a table.
typedef struct effort {
    int receivers, rays, rounds; // no rounds: no times
    const int *size;             // which of the tangents
    int cases;                   // from the first on; only the chart's own are timed
} effort;

typedef struct cell {
    bool measured;
    errors e[METHODS_MOST][BIASES];
    spread ns[METHODS_MOST];
    double noise;
} cell;

typedef struct table {
    char name[CASE_ALL][48];
    cell at[CASE_ALL][TANGENTS];
} table;

// Errors of all methods with all biases.
static bool measure_errors(const bench *b, const receiver *r, int count, cell *to, message *why)
{
    float *value = malloc((size_t)(method_count + 1) * (size_t)count * sizeof *value);
    if (!value) return fail(why, "no memory for %d receivers", count);
    for (int bias = 0; bias < BIASES; bias++) {
        int same[METHODS_MOST];
        for (int i = 0; i < method_count; i++)
            same[i] = bias == 0 || takes_bias(&methods[i]) ? bias : -1;
        bench_evaluate(b, same, r, count, value);
        for (int i = 0; i < method_count; i++) {
            if (same[i] < 0) continue;
            to->e[i][bias] = errors_of(value + i * count, r, count, value + method_count * count);
        }
    }
    free(value);
    return true;
}

// One case under one light. A light too large for the case leaves the cell unmeasured.
static bool measure_cell(const measurement *m, bench *b, const compare_case *c, float tangent,
                         const effort *work, uint64_t seed, cell *to, message *why)
{
    receiver *r = malloc((size_t)work->receivers * sizeof *r);
    const int count = work->receivers;
    if (!r) return fail(why, "no memory for %d receivers", count);
    bool done = bench_update(b, c, tangent, why);
    if (done && !case_receivers(c, &b->light, count, work->rays, seed, r)) {
        say("  %s, tangent %g: no surface sees the whole light, left out", c->name,
            (double)tangent);
        free(r);
        return true;
    }
    if (done) done = measure_errors(b, r, count, to, why);
    if (done && work->rounds) bench_time(b, m->bias, r, count, work->rounds, to->ns);
    for (int i = 0; i < count && done; i++)
        to->noise += (double)r[i].noise * (double)r[i].noise / count;
    to->noise = sqrt(to->noise);
    to->measured = done;
    free(r);
    return done;
}

static bool measure_table(const measurement *m, const effort *work, table *t, message *why)
{
    bench b;
    bool done = bench_create(&b, SIDE, why);
    memset(t, 0, sizeof *t);
    for (int which = 0; which < work->cases && done; which++) {
        compare_case c;
        effort here = *work;
        if (which >= CASE_COUNT) here.size = new_sizes, here.rounds = 0;
        message missing;
        const double start = seconds_now();
        if (!case_make(&c, which, m->data, &missing)) {
            say("  a scene is left out: %s", missing.text);
            continue;
        }
        memcpy(t->name[which], c.name, sizeof c.name);
        for (int l = 0; l < TANGENTS && done; l++) {
            if (!work->size[l] || !here.size[l]) continue;
            done = measure_cell(m, &b, &c, tangents[l], &here, (uint64_t)(which * TANGENTS + l + 1),
                                &t->at[which][l], why);
        }
        if (work->rounds) say("  %-14s %5.1f s", c.name, seconds_now() - start);
        case_free(&c);
    }
    bench_free(&b);
    return done;
}

// ---- Biases --------------------------------------------------------------------------------

static void choose_biases(measurement *m, const table *t)
{
    for (int i = 0; i < method_count; i++) {
        double sum[BIASES] = {0};
        for (int k = 0; k < CASE_COUNT * TANGENTS; k++) {
            const cell *at = &t->at[k / TANGENTS][k % TANGENTS];
            for (int bias = 0; bias < BIASES && at->measured; bias++)
                sum[bias] += at->e[i][bias].rms;
        }
        m->bias[i] = 0;
        for (int bias = 1; bias < BIASES && takes_bias(&methods[i]); bias++) {
            if (sum[bias] < sum[m->bias[i]]) m->bias[i] = bias;
        }
    }
    m->bias_known = true;
}

bool measure_biases(measurement *m, message *why)
{
    static const int two[TANGENTS] = {0, 1, 0, 1, 0, 0};
    const effort little = {150, 144, 0, two, CASE_COUNT};
    if (m->bias_known) return true;
    table *t = malloc(sizeof *t);
    if (!t) return fail(why, "no memory");
    say("biases of the rivals");
    const bool done = measure_table(m, &little, t, why);
    if (done) choose_biases(m, t);
    free(t);
    return done;
}

// ---- Figures -------------------------------------------------------------------------------

// Methods whose error in each scene and size is asked for.
bool is_followed(const char *name)
{
    static const char *const followed[] = {"hard",
                                           "PCSS, all texels",
                                           "PCSS, all texels, normal",
                                           CSSM16 CSSM_MIPS,
                                           "back-projection, all texels, normal",
                                           "MSSM 6, lower blocker",
                                           "MSSM 6, upper blocker",
                                           "layered, 4 moments",
                                           "layered, 6 moments",
                                           "layered, 6 moments, normal"};
    for (size_t i = 0; i < sizeof followed / sizeof *followed; i++)
        if (!strcmp(name, followed[i])) return true;
    return false;
}

static void put_case(measurement *m, const char *experiment_name, const char *name, double x,
                     const cell *at)
{
    for (int i = 0; i < method_count; i++) {
        const double rms = at->e[i][m->bias[i]].rms;
        if (is_followed(methods[i].name))
            put(m, experiment_name, name, methods[i].name, x, "rms", rms, rms, rms);
    }
}

// Means over the cells with lights from..to of the table, with quartiles of the cells.
typedef double cell_value(const measurement *m, const cell *at, int who);

static double cell_rms(const measurement *m, const cell *at, int who)
{
    return at->e[who][m->bias[who]].rms;
}

static double cell_best(const measurement *m, const cell *at, int who)
{
    double best = cell_rms(m, at, who);
    for (int bias = 0; bias < BIASES && takes_bias(&methods[who]); bias++)
        best = fmin(best, at->e[who][bias].rms);
    return best;
}

static double cell_ns(const measurement *m, const cell *at, int who)
{
    (void)m;
    return at->ns[who].value;
}

// A part of the table: scenes from first on, before end, and lights from..to.
typedef struct part {
    int first, end, from, to;
} part;

static spread over_cells(const measurement *m, const table *t, part p, int who, cell_value *value)
{
    double values[CASE_ALL * TANGENTS], sum = 0;
    int count = 0;
    for (int which = p.first; which < p.end; which++) {
        for (int l = p.from; l <= p.to; l++) {
            if (t->at[which][l].measured) values[count++] = value(m, &t->at[which][l], who);
        }
    }
    if (!count) return (spread){0, 0, 0};
    for (int i = 0; i < count; i++) sum += values[i];
    spread s = spread_of(values, count);
    s.value = sum / count;
    return s;
}

static void put_all(measurement *m, const table *t, int from, int to, double x)
{
    static const struct {
        const char *metric;
        cell_value *value;
    } kinds[] = {{"rms", cell_rms}, {"ns", cell_ns}};
    const size_t last = sizeof kinds / sizeof *kinds - 1;
    for (int i = 0; i < method_count; i++) {
        for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
            const part p = {0, CASE_COUNT, from, to};
            const spread s = over_cells(m, t, p, i, kinds[k].value);
            const char *to_experiment = x <= 0 ? "overall" : k == last ? "speed" : "error";
            put(m, to_experiment, "all", methods[i].name, x, kinds[k].metric, s.value, s.value,
                s.value);
        }
    }
}

// Means over the scenes of a group, all their lights.
static void put_group(measurement *m, const table *t, const char *experiment_name, int first,
                      int end)
{
    const part p = {first, end, 0, TANGENTS - 1};
    for (int i = 0; i < method_count; i++) {
        const double rms = over_cells(m, t, p, i, cell_rms).value;
        put(m, experiment_name, "all", methods[i].name, 0, "rms", rms, rms, rms);
    }
}

static void put_noise(measurement *m, const table *t)
{
    double sum = 0, most = 0;
    int count = 0;
    for (int k = 0; k < CASE_ALL * TANGENTS; k++) {
        const cell *at = &t->at[k / TANGENTS][k % TANGENTS];
        if (!at->measured) continue;
        sum += at->noise;
        most = fmax(most, at->noise);
        count++;
    }
    put(m, "truth", "all", "error", 0, "noise", sum / count, sum / count, sum / count);
    put(m, "truth", "all", "error", 0, "noise_most", most, most, most);
}

static bool any_measured(const table *t, int l)
{
    bool any = false;
    for (int which = 0; which < CASE_COUNT; which++) any = any || t->at[which][l].measured;
    return any;
}

bool measure_error(measurement *m, message *why)
{
    static const int some[TANGENTS] = {0, 1, 0, 1, 0, 1};
    const effort full = {1000, 484, 7, every_size, CASE_ALL}, quick = {200, 144, 3, some, CASE_ALL};
    table *t = malloc(sizeof *t);
    if (!t) return fail(why, "no memory");
    bool done = measure_biases(m, why) && measure_table(m, m->quick ? &quick : &full, t, why);
    if (done) choose_biases(m, t); // now from all receivers
    for (int l = 0; l < TANGENTS && done; l++) {
        if (any_measured(t, l)) put_all(m, t, l, l, (double)tangents[l]);
    }
    if (done) put_all(m, t, 0, TANGENTS - 1, 0);
    if (done) put_noise(m, t);
    if (done) put_group(m, t, "new", CASE_COUNT, CASE_COUNT + CASE_NEW);
    if (done) put_group(m, t, "unseen", CASE_COUNT + CASE_NEW, CASE_ALL);
    for (int k = 0; k < CASE_ALL * TANGENTS && done; k++) {
        const int which = k / TANGENTS, l = k % TANGENTS;
        const char *group = which < CASE_COUNT ? "error" : case_group(which);
        if (t->at[which][l].measured)
            put_case(m, group, t->name[which], (double)tangents[l], &t->at[which][l]);
    }
    for (int i = 0; i < method_count && done; i++) {
        const double bias = (double)biases[m->bias[i]];
        if (takes_bias(&methods[i]))
            put(m, "overall", "all", methods[i].name, 0, "bias", bias, bias, bias);
    }
    free(t);
    return done;
}

// ---- A scene from a file -------------------------------------------------------------------

static void print_cell(const measurement *m, const compare_case *c, double tangent, const cell *at)
{
    printf("%s, %d triangles, light of half-angle tangent %g, noise of the truth %.4f\n", c->name,
           c->scene.triangles, tangent, at->noise);
    printf("  %-35s %8s %8s %8s %9s %6s %14s\n", "method", "rms", "mean", "p99", "ns", "bias",
           "rms, best bias");
    for (int i = 0; i < method_count; i++) {
        const errors *e = &at->e[i][m->bias[i]];
        const bool biased = takes_bias(&methods[i]);
        printf("  %-35s %8.4f %8.4f %8.4f %9.0f %6.1f %14.4f\n", methods[i].name, e->rms, e->mean,
               e->p99, at->ns[i].value, biased ? (double)biases[m->bias[i]] : 0,
               cell_best(m, at, i));
    }
}

bool measure_scene(measurement *m, message *why)
{
    const effort full = {2000, 1024, 9, every_size, 0}, quick = {300, 256, 3, every_size, 0};
    compare_case c;
    bench b;
    if (!case_load(&c, m->scene, m->sun, why)) return false;
    cell *at = calloc(TANGENTS, sizeof *at);
    memset(&b, 0, sizeof b);
    bool done = at ? measure_biases(m, why) && bench_create(&b, SIDE, why) : fail(why, "no memory");
    for (int l = 0; l < TANGENTS && done; l++) {
        done = measure_cell(m, &b, &c, tangents[l], m->quick ? &quick : &full, (uint64_t)l + 1,
                            &at[l], why);
        if (!done || !at[l].measured) continue;
        print_cell(m, &c, (double)tangents[l], &at[l]);
        put_case(m, "error", c.name, (double)tangents[l], &at[l]);
    }
    bench_free(&b);
    free(at);
    case_free(&c);
    return done;
}
