// Scenes made after the chart's own, see cases.h.
#include "case_parts.h"

#define UNUSED (void)shift, (void)state

static void boxes(scene *s, const float (*b)[6], int count)
{
    for (int i = 0; i < count; i++) box(s, b[i][0], b[i][1], b[i][2], b[i][3], b[i][4], b[i][5]);
}

// ---- Made up by reviewers ----------------------------------------------------------------------

// Ten steps with a railing of thin posts.
static void stairs(scene *s, float shift, uint64_t *state)
{
    UNUSED;
    slab(s);
    for (int i = 0; i < 10; i++) {
        const float x = -1.2f + 0.2f * (float)i, top = 0.16f * (float)(i + 1);
        box(s, x, 0.5f * top, -0.3f, 0.1f, 0.5f * top, 0.8f);
        bar(s, vec(x, top, 0.45f), vec(x, top + 0.5f, 0.45f), 0.012f);
    }
    bar(s, vec(-1.2f, 0.66f, 0.45f), vec(0.6f, 2.1f, 0.45f), 0.02f);
}

// Diagonal wires before a wall.
static void chain_link(scene *s, float shift, uint64_t *state)
{
    UNUSED;
    slab(s);
    box(s, 0, 0.8f, -0.9f, 2, 0.8f, 0.05f);
    for (int i = -12; i <= 12; i++) {
        const float x = 0.16f * (float)i;
        bar(s, vec(x - 0.6f, 0.02f, 0.3f), vec(x + 0.6f, 1.22f, 0.3f), 0.008f);
        bar(s, vec(x + 0.6f, 0.02f, 0.3f), vec(x - 0.6f, 1.22f, 0.3f), 0.008f);
    }
    for (int i = -1; i <= 1; i++) {
        const float x = 1.2f * (float)i;
        bar(s, vec(x, 0, 0.3f), vec(x, 1.3f, 0.3f), 0.03f);
    }
}

// An open rectangle.
static void leaf(scene *s, vec3 centre, vec3 normal, float half_u, float half_v)
{
    const vec3 n = vec_unit(normal), a = vec_unit(vec_cross(n, vec(0.3f, 0.2f, 0.9f)));
    const vec3 u = vec_scale(a, half_u), v = vec_scale(vec_cross(n, a), half_v);
    const int first = scene_put_vertex(s, vec_sub(vec_sub(centre, u), v), n);
    scene_put_vertex(s, vec_sub(vec_add(centre, u), v), n);
    scene_put_vertex(s, vec_add(vec_add(centre, u), v), n);
    scene_put_vertex(s, vec_add(vec_sub(centre, u), v), n);
    scene_put_triangle(s, first, first + 1, first + 2);
    scene_put_triangle(s, first, first + 2, first + 3);
}

static void leafy_tree(scene *s, float shift, uint64_t *state)
{
    (void)shift;
    slab(s);
    bar(s, vec(0, 0, 0), vec(0.05f, 1.3f, 0), 0.07f);
    for (int i = 0; i < 7; i++) {
        const float a = 0.9f * (float)i, y = 0.08f * (float)i;
        bar(s, vec(0, 0.7f + y, 0), vec(0.8f * cosf(a), 1.3f + y, 0.8f * sinf(a)), 0.02f);
    }
    for (int i = 0; i < 160; i++) {
        const float a = draw(state, 0, 6.28), r = draw(state, 0.1, 1), h = draw(state, 0.06, 0.13);
        const vec3 at = vec(r * cosf(a), draw(state, 0.9, 2), r * sinf(a));
        leaf(s, at, vec(draw(state, -1, 1), draw(state, 0.2, 1), draw(state, -1, 1)), h, 0.6f * h);
    }
}

// Close to the ground on four wheels, each of six turned boxes.
static void car(scene *s, float shift, uint64_t *state)
{
    UNUSED;
    slab(s);
    box(s, 0, 0.42f, 0, 1.1f, 0.22f, 0.45f);
    box(s, -0.1f, 0.8f, 0, 0.55f, 0.16f, 0.4f);
    for (int i = 0; i < 24; i++) {
        const float a = VEC_PI / 6 * (float)(i / 4), c = cosf(a), d = sinf(a);
        const vec3 at = vec(i & 1 ? 0.7f : -0.7f, 0.2f, i & 2 ? 0.4f : -0.4f);
        const scene_frame f = {vec(c, d, 0), vec(-d, c, 0), vec(0, 0, 1), at};
        scene_put_box(s, &f, vec(0.193f, 0.052f, 0.07f));
    }
    bar(s, vec(-0.9f, 0.6f, 0.3f), vec(-1, 1.5f, 0.3f), 0.008f);
}

