#include "room.h"

#include <string.h>

const vec3 room_low = {-3, 0, -2.5f}, room_high = {3, 3, 2.5f}, room_centre = {0, 1, 0};
const vec3 room_wall_low = {-0.9f, -0.3f, -3.5f}, room_wall_high = {3, 4.5f, 2.8f};
const vec3 room_ambient = {0.14f, 0.14f, 0.15f};
const vec3 room_lamp_radiance = {36, 28.5f, 19}, room_sky_radiance = {1.6f, 2.0f, 2.8f};
const vec3 room_sun_irradiance = {20, 16, 11};
const vec3 room_to_sun = {0.975703f, 0.186525f, -0.114785f};

// ---- Walls: rectangles that are seen from inside

// From a corner along two edges; the normal is their cross product's.
static void put_wall(scene *s, vec3 corner, vec3 u, vec3 v)
{
    const vec3 n = vec_cross(u, v);
    const int first = scene_put_vertex(s, corner, n);
    scene_put_vertex(s, vec_add(corner, u), n);
    scene_put_vertex(s, vec_add(vec_add(corner, u), v), n);
    scene_put_vertex(s, vec_add(corner, v), n);
    scene_put_triangle(s, first, first + 1, first + 2);
    scene_put_triangle(s, first, first + 2, first + 3);
}

// A piece of the right wall, from and to in y and z.
static void put_right(scene *s, float y0, float y1, float z0, float z1)
{
    if (z1 > z0) put_wall(s, vec(room_high.x, y0, z0), vec(0, 0, z1 - z0), vec(0, y1 - y0, 0));
}

// The wall goes on beyond the room's corners: all that could see the sun is behind it.
static void put_sun_casters(scene *s, float door)
{
    const float z0 = ROOM_DOOR_FROM, z1 = z0 + ROOM_DOOR_WIDTH, high = ROOM_DOOR_HEIGHT;
    scene_begin_object(s, 0.25f, 0.50f, 0.42f);
    put_right(s, high, room_wall_high.y, room_wall_low.z, room_wall_high.z);
    put_right(s, room_wall_low.y, high, room_wall_low.z, z0);
    put_right(s, room_wall_low.y, high, z1, room_wall_high.z);
    put_right(s, room_wall_low.y, 0, z0, z1);
    scene_begin_object(s, 0.55f, 0.42f, 0.28f);
    put_right(s, 0, high, z0 + door, z1);
}

static void put_other_walls(scene *s)
{
    const vec3 size = vec_sub(room_high, room_low);
    scene_begin_object(s, 0.80f, 0.79f, 0.76f);
    put_wall(s, vec(room_low.x, room_high.y, room_low.z), vec(size.x, 0, 0), vec(0, 0, size.z));
    scene_begin_object(s, 0.72f, 0.70f, 0.66f);
    put_wall(s, room_low, vec(size.x, 0, 0), vec(0, size.y, 0));
    scene_begin_object(s, 0.70f, 0.12f, 0.08f);
    put_wall(s, room_low, vec(0, size.y, 0), vec(0, 0, size.z));
    scene_begin_object(s, 0.46f, 0.38f, 0.30f);
    put_wall(s, room_low, vec(0, 0, size.z), vec(size.x, 0, 0));
    scene_begin_object(s, 0.72f, 0.70f, 0.66f);
    put_wall(s, vec(room_low.x, 0, room_high.z), vec(0, size.y, 0), vec(size.x, 0, 0));
}

// ---- Things

static void put_plant(scene *s)
{
    const vec3 foot = vec(-0.08f, 0.73f, -0.16f);
    const scene_frame pot = scene_frame_at(vec_add(foot, vec(0, 0.09f, 0)), 0.4f, 0);
    scene_begin_object(s, 0.62f, 0.30f, 0.18f);
    scene_put_box(s, &pot, vec(0.085f, 0.09f, 0.085f));
    scene_begin_object(s, 0.30f, 0.52f, 0.16f);
    for (int i = 0; i < 9; i++) {
        const float turn = 2.4f * (float)i, rise = 0.25f + 0.016f * (float)i;
        const float lean = 0.15f + 0.13f * (float)(i % 3);
        // Leaves lie along their frame's x axis; it points outwards and a little up.
        scene_frame leaf = scene_frame_at(vec_add(foot, vec(0, rise, 0)), turn, 0);
        const vec3 x = leaf.x;
        leaf.x = vec_mad(vec_scale(x, cosf(lean)), vec(0, 1, 0), sinf(lean));
        leaf.y = vec_mad(vec_scale(x, -sinf(lean)), vec(0, 1, 0), cosf(lean));
        leaf.origin = vec_mad(leaf.origin, leaf.x, 0.15f);
        scene_put_leaf(s, &leaf, 0.15f, 0.05f);
    }
}

