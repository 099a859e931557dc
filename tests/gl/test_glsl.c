// The GLSL text of both headers, compiled and run by this machine's driver, against the C code.
//
// Equal text is not equal arithmetic: a compiler may fuse a*b + c, reorder, or round a quotient
// differently, on either side. So a result may differ from C's by AGREEMENT, and by more only at a
// limit: where C itself answers that differently once an input moves by its last bits (a branch is
// taken the other way, or moments with hardly any bias make the problem that ill-conditioned).
// Where both sides round alike, such inputs must be next to none.
#include "../support/gl_test.h"
#include "../support/test.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../examples/common/gl_context.h"
#include "../../lightprobe.h"
#include "../../mssm.h"

#define AGREEMENT 1e-5f

enum { WIDTH = 8, GROUP = 64 }; // floats an input and a result; invocations a work group
enum { SEED = 20240229, MILLION = 1 << 20 };

// ---- Inputs ----
//
// An input is the moments (a[0] ... a[5]), the receiver's depth (a[6]) and the bias (a[7]), or what
// the function takes, from a[0] on.

static mssm_moments4 moments4(const float *a)
{
    mssm_moments4 m;
    memcpy(m.b, a, sizeof m.b);
    return m;
}

static mssm_moments6 moments6(const float *a)
{
    mssm_moments6 m;
    memcpy(m.b, a, sizeof m.b);
    return m;
}

// Random depths of one filter region; returns how many.
static int random_depths(uint64_t *seed, double *z, double *weight)
{
    const int family = (int)test_range(seed, 0, 6);
    const double base = test_range(seed, -1, 1), spread = pow(10, test_range(seed, -7, 0.3));
    // One depth; two, from far to nearly equal; three layers; a slope; foliage; one outlier.
    const int n = family < 3 ? family + 1 : (int)test_range(seed, 4, 17);
    double sum = 0;
    for (int i = 0; i < n; i++) {
        z[i] = family == 1        ? base + i * spread
               : family == 3      ? base + spread * (i - 0.5 * n) / n
               : family == 5 && i ? base + 1e-3 * test_range(seed, -1, 1)
                                  : test_range(seed, -1, 1);
        z[i] = z[i] < -1 ? -1 : z[i] > 1 ? 1 : z[i];
        weight[i] = family == 3 || family == 4 ? 1 : family == 5 && !i ? 0.02 : test_uniform(seed);
        sum += weight[i] += 1e-6;
    }
    if (family == 0 && test_uniform(seed) < 0.3) z[0] = (int)test_range(seed, 0, 3) - 1;
    for (int i = 0; i < n; i++) weight[i] /= sum;
    return n;
}

// Moments of such a region, stored in float32, in 16 bits or in a table, with the safe bias of that
// format, a larger one or now and then none, and a receiver in and around it.
static void random_receiver(uint64_t *seed, float *a, bool four)
{
    static const float safe[2][3] = {{MSSM_BIAS4_FLOAT32, MSSM_BIAS4_UNORM16, MSSM_BIAS4_DECODED},
                                     {MSSM_BIAS6_FLOAT32, MSSM_BIAS6_UNORM16, MSSM_BIAS6_DECODED}};
    static const float strength[3] = {1, 30, 0};
    const double step[3] = {0, 1.0 / 65535, 27 * 27 / 4294967295.0};
    double z[17], weight[17], b[6] = {0};
    const int n = random_depths(seed, z, weight), format = (int)test_range(seed, 0, 3);
    for (int i = 0; i < n; i++) {
        double power = weight[i];
        for (int k = 0; k < 6; k++) b[k] += power *= z[i];
    }
    mssm_moments6 m;
    for (int k = 0; k < 6; k++) m.b[k] = (float)b[k];
    if (format) {
        m = mssm_moments6_encode(m);
        for (int k = 0; k < 6; k++)
            m.b[k] = (float)(step[format] * floor(m.b[k] / step[format] + 0.5));
        m = mssm_moments6_decode(m);
    }
    a[7] = safe[!four][format] * strength[(int)test_range(seed, 0, 2.1)];
    if (four) {
        mssm_moments4 m4 = moments4(m.b);
        m4 = format ? mssm_moments4_bias_encoded(m4, a[7]) : mssm_moments4_bias(m4, a[7]);
        memcpy(a, m4.b, sizeof m4.b);
        a[4] = a[5] = 0;
    } else {
        m = format ? mssm_moments6_bias_encoded(m, a[7]) : mssm_moments6_bias(m, a[7]);
        memcpy(a, m.b, sizeof m.b);
    }
    const double kind = test_uniform(seed), sign = test_uniform(seed) < 0.5 ? -1 : 1;
    const double near = z[(int)test_range(seed, 0, n)];
    a[6] = (float)(kind < 0.1   ? near
                   : kind < 0.5 ? near + sign * pow(10, test_range(seed, -7, -1.5))
                   : kind < 0.6 ? test_range(seed, -1.2, 1.2)
                                : test_range(seed, -1, 1));
}

