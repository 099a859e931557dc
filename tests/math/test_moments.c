// The moment math against oracles in quad precision, on the families of depth patches where moment
// methods fail, and on garbage.
#include "../support/families.h"
#include "../support/oracle_moments.h"
#include "../support/test.h"

#include "../../mssm.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef __SSE__
#include <xmmintrin.h>
#endif

// ---- depth patches as they come out of storage ---------------------------------------------

// TABLE is the sum of 32-bit integers over a kernel, decoded: what a user's own estimator gets. The
// library's own estimators take a shorter way, see "stored" in mssm.h.
enum { FLOAT32, UNORM16, TABLE, FORMATS };
static const char *const format_names[FORMATS] = {"float32", "16-bit", "u32 table"};

// The largest errors allowed at the safe bias (DESIGN 13): 99.9% and all.
static const double limit_999[FORMATS] = {8e-3, 1e-3, 2.5e-2};
static const double limit_max[FORMATS] = {2e-2, 3e-3, 6e-2};

static float safe_alpha(int m, int format)
{
    static const float alpha[2][FORMATS] = {
        {MSSM_BIAS4_FLOAT32, MSSM_BIAS4_UNORM16, MSSM_BIAS4_DECODED},
        {MSSM_BIAS6_FLOAT32, MSSM_BIAS6_UNORM16, MSSM_BIAS6_DECODED}};
    return alpha[m == 6][format];
}

typedef struct patch {
    int family, count;
    float depth[27 * 27];
} patch;

// Six floats serve both lengths: of four moments the last two stay 0.
typedef struct moments {
    float b[6];
} moments;

static patch random_patch(int family, uint64_t *state)
{
    patch p;
    const double kind = family_range(state, 0, 1);
    const int side = kind < 0.15 ? 27 : kind < 0.5 ? 2 + (int)(kind * 60) % 9 : 3 + (int)(kind * 8);
    p.family = family;
    p.count = side * side;
    family_patch(family, side, state, p.depth);
    return p;
}

static moments decoded(int m, moments q)
{
    mssm_moments4 q4;
    mssm_moments6 q6;
    memcpy(q4.b, q.b, sizeof q4.b);
    memcpy(q6.b, q.b, sizeof q6.b);
    q4 = mssm_moments4_decode(q4);
    q6 = mssm_moments6_decode(q6);
    memset(&q, 0, sizeof q);
    if (m == 4)
        memcpy(q.b, q4.b, sizeof q4.b);
    else
        memcpy(q.b, q6.b, sizeof q6.b);
    return q;
}

// Unbiased. The sums are exact up to double precision or integers.
static moments stored(const patch *p, int m, int format)
{
    const double scale = floor(4294967295.0 / (29 * 29));
    moments r;
    memset(&r, 0, sizeof r);
    for (int k = 1; k <= m; k++) {
        double sum = 0;
        for (int i = 0; i < p->count; i++) {
            const double z = (double)p->depth[i];
            double power = z;
            for (int j = 1; j < k; j++) power *= z;
            const double q = 0.5 + 0.5 * family_chebyshev(k, z);
            sum += format == FLOAT32 ? power : format == UNORM16 ? q : floor(q * scale + 0.5);
        }
        const double mean = sum / p->count;
        if (format == FLOAT32) r.b[k - 1] = (float)mean;
        if (format == UNORM16) r.b[k - 1] = (float)(floor(mean * 65535 + 0.5) / 65535);
        if (format == TABLE) {
            r.b[k - 1] = (float)(uint32_t)sum * (1 / ((float)scale * (float)p->count));
        }
    }
    return format == FLOAT32 ? r : decoded(m, r);
}

static moments biased(int m, int format, moments r, float alpha)
{
    mssm_moments4 m4;
    mssm_moments6 m6;
    memcpy(m4.b, r.b, sizeof m4.b);
    memcpy(m6.b, r.b, sizeof m6.b);
    // Decoding rounds powers, so the vector for powers suits tables as well and keeps D3 larger.
    m4 = format == UNORM16 ? mssm_moments4_bias_encoded(m4, alpha) : mssm_moments4_bias(m4, alpha);
    m6 = format == UNORM16 ? mssm_moments6_bias_encoded(m6, alpha) : mssm_moments6_bias(m6, alpha);
    memset(&r, 0, sizeof r);
    if (m == 4)
        memcpy(r.b, m4.b, sizeof m4.b);
    else
        memcpy(r.b, m6.b, sizeof m6.b);
    return r;
}

static mssm_moments4 four(moments r)
{
    mssm_moments4 m;
    memcpy(m.b, r.b, sizeof m.b);
    return m;
}

static mssm_moments6 six(moments r)
{
    mssm_moments6 m;
    memcpy(m.b, r.b, sizeof m.b);
    return m;
}

static mssm_bounds visibility(int m, moments r, float z)
{
    return m == 4 ? mssm_visibility4(four(r), z) : mssm_visibility6(six(r), z);
}

static float blocker_depth(int m, moments r, float z, float self_min, float self_max)
{
    return m == 4 ? mssm_blocker_depth4(four(r), z, self_min, self_max)
                  : mssm_blocker_depth6(six(r), z, self_min, self_max);
}

// The canonical representation of either length as points; count 3 or 4.
typedef struct nodes {
    int count;
    float z[4], w[4];
} nodes;

static nodes reconstructed(int m, moments r, float z)
{
    nodes n;
    memset(&n, 0, sizeof n);
    n.count = m / 2 + 1;
    if (m == 4) {
        const mssm_points3 p = mssm_reconstruct4(four(r), z);
        memcpy(n.z, p.z, sizeof p.z);
        memcpy(n.w, p.w, sizeof p.w);
    } else {
        const mssm_points4 p = mssm_reconstruct6(six(r), z);
        memcpy(n.z, p.z, sizeof p.z);
        memcpy(n.w, p.w, sizeof p.w);
    }
    return n;
}

static orthogonal orthogonal_of(int m, moments r)
{
    quad b[7] = {1, 0, 0, 0, 0, 0, 0};
    for (int k = 0; k < m; k++) b[k + 1] = (quad)r.b[k];
    return orthogonal_of_moments(m, b);
}

// Shares of depth < z and depth == z.
static void shares(const patch *p, float z, double *nearer, double *self)
{
    int below = 0, at = 0;
    for (int i = 0; i < p->count; i++) {
        below += p->depth[i] < z;
        at += p->depth[i] == z;
    }
    *nearer = (double)below / p->count;
    *self = (double)at / p->count;
}

// ---- worst cases ---------------------------------------------------------------------------

typedef struct worst {
    double error;
    int m, family;
    float alpha, z;
    moments b;
} worst;

static void keep_worst(worst *w, double error, int m, int family, float alpha, moments b, float z)
{
    if (!(error > w->error) && error == error) return;
    w->error = error;
    w->m = m;
    w->family = family;
    w->alpha = alpha;
    w->b = b;
    w->z = z;
}

