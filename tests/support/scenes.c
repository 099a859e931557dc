#include "scenes.h"

#include "test.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

// ---- vectors -------------------------------------------------------------------------------

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void set(double r[3], double x, double y, double z)
{
    r[0] = x;
    r[1] = y;
    r[2] = z;
}

static void cross(const double a[3], const double b[3], double r[3])
{
    set(r, a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
}

static void normalise(double a[3])
{
    const double length = sqrt(dot(a, a));
    for (int i = 0; i < 3; i++) a[i] /= length;
}

// r = a + t b
static void along(const double a[3], const double b[3], double t, double r[3])
{
    for (int i = 0; i < 3; i++) r[i] = a[i] + t * b[i];
}

// Two unit vectors across a unit vector.
static void across(const double n[3], double u[3], double v[3])
{
    const double other[3] = {fabs(n[0]) < 0.7, fabs(n[0]) >= 0.7, 0};
    cross(other, n, u);
    normalise(u);
    cross(n, u, v);
}

static void random_direction(uint64_t *state, double d[3])
{
    const double z = test_range(state, -1, 1), angle = test_range(state, 0, 2 * pi);
    const double r = sqrt(1 - z * z);
    set(d, r * cos(angle), r * sin(angle), z);
}

// ---- shapes --------------------------------------------------------------------------------

static shape *add(scene *s, shape_kind kind, double x, double y, double z)
{
    shape *o = &s->shapes[s->count < SCENE_SHAPES ? s->count++ : SCENE_SHAPES - 1];
    memset(o, 0, sizeof *o);
    o->kind = kind;
    set(o->centre, x, y, z);
    for (int i = 0; i < 3; i++) o->axis[i][i] = 1;
    return o;
}

void scene_add_sphere(scene *s, double x, double y, double z, double radius)
{
    set(add(s, SHAPE_SPHERE, x, y, z)->half, radius, radius, radius);
}

void scene_add_box(scene *s, double x, double y, double z, double hx, double hy, double hz)
{
    set(add(s, SHAPE_BOX, x, y, z)->half, hx, hy, hz);
}

void scene_add_disc(scene *s, double x, double y, double z, double radius, const double normal[3])
{
    shape *o = add(s, SHAPE_DISC, x, y, z);
    set(o->half, radius, radius, 0);
    memcpy(o->axis[2], normal, sizeof o->axis[2]);
    normalise(o->axis[2]);
    across(o->axis[2], o->axis[0], o->axis[1]);
}

void scene_turn_last(scene *s, const double axis_0[3], const double axis_2[3])
{
    shape *o = &s->shapes[s->count - 1];
    memcpy(o->axis[2], axis_2, sizeof o->axis[2]);
    normalise(o->axis[2]);
    cross(o->axis[2], axis_0, o->axis[1]);
    normalise(o->axis[1]);
    cross(o->axis[1], o->axis[2], o->axis[0]);
}

// Where the line p + t d enters and leaves a shape.
static int intersect(const shape *o, const double p[3], const double d[3], double *enter,
                     double *leave)
{
    double q[3];
    along(p, o->centre, -1, q);
    if (o->kind == SHAPE_SPHERE) {
        const double a = dot(d, d), b = dot(q, d), c = dot(q, q) - o->half[0] * o->half[0];
        const double square = b * b - a * c;
        if (square < 0) return 0;
        *enter = (-b - sqrt(square)) / a;
        *leave = (-b + sqrt(square)) / a;
        return 1;
    }
    if (o->kind == SHAPE_DISC) {
        const double slope = dot(d, o->axis[2]);
        if (fabs(slope) < 1e-12) return 0;
        double x[3];
        *enter = *leave = -dot(q, o->axis[2]) / slope;
        along(q, d, *enter, x);
        return dot(x, x) <= o->half[0] * o->half[0];
    }
    // Far from most boxes: outside of the sphere around it there is nothing to divide.
    const double a = dot(d, d), b = dot(q, d);
    if (a * dot(q, q) - b * b > 1.001 * a * dot(o->half, o->half)) return 0;
    *enter = -1e30;
    *leave = 1e30;
    for (int i = 0; i < 3; i++) {
        const double from = dot(q, o->axis[i]), slope = dot(d, o->axis[i]);
        if (fabs(slope) < 1e-12) {
            if (fabs(from) > o->half[i]) return 0;
            continue;
        }
        const double middle = -from / slope, reach = fabs(o->half[i] / slope);
        if (middle - reach > *enter) *enter = middle - reach;
        if (middle + reach < *leave) *leave = middle + reach;
    }
    return *enter <= *leave;
}

static void normal_at(const shape *o, const double point[3], const double ray[3], double n[3])
{
    double q[3];
    along(point, o->centre, -1, q);
    if (o->kind == SHAPE_SPHERE) {
        memcpy(n, q, sizeof q);
        normalise(n);
        return;
    }
    int face = 2;
    double side = -dot(ray, o->axis[2]);
    if (o->kind == SHAPE_BOX) {
        double farthest = -1;
        for (int i = 0; i < 3; i++) {
            const double x = dot(q, o->axis[i]);
            if (fabs(x) / o->half[i] <= farthest) continue;
            farthest = fabs(x) / o->half[i];
            face = i;
            side = x;
        }
    }
    for (int i = 0; i < 3; i++) n[i] = side < 0 ? -o->axis[face][i] : o->axis[face][i];
}

void scene_finish(scene *s)
{
    set(s->low, 1e30, 1e30, 1e30);
    set(s->high, -1e30, -1e30, -1e30);
    normalise(s->sun);
    for (int j = 0; j < s->count; j++) {
        const shape *o = &s->shapes[j];
        for (int i = 0; i < 3; i++) {
            double reach = o->half[0];
            if (o->kind == SHAPE_DISC) reach *= sqrt(1 - fmin(1, pow(o->axis[2][i], 2)));
            if (o->kind == SHAPE_BOX) {
                reach = 0;
                for (int k = 0; k < 3; k++) reach += fabs(o->axis[k][i]) * o->half[k];
            }
            s->low[i] = fmin(s->low[i], o->centre[i] - reach);
            s->high[i] = fmax(s->high[i], o->centre[i] + reach);
        }
    }
}

// ---- the scenes ----------------------------------------------------------------------------

static void ground(scene *s)
{
    scene_add_box(s, 0, -0.1, 0, 2.5, 0.1, 2.5);
    s->ground_casts = 1;
}

static void solids(scene *s)
{
    scene_add_box(s, 0, 0.5, 0, 0.5, 0.5, 0.5);
    scene_add_sphere(s, 1.2, 0.8, 0.4, 0.5);
    scene_add_sphere(s, -1.2, 1.3, -0.3, 0.35);
}

static void cloud_of_spheres(scene *s, uint64_t *state)
{
    for (int i = 0; i < 40; i++) {
        const double x = test_range(state, -1.5, 1.5), y = test_range(state, 0.2, 2.2);
        const double z = test_range(state, -1.5, 1.5);
        scene_add_sphere(s, x, y, z, test_range(state, 0.08, 0.23));
    }
}

static void crossed_grids(scene *s)
{
    for (int i = 0; i < 9; i++) {
        scene_add_box(s, -1.6 + 0.4 * i, 1, 0, 0.05, 1, 0.05);
        scene_add_box(s, 0, 0.4, -1.6 + 0.4 * i, 1.6, 0.05, 0.03);
    }
}

static void foliage(scene *s, uint64_t *state)
{
    scene_add_box(s, 0, 0.5, 0, 0.08, 0.5, 0.08);
    for (int i = 0; i < 150; i++) {
        const double r = 1.3 * sqrt(test_uniform(state)), angle = test_range(state, 0, 2 * pi);
        const double y = test_range(state, 0.9, 2.3), radius = test_range(state, 0.07, 0.15);
        double normal[3];
        random_direction(state, normal);
        scene_add_disc(s, r * cos(angle), y, r * sin(angle), radius, normal);
    }
}

static void thin_plates(scene *s)
{
    const double up[3] = {0.2, 1, 0.1}, aside[3] = {1, 0.5, 0};
    scene_add_disc(s, 0, 1.2, 0, 0.7, up);
    scene_add_disc(s, 0.9, 0.3, 0.6, 0.3, aside);
    scene_add_box(s, -1.1, 0.6, 0.2, 0.01, 0.6, 0.5);
    scene_add_box(s, 0.2, 0.5, -1.1, 0.7, 0.01, 0.2);
}

static void curved(scene *s)
{
    const double a[3] = {1, 0.4, 0.2}, b[3] = {0.3, -0.2, 1}, c[3] = {0.2, 1, -0.5};
    scene_add_sphere(s, 0, 0.7, 0, 0.9);
    scene_add_sphere(s, 0.9, 1.3, 0.3, 0.25);
    scene_add_sphere(s, -0.3, 1.75, 0.4, 0.12);
    scene_add_box(s, -1.1, 1, 0.6, 0.4, 0.25, 0.3);
    scene_turn_last(s, a, b);
    scene_add_box(s, 0.2, 1.9, -0.3, 0.15, 0.3, 0.1);
    scene_turn_last(s, b, c);
}

static void slats(scene *s)
{
    const double across_slats[3] = {1, 0, 0}, normal[3] = {0, -sin(0.6), cos(0.6)};
    for (int i = 0; i < 12; i++) {
        scene_add_box(s, 0, 0.2 + 0.16 * i, 0.8, 1.2, 0.06, 0.008);
        scene_turn_last(s, across_slats, normal);
    }
    scene_add_box(s, 0, 1, -0.9, 1.5, 1, 0.05);
}

static void box_on_ground(scene *s)
{
    ground(s);
    scene_add_box(s, 0, 0.5, 0, 0.6, 0.5, 0.4);
    scene_add_box(s, 1.3, 0.15, 0.8, 0.15, 0.15, 0.15);
}

static void near_and_far(scene *s)
{
    scene_add_sphere(s, 0.1, 0.25, 0.1, 0.2);
    scene_add_box(s, -0.5, 2.6, 0, 0.7, 0.05, 1);
    scene_add_sphere(s, 0.9, 0.6, -0.4, 0.15);
}

static void wall_and_column(scene *s)
{
    ground(s);
    scene_add_box(s, -0.2, 1.2, -1.2, 1.8, 1.2, 0.1);
    scene_add_box(s, 0.8, 0.8, 0.4, 0.12, 0.8, 0.12);
    scene_add_sphere(s, -0.8, 0.3, 0.5, 0.3);
}

void scene_make(scene *s, int which)
{
    static const struct {
        const char *name;
        double sun[3];
    } kinds[SCENE_COUNT] = {
        {"solids", {0.3, 1, 0.45}},        {"cloud of spheres", {0.3, 1, 0.45}},
        {"crossed grids", {0.3, 1, 0.45}}, {"box on the ground", {0.3, 1, 0.45}},
        {"thin plates", {0.3, 1, 0.45}},   {"near and far", {0.3, 1, 0.45}},
        {"foliage", {0.3, 1, 0.45}},       {"wall and column", {0.4, 0.9, -0.5}},
        {"curved", {0.5, 0.8, 0.3}},       {"slats", {0.2, 0.6, 0.8}}};
    uint64_t state = UINT64_C(0x9e3779b97f4a7c15) + (uint64_t)which;
    memset(s, 0, sizeof *s);
    s->name = kinds[which].name;
    memcpy(s->sun, kinds[which].sun, sizeof s->sun);
    switch (which) {
    case 0: solids(s); break;
    case 1: cloud_of_spheres(s, &state); break;
    case 2: crossed_grids(s); break;
    case 3: box_on_ground(s); break;
    case 4: thin_plates(s); break;
    case 5: near_and_far(s); break;
    case 6: foliage(s, &state); break;
    case 7: wall_and_column(s); break;
    case 8: curved(s); break;
    default: slats(s); break;
    }
    scene_finish(s);
}

mssm_result scene_light(const scene *s, double tan_half_u, double tan_half_v, mssm_light *light)
{
    const float axis_u[3] = {0.9f, 0.1f, -0.4f};
    float sun[3], low[3], high[3];
    for (int i = 0; i < 3; i++) {
        sun[i] = (float)s->sun[i];
        low[i] = (float)s->low[i];
        high[i] = (float)s->high[i];
    }
    return mssm_light_directional(light, sun, axis_u, (float)tan_half_u, (float)tan_half_v, low,
                                  high);
}

// ---- depth maps ----------------------------------------------------------------------------

// Solves row[i] . x = right[i] of three rows by Cramer's rule. (Arrays with their sizes are not what gcc 12
// -O3 -march=native takes them for.)
static void solve(double (*row)[3], const double *right, double *x)
{
    double minor[3];
    cross(row[1], row[2], minor);
    const double determinant = dot(row[0], minor);
    for (int k = 0; k < 3; k++) {
        double m[3][3];
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) m[i][j] = j == k ? right[i] : row[i][j];
        }
        cross(m[1], m[2], minor);
        x[k] = dot(m[0], minor) / determinant;
    }
}

