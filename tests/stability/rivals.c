// The published algorithm and its variants, from their descriptions (Peters, GDC Europe 2016, bonus
// slides "Computing the bounds"): solve B c = (1, z, z^2...) with B the matrix of moments; the
// roots of the polynomial c are the other depths; the shares follow from as many linear equations
// as there are depths. They differ in how the two systems and the polynomial are solved. All in
// float32, without any repair.
#include "../support/published_moments.h"
#include "methods.h"

#include <math.h>
#include <string.h>

typedef struct nodes {
    int count;
    float z[4], w[4]; // z[0] is the receiver
} nodes;

// B[i][j] = b_(i+j), and the right side, powers of the receiver's depth.
static void moment_system(int n, const float b[6], float z, float B[4][4], float right[4])
{
    for (int i = 0; i <= n; i++) {
        for (int j = 0; j <= n; j++) B[i][j] = i + j ? b[i + j - 1] : 1;
        right[i] = i ? right[i - 1] * z : 1;
    }
}

// L D L^T.
static void solve_cholesky(int size, float B[4][4], const float right[4], float c[4])
{
    float L[4][4], D[4];
    for (int i = 0; i < size; i++) {
        for (int j = 0; j <= i; j++) {
            float s = B[i][j];
            for (int k = 0; k < j; k++) s -= L[i][k] * L[j][k] * D[k];
            if (i == j)
                D[i] = s;
            else
                L[i][j] = s / D[j];
        }
    }
    for (int i = 0; i < size; i++) {
        c[i] = right[i];
        for (int k = 0; k < i; k++) c[i] -= L[i][k] * c[k];
    }
    for (int i = 0; i < size; i++) c[i] /= D[i];
    for (int i = size - 1; i >= 0; i--) {
        for (int k = i + 1; k < size; k++) c[i] -= L[k][i] * c[k];
    }
}

// Gaussian elimination with partial pivoting.
static void solve_lu(int size, float A[4][4], const float right[4], float c[4])
{
    memcpy(c, right, 4 * sizeof *c);
    for (int k = 0; k < size; k++) {
        int pivot = k;
        for (int i = k + 1; i < size; i++) {
            if (fabsf(A[i][k]) > fabsf(A[pivot][k])) pivot = i;
        }
        for (int j = 0; j < size; j++) {
            const float t = A[k][j];
            A[k][j] = A[pivot][j];
            A[pivot][j] = t;
        }
        const float t = c[k];
        c[k] = c[pivot];
        c[pivot] = t;
        for (int i = k + 1; i < size; i++) {
            const float f = A[i][k] / A[k][k];
            for (int j = k; j < size; j++) A[i][j] -= f * A[k][j];
            c[i] -= f * c[k];
        }
    }
    for (int i = size - 1; i >= 0; i--) {
        for (int j = i + 1; j < size; j++) c[i] -= A[i][j] * c[j];
        c[i] /= A[i][i];
    }
}

// Determinant of A without row i and column j.
static float minor_of(int size, float A[4][4], int i, int j)
{
    float M[3][3];
    for (int r = 0, y = 0; r < size; r++) {
        if (r == i) continue;
        for (int s = 0, x = 0; s < size; s++) {
            if (s != j) M[y][x++] = A[r][s];
        }
        y++;
    }
    if (size == 3) return M[0][0] * M[1][1] - M[0][1] * M[1][0];
    return M[0][0] * (M[1][1] * M[2][2] - M[1][2] * M[2][1]) -
           M[0][1] * (M[1][0] * M[2][2] - M[1][2] * M[2][0]) +
           M[0][2] * (M[1][0] * M[2][1] - M[1][1] * M[2][0]);
}

// The adjugate over the determinant.
static void solve_inverse(int size, float A[4][4], const float right[4], float c[4])
{
    float determinant = 0;
    for (int j = 0; j < size; j++) {
        determinant += (j % 2 ? -1.0f : 1.0f) * A[0][j] * minor_of(size, A, 0, j);
    }
    for (int i = 0; i < size; i++) {
        float s = 0;
        for (int j = 0; j < size; j++) {
            s += ((i + j) % 2 ? -1.0f : 1.0f) * minor_of(size, A, j, i) / determinant * right[j];
        }
        c[i] = s;
    }
}

