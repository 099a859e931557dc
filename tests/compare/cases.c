#include "cases.h"

#include "../../examples/common/raster.h"
#include "../../examples/common/threads.h"
#include "case_parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- Parts ---------------------------------------------------------------------------------

// An open disc of 12 corners: a leaf without thickness.
static void disc(scene *s, vec3 centre, vec3 normal, float radius)
{
    enum { CORNERS = 12 };
    const vec3 n = vec_unit(normal);
    const vec3 u = vec_unit(vec_cross(n, fabsf(n.x) < 0.7f ? vec(1, 0, 0) : vec(0, 1, 0)));
    const vec3 v = vec_cross(n, u);
    const int first = s->vertices;
    for (int i = 0; i < CORNERS; i++) {
        const float angle = 2 * VEC_PI * (float)i / CORNERS;
        const vec3 p = vec_mad(vec_mad(centre, u, radius * cosf(angle)), v, radius * sinf(angle));
        scene_put_vertex(s, p, n);
    }
    for (int i = 2; i < CORNERS; i++) scene_put_triangle(s, first, first + i - 1, first + i);
}

// An open sheet: the curve (x, y)(t) pushed along z by +-half.
static void sheet(scene *s, vec3 centre, float turn, float width, float height, float half,
                  bool arch)
{
    enum { PIECES = 24 };
    const int first = s->vertices;
    for (int i = 0; i <= PIECES; i++) {
        const float t = 2 * (float)i / PIECES - 1;
        const float rise = arch ? sqrtf(1 - t * t) : 1 - fabsf(t);
        for (int k = -1; k <= 1; k += 2) {
            const vec3 p = vec_turn(vec(width * t, height * rise, half * (float)k), turn);
            scene_put_vertex(s, vec_add(centre, p), vec(0, 1, 0));
        }
    }
    for (int i = 0; i < PIECES; i++) {
        const int a = first + 2 * i;
        scene_put_triangle(s, a, a + 1, a + 3);
        scene_put_triangle(s, a, a + 3, a + 2);
    }
}

static vec3 random_direction(uint64_t *state)
{
    const float z = draw(state, -1, 1), angle = draw(state, 0, 6.2831853);
    const float r = sqrtf(1 - z * z);
    return vec(r * cosf(angle), r * sinf(angle), z);
}

// ---- Scenes --------------------------------------------------------------------------------
// Each in about 4 x 2 x 4 units. shift is how far the moving object has come.

// Things that stand and lean on the ground: bias opens a bright gap under them.
static void contact(scene *s, float shift, uint64_t *state)
{
    (void)shift, (void)state;
    slab(s);
    box(s, -0.9f, 0.5f, -0.3f, 0.45f, 0.5f, 0.3f);
    box(s, 0.9f, 0.04f, 0.9f, 0.7f, 0.04f, 0.4f);
    ball(s, 0.5f, 0.3f, -0.6f, 0.3f);
    ball(s, -0.4f, 0.1f, 0.9f, 0.1f);
    turned_box(s, vec(1.5f, 0.45f, -0.9f), 0.4f, 0.5f, vec(0.5f, 0.5f, 0.02f));
    for (int i = 0; i < 5; i++) box(s, -1.9f + 0.3f * (float)i, 0.15f, 1.6f, 0.05f, 0.15f, 0.05f);
}

// Leaves and plates thinner than a texel, at several heights.
static void leaves(scene *s, float shift, uint64_t *state)
{
    (void)shift;
    for (int i = 0; i < 24; i++) {
        const vec3 at = vec(draw(state, -1.4, 1.4), draw(state, 0.08, 1.3), draw(state, -1.4, 1.4));
        const scene_frame f = scene_frame_at(at, draw(state, 0, 6.28), draw(state, -0.7, 0.7));
        scene_put_leaf(s, &f, draw(state, 0.25, 0.45), draw(state, 0.1, 0.2));
    }
    turned_box(s, vec(0.3f, 0.7f, 0.2f), 0.3f, 0.15f, vec(0.5f, 0.004f, 0.4f));
    turned_box(s, vec(-0.8f, 0.4f, 0.7f), 1.1f, 1.4f, vec(0.4f, 0.004f, 0.4f));
}

