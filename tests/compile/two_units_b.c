// The other source file: uses what two_units_a.c implements (tests/compile.sh).
#include "lightprobe.h"
#include "mssm.h"

#ifdef __cplusplus
extern "C"
#endif
    float
    visibility_in_a(float z);

int main(void)
{
    const mssm_moments4 m = mssm_moments4_bias(mssm_moments4_of_depth(0.5f), 1e-3f);
    const float here = mssm_visibility4(m, -0.5f).upper, there = visibility_in_a(-0.5f);
    const float half_sphere = lightprobe_disc_irradiance(0.0f, 1.0f);
    return !(here <= there && here >= there && half_sphere > 0.49f);
}
