// OpenGL's maps and visibility against the CPU's, and its picture against ray tracing.
#include "gl_subject.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// The shader has the same text.
static void level_holds_kernel(void)
{
    const float hostile[] = {0, -0.0f, -1, -INFINITY, 1e-40f, INFINITY, NAN, -NAN};
    for (int levels = 1; levels <= 11; levels++) {
        for (int k = 0; k < 12; k++) {
            const float most = ldexpf(27, k),
                        at[] = {nextafterf(most, 0), most, nextafterf(most, 1e9f)};
            for (int i = 0; i < 3; i++) {
                int level = 0;
                while (level < levels - 1 && ldexp(27, level) < (double)at[i]) level++;
                const int found = gl_fakes_level_of(at[i], levels);
                CHECK(found == level, "%a of %d levels: %d, not %d", (double)at[i], levels, found,
                      level);
            }
        }
        for (size_t i = 0; i < sizeof hostile / sizeof *hostile; i++) {
            const int found = gl_fakes_level_of(hostile[i], levels);
            CHECK(found == (hostile[i] > 27 ? levels - 1 : 0), "%g: %d", (double)hostile[i], found);
        }
    }
}

// ---- The CPU's numbers ------------------------------------------------------------------------

static void tables_are_equal(void)
{
    static const struct {
        int side, lights, samples, moments, back;
    } cases[] = {{256, 1, 4, 6, 0}, {100, 3, 4, 6, 1}, {300, 2, 1, 6, 0}, {1, 2, 4, 6, 0},
                 {27, 1, 1, 6, 1},  {28, 5, 4, 6, 0},  {300, 1, 4, 4, 1}, {2, 1, 1, 4, 0},
                 {55, 2, 4, 4, 0},  {109, 1, 1, 6, 0}};
    uint64_t seed = 21;
    difference all = {0, 0, 0};
    if (!begin_gl()) return;
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c += (size_t)stride()) {
        const int side = cases[c].side;
        const mssm_gl_desc d =
            description(cases[c].lights, side, cases[c].samples, cases[c].moments);
        subject s;
        difference here = {0, 0, 0};
        if (!make_subject(&s, &d)) continue;
        const int samples = s.desc.samples, count = side * side * samples;
        float *z = allocate(2 * sizeof *z * (size_t)count);
        for (int round = 0; round < 2; round++) { // the second over the first
            for (int i = 0; i < d.lights; i++) {
                s.light[i] = wide_light(false, 3); // asks for every level
                random_depth(z, side, samples, &seed);
                random_depth(z + count, side, samples, &seed);
                fill(&s, i, z, cases[c].back ? z + count : NULL);
            }
            build(&s);
        }
        int levels = 0, size;
        for (int i = 0; i < d.lights; i++) levels = compare_tables(&s, i, &here);
        CHECK(!gl_fakes_map_table(s.map[0], levels, &size), "side %d: only %d levels", side,
              levels);
        CHECK(here.unequal == 0 || slack(),
              "side %d, %d lights, %d samples, %d moments: %g of %g "
              "sums differ, texels by up to %d",
              side, d.lights, samples, d.moments, here.unequal, here.values, here.largest);
        CHECK(here.largest <= slack(), "side %d: a texel differs by %d", side, here.largest);
        all.values += here.values;
        all.unequal += here.unequal;
        all.largest = here.largest > all.largest ? here.largest : all.largest;
        free(z);
        drop_subject(&s);
    }
    test_note("%.0f sums, %.0f differ, a texel by at most %d", all.values, all.unequal,
              all.largest);
    end_gl();
}

// Linear depth is computed by the GPU in float: T6 changes 36 times as fast as depth does.
static void spot_depth_is_linear_per_sample(void)
{
    enum { SIDE = 100, SAMPLES = 4, COUNT = SIDE * SIDE * SAMPLES };
    const mssm_gl_desc d = description(2, SIDE, SAMPLES, 6);
    uint64_t seed = 22;
    subject s;
    difference all = {0, 0, 0};
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        float *z = allocate(2 * sizeof *z * COUNT);
        for (int i = 0; i < 2; i++) {
            s.light[i] = wide_light(true, 3);
            random_depth(z, SIDE, SAMPLES, &seed);
            random_depth(z + COUNT, SIDE, SAMPLES, &seed);
            fill(&s, i, z, i ? z + COUNT : NULL);
        }
        build(&s);
        for (int i = 0; i < 2; i++) compare_tables(&s, i, &all);
        test_note("a texel differs by at most %.2g of a value", all.largest / 2945788.0);
        CHECK(all.largest < 60, "%d units", all.largest);
        free(z);
        drop_subject(&s);
    }
    end_gl();
}