// Small things near the ground in the penumbra of plates far above: one average blocker depth for
// both is wrong for each. The plates move.
static void near_and_far(scene *s, float shift, uint64_t *state)
{
    for (int i = 0; i < 14; i++) {
        const float r = draw(state, 0.06, 0.2);
        ball(s, draw(state, -1.3, 1.3), r + draw(state, 0, 0.15), draw(state, -1.3, 1.3), r);
    }
    scene_begin_object(s, 0.5f, 0.5f, 0.5f);
    box(s, -0.7f + shift, 2.6f, -0.2f, 0.5f, 0.04f, 1);
    box(s, 0.6f + shift, 2.2f, 0.5f, 0.35f, 0.04f, 0.35f);
}

// A crown of open leaves at all distances from each other.
static void foliage(scene *s, float shift, uint64_t *state)
{
    (void)shift;
    box(s, 0, 0.5f, 0, 0.08f, 0.5f, 0.08f);
    for (int i = 0; i < 300; i++) {
        const float r = 1.3f * sqrtf(draw(state, 0, 1)), angle = draw(state, 0, 6.2831853);
        const vec3 at = vec(r * cosf(angle), draw(state, 0.8, 2.2), r * sinf(angle));
        disc(s, at, random_direction(state), draw(state, 0.05, 0.12));
    }
}

// Two grids of bars, one above the other. The upper one moves.
static void grids(scene *s, float shift, uint64_t *state)
{
    (void)state;
    for (int i = 0; i < 10; i++) box(s, -1.62f + 0.36f * (float)i, 0.5f, 0, 0.06f, 0.04f, 1.7f);
    scene_begin_object(s, 0.5f, 0.5f, 0.5f);
    for (int i = 0; i < 8; i++) box(s, shift, 1.6f, -1.61f + 0.46f * (float)i, 1.7f, 0.04f, 0.08f);
}

// Low bumps and long shadows under a sun near the horizon.
static void grazing(scene *s, float shift, uint64_t *state)
{
    (void)shift;
    slab(s);
    for (int i = 0; i < 12; i++) {
        const float h = draw(state, 0.02, 0.25);
        turned_box(s, vec(draw(state, -2, 2), h, draw(state, -2, 2)), draw(state, 0, 3), 0,
                   vec(draw(state, 0.1, 0.3), h, draw(state, 0.03, 0.3)));
    }
    for (int i = 0; i < 6; i++) {
        const float r = draw(state, 0.15, 0.4);
        ball(s, draw(state, -2, 2), -0.6f * r, draw(state, -2, 2), r);
    }
}

// Blocks and towers under a sky that is almost one light.
static void city(scene *s, float shift, uint64_t *state)
{
    (void)shift;
    slab(s);
    for (int i = 0; i < 36; i++) {
        const float x = -2 + 0.8f * (float)(i % 6), z = -2 + 0.8f * (float)(i / 6);
        const float h = draw(state, 0.05, 0.25) * (i % 7 == 3 ? 4.0f : 1.0f);
        box(s, x, h, z, draw(state, 0.12, 0.28), h, draw(state, 0.12, 0.28));
    }
}

// Slats, needles and wires: the sharp shadows of small lights.
static void fence(scene *s, float shift, uint64_t *state)
{
    (void)shift;
    slab(s);
    for (int i = 0; i < 12; i++)
        turned_box(s, vec(-0.6f, 0.15f + 0.12f * (float)i, 0.3f), 0.3f, 0.6f,
                   vec(0.9f, 0.05f, 0.006f));
    for (int i = 0; i < 30; i++) {
        const float h = draw(state, 0.2, 0.8);
        turned_box(s, vec(draw(state, 0.2, 2.2), h, draw(state, -2, 2)), draw(state, 0, 6.28),
                   draw(state, -0.15, 0.15), vec(0.012f, h, 0.012f));
    }
}