static void put_things(scene *s)
{
    scene_begin_object(s, 0.74f, 0.72f, 0.68f);
    const scene_frame top = scene_frame_at(vec(0, 0.705f, 0), 0, 0);
    scene_put_box(s, &top, vec(0.85f, 0.025f, 0.5f));
    for (int i = 0; i < 4; i++) {
        const float x = i & 1 ? 0.78f : -0.78f, z = i & 2 ? 0.43f : -0.43f;
        const scene_frame leg = scene_frame_at(vec(x, 0.34f, z), 0, 0);
        scene_put_box(s, &leg, vec(0.03f, 0.34f, 0.03f));
    }
    const scene_frame large = scene_frame_at(vec(-0.48f, 0.90f, 0.10f), 0, 0);
    const scene_frame small = scene_frame_at(vec(0.20f, 0.82f, 0.25f), 0, 0);
    const scene_frame tall = scene_frame_at(vec(0.50f, 0.93f, -0.10f), 0.5f, 0);
    const scene_frame flat = scene_frame_at(vec(0.56f, 0.755f, 0.28f), -0.35f, 0);
    scene_begin_object(s, 0.80f, 0.80f, 0.80f);
    scene_put_sphere(s, &large, 0.17f, 24);
    scene_put_box(s, &tall, vec(0.10f, 0.20f, 0.10f));
    scene_begin_object(s, 0.20f, 0.32f, 0.62f);
    scene_put_sphere(s, &small, 0.09f, 18);
    scene_begin_object(s, 0.75f, 0.62f, 0.22f);
    scene_put_box(s, &flat, vec(0.13f, 0.025f, 0.09f));
    put_plant(s);
}

// ---- All of it

// It hangs by a cord, which is there for looks.
static void put_lamp(room *r, float lean)
{
    const vec3 up = vec(-sinf(lean), cosf(lean), 0), hook = vec(0.1f, room_high.y, 0.35f);
    const float length = 1.1f, half = 0.5f * (length - ROOM_LAMP_RADIUS);
    const scene_frame cord = {{up.y, -up.x, 0}, up, {0, 0, 1}, vec_mad(hook, up, -half)};
    r->lamp = vec_mad(hook, up, -length);
    scene_begin_object(&r->all, 0.1f, 0.1f, 0.1f);
    scene_put_box(&r->all, &cord, vec(0.007f, half, 0.007f));
    r->walls = r->all.triangles;
    r->wall_objects = r->all.objects;
    const scene_frame lamp = scene_frame_at(r->lamp, 0, 0);
    scene_begin_object(&r->all, room_lamp_radiance.x, room_lamp_radiance.y, room_lamp_radiance.z);
    scene_put_sphere(&r->all, &lamp, ROOM_LAMP_RADIUS, 24);
}

bool room_create(room *r, float time)
{
    const float phase = 2 * VEC_PI * time;
    scene *s = &r->all;
    memset(r, 0, sizeof *r);
    r->door = ROOM_DOOR_WIDTH * (0.55f + 0.45f * cosf(phase));
    put_things(s);
    r->things = s->triangles;
    r->things_objects = s->objects;
    r->low = r->high = s->vertices ? s->position[0] : vec(0, 0, 0);
    for (int i = 1; i < s->vertices; i++) {
        r->low = vec_min(r->low, s->position[i]);
        r->high = vec_max(r->high, s->position[i]);
    }
    put_sun_casters(s, r->door);
    r->sun_casters = s->triangles;
    put_other_walls(s);
    put_lamp(r, 0.75f * sinf(phase));
    scene_begin_object(s, room_sky_radiance.x, room_sky_radiance.y, room_sky_radiance.z);
    put_right(s, 0, ROOM_DOOR_HEIGHT, ROOM_DOOR_FROM, ROOM_DOOR_FROM + r->door);
    return scene_end(s);
}

void room_free(room *r)
{
    scene_free(&r->all);
}

camera room_camera(float aspect)
{
    return camera_look(vec(0.45f, 1.50f, 2.1f), vec(0.03f, 1.2f, -0.2f), 0.95f, aspect);
}