static void random_receiver4(uint64_t *seed, float *a)
{
    random_receiver(seed, a, true);
}

static void random_receiver6(uint64_t *seed, float *a)
{
    random_receiver(seed, a, false);
}

// Finite numbers of any size, and small ones that are no moments of anything.
static void random_garbage(uint64_t *seed, float *a)
{
    const double size = test_uniform(seed) < 0.5 ? 0.3 : test_range(seed, -44, 38);
    for (int k = 0; k < WIDTH; k++) {
        a[k] = (float)(test_range(seed, -1, 1) * pow(10, size));
        if (test_uniform(seed) < 0.05) a[k] = (float)((int)test_range(seed, 0, 3) - 1);
    }
    if (test_uniform(seed) < 0.5) a[6] = (float)test_range(seed, -1, 1);
}

// Cubics with three real roots, some close together, or with one, or of lower degree.
static void random_cubic(uint64_t *seed, float *a)
{
    double x[3], scale = pow(10, test_range(seed, -3, 3));
    const double kind = test_uniform(seed), gap = pow(10, test_range(seed, -6, 0));
    for (int k = 0; k < 3; k++) x[k] = test_range(seed, -1, 1);
    if (kind < 0.3) x[1] = x[0] + gap;
    if (kind < 0.1) x[2] = x[0] - gap;
    memset(a, 0, sizeof *a * WIDTH);
    if (kind < 0.8) {
        a[0] = (float)(-scale * x[0] * x[1] * x[2]);
        a[1] = (float)(scale * (x[0] * x[1] + x[0] * x[2] + x[1] * x[2]));
        a[2] = (float)(-scale * (x[0] + x[1] + x[2]));
        a[3] = (float)scale;
    } else {
        for (int k = 0; k < 4; k++) a[k] = (float)(scale * test_range(seed, -1, 1));
        if (kind > 0.9) a[3] *= kind > 0.95 ? 0 : (float)gap;
    }
}

static void random_disc(uint64_t *seed, float *a)
{
    memset(a, 0, sizeof *a * WIDTH);
    for (int k = 0; k < 2; k++) a[k] = (float)test_range(seed, -1, 1);
    const double kind = test_uniform(seed);
    if (kind < 0.3) a[0] = (float)cos(pow(10, test_range(seed, -4, 0))); // small discs
    if (kind < 0.1) a[1] = (float)(test_range(seed, -2, 2) * sqrt(1 - a[0] * a[0]));
    if (kind > 0.95) a[0] = (float)((int)test_range(seed, 0, 3) - 1);
    if (kind > 0.98) a[1] = (float)((int)test_range(seed, 0, 3) - 1);
    a[1] = fmaxf(-1, fminf(1, a[1]));
}

// ---- The two sides ----

typedef struct kind {
    bool (*promise)(const float *a, const float *r);       // what holds for any finite input
    float (*distance)(const float *r, const float *other); // of two results that keep it
    float own_error;                                       // C's own, where that may be larger
} kind;

typedef struct function {
    const char *name;
    int results;
    void (*input)(uint64_t *seed, float *a);
    void (*c)(const float *a, float *r);
    const kind *kind;
    const char *glsl;
} function;

static void of_depth4(const float *a, float *r)
{
    const mssm_moments4 m = mssm_moments4_of_depth(a[6]);
    memcpy(r, m.b, sizeof m.b);
}

