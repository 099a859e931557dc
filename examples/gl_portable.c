// gl_hello for OpenGL 3.3 (or macOS's 4.1) and OpenGL ES 3.0: the CPU makes the tables and uploads
// them; the shading is the same. Uses only calls that both versions have. No window:
//     cc -O2 -I. examples/gl_portable.c examples/common/*.c -lm -lpthread -ldl && ./a.out --es portable.png
// All that mssm.h needs is in common/gl33_shadows.c, shadow_draw() and the fragment shader.
#include "mssm.h"

#include "common/gl33_shadows.h"
#include "common/gl_context.h"
#include "common/options.h"
#include "common/raster.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 256, SAMPLES = 4, WIDTH = 1024, HEIGHT = 768 };
static const float to_light[3] = {-1, 1.1f, 0.15f}, axis[3] = {1, 0, 0};
static const float box_min[3] = {-0.15f, 0, -0.5f}, box_max[3] = {0.15f, 1.5f, 0.5f};

// Goes after the text of mssm.h.
static const char fragment[] =
    "uniform vec3 to_light;\n"
    "in vec3 position, normal, albedo;\n"
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec3 n = normalize(normal);\n"
    "    float light = max(dot(n, normalize(to_light)), 0.0) * mssm_visibility(0, position);\n"
    "    float sky = 0.2 + 0.1 * n.y;\n"
    "    color = vec4(albedo * (light + sky), 1.0);\n"
    "}\n";

// Draws the depth map with OpenGL, reads it back and makes its tables.
static bool shadow_draw(mssm_map **map, mssm_light *light, const char *version,
                        const gl33_mesh *casters, message *why)
{
    static float depth[SIDE * SIDE * SAMPLES];
    static unsigned char memory[4 << 20];
    if (mssm_light_directional(light, to_light, axis, 0.12f, 0.12f, box_min, box_max) ||
        mssm_map_init(map, memory, sizeof memory, SIDE, 6)) {
        return fail(why, "no light");
    }
    return gl33_depth(version, casters, light->world_to_shadow, SIDE, SAMPLES, depth, why) &&
           mssm_map_update(*map, depth, NULL, SAMPLES) == MSSM_OK;
}

static bool run(const char *version, const char *file, message *why)
{
    const camera eye = camera_look(vec(2.5f, 3.3f, 3.8f), vec(0.42f, 0.58f, 0), 0.52f, 4.0f / 3);
    const scene_frame ground = scene_frame_at(vec(0, -0.1f, 0), 0, 0),
                      wall = scene_frame_at(vec(0, 0.75f, 0), 0, 0);
    scene s = {0};
    gl33_mesh boxes = {0};
    gl33_shadows shadows = {.lights = 1};
    mssm_map *map;
    mssm_light light;
    image picture;
    float world_to_clip[16];
    scene_begin_object(&s, 0.7f, 0.7f, 0.68f);
    scene_put_box(&s, &ground, vec(15, 0.1f, 15));
    scene_begin_object(&s, 0.8f, 0.3f, 0.15f);
    scene_put_box(&s, &wall, vec(0.1f, 0.75f, 0.45f));
    const bool ready = scene_end(&s) && gl33_mesh_upload(&boxes, &s, why) &&
                       shadow_draw(&map, &light, version, &boxes, why) &&
                       gl33_shadows_upload(&shadows, 0, map, &light, why);
    const GLuint program = ready ? gl33_shadows_program(version, 1, NULL, fragment, why) : 0;
    if (!program || !gl33_target_begin(WIDTH, HEIGHT, 4, why)) return false;
    gl_camera_matrix(&eye, 0.1f, 30, world_to_clip);
    gl33.UseProgram(program);
    gl33_shadows_bind(&shadows);
    gl33.UniformMatrix4fv(gl33.GetUniformLocation(program, "world_to_clip"), 1, GL_FALSE,
                          world_to_clip);
    gl33.Uniform3fv(gl33.GetUniformLocation(program, "to_light"), 1, to_light);
    gl33_mesh_draw(&boxes);
    const bool done =
        gl33_target_read(WIDTH, HEIGHT, &picture, why) && image_save(&picture, 1.3f, file, why);
    image_free(&picture);
    gl33_shadows_free(&shadows);
    scene_free(&s);
    return done;
}

int main(int argc, char **argv)
{
    static const char usage[] =
        "gl_portable [--es|--gl33] [PICTURE.png]: gl_hello in OpenGL ES 3.0, or 3.3 (default)";
    gl_context context = {0};
    const char *missing;
    message why = {"OpenGL has refused a call"};
    if (options_help_asked(argc, argv, usage)) return 0;
    const bool es = argc > 1 && !strcmp(argv[1], "--es"),
               named = es || (argc > 1 && !strcmp(argv[1], "--gl33"));
    const char *file = argc > 1 + named ? argv[1 + named] : "portable.png";
    if (!gl_context_create_portable(&context, es, &missing) ||
        !gl33_load(gl_context_function, &missing))
        return fprintf(stderr, "gl_portable: %s\n", missing), 1;
    const bool done =
        run(es ? "#version 300 es\nprecision highp float;\n" : "#version 330 core\n", file, &why);
    if (!done) fprintf(stderr, "gl_portable: %s\n", why.text);
    gl_context_destroy(&context);
    return done ? 0 : 1;
}