// However many samples the driver has, equal ones are one.
static void equal_samples_are_one(void)
{
    enum { SIDE = 40, COUNT = SIDE * SIDE };
    float z[COUNT];
    uint64_t seed = 23;
    if (!begin_gl()) return;
    for (int samples = 1; samples <= 4; samples += stride()) {
        const mssm_gl_desc d = description(1, SIDE, samples, 6);
        subject s;
        difference all = {0, 0, 0};
        if (!make_subject(&s, &d)) continue;
        s.light[0] = wide_light(false, 0.5f);
        random_depth(z, SIDE, 1, &seed);
        s.desc.samples = 1; // what there is to fill in
        fill(&s, 0, z, NULL);
        build(&s);
        compare_tables(&s, 0, &all);
        CHECK(all.largest <= 1 + slack(), "%d samples: a texel differs by %d", samples,
              all.largest);
        drop_subject(&s);
    }
    end_gl();
}

// Three lights over three scenes, the last one a spot.
static void fill_scenes(subject *s, scene scenes[3])
{
    static const int which[3] = {1, 6, 8};
    const size_t count = (size_t)(s->desc.side * s->desc.side * s->desc.samples);
    float *z = allocate(2 * count * sizeof *z);
    for (int i = 0; i < 3; i++) {
        scene_make(&scenes[i], which[i]);
        if (i == 2)
            s->light[i] = wide_light(true, 0.4f);
        else
            CHECK(scene_light(&scenes[i], i ? 0.3 : 0.1, i ? 0.2 : 0.1, &s->light[i]) == 0,
                  "light");
        scene_depth(&scenes[i], &s->light[i], s->desc.side, s->desc.samples, z, z + count);
        fill(s, i, z, i == 1 ? NULL : z + count);
    }
    build(s);
    free(z);
}

static void visibility_is_equal(void)
{
    static const char *const names[4] = {"layered", "lower blocker", "upper blocker", "horizon"};
    const int count = test_trials(20000);
    float *points = allocate(sizeof *points * 3 * (size_t)count);
    uint64_t seed = 24;
    if (!begin_gl()) {
        free(points);
        return;
    }
    for (int estimator = 0; estimator < 4; estimator += stride()) {
        for (int moments = 0; moments <= 6; moments += moments ? 2 : 4) {
            mssm_gl_desc d = description(3, 128, 4, moments == 4 ? 4 : 6);
            char what[60];
            subject s;
            scene scenes[3];
            agreement a = {0, 0, 0, 0, 0};
            d.settings.estimator = (mssm_estimator)estimator;
            d.settings.moments = moments;
            snprintf(what, sizeof what, "%s, %d moments", names[estimator], moments);
            if (!make_subject(&s, &d)) continue;
            fill_scenes(&s, scenes);
            for (int i = 0; i < 3; i++) {
                random_points(&scenes[i], count, points, &seed);
                compare_visibility(&s, i, what, count, points, &a);
            }
            test_note("%-24s rms %.1e, largest %.1e, at limits %.1e", what,
                      sqrt(a.squares / a.count), a.largest, a.largest_at_limit);
            CHECK(sqrt(a.squares / a.count) < 5e-4, "%s: rms %g", what, sqrt(a.squares / a.count));
            drop_subject(&s);
        }
    }
    free(points);
    end_gl();
}