static void of_depth6(const float *a, float *r)
{
    const mssm_moments6 m = mssm_moments6_of_depth(a[6]);
    memcpy(r, m.b, sizeof m.b);
}

static void bias4(const float *a, float *r)
{
    const mssm_moments4 m = mssm_moments4_bias(moments4(a), a[7]);
    memcpy(r, m.b, sizeof m.b);
}

static void bias6(const float *a, float *r)
{
    const mssm_moments6 m = mssm_moments6_bias(moments6(a), a[7]);
    memcpy(r, m.b, sizeof m.b);
}

static void bias_encoded4(const float *a, float *r)
{
    const mssm_moments4 m = mssm_moments4_bias_encoded(moments4(a), a[7]);
    memcpy(r, m.b, sizeof m.b);
}

static void bias_encoded6(const float *a, float *r)
{
    const mssm_moments6 m = mssm_moments6_bias_encoded(moments6(a), a[7]);
    memcpy(r, m.b, sizeof m.b);
}

static void encode4(const float *a, float *r)
{
    const mssm_moments4 q = mssm_moments4_encode(moments4(a));
    memcpy(r, q.b, sizeof q.b);
}

static void encode6(const float *a, float *r)
{
    const mssm_moments6 q = mssm_moments6_encode(moments6(a));
    memcpy(r, q.b, sizeof q.b);
}

static void decode4(const float *a, float *r)
{
    const mssm_moments4 m = mssm_moments4_decode(mssm_moments4_encode(moments4(a)));
    memcpy(r, m.b, sizeof m.b);
}

static void decode6(const float *a, float *r)
{
    const mssm_moments6 m = mssm_moments6_decode(mssm_moments6_encode(moments6(a)));
    memcpy(r, m.b, sizeof m.b);
}

static void visibility4(const float *a, float *r)
{
    const mssm_bounds v = mssm_visibility4(moments4(a), a[6]);
    r[0] = v.lower;
    r[1] = v.upper;
}

static void visibility6(const float *a, float *r)
{
    const mssm_bounds v = mssm_visibility6(moments6(a), a[6]);
    r[0] = v.lower;
    r[1] = v.upper;
}

static void reconstruct4(const float *a, float *r)
{
    const mssm_points3 p = mssm_reconstruct4(moments4(a), a[6]);
    memcpy(r, p.z, sizeof p.z);
    memcpy(r + 3, p.w, sizeof p.w);
}

static void reconstruct6(const float *a, float *r)
{
    const mssm_points4 p = mssm_reconstruct6(moments6(a), a[6]);
    memcpy(r, p.z, sizeof p.z);
    memcpy(r + 4, p.w, sizeof p.w);
}

static void blocker_depth4(const float *a, float *r)
{
    r[0] = mssm_blocker_depth4(moments4(a), a[6], 1e-3f, 1e-3f);
    r[1] = mssm_blocker_depth4(moments4(a), a[6], 1e-3f, 1.0f);
}

static void blocker_depth6(const float *a, float *r)
{
    r[0] = mssm_blocker_depth6(moments6(a), a[6], 1e-3f, 1e-3f);
    r[1] = mssm_blocker_depth6(moments6(a), a[6], 1e-3f, 1.0f);
}

static void solve_cubic(const float *a, float *r)
{
    const mssm_roots3 x = mssm_solve_cubic(a[0], a[1], a[2], a[3]);
    memcpy(r, x.x, sizeof x.x);
    r[3] = (float)x.count;
}

static void disc_irradiance(const float *a, float *r)
{
    r[0] = lightprobe_disc_irradiance(a[0], a[1]);
}

static void multiply_add(const float *a, float *r)
{
    r[0] = a[0] * a[1] + a[2];
}

// ---- What the interface promises; a comparison with NaN is false ----

static bool all_finite(const float *a, const float *r)
{
    (void)a;
    for (int k = 0; k < WIDTH; k++)
        if (!isfinite(r[k])) return false;
    return true;
}

static bool all_in_unit(const float *a, const float *r)
{
    (void)a;
    for (int k = 0; k < WIDTH; k++)
        if (!(r[k] >= 0 && r[k] <= 1)) return false;
    return true;
}

