// The slides' plots of run time: filtered hard shadows against the radius of the Gaussian, the side
// of the map and the size of the picture.
#include "../compare/methods.h"
#include "page.h"

#include "../../examples/common/raster.h"
#include "../../examples/common/threads.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { METHODS = 3, POINTS = 4, RADIUS = 4, ROUNDS = 3 };
static const int radii[POINTS] = {1, 4, 8, 16}, sides[POINTS] = {128, 256, 512, 1024},
                 pictures[POINTS] = {320, 640, 1280, 1920};

static const struct {
    const char *name, *title;
    colour ink;
    marker shape;
} shown[METHODS] = {{"PCF, Gaussian", "percentage-closer filtering", COLOUR_PCSS, MARKER_SQUARE},
                    {"EVSM, Gaussian", "EVSM, 128 bits", COLOUR_VARIANCE, MARKER_DIAMOND},
                    {"filtered, 4 moments", "moments, 64 bits", COLOUR_LAYERED, MARKER_CIRCLE}};

typedef struct bench {
    int measured, rounds; // values of each axis, and how often
    int side, picture;    // what does not vary, as an index
    scene scene;
    mssm_light light;
    float *depth[POINTS]; // by the side
    float (*points[POINTS])[3];
    int count[POINTS]; // by the size of the picture
} bench;

static bool collect(bench *b, int at, message *why)
{
    const int width = pictures[at], height = width * 9 / 16;
    const camera eye = camera_look(vec(0.3f, 2.25f, 7.7f), vec(-0.05f, 0.86f, 0), 0.57f, 16.0f / 9);
    view v;
    b->points[at] = malloc(sizeof *b->points[at] * (size_t)width * (size_t)height);
    if (!b->points[at] || !view_create(&v, &b->scene, &eye, width, height))
        return fail(why, "no memory for a view");
    for (int i = 0; i < width * height; i++) {
        surface s[VIEW_SAMPLES];
        if (!view_surfaces(&v, &b->scene, i % width, i / width, s)) continue;
        float *to = b->points[at][b->count[at]++];
        to[0] = s[0].position.x;
        to[1] = s[0].position.y;
        to[2] = s[0].position.z;
    }
    view_free(&v);
    return true;
}

static bool bench_open(bench *b, bool quick, message *why)
{
    static const float sun[3] = {-0.55f, 0.62f, 0.56f}, across[3] = {0, 1, 0};
    memset(b, 0, sizeof *b);
    b->measured = quick ? 2 : POINTS;
    b->rounds = quick ? 1 : ROUNDS;
    b->side = b->measured / 2;
    b->picture = 1;
    if (!scene_create(&b->scene, 0, NULL)) return fail(why, "no memory for the scene");
    const float low[3] = {b->scene.low.x, b->scene.low.y, b->scene.low.z},
                high[3] = {b->scene.high.x, b->scene.high.y, b->scene.high.z};
    if (mssm_light_directional(&b->light, sun, across, 0, 0, low, high))
        return fail(why, "no light");
    const raster_frustum frustum = {b->light.world_to_shadow, false, 0, 0};
    for (int i = 0; i < b->measured; i++) {
        b->depth[i] = malloc(sizeof **b->depth * (size_t)sides[i] * (size_t)sides[i]);
        if (!b->depth[i] ||
            !raster_depth(&b->scene, &frustum, RASTER_FRONT, sides[i], 1, b->depth[i])) {
            return fail(why, "no memory for depth maps");
        }
        if (!collect(b, i, why)) return false;
    }
    return true;
}

static void bench_close(bench *b)
{
    for (int i = 0; i < POINTS; i++) {
        free(b->depth[i]);
        free(b->points[i]);
    }
    scene_free(&b->scene);
}

// Milliseconds of a frame's shadows: the map's update and every pixel's look.
static double time_of(const bench *b, const method *of, int radius, int side, int picture)
{
    method m = *of;
    size_t bytes;
    double least = HUGE_VAL;
    static volatile float sink;
    m.variant = radius;
    void *state = m.create(&m, sides[side], &bytes);
    const depth_map map = {&b->light, sides[side], b->depth[side], NULL};
    for (int round = 0; round < b->rounds && state; round++) {
        const double start = seconds_now();
        m.update(state, &map);
        for (int i = 0; i < b->count[picture]; i++)
            sink = m.visibility(state, b->points[picture][i], m.bias, (unsigned)i);
        least = fmin(least, seconds_now() - start);
    }
    (void)sink;
    if (state) m.destroy(state);
    return 1e3 * least;
}

