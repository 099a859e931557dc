// A light probe rendered each frame: a room with a swinging lamp and a sliding door is drawn into a
// cube map with distances, the GPU finds its lights, and these light objects on a table: so the
// objects receive light from the walls, with shadows. OpenGL 4.5, no window:
//     cc -O2 -I. examples/gl_room.c examples/common/*.c -lm -lpthread -ldl && ./a.out --truth
#include "common/gl_example.h"
#include "common/gl_probe_lights.h"
#include "common/gl_room.h"
#include "common/report.h"

#include <stdio.h>

#define STILL 0.06f                   // the time of a single picture
#define EXPOSURE 2.7f                 // of all pictures
static const char things_fragment[] = // after the texts of both headers
    "layout(location = 1) uniform vec3 probe;\n"
    "layout(location = 2) uniform vec4 lamp;\n" // and its radius
    "layout(location = 3) uniform vec4 eye;\n"  // and alpha of a varnish, 0 without
    "in vec3 position, normal, albedo;\n"
    "out vec4 color;\n"
    "vec3 light_of(int i, vec3 n)\n"
    "{\n"
    "    lightprobe_light l = lightprobe_lights[i];\n"
    "    vec3 place = probe + l.distance * l.direction, offset = position - probe;\n"
    "    if (distance(place, lamp.xyz) > 2 * lamp.w) return lightprobe_irradiance(i, offset, n);\n"
    "    return lightprobe_sphere_irradiance(i, offset, n);\n" // the lamp has no shade
    "}\n"
    "void main()\n"
    "{\n"
    "    vec3 n = normalize(normal), sum = lightprobe_residual_irradiance(n) * albedo / 3.14159265;\n"
    "    lightprobe_lobe lobe =\n"
    "        lightprobe_specular_lobe(n, normalize(eye.xyz - position), eye.w, vec3(0.04));\n"
    "    for (int i = 0; i < lightprobe_count; i++) {\n"
    "        vec3 light = light_of(i, n) * albedo / 3.14159265;\n"
    "        if (eye.w > 0) light += lightprobe_specular(i, position - probe, lobe);\n"
    "        if (light != vec3(0)) sum += light * mssm_visibility(i, position, n);\n"
    "    }\n"
    "    color = vec4(sum, 1);\n"
    "}\n";

typedef struct renderer {
    gl_room walls;
    gl_probe_lights lights;
    gl_target picture;
    GLuint things;
    float shine;
} renderer;

static bool create(renderer *r, const options *o, int side, message *why)
{
    r->shine = o->shine;
    if (!gl_probe_lights_create(&r->lights, side, o->lights, true, why)) return false;
    const char *const vertex[] = {gl_scene_vertex, NULL};
    const char *const texts[] = {lightprobe_glsl_math(),
                                 lightprobe_glsl_lights(),
                                 lightprobe_glsl_specular(),
                                 mssm_gl_shader(r->lights.shadows),
                                 things_fragment,
                                 NULL};
    return gl_room_create(&r->walls, side, why) &&
           (r->things = gl_program("things", vertex, texts, why)) &&
           gl_target_create(&r->picture, o->width, o->height, 4, (GLenum[3]){GL_RGBA32F}, why);
}

static void destroy(renderer *r)
{
    gl_room_free(&r->walls);
    gl_probe_lights_free(&r->lights);
    gl_target_free(&r->picture);
    if (r->things) gl.DeleteProgram(r->things);
}

static void draw_picture(renderer *r, const room *world, const gl_mesh *things)
{
    const camera eye = room_camera((float)r->picture.width / (float)r->picture.height);
    const float lamp[4] = {world->lamp.x, world->lamp.y, world->lamp.z, ROOM_LAMP_RADIUS};
    const float viewer[4] = {eye.position.x, eye.position.y, eye.position.z, r->shine};
    gl_target_begin(&r->picture);
    gl.Enable(GL_DEPTH_TEST);
    gl_camera_use(&eye, 0.05f, 10, r->things);
    gl.ProgramUniform3fv(r->things, 1, 1, &room_centre.x);
    gl.ProgramUniform4fv(r->things, 2, 1, lamp);
    gl.ProgramUniform4fv(r->things, 3, 1, viewer);
    gl_probe_lights_bind(&r->lights);
    gl_mesh_draw(things);
    gl_room_draw_walls(&r->walls, &eye);
    gl.Disable(GL_DEPTH_TEST);
}

// By what a cube shows, in which the things themselves are not.
static bool draw_lit_by(renderer *r, const room *world, GLuint cube, message *why)
{
    const gl_mesh things = gl_room_things(&r->walls);
    const bool lit = gl_probe_lights_update(&r->lights, cube, room_centre, world->low, world->high,
                                            &things, why);
    if (lit) draw_picture(r, world, &things);
    return lit;
}

static bool draw_frame(renderer *r, const room *world, message *why)
{
    if (!gl_room_set(&r->walls, world, why)) return false;
    gl_room_draw_cube(&r->walls);
    return draw_lit_by(r, world, r->walls.cube, why);
}

static bool save_frame(renderer *r, const options *o, float time, const char *file, message *why)
{
    image picture = {0};
    room world;
    double error;
    bool done = room_create(&world, time) && draw_frame(r, &world, why) &&
                gl_target_read(&r->picture, &picture, why);
    if (done && o->truth != TRUTH_NONE) {
        done = room_truth_beside(&world, r->shine, &picture, &error, why);
        if (done) printf("rms error of the things %.3f of their mean\n", error);
    }
    done = done && image_save(&picture, EXPOSURE, file, why);
    image_free(&picture);
    room_free(&world);
    return done;
}

static bool run(int argc, char **argv, message *why)
{
    static renderer r;
    options o = {.out = "room.png", .lights = 16, .width = 640, .height = 360};
    bool done =
        options_parse_some(&o, "--out --truth --orbit --lights --size --shine", argc, argv, why) &&
        create(&r, &o, 128, why);
    if (done && !o.orbit) done = save_frame(&r, &o, STILL, o.out, why);
    for (int i = 0; i < o.orbit && done; i++) {
        char file[1024];
        report_frame_name(file, sizeof file, o.out, i);
        done = save_frame(&r, &o, (float)i / (float)o.orbit, file, why);
    }
    destroy(&r);
    return done;
}

int main(int argc, char **argv)
{
    return gl_example_main(
        argc, argv,
        "gl_room [--out PICTURE.png|pfm] [--truth] [--orbit FRAMES] [--lights 1..64] [--size WxH] "
        "[--shine ALPHA]\n"
        "--orbit writes up to 9999 numbered frames; --size 16 to 8192 (640x360); --shine .02 to 1",
        run);
}
