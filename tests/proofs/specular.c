// Fits the numbers of lightprobe_specular_lobe, and fails when lightprobe.h has others.
//     make specular    or    build/release/specular [print]
//
// Reflected radiance of GGX with height-correlated Smith shadowing is a distribution of directions
// of light, times what it sums up to. The distribution is fitted by a cosine that a matrix has
// transformed (Heitz, Dupuy, Hill and Neubelt: Real-Time Polygonal-Light Shading with Linearly
// Transformed Cosines, 2016), of the matrices that leave the horizon where it is:
//     x' = along x - shear z,   y' = across y,   z' = 2 alpha z
// in axes away from the viewer (x) and along the normal (z). A small alpha has along = cos^2,
// across = 1, shear = sin cos: GGX's distribution of half vectors is itself a transformed cosine,
// and a mirror doubles its angles. What a larger alpha adds is alpha times a polynomial of alpha
// and r = cos / (cos + alpha), of degree 3 in each: all depends on cos / alpha near grazing.
// Levenberg and Marquardt's method minimises the squared difference of the distributions, over the
// root of GGX's, for all roughnesses and angles; without the root tails are worse by far, over GGX
// itself peaks are. The sums, with and without Schlick's (1 - cos)^5, are fitted by linear least
// squares. "print" prints the numbers for lightprobe.h, "table" those of the docs.
#include "../../lightprobe.h"
#include "../support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    ALPHAS = 14,
    ANGLES = 16,
    NODES = ALPHAS * ANGLES,
    SIDE = 32,
    FINE = 192,
    TERMS = 16,
    SHAPE = 3 * TERMS
};
static const double PI = 3.14159265358979323846;

typedef struct sample {
    double light[3];
    double value,
        density; // of the distribution; of samples, in a node what differences are divided by
} sample;

typedef struct node {
    double alpha, cosine;
    double whole, schlick; // the sums
    int count;
    sample s[SIDE * SIDE];
} node;

static node nodes[NODES];

// A half vector drawn by GGX, the light's direction by it, the BRDF times cosine and the density of
// drawing. False if no light comes from there.
static int draw(double alpha, double cosine, double u, double v, sample *s, double *half_cosine)
{
    const double sine = sqrt(1 - cosine * cosine), a2 = alpha * alpha, phi = PI * v;
    const double hz = sqrt((1 - u) / (1 - u + a2 * u)), hr = sqrt(1 - hz * hz), hx = hr * cos(phi),
                 hy = hr * sin(phi);
    const double along = cosine * hz - sine * hx; // the viewer is at x = -sine
    const double l[3] = {2 * along * hx + sine, 2 * along * hy, 2 * along * hz - cosine};
    if (along <= 0 || l[2] <= 0) return 0;
    const double d = a2 / (PI * pow(hz * hz * (a2 - 1) + 1, 2));
    const double to_view = sqrt(cosine * cosine + a2 * sine * sine) / cosine;
    const double to_light = sqrt(l[2] * l[2] + a2 * (1 - l[2] * l[2])) / l[2];
    memcpy(s->light, l, sizeof l);
    s->value = d * 2 / (to_view + to_light) / (4 * cosine);
    s->density = d * hz / (4 * along);
    *half_cosine = along;
    return 1;
}

static void make_node(node *o, double alpha, double cosine)
{
    sample s;
    double half, square = 0;
    o->alpha = alpha;
    o->cosine = cosine;
    for (int i = 0; i < FINE * FINE; i++) {
        if (!draw(alpha, cosine, (i / FINE + 0.5) / FINE, (i % FINE + 0.5) / FINE, &s, &half))
            continue;
        o->whole += s.value / s.density / (FINE * FINE);
        o->schlick += s.value / s.density / (FINE * FINE) * pow(1 - half, 5);
    }
    for (int i = 0; i < SIDE * SIDE; i++) {
        if (!draw(alpha, cosine, (i / SIDE + 0.5) / SIDE, (i % SIDE + 0.5) / SIDE, &s, &half))
            continue;
        s.value /= o->whole;
        s.density =
            pow(s.density, 0.75); // one power for the mean, half of one so that peaks count more
        o->s[o->count++] = s;
        square += pow(s.value / s.density, 2);
    }
    for (int i = 0; i < o->count; i++) o->s[i].density *= sqrt(square); // all nodes count the same
}

