// Smoke in front of, between and behind solids, drawn into moment maps by OpenGL: what the maps say
// encloses what a ray through the same puffs and triangles loses, hard and soft.
#include "../support/gl_test.h"
#include "../support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../../examples/common/gl_smoke_plume.h"
#include "../../mssm.h"

enum { SIDE = 128, ALONG = 32, RAYS = 64, POINTS = ALONG * RAYS, TEXELS = SIDE * SIDE };

static struct {
    gl_context context;
    scene solids;
    gl_mesh casters, receivers, triangle;
    gl_smoke_plume plume;
    bvh *tree;
    mssm_light light;
    mssm_gl *map;
    mssm_gl *tables;
    gl_target answers;
    float point[POINTS][4], shadow[POINTS][3],
        answer[POINTS];        // ALONG points a ray, going away from the sun
    float encoded[TEXELS * 6]; // as drawn
    float rounded[TEXELS * 6]; // as stored
} stage;

static const float to_sun[3] = {-0.6f, 0.64f, 0.48f}, axis[3] = {0, 1, 0};
static const char layer_text[] =
    "void main() { mssm_translucent(2 * gl_FragCoord.z - 1, opacity()); }\n";
static const char answer_text[] = // behind a text that declares visibility()
    "layout(std430, binding = 7) readonly buffer points { vec4 point[]; };\n"
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    color = vec4(visibility(point[at.y * 32 + at.x].xyz));\n"
    "}\n";

// From shadow space into the world; the matrix has orthogonal rows.
static void unproject(const float shadow[3], float point[4])
{
    const float *m = stage.light.world_to_shadow;
    for (int k = 0; k < 4; k++) point[k] = 0;
    for (int i = 0; i < 3; i++) {
        const float square = m[i] * m[i] + m[4 + i] * m[4 + i] + m[8 + i] * m[8 + i];
        for (int k = 0; k < 3; k++) {
            point[k] += m[4 * k + i] * (shadow[i] - m[12 + i]) / square;
        }
    }
}

// Whether no edge of a solid runs through a texel: its samples would see more than its middle.
static bool is_plain(const float middle[3])
{
    float least = HUGE_VALF, most = 0;
    for (int i = 0; i < 4; i++) {
        const float corner[3] = {middle[0] + (i % 2 ? 1.0f : -1.0f) / SIDE,
                                 middle[1] + (i > 1 ? 1.0f : -1.0f) / SIDE, -1};
        float from[4];
        unproject(corner, from);
        const float hit = bvh_hit_nearest(stage.tree, vec_of(from), vec_scale(vec_of(to_sun), -1));
        least = fminf(least, hit);
        most = fmaxf(most, hit);
    }
    return most - least < 0.1f;
}

// The middle of a texel that the plume covers.
static void choose_ray(uint64_t *seed, float shadow[3])
{
    do {
        const int puff = (int)test_range(seed, 0, GL_SMOKE_PUFFS);
        const vec3 c = stage.plume.puff[puff].centre;
        const float at[3] = {c.x, c.y, c.z};
        CHECK(mssm_light_project(&stage.light, at, shadow), "projection");
        for (int k = 0; k < 2; k++) {
            shadow[k] = -1 + (2 * floorf((0.5f + 0.5f * shadow[k]) * SIDE) + 1) / SIDE;
        }
    } while (!is_plain(shadow));
}

static void choose_points(void)
{
    uint64_t seed = 91;
    for (int i = 0; i < POINTS; i++) {
        float *s = stage.shadow[i];
        if (i % ALONG == 0) choose_ray(&seed, s);
        if (i % ALONG != 0) memcpy(s, s - 3, 2 * sizeof *s);
        s[2] = -0.95f + 1.8f * ((float)(i % ALONG) + (float)test_uniform(&seed)) / ALONG;
        unproject(s, stage.point[i]);
    }
}

static bool begin(int moments)
{
    const mssm_gl_desc hard = {.load = gl_context_function,
                               .filtered = 1,
                               .side = SIDE,
                               .samples = 1,
                               .moments = moments,
                               .radius = -1,
                               .filter = {0, 1e-6f, 1},
                               .first_buffer_binding = 1};
    const mssm_gl_desc soft = {
        .load = gl_context_function, .side = SIDE, .first_buffer_binding = 1};
    const GLenum formats[GL_TARGET_COLORS] = {GL_RGBA32F};
    float low[3], high[3];
    message why = {"no memory"};
    memset(&stage, 0, sizeof stage);
    if (!gl_test_begin(&stage.context)) return false;
    gl_mesh_triangle(&stage.triangle);
    const bool made = gl_smoke_scene(&stage.solids, &stage.casters, &stage.receivers, &stage.plume,
                                     low, high, &why) &&
                      (stage.tree = bvh_create(&stage.solids)) &&
                      gl_target_create(&stage.answers, ALONG, RAYS, 1, formats, &why) &&
                      !mssm_light_directional(&stage.light, to_sun, axis, 0.1f, 0.1f, low, high) &&
                      !mssm_gl_create(&stage.map, &hard) && !mssm_gl_create(&stage.tables, &soft) &&
                      !mssm_gl_set_light(stage.map, 0, &stage.light) &&
                      !mssm_gl_set_light(stage.tables, 0, &stage.light);
    CHECK(made, "%s", why.text);
    if (made) choose_points();
    return made;
}

