// mssm.h behind the interface of the suite. The bodies of the headers are compiled here, so that
// the way from a table's values to the bounds, which is private, can be measured on its own.
#define MSSM_IMPLEMENTATION
#define MSSM_NO_GL
#define LIGHTPROBE_IMPLEMENTATION
#define LIGHTPROBE_NO_GL
#include "../../mssm.h"
#include "../../lightprobe.h"

#include "methods.h"

#include <string.h>

static mssm_moments4 four(const float b[6])
{
    mssm_moments4 m;
    memcpy(m.b, b, sizeof m.b);
    return m;
}

static mssm_moments6 six(const float b[6])
{
    mssm_moments6 m;
    memcpy(m.b, b, sizeof m.b);
    return m;
}

answer run_bounds(int m, const float b[6], const float t[6], float alpha, float z)
{
    (void)t;
    (void)alpha;
    const mssm_bounds v = m == 4 ? mssm_visibility4(four(b), z) : mssm_visibility6(six(b), z);
    const answer a = {v.lower, v.upper,
                      m == 4 ? mssm_blocker_depth4(four(b), z, 1e-3f, 1e-3f)
                             : mssm_blocker_depth6(six(b), z, 1e-3f, 1e-3f)};
    return a;
}

// Bounds and blocker depth from the depths and shares themselves.
answer run_points(int m, const float b[6], const float t[6], float alpha, float z)
{
    (void)t;
    (void)alpha;
    float depth[4], share[4];
    if (m == 4) {
        const mssm_points3 p = mssm_reconstruct4(four(b), z);
        memcpy(depth, p.z, sizeof p.z);
        memcpy(share, p.w, sizeof p.w);
    } else {
        const mssm_points4 p = mssm_reconstruct6(six(b), z);
        memcpy(depth, p.z, sizeof p.z);
        memcpy(share, p.w, sizeof p.w);
    }
    float nearer = 0, first = 0;
    for (int i = 1; i <= m / 2; i++) {
        if (depth[i] >= z) continue;
        nearer += share[i];
        first += share[i] * depth[i];
    }
    const answer a = {1 - nearer - share[0], 1 - nearer,
                      (first + 1e-3f * in_map(z)) / (nearer + 1e-3f)};
    return a;
}

answer run_stored(int m, const float b[6], const float t[6], float alpha, float z)
{
    (void)b;
    struct mssm_split s;
    if (m == 4)
        s = mssm_split4(mssm_make_kernel4(mssm_factorise_stored4(four(t), alpha), z));
    else
        s = mssm_split6(mssm_make_kernel6(mssm_factorise_stored6(six(t), alpha), z));
    const mssm_bounds v = mssm_split_bounds(s);
    const answer a = {v.lower, v.upper, mssm_split_depth(s, z, 1e-3f, 1e-3f)};
    return a;
}

void table_values(const mssm_map *map, float t[6])
{
    const float half = 0.5f * (float)map->side;
    const mssm_moments6 m = mssm_query(map, map->moments, half, half, half, half);
    memcpy(t, m.b, sizeof m.b);
}
