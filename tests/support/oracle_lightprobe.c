#include "oracle_lightprobe.h"
#include "test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

// ------------------------------------------------------------------------------------------ probes

test_probe test_probe_new(int side)
{
    test_probe p = {side, {NULL}};
    for (int f = 0; f < 6; f++) p.face[f] = calloc((size_t)side * (size_t)side * 3, sizeof(float));
    return p;
}

void test_probe_free(test_probe *probe)
{
    for (int f = 0; f < 6; f++) free(probe->face[f]);
    memset(probe, 0, sizeof *probe);
}

lightprobe_cube test_probe_cube(const test_probe *probe)
{
    lightprobe_cube cube = {{NULL}, probe->side, 3};
    for (int f = 0; f < 6; f++) cube.face[f] = probe->face[f];
    return cube;
}

test_probe test_probe_load(const char *name)
{
    test_probe p = {0, {NULL}};
    const char *folder = getenv("SHARED_DATA");
    char path[1000];
    snprintf(path, sizeof path, "%s/probes/%s.pfm", folder ? folder : "../shared/data", name);
    FILE *file = fopen(path, "rb");
    int side, rows;
    float scale;
    if (file && fscanf(file, "PF %d %d %f", &side, &rows, &scale) == 3 && rows == 6 * side) {
        const int little = scale < 0; // the sign tells the byte order
        fgetc(file);
        p = test_probe_new(side);
        for (int r = rows - 1; r >= 0; r--) {
            float *row = p.face[r / side] + (size_t)(r % side) * (size_t)side * 3;
            for (int i = 0; i < 3 * side; i++) {
                unsigned char b[4] = {0};
                if (fread(b, sizeof b, 1, file) != 1) p.side = 0;
                uint32_t bits = 0;
                for (int k = 0; k < 4; k++) bits = bits << 8 | b[little ? 3 - k : k];
                memcpy(row + i, &bits, sizeof bits);
            }
        }
    }
    if (file) fclose(file);
    return p;
}

void oracle_direction(int face, double s, double t, double direction[3])
{
    const double table[6][3] = {{1, -t, -s}, {-1, -t, s}, {s, 1, t},
                                {s, -1, -t}, {s, -t, 1},  {-s, -t, -1}};
    const double length = sqrt(1 + s * s + t * t);
    for (int i = 0; i < 3; i++) direction[i] = table[face][i] / length;
}

static void texel_direction(int side, int face, int x, int y, double d[3])
{
    oracle_direction(face, -1 + (2 * x + 1.0) / side, -1 + (2 * y + 1.0) / side, d);
}

static void look_up(const test_probe *p, const double d[3], double rgb[3])
{
    const double ax = fabs(d[0]), ay = fabs(d[1]), az = fabs(d[2]);
    const int axis = ax >= ay && ax >= az ? 0 : ay >= az ? 1 : 2, face = 2 * axis + (d[axis] < 0);
    const double m = fabs(d[axis]);
    const double s[6] = {-d[2] / m, d[2] / m, d[0] / m, d[0] / m, d[0] / m, -d[0] / m};
    const double t[6] = {-d[1] / m, -d[1] / m, d[2] / m, -d[2] / m, -d[1] / m, -d[1] / m};
    const double x = (s[face] + 1) * p->side / 2 - 0.5, y = (t[face] + 1) * p->side / 2 - 0.5;
    memset(rgb, 0, 3 * sizeof *rgb);
    for (int k = 0; k < 4; k++) {
        const double fx = x - floor(x), fy = y - floor(y);
        int i = (int)floor(x) + (k & 1), j = (int)floor(y) + (k >> 1);
        const double w = (k & 1 ? fx : 1 - fx) * (k >> 1 ? fy : 1 - fy);
        i = i < 0 ? 0 : i >= p->side ? p->side - 1 : i;
        j = j < 0 ? 0 : j >= p->side ? p->side - 1 : j;
        const float *texel = p->face[face] + ((size_t)j * (size_t)p->side + (size_t)i) * 3;
        for (int c = 0; c < 3; c++) rgb[c] += w * (texel[c] > 0 ? (double)texel[c] : 0);
    }
}

