// The demo's scene in a window (GLFW): turn it, change settings, compare methods.
//     cc -O2 -I. examples/viewer.c examples/common/*.c -lglfw -lm -lpthread -ldl && ./a.out
// For tests: --screenshot FILE after --frames N; --keys "S]E" presses these keys before the first
// frame, where a . draws a frame.
#include "common/gl_lighting.h"
#include "common/gl_reference.h"
#include "common/gl_text.h"
#include "common/governor.h"
#include "common/options.h"
#include "common/png.h"
#include "common/threads.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_LIGHTS = 64, MAP_SIDE = 256, METHODS = 7 };
enum { METHOD_NONE = -1, METHOD_HARD = 3 }; // the first three are mssm_estimator

static const char *const method_name[METHODS] = {
    "layered", "lower blocker", "upper blocker", "hard", "pcss 27x27", "sampled truth", "none"};
static const char help[] =
    "[ ] lights   - = size   E method   M moments   F faces   S other method\n"
    "A animate   H frame-time target   T text   P picture\n"
    "drag: turn   right drag: split\n";
static const float budgets[] = {0, 1000.0f / 60, 1000.0f / 30, 100}; // milliseconds, 0: hold none

typedef struct viewer {
    GLFWwindow *window;
    lighting lights;
    gl_lighting left;
    gl_reference reference;
    gl_target right;
    gl_text text;
    gl_mesh triangle;
    GLuint program, display; // moments with settings that may change at any time; the two halves
    governor governor;       // of governor_ladder; without a budget it is not asked
    int budget, drawn_at;    // of budgets[]; level of the last frame
    probe source, turned;
    scene s;
    quality own;          // what the keys say
    const quality *now;   // own, or what the governor took of its ladder
    int compare, samples; // samples of the truth so far
    float turn, tilt, distance, split, time, exposure;
    bool animate, show_text, stale, save;
    double mouse_x, mouse_y;
    int width, height;
} viewer;

// mssm_visibility() with the compiled-in choice of method and moments replaced by uniforms.
static const char changeable[] =
    "uniform int estimator, moments;\n"
    "float changeable_visibility(int light, vec3 p)\n"
    "{\n"
    "    mssm_view v = mssm_view_of(light);\n"
    "    mssm_options o = mssm_chosen;\n"
    "    o.estimator = estimator;\n"
    "    o.moments = moments;\n"
    "    return mssm_estimate(mssm_map(light), v, o, mssm_receive(v, o, p.x, p.y, p.z));\n"
    "}\n"
    "#define mssm_visibility changeable_visibility\n";

static const char display_text[] =
    "layout(binding = 0) uniform sampler2D left;\n"
    "layout(binding = 1) uniform sampler2D right;\n"
    "uniform vec2 exposure;\n"
    "uniform float split;\n"
    "in vec2 place;\n"
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    ivec2 pixel = ivec2(gl_FragCoord.xy);\n"
    "    vec3 light = gl_FragCoord.x < split ? exposure.x * texelFetch(left, pixel, 0).rgb\n"
    "                                        : exposure.y * texelFetch(right, pixel, 0).rgb;\n"
    "    vec3 film = 1 - 1 / ((1 + 0.5 * light) * (1 + 0.5 * light));\n" // as image_tonemap()
    "    vec3 srgb = mix(12.92 * film, 1.055 * pow(film, vec3(1 / 2.4)) - 0.055,\n"
    "                    greaterThan(film, vec3(0.0031308)));\n"
    "    color = vec4(abs(gl_FragCoord.x - split) < 1 ? vec3(1) : srgb, 1);\n"
    "}\n";

static bool create_window(viewer *v, message *why)
{
    const char *missing;
    if (!glfwInit()) return fail(why, "GLFW finds no display");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    v->window = glfwCreateWindow(v->width, v->height, "mssm", NULL, NULL);
    if (!v->window) return fail(why, "no window with OpenGL 4.5");
    glfwMakeContextCurrent(v->window);
    glfwSwapInterval(0);
    return gl_load(glfwGetProcAddress, &missing) || fail(why, "the driver lacks %s", missing);
}

