#include "gl_convolution.h"

#include <stdio.h>

enum { BASIS_UNIT = 5, WEIGHTED_UNIT, MEAN_UNIT };

// What gl.h leaves out.
enum { R16F = 0x822D };

// Measured by coordinate descent: the least rms error of the default scene's picture under 16
// lights, against rays.
static const gl_convolution_tuning best[2][3] = {
    {{0, 0.038f, 1.56f, 0.067f, 0, 8.15f, 46.4f, 0},
     {0, 0.03f, 1.175f, 0.0615f, 0.124f, 9.6f, 86, 0},
     {0.07f, 0.015f, 1.5f, 0.12f, 0.89f, 20.7f, 155, 0}},
    {{0.0054f, 0.063f, 1.13f, 0.048f, 0.125f, 10.4f, 67.6f, 3.89f},
     {0.017f, 0.03f, 1.09f, 0.0865f, 0, 9.2f, 91.6f, 2.9f},
     {0.168f, 0.03f, 0.925f, 0.028f, 0, 5.3f, 95.4f, 2.85f}}};

gl_convolution_tuning gl_convolution_best(gl_convolution_filter filter, int terms)
{
    return best[filter == GL_CONVOLUTION_MIPS][terms <= 4 ? 0 : terms <= 8 ? 1 : 2];
}

// ---- Shaders

static const char common_text[] =
    "const float PI = 3.14159265;\n"
    "float phase(float z) { return MARGIN + (1 - 2 * MARGIN) * z; }\n"
    "vec2 wave(float angle) { return vec2(cos(angle), sin(angle)); }\n"
    "vec2 turn(vec2 a, vec2 b) { return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x); }\n";

// The finest level of mip maps, one thread a texel: terms 2i and 2i + 1 are layer i of a light. 8
// bits for the basis and 16 for the rest, as in the paper.
static const char texels_text[] =
    "layout(local_size_x = 8, local_size_y = 8) in;\n"
    "layout(binding = 0, rgba8) writeonly uniform image2DArray basis;\n"
    "layout(binding = 1, rgba16f) writeonly uniform image2DArray weighted;\n"
    "layout(binding = 2, r16f) writeonly uniform image2DArray mean;\n"
    "void main()\n"
    "{\n"
    "    ivec3 p = ivec3(gl_GlobalInvocationID);\n"
    "    float t = phase(texelFetch(depth_maps, p, 0).r);\n"
    "    vec2 now = wave(PI * t), step = wave(2 * PI * t);\n"
    "    imageStore(mean, p, vec4(t));\n"
    "    for (int i = 0; i < QUADS; i++) {\n"
    "        vec2 next = turn(now, step);\n"
    "        ivec3 q = ivec3(p.xy, QUADS * p.z + i);\n"
    "        imageStore(basis, q, 0.5 * vec4(now, next) + 0.5);\n"
    "        imageStore(weighted, q, t * vec4(now, next));\n"
    "        now = turn(next, step);\n"
    "    }\n"
    "}\n";

// Tables: first along columns, one thread a column, light and layer, from the depth map; then along
// rows, in place. Entry (x,y) is the sum of the texels left of and below it, so there is a first
// row and column of zeros.
static const char columns_text[] =
    "layout(local_size_x = 64) in;\n"
    "layout(binding = 0, rgba32f) writeonly uniform image2DArray basis;\n"
    "layout(binding = 1, rgba32f) writeonly uniform image2DArray weighted;\n"
    "layout(binding = 2, r32f) writeonly uniform image2DArray mean;\n"
    "void main()\n"
    "{\n"
    "    ivec3 p = ivec3(gl_GlobalInvocationID.x, 0, gl_GlobalInvocationID.z);\n"
    "    int i = int(gl_GlobalInvocationID.y), side = textureSize(depth_maps, 0).y;\n"
    "    ivec3 q = ivec3(p.x + 1, 0, QUADS * p.z + i);\n"
    "    vec4 sum = vec4(0), weighted_sum = vec4(0), mean_sum = vec4(0);\n"
    "    for (; p.y < side; p.y++) {\n"
    "        float t = phase(texelFetch(depth_maps, p, 0).r);\n"
    "        vec2 now = wave(PI * t * (4 * i + 1));\n"
    "        vec4 both = vec4(now, turn(now, wave(2 * PI * t)));\n"
    "        sum += both;\n"
    "        weighted_sum += t * both;\n"
    "        mean_sum += t;\n"
    "        q.y++;\n"
    "        imageStore(basis, q, sum);\n"
    "        imageStore(weighted, q, weighted_sum);\n"
    "        if (i == 0) imageStore(mean, ivec3(q.xy, p.z), mean_sum);\n"
    "    }\n"
    "}\n";