test_probe test_probe_turned(const test_probe *probe, double yaw, double pitch)
{
    const double c = cos(yaw), s = sin(yaw), e = cos(pitch), f = sin(pitch);
    test_probe out = test_probe_new(probe->side);
    for (int face = 0; face < 6; face++) {
        for (int i = 0; i < probe->side * probe->side; i++) {
            double d[3], rgb[3];
            texel_direction(probe->side, face, i % probe->side, i / probe->side, d);
            const double x = c * d[0] + s * d[2], z = c * d[2] - s * d[0];
            const double turned[3] = {x, e * d[1] - f * z, f * d[1] + e * z};
            look_up(probe, turned, rgb);
            for (int k = 0; k < 3; k++) out.face[face][3 * i + k] = (float)rgb[k];
        }
    }
    return out;
}

const char *const test_scene_names[SCENE_COUNT] = {"sky and sun", "window", "lamps", "gradient",
                                                   "noise"};

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void scene_radiance(test_scene scene, const double d[3], uint64_t *random, double rgb[3])
{
    const double sun[3] = {0.36, 0.8, 0.48};
    if (scene == SCENE_SKY_SUN) {
        const double up = d[1] > 0 ? d[1] : 0, hot = dot(d, sun) > cos(pi / 180) ? 2000 : 0;
        const double haze = 3 * exp(-8 * (1 - dot(d, sun)));
        rgb[0] = (d[1] > 0 ? 0.8 - 0.5 * up : 0.15) + haze + hot;
        rgb[1] = (d[1] > 0 ? 0.9 - 0.4 * up : 0.12) + haze + hot * 0.9;
        rgb[2] = (d[1] > 0 ? 1.1 : 0.1) + haze + hot * 0.8;
    } else if (scene == SCENE_WINDOW) {
        const int in = d[0] > 0 && fabs(d[2] / d[0] - 0.9) < 0.3 && fabs(d[1] / d[0] - 0.2) < 0.5;
        rgb[0] = in ? 12 : 0.3 + 0.1 * d[1];
        rgb[1] = in ? 13 : 0.25;
        rgb[2] = in ? 15 : 0.2 - 0.1 * d[1];
    } else if (scene == SCENE_LAMPS) {
        uint64_t state = 7;
        rgb[0] = rgb[1] = rgb[2] = 0.02;
        for (int i = 0; i < 40; i++) {
            const double z = test_range(&state, -1, 1), a = test_range(&state, 0, 2 * pi);
            const double r = sqrt(1 - z * z), lamp[3] = {r * cos(a), z, r * sin(a)};
            const double power = test_range(&state, 5, 60), tint = test_uniform(&state);
            if (dot(d, lamp) < cos(test_range(&state, 0.01, 0.06))) continue;
            rgb[0] += power;
            rgb[1] += power * 0.8;
            rgb[2] += power * tint;
        }
    } else if (scene == SCENE_GRADIENT) {
        for (int c = 0; c < 3; c++) rgb[c] = 1 + 0.9 * (0.6 * d[c] + 0.64 * d[(c + 1) % 3]);
    } else {
        for (int c = 0; c < 3; c++) rgb[c] = pow(test_uniform(random), 6);
    }
}

test_probe test_scene_probe(test_scene scene, int side)
{
    test_probe out = test_probe_new(side);
    uint64_t random = 12345;
    for (int face = 0; face < 6; face++) {
        for (int i = 0; i < side * side; i++) {
            double d[3], rgb[3];
            texel_direction(side, face, i % side, i / side, d);
            scene_radiance(scene, d, &random, rgb);
            for (int c = 0; c < 3; c++) out.face[face][3 * i + c] = (float)rgb[c];
        }
    }
    return out;
}