static bool open_viewer(viewer *v, message *why)
{
    const lighting_settings settings = {
        .probe = {.max_lights = MOST_LIGHTS}, .map_side = MAP_SIDE, .map_samples = 4};
    if (!probe_default(&v->source, 128) || !probe_create(&v->turned, 128)) {
        return fail(why, "no memory for the probe");
    }
    if (!lighting_create(&v->lights, &settings, v->source.side, why) || !create_window(v, why) ||
        !gl_lighting_create(&v->left, &v->lights, glfwGetProcAddress, v->width, v->height, why) ||
        !gl_reference_create(&v->reference, 2 * MAP_SIDE, MOST_LIGHTS, why) ||
        !gl_text_create(&v->text, why)) {
        return false;
    }
    const char *text = mssm_gl_shader(v->left.set[0].maps);
    char *joined = malloc(strlen(text) + sizeof changeable);
    if (!joined) return fail(why, "no memory for a shader");
    strcpy(joined, text);
    strcat(joined, changeable);
    v->program = gl_lighting_program("viewer", joined, false, why);
    free(joined);
    v->display = gl_program_simple("display", gl_triangle_vertex, display_text, why);
    gl_mesh_triangle(&v->triangle);
    return v->program && v->display;
}

static void close_viewer(viewer *v)
{
    if (v->program) gl.DeleteProgram(v->program);
    if (v->display) gl.DeleteProgram(v->display);
    gl_mesh_free(&v->triangle);
    gl_target_free(&v->right);
    gl_text_free(&v->text);
    gl_reference_free(&v->reference);
    gl_lighting_free(&v->left);
    v->lights.settings.probe.max_lights = MOST_LIGHTS; // what it was made with
    lighting_free(&v->lights);
    probe_free(&v->source);
    probe_free(&v->turned);
    scene_free(&v->s);
    glfwTerminate();
}

// ---- Input

// From the middle of the ladder.
static void hold(viewer *v)
{
    v->budget = (v->budget + 1) % (int)(sizeof budgets / sizeof *budgets);
    v->drawn_at = -1; // the last frame was not drawn at a level
    governor_start(&v->governor, governor_ladder, governor_ladder_levels,
                   governor_ladder_levels / 2, budgets[v->budget]);
}

static void press(viewer *v, int key)
{
    quality *q = &v->own;
    v->stale = true;
    if (key == '[' && q->lights > 1) q->lights /= 2;
    if (key == ']' && q->lights < MOST_LIGHTS) q->lights *= 2;
    if (key == '-') v->left.size *= 0.8f;
    if (key == '=') v->left.size *= 1.25f;
    if (key == 'E') q->estimator = (mssm_estimator)((q->estimator + 1) % 3);
    if (key == 'M') q->moments = q->moments == 0 ? 4 : q->moments == 4 ? 6 : 0;
    if (key == 'S') v->compare = (v->compare + 1) % METHODS;
    if (key == 'F') v->lights.settings.back_faces = !v->lights.settings.back_faces;
    if (key == 'H') hold(v);
    if (key == 'A') v->animate = !v->animate;
    if (key == 'T') v->show_text = !v->show_text;
    if (key == 'P') v->save = true;
    if (key == GLFW_KEY_ESCAPE) glfwSetWindowShouldClose(v->window, 1);
}

static void on_key(GLFWwindow *window, int key, int code, int action, int mods)
{
    (void)code, (void)mods;
    if (action != GLFW_RELEASE) press(glfwGetWindowUserPointer(window), key);
}

static void on_scroll(GLFWwindow *window, double x, double y)
{
    viewer *v = glfwGetWindowUserPointer(window);
    (void)x;
    v->distance = fminf(fmaxf(v->distance * expf(-0.1f * (float)y), 2), 20);
    v->stale = true;
}

