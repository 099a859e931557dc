#include "median_cut.h"

#include <stdio.h>
#include <string.h>

// Regions are (face, x0 | x1 << 16, y0 | y1 << 16, luminance).
static const char tables_text[] =
    "layout(binding = 0) uniform sampler2DArray colours;\n"
    "layout(binding = 1) uniform sampler2DArray moments;\n"
    "layout(std430, binding = 0) buffer Regions { uint count; uvec4 regions[256]; };\n"
    "vec4 part(sampler2DArray t, int face, int x, int y)\n"
    "{\n"
    "    return x < 0 || y < 0 ? vec4(0) : texelFetch(t, ivec3(x, y, face), 0);\n"
    "}\n"
    "vec4 sum_of(sampler2DArray t, int face, ivec2 x, ivec2 y)\n"
    "{\n"
    "    return part(t, face, x.y - 1, y.y - 1) + part(t, face, x.x - 1, y.x - 1) -\n"
    "        part(t, face, x.y - 1, y.x - 1) - part(t, face, x.x - 1, y.y - 1);\n"
    "}\n";

static const char rows_text[] =
    "layout(local_size_x = 32) in;\n"
    "layout(binding = 0) uniform sampler2DArray probe;\n"
    "layout(binding = 0, rgba32f) writeonly uniform image2DArray colours;\n"
    "layout(binding = 1, rgba32f) writeonly uniform image2DArray moments;\n"
    "const mat3 xyz = mat3(0.4124, 0.2126, 0.0193, 0.3576, 0.7152, 0.1192, 0.1805, 0.0722, "
    "0.9505);\n"
    "void main()\n"
    "{\n"
    "    ivec3 p = ivec3(0, gl_GlobalInvocationID.xy);\n"
    "    int side = textureSize(probe, 0).x;\n"
    "    float step = 2.0 / side, v = step * (p.y + 0.5) - 1;\n"
    "    vec4 colour = vec4(0), moment = vec4(0);\n"
    "    for (; p.x < side; p.x++) {\n"
    "        float u = step * (p.x + 0.5) - 1, r2 = 1 + u * u + v * v;\n"
    "        vec3 c = xyz * (texelFetch(probe, p, 0).rgb * (step * step / (r2 * sqrt(r2))));\n"
    "        colour.rgb += c;\n"
    "        moment += c.y * vec4(u, v, u * u, v * v);\n"
    "        imageStore(colours, p, colour);\n"
    "        imageStore(moments, p, moment);\n"
    "    }\n"
    "}\n";

static const char columns_text[] =
    "layout(local_size_x = 32) in;\n"
    "layout(binding = 0, rgba32f) uniform image2DArray colours;\n"
    "layout(binding = 1, rgba32f) uniform image2DArray moments;\n"
    "void main()\n"
    "{\n"
    "    ivec3 p = ivec3(gl_GlobalInvocationID.x, 0, gl_GlobalInvocationID.y);\n"
    "    int side = imageSize(colours).y;\n"
    "    vec4 colour = vec4(0), moment = vec4(0);\n"
    "    for (; p.y < side; p.y++) {\n"
    "        imageStore(colours, p, colour += imageLoad(colours, p));\n"
    "        imageStore(moments, p, moment += imageLoad(moments, p));\n"
    "    }\n"
    "}\n";