// All members of mssm_settings take part, one at a time and all at once.
static void settings_are_obeyed(void)
{
    static const mssm_settings settings[] = {
        {0, MSSM_LAYERED, 1e-3f, 0, 0, 0}, {0, MSSM_LAYERED, 0, 0.05f, 0, 0},
        {0, MSSM_LAYERED, 0, 0, 9, 0},     {0, MSSM_LAYERED, 0, 0, 0, 0.1f},
        {4, MSSM_LAYERED, 0, 0, 0, 0},     {6, MSSM_UPPER_BLOCKER, 1e-4f, 0.02f, 33, 0.02f}};
    const int count = test_trials(4000);
    float *points = allocate(sizeof *points * 3 * (size_t)count);
    uint64_t seed = 25;
    if (begin_gl()) {
        for (size_t i = 0; i < sizeof settings / sizeof *settings; i += (size_t)stride()) {
            mssm_gl_desc d = description(3, 100, 1, 6);
            char what[60];
            subject s;
            scene scenes[3];
            agreement a = {0, 0, 0, 0, 0};
            d.settings = settings[i];
            snprintf(what, sizeof what, "settings %d", (int)i);
            if (!make_subject(&s, &d)) continue;
            fill_scenes(&s, scenes);
            for (int k = 0; k < 3; k++) {
                random_points(&scenes[k], count, points, &seed);
                compare_visibility(&s, k, what, count, points, &a);
            }
            test_note("%s: rms %.1e, largest %.1e, at limits %.1e", what, sqrt(a.squares / a.count),
                      a.largest, a.largest_at_limit);
            drop_subject(&s);
        }
        end_gl();
    }
    free(points);
}

// However far below the casters the ground is: kernels grow with the distance.
static void far_receivers_are_equal(void)
{
    enum { SIDE = 256, COUNT = SIDE * SIDE * 4, POINTS = 4000 };
    static float points[3 * POINTS];
    const mssm_gl_desc d = description(1, SIDE, 4, 6);
    uint64_t seed = 44;
    scene c;
    subject s;
    agreement a = {0, 0, 0, 0, 0};
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        float *z = allocate(sizeof *z * COUNT);
        scene_make(&c, 1);
        CHECK(!scene_light(&c, 0.05, 0.05, &s.light[0]), "light");
        scene_depth(&c, &s.light[0], SIDE, 4, z, NULL);
        fill(&s, 0, z, NULL);
        build(&s);
        for (int i = 0; i < POINTS; i++) {
            const double below = test_range(&seed, 0, i % 2 ? 20 : 200);
            for (int k = 0; k < 3; k++) {
                points[3 * i + k] = (float)(test_range(&seed, -2, 2) - below * c.sun[k]);
            }
        }
        compare_visibility(&s, 0, "far below", POINTS, points, &a);
        test_note("rms %.1e, largest %.1e, at limits %.1e", sqrt(a.squares / a.count), a.largest,
                  a.largest_at_limit);
        free(z);
        drop_subject(&s);
    }
    end_gl();
}

// mssm_visibility_at is mssm_visibility of a point that is in shadow space already.
static void shadow_space_is_the_same(void)
{
    enum { COUNT = 1000 };
    static float world[3 * COUNT], shadow[3 * COUNT], a[COUNT], b[COUNT];
    const mssm_gl_desc d = description(3, 64, 1, 6);
    uint64_t seed = 26;
    scene scenes[3];
    subject s;
    double worst = 0, squares = 0;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        fill_scenes(&s, scenes);
        for (int i = 0; i < 3; i++) {
            random_points(&scenes[i], COUNT, world, &seed);
            for (int k = 0; k < COUNT; k++) {
                float *q = shadow + 3 * k;
                if (!mssm_light_project(&s.light[i], world + 3 * k, q)) q[0] = 9;
            }
            ask(&s, i, false, COUNT, world, a);
            ask(&s, i, true, COUNT, shadow, b);
            for (int k = 0; k < COUNT; k++) {
                const double off = fabs((double)(a[k] - b[k]));
                worst = fmax(worst, off);
                squares += off * off / (3 * COUNT);
            }
        }
        test_note("rms %.1e, largest %.1e", sqrt(squares), worst);
        CHECK(sqrt(squares) < 1e-3, "rms %g", sqrt(squares));
        drop_subject(&s);
    }
    end_gl();
}