static void note_worst(const char *what, const worst *w)
{
    char text[200];
    int length = 0;
    for (int k = 0; k < w->m; k++) {
        length += snprintf(text + length, sizeof text - (size_t)length, " %a,", (double)w->b.b[k]);
    }
    test_note("%s %.2e: %s, alpha %g, moments%s z %a", what, w->error,
              w->family < 0 ? "any" : family_names[w->family], (double)w->alpha, text,
              (double)w->z);
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int in_range(mssm_bounds v)
{
    return v.lower >= 0 && v.lower <= v.upper && v.upper <= 1;
}

// Any finite float: every exponent equally often, both signs, now and then special values.
static float any_float(uint64_t *state)
{
    static const float special[] = {0,        -0.0f, 1,       -1,     0.5f,    FLT_MAX,
                                    -FLT_MAX, 1e38f, FLT_MIN, 1e-45f, -1e-45f, 1e-38f};
    const uint64_t r = test_random(state);
    if (r % 8 == 0) return special[(r >> 8) % (sizeof special / sizeof *special)];
    if (r % 8 < 4) return (float)test_range(state, -1.5, 1.5);
    const uint32_t bits = (uint32_t)(r >> 32);
    float x;
    memcpy(&x, &bits, sizeof x);
    return x - x == 0 ? x : 3e38f;
}

// ---- the oracle itself ---------------------------------------------------------------------

static void oracle_reproduces_moments(void)
{
    uint64_t state = 11;
    double worst_moment = 0, worst_match = 0;
    for (int i = 0; i < test_trials(600); i++) {
        const int m = i & 1 ? 6 : 4;
        const patch p = random_patch(i / 2 % FAMILY_COUNT, &state);
        distribution d = distribution_of(p.count, p.depth);
        const quad even[3] = {0.657L, 0.734L, 1.197L};
        if (i & 2) distribution_bias(&d, m, even, 1e-6L);
        quad b[7];
        distribution_moments(&d, b);
        const orthogonal o = orthogonal_of_distribution(m, &d);
        const float z = family_receiver(i % RECEIVER_COUNT, p.count, p.depth, &state);
        const points r = oracle_points(&o, (quad)z);
        const int degenerate = o.rank <= o.n;
        // A depth at infinity holds no share, yet its part of the last moment.
        const int held = degenerate || r.count == o.n + 1 ? m : m - 1;
        for (int k = 0; k <= held; k++) {
            quad sum = 0;
            for (int j = 0; j < r.count; j++) {
                quad power = r.w[j];
                for (int n = 0; n < k; n++) power *= r.z[j];
                sum += power;
            }
            const double error = (double)quad_abs(sum - b[k]);
            if (error > worst_moment) worst_moment = error;
            CHECK(error < 1e-12, "moment %d of %s is off by %g", k, family_names[p.family], error);
        }
        CHECK(degenerate || r.count >= o.n, "only %d depths", r.count);
        if (!(i & 2)) continue;
        const orthogonal from_moments = orthogonal_of_moments(m, b);
        const sharp_bounds s = oracle_bounds(&o, (quad)z),
                           t = oracle_bounds(&from_moments, (quad)z);
        const double match = (double)quad_abs(s.upper - t.upper);
        if (match > worst_match) worst_match = match;
        CHECK(match < 1e-9, "depths and moments disagree by %g on %s", match,
              family_names[p.family]);
    }
    test_note("moments to %.1e, bounds from depths and from moments to %.1e", worst_moment,
              worst_match);
}

// ---- bounds --------------------------------------------------------------------------------

enum { PER_FAMILY = 120 };

static void match_format(int m, int format, float alpha)
{
    static double errors[FAMILY_COUNT * PER_FAMILY * RECEIVER_COUNT];
    worst w = {-1, m, -1, alpha, 0, {{0}}};
    uint64_t state = 1000 + (uint64_t)(10 * m + format);
    int count = 0;
    for (int i = 0; i < test_trials(FAMILY_COUNT * PER_FAMILY); i++) {
        const patch p = random_patch(i % FAMILY_COUNT, &state);
        const moments b = biased(m, format, stored(&p, m, format), alpha);
        const orthogonal o = orthogonal_of(m, b);
        CHECK(o.rank == m / 2 + 1, "%d moments, %s, %s: alpha %g does not repair", m,
              format_names[format], family_names[p.family], (double)alpha);
        for (int r = 0; r < RECEIVER_COUNT; r++) {
            const float z = family_receiver(r, p.count, p.depth, &state);
            const sharp_bounds s = oracle_bounds(&o, (quad)z);
            const mssm_bounds v = visibility(m, b, z);
            const double low = fabs((double)((quad)v.lower - s.lower));
            const double high = fabs((double)((quad)v.upper - s.upper));
            errors[count] = low > high ? low : high;
            keep_worst(&w, errors[count++], m, p.family, alpha, b, z);
        }
    }
    qsort(errors, (size_t)count, sizeof *errors, ascending);
    const double most = errors[(int)(0.999 * count)];
    test_note("%d moments, %-9s alpha %.2g: median %.1e, 99.9%% %.1e, max %.1e", m,
              format_names[format], (double)alpha, errors[count / 2], most, w.error);
    note_worst("   ", &w);
    CHECK(most <= limit_999[format], "99.9%% is above %g", limit_999[format]);
    CHECK(w.error <= limit_max[format], "the worst is above %g", limit_max[format]);
}

static void bounds_match_oracle(void)
{
    for (int m = 4; m <= 6; m += 2) {
        for (int format = 0; format < FORMATS; format++)
            match_format(m, format, safe_alpha(m, format));
    }
    for (int m = 4; m <= 6; m += 2) match_format(m, FLOAT32, 1e-3f);
}

// What the safe bias promises: the biased moments are those of (1-alpha) truth + alpha anything. In
// quad precision that holds exactly; in float32 up to the errors allowed above.
static void bounds_enclose_truth(void)
{
    uint64_t state = 21;
    const worst none = {-1, 4, -1, 0, 0, {{0}}};
    worst proof = none;
    for (int format = 0; format < FORMATS; format++) {
        worst w = none;
        for (int i = 0; i < test_trials(24000); i++) {
            const int m = i & 1 ? 6 : 4;
            const float alpha = i % 6 < 4 ? safe_alpha(m, format) : 1e-3f;
            const patch p = random_patch(i / 2 % FAMILY_COUNT, &state);
            const float z = family_receiver(i % RECEIVER_COUNT, p.count, p.depth, &state);
            const moments b = biased(m, format, stored(&p, m, format), alpha);
            const mssm_bounds v = visibility(m, b, z);
            double nearer, self;
            shares(&p, z, &nearer, &self);
            const double keep = 1 - (double)alpha;
            const double dark = keep * (1 - nearer) - (double)v.upper;
            const double leak = (double)v.lower - (keep * (1 - nearer - self) + (double)alpha);
            const double error = dark > leak ? dark : leak;
            keep_worst(&w, error, m, p.family, alpha, b, z);
            CHECK(error <= limit_max[format], "%s: the truth is outside by %g",
                  format_names[format], error);
            if (i % 8 > 1) continue;
            const orthogonal o = orthogonal_of(m, b);
            const sharp_bounds s = oracle_bounds(&o, (quad)z);
            const double exact_dark = (double)((quad)(keep * (1 - nearer)) - s.upper);
            const double exact_leak =
                (double)s.lower - (keep * (1 - nearer - self) + (double)alpha);
            keep_worst(&proof, exact_dark > exact_leak ? exact_dark : exact_leak, m, p.family,
                       alpha, b, z);
        }
        test_note("%s", format_names[format]);
        note_worst("outside by", &w);
    }
    note_worst("in quad precision outside by", &proof);
    CHECK(proof.error < 1e-12, "the safe bias is not safe: %g", proof.error);
}

static void bounds_enclose_biased_distribution(void)
{
    static const double even4[3] = {0.920, 3.804, 0}, even6[3] = {0.421, 0.511, 1.913};
    uint64_t state = 22;
    worst w = {-1, 4, -1, 0, 0, {{0}}};
    for (int i = 0; i < test_trials(3000); i++) {
        const int m = i & 1 ? 6 : 4;
        const double *source = m == 4 ? even4 : even6;
        const quad even[3] = {(quad)source[0], (quad)source[1], (quad)source[2]};
        const float alpha = i & 2 ? 1e-3f : i & 4 ? 1e-5f : safe_alpha(m, FLOAT32);
        const patch p = random_patch(i / 8 % FAMILY_COUNT, &state);
        distribution d = distribution_of(p.count, p.depth);
        distribution_bias(&d, m, even, (quad)alpha);
        quad exact[7];
        distribution_moments(&d, exact);
        moments b = {{0}};
        for (int k = 0; k < m; k++) b.b[k] = (float)exact[k + 1];
        for (int r = 0; r < RECEIVER_COUNT; r++) {
            const float z = family_receiver(r, p.count, p.depth, &state);
            const sharp_bounds truth = distribution_truth(&d, (quad)z);
            const mssm_bounds v = visibility(m, b, z);
            const double dark = (double)(truth.upper - (quad)v.upper);
            const double leak = (double)((quad)v.lower - truth.lower);
            keep_worst(&w, dark > leak ? dark : leak, m, p.family, alpha, b, z);
        }
    }
    note_worst("outside by", &w);
    CHECK(w.error <= limit_max[FLOAT32], "the biased distribution is outside by %g", w.error);
}

static void bounds_in_range_at_any_bias(void)
{
    static const float alphas[] = {0,     1e-9f, 1e-8f, 1e-7f, 3e-7f, 1e-6f,
                                   3e-6f, 1e-5f, 1e-4f, 1e-3f, 0.1f,  1};
    uint64_t state = 23;
    for (int i = 0; i < test_trials(30000); i++) {
        const patch p = random_patch(i % FAMILY_COUNT, &state);
        for (int n = 0; n < 2 * FORMATS; n++) {
            const int m = n & 1 ? 6 : 4, format = n / 2;
            const float alpha = alphas[test_random(&state) % 12];
            const moments b = biased(m, format, stored(&p, m, format), alpha);
            const float z = family_receiver((i + n) % RECEIVER_COUNT, p.count, p.depth, &state);
            const mssm_bounds v = visibility(m, b, z);
            CHECK(in_range(v), "%d moments %a %a %a %a %a %a z %a: [%g, %g]", m, (double)b.b[0],
                  (double)b.b[1], (double)b.b[2], (double)b.b[3], (double)b.b[4], (double)b.b[5],
                  (double)z, (double)v.lower, (double)v.upper);
        }
    }
}

static void garbage_keeps_bounds_in_range(void)
{
    uint64_t state = 24;
    for (int i = 0; i < test_trials(800000); i++) {
        const int m = i & 1 ? 6 : 4;
        moments b = {{0}};
        for (int k = 0; k < m; k++) b.b[k] = any_float(&state);
        const float z = any_float(&state);
        const mssm_bounds v = visibility(m, b, z);
        CHECK(in_range(v), "%d moments %a %a %a %a %a %a z %a: [%g, %g]", m, (double)b.b[0],
              (double)b.b[1], (double)b.b[2], (double)b.b[3], (double)b.b[4], (double)b.b[5],
              (double)z, (double)v.lower, (double)v.upper);
    }
}

static int finite_nodes(nodes n)
{
    double sum = 0;
    for (int k = 0; k < n.count; k++) {
        if (!isfinite(n.z[k]) || !(n.w[k] >= 0 && n.w[k] <= 1)) return 0;
        if (k > 1 && n.z[k] < n.z[k - 1]) return 0;
        sum += (double)n.w[k];
    }
    return fabs(sum - 1) < 1e-5;
}

static int finite_moments(int m, moments b)
{
    for (int k = 0; k < m; k++) {
        if (!isfinite(b.b[k])) return 0;
    }
    return 1;
}

// Every function on one input; the name of the first that broke its promise, or null.
static const char *broken_function(int m, moments b, float z, float alpha)
{
    moments q = {{0}};
    const mssm_moments4 of4 = mssm_moments4_of_depth(z), e4 = mssm_moments4_encode(four(b));
    const mssm_moments6 of6 = mssm_moments6_of_depth(z), e6 = mssm_moments6_encode(six(b));
    if (m == 4)
        memcpy(q.b, e4.b, sizeof e4.b);
    else
        memcpy(q.b, e6.b, sizeof e6.b);
    for (int k = 0; k < m; k++) {
        if (!(q.b[k] >= 0 && q.b[k] <= 1)) return "encode";
        if (!(fabsf(m == 4 ? of4.b[k] : of6.b[k]) <= 1)) return "of_depth";
    }
    if (!finite_moments(m, decoded(m, b))) return "decode";
    if (!finite_moments(m, biased(m, FLOAT32, b, alpha))) return "bias";
    if (!finite_nodes(reconstructed(m, b, z))) return "reconstruct";
    // The upper bound holds the receiver's own share, however the others are rounded.
    if (!(visibility(m, b, z).upper >= reconstructed(m, b, z).w[0] - 1e-6f)) return "visibility";
    const float receiver = z < -1 ? -1 : z < 1 ? z : 1;
    const float low = blocker_depth(m, b, z, 1e-3f, 1e-3f),
                any = blocker_depth(m, b, z, alpha, b.b[0]);
    if (!(low >= -1 && low <= receiver && any >= -1 && any <= receiver)) return "blocker_depth";
    const mssm_roots3 r = mssm_solve_cubic(b.b[0], b.b[1], b.b[2], b.b[3]);
    if (r.count < 0 || r.count > 3) return "solve_cubic (count)";
    for (int k = 0; k < 3; k++) {
        if (!isfinite(r.x[k])) return "solve_cubic";
        if (k > 0 && k < r.count && r.x[k] < r.x[k - 1]) return "solve_cubic (order)";
    }
    return NULL;
}

static void garbage_keeps_everything_finite(void)
{
    uint64_t state = 25;
    for (int i = 0; i < test_trials(800000); i++) {
        const int m = i & 1 ? 6 : 4;
        moments b = {{0}};
        for (int k = 0; k < m; k++) b.b[k] = any_float(&state);
        const float z = any_float(&state), alpha = any_float(&state);
        const char *broken = broken_function(m, b, z, alpha);
        CHECK(!broken, "%d moments, %s: %a %a %a %a %a %a z %a alpha %a", m, broken, (double)b.b[0],
              (double)b.b[1], (double)b.b[2], (double)b.b[3], (double)b.b[4], (double)b.b[5],
              (double)z, (double)alpha);
    }
}

static void nan_and_infinity_become_finite(void)
{
    const float special[] = {NAN, -NAN, INFINITY, -INFINITY, 0, 1, -1, 0.25f, FLT_MAX, 1e-45f};
    uint64_t state = 26;
    for (int i = 0; i < test_trials(200000); i++) {
        const int m = i & 1 ? 6 : 4;
        moments b = {{0}};
        for (int k = 0; k < m; k++) b.b[k] = special[test_random(&state) % 10];
        const float z = special[test_random(&state) % 10],
                    alpha = special[test_random(&state) % 10];
        const char *broken = broken_function(m, b, z, alpha);
        const mssm_bounds v = visibility(m, b, z);
        CHECK(in_range(v), "bounds [%g, %g]", (double)v.lower, (double)v.upper);
        CHECK(!broken, "%d moments, %s: %a %a %a %a %a %a z %a alpha %a", m, broken, (double)b.b[0],
              (double)b.b[1], (double)b.b[2], (double)b.b[3], (double)b.b[4], (double)b.b[5],
              (double)z, (double)alpha);
    }
}

static void lone_surface_is_lit(void)
{
    uint64_t state = 27;
    for (int format = 0; format < FORMATS; format++) {
        for (int m = 4; m <= 6; m += 2) {
            const float alpha = safe_alpha(m, format);
            worst w = {-1, m, -1, alpha, 0, {{0}}};
            for (int i = 0; i < test_trials(60000); i++) {
                const int family = i % 4 ? FAMILY_FLAT : FAMILY_EXACT;
                patch p = random_patch(family, &state);
                p.count = 1; // all texels are equal
                const float d = p.depth[0];
                const int kind = (int)(test_random(&state) % 3);
                const float away = (float)exp(test_range(&state, log(1e-8), 0));
                const float z = kind == 0   ? d
                                : kind == 1 ? d - away
                                            : (float)test_range(&state, -1.5, (double)d);
                const moments b = biased(m, format, stored(&p, m, format), alpha);
                const mssm_bounds v = visibility(m, b, z);
                keep_worst(&w, 1 - (double)v.upper, m, family, alpha, b, z);
            }
            test_note("%d moments, %s", m, format_names[format]);
            note_worst("false shadow", &w);
            // float32 cannot tell 1 - alpha from 1 any better than this.
            CHECK(w.error <= (double)alpha + 6e-8, "false shadow %g at alpha %g", w.error,
                  (double)alpha);
        }
    }
}

static void bounds_fall_with_depth(void)
{
    static const double limit[3] = {4e-6, 4e-6, 4e-6};
    uint64_t state = 28;
    worst w[FORMATS];
    for (int f = 0; f < FORMATS; f++) {
        const worst none = {-1, 4, -1, 0, 0, {{0}}};
        w[f] = none;
    }
    for (int i = 0; i < test_trials(4000); i++) {
        const int m = i & 1 ? 6 : 4, format = i / 2 % FORMATS;
        const patch p = random_patch(i / 6 % FAMILY_COUNT, &state);
        const float alpha = i % 7 ? safe_alpha(m, format) : 1e-3f;
        const moments b = biased(m, format, stored(&p, m, format), alpha);
        double z[200];
        for (int k = 0; k < 200; k++) {
            const int kind = k % 10 ? RECEIVER_NEAR : k % RECEIVER_COUNT;
            z[k] = k < 100 ? -1.2 + k * 0.024
                           : (double)family_receiver(kind, p.count, p.depth, &state);
        }
        qsort(z, 200, sizeof *z, ascending);
        mssm_bounds before = {1, 1};
        for (int k = 0; k < 200; k++) {
            const mssm_bounds v = visibility(m, b, (float)z[k]);
            const double up = (double)v.upper - (double)before.upper;
            const double low = (double)v.lower - (double)before.lower;
            keep_worst(&w[format], up > low ? up : low, m, p.family, alpha, b, (float)z[k]);
            before = v;
        }
    }
    for (int f = 0; f < FORMATS; f++) {
        test_note("%s", format_names[f]);
        note_worst("rise of", &w[f]);
        CHECK(w[f].error <= limit[f], "a bound rises by %g", w[f].error);
    }
}

static void mirror_swaps_bounds(void)
{
    uint64_t state = 29;
    worst w = {-1, 4, -1, 0, 0, {{0}}};
    for (int i = 0; i < test_trials(60000); i++) {
        const int m = i & 1 ? 6 : 4, format = i / 2 % FORMATS;
        const patch p = random_patch(i / 6 % FAMILY_COUNT, &state);
        const float alpha = i % 7 ? safe_alpha(m, format) : 1e-3f;
        const moments b = biased(m, format, stored(&p, m, format), alpha);
        const float z = family_receiver(i % RECEIVER_COUNT, p.count, p.depth, &state);
        moments c = b;
        for (int k = 0; k < m; k += 2) c.b[k] = -b.b[k];
        const mssm_bounds v = visibility(m, b, z), u = visibility(m, c, -z);
        const double a = fabs(1 - (double)v.lower - (double)u.upper);
        const double e = fabs(1 - (double)v.upper - (double)u.lower);
        keep_worst(&w, a > e ? a : e, m, p.family, alpha, b, z);
    }
    note_worst("differs by", &w);
    CHECK(w.error <= 2e-5, "mirrored bounds differ by %g", w.error);
}

// ---- exact depths --------------------------------------------------------------------------

// `count` depths at least 0.25 apart with shares of at least 0.1.
static void few_depths(int count, uint64_t *state, float *z, double *w)
{
    double total = 0;
    for (int again = 1; again;) {
        again = 0;
        for (int i = 0; i < count; i++) z[i] = (float)test_range(state, -1, 1);
        for (int i = 0; i < count; i++) {
            for (int j = 0; j < i; j++) again |= fabsf(z[i] - z[j]) < 0.25f;
        }
    }
    for (int i = 0; i < count; i++) total += w[i] = test_range(state, 0.1, 1);
    for (int i = 0; i < count; i++) w[i] /= total;
}

static moments moments_of(int m, int count, const float *z, const double *w)
{
    double sum[6] = {0};
    moments b = {{0}};
    for (int i = 0; i < count; i++) {
        double power = w[i];
        for (int k = 0; k < m; k++) sum[k] += power *= (double)z[i];
    }
    for (int k = 0; k < m; k++) b.b[k] = (float)sum[k];
    return b;
}

static void exact_depths_are_reproduced(void)
{
    for (int m = 4; m <= 6; m += 2) {
        for (int count = m / 2; count <= m / 2 + 1; count++) {
            uint64_t state = 30 + (uint64_t)(m + count);
            const float alpha = safe_alpha(m, FLOAT32);
            double worst_step = 0, worst_share = 0, worst_depth = 0;
            for (int i = 0; i < test_trials(20000); i++) {
                float z[4];
                double w[4];
                few_depths(count, &state, z, w);
                const moments b = biased(m, FLOAT32, moments_of(m, count, z, w), alpha);
                // At one of its depths the representation is the distribution.
                const nodes n = reconstructed(m, b, z[0]);
                for (int k = 0; k < count; k++) {
                    double depth = 10, share = 10;
                    for (int j = 0; j < n.count; j++) {
                        if (fabs((double)n.z[j] - (double)z[k]) >= depth) continue;
                        depth = fabs((double)n.z[j] - (double)z[k]);
                        share = fabs((double)n.w[j] - w[k]);
                    }
                    worst_depth = depth > worst_depth ? depth : worst_depth;
                    worst_share = share > worst_share ? share : worst_share;
                }
                double nearer = 0;
                for (int k = 1; k < count; k++) nearer += z[k] < z[0] ? w[k] : 0;
                const mssm_bounds v = visibility(m, b, z[0]);
                const double up = fabs(1 - nearer - (double)v.upper);
                const double low = fabs(1 - nearer - w[0] - (double)v.lower);
                worst_step = up > worst_step ? up : worst_step;
                worst_step = low > worst_step ? low : worst_step;
            }
            test_note("%d moments, %d depths: bounds to %.1e, shares to %.1e, depths to %.1e", m,
                      count, worst_step, worst_share, worst_depth);
            // Four depths as near as 0.25 leave a third pivot of 1e-5: the bias alone shows there.
            const double slack = count == 4 ? 20 : 1;
            CHECK(worst_step < slack * 1e-3, "bounds off by %g", worst_step);
            CHECK(worst_share < slack * 2e-3, "shares off by %g", worst_share);
            CHECK(worst_depth < slack * 4e-3, "depths off by %g", worst_depth);
        }
    }
}

// ---- storage -------------------------------------------------------------------------------

static void moments_of_depth_are_powers(void)
{
    uint64_t state = 41;
    double error = 0;
    for (int i = 0; i < test_trials(100000); i++) {
        const float z = i < 3 ? (float)(i - 1) : (float)test_range(&state, -1, 1);
        const mssm_moments4 a = mssm_moments4_of_depth(z);
        const mssm_moments6 b = mssm_moments6_of_depth(z);
        for (int k = 0; k < 6; k++) {
            const double power = pow((double)z, k + 1), e = fabs((double)b.b[k] - power);
            error = e > error ? e : error;
            if (k < 4) CHECK(a.b[k] == b.b[k], "moment %d of %a differs", k + 1, (double)z);
            if (i < 3) CHECK((double)b.b[k] == power, "moment %d of %g", k + 1, (double)z);
        }
    }
    test_note("largest error %.1e", error);
    CHECK(error < 1.6e-7, "moments of depth are off by %g", error);
}

static void decode_undoes_encode(void)
{
    uint64_t state = 42;
    double there = 0, back = 0;
    for (int i = 0; i < test_trials(40000); i++) {
        const patch p = random_patch(i % FAMILY_COUNT, &state);
        const moments b = stored(&p, 6, FLOAT32);
        const mssm_moments4 q4 = mssm_moments4_encode(four(b));
        const mssm_moments6 q6 = mssm_moments6_encode(six(b)), r = mssm_moments6_decode(q6);
        const mssm_moments4 r4 = mssm_moments4_decode(q4);
        double power[7] = {1, 0, 0, 0, 0, 0, 0};
        for (int k = 1; k <= 6; k++) power[k] = (double)b.b[k - 1];
        const double t[6] = {power[1],
                             2 * power[2] - 1,
                             4 * power[3] - 3 * power[1],
                             8 * power[4] - 8 * power[2] + 1,
                             16 * power[5] - 20 * power[3] + 5 * power[1],
                             32 * power[6] - 48 * power[4] + 18 * power[2] - 1};
        for (int k = 0; k < 6; k++) {
            const double q = 0.5 + 0.5 * t[k], e = fabs((double)q6.b[k] - (q < 0   ? 0
                                                                           : q > 1 ? 1
                                                                                   : q));
            there = e > there ? e : there;
            if (k < 4) CHECK(q4.b[k] == q6.b[k], "value %d of four is not that of six", k + 1);
            const double f = fabs((double)r.b[k] - power[k + 1]);
            back = f > back ? f : back;
            if (k < 4)
                CHECK(r4.b[k] == r.b[k], "decoded value %d of four is not that of six", k + 1);
        }
    }
    test_note("encode to %.1e, decode(encode) to %.1e", there, back);
    CHECK(there < 4e-6 && back < 1e-6, "encode off by %g, the round trip by %g", there, back);
}

static void bias_pulls_to_its_vector(void)
{
    static const float star4[4] = {0, 0.920f, 0, 3.804f},
                       star6[6] = {0, 0.421f, 0, 0.511f, 0, 1.913f};
    uint64_t state = 43;
    for (int i = 0; i < test_trials(20000); i++) {
        const patch p = random_patch(i % FAMILY_COUNT, &state);
        const moments b = stored(&p, 6, FLOAT32);
        const float alpha = (float)exp(test_range(&state, log(1e-8), 0));
        const mssm_moments4 a0 = mssm_moments4_bias(four(b), 0),
                            a1 = mssm_moments4_bias(four(b), 1);
        const mssm_moments6 b0 = mssm_moments6_bias(six(b), 0), b1 = mssm_moments6_bias(six(b), 1);
        const mssm_moments4 a = mssm_moments4_bias(four(b), alpha);
        const mssm_moments6 c = mssm_moments6_bias(six(b), alpha);
        for (int k = 0; k < 6; k++) {
            const double keep = 1 - (double)alpha, old = keep * (double)b.b[k];
            CHECK(b0.b[k] == b.b[k], "alpha 0 changes moment %d", k + 1);
            CHECK(fabsf(b1.b[k] - star6[k]) < 3e-7f, "alpha 1: moment %d is %g", k + 1,
                  (double)b1.b[k]);
            CHECK(fabs((double)c.b[k] - (old + (double)alpha * (double)star6[k])) < 3e-7,
                  "alpha %g: moment %d of 6", (double)alpha, k + 1);
            if (k >= 4) continue;
            CHECK(a0.b[k] == b.b[k], "alpha 0 changes moment %d", k + 1);
            CHECK(fabsf(a1.b[k] - star4[k]) < 5e-7f, "alpha 1: moment %d is %g", k + 1,
                  (double)a1.b[k]);
            CHECK(fabs((double)a.b[k] - (old + (double)alpha * (double)star4[k])) < 5e-7,
                  "alpha %g: moment %d of 4", (double)alpha, k + 1);
        }
    }
}

// ---- cubic ---------------------------------------------------------------------------------

// How far a root may move when every coefficient moves by a relative `delta`: as far as the lowest
// derivative that is not too small lets it.
static double root_uncertainty(const float c[4], double x, double delta)
{
    const double a = fabs(x), c0 = (double)c[0], c1 = (double)c[1], c2 = (double)c[2],
                 c3 = (double)c[3];
    const double f = delta * (((fabs(c3) * a + fabs(c2)) * a + fabs(c1)) * a + fabs(c0));
    const double first = fabs((3 * c3 * x + 2 * c2) * x + c1), second = fabs(3 * c3 * x + c2);
    double best = first > 0 ? f / first : 1e300;
    if (second > 0) best = fmin(best, sqrt(f / second));
    if (c3 != 0) best = fmin(best, cbrt(f / fabs(c3)));
    return 4 * best;
}

// The roots where numbers below 1e-38 are 0, as on GPUs and in programs linked with -ffast-math.
static mssm_roots3 solve_flushed(const float c[4])
{
#ifdef __SSE__
    const unsigned before = _mm_getcsr();
    _mm_setcsr(before | 0x8040);
#endif
    const mssm_roots3 r = mssm_solve_cubic(c[0], c[1], c[2], c[3]);
#ifdef __SSE__
    _mm_setcsr(before);
#endif
    return r;
}

// Do the roots found agree with the true ones, up to what rounding the coefficients can do?
static int roots_agree(const float c[4], mssm_roots3 r, double delta, const char **why)
{
    const quad q[4] = {(quad)c[0], (quad)c[1], (quad)c[2], (quad)c[3]};
    quad x[3];
    const int count = oracle_cubic(q, x);
    for (int i = 0; i < r.count; i++) {
        *why = "a root is not finite or out of order";
        if (!isfinite(r.x[i]) || (i > 0 && r.x[i] < r.x[i - 1])) return 0;
    }
    *why = "an unused root is not 0";
    for (int i = r.count; i < 3; i++) {
        if (!(r.x[i] >= 0 && r.x[i] <= 0)) return 0;
    }
    // Every true root must be found, a root found in excess must be within rounding of being one.
    int used[3] = {0, 0, 0};
    for (int i = 0; i < count; i++) {
        int best = -1;
        for (int j = 0; j < r.count; j++) {
            if (used[j]) continue;
            if (best < 0 || quad_abs((quad)r.x[j] - x[i]) < quad_abs((quad)r.x[best] - x[i]))
                best = j;
        }
        const double exact = (double)x[i];
        const double allowed = root_uncertainty(c, exact, delta) + 3e-7 * fabs(exact) + 1e-37;
        *why = "a root is lost";
        if (fabs(exact) > 1e17) continue; // counts as infinite
        if (best < 0) return 0;
        *why = "a root is wrong";
        if (fabs((double)((quad)r.x[best] - x[i])) > allowed) return 0;
        used[best] = 1;
    }
    *why = "a root is made up";
    for (int j = 0; j < r.count; j++) {
        const quad a = (quad)r.x[j], b = quad_abs(a);
        const quad f = ((q[3] * a + q[2]) * a + q[1]) * a + q[0];
        const quad size =
            ((quad_abs(q[3]) * b + quad_abs(q[2])) * b + quad_abs(q[1])) * b + quad_abs(q[0]);
        if (!used[j] && quad_abs(f) > 8 * (quad)delta * size) return 0;
    }
    return 1;
}

static void check_cubic(const float c[4], double delta)
{
    const mssm_roots3 r = mssm_solve_cubic(c[0], c[1], c[2], c[3]), flushed = solve_flushed(c);
    const char *why = "";
    CHECK(roots_agree(c, r, delta, &why), "%s: %a %a %a %a", why, (double)c[0], (double)c[1],
          (double)c[2], (double)c[3]);
    CHECK(!memcmp(&r, &flushed, sizeof r) || roots_agree(c, flushed, delta, &why),
          "flushed: %s: %a %a %a %a", why, (double)c[0], (double)c[1], (double)c[2], (double)c[3]);
}

static void coefficients_of_roots(const double x[3], double scale, float c[4])
{
    c[3] = (float)scale;
    c[2] = (float)(-scale * (x[0] + x[1] + x[2]));
    c[1] = (float)(scale * (x[0] * x[1] + x[0] * x[2] + x[1] * x[2]));
    c[0] = (float)(-scale * x[0] * x[1] * x[2]);
}

static void cubic_random(void)
{
    uint64_t state = 51;
    for (int i = 0; i < test_trials(40000); i++) {
        float c[4];
        double x[3];
        const double scale = exp(test_range(&state, -3, 3));
        for (int k = 0; k < 3; k++) {
            x[k] = i & 1 ? test_range(&state, -2, 2)
                         : (test_uniform(&state) < 0.5 ? -1 : 1) * exp(test_range(&state, -7, 7));
        }
        coefficients_of_roots(x, scale, c);
        check_cubic(c, 1e-6);
        for (int k = 0; k < 4; k++) c[k] = (float)test_range(&state, -1, 1);
        check_cubic(c, 1e-6);
    }
}

static void cubic_near_equal_roots(void)
{
    uint64_t state = 52;
    for (int i = 0; i < test_trials(60000); i++) {
        float c[4];
        double x[3];
        const double gap = exp(test_range(&state, log(1e-7), log(1e-1)));
        x[0] = test_range(&state, -1, 1);
        x[1] = x[0] + gap;
        x[2] = i % 3 == 0   ? x[0] + gap * test_range(&state, 1, 3)
               : i % 3 == 1 ? x[0]
                            : test_range(&state, -1, 1);
        coefficients_of_roots(x, 1, c);
        check_cubic(c, 1e-6);
    }
}

// Roots that rounding of the coefficients has just made complex are kept as double roots: all three
// shares of a distribution with two near depths must be there.
static void cubic_loses_no_pair(void)
{
    uint64_t state = 53;
    int lost = 0, tried = 0;
    for (int i = 0; i < test_trials(60000); i++) {
        float c[4];
        double x[3];
        x[0] = test_range(&state, -1, 1);
        x[1] = x[0] + exp(test_range(&state, log(1e-7), log(1e-1)));
        x[2] = test_range(&state, -1, 1);
        coefficients_of_roots(x, 1, c);
        tried++;
        lost += mssm_solve_cubic(c[0], c[1], c[2], c[3]).count != 3;
    }
    test_note("%d of %d lost", lost, tried);
    CHECK(lost == 0, "%d of %d cubics made from three real roots have lost some", lost, tried);
}

static void cubic_triple_roots(void)
{
    uint64_t state = 54;
    for (int i = 0; i < test_trials(20000); i++) {
        float c[4];
        const double root = i < 5 ? 0.5 * (i - 2) : test_range(&state, -4, 4),
                     x[3] = {root, root, root};
        coefficients_of_roots(x, i < 5 ? 1 : exp(test_range(&state, -3, 3)), c);
        check_cubic(c, 1e-6);
        const mssm_roots3 r = mssm_solve_cubic(c[0], c[1], c[2], c[3]);
        CHECK(r.count == 3, "%d roots of (x - %a)^3", r.count, root);
    }
}

static void cubic_degenerate(void)
{
    static const float cases[][4] = {{0, 0, 0, 0},      {1, 0, 0, 0},       {-1, 1, 0, 0},
                                     {1, 2, 0, 0},      {1, -3, 2, 0},      {1, 2, 1, 0},
                                     {1, 0, 1, 0},      {0, 0, 0, 1},       {0, 0, 1, 1},
                                     {0, 1, 0, 1},      {0, -1, 0, 1},      {-1, 0, 0, 1},
                                     {1, 0, 0, 1},      {0, 0, 1, 0},       {0, 1, 0, 0},
                                     {1, 1, 1, 1},      {1, -3, 2, 1e-30f}, {1, 2, 1e-30f, 0},
                                     {1, 2, 0, 1e-30f}, {1, -3, 2, 1e-7f},  {1, 2, 1e-7f, 1e-14f}};
    static const int counts[] = {0, 0, 1, 1, 2, 2, 0, 3, 3, 1, 3, 1, 1, 2, 1, 1};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        check_cubic(cases[i], 1e-6);
        const float *c = cases[i];
        const mssm_roots3 r = mssm_solve_cubic(c[0], c[1], c[2], c[3]);
        if (i < sizeof counts / sizeof *counts) {
            CHECK(r.count == counts[i], "%g %g %g %g: %d roots", (double)c[0], (double)c[1],
                  (double)c[2], (double)c[3], r.count);
        }
    }
    uint64_t state = 55;
    for (int i = 0; i < test_trials(40000); i++) {
        float c[4];
        for (int k = 0; k < 4; k++) c[k] = (float)test_range(&state, -1, 1);
        c[3] *= (float)exp(test_range(&state, log(1e-20), 0));
        if (i % 3 == 0) c[3] = 0;
        if (i % 5 == 0) c[2] *= (float)exp(test_range(&state, log(1e-20), 0));
        if (i % 15 == 0) c[2] = 0;
        check_cubic(c, 1e-6);
    }
}