// The rays of a light's shadow space: those of a directional light have one direction, those of a
// perspective one one origin. Points of the ray of (x,y) are origin + t ray, where t is the depth plus
// 1 for directional lights and the distance along the axis for perspective ones.
typedef struct shadow_rays {
    int perspective;
    double m[3][3], offset[3], same[3];
} shadow_rays;

static void shadow_rays_of(const mssm_light *light, shadow_rays *s)
{
    const int depth_row = light->perspective ? 3 : 2;
    const int rows[3] = {0, 1, depth_row};
    s->perspective = light->perspective;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) s->m[i][j] = (double)light->world_to_shadow[4 * j + rows[i]];
        s->offset[i] = (double)light->world_to_shadow[12 + rows[i]];
    }
    const double eye[3] = {-s->offset[0], -s->offset[1], -s->offset[2]}, way[3] = {0, 0, 1};
    solve(s->m, s->perspective ? eye : way, s->same);
}

static void shadow_ray(shadow_rays *s, double x, double y, double origin[3], double ray[3])
{
    const double way[3] = {x, y, 1};
    const double start[3] = {x - s->offset[0], y - s->offset[1], -1 - s->offset[2]};
    solve(s->m, s->perspective ? way : start, s->perspective ? ray : origin);
    memcpy(s->perspective ? origin : ray, s->same, sizeof s->same);
}

