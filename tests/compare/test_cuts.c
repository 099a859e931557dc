// The rivals of lightprobe_extract: greedy rectangles and variance minimization.
#include "light_cuts.h"
#include "../figures/median_cut.h"
#include "../support/oracle_lightprobe.h"
#include "../support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 64 };

typedef struct cut_lights {
    lightprobe_light light[MOST];
    light_cut cut[MOST];
    int count;
} cut_lights;

enum { GREEDY, VARIANCE, WAYS };
static const char *const way_names[WAYS] = {"greedy rectangles", "variance cuts"};

static void find(cut_lights *l, int way, const test_probe *p, int most)
{
    const lightprobe_cube cube = test_probe_cube(p);
    memset(l, 0, sizeof *l);
    l->count = way == VARIANCE ? light_cuts_variance(&cube, most, l->light, l->cut)
                               : light_cuts_greedy(&cube, light_cuts_threshold(&cube, most), most,
                                                   l->light, l->cut);
}

static double angle_between_lights(const lightprobe_light *a, const lightprobe_light *b)
{
    double squared = 0;
    for (int k = 0; k < 3; k++)
        squared += pow((double)a->direction[k] - (double)b->direction[k], 2);
    return sqrt(squared) * 180 / 3.14159265358979;
}

static int within(const light_cut *k, int face, int x, int y)
{
    return face == k->face && x >= k->x0 && x < k->x1 && y >= k->y0 && y < k->y1;
}

static void check_energy(const test_probe *p, const cut_lights *l, const char *where)
{
    double total[3];
    oracle_total(p, total);
    for (int c = 0; c < 3; c++) {
        double sum = 0;
        for (int i = 0; i < l->count; i++) sum += (double)l->light[i].irradiance[c];
        CHECK(fabs(sum - total[c]) <= 2e-6 * total[c], "%s: channel %d has %g of %g", where, c, sum,
              total[c]);
    }
}

static void lights_hold_the_probes_energy(void)
{
    for (int scene = 0; scene < SCENE_COUNT; scene++) {
        test_probe p = test_scene_probe((test_scene)scene, 24);
        for (int way = 0; way < WAYS; way++) {
            for (int most = 8; most <= MOST; most *= 2) {
                cut_lights l;
                char where[96];
                find(&l, way, &p, most);
                snprintf(where, sizeof where, "%s, %s, %d", test_scene_names[scene], way_names[way],
                         most);
                CHECK(l.count > 0 && l.count <= most, "%s: %d lights", where, l.count);
                check_energy(&p, &l, where);
            }
        }
        test_probe_free(&p);
    }
}

// With fewer lights than faces something has to be left out; the brightest stay.
static void few_lights_are_the_brightest(void)
{
    test_probe p = test_scene_probe(SCENE_SKY_SUN, 16);
    for (int way = 0; way < WAYS; way++) {
        cut_lights few, all;
        find(&all, way, &p, 6);
        find(&few, way, &p, 4);
        CHECK(all.count == 6 && few.count == 4, "%s: %d and %d", way_names[way], all.count,
              few.count);
        CHECK(!memcmp(few.light, all.light, 4 * sizeof *few.light), "%s: others", way_names[way]);
    }
    test_probe_free(&p);
}

// Variance cuts cover every texel once. Greedy rectangles may overlap, but leave no lit texel out.
static void texels_belong_to_rectangles(void)
{
    enum { SIDE = 20 };
    for (int scene = 0; scene < SCENE_COUNT; scene++) {
        test_probe p = test_scene_probe((test_scene)scene, SIDE);
        for (int way = 0; way < WAYS; way++) {
            cut_lights l;
            int wrong = 0;
            find(&l, way, &p, 32);
            for (int i = 0; i < 6 * SIDE * SIDE; i++) {
                const int face = i / (SIDE * SIDE), x = i % SIDE, y = i / SIDE % SIDE;
                const float *rgb = p.face[face] + 3 * (y * SIDE + x);
                int times = 0;
                for (int k = 0; k < l.count; k++) times += within(&l.cut[k], face, x, y);
                if (rgb[0] + rgb[1] + rgb[2] <= 0) continue;
                wrong += way == VARIANCE ? times != 1 : times < 1;
            }
            CHECK(wrong == 0, "%s, %s: %d texels", test_scene_names[scene], way_names[way], wrong);
        }
        test_probe_free(&p);
    }
}

