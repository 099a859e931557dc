// The loops over families, formats, biases, methods and receivers, and the judgement of each reply.
#include "measure.h"

#include "../../examples/common/threads.h"
#include "../support/oracle_moments.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Rounding may pass 0 and 1 and cross equal bounds by this much without being counted, unless the
// method promises otherwise.
static float tolerance_of(int method)
{
    return methods[method].exact ? 0 : 1e-5f;
}

const char *const family_keys[FAMILY_COUNT] = {"flat",      "exact",    "slope",   "two",
                                               "close",     "edge",     "three",   "foliage",
                                               "continuum", "near-far", "outlier", "bimodal"};

int applies(int method, int format)
{
    return !methods[method].stored_only || format == FORMAT_TABLE;
}

static int chosen(int wanted, int value)
{
    return wanted < 0 || wanted == value;
}

float plan_alpha(const plan *p, int bias, int method, int m, int format)
{
    if (p->bias[bias] >= 0) return p->bias[bias];
    if (methods[method].stored_only) return m == 4 ? MSSM_BIAS4_TABLE : MSSM_BIAS6_TABLE;
    return safe_bias(m, format, methods[method].vector);
}

static line *line_at(const results *r, int method, int m, int format, int bias, int family)
{
    const int row = (method * 2 + (m == 6)) * FORMATS + format;
    return r->lines + (row * r->p.biases + bias) * FAMILY_COUNT + family;
}

static int is_finite(float x)
{
    return x - x == 0;
}

static double clamped(float x, double low, double high)
{
    return !is_finite(x) ? high : (double)x < low ? low : (double)x > high ? high : (double)x;
}

// The table's own values are biased here as mssm.h does inside, with the vector for stored moments.
static orthogonal orthogonal_of_query(const query *q)
{
    quad b[7] = {1, 0, 0, 0, 0, 0, 0};
    if (!methods[q->method].stored_only) {
        for (int k = 0; k < q->m; k++) b[k + 1] = (quad)q->b[k];
        return orthogonal_of_moments(q->m, b);
    }
    const quad even[2][3] = {{1.120L, 2.884L, 0}, {0.657L, 0.734L, 1.197L}};
    const quad *star = even[q->m == 6], a = (quad)q->alpha;
    quad t[6];
    for (int k = 0; k < 6; k++) t[k] = (quad)q->t[k];
    b[1] = t[0];
    b[2] = (1 + t[1]) / 2;
    b[3] = (3 * t[0] + t[2]) / 4;
    b[4] = (3 + 4 * t[1] + t[3]) / 8;
    b[5] = (10 * t[0] + 5 * t[2] + t[4]) / 16;
    b[6] = (10 + 15 * t[1] + 6 * t[3] + t[5]) / 32;
    for (int k = 1; k <= 6; k++) b[k] = (1 - a) * b[k] + (k % 2 ? 0 : a * star[k / 2 - 1]);
    return orthogonal_of_moments(q->m, b);
}

typedef struct exact {
    int valid;
    double lower, upper, nearer, depth;
} exact;

static exact exact_of(const query *q)
{
    exact e = {0, 0, 0, 0, 0};
    const orthogonal o = orthogonal_of_query(q);
    e.valid = o.rank == o.n + 1;
    if (!e.valid) return e;
    const sharp_bounds s = oracle_bounds(&o, (quad)q->z);
    e.lower = (double)s.lower;
    e.upper = (double)s.upper;
    e.nearer = (double)s.nearer;
    // The receiver takes part with its depth in the map's range.
    const double z = q->z > 1 ? 1 : q->z < -1 ? -1 : (double)q->z;
    const quad depth = oracle_blocker_depth(&s, (quad)z, 1e-3L, 1e-3L);
    e.depth = (double)depth < -1 ? -1 : (double)depth > z ? z : (double)depth;
    return e;
}

