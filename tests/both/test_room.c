// Lights at finite places: a closed room of evenly bright rectangles whose probe has distances,
// against rays to these rectangles; the area light that stands for one; what bad distances do.
#include "../../lightprobe.h"
#include "../support/scenes.h"
#include "../support/test.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 64, MAP = 256, LIGHTS = 16, RECTANGLES = 10 };

// Radiance of one side of a rectangle: that which edge[0] x edge[1] points to.
typedef struct rectangle {
    double corner[3], edge[2][3], normal[3], radiance;
} rectangle;

typedef struct room {
    const char *name;
    rectangle r[RECTANGLES];
    int count, distances;
    double tube[3], tube_axis[3], tube_radius, tube_half, tube_radiance;
    scene casters;
    float *texels;
    lightprobe_cube cube;
    lightprobe_light light[LIGHTS];
    mssm_map *map[LIGHTS];
    char *memory;
    int lights;
} room;

static double probe[3] = {0, 0.6, 0};

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void set_normal(rectangle *r)
{
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        r->normal[i] = r->edge[0][j] * r->edge[1][k] - r->edge[0][k] * r->edge[1][j];
    }
    const double length = sqrt(dot(r->normal, r->normal));
    for (int i = 0; i < 3; i++) r->normal[i] /= length;
}

// axis: of its normal; sign: which way it shines. The other axes follow in their order.
static void add(room *o, int axis, double sign, double at, double low_u, double low_v,
                double size_u, double size_v, double radiance)
{
    rectangle *r = o->r + o->count++;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    memset(r, 0, sizeof *r);
    r->corner[axis] = at;
    r->corner[u] = low_u;
    r->corner[v] = low_v;
    r->edge[sign < 0][u] = size_u;
    r->edge[sign > 0][v] = size_v;
    set_normal(r);
    r->radiance = radiance;
}

// A rectangle anywhere; n: where it shines to, of any length; v: the direction of its side size[1].
static void add_panel(room *o, const double middle[3], const double n[3], const double v[3],
                      const double size[2], double radiance)
{
    rectangle *r = o->r + o->count++;
    double u[3];
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        u[i] = v[j] * n[k] - v[k] * n[j];
    }
    const double length_u = sqrt(dot(u, u)), length_v = sqrt(dot(v, v));
    for (int i = 0; i < 3; i++) {
        r->edge[0][i] = size[0] * u[i] / length_u;
        r->edge[1][i] = size[1] * v[i] / length_v;
        r->corner[i] = middle[i] - 0.5 * (r->edge[0][i] + r->edge[1][i]);
    }
    set_normal(r);
    r->radiance = radiance;
}

// How far along the ray the rectangle shines from; HUGE_VAL where it does not.
static double hit(const rectangle *r, const double from[3], const double ray[3])
{
    const double *n = r->normal, towards = dot(ray, n);
    double to[3], at[3];
    if (towards >= 0) return HUGE_VAL;
    for (int i = 0; i < 3; i++) to[i] = r->corner[i] - from[i];
    const double t = dot(to, n) / towards;
    if (t <= 0) return HUGE_VAL;
    for (int i = 0; i < 3; i++) at[i] = t * ray[i] - to[i];
    for (int e = 0; e < 2; e++) {
        const double part = dot(at, r->edge[e]) / dot(r->edge[e], r->edge[e]);
        if (part < 0 || part > 1) return HUGE_VAL;
    }
    return t;
}

// A room of 6 x 3 x 5 m, with what the number says.
static void make(room *o, int which)
{
    static const char *const names[] = {
        "lamp",      "window",         "bright wall", "all three",        "bars before the wall",
        "desk lamp", "panel upstands", "panel leans", "window at the end"};
    static const double up[3] = {0, 1, 0}, along[3] = {0, 0, 1};
    static const double desk[3] = {-0.7, 0.9, -0.6}, beside[3] = {1.3, 0.9, -0.9};
    static const double down[3] = {0.5, -1, 0.1}, forth[3] = {-0.3, 0, 1};
    static const double lean[3] = {-0.2, -1, -0.3}, over[3] = {0.9, 1.5, -0.7};
    const double dim = 0.02;
    memset(o, 0, sizeof *o);
    o->name = names[which];
    o->distances = 1;
    add(o, 0, 1, -3, 0, -2.5, 3, 5, dim);
    add(o, 0, -1, 3, 0, -2.5, 3, 5, dim);
    add(o, 1, 1, 0, -2.5, -3, 5, 6, dim);
    add(o, 1, -1, 3, -2.5, -3, 5, 6, dim);
    add(o, 2, 1, -2.5, -3, 0, 6, 3, dim);
    add(o, 2, -1, 2.5, -3, 0, 6, 3, dim);
    // In front of what they are on by a hair; the tracer knows no coplanar ones.
    if (which == 0 || which == 3) add(o, 1, -1, 2.1, 0.5, 0.6, 0.3, 0.4, 12);
    if (which == 1 || which == 3) add(o, 0, -1, 2.999, 0.9, -0.9, 1.2, 1.3, 2);
    for (int k = 0; k < 3 && which == 4; k++) add(o, 2, 1, -1.6, -1.4 + 0.5 * k, 0.4, 0.25, 0.9, 1);
    if (which >= 2 && which <= 4) add(o, 2, 1, -2.499, -2.2, 0.2, 2.4, 1.9, 1);
    if (which == 5) add_panel(o, desk, down, along, (double[2]){0.2, 0.2}, 20);
    if (which == 6) add_panel(o, beside, forth, up, (double[2]){0.6, 0.6}, 6);
    if (which == 7) add_panel(o, over, lean, along, (double[2]){0.5, 0.35}, 8);
    if (which == 8) add(o, 0, -1, 2.999, 0.9, 1.2, 1.2, 1.2, 3);
    scene *s = &o->casters;
    scene_add_sphere(s, 0.3, 0.35, 0.2, 0.25);
    scene_add_sphere(s, -0.4, 0.2, 0.4, 0.2);
    scene_add_box(s, -0.35, 0.3, -0.3, 0.12, 0.3, 0.12);
    scene_add_box(s, 0.45, 0.15, -0.35, 0.2, 0.02, 0.15);
    s->sun[1] = 1;
    scene_finish(s);
    o->texels = malloc(6 * SIDE * SIDE * 4 * sizeof *o->texels);
    o->memory = malloc(LIGHTS * mssm_map_bytes(MAP, 6));
    if (!o->texels || !o->memory) abort();
    o->cube.side = SIDE;
    o->cube.channels = 4;
    for (int face = 0; face < 6; face++) o->cube.face[face] = o->texels + face * SIDE * SIDE * 4;
}

static void drop(room *o)
{
    free(o->texels);
    free(o->memory);
}

// How far along a unit ray from the probe a straight tube is, or a ball if it has no length; HUGE_VAL where
// it is not.
static double hit_tube(const room *o, const double ray[3])
{
    double from[3], across[3];
    if (!(o->tube_half > 0)) {
        for (int c = 0; c < 3; c++) from[c] = o->tube[c] - probe[c];
        const double middle = dot(from, ray);
        const double under = middle * middle - dot(from, from) + o->tube_radius * o->tube_radius;
        return under > 0 && middle > 0 ? middle - sqrt(under) : HUGE_VAL;
    }
    const double *a = o->tube_axis, along = dot(ray, a);
    for (int c = 0; c < 3; c++) from[c] = probe[c] - o->tube[c];
    const double start = dot(from, a);
    for (int c = 0; c < 3; c++) {
        from[c] -= start * a[c];
        across[c] = ray[c] - along * a[c];
    }
    const double d2 = dot(across, across), b = dot(from, across) / (d2 + 1e-30);
    const double inside = b * b - (dot(from, from) - o->tube_radius * o->tube_radius) / d2;
    const double t = -b - sqrt(fmax(inside, 0));
    return inside > 0 && t > 0 && fabs(start + t * along) < o->tube_half ? t : HUGE_VAL;
}