// What of the map a shape can cover: low x and y, high x and y, of a cube around it.
static void shadow_window(const shadow_rays *s, const shape *o, double window[4])
{
    const double size = o->kind == SHAPE_BOX ? sqrt(dot(o->half, o->half)) : o->half[0];
    window[0] = window[1] = 1e30;
    window[2] = window[3] = -1e30;
    for (int i = 0; i < 8; i++) {
        double p[3], at[3];
        for (int k = 0; k < 3; k++) p[k] = o->centre[k] + (i >> k & 1 ? 1.001 : -1.001) * size;
        for (int k = 0; k < 3; k++) at[k] = dot(s->m[k], p) + s->offset[k];
        const double w = s->perspective ? at[2] : 1;
        for (int k = 0; k < 2; k++) { // all of it where the cube reaches behind the light
            window[k] = fmin(window[k], w > 0 ? at[k] / w : -1e30);
            window[2 + k] = fmax(window[2 + k], w > 0 ? at[k] / w : 1e30);
        }
    }
}

void scene_depth(const scene *s, const mssm_light *light, int side, int samples, float *front,
                 float *back)
{
    const double z_near = light->perspective ? (double)light->z_near : 0;
    const double z_far = light->perspective ? (double)light->z_far : 2;
    double window[SCENE_SHAPES][4];
    shadow_rays rays;
    shadow_rays_of(light, &rays);
    for (int j = 0; j < s->count; j++) shadow_window(&rays, &s->shapes[j], window[j]);
    for (int i = 0; i < side * side * samples; i++) {
        // A rank-1 lattice: evenly spread for any number of samples, the centre for one.
        const int texel = i / samples, n = i % samples;
        const double dx = (n + 0.5) / samples, dy = fmod(0.5 + n * 0.6180339887498949, 1);
        const double x = -1 + 2 * (texel % side + dx) / side,
                     y = -1 + 2 * (texel / side + dy) / side;
        double origin[3], ray[3], first = z_far, last = z_far;
        shadow_ray(&rays, x, y, origin, ray);
        for (int j = 0; j < s->count; j++) {
            double enter, leave;
            const double *w = window[j];
            if (x < w[0] || y < w[1] || x > w[2] || y > w[3]) continue;
            if (!intersect(&s->shapes[j], origin, ray, &enter, &leave)) continue;
            // A thousandth of tolerance: shapes touch the planes of a fitted frustum.
            if (enter > z_near - 1e-3 && enter < first) first = enter;
            if (leave > z_near - 1e-3 && leave < last) last = leave;
        }
        front[i] = (float)(-1 + 2 * (first - z_near) / (z_far - z_near));
        if (back) back[i] = (float)(-1 + 2 * (last - z_near) / (z_far - z_near));
    }
}

