#include "gl_room.h"

#include "gl_context.h"
#include "probe.h"

#include <string.h>

enum { LAMP, SKY, SUN, LIGHTS };

// Behind mssm_gl_shader().
static const char walls_fragment[] =
    "layout(location = 1) uniform vec3 centre;\n"
    "layout(location = 2) uniform vec3 lamp;\n"
    "layout(location = 3) uniform vec3 to_sun;\n"
    "layout(location = 4) uniform vec3 door[4];\n"     // corners
    "layout(location = 8) uniform vec3 strength[4];\n" // lamp, sky, sun, ambient
    "layout(location = 12) uniform float lamp_area;\n" // of its outline
    "layout(location = 13) uniform int emits;\n"       // then albedo is radiance
    "in vec3 position, normal, albedo;\n"
    "out vec4 color;\n"
    // Of a rectangle above the horizon, times its radiance (Lambert).
    "float rectangle_irradiance(vec3 p, vec3 n)\n"
    "{\n"
    "    float sum = 0;\n"
    "    for (int i = 0; i < 4; i++) {\n"
    "        vec3 a = normalize(door[i] - p), b = normalize(door[(i + 1) % 4] - p);\n"
    "        vec3 across = cross(a, b);\n"
    "        sum += acos(clamp(dot(a, b), -1, 1)) * dot(across, n) / max(length(across), 1e-6);\n"
    "    }\n"
    "    return 0.5 * max(sum, 0);\n"
    "}\n"
    "void main()\n"
    "{\n"
    "    vec3 n = normalize(normal), sum = strength[3], to_lamp = lamp - position;\n"
    "    float away = length(to_lamp), share[3];\n"
    "    share[0] = lamp_area * max(dot(n, to_lamp), 0) / (away * away * away);\n"
    "    share[1] = rectangle_irradiance(position, n);\n"
    "    share[2] = max(dot(n, to_sun), 0);\n"
    "    for (int i = 0; i < 3; i++)\n"
    "        if (emits == 0 && share[i] > 0)\n"
    "            sum += strength[i] * (share[i] * mssm_visibility(i, position, n));\n"
    "    color = vec4(emits == 0 ? albedo * sum / 3.14159265 : albedo, distance(position, "
    "centre));\n"
    "}\n";

bool gl_room_create(gl_room *g, int side, message *why)
{
    const mssm_gl_desc desc = {.load = gl_context_function, .lights = LIGHTS, .side = 512};
    const GLenum formats[GL_TARGET_COLORS] = {GL_RGBA32F};
    memset(g, 0, sizeof *g);
    if (mssm_gl_create(&g->shadows, &desc)) return fail(why, "no shadow maps");
    const char *const vertex[] = {gl_scene_vertex, NULL};
    const char *const texts[] = {mssm_gl_shader(g->shadows), walls_fragment, NULL};
    gl.CreateTextures(GL_TEXTURE_CUBE_MAP, 1, &g->cube);
    gl.TextureStorage2D(g->cube, 2, GL_RGBA32F, 2 * side, 2 * side);
    gl.CreateFramebuffers(1, &g->cube_target);
    return (g->depth = gl_program_simple("room's depth", gl_depth_vertex, NULL, why)) &&
           (g->program = gl_program("walls", vertex, texts, why)) &&
           gl_target_create(&g->face, 2 * side, 2 * side, 4, formats, why);
}

void gl_room_free(gl_room *g)
{
    mssm_gl_destroy(g->shadows);
    if (g->depth) gl.DeleteProgram(g->depth);
    if (g->program) gl.DeleteProgram(g->program);
    if (g->cube) gl.DeleteTextures(1, &g->cube);
    if (g->cube_target) gl.DeleteFramebuffers(1, &g->cube_target);
    gl_target_free(&g->face);
    gl_mesh_free(&g->mesh);
    memset(g, 0, sizeof *g);
}

// ---- Lights

static void floats(vec3 v, float out[3])
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

// An emitter of these half-sizes across the way from the things to it.
static mssm_result light_at(mssm_light *light, const room *r, vec3 place, float half_z,
                            float half_y)
{
    const vec3 way = vec_sub(place, room_centre);
    const float distance = vec_length(way), axis[3] = {0, 0, 1};
    float from[3], to[3], low[3], high[3];
    floats(room_centre, from);
    floats(way, to);
    floats(r->low, low);
    floats(r->high, high);
    return mssm_light_area(light, from, to, axis, half_z / distance, half_y / distance, distance,
                           low, high);
}

// The door's rectangle, as the things see it: foreshortened.
static mssm_result sky_light(mssm_light *light, const room *r)
{
    const vec3 middle = vec(room_high.x, 0.5f * ROOM_DOOR_HEIGHT, ROOM_DOOR_FROM + 0.5f * r->door);
    const vec3 way = vec_unit(vec_sub(middle, room_centre));
    return light_at(light, r, middle, 0.5f * r->door * sqrtf(1 - way.z * way.z),
                    0.5f * ROOM_DOOR_HEIGHT * sqrtf(1 - way.y * way.y));
}

