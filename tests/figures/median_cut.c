#include "median_cut.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool median_cut_create(median_cut *m, int side)
{
    m->side = side;
    m->table = malloc(6 * MEDIAN_CUT_SUMS * (size_t)side * (size_t)side * sizeof *m->table);
    return m->table;
}

void median_cut_free(median_cut *m)
{
    free(m->table);
}

static float *entry(const median_cut *m, int face, int x, int y)
{
    return m->table +
           MEDIAN_CUT_SUMS *
               (((size_t)face * (size_t)m->side + (size_t)y) * (size_t)m->side + (size_t)x);
}

// Four sums at a time, which gcc does not do by itself at -O2.
typedef float floats __attribute__((vector_size(16)));

void median_cut_sums(median_cut *m, const lightprobe_cube *cube)
{
    const float step = 2.0f / (float)m->side;
    const size_t row = MEDIAN_CUT_SUMS * (size_t)m->side;
    for (int face = 0; face < 6; face++) {
        const float *rgb = cube->face[face];
        for (int y = 0; y < m->side; y++) {
            floats colour = {0}, moment = {0}, above[2] = {{0}, {0}};
            float *to = entry(m, face, 0, y);
            const float v = step * ((float)y + 0.5f) - 1;
            for (int x = 0; x < m->side; x++, rgb += 3, to += MEDIAN_CUT_SUMS) {
                const float u = step * ((float)x + 0.5f) - 1, r2 = 1 + u * u + v * v;
                const float w = step * step / (r2 * sqrtf(r2)); // Eq. 8
                const float r = w * rgb[0], g = w * rgb[1], b = w * rgb[2];
                const float Y = 0.2126f * r + 0.7152f * g + 0.0722f * b;
                const floats xyz = {0.4124f * r + 0.3576f * g + 0.1805f * b, Y,
                                    0.0193f * r + 0.1192f * g + 0.9505f * b, 0};
                const floats uv = {Y * u, Y * v, Y * u * u, Y * v * v};
                colour += xyz;
                moment += uv;
                if (y) memcpy(above, to - row, sizeof above);
                const floats sum[2] = {colour + above[0], moment + above[1]};
                memcpy(to, sum, sizeof sum);
            }
        }
    }
}

// Eq. 2.
static void sum_of(const median_cut *m, const light_cut *c, float sum[MEDIAN_CUT_SUMS])
{
    const int x[2] = {c->x0 - 1, c->x1 - 1}, y[2] = {c->y0 - 1, c->y1 - 1};
    memset(sum, 0, MEDIAN_CUT_SUMS * sizeof *sum);
    for (int i = 0; i < 4; i++) {
        if (x[i & 1] < 0 || y[i >> 1] < 0) continue;
        const float *e = entry(m, c->face, x[i & 1], y[i >> 1]),
                    sign = i == 0 || i == 3 ? 1.0f : -1.0f;
        for (int k = 0; k < MEDIAN_CUT_SUMS; k++) sum[k] += sign * e[k];
    }
}

static float luminance_of(const median_cut *m, const light_cut *c)
{
    float sum[MEDIAN_CUT_SUMS];
    sum_of(m, c, sum);
    return sum[1];
}

// Luminance of what lies before a cut across the longer edge.
static float part_of(const median_cut *m, const light_cut *a, bool wide, int at)
{
    light_cut part = *a;
    *(wide ? &part.x1 : &part.y1) = at;
    return luminance_of(m, &part);
}

// Where the luminance is split most evenly: by bisection in the table.
static bool split(const median_cut *m, light_cut *a, light_cut *b)
{
    const bool wide = a->x1 - a->x0 >= a->y1 - a->y0;
    const int start = wide ? a->x0 : a->y0, end = wide ? a->x1 : a->y1;
    if (end - start < 2) return false;
    const float half = 0.5f * luminance_of(m, a);
    int low = start + 1, high = end - 1;
    while (low < high) { // the first that is half or more
        const int middle = (low + high) / 2;
        if (part_of(m, a, wide, middle) < half)
            low = middle + 1;
        else
            high = middle;
    }
    if (low > start + 1 && half - part_of(m, a, wide, low - 1) <= part_of(m, a, wide, low) - half)
        low--;
    *b = *a;
    *(wide ? &a->x1 : &a->y1) = low;
    *(wide ? &b->x0 : &b->y0) = low;
    return true;
}