// ---- receivers and the truth ---------------------------------------------------------------

// Where a ray through anywhere in the scene meets it first.
static int hit_along(const scene *s, const double ray[3], uint64_t *state, double point[3],
                     double normal[3])
{
    double aim[3], start[3], nearest = 1e30;
    for (int i = 0; i < 3; i++) aim[i] = test_range(state, s->low[i], s->high[i]);
    along(aim, ray, -20, start);
    const shape *hit = NULL;
    for (int j = 0; j < s->count; j++) {
        double enter, leave;
        if (!intersect(&s->shapes[j], start, ray, &enter, &leave) || enter >= nearest) continue;
        nearest = enter;
        hit = &s->shapes[j];
    }
    if (!hit) return 0;
    along(start, ray, nearest, point);
    normal_at(hit, point, ray, normal);
    return 1;
}

void scene_receiver(const scene *s, uint64_t *state, double point[3], double normal[3])
{
    if (!s->ground_casts && test_uniform(state) < 0.6) {
        const double x = test_range(state, -2, 2), z = test_range(state, -2, 2);
        set(point, x, s->ground, z);
        set(normal, 0, 1, 0);
        return;
    }
    for (;;) {
        double ray[3];
        random_direction(state, ray);
        ray[1] = -fabs(ray[1]) - 0.1;
        normalise(ray);
        // What faces away from the light is dark by itself: no shadow map is asked about it.
        if (hit_along(s, ray, state, point, normal) && dot(normal, s->sun) > 0.02) return;
    }
}