static void end(void)
{
    CHECK(gl.GetError() == GL_NO_ERROR, "GL error");
    mssm_gl_destroy(stage.map);
    mssm_gl_destroy(stage.tables);
    gl_target_free(&stage.answers);
    gl_smoke_free(&stage.plume);
    gl_mesh_free(&stage.receivers); // casters share its buffers
    gl_mesh_free(&stage.triangle);
    bvh_free(stage.tree);
    scene_free(&stage.solids);
    gl_context_destroy(&stage.context);
}

static void draw_maps(int moments)
{
    static float part[2][TEXELS * 4];
    message why = {""};
    const char *const vertex[] = {gl_smoke_vertex, NULL};
    const char *const text[] = {mssm_glsl_math(), mssm_glsl_translucent(), gl_smoke_opacity,
                                layer_text, NULL};
    const GLuint depth = gl_program_simple("depth", gl_depth_vertex, NULL, &why);
    const GLuint layer = gl_program("layer", vertex, text, &why);
    CHECK(depth && layer, "%s", why.text);
    CHECK(!mssm_gl_begin_depth(stage.map, 0, 0), "begin");
    gl.UseProgram(depth);
    gl.ProgramUniformMatrix4fv(depth, 0, 1, GL_FALSE, stage.light.world_to_shadow);
    gl_mesh_draw(&stage.casters);
    CHECK(!mssm_gl_end_depth(stage.map), "end");
    CHECK(!mssm_gl_begin_translucent(stage.map), "begin");
    gl_smoke_draw(&stage.plume, layer, stage.light.world_to_shadow, vec_of(to_sun), 0);
    CHECK(!mssm_gl_end_translucent(stage.map), "end");
    gl.GetTextureImage(mssm_gl_texture(stage.map, 3), 0, GL_RGBA, GL_FLOAT, sizeof part, part);
    for (int i = 0; i < 6 * TEXELS; i++) stage.encoded[i] = part[i % 6 / 3][i / 6 * 4 + i % 3];
    CHECK(!mssm_gl_set_moments(stage.tables, 0, mssm_gl_texture(stage.map, 3)), "moments");
    CHECK(!mssm_gl_build(stage.tables) && !mssm_gl_build(stage.map), "build");
    for (int k = 0; k < moments / 4 + moments % 4 / 2; k++) {
        gl.GetTextureImage(mssm_gl_texture(stage.map, (unsigned)k != 0), 0, GL_RGBA, GL_FLOAT,
                           sizeof part[0], part[k]);
    }
    for (int i = 0; i < 6 * TEXELS; i++) stage.rounded[i] = part[i % 6 / 4][i / 6 * 4 + i % 6 % 4];
    gl.DeleteProgram(depth);
    gl.DeleteProgram(layer);
}

// Visibility of all points by a text that declares visibility(vec3).
static void ask(const char *shader, const char *visibility)
{
    message why = {""};
    image result;
    GLuint buffer;
    const char *const vertex[] = {gl_triangle_vertex, NULL};
    const char *const text[] = {shader, visibility, answer_text, NULL};
    const GLuint program = gl_program("answers", vertex, text, &why);
    gl.CreateBuffers(1, &buffer);
    gl.NamedBufferStorage(buffer, sizeof stage.point, stage.point, 0);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 7, buffer);
    gl_target_begin(&stage.answers);
    gl.UseProgram(program);
    gl_mesh_draw(&stage.triangle);
    CHECK(program && gl_target_read(&stage.answers, &result, &why), "%s", why.text);
    for (int i = 0; i < POINTS; i++) {
        stage.answer[i] = image_get(&result, i % ALONG, RAYS - 1 - i / ALONG).x;
    }
    image_free(&result);
    gl.DeleteBuffers(1, &buffer);
    gl.DeleteProgram(program);
}

static const char hard_text[] =
    "float visibility(vec3 p) { return mssm_filtered_visibility(0, p, vec3(0), vec3(0)); }\n";

// By the definition of a puff, over all of them.
static double true_visibility(const float point[4])
{
    const vec3 p = vec_of(point), d = vec_of(to_sun);
    double through = bvh_hit_any(stage.tree, p, d, 100) ? 0 : 1;
    for (int i = 0; i < GL_SMOKE_PUFFS; i++) {
        const gl_smoke_puff *puff = stage.plume.puff + i;
        const vec3 to = vec_sub(puff->centre, p);
        const double t = (double)vec_dot(to, d), r = (double)puff->radius;
        const double f = 1 - ((double)vec_dot(to, to) - t * t) / (r * r);
        if (t > 0 && f > 0) through *= 1 - (double)puff->opacity * f * f;
    }
    return through;
}