test_probe test_disc_probe(int side, const double direction[3], double half_angle,
                           double background)
{
    test_probe out = test_probe_new(side);
    for (int face = 0; face < 6; face++) {
        for (int i = 0; i < side * side; i++) {
            int inside = 0;
            for (int k = 0; k < 16; k++) {
                double d[3];
                const double x = i % side + (k % 4 + 0.5) / 4, y = i / side + (k / 4 + 0.5) / 4;
                oracle_direction(face, -1 + 2 * x / side, -1 + 2 * y / side, d);
                inside += dot(d, direction) > cos(half_angle);
            }
            for (int c = 0; c < 3; c++)
                out.face[face][3 * i + c] = (float)(background + inside / 16.0);
        }
    }
    return out;
}

// ------------------------------------------------------------------------------- sums over texels

long double oracle_solid_angle(int side, int x, int y)
{
    const long double h = 2.0L / side, s = -1 + x * h, t = -1 + y * h;
    long double sum = 0;
    for (int k = 0; k < 4; k++) {
        const long double a = s + (k & 1) * h, b = t + (k >> 1) * h;
        const long double corner = atan2l(a * b, sqrtl(1 + a * a + b * b));
        sum += k == 0 || k == 3 ? corner : -corner;
    }
    return sum;
}

static double luminance(const double rgb[3])
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

// Calls visit with every texel's direction and radiance times solid angle.
static void each_texel(const test_probe *p, void (*visit)(const double *, const double *, void *),
                       void *user)
{
    const int n = p->side;
    double *omega = malloc((size_t)n * (size_t)n * sizeof *omega);
    for (int i = 0; i < n * n; i++) omega[i] = (double)oracle_solid_angle(n, i % n, i / n);
    for (int face = 0; face < 6; face++) {
        for (int i = 0; i < n * n; i++) {
            double d[3], flux[3];
            texel_direction(n, face, i % n, i / n, d);
            for (int c = 0; c < 3; c++) {
                const float value = p->face[face][3 * i + c];
                flux[c] = value > 0 ? (double)value * omega[i] : 0;
            }
            visit(d, flux, user);
        }
    }
    free(omega);
}

static void add_total(const double *d, const double *flux, void *user)
{
    (void)d;
    for (int c = 0; c < 3; c++) ((double *)user)[c] += flux[c];
}

void oracle_total(const test_probe *probe, double total[3])
{
    memset(total, 0, 3 * sizeof *total);
    each_texel(probe, add_total, total);
}

static void add_vector(const double *d, const double *flux, void *user)
{
    for (int c = 0; c < 3; c++) ((double *)user)[c] += d[c] * luminance(flux);
}

void oracle_vector(const test_probe *probe, double vector[3])
{
    memset(vector, 0, 3 * sizeof *vector);
    each_texel(probe, add_vector, vector);
}

// ------------------------------------------------------------------------------------ irradiance

double oracle_disc_irradiance(double cos_alpha, double cos_theta)
{
    const double alpha = acos(cos_alpha), sin_theta = sqrt(1 - cos_theta * cos_theta);
    const double node[3] = {-0.774596669241483377, 0, 0.774596669241483377};
    const double weight[3] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
    const int rings = 2000;
    double sum = 0, area = 0;
    for (int i = 0; i < 3 * rings; i++) {
        const double r = alpha * (i / 3 + 0.5 + 0.5 * node[i % 3]) / rings;
        const double a = cos(r) * cos_theta, b = sin(r) * sin_theta; // height = a + b cos phi
        const double phi = a >= b ? pi : a <= -b ? 0 : acos(-a / b);
        sum += weight[i % 3] * sin(r) * 2 * (a * phi + b * sin(phi));
        area += weight[i % 3] * sin(r) * 2 * pi;
    }
    return sum / area;
}

static void normal(int i, double n[3])
{
    const double z = 1 - (2 * i + 1.0) / ORACLE_NORMALS, a = i * 2.399963229728653;
    n[0] = sqrt(1 - z * z) * cos(a);
    n[1] = z;
    n[2] = sqrt(1 - z * z) * sin(a);
}

