// Deferred shading with all area lights of a turning probe, OpenGL 4.5, no window. The lights stay
// on the GPU; the CPU reads them a frame late for the depth maps, and shading uses the same lights.
//     cc -O2 -I. examples/gl_deferred.c examples/common/*.c -lm -lpthread -ldl && ./a.out --orbit 8
#include "common/gl_example.h"
#include "common/probe.h"
#include "../lightprobe.h"
#include "../mssm.h"

#include <stdio.h>

enum { LIGHTS = 24, WIDTH = 960, HEIGHT = 540 };
static const char shading[] = // for a triangle over the picture, after the texts of both headers
    "layout(binding = 0) uniform sampler2D position_map;\n"
    "layout(binding = 1) uniform sampler2D normal_map;\n"
    "layout(binding = 2) uniform sampler2D albedo_map;\n"
    "layout(binding = 3) uniform samplerCube probe;\n"
    "in vec3 ray;\n"
    "out vec4 color;\n"
    "vec3 seen(vec3 p, vec3 normal, vec3 diffuse)\n" // of a varnished surface
    "{\n"
    "    lightprobe_lobe lobe = lightprobe_specular_lobe(normal, -normalize(ray), 0.1, vec3(0.04));\n"
    "    vec3 sum = diffuse * lightprobe_residual_irradiance(normal);\n"
    "    for (int i = 0; i < lightprobe_count; i++) {\n"
    "        vec3 lit = diffuse * lightprobe_irradiance(i, normal) + lightprobe_specular(i, lobe);\n"
    "        if (lit != vec3(0)) sum += lit * mssm_visibility(i, p, normal);\n"
    "    }\n"
    "    return sum;\n"
    "}\n"
    "void main()\n"
    "{\n"
    "    ivec2 pixel = ivec2(gl_FragCoord.xy);\n"
    "    vec4 at = texelFetch(position_map, pixel, 0);\n"
    "    vec3 normal = texelFetch(normal_map, pixel, 0).xyz, albedo = texelFetch(albedo_map, pixel, 0).rgb;\n"
    "    color = at.w == 0 ? texture(probe, ray) : vec4(seen(at.xyz, normal, albedo / 3.14159265), 1);\n"
    "}\n";

typedef struct renderer {
    lightprobe_gl *probe;
    mssm_gl *shadows;
    gl_mesh casters, triangle;
    gl_target view, picture;
    GLuint depth_program, view_program, shading_program, cube;
    lightprobe_light light[LIGHTS]; // whose depth maps are drawn
    int lights;
} renderer;

static bool create(renderer *r, message *why)
{
    const lightprobe_gl_desc from = {
        .load = gl_context_function, .side = 128, .max_lights = LIGHTS};
    const mssm_gl_desc desc = {.load = gl_context_function,
                               .lights = LIGHTS,
                               .first_texture_unit = 4,
                               .first_buffer_binding = 1,
                               .settings = {.estimator = MSSM_HORIZON}};
    const GLenum view_formats[] = {GL_RGBA32F, GL_RGBA16F, GL_RGBA8};
    if (lightprobe_gl_create(&r->probe, &from)) return fail(why, "no lights from probes");
    if (mssm_gl_create(&r->shadows, &desc)) return fail(why, "no shadow maps");
    const char *const vertices[] = {gl_triangle_vertex, NULL};
    const char *const fragments[] = {lightprobe_glsl_math(),
                                     lightprobe_glsl_lights(),
                                     lightprobe_glsl_specular(),
                                     mssm_gl_shader(r->shadows),
                                     shading,
                                     NULL};
    gl_mesh_triangle(&r->triangle);
    return (r->depth_program = gl_program_simple("depth", gl_depth_vertex, NULL, why)) &&
           (r->view_program = gl_program_simple("view", gl_scene_vertex, gl_scene_fragment, why)) &&
           (r->shading_program = gl_program("shading", vertices, fragments, why)) &&
           gl_target_create(&r->view, WIDTH, HEIGHT, 1, view_formats, why) &&
           gl_target_create(&r->picture, WIDTH, HEIGHT, 1, (GLenum[3]){GL_RGBA32F}, why);
}

