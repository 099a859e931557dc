// Smoke that shadows solids and itself and is shadowed by solids, under a sun without size
// (a filtered moment map) and a wide one (tables of the same moments), OpenGL 4.5, no window:
//     cc -O2 -I. examples/gl_smoke.c examples/common/*.c -lm -lpthread -ldl && ./a.out smoke
#include "common/gl_example.h"
#include "common/gl_smoke_plume.h"

#include <stdio.h>
#include <time.h>

enum { WIDTH = 640, HEIGHT = 360, SIDE = 512 };
static const char *const bounds_text[2] = {
    "mssm_bounds seen(vec3 p) { return mssm_filtered_bounds(0, p, dFdx(p), dFdy(p)); }\n",
    "mssm_bounds seen(vec3 p) { float v = mssm_visibility(0, p); return mssm_bounds(v, v); }\n"};
static const char solid_text[] =
    "layout(location = 2) uniform vec3 sun;\n"
    "in vec3 position, normal, albedo; out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec3 n = normalize(normal);\n"
    "    color = vec4(albedo * surface(max(dot(n, sun), 0) * seen(position).upper, n.y), 1);\n"
    "}\n";
static const char smoke_text[] =
    "out vec4 color;\n"
    "void main() { // half of the smoke round a place is behind it: the middle of both bounds\n"
    "    mssm_bounds b = seen(position);\n"
    "    color = vec4(vec3(scattered(0.5 * (b.lower + b.upper))), opacity()); }\n";
static const char layer_text[] =
    "void main() { mssm_translucent(2 * gl_FragCoord.z - 1, opacity()); }\n";

static const char usage[] =
    "gl_smoke [STEM [MOMENTS]]: compares smoke and its shadows with rays; writes STEM.png,\n"
    "STEM-soft.png and their -truth.png. MOMENTS of the first: 4 (64 bits a texel) or 6 (96)";

static scene solids;
static gl_mesh casters, receivers; // the latter with floor and wall too, which shade nothing
static gl_smoke_plume smoke;
static const gl_smoke_sun sun[2] = {{{-0.6f, 0.64f, 0.48f}, {0, 1, 0}, 0},
                                    {{-0.6f, 0.64f, 0.48f}, {0, 1, 0}, 0.1f}};
static mssm_light light;
static mssm_gl *hard, *soft;
static GLuint depth, layer;

static bool create(int moments, message *why)
{
    const mssm_gl_desc hard_desc = {.load = gl_context_function,
                                    .filtered = 1,
                                    .side = SIDE,
                                    .moments = moments,
                                    .first_buffer_binding = 1};
    const mssm_gl_desc soft_desc = {
        .load = gl_context_function, .side = SIDE, .first_buffer_binding = 1};
    const char *const vertex[] = {gl_smoke_vertex, NULL};
    const char *const text[] = {mssm_glsl_math(), mssm_glsl_translucent(), gl_smoke_opacity,
                                layer_text, NULL};
    float low[3], high[3];
    if (!gl_smoke_scene(&solids, &casters, &receivers, &smoke, low, high, why)) return false;
    if (mssm_light_directional(&light, sun[1].direction, sun[1].axis, sun[1].half, sun[1].half, low,
                               high) ||
        mssm_gl_create(&hard, &hard_desc) || mssm_gl_create(&soft, &soft_desc) ||
        mssm_gl_set_light(soft, 0, &light)) {
        return fail(why, "no shadow maps");
    }
    return (depth = gl_program_simple("depth", gl_depth_vertex, NULL, why)) &&
           (layer = gl_program("layer", vertex, text, why));
}

static double cpu_seconds(void) // since the last call
{
    static clock_t last;
    const clock_t before = last;
    gl.Finish();
    return (double)((last = clock()) - before) / CLOCKS_PER_SEC;
}

