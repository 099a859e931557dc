#include "shafts.h"

#include "threads.h"

#include <stdlib.h>

bool shafts_create(shafts *s, int rows, int columns)
{
    *s = (shafts){.rows = rows, .columns = columns};
    s->moments = malloc((size_t)rows * (size_t)columns * 6 * sizeof *s->moments);
    return s->moments != NULL;
}

void shafts_free(shafts *s)
{
    free(s->moments);
    *s = (shafts){.rows = 0};
}

mssm_light shafts_sun(const scene *s, const float to_sun[3])
{
    const float axis[3] = {1, 0, 0}, low[3] = {s->low.x, s->low.y, s->low.z};
    const float high[3] = {s->high.x, s->high.y, s->high.z};
    mssm_light light = {{0}, 0, 0, 0, 1, 1, -1, 1};
    mssm_light_directional(&light, to_sun, axis, 0, 0, low, high);
    // Without its empty rim, which soft shadows want. Here it would be one more depth in each row, and
    // six moments know three: the hall would err by .0211, not .0185.
    const float rim = 1 + 1 / 64.0f;
    for (int i = 0; i < 8; i++) light.world_to_shadow[i / 2 * 4 + i % 2] *= rim;
    light.extent_u /= rim;
    light.extent_v /= rim;
    return light;
}

bool shafts_look(mssm_scattering *from, const mssm_light *light, const camera *eye,
                 float extinction)
{
    const float at[3] = {eye->position.x, eye->position.y, eye->position.z};
    float corners[12];
    for (int i = 0; i < 4; i++) {
        const vec3 d = camera_ray(eye, i == 1 || i == 2, i > 1);
        corners[3 * i] = d.x;
        corners[3 * i + 1] = d.y;
        corners[3 * i + 2] = d.z;
    }
    return mssm_scattering_init(from, light, at, corners, extinction) == MSSM_OK;
}

typedef struct update_job {
    shafts *s;
    const mssm_filtered *map;
} update_job;

// As gl_shafts.c does it: each texel looks at the filtered map under its own footprint, and holds
// what all up to it hold on average. 16 bits are enough for that.
static void add_up_row(void *context, int index)
{
    const update_job *job = context;
    shafts *s = job->s;
    const mssm_scattering v = s->view;
    const float columns = (float)s->columns, step = v.azimuth[1] / (float)s->rows;
    const mssm_epipolar row = mssm_scattering_row(v, v.azimuth[0] + step * ((float)index + 0.5f));
    const float scale = sqrtf(row.x * row.x + row.y * row.y); // shadow space for each r
    float *to = s->moments + (size_t)index * (size_t)s->columns * 6, sum[6] = {0};
    float left = row.first;
    for (int i = 0; i < s->columns; i++) {
        const float right = mssm_scattering_distance(row, ((float)i + 1) / columns);
        const float r = mssm_scattering_distance(row, ((float)i + 0.5f) / columns);
        const mssm_moments6 m =
            mssm_filtered_moments(job->map, v.eye[0] + row.x * r, v.eye[1] + row.y * r,
                                  scale * fmaxf(right - left, r * step));
        const mssm_moments6 t = mssm_scattering_moments(v, r, m.b[0], m.b[1], m.b[2]);
        mssm_moments6 mean;
        for (int k = 0; k < 6; k++) mean.b[k] = (sum[k] += t.b[k]) / ((float)i + 1);
        mean = mssm_moments6_encode(mean);
        for (int k = 0; k < 6; k++) *to++ = floorf(mean.b[k] * 65535 + 0.5f) / 65535;
        left = right;
    }
}

void shafts_update(shafts *s, const mssm_filtered *map, const mssm_scattering *from)
{
    update_job job = {s, map};
    s->view = *from;
    parallel_for(s->rows, add_up_row, &job, NULL);
}

// Bilinear. Rows that go all the way round are joined, others end in their last.
static mssm_moments6 look_up(const shafts *s, float row, float column)
{
    const float x = fminf(fmaxf(column * (float)s->columns - 1, 0), (float)s->columns - 1);
    const float y = fminf(fmaxf(row, 0), 1) * (float)s->rows - 0.5f;
    const int left = (int)x, low = (int)floorf(y);
    const bool round = s->view.azimuth[1] > 6.28f;
    mssm_moments6 q = {{0}};
    for (int j = 0; j < 4; j++) {
        int i = left + j % 2, at = low + j / 2;
        if (i == s->columns) i--;
        if (at < 0) at = round ? s->rows - 1 : 0;
        if (at == s->rows) at = round ? 0 : s->rows - 1;
        const float across = x - (float)left, up = y - (float)low;
        const float w = (j % 2 ? across : 1 - across) * (j / 2 ? up : 1 - up);
        const float *from = s->moments + ((size_t)at * (size_t)s->columns + (size_t)i) * 6;
        for (int k = 0; k < 6; k++) q.b[k] += w * from[k];
    }
    return q;
}

float shafts_visibility(const shafts *s, vec3 direction, float distance)
{
    const mssm_view_ray ray =
        mssm_scattering_ray(s->view, direction.x, direction.y, direction.z, distance);
    const mssm_moments6 m = mssm_moments6_decode(look_up(s, ray.row, ray.column));
    return mssm_scattering_visibility(ray, mssm_moments6_bias_encoded(m, MSSM_BIAS6_UNORM16));
}

