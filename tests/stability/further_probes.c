// Light probes at their limits: lightprobe.h next to the paper's median cut (the header's own mode
// of it), and to sums that take texels as they are.
#include "further.h"

#include "../support/oracle_lightprobe.h"
#include "../support/families.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

enum { MOST_LIGHTS = 1024 };

typedef struct result {
    int failed, count, finite;
    double energy; // largest relative difference of a channel's lights + residual to the probe
    lightprobe_light lights[MOST_LIGHTS];
    lightprobe_stats stats;
} result;

static int light_is_finite(const lightprobe_light *l)
{
    double sum = 0;
    for (int c = 0; c < 3; c++) {
        sum += (double)l->direction[c] + (double)l->axis_u[c] + (double)l->axis_v[c] +
               (double)l->irradiance[c];
    }
    sum += (double)l->tan_half_u + (double)l->tan_half_v + (double)l->solid_angle +
           (double)l->cos_alpha;
    return sum - sum == 0;
}

static const result *extracted(const test_probe *p, int mode, int max_lights)
{
    static result r;
    const lightprobe_cube cube = test_probe_cube(p);
    lightprobe_settings set = {0};
    set.max_lights = max_lights;
    set.mode = mode;
    const size_t bytes = lightprobe_scratch_bytes(p->side, max_lights);
    void *scratch = malloc(bytes);
    if (!scratch) abort();
    r.count = 0;
    r.failed = lightprobe_extract(&cube, &set, scratch, bytes, r.lights, &r.count, &r.stats) != 0;
    free(scratch);
    r.finite = !r.failed;
    r.energy = 0;
    double total[3];
    oracle_total(p, total);
    for (int c = 0; c < 3; c++) {
        double sum = (double)r.stats.residual[c];
        for (int i = 0; i < r.count; i++) sum += (double)r.lights[i].irradiance[c];
        if (total[c] > 0) r.energy = fmax(r.energy, fabs(sum / total[c] - 1));
    }
    for (int i = 0; i < r.count; i++) r.finite = r.finite && light_is_finite(r.lights + i);
    return &r;
}

static void fill(test_probe *p, float value)
{
    for (int f = 0; f < 6; f++) {
        for (int i = 0; i < 3 * p->side * p->side; i++) p->face[f][i] = value;
    }
}

// Ours and the paper's way on the same probe with up to 32 lights.
static void compare(finding *f, const test_probe *p, double limit)
{
    const result *r = extracted(p, LIGHTPROBE_BEST, 32);
    say(f->ours, "%d lights, %s, energy off by %.1e", r->count,
        r->finite ? "all finite" : "NOT finite", r->energy);
    f->holds = !r->failed && r->finite && r->energy <= limit;
    r = extracted(p, LIGHTPROBE_MEDIAN_CUT, 32);
    say(f->others, "median cut: %d lights, %s, energy off by %.1e", r->count,
        r->finite ? "all finite" : "NOT finite", r->energy);
}

static void black(finding *f)
{
    test_probe p = test_probe_new(16);
    const result *r = extracted(&p, LIGHTPROBE_BEST, 32);
    say(f->what, "a black probe");
    say(f->ours, "%d lights, result %s", r->count, r->failed ? "error" : "OK");
    f->holds = !r->failed && r->count == 0;
    r = extracted(&p, LIGHTPROBE_MEDIAN_CUT, 32);
    say(f->others, "median cut: %d lights", r->count);
    test_probe_free(&p);
}

static void constant(finding *f)
{
    test_probe p = test_probe_new(16);
    say(f->what, "a constant probe");
    fill(&p, 0.7f);
    compare(f, &p, 1e-6);
    test_probe_free(&p);
}

static void hot_texel(finding *f)
{
    test_probe p = test_probe_new(33);
    say(f->what, "one texel a million times as bright as all others");
    fill(&p, 1e-6f);
    for (int c = 0; c < 3; c++) p.face[3][3 * (33 * 16 + 16) + c] = 1;
    compare(f, &p, 1e-6);
    test_probe_free(&p);
}

static void brightest(finding *f)
{
    test_probe p = test_probe_new(8);
    say(f->what, "every texel FLT_MAX: sums leave the range of float");
    fill(&p, FLT_MAX);
    const result *r = extracted(&p, LIGHTPROBE_BEST, 32);
    say(f->ours, "%d lights, %s", r->count,
        r->finite ? "all finite (sums are held at FLT_MAX)" : "NOT finite");
    f->holds = !r->failed && r->finite;
    float sum = 0;
    for (int i = 0; i < 6 * 64; i++)
        sum += FLT_MAX * lightprobe_texel_solid_angle(8, i % 8, i / 8 % 8);
    say(f->others, "a float32 sum is %s",
        sum - sum == 0 ? "finite" : "Inf, its weighted directions NaN");
    test_probe_free(&p);
}

