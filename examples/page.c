// The scenes of gl_hello and of the demo with its probe, interactive in a browser: WebGL 2, with
// maps made on the CPU.
//     make page     with emscripten: makes build/page/page.html, a single file
// Drag to turn the light or the probe; the wheel changes the light's size.
#include "../lightprobe.h"
#include "../mssm.h"

#include "common/gl33_shadows.h"
#include "common/probe.h"
#include "common/raster.h"

#include <emscripten.h>
#include <emscripten/html5.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 256, SAMPLES = 4, LIGHTS = GL33_LIGHTS, BLOCK = 192 + 80 * LIGHTS };
enum { HELLO, DEMO, SCENES };

static struct {
    scene scenes[SCENES];
    gl33_mesh mesh[SCENES];
    probe source, turned;
    gl33_shadows shadows;
    GLuint program, lights_buffer;
    mssm_map *map;
    lightprobe_light light[LIGHTS];
    lightprobe_stats stats;
    int shown, lights;
    float azimuth, elevation, size, turn; // of the light; of the probe
    bool changed, dragging;
} page = {.shadows = {.lights = LIGHTS},
          .azimuth = 2.9927f,
          .elevation = 0.8258f,
          .size = 0.12f,
          .changed = true};

static const char fragment[] =
    "uniform float exposure;\n"
    "in vec3 position, normal, albedo;\n"
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec3 n = normalize(normal), sum = lightprobe_residual_irradiance(n);\n"
    "    for (int i = 0; i < lightprobe_count; i++) {\n"
    "        vec3 light = lightprobe_irradiance(i, n);\n"
    "        if (light != vec3(0.0)) sum += light * mssm_visibility(i, position);\n"
    "    }\n"
    "    vec3 x = 1.0 + 0.5 * exposure * albedo * sum, film = 1.0 - 1.0 / (x * x);  // as image_tonemap()\n"
    "    color = vec4(mix(12.92 * film, 1.055 * pow(film, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, film)), 1.0);\n"
    "}\n";

// ---- Lights

// One light, with the sky of gl_hello as the residual.
static bool light_hello(void)
{
    const float c = cosf(page.elevation);
    const float to_light[3] = {c * cosf(page.azimuth), sinf(page.elevation),
                               c * sinf(page.azimuth)};
    lightprobe_light *l = &page.light[0];
    memset(l, 0, sizeof *l);
    memset(&page.stats, 0, sizeof page.stats);
    memcpy(l->direction, to_light, sizeof to_light);
    l->axis_u[0] = l->cos_alpha = 1;
    l->tan_half_u = l->tan_half_v = page.size;
    for (int i = 0; i < 3; i++) {
        l->irradiance[i] = 1;
        page.stats.residual_sh[0][i] = 0.2f;
        page.stats.residual_sh[1][i] = 0.1f; // times the normal's y
    }
    page.lights = 1;
    return true;
}

// The lights of the turned probe.
static bool light_demo(message *why)
{
    lightprobe_cube cube = {.side = page.source.side, .channels = 3};
    const lightprobe_settings settings = {.max_lights = LIGHTS};
    const size_t bytes = lightprobe_scratch_bytes(cube.side, LIGHTS);
    void *scratch = malloc(bytes);
    bool good = scratch && probe_rotate(&page.turned, &page.source, page.turn);
    for (int i = 0; i < 6; i++) cube.face[i] = page.turned.face[i];
    good = good && !lightprobe_extract(&cube, &settings, scratch, bytes, page.light, &page.lights,
                                       &page.stats);
    free(scratch);
    return good || fail(why, "no lights in the probe");
}

static bool draw_maps(message *why)
{
    static float depth[SIDE * SIDE * SAMPLES];
    static const float hello_low[3] = {-0.15f, 0, -0.5f}, hello_high[3] = {0.15f, 1.5f, 0.5f};
    const scene *s = &page.scenes[page.shown];
    const float low[3] = {s->low.x, s->low.y, s->low.z},
                high[3] = {s->high.x, s->high.y, s->high.z};
    const bool hello = page.shown == HELLO; // whose ground is much larger than the caster
    for (int i = 0; i < page.lights; i++) {
        const lightprobe_light *l = &page.light[i];
        mssm_light frustum;
        if (mssm_light_directional(&frustum, l->direction, l->axis_u, l->tan_half_u, l->tan_half_v,
                                   hello ? hello_low : low, hello ? hello_high : high)) {
            return fail(why, "no light");
        }
        const raster_frustum view = {frustum.world_to_shadow, false, 0, 0};
        if (!raster_depth(s, &view, RASTER_FRONT, SIDE, SAMPLES, depth) ||
            mssm_map_update(page.map, depth, NULL, SAMPLES) ||
            !gl33_shadows_upload(&page.shadows, i, page.map, &frustum, why)) {
            return false;
        }
    }
    return true;
}

// ---- The picture

