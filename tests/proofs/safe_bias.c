// How strong must the bias be? Proves the safe strengths that mssm.h takes its constants from, and
// fails when one of its constants is below what is proven, or below what sampled patches needed.
//     make bias    or    build/release/safe_bias [patches] [seed]
//
// Moments b of a distribution have a positive semidefinite Hankel matrix H(b). Storage and
// arithmetic add an error e whose zeroth entry is 0, and blending to b* with strength alpha
// repairs it when
//     (1 - alpha) H(e) + alpha H(b*) >= 0        for every error e that can occur,
// because the rest, (1 - alpha) H(b), never hurts. H is linear, so the vertices of the box of
// errors are enough: the safe alpha is l/(1+l), l the largest eigenvalue of the pencils (-H(e),
// H(b*)). That is a proof, computed in __float128 where the compiler has it. The second half of the
// program samples depth patches through the float32 arithmetic and checks the outcome in quad
// precision: the proof must not be optimistic.
//
// All matrices here are in the Chebyshev basis, G[i][j] = E[T_i T_j] = (T_{i+j} + T_{|i-j|}) / 2,
// a congruence of the Hankel matrix: well scaled, and definite exactly where the other one is.
#include "../support/families.h"
#include "../support/oracle_moments.h"

#include "../../mssm.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double ULP = 1.0 / 16777216;  // relative spacing of float32 below a power of two
static const double HALF = 1.0 / 33554432; // largest rounding error of a float32 in [-1,1]

typedef struct matrix {
    quad a[4][4];
} matrix;

// ---- moments and matrices ------------------------------------------------------------------

// T[1..m] from b[1..m]; of_one is 1 for moments and 0 for differences of moments.
static void chebyshev_of_powers(int m, const quad b[7], quad of_one, quad T[7])
{
    T[1] = b[1];
    T[2] = 2 * b[2] - of_one;
    T[3] = 4 * b[3] - 3 * b[1];
    T[4] = 8 * b[4] - 8 * b[2] + of_one;
    T[5] = m == 6 ? 16 * b[5] - 20 * b[3] + 5 * b[1] : 0;
    T[6] = m == 6 ? 32 * b[6] - 48 * b[4] + 18 * b[2] - of_one : 0;
}

static matrix gram(int m, const quad T[7], quad of_one)
{
    matrix g;
    memset(&g, 0, sizeof g);
    for (int i = 0; i <= m / 2; i++) {
        for (int j = 0; j <= m / 2; j++) {
            const quad sum = i + j ? T[i + j] : of_one;
            g.a[i][j] = (sum + (i == j ? of_one : T[abs(i - j)])) / 2;
        }
    }
    return g;
}

// The matrix of a bias vector, given by its even powers: those of the float32 numbers in the
// header.
static matrix bias_gram(int m, const double even[3])
{
    const quad b[7] = {
        1, 0, (quad)(float)even[0], 0, (quad)(float)even[1], 0, (quad)(float)even[2]};
    quad T[7] = {1};
    chebyshev_of_powers(m, b, 1, T);
    return gram(m, T, 1);
}

// The lower triangular root of a positive definite matrix; 0 if it is not.
static int cholesky(int n, const matrix *a, matrix *root)
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            quad s = a->a[i][j];
            for (int k = 0; k < j; k++) s -= root->a[i][k] * root->a[j][k];
            if (i == j && !(s > 0)) return 0;
            root->a[i][j] = i == j ? quad_sqrt(s) : s / root->a[j][j];
        }
    }
    return 1;
}