// The quadratic formula, and the closed form of a cubic with three real roots.
static void find_roots(int n, const float c[4], float x[3])
{
    if (n == 2) {
        const float p = c[1] / c[2], q = c[0] / c[2], r = sqrtf(p * p / 4 - q);
        x[0] = -p / 2 - r;
        x[1] = -p / 2 + r;
        return;
    }
    const float a = c[2] / c[3] / 3, b = c[1] / c[3], d = c[0] / c[3];
    const float p = b / 3 - a * a, q = (2 * a * a * a - a * b + d) / 2;
    const float angle = atan2f(sqrtf(-p * p * p - q * q), -q) / 3, size = 2 * sqrtf(-p);
    for (int k = 0; k < 3; k++) x[k] = size * cosf(angle + 2.0943951f * (float)k) - a;
}

// The same with the cubic of the image-based lighting paper's reference [8].
static void find_roots_published(int n, const float c[4], float x[3])
{
    if (n == 2)
        find_roots(n, c, x);
    else
        published_cubic(c[0], c[1], c[2], c[3], x);
}

// Each share as a Lagrange polynomial through all depths, applied to the moments.
static void closed_form_shares(nodes *s, const float b[6])
{
    for (int i = 0; i < s->count; i++) {
        float e[4] = {1, 0, 0, 0}, below = 1; // product of (x - z_j), highest power first
        int degree = 0;
        for (int j = 0; j < s->count; j++) {
            if (j == i) continue;
            degree++;
            for (int k = degree; k > 0; k--) e[k] -= s->z[j] * e[k - 1];
            below *= s->z[i] - s->z[j];
        }
        float sum = e[degree];
        for (int k = 0; k < degree; k++) sum += e[k] * b[degree - k - 1];
        s->w[i] = sum / below;
    }
}

// Householder reflections, and back from the last.
static void solve_qr(int size, float A[4][4], const float right[4], float c[4])
{
    memcpy(c, right, 4 * sizeof *c);
    for (int k = 0; k < size; k++) {
        float v[4] = {0}, length = 0, squared = 0;
        for (int i = k; i < size; i++) length += A[i][k] * A[i][k];
        length = A[k][k] > 0 ? -sqrtf(length) : sqrtf(length);
        for (int i = k; i < size; i++) v[i] = A[i][k] - (i == k ? length : 0);
        for (int i = k; i < size; i++) squared += v[i] * v[i];
        for (int j = k; j <= size; j++) { // the last column is the right side
            float along = 0;
            for (int i = k; i < size; i++) along += v[i] * (j < size ? A[i][j] : c[i]);
            for (int i = k; i < size; i++)
                *(j < size ? &A[i][j] : &c[i]) -= 2 * along / squared * v[i];
        }
    }
    for (int i = size - 1; i >= 0; i--) {
        for (int j = i + 1; j < size; j++) c[i] -= A[i][j] * c[j];
        c[i] /= A[i][i];
    }
}

typedef void solver(int size, float A[4][4], const float right[4], float c[4]);

// The Vandermonde system.
static void solved_shares(nodes *s, const float b[6], solver *solve)
{
    float V[4][4], right[4] = {0};
    for (int i = 0; i < s->count; i++) {
        for (int j = 0; j < s->count; j++) V[i][j] = i ? V[i - 1][j] * s->z[j] : 1;
        right[i] = i ? b[i - 1] : 1;
    }
    solve(s->count, V, right, s->w);
}

static answer summed(const nodes *s, float z)
{
    float nearer = 0, first = 0;
    for (int i = 1; i < s->count; i++) {
        if (s->z[i] >= z) continue;
        nearer += s->w[i];
        first += s->w[i] * s->z[i];
    }
    const answer a = {1 - nearer - s->w[0], 1 - nearer,
                      (first + 1e-3f * in_map(z)) / (nearer + 1e-3f)};
    return a;
}