static bool draw(message *why)
{
    static unsigned char block[BLOCK];
    const camera eyes[SCENES] = {
        camera_look(vec(2.5f, 3.3f, 3.8f), vec(0.42f, 0.58f, 0), 0.52f, 4.0f / 3),
        camera_look(vec(0.3f, 2.25f, 7.7f), vec(-0.05f, 0.86f, 0), 0.57f, 4.0f / 3)};
    const float exposure[SCENES] = {1.3f, 0.6f};
    float world_to_clip[16];
    int width, height;
    if (!(page.shown == HELLO ? light_hello() : light_demo(why)) || !draw_maps(why)) return false;
    if (lightprobe_uniforms(page.light, page.lights, &page.stats, block, BLOCK))
        return fail(why, "no lights");
    gl33.BindBufferBase(GL_UNIFORM_BUFFER, 1, page.lights_buffer);
    gl33.BufferData(GL_UNIFORM_BUFFER, BLOCK, block, 0x88E8); // GL_DYNAMIC_DRAW
    gl33_shadows_bind(&page.shadows);
    gl_camera_matrix(&eyes[page.shown], 0.1f, 30, world_to_clip);
    emscripten_get_canvas_element_size("#canvas", &width, &height); // of 4:3
    gl33.Viewport(0, 0, width, height);
    gl33.ClearColor(0.3f, 0.35f, 0.4f, 1);
    gl33.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    gl33.Enable(GL_DEPTH_TEST);
    gl33.UseProgram(page.program);
    gl33.UniformMatrix4fv(gl33.GetUniformLocation(page.program, "world_to_clip"), 1, GL_FALSE,
                          world_to_clip);
    gl33.Uniform1f(gl33.GetUniformLocation(page.program, "exposure"), exposure[page.shown]);
    gl33_mesh_draw(&page.mesh[page.shown]);
    return gl33.GetError() == GL_NO_ERROR || fail(why, "WebGL refused a call");
}

static void frame(void)
{
    message why = {""};
    if (!page.changed) return;
    page.changed = false;
    const bool good = draw(&why);
    EM_ASM({ said(UTF8ToString($0), $1); }, why.text, good);
}

// ---- The page

EMSCRIPTEN_KEEPALIVE void page_show(int which)
{
    page.shown = which;
    page.changed = true;
}

static EM_BOOL mouse(int type, const EmscriptenMouseEvent *e, void *user)
{
    (void)user;
    if (type == EMSCRIPTEN_EVENT_MOUSEDOWN) page.dragging = true;
    if (type == EMSCRIPTEN_EVENT_MOUSEUP) page.dragging = false;
    if (type != EMSCRIPTEN_EVENT_MOUSEMOVE || !page.dragging) return EM_FALSE;
    const float x = (float)e->movementX * 0.01f, y = (float)e->movementY * 0.01f;
    if (page.shown == DEMO)
        page.turn += x;
    else
        page.azimuth -= x, page.elevation = fminf(fmaxf(page.elevation - y, 0.1f), 1.5f);
    page.changed = true;
    return EM_TRUE;
}

static EM_BOOL wheel(int type, const EmscriptenWheelEvent *e, void *user)
{
    (void)type, (void)user;
    page.size = fminf(fmaxf(page.size * expf(e->deltaY > 0 ? -0.15f : 0.15f), 0.005f), 0.6f);
    page.changed = true;
    return EM_TRUE;
}

static void (*find(const char *name))(void)
{
    void *address = emscripten_webgl2_get_proc_address(name);
    if (!address) address = emscripten_webgl1_get_proc_address(name);
    void (*f)(void);
    memcpy(&f, &address, sizeof f);
    return f;
}

static bool open_page(message *why)
{
    const scene_frame ground = scene_frame_at(vec(0, -0.1f, 0), 0, 0),
                      wall = scene_frame_at(vec(0, 0.75f, 0), 0, 0);
    const char *const before[] = {"#define LIGHTPROBE_UNIFORMS 16\n", lightprobe_glsl_math(),
                                  lightprobe_glsl_lights(), NULL};
    const char *missing = "";
    EmscriptenWebGLContextAttributes attributes;
    emscripten_webgl_init_context_attributes(&attributes);
    attributes.majorVersion = 2;
    attributes.antialias = EM_TRUE;
    attributes.preserveDrawingBuffer = EM_TRUE; // for screenshots
    const EMSCRIPTEN_WEBGL_CONTEXT_HANDLE context =
        emscripten_webgl_create_context("#canvas", &attributes);
    if (context <= 0 || emscripten_webgl_make_context_current(context))
        return fail(why, "this browser has no WebGL 2");
    if (!gl33_load(find, &missing)) return fail(why, "WebGL 2 lacks %s", missing);
    scene *s = &page.scenes[HELLO];
    scene_begin_object(s, 0.7f, 0.7f, 0.68f);
    scene_put_box(s, &ground, vec(15, 0.1f, 15));
    scene_begin_object(s, 0.8f, 0.3f, 0.15f);
    scene_put_box(s, &wall, vec(0.1f, 0.75f, 0.45f));
    const size_t bytes = mssm_map_bytes(SIDE, 6);
    if (!scene_end(s) || !scene_create(&page.scenes[DEMO], 0, NULL) ||
        !probe_default(&page.source, 64) || !probe_create(&page.turned, 64) ||
        mssm_map_init(&page.map, malloc(bytes), bytes, SIDE, 6)) {
        return fail(why, "no memory");
    }
    for (int i = 0; i < SCENES; i++)
        if (!gl33_mesh_upload(&page.mesh[i], &page.scenes[i], why)) return false;
    page.program = gl33_shadows_program("#version 300 es\n", LIGHTS, before, fragment, why);
    if (!page.program) return false;
    gl33.UniformBlockBinding(page.program,
                             gl33.GetUniformBlockIndex(page.program, "lightprobe_buffer"), 1);
    gl33.GenBuffers(1, &page.lights_buffer);
    emscripten_set_mousedown_callback("#canvas", NULL, EM_FALSE, mouse);
    emscripten_set_mouseup_callback(EMSCRIPTEN_EVENT_TARGET_WINDOW, NULL, EM_FALSE, mouse);
    emscripten_set_mousemove_callback("#canvas", NULL, EM_FALSE, mouse);
    emscripten_set_wheel_callback("#canvas", NULL, EM_FALSE, wheel);
    return true;
}

int main(void)
{
    message why;
    if (open_page(&why))
        emscripten_set_main_loop(frame, 0, 0);
    else
        EM_ASM({ said(UTF8ToString($0), 0); }, why.text);
    return 0;
}