// Largest eigenvalue of a symmetric matrix, by Jacobi rotations.
static quad largest_eigenvalue(int n, matrix a)
{
    for (int sweep = 0; sweep < 30; sweep++) {
        quad off = 0, all = 0;
        for (int p = 0; p < n; p++) {
            for (int q = 0; q < n; q++) {
                all += a.a[p][q] * a.a[p][q];
                off += p == q ? 0 : a.a[p][q] * a.a[p][q];
            }
        }
        if (off <= 1e-48L * all) break;
        for (int p = 0; p < n - 1; p++) {
            for (int q = p + 1; q < n; q++) {
                if (a.a[p][q] == 0) continue;
                const quad theta = (a.a[q][q] - a.a[p][p]) / (2 * a.a[p][q]);
                const quad t =
                    (theta < 0 ? -1 : 1) / (quad_abs(theta) + quad_sqrt(theta * theta + 1));
                const quad c = 1 / quad_sqrt(t * t + 1), s = t * c;
                for (int k = 0; k < n; k++) {
                    const quad x = a.a[k][p], y = a.a[k][q];
                    a.a[k][p] = c * x - s * y;
                    a.a[k][q] = s * x + c * y;
                }
                for (int k = 0; k < n; k++) {
                    const quad x = a.a[p][k], y = a.a[q][k];
                    a.a[p][k] = c * x - s * y;
                    a.a[q][k] = s * x + c * y;
                }
            }
        }
    }
    quad largest = a.a[0][0];
    for (int i = 1; i < n; i++) largest = a.a[i][i] > largest ? a.a[i][i] : largest;
    return largest;
}

// Largest l with det(-e - l b*) = 0: as much b* as the error e takes away.
static quad pencil(int n, const matrix *e, const matrix *root)
{
    matrix c;
    memset(&c, 0, sizeof c);
    for (int j = 0; j < n; j++) {
        for (int i = 0; i < n; i++) {
            quad s = -e->a[i][j];
            for (int k = 0; k < i; k++) s -= root->a[i][k] * c.a[k][j];
            c.a[i][j] = s / root->a[i][i];
        }
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            quad s = c.a[i][j];
            for (int k = 0; k < j; k++) s -= root->a[j][k] * c.a[i][k];
            c.a[i][j] = s / root->a[j][j];
        }
    }
    return largest_eigenvalue(n, c);
}

// ---- error budgets -------------------------------------------------------------------------

// Errors that can occur together, each up to the given size: of the Chebyshev values, of the
// powers, and of the share that all of them were scaled by together (a sum of weights that is not
// quite 1).
typedef struct budget {
    const char *name;
    double chebyshev[7], power[7], scale;
} budget;

// The worst vertex of one box.
static quad worst_vertex(int m, const double box[7], int powers, const matrix *root)
{
    quad worst = 0;
    for (int v = 0; v < 1 << m; v++) {
        quad e[7] = {0}, T[7] = {0};
        for (int k = 1; k <= m; k++) e[k] = (quad)(v >> (k - 1) & 1 ? box[k] : -box[k]);
        if (powers)
            chebyshev_of_powers(m, e, 0, T);
        else
            memcpy(T, e, sizeof T);
        const matrix g = gram(m, T, 0);
        const quad l = pencil(m / 2 + 1, &g, root);
        worst = l > worst ? l : worst;
    }
    return worst;
}

// The provably safe strength: the parts of the budget add up (the eigenvalue is subadditive).
static double safe_alpha(int m, const double even[3], const budget *error)
{
    const matrix star = bias_gram(m, even);
    matrix root, zeroth;
    memset(&zeroth, 0, sizeof zeroth);
    if (!cholesky(m / 2 + 1, &star, &root)) return 1;
    zeroth.a[0][0] = -(quad)error->scale; // all values scaled up by 1+s: the zeroth moment lacks s
    const quad l = worst_vertex(m, error->chebyshev, 0, &root) +
                   worst_vertex(m, error->power, 1, &root) + pencil(m / 2 + 1, &zeroth, &root);
    return (double)(l / (1 + l));
}

static budget no_error(const char *name)
{
    budget e;
    memset(&e, 0, sizeof e);
    e.name = name;
    return e;
}

static budget chebyshev_error(const char *name, double size)
{
    budget e = no_error(name);
    for (int k = 1; k <= 6; k++) e.chebyshev[k] = size;
    return e;
}

static budget power_error(const char *name, double size)
{
    budget e = no_error(name);
    for (int k = 1; k <= 6; k++) e.power[k] = size;
    return e;
}

// The blend x + alpha (x* - x) rounds once, twice as coarsely where an even value passes 1.
static void add_blend(double box[7])
{
    for (int k = 1; k <= 6; k++) box[k] += (k % 2 ? 1 : 2) * HALF;
}

