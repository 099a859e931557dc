// The example components beside the lights: the sampled light adds up to the truth and is the same
// on every run, depth ranges read from the GPU are those of the CPU, shared falloffs give the same
// in GLSL.
#include "../support/gl_state.h"
#include "../support/gl_test.h"
#include "../support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../../examples/common/gl_range.h"
#include "../../examples/common/gl_sampled.h"
#include "../../examples/common/gl_shafts.h"
#include "../../examples/common/raytrace.h"
#include "../../examples/common/shafts.h"

enum { WIDTH = 96, HEIGHT = 72, POINTS = 256 };
static const float position[3] = {-1.6f, 3.2f, 1.2f}, up[3] = {0, 1, 0}, axis[3] = {1, 0, 0};
static const float half_width = 0.3f;

typedef struct stage {
    gl_context context;
    scene s;
    camera eye;
    gl_mesh casters;
    gl_surfaces view;
    GLuint depth_program;
} stage;

static bool begin(stage *t)
{
    message why;
    memset(t, 0, sizeof *t);
    if (!gl_test_begin(&t->context)) return false;
    t->eye = camera_look(vec(0.3f, 3.4f, 5.6f), vec(-0.05f, 0.6f, 0), 0.66f, 4.0f / 3);
    t->depth_program = gl_program_simple("depth", gl_depth_vertex, NULL, &why);
    CHECK(t->depth_program && scene_create(&t->s, 0, NULL) &&
              gl_mesh_upload(&t->casters, &t->s, &why) &&
              gl_surfaces_create(&t->view, WIDTH, HEIGHT, &why),
          "no stage");
    gl_surfaces_draw(&t->view, &t->casters, &t->eye);
    return true;
}

static void end(stage *t)
{
    CHECK(gl.GetError() == GL_NO_ERROR, "a GL error is left");
    scene_free(&t->s);
    gl_context_destroy(&t->context);
}

static mssm_light at_point(const void *light, float x, float y)
{
    const float at[3] = {position[0] + half_width * x, position[1], position[2] + half_width * y};
    mssm_light f = {{0}, 0, 0, 0, 1, 1, -1, 1};
    (void)light;
    CHECK(!mssm_light_spot(&f, at, up, axis, 3, 0.5f, 5, 0, 0), "light");
    return f;
}

static void add(stage *t, gl_sampled *s, unsigned long long state, int points)
{
    gl_sampled_add(s, state, points, at_point, NULL, &t->casters, t->view.target.color, 0.01f);
}

static void read_sum(const gl_sampled *s, float *sum)
{
    gl.GetTextureImage(s->sum.color[0], 0, GL_RGBA, GL_FLOAT,
                       4 * WIDTH * HEIGHT * (GLsizei)sizeof *sum, sum);
}

static void the_sampled_light_is_the_truth(void)
{
    static float sum[4][4 * WIDTH * HEIGHT], place[2][4 * WIDTH * HEIGHT];
    static gl_sampled s;
    stage t;
    message why;
    if (!begin(&t)) return;
    CHECK(gl_sampled_create(&s, 1024, WIDTH, HEIGHT, &why), "create: %s", why.text);
    // All at once, in steps of 7 after another state, again at once after it: the same bits.
    add(&t, &s, 1, POINTS);
    read_sum(&s, sum[0]);
    add(&t, &s, 2, 1);
    CHECK(s.samples == 1, "a new state does not begin anew");
    for (int i = 0; i < POINTS; i += 7) add(&t, &s, 1, POINTS - i < 7 ? POINTS - i : 7);
    CHECK(s.samples == POINTS, "%d samples", s.samples);
    read_sum(&s, sum[1]);
    CHECK(!memcmp(sum[0], sum[1], sizeof sum[0]), "not the same on every run");
    for (int i = 0; i < 2; i++) {
        gl.GetTextureImage(t.view.target.color[i], 0, GL_RGBA, GL_FLOAT, sizeof place[i], place[i]);
    }
    bvh *tree = bvh_create(&t.s);
    double squares = 0;
    int count = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i += 5) {
        const vec3 p = vec_of(place[0] + 4 * i), n = vec_of(place[1] + 4 * i);
        const vec3 middle = vec_of(position), start = vec_mad(p, n, 1e-3f);
        if (place[0][4 * i + 3] == 0 || vec_dot(n, vec_sub(middle, p)) < 0.3f) continue;
        int lit = 0;
        for (int k = 0; k < 256; k++) {
            const float x = ((float)(k % 16) + 0.5f) / 8 - 1,
                        y = ((float)k / 16 + 0.5f / 16) / 8 - 1;
            const vec3 to = vec_add(middle, vec(half_width * x, 0, half_width * y));
            lit += !bvh_hit_any(tree, start, vec_sub(to, start), 1);
        }
        squares += pow((double)(sum[0][4 * i] / sum[0][4 * i + 3]) - lit / 256.0, 2);
        count++;
    }
    bvh_free(tree);
    test_note("rms of %d samples against ray tracing: %.4f over %d pixels", POINTS,
              sqrt(squares / count), count);
    CHECK(count > 200 && sqrt(squares / count) < 0.05, "rms %.4f", sqrt(squares / count));
    gl_sampled_free(&s);
    end(&t);
}

