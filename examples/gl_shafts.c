// Light shafts in a hazy hall from a filtered moment map, one lookup a pixel, compared with ray
// marching on the GPU and, as the truth, with 1024 steps on the CPU. OpenGL 4.5, no window:
//     cc -O2 -I. examples/gl_shafts.c examples/common/*.c -lm -lpthread -ldl && ./a.out shafts.png
// writes shafts.png, shafts.png-marched.png (in equal time) and shafts.png-truth.png.
#include "common/gl_example.h"
#include "common/gl_shafts.h"
#include "common/shafts.h"

#include <stdio.h>
#include <time.h>

enum { WIDTH = 640, HEIGHT = 360, SIDE = 1024, FINE = 4096, FRAMES = 15 };
static const float to_sun[3] = {-0.4f, 0.8f, -1}, extinction = 0.2f, far_end = 14;

static const char shade_text[] =
    "uniform vec3 to_sun;\n"
    "in vec3 position, normal, albedo;\n"
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    float seen = mssm_filtered_visibility(0, position, dFdx(position), dFdy(position));\n"
    "    float facing = max(dot(normalize(normal), normalize(to_sun)), 0);\n"
    "    color = vec4(albedo * (vec3(1.6, 1.4, 1.1) * seen * facing + 0.14), 1);\n"
    "}\n";

static camera eye;
static scene hall;
static mssm_light light;
static mssm_scattering from;
static mssm_gl *map;
static gl_mesh solids;
static gl_surfaces seen;
static gl_target target, depth_map;
static image shaded, positions, truth;
static GLuint depth, shade, moments, march;

static bool create(message *why)
{
    const mssm_gl_desc desc = {
        .load = gl_context_function, .filtered = 1, .side = SIDE, .radius = 1};
    eye = camera_look(vec(2.5f, 1.4f, 3.2f), vec(-0.5f, 1.2f, -2), 0.9f, (float)WIDTH / HEIGHT);
    if (!shafts_hall(&hall) || !image_create(&truth, WIDTH, HEIGHT)) return fail(why, "no memory");
    light = shafts_sun(&hall, to_sun);
    shafts_look(&from, &light, &eye, extinction);
    if (mssm_gl_create(&map, &desc)) return fail(why, "no filtered map");
    const char *const vertices[] = {gl_scene_vertex, NULL};
    const char *const shading[] = {mssm_gl_shader(map), shade_text, NULL};
    return (depth = gl_program_simple("depth", gl_depth_vertex, NULL, why)) &&
           (shade = gl_program("shading", vertices, shading, why)) &&
           (moments = gl_shafts_program("shafts", NULL, why)) &&
           (march = gl_shafts_program("marching", gl_shafts_marched, why)) &&
           gl_mesh_upload(&solids, &hall, why) && gl_surfaces_create(&seen, WIDTH, HEIGHT, why) &&
           gl_target_create(&target, WIDTH, HEIGHT, 1, (GLenum[3]){GL_RGBA32F}, why) &&
           gl_target_create(&depth_map, SIDE, SIDE, 1, (GLenum[3]){0}, why);
}

static bool prepare(message *why)
{
    gl.ProgramUniformMatrix4fv(march, gl.GetUniformLocation(march, "world_to_shadow"), 1, GL_FALSE,
                               light.world_to_shadow);
    gl.ProgramUniform3fv(shade, gl.GetUniformLocation(shade, "to_sun"), 1, to_sun);
    gl_example_map(map, 0, &light, depth, &solids);
    mssm_gl_build(map);
    mssm_gl_bind(map);
    gl.Enable(GL_DEPTH_TEST);
    gl_target_begin(&depth_map);
    gl.UseProgram(depth);
    gl_mesh_draw(&solids);
    gl_target_begin(&target);
    gl_camera_use(&eye, 0.1f, 30, shade);
    gl_mesh_draw(&solids);
    gl_surfaces_draw(&seen, &solids, &eye);
    return gl_target_read(&target, &shaded, why) && gl_target_read(&seen.target, &positions, why);
}

// Draws the shafts alone, with moments of rows x columns, or by marching if rows is 0. Returns the
// least process time of a frame.
static double draw(const char *name, int rows, int columns, image *out)
{
    gl_shafts s = {0};
    message why;
    double error, of_steps, least = 1e9;
    if (rows && !gl_shafts_create(&s, rows, columns, &why)) return 0;
    gl.ProgramUniform1i(march, gl.GetUniformLocation(march, "steps"), columns);
    gl.BindTextureUnit(GL_SHAFTS_TEXTURE, depth_map.depth);
    for (int i = 0; i < FRAMES; i++) {
        gl_target_begin(&target);
        gl.Finish();
        const clock_t start = clock();
        if (rows) gl_shafts_update(&s, &from, mssm_gl_texture(map, 0));
        gl_shafts_draw(rows ? moments : march, seen.target.color[0], &eye, extinction, far_end,
                       vec(1, 1, 1));
        gl.Finish();
        least = fmin(least, (double)(clock() - start) / CLOCKS_PER_SEC);
    }
    gl_shafts_free(&s);
    image_free(out);
    if (!gl_target_read(&target, out, &why)) return 0;
    shafts_errors(out, &truth, &error, &of_steps);
    printf("%-10s %4d x %-4d rms error %.4f, of steps between pixels %.4f %9.1f ms\n", name, rows,
           columns, error, of_steps, 1e3 * least);
    return least;
}

static bool save(image *picture, const char *file, const char *end, message *why)
{
    char name[300];
    shafts_over(picture, vec(1.3f, 1.1f, 0.8f), &shaded, extinction, &eye, &positions, far_end);
    snprintf(name, sizeof name, "%s%s", file, end);
    return image_save_png(picture, 1.5f, name, why);
}

static bool compare(const char *file, message *why)
{
    static const int sweep[][2] = {{64, 64}, {128, 128}, {512, 256}, {1024, 512}, {256, 128}};
    image got = {0}, marched = {0};
    double seconds = 0;
    for (int steps = 4; steps < 128; steps *= 4) draw("marching", 0, steps, &marched);
    const double eight = draw("marching", 0, 8, &marched);
    const double by_step = (draw("marching", 0, 128, &marched) - eight) / 120;
    for (int i = 0; i < 5; i++) seconds = draw("moments", sweep[i][0], sweep[i][1], &got);
    draw("equal time", 0, (int)fmax(8.5 + (seconds - eight) / by_step, 1), &marched);
    const bool saved = save(&got, file, "", why) && save(&marched, file, "-marched.png", why) &&
                       save(&truth, file, "-truth.png", why);
    image_free(&got);
    image_free(&marched);
    return saved;
}

static bool run(int argc, char **argv, message *why)
{
    const bool done =
        create(why) && prepare(why) &&
        shafts_truth(&hall, &light, FINE, 1024, extinction, &eye, &positions, far_end, &truth) &&
        compare(argc > 1 ? argv[1] : "shafts.png", why);
    scene_free(&hall);
    image_free(&truth);
    image_free(&shaded);
    image_free(&positions);
    mssm_gl_destroy(map); // the rest goes with the context
    return done;
}

int main(int argc, char **argv)
{
    return gl_example_main(argc, argv,
                           "gl_shafts [PICTURE.png]: light shafts; writes also "
                           "PICTURE.png-marched.png and -truth.png",
                           run);
}
