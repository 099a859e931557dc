#include "gl_smoke_plume.h"

#include "threads.h"

#include <stdlib.h>

enum { BILLOWS = 40, IN_BILLOW = GL_SMOKE_PUFFS / BILLOWS };

// ---- Making it

static float random_in(unsigned *state, float low, float high)
{
    *state = *state * 1664525u + 1013904223u;
    return low + (high - low) * (float)(*state >> 8) / 16777216.0f;
}

static vec3 random_in_ball(unsigned *state)
{
    for (;;) {
        const float x = random_in(state, -1, 1), y = random_in(state, -1, 1);
        const vec3 p = vec(x, y, random_in(state, -1, 1));
        if (vec_dot(p, p) < 1) return p;
    }
}

// Billows rise, widen, thin out and drift with the wind; each is a ball of puffs.
static void make_billow(gl_smoke_plume *p, int index, vec3 foot, float height, unsigned *state)
{
    const float age = ((float)index + random_in(state, 0, 1)) / BILLOWS;
    const float width = height * (0.06f + 0.12f * age), turn = 9 * age;
    const vec3 drift = vec(0.22f * age * age + 0.03f * age * sinf(turn), powf(age, 0.8f),
                           0.03f * age * cosf(turn) - 0.06f * age * age);
    const vec3 middle = vec_mad(vec_mad(foot, drift, height), random_in_ball(state), width);
    for (int i = 0; i < IN_BILLOW; i++) {
        const float radius = width * random_in(state, 0.45f, 0.9f);
        p->puff[index * IN_BILLOW + i] = (gl_smoke_puff){
            vec_mad(middle, random_in_ball(state), 0.75f * width), radius, 0.42f - 0.3f * age};
    }
}

static int axis; // of the comparison below
static int compare_along(const void *a, const void *b)
{
    const float *const x = &((const gl_smoke_puff *)a)->centre.x;
    const float *const y = &((const gl_smoke_puff *)b)->centre.x;
    return x[axis] < y[axis] ? -1 : x[axis] > y[axis];
}

// Halves and quarters, so that neighbours in the array are neighbours in space.
static void order(gl_smoke_puff *puff, int count, int depth)
{
    const int half = count / 2 / GL_SMOKE_GROUP * GL_SMOKE_GROUP;
    if (half == 0) return;
    axis = depth % 3;
    qsort(puff, (size_t)count, sizeof *puff, compare_along);
    order(puff, half, depth + 1);
    order(puff + half, count - half, depth + 1);
}

static gl_smoke_puff sphere_around(const gl_smoke_puff *puff)
{
    gl_smoke_puff s = {vec(0, 0, 0), 0, 0};
    for (int i = 0; i < GL_SMOKE_GROUP; i++) {
        s.centre = vec_mad(s.centre, puff[i].centre, 1.0f / GL_SMOKE_GROUP);
    }
    for (int i = 0; i < GL_SMOKE_GROUP; i++) {
        const float reach = vec_length(vec_sub(puff[i].centre, s.centre)) + puff[i].radius;
        s.radius = fmaxf(s.radius, 1.001f * reach);
    }
    return s;
}

void gl_smoke_create(gl_smoke_plume *p, vec3 foot, float height)
{
    unsigned state = 7;
    *p = (gl_smoke_plume){.low = foot, .high = foot};
    for (int i = 0; i < BILLOWS; i++) make_billow(p, i, foot, height, &state);
    order(p->puff, GL_SMOKE_PUFFS, 0);
    for (int i = 0; i < GL_SMOKE_PUFFS; i++) {
        const vec3 r = vec(p->puff[i].radius, p->puff[i].radius, p->puff[i].radius);
        p->low = vec_min(p->low, vec_sub(p->puff[i].centre, r));
        p->high = vec_max(p->high, vec_add(p->puff[i].centre, r));
        if (i % GL_SMOKE_GROUP == 0) p->group[i / GL_SMOKE_GROUP] = sphere_around(p->puff + i);
    }
    gl_mesh_triangle(&p->quads);
    p->quads.count = 6 * GL_SMOKE_PUFFS;
    gl.CreateBuffers(1, &p->buffer);
    gl.NamedBufferStorage(p->buffer, sizeof p->puff, NULL, GL_DYNAMIC_STORAGE_BIT);
}

