// What an eye sees of errors and their mean does not say: visibility that falls where the truth
// rises, errors that change from one texel to the next, and the difference of pictures.
#include "measure.h"

#include "../support/test.h"
#include "flip.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 256 };

// ---- Rows outwards over the shadow of one convex caster -----------------------------------------

enum { CASTERS = 6, ROWS = 20, STEPS = 80, ROW_RECEIVERS = ROWS * STEPS, LIGHTS = 4 };
static const float row_tangents[LIGHTS] = {0.05f, 0.1f, 0.2f, 0.4f};
static const double fall_seen = 0.03;

typedef struct falls {
    int rows, falling[METHODS_MOST];
    double deepest[METHODS_MOST];
} falls;

// A turned box over a floor that is in the map, or over one that is not.
static bool convex_case(compare_case *c, int which, message *why)
{
    uint64_t state = 100 + (uint64_t)which;
    memset(c, 0, sizeof *c);
    snprintf(c->name, sizeof c->name, "one box");
    c->closed = true;
    c->moving = -1;
    c->ground = which % 2 ? 0 : (float)NAN;
    c->sun = vec_unit(vec(0.2f * (float)(which / 2), 1, 0.1f * (float)(which / 2)));
    scene_begin_object(&c->scene, 0.5f, 0.5f, 0.5f);
    const scene_frame f = scene_frame_at(vec(0, 0.75f, 0), (float)test_range(&state, 0, 3),
                                         (float)test_range(&state, 0, 1.5));
    scene_put_box(&c->scene, &f, vec(0.25f, 0.22f, 0.28f));
    const scene_frame floor_frame = scene_frame_at(vec(0, -0.05f, 0), 0, 0);
    if (which % 2 == 0) scene_put_box(&c->scene, &floor_frame, vec(1.5f, 0.05f, 1.5f));
    if (!scene_end(&c->scene)) return fail(why, "no memory for a box");
    c->tree = bvh_create(&c->scene);
    return c->tree || fail(why, "no memory for a box");
}

static void fill_rows(const compare_case *c, receiver *r)
{
    const vec3 middle = vec_mad(vec(0, 0.75f, 0), c->sun, -0.75f / c->sun.y);
    for (int i = 0; i < ROW_RECEIVERS; i++) {
        const float a = 2 * VEC_PI * (float)(i / STEPS) / ROWS,
                    d = 0.9f * (float)(i % STEPS) / STEPS;
        r[i].point = vec(middle.x + d * cosf(a), 0, middle.z + d * sinf(a));
        r[i].normal = vec(0, 1, 0);
    }
}

// The truth never falls outwards; what its rays' noise does is taken off.
static double deepest_fall(const float *v, const receiver *r)
{
    float top = 0, top_truth = 0;
    double deepest = 0;
    for (int i = 0; i < STEPS; i++) {
        top = fmaxf(top, v[i]);
        top_truth = fmaxf(top_truth, r[i].truth);
        deepest = fmax(deepest, (double)(top - v[i]) - (double)(top_truth - r[i].truth));
    }
    return deepest;
}

static bool rows_of(measurement *m, bench *b, int which, float tangent, falls *sum, message *why)
{
    static receiver r[ROW_RECEIVERS];
    static float value[METHODS_MOST * ROW_RECEIVERS];
    compare_case c;
    if (!convex_case(&c, which, why)) return false;
    const bool done = bench_update(b, &c, tangent, why);
    fill_rows(&c, r);
    if (done) case_truth(&c, &b->light, ROW_RECEIVERS, m->quick ? 196 : 400, 1, r);
    if (done) bench_evaluate(b, m->bias, r, ROW_RECEIVERS, value);
    for (int i = 0; i < method_count * ROWS && done; i++) {
        const int who = i / ROWS, row = i % ROWS * STEPS;
        const double fall = deepest_fall(value + who * ROW_RECEIVERS + row, r + row);
        sum->falling[who] += fall > fall_seen;
        sum->deepest[who] = fmax(sum->deepest[who], fall);
    }
    sum->rows += ROWS;
    case_free(&c);
    return done;
}

static bool measure_rows(measurement *m, bench *b, message *why)
{
    falls sum;
    bool done = true;
    memset(&sum, 0, sizeof sum);
    for (int i = 0; i < CASTERS * LIGHTS && done; i++) {
        if (m->quick && i / LIGHTS >= 2) break;
        done = rows_of(m, b, i / LIGHTS, row_tangents[i % LIGHTS], &sum, why);
    }
    for (int i = 0; i < method_count && done; i++) {
        const double share = 100.0 * sum.falling[i] / sum.rows, deepest = sum.deepest[i];
        put(m, "eye", "all", methods[i].name, 0, "falling_rows", share, share, share);
        put(m, "eye", "all", methods[i].name, 0, "deepest_fall", deepest, deepest, deepest);
    }
    return done;
}

