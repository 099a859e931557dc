// Antialiased hard shadows of a sun from a moment map of 64 bits a texel, compared with PCF by the
// same kernel and with rays: errors and costs. OpenGL 4.5, no window:
//     cc -O2 -I. examples/gl_hard.c examples/common/*.c -lm -lpthread -ldl && ./a.out hard 2
#include "common/gl_example.h"
#include "common/raytrace.h"
#include "common/threads.h"

#include <stdio.h>

enum { WIDTH = 640, HEIGHT = 360, SIDE = 512, FRAMES = 5 };
static const float to_sun[3] = {-0.6f, 1, 0.5f}, axis[3] = {1, 0, 0};
static scene s;
static camera eye;
static mssm_light light;
static gl_mesh solids;
static gl_target target, plain; // multisampled; a depth map for the rival
static image truth;

static const char shading[] = // after a text that declares visibility()
    "layout(location = 1) uniform vec3 to_sun;\n"
    "in vec3 position, normal, albedo;\n"
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec3 n = normalize(normal);\n"
    "    float seen = visibility(position, dFdx(position), dFdy(position));\n"
    "    color = vec4(albedo * (max(dot(n, to_sun), 0) * seen + 0.2 + 0.1 * n.y), 1);\n"
    "}\n";
static const char moments_text[] =
    "float visibility(vec3 p, vec3 x, vec3 y) { return mssm_filtered_visibility(0, p, x, y); }\n";
static const char pcf_text[] = // every texel of the same Gaussian
    "layout(location = 2) uniform mat4 world_to_shadow;\n"
    "layout(location = 3) uniform int radius;\n"
    "layout(binding = 2) uniform sampler2D depth_map;\n"
    "float visibility(vec3 p, vec3 x, vec3 y)\n"
    "{\n"
    "    vec3 at = 0.5 + 0.5 * (world_to_shadow * vec4(p, 1)).xyz;\n"
    "    ivec2 size = textureSize(depth_map, 0);\n"
    "    vec2 sum = vec2(0);\n"
    "    for (int j = -radius; j <= radius; j++) for (int i = -radius; i <= radius; i++) {\n"
    "        ivec2 t = ivec2(floor(at.xy * size)) + ivec2(i, j);\n"
    "        float w = exp(-2.0 * (i * i + j * j) / (radius * radius));\n"
    "        bool outside = any(lessThan(t, ivec2(0))) || any(greaterThanEqual(t, size));\n"
    "        sum += w * vec2(outside || texelFetch(depth_map, t, 0).x > at.z - 0.006, 1);\n"
    "    }\n"
    "    return sum.x / sum.y;\n"
    "}\n";

static const char usage[] =
    "gl_hard [STEM [RADIUS [MOMENTS]]]: compares filtered hard shadows with PCF and rays; writes\n"
    "STEM.png, STEM-pcf.png, STEM-truth.png. RADIUS of the Gaussian in texels (2), MOMENTS 4 or 6";

static float sunlight(vec3 n, bool seen) // as the shader has it
{
    const float facing = fmaxf(vec_dot(n, vec_unit(vec_of(to_sun))), 0);
    return facing * (seen ? 1.0f : 0.0f) + 0.2f + 0.1f * n.y;
}

// Draws the picture a few times, saves it, prints its error and the seconds of the fastest.
static bool draw(GLuint program, const char *file, const char *end, message *why)
{
    double least = 1e9;
    char name[300];
    image result;
    const vec3 sun = vec_unit(vec_of(to_sun));
    gl_camera_use(&eye, 0.1f, 30, program);
    gl.ProgramUniform3fv(program, 1, 1, &sun.x);
    for (int i = 0; i < FRAMES; i++) {
        gl_target_begin(&target);
        gl.Finish();
        const double start = seconds_now();
        gl_mesh_draw(&solids);
        gl.Finish();
        least = fmin(least, seconds_now() - start);
    }
    if (!gl_target_read(&target, &result, why)) return false;
    snprintf(name, sizeof name, "%s%s.png", file, end);
    printf("%s: rms error %.4f, %.1f ms\n", name, image_rms(&result, &truth), 1e3 * least);
    const bool saved = image_save_png(&result, 1.3f, name, why);
    image_free(&result);
    return saved;
}

