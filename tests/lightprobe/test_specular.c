// Specular reflection of the lights: against GGX integrated over the light, and what must hold for
// any light.
#include "../../lightprobe.h"
#include "../support/test.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void random_unit(uint64_t *seed, double d[3])
{
    const double z = test_range(seed, -1, 1), a = test_range(seed, 0, 2 * pi), r = sqrt(1 - z * z);
    d[0] = r * cos(a);
    d[1] = r * sin(a);
    d[2] = z;
}

// ---- The oracle: radiance per radiance of the light, by a grid over it

// What looks from the probe like a rectangle with half-sizes u and v in a plane at c, but lies in the plane
// that recedes by slope[] along its axes.
typedef struct panel {
    double direction[3], axis_u[3], axis_v[3], c, u, v, offset[3], slope[2];
} panel;

typedef struct surface {
    double normal[3], view[3], alpha, f0;
} surface;

// GGX times cosine for light from the unit vector l: Walter et al. 2007, Heitz 2014, Schlick 1994.
static double reflected(const surface *s, const double l[3])
{
    double h[3], a2 = s->alpha * s->alpha;
    for (int i = 0; i < 3; i++) h[i] = s->view[i] + l[i];
    const double size = sqrt(dot(h, h)), nv = dot(s->normal, s->view), nl = dot(s->normal, l);
    const double nh = dot(s->normal, h) / size, vh = dot(s->view, h) / size;
    if (nl <= 0) return 0;
    const double d = a2 / (pi * pow(nh * nh * (a2 - 1) + 1, 2));
    const double lambda_v = (sqrt(1 + a2 * (1 / (nv * nv) - 1)) - 1) / 2;
    const double lambda_l = (sqrt(1 + a2 * (1 / (nl * nl) - 1)) - 1) / 2;
    return d / (1 + lambda_v + lambda_l) / (4 * nv) * (s->f0 + (1 - s->f0) * pow(1 - vh, 5));
}

// What the header makes of it, by its own matrix: a cosine lobe, transformed. Seen along the normal
// "away" is shorter than 1, and the matrix stretches less along it.
static double transformed(const lightprobe_lobe *lobe, const double l[3])
{
    double x = 0, z = 0, length = 1e-12;
    for (int i = 0; i < 3; i++) {
        x += lobe->away[i] * l[i];
        z += lobe->normal[i] * l[i];
        length += lobe->away[i] * lobe->away[i];
    }
    const double along = lobe->across + (lobe->along - lobe->across) * length;
    length = sqrt(length);
    x /= length;
    const double p = along * x - lobe->shear * length * z,
                 q2 = fmax(0, 1 - x * x - z * z) * lobe->across * lobe->across;
    const double r = lobe->width * z, square = p * p + q2 + r * r;
    return z > 0 ? r * along * lobe->across * lobe->width / (pi * square * square) : 0;
}

static double solid_angle(const panel *p)
{
    return 4 * atan2(p->u * p->v, p->c * sqrt(p->c * p->c + p->u * p->u + p->v * p->v));
}

// Sum over a grid of n^2 places, of one of the two.
static double integral(const panel *p, const surface *s, const lightprobe_lobe *lobe, int n)
{
    double sum = 0;
    for (int i = 0; i < n * n; i++) {
        const double x = p->u * (2 * (i % n + 0.5) / n - 1), y = p->v * (2 * (i / n + 0.5) / n - 1);
        double l[3], across[3], ray[3];
        for (int k = 0; k < 3; k++) {
            ray[k] = p->c * p->direction[k] + x * p->axis_u[k] + y * p->axis_v[k];
            across[k] = p->direction[k] - p->slope[0] * p->axis_u[k] - p->slope[1] * p->axis_v[k];
        }
        const double reach =
            p->c / dot(ray, across); // the ray from the probe meets the plane there
        for (int k = 0; k < 3; k++) l[k] = reach * ray[k] - p->c * p->offset[k];
        const double square = dot(l, l), size = sqrt(square), facing = dot(l, across) / size;
        for (int k = 0; k < 3; k++) l[k] /= size;
        if (facing > 0) // an area of the plane is reach^3 times that of the rectangle, and |across|
            sum += 4 * p->u * p->v / (n * n) * reach * reach * reach * facing / square *
                   (lobe ? transformed(lobe, l) : reflected(s, l));
    }
    return sum;
}

// ---- Lights and surfaces

