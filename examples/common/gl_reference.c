#include "gl_reference.h"

#include <stdio.h>

// Lights go to the GPU in slots, a fresh one for each call of gl_reference_draw: Mesa's llvmpipe
// (22.3) lets NamedBufferSubData overtake draws that are queued and still read the old contents, so
// that sums of many points differed from run to run.
enum { DEPTH_UNIT = 4, LIGHT_BINDING = 1, SLOTS = 32, OFFSET_ALIGNMENT = 256 };

// As the shaders see a light: std430.
typedef struct reference_light {
    float world_to_shadow[16];
    float kernel[2]; // half-width of the penumbra in texture coordinates per unit of depth
    float bias;      // of depth
    float frame;
} reference_light;

static GLsizeiptr slot_bytes(const gl_reference *r)
{
    const GLsizeiptr bytes = r->room * (GLsizeiptr)sizeof(reference_light);
    return (bytes + OFFSET_ALIGNMENT - 1) / OFFSET_ALIGNMENT * OFFSET_ALIGNMENT;
}

const char gl_reference_text[] =
    "layout(binding = 4) uniform sampler2DArray depth_maps;\n"
    "struct Reference { mat4 world_to_shadow; vec4 kernel; };\n"
    "layout(std430, binding = 1) readonly buffer References { Reference reference[]; };\n"
    "vec3 shadow_place(int light, vec3 position)\n"
    "{\n"
    "    vec4 p = reference[light].world_to_shadow * vec4(position, 1);\n"
    "    return vec3(0.5 * p.xy + 0.5, p.z);\n"
    "}\n";

static const char test_text[] = "float map_depth(int light, vec2 at)\n" // the nearest texel
                                "{\n"
                                "    return 2 * textureLod(depth_maps, vec3(at, light), 0).r - 1;\n"
                                "}\n";

static const char hard_text[] =
    "float mssm_visibility(int light, vec3 position)\n"
    "{\n"
    "    vec3 p = shadow_place(light, position);\n"
    "    return map_depth(light, p.xy) < min(p.z - reference[light].kernel.z, 1) ? 0 : 1;\n"
    "}\n";

// What does not change from tap to tap stands outside of the loops.
static const char pcss_text[] =
    "float mssm_visibility(int light, vec3 position)\n"
    "{\n"
    "    vec3 p = shadow_place(light, position);\n"
    "    vec3 kernel = reference[light].kernel.xyz;\n"
    "    vec2 least = 0.5 / textureSize(depth_maps, 0).xy;\n"
    "    float z = min(p.z - kernel.z, 1), sum = 0, blockers = 0, lit = 0;\n"
    "    vec2 tap = max(kernel.xy * (p.z + 1), least) * (2.0 / TAPS), at;\n"
    "    vec2 first = p.xy - 0.5 * (TAPS - 1) * tap;\n"
    "    at.y = first.y;\n"
    "    for (int j = 0; j < TAPS; j++, at.y += tap.y) {\n"
    "        at.x = first.x;\n"
    "        for (int i = 0; i < TAPS; i++, at.x += tap.x) {\n"
    "            float d = map_depth(light, at);\n"
    "            if (d < z) { sum += d; blockers++; }\n"
    "        }\n"
    "    }\n"
    "    if (blockers == 0) return 1;\n"
    "    if (blockers == TAPS * TAPS) return 0;\n"
    "    tap = max(kernel.xy * (p.z - sum / blockers), least) * (2.0 / TAPS);\n"
    "    first = p.xy - 0.5 * (TAPS - 1) * tap;\n"
    "    at.y = first.y;\n"
    "    for (int j = 0; j < TAPS; j++, at.y += tap.y) {\n"
    "        at.x = first.x;\n"
    "        for (int i = 0; i < TAPS; i++, at.x += tap.x) {\n"
    "            if (map_depth(light, at) >= z) lit++;\n"
    "        }\n"
    "    }\n"
    "    return lit / (TAPS * TAPS);\n"
    "}\n";

void gl_reference_visibility(gl_reference_kind kind, char *text, size_t room)
{
    snprintf(text, room, "#define TAPS %d\n%s%s%s", GL_REFERENCE_TAPS, gl_reference_text, test_text,
             kind == GL_REFERENCE_PCSS ? pcss_text : hard_text);
}

