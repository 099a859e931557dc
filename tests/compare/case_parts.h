// What the scenes of the comparison are built of, and the table that names them.
#ifndef CASE_PARTS_H
#define CASE_PARTS_H

#include "../support/test.h"
#include "cases.h"

static inline float draw(uint64_t *state, double low, double high)
{
    return (float)test_range(state, low, high);
}

static inline void box(scene *s, float x, float y, float z, float hx, float hy, float hz)
{
    const scene_frame f = scene_frame_at(vec(x, y, z), 0, 0);
    scene_put_box(s, &f, vec(hx, hy, hz));
}

static inline void turned_box(scene *s, vec3 centre, float turn, float tilt, vec3 half)
{
    const scene_frame f = scene_frame_at(centre, turn, tilt);
    scene_put_box(s, &f, half);
}

static inline void ball(scene *s, float x, float y, float z, float radius)
{
    const scene_frame f = scene_frame_at(vec(x, y, z), 0, 0);
    scene_put_sphere(s, &f, radius, 20);
}

// A slab with its top at 0: ground that is in the depth map.
static inline void slab(scene *s)
{
    box(s, 0, -0.1f, 0, 2.5f, 0.1f, 2.5f);
}

// A square bar from a to b.
static inline void bar(scene *s, vec3 a, vec3 b, float radius)
{
    const vec3 along = vec_sub(b, a), z = vec_unit(along);
    const vec3 x = vec_unit(vec_cross(fabsf(z.y) < 0.9f ? vec(0, 1, 0) : vec(1, 0, 0), z));
    const scene_frame f = {x, vec_cross(z, x), z, vec_scale(vec_add(a, b), 0.5f)};
    scene_put_box(s, &f, vec(radius, radius, 0.5f * vec_length(along)));
}

typedef struct kind {
    const char *name;
    void (*build)(scene *s, float shift, uint64_t *state); // NULL: the demo's scene
    float sun[3];
    bool closed, ground;
    int moving;
    const char *mesh; // a shared one that stands in the middle
} kind;

// Scenes after the chart's own: those made up by reviewers, and those that nobody tuned for.
// (cases_new.c)
extern const kind new_kinds[CASE_NEW + CASE_UNSEEN];

#endif