float shafts_marched(const shafts_march *m, vec3 origin, vec3 direction, float distance)
{
    const float all = m->extinction * distance;
    int lit = 0;
    for (int i = 0; i < m->steps; i++) {
        const float u = ((float)i + 0.5f) / (float)m->steps;
        const float t =
            all > 1e-3f ? -logf(1 - u * (1 - expf(-all))) / m->extinction : u * distance;
        const vec3 p = vec_mad(origin, direction, t);
        const float point[3] = {p.x, p.y, p.z};
        float at[3] = {0};
        mssm_light_project(m->light, point, at);
        const float x = floorf((0.5f + 0.5f * at[0]) * (float)m->side);
        const float y = floorf((0.5f + 0.5f * at[1]) * (float)m->side);
        const bool inside = x >= 0 && y >= 0 && x < (float)m->side && y < (float)m->side;
        const float depth = inside ? m->depth[(size_t)y * (size_t)m->side + (size_t)x] : 1;
        lit += depth >= at[2] || depth > 0.9f;
    }
    return (float)lit / (float)m->steps;
}

float shafts_distance(const camera *eye, const image *positions, float far_end, int x, int y)
{
    const vec3 p = image_get(positions, x, y);
    return vec_dot(p, p) > 0 ? fminf(vec_length(vec_sub(p, eye->position)), far_end) : far_end;
}

typedef struct image_job {
    const shafts_march *march;
    const camera *eye;
    const image *positions;
    image *out;
    float far_end;
} image_job;

static void march_row(void *context, int y)
{
    const image_job *job = context;
    const float width = (float)job->out->width, height = (float)job->out->height;
    for (int x = 0; x < job->out->width; x++) {
        const vec3 d =
            vec_unit(camera_ray(job->eye, ((float)x + 0.5f) / width, ((float)y + 0.5f) / height));
        const float t = shafts_distance(job->eye, job->positions, job->far_end, x, y);
        const float share = 1 - expf(-job->march->extinction * t);
        const float v = share * shafts_marched(job->march, job->eye->position, d, t);
        image_set(job->out, x, y, vec(v, v, v));
    }
}

void shafts_march_image(const shafts_march *m, const camera *eye, const image *positions,
                        float far_end, image *out)
{
    image_job job = {m, eye, positions, out, far_end};
    parallel_for(out->height, march_row, &job, "marching");
}

bool shafts_truth(const scene *s, const mssm_light *light, int side, int steps, float extinction,
                  const camera *eye, const image *positions, float far_end, image *out)
{
    const raster_frustum frustum = {light->world_to_shadow, false, 0, 0};
    float *depth = malloc((size_t)side * (size_t)side * sizeof *depth);
    const shafts_march march = {light, depth, side, steps, extinction};
    const bool drawn = depth && raster_depth(s, &frustum, RASTER_FRONT, side, 1, depth);
    if (drawn) shafts_march_image(&march, eye, positions, far_end, out);
    free(depth);
    return drawn;
}

void shafts_over(image *light, vec3 color, const image *solid, float extinction, const camera *eye,
                 const image *positions, float far_end)
{
    for (int i = 0; i < light->width * light->height; i++) {
        const int x = i % light->width, y = i / light->width;
        const float t = shafts_distance(eye, positions, far_end, x, y);
        const vec3 behind = vec_scale(image_get(solid, x, y), expf(-extinction * t));
        image_set(light, x, y, vec_add(behind, vec_mul(color, image_get(light, x, y))));
    }
}

void shafts_errors(const image *got, const image *expected, double *error, double *of_steps)
{
    const int pixels = got->width * got->height;
    double errors = 0, steps = 0, before = 0;
    for (int i = 0; i < pixels; i++) {
        const double e = got->rgb[3 * i] - expected->rgb[3 * i],
                     step = i % got->width ? e - before : 0;
        errors += e * e;
        steps += step * step;
        before = e;
    }
    *error = sqrt(errors / pixels);
    *of_steps = sqrt(steps / pixels);
}

static void put_box(scene *s, float x, float y, float z, float half_x, float half_y, float half_z)
{
    const scene_frame f = scene_frame_at(vec(x, y, z), 0, 0);
    scene_put_box(s, &f, vec(half_x, half_y, half_z));
}

bool shafts_hall(scene *s)
{
    const scene_frame ball = scene_frame_at(vec(-1, 0.5f, -0.5f), 0, 0);
    *s = (scene){0};
    scene_begin_object(s, 0.55f, 0.5f, 0.45f);
    put_box(s, 0, -0.1f, 0, 4, 0.1f, 4);
    scene_begin_object(s, 0.7f, 0.6f, 0.5f);
    put_box(s, 0, 3.4f, -1, 4, 0.1f, 3);
    put_box(s, 0, 0.4f, -3.9f, 4, 0.4f, 0.1f);
    put_box(s, 0, 3.05f, -3.9f, 4, 0.25f, 0.1f);
    for (int i = 0; i < 6; i++) put_box(s, -3.5f + 1.4f * (float)i, 1.8f, -3.9f, 0.35f, 1, 0.1f);
    for (int i = 0; i < 5; i++) { // bars
        put_box(s, -2.8f + 1.4f * (float)i, 1.8f, -3.9f, 0.03f, 1, 0.03f);
        put_box(s, -2.8f + 1.4f * (float)i, 1.8f, -3.9f, 0.35f, 0.03f, 0.03f);
    }
    scene_begin_object(s, 0.2f, 0.35f, 0.6f);
    put_box(s, 1.2f, 0.4f, -1, 0.4f, 0.4f, 0.4f);
    scene_put_sphere(s, &ball, 0.5f, 24);
    return scene_end(s);
}