void gl_smoke_free(gl_smoke_plume *p)
{
    gl_mesh_free(&p->quads);
    if (p->buffer) gl.DeleteBuffers(1, &p->buffer);
    p->buffer = 0;
}

static void put_box(scene *s, float x, float y, float z, float turn, vec3 half)
{
    const scene_frame f = scene_frame_at(vec(x, y, z), turn, 0);
    scene_put_box(s, &f, half);
}

bool gl_smoke_scene(scene *s, gl_mesh *casters, gl_mesh *receivers, gl_smoke_plume *p, float low[3],
                    float high[3], message *why)
{
    const scene_frame ball = scene_frame_at(vec(1.0f, 0.4f, 0.1f), 0, 0);
    scene_begin_object(s, 0.45f, 0.5f, 0.42f);
    put_box(s, -1.5f, 0.9f, 0.66f, 0.9f, vec(0.65f, 0.5f, 0.03f));
    put_box(s, -1.5f, 1.75f, 0.66f, 0.9f, vec(0.65f, 0.1f, 0.03f));
    put_box(s, -1.5f, 2.2f, 0.66f, 0.9f, vec(0.65f, 0.1f, 0.03f));
    put_box(s, -1.1f, 1.2f, 0.16f, 0.9f, vec(0.04f, 1.2f, 0.04f));
    put_box(s, -1.9f, 1.2f, 1.16f, 0.9f, vec(0.04f, 1.2f, 0.04f));
    scene_begin_object(s, 0.13f, 0.33f, 0.62f);
    scene_put_sphere(s, &ball, 0.4f, 28);
    const int casting = s->triangles;
    scene_begin_object(s, 0.6f, 0.57f, 0.52f);
    put_box(s, 0, -0.1f, 1, 0, vec(7, 0.1f, 3.5f));
    scene_begin_object(s, 0.36f, 0.38f, 0.4f);
    put_box(s, 0, 2, -1.6f, 0, vec(7, 2.2f, 0.1f));
    if (!scene_end(s) || !gl_mesh_upload(receivers, s, why)) return false;
    *casters = *receivers;
    casters->count = 3 * casting;
    gl_smoke_create(p, vec(-0.65f, 0.12f, 0), 2.3f);
    const vec3 a = vec_min(p->low, vec(-2, 0, -0.3f)), b = vec_max(p->high, vec(1.4f, 2.4f, 1.2f));
    low[0] = a.x, low[1] = a.y, low[2] = a.z;
    high[0] = b.x, high[1] = b.y, high[2] = b.z;
    return true;
}

// ---- Drawing it

// clang-format off
const char gl_smoke_vertex[] =
    "layout(location = 0) uniform mat4 world_to_clip;\n"
    "layout(location = 1) uniform vec4 eye;\n"
    "layout(std430, binding = 0) readonly buffer puffs { float puff[]; };\n"
    "out vec3 position;\n"
    "out vec2 place;\n"
    "flat out float puff_opacity;\n"
    "void main()\n"
    "{\n"
    "    int i = gl_VertexID / 6 * 5, corner = gl_VertexID % 6;\n"
    "    vec3 centre = vec3(puff[i], puff[i + 1], puff[i + 2]);\n"
    "    vec3 back = normalize(eye.xyz - eye.w * centre);\n" // the billboard faces who looks
    "    vec3 right = normalize(cross(abs(back.y) < 0.9 ? vec3(0, 1, 0) : vec3(1, 0, 0), back));\n"
    "    place = vec2(corner > 0 && corner < 4 ? 1 : -1, corner > 1 && corner < 5 ? 1 : -1);\n"
    "    position = centre + puff[i + 3] * (place.x * right + place.y * cross(back, right));\n"
    "    puff_opacity = puff[i + 4];\n"
    "    gl_Position = world_to_clip * vec4(position, 1);\n"
    "}\n";

const char gl_smoke_opacity[] =
    "in vec3 position;\n"
    "in vec2 place;\n"
    "flat in float puff_opacity;\n"
    "float opacity()\n"
    "{\n"
    "    float f = max(1 - dot(place, place), 0);\n"
    "    return puff_opacity * f * f;\n"
    "}\n";
// clang-format on