// ---- Neighbours ---------------------------------------------------------------------------------

enum { PAIRS = 400 };

typedef struct structure {
    double squares[METHODS_MOST];
    int pairs;
} structure;

// Whether a surface is there, and nothing over it.
static bool is_on_surface(const compare_case *c, const receiver *r, float texel)
{
    const float high = 0.5f * texel;
    const float hit =
        bvh_hit_nearest(c->tree, vec_mad(r->point, r->normal, high), vec_scale(r->normal, -1));
    if (fabsf(r->point.y - c->ground) < 1e-5f) return hit > 0.99f * high;
    return fabsf(hit - high) < 0.05f * high;
}

// A texel further on the tangent plane, anywhere around.
static void step_aside(const mssm_light *light, receiver *r, int count)
{
    uint64_t state = 5;
    const float texel = 2 * light->extent_u / SIDE;
    for (int i = 0; i < count; i++) {
        const vec3 n = r[i].normal;
        const vec3 u = vec_unit(vec_cross(fabsf(n.y) < 0.9f ? vec(0, 1, 0) : vec(1, 0, 0), n));
        const vec3 v = vec_cross(n, u);
        const float a = (float)test_range(&state, 0, 6.2831853);
        r[i].point = vec_mad(vec_mad(r[i].point, u, texel * cosf(a)), v, texel * sinf(a));
    }
}

static bool pairs_of(measurement *m, bench *b, int which, float tangent, structure *sum,
                     message *why)
{
    static receiver r[2][PAIRS];
    static float value[2][METHODS_MOST * PAIRS];
    const int count = m->quick ? PAIRS / 4 : PAIRS, rays = m->quick ? 144 : 400;
    compare_case c;
    message missing;
    if (!case_make(&c, which, m->data, &missing))
        return true; // a mesh that is not here: said before
    bool done = bench_update(b, &c, tangent, why);
    const bool seen = done && case_receivers(&c, &b->light, count, rays, 21, r[0]);
    if (seen) {
        memcpy(r[1], r[0], sizeof r[0]);
        step_aside(&b->light, r[1], count);
        case_truth(&c, &b->light, count, rays, 21,
                   r[1]); // the same rays: their noise mostly cancels
        for (int i = 0; i < 2; i++) bench_evaluate(b, m->bias, r[i], count, value[i]);
    }
    const float texel = 2 * b->light.extent_u / SIDE;
    for (int i = 0; i < method_count * count && seen; i++) {
        const int k = i % count;
        if (!is_on_surface(&c, &r[1][k], texel)) continue; // over an edge, or inside something
        if (i < count) sum->pairs++;
        const double a = (double)value[0][i] - (double)r[0][k].truth;
        sum->squares[i / count] += pow(a - ((double)value[1][i] - (double)r[1][k].truth), 2);
    }
    case_free(&c);
    return done;
}

static bool measure_structure(measurement *m, bench *b, message *why)
{
    structure sum;
    bool done = true;
    memset(&sum, 0, sizeof sum);
    for (int which = 0; which < CASE_COUNT + CASE_NEW && done; which++) {
        for (int l = 0; l < 2 && done; l++)
            done = pairs_of(m, b, which, l ? 0.4f : 0.1f, &sum, why);
    }
    for (int i = 0; i < method_count && done; i++) {
        const double rms = sqrt(sum.squares[i] / sum.pairs);
        put(m, "eye", "all", methods[i].name, 0, "structure", rms, rms, rms);
    }
    return done;
}

// ---- Pictures -----------------------------------------------------------------------------------

enum { WIDTH = 320, HEIGHT = 180, ROOM = WIDTH * HEIGHT * (VIEW_SAMPLES + 1) };

// The surfaces of a picture, as receivers in the order of its pixels.
typedef struct picture {
    receiver *r;
    float *share, *albedo, *value; // of the pixel; luminance of the surface; by method
    int *pixel, count;
    image truth, seen;
} picture;

static void picture_free(picture *p)
{
    free(p->r);
    free(p->share);
    free(p->albedo);
    free(p->value);
    free(p->pixel);
    image_free(&p->truth);
    image_free(&p->seen);
}

