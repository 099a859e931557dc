#include "probe.h"

#include "../../lightprobe.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool probe_create(probe *p, int side)
{
    memset(p, 0, sizeof *p);
    if (side < 1 || side > 4096) return false;
    const size_t face = (size_t)side * (size_t)side * 3;
    p->texels = calloc(6 * face, sizeof *p->texels);
    if (!p->texels) return false;
    p->side = side;
    for (size_t f = 0; f < 6; f++) p->face[f] = p->texels + f * face;
    return true;
}

void probe_free(probe *p)
{
    free(p->texels);
    memset(p, 0, sizeof *p);
}

static float *texel(const probe *p, int face, int x, int y)
{
    return p->texels + ((size_t)(face * p->side + y) * (size_t)p->side + (size_t)x) * 3;
}

// ---- Directions

// Where a face looks, and which way its s and t grow.
static const float face_axes[6][3][3] = {
    {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
    {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},   {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
    {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},  {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}},
};

vec3 probe_direction(int face, float s, float t)
{
    const float(*axes)[3] = face_axes[face];
    return vec_mad(vec_mad(vec_of(axes[0]), vec_of(axes[1]), s), vec_of(axes[2]), t);
}

int probe_locate(vec3 d, float *s, float *t)
{
    const float x = fabsf(d.x), y = fabsf(d.y), z = fabsf(d.z);
    int face = d.z < 0 ? 5 : 4;
    if (x >= y && x >= z)
        face = d.x < 0 ? 1 : 0;
    else if (y >= z)
        face = d.y < 0 ? 3 : 2;
    const float major = vec_dot(d, vec_of(face_axes[face][0]));
    *s = vec_dot(d, vec_of(face_axes[face][1])) / major;
    *t = vec_dot(d, vec_of(face_axes[face][2])) / major;
    return face;
}

static int texel_index(float s, int side)
{
    const int i = (int)((s * 0.5f + 0.5f) * (float)side);
    return i < 0 ? 0 : i >= side ? side - 1 : i;
}

vec3 probe_sample(const probe *p, vec3 direction)
{
    float s, t;
    const int face = probe_locate(direction, &s, &t);
    const float n = (float)p->side;
    const float x = (s * 0.5f + 0.5f) * n - 0.5f, y = (t * 0.5f + 0.5f) * n - 0.5f;
    const float x0 = floorf(x), y0 = floorf(y);
    vec3 sum = vec(0, 0, 0);
    for (int corner = 0; corner < 4; corner++) {
        const float cx = x0 + (float)(corner & 1), cy = y0 + (float)(corner >> 1);
        const float weight = (1 - fabsf(x - cx)) * (1 - fabsf(y - cy));
        // A corner beyond the face's edge is a direction on the neighbouring face.
        const vec3 d = probe_direction(face, (2 * cx + 1) / n - 1, (2 * cy + 1) / n - 1);
        const int f = probe_locate(d, &s, &t);
        sum = vec_mad(sum, vec_of(texel(p, f, texel_index(s, p->side), texel_index(t, p->side))),
                      weight);
    }
    return sum;
}

// ---- Spreading solid angle over texels
//
// A pixel of the source is a polygon of directions. Cut by the pyramid of a face and projected onto
// it, its edges are straight, and so are those of the texels; what a texel receives is the area of
// the overlap. The pixels of the source share their edges, so all overlaps of a texel add up to the
// texel: a constant stays constant, and a single bright pixel keeps its energy.

#define POLYGON_MOST 16

typedef struct polygon {
    vec3 corner[POLYGON_MOST];
    int count;
} polygon;

// Keeps the part where dot(normal, corner) >= 0 (Sutherland and Hodgman).
static void polygon_clip(polygon *p, vec3 normal)
{
    const polygon old = *p;
    p->count = 0;
    for (int i = 0; i < old.count && p->count + 2 <= POLYGON_MOST; i++) {
        const vec3 a = old.corner[i], b = old.corner[(i + 1) % old.count];
        const float da = vec_dot(normal, a), db = vec_dot(normal, b);
        if (da >= 0) p->corner[p->count++] = a;
        if ((da >= 0) != (db >= 0)) p->corner[p->count++] = vec_mix(a, b, da / (da - db));
    }
}

// The solid angle of a small polygon on the plane z = 1, its corners (s,t,1): area times the
// density at the centre.
static float polygon_solid_angle(const polygon *p)
{
    vec3 centre = vec(0, 0, 0);
    double twice = 0;
    for (int i = 0; i < p->count; i++) {
        // Relative to the first corner, so that a small polygon does not drown in its position.
        const vec3 a = vec_sub(p->corner[i], p->corner[0]);
        const vec3 b = vec_sub(p->corner[(i + 1) % p->count], p->corner[0]);
        twice += (double)a.x * (double)b.y - (double)a.y * (double)b.x;
        centre = vec_mad(centre, p->corner[i], 1 / (float)p->count);
    }
    const float r2 = vec_dot(centre, centre);
    return (float)fabs(twice) * 0.5f / (r2 * sqrtf(r2));
}

typedef struct spread {
    probe *to;
    double *weight; // a texel's share of solid angle received so far
    double *sum;    // and the radiance times that
} spread;

static void spread_to_texel(const spread *out, int face, int x, int y, const polygon *p,
                            const float rgb[3])
{
    const size_t i = (size_t)(face * out->to->side + y) * (size_t)out->to->side + (size_t)x;
    const float w = polygon_solid_angle(p);
    out->weight[i] += (double)w;
    for (size_t c = 0; c < 3; c++) out->sum[3 * i + c] += (double)w * (double)rgb[c];
}

static void spread_to_face(const spread *out, int face, polygon p, const float rgb[3])
{
    const int side = out->to->side;
    float low_s = 1, high_s = -1, low_t = 1, high_t = -1;
    // Four planes of the pyramid: 1 + s, 1 - s, 1 + t, 1 - t >= 0.
    for (int plane = 0; plane < 4; plane++) {
        const float sign = plane & 1 ? -1.0f : 1.0f;
        polygon_clip(&p, plane < 2 ? vec(sign, 0, 1) : vec(0, sign, 1));
    }
    if (p.count < 3) return;
    for (int i = 0; i < p.count; i++) {
        const vec3 c = p.corner[i];
        if (!(c.z > 0)) return; // only the apex of the pyramid is left
        p.corner[i] = vec(c.x / c.z, c.y / c.z, 1);
        low_s = fminf(low_s, p.corner[i].x);
        high_s = fmaxf(high_s, p.corner[i].x);
        low_t = fminf(low_t, p.corner[i].y);
        high_t = fmaxf(high_t, p.corner[i].y);
    }
    const int x0 = texel_index(low_s, side), x1 = texel_index(high_s, side);
    const int y0 = texel_index(low_t, side), y1 = texel_index(high_t, side);
    const float step = 2 / (float)side;
    for (int y = y0; y <= y1; y++) {
        polygon row = p;
        if (y > y0) polygon_clip(&row, vec(0, 1, 1 - step * (float)y));
        if (y < y1) polygon_clip(&row, vec(0, -1, step * (float)(y + 1) - 1));
        for (int x = x0; x <= x1; x++) {
            polygon cell = row;
            if (x > x0) polygon_clip(&cell, vec(1, 0, 1 - step * (float)x));
            if (x < x1) polygon_clip(&cell, vec(-1, 0, step * (float)(x + 1) - 1));
            if (cell.count >= 3) spread_to_texel(out, face, x, y, &cell, rgb);
        }
    }
}

static void spread_quad(const spread *out, const vec3 corner[4], const float value[3])
{
    float rgb[3];
    // A broken texel must not break its neighbours.
    for (int c = 0; c < 3; c++) rgb[c] = isfinite(value[c]) ? value[c] : 0;
    for (int face = 0; face < 6; face++) {
        polygon p = {.count = 4};
        bool ahead = false;
        for (int i = 0; i < 4; i++) {
            p.corner[i] = vec(vec_dot(corner[i], vec_of(face_axes[face][1])),
                              vec_dot(corner[i], vec_of(face_axes[face][2])),
                              vec_dot(corner[i], vec_of(face_axes[face][0])));
            ahead |= p.corner[i].z > 0.5f; // unit vectors on a face have at least 0.577
        }
        if (ahead) spread_to_face(out, face, p, rgb);
    }
}

static bool spread_begin(spread *out, probe *to)
{
    const size_t texels = 6 * (size_t)to->side * (size_t)to->side;
    out->to = to;
    out->weight = calloc(texels, 4 * sizeof *out->weight);
    out->sum = out->weight ? out->weight + texels : NULL;
    return out->weight != NULL;
}

static void spread_end(const spread *out)
{
    const size_t texels = 6 * (size_t)out->to->side * (size_t)out->to->side;
    for (size_t i = 0; i < 3 * texels; i++) {
        const double w = out->weight[i / 3];
        out->to->texels[i] = w > 0 ? (float)(out->sum[i] / w) : 0;
    }
    free(out->weight);
}

bool probe_rotate(probe *out, const probe *in, float angle)
{
    spread to;
    const float n = (float)in->side;
    if (angle == 0 && in->side == out->side) { // exactly, broken texels included
        memcpy(out->texels, in->texels, 18 * (size_t)in->side * (size_t)in->side * sizeof(float));
        return true;
    }
    if (!spread_begin(&to, out)) return false;
    for (int i = 0; i < 6 * in->side * in->side; i++) {
        const int face = i / (in->side * in->side), y = i / in->side % in->side, x = i % in->side;
        vec3 corner[4];
        for (int c = 0; c < 4; c++) {
            const float cx = (float)(x + (c == 1 || c == 2)), cy = (float)(y + (c >= 2));
            const vec3 d = probe_direction(face, 2 * cx / n - 1, 2 * cy / n - 1);
            corner[c] = vec_unit(vec_turn(d, angle));
        }
        spread_quad(&to, corner, texel(in, face, x, y));
    }
    spread_end(&to);
    return true;
}

// ---- Irradiance

void probe_irradiance(const probe *p, const vec3 *normal, int normals, vec3 *irradiance)
{
    for (int k = 0; k < normals; k++) irradiance[k] = vec(0, 0, 0);
    for (int i = 0; i < 6 * p->side * p->side; i++) {
        const int face = i / p->side / p->side, y = i / p->side % p->side, x = i % p->side;
        const float weight = lightprobe_texel_solid_angle(p->side, x, y), n = (float)p->side;
        const vec3 d =
            vec_unit(probe_direction(face, (float)(2 * x + 1) / n - 1, (float)(2 * y + 1) / n - 1));
        vec3 flux = vec_of(p->texels + 3 * (size_t)i);
        flux.x = flux.x > 0 && flux.x < HUGE_VALF ? flux.x * weight : 0;
        flux.y = flux.y > 0 && flux.y < HUGE_VALF ? flux.y * weight : 0;
        flux.z = flux.z > 0 && flux.z < HUGE_VALF ? flux.z * weight : 0;
        for (int k = 0; k < normals; k++) {
            const float cosine = vec_dot(d, normal[k]);
            if (cosine > 0) irradiance[k] = vec_mad(irradiance[k], flux, cosine);
        }
    }
}

bool probe_irradiance_map(const probe *p, int side, probe *map)
{
    const int texels = 6 * side * side;
    vec3 *normal = calloc(2 * (size_t)texels, sizeof *normal),
         *sum = normal ? normal + texels : NULL;
    const bool created = normal && probe_create(map, side);
    for (int i = 0; i < texels && created; i++) {
        const float n = (float)side, s = (float)(2 * (i % side) + 1) / n - 1,
                    t = (float)(2 * (i / side % side) + 1) / n - 1;
        normal[i] = vec_unit(probe_direction(i / side / side, s, t));
    }
    if (created) {
        probe_irradiance(p, normal, texels, sum);
        for (int i = 0; i < texels; i++) memcpy(map->texels + 3 * (size_t)i, &sum[i], sizeof *sum);
    }
    free(normal);
    return created;
}

// ---- From pictures

bool probe_from_image(probe *p, const image *im, int side, message *why)
{
    const lightprobe_image picture = {im->rgb, im->width, im->height, 3, 0, LIGHTPROBE_AUTO};
    const int own = lightprobe_image_side(&picture);
    memset(p, 0, sizeof *p);
    if (own == 0) {
        return fail(why,
                    "%d x %d pixels are neither a lat-long picture (2:1), a cross (4:3 or 3:4) nor "
                    "six faces in a row (6:1 or 1:6)",
                    im->width, im->height);
    }
    const bool faces = abs(im->width - 2 * im->height) > 1;
    if (side == 0) side = own < 16 ? 16 : own;
    if (side > PROBE_DEFAULT_SIDE) side = PROBE_DEFAULT_SIDE;
    if (faces) side = own;
    if (!probe_create(p, side)) return fail(why, "no memory for a probe of side %d", side);
    const lightprobe_result result =
        lightprobe_cube_from_image(&picture, side, p->texels, NULL, &p->broken);
    if (result) probe_free(p);
    return !result || fail(why, "%s", lightprobe_result_string(result));
}

bool probe_to_image(const probe *p, image *im)
{
    if (!image_create(im, p->side, 6 * p->side)) return false;
    memcpy(im->rgb, p->texels, (size_t)im->width * (size_t)im->height * 3 * sizeof *im->rgb);
    return true;
}

bool probe_load(probe *p, const char *path, int side, message *why)
{
    image im;
    message reason;
    memset(p, 0, sizeof *p);
    if (!image_load(&im, path, why)) return false;
    const bool made = probe_from_image(p, &im, side, &reason);
    image_free(&im);
    return made || fail(why, "%s: %.180s", path, reason.text);
}

// ---- The built-in probe

// 1 inside, 0 outside, with a soft rim of the given width.
static float soft_step(float inside, float rim)
{
    const float x = fminf(fmaxf(inside / rim + 0.5f, 0), 1);
    return x * x * (3 - 2 * x);
}

// A rectangle of light that faces the scene from a direction, as wide and high as its tangents say.
static float soft_box(vec3 d, vec3 towards, float half_width, float half_height)
{
    const vec3 right = vec_unit(vec_cross(vec(0, 1, 0), towards)), up = vec_cross(towards, right);
    const float along = vec_dot(d, towards);
    if (along <= 0) return 0;
    const float u = fabsf(vec_dot(d, right) / along), v = fabsf(vec_dot(d, up) / along);
    const float frame = soft_step(half_width - u, 0.04f) * soft_step(half_height - v, 0.04f);
    // Two bars divide it into panes.
    return frame * (1 - 0.9f * soft_step(0.018f - u, 0.01f)) *
           (1 - 0.9f * soft_step(0.018f - v, 0.01f));
}

static vec3 default_radiance(vec3 d)
{
    const vec3 sun = vec_unit(vec(-0.72f, 0.60f, -0.34f));
    const vec3 window = vec_unit(vec(0.72f, 0.40f, 0.60f));
    const float towards_sun = fmaxf(vec_dot(d, sun), 0);
    const float height = fmaxf(d.y, 0);
    // Hazy hills all around.
    const float azimuth = atan2f(d.x, -d.z);
    const float ridge = 0.05f + 0.025f * sinf(3 * azimuth + 0.5f) + 0.012f * sinf(11 * azimuth);
    vec3 sky = vec_mix(vec(0.95f, 0.62f, 0.42f), vec(0.09f, 0.22f, 0.55f), sqrtf(height));
    sky = vec_mad(sky, vec(0.9f, 0.55f, 0.28f), powf(towards_sun, 12));
    const vec3 hills = vec_mix(vec(0.34f, 0.27f, 0.30f), vec(0.60f, 0.42f, 0.36f), towards_sun);
    const vec3 meadow =
        vec_mix(vec(0.40f, 0.30f, 0.22f), vec(0.12f, 0.10f, 0.08f), sqrtf(fmaxf(-d.y, 0)));
    vec3 sum = vec_mix(meadow, hills, soft_step(d.y, 0.02f));
    sum = vec_mix(sum, sky, soft_step(d.y - ridge, 0.012f));
    // The disc is 4 degrees wide instead of half a degree: as behind thin haze.
    sum = vec_mad(sum, vec(1900, 1480, 980), soft_step(towards_sun - 0.99939f, 0.0005f));
    return vec_mad(sum, vec(2.0f, 2.7f, 3.7f), soft_box(d, window, 0.42f, 0.30f));
}

bool probe_default(probe *p, int side)
{
    enum { GRID = 4 }; // samples along the side of a texel
    if (!probe_create(p, side)) return false;
    for (int i = 0; i < 6 * side * side; i++) {
        vec3 sum = vec(0, 0, 0);
        for (int k = 0; k < GRID * GRID; k++) {
            const float s = ((float)(i % side) + ((float)(k % GRID) + 0.5f) / GRID) / (float)side;
            const float t =
                ((float)(i / side % side) + ((float)(k / GRID) + 0.5f) / GRID) / (float)side;
            const vec3 d = vec_unit(probe_direction(i / side / side, 2 * s - 1, 2 * t - 1));
            sum = vec_mad(sum, default_radiance(d), 1.0f / (GRID * GRID));
        }
        memcpy(p->texels + 3 * (size_t)i, &sum, sizeof sum);
    }
    return true;
}
