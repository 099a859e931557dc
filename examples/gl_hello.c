// One area light, one caster, one soft shadow, OpenGL 4.5, no window:
//     cc -O2 -I. examples/gl_hello.c examples/common/*.c -lm -lpthread -ldl && ./a.out hello.png
// All that mssm.h needs is in shadow_create(), shadow_draw() and the fragment shader.
#include "common/gl_example.h"

static const float to_light[3] = {-1, 1.1f, 0.15f}, axis[3] = {1, 0, 0};
static const float box_min[3] = {-0.15f, 0, -0.5f}, box_max[3] = {0.15f, 1.5f, 0.5f};

// ---- What you add to your renderer ---------------------------------------------------------------

static bool shadow_create(mssm_gl **shadow, mssm_light *light, message *why)
{
    const mssm_gl_desc desc = {.load = gl_context_function, .side = 256};
    mssm_result result =
        mssm_light_directional(light, to_light, axis, 0.12f, 0.12f, box_min, box_max);
    if (result == MSSM_OK) result = mssm_gl_create(shadow, &desc);
    if (result == MSSM_OK) result = mssm_gl_set_light(*shadow, 0, light);
    return result == MSSM_OK || fail(why, "%s", mssm_result_string(result));
}

// Call this whenever the light or the casters have moved.
static void shadow_draw(mssm_gl *shadow, const mssm_light *light, GLuint depth,
                        const gl_mesh *casters)
{
    mssm_gl_begin_depth(shadow, 0, 0);
    gl.UseProgram(depth); // gl_Position = world_to_shadow * position
    gl.ProgramUniformMatrix4fv(depth, 0, 1, GL_FALSE, light->world_to_shadow);
    gl_mesh_draw(casters);
    mssm_gl_end_depth(shadow);
    mssm_gl_build(shadow);
}

// Compiled with mssm_gl_shader() in front of it.
static const char fragment[] =
    "uniform vec3 to_light;\n"
    "in vec3 position, normal, albedo;\n"
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec3 n = normalize(normal);\n"
    "    float light = max(dot(n, normalize(to_light)), 0) * mssm_visibility(0, position);\n"
    "    float sky = 0.2 + 0.1 * n.y;\n"
    "    color = vec4(albedo * (light + sky), 1);\n"
    "}\n";

// ---- What every renderer has ---------------------------------------------------------------------

enum { BOXES = 2 };
static vec3 corner[BOXES * 24], normal[BOXES * 24];
static int triangle[BOXES * 12][3];
static unsigned char object[BOXES * 12];

static void add_box(int index, vec3 centre, vec3 half)
{
    static const int quad[6] = {0, 1, 2, 0, 2, 3};
    for (int i = 0; i < 24; i++) { // four corners of six sides, counter-clockwise from outside
        const int side = i / 4, u = i % 4 == 1 || i % 4 == 2 ? 1 : -1, v = i % 4 >= 2 ? 1 : -1;
        const float sign = side & 1 ? -1.0f : 1.0f;
        const float local[3] = {sign, (float)u, (float)v * sign}, n[3] = {sign, 0, 0};
        const int x = (3 - side / 2) % 3, y = (x + 1) % 3, z = (x + 2) % 3;
        corner[24 * index + i] = vec_add(centre, vec_mul(half, vec(local[x], local[y], local[z])));
        normal[24 * index + i] = vec(n[x], n[y], n[z]);
    }
    for (int i = 0; i < 36; i++) {
        triangle[12 * index + i / 3][i % 3] = 24 * index + i / 6 * 4 + quad[i % 6];
        object[12 * index + i / 3] = (unsigned char)index;
    }
}

static bool run(int argc, char **argv, message *why)
{
    const camera eye = camera_look(vec(2.5f, 3.3f, 3.8f), vec(0.42f, 0.58f, 0), 0.52f, 4.0f / 3);
    const scene s = {.position = corner,
                     .normal = normal,
                     .triangle = triangle,
                     .object = object,
                     .albedo = {{0.7f, 0.7f, 0.68f}, {0.8f, 0.3f, 0.15f}},
                     .vertices = BOXES * 24,
                     .triangles = BOXES * 12,
                     .objects = BOXES};
    gl_mesh casters = {0};
    gl_target target;
    mssm_gl *shadow;
    mssm_light light;
    add_box(0, vec(0, -0.1f, 0), vec(15, 0.1f, 15));
    add_box(1, vec(0, 0.75f, 0), vec(0.1f, 0.75f, 0.45f));
    if (!gl_mesh_upload(&casters, &s, why) || !shadow_create(&shadow, &light, why) ||
        !gl_target_create(&target, 1024, 768, 4, (GLenum[3]){GL_RGBA32F}, why)) {
        return false;
    }
    const char *const vertices[] = {gl_scene_vertex, NULL};
    const char *const fragments[] = {mssm_gl_shader(shadow), fragment, NULL};
    const GLuint depth = gl_program_simple("depth", gl_depth_vertex, NULL, why);
    const GLuint shading = gl_program("shading", vertices, fragments, why);
    if (!depth || !shading) return false;

    shadow_draw(shadow, &light, depth, &casters);

    gl_target_begin(&target);
    gl.Enable(GL_DEPTH_TEST);
    mssm_gl_bind(shadow);
    gl_camera_use(&eye, 0.1f, 30, shading);
    gl.ProgramUniform3fv(shading, gl.GetUniformLocation(shading, "to_light"), 1, to_light);
    gl_mesh_draw(&casters);
    const bool saved = gl_target_save(&target, 1.3f, argc > 1 ? argv[1] : "hello.png", why);
    mssm_gl_destroy(shadow); // the rest goes with the context
    return saved;
}

int main(int argc, char **argv)
{
    return gl_example_main(
        argc, argv, "gl_hello [PICTURE.png]: one area light, one caster, one soft shadow", run);
}