static void add_irradiance(const double *d, const double *flux, void *user)
{
    static double normals[ORACLE_NORMALS][3];
    if (normals[0][1] == 0)
        for (int i = 0; i < ORACLE_NORMALS; i++) normal(i, normals[i]);
    oracle_irradiance *e = user;
    for (int i = 0; i < ORACLE_NORMALS; i++) {
        const double cosine = dot(d, normals[i]);
        for (int c = 0; c < 3 && cosine > 0; c++) e->rgb[i][c] += cosine * flux[c];
    }
}

void oracle_irradiance_of_probe(const test_probe *probe, oracle_irradiance *out)
{
    memset(out, 0, sizeof *out);
    each_texel(probe, add_irradiance, out);
}

void oracle_irradiance_of_lights(const lightprobe_light *lights, int count, int paper,
                                 oracle_irradiance *out)
{
    memset(out, 0, sizeof *out);
    for (int i = 0; i < ORACLE_NORMALS; i++) {
        double n[3];
        normal(i, n);
        for (int k = 0; k < count; k++) {
            const lightprobe_light *l = lights + k;
            const double d[3] = {(double)l->direction[0], (double)l->direction[1],
                                 (double)l->direction[2]};
            const double cosine = dot(d, n), eq18 = 0.5 * (1 + (double)l->cos_alpha) * cosine;
            const double e = paper
                                 ? (cosine > 0 ? eq18 : 0)
                                 : (double)lightprobe_disc_irradiance(l->cos_alpha, (float)cosine);
            for (int c = 0; c < 3; c++) out->rgb[i][c] += e * (double)l->irradiance[c];
        }
    }
}

double oracle_error(const oracle_irradiance *truth, const oracle_irradiance *other)
{
    double squares = 0, mean = 0;
    for (int i = 0; i < ORACLE_NORMALS; i++) {
        const double a = luminance(truth->rgb[i]), b = luminance(other->rgb[i]);
        squares += (a - b) * (a - b);
        mean += a;
    }
    return 100 * sqrt(squares / ORACLE_NORMALS) / (mean / ORACLE_NORMALS);
}

// ----------------------------------------------------------------------------- irradiance behind edges

static void random_direction(uint64_t *random, double d[3])
{
    const double z = test_range(random, -1, 1), a = test_range(random, 0, 2 * pi);
    d[0] = sqrt(1 - z * z) * cos(a);
    d[1] = sqrt(1 - z * z) * sin(a);
    d[2] = z;
}

// The edge hides what lies from start to end along it, blurred over 1 / sharpness.
static double hidden(const oracle_edges *e, int k, const double d[3], double sharpness)
{
    const double at = dot(d, e->edge[k]);
    const double a = 0.5 + (at - e->start[k]) * sharpness, b = 0.5 + (at - e->end[k]) * sharpness;
    return (a < 0 ? 0 : a > 1 ? 1 : a) - (b < 0 ? 0 : b > 1 ? 1 : b);
}

typedef struct edge_sums {
    oracle_edges *edges;
    double sharpness;
} edge_sums;

static void add_seen(const double *d, const double *flux, void *user)
{
    const edge_sums *s = user;
    oracle_edges *e = s->edges;
    const double l = luminance(flux);
    for (int k = 0; k < e->count && l > 0; k++) {
        const double cosine = dot(d, e->normal[k]);
        if (cosine <= 0) continue;
        e->mean += cosine * l / e->count;
        e->seen[k] += cosine * l * (1 - hidden(e, k, d, s->sharpness));
    }
}

void oracle_edges_anywhere(const test_probe *probe, int count, uint64_t seed, oracle_edges *out)
{
    edge_sums s = {out, 0.5 * probe->side}; // a texel
    memset(out, 0, sizeof *out);
    out->count = count;
    for (int k = 0; k < count; k++) {
        random_direction(&seed, out->normal[k]);
        random_direction(&seed, out->edge[k]);
        out->end[k] = 9;
    }
    each_texel(probe, add_seen, &s);
}

// Draws directions by their light: each texel replaces the one before with the probability of its
// share of what has been seen so far.
typedef struct drawn_direction {
    uint64_t random;
    double sum, direction[ORACLE_EDGES][3];
    int count;
} drawn_direction;

