// Small vector math in float, and the one fraction of it that every example needs.
#ifndef VEC_H
#define VEC_H

#include <math.h>

typedef struct vec3 {
    float x, y, z;
} vec3;

#define VEC_PI 3.14159265358979f

static inline vec3 vec(float x, float y, float z)
{
    const vec3 v = {x, y, z};
    return v;
}

static inline vec3 vec_of(const float v[3])
{
    return vec(v[0], v[1], v[2]);
}

static inline vec3 vec_add(vec3 a, vec3 b)
{
    return vec(a.x + b.x, a.y + b.y, a.z + b.z);
}
static inline vec3 vec_sub(vec3 a, vec3 b)
{
    return vec(a.x - b.x, a.y - b.y, a.z - b.z);
}
static inline vec3 vec_mul(vec3 a, vec3 b)
{
    return vec(a.x * b.x, a.y * b.y, a.z * b.z);
}
static inline vec3 vec_scale(vec3 a, float f)
{
    return vec(a.x * f, a.y * f, a.z * f);
}
static inline vec3 vec_mad(vec3 a, vec3 b, float f)
{
    return vec_add(a, vec_scale(b, f));
}
static inline vec3 vec_mix(vec3 a, vec3 b, float t)
{
    return vec_mad(vec_scale(a, 1 - t), b, t);
}

static inline float vec_dot(vec3 a, vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline float vec_length(vec3 a)
{
    return sqrtf(vec_dot(a, a));
}

static inline vec3 vec_cross(vec3 a, vec3 b)
{
    return vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

// The zero vector stays zero.
static inline vec3 vec_unit(vec3 a)
{
    const float length = vec_length(a);
    return length > 0 ? vec_scale(a, 1 / length) : a;
}

static inline vec3 vec_min(vec3 a, vec3 b)
{
    return vec(fminf(a.x, b.x), fminf(a.y, b.y), fminf(a.z, b.z));
}

static inline vec3 vec_max(vec3 a, vec3 b)
{
    return vec(fmaxf(a.x, b.x), fmaxf(a.y, b.y), fmaxf(a.z, b.z));
}

// Rec. 709 luminance.
static inline float vec_luminance(vec3 rgb)
{
    return 0.2126f * rgb.x + 0.7152f * rgb.y + 0.0722f * rgb.z;
}

// Turns about +Y, counter-clockwise seen from above.
static inline vec3 vec_turn(vec3 v, float angle)
{
    const float c = cosf(angle), s = sinf(angle);
    return vec(c * v.x + s * v.z, v.y, c * v.z - s * v.x);
}

#endif
