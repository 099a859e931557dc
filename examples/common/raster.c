#include "raster.h"

#include <stdlib.h>
#include <string.h>

// Samples at the corners of a turned grid: no two share a row or a column, so that nearly upright
// and nearly level edges are smoothed best.
static const float sample_grid[4][8][2] = {
    {{0.5f, 0.5f}},
    {{0.25f, 0.25f}, {0.75f, 0.75f}},
    {{0.375f, 0.125f}, {0.875f, 0.375f}, {0.125f, 0.625f}, {0.625f, 0.875f}},
    {{0.5625f, 0.3125f},
     {0.4375f, 0.6875f},
     {0.8125f, 0.5625f},
     {0.3125f, 0.1875f},
     {0.1875f, 0.8125f},
     {0.0625f, 0.4375f},
     {0.6875f, 0.9375f},
     {0.9375f, 0.0625f}},
};

static const float (*sample_positions(int samples))[2]
{
    return sample_grid[samples >= 8 ? 3 : samples >= 4 ? 2 : samples >= 2 ? 1 : 0];
}

void raster_sample_position(int samples, int s, float *x, float *y)
{
    *x = sample_positions(samples)[s][0];
    *y = sample_positions(samples)[s][1];
}

// ---- Triangles to samples

typedef struct point4 {
    float x, y, z, w;
} point4;

typedef struct target {
    int width, height, samples;
    bool flip_y;      // row 0 at the top
    float *depth;     // smaller is nearer
    int *triangle;    // or NULL
    bool perspective; // see raster_frustum
    float z_near, z_far;
} target;

// A function that is linear over the picture.
typedef struct plane {
    float dx, dy, c;
} plane;

typedef struct setup {
    plane edge[3]; // >= 0 inside, 1 at the opposite corner
    plane depth;   // z, or 1/w in perspective
    float low_x, high_x, low_y, high_y;
} setup;

static float plane_at(const plane *p, float x, float y)
{
    return p->dx * x + p->dy * y + p->c;
}

// Positions in pixels. False for triangles seen from behind or edge on.
static bool triangle_setup(setup *t, const float x[3], const float y[3], const float value[3])
{
    const double area = ((double)x[1] - (double)x[0]) * ((double)y[2] - (double)y[0]) -
                        ((double)x[2] - (double)x[0]) * ((double)y[1] - (double)y[0]);
    if (!(area > 0)) return false;
    t->depth = (plane){0, 0, 0};
    for (int i = 0; i < 3; i++) {
        const int a = (i + 1) % 3, b = (i + 2) % 3;
        const double dx = ((double)y[a] - (double)y[b]) / area;
        const double dy = ((double)x[b] - (double)x[a]) / area;
        const double c = -dx * (double)x[a] - dy * (double)y[a];
        t->edge[i] = (plane){(float)dx, (float)dy, (float)c};
        t->depth.dx += (float)dx * value[i];
        t->depth.dy += (float)dy * value[i];
        t->depth.c += (float)c * value[i];
    }
    t->low_x = fminf(x[0], fminf(x[1], x[2]));
    t->high_x = fmaxf(x[0], fmaxf(x[1], x[2]));
    t->low_y = fminf(y[0], fminf(y[1], y[2]));
    t->high_y = fmaxf(y[0], fmaxf(y[1], y[2]));
    return true;
}

// Two triangles that share an edge must leave no sample between them, whatever the rounding: a hole
// of one sample lets light through, a hair of overlap does not show.
static float edge_slack(const plane *p)
{
    return 2e-4f * (fabsf(p->dx) + fabsf(p->dy));
}

// Narrows [low, high] to where the edge can be inside somewhere in the row of pixels y .. y+1.
static void narrow(const plane *p, float y, float *low, float *high)
{
    const float inside = p->c + p->dy * (p->dy > 0 ? y + 1 : y) + edge_slack(p);
    if (p->dx > 0)
        *low = fmaxf(*low, -inside / p->dx);
    else if (p->dx < 0)
        *high = fminf(*high, -inside / p->dx);
    else if (inside < 0)
        *high = *low - 1;
}

static int clamp_to(float x, int low, int high)
{
    return x > (float)low ? (x < (float)high ? (int)x : high) : low;
}

static void fill_pixel(const target *to, const setup *t, int x, int y, int index)
{
    const float(*grid)[2] = sample_positions(to->samples);
    const int row = to->flip_y ? to->height - 1 - y : y;
    const size_t first = ((size_t)row * (size_t)to->width + (size_t)x) * (size_t)to->samples;
    for (int s = 0; s < to->samples; s++) {
        const float px = (float)x + grid[s][0], py = (float)y + grid[s][1];
        if (plane_at(&t->edge[0], px, py) < -edge_slack(&t->edge[0]) ||
            plane_at(&t->edge[1], px, py) < -edge_slack(&t->edge[1]) ||
            plane_at(&t->edge[2], px, py) < -edge_slack(&t->edge[2])) {
            continue;
        }
        float z = plane_at(&t->depth, px, py);
        if (to->perspective) z = -1 + 2 * (1 / z - to->z_near) / (to->z_far - to->z_near);
        // What lies before the near plane is cut off; a cut through a triangle may round to below
        // -1.
        if (!(z >= -1.000001f && z < to->depth[first + (size_t)s])) continue;
        to->depth[first + (size_t)s] = z > -1 ? z : -1;
        if (to->triangle) to->triangle[first + (size_t)s] = index;
    }
}

