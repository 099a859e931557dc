#include "oracle_moments.h"

#include <string.h>

quad quad_abs(quad x)
{
    return x < 0 ? -x : x;
}

// Newton's method, scaled into [1,4) first.
quad quad_sqrt(quad x)
{
    if (!(x > 0)) return 0;
    quad scale = 1;
    while (x >= 4) {
        x *= 0.25L;
        scale *= 2;
    }
    while (x < 1) {
        x *= 4;
        scale *= 0.5L;
    }
    quad r = 1.5L;
    for (int i = 0; i < 9; i++) r = (r + x / r) * 0.5L;
    return r * scale;
}

// ---- distributions -------------------------------------------------------------------------

void distribution_add(distribution *d, quad z, quad w)
{
    if (d->count == DISTRIBUTION_MAX) return;
    d->z[d->count] = z;
    d->w[d->count++] = w;
}

// Shell sort, then equal depths become one.
void distribution_sort(distribution *d)
{
    static const int gaps[] = {701, 301, 132, 57, 23, 10, 4, 1};
    for (int g = 0; g < 8; g++) {
        for (int i = gaps[g]; i < d->count; i++) {
            const quad z = d->z[i], w = d->w[i];
            int j = i;
            for (; j >= gaps[g] && d->z[j - gaps[g]] > z; j -= gaps[g]) {
                d->z[j] = d->z[j - gaps[g]];
                d->w[j] = d->w[j - gaps[g]];
            }
            d->z[j] = z;
            d->w[j] = w;
        }
    }
    int n = 0;
    for (int i = 0; i < d->count; i++) {
        if (d->w[i] <= 0) continue;
        if (n > 0 && d->z[n - 1] == d->z[i]) {
            d->w[n - 1] += d->w[i];
        } else {
            d->z[n] = d->z[i];
            d->w[n++] = d->w[i];
        }
    }
    d->count = n;
}

distribution distribution_of(int count, const float *depth)
{
    distribution d;
    d.count = 0;
    for (int i = 0; i < count; i++) distribution_add(&d, (quad)depth[i], (quad)1 / count);
    distribution_sort(&d);
    return d;
}

void distribution_bias(distribution *d, int m, const quad even[3], quad alpha)
{
    for (int i = 0; i < d->count; i++) d->w[i] *= 1 - alpha;
    // Squares s of the depths: one for 4 moments (and the depth 0), two for 6.
    if (m == 4) {
        const quad s = even[1] / even[0], w = even[0] / s;
        distribution_add(d, quad_sqrt(s), alpha * w / 2);
        distribution_add(d, -quad_sqrt(s), alpha * w / 2);
        distribution_add(d, 0, alpha * (1 - w));
    } else {
        // The squares are the roots of s^2 - p s + q, orthogonal to 1 and s under moments 1, b2,
        // b4, b6.
        const quad b2 = even[0], b4 = even[1], b6 = even[2], det = b4 - b2 * b2;
        const quad p = (b6 - b4 * b2) / det, q = (b6 * b2 - b4 * b4) / det;
        const quad r = quad_sqrt(p * p / 4 - q), s1 = p / 2 - r, s2 = p / 2 + r;
        const quad w2 = (b2 - s1) / (s2 - s1);
        distribution_add(d, quad_sqrt(s1), alpha * (1 - w2) / 2);
        distribution_add(d, -quad_sqrt(s1), alpha * (1 - w2) / 2);
        distribution_add(d, quad_sqrt(s2), alpha * w2 / 2);
        distribution_add(d, -quad_sqrt(s2), alpha * w2 / 2);
    }
    distribution_sort(d);
}

void distribution_moments(const distribution *d, quad b[7])
{
    memset(b, 0, 7 * sizeof *b);
    for (int i = 0; i < d->count; i++) {
        quad power = d->w[i];
        for (int k = 0; k < 7; k++) {
            b[k] += power;
            power *= d->z[i];
        }
    }
}

sharp_bounds distribution_truth(const distribution *d, quad z)
{
    sharp_bounds s;
    memset(&s, 0, sizeof s);
    for (int i = 0; i < d->count; i++) {
        if (d->z[i] < z) {
            s.nearer += d->w[i];
            s.first += d->w[i] * d->z[i];
        } else if (d->z[i] == z) {
            s.self += d->w[i];
        }
    }
    s.upper = 1 - s.nearer;
    s.lower = s.upper - s.self;
    return s;
}

// ---- orthogonal polynomials ----------------------------------------------------------------