// A hand with four fingers and a thumb, at a height above the ground.
static void hand(scene *s, float height)
{
    const float y = height + 0.05f;
    slab(s);
    box(s, 0, y, 0, 0.45f, 0.05f, 0.4f);
    for (int i = 0; i < 4; i++)
        box(s, -0.36f + 0.24f * (float)i, y, 0.75f + 0.02f * (float)(i % 3), 0.08f, 0.04f, 0.36f);
    turned_box(s, vec(0.62f, y, 0.1f), 0.9f, 0, vec(0.08f, 0.04f, 0.3f));
    bar(s, vec(0, y, -0.4f), vec(0, y + 0.75f, -1.6f), 0.15f);
}

static void low_hand(scene *s, float shift, uint64_t *state)
{
    UNUSED;
    hand(s, 0.05f);
}

static void high_hand(scene *s, float shift, uint64_t *state)
{
    UNUSED;
    hand(s, 1);
}

// Eight thin plates above each other.
static void plates(scene *s, float shift, uint64_t *state)
{
    UNUSED;
    slab(s);
    for (int i = 0; i < 8; i++) {
        const float t = (float)i;
        box(s, -0.1f + 0.03f * t, 0.08f + 0.1f * t, 0.05f * t, 0.8f - 0.06f * t, 0.004f,
            0.7f - 0.05f * t);
    }
}

static void low_blocks(scene *s, uint64_t *state)
{
    slab(s);
    for (int i = 0; i < 16; i++) {
        const float h = draw(state, 0.05, 0.25), x = draw(state, -2, 2), z = draw(state, -2, 2);
        box(s, x, h, z, draw(state, 0.05, 0.2), h, draw(state, 0.05, 0.2));
    }
    ball(s, 0.2f, 0.2f, 0.3f, 0.2f);
}

// One thing that is far higher than all others takes most of the range of depths.
static void mast(scene *s, float shift, uint64_t *state)
{
    (void)shift;
    low_blocks(s, state);
    bar(s, vec(-1.5f, 0, -1.2f), vec(-1.5f, 16, -1.2f), 0.05f);
}

static void bird(scene *s, float shift, uint64_t *state)
{
    (void)shift;
    low_blocks(s, state);
    box(s, 0.5f, 30, 0.5f, 0.3f, 0.05f, 0.3f);
}

// Small casters in a large map.
static void wide_ground(scene *s, float shift, uint64_t *state)
{
    (void)shift;
    box(s, 0, -0.1f, 0, 15, 0.1f, 15);
    for (int i = 0; i < 10; i++) {
        const float h = draw(state, 0.2, 0.6), x = draw(state, -2, 2), z = draw(state, -2, 2);
        box(s, x, h, z, draw(state, 0.1, 0.3), h, draw(state, 0.1, 0.3));
    }
    ball(s, 0.3f, 0.5f, 0.3f, 0.5f);
}

static void blinds(scene *s, float shift, uint64_t *state)
{
    UNUSED;
    slab(s);
    for (int i = 0; i < 22; i++)
        turned_box(s, vec(0, 0.3f + 0.07f * (float)i, 0), 0, 0.7f, vec(1.2f, 0.003f, 0.035f));
    box(s, 0, 0.8f, -1.3f, 1.6f, 0.8f, 0.05f);
}