static const char rows_text[] =
    "layout(local_size_x = 64) in;\n"
    "layout(binding = 0, rgba32f) uniform image2DArray basis;\n"
    "layout(binding = 1, rgba32f) uniform image2DArray weighted;\n"
    "layout(binding = 2, r32f) uniform image2DArray mean;\n"
    "void main()\n"
    "{\n"
    "    int i = int(gl_GlobalInvocationID.y), light = int(gl_GlobalInvocationID.z);\n"
    "    ivec3 q = ivec3(0, gl_GlobalInvocationID.x + 1, QUADS * light + i);\n"
    "    int side = imageSize(basis).x;\n"
    "    vec4 sum = vec4(0), weighted_sum = vec4(0), mean_sum = vec4(0);\n"
    "    for (q.x = 1; q.x < side; q.x++) {\n"
    "        imageStore(basis, q, sum += imageLoad(basis, q));\n"
    "        imageStore(weighted, q, weighted_sum += imageLoad(weighted, q));\n"
    "        if (i > 0) continue;\n"
    "        ivec3 r = ivec3(q.xy, light);\n"
    "        imageStore(mean, r, mean_sum += imageLoad(mean, r));\n"
    "    }\n"
    "}\n";

static const char images_text[] = "layout(binding = 5) uniform sampler2DArray basis;\n"
                                  "layout(binding = 6) uniform sampler2DArray weighted;\n"
                                  "layout(binding = 7) uniform sampler2DArray mean;\n";

// A region of the map and the means in it: of mip maps, a square of the same area, read once;
static const char mips_text[] = "struct Region { vec2 at; float lod, inside; };\n"
                                "Region region(vec2 at, vec2 half_size)\n"
                                "{\n"
                                "    vec2 w = 2 * half_size * textureSize(basis, 0).xy;\n"
                                "    return Region(at, max(0.5 * log2(w.x * w.y) - FINER, 0), 1);\n"
                                "}\n"
                                "vec4 filtered(sampler2DArray images, Region r, int layer)\n"
                                "{\n"
                                "    return textureLod(images, vec3(r.at, layer), r.lod);\n"
                                "}\n"
                                "vec4 waves(Region r, int layer)\n"
                                "{\n"
                                "    return 2 * filtered(basis, r, layer) - 1;\n"
                                "}\n";

// of tables, the rectangle itself, from its corners, between which the sampler interpolates. The
// part of it beside the map sees light.
static const char tables_text[] =
    "struct Region { vec2 low, high; float scale, inside; };\n"
    "Region region(vec2 at, vec2 half_size)\n"
    "{\n"
    "    vec2 side = textureSize(basis, 0).xy;\n"
    "    vec2 low = clamp(at - half_size, 0, 1), high = clamp(at + half_size, 0, 1);\n"
    "    vec2 size = max(high - low, 1e-5), all = 2 * half_size;\n"
    "    float texels = size.x * size.y * (side.x - 1) * (side.y - 1);\n"
    "    float inside = size.x * size.y / (all.x * all.y);\n"
    "    low = (low * (side - 1) + 0.5) / side;\n"
    "    return Region(low, (high * (side - 1) + 0.5) / side, 1 / texels, inside);\n"
    "}\n"
    "vec4 filtered(sampler2DArray images, Region r, int layer)\n"
    "{\n"
    "    vec4 a = textureLod(images, vec3(r.low, layer), 0);\n"
    "    vec4 b = textureLod(images, vec3(r.high.x, r.low.y, layer), 0);\n"
    "    vec4 c = textureLod(images, vec3(r.low.x, r.high.y, layer), 0);\n"
    "    vec4 d = textureLod(images, vec3(r.high, layer), 0);\n"
    "    return ((d - c) - (b - a)) * r.scale;\n"
    "}\n"
    "vec4 waves(Region r, int layer) { return filtered(basis, r, layer); }\n";

