#include "families.h"

#include <math.h>

const char *const family_names[FAMILY_COUNT] = {
    "flat",  "exactly -1, 0, 1", "slope",     "two depths", "close pair", "edge and slopes",
    "three", "foliage",          "continuum", "near/far",   "outlier",    "bimodal noise"};

uint64_t family_random(uint64_t *state)
{
    uint64_t x = (*state += UINT64_C(0x9e3779b97f4a7c15));
    x = (x ^ (x >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94d049bb133111eb);
    return x ^ (x >> 31);
}

double family_range(uint64_t *state, double low, double high)
{
    return low + (high - low) * (double)(family_random(state) >> 11) * (1.0 / 9007199254740992.0);
}

// Every order of magnitude equally often.
static double log_range(uint64_t *state, double low, double high)
{
    return exp(family_range(state, log(low), log(high)));
}

static int below(uint64_t *state, int n)
{
    return (int)(family_random(state) % (uint64_t)n);
}

static float depth_of(double z)
{
    return (float)(z < -1 ? -1 : z > 1 ? 1 : z);
}

// A plane through depth z at the patch's centre, as a value at the texel.
typedef struct plane {
    double z, x, y;
} plane;

static plane random_plane(uint64_t *state)
{
    const double steep = log_range(state, 1e-4, 1), angle = family_range(state, 0, 6.2831853);
    const plane p = {family_range(state, -1, 1), steep * cos(angle), steep * sin(angle)};
    return p;
}

static double plane_at(plane p, double x, double y)
{
    return p.z + p.x * x + p.y * y;
}

// One of `layers` depths per texel; the layers' shares are uneven, down to nothing.
static void scattered(int layers, const float *layer, int count, uint64_t *state, float *depth)
{
    double share[16], total = 0;
    for (int i = 0; i < layers; i++) {
        share[i] = below(state, 2) ? family_range(state, 0.1, 1) : log_range(state, 1e-3, 1);
        total += share[i];
    }
    for (int k = 0; k < count; k++) {
        double left = family_range(state, 0, total);
        int i = 0;
        while (i < layers - 1 && left >= share[i]) left -= share[i++];
        depth[k] = layer[i];
    }
}

// Two half planes that meet in a line through the patch, a surface on each side.
static void edge(int side, plane a, plane b, uint64_t *state, float *depth)
{
    const double angle = family_range(state, 0, 6.2831853), offset = family_range(state, -0.4, 0.4);
    for (int k = 0; k < side * side; k++) {
        const double x = (k % side + 0.5) / side - 0.5, y = (k / side + 0.5) / side - 0.5;
        const int first = x * cos(angle) + y * sin(angle) < offset;
        depth[k] = depth_of(plane_at(first ? a : b, x, y));
    }
}

// One or two planes, with an edge between them.
static void surfaces(int family, int side, uint64_t *state, float *depth)
{
    plane a = {family_range(state, -1, 1), 0, 0}, b = a;
    if (family == FAMILY_EXACT) a.z = below(state, 3) - 1;
    if (family == FAMILY_SLOPE || family == FAMILY_EDGE) a = random_plane(state);
    if (family == FAMILY_TWO) b.z = family_range(state, -1, 1);
    if (family == FAMILY_CLOSE) b.z = a.z + log_range(state, 1e-7, 1e-2);
    const int two = family == FAMILY_TWO || family == FAMILY_CLOSE;
    if (family == FAMILY_EDGE) b = random_plane(state);
    edge(side, a, two || family == FAMILY_EDGE ? b : a, state, depth);
    if (family == FAMILY_OUTLIER) {
        depth[below(state, side * side)] = depth_of(family_range(state, -1, 1));
    }
}

// Depths without order in the patch.
static void layers(int family, int count, uint64_t *state, float *depth)
{
    float layer[16];
    for (int i = 0; i < 16; i++) layer[i] = depth_of(family_range(state, -1, 1));
    if (family == FAMILY_CLOSE) {
        layer[1] = depth_of((double)layer[0] + log_range(state, 1e-7, 1e-2));
    }
    if (family == FAMILY_NEAR_FAR) {
        layer[0] = depth_of(-1 + (below(state, 2) ? 0 : log_range(state, 1e-6, 1e-1)));
        layer[1] = depth_of(1 - (below(state, 2) ? 0 : log_range(state, 1e-6, 1e-1)));
    }
    const int many = 4 + below(state, 13);
    scattered(family == FAMILY_FOLIAGE ? many
              : family == FAMILY_THREE ? 3
                                       : 2,
              layer, count, state, depth);
    if (family == FAMILY_BIMODAL) {
        const double noise = log_range(state, 1e-5, 1e-1);
        for (int k = 0; k < count; k++) {
            depth[k] = depth_of((double)depth[k] + family_range(state, -noise, noise));
        }
    }
    if (family == FAMILY_CONTINUUM) {
        const double low = family_range(state, -1, 1), high = family_range(state, low, 1);
        for (int k = 0; k < count; k++) depth[k] = depth_of(family_range(state, low, high));
    }
}

void family_patch(int family, int side, uint64_t *state, float *depth)
{
    switch (family) {
    case FAMILY_FLAT:
    case FAMILY_EXACT:
    case FAMILY_SLOPE:
    case FAMILY_EDGE:
    case FAMILY_OUTLIER: surfaces(family, side, state, depth); break;
    case FAMILY_TWO:
    case FAMILY_CLOSE:
        if (below(state, 2)) {
            surfaces(family, side, state, depth);
            break;
        }
        layers(family, side * side, state, depth);
        break;
    default: layers(family, side * side, state, depth); break;
    }
}

float family_receiver(int kind, int count, const float *depth, uint64_t *state)
{
    const float z = depth[below(state, count)];
    const double sign = below(state, 2) ? 1 : -1;
    double low = 2, high = -2;
    for (int i = 0; i < count; i++) {
        low = (double)depth[i] < low ? (double)depth[i] : low;
        high = (double)depth[i] > high ? (double)depth[i] : high;
    }
    switch (kind) {
    case RECEIVER_ON_DEPTH: return z;
    case RECEIVER_NEAR: return (float)((double)z + sign * log_range(state, 1e-7, 3e-2));
    case RECEIVER_HULL:
        return (float)(sign > 0 ? high + log_range(state, 1e-7, 1e-2)
                                : low - log_range(state, 1e-7, 1e-2));
    case RECEIVER_FAR:
        return (float)(sign > 0 ? family_range(state, high, 1.5) : family_range(state, -1.5, low));
    default: return (float)family_range(state, -1, 1);
    }
}

double family_chebyshev(int k, double z)
{
    double before = 1, now = z;
    for (int i = 1; i < k; i++) {
        const double next = 2 * z * now - before;
        before = now;
        now = next;
    }
    return now;
}