static bool make_lights(const room *r, mssm_light light[LIGHTS])
{
    const float square = 0.8660254f * ROOM_LAMP_RADIUS; // as wide as a disc by its variance
    float to[3], low[3], high[3], axis[3] = {0, 0, 1};
    floats(room_to_sun, to);
    floats(room_wall_low, low);
    floats(room_wall_high, high);
    return !light_at(&light[LAMP], r, r->lamp, square, square) && !sky_light(&light[SKY], r) &&
           !mssm_light_directional(&light[SUN], to, axis, ROOM_SUN_TANGENT, ROOM_SUN_TANGENT, low,
                                   high);
}

static void draw_triangles(const gl_mesh *m, int from, int to)
{
    gl.BindVertexArray(m->array);
    gl.DrawElements(GL_TRIANGLES, 3 * (to - from), GL_UNSIGNED_INT,
                    (const void *)(3 * sizeof(GLuint) * (uintptr_t)from));
}

static void set_uniforms(gl_room *g, const room *r)
{
    const float x = room_high.x, z0 = ROOM_DOOR_FROM, z1 = z0 + r->door, high = ROOM_DOOR_HEIGHT;
    const vec3 v[] = {
        room_centre,   r->lamp,    room_to_sun,        {x, 0, z0},        {x, high, z0},
        {x, high, z1}, {x, 0, z1}, room_lamp_radiance, room_sky_radiance, room_sun_irradiance,
        room_ambient};
    const float area = VEC_PI * ROOM_LAMP_RADIUS * ROOM_LAMP_RADIUS;
    for (GLint i = 0; i < 3; i++) gl.ProgramUniform3fv(g->program, 1 + i, 1, &v[i].x);
    gl.ProgramUniform3fv(g->program, 4, 4, &v[3].x);
    gl.ProgramUniform3fv(g->program, 8, 4, &v[7].x);
    gl.ProgramUniform1f(g->program, 12, area);
}

bool gl_room_set(gl_room *g, const room *r, message *why)
{
    mssm_light light[LIGHTS];
    if (!gl_mesh_upload(&g->mesh, &r->all, why)) return false;
    if (!make_lights(r, light)) return fail(why, "no lights for the walls");
    g->things = r->things;
    g->sun_casters = r->sun_casters;
    g->walls = r->walls;
    set_uniforms(g, r);
    for (int i = 0; i < LIGHTS; i++) {
        mssm_gl_set_light(g->shadows, i, &light[i]);
        mssm_gl_begin_depth(g->shadows, i, 0);
        gl.UseProgram(g->depth);
        gl.ProgramUniformMatrix4fv(g->depth, 0, 1, GL_FALSE, light[i].world_to_shadow);
        draw_triangles(&g->mesh, 0, i == SUN ? g->sun_casters : g->things);
        mssm_gl_end_depth(g->shadows);
    }
    return !mssm_gl_build(g->shadows) || fail(why, "no shadow maps");
}

// ---- Drawing

void gl_room_draw_walls(gl_room *g, const camera *eye)
{
    mssm_gl_bind(g->shadows);
    gl_camera_use(eye, 0.05f, 10, g->program);
    gl.ProgramUniform1i(g->program, 13, 0);
    draw_triangles(&g->mesh, g->things, g->walls);
    gl.ProgramUniform1i(g->program, 13, 1);
    draw_triangles(&g->mesh, g->walls, g->mesh.count / 3);
}

gl_mesh gl_room_things(const gl_room *g)
{
    gl_mesh m = g->mesh;
    m.count = 3 * g->things;
    return m;
}

// Columns and rows of a face in OpenGL's order, the first row at the bottom of what is drawn.
static camera face_camera(int face)
{
    const vec3 ahead = probe_direction(face, 0, 0);
    return (camera){room_centre,
                    vec_sub(probe_direction(face, 1, 0), ahead),
                    vec_sub(probe_direction(face, 0, 1), ahead),
                    vec_scale(ahead, -1),
                    1,
                    1};
}

void gl_room_draw_cube(gl_room *g)
{
    const int side = g->face.width;
    gl.Enable(GL_DEPTH_TEST);
    for (int i = 0; i < 6; i++) {
        const camera eye = face_camera(i);
        gl_target_begin(&g->face);
        gl_room_draw_walls(g, &eye);
        gl.NamedFramebufferTextureLayer(g->cube_target, GL_COLOR_ATTACHMENT0, g->cube, 0, i);
        gl.BlitNamedFramebuffer(g->face.framebuffer, g->cube_target, 0, 0, side, side, 0, 0, side,
                                side, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    }
    gl.GenerateTextureMipmap(g->cube);
    gl.Disable(GL_DEPTH_TEST);
}