static budget float_error(const char *name, double size)
{
    budget e = power_error(name, size);
    add_blend(e.power);
    return e;
}

// A box query of the table as mssm.h does it: rectangle sums become floats (exact where they hold
// a few texels, one rounding where they hold many), (a f0 + b f2) + f1 by row, the same by column,
// one product with the inverse area. Worst mix of shares: 3 x 3 texels with full weights, 5.7
// roundings. They are relative to T in a signed table, and to (T+1)/2 in an unsigned one. The
// decode to powers is counted operation by operation: b2 one sum; b3 a product and a sum; b4 two
// sums, one of them half as large; and so on.
static budget table_error(const char *name, int is_signed, int powers)
{
    static const double decode[7] = {0, 0, 1, 2, 1.5, 3.5, 3.6};
    // The signed scale is 5 less than it could be (MSSM_SCALE).
    const double integer = is_signed ? 0.5 / 2945788 : 0.5 * 729 / 2147483647.5;
    budget e =
        chebyshev_error(name, integer + 6 * ULP * (is_signed ? 1 : 2) + (is_signed ? 0 : HALF));
    for (int k = 1; k <= 6; k++) e.power[k] = powers ? decode[k] * HALF : 0;
    add_blend(powers ? e.power : e.chebyshev);
    return e;
}

// What mssm_map_moments gives: a signed query, stored values (T+1)/2 of it, powers of those.
static budget decoded_error(const char *name)
{
    budget e = table_error(name, 1, 1);
    for (int k = 1; k <= 6; k++) e.chebyshev[k] += 2 * HALF;
    return e;
}

// A texel of a coarser level is the rounded mean of four of the level below: another half unit a
// level at worst, where all of them fall the same way in every texel of a nearly flat region. The
// header's constants are for level 0.
static void add_levels(budget *e)
{
    for (int k = 1; k <= 6; k++) e->chebyshev[k] += 4 * 0.5 / 2945788;
}

// ---- the vectors ---------------------------------------------------------------------------

typedef struct bias_vector {
    const char *name;
    int moments;
    double even[3];
} bias_vector;

enum { VECTORS = 7 };
static const bias_vector vectors[VECTORS] = {
    {"4: .375 .375", 4, {0.375, 0.375, 0}},
    {"4: .628 .628", 4, {0.628, 0.628, 0}},
    {"4: .920 3.804", 4, {0.920, 3.804, 0}},
    {"4: 1.120 2.884", 4, {1.120, 2.884, 0}},
    {"6: .5566 .489 .4787", 6, {0.5566, 0.489, 0.47869382}},
    {"6: .421 .511 1.913", 6, {0.421, 0.511, 1.913}},
    {"6: .657 .734 1.197", 6, {0.657, 0.734, 1.197}}};

enum {
    ROW_AMPLIFICATION,
    ROW_AMPLIFICATION_POWERS,
    ROW_FLOAT_STORED,
    ROW_FLOAT_AVERAGED,
    ROW_SIXTEEN_ONE,
    ROW_SIXTEEN_THREE,
    ROW_INTEGER,
    ROW_U32_POWERS,
    ROW_S32_POWERS,
    ROW_U32_CHEBYSHEV,
    ROW_S32_CHEBYSHEV,
    ROW_S32_DECODED,
    ROW_LEVEL_CHEBYSHEV,
    ROW_LEVEL_DECODED,
    ROWS
};