// The probe from its centre, without the casters, 4 x 4 rays a texel; its distance is their harmonic
// mean, weighted by radiance. As a plain cube it would have, or mip maps: the mean of distances, or (2)
// of radiance over distance.
enum { WEIGHTED, PLAIN, OVER };
static void render_as(room *o, int kind)
{
    for (int i = 0; i < 6 * SIDE * SIDE; i++) {
        double sum = 0, inverse = 0, away = 0;
        for (int k = 0; k < 16; k++) {
            const double h = 2.0 / SIDE;
            float d[3];
            lightprobe_texel_direction(i / SIDE / SIDE,
                                       (float)((i % SIDE + (k % 4 + 0.5) / 4) * h - 1),
                                       (float)((i / SIDE % SIDE + (k / 4 + 0.5) / 4) * h - 1), d);
            const double ray[3] = {d[0], d[1], d[2]};
            double nearest = HUGE_VAL, radiance = 0;
            for (int r = 0; r < o->count; r++) {
                const double t = hit(o->r + r, probe, ray);
                if (t >= nearest) continue;
                nearest = t;
                radiance = o->r[r].radiance;
            }
            const double tube = o->tube_radius > 0 ? hit_tube(o, ray) : HUGE_VAL;
            if (tube < nearest) {
                nearest = tube;
                radiance = o->tube_radiance;
            }
            sum += radiance / 16;
            inverse += radiance / nearest / 16;
            away += nearest / 16;
        }
        for (int c = 0; c < 3; c++) o->texels[4 * i + c] = (float)sum;
        o->texels[4 * i + 3] = (float)(kind == PLAIN  ? away
                                       : kind == OVER ? inverse
                                                      : sum / inverse);
    }
}

static void render(room *o)
{
    render_as(o, WEIGHTED);
}

// A unit vector in proportion to the cosine to n.
static void cosine_ray(const double n[3], double u, double v, double ray[3])
{
    const double z = 2 * v - 1, r = sqrt(1 - z * z), a = 6.283185307179586 * u;
    const double sphere[3] = {r * cos(a), z, r * sin(a)};
    for (int c = 0; c < 3; c++) ray[c] = n[c] + sphere[c];
    const double length = sqrt(dot(ray, ray)) + 1e-30;
    for (int c = 0; c < 3; c++) ray[c] /= length;
}

// Irradiance by stratified rays: to the bright rectangles, and to wherever they meet the walls.
static double truth(const room *o, const double p[3], const double n[3], uint64_t *state)
{
    enum { GRID = 24, WALLS = 6 };
    double sum = 0;
    for (int k = WALLS - 1; k < o->count; k++) {
        const rectangle *r = o->r + k;
        const double *normal = r->normal;
        double part = 0;
        for (int i = 0; i < GRID * GRID; i++) {
            const double a = (i % GRID + test_uniform(state)) / GRID,
                         b = (i / GRID + test_uniform(state)) / GRID;
            double to[3], at[3], d2, cosine, away;
            if (k < WALLS) { // once, for all of them
                double nearest = HUGE_VAL;
                cosine_ray(n, a, b, to);
                for (int w = 0; w < WALLS; w++) nearest = fmin(nearest, hit(o->r + w, p, to));
                for (int c = 0; c < 3; c++) at[c] = p[c] + nearest * to[c];
                part += !scene_blocks(&o->casters, p, at) ? 3.14159265 : 0;
                continue;
            }
            for (int c = 0; c < 3; c++)
                at[c] = r->corner[c] + a * r->edge[0][c] + b * r->edge[1][c];
            for (int c = 0; c < 3; c++) to[c] = at[c] - p[c];
            d2 = dot(to, to), cosine = dot(to, n), away = -dot(to, normal);
            for (int w = WALLS; w < o->count; w++)
                if (hit(o->r + w, p, to) < 0.999) away = 0;
            if (cosine > 0 && away > 0 && !scene_blocks(&o->casters, p, at))
                part += cosine * away / (d2 * d2);
        }
        if (k >= WALLS) part *= sqrt(dot(r->edge[0], r->edge[0]) * dot(r->edge[1], r->edge[1]));
        sum += r->radiance * part / (GRID * GRID);
    }
    return sum;
}

static void extract(room *o, int lights)
{
    lightprobe_settings s;
    memset(&s, 0, sizeof s);
    s.max_lights = lights;
    s.distances = o->distances;
    const size_t bytes = lightprobe_scratch_bytes(SIDE, LIGHTS);
    void *scratch = malloc(bytes);
    CHECK(!lightprobe_extract(&o->cube, &s, scratch, bytes, o->light, &o->lights, NULL), "extract");
    for (int i = 0; i < o->lights; i++) {
        const float u = o->light[i].slope_u, v = o->light[i].slope_v;
        CHECK(fabsf(u) + fabsf(v) <= 2.4001f, "slopes %g %g", (double)u, (double)v);
    }
    free(scratch);
}

static void float3(const double v[3], float out[3])
{
    for (int i = 0; i < 3; i++) out[i] = (float)v[i];
}

// The lights' irradiance at receivers; places: at their distance, not at infinity; 2: facing the
// probe.
static void shade(room *o, int places, int count, double (*p)[3], double (*n)[3], double *out)
{
    float *depth = malloc(MAP * MAP * sizeof *depth), low[3], high[3], at[3];
    if (!depth) abort();
    float3(o->casters.low, low);
    float3(o->casters.high, high);
    float3(probe, at);
    memset(out, 0, (size_t)count * sizeof *out);
    for (int k = 0; k < o->lights; k++) {
        const lightprobe_light *l = o->light + k;
        lightprobe_light here = *l;
        mssm_light light;
        mssm_map *map;
        memset(&light, 0, sizeof light);
        if (!places) here.distance = 0;
        if (places == 2) here.slope_u = here.slope_v = 0;
        CHECK(!mssm_light_area(&light, at, l->direction, l->axis_u, l->tan_half_u, l->tan_half_v,
                               here.distance, low, high),
              "light");
        scene_depth(&o->casters, &light, MAP, 1, depth, NULL);
        CHECK(!mssm_map_init(&map, o->memory, mssm_map_bytes(MAP, 6), MAP, 6), "map");
        CHECK(!mssm_map_update(map, depth, NULL, 1), "update");
        for (int i = 0; i < count; i++) {
            const lightprobe_light seen =
                lightprobe_light_at(here, (float)(p[i][0] - probe[0]), (float)(p[i][1] - probe[1]),
                                    (float)(p[i][2] - probe[2]));
            float point[3], normal[3], cosine = 0;
            float3(p[i], point);
            float3(n[i], normal);
            for (int c = 0; c < 3; c++) cosine += normal[c] * seen.direction[c];
            const float e = seen.irradiance[1] * lightprobe_disc_irradiance(seen.cos_alpha, cosine);
            if (e > 0)
                out[i] +=
                    (double)(e * mssm_map_visibility_normal(map, &light, NULL, point, normal));
        }
    }
    free(depth);
}

static double rms(int count, const double *a, const double *b)
{
    double squares = 0;
    for (int i = 0; i < count; i++) squares += (a[i] - b[i]) * (a[i] - b[i]);
    return sqrt(squares / count);
}

enum { MOST = 600 };
static double point[MOST][3], normal[MOST][3], true_light[MOST], shaded[MOST];

// On the floor around the casters, or between them and facing any way.
static void place_receivers(const room *o, int count, uint64_t *state)
{
    for (int i = 0; i < count; i++) {
        double *p = point[i], *n = normal[i];
        do {
            for (int c = 0; c < 3; c++) n[c] = i % 2 ? test_range(state, -1, 1) : c == 1;
        } while (dot(n, n) > 1 || dot(n, n) < 0.01);
        const double length = sqrt(dot(n, n));
        for (int c = 0; c < 3; c++) n[c] /= length;
        double above[3];
        do { // not inside a caster
            p[0] = above[0] = test_range(state, -0.9, 0.9);
            p[1] = i % 2 ? test_range(state, 0.02, 0.6) : 1e-3;
            p[2] = above[2] = test_range(state, -0.9, 0.9);
            above[1] = p[1] + 1e-3;
        } while (scene_blocks(&o->casters, p, above));
    }
}

// Rooms first to last by lights at their places, and by these otherwise: shade()'s mode. Their error is
// at most that part of the other's, in the last room that one.
static void compare_places(uint64_t seed, int first, int last, int mode, const char *otherwise,
                           double part, double last_part)
{
    const int count = test_trials(MOST);
    uint64_t state = seed;
    for (int which = first; which <= last; which++) {
        room o;
        make(&o, which);
        render(&o);
        place_receivers(&o, count, &state);
        double mean = 0;
        for (int i = 0; i < count; i++)
            mean += (true_light[i] = truth(&o, point[i], normal[i], &state)) / count;
        for (int lights = 4; lights <= LIGHTS; lights *= 2) {
            extract(&o, lights);
            shade(&o, 1, count, point, normal, shaded);
            const double placed = rms(count, shaded, true_light) / mean;
            shade(&o, mode, count, point, normal, shaded);
            const double other = rms(count, shaded, true_light) / mean;
            test_note("%s, %d lights: error %.3f, %s %.3f", o.name, lights, placed, otherwise,
                      other);
            CHECK(count < MOST || placed < (which < last ? part : last_part) * other,
                  "%s, %d lights: %.3f, %s %.3f", o.name, lights, placed, otherwise, other);
        }
        drop(&o);
    }
}

