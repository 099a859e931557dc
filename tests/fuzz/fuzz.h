// What the fuzzers share: numbers made from bytes, ugly ones more often than chance would have it,
// and an expectation whose failure ends the program so that the input is kept.
#ifndef FUZZ_H
#define FUZZ_H

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

typedef struct fuzz_input {
    const uint8_t *at;
    size_t left;
} fuzz_input;

#define EXPECT(condition, ...)                                                    \
    do {                                                                          \
        if (!(condition)) fuzz_fail(__FILE__, __LINE__, #condition, __VA_ARGS__); \
    } while (0)

#if defined __GNUC__
__attribute__((format(printf, 4, 5), noreturn))
#endif
static inline void
fuzz_fail(const char *file, int line, const char *what, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    fprintf(stderr, "%s:%d: not so: %s: ", file, line, what);
    vfprintf(stderr, format, list);
    fprintf(stderr, "\n");
    va_end(list);
    abort();
}

// Zero after the end of the input.
static inline unsigned fuzz_byte(fuzz_input *in)
{
    if (in->left == 0) return 0;
    in->left--;
    return *in->at++;
}

static inline int fuzz_int(fuzz_input *in, int low, int high)
{
    const unsigned two = fuzz_byte(in) << 8;
    return low + (int)((two | fuzz_byte(in)) % (unsigned)(high - low + 1));
}

// A multiple of 2^-15 in [-1,1].
static inline float fuzz_unit(fuzz_input *in)
{
    return (float)fuzz_int(in, -32768, 32767) / 32767.5f;
}

static inline float fuzz_bits(fuzz_input *in)
{
    uint32_t bits = 0;
    float x;
    for (int i = 0; i < 4; i++) bits = bits << 8 | fuzz_byte(in);
    memcpy(&x, &bits, sizeof x);
    return x;
}

// Any float, NaN and infinity too.
static inline float fuzz_float(fuzz_input *in)
{
    static const float ugly[] = {0,         -0.0f,   1,        -1,      NAN,        INFINITY,
                                 -INFINITY, FLT_MAX, -FLT_MAX, FLT_MIN, 1e-45f,     -1e-45f,
                                 1e-7f,     1e7f,    1e18f,    1e-18f,  0.9999999f, 1.0000001f};
    const unsigned kind = fuzz_byte(in);
    if (kind < 128) return fuzz_unit(in);
    if (kind < 170) return 10 * fuzz_unit(in);
    if (kind < 212) return fuzz_bits(in);
    return ugly[kind % (sizeof ugly / sizeof *ugly)];
}

// Finite, and of a size that squares do not overflow.
static inline float fuzz_tame(fuzz_input *in, float most)
{
    return most * fuzz_unit(in);
}

static inline void *fuzz_allocate(size_t bytes)
{
    void *memory = malloc(bytes ? bytes : 1);
    if (!memory) abort();
    return memory;
}

#endif
