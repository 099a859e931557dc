// Weights and samples that methods share, see methods.h.
#include "methods.h"

#include <math.h>
#include <stdint.h>

void gaussian(int radius, float weight[TAPS_MOST])
{
    double w[TAPS_MOST], sum = 0;
    for (int i = -radius; i <= radius; i++) {
        w[i + radius] = radius ? exp(-2.0 * i * i / ((double)radius * radius)) : 1;
        sum += w[i + radius];
    }
    for (int i = 0; i <= 2 * radius; i++) weight[i] = (float)(w[i] / sum);
}

static float random_unit(uint64_t *s)
{
    *s = *s * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (float)(*s >> 40) * (1.0f / 16777216.0f);
}

static float around(float d)
{
    d = fabsf(d);
    return fminf(d, 1 - d);
}

// A point of the square [-1,1]^2 as ring and place on it.
static ring_sample on_ring(float u, float v)
{
    const float ring = fmaxf(fabsf(u), fabsf(v));
    const float a = u / fmaxf(ring, 1e-9f), b = v / fmaxf(ring, 1e-9f);
    float at = a >= 1 ? b : b >= 1 ? 2 - a : a <= -1 ? 4 - b : 6 + a;
    if (at < 0) at += 8;
    const ring_sample s = {ring, at};
    return s;
}

// Poisson-disc samples of the square by best candidates (Mitchell 1991): of many random points the
// one farthest from all points so far, distances taken around the square's edges, so that the
// edges get their share and no more.
void poisson_pattern(int samples, ring_sample *to)
{
    float u[SAMPLES_MAX], v[SAMPLES_MAX];
    uint64_t random = 20260101;
    for (int i = 0; i < samples; i++) {
        float best = -1;
        for (int n = 0; n < 40 * (i + 1); n++) {
            const float a = random_unit(&random), b = random_unit(&random);
            float nearest = 9;
            for (int j = 0; j < i; j++) {
                const float du = around(a - u[j]), dv = around(b - v[j]);
                nearest = fminf(nearest, du * du + dv * dv);
            }
            if (nearest <= best) continue;
            best = nearest;
            u[i] = a;
            v[i] = b;
        }
        to[i] = on_ring(2 * u[i] - 1, 2 * v[i] - 1);
    }
}
