// Textbook ports of the published bounds from moments, next to which the library's speed is
// measured. All return the upper bound of visibility.
#ifndef PUBLISHED_MOMENTS_H
#define PUBLISHED_MOMENTS_H

#include <math.h>

// Moment shadow mapping (Peters and Klein 2015): Cholesky factorisation of the Hankel matrix, its
// solution for (1, z, z^2), the roots of that quadratic, the share of what is nearer in closed
// form.
static inline float published4(const float b[4], float z)
{
    const float l21 = b[2] - b[0] * b[1];
    const float d1 = b[1] - b[0] * b[0];
    const float c21 = l21 / d1;
    const float d2 = (b[3] - b[1] * b[1]) - l21 * c21;
    float c0 = 1, c1 = z, c2 = z * z;
    c1 -= b[0];
    c2 -= b[1] + c21 * c1;
    c1 /= d1;
    c2 /= d2;
    c1 -= c21 * c2;
    c0 -= c1 * b[0] + c2 * b[1];
    const float p = c1 / c2, q = c0 / c2;
    const float root = sqrtf(p * p * 0.25f - q);
    const float z1 = -0.5f * p - root, z2 = -0.5f * p + root;
    if (z <= z1) return 1;
    const float other = z <= z2 ? z : z1;
    const float share =
        (other * z2 - b[0] * (other + z2) + b[1]) / ((z2 - (z <= z2 ? z1 : z)) * (z - z1));
    const float nearer = z <= z2 ? share : 1 + share;
    return 1 - (nearer < 0 ? 0 : nearer > 1 ? 1 : nearer);
}

// The real roots of c0 + c1 x + c2 x^2 + c3 x^3, all assumed real: the trigonometric closed form.
static inline void published_cubic(float c0, float c1, float c2, float c3, float x[3])
{
    const float b = c2 / (3 * c3), c = c1 / (3 * c3), d = c0 / c3;
    const float e = c - b * b, f = d - b * c, g = b * d - c * c;
    const float disc = 4 * e * g - f * f;
    const float depressed = f - 2 * b * e;
    const float angle = atan2f(sqrtf(disc), -depressed) * (1.0f / 3.0f);
    const float cosine = cosf(angle), sine = sinf(angle), size = 2 * sqrtf(-e);
    x[0] = size * cosine - b;
    x[1] = size * (-0.5f * cosine - 0.8660254f * sine) - b;
    x[2] = size * (-0.5f * cosine + 0.8660254f * sine) - b;
}

// The same for six moments: a 4x4 factorisation and the roots of the cubic ...
static inline void published6_depths(const float b[6], float z, float x[3])
{
    const float l21 = b[2] - b[0] * b[1], d1 = b[1] - b[0] * b[0], c21 = l21 / d1;
    const float d2 = (b[3] - b[1] * b[1]) - l21 * c21;
    const float l31 = b[3] - b[0] * b[2], c31 = l31 / d1;
    const float l32 = b[4] - b[1] * b[2] - l31 * c21, c32 = l32 / d2;
    const float d3 = b[5] - b[2] * b[2] - l31 * c31 - l32 * c32;
    float c0 = 1, c1 = z, c2 = z * z, c3 = z * z * z;
    c1 -= b[0];
    c2 -= b[1] + c21 * c1;
    c3 -= b[2] + c31 * c1 + c32 * c2;
    c1 /= d1;
    c2 /= d2;
    c3 /= d3;
    c2 -= c32 * c3;
    c1 -= c21 * c2 + c31 * c3;
    c0 -= b[0] * c1 + b[1] * c2 + b[2] * c3;
    published_cubic(c0, c1, c2, c3, x);
}

// ... and then the shares as solution of the 4x4 Vandermonde system by elimination (image-based
// lighting paper, 4.2: the shares are needed one by one for the blocker depth) ...
static inline float published6(const float b[6], float z)
{
    float n[4], a[4][5];
    n[0] = z;
    published6_depths(b, z, n + 1);
    for (int j = 0; j < 4; j++) {
        a[0][j] = 1;
        a[1][j] = n[j];
        a[2][j] = n[j] * n[j];
        a[3][j] = n[j] * n[j] * n[j];
    }
    a[0][4] = 1;
    a[1][4] = b[0];
    a[2][4] = b[1];
    a[3][4] = b[2];
    for (int i = 0; i < 3; i++) {
        const float inverse = 1 / a[i][i];
        for (int k = i + 1; k < 4; k++) {
            const float factor = a[k][i] * inverse;
            for (int j = i + 1; j < 5; j++) a[k][j] -= factor * a[i][j];
        }
    }
    float w[4];
    for (int i = 3; i >= 0; i--) {
        float sum = a[i][4];
        for (int j = i + 1; j < 4; j++) sum -= a[i][j] * w[j];
        w[i] = sum / a[i][i];
    }
    float nearer = 0;
    for (int j = 1; j < 4; j++) nearer += n[j] < z ? w[j] : 0;
    return 1 - (nearer < 0 ? 0 : nearer > 1 ? 1 : nearer);
}

// ... or, where only the bound is asked for (Peters et al. 2017), the moment of the polynomial
// that is 1 at the depths nearer than z and 0 at the others, interpolated by divided differences.
static inline float published6_short(const float b[6], float z)
{
    float x[3];
    published6_depths(b, z, x);
    const float f1 = x[0] < z ? 1.0f : 0.0f, f2 = x[1] < z ? 1.0f : 0.0f,
                f3 = x[2] < z ? 1.0f : 0.0f;
    const float f01 = f1 / (x[0] - z), f12 = (f2 - f1) / (x[1] - x[0]),
                f23 = (f3 - f2) / (x[2] - x[1]);
    const float f012 = (f12 - f01) / (x[1] - z), f123 = (f23 - f12) / (x[2] - x[0]);
    const float f0123 = (f123 - f012) / (x[2] - z);
    float p0 = f012 - f0123 * x[1], p1 = f0123, p2, p3;
    p2 = p1;
    p1 = p0 - p1 * x[0];
    p0 = f01 - p0 * x[0];
    p3 = p2;
    p2 = p1 - p2 * z;
    p1 = p0 - p1 * z;
    p0 = -p0 * z;
    const float nearer = p0 + p1 * b[0] + p2 * b[1] + p3 * b[2];
    return 1 - (nearer < 0 ? 0 : nearer > 1 ? 1 : nearer);
}

#endif