// Walls and posts on the border of everything: kernels reach over the edge of the map.
static void map_edge(scene *s, float shift, uint64_t *state)
{
    (void)shift, (void)state;
    slab(s);
    box(s, -2.44f, 0.5f, 0, 0.06f, 0.5f, 2.5f);
    box(s, 0.4f, 0.35f, -2.44f, 2.1f, 0.35f, 0.06f);
    for (int i = 0; i < 6; i++) box(s, 2.42f, 0.45f, -2.2f + 0.9f * (float)i, 0.08f, 0.45f, 0.08f);
    for (int i = 0; i < 5; i++) ball(s, -1.8f + 0.9f * (float)i, 0.2f, 2.3f, 0.2f);
}

// Roofs, tents and sails without a far side.
static void open_sheets(scene *s, float shift, uint64_t *state)
{
    (void)shift;
    sheet(s, vec(-0.8f, 0.3f, -0.5f), 0.4f, 0.7f, 0.6f, 0.8f, true);
    sheet(s, vec(1.0f, 0, -0.9f), -0.5f, 0.6f, 0.7f, 0.5f, false);
    sheet(s, vec(0.4f, 1.3f, 0.7f), 1.2f, 0.5f, -0.2f, 0.5f, true);
    for (int i = 0; i < 12; i++)
        disc(s, vec(draw(state, -1.6, 1.6), draw(state, 0.1, 0.6), draw(state, 0.5, 1.6)),
             random_direction(state), 0.2f);
}

// Balls in the air, at all distances from each other.
static void balls(scene *s, float shift, uint64_t *state)
{
    (void)shift;
    for (int i = 0; i < 40; i++) {
        const float x = draw(state, -1.5, 1.5), y = draw(state, 0.2, 2.2);
        const float z = draw(state, -1.5, 1.5);
        ball(s, x, y, z, draw(state, 0.08, 0.23));
    }
}

// Around a mesh from a file: something far above it.
static void roof(scene *s, float shift, uint64_t *state)
{
    (void)shift, (void)state;
    box(s, -0.5f, 2.4f, 0.3f, 0.12f, 0.03f, 1);
    box(s, 0.1f, 2.4f, 0.1f, 0.12f, 0.03f, 1);
    box(s, 0.7f, 2.4f, -0.1f, 0.12f, 0.03f, 1);
}

static const kind kinds[CASE_COUNT] = {
    {"contact", contact, {0.3f, 1, 0.45f}, true, false, -1, NULL},
    {"thin leaves", leaves, {0.2f, 1, -0.35f}, true, true, -1, NULL},
    {"near and far", near_and_far, {0.3f, 1, 0.25f}, true, true, 1, NULL},
    {"foliage", foliage, {0.3f, 1, 0.45f}, false, true, -1, NULL},
    {"grids", grids, {0.25f, 1, 0.4f}, true, true, 1, NULL},
    {"grazing light", grazing, {0.8f, 0.28f, 0.45f}, true, false, -1, NULL},
    {"city", city, {0.12f, 1, 0.2f}, true, false, -1, NULL},
    {"fence", fence, {0.4f, 1, 0.6f}, true, false, -1, NULL},
    {"map edge", map_edge, {-0.5f, 0.9f, -0.35f}, true, false, -1, NULL},
    {"open sheets", open_sheets, {0.45f, 1, 0.2f}, false, true, -1, NULL},
    {"balls", balls, {0.3f, 1, 0.45f}, true, true, -1, NULL},
    {"demo scene", NULL, {0.35f, 1, 0.5f}, true, false, -1, NULL},
    {"bunny", roof, {0.5f, 1, 0.4f}, true, true, -1, "bunny.obj"},
    {"teapot", roof, {0.45f, 1, 0.5f}, false, true, -1, "teapot.obj"},
};

