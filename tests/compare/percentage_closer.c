// Methods that compare the depth map texel by texel: hard shadows, percentage-closer filtering,
// percentage-closer soft shadows from samples or from all texels, and back-projection.
#include "rivals.h"

#include <stdint.h>

typedef struct state {
    view view;
    int samples;
    ring_sample sample[SAMPLES_MAX];
    int radius;
    float weight[TAPS_MOST]; // of a Gaussian
} state;

// ---- the pattern of samples --------------------------------------------------------------------

// The Apelles thesis rotates a disc that a square pattern was mapped to, by a random angle for
// every pixel. Its lights are discs. For a square light the same rotation is mapped back to the
// square (Shirley and Chiu 1997), where it slides samples along concentric squares.
static float turn_of(unsigned pixel)
{
    uint32_t h = pixel * 2654435761u;
    h = (h ^ (h >> 15)) * 2246822519u;
    h = (h ^ (h >> 13)) * 3266489917u;
    h ^= h >> 16;
    return (float)(h >> 8) * (8.0f / 16777216.0f);
}

// Along the perimeter of the unit square: the first coordinate of the point at 0 <= at < 8.
static float on_perimeter(float at)
{
    return limited(fabsf(at - 4) - 2, -1, 1);
}

// The samples as a pixel sees them, turned.
typedef struct pattern {
    float u[SAMPLES_MAX], v[SAMPLES_MAX];
} pattern;

static void turn_pattern(const state *p, float turn, pattern *to)
{
    for (int i = 0; i < p->samples; i++) {
        float at = p->sample[i].at + turn;
        at -= at >= 8 ? 8.0f : 0.0f;
        const float after = at + (at < 2 ? 6.0f : -2.0f);
        to->u[i] = p->sample[i].ring * on_perimeter(at);
        to->v[i] = p->sample[i].ring * on_perimeter(after);
    }
}

// Depth of the texel at (x, y); 1 outside of the map. Without a branch: samples of one kernel fall
// on both sides of the border at random.
static inline float depth_at(const view *v, float x, float y)
{
    const float end = (float)v->side;
    const bool in = (x >= 0) & (x < end) & (y >= 0) & (y < end);
    const size_t at = in ? (size_t)((int)y * v->side + (int)x) : 0;
    const float z = v->depth[at];
    return in ? z : 1;
}

// ---- all texels of a rectangle -----------------------------------------------------------------

// What a kernel holds nearer than the receiver: area in texels, and the sum of depths over it.
typedef struct blockers {
    float area, depths;
} blockers;

// x where the comparison held, 0 elsewhere.
static inline floats where(ints held, floats x)
{
    return (floats)(held & (ints)x);
}

static inline float sum_of(floats x)
{
    return (x[0] + x[1]) + (x[2] + x[3]);
}

// One texel after the other, as the library's own code is: two at a time, which is as fast as this
// gets without vectors.
static blockers blockers_of_row(const float *depth, int count, float limit)
{
    int n = 0, i = 0;
    float a = 0, b = 0;
    for (; i + 2 <= count; i += 2) {
        const float y = depth[i], z = depth[i + 1];
        n += (y < limit) + (z < limit);
        a += y < limit ? y : 0.0f;
        b += z < limit ? z : 0.0f;
    }
    if (i < count) {
        n += depth[i] < limit;
        a += depth[i] < limit ? depth[i] : 0.0f;
    }
    const blockers all = {(float)n, a + b};
    return all;
}

// The same in vectors of four.
static blockers blockers_of_row_4(const float *depth, int count, float limit)
{
    ints n = {0}, m = {0}; // less the number
    floats a = {0}, b = {0};
    int i = 0;
    for (; i + 2 * LANES <= count; i += 2 * LANES) {
        const floats y = load(depth + i), z = load(depth + i + LANES);
        n += y < limit;
        m += z < limit;
        a += where(y < limit, y);
        b += where(z < limit, z);
    }
    n += m;
    blockers all = blockers_of_row(depth + i, count - i, limit);
    all.area -= (float)(n[0] + n[1] + n[2] + n[3]);
    all.depths += sum_of(a + b);
    return all;
}

static void take_off(blockers *b, float depth, float limit, float share)
{
    b->area -= depth < limit ? share : 0.0f;
    b->depths -= depth < limit ? share * depth : 0.0f;
}

