#include "gl_lighting.h"

#include <stdlib.h>
#include <string.h>

// Texture units and buffers of ours; those of the headers come after them.
enum { POSITION_UNIT, NORMAL_UNIT, ALBEDO_UNIT, PROBE_UNIT, FIRST_FREE_UNIT };
enum { LIGHT_BUFFER, FIRST_FREE_BUFFER };

// ---- Shaders

// The buffer holds lightprobe_light as it stands in C: all its members are 4 bytes wide.
// clang-format off
static const char light_buffer[] =
    "struct Light {\n"
    "    float direction[3], axis_u[3], axis_v[3];\n"
    "    float tan_half_u, tan_half_v;\n"
    "    float irradiance[3];\n"
    "    float solid_angle, cos_alpha;\n"
    "    int id;\n"
    "    float distance, slope_u, slope_v, state[18];\n"
    "};\n"
    "layout(std430, binding = 0) readonly buffer Lights { Light light[]; };\n"
    "vec3 of(float v[3]) { return vec3(v[0], v[1], v[2]); }\n";
// clang-format on

static const char shading_lights[] =
    "uniform int first_light, light_count;\n"
    "uniform vec3 residual_sh[9];\n" // irradiance that the lights do not carry
    "uniform float little;\n"        // luminance of irradiance that is not worth a shadow
    // The next light whose share is worth a shadow. So a pixel goes on to its own next light, and
    // does not wait for neighbours that others shine on.
    "int next_light(int i, vec3 normal, out vec3 arriving)\n"
    "{\n"
    "    arriving = vec3(0);\n"
    "    for (; i < light_count; i++) {\n"
    "        Light l = light[first_light + i];\n"
    "        arriving = of(l.irradiance) *\n"
    "            lightprobe_disc_irradiance(l.cos_alpha, dot(normal, of(l.direction)));\n"
    "        if (dot(arriving, vec3(0.2126, 0.7152, 0.0722)) >= little) break;\n"
    "    }\n"
    "    return i;\n"
    "}\n"
    "vec3 irradiance_at(vec3 position, vec3 normal)\n"
    "{\n"
    "    vec3 sum = vec3(0), arriving;\n"
    "    for (int k = 0; k < 9; k++)\n"
    "        sum += residual_sh[k] * lightprobe_harmonic(k, normal.x, normal.y, normal.z);\n"
    "    sum = max(sum, vec3(0));\n"
    "    int i = next_light(0, normal, arriving);\n"
    // Tested at its end: a software rasterizer runs a loop once more where the test comes first.
    "    if (i < light_count) do {\n"
    "        sum += arriving * visibility_of(i, position, normal);\n"
    "        i = next_light(i + 1, normal, arriving);\n"
    "    } while (i < light_count);\n"
    "    return sum;\n"
    "}\n";

// A pixel is shaded once, unless an edge runs through it: samples on the same object that face
// about the same way are one piece of surface, as in view_surfaces() of raster.c.
static const char shading_main[] =
    "layout(binding = 0) uniform sampler2DMS position_map;\n"
    "layout(binding = 1) uniform sampler2DMS normal_map;\n"
    "layout(binding = 2) uniform sampler2DMS albedo_map;\n"
    "layout(binding = 3) uniform samplerCube probe;\n"
    "uniform float background;\n" // 0: the background has been drawn before
    "in vec3 ray;\n"
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    ivec2 pixel = ivec2(gl_FragCoord.xy);\n"
    "    vec3 sum = vec3(0);\n"
    "    float rest = 1;\n"
    "    int left = 0;\n"
    "    for (int s = 0; s < 4; s++) {\n"
    "        if (texelFetch(position_map, pixel, s).w != 0) left |= 1 << s;\n"
    "    }\n"
    "    while (left != 0) {\n"
    "        int first = findLSB(left);\n"
    "        vec3 normal = vec3(0), albedo = texelFetch(albedo_map, pixel, first).xyz;\n"
    "        float share = 0;\n"
    "        for (int s = first; s < 4; s++) {\n"
    "            if ((left >> s & 1) == 0) continue;\n"
    "            vec3 n = texelFetch(normal_map, pixel, s).xyz;\n"
    "            if (texelFetch(albedo_map, pixel, s).xyz != albedo) continue;\n"
    "            if (dot(normal, n) < 0.8 * length(normal)) continue;\n"
    "            normal += n;\n"
    "            share += 0.25;\n"
    "            left &= ~(1 << s);\n"
    "        }\n"
    "        left &= ~(1 << first);\n"
    "        vec3 position = texelFetch(position_map, pixel, first).xyz;\n"
    "        vec3 reflected = albedo * irradiance_at(position, normalize(normal));\n"
    "        sum += reflected * (share / 3.14159265);\n"
    "        rest -= share;\n"
    "    }\n"
    "    sum += rest * background * texture(probe, ray).rgb;\n"
    "    color = vec4(sum, 1);\n"
    "}\n";

