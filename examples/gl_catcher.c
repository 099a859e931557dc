// Shadowed image-based lighting with an irradiance map of one's own, OpenGL 4.5, no window: objects stand in a
// photograph, whose ground is invisible but for the shadows that it catches.
//     cc -O2 -I. examples/gl_catcher.c examples/common/*.c -lm -lpthread -ldl && ./a.out catcher.png
// The extracted lights shade nothing: they only say, in shadow_ratio(), which part of the light is left.
#include "common/gl_context.h"
#include "common/gl_draw.h"
#include "common/options.h"
#include "common/photograph.h"
#include "../lightprobe.h"
#include "../mssm.h"

#include <stdio.h>
#include <string.h>

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
static const char backdrop[] =
    "layout(binding = 0) uniform sampler2D photograph;\n"
    "in vec2 place;\n"
    "out vec4 color;\n"
    "void main() { color = texture(photograph, vec2(place.x, 1 - place.y)); }\n";

typedef struct renderer {
    lightprobe_gl *probe;
    mssm_gl *shadows;
    scene objects;
    gl_mesh casters, ground, triangle;
    gl_target target;
    GLuint depth, program, backdrop, cube, irradiance, photograph;
} renderer;

static camera where_from(void)
{
    return camera_look(vec(0.6f, 2.2f, 4.3f), vec(0.25f, 0.32f, 0.1f), 0.48f, (float)WIDTH / HEIGHT);
}

static GLuint program_with(const renderer *r, const char *ratio_text, message *why)
{
    const char *const vertices[] = {gl_scene_vertex, NULL};
    const char *const fragments[] = {lightprobe_glsl_math(), lightprobe_glsl_lights(), mssm_gl_shader(r->shadows),
                                     ratio_text, shading, NULL};
    return gl_program("catcher", vertices, fragments, why);
}

static bool create(renderer *r, const probe *p, const char *ratio_text, int width, int height, message *why)
{
    const lightprobe_gl_desc from = {.load = gl_context_function, .side = p->side, .max_lights = LIGHTS};
    const mssm_gl_desc desc = {.load = gl_context_function, .lights = LIGHTS, .side = 512};
    const GLenum formats[GL_TARGET_COLORS] = {GL_RGBA32F};
    probe map;
    scene s;
    if (lightprobe_gl_create(&r->probe, &from)) return fail(why, "no lights from probes");
    if (mssm_gl_create(&r->shadows, &desc)) return fail(why, "no shadow maps");
    if (!probe_irradiance_map(p, 16, &map) || !photograph_scene(&r->objects, true, false) ||
        !photograph_scene(&s, false, true)) {
        return false;
    }
    gl_probe_upload(&r->cube, p->face, p->side);
    gl_probe_upload(&r->irradiance, map.face, map.side);
    gl_mesh_triangle(&r->triangle);
    const bool uploaded = gl_mesh_upload(&r->ground, &s, why) && gl_mesh_upload(&r->casters, &r->objects, why);
    probe_free(&map);
    scene_free(&s);
    return uploaded && gl_target_create(&r->target, width, height, 4, formats, why) &&
           (r->depth = gl_program_simple("depth", gl_depth_vertex, NULL, why)) &&
           (r->backdrop = gl_program_simple("backdrop", gl_triangle_vertex, backdrop, why)) &&
           (r->program = program_with(r, ratio_text, why));
}

static void destroy(renderer *r)
{
    mssm_gl_destroy(r->shadows);
    lightprobe_gl_destroy(r->probe);
    scene_free(&r->objects);
}

static bool draw_shadows(renderer *r, message *why)
{
    const vec3 a = r->objects.low, b = r->objects.high;
    const float low[3] = {a.x, a.y, a.z}, high[3] = {b.x, b.y, b.z};
    lightprobe_light light[LIGHTS];
    int lights;
    if (lightprobe_gl_update(r->probe, r->cube) || lightprobe_gl_read(r->probe, 1, light, &lights, NULL))
        return fail(why, "no lights in the probe");
    for (int i = 0; i < lights; i++) {
        const lightprobe_light *l = &light[i];
        mssm_light f;
        mssm_light_directional(&f, l->direction, l->axis_u, l->tan_half_u, l->tan_half_v, low, high);
        mssm_gl_set_light(r->shadows, i, &f);
        mssm_gl_begin_depth(r->shadows, i, 0);
        gl.UseProgram(r->depth);
        gl.ProgramUniformMatrix4fv(r->depth, 0, 1, GL_FALSE, f.world_to_shadow);
        gl_mesh_draw(&r->casters); // the ground casts none: its light is in the probe
        mssm_gl_end_depth(r->shadows);
    }
    return mssm_gl_build(r->shadows) == MSSM_OK || fail(why, "no tables");
}