// The nearer texels of the kernel, its border by the part that lies inside. Empty texels (1) never
// block.
static blockers blockers_in(const view *v, const place *r, kernel k, bool vectors)
{
    const strips x = strips_of(r->x, k.u, v->side), y = strips_of(r->y, k.v, v->side);
    const int count = x.edge[3] - x.edge[0];
    const float limit = least(r->z, 1);
    blockers all = {0, 0};
    if (count <= 0) return all;
    for (int j = y.edge[0]; j < y.edge[3]; j++) {
        const float *depth = v->depth + (size_t)j * (size_t)v->side + (size_t)x.edge[0];
        blockers row =
            vectors ? blockers_of_row_4(depth, count, limit) : blockers_of_row(depth, count, limit);
        if (x.edge[1] > x.edge[0]) take_off(&row, depth[0], limit, 1 - x.first);
        if (x.edge[3] > x.edge[2]) take_off(&row, depth[count - 1], limit, 1 - x.last);
        const float share = j < y.edge[1] ? y.first : j >= y.edge[2] ? y.last : 1;
        all.area += share * row.area;
        all.depths += share * row.depths;
    }
    return all;
}

static float visible_share(const view *v, const place *r, kernel k, bool vectors)
{
    return limited(1 - blockers_in(v, r, k, vectors).area / (4 * k.u * k.v), 0, 1);
}

// ---- the methods -------------------------------------------------------------------------------

void *percentage_closer_create(const struct method *m, int side, size_t *bytes)
{
    state *p = view_create(sizeof *p, side);
    if (!p) return NULL;
    p->samples = m->variant < SAMPLES_MAX ? m->variant : SAMPLES_MAX;
    poisson_pattern(p->samples, p->sample);
    *bytes = view_bytes(side);
    return p;
}

void percentage_closer_destroy(void *state_)
{
    view_destroy(state_);
}

void percentage_closer_update(void *state_, const depth_map *map)
{
    view_update(state_, map);
}

// Williams 1978: the nearest texel decides.
float hard_visibility(const void *state_, const float point[3], float bias, unsigned pixel)
{
    const state *p = state_;
    place r;
    (void)pixel;
    if (!place_of(&p->view, point, bias, &r)) return 1;
    return depth_at(&p->view, r.x, r.y) < least(r.z, 1) ? 0.0f : 1.0f;
}

// Reeves, Salesin and Cook 1987, the same kernel everywhere: 5 by 5 texels around the receiver,
// with partial texels at the border, which is what 16 bilinear comparisons of a GPU give.
float pcf_visibility(const void *state_, const float point[3], float bias, unsigned pixel)
{
    const state *p = state_;
    const kernel five = {2.5f, 2.5f};
    place r;
    (void)pixel;
    return place_of(&p->view, point, bias, &r) ? visible_share(&p->view, &r, five, false) : 1;
}

// Shares of the texels along one axis under a Gaussian that stands at a place between them: one
// more than it has taps. Returns the first texel.
static int shares_at(const state *p, float at, float share[TAPS_MOST + 1])
{
    const int taps = 2 * p->radius + 1;
    const float first = floorf(at - 0.5f), rest = at - 0.5f - first;
    float before = 0;
    for (int i = 0; i <= taps; i++) {
        const float now = i < taps ? p->weight[i] : 0;
        share[i] = (1 - rest) * now + rest * before;
        before = now;
    }
    return (int)first - p->radius;
}

void *gaussian_create(const struct method *m, int side, size_t *bytes)
{
    state *p = percentage_closer_create(m, side, bytes);
    if (!p) return NULL;
    p->radius = m->variant;
    gaussian(p->radius, p->weight);
    return p;
}

// Every texel under a Gaussian, each compared with its neighbours bilinearly as by a GPU: the
// kernel of a blurred map read bilinearly. In vectors of four.
float gaussian_visibility(const void *state_, const float point[3], float bias, unsigned pixel)
{
    const state *p = state_;
    const view *v = &p->view;
    float across[TAPS_MOST + 1], up[TAPS_MOST + 1], blocked = 0;
    place r;
    (void)pixel;
    if (!place_of(v, point, bias, &r)) return 1;
    const float limit = least(r.z, 1);
    const int x0 = shares_at(p, r.x, across), y0 = shares_at(p, r.y, up), taps = 2 * p->radius + 2;
    const int first = x0 < 0 ? -x0 : 0, last = x0 + taps > v->side ? v->side - x0 : taps;
    for (int j = y0 < 0 ? -y0 : 0; j < taps && y0 + j < v->side; j++) {
        const float *depth = v->depth + (size_t)(y0 + j) * (size_t)v->side;
        floats row = {0};
        int i = first;
        for (; i + LANES <= last; i += LANES)
            row += where(load(depth + (x0 + i)) < limit, load(across + i));
        float sum = sum_of(row);
        for (; i < last; i++) sum += depth[x0 + i] < limit ? across[i] : 0;
        blocked += up[j] * sum;
    }
    return limited(1 - blocked, 0, 1);
}