static void on_mouse(GLFWwindow *window, double x, double y)
{
    viewer *v = glfwGetWindowUserPointer(window);
    if (glfwGetMouseButton(window, GLFW_MOUSE_BUTTON_LEFT)) {
        v->turn -= 0.006f * (float)(x - v->mouse_x);
        v->tilt = fminf(fmaxf(v->tilt + 0.006f * (float)(y - v->mouse_y), 0.02f), 1.5f);
        v->stale = true;
    }
    if (glfwGetMouseButton(window, GLFW_MOUSE_BUTTON_RIGHT)) v->split = (float)x / (float)v->width;
    v->mouse_x = x;
    v->mouse_y = y;
}

static bool resized(viewer *v, message *why)
{
    const GLenum formats[GL_TARGET_COLORS] = {GL_RGBA32F};
    int width, height;
    glfwGetFramebufferSize(v->window, &width, &height);
    if (width < 16 || height < 16 || (width == v->right.width && height == v->right.height))
        return true;
    v->width = width, v->height = height;
    v->stale = true;
    gl_target_free(&v->right);
    return gl_target_create(&v->right, width, height, 1, formats, why) &&
           gl_lighting_resize(&v->left, width, height, why);
}

// ---- A frame

static void shade_half(viewer *v, const camera *eye, const gl_target *to, int method, bool add)
{
    const int split = (int)(v->split * (float)v->width);
    const bool left = to == &v->left.picture;
    gl.Enable(GL_SCISSOR_TEST);
    if (v->compare == METHODS - 1)
        gl.Scissor(0, 0, v->width, v->height);
    else
        gl.Scissor(left ? 0 : split, 0, left ? split : v->width - split, v->height);
    if (add) {
        gl.BindFramebuffer(GL_FRAMEBUFFER, to->framebuffer);
        gl.Viewport(0, 0, to->width, to->height);
    } else {
        gl_target_begin(to);
    }
    if (method < METHOD_HARD) {
        gl.ProgramUniform1i(v->program, gl.GetUniformLocation(v->program, "estimator"), method);
        gl.ProgramUniform1i(v->program, gl.GetUniformLocation(v->program, "moments"),
                            v->now->moments);
        gl_lighting_shade(&v->left, v->program, &v->lights, eye);
    } else {
        gl_reference_shade(&v->reference, &v->left, &v->lights, eye,
                           (gl_reference_kind)(method - METHOD_HARD), add);
    }
    gl.Disable(GL_SCISSOR_TEST);
}

// Maps of another side, for as many lights as there is room for.
static bool set_side(viewer *v, int side, message *why)
{
    for (int i = 0; i < GL_LIGHTING_SETS && side != v->lights.settings.map_side; i++) {
        gl_shadow_set *set = &v->left.set[i];
        const mssm_result result = mssm_gl_resize(set->maps, set->room, side << i);
        if (result != MSSM_OK) return fail(why, "shadow maps: %s", mssm_result_string(result));
        set->side = side << i;
    }
    v->lights.settings.map_side = side;
    return true;
}

// Before a frame is drawn: what the last one took, and how this one is to be drawn.
static bool govern(viewer *v, message *why)
{
    double seconds = 0;
    v->now = &v->own;
    if (v->budget) {
        for (int i = GL_LIGHTING_DEPTH; i <= GL_LIGHTING_SHADING; i++)
            seconds += gl_lighting_seconds(&v->left, i);
        v->drawn_at = governor_frame(&v->governor, (float)(1e3 * seconds), v->drawn_at);
        v->now = &governor_ladder[v->drawn_at];
    }
    if (v->now->lights != v->lights.settings.probe.max_lights) {
        v->lights.settings.probe.max_lights = v->now->lights;
        v->lights.lights = 0; // start afresh instead of going on from the last frame's
    }
    return set_side(v, v->now->map_side, why);
}