// Shading by the sunlight that arrives, for the truth and as GLSL.
#define SURFACE(sunlight, normal_y) ((sunlight) + 0.2f + 0.1f * (normal_y))
#define SCATTERED(sunlight) (0.85f * (sunlight) + 0.12f) // alike to all sides
#define QUOTED(...) #__VA_ARGS__
#define AS_TEXT(...) QUOTED(__VA_ARGS__)

// clang-format off
const char gl_smoke_shading[] =
    "float surface(float light, float up) { return " AS_TEXT(SURFACE(light, up)) "; }\n"
    "float scattered(float light) { return " AS_TEXT(SCATTERED(light)) "; }\n";
// clang-format on

typedef struct layer {
    float distance, opacity;
} layer;

static int compare_layers(const void *a, const void *b)
{
    const layer *x = a, *y = b;
    return x->distance < y->distance ? -1 : x->distance > y->distance;
}

void gl_smoke_draw(gl_smoke_plume *p, GLuint program, const float world_to_clip[16], vec3 eye,
                   float eye_w)
{
    const float from[4] = {eye.x, eye.y, eye.z, eye_w};
    layer far_first[GL_SMOKE_PUFFS]; // the index in place of the opacity
    gl_smoke_puff sorted[GL_SMOKE_PUFFS];
    for (int i = 0; i < GL_SMOKE_PUFFS; i++) {
        const vec3 c = p->puff[i].centre;
        far_first[i].distance = eye_w != 0 ? -vec_length(vec_sub(c, eye)) : vec_dot(c, eye);
        far_first[i].opacity = (float)i;
    }
    qsort(far_first, GL_SMOKE_PUFFS, sizeof *far_first, compare_layers);
    for (int i = 0; i < GL_SMOKE_PUFFS; i++) sorted[i] = p->puff[(int)far_first[i].opacity];
    gl.NamedBufferSubData(p->buffer, 0, sizeof sorted, sorted);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, p->buffer);
    gl.UseProgram(program);
    gl.ProgramUniformMatrix4fv(program, 0, 1, GL_FALSE, world_to_clip);
    gl.ProgramUniform4fv(program, 1, 1, from);
    gl.Enable(GL_BLEND);
    gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    gl.DepthMask(0); // billboards may cut each other
    gl_mesh_draw(&p->quads);
    gl.DepthMask(1);
    gl.Disable(GL_BLEND);
}

// ---- Rays

// How far the ray goes to come nearest to the centre; *f = 1 - (distance / radius)^2 there.
static float nearest(const gl_smoke_puff *s, vec3 origin, vec3 direction, float *f)
{
    const vec3 to = vec_sub(s->centre, origin);
    const float t = vec_dot(to, direction);
    *f = 1 - (vec_dot(to, to) - t * t) / (s->radius * s->radius);
    return t;
}

// What a ray meets before the limit, in no order; room for all puffs.
static int find_layers(const gl_smoke_plume *p, vec3 origin, vec3 direction, float limit,
                       layer *out)
{
    int count = 0;
    float f;
    for (int g = 0; g < GL_SMOKE_PUFFS / GL_SMOKE_GROUP; g++) {
        const float middle = nearest(p->group + g, origin, direction, &f), r = p->group[g].radius;
        if (f <= 0 || middle + r < 0 || middle - r > limit) continue;
        for (int i = g * GL_SMOKE_GROUP; i < (g + 1) * GL_SMOKE_GROUP; i++) {
            const float t = nearest(p->puff + i, origin, direction, &f);
            if (f <= 0 || t <= 0 || t >= limit) continue;
            out[count++] = (layer){t, p->puff[i].opacity * f * f};
        }
    }
    return count;
}

float gl_smoke_transmittance(const gl_smoke_plume *p, vec3 origin, vec3 direction)
{
    layer met[GL_SMOKE_PUFFS];
    const int count = find_layers(p, origin, direction, HUGE_VALF, met);
    float through = 1;
    for (int i = 0; i < count; i++) through *= 1 - met[i].opacity;
    return through;
}

typedef struct tracing {
    const gl_smoke_plume *p;
    const scene *s;
    const gl_smoke_sun *sun;
    bvh *tree;
    view seen; // two samples along each side of a pixel, and four in each
    image fine;
} tracing;