static bool ordered_bounds(const float *a, const float *r)
{
    (void)a;
    return r[0] >= 0 && r[0] <= r[1] && r[1] <= 1;
}

static bool blockers_before_receiver(const float *a, const float *r)
{
    const float z = fmaxf(a[6], -1);
    return r[0] >= -1 && r[0] <= z && r[1] >= -1 && r[1] <= z;
}

static bool shares3(const float *a, const float *r)
{
    return all_finite(a, r) && r[1] <= r[2] &&
           all_in_unit(a, (const float[WIDTH]){r[3], r[4], r[5]});
}

static bool shares4(const float *a, const float *r)
{
    return all_finite(a, r) && r[1] <= r[2] && r[2] <= r[3] &&
           all_in_unit(a, (const float[WIDTH]){r[4], r[5], r[6], r[7]});
}

static bool ascending_roots(const float *a, const float *r)
{
    return all_finite(a, r) && r[3] >= 0 && r[3] <= 3 && (r[3] < 2 || r[0] <= r[1]) &&
           (r[3] < 3 || r[1] <= r[2]);
}

// ---- How far two results are apart ----

static float largest_difference(const float *r, const float *other)
{
    float largest = 0;
    for (int k = 0; k < WIDTH; k++) largest = fmaxf(largest, fabsf(r[k] - other[k]));
    return largest;
}

// Share that lies before x.
static float share_before(const float *z, const float *w, int n, float x)
{
    float sum = 0;
    for (int k = 0; k < n; k++) sum += z[k] < x ? w[k] : 0;
    return sum;
}

// Area between the cumulative shares of two distributions of n depths each: what has to be carried
// how far to turn one into the other. Depths with next to no share may lie anywhere; those outside
// of [-2,2] count as there.
static float earth_moved(const float *r, const float *other, int n)
{
    float x[WIDTH], moved = 0;
    for (int k = 0; k < 2 * n; k++) {
        const float z = fmaxf(-2, fminf(2, k < n ? r[k] : other[k - n]));
        int at = k;
        for (; at > 0 && x[at - 1] > z; at--) x[at] = x[at - 1];
        x[at] = z;
    }
    for (int k = 1; k < 2 * n; k++) {
        const float middle = 0.5f * x[k - 1] + 0.5f * x[k];
        const float shares = share_before(r, r + n, n, middle);
        moved += (x[k] - x[k - 1]) * fabsf(shares - share_before(other, other + n, n, middle));
    }
    return moved;
}

static float earth_moved3(const float *r, const float *other)
{
    return earth_moved(r, other, 3);
}

static float earth_moved4(const float *r, const float *other)
{
    return earth_moved(r, other, 4);
}

// Largest distance of a root of one cubic from the nearest of the other, on a sphere: infinity is a
// root of both, so one that runs away as the leading coefficient goes to 0 is no jump.
static float root_distance(const float *r, const float *other)
{
    float largest = 0;
    for (int side = 0; side < 2; side++) {
        const float *p = side ? other : r, *q = side ? r : other;
        for (int i = 0; i < (int)p[3]; i++) {
            float nearest = 1 / hypotf(1, p[i]);
            for (int k = 0; k < (int)q[3]; k++)
                nearest = fminf(nearest, fabsf(p[i] - q[k]) / hypotf(1, p[i]) / hypotf(1, q[k]));
            largest = fmaxf(largest, nearest);
        }
    }
    return largest;
}

static const kind numbers = {all_finite, largest_difference, 0};
static const kind in_unit = {all_in_unit, largest_difference, 0};
static const kind bounds = {ordered_bounds, largest_difference, 0};
static const kind blockers = {blockers_before_receiver, largest_difference, 0};
// Two depths close to each other and far from the receiver: the mean of their distribution is up to
// 7e-4 off (3 in a million inputs).
static const kind points3 = {shares3, earth_moved3, 2e-3f};
static const kind points4 = {shares4, earth_moved4, 2e-3f};
static const kind roots = {ascending_roots, root_distance, 0};

#define TO_R4 "for (int k = 0; k < 4; k++) r[k] = m.b[k];"
#define TO_R6 "for (int k = 0; k < 6; k++) r[k] = m.b[k];"

