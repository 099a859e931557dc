// Prints a compute shader that holds the GLSL text of both headers, for a second compiler to judge
// (tests/compile.sh).
#define MSSM_IMPLEMENTATION
#include "mssm.h"
#define LIGHTPROBE_IMPLEMENTATION
#include "lightprobe.h"

#include <stdio.h>

int main(void)
{
    printf("#version 450 core\n%s%s%s", mssm_glsl_math(), lightprobe_glsl_math(),
           lightprobe_glsl_lights());
    printf("layout(local_size_x = 1) in;\nvoid main() {}\n");
    return 0;
}