orthogonal orthogonal_of_distribution(int m, const distribution *d)
{
    static quad p[DISTRIBUTION_MAX], before[DISTRIBUTION_MAX];
    orthogonal o;
    memset(&o, 0, sizeof o);
    o.n = m / 2;
    o.rank = d->count <= o.n ? d->count : o.n + 1;
    for (int i = 0; i < d->count; i++) {
        p[i] = 1;
        before[i] = 0;
    }
    for (int k = 0; k <= o.n && k < o.rank; k++) {
        quad first = 0;
        for (int i = 0; i < d->count; i++) {
            o.d[k] += d->w[i] * p[i] * p[i];
            first += d->w[i] * p[i] * p[i] * d->z[i];
        }
        o.a[k] = first / o.d[k];
        const quad ratio = k > 0 ? o.d[k] / o.d[k - 1] : 0;
        for (int i = 0; i < d->count; i++) {
            const quad next = (d->z[i] - o.a[k]) * p[i] - ratio * before[i];
            before[i] = p[i];
            p[i] = next;
        }
    }
    return o;
}

// Elimination on the Hankel matrix: row k becomes E[p_k z^j], whose diagonal holds the squared
// norms.
orthogonal orthogonal_of_moments(int m, const quad b[7])
{
    orthogonal o;
    quad h[4][4], shift = 0; // shift: the coefficient of z^(k-1) in p_k, with its sign turned
    memset(&o, 0, sizeof o);
    o.n = m / 2;
    o.rank = o.n + 1;
    for (int i = 0; i <= o.n; i++) {
        for (int j = 0; j <= o.n; j++) h[i][j] = b[i + j];
    }
    for (int k = 0; k <= o.n; k++) {
        o.d[k] = h[k][k];
        if (o.d[k] < 1e-28L) {
            o.rank = o.d[k] > -1e-28L ? k : 0;
            break;
        }
        if (k == o.n) break; // a[n] takes the moment after the last
        const quad next = h[k][k + 1] / h[k][k];
        o.a[k] = next - shift;
        shift = next;
        for (int i = k + 1; i <= o.n; i++) {
            const quad factor = h[i][k] / h[k][k];
            for (int j = k; j <= o.n; j++) h[i][j] -= factor * h[k][j];
        }
    }
    return o;
}

// p[k](z + t) as a polynomial of t, for k = 0..n.
static void polynomials_at(const orthogonal *o, quad z, quad p[4][4])
{
    memset(p, 0, 16 * sizeof(quad));
    p[0][0] = 1;
    for (int k = 0; k < o->n; k++) {
        for (int j = 0; j <= k + 1; j++) {
            p[k + 1][j] = (z - o->a[k]) * p[k][j] + (j > 0 ? p[k][j - 1] : 0) -
                          (k > 0 ? o->d[k] / o->d[k - 1] * p[k - 1][j] : 0);
        }
    }
}

static quad value_at(const quad c[4], quad t)
{
    return ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
}

// The share of the depth z + t: the Christoffel number.
static quad share_at(const orthogonal *o, int used, quad p[4][4], quad t)
{
    quad sum = 0;
    for (int k = 0; k < used; k++) {
        const quad v = value_at(p[k], t);
        sum += v * v / o->d[k];
    }
    return 1 / sum;
}

static void insert_point(points *r, quad z, quad w)
{
    int i = r->count++;
    for (; i > 1 && r->z[i - 1] > z; i--) {
        r->z[i] = r->z[i - 1];
        r->w[i] = r->w[i - 1];
    }
    r->z[i] = z;
    r->w[i] = w;
}

points oracle_points(const orthogonal *o, quad z)
{
    points r;
    quad p[4][4], c[4] = {0}, x[3];
    memset(&r, 0, sizeof r);
    polynomials_at(o, z, p);
    // A singular matrix has one distribution only; z has a share if it is one of its depths.
    if (o->rank <= o->n) {
        const int count = o->rank > 0 ? oracle_cubic(p[o->rank], x) : 0;
        r.count = 1;
        r.z[0] = z;
        for (int i = 0; i < count; i++) {
            const quad w = share_at(o, o->rank, p, x[i]);
            if (quad_abs(x[i]) < 1e-16L)
                r.w[0] = w;
            else
                insert_point(&r, z + x[i], w);
        }
        return r;
    }
    // The kernel in v = 1/t: no root is at infinity, that of a depth at infinity is 0.
    for (int k = 0; k <= o->n; k++) {
        for (int j = 0; j <= k; j++) c[o->n - j] += p[k][j] * p[k][0] / o->d[k];
    }
    r.count = 1;
    r.z[0] = z;
    r.w[0] = share_at(o, o->n + 1, p, 0);
    const int count = oracle_cubic(c, x);
    for (int i = 0; i < count; i++) {
        if (quad_abs(x[i]) < 1e-20L) continue;
        insert_point(&r, z + 1 / x[i], share_at(o, o->n + 1, p, 1 / x[i]));
    }
    return r;
}