bool gl_reference_create(gl_reference *r, int side, int lights, message *why)
{
    static const float beside[4] = {1, 1, 1, 1};
    char text[GL_REFERENCE_TEXT];
    *r = (gl_reference){.bias = 4, .side = side, .room = lights};
    gl.CreateTextures(GL_TEXTURE_2D_ARRAY, 1, &r->depth);
    gl.TextureStorage3D(r->depth, 1, GL_DEPTH_COMPONENT32F, side, side, lights);
    gl.TextureParameteri(r->depth, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TextureParameteri(r->depth, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl.TextureParameteri(r->depth, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
    gl.TextureParameteri(r->depth, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
    gl.TextureParameterfv(r->depth, GL_TEXTURE_BORDER_COLOR, beside);
    gl.CreateFramebuffers(1, &r->framebuffer);
    gl.CreateBuffers(1, &r->lights);
    gl.NamedBufferStorage(r->lights, SLOTS * slot_bytes(r), NULL, GL_DYNAMIC_STORAGE_BIT);
    for (int i = 0; i < 2; i++) {
        gl_reference_visibility(i == GL_REFERENCE_HARD ? GL_REFERENCE_HARD : GL_REFERENCE_PCSS,
                                text, sizeof text);
        r->program[i] =
            gl_lighting_program(i == GL_REFERENCE_HARD ? "hard" : "PCSS", text, false, why);
        if (r->program[i]) continue;
        gl_reference_free(r);
        return false;
    }
    return true;
}

void gl_reference_free(gl_reference *r)
{
    if (r->depth) gl.DeleteTextures(1, &r->depth);
    if (r->framebuffer) gl.DeleteFramebuffers(1, &r->framebuffer);
    if (r->lights) gl.DeleteBuffers(1, &r->lights);
    for (int i = 0; i < 2; i++) {
        if (r->program[i]) gl.DeleteProgram(r->program[i]);
    }
    *r = (gl_reference){0};
}

// The index-th of points that fill the square [-1,1]^2 evenly (Roberts' R2 sequence).
static void spread(int index, int light, float *x, float *y)
{
    const double i = index + 1, shift = 0.618034 * light;
    *x = (float)(2 * fmod(0.7548776662 * i + shift, 1) - 1);
    *y = (float)(2 * fmod(0.5698402910 * i + shift, 1) - 1);
}

static mssm_light light_frustum(const lightprobe_light *l, float size, const scene *s, float x,
                                float y)
{
    const float low[3] = {s->low.x, s->low.y, s->low.z};
    const float high[3] = {s->high.x, s->high.y, s->high.z};
    float direction[3];
    mssm_light f = {{0}, 0, 0, 0, 1, 1, -1, 1};
    for (int k = 0; k < 3; k++) {
        direction[k] = l->direction[k] +
                       size * (x * l->tan_half_u * l->axis_u[k] + y * l->tan_half_v * l->axis_v[k]);
    }
    mssm_light_directional(&f, direction, l->axis_u, size * l->tan_half_u, size * l->tan_half_v,
                           low, high);
    return f;
}

void gl_reference_draw(gl_reference *r, const gl_lighting *g, int lights, const scene *s,
                       gl_reference_kind kind, int index)
{
    r->slot = (r->slot + 1) % SLOTS;
    if (r->slot == 0) gl.Finish(); // all slots are used again from here on
    gl.BindFramebuffer(GL_FRAMEBUFFER, r->framebuffer);
    gl.NamedFramebufferDrawBuffers(r->framebuffer, 0, NULL);
    gl.Viewport(0, 0, r->side, r->side);
    gl.Enable(GL_DEPTH_TEST);
    gl.UseProgram(g->depth_program);
    for (int i = 0; i < lights && i < r->room; i++) {
        float x = 0, y = 0;
        if (kind == GL_REFERENCE_TRUTH) spread(index, i, &x, &y);
        const mssm_light f = light_frustum(&g->ordered[i], g->size, s, x, y);
        const float range = 0.5f * (f.z_far - f.z_near), scale = 0.5f * range;
        const float extent = f.extent_u > f.extent_v ? f.extent_u : f.extent_v;
        const float texel = 2 * extent / ((float)r->side * range); // its width in units of depth
        reference_light l = {{0},
                             {scale * f.half_u / f.extent_u, scale * f.half_v / f.extent_v},
                             r->bias * texel,
                             (float)r->frame};
        for (int k = 0; k < 16; k++) l.world_to_shadow[k] = f.world_to_shadow[k];
        gl.NamedBufferSubData(r->lights, r->slot * slot_bytes(r) + i * (GLintptr)sizeof l, sizeof l,
                              &l);
        gl.NamedFramebufferTextureLayer(r->framebuffer, GL_DEPTH_ATTACHMENT, r->depth, 0, i);
        gl.Clear(GL_DEPTH_BUFFER_BIT);
        gl.ProgramUniformMatrix4fv(g->depth_program, 0, 1, GL_FALSE, f.world_to_shadow);
        gl_mesh_draw(&g->casters);
    }
    gl.Disable(GL_DEPTH_TEST);
}

void gl_reference_bind(const gl_reference *r)
{
    gl.BindTextureUnit(DEPTH_UNIT, r->depth);
    gl.BindBufferRange(GL_SHADER_STORAGE_BUFFER, LIGHT_BINDING, r->lights, r->slot * slot_bytes(r),
                       slot_bytes(r));
}

void gl_reference_shade(gl_reference *r, gl_lighting *g, const lighting *l, const camera *eye,
                        gl_reference_kind kind, bool add)
{
    const int lights = l->lights < r->room ? l->lights : r->room;
    gl_reference_bind(r);
    gl_lighting_pass(g, r->program[kind == GL_REFERENCE_PCSS], l, eye, 0, lights,
                     GL_LIGHTING_BASE | (add ? GL_LIGHTING_ADD : 0));
}
