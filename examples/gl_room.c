// A light probe that is rendered each frame: a room with a swinging lamp and a sliding door is
// drawn into a cube map with distances, its lights are found on the GPU, and things on a table lit
// by them, so that they get the light that the walls reflect, with its shadows. OpenGL 4.5, no
// window:
//     cc -O2 -I. examples/gl_room.c examples/common/*.c -lm -lpthread -ldl && ./a.out --truth
#include "common/gl_context.h"
#include "common/gl_room.h"
#include "common/gl_timer.h"
#include "common/options.h"
#include "common/report.h"
#include "../lightprobe.h"
#include "../mssm.h"

#include <stdio.h>
#include <string.h>

enum { MOST_LIGHTS = 64 };
#define STILL 0.06f
static const char things_fragment[] = // behind the texts of both headers
    "layout(location = 1) uniform vec3 probe;\n"
    "layout(location = 2) uniform vec4 lamp;\n" // and its radius
    "layout(location = 3) uniform int at_infinity;\n"
    "layout(location = 4) uniform vec4 eye;\n" // and alpha of a varnish, 0 without
    "in vec3 position, normal, albedo;\n"
    "out vec4 color;\n"
    "vec3 light_of(int i, vec3 n)\n"
    "{\n"
    "    lightprobe_light l = lightprobe_lights[i];\n"
    "    vec3 place = probe + l.distance * l.direction, offset = position - probe;\n"
    "    if (at_infinity != 0) return lightprobe_irradiance(i, n);\n"
    "    if (distance(place, lamp.xyz) > 2 * lamp.w) return lightprobe_irradiance(i, offset, n);\n"
    "    return lightprobe_sphere_irradiance(i, offset, n);\n" // the lamp has no shade
    "}\n"
    "void main()\n"
    "{\n"
    "    vec3 n = normalize(normal), sum = lightprobe_residual_irradiance(n) * albedo / 3.14159265;\n"
    "    vec3 offset = at_infinity != 0 ? vec3(0) : position - probe;\n"
    "    lightprobe_lobe lobe =\n"
    "        lightprobe_specular_lobe(n, normalize(eye.xyz - position), eye.w, vec3(0.04));\n"
    "    for (int i = 0; i < lightprobe_count; i++) {\n"
    "        vec3 light = light_of(i, n) * albedo / 3.14159265;\n"
    "        if (eye.w > 0) light += lightprobe_specular(i, offset, lobe);\n"
    "        if (light != vec3(0)) sum += light * mssm_visibility(i, position, n);\n"
    "    }\n"
    "    color = vec4(sum, 1);\n"
    "}\n";

typedef struct renderer {
    gl_room walls;
    lightprobe_gl *probe;
    mssm_gl *shadows;
    gl_target picture;
    gl_timer timer;
    GLuint depth, things;
    float shine;
    lightprobe_light light[MOST_LIGHTS];
    int lights;
} renderer;

static bool create(renderer *r, const options *o, int side, message *why)
{
    const lightprobe_gl_desc from = {
        .load = gl_context_function, .side = side, .max_lights = o->lights, .distances = 1};
    const mssm_gl_desc maps = {.load = gl_context_function,
                               .lights = o->lights,
                               .side = 512,
                               .first_buffer_binding = 1,
                               .settings = {.estimator = MSSM_HORIZON}};
    memset(r, 0, sizeof *r);
    r->shine = o->shine;
    if (lightprobe_gl_create(&r->probe, &from)) return fail(why, "no lights from probes");
    if (mssm_gl_create(&r->shadows, &maps)) return fail(why, "no shadow maps");
    const char *const vertex[] = {gl_scene_vertex, NULL};
    const char *const texts[] = {
        lightprobe_glsl_math(),     lightprobe_glsl_lights(), lightprobe_glsl_specular(),
        mssm_gl_shader(r->shadows), things_fragment,          NULL};
    return gl_room_create(&r->walls, side, why) &&
           (r->depth = gl_program_simple("depth", gl_depth_vertex, NULL, why)) &&
           (r->things = gl_program("things", vertex, texts, why)) &&
           gl_target_create(&r->picture, o->width, o->height, 4, (GLenum[3]){GL_RGBA32F}, why);
}

static void destroy(renderer *r)
{
    gl_room_free(&r->walls);
    lightprobe_gl_destroy(r->probe);
    mssm_gl_destroy(r->shadows);
    gl_target_free(&r->picture);
    gl_timer_free(&r->timer);
    if (r->depth) gl.DeleteProgram(r->depth);
    if (r->things) gl.DeleteProgram(r->things);
}

// Maps of the things, one a light; at infinity as a probe without distances would have them.
static void draw_shadows(renderer *r, const room *world, bool at_infinity)
{
    const float low[3] = {world->low.x, world->low.y, world->low.z};
    const float high[3] = {world->high.x, world->high.y, world->high.z};
    const float centre[3] = {room_centre.x, room_centre.y, room_centre.z};
    for (int i = 0; i < r->lights; i++) {
        const lightprobe_light *l = &r->light[i];
        mssm_light f;
        mssm_light_area(&f, centre, l->direction, l->axis_u, l->tan_half_u, l->tan_half_v,
                        at_infinity ? 0 : l->distance, low, high);
        mssm_gl_set_light(r->shadows, i, &f);
        mssm_gl_begin_depth(r->shadows, i, 0);
        gl.UseProgram(r->depth);
        gl.ProgramUniformMatrix4fv(r->depth, 0, 1, GL_FALSE, f.world_to_shadow);
        gl_room_draw_things(&r->walls);
        mssm_gl_end_depth(r->shadows);
    }
    mssm_gl_build(r->shadows);
}

