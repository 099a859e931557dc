#include "mip_maps.h"

#include "rivals.h"

typedef int8_t bytes_of_4 __attribute__((vector_size(4)));
typedef int16_t shorts_of_4 __attribute__((vector_size(8)));

static const float byte = 127, word = 32767;

bool mip_maps_create(mip_maps *m, int side, int channels, size_t *bytes)
{
    size_t texels = 0;
    *m = (mip_maps){.channels = channels};
    for (int s = side; m->levels == 0 || m->side[m->levels - 1] > 1; s = (s + 1) / 2) {
        m->side[m->levels] = s;
        m->first[m->levels++] = texels;
        texels += (size_t)s * (size_t)s;
    }
    m->waves = malloc(texels * (size_t)channels);
    m->weighted = malloc(texels * (size_t)channels * sizeof *m->weighted);
    m->phases = malloc(texels * sizeof *m->phases);
    *bytes = texels * ((size_t)channels * 3 + 2);
    if (m->waves && m->weighted && m->phases) return true;
    mip_maps_free(m);
    return false;
}

void mip_maps_free(mip_maps *m)
{
    free(m->waves);
    free(m->weighted);
    free(m->phases);
    *m = (mip_maps){0};
}

void mip_maps_set(mip_maps *m, size_t texel, const float *waves, float phase)
{
    const size_t n = (size_t)m->channels, at = texel * n;
    for (size_t c = 0; c < n; c++) {
        m->waves[at + c] = (int8_t)lrintf(byte * waves[c]);
        m->weighted[at + c] = (int16_t)lrintf(word * waves[c] * phase);
    }
    m->phases[texel] = (int16_t)lrintf(word * phase);
}

// Rounded, or every level would be darker than the finer one.
static int mean_of_4(int a, int b, int c, int d)
{
    return (a + b + c + d + 2) >> 2;
}

// The first of the four finer texels of a coarser one, and the others: the last row and column of
// an odd side count twice.
static void finer_of(const mip_maps *m, int level, int x, int y, size_t from[4])
{
    const int side = m->side[level - 1];
    for (int i = 0; i < 4; i++) {
        const int fx = 2 * x + i % 2, fy = 2 * y + i / 2;
        from[i] = m->first[level - 1] + (size_t)(fy < side ? fy : side - 1) * (size_t)side +
                  (size_t)(fx < side ? fx : side - 1);
    }
}

void mip_maps_build(mip_maps *m)
{
    const size_t n = (size_t)m->channels;
    for (int level = 1; level < m->levels; level++) {
        const int side = m->side[level];
        for (int i = 0; i < side * side; i++) {
            const size_t to = m->first[level] + (size_t)i;
            size_t f[4];
            finer_of(m, level, i % side, i / side, f);
            const int8_t *w = m->waves;
            const int16_t *d = m->weighted, *u = m->phases;
            for (size_t c = 0; c < n; c++) {
                m->waves[to * n + c] = (int8_t)mean_of_4(w[f[0] * n + c], w[f[1] * n + c],
                                                         w[f[2] * n + c], w[f[3] * n + c]);
                m->weighted[to * n + c] = (int16_t)mean_of_4(d[f[0] * n + c], d[f[1] * n + c],
                                                             d[f[2] * n + c], d[f[3] * n + c]);
            }
            m->phases[to] = (int16_t)mean_of_4(u[f[0]], u[f[1]], u[f[2]], u[f[3]]);
        }
    }
}

// Bilinear in one level: four texels and their weights, times a share.
static void read_level(const mip_maps *m, int level, float x, float y, float share, mip_read *r,
                       int first)
{
    const int side = m->side[level];
    const float step = ldexpf(1, -level);
    const float u = limited(x * step - 0.5f, -1, (float)side);
    const float v = limited(y * step - 0.5f, -1, (float)side);
    const float low_u = floorf(u), low_v = floorf(v), part_u = u - low_u, part_v = v - low_v;
    for (int i = 0; i < 4; i++) {
        const int tx = (int)low_u + i % 2, ty = (int)low_v + i / 2;
        const bool inside = tx >= 0 && tx < side && ty >= 0 && ty < side;
        const float weight = share * (i % 2 ? part_u : 1 - part_u) * (i / 2 ? part_v : 1 - part_v);
        r->at[first + i] = m->first[level] + (inside ? (size_t)ty * (size_t)side + (size_t)tx : 0);
        r->weight[first + i] = inside ? weight : 0;
        r->outside += inside ? 0 : weight;
    }
}

mip_read mip_maps_read(const mip_maps *m, float x, float y, float level)
{
    mip_read r = {.outside = 0};
    const float last = (float)(m->levels - 1), at = limited(level, 0, last);
    const int low = (int)least(at, most(last - 1, 0)), high = low + 1 < m->levels ? low + 1 : low;
    const float part = at - (float)low;
    read_level(m, low, x, y, 1 - part, &r, 0);
    read_level(m, high, x, y, part, &r, 4);
    return r;
}

static floats load_bytes(const void *from)
{
    bytes_of_4 b;
    memcpy(&b, from, sizeof b);
    return __builtin_convertvector(b, floats);
}

static floats load_shorts(const void *from)
{
    shorts_of_4 s;
    memcpy(&s, from, sizeof s);
    return __builtin_convertvector(s, floats);
}

// Means of all channels of an image; size: bytes of a number, one: the number that stands for 1.
static inline void means_of(const mip_maps *m, const mip_read *r, const void *image, size_t size,
                            floats load_4(const void *), float one, float *mean)
{
    const size_t n = (size_t)m->channels;
    for (size_t c = 0; c < n; c += LANES) {
        floats sum = {0};
        for (int i = 0; i < 8; i++) {
            const char *at = (const char *)image + (r->at[i] * n + c) * size;
            sum += all_of(r->weight[i] / one) * load_4(at);
        }
        memcpy(mean + c, &sum, sizeof sum);
    }
}

void mip_maps_waves(const mip_maps *m, const mip_read *r, float *mean)
{
    means_of(m, r, m->waves, sizeof *m->waves, load_bytes, byte, mean);
}

void mip_maps_weighted(const mip_maps *m, const mip_read *r, float *mean)
{
    means_of(m, r, m->weighted, sizeof *m->weighted, load_shorts, word, mean);
}

float mip_maps_phase(const mip_maps *m, const mip_read *r)
{
    float sum = 0;
    for (int i = 0; i < 8; i++) sum += r->weight[i] / word * (float)m->phases[r->at[i]];
    return sum;
}