static void table_and_chair(scene *s, float shift, uint64_t *state)
{
    static const float b[][6] = {
        {0, 0.8f, 0, 0.9f, 0.03f, 0.6f},           {-0.5f, 0.93f, -0.2f, 0.08f, 0.1f, 0.08f},
        {0.4f, 0.1f, 0, 0.15f, 0.1f, 0.1f},        {1.6f, 0.46f, 0, 0.24f, 0.02f, 0.26f},
        {1.4f, 0.45f, 0.22f, 0.02f, 0.45f, 0.02f}, {1.4f, 0.45f, -0.22f, 0.02f, 0.45f, 0.02f},
        {1.8f, 0.22f, 0.22f, 0.02f, 0.22f, 0.02f}, {1.8f, 0.22f, -0.22f, 0.02f, 0.22f, 0.02f}};
    UNUSED;
    slab(s);
    boxes(s, b, 8);
    for (int i = 0; i < 4; i++)
        box(s, i & 1 ? 0.82f : -0.82f, 0.385f, i & 2 ? 0.52f : -0.52f, 0.03f, 0.385f, 0.03f);
    ball(s, 0.1f, 0.98f, 0.1f, 0.15f);
    ball(s, -0.2f, 0.15f, 0.3f, 0.15f);
}

// A small square hole in a wide roof: a spot of light in the umbra.
static void hole(scene *s, float shift, uint64_t *state)
{
    static const float b[][6] = {{1.06f, 1.6f, 0, 0.94f, 0.03f, 2},
                                 {-1.06f, 1.6f, 0, 0.94f, 0.03f, 2},
                                 {0, 1.6f, 1.06f, 0.12f, 0.03f, 0.94f},
                                 {0, 1.6f, -1.06f, 0.12f, 0.03f, 0.94f},
                                 {-0.8f, 0.2f, -0.5f, 0.2f, 0.2f, 0.2f}};
    UNUSED;
    slab(s);
    boxes(s, b, 5);
    ball(s, 0.1f, 0.15f, 0.2f, 0.15f);
}

// Two roofs at different heights that meet as seen from the light.
static void crack(scene *s, float shift, uint64_t *state)
{
    static const float b[][6] = {{-0.75f, 0.5f, 0, 0.75f, 0.02f, 1.2f},
                                 {0.75f, 1.5f, 0, 0.75f, 0.02f, 1.2f},
                                 {0, 1, 0.9f, 0.3f, 0.02f, 0.2f}};
    UNUSED;
    slab(s);
    boxes(s, b, 3);
}

static void colonnade(scene *s, float shift, uint64_t *state)
{
    UNUSED;
    slab(s);
    for (int i = 0; i < 14; i++)
        box(s, -1.5f + 0.5f * (float)(i / 2), 0.6f, i % 2 ? 0.5f : -0.5f, 0.07f, 0.6f, 0.07f);
    box(s, 0, 1.26f, 0, 1.8f, 0.06f, 0.7f);
    for (int i = 0; i < 3; i++)
        box(s, 0, 0.1f * (float)i, 0, 2 - 0.1f * (float)i, 0.05f, 0.95f - 0.1f * (float)i);
}

// Six sagging wires between two posts.
static void wires(scene *s, float shift, uint64_t *state)
{
    UNUSED;
    slab(s);
    for (int i = -1; i <= 1; i += 2) {
        const float x = 1.8f * (float)i;
        bar(s, vec(x, 0, 0), vec(x, 1.8f, 0), 0.04f);
        bar(s, vec(x, 1.7f, -0.5f), vec(x, 1.7f, 0.5f), 0.025f);
    }
    for (int i = 0; i < 72; i++) {
        const float z = -0.5f + 0.2f * (float)(i / 12), a = -1.8f + 0.3f * (float)(i % 12);
        const float b = a + 0.3f;
        bar(s, vec(a, 1.5f + 0.06f * a * a, z), vec(b, 1.5f + 0.06f * b * b, z), 0.006f);
    }
    ball(s, 0.4f, 0.2f, 1, 0.2f);
}

// A wavy sheet of thin boxes: all distances to the ground from nothing on.
static void cloth(scene *s, float shift, uint64_t *state)
{
    UNUSED;
    slab(s);
    for (int i = 0; i < 24; i++) {
        const float x = -1.2f + 0.1f * (float)i, y = 0.15f + 0.14f * sinf(3 * x);
        const float rise = 0.15f + 0.14f * sinf(3 * (x + 0.1f)) - y, half = hypotf(0.1f, rise) / 2;
        const vec3 along = vec_unit(vec(0.1f, rise, 0));
        const scene_frame f = {along, vec(-along.y, along.x, 0), vec(0, 0, 1),
                               vec(x + 0.05f, y + 0.5f * rise, 0)};
        scene_put_box(s, &f, vec(half, 0.004f, 0.9f));
    }
}

