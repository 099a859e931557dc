// The list of methods, in the order of the tables.
#include "methods.h"

#include <string.h>

const approach methods[METHODS] = {
    {"mssm", "mssm.h: bounds without the roots", VECTOR_OURS, 0, 1, 1, run_bounds},
    {"mssm-points", "mssm.h: full reconstruction", VECTOR_OURS, 0, 1, 0, run_points},
    {"mssm-stored", "mssm.h: as its own tables are read", VECTOR_OURS, 1, 1, 1, run_stored},
    {"cholesky", "published: Cholesky, roots, customary bias vector", VECTOR_CUSTOMARY, 0, 0, 0,
     run_cholesky},
    {"cholesky-our-vector", "Cholesky, roots, our bias vector", VECTOR_OURS, 0, 0, 0, run_cholesky},
    {"inverse", "explicit inverse of the moment matrix, our bias vector", VECTOR_OURS, 0, 0, 0,
     run_inverse},
    {"lu", "LU with pivoting of both systems, our bias vector", VECTOR_OURS, 0, 0, 0, run_lu},
    {"newton", "Cholesky, divided differences, our bias vector", VECTOR_OURS, 0, 0, 0, run_newton},
    {"cubic", "Cholesky, cubic of the paper's [8], our bias vector", VECTOR_OURS, 0, 0, 0,
     run_cubic},
    {"paper-inverse", "the same, inverse of the weights' system", VECTOR_OURS, 0, 0, 0,
     run_paper_inverse},
    {"paper-lu", "the same, LU of the weights' system", VECTOR_OURS, 0, 0, 0, run_paper_lu},
    {"paper-qr", "the same, QR of the weights' system", VECTOR_OURS, 0, 0, 0, run_paper_qr}};

int method_named(const char *name)
{
    for (int i = 0; i < METHODS; i++) {
        if (!strcmp(methods[i].name, name)) return i;
    }
    return -1;
}

float in_map(float z)
{
    return z < -1 ? -1 : z > 1 ? 1 : z;
}
