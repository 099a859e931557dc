// Lights of a probe: error against their number for this library, the paper's median cut, point
// lights, greedy rectangles and variance minimization; and the time of a whole picture.
#include "light_cuts.h"
#include "measure.h"

#include "../../examples/common/lighting.h"
#include "../../examples/common/threads.h"
#include "../support/oracle_lightprobe.h"
#include "../support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_LIGHTS = 64, POINTS = 300, KINDS = 5 };
static const char *const kind_names[KINDS] = {"largest error first", "median cut", "point lights",
                                              "greedy rectangles", "variance cuts"};
enum { LARGEST_ERROR, MEDIAN_CUT, POINT_LIGHTS, GREEDY, VARIANCE };

// Surface points of the demo's scene and what the probe sheds on them.
typedef struct surface_point {
    receiver r;
    double irradiance[2]; // luminance, by two independent sets of rays
} surface_point;

// Everything that belongs to one probe.
typedef struct study {
    measurement *m;
    char name[FIGURE_NAME];
    probe p;
    probe_sampler sampler;
    const scene *s;
    const bvh *tree;
    surface_point point[POINTS];
    int points, rays;
    double mean;
    oracle_irradiance truth; // unoccluded
    oracle_edges edges;      // near what is bright
} study;

// ---- Truth ---------------------------------------------------------------------------------

static void trace_point(void *context, int index)
{
    study *s = context;
    surface_point *p = &s->point[index];
    const vec3 from = vec_mad(p->r.point, p->r.normal, 2e-3f);
    for (int k = 0; k < 2; k++) {
        const vec3 rgb = trace_irradiance(s->tree, &s->sampler, from, p->r.normal, s->rays,
                                          (unsigned)(2 * index + k + 1));
        p->irradiance[k] = (double)vec_luminance(rgb);
    }
}

static double truth_of(const surface_point *p)
{
    return 0.5 * (p->irradiance[0] + p->irradiance[1]);
}

// Points on the scene's upper surfaces, drawn as for a light at the zenith.
static bool draw_points(study *s, const compare_case *c, message *why)
{
    static receiver r[POINTS];
    mssm_light zenith;
    s->points = s->m->quick ? POINTS / 4 : POINTS;
    s->rays = s->m->quick ? 1024 : 4096;
    if (case_light(c, 0.01f, 0.01f, &zenith) || !case_receivers(c, &zenith, s->points, 4, 21, r)) {
        return fail(why, "no points on the demo's scene");
    }
    for (int i = 0; i < s->points; i++) s->point[i].r = r[i];
    parallel_for(s->points, trace_point, s, NULL);
    double noise = 0;
    s->mean = 0;
    for (int i = 0; i < s->points; i++) {
        const double d = 0.5 * (s->point[i].irradiance[0] - s->point[i].irradiance[1]);
        noise += d * d / s->points;
        s->mean += truth_of(&s->point[i]) / s->points;
    }
    noise = 100 * sqrt(noise) / s->mean;
    put(s->m, "truth", s->name, "lights", 0, "noise", noise, noise, noise);
    return true;
}

// ---- Lights --------------------------------------------------------------------------------

static bool open_lighting(lighting *l, const study *s, int count, int mode, float tolerance,
                          message *why)
{
    lighting_settings settings;
    memset(&settings, 0, sizeof settings);
    settings.probe.max_lights = count;
    settings.probe.mode = mode;
    settings.probe.tolerance = tolerance;
    settings.shadows.estimator = MSSM_HORIZON;
    settings.map_side = 256;
    settings.map_samples = 4;
    return lighting_create(l, &settings, s->p.side, why);
}

// Turns the lights of the median cut into points: no size, and the whole energy along one
// direction.
static void shrink(lighting *l)
{
    for (int i = 0; i < l->lights; i++) {
        l->light[i].tan_half_u = l->light[i].tan_half_v = 0;
        l->light[i].cos_alpha = 1;
    }
}

// What a surface gets per unit of irradiance when nothing is in between: the clipped disc for ours,
// Eq. 18 for median cut; the others go by the cosine to one direction, which is a disc without a
// size.
static float share_of(const lightprobe_light *light, vec3 normal, int kind)
{
    const float cosine = vec_dot(vec_of(light->direction), normal);
    if (kind == LARGEST_ERROR) return lightprobe_disc_irradiance(light->cos_alpha, cosine);
    return cosine > 0 ? 0.5f * (1 + light->cos_alpha) * cosine : 0;
}