// Visibility: Eq. 6 and 11 with one series above and below the line, then the kernel that the mean
// blocker asks for, and Eq. 9.
static const char shading_text[] =
    // The series for "nearer than the receiver" without its constant, of two terms: own are the
    // receiver's waves, b the filtered ones.
    "float series(vec2 weight, vec4 own, vec4 b)\n"
    "{\n"
    "    return dot(weight, own.yw * b.xz - own.xz * b.yw);\n"
    "}\n"
    "float mssm_visibility(int light, vec3 position)\n"
    "{\n"
    "    vec3 p = shadow_place(light, position);\n"
    "    vec2 kernel = reference[light].kernel.xy, least = 0.5 / textureSize(depth_maps, 0).xy;\n"
    "    float d = phase(clamp(0.5 * p.z + 0.5 - OFFSET, 0, 1));\n"
    "    vec2 first = wave(PI * d), step = wave(2 * PI * d);\n"
    "    vec4 own[QUADS];\n"
    "    for (int i = 0; i < QUADS; i++) {\n"
    "        own[i] = vec4(first, turn(first, step));\n"
    "        first = turn(own[i].zw, step);\n"
    "    }\n"
    "    Region r = region(p.xy, max(kernel * (p.z + 1), least));\n"
    "    float blocked = CONSTANT, depth = CONSTANT * filtered(mean, r, light).x;\n"
    "    for (int i = 0; i < QUADS; i++) {\n"
    "        blocked += series(weights[i], own[i], waves(r, QUADS * light + i));\n"
    "    }\n"
    "    if (blocked <= 1e-3) return 1;\n"
    "    for (int i = 0; i < QUADS; i++) {\n"
    "        depth += series(weights[i], own[i], filtered(weighted, r, QUADS * light + i));\n"
    "    }\n"
    "    float gap = clamp(d - depth / blocked, 0, d - MARGIN) / (1 - 2 * MARGIN);\n"
    "    r = region(p.xy, max(kernel * 2 * gap, least));\n"
    "    blocked = CONSTANT;\n"
    "    for (int i = 0; i < QUADS; i++) {\n"
    "        blocked += series(weights[i], own[i], waves(r, QUADS * light + i));\n"
    "    }\n"
    "    return pow(clamp(1 - blocked * r.inside, 0, 1), 1 + A * exp(-B * gap));\n"
    "}\n";

// ---- Making

// Numbers that shaders are compiled with.
static void write_constants(char *text, size_t room, int terms, const gl_convolution_tuning *set)
{
    int at = snprintf(text, room,
                      "#define QUADS %d\n#define MARGIN %.6f\n#define OFFSET %.6f\n"
                      "#define CONSTANT %.6f\n#define FINER %.6f\n#define A %.6f\n#define B %.6f\n"
                      "const vec2 weights[QUADS] = vec2[QUADS](",
                      terms / 2, (double)set->margin, (double)set->offset, 0.5 - (double)set->shift,
                      (double)set->finer, (double)set->a, (double)set->b);
    for (int k = 0; k < terms; k++) {
        const double share = (k + 1.0) / terms, order = 2 * k + 1;
        const double weight = (double)set->scale * 2 / (3.14159265 * order) *
                              exp(-(double)set->damping * share * share);
        at += snprintf(text + at, room - (size_t)at, "%s%.6f%s",
                       k % 2 ? ", "
                       : k   ? ", vec2("
                             : "vec2(",
                       weight, k % 2 ? ")" : "");
    }
    snprintf(text + at, room - (size_t)at, ");\n");
}

static GLuint compute_program(const char *name, const char *constants, const char *body,
                              message *why)
{
    const char *const piece[] = {"#version 450 core\n", constants, common_text, gl_reference_text,
                                 body};
    GLint done = 0;
    char log[160] = "";
    const GLuint shader = gl.CreateShader(GL_COMPUTE_SHADER), program = gl.CreateProgram();
    gl.ObjectLabel(GL_PROGRAM, program, -1, name);
    gl.ShaderSource(shader, sizeof piece / sizeof *piece, piece, NULL);
    gl.CompileShader(shader);
    gl.AttachShader(program, shader);
    gl.LinkProgram(program);
    gl.GetShaderInfoLog(shader, sizeof log, NULL, log);
    gl.DeleteShader(shader); // the program keeps it
    gl.GetProgramiv(program, GL_LINK_STATUS, &done);
    if (done) return program;
    gl.DeleteProgram(program);
    fail(why, "%s: %s", name, log);
    return 0;
}

static int levels_of(int side)
{
    int levels = 1;
    while (side >> levels) levels++;
    return levels;
}