static void fill_rows(budget rows[ROWS])
{
    rows[ROW_AMPLIFICATION] =
        chebyshev_error("amplification, Chebyshev basis, error 1 of (T+1)/2", 2e-9);
    rows[ROW_AMPLIFICATION_POWERS] =
        power_error("amplification, powers, odd as (b+1)/2, even as they are", 1e-9);
    for (int k = 1; k <= 5; k += 2) rows[ROW_AMPLIFICATION_POWERS].power[k] = 2e-9;
    rows[ROW_FLOAT_STORED] = float_error("float32, stored once (2^-25) and blended", HALF);
    rows[ROW_FLOAT_AVERAGED] =
        power_error("float32, averaged in float32 and blended (2^-22 in all)", 8 * HALF);
    rows[ROW_SIXTEEN_ONE] = chebyshev_error("16 bit, one rounding", 1 / 65535.0);
    rows[ROW_SIXTEEN_THREE] = chebyshev_error("16 bit, resolve and 2 blur passes", 3 / 65535.0);
    rows[ROW_INTEGER] =
        chebyshev_error("u32 table, 27 x 27, integer part", 0.5 * 729 / 2147483647.5);
    rows[ROW_U32_POWERS] = table_error("u32 table, unsigned, powers", 0, 1);
    rows[ROW_S32_POWERS] = table_error("u32 table, signed, powers", 1, 1);
    rows[ROW_U32_CHEBYSHEV] = table_error("u32 table, unsigned, Chebyshev", 0, 0);
    rows[ROW_S32_CHEBYSHEV] = table_error("u32 table, signed, Chebyshev", 1, 0);
    rows[ROW_S32_DECODED] = decoded_error("u32 table, signed, (T+1)/2, then powers");
    rows[ROW_LEVEL_CHEBYSHEV] = table_error("the same table, Chebyshev, at level 4", 1, 0);
    rows[ROW_LEVEL_DECODED] = decoded_error("the same, (T+1)/2, then powers, at level 4");
    add_levels(&rows[ROW_LEVEL_CHEBYSHEV]);
    add_levels(&rows[ROW_LEVEL_DECODED]);
}

// By row and vector.
static void print_proofs(double proven[ROWS][VECTORS])
{
    budget rows[ROWS];
    fill_rows(rows);
    for (int i = 0; i < ROWS; i++) {
        const double unit = i == ROW_AMPLIFICATION || i == ROW_AMPLIFICATION_POWERS ? 1e9 : 1;
        printf("\n%s\n", rows[i].name);
        for (int v = 0; v < VECTORS; v++) {
            proven[i][v] = safe_alpha(vectors[v].moments, vectors[v].even, &rows[i]);
            printf("    %-22s %.3g\n", vectors[v].name, unit * proven[i][v]);
        }
    }
    printf("\nscale: a sum of weights that is 1+s instead of 1 costs alpha = s times\n");
    for (int v = 0; v < VECTORS; v++) {
        budget e = no_error("scale");
        e.scale = 1e-9;
        printf("    %-22s %.3g\n", vectors[v].name,
               1e9 * safe_alpha(vectors[v].moments, vectors[v].even, &e));
    }
    printf(
        "\npivots of b*: b2, b4 - b2^2, b6 - b4^2/b2; a pivot's floor is alpha/2 times its own\n");
    for (int v = 0; v < VECTORS; v++) {
        const double *b = vectors[v].even;
        printf("    %-22s %.6g %.6g", vectors[v].name, b[0], b[1] - b[0] * b[0]);
        if (vectors[v].moments == 6) printf(" %.6g", b[2] - b[1] * b[1] / b[0]);
        printf("\n");
    }
}

// ---- sampling ------------------------------------------------------------------------------

enum {
    FLOAT_STORED,
    FLOAT_AVERAGED,
    SIXTEEN_ONE,
    SIXTEEN_THREE,
    U32_POWERS,
    S32_POWERS,
    U32_CHEBYSHEV,
    S32_CHEBYSHEV,
    S32_DECODED,
    FORMATS
};
static const char *const format_names[FORMATS] = {"float32, stored once",
                                                  "float32, averaged in float32",
                                                  "16 bit, one rounding",
                                                  "16 bit, three roundings",
                                                  "u32 table, unsigned, powers",
                                                  "u32 table, signed, powers",
                                                  "u32 table, unsigned, Chebyshev",
                                                  "u32 table, signed, Chebyshev",
                                                  "u32 table, signed, (T+1)/2, then powers"};

// What reaches the bias: powers b[1..6] or Chebyshev values T[1..6], in float32.
typedef struct received {
    float x[7];
    int chebyshev;
} received;

typedef struct patch {
    int side;
    float depth[28 * 28], weight_x[28], weight_y[28];
} patch;