// Fernando 2005 with as many samples for the blocker search as for the filter.
float pcss_sampled_visibility(const void *state_, const float point[3], float bias, unsigned pixel)
{
    const state *p = state_;
    const view *v = &p->view;
    place r;
    if (!place_of(v, point, bias, &r)) return 1;
    const float limit = least(r.z, 1);
    pattern at;
    turn_pattern(p, turn_of(pixel), &at);
    kernel k = kernel_of(v, &r, -1);
    float sum = 0;
    int found = 0;
    for (int i = 0; i < p->samples; i++) {
        const float z = depth_at(v, r.x + k.u * at.u[i], r.y + k.v * at.v[i]);
        found += z < limit;
        sum += z < limit ? z : 0;
    }
    if (found == 0) return 1;
    k = kernel_of(v, &r, limited(sum / (float)found, -1, r.z));
    int blocked = 0;
    for (int i = 0; i < p->samples; i++) {
        blocked += depth_at(v, r.x + k.u * at.u[i], r.y + k.v * at.v[i]) < limit;
    }
    return 1 - (float)blocked / (float)p->samples;
}

// The same from all texels. The variant says whether in vectors.
float pcss_visibility(const void *state_, const float point[3], float bias, unsigned pixel)
{
    const state *p = state_;
    const bool vectors = p->samples > 0;
    place r;
    (void)pixel;
    if (!place_of(&p->view, point, bias, &r)) return 1;
    kernel k = kernel_of(&p->view, &r, -1);
    const blockers found = blockers_in(&p->view, &r, k, vectors);
    if (found.area <= 0) return 1;
    // The filter's kernel lies inside: nothing but blockers here is nothing but blockers there.
    if (found.area >= 4 * k.u * k.v * (1 - 1e-5f)) return 0;
    k = kernel_of(&p->view, &r, limited(found.depths / found.area, -1, r.z));
    return visible_share(&p->view, &r, k, vectors);
}

// How depth changes from texel to texel along the receiver's plane.
typedef struct slope {
    float x, y;
} slope;

// Rows of the view are orthogonal: one over its square leads a texel, or a unit of depth, further.
static slope slope_of(const view *v, const float normal[3])
{
    float along[3];
    for (int i = 0; i < 3; i++) {
        const float *row = v->row[i];
        along[i] = (normal[0] * row[0] + normal[1] * row[1] + normal[2] * row[2]) /
                   (row[0] * row[0] + row[1] * row[1] + row[2] * row[2]);
    }
    const float steep = 1000 * v->texel; // the light grazes it; also keeps 0 / 0 out
    const slope s = {limited(-along[0] / along[2], -steep, steep),
                     limited(-along[1] / along[2], -steep, steep)};
    return s;
}

// blockers_of_row_4 of texels before the plane, which has the depth at in the first one.
static blockers blockers_of_row_before(const float *depth, int count, float at, float step,
                                       float limit)
{
    const floats ramp = {0, 1, 2, 3}, most_ = all_of(limit);
    floats plane = all_of(at) + ramp * all_of(step), a = {0};
    ints n = {0}; // less the number
    blockers all = {0, 0};
    int i = 0;
    for (; i + LANES <= count; i += LANES, plane += all_of(LANES * step)) {
        const floats z = load(depth + i);
        const ints nearer = (z < plane) & (z < most_);
        n += nearer;
        a += where(nearer, z);
    }
    for (; i < count; i++) take_off(&all, depth[i], least(at + (float)i * step, limit), -1);
    all.area -= (float)(n[0] + n[1] + n[2] + n[3]);
    all.depths += sum_of(a);
    return all;
}

// blockers_in of texels that are nearer than the receiver and before its plane.
static blockers blockers_before(const view *v, const place *r, kernel k, slope s)
{
    const strips x = strips_of(r->x, k.u, v->side), y = strips_of(r->y, k.v, v->side);
    const int count = x.edge[3] - x.edge[0];
    const float limit = least(r->z, 1);
    blockers all = {0, 0};
    if (count <= 0) return all;
    for (int j = y.edge[0]; j < y.edge[3]; j++) {
        const float *depth = v->depth + (size_t)j * (size_t)v->side + (size_t)x.edge[0];
        const float at =
            r->z + s.y * ((float)j + 0.5f - r->y) + s.x * ((float)x.edge[0] + 0.5f - r->x);
        const float end = least(at + s.x * (float)(count - 1), limit);
        blockers row = blockers_of_row_before(depth, count, at, s.x, limit);
        if (x.edge[1] > x.edge[0]) take_off(&row, depth[0], least(at, limit), 1 - x.first);
        if (x.edge[3] > x.edge[2]) take_off(&row, depth[count - 1], end, 1 - x.last);
        const float share = j < y.edge[1] ? y.first : j >= y.edge[2] ? y.last : 1;
        all.area += share * row.area;
        all.depths += share * row.depths;
    }
    return all;
}