// Irradiance that is clipped at the horizon goes with the visibility of the part above it. The
// others are not clipped: the visibility of the whole light, which the ground hides in part, is
// better for them.
static double shade(const lighting *l, const surface_point *p, int kind)
{
    const float at[3] = {p->r.point.x, p->r.point.y, p->r.point.z};
    const float normal[3] = {p->r.normal.x, p->r.normal.y, p->r.normal.z};
    const mssm_settings whole = {0, MSSM_LAYERED, 0, 0, 0, 0};
    const mssm_settings *how = kind == LARGEST_ERROR ? &l->settings.shadows : &whole;
    double sum = 0;
    for (int i = 0; i < l->lights; i++) {
        const float share = share_of(&l->light[i], p->r.normal, kind);
        if (share <= 0) continue;
        const float seen = mssm_map_visibility_normal(l->map[i], &l->frustum[i], how, at, normal);
        sum += (double)(seen * share * vec_luminance(vec_of(l->light[i].irradiance)));
    }
    if (kind == LARGEST_ERROR) {
        float rest[3];
        lightprobe_residual_irradiance(&l->stats, normal, rest);
        sum += (double)vec_luminance(vec_of(rest));
    }
    return sum;
}

// Error of the picture in % of its mean; nanoseconds a point on one core.
static double picture_error(const study *s, const lighting *l, int kind, spread *ns)
{
    enum { ROUNDS = 3 };
    double squares = 0, times[ROUNDS];
    for (int round = 0; round < ROUNDS; round++) {
        const double start = cpu_seconds();
        squares = 0;
        for (int i = 0; i < s->points; i++) {
            const double d = shade(l, &s->point[i], kind) - truth_of(&s->point[i]);
            squares += d * d;
        }
        times[round] = 1e9 * (cpu_seconds() - start) / s->points;
    }
    *ns = spread_of(times, ROUNDS);
    return 100 * sqrt(squares / s->points) / s->mean;
}

static lightprobe_cube cube_of(const study *s)
{
    lightprobe_cube cube = {{NULL}, s->p.side, 3};
    for (int f = 0; f < 6; f++) cube.face[f] = s->p.face[f];
    return cube;
}

static void put_lights(const study *s, int kind, int count, const char *metric, double value)
{
    put(s->m, "lights", s->name, kind_names[kind], count, metric, value, value, value);
}

// By the rivals that are not in the library. The search for the threshold is not part of their
// time.
static bool extract_cuts(lighting *l, const study *s, int kind, float threshold, message *why)
{
    light_cut cuts[MOST_LIGHTS];
    const lightprobe_cube cube = cube_of(s);
    const int most = l->settings.probe.max_lights;
    const double start = seconds_now();
    l->lights = kind == GREEDY ? light_cuts_greedy(&cube, threshold, most, l->light, cuts)
                               : light_cuts_variance(&cube, most, l->light, cuts);
    l->extract_seconds = seconds_now() - start;
    return l->lights || fail(why, "no %s", kind_names[kind]);
}

static bool extract(lighting *l, const study *s, int kind, spread *ms, message *why)
{
    enum { ROUNDS = 9 };
    double times[ROUNDS];
    bool done = true;
    const lightprobe_cube cube = cube_of(s);
    const int most = l->settings.probe.max_lights;
    const float threshold = kind == GREEDY ? light_cuts_threshold(&cube, most) : 0;
    for (int round = 0; round < ROUNDS && done; round++) {
        l->lights = 0; // start afresh, as for a first frame
        done = kind >= GREEDY ? extract_cuts(l, s, kind, threshold, why)
                              : lighting_extract(l, &s->p, why);
        times[round] = 1e3 * l->extract_seconds;
    }
    if (kind == POINT_LIGHTS) shrink(l);
    *ms = spread_of(times, ROUNDS);
    return done;
}

// Error behind edges in % of the mean.
static void put_edges(const study *s, const char *experiment, const char *name, double x,
                      const lighting *l, int paper)
{
    const double e = 100 * oracle_edge_error(&s->edges, l->light, l->lights, paper, &l->stats);
    put(s->m, experiment, s->name, name, x, "blocked_rms", e, e, e);
}

// What most engines do: the light with the highest radiance has a map, all else is ambient light of
// nine harmonics.
static bool study_one_sun(const study *s, message *why)
{
    lighting l;
    spread ms;
    int sun = 0;
    if (!open_lighting(&l, s, MOST_LIGHTS, LIGHTPROBE_BEST, 0, why)) return false;
    const bool done = extract(&l, s, LARGEST_ERROR, &ms, why);
    float *sh = l.stats.residual_sh[0];
    for (int i = 1; i < l.lights && done; i++)
        if (l.light[i].irradiance[1] * l.light[sun].solid_angle >
            l.light[sun].irradiance[1] * l.light[i].solid_angle)
            sun = i;
    for (int i = 0; i < l.lights && done; i++) {
        const float *d = l.light[i].direction, c = l.light[i].cos_alpha, h = 0.5f * (1 + c);
        const float a = 0.5f * h, b = 0.15625f * c * h;
        const float weight[9] = {0.25f,
                                 a * d[1],
                                 a * d[2],
                                 a * d[0],
                                 6 * b * d[0] * d[1],
                                 6 * b * d[1] * d[2],
                                 0.5f * b * (3 * d[2] * d[2] - 1),
                                 6 * b * d[2] * d[0],
                                 1.5f * b * (d[0] * d[0] - d[1] * d[1])};
        for (int k = 0; k < 27 && i != sun; k++)
            sh[k] += weight[k / 3] * l.light[i].irradiance[k % 3];
    }
    l.light[0] = l.light[sun];
    l.lights = done ? 1 : 0;
    if (done) put_edges(s, "edges", "one sun and ambient", 1, &l, 0);
    lighting_free(&l);
    return done;
}