// The moment map, and the depth map of the rival.
static void draw_maps(mssm_gl *shadow, GLuint depth)
{
    gl_example_map(shadow, 0, &light, depth, &solids);
    mssm_gl_build(shadow);
    gl_target_begin(&plain);
    gl.Enable(GL_DEPTH_TEST);
    gl.UseProgram(depth);
    gl_mesh_draw(&solids);
}

static bool compare(mssm_gl *shadow, const char *file, int radius, message *why)
{
    const char *const vertices[] = {gl_scene_vertex, NULL};
    const char *const rival[] = {pcf_text, shading, NULL};
    const char *const texts[] = {mssm_gl_shader(shadow), moments_text, shading, NULL};
    const GLuint depth = gl_program_simple("depth", gl_depth_vertex, NULL, why);
    const GLuint pcf = gl_program("percentage-closer filtering", vertices, rival, why);
    const GLuint program = gl_program("moments", vertices, texts, why);
    if (!depth || !pcf || !program) return false;
    draw_maps(shadow, depth);
    gl.ProgramUniformMatrix4fv(pcf, 2, 1, GL_FALSE, light.world_to_shadow);
    gl.ProgramUniform1i(pcf, 3, radius);
    mssm_gl_bind(shadow);
    gl.BindTextureUnit(2, plain.depth);
    return draw(pcf, file, "-pcf", why) && draw(program, file, "", why);
}

static bool create(message *why)
{
    eye = camera_look(vec(0.3f, 2.25f, 7.7f), vec(-0.05f, 0.86f, 0), 0.57f, 16.0f / 9);
    if (!scene_create(&s, 0, NULL) ||
        !trace_picture(&s, &eye, vec_unit(vec_of(to_sun)), sunlight, WIDTH, HEIGHT, &truth)) {
        return fail(why, "no memory");
    }
    const float low[3] = {s.low.x, s.low.y, s.low.z}, high[3] = {s.high.x, s.high.y, s.high.z};
    mssm_light_directional(&light, to_sun, axis, 0, 0, low, high);
    return gl_mesh_upload(&solids, &s, why) &&
           gl_target_create(&target, WIDTH, HEIGHT, 4, (GLenum[3]){GL_RGBA32F}, why) &&
           gl_target_create(&plain, SIDE, SIDE, 1, (GLenum[3]){0}, why);
}

static bool run(int argc, char **argv, message *why)
{
    const char *const file = argc > 1 ? argv[1] : "hard";
    int radius = 2, moments = 4;
    const bool good = (argc <= 2 || options_int(argv[2], 1, 32, &radius)) &&
                      (argc <= 3 || options_int(argv[3], 4, 6, &moments)) && moments != 5;
    const mssm_gl_desc desc = {.load = gl_context_function,
                               .filtered = 1,
                               .side = SIDE,
                               .radius = radius,
                               .moments = moments};
    mssm_gl *shadow;
    char name[300];
    if (!good) return fail(why, "RADIUS is 1 to 32, MOMENTS 4 or 6");
    snprintf(name, sizeof name, "%s-truth.png", file);
    if (mssm_gl_create(&shadow, &desc)) return fail(why, "no filtered maps");
    const bool done = create(why) && image_save_png(&truth, 1.3f, name, why) &&
                      compare(shadow, file, desc.radius, why);
    scene_free(&s);
    image_free(&truth);
    mssm_gl_destroy(shadow); // the rest goes with the context
    return done;
}

int main(int argc, char **argv)
{
    return gl_example_main(argc, argv, usage, run);
}