static void random_axes(uint64_t *seed, panel *p)
{
    double size = 0;
    do {
        random_unit(seed, p->axis_u);
        const double along = dot(p->axis_u, p->direction);
        for (int i = 0; i < 3; i++) p->axis_u[i] -= along * p->direction[i];
        size = sqrt(dot(p->axis_u, p->axis_u));
    } while (size < 0.1);
    for (int i = 0; i < 3; i++) p->axis_u[i] /= size;
    const double hand = test_uniform(seed) < 0.5 ? -1 : 1; // both occur
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        p->axis_v[i] = hand * (p->direction[j] * p->axis_u[k] - p->direction[k] * p->axis_u[j]);
    }
}

// Uniform of radiance 1.
static lightprobe_light light_of(panel *p, double tan_u, double tan_v, double cos_alpha)
{
    lightprobe_light l;
    memset(&l, 0, sizeof l);
    l.tan_half_u = (float)tan_u;
    l.tan_half_v = (float)tan_v;
    l.cos_alpha = (float)cos_alpha;
    const double wide = cos_alpha < 0 ? sqrt(1 - cos_alpha * cos_alpha) : 1;
    p->c = l.cos_alpha;
    p->u = wide * l.tan_half_u / sqrt(1 + (double)l.tan_half_u * l.tan_half_u);
    p->v = wide * l.tan_half_v / sqrt(1 + (double)l.tan_half_v * l.tan_half_v);
    for (int i = 0; i < 3; i++) {
        l.direction[i] = (float)p->direction[i];
        l.axis_u[i] = (float)p->axis_u[i];
        l.axis_v[i] = (float)p->axis_v[i];
        l.irradiance[i] = (float)solid_angle(p);
    }
    return l;
}

static lightprobe_lobe lobe_of(const surface *s)
{
    float n[3], v[3], f0[3];
    for (int i = 0; i < 3; i++) {
        n[i] = (float)s->normal[i];
        v[i] = (float)s->view[i];
        f0[i] = (float)s->f0;
    }
    return lightprobe_specular_lobe(n, v, (float)s->alpha, f0);
}

// Seen under an angle from the normal.
static surface surface_at(uint64_t *seed, double alpha, double angle, double f0)
{
    surface s = {{0}, {0}, alpha, f0};
    panel frame;
    random_unit(seed, s.normal);
    memcpy(frame.direction, s.normal, sizeof s.normal);
    random_axes(seed, &frame);
    for (int i = 0; i < 3; i++) s.view[i] = cos(angle) * s.normal[i] - sin(angle) * frame.axis_u[i];
    return s;
}

// About where a mirror would show it, so that it matters.
static void aim(uint64_t *seed, panel *p, const surface *s, double reach)
{
    const double nv = dot(s->normal, s->view);
    double off[3], size;
    random_unit(seed, off);
    for (int i = 0; i < 3; i++)
        p->direction[i] = 2 * nv * s->normal[i] - s->view[i] + reach * off[i];
    size = sqrt(dot(p->direction, p->direction));
    for (int i = 0; i < 3; i++) p->direction[i] /= size;
    random_axes(seed, p);
    memset(p->offset, 0, sizeof p->offset);
    memset(p->slope, 0, sizeof p->slope);
}

// As far above the surface's horizon.
static void lay(uint64_t *seed, panel *p, const surface *s, double sine)
{
    const double up = dot(p->direction, s->normal);
    for (int i = 0; i < 3; i++) p->direction[i] -= up * s->normal[i];
    const double along = sqrt(dot(p->direction, p->direction));
    for (int i = 0; i < 3; i++)
        p->direction[i] = sqrt(1 - sine * sine) / along * p->direction[i] + sine * s->normal[i];
    random_axes(seed, p);
}

// ---- The properties