// Row by row, from the left edge to the right: long thin triangles would waste their bounding box.
static void fill_triangle(const target *to, const point4 corner[3], bool backwards, int index)
{
    float x[3], y[3], value[3];
    setup t;
    for (int i = 0; i < 3; i++) {
        const point4 p = corner[backwards ? 2 - i : i];
        x[i] = (p.x / p.w * 0.5f + 0.5f) * (float)to->width;
        y[i] = (p.y / p.w * 0.5f + 0.5f) * (float)to->height;
        value[i] = to->perspective ? 1 / p.w : p.z;
    }
    if (!triangle_setup(&t, x, y, value)) return;
    const int y0 = clamp_to(t.low_y, 0, to->height), y1 = clamp_to(t.high_y, -1, to->height - 1);
    for (int row = y0; row <= y1; row++) {
        float low = t.low_x, high = t.high_x;
        for (int i = 0; i < 3; i++) narrow(&t.edge[i], (float)row, &low, &high);
        const int x0 = clamp_to(low, 0, to->width), x1 = clamp_to(high, -1, to->width - 1);
        for (int column = x0; column <= x1 && high >= low; column++) {
            fill_pixel(to, &t, column, row, index);
        }
    }
}

// Cuts off what is nearer than z_near, where the projection has its pole.
static int clip_near(const point4 in[3], float z_near, point4 out[4])
{
    int count = 0;
    for (int i = 0; i < 3; i++) {
        const point4 a = in[i], b = in[(i + 1) % 3];
        if (a.w >= z_near) out[count++] = a;
        if ((a.w >= z_near) != (b.w >= z_near)) {
            const float t = (z_near - a.w) / (b.w - a.w);
            out[count++] = (point4){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y),
                                    a.z + t * (b.z - a.z), z_near};
        }
    }
    return count;
}

// Triangles seen from the front, counter-clockwise in the picture, or from behind, or both.
static bool draw(const target *to, const scene *s, const float m[16], bool front, bool back)
{
    point4 *vertex = malloc((size_t)s->vertices * sizeof *vertex);
    if (!vertex) return false;
    for (int i = 0; i < s->vertices; i++) {
        const vec3 p = s->position[i];
        float c[4];
        for (int k = 0; k < 4; k++) c[k] = m[k] * p.x + m[4 + k] * p.y + m[8 + k] * p.z + m[12 + k];
        vertex[i] = (point4){c[0], c[1], c[2], c[3]};
    }
    for (int i = 0; i < s->triangles; i++) {
        const int *t = s->triangle[i];
        const point4 corner[3] = {vertex[t[0]], vertex[t[1]], vertex[t[2]]};
        point4 part[4];
        const int corners = to->perspective ? clip_near(corner, to->z_near, part) : 3;
        if (!to->perspective) memcpy(part, corner, sizeof corner);
        for (int k = 2; k < corners; k++) {
            const point4 fan[3] = {part[0], part[k - 1], part[k]};
            if (front) fill_triangle(to, fan, false, i);
            if (back) fill_triangle(to, fan, true, i);
        }
    }
    free(vertex);
    return true;
}

// ---- Depth maps

bool raster_depth(const scene *s, const raster_frustum *frustum, raster_faces faces, int side,
                  int samples, float *depth)
{
    const target to = {
        side,          side, samples, false, depth, NULL, frustum->perspective, frustum->z_near,
        frustum->z_far};
    const size_t count = (size_t)side * (size_t)side * (size_t)samples;
    for (size_t i = 0; i < count; i++) depth[i] = 1;
    return draw(&to, s, frustum->world_to_shadow, faces != RASTER_BACK, true);
}

// ---- The camera

camera camera_look(vec3 from, vec3 to, float vertical_angle, float aspect)
{
    camera c;
    c.position = from;
    c.back = vec_unit(vec_sub(from, to));
    c.right = vec_unit(vec_cross(vec(0, 1, 0), c.back));
    c.up = vec_cross(c.back, c.right);
    c.tan_y = tanf(0.5f * vertical_angle);
    c.tan_x = c.tan_y * aspect;
    return c;
}

vec3 camera_ray(const camera *c, float x, float y)
{
    const vec3 d = vec_mad(vec_scale(c->back, -1), c->right, (2 * x - 1) * c->tan_x);
    return vec_mad(d, c->up, (1 - 2 * y) * c->tan_y);
}