static bool light_scene(viewer *v, message *why)
{
    scene_free(&v->s);
    if (!probe_rotate(&v->turned, &v->source, 2 * VEC_PI * v->time / 60) ||
        !scene_create(&v->s, v->time, NULL)) {
        return fail(why, "no memory");
    }
    gl_probe_upload(&v->left.probe, v->turned.face, v->turned.side);
    return lighting_extract(&v->lights, &v->turned, why) &&
           gl_lighting_draw_maps(&v->left, &v->lights, &v->s, why);
}

static void draw_right(viewer *v, const camera *eye)
{
    const gl_reference_kind kind = (gl_reference_kind)(v->compare - METHOD_HARD);
    if (v->compare == METHODS - 1) return;
    v->samples = v->stale ? 0 : v->samples;
    if (v->compare >= METHOD_HARD) {
        gl_reference_draw(&v->reference, &v->left, v->lights.lights, &v->s, kind, v->samples);
    }
    shade_half(v, eye, &v->right, v->compare, kind == GL_REFERENCE_TRUTH && v->samples > 0);
    v->samples = kind == GL_REFERENCE_TRUTH && v->compare >= METHOD_HARD ? v->samples + 1 : 1;
}

static void draw_text(viewer *v)
{
    char line[GL_TEXT_LENGTH], right[64] = "", held[64] = "";
    if (v->compare < METHODS - 1) {
        snprintf(right, sizeof right, " and %s (%d)", method_name[v->compare], v->samples);
    }
    if (v->budget) {
        snprintf(held, sizeof held, "holding %.0f ms: level %d of %d, maps of %d\n",
                 (double)budgets[v->budget], v->governor.level, governor_ladder_levels,
                 v->lights.settings.map_side);
    }
    snprintf(line, sizeof line,
             "%s%s, %d lights, %s moments, %s faces, size %.2f\n"
             "extract %.1f ms, depth %.1f, tables %.1f, view %.1f, shading %.1f\n%s%s",
             method_name[v->now->estimator], right, v->lights.lights,
             v->now->moments == 0   ? "4 or 6"
             : v->now->moments == 4 ? "4"
                                    : "6",
             v->lights.settings.back_faces ? "both" : "front", (double)v->left.size,
             1e3 * v->lights.extract_seconds,
             1e3 * gl_timer_latest(&v->left.timer, GL_LIGHTING_DEPTH),
             1e3 * gl_timer_latest(&v->left.timer, GL_LIGHTING_TABLES),
             1e3 * gl_timer_latest(&v->left.timer, GL_LIGHTING_VIEW),
             1e3 * gl_timer_latest(&v->left.timer, GL_LIGHTING_SHADING), held, help);
    gl_text_draw(&v->text, line, v->width, v->height, v->width > 1600 ? 3 : v->width < 960 ? 1 : 2);
}

static void display(viewer *v)
{
    const bool whole = v->compare == METHODS - 1;
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl.Viewport(0, 0, v->width, v->height);
    gl.BindTextureUnit(0, v->left.picture.color[0]);
    gl.BindTextureUnit(1, v->right.color[0]);
    gl.ProgramUniform2f(v->display, gl.GetUniformLocation(v->display, "exposure"), v->exposure,
                        v->exposure / (float)(v->samples > 0 ? v->samples : 1));
    gl.ProgramUniform1f(v->display, gl.GetUniformLocation(v->display, "split"),
                        whole ? 2 * (float)v->width : v->split * (float)v->width);
    gl.UseProgram(v->display);
    gl_mesh_draw(&v->triangle);
    if (v->show_text) draw_text(v);
}

