// Prints a compute shader that holds the GLSL text of both headers, for a second compiler to judge
// (tests/compile.sh); with an argument, a fragment shader of translucent casters.
#define MSSM_IMPLEMENTATION
#include "mssm.h"
#define LIGHTPROBE_IMPLEMENTATION
#include "lightprobe.h"

#include <stdio.h>

int main(int argc, char **argv)
{
    (void)argv;
    if (argc > 1) {
        printf("#version 450 core\n%s%s", mssm_glsl_math(), mssm_glsl_translucent());
        printf("void main() { mssm_translucent(gl_FragCoord.z, 0.5); }\n");
        return 0;
    }
    printf("#version 450 core\n%s%s%s%s%s", mssm_glsl_math(), mssm_glsl_scattering(),
           lightprobe_glsl_math(), lightprobe_glsl_lights(), lightprobe_glsl_specular());
    printf("layout(local_size_x = 1) in;\nvoid main() {}\n");
    return 0;
}
