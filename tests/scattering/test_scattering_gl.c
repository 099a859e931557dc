// Light shafts in OpenGL: the shared math gives C's numbers, the passes give those of the CPU.
#include "../support/gl_test.h"
#include "../support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../examples/common/gl_shafts.h"
#include "../../examples/common/shafts.h"

enum { INPUTS = 1 << 15, IN = 12, OUT = 16 };
static const float sun[3] = {-0.4f, 0.8f, -1}, axis[3] = {1, 0, 0}, extinction = 0.2f;

// clang-format off
static const char ask_text[] =
    "layout(local_size_x = 64) in;\n"
    "layout(std430, binding = 0) readonly buffer View { mssm_scattering s; };\n"
    "layout(std430, binding = 1) readonly buffer Inputs { float a[]; };\n"
    "layout(std430, binding = 2) writeonly buffer Results { float r[]; };\n"
    "void main()\n"
    "{\n"
    "    uint i = 12 * gl_GlobalInvocationID.x, o = 16 * gl_GlobalInvocationID.x;\n"
    "    mssm_epipolar row = mssm_scattering_row(s, a[i]);\n"
    "    mssm_view_ray ray = mssm_scattering_ray(s, a[i + 1], a[i + 2], a[i + 3], a[i + 4]);\n"
    "    mssm_moments6 m = mssm_scattering_moments(s, a[i + 5], a[i + 6], a[i + 7], a[i + 8]);\n"
    "    r[o] = row.first; r[o + 1] = row.extent;\n"
    "    r[o + 2] = mssm_scattering_distance(row, a[i + 9]);\n"
    "    r[o + 3] = ray.row; r[o + 4] = ray.column; r[o + 5] = ray.depth;\n"
    "    r[o + 6] = ray.share; r[o + 7] = ray.upper;\n"
    "    r[o + 8] = mssm_inclination(s, a[i + 5], a[i + 10]);\n"
    "    for (int k = 0; k < 6; k++) r[o + 9 + k] = m.b[k];\n"
    "    r[o + 15] = mssm_scattering_visibility(ray, mssm_moments6_bias(m, 1e-3));\n"
    "}\n";
// clang-format on

static void ask_c(const mssm_scattering *s, const float *a, float *r)
{
    const mssm_epipolar row = mssm_scattering_row(*s, a[0]);
    const mssm_view_ray ray = mssm_scattering_ray(*s, a[1], a[2], a[3], a[4]);
    const mssm_moments6 m = mssm_scattering_moments(*s, a[5], a[6], a[7], a[8]);
    r[0] = row.first;
    r[1] = row.extent;
    r[2] = mssm_scattering_distance(row, a[9]);
    r[3] = ray.row;
    r[4] = ray.column;
    r[5] = ray.depth;
    r[6] = ray.share;
    r[7] = ray.upper;
    r[8] = mssm_inclination(*s, a[5], a[10]);
    memcpy(r + 9, m.b, sizeof m.b);
    r[15] = mssm_scattering_visibility(ray, mssm_moments6_bias(m, 1e-3f));
}

static void random_input(uint64_t *seed, float *a)
{
    const vec3 d = vec_unit(vec((float)test_range(seed, -1, 1), (float)test_range(seed, -1, 1),
                                (float)test_range(seed, -1, 1)));
    double b[3] = {0};
    for (int i = 0; i < 4; i++) {
        const double z = test_range(seed, -1, 1);
        for (int k = 0; k < 3; k++) b[k] += 0.25 * pow(z, k + 1);
    }
    a[0] = (float)test_range(seed, -3.14, 3.14);
    a[1] = d.x;
    a[2] = d.y;
    a[3] = d.z;
    a[4] = powf(10, (float)test_range(seed, -1, 1.5));
    a[5] = (float)test_range(seed, 0.01, 6);
    for (int k = 0; k < 3; k++) a[6 + k] = (float)b[k];
    a[9] = (float)test_range(seed, 0, 1);
    a[10] = (float)test_range(seed, -1, 1);
    a[11] = 0;
}

