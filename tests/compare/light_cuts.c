// Greedy rectangles and variance minimization, see light_cuts.h.
#include "light_cuts.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

// A light in the making.
typedef struct region {
    light_cut cut;
    double rgb[3]; // irradiance
    double flux;   // its luminance
    double variance;
} region;

static const float *texel_of(const lightprobe_cube *cube, int face, int x, int y)
{
    return cube->face[face] + (size_t)(y * cube->side + x) * (size_t)cube->channels;
}

static double luminance(const double rgb[3])
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

// Irradiance that a texel brings; as in lightprobe.h, what is negative or not finite counts as 0.
static double texel_flux(const lightprobe_cube *cube, int face, int x, int y, double rgb[3])
{
    const float *radiance = texel_of(cube, face, x, y);
    const double omega = (double)lightprobe_texel_solid_angle(cube->side, x, y);
    for (int c = 0; c < 3; c++) {
        rgb[c] = radiance[c] > 0 && isfinite(radiance[c]) ? omega * (double)radiance[c] : 0;
    }
    return luminance(rgb);
}

static double coordinate(const lightprobe_cube *cube, double at)
{
    return 2 * at / cube->side - 1;
}

// ---- Lights of regions

static int brighter(const void *a, const void *b)
{
    const double x = ((const region *)a)->flux, y = ((const region *)b)->flux;
    return x < y ? 1 : x > y ? -1 : 0;
}

static void direction_of(int face, double s, double t, double d[3])
{
    float direction[3];
    lightprobe_texel_direction(face, (float)s, (float)t, direction);
    for (int c = 0; c < 3; c++) d[c] = (double)direction[c];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// From one edge's middle to the other's, both seen on the plane at distance 1 from the centre.
static void across(const double centre[3], const double a[3], const double b[3], double out[3])
{
    const double to_a = dot(a, centre), to_b = dot(b, centre);
    for (int c = 0; c < 3; c++) out[c] = b[c] / to_b - a[c] / to_a;
}

static void set_axes(lightprobe_light *l, const double n[3], const double u[3], double half_u,
                     double half_v)
{
    const double v[3] = {n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2],
                         n[0] * u[1] - n[1] * u[0]};
    const bool turn = half_v > half_u; // the longer side is u
    for (int c = 0; c < 3; c++) {
        l->direction[c] = (float)n[c];
        l->axis_u[c] = (float)(turn ? v[c] : u[c]);
        l->axis_v[c] = (float)(turn ? -u[c] : v[c]);
    }
    l->tan_half_u = (float)(turn ? half_v : half_u);
    l->tan_half_v = (float)(turn ? half_u : half_v);
}

static void place_rectangle(const lightprobe_cube *cube, const light_cut *k, lightprobe_light *l)
{
    const double s0 = coordinate(cube, k->x0), s1 = coordinate(cube, k->x1);
    const double t0 = coordinate(cube, k->y0), t1 = coordinate(cube, k->y1);
    const double s = 0.5 * (s0 + s1), t = 0.5 * (t0 + t1);
    double n[3], a[3], b[3], u[3], v[3];
    direction_of(k->face, s, t, n);
    direction_of(k->face, s0, t, a);
    direction_of(k->face, s1, t, b);
    across(n, a, b, u);
    direction_of(k->face, s, t0, a);
    direction_of(k->face, s, t1, b);
    across(n, a, b, v);
    const double width = sqrt(dot(u, u)), along = dot(u, v) / width;
    for (int c = 0; c < 3; c++) u[c] /= width;
    set_axes(l, n, u, 0.5 * width, 0.5 * sqrt(fmax(dot(v, v) - along * along, 0)));
}