// The light's part of the lobe, by edges, is that of a grid: near and far, across the horizon, from
// beside the probe, tilted.
static void part_of_the_lobe_is_exact(void)
{
    uint64_t seed = 11;
    double worst = 0, cut = 0;
    for (int i = 0; i < test_trials(2000); i++) {
        const double alpha = pow(test_range(&seed, 0.15, 1), 2);
        const surface s = surface_at(&seed, alpha, test_range(&seed, 0, 1.5), 1);
        const lightprobe_lobe lobe = lobe_of(&s);
        panel p;
        aim(&seed, &p, &s, 1.5);
        const double t = pow(10, test_range(&seed, -2.5, 0.3));
        if (i % 4 == 3) lay(&seed, &p, &s, test_range(&seed, -0.7, 0.7) * fmin(t, 1));
        lightprobe_light l =
            light_of(&p, t, t * test_range(&seed, 0.1, 1), test_range(&seed, 0.2, 1));
        if (i % 3 == 0) l.distance = 2.5f;
        for (int k = 0; k < 3 && i % 3 == 0; k++) p.offset[k] = test_range(&seed, -0.5, 0.5);
        for (int k = 0; k < 2 && i % 6 == 0; k++) // no edge is nearer than half as far
            p.slope[k] = test_range(&seed, -1, 1) * fmin(2, 0.25 * p.c / (k ? p.v : p.u));
        l.slope_u = (float)p.slope[0];
        l.slope_v = (float)p.slope[1];
        float rgb[3];
        lightprobe_specular(l, lobe, (float)(2.5 * p.offset[0]), (float)(2.5 * p.offset[1]),
                            (float)(2.5 * p.offset[2]), rgb);
        const double truth = integral(&p, &s, &lobe, 200), part = rgb[0] / lobe.whole;
        worst = fmax(worst, fabs(part - truth) / (0.02 + truth));
        cut += fabs(dot(p.direction, s.normal)) < t && truth > 0.01;
    }
    test_note("worst %.1e of the part and 0.02; %g lights cut by the horizon", worst, cut);
    CHECK(worst < 0.01, "worst %g",
          worst); // the grid's own error where the horizon or a narrow lobe cuts it
    CHECK(cut > 0.05 * test_trials(2000), "only %g were cut", cut);
}

// Single precision: a light of 1/20 degree and its grid agree to four digits.
static void small_lights_keep_their_digits(void)
{
    uint64_t seed = 5;
    double worst = 0;
    for (int i = 0; i < test_trials(2000); i++) {
        const surface s =
            surface_at(&seed, pow(test_range(&seed, 0.3, 1), 2), test_range(&seed, 0, 1.4), 1);
        const lightprobe_lobe lobe = lobe_of(&s);
        panel p;
        aim(&seed, &p, &s, 0.2);
        if (dot(p.direction, s.normal) < 0.1) continue;
        const lightprobe_light l = light_of(&p, 1e-3, 1e-3, 1);
        float rgb[3];
        lightprobe_specular(l, lobe, 0, 0, 0, rgb);
        worst = fmax(worst, fabs(rgb[0] / (lobe.whole * integral(&p, &s, &lobe, 4)) - 1));
    }
    CHECK(worst < 2e-3, "worst %g", worst);
}

// Against GGX itself, in parts of rms radiance: what docs/lightprobe.md says of each roughness and
// angle.
static void radiance_is_that_of_ggx(void)
{
    static const double alphas[] = {0.05, 0.1, 0.2, 0.5, 1}, ends[] = {0, 0.7, 1.22, 1.48};
    static const double most[5][3] = {{0.02, 0.03, 0.06},
                                      {0.03, 0.05, 0.1},
                                      {0.04, 0.07, 0.15},
                                      {0.04, 0.07, 0.15},
                                      {0.04, 0.04, 0.12}};
    for (int a = 0; a < 5; a++) {
        for (int part = 0; part < 3; part++) {
            uint64_t seed = 21;
            double wrong = 0, right = 0;
            for (int i = 0; i < 150; i++) { // whatever the scale: fewer are no mean
                const surface s =
                    surface_at(&seed, alphas[a], test_range(&seed, ends[part], ends[part + 1]),
                               i % 2 ? 1 : 0.04);
                panel p;
                const double t = pow(10, test_range(&seed, -1.5, 0));
                aim(&seed, &p, &s, 2 * alphas[a] + t);
                const lightprobe_light l =
                    light_of(&p, t, t * test_range(&seed, 0.3, 1), 1 / sqrt(1 + t * t));
                float rgb[3];
                lightprobe_specular(l, lobe_of(&s), 0, 0, 0, rgb);
                const double truth = integral(&p, &s, NULL, 64);
                wrong += pow(rgb[1] - truth, 2) / s.f0;
                right += truth * truth / s.f0;
            }
            const double rms = sqrt(wrong / right);
            test_note("alpha %g, up to %2.0f degrees: %.3f", alphas[a], ends[part + 1] * 180 / pi,
                      rms);
            CHECK(rms < most[a][part], "alpha %g, part %d: %g", alphas[a], part, rms);
        }
    }
}