GLuint gl_lighting_program(const char *name, const char *visibility, bool normals, message *why)
{
    const char *const call = normals ? "#define visibility_of mssm_visibility\n"
                                     : "#define visibility_of(i, p, n) mssm_visibility(i, p)\n";
    const char *const vertex[] = {gl_triangle_vertex, NULL};
    const char *const fragment[] = {lightprobe_glsl_math(), visibility,   call, light_buffer,
                                    shading_lights,         shading_main, NULL};
    return gl_program(name, vertex, fragment, why);
}

// ---- Making

static bool create_set(gl_shadow_set *set, const lighting *l, int side, mssm_gl_loader load,
                       message *why)
{
    const mssm_gl_desc desc = {.load = load,
                               .lights = 1,
                               .side = side,
                               .samples = l->settings.map_samples,
                               .moments = 6,
                               .settings = l->settings.shadows,
                               .first_texture_unit = FIRST_FREE_UNIT,
                               .first_buffer_binding = FIRST_FREE_BUFFER};
    const mssm_result result = mssm_gl_create(&set->maps, &desc);
    if (result != MSSM_OK) return fail(why, "shadow maps: %s", mssm_result_string(result));
    set->side = side;
    set->room = 1;
    set->light = malloc((size_t)l->settings.probe.max_lights * sizeof *set->light);
    return set->light || fail(why, "no memory for lights");
}

static bool create_all(gl_lighting *g, const lighting *l, mssm_gl_loader load, int width,
                       int height, message *why)
{
    const size_t bytes = (size_t)l->settings.probe.max_lights * sizeof *g->ordered;
    g->ordered = malloc(bytes);
    if (!g->ordered) return fail(why, "no memory for lights");
    gl.CreateBuffers(1, &g->lights);
    gl.NamedBufferStorage(g->lights, (GLsizeiptr)bytes, NULL, GL_DYNAMIC_STORAGE_BIT);
    gl_mesh_triangle(&g->triangle);
    for (int i = 0; i < GL_LIGHTING_SETS; i++) {
        if (!create_set(&g->set[i], l, l->settings.map_side << i, load, why)) return false;
    }
    g->depth_program = gl_program_simple("casters", gl_depth_vertex, NULL, why);
    g->view_program = gl_program_simple("view", gl_scene_vertex, gl_scene_fragment, why);
    // The text is the same for both sets: how large the maps are is read from a buffer.
    g->program = gl_lighting_program("shading", mssm_gl_shader(g->set[0].maps), true, why);
    return g->depth_program && g->view_program && g->program &&
           gl_lighting_resize(g, width, height, why);
}

