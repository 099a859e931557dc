#include "scene.h"

#include <stdlib.h>
#include <string.h>

#define TAU (2 * VEC_PI)

// ---- Growing the scene

typedef scene_frame frame;

static vec3 frame_vector(const frame *f, vec3 v)
{
    return vec_mad(vec_mad(vec_scale(f->x, v.x), f->y, v.y), f->z, v.z);
}

static vec3 frame_point(const frame *f, vec3 p)
{
    return vec_add(f->origin, frame_vector(f, p));
}

frame scene_frame_at(vec3 origin, float turn, float tilt)
{
    const float c = cosf(tilt), s = sinf(tilt);
    const frame f = {vec_turn(vec(1, 0, 0), turn), vec_turn(vec(0, c, s), turn),
                     vec_turn(vec(0, -s, c), turn), origin};
    return f;
}

static void *grown(scene *s, void *array, int room, size_t size)
{
    void *larger = realloc(array, (size_t)room * size);
    s->failed |= !larger;
    return larger ? larger : array;
}

int scene_put_vertex(scene *s, vec3 position, vec3 normal)
{
    if (s->vertices == s->vertex_room) {
        const int room = s->vertex_room * 2 + 1024;
        s->position = grown(s, s->position, room, sizeof *s->position);
        s->normal = grown(s, s->normal, room, sizeof *s->normal);
        if (s->failed) return 0;
        s->vertex_room = room;
    }
    s->position[s->vertices] = position;
    s->normal[s->vertices] = vec_unit(normal);
    return s->vertices++;
}

