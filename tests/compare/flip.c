#include "flip.h"

#include <math.h>
#include <stdlib.h>

#include "../../examples/common/vec.h"

enum { RADIUS_MOST = 16 };
static const double pixels_a_degree = 67.02, pi = 3.14159265358979;

// ---- Colours ------------------------------------------------------------------------------------

// Linear Rec. 709 to XYZ, and back.
static const double to_xyz[3][3] = {{0.4124564, 0.3575761, 0.1804375},
                                    {0.2126729, 0.7151522, 0.0721750},
                                    {0.0193339, 0.1191920, 0.9503041}};
static const double to_rgb[3][3] = {{3.2404542, -1.5371385, -0.4985314},
                                    {-0.9692660, 1.8760108, 0.0415560},
                                    {0.0556434, -0.2040259, 1.0572252}};

typedef struct colour3 {
    double c[3];
} colour3;

static colour3 times(const double m[3][3], colour3 v)
{
    colour3 r;
    for (int i = 0; i < 3; i++) r.c[i] = m[i][0] * v.c[0] + m[i][1] * v.c[1] + m[i][2] * v.c[2];
    return r;
}

// XYZ in shares of white.
static colour3 relative_xyz(colour3 rgb)
{
    colour3 r = times(to_xyz, rgb);
    for (int i = 0; i < 3; i++) r.c[i] /= to_xyz[i][0] + to_xyz[i][1] + to_xyz[i][2];
    return r;
}

// Opponent space in which filtering is linear: YCxCz.
static colour3 opponent_of(colour3 rgb)
{
    const colour3 x = relative_xyz(rgb);
    return (colour3){{116 * x.c[1] - 16, 500 * (x.c[0] - x.c[1]), 200 * (x.c[1] - x.c[2])}};
}

static colour3 rgb_of(colour3 opponent)
{
    const double y = (opponent.c[0] + 16) / 116;
    colour3 x = {{y + opponent.c[1] / 500, y, y - opponent.c[2] / 200}};
    for (int i = 0; i < 3; i++) x.c[i] *= to_xyz[i][0] + to_xyz[i][1] + to_xyz[i][2];
    x = times(to_rgb, x);
    for (int i = 0; i < 3; i++) x.c[i] = fmin(fmax(x.c[i], 0), 1);
    return x;
}

static double lab_root(double t)
{
    const double d = 6.0 / 29;
    return t > d * d * d ? cbrt(t) : t / (3 * d * d) + 4.0 / 29;
}

// CIELAB whose chroma fades with the lightness (Hunt).
static colour3 lab_of(colour3 rgb)
{
    const colour3 x = relative_xyz(rgb);
    const double fx = lab_root(x.c[0]), fy = lab_root(x.c[1]), fz = lab_root(x.c[2]);
    const double light = 116 * fy - 16;
    return (colour3){{light, 0.01 * light * 500 * (fx - fy), 0.01 * light * 200 * (fy - fz)}};
}

// HyAB, raised to 0.7.
static double colour_distance(colour3 a, colour3 b)
{
    const double d = fabs(a.c[0] - b.c[0]) + hypot(a.c[1] - b.c[1], a.c[2] - b.c[2]);
    return pow(d, 0.7);
}

// In [0,1]; the largest distance is that of green and blue. Up to 0.4 of it takes up 0.95 of the
// range.
static double scaled_distance(double d)
{
    const colour3 green = {{0, 1, 0}}, blue = {{0, 0, 1}};
    const double most = colour_distance(lab_of(green), lab_of(blue)), knee = 0.4 * most;
    return d < knee ? 0.95 * d / knee : 0.95 + 0.05 * (d - knee) / (most - knee);
}

// ---- Filters ------------------------------------------------------------------------------------

typedef struct taps {
    int radius;
    double w[2 * RADIUS_MOST + 1];
} taps;

// Contrast sensitivity of a channel: a sum of Gaussians a sqrt(pi / b) exp(-pi^2 x^2 / b) of x
// degrees.
static taps gaussian_taps(double b)
{
    const double widest = 0.04; // the largest b sets the radius of all
    taps t = {(int)ceil(3 * sqrt(widest / (2 * pi * pi)) * pixels_a_degree), {0}};
    double sum = 0;
    for (int i = -t.radius; i <= t.radius; i++) {
        const double x = i / pixels_a_degree;
        sum += t.w[i + t.radius] = exp(-pi * pi * x * x / b);
    }
    for (int i = 0; i <= 2 * t.radius; i++) t.w[i] /= sum;
    return t;
}

// Detectors of edges (first derivative of a Gaussian) and points (second): positive and negative
// weights sum to 1 and -1. Order 0 is the Gaussian across.
static taps feature_taps(int order)
{
    const double sd = 0.5 * 0.082 * pixels_a_degree;
    taps t = {(int)ceil(3 * sd), {0}};
    double above = 0, below = 0;
    for (int i = -t.radius; i <= t.radius; i++) {
        const double x = i, g = exp(-x * x / (2 * sd * sd));
        const double w = order == 0 ? g : order == 1 ? -x * g : (x * x / (sd * sd) - 1) * g;
        t.w[i + t.radius] = w;
        above += fmax(w, 0);
        below -= fmin(w, 0);
    }
    for (int i = 0; i <= 2 * t.radius; i++) t.w[i] /= t.w[i] > 0 ? above : below > 0 ? below : 1;
    return t;
}