static patch random_patch(uint64_t *state)
{
    patch p;
    const double kind = family_range(state, 0, 1);
    const int whole = family_range(state, 0, 1) < 0.3;
    p.side = kind < 0.3 ? 28 : 2 + (int)family_range(state, 0, kind < 0.6 ? 2 : 26);
    family_patch((int)(family_random(state) % FAMILY_COUNT), p.side, state, p.depth);
    for (int i = 0; i < p.side; i++) p.weight_x[i] = p.weight_y[i] = 1;
    if (!whole) {
        p.weight_x[0] = (float)family_range(state, 0, 1);
        p.weight_y[0] = (float)family_range(state, 0, 1);
    }
    // A kernel is 27 texels wide at most, at a fractional place.
    const int last = p.side - 1;
    if (p.side == 28 && whole) p.weight_x[0] = p.weight_y[0] = 0.5f;
    if (!whole || p.side == 28) {
        p.weight_x[last] = p.side == 28 ? 1 - p.weight_x[0] : (float)family_range(state, 0, 1);
        p.weight_y[last] = p.side == 28 ? 1 - p.weight_y[0] : (float)family_range(state, 0, 1);
    }
    return p;
}

// Sum of one channel over rectangle (i,j) of the 3 x 3 that an interpolated query reads.
static float rectangle(const patch *p, int k, int i, int j, int is_signed, double scale)
{
    const int from[3] = {0, 1, p->side - 1}, to[3] = {1, p->side - 1, p->side};
    int64_t sum = 0;
    for (int y = from[i]; y < to[i]; y++) {
        for (int x = from[j]; x < to[j]; x++) {
            const double T = family_chebyshev(k, (double)p->depth[y * p->side + x]);
            sum += llrint((is_signed ? T : 0.5 * T + 0.5) * scale);
        }
    }
    return (float)sum;
}

// powers: 0 leaves Chebyshev values, 1 turns them into powers, 2 does that as mssm_map_moments
// does.
static received table_query(const patch *p, int is_signed, int powers)
{
    const double scale = is_signed ? 2945788 : floor(4294967295.0 / 729);
    const float a = p->weight_x[0], b = p->weight_x[p->side - 1];
    const float c = p->weight_y[0], d = p->weight_y[p->side - 1];
    const float area = (a + (float)(p->side - 2) + b) * (c + (float)(p->side - 2) + d);
    const float inverse = 1 / ((float)scale * area);
    float T[7] = {1, 0, 0, 0, 0, 0, 0};
    received r;
    memset(&r, 0, sizeof r);
    for (int k = 1; k <= 6; k++) {
        float row[3];
        for (int i = 0; i < 3; i++) {
            const float f0 = rectangle(p, k, i, 0, is_signed, scale);
            const float f1 = rectangle(p, k, i, 1, is_signed, scale);
            const float f2 = rectangle(p, k, i, 2, is_signed, scale);
            row[i] = (a * f0 + b * f2) + f1;
        }
        const float q = ((c * row[0] + d * row[2]) + row[1]) * inverse;
        T[k] = is_signed ? q : 2 * q - 1;
    }
    r.chebyshev = !powers;
    memcpy(r.x, T, sizeof T);
    if (!powers) return r;
    if (powers == 2) {
        mssm_moments6 q;
        for (int k = 0; k < 6; k++) q.b[k] = 0.5f + 0.5f * T[k + 1];
        q = mssm_moments6_decode(q);
        memcpy(r.x + 1, q.b, sizeof q.b);
        return r;
    }
    r.x[2] = 0.5f * (1 + T[2]);
    r.x[3] = 0.25f * (3 * T[1] + T[3]);
    r.x[4] = 0.125f * (3 + 4 * T[2] + T[4]);
    r.x[5] = 0.0625f * (10 * T[1] + 5 * T[3] + T[5]);
    r.x[6] = 0.03125f * (10 + 15 * T[2] + 6 * T[4] + T[6]);
    return r;
}

