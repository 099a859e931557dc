// One of two source files of a program: the one with the implementations (tests/compile.sh).
#define MSSM_IMPLEMENTATION
#include "mssm.h"
#define LIGHTPROBE_IMPLEMENTATION
#include "lightprobe.h"

#ifdef __cplusplus
extern "C"
#endif
    float
    visibility_in_a(float z);

float visibility_in_a(float z)
{
    return mssm_visibility4(mssm_moments4_bias(mssm_moments4_of_depth(0.5f), 1e-3f), z).upper;
}
