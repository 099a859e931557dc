// Moments to bounds, shares, blockers and roots: total on any floats, and for moments of a real
// distribution the bounds enclose its visibility.
//     make fuzz FUZZ=moments
#include "fuzz.h"

#define MSSM_IMPLEMENTATION
#define MSSM_NO_GL
#include "../../mssm.h"

static int finite_all(const float *x, int count)
{
    for (int i = 0; i < count; i++) {
        if (!isfinite(x[i])) return 0;
    }
    return 1;
}

static void check_bounds(mssm_bounds b, const char *what)
{
    EXPECT(b.lower >= 0 && b.lower <= b.upper && b.upper <= 1, "%s: %a %a", what, (double)b.lower,
           (double)b.upper);
}

// z[0] is the receiver's depth; the others ascend; shares are none below zero and sum to 1.
static void check_points(const float *z, const float *w, int count, float at)
{
    float sum = 0;
    EXPECT(finite_all(z, count) && finite_all(w, count), "%a %a", (double)z[1], (double)w[1]);
    for (int i = 0; i < count; i++) {
        EXPECT(w[i] >= 0 && w[i] <= 1.000001f, "share %d is %a", i, (double)w[i]);
        EXPECT(i < 2 || z[i - 1] <= z[i], "depths %a %a", (double)z[i - 1], (double)z[i]);
        sum += w[i];
    }
    EXPECT(fabsf(sum - 1) < 1e-5f, "shares sum to %a", (double)sum);
    if (fabsf(at) <= 1) EXPECT(fabsf(z[0] - at) < 1e-5f, "%a for %a", (double)z[0], (double)at);
}

static void check_blocker(float depth, float z)
{
    const float most = z < 1 ? (z > -1 ? z : -1) : 1; // NaN counts as 1
    EXPECT(depth >= -1 && depth <= most, "blocker at %a, receiver at %a", (double)depth, (double)z);
}

static void check_four(mssm_moments4 m, float z, float self_min, float self_max)
{
    const mssm_bounds one = mssm_visibility4(m, z);
    const float *rows[4] = {m.b, m.b + 1, m.b + 2, m.b + 3};
    float lower = -1, upper = -1;
    check_bounds(one, "four");
    mssm_visibility4_array(1, rows, &z, &lower, &upper);
    check_bounds((mssm_bounds){lower, upper}, "array of four");
    EXPECT(fabsf(lower - one.lower) + fabsf(upper - one.upper) < 1e-3f || !(fabsf(z) <= 1),
           "%a, alone %a", (double)upper, (double)one.upper);
    const mssm_points3 p = mssm_reconstruct4(m, z);
    check_points(p.z, p.w, 3, z);
    check_blocker(mssm_blocker_depth4(m, z, self_min, self_max), z);
    const mssm_moments4 q = mssm_moments4_encode(m);
    for (int k = 0; k < 4; k++) EXPECT(q.b[k] >= 0 && q.b[k] <= 1, "encoded %a", (double)q.b[k]);
    EXPECT(finite_all(mssm_moments4_decode(m).b, 4), "decoded");
}

static void check_six(mssm_moments6 m, float z, float self_min, float self_max)
{
    const mssm_bounds one = mssm_visibility6(m, z);
    const float *rows[6] = {m.b, m.b + 1, m.b + 2, m.b + 3, m.b + 4, m.b + 5};
    float lower = -1, upper = -1;
    check_bounds(one, "six");
    mssm_visibility6_array(1, rows, &z, &lower, &upper);
    check_bounds((mssm_bounds){lower, upper}, "array of six");
    const mssm_points4 p = mssm_reconstruct6(m, z);
    check_points(p.z, p.w, 4, z);
    check_blocker(mssm_blocker_depth6(m, z, self_min, self_max), z);
    const mssm_moments6 q = mssm_moments6_encode(m);
    for (int k = 0; k < 6; k++) EXPECT(q.b[k] >= 0 && q.b[k] <= 1, "encoded %a", (double)q.b[k]);
    EXPECT(finite_all(mssm_moments6_decode(m).b, 6), "decoded");
}

static void check_garbage(fuzz_input *in)
{
    mssm_moments4 four;
    mssm_moments6 six;
    for (int k = 0; k < 6; k++) six.b[k] = fuzz_float(in);
    for (int k = 0; k < 4; k++) four.b[k] = six.b[k];
    const float z = fuzz_float(in), low = fuzz_float(in), high = fuzz_float(in),
                alpha = fuzz_float(in);
    check_four(four, z, low, high);
    check_six(six, z, low, high);
    check_four(mssm_moments4_bias(four, alpha), z, 1e-3f, 1e-3f);
    check_six(mssm_moments6_bias(six, alpha), z, 1e-3f, 1);
    check_four(mssm_moments4_bias_encoded(mssm_moments4_decode(four), alpha), z, 1e-3f, 1);
    check_six(mssm_moments6_bias_encoded(mssm_moments6_decode(six), alpha), z, 1e-3f, 1e-3f);
}