static void hostile_points_are_in_range(void)
{
    enum { COUNT = 4096 };
    static const float odd[] = {0, 1, -1, 1e30f, -1e30f, 3e38f, 1e-42f, INFINITY, -INFINITY, NAN};
    static float points[3 * COUNT], v[COUNT];
    uint64_t seed = 27;
    scene scenes[3];
    if (!begin_gl()) return;
    for (int estimator = 0; estimator < 3; estimator += stride()) {
        mssm_gl_desc d = description(3, 32, 1, 6);
        subject s;
        d.settings.estimator = (mssm_estimator)estimator;
        if (!make_subject(&s, &d)) continue;
        fill_scenes(&s, scenes);
        for (int i = 0; i < 3; i++) {
            for (int k = 0; k < 3 * COUNT; k++) {
                const uint64_t pick = test_random(&seed) % 20;
                points[k] = pick < 10 ? odd[pick] : (float)test_range(&seed, -3, 3);
            }
            ask(&s, i, i == 1, COUNT, points, v);
            for (int k = 0; k < COUNT; k++) {
                CHECK(v[k] >= 0 && v[k] <= 1, "%g at %g %g %g", (double)v[k], (double)points[3 * k],
                      (double)points[3 * k + 1], (double)points[3 * k + 2]);
            }
        }
        drop_subject(&s);
    }
    end_gl();
}

// A shader's loop may run on beyond the lights that there are.
static void lights_that_are_not_there_are_lit(void)
{
    enum { COUNT = 64 };
    static const int indices[] = {-1, 3, 4, 100000, INT_MAX, INT_MIN};
    static float points[3 * COUNT], v[COUNT];
    uint64_t seed = 28;
    scene scenes[3];
    subject s;
    const mssm_gl_desc d = description(3, 32, 1, 6);
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        fill_scenes(&s, scenes);
        for (int k = 0; k < 3 * COUNT; k++) points[k] = (float)test_range(&seed, -1, 1);
        for (int i = 0; i < 12; i++) {
            ask(&s, indices[i / 2], i % 2, COUNT, points, v);
            for (int k = 0; k < COUNT; k++)
                CHECK(v[k] == 1, "light %d: %g", indices[i / 2], (double)v[k]);
        }
        drop_subject(&s);
    }
    end_gl();
}

static void new_maps_are_lit(void)
{
    enum { COUNT = 500 };
    static float points[3 * COUNT], v[COUNT];
    const mssm_gl_desc d = description(2, 64, 4, 6);
    uint64_t seed = 28;
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        for (int k = 0; k < 3 * COUNT; k++) points[k] = (float)test_range(&seed, -4, 4);
        for (int pass = 0; pass < 3; pass++) { // new; with lights; built
            for (int i = 0; i < 2; i++) {
                s.light[i] = wide_light(i, 0.3f);
                if (pass == 1) CHECK(!mssm_gl_set_light(s.gl, i, &s.light[i]), "set light");
                if (pass == 2 && i == 0) build(&s);
                ask(&s, i, false, COUNT, points, v);
                for (int k = 0; k < COUNT; k++) {
                    CHECK(v[k] > 0.999f, "pass %d, light %d: %g", pass, i, (double)v[k]);
                }
            }
        }
        drop_subject(&s);
    }
    end_gl();
}

// ---- The picture against ray tracing ------------------------------------------------------------

// Errors of GL (meshes drawn), of the CPU (depth by ray tracing) against the truth, and of the one
// against the other; added to sums of squares.
static void measure_scene(subject *s, const scene *c, int receivers, uint64_t *seed, double sums[3])
{
    float *points = allocate(sizeof *points * 3 * (size_t)receivers);
    float *v = allocate(sizeof *v * (size_t)receivers);
    double *truth = allocate(sizeof *truth * (size_t)receivers);
    for (int i = 0; i < receivers; i++) {
        double p[3], normal[3];
        scene_receiver(c, seed, p, normal);
        for (int k = 0; k < 3; k++) points[3 * i + k] = (float)p[k];
        truth[i] = scene_visibility(c, &s->light[0], p, normal, 12, seed);
    }
    ask(s, 0, false, receivers, points, v);
    for (int i = 0; i < receivers; i++) {
        const double cpu =
            (double)mssm_map_visibility(s->map[0], &s->light[0], NULL, points + 3 * i);
        sums[0] += pow((double)v[i] - truth[i], 2) / receivers;
        sums[1] += pow(cpu - truth[i], 2) / receivers;
        sums[2] += pow((double)v[i] - cpu, 2) / receivers;
    }
    free(points);
    free(v);
    free(truth);
}