// Any first n points leave no large hole: the largest gap shrinks like that of a Poisson disc.
static void points_are_spread_at_every_number(void)
{
    static gl_sampled s;
    stage t;
    message why;
    if (!begin(&t)) return;
    CHECK(gl_sampled_create(&s, 8, 8, 8, &why), "create: %s", why.text);
    CHECK(s.point[0][0] == 0 && s.point[0][1] == 0, "the middle is not first");
    for (int n = 4; n <= GL_SAMPLED_POINTS; n *= 4) {
        float closest = 9, mean[2] = {0, 0};
        for (int i = 0; i < n; i++) {
            CHECK(fabsf(s.point[i][0]) <= 1 && fabsf(s.point[i][1]) <= 1, "outside");
            mean[0] += s.point[i][0] / (float)n, mean[1] += s.point[i][1] / (float)n;
            for (int j = 0; j < i; j++) {
                closest = fminf(
                    closest, hypotf(s.point[i][0] - s.point[j][0], s.point[i][1] - s.point[j][1]));
            }
        }
        const float grid = 2 / sqrtf((float)n); // distance of as many points on a grid
        CHECK(closest > 0.4f * grid, "%d points, two %.3f of a grid's distance apart", n,
              (double)(closest / grid));
        CHECK(hypotf(mean[0], mean[1]) < 0.6f * grid, "%d points lean to one side", n);
    }
    gl_sampled_free(&s);
    end(&t);
}

// Ranges read from the GPU against a rasterizer of our own; what moves is not cut off.
static void depth_ranges_from_the_gpu(void)
{
    enum { SIDE = 128 };
    static float depth[SIDE * SIDE * 4];
    const mssm_gl_desc desc = {.load = gl_context_function, .lights = 2, .side = SIDE};
    stage t;
    mssm_gl *maps = NULL;
    gl_range range;
    message why;
    mssm_light light[2];
    if (!begin(&t)) return;
    const float low[3] = {-7, -3, -7}, high[3] = {7, 5, 7}, sun[3] = {-0.7f, 1, 0.5f};
    light[0] = at_point(NULL, 0, 0);
    CHECK(!mssm_light_directional(&light[1], sun, axis, 0.1f, 0.1f, low, high), "light");
    CHECK(!mssm_gl_create(&maps, &desc) && gl_range_create(&range, 2, SIDE, &why), "create");
    for (int frame = 0; frame < 4; frame++) {
        for (int i = 0; i < 2; i++) {
            const mssm_light f = gl_range_fit(&range, i, &light[i]);
            const raster_frustum r = {f.world_to_shadow, f.perspective != 0, f.z_near, f.z_far};
            float nearest = 0, farthest = 0;
            CHECK(raster_depth(&t.s, &r, RASTER_FRONT, SIDE, 4, depth), "raster");
            CHECK(mssm_depth_range(depth, SIDE * SIDE * 4, &nearest, &farthest), "nothing drawn");
            // Fitted with a tenth on both sides: 1.2 of the range between -0.99 and 0.8.
            if (frame > 0) {
                CHECK(fabsf(nearest + 0.841f) < 0.03f && fabsf(farthest - 0.651f) < 0.03f,
                      "light %d, frame %d: %g to %g", i, frame, (double)nearest, (double)farthest);
            } else {
                CHECK(f.z_far == light[i].z_far, "fitted to nothing");
            }
            CHECK(!mssm_gl_set_light(maps, i, &f) && !mssm_gl_begin_depth(maps, i, 0), "begin");
            gl.UseProgram(t.depth_program);
            gl.ProgramUniformMatrix4fv(t.depth_program, 0, 1, GL_FALSE, f.world_to_shadow);
            gl_mesh_draw(&t.casters);
            gl_range_reduce(&range, i, maps);
            CHECK(!mssm_gl_end_depth(maps), "end");
        }
    }
    gl_range_free(&range);
    mssm_gl_destroy(maps);
    end(&t);
}