// GGX's whole reflectance, over half vectors as GGX has them: their density cancels most of it.
static double all_of_ggx(double alpha, double angle, double f0)
{
    const int n = 150;
    double sum = 0;
    for (int k = 0; k < n * n; k++) {
        const double u = (k / n + 0.5) / n, phi = pi * (k % n + 0.5) / n;
        const double hz = sqrt((1 - u) / (1 - u + alpha * alpha * u)), hr = sqrt(1 - hz * hz);
        const double vh = sin(angle) * hr * cos(phi) + cos(angle) * hz,
                     nl = 2 * vh * hz - cos(angle);
        if (vh <= 0 || nl <= 0) continue;
        const double lv = sqrt(1 + pow(alpha * tan(angle), 2)),
                     ll = sqrt(1 + alpha * alpha * (1 / (nl * nl) - 1));
        sum += 2 / (lv + ll) * vh / (cos(angle) * hz) * (f0 + (1 - f0) * pow(1 - vh, 5)) / (n * n);
    }
    return sum;
}

// The whole hemisphere of light gives the whole reflectance, and so does the sphere; by f0 and
// angle.
static void compare_reflectance(double least_angle, double most_angle, double limit)
{
    static const double f0[] = {0, 0.04, 1};
    uint64_t seed = 2;
    double worst = 0, between = 0;
    for (int i = 0; i < test_trials(300); i++) {
        const double alpha = pow(test_range(&seed, 0.1415, 1), 2),
                     angle = test_range(&seed, least_angle, most_angle);
        const surface s = surface_at(&seed, alpha, angle, f0[i % 3]);
        panel p;
        memcpy(p.direction, s.normal, sizeof p.direction);
        random_axes(&seed, &p);
        float hemisphere[3], sphere[3];
        const lightprobe_light half = light_of(&p, 4, 4, 0);
        random_unit(&seed, p.direction);
        random_axes(&seed, &p);
        const lightprobe_light all = light_of(&p, 4, 4, -1);
        lightprobe_specular(half, lobe_of(&s), 0, 0, 0, hemisphere);
        lightprobe_specular(all, lobe_of(&s), 0, 0, 0, sphere);
        worst = fmax(worst, fabs(hemisphere[0] - all_of_ggx(alpha, angle, s.f0)));
        between = fmax(between, fabs(hemisphere[0] - sphere[0]));
        CHECK(hemisphere[0] <= 1, "more than all: %g", (double)hemisphere[0]);
    }
    test_note("worst %.4f of the light's radiance", worst);
    CHECK(worst < limit && between < 1e-5, "worst %g, between hemisphere and sphere %g", worst,
          between);
}

static void whole_reflectance_is_ggxs(void)
{
    compare_reflectance(0, 1.5, 0.016);
}

// Beyond 88 degrees, where nothing is fitted, it goes on: no dark line before the horizon of a
// floor.
static void grazing_reflectance_goes_on(void)
{
    compare_reflectance(1.535, 1.57, 0.1);
}

// Smooth normals turn away from the viewer at outlines: then it is as if he stood in the surface
// before it.
static void viewers_below_stand_in_the_surface(void)
{
    uint64_t seed = 14;
    double worst = 0, above = 0;
    for (int i = 0; i < test_trials(20000); i++) {
        const double angle = test_range(&seed, 0.5 * pi, 0.98 * pi), t = test_range(&seed, 0.01, 1);
        const surface below = surface_at(&seed, pow(test_range(&seed, 0.15, 1), 2), angle, 1);
        surface along = below;
        panel p;
        float rgb[3], wanted[3];
        for (int k = 0; k < 3; k++)
            along.view[k] = (below.view[k] - cos(angle) * below.normal[k]) / sin(angle);
        random_unit(&seed, p.direction);
        random_axes(&seed, &p);
        const lightprobe_light l = light_of(&p, t, t, 1 / sqrt(1 + t * t));
        lightprobe_specular(l, lobe_of(&below), 0, 0, 0, rgb);
        lightprobe_specular(l, lobe_of(&along), 0, 0, 0, wanted);
        worst = fmax(worst, fabs(rgb[0] - wanted[0]));
        const double top = p.c * dot(p.direction, below.normal) +
                           p.u * fabs(dot(p.axis_u, below.normal)) +
                           p.v * fabs(dot(p.axis_v, below.normal));
        if (top < -1e-5) CHECK(rgb[0] == 0, "%g from below", (double)rgb[0]);
        above += rgb[0] > 0.01f;
    }
    CHECK(worst < 1e-3 && above > 0.05 * test_trials(20000), "worst %g, %g shine", worst, above);
}