// The driver's exp, log and atan are its own: GLSL asks for 4 units of the last place and more.
static void shared_math_agrees(void)
{
    gl_context c;
    if (!gl_test_begin(&c)) return;
    static float in[INPUTS * IN], out[INPUTS * OUT];
    const camera eye = camera_look(vec(2.5f, 1.4f, 3.2f), vec(-0.5f, 1.2f, -2), 0.9f, 1.5f);
    const float low[3] = {-4, -1, -4}, high[3] = {4, 3, 4};
    const char *const text[] = {mssm_glsl_math(), mssm_glsl_scattering(), ask_text, NULL};
    const GLuint program = gl_test_compute("scattering", text);
    uint64_t seed = 96;
    mssm_light light;
    mssm_scattering s;
    GLuint buffer[3];
    float worst[OUT] = {0};
    int off = 0;
    mssm_light_directional(&light, sun, axis, 0, 0, low, high);
    CHECK(shafts_look(&s, &light, &eye, extinction), "look");
    s.balance = 0.5f;
    for (int i = 0; i < INPUTS; i++) random_input(&seed, in + i * IN);
    gl.CreateBuffers(3, buffer);
    gl.NamedBufferStorage(buffer[0], sizeof s, &s, 0);
    gl.NamedBufferStorage(buffer[1], sizeof in, in, 0);
    gl.NamedBufferStorage(buffer[2], sizeof out, NULL, 0);
    for (GLuint i = 0; i < 3; i++) gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, i, buffer[i]);
    gl.UseProgram(program);
    gl.DispatchCompute(INPUTS / 64, 1, 1);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl.GetNamedBufferSubData(buffer[2], 0, sizeof out, out);
    for (int i = 0; i < INPUTS; i++) {
        float r[OUT];
        ask_c(&s, in + i * IN, r);
        for (int k = 0; k < OUT; k++) {
            const float e = fabsf(r[k] - out[i * OUT + k]);
            if (k == 15 && e > 1e-3f) off++; // where the bounds jump
            if (k < 15 || e <= 1e-3f) worst[k] = fmaxf(worst[k], e);
            CHECK(isfinite(out[i * OUT + k]), "input %d, result %d", i, k);
        }
    }
    for (int k = 0; k < OUT; k++)
        CHECK(worst[k] < 1e-3f, "result %d is %g off", k, (double)worst[k]);
    test_note("moments off by at most %.2g, column by %.2g, share by %.2g; visibility by more than "
              "0.001 for %.3f%%",
              (double)worst[14], (double)worst[4], (double)worst[6], 100.0 * off / INPUTS);
    CHECK(off < INPUTS / 500, "%d visibilities are off", off);
    gl.DeleteBuffers(3, buffer);
    gl.DeleteProgram(program);
    CHECK(gl.GetError() == GL_NO_ERROR, "GL error");
    gl_context_destroy(&c);
}

// ---- The passes ----

enum { SIDE = 256, ROWS = 128, COLUMNS = 128, WIDTH = 96, HEIGHT = 64 };

static struct {
    gl_context context;
    mssm_light light;
    mssm_gl *map;
    gl_mesh solids;
    gl_surfaces seen;
    gl_target target, depth;
    scene hall;
    image positions;
} stage;

static bool begin_hall(void)
{
    const GLenum color[GL_TARGET_COLORS] = {GL_RGBA32F}, none[GL_TARGET_COLORS] = {0};
    const mssm_gl_desc desc = {
        .load = gl_context_function, .filtered = 1, .side = SIDE, .samples = 1, .radius = 1};
    message why;
    if (!gl_test_begin(&stage.context)) return false;
    stage.solids = (gl_mesh){0};
    const bool made = shafts_hall(&stage.hall) &&
                      gl_mesh_upload(&stage.solids, &stage.hall, &why) &&
                      !mssm_gl_create(&stage.map, &desc) &&
                      gl_surfaces_create(&stage.seen, WIDTH, HEIGHT, &why) &&
                      gl_target_create(&stage.target, WIDTH, HEIGHT, 1, color, &why) &&
                      gl_target_create(&stage.depth, SIDE, SIDE, 1, none, &why);
    const GLuint depth = gl_program_simple("depth", gl_depth_vertex, NULL, &why);
    CHECK(made && depth, "%s", why.text);
    if (!made || !depth) return false;
    stage.light = shafts_sun(&stage.hall, sun);
    gl.ProgramUniformMatrix4fv(depth, 0, 1, GL_FALSE, stage.light.world_to_shadow);
    mssm_gl_set_light(stage.map, 0, &stage.light);
    mssm_gl_begin_depth(stage.map, 0, 0);
    gl.UseProgram(depth);
    gl_mesh_draw(&stage.solids);
    mssm_gl_end_depth(stage.map);
    mssm_gl_build(stage.map);
    gl_target_begin(&stage.depth);
    gl.Enable(GL_DEPTH_TEST);
    gl_mesh_draw(&stage.solids);
    gl.Disable(GL_DEPTH_TEST);
    gl.DeleteProgram(depth);
    return true;
}