static void draw_picture(renderer *r, const room *world, bool at_infinity)
{
    const camera eye = room_camera((float)r->picture.width / (float)r->picture.height);
    const lightprobe_gl_range lights = lightprobe_gl_lights(r->probe, 1); // those the maps are of
    const float lamp[4] = {world->lamp.x, world->lamp.y, world->lamp.z, ROOM_LAMP_RADIUS};
    const float viewer[4] = {eye.position.x, eye.position.y, eye.position.z, r->shine};
    float world_to_clip[16];
    gl_camera_matrix(&eye, 0.05f, 10, world_to_clip);
    gl_target_begin(&r->picture);
    gl.Enable(GL_DEPTH_TEST);
    gl.UseProgram(r->things);
    gl.ProgramUniformMatrix4fv(r->things, 0, 1, GL_FALSE, world_to_clip);
    gl.ProgramUniform3fv(r->things, 1, 1, &room_centre.x);
    gl.ProgramUniform4fv(r->things, 2, 1, lamp);
    gl.ProgramUniform1i(r->things, 3, at_infinity);
    gl.ProgramUniform4fv(r->things, 4, 1, viewer);
    gl.BindBufferRange(GL_SHADER_STORAGE_BUFFER, 0, lights.buffer, lights.offset, lights.bytes);
    mssm_gl_bind(r->shadows);
    gl_room_draw_things(&r->walls);
    gl_room_draw_walls(&r->walls, world_to_clip);
    gl.Disable(GL_DEPTH_TEST);
}

static bool frame(renderer *r, const room *world, bool at_infinity, message *why)
{
    gl_timer_start(&r->timer);
    if (!gl_room_set(&r->walls, world, why)) return false;
    gl_timer_mark(&r->timer);
    gl_room_draw_cube(&r->walls);
    gl_timer_mark(&r->timer);
    if (lightprobe_gl_update(r->probe, r->walls.cube)) return fail(why, "no lights in the probe");
    gl_timer_mark(&r->timer);
    // Waits, so that the picture is of this room; a game takes what is there, a frame late.
    if (lightprobe_gl_read(r->probe, 1, r->light, &r->lights, NULL)) return fail(why, "no lights");
    draw_shadows(r, world, at_infinity);
    gl_timer_mark(&r->timer);
    draw_picture(r, world, at_infinity);
    gl_timer_mark(&r->timer);
    return true;
}

// The truth on the right of it, and how far off it is; the same lights at infinity for comparison.
static bool add_truth(renderer *r, const room *world, image *picture, message *why)
{
    image endless = {0};
    double error[2];
    const bool done = frame(r, world, true, why) && gl_target_read(&r->picture, &endless, why) &&
                      room_truth_beside(world, r->shine, picture, &endless, error, why);
    if (done)
        printf("rms error of the things %.3f of their mean, at infinity %.3f\n", error[0],
               error[1]);
    image_free(&endless);
    return done;
}

static void print_times(const renderer *r)
{
    static const char *const stage[] = {"walls' shadows", "cube", "lights", "maps", "picture"};
    printf("%d lights, ms:", r->lights);
    for (int k = 0; k < 5; k++)
        printf(" %s %.1f", stage[k], 1e3 * gl_timer_seconds(&r->timer, k + 1));
    printf("\n");
}

static bool run(renderer *r, const options *o, message *why)
{
    const float exposure = 2.7f; // of all frames
    bool done = o->lights <= MOST_LIGHTS || fail(why, "at most %d lights", MOST_LIGHTS);
    done = done && create(r, o, 128, why);
    for (int i = 0; i < (o->orbit ? o->orbit : 1) && done; i++) {
        const float time = o->orbit ? (float)i / (float)o->orbit : STILL;
        char file[1024], number[16] = "";
        image picture = {0};
        room world;
        if (o->orbit) snprintf(number, sizeof number, "-%04d", i);
        report_name(file, sizeof file, o->out, number);
        done = room_create(&world, time) && frame(r, &world, false, why) &&
               gl_target_read(&r->picture, &picture, why);
        print_times(r);
        done = done && (!o->truth || add_truth(r, &world, &picture, why)) &&
               image_save(&picture, exposure, file, why);
        image_free(&picture);
        room_free(&world);
    }
    destroy(r);
    return done;
}

int main(int argc, char **argv)
{
    static renderer r;
    static const char usage[] =
        "gl_room [--out PICTURE.png|pfm] [--truth] [--orbit FRAMES] [--lights 1..64] [--size WxH] "
        "[--shine ALPHA]\n"
        "--orbit writes up to 9999 numbered frames; --size 16 to 8192 (640x360); --shine .02 to 1";
    options o = {.out = "room.png", .lights = 16, .width = 640, .height = 360};
    gl_context context = {0};
    const char *missing;
    message why = {"no memory"};
    if (options_help_asked(argc, argv, usage)) return 0;
    const bool done =
        options_parse_some(&o, "--out --truth --orbit --lights --size --shine", argc, argv, &why) &&
        (gl_context_create(&context, &missing) || fail(&why, "%s", missing)) && run(&r, &o, &why);
    if (!done) fprintf(stderr, "gl_room: %s\n", why.text);
    gl_context_destroy(&context);
    return done ? 0 : 1;
}