// Where the leading coefficient puts a root beyond 1e18, the degree is one less.
static void roots_beyond_1e18_are_infinite(void)
{
    for (int beyond = 0; beyond < 2; beyond++) {
        const float far = beyond ? 1.2e18f : 0.8e18f;
        for (int sign = -1; sign <= 1; sign += 2) {
            const float lead = (float)sign / far;
            const mssm_roots3 one = mssm_solve_cubic(1, lead, 0, 0),
                              two = mssm_solve_cubic(-0.25f, 1, lead, 0),
                              three = mssm_solve_cubic(-0.25f, 0, 1, lead);
            CHECK(one.count == !beyond && two.count == 2 - beyond && three.count == 3 - beyond,
                  "%d %d %d roots with one at %g", one.count, two.count, three.count, (double)far);
            if (beyond) {
                CHECK(fabsf(two.x[0] - 0.25f) < 1e-6f, "root %g", (double)two.x[0]);
                CHECK(fabsf(three.x[0] + 0.5f) < 1e-6f && fabsf(three.x[1] - 0.5f) < 1e-6f,
                      "roots");
            } else {
                const int last = sign < 0;
                CHECK(fabsf(one.x[0] + (float)sign * far) < 1e12f, "root %g", (double)one.x[0]);
                CHECK(fabsf(two.x[last] + (float)sign * far) < 1e12f, "root %g",
                      (double)two.x[last]);
                CHECK(fabsf(three.x[2 * last] + (float)sign * far) < 1e12f, "root %g",
                      (double)three.x[2 * last]);
            }
        }
    }
}