// A light and all the rest of the sphere make the whole.
static void light_and_its_opposite_make_the_whole(void)
{
    uint64_t seed = 3;
    double worst = 0;
    for (int i = 0; i < test_trials(3000); i++) {
        const surface s =
            surface_at(&seed, pow(test_range(&seed, 0.2, 1), 2), test_range(&seed, 0, 1.5), 1);
        const lightprobe_lobe lobe = lobe_of(&s);
        const double c = test_range(&seed, 0.02, 0.9), shrink = sqrt(1 - c * c),
                     sine = test_range(&seed, 0.1, 0.9) * shrink;
        panel p, q;
        float light[3], rest[3];
        random_unit(&seed, p.direction);
        random_axes(&seed, &p);
        q = p;
        for (int k = 0; k < 3; k++) q.direction[k] = -q.direction[k];
        const double t = sine / sqrt(1 - sine * sine),
                     wide = sine / shrink / sqrt(1 - sine * sine / (shrink * shrink));
        lightprobe_specular(light_of(&p, t, t, c), lobe, 0, 0, 0, light);
        lightprobe_specular(light_of(&q, wide, wide, -c), lobe, 0, 0, 0, rest);
        worst = fmax(worst, fabs(light[0] + rest[0] - lobe.whole));
    }
    CHECK(worst < 2e-5, "worst %g", worst);
}

// While a light sets nothing jumps; once it is below the horizon, behind a receiver or faces away,
// there is none.
static void setting_lights_fade(void)
{
    uint64_t seed = 8;
    for (int i = 0; i < test_trials(300); i++) {
        const surface s =
            surface_at(&seed, pow(test_range(&seed, 0.3, 1), 2), test_range(&seed, 0, 1.5), 1);
        const lightprobe_lobe lobe = lobe_of(&s);
        const double t = pow(10, test_range(&seed, -2, -0.3));
        panel frame = {{0}, {0}, {0}, 0, 0, 0, {0}, {0}};
        memcpy(frame.direction, s.normal, sizeof s.normal);
        random_axes(&seed, &frame);
        float before = 0, rgb[3];
        for (int step = 0; step <= 200; step++) {
            const double h =
                (1 - step / 100.0) * 2 * t; // of its centre; both corners at most 1.42 t away
            panel p = frame;
            for (int k = 0; k < 3; k++) {
                p.direction[k] = sin(h) * s.normal[k] + cos(h) * frame.axis_u[k];
                p.axis_u[k] = cos(h) * s.normal[k] - sin(h) * frame.axis_u[k];
            }
            lightprobe_specular(light_of(&p, t, t, 1), lobe, 0, 0, 0, rgb);
            CHECK(step > 0 || rgb[0] > 0, "nothing from above");
            CHECK(step == 0 || fabsf(rgb[0] - before) < 0.1f, "step %d from %g to %g", step,
                  (double)before, (double)rgb[0]);
            if (step > 180) CHECK(rgb[0] == 0, "%g from below", (double)rgb[0]);
            before = rgb[0];
        }
    }
    const surface s = {{0, 1, 0}, {0, 1, 0}, 0.5, 1};
    panel p = {{0, 1, 0}, {1, 0, 0}, {0, 0, -1}, 0, 0, 0, {0}, {0}};
    lightprobe_light l = light_of(&p, 0.2, 0.2, 0.98);
    float rgb[3];
    l.distance = 3;
    lightprobe_specular(l, lobe_of(&s), 0, 2.9f, 0, rgb);
    CHECK(rgb[0] > 0.9f * lobe_of(&s).whole, "close below it: %g", (double)rgb[0]);
    lightprobe_specular(l, lobe_of(&s), 0, 3.1f, 0, rgb);
    CHECK(rgb[0] == 0 && rgb[2] == 0, "behind it: %g", (double)rgb[0]);
}

