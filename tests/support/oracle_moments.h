// What the moment math must return, in quad precision and by other ways than the library's:
// orthogonal polynomials by Stieltjes' procedure from the depths themselves (no moments, no
// cancellation) or by elimination from a moment vector, their kernel's roots bracketed and
// bisected.
#ifndef ORACLE_MOMENTS_H
#define ORACLE_MOMENTS_H

#ifdef __SIZEOF_FLOAT128__
__extension__ typedef __float128 quad;
#else
typedef long double quad;
#endif

// Depths with shares (sum 1). Ascending and distinct after distribution_sort.
enum { DISTRIBUTION_MAX = 1040 };
typedef struct distribution {
    int count;
    quad z[DISTRIBUTION_MAX], w[DISTRIBUTION_MAX];
} distribution;

// Monic orthogonal polynomials p_{k+1} = (z - a[k]) p_k - d[k]/d[k-1] p_{k-1} with squared norms
// d[k], d[0] = 1. n = 2 or 3 of them besides p_0; fewer where the distribution has only `rank`
// depths, whose polynomial p_rank vanishes on all of them. rank is n + 1 in general.
typedef struct orthogonal {
    int n, rank;
    quad a[4], d[4];
} orthogonal;

// Canonical representation: z[0] is the given depth, the others ascend. A depth at infinity (share
// 0) is left out.
typedef struct points {
    int count;
    quad z[4], w[4];
} points;

// Of visibility; nearer and self are the shares of depth < z and depth == z that make up the
// bounds.
typedef struct sharp_bounds {
    quad lower, upper, nearer, self;
    quad first; // sum of share times depth over the depths nearer than z
} sharp_bounds;

quad quad_abs(quad x);
quad quad_sqrt(quad x);

distribution distribution_of(int count, const float *depth);
void distribution_add(distribution *d, quad z, quad w);
void distribution_sort(distribution *d);
// (1-alpha) d + alpha d*, d* a distribution with the even moments given (2 for m = 4, 3 for m = 6).
void distribution_bias(distribution *d, int m, const quad even[3], quad alpha);
void distribution_moments(const distribution *d, quad b[7]);
// Bounds of the distribution itself: upper counts what is nearer than z, lower also what is at z.
sharp_bounds distribution_truth(const distribution *d, quad z);

orthogonal orthogonal_of_distribution(int m, const distribution *d);
// b[0] = 1. Returns rank 0 where the moments are not those of any distribution.
orthogonal orthogonal_of_moments(int m, const quad b[7]);

points oracle_points(const orthogonal *o, quad z);
sharp_bounds oracle_bounds(const orthogonal *o, quad z);
// Eq. 7 and 19: mean depth of what is nearer than z and of the receiver, whose share is clamped.
quad oracle_blocker_depth(const sharp_bounds *s, quad z, quad self_min, quad self_max);

// All real roots of c[0] + c[1] x + c[2] x^2 + c[3] x^3, ascending, multiple ones repeated.
int oracle_cubic(const quad c[4], quad x[3]);

#endif