// ---- The distribution, and what it is fitted by

// g: along, shear over sine, across.
static double transformed(const node *o, const double *l, const double g[3])
{
    const double width = 2 * o->alpha, sine = sqrt(1 - o->cosine * o->cosine);
    const double x = (g[0] * l[0] - g[1] * sine * l[2]) / width, y = g[2] * l[1] / width, z = l[2];
    const double square = x * x + y * y + z * z;
    return z * g[0] * g[2] / (width * width * PI * square * square);
}

static double difference(const node *o, const double g[3])
{
    double sum = 0;
    for (int i = 0; i < o->count; i++) {
        const double d = (transformed(o, o->s[i].light, g) - o->s[i].value) / o->s[i].density;
        sum += d * d;
    }
    return sum;
}

static void terms(const node *o, double b[TERMS])
{
    const double r = o->cosine / (o->cosine + o->alpha);
    for (int i = 0; i < TERMS; i++) b[i] = pow(o->alpha, i / 4) * pow(r, i % 4);
}

static void evaluate(const node *o, const double *c, double g[3])
{
    double b[TERMS];
    terms(o, b);
    g[0] = o->cosine * o->cosine;
    g[1] = o->cosine;
    g[2] = 1;
    for (int k = 0; k < SHAPE; k++) g[k / TERMS] += o->alpha * c[k] * b[k % TERMS];
}

static double all_difference(const double *c)
{
    double sum = 0, g[3];
    for (int i = 0; i < NODES; i++) {
        evaluate(&nodes[i], c, g);
        if (!(g[0] > 0 && g[2] > 0)) return 1e30;
        sum += difference(&nodes[i], g);
    }
    return sum;
}

// Gauss and Jordan, with pivots: b becomes the solution.
static void solve(int n, double *a, double *b)
{
    for (int i = 0; i < n; i++) {
        int p = i;
        for (int k = i; k < n; k++) p = fabs(a[k * n + i]) > fabs(a[p * n + i]) ? k : p;
        for (int k = 0; k <= n; k++) {
            double *x = k < n ? &a[i * n + k] : &b[i], *y = k < n ? &a[p * n + k] : &b[p], t = *x;
            *x = *y;
            *y = t;
        }
        for (int k = 0; k < n; k++) {
            const double f = k == i ? 0 : a[k * n + i] / a[i * n + i];
            for (int j = i; j < n; j++) a[k * n + j] -= f * a[i * n + j];
            b[k] -= f * b[i];
        }
    }
    for (int i = 0; i < n; i++) b[i] /= a[i * n + i];
}

// The normal equations of a node's three numbers.
static void normal_equations(const node *o, const double g[3], double jj[9], double jr[3])
{
    memset(jj, 0, 9 * sizeof *jj);
    memset(jr, 0, 3 * sizeof *jr);
    for (int i = 0; i < o->count; i++) {
        const sample *s = &o->s[i];
        const double now = transformed(o, s->light, g);
        double j[3];
        for (int k = 0; k < 3; k++) {
            double moved[3] = {g[0], g[1], g[2]};
            const double step = 1e-6 * (fabs(g[k]) + 1e-3);
            moved[k] += step;
            j[k] = (transformed(o, s->light, moved) - now) / (step * s->density);
        }
        for (int k = 0; k < 3; k++) {
            jr[k] += j[k] * (s->value - now) / s->density;
            for (int m = 0; m < 3; m++) jj[3 * k + m] += j[k] * j[m];
        }
    }
}

// A node alone; the start is about right.
static void fit_node(const node *o, double g[3])
{
    const double a = o->alpha;
    double jj[9], jr[3], damping = 1e-3;
    g[0] = o->cosine * o->cosine + 7 * a * a / (1 + 5 * a * a);
    g[1] = o->cosine + a * (1 - a) * (1 - o->cosine);
    g[2] = 1 + 0.7 * a;
    for (double now = difference(o, g); damping < 1e9; damping *= 4) {
        normal_equations(o, g, jj, jr);
        for (int k = 0; k < 3; k++) jj[4 * k] *= 1 + damping;
        if (jj[4] < 1e-9 * jj[0]) jj[4] = 1; // seen along the normal there is no shear
        solve(3, jj, jr);
        for (int k = 0; k < 3; k++) jr[k] += g[k];
        const double next = jr[0] > 0 && jr[2] > 0 ? difference(o, jr) : now;
        if (!(next < now * (1 - 1e-12))) continue;
        memcpy(g, jr, sizeof jr);
        now = next;
        damping *= 0.01;
    }
}