static bool same(vec3 a, vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

// Triangles with two corners in one place, at poles and tips, are left out: their neighbours meet.
void scene_put_triangle(scene *s, int a, int b, int c)
{
    if (s->triangles == s->triangle_room) {
        const int room = s->triangle_room * 2 + 1024;
        s->triangle = grown(s, s->triangle, room, sizeof *s->triangle);
        s->object = grown(s, s->object, room, sizeof *s->object);
        if (!s->failed) s->triangle_room = room;
    }
    if (s->failed) return;
    const vec3 *p = s->position;
    if (same(p[a], p[b]) || same(p[b], p[c]) || same(p[c], p[a])) return;
    s->triangle[s->triangles][0] = a;
    s->triangle[s->triangles][1] = b;
    s->triangle[s->triangles][2] = c;
    s->object[s->triangles++] = (unsigned char)(s->objects - 1);
}

static void add_quad(scene *s, int a, int b, int c, int d)
{
    scene_put_triangle(s, a, b, c);
    scene_put_triangle(s, a, c, d);
}

void scene_begin_object(scene *s, float r, float g, float b)
{
    s->albedo[s->objects++] = vec(r, g, b);
}

// ---- Shapes

void scene_put_box(scene *s, const frame *f, vec3 half)
{
    for (int side = 0; side < 6; side++) {
        const float sign = side & 1 ? -1.0f : 1.0f;
        const vec3 axes[3] = {vec(half.x, 0, 0), vec(0, half.y, 0), vec(0, 0, half.z)};
        const vec3 n = vec_scale(axes[side / 2], sign);
        const vec3 u = axes[(side / 2 + 1) % 3], v = vec_scale(axes[(side / 2 + 2) % 3], sign);
        int corner[4];
        for (int i = 0; i < 4; i++) {
            const vec3 p =
                vec_mad(vec_mad(n, u, i == 1 || i == 2 ? 1.0f : -1.0f), v, i >= 2 ? 1.0f : -1.0f);
            corner[i] = scene_put_vertex(s, frame_point(f, p), frame_vector(f, n));
        }
        add_quad(s, corner[0], corner[1], corner[2], corner[3]);
    }
}

typedef struct profile_point {
    float radius, height;
} profile_point;

// One band of a surface of revolution, from ring a to ring b, with the given normals there.
static void add_band(scene *s, const frame *f, const profile_point p[2],
                     const profile_point normal[2], int around)
{
    const int first = s->vertices;
    for (int i = 0; i < around; i++) {
        const float c = cosf(TAU * (float)i / (float)around),
                    d = sinf(TAU * (float)i / (float)around);
        for (int k = 0; k < 2; k++) {
            scene_put_vertex(
                s, frame_point(f, vec(p[k].radius * c, p[k].height, p[k].radius * d)),
                frame_vector(f, vec(normal[k].radius * c, normal[k].height, normal[k].radius * d)));
        }
    }
    for (int i = 0; i < around; i++) {
        const int a = first + 2 * i, b = first + 2 * ((i + 1) % around);
        add_quad(s, a, a + 1, b + 1, b);
    }
}

// Turns a profile, which goes from the bottom of the axis to its top, about the local y axis. Every
// piece of it gets an edge of its own.
static void add_lathe(scene *s, const frame *f, const profile_point *p, int points, int around)
{
    for (int i = 0; i + 1 < points; i++) {
        const profile_point across = {p[i + 1].height - p[i].height, p[i].radius - p[i + 1].radius};
        const profile_point normal[2] = {across, across};
        add_band(s, f, p + i, normal, around);
    }
}

void scene_put_sphere(scene *s, const frame *f, float radius, int rings)
{
    for (int i = 0; i < rings; i++) {
        profile_point p[2], normal[2];
        for (int k = 0; k < 2; k++) {
            const float angle = VEC_PI * (float)(i + k) / (float)rings;
            // sin(pi) is not 0 in float; the pole must be one point.
            normal[k].radius = i + k == 0 || i + k == rings ? 0 : sinf(angle);
            normal[k].height = -cosf(angle);
            p[k].radius = radius * normal[k].radius;
            p[k].height = radius * normal[k].height;
        }
        add_band(s, f, p, normal, 2 * rings);
    }
}

// A point of the (2,3) torus knot, or with flat set of a circle; t in [0,1).
static vec3 knot(float t, float ring, float swing)
{
    const float turn = swing > 0 ? 2 * TAU * t : TAU * t, wave = 3 * TAU * t;
    const float r = ring + swing * cosf(wave);
    return vec(r * cosf(turn), r * sinf(turn), swing * 1.3f * sinf(wave));
}

// A tube along the knot (swing > 0) or a ring (swing = 0), in the local x-y plane.
static void add_tube(scene *s, const frame *f, float ring, float swing, float radius, int along,
                     int around)
{
    const int first = s->vertices;
    for (int i = 0; i < along; i++) {
        const float t = (float)i / (float)along, step = 1e-2f;
        const vec3 c = knot(t, ring, swing);
        const vec3 ahead = knot(t + step, ring, swing), behind = knot(t - step, ring, swing);
        const vec3 tangent = vec_unit(vec_sub(ahead, behind));
        // The curve never runs straight, so its own bend gives a frame that closes.
        vec3 inward = vec_sub(vec_add(ahead, behind), vec_scale(c, 2));
        inward = vec_unit(vec_mad(inward, tangent, -vec_dot(inward, tangent)));
        const vec3 side = vec_cross(tangent, inward);
        for (int k = 0; k < around; k++) {
            const float angle = TAU * (float)k / (float)around;
            const vec3 n = vec_mad(vec_scale(inward, cosf(angle)), side, sinf(angle));
            scene_put_vertex(s, frame_point(f, vec_mad(c, n, radius)), frame_vector(f, n));
        }
    }
    for (int i = 0; i < along * around; i++) {
        const int row = i / around * around, k = i % around, next = (k + 1) % around;
        const int ahead = (row + around) % (along * around);
        add_quad(s, first + row + k, first + row + next, first + ahead + next, first + ahead + k);
    }
}

void scene_put_leaf(scene *s, const frame *f, float length, float width)
{
    enum { ALONG = 24, ACROSS = 8, ROW = ACROSS + 1 };
    const float thickness = 0.012f;
    for (int skin = -1; skin <= 1; skin += 2) {
        const int first = s->vertices;
        for (int i = 0; i <= ALONG; i++) {
            for (int k = 0; k <= ACROSS; k++) {
                const float u = 2 * (float)i / ALONG - 1, v = 2 * (float)k / ACROSS - 1;
                const float open = 1 - u * u;
                const vec3 bent = vec(
                    length * u, 0.35f * length * (u * u - 0.3f * u) + 0.5f * width * open * v * v,
                    width * open * (1.0f - 0.3f * u) * v);
                // The bend is slight: its slopes make a normal good enough for shading.
                const vec3 n = vec(-0.35f * (2 * u - 0.3f), 1, -v);
                const float lift = thickness * (float)skin * open * (1 - v * v);
                scene_put_vertex(s, frame_point(f, vec_mad(bent, vec(0, 1, 0), lift)),
                                 vec_scale(frame_vector(f, n), (float)skin));
            }
        }
        for (int i = 0; i < ALONG * ACROSS; i++) {
            const int a = first + i / ACROSS * ROW + i % ACROSS;
            if (skin > 0)
                add_quad(s, a, a + 1, a + ROW + 1, a + ROW);
            else
                add_quad(s, a, a + ROW, a + ROW + 1, a + 1);
        }
    }
}

// ---- Meshes from files

typedef struct corner {
    vec3 position;
    int index;
} corner;

static int compare_corners(const void *first, const void *second)
{
    const vec3 a = ((const corner *)first)->position, b = ((const corner *)second)->position;
    if (a.x != b.x) return a.x < b.x ? -1 : 1;
    if (a.y != b.y) return a.y < b.y ? -1 : 1;
    return a.z < b.z ? -1 : a.z > b.z;
}

// Smooth normals, weighted by area. Vertices in the same place share theirs, because many files
// repeat the vertices along the seams of patches. The scale keeps squares of areas in range.
static bool smooth_normals(const mesh *m, float scale, vec3 *normal)
{
    corner *sorted = malloc((size_t)m->vertices * sizeof *sorted);
    if (!sorted) return false;
    for (int i = 0; i < m->vertices; i++) {
        normal[i] = vec(0, 0, 0);
        sorted[i].position = m->position[i];
        sorted[i].index = i;
    }
    for (int i = 0; i < m->triangles; i++) {
        const int *t = m->triangle[i];
        const vec3 a = m->position[t[0]];
        const vec3 n = vec_cross(vec_scale(vec_sub(m->position[t[1]], a), scale),
                                 vec_scale(vec_sub(m->position[t[2]], a), scale));
        for (int k = 0; k < 3; k++) normal[t[k]] = vec_add(normal[t[k]], n);
    }
    qsort(sorted, (size_t)m->vertices, sizeof *sorted, compare_corners);
    for (int i = 0, end; i < m->vertices; i = end) {
        vec3 sum = vec(0, 0, 0);
        for (end = i; end < m->vertices && !compare_corners(sorted + i, sorted + end); end++) {
            sum = vec_add(sum, normal[sorted[end].index]);
        }
        for (int k = i; k < end; k++) normal[sorted[k].index] = sum;
    }
    free(sorted);
    return true;
}

void scene_put_mesh(scene *s, const frame *f, const mesh *m, float radius, float height)
{
    vec3 low = m->position[0], high = low;
    vec3 *normal = malloc((size_t)m->vertices * sizeof *normal);
    for (int i = 1; i < m->vertices; i++) {
        low = vec_min(low, m->position[i]);
        high = vec_max(high, m->position[i]);
    }
    const vec3 size = vec_sub(high, low);
    const float across = 0.5f * hypotf(size.x, size.z);
    float fit = across * height > size.y * radius ? radius / across : height / size.y;
    if (!isfinite(fit)) fit = 1;
    if (!normal || !smooth_normals(m, fit, normal)) s->failed = true;
    const vec3 foot = vec(0.5f * low.x + 0.5f * high.x, low.y, 0.5f * low.z + 0.5f * high.z);
    const int first = s->vertices;
    for (int i = 0; i < m->vertices && !s->failed; i++) {
        const vec3 p = vec_scale(vec_sub(m->position[i], foot), fit);
        scene_put_vertex(s, frame_point(f, p), frame_vector(f, normal[i]));
    }
    for (int i = 0; i < m->triangles && !s->failed; i++) {
        const int *t = m->triangle[i];
        scene_put_triangle(s, first + t[0], first + t[1], first + t[2]);
    }
    free(normal);
}

// ---- The default scene

static void add_ground(scene *s)
{
    const profile_point slab[] = {{0, -0.16f},    {4.3f, -0.16f}, {4.4f, -0.06f},
                                  {4.4f, -0.02f}, {4.38f, 0},     {0, 0}};
    const frame f = scene_frame_at(vec(0, 0, 0), 0, 0);
    scene_begin_object(s, 0.66f, 0.63f, 0.60f);
    add_lathe(s, &f, slab, 6, 128);
}

static void add_columns(scene *s)
{
    const profile_point column[] = {{0, 0},       {0.2f, 0},      {0.2f, 0.1f},  {0.13f, 0.16f},
                                    {0.1f, 1.9f}, {0.17f, 2.02f}, {0.17f, 2.1f}, {0, 2.1f}};
    scene_begin_object(s, 0.78f, 0.75f, 0.70f);
    for (int i = 0; i < 3; i++) {
        const frame f =
            scene_frame_at(vec(-3.05f + 0.95f * (float)i, 0, -1.0f - 0.75f * (float)i), 0, 0);
        add_lathe(s, &f, column, 8, 40);
    }
}

// Slats and two rails: thin things whose shadows are sharp at the foot and dissolve further on.
static void add_railing(scene *s)
{
    const float turn = 0.86f;
    const vec3 middle = vec(-2.25f, 0.42f, 1.25f), along = vec_turn(vec(1, 0, 0), turn);
    scene_begin_object(s, 0.45f, 0.50f, 0.42f);
    for (int i = 0; i < 9; i++) {
        const frame f = scene_frame_at(vec_mad(middle, along, 0.26f * ((float)i - 4)), turn, 0);
        scene_put_box(s, &f, vec(0.035f, 0.42f, 0.012f));
    }
    for (int i = 0; i < 2; i++) {
        const frame f =
            scene_frame_at(vec_add(middle, vec(0, 0.5f * (float)i - 0.24f, 0)), turn, 0);
        scene_put_box(s, &f, vec(1.2f, 0.025f, 0.018f));
    }
}

// A ring high above low blocks: shadows of a far and a near caster on top of each other.
static void add_blocks_and_ring(scene *s, float phase)
{
    scene_begin_object(s, 0.70f, 0.62f, 0.36f);
    const float size[3] = {0.42f, 0.28f, 0.2f};
    const vec3 place[3] = {vec(3.0f, 0.24f, 0.45f), vec(2.45f, 0.16f, 1.0f),
                           vec(3.1f, 0.62f, 0.4f)};
    const float height[3] = {0.24f, 0.16f, 0.14f};
    for (int i = 0; i < 3; i++) {
        const frame f = scene_frame_at(place[i], 0.35f + 0.5f * (float)i, 0);
        scene_put_box(s, &f, vec(size[i], height[i], size[i]));
    }
    scene_begin_object(s, 0.85f, 0.62f, 0.14f);
    const frame ring = scene_frame_at(
        vec(1.2f + 0.25f * sinf(phase), 1.6f + 0.15f * cosf(phase), -0.45f), 0.5f + phase, 1.15f);
    add_tube(s, &ring, 0.52f, 0, 0.085f, 96, 20);
}

static void add_centre(scene *s, float phase, const mesh *centre)
{
    const profile_point pedestal[] = {{0, 0},         {0.78f, 0},     {0.78f, 0.07f}, {0.7f, 0.1f},
                                      {0.66f, 0.34f}, {0.72f, 0.37f}, {0.72f, 0.42f}, {0, 0.42f}};
    const frame foot = scene_frame_at(vec(-0.15f, 0, -0.2f), 0, 0);
    scene_begin_object(s, 0.60f, 0.56f, 0.54f);
    add_lathe(s, &foot, pedestal, 8, 72);
    scene_begin_object(s, 0.80f, 0.22f, 0.11f);
    if (centre) {
        const frame f = scene_frame_at(vec(-0.15f, 0.42f, -0.2f), phase, 0);
        scene_put_mesh(s, &f, centre, 0.95f, 1.35f);
    } else {
        const frame f = scene_frame_at(vec(-0.15f, 1.2f, -0.2f), 0.3f + phase, 0);
        add_tube(s, &f, 0.44f, 0.2f, 0.135f, 240, 20);
    }
}

static void add_balls_and_leaves(scene *s, float phase)
{
    const frame large = scene_frame_at(vec(1.25f, 0.45f, 1.3f), 0, 0);
    const frame small = scene_frame_at(vec(0.35f, 0.2f, 2.05f), 0, 0);
    scene_begin_object(s, 0.13f, 0.33f, 0.62f);
    scene_put_sphere(s, &large, 0.45f, 28);
    scene_begin_object(s, 0.82f, 0.80f, 0.78f);
    scene_put_sphere(s, &small, 0.2f, 20);
    scene_begin_object(s, 0.33f, 0.56f, 0.10f);
    for (int i = 0; i < 4; i++) {
        const float k = (float)i, swing = 0.12f * sinf(phase + 1.7f * k);
        const frame f =
            scene_frame_at(vec(2.5f - 0.33f * k + swing, 0.25f + 0.3f * k, -1.3f - 0.15f * k),
                           0.8f + 1.3f * k, 0.25f + swing);
        scene_put_leaf(s, &f, 0.3f, 0.12f);
    }
}

bool scene_end(scene *s)
{
    if (s->failed) {
        scene_free(s);
        return false;
    }
    s->low = s->high = s->position[0];
    for (int i = 1; i < s->vertices; i++) {
        s->low = vec_min(s->low, s->position[i]);
        s->high = vec_max(s->high, s->position[i]);
    }
    return true;
}

bool scene_create(scene *s, float time, const mesh *centre)
{
    const float phase = TAU * time / 8;
    memset(s, 0, sizeof *s);
    add_ground(s);
    add_columns(s);
    add_railing(s);
    add_blocks_and_ring(s, phase);
    add_centre(s, phase, centre);
    add_balls_and_leaves(s, phase);
    return scene_end(s);
}

scene_vertex *scene_vertices(const scene *s)
{
    scene_vertex *v = malloc((size_t)s->vertices * sizeof *v);
    for (int i = 0; i < s->vertices && v; i++)
        v[i] = (scene_vertex){s->position[i], s->normal[i], vec(0, 0, 0)};
    for (int i = 0; i < s->triangles && v; i++) { // objects share no vertices
        for (int k = 0; k < 3; k++) v[s->triangle[i][k]].albedo = s->albedo[s->object[i]];
    }
    return v;
}

void scene_free(scene *s)
{
    free(s->position);
    free(s->normal);
    free(s->triangle);
    free(s->object);
    memset(s, 0, sizeof *s);
}