static void alley(scene *s, float shift, uint64_t *state)
{
    UNUSED;
    slab(s);
    for (int i = 0; i < 4; i++) box(s, -1.8f + 1.2f * (float)i, 1.2f, 0, 0.42f, 1.2f, 2.2f);
    ball(s, -1.2f, 0.15f, 0.5f, 0.12f);
    ball(s, 0, 0.15f, -0.5f, 0.12f);
}

// Four grids of bars, crossing, far apart.
static void lattice(scene *s, float shift, uint64_t *state)
{
    UNUSED;
    for (int i = 0; i < 36; i++) {
        const float t = -1.2f + 0.3f * (float)(i % 9), y = 0.4f + 0.5f * (float)(i / 9);
        if (i / 9 % 2)
            box(s, t, y, 0, 0.05f, 0.02f, 1.3f);
        else
            box(s, 0, y, t, 1.3f, 0.02f, 0.05f);
    }
}

static void plate_over_ball(scene *s, float shift, uint64_t *state)
{
    static const float b[][6] = {{0, 1.7f, 0, 1.1f, 0.02f, 1.1f},
                                 {0.7f, 0.12f, 0.3f, 0.12f, 0.12f, 0.12f},
                                 {-0.9f, 0.3f, -0.6f, 0.05f, 0.3f, 0.3f}};
    UNUSED;
    slab(s);
    boxes(s, b, 3);
    ball(s, 0, 0.25f, 0, 0.25f);
}

// ---- Made after tuning, for nobody to tune for --------------------------------------------------

// A bicycle wheel of thin spokes, leaning.
static void spokes(scene *s, float shift, uint64_t *state)
{
    UNUSED;
    slab(s);
    for (int i = 0; i < 24; i++) {
        const float a = 2 * VEC_PI / 24 * (float)i, b = a + 2 * VEC_PI / 24;
        const vec3 hub = vec(0, 0.72f, 0.2f);
        const vec3 from = vec(0.7f * cosf(a), 0.72f + 0.69f * sinf(a), 0.2f - 0.2f * sinf(a));
        const vec3 to = vec(0.7f * cosf(b), 0.72f + 0.69f * sinf(b), 0.2f - 0.2f * sinf(b));
        bar(s, hub, from, 0.008f);
        bar(s, from, to, 0.025f);
    }
}

// A stack of leaning books and a shelf above.
static void books(scene *s, float shift, uint64_t *state)
{
    (void)shift;
    slab(s);
    for (int i = 0; i < 12; i++) {
        const float h = draw(state, 0.25, 0.45);
        turned_box(s, vec(-1.1f + 0.18f * (float)i, 0.95f * h, 0), 1.5708f, draw(state, 0, 0.3),
                   vec(0.3f, h, 0.05f));
    }
    box(s, 0, 1.2f, -0.1f, 1.5f, 0.03f, 0.4f);
    box(s, 0, 0.6f, -0.55f, 1.5f, 0.6f, 0.03f);
}

// Slabs that hover a little above each other's edges, turned, like a spiral stair.
static void spiral(scene *s, float shift, uint64_t *state)
{
    UNUSED;
    slab(s);
    for (int i = 0; i < 18; i++) {
        const float a = 0.35f * (float)i;
        turned_box(s, vec(0.6f * cosf(a), 0.1f + 0.12f * (float)i, 0.6f * sinf(a)), -a, 0,
                   vec(0.5f, 0.025f, 0.12f));
    }
    bar(s, vec(0, 0, 0), vec(0, 2.4f, 0), 0.06f);
}

// Stones of all sizes in heaps.
static void rubble(scene *s, float shift, uint64_t *state)
{
    (void)shift;
    slab(s);
    for (int i = 0; i < 90; i++) {
        const float r = 0.04f + 0.3f * powf(draw(state, 0, 1), 4), a = draw(state, 0, 6.28);
        const float d = draw(state, 0, 1.6);
        turned_box(s, vec(d * cosf(a), draw(state, 0, 0.5) * (1.6f - d), d * sinf(a)),
                   draw(state, 0, 3), draw(state, -1, 1), vec(r, 0.6f * r, 0.8f * r));
    }
}