void gl_camera_matrix(const camera *c, float near, float far, float world_to_clip[16])
{
    const vec3 row[4] = {vec_scale(c->right, 1 / c->tan_x), vec_scale(c->up, 1 / c->tan_y),
                         vec_scale(c->back, -(far + near) / (far - near)), vec_scale(c->back, -1)};
    const float shift[4] = {0, 0, -2 * far * near / (far - near), 0};
    for (int k = 0; k < 4; k++) {
        world_to_clip[k] = row[k].x;
        world_to_clip[4 + k] = row[k].y;
        world_to_clip[8 + k] = row[k].z;
        world_to_clip[12 + k] = shift[k] - vec_dot(row[k], c->position);
    }
}

static void camera_matrix(const camera *c, float m[16])
{
    const vec3 row[4] = {vec_scale(c->right, 1 / c->tan_x), vec_scale(c->up, 1 / c->tan_y),
                         vec(0, 0, 0), vec_scale(c->back, -1)};
    for (int k = 0; k < 4; k++) {
        m[k] = row[k].x;
        m[4 + k] = row[k].y;
        m[8 + k] = row[k].z;
        m[12 + k] = -vec_dot(row[k], c->position);
    }
}

bool view_create(view *v, const scene *s, const camera *eye, int width, int height)
{
    const size_t count = (size_t)width * (size_t)height * VIEW_SAMPLES;
    const vec3 centre = vec_scale(vec_add(s->low, s->high), 0.5f);
    const float radius = 0.5f * vec_length(vec_sub(s->high, s->low));
    const float far = vec_length(vec_sub(centre, eye->position)) + radius;
    float m[16], *depth = malloc(count * sizeof *depth);
    *v = (view){*eye, width, height, malloc(count * sizeof *v->triangle)};
    camera_matrix(eye, m);
    const target to = {width, height, VIEW_SAMPLES, true, depth, v->triangle, true, 0.02f, far};
    for (size_t i = 0; i < count && depth && v->triangle; i++) {
        depth[i] = 2;
        v->triangle[i] = -1;
    }
    const bool drawn = depth && v->triangle && draw(&to, s, m, true, false);
    free(depth);
    if (!drawn) view_free(v);
    return drawn;
}

void view_free(view *v)
{
    free(v->triangle);
    memset(v, 0, sizeof *v);
}

// Position and normal where the ray through a sample meets the plane of its triangle.
static void view_sample(const view *v, const scene *s, int x, int y, int sample, int triangle,
                        vec3 *position, vec3 *normal)
{
    const int *t = s->triangle[triangle];
    const float *grid = sample_positions(VIEW_SAMPLES)[sample];
    const vec3 a = s->position[t[0]];
    const vec3 ab = vec_sub(s->position[t[1]], a), ac = vec_sub(s->position[t[2]], a);
    const vec3 d = camera_ray(&v->eye, ((float)x + grid[0]) / (float)v->width,
                              ((float)y + 1 - grid[1]) / (float)v->height);
    const vec3 from = vec_sub(v->eye.position, a), side = vec_cross(d, ac);
    const float scale = 1 / vec_dot(ab, side);
    // Clamped: the slack of the edges lets samples lie a hair outside.
    const float b = fminf(fmaxf(vec_dot(from, side) * scale, 0), 1);
    const float c = fminf(fmaxf(vec_dot(d, vec_cross(from, ab)) * scale, 0), 1 - b);
    *position = vec_mad(vec_mad(a, ab, b), ac, c);
    const vec3 n = vec_mad(vec_scale(s->normal[t[0]], 1 - b - c), s->normal[t[1]], b);
    *normal = vec_unit(vec_mad(n, s->normal[t[2]], c));
}

int view_surfaces(const view *v, const scene *s, int x, int y, surface piece[VIEW_SAMPLES])
{
    const int *triangle = v->triangle + ((size_t)y * (size_t)v->width + (size_t)x) * VIEW_SAMPLES;
    int pieces = 0;
    for (int i = 0; i < VIEW_SAMPLES; i++) {
        if (triangle[i] < 0) continue;
        vec3 position, normal;
        int k = 0;
        view_sample(v, s, x, y, i, triangle[i], &position, &normal);
        while (k < pieces &&
               (piece[k].object != s->object[triangle[i]] ||
                vec_dot(piece[k].normal, normal) < 0.8f * vec_length(piece[k].normal))) {
            k++;
        }
        // The mean position of several samples would lie below a curved surface, and in its shadow.
        if (k == pieces)
            piece[pieces++] = (surface){position, {0, 0, 0}, s->object[triangle[i]], 0};
        piece[k].normal = vec_add(piece[k].normal, normal);
        piece[k].share += 1;
    }
    for (int k = 0; k < pieces; k++) {
        piece[k].normal = vec_unit(piece[k].normal);
        piece[k].share /= VIEW_SAMPLES;
    }
    return pieces;
}