// Floor and wall, which the map does not have, are between the sun and what lies behind them.
static bool in_front(const float point[4])
{
    return point[1] > 0.001f && point[2] > -1.49f;
}

static mssm_bounds stored_bounds(int i, int moments)
{
    const float *s = stage.shadow[i];
    const int x = (int)((0.5f + 0.5f * s[0]) * SIDE), y = (int)((0.5f + 0.5f * s[1]) * SIDE);
    mssm_moments6 six;
    mssm_moments4 four;
    memcpy(six.b, stage.rounded + (y * SIDE + x) * 6, sizeof six.b);
    six = mssm_moments6_decode(six);
    memcpy(four.b, six.b, sizeof four.b);
    return moments == 6
               ? mssm_visibility6(mssm_moments6_bias_encoded(six, MSSM_BIAS6_UNORM16), s[2])
               : mssm_visibility4(mssm_moments4_bias_encoded(four, MSSM_BIAS4_UNORM16), s[2]);
}

static void smoke_and_solids_are_enclosed(void)
{
    for (int moments = 4; moments <= 6; moments += 2) {
        if (!begin(moments)) return;
        double above = 0, below = 0, gap = 0, middle = 0;
        int asked = 0, partial = 0;
        draw_maps(moments);
        mssm_gl_bind(stage.map);
        ask(mssm_gl_shader(stage.map), hard_text);
        for (int i = 0; i < POINTS; i++) {
            if (!in_front(stage.point[i])) continue;
            const double truth = true_visibility(stage.point[i]);
            const mssm_bounds b = stored_bounds(i, moments);
            const double upper = (double)stage.answer[i], lower = (double)b.lower;
            above = fmax(above, truth - upper);
            below = fmax(below, lower - truth);
            gap += upper - truth;
            middle += fabs(0.5 * (upper + lower) - truth);
            asked++;
            partial += truth > 0.1 && truth < 0.9;
        }
        CHECK(partial > asked / 10 && asked > POINTS / 4, "%d of %d in part shadow", partial,
              asked);
        CHECK(above < 1e-4, "truth above the upper bound by %g", above);
        CHECK(below < 1e-4, "truth below the lower bound by %g", below);
        test_note(
            "%d moments: truth outside by %.1e, %.1e; upper bound too light by %.3f in the mean, "
            "middle of the bounds off by %.3f (%d points)",
            moments, above, below, gap / asked, middle / asked, asked);
        end();
    }
}

static void smoke_darkens_towards_its_back(void)
{
    for (int moments = 4; moments <= 6; moments += 2) {
        if (!begin(moments)) return;
        float worst = 0, least = 1, most = 0;
        draw_maps(moments);
        mssm_gl_bind(stage.map);
        ask(mssm_gl_shader(stage.map), hard_text);
        for (int i = 0; i < POINTS; i++) {
            if (i % ALONG) worst = fmaxf(worst, stage.answer[i] - stage.answer[i - 1]);
            least = fminf(least, stage.answer[i]);
            most = fmaxf(most, stage.answer[i]);
        }
        CHECK(least < 0.1f && most > 0.99f, "from %g to %g only", (double)most, (double)least);
        CHECK(worst < 1e-5f, "lighter by %g further back", (double)worst);
        test_note("%d moments: lighter by %.1e at worst", moments, (double)worst);
        end();
    }
}

static void soft_tables_agree_with_cpu(void)
{
    if (!begin(6)) return;
    mssm_map *map;
    double mean = 0, worst = 0;
    int partial = 0;
    const size_t bytes = mssm_map_bytes(SIDE, 6);
    void *memory = malloc(bytes);
    draw_maps(6);
    CHECK(!mssm_map_init(&map, memory, bytes, SIDE, 6), "init");
    CHECK(!mssm_map_update_moments(map, stage.encoded), "update");
    mssm_gl_bind(stage.tables);
    ask(mssm_gl_shader(stage.tables),
        "float visibility(vec3 p) { return mssm_visibility(0, p); }\n");
    for (int i = 0; i < POINTS; i++) {
        const float cpu = mssm_map_visibility(map, &stage.light, NULL, stage.point[i]);
        const double off = fabs((double)(cpu - stage.answer[i]));
        mean += off / POINTS;
        worst = fmax(worst, off);
        partial += cpu > 0.1f && cpu < 0.9f;
    }
    CHECK(partial > POINTS / 10, "%d points in part shadow", partial);
    CHECK(mean < 1e-4 && worst < 0.01, "GL differs by %g, at worst %g", mean, worst);
    test_note("GL differs by %.1e, at worst %.1e", mean, worst);
    free(memory);
    end();
}

const test_case smoke_tests[] = {
    {"smoke GL: bounds enclose what rays lose in puffs and solids", smoke_and_solids_are_enclosed},
    {"smoke GL: visibility falls with depth", smoke_darkens_towards_its_back},
    {"smoke GL: soft shadows agree with the CPU's tables of the same moments",
     soft_tables_agree_with_cpu},
    {0, 0}};