// The bias follows the receiver's plane, as a wide kernel asks for (Isidoro 2006): with one bias
// for the whole map, sloping ground shadows itself or a caster near it is lost.
static float pcss_plane_visibility(const view *v, const float point[3], const float normal[3],
                                   float bias)
{
    place r;
    if (!place_of(v, point, bias, &r)) return 1;
    const slope s = slope_of(v, normal);
    kernel k = kernel_of(v, &r, -1);
    const blockers found = blockers_before(v, &r, k, s);
    if (found.area <= 0) return 1;
    if (found.area >= 4 * k.u * k.v * (1 - 1e-5f)) return 0;
    k = kernel_of(v, &r, limited(found.depths / found.area, -1, r.z));
    return limited(1 - blockers_before(v, &r, k, s).area / (4 * k.u * k.v), 0, 1);
}

void pcss_plane_many(const void *state_, int count, const float (*points)[3],
                     const float (*normals)[3], float bias, float *out)
{
    const state *p = state_;
    for (int i = 0; i < count; i++)
        out[i] = pcss_plane_visibility(&p->view, points[i], normals[i], bias);
}

// The part of the light that a texel hides, both as lengths along one axis: the texel reaches from
// low to low + 1 around the receiver, the light as seen through its depth from -half to half.
static inline float hidden(float low, float half)
{
    const float a = low > -half ? low : -half, b = low + 1 < half ? low + 1 : half;
    return b > a ? b - a : 0.0f;
}

// The receiver's plane has the depth at beside x = 0.
static float hidden_by_row(const view *v, const place *r, int x0, int x1, float low_v,
                           const float *depth, float at, float step)
{
    const float limit = least(r->z, 1);
    float sum = 0;
    for (int x = x0; x < x1; x++) {
        const float z = depth[x];
        if (!(z < least(at + step * (float)x, limit))) continue;
        const float distance = r->z - most(z, -1);
        const float u = most(v->wide_u * distance, 0.5f), w = most(v->wide_v * distance, 0.5f);
        const float part = hidden((float)x - r->x, u);
        if (part > 0) sum += part * hidden(low_v, w) / (4 * u * w);
    }
    return sum;
}

// Guennebaud, Barthe and Paulin 2006: every texel of the search region is a small rectangle that
// hides what it covers of the light. Texels do not overlap as seen from the receiver of a flat
// blocker; at several depths they do, and are counted twice, up to 1. Stretching texels to their left
// and lower neighbours, the paper's way to fill gaps, raises the error over the chart's scenes by a
// third (with normals .037 to .050, of receivers of its own); so it is left out.
static float back_projection(const view *v, const float point[3], const float normal[3], float bias)
{
    place r;
    if (!place_of(v, point, bias, &r)) return 1;
    const slope flat = {0, 0}, s = normal ? slope_of(v, normal) : flat;
    const kernel k = kernel_of(v, &r, -1);
    const strips x = strips_of(r.x, k.u, v->side), y = strips_of(r.y, k.v, v->side);
    float occlusion = 0;
    for (int j = y.edge[0]; j < y.edge[3] && occlusion < 1; j++) {
        const float at = r.z + s.y * ((float)j + 0.5f - r.y) + s.x * (0.5f - r.x);
        occlusion += hidden_by_row(v, &r, x.edge[0], x.edge[3], (float)j - r.y,
                                   v->depth + (size_t)j * (size_t)v->side, at, s.x);
    }
    return limited(1 - occlusion, 0, 1);
}

float back_projection_visibility(const void *state_, const float point[3], float bias,
                                 unsigned pixel)
{
    const state *p = state_;
    (void)pixel;
    return back_projection(&p->view, point, NULL, bias);
}

void back_projection_many(const void *state_, int count, const float (*points)[3],
                          const float (*normals)[3], float bias, float *out)
{
    const state *p = state_;
    for (int i = 0; i < count; i++) out[i] = back_projection(&p->view, points[i], normals[i], bias);
}