static void places_halve_the_error(void)
{
    compare_places(11, 0, 4, 0, "at infinity", 0.5, 0.5);
}

// Of flat lamps beside the probe and of a window at the end of a wall most of the error is the
// cosine.
static void flat_emitters_shine_by_their_cosine(void)
{
    compare_places(12, 5, 8, 2, "facing the probe", 0.25, 0.8);
}

// Leaves on a bar and on the wall behind it may look like one steep plane.
static void bars_are_no_worse_for_slopes(void)
{
    compare_places(16, 4, 4, 2, "facing the probe", 1.02, 1.02);
}

// A panel alone: the normal of all its lights is the panel's.
static void slopes_are_the_panels(void)
{
    uint64_t state = 13;
    double worst = 1;
    for (int t = 0; t < test_trials(60); t++) {
        room o;
        double n[3], at[3], aside[3], cosine, away;
        make(&o, 0);
        o.count = 0;
        do {
            for (int c = 0; c < 3; c++) n[c] = test_range(&state, -1, 1);
            for (int c = 0; c < 3; c++) at[c] = test_range(&state, -2, 2);
            for (int c = 0; c < 3; c++) aside[c] = n[(c + 1) % 3] - n[(c + 2) % 3];
            away = sqrt(dot(at, at));
            cosine = -dot(n, at) / sqrt(dot(n, n)) / away;
        } while (cosine < 0.5 || away < 1 || dot(aside, aside) < 0.1);
        for (int c = 0; c < 3; c++) at[c] += probe[c];
        const double size[2] = {0.3 * away, 0.2 * away};
        add_panel(&o, at, n, aside, size, 5);
        memcpy(n, o.r->normal, sizeof n);
        render(&o);
        for (int i = 3; i < 24 * SIDE * SIDE; i += 4) // nothing but the panel has a place
            if (!(o.texels[i] > 0)) o.texels[i] = 0;
        extract(&o, 1 + t % 3);
        for (int k = 0; k < o.lights; k++) {
            const lightprobe_light *l = o.light + k;
            double to[3];
            for (int c = 0; c < 3; c++)
                to[c] = (double)(l->slope_u * l->axis_u[c] + l->slope_v * l->axis_v[c] -
                                 l->direction[c]);
            worst = fmin(worst, dot(to, n) / sqrt(dot(to, to)));
        }
        drop(&o);
    }
    test_note("normals are off by %.3f radians at most", acos(worst));
    CHECK(worst > 0.995, "a cosine of %g to the normal", worst);
}

// One light for a patch in any direction that is a ball, a corner, or near and far by turns: no
// plane fits, and it is taken for a disc that faces the probe.
static void what_is_no_plane_has_no_slope(void)
{
    uint64_t state = 14;
    double worst = 0;
    for (int t = 0; t < test_trials(60); t++) {
        room o;
        double d[3];
        make(&o, 0);
        do {
            for (int c = 0; c < 3; c++) d[c] = test_range(&state, -1, 1);
        } while (dot(d, d) > 1 || d[0] * d[0] + d[1] * d[1] < 0.1);
        const double length = sqrt(dot(d, d)), radius = test_range(&state, 0.2, 0.5);
        const double across[3] = {-d[1], d[0], 0}, side = sqrt(dot(across, across));
        for (int i = 0; i < 6 * SIDE * SIDE; i++) {
            const int x = i % SIDE, y = i / SIDE % SIDE;
            float w[3];
            lightprobe_texel_direction(i / SIDE / SIDE, (2 * (float)x + 1) / SIDE - 1,
                                       (2 * (float)y + 1) / SIDE - 1, w);
            const double to[3] = {w[0], w[1], w[2]}, along = dot(to, d) / length;
            const double inside = along * along - 1 + radius * radius;
            double away = along - sqrt(fmax(inside, 0));
            if (t % 4 == 1) away = 1 / (along - fabs(dot(to, across)) / side);
            if (t % 4 == 2) away = (x / 3 + y / 3) % 2 ? 1 : 1.5;
            if (t % 4 == 3) away = x / 4 % 3 || y / 4 % 3 ? 1 : 0.1;
            for (int c = 0; c < 3; c++) o.texels[4 * i + c] = along > 0 && inside > 0 ? 1 : 0;
            o.texels[4 * i + 3] = (float)away;
        }
        extract(&o, 1);
        CHECK(o.lights == 1, "%d lights", o.lights);
        const double slope = hypot((double)o.light[0].slope_u, (double)o.light[0].slope_v);
        worst = fmax(worst, slope);
        CHECK(slope < 0.1, "kind %d has a slope of %g", t % 4, slope);
        drop(&o);
    }
    test_note("largest slope %.3f", worst);
}

// A tube looks the same from all around it: lights along it have slopes along it, those of the line, and none
// across, which the dim walls beside it alone would tell.
static void tubes_have_no_slope_across(void)
{
    uint64_t state = 21;
    double across = 0, along = 0, sum = 0;
    int lights = 0;
    for (int t = 0; t < test_trials(40); t++) {
        room o;
        double at[3], length;
        make(&o, 0);
        o.count = 6;
        do {
            for (int c = 0; c < 3; c++) o.tube_axis[c] = test_range(&state, -1, 1);
            for (int c = 0; c < 3; c++) at[c] = test_range(&state, -1.6, 1.6);
            length = sqrt(dot(o.tube_axis, o.tube_axis));
            for (int c = 0; c < 3; c++) o.tube_axis[c] /= length;
        } while (length > 1 || fabs(dot(o.tube_axis, at)) > 0.3 || dot(at, at) < 1);
        for (int c = 0; c < 3; c++) o.tube[c] = probe[c] + at[c];
        o.tube_radius = test_range(&state, 0.008, 0.016);
        o.tube_half = test_range(&state, 0.5, 0.9);
        o.tube_radiance = 60;
        render(&o);
        extract(&o, LIGHTS);
        for (int k = 0; k < o.lights; k++) {
            const lightprobe_light *l = o.light + k;
            double d[3], tilt[3], from[3];
            for (int c = 0; c < 3; c++) {
                d[c] = l->direction[c];
                tilt[c] = (double)(l->slope_u * l->axis_u[c] + l->slope_v * l->axis_v[c]);
                from[c] = (double)l->distance * d[c] - at[c];
            }
            const double part = dot(from, o.tube_axis), cosine = dot(d, o.tube_axis);
            const double sine = sqrt(1 - cosine * cosine), straight = dot(tilt, o.tube_axis) / sine;
            if (dot(from, from) - part * part > 0.01) continue; // a wall
            const double flux = (double)l->irradiance[1];
            lights++;
            sum += flux;
            across += flux * fmax(dot(tilt, tilt) - straight * straight, 0);
            along += flux * fmin(pow(straight - cosine / sine, 2), 1);
        }
        drop(&o);
    }
    across = sqrt(across / sum);
    along = sqrt(along / sum);
    test_note("%d lights of tubes: slopes across of %.3f, along off by %.3f", lights, across,
              along);
    CHECK(lights > 0 && across < 0.15, "slopes across of %g", across);
    CHECK(along < 0.3, "slopes along off by %g", along);
}