// Lights whose shadows are too weak are left to the residual.
static bool study_weak(const study *s, message *why)
{
    static const float least[] = {0, 0.02f, 0.05f, 0.1f};
    bool done = true;
    for (size_t k = 0; k < sizeof least / sizeof *least && done; k++) {
        lighting l;
        spread ms, ns;
        if (!open_lighting(&l, s, 32, LIGHTPROBE_BEST, 0, why)) return false;
        l.settings.probe.min_shadow = least[k];
        done = extract(&l, s, LARGEST_ERROR, &ms, why) && lighting_draw_maps(&l, s->s, why);
        if (done) {
            const double x = (double)least[k], rms = picture_error(s, &l, LARGEST_ERROR, &ns),
                         n = l.lights;
            put_edges(s, "weak", "min_shadow", x, &l, 0);
            put(s->m, "weak", s->name, "min_shadow", x, "picture_rms", rms, rms, rms);
            put(s->m, "weak", s->name, "min_shadow", x, "maps", n, n, n);
        }
        lighting_free(&l);
    }
    return done;
}

static bool study_count(const study *s, int kind, int count, message *why)
{
    static oracle_irradiance by_lights;
    lighting l;
    spread ms, ns;
    const int mode = kind == LARGEST_ERROR ? LIGHTPROBE_BEST : LIGHTPROBE_MEDIAN_CUT;
    if (!open_lighting(&l, s, count, mode, 0, why)) return false;
    const bool done = extract(&l, s, kind, &ms, why) && lighting_draw_maps(&l, s->s, why);
    if (done) {
        put_edges(s, "edges", kind_names[kind], count, &l, kind != LARGEST_ERROR);
        oracle_irradiance_of_lights(l.light, l.lights, kind != LARGEST_ERROR, &by_lights);
        put_lights(s, kind, count, "irradiance_rms", oracle_error(&s->truth, &by_lights));
        put_lights(s, kind, count, "picture_rms", picture_error(s, &l, kind, &ns));
        put_lights(s, kind, count, "found", l.lights);
        put(s->m, "lights", s->name, kind_names[kind], count, "ms", ms.value, ms.low, ms.high);
    }
    lighting_free(&l);
    return done;
}

// As many lights as a tolerance asks for, next to all 64.
static bool study_tolerance(const study *s, message *why)
{
    static const struct {
        const char *name;
        float tolerance;
    } rows[] = {{"64 lights", 0},
                {"tolerance 0.01", 0.01f},
                {"tolerance 0.02", 0.02f},
                {"tolerance 0.05", 0.05f}};
    bool done = true;
    for (size_t k = 0; k < sizeof rows / sizeof *rows && done; k++) {
        const double x = (double)rows[k].tolerance;
        lighting l;
        spread ms, ns;
        if (!open_lighting(&l, s, MOST_LIGHTS, LIGHTPROBE_BEST, rows[k].tolerance, why))
            return false;
        done = extract(&l, s, LARGEST_ERROR, &ms, why) && lighting_draw_maps(&l, s->s, why);
        if (done) {
            const double rms = picture_error(s, &l, LARGEST_ERROR, &ns), n = l.lights;
            const char *name = rows[k].name;
            put(s->m, "tolerance", s->name, name, x, "picture_rms", rms, rms, rms);
            put(s->m, "tolerance", s->name, name, x, "shade_ns", ns.value, ns.low, ns.high);
            put(s->m, "tolerance", s->name, name, x, "lights", n, n, n);
        }
        lighting_free(&l);
    }
    return done;
}

// The oracle takes the same texels.
static void unoccluded_truth(study *s)
{
    test_probe p;
    p.side = s->p.side;
    for (int face = 0; face < 6; face++)
        p.face[face] = s->p.texels + (size_t)face * (size_t)(3 * s->p.side * s->p.side);
    oracle_irradiance_of_probe(&p, &s->truth);
    oracle_edges_near_light(&p, s->m->quick ? 400 : 1200, 12345, &s->edges);
}