static GLuint images(const gl_convolution *c, GLenum format, int layers)
{
    const bool mips = c->filter == GL_CONVOLUTION_MIPS;
    const int side = mips ? c->side : c->side + 1;
    GLuint t;
    gl.CreateTextures(GL_TEXTURE_2D_ARRAY, 1, &t);
    gl.TextureStorage3D(t, mips ? levels_of(side) : 1, format, side, side, layers);
    gl.TextureParameteri(t, GL_TEXTURE_MIN_FILTER, mips ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR);
    gl.TextureParameteri(t, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl.TextureParameteri(t, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    return t;
}

// A new texture holds anything: the first row and column of tables must be zeros.
static void clear(GLuint texture, int layers)
{
    const float zero[4] = {0};
    GLuint framebuffer;
    gl.CreateFramebuffers(1, &framebuffer);
    for (int i = 0; i < layers; i++) {
        gl.NamedFramebufferTextureLayer(framebuffer, GL_COLOR_ATTACHMENT0, texture, 0, i);
        gl.ClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, zero);
    }
    gl.DeleteFramebuffers(1, &framebuffer);
}

void gl_convolution_visibility(gl_convolution_filter filter, int terms,
                               const gl_convolution_tuning *tuning, char *text, size_t room)
{
    const gl_convolution_tuning set = tuning ? *tuning : gl_convolution_best(filter, terms);
    char constants[1024];
    write_constants(constants, sizeof constants, terms, &set);
    snprintf(text, room, "%s%s%s%s%s%s", constants, common_text, gl_reference_text, images_text,
             filter == GL_CONVOLUTION_MIPS ? mips_text : tables_text, shading_text);
}

static bool create_programs(gl_convolution *c, const gl_convolution_tuning *set, message *why)
{
    const bool mips = c->filter == GL_CONVOLUTION_MIPS;
    char constants[1024], text[GL_CONVOLUTION_TEXT];
    write_constants(constants, sizeof constants, c->terms, set);
    gl_convolution_visibility(c->filter, c->terms, set, text, sizeof text);
    c->program = gl_lighting_program("convolution soft shadows", text, false, why);
    c->update[0] =
        compute_program("basis images", constants, mips ? texels_text : columns_text, why);
    if (!mips) c->update[1] = compute_program("basis tables", constants, rows_text, why);
    return c->program && c->update[0] && (mips || c->update[1]);
}

bool gl_convolution_create(gl_convolution *c, gl_convolution_filter filter, int terms,
                           const gl_convolution_tuning *tuning, int side, int lights, message *why)
{
    const bool mips = filter == GL_CONVOLUTION_MIPS;
    const gl_convolution_tuning set = tuning ? *tuning : gl_convolution_best(filter, terms);
    const int layers = terms / 2 * lights;
    *c = (gl_convolution){.filter = filter, .side = side, .room = lights, .terms = terms};
    c->basis = images(c, mips ? GL_RGBA8 : GL_RGBA32F, layers);
    c->weighted = images(c, mips ? GL_RGBA16F : GL_RGBA32F, layers);
    c->mean = images(c, mips ? R16F : GL_R32F, lights);
    if (!mips) {
        clear(c->basis, layers);
        clear(c->weighted, layers);
        clear(c->mean, lights);
    }
    if (create_programs(c, &set, why)) return true;
    gl_convolution_free(c);
    return false;
}

void gl_convolution_free(gl_convolution *c)
{
    const GLuint textures[3] = {c->basis, c->weighted, c->mean};
    for (int i = 0; i < 3; i++) {
        if (textures[i]) gl.DeleteTextures(1, &textures[i]);
    }
    for (int i = 0; i < 2; i++) {
        if (c->update[i]) gl.DeleteProgram(c->update[i]);
    }
    if (c->program) gl.DeleteProgram(c->program);
    *c = (gl_convolution){0};
}

// ---- Frame

static void bind_images(const gl_convolution *c, GLenum access)
{
    const bool mips = c->filter == GL_CONVOLUTION_MIPS;
    gl.BindImageTexture(0, c->basis, 0, GL_TRUE, 0, access, mips ? GL_RGBA8 : GL_RGBA32F);
    gl.BindImageTexture(1, c->weighted, 0, GL_TRUE, 0, access, mips ? GL_RGBA16F : GL_RGBA32F);
    gl.BindImageTexture(2, c->mean, 0, GL_TRUE, 0, access, mips ? R16F : GL_R32F);
}

void gl_convolution_update(gl_convolution *c, const gl_reference *r, int lights)
{
    const GLbitfield barriers = GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT;
    const GLuint side = (GLuint)c->side, all = (GLuint)lights, quads = (GLuint)c->terms / 2;
    gl_reference_bind(r);
    gl.UseProgram(c->update[0]);
    if (c->filter == GL_CONVOLUTION_MIPS) {
        bind_images(c, GL_WRITE_ONLY);
        gl.DispatchCompute(side / 8, side / 8, all);
        gl.MemoryBarrier(barriers);
        gl.GenerateTextureMipmap(c->basis);
        gl.GenerateTextureMipmap(c->weighted);
        gl.GenerateTextureMipmap(c->mean);
        return;
    }
    bind_images(c, GL_READ_WRITE);
    gl.DispatchCompute(side / 64, quads, all);
    gl.MemoryBarrier(barriers);
    gl.UseProgram(c->update[1]);
    gl.DispatchCompute(side / 64, quads, all);
    gl.MemoryBarrier(barriers);
}

void gl_convolution_bind(const gl_convolution *c)
{
    gl.BindTextureUnit(BASIS_UNIT, c->basis);
    gl.BindTextureUnit(WEIGHTED_UNIT, c->weighted);
    gl.BindTextureUnit(MEAN_UNIT, c->mean);
}