// Infinite coefficients count as the largest finite ones, NaN as one of them.
static void infinite_coefficients_are_the_largest(void)
{
    uint64_t state = 57;
    for (int i = 0; i < 400; i++) {
        float c[4];
        for (int k = 0; k < 4; k++) {
            c[k] = test_random(&state) % 3 ? (float)test_range(&state, -1, 1) : 0;
            if (test_random(&state) % 4 == 0) c[k] *= 1e38f;
        }
        const int at = i % 4;
        c[at] = INFINITY;
        const mssm_roots3 a = mssm_solve_cubic(c[0], c[1], c[2], c[3]);
        c[at] = FLT_MAX;
        const mssm_roots3 b = mssm_solve_cubic(c[0], c[1], c[2], c[3]);
        c[at] = -INFINITY;
        const mssm_roots3 d = mssm_solve_cubic(c[0], c[1], c[2], c[3]);
        c[at] = -FLT_MAX;
        const mssm_roots3 e = mssm_solve_cubic(c[0], c[1], c[2], c[3]);
        c[at] = NAN;
        const mssm_roots3 n = mssm_solve_cubic(c[0], c[1], c[2], c[3]);
        CHECK(!memcmp(&a, &b, sizeof a) && !memcmp(&d, &e, sizeof d), "coefficient %d", at);
        CHECK(!memcmp(&n, &a, sizeof n) || !memcmp(&n, &d, sizeof n), "NaN as coefficient %d", at);
    }
}