// Each thread splits one region a round, which makes no more than 256; a bitonic sorter moves the
// empty ones to the end and the brightest to the front.
static const char cuts_text[] =
    "layout(local_size_x = 256) in;\n"
    "uniform int most;\n"
    "shared uvec4 list[256];\n"
    "shared float key[256];\n"
    "shared int filled;\n"
    "float luminance(uvec4 r)\n"
    "{\n"
    "    return sum_of(colours, int(r.x), ivec2(r.y & 0xffffu, r.y >> 16), ivec2(r.z & 0xffffu, "
    "r.z >> 16)).y;\n"
    "}\n"
    "void set(int i, uvec4 r)\n"
    "{\n"
    "    list[i] = r;\n"
    "    key[i] = luminance(r);\n"
    "}\n"
    "float part_of(uvec4 r, ivec2 x, ivec2 y, bool wide, int at)\n"
    "{\n"
    "    return sum_of(colours, int(r.x), wide ? ivec2(x.x, at) : x, wide ? y : ivec2(y.x, "
    "at)).y;\n"
    "}\n"
    "bool split(int from, int to)\n"
    "{\n"
    "    uvec4 a = list[from];\n"
    "    ivec2 x = ivec2(a.y & 0xffffu, a.y >> 16), y = ivec2(a.z & 0xffffu, a.z >> 16);\n"
    "    bool wide = x.y - x.x >= y.y - y.x;\n"
    "    int start = wide ? x.x : y.x, end = wide ? x.y : y.y, low = start + 1, high = end - 1;\n"
    "    if (end - start < 2) return false;\n"
    "    float goal = 0.5 * key[from];\n"
    "    while (low < high) {\n"
    "        int middle = (low + high) / 2;\n"
    "        if (part_of(a, x, y, wide, middle) < goal) low = middle + 1; else high = middle;\n"
    "    }\n"
    "    if (low > start + 1 && goal - part_of(a, x, y, wide, low - 1) <= part_of(a, x, y, wide, "
    "low) - goal) low--;\n"
    "    uint first = uint(start | low << 16), second = uint(low | end << 16);\n"
    "    set(from, uvec4(a.x, wide ? first : a.y, wide ? a.z : first, 0));\n"
    "    set(to, uvec4(a.x, wide ? second : a.y, wide ? a.z : second, 0));\n"
    "    return true;\n"
    "}\n"
    "void sort(int lane)\n"
    "{\n"
    "    for (int k = 2; k <= 256; k *= 2) {\n"
    "        for (int j = k / 2; j > 0; j /= 2) {\n"
    "            barrier();\n"
    "            if (lane >= 128) continue;\n"
    "            int a = 2 * lane - (lane & (j - 1)), b = a + j;\n"
    "            bool down = (a & k) == 0;\n"
    "            float one = key[a], other = key[b];\n"
    "            if (down ? one < other : one > other) {\n"
    "                key[a] = other;\n"
    "                key[b] = one;\n"
    "                uvec4 r = list[a];\n"
    "                list[a] = list[b];\n"
    "                list[b] = r;\n"
    "            }\n"
    "        }\n"
    "    }\n"
    "    barrier();\n"
    "}\n"
    "void main()\n"
    "{\n"
    "    int lane = int(gl_LocalInvocationIndex), side = textureSize(colours, 0).x;\n"
    "    key[lane] = -1;\n"
    "    barrier();\n"
    "    if (lane < 6) set(lane, uvec4(lane, side << 16, side << 16, 0));\n"
    "    int n = 6;\n"
    "    sort(lane);\n"
    "    for (int round = 0; round < 64 && n < most; round++) {\n"
    "        int todo = min(n, most - n);\n"
    "        if (lane == 0) filled = n;\n"
    "        barrier();\n"
    "        if (lane < todo && split(lane, n + lane)) atomicAdd(filled, 1);\n"
    "        barrier();\n"
    "        int now = filled;\n"
    "        sort(lane);\n"
    "        if (now == n) break;\n"
    "        n = now;\n"
    "    }\n"
    "    if (lane == 0) count = n;\n"
    "    if (lane < n) regions[lane] = list[lane];\n"
    "}\n";

// A record of its own, not the header's struct, which may grow: gl_median_cut_read() takes it apart.
typedef struct record {
    float direction[3], tan_half_u, axis_u[3], tan_half_v, axis_v[3], cos_alpha, irradiance[4];
} record;

static const char lights_text[] =
    "layout(local_size_x = 64) in;\n"
    "struct Light { vec4 direction, axis_u, axis_v, irradiance; };\n"
    "layout(std430, binding = 1) writeonly buffer Lights { Light lights[]; };\n"
    "vec3 world(uint face, float s, float t, float m)\n"
    "{\n"
    "    if (face == 0) return vec3(m, -t, -s);\n"
    "    if (face == 1) return vec3(-m, -t, s);\n"
    "    if (face == 2) return vec3(s, m, t);\n"
    "    if (face == 3) return vec3(s, -m, -t);\n"
    "    if (face == 4) return vec3(s, -t, m);\n"
    "    return vec3(-s, -t, -m);\n"
    "}\n"
    "const mat3 rgb = mat3(3.2406, -0.9689, 0.0557, -1.5372, 1.8758, -0.2040, -0.4986, 0.0415, "
    "1.0570);\n"
    "void main()\n"
    "{\n"
    "    int i = int(gl_GlobalInvocationID.x);\n"
    "    if (i >= int(count)) return;\n"
    "    uvec4 r = regions[i];\n"
    "    ivec2 x = ivec2(r.y & 0xffffu, r.y >> 16), y = ivec2(r.z & 0xffffu, r.z >> 16);\n"
    "    vec3 c = sum_of(colours, int(r.x), x, y).rgb;\n"
    "    vec4 m = sum_of(moments, int(r.x), x, y) / (c.y > 0 ? c.y : 1);\n"
    "    vec2 size = sqrt(3 * max(m.zw - m.xy * m.xy, 0));\n"
    "    float distance = length(vec3(m.xy, 1));\n"
    "    vec3 d = world(r.x, m.x, m.y, 1) / distance, u = world(r.x, 1, 0, 0), v = world(r.x, 0, "
    "1, 0);\n"
    "    u -= dot(u, d) * d;\n"
    "    v -= dot(v, d) * d;\n"
    "    size *= vec2(length(u), length(v)) / distance;\n"
    "    float cos_alpha = max(1 - 4 * size.x * size.y / 6.2831853, -1);\n"
    "    lights[i] = Light(vec4(d, size.x), vec4(normalize(u), size.y), vec4(normalize(v), cos_alpha), "
    "vec4(rgb * c, 0));\n"
    "}\n";