// A bulb that is about a texel wide, walls behind it: means of radiance over distance have it at its own
// place, of its probe's 4 x 4 rays a texel as of single ones; means of distances do not.
static void filtered_distances_keep_lamps_in_place(void)
{
    uint64_t state = 22;
    double worst[3] = {0, 0, 0};
    for (int t = 0; t < test_trials(40); t++) {
        for (int kind = WEIGHTED; kind <= OVER; kind++) {
            const uint64_t again = state;
            room o;
            double at[3];
            make(&o, 0);
            o.count = 6;
            do {
                for (int c = 0; c < 3; c++) at[c] = test_range(&state, -1.2, 1.2);
            } while (dot(at, at) < 0.25 || at[1] < -0.5);
            for (int c = 0; c < 3; c++) o.tube[c] = probe[c] + at[c];
            o.tube_axis[0] = at[2] / hypot(at[0], at[2]);
            o.tube_axis[2] = -at[0] / hypot(at[0], at[2]);
            o.tube_half = o.tube_radius = sqrt(dot(at, at)) * test_range(&state, 0.01, 0.03);
            o.tube_radiance = 10000;
            o.distances = kind == OVER ? 2 : 1;
            render_as(&o, kind);
            extract(&o, 4);
            const double away = sqrt(dot(at, at));
            worst[kind] = fmax(worst[kind], fabs((double)o.light[0].distance / away - 1));
            if (kind < OVER) state = again;
            drop(&o);
        }
    }
    test_note(
        "distances are off by %.3f, of means of distances by %.2f, of means over them by %.3f",
        worst[WEIGHTED], worst[PLAIN], worst[OVER]);
    CHECK(worst[OVER] < 0.05, "%g off", worst[OVER]);
}

// Light of all lights at a receiver, nothing in between.
static double bare_light(const room *o, int facing, const double p[3], const double n[3])
{
    double sum = 0;
    for (int k = 0; k < o->lights; k++) {
        lightprobe_light l = o->light[k];
        if (facing) l.slope_u = l.slope_v = 0;
        l = lightprobe_light_at(l, (float)(p[0] - probe[0]), (float)(p[1] - probe[1]),
                                (float)(p[2] - probe[2]));
        float cosine = 0;
        for (int c = 0; c < 3; c++) cosine += (float)n[c] * l.direction[c];
        sum += (double)(l.irradiance[1] * lightprobe_disc_irradiance(l.cos_alpha, cosine));
    }
    return sum;
}

// A leaning panel goes around the probe: its light jitters (steps of steps) as that of the same lights
// facing the probe does, though leaves change hands; and the slopes are still the panel's.
static void slopes_go_on_smoothly(void)
{
    enum { RECEIVERS = 60, FRAMES = 80 };
    static double light[2][3][RECEIVERS];
    const size_t bytes = lightprobe_scratch_bytes(SIDE, LIGHTS);
    void *scratch = malloc(bytes);
    double jitter[2] = {0, 0}, error[2] = {0, 0};
    lightprobe_light before[LIGHTS];
    lightprobe_settings s;
    uint64_t state = 5;
    room o;
    make(&o, 0);
    place_receivers(&o, RECEIVERS, &state);
    memset(&s, 0, sizeof s);
    memset(&o.casters, 0, sizeof o.casters);
    s.max_lights = LIGHTS;
    s.distances = 1;
    for (int frame = 0; frame < FRAMES; frame++) {
        const double a = 0.002 * frame, at[3] = {1.3 * cos(a), 1.5, 1.3 * sin(a)};
        const double n[3] = {-0.6 * cos(a), -1, -0.6 * sin(a)}, v[3] = {-sin(a), 0, cos(a)};
        o.count = 6;
        add_panel(&o, at, n, v, (double[2]){0.4, 0.3}, 10);
        render(&o);
        memcpy(before, o.light, sizeof before);
        s.previous = frame ? before : NULL;
        s.previous_count = frame ? o.lights : 0;
        CHECK(!lightprobe_extract(&o.cube, &s, scratch, bytes, o.light, &o.lights, NULL), "frame");
        for (int i = 0; i < 2 * RECEIVERS; i++) {
            const int facing = i % 2, r = i / 2;
            double *now = &light[facing][frame % 3][r];
            const double last = light[facing][(frame + 2) % 3][r];
            const double first = light[facing][(frame + 1) % 3][r];
            *now = bare_light(&o, facing, point[r], normal[r]);
            if (frame > 1) jitter[facing] += pow(*now - 2 * last + first, 2);
            if (frame == FRAMES - 1)
                error[facing] += pow(*now - truth(&o, point[r], normal[r], &state), 2);
        }
    }
    for (int k = 0; k < 2; k++) {
        jitter[k] = sqrt(jitter[k] / RECEIVERS / (FRAMES - 2));
        error[k] = sqrt(error[k] / RECEIVERS);
    }
    test_note("jitter %.2g, facing the probe %.2g; error in the end %.2g, facing %.2g", jitter[0],
              jitter[1], error[0], error[1]);
    CHECK(jitter[0] < 1.5 * jitter[1], "jitter %g, not %g", jitter[0], jitter[1]);
    CHECK(error[0] < 0.4 * error[1], "error %g, not %g", error[0], error[1]);
    free(scratch);
    drop(&o);
}

// A bulb passes the probe, half a metre away, a step of 12 mm a frame: lights are reassigned, and what fades of
// one that has given the bulb away must not jump to the wall behind. The truth is that of a ball.
static void lights_that_fade_stay_in_place(void)
{
    enum { RECEIVERS = 40, FRAMES = 120 };
    const size_t bytes = lightprobe_scratch_bytes(SIDE, LIGHTS);
    const int most = test_trials(FRAMES) < 4 ? 4 : test_trials(FRAMES);
    void *scratch = malloc(bytes);
    static double last[RECEIVERS], last_true[RECEIVERS];
    double mean = 0, steps = 0, true_steps = 0, worst = 0;
    int count = 0;
    lightprobe_light before[LIGHTS];
    lightprobe_settings s;
    uint64_t state = 6;
    room o;
    make(&o, 0);
    for (int i = 0; i < RECEIVERS; i++) {
        do {
            for (int c = 0; c < 3; c++) point[i][c] = test_range(&state, -0.25, 0.25);
        } while (sqrt(dot(point[i], point[i])) > 0.25);
        do {
            for (int c = 0; c < 3; c++) normal[i][c] = test_range(&state, -1, 1);
        } while (dot(normal[i], normal[i]) > 1 || dot(normal[i], normal[i]) < 0.01);
        const double length = sqrt(dot(normal[i], normal[i]));
        for (int c = 0; c < 3; c++) normal[i][c] /= length;
        for (int c = 0; c < 3; c++) point[i][c] += probe[c];
    }
    memset(&s, 0, sizeof s);
    o.count = 6;
    o.tube_radius = 0.12;
    o.tube_radiance = 30;
    s.max_lights = LIGHTS;
    s.distances = 1;
    for (int frame = 0; frame < most; frame++) {
        o.tube[0] = probe[0] + 0.012 * (frame - 0.6 * FRAMES);
        o.tube[1] = probe[1];
        o.tube[2] = probe[2] + 0.45;
        render(&o);
        memcpy(before, o.light, sizeof before);
        s.previous = frame ? before : NULL;
        s.previous_count = frame ? o.lights : 0;
        CHECK(!lightprobe_extract(&o.cube, &s, scratch, bytes, o.light, &o.lights, NULL), "frame");
        for (int i = 0; i < RECEIVERS; i++) {
            double to[3];
            for (int c = 0; c < 3; c++) to[c] = o.tube[c] - point[i][c];
            const double away = sqrt(dot(to, to)), cosine = dot(to, normal[i]) / away;
            const double part = o.tube_radius / away, now = bare_light(&o, 0, point[i], normal[i]);
            const double all = cosine > part // the horizon does not cut it
                                   ? 3.14159265 * o.tube_radiance * part * part * cosine
                                   : 0;
            if (all > 0 && last_true[i] > 0) {
                const double step = now - last[i] - (all - last_true[i]);
                steps += step * step;
                true_steps += pow(all - last_true[i], 2);
                worst = fmax(worst, fabs(step));
                mean += all;
                count++;
            }
            last[i] = now;
            last_true[i] = all;
        }
    }
    mean /= count;
    steps = sqrt(steps / count) / mean;
    test_note("steps of the bulb's light are off by %.4f of it, at most by %.3f; its own are %.4f",
              steps, worst / mean, sqrt(true_steps / count) / mean);
    CHECK(most < FRAMES || (steps < 0.02 && worst < 0.25 * mean), "steps are off by %g, %g", steps,
          worst / mean);
    free(scratch);
    drop(&o);
}