// Bad channels count as 0: the lights are those of the probe with zeros there.
static void bad_texels(finding *f, float bad, const char *name)
{
    test_probe p = test_scene_probe(SCENE_SKY_SUN, 16);
    uint64_t state = 6;
    int there = 0;
    float sum = 0;
    for (int i = 0; i < 40; i++) {
        float *texel = p.face[family_random(&state) % 6] + 3 * (family_random(&state) % 256);
        there += texel[1] - texel[1] == 0 && texel[1] >= 0;
        texel[1] = bad;
    }
    for (int i = 0; i < 6 * 256; i++) sum += p.face[i / 256][3 * (i % 256) + 1];
    say(f->what, "40 texels of a sky are %s", name);
    const result *r = extracted(&p, LIGHTPROBE_BEST, 32);
    say(f->ours, "%d lights, %s, %d texels counted as repaired of %d", r->count,
        r->finite ? "all finite" : "NOT finite", r->stats.repaired_texels, there);
    f->holds = !r->failed && r->finite && r->stats.repaired_texels == there;
    say(f->others, "a sum that takes texels as they are gives %g", (double)sum);
    test_probe_free(&p);
}

static void negative(finding *f)
{
    bad_texels(f, -1e4f, "negative (-1e4)");
}

static void not_a_number(finding *f)
{
    bad_texels(f, NAN, "NaN");
}

static void infinite(finding *f)
{
    bad_texels(f, INFINITY, "Inf");
}

static double degrees_off(const lightprobe_light *l, const double d[3])
{
    double dot = 0;
    for (int i = 0; i < 3; i++) dot += (double)l->direction[i] * d[i];
    return acos(dot > 1 ? 1 : dot) * 180 / 3.14159265358979;
}

// A disc of 10 degrees: how many lights hold it, how far off is the brightest.
static void disc_at(finding *f, double x, double y, double z, const char *place)
{
    const double length = sqrt(x * x + y * y + z * z), d[3] = {x / length, y / length, z / length};
    test_probe p = test_disc_probe(64, d, 10 * 3.14159265358979 / 180, 0);
    const result *r = extracted(&p, LIGHTPROBE_BEST, 0);
    const double off = degrees_off(r->lights, d);
    say(f->what, "a disc of 10 degrees %s", place);
    say(f->ours, "%d light, %.3f degrees off", r->count, off);
    f->holds = !r->failed && r->count == 1 && off < 0.1;
    r = extracted(&p, LIGHTPROBE_MEDIAN_CUT, 6);
    double largest = 0, away = 0;
    int lit = 0;
    for (int i = 0; i < r->count; i++) {
        lit += r->lights[i].irradiance[1] > 0;
        if ((double)r->lights[i].irradiance[1] <= largest) continue;
        largest = (double)r->lights[i].irradiance[1];
        away = degrees_off(r->lights + i, d);
    }
    say(f->others, "median cut, one region a face: %d lights, the brightest %.1f degrees off", lit,
        away);
    test_probe_free(&p);
}

static void face_centre(finding *f)
{
    disc_at(f, 0, 0, 1, "in the middle of a face");
}

static void face_edge(finding *f)
{
    disc_at(f, 1, 0, 1, "on the edge of two faces");
}

static void face_corner(finding *f)
{
    disc_at(f, 1, 1, 1, "in the corner of three faces");
}

static void one_texel_faces(finding *f)
{
    test_probe p = test_probe_new(1);
    say(f->what, "faces of 1 x 1 texel, each of its own colour");
    for (int i = 0; i < 18; i++) p.face[i / 3][i % 3] = (float)(1 + i);
    compare(f, &p, 1e-6);
    test_probe_free(&p);
}

static void many_lights(finding *f)
{
    test_probe p = test_scene_probe(SCENE_NOISE, 32);
    double worst = 0, paper = 0;
    int bad = 0, short_of = 0, paper_short = 0;
    for (int n = 1; n <= MOST_LIGHTS; n = n < 8 ? n + 1 : n * 2) {
        const result *r = extracted(&p, LIGHTPROBE_BEST, n);
        worst = fmax(worst, r->energy);
        bad += r->failed || !r->finite || r->count > n;
        short_of += r->count < n;
        r = extracted(&p, LIGHTPROBE_MEDIAN_CUT, n);
        paper = fmax(paper, r->energy);
        paper_short += r->count < n;
    }
    say(f->what, "1 to 1024 lights of a probe of noise");
    say(f->ours, "energy off by at most %.1e; %d counts with fewer lights than asked for", worst,
        short_of);
    say(f->others, "median cut: %.1e; %d counts with fewer lights than asked for", paper,
        paper_short);
    f->holds = !bad && worst < 1e-6 && short_of == 0;
    test_probe_free(&p);
}

const further further_probes[] = {{"probe-black", black},
                                  {"probe-constant", constant},
                                  {"probe-hot-texel", hot_texel},
                                  {"probe-flt-max", brightest},
                                  {"probe-negative", negative},
                                  {"probe-nan", not_a_number},
                                  {"probe-inf", infinite},
                                  {"probe-face", face_centre},
                                  {"probe-edge", face_edge},
                                  {"probe-corner", face_corner},
                                  {"probe-1x1", one_texel_faces},
                                  {"probe-lights", many_lights},
                                  {0, 0}};
