// Storage formats, one function each, and the bias vectors.
#include "stored.h"

#include "../support/families.h"
#include "methods.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *const format_names[FORMATS] = {"float32", "unorm16",   "filtered",
                                           "table",   "float-sat", "slides-table"};
const char *const format_titles[FORMATS] = {"float32",
                                            "16 bits, stored once",
                                            "16 bits, resolve and 2 blur passes",
                                            "32-bit integer table of mssm.h",
                                            "float32 summed-area table, 256 x 256",
                                            "uint32 table, scale 2^32/n"};

patch patch_make(int family, int number, unsigned seed)
{
    uint64_t state = UINT64_C(0x57ab1e) + (uint64_t)family * 1000003u + (uint64_t)number * 7919u +
                     (uint64_t)seed * UINT64_C(0x2545f4914f6cdd1d);
    patch p;
    const double kind = family_range(&state, 0, 1);
    p.side = kind < 0.3 ? PATCH_SIDE : 2 + (int)family_range(&state, 0, 10);
    p.count = p.side * p.side;
    family_patch(family, p.side, &state, p.depth);
    for (int r = 0; r < RECEIVERS; r++) p.z[r] = family_receiver(r, p.count, p.depth, &state);
    return p;
}

static double power(int k, double z)
{
    double r = z;
    for (int i = 1; i < k; i++) r *= z;
    return r;
}

static void decode(const double q[6], float b[6])
{
    mssm_moments6 m;
    for (int k = 0; k < 6; k++) m.b[k] = (float)q[k];
    m = mssm_moments6_decode(m);
    memcpy(b, m.b, sizeof m.b);
}

static void store_float32(const patch *p, float b[6])
{
    for (int k = 1; k <= 6; k++) {
        double sum = 0;
        for (int i = 0; i < p->count; i++) sum += power(k, (double)p->depth[i]);
        b[k - 1] = (float)(sum / p->count);
    }
}

static double unorm16(double x)
{
    return floor(x * 65535 + 0.5) / 65535;
}

// Passes: 1 rounds the mean of all texels; 3 rounds the texels, the means of rows and their mean.
static void store_unorm16(const patch *p, int passes, float b[6])
{
    double q[6];
    for (int k = 1; k <= 6; k++) {
        double sum = 0;
        for (int y = 0; y < p->side; y++) {
            double row = 0;
            for (int x = 0; x < p->side; x++) {
                const double v = 0.5 + 0.5 * family_chebyshev(k, (double)p->depth[y * p->side + x]);
                row += passes == 3 ? unorm16(v) : v;
            }
            sum += passes == 3 ? unorm16(row / p->side) : row / p->side;
        }
        q[k - 1] = unorm16(sum / p->side);
    }
    decode(q, b);
}

// Through the library itself: a map of the patch's size and a query of all of it.
static void store_table(const patch *p, stored *s)
{
    static const int bytes = 32000; // of 27^2 texels, 6 moments
    unsigned char memory[32000];
    mssm_map *map;
    if (mssm_map_init(&map, memory, (size_t)bytes, p->side, 6) ||
        mssm_map_update(map, p->depth, NULL, 1)) {
        abort(); // the arguments are constants
    }
    const mssm_moments6 m = mssm_map_moments(map, 0, 0, 1, 1);
    memcpy(s->b, m.b, sizeof s->b);
    table_values(map, s->t);
}

// The patch at the far corner of a map that holds a floor at depth .7 elsewhere. Prefix sums and
// their differences are taken in float32, as a compute shader would.
static void store_float_sat(const patch *p, float b[6])
{
    enum { SIDE = 256 };
    static const float elsewhere = 0.7f;
    const int from = SIDE - p->side;
    for (int k = 1; k <= 6; k++) {
        float above[SIDE + 1] = {0}, top_right = 0, top_left = 0;
        for (int y = 0; y < SIDE; y++) {
            float run = 0;
            for (int x = 0; x < SIDE; x++) {
                const int inside = x >= from && y >= from;
                const float z = inside ? p->depth[(y - from) * p->side + x - from] : elsewhere;
                run += (float)power(k, (double)z);
                above[x + 1] += run;
            }
            if (y != from - 1) continue;
            top_left = above[from];
            top_right = above[SIDE];
        }
        b[k - 1] = (above[SIDE] - above[from] - top_right + top_left) / (float)p->count;
    }
}