// The probe passes lamps half a metre away, 12 mm a frame and twice that: lights that go on from the last
// frame's err against rays little more than such as are found afresh in each.
static void lights_keep_up_with_lamps(void)
{
    enum { RECEIVERS = 16, FRAMES = 150 };
    static const double down[3] = {0, -1, 0}, back[3] = {0, 0.2, 1}, forth[3] = {0, -0.3, -1};
    static const double left[3] = {-0.3, 0.9, 0.5}, right[3] = {0.5, 0.3, -0.45};
    static double offset[RECEIVERS][3];
    const size_t bytes = lightprobe_scratch_bytes(SIDE, LIGHTS);
    const int most = test_trials(FRAMES) < 8 ? 8 : test_trials(FRAMES);
    void *scratch = malloc(bytes);
    lightprobe_light going_on[LIGHTS], before[LIGHTS];
    lightprobe_settings s;
    uint64_t state = 24;
    room o;
    make(&o, 0);
    memset(&o.casters, 0, sizeof o.casters);
    for (int i = 0; i < RECEIVERS; i++) {
        do {
            for (int c = 0; c < 3; c++) normal[i][c] = test_range(&state, -1, 1);
        } while (dot(normal[i], normal[i]) > 1 || dot(normal[i], normal[i]) < 0.01);
        const double length = sqrt(dot(normal[i], normal[i]));
        for (int c = 0; c < 3; c++) normal[i][c] /= length;
        for (int c = 0; c < 3; c++) offset[i][c] = test_range(&state, -0.15, 0.15);
    }
    memset(&s, 0, sizeof s);
    s.max_lights = LIGHTS;
    s.distances = 1;
    for (int fast = 0; fast < 2; fast++) {
        double error[2] = {0, 0}, mean = 0;
        int count = 0, frames = most / (1 + fast);
        for (int frame = 0; frame < frames; frame++) {
            probe[0] = 0.012 * (1 + fast) * (frame - 0.5 * frames);
            o.count = 6;
            add_panel(&o, left, forth, down, (double[2]){0.14, 0.14}, 50);
            add_panel(&o, right, back, down, (double[2]){0.17, 0.17}, 40);
            for (int k = -1; k < 2; k += 2) add(&o, 1, -1, 2.9, 0.8, 1.2 * k, 0.2, 0.6, 8);
            render(&o);
            memcpy(before, going_on, sizeof before);
            s.previous = frame ? before : NULL;
            s.previous_count = frame ? count : 0;
            CHECK(!lightprobe_extract(&o.cube, &s, scratch, bytes, going_on, &count, NULL),
                  "frame");
            for (int i = 0; i < RECEIVERS; i++)
                for (int c = 0; c < 3; c++) point[i][c] = probe[c] + offset[i][c];
            for (int i = 0; i < RECEIVERS; i++)
                mean += (true_light[i] = truth(&o, point[i], normal[i], &state)) / RECEIVERS;
            for (int afresh = 0; afresh < 2; afresh++) {
                memcpy(o.light, going_on, sizeof going_on);
                o.lights = count;
                if (afresh) extract(&o, LIGHTS);
                for (int i = 0; i < RECEIVERS; i++)
                    error[afresh] +=
                        pow(bare_light(&o, 0, point[i], normal[i]) - true_light[i], 2) / RECEIVERS;
            }
        }
        for (int k = 0; k < 2; k++) error[k] = sqrt(error[k] / frames) / (mean / frames);
        test_note("%d mm a frame: error %.3f of the mean, afresh %.3f", 12 * (1 + fast), error[0],
                  error[1]);
        CHECK(error[0] < error[1] + 0.06, "error %g, afresh %g", error[0], error[1]);
    }
    probe[0] = 0;
    free(scratch);
    drop(&o);
}

// Strips of one radiance, by turns near and far, on a dark background: one light each side of a
// gap.
static void near_is_told_from_far(void)
{
    enum { N = 32 };
    static float texels[6 * N * N * 4];
    lightprobe_cube cube = {{0}, N, 4};
    lightprobe_light first[4], second[4];
    static unsigned char scratch[1 << 20];
    int count, i = 0;
    for (int face = 0; face < 6; face++) cube.face[face] = texels + face * N * N * 4;
    for (; i < 6 * N * N; i++) {
        const int x = i % N, y = i / N % N,
                  in = i / N / N == 4 && x >= 8 && x < 24 && y >= 8 && y < 24;
        for (int c = 0; c < 3; c++) texels[4 * i + c] = in ? 1 : 0;
        texels[4 * i + 3] = x & 4 ? 1 : 20;
    }
    lightprobe_settings s;
    memset(&s, 0, sizeof s);
    s.max_lights = 2;
    s.distances = 1;
    for (int scaled = 0; scaled < 2; scaled++) { // any unit will do
        const float unit = scaled ? 1e-3f : 1;
        for (i = 3; i < 24 * N * N; i += 4) texels[i] *= unit;
        CHECK(!lightprobe_extract(&cube, &s, scratch, sizeof scratch, first, &count, NULL) &&
                  count == 2,
              "extract");
        const float low = fminf(first[0].distance, first[1].distance),
                    high = fmaxf(first[0].distance, first[1].distance);
        CHECK(fabsf(low / unit - 1) < 1e-4f && fabsf(high / unit - 20) < 1e-2f,
              "lights at %g and %g, not %g and %g", (double)low, (double)high, (double)unit,
              20 * (double)unit);
        for (i = 3; i < 24 * N * N; i += 4) texels[i] /= unit;
    }
    // Without a use for distances nothing changes, to the last bit.
    s.distances = 0;
    lightprobe_extract(&cube, &s, scratch, sizeof scratch, first, &count, NULL);
    for (i = 3; i < 24 * N * N; i += 4) texels[i] = 0;
    s.distances = 1;
    lightprobe_extract(&cube, &s, scratch, sizeof scratch, second, &count, NULL);
    CHECK(!memcmp(first, second, 2 * sizeof *first) && first[0].distance == 0,
          "distances of 0 are not infinite");
}

// Every light is finite and the same as at infinity where its distances say nothing.
static void bad_distances_are_infinite(void)
{
    enum { N = 9 };
    static const float bad[] = {0, -1, 1e-20f, 1e20f, HUGE_VALF, -HUGE_VALF, NAN};
    static float texels[6 * N * N * 4];
    static unsigned char scratch[1 << 20];
    lightprobe_cube cube = {{0}, N, 4};
    lightprobe_light light[8], before[8];
    lightprobe_settings s;
    int count, was;
    memset(&s, 0, sizeof s);
    for (int face = 0; face < 6; face++) cube.face[face] = texels + face * N * N * 4;
    for (int i = 0; i < 6 * N * N * 4; i++) texels[i] = 1 + (float)(i * 7919 % 13);
    s.max_lights = 8;
    for (int mode = 0; mode < 4; mode++) {
        s.mode = mode / 2;
        s.distances = 0;
        lightprobe_extract(&cube, &s, scratch, sizeof scratch, before, &was, NULL);
        s.distances = 1 + mode % 2;
        for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
            lightprobe_stats stats;
            for (int i = 3; i < 6 * N * N * 4; i += 4) texels[i] = bad[k];
            CHECK(!lightprobe_extract(&cube, &s, scratch, sizeof scratch, light, &count, &stats),
                  "extract");
            CHECK(count == was && !memcmp(light, before, (size_t)count * sizeof *light),
                  "distances of %g", (double)bad[k]);
            CHECK(stats.repaired_texels == 0, "distances count as broken");
            for (int i = 3; i < 6 * N * N * 4; i += 8) // every other one at 2
                texels[i] = s.distances == 1 ? 2
                                             : (0.2126f * texels[i - 3] + 0.7152f * texels[i - 2] +
                                                0.0722f * texels[i - 1]) /
                                                   2;
            lightprobe_extract(&cube, &s, scratch, sizeof scratch, light, &count, NULL);
            for (int i = 0; i < count; i++)
                CHECK(light[i].distance > 2 && light[i].distance < 40, "half of %g: %g",
                      (double)bad[k], (double)light[i].distance);
        }
    }
    s.mode = 0;
    s.distances = 1;
    for (int i = 3; i < 6 * N * N * 4; i += 4)
        texels[i] = i & 4 ? 1e9f : 0; // twice as far in the mean
    lightprobe_extract(&cube, &s, scratch, sizeof scratch, light, &count, NULL);
    for (int i = 0; i < count; i++) CHECK(light[i].distance == 0, "%g", (double)light[i].distance);
    for (int i = 0; i < 6 * N * N * 4; i++)
        texels[i] = i % 4 == 3 ? 1e-9f : FLT_MAX; // sums are infinite
    CHECK(!lightprobe_extract(&cube, &s, scratch, sizeof scratch, light, &count, NULL), "extract");
    for (int i = 0; i < count; i++)
        CHECK(light[i].distance >= 0 && light[i].distance < 1, "%g", (double)light[i].distance);
    count = -1;
    cube.channels = 3;
    CHECK(lightprobe_extract(&cube, &s, scratch, sizeof scratch, light, &count, NULL) ==
              LIGHTPROBE_ERROR_CHANNELS,
          "RGB");
    cube.channels = 4;
    for (int k = -1; k < 4; k += 4) {
        s.distances = k;
        CHECK(lightprobe_extract(&cube, &s, scratch, sizeof scratch, light, &count, NULL) ==
                  LIGHTPROBE_ERROR_SETTINGS,
              "%d", k);
    }
    CHECK(count == -1, "a failure writes");
}