void scene_surface(const scene *s, uint64_t *state, double point[3], double normal[3])
{
    double ray[3];
    do random_direction(state, ray);
    while (!hit_along(s, ray, state, point, normal));
}

// Whether something lies between p and p + length d; what p itself touches does not count.
static int blocked(const scene *s, const double p[3], const double d[3], double length)
{
    for (int j = 0; j < s->count; j++) {
        double enter, leave;
        if (!intersect(&s->shapes[j], p, d, &enter, &leave)) continue;
        if (s->shapes[j].kind == SHAPE_DISC ? enter > 1e-5 && enter < length
                                            : fmin(leave, length) - fmax(enter, 0) > 1e-5) {
            return 1;
        }
    }
    return 0;
}

// Unit vectors of the light's frame from its matrix: u, v, and the way the light shines.
int scene_blocks(const scene *s, const double from[3], const double to[3])
{
    double ray[3];
    along(to, from, -1, ray);
    const double length = sqrt(dot(ray, ray));
    normalise(ray);
    return blocked(s, from, ray, length);
}

static void light_frame(const mssm_light *light, double frame[3][3])
{
    const int depth_row = light->perspective ? 3 : 2;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            frame[i][j] = (double)light->world_to_shadow[4 * j + (i < 2 ? i : depth_row)];
        }
        normalise(frame[i]);
    }
}

double scene_facing(const mssm_light *light, const double normal[3], double *reach)
{
    double frame[3][3];
    light_frame(light, frame);
    *reach = fabs(dot(frame[0], normal)) * (double)light->half_u +
             fabs(dot(frame[1], normal)) * (double)light->half_v;
    return -dot(frame[2], normal);
}

// Of rays to the light, those that get there; only_above: of those that leave upwards, 1 without any.
static double seen_share(const scene *s, const mssm_light *light, const double point[3],
                         const double normal[3], int only_above, int grid, uint64_t *state)
{
    double frame[3][3], start[3];
    shadow_rays rays; // whose origin is the middle of a perspective light
    light_frame(light, frame);
    shadow_rays_of(light, &rays);
    along(point, normal, 1e-5, start);
    int seen = 0, all = 0;
    for (int i = 0; i < grid * grid; i++) {
        const double a = -1 + 2 * (i % grid + test_uniform(state)) / grid;
        const double b = -1 + 2 * (i / grid + test_uniform(state)) / grid;
        double ray[3], length = 1e30;
        if (light->perspective) {
            along(rays.same, frame[0], a * (double)light->half_u, ray);
            along(ray, frame[1], b * (double)light->half_v, ray);
            along(ray, start, -1, ray);
            length = sqrt(dot(ray, ray));
        } else {
            for (int k = 0; k < 3; k++) ray[k] = -frame[2][k];
            along(ray, frame[0], a * (double)light->half_u, ray);
            along(ray, frame[1], b * (double)light->half_v, ray);
        }
        normalise(ray);
        if (only_above && dot(ray, normal) <= 0) continue;
        all++;
        seen += !blocked(s, start, ray, length);
    }
    return all ? (double)seen / all : 1;
}

double scene_visibility(const scene *s, const mssm_light *light, const double point[3],
                        const double normal[3], int grid, uint64_t *state)
{
    return seen_share(s, light, point, normal, 0, grid, state);
}

double scene_visibility_above(const scene *s, const mssm_light *light, const double point[3],
                              const double normal[3], int grid, uint64_t *state)
{
    return seen_share(s, light, point, normal, 1, grid, state);
}