// A surface goes through a wide light at a finite place, flat or leaning, within its outline: it is lit up
// to the plane and not behind it, without a step.
static void lights_end_at_their_plane(void)
{
    enum { STEPS = 400 };
    uint64_t seed = 31;
    double worst = 0;
    for (int t = 0; t < test_trials(100); t++) {
        lightprobe_light l;
        const float up[3] = {0, 1, 0}, view[3] = {0, 0.6f, 0.8f}, f0[3] = {1, 1, 1};
        const double alpha = test_range(&seed, 0.3, 0.8), slope = t % 2 ? 0.4 : 0;
        const float aside = (float)test_range(&seed, -0.1, 0.1);
        const lightprobe_lobe lobe =
            lightprobe_specular_lobe(up, view, (float)test_range(&seed, 0.1, 1), f0);
        float last = 0, most = 0, step = 0, behind = 0;
        memset(&l, 0, sizeof l);
        l.direction[2] = -1;
        l.axis_u[0] = l.axis_v[1] = 1;
        l.cos_alpha = (float)cos(alpha);
        l.tan_half_u = l.tan_half_v = (float)tan(0.88 * alpha);
        l.irradiance[0] = 1;
        l.distance = 2;
        l.slope_u = (float)slope;
        for (int i = 0; i < STEPS; i++) {
            const float z = -1.5f - (float)i / STEPS;
            float rgb[3];
            lightprobe_specular(l, lobe, aside, 0, z, rgb);
            if (i) step = fmaxf(step, fabsf(rgb[0] - last));
            most = fmaxf(most, rgb[0]);
            // The plane: distance 2 in direction -z, and further by the slope along x.
            if (-z > 2 + (float)slope * aside) behind = fmaxf(behind, rgb[0]);
            last = rgb[0];
        }
        CHECK(most > 0.1f && behind < 1e-6f * most, "at most %g, behind it %g", (double)most,
              (double)behind);
        worst = fmax(worst, (double)(step / most));
    }
    test_note("largest step of %d: %.3f of the largest radiance", STEPS, worst);
    CHECK(worst < 0.15, "a step of %g", worst);
}

// ---- Lights of a probe that sees a panel, against the panel

// Where the ray meets the rectangle from its front, HUGE_VAL where not; corner and both edges.
static double meets(double r[3][3], const double n[3], const double ray[3])
{
    const double t = dot(r[0], n) / dot(ray, n);
    double at[3];
    if (dot(ray, n) >= 0) return HUGE_VAL;
    for (int k = 0; k < 3; k++) at[k] = t * ray[k] - r[0][k];
    for (int e = 1; e < 3; e++) {
        const double part = dot(at, r[e]) / dot(r[e], r[e]);
        if (part < 0 || part > 1) return HUGE_VAL;
    }
    return t;
}

// A panel anywhere, seen from the probe under up to 60 degrees, shines 1.
static void random_panel(uint64_t *seed, double r[3][3], double n[3])
{
    double at[3], aside[3], away;
    do {
        random_unit(seed, n);
        random_unit(seed, at);
        random_unit(seed, aside);
    } while (-dot(n, at) < 0.5 || fabs(dot(n, aside)) > 0.8);
    away = test_range(seed, 1, 2.5);
    const double flat = sqrt(1 - pow(dot(n, aside), 2));
    for (int k = 0; k < 3; k++) r[1][k] = 0.5 * away * (aside[k] - dot(n, aside) * n[k]) / flat;
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        r[2][k] = 0.66 * (n[i] * r[1][j] - n[j] * r[1][i]);
    }
    for (int k = 0; k < 3; k++) r[0][k] = away * at[k] - 0.5 * (r[1][k] + r[2][k]);
}

// Lights of a probe that sees nothing else, by 4 x 4 rays a texel.
static int lights_of_panel(double r[3][3], const double n[3], int most, lightprobe_light *light)
{
    enum { SIDE = 64, RAYS = 4 };
    static float texels[6][SIDE * SIDE * 4];
    static unsigned char scratch[1 << 20];
    lightprobe_cube cube = {{0}, SIDE, 4};
    lightprobe_settings settings;
    int count = 0;
    memset(&settings, 0, sizeof settings);
    settings.max_lights = most;
    settings.distances = 1;
    for (int i = 0; i < 6 * SIDE * SIDE; i++) {
        float *texel = texels[i / SIDE / SIDE] + 4 * (i % (SIDE * SIDE));
        double sum = 0, inverse = 0;
        for (int k = 0; k < RAYS * RAYS; k++) {
            float d[3];
            lightprobe_texel_direction(
                i / SIDE / SIDE, (float)((i % SIDE + (k % RAYS + 0.5) / RAYS) * 2 / SIDE - 1),
                (float)((i / SIDE % SIDE + (k / RAYS + 0.5) / RAYS) * 2 / SIDE - 1), d);
            const double ray[3] = {d[0], d[1], d[2]}, t = meets(r, n, ray);
            sum += t < HUGE_VAL;
            inverse += 1 / t;
        }
        for (int c = 0; c < 3; c++) texel[c] = (float)(sum / (RAYS * RAYS));
        texel[3] = sum > 0 ? (float)(sum / inverse) : 0;
        cube.face[i / SIDE / SIDE] = texels[i / SIDE / SIDE];
    }
    CHECK(!lightprobe_extract(&cube, &settings, scratch, sizeof scratch, light, &count, NULL),
          "extract");
    return count;
}