static void place_point(const lightprobe_cube *cube, const light_cut *k, lightprobe_light *l)
{
    double sum[3] = {0, 0, 0}, u[3] = {0, 0, 0}, rgb[3], d[3];
    for (int y = k->y0; y < k->y1; y++) {
        for (int x = k->x0; x < k->x1; x++) {
            const double flux = texel_flux(cube, k->face, x, y, rgb);
            direction_of(k->face, coordinate(cube, x + 0.5), coordinate(cube, y + 0.5), d);
            for (int c = 0; c < 3; c++) sum[c] += flux * d[c];
        }
    }
    const double length = sqrt(dot(sum, sum));
    for (int c = 0; c < 3; c++) sum[c] /= length;
    u[fabs(sum[0]) < 0.6 ? 0 : 1] = 1;
    const double in = dot(u, sum);
    for (int c = 0; c < 3; c++) u[c] = (u[c] - in * sum[c]) / sqrt(1 - in * in);
    set_axes(l, sum, u, 0, 0);
}

static int finish(const lightprobe_cube *cube, region *r, int count, int most, bool points,
                  lightprobe_light *lights, light_cut *cuts)
{
    int written = 0;
    qsort(r, (size_t)count, sizeof *r, brighter);
    for (int i = 0; i < count && written < most && r[i].flux > 0; i++) {
        const light_cut *k = &r[i].cut;
        lightprobe_light *l = &lights[written];
        double omega = 0;
        memset(l, 0, sizeof *l);
        (points ? place_point : place_rectangle)(cube, k, l);
        for (int y = k->y0; y < k->y1; y++) {
            for (int x = k->x0; x < k->x1; x++)
                omega += (double)lightprobe_texel_solid_angle(cube->side, x, y);
        }
        for (int c = 0; c < 3; c++) l->irradiance[c] = (float)r[i].rgb[c];
        l->solid_angle = (float)omega;
        l->cos_alpha = 1;
        l->id = written;
        cuts[written++] = *k;
    }
    return written;
}

// ---- Greedy rectangles

// One face: what is left of each texel's energy, and the last rectangle that covers it (-1: none).
typedef struct greedy {
    const lightprobe_cube *cube;
    int side, face;
    double *left;
    int *last;
    double mean; // energy a unit of solid angle
} greedy;

static void greedy_open(greedy *g, const lightprobe_cube *cube, int face)
{
    double rgb[3];
    g->cube = cube;
    g->side = cube->side;
    g->face = face;
    g->mean = 0;
    for (int y = 0; y < g->side; y++) {
        for (int x = 0; x < g->side; x++) {
            const int i = y * g->side + x;
            g->left[i] = texel_flux(cube, face, x, y, rgb);
            g->last[i] = -1;
            g->mean += g->left[i];
        }
    }
    g->mean /= 4 * acos(-1) / 6;
}

static double energy_of(const greedy *g, int x0, int y0, int x1, int y1)
{
    double sum = 0;
    for (int y = y0; y < y1; y++) {
        for (int x = x0; x < x1; x++) sum += g->left[y * g->side + x];
    }
    return sum;
}

// The brightest texel that no rectangle covers; -1: all are covered, or what is left is black.
static int seed_of(const greedy *g)
{
    int best = -1;
    for (int i = 0; i < g->side * g->side; i++) {
        if (g->last[i] < 0 && g->left[i] > (best < 0 ? 0 : g->left[best])) best = i;
    }
    return best;
}

static light_cut grow(const greedy *g, int seed, double threshold)
{
    const int n = g->side, x = seed % n, y = seed / n;
    light_cut k = {g->face, x, y, x + 1, y + 1};
    double sum = g->left[seed];
    for (bool grown = true; grown;) {
        grown = false;
        for (int edge = 0; edge < 4; edge++) {
            light_cut strip = k, wider = k;
            if (edge == 0) strip.x1 = k.x0, strip.x0 = wider.x0 = k.x0 - 1;
            if (edge == 1) strip.x0 = k.x1, strip.x1 = wider.x1 = k.x1 + 1;
            if (edge == 2) strip.y1 = k.y0, strip.y0 = wider.y0 = k.y0 - 1;
            if (edge == 3) strip.y0 = k.y1, strip.y1 = wider.y1 = k.y1 + 1;
            if (wider.x0 < 0 || wider.y0 < 0 || wider.x1 > n || wider.y1 > n) continue;
            const double more = energy_of(g, strip.x0, strip.y0, strip.x1, strip.y1);
            if (!(more > threshold * (sum + more))) continue;
            sum += more;
            k = wider;
            grown = true;
        }
    }
    return k;
}