static const function storage_functions[] = {
    {"mssm_moments4_of_depth", 4, random_receiver4, of_depth4, &numbers,
     "mssm_moments4 m = mssm_moments4_of_depth(a[6]);" TO_R4},
    {"mssm_moments6_of_depth", 6, random_receiver6, of_depth6, &numbers,
     "mssm_moments6 m = mssm_moments6_of_depth(a[6]);" TO_R6},
    {"mssm_moments4_bias", 4, random_receiver4, bias4, &numbers,
     "mssm_moments4 m = mssm_moments4_bias(m4, a[7]);" TO_R4},
    {"mssm_moments6_bias", 6, random_receiver6, bias6, &numbers,
     "mssm_moments6 m = mssm_moments6_bias(m6, a[7]);" TO_R6},
    {"mssm_moments4_bias_encoded", 4, random_receiver4, bias_encoded4, &numbers,
     "mssm_moments4 m = mssm_moments4_bias_encoded(m4, a[7]);" TO_R4},
    {"mssm_moments6_bias_encoded", 6, random_receiver6, bias_encoded6, &numbers,
     "mssm_moments6 m = mssm_moments6_bias_encoded(m6, a[7]);" TO_R6},
    {"mssm_moments4_encode", 4, random_receiver4, encode4, &in_unit,
     "mssm_moments4 m = mssm_moments4_encode(m4);" TO_R4},
    {"mssm_moments6_encode", 6, random_receiver6, encode6, &in_unit,
     "mssm_moments6 m = mssm_moments6_encode(m6);" TO_R6},
    {"mssm_moments4_decode", 4, random_receiver4, decode4, &numbers,
     "mssm_moments4 m = mssm_moments4_decode(mssm_moments4_encode(m4));" TO_R4},
    {"mssm_moments6_decode", 6, random_receiver6, decode6, &numbers,
     "mssm_moments6 m = mssm_moments6_decode(mssm_moments6_encode(m6));" TO_R6},
    {0}};

static const function bound_functions[] = {
    {"mssm_visibility4", 2, random_receiver4, visibility4, &bounds,
     "mssm_bounds v = mssm_visibility4(m4, a[6]); r[0] = v.lower; r[1] = v.upper;"},
    {"mssm_visibility6", 2, random_receiver6, visibility6, &bounds,
     "mssm_bounds v = mssm_visibility6(m6, a[6]); r[0] = v.lower; r[1] = v.upper;"},
    {0}};

static const function blocker_functions[] = {
    {"mssm_blocker_depth4", 2, random_receiver4, blocker_depth4, &blockers,
     "r[0] = mssm_blocker_depth4(m4, a[6], 1e-3, 1e-3);"
     "r[1] = mssm_blocker_depth4(m4, a[6], 1e-3, 1.0);"},
    {"mssm_blocker_depth6", 2, random_receiver6, blocker_depth6, &blockers,
     "r[0] = mssm_blocker_depth6(m6, a[6], 1e-3, 1e-3);"
     "r[1] = mssm_blocker_depth6(m6, a[6], 1e-3, 1.0);"},
    {0}};

static const function reconstruct_functions[] = {
    {"mssm_reconstruct4", 6, random_receiver4, reconstruct4, &points3,
     "mssm_points3 p = mssm_reconstruct4(m4, a[6]);"
     "for (int k = 0; k < 3; k++) { r[k] = p.z[k]; r[3 + k] = p.w[k]; }"},
    {"mssm_reconstruct6", 8, random_receiver6, reconstruct6, &points4,
     "mssm_points4 p = mssm_reconstruct6(m6, a[6]);"
     "for (int k = 0; k < 4; k++) { r[k] = p.z[k]; r[4 + k] = p.w[k]; }"},
    {0}};

static const function cubic_functions[] = {
    {"mssm_solve_cubic", 4, random_cubic, solve_cubic, &roots,
     "mssm_roots3 x = mssm_solve_cubic(a[0], a[1], a[2], a[3]);"
     "for (int k = 0; k < 3; k++) r[k] = x.x[k];"
     "r[3] = float(x.count);"},
    {0}};

static const function disc_functions[] = {{"lightprobe_disc_irradiance", 1, random_disc,
                                           disc_irradiance, &in_unit,
                                           "r[0] = lightprobe_disc_irradiance(a[0], a[1]);"},
                                          {0}};

