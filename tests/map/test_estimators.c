// What the estimators promise beyond closeness to rays: shadows that only brighten outwards, umbras
// that stay dark whatever the frustum, and what normals, many points and tolerances do.
#include "../support/scenes.h"
#include "../support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct setup {
    scene scene;
    mssm_light light;
    mssm_map *map;
    float *depth;
    void *memory;
    int side;
} setup;

static void *allocate(size_t bytes)
{
    void *memory = malloc(bytes);
    if (!memory) abort();
    return memory;
}

static void setup_map(setup *u, int side, int samples, int with_back)
{
    const size_t count = (size_t)(side * side * samples), bytes = mssm_map_bytes(side, 6);
    float *back = allocate(count * sizeof *back);
    u->side = side;
    u->depth = allocate(count * sizeof *u->depth);
    u->memory = allocate(bytes);
    scene_depth(&u->scene, &u->light, side, samples, u->depth, back);
    CHECK(mssm_map_init(&u->map, u->memory, bytes, side, 6) == MSSM_OK, "init");
    CHECK(mssm_map_update(u->map, u->depth, with_back ? back : NULL, samples) == MSSM_OK, "update");
    free(back);
}

static void setup_free(setup *u)
{
    free(u->depth);
    free(u->memory);
}

static double visibility(const setup *u, const mssm_settings *settings, const double point[3])
{
    const float p[3] = {(float)point[0], (float)point[1], (float)point[2]};
    return (double)mssm_map_visibility(u->map, &u->light, settings, p);
}

static double visibility_set(const setup *u, const mssm_settings *settings, const double point[3],
                             const double normal[3], double length)
{
    float p[3], n[3];
    for (int k = 0; k < 3; k++) {
        p[k] = (float)point[k];
        n[k] = (float)(normal[k] * length);
    }
    return (double)mssm_map_visibility_normal(u->map, &u->light, settings, p, n);
}

static double visibility_normal(const setup *u, const double point[3], const double normal[3],
                                double length)
{
    return visibility_set(u, NULL, point, normal, length);
}

// Of the part above the horizon.
static double visibility_above(const setup *u, const double point[3], const double normal[3])
{
    const mssm_settings s = {.estimator = MSSM_HORIZON};
    return visibility_set(u, &s, point, normal, 1);
}

static const float up[3] = {0, 1, 0}, axis[3] = {1, 0, 0};

// Straight from above, with the frustum's sides given.
static void sun_above(setup *u, double tangent, float low_y, float high_y, float half)
{
    const float low[3] = {-half, low_y, -half}, high[3] = {half, high_y, half};
    CHECK(mssm_light_directional(&u->light, up, axis, (float)tangent, (float)tangent, low, high) ==
              MSSM_OK,
          "light");
}

static void spot_above(setup *u, float height, float tan_half_fov, float z_near, float z_far,
                       double half_width)
{
    const float at[3] = {0, height, 0};
    CHECK(mssm_light_spot(&u->light, at, up, axis, tan_half_fov, z_near, z_far, (float)half_width,
                          (float)half_width) == MSSM_OK,
          "light");
}

// ---- shape of penumbras ------------------------------------------------------------------------

