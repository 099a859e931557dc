#include "raytrace.h"

#include "threads.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

// ---- The tree: split where the surface area heuristic says, leaves of up to four triangles

typedef struct bvh_node {
    vec3 low, high;
    int first; // a leaf's first triangle, or the first of two children
    int count; // triangles of a leaf, 0 for inner nodes
} bvh_node;

typedef struct bvh_triangle {
    vec3 a, ab, ac;
} bvh_triangle;

struct bvh {
    bvh_node *node;
    bvh_triangle *triangle;
    int nodes;
};

typedef struct item {
    vec3 low, high, centre;
    int triangle;
} item;

enum { BINS = 16, LEAF = 4, DEPTH_MOST = 64 };

static float axis_of(vec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

static float box_area(vec3 low, vec3 high)
{
    const vec3 d = vec_sub(high, low);
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

static void bounds_of(const item *items, int count, bool centres, vec3 *low, vec3 *high)
{
    *low = vec(HUGE_VALF, HUGE_VALF, HUGE_VALF);
    *high = vec_scale(*low, -1);
    for (int i = 0; i < count; i++) {
        *low = vec_min(*low, centres ? items[i].centre : items[i].low);
        *high = vec_max(*high, centres ? items[i].centre : items[i].high);
    }
}

static int bin_of(const item *it, int axis, float low, float scale)
{
    const int bin = (int)((axis_of(it->centre, axis) - low) * scale);
    return bin < BINS ? bin : BINS - 1;
}

typedef struct bin {
    vec3 low, high;
    int count;
} bin;

static void bin_add(bin *to, vec3 low, vec3 high, int count)
{
    to->low = to->count ? vec_min(to->low, low) : low;
    to->high = to->count ? vec_max(to->high, high) : high;
    to->count += count;
}

// The cheapest border between bins along one axis; *cost is lowered when this axis beats it.
static int best_split(const item *items, int count, int axis, float low, float scale, float *cost)
{
    bin bins[BINS] = {{{0, 0, 0}, {0, 0, 0}, 0}}, sum = bins[0];
    float right_cost[BINS];
    int best = -1;
    for (int i = 0; i < count; i++) {
        bin_add(&bins[bin_of(items + i, axis, low, scale)], items[i].low, items[i].high, 1);
    }
    for (int i = BINS - 1; i > 0; i--) {
        if (bins[i].count) bin_add(&sum, bins[i].low, bins[i].high, bins[i].count);
        right_cost[i] = sum.count ? box_area(sum.low, sum.high) * (float)sum.count : 0;
    }
    sum.count = 0;
    for (int i = 0; i + 1 < BINS; i++) {
        if (bins[i].count) bin_add(&sum, bins[i].low, bins[i].high, bins[i].count);
        if (sum.count == 0 || sum.count == count) continue;
        const float total = box_area(sum.low, sum.high) * (float)sum.count + right_cost[i + 1];
        if (total < *cost) {
            *cost = total;
            best = i;
        }
    }
    return best;
}

// Orders the items and returns how many go left.
static int partition(item *items, int count)
{
    vec3 low, high;
    int best_axis = -1, best_bin = -1;
    float best_cost = HUGE_VALF;
    bounds_of(items, count, true, &low, &high);
    for (int axis = 0; axis < 3; axis++) {
        const float size = axis_of(high, axis) - axis_of(low, axis);
        if (!(size > 0)) continue;
        const int split =
            best_split(items, count, axis, axis_of(low, axis), BINS / size, &best_cost);
        if (split < 0) continue;
        best_axis = axis;
        best_bin = split;
    }
    if (best_axis < 0) return count / 2; // all centres in one place
    const float from = axis_of(low, best_axis), scale = BINS / (axis_of(high, best_axis) - from);
    int left = 0;
    for (int i = 0; i < count; i++) {
        if (bin_of(items + i, best_axis, from, scale) > best_bin) continue;
        const item moved = items[i];
        items[i] = items[left];
        items[left++] = moved;
    }
    return left;
}

static void build(bvh *tree, int node, item *items, int first, int count, int depth)
{
    bvh_node *n = tree->node + node;
    bounds_of(items + first, count, false, &n->low, &n->high);
    n->first = first;
    n->count = count;
    if (count <= LEAF || depth == DEPTH_MOST - 1) return;
    const int left = partition(items + first, count), children = tree->nodes;
    n->first = children;
    n->count = 0;
    tree->nodes += 2;
    build(tree, children, items, first, left, depth + 1);
    build(tree, children + 1, items, first + left, count - left, depth + 1);
}

bvh *bvh_create(const scene *s)
{
    const size_t count = (size_t)s->triangles;
    bvh *tree = calloc(1, sizeof *tree);
    item *items = malloc(count * sizeof *items);
    if (tree) tree->node = malloc(2 * count * sizeof *tree->node);
    if (tree) tree->triangle = malloc(count * sizeof *tree->triangle);
    if (!tree || !items || !tree->node || !tree->triangle) {
        bvh_free(tree);
        free(items);
        return NULL;
    }
    for (size_t i = 0; i < count; i++) {
        const int *t = s->triangle[i];
        const vec3 a = s->position[t[0]], b = s->position[t[1]], c = s->position[t[2]];
        const vec3 low = vec_min(a, vec_min(b, c)), high = vec_max(a, vec_max(b, c));
        items[i] = (item){low, high, vec_scale(vec_add(low, high), 0.5f), (int)i};
    }
    tree->nodes = 1;
    build(tree, 0, items, 0, s->triangles, 0);
    for (size_t i = 0; i < count; i++) {
        const int *t = s->triangle[items[i].triangle];
        const vec3 a = s->position[t[0]];
        tree->triangle[i] =
            (bvh_triangle){a, vec_sub(s->position[t[1]], a), vec_sub(s->position[t[2]], a)};
    }
    free(items);
    return tree;
}

void bvh_free(bvh *tree)
{
    if (!tree) return;
    free(tree->node);
    free(tree->triangle);
    free(tree);
}

// ---- Rays

typedef struct ray {
    vec3 origin, direction, inverse;
} ray;

// Moeller and Trumbore, both sides; the distance, or HUGE_VALF.
static float hit_triangle(const bvh_triangle *t, const ray *r)
{
    const vec3 side = vec_cross(r->direction, t->ac), from = vec_sub(r->origin, t->a);
    const float scale = 1 / vec_dot(t->ab, side);
    const float u = vec_dot(from, side) * scale;
    if (!(u >= 0 && u <= 1)) return HUGE_VALF;
    const vec3 other = vec_cross(from, t->ab);
    const float v = vec_dot(r->direction, other) * scale;
    if (!(v >= 0 && u + v <= 1)) return HUGE_VALF;
    const float distance = vec_dot(t->ac, other) * scale;
    return distance > 0 ? distance : HUGE_VALF;
}

static float smaller(float a, float b)
{
    return a < b ? a : b;
}
static float larger(float a, float b)
{
    return a > b ? a : b;
}

// Where the ray enters the box; HUGE_VALF when it misses or enters beyond the limit.
static float enter_box(const bvh_node *n, const ray *r, float limit)
{
    const vec3 a = vec_mul(vec_sub(n->low, r->origin), r->inverse);
    const vec3 b = vec_mul(vec_sub(n->high, r->origin), r->inverse);
    const float in = larger(larger(smaller(a.x, b.x), smaller(a.y, b.y)), smaller(a.z, b.z));
    const float out = smaller(smaller(larger(a.x, b.x), larger(a.y, b.y)), larger(a.z, b.z));
    return in <= out * 1.000001f && out >= 0 && in < limit ? in : HUGE_VALF;
}

// The nearest hit before the limit, or with any set the first one found.
static float walk(const bvh *tree, vec3 origin, vec3 direction, float limit, bool any)
{
    const ray r = {origin, direction, {1 / direction.x, 1 / direction.y, 1 / direction.z}};
    int stack[DEPTH_MOST + 1], waiting = 0;
    float nearest = limit;
    stack[waiting++] = 0;
    while (waiting > 0) {
        const bvh_node *n = tree->node + stack[--waiting];
        if (enter_box(n, &r, nearest) >= nearest) continue;
        for (int i = 0; i < n->count; i++) {
            const float distance = hit_triangle(tree->triangle + n->first + i, &r);
            if (distance >= nearest) continue;
            nearest = distance;
            if (any) return nearest;
        }
        if (n->count) continue;
        // The child on the ray's near side is looked at first, so it is put on top.
        const float a = enter_box(tree->node + n->first, &r, nearest);
        const float b = enter_box(tree->node + n->first + 1, &r, nearest);
        if (larger(a, b) < nearest) stack[waiting++] = n->first + (a < b);
        if (smaller(a, b) < nearest) stack[waiting++] = n->first + (a >= b);
    }
    return nearest < limit ? nearest : HUGE_VALF;
}

bool bvh_hit_any(const bvh *tree, vec3 origin, vec3 direction, float distance)
{
    return walk(tree, origin, direction, distance, true) < distance;
}

float bvh_hit_nearest(const bvh *tree, vec3 origin, vec3 direction)
{
    return walk(tree, origin, direction, HUGE_VALF, false);
}

// ---- Sampling

// Two numbers in [0,1) from a seed (the finalizer of MurmurHash3, twice).
static void shift_of(unsigned seed, float *u, float *v)
{
    uint32_t h = seed * 2654435761u + 0x9e3779b9u;
    for (int i = 0; i < 2; i++) {
        h ^= h >> 16;
        h *= 0x85ebca6bu;
        h ^= h >> 13;
        h *= 0xc2b2ae35u;
        h ^= h >> 16;
        *(i ? v : u) = (float)(h >> 8) * (1.0f / 16777216);
    }
}

float trace_rectangle(const bvh *tree, vec3 point, const vec3 *normal, vec3 direction, vec3 axis_u,
                      vec3 axis_v, float tan_half_u, float tan_half_v, int grid, unsigned seed)
{
    float seen = 0, all = 0;
    for (int i = 0; i < grid * grid; i++) {
        float ju, jv;
        shift_of(seed * 7919u + (unsigned)i, &ju, &jv);
        const float u = 2 * ((float)(i % grid) + ju) / (float)grid - 1;
        const float v = 2 * ((float)(i / grid) + jv) / (float)grid - 1;
        const vec3 d = vec_mad(vec_mad(direction, axis_u, u * tan_half_u), axis_v, v * tan_half_v);
        // Per u and v, solid angle falls with length^3; the cosine is divided by length once more.
        const float square = vec_dot(d, d);
        const float weight = normal ? fmaxf(vec_dot(*normal, d), 0) / (square * square) : 1;
        all += weight;
        if (weight > 0 && !bvh_hit_any(tree, point, d, HUGE_VALF)) seen += weight;
    }
    return all > 0 ? seen / all : 0;
}

// Density of solid angle over the s-t plane of a face.
static float face_density(float s, float t)
{
    const float r2 = 1 + s * s + t * t;
    return 1 / (r2 * sqrtf(r2));
}

// What a texel sends: its luminance as lightprobe.h counts it, broken values being none.
static vec3 clean_texel(const probe *p, int i)
{
    vec3 rgb = vec_of(p->texels + 3 * (size_t)i);
    rgb.x = rgb.x > 0 && rgb.x < HUGE_VALF ? rgb.x : 0;
    rgb.y = rgb.y > 0 && rgb.y < HUGE_VALF ? rgb.y : 0;
    rgb.z = rgb.z > 0 && rgb.z < HUGE_VALF ? rgb.z : 0;
    return rgb;
}

static void texel_corner(const probe *p, int i, float *s, float *t)
{
    *s = 2 * (float)(i % p->side) / (float)p->side - 1;
    *t = 2 * (float)(i / p->side % p->side) / (float)p->side - 1;
}

bool probe_sampler_create(probe_sampler *sampler, const probe *p)
{
    const int texels = 6 * p->side * p->side;
    const float half = 1 / (float)p->side;
    double sum = 0, total = 0;
    sampler->source = p;
    sampler->cumulative = malloc((size_t)texels * sizeof *sampler->cumulative);
    if (!sampler->cumulative) return false;
    for (int pass = 0; pass < 2; pass++) {
        total = sum;
        sum = 0;
        for (int i = 0; i < texels; i++) {
            float s, t;
            texel_corner(p, i, &s, &t);
            const float weight =
                face_density(s + half, t + half) * vec_luminance(clean_texel(p, i));
            sum += (double)weight;
            if (pass) sampler->cumulative[i] = total > 0 ? sum / total : (i + 1.0) / texels;
        }
    }
    sampler->cumulative[texels - 1] = 1;
    return true;
}

void probe_sampler_free(probe_sampler *sampler)
{
    free(sampler->cumulative);
    memset(sampler, 0, sizeof *sampler);
}

// The first texel whose cumulative share is above x, and its own share.
static int find_texel(const probe_sampler *sampler, double x, float *share)
{
    const int side = sampler->source->side;
    int low = 0, high = 6 * side * side - 1;
    while (low < high) {
        const int middle = low + (high - low) / 2;
        if (sampler->cumulative[middle] > x)
            high = middle;
        else
            low = middle + 1;
    }
    *share = (float)(sampler->cumulative[low] - (low ? sampler->cumulative[low - 1] : 0));
    return low;
}

vec3 trace_irradiance(const bvh *tree, const probe_sampler *sampler, vec3 point, vec3 normal,
                      int rays, unsigned seed)
{
    const probe *p = sampler->source;
    const float step = 2 / (float)p->side;
    vec3 sum = vec(0, 0, 0);
    float shift, ignored;
    shift_of(seed, &shift, &ignored);
    for (int i = 0; i < rays; i++) {
        float ju, jv, s, t, share;
        // Evenly spaced through the cumulative shares, at random inside the texel.
        const int texel = find_texel(sampler, ((double)i + (double)shift) / rays, &share);
        shift_of(seed * 9781u + (unsigned)i, &ju, &jv);
        texel_corner(p, texel, &s, &t);
        s += ju * step;
        t += jv * step;
        const vec3 d = vec_unit(probe_direction(texel / p->side / p->side, s, t));
        const float cosine = vec_dot(d, normal);
        if (!(cosine > 0) || !(share > 0) || bvh_hit_any(tree, point, d, HUGE_VALF)) continue;
        const float weight = cosine * face_density(s, t) * step * step / (share * (float)rays);
        sum = vec_mad(sum, clean_texel(p, texel), weight);
    }
    return sum;
}

// ---- Pictures

typedef struct picture_job {
    const scene *s;
    bvh *tree;
    view samples; // of twice the width and height
    vec3 direction;
    trace_light *light;
    image *out;
} picture_job;

static void trace_row(void *context, int y)
{
    const picture_job *job = context;
    for (int i = 0; i < 4 * job->out->width; i++) {
        surface piece[VIEW_SAMPLES];
        const int x = i / 4;
        vec3 sum = image_get(job->out, x, y);
        const int pieces =
            view_surfaces(&job->samples, job->s, 2 * x + i % 2, 2 * y + i / 2 % 2, piece);
        for (int k = 0; k < pieces; k++) {
            const vec3 n = piece[k].normal, p = vec_mad(piece[k].position, n, 2e-3f);
            const bool seen = !bvh_hit_any(job->tree, p, job->direction, 100);
            sum = vec_mad(sum, job->s->albedo[piece[k].object],
                          0.25f * piece[k].share * job->light(n, seen));
        }
        image_set(job->out, x, y, sum);
    }
}

bool trace_picture(const scene *s, const camera *eye, vec3 direction, trace_light *light, int width,
                   int height, image *out)
{
    picture_job job = {.s = s, .direction = direction, .light = light, .out = out};
    job.tree = bvh_create(s);
    const bool viewed = view_create(&job.samples, s, eye, 2 * width, 2 * height);
    const bool created = job.tree && viewed && image_create(out, width, height);
    if (created) parallel_for(height, trace_row, &job, NULL);
    if (viewed) view_free(&job.samples);
    bvh_free(job.tree);
    return created;
}
