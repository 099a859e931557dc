// Shadowed image-based lighting with your irradiance map, OpenGL 4.5, no window: objects in a
// photograph, on a ground that shows only the shadows it catches.
//     cc -O2 -I. examples/gl_catcher.c examples/common/*.c -lm -lpthread -ldl && ./a.out --truth
// The extracted lights do not shade: shadow_ratio() computes from them which part of the light is
// left.
#include "common/gl_example.h"
#include "common/gl_probe_lights.h"
#include "common/photograph.h"
#include "common/report.h"

#include <stdio.h>

enum { LIGHTS = 24, WIDTH = 960, HEIGHT = 540, RAYS = 128 };
static const char ratio[] = // after the texts of both headers
    "vec3 shadow_ratio(vec3 position, vec3 normal)\n"
    "{\n"
    "    vec3 all = lightprobe_residual_irradiance(normal), seen = all;\n"
    "    for (int i = 0; i < lightprobe_count; i++) {\n"
    "        vec3 light = lightprobe_irradiance(i, normal);\n"
    "        all += light;\n"
    "        if (light != vec3(0)) seen += light * mssm_visibility(i, position, normal);\n"
    "    }\n"
    "    return mix(vec3(1), seen / all, lessThan(seen, all));\n" // 1 where there is nothing to shadow
    "}\n";
static const char shading[] =
    "layout(binding = 0) uniform samplerCube irradiance_map;\n"
    "layout(location = 1) uniform bool catches;\n"
    "in vec3 position, normal, albedo;\n"
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec3 n = normalize(normal), own = albedo * texture(irradiance_map, n).rgb / 3.14159265;\n"
    "    color = vec4((catches ? vec3(1) : own) * shadow_ratio(position, n), 1);\n"
    "}\n";

static gl_probe_lights lights;
static scene objects;
static gl_mesh casters, ground;
static gl_target target;
static GLuint program, cube, irradiance;

static GLuint program_with(const char *ratio_text, message *why)
{
    const char *const vertices[] = {gl_scene_vertex, NULL};
    const char *const fragments[] = {lightprobe_glsl_math(),
                                     lightprobe_glsl_lights(),
                                     mssm_gl_shader(lights.shadows),
                                     ratio_text,
                                     shading,
                                     NULL};
    return gl_program("catcher", vertices, fragments, why);
}

static bool create(const probe *p, int width, int height, message *why)
{
    probe map;
    scene s;
    if (!gl_probe_lights_create(&lights, p->side, LIGHTS, false, why) ||
        !probe_irradiance_map(p, 16, &map) || !photograph_scene(&objects, true, false) ||
        !photograph_scene(&s, false, true)) {
        return false;
    }
    gl_probe_upload(&cube, p->face, p->side);
    gl_probe_upload(&irradiance, map.face, map.side);
    const bool uploaded =
        gl_mesh_upload(&ground, &s, why) && gl_mesh_upload(&casters, &objects, why);
    probe_free(&map);
    scene_free(&s);
    return uploaded && gl_target_create(&target, width, height, 4, (GLenum[3]){GL_RGBA32F}, why) &&
           (program = program_with(ratio, why));
}

static void destroy(void)
{
    gl_probe_lights_free(&lights);
    scene_free(&objects);
    gl_mesh_free(&casters);
    gl_mesh_free(&ground);
    gl_target_free(&target);
    if (program) gl.DeleteProgram(program);
    gl.DeleteTextures(2, (GLuint[2]){cube, irradiance});
}

// The ground casts no shadows: its light is in the probe.
static bool draw_shadows(message *why)
{
    return gl_probe_lights_update(&lights, cube, vec(0, 0, 0), objects.low, objects.high, &casters,
                                  why);
}

static bool draw(const camera *eye, const image *photo, image *out, message *why)
{
    gl_target_begin(&target);
    if (!gl_image_draw(photo, why)) return false;
    gl_probe_lights_bind(&lights);
    gl.BindTextureUnit(0, irradiance);
    gl_camera_use(eye, 0.1f, 100, program);
    gl.Enable(GL_DEPTH_TEST);
    gl.Enable(GL_BLEND);
    gl.BlendFunc(GL_ZERO, GL_SRC_COLOR);
    gl.ProgramUniform1i(program, 1, 1);
    gl_mesh_draw(&ground);
    gl.Disable(GL_BLEND);
    gl.ProgramUniform1i(program, 1, 0);
    gl_mesh_draw(&casters);
    gl.Disable(GL_DEPTH_TEST);
    return gl_target_read(&target, out, why);
}

static bool run(int argc, char **argv, message *why)
{
    const camera eye = photograph_camera((float)WIDTH / HEIGHT);
    options o = {.out = "catcher.png"};
    probe p;
    image photo = {0}, picture = {0}, rays = {0};
    char name[1024];
    if (!options_parse_some(&o, "--probe --out --truth", argc, argv, why)) return false;
    if (o.probe ? !probe_load(&p, o.probe, 0, why) : !probe_default(&p, 128)) return false;
    if (!photograph_take(&p, &eye, WIDTH, HEIGHT, &photo)) return false; // yours, from a camera
    const float exposure = 1.5f * image_exposure(&photo);
    report_name(name, sizeof name, o.out, "-truth");
    const bool done = create(&p, WIDTH, HEIGHT, why) && draw_shadows(why) &&
                      draw(&eye, &photo, &picture, why) &&
                      image_save(&picture, exposure, o.out, why) &&
                      (o.truth == TRUTH_NONE || (photograph_truth(&p, &eye, &photo, RAYS, &rays) &&
                                                 image_save(&rays, exposure, name, why)));
    destroy();
    image_free(&photo);
    image_free(&picture);
    image_free(&rays);
    probe_free(&p);
    return done;
}

int main(int argc, char **argv)
{
    return gl_example_main(
        argc, argv,
        "gl_catcher [--probe FILE] [--out PICTURE.png|pfm] [--truth]: objects and their shadows\n"
        "in a photograph, catcher.png; FILE .hdr or .pfm: lat-long, cross or strip of six faces;\n"
        "--truth writes the same by rays too, catcher-truth.png",
        run);
}