static void draw_direction(const double *d, const double *flux, void *user)
{
    drawn_direction *s = user;
    const double l = luminance(flux);
    s->sum += l;
    for (int k = 0; k < s->count && l > 0; k++)
        if (test_uniform(&s->random) * s->sum < l)
            memcpy(s->direction[k], d, sizeof s->direction[k]);
}

void oracle_edges_near_light(const test_probe *probe, int count, uint64_t seed, oracle_edges *out)
{
    static drawn_direction drawn;
    edge_sums s = {out, 1e9}; // texels are points
    memset(out, 0, sizeof *out);
    memset(&drawn, 0, sizeof drawn);
    out->count = drawn.count = count;
    drawn.random = seed;
    each_texel(probe, draw_direction, &drawn);
    for (int k = 0; k < count; k++) {
        const double *d = drawn.direction[k];
        double *b = out->edge[k], along, length;
        do random_direction(&drawn.random, out->normal[k]);
        while (dot(out->normal[k], d) < 0.3);
        do random_direction(&drawn.random, b);
        while (fabs(dot(b, d)) > 0.9);
        along = dot(b, d);
        for (int i = 0; i < 3; i++) b[i] -= along * d[i];
        length = sqrt(dot(b, b));
        for (int i = 0; i < 3; i++) b[i] /= length;
        out->start[k] = test_range(&drawn.random, -1, 1) * (k % 2 ? 0.25 : 0.02);
        out->end[k] = k % 4 < 2 ? 9 : out->start[k] + 0.1;
    }
    each_texel(probe, add_seen, &s);
}

// Of the rectangle, in this many places.
static double seen_part(const oracle_edges *e, int k, const lightprobe_light *l)
{
    enum { N = 12 };
    double sum = 0;
    for (int i = 0; i < N * N; i++) {
        const double u = (2 * (i % N) + 1 - N) * (double)l->tan_half_u / N;
        const double v = (2 * (i / N) + 1 - N) * (double)l->tan_half_v / N;
        const double scale = 1 / sqrt(1 + u * u + v * v);
        double d[3];
        for (int c = 0; c < 3; c++)
            d[c] = scale *
                   ((double)l->direction[c] + u * (double)l->axis_u[c] + v * (double)l->axis_v[c]);
        sum += 1 - hidden(e, k, d, 1e9);
    }
    return sum / (N * N);
}

double oracle_edge_error(const oracle_edges *e, const lightprobe_light *lights, int count,
                         int paper, const lightprobe_stats *residual)
{
    double squares = 0;
    for (int k = 0; k < e->count; k++) {
        const double *n = e->normal[k];
        const double harmonic[9] = {1,
                                    n[1],
                                    n[2],
                                    n[0],
                                    n[0] * n[1],
                                    n[1] * n[2],
                                    3 * n[2] * n[2] - 1,
                                    n[2] * n[0],
                                    n[0] * n[0] - n[1] * n[1]};
        double sum = 0;
        for (int i = 0; residual && i < 9; i++) {
            double rgb[3];
            for (int c = 0; c < 3; c++) rgb[c] = (double)residual->residual_sh[i][c];
            sum += harmonic[i] * luminance(rgb);
        }
        for (int i = 0; i < count; i++) {
            const lightprobe_light *l = lights + i;
            double d[3], rgb[3];
            for (int c = 0; c < 3; c++) {
                d[c] = (double)l->direction[c];
                rgb[c] = (double)l->irradiance[c];
            }
            const double cosine = dot(d, e->normal[k]),
                         eq18 = 0.5 * (1 + (double)l->cos_alpha) * cosine;
            const double part =
                paper ? (cosine > 0 ? eq18 : 0)
                      : (double)lightprobe_disc_irradiance(l->cos_alpha, (float)cosine);
            if (part > 0) sum += part * luminance(rgb) * seen_part(e, k, l);
        }
        squares += (sum - e->seen[k]) * (sum - e->seen[k]);
    }
    return sqrt(squares / e->count) / e->mean;
}
