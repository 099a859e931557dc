// Both headers as static functions in two source files of one program; unused ones are no warnings.
#define MSSM_STATIC
#define LIGHTPROBE_STATIC
#define MSSM_IMPLEMENTATION
#include "mssm.h"
#define LIGHTPROBE_IMPLEMENTATION
#include "lightprobe.h"

#if MSSM_VERSION < 200 || LIGHTPROBE_VERSION < 200
#error the versions are not those of this test
#endif

int first_unit(void);
int second_unit(void);

#ifdef SECOND
int second_unit(void)
{
    return mssm_map_bytes(16, 6) > 0 && lightprobe_disc_irradiance(1, 1) > 0;
}
#else
int first_unit(void)
{
    return mssm_map_bytes(16, 4) > 0 && lightprobe_scratch_bytes(16, 4) > 0;
}

int main(void)
{
    return first_unit() && second_unit() ? 0 : 1;
}
#endif