// Up to eight depths with shares, in double; the receiver often at one of them.
static void check_distribution(fuzz_input *in)
{
    double depth[8], share[8], sum = 0, b[6] = {0};
    const int count = fuzz_int(in, 1, 8);
    for (int i = 0; i < count; i++) {
        const float near_by = ldexpf(fuzz_unit(in), -fuzz_int(in, 0, 25));
        const float d = i > 0 && fuzz_byte(in) & 1 ? (float)depth[i - 1] + near_by : near_by;
        depth[i] = (double)(d < 1 ? (d > -1 ? d : -1) : 1);
        share[i] = ldexp(1 + fuzz_int(in, 0, 255), -fuzz_int(in, 0, 25));
        sum += share[i];
    }
    for (int i = 0; i < count; i++) {
        double power = share[i] /= sum;
        for (int k = 0; k < 6; k++) b[k] += power *= depth[i];
    }
    const int chosen = fuzz_int(in, 0, 2 * count);
    float z = chosen < count ? (float)depth[chosen] : fuzz_unit(in);
    if (chosen & 1) z += ldexpf(fuzz_unit(in), -fuzz_int(in, 0, 25));
    double lit = 1, at = 0; // what is not nearer, and what of it is at z itself
    for (int i = 0; i < count; i++) {
        lit -= depth[i] < (double)z ? share[i] : 0;
        at += depth[i] == (double)z ? share[i] : 0;
    }
    mssm_moments4 four;
    mssm_moments6 six;
    for (int k = 0; k < 4; k++) four.b[k] = (float)b[k];
    for (int k = 0; k < 6; k++) six.b[k] = (float)b[k];
    four = mssm_moments4_bias(four, MSSM_BIAS4_FLOAT32);
    six = mssm_moments6_bias(six, MSSM_BIAS6_FLOAT32);
    check_four(four, z, 1e-3f, 1e-3f);
    check_six(six, z, 1e-3f, 1);
    const mssm_bounds v4 = mssm_visibility4(four, z), v6 = mssm_visibility6(six, z);
    // False shadow and false light by at most the bias, and rounding.
    const double slack4 = (double)MSSM_BIAS4_FLOAT32 + 1e-6,
                 slack6 = (double)MSSM_BIAS6_FLOAT32 + 1e-6;
    EXPECT((double)v4.upper >= lit - slack4, "upper %.9g of four, lit %.9g", (double)v4.upper, lit);
    EXPECT((double)v6.upper >= lit - slack6, "upper %.9g of six, lit %.9g", (double)v6.upper, lit);
    EXPECT((double)v4.lower <= lit - at + slack4, "lower %.9g of four, lit %.9g", (double)v4.lower,
           lit - at);
    EXPECT((double)v6.lower <= lit - at + slack6, "lower %.9g of six, lit %.9g", (double)v6.lower,
           lit - at);
}

static void check_cubic(fuzz_input *in)
{
    float c[4];
    for (int k = 0; k < 4; k++) c[k] = fuzz_float(in);
    const mssm_roots3 r = mssm_solve_cubic(c[0], c[1], c[2], c[3]);
    EXPECT(r.count >= 0 && r.count <= 3 && finite_all(r.x, 3), "%d roots", r.count);
    for (int i = 0; i < 3; i++) {
        EXPECT(i < r.count || r.x[i] == 0, "root %d of %d is %a", i, r.count, (double)r.x[i]);
        EXPECT(i == 0 || i >= r.count || r.x[i - 1] <= r.x[i], "roots %a %a", (double)r.x[i - 1],
               (double)r.x[i]);
    }
    const float most = fmaxf(fmaxf(fabsf(c[0]), fabsf(c[1])), fabsf(c[2]));
    EXPECT(r.count >= 1 || !(fabsf(c[3]) > 1e-17f * most) || !finite_all(c, 4),
           "a cubic without a root");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_input in = {data, size};
    while (in.left > 0) {
        const unsigned what = fuzz_byte(&in) % 3;
        (what == 0 ? check_garbage : what == 1 ? check_distribution : check_cubic)(&in);
    }
    return 0;
}