static GLuint program(const char *name, const char *first, const char *second, message *why)
{
    const char *const piece[] = {"#version 450 core\n", first, second};
    GLint done = 0;
    char log[160] = "";
    const GLuint shader = gl.CreateShader(GL_COMPUTE_SHADER), made = gl.CreateProgram();
    gl.ObjectLabel(GL_PROGRAM, made, -1, name);
    gl.ShaderSource(shader, 3, piece, NULL);
    gl.CompileShader(shader);
    gl.AttachShader(made, shader);
    gl.LinkProgram(made);
    gl.GetShaderInfoLog(shader, sizeof log, NULL, log);
    gl.DeleteShader(shader);
    gl.GetProgramiv(made, GL_LINK_STATUS, &done);
    if (done) return made;
    gl.DeleteProgram(made);
    return (void)fail(why, "%s: %s", name, log), 0u;
}

static GLuint texture(int side)
{
    GLuint t;
    gl.CreateTextures(GL_TEXTURE_2D_ARRAY, 1, &t);
    gl.TextureStorage3D(t, 1, GL_RGBA32F, side, side, 6);
    gl.TextureParameteri(t, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    return t;
}

enum {
    LIGHT_BYTES = MEDIAN_CUT_MOST * (int)sizeof(record),
    REGION_BYTES = 16 + 16 * MEDIAN_CUT_MOST
};

bool gl_median_cut_create(gl_median_cut *m, const lightprobe_cube *cube, message *why)
{
    const int side = cube->side;
    *m = (gl_median_cut){
        .side = side, .probe = texture(side), .table = {texture(side), texture(side)}};
    for (int face = 0; face < 6; face++) {
        gl.TextureSubImage3D(m->probe, 0, 0, 0, face, side, side, 1, GL_RGB, GL_FLOAT,
                             cube->face[face]);
    }
    gl.CreateBuffers(1, &m->regions);
    gl.CreateBuffers(1, &m->lights);
    gl.NamedBufferStorage(m->regions, REGION_BYTES, NULL, 0);
    gl.NamedBufferStorage(m->lights, LIGHT_BYTES, NULL, 0);
    m->rows = program("median cut, rows", "", rows_text, why);
    m->columns = program("median cut, columns", "", columns_text, why);
    m->cuts = program("median cut", tables_text, cuts_text, why);
    m->resolve = program("median cut, lights", tables_text, lights_text, why);
    if (m->rows && m->columns && m->cuts && m->resolve) return true;
    gl_median_cut_free(m);
    return false;
}

void gl_median_cut_free(gl_median_cut *m)
{
    const GLuint textures[3] = {m->probe, m->table[0], m->table[1]};
    const GLuint buffers[2] = {m->regions, m->lights};
    const GLuint programs[4] = {m->rows, m->columns, m->cuts, m->resolve};
    gl.DeleteTextures(3, textures);
    gl.DeleteBuffers(2, buffers);
    for (int i = 0; i < 4; i++)
        if (programs[i]) gl.DeleteProgram(programs[i]);
    *m = (gl_median_cut){0};
}

void gl_median_cut_sums(const gl_median_cut *m)
{
    const GLuint groups = (GLuint)m->side / 32;
    for (GLuint i = 0; i < 2; i++)
        gl.BindImageTexture(i, m->table[i], 0, GL_TRUE, 0, GL_READ_WRITE, GL_RGBA32F);
    gl.BindTextureUnit(0, m->probe);
    gl.UseProgram(m->rows);
    gl.DispatchCompute(groups, 6, 1);
    gl.MemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    gl.UseProgram(m->columns);
    gl.DispatchCompute(groups, 6, 1);
    gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

static void bind(const gl_median_cut *m)
{
    for (GLuint i = 0; i < 2; i++) gl.BindTextureUnit(i, m->table[i]);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, m->regions);
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, m->lights);
}

void gl_median_cut_cuts(const gl_median_cut *m, int most)
{
    bind(m);
    gl.ProgramUniform1i(m->cuts, gl.GetUniformLocation(m->cuts, "most"), most);
    gl.UseProgram(m->cuts);
    gl.DispatchCompute(1, 1, 1);
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void gl_median_cut_lights(const gl_median_cut *m, int most)
{
    bind(m);
    gl.UseProgram(m->resolve);
    gl.DispatchCompute((GLuint)(most + 63) / 64, 1, 1);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
}

int gl_median_cut_read(const gl_median_cut *m, lightprobe_light lights[MEDIAN_CUT_MOST])
{
    static record found[MEDIAN_CUT_MOST];
    GLuint count = 0;
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl.GetNamedBufferSubData(m->regions, 0, sizeof count, &count);
    gl.GetNamedBufferSubData(m->lights, 0, (GLsizeiptr)(count * sizeof *found), found);
    for (GLuint i = 0; i < count; i++) {
        const record *from = &found[i];
        lightprobe_light *to = &lights[i];
        memset(to, 0, sizeof *to);
        for (int k = 0; k < 3; k++) {
            to->direction[k] = from->direction[k];
            to->axis_u[k] = from->axis_u[k];
            to->axis_v[k] = from->axis_v[k];
            to->irradiance[k] = from->irradiance[k];
        }
        to->tan_half_u = from->tan_half_u;
        to->tan_half_v = from->tan_half_v;
        to->cos_alpha = from->cos_alpha;
    }
    return (int)count;
}
