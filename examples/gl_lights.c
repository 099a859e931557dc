// Every kind of light over one scene, OpenGL 4.5, no window:
//     cc -O2 -I. examples/gl_lights.c examples/common/*.c -lm -lpthread -ldl && ./a.out lights.png
// Above: a sun, the sun in a box, a spot. Below: a point light, an area light, that light sampled.
#include "common/gl_example.h"
#include "common/gl_range.h"
#include "common/gl_sampled.h"

enum { SUN, BOXED, SPOT, LAMP, AREA, SAMPLED, KINDS, MAPS = 10, WIDTH = 480, HEIGHT = 360 };
static const float sun[3] = {-0.7f, 1, 0.5f}, axis[3] = {1, 0, 0}, up[3] = {0, 1, 0};
static const float position[3] = {-1.6f, 3.2f, 1.2f}, aim[3] = {-0.4f, 0.866667f, 0.3f};
static const float lamp[3] = {0.9f, 1.5f, 1.3f};
static const float room[2][3] = {{-4.4f, -0.2f, -4.4f}, {4.4f, 2.2f, 4.4f}};
static const float box[2][3] = {{-1.3f, -0.2f, -1.5f}, {1.5f, 2.2f, 1.3f}}, half_width = 0.35f;

static const char shading[] = // after mssm_gl_shader() and mssm_glsl_lights()
    "layout(binding = 0) uniform sampler2D map[4];\n" // position, normal, albedo, sum of samples
    "layout(location = 0) uniform int kind; layout(location = 1) uniform vec3 place[4];\n"
    "vec3 at = place[0], axis = place[1]; out vec4 color;\n" // see shade()
    "float visibility(vec3 p)\n"
    "{\n"
    "    vec4 sum = texelFetch(map[3], ivec2(gl_FragCoord.xy) % textureSize(map[3], 0), 0);\n"
    "    if (kind == 5) return sum.x / sum.w;\n"
    "    if (kind != 3) return mssm_visibility(kind == 4 ? 3 : kind, p);\n"
    "    mssm_faces f = mssm_point_faces(p.x - at.x, p.y - at.y, p.z - at.z);\n"
    "    float seen = 0;\n"
    "    for (int i = 0; i < 3; i++)\n"
    "        if (f.weight[i] > 0) seen += f.weight[i] * mssm_visibility(4 + f.face[i], p);\n"
    "    return seen;\n"
    "}\n"
    "float strength(vec3 p, vec3 n)\n" // of the light as it arrives, were there no shadows
    "{\n"
    "    vec3 to = kind < 2 ? at : at - p;\n"
    "    float facing = max(dot(n, normalize(to)), 0), away = dot(normalize(to), axis);\n"
    "    if (kind < 2) return kind == 0 || clamp(p, place[2], place[3]) == p ? facing : 0;\n"
    "    if (kind == 2) facing *= mssm_cone(away, 0.9, 0.8, 8);\n"
    "    if (kind >= 4) facing *= max(away, 0);\n" // a flat light shines by the cosine
    "    return facing * (kind == 3 ? 3 : 14) * mssm_attenuation(length(to), 0, 0, 1);\n"
    "}\n"
    "void main()\n"
    "{\n"
    "    ivec2 pixel = ivec2(gl_FragCoord.xy) % textureSize(map[0], 0);\n"
    "    vec4 p = texelFetch(map[0], pixel, 0);\n"
    "    float light = strength(p.xyz, texelFetch(map[1], pixel, 0).xyz);\n"
    "    if (light > 0) light *= visibility(p.xyz);\n"
    "    color = p.w * texelFetch(map[2], pixel, 0) * (light + 0.06);\n"
    "}\n";

static mssm_gl *shadows;
static mssm_light light[MAPS];
static gl_range range;
static gl_sampled sampled;
static gl_mesh casters, triangle;
static gl_surfaces surfaces;
static gl_target all;
static GLuint depth, program;

static mssm_light area_light(const void *half, float x, float y)
{
    const float at[3] = {position[0] + x * half_width, position[1], position[2] + y * half_width};
    mssm_light f = {{0}, 0, 0, 0, 1, 1, -1, 1};
    mssm_light_spot(&f, at, up, axis, 2.2f, 0.5f, 5, *(const float *)half, *(const float *)half);
    return f;
}