// A perforated roof over a room with a wall: many small lit spots.
static void sieve(scene *s, float shift, uint64_t *state)
{
    UNUSED;
    slab(s);
    for (int i = 0; i < 9; i++) {
        const float t = -1.2f + 0.3f * (float)i;
        box(s, t, 1.3f, 0, 0.11f, 0.02f, 1.35f);
        box(s, 0, 1.32f, t, 1.35f, 0.02f, 0.11f);
    }
    box(s, 0, 0.65f, -1.4f, 1.4f, 0.65f, 0.04f);
    ball(s, 0.3f, 0.3f, 0.2f, 0.3f);
}

// Two trunks, the one before the other as seen from the light, and grass of thin blades at their
// feet.
static void grass(scene *s, float shift, uint64_t *state)
{
    (void)shift;
    slab(s);
    bar(s, vec(-0.4f, 0, -0.3f), vec(-0.35f, 2, -0.3f), 0.12f);
    bar(s, vec(0.5f, 0, 0.5f), vec(0.6f, 1.4f, 0.5f), 0.09f);
    for (int i = 0; i < 300; i++) {
        const float x = draw(state, -1.5, 1.5), z = draw(state, -1.5, 1.5),
                    h = draw(state, 0.1, 0.3);
        bar(s, vec(x, 0, z), vec(x + draw(state, -0.1, 0.1), h, z + draw(state, -0.1, 0.1)),
            0.006f);
    }
}

const kind new_kinds[CASE_NEW + CASE_UNSEEN] = {
    {"stairs", stairs, {-0.7f, 1, 0.5f}, true, false, -1, NULL},
    {"chain link", chain_link, {0.25f, 0.7f, 1}, true, false, -1, NULL},
    {"leafy tree", leafy_tree, {0.3f, 1, 0.45f}, false, false, -1, NULL},
    {"car", car, {0.5f, 1, 0.6f}, true, false, -1, NULL},
    {"low hand", low_hand, {0.2f, 1, 0.3f}, true, false, -1, NULL},
    {"high hand", high_hand, {0.2f, 1, 0.3f}, true, false, -1, NULL},
    {"plates", plates, {0.3f, 1, 0.2f}, true, false, -1, NULL},
    {"mast", mast, {0.2f, 1, 0.3f}, true, false, -1, NULL},
    {"bird", bird, {0.05f, 1, 0.08f}, true, false, -1, NULL},
    {"wide ground", wide_ground, {0.4f, 1, 0.3f}, true, false, -1, NULL},
    {"blinds", blinds, {0.2f, 0.8f, 1}, true, false, -1, NULL},
    {"table and chair", table_and_chair, {0.4f, 1, 0.3f}, true, false, -1, NULL},
    {"hole", hole, {0.1f, 1, 0.15f}, true, false, -1, NULL},
    {"crack", crack, {0.02f, 1, 0.03f}, true, false, -1, NULL},
    {"colonnade", colonnade, {0.5f, 0.8f, 0.9f}, true, false, -1, NULL},
    {"wires", wires, {0.3f, 1, 0.4f}, true, false, -1, NULL},
    {"cloth", cloth, {0.3f, 1, 0.2f}, true, false, -1, NULL},
    {"alley", alley, {0.35f, 1, 0.1f}, true, false, -1, NULL},
    {"lattice", lattice, {0.1f, 1, 0.13f}, true, true, -1, NULL},
    {"plate over ball", plate_over_ball, {0.15f, 1, 0.1f}, true, false, -1, NULL},
    {"spokes", spokes, {0.2f, 1, 0.5f}, true, false, -1, NULL},
    {"books", books, {0.4f, 1, 0.7f}, true, false, -1, NULL},
    {"spiral", spiral, {0.25f, 1, 0.15f}, true, false, -1, NULL},
    {"rubble", rubble, {0.6f, 0.7f, 0.3f}, true, false, -1, NULL},
    {"sieve", sieve, {0.2f, 1, 0.35f}, true, false, -1, NULL},
    {"grass", grass, {0.5f, 1, 0.25f}, true, false, -1, NULL},
};