const char *case_group(int which)
{
    return which < CASE_COUNT ? "chart" : which < CASE_COUNT + CASE_NEW ? "new" : "unseen";
}

static const char *shared_folder(const char *data)
{
    if (!data) data = getenv("SHARED_DATA");
    return data ? data : "../shared/data";
}

static bool put_shared_mesh(scene *s, const char *name, const char *data, message *why)
{
    char path[1024];
    mesh m;
    const scene_frame f = scene_frame_at(vec(0, 0, 0), 0.5f, 0);
    snprintf(path, sizeof path, "%s/meshes/%s", shared_folder(data), name);
    if (!mesh_load_obj(&m, path, why)) return false;
    scene_put_mesh(s, &f, &m, 1.3f, 1.5f);
    mesh_free(&m);
    return true;
}

// A tree over the finished scene; the case is freed where that fails.
static bool finish(compare_case *c, message *why)
{
    c->sun = vec_unit(c->sun);
    c->tree = bvh_create(&c->scene);
    if (c->tree) return true;
    case_free(c);
    return fail(why, "no memory for %s", c->name);
}

bool case_make_step(compare_case *c, int which, int step, const char *data, message *why)
{
    const kind *k = which < CASE_COUNT ? &kinds[which] : &new_kinds[which - CASE_COUNT];
    // A quarter texel of a map over about 5 units; the sun turns by as much as that is at 2.5.
    const float moved = 0.25f * 5 / 256 * (float)step;
    uint64_t state = UINT64_C(0x9e3779b97f4a7c15) + (uint64_t)which;
    memset(c, 0, sizeof *c);
    snprintf(c->name, sizeof c->name, "%s", k->name);
    c->closed = k->closed;
    c->ground = k->ground ? 0 : (float)NAN;
    c->moving = k->moving;
    c->sun = vec_of(k->sun);
    if (k->moving < 0) c->sun = vec_turn(c->sun, moved / 2.5f / hypotf(c->sun.x, c->sun.z));
    if (!k->build) {
        if (!scene_create(&c->scene, 0, NULL)) return fail(why, "no memory for %s", k->name);
        return finish(c, why);
    }
    scene_begin_object(&c->scene, 0.5f, 0.5f, 0.5f);
    k->build(&c->scene, moved, &state);
    if (k->mesh && !put_shared_mesh(&c->scene, k->mesh, data, why)) {
        scene_free(&c->scene);
        return false;
    }
    if (!scene_end(&c->scene)) return fail(why, "no memory for %s", k->name);
    return finish(c, why);
}

bool case_make(compare_case *c, int which, const char *data, message *why)
{
    if (!case_make_step(c, which, 0, data, why)) return false;
    c->moving = -1;
    return true;
}

bool case_load(compare_case *c, const char *path, vec3 sun, message *why)
{
    mesh m;
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    if (!mesh_load_obj(&m, path, why)) return false;
    memset(c, 0, sizeof *c);
    snprintf(c->name, sizeof c->name, "%.*s", (int)strcspn(name, "."), name);
    scene_begin_object(&c->scene, 0.5f, 0.5f, 0.5f);
    for (int i = 0; i < m.vertices; i++) scene_put_vertex(&c->scene, m.position[i], vec(0, 1, 0));
    for (int i = 0; i < m.triangles; i++)
        scene_put_triangle(&c->scene, m.triangle[i][0], m.triangle[i][1], m.triangle[i][2]);
    mesh_free(&m);
    if (!scene_end(&c->scene)) return fail(why, "no memory for %s", path);
    if (c->scene.triangles == 0) return fail(why, "%s: all triangles are points", path);
    c->ground = c->scene.low.y;
    c->sun = sun;
    c->moving = -1;
    return finish(c, why);
}

void case_free(compare_case *c)
{
    bvh_free(c->tree);
    scene_free(&c->scene);
    c->tree = NULL;
}

// ---- Lights and depth maps -----------------------------------------------------------------