static void picture_agrees_with_ray_tracing(void)
{
    static const struct {
        int which, spot, back;
        double size;
    } cases[] = {{0, 0, 0, 0.05}, {0, 0, 1, 0.2}, {1, 0, 0, 0.2}, {2, 0, 1, 0.1}, {3, 0, 0, 0.2},
                 {6, 0, 0, 0.1},  {8, 1, 0, 0.3}, {0, 1, 1, 0.1}, {7, 1, 0, 0.6}, {4, 0, 0, 0.4}};
    enum { CASES = sizeof cases / sizeof *cases };
    enum { RECEIVERS = 300 };
    const int receivers = test_trials(RECEIVERS), side = receivers < 100 ? 64 : 256;
    double sums[3] = {0, 0, 0};
    uint64_t seed = 29;
    if (!begin_gl()) return;
    for (int asked = 1; asked <= 4; asked += 3 * stride()) {
        const mssm_gl_desc d = description(1, side, asked, 6);
        subject s;
        if (!make_subject(&s, &d)) continue;
        const int samples = s.desc.samples;
        const size_t count = (size_t)(side * side * samples);
        float *z = allocate(2 * count * sizeof *z);
        for (int i = 0; i < CASES; i += stride()) {
            scene c;
            mesh m;
            double here[3] = {0, 0, 0};
            scene_make(&c, cases[i].which);
            if (cases[i].spot)
                s.light[0] = wide_light(true, (float)cases[i].size);
            else
                CHECK(!scene_light(&c, cases[i].size, cases[i].size, &s.light[0]), "light");
            make_mesh(&m, &c);
            draw_light(&s, &m, cases[i].back);
            scene_depth(&c, &s.light[0], side, samples, z, z + count);
            CHECK(!mssm_map_update(s.map[0], z, cases[i].back ? z + count : NULL, samples),
                  "update");
            measure_scene(&s, &c, receivers, &seed, here);
            CHECK(receivers < RECEIVERS || here[0] < 1.2 * here[1] + 3e-4,
                  "%s%s%s, %d samples: rms %.4f, CPU %.4f", c.name, cases[i].spot ? ", spot" : "",
                  cases[i].back ? ", both faces" : "", asked, sqrt(here[0]), sqrt(here[1]));
            for (int k = 0; k < 3; k++) sums[k] += here[k] / (2 * CASES);
            drop_mesh(&m);
        }
        free(z);
        drop_subject(&s);
    }
    test_note("rms against ray tracing: GL %.4f, CPU %.4f; GL against CPU %.4f", sqrt(sums[0]),
              sqrt(sums[1]), sqrt(sums[2]));
    end_gl();
}

// ---- From frame to frame ----------------------------------------------------------------------

enum { FRAME_POINTS = 100 };

typedef struct motion {
    double squares, truth_squares, largest, step;
    int steps;
} motion;

// Adds the steps from before to now: of the estimate, and of the truth.
static void add_steps(motion *m, const float v[2][FRAME_POINTS], const double t[2][FRAME_POINTS])
{
    for (int i = 0; i < FRAME_POINTS; i++) {
        const double step = (double)v[1][i] - (double)v[0][i], truth = t[1][i] - t[0][i];
        m->squares += pow(step - truth, 2);
        m->truth_squares += truth * truth;
        m->largest = fmax(m->largest, fabs(step) - fabs(truth));
        m->step = fmax(m->step, fabs(truth));
        m->steps++;
    }
}

// One frame of a scene: the light is fitted, the casters are drawn, all points are asked.
static void make_frame(subject *s, const scene *c, const double points[][3], float v[FRAME_POINTS],
                       double truth[FRAME_POINTS])
{
    const double up[3] = {0, 1, 0};
    float world[3 * FRAME_POINTS];
    mesh m;
    uint64_t same = 12; // the truth's noise must not move
    CHECK(scene_light(c, 0.15, 0.15, &s->light[0]) == MSSM_OK, "light");
    make_mesh(&m, c);
    draw_light(s, &m, false);
    for (int i = 0; i < FRAME_POINTS; i++) {
        for (int k = 0; k < 3; k++) world[3 * i + k] = (float)points[i][k];
        truth[i] = scene_visibility(c, &s->light[0], points[i], up, 16, &same);
    }
    ask(s, 0, false, FRAME_POINTS, world, v);
    drop_mesh(&m);
}