// Radiance that a surface at p sends to the viewer of the panel, by a grid over it.
static double shine_of(double r[3][3], const double n[3], const double p[3], const surface *s)
{
    enum { GRID = 32 };
    double sum = 0;
    for (int i = 0; i < GRID * GRID; i++) {
        const double a = (i % GRID + 0.5) / GRID, b = (i / GRID + 0.5) / GRID;
        double to[3];
        for (int k = 0; k < 3; k++) to[k] = r[0][k] + a * r[1][k] + b * r[2][k] - p[k];
        const double away = sqrt(dot(to, to)), cosine = -dot(to, n) / away;
        for (int k = 0; k < 3; k++) to[k] /= away;
        if (cosine > 0) sum += reflected(s, to) * cosine / (away * away);
    }
    return sum / (GRID * GRID) * sqrt(dot(r[1], r[1]) * dot(r[2], r[2]));
}

// However few lights a panel has, surfaces around the probe that show it show it tilted: with slopes the
// error is less, and in no single room more.
static void panels_shine_as_they_are_tilted(void)
{
    const int panels = test_trials(60);
    for (int most = 1; most <= 16; most *= 2) {
        uint64_t seed = 15;
        double ratio = 0, worst = 0;
        for (int t = 0; t < panels; t++) {
            double r[3][3], n[3], error[2] = {0, 0};
            lightprobe_light light[16];
            random_panel(&seed, r, n);
            const int count = lights_of_panel(r, n, most, light);
            for (int i = 0; i < 40; i++) {
                surface s = {{0}, {0}, 0.2, 1};
                double p[3], to[3], seen[2] = {0, 0};
                random_unit(&seed, p);
                random_unit(&seed, s.normal);
                for (int k = 0; k < 3; k++) // about where a mirror would show the panel
                    to[k] = r[0][k] + 0.5 * (r[1][k] + r[2][k]) - 0.7 * p[k] +
                            test_range(&seed, -0.3, 0.3);
                const double away = sqrt(dot(to, to)), cosine = dot(to, s.normal) / away;
                if (cosine < 0.1) continue;
                for (int k = 0; k < 3; k++) {
                    s.view[k] = 2 * cosine * s.normal[k] - to[k] / away;
                    p[k] *= 0.7;
                }
                const double right = shine_of(r, n, p, &s);
                for (int k = 0; k < 2 * count; k++) {
                    float rgb[3];
                    lightprobe_light l = light[k / 2];
                    if (k % 2) l.slope_u = l.slope_v = 0;
                    lightprobe_specular(l, lobe_of(&s), (float)p[0], (float)p[1], (float)p[2], rgb);
                    seen[k % 2] += (double)rgb[1];
                }
                for (int k = 0; k < 2; k++) error[k] += pow(seen[k] - right, 2);
            }
            ratio += 0.5 * log(error[0] / error[1]) / panels;
            worst = fmax(worst, sqrt(error[0] / error[1]));
        }
        test_note("%d lights: error %.2f of that facing the probe, at most %.2f", most, exp(ratio),
                  worst);
        CHECK(panels < 20 || exp(ratio) < 0.4, "%d lights: %g", most, exp(ratio));
        CHECK(worst < 1.06, "%d lights: %g in one room", most, worst);
    }
}

static float garbage(uint64_t *seed)
{
    const double kind = test_uniform(seed);
    if (kind < 0.3) return (float)test_range(seed, -1, 1);
    if (kind < 0.5) return (float)((int)test_range(seed, 0, 3) - 1);
    return (float)(test_range(seed, -1, 1) * pow(10, test_range(seed, -40, 38)));
}