mssm_result case_light(const compare_case *c, float tan_half_u, float tan_half_v, mssm_light *light)
{
    const float sun[3] = {c->sun.x, c->sun.y, c->sun.z};
    const float axis_u[3] = {0.9f, 0.1f, -0.4f}; // along no edge of the scenes
    const vec3 a = c->scene.low, b = c->scene.high;
    const float low[3] = {a.x, a.y, a.z}, high[3] = {b.x, b.y, b.z};
    return mssm_light_directional(light, sun, axis_u, tan_half_u, tan_half_v, low, high);
}

bool case_depth(const compare_case *c, const mssm_light *light, int side, float *front, float *back)
{
    const size_t texels = (size_t)side * (size_t)side;
    const raster_frustum frustum = {light->world_to_shadow, false, 0, 0};
    float *far_side = back ? back : malloc(texels * sizeof *far_side);
    const bool drawn = far_side &&
                       raster_depth(&c->scene, &frustum, RASTER_FRONT, side, 1, front) &&
                       raster_depth(&c->scene, &frustum, RASTER_BACK, side, 1, far_side);
    // What shows its back to the light casts a shadow too: open surfaces have no other side.
    for (size_t i = 0; i < texels && drawn; i++) front[i] = fminf(front[i], far_side[i]);
    if (!back) free(far_side);
    return drawn;
}

// ---- Receivers -----------------------------------------------------------------------------

// The light's frame in the world, from the rows of its matrix.
typedef struct light_frame {
    vec3 u, v, towards;
    float half_u, half_v;
} light_frame;

static light_frame frame_of(const mssm_light *light)
{
    const float *m = light->world_to_shadow;
    const light_frame f = {vec_unit(vec(m[0], m[4], m[8])), vec_unit(vec(m[1], m[5], m[9])),
                           vec_unit(vec(-m[2], -m[6], -m[10])), light->half_u, light->half_v};
    return f;
}

static vec3 ray_to(const light_frame *f, float u, float v)
{
    return vec_mad(vec_mad(f->towards, f->u, u * f->half_u), f->v, v * f->half_v);
}

static bool whole_above_horizon(const light_frame *f, vec3 normal)
{
    float least = 1;
    for (int i = 0; i < 4; i++) {
        const vec3 d = ray_to(f, i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f);
        least = fminf(least, vec_dot(vec_unit(d), normal));
    }
    return least > 0.02f;
}

// Where receivers come from: triangles by their area, and a rectangle of the ground that holds the
// casters' shadows.
typedef struct sources {
    double *area; // cumulative
    bool ground;
    vec3 low, high; // of the rectangle
    float lift;     // rays start this far above a surface
} sources;

static vec3 normal_of(const compare_case *c, int triangle, const light_frame *f)
{
    const int *t = c->scene.triangle[triangle];
    const vec3 a = c->scene.position[t[0]], b = c->scene.position[t[1]];
    const vec3 n = vec_cross(vec_sub(b, a), vec_sub(c->scene.position[t[2]], a));
    // Both sides of an open surface receive.
    return !c->closed && vec_dot(n, f->towards) < 0 ? vec_scale(n, -1) : n;
}

static bool sources_open(sources *s, const compare_case *c, const light_frame *f)
{
    const vec3 low = c->scene.low, high = c->scene.high;
    const float size = vec_length(vec_sub(high, low));
    double sum = 0;
    s->lift = 1e-4f * size;
    s->area = malloc((size_t)c->scene.triangles * sizeof *s->area);
    if (!s->area) return false;
    for (int i = 0; i < c->scene.triangles; i++) {
        const vec3 n = normal_of(c, i, f);
        const bool takes_part = c->scene.object[i] != c->moving;
        if (takes_part && whole_above_horizon(f, vec_unit(n))) sum += 0.5 * (double)vec_length(n);
        s->area[i] = sum;
    }
    s->ground = c->ground == c->ground && whole_above_horizon(f, vec(0, 1, 0));
    if (!s->ground) return true;
    const float height = fminf((high.y - c->ground) / fmaxf(f->towards.y, 1e-3f), size);
    const vec3 shift = vec_scale(f->towards, -height), edge = vec(0.1f * size, 0, 0.1f * size);
    s->low = vec_sub(vec_min(low, vec_add(low, shift)), edge);
    s->high = vec_add(vec_max(high, vec_add(high, shift)), edge);
    return true;
}