static void draw_maps(void)
{
    cpu_seconds();
    gl_example_map(hard, 0, &light, depth, &casters);
    mssm_gl_begin_translucent(hard);
    gl_smoke_draw(&smoke, layer, light.world_to_shadow, vec_of(sun->direction), 0);
    mssm_gl_end_translucent(hard);
    mssm_gl_set_moments(soft, 0, mssm_gl_texture(hard, 3)); // as long as they are sharp
    mssm_gl_build(soft);
    mssm_gl_build(hard);
    printf("CPU seconds: maps %.2f\n", cpu_seconds());
}

static bool draw_picture(bool wide, const camera *eye, const gl_target *target, message *why)
{
    const char *const map = wide ? mssm_gl_shader(soft) : mssm_gl_shader(hard);
    const char *const vertex[] = {gl_scene_vertex, NULL, gl_smoke_vertex, NULL};
    const char *const solid[] = {map, gl_smoke_shading, bounds_text[wide], solid_text, NULL};
    const char *const puff[] = {
        map, gl_smoke_shading, bounds_text[wide], gl_smoke_opacity, smoke_text, NULL};
    const GLuint solid_program = gl_program("solids", vertex, solid, why);
    const GLuint smoke_program = gl_program("smoke", vertex + 2, puff, why);
    float world_to_clip[16];
    if (!solid_program || !smoke_program) return false;
    gl_camera_matrix(eye, 0.1f, 30, world_to_clip);
    cpu_seconds();
    gl_target_begin(target);
    gl.Enable(GL_DEPTH_TEST);
    gl_camera_use(eye, 0.1f, 30, solid_program);
    gl.ProgramUniform3fv(solid_program, 2, 1, sun->direction);
    (void)(wide ? mssm_gl_bind(soft) : mssm_gl_bind(hard));
    gl_mesh_draw(&receivers);
    gl_smoke_draw(&smoke, smoke_program, world_to_clip, eye->position, 1);
    return true;
}

static bool compare(bool wide, const char *file, const camera *eye, const gl_target *target,
                    message *why)
{
    image ours = {0}, truth = {0};
    char name[300];
    if (!draw_picture(wide, eye, target, why)) return false;
    printf("%s sun %.2f", wide ? "wide" : "small", cpu_seconds());
    bool done = gl_target_read(target, &ours, why) &&
                gl_smoke_trace(&smoke, &solids, eye, &sun[wide], WIDTH, HEIGHT, &truth, why);
    if (done) printf(", rays %.2f; rms error %.4f\n", cpu_seconds(), image_rms(&ours, &truth));
    for (int rays = 0; rays < 2 && done; rays++) {
        snprintf(name, sizeof name, "%s%s%s.png", file, wide ? "-soft" : "", rays ? "-truth" : "");
        done = image_save_png(rays ? &truth : &ours, 1.3f, name, why);
    }
    image_free(&ours);
    image_free(&truth);
    return done;
}

static bool run(int argc, char **argv, message *why)
{
    const char *const file = argc > 1 ? argv[1] : "smoke";
    const camera eye = camera_look(vec(0.6f, 2.4f, 6.3f), vec(0.1f, 1.3f, 0), 0.54f, 16.0f / 9);
    int moments = 6;
    gl_target target;
    if ((argc > 2 && !options_int(argv[2], 4, 6, &moments)) || moments == 5)
        return fail(why, "MOMENTS are 4 or 6");
    bool done = create(moments, why) &&
                gl_target_create(&target, WIDTH, HEIGHT, 4, (GLenum[3]){GL_RGBA32F}, why);
    if (done) draw_maps();
    for (int wide = 0; wide < 2 && done; wide++)
        done = compare(wide != 0, file, &eye, &target, why);
    scene_free(&solids);
    mssm_gl_destroy(hard);
    mssm_gl_destroy(soft); // the rest goes with the context
    return done;
}

int main(int argc, char **argv)
{
    return gl_example_main(argc, argv, usage, run);
}