static bool study_probe(study *s, const compare_case *c, message *why)
{
    static const int counts[] = {4, 8, 16, 32, 64};
    bool done = probe_sampler_create(&s->sampler, &s->p);
    if (!done) return fail(why, "no memory for rays");
    say("  %s", s->name);
    unoccluded_truth(s);
    done = draw_points(s, c, why);
    for (size_t k = 0; k < sizeof counts / sizeof *counts && done; k++) {
        for (int kind = 0; kind < KINDS && done; kind++)
            done = study_count(s, kind, counts[k], why);
    }
    done = done && study_one_sun(s, why) && study_weak(s, why) && study_tolerance(s, why);
    probe_sampler_free(&s->sampler);
    return done;
}

// Probe number which: the built-in one, then the shared ones; with --probe that file alone.
enum { PROBES = 4 };
static bool open_probe(study *s, int which, message *why)
{
    static const char *const shared[PROBES] = {NULL, "interior_128", "city_sun_128",
                                               "overcast_128"};
    const measurement *m = s->m;
    char path[1024];
    if (m->probe) {
        const char *slash = strrchr(m->probe, '/'), *name = slash ? slash + 1 : m->probe;
        snprintf(s->name, sizeof s->name, "%.*s", (int)strcspn(name, "."), name);
        return probe_load(&s->p, m->probe, 0, why);
    }
    snprintf(s->name, sizeof s->name, "%s", which ? shared[which] : "built-in probe");
    if (!which) return probe_default(&s->p, PROBE_DEFAULT_SIDE) || fail(why, "no memory");
    const char *folder = m->data ? m->data : getenv("SHARED_DATA");
    snprintf(path, sizeof path, "%s/probes/%s.pfm", folder ? folder : "../shared/data",
             shared[which]);
    return probe_load(&s->p, path, 0, why);
}

bool measure_lights(measurement *m, message *why)
{
    static study s;
    scene demo;
    if (!scene_create(&demo, 0, NULL)) return fail(why, "no memory");
    compare_case c = {"demo scene", demo, bvh_create(&demo), vec(0, 1, 0), true, (float)NAN, -1};
    bool done = c.tree || fail(why, "no memory");
    for (int which = 0; which < (m->probe ? 1 : PROBES) && done; which++) {
        message missing;
        s.m = m;
        s.s = &c.scene;
        s.tree = c.tree;
        if (!open_probe(&s, which, &missing)) {
            // One that was asked for by name is no option.
            if (m->probe)
                done = fail(why, "%.200s", missing.text);
            else
                say("  a probe is left out: %s", missing.text);
            continue;
        }
        done = study_probe(&s, &c, why);
        probe_free(&s.p);
    }
    case_free(&c);
    return done;
}

// ---- A whole picture -----------------------------------------------------------------------

static bool draw_picture(measurement *m, const probe *p, const scene *s, lighting *l, int width,
                         int height, message *why)
{
    const camera eye = camera_look(vec(0.3f, 2.25f, 7.7f), vec(-0.05f, 0.86f, 0), 0.57f,
                                   (float)width / (float)height);
    const light_source maps = {l, NULL, NULL, 0, 0};
    char size[FIGURE_NAME];
    view v;
    image picture;
    const double start = seconds_now();
    if (!lighting_extract(l, p, why) || !lighting_draw_maps(l, s, why)) return false;
    if (!view_create(&v, s, &eye, width, height)) return fail(why, "no memory");
    const bool done = image_create(&picture, width, height) || fail(why, "no memory");
    const double before = seconds_now();
    if (done) {
        lighting_render(&v, s, p, &maps, &picture);
        const double shading = seconds_now() - before, all = seconds_now() - start;
        const int threads = parallel_threads();
        snprintf(size, sizeof size, "%d x %d", width, height);
        put(m, "picture", size, "all", threads, "seconds", all, all, all);
        put(m, "picture", size, "shading", threads, "seconds", shading, shading, shading);
        put(m, "picture", size, "all", threads, "lights", l->lights, l->lights, l->lights);
        image_free(&picture);
    }
    view_free(&v);
    return done;
}

bool measure_picture(measurement *m, message *why)
{
    const int shrunk = m->quick ? 4 : 1;
    study s;
    scene demo;
    lighting l;
    s.m = m;
    if (!probe_default(&s.p, PROBE_DEFAULT_SIDE)) return fail(why, "no memory");
    bool done = scene_create(&demo, 0, NULL) || fail(why, "no memory");
    if (done && open_lighting(&l, &s, 32, LIGHTPROBE_BEST, 0, why)) {
        done = draw_picture(m, &s.p, &demo, &l, 960 / shrunk, 540 / shrunk, why);
        lighting_free(&l);
    } else
        done = false;
    scene_free(&demo);
    probe_free(&s.p);
    return done;
}