// Least squares of a polynomial over all nodes: of what each node should have and how much it
// weighs.
static void fit_terms(const double *wanted, const double *weight, const double *factor,
                      double c[TERMS])
{
    double a[TERMS * TERMS] = {0}, t[TERMS];
    memset(c, 0, TERMS * sizeof *c);
    for (int i = 0; i < NODES; i++) {
        terms(&nodes[i], t);
        for (int k = 0; k < TERMS; k++) {
            c[k] += weight[i] * factor[i] * t[k] * wanted[i];
            for (int m = 0; m < TERMS; m++)
                a[k * TERMS + m] += weight[i] * factor[i] * factor[i] * t[k] * t[m];
        }
    }
    solve(TERMS, a, c);
}

static void start_shape(double c[SHAPE])
{
    static double g[NODES][3];
    double wanted[NODES], weight[NODES], factor[NODES];
    for (int i = 0; i < NODES; i++) fit_node(&nodes[i], g[i]);
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < NODES; i++) {
            const double m = nodes[i].cosine;
            wanted[i] = g[i][k] - (k == 0 ? m * m : k == 1 ? m : 1);
            weight[i] = k == 1 && m == 1 ? 0 : 1 / (g[i][k] * g[i][k]);
            factor[i] = nodes[i].alpha;
        }
        fit_terms(wanted, weight, factor, c + k * TERMS);
    }
}

// Adds a node to the normal equations of all terms.
static void add_node(const node *o, const double *c, double *a, double *b)
{
    double g[3], t[TERMS], jj[9], jr[3];
    evaluate(o, c, g);
    terms(o, t);
    normal_equations(o, g, jj, jr);
    for (int k = 0; k < SHAPE; k++) {
        b[k] += o->alpha * jr[k / TERMS] * t[k % TERMS];
        for (int m = 0; m < SHAPE; m++)
            a[k * SHAPE + m] +=
                o->alpha * o->alpha * jj[k / TERMS * 3 + m / TERMS] * t[k % TERMS] * t[m % TERMS];
    }
}

static void fit_shape(double c[SHAPE])
{
    static double a[SHAPE * SHAPE], damped[SHAPE * SHAPE];
    double b[SHAPE], step[SHAPE], damping = 1e-3, now = all_difference(c);
    for (int round = 0; round < 400 && damping < 1e12; round++) {
        memset(a, 0, sizeof a);
        memset(b, 0, sizeof b);
        for (int i = 0; i < NODES; i++) add_node(&nodes[i], c, a, b);
        for (; damping < 1e12; damping *= 4) {
            memcpy(damped, a, sizeof a);
            memcpy(step, b, sizeof b);
            for (int k = 0; k < SHAPE; k++)
                damped[k * SHAPE + k] += damping * (a[k * SHAPE + k] + 1e-9);
            solve(SHAPE, damped, step);
            for (int k = 0; k < SHAPE; k++) step[k] += c[k];
            const double next = all_difference(step);
            if (!(next < now)) continue;
            memcpy(c, step, sizeof step);
            now = next;
            damping *= 0.1;
            break;
        }
    }
}

// ---- Against the header

static void make_nodes(void)
{
    for (int i = 0; i < NODES; i++) {
        const double least = sqrt(0.02), root = least + (1 - least) * (i / ANGLES) / (ALPHAS - 1);
        make_node(&nodes[i], root * root, cos(88 * PI / 180 * (i % ANGLES) / (ANGLES - 1)));
    }
}

static void fit_sums(double whole[TERMS], double schlick[TERMS])
{
    double wanted[2][NODES], weight[NODES], factor[2][NODES];
    for (int i = 0; i < NODES; i++) {
        weight[i] = factor[0][i] = 1;
        factor[1][i] = pow(1 - nodes[i].cosine, 5);
        wanted[0][i] = nodes[i].whole;
        wanted[1][i] = nodes[i].schlick;
    }
    fit_terms(wanted[0], weight, factor[0], whole);
    fit_terms(wanted[1], weight, factor[1], schlick);
}