static void give(const greedy *g, region *to, int texel, double energy)
{
    double rgb[3];
    const double whole = texel_flux(g->cube, g->face, texel % g->side, texel / g->side, rgb);
    for (int c = 0; c < 3 && whole > 0; c++) to->rgb[c] += rgb[c] * energy / whole;
    to->flux += energy;
}

// Takes the energy out of the face but for its average, which later rectangles may need to grow.
static void take(greedy *g, region *to, int number)
{
    const light_cut *k = &to->cut;
    for (int y = k->y0; y < k->y1; y++) {
        for (int x = k->x0; x < k->x1; x++) {
            const int i = y * g->side + x;
            const double rest = g->mean * (double)lightprobe_texel_solid_angle(g->side, x, y);
            g->last[i] = number;
            if (g->left[i] <= rest) continue;
            give(g, to, i, g->left[i] - rest);
            g->left[i] = rest;
        }
    }
}

// Adds the rectangles of one face; those beyond `room` are counted, not kept.
static int greedy_face(greedy *g, double threshold, region *r, int room)
{
    int count = 0;
    for (int seed = seed_of(g); seed >= 0 && count < room; seed = seed_of(g)) {
        memset(&r[count], 0, sizeof *r);
        r[count].cut = grow(g, seed, threshold);
        take(g, &r[count], count);
        count++;
    }
    // The paper doesn't say who gets what is still left; it would be lost if nobody did.
    for (int i = 0; i < g->side * g->side; i++)
        if (g->last[i] >= 0) give(g, &r[g->last[i]], i, g->left[i]);
    return seed_of(g) >= 0 ? room + 1 : count;
}

// The number of rectangles, room + 1 for more than that; -1 without memory.
static int greedy_all(const lightprobe_cube *cube, double threshold, region *r, int room)
{
    const size_t texels = (size_t)cube->side * (size_t)cube->side;
    greedy g;
    int count = 0;
    g.left = malloc(texels * sizeof *g.left);
    g.last = malloc(texels * sizeof *g.last);
    const bool memory = g.left && g.last;
    for (int face = 0; face < 6 && memory && count <= room; face++) {
        greedy_open(&g, cube, face);
        count += greedy_face(&g, threshold, r + count, room - count);
    }
    free(g.left);
    free(g.last);
    return memory ? count : -1;
}

int light_cuts_greedy(const lightprobe_cube *cube, float threshold, int most,
                      lightprobe_light *lights, light_cut *cuts)
{
    static const int room = LIGHT_CUTS_MOST;
    region *r = malloc((size_t)room * sizeof *r);
    int count = r ? greedy_all(cube, (double)threshold, r, room) : -1;
    if (count > room) count = room;
    count = count < 0 ? 0 : finish(cube, r, count, most, false, lights, cuts);
    free(r);
    return count;
}

// The number does not always rise with the threshold, so all of a fine scale are tried.
float light_cuts_threshold(const lightprobe_cube *cube, int most)
{
    region *r = malloc(LIGHT_CUTS_MOST * sizeof *r);
    float best = 0;
    int best_count = -1;
    for (int i = 0; i <= 120 && r; i++) {
        const double threshold = 0.5 / cube->side * pow(2.0 * cube->side, i / 120.0);
        const int count = greedy_all(cube, threshold, r, most);
        if (count > most || count <= best_count) continue;
        best_count = count;
        best = (float)threshold;
    }
    free(r);
    return best;
}

// ---- Variance minimization

// Sums of luminance and of luminance times direction over the texels left of and above a corner.
typedef struct moments {
    double flux, vector[3];
} moments;

typedef struct tables {
    int side;
    moments *sum; // [(face * (side + 1) + y) * (side + 1) + x]
} tables;

static moments *corner(const tables *t, int face, int x, int y)
{
    return &t->sum[((size_t)face * (size_t)(t->side + 1) + (size_t)y) * (size_t)(t->side + 1) +
                   (size_t)x];
}