static void end_hall(void)
{
    mssm_gl_destroy(stage.map);
    gl_surfaces_free(&stage.seen);
    gl_target_free(&stage.target);
    gl_target_free(&stage.depth);
    gl_mesh_free(&stage.solids);
    scene_free(&stage.hall);
    CHECK(gl.GetError() == GL_NO_ERROR, "GL error");
    gl_context_destroy(&stage.context);
}

// The filtered map of the GPU in a map of the CPU: both take the same depths.
static mssm_filtered *same_map(void **memory)
{
    const size_t bytes = mssm_filtered_bytes(SIDE, 4);
    float *depth = malloc(sizeof(float) * SIDE * SIDE);
    mssm_filtered *map = NULL;
    *memory = malloc(bytes);
    if (!depth || !*memory) abort();
    gl.GetTextureImage(stage.depth.depth, 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                       sizeof(float) * SIDE * SIDE, depth);
    for (int i = 0; i < SIDE * SIDE; i++) depth[i] = 2 * depth[i] - 1;
    CHECK(!mssm_filtered_init(&map, *memory, bytes, SIDE, 4) &&
              !mssm_filtered_update(map, depth, 1, 1),
          "map");
    free(depth);
    return map;
}

// Root mean square. Single texels may differ more: where nearly one depth is split into two.
static double texel_error(const gl_shafts *s, const shafts *cpu)
{
    static float low[ROWS * COLUMNS * 4], high[ROWS * COLUMNS * 4];
    double sum = 0;
    gl.GetTextureImage(s->texture[0], 0, GL_RGBA, GL_FLOAT, sizeof low, low);
    gl.GetTextureImage(s->texture[1], 0, GL_RGBA, GL_FLOAT, sizeof high, high);
    for (int i = 0; i < ROWS * COLUMNS; i++) {
        for (int k = 0; k < 6; k++) {
            const float got = k < 4 ? low[4 * i + k] : high[4 * i + k - 4];
            sum += pow((double)(got - cpu->moments[6 * i + k]), 2);
        }
    }
    return sqrt(sum / (ROWS * COLUMNS * 6));
}