static bool create(const scene *s, message *why)
{
    const mssm_gl_desc desc = {.load = gl_context_function,
                               .lights = MAPS,
                               .side = 512,
                               .first_texture_unit = 4,
                               .first_buffer_binding = 1};
    if (mssm_light_directional(&light[SUN], sun, axis, 0.06f, 0.06f, room[0], room[1]) ||
        mssm_light_directional(&light[BOXED], sun, axis, 0.06f, 0.06f, box[0], box[1]) ||
        mssm_light_spot(&light[SPOT], position, aim, axis, 0.76f, 0.5f, 9, 0.1f, 0.1f) ||
        mssm_light_point(&light[4], lamp, 0.35f, 8, 0.08f) || mssm_gl_create(&shadows, &desc)) {
        return fail(why, "no shadow maps");
    }
    light[3] = area_light(&half_width, 0, 0);
    const char *const vertex[] = {gl_triangle_vertex, NULL};
    const char *const texts[] = {mssm_gl_shader(shadows), mssm_glsl_lights(), shading, NULL};
    gl_mesh_triangle(&triangle);
    return (depth = gl_program_simple("depth", gl_depth_vertex, NULL, why)) &&
           (program = gl_program("lights", vertex, texts, why)) &&
           gl_range_create(&range, MAPS, 512, why) &&
           gl_sampled_create(&sampled, 1024, WIDTH, HEIGHT, why) &&
           gl_surfaces_create(&surfaces, WIDTH, HEIGHT, why) &&
           gl_target_create(&all, WIDTH * 3, HEIGHT * 2, 1, (GLenum[3]){GL_RGBA32F}, why) &&
           gl_mesh_upload(&casters, s, why);
}

static void draw_shadows(void)
{
    for (int i = 0; i < MAPS; i++) {
        const mssm_light f = gl_range_fit(&range, i, &light[i]);
        mssm_gl_set_light(shadows, i, &f);
        mssm_gl_begin_depth(shadows, i, 0);
        gl.UseProgram(depth);
        gl.ProgramUniformMatrix4fv(depth, 0, 1, GL_FALSE, f.world_to_shadow);
        gl_mesh_draw(&casters);
        gl_range_reduce(&range, i, shadows);
        mssm_gl_end_depth(shadows);
    }
    mssm_gl_build(shadows);
}

static void shade(int kind)
{
    const float *at = kind <= BOXED ? sun : kind == LAMP ? lamp : position;
    gl.Viewport(kind % 3 * WIDTH, kind < 3 ? HEIGHT : 0, WIDTH, HEIGHT);
    gl.ProgramUniform1i(program, 0, kind);
    gl.ProgramUniform3fv(program, 1, 1, at); // the light's position, or the direction to the sun
    gl.ProgramUniform3fv(program, 2, 1, kind == SPOT ? aim : up);
    gl.ProgramUniform3fv(program, 3, 2, box[0]);
    gl_mesh_draw(&triangle);
}

static bool draw(const char *file, message *why)
{
    const camera eye = camera_look(vec(0.3f, 3.4f, 5.6f), vec(-0.05f, 0.6f, 0), 0.66f, 4.0f / 3);
    for (int i = 0; i < 32; i++) { // nothing moves, so the state is always 1
        draw_shadows();
        gl_surfaces_draw(&surfaces, &casters, &eye);
        gl_sampled_add(&sampled, 1, 8, area_light, &(float){0}, &casters, surfaces.target.color,
                       0.01f);
    }
    gl_target_begin(&all);
    gl.UseProgram(program);
    for (GLuint i = 0; i < GL_TARGET_COLORS; i++) gl.BindTextureUnit(i, surfaces.target.color[i]);
    gl.BindTextureUnit(3, sampled.sum.color[0]);
    mssm_gl_bind(shadows);
    for (int kind = 0; kind < KINDS; kind++) shade(kind);
    return gl_target_save(&all, 1.6f, file, why);
}

static bool run(int argc, char **argv, message *why)
{
    scene s = {0};
    const bool done = scene_create(&s, 0, NULL) && create(&s, why) &&
                      draw(argc > 1 ? argv[1] : "lights.png", why);
    scene_free(&s);
    gl_range_free(&range);
    mssm_gl_destroy(shadows); // the rest goes with the context
    return done;
}

int main(int argc, char **argv)
{
    return gl_example_main(
        argc, argv, "gl_lights [PICTURE.png]: every kind of light, the last beside its truth", run);
}