static bool frame(viewer *v, message *why)
{
    const vec3 centre = vec(-0.05f, 0.8f, 0), back = {0, sinf(v->tilt), cosf(v->tilt)};
    const vec3 at = vec_mad(centre, vec_turn(back, v->turn), v->distance);
    if (!resized(v, why)) return false;
    const camera eye = camera_look(at, centre, 0.57f, (float)v->width / (float)v->height);
    if (v->animate) v->time += 1.0f / 30, v->stale = true;
    if (v->stale) {
        if (!govern(v, why) || !light_scene(v, why)) return false;
        gl_lighting_draw_view(&v->left, &v->s, &eye);
        shade_half(v, &eye, &v->left.picture, (int)v->now->estimator, false);
    }
    draw_right(v, &eye);
    v->stale = false;
    if (v->exposure == 0) {
        image picture;
        if (!gl_target_read(&v->left.picture, &picture, why)) return false;
        v->exposure = lighting_exposure(&picture, &v->s, &eye);
        image_free(&picture);
    }
    display(v);
    return true;
}

static bool screenshot(const viewer *v, const char *file, message *why)
{
    const size_t row = 3 * (size_t)v->width, height = (size_t)v->height;
    unsigned char *pixels = malloc(2 * row * height), *turned = pixels + row * height;
    if (!pixels) return fail(why, "no memory for a picture");
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl.ReadPixels(0, 0, v->width, v->height, GL_RGB, GL_UNSIGNED_BYTE, pixels);
    for (size_t y = 0; y < height; y++)
        memcpy(turned + y * row, pixels + (height - 1 - y) * row, row);
    const bool written = png_write(file, turned, v->width, v->height, why);
    free(pixels);
    printf("%s\n", file);
    return written;
}

static bool run(viewer *v, const char *file, int frames, const char *keys, message *why)
{
    if (!open_viewer(v, why)) return false;
    glfwSetWindowUserPointer(v->window, v);
    glfwSetKeyCallback(v->window, on_key);
    glfwSetCursorPosCallback(v->window, on_mouse);
    glfwSetScrollCallback(v->window, on_scroll);
    for (; *keys; keys++) {
        if (*keys != '.')
            press(v, *keys);
        else if (!frame(v, why))
            return false;
    }
    for (int i = 1; !glfwWindowShouldClose(v->window) && (!frames || i <= frames); i++) {
        glfwPollEvents();
        if (!frame(v, why)) return false;
        if (v->save || (file && i == frames)) {
            if (!screenshot(v, file ? file : "viewer.png", why)) return false;
            v->save = false;
        }
        glfwSwapBuffers(v->window);
    }
    return true;
}

int main(int argc, char **argv)
{
    static viewer v = {.own = {16, MAP_SIDE, 0, MSSM_LAYERED, 0},
                       .compare = METHODS - 1,
                       .turn = 0.04f,
                       .tilt = 0.2f,
                       .distance = 7.9f,
                       .split = 0.5f,
                       .show_text = true,
                       .stale = true,
                       .width = 960,
                       .height = 540};
    static const char usage[] =
        "viewer [--size WxH] [--screenshot FILE] [--frames N] [--keys KEYS]";
    message why = {"no memory"};
    const char *file = NULL, *keys = "";
    int frames = 0;
    bool good = true;
    if (options_help_asked(argc, argv, usage)) return 0;
    for (int i = 1; i < argc && good; i += 2) {
        const char *name = argv[i], *value = i + 1 < argc ? argv[i + 1] : "";
        if (!strcmp(name, "--screenshot") && *value) {
            file = value;
        } else if (!strcmp(name, "--keys")) {
            keys = value;
        } else if (!(!strcmp(name, "--size") && options_size(value, &v.width, &v.height)) &&
                   !(!strcmp(name, "--frames") && options_int(value, 0, INT_MAX, &frames))) {
            good = fail(&why, "%.60s cannot be \"%.40s\"; sizes are 16x16 to 8192x8192; usage: %s",
                        name, value, usage);
        }
    }
    const bool done = good && run(&v, file, frames, keys, &why);
    if (!done) fprintf(stderr, "viewer: %s\n", why.text);
    close_viewer(&v);
    return done ? 0 : 1;
}