sharp_bounds oracle_bounds(const orthogonal *o, quad z)
{
    const points p = oracle_points(o, z);
    sharp_bounds s;
    memset(&s, 0, sizeof s);
    s.self = p.w[0];
    for (int i = 1; i < p.count; i++) {
        if (p.z[i] >= z) continue;
        s.nearer += p.w[i];
        s.first += p.w[i] * p.z[i];
    }
    s.upper = 1 - s.nearer;
    s.lower = s.upper - s.self;
    return s;
}

quad oracle_blocker_depth(const sharp_bounds *s, quad z, quad self_min, quad self_max)
{
    const quad self = s->self < self_min ? self_min : s->self > self_max ? self_max : s->self;
    return (s->first + self * z) / (s->nearer + self);
}

// ---- cubic ---------------------------------------------------------------------------------

// The root in [low,high], where f changes sign: Newton's method, and bisection where that would
// leave the bracket or no longer halves its steps (it crawls at multiple roots).
static quad bracketed(const quad c[4], quad low, quad high)
{
    const int falling = value_at(c, low) > 0;
    quad x = (low + high) / 2, step = high - low, before = step;
    for (int i = 0; i < 400; i++) {
        const quad f = value_at(c, x), slope = (3 * c[3] * x + 2 * c[2]) * x + c[1];
        if (f == 0) return x;
        if ((f > 0) == falling)
            low = x;
        else
            high = x;
        quad next = slope != 0 ? x - f / slope : low;
        const int slow = 2 * quad_abs(next - x) > quad_abs(before);
        if (!(next > low && next < high) || slow) next = (low + high) / 2;
        before = step;
        step = next - x;
        x = next;
        if (quad_abs(step) <= 1e-33L * quad_abs(x)) break;
    }
    return x;
}

// Cauchy's bound on the roots, brought down as long as the leading term outweighs the rest.
static quad root_bound(const quad c[4], int degree)
{
    quad bound = 1;
    for (int k = 0; k < degree; k++) bound += quad_abs(c[k] / c[degree]);
    for (int i = 0; i < 200; i++) {
        const quad x = bound / 16;
        quad rest = 0, lead = quad_abs(c[degree]);
        for (int k = degree - 1; k >= 0; k--) rest = rest * x + quad_abs(c[k]);
        for (int k = 0; k < degree; k++) lead *= x;
        if (rest >= lead) break;
        bound = x;
    }
    return bound;
}

// Where the slope of a polynomial of degree 2 or 3 is zero, ascending.
static int extrema_of(const quad c[4], int degree, quad extremum[2])
{
    if (degree == 2) {
        extremum[0] = -c[1] / (2 * c[2]);
        return 1;
    }
    const quad middle = -c[2] / (3 * c[3]);
    const quad disc = middle * middle - c[1] / (3 * c[3]);
    if (disc < 0) return 0;
    const quad outer = middle + (middle < 0 ? -quad_sqrt(disc) : quad_sqrt(disc));
    const quad inner = outer != 0 ? c[1] / (3 * c[3]) / outer : 0;
    extremum[0] = outer < inner ? outer : inner;
    extremum[1] = outer < inner ? inner : outer;
    return 2;
}

int oracle_cubic(const quad c[4], quad x[3])
{
    int degree = 3, count = 0;
    while (degree > 0 && c[degree] == 0) degree--;
    if (degree == 0) return 0;
    if (degree == 1) {
        x[0] = -c[0] / c[1];
        return 1;
    }
    // Between and outside of the extrema the polynomial is monotone.
    quad extremum[2];
    const int extrema = extrema_of(c, degree, extremum);
    const quad bound = root_bound(c, degree);
    for (int i = 0; i <= extrema; i++) {
        const quad low = i > 0 ? extremum[i - 1] : -bound, high = i < extrema ? extremum[i] : bound;
        const quad f = value_at(c, low), g = value_at(c, high);
        if (i > 0 && f == 0) { // a double root touches the axis here
            x[count] = low;
            if (count == 0 || x[count - 1] != low) count++;
            if (count < degree) x[count++] = low;
            continue;
        }
        if (i < extrema && g == 0) continue; // counted by the next interval
        if ((f < 0) != (g < 0)) x[count++] = bracketed(c, low, high);
    }
    return count;
}