typedef struct plane {
    int width, height;
    double *v; // two planes: the second is for between two passes
} plane;

static double at(const plane *p, const double *v, int x, int y)
{
    x = x < 0 ? 0 : x >= p->width ? p->width - 1 : x;
    y = y < 0 ? 0 : y >= p->height ? p->height - 1 : y;
    return v[y * p->width + x];
}

// Along rows, then along columns.
static void filter(const plane *from, const taps *across, const taps *up, plane *to)
{
    const int count = from->width * from->height;
    double *between = to->v + count;
    for (int i = 0; i < count; i++) {
        double sum = 0;
        for (int k = -across->radius; k <= across->radius; k++)
            sum += across->w[k + across->radius] *
                   at(from, from->v, i % from->width + k, i / from->width);
        between[i] = sum;
    }
    for (int i = 0; i < count; i++) {
        double sum = 0;
        for (int k = -up->radius; k <= up->radius; k++)
            sum += up->w[k + up->radius] * at(from, between, i % from->width, i / from->width + k);
        to->v[i] = sum;
    }
}

// ---- The difference -----------------------------------------------------------------------------

enum { ACHROMATIC, RED_GREEN, BLUE_YELLOW, EDGE_X, EDGE_Y, POINT_X, POINT_Y, WORK, OTHER, PLANES };

typedef struct side {
    plane p[PLANES];
} side;

static void side_free(side *s)
{
    for (int i = 0; i < PLANES; i++) free(s->p[i].v);
}

static int side_create(side *s, int width, int height)
{
    int made = 1;
    for (int i = 0; i < PLANES; i++) {
        s->p[i] = (plane){width, height, NULL};
        s->p[i].v = malloc(2 * (size_t)width * (size_t)height * sizeof *s->p[i].v);
        made = made && s->p[i].v;
    }
    return made;
}

// A channel seen from afar: the weighted mean of two Gaussians.
static void blur(side *s, int channel, double b, double other_b, double other_share)
{
    const int count = s->p[0].width * s->p[0].height;
    const taps one = gaussian_taps(b), other = gaussian_taps(other_b);
    filter(&s->p[channel], &one, &one, &s->p[WORK]);
    filter(&s->p[channel], &other, &other, &s->p[OTHER]);
    for (int i = 0; i < count; i++)
        s->p[channel].v[i] = (1 - other_share) * s->p[WORK].v[i] + other_share * s->p[OTHER].v[i];
}

static colour3 channels_at(const side *s, int i)
{
    return (colour3){{s->p[0].v[i], s->p[1].v[i], s->p[2].v[i]}};
}

// Features of what lies there, then colours as seen from afar.
static void prepare(side *s, const image *of)
{
    const taps flat = feature_taps(0), edge = feature_taps(1), point = feature_taps(2);
    const int count = of->width * of->height;
    for (int i = 0; i < count; i++) {
        colour3 c;
        for (int k = 0; k < 3; k++) c.c[k] = fmin(fmax((double)of->rgb[3 * i + k], 0), 1);
        c = opponent_of(c);
        for (int k = 0; k < 3; k++) s->p[k].v[i] = c.c[k];
    }
    filter(&s->p[ACHROMATIC], &edge, &flat, &s->p[EDGE_X]);
    filter(&s->p[ACHROMATIC], &flat, &edge, &s->p[EDGE_Y]);
    filter(&s->p[ACHROMATIC], &point, &flat, &s->p[POINT_X]);
    filter(&s->p[ACHROMATIC], &flat, &point, &s->p[POINT_Y]);
    // A Gaussian of weight a has a volume in proportion to a sqrt(b).
    const double first = 34.1 * sqrt(0.04), second = 13.5 * sqrt(0.025);
    blur(s, ACHROMATIC, 0.0047, 0.0047, 0);
    blur(s, RED_GREEN, 0.0053, 0.0053, 0);
    blur(s, BLUE_YELLOW, 0.04, 0.025, second / (first + second));
}

// The strength of edges or points, of lightness in [0,1].
static double feature_at(const side *s, int x, int y, int i)
{
    return hypot(s->p[x].v[i], s->p[y].v[i]) / 116;
}

double flip_mean(const image *a, const image *b)
{
    const int count = a->width * a->height;
    side s[2];
    double sum = 0;
    const int made =
        side_create(&s[0], a->width, a->height) & side_create(&s[1], a->width, a->height);
    if (made) prepare(&s[0], a);
    if (made) prepare(&s[1], b);
    for (int i = 0; i < count && made; i++) {
        const double colour = scaled_distance(colour_distance(
            lab_of(rgb_of(channels_at(&s[0], i))), lab_of(rgb_of(channels_at(&s[1], i)))));
        const double edges =
            fabs(feature_at(&s[0], EDGE_X, EDGE_Y, i) - feature_at(&s[1], EDGE_X, EDGE_Y, i));
        const double points =
            fabs(feature_at(&s[0], POINT_X, POINT_Y, i) - feature_at(&s[1], POINT_X, POINT_Y, i));
        const double feature = sqrt(fmin(fmax(edges, points) / sqrt(2), 1));
        sum += pow(colour, 1 - feature) / count;
    }
    side_free(&s[0]);
    side_free(&s[1]);
    return made ? sum : NAN;
}
