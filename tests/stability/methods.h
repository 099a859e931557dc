// The methods that the suite compares: mssm.h's own functions, and the ways to the same bounds that
// are in circulation, each written from its description in plain float32.
#ifndef METHODS_H
#define METHODS_H

#include "../../mssm.h"
#include "stored.h"

// Bounds on visibility as the method returns them (nothing is clamped or repaired), and the mean
// depth of the blockers where the receiver's own share counts as 1e-3 (Eq. 7).
typedef struct answer {
    float lower, upper, blocker;
} answer;

typedef struct approach {
    const char *name;  // for the command line
    const char *title; // for people: what it is
    int vector;        // which bias vector goes with it
    int stored_only;   // reads the table's own values, not powers
    int ours;
    int exact; // promises bounds in [0,1] and in order without any tolerance
    // b: biased powers; t: unbiased table values; m 4 or 6.
    answer (*run)(int m, const float b[6], const float t[6], float alpha, float z);
} approach;

enum {
    METHOD_BOUNDS,
    METHOD_POINTS,
    METHOD_STORED,
    METHOD_PUBLISHED,
    METHOD_CHOLESKY,
    METHOD_INVERSE,
    METHOD_LU,
    METHOD_NEWTON,
    METHOD_CUBIC,
    METHOD_PAPER_INVERSE,
    METHOD_PAPER_LU,
    METHOD_PAPER_QR,
    METHODS
};
extern const approach methods[METHODS];
int method_named(const char *name); // -1 if there is none

answer run_bounds(int m, const float b[6], const float t[6], float alpha, float z);
answer run_points(int m, const float b[6], const float t[6], float alpha, float z);
answer run_stored(int m, const float b[6], const float t[6], float alpha, float z);
answer run_cholesky(int m, const float b[6], const float t[6], float alpha, float z);
answer run_inverse(int m, const float b[6], const float t[6], float alpha, float z);
answer run_lu(int m, const float b[6], const float t[6], float alpha, float z);
answer run_newton(int m, const float b[6], const float t[6], float alpha, float z);
answer run_cubic(int m, const float b[6], const float t[6], float alpha, float z);
answer run_paper_inverse(int m, const float b[6], const float t[6], float alpha, float z);
answer run_paper_lu(int m, const float b[6], const float t[6], float alpha, float z);
answer run_paper_qr(int m, const float b[6], const float t[6], float alpha, float z);

// The receiver's depth as it takes part in a mean of depths.
float in_map(float z);
// E[T_k] of all of a map, as the library's own estimators read it.
void table_values(const mssm_map *map, float t[6]);

#endif
