// What the estimators promise beyond closeness to rays: shadows that only brighten outwards, umbras that
// stay dark whatever the frustum, and what normals, many points and tolerances do.
#include "scenes.h"
#include "test.h"

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

// ---- frusta that reach far towards the light ---------------------------------------------------

// Below the middle of a plate that hides the whole light. In a box 512 times as tall as the plate is above
// the ground, and more, the moment bias (1.3e-6 and 7e-7 of the square of the range of depth) lets light through.
static void umbras_stay_dark_whatever_the_frustum(void)
{
    enum { TALL = 6, NEAR_PLANES = 7 };
    static const struct {
        float reach; // height of the box, or the near plane
        double limit6, limit4;
    } ways[TALL + NEAR_PLANES] = {{1, 0.01, 0.01},     {16, 0.01, 0.01},    {64, 0.01, 0.01},
                                  {128, 0.01, 0.01},   {256, 0.013, 0.035}, {1024, 0.18, 0.37},
                                  {3, 0.01, 0.01},     {1, 0.01, 0.01},     {0.3f, 0.01, 0.01},
                                  {0.1f, 0.01, 0.01},  {0.02f, 0.01, 0.01}, {0.01f, 0.01, 0.01},
                                  {0.001f, 0.01, 0.01}};
    const double at[3] = {0, 0, 0};
    for (int way = 0; way < TALL + NEAR_PLANES; way++) {
        setup u;
        memset(&u.scene, 0, sizeof u.scene);
        scene_add_box(&u.scene, 0, -0.05, 0, 9, 0.05, 9);
        scene_add_box(&u.scene, 0, 0.495, 0, 1, 0.005, 1);
        scene_finish(&u.scene);
        if (way < TALL)
            sun_above(&u, 0.2, 0, ways[way].reach, 2);
        else
            spot_above(&u, 4, 0.7f, ways[way].reach, 5, 0.3);
        setup_map(&u, 256, 1, 0);
        double lightest[2] = {0};
        for (int e = 0; e < 9; e++) {
            const mssm_settings s = {.moments = e / 3 ? e / 3 * 2 + 2 : 0,
                                     .estimator = (mssm_estimator)(e % 3)};
            const double v = visibility(&u, &s, at);
            double *most = &lightest[s.moments == 4];
            *most = fmax(*most, v);
            CHECK(v < (s.moments == 4 ? ways[way].limit4 : ways[way].limit6),
                  "%s %g, estimator %d, %d moments: %.4f", way < TALL ? "height" : "near plane",
                  (double)ways[way].reach, e % 3, s.moments, v);
        }
        if (lightest[1] > 0.005)
            test_note("%s %g: %.4f, with 4 moments %.4f", way < TALL ? "height" : "near plane",
                      (double)ways[way].reach, lightest[0], lightest[1]);
        setup_free(&u);
    }
}

// Root mean square error of receivers in a scene below its light.
static double rms(const setup *u, int receivers, uint64_t seed)
{
    double squares = 0;
    for (int i = 0; i < receivers; i++) {
        double point[3], normal[3];
        scene_receiver(&u->scene, &seed, point, normal);
        const double truth = scene_visibility(&u->scene, &u->light, point, normal, 12, &seed);
        squares += pow(visibility(u, NULL, point) - truth, 2);
    }
    return sqrt(squares / receivers);
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

// Neither what a frustum holds of empty space nor a thin mast in a corner costs contact shadows.
static void near_planes_and_masts_cost_no_contact_shadows(void)
{
    static const float nears[4] = {2, 0.5f, 0.2f, 0.01f};
    static const double masts[4] = {0, 3, 10, 40};
    const int receivers = test_trials(1500);
    for (int way = 0; way < 2; way++) {
        double error[4], best = 1;
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
            error[i] = rms(&u, receivers, 31);
            best = fmin(best, error[i]);
            setup_free(&u);
        }
        test_note("%s: rms %.4f %.4f %.4f %.4f",
                  way ? "masts of 0, 3, 10, 40" : "near planes 2, .5, .2, .01", error[0], error[1],
                  error[2], error[3]);
        for (int i = 0; i < 4 && receivers >= 100; i++) {
            CHECK(error[i] <= 0.035, "way %d, %d: rms %.4f", way, i, error[i]);
            CHECK(error[i] <= 1.2 * best, "way %d, %d: rms %.4f, best %.4f", way, i, error[i],
                  best);
        }
    }
}

// Below a sheet that goes on beyond the map, up to its rim: what the map holds there stands for the rest.
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

const test_case estimators_tests[] = {
    {"the penumbra of a convex caster does not fall going outwards",
     penumbrae_only_brighten_outwards},
    {"umbras stay dark under tall boxes and near planes close to the light, with every estimator",
     umbras_stay_dark_whatever_the_frustum},
    {"near planes and masts cost no contact shadows",
     near_planes_and_masts_cost_no_contact_shadows},
    {"no light comes in past the rim of a cone or a cascade", no_light_comes_in_past_the_rim},
    {0, 0}};