// ---- Running a shader ----

static GLuint compute_program(const function *f)
{
    char main_text[2000];
    const char *const text[] = {mssm_glsl_math(), lightprobe_glsl_math(), main_text, NULL};
    snprintf(main_text, sizeof main_text,
             "layout(local_size_x = %d) in;\n"
             "layout(std430, binding = 0) readonly buffer inputs { float input_[]; };\n"
             "layout(std430, binding = 1) writeonly buffer results { float result[]; };\n"
             "void main()\n"
             "{\n"
             "    uint first = %du * gl_GlobalInvocationID.x;\n"
             "    float a[%d], r[%d];\n"
             "    for (int k = 0; k < %d; k++) { a[k] = input_[first + uint(k)]; r[k] = 0.0; }\n"
             "    mssm_moments4 m4;\n"
             "    mssm_moments6 m6;\n"
             "    for (int k = 0; k < 4; k++) m4.b[k] = a[k];\n"
             "    for (int k = 0; k < 6; k++) m6.b[k] = a[k];\n"
             "    %s\n"
             "    for (int k = 0; k < %d; k++) result[first + uint(k)] = r[k];\n"
             "}\n",
             GROUP, WIDTH, WIDTH, WIDTH, WIDTH, f->glsl, WIDTH);
    return gl_test_compute(f->name, text);
}

// results[i] = f(inputs[i]) by the GPU. count is a multiple of GROUP.
static bool run_shader(const function *f, const float *inputs, float *results, int count)
{
    const GLsizeiptr bytes = (GLsizeiptr)sizeof(float) * WIDTH * count;
    const GLuint program = compute_program(f);
    if (!program) return false;
    GLuint buffers[2];
    gl.CreateBuffers(2, buffers);
    gl.NamedBufferStorage(buffers[0], bytes, inputs, 0);
    gl.NamedBufferStorage(buffers[1], bytes, NULL, 0);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffers[0]);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, buffers[1]);
    gl.UseProgram(program);
    gl.DispatchCompute((GLuint)(count / GROUP), 1, 1);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl.GetNamedBufferSubData(buffers[1], 0, bytes, results);
    gl.DeleteBuffers(2, buffers);
    gl.DeleteProgram(program);
    const GLenum error = gl.GetError();
    CHECK(error == GL_NO_ERROR, "%s: GL error 0x%04x", f->name, error);
    return error == GL_NO_ERROR;
}

// ---- Comparing ----

// Do C's results at the neighbouring inputs account for the GPU's, which is d away from c?
// Neighbours: one input moved up or down by 1, 2, 4 or 8 of its last bits. A fused multiply-add or
// another quotient on one side is as if several inputs moved at once, hence the factor 4: with C
// fused and llvmpipe not, 1.9 was needed (mssm_reconstruct6, a million inputs). Where a
// GPU's quotients are not exact, also by the last bit of 1: so much moves what they are added to.
static bool at_limit(const function *f, const float *a, const float *c, float d, bool exact)
{
    float largest = 0;
    for (int move = 0; move < (exact ? 8 : 10) * WIDTH; move++) {
        float b[WIDTH], r[WIDTH] = {0};
        memcpy(b, a, sizeof b);
        float *moved = &b[move % WIDTH];
        const int step = move / WIDTH;
        if (step >= 8) *moved += step % 2 ? FLT_EPSILON : -FLT_EPSILON;
        for (int bits = step < 8 ? 1 << step / 2 : 0; bits > 0; bits--)
            *moved = nextafterf(*moved, step % 2 ? INFINITY : -INFINITY);
        f->c(b, r);
        largest = fmaxf(largest, f->kind->distance(c, r));
    }
    return d <= AGREEMENT + 4 * largest;
}

static void print_case(const function *f, const float *a, const float *c, const float *g)
{
    test_note("  %s of %a, %a, %a, %a, %a, %a, %a, %a", f->name, a[0], a[1], a[2], a[3], a[4], a[5],
              a[6], a[7]);
    test_note("    C    %.9g, %.9g, %.9g, %.9g, %.9g, %.9g, %.9g, %.9g", c[0], c[1], c[2], c[3],
              c[4], c[5], c[6], c[7]);
    test_note("    GLSL %.9g, %.9g, %.9g, %.9g, %.9g, %.9g, %.9g, %.9g", g[0], g[1], g[2], g[3],
              g[4], g[5], g[6], g[7]);
}

