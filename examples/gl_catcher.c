// Shadowed image-based lighting with an irradiance map of one's own, OpenGL 4.5, no window: objects
// stand in a photograph, whose ground is invisible but for the shadows that it catches.
//     cc -O2 -I. examples/gl_catcher.c examples/common/*.c -lm -lpthread -ldl && ./a.out --truth
// The extracted lights shade nothing: they only say, in shadow_ratio(), which part of the light is
// left.
#include "common/gl_context.h"
#include "common/gl_draw.h"
#include "common/options.h"
#include "common/photograph.h"
#include "common/report.h"
#include "../lightprobe.h"
#include "../mssm.h"

#include <stdio.h>

enum { LIGHTS = 24, WIDTH = 960, HEIGHT = 540, RAYS = 128 };
static const char ratio[] = // behind the texts of both headers
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

static const char help[] = "Objects and their shadows in a photograph.\n"
                           "\n"
                           "  --probe FILE  the light, .hdr or .pfm: lat-long, cross or strip of "
                           "six cube faces (built in)\n"
                           "  --out FILE    the picture, .png or .pfm (catcher.png)\n"
                           "  --truth       also the same by rays, to catcher-truth.png\n"
                           "  --help        this text\n";

static lightprobe_gl *finder;
static mssm_gl *shadows;
static scene objects;
static gl_mesh casters, ground;
static gl_target target;
static GLuint depth, program, cube, irradiance;

static GLuint program_with(const char *ratio_text, message *why)
{
    const char *const vertices[] = {gl_scene_vertex, NULL};
    const char *const fragments[] = {lightprobe_glsl_math(),
                                     lightprobe_glsl_lights(),
                                     mssm_gl_shader(shadows),
                                     ratio_text,
                                     shading,
                                     NULL};
    return gl_program("catcher", vertices, fragments, why);
}

static bool create(const probe *p, int width, int height, message *why)
{
    const lightprobe_gl_desc from = {
        .load = gl_context_function, .side = p->side, .max_lights = LIGHTS};
    const mssm_gl_desc desc = {.load = gl_context_function,
                               .lights = LIGHTS,
                               .side = 512,
                               .settings = {.estimator = MSSM_HORIZON}};
    probe map;
    scene s;
    if (lightprobe_gl_create(&finder, &from)) return fail(why, "no lights from probes");
    if (mssm_gl_create(&shadows, &desc)) return fail(why, "no shadow maps");
    if (!probe_irradiance_map(p, 16, &map) || !photograph_scene(&objects, true, false) ||
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
           (depth = gl_program_simple("depth", gl_depth_vertex, NULL, why)) &&
           (program = program_with(ratio, why));
}

static bool draw_shadows(message *why)
{
    const float low[3] = {objects.low.x, objects.low.y, objects.low.z};
    const float high[3] = {objects.high.x, objects.high.y, objects.high.z};
    lightprobe_light light[LIGHTS];
    int lights;
    if (lightprobe_gl_update(finder, cube) || lightprobe_gl_read(finder, 1, light, &lights, NULL))
        return fail(why, "no lights in the probe");
    for (int i = 0; i < lights; i++) {
        const lightprobe_light *l = &light[i];
        mssm_light f;
        mssm_light_directional(&f, l->direction, l->axis_u, l->tan_half_u, l->tan_half_v, low,
                               high);
        mssm_gl_set_light(shadows, i, &f);
        mssm_gl_begin_depth(shadows, i, 0);
        gl.UseProgram(depth);
        gl.ProgramUniformMatrix4fv(depth, 0, 1, GL_FALSE, f.world_to_shadow);
        gl_mesh_draw(&casters); // the ground casts none: its light is in the probe
        mssm_gl_end_depth(shadows);
    }
    return mssm_gl_build(shadows) == MSSM_OK || fail(why, "no tables");
}

static bool draw(const camera *eye, const image *photo, image *out, message *why)
{
    float world_to_clip[16];
    gl_camera_matrix(eye, 0.1f, 100, world_to_clip);
    gl_target_begin(&target);
    if (!gl_image_draw(photo, why)) return false;
    const lightprobe_gl_range lights = lightprobe_gl_lights(finder, 1); // as the maps have them
    gl.BindBufferRange(GL_SHADER_STORAGE_BUFFER, 0, lights.buffer, lights.offset, lights.bytes);
    gl.BindTextureUnit(0, irradiance);
    mssm_gl_bind(shadows);
    gl.UseProgram(program);
    gl.ProgramUniformMatrix4fv(program, 0, 1, GL_FALSE, world_to_clip);
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

static bool run(const options *o, message *why)
{
    const camera eye = photograph_camera((float)WIDTH / HEIGHT);
    probe p;
    image photo = {0}, picture = {0}, rays = {0};
    char name[1024];
    if (o->probe ? !probe_load(&p, o->probe, 0, why) : !probe_default(&p, 128)) return false;
    if (!photograph_take(&p, &eye, WIDTH, HEIGHT, &photo)) return false; // yours, from a camera
    const float exposure = 1.5f * image_exposure(&photo);
    report_name(name, sizeof name, o->out, "-truth");
    const bool done = create(&p, WIDTH, HEIGHT, why) && draw_shadows(why) &&
                      draw(&eye, &photo, &picture, why) &&
                      image_save(&picture, exposure, o->out, why) &&
                      (o->truth == TRUTH_NONE || (photograph_truth(&p, &eye, &photo, RAYS, &rays) &&
                                                  image_save(&rays, exposure, name, why)));
    image_free(&photo);
    image_free(&picture);
    image_free(&rays);
    probe_free(&p);
    return done;
}

int main(int argc, char **argv)
{
    options o = {.out = "catcher.png"};
    gl_context context = {0};
    const char *missing;
    message why = {"no memory"};
    bool done = options_parse_some(&o, "--probe --out --truth --help", argc, argv, &why);
    if (o.help) return fputs(help, stdout) < 0;
    done = done && (gl_context_create(&context, &missing) || fail(&why, "%s", missing)) &&
           run(&o, &why);
    if (!done) fprintf(stderr, "gl_catcher: %s\n", why.text);
    mssm_gl_destroy(shadows);
    lightprobe_gl_destroy(finder);
    gl_context_destroy(&context);
    return done ? 0 : 1;
}
