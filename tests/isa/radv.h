// Compiles shaders for AMD GPUs on a machine without one: where RADV_FORCE_FAMILY names a GPU,
// Mesa's Vulkan driver RADV makes a device on which nothing runs, but pipelines are compiled to the
// end.
#ifndef RADV_H
#define RADV_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct radv radv;

typedef struct radv_code {
    int vgprs, sgprs; // registers of a thread, and of a wave
    int spilled_vgprs,
        spilled_sgprs; // that did not fit; scratch: bytes of memory a wave has instead
    int scratch;
    int waves;      // that fit on a SIMD at once, RDNA: counted as waves of 32 threads
    int bytes;      // of code
    int latency;    // clocks of one wave alone, as ACO estimates them if each loop turns 8 times
    char *assembly; // to be freed
} radv_code;

radv *radv_open(const char *family);    // a name of RADV's; NULL where it knows none such
const char *radv_driver(const radv *r); // "Mesa 22.3.6"
void radv_close(radv *r);

// SPIR-V of a compute shader whose bindings are samplers below 16, images below 32, storage buffers
// below 48 and uniform blocks below 64.
bool radv_compile(radv *r, const uint32_t *spirv, size_t bytes, radv_code *code);

#endif