static double growth(const series *s)
{
    return s->y[s->count - 1] / s->y[0];
}

// Nanoseconds that a pixel more costs.
static double each(const bench *b, const series *s)
{
    const int last = b->measured - 1;
    const double pixels = (double)(b->count[last] - b->count[0]);
    return 1e6 * (s->y[last] - s->y[0]) / pixels;
}

static void judge(page *p, const bench *b, const panel panels[3])
{
    enum { PCF, EVSM, OWN };
    const series *by_radius = panels[0].list, *maps = panels[1].list, *output = panels[2].list;
    const bool radius = growth(&by_radius[PCF]) > growth(&by_radius[OWN]),
               map = growth(&maps[OWN]) > growth(&maps[PCF]),
               pixel = each(b, &output[PCF]) > each(b, &output[OWN]);
    const int held = radius + map + pixel, last = b->measured - 1;
    fprintf(
        p->file,
        "**%s** Radius %d to %d: percentage-closer filtering takes %.1f times as long "
        "(\"catastrophic\"), moments %.1f times (\"barely depends\"). Map %d² to %d²: %.1f times "
        "(\"barely gets more expensive\") against %.1f times (\"the cost per texel is higher\"). "
        "Each further pixel costs %.0f ns with percentage-closer filtering, %.0f with EVSM, %.0f "
        "with moments: that moments are cheaper per pixel %s%s.\n\n",
        held == 3  ? "Agrees."
        : held > 0 ? "Agrees in part."
                   : "Does not agree.",
        radii[0], radii[last], growth(&by_radius[PCF]), growth(&by_radius[OWN]), sides[0],
        sides[last], growth(&maps[PCF]), growth(&maps[OWN]), each(b, &output[PCF]),
        each(b, &output[EVSM]), each(b, &output[OWN]),
        pixel ? "holds" : "does not hold at this radius",
        pixel
            ? ""
            : ", because a processor reads the kernel's texels from its cache, here four at a time, "
              "and pays for the moments' arithmetic, where a GPU waits for memory");
}

bool hard_shadow_times(page *p, message *why)
{
    bench b;
    panel panels[3];
    if (!bench_open(&b, p->quick, why)) return false;
    memset(panels, 0, sizeof panels);
    panels[0].across = "radius of the Gaussian, texels";
    panels[1].across = "side of the map, texels";
    panels[2].across = "width of the picture, pixels";
    for (int k = 0; k < METHODS; k++) {
        const method *m = method_named(shown[k].name);
        if (!m) return fail(why, "no method %s", shown[k].name);
        for (int i = 0; i < 3; i++)
            panels[i].list[panels[i].count++] =
                (series){.name = shown[k].title, .ink = shown[k].ink, .shape = shown[k].shape};
        for (int i = 0; i < b.measured; i++) {
            series_add(&panels[0].list[k], radii[i], time_of(&b, m, radii[i], b.side, b.picture));
            series_add(&panels[1].list[k], sides[i], time_of(&b, m, RADIUS, i, b.picture));
            series_add(&panels[2].list[k], pictures[i], time_of(&b, m, RADIUS, b.side, i));
        }
    }
    fprintf(
        p->file,
        "## Filtered hard shadows\n\n"
        "The slides' plots of run time: radius, map and output. Times are of one light on one "
        "core: an update of the map and one visibility for each pixel that shows the scene. "
        "Unless varied, the radius is %d, maps are %d², pictures %d wide. Percentage-closer "
        "filtering reads every texel of the kernel for each pixel; the others filter the map in "
        "two passes and read one filtered texel. The soft shadows' plots are above.\n\n"
        "![Filtered hard shadows](figure_hard_shadow_times.svg)\n\n",
        RADIUS, sides[b.side], pictures[b.picture]);
    static const char *const corner[3] = {"ms, by radius", "ms, by the map's side",
                                          "ms, by the picture's width"};
    for (int i = 0; i < 3; i++) chart_table(p->file, corner[i], &panels[i]);
    judge(p, &b, panels);
    bench_close(&b);
    return chart_draw(page_path(p, "figure_hard_shadow_times.svg"),
                      "Filtered hard shadows: time against radius, map and picture", panels, 3,
                      why);
}
