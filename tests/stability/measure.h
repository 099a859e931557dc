// Runs methods over families, formats and biases and keeps what the page needs: failures, distance
// to the truth, and errors against the oracle in quad precision.
#ifndef MEASURE_H
#define MEASURE_H

#include "../support/families.h"
#include "methods.h"
#include "stored.h"

enum { MAX_BIASES = 16 };

// What to run; -1 means all of them.
extern const char *const family_keys[FAMILY_COUNT]; // for the command line

typedef struct plan {
    int patches; // per family
    int method, m, format, family;
    int biases;
    float bias[MAX_BIASES]; // negative: the safe strength of the format
    unsigned seed;          // 0 on the page
} plan;

// One query: enough to run it again.
typedef struct query {
    int method, m, format, family;
    float alpha, z, b[6], t[6];
} query;

// One method on one family, format and bias.
typedef struct line {
    int samples, not_finite, out_of_range, crossed, unrepaired;
    float dark, leak;               // largest distance of a bound to the wrong side of the truth
    int errors;                     // how many of the arrays below are set
    float *error, *wrong, *blocker; // `wrong` is max(dark, leak) and has `samples` values
    float worst_error;
    query worst;
    query first_failure; // m is 0 where there was none
} line;

typedef struct results {
    plan p;
    int sorted;
    line *lines;
} results;

// Percentiles over one family, or over all of them.
typedef struct figures {
    int samples, not_finite, out_of_range, crossed, unrepaired;
    double dark, leak;
    double error[4], wrong[4], blocker[4]; // 50, 99, 99.9% and the largest
    query worst, first_failure;
} figures;

int results_run(results *r, const plan *p); // 0 when memory runs out
void results_free(results *r);
figures results_figures(results *r, int method, int m, int format, int bias, int family);
// The bias that the method gets: the safe one is that of what it reads.
float plan_alpha(const plan *p, int bias, int method, int m, int format);
// Whether the method reads that format.
int applies(int method, int format);

// How far a reply is from the sharp bounds of the (valid) moments it was given.
typedef struct judgement {
    int valid; // the moments are those of some distribution
    double error, blocker;
    double lower, upper, depth; // what the oracle says
} judgement;
judgement judge(const query *q, const answer *a);
// Not finite, out of [0,1] or crossed.
int failed(const answer *a, int method);

#endif
