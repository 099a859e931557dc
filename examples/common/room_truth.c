#include "room.h"

#include "raytrace.h"
#include "threads.h"

#include <stdint.h>
#include <stdlib.h>

// ---- Walls

// Irradiance on a grid over a wall; u and v are the axes that follow its normal's.
typedef struct wall_map {
    int columns, rows;
    vec3 *light;
} wall_map;

struct room_truth {
    const room *r;
    bvh *things;
    wall_map wall[ROOM_WALLS];
    int rays;
};

static float part(vec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

static vec3 axis_point(int axis, float n, float u, float v)
{
    return axis == 0 ? vec(n, u, v) : axis == 1 ? vec(v, n, u) : vec(u, v, n);
}

static float wall_size(int axis)
{
    return part(room_high, axis) - part(room_low, axis);
}

static bool in_door(float y, float z)
{
    return y < ROOM_DOOR_HEIGHT && z > ROOM_DOOR_FROM && z < ROOM_DOOR_FROM + ROOM_DOOR_WIDTH;
}

static bool is_open(const room *r, float y, float z)
{
    return in_door(y, z) && z < ROOM_DOOR_FROM + r->door;
}

static vec3 wall_albedo(const room *r, int wall, vec3 at)
{
    static const int object[ROOM_WALLS] = {4, 0, 5, 2, 3, 6}; // the order of room_create
    const int door = wall == ROOM_RIGHT && in_door(at.y, at.z);
    return r->all.albedo[r->things_objects + object[wall] + door];
}

// Between the four points of the grid around a place.
static vec3 wall_light(const wall_map *m, int wall, vec3 at)
{
    const int u_axis = (wall / 2 + 1) % 3, v_axis = (wall / 2 + 2) % 3;
    const float u = (part(at, u_axis) - part(room_low, u_axis)) / wall_size(u_axis);
    const float v = (part(at, v_axis) - part(room_low, v_axis)) / wall_size(v_axis);
    const float x = fminf(fmaxf(u * (float)m->columns - 0.5f, 0), (float)m->columns - 1.001f);
    const float y = fminf(fmaxf(v * (float)m->rows - 0.5f, 0), (float)m->rows - 1.001f);
    const vec3 *p = m->light + (int)y * m->columns + (int)x;
    const float a = x - floorf(x), b = y - floorf(y);
    return vec_mix(vec_mix(p[0], p[1], a), vec_mix(p[m->columns], p[m->columns + 1], a), b);
}

// What a ray from inside the room meets: of walls what they reflect, lamp, or the sky in the door.
static vec3 met(const room_truth *t, vec3 from, vec3 ray, vec3 lamp, vec3 sky)
{
    float nearest = HUGE_VALF;
    int wall = 0;
    for (int axis = 0; axis < 3; axis++) {
        const float d = part(ray, axis);
        const float distance = (part(d > 0 ? room_high : room_low, axis) - part(from, axis)) / d;
        if (d == 0 || distance >= nearest) continue;
        nearest = distance;
        wall = 2 * axis + (d > 0);
    }
    const vec3 at = vec_mad(from, ray, nearest), to_lamp = vec_sub(t->r->lamp, from);
    const float ahead = vec_dot(to_lamp, ray), lamp2 = ROOM_LAMP_RADIUS * ROOM_LAMP_RADIUS;
    if (ahead > 0 && vec_dot(to_lamp, to_lamp) - ahead * ahead < lamp2) return lamp;
    if (wall == ROOM_RIGHT && is_open(t->r, at.y, at.z)) return sky;
    return vec_mul(wall_albedo(t->r, wall, at),
                   vec_scale(wall_light(&t->wall[wall], wall, at), 1 / VEC_PI));
}

// ---- Light that arrives at a point

typedef struct receiver {
    const room_truth *t;
    vec3 point, normal;
    uint32_t seed;
} receiver;

// Number i of count x count in the unit square, each shifted within its cell (lowbias32 as hash).
static void sample(const receiver *to, int i, int count, float *u, float *v)
{
    uint32_t h = to->seed + (uint32_t)i * 0x9e3779b9u;
    float shift[2];
    for (int k = 0; k < 2; k++) {
        h = (h ^ h >> 16) * 0x7feb352du;
        h = (h ^ h >> 15) * 0x846ca68bu;
        h ^= h >> 16;
        shift[k] = (float)(h >> 8) * (1.0f / 16777216);
    }
    *u = ((float)(i % count) + shift[0]) / (float)count;
    *v = ((float)(i / count) + shift[1]) / (float)count;
}

static scene_frame frame_of(vec3 z)
{
    const vec3 x = vec_unit(vec_cross(fabsf(z.y) < 0.9f ? vec(0, 1, 0) : vec(1, 0, 0), z));
    return (scene_frame){x, vec_cross(z, x), z, {0, 0, 0}};
}

// At that angle (its cosine) from the frame's z axis.
static vec3 around(const scene_frame *f, float cosine, float turn)
{
    const float sine = sqrtf(fmaxf(1 - cosine * cosine, 0)), a = 2 * VEC_PI * turn;
    return vec_mad(vec_mad(vec_scale(f->x, sine * cosf(a)), f->y, sine * sinf(a)), f->z, cosine);
}

// Shares of the radiance, and of the sun's irradiance.
static float lamp_share(const receiver *to, int count)
{
    const vec3 way = vec_sub(to->t->r->lamp, to->point);
    const float distance = vec_length(way), sine = ROOM_LAMP_RADIUS / distance;
    const float least = sqrtf(fmaxf(1 - sine * sine, 0));
    const scene_frame f = frame_of(vec_scale(way, 1 / distance));
    float sum = 0;
    for (int i = 0; i < count * count; i++) {
        float u, v;
        sample(to, i, count, &u, &v);
        const vec3 d = around(&f, 1 - u * (1 - least), v);
        const float facing = vec_dot(d, to->normal);
        if (facing > 0 && !bvh_hit_any(to->t->things, to->point, d, distance)) sum += facing;
    }
    return sum * 2 * VEC_PI * (1 - least) / (float)(count * count);
}

static float sky_share(const receiver *to, int count)
{
    float sum = 0;
    for (int i = 0; i < count * count; i++) {
        float u, v;
        sample(to, i, count, &u, &v);
        const vec3 at = vec(room_high.x, u * ROOM_DOOR_HEIGHT, ROOM_DOOR_FROM + v * to->t->r->door);
        const vec3 way = vec_sub(at, to->point);
        const float facing = vec_dot(way, to->normal), d2 = vec_dot(way, way);
        if (facing > 0 && way.x > 0 && !bvh_hit_any(to->t->things, to->point, way, 1))
            sum += facing * way.x / (d2 * d2);
    }
    return sum * ROOM_DOOR_HEIGHT * to->t->r->door / (float)(count * count);
}

static float sun_share(const receiver *to, int count)
{
    const scene_frame f = frame_of(room_to_sun);
    float sum = 0;
    for (int i = 0; i < count * count; i++) {
        float u, v;
        sample(to, i, count, &u, &v);
        const vec3 d = vec_mad(vec_mad(f.z, f.x, (2 * u - 1) * ROOM_SUN_TANGENT), f.y,
                               (2 * v - 1) * ROOM_SUN_TANGENT);
        const float facing = vec_dot(f.z, to->normal);
        const vec3 at = vec_mad(to->point, d, (room_high.x - to->point.x) / d.x);
        if (facing > 0 && is_open(to->t->r, at.y, at.z) &&
            !bvh_hit_any(to->t->things, to->point, d, HUGE_VALF))
            sum += facing;
    }
    return sum / (float)(count * count);
}

static vec3 bounce(const receiver *to, int count)
{
    const scene_frame f = frame_of(to->normal);
    const vec3 dark = vec(0, 0, 0);
    vec3 sum = dark;
    for (int i = 0; i < count * count; i++) {
        float u, v;
        sample(to, i, count, &u, &v);
        const vec3 d = around(&f, sqrtf(u), v);
        if (bvh_hit_any(to->t->things, to->point, d, HUGE_VALF)) continue;
        sum =
            vec_add(sum, met(to->t, to->point, d, dark, dark)); // lamp and sky are asked themselves
    }
    return vec_scale(sum, VEC_PI / (float)(count * count));
}

vec3 room_truth_irradiance(const room_truth *t, vec3 point, vec3 normal, bool wall, unsigned seed)
{
    const receiver to = {t, vec_mad(point, normal, 1e-3f), normal, seed * 0x85ebca6bu};
    vec3 sum = wall ? room_ambient : bounce(&to, 2 * t->rays);
    sum = vec_mad(sum, room_lamp_radiance, lamp_share(&to, t->rays));
    sum = vec_mad(sum, room_sky_radiance, sky_share(&to, t->rays));
    return vec_mad(sum, room_sun_irradiance, sun_share(&to, t->rays));
}

// Directions by the half vectors of GGX; height-correlated Smith shadowing, Schlick's Fresnel term.
vec3 room_truth_shine(const room_truth *t, vec3 point, vec3 normal, vec3 viewer, float alpha,
                      unsigned seed)
{
    const receiver to = {t, vec_mad(point, normal, 1e-3f), normal, seed * 0x85ebca6bu};
    const scene_frame f = frame_of(normal);
    const float a2 = alpha * alpha, out = vec_dot(normal, viewer);
    const int count = 2 * t->rays;
    vec3 sum = vec(0, 0, 0);
    for (int i = 0; i < count * count && out > 0; i++) {
        float u, v;
        sample(&to, i, count, &u, &v);
        const vec3 h = around(&f, sqrtf((1 - u) / (1 + (a2 - 1) * u)), v);
        const float facing = vec_dot(viewer, h);
        const vec3 d = vec_mad(vec_scale(viewer, -1), h, 2 * facing);
        const float in = vec_dot(normal, d);
        if (in <= 0 || bvh_hit_any(t->things, to.point, d, HUGE_VALF)) continue;
        const float smith =
            2 * in * out /
            (in * sqrtf(a2 + (1 - a2) * out * out) + out * sqrtf(a2 + (1 - a2) * in * in));
        const float fresnel = 0.04f + 0.96f * powf(1 - facing, 5);
        sum = vec_mad(sum, met(t, to.point, d, room_lamp_radiance, room_sky_radiance),
                      smith * fresnel * facing / (out * vec_dot(normal, h)));
    }
    return vec_scale(sum, 1 / (float)(count * count));
}

// ---- Making

typedef struct wall_work {
    room_truth *t;
    int wall;
} wall_work;

static void light_row(void *context, int row)
{
    const wall_work *w = context;
    const wall_map *m = &w->t->wall[w->wall];
    const int axis = w->wall / 2, u_axis = (axis + 1) % 3, v_axis = (axis + 2) % 3;
    const bool high = w->wall % 2;
    const vec3 corner = high ? room_high : room_low, normal = axis_point(axis, high ? -1 : 1, 0, 0);
    for (int i = 0; i < m->columns; i++) {
        const float u = ((float)i + 0.5f) / (float)m->columns * wall_size(u_axis);
        const float v = ((float)row + 0.5f) / (float)m->rows * wall_size(v_axis);
        const vec3 at = axis_point(axis, part(corner, axis), part(room_low, u_axis) + u,
                                   part(room_low, v_axis) + v);
        const unsigned seed = (unsigned)((w->wall * 4096 + row) * 4096 + i);
        m->light[row * m->columns + i] = room_truth_irradiance(w->t, at, normal, true, seed);
    }
}

room_truth *room_truth_create(const room *r, float grid, int rays, message *why)
{
    room_truth *t = calloc(1, sizeof *t);
    scene things = r->all; // which come first
    things.triangles = r->things;
    bool made = t && (t->things = bvh_create(&things));
    for (int i = 0; i < ROOM_WALLS && made; i++) {
        wall_map *m = &t->wall[i];
        m->columns = 2 + (int)(wall_size((i / 2 + 1) % 3) / grid);
        m->rows = 2 + (int)(wall_size((i / 2 + 2) % 3) / grid);
        made = (m->light = malloc((size_t)m->columns * (size_t)m->rows * sizeof *m->light));
    }
    if (!made) {
        room_truth_free(t);
        fail(why, "no memory for rays");
        return NULL;
    }
    t->r = r;
    t->rays = rays;
    for (int i = 0; i < ROOM_WALLS; i++)
        parallel_for(t->wall[i].rows, light_row, &(wall_work){t, i}, NULL);
    return t;
}

void room_truth_free(room_truth *t)
{
    if (!t) return;
    for (int i = 0; i < ROOM_WALLS; i++) free(t->wall[i].light);
    bvh_free(t->things);
    free(t);
}

// ---- The picture

typedef struct picture_work {
    const room_truth *t;
    vec3 eye;
    float shine;
    view v;
    image *out;
    float *things;
} picture_work;

static void trace_row(void *context, int y)
{
    const picture_work *w = context;
    const room *r = w->t->r;
    for (int x = 0; x < w->v.width; x++) {
        surface piece[VIEW_SAMPLES];
        const int pixel = y * w->v.width + x, pieces = view_surfaces(&w->v, &r->all, x, y, piece);
        vec3 sum = vec(0, 0, 0);
        float things = 0;
        for (int i = 0; i < pieces; i++) {
            const surface *s = piece + i;
            const bool wall = s->object >= r->things_objects;
            vec3 light = vec(VEC_PI, VEC_PI, VEC_PI);
            if (s->object < r->wall_objects)
                light = room_truth_irradiance(w->t, s->position, s->normal, wall, (unsigned)pixel);
            sum = vec_mad(sum, vec_mul(r->all.albedo[s->object], light), s->share / VEC_PI);
            if (wall) continue;
            things += s->share;
            if (w->shine > 0)
                sum = vec_mad(sum,
                              room_truth_shine(w->t, s->position, s->normal,
                                               vec_unit(vec_sub(w->eye, s->position)), w->shine,
                                               (unsigned)pixel),
                              s->share);
        }
        image_set(w->out, x, y, sum);
        if (w->things) w->things[pixel] = things;
    }
}

bool room_truth_picture(const room_truth *t, const camera *eye, float shine, int width, int height,
                        image *out, float *things, message *why)
{
    picture_work w = {.t = t, .eye = eye->position, .shine = shine, .out = out, .things = things};
    if (!image_create(out, width, height)) return fail(why, "no memory for a picture");
    if (!view_create(&w.v, &t->r->all, eye, width, height)) {
        image_free(out);
        return fail(why, "no memory for a picture");
    }
    parallel_for(height, trace_row, &w, "rays");
    view_free(&w.v);
    return true;
}

// ---- Beside pictures

static double error_of(const image *a, const image *truth, const float *things)
{
    double squares = 0, sum = 0, count = 0;
    for (int i = 0; i < a->width * a->height; i++) {
        if (things[i] < 1) continue;
        for (int k = 3 * i; k < 3 * i + 3; k++, count++) {
            squares += pow((double)(a->rgb[k] - truth->rgb[k]), 2);
            sum += (double)truth->rgb[k];
        }
    }
    return sum > 0 ? sqrt(squares * count) / sum : 0;
}

// The second on the right of the first, into which both go.
static bool put_beside(image *first, const image *second)
{
    image both;
    if (!image_create(&both, 2 * first->width, first->height)) return false;
    for (int y = 0; y < first->height; y++) {
        for (int x = 0; x < first->width; x++) {
            image_set(&both, x, y, image_get(first, x, y));
            image_set(&both, x + first->width, y, image_get(second, x, y));
        }
    }
    image_free(first);
    *first = both;
    return true;
}

bool room_truth_beside(const room *r, float shine, image *picture, double *error, message *why)
{
    const int width = picture->width, height = picture->height;
    const camera eye = room_camera((float)width / (float)height);
    room_truth *t = room_truth_create(r, 0.05f, 12, why);
    float *things = malloc((size_t)width * (size_t)height * sizeof *things);
    image truth = {0, 0, NULL};
    bool done = t && (things || fail(why, "no memory for a picture")) &&
                room_truth_picture(t, &eye, shine, width, height, &truth, things, why);
    if (done) {
        *error = error_of(picture, &truth, things);
        done = put_beside(picture, &truth) || fail(why, "no memory for a picture");
    }
    image_free(&truth);
    room_truth_free(t);
    free(things);
    return done;
}