// Roots of ordinary size under coefficients that are all huge or all tiny, and roots of any size.
static void cubic_huge_and_tiny(void)
{
    uint64_t state = 56;
    for (int i = 0; i < test_trials(40000); i++) {
        float c[4];
        double x[3];
        const double scale = exp(test_range(&state, log(1e-30), log(1e37)));
        for (int k = 0; k < 3; k++) x[k] = test_range(&state, -1, 1);
        coefficients_of_roots(x, scale, c);
        check_cubic(c, 1e-6);
        const double size = exp(test_range(&state, log(1e-9), log(1e9)));
        for (int k = 0; k < 3; k++) x[k] = size * test_range(&state, -1, 1);
        coefficients_of_roots(x, 1, c);
        check_cubic(c, 1e-6);
    }
}

// Roots of any size beside each other, down to 1e-28 of the largest, and coefficients up to
// FLT_MAX.
static void cubic_roots_far_apart(void)
{
    static const float cases[][4] = {
        {1e3f, -1e19f, 0, FLT_MAX},
        {-1.01062594e-19f, -9.49428891e-18f, 0.99999994f, 3.51274322e-11f},
        {FLT_MAX, 3.1e38f, -FLT_MAX, -3.2e38f},
        {0, 1e-25f, 1, 0},
        {0, 1e-25f, 1, 1e-10f},
        {0x1.5d5cbep-90f, 0x1.9d573ap-2f, -0x1.114ffap+0f, 0x1.6241bp-1f}}; // -2.7e-27 was 0
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) check_cubic(cases[i], 1e-6);
    uint64_t state = 58;
    int tried = 0;
    for (int i = 0; i < test_trials(80000); i++) {
        float c[4];
        double x[3], most = 0, product[4];
        x[0] = (i & 1 ? -1 : 1) * exp(test_range(&state, log(1e-10), log(1e17)));
        x[1] = (i & 2 ? -1 : 1) * fabs(x[0]) * exp(test_range(&state, log(1e-28), 0));
        x[2] = i % 3 == 0 ? x[1] * (1 + exp(test_range(&state, log(1e-7), 0)))
               : i % 3 == 1
                   ? -x[1] * (1 + test_range(&state, 0, 1e-6))
                   : (i & 4 ? -1 : 1) * fabs(x[0]) * exp(test_range(&state, log(1e-28), 0));
        if (i % 7 == 0) x[2] = 0;
        if (i % 9 == 2) x[1] = fabs(x[0]) * test_range(&state, 0.02, 1); // one far below two
        product[3] = 1;
        product[2] = -(x[0] + x[1] + x[2]);
        product[1] = x[0] * x[1] + x[0] * x[2] + x[1] * x[2];
        product[0] = -x[0] * x[1] * x[2];
        for (int k = 0; k < 4; k++) most = fmax(most, fabs(product[k]));
        const double scale = exp(test_range(&state, log(1e-2), log((double)FLT_MAX))) / most;
        int kept = 1;
        for (int k = 0; k < 4; k++) {
            c[k] = (float)(product[k] * scale);
            // Less than 1e-36 of the largest, or than 1e-38, may count as 0.
            const double size = fabs(product[k]);
            kept = kept && (size <= 0 || (size >= 1.1e-36 * most && size * scale > 1.2e-38));
        }
        if (!kept) continue;
        tried++;
        check_cubic(c, 1e-6);
    }
    CHECK(tried > test_trials(80000) / 4, "%d tried", tried);
}