static bool tables_create(tables *t, const lightprobe_cube *cube)
{
    const size_t edge = (size_t)cube->side + 1;
    double rgb[3], d[3];
    t->side = cube->side;
    t->sum = calloc(6 * edge * edge, sizeof *t->sum);
    if (!t->sum) return false;
    for (int i = 0; i < 6 * t->side * t->side; i++) {
        const int face = i / (t->side * t->side), x = i % t->side, y = i / t->side % t->side;
        const moments *a = corner(t, face, x, y + 1), *b = corner(t, face, x + 1, y);
        const moments *twice = corner(t, face, x, y);
        moments *m = corner(t, face, x + 1, y + 1);
        const double flux = texel_flux(cube, face, x, y, rgb);
        direction_of(face, coordinate(cube, x + 0.5), coordinate(cube, y + 0.5), d);
        m->flux = a->flux + b->flux - twice->flux + flux;
        for (int c = 0; c < 3; c++)
            m->vector[c] = a->vector[c] + b->vector[c] - twice->vector[c] + flux * d[c];
    }
    return true;
}

// Sum of luminance times squared distance from the centroid.
static double variance_of(const tables *t, const light_cut *k)
{
    const moments *a = corner(t, k->face, k->x0, k->y0), *b = corner(t, k->face, k->x1, k->y0);
    const moments *c = corner(t, k->face, k->x0, k->y1), *d = corner(t, k->face, k->x1, k->y1);
    const double flux = a->flux - b->flux - c->flux + d->flux;
    double square = 0;
    for (int i = 0; i < 3; i++) {
        const double v = a->vector[i] - b->vector[i] - c->vector[i] + d->vector[i];
        square += v * v;
    }
    return flux > 0 ? fmax(flux - square / flux, 0) : 0;
}

// The best of all lines across the region; false if it is a single texel.
static bool divide(const tables *t, const region *r, region *first, region *second)
{
    const light_cut *k = &r->cut;
    double least = HUGE_VAL;
    for (int i = 1; i < k->x1 - k->x0 + k->y1 - k->y0 - 1; i++) {
        light_cut a = *k, b = *k;
        if (i < k->x1 - k->x0)
            a.x1 = b.x0 = k->x0 + i;
        else
            a.y1 = b.y0 = k->y0 + i - (k->x1 - k->x0 - 1);
        const double va = variance_of(t, &a), vb = variance_of(t, &b);
        if (va + vb >= least) continue;
        least = va + vb;
        first->cut = a, first->variance = va;
        second->cut = b, second->variance = vb;
    }
    return least < HUGE_VAL;
}

static void sum_texels(const lightprobe_cube *cube, region *r)
{
    const light_cut *k = &r->cut;
    double rgb[3];
    for (int c = 0; c < 3; c++) r->rgb[c] = 0;
    for (int y = k->y0; y < k->y1; y++) {
        for (int x = k->x0; x < k->x1; x++) {
            texel_flux(cube, k->face, x, y, rgb);
            for (int c = 0; c < 3; c++) r->rgb[c] += rgb[c];
        }
    }
    r->flux = luminance(r->rgb);
}

int light_cuts_variance(const lightprobe_cube *cube, int most, lightprobe_light *lights,
                        light_cut *cuts)
{
    enum { ROOM = LIGHT_CUTS_MOST + 6 };
    region *r = malloc(ROOM * sizeof *r);
    tables t = {0, NULL};
    int count = 0;
    if (!r || !tables_create(&t, cube)) {
        free(r);
        return 0;
    }
    for (; count < 6; count++) {
        r[count].cut = (light_cut){count, 0, 0, cube->side, cube->side};
        r[count].variance = variance_of(&t, &r[count].cut);
    }
    while (count < most && count < ROOM) {
        int widest = 0;
        for (int i = 1; i < count; i++)
            if (r[i].variance > r[widest].variance) widest = i;
        const region whole = r[widest];
        if (whole.variance <= 0) break;
        if (divide(&t, &whole, &r[widest], &r[count]))
            count++;
        else
            r[widest].variance = 0; // rounding of a single texel
    }
    for (int i = 0; i < count; i++) sum_texels(cube, &r[i]);
    count = finish(cube, r, count, most, true, lights, cuts);
    free(t.sum);
    free(r);
    return count;
}
