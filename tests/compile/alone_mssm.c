// mssm.h by itself, as the first include, in C and in C++ (tests/compile.sh).
#define MSSM_IMPLEMENTATION
#include "mssm.h"

int main(void)
{
    const mssm_moments4 m = mssm_moments4_bias(mssm_moments4_of_depth(0.5f), 1e-3f);
    const mssm_bounds lit = mssm_visibility4(m, -0.5f);
    const char *glsl = mssm_glsl_math();
    return !(lit.upper > 0.99f && lit.lower <= lit.upper && glsl[0]);
}