// A cube or a box of random size, turned at random, and a floor that only the map has.
static void turned_box(setup *u, int is_cube, int with_floor, uint64_t *state)
{
    double a[3], b[3], n[3], half[3];
    for (int k = 0; k < 3; k++) {
        a[k] = test_range(state, -1, 1);
        b[k] = test_range(state, -1, 1);
        half[k] = is_cube ? 0.25 : test_range(state, 0.1, 0.28);
    }
    for (int k = 0; k < 3; k++)
        n[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    memset(&u->scene, 0, sizeof u->scene);
    scene_add_box(&u->scene, 0, 0, 0, half[0], half[1], half[2]);
    scene_turn_last(&u->scene, a, n);
    if (with_floor) scene_add_box(&u->scene, 0, -0.65, 0, 3, 0.05, 3);
    scene_finish(&u->scene);
}

// How far visibility falls from its highest on the way out along a row on the floor.
static double deepest_fall(const setup *u, double angle, double length, int rays)
{
    const double normal[3] = {0, 1, 0};
    double top = 0, fall = 0;
    for (int i = 0; i < 100; i++) {
        const double r = length * i / 100, p[3] = {r * cos(angle), -0.6, r * sin(angle)};
        uint64_t state = 1; // the same rays for all
        const double v = rays ? scene_visibility(&u->scene, &u->light, p, normal, 24, &state)
                              : visibility(u, NULL, p);
        top = fmax(top, v);
        fall = fmax(fall, top - v);
    }
    return fall;
}

static int rising(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

// Rows through the penumbra of one box in one map, and how far they fall where the truth does not.
static int falls_of_box(setup *u, int is_spot, int with_floor, double *fall)
{
    static const double tangents[4] = {0.03, 0.1, 0.2, 0.4};
    int rows = 0;
    if (is_spot)
        spot_above(u, 2.4f, 0.5f, 1, 4, 0);
    else
        sun_above(u, 0, with_floor ? -0.7f : -0.5f, 0.5f, with_floor ? 0.9f : 0.5f);
    setup_map(u, 256, 4, 0);
    u->scene.count = 1;
    for (int t = 0; t < 4; t++) {
        u->light.half_u = u->light.half_v = (float)(is_spot ? 3 * tangents[t] : tangents[t]);
        for (int row = 0; row < 20; row++) {
            const double angle = 6.2831853 * (row + 0.3) / 20, length = with_floor ? 0.6 : 1.2;
            double f = deepest_fall(u, angle, length, 0);
            if (f > 0.03) f = fmax(f - deepest_fall(u, angle, length, 1), 0);
            fall[rows++] = f;
        }
    }
    setup_free(u);
    return rows;
}

// Longish boxes under the largest light are the worst.
static void penumbrae_only_brighten_outwards(void)
{
    enum { BOXES = 4 };
    static const double most_rows[2] = {0.015, 0.005};
    static double fall[BOXES * 4 * 80];
    uint64_t state = 30;
    for (int is_cube = 0; is_cube < 2; is_cube++) {
        int rows = 0, bad = 0;
        for (int way = 0; way < test_trials(BOXES) * 4; way++) {
            setup u;
            turned_box(&u, is_cube, way / 2 % 2, &state);
            rows += falls_of_box(&u, way % 2, way / 2 % 2, fall + rows);
        }
        for (int i = 0; i < rows; i++) bad += fall[i] > 0.03;
        qsort(fall, (size_t)rows, sizeof *fall, rising);
        const double most = fall[(rows - 1) * 99 / 100];
        test_note("%s: %d of %d rows fall by more than 0.03; 99%% by at most %.3f, all by %.3f",
                  is_cube ? "cubes" : "boxes", bad, rows, most, fall[rows - 1]);
        if (rows < 1000) continue;
        CHECK(bad <= most_rows[is_cube] * rows, "%d of %d rows fall by more than 0.03", bad, rows);
        CHECK(most <= 0.05, "99%% of rows fall by at most %.3f", most);
    }
}

// Half of a light's reach into ground that it grazes lies in front of each receiver, and a caster hides
// much of the other half, by which ground is known.
static double error_beside_plate(const double sun[3], double tangent, double height)
{
    enum { GRID = 12 };
    static const double normal[3] = {0, 1, 0};
    setup u;
    memset(&u.scene, 0, sizeof u.scene);
    scene_add_box(&u.scene, 0, -0.05, 0, 2, 0.05, 2);
    scene_add_box(&u.scene, 0, height, 0, 0.9, 0.03, 0.9);
    memcpy(u.scene.sun, sun, sizeof u.scene.sun);
    scene_finish(&u.scene);
    CHECK(scene_light(&u.scene, tangent, tangent, &u.light) == MSSM_OK, "light");
    setup_map(&u, 256, 4, 0);
    double squares = 0;
    for (int i = 0; i < GRID * GRID; i++) {
        const double p[3] = {3.9 * (i % GRID + 0.5) / GRID - 1.95, 0,
                             3.9 * (i / GRID + 0.5) / GRID - 1.95};
        uint64_t state = 1;
        const double truth = scene_visibility(&u.scene, &u.light, p, normal, 16, &state);
        squares += pow(visibility(&u, NULL, p) - truth, 2);
    }
    setup_free(&u);
    return sqrt(squares / (GRID * GRID));
}

static void grazed_ground_is_no_caster(void)
{
    static const double sun[3][3] = {{0.36, 0.864, 0.352}, {0.64, 0.74, 0.21}, {0.1, 0.87, 0.48}};
    double sum = 0;
    for (int i = 0; i < 12; i++)
        sum += error_beside_plate(sun[i / 4], i % 2 ? 0.4 : 0.2, i / 2 % 2 ? 1.6 : 0.4);
    test_note("rms error %.4f", sum / 12);
    CHECK(sum / 12 < 0.033, "rms error %.4f", sum / 12);
}

// ---- scenes of several layers ------------------------------------------------------------------

// Over all that a light reaches in a scene, with the receivers' normals or without them.
static double error_in_scene(scene *s, double tangent, int with_normals)
{
    enum { RECEIVERS = 500 };
    double squares = 0;
    uint64_t state = 5;
    setup u;
    scene_finish(s);
    u.scene = *s;
    CHECK(scene_light(&u.scene, tangent, tangent, &u.light) == MSSM_OK, "light");
    setup_map(&u, 128, 1, 0);
    for (int i = 0; i < RECEIVERS; i++) {
        double p[3], n[3], reach;
        scene_receiver(&u.scene, &state, p, n);
        if (scene_facing(&u.light, n, &reach) < reach) continue; // the horizon's business
        const double truth = scene_visibility(&u.scene, &u.light, p, n, 12, &state);
        const double v = with_normals ? visibility_normal(&u, p, n, 1) : visibility(&u, NULL, p);
        squares += pow(v - truth, 2) / RECEIVERS;
    }
    setup_free(&u);
    return sqrt(squares);
}

// Two layers of bars, far apart: what a wide kernel has dealt with is not counted again by narrower
// ones, that it blocks beside.
static void bars_below_bars_block_once(void)
{
    scene s;
    memset(&s, 0, sizeof s);
    for (int i = 0; i < 10; i++) scene_add_box(&s, 0.36 * i - 1.62, 0.5, 0, 0.06, 0.04, 1.7);
    for (int i = 0; i < 8; i++) scene_add_box(&s, 0, 1.6, 0.46 * i - 1.61, 1.7, 0.04, 0.08);
    s.sun[0] = 0.25;
    s.sun[1] = 1;
    s.sun[2] = 0.4;
    const double rms = error_in_scene(&s, 0.15, 0);
    test_note("rms error %.4f", rms);
    CHECK(rms < 0.07, "rms error %.4f", rms);
}

// A small hole in a wide roof, and things below: faint light, of which the receiver's own surface must
// take none, with its normal or by what is much nearer than the roof.
static void light_through_a_hole_is_not_lost(void)
{
    scene s;
    memset(&s, 0, sizeof s);
    scene_add_box(&s, 0, -0.05, 0, 2.5, 0.05, 2.5);
    for (int i = -1; i < 2; i += 2) {
        scene_add_box(&s, 1.06 * i, 1.6, 0, 0.94, 0.03, 2);
        scene_add_box(&s, 0, 1.6, 1.06 * i, 0.12, 0.03, 0.94);
    }
    scene_add_box(&s, -0.8, 0.2, -0.5, 0.2, 0.2, 0.2);
    scene_add_sphere(&s, 0.1, 0.15, 0.2, 0.15);
    s.ground_casts = 1;
    s.sun[0] = 0.1;
    s.sun[1] = 1;
    s.sun[2] = 0.15;
    const double without = error_in_scene(&s, 0.5, 0), with = error_in_scene(&s, 0.5, 1);
    test_note("rms error %.4f, with normals %.4f", without, with);
    CHECK(without < 0.0155, "rms error %.4f", without);
    CHECK(with < 0.0125, "rms error with normals %.4f", with);
}

// A wall that the light grazes, between boards that hide it whole: all that is in front of it is as
// close to its tangent plane as the wall would be, but none of the wall is to be seen behind.
static void walls_between_boards_are_dark(void)
{
    const double wall[3] = {0, 0, 1};
    uint64_t state = 6;
    double sum[3] = {0};
    int count = 0, lit[3] = {0};
    for (int i = 0; i < 6; i++) {
        setup u;
        memset(&u, 0, sizeof u);
        scene_add_box(&u.scene, 0, 0.8, -0.02, 1, 0.8, 0.02);
        for (int k = 0; k < 5; k++) scene_add_box(&u.scene, 0, 0.4 * k, 0.15, 1, 0.015, 0.15);
        u.scene.sun[0] = test_range(&state, -0.3, 0.3);
        u.scene.sun[1] = 1;
        u.scene.sun[2] = test_range(&state, 0.12, 0.3);
        scene_finish(&u.scene);
        CHECK(scene_light(&u.scene, 0.1, 0.1, &u.light) == MSSM_OK, "light");
        setup_map(&u, 256, 1, 0);
        for (int j = 0; j < test_trials(1000); j++) {
            const double p[3] = {test_range(&state, -0.7, 0.7), test_range(&state, 0.03, 1.57), 0};
            if (scene_visibility(&u.scene, &u.light, p, wall, 12, &state) > 0) continue;
            const double v[3] = {visibility(&u, NULL, p), visibility_normal(&u, p, wall, 1),
                                 visibility_above(&u, p, wall)};
            for (int k = 0; k < 3; k++) {
                sum[k] += v[k];
                lit[k] += v[k] > 0.05;
            }
            count++;
        }
        setup_free(&u);
    }
    for (int k = 0; k < 3; k++) {
        const char *with[3] = {"no normal", "a normal", "the horizon"};
        test_note("%s: %.4f on average, over .05 at %d of %d", with[k], sum[k] / count, lit[k],
                  count);
        CHECK(sum[k] < 0.004 * count, "%s: %.4f", with[k], sum[k] / count);
    }
}

// Columns that the light grazes, which have themselves behind them, too; and shelves, where half of
// the wall sees light.
static void columns_are_told_from_shelves(void)
{
    scene columns, shelves;
    memset(&columns, 0, sizeof columns);
    memset(&shelves, 0, sizeof shelves);
    for (int i = -1; i < 2; i++) scene_add_box(&columns, 0.8 * i, 0.45, 0, 0.12, 0.45, 0.4);
    scene_add_box(&columns, 0, 1, 0, 0.92, 0.1, 0.4);
    columns.sun[0] = 0.3;
    columns.sun[1] = 1;
    columns.sun[2] = 0.1;
    for (int i = 0; i < 5; i++) scene_add_box(&shelves, 0, 0.4 * i, 0, 0.8, 0.015, 0.2);
    scene_add_box(&shelves, 0, 0.8, -0.22, 0.8, 0.8, 0.02);
    for (int i = -1; i < 2; i += 2) scene_add_box(&shelves, 0.8 * i, 0.8, 0, 0.02, 0.8, 0.2);
    shelves.sun[0] = 0.2;
    shelves.sun[1] = 1;
    shelves.sun[2] = 0.17;
    columns.ground_casts = shelves.ground_casts = 1;
    scene_add_box(&columns, 0, -0.05, 0, 2, 0.05, 2);
    scene_add_box(&shelves, 0, -0.05, 0, 2, 0.05, 2);
    const double among = error_in_scene(&columns, 0.05, 1), on = error_in_scene(&shelves, 0.05, 1);
    test_note("rms error among columns %.4f, on shelves %.4f", among, on);
    CHECK(among < 0.0135 && on < 0.06, "columns %.4f, shelves %.4f", among, on);
}

// A hand just above the ground: what lies a little behind a receiver is its own surface by its normal
// only as far as its tangent plane comes.
static void ground_below_a_hand_is_not_the_hand(void)
{
    static const double arm[3] = {0, 0.75, -1.2}, across[3] = {1, 0, 0};
    scene s;
    memset(&s, 0, sizeof s);
    scene_add_box(&s, 0, -0.05, 0, 2.5, 0.05, 2.5);
    scene_add_box(&s, 0, 0.1, 0, 0.45, 0.05, 0.4);
    for (int i = 0; i < 4; i++)
        scene_add_box(&s, 0.24 * i - 0.36, 0.1, 0.75 + 0.02 * (i % 3), 0.08, 0.04, 0.36);
    scene_add_box(&s, 0, 0.475, -1, 0.7, 0.15, 0.15);
    scene_turn_last(&s, arm, across);
    s.ground_casts = 1;
    s.sun[0] = 0.2;
    s.sun[1] = 1;
    s.sun[2] = 0.3;
    const double rms = error_in_scene(&s, 0.15, 1);
    test_note("rms error %.4f", rms);
    CHECK(rms < 0.044, "rms error %.4f", rms);
}

// A bird far above low blocks: after its kernel the next is for what the map holds below, not for what
// moments of so many depths make of it.
static void birds_cost_no_shadows_below(void)
{
    scene s;
    uint64_t state = 3;
    memset(&s, 0, sizeof s);
    scene_add_box(&s, 0, -0.05, 0, 2.5, 0.05, 2.5);
    for (int i = 0; i < 16; i++) {
        const double h = test_range(&state, 0.05, 0.25), x = test_range(&state, -2, 2),
                     z = test_range(&state, -2, 2);
        scene_add_box(&s, x, h, z, 0.15, h, 0.1);
    }
    scene_add_box(&s, 0.5, 30, 0.5, 0.3, 0.05, 0.3);
    s.ground_casts = 1;
    s.sun[0] = 0.05;
    s.sun[1] = 1;
    s.sun[2] = 0.08;
    const double small = error_in_scene(&s, 0.15, 0), large = error_in_scene(&s, 0.5, 0);
    test_note("rms error %.4f, of a larger light %.4f", small, large);
    CHECK(small < 0.0225 && large < 0.053, "rms error %.4f, of a larger light %.4f", small, large);
}

// From kernels of less than a texel on, by 3% a step. Balls and the texels beside their rims, where what
// is right for a kernel of one texel has to fade out until it is one and a half wide.
static void growing_lights_do_not_pop(void)
{
    enum { RECEIVERS = 1500, STEPS = 100 };
    int large = 0;
    uint64_t state = 1;
    setup u;
    memset(&u.scene, 0, sizeof u.scene);
    for (int i = 0; i < 5; i++)
        scene_add_sphere(&u.scene, 0.5 * i - 1, 0.3 + 0.1 * (i % 2), 0.2 * (i % 3) - 0.2, 0.3);
    u.scene.sun[0] = 0.3;
    u.scene.sun[1] = 1;
    scene_finish(&u.scene);
    CHECK(scene_light(&u.scene, 0.05, 0.05, &u.light) == MSSM_OK, "light");
    setup_map(&u, 64, 1, 0);
    for (int i = 0; i < RECEIVERS; i++) {
        double p[3], normal[3], before = 0;
        scene_receiver(&u.scene, &state, p, normal);
        for (int k = 0; k <= STEPS; k++) {
            u.light.half_u = u.light.half_v = (float)(0.02 * pow(1.03, k));
            const double v = visibility(&u, NULL, p);
            large += k > 0 && fabs(v - before) > 0.15;
            before = v;
        }
    }
    setup_free(&u);
    test_note("%d of %d steps are larger than .15", large, RECEIVERS * STEPS);
    CHECK(large <= 8, "%d steps larger than .15", large);
}

// ---- maps of both faces ------------------------------------------------------------------------

// Slats over a floor, whose depths in such a map are halfway to their backs. Half of the floor lies
// behind its receivers, no further off than the slats are in front: a surface through the receivers
// would tell in their favour, and what is halfway to its back does so by half (.095 otherwise).
static void both_faces_keep_shadows_on_thick_floors(void)
{
    enum { RECEIVERS = 500 };
    static const double tangents[3] = {0.1, 0.2, 0.4}, normal[3] = {0, 1, 0};
    double squares = 0;
    for (int t = 0; t < 3; t++) {
        setup u;
        uint64_t state = 40;
        memset(&u.scene, 0, sizeof u.scene);
        scene_add_box(&u.scene, 0, -0.1, 0, 1.5, 0.1, 1.5);
        for (int i = 0; i < 6; i++) scene_add_box(&u.scene, 0.2 * i - 0.6, 0.1, 0, 0.05, 0.02, 0.6);
        u.scene.sun[0] = 0.4;
        u.scene.sun[1] = 1;
        scene_finish(&u.scene);
        CHECK(scene_light(&u.scene, tangents[t], tangents[t], &u.light) == MSSM_OK, "light");
        setup_map(&u, 256, 1, 1);
        for (int i = 0; i < RECEIVERS; i++) {
            const double p[3] = {test_range(&state, -0.8, 0.6), 0, test_range(&state, -0.6, 0.6)};
            const double truth = scene_visibility(&u.scene, &u.light, p, normal, 12, &state);
            squares += pow(visibility(&u, NULL, p) - truth, 2);
        }
        setup_free(&u);
    }
    const double rms = sqrt(squares / (3 * RECEIVERS));
    test_note("rms error %.4f", rms);
    CHECK(rms < 0.08, "rms error %.4f", rms);
}

// The other side of that: a plate tilted by 63 degrees shades itself where what is halfway to its back
// does not tell in its favour at all (by .09). The whole light is above its horizon.
static void both_faces_leave_tilted_plates_lit(void)
{
    enum { RECEIVERS = 400 };
    static const double along[3] = {1, 2, 0}, across[3] = {0, 0, 1}, thick = 0.02;
    const double length = sqrt(5);
    double lost = 0;
    uint64_t state = 41;
    setup u;
    memset(&u.scene, 0, sizeof u.scene);
    scene_add_box(&u.scene, 0, 0, 0, 1, thick, 1);
    scene_turn_last(&u.scene, along, across);
    scene_add_box(&u.scene, 3, 3, 3, 0.1, 0.1, 0.1); // room towards the light
    u.scene.sun[1] = 1;
    scene_finish(&u.scene);
    CHECK(scene_light(&u.scene, 0.4, 0.4, &u.light) == MSSM_OK, "light");
    setup_map(&u, 256, 1, 1);
    for (int i = 0; i < RECEIVERS; i++) {
        const double x = test_range(&state, -0.8, 0.8), z = test_range(&state, -0.8, 0.8);
        const double p[3] = {(x - 2 * thick) / length, (2 * x + thick) / length, z};
        lost += (1 - visibility(&u, NULL, p)) / RECEIVERS;
    }
    setup_free(&u);
    CHECK(lost < 0.03, "darker by %.4f", lost);
}

// The light comes straight down and is all but a point, so that a box's shadow is as wide as the box.
// Halfway to its back it is some texels above the ground: no rim of the receiver's own surface.
static void both_faces_keep_shadows_of_low_boxes(void)
{
    enum { PLACES = 16, STEPS = 400 };
    static const double texel = 2.0 / 128, half = 0.3, way = 0.4;
    for (int texels = 6; texels <= 12; texels += 3) {
        double width = 0;
        for (int place = 0; place < PLACES; place++) {
            const double height = texels * texel, x = texel * (place + 0.5) / PLACES;
            setup u;
            memset(&u.scene, 0, sizeof u.scene);
            scene_add_box(&u.scene, x, height / 2, 0, half, height / 2, half);
            scene_finish(&u.scene);
            sun_above(&u, 0.001, 0, 1, 1);
            setup_map(&u, 128, 1, 1);
            for (int i = 0; i < STEPS; i++) {
                const double p[3] = {way * (2 * (i + 0.5) / STEPS - 1), 0, 0.1};
                width += 2 * way / STEPS * (1 - visibility(&u, NULL, p)) / PLACES;
            }
            setup_free(&u);
        }
        test_note("%d texels high: wider by %.3f texels", texels, (width - 2 * half) / texel);
        CHECK(fabs(width - 2 * half) < 0.1 * texel, "%d texels high: wider by %.3f texels", texels,
              (width - 2 * half) / texel);
    }
}

// ---- frusta that reach far towards the light ---------------------------------------------------

// Below a plate that hides the whole light. In a box 512 times as tall as the plate is above the
// ground the moment bias (1.3e-6 and 7e-7 of the square of the range of depth) would let light
// through.
static void umbras_stay_dark_whatever_the_frustum(void)
{
    enum { TALL = 8, NEAR_PLANES = 7 };
    // Heights of the box, and near planes.
    static const float reach[TALL + NEAR_PLANES] = {1, 16, 64,   128,  256,   1024,  4096,  16384,
                                                    3, 1,  0.3f, 0.1f, 0.02f, 0.01f, 0.001f};
    for (int way = 0; way < TALL + NEAR_PLANES; way++) {
        setup u;
        memset(&u.scene, 0, sizeof u.scene);
        scene_add_box(&u.scene, 0, -0.05, 0, 9, 0.05, 9);
        scene_add_box(&u.scene, 0, 0.495, 0, 1, 0.005, 1);
        scene_finish(&u.scene);
        if (way < TALL)
            sun_above(&u, 0.2, 0, reach[way], 2);
        else
            spot_above(&u, 4, 0.7f, reach[way], 5, 0.3);
        setup_map(&u, 256, 1, 0);
        double lightest = 0;
        for (int e = 0; e < 9; e++) {
            const mssm_settings s = {.moments = e / 3 ? e / 3 * 2 + 2 : 0,
                                     .estimator = (mssm_estimator)(e % 3)};
            for (int i = 0; i < 25; i++) {
                const double at[3] = {0.3 * (i % 5 - 2), 0, 0.3 * (i / 5 - 2)};
                lightest = fmax(lightest, visibility(&u, &s, at));
                const float point[3] = {(float)at[0], 0, (float)at[2]};
                lightest = fmax(lightest,
                                (double)mssm_map_visibility_normal(u.map, &u.light, &s, point, up));
            }
            CHECK(lightest < 0.01, "%s %g, estimator %d, %d moments: %.4f",
                  way < TALL ? "height" : "near plane", (double)reach[way], e % 3, s.moments,
                  lightest);
        }
        if (lightest > 0.005)
            test_note("%s %g: %.4f", way < TALL ? "height" : "near plane", (double)reach[way],
                      lightest);
        setup_free(&u);
    }
}

// Under a high plate, beside a lower one, and something far below: all of the light's cone meets
// plates in the map, and yet light comes in between them.
static void light_comes_through_gaps_between_plates(void)
{
    static const double below[2] = {30, 90}, height[2] = {0.1, 0.2};
    uint64_t state = 4;
    for (int way = 0; way < 4; way++) {
        setup u;
        memset(&u.scene, 0, sizeof u.scene);
        scene_add_box(&u.scene, -1, way / 2 ? height[way % 2] / 2 : height[way % 2], 0, 1,
                      way / 2 ? height[way % 2] / 2 : 0.002, 2);
        scene_add_box(&u.scene, 1, 1, 0, 1, 0.002, 2);
        scene_add_box(&u.scene, 2.2, -below[way % 2], 2.2, 0.05, 0.05, 0.05);
        u.scene.sun[1] = 1;
        scene_finish(&u.scene);
        CHECK(scene_light(&u.scene, 0.3, 0.3, &u.light) == MSSM_OK, "light");
        setup_map(&u, 256, 1, 0);
        for (int i = 0; i < 5; i++) {
            const double at[3] = {0.03 + 0.03 * i, 0, 0}, normal[3] = {0, 1, 0};
            const double truth = scene_visibility(&u.scene, &u.light, at, normal, 20, &state);
            const double seen = visibility(&u, NULL, at);
            CHECK(fabs(seen - truth) < 0.15, "%g below, %.2f aside: %.3f of %.3f", below[way % 2],
                  at[0], seen, truth);
        }
        setup_free(&u);
    }
}

// Root mean square errors of the three estimators over receivers in a scene below its light.
static void rms(const setup *u, int receivers, uint64_t seed, double error[3])
{
    memset(error, 0, 3 * sizeof *error);
    for (int i = 0; i < receivers; i++) {
        double point[3], normal[3];
        scene_receiver(&u->scene, &seed, point, normal);
        const double truth = scene_visibility(&u->scene, &u->light, point, normal, 12, &seed);
        for (int e = 0; e < 3; e++) {
            const mssm_settings s = {.estimator = (mssm_estimator)e};
            error[e] += pow(visibility(u, &s, point) - truth, 2);
        }
    }
    for (int e = 0; e < 3; e++) error[e] = sqrt(error[e] / receivers);
}

static void boxes_on_ground(setup *u)
{
    memset(&u->scene, 0, sizeof u->scene);
    scene_add_box(&u->scene, 0, -0.1, 0, 2, 0.1, 2);
    scene_add_box(&u->scene, 0.1, 0.3, 0, 0.4, 0.3, 0.3);
    scene_add_box(&u->scene, -0.9, 0.15, 0.7, 0.2, 0.15, 0.2);
    scene_add_box(&u->scene, 0.9, 0.1, -0.8, 0.3, 0.1, 0.1);
    scene_add_box(&u->scene, 0.9, 0.6, 0.9, 0.1, 0.6, 0.1);
    u->scene.ground_casts = 1;
}

static setup boxes_below(int is_spot)
{
    setup u;
    boxes_on_ground(&u);
    u.scene.sun[0] = 0.5;
    u.scene.sun[1] = 1;
    scene_finish(&u.scene);
    if (is_spot)
        spot_above(&u, 4, 0.8f, 0.5f, 5, 0.3);
    else
        CHECK(scene_light(&u.scene, 0.2, 0.1, &u.light) == MSSM_OK, "light");
    setup_map(&u, 128, 1, 0);
    return u;
}

// Neither what a frustum holds of empty space nor a thin mast in a corner costs contact shadows.
// The single kernels of the published estimators search as far as the mast: five times the error
// below 40 units.
static void near_planes_and_masts_cost_no_contact_shadows(void)
{
    static const float nears[4] = {2, 0.5f, 0.2f, 0.01f};
    static const double masts[4] = {0, 3, 10, 40}, times[2][3] = {{1.2, 1.2, 1.4}, {1.2, 9, 9}};
    const int receivers = test_trials(1500);
    for (int way = 0; way < 2; way++) {
        double error[4][3], best[3] = {1, 1, 1};
        for (int i = 0; i < 4; i++) {
            setup u;
            boxes_on_ground(&u);
            u.scene.sun[1] = 1;
            scene_finish(&u.scene);
            // The mast is in the map alone, and beside where the receivers are.
            if (way == 1 && masts[i] > 0)
                scene_add_box(&u.scene, -1.97, masts[i] / 2, -1.97, 0.02, masts[i] / 2, 0.02);
            if (way == 0)
                spot_above(&u, 4, 0.8f, nears[i], 5, 0.3);
            else
                sun_above(&u, 0.1, -0.2f, (float)fmax(masts[i], 1.2), 2);
            setup_map(&u, 256, 1, 0);
            u.scene.count = 5;
            rms(&u, receivers, 31, error[i]);
            for (int e = 0; e < 3; e++) best[e] = fmin(best[e], error[i][e]);
            setup_free(&u);
        }
        for (int e = 0; e < 3; e++) {
            test_note("%s, estimator %d: rms %.4f %.4f %.4f %.4f",
                      way ? "masts of 0, 3, 10, 40" : "near planes 2, .5, .2, .01", e, error[0][e],
                      error[1][e], error[2][e], error[3][e]);
        }
        for (int i = 0; i < 12 && receivers >= 1000; i++) {
            const double got = error[i / 3][i % 3], least = best[i % 3];
            CHECK(got <= 0.035, "way %d, %d, estimator %d: rms %.4f", way, i / 3, i % 3, got);
            CHECK(got <= times[way][i % 3] * least, "way %d, %d, estimator %d: rms %.4f, best %.4f",
                  way, i / 3, i % 3, got, least);
        }
    }
}

// Below a sheet that goes on beyond the map, up to its rim: what the map holds there stands for the
// rest.
static void no_light_comes_in_past_the_rim(void)
{
    static const float half[4] = {0, 0.02f, 0.1f, 0.3f};
    static const double part[7] = {0, 0.5, 0.8, 0.88, 0.92, 0.96, 0.99};
    double lightest = 0;
    for (int way = 0; way < 6; way++) {
        setup u;
        double across = 8 * 0.57735;
        memset(&u.scene, 0, sizeof u.scene);
        scene_add_box(&u.scene, 0, -0.001 - (way < 4 ? 2 : 1), 0, 90, 0.001, 90);
        scene_finish(&u.scene);
        if (way < 4) { // a cone of 60 degrees
            spot_above(&u, 0, 0.57735f, 0.5f, 12, (double)half[way]);
        } else if (way == 4) {
            spot_above(&u, 0, 1, 0.1f, 20, 0.1);
            across = 8;
        } else { // a cascade
            sun_above(&u, 0.1, -8, 0, 5);
            across = 5;
        }
        setup_map(&u, 256, 4, 0);
        for (int i = 0; i < 7; i++) {
            for (int e = 0; e < 3; e++) {
                const mssm_settings s = {.estimator = (mssm_estimator)e};
                const double p[3] = {across * part[i], -8, i % 2 ? across * part[i] : 0};
                const double v = visibility(&u, &s, p);
                lightest = fmax(lightest, v);
                CHECK(v <= 0.02, "way %d, estimator %d, at %.2f of the radius: %.4f", way, e,
                      part[i], v);
            }
        }
        setup_free(&u);
    }
    test_note("lightest %.4f", lightest);
}

// ---- normals -----------------------------------------------------------------------------------

static double length_of(const double a[3])
{
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

// Tilts a unit normal by an angle, in a random direction.
static void tilt(const double n[3], double angle, uint64_t *state, double tilted[3])
{
    double a[3], across[3], length = 0;
    while (length < 0.1) {
        for (int k = 0; k < 3; k++) a[k] = test_range(state, -1, 1);
        for (int k = 0; k < 3; k++)
            across[k] = n[(k + 1) % 3] * a[(k + 2) % 3] - n[(k + 2) % 3] * a[(k + 1) % 3];
        length = length_of(across);
    }
    for (int k = 0; k < 3; k++) tilted[k] = cos(angle) * n[k] + sin(angle) / length * across[k];
}

enum { NO_NORMAL, NORMAL, TILTED, REVERSED, NORMAL_KINDS };

static void normals_tell_the_receivers_own_surface(void)
{
    static const double tangents[2] = {0.1, 0.4};
    const int receivers = test_trials(250), side = test_trials(256) > 20 ? 256 : 64;
    double mean[NORMAL_KINDS] = {0};
    uint64_t state = 32;
    for (int way = 0; way < 2 * SCENE_COUNT; way++) {
        double squares[NORMAL_KINDS] = {0};
        setup u;
        scene_make(&u.scene, way / 2);
        CHECK(scene_light(&u.scene, tangents[way % 2], tangents[way % 2], &u.light) == MSSM_OK,
              "light");
        setup_map(&u, side, 1, 0);
        for (int i = 0; i < receivers; i++) {
            double point[3], normal[3], n[3];
            scene_receiver(&u.scene, &state, point, normal);
            const double truth = scene_visibility(&u.scene, &u.light, point, normal, 12, &state);
            tilt(normal, 20 * 0.0174532925199433, &state, n);
            const double v[NORMAL_KINDS] = {
                visibility(&u, NULL, point), visibility_normal(&u, point, normal, 1),
                visibility_normal(&u, point, n, 1), visibility_normal(&u, point, normal, -1)};
            for (int k = 0; k < NORMAL_KINDS; k++) {
                CHECK(v[k] >= 0 && v[k] <= 1, "%s: %g", u.scene.name, v[k]);
                squares[k] += pow(v[k] - truth, 2);
            }
        }
        for (int k = 0; k < NORMAL_KINDS; k++)
            mean[k] += sqrt(squares[k] / receivers) / (2 * SCENE_COUNT);
        setup_free(&u);
    }
    test_note(
        "mean rms %.4f without normals, %.4f with them, %.4f tilted by 20 degrees, %.4f reversed",
        mean[NO_NORMAL], mean[NORMAL], mean[TILTED], mean[REVERSED]);
    if (receivers < 100) return;
    CHECK(mean[NORMAL] < 0.99 * mean[NO_NORMAL], "%.4f with normals, %.4f without", mean[NORMAL],
          mean[NO_NORMAL]);
    CHECK(mean[TILTED] < 1.1 * mean[NORMAL], "tilted: %.4f, not %.4f", mean[TILTED], mean[NORMAL]);
    CHECK(mean[REVERSED] < 1.01 * mean[NORMAL], "reversed: %.4f, not %.4f", mean[REVERSED],
          mean[NORMAL]);
}

// A plate so low that without a normal bias and fade would take part of it for the ground. Ground that
// faces the light, or nearly so, has it hidden; open ground stays lit with normals 20 degrees off.
static void normals_close_contacts(void)
{
    uint64_t state = 17;
    for (int trial = 0; trial < test_trials(60) * 10; trial++) {
        setup u;
        const int is_spot = trial & 1, side = 64 << trial % 4;
        if (is_spot)
            spot_above(&u, 2.4f, 0.5f, 1, 3, 2.4 * test_range(&state, 0.01, 0.1));
        else
            sun_above(&u, test_range(&state, 0.01, 0.1), -0.2f, 1, 1);
        const double texel = (is_spot ? 2.4 : 2) / side, height = test_range(&state, 1.4, 3);
        memset(&u.scene, 0, sizeof u.scene);
        scene_add_box(&u.scene, 0, -0.05, 0, 3, 0.05, 3);
        scene_add_box(&u.scene, 0, height * texel - 1e-4, 0, 0.3, 1e-4, 0.3);
        scene_finish(&u.scene);
        setup_map(&u, side, 1, 0);
        const double n[3] = {0, 1, 0};
        double tilted[3];
        for (int i = 0; i < 40; i++) {
            const double x = test_range(&state, -0.2, 0.2), z = test_range(&state, -0.2, 0.2);
            const double below[3] = {x, 0, z}, away[3] = {x < 0 ? x - 0.5 : x + 0.5, 0, z};
            tilt(n, test_range(&state, 0, 0.35), &state, tilted);
            const double hidden = visibility_normal(&u, below, n, 1);
            const double lit = visibility_normal(&u, away, tilted, 1);
            CHECK(hidden < 0.02, "side %d, %.2f texels below a plate: %.3f", side, height, hidden);
            CHECK(lit > 0.98, "side %d: open ground sees %.3f", side, lit);
        }
        setup_free(&u);
    }
}

// ---- lights that the horizon cuts --------------------------------------------------------------

enum { ALONE = 3, CUT_SCENES = 7 };

// Bodies alone, then with others around.
static void cut_scene(scene *s, int which)
{
    static const double a[3] = {1, 0.2, 0.6}, c[3] = {-0.4, -0.6, 1}, d[3] = {0.5, 0.5, 1};
    memset(s, 0, sizeof *s);
    if (which == 0) scene_add_sphere(s, 0.3, -0.2, 0.4, 0.3);
    if (which == 1 || which == 2)
        scene_add_box(s, 0, 0, 0, which == 1 ? 0.8 : 0.15, which == 1 ? 0.15 : 0.9, 0.4);
    if (which == 1 || which == 2) scene_turn_last(s, a, c);
    if (which == 3 || which == 4) scene_add_box(s, 0, -0.1, 0, 2, 0.1, 2);
    if (which == 3) scene_add_sphere(s, 0.1, 0.4, 0, 0.4);
    if (which == 4) scene_add_box(s, -0.5, 0.4, 0, 0.3, 0.4, 0.3);
    if (which == 4) scene_add_box(s, 0.6, 0.6, 0.4, 0.3, 0.3, 0.3);
    if (which == 4) scene_turn_last(s, d, c);
    for (int i = 0; i < 6 && which == 5; i++)
        scene_add_sphere(s, 0.4 * i - 1, 0.3 * (i % 3), 0.35 * (i % 2), 0.2 + 0.05 * (i % 4));
    if (which == 6) scene_add_box(s, 0, 0, 0, 0.4, 0.4, 0.4);
    if (which == 6) scene_add_box(s, -0.9, 0.2, 0.1, 0.1, 0.8, 0.7);
    if (which == 6) scene_add_sphere(s, 0.8, 0.5, 0.2, 0.3);
}

// Weighted by the share of the light that is above, as shading does.
typedef struct cut_sums {
    double weight, seen, truth, squares, without, divided;
} cut_sums;

static void add_cut_receivers(const setup *u, int count, uint64_t *state, cut_sums *sum)
{
    for (int i = 0; i < count; i++) {
        double p[3], n[3], reach;
        scene_surface(&u->scene, state, p, n);
        const double facing = scene_facing(&u->light, n, &reach);
        if (fabs(facing) >= reach) continue;
        const double truth = scene_visibility_above(&u->scene, &u->light, p, n, 12, state);
        const double v = visibility_above(u, p, n), without = visibility(u, NULL, p);
        const double weight = 0.5 + 0.5 * facing / reach;
        CHECK(v >= 0 && v <= 1, "%g", v);
        sum->weight += weight;
        sum->seen += weight * v;
        sum->truth += weight * truth;
        sum->squares += weight * pow(v - truth, 2);
        sum->without += weight * pow(without - truth, 2);
        sum->divided += weight * pow(fmin(without / weight, 1) - truth, 2);
    }
}

static void normals_leave_what_is_above_the_horizon(void)
{
    static const double tangents[4] = {0.1, 0.4, 1, 2.5};
    const int receivers = test_trials(400), side = test_trials(256) > 20 ? 256 : 64;
    uint64_t state = 34;
    for (int which = 0; which < CUT_SCENES; which++) {
        cut_sums sum = {0};
        for (int way = 0; way < 16; way++) {
            const double t = tangents[way / 4], turn = 2.4 * way;
            setup u;
            cut_scene(&u.scene, which);
            u.scene.sun[0] = cos(turn);
            u.scene.sun[1] = which == 3 || which == 4 ? 0.3 + 0.2 * (way % 4) : 0.9 * (way % 4) - 1;
            u.scene.sun[2] = sin(turn);
            scene_finish(&u.scene);
            CHECK(scene_light(&u.scene, t, way % 2 ? t : 0.5 * t, &u.light) == MSSM_OK, "light");
            setup_map(&u, side, 4, 0);
            add_cut_receivers(&u, receivers, &state, &sum);
            setup_free(&u);
        }
        const double rms = sqrt(sum.squares / sum.weight), kept = sum.seen / sum.truth;
        const double without = sqrt(sum.without / sum.weight),
                     divided = sqrt(sum.divided / sum.weight);
        test_note("%s %d: %.3f of the light, rms %.3f; without normals %.3f, divided by the share "
                  "above %.3f",
                  which < ALONE ? "alone" : "among others", which, kept, rms, without, divided);
        if (receivers < 100) continue;
        CHECK(rms < 0.6 * without && rms < divided, "%.3f, without %.3f, divided %.3f", rms,
              without, divided);
        CHECK(which >= ALONE || (kept > 0.97 && rms < 0.06), "alone: %.3f, rms %.3f", kept, rms);
        CHECK(fabs(kept - 1) < 0.1, "%.3f of the light", kept);
    }
}

// A receiver goes around a ball under a light. Steps of the search from texel to texel are what is
// left, as large without a normal.
static void horizons_do_not_pop(void)
{
    enum { STEPS = 3000 };
    static const double tangents[3] = {0.2, 0.7, 2};
    int large = 0;
    for (int way = 0; way < 12; way++) {
        const double t = tangents[way % 3], lean = 0.3 * way;
        double before = 0, worst = 0;
        int whole = 0;
        setup u;
        cut_scene(&u.scene, way % 2 ? 0 : 5);
        u.scene.sun[0] = cos(lean);
        u.scene.sun[1] = 0.4;
        u.scene.sun[2] = sin(lean);
        scene_finish(&u.scene);
        CHECK(scene_light(&u.scene, t, 0.6 * t, &u.light) == MSSM_OK, "light");
        setup_map(&u, 256, 4, 0);
        for (int i = 0; i <= STEPS; i++) {
            const double turn = 6.283185307179586 * i / STEPS, c = cos(turn), s = sin(turn);
            const double n[3] = {c * cos(lean), s, c * sin(lean)};
            double p[3], reach;
            for (int k = 0; k < 3; k++)
                p[k] = u.scene.shapes[0].centre[k] + u.scene.shapes[0].half[0] * n[k];
            const double facing = scene_facing(&u.light, n, &reach);
            const double share = fmin(fmax(0.5 + 0.5 * facing / reach, 0), 1);
            const double v = share * share * visibility_above(&u, p, n);
            if (i) worst = fmax(worst, fabs(v - before));
            large += i && fabs(v - before) > 0.05;
            if (share >= 1) whole++;
            before = v;
        }
        test_note("tangent %.1f, %s: steps up to %.3f", t, way % 2 ? "alone" : "among others",
                  worst);
        CHECK(whole > 100, "the light is never above");
        CHECK(worst < 0.1, "a step of %.3f", worst);
        setup_free(&u);
    }
    CHECK(large < 8, "%d steps over .05", large);
}

// Powers of two change no digit of it, so that nothing at all may depend on them.
static void only_the_direction_of_a_normal_counts(void)
{
    static const double lengths[6] = {0x1p-66, 0x1p-33, 0x1p-10, 8, 0x1p50, 0x1p100};
    uint64_t state = 33;
    double worst[6] = {0};
    for (int way = 0; way < 2; way++) {
        setup u = boxes_below(way);
        for (int i = 0; i < test_trials(2000); i++) {
            double point[3], normal[3];
            const double none[2][3] = {{0, 0, 0}, {0, (double)NAN, 0}};
            scene_receiver(&u.scene, &state, point, normal);
            const double plain = visibility(&u, NULL, point),
                         v = visibility_normal(&u, point, normal, 1);
            const float p[3] = {(float)point[0], (float)point[1], (float)point[2]};
            CHECK((double)mssm_map_visibility_normal(u.map, &u.light, NULL, p, NULL) == plain,
                  "NULL");
            CHECK(visibility_normal(&u, point, none[0], 1) == plain, "zero");
            CHECK(visibility_normal(&u, point, none[1], 1) == plain, "NaN");
            for (int l = 0; l < 6; l++)
                worst[l] =
                    fmax(worst[l], fabs(visibility_normal(&u, point, normal, lengths[l]) - v));
        }
        setup_free(&u);
    }
    for (int l = 0; l < 6; l++) CHECK(worst[l] <= 0, "length %g: %g", lengths[l], worst[l]);
}

// Points that interpolation or rounding has put a part of a texel below the surface that the map
// holds.
static void normals_help_points_below_their_surface(void)
{
    static const double below[3] = {0, 0.25, 0.5};
    const int side = 256;
    double error[3][2] = {{0}};
    int count = 0;
    for (int s = 0; s < SCENE_COUNT; s++) {
        uint64_t state = 34;
        setup u;
        scene_make(&u.scene, s);
        CHECK(scene_light(&u.scene, 0.1, 0.1, &u.light) == MSSM_OK, "light");
        setup_map(&u, side, 1, 0);
        const double texel = 2 * (double)fmaxf(u.light.extent_u, u.light.extent_v) / side;
        for (int i = 0; i < test_trials(300); i++) {
            double point[3], normal[3], p[3];
            scene_receiver(&u.scene, &state, point, normal);
            if (point[1] <= u.scene.ground && !u.scene.ground_casts) continue;
            if (scene_visibility(&u.scene, &u.light, point, normal, 12, &state) < 1) continue;
            for (int b = 0; b < 3; b++) {
                for (int k = 0; k < 3; k++) p[k] = point[k] - below[b] * texel * normal[k];
                error[b][0] += 1 - visibility(&u, NULL, p);
                error[b][1] += 1 - visibility_normal(&u, p, normal, 1);
            }
            count++;
        }
        setup_free(&u);
    }
    for (int b = 0; b < 3; b++) {
        const double without = error[b][0] / count, with = error[b][1] / count;
        test_note("%.2f texels below: lit points lose %.4f without normals, %.4f with", below[b],
                  without, with);
        if (count < 1000) continue;
        CHECK(with <= without + (below[b] > 0 ? 0 : 1e-3),
              "%.2f texels below: %.4f with normals, %.4f without", below[b], with, without);
    }
}

// ---- many points, tolerance, least depths ------------------------------------------------------

static void many_points_are_as_one(void)
{
    enum { COUNT = 500 };
    static float points[COUNT][3], normals[COUNT][3], many[COUNT + 1];
    uint64_t state = 35;
    for (int way = 0; way < 12; way++) {
        setup u = boxes_below(way % 2);
        const mssm_settings s = {.estimator = (mssm_estimator)(way / 2 % 3)};
        const int with_normals = way >= 6;
        const float(*n)[3] = with_normals ? (const float(*)[3])normals : NULL;
        for (int i = 0; i < COUNT; i++) {
            double point[3], normal[3];
            scene_receiver(&u.scene, &state, point, normal);
            for (int k = 0; k < 3; k++) {
                points[i][k] = (float)point[k];
                normals[i][k] = (float)normal[k];
            }
            if (i % 10 == 3) points[i][i % 3] = i % 20 == 3 ? (float)NAN : (float)INFINITY;
            if (i % 10 == 6) normals[i][i % 3] = i % 20 == 6 ? (float)NAN : -(float)INFINITY;
        }
        for (int i = 0; i <= COUNT; i++) many[i] = -7;
        mssm_map_visibility_many(u.map, &u.light, &s, 0, (const float(*)[3])points, n, many);
        mssm_map_visibility_many(u.map, &u.light, &s, -3, (const float(*)[3])points, n, many);
        CHECK(many[0] == -7, "no points wrote %g", (double)many[0]);
        mssm_map_visibility_many(u.map, &u.light, &s, COUNT, (const float(*)[3])points, n, many);
        CHECK(many[COUNT] == -7, "one too many: %g", (double)many[COUNT]);
        for (int i = 0; i < COUNT; i++) {
            const float one = with_normals ? mssm_map_visibility_normal(u.map, &u.light, &s,
                                                                        points[i], normals[i])
                                           : mssm_map_visibility(u.map, &u.light, &s, points[i]);
            CHECK(memcmp(&one, &many[i], sizeof one) == 0, "point %d: %g, alone %g", i,
                  (double)many[i], (double)one);
            CHECK(i % 10 != 3 || many[i] == 1, "not finite: %g", (double)many[i]);
        }
        // Without a map or a light all is lit; without points or room for the result nothing
        // happens.
        mssm_map_visibility_many(NULL, &u.light, &s, COUNT, (const float(*)[3])points, n, many);
        for (int i = 0; i < COUNT; i++) CHECK(many[i] == 1, "no map: %g", (double)many[i]);
        many[1] = 0;
        mssm_map_visibility_many(u.map, NULL, &s, 2, (const float(*)[3])points, n, many);
        CHECK(many[1] == 1, "no light: %g", (double)many[1]);
        many[0] = -7;
        mssm_map_visibility_many(u.map, &u.light, &s, 2, NULL, n, many);
        mssm_map_visibility_many(u.map, &u.light, &s, 2, (const float(*)[3])points, n, NULL);
        CHECK(many[0] == -7, "no points wrote %g", (double)many[0]);
        setup_free(&u);
    }
}

static float leave_on_the_stack(float value)
{
    volatile float left[4096];
    for (int i = 0; i < 4096; i++) left[i] = value;
    return left[4095];
}

// Nothing is read that was not set before.
static void what_was_on_the_stack_does_not_matter(void)
{
    static float (*volatile leave)(float) = leave_on_the_stack; // a frame of its own
    static const float values[3] = {0, 1e30f, -1e30f};
    for (int way = 0; way < 16; way++) {
        const mssm_settings s = {.moments = way % 2 ? 4 : 6,
                                 .estimator = (mssm_estimator)(way / 4)};
        uint64_t state = 42;
        setup u = boxes_below(way / 2 % 2);
        u.light.half_u = u.light.half_v = 0.5f;
        for (int i = 0; i < 200; i++) {
            double point[3], normal[3], v[3];
            scene_receiver(&u.scene, &state, point, normal);
            for (int k = 0; k < 3; k++) {
                leave(values[k]);
                v[k] = i % 2 ? visibility_set(&u, &s, point, normal, 1) : visibility(&u, &s, point);
            }
            CHECK(v[0] == v[1] && v[0] == v[2], "%g, with other numbers there %g or %g", v[0], v[1],
                  v[2]);
        }
        setup_free(&u);
    }
}

static void tolerance_bounds_the_error(void)
{
    static const float tolerances[3] = {1.0f / 256, 0.02f, 0.1f};
    const mssm_settings exact = {.tolerance = 1e-9f};
    double worst[3] = {0};
    uint64_t state = 36;
    for (int which = 0; which < SCENE_COUNT; which++) {
        setup u;
        scene_make(&u.scene, which);
        CHECK(scene_light(&u.scene, 0.3, 0.2, &u.light) == MSSM_OK, "light");
        setup_map(&u, 128, 1, 0);
        for (int i = 0; i < test_trials(2000); i++) {
            double point[3], normal[3];
            scene_receiver(&u.scene, &state, point, normal);
            const double v = visibility(&u, &exact, point);
            for (int t = 0; t < 3; t++) {
                const mssm_settings s = {.tolerance = tolerances[t]};
                worst[t] = fmax(worst[t], fabs(visibility(&u, &s, point) - v));
            }
        }
        setup_free(&u);
    }
    test_note("at 1/256, .02, .1 differs by %.5f %.5f %.5f", worst[0], worst[1], worst[2]);
    for (int t = 0; t < 3; t++)
        CHECK(worst[t] <= (double)tolerances[t] + 1e-5, "tolerance %g: %g", (double)tolerances[t],
              worst[t]);
}

// A map with some texels at random depths, and a sun along z, whose depth is that of shadow space.
static void speckled_map(setup *u, int side, uint64_t *state)
{
    const size_t bytes = mssm_map_bytes(side, 6);
    const double dense = pow(10, test_range(state, -5, -1));
    memset(&u->light, 0, sizeof u->light);
    for (int i = 0; i < 3; i++) u->light.world_to_shadow[5 * i] = 1;
    u->light.world_to_shadow[15] = u->light.extent_u = u->light.extent_v = 1;
    u->light.z_far = 2;
    u->side = side;
    u->depth = allocate((size_t)(side * side) * sizeof *u->depth);
    u->memory = allocate(bytes);
    for (int i = 0; i < side * side; i++)
        u->depth[i] = test_uniform(state) < dense ? (float)test_range(state, -0.9, 0.7) : 1;
    u->depth[(int)test_range(state, 0, side * side)] = (float)test_range(state, -0.9, 0.7);
    CHECK(mssm_map_init(&u->map, u->memory, bytes, side, 6) == MSSM_OK, "init");
    CHECK(mssm_map_update(u->map, u->depth, NULL, 1) == MSSM_OK, "update");
}

// Whether no depth before z lies within the cone above texel coordinates (x, y), widened to times
// its half-width, which is half texels per unit of depth, and by some texels more. Beyond the map
// its rim goes on.
static int cone_is_free(const setup *u, double x, double y, double z, double half, double times,
                        double more)
{
    const double cx = fmin(fmax(x, 0), u->side), cy = fmin(fmax(y, 0), u->side);
    for (int i = 0; i < u->side * u->side; i++) {
        const double before = z - (double)u->depth[i];
        if (before < 0) continue;
        const double reach = 0.5 + times * fmax(half * before, 0.5) + more;
        if (fabs(i % u->side + 0.5 - cx) < reach && fabs(i / u->side + 0.5 - cy) < reach) return 0;
    }
    return 1;
}

// Least depths are of some texels around too, so what is close by may turn one kernel into several.
static void points_with_a_free_cone_are_lit(void)
{
    static const int sides[6] = {1, 2, 3, 57, 255, 257};
    static const double times[2] = {1, 3}, more[2] = {0.5, 3};
    uint64_t state = 37;
    int count[2] = {0}, exact[2] = {0};
    double darkest[2] = {1, 1};
    for (int trial = 0; trial < test_trials(30) * 6; trial++) {
        setup u;
        speckled_map(&u, sides[trial % 6], &state);
        for (int i = 0; i < 60; i++) {
            const double tangent = pow(10, test_range(&state, -2, 0.3));
            const double p[3] = {test_range(&state, -1, 1), test_range(&state, -1, 1),
                                 test_range(&state, -0.9, 1)};
            const double x = (0.5 + 0.5 * p[0]) * u.side, y = (0.5 + 0.5 * p[1]) * u.side;
            u.light.half_u = (float)tangent;
            u.light.half_v = (float)(tangent * test_uniform(&state));
            const double v = visibility(&u, NULL, p), half = tangent * 0.5 * u.side;
            for (int w = 0; w < 2; w++) {
                if (!cone_is_free(&u, x, y, p[2], half, times[w], more[w])) continue;
                count[w]++;
                exact[w] += v >= 1;
                darkest[w] = fmin(darkest[w], v);
            }
        }
        setup_free(&u);
    }
    test_note("%d free cones, %d of exactly 1, the darkest %.5f; three times as wide: %d, %d, %.5f",
              count[0], exact[0], darkest[0], count[1], exact[1], darkest[1]);
    CHECK(darkest[1] >= 1, "nothing three cones wide, and yet %.6f", darkest[1]);
    CHECK(darkest[0] > 0.98, "nothing in the cone, and yet %.6f", darkest[0]);
    CHECK(exact[0] >= 0.99 * count[0], "exactly 1: %d of %d", exact[0], count[0]);
}

// Single texels over a kernel of up to three texels, also in the last row and column of any side.
static void no_texel_is_missed(void)
{
    static const int sides[6] = {56, 57, 128, 129, 255, 257};
    uint64_t state = 38;
    double worst = 0;
    for (int s = 0; s < 6; s++) {
        setup u;
        const int side = sides[s], last = side - 1;
        speckled_map(&u, side, &state);
        for (int trial = 0; trial < test_trials(60); trial++) {
            const int any = (int)test_range(&state, 0, side),
                      other = (int)test_range(&state, 0, side);
            const int column = trial % 3 == 1 ? last : any, row = trial % 3 == 2 ? last : other;
            const double deep = 24.0 / side, half = test_range(&state, 0.5, 1.5);
            const double p[3] = {(column + 0.5) * 2 / side - 1, (row + 0.5) * 2 / side - 1, 0.75};
            for (int i = 0; i < side * side; i++) u.depth[i] = 1;
            u.depth[row * side + column] = (float)(p[2] - deep);
            CHECK(mssm_map_update(u.map, u.depth, NULL, 1) == MSSM_OK, "update");
            u.light.half_u = u.light.half_v = (float)(half / (0.5 * side * deep));
            const double most = 1 - 1 / (4 * half * half);
            worst = fmax(worst, visibility(&u, NULL, p) - most);
        }
        setup_free(&u);
    }
    test_note("at most %.4f lighter", worst);
    CHECK(worst < 0.02, "%.4f lighter than with the texel", worst);
}

const test_case estimators_tests[] = {
    {"the penumbra of a convex caster does not fall going outwards",
     penumbrae_only_brighten_outwards},
    {"ground that the light grazes is no caster", grazed_ground_is_no_caster},
    {"bars far below bars block once", bars_below_bars_block_once},
    {"light through a hole is not lost to the receiver's own surface",
     light_through_a_hole_is_not_lost},
    {"walls that light grazes are dark between boards", walls_between_boards_are_dark},
    {"columns that light grazes are told from shelves", columns_are_told_from_shelves},
    {"ground just below a hand is not the hand, with normals", ground_below_a_hand_is_not_the_hand},
    {"birds far above cost no shadows below", birds_cost_no_shadows_below},
    {"visibility does not pop as a light grows", growing_lights_do_not_pop},
    {"maps of both faces keep shadows on thick floors", both_faces_keep_shadows_on_thick_floors},
    {"maps of both faces leave tilted plates lit", both_faces_leave_tilted_plates_lit},
    {"maps of both faces keep shadows of low boxes", both_faces_keep_shadows_of_low_boxes},
    {"umbras stay dark under tall boxes and near planes close to the light, with every estimator",
     umbras_stay_dark_whatever_the_frustum},
    {"light comes through gaps between plates in tall boxes",
     light_comes_through_gaps_between_plates},
    {"near planes and masts cost no contact shadows",
     near_planes_and_masts_cost_no_contact_shadows},
    {"no light comes in past the rim of a cone or a cascade", no_light_comes_in_past_the_rim},
    {"a normal tells the receiver's own surface", normals_tell_the_receivers_own_surface},
    {"a normal closes contacts and leaves open ground lit", normals_close_contacts},
    {"a normal leaves of the light what is above the horizon",
     normals_leave_what_is_above_the_horizon},
    {"the horizon's cut does not pop", horizons_do_not_pop},
    {"only the direction of a normal counts, and none is as zero or NaN",
     only_the_direction_of_a_normal_counts},
    {"normals help points below their surface", normals_help_points_below_their_surface},
    {"many points are as one", many_points_are_as_one},
    {"what was on the stack does not matter", what_was_on_the_stack_does_not_matter},
    {"tolerance bounds the error of visibility", tolerance_bounds_the_error},
    {"points with a free cone are lit", points_with_a_free_cone_are_lit},
    {"no texel is missed", no_texel_is_missed},
    {0, 0}};