static void print(const char *name, const double *c)
{
    printf("    float %s = lightprobe_cubic(\n        a", name);
    for (int i = 0; i < 4; i++, c += 4)
        printf(",%slightprobe_cubic(r, %.5gf, %.5gf, %.5gf, %.5gf)", i == 0 ? " " : "\n        ",
               c[0], c[1], c[2], c[3]);
    printf(");\n");
}

// How far the header is from the fit: in parts of the fit, of the whole reflectance for sums.
static int check_header(const double *shape, const double *whole, const double *schlick)
{
    const float up[3] = {0, 0, 1};
    double worst = 0, sums = 0;
    for (int i = 0; i < NODES; i++) {
        const node *o = &nodes[i];
        const double m = o->cosine, sine = sqrt(1 - m * m);
        const float view[3] = {(float)-sine, 0, (float)m};
        const lightprobe_lobe lobe = lightprobe_specular_lobe(up, view, (float)o->alpha, up);
        double g[3], t[TERMS], e = 0, b = 0;
        evaluate(o, shape, g);
        terms(o, t);
        for (int k = 0; k < TERMS; k++) {
            e += whole[k] * t[k];
            b += pow(1 - m, 5) * schlick[k] * t[k];
        }
        const double x = lobe.shear / lobe.along, to_viewer = (m - sine * x) / sqrt(1 + x * x);
        const double fresnel = lobe.fresnel + pow(1 - sqrt(0.5 + 0.5 * to_viewer), 5);
        worst = fmax(worst, fmax(fabs(lobe.along / g[0] - 1), fabs(lobe.across / g[2] - 1)));
        worst = fmax(worst, fabs(lobe.shear - sine * g[1]) / (g[1] + sine));
        sums = fmax(sums,
                    fmax(fabs(lobe.whole - fmin(e, 1)), fabs(fresnel * (lobe.whole + 1e-3) - b)));
    }
    printf("lightprobe.h against the fit: matrix %.1e, sums %.1e\n", worst, sums);
    return worst < 1e-3 && sums < 1e-4;
}

// ---- Against rays, on area lights

// A rectangle of tangent t about where a mirror would show one, the normal being z and the viewer
// at x < 0.
static lightprobe_light random_light(uint64_t *seed, double alpha, double angle, double t)
{
    lightprobe_light l;
    const double off = 2 * alpha + t, phi = angle + test_range(seed, -1, 1) * off;
    const double aside = test_range(seed, -1, 1) * off, turn = test_range(seed, 0, PI);
    const double d[3] = {sin(phi) * cos(aside), sin(aside), cos(phi) * cos(aside)};
    const double e[3] = {cos(phi), 0, -sin(phi)};
    const double f[3] = {d[1] * e[2] - d[2] * e[1], d[2] * e[0] - d[0] * e[2],
                         d[0] * e[1] - d[1] * e[0]};
    memset(&l, 0, sizeof l);
    for (int i = 0; i < 3; i++) {
        l.direction[i] = (float)d[i];
        l.axis_u[i] = (float)(cos(turn) * e[i] + sin(turn) * f[i]);
        l.axis_v[i] = (float)(cos(turn) * f[i] - sin(turn) * e[i]);
    }
    l.tan_half_u = (float)t;
    l.tan_half_v = (float)(t * test_range(seed, 0.3, 1));
    l.cos_alpha = (float)(1 / sqrt(1 + t * t));
    return l;
}

// Sines of the half-sizes; the solid angle of the rectangle by four right triangles' corners.
static double solid_angle(const lightprobe_light *l, double *u, double *v)
{
    const double c = l->cos_alpha, tu = l->tan_half_u, tv = l->tan_half_v;
    *u = tu / sqrt(1 + tu * tu);
    *v = tv / sqrt(1 + tv * tv);
    return 4 * atan2(*u * *v, c * sqrt(c * c + *u * *u + *v * *v));
}