// Weighted mean of a power or Chebyshev value over the patch, each texel rounded to `step` first.
static double patch_mean(const patch *p, int k, int powers, double step)
{
    double sum = 0, total = 0;
    for (int y = 0; y < p->side; y++) {
        for (int x = 0; x < p->side; x++) {
            const double z = (double)p->depth[y * p->side + x];
            const double w = (double)(p->weight_x[x] * p->weight_y[y]);
            const double v = powers ? pow(z, k) : family_chebyshev(k, z);
            sum += w * (step > 0 ? step * (double)llrint(v / step) : v);
            total += w;
        }
    }
    return total > 0 ? sum / total : 0;
}

// Float32 powers of float32 depths, averaged pairwise in float32 as a chain of mip maps does.
static received float_average(const patch *p)
{
    const int count = p->side * p->side;
    received r;
    memset(&r, 0, sizeof r);
    for (int k = 1; k <= 6; k++) {
        float sum[28 * 28];
        for (int i = 0; i < count; i++) {
            const float z = p->depth[i], z2 = z * z;
            sum[i] = (k & 1 ? z : 1) * (k < 2 ? 1 : k < 4 ? z2 : k < 6 ? z2 * z2 : z2 * z2 * z2);
        }
        for (int n = count; n > 1; n = (n + 1) / 2) {
            for (int i = 0; i < n / 2; i++) sum[i] = sum[2 * i] + sum[2 * i + 1];
            if (n % 2) sum[n / 2] = sum[n - 1];
        }
        r.x[k] = sum[0] / (float)count;
    }
    return r;
}

static received receive(const patch *p, int format)
{
    received r;
    memset(&r, 0, sizeof r);
    if (format == FLOAT_AVERAGED) return float_average(p);
    if (format >= U32_POWERS) {
        return table_query(p, format != U32_POWERS && format != U32_CHEBYSHEV,
                           format == S32_DECODED                          ? 2
                           : format == U32_POWERS || format == S32_POWERS ? 1
                                                                          : 0);
    }
    const int is_float = format == FLOAT_STORED;
    // Three roundings can all fall the same way: as one of three times the size.
    const double step = 2 / 65535.0 * (format == SIXTEEN_THREE ? 3 : 1);
    for (int k = 1; k <= 6; k++) {
        const double mean = patch_mean(p, k, is_float, 0);
        r.x[k] = (float)(is_float ? mean : step * (double)llrint(mean / step));
    }
    r.chebyshev = !is_float;
    return r;
}

// Is the matrix of the biased float32 values positive definite? Exact but for quad precision.
static int is_valid(int m, const received *r, const double even[3], float alpha)
{
    const quad powers[7] = {1, 0, (quad)even[0], 0, (quad)even[1], 0, (quad)even[2]};
    quad star[7] = {1, 0, 0, 0, 0, 0, 0};
    if (r->chebyshev)
        chebyshev_of_powers(m, powers, 1, star);
    else
        memcpy(star, powers, sizeof star);
    quad x[7] = {1, 0, 0, 0, 0, 0, 0}, a[4][4];
    for (int k = 1; k <= m; k++) {
        const float blended = r->x[k] + alpha * ((float)star[k] - r->x[k]);
        x[k] = (quad)blended;
    }
    for (int i = 0; i <= m / 2; i++) {
        for (int j = 0; j <= m / 2; j++) {
            a[i][j] = r->chebyshev ? (x[i + j] + x[abs(i - j)]) / 2 : x[i + j];
        }
    }
    for (int i = 0; i <= m / 2; i++) {
        if (!(a[i][i] > 0)) return 0;
        for (int j = i + 1; j <= m / 2; j++) {
            for (int k = i + 1; k <= m / 2; k++) a[j][k] -= a[j][i] * a[i][k] / a[i][i];
        }
    }
    return 1;
}

// The smallest strength of a geometric row at which this patch is valid, and at all above it.
static double needed_alpha(int m, const received *r, const double even[3], double known)
{
    double alpha = known;
    while (alpha < 1 && !is_valid(m, r, even, (float)alpha)) alpha *= 1.02;
    return alpha;
}