// A blocker depth counts by the share that it stands for: where hardly anything is nearer it has no
// consequence. What is not finite is as wrong as can be.
static judgement judge_against(const exact *e, const query *q, const answer *a)
{
    judgement j = {e->valid, 1, 1, e->lower, e->upper, e->depth};
    if (!e->valid) return j;
    const double low = fabs(clamped(a->lower, 0, 1) - e->lower);
    const double high = fabs(clamped(a->upper, 0, 1) - e->upper);
    if (is_finite(a->lower) && is_finite(a->upper)) j.error = low > high ? low : high;
    const double z = clamped(q->z, -1, 1);
    if (is_finite(a->blocker)) {
        j.blocker = fabs(clamped(a->blocker, -1, z) - e->depth) * (e->nearer + 1e-3);
    }
    return j;
}

judgement judge(const query *q, const answer *a)
{
    const exact e = exact_of(q);
    return judge_against(&e, q, a);
}

static int finite_answer(const answer *a)
{
    return is_finite(a->lower) && is_finite(a->upper) && is_finite(a->blocker);
}

static int out_of_range(const answer *a, int method)
{
    const float low = -tolerance_of(method), high = 1 - low;
    return finite_answer(a) &&
           (a->lower < low || a->upper > high || a->upper < low || a->lower > high);
}

static int crossed(const answer *a, int method)
{
    return finite_answer(a) && a->lower > a->upper + tolerance_of(method);
}

int failed(const answer *a, int method)
{
    return !finite_answer(a) || out_of_range(a, method) || crossed(a, method);
}

static void keep(line *l, const query *q, const answer *a, const exact *e, double nearer,
                 double self)
{
    l->not_finite += !finite_answer(a);
    l->out_of_range += out_of_range(a, q->method);
    l->crossed += crossed(a, q->method);
    l->unrepaired += !e->valid;
    if (failed(a, q->method) && !l->first_failure.m) l->first_failure = *q;
    const int bounds = is_finite(a->lower) && is_finite(a->upper);
    const double dark = bounds ? 1 - nearer - clamped(a->upper, 0, 1) : 1;
    const double leak = bounds ? clamped(a->lower, 0, 1) - (1 - nearer - self) : 1;
    if (bounds && dark > (double)l->dark) l->dark = (float)dark;
    if (bounds && leak > (double)l->leak) l->leak = (float)leak;
    const double wrong = dark > leak ? dark : leak;
    l->wrong[l->samples++] = (float)(wrong > 0 ? wrong : 0);
    if (!e->valid) return;
    const judgement j = judge_against(e, q, a);
    if ((float)j.error > l->worst_error) {
        l->worst_error = (float)j.error;
        l->worst = *q;
    }
    l->error[l->errors] = (float)j.error;
    l->blocker[l->errors++] = (float)j.blocker;
}

// All methods that use this bias vector, on one receiver.
static void run_receiver(results *r, query q, int bias, int vector, double nearer, double self)
{
    exact e = {0, 0, 0, 0, 0};
    for (int i = 0, known = 0; i < METHODS; i++) {
        if (!chosen(r->p.method, i) || methods[i].vector != vector || !applies(i, q.format)) {
            continue;
        }
        const int same = known && !methods[i].stored_only;
        q.method = i;
        q.alpha = plan_alpha(&r->p, bias, i, q.m, q.format);
        if (!same) e = exact_of(&q);
        known = !methods[i].stored_only;
        const answer a = methods[i].run(q.m, q.b, q.t, q.alpha, q.z);
        keep(line_at(r, i, q.m, q.format, bias, q.family), &q, &a, &e, nearer, self);
    }
}

static void run_format(results *r, const patch *p, int family, int format)
{
    const stored s = patch_store(p, format);
    query q;
    memset(&q, 0, sizeof q);
    q.family = family;
    q.format = format;
    memcpy(q.t, s.t, sizeof q.t);
    for (int i = 0; i < r->p.biases * VECTORS * 2; i++) {
        const int bias = i % r->p.biases, vector = i / r->p.biases % VECTORS;
        q.m = i / r->p.biases / VECTORS ? 6 : 4;
        if (!chosen(r->p.m, q.m)) continue;
        const int user = vector == VECTOR_CUSTOMARY ? METHOD_PUBLISHED : METHOD_BOUNDS;
        const float alpha = plan_alpha(&r->p, bias, user, q.m, format);
        bias_moments(q.m, format, vector, alpha, s.b, q.b);
        for (int k = 0; k < RECEIVERS; k++) {
            int nearer = 0, self = 0;
            q.z = p->z[k];
            for (int j = 0; j < p->count; j++) {
                nearer += p->depth[j] < q.z;
                self += p->depth[j] == q.z;
            }
            run_receiver(r, q, bias, vector, (double)nearer / p->count, (double)self / p->count);
        }
    }
}