static void store_slides(const patch *p, float b[6])
{
    const float scale = (float)(4294967296.0 / (PATCH_SIDE * PATCH_SIDE));
    double q[6];
    for (int k = 1; k <= 6; k++) {
        uint32_t sum = 0;
        for (int i = 0; i < p->count; i++) {
            const double v = 0.5 + 0.5 * family_chebyshev(k, (double)p->depth[i]);
            sum += (uint32_t)(v * (double)scale + 0.5);
        }
        q[k - 1] = (double)((float)sum / (scale * (float)p->count));
    }
    decode(q, b);
}

stored patch_store(const patch *p, int format)
{
    stored s;
    memset(&s, 0, sizeof s);
    if (format == FORMAT_FLOAT32) store_float32(p, s.b);
    if (format == FORMAT_UNORM16) store_unorm16(p, 1, s.b);
    if (format == FORMAT_FILTERED) store_unorm16(p, 3, s.b);
    if (format == FORMAT_TABLE) store_table(p, &s);
    if (format == FORMAT_FLOAT_SAT) store_float_sat(p, s.b);
    if (format == FORMAT_SLIDES) store_slides(p, s.b);
    return s;
}

// What the customary vectors need by the same proof (`make bias`); for 16 bits and 4 moments the
// slides' own 6e-5, which is more.
static float customary_bias(int m, int format)
{
    switch (format) {
    case FORMAT_FLOAT32: return m == 4 ? 2.4e-6f : 2.1e-5f;
    case FORMAT_UNORM16: return m == 4 ? 6.0e-5f : 6.5e-5f;
    case FORMAT_FILTERED: return m == 4 ? 1.2e-4f : 2.0e-4f;
    default: return m == 4 ? 3.4e-6f : 1.4e-5f;
    }
}

float safe_bias(int m, int format, int vector)
{
    if (vector == VECTOR_CUSTOMARY) return customary_bias(m, format);
    switch (format) {
    case FORMAT_FLOAT32: return m == 4 ? MSSM_BIAS4_FLOAT32 : MSSM_BIAS6_FLOAT32;
    case FORMAT_UNORM16: return m == 4 ? MSSM_BIAS4_UNORM16 : MSSM_BIAS6_UNORM16;
    case FORMAT_FILTERED: return m == 4 ? MSSM_BIAS4_UNORM16_FILTERED : MSSM_BIAS6_UNORM16_FILTERED;
    default: return m == 4 ? MSSM_BIAS4_DECODED : MSSM_BIAS6_DECODED;
    }
}

// Customary: (0, .375, 0, .375) for float32 and (0, .628, 0, .628) for stored transforms with 4
// moments; (0, .5566, 0, .489, 0, .47869382) with 6.
void bias_moments(int m, int format, int vector, float alpha, const float b[6], float out[6])
{
    mssm_moments4 m4;
    mssm_moments6 m6;
    memcpy(m4.b, b, sizeof m4.b);
    memcpy(m6.b, b, sizeof m6.b);
    memset(out, 0, 6 * sizeof *out);
    if (vector == VECTOR_CUSTOMARY) {
        const float four = format == FORMAT_FLOAT32 || format == FORMAT_FLOAT_SAT ? 0.375f : 0.628f;
        const float even4[6] = {0, four, 0, four, 0, 0};
        const float even6[6] = {0, 0.5566f, 0, 0.489f, 0, 0.47869382f};
        for (int k = 0; k < m; k++) {
            out[k] = b[k] + alpha * ((m == 4 ? even4 : even6)[k] - b[k]);
        }
        return;
    }
    const int encoded = format == FORMAT_UNORM16 || format == FORMAT_FILTERED;
    m4 = encoded ? mssm_moments4_bias_encoded(m4, alpha) : mssm_moments4_bias(m4, alpha);
    m6 = encoded ? mssm_moments6_bias_encoded(m6, alpha) : mssm_moments6_bias(m6, alpha);
    memcpy(out, m == 4 ? m4.b : m6.b, (size_t)m * sizeof *out);
}