static double inner(const float *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Whether a ray meets the rectangle, or the disc that lightprobe_extract gives these half-sizes.
static int hits(const lightprobe_light *l, const double *ray, int disc)
{
    const double c = inner(l->direction, ray), away = c / l->cos_alpha;
    double u, v;
    if (disc) return c > l->cos_alpha;
    solid_angle(l, &u, &v);
    return away > 0 && fabs(inner(l->axis_u, ray)) < u * away &&
           fabs(inner(l->axis_v, ray)) < v * away;
}

// Radiance to the viewer of a light of radiance 1 by rays drawn by GGX, for f0 1 and 0.04.
static void trace(const lightprobe_light *l, double alpha, double cosine, int disc, double out[2])
{
    const int rays = 256;
    out[0] = out[1] = 0;
    for (int i = 0; i < rays * rays; i++) {
        sample s;
        double half;
        const double part =
            (i % rays + 0.5) / rays * 2; // both halves: light need not be symmetrical
        if (!draw(alpha, cosine, (i / rays + 0.5) / rays, part > 1 ? 2 - part : part, &s, &half))
            continue;
        if (part > 1) s.light[1] = -s.light[1];
        if (!hits(l, s.light, disc)) continue;
        const double part_of = s.value / s.density / (rays * rays), fresnel = pow(1 - half, 5);
        out[0] += part_of;
        out[1] += part_of * (0.04 + 0.96 * fresnel);
    }
}

// Rms of what is wrong in parts of rms radiance; the largest in parts of the light's radiance.
static void measure(double alpha, double low, double high, int disc, double rms[2], double *worst)
{
    const float up[3] = {0, 0, 1}, f0[3] = {1, 0.04f, 0.04f};
    double wrong[2] = {0}, right[2] = {0};
    uint64_t seed = 1;
    for (int i = 0; i < 400; i++) {
        const double angle = test_range(&seed, low, high) * PI / 180,
                     t = pow(10, test_range(&seed, -1.5, 0));
        const float view[3] = {(float)-sin(angle), 0, (float)cos(angle)};
        const lightprobe_lobe lobe = lightprobe_specular_lobe(up, view, (float)alpha, f0);
        lightprobe_light l = random_light(&seed, alpha, angle, t);
        double truth[2], u, v;
        float rgb[3];
        if (disc) { // the variance of its sines is (1 - c)(2 + c) / 6
            const double c = l.cos_alpha, sine2 = (1 - c) * (2 + c) / 2;
            l.tan_half_u = l.tan_half_v = (float)sqrt(sine2 / (1 - sine2));
        }
        for (int k = 0; k < 3; k++)
            l.irradiance[k] = (float)(disc ? 2 * PI * (1 - l.cos_alpha) : solid_angle(&l, &u, &v));
        trace(&l, alpha, cos(angle), disc, truth);
        lightprobe_specular(l, lobe, 0, 0, 0, rgb);
        for (int k = 0; k < 2; k++) {
            wrong[k] += pow(rgb[k] - truth[k], 2);
            right[k] += truth[k] * truth[k];
        }
        *worst = fmax(*worst, fabs(rgb[0] - truth[0]));
    }
    for (int k = 0; k < 2; k++) rms[k] = sqrt(wrong[k] / right[k]);
}

// In percent; f0 1 and 0.04.
static void table(void)
{
    static const double alphas[] = {0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1},
                        angles[] = {0, 40, 70, 85, 89.5};
    printf(
        "| alpha | 0 to 40 degrees | 40 to 70 | 70 to 85 | 85 to 89.5 | largest | discs |\n|---|---|---|---|---|---|---|\n");
    for (int i = 0; i < 8; i++) {
        double rms[2], worst = 0;
        printf("| %g |", alphas[i]);
        for (int k = 0; k < 4; k++) {
            measure(alphas[i], angles[k], angles[k + 1], 0, rms, &worst);
            printf(" %.1f, %.1f |", 100 * rms[0], 100 * rms[1]);
        }
        printf(" %.0f |", 100 * worst);
        measure(alphas[i], 0, 70, 1, rms, &worst);
        printf(" %.1f, %.1f |\n", 100 * rms[0], 100 * rms[1]);
    }
}

int main(int argc, char **argv)
{
    static double shape[SHAPE], whole[TERMS], schlick[TERMS];
    make_nodes();
    start_shape(shape);
    fit_shape(shape);
    fit_sums(whole, schlick);
    if (argc > 1 && !strcmp(argv[1], "table")) table();
    if (argc > 1 && !strcmp(argv[1], "print")) {
        print("along", shape);
        print("shear", shape + TERMS);
        print("across", shape + 2 * TERMS);
        print("whole", whole);
        print("schlick", schlick);
    }
    return !check_header(shape, whole, schlick);
}