static bool draw(renderer *r, const camera *eye, const image *photo, image *out, message *why)
{
    float world_to_clip[16];
    if (!draw_shadows(r, why)) return false;
    gl.CreateTextures(GL_TEXTURE_2D, 1, &r->photograph);
    gl.TextureStorage2D(r->photograph, 1, GL_RGBA32F, photo->width, photo->height);
    gl.TextureParameteri(r->photograph, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl.TextureSubImage2D(r->photograph, 0, 0, 0, photo->width, photo->height, GL_RGB, GL_FLOAT, photo->rgb);
    gl_camera_matrix(eye, 0.1f, 100, world_to_clip);
    gl_target_begin(&r->target);
    gl.BindTextureUnit(0, r->photograph);
    gl.UseProgram(r->backdrop);
    gl_mesh_draw(&r->triangle);
    const lightprobe_gl_range lights = lightprobe_gl_lights(r->probe, 1); // as the maps have them
    gl.BindBufferRange(GL_SHADER_STORAGE_BUFFER, 0, lights.buffer, lights.offset, lights.bytes);
    gl.BindTextureUnit(0, r->irradiance);
    mssm_gl_bind(r->shadows);
    gl.UseProgram(r->program);
    gl.ProgramUniformMatrix4fv(r->program, 0, 1, GL_FALSE, world_to_clip);
    gl.Enable(GL_DEPTH_TEST);
    gl.Enable(GL_BLEND);
    gl.BlendFunc(GL_ZERO, GL_SRC_COLOR);
    gl.ProgramUniform1i(r->program, 1, 1);
    gl_mesh_draw(&r->ground);
    gl.Disable(GL_BLEND);
    gl.ProgramUniform1i(r->program, 1, 0);
    gl_mesh_draw(&r->casters);
    return gl_target_read(&r->target, out, why);
}

static bool run(const char *probe_file, const char *photo_file, const char *file, bool truth, message *why)
{
    const camera eye = where_from();
    renderer r = {0};
    probe p;
    image photo, picture, rays;
    if (probe_file ? !probe_load(&p, probe_file, 0, why) : !probe_default(&p, PROBE_DEFAULT_SIDE)) return false;
    if (photo_file ? !image_load(&photo, photo_file, why) : !photograph_take(&p, &eye, WIDTH, HEIGHT, &photo)) return false;
    const float exposure = 1.5f * image_exposure(&photo);
    bool done = create(&r, &p, ratio, WIDTH, HEIGHT, why) && draw(&r, &eye, &photo, &picture, why) &&
                image_save(&picture, exposure, file, why);
    if (done && truth) {
        char name[1024];
        const char *dot = strrchr(file, '.');
        snprintf(name, sizeof name, "%.*s-truth%s", (int)(dot ? dot - file : (long)strlen(file)), file, dot ? dot : "");
        done = photograph_truth(&p, &eye, &photo, RAYS, &rays) && image_save(&rays, exposure, name, why);
    }
    destroy(&r);
    return done;
}

int main(int argc, char **argv)
{
    static const char usage[] =
        "gl_catcher [--probe FILE] [--photo FILE] [--truth] [PICTURE.png]: objects and their shadows in a photograph;\n"
        "--probe its light, a .hdr or .pfm (built in); --photo the photograph (an empty square in that light, paved);\n"
        "--truth also writes PICTURE-truth.png, by rays";
    const char *probe_file = NULL, *photo = NULL, *file = "catcher.png", *missing;
    gl_context context = {0};
    message why = {"no memory"};
    bool truth = false;
    if (options_help_asked(argc, argv, usage)) return 0;
    for (int i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--truth")) truth = true;
        else if (!strcmp(argv[i], "--probe") && i + 1 < argc) probe_file = argv[++i];
        else if (!strcmp(argv[i], "--photo") && i + 1 < argc) photo = argv[++i];
        else if (argv[i][0] != '-') file = argv[i];
        else return fprintf(stderr, "gl_catcher: usage: %s\n", usage), 1;
    }
    const bool done = (gl_context_create(&context, &missing) || fail(&why, "%s", missing)) &&
                      run(probe_file, photo, file, truth, &why);
    if (!done) fprintf(stderr, "gl_catcher: %s\n", why.text);
    gl_context_destroy(&context);
    return done ? 0 : 1;
}