static void print_samples(int patches, uint64_t seed, double needed[FORMATS][VECTORS])
{
    uint64_t state = seed;
    for (int f = 0; f < FORMATS; f++) {
        for (int v = 0; v < VECTORS; v++) needed[f][v] = 1e-9;
    }
    for (int i = 0; i < patches; i++) {
        const patch p = random_patch(&state);
        for (int f = 0; f < FORMATS; f++) {
            const received r = receive(&p, f);
            for (int v = 0; v < VECTORS; v++) {
                needed[f][v] = needed_alpha(vectors[v].moments, &r, vectors[v].even, needed[f][v]);
            }
        }
    }
    printf("\nstrength that %d sampled patches needed\n", patches);
    for (int f = 0; f < FORMATS; f++) {
        printf("\n%s\n", format_names[f]);
        for (int v = 0; v < VECTORS; v++) printf("    %-22s %.3g\n", vectors[v].name, needed[f][v]);
    }
}

// ---- the constants of the header -----------------------------------------------------------

typedef struct constant {
    const char *name;
    float value;
    int vector, row, format; // what proves it and what samples it
} constant;

static const constant constants[] = {
    {"MSSM_BIAS4_FLOAT32", MSSM_BIAS4_FLOAT32, 2, ROW_FLOAT_AVERAGED, FLOAT_AVERAGED},
    {"MSSM_BIAS6_FLOAT32", MSSM_BIAS6_FLOAT32, 5, ROW_FLOAT_AVERAGED, FLOAT_AVERAGED},
    {"MSSM_BIAS4_UNORM16", MSSM_BIAS4_UNORM16, 3, ROW_SIXTEEN_ONE, SIXTEEN_ONE},
    {"MSSM_BIAS6_UNORM16", MSSM_BIAS6_UNORM16, 6, ROW_SIXTEEN_ONE, SIXTEEN_ONE},
    {"MSSM_BIAS4_UNORM16_FILTERED", MSSM_BIAS4_UNORM16_FILTERED, 3, ROW_SIXTEEN_THREE,
     SIXTEEN_THREE},
    {"MSSM_BIAS6_UNORM16_FILTERED", MSSM_BIAS6_UNORM16_FILTERED, 6, ROW_SIXTEEN_THREE,
     SIXTEEN_THREE},
    {"MSSM_BIAS4_TABLE", MSSM_BIAS4_TABLE, 3, ROW_S32_CHEBYSHEV, S32_CHEBYSHEV},
    {"MSSM_BIAS6_TABLE", MSSM_BIAS6_TABLE, 6, ROW_S32_CHEBYSHEV, S32_CHEBYSHEV},
    {"MSSM_BIAS4_DECODED", MSSM_BIAS4_DECODED, 2, ROW_S32_DECODED, S32_DECODED},
    {"MSSM_BIAS6_DECODED", MSSM_BIAS6_DECODED, 5, ROW_S32_DECODED, S32_DECODED}};

// The table that mssm.h quotes. Returns how many of its constants are too small.
static int check_constants(double proven[ROWS][VECTORS], double needed[FORMATS][VECTORS])
{
    int bad = 0;
    printf("\n%-28s %10s %10s %10s   even moments of the vector\n", "constant", "in mssm.h",
           "proven", "sampled");
    for (size_t i = 0; i < sizeof constants / sizeof *constants; i++) {
        const constant *c = constants + i;
        const double proof = proven[c->row][c->vector], sample = needed[c->format][c->vector];
        const int low = (double)c->value < proof || (double)c->value < sample;
        bad += low;
        printf("%-28s %10.4g %10.4g %10.4g   %s%s\n", c->name, (double)c->value, proof, sample,
               vectors[c->vector].name + 3, low ? "   TOO SMALL" : "");
    }
    return bad;
}

int main(int argc, char **argv)
{
    static double proven[ROWS][VECTORS], needed[FORMATS][VECTORS];
    print_proofs(proven);
    print_samples(argc > 1 ? atoi(argv[1]) : 30000,
                  argc > 2 ? strtoull(argv[2], NULL, 0) : UINT64_C(2026), needed);
    const int bad = check_constants(proven, needed);
    if (bad) printf("%d constants of mssm.h are below what is safe\n", bad);
    return bad > 0;
}