// Of a point: cosine over squared distance, next to it and far away; directions are unit at any
// distance.
static void points_at_places_are_exact(void)
{
    uint64_t state = 8;
    for (int t = 0; t < test_trials(4000); t++) {
        lightprobe_light l;
        double from[3], axis[3] = {0.36, 0.48, 0.8};
        memset(&l, 0, sizeof l);
        float3(axis, l.direction);
        l.irradiance[0] = l.cos_alpha = 1;
        l.distance = (float)exp(test_range(&state, -5, 5));
        const double away = (double)l.distance * exp(test_range(&state, -6, 21));
        do {
            for (int c = 0; c < 3; c++) from[c] = test_range(&state, -1, 1);
        } while (dot(from, from) > 1 || -dot(from, axis) < 0.1);
        float p[3];
        for (int c = 0; c < 3; c++) p[c] = (float)((double)l.distance * axis[c] + away * from[c]);
        const double d2 = away * away * dot(from, from),
                     cosine = -dot(from, axis) / sqrt(dot(from, from));
        const double truth = cosine * (double)l.distance * (double)l.distance / d2;
        const lightprobe_light seen = lightprobe_light_at(l, p[0], p[1], p[2]);
        double unit[3] = {seen.direction[0], seen.direction[1], seen.direction[2]};
        CHECK(fabs(dot(unit, unit) - 1) < 1e-3, "%g distances away: a direction of length %g",
              away / (double)l.distance, sqrt(dot(unit, unit)));
        CHECK(fabs((double)seen.irradiance[0] - truth) < 0.01 * truth + 1e-12,
              "%g distances away: %g, not %g", away / (double)l.distance,
              (double)seen.irradiance[0], truth);
    }
}

// Vector irradiance of a disc with this axis, over its radiance, by integration over it.
static void vector_of_disc(const double centre[3], const double axis[3], double radius,
                           const double p[3], double sum[3])
{
    enum { RINGS = 200, TURNS = 200 };
    const double u[3] = {axis[2], 0, -axis[0]}, long_u = sqrt(dot(u, u));
    double v[3];
    for (int c = 0; c < 3; c++) {
        const int j = (c + 1) % 3, k = (c + 2) % 3;
        v[c] = (axis[j] * u[k] - axis[k] * u[j]) / long_u;
        sum[c] = 0;
    }
    for (int i = 0; i < RINGS * TURNS; i++) {
        const double r = radius * sqrt((i % RINGS + 0.5) / RINGS),
                     a = 6.283185307 * (i / RINGS + 0.5) / TURNS;
        double to[3];
        for (int c = 0; c < 3; c++)
            to[c] = centre[c] - p[c] + r * (cos(a) * u[c] / long_u + sin(a) * v[c]);
        const double d2 = dot(to, to), part = dot(to, axis) / (d2 * d2);
        for (int c = 0; c < 3; c++)
            sum[c] += to[c] * part * 3.141592654 * radius * radius / (RINGS * TURNS);
    }
}

// Discs of radiance 1 at any place and angle, for receivers that see all of them, as the lights that
// their own vector irradiance at the probe makes of them.
static void discs_at_places_are_exact(void)
{
    const int trials = test_trials(400);
    const double none[3] = {0, 0, 0};
    int tested = 0;
    uint64_t state = 5;
    double worst = 0, steepest = 0;
    for (int t = 0; t < trials; t++) {
        lightprobe_light l;
        double centre[3], axis[3], p[3], sum[3], first[3], d[3], u[3], v[3], height, below;
        const double radius = exp(test_range(&state, -4, 0.7));
        do {
            for (int c = 0; c < 3; c++) axis[c] = test_range(&state, -1, 1);
            for (int c = 0; c < 3; c++) centre[c] = t % 2 ? test_range(&state, -2, 2) : axis[c];
            const double length = sqrt(dot(axis, axis)) + 1e-9;
            for (int c = 0; c < 3; c++) axis[c] /= length;
            height = dot(axis, centre);
        } while (height < 0.1 * radius || height < 0.1);
        vector_of_disc(centre, axis, radius, none, first);
        const double sine2 = sqrt(dot(first, first)) / 3.141592653589793;
        for (int c = 0; c < 3; c++) d[c] = first[c] / sqrt(dot(first, first));
        const double flat = hypot(d[0], d[1]), cosine = dot(axis, d);
        if (sine2 > 0.87 || flat < 0.1 || cosine < 0.3) continue;
        if (sine2 / cosine > 0.9 + 0.1 * sine2) continue; // its plane nearly meets the probe
        tested++;
        for (int c = 0; c < 3; c++) u[c] = c == 2 ? 0 : c ? -d[0] / flat : d[1] / flat;
        for (int c = 0; c < 3; c++)
            v[c] = d[(c + 1) % 3] * u[(c + 2) % 3] - d[(c + 2) % 3] * u[(c + 1) % 3];
        memset(&l, 0, sizeof l);
        float3(d, l.direction);
        float3(u, l.axis_u);
        float3(v, l.axis_v);
        l.slope_u = (float)(-dot(axis, u) / cosine);
        l.slope_v = (float)(-dot(axis, v) / cosine);
        l.distance = (float)(height / cosine);
        l.cos_alpha = (float)sqrt(1 - sine2);
        for (int c = 0; c < 3; c++)
            l.irradiance[c] = (float)(6.283185307 * (1 - (double)l.cos_alpha));
        const lightprobe_light same = lightprobe_light_at(l, 0, 0, 0);
        for (int c = 0; c < 3; c++)
            CHECK(fabsf(same.direction[c] - l.direction[c]) < 1e-4f, "direction at the probe");
        const float digits = t % 2 ? 1e-5f : 1e-6f; // tilted, or not
        CHECK(fabsf(same.irradiance[1] / l.irradiance[1] - 1) < 10 * digits &&
                  fabsf(same.cos_alpha - l.cos_alpha) < digits,
              "at the probe: %g, not %g", (double)same.irradiance[1], (double)l.irradiance[1]);
        do {
            for (int c = 0; c < 3; c++) p[c] = test_range(&state, -2, 2);
            below = height - dot(axis, p);
        } while (below < 0.2 * (radius + 1));
        vector_of_disc(centre, axis, radius, p, sum);
        const lightprobe_light seen = lightprobe_light_at(l, (float)p[0], (float)p[1], (float)p[2]);
        const double size = (double)seen.irradiance[0] * 0.5 * (1 + (double)seen.cos_alpha);
        for (int c = 0; c < 3; c++)
            worst =
                fmax(worst, fabs(size * (double)seen.direction[c] - sum[c]) / sqrt(dot(sum, sum)));
        steepest = fmax(steepest, hypot((double)l.slope_u, (double)l.slope_v));
    }
    test_note("worst vector irradiance %.2g of %d discs, slopes up to %.2g", worst, tested,
              steepest);
    CHECK(worst < 2e-3 && tested > trials / 2, "%g of %d", worst, tested); // of the sum
    // What has no place, is wider than that or lies behind.
    lightprobe_light l;
    memset(&l, 0, sizeof l);
    l.direction[1] = l.irradiance[0] = 1;
    l.cos_alpha = 0.9f;
    for (int k = 0; k < 2; k++) {
        const lightprobe_light seen = lightprobe_light_at(l, 1, 2, 3);
        CHECK(!memcmp(&seen, &l, sizeof l), "a light without a place moves");
        l.distance = 1;
        l.cos_alpha = -0.1f;
    }
    for (int k = 0; k < 5; k++) { // on it, in it, behind it, far away; points too
        const float y[] = {1, 1, 3, -1e30f, 0.5f};
        for (int c = 0; c < 2; c++) {
            l.cos_alpha = c ? 0.9f : 1;
            const lightprobe_light seen = lightprobe_light_at(l, k == 1 ? 0 : 0.1f, y[k], 0);
            CHECK(seen.irradiance[0] >= 0 && seen.irradiance[0] < 1e30f && seen.cos_alpha >= 0 &&
                      seen.cos_alpha <= 1,
                  "%d", k);
            CHECK(k == 4 || seen.irradiance[0] <= 0, "light at height %g", (double)y[k]);
        }
    }
}

