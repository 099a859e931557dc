// The workbench and the statistics of measure.h.
#include "measure.h"

#include "../../examples/common/threads.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

const float biases[BIASES] = {0, 1, 2, 3, 4, 6, 8, 16};

void say(const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vfprintf(stderr, format, list);
    va_end(list);
    fputc('\n', stderr);
}

void put(measurement *m, const char *experiment_name, const char *scene_name,
         const char *method_name, double x, const char *metric, double value, double low,
         double high)
{
    if (figures_add(&m->f, experiment_name, scene_name, method_name, x, metric, value, low, high))
        return;
    say("measure: %s, %s, %s, %g, %s = %g cannot be kept", experiment_name, scene_name, method_name,
        x, metric, value);
    exit(1);
}

// ---- Statistics ----------------------------------------------------------------------------

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int compare_floats(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

spread spread_of(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, compare_doubles);
    const double middle = 0.5 * (values[(count - 1) / 2] + values[count / 2]);
    const spread s = {middle, values[count / 4], values[count - 1 - count / 4]};
    return s;
}

errors errors_of(const float *value, const receiver *r, int count, float *scratch)
{
    double sum = 0, squares = 0, fourths = 0;
    for (int i = 0; i < count; i++) {
        const double e = (double)value[i] - (double)r[i].truth;
        sum += e;
        squares += e * e;
        fourths += e * e * e * e;
        scratch[i] = (float)fabs(e);
    }
    qsort(scratch, (size_t)count, sizeof *scratch, compare_floats);
    const double mean = squares / count;
    const double error = sqrt(fmax(fourths / count - mean * mean, 0) / count);
    const errors e = {sqrt(mean), sqrt(fmax(mean - error, 0)), sqrt(mean + error), sum / count,
                      (double)scratch[(int)(0.99 * (count - 1) + 0.5)]};
    return e;
}

// ---- The workbench -------------------------------------------------------------------------

bool takes_bias(const method *m)
{
    return strcmp(m->family, "MSSM") && strcmp(m->family, "layered") &&
           strcmp(m->family, "filtered");
}

bool bench_create(bench *b, int side, message *why)
{
    memset(b, 0, sizeof *b);
    b->side = side;
    b->front = malloc((size_t)side * (size_t)side * sizeof *b->front);
    b->back = malloc((size_t)side * (size_t)side * sizeof *b->back);
    bool made = b->front && b->back && method_count <= METHODS_MOST;
    for (int i = 0; i < method_count && made; i++) {
        b->state[i] = methods[i].create(&methods[i], side, &b->bytes[i]);
        made = b->state[i];
    }
    if (made) return true;
    bench_free(b);
    return fail(why, "no memory for all methods at %d^2", side);
}

void bench_free(bench *b)
{
    for (int i = 0; i < method_count; i++) {
        if (b->state[i]) methods[i].destroy(b->state[i]);
    }
    free(b->front);
    free(b->back);
    memset(b, 0, sizeof *b);
}

depth_map bench_map(const bench *b, const method *m)
{
    const bool mean = b->closed && !strcmp(m->family, "MSSM"); // Kneiphof, 4.2.3
    return (depth_map){&b->light, b->side, b->front, mean ? b->back : NULL};
}

bool bench_update(bench *b, const compare_case *c, float tangent, message *why)
{
    const mssm_result result = case_light(c, tangent, tangent, &b->light);
    if (result) return fail(why, "%s: %s", c->name, mssm_result_string(result));
    b->closed = c->closed;
    if (!case_depth(c, &b->light, b->side, b->front, b->closed ? b->back : NULL))
        return fail(why, "no memory");
    for (int i = 0; i < method_count; i++) {
        const depth_map map = bench_map(b, &methods[i]);
        methods[i].update(b->state[i], &map);
    }
    return true;
}

// Receivers from number first on, round and round, by one method.
static void ask(const bench *b, int which, int bias, const receiver *r, int count, int first, int n,
                float *value)
{
    enum { BLOCK = 64 };
    const method *m = &methods[which];
    float points[BLOCK][3], normals[BLOCK][3];
    for (int i = 0; i < n; i += BLOCK) {
        const int some = n - i < BLOCK ? n - i : BLOCK;
        for (int k = 0; k < some; k++) {
            const receiver *one = &r[(first + i + k) % count];
            const vec3 p = one->point, q = one->normal;
            points[k][0] = p.x, points[k][1] = p.y, points[k][2] = p.z;
            normals[k][0] = q.x, normals[k][1] = q.y, normals[k][2] = q.z;
        }
        if (m->many) {
            m->many(b->state[which], some, (const float(*)[3])points, (const float(*)[3])normals,
                    biases[bias], value + i);
            continue;
        }
        for (int k = 0; k < some; k++)
            value[i + k] = m->visibility(b->state[which], points[k], biases[bias],
                                         (unsigned)((first + i + k) % count));
    }
}

typedef struct evaluation {
    const bench *b;
    const int *bias;
    const receiver *r;
    int count;
    float *value;
} evaluation;

enum { SHARE = 128 }; // receivers a task

static void evaluate_some(void *context, int index)
{
    const evaluation *e = context;
    const int first = index * SHARE, rest = e->count - first, n = rest < SHARE ? rest : SHARE;
    for (int i = 0; i < method_count; i++) {
        if (e->bias[i] >= 0)
            ask(e->b, i, e->bias[i], e->r, e->count, first, n, e->value + i * e->count + first);
    }
}

void bench_evaluate(const bench *b, const int bias[METHODS_MOST], const receiver *r, int count,
                    float *value)
{
    evaluation e = {b, bias, r, count, value};
    parallel_for((count + SHARE - 1) / SHARE, evaluate_some, &e, NULL);
}

// The processor's time, which other programs on the machine disturb less than the clock on the
// wall.
double cpu_seconds(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

enum { TIMED_MOST = 20000 };

// Asks for n receivers from number first on, round and round, and returns the seconds.
static double time_method(const bench *b, int which, int bias, const receiver *r, int count,
                          int first, int n)
{
    static float value[TIMED_MOST];
    const double start = cpu_seconds();
    ask(b, which, bias, r, count, first, n, value);
    return cpu_seconds() - start;
}

void bench_time(const bench *b, const int bias[METHODS_MOST], const receiver *r, int count,
                int rounds, spread ns[METHODS_MOST])
{
    static double times[METHODS_MOST][ROUNDS_MOST];
    for (int round = -1; round < rounds; round++) {
        for (int i = 0; i < method_count; i++) {
            // The first round tells how many receivers take a millisecond; all methods get the same
            // ones, but for those that are so slow that a part of them must do.
            const int n = round < 0 ? 64 : (int)fmin(fmax(1e6 / ns[i].value, 64), TIMED_MOST);
            const int first = round < 0 ? 0 : round * count / rounds;
            const double t = 1e9 * time_method(b, i, bias[i], r, count, first, n) / n;
            if (round < 0)
                ns[i].value = fmax(t, 1);
            else
                times[i][round] = t;
        }
    }
    for (int i = 0; i < method_count; i++) ns[i] = spread_of(times[i], rounds);
}