// ---- reconstruction, blocker depth ---------------------------------------------------------

static void reconstruction_holds_moments(void)
{
    uint64_t state = 61;
    for (int format = 0; format < FORMATS; format++) {
        worst shares_off = {-1, 4, -1, 0, 0, {{0}}}, moments_off = shares_off,
              shares_wrong = shares_off;
        for (int i = 0; i < test_trials(12000); i++) {
            const int m = i & 1 ? 6 : 4;
            const float alpha = i % 6 < 4 ? safe_alpha(m, format) : 1e-3f;
            const patch p = random_patch(i / 2 % FAMILY_COUNT, &state);
            const moments b = biased(m, format, stored(&p, m, format), alpha);
            const float z = family_receiver(i % RECEIVER_COUNT, p.count, p.depth, &state);
            const nodes n = reconstructed(m, b, z);
            CHECK(finite_nodes(n), "shares or order of depths are broken");
            CHECK(n.z[0] >= z && n.z[0] <= z, "z[0] is %a for %a", (double)n.z[0], (double)z);
            double sum = 0;
            for (int k = 0; k < n.count; k++) sum += (double)n.w[k];
            keep_worst(&shares_off, fabs(sum - 1), m, p.family, alpha, b, z);
            for (int k = 1; k <= m; k++) {
                double mean = 0, size = 1;
                for (int j = 0; j < n.count; j++) {
                    const double term = (double)n.w[j] * pow((double)n.z[j], k);
                    mean += term;
                    size += fabs(term);
                }
                keep_worst(&moments_off, fabs(mean - (double)b.b[k - 1]) / size, m, p.family, alpha,
                           b, z);
            }
            // The shares nearer than z must agree with the bounds, which take another way.
            const mssm_bounds v = visibility(m, b, z);
            double nearer = 0;
            for (int k = 1; k < n.count; k++) nearer += n.z[k] < n.z[0] ? (double)n.w[k] : 0;
            keep_worst(&shares_wrong, fabs(1 - nearer - (double)v.upper), m, p.family, alpha, b, z);
        }
        test_note("%s", format_names[format]);
        note_worst("shares sum to 1 within", &shares_off);
        note_worst("moments, relative, within", &moments_off);
        note_worst("bounds within", &shares_wrong);
        CHECK(shares_off.error < 1e-6, "shares sum to 1 + %g", shares_off.error);
        CHECK(moments_off.error < 2e-3, "moments are off by %g", moments_off.error);
        CHECK(shares_wrong.error < 1e-5, "bounds are off by %g", shares_wrong.error);
    }
}

static void arrays_give_the_same(void)
{
    enum { N = 1000 };
    static float b[6][N], z[N], lower[N + 1], upper[N + 1];
    uint64_t state = 62;
    double error = 0;
    for (int round = 0; round < test_trials(40); round++) {
        const int m = round & 1 ? 6 : 4, garbage = round % 10 == 9;
        const int count = round < 4 ? round : N - (int)(test_random(&state) % 20);
        for (int i = 0; i < count; i++) {
            const patch p = random_patch(i % FAMILY_COUNT, &state);
            const int format = i % FORMATS;
            moments r = biased(m, format, stored(&p, m, format), safe_alpha(m, format));
            z[i] = family_receiver(i % RECEIVER_COUNT, p.count, p.depth, &state);
            for (int k = 0; k < m; k++) b[k][i] = garbage ? any_float(&state) : r.b[k];
        }
        const float *four_rows[4] = {b[0], b[1], b[2], b[3]};
        const float *six_rows[6] = {b[0], b[1], b[2], b[3], b[4], b[5]};
        lower[count] = upper[count] = -7;
        if (m == 4)
            mssm_visibility4_array(count, four_rows, z, lower, upper);
        else
            mssm_visibility6_array(count, six_rows, z, lower, upper);
        CHECK(lower[count] == -7 && upper[count] == -7, "writes past the end");
        for (int i = 0; i < count; i++) {
            moments r = {{0}};
            for (int k = 0; k < m; k++) r.b[k] = b[k][i];
            const mssm_bounds v = visibility(m, r, z[i]);
            const double e =
                fabs((double)v.lower - (double)lower[i]) + fabs((double)v.upper - (double)upper[i]);
            if (!garbage && e > error) error = e;
            CHECK(lower[i] >= 0 && lower[i] <= upper[i] && upper[i] <= 1,
                  "array bounds out of range");
        }
    }
    test_note("largest difference %.1e", error);
    // Equal but for contraction of a*b+c in one of the two.
    CHECK(error < 1e-3, "arrays differ from single calls by %g", error);
}

// Where a user's bias is too small, fewer moments are right where more are garbage.
static void too_small_a_bias_falls_back(void)
{
    uint64_t state = 63;
    for (int m = 4; m <= 6; m += 2) {
        double sum = 0;
        int count = 0, bad = 0;
        for (int i = 0; i < test_trials(60000); i++) {
            const float alpha = safe_alpha(m, FLOAT32) / (i % 2 ? 10 : 1000);
            patch p = random_patch(i % 3 ? FAMILY_FLAT : FAMILY_SLOPE, &state);
            float nearest = 2;
            for (int k = 0; k < p.count; k++) nearest = p.depth[k] < nearest ? p.depth[k] : nearest;
            const float z =
                nearest - (float)(i % 4 ? exp(test_range(&state, log(1e-7), log(1e-1))) : 0);
            const moments b = biased(m, FLOAT32, stored(&p, m, FLOAT32), alpha);
            const double dark = 1 - (double)visibility(m, b, z).upper;
            sum += dark;
            bad += dark > 0.01;
            count++;
        }
        test_note("%d moments, bias 10 and 1000 times too small: mean false shadow %.1e, over 1%% "
                  "in %d of %d",
                  m, sum / count, bad, count);
        CHECK(sum / count < 2e-3, "mean false shadow %g", sum / count);
    }
}

// With a wide bias nothing cancels: what is left is the error of the formulas themselves.
static void wide_bias_leaves_only_rounding(void)
{
    uint64_t state = 66;
    const worst none = {-1, 4, -1, 0, 0, {{0}}};
    worst bound = none, blocker = none, share = none, place = none;
    for (int i = 0; i < test_trials(12000); i++) {
        const int m = i & 1 ? 6 : 4;
        const float alpha = (float)test_range(&state, 0.1, 0.5);
        const patch p = random_patch(i / 2 % FAMILY_COUNT, &state);
        const moments b = biased(m, i % 4 < 2 ? FLOAT32 : UNORM16, stored(&p, m, FLOAT32), alpha);
        const float z = i % 5 ? family_receiver(i % RECEIVER_COUNT, p.count, p.depth, &state)
                              : (float)test_range(&state, -3, 3);
        const orthogonal o = orthogonal_of(m, b);
        const sharp_bounds s = oracle_bounds(&o, (quad)z);
        const mssm_bounds v = visibility(m, b, z);
        const double low = fabs((double)((quad)v.lower - s.lower));
        const double high = fabs((double)((quad)v.upper - s.upper));
        keep_worst(&bound, low > high ? low : high, m, p.family, alpha, b, z);
        const points r = oracle_points(&o, (quad)z);
        const nodes n = reconstructed(m, b, z);
        for (int k = 0; k < n.count && r.count == n.count; k++) {
            const double w = fabs((double)((quad)n.w[k] - r.w[k])), far = fabs((double)r.z[k]);
            keep_worst(&share, w, m, p.family, alpha, b, z);
            // Inverses of distances are what is solved for.
            const double off = fabs((double)((quad)n.z[k] - r.z[k])) / (1 + far * far);
            if (far < 100) keep_worst(&place, off, m, p.family, alpha, b, z);
        }
        if (z < -1 || z > 1) continue;
        quad exact = oracle_blocker_depth(&s, (quad)z, 1e-3L, 0.5L);
        exact = exact < -1 ? -1 : exact > (quad)z ? (quad)z : exact;
        const double depth = fabs((double)((quad)blocker_depth(m, b, z, 1e-3f, 0.5f) - exact));
        keep_worst(&blocker, depth * ((double)s.nearer + 1e-3), m, p.family, alpha, b, z);
    }
    note_worst("bounds off by", &bound);
    note_worst("blocker depth times share off by", &blocker);
    note_worst("shares off by", &share);
    note_worst("depths off by", &place);
    CHECK(bound.error < 2e-6 && blocker.error < 1e-6, "bounds off by %g, blocker depth by %g",
          bound.error, blocker.error);
    CHECK(share.error < 5e-5 && place.error < 5e-5, "shares off by %g, depths by %g", share.error,
          place.error);
}