// Any finite numbers: at least 0, at most the light's radiance, which is limited by the least solid
// angle.
static void any_arguments_give_radiance(void)
{
    uint64_t seed = 4;
    for (int i = 0; i < test_trials(200000); i++) {
        lightprobe_light l;
        float n[3], v[3], f0[3], at[3], rgb[3];
        memset(&l, 0, sizeof l);
        for (int k = 0; k < 3; k++) {
            n[k] = garbage(&seed);
            v[k] = garbage(&seed);
            f0[k] = garbage(&seed);
            at[k] = garbage(&seed);
            l.direction[k] = garbage(&seed);
            l.axis_u[k] = garbage(&seed);
            l.axis_v[k] = garbage(&seed);
            l.irradiance[k] = 1;
        }
        l.tan_half_u = garbage(&seed);
        l.tan_half_v = garbage(&seed);
        l.cos_alpha = garbage(&seed);
        l.distance = garbage(&seed);
        l.slope_u = garbage(&seed);
        l.slope_v = garbage(&seed);
        lightprobe_specular(l, lightprobe_specular_lobe(n, v, garbage(&seed), f0), at[0], at[1],
                            at[2], rgb);
        for (int k = 0; k < 3; k++)
            CHECK(rgb[k] >= 0 && rgb[k] <= 2.6e5f, "trial %d: %g", i, (double)rgb[k]);
    }
}

static void arguments_are_clamped(void)
{
    const float up[3] = {0, 1, 0}, aside[3] = {0.8f, 0.6f, 0}, below[3] = {0.8f, -0.6f, 0},
                along[3] = {1, 0, 0};
    const float f0[3] = {-1, 0.5f, 2}, inside[3] = {0, 0.5f, 1};
    const lightprobe_lobe a = lightprobe_specular_lobe(up, aside, 0.001f, f0),
                          b = lightprobe_specular_lobe(up, aside, 0.02f, inside);
    const lightprobe_lobe c = lightprobe_specular_lobe(up, aside, 7, f0),
                          d = lightprobe_specular_lobe(up, aside, 1, inside);
    CHECK(!memcmp(&a, &b, sizeof a) && !memcmp(&c, &d, sizeof c), "alpha or f0 beyond the limits");
    CHECK(lightprobe_specular_lobe(up, below, 0.3f, f0).whole ==
              lightprobe_specular_lobe(up, along, 0.3f, f0).whole,
          "from below");
    // Straight from above the lobe is as wide in each direction.
    panel p = {{0.6, 0.8, 0}, {0, 0, 1}, {0, 0, 0}, 0, 0, 0, {0}, {0}};
    const lightprobe_lobe e = lightprobe_specular_lobe(up, up, 0.3f, inside);
    float least = FLT_MAX, most = 0;
    for (int i = 0; i < 12; i++) {
        p.direction[0] = 0.6 * cos(i);
        p.direction[2] = 0.6 * sin(i);
        for (int k = 0; k < 3; k++)
            p.axis_v[k] = p.direction[(k + 1) % 3] * p.axis_u[(k + 2) % 3] -
                          p.direction[(k + 2) % 3] * p.axis_u[(k + 1) % 3];
        const double u[3] = {-sin(i), 0, cos(i)}, v[3] = {0.8 * cos(i), -0.6, 0.8 * sin(i)};
        memcpy(p.axis_u, u, sizeof u);
        memcpy(p.axis_v, v, sizeof v);
        float rgb[3];
        lightprobe_specular(light_of(&p, 0.1, 0.1, 1), e, 0, 0, 0, rgb);
        least = fminf(least, rgb[1]);
        most = fmaxf(most, rgb[1]);
    }
    CHECK(most > 0 && most - least < 1e-4f * most, "%g to %g around", (double)least, (double)most);
}

const test_case specular_tests[] = {
    {"specular: a light's part of the lobe is that of a grid", part_of_the_lobe_is_exact},
    {"specular: small lights keep their digits", small_lights_keep_their_digits},
    {"specular: radiance is that of GGX over the light", radiance_is_that_of_ggx},
    {"specular: all light gives all reflectance", whole_reflectance_is_ggxs},
    {"specular: grazing reflectance goes on", grazing_reflectance_goes_on},
    {"specular: viewers below stand in the surface", viewers_below_stand_in_the_surface},
    {"specular: a light and the rest of the sphere make the whole",
     light_and_its_opposite_make_the_whole},
    {"specular: lights set without a step", setting_lights_fade},
    {"specular: lights end at their plane without a step", lights_end_at_their_plane},
    {"specular: lights of a panel shine as it is tilted", panels_shine_as_they_are_tilted},
    {"specular: any finite arguments give radiance", any_arguments_give_radiance},
    {"specular: arguments are clamped", arguments_are_clamped},
    {NULL, NULL},
};