static void add_surface(picture *p, int at, vec3 point, vec3 normal, float share, float albedo)
{
    p->r[p->count] = (receiver){point, normal, 0, 0};
    p->share[p->count] = share;
    p->albedo[p->count] = albedo;
    p->pixel[p->count++] = at;
}

static void collect(picture *p, const compare_case *c, const view *v, const camera *eye)
{
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const int x = i % WIDTH, y = i / WIDTH;
        surface found[VIEW_SAMPLES];
        const int count = view_surfaces(v, &c->scene, x, y, found);
        float rest = 1;
        for (int k = 0; k < count; k++) {
            add_surface(p, i, found[k].position, found[k].normal, found[k].share,
                        vec_luminance(c->scene.albedo[found[k].object]));
            rest -= found[k].share;
        }
        const vec3 ray = camera_ray(eye, ((float)x + 0.5f) / WIDTH, ((float)y + 0.5f) / HEIGHT);
        const float away = (c->ground - eye->position.y) / ray.y;
        if (rest > 0.01f && away > 0)
            add_surface(p, i, vec_mad(eye->position, ray, away), vec(0, 1, 0), rest, 0.6f);
    }
}

static bool picture_create(picture *p, const compare_case *c, vec3 from, vec3 to)
{
    const camera eye = camera_look(from, to, 0.57f, (float)WIDTH / HEIGHT);
    view v;
    memset(p, 0, sizeof *p);
    p->r = malloc(ROOM * sizeof *p->r);
    p->share = malloc(ROOM * sizeof *p->share);
    p->albedo = malloc(ROOM * sizeof *p->albedo);
    p->pixel = malloc(ROOM * sizeof *p->pixel);
    if (!p->r || !p->share || !p->albedo || !p->pixel || !image_create(&p->truth, WIDTH, HEIGHT) ||
        !image_create(&p->seen, WIDTH, HEIGHT) || !view_create(&v, &c->scene, &eye, WIDTH, HEIGHT))
        return false;
    collect(p, c, &v, &eye);
    view_free(&v);
    p->value = malloc((size_t)p->count * (size_t)method_count * sizeof *p->value);
    return p->value;
}

// Grey, by the light and a little from all around; value NULL: the truth.
static void shade(const picture *p, vec3 sun, const float *value, image *to)
{
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) to->rgb[i] = 0;
    for (int i = 0; i < p->count; i++) {
        const float seen = value ? value[i] : p->r[i].truth;
        const float light = 0.15f + 0.9f * fmaxf(vec_dot(p->r[i].normal, sun), 0) * seen;
        for (int k = 0; k < 3; k++)
            to->rgb[3 * p->pixel[i] + k] += p->share[i] * p->albedo[i] * light;
    }
}

static bool flip_of(measurement *m, bench *b, int which, vec3 from, vec3 to, double *sum,
                    message *why)
{
    compare_case c;
    picture p;
    if (!case_make(&c, which, m->data, why)) return false;
    bool done = bench_update(b, &c, 0.25f, why);
    if (done && !picture_create(&p, &c, from, to)) {
        done = fail(why, "no memory for pictures");
        picture_free(&p);
    } else if (done) {
        case_truth(&c, &b->light, p.count, m->quick ? 36 : 196, 9, p.r);
        bench_evaluate(b, m->bias, p.r, p.count, p.value);
        shade(&p, c.sun, NULL, &p.truth);
        for (int i = 0; i < method_count; i++) {
            shade(&p, c.sun, p.value + i * p.count, &p.seen);
            sum[i] += flip_mean(&p.truth, &p.seen);
        }
        picture_free(&p);
    }
    case_free(&c);
    return done;
}

// The two scenes that pictures.c draws, as it sees them.
static bool measure_flip(measurement *m, bench *b, message *why)
{
    double sum[METHODS_MOST] = {0};
    const bool done = flip_of(m, b, 11, vec(0.3f, 3.1f, 6.6f), vec(0, 0.75f, 0.3f), sum, why) &&
                      flip_of(m, b, 4, vec(1.5f, 2.6f, 4.6f), vec(-0.1f, 0.35f, 0.2f), sum, why);
    for (int i = 0; i < method_count && done; i++)
        put(m, "eye", "all", methods[i].name, 0, "flip", sum[i] / 2, sum[i] / 2, sum[i] / 2);
    return done;
}

bool measure_eye(measurement *m, message *why)
{
    bench b;
    if (!measure_biases(m, why)) return false;
    bool done = bench_create(&b, SIDE, why) && measure_rows(m, &b, why);
    if (done) done = measure_structure(m, &b, why);
    if (done) done = measure_flip(m, &b, why);
    bench_free(&b);
    return done;
}