static void run_family(void *context, int family)
{
    results *r = (results *)context;
    if (!chosen(r->p.family, family)) return;
    for (int i = 0; i < r->p.patches; i++) {
        const patch p = patch_make(family, i, r->p.seed);
        for (int f = 0; f < FORMATS; f++) {
            if (chosen(r->p.format, f)) run_format(r, &p, family, f);
        }
    }
}

static int ascending(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

int results_run(results *r, const plan *p)
{
    const size_t count = (size_t)(METHODS * 2 * FORMATS * p->biases * FAMILY_COUNT);
    const size_t per = (size_t)(p->patches * RECEIVERS);
    r->p = *p;
    r->lines = (line *)calloc(count, sizeof *r->lines);
    if (!r->lines) return 0;
    for (int i = 0; i < METHODS * 2 * FORMATS * p->biases * FAMILY_COUNT; i++) {
        const int family = i % FAMILY_COUNT, row = i / FAMILY_COUNT / p->biases;
        const int format = row % FORMATS, m = row / FORMATS % 2 ? 6 : 4, method = row / FORMATS / 2;
        if (!chosen(p->family, family) || !chosen(p->format, format) || !chosen(p->m, m) ||
            !chosen(p->method, method) || !applies(method, format)) {
            continue;
        }
        line *l = r->lines + i;
        l->error = (float *)malloc(3 * per * sizeof(float));
        if (!l->error) return 0;
        l->wrong = l->error + per;
        l->blocker = l->wrong + per;
        l->worst_error = -1;
    }
    parallel_for(FAMILY_COUNT, run_family, r, "families");
    return 1;
}

void results_free(results *r)
{
    const int count = METHODS * 2 * FORMATS * r->p.biases * FAMILY_COUNT;
    for (int i = 0; r->lines && i < count; i++) free(r->lines[i].error);
    free(r->lines);
    r->lines = NULL;
}

static void percentiles(float *x, int count, double out[4])
{
    static const double share[4] = {0.5, 0.99, 0.999, 1};
    if (count == 0) { // nothing to compare: no moments were valid
        for (int i = 0; i < 4; i++) out[i] = NAN;
        return;
    }
    qsort(x, (size_t)count, sizeof *x, ascending);
    for (int i = 0; i < 4; i++) {
        const int at = (int)(share[i] * count);
        out[i] = (double)x[at < count ? at : count - 1];
    }
}

figures results_figures(results *r, int method, int m, int format, int bias, int family)
{
    figures f;
    const size_t room = (size_t)(r->p.patches * RECEIVERS * FAMILY_COUNT);
    float *all = (float *)malloc(3 * room * sizeof(float));
    int errors = 0;
    float worst = -1;
    memset(&f, 0, sizeof f);
    if (!all) abort();
    for (int i = 0; i < FAMILY_COUNT; i++) {
        if (!chosen(family, i)) continue;
        const line *l = line_at(r, method, m, format, bias, i);
        if (!l->error) continue;
        memcpy(all + errors, l->error, (size_t)l->errors * sizeof(float));
        memcpy(all + room + errors, l->blocker, (size_t)l->errors * sizeof(float));
        memcpy(all + 2 * room + f.samples, l->wrong, (size_t)l->samples * sizeof(float));
        errors += l->errors;
        f.samples += l->samples;
        f.not_finite += l->not_finite;
        f.out_of_range += l->out_of_range;
        f.crossed += l->crossed;
        f.unrepaired += l->unrepaired;
        f.dark = (double)l->dark > f.dark ? (double)l->dark : f.dark;
        f.leak = (double)l->leak > f.leak ? (double)l->leak : f.leak;
        if (l->worst_error > worst) {
            worst = l->worst_error;
            f.worst = l->worst;
        }
        if (!f.first_failure.m) f.first_failure = l->first_failure;
    }
    percentiles(all, errors, f.error);
    percentiles(all + room, errors, f.blocker);
    percentiles(all + 2 * room, f.samples, f.wrong);
    free(all);
    return f;
}