bool gl_lighting_resize(gl_lighting *g, int width, int height, message *why)
{
    const GLenum samples[GL_TARGET_COLORS] = {GL_RGBA32F, GL_RGBA16F, GL_RGBA16F};
    const GLenum picture[GL_TARGET_COLORS] = {GL_RGBA32F};
    gl_target_free(&g->view);
    gl_target_free(&g->picture);
    return gl_target_create(&g->view, width, height, VIEW_SAMPLES, samples, why) &&
           gl_target_create(&g->picture, width, height, 1, picture, why);
}

bool gl_lighting_create(gl_lighting *g, const lighting *l, mssm_gl_loader load, int width,
                        int height, message *why)
{
    memset(g, 0, sizeof *g);
    g->size = 1;
    if (create_all(g, l, load, width, height, why)) return true;
    gl_lighting_free(g);
    return false;
}

void gl_lighting_free(gl_lighting *g)
{
    if (!g->ordered) return; // nothing was made: there may be no context
    for (int i = 0; i < GL_LIGHTING_SETS; i++) {
        mssm_gl_destroy(g->set[i].maps);
        free(g->set[i].light);
    }
    gl_mesh_free(&g->casters);
    gl_mesh_free(&g->triangle);
    gl_target_free(&g->view);
    gl_target_free(&g->picture);
    if (g->depth_program) gl.DeleteProgram(g->depth_program);
    if (g->view_program) gl.DeleteProgram(g->view_program);
    if (g->program) gl.DeleteProgram(g->program);
    if (g->lights) gl.DeleteBuffers(1, &g->lights);
    if (g->probe) gl.DeleteTextures(1, &g->probe);
    gl_timer_free(&g->timer);
    free(g->ordered);
    memset(g, 0, sizeof *g);
}

// ---- Maps

// Puts every light into the set with maps of its size, and the lights into the buffer set by set.
static bool sort_lights(gl_lighting *g, const lighting *l, message *why)
{
    int count = 0;
    for (int i = 0; i < GL_LIGHTING_SETS; i++) {
        gl_shadow_set *set = &g->set[i];
        set->lights = 0;
        for (int k = 0; k < l->lights; k++) {
            if (lighting_map_side(l, k) != set->side) continue;
            set->light[set->lights++] = k;
            g->ordered[count++] = l->light[k];
        }
        if (set->lights <= set->room) continue;
        const mssm_result result = mssm_gl_resize(set->maps, set->lights, set->side);
        if (result != MSSM_OK) return fail(why, "shadow maps: %s", mssm_result_string(result));
        set->room = set->lights;
    }
    gl.NamedBufferSubData(g->lights, 0, (GLsizeiptr)((size_t)count * sizeof *g->ordered),
                          g->ordered);
    return true;
}

static mssm_result draw_map(const gl_lighting *g, const gl_shadow_set *set, int map,
                            const lighting *l, const scene *s)
{
    const lightprobe_light *light = &l->light[set->light[map]];
    const int passes = l->settings.back_faces ? 2 : 1;
    const float low[3] = {s->low.x, s->low.y, s->low.z},
                high[3] = {s->high.x, s->high.y, s->high.z};
    mssm_light frustum;
    mssm_result r =
        mssm_light_directional(&frustum, light->direction, light->axis_u,
                               g->size * light->tan_half_u, g->size * light->tan_half_v, low, high);
    if (r == MSSM_OK) r = mssm_gl_set_light(set->maps, map, &frustum);
    for (int back = 0; back < passes && r == MSSM_OK; back++) {
        r = mssm_gl_begin_depth(set->maps, map, back);
        if (r != MSSM_OK) break;
        gl.UseProgram(g->depth_program);
        gl.ProgramUniformMatrix4fv(g->depth_program, 0, 1, GL_FALSE, frustum.world_to_shadow);
        gl_mesh_draw(&g->casters);
        r = mssm_gl_end_depth(set->maps);
    }
    return r;
}