// Inputs of one family, and what the GPU makes of them.
typedef struct batch {
    int count;
    float *inputs, *results;
} batch;

static batch make_batch(void (*input)(uint64_t *seed, float *a), int count)
{
    batch b;
    uint64_t seed = SEED;
    b.count = (test_trials(count) + GROUP - 1) / GROUP * GROUP;
    b.inputs = malloc(sizeof(float) * WIDTH * (size_t)b.count);
    b.results = malloc(sizeof(float) * WIDTH * (size_t)b.count);
    for (int i = 0; i < b.count; i++) input(&seed, b.inputs + WIDTH * i);
    return b;
}

static void free_batch(batch b)
{
    free(b.inputs);
    free(b.results);
}

// Checks the promise for every result; prints the first few that break it.
static void check_promise(const function *f, batch b)
{
    int broken = 0;
    for (int i = 0; i < b.count; i++) {
        const float *a = b.inputs + WIDTH * i, *g = b.results + WIDTH * i;
        float c[WIDTH] = {0};
        if (f->kind->promise(a, g) || broken++ >= 3) continue;
        f->c(a, c);
        print_case(f, a, c, g);
    }
    CHECK(!broken, "%s breaks its promise for %d of %d inputs", f->name, broken, b.count);
}

// Checks that all results agree but at limits, and that at most the share `limits` are at limits.
// With quotients and roots that are two units off, two of a million blocker depths were 9e-5 and
// 3e-4 off beyond what their inputs' last bits explain.
static void check_agreement(const function *f, batch b, double limits, bool exact)
{
    const int others = exact ? 0 : 1 + b.count / 100000;
    int same = 0, limit = 0, bad = 0, worst_at = 0;
    float c[WIDTH] = {0}, worst = 0, worst_limit = 0;
    for (int i = 0; i < b.count; i++) {
        const float *a = b.inputs + WIDTH * i, *g = b.results + WIDTH * i;
        f->c(a, c);
        const float d = f->kind->distance(c, g);
        same += d <= 0;
        if (d <= AGREEMENT) {
            worst_at = d > worst ? i : worst_at;
            worst = fmaxf(d, worst);
        } else if (d <= f->kind->own_error || at_limit(f, a, c, d, exact)) {
            worst_limit = fmaxf(d, worst_limit);
            limit++;
        } else {
            CHECK(++bad <= others && d < 1e-3f, "%s differs by %g for input %d of seed %d", f->name,
                  d, i, SEED);
            if (bad <= 3) print_case(f, a, c, g);
        }
    }
    test_note("%-26s equal %6.2f%%, worst %.2g; at limits %.4f%%, worst %.2g", f->name,
              100.0 * same / b.count, worst, 100.0 * limit / b.count, worst_limit);
    if (worst > 1e-6f) {
        f->c(b.inputs + WIDTH * worst_at, c);
        print_case(f, b.inputs + WIDTH * worst_at, c, b.results + WIDTH * worst_at);
    }
    CHECK(limit <= limits * b.count, "%s: %d of %d inputs are at limits", f->name, limit, b.count);
}

// Does one side fuse a*b + c where the other does not? Then ill-conditioned inputs show it.
static bool rounds_alike(void)
{
    static const char *const body = "r[0] = a[0] * a[1] + a[2];";
    const function sum = {"a*b + c", 1, random_disc, multiply_add, &numbers, body};
    float a[WIDTH * GROUP] = {0}, g[WIDTH * GROUP], c[WIDTH] = {0};
    a[0] = 1 + FLT_EPSILON;
    a[1] = 1 - FLT_EPSILON;
    a[2] = -1;
    if (!run_shader(&sum, a, g, GROUP)) return false;
    sum.c(a, c);
    return fabsf(c[0] - g[0]) <= 0;
}