static void compare_camera(const char *name, vec3 from, vec3 to)
{
    const camera eye = camera_look(from, to, 0.9f, (float)WIDTH / HEIGHT);
    mssm_scattering from_eye;
    gl_shafts s = {0};
    shafts cpu;
    image got, want;
    message why = {"no memory"};
    void *memory;
    const GLuint program = gl_shafts_program("shafts", NULL, &why);
    const bool made = program && gl_shafts_create(&s, ROWS, COLUMNS, &why) &&
                      shafts_create(&cpu, ROWS, COLUMNS) && image_create(&want, WIDTH, HEIGHT) &&
                      shafts_look(&from_eye, &stage.light, &eye, extinction);
    CHECK(made, "%s", why.text);
    if (!made) return;
    shafts_update(&cpu, same_map(&memory), &from_eye);
    gl_surfaces_draw(&stage.seen, &stage.solids, &eye);
    gl_target_begin(&stage.target);
    gl_shafts_update(&s, &from_eye, mssm_gl_texture(stage.map, 0));
    gl_shafts_draw(program, stage.seen.target.color[0], &eye, extinction, 14, vec(1, 1, 1));
    CHECK(gl_target_read(&stage.target, &got, &why) &&
              gl_target_read(&stage.seen.target, &stage.positions, &why),
          "%s", why.text);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const int x = i % WIDTH, y = i / WIDTH;
        const vec3 d =
            vec_unit(camera_ray(&eye, ((float)x + 0.5f) / WIDTH, ((float)y + 0.5f) / HEIGHT));
        const float t = shafts_distance(&eye, &stage.positions, 14, x, y);
        const float v = (1 - expf(-extinction * t)) * shafts_visibility(&cpu, d, t);
        image_set(&want, x, y, vec(v, v, v));
    }
    double error, bands;
    shafts_errors(&got, &want, &error, &bands);
    const double texels = texel_error(&s, &cpu);
    test_note("%s: rms of texels %.5f, of the picture %.5f", name, texels, error);
    CHECK(texels < 4e-3, "%s: texels off by %g", name, texels);
    CHECK(error < 1e-3, "%s: picture off by %g", name, error);
    image_free(&got);
    image_free(&want);
    image_free(&stage.positions);
    gl_shafts_free(&s);
    shafts_free(&cpu);
    free(memory);
    gl.DeleteProgram(program);
}

static void passes_agree(void)
{
    if (!begin_hall()) return;
    compare_camera("windows ahead", vec(2.5f, 1.4f, 3.2f), vec(-0.5f, 1.2f, -2));
    compare_camera("the sun in the picture", vec(1.2f, 1, 2.2f), vec(0.8f, 1.9f, -1));
    compare_camera("the camera's own shadow", vec(-1, 1.4f, -1.5f), vec(-0.4f, 0.2f, 0));
    compare_camera("from outside", vec(7, 5, 9), vec(0, 1, 0));
    end_hall();
}

static void marching_agrees(void)
{
    if (!begin_hall()) return;
    const camera eye =
        camera_look(vec(2.5f, 1.4f, 3.2f), vec(-0.5f, 1.2f, -2), 0.9f, (float)WIDTH / HEIGHT);
    static float depth[SIDE * SIDE];
    image got, want;
    message why = {"no memory"};
    const GLuint program = gl_shafts_program("marching", gl_shafts_marched, &why);
    CHECK(program && image_create(&want, WIDTH, HEIGHT), "%s", why.text);
    gl_surfaces_draw(&stage.seen, &stage.solids, &eye);
    gl.ProgramUniformMatrix4fv(program, gl.GetUniformLocation(program, "world_to_shadow"), 1,
                               GL_FALSE, stage.light.world_to_shadow);
    gl.ProgramUniform1i(program, gl.GetUniformLocation(program, "steps"), 32);
    gl.BindTextureUnit(GL_SHAFTS_TEXTURE, stage.depth.depth);
    gl_target_begin(&stage.target);
    gl_shafts_draw(program, stage.seen.target.color[0], &eye, extinction, 14, vec(1, 1, 1));
    CHECK(gl_target_read(&stage.target, &got, &why) &&
              gl_target_read(&stage.seen.target, &stage.positions, &why),
          "%s", why.text);
    gl.GetTextureImage(stage.depth.depth, 0, GL_DEPTH_COMPONENT, GL_FLOAT, sizeof depth, depth);
    for (int i = 0; i < SIDE * SIDE; i++) depth[i] = 2 * depth[i] - 1;
    const shafts_march march = {&stage.light, depth, SIDE, 32, extinction};
    shafts_march_image(&march, &eye, &stage.positions, 14, &want);
    double error, bands;
    shafts_errors(&got, &want, &error, &bands);
    test_note("32 steps on the GPU and on the CPU differ by %.5f rms", error);
    CHECK(error < 2e-3, "%g", error);
    image_free(&got);
    image_free(&want);
    image_free(&stage.positions);
    gl.DeleteProgram(program);
    end_hall();
}

const test_case scattering_gl_tests[] = {
    {"GLSL gives C's numbers of single scattering", shared_math_agrees},
    {"light shafts in OpenGL are those of the CPU", passes_agree},
    {"marching in OpenGL is that of the CPU", marching_agrees},
    {0, 0}};