static nodes other_depths(int m, const float b[6], float z, solver *solve,
                          void (*roots)(int n, const float c[4], float x[3]))
{
    nodes s;
    float B[4][4], right[4], c[4] = {0};
    s.count = m / 2 + 1;
    moment_system(m / 2, b, z, B, right);
    solve(s.count, B, right, c);
    s.z[0] = z;
    roots(m / 2, c, s.z + 1);
    return s;
}

answer run_cholesky(int m, const float b[6], const float t[6], float alpha, float z)
{
    (void)t;
    (void)alpha;
    nodes s = other_depths(m, b, z, solve_cholesky, find_roots);
    closed_form_shares(&s, b);
    return summed(&s, z);
}

answer run_inverse(int m, const float b[6], const float t[6], float alpha, float z)
{
    (void)t;
    (void)alpha;
    nodes s = other_depths(m, b, z, solve_inverse, find_roots);
    closed_form_shares(&s, b);
    return summed(&s, z);
}

answer run_lu(int m, const float b[6], const float t[6], float alpha, float z)
{
    (void)t;
    (void)alpha;
    nodes s = other_depths(m, b, z, solve_lu, find_roots);
    solved_shares(&s, b, solve_lu);
    return summed(&s, z);
}

answer run_cubic(int m, const float b[6], const float t[6], float alpha, float z)
{
    (void)t;
    (void)alpha;
    nodes s = other_depths(m, b, z, solve_cholesky, find_roots_published);
    closed_form_shares(&s, b);
    return summed(&s, z);
}

// What the image-based lighting paper tried (4.2.1): that cubic, and the system of the weights.
static answer run_paper(int m, const float b[6], float z, solver *solve)
{
    nodes s = other_depths(m, b, z, solve_cholesky, find_roots_published);
    solved_shares(&s, b, solve);
    return summed(&s, z);
}

answer run_paper_inverse(int m, const float b[6], const float t[6], float alpha, float z)
{
    (void)t;
    (void)alpha;
    return run_paper(m, b, z, solve_inverse);
}

answer run_paper_lu(int m, const float b[6], const float t[6], float alpha, float z)
{
    (void)t;
    (void)alpha;
    return run_paper(m, b, z, solve_lu);
}

answer run_paper_qr(int m, const float b[6], const float t[6], float alpha, float z)
{
    (void)t;
    (void)alpha;
    return run_paper(m, b, z, solve_qr);
}

// The polynomial that has the values f at the depths, by divided differences, applied to the
// moments: the mean of f over the distribution, without the shares.
static float mean_of(const nodes *s, const float f[4], const float b[6])
{
    float d[4], c[4] = {0, 0, 0, 0};
    const int n = s->count;
    memcpy(d, f, sizeof d);
    for (int k = 1; k < n; k++) {
        for (int i = n - 1; i >= k; i--) d[i] = (d[i] - d[i - 1]) / (s->z[i] - s->z[i - k]);
    }
    for (int i = n - 1; i >= 0; i--) { // c = c (x - z_i) + d_i
        for (int k = n - 1; k > 0; k--) c[k] = c[k - 1] - s->z[i] * c[k];
        c[0] = d[i] - s->z[i] * c[0];
    }
    float sum = c[0];
    for (int k = 1; k < n; k++) sum += c[k] * b[k - 1];
    return sum;
}

answer run_newton(int m, const float b[6], const float t[6], float alpha, float z)
{
    (void)t;
    (void)alpha;
    const nodes s = other_depths(m, b, z, solve_cholesky, find_roots);
    float nearer[4] = {0}, not_behind[4] = {1, 0, 0, 0}, first[4] = {0};
    for (int i = 1; i < s.count; i++) {
        const int in_front = s.z[i] < z;
        nearer[i] = in_front ? 1 : 0;
        not_behind[i] = nearer[i];
        first[i] = in_front ? s.z[i] : 0;
    }
    const float share = mean_of(&s, nearer, b);
    const answer a = {1 - mean_of(&s, not_behind, b), 1 - share,
                      (mean_of(&s, first, b) + 1e-3f * in_map(z)) / (share + 1e-3f)};
    return a;
}