// Bounds of the distribution's own variance alone (Cantelli): one other depth, beyond the mean.
static mssm_bounds bounds_of_variance(float mean, double variance, float z)
{
    const double u = (double)z - (double)mean, self = variance / (variance + u * u);
    const mssm_bounds r = {u > 0 ? 0 : (float)(1 - self), u > 0 ? (float)self : 1};
    return r;
}

// Shares that a reconstruction has next to a depth.
static double share_near(const nodes *n, double z)
{
    double share = 0;
    for (int k = 0; k < n->count; k++)
        share += fabs((double)n->z[k] - z) < 0.02 * (1 + z * z) ? (double)n->w[k] : 0;
    return share;
}

static void check_longest_valid_part(int m, int valid, moments b, double variance, double slack,
                                     const char *what)
{
    static const float at[] = {-1.2f, -0.9f, -0.37f, -0.01f, -2e-4f, 1e-5f,
                               6e-4f, 0.02f, 0.3f,   0.75f,  1.1f};
    const orthogonal o = orthogonal_of(valid > 2 ? valid : 4, b);
    for (size_t i = 0; i < sizeof at / sizeof *at; i++) {
        const mssm_bounds v = visibility(m, b, at[i]);
        const sharp_bounds s = oracle_bounds(&o, (quad)at[i]);
        const mssm_bounds flat = bounds_of_variance(b.b[0], variance, at[i]);
        const double lower = valid > 2 ? (double)s.lower : (double)flat.lower;
        const double upper = valid > 2 ? (double)s.upper : (double)flat.upper;
        CHECK(fabs((double)v.lower - lower) < slack && fabs((double)v.upper - upper) < slack,
              "%s: of %d moments %d hold, [%g, %g] at %g is not [%g, %g]", what, m, valid,
              (double)v.lower, (double)v.upper, (double)at[i], lower, upper);
        // The reconstruction holds the same depths; what it has more lies far away.
        const nodes n = reconstructed(m, b, at[i]);
        const points r = oracle_points(&o, (quad)at[i]);
        for (int k = 0; k < r.count && valid > 2; k++) {
            const double z = (double)r.z[k], want = (double)r.w[k], got = share_near(&n, z);
            if (fabs(z) < 10 && want > 0.05)
                CHECK(got > want - 0.03, "%s: %g at %g, not %g", what, got, z, want);
        }
        const double u = (double)at[i] - (double)b.b[0], z = (double)b.b[0] - variance / u;
        const double other = u * u / (variance + u * u), got = share_near(&n, z);
        if (valid == 2 && fabs(z) < 10)
            CHECK(got > other - 0.03, "%s: %g at %g, not %g", what, got, z, other);
    }
}

// Symmetric moments with chosen pivots D1 = b2, D2 = b4 - b2^2, D3 = b6 - b4^2/b2. Below half of
// what the safe bias leaves (docs/moments.md, "Bias"), with the smaller bias that fits a
// function, a pivot does not count.
static void pivots_below_half_the_bias_do_not_count(void)
{
    static const double parts[] = {-3, 0, 0.8, 1.25, 2, 4};
    const double d1[2] = {MSSM_BIAS4_FLOAT32 * 0.920, MSSM_BIAS6_FLOAT32 * 0.421};
    const double d2[2] = {MSSM_BIAS4_FLOAT32 * (3.804 - 0.920 * 0.920),
                          MSSM_BIAS6_FLOAT32 * (0.511 - 0.421 * 0.421)};
    const double d3 = MSSM_BIAS6_DECODED * (1.197 - 0.734 * 0.734 / 0.657);
    for (int i = 0; i < 6; i++) {
        const int holds = parts[i] > 1;
        for (int m = 4; m <= 6; m += 2) {
            const double least = 0.5 * d1[m == 6], variance = parts[i] * least;
            const moments flat = {{0, (float)variance, 0, 0, 0, 0}};
            check_longest_valid_part(m, 2, flat, holds ? variance : least, 0.01, "D1");
            const moments two = {
                {0, 0.0625f, 0, (float)(0.00390625 + 0.5 * parts[i] * d2[m == 6]), 0, 0}};
            check_longest_valid_part(m, holds ? 4 : 2, two, 0.0625, holds ? 0.02 : 1e-5, "D2");
        }
        const moments three = {{0, 0.25f, 0, 0.125f, 0, (float)(0.0625 + 0.5 * parts[i] * d3)}};
        check_longest_valid_part(6, holds ? 6 : 4, three, 0.25, holds ? 0.02 : 1e-5, "D3");
    }
}

// The upper bound at a depth z from the stored moments of one texel, next to no bias.
static float stored_upper(const mssm_map *map, int m, float z)
{
    static const float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1}, up[3] = {0, 1, 0},
                       x[3] = {1, 0, 0};
    mssm_light light;
    mssm_settings s = {0, MSSM_LOWER_BLOCKER, 1e-12f, 1e-12f, 0, 1e-9f};
    s.moments = m;
    CHECK(!mssm_light_directional(&light, up, x, 0, 0, low, high), "no light");
    light.world_to_shadow[6] = -1; // depth is -y
    light.world_to_shadow[14] = 0;
    const float p[3] = {0.5f, -z, 0.5f}; // over the middle of a texel
    return mssm_map_visibility(map, &light, &s, p);
}

// The moments that a table holds of these depths: Chebyshev moments rounded to 1/S, less 2.4e-7 of
// them.
static void moments_of_table(int count, const float *depth, quad b[7])
{
    const double scale = floor(2147483647.0 / (27 * 27)) - 5;
    quad t[7] = {1};
    for (int k = 1; k <= 6; k++) {
        double sum = 0;
        for (int i = 0; i < count; i++) sum += family_chebyshev(k, (double)depth[i]);
        t[k] = (quad)(floor(sum / count * scale + 0.5) / scale * (1 - 2.4e-7));
    }
    b[0] = 1;
    b[1] = t[1];
    b[2] = (1 + t[2]) / 2;
    b[3] = (3 * t[1] + t[3]) / 4;
    b[4] = (3 + 4 * t[2] + t[4]) / 8;
    b[5] = (10 * t[1] + 5 * t[3] + t[5]) / 16;
    b[6] = (10 + 15 * t[2] + 6 * t[4] + t[6]) / 32;
}

// Depths at -outer, -inner, inner and outer, of 4 samples `ends` at each end. Counts how many
// moments hold.
static void check_stored(int m, float outer, float inner, int ends, int tried[3])
{
    enum { samples = 4 };
    static float depth[4 * samples];
    const double alpha = m == 6 ? (double)MSSM_BIAS6_TABLE : (double)MSSM_BIAS4_TABLE;
    const double b2 = m == 6 ? 0.657 : 1.120, b4 = m == 6 ? 0.734 : 2.884;
    const double least[4] = {0, 0.5 * alpha * b2, 0.5 * alpha * (b4 - b2 * b2),
                             0.5 * alpha * (1.197 - b4 * b4 / b2)};
    const int exact = outer == 0.5f && inner == outer; // no polynomial is rounded
    quad b[7];
    for (int i = 0; i < 4 * samples; i++) {
        const int k = i % samples;
        depth[i] =
            (k < samples / 2 ? -1.0f : 1.0f) * (k < ends || k >= samples - ends ? outer : inner);
    }
    moments_of_table(4 * samples, depth, b);
    int valid = 1;
    const orthogonal all = orthogonal_of_moments(m, b);
    for (; valid <= m / 2; valid++) {
        const double pivot = (double)all.d[valid] / least[valid];
        // Rounding to the next integer decides; of six moments' D2 all that is below is noise.
        if ((pivot > 0.4 || (m == 6 && valid == 2 && !exact)) && pivot < 1.6) return;
        if (pivot < 1) break;
    }
    const double variance = valid == 1 ? least[1] : (double)b[2];
    valid = valid > 2 ? 2 * valid - 2 : 2;
    tried[valid / 2 - 1]++;
    const size_t bytes = mssm_map_bytes(2, m);
    void *memory = malloc(bytes);
    mssm_map *map;
    CHECK(memory && !mssm_map_init(&map, memory, bytes, 2, m) &&
              !mssm_map_update(map, depth, NULL, samples),
          "no map");
    const orthogonal o = orthogonal_of_moments(valid > 2 ? valid : 4, b);
    for (int i = -9; i <= 9; i += 2) {
        const float z = 0.3f * (float)i * (outer > 0 ? outer : 6e-4f);
        if (z > 0.9f) continue; // receivers further away are tested there
        const double want = valid > 2 ? (double)oracle_bounds(&o, (quad)z).upper
                                      : (double)bounds_of_variance((float)b[1], variance, z).upper;
        const double got = (double)stored_upper(map, m, z);
        if (got == 0 && z > outer) continue; // dark, and proved
        CHECK(fabs(got - want) < (exact ? 1e-3 : 0.07),
              "%d of %d moments hold, %g at %g is not %g (outer %g)", valid, m, got, (double)z,
              want, (double)outer);
    }
    free(memory);
}

// As "pivots below half the bias do not count", for what the tables hold.
static void stored_pivots_below_half_the_bias_do_not_count(void)
{
    for (int m = 4; m <= 6; m += 2) {
        int tried[3] = {0};
        check_stored(m, 0, 0, 2, tried);
        check_stored(m, 0.5f, 0.5f, 2, tried);
        for (float outer = 2e-4f; outer < 0.3f; outer *= 1.03f) {
            check_stored(m, outer, outer, 2, tried); // two depths: D1
            check_stored(m, outer, 0, 1, tried);     // three: D2 is a quarter of outer^4
            if (m == 6) check_stored(m, outer, 0.5f * outer, 1, tried);
        }
        test_note("%d moments: cases with 2, 4, 6 that hold: %d, %d, %d", m, tried[0], tried[1],
                  tried[2]);
        CHECK(tried[0] > 20 && tried[1] > 20 && tried[2] >= 5 * (m - 4), "too few cases");
    }
}