// What of the sun comes through to a point.
static float trace_sun(const tracing *job, vec3 point, int rays, unsigned seed)
{
    const gl_smoke_sun *l = job->sun;
    const vec3 to = vec_of(l->direction), u = vec_unit(vec_cross(vec_of(l->axis), to));
    const vec3 v = vec_cross(to, u);
    const unsigned hash = seed * 2654435761u ^ seed << 13;
    float sum = 0;
    if (!(l->half > 0)) rays = 1;
    // A lattice (powers of the plastic number's inverse) that is even from wherever it starts.
    for (unsigned i = 0; i < (unsigned)rays; i++) {
        const float a = (float)(hash + 0xC13FA9A9u * i) / 2147483648.0f - 1;
        const float b = (float)(hash * 7919 + 0x91E10DA5u * i) / 2147483648.0f - 1;
        const vec3 d = vec_unit(vec_mad(vec_mad(to, u, a * l->half), v, b * l->half));
        if (!bvh_hit_any(job->tree, point, d, 100)) sum += gl_smoke_transmittance(job->p, point, d);
    }
    return sum / (float)rays;
}

// The smoke along a camera's ray, in front of what is there; *through is the share of that.
static float trace_smoke(const tracing *job, vec3 direction, float limit, unsigned seed,
                         float *through)
{
    layer met[GL_SMOKE_PUFFS];
    const vec3 from = job->seen.eye.position;
    const int count = find_layers(job->p, from, direction, limit, met);
    float sum = 0;
    qsort(met, (size_t)count, sizeof *met, compare_layers);
    *through = 1;
    for (int i = 0; i < count; i++) {
        const vec3 at = vec_mad(from, direction, met[i].distance);
        const float seen = trace_sun(job, at, 4, seed * 64 + (unsigned)i);
        sum += *through * met[i].opacity * SCATTERED(seen);
        *through *= 1 - met[i].opacity;
    }
    return sum;
}

static void trace_row(void *context, int y)
{
    tracing *job = context;
    const view *v = &job->seen;
    for (int x = 0; x < v->width; x++) {
        surface piece[VIEW_SAMPLES];
        const unsigned seed = (unsigned)(y * v->width + x);
        const vec3 ray = camera_ray(&v->eye, ((float)x + 0.5f) / (float)v->width,
                                    ((float)y + 0.5f) / (float)v->height);
        const int pieces = view_surfaces(v, job->s, x, y, piece);
        float through, limit = HUGE_VALF;
        if (pieces) limit = vec_length(vec_sub(piece[0].position, v->eye.position));
        const float smoke = trace_smoke(job, vec_unit(ray), limit, seed, &through);
        vec3 sum = vec(smoke, smoke, smoke);
        for (int i = 0; i < pieces; i++) {
            const vec3 n = piece[i].normal, at = vec_mad(piece[i].position, n, 2e-3f);
            float light = fmaxf(vec_dot(n, vec_of(job->sun->direction)), 0);
            if (light > 0) light *= trace_sun(job, at, 16, seed);
            sum = vec_mad(sum, job->s->albedo[piece[i].object],
                          through * piece[i].share * SURFACE(light, n.y));
        }
        image_set(&job->fine, x, y, sum);
    }
}

bool gl_smoke_trace(const gl_smoke_plume *p, const scene *s, const camera *eye,
                    const gl_smoke_sun *sun, int width, int height, image *out, message *why)
{
    tracing job = {.p = p, .s = s, .sun = sun, .tree = bvh_create(s)};
    const bool room = job.tree && view_create(&job.seen, s, eye, 2 * width, 2 * height) &&
                      image_create(&job.fine, 2 * width, 2 * height) &&
                      image_create(out, width, height);
    if (room) {
        parallel_for(2 * height, trace_row, &job, "tracing the truth");
        for (int i = 0; i < width * height; i++) {
            const int x = i % width, y = i / width;
            vec3 sum = vec(0, 0, 0);
            for (int k = 0; k < 4; k++) {
                sum = vec_mad(sum, image_get(&job.fine, 2 * x + k % 2, 2 * y + k / 2), 0.25f);
            }
            image_set(out, x, y, sum);
        }
    }
    image_free(&job.fine);
    view_free(&job.seen);
    bvh_free(job.tree);
    return room || fail(why, "no memory for rays");
}