// Loose triangles, seen from both sides and cut by both planes: the same depth from either
// rasterizer.
static void rasterizers_agree(void)
{
    enum { SIDE = 200, COUNT = 40 };
    static float cpu[SIDE * SIDE], got[SIDE * SIDE];
    const GLenum formats[GL_TARGET_COLORS] = {GL_RGBA8};
    const float low[3] = {-1.5f, -1, -1.5f}, high[3] = {1.5f, 1, 1.5f}, sun[3] = {0.4f, 1, 0.3f};
    const float at[3] = {1, 2.5f, 0.5f};
    stage t;
    gl_target target;
    gl_mesh loose = {0};
    scene s = {0};
    message why;
    uint64_t state = 6;
    mssm_light light[2];
    if (!begin(&t)) return;
    scene_begin_object(&s, 1, 1, 1);
    for (int i = 0; i < 3 * COUNT; i++) {
        scene_put_vertex(&s,
                         vec((float)test_range(&state, -2, 2), (float)test_range(&state, -2, 2),
                             (float)test_range(&state, -2, 2)),
                         vec(0, 1, 0));
        if (i % 3 == 2) scene_put_triangle(&s, i - 2, i - 1, i);
    }
    CHECK(scene_end(&s) && gl_mesh_upload(&loose, &s, &why) &&
              gl_target_create(&target, SIDE, SIDE, 0, formats, &why),
          "create");
    CHECK(!mssm_light_directional(&light[0], sun, axis, 0.1f, 0.1f, low, high) &&
              !mssm_light_spot(&light[1], at, sun, axis, 1, 1, 3.5f, 0.1f, 0.1f),
          "lights");
    for (int k = 0; k < 4; k++) {
        const mssm_light *f = &light[k / 2];
        const bool back = k % 2;
        const raster_frustum r = {f->world_to_shadow, f->perspective != 0, f->z_near, f->z_far};
        int off = 0, hit = 0;
        CHECK(raster_depth(&s, &r, back ? RASTER_BACK : RASTER_FRONT, SIDE, 1, cpu), "raster");
        gl_target_begin(&target);
        gl.UseProgram(t.depth_program);
        gl.ProgramUniformMatrix4fv(t.depth_program, 0, 1, GL_FALSE, f->world_to_shadow);
        gl.Enable(GL_DEPTH_TEST);
        if (back) gl.Enable(GL_CULL_FACE);
        gl.CullFace(GL_FRONT);
        gl_mesh_draw(&loose);
        gl.CullFace(GL_BACK);
        gl.Disable(GL_CULL_FACE);
        gl.Disable(GL_DEPTH_TEST);
        gl.GetTextureImage(target.depth, 0, GL_DEPTH_COMPONENT, GL_FLOAT, (GLsizei)sizeof got, got);
        for (int i = 0; i < SIDE * SIDE; i++) {
            float z = 2 * got[i] - 1;
            if (f->perspective && z < 1) { // to linear
                const float n = f->z_near,
                            w = 2 * f->z_far * n / (f->z_far + n - z * (f->z_far - n));
                z = -1 + 2 * (w - n) / (f->z_far - n);
            }
            hit += cpu[i] < 1;
            off += !(fabsf(z - cpu[i]) < 2e-3f);
        }
        // Edges are drawn to a part of a pixel.
        CHECK(hit > SIDE * SIDE / 4 && off < hit / 100, "%d: %d of %d samples differ", k, off, hit);
        test_note("%s, %s: %d of %d samples differ", k / 2 ? "spot" : "sun", back ? "back" : "all",
                  off, hit);
    }
    gl_target_free(&target);
    gl_mesh_free(&loose);
    scene_free(&s);
    end(&t);
}

// ---- Shared functions in GLSL --------------------------------------------------------------------