static void blocker_depth_matches_oracle(void)
{
    static const float self[3][2] = {{1e-3f, 1e-3f}, {1e-3f, 1}, {1e-3f, 0.1f}};
    uint64_t state = 64;
    for (int format = 0; format < FORMATS; format++) {
        worst w = {-1, 4, -1, 0, 0, {{0}}};
        for (int i = 0; i < test_trials(9000); i++) {
            const int m = i & 1 ? 6 : 4;
            const float alpha = i % 6 < 4 ? safe_alpha(m, format) : 1e-3f;
            const patch p = random_patch(i / 2 % FAMILY_COUNT, &state);
            const moments b = biased(m, format, stored(&p, m, format), alpha);
            float z = family_receiver(i % RECEIVER_COUNT, p.count, p.depth, &state);
            z = z < -1 ? -1 : z > 1 ? 1 : z;
            const orthogonal o = orthogonal_of(m, b);
            const sharp_bounds s = oracle_bounds(&o, (quad)z);
            for (int k = 0; k < 3; k++) {
                const float depth = blocker_depth(m, b, z, self[k][0], self[k][1]);
                quad exact = oracle_blocker_depth(&s, (quad)z, (quad)self[k][0], (quad)self[k][1]);
                exact = exact < -1 ? -1 : exact > (quad)z ? (quad)z : exact;
                CHECK(depth >= -1 && depth <= z, "%g is outside of [-1,%g]", (double)depth,
                      (double)z);
                const double error = fabs((double)((quad)depth - exact));
                // Where hardly anything is nearer, the share that is divides by the self weight.
                keep_worst(&w, error * (double)(s.nearer + (quad)self[k][0]), m, p.family, alpha, b,
                           z);
            }
            const float low = blocker_depth(m, b, z, 1e-3f, 1e-3f),
                        high = blocker_depth(m, b, z, 1e-3f, 1);
            CHECK(low <= high + 1e-6f, "lower %a above upper %a", (double)low, (double)high);
        }
        test_note("%s", format_names[format]);
        note_worst("depth times share off by", &w);
        CHECK(w.error <= limit_max[format], "blocker depth times share is off by %g", w.error);
    }
}

static void blocker_depth_of_few_blockers(void)
{
    uint64_t state = 65;
    double one = 0, two = 0;
    for (int i = 0; i < test_trials(40000); i++) {
        const int m = i & 1 ? 6 : 4;
        float z[4];
        double w[4];
        // The farthest depth receives, the others block.
        const int count = i & 2 ? 3 : 2;
        few_depths(count, &state, z, w);
        int last = 0;
        for (int k = 1; k < count; k++) last = z[k] > z[last] ? k : last;
        double nearer = 0, first = 0;
        for (int k = 0; k < count; k++) {
            nearer += k == last ? 0 : w[k];
            first += k == last ? 0 : w[k] * (double)z[k];
        }
        const moments b = biased(m, FLOAT32, moments_of(m, count, z, w), safe_alpha(m, FLOAT32));
        const double exact = (first + 1e-3 * (double)z[last]) / (nearer + 1e-3);
        const double error = fabs((double)blocker_depth(m, b, z[last], 1e-3f, 1e-3f) - exact);
        if (count == 2)
            one = error > one ? error : one;
        else
            two = error > two ? error : two;
    }
    test_note("one blocker to %.1e, two to %.1e", one, two);
    CHECK(one < 1e-3 && two < 1e-2, "blocker depth is off by %g for one and %g for two", one, two);
}

// ---- errata --------------------------------------------------------------------------------

// Image-based lighting paper, Eq. 19: the sum's upper limit is printed as m.
static void eq19_sums_over_half_plus_one(void)
{
    uint64_t state = 71;
    for (int i = 0; i < test_trials(2000); i++) {
        const int m = i & 1 ? 6 : 4;
        const patch p = random_patch(FAMILY_CONTINUUM, &state);
        const moments b = biased(m, FLOAT32, stored(&p, m, FLOAT32), 1e-4f);
        const float z = family_receiver(RECEIVER_INSIDE, p.count, p.depth, &state);
        const orthogonal o = orthogonal_of(m, b);
        const points r = oracle_points(&o, (quad)z);
        quad sum = 0;
        for (int k = 0; k < r.count; k++) sum += r.w[k];
        CHECK(r.count == m / 2 + 1 && r.count < m, "%d depths for %d moments", r.count, m);
        CHECK(quad_abs(sum - 1) < 1e-20L, "they do not hold all of the shares");
    }
    CHECK(sizeof(mssm_points3) == 6 * sizeof(float) && sizeof(mssm_points4) == 8 * sizeof(float),
          "mssm_points hold more than m/2 + 1 depths");
}

// Is alpha H(b*) + H(e) definite for every vertex e of a box of errors? powers: errors of b itself.
static int repairs_box(int m, const double even[3], int powers, double alpha)
{
    for (int v = 0; v < 1 << m; v++) {
        quad b[7], e[7] = {0};
        for (int k = 1; k <= m; k++) e[k] = v >> (k - 1) & 1 ? 2 : -2; // an error of 1 in (T+1)/2
        b[0] = (quad)alpha;
        b[1] = e[1];
        b[2] = powers ? e[2] : e[2] / 2;
        b[3] = powers ? e[3] : (3 * e[1] + e[3]) / 4;
        b[4] = powers ? e[4] : (4 * e[2] + e[4]) / 8;
        b[5] = powers ? e[5] : (10 * e[1] + 5 * e[3] + e[5]) / 16;
        b[6] = powers ? e[6] : (15 * e[2] + 6 * e[4] + e[6]) / 32;
        for (int k = 0; k < 3; k++) b[2 * k + 2] += (quad)(alpha * even[k]);
        if (orthogonal_of_moments(m, b).rank != m / 2 + 1) return 0;
    }
    return 1;
}

// GDC slides: storage needs a numerically optimized transform. The Chebyshev basis amplifies
// storage errors into bias as little (the optimized ones by 2.47 and 4.23), powers by far more.
static void chebyshev_basis_amplifies_little(void)
{
    static const struct {
        int m, powers;
        double even[3], amplification;
    } cases[] = {{4, 0, {1.120, 2.884, 0}, 2.430}, {6, 0, {0.657, 0.734, 1.197}, 4.544},
                 {4, 1, {0.920, 3.804, 0}, 3.971}, {6, 1, {0.421, 0.511, 1.913}, 18.14},
                 {4, 0, {0.628, 0.628, 0}, 5.003}, {6, 0, {0.5566, 0.489, 0.47869382}, 8.471},
                 {4, 1, {1.120, 2.884, 0}, 6.155}, {6, 1, {0.657, 0.734, 1.197}, 37.04}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const double a = cases[i].amplification;
        CHECK(repairs_box(cases[i].m, cases[i].even, cases[i].powers, a * 1.001), "more than %g",
              a);
        CHECK(!repairs_box(cases[i].m, cases[i].even, cases[i].powers, a * 0.999), "less than %g",
              a);
    }
}

const test_case moments_tests[] = {
    {"moments: the oracle's depths hold the moments", oracle_reproduces_moments},
    {"moments: bounds match the sharp bounds in quad precision", bounds_match_oracle},
    {"moments: bounds enclose the truth at the safe bias", bounds_enclose_truth},
    {"moments: bounds enclose the biased distribution", bounds_enclose_biased_distribution},
    {"moments: bounds are ordered and in range at any bias", bounds_in_range_at_any_bias},
    {"moments: garbage gives ordered bounds in range", garbage_keeps_bounds_in_range},
    {"moments: garbage gives finite output everywhere", garbage_keeps_everything_finite},
    {"moments: NaN and infinity give finite output", nan_and_infinity_become_finite},
    {"moments: a lone surface is shadowed by at most the bias", lone_surface_is_lit},
    {"moments: bounds fall with the receiver's depth", bounds_fall_with_depth},
    {"moments: mirrored depths swap the bounds", mirror_swaps_bounds},
    {"moments: two, three and four exact depths are reproduced", exact_depths_are_reproduced},
    {"moments: of depth are powers", moments_of_depth_are_powers},
    {"moments: decode undoes encode, four are a prefix of six", decode_undoes_encode},
    {"moments: bias pulls to its vector", bias_pulls_to_its_vector},
    {"cubic: random roots and coefficients", cubic_random},
    {"cubic: nearly equal roots", cubic_near_equal_roots},
    {"cubic: no pair is lost to rounding", cubic_loses_no_pair},
    {"cubic: triple roots", cubic_triple_roots},
    {"cubic: vanishing leading coefficients", cubic_degenerate},
    {"cubic: infinite coefficients are the largest", infinite_coefficients_are_the_largest},
    {"cubic: roots beyond 1e18 are infinite", roots_beyond_1e18_are_infinite},
    {"cubic: huge and tiny", cubic_huge_and_tiny},
    {"cubic: roots far apart", cubic_roots_far_apart},
    {"moments: the reconstruction holds shares, order and moments", reconstruction_holds_moments},
    {"moments: arrays give what single calls give", arrays_give_the_same},
    {"moments: too small a bias falls back to fewer moments", too_small_a_bias_falls_back},
    {"moments: pivots below half the bias do not count", pivots_below_half_the_bias_do_not_count},
    {"moments: stored pivots below half the bias do not count",
     stored_pivots_below_half_the_bias_do_not_count},
    {"moments: a wide bias leaves only rounding", wide_bias_leaves_only_rounding},
    {"moments: blocker depth matches Eq. 7 and 19", blocker_depth_matches_oracle},
    {"moments: one or two blockers are found exactly", blocker_depth_of_few_blockers},
    {"erratum: Eq. 19 sums over m/2 + 1 depths, not m", eq19_sums_over_half_plus_one},
    {"erratum: the Chebyshev basis amplifies errors little", chebyshev_basis_amplifies_little},
    {NULL, NULL}};