// However a light is tilted, how wide it is and how near the receiver: a surface that faces it gets at most
// pi times its radiance, what a sky of that radiance all around would give.
static void nothing_outshines_its_radiance(void)
{
    uint64_t state = 23;
    double worst = 0;
    for (int t = 0; t < test_trials(200000); t++) {
        lightprobe_light l;
        float p[3];
        memset(&l, 0, sizeof l);
        const double angle = exp(test_range(&state, -6, 0.44)), reach = test_range(&state, -5, 1);
        l.direction[2] = l.axis_u[0] = l.axis_v[1] = l.distance = 1;
        l.slope_u = (float)test_range(&state, -2, 2);
        l.slope_v = (float)test_range(&state, -2, 2);
        const double edge = tan(angle) * (double)(fabsf(l.slope_u) + fabsf(l.slope_v));
        if (t % 2 && edge > 0.25) { // an edge is a quarter nearer, as of lights that are found
            l.slope_u *= (float)(0.25 / edge);
            l.slope_v *= (float)(0.25 / edge);
        }
        l.cos_alpha = (float)cos(angle);
        l.irradiance[1] = 1;
        for (int c = 0; c < 3; c++)
            p[c] = (float)((c == 2) + exp(reach) * test_range(&state, -1, 1));
        const double radiance = 1 / (6.283185307179586 * (1 - (double)l.cos_alpha));
        for (int k = 0; k < 2; k++) {
            const lightprobe_light seen =
                (k ? lightprobe_sphere_at : lightprobe_light_at)(l, p[0], p[1], p[2]);
            const float e =
                seen.irradiance[1] * lightprobe_disc_irradiance(seen.cos_alpha, 1); // facing it
            worst = fmax(worst, (double)e / (3.141592653589793 * radiance));
        }
    }
    test_note("at most %.4f of pi times the radiance", worst);
    CHECK(worst < 1 + 1e-5, "%g times pi times the radiance", worst);
    CHECK(worst > 0.9, "no receiver was close: %g", worst);
}

// A ball of even radiance: the light that a probe makes of it, by integration over what is seen,
// and its irradiance elsewhere, in closed form (facing the ball: radiance * pi * radius^2 /
// distance^2).
static void spheres_shine_to_all_sides(void)
{
    const int trials = test_trials(400);
    uint64_t state = 6;
    double worst = 0, wide = 0;
    for (int t = 0; t < trials; t++) {
        enum { RINGS = 2000 };
        const double radius = test_range(&state, 0.01, 0.5), away = exp(test_range(&state, -3, 3));
        double inverse = 0, all = 0, p[3];
        for (int i = 0; i < RINGS; i++) { // of equal solid angle
            const double least = sqrt(1 - radius * radius),
                         cosine = 1 - (1 - least) * (i + 0.5) / RINGS;
            inverse += 1 / (cosine - sqrt(cosine * cosine - 1 + radius * radius));
            all += 6.283185307179586 * (1 - least) / RINGS;
        }
        lightprobe_light l;
        memset(&l, 0, sizeof l);
        l.direction[2] = 1;
        for (int c = 0; c < 3; c++) l.irradiance[c] = (float)all;
        l.cos_alpha = (float)sqrt(1 - radius * radius);
        l.distance = (float)(away * RINGS / inverse);
        do {
            for (int c = 0; c < 3; c++) p[c] = test_range(&state, -2, 2);
        } while (p[0] * p[0] + p[1] * p[1] + (p[2] - 1) * (p[2] - 1) < 2 * radius * radius);
        const lightprobe_light seen = lightprobe_sphere_at(
            l, (float)(p[0] * away), (float)(p[1] * away), (float)(p[2] * away));
        const double to[3] = {-p[0], -p[1], 1 - p[2]}, d2 = dot(to, to);
        const double truth = 3.141592653589793 * radius * radius / d2;
        const double facing = (double)seen.irradiance[1] * 0.5 * (1 + (double)seen.cos_alpha);
        double cosine = 0;
        for (int c = 0; c < 3; c++) cosine += to[c] * (double)seen.direction[c] / sqrt(d2);
        const double off = fmax(fabs(facing / truth - 1), 1 - cosine);
        if (radius < 0.1) worst = fmax(worst, off);
        wide = fmax(wide, off);
    }
    test_note("worst irradiance %.2g, for radii up to 0.1 of the distance %.2g", wide, worst);
    CHECK(worst < 0.02 && wide < 0.3, "%g, %g", worst, wide);
    lightprobe_light l;
    memset(&l, 0, sizeof l);
    l.direction[1] = l.irradiance[0] = 1;
    l.cos_alpha = 0.9f;
    for (int k = 0; k < 2; k++) {
        const lightprobe_light seen = lightprobe_sphere_at(l, 1, 2, 3);
        CHECK(!memcmp(&seen, &l, sizeof l), "a light without a place moves");
        l.distance = 1;
        l.cos_alpha = -0.1f;
    }
    for (int k = 0; k < 10; k++) { // in its centre, in it, behind it, far away; points too
        const float y[] = {1, 1.2f, 3, -1e30f, -3e38f};
        l.cos_alpha = k > 4 ? 0.9f : 1;
        l.distance = k % 5 == 4 ? 1e-9f : 1;
        const lightprobe_light seen = lightprobe_sphere_at(l, 0, y[k % 5], 0);
        const float e = seen.irradiance[0], way = seen.direction[1];
        CHECK(e >= 0 && e < 1e30f && seen.cos_alpha >= 0 && seen.cos_alpha <= 1 && way >= -1 &&
                  way <= 1,
              "%d: %g", k, (double)e);
        CHECK(k % 5 != 2 || (e > 0 && way < 0), "not seen from behind");
        CHECK(k % 5 < 3 || e < 1e-20f, "seen from afar");
    }
}

static mssm_result area(mssm_light *l, float x, float distance, float size)
{
    const float at[3] = {x, 0, 0}, to[3] = {0, 2, 0}, axis[3] = {1, 0, 0}, low[3] = {-1, -1, -1},
                high[3] = {1, 1, 1};
    return mssm_light_area(l, at, to, axis, size, 0.5f * size, distance, low, high);
}

