// Both headers with their implementations in one file, in either order (tests/compile.sh), included
// twice as large programs happen to do.
#if defined _WIN32
#include <windows.h> // defines near, far, min, max, MemoryBarrier...
#endif
#define MSSM_IMPLEMENTATION
#define LIGHTPROBE_IMPLEMENTATION
#if defined LIGHTPROBE_FIRST
#include "lightprobe.h"
#include "mssm.h"
#else
#include "mssm.h"
#include "lightprobe.h"
#endif
#include "lightprobe.h"
#include "mssm.h"

int main(void)
{
    const float half_sphere = lightprobe_disc_irradiance(0.0f, 1.0f);
    const mssm_moments6 m = mssm_moments6_bias(mssm_moments6_of_depth(0.5f), 1e-3f);
    return !(half_sphere > 0.49f && mssm_visibility6(m, -0.5f).upper > 0.99f);
}