enum { CASES = 4096 };
static const char ask_text[] =
    "layout(local_size_x = 64) in;\n"
    "layout(std430, binding = 0) readonly buffer Inputs { vec4 asked[]; };\n"
    "layout(std430, binding = 1) writeonly buffer Outputs { float told[][9]; };\n"
    "void main()\n"
    "{\n"
    "    uint i = gl_GlobalInvocationID.x;\n"
    "    vec4 a = asked[i];\n"
    "    mssm_faces f = mssm_point_faces(a.x, a.y, a.z);\n"
    "    for (int k = 0; k < 3; k++) {\n"
    "        told[i][k] = float(f.face[k]);\n"
    "        told[i][3 + k] = f.weight[k];\n"
    "    }\n"
    "    told[i][6] = mssm_attenuation(abs(a.x), 0.5, abs(a.y), abs(a.z));\n"
    "    told[i][7] = mssm_cone(0.25 * a.w, 0.8, 0.6, 3.0);\n"
    "    told[i][8] = mssm_cone(a.w, 0.0, -6.0, i % 8 < 4 ? a.z : 0.0);\n"
    "}\n";

static void falloffs_are_the_same_in_glsl(void)
{
    static float asked[CASES][4], told[CASES][9];
    const char *const text[] = {mssm_glsl_lights(), ask_text, NULL};
    stage t;
    GLuint buffer[2];
    uint64_t state = 4;
    if (!begin(&t)) return;
    for (int i = 0; i < CASES; i++) {
        for (int k = 0; k < 4; k++) asked[i][k] = (float)test_range(&state, -4, 4);
        if (i % 2) asked[i][1] = asked[i][0] * (float)test_range(&state, 0.9, 1.1); // near an edge
        if (i % 5 == 0) asked[i][3] = (float)(i / 5 % 3 - 1);
    }
    const GLuint program = gl_test_compute("mssm_glsl_lights", text);
    for (GLuint i = 0; i < 2; i++) {
        gl.CreateBuffers(1, &buffer[i]);
        gl.NamedBufferStorage(buffer[i], i ? sizeof told : sizeof asked, i ? NULL : asked, 0);
        gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, i, buffer[i]);
    }
    gl.UseProgram(program);
    gl.DispatchCompute(CASES / 64, 1, 1);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl.GetNamedBufferSubData(buffer[1], 0, sizeof told, told);
    for (int i = 0; i < CASES; i++) {
        const float *a = asked[i], *b = told[i];
        const mssm_faces f = mssm_point_faces(a[0], a[1], a[2]);
        for (int k = 0; k < 3; k++) {
            CHECK(b[k] == (float)f.face[k] && fabsf(b[3 + k] - f.weight[k]) < 1e-5f, "faces");
        }
        const float d = mssm_attenuation(fabsf(a[0]), 0.5f, fabsf(a[1]), fabsf(a[2]));
        CHECK(fabsf(b[6] - d) < 1e-5f * d, "attenuation %g, not %g", (double)b[6], (double)d);
        CHECK(fabsf(b[7] - mssm_cone(0.25f * a[3], 0.8f, 0.6f, 3)) < 1e-5f, "cone");
        CHECK(fabsf(b[8] - mssm_cone(a[3], 0, -6, i % 8 < 4 ? a[2] : 0)) < 1e-5f, "cone of %g",
              (double)a[3]);
    }
    gl.DeleteBuffers(2, buffer);
    gl.DeleteProgram(program);
    end(&t);
}

// ---- What components leave behind ----------------------------------------------------------------

// Of all kinds that components make, by their names.
static int living_objects(void)
{
    static const char *const ask[] = {"glIsBuffer", "glIsFramebuffer", "glIsProgram",
                                      "glIsShader", "glIsTexture",     "glIsVertexArray"};
    int count = 0;
    gl.UseProgram(0); // which would keep one alive
    for (int k = 0; k < 6; k++) {
        GLboolean(GL_CALL * is)(GLuint) = (GLboolean(GL_CALL *)(GLuint))gl_context_function(ask[k]);
        for (GLuint name = 1; name < 4096; name++) count += is(name) != 0;
    }
    return count;
}

// The driver refuses the answer-th program or framebuffer.
static gl_functions driver;
static int answer;

static void GL_CALL refuse_program(GLuint program, GLenum name, GLint *value)
{
    driver.GetProgramiv(program, name, value);
    if (name == GL_LINK_STATUS && --answer == 0) *value = GL_FALSE;
}

static GLenum GL_CALL refuse_framebuffer(GLuint framebuffer, GLenum target)
{
    return --answer == 0 ? 0 : driver.CheckNamedFramebufferStatus(framebuffer, target);
}

static struct {
    gl_range range;
    gl_sampled sampled;
    gl_shafts shafts;
    GLuint shafts_program;
} made;