static void area_lights_cover_their_box(void)
{
    mssm_light l, endless;
    float shadow[3];
    for (int k = 0; k < 60; k++) {
        const float x = (float)(k % 3) - 1, distance = expf(-3 + 0.15f * (float)k),
                    size = 0.02f * (float)(k % 5);
        CHECK(!area(&l, x, distance, size), "area");
        for (int i = 0; i < 8; i++) {
            const float corner[3] = {i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f,
                                     i & 4 ? 1.0f : -1.0f};
            CHECK(mssm_light_project(&l, corner, shadow) && fabsf(shadow[0]) <= 1 &&
                      fabsf(shadow[1]) <= 1 && shadow[2] > -1 && shadow[2] < 0.81f,
                  "a corner outside of the map from %g", (double)distance);
        }
        if (!l.perspective) continue;
        const float centre[3] = {x, 0, 0}, away = l.half_u / fmaxf(size, 1e-9f);
        CHECK(size == 0 ||
                  (away >= 0.999f * distance && fabsf(l.half_v / away / (0.5f * size) - 1) < 1e-5f),
              "size");
        CHECK(mssm_light_project(&l, centre, shadow) && fabsf(shadow[0]) < 1e-5f,
              "not seen from the probe");
        CHECK(distance < 4 || size == 0 || fabsf(away / distance - 1) < 1e-5f,
              "moved from %g to %g", (double)distance, (double)away);
    }
    for (int k = 0; k < 4; k++) {
        const float far[4] = {0, HUGE_VALF, 700, 200};
        CHECK(!area(&l, 0, far[k], k == 3 ? 2.0f : 0) && !area(&endless, 0, 0, k == 3 ? 2.0f : 0),
              "far");
        CHECK(!l.perspective && !memcmp(&l, &endless, sizeof l), "a spot light at %g",
              (double)far[k]);
    }
    CHECK(!area(&l, 0, 200, 0) && l.perspective, "directional from 200");
    endless = l;
    for (int k = 0; k < 8;
         k++) { // a flat box far from the world's origin, right in front of the light
        const float at = expf((float)k), place[3] = {3 * at, 0.6f * at, 0.8f * at},
                    up[3] = {0.6f, 0, 0.8f}, u[3] = {0, 1, 0};
        const float low[3] = {3 * at, 0.6f * at, 0.8f * at},
                    high[3] = {3 * at, 1.1f * at, 0.8f * at};
        CHECK(!mssm_light_area(&l, place, up, u, 0.01f, 0.01f, 1e-4f * at, low, high), "area");
        for (int i = 0; i < 2; i++)
            CHECK(mssm_light_project(&l, i ? low : high, shadow) && shadow[2] > -1 &&
                      shadow[2] < 0.81f,
                  "flat, %g from the origin: depth %g", (double)at, (double)shadow[2]);
    }
    const float good[3] = {0, 1, 0}, bad[3] = {NAN, 0, 0}, null[3] = {0, 0, 0},
                huge[3] = {3e38f, 0, 0};
    const float wide[2][3] = {{-3e37f, -3e37f, -3e37f}, {3e37f, 3e37f, 3e37f}};
    CHECK(area(&l, 0, -1, 0) && area(&l, 0, NAN, 0) && area(&l, 0, -NAN, 0) &&
              !area(&l, 0, -0.0f, 0),
          "distance");
    CHECK(area(&l, 0, 3, -1) && area(NULL, 0, 3, 0) && area(&l, 0, 3e38f, 3e38f) == MSSM_OK,
          "size");
    l = endless;
    CHECK(mssm_light_area(&l, bad, good, good, 0, 0, 1, null, null) &&
              mssm_light_area(&l, NULL, good, good, 0, 0, 1, null, null) &&
              mssm_light_area(&l, good, null, good, 0, 0, 1, null, null) &&
              mssm_light_area(&l, good, good, good, 0, 0, 1, good, null),
          "arguments");
    CHECK(mssm_light_area(&l, huge, huge, good, 0.1f, 0.1f, 3e38f, wide[0], wide[1]) ==
              MSSM_ERROR_ARGUMENT,
          "a place beyond floats");
    CHECK(!memcmp(&l, &endless, sizeof l), "a failure writes");
    CHECK(!mssm_light_area(&l, null, good, good, 0, 0, 1, null, null), "a point for a box");
}

// Numbers of all sizes, those that matter among them.
static float any_number(uint64_t *state, double most)
{
    static const float some[] = {0,     1,      -1,     0.5f,   1e-3f,       1e-7f,
                                 1e-9f, 1e-20f, 1e-38f, 1e-42f, 0.99999994f, 3e38f};
    const double kind = test_range(state, 0, 3);
    const float x = kind < 1 ? some[(int)test_range(state, 0, 12)]
                             : (float)(pow(10, test_range(state, -40, kind < 2 ? 0 : 38)) *
                                       (test_range(state, 0, 2) < 1 ? -1 : 1));
    return (float)fmax(-most, fmin(most, (double)x));
}

// Half-angles about 90 degrees are those of lamps that light half of the sphere, give or take
// rounding.
static void any_place_gives_a_light(void)
{
    uint64_t state = 9;
    lightprobe_light l;
    memset(&l, 0, sizeof l);
    for (int i = 0; i < test_trials(300000); i++) {
        const float p[3] = {any_number(&state, 3e38), any_number(&state, 3e38),
                            any_number(&state, 3e38)};
        double length = 0;
        for (int c = 0; c < 3; c++) {
            l.direction[c] = (float)test_range(&state, -1, 1);
            l.irradiance[c] = fabsf(any_number(&state, 1e30));
            length += (double)l.direction[c] * (double)l.direction[c];
        }
        for (int c = 0; c < 3; c++) l.direction[c] /= (float)sqrt(length);
        const float *d = l.direction, aside = hypotf(d[0], d[1]) + 1e-9f;
        l.axis_u[0] = d[1] / aside;
        l.axis_u[1] = -d[0] / aside;
        for (int c = 0; c < 3; c++)
            l.axis_v[c] =
                d[(c + 1) % 3] * l.axis_u[(c + 2) % 3] - d[(c + 2) % 3] * l.axis_u[(c + 1) % 3];
        l.cos_alpha = any_number(&state, 1);
        l.slope_u = i % 2 ? any_number(&state, 3e38) : 0;
        l.slope_v = i % 4 > 1 ? any_number(&state, 3e38) : 0;
        l.distance = fabsf(any_number(&state, 3e38));
        for (int k = 0; k < 2; k++) {
            const lightprobe_light seen =
                (k ? lightprobe_sphere_at : lightprobe_light_at)(l, p[0], p[1], p[2]);
            int sound = seen.cos_alpha >= -1 && seen.cos_alpha <= 1;
            for (int c = 0; c < 3; c++)
                sound &= seen.irradiance[c] >= 0 && fabsf(seen.direction[c]) < 1.01f;
            CHECK(sound, "%d: cos_alpha %g, distance %g, at %g %g %g", k, (double)l.cos_alpha,
                  (double)l.distance, (double)p[0], (double)p[1], (double)p[2]);
        }
    }
    l.direction[0] = l.direction[2] = 0;
    l.direction[1] = l.irradiance[0] = l.distance = 1;
    l.axis_u[0] = l.axis_v[2] = 1;
    l.axis_u[1] = l.axis_u[2] = l.axis_v[0] = l.axis_v[1] = 0;
    for (int i = 0; i < 400; i++) { // where a lamp without size is, and next to it
        l.cos_alpha = i % 2 ? 1 : 0.99999994f;
        l.irradiance[1] = 1e26f;
        l.slope_u = (float)test_range(&state, -3, 3);
        const float aside = i % 4 < 2 ? 0 : (float)pow(10, test_range(&state, -30, -10));
        const float below = i % 8 < 4 ? 0 : (float)pow(10, test_range(&state, -7, -3));
        for (int k = 0; k < 2; k++) {
            const lightprobe_light seen =
                (k ? lightprobe_sphere_at : lightprobe_light_at)(l, aside, 1 - below, 0);
            CHECK(isfinite(seen.irradiance[1]) && seen.irradiance[1] >= 0 &&
                      fabsf(seen.direction[1]) < 1.01f,
                  "%d: irradiance %g, direction %g, %g aside, %g below", k,
                  (double)seen.irradiance[1], (double)seen.direction[1], (double)aside,
                  (double)below);
        }
    }
    l.slope_u = l.slope_v = 0;
    for (int k = 0; k < 2; k++) {
        l.cos_alpha = k ? 2e-3f : 1e-7f;
        const lightprobe_light seen = lightprobe_light_at(l, 0.3f, 0.2f, 0);
        const float e =
            seen.irradiance[0] * lightprobe_disc_irradiance(seen.cos_alpha, seen.direction[1]);
        CHECK(fabsf(e - 0.5f) < 2e-3f, "half of the sphere: %g", (double)e);
    }
}

const test_case room_tests[] = {
    {"lights at their places halve the error in a room", places_halve_the_error},
    {"flat emitters at places shine by their cosine", flat_emitters_shine_by_their_cosine},
    {"lights of bars before a wall err no more for their slopes", bars_are_no_worse_for_slopes},
    {"lights of a panel have its slopes", slopes_are_the_panels},
    {"lights of what is no plane have no slope", what_is_no_plane_has_no_slope},
    {"lights of tubes have no slope across", tubes_have_no_slope_across},
    {"distances that filters average keep lamps in place", filtered_distances_keep_lamps_in_place},
    {"slopes of lights go on smoothly", slopes_go_on_smoothly},
    {"lights that fade stay in place", lights_that_fade_stay_in_place},
    {"lights keep up with lamps that pass", lights_keep_up_with_lamps},
    {"lights tell what is near from what is far", near_is_told_from_far},
    {"bad distances of a probe are infinite", bad_distances_are_infinite},
    {"discs at finite places have the right vector irradiance", discs_at_places_are_exact},
    {"lights at finite places never outshine their radiance", nothing_outshines_its_radiance},
    {"spheres at finite places shine to all sides alike", spheres_shine_to_all_sides},
    {"points at finite places shine by cosine over squared distance", points_at_places_are_exact},
    {"places that are any numbers give lights", any_place_gives_a_light},
    {"area lights cover their casters' box", area_lights_cover_their_box},
    {NULL, NULL},
};