// An even probe: six faces, then variance cuts of even size, whose points share the light evenly.
static void constant_probe_is_cut_evenly(void)
{
    test_probe p = test_probe_new(16);
    cut_lights l;
    for (int face = 0; face < 6; face++)
        for (int i = 0; i < 3 * 16 * 16; i++) p.face[face][i] = 2;
    for (int way = 0; way < WAYS; way++) {
        find(&l, way, &p, 6);
        CHECK(l.count == 6, "%s: %d lights", way_names[way], l.count);
        for (int i = 0; i < l.count; i++) {
            const lightprobe_light *k = &l.light[i];
            const float half = way == GREEDY ? 1 : 0;
            float longest = 0;
            for (int c = 0; c < 3; c++) longest = fmaxf(longest, fabsf(k->direction[c]));
            CHECK(fabsf(k->irradiance[1] - 4.1887902f) < 1e-5f, "irradiance %g",
                  (double)k->irradiance[1]);
            CHECK(fabsf(k->solid_angle - 2.0943951f) < 1e-5f, "size %g", (double)k->solid_angle);
            CHECK(longest > 0.99999f, "a face's middle is at %g", (double)longest);
            CHECK(fabsf(k->tan_half_u - half) < 1e-5f && fabsf(k->tan_half_v - half) < 1e-5f,
                  "%s: %g x %g", way_names[way], (double)k->tan_half_u, (double)k->tan_half_v);
        }
    }
    find(&l, VARIANCE, &p, 24);
    for (int i = 0; i < l.count; i++) {
        const float share = l.light[i].irradiance[0] / (2 * 12.566371f / 24);
        CHECK(share > 0.7f && share < 1.4f, "light %d has %g of its share", i, (double)share);
    }
    test_probe_free(&p);
}

static void one_hot_texel_gets_its_own_light(void)
{
    test_probe p = test_probe_new(16);
    double d[3];
    for (int face = 0; face < 6; face++)
        for (int i = 0; i < 3 * 16 * 16; i++) p.face[face][i] = 0.01f;
    for (int c = 0; c < 3; c++) p.face[2][3 * (5 * 16 + 11) + c] = 1000;
    oracle_direction(2, -1 + 2 * 11.5 / 16, -1 + 2 * 5.5 / 16, d);
    for (int way = 0; way < WAYS; way++) {
        cut_lights l;
        find(&l, way, &p, 16);
        const light_cut *k = &l.cut[0]; // the brightest
        double off = 0;
        for (int c = 0; c < 3; c++) off += fabs(d[c] - (double)l.light[0].direction[c]);
        CHECK(within(k, 2, 11, 5), "%s: the brightest light is elsewhere", way_names[way]);
        if (way == GREEDY)
            CHECK(k->x1 - k->x0 == 1 && k->y1 - k->y0 == 1, "%d x %d texels", k->x1 - k->x0,
                  k->y1 - k->y0);
        CHECK(off < 1e-4, "%s: direction off by %g", way_names[way], off);
        check_energy(&p, &l, way_names[way]);
    }
    test_probe_free(&p);
}

// Each cut lowers the sum it minimizes, so more lights never have more of it; counted from the
// texels.
static double variance_left(const test_probe *p, const cut_lights *l)
{
    double sum = 0;
    for (int i = 0; i < 6 * p->side * p->side; i++) {
        const int face = i / (p->side * p->side), x = i % p->side, y = i / p->side % p->side;
        const float *rgb = p->face[face] + 3 * (y * p->side + x);
        const double omega = (double)oracle_solid_angle(p->side, x, y);
        double d[3];
        oracle_direction(face, -1 + (2 * x + 1.0) / p->side, -1 + (2 * y + 1.0) / p->side, d);
        for (int k = 0; k < l->count; k++) {
            double off = 0;
            if (!within(&l->cut[k], face, x, y)) continue;
            for (int c = 0; c < 3; c++) off += pow(d[c] - (double)l->light[k].direction[c], 2);
            sum += off * omega *
                   (0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2]);
        }
    }
    return sum;
}

static void variance_falls_with_every_cut(void)
{
    for (int scene = 0; scene < SCENE_COUNT; scene++) {
        test_probe p = test_scene_probe((test_scene)scene, 16);
        double before = HUGE_VAL;
        for (int most = 6; most <= 48; most += 6) {
            cut_lights l;
            find(&l, VARIANCE, &p, most);
            const double left = variance_left(&p, &l);
            CHECK(left <= before * 1.0001, "%s: %g, then %g with %d lights",
                  test_scene_names[scene], before, left, most);
            before = left;
        }
        test_probe_free(&p);
    }
}