static bool create_range(message *why)
{
    return gl_range_create(&made.range, 2, 64, why);
}

static void free_range(void)
{
    gl_range_free(&made.range);
}

static bool create_sampled(message *why)
{
    return gl_sampled_create(&made.sampled, 64, WIDTH, HEIGHT, why);
}

static void free_sampled(void)
{
    gl_sampled_free(&made.sampled);
}

static bool create_shafts(message *why)
{
    made.shafts_program = gl_shafts_program("shafts", NULL, why);
    return made.shafts_program && gl_shafts_create(&made.shafts, 64, 64, why);
}

static void free_shafts(void)
{
    if (made.shafts_program) gl.DeleteProgram(made.shafts_program);
    gl_shafts_free(&made.shafts);
}

static const struct {
    const char *name;
    bool (*create)(message *why);
    void (*free)(void);
    int refusals; // programs and framebuffers
} components[] = {{"gl_range", create_range, free_range, 1},
                  {"gl_sampled", create_sampled, free_sampled, 4},
                  {"gl_shafts", create_shafts, free_shafts, 2}};

static void components_leave_no_objects(void)
{
    stage t;
    if (!begin(&t)) return;
    driver = gl;
    for (int k = 0; k < 3; k++) {
        const int had = living_objects();
        bool whole = false;
        for (int i = 1; !whole; i++) {
            message why = {""};
            memset(&made, 0, sizeof made);
            answer = i;
            gl.GetProgramiv = refuse_program;
            gl.CheckNamedFramebufferStatus = refuse_framebuffer;
            whole = components[k].create(&why);
            gl = driver;
            CHECK(whole == (i > components[k].refusals) && whole == !why.text[0], "%s, %d: %s",
                  components[k].name, i, why.text);
            CHECK(!whole || living_objects() > had, "%s: no objects seen", components[k].name);
            components[k].free();
            const int left = living_objects() - had;
            CHECK(left == 0, "%s, refusal %d: %d objects left", components[k].name, i, left);
        }
    }
    end(&t);
}

static gl_state before, after;

static void check_changes(const char *call, const char *documented)
{
    char text[800];
    gl_state_take(&after);
    const int n = gl_state_differences(&before, &after, documented, text, sizeof text);
    CHECK(n == 0, "%s changes%s", call, text);
    gl_state_take(&before);
}