typedef struct region {
    light_cut cut;
    float luminance;
} region;

static int brighter(const void *a, const void *b)
{
    const float x = ((const region *)a)->luminance, y = ((const region *)b)->luminance;
    return (x < y) - (x > y);
}

// Each region once a round; in the last one the brightest.
int median_cut_cuts(const median_cut *m, int most, light_cut *cuts)
{
    region r[2 * MEDIAN_CUT_MOST];
    int count = 6;
    for (int face = 0; face < 6; face++) {
        r[face].cut = (light_cut){face, 0, 0, m->side, m->side};
        r[face].luminance = luminance_of(m, &r[face].cut);
    }
    for (int made = 1; made && count < most;) {
        const int todo = count < most - count ? count : most - count;
        made = 0;
        qsort(r, (size_t)count, sizeof *r, brighter);
        for (int i = 0; i < todo; i++) {
            region *other = &r[count + made];
            if (!split(m, &r[i].cut, &other->cut)) continue;
            r[i].luminance = luminance_of(m, &r[i].cut);
            other->luminance = luminance_of(m, &other->cut);
            made++;
        }
        count += made;
    }
    for (int i = 0; i < count; i++) cuts[i] = r[i].cut;
    return count;
}

void median_cut_lights(const median_cut *m, const light_cut *cuts, int count,
                       lightprobe_light *lights)
{
    for (int i = 0; i < count; i++) {
        float s[MEDIAN_CUT_SUMS], axis[2][3], d[3];
        lightprobe_light *l = &lights[i];
        sum_of(m, &cuts[i], s);
        memset(l, 0, sizeof *l);
        const float Y = s[1] > 0 ? s[1] : 1, u = s[4] / Y, v = s[5] / Y; // Eq. 9
        const float variance[2] = {fmaxf(s[6] / Y - u * u, 0), fmaxf(s[7] / Y - v * v, 0)};
        lightprobe_texel_direction(cuts[i].face, u, v, l->direction);
        lightprobe_texel_direction(cuts[i].face, 0, 0, d);
        // The face's axes are what the direction changes by.
        float far_u[3], far_v[3];
        lightprobe_texel_direction(cuts[i].face, 1, 0, far_u);
        lightprobe_texel_direction(cuts[i].face, 0, 1, far_v);
        for (int k = 0; k < 3; k++) {
            axis[0][k] = 1.41421356f * far_u[k] - d[k];
            axis[1][k] = 1.41421356f * far_v[k] - d[k];
        }
        const float distance = sqrtf(1 + u * u + v * v);
        for (int j = 0; j < 2; j++) {
            float *to = j ? l->axis_v : l->axis_u, along = 0, length = 0;
            for (int k = 0; k < 3; k++) along += axis[j][k] * l->direction[k];
            for (int k = 0; k < 3; k++) {
                to[k] = axis[j][k] - along * l->direction[k];
                length += to[k] * to[k];
            }
            length = sqrtf(length);
            for (int k = 0; k < 3; k++) to[k] /= length;
            *(j ? &l->tan_half_v : &l->tan_half_u) = sqrtf(3 * variance[j]) * length / distance;
        }
        l->irradiance[0] = 3.2406f * s[0] - 1.5372f * s[1] - 0.4986f * s[2];
        l->irradiance[1] = -0.9689f * s[0] + 1.8758f * s[1] + 0.0415f * s[2];
        l->irradiance[2] = 0.0557f * s[0] - 0.2040f * s[1] + 1.0570f * s[2];
        l->cos_alpha = fmaxf(1 - 4 * l->tan_half_u * l->tan_half_v / 6.2831853f, -1);
    }
}
