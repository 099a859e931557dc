// lightprobe.h by itself, as the first include, in C and in C++ (tests/compile.sh).
#define LIGHTPROBE_IMPLEMENTATION
#include "lightprobe.h"

int main(void)
{
    const float half_sphere = lightprobe_disc_irradiance(0.0f, 1.0f);
    const char *glsl = lightprobe_glsl_math();
    return !(half_sphere > 0.49f && half_sphere < 0.51f && glsl[0]);
}