bool gl_lighting_draw_maps(gl_lighting *g, const lighting *l, const scene *s, message *why)
{
    mssm_result result = MSSM_OK;
    gl_timer_start(&g->timer);
    if (!gl_mesh_upload(&g->casters, s, why) || !sort_lights(g, l, why)) return false;
    for (int i = 0; i < GL_LIGHTING_SETS; i++) {
        const gl_shadow_set *set = &g->set[i];
        for (int k = 0; k < set->lights && result == MSSM_OK; k++) {
            result = draw_map(g, set, k, l, s);
        }
    }
    gl_timer_mark(&g->timer);
    for (int i = 0; i < GL_LIGHTING_SETS && result == MSSM_OK; i++) {
        result = mssm_gl_build(g->set[i].maps);
    }
    gl_timer_mark(&g->timer);
    return result == MSSM_OK || fail(why, "shadow maps: %s", mssm_result_string(result));
}

// ---- View and shading

void gl_lighting_draw_view(gl_lighting *g, const scene *s, const camera *eye)
{
    const vec3 centre = vec_scale(vec_add(s->low, s->high), 0.5f);
    const float radius = 0.5f * vec_length(vec_sub(s->high, s->low));
    float world_to_clip[16];
    gl_camera_matrix(eye, 0.02f, vec_length(vec_sub(centre, eye->position)) + radius,
                     world_to_clip);
    gl_target_begin(&g->view);
    gl.UseProgram(g->view_program);
    gl.ProgramUniformMatrix4fv(g->view_program, 0, 1, GL_FALSE, world_to_clip);
    gl.Enable(GL_DEPTH_TEST);
    gl.Enable(GL_CULL_FACE);
    gl_mesh_draw(&g->casters);
    gl.Disable(GL_CULL_FACE);
    gl.Disable(GL_DEPTH_TEST);
    gl_timer_mark(&g->timer);
}

void gl_lighting_pass(gl_lighting *g, GLuint program, const lighting *l, const camera *eye,
                      int first, int count, unsigned flags)
{
    const bool base = flags & GL_LIGHTING_BASE, add = flags & GL_LIGHTING_ADD;
    static const float nothing[9][3];
    const float little = 2e-5f * vec_luminance(vec_of(l->stats.total));
    gl.ProgramUniform1i(program, gl.GetUniformLocation(program, "first_light"), first);
    gl.ProgramUniform1i(program, gl.GetUniformLocation(program, "light_count"), count);
    gl.ProgramUniform3fv(program, gl.GetUniformLocation(program, "residual_sh"), 9,
                         base ? l->stats.residual_sh[0] : nothing[0]);
    gl.ProgramUniform1f(program, gl.GetUniformLocation(program, "little"), little);
    gl.ProgramUniform1f(program, gl.GetUniformLocation(program, "background"), base ? 1 : 0);
    gl_camera_uniforms(eye, program);
    for (GLuint i = 0; i < GL_TARGET_COLORS; i++) gl.BindTextureUnit(i, g->view.color[i]);
    gl.BindTextureUnit(PROBE_UNIT, g->probe);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, LIGHT_BUFFER, g->lights);
    gl.UseProgram(program);
    if (add) gl.Enable(GL_BLEND);
    gl.BlendFunc(GL_ONE, GL_ONE);
    gl_mesh_draw(&g->triangle);
    gl.Disable(GL_BLEND);
}

void gl_lighting_shade(gl_lighting *g, GLuint program, const lighting *l, const camera *eye)
{
    int first = 0;
    for (int i = 0; i < GL_LIGHTING_SETS; i++) {
        const gl_shadow_set *set = &g->set[i];
        if (i > 0 && set->lights == 0) continue;
        mssm_gl_bind(set->maps);
        gl_lighting_pass(g, program ? program : g->program, l, eye, first, set->lights,
                         i > 0 ? GL_LIGHTING_ADD : GL_LIGHTING_BASE);
        first += set->lights;
    }
    gl_timer_mark(&g->timer);
}

double gl_lighting_seconds(const gl_lighting *g, int step)
{
    return gl_timer_seconds(&g->timer, step);
}