static void components_change_what_their_headers_say(void)
{
    const GLenum none[GL_TARGET_COLORS] = {0};
    const float low[3] = {-4, -1, -4}, high[3] = {4, 3, 4};
    stage t;
    message why = {""};
    gl_target depth;
    GLuint map;
    mssm_light light;
    mssm_scattering from;
    mssm_gl *maps = NULL;
    const mssm_gl_desc desc = {.load = gl_context_function, .lights = 2, .side = 64};
    if (!begin(&t)) return;
    CHECK(!mssm_light_directional(&light, up, axis, 0, 0, low, high) &&
              shafts_look(&from, &light, &t.eye, 0.1f) &&
              gl_target_create(&depth, 64, 64, 4, none, &why),
          "%s", why.text);
    gl.CreateTextures(GL_TEXTURE_2D_ARRAY, 1, &map);
    gl.TextureStorage3D(map, 1, GL_RGBA16, 64, 64, 1);
    CHECK(!mssm_gl_create(&maps, &desc) && !mssm_gl_set_light(maps, 1, &light), "maps");
    gl_state_take(&before);
    for (int k = 0; k < 3; k++) CHECK(components[k].create(&why), "%s", why.text);
    check_changes("creating", NULL);
    gl_target_begin(&depth);
    CHECK(!mssm_gl_begin_depth(maps, 1, 0), "begin");
    gl_state_take(&before);
    for (int frame = 0; frame < 2; frame++) { // the first range comes from nowhere
        gl_range_fit(&made.range, 1, &light);
        check_changes("gl_range_fit", NULL);
        gl_range_reduce(&made.range, 1, maps);
        check_changes("gl_range_reduce", "CURRENT_PROGRAM TEXTURE_BINDING_2D_MULTISAMPLE_ARRAY[0] "
                                         "SHADER_STORAGE_BUFFER[0] SHADER_STORAGE_BUFFER_BINDING");
    }
    CHECK(!mssm_gl_end_depth(maps), "end");
    mssm_gl_destroy(maps);
    gl.Enable(GL_DEPTH_TEST);
    gl.Enable(GL_BLEND);
    gl_state_take(&before);
    add(&t, &made.sampled, 1, 2);
    check_changes("gl_sampled_add",
                  "DRAW_FRAMEBUFFER_BINDING READ_FRAMEBUFFER_BINDING DRAW_BUFFER READ_BUFFER "
                  "VIEWPORT COLOR_CLEAR_VALUE CURRENT_PROGRAM VERTEX_ARRAY_BINDING "
                  "ELEMENT_ARRAY_BUFFER_BINDING TEXTURE_BINDING_2D[0] TEXTURE_BINDING_2D[1] "
                  "TEXTURE_BINDING_2D[2] DEPTH_TEST BLEND BLEND_DST_RGB BLEND_DST_ALPHA");
    gl_shafts_update(&made.shafts, &from, map);
    check_changes("gl_shafts_update",
                  "CURRENT_PROGRAM SHADER_STORAGE_BUFFER[8] SHADER_STORAGE_BUFFER_BINDING "
                  "TEXTURE_BINDING_2D[8] TEXTURE_BINDING_2D_ARRAY[8] TEXTURE_BINDING_2D[9] "
                  "IMAGE_BINDING_NAME[0] IMAGE_BINDING_NAME[1] IMAGE_BINDING_ACCESS[0] "
                  "IMAGE_BINDING_ACCESS[1] IMAGE_BINDING_FORMAT[0] IMAGE_BINDING_FORMAT[1]");
    gl.Enable(GL_BLEND);
    gl_state_take(&before);
    gl_shafts_draw(made.shafts_program, t.view.target.color[0], &t.eye, 0.1f, 9, vec(1, 1, 1));
    check_changes("gl_shafts_draw", "CURRENT_PROGRAM VERTEX_ARRAY_BINDING TEXTURE_BINDING_2D[10] "
                                    "BLEND BLEND_DST_RGB BLEND_DST_ALPHA");
    for (int k = 0; k < 3; k++) components[k].free();
    gl_target_free(&depth);
    gl.DeleteTextures(1, &map);
    gl_state_free(&before);
    gl_state_free(&after);
    end(&t);
}

static void targets_are_read_as_means(void)
{
    const GLenum formats[GL_TARGET_COLORS] = {GL_RGBA32F};
    stage t;
    message why = {""};
    gl_target target;
    gl_mesh all;
    image picture;
    if (!begin(&t)) return;
    const GLuint program = gl_program_simple(
        "samples", gl_triangle_vertex,
        "out vec4 color;\n"
        "void main() { color = vec4(float(gl_SampleID) / float(gl_NumSamples - 1)); }\n",
        &why);
    CHECK(program && gl_target_create(&target, 8, 4, 4, formats, &why), "%s", why.text);
    gl_mesh_triangle(&all);
    gl_target_begin(&target);
    gl.UseProgram(program);
    gl_mesh_draw(&all);
    const int had = living_objects();
    gl_state_take(&before);
    CHECK(gl_target_read(&target, &picture, &why), "%s", why.text);
    check_changes("gl_target_read", NULL);
    CHECK(living_objects() == had, "objects left");
    CHECK(picture.width == 8 && picture.height == 4, "%d x %d", picture.width, picture.height);
    for (int i = 0; i < 8 * 4 * 3; i++)
        CHECK(fabsf(picture.rgb[i] - 0.5f) < 1e-6f, "%g", (double)picture.rgb[i]);
    image_free(&picture);
    gl_target_free(&target);
    gl_mesh_free(&all);
    gl.DeleteProgram(program);
    gl_state_free(&before);
    gl_state_free(&after);
    end(&t);
}

const test_case lights_gl_tests[] = {
    {"GL: the sampled light is the truth, and the same on every run",
     the_sampled_light_is_the_truth},
    {"GL: the sampled light's points are spread at every number",
     points_are_spread_at_every_number},
    {"GL: the CPU's rasterizer culls and cuts alike", rasterizers_agree},
    {"GL: depth ranges from the GPU are those drawn", depth_ranges_from_the_gpu},
    {"GL: falloffs of lights are the same in GLSL", falloffs_are_the_same_in_glsl},
    {"GL: components leave no objects, whatever the driver refuses", components_leave_no_objects},
    {"GL: components change the state that their headers name",
     components_change_what_their_headers_say},
    {"GL: a multisampled target is read as the mean of its samples", targets_are_read_as_means},
    {0, 0}};
