// A sun with filtered hard shadows and 16 lamps with soft ones in one forward shader, OpenGL 4.5,
// no window:
//     cc -O2 -I. examples/gl_forward.c examples/common/*.c -lm -lpthread -ldl && ./a.out forward.png
// Two mssm_gl objects with different map sides and different names for their GLSL functions.
#include "common/gl_example.h"

enum { LAMPS = 16, WIDTH = 960, HEIGHT = 540 };
static const float to_sun[3] = {-0.7f, 1, 0.5f}, up[3] = {0, 1, 0}, axis[3] = {1, 0, 0};

static const char fragment[] = // after both texts
    "in vec3 position, normal, albedo;\n"
    "layout(location = 1) uniform vec3 to_sun;\n"
    "layout(location = 2) uniform vec3 lamp[16];\n"
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec3 n = normalize(normal), sum = vec3(0.04);\n"
    "    float facing = max(dot(n, normalize(to_sun)), 0.0);\n"
    "    float seen = sun_shadow(0, position, dFdx(position), dFdy(position));\n"
    "    sum += vec3(0.5, 0.45, 0.4) * (facing * seen);\n"
    "    for (int i = 0; i < 16; i++) {\n"
    "        vec3 to = lamp[i] - position;\n"
    "        float distance = length(to), down = to.y / distance;\n" // the cone: a tangent of 1.2
    "        float light = max(dot(n, to), 0.0) * smoothstep(0.65, 0.8, down) / (distance * distance);\n"
    "        if (light > 0.0) light *= lamp_shadow(i, position, n);\n"
    "        sum += mix(vec3(0.8, 0.3, 0.1), vec3(0.1, 0.3, 0.8), float(i % 4) / 3.0) * light;\n"
    "    }\n"
    "    color = vec4(albedo * sum, 1.0);\n"
    "}\n";

static mssm_gl *sun_maps, *lamp_maps;
static mssm_light sun, lamp[LAMPS];
static float places[LAMPS][3];
static gl_mesh casters;
static GLuint depth, program;

static bool create(message *why)
{
    const mssm_gl_desc sun_desc = {
        .load = gl_context_function, .filtered = 1, .side = 1024, .name = "sun_shadow"};
    const mssm_gl_desc lamp_desc = {
        .load = gl_context_function, .lights = LAMPS, .name = "lamp_shadow"};
    const float low[3] = {-4.4f, -0.2f, -4.4f}, high[3] = {4.4f, 2.2f, 4.4f};
    bool good = !mssm_light_directional(&sun, to_sun, axis, 0, 0, low, high) &&
                !mssm_gl_create(&sun_maps, &sun_desc) && !mssm_gl_create(&lamp_maps, &lamp_desc) &&
                !mssm_gl_set_light(sun_maps, 0, &sun);
    for (int i = 0; i < LAMPS && good; i++) {
        places[i][0] = (float)(i % 4) * 1.4f - 2.1f;
        places[i][1] = 2.6f;
        places[i][2] = (float)(i / 4) * 1.4f - 2.1f;
        good = !mssm_light_spot(&lamp[i], places[i], up, axis, 1.2f, 0.3f, 4, 0.1f, 0.1f) &&
               !mssm_gl_set_light(lamp_maps, i, &lamp[i]);
    }
    if (!good) return fail(why, "no shadow maps");
    const char *const vertex[] = {gl_scene_vertex, NULL};
    const char *const texts[] = {mssm_gl_shader(sun_maps), mssm_gl_shader(lamp_maps), fragment,
                                 NULL};
    return (depth = gl_program_simple("depth", gl_depth_vertex, NULL, why)) &&
           (program = gl_program("forward", vertex, texts, why));
}

static void draw_maps(mssm_gl *maps, const mssm_light *light, int count)
{
    mssm_gl_begin_frame(maps);
    for (int i = 0; i < count; i++) gl_example_map(maps, i, &light[i], depth, &casters);
    mssm_gl_build(maps);
    mssm_gl_end_frame(maps);
}

static bool draw(const char *file, message *why)
{
    const camera eye =
        camera_look(vec(0.3f, 3.4f, 5.6f), vec(-0.05f, 0.6f, 0), 0.66f, (float)WIDTH / HEIGHT);
    gl_target target;
    if (!gl_target_create(&target, WIDTH, HEIGHT, 4, (GLenum[3]){GL_RGBA32F}, why)) return false;
    draw_maps(sun_maps, &sun, 1);
    draw_maps(lamp_maps, lamp, LAMPS);
    gl_target_begin(&target);
    gl.Enable(GL_DEPTH_TEST);
    gl_camera_use(&eye, 0.1f, 100, program);
    gl.ProgramUniform3fv(program, 1, 1, to_sun);
    gl.ProgramUniform3fv(program, 2, LAMPS, places[0]);
    mssm_gl_bind(sun_maps);
    mssm_gl_bind(lamp_maps);
    gl_mesh_draw(&casters);
    return gl_target_save(&target, 1.4f, file, why);
}

static bool run(int argc, char **argv, message *why)
{
    scene s = {0};
    const bool done = scene_create(&s, 0, NULL) && gl_mesh_upload(&casters, &s, why) &&
                      create(why) && draw(argc > 1 ? argv[1] : "forward.png", why);
    scene_free(&s);
    mssm_gl_destroy(sun_maps);
    mssm_gl_destroy(lamp_maps); // the rest goes with the context
    return done;
}

int main(int argc, char **argv)
{
    return gl_example_main(
        argc, argv,
        "gl_forward [PICTURE.png]: a filtered sun and 16 soft lamps in one forward shader", run);
}
