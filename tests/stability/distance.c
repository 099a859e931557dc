// Two depths that close up: makes the patches, asks every method, keeps percentiles.
#include "distance.h"

#include "../../examples/common/threads.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct sweep {
    int m, format, trials;
    distance_row *rows;
} sweep;

static query query_of(const sweep *s, double distance, uint64_t *state, float t[6])
{
    patch p;
    query q;
    const double z = family_range(state, -1, 1 - distance);
    const int far_texels = 1 + (int)family_range(state, 0, 63);
    p.side = 8;
    p.count = 64;
    for (int i = 0; i < p.count; i++) p.depth[i] = (float)(i < far_texels ? z + distance : z);
    const double place[5] = {0, 1, family_range(state, 0, 1), family_range(state, -1, 0),
                             family_range(state, 1, 2)};
    memset(&q, 0, sizeof q);
    q.m = s->m;
    q.format = s->format;
    q.z = (float)(z + distance * place[family_random(state) % 5]);
    const stored r = patch_store(&p, s->format);
    memcpy(t, r.b, sizeof r.b);
    memcpy(q.t, r.t, sizeof q.t);
    return q;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void run_distance(void *context, int index)
{
    const sweep *s = (const sweep *)context;
    distance_row *row = s->rows + index;
    double *errors = (double *)malloc((size_t)(s->trials * METHODS) * sizeof *errors);
    if (!errors) abort();
    memset(row, 0, sizeof *row);
    row->distance = pow(10, -7 + index * 0.25);
    uint64_t state = 4711 + (uint64_t)index;
    const plan safe = {0, -1, -1, -1, -1, 1, {-1}, 0};
    for (int i = 0; i < s->trials; i++) {
        float b[6];
        query q = query_of(s, row->distance, &state, b);
        for (int k = 0; k < METHODS; k++) {
            errors[k * s->trials + i] = 0;
            if (!applies(k, s->format)) continue;
            q.method = k;
            q.alpha = plan_alpha(&safe, 0, k, s->m, s->format);
            bias_moments(s->m, s->format, methods[k].vector, q.alpha, b, q.b);
            const answer a = methods[k].run(s->m, q.b, q.t, q.alpha, q.z);
            const judgement j = judge(&q, &a);
            row->failures[k] += failed(&a, k);
            errors[k * s->trials + i] = j.valid ? j.error : 0;
        }
    }
    for (int k = 0; k < METHODS; k++) {
        double *e = errors + k * s->trials;
        qsort(e, (size_t)s->trials, sizeof *e, ascending);
        row->error[k] = e[(int)(0.999 * s->trials)];
        row->largest[k] = e[s->trials - 1];
    }
    free(errors);
}

void distance_run(int m, int format, int trials, distance_row rows[DISTANCES])
{
    sweep s = {m, format, trials, rows};
    parallel_for(DISTANCES, run_distance, &s, "distances");
}