static void draw_on_ground(const sources *s, float height, uint64_t *state, receiver *r)
{
    r->point.x = draw(state, (double)s->low.x, (double)s->high.x);
    r->point.y = height;
    r->point.z = draw(state, (double)s->low.z, (double)s->high.z);
    r->normal = vec(0, 1, 0);
}

static void draw_on_casters(const sources *s, const compare_case *c, const light_frame *f,
                            uint64_t *state, receiver *r)
{
    const double total = s->area[c->scene.triangles - 1], at = test_range(state, 0, total);
    int low = 0, high = c->scene.triangles - 1;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (s->area[middle] > at)
            high = middle;
        else
            low = middle + 1;
    }
    float u = draw(state, 0, 1), v = draw(state, 0, 1);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const int *t = c->scene.triangle[low];
    const vec3 a = c->scene.position[t[0]];
    const vec3 b = vec_sub(c->scene.position[t[1]], a), d = vec_sub(c->scene.position[t[2]], a);
    r->point = vec_mad(vec_mad(a, b, u), d, v);
    r->normal = vec_unit(normal_of(c, low, f));
}

// Whether one direction drawn above the surface leads out: what lies inside another part or under
// it is seen by nobody.
static bool seen_from_outside(const compare_case *c, const receiver *r, float lift, uint64_t *state)
{
    const vec3 out = vec_mad(random_direction(state), r->normal, 1.001f);
    return !bvh_hit_any(c->tree, vec_mad(r->point, r->normal, lift), out, HUGE_VALF);
}

typedef struct tracing {
    const compare_case *c;
    light_frame f;
    float lift;
    int grid; // even
    uint64_t seed;
    receiver *receivers;
    int radius; // of a Gaussian over the map instead of an area of the light; -1: none
    float weight[TAPS_MOST], texel_u, texel_v; // texels in world units
} tracing;

// Drawn from the kernel, in texels: s in [0,1) takes a tap by its weight, and what is left of it a
// point under the tap's tent.
static float under_kernel(const tracing *t, float s)
{
    int i = 0;
    while (i < 2 * t->radius && s >= t->weight[i]) s -= t->weight[i++];
    const float rest = fminf(s / t->weight[i], 1);
    const float tent = rest < 0.5f ? sqrtf(2 * rest) - 1 : 1 - sqrtf(2 - 2 * rest);
    return (float)(i - t->radius) + tent;
}

// How far below, away from the light, the next surface is.
static float next_below(const tracing *t, vec3 from)
{
    const float ground = (from.y - t->c->ground) / t->f.towards.y; // NAN: there is none
    const float casters = bvh_hit_nearest(t->c->tree, from, vec_scale(t->f.towards, -1));
    return ground >= 0 && ground < casters ? ground : casters;
}

// Whether something stands between the light and a tap, beside the receiver on its tangent plane.
// Where the surface bends towards the light, the plane is under it: if nothing is nearer below,
// taps stand on what is above by no more than they are away.
static bool is_tap_blocked(const tracing *t, const receiver *r, vec3 from, float u, float v)
{
    const light_frame *f = &t->f;
    const float x = t->texel_u * under_kernel(t, u), y = t->texel_v * under_kernel(t, v);
    const float across = x * vec_dot(f->u, r->normal) + y * vec_dot(f->v, r->normal);
    const vec3 aside = vec_mad(vec_mad(vec_scale(f->u, x), f->v, y), f->towards,
                               -across / vec_dot(f->towards, r->normal));
    const vec3 tap = vec_add(from, aside);
    if (!bvh_hit_any(t->c->tree, tap, f->towards, HUGE_VALF)) return false;
    const float reach = vec_length(aside), above = bvh_hit_nearest(t->c->tree, tap, f->towards);
    if (above > reach || next_below(t, tap) <= above) return true;
    return bvh_hit_any(t->c->tree, vec_mad(tap, f->towards, reach), f->towards, HUGE_VALF);
}