static void cuts_are_deterministic(void)
{
    test_probe p = test_scene_probe(SCENE_LAMPS, 24);
    for (int way = 0; way < WAYS; way++) {
        cut_lights a, b;
        find(&a, way, &p, 32);
        find(&b, way, &p, 32);
        CHECK(!memcmp(&a, &b, sizeof a), "%s differ", way_names[way]);
    }
    test_probe_free(&p);
}

static void black_probe_has_no_cuts(void)
{
    test_probe p = test_probe_new(8);
    for (int way = 0; way < WAYS; way++) {
        cut_lights l;
        find(&l, way, &p, 16);
        CHECK(l.count == 0, "%s: %d lights", way_names[way], l.count);
    }
    test_probe_free(&p);
}

// The paper's way in tables, which make figures takes the time of, against lightprobe.h's own: in
// full rounds it does not matter which region is first.
static void tables_find_the_median_cut(void)
{
    enum { SIDE = 64, LIGHTS = 96 };
    static light_cut cuts[LIGHTS];
    static lightprobe_light lights[LIGHTS], own[LIGHTS];
    const lightprobe_settings settings = {.max_lights = LIGHTS, .mode = LIGHTPROBE_MEDIAN_CUT};
    test_probe p = test_probe_new(SIDE);
    uint64_t state = 96;
    for (int i = 0; i < 6 * 3 * SIDE * SIDE; i++) // smooth, with a bright corner
        p.face[i / (3 * SIDE * SIDE)][i % (3 * SIDE * SIDE)] =
            (float)(0.2 + 0.1 * test_uniform(&state) + (i % (3 * SIDE * SIDE) < 900 ? 3 : 0));
    const lightprobe_cube cube = test_probe_cube(&p);
    const size_t bytes = lightprobe_scratch_bytes(SIDE, LIGHTS);
    void *scratch = malloc(bytes);
    median_cut m;
    int found = 0, elsewhere = 0;
    CHECK(median_cut_create(&m, SIDE) && scratch, "no memory");
    median_cut_sums(&m, &cube);
    const int count = median_cut_cuts(&m, LIGHTS, cuts);
    median_cut_lights(&m, cuts, count, lights);
    CHECK(!lightprobe_extract(&cube, &settings, scratch, bytes, own, &found, NULL), "no lights");
    CHECK(count == LIGHTS && found == LIGHTS, "%d and %d lights", count, found);
    double sum[2] = {0, 0}, worst = 0;
    for (int i = 0; i < count; i++) {
        int near = 0;
        for (int k = 1; k < found; k++)
            if (angle_between_lights(&lights[i], &own[k]) <
                angle_between_lights(&lights[i], &own[near]))
                near = k;
        const double off = fabs((double)lights[i].tan_half_u / (double)own[near].tan_half_u - 1);
        if (angle_between_lights(&lights[i], &own[near]) > 0.2) {
            elsewhere++;
        } else {
            worst = fmax(worst, off);
        }
        sum[0] += (double)lights[i].irradiance[1];
        sum[1] += (double)own[i].irradiance[1];
    }
    CHECK(fabs(sum[0] / sum[1] - 1) < 1e-3, "they carry %g of %g", sum[0], sum[1]);
    CHECK(elsewhere == 0, "%d lights are elsewhere", elsewhere);
    CHECK(worst < 1e-3, "half-sizes differ by %g", worst);
    test_note("%d of %d lights elsewhere, half-sizes within %.1e", elsewhere, LIGHTS, worst);
    median_cut_free(&m);
    free(scratch);
    test_probe_free(&p);
}

const test_case cuts_tests[] = {
    {"cuts: the paper's tables find the lights of LIGHTPROBE_MEDIAN_CUT",
     tables_find_the_median_cut},
    {"cuts: lights hold the probe's energy", lights_hold_the_probes_energy},
    {"cuts: few lights are the brightest", few_lights_are_the_brightest},
    {"cuts: every lit texel belongs to a rectangle, of variance cuts to one",
     texels_belong_to_rectangles},
    {"cuts: a constant probe is cut evenly", constant_probe_is_cut_evenly},
    {"cuts: one hot texel gets its own light", one_hot_texel_gets_its_own_light},
    {"cuts: the variance falls with every cut", variance_falls_with_every_cut},
    {"cuts: the same probe, the same cuts", cuts_are_deterministic},
    {"cuts: a black probe has none", black_probe_has_no_cuts},
    {0, 0},
};