static motion play(subject *s, int which, bool light_turns, int frames)
{
    static double points[FRAME_POINTS][3];
    motion m = {0, 0, 0, 0, 0};
    float v[2][FRAME_POINTS];
    double t[2][FRAME_POINTS];
    uint64_t seed = 31;
    scene c;
    scene_make(&c, which);
    for (int i = 0; i < FRAME_POINTS; i++) {
        points[i][0] = test_range(&seed, -1.5, 1.5);
        points[i][1] = 1e-4;
        points[i][2] = test_range(&seed, -1.5, 1.5);
    }
    const double sun[3] = {c.sun[0], c.sun[1], c.sun[2]};
    for (int frame = 0; frame < frames; frame++) {
        if (light_turns) {
            const double angle = frame * 0.25 * 0.0174532925199433;
            c.sun[0] = cos(angle) * sun[0] - sin(angle) * sun[1];
            c.sun[1] = sin(angle) * sun[0] + cos(angle) * sun[1];
        } else {
            c.shapes[0].centre[0] += 0.1 * 2 * (double)s->light[0].extent_u / s->desc.side;
        }
        scene_finish(&c);
        make_frame(s, &c, (const double(*)[3])points, v[1], t[1]);
        if (frame > 0)
            add_steps(&m, (const float(*)[FRAME_POINTS])v, (const double(*)[FRAME_POINTS])t);
        memcpy(v[0], v[1], sizeof v[0]);
        memcpy(t[0], t[1], sizeof t[0]);
    }
    return m;
}

static void visibility_does_not_flicker(void)
{
    static const int which[3] = {0, 6, 2};
    const int frames = test_trials(16) < 2 ? 2 : test_trials(16);
    const mssm_gl_desc d = description(1, 256, 4, 6);
    subject s;
    if (!begin_gl()) return;
    if (make_subject(&s, &d)) {
        s.light[0] = wide_light(false, 0.15f);
        for (int turns = 1; turns >= 0; turns--) {
            for (int i = 0; i < 3; i += stride()) {
                const motion m = play(&s, which[i], turns, frames);
                scene c;
                scene_make(&c, which[i]);
                test_note("%s, %s: rms step %.4f off the truth's %.4f, largest excess %.3f, the "
                          "truth's largest %.3f",
                          turns ? "light turns" : "caster moves", c.name, sqrt(m.squares / m.steps),
                          sqrt(m.truth_squares / m.steps), m.largest, m.step);
                // Not GL's but the estimator's: the CPU takes the same steps, with 16 samples, too.
                CHECK(m.largest < (turns ? 0.15 : 0.1),
                      "%s, %s: a step of %.3f more than the truth's",
                      turns ? "light turns" : "caster moves", c.name, m.largest);
            }
        }
        drop_subject(&s);
    }
    end_gl();
}

const test_case gl_numbers_tests[] = {
    {"levels: a kernel gets the first that holds it", level_holds_kernel},
    {"GL's tables are the CPU's, bit for bit", tables_are_equal},
    {"GL's spot lights have linear depth in every sample", spot_depth_is_linear_per_sample},
    {"GL's equal samples are one", equal_samples_are_one},
    {"GL's visibility is the CPU's", visibility_is_equal},
    {"GL's settings are obeyed", settings_are_obeyed},
    {"GL's receivers far behind all casters are the CPU's", far_receivers_are_equal},
    {"GL's visibility from shadow space is that from world space", shadow_space_is_the_same},
    {"GL's visibility of hostile points is in range", hostile_points_are_in_range},
    {"GL's new maps are lit", new_maps_are_lit},
    {"GL's lights that are not there are lit", lights_that_are_not_there_are_lit},
    {"GL's picture agrees with ray tracing as the CPU's does", picture_agrees_with_ray_tracing},
    {"GL's visibility does not flicker from frame to frame", visibility_does_not_flicker},
    {0, 0}};