// One ray through every cell of a grid over the light. Its standard error comes from blocks of four
// cells as if they were one cell, which errs to the safe side.
static void trace_one(void *context, int index)
{
    const tracing *t = context;
    receiver *r = &t->receivers[index];
    const vec3 from = vec_mad(r->point, r->normal, t->lift);
    uint64_t state = (t->seed + (uint64_t)index + 1) * UINT64_C(0x9e3779b97f4a7c15);
    double variance = 0;
    int seen = 0;
    for (int block = 0; block < t->grid * t->grid / 4; block++) {
        int of_four = 0;
        for (int k = 0; k < 4; k++) {
            const int x = block % (t->grid / 2) * 2 + k % 2, y = block / (t->grid / 2) * 2 + k / 2;
            const float u = 2 * ((float)x + draw(&state, 0, 1)) / (float)t->grid - 1;
            const float v = 2 * ((float)y + draw(&state, 0, 1)) / (float)t->grid - 1;
            of_four += t->radius < 0
                           ? !bvh_hit_any(t->c->tree, from, ray_to(&t->f, u, v), HUGE_VALF)
                           : !is_tap_blocked(t, r, from, 0.5f * (u + 1), 0.5f * (v + 1));
        }
        seen += of_four;
        variance += of_four * (4 - of_four) / 3.0;
    }
    const double rays = t->grid * t->grid;
    r->truth = (float)(seen / rays);
    r->noise = (float)(sqrt(variance) / rays);
}

static tracing tracing_of(const compare_case *c, const mssm_light *light, int rays, uint64_t seed,
                          receiver *receivers)
{
    const float size = vec_length(vec_sub(c->scene.high, c->scene.low));
    const int half = (int)(0.5 * sqrt(rays) + 0.5);
    const tracing t = {.c = c,
                       .f = frame_of(light),
                       .lift = 1e-4f * size,
                       .grid = 2 * (half > 0 ? half : 1),
                       .seed = seed,
                       .receivers = receivers,
                       .radius = -1};
    return t;
}

void case_truth(const compare_case *c, const mssm_light *light, int count, int rays, uint64_t seed,
                receiver *receivers)
{
    tracing t = tracing_of(c, light, rays, seed, receivers);
    parallel_for(count, trace_one, &t, NULL);
}

void case_truth_filtered(const compare_case *c, const mssm_light *light, int side, int radius,
                         int count, int rays, uint64_t seed, receiver *receivers)
{
    tracing t = tracing_of(c, light, rays, seed, receivers);
    t.radius = radius;
    t.texel_u = 2 * light->extent_u / (float)side;
    t.texel_v = 2 * light->extent_v / (float)side;
    gaussian(radius, t.weight);
    parallel_for(count, trace_one, &t, NULL);
}

bool case_receivers(const compare_case *c, const mssm_light *light, int count, int rays,
                    uint64_t seed, receiver *out)
{
    const light_frame f = frame_of(light);
    uint64_t state = seed * 2 + 1;
    sources s;
    int made = 0;
    if (!sources_open(&s, c, &f)) return false;
    const bool casters = s.area[c->scene.triangles - 1] > 0;
    for (int i = 0; i < 400 * count && made < count && (casters || s.ground); i++) {
        receiver *r = &out[made];
        if (s.ground && (made % 2 || !casters))
            draw_on_ground(&s, c->ground, &state, r);
        else
            draw_on_casters(&s, c, &f, &state, r);
        made += seen_from_outside(c, r, s.lift, &state);
    }
    free(s.area);
    if (made < count) return false;
    case_truth(c, light, count, rays, seed, out);
    return true;
}