static void draw_shadows(renderer *r, const scene *s)
{
    const float lo[3] = {s->low.x, s->low.y, s->low.z}, hi[3] = {s->high.x, s->high.y, s->high.z};
    for (int i = 0; i < r->lights; i++) {
        const lightprobe_light *l = &r->light[i];
        mssm_light f;
        mssm_light_directional(&f, l->direction, l->axis_u, l->tan_half_u, l->tan_half_v, lo, hi);
        gl_example_map(r->shadows, i, &f, r->depth_program, &r->casters);
    }
    mssm_gl_build(r->shadows);
}

static void draw_picture(renderer *r)
{
    const camera eye = camera_look(vec(0.3f, 2.25f, 7.7f), vec(-0.05f, 0.86f, 0), 0.57f, 16.0f / 9);
    gl_target_begin(&r->view);
    gl.Enable(GL_DEPTH_TEST);
    gl_camera_use(&eye, 0.1f, 30, r->view_program);
    gl_mesh_draw(&r->casters);
    gl.Disable(GL_DEPTH_TEST);
    gl_target_begin(&r->picture);
    gl.UseProgram(r->shading_program);
    gl_camera_uniforms(&eye, r->shading_program);
    for (GLuint i = 0; i < GL_TARGET_COLORS; i++) gl.BindTextureUnit(i, r->view.color[i]);
    gl.BindTextureUnit(3, r->cube);
    const lightprobe_gl_range lights = lightprobe_gl_lights(r->probe, 1); // as the maps have them
    gl.BindBufferRange(GL_SHADER_STORAGE_BUFFER, 0, lights.buffer, lights.offset, lights.bytes);
    mssm_gl_bind(r->shadows);
    gl_mesh_draw(&r->triangle);
}

static bool frame(renderer *r, const probe *p, const scene *s, const char *file, message *why)
{
    gl_probe_upload(&r->cube, p->face, p->side); // whatever animates it
    if (!gl_mesh_upload(&r->casters, s, why)) return false;
    if (lightprobe_gl_update(r->probe, r->cube)) return fail(why, "no lights in the probe");
    // Waits only for the first lights; later it takes those of the previous frame.
    lightprobe_gl_read(r->probe, r->lights == 0, r->light, &r->lights, NULL);
    draw_shadows(r, s);
    draw_picture(r);
    return gl_target_save(&r->picture, 0, file, why);
}

static bool run(int argc, char **argv, message *why)
{
    static renderer r;
    options o = {.out = "deferred", .orbit = 1};
    probe source = {0}, turned = {0};
    bool done = options_parse_some(&o, "--orbit --out", argc, argv, why) &&
                probe_default(&source, 128) && probe_create(&turned, 128) && create(&r, why);
    for (int i = 0; i < o.orbit && done; i++) {
        const float turn = (float)i / (float)o.orbit;
        scene s = {0};
        char file[1024];
        snprintf(file, sizeof file, "%s-%04d.png", o.out, i);
        done = probe_rotate(&turned, &source, 2 * VEC_PI * turn) &&
               scene_create(&s, 8 * turn, NULL) && frame(&r, &turned, &s, file, why);
        scene_free(&s);
    }
    probe_free(&source);
    probe_free(&turned);
    mssm_gl_destroy(r.shadows); // the rest goes with the context
    lightprobe_gl_destroy(r.probe);
    return done;
}

int main(int argc, char **argv)
{
    return gl_example_main(argc, argv,
                           "gl_deferred [--orbit FRAMES] [--out STEM]: all lights of a turning "
                           "probe; writes STEM-0000.png and on",
                           run);
}
