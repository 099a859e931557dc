// The moment math alone: what four and six moments tell about a few depths.
//     cc -I. examples/moments.c -lm && ./a.out
#define MSSM_IMPLEMENTATION
#include "mssm.h"

#include <stdio.h>

int main(void)
{
    // A texel region that sees leaves at three depths and the ground behind them.
    const float depth[4] = {-0.6f, -0.5f, 0.1f, 0.9f}, share[4] = {0.1f, 0.2f, 0.3f, 0.4f};
    mssm_moments6 m6 = {{0}};
    mssm_moments4 m4;
    for (int i = 0; i < 4; i++) {
        const mssm_moments6 one = mssm_moments6_of_depth(depth[i]);
        for (int k = 0; k < 6; k++) m6.b[k] += share[i] * one.b[k];
    }
    for (int k = 0; k < 4; k++) m4.b[k] = m6.b[k]; // four moments are a prefix of six

    // Rounding leaves the set of valid moments; the bias brings them back.
    m4 = mssm_moments4_bias(m4, MSSM_BIAS4_FLOAT32);
    m6 = mssm_moments6_bias(m6, MSSM_BIAS6_FLOAT32);

    printf("receiver   visible   4 moments       6 moments\n");
    for (int i = 0; i <= 10; i++) {
        const float z = -1 + 0.2f * (float)i;
        float visible = 0;
        for (int k = 0; k < 4; k++) visible += depth[k] >= z ? share[k] : 0;
        const mssm_bounds b4 = mssm_visibility4(m4, z), b6 = mssm_visibility6(m6, z);
        printf("%8.1f %9.2f   %.3f - %.3f   %.3f - %.3f\n", (double)z, (double)visible,
               (double)b4.lower, (double)b4.upper, (double)b6.lower, (double)b6.upper);
    }
    return 0;
}