// limits: the largest share at limits where both sides round alike; `otherwise` where one fuses and
// the other does not, or the GPU's quotients and roots are its own.
static void compare_all(const function *f, double limits, double otherwise)
{
    gl_context c;
    if (!gl_test_begin(&c)) return;
    const bool fused = !rounds_alike(), exact = gl_test_rounds();
    if (fused) test_note("one side fuses multiply and add, the other does not");
    if (!exact) test_note("this GPU rounds quotients or roots its own way");
    for (; f->name; f++) {
        batch b = make_batch(f->input, MILLION);
        if (run_shader(f, b.inputs, b.results, b.count)) {
            check_promise(f, b);
            check_agreement(f, b, exact && !fused ? limits : otherwise, exact);
        }
        free_batch(b);
    }
    gl_context_destroy(&c);
}

// ---- The properties ----

static void text_compiles(void)
{
    gl_context c;
    if (!gl_test_begin(&c)) return;
    static const GLenum types[] = {GL_VERTEX_SHADER, GL_FRAGMENT_SHADER, GL_COMPUTE_SHADER};
    for (int i = 0; i < 3; i++) {
        const char *const text[] = {mssm_glsl_math(), lightprobe_glsl_math(),
                                    i < 2 ? "" : "layout(local_size_x = 1) in;\n",
                                    "void main() {}\n", NULL};
        gl.DeleteShader(gl_test_shader(types[i], "the text", text));
    }
    gl_context_destroy(&c);
}

static void keep_promises(batch b)
{
    static const function *const all[] = {bound_functions, blocker_functions, reconstruct_functions,
                                          cubic_functions};
    for (size_t group = 0; group < sizeof all / sizeof *all; group++)
        for (const function *f = all[group]; f->name; f++)
            if (run_shader(f, b.inputs, b.results, b.count)) check_promise(f, b);
}

static void garbage_is_tamed(void)
{
    gl_context c;
    if (!gl_test_begin(&c)) return;
    batch b = make_batch(random_garbage, MILLION);
    keep_promises(b);
    free_batch(b);
    gl_context_destroy(&c);
}

// A share may become 1.0000001 there, and x / x less than 1.
static void loose_quotients_break_nothing(void)
{
    static void (*const inputs[])(uint64_t *, float *) = {random_garbage, random_receiver4,
                                                          random_receiver6, random_cubic};
    gl_context c;
    if (!gl_test_begin(&c)) return;
    gl_test_round_loosely();
    CHECK(!gl_test_rounds(), "quotients are exact");
    for (int i = 0; i < 4; i++) {
        batch b = make_batch(inputs[i], MILLION / 32); // one in a thousand broke
        keep_promises(b);
        free_batch(b);
    }
    gl_context_destroy(&c);
}

static void storage_agrees(void)
{
    compare_all(storage_functions, 0, 0);
}

static void bounds_agree(void)
{
    compare_all(bound_functions, 0.0001, 0.15);
}

static void blocker_depths_agree(void)
{
    compare_all(blocker_functions, 0.0001, 0.15);
}

static void reconstructions_agree(void)
{
    compare_all(reconstruct_functions, 0.002, 0.15);
}

// A third of these cubics have two or three roots within 1e-6 ... 1 of each other.
static void cubics_agree(void)
{
    compare_all(cubic_functions, 0.0001, 0.25);
}

static void discs_agree(void)
{
    compare_all(disc_functions, 0.0001, 0.001);
}

const test_case glsl_tests[] = {
#if UINTPTR_MAX <= 0xffffffffu
    {0, 0}, // a 32-bit program would need a 32-bit driver, and the text is the same
#endif
    {"the GLSL text compiles as GLSL 4.50 without a warning", text_compiles},
    {"GLSL gives C's moments, bias and storage form", storage_agrees},
    {"GLSL gives C's bounds", bounds_agree},
    {"GLSL gives C's blocker depths", blocker_depths_agree},
    {"GLSL gives C's reconstructions", reconstructions_agree},
    {"GLSL gives C's roots of cubics", cubics_agree},
    {"GLSL gives C's irradiance of discs", discs_agree},
    {"GLSL keeps its promises for a million garbage inputs", garbage_is_tamed},
    {"GLSL keeps its promises where quotients and roots are two units off",
     loose_quotients_break_nothing},
    {0, 0}};
